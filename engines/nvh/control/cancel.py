"""Feed-forward on one order in an actuator beside a mount: filtered-x least mean squares, sampled.

At every sample k, T apart, the actuator pushes by ``u = Re p`` and e is the force that arrives at the car; with the
path G from u to e at the order's rate W, as it was measured once,

    p_(k+1) = exp(i W T) (p_k - step conj(G) e_k)

which turns with the order and stands still when e has none of it. Written for Re p and Im p it is linear, with
constant coefficients: with the powertrain on its mounts (`OnMounts`, held over a sample) its poles say which steps are
stable, and how fast the order goes. The same controller drives the general model through `Stepper`.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

from engines.nvh.excitation.loads import Source
from engines.nvh.mounts.mounts import Mount
from engines.nvh.mounts.response import OnMounts
from mbsd3d import Body, Force, Input, Sine, State, Stepper, System, Torque, measures
from mbsd3d.errors import InputError
from mbsd3d.extend import ForceElement, exponential, matrix, number, quaternion_from_matrix

Z = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Path:
    """Sampled path: ``x' = A x + B u, e = C x + D u`` from sample to sample, ``period`` T [s]."""

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: float
    period: float

    def gain(self, W: float) -> complex:
        """Return the transfer function G at a rate [rad/s]."""
        z = np.exp(1j * W * self.period)
        return complex(self.C @ np.linalg.solve(z * np.eye(self.A.shape[0]) - self.A, self.B) + self.D)

    def loop(self, W: float, step: float) -> np.ndarray:
        """Return the matrix of path and controller from sample to sample, shape (n + 2, n + 2)."""
        g = step * self.gain(W).conjugate()
        turn = np.array([[np.cos(W * self.period), -np.sin(W * self.period)],
                         [np.sin(W * self.period), np.cos(W * self.period)]])  # fmt: skip
        seen = np.array([[g.real], [g.imag]])
        adapt = turn @ (np.eye(2) - seen * self.D @ np.array([[1.0, 0.0]]))
        return np.block([[self.A, self.B[:, None], 0 * self.B[:, None]], [-turn @ seen * self.C, adapt]])

    def limit(self, W: float) -> float:
        """Return the step from which the loop is unstable; raise ValueError if every step is unstable."""

        def size(step: float) -> float:
            return float(np.abs(np.linalg.eigvals(self.loop(W, step))).max()) - 1.0

        high = 1e-6 / abs(self.gain(W)) ** 2
        if size(high / 1.5) >= 0.0:
            raise InputError("active mount: unstable or undamped without it; give mounts with dampers")
        while size(high) < 0.0:
            high *= 1.5
        return float(brentq(size, high / 1.5, high, rtol=1e-10))

    def time(self, W: float, step: float) -> float:
        """Return the time in which the slowest mode of the loop falls to 1 / e [s]."""
        return float(-self.period / np.log(np.abs(np.linalg.eigvals(self.loop(W, step))).max()))


@dataclass(frozen=True)
class Cancel:
    """``held`` with a ``source`` at ``rpm`` [1/min]; an actuator along z beside the mount number ``which``; ``order``
    that it cancels; ``rate``: samples a second [Hz].

    ValueError for an unknown mount, a mount that stands askew, an order that is not of the source, or a rate below
    four samples of the order.
    """

    held: OnMounts
    source: Source
    rpm: float
    which: int
    order: float
    rate: float

    def __post_init__(self) -> None:
        number(self.rpm, "active mount: rpm", positive=True)
        number(self.rate, "active mount: rate", positive=True)
        if not 0 <= self.which < len(self.held.placed):
            raise InputError(f"active mount: number {self.which}; there are 0 to {len(self.held.placed) - 1}")
        if self.mount.angle:
            raise InputError(f"active mount: '{self.mount.name}' stands askew; give one along the axes of the car")
        if self.order not in self.source.inertia.orders[1:]:
            raise InputError(f"active mount: order {self.order:g}; give a half or a whole one up to 8")
        if self.rate < 4 * self.W / (2 * np.pi):
            raise InputError(f"active mount: rate {self.rate:g} Hz; give {4 * self.W / (2 * np.pi):.0f} Hz or more")

    @property
    def mount(self) -> Mount:
        """Return the mount that carries the actuator."""
        return self.held.placed[self.which]

    @property
    def turning(self) -> float:
        """Return the rate of the crank [rad/s]."""
        return 2 * np.pi * self.rpm / 60

    @property
    def W(self) -> float:
        """Return the rate of the order [rad/s]."""
        return self.order * self.turning

    @cached_property
    def path(self) -> Path:
        """Return the path from the actuator to the force on the car, held over a sample."""
        head, model = self.held.head(self.mount)[2], self.held.model(self.turning)
        A, B, C = model.seen  # dimensionless, without the angle of the crank
        n = len(A)
        both = np.zeros((n + 1, n + 1))
        both[:n, :n], both[:n, n] = A, B @ head  # + u on the powertrain, - u on the car
        sampled = expm(both * (model.rate / self.rate))
        seen = np.concatenate([self.mount.rates[2] * head, self.mount.damping[2] * head]) @ C
        return Path(sampled[:n, :n], sampled[:n, n], seen, -1.0, 1 / self.rate)

    @cached_property
    def force(self) -> complex:
        """Return the phasor of the order along z on the car at the mount, without the actuator [N]."""
        found = self.held.answer(self.source, [self.rpm])
        return complex(found.force[0, int(2 * self.order), self.which, 2])

    @cached_property
    def actuator(self) -> tuple[float, float]:
        """Return (amplitude of its force [N], power it gives to the powertrain [W]) of the actuator when the order is
        cancelled.
        """
        u = -self.force / self.path.gain(self.W)
        (H,) = self.held.receptance(self.turning, np.array([self.W]))
        head = self.held.head(self.mount)[2]
        found = self.held.answer(self.source, [self.rpm]).motion[0, int(2 * self.order)]
        v = 1j * self.W * head @ (found + H @ (head * u))
        return abs(u), float((u * np.conj(v)).real / 2)

    def predicted(self, step: float, count: int) -> np.ndarray:
        """Return the error e of the linear loop from rest [N], shape (count,)."""
        L, n, found = self.path.loop(self.W, step), self.path.B.size, np.empty(count)
        state = np.zeros(n + 2)
        g = step * self.path.gain(self.W).conjugate()
        back = np.exp(1j * self.W / self.rate) * g
        for k in range(count):
            given = (self.force * np.exp(1j * self.W * k / self.rate)).real
            found[k] = self.path.C @ state[:n] + self.path.D * state[n] + given
            state = L @ state
            state[n:] -= np.array([back.real, back.imag]) * given
        return found

    def system(self) -> System:
        """Build the general model: powertrain and rotor on the mounts under this order of the load, with an input."""
        load = self.source.at(self.rpm).six[int(2 * self.order)] * np.exp(-1j * self.order * self.held.roll)
        hertz, turn = self.W / (2 * np.pi), matrix(self.held.rest[3:])
        load = np.concatenate([turn @ load[:3], turn @ load[3:]])
        waves = [Sine(float(abs(x)), hertz, float(np.angle(x) + np.pi / 2)) for x in load]

        def forces(body: Body) -> list[ForceElement]:
            acting = [Force(body, tuple(waves[:3]), at=(0, 0, 0)), Torque(body, tuple(waves[3:]))]
            return [*self.held.forces(body), *acting, Force(body, (0, 0, Input("actuator")), at=self.mount.at)]

        return self.held.body.system(forces, self.turning)

    def start(self) -> State:
        """Return the state of powertrain and rotor in the small motion of this order at t = 0."""
        motion, rest = self.held.answer(self.source, [self.rpm]).motion[0, int(2 * self.order)], self.held.rest
        moved, speed = motion.real, (1j * self.W * motion).real
        turn = matrix(exponential(moved[3:])) @ matrix(rest[3:])
        q = np.concatenate([rest[:3] + moved[:3], quaternion_from_matrix(turn)])
        axis = turn[:, 0]
        spin = speed[3:] + axis * (self.turning - speed[3]) / axis[0]
        return State(0.0, np.tile(q, 2), np.concatenate([speed, speed[:3], spin]))

    def run(self, step: float, count: int) -> np.ndarray:
        """Simulate the error e in the general model with `Stepper`, from the linear answer without actuator [N], shape
        (count,).
        """
        number(step, "active mount: step", positive=True)
        system = self.system()
        body, at = system.bodies[0], self.mount.at
        seen = [measures.position(body, axis=Z, at=at), measures.velocity(body, axis=Z, at=at)]
        live = Stepper(system, self.start(), measures=seen)
        g, turn, p, found = self.path.gain(self.W).conjugate(), np.exp(1j * self.W / self.rate), 0j, np.empty(count)
        mean = (self.held.rest[:3] + matrix(self.held.rest[3:]) @ at)[2]
        for k in range(count):
            height, speed = live.measured
            found[k] = self.mount.rates[2] * (height - mean) + self.mount.damping[2] * speed - p.real
            live.set("actuator", p.real)
            live.advance((k + 1) / self.rate)
            p = turn * (p - step * g * found[k])
        return found
