// Live curves: the last seconds of each panel, drawn anew with what has come.

function makeStrip(panel, colours, seconds) {
  const {figure, canvas, values, stroke, marks} = makeFigure(panel.label, panel.unit, panel.lines, colours, "");
  let times = [], rows = [], marked = false; // rows: an array of values per time

  function push(t, row) {
    while (times.length && times[times.length - 1] >= t) times.pop(), rows.pop(); // it was reset
    times.push(t), rows.push(row);
    let old = 0;
    while (times[old] < t - seconds) old++;
    if (old > 60) (times = times.slice(old)), (rows = rows.slice(old));
  }

  function clear() {
    (times = []), (rows = []);
  }

  // What is seen, with air and on round numbers, so that it does not change with every value.
  function range() {
    let low = Infinity, high = -Infinity;
    for (const row of rows) for (const v of row) if (Number.isFinite(v)) (low = Math.min(low, v)), (high = Math.max(high, v));
    if (low > high) return [-1, 1];
    if (high - low <= 1e-6 * Math.max(Math.abs(low), Math.abs(high), 1e-3)) (low -= 0.5 * Math.abs(low) || 1), (high += 0.5 * Math.abs(high) || 1);
    const {step} = ticks(low, high, 5);
    return [Math.floor(low / step) * step, Math.ceil(high / step) * step];
  }

  function draw() {
    const width = canvas.clientWidth, height = canvas.clientHeight;
    if (!width || !times.length) return;
    if (!marked) marks(), (marked = true);
    const first = Math.max(times[times.length - 1] - seconds, times[0]), last = first + seconds; // they fill it, then it goes along
    const g = sharp(canvas, width, height), axes = makeAxes(width, height, ...range(), first, last);
    axes.draw(g);
    panel.lines.forEach((_, i) => {
      stroke(g, i, 1.75), g.beginPath();
      let pen = false;
      times.forEach((t, k) => {
        const v = rows[k][i];
        if (t >= first && Number.isFinite(v)) g[pen ? "lineTo" : "moveTo"](axes.x(t), axes.y(v));
        pen = t >= first && Number.isFinite(v);
      });
      g.stroke();
      values[i].textContent = valueText(rows[rows.length - 1][i]);
    });
  }

  return {figure, push, clear, draw, get count() { return times.length; }};
}
