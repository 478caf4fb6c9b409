"""Random mechanisms in a plane with friction from loads, stops, freewheels, clutches and rows that switch.

Chains on the ground or on a cart, slider-cranks, four-bars and cranks in a swinging guide. The second formulation has
three coordinates a body and all joints as rows, with accelerations and loads by a nested solve: friction by passes,
what sticks, slips or holds by trying all senses. Nothing of the package stands in it.
"""

from dataclasses import dataclass, field
from itertools import combinations, product
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import null_space

from mbsd3d import (
    GROUND,
    Body,
    Clutch,
    Cylindrical,
    Distance,
    DryFriction,
    EndStop,
    Force,
    Freewheel,
    Gear,
    JointFriction,
    PointOnLine,
    Prismatic,
    Revolute,
    Sine,
    Switched,
    System,
    Torque,
    measures,
    rotation,
)
from mbsd3d.rotations import matrix

GRAVITY = 9.81
AWAY = 1e-7  # [s] after an event without a look at conditions
SLOW = 1e-9  # [rad/s, m/s] of a rate that counts as none
PASSED = 1e-10  # [rad/s, m/s] by which a rate passes zero where it ends a slip: rounding does not
CLOSE = 1e-9  # [rad, m] of a stop that is touched
BALANCED = 1e-6  # [1] of the accelerations by other shares: one below 0 by less is 0
DEAD = 1e-6  # [1] of the rate of a joint over those of the motion: it stands at a dead centre
EXACT = dict(method="DOP853", rtol=1e-10, atol=1e-12, max_step=0.04)
EVALUATIONS_MAX = 4000  # of a piece between two events: more where rows are all but dependent
PASSES = 400  # of friction; a gain of 0.9 takes 250
STEP = 1e-30  # [s] of the complex derivative
ORIGIN = np.array([0.7, -1.3, 0.4])
AXES = matrix(rotation((0.3, -0.5, 0.8), 1.1))
PIN, GUIDE = "pin", "guide"


class Undecided(Exception):  # noqa: N818
    """The second formulation does not say what happens."""


@dataclass
class Pair:
    """A joint between links a and b (-1: the ground) at a point of the plane; guides have a direction in a."""

    kind: str
    a: int
    b: int
    at: np.ndarray
    along: float = 0.0  # rad
    size: float = 0.0  # radius of the pin; length of the guide, 0: it presses by the force across alone
    mu: float = 0.0
    static: float = 0.0
    preload: float = 0.0
    viscous: float = 0.0
    clutch: float = 0.0  # N m or N
    stop: tuple | None = None  # (lower, upper, restitution)
    wheel: bool = False
    plain: bool = False  # a pin that holds its point in the plane, no more: the loop is closed without repeated rows

    @property
    def rubs(self):
        return self.mu > 0.0 or self.clutch > 0.0


class Latch(NamedTuple):
    """A row that engages where coordinate k passes a value in a sense, and lets go where it passes another one."""

    kind: str  # "distance" or "gear"
    first: int  # link, or joint of the gear
    second: int
    points: tuple  # on the first and on the second link
    ratio: float
    engage: tuple  # (coordinate, value, sense)
    release: tuple


@dataclass
class Plane:
    """A mechanism: links (mass, inertia, com (2,), place (2,)), joints, loads and the rates of its freedoms."""

    kind: str
    links: list
    pairs: list
    loads: list  # (link, "torque" or 0 or 1 for a force along x or y, amplitude, frequency, phase)
    rates: dict
    latches: list = field(default_factory=list)


def friction_of(rng, kind):
    mu = float(rng.uniform(0.08, 0.35))
    size = rng.uniform(0.01, 0.05) if kind == PIN else float(rng.choice([0.0, rng.uniform(0.25, 0.4)]))
    static = mu * float(rng.choice([1.0, 1.0, rng.uniform(1.05, 1.5)]))
    preload, viscous = (
        float(rng.choice([0.0, 0.0, rng.uniform(1.0, 20.0)])),
        float(rng.choice([0.0, rng.uniform(0, 0.1)])),
    )
    return dict(mu=mu, static=static, size=size, preload=preload, viscous=viscous)


def random_link(rng, start, end):
    """Return a link between two points, its centre of mass beside the line."""
    along = end - start
    aside = np.array([-along[1], along[0]])
    com = rng.uniform(0.2, 0.8) * along + rng.uniform(-0.2, 0.2) * aside
    return float(rng.uniform(0.5, 2.0)), float(rng.uniform(0.01, 0.06)), com, start


def random_plane(seed):
    """Return a mechanism of one of four kinds."""
    rng = np.random.default_rng([seed, 33])
    kind = str(rng.choice(["chain", "chain", "slider-crank", "four-bar", "swinging guide"]))
    found = {"chain": chain, "slider-crank": slider_crank, "four-bar": four_bar, "swinging guide": swinging}[kind](rng)
    add_switches(rng, found)
    return found


def chain(rng):
    count, links, pairs, at, before = int(rng.integers(1, 4)), [], [], np.zeros(2), -1
    if rng.random() < 0.4:
        links.append((float(rng.uniform(1, 3)), 0.1, rng.uniform(-0.1, 0.1, 2), at))
        pairs.append(Pair(GUIDE, -1, 0, at, float(rng.uniform(-0.3, 0.3)), **friction_of(rng, GUIDE)))
        before = 0
    for _ in range(count):
        turn, length = rng.uniform(-2.2, -0.9), rng.uniform(0.3, 0.6)
        end = at + length * np.array([np.cos(turn), np.sin(turn)])
        pairs.append(Pair(PIN, before, len(links), at, **friction_of(rng, PIN)))
        before = len(links)
        links.append(random_link(rng, at, end))
        at = end
    rates = {k: float(rng.choice([0.0, rng.uniform(-6, 6), rng.uniform(-6, 6)])) for k in range(len(pairs))}
    return Plane("chain", links, pairs, random_loads(rng, len(links)), rates)


def random_loads(rng, count):
    found = [(int(rng.integers(count)), "torque", rng.uniform(1, 8), rng.uniform(0.3, 2), rng.uniform(0, 6))]
    if rng.random() < 0.5:
        found.append((int(rng.integers(count)), int(rng.integers(2)), rng.uniform(2, 20), rng.uniform(0.3, 2), 1.0))
    return found


def slider_crank(rng):
    r, l, turn, tilt = rng.uniform(0.1, 0.2), rng.uniform(0.35, 0.6), rng.uniform(-3, 3), rng.uniform(-1, 1)
    pin = r * np.array([np.cos(turn), np.sin(turn)])
    way, off = (
        np.array([np.cos(tilt), np.sin(tilt)]),
        rng.uniform(-0.05, 0.05) * np.array([-np.sin(tilt), np.cos(tilt)]),
    )
    b = way @ (off - pin)
    end = off + way * (-b + np.sqrt(b * b - (off - pin) @ (off - pin) + l * l))
    links = [random_link(rng, np.zeros(2), pin), random_link(rng, pin, end)]
    links.append((float(rng.uniform(0.5, 2)), 0.02, rng.uniform(-0.05, 0.05, 2), end))
    pairs = [Pair(PIN, -1, 0, np.zeros(2), **friction_of(rng, PIN)), Pair(PIN, 0, 1, pin, **friction_of(rng, PIN))]
    pairs += [Pair(PIN, 1, 2, end, **friction_of(rng, PIN)), Pair(GUIDE, -1, 2, end, tilt, **friction_of(rng, GUIDE))]
    if rng.random() < 0.5:
        pairs[2] = Pair(PIN, 1, 2, end, plain=True)
    else:
        pairs[3].size = pairs[3].viscous = 0.0  # a bore that holds no moment along it leaves it open
    return Plane("slider-crank", links, pairs, loop_loads(rng, 3), {0: float(rng.uniform(-12, 12))})


def four_bar(rng):
    turn, r, l, rocker, base = (
        rng.uniform(-3, 3),
        rng.uniform(0.1, 0.2),
        rng.uniform(0.4, 0.6),
        rng.uniform(0.3, 0.5),
        0.5,
    )
    pin, far = r * np.array([np.cos(turn), np.sin(turn)]), base * np.array([np.cos(0.3), np.sin(0.3)])
    d = far - pin
    x = (d @ d + l * l - rocker * rocker) / (2 * np.linalg.norm(d))
    ahead = d / np.linalg.norm(d)
    end = pin + x * ahead + np.sqrt(max(l * l - x * x, 1e-3)) * np.array([-ahead[1], ahead[0]])
    links = [random_link(rng, np.zeros(2), pin), random_link(rng, pin, end), random_link(rng, far, end)]
    pairs = [Pair(PIN, -1, 0, np.zeros(2), **friction_of(rng, PIN)), Pair(PIN, 0, 1, pin, **friction_of(rng, PIN))]
    pairs += [Pair(PIN, 1, 2, end, plain=True), Pair(PIN, -1, 2, far, **friction_of(rng, PIN))]
    return Plane("four-bar", links, pairs, loop_loads(rng, 3), {0: float(rng.uniform(-12, 12))})


def swinging(rng):
    turn, r = rng.uniform(-3, 3), rng.uniform(0.1, 0.2)
    pin, far = r * np.array([np.cos(turn), np.sin(turn)]), np.array([0.45, rng.uniform(-0.1, 0.1)])
    way = pin - far
    links = [random_link(rng, np.zeros(2), pin), (float(rng.uniform(0.3, 1)), 0.01, rng.uniform(-0.03, 0.03, 2), pin)]
    links.append(random_link(rng, far, far + 1.5 * way))
    pairs = [Pair(PIN, -1, 0, np.zeros(2), **friction_of(rng, PIN)), Pair(PIN, 0, 1, pin, plain=True)]
    pairs.append(Pair(GUIDE, 2, 1, pin, float(np.arctan2(way[1], way[0])), **friction_of(rng, GUIDE)))
    pairs.append(Pair(PIN, -1, 2, far, **friction_of(rng, PIN)))
    return Plane("swinging guide", links, pairs, loop_loads(rng, 3), {0: float(rng.uniform(-10, 10))})


def loop_loads(rng, count):
    return [(0, "torque", rng.uniform(4, 20), rng.uniform(0.4, 2), rng.uniform(0, 6)), *random_loads(rng, count)[1:]]


def add_switches(rng, plane):
    """Add stops, freewheels, clutches and a latch to some joints."""
    bounce, loop = float(rng.choice([0.0, 0.4, 0.7])), plane.kind != "chain"
    for k, pair in enumerate(plane.pairs):
        what = rng.random()
        if pair.plain or (loop and k > 0):
            continue
        reach = rng.uniform(0.3, 2.5, 2) if pair.kind == PIN else rng.uniform(0.2, 0.5, 2)
        if what < 0.3:
            pair.stop = (-float(reach[0]), float(reach[1]), bounce)
        elif what < 0.4:
            pair.wheel = True
            plane.rates[k] = abs(plane.rates[k])
        elif what < 0.55:
            pair.clutch = float(rng.uniform(0.5, 4.0))
    for pair in plane.pairs:
        if rng.random() < 0.15 and not pair.plain:
            pair.mu = pair.static = 0.0
    if rng.random() < 0.35:
        plane.latches.append(random_latch(rng, plane))


def random_latch(rng, plane):
    pins = [k for k, pair in enumerate(plane.pairs) if pair.kind == PIN and not pair.plain]
    k = 0 if plane.pairs[0].kind == PIN else 1
    sense = float(np.sign(plane.rates[k])) or 1.0
    engage = (k, sense * float(rng.uniform(0.1, 0.8)), sense)
    release = (k, engage[1] - sense * float(rng.uniform(0.1, 0.4)), -sense)
    if plane.kind == "chain" and len(pins) > 1 and rng.random() < 0.5:
        return Latch(
            "gear", pins[0], pins[1], (), float(rng.choice([-1.0, 1.0]) * rng.uniform(0.4, 2)), engage, release
        )
    b = len(plane.links) - 1
    if plane.kind == "chain" and len(plane.links) > 1:
        a, b = -1, int(rng.integers(1, len(plane.links)))
        points = rng.uniform(-1, 1, 2), plane.links[b][2] + plane.links[b][3] + rng.uniform(-0.1, 0.1, 2)
        return Latch("distance", a, b, points, 0.0, engage, release)
    # a rod that holds all that there is; it lets go where a drive could not reach, so never
    points = rng.uniform(-1, 1, 2), plane.links[b][2] + plane.links[b][3] + rng.uniform(-0.1, 0.1, 2)
    return Latch("distance", -1, b, points, 0.0, engage, release)


# --- the package ---


def there(point):
    return ORIGIN + AXES[:, :2] @ np.asarray(point)


def system_of(plane):
    """Return (system, start, joints) in a slanted plane."""
    bodies, X, n = [], AXES, AXES[:, 2]
    halves = plane.kind == "slider-crank" and not plane.pairs[2].plain
    for k, (mass, inertia, com, place) in enumerate(plane.links):
        share = 0.5 if halves and k == 1 else 1.0
        own = X @ np.diag([0.8 * inertia, 0.7 * inertia, inertia]) @ X.T
        made = [Body(f"link{k}{x}", share * mass, share * own, com=X[:, :2] @ com, position=there(place))
                for x in ("", "b")[: 2 if share < 1.0 else 1]]  # fmt: skip
        bodies.append(made)

    def at(k, last=False):
        return GROUND if k < 0 else bodies[k][-1 if last else 0]

    joints, forces = [], []
    for k, pair in enumerate(plane.pairs):
        a, b, place, name = at(pair.a, True), at(pair.b), there(pair.at), f"x{k}"
        if pair.kind == GUIDE:
            way = X[:, 0] * np.cos(pair.along) + X[:, 1] * np.sin(pair.along)
            kind = Cylindrical if halves else Prismatic
            joints.append(kind(a, b, at=place, axis=way, name=name))
        else:
            joints.append((PointOnLine if pair.plain else Revolute)(a, b, at=place, axis=n, name=name))
        forces += forces_of(pair, joints[-1], k)
    extra = [Prismatic(*bodies[1], at=bodies[1][0].position, axis=n, name="rod")] if halves else []
    for link, what, amplitude, frequency, phase in plane.loads:
        way = n if what == "torque" else X[:, what]
        load = tuple(Sine(amplitude * x, frequency, phase) for x in way)
        forces.append(Torque(bodies[link][0], load) if what == "torque" else Force(bodies[link][0], load))
    switched = [switched_of(latch, joints, at, k) for k, latch in enumerate(plane.latches)]
    system = System(
        [x for made in bodies for x in made], [*joints, *extra, *switched], forces, gravity=-GRAVITY * X[:, 1]
    )
    rates = {joints[k]: rate for k, rate in plane.rates.items()}
    return system, system.assemble(rates=rates), joints


def forces_of(pair, joint, k):
    found = []
    if pair.mu > 0.0:
        size = {} if not pair.size else {"pin_radius" if pair.kind == PIN else "guide_length": pair.size}
        found.append(
            DryFriction(joint, mu=pair.mu, mu_static=pair.static, preload=pair.preload, name=f"friction{k}", **size)
        )
    if pair.viscous:
        found.append(JointFriction(joint, viscous=pair.viscous))
    if pair.stop:
        found.append(EndStop(joint, lower=pair.stop[0], upper=pair.stop[1], restitution=pair.stop[2], name=f"stop{k}"))
    if pair.wheel:
        found.append(Freewheel(joint, name=f"wheel{k}"))
    if pair.clutch:
        found.append(Clutch(joint, torque=pair.clutch, engaged=True, name=f"clutch{k}"))
    return found


def switched_of(latch, joints, at, number):
    if latch.kind == "gear":
        joint = Gear(joints[latch.first], joints[latch.second], ratio=latch.ratio)
    else:
        ends = [there(point) for point in latch.points]
        joint = Distance(at(latch.first), at(latch.second), at_a=ends[0], at_b=ends[1])
    conditions = []
    for k, value, sense in (latch.engage, latch.release):
        x = (measures.angle if joints[k].angle() is not None else measures.slide)(joints[k])
        conditions.append(x > value if sense > 0 else x < value)
    return Switched(joint, engage=conditions[0], release=conditions[1], name=f"latch{number}")


# --- the second formulation ---


class Motion(NamedTuple):
    """Accelerations, loads of the joints by pair, loads of the coordinates that stick."""

    a: np.ndarray
    loads: np.ndarray
    held: dict
    press: np.ndarray  # of each pair


class SecondFormulation:
    """March from event to event, in places of the centres of mass and angles of all links."""

    def __init__(self, plane):
        self.plane, self.n = plane, 3 * len(plane.links)
        self.inertia = np.array([x for mass, I, _, _ in plane.links for x in (mass, mass, I)])
        self.q = np.array([x for _, _, com, place in plane.links for x in (*(com + place), 0.0)])
        self.origins = [com + place for _, _, com, place in plane.links]
        self.t, self.closed, self.lengths = 0.0, {}, {}
        self.senses, self.stuck, self.base, self.line = {}, [], [], None
        self.together, self.known, self.evaluations = False, (None, None), 0
        G, E, _, _ = self.rows(self.q, np.zeros(self.n))
        some = sorted(plane.rates)
        A = np.vstack([G, E[some]])
        self.v = np.linalg.lstsq(A, np.r_[np.zeros(len(G)), [plane.rates[k] for k in some]], rcond=None)[0]
        self.project()
        self.settle()

    # kinematics

    def point(self, q, link, place):
        """Return a point of a link, and its gradient (2, n)."""
        J = np.zeros((2, self.n), q.dtype)
        if link < 0:
            return place + 0.0 * q[:2], J
        x, y = place - self.origins[link]
        c, s = np.cos(q[3 * link + 2]), np.sin(q[3 * link + 2])
        arm = np.array([c * x - s * y, s * x + c * y])
        J[0, 3 * link] = J[1, 3 * link + 1] = 1.0
        J[:, 3 * link + 2] = -arm[1], arm[0]
        return q[3 * link : 3 * link + 2] + arm, J

    def gradients(self, q):
        """Return (G, E, c): rows of joints and latches, of coordinates, and values of the coordinates."""
        G, E, values = [], [], []
        for pair in self.plane.pairs:
            (pa, Ja), (pb, Jb) = self.point(q, pair.a, pair.at), self.point(q, pair.b, pair.at)
            turn = np.zeros(self.n, q.dtype)
            turn[3 * pair.b + 2] = 1.0
            angle = q[3 * pair.b + 2]
            if pair.a >= 0:
                turn[3 * pair.a + 2] = -1.0
                angle = angle - q[3 * pair.a + 2]
            if pair.kind == PIN:
                G += list(Jb - Ja)
                E.append(turn)
                values.append(angle)
                continue
            way = pair.along + (q[3 * pair.a + 2] if pair.a >= 0 else 0.0)
            u, w, d = np.array([np.cos(way), np.sin(way)]), np.array([-np.sin(way), np.cos(way)]), pb - pa
            along, across = u @ (Jb - Ja), w @ (Jb - Ja)
            if pair.a >= 0:
                along[3 * pair.a + 2] += w @ d
                across[3 * pair.a + 2] -= u @ d
            G += [across, turn]
            E.append(along)
            values.append(u @ d)
        for number in self.lengths:
            latch = self.plane.latches[number]
            if latch.kind == "gear":
                G.append(E[latch.second] - latch.ratio * E[latch.first])
                continue
            (pa, Ja), (pb, Jb) = (self.point(q, *x) for x in zip(latch[1:3], latch.points, strict=True))
            d = pb - pa
            G.append(d @ (Jb - Ja) / np.sqrt(d @ d))
        return np.array(G), np.array(E), np.array(values)

    def rows(self, q, v):
        """Return G, E, what G a is, and what is added to E a; the values of the coordinates stand in ``known``."""
        key = (q.tobytes(), v.tobytes(), tuple(self.lengths))
        if self.known[0] != key:
            G, E, x = self.gradients(q + 1j * STEP * v)
            self.known = key, (G.real, E.real, -(G.imag @ v) / STEP, (E.imag @ v) / STEP, x.real)
        return self.known[1][:4]

    def coordinates(self, q, v=None):
        if v is not None and self.known[0] == (q.tobytes(), v.tobytes(), tuple(self.lengths)):
            return self.known[1][4]
        return self.gradients(q)[2]

    def rates(self, q, v):
        return self.rows(q, v)[1] @ v

    # dynamics

    def applied(self, q, v, t, E):
        Q = np.zeros(self.n)
        Q[1::3] = -GRAVITY * self.inertia[1::3]
        for link, what, amplitude, frequency, phase in self.plane.loads:
            Q[3 * link + (2 if what == "torque" else what)] += amplitude * np.sin(2 * np.pi * frequency * t + phase)
        viscous = np.array([pair.viscous for pair in self.plane.pairs])
        return Q - E.T @ (viscous * (E @ v))

    def press(self, loads):
        """Return the size of what presses in each pair, with the lever of its friction."""
        found = np.zeros(len(self.plane.pairs))
        for k, pair in enumerate(self.plane.pairs):
            x, y = loads[2 * k : 2 * k + 2]
            if pair.kind == PIN:
                found[k] = pair.size * (np.hypot(x, y) + pair.preload)
            else:
                found[k] = pair.preload + (max(abs(x), 2.0 * abs(y) / pair.size) if pair.size else abs(x))
        return found

    def capacity(self, k, press, static):
        pair = self.plane.pairs[k]
        return (pair.static if static else pair.mu) * press[k] + pair.clutch

    def solve(self, q, v, t, base, senses, static=()):
        """Return the motion with coordinates ``base`` at rest, and friction against the senses of others."""
        G, E, gamma, bias = self.rows(q, v)
        some = sorted(senses)
        B = np.vstack([G, E[list(base)]]) if base else G
        goal = np.r_[gamma, -bias[list(base)]]
        W = self.inertia[:, None]
        A = B @ (B.T / W)
        loads = np.column_stack([self.applied(q, v, t, E), *(E[k] for k in some)])
        right = np.column_stack([goal, np.zeros((len(goal), len(some)))]) - B @ (loads / W)
        lam = np.linalg.lstsq(A, right, rcond=1e-13)[0]
        w, n = np.zeros(len(some)), 2 * len(self.plane.pairs)
        for _ in range(PASSES):
            press = self.press(lam[:n, 0] + lam[:n, 1:] @ w)
            new = np.array([-senses[k] * self.capacity(k, press, k in static) for k in some])
            done = np.abs(new - w).max(initial=0.0) <= 1e-14 * np.abs(new).max(initial=1.0)
            w = new
            if done:
                break
        else:
            raise Undecided("friction does not settle")
        every = lam[:, 0] + lam[:, 1:] @ w
        a = (loads[:, 0] + loads[:, 1:] @ w + B.T @ every) / self.inertia
        return Motion(a, every[:n], dict(zip(base, every[len(G) :], strict=True)), self.press(every[:n]))

    def motion(self, q, v, t):
        return self.solve(q, v, t, self.base, {k: s for k, s in self.senses.items() if self.plane.pairs[k].rubs})

    def interval(self, k, press, static=True):
        """Return the least and the greatest load that a coordinate at rest bears."""
        most = self.capacity(k, press, static)
        low, high = -most, most
        if self.closed.get(k) == "low" or self.plane.pairs[k].wheel:
            high = np.inf
        if self.closed.get(k) == "high":
            low = -np.inf
        return low, high

    def project(self):
        """Set rates that stand at rest to zero, and velocities on the rows."""
        G, E, _, _ = self.rows(self.q, self.v)
        A = np.vstack([G, E[self.stuck]]) if self.stuck else G
        self.v = self.v - np.linalg.lstsq(A, A @ self.v, rcond=1e-10)[0]

    def settle(self, leaving=None):
        """Decide which coordinates at rest stick, and in which sense the others slip; ``leaving``: (k, sense)."""
        x, rates = self.coordinates(self.q), self.rates(self.q, self.v)
        pairs = self.plane.pairs
        self.closed = {}
        for k, pair in enumerate(pairs):
            if pair.stop and abs(rates[k]) < SLOW:
                if abs(x[k] - pair.stop[0]) < CLOSE:
                    self.closed[k] = "low"
                if abs(x[k] - pair.stop[1]) < CLOSE:
                    self.closed[k] = "high"
        rest = [k for k, pair in enumerate(pairs)
                if abs(rates[k]) < SLOW and (pair.rubs or pair.wheel or k in self.closed)]  # fmt: skip
        self.senses = {k: float(np.sign(rates[k])) for k, pair in enumerate(pairs) if k not in rest}
        self.stuck, self.base, self.line = [], [], None
        if not rest:
            return
        G, E, _, _ = self.rows(self.q, self.v)
        N = null_space(G, rcond=1e-9)
        if N.shape[1] == 0:
            self.stuck = rest
            return
        moves = E @ N
        dead = [k for k in rest if np.linalg.norm(moves[k]) < DEAD * np.linalg.norm(moves)]
        alive = [k for k in rest if k not in dead]
        rank = np.linalg.matrix_rank(moves[alive], tol=1e-8) if alive else 0
        if rank == len(alive):
            self.try_all(alive, dead, leaving)
        elif rank == 1 and N.shape[1] == 1 and not dead:
            self.try_line(alive, np.sign(moves[alive, 0]), leaving)
        else:
            raise Undecided("shares of what sticks are open")
        self.project()

    def try_all(self, alive, dead, leaving):
        """Try all choices of what sticks and in which sense the others slip, most sticking first."""
        choices = [c for c in product((0, 1, -1), repeat=len(alive))]
        for choice in sorted(choices, key=lambda c: sum(map(abs, c))):
            chosen = dict(zip(alive, choice, strict=True))
            if leaving and leaving[0] in chosen and chosen[leaving[0]] != leaving[1]:
                continue
            if any(s > 0 and self.closed.get(k) == "high" for k, s in chosen.items()):
                continue
            if any(s < 0 and (self.closed.get(k) == "low" or self.plane.pairs[k].wheel) for k, s in chosen.items()):
                continue
            for more in product((1.0, -1.0), repeat=len(dead)):
                if self.fits(chosen, dict(zip(dead, more, strict=True)), leaving):
                    return
        raise Undecided("nothing fits")

    def fits(self, chosen, dead, leaving):
        senses = self.senses | {k: float(s) for k, s in chosen.items() if s} | dead
        base = [k for k, s in chosen.items() if not s]
        rub = {k: s for k, s in senses.items() if self.plane.pairs[k].rubs}
        found = self.solve(self.q, self.v, self.t, base, rub)
        _, E, _, bias = self.rows(self.q, self.v)
        a = E @ found.a + bias
        for k in base:
            low, high = self.interval(k, found.press)
            small = 1e-10 * max(1.0, abs(found.held[k]))
            if not low - small <= found.held[k] <= high + small:
                return False
        small = 1e-9 * max(1.0, np.abs(a).max())
        moving = {k: s for k, s in chosen.items() if s} | dead
        if any(s * a[k] < -small for k, s in moving.items()):
            return False
        self.senses, self.stuck, self.base = senses, base, base
        return True

    def one_way(self, q, v, t, alive, signs, way, static):
        """Return the acceleration along a way of all joints together, None if a stop is there."""
        senses = dict(zip(alive, way * signs, strict=True))
        press = np.zeros(len(self.plane.pairs))
        for k, s in senses.items():
            low, high = self.interval(k, press)
            if not np.isfinite(high if s < 0 else low):
                return None
        rub = {k: s for k, s in senses.items() if self.plane.pairs[k].rubs}
        found = self.solve(q, v, t, [], self.rubbing_elsewhere(alive) | rub, alive if static else ())
        _, E, _, bias = self.rows(q, v)
        return float(senses[alive[0]] * (E[alive[0]] @ found.a + bias[alive[0]]))

    def check_it_cannot_stand(self, alive, signs, way):
        """Raise Undecided where joints that start together along a way may stand as well, by other shares of the load.

        Standing, each bears a share between both its limits. Where some shares push against the way harder than full
        friction of all does, as a share changes what presses the others, there are shares in between that balance.
        """
        found = []
        for shares in product((1.0, 0.5, 0.0, -0.5, -1.0), repeat=len(alive)):
            rub = {k: s * x for k, s, x in zip(alive, way * signs, shares, strict=True) if self.plane.pairs[k].rubs}
            motion = self.solve(self.q, self.v, self.t, [], self.rubbing_elsewhere(alive) | rub, alive)
            _, E, _, bias = self.rows(self.q, self.v)
            found.append(float(way * signs[0] * (E[alive[0]] @ motion.a + bias[alive[0]])))
        if min(found) < -BALANCED * max(map(abs, found)):
            raise Undecided("what stands together may start and may stand: both fit the law of friction")

    def from_rest(self, t, q, v, way):
        """Return the acceleration with which joints that stand together would start along a way."""
        return self.one_way(q, v, t, self.stuck, self.line, way, True)

    def rubbing_elsewhere(self, alive):
        return {k: s for k, s in self.senses.items() if k not in alive and self.plane.pairs[k].rubs}

    def try_line(self, alive, signs, leaving):
        """All joints move together: they stand if they start in neither way."""
        ways = [1.0, -1.0]
        if leaving:
            ways = [leaving[1]]
        for way in ways:
            a = self.one_way(self.q, self.v, self.t, alive, signs, way, True)
            if a is not None and (a > 1e-9 or leaving):
                self.check_it_cannot_stand(alive, signs, way)
                self.senses = self.senses | dict(zip(alive, way * signs, strict=True))
                return
        self.stuck, self.base, self.line = alive, alive[:1], signs

    # events

    def watched(self):
        """Return (what, which, function of t, q, v that falls through 0)."""
        found, pairs = [], self.plane.pairs
        for k, pair in enumerate(pairs):
            if k not in self.stuck:
                if pair.rubs or pair.wheel:
                    sense = 1.0 if pair.wheel else self.senses[k]
                    found.append(("rate", k, lambda t, q, v, k=k, s=sense: s * self.rates(q, v)[k] + PASSED))
                if pair.stop:
                    low, high, _ = pair.stop
                    found.append(("low", k, lambda t, q, v, k=k, x=low: self.coordinates(q, v)[k] - x))
                    found.append(("high", k, lambda t, q, v, k=k, x=high: x - self.coordinates(q, v)[k]))
        if self.line is not None:
            for way in (1.0, -1.0):
                if self.one_way(self.q, self.v, self.t, self.stuck, self.line, way, True) is not None:
                    found.append(("starts", way, lambda t, q, v, w=way: -self.from_rest(t, q, v, w)))
        else:
            for k in self.base:
                for way in (1.0, -1.0):
                    found.append(("slips", (k, way), lambda t, q, v, k=k, way=way: self.reserve(t, q, v, k, way)))
        for number, latch in enumerate(self.plane.latches):
            k, value, sense = latch.release if number in self.lengths else latch.engage
            found.append(("latch", number, lambda t, q, v, k=k, x=value, s=sense: s * (x - self.coordinates(q, v)[k])))
        return found

    def reserve(self, t, q, v, k, way):
        """Return what a coordinate could bear more before it slips in a sense."""
        found = self.motion(q, v, t)
        low, high = self.interval(k, found.press)
        reserve = found.held[k] - low if way > 0 else high - found.held[k]
        return min(reserve, 1e6)

    def next_event(self, t_end):
        """March to the next event; return (time, names, samples), the last two None at the end."""
        n, watched = self.n, self.watched()

        self.evaluations = 0

        def rates(t, y):
            self.evaluations += 1
            if self.evaluations > EVALUATIONS_MAX:
                raise Undecided("rows are all but dependent")
            return np.r_[y[n:], self.motion(y[:n], y[n:], t).a]

        now = [f(self.t, self.q, self.v) for *_, f in watched]
        if self.t > 0.0:
            self.move(solve_ivp(rates, (self.t, self.t + AWAY), np.r_[self.q, self.v], **EXACT))
            later = [f(self.t, self.q, self.v) for *_, f in watched]
            self.together = any(b < -1e-12 for b in later)
            if self.together:
                return None
        elif any(x < 0.0 for x, (what, *_) in zip(now, watched, strict=True) if what != "latch"):
            raise Undecided("starts beyond an event")
        watched = [w for w in watched if w[0] != "latch" or w[2](self.t, self.q, self.v) > 0.0]
        conditions = []
        for *_, f in watched:
            condition = lambda t, y, f=f: f(t, y[:n], y[n:])  # noqa: E731
            condition.direction, condition.terminal = -1.0, True
            conditions.append(condition)
        run = solve_ivp(rates, (self.t, t_end), np.r_[self.q, self.v], events=conditions, **EXACT)
        samples = [(t, self.coordinates(y[:n]), self.rates(y[:n], y[n:])) for t, y in zip(run.t, run.y.T, strict=True)]
        self.move(run)
        if run.status != 1:
            return self.t, None, samples
        what, which, _ = watched[next(i for i, times in enumerate(run.t_events) if times.size)]
        self.jump(what, which)
        return self.t, (what, which), samples

    def move(self, run):
        self.t, (self.q, self.v) = run.t[-1], np.split(run.y[:, -1], 2)

    def jump(self, what, which):
        """Apply the impact, and decide what holds after it."""
        leaving = None
        if what == "latch":
            if which in self.lengths:
                del self.lengths[which]
            else:
                self.lengths[which] = True
                self.v = self.impact()
        if what in ("low", "high"):
            self.v = self.impact()
        if what == "slips":
            leaving = which
        if what == "starts":
            leaving = (self.stuck[0], which)
        self.settle(leaving)

    def impact(self):
        """Return velocities after an impact: 0 <= P, s (u + e v) >= 0 of each stop and freewheel, one of both zero."""
        G, E, _, _ = self.rows(self.q, self.v)
        x, before = self.coordinates(self.q), E @ self.v
        closed = {}
        for k, pair in enumerate(self.plane.pairs):
            if pair.wheel:
                closed[k] = (1.0, 0.0)
            if pair.stop and abs(x[k] - pair.stop[0]) < CLOSE:
                closed[k] = (1.0, pair.stop[2])
            if pair.stop and abs(x[k] - pair.stop[1]) < CLOSE:
                closed[k] = (-1.0, pair.stop[2])
        rows = sorted(closed)
        for count in range(len(rows), -1, -1):
            for some in combinations(rows, count):
                A = np.vstack([G, E[list(some)]]) if some else G
                goal = np.r_[np.zeros(len(G)), [-closed[k][1] * before[k] for k in some]]
                W = A @ (A.T / self.inertia[:, None])
                P = np.linalg.lstsq(W, goal - A @ self.v, rcond=1e-11)[0]
                u = self.v + A.T @ P / self.inertia
                if np.abs(A @ u - goal).max() > 1e-8:
                    continue
                after = E @ u
                pushes = all(closed[k][0] * p > -1e-12 for k, p in zip(some, P[len(G) :], strict=True))
                if pushes and all(s * (after[k] + e * before[k]) > -1e-10 for k, (s, e) in closed.items()):
                    return u
        raise Undecided("no impulses")


def march(plane, events, t_end):
    """Return (events found (t, what), samples (t, values, rates)) of the second formulation, and why it ended early."""
    second, known, samples = SecondFormulation(plane), [], []
    while len(known) < events:
        found = second.next_event(t_end)
        if found is None:
            return known[:-1], [x for x in samples if x[0] < known[-1][0]], "several at one time"
        samples += found[2]
        if found[1] is None:
            return known, samples, ""
        if known and found[0] - known[-1][0] < 1e-5:
            return known, samples, "hops"
        known.append(found[:2])
    return known, samples, ""
