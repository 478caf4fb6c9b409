"""Runs of a planar mechanism, through time by Runge-Kutta or position by position of a driven one; results by part."""

import time
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from engines.planar import rows as kinds
from engines.planar.joints import Driver, Rolling, SlideDriver
from engines.planar.march import DONE, NOT_FINITE, SINGULAR, close, evaluate, march, trace
from engines.planar.rows import Model, Work
from engines.planar.system import Lowered, System, lower
from mbsd3d import AssemblyError, IntegrationError
from mbsd3d.errors import InputError
from mbsd3d.extend import number

Vector = np.ndarray | Sequence[float]  # (2,)


class Reaction(NamedTuple):
    """Reaction of a joint on its body b."""

    force: np.ndarray  # (k, 2) world [N]
    moment: np.ndarray  # (k,) about ``point`` [N m]
    point: np.ndarray  # (k, 2) world [m]


class Energy(NamedTuple):
    """Energies (k,) each [J]; potential of weight and springs."""

    kinetic: np.ndarray
    potential: np.ndarray

    @property
    def total(self) -> np.ndarray:
        """Return the sum of kinetic and potential energy [J]."""
        return self.kinetic + self.potential


def turned(angle: np.ndarray, vector: Vector) -> np.ndarray:
    """Return R(angle) vector, (k,), (2,) -> (k, 2)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]], axis=-1)


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return a x b, the component out of the plane."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


class Solution:
    """Samples of a run; bodies, joints and drivers are given by themselves or by their names."""

    def __init__(self, system: System, t: np.ndarray, arrays: tuple, seconds: float) -> None:
        self.system, self.t, self.seconds = system, t, seconds
        self._q, self._v, self._a, self._wrench = arrays

    def _row(self, array: np.ndarray, body: Any) -> np.ndarray:
        """Return the samples of a body, zeros for the ground, shape (k, 3)."""
        if getattr(body, "name", body) == "ground":
            return np.zeros((len(self.t), 3))
        return array[:, self.system.part(body, "bodies")]

    def position(self, body: Any) -> np.ndarray:
        """Return the position of the reference point O [m], shape (k, 2)."""
        return self._row(self._q, body)[:, :2]

    def angle(self, body: Any) -> np.ndarray:
        """Return the direction of the x axis of a body, not wrapped [rad], shape (k,)."""
        return self._row(self._q, body)[:, 2]

    def velocity(self, body: Any) -> np.ndarray:
        """Return the velocity of O [m/s], shape (k, 2)."""
        return self._row(self._v, body)[:, :2]

    def omega(self, body: Any) -> np.ndarray:
        """Return the angular velocity of a body [rad/s], shape (k,)."""
        return self._row(self._v, body)[:, 2]

    def acceleration(self, body: Any) -> np.ndarray:
        """Return the acceleration of O [m/s^2], shape (k, 2)."""
        return self._row(self._a, body)[:, :2]

    def alpha(self, body: Any) -> np.ndarray:
        """Return the angular acceleration of a body [rad/s^2], shape (k,)."""
        return self._row(self._a, body)[:, 2]

    def point(self, body: Any, local: Vector) -> np.ndarray:
        """Return the position of a point given in body axes from O [m], shape (k, 2)."""
        return self.position(body) + turned(self.angle(body), local)

    def com(self, body: Any) -> np.ndarray:
        """Return the position of the centre of mass [m], shape (k, 2)."""
        return self.point(body, self.system.bodies[self.system.part(body, "bodies")].com)

    def reaction(self, joint: Any) -> Reaction:
        """Return force [N] and moment [N m] of a joint on its body b, at its point (of a rolling disc: the contact).

        Body b of a gear is body b of its second hinge; a frame that both hinges share takes the moments of both.
        """
        i = self.system.part(joint, "joints")
        joint = self.system.joints[i]
        wrench = self._wrench[:, self.system.lowered.joint_of == i].sum(axis=1)
        body = joint.rows()[0].bodies[1]
        if isinstance(joint, Rolling):
            centre = self.point(body, body.local_point(joint.centre))
            point = centre - joint.radius * turned(self.angle(joint.a), joint.a.local(joint.normal()))
        else:
            point = self.point(body, body.local_point(joint.point()))
        force = wrench[:, :2]
        return Reaction(force, wrench[:, 2] - cross(point - self.position(body), force), point)

    def effort(self, driver: Any) -> np.ndarray:
        """Return the torque [N m] or force along the axis [N] of a driver on body b, shape (k,)."""
        joint = self.system.joints[self.system.part(driver, "joints")]
        if not isinstance(joint, Driver):
            raise InputError(f"{self.system.name(joint)} is not a driver; ask for its reaction")
        reaction = self.reaction(joint)
        if not isinstance(joint, SlideDriver):
            return reaction.moment
        slider = joint.through
        return np.sum(reaction.force * turned(self.angle(slider.a), slider.a.local(slider.axis)), axis=1)

    def energy(self) -> Energy:
        """Return the kinetic energy m v_G^2 / 2 + I_G w^2 / 2 and the potential energy of weight and springs [J]."""
        kinetic, potential = np.zeros(len(self.t)), np.zeros(len(self.t))
        for body in self.system.bodies:
            w, arm = self.omega(body), turned(self.angle(body), body.com)
            velocity = self.velocity(body) + w[:, None] * np.stack([-arm[:, 1], arm[:, 0]], axis=1)
            kinetic += (body.mass * np.sum(velocity**2, axis=1) + body.inertia * w**2) / 2
            potential -= body.mass * self.com(body) @ self.system.gravity
        for part in self.system.loads:
            row = part.load()
            a, b = row.bodies
            if row.kind == kinds.SPRING:
                span = self.point(b, row.values[2:4]) - self.point(a, row.values[:2])
                potential += row.values[4] * (np.hypot(*span.T) - row.values[6]) ** 2 / 2
            elif row.kind == kinds.TORSION:
                potential += row.values[0] * (self.angle(b) - self.angle(a) - row.values[2]) ** 2 / 2
        return Energy(kinetic, potential)


PIECE_SECONDS = 0.1  # [s] of computation between two checks for Ctrl-C
VELOCITY_TOLERANCE = 1e-9  # [1] of the largest given velocity or 1 [m/s, rad/s]: its error against the joints


def simulate(
    system: System, t_end: float, *, dt: float, output: int | None = None, centripetal: bool = True
) -> Solution:
    """Simulate the motion by Runge-Kutta of order 4 with a fixed step, projected onto the constraints after every step.

    ``t_end, dt``: [s]; the step is shortened so that it divides the time between two samples; ``output``: number of
    samples, both ends included; None = every step; ``centripetal``: False drops h: wrong, for comparison. ValueError
    for redundant rows, initial velocities that contradict the joints, a table that ends before the run, a point mass
    whose rate can change; IntegrationError if rows become singular or numbers are not finite; AssemblyError if a joint
    cannot close. They name joint or body, time and gap.
    """
    t_end, dt = number(t_end, "simulate: t_end", positive=True), number(dt, "simulate: dt", positive=True)
    if output is not None and (output != int(output) or output < 2):
        raise InputError(f"simulate: output {output}; give None or a count of at least 2")
    steps = max(int(np.ceil(t_end / dt * (1 - 1e-12))), 1)
    samples = steps if output is None else int(output) - 1
    every = -(-steps // samples)
    covered(system, 0.0, t_end)
    lowered = system.lowered if centripetal else lower(system, centripetal=False)
    work, q = lowered.work(), lowered.q.copy()
    v = initial_velocity(system, lowered, work, q)
    out = storage(lowered, samples + 1)
    began = time.perf_counter()
    arguments = lowered.model, work, q, v, t_end, every * samples, every, out
    status, row, t = in_pieces(march, arguments, every * samples + 1)
    seconds = time.perf_counter() - began
    explain(system, lowered, work, status, row, t)
    return Solution(system, t_end * (np.arange(samples + 1) / samples), out, seconds)


def kinematics(system: System, times: ArrayLike, *, centripetal: bool = True) -> Solution:
    """Compute motion and forces of a fully driven system, position by position from the reference pose at t = 0.

    Arguments and errors as in `simulate`, at times (k,) [s]; ValueError if freedoms are left.
    """
    times = np.atleast_1d(np.asarray(times, dtype=float))
    if times.ndim != 1 or not times.size or not np.isfinite(times).all():
        raise InputError(f"kinematics: times of shape {times.shape}; give a row of finite numbers [s]")
    covered(system, min(0.0, times.min()), max(0.0, times.max()))
    lowered = system.lowered if centripetal else lower(system, centripetal=False)
    left = 3 * len(system.bodies) - lowered.model.kind.size
    if left:
        raise InputError(f"kinematics: {left} degrees of freedom are not driven; add as many drivers, or use simulate")
    work, q, out = lowered.work(), lowered.q.copy(), storage(lowered, times.size + 1)
    began = time.perf_counter()
    status, row, t = in_pieces(trace, (lowered.model, work, q, np.concatenate([[0.0], times]), out), times.size + 1)
    seconds = time.perf_counter() - began
    explain(system, lowered, work, status, row, t)
    return Solution(system, times, tuple(array[1:] for array in out), seconds)


def in_pieces(loop: Callable, arguments: tuple, count: int) -> tuple[int, int, float]:
    """Run a compiled loop over 0 ... count - 1 in pieces of `PIECE_SECONDS` so that Ctrl-C ends it; the numbers
    equal those of one piece.
    """
    begin, size, status = 0, 100, (DONE, 0, 0.0)
    while begin < count and status[0] == DONE:
        end, began = min(begin + size, count), time.perf_counter()
        status = loop(*arguments, begin, end)
        seconds = max(time.perf_counter() - began, 1e-9)
        size = max(1, int((end - begin) * min(10.0, PIECE_SECONDS / seconds)))
        begin = end
    return status


def covered(system: System, low: float, high: float) -> None:
    """Raise ValueError that names a part whose motion is not known from low to high [s]."""
    for part in (*system.joints, *system.loads):
        first, last = part.motion.interval if hasattr(part, "motion") else (-np.inf, np.inf)
        if low < first or high > last:
            raise InputError(
                f"{system.name(part)}: its table covers {first:g} s to {last:g} s and is asked for {low:g} s to "
                f"{high:g} s; extend it or stay inside"
            )


def storage(lowered: Lowered, samples: int) -> tuple[np.ndarray, ...]:
    """Allocate q, v, v_dot (samples, n, 3) and the wrenches of the rows (samples, m, 3)."""
    n, m = len(lowered.q) - 1, lowered.model.kind.size
    return (*(np.empty((samples, n, 3)) for _ in range(3)), np.empty((samples, m, 3)))


def initial_velocity(system: System, lowered: Lowered, work: Any, q: np.ndarray) -> np.ndarray:
    """Return velocities with the given numbers and J v = f_dot, of least kinetic energy, shape (n + 1, 3); projects
    q."""
    status, row = close(lowered.model, work, 0.0, q)
    explain(system, lowered, work, status, row, 0.0)
    v = np.zeros_like(q)
    evaluate(lowered.model, work, 0.0, q, v)
    J, given, values = lowered.jacobian(work), [], []
    for i, body in enumerate(system.bodies):
        numbers = (*((None, None) if body.velocity is None else body.velocity), body.omega)
        given += [3 * i + k for k, x in enumerate(numbers) if x is not None]
        values += [x for x in numbers if x is not None]
    A = np.vstack([J, np.eye(J.shape[1])[given]])
    b = np.concatenate([work.rate, values])
    if not np.any(b):
        return v
    root = np.linalg.inv(scaling(lowered.model, work))
    found = root @ np.linalg.lstsq(A @ root, b, rcond=1e-12)[0]
    wrong = np.abs(A @ found - b)
    if wrong.max() > VELOCITY_TOLERANCE * max(1.0, np.abs(b).max()):
        m = lowered.model.kind.size
        worst = int(np.argmax(wrong[:m])) if m and wrong[:m].max() > 1e-3 * wrong.max() else None
        where = "" if worst is None else f" of {system.name(system.joints[lowered.joint_of[worst]])}"
        raise InputError(
            f"System: the initial velocities contradict the rows{where} by {wrong.max():.3g}; "
            "correct them, or leave None what the joints decide"
        )
    v[:-1] = found.reshape(-1, 3)
    return v


def scaling(model: Model, work: Work) -> np.ndarray:
    """Return U (3 n, 3 n) with v'U'U v twice the kinetic energy."""
    U = np.zeros((3 * len(model.body) - 3,) * 2)
    for i, (mass, inertia) in enumerate(model.body[:-1, :2]):
        x, y = work.frame[i, 2:]
        block = np.array([[1.0, 0.0, -y], [0.0, 1.0, x], [0.0, 0.0, np.sqrt(inertia / mass)]])
        U[3 * i : 3 * i + 3, 3 * i : 3 * i + 3] = np.sqrt(mass) * block
    return U


def explain(system: System, lowered: Lowered, work: Any, status: int, row: int, t: float) -> None:
    """Raise the error of a status, naming the joint."""
    if status == DONE:
        return
    if status == NOT_FINITE:
        body = int(np.argmax(~np.isfinite(work.x[:-1] + work.q[:-1]).all(axis=1)))
        advice = "take a smaller dt, or keep the ends of springs apart"
        raise IntegrationError(
            "planar: numbers are not finite", time=t, part=f"body '{system.bodies[body].name}'", advice=advice
        )
    at = row if status != SINGULAR else int(np.flatnonzero(lowered.model.place == row)[0])
    joint = system.name(system.joints[lowered.joint_of[at]])
    if status == SINGULAR:
        advice = "a dead point or a redundancy: move the pose, drive another joint, or remove one"
        raise IntegrationError("planar: rows singular", time=t, part=joint, advice=advice)
    gap, advice = float(np.abs(work.c).max()), "check lengths and drivers, or take smaller steps"
    raise AssemblyError("planar: joint cannot close", time=t, part=joint, residual=gap, advice=advice)
