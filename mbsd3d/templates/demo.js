// The page around the players of a demo: it starts them as they come into view, keeps them in step, follows their story,
// and lets the letters of the equation live: values of the moment, and lit with the curve or arrow that shows them.
const frames = [...document.querySelectorAll("iframe")], still = matchMedia("(prefers-reduced-motion: reduce)");
const steps = [...document.querySelectorAll(".story li")], symbols = [...document.querySelectorAll(".symbols button")];
const tell = (what, except) => frames.forEach(({contentWindow: frame}) => frame !== except && frame.postMessage(what, "*"));
const seen = new Set();
let held = null; // the symbol that was chosen by a click

const inView = () => tell({inView: seen.size > 0 && !still.matches});
const watch = new IntersectionObserver((entries) => {
  for (const {target, isIntersecting} of entries) seen[isIntersecting ? "add" : "delete"](target);
  inView();
}, {threshold: 0.4});
frames.forEach((frame) => watch.observe(frame));

addEventListener("message", ({data, source}) => {
  if (!frames.some(({contentWindow}) => contentWindow === source)) return;
  if (typeof data?.time === "number") tell(data, source);
  if (data?.ready) inView();
  if (source !== frames[0].contentWindow) return;
  if (typeof data?.solved === "boolean") {
    for (const part of document.querySelectorAll(".first")) part.hidden = data.solved;
    document.getElementById("elsewhere").hidden = !data.solved;
  }
  if (typeof data?.caption === "number")
    steps.forEach((step, k) => k === data.caption ? step.setAttribute("aria-current", "step") : step.removeAttribute("aria-current"));
  if (data?.now) showValues(data.now);
  if ("pointed" in (data ?? {})) light(data.pointed && symbols.find((symbol) => shows(symbol, data.pointed)));
});
for (const button of document.querySelectorAll("[data-seek]"))
  button.addEventListener("click", () => tell({seek: Number(button.dataset.seek)}));

// Four digits, as the players print them.
const RAISED = {"-": "\u207b", ...Object.fromEntries([..."\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079"].map((c, i) => [i, c]))};
function numberText(value) {
  if (typeof value !== "number") return "\u2013";
  const size = Math.abs(value) < 1e-9 ? 0 : Math.abs(value), [mantissa, power] = value.toExponential(3).split("e");
  if (size && (size < 1e-3 || size >= 1e5)) return `${mantissa.replace("-", "\u2212")} \u00b7 10${[...String(Number(power))].map((c) => RAISED[c]).join("")}`;
  return (size ? String(Number(value.toPrecision(4))) : "0").replace("-", "\u2212");
}
function showValues({t, lines, sliders, solved}) {
  for (const move of cursors) move(t);
  for (const symbol of symbols) {
    const {curve, parameter, value} = symbol.dataset;
    const here = curve ? numberText(lines[curve]) : parameter in sliders && solved ? numberText(sliders[parameter]) : solved && !parameter && value ? "\u2013" : value;
    symbol.querySelector("output").textContent = here;
  }
}

// Cursors of the figures below, over the same time; a click on one leads there.
const NS = "http://www.w3.org/2000/svg";
const cursors = [...document.querySelectorAll("svg[data-time]")].map((figure) => {
  const [first, last, left, right, bottom, top] = figure.dataset.time.split(" ").map(Number);
  const line = document.createElementNS(NS, "line");
  for (const [name, value] of Object.entries({y1: bottom, y2: top, stroke: "currentColor", "stroke-width": 1})) line.setAttribute(name, value);
  figure.append(line);
  figure.addEventListener("click", ({clientX, clientY}) => {
    const at = new DOMPoint(clientX, clientY).matrixTransform(figure.getScreenCTM().inverse()).x;
    tell({seek: first + ((at - left) / (right - left)) * (last - first)});
  });
  return (t) => {
    const x = left + ((t - first) / (last - first)) * (right - left);
    line.setAttribute("x1", x), line.setAttribute("x2", x), (line.style.display = t < first || t > last ? "none" : "");
  };
});

const shows = ({dataset: {curve, arrow}}, pointed) => ("arrow" in pointed ? arrow === pointed.arrow : curve === `${pointed.curve}.${pointed.line}`);
function light(symbol) {
  for (const part of document.querySelectorAll("[data-symbol]")) part.classList.toggle("lit", part.dataset.symbol === symbol?.dataset.symbol);
}
function point(symbol) {
  light(symbol);
  const {curve, arrow} = symbol?.dataset ?? {}, [index, line] = (curve || ".").split(".");
  tell({light: curve || arrow ? {...(curve && {curve: Number(index), line: Number(line)}), ...(arrow && {arrow})} : null});
}
for (const part of document.querySelectorAll("[data-symbol]")) {
  const symbol = symbols.find(({dataset}) => dataset.symbol === part.dataset.symbol);
  part.addEventListener("pointerenter", ({pointerType}) => pointerType === "mouse" && point(symbol));
  part.addEventListener("pointerleave", ({pointerType}) => pointerType === "mouse" && point(held));
  part.addEventListener("click", () => {
    held = held === symbol ? null : symbol;
    for (const other of symbols) other.setAttribute("aria-pressed", String(other === held));
    point(held);
  });
}
