"""Random chains in a plane with stops and freewheels, and their own equations in minimal coordinates.

A chain hangs on the ground or on a cart; each hinge (or the cart) has a rigid stop, a freewheel or friction that is
smooth in its rate. Nothing of the package stands in the second formulation: mass matrix by Jacobians of the links,
events by SciPy, impacts and rest by trying all sets of what holds.
"""

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.integrate import solve_ivp

from mbsd3d import GROUND, Body, EndStop, Freewheel, JointFriction, Prismatic, Revolute, System, rotation
from mbsd3d.rotations import matrix

GRAVITY = 9.81
AWAY = 1e-7  # [s] after an event without a look at conditions: hops to be compared last longer
GRAZE = 1e-12  # [rad, m] beyond a limit that is rounding
EXACT = dict(method="DOP853", rtol=1e-11, atol=1e-12, max_step=0.02)
SLOW = 1e-9  # [rad/s, m/s] of a rate that counts as none after an impact


@dataclass
class Machine:
    """Numbers of a chain: per link mass, inertia, com (2,), length; per coordinate its stops, freewheel, friction."""

    cart: float  # kg, 0: the chain hangs on the ground
    links: list
    stops: list  # (lower, upper, restitution) or None
    wheels: list  # whether it may not go back
    friction: list  # (Coulomb load, transition rate, viscous)
    q: np.ndarray
    v: np.ndarray


def random_machine(seed):
    """Return a chain of one to three links, on a cart one time in three."""
    rng = np.random.default_rng(seed)
    count, cart = int(rng.integers(1, 4)), float(rng.uniform(1.0, 3.0)) if rng.random() < 0.34 else 0.0
    links = [
        (rng.uniform(0.5, 2.0), rng.uniform(0.01, 0.1), rng.uniform((0.1, -0.1), (0.4, 0.1)), rng.uniform(0.3, 0.6))
        for _ in range(count)
    ]
    n = count + (cart > 0.0)
    kinds = rng.choice(["stop", "stop", "stop", "wheel", "none"], n)
    kinds[rng.integers(n)] = "stop"
    stops, wheels = [], []
    for kind in kinds:
        low, high = -rng.uniform(0.2, 0.7), rng.uniform(0.2, 0.7)
        stops.append((low, high, float(rng.choice([0.0, 0.4, 0.7]))) if kind == "stop" else None)
        wheels.append(kind == "wheel")
    bounce = rng.choice([0.0, 0.4, 0.7])  # one for all: Newton's law may give energy otherwise
    stops = [stop and (*stop[:2], float(bounce)) for stop in stops]
    friction = [(rng.uniform(0.1, 0.5), rng.uniform(0.2, 0.5), rng.uniform(0.0, 0.1)) for _ in range(n)]
    v = rng.uniform(-6.0, 6.0, n)
    return Machine(cart, links, stops, wheels, friction, rng.uniform(-0.1, 0.1, n), np.where(wheels, abs(v), v))


def system_of(machine):
    """Return (system, start, joints) of a chain in a slanted plane."""
    R, at = matrix(rotation((0.3, -0.5, 0.8), 1.1)), np.array([0.7, -1.3, 0.4])
    bodies, joints, before = [], [], GROUND
    if machine.cart:
        before = Body("cart", machine.cart, R @ np.diag([0.1, 0.2, 0.15]) @ R.T, position=at)
        bodies.append(before)
        joints.append(Prismatic(GROUND, before, at=at, axis=R[:, 0], name="x0"))
    for mass, inertia, com, length in machine.links:
        own = R @ np.diag([0.8 * inertia, 0.7 * inertia, inertia]) @ R.T
        # at the reference pose a link hangs down: its x axis along -y of the plane
        there = com[0] * -R[:, 1] + com[1] * R[:, 0]
        link = Body(f"link{len(joints)}", mass, own, com=there, position=at)
        joints.append(Revolute(before, link, at=at, axis=R[:, 2], name=f"x{len(joints)}"))
        bodies.append(link)
        before, at = link, at - length * R[:, 1]
    forces = []
    for k, joint in enumerate(joints):
        coulomb, transition, viscous = machine.friction[k]
        forces.append(JointFriction(joint, coulomb=coulomb, viscous=viscous, transition=transition))
        if machine.stops[k]:
            low, high, e = machine.stops[k]
            forces.append(EndStop(joint, lower=low, upper=high, restitution=e, name=f"part{k}"))
        if machine.wheels[k]:
            forces.append(Freewheel(joint, name=f"part{k}"))
    system = System(bodies, joints, forces, gravity=-GRAVITY * R[:, 1])
    hinges = {joint: x for joint, x in zip(joints, machine.q, strict=True) if isinstance(joint, Revolute)}
    slides = {joint: x for joint, x in zip(joints, machine.q, strict=True) if isinstance(joint, Prismatic)}
    rates = dict(zip(joints, machine.v, strict=True))
    return system, system.assemble(angles=hinges, slides=slides, rates=rates), joints


def equations(machine, q, v):
    """Return (M, Q) of M a = Q + loads along the coordinates."""
    n, slides = q.size, int(machine.cart > 0.0)
    M, Q = np.zeros((n, n)), np.zeros(n)
    place, drift = np.array([q[0] if slides else 0.0, 0.0]), np.zeros(2)
    if slides:
        M[0, 0] += machine.cart
    turn, spin, origins = -0.5 * np.pi, 0.0, []
    for k, (mass, inertia, com, length) in enumerate(machine.links):
        turn, spin = turn + q[slides + k], spin + v[slides + k]
        ahead, aside = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
        origins.append(place)
        arm = com[0] * ahead + com[1] * aside
        J, Jw = np.zeros((2, n)), np.zeros(n)
        if slides:
            J[0, 0] = 1.0
        for j, origin in enumerate(origins):
            lever = place + arm - origin
            J[:, slides + j] = -lever[1], lever[0]
            Jw[slides + j] = 1.0
        bias = drift - spin**2 * arm
        M += mass * J.T @ J + inertia * np.outer(Jw, Jw)
        Q += J.T @ (mass * (np.array([0.0, -GRAVITY]) - bias))
        place, drift = place + length * ahead, drift - spin**2 * length * ahead
    for k, (coulomb, transition, viscous) in enumerate(machine.friction):
        Q[k] -= coulomb * np.tanh(v[k] / transition) + viscous * v[k]
    return M, Q


class SecondFormulation:
    """March of a chain from event to event; ``held`` has the sense of the load by coordinate."""

    def __init__(self, machine):
        self.machine, self.q, self.v, self.t, self.held = machine, machine.q.copy(), machine.v.copy(), 0.0, {}
        self.together = False  # whether another part was struck within AWAY of the last event

    def loads(self, q, v, held):
        """Return (accelerations, loads of held coordinates)."""
        M, Q = equations(self.machine, q, v)
        rows = sorted(held)
        E = np.eye(q.size)[rows]
        K = np.block([[M, -E.T], [E, np.zeros((len(rows), len(rows)))]])
        x = np.linalg.solve(K, np.r_[Q, np.zeros(len(rows))])
        return x[: q.size], dict(zip(rows, x[q.size :], strict=True))

    def watched(self):
        """Return (coordinate, what, function of q and v that falls through 0 at the event)."""
        found = []
        for k in range(self.q.size):
            stop = self.machine.stops[k]
            if k in self.held:
                sense, now = self.held[k], dict(self.held)
                found.append((k, "leaves", lambda q, v, k=k, s=sense, h=now: s * self.loads(q, v, h)[1][k]))
            elif stop:
                found.append((k, "low", lambda q, v, k=k, low=stop[0]: q[k] - low))
                found.append((k, "high", lambda q, v, k=k, high=stop[1]: high - q[k]))
            elif self.machine.wheels[k]:
                found.append((k, "locks", lambda q, v, k=k: v[k]))
        return found

    def next_event(self, t_end):
        """March to the next event; return (time, coordinate), None at the end."""
        n, watched = self.q.size, self.watched()

        def rates(t, y):
            return np.r_[y[n:], self.loads(y[:n], y[n:], self.held)[0]]

        if self.t > 0.0:  # off what was struck, which is a root of its condition
            self.move(solve_ivp(rates, (self.t, self.t + AWAY), np.r_[self.q, self.v], **EXACT))
            limits = [f(self.q, self.v) for _, what, f in watched if what in ("low", "high")]
            self.together = min(limits, default=0.0) < -GRAZE
            if self.together:
                return None
        conditions = []
        for _, _, f in watched:
            condition = lambda t, y, f=f: f(y[:n], y[n:])  # noqa: E731
            condition.direction, condition.terminal = -1.0, True
            conditions.append(condition)
        run = solve_ivp(rates, (self.t, t_end), np.r_[self.q, self.v], events=conditions, **EXACT)
        self.move(run)
        if run.status != 1:
            return None
        k, what, _ = watched[next(i for i, times in enumerate(run.t_events) if times.size)]
        self.jump(k, what)
        return self.t, k

    def move(self, run):
        """Take the end of a run of SciPy."""
        self.t, (self.q, self.v) = run.t[-1], np.split(run.y[:, -1], 2)

    def jump(self, k, what):
        """Apply the impact, and decide what holds after it."""
        closed = dict(self.held)
        if what == "leaves":
            del closed[k]
        else:
            closed[k] = -1.0 if what == "high" else 1.0
        if what in ("low", "high"):
            self.v = self.impact(closed)
        if what == "locks":
            self.v[k] = 0.0
        closed = {j: 1.0 for j, wheel in enumerate(self.machine.wheels) if wheel and j != k} | closed
        still = {j: s for j, s in closed.items() if abs(self.v[j]) < SLOW}
        for j in still:
            self.v[j] = 0.0
        self.held = self.rest(still)

    def impact(self, closed):
        """Return the rates after an impact: 0 <= P, s (u + e v) >= 0, one of both zero."""
        M, _ = equations(self.machine, self.q, self.v)
        closed = {j: 1.0 for j, wheel in enumerate(self.machine.wheels) if wheel} | closed  # these, at any rate
        rows = sorted(closed)
        S = np.array([closed[j] for j in rows])
        e = np.array([self.machine.stops[j][2] if self.machine.stops[j] else 0.0 for j in rows])
        W = np.linalg.inv(M)
        for count in range(len(rows), -1, -1):
            for some in map(list, combinations(range(len(rows)), count)):
                P = np.zeros(self.q.size)
                own = [rows[i] for i in some]
                if some:
                    goal = -(1.0 + e[some]) * self.v[own]
                    P[own] = np.linalg.solve(W[np.ix_(own, own)], goal)
                u = self.v + W @ P
                if (S * P[rows] > -1e-12).all() and (S * (u[rows] + e * self.v[rows]) > -1e-10).all():
                    return u
        raise AssertionError("no impulses")

    def rest(self, still):
        """Return what holds of coordinates at rest: 0 <= load, a >= 0, one of both zero."""
        for count in range(len(still) + 1):
            for some in combinations(still, count):
                held = {j: still[j] for j in some}
                a, loads = self.loads(self.q, self.v, held)
                pressed = all(held[j] * loads[j] > -1e-12 for j in held)
                if pressed and all(still[j] * a[j] > -1e-12 for j in still if j not in held):
                    return held
        raise AssertionError("no loads")
