// The page: time, controls, switches, legend.

const times = data.times, last = times.first + times.step * (times.count - 1);
const still = times.count === 1;
let time = times.first, playing = false, waiting = false, speed = data.speed, before = null, curves = [];

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
    let t = time + passed * speed;
    if (t >= last) {
      if ($("loop").checked) t = times.first + ((t - times.first) % (last - times.first));
      else (t = last), play(false);
    }
    seek(t);
  }
  if (dirty) draw();
  if (waiting && scene?.idle()) (waiting = false), scene.move(placeOf(time), shown);
  requestAnimationFrame(tick);
}

function draw() {
  (dirty = false), (waiting = true); // the scene follows when the client has taken the last messages
  const place = placeOf(time);
  if ($("time")) $("time").textContent = timeText(time);
  if (!still) {
    $("scrub").value = time;
    $("scrub").setAttribute("aria-valuetext", timeText(time));
  }
  for (const curve of curves) curve.draw(place);
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

function setUpCurves(lines) {
  if (!data.curves.length) return;
  const colours = data.colours[dark ? "dark" : "light"];
  const scales = {};
  data.curves.forEach(({unit}, i) => {
    for (const {values} of lines[i]) for (const v of values) if (Math.abs(v) > (scales[unit] ?? 0)) scales[unit] = Math.abs(v);
  });
  const pick = (t) => (play(false), seek(t));
  curves = data.curves.map((curve, i) => makeCurve(curve, lines[i], times, colours, scales[curve.unit] ?? 0, pick));
  $("curves").append(...curves.map((curve) => curve.figure));
  const again = () => (curves.forEach((curve) => curve.resize()), (dirty = true));
  new ResizeObserver(again).observe($("curves"));
  $("show-curves").addEventListener("change", () => $("page").classList.toggle("no-curves", !$("show-curves").checked));
  setUpDivider();
}

async function start() {
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
  if (!(await setUpScene(makeScene(data, arrays)))) return;
  scene.follow(data.followed), resetCamera(), say("");
  document.documentElement.dataset.ready = "yes";
}

// For scripts and tests: the same as the controls do.
window.mbsd3d = {seek, play, data, get time() { return time; }, get playing() { return playing; }, set speed(x) { speed = x; }};
start().catch((error) => say(`This page cannot be shown: ${error.message}`));
