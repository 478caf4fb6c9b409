// What the page of a motion and the page of a ride share: data, icons, switches of layers, legend, divider.

const $ = (id) => document.getElementById(id);
const data = JSON.parse($("data").textContent);
const ICONS = {
  play: "M3 1.5v13l11-6.5z", pause: "M3 2h4v12H3zM9 2h4v12H9z", back: "M2 2h3v12H2zM14 2v12L6 8z", forth: "M11 2h3v12h-3zM2 2v12l8-6z",
};
const shown = {}, stale = new Set(); // layers that are switched on; those that do not belong to the motion on the screen
let dirty = true, scene = null, share = 38;

const icon = (button, name) => (button.innerHTML = `<svg viewBox="0 0 16 16" aria-hidden="true"><path d="${ICONS[name]}"/></svg>`);
const say = (text) => (($("message").textContent = text), ($("message").hidden = !text));
const resetCamera = () => (scene?.resetCamera(), (dirty = true)); // a followed body may be elsewhere now

function speedText(x) {
  return x === 1 ? "real time" : `${Number(x.toPrecision(3))} \u00d7`;
}

function makeSwitch(name, on, mark, act) {
  const tick = element("input", {type: "checkbox", checked: on});
  tick.addEventListener("change", () => act(tick.checked));
  const label = element("label", {}, tick, ...(mark ? [mark] : []), name);
  (label.dataset.layer = name), $("switches").querySelector("fieldset").append(label);
  return tick;
}

function arrowMark(kind) {
  const mark = element("i", {className: "mark arrow", textContent: kind.heads === 2 ? "\u21a0" : "\u2192"});
  mark.style.color = kind.colour;
  mark.setAttribute("aria-hidden", "true");
  return mark;
}

// What lies inside bodies makes them transparent when it is first shown; a switch of its own undoes that.
function makeSwitches() {
  const through = makeSwitch("see through bodies", false, null, (on) => scene?.seeThrough(on));
  let asked = false;
  for (const layer of data.layers) {
    shown[layer.name] = layer.shown;
    makeSwitch(layer.name, layer.shown, layer.heads ? arrowMark(layer) : null, (on) => {
      (shown[layer.name] = on), (dirty = true);
      scene?.show(layer.nodes, on && !stale.has(layer.name));
      if (on && layer.inner && !asked) asked = through.checked || (through.click(), true);
      makeLegend();
    });
  }
  $("switches").open = window.innerWidth > 1000;
}

function makeLegend() {
  const rows = data.arrows.filter(({kind}) => shown[kind] && !stale.has(kind)).map((kind) => {
    const pale = kind.uncertain ? "; pale: not determined by the joints" : "";
    return element("p", {}, arrowMark(kind), `${kind.kind}${kind.unit && `, longest arrow: ${valueText(kind.longest)} ${kind.unit}`}${pale}`);
  });
  if (shown["ground grid"]) rows.push(element("p", {textContent: `grid ${data.grid}`}));
  $("legend").replaceChildren(...rows);
}

// Part of the width [%] that the curves take.
function widen(part) {
  share = Math.min(Math.max(part, 15), 80);
  $("page").style.setProperty("--share", `${share}%`);
  $("divider").setAttribute("aria-valuenow", Math.round(share));
}

function setUpDivider() {
  const divider = $("divider");
  divider.addEventListener("pointerdown", (event) => divider.setPointerCapture(event.pointerId));
  divider.addEventListener("pointermove", (event) => {
    if (event.buttons & 1) widen(100 * (1 - event.clientX / window.innerWidth));
  });
}

// True once the scene can be moved; otherwise the message says why it cannot.
async function setUpScene(made) {
  const graphics = document.createElement("canvas").getContext("webgl2");
  if (!graphics) return say("This browser shows no WebGL, which the 3D scene needs; switch it on or take another one."), false;
  graphics.getExtension("WEBGL_lose_context")?.loseContext();
  if (!(await made.ready(30))) return say("The 3D scene did not start: reload the page, or take another browser."), false;
  scene = made;
  if (dark) scene.darken();
  return true;
}
