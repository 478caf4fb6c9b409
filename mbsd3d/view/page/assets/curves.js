// Curves over time beside the scene: axes, ticks, units, a cursor with its values; dragging on one scrubs.

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

// As many digits as the step needs; powers of ten only for very large and small numbers.
function tickText(value, step) {
  if (Math.abs(value) < 1e-9 * step) return "0";
  const size = Math.max(Math.abs(value), step);
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const plain = size < 1e5 && digits <= 5 ? value.toFixed(digits) : String(Number(value.toPrecision(3)));
  return plain.replaceAll("-", "\u2212");
}

// Four digits; what is rounding in the scale of its picture is zero.
function valueText(value, scale = 0) {
  if (!Number.isFinite(value)) return "\u2013";
  const size = Math.abs(value) <= 1e-9 * scale ? 0 : Math.abs(value);
  if (size === 0) return "0";
  const text = size >= 1e-3 && size < 1e6 ? Number(value.toPrecision(4)).toString() : value.toExponential(3);
  return text.replaceAll("-", "\u2212");
}

// `scale`: largest value of this unit on the page; what is 1e-9 of it is rounding and not blown up.
function makeCurve(curve, lines, times, colours, scale, seek) {
  const canvas = element("canvas", {className: "plot"});
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", `${curve.label} in ${curve.unit} over time; drag to scrub`);
  const values = [], legend = element("ul", {className: "key"});
  curve.lines.forEach((line, i) => {
    const value = element("output", {className: "value"});
    const mark = element("canvas", {className: "mark", width: 44, height: 10});
    values.push(value);
    legend.append(element("li", {}, mark, element("span", {textContent: line.name}), value));
  });
  const unit = curve.unit ? ` [${curve.unit}]` : "";
  const figure = element("figure", {}, element("figcaption", {}, element("b", {textContent: curve.label + unit}), legend), canvas);
  let low = Infinity, high = -Infinity;
  for (const v of lines.flatMap((line) => Array.from(line.values))) {
    if (Number.isFinite(v)) (low = Math.min(low, v)), (high = Math.max(high, v));
  }
  if (low > high) (low = -1), (high = 1);
  if (high - low <= 1e-9 * scale || high === low) (low -= 0.05 * scale || 1), (high += 0.05 * scale || 1);
  const air = 0.06 * (high - low);
  (low -= air), (high += air);
  const first = times.first, last = times.first + times.step * (times.count - 1);
  const box = {left: 56, right: 12, top: 6, bottom: 20};
  const drawn = element("canvas"); // axes and lines, onto which cursor and values come
  let stale = true;

  const ink = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const stroke = (g, i, wide) => {
    (g.strokeStyle = colours[i % colours.length]), (g.lineWidth = wide);
    g.setLineDash(DASHES[Math.floor(i / colours.length) % DASHES.length]);
  };
  const x = (t) => box.left + ((t - first) / (last - first || 1)) * (canvas.clientWidth - box.left - box.right);
  const y = (v) => box.top + ((high - v) / (high - low)) * (canvas.clientHeight - box.top - box.bottom);

  function axes(g, width, height) {
    g.font = "11px system-ui, sans-serif";
    (g.fillStyle = ink("--muted")), (g.strokeStyle = ink("--line")), (g.lineWidth = 1);
    const up = ticks(low, high, Math.max(3, Math.floor((height - box.top - box.bottom) / 30)));
    const along = ticks(first, last, Math.max(2, Math.floor(width / 80)));
    (g.textAlign = "right"), (g.textBaseline = "middle");
    for (const v of up.found) {
      const at = Math.round(y(v)) + 0.5;
      g.beginPath(), g.moveTo(box.left, at), g.lineTo(width - box.right, at), g.stroke();
      g.fillText(tickText(v, up.step), box.left - 6, at);
    }
    (g.textAlign = "center"), (g.textBaseline = "top");
    for (const t of along.found) {
      const at = Math.round(x(t)) + 0.5, text = tickText(t, along.step);
      g.beginPath(), g.moveTo(at, height - box.bottom), g.lineTo(at, height - box.bottom + 4), g.stroke();
      const room = g.measureText(text + " s").width / 2;
      g.fillText(t === along.found[along.found.length - 1] ? `${text} s` : text, Math.min(at, width - room - 1), height - box.bottom + 6);
    }
  }

  function background() {
    const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
    canvas.width = drawn.width = Math.round(width * ratio);
    canvas.height = drawn.height = Math.round(height * ratio);
    canvas.getContext("2d").setTransform(ratio, 0, 0, ratio, 0, 0);
    const g = drawn.getContext("2d");
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    axes(g, width, height);
    lines.forEach((line, i) => {
      stroke(g, i, 1.75);
      g.beginPath();
      let pen = false;
      line.values.forEach((v, k) => {
        if (Number.isFinite(v)) g[pen ? "lineTo" : "moveTo"](x(first + k * times.step), y(v));
        pen = Number.isFinite(v);
      });
      g.stroke();
    });
    stale = false;
    legend.querySelectorAll("canvas").forEach((mark, i) => {
      const m = mark.getContext("2d");
      m.clearRect(0, 0, 44, 10), stroke(m, i, 4), m.beginPath(), m.moveTo(0, 5), m.lineTo(44, 5), m.stroke();
    });
  }

  function draw(place) {
    if (!canvas.clientWidth) return;
    if (stale) background();
    const g = canvas.getContext("2d"), at = x(first + place * times.step);
    g.clearRect(0, 0, canvas.clientWidth, canvas.clientHeight);
    g.drawImage(drawn, 0, 0, canvas.clientWidth, canvas.clientHeight);
    (g.strokeStyle = ink("--ink")), (g.lineWidth = 1), g.setLineDash([]);
    g.beginPath(), g.moveTo(at, box.top), g.lineTo(at, canvas.clientHeight - box.bottom), g.stroke();
    lines.forEach((line, i) => {
      const v = rowAt(line, place)[0];
      values[i].textContent = valueText(v, scale);
      if (!Number.isFinite(v)) return;
      (g.fillStyle = colours[i % colours.length]), (g.strokeStyle = ink("--paper")), (g.lineWidth = 1.5);
      g.beginPath(), g.arc(at, y(v), 4, 0, 7), g.fill(), g.stroke();
    });
  }

  const pick = (event) => {
    const share = (event.offsetX - box.left) / (canvas.clientWidth - box.left - box.right);
    seek(first + Math.min(Math.max(share, 0), 1) * (last - first));
  };
  canvas.addEventListener("pointerdown", (event) => (canvas.setPointerCapture(event.pointerId), pick(event)));
  canvas.addEventListener("pointermove", (event) => event.buttons & 1 && pick(event));
  return {figure, draw, resize: () => (stale = true)};
}
