// Curves over time beside the scene: axes, ticks, units, a cursor with its values; dragging on one scrubs.

const RAISED = {"-": "\u207b", ...Object.fromEntries([..."\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079"].map((c, i) => [i, c]))};
const DASHES = [[], [7, 3], [2, 2.5], [8, 3, 2, 3]];

function element(tag, properties = {}, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

// Round values between low and high, about `count` of them, and never one alone: it tells no scale.
function ticks(low, high, count) {
  const rough = (high - low) / count, decade = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((factor) => factor * decade).find((s) => s >= rough * 0.999);
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(k * step);
  return found.length > 1 || count > 9 ? {found, step} : ticks(low, high, count + 1);
}

// A printed number as it is set: a true minus, its power of ten raised, groups of three digits where there are five.
function numeral(text) {
  const [mantissa, power] = text.split("e"), [whole, rest] = mantissa.split(".");
  const grouped = whole.length - whole.startsWith("-") > 4 ? whole.replace(/\B(?=(\d{3})+$)/g, "\u202f") : whole;
  const raised = power && [...String(Number(power))].map((c) => RAISED[c]).join("");
  const printed = rest === undefined ? grouped : `${grouped}.${rest}`;
  const factor = {1: "", "-1": "-"}[mantissa] ?? `${printed} \u00b7 `;
  return (raised ? `${factor}10${raised}` : printed).replace("-", "\u2212");
}

// As many digits as the step needs; powers of ten only for long numbers that they make shorter.
function tickText(value, step) {
  if (Math.abs(value) < 1e-9 * step) return "0";
  const decade = (x) => Math.floor(Math.log10(Math.abs(x)) + 1e-9);
  const plain = value.toFixed(Math.min(Math.max(0, -decade(step)), 100));
  const power = value.toExponential(Math.max(0, decade(value) - decade(step)));
  return numeral(plain.length < 8 || plain.length <= power.length ? plain : power);
}

// Four digits; what is rounding in the scale of its picture is zero.
function valueText(value, scale = 0) {
  if (!Number.isFinite(value)) return "\u2013";
  const size = Math.abs(value) <= 1e-9 * scale ? 0 : Math.abs(value);
  if (size === 0) return "0";
  const rounded = Number(value.toPrecision(4)); // no zeros at the end: 10^-3, not 1.000 10^-3
  return numeral(size >= 1e-3 && size < 1e6 ? rounded.toString() : rounded.toExponential());
}

const BOX = {left: 56, right: 12, top: 6, bottom: 20}; // room for numbers around a plot; on the left at least
const FONT = "11px system-ui, sans-serif";
const letters = element("canvas").getContext("2d"); // measures them

const ink = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

// Title, names with marks and values, and a canvas; `stroke` sets the line of number i.
function makeFigure(label, unit, names, colours, hint) {
  const canvas = element("canvas", {className: "plot"});
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", `${label}${unit ? ` in ${unit}` : ""} over time${hint}`);
  const values = [], legend = element("ul", {className: "key"});
  for (const name of names) {
    const value = element("output", {className: "value"});
    values.push(value);
    legend.append(element("li", {}, element("canvas", {className: "mark", width: 44, height: 10}), element("span", {textContent: name}), value));
  }
  const title = element("b", {textContent: label + (unit ? ` [${unit}]` : "")});
  const figure = element("figure", {}, element("figcaption", {}, title, legend), canvas);
  const stroke = (g, i, wide) => {
    (g.strokeStyle = colours[i % colours.length]), (g.lineWidth = wide);
    g.setLineDash(DASHES[Math.floor(i / colours.length) % DASHES.length]);
  };
  const marks = () => legend.querySelectorAll("canvas").forEach((mark, i) => {
    const m = mark.getContext("2d");
    m.clearRect(0, 0, 44, 10), stroke(m, i, 4), m.beginPath(), m.moveTo(0, 5), m.lineTo(44, 5), m.stroke();
  });
  return {figure, canvas, values, stroke, marks};
}

// A canvas as sharp as the screen; its context draws in units of the page.
function sharp(canvas, width, height) {
  const ratio = window.devicePixelRatio || 1, g = canvas.getContext("2d");
  (canvas.width = Math.round(width * ratio)), (canvas.height = Math.round(height * ratio));
  g.setTransform(ratio, 0, 0, ratio, 0, 0);
  return g;
}

// Where values low ... high and times first ... last lie on a canvas of the given size, and the lines and numbers there.
function makeAxes(width, height, low, high, first, last) {
  const up = ticks(low, high, Math.max(3, Math.floor((height - BOX.top - BOX.bottom) / 30)));
  const numbers = up.found.map((v) => tickText(v, up.step));
  letters.font = FONT;
  const left = Math.max(BOX.left, ...numbers.map((text) => 8 + letters.measureText(text).width));
  const x = (t) => left + ((t - first) / (last - first || 1)) * (width - left - BOX.right);
  const y = (v) => BOX.top + ((high - v) / (high - low)) * (height - BOX.top - BOX.bottom);
  function draw(g) {
    g.font = FONT;
    (g.fillStyle = ink("--muted")), (g.strokeStyle = ink("--line")), (g.lineWidth = 1), g.setLineDash([]);
    const along = ticks(first, last, Math.max(2, Math.floor(width / 80)));
    (g.textAlign = "right"), (g.textBaseline = "middle");
    up.found.forEach((v, i) => {
      const at = Math.round(y(v)) + 0.5;
      g.beginPath(), g.moveTo(left, at), g.lineTo(width - BOX.right, at), g.stroke();
      g.fillText(numbers[i], left - 6, at);
    });
    (g.textAlign = "center"), (g.textBaseline = "top");
    for (const t of along.found) {
      const at = Math.round(x(t)) + 0.5, text = tickText(t, along.step);
      g.beginPath(), g.moveTo(at, height - BOX.bottom), g.lineTo(at, height - BOX.bottom + 4), g.stroke();
      const room = g.measureText(text + " s").width / 2;
      g.fillText(t === along.found[along.found.length - 1] ? `${text} s` : text, Math.min(at, width - room - 1), height - BOX.bottom + 6);
    }
  }
  return {x, y, left, draw};
}

// `scale`: what this unit amounts to on the page and in the run; what is 1e-9 of it is rounding and not blown up.
// `index`: its place among the curves of the page.
function makeCurve(curve, lines, times, colours, scale, seek, index) {
  const {figure, canvas, values, stroke, marks} = makeFigure(curve.label, curve.unit, curve.lines.map((line) => line.name), colours, "; drag to scrub");
  let low = Infinity, high = -Infinity;
  for (const v of lines.flatMap((line) => Array.from(line.values))) {
    if (Number.isFinite(v)) (low = Math.min(low, v)), (high = Math.max(high, v));
  }
  if (low > high) (low = -1), (high = 1);
  if (high - low <= 1e-9 * scale || high === low) {
    const size = Math.max(Math.abs(low), Math.abs(high)), room = size > 1e-6 * scale ? 0.05 * size : 1; // nothing: -1 to 1
    (low -= room), (high += room);
  }
  const air = 0.06 * (high - low);
  (low -= air), (high += air);
  const first = times.first, last = times.first + times.step * (times.count - 1);
  const drawn = element("canvas"); // axes and lines, onto which cursor and values come
  let axes = null, lit = -1; // null = to be drawn anew; line that stands out, -1 = all alike, -2 = none
  figure.dataset.curve = index;

  function background() {
    const width = canvas.clientWidth, height = canvas.clientHeight, g = sharp(drawn, width, height);
    sharp(canvas, width, height);
    axes = makeAxes(width, height, low, high, first, last);
    axes.draw(g);
    lines.forEach((line, i) => {
      stroke(g, i, lit === i ? 4 : 1.75);
      g.globalAlpha = lit === -1 || lit === i ? 1 : 0.25;
      g.beginPath();
      let pen = false;
      line.values.forEach((v, k) => {
        if (Number.isFinite(v)) g[pen ? "lineTo" : "moveTo"](axes.x(first + k * times.step), axes.y(v));
        pen = Number.isFinite(v);
      });
      g.stroke();
    });
    g.globalAlpha = 1;
    marks();
  }

  function draw(place) {
    if (!canvas.clientWidth) return;
    if (axes === null) background();
    const g = canvas.getContext("2d"), at = axes.x(first + place * times.step);
    g.clearRect(0, 0, canvas.clientWidth, canvas.clientHeight);
    g.drawImage(drawn, 0, 0, canvas.clientWidth, canvas.clientHeight);
    (g.strokeStyle = ink("--ink")), (g.lineWidth = 1), g.setLineDash([]);
    g.beginPath(), g.moveTo(at, BOX.top), g.lineTo(at, canvas.clientHeight - BOX.bottom), g.stroke();
    lines.forEach((line, i) => {
      const v = rowAt(line, place)[0];
      values[i].textContent = valueText(v, scale);
      if (!Number.isFinite(v)) return;
      (g.fillStyle = colours[i % colours.length]), (g.strokeStyle = ink("--paper")), (g.lineWidth = 1.5);
      g.beginPath(), g.arc(at, axes.y(v), 4, 0, 7), g.fill(), g.stroke();
    });
  }

  const pick = (event) => {
    const share = (event.offsetX - axes.left) / (canvas.clientWidth - axes.left - BOX.right);
    seek(first + Math.min(Math.max(share, 0), 1) * (last - first));
  };
  canvas.addEventListener("pointerdown", (event) => (canvas.setPointerCapture(event.pointerId), pick(event)));
  canvas.addEventListener("pointermove", (event) => event.buttons & 1 && pick(event));
  const at = (place) => lines.map((line) => rowAt(line, place)[0]);
  const light = (line) => line !== lit && ((lit = line), (axes = null));
  return {figure, draw, at, light, index, resize: () => (axes = null)};
}
