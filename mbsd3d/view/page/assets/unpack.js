// Packed arrays (mbsd3d/view/content.py) and what lies between two frames.

async function inflate(text) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Values (frames, ...) as one Float64Array, frame by frame; steps are summed up twice in 32-bit integers.
async function unpack(packed) {
  const raw = await inflate(packed.data), size = raw.length / 4;
  const frames = packed.shape[0], width = size / frames;
  const values = new Float64Array(size);
  for (let row = 0; row < width; row++) {
    let slope = 0, value = 0;
    for (let frame = 0; frame < frames; frame++) {
      const i = row * frames + frame;
      const zigzag = raw[i] | (raw[size + i] << 8) | (raw[2 * size + i] << 16) | (raw[3 * size + i] << 24);
      slope = (slope + ((zigzag >>> 1) ^ -(zigzag & 1))) | 0;
      value = (value + slope) | 0;
      values[frame * width + row] = value === -2147483648 ? NaN : value * packed.step;
    }
  }
  return {values, width, frames};
}

// The row of an array at a place between frames, e.g. 3.25.
function rowAt(array, place) {
  const {values, width, frames} = array;
  const k = Math.min(Math.floor(place), frames - 1), next = Math.min(k + 1, frames - 1), share = place - k;
  const row = new Float64Array(width);
  for (let i = 0; i < width; i++) {
    const a = values[k * width + i], b = values[next * width + i];
    row[i] = share === 0 ? a : a + share * (b - a);
  }
  return row;
}

// Quaternions of a row, brought back to length 1: neighbours are on one sheet, so this is the shorter way.
function quaternionsAt(array, place) {
  const row = rowAt(array, place);
  for (let i = 0; i < row.length; i += 4) {
    const norm = Math.hypot(row[i], row[i + 1], row[i + 2], row[i + 3]);
    for (let k = i; k < i + 4; k++) row[k] /= norm;
  }
  return row;
}

// R(e) p + r of body `i`.
function pointOf(r, e, i, p) {
  const [w, x, y, z] = e.subarray(4 * i, 4 * i + 4);
  const s = [2 * (y * p[2] - z * p[1]), 2 * (z * p[0] - x * p[2]), 2 * (x * p[1] - y * p[0])];
  return [
    r[3 * i] + p[0] + w * s[0] + y * s[2] - z * s[1],
    r[3 * i + 1] + p[1] + w * s[1] + z * s[0] - x * s[2],
    r[3 * i + 2] + p[2] + w * s[2] + x * s[1] - y * s[0],
  ];
}

const Z = [0, 0, 1];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

// Unit quaternion of the smallest rotation of unit vector a to b; half a turn about any normal if b = -a.
function smallestTurn(a, b) {
  const e = [1 + a[0] * b[0] + a[1] * b[1] + a[2] * b[2], ...cross(a, b)], norm = Math.hypot(...e);
  if (norm > 1e-7) return e.map((x) => x / norm);
  const normal = cross(a, Math.abs(a[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0]), size = Math.hypot(...normal);
  return [0, ...normal.map((x) => x / size)];
}

function product(p, q) {
  const [x, y, z] = cross(p.slice(1), q.slice(1));
  return [
    p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
    p[0] * q[1] + q[0] * p[1] + x, p[0] * q[2] + q[0] * p[2] + y, p[0] * q[3] + q[0] * p[3] + z,
  ];
}
