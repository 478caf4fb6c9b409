// The page: time, controls, switches, legend.

const times = data.times, last = times.first + times.step * (times.count - 1);
const still = times.count === 1;
let time = times.first, playing = false, waiting = false, speed = data.speed, before = null, curves = [];
let rider = null; // see ridden.js
let known = Infinity, explorer = null; // time up to which the motion on the screen is known [s]; see explore.js

const HOLD = 0.7; // [s] of a stop where a caption comes up, and at the end of a film with captions
const captions = data.captions;
let hold = 0, told = -2, captioned = true; // rest of the stop [s]; number of the caption on the page; whether they are of this motion

const placeOf = (t) => (still ? 0 : Math.min(Math.max((t - times.first) / times.step, 0), times.count - 1));

// Digits after the point such that a frame's step is seen.
const digits = still ? 4 : Math.min(9, Math.max(0, Math.ceil(-Math.log10(times.step)) + 1));
const timeText = (t) => `t = ${t.toFixed(digits)} s`.replace("-", "\u2212");

function seek(t) {
  (time = Math.min(Math.max(t, times.first), last)), (dirty = true);
}

function play(on) {
  if (still) return;
  if (on && time >= last) seek(times.first);
  (playing = on), (before = null);
  icon($("play"), on ? "pause" : "play");
  $("play").setAttribute("aria-label", on ? "pause" : "play");
}

const step = (frames) => (play(false), seek(times.first + (Math.round(placeOf(time)) + frames) * times.step));

// One turn of the clock: model time goes on by speed times real time, however slow the drawing is.
function tick(now) {
  if (playing) {
    const passed = before === null ? 0 : (now - before) / 1000;
    before = now;
    const away = Math.max(passed - hold, 0), t = time + away * speed;
    hold = Math.max(hold - passed, 0);
    const [stop] = captioned ? captions.find(([at]) => at > time && at <= t) ?? (captions.length && t >= last && time < last ? [last] : []) : [];
    if (stop !== undefined) (hold = HOLD), seek(stop);
    else if (away) goOn(t);
  }
  if (rider?.riding) return rider.tick(now), requestAnimationFrame(tick);
  if (dirty) draw();
  if (waiting && scene?.idle()) (waiting = false), scene.move(placeOf(Math.min(time, known)), shown);
  requestAnimationFrame(tick);
}
// Later than the last moment is the first one again, or the end.
function goOn(t) {
  if (t < last) seek(t);
  else if ($("loop").checked) seek(times.first + ((t - times.first) % (last - times.first)));
  else seek(last), play(false);
}

// The caption of a moment: from its time on, until the next one.
function caption(t) {
  const at = captioned ? captions.findLastIndex(([begin]) => begin <= t + 0.01 * times.step) : -1;
  if (at === told) return;
  told = at;
  [...($("caption")?.children ?? [])].forEach((says, k) => says.classList.toggle("now", k === at));
  parent !== window && parent.postMessage({caption: at}, "*");
}

function draw() {
  (dirty = false), (waiting = true); // the scene follows when the client has taken the last messages
  const there = Math.min(time, known), place = placeOf(there);
  if ($("time")) $("time").textContent = timeText(there);
  if (!still) {
    $("scrub").value = time;
    $("scrub").setAttribute("aria-valuetext", timeText(time));
  }
  for (const curve of curves) curve.draw(place);
  if (captions.length) caption(there);
}

function setUpTime() {
  icon($("play"), "play"), icon($("back"), "back"), icon($("forth"), "forth");
  Object.assign($("scrub"), {min: times.first, max: last, step: "any", value: times.first});
  $("time").style.minWidth = `${timeText(last).length}ch`; // else the page is laid out anew when a digit is added
  $("scrub").addEventListener("input", () => seek($("scrub").valueAsNumber));
  const choices = new Set([data.speed]);
  for (let k = -3; k <= 1; k++) for (const factor of [1, 2, 5]) choices.add(Number((factor * 10 ** k).toPrecision(3)));
  for (const x of [...choices].sort((a, b) => a - b)) {
    $("speed").append(element("option", {value: x, textContent: speedText(x), selected: x === data.speed}));
  }
  const pace = () => ($("pace").textContent = speed === 1 ? "real time" : `${speedText(speed)} real time`);
  $("speed").addEventListener("change", () => ((speed = Number($("speed").value)), pace()));
  pace();
  for (const [i, name] of data.bodies) $("follow").append(element("option", {value: i, textContent: name, selected: i === data.followed}));
  $("follow").addEventListener("change", () => (scene?.follow(Number($("follow").value)), (dirty = true)));
  $("play").addEventListener("click", () => play(!playing));
  $("back").addEventListener("click", () => step(-1));
  $("forth").addEventListener("click", () => step(1));
}

// Keys are ours: viser's own (space, arrows, letters) would move the camera.
function onKey(event) {
  event.stopImmediatePropagation();
  if (rider?.key(event)) return event.preventDefault();
  const {key, target} = event, typing = target.matches?.("select, input[type=range]");
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const moves = target.id === "divider" ? {ArrowLeft: () => widen(share + 4), ArrowRight: () => widen(share - 4)} : {};
  const does = moves[key] ?? {
    " ": () => play(!playing), Home: () => seek(times.first), End: () => (play(false), seek(last)),
    ArrowLeft: () => step(-1), ArrowRight: () => step(1), c: resetCamera,
  }[key];
  const keeps = key === " " ? target.matches?.("button, input, select, summary") : typing && key !== "c";
  if (!does || keeps) return;
  event.preventDefault(), does();
}

// Curves with their cursors; those without lines are left out.
function showCurves(lines) {
  const colours = data.colours[dark ? "dark" : "light"];
  const scales = {};
  data.curves.forEach(({unit, size}, i) => {
    scales[unit] = Math.max(scales[unit] ?? 0, size);
    for (const {values} of lines[i] ?? []) for (const v of values) if (Math.abs(v) > scales[unit]) scales[unit] = Math.abs(v);
  });
  const pick = (t) => (play(false), seek(t));
  curves = data.curves.flatMap((curve, i) => lines[i] ? [makeCurve(curve, lines[i], times, colours, scales[curve.unit] ?? 0, pick, i)] : []);
  $("curves").replaceChildren(...curves.map((curve) => curve.figure));
  dirty = true;
}

function setUpCurves(lines) {
  if (!data.curves.length) return;
  showCurves(lines);
  const again = () => (curves.forEach((curve) => curve.resize()), (dirty = true));
  new ResizeObserver(again).observe($("curves"));
  $("show-curves").addEventListener("change", () => $("page").classList.toggle("no-curves", !$("show-curves").checked));
  setUpDivider();
}

// The page around a motion that is solved here: what is not of it is hidden.
function setUpExplorer(arrays, recorded) {
  const {explore} = data, longest = data.arrows.map((kind) => kind.longest), factors = data.arrows.map((kind) => kind.factor);
  function show(made, first) {
    captioned = first;
    (arrays.r = made.r), (arrays.e = made.e);
    data.arrows.forEach((kind, i) => {
      if (made.arrows[i]) arrays.arrows[i] = made.arrows[i];
      stale[made.arrows[i] ? "delete" : "add"](kind.kind);
    });
    for (const name of explore.stale) if (name !== "bodies") stale[first ? "delete" : "add"](name);
    for (const {name, nodes} of data.layers) scene?.show(nodes, shown[name] && !stale.has(name));
    renew(made, first ? times.count : 0);
  }
  function renew(made, count) {
    if (data.curves.length) showCurves(made.lines);
    data.arrows.forEach((kind, i) => {
      if (!made.arrows[i]) return;
      const {values} = made.arrows[i].vectors;
      let most = 0;
      for (let k = 0; k < values.length; k += 3) most = Math.max(most, Math.hypot(values[k], values[k + 1], values[k + 2]) || 0);
      (kind.longest = most), (kind.factor = most ? (factors[i] * longest[i]) / most : 0);
    });
    makeLegend();
    if (explore.traces) scene?.retrace(explore.traces.map((trace) => pathOf(trace, made, count)));
    dirty = true;
  }
  const page = {show, renew, known: (t) => ((known = t), (dirty = true)), ghost: (made, count) => (scene?.ghost(made, count), (dirty = true))};
  explorer = makeExplorer(explore, recorded, page);
}

// What belongs to the film is hidden while the reader rides; then the film goes on from its start.
function setUpRide() {
  function ride(on) {
    play(false), seek(times.first);
    for (const {name, nodes, heads} of data.layers) if (heads || name === "traces") scene.show(nodes, !on && shown[name] && !stale.has(name));
    $("legend").hidden = on, scene.carryGround([0, 0], data.ride), resetCamera();
  }
  function put(r, e) {
    if (scene.idle()) scene.carryGround(r.subarray(3 * data.ride.upright), data.ride), scene.put(r, e);
  }
  rider = makeRider(data.ride, {ride, put});
  window.addEventListener("keyup", (event) => rider.key(event), true);
}

async function start() {
  $("caption")?.append(...captions.map(([, says]) => element("span", {textContent: says}))); // one upon the other: the strip keeps its height
  if (typeof DecompressionStream === "undefined") return say("This browser is too old to unpack the motion; a newer one shows it.");
  const all = (list) => Promise.all(list.map(unpack));
  const arrays = {
    r: await unpack(data.poses.r), e: await unpack(data.poses.e),
    arrows: await Promise.all(data.arrows.map(async (kind) => ({points: await unpack(kind.points), vectors: await unpack(kind.vectors)}))),
  };
  const lines = await Promise.all(data.curves.map((curve) => all(curve.lines.map((line) => line.values))));
  if (!still) setUpTime();
  makeSwitches(), makeLegend(), setUpCurves(lines);
  window.addEventListener("keydown", onKey, true);
  document.addEventListener("visibilitychange", () => (before = null)); // a hidden page stands still
  $("camera").addEventListener("click", resetCamera);
  requestAnimationFrame(tick);
  const seen = await setUpScene(makeScene(data, arrays));
  if (data.explore) setUpExplorer(arrays, {...arrays, arrows: [...arrays.arrows], lines});
  if (!seen) return;
  if (data.ride) setUpRide();
  scene.follow(data.followed), resetCamera(), say("");
  document.documentElement.dataset.ready = "yes";
}

// One line of the curves stands out, and of the arrows only its kind is seen; null = all as before.
function light(what) {
  for (const curve of curves) curve.light(what && "curve" in what ? (what.curve === curve.index ? what.line : -2) : -1);
  for (const {name, nodes, heads} of data.layers) {
    if (!heads) continue;
    const on = what?.arrow ? name === what.arrow : $("switches").querySelector(`[data-layer="${name}"] input`).checked;
    (shown[name] = on), scene?.show(nodes, on && !stale.has(name));
  }
  dirty = true;
}

// What the page around it may tell of this moment: values of curves and sliders.
function moment() {
  const there = Math.min(time, known), lines = {};
  for (const curve of curves) curve.at(placeOf(there)).forEach((value, k) => (lines[`${curve.index}.${k}`] = value));
  const sliders = Object.fromEntries(data.explore?.sliders.map(({name}, k) => [name, explorer?.values[k]]) ?? []);
  return {t: there, lines, sliders, solved: !captioned};
}

// For scripts and tests: the same as the controls do.
window.mbsd3d = {seek, play, light, moment, data, get time() { return time; }, get playing() { return playing; }, set speed(x) { speed = x; }, get explorer() { return explorer; }, get rider() { return rider; }};
start().catch((error) => say(`This page cannot be shown: ${error.message}`));
