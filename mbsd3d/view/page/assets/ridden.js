// The reader moves the mechanism himself: its equations are solved as the clock goes, with forces that keys or buttons give.

const RIDE_RATE = 60, STEEP = 0.85, RIDE_END = 600; // frames a second; sine of the lean at which it has fallen; s

// Signals given times a factor, from -1 to 1, that may change between frames.
function makeRidden({tables, method, given, origin, upright}) {
  const model = structuredClone(tables), solver = makeSolver(model, method), n = model.body.length;
  const whole = given.map((i) => tables.signal[i].map(({data}) => [...data]));
  const wanted = [0, 1 / RIDE_RATE], seen = {r: new Float64Array(3 * (n + 1)), e: new Float64Array(4 * (n + 1)), frames: 0};
  let lean = 0;
  function note(k) {
    solver.bodies.forEach(({r, e}, i) => {
      for (let j = 0; j < 3; j++) seen.r[3 * i + j] = r[j] - (i < n ? origin[j] : 0);
      seen.e.set(e, 4 * i);
    });
    (seen.frames = k), (lean = solver.bodies[upright].R[7]);
  }
  give(0);
  const run = solver.start(wanted, note);
  function give(factor) {
    given.forEach((i, k) => model.signal[i].forEach((term, j) => (term.data = whole[k][j].map((x) => factor * x))));
  }
  // On to a frame, for some milliseconds at most.
  function go(frame, factor, budget) {
    give(factor);
    while (wanted.length <= frame) wanted.push(wanted.length / RIDE_RATE);
    run.advance(budget);
  }
  return {go, seen, get fallen() { return Math.abs(lean) > STEEP || Boolean(run.failed) || seen.frames > RIDE_END * RIDE_RATE; }, get run() { return run; }};
}

// Buttons and keys; `page` shows poses and says when the film comes back.
function makeRider(what, page) {
  let ridden = null, begun = 0, factor = 0, over = false;
  const side = {ArrowLeft: -1, ArrowRight: 1};
  const push = (x) => (factor = x);
  for (const [id, x] of [["left", -1], ["right", 1]]) {
    $(id).addEventListener("pointerdown", (event) => ($(id).setPointerCapture(event.pointerId), push(x)));
    for (const end of ["pointerup", "pointercancel"]) $(id).addEventListener(end, () => push(0));
  }
  function start() {
    (ridden = makeRidden(what)), (begun = performance.now()), (over = false), push(0);
    $("page").classList.add("riding"), $("ride").textContent = "back to the film", page.ride(true), tell(what.hint);
  }
  function stop() {
    (ridden = null), $("page").classList.remove("riding"), $("ride").textContent = "ride it yourself", page.ride(false);
  }
  const tell = (text) => $("hint").textContent !== text && ($("hint").textContent = text);
  function tick(now) {
    if (!ridden || over) return;
    ridden.go(Math.floor((RIDE_RATE * (now - begun)) / 1000), factor, 12);
    const late = now - begun - (1000 * ridden.seen.frames) / RIDE_RATE;
    if (late > 100) begun += late; // a page that was hidden, or slow, does not hurry after the clock
    page.put(ridden.seen.r, ridden.seen.e);
    if (ridden.fallen) (over = true), tell(`It fell after ${(ridden.seen.frames / RIDE_RATE).toFixed(1)} s. Space: once more.`);
  }
  // True if the key was one of the ride.
  function key({key, type}) {
    if (!ridden || !(key in side || key === " " || key === "Escape")) return false;
    if (key in side) push(type === "keydown" ? side[key] : factor === side[key] ? 0 : factor);
    else if (type === "keydown") key === " " ? start() : stop();
    return true;
  }
  $("ride").addEventListener("click", () => (ridden ? stop() : start()));
  return {tick, key, start, stop, get riding() { return ridden !== null; }, get ridden() { return ridden; }};
}
