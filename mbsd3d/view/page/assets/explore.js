// Sliders, switches of terms and a ghost: the page solves its mechanism again and shows nothing that is not of it.
// Solved frames come in slices; later ones are not shown before they are there.

const TERM_TEXTS = {gyroscopic: "gyroscopic term w \u00d7 I w", centripetal: "centripetal term m w \u00d7 (w \u00d7 s)", gamma: "right side \u03b3 of the joints"};
const ROUNDING = 1e-12; // [1] of the first value: a sum of polynomials that is less is 0

// Chebyshev polynomials of a place from -1 to 1, and the sums of their products (`view/explore/sliders.py`).
const placeOn = ({low, high, logarithmic}, value) => {
  const [a, b, x] = logarithmic ? [low, high, value].map(Math.log) : [low, high, value];
  return (2 * x - a - b) / (b - a);
};
const valueOn = ({low, high, logarithmic}, x) =>
  logarithmic ? Math.sqrt(low * high) * Math.sqrt(high / low) ** x : 0.5 * (low + high) + 0.5 * (high - low) * x;
function polynomialsAt(sliders, values) {
  return sliders.map((slider, k) => {
    const x = placeOn(slider, values[k]), found = [1, x];
    for (let i = 2; i <= 32; i++) found.push(2 * x * found[i - 1] - found[i - 2]);
    return found;
  });
}
function sumOf(terms, polynomials) {
  const count = polynomials.length;
  let sum = 0;
  for (let i = 0; i < terms.length; i += count + 1) {
    let x = terms[i + count];
    for (let k = 0; k < count; k++) x *= polynomials[k][terms[i + k]];
    sum += x;
  }
  return sum;
}
// Tables of the mechanism at values of the sliders.
function tablesAt({tables, varying}, sliders, values) {
  const made = structuredClone(tables), polynomials = polynomialsAt(sliders, values);
  for (const {path, terms} of varying) {
    const keys = path.split("."), last = keys.pop(), owner = keys.reduce((item, key) => item[key], made);
    owner[last] = sumOf(terms, polynomials);
  }
  return made;
}

// Numbers of a solved moment: of bodies, hinges, energies, reactions (`view/explore/exploration.py`).
function makeReader(solver, tables, {joints, com}) {
  const {bodies, lam, J, last} = solver, n = tables.body.length;
  const add = (a, b) => a.map((x, k) => x + b[k]);
  const turned = ({R}, p) => [0, 3, 6].map((k) => R[k] * p[0] + R[k + 1] * p[1] + R[k + 2] * p[2]);
  const momentum = (i) => turned(bodies[i], [0, 3, 6].map((k) => tables.body[i].inertia.slice(k, k + 3).reduce((sum, x, j) => sum + x * bodies[i].own[j], 0)));
  function wrench({rows, body, on, point}) {
    const force = [0, 0, 0], moment = [0, 0, 0];
    for (let k = rows[0]; k < rows[1]; k++) tables.row[k].body.forEach((on, slot) => {
      if (on !== body) return;
      for (let j = 0; j < 3; j++) (force[j] -= J[24 * k + 6 * slot + j] * lam[k]), (moment[j] -= J[24 * k + 6 * slot + 3 + j] * lam[k]);
    });
    const place = add(bodies[on].r, turned(bodies[on], point)), about = cross(place.map((x, j) => x - bodies[body].r[j]), force);
    return {force, moment: moment.map((x, j) => x - about[j]), point: place};
  }
  const ofBody = {
    position: ({r}) => r, velocity: ({v}) => v, omega: ({w}) => w, omega_body: ({own}) => own, orientation: ({e}) => e,
    com: (body, i) => add(body.r, turned(body, com[i])),
  };
  const energies = {
    kinetic: () => solver.kinetic(), potential: () => solver.stored, total: () => solver.kinetic() + solver.stored, work: (y) => y[13 * n],
  };
  const size = (v, axis) => (axis < 0 ? Math.hypot(...v) : v[axis]);
  function read(reading, y) {
    const {of, axis} = reading;
    if (of === "coordinate") return last[reading.coordinate].value;
    if (of === "rate") return last[reading.coordinate].rate;
    if (of === "push") return size(solver.pushes[reading.force], axis);
    if (of === "effort") return -lam[reading.row];
    if (of === "energy") return energies[reading.part](y);
    if (of === "force" || of === "moment") return size(wrench(joints[reading.joint])[of], axis);
    return ofBody[of](bodies[reading.body], reading.body)[axis];
  }
  // Point and vector of an arrow.
  function arrow(kind, i) {
    if (kind.startsWith("reaction")) {
      const found = wrench(joints[i]);
      return [found.point, found[kind.slice(9)]];
    }
    return [ofBody.com(bodies[i], i), kind === "angular velocity" ? bodies[i].w : momentum(i)];
  }
  return {read, arrow};
}

const emptyArray = (frames, width) => ({values: new Float64Array(frames * width).fill(NaN), width, frames});

// One run in the page: arrays like those of the recorded motion, filled frame by frame.
function solveMotion(tables, what, arrows, frames) {
  const n = tables.body.length, solver = makeSolver(tables, what.method), reader = makeReader(solver, tables, what);
  const made = {
    r: emptyArray(frames.length, 3 * (n + 1)), e: emptyArray(frames.length, 4 * (n + 1)),
    arrows: arrows.map((items) => items && {points: emptyArray(frames.length, 3 * items.names.length), vectors: emptyArray(frames.length, 3 * items.names.length)}),
    lines: what.curves.map((lines) => lines.every(Boolean) ? lines.map(() => emptyArray(frames.length, 1)) : null),
  };
  let run = null;
  function seen(k) {
    const {r, e} = made, y = run?.y ?? new Float64Array(solver.size);
    for (let i = 0; i <= n; i++) {
      const body = solver.bodies[i], o = 4 * (n + 1) * k + 4 * i, before = o - 4 * (n + 1);
      for (let j = 0; j < 3; j++) r.values[3 * (n + 1) * k + 3 * i + j] = body.r[j] - (i < n ? what.origin[j] : 0);
      const sheet = k > 0 && body.e.reduce((sum, x, j) => sum + x * e.values[before + j], 0) < 0 ? -1 : 1;
      body.e.forEach((x, j) => (e.values[o + j] = sheet * x));
    }
    arrows.forEach((items, a) => items?.names.forEach((which, i) => {
      const [point, vector] = reader.arrow(items.kind, which), o = 3 * items.names.length * k + 3 * i;
      made.arrows[a].points.values.set(point.map((x, j) => x - what.origin[j]), o), made.arrows[a].vectors.values.set(vector, o);
    }));
    made.lines.forEach((lines, c) => lines?.forEach((line, i) => (line.values[k] = reader.read(what.curves[c][i], y))));
  }
  run = solver.start(frames, seen);
  return {made, run};
}

// Paths of points through a motion, in the axes of the body from which they are seen.
function pathOf({body, point, base}, {r, e}, count, origin) {
  const n = r.width / 3 - 1, path = [];
  for (let k = 0; k < count; k++) {
    const poses = [r.values.subarray(k * r.width, (k + 1) * r.width), e.values.subarray(k * e.width, (k + 1) * e.width)];
    const place = pointOf(...poses, body, point), o = pointOf(...poses, base, [0, 0, 0]);
    if (base === n) path.push(place);
    else path.push([[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((unit) => {
      const axis = pointOf(...poses, base, unit);
      return axis.reduce((sum, x, j) => sum + (x - o[j]) * (place[j] - o[j]), 0);
    }));
  }
  return path;
}

// What a number of theory is compared with: read from the curves that were solved.
function foundIn(lines, {of, curve, line}, frames) {
  const values = lines[curve]?.[line]?.values;
  if (!values) return NaN;
  if (of === "last") return values[values.length - 1];
  const zeros = [], dt = frames[1] - frames[0];
  const x = of === "crossings" ? values : values.slice(2).map((v, k) => (v - values[k]) / (2 * dt)), shift = of === "crossings" ? 0 : 1;
  for (let k = 1; k + 2 < x.length; k++) if (x[k] * x[k + 1] < 0) {
    let low = 0, high = 1; // a cubic through four samples, halved
    const at = (s) => x[k - 1] * (-s * (s - 1) * (s - 2)) / 6 + x[k] * ((s + 1) * (s - 1) * (s - 2)) / 2 - x[k + 1] * ((s + 1) * s * (s - 2)) / 2 + x[k + 2] * ((s + 1) * s * (s - 1)) / 6;
    for (let turn = 0; turn < 50; turn++) { const middle = (low + high) / 2; if (at(middle) * x[k] > 0) low = middle; else high = middle; }
    zeros.push(frames[k + shift] + low * dt);
  }
  if (of === "turning") return zeros.length ? zeros[0] - frames[0] : NaN;
  return zeros.length > 1 ? (zeros[zeros.length - 1] - zeros[0]) / (zeros.length - 1) : Infinity;
}

// The controls, and what they change. `page`: what the player does with a motion that is shown.
function makeExplorer(what, recorded, page) {
  const frames = Array.from({length: times.count}, (_, k) => (k === times.count - 1 ? last : times.first + k * times.step));
  const values = what.sliders.map(({start}) => start), omitted = new Set();
  const outputs = [], inputs = [], switches = [];
  let main = null, ghost = null, ghostOn = false, renewed = 0, turn = 0, drawn = values.join();
  const apart = () => omitted.size > 0 || what.sliders.some(({start}, k) => values[k] !== start);
  const arrows = data.arrows.map(({kind}, a) => what.arrows[a] && {kind, names: what.arrows[a]});
  const termsOf = (names) => Object.fromEntries([...names].map((name) => [name, false]));

  function solve() {
    const away = apart();
    document.documentElement.dataset.solved = away ? "running" : "no";
    what.sliders.forEach(({label, unit}, k) => {
      outputs[k].textContent = `${valueText(values[k])} ${unit}`.trim();
      inputs[k].setAttribute("aria-valuetext", outputs[k].textContent), (inputs[k].value = placeOn(what.sliders[k], values[k]));
    });
    switches.forEach(([name, tick]) => (tick.checked = !omitted.has(name)));
    reshape();
    main = away ? solveMotion({...tablesAt(what, what.sliders, values), terms: termsOf(omitted)}, what, arrows, frames) : null;
    solveGhost();
    page.show(main ? main.made : recorded, !away), page.known(main ? 0 : Infinity);
    parent !== window && parent.postMessage({solved: away}, "*");
    advance(20), renew(), goOn();
  }
  // Corners of meshes, points of lines, ends of springs and rods at these values, if they are others than before.
  function reshape() {
    if (!what.shapes.length || drawn === values.join()) return;
    const polynomials = polynomialsAt(what.sliders, values), shapes = {};
    for (const {node, key, unit, terms} of what.shapes) {
      const found = new Float64Array(terms[0][1].length);
      for (const [degrees, numbers] of terms) {
        const factor = degrees.reduce((product, degree, k) => product * polynomials[k][degree], unit);
        for (let i = 0; i < found.length; i++) found[i] += factor * numbers[i];
      }
      if (key === "ends") data.links[node[0]].ends[node[1]].forEach((end, side) => (end[1] = Array.from(found.subarray(3 * side, 3 * side + 3))));
      else shapes[node] = {[key]: found.map((x) => x * data.scale)};
    }
    (drawn = values.join()), scene?.reshape(shapes);
  }
  // Slices between the frames of the page, also where these come slowly.
  function goOn() {
    clearTimeout(turn), (turn = advance(8) ? setTimeout(goOn) : 0);
  }
  function solveGhost() {
    ghost = null;
    page.ghost(null, 0);
    if (!ghostOn) return;
    const {tables, term, sliders} = what.ghost, own = sliders ? what.sliders.filter(({name}) => sliders.includes(name)) : what.sliders;
    const at = own.map((slider) => values[what.sliders.indexOf(slider)]);
    const model = tables ? tablesAt(what.ghost, own, at) : tablesAt(what, what.sliders, values);
    const without = tables ? omitted : new Set([...omitted, term]);
    ghost = solveMotion({...model, terms: termsOf(without)}, {...what, curves: []}, [], frames);
  }
  // Goes on for some milliseconds; true if there is more to show.
  function advance(budget) {
    const busy = [main, ghost].filter((one) => one && one.run.next < frames.length && !one.run.failed);
    if (!busy.length) return false;
    for (const one of busy) one.run.advance(budget / busy.length);
    if (main) page.known(frames[main.run.next - 1]);
    if (ghost) page.ghost(ghost.made, ghost.run.next);
    const over = !main || main.run.next === frames.length || main.run.failed;
    if (over || performance.now() - renewed > 300) renew();
    return true;
  }
  function renew() {
    renewed = performance.now();
    if (main) page.renew(main.made, main.run.next);
    report();
    if (!main || main.run.next === frames.length || main.run.failed) document.documentElement.dataset.solved = main ? (main.run.failed ? "failed" : "yes") : "no";
  }
  function report() {
    const texts = [];
    if (!main) texts.push("As computed beforehand. Move a slider, and this page solves the mechanism itself.");
    else {
      const {run} = main, {count} = run;
      if (run.failed) texts.push(`Solved up to t = ${valueText(run.t)} s: ${run.failed}.`);
      else if (run.next < frames.length) texts.push(`Solving: ${Math.floor((100 * run.next) / frames.length)} %.`);
      else texts.push(`Solved in this page: ${count.steps} steps, largest gap ${valueText(run.gap * what.tables.length)} m${Number.isFinite(run.drift) ? `, energy kept to ${valueText(run.drift / run.scale)} of its scale` : ""}.`);
      if (omitted.size) texts.push("A term is left out: this is not how it moves.");
      if (what.stale.includes("bodies")) texts.push("Bodies are drawn in their first shapes.");
    }
    $("certificate").textContent = texts.join(" ");
    $("theory").replaceChildren(...theory());
  }
  function theory() {
    if (!what.theory || omitted.size) return [];
    const polynomials = polynomialsAt(what.sliders, values), done = !main || main.run.next === frames.length;
    return what.theory.lines.map(({label, unit, start, reading, terms}) => {
      const found = terms.length && apart() ? sumOf(terms, polynomials) : start;
      const known = Math.abs(found) < ROUNDING * Math.abs(start) ? 0 : found;
      const own = done && reading ? foundIn((main ? main.made : recorded).lines, reading, frames) : NaN;
      const beside = Number.isFinite(own) ? `; here ${valueText(own)}, theory differs by ${valueText(Math.abs(own - known))}` : "";
      return element("li", {textContent: `${label}, by theory ${valueText(known)}${unit === "-" ? "" : ` ${unit}`}${beside}`});
    });
  }
  function reset() {
    what.sliders.forEach(({start}, k) => (values[k] = start)), omitted.clear(), solve();
  }
  what.sliders.forEach((slider, k) => {
    const output = element("output"), first = placeOn(slider, slider.start);
    const input = element("input", {type: "range", min: -1, max: 1, step: "any"});
    input.setAttribute("aria-label", slider.label);
    input.addEventListener("input", () => {
      const near = Math.abs(input.valueAsNumber - first) < 0.004; // the first value is found again
      (values[k] = near ? slider.start : valueOn(slider, input.valueAsNumber)), solve();
    });
    inputs.push(input), outputs.push(output);
    $("sliders").append(element("label", {}, element("span", {textContent: slider.label}), input, output));
  });
  for (const name of what.terms) {
    const tick = element("input", {type: "checkbox", checked: true});
    tick.addEventListener("change", () => (omitted[tick.checked ? "delete" : "add"](name), solve()));
    switches.push([name, tick]), $("terms").append(element("label", {}, tick, TERM_TEXTS[name]));
  }
  if (what.ghost) {
    const tick = element("input", {type: "checkbox"});
    tick.addEventListener("change", () => ((ghostOn = tick.checked), solveGhost(), goOn()));
    $("terms").append(element("label", {}, tick, `ghost: ${what.ghost.label}`));
  }
  const back = element("button", {type: "button", textContent: "first values"});
  back.addEventListener("click", reset), $("terms").append(back);
  solve();
  return {set: (given) => (given.forEach((x, k) => (values[k] = x)), solve()), reset, get values() { return values; }, get run() { return main?.run; }, get made() { return main?.made ?? recorded; }};
}
