// Gamepads and wheels of the standard layout: a stick goes to both ends of a range, a trigger to the upper one.

const DEAD = 0.1; // of its way, in which a stick at rest may lie
const FINE = 64; // steps of that way that are told apart
const PADS = {
  "left stick": (pad) => pad.axes[0],
  "left stick up": (pad) => -pad.axes[1],
  "right stick": (pad) => pad.axes[2],
  "right stick up": (pad) => -pad.axes[3],
  "left trigger": (pad) => pad.buttons[6].value,
  "right trigger": (pad) => pad.buttons[7].value,
};
const leaned = new Map(); // control -> share of the way its stick is held at

const gamepads = () => [...(navigator.getGamepads?.() ?? [])].filter((pad) => pad?.connected);
const usable = (pad) => pad.mapping === "standard";

// Once a picture: gamepads send no events of their own.
function readPads() {
  if (socket?.readyState !== WebSocket.OPEN || !state.values) return;
  const found = gamepads().filter(usable);
  for (const control of data.controls) {
    const read = PADS[control.pad];
    if (!read) continue;
    const far = found.map(read).reduce((most, x) => (Math.abs(x) > Math.abs(most) ? x : most), 0);
    const share = Math.max(Math.abs(far) - DEAD, 0) / (1 - DEAD);
    lean(control, (Math.sign(far) * Math.round(FINE * share)) / FINE);
  }
}

function lean({name, low, high}, way) {
  if (way === (leaned.get(name) ?? 0)) return;
  const rest = state.values[name];
  way ? leaned.set(name, way) : leaned.delete(name);
  tell({hold: name, to: way ? rest + Math.abs(way) * ((way > 0 ? high : low) - rest) : null});
}

const letPadsGo = () => data.controls.filter(({name}) => leaned.has(name)).forEach((control) => lean(control, 0));

// Which stick does what, as soon as a gamepad is seen.
function showPads() {
  const found = gamepads(), line = $("pads");
  const uses = data.controls.filter(({pad}) => pad).map(({name, pad}) => `${pad}: ${name}`).join(", ");
  line.textContent = found.map((pad) => `${pad.id}: ${usable(pad) ? uses : "not of the standard layout, so it is not used"}`).join("; ");
  line.hidden = !found.length;
}

function setUpPads() {
  for (const kind of ["gamepadconnected", "gamepaddisconnected"]) window.addEventListener(kind, showPads);
  document.addEventListener("visibilitychange", () => document.hidden && letPadsGo());
  showPads();
}
