// Solves a mechanism in the page from its lowered tables (mbsd3d/view/explore/lowered.py), as the kernels do in Python:
//
//   [ M  J' ] [ v_dot ]   [ Q - h ]     y = (q, u, work of what stores no energy), q = (r, e) a body,
//   [ J  0  ] [ lam   ] = [ gamma ]     u = (r_dot, R'w) a body; e_dot = H(e) w / 2
//
// and behind them the states that force elements own, as the deflections of tyres and of what rubs,
// about the reference points O. M^-1 is known body by body, so S = J M^-1 J' gives the multipliers; rows that repeat
// others are allowed. Steps are of order 8, projected onto c = 0 and J v = b. Vectors are arrays of three numbers in
// world axes; R is a row-major matrix from body to world.

function makeSolver(model, method) {
  const n = model.body.length, rows = model.row.length, owned = model.state.length, WORK = 13 * n, OWN = WORK + 1, size = OWN + owned;
  const terms = {gyroscopic: true, centripetal: true, gamma: true, ...model.terms};
  const ZERO = [0, 0, 0], UNIT = [[1, 0, 0], [0, 1, 0], [0, 0, 1]], ONE = [1, 0, 0, 0, 1, 0, 0, 0, 1];
  const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
  const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
  const scale = (k, a) => [k * a[0], k * a[1], k * a[2]];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const from = (x, o) => [x[o], x[o + 1], x[o + 2]];
  function write(x, o, a) {
    (x[o] = a[0]), (x[o + 1] = a[1]), (x[o + 2] = a[2]);
  }
  const turning = (w, s) => cross(w, cross(w, s)); // centripetal acceleration of a point at s
  const rotate = (R, a) => [
    R[0] * a[0] + R[1] * a[1] + R[2] * a[2], R[3] * a[0] + R[4] * a[1] + R[5] * a[2], R[6] * a[0] + R[7] * a[1] + R[8] * a[2],
  ];
  const rotateBack = (R, a) => [
    R[0] * a[0] + R[3] * a[1] + R[6] * a[2], R[1] * a[0] + R[4] * a[1] + R[7] * a[2], R[2] * a[0] + R[5] * a[1] + R[8] * a[2],
  ];

  // Bodies as they are at the state at hand; the last one is the ground.
  const bodies = [...model.body, null].map(() => ({r: ZERO, e: [1, 0, 0, 0], R: ONE, s: ZERO, v: ZERO, w: ZERO, own: ZERO, spin: ZERO}));
  // A body whose inertia cannot be inverted gets a little more while S is formed; iterations take it away again.
  const light = model.body.flatMap((body, i) => (body.light ? [i] : []));
  const total = model.body.reduce((sum, {mass}) => sum + mass, 0) || 1, little = 1e-4 * total, turned3 = little * model.length ** 2;
  const masses = model.body.map(({mass, light}) => mass + (light ? little : 0));
  const inverses = model.body.map(({inertia, light}) => inverse3(inertia.map((x, j) => x + (light && j % 4 === 0 ? turned3 : 0))));
  const J = new Float64Array(24 * rows), c = new Float64Array(rows), b = new Float64Array(rows), gamma = new Float64Array(rows);
  const Q = new Float64Array(6 * n + 6), h = new Float64Array(6 * n), acceleration = new Float64Array(6 * n), lam = new Float64Array(rows);
  const last = model.coordinate.map(() => ({value: 0, rate: 0})); // at the last accepted state, to unwrap against
  let lastTime = 0, stored = 0, power = 0;
  const own = new Float64Array(owned), ownRate = new Float64Array(owned), pushes = model.force.map(() => ZERO); // of force elements: states, their rates, forces on the last body
  const count = {steps: 0, rejected: 0, evaluations: 0};

  function kinematics(y) {
    own.set(y.subarray(OWN, size));
    for (let i = 0; i < n; i++) {
      const q = 7 * i, u = 7 * n + 6 * i, body = bodies[i], e0 = y[q + 3], e1 = y[q + 4], e2 = y[q + 5], e3 = y[q + 6];
      const k = 2 / (e0 * e0 + e1 * e1 + e2 * e2 + e3 * e3);
      body.e = [e0, e1, e2, e3];
      body.R = [
        1 - k * (e2 * e2 + e3 * e3), k * (e1 * e2 - e0 * e3), k * (e1 * e3 + e0 * e2),
        k * (e1 * e2 + e0 * e3), 1 - k * (e1 * e1 + e3 * e3), k * (e2 * e3 - e0 * e1),
        k * (e1 * e3 - e0 * e2), k * (e2 * e3 + e0 * e1), 1 - k * (e1 * e1 + e2 * e2),
      ];
      (body.r = from(y, q)), (body.v = from(y, u)), (body.own = from(y, u + 3));
      (body.s = rotate(body.R, model.body[i].com)), (body.w = rotate(body.R, body.own));
    }
  }
  const arm = (body, p) => rotate(body.R, p);
  const point = (body, s) => add(body.r, s);
  const velocity = (body, s) => add(body.v, cross(body.w, s));
  const columns = (body, F) => [0, 1, 2].map((j) => arm(body, [F[j], F[3 + j], F[6 + j]]));

  // ---- signals: value and two derivatives

  function polynomial(coefficients, x) {
    let f = 0, g = 0, k = 0;
    for (let i = coefficients.length - 1; i >= 0; i--) (k = k * x + 2 * g), (g = g * x + f), (f = f * x + coefficients[i]);
    return [f, g, k];
  }
  function spline(data, t) {
    const pieces = data[0];
    let low = 0, high = pieces - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (data[1 + middle] <= t) low = middle;
      else high = middle - 1;
    }
    const first = 2 + pieces + 4 * low;
    return polynomial(data.slice(first, first + 4).reverse(), t - data[1 + low]);
  }
  function sine([amplitude, omega, phase], t) {
    const s = Math.sin(omega * t + phase), k = Math.cos(omega * t + phase);
    return [amplitude * s, amplitude * omega * k, -amplitude * omega * omega * s];
  }
  const TERMS = [polynomial, sine, spline];
  const signal = (i, t) => model.signal[i].reduce((sum, {kind, data}) => add(sum, TERMS[kind](data, t)), ZERO);

  // ---- hinge coordinates: value, J_dot v, and what its rate is by the velocities of both bodies

  // n . (p_b - p_a), with n and s_a fixed in a, s_b in b
  function slideAlong(a, z, normal, sa, sb) {
    const reach = sub(point(z, sb), a.r), gap = sub(reach, sa), gapRate = sub(velocity(z, sb), velocity(a, sa)), rate = cross(a.w, normal);
    const points = sub(turning(z.w, sb), turning(a.w, sa));
    const bias = dot(cross(a.w, rate), gap) + 2 * dot(rate, gapRate) + dot(normal, points);
    return {value: dot(normal, gap), bias, la: scale(-1, normal), ta: cross(normal, reach), lb: normal, tb: cross(sb, normal)};
  }
  function nearestTurn(i, raw, rate, t) {
    const expected = last[i].value + 0.5 * (last[i].rate + rate) * (t - lastTime);
    return raw + 2 * Math.PI * Math.floor((expected - raw) / (2 * Math.PI) + 0.5);
  }
  // atan2(x_b . y_a, x_b . x_a)
  function angle(i, t) {
    const {body, axis} = model.coordinate[i], a = bodies[body[0]], z = bodies[body[1]];
    const xa = arm(a, axis[0]), ya = arm(a, axis[1]), xb = arm(z, axis[2]), sin = dot(xb, ya), cos = dot(xb, xa);
    const f = sub(scale(cos, ya), scale(sin, xa)), N = sin * sin + cos * cos, g = scale(1 / N, cross(xb, f)), w = sub(z.w, a.w);
    const sinRate = dot(w, cross(xb, ya)), cosRate = dot(w, cross(xb, xa));
    const fRate = sub(add(scale(cosRate, ya), scale(cos, cross(a.w, ya))), add(scale(sinRate, xa), scale(sin, cross(a.w, xa))));
    const top = add(cross(cross(z.w, xb), f), cross(xb, fRate));
    const bias = dot(w, sub(scale(1 / N, top), scale((2 * (sin * sinRate + cos * cosRate)) / N, g)));
    return {value: nearestTurn(i, Math.atan2(sin, cos), dot(g, w), t), bias, la: ZERO, ta: scale(-1, g), lb: ZERO, tb: g};
  }
  function slide(i) {
    const {body, axis, point: at} = model.coordinate[i], a = bodies[body[0]], z = bodies[body[1]];
    return slideAlong(a, z, arm(a, axis[0]), arm(a, at[0]), arm(z, at[1]));
  }
  const coordinate = (i, t) => (model.coordinate[i].kind === 0 ? angle(i, t) : slide(i));
  function rateOf(i, x) {
    const [a, z] = model.coordinate[i].body.map((k) => bodies[k]);
    return dot(x.la, a.v) + dot(x.ta, a.w) + dot(x.lb, z.v) + dot(x.tb, z.w);
  }
  function remember(t) {
    const found = model.coordinate.map((_, i) => coordinate(i, t));
    found.forEach((x, i) => ((last[i].value = x.value), (last[i].rate = rateOf(i, x))));
    lastTime = t;
  }

  // ---- rows: c, J, gamma of each primitive, in the order of kinds.py (kernels/rows.py)

  function put(k, slot, linear, angular) {
    write(J, 24 * k + 6 * slot, linear), write(J, 24 * k + 6 * slot + 3, angular);
  }
  function more(k, slot, linear, angular) {
    const o = 24 * k + 6 * slot;
    for (let j = 0; j < 3; j++) (J[o + j] += linear[j]), (J[o + 3 + j] += angular[j]);
  }
  // x . y of axes that turn with wx and wy: value, gradient, J_dot v
  function axesDot(x, y, wx, wy) {
    const w = sub(wx, wy), value = dot(x, y);
    return {value, n: cross(x, y), bias: dot(w, x) * dot(wx, y) - dot(w, y) * dot(wy, x) - dot(w, w) * value};
  }
  function contactRow(k, a, z, normal, normalRate, armB, armA, biasB, armARate) {
    const slip = sub(velocity(z, armB), velocity(a, armA));
    gamma[k] = -(dot(normalRate, slip) + dot(normal, sub(biasB, cross(a.w, armARate))));
    put(k, 0, scale(-1, normal), cross(normal, armA)), put(k, 1, normal, cross(armB, normal));
  }
  const spread = (r, u, v) => [0, 1, 2].reduce((sum, i) => add(sum, scale(r[i] * r[i] * dot(u[i], v), u[i])), ZERO);
  function turnOnly(k, n) {
    put(k, 0, ZERO, n), put(k, 1, ZERO, scale(-1, n));
  }
  const fillers = [
    function coincide(p, k, a, z) {
      const sa = arm(a, p.point[0]), sb = arm(z, p.point[1]), gap = sub(point(z, sb), point(a, sa)), g = sub(turning(a.w, sa), turning(z.w, sb));
      UNIT.forEach((unit, i) => {
        (c[k + i] = gap[i]), (gamma[k + i] = g[i]);
        put(k + i, 0, scale(-1, unit), cross(unit, sa)), put(k + i, 1, unit, cross(sb, unit));
      });
    },
    function axesAtRightAngle(p, k, a, z) {
      const x = axesDot(arm(a, p.axis[0]), arm(z, p.axis[1]), a.w, z.w);
      (c[k] = x.value), (gamma[k] = -x.bias), turnOnly(k, x.n);
    },
    function constantVelocity(p, k, a, z) {
      const x = axesDot(arm(a, p.axis[0]), arm(z, p.second_axis[1]), a.w, z.w), y = axesDot(arm(a, p.second_axis[0]), arm(z, p.axis[1]), a.w, z.w);
      (c[k] = x.value - y.value), (gamma[k] = y.bias - x.bias), turnOnly(k, sub(x.n, y.n));
    },
    function inPlane(p, k, a, z) {
      const x = slideAlong(a, z, arm(a, p.axis[0]), arm(a, p.point[0]), arm(z, p.point[1]));
      (c[k] = x.value), (gamma[k] = -x.bias), put(k, 0, x.la, x.ta), put(k, 1, x.lb, x.tb);
    },
    function distance(p, k, a, z) {
      const sa = arm(a, p.point[0]), sb = arm(z, p.point[1]), gap = sub(point(z, sb), point(a, sa)), rate = sub(velocity(z, sb), velocity(a, sa));
      const length = Math.sqrt(dot(gap, gap)), along = scale(1 / length, gap), speed = dot(along, rate);
      c[k] = length - p.value[0];
      gamma[k] = -(dot(rate, rate) - speed * speed) / length - dot(along, sub(turning(z.w, sb), turning(a.w, sa)));
      put(k, 0, scale(-1, along), cross(along, sa)), put(k, 1, along, cross(sb, along));
    },
    function ratio(p, k, a, z, t) {
      (c[k] = 0), (gamma[k] = 0);
      p.coordinate.slice(0, 2).forEach((which, i) => {
        if (which < 0) return;
        const f = p.value[i], x = coordinate(which, t);
        (c[k] += f * x.value), (gamma[k] -= f * x.bias);
        put(k, 2 * i, scale(f, x.la), scale(f, x.ta)), put(k, 2 * i + 1, scale(f, x.lb), scale(f, x.tb));
      });
    },
    function turnRate(p, k, a, z) {
      const x = arm(a, p.axis[0]);
      (c[k] = 0), (gamma[k] = -dot(cross(a.w, x), sub(z.w, a.w))), turnOnly(k, scale(-1, x));
    },
    function noSideslip(p, k, a, z) {
      const normal = arm(z, p.axis[1]), s = arm(z, p.point[1]), reach = sub(point(z, s), a.r), rate = sub(velocity(z, s), a.v);
      (c[k] = 0), contactRow(k, a, z, normal, cross(z.w, normal), s, reach, turning(z.w, s), rate);
    },
    function roll(p, k, a, z) {
      const n = arm(a, p.axis[0]), u = arm(z, p.axis[1]), v = arm(z, p.second_axis[1]), s = arm(z, p.point[1]);
      const r = p.value, rho = p.value[3], axes = [u, v, cross(u, v)], normalRate = cross(a.w, n);
      const q = spread(r, axes, n), height = Math.sqrt(dot(n, q) + 1e-300), low = sub(scale(-1 / height, q), scale(rho, n));
      const turn = sub(normalRate, cross(z.w, n)), bent = sub(spread(r, axes, turn), scale(dot(turn, q) / (height * height), q));
      const lowRate = sub(cross(z.w, low), add(scale(1 / height, bent), scale(rho, turn)));
      const centre = sub(point(z, s), a.r), armB = add(s, low), armA = add(centre, low);
      const armARate = add(sub(velocity(z, s), a.v), lowRate), biasB = cross(z.w, add(cross(z.w, s), lowRate));
      const along = arm(a, p.second_axis[0]), across = cross(n, along);
      (c[k] = dot(n, sub(centre, arm(a, p.point[0]))) - height - rho), (c[k + 1] = c[k + 2] = 0);
      contactRow(k, a, z, n, normalRate, armB, armA, biasB, armARate);
      contactRow(k + 1, a, z, along, cross(a.w, along), armB, armA, biasB, armARate);
      contactRow(k + 2, a, z, across, cross(a.w, across), armB, armA, biasB, armARate);
    },
    function mesh(p, k, a, z, t) {
      fillers[5](p, k, a, z, t); // the ratio of the angles, then what makes it a force along the line of action
      for (let i = 0; i < 2; i++) {
        const from = 2 * i, to = from + 1, x = bodies[p.body[from]], y = bodies[p.body[to]];
        const mount = arm(x, p.point[from]), hub = arm(y, p.point[to]), normal = arm(x, p.axis[from]), spin = arm(y, p.axis[to]);
        const across = model.coordinate[p.coordinate[i]].axis, u = cross(arm(x, across[0]), arm(x, across[1]));
        const gap = slideAlong(x, y, normal, mount, hub), slid = slideAlong(x, y, u, mount, hub);
        const level = axesDot(arm(x, p.second_axis[from]), spin, x.w, y.w);
        const lean = axesDot(sub(normal, scale(dot(normal, u), u)), spin, x.w, y.w), leanRate = dot(sub(x.w, y.w), lean.n);
        const slidRate = dot(slid.la, x.v) + dot(slid.ta, x.w) + dot(slid.lb, y.v) + dot(slid.tb, y.w);
        const moment = sub(level.n, scale(slid.value, lean.n)), f = lean.value;
        c[k] += gap.value + level.value - slid.value * f;
        gamma[k] -= gap.bias + level.bias - slid.value * lean.bias - f * slid.bias - 2 * slidRate * leanRate;
        more(k, from, sub(gap.la, scale(f, slid.la)), add(sub(gap.ta, scale(f, slid.ta)), moment));
        more(k, to, sub(gap.lb, scale(f, slid.lb)), sub(sub(gap.tb, scale(f, slid.tb)), moment));
      }
    },
  ];
  function fillRows(t) {
    b.fill(0);
    for (const p of model.primitive) {
      const k = p.row;
      fillers[p.kind](p, k, bodies[p.body[0]], bodies[p.body[1]], t);
      if (!terms.gamma) gamma.fill(0, k, k + p.rows); // without -J_dot v, with what drivers prescribe
      if (p.signal < 0) continue;
      const [f, rate, bend] = signal(p.signal, t);
      if (model.row[k].holonomic) (c[k] -= f), (b[k] = rate), (gamma[k] += bend);
      else (b[k] = f), (gamma[k] += rate);
    }
  }

  // ---- loads: Q with gravity, h, energy stored, power of what stores none

  function push(i, force, moment) {
    const o = 6 * i;
    for (let j = 0; j < 3; j++) (Q[o + j] += force[j]), (Q[o + 3 + j] += moment[j]);
  }
  const pushAt = (i, force, s) => push(i, force, cross(s, force));
  const components = (p, t) => p.signal.map((i) => (i < 0 ? 0 : signal(i, t)[0]));
  const given = (p, t) => (p.option === 1 ? rotate(bodies[p.body[1]].R, components(p, t)) : components(p, t));
  const tied = (k, x) => [0, 1, 2].map((i) => k[i] * x[i]); // a diagonal stiffness times a vector
  const intoAxes = (F, x) => F.map((axis) => dot(axis, x));
  const outOfAxes = (F, x) => add(add(scale(x[0], F[0]), scale(x[1], F[1])), scale(x[2], F[2]));
  function alongCoordinate(p, t, law) {
    const x = coordinate(p.coordinate, t), load = law(x.value, rateOf(p.coordinate, x)), [a, z] = model.coordinate[p.coordinate].body;
    push(a, scale(load, x.la), scale(load, x.ta)), push(z, scale(load, x.lb), scale(load, x.tb));
  }
  // f = k x + c u, but no more than `most`, and x_dot = (f - k x) / c
  function gripped(k, c, x, u, most) {
    const free = x.map((deflection, j) => k * deflection + c * u[j]), size = Math.hypot(...free);
    const share = most <= 0 ? 0 : size > most ? most / size : 1, force = free.map((f) => share * f);
    return {force, rate: force.map((f, j) => (f - k * x[j]) / c)};
  }
  function smoothed(most, u, still) {
    const share = most / Math.sqrt(u.reduce((sum, x) => sum + x * x, still * still));
    return u.map((x) => share * x);
  }
  // Friction and moment against slip and turning under a pressure, in the axes of the plane, by their own states or without
  function rubbing(p, normal, slip, turn) {
    const {grip: k, grip_damping: c, size, creep, state, states} = p, limits = [p.friction, p.rolling, p.spinning].map((x) => x * normal);
    if (!states) {
      const [f, r, s] = [[slip, limits[0], creep], [turn.slice(0, 2), limits[1], creep / size], [turn.slice(2), limits[2], creep / size]]
        .map(([u, most, still]) => smoothed(most, u, still));
      return {friction: f, moment: [...r, ...s]};
    }
    const found = [], parts = [[0, 2, k, c, slip, limits[0]], [2, 4, k * size * size, c * size * size, turn.slice(0, 2), limits[1]], [4, 5, k * size * size, c * size * size, turn.slice(2), limits[2]]];
    for (const [first, end, stiff, loss, u, most] of states > 2 ? parts : parts.slice(0, 1)) {
      const x = own.subarray(state + first, state + end), {force, rate} = gripped(stiff, loss, Array.from(x), u, most);
      ownRate.set(rate, state + first), found.push(force);
      x.forEach((deflection, j) => ((stored += 0.5 * stiff * deflection * deflection), (power += stiff * deflection * rate[j])));
    }
    return {friction: found[0], moment: states > 2 ? [...found[1], ...found[2]] : ZERO};
  }
  // Force over that of the linear tyre, and trail over that at rest, at a linear force of q times the grip
  function brush(q) {
    if (q >= 1.5) return [1 / q, 0];
    const s = q / (1 - q / 3), rest = 1 - s / 3, adhesion = 1 - s / 3 + (s * s) / 27;
    return [adhesion / (1 - q / 3), (rest * rest * rest) / adhesion];
  }
  const share = (k, load) => Math.max(1 - k * (load - 1), 0.1); // of a coefficient that a load leaves
  const laws = {
    Contact(p) {
      const [i, k] = p.body, a = bodies[i], z = bodies[k], A = columns(a, p.frame[0]), normal = A[2];
      const q = spread(p.radii, columns(z, p.frame[1]), normal), low = sub(scale(-1 / Math.sqrt(dot(normal, q) + 1e-300), q), scale(p.tube, normal));
      const place = add(point(z, arm(z, p.point[1])), low), gap = dot(normal, sub(place, point(a, arm(a, p.point[0]))));
      const onA = sub(place, a.r), onB = sub(place, z.r), slip = intoAxes(A, sub(velocity(z, onB), velocity(a, onA))), turn = intoAxes(A, sub(z.w, a.w));
      const depth = Math.max(-gap, 0), elastic = gap < 0 ? p.stiffness * depth ** p.exponent : 0;
      const N = gap < 0 ? Math.max(elastic * (1 - p.loss * slip[2]) - p.damping * slip[2], 0) : 0;
      const {friction, moment} = rubbing(p, N, slip.slice(0, 2), turn);
      stored += (elastic * depth) / (p.exponent + 1);
      power -= (elastic - N) * slip[2] + friction[0] * slip[0] + friction[1] * slip[1] + dot(moment, turn);
      const force = outOfAxes(A, [-friction[0], -friction[1], N]), couple = outOfAxes(A, moment);
      pushAt(k, force, onB), push(k, ZERO, scale(-1, couple)), pushAt(i, scale(-1, force), onA), push(i, ZERO, couple);
    },
    Tyre(p, t) {
      const [i, k] = p.body, ground = bodies[i], wheel = bodies[k], [, , n] = columns(ground, p.frame[0]), [axle] = columns(wheel, p.frame[1]);
      const lean = dot(axle, n), level = 1 / Math.sqrt(1 - lean * lean), ahead = scale(level, cross(axle, n)), left = cross(n, ahead);
      const hub = arm(wheel, p.point[1]), lowest = add(hub, scale(p.ring * level, sub(scale(lean, axle), n)));
      const height = dot(sub(point(wheel, lowest), point(ground, arm(ground, p.point[0]))), n);
      const s = sub(lowest, scale(height, n)), onGround = sub(point(wheel, s), ground.r), there = velocity(ground, onGround);
      const v = sub(velocity(wheel, s), there), w = sub(wheel.w, ground.w), speed = dot(sub(velocity(wheel, hub), there), ahead);
      const slipX = dot(v, ahead), slipY = dot(v, left), climb = dot(v, n), sink = p.crown - height, spring = sink > 0 ? p.stiffness * sink : 0;
      const N = sink > 0 ? Math.max(spring - p.damping * climb, 0) : 0, load = N / p.nominal_load, left3 = share(p.stiffness_sensitivity, load);
      const Cx = left3 * p.longitudinal, Cy = left3 * p.cornering, Cg = left3 * p.camber, V = Math.abs(speed), limited = p.signal[0] >= 0;
      const grip = limited ? Math.max(signal(p.signal[0], t)[0], 0.01) * share(p.grip_sensitivity, load) : Infinity;
      const [zx, zy] = [own[p.state], own[p.state + 1]], sliding = limited ? Math.hypot(Cx * slipX, Cy * slipY) / (3 * grip) : 0;
      const lagging = p.option ? 0 : 1;
      ownRate[p.state] = (-slipX - (V + sliding) * zx) / p.relaxation_x;
      ownRate[p.state + 1] = (-slipY - ((lagging * V * Cg) / Cy) * lean - (V + sliding) * zy) / p.relaxation;
      const standing = p.standing_damping / (1 + (speed / p.standing_speed) ** 2), pullX = Cx * zx - standing * slipX, pullY = Cy * zy - standing * slipY;
      const q = limited ? Math.hypot(pullX, pullY) / grip : 0, [part, trail] = limited ? brush(q) : [1, 1];
      const Fx = N * part * pullX, Fy = N * (part * pullY - (1 - lagging) * Cg * lean), bySlip = N * part * (pullY + lagging * Cg * lean);
      const Mz = Math.tanh(speed / 0.01) * (N * p.twisting * lean - p.trail * trail * bySlip), reach = sub(s, hub), radius = Math.sqrt(dot(reach, reach));
      const My = -p.rolling_resistance * N * radius * Math.tanh((dot(w, axle) * radius) / 0.05);
      const F = add(scale(N, n), add(scale(Fx, ahead), scale(Fy, left))), M = add(scale(My, left), scale(Mz, n));
      pushAt(k, F, s), pushAt(i, scale(-1, F), onGround), push(k, ZERO, M), push(i, ZERO, scale(-1, M));
      (stored += 0.5 * spring * sink * (sink > 0)), (power += dot(F, v) + dot(M, w) - spring * climb);
    },
    SpringDamper(p) {
      const [i, k] = p.body, sa = arm(bodies[i], p.point[0]), sb = arm(bodies[k], p.point[1]);
      const gap = sub(point(bodies[k], sb), point(bodies[i], sa)), length = Math.sqrt(dot(gap, gap)), along = scale(1 / (length || 1), gap);
      const stretch = length - p.length, speed = dot(along, sub(velocity(bodies[k], sb), velocity(bodies[i], sa)));
      const pull = scale(p.stiffness * stretch + p.damping * speed, along);
      pushAt(i, pull, sa), pushAt(k, scale(-1, pull), sb);
      (stored += 0.5 * p.stiffness * stretch * stretch), (power -= p.damping * speed * speed);
    },
    TorsionSpring(p, t) {
      alongCoordinate(p, t, (x, rate) => {
        const stretch = x - p.angle;
        (stored += 0.5 * p.stiffness * stretch * stretch), (power -= p.damping * rate * rate);
        return -p.stiffness * stretch - p.damping * rate;
      });
    },
    JointFriction(p, t) {
      alongCoordinate(p, t, (x, rate) => {
        const load = -p.coulomb * Math.tanh(rate / p.transition) - p.viscous * rate;
        power += load * rate;
        return load;
      });
    },
    Torque(p, t) {
      const load = given(p, t);
      push(p.body[1], ZERO, load), (power += dot(load, bodies[p.body[1]].w));
    },
    Force(p, t) {
      const load = given(p, t), body = bodies[p.body[1]], s = arm(body, p.point[1]);
      pushAt(p.body[1], load, s), (power += dot(load, velocity(body, s)));
    },
    AeroDrag(p, t) {
      const body = bodies[p.body[1]], s = arm(body, p.point[1]), v = sub(velocity(body, s), components(p, t));
      const force = scale(-0.5 * p.density * p.drag_area * Math.sqrt(dot(v, v)), v);
      pushAt(p.body[1], force, s), (power += dot(force, velocity(body, s)));
    },
    Weight(p) {
      const body = bodies[p.body[1]], g = outOfAxes(columns(bodies[p.body[0]], p.frame[0]), p.acceleration);
      const pull = scale(model.body[p.body[1]].mass, g);
      pushAt(p.body[1], pull, body.s), (power += dot(pull, velocity(body, body.s)));
    },
    CentralGravity(p) {
      const [i, k] = p.body, a = bodies[i], z = bodies[k], {inertia, mass} = model.body[k], sa = arm(a, p.point[0]);
      const reach = sub(point(z, z.s), point(a, sa)), r = Math.sqrt(dot(reach, reach)), way = scale(1 / r, reach);
      const In = rotate(z.R, rotate(inertia, rotateBack(z.R, way))), along = dot(way, In), trace = inertia[0] + inertia[4] + inertia[8], f = p.mu / (r * r);
      const pull = add(scale(-f * (mass + (1.5 * (trace - 5 * along)) / (r * r)), way), scale((-3 * f) / (r * r), In));
      pushAt(k, pull, z.s), push(k, ZERO, scale((3 * f) / r, cross(way, In))), pushAt(i, scale(-1, pull), sa);
      stored -= f * r * (mass + (0.5 * (trace - 3 * along)) / (r * r));
    },
    Bushing(p) {
      const [i, k] = p.body, a = bodies[i], z = bodies[k], A = columns(a, p.frame[0]), B = columns(z, p.frame[1]);
      const sb = arm(z, p.point[1]), reach = sub(point(z, sb), a.r), K = p.turning_stiffness;
      const x = intoAxes(A, sub(reach, arm(a, p.point[0]))), rate = intoAxes(A, sub(velocity(z, sb), velocity(a, reach))), w = intoAxes(A, sub(z.w, a.w));
      const D = A.map((one) => B.map((other) => dot(one, other))), rest = 1 - D[0][0] - D[1][1] - D[2][2]; // axes of b in a
      const away = [D[2][1] - D[1][2], D[0][2] - D[2][0], D[1][0] - D[0][1]], mixed = [D[1][2] + D[2][1], D[2][0] + D[0][2], D[0][1] + D[1][0]];
      const squares = away.map((value, j) => (rest < 0 ? (value * value) / (2 - rest) : rest + 2 * D[j][j]));
      const across = [(K[2] - K[1]) * mixed[0], (K[0] - K[2]) * mixed[1], (K[1] - K[0]) * mixed[2]];
      const Kx = tied(p.stiffness, x), Cx = tied(p.damping, rate), Cw = tied(p.turning_damping, w);
      const force = outOfAxes(A, scale(-1, add(Kx, Cx))), moment = outOfAxes(A, sub(scale(-0.5, add(tied(K, away), across)), Cw));
      pushAt(k, force, sb), pushAt(i, scale(-1, force), reach), push(k, ZERO, moment), push(i, ZERO, scale(-1, moment));
      (stored += 0.5 * dot(x, Kx) + 0.5 * dot(K, squares)), (power -= dot(rate, Cx) + dot(w, Cw));
    },
  };
  function loads(t) {
    Q.fill(0), (stored = 0), (power = 0);
    for (let i = 0; i < n; i++) {
      const {mass, inertia} = model.body[i], {R, s, w, own, r} = bodies[i], weight = scale(mass, model.gravity);
      bodies[i].spin = terms.gyroscopic ? cross(own, rotate(inertia, own)) : ZERO; // in body axes: no rounding of R R'
      const pull = terms.centripetal ? scale(mass, turning(w, s)) : ZERO;
      pushAt(i, weight, s), (stored -= dot(weight, add(r, s)));
      write(h, 6 * i, pull), write(h, 6 * i + 3, add(rotate(R, bodies[i].spin), cross(s, pull)));
    }
    ownRate.fill(0);
    model.force.forEach((p, i) => {
      const o = 6 * p.body[1], before = from(Q, o);
      laws[p.law](p, t), (pushes[i] = sub(from(Q, o), before));
    });
  }

  // ---- the saddle point

  const touching = bodies.map(() => []); // of each body: a row, place of its block in J, the next row, ...
  model.row.forEach(({body}, k) => body.forEach((i, slot) => i >= 0 && i < n && touching[i].push(k, 24 * k + 6 * slot)));
  const driven = model.row.flatMap(({drive}, k) => (drive >= 0 ? [k] : [])), units = Float64Array.from(model.row, ({holonomic, scale: unit}) => holonomic * unit);
  const first = Int32Array.from({length: rows}, (_, k) => k); // first column of each line of S that is not zero
  for (const list of touching) for (let x = 0; x < list.length; x += 2) for (let z = 0; z < list.length; z += 2) {
    first[list[x]] = Math.min(first[list[x]], list[z]);
  }
  const MJ = new Float64Array(24 * rows), S = new Float64Array(rows * rows), L = new Float64Array(rows * rows);
  const right = new Float64Array(rows), rest = new Float64Array(rows);
  const MU = 1e-9; // [1] of the diagonal, added to it so that rows may repeat others; iterations take it away again

  // out = M_i^-1 x of (force, moment about O) in x, both at their places
  function yields(i, x, o, out, p) {
    const {R, s} = bodies[i], force = from(x, o), moment = sub(from(x, o + 3), cross(s, force));
    const alpha = rotate(R, rotate(inverses[i], rotateBack(R, moment)));
    write(out, p, add(scale(1 / masses[i], force), cross(s, alpha))), write(out, p + 3, alpha);
  }
  function factor() {
    S.fill(0);
    for (let i = 0; i < n; i++) {
      const list = touching[i];
      for (let x = 0; x < list.length; x += 2) {
        const k = list[x], o = list[x + 1];
        yields(i, J, o, MJ, o);
        for (let z = 0; z < list.length; z += 2) {
          const l = list[z], p = list[z + 1];
          if (l > k) continue;
          S[k * rows + l] += MJ[o] * J[p] + MJ[o + 1] * J[p + 1] + MJ[o + 2] * J[p + 2] + MJ[o + 3] * J[p + 3] + MJ[o + 4] * J[p + 4] + MJ[o + 5] * J[p + 5];
        }
      }
    }
    for (let k = 0; k < rows; k++) {
      const line = k * rows, mu = MU * S[line + k];
      let pivot = S[line + k] + mu;
      for (let l = first[k]; l < k; l++) {
        const other = l * rows;
        let v = S[line + l];
        for (let j = Math.max(first[k], first[l]); j < l; j++) v -= L[line + j] * L[other + j];
        (v *= L[other + l]), (L[line + l] = v), (pivot -= v * v);
      }
      L[line + k] = 1 / Math.sqrt(Math.max(pivot, 1e-3 * mu));
    }
  }
  function substitute(x) {
    for (let k = 0; k < rows; k++) {
      for (let j = first[k]; j < k; j++) x[k] -= L[k * rows + j] * x[j];
      x[k] *= L[k * rows + k];
    }
    for (let k = rows - 1; k >= 0; k--) {
      x[k] *= L[k * rows + k];
      for (let j = first[k]; j < k; j++) x[j] -= L[k * rows + j] * x[k];
    }
  }
  function largest(x) {
    let most = 0;
    for (let k = 0; k < x.length; k++) most = Math.max(most, Math.abs(x[k]));
    return most;
  }
  // lam with S lam = right
  function multipliers() {
    const goal = largest(right);
    lam.fill(0), rest.set(right);
    for (let sweep = 0; sweep < 4; sweep++) {
      substitute(rest);
      for (let k = 0; k < rows; k++) lam[k] += rest[k];
      rest.set(right);
      for (let k = 0; k < rows; k++) for (let l = first[k]; l <= k; l++) {
        const s = S[k * rows + l];
        rest[k] -= s * lam[l];
        if (l < k) rest[l] -= s * lam[k];
      }
      if (!(largest(rest) > 1e-15 * goal)) return;
    }
  }
  function react(x) { // x -= M^-1 J' lam
    for (let i = 0; i < n; i++) for (let z = 0; z < touching[i].length; z += 2) {
      const l = lam[touching[i][z]], o = touching[i][z + 1];
      for (let j = 0; j < 6; j++) x[6 * i + j] -= MJ[o + j] * l;
    }
  }
  function times(x) { // right = J x
    right.fill(0);
    for (let i = 0; i < n; i++) for (let z = 0; z < touching[i].length; z += 2) {
      const o = touching[i][z + 1], p = 6 * i;
      right[touching[i][z]] += J[o] * x[p] + J[o + 1] * x[p + 1] + J[o + 2] * x[p + 2] + J[o + 3] * x[p + 3] + J[o + 4] * x[p + 4] + J[o + 5] * x[p + 5];
    }
  }
  const work6 = new Float64Array(6 * n), load6 = new Float64Array(6 * n), carried = new Float64Array(6 * n), turned = bodies.map(() => ZERO);
  // Accelerations and multipliers under the loads at hand; Euler's term alone in body axes, and about G it moves O
  function solveLoads() {
    for (let i = 0; i < n; i++) {
      const o = 6 * i, alpha = rotate(bodies[i].R, turned[i]);
      yields(i, load6, o, acceleration, o);
      write(acceleration, o, add(from(acceleration, o), cross(bodies[i].s, alpha)));
      write(work6, o, from(acceleration, o)), write(work6, o + 3, add(from(acceleration, o + 3), alpha));
    }
    times(work6);
    for (let k = 0; k < rows; k++) right[k] -= gamma[k];
    multipliers(), react(acceleration);
  }
  // The loads that would move what was added to a light body as it moves; returns by how much they are others than before.
  function carry() {
    let change = 0;
    for (const i of light) {
      const o = 6 * i, {R, s} = bodies[i], alpha = add(from(acceleration, o + 3), rotate(R, turned[i]));
      const force = scale(little, add(from(acceleration, o), cross(alpha, s))), moment = add(cross(s, force), scale(turned3, alpha));
      for (let j = 0; j < 3; j++) {
        change = Math.max(change, Math.abs(force[j] - carried[o + j]) * model.length, Math.abs(moment[j] - carried[o + 3 + j]));
        (load6[o + j] += force[j] - carried[o + j]), (load6[o + 3 + j] += moment[j] - carried[o + 3 + j]);
      }
      write(carried, o, force), write(carried, o + 3, moment);
    }
    return change;
  }
  // dy at (t, y); `ready`: the factor at hand is that of y
  function evaluate(t, y, dy, ready = false) {
    count.evaluations++;
    kinematics(y), fillRows(t), loads(t);
    if (!ready) factor();
    for (let i = 0; i < n; i++) {
      const {s, spin} = bodies[i], o = 6 * i, pull = from(h, o);
      turned[i] = rotate(inverses[i], scale(-1, spin));
      write(load6, o, sub(from(Q, o), pull)), write(load6, o + 3, sub(from(Q, o + 3), cross(s, pull)));
    }
    solveLoads(), carried.fill(0);
    for (let sweep = 0, first = 0, change; light.length && sweep < 12; sweep++) {
      if (!((change = carry()) > 1e-11 * (first ||= change))) break;
      solveLoads();
    }
    for (const k of driven) power -= lam[k] * b[k];
    for (let i = 0; i < n; i++) {
      const q = 7 * i, u = 7 * n + 6 * i, {R, w, e, v} = bodies[i], alpha = from(acceleration, 6 * i + 3);
      write(dy, q, v), write4(dy, q + 3, quaternionRate(e, w));
      write(dy, u, from(acceleration, 6 * i)), write(dy, u + 3, add(rotateBack(R, alpha), turned[i]));
      write(acceleration, 6 * i + 3, add(alpha, rotate(R, turned[i])));
    }
    (dy[WORK] = power), dy.set(ownRate, OWN);
  }
  function write4(x, o, e) {
    (x[o] = e[0]), (x[o + 1] = e[1]), (x[o + 2] = e[2]), (x[o + 3] = e[3]);
  }
  const quaternionRate = (e, w) => [
    0.5 * (-e[1] * w[0] - e[2] * w[1] - e[3] * w[2]), 0.5 * (e[0] * w[0] + e[3] * w[1] - e[2] * w[2]),
    0.5 * (-e[3] * w[0] + e[0] * w[1] + e[1] * w[2]), 0.5 * (e[2] * w[0] - e[1] * w[1] + e[0] * w[2]),
  ];
  // e of y turned by a small rotation, of length 1 again
  function turnBody(y, q, turn) {
    const o = q + 3, e = [y[o], y[o + 1], y[o + 2], y[o + 3]], rate = quaternionRate(e, turn).map((x, j) => e[j] + x);
    const norm = Math.sqrt(rate[0] ** 2 + rate[1] ** 2 + rate[2] ** 2 + rate[3] ** 2);
    write4(y, o, rate.map((x) => x / norm));
  }

  // ---- projection onto c = 0 and J v = b, in the metric of M; the factor left behind is that of y

  function gapOf() {
    let gap = 0;
    for (let k = 0; k < rows; k++) gap = Math.max(gap, Math.abs(c[k]) * units[k]);
    return gap;
  }
  function project(t, y) {
    for (let i = 0; i < n; i++) turnBody(y, 7 * i, ZERO);
    kinematics(y), fillRows(t), factor();
    let gap = gapOf();
    for (let turn = 0; turn < 8 && gap > 2e-14; turn++) {
      right.set(c), work6.fill(0), multipliers(), react(work6);
      for (let i = 0; i < n; i++) {
        for (let j = 0; j < 3; j++) y[7 * i + j] += work6[6 * i + j];
        turnBody(y, 7 * i, from(work6, 6 * i + 3));
      }
      kinematics(y), fillRows(t), factor();
      const before = gap;
      if ((gap = gapOf()) > 0.25 * before) break;
    }
    for (let i = 0; i < n; i++) write(work6, 6 * i, bodies[i].v), write(work6, 6 * i + 3, bodies[i].w);
    times(work6);
    for (let k = 0; k < rows; k++) right[k] -= b[k];
    work6.fill(0), multipliers(), react(work6);
    for (let i = 0; i < n; i++) {
      const u = 7 * n + 6 * i, turned = rotateBack(bodies[i].R, from(work6, 6 * i + 3));
      for (let j = 0; j < 3; j++) (y[u + j] += work6[6 * i + j]), (y[u + 3 + j] += turned[j]);
    }
    return gap;
  }
  function kinetic() {
    return model.body.reduce((sum, {mass, inertia}, i) => {
      const {own, s} = bodies[i], v = velocity(bodies[i], s);
      return sum + 0.5 * mass * dot(v, v) + 0.5 * dot(own, rotate(inertia, own));
    }, 0);
  }
  const energy = (y) => kinetic() + stored - y[WORK]; // constant along a run

  // ---- a run: `seen(k, t)` is called at each of the `wanted` times; advance(ms) goes on for so long, false at the end

  function start(wanted, seen, rtol = 1e-9) {
    const {A, B, C, E3, E5} = method, stages = B.length, K = Array.from({length: stages}, () => new Float64Array(size));
    const y = new Float64Array(size), z = new Float64Array(size), sum = new Float64Array(size), span = wanted[wanted.length - 1] - wanted[0];
    const run = {t: wanted[0], next: 0, gap: 0, drift: 0, scale: 1e-300, failed: "", y, count};
    let speed = (1e-2 * model.length) / span, spin = 1e-2 / span, h = 0, wait = false;
    y.set(model.start.q), y.set(model.state.map((x) => x.start), OWN);
    Object.assign(count, {steps: 0, rejected: 0, evaluations: 0});
    model.coordinate.forEach((x, i) => ((last[i].value = x.start), (last[i].rate = 0)));
    (lastTime = run.t), kinematics(y);
    for (let i = 0; i < n; i++) {
      const v = model.start.v.slice(6 * i, 6 * i + 6);
      y.set(v.slice(0, 3), 7 * n + 6 * i), y.set(rotateBack(bodies[i].R, v.slice(3)), 7 * n + 6 * i + 3);
    }
    function combine(weights, step) {
      sum.fill(0);
      for (let j = 0; j < weights.length; j++) {
        const factor = step * weights[j], rates = K[j];
        if (factor !== 0) for (let i = 0; i < size; i++) sum[i] += factor * rates[i];
      }
    }
    function trial(weights, step) {
      combine(weights, step);
      for (let i = 0; i < size; i++) z[i] = y[i] + sum[i];
    }
    function square(o, many) {
      let total = 0;
      for (let i = o; i < o + many; i++) total += sum[i] * sum[i];
      return total;
    }
    // Of the worst body: turns, places in lengths of the model, speeds in the largest ones; of the work a thousandth
    function norm(weights, step) {
      combine(weights, step);
      let worst = (1e-3 * sum[WORK] / (total * speed * speed)) ** 2;
      for (let i = 0; i < n; i++) {
        const q = 7 * i, u = 7 * n + 6 * i;
        worst = Math.max(worst, square(q, 3) / model.length ** 2, 4 * square(q + 3, 4), square(u, 3) / speed ** 2, square(u + 3, 3) / spin ** 2);
      }
      model.state.forEach(({unit, power}, j) => (worst = Math.max(worst, (sum[OWN + j] / (unit * speed ** power)) ** 2)));
      return Number.isFinite(worst) ? worst : Infinity;
    }
    function accept(t, gap) { // y and K[0] are those of t
      (run.t = t), remember(t);
      for (const {v, w} of bodies) (spin = Math.max(spin, Math.hypot(...w))), (speed = Math.max(speed, Math.hypot(...v)));
      (speed = Math.max(speed, model.length * spin)), (run.gap = Math.max(run.gap, gap));
      const now = energy(y);
      if (model.driven) run.drift = NaN; // poses are found one by one, without the work between them
      else if (run.first === undefined) run.first = now;
      else run.drift = Math.max(run.drift, Math.abs(now - run.first));
      run.scale = Math.max(run.scale, kinetic(), Math.abs(y[WORK]));
      if (wanted[run.next] <= t) seen(run.next++, t);
    }
    function settle(t) {
      const gap = project(t, y);
      evaluate(t, y, K[0], true), accept(t, gap);
    }
    // All rows hold positions and nothing is left free: each pose is found from a guess by the last one.
    function follow(t) {
      const step = t - run.t;
      for (let i = 0; i < n; i++) {
        const q = 7 * i, u = 7 * n + 6 * i, mean = [0, 1, 2].map((j) => step * (y[u + 3 + j] + 0.5 * step * K[0][u + 3 + j]));
        for (let j = 0; j < 3; j++) y[q + j] += step * (y[u + j] + 0.5 * step * K[0][u + j]);
        turnBody(y, q, rotate(bodies[i].R, mean));
        for (let j = 0; j < 6; j++) y[u + j] += step * K[0][u + j];
      }
      count.steps++, settle(t);
      if (!(run.gap < 1e-9)) run.failed = "the loops do not close there";
    }
    function step(end) {
      const near = run.t + 1.01 * h >= end, length = near ? end - run.t : h, {t} = run;
      for (let g = 1; g < stages; g++) trial(A[g], length), evaluate(t + C[g] * length, z, K[g]);
      trial(B, length);
      const e5 = norm(E5, length), e3 = norm(E3, length), error = e5 === 0 ? 0 : e5 / Math.sqrt(e5 + 0.01 * e3) / (0.2 * rtol);
      const factor8 = error === 0 ? 6 : Math.min(wait ? 1 : 6, Math.max(0.2, 0.75 * error ** -0.125));
      if (!(error <= 1)) {
        count.rejected++, (h = length * (Number.isFinite(error) ? Math.min(factor8, 0.9) : 0.2)), (wait = true);
        if (h < 1e-12 * span || count.rejected > 1e5) run.failed = "the steps become too short there";
        return;
      }
      y.set(z), count.steps++;
      if (!near || factor8 < 1) h = length * factor8;
      else h = Math.max(h, length * factor8);
      (wait = false), settle(near ? end : t + length);
    }
    settle(run.t);
    const rates = K[0].subarray(7 * n), rough = rates.reduce((most, x, j) => (j < 6 * n ? Math.max(most, Math.abs(x) / (j % 6 < 3 ? speed : spin)) : most), 0);
    h = Math.min(span, (0.5 * rtol ** 0.125) / Math.max(spin, rough, speed / model.length));
    run.advance = (budget) => {
      const began = performance.now();
      while (run.next < wanted.length && !run.failed) {
        if (performance.now() - began > budget) return true;
        if (model.driven) follow(wanted[run.next]);
        else step(wanted[run.next]);
      }
      return false;
    };
    return run;
  }

  // All terms at a state, for tests and readings: multipliers and accelerations are those of the last evaluation.
  function at(t, y) {
    const dy = new Float64Array(size);
    (lastTime = t), model.coordinate.forEach((x, i) => ((last[i].value = x.start), (last[i].rate = 0)));
    evaluate(t, y, dy);
    return {c, J, b, gamma, Q, h, lam, acceleration, stored, power, dy, ownRate};
  }
  return {start, at, bodies, J, lam, last, pushes, size, evaluate, project, energy, kinetic, get stored() { return stored; }};
}

function inverse3([a, b, c, d, e, f, g, h, i]) {
  const det = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g);
  return [e * i - f * h, c * h - b * i, b * f - c * e, f * g - d * i, a * i - c * g, c * d - a * f, d * h - e * g, b * g - a * h, a * e - b * d].map((x) => x / det);
}
