"""The result of a run: every quantity by part, in world axes and SI units."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..base.checks import short_repr
from ..base.errors import InputError
from ..base.rotations import crosses, matrix
from ..base.style import Sampled
from ..dynamics.batch import wrenches
from ..equations.compiled import Compiled, compile_system, new_data, tables_of
from ..kernels.coordinates import coordinate_rate, measure, remember
from ..kernels.kinematics import kinematics
from ..kernels.layout import Data
from ..kernels.rows import rows
from ..mechanism.bodies import GROUND, Body, Ground
from ..mechanism.drivers import Driver
from ..mechanism.force_element import ForceElement
from ..mechanism.joints import Joint, coordinate_of
from ..mechanism.measures import Measure, check_members
from ..mechanism.primitives import Coordinate
from ..mechanism.state import State
from .motion import Motion
from .reactions import (
    NOT_DETERMINED,
    Determined,
    Probe,
    Reaction,
    RunRows,
    Shares,
    all_determined,
    axes_of,
    group_of,
    is_unique,
)
from .record import Record


@dataclass(frozen=True, repr=False)
class Energy(Sampled):
    """Energies [J] at the samples; ``work`` was done by drivers and by forces that store none."""

    kinetic: np.ndarray
    potential: np.ndarray
    total: np.ndarray
    work: np.ndarray


@dataclass(frozen=True, repr=False)
class Momentum(Sampled):
    """Linear momentum [kg m/s] and angular momentum about the world origin [kg m^2/s], (samples, 3)."""

    linear: np.ndarray
    angular: np.ndarray


@dataclass(frozen=True, repr=False)
class Drift(Sampled):
    """Largest |c| [m or rad] and |J v - b| [m/s or rad/s] over all rows at each sample."""

    position: np.ndarray
    velocity: np.ndarray


class AboutCentre(NamedTuple):
    """The motion of the whole: that of its centre of mass, and what goes on about it."""

    place: np.ndarray  # (samples, 3) m, of the centre of mass
    velocity: np.ndarray  # (samples, 3) m/s, of the centre of mass
    kinetic: np.ndarray  # (samples,) J, of the motion about it
    angular: np.ndarray  # (samples, 3) kg m^2/s, about it
    fastest: float  # m/s, greatest velocity of a centre of mass of a body, relative to the mean of all and of the run
    farthest: float  # m, greatest distance of one from the middle of all bodies


@dataclass(frozen=True, eq=False, repr=False)
class RunResult(Motion):
    """Samples, record, start and end of a run.

    Parts are given as objects or by name; vectors are (samples, 3) in world axes.
    """

    record: Record
    start: State  # as it was given; the first sample may be later
    final: State
    estimated: tuple[float | None, float | None, float | None] = (None, None, None)  # of the global error, `estimate`:
    # itself, its order, and the time in which it doubles [s]
    derived: dict[str, Any] = field(default_factory=dict, init=False)  # what is made of the samples once

    @classmethod
    def from_run(
        cls,
        compiled: Compiled,
        arrays: dict[str, np.ndarray],
        record: Record,
        start: State,
        y: np.ndarray,
        t: float,
        data: Data,
    ) -> "RunResult":
        """Split the raw samples ``y`` into q, world velocities and internal states."""
        n = len(compiled.system.bodies)
        states = arrays.pop("y")
        arrays["state"] = states
        arrays["q"] = states[:, : 7 * n].reshape(-1, n, 7)
        arrays["v"] = world_velocities(states, n)
        arrays["z"] = states[:, 13 * n :]
        arrays["acceleration"] = arrays["acceleration"].reshape(-1, n, 6)
        at_end = len(states) > 0 and np.array_equal(states[-1], y)
        v = arrays["v"][-1] if at_end else world_velocities(y[None], n)[0]
        own = y[13 * n : 13 * n + compiled.model.z_work]
        coordinates = data.coordinate["value"][: compiled.own_coordinates].copy()
        end = State(t, unit_quaternions(y[: 7 * n]), v.ravel(), own, coordinates)
        return cls(compiled, arrays, record, start, end)

    def velocity(self, body: Body | str) -> np.ndarray:
        """Return the velocity of the reference point [m/s]."""
        return self.arrays["v"][:, self._body(body), :3]

    def omega(self, body: Body | str) -> np.ndarray:
        """Return the angular velocity [rad/s], world axes."""
        return self.arrays["v"][:, self._body(body), 3:]

    def omega_body(self, body: Body | str) -> np.ndarray:
        """Return the angular velocity [rad/s], body axes."""
        return np.einsum("tji,tj->ti", self.rotation(body), self.omega(body))

    def acceleration(self, body: Body | str) -> np.ndarray:
        """Return the acceleration of the reference point [m/s^2]."""
        return self.arrays["acceleration"][:, self._body(body), :3]

    def alpha(self, body: Body | str) -> np.ndarray:
        """Return the angular acceleration [rad/s^2], world axes."""
        return self.arrays["acceleration"][:, self._body(body), 3:]

    def _coordinate(self, joint: Joint | str, kind: str) -> int:
        part = self.system.part(joint, "joints")
        return self.compiled.coordinate(coordinate_of(part, kind, f"solution.{kind}"))

    def angle(self, joint: Joint | str) -> np.ndarray:
        """Return (samples,) angle of a hinge [rad], unwrapped, zero at the reference pose."""
        return self.arrays["coordinate"][:, self._coordinate(joint, "angle")]

    def slide(self, joint: Joint | str) -> np.ndarray:
        """Return (samples,) displacement of a sliding joint [m]."""
        return self.arrays["coordinate"][:, self._coordinate(joint, "slide")]

    def rate(self, joint: Joint | str) -> np.ndarray:
        """Return (samples,) rate of a hinge's angle [rad/s], or of a slide [m/s] where there is no angle."""
        part = self.system.part(joint, "joints")
        x = part.angle() or part.slide()
        if x is None:
            raise InputError(f"'{self.system.name(part)}' has no angle and no slide; give a hinge or a slider")
        return self._coordinate_rate(x)

    def _coordinate_rate(self, x: Coordinate) -> np.ndarray:
        """Return (samples,) rate of a hinge coordinate [rad/s or m/s]."""
        if x.kind not in ("angle", "slide"):
            return self.measure(Measure("coordinate rate", f"rate of a {x.kind}", "m/s", x.a, x.b, coordinate=x))
        axis = self.body_axis(x.a, x.axis)
        w_a, w_b = (np.zeros((self.t.size, 3)) if isinstance(body, Ground) else self.omega(body) for body in (x.a, x.b))
        if x.kind == "angle":
            return np.einsum("ti,ti->t", axis, w_b - w_a)
        p_b, v_b = self._point_motion(x.b, x.point_b)
        v_a_there = 0.0 if isinstance(x.a, Ground) else self.velocity(x.a) + crosses(w_a, p_b - self.position(x.a))
        return np.einsum("ti,ti->t", axis, v_b - v_a_there)

    def _point_motion(self, body: Body | Ground, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return world position and velocity of a body point given at the reference pose."""
        if isinstance(body, Ground):
            return np.broadcast_to(point, (self.t.size, 3)), np.zeros((self.t.size, 3))
        return self._carried(body, body.local_point(point))

    def _carried(self, body: Body, local: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return world position and velocity of a point given in body axes from the reference point."""
        arm = self.rotation(body) @ local
        return self.position(body) + arm, self.velocity(body) + crosses(self.omega(body), arm)

    def measure(self, measures: Measure | Sequence[Measure]) -> np.ndarray:
        """Return the values (samples,) of one of `mbsd3d.measures`, (samples, k) of k of them.

        Angles of hinges are those of the run. Other angles, e.g. headings, are followed from sample to sample: between
        two of them the mean of both rates must tell the turn to within half a turn.
        """
        wanted = tuple(measures) if isinstance(measures, list | tuple) else (measures,)
        for one in wanted:
            if not isinstance(one, Measure):
                raise InputError(
                    f"solution.measure: {short_repr(one)} is not a measure; build one with mbsd3d.measures"
                )
            check_members(self.system, one, "solution.measure")
            if one.joint is not None and not self._is_unique([one.joint]):
                raise InputError(f"solution.measure: {one.label} {NOT_DETERMINED}")
        model = compile_system(self.system, wanted).model
        data, known = new_data(model), len(tables_of(self.system).coordinate_index)
        values = np.empty((self.t.size, len(wanted)))
        for k, t in enumerate(self.t):
            kinematics(model, data, self.arrays["state"][k])
            half = 0.5 * (t - self.t[max(k - 1, 0)])
            for i in range(known, model.coordinate.size):  # other angles go on from the sample before
                mean = data.coordinate["rate"][i] + coordinate_rate(model, data, i, t)
                data.coordinate["value"][i] += half * mean
            data.coordinate["value"][:known] = self.arrays["coordinate"][k, :known]  # those of hinges count their turns
            data.unwrap_time[0] = t
            if any(one.joint is not None for one in wanted):
                rows(model, data, t)
                data.row["lam"] = self.arrays["lam"][k]
            values[k] = [measure(model, data, i, t) for i in range(len(wanted))]
            remember(model, data, t)
        return values[:, 0] if isinstance(measures, Measure) else values

    def state_of(self, force: ForceElement | str) -> np.ndarray:
        """Return the internal states (samples, k) of a force element, e.g. of a filter or a `CustomForce`."""
        part = self.system.part(force, "forces")
        entry = self.compiled.model.force[self.system.forces.index(part)]
        return self.arrays["z"][:, entry["state"] : entry["state"] + entry["states"]]

    @property
    def _rows(self) -> RunRows:
        """Return what the rows of the run are taken from."""
        return RunRows(self.compiled, self.t, self.arrays["state"], self.arrays["coordinate"], self.record)

    @cached_property
    def _probes(self) -> list[Probe]:
        """Return what the constraints leave open at a few samples."""
        return self._rows.probes()

    def _shares_of(self, groups: list[list[Joint]]) -> Shares:
        """Return least-norm shares, and what is determined of the net wrenches of joints."""
        origins = [0.0 if isinstance(parts[0].b, Ground) else self.position(parts[0].b) for parts in groups]
        arms = [parts[0].reaction_points(self) - O for parts, O in zip(groups, origins, strict=True)]
        return self._rows.share_out(self.arrays["lam"], [group_of(self.compiled, parts) for parts in groups], arms)

    @cached_property
    def _shares(self) -> tuple[np.ndarray, dict[int, Determined]]:
        """Return multipliers (samples, rows) of least norm, and what is determined of each joint."""
        joints = [joint for joint in self.system.joints if not self._is_unique([joint])]
        lam, determined = self._shares_of([[joint] for joint in joints])
        return lam, dict(zip(map(id, joints), determined, strict=True))

    def _is_unique(self, parts: list[Joint]) -> bool:
        """Return whether all of the net wrench of joints is determined wherever the run was looked at first."""
        return not self._probes or is_unique(self.compiled, self._probes, group_of(self.compiled, parts))

    def _determined(self, parts: list[Joint]) -> Determined:
        """Return directions in which the constraints determine the net wrench of joints of one body b."""
        if self._is_unique(parts):
            return all_determined(self.t.size)
        return self._shares[1][id(parts[0])] if len(parts) == 1 else self._shares_of([parts]).determined[0]

    def reaction(self, *joints: Joint | str, axes: str = "world") -> Reaction:
        """Force [N] and moment [N m] of a joint on its body b at the joint's point.

        Components are along the axes of the world, or with ``axes="a"`` and ``"b"`` along the body axes of a or b, with
        ``"joint"`` along those of the joint: z its axis or normal, fixed in a, x and y across it.
        With several joints of one body b: their net wrench at the first one's point. ``unique`` says whether the
        constraints determine all of it, ``unique_force`` and ``unique_moment`` which components, ``determined_force``
        and ``determined_moment`` are the part they determine, in any direction; indeterminate shares are the ones of
        least norm, which depends on the length unit.
        """
        system, compiled = self.system, self.compiled
        parts = [system.part(joint, "joints") for joint in joints]
        if not parts:
            raise InputError("solution.reaction: no joint given; give one or more joints")
        body = parts[0].b
        for part in parts[1:]:
            if part.b is not body:
                raise InputError(
                    f"solution.reaction: '{system.name(part)}' acts on '{part.b.name}', "
                    f"'{system.name(parts[0])}' on '{body.name}'; net wrenches need one body b"
                )
        turned = axes_of(self, parts[0], axes)
        samples, lam = self.t.size, self.arrays["lam"] if self._is_unique(parts) else self._shares[0]
        total, one = np.zeros((samples, 6)), np.zeros((samples, 6))
        index, data, states = compiled.body_index[id(body)], compiled.data(), self.arrays["state"]
        coordinates = np.ascontiguousarray(self.arrays["coordinate"])
        for part in parts:
            rows = compiled.rows[id(part)]
            wrenches(compiled.model, data, self.t, states, coordinates, lam, rows.start, rows.stop, index, one)
            total += one
        point = parts[0].reaction_points(self)
        origin = np.zeros((samples, 3)) if body is GROUND else self.position(body)
        force = total[:, :3]
        moment = total[:, 3:] - crosses(point - origin, force)
        return self._determined(parts).reaction(force, moment, point, slice(None), turned)

    def effort(self, driver: Driver | str) -> np.ndarray:
        """Return torque [N m] or force [N] of a driver on b along its motion (samples,); (samples, k) for k rows."""
        part = self.system.part(driver, "joints")
        if not isinstance(part, Driver):
            raise InputError(f"'{self.system.name(part)}' ({type(part).__name__}) is not a driver; use reaction")
        rows = self.compiled.rows[id(part)]
        lam = self.arrays["lam"] if self._is_unique([part]) else self._shares[0]
        effort = -lam[:, rows]
        return effort[:, 0] if effort.shape[1] == 1 else effort

    def _reflected_energy(self) -> np.ndarray:
        """Return the kinetic energy (samples,) of the reflected inertias of joints [J]."""
        held = [pair for joint in self.system.joints for pair in joint.reflected()]
        return sum((0.5 * inertia * self._coordinate_rate(x) ** 2 for x, inertia in held), np.zeros(self.t.size))

    @cached_property
    def _energy(self) -> Energy:
        model, system = self.compiled.model, self.system
        kinetic, potential = self._reflected_energy(), self.arrays["potential"].sum(axis=1)
        for body in system.bodies:
            centre, v_com = self._carried(body, body.com)
            w = self.omega_body(body)
            kinetic += 0.5 * body.mass * (v_com**2).sum(axis=1) + 0.5 * np.einsum("ti,ij,tj->t", w, body.inertia, w)
            potential -= body.mass * centre @ system.gravity
        work = self.arrays["z"][:, model.z_work : model.z_impulse].sum(axis=1)
        return Energy(kinetic, potential, kinetic + potential, work)

    def energy(self) -> Energy:
        """Return kinetic, potential (gravity, springs) and total energy, and work of drivers and other forces [J]."""
        return self._energy

    def work(self, part: Driver | ForceElement | str) -> np.ndarray:
        """Return the work [J] since the start of a driver, or of the part of a force that stores no energy."""
        model, system = self.compiled.model, self.system
        if any(part is force or (isinstance(part, str) and part == system.name(force)) for force in system.forces):
            first = model.z_work + system.forces.index(system.part(part, "forces"))
            return self.arrays["z"][:, first]
        rows = self.compiled.rows[id(system.part(part, "joints"))]
        numbers = model.row["drive"][rows]
        return self.arrays["z"][:, model.z_drive + numbers[numbers >= 0]].sum(axis=1)

    def momentum(self) -> Momentum:
        """Return momentum and angular momentum about the world origin."""
        linear, angular = np.zeros((self.t.size, 3)), np.zeros((self.t.size, 3))
        for body in self.system.bodies:
            centre, v_com = self._carried(body, body.com)
            p = body.mass * v_com
            linear += p
            angular += crosses(centre, p)
            angular += np.einsum("tij,tj->ti", self.rotation(body), self.omega_body(body) @ body.inertia)
        return Momentum(linear, angular)

    @cached_property
    def about_centre(self) -> AboutCentre:
        """Return the motion about the centre of mass of the whole, the same for every observer.

        Summed about the middle of the bodies and relative to their mean velocity, then moved to the centre of mass: at
        1e5 m/s the energy of the whole would leave no digits of what goes on in it.
        """
        mass = self.system.total_mass()
        middle, v = self.arrays["q"][..., :3].mean(axis=1), self.arrays["v"][..., :3]
        mean = v.mean(axis=(0, 1)) if self.t.size else np.zeros(3)
        place, velocity, angular = np.zeros((3, self.t.size, 3))
        kinetic, farthest, fastest = self._reflected_energy(), 0.0, 0.0
        for body in self.system.bodies:
            centre, v_com = self._carried(body, body.com)
            s, v, w = centre - middle, v_com - mean, self.omega_body(body)
            farthest = max(farthest, float(np.linalg.norm(s, axis=1).max(initial=0.0)))
            fastest = max(fastest, float(np.linalg.norm(v, axis=1).max(initial=0.0)))
            place += body.mass * s
            velocity += body.mass * v
            kinetic += 0.5 * body.mass * (v**2).sum(axis=1) + 0.5 * np.einsum("ti,ij,tj->t", w, body.inertia, w)
            angular += body.mass * crosses(s, v) + np.einsum("tij,tj->ti", self.rotation(body), w @ body.inertia)
        place, velocity = (x / mass if mass else x for x in (place, velocity))
        kinetic -= 0.5 * mass * (velocity**2).sum(axis=1)
        angular -= mass * crosses(place, velocity)
        return AboutCentre(middle + place, mean + velocity, kinetic, angular, fastest, farthest)

    def drift(self) -> Drift:
        """Return the constraint residuals at the samples."""
        residual = self.arrays["residual"]
        return Drift(residual[:, 0], residual[:, 1])

    def state(self, sample: int = -1) -> State:
        """Return the state at a sample, to start another run from."""
        count = self.t.size
        if not count:
            raise InputError("solution.state: the solution has no samples; run it to a later time")
        whole = isinstance(sample, int | np.integer) and not isinstance(sample, bool)
        if not whole or not -count <= sample < count:
            raise InputError(
                f"solution.state: sample {short_repr(sample)} is not one of {count}; give 0 ... {count - 1}"
            )
        a = self.arrays
        own, q = a["z"][sample, : self.compiled.model.z_work], unit_quaternions(a["q"][sample].ravel())
        coordinates = a["coordinate"][sample, : self.compiled.own_coordinates]
        return State(float(self.t[sample]), q, a["v"][sample].ravel(), own, coordinates)


def unit_quaternions(q: np.ndarray) -> np.ndarray:
    """Return q with |e| = 1 for every body: without stabilisation the norms drift, which R(e) does not see."""
    poses = q.reshape(-1, 7).copy()
    poses[:, 3:] /= np.linalg.norm(poses[:, 3:], axis=1, keepdims=True)
    return poses.ravel()


def world_velocities(states: np.ndarray, n: int) -> np.ndarray:
    """Return world velocities (r_dot, w) (samples, n, 6) from states y with u = (r_dot, R'w)."""
    v = np.empty((states.shape[0], n, 6))
    some = max(1, 2**14 // n)  # samples at a time: their rotation matrices take 1 MB
    for k in range(0, states.shape[0], some):
        y = states[k : k + some]
        u = y[:, 7 * n : 13 * n].reshape(-1, n, 6)
        R = matrix(y[:, : 7 * n].reshape(-1, n, 7)[..., 3:])
        v[k : k + some, :, :3] = u[..., :3]
        v[k : k + some, :, 3:] = np.einsum("tbij,tbj->tbi", R, u[..., 3:])
    return v
