"""Chains in space in which one joint switches, in minimal coordinates: Kane's equations, and events found by scipy."""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from helpers.models import direction
from mbsd3d import GROUND, Body, Clutch, EndStop, Prismatic, Revolute, SumSpring, System, TorsionSpring, rotation
from validation.calibration.rates import Chain

STEP_MAX = 2e-3  # [s] for scipy, which steps over a part that is struck and left in between
HOP_MIN = 2e-2  # [s] between events: shorter hops end in rest, which is not followed


@dataclass(frozen=True, eq=False)
class Machine:
    """A chain with rotors at its joints; joint ``k`` has a rigid stop (lower, upper, e) or a clutch (torque,)."""

    chain: Chain
    rotors: np.ndarray
    k: int
    part: tuple[float, ...]
    v: np.ndarray  # at the reference pose

    @property
    def stops(self):
        """Return whether the part is a stop."""
        return len(self.part) == 3


def random_chain(seed):
    """Draw two to four links on hinges and slides of any direction, with springs; half of the joints have rotors."""
    rng = np.random.default_rng([seed, 5])
    n = int(rng.integers(2, 5))
    slides = rng.random(n) < 0.25
    arms = 0.3 * rng.normal(size=(n, 6, 3))
    arms -= arms.mean(axis=1, keepdims=True)
    masses = rng.uniform(0.3, 3.0, n)
    inertias = [m / 6.0 * (np.sum(x * x) * np.eye(3) - x.T @ x) for m, x in zip(masses, arms, strict=True)]
    chain = Chain(
        points=rng.normal(size=(n, 3)), axes=np.array([direction(rng) for _ in range(n)]), slides=slides,
        masses=masses, centres=rng.normal(size=(n, 3)), inertias=np.array(inertias), gravity=4.0 * rng.normal(size=3),
        stiffness=rng.uniform(0.5, 6.0, n), damping=rng.uniform(0.0, 0.5, n),
    )  # fmt: skip
    stop = (-rng.uniform(0.1, 0.8), rng.uniform(0.1, 0.8), rng.uniform(0.4, 0.9))
    part = stop if rng.random() < 0.6 else (rng.uniform(1.0, 6.0),)
    rotors = rng.uniform(0.1, 2.0, n) * (rng.random(n) < 0.5)
    return Machine(chain, rotors, int(rng.integers(n)), part, 3.0 * rng.normal(size=n))


def system_of(machine):
    """Return (system, start, joints), with reference points and axes of bodies anywhere."""
    chain, rng = machine.chain, np.random.default_rng(1)
    bodies, joints, forces = [], [], []
    for k, mass in enumerate(chain.masses):
        turn, off = rotation(direction(rng), rng.uniform(0.0, 3.0)), 0.4 * rng.normal(size=3)
        made = Body("axes", 1.0, (1.0, 1.0, 1.0), orientation=turn).axes
        own = made.T @ chain.inertias[k] @ made
        place = {"com": off, "position": chain.centres[k] - made @ off, "orientation": turn}
        bodies.append(Body(f"link {k}", mass, 0.5 * (own + own.T), **place))
        pair = ([GROUND, *bodies][k], bodies[k])
        at = {"at": chain.points[k], "axis": chain.axes[k], "name": f"joint {k}"}
        law = {"stiffness": chain.stiffness[k], "damping": chain.damping[k]}
        if chain.slides[k]:
            joints.append(Prismatic(*pair, **at, reflected_mass=machine.rotors[k]))
            forces.append(SumSpring(joints[-1], **law))
        else:
            joints.append(Revolute(*pair, **at, reflected_inertia=machine.rotors[k]))
            forces.append(TorsionSpring(joints[-1], **law))
    one, numbers = joints[machine.k], machine.part
    if machine.stops:
        forces.append(EndStop(one, lower=numbers[0], upper=numbers[1], restitution=numbers[2], name="part"))
    else:
        forces.append(Clutch(one, torque=numbers[0], engaged=True, name="part"))
    system = System(bodies, joints, forces, gravity=chain.gravity)
    return system, system.assemble(rates=dict(zip(joints, machine.v, strict=True))), joints


class Motion:
    """The motion of a machine from event to event; ``slip``: sense in which its clutch slips, 0 = it holds."""

    def __init__(self, machine):
        self.machine, self.t, self.events = machine, 0.0, []
        self.q, self.v = np.zeros_like(machine.v), machine.v.copy()
        self.slip = 0.0 if machine.stops else float(np.sign(machine.v[machine.k]))

    def accelerations(self, q, v, slip):
        """Return (rates of v, load that holds joint k or 0, M)."""
        machine, chain, k = self.machine, self.machine.chain, self.machine.k
        M, right = chain.equations(q, v)[:2]
        M, right = M + np.diag(machine.rotors), right - chain.stiffness * q - chain.damping * v
        if machine.stops or slip:
            right[k] -= 0.0 if machine.stops else slip * machine.part[0]
            return np.linalg.solve(M, right), 0.0, M
        free = np.arange(v.size) != k
        found = np.zeros(v.size)
        found[free] = np.linalg.solve(M[np.ix_(free, free)], right[free])
        return found, float(M[k] @ found - right[k]), M

    def watched(self):
        """Return functions of (t, y) that pass zero downwards at the next event."""
        n, k, part, slip = self.v.size, self.machine.k, self.machine.part, self.slip
        if self.machine.stops:
            found = [lambda t, y: y[k] - part[0], lambda t, y: part[1] - y[k]]
        elif slip:
            found = [lambda t, y: slip * y[n + k]]
        else:
            found = [lambda t, y: part[0] - abs(self.accelerations(y[:n], y[n:], 0.0)[1])]
        for one in found:
            one.terminal, one.direction = True, -1.0
        return found

    def switch(self):
        """Change what holds, or the rates in an impact, at an event."""
        k, part = self.machine.k, self.machine.part
        _, load, M = self.accelerations(self.q, self.v, 0.0)
        if self.machine.stops:
            along = np.linalg.solve(M, np.eye(self.v.size)[k])
            self.v = self.v - (1.0 + part[2]) * self.v[k] / along[k] * along
            return
        self.v[k] = 0.0
        _, load, _ = self.accelerations(self.q, self.v, 0.0)
        self.slip = 0.0 if self.slip and abs(load) <= part[0] else -float(np.sign(load))

    def go_on(self, t_end):
        """Move to the next event, or to the end; return whether there was one."""
        n, slip = self.v.size, self.slip

        def slope(t, y):
            return np.append(y[n:], self.accelerations(y[:n], y[n:], slip)[0])

        start = np.append(self.q, self.v)
        limits = {"rtol": 1e-10, "atol": 1e-12, "max_step": STEP_MAX}
        found = solve_ivp(slope, (self.t, t_end), start, "DOP853", events=self.watched(), **limits)
        self.t, self.q, self.v = float(found.t[-1]), found.y[:n, -1], found.y[n:, -1].copy()
        if found.status != 1:
            return False
        self.switch()
        self.events.append(self.t)
        return True


def march(machine, t_end, most):
    """Return the motion up to the end, to an event that follows another one at once, or after ``most`` events."""
    motion = Motion(machine)
    while len(motion.events) < most and motion.go_on(t_end):
        if len(motion.events) > 1 and motion.events[-1] - motion.events[-2] < HOP_MIN:
            break
    return motion
