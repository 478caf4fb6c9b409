// The 3D scene: viser's client draws it, this moves it by the messages a server would send.

function makeScene(data, arrays) {
  let viewer = null, followed = -1; // the body the camera goes along with,
  let seen = null, faced = 0, turning = false; // where it was last and where it headed, and whether the camera turns with it
  const tell = (type, name, content) => viewer.messageQueue.push({type, name, owner: "", ...content});
  const moving = data.moving; // numbers of the bodies that move at all

  // Resolves when the last node is there; false where the client's hook is missing.
  async function ready(seconds) {
    const end = performance.now() + 1000 * seconds;
    while (performance.now() < end) {
      viewer = window.__viserMutable;
      if (viewer && viewer.cameraControl && viewer.nodeRefFromName["/ready"]) return true;
      await new Promise((done) => setTimeout(done, 50));
    }
    viewer = null;
    return false;
  }

  // Copies of a body of length 1 along z, laid along vectors from points: as wide as long, or of given radii; they turn
  // from directions `rest` by the smallest rotation, so that coils do not spin (`laid` of mbsd3d/view/scene/meshes.py).
  function lay(name, points, vectors, factor, radii, rest) {
    const count = points.length / 3;
    const positions = new Float32Array(3 * count), turns = new Float32Array(4 * count), scales = new Float32Array(3 * count);
    for (let i = 0; i < count; i++) {
      const v = vectors.subarray(3 * i, 3 * i + 3), length = Math.hypot(...v) || 0;
      const first = rest ? rest[i] : Z, way = length > 0 ? Array.from(v, (x) => x / length) : Z;
      for (let k = 0; k < 3; k++) positions[3 * i + k] = points[3 * i + k] * data.scale;
      turns.set(product(smallestTurn(first, way), smallestTurn(Z, first)), 4 * i);
      const long = length * factor * data.scale, wide = radii ? radii[i] * data.scale : long;
      scales.set([wide + 1e-9, wide + 1e-9, long + 1e-9], 3 * i);
    }
    const updates = {batched_positions: positions, batched_wxyzs: turns, batched_scales: scales};
    tell("SceneNodeUpdateMessage", name, {updates});
  }

  // Ends of the tangent of two circles about `start` and `end` (`Link.placed` of mbsd3d/view/scene/drawing.py).
  function tangent(start, end, [body, axis, first, second], r, e) {
    const o = pointOf(r, e, body, [0, 0, 0]), n = pointOf(r, e, body, axis).map((x, k) => x - o[k]);
    const gap = end.map((x, k) => x - start[k]), off = n.reduce((sum, x, k) => sum + x * gap[k], 0);
    const flat = gap.map((x, k) => x - off * n[k]), d = Math.hypot(...flat);
    const sine = Math.min(Math.max((first - second) / d, -1), 1), cosine = Math.sqrt(1 - sine * sine);
    const across = cross(n, flat);
    const side = flat.map((f, k) => (sine * f - cosine * across[k]) / d);
    return [start.map((x, k) => x + first * side[k]), end.map((x, k) => x + second * side[k])];
  }

  function moveLinks({node, ends, rounds, radii, rest}, r, e) {
    const starts = new Float64Array(3 * ends.length), vectors = new Float64Array(starts.length);
    ends.forEach(([[a, p], [b, q]], i) => {
      let start = pointOf(r, e, a, p), end = pointOf(r, e, b, q);
      if (rounds[i]) [start, end] = tangent(start, end, rounds[i], r, e);
      for (let k = 0; k < 3; k++) (starts[3 * i + k] = start[k]), (vectors[3 * i + k] = end[k] - start[k]);
    });
    lay(node, starts, vectors, 1, radii, rest);
  }

  // Traces grow by drawing only their first segments.
  function growTraces(place) {
    for (const name of data.traces) {
      viewer.nodeRefFromName[name]?.traverse((part) => {
        if (part.geometry?.isInstancedBufferGeometry) part.geometry.instanceCount = Math.max(Math.ceil(place), 0);
      });
    }
  }

  // Other paths of the traces, each a list of points.
  function retrace(paths) {
    const shapes = {};
    data.traces.forEach((name, i) => {
      const points = (paths[i] ?? []).slice(1).flatMap((point, k) => [...paths[i][k], ...point]).map((x) => x * data.scale);
      if (points.length) for (const node of [name, name.replace("/passed", "/path")]) shapes[node] = {points};
    });
    if (viewer) reshape(shapes);
  }

  // Pale bodies of another motion, known up to some frame.
  let pale = null, paleCount = 0, paleShown = false;
  const ghost = (made, count) => ((pale = made), (paleCount = count));
  function moveGhost(place) {
    const on = pale !== null && place <= paleCount - 1;
    if (on !== paleShown) for (const i of moving) tell("SetSceneNodeVisibilityMessage", `/ghosts/${i}`, {visible: on});
    paleShown = on;
    if (on) moveBodies("/ghosts", rowAt(pale.r, place), quaternionsAt(pale.e, place));
  }

  // True if the client took the last messages, so that slow machines are not flooded.
  const idle = () => viewer !== null && viewer.messageQueue.length === 0;

  // Bodies, links and camera to a pose.
  function moveBodies(kind, r, e) {
    for (const i of moving) {
      const name = `${kind}/${i}`;
      tell("SetPositionMessage", name, {position: Array.from(r.subarray(3 * i, 3 * i + 3), (x) => x * data.scale)});
      tell("SetOrientationMessage", name, {wxyz: Array.from(e.subarray(4 * i, 4 * i + 4))});
    }
  }
  function put(r, e) {
    moveBodies("/bodies", r, e);
    for (const links of data.links) moveLinks(links, r, e);
    if (followed >= 0) goAlong(r, e);
    viewer.requestRender();
  }

  // Everything to a place between the frames.
  function move(place, shown) {
    put(rowAt(arrays.r, place), quaternionsAt(arrays.e, place));
    data.arrows.forEach((kind, i) => {
      const {points, vectors} = arrays.arrows[i];
      if (shown[kind.kind]) lay(kind.node, rowAt(points, place), rowAt(vectors, place), kind.factor);
    });
    growTraces(place), moveGhost(place);
  }

  // The camera is shifted by what the followed body has moved, and turned by what it has if asked to.
  function goAlong(r, e) {
    const control = viewer.cameraControl, there = placeIn(r), way = headingIn(e);
    if (seen !== null) {
      const turn = turning ? Math.atan2(Math.sin(way - faced), Math.cos(way - faced)) : 0;
      const {x, y, z} = control.getTarget(there.clone()).sub(seen), c = Math.cos(turn), s = Math.sin(turn);
      control.moveTo(there.x + c * x + s * z, there.y + y, there.z + c * z - s * x, false);
      if (turn) control.rotate(turn, 0, false);
    }
    (seen = there), (faced = way);
  }

  // About the vertical, of the x axis of the followed body.
  function headingIn(e) {
    const [w, x, y, z] = e.subarray(4 * followed, 4 * followed + 4);
    return Math.atan2(2 * (x * y + w * z), 1 - 2 * (y * y + z * z));
  }

  // Of the followed body, in the client's own axes: y is up.
  function placeIn(r) {
    const frame = viewer.nodeRefFromName["/bodies"] ?? viewer.nodeRefFromName[""];
    const place = Array.from(r.subarray(3 * followed, 3 * followed + 3), (x) => x * data.scale);
    return frame.localToWorld(viewer.camera.position.clone().fromArray(place));
  }

  // The ground grid goes along, by whole squares, with a place (x, y); its own one is at (0, 0).
  function carryGround([x, y], {ground, cell}) {
    const whole = [x, y].map((v, k) => ground[k] + cell * Math.round(v / cell));
    tell("SetPositionMessage", "/grid", {position: [...whole, ground[2]].map((v) => v * data.scale)});
  }

  const follow = (body) => ((followed = body), (seen = null));
  const turnAlong = (on) => (turning = on);

  // Other points of lines, other corners of meshes: the bodies have other shapes now.
  function reshape(shapes) {
    for (const [name, shape] of Object.entries(shapes)) {
      const updates = {};
      for (const [key, numbers] of Object.entries(shape)) updates[key] = (key === "faces" ? Uint32Array : Float32Array).from(numbers);
      tell("SceneNodeUpdateMessage", name, {updates});
    }
    viewer.requestRender();
  }

  function show(nodes, visible) {
    if (viewer === null) return;
    for (const name of nodes) tell("SetSceneNodeVisibilityMessage", name, {visible});
    viewer.requestRender();
  }

  // Arrows and marks inside bodies are seen through them.
  function seeThrough(on) {
    if (viewer === null) return;
    for (const name of data.solids) tell("SceneNodeUpdateMessage", name, {updates: {opacity: on ? 0.4 : null}});
    viewer.requestRender();
  }

  // On dark paper the grid stands back too.
  function darken() {
    const [cell_color, section_color] = data.darkCells;
    tell("SceneNodeUpdateMessage", "/grid", {updates: {cell_color, section_color}});
  }

  // The first view, as near as the shape of the window lets it. One that goes along is that of the first frame.
  function resetCamera() {
    if (viewer === null) return;
    const near = data.followed >= 0 && followed >= 0;
    viewer.resetCameraPose(false), (seen = near ? placeIn(rowAt(arrays.r, 0)) : null), (faced = near ? headingIn(rowAt(arrays.e, 0)) : 0);
    const box = document.getElementById("scene").getBoundingClientRect();
    const [depth, across, up] = data.sight, distance = depth + Math.max((across * box.height) / Math.max(box.width, 1), up);
    viewer.cameraControl.dollyTo(distance * data.scale, false);
    viewer.requestRender();
  }

  return {ready, put, carryGround, move, idle, show, seeThrough, darken, follow, turnAlong, reshape, retrace, ghost, resetCamera};
}
