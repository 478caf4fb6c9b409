// The page of a ride: sliders and keys go to the server, frames come from it.

const PACES = [0.05, 0.1, 0.2, 0.5, 1, 2];
const lines = data.panels.reduce((sum, panel) => sum + panel.lines.length, 0);
const HEAD = 3; // numbers before the curves: time, late frames, share of the pace
const count = data.moving.length;
const controls = new Map(); // name -> {set(value)}
const pressed = new Map(); // key -> what its release does
let socket = null, frame = null, last = null, drawn = null, state = {running: true, pace: 1}, told = "", strips = [], shapes = "{}", ride = null, drew = 0;

const tell = (message) => socket?.readyState === WebSocket.OPEN && socket.send(JSON.stringify(message));
const numberText = (x) => numeral(Number(x.toPrecision(3)).toString());
const keyText = (key) => ({ArrowLeft: "\u2190", ArrowRight: "\u2192", ArrowUp: "\u2191", ArrowDown: "\u2193"})[key] ?? key.toUpperCase();

// One slider. Pressed keys hold an end of the range; a slider with a spring goes back when it is let go.
function makeControl(control) {
  const {name, low, high, unit} = control;
  const slider = element("input", {type: "range", min: low, max: high, step: (high - low) / 1000, value: control.value});
  const value = element("output"), marks = element("div", {className: "good"});
  let taken = false; // by the pointer: then the server's value does not move it
  const keys = control.keys.map((pair) => pair.map(keyText).join(" ")).join(", ");
  const head = element("span", {}, element("b", {textContent: name}), value, unit ? ` ${unit}` : "");
  const row = element("label", {className: "control"}, head, ...(keys ? [element("kbd", {textContent: keys})] : []), slider, marks);
  if (control.hint) row.append(element("small", {textContent: control.hint}));
  slider.setAttribute("aria-label", unit ? `${name} in ${unit}` : name);
  slider.title = control.springs ? "goes back when it is let go" : "double click: back to its value at the start";
  const send = () => ((taken = true), tell({[control.springs ? "hold" : "set"]: name, to: slider.valueAsNumber}));
  const let_go = () => {
    if (taken && control.springs) tell({hold: name, to: null}), (slider.value = control.value);
    taken = false;
  };
  slider.addEventListener("input", send);
  slider.addEventListener("change", let_go);
  for (const event of ["pointerup", "pointercancel", "blur"]) slider.addEventListener(event, let_go);
  slider.addEventListener("dblclick", () => control.springs || tell({set: name, to: control.value}));
  $("controls").append(row);
  const show = (x, good) => {
    if (!taken) slider.value = x;
    value.textContent = numberText(x);
    const spans = (good ?? []).map(([from, to]) => [from, to].map((v) => (100 * (Math.min(Math.max(v, low), high) - low)) / (high - low)));
    marks.hidden = !good;
    marks.style.background = `linear-gradient(to right, ${["transparent 0%", ...spans.map(([a, b]) => `transparent ${a}%, var(--good) ${a}%, var(--good) ${b}%, transparent ${b}%`), "transparent 100%"].join(", ")})`;
  };
  show(control.value);
  controls.set(name, {show});
}

// Keys: pressed and released both count. viser's own (space, arrows, letters) would move the camera.
function onKey(event) {
  event.stopImmediatePropagation();
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key, {target} = event;
  if (event.type === "keyup") return release(key);
  if (event.ctrlKey || event.metaKey || event.altKey || target.matches?.("select")) return;
  const control = data.controls.find((one) => one.keys.some((pair) => pair.includes(key)));
  if (control) {
    event.preventDefault();
    if (pressed.has(key)) return; // it repeats
    const {name, low, high, keys} = control;
    pressed.set(key, () => tell({hold: name, to: null}));
    return tell({hold: name, to: keys.some(([down]) => down === key) ? low : high});
  }
  const does = {" ": () => tell({run: !state.running}), r: () => tell({do: "reset"}), c: resetCamera}[key];
  if (!does || (key === " " && target.matches?.("button, input[type=checkbox], summary"))) return;
  event.preventDefault();
  if (!event.repeat) does();
}

function release(key) {
  pressed.get(key)?.(), pressed.delete(key);
}

const releaseAll = () => [...pressed.keys()].forEach(release);

// What seldom changes.
function onNews(news) {
  state = news;
  for (const [name, control] of controls) control.show(news.held[name] ?? news.values[name], news.good[name]);
  icon($("play"), news.running ? "pause" : "play");
  $("play").setAttribute("aria-label", news.running ? "pause" : "go on");
  $("play").disabled = news.over;
  $("speed").value = news.pace;
  ($("note").textContent = news.note), ($("note").hidden = !news.note);
  $("save").textContent = news.saving ? "saving ..." : `save the ride${news.since > 0.05 ? ` since ${news.since.toFixed(1)} s` : ""}`;
  $("save").disabled = news.saving;
  if (ride !== null && news.ride > ride) element("a", {href: `/ride-${news.ride}.html`, download: `${document.title}.html`}).click();
  ride = news.ride;
  const changed = JSON.stringify(news.shapes);
  if (changed !== shapes) scene?.reshape(news.shapes), (shapes = changed);
  if (news.history) {
    strips.forEach((strip) => strip.clear());
    for (const [t, ...row] of news.history) pushRow(t, row.map((x) => x ?? NaN));
  }
}

function pushRow(t, row) {
  let at = 0;
  data.panels.forEach((panel, i) => strips[i].push(t, row.slice(at, (at += panel.lines.length))));
}

function onFrame(numbers) {
  last = numbers;
  frame = numbers;
  pushRow(numbers[0], Array.from(numbers.subarray(HEAD, HEAD + lines)));
}

// One picture, of the newest frame.
function tick(now) {
  requestAnimationFrame(tick);
  readPads();
  if (frame === null || (scene !== null && !scene.idle())) return;
  const [t, late, share] = frame;
  $("time").textContent = `t = ${t.toFixed(2)} s`;
  $("pace").textContent = !state.running ? (state.over ? "over" : "paused") : share < 0.98 ? `${Math.round(100 * share)} % of ${speedText(state.pace)}` : speedText(state.pace);
  $("late").textContent = `late frames: ${late}`;
  if (now - drew > 45) strips.forEach((strip) => strip.draw()), (drew = now); // the scene needs the time more
  if (scene === null) return void (frame = null);
  const r = new Float64Array(3 * count + 3), e = new Float64Array(4 * count + 4);
  e[4 * count] = 1; // the ground comes last
  for (let i = 0; i < count; i++) {
    const at = HEAD + lines + 7 * i;
    r.set(frame.subarray(at, at + 3).map((x, k) => x - data.origin[k]), 3 * i), e.set(frame.subarray(at + 3, at + 7), 4 * i);
  }
  scene.put(r, e);
  (drawn = t), (frame = null);
}

function connect() {
  socket = new WebSocket(`ws://${location.host}/live`);
  socket.binaryType = "arraybuffer";
  socket.onmessage = ({data: said}) => (typeof said === "string" ? onNews(JSON.parse(said)) : onFrame(new Float64Array(said)));
  socket.onopen = () => scene !== null && (say(""), tell({watch: true}));
  socket.onclose = () => {
    pressed.clear(), leaned.clear();
    say("The ride has ended: its server was stopped.");
    setTimeout(connect, 1000);
  };
}

function setUpPage() {
  if (data.controls.length) data.controls.forEach(makeControl);
  for (const x of PACES) $("speed").append(element("option", {value: x, textContent: speedText(x), selected: x === 1}));
  $("speed").addEventListener("change", () => tell({pace: Number($("speed").value)}));
  for (const [i, name] of data.bodies) $("follow").append(element("option", {value: i, textContent: name, selected: i === data.followed}));
  $("follow").addEventListener("change", () => scene?.follow(Number($("follow").value)));
  $("turn").addEventListener("change", () => scene?.turnAlong($("turn").checked));
  $("turn").checked = data.followed >= 0;
  $("play").addEventListener("click", () => tell({run: !state.running}));
  $("reset").addEventListener("click", () => tell({do: "reset"}));
  $("save").addEventListener("click", () => tell({do: "save"}));
  $("camera").addEventListener("click", resetCamera);
  strips = data.panels.map((panel) => makeStrip(panel, data.colours[dark ? "dark" : "light"], data.seconds));
  $("curves").append(...strips.map((strip) => strip.figure));
  makeSwitches(), makeLegend(), setUpDivider(), setUpPads();
  $("switches").open = false;
  for (const kind of ["keydown", "keyup"]) window.addEventListener(kind, onKey, true);
  window.addEventListener("blur", releaseAll);
  document.addEventListener("visibilitychange", () => document.hidden && releaseAll());
}

async function start() {
  setUpPage(), connect(), requestAnimationFrame(tick);
  const arrays = {r: await unpack(data.poses.r), e: await unpack(data.poses.e), arrows: []};
  if (!(await setUpScene(makeScene(data, arrays)))) return;
  scene.turnAlong($("turn").checked), scene.follow(data.followed), resetCamera();
  if (socket.readyState === WebSocket.OPEN) socket.onopen();
  if (shapes !== "{}") scene.reshape(state.shapes);
  document.documentElement.dataset.ready = "yes";
}

// For scripts and tests.
window.mbsd3d = {data, tell, get state() { return state; }, get frames() { return strips[0]?.count ?? 0; }, get last() { return last; }, get drawn() { return drawn; }};
start().catch((error) => say(`This page cannot be shown: ${error.message}`));
