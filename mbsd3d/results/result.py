"""The result of a run: every quantity by part, in world axes and SI units."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..base.checks import short_repr
from ..base.errors import InputError
from ..base.rotations import crosses
from ..base.style import Sampled
from ..base.wording import with_article
from ..dynamics.batch import at_body_point, joint_reactions, joint_wrenches
from ..equations.compiled import Compiled, compile_system, new_data, tables_of
from ..kernels.coordinates import coordinate_rate, remember
from ..kernels.kinematics import kinematics, world_velocities
from ..kernels.layout import Data
from ..kernels.measures import measure
from ..kernels.rows import rows
from ..mechanism.bodies import Body, Ground
from ..mechanism.drivers import Driver
from ..mechanism.force_element import ForceElement
from ..mechanism.joints import Joint, coordinate_of
from ..mechanism.measures import Measure, check_members
from ..mechanism.primitives import Coordinate, TurnRate
from ..mechanism.state import State
from .elastic_shares import Elasticity, PairsOfJoints, elastic_shares
from .events import Event
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
    joined_reactions,
)
from .record import Record

WRENCH_NUMBERS_MAX = 2**17  # [numbers] of the wrenches of all joints that a result keeps: 1 MB


@dataclass(frozen=True, repr=False)
class Energy(Sampled):
    """Energies [J] at the samples; ``work`` was done by drivers and by forces that store none, ``lost`` in impacts."""

    kinetic: np.ndarray
    potential: np.ndarray
    total: np.ndarray
    work: np.ndarray
    lost: np.ndarray

    def shown(self) -> dict[str, np.ndarray]:
        """Return the energies by name, for tables and curves; those lost in impacts only where there were any."""
        return {name: values for name, values in vars(self).items() if name != "lost" or values.any()}


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
    """Motion of the whole system: of its centre of mass, and about it."""

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
    pieces: tuple["RunResult", ...] = ()  # of a run with parts that switch, from one event to the next
    events: tuple[Event, ...] = ()
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
        arrays["v"] = world_velocities_of(states, n)
        arrays["z"] = states[:, 13 * n :]
        arrays["acceleration"] = arrays["acceleration"].reshape(-1, n, 6)
        at_end = len(states) > 0 and states[-1].tobytes() == y.tobytes()
        v = arrays["v"][-1] if at_end else world_velocities_of(y[None], n)[0]
        own = y[13 * n : 13 * n + compiled.model.z_work]
        coordinates = data.coordinate["value"][: compiled.own_coordinates].copy()
        made = State.of_numbers if math.isfinite(y.sum()) else State
        end = made(t, unit_quaternions(y[: 7 * n]), v.flatten(), own.copy(), coordinates, modes=dict(compiled.modes))
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
            return self.measure(
                Measure("coordinate rate", f"rate of {with_article(x.kind)}", "m/s", x.a, x.b, coordinate=x)
            )
        axis = self.body_axis(x.a, x.axis)
        w_a, w_b = self._turning(x.a), self._turning(x.b)
        if x.kind == "angle":
            return np.einsum("ti,ti->t", axis, w_b - w_a)
        p_b, v_b = self._point_motion(x.b, x.point_b)
        v_a_there = 0.0 if isinstance(x.a, Ground) else self.velocity(x.a) + crosses(w_a, p_b - self.position(x.a))
        return np.einsum("ti,ti->t", axis, v_b - v_a_there)

    def _turning(self, body: Body | Ground) -> np.ndarray:
        """Return (samples, 3) angular velocity of a body, or of the ground."""
        return np.zeros((self.t.size, 3)) if isinstance(body, Ground) else self.omega(body)

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
        two of them the mean of both rates must predict the rotation to within half a turn.
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
        if self.pieces and any(one.joint is not None for one in wanted):
            return np.concatenate([piece.measure(measures) for piece in self.pieces])
        model = compile_system(self.system, tuple(one.plain() for one in wanted), modes=self.compiled.modes).model
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
        for i, one in enumerate(wanted):
            if one.plain() is not one:
                values[:, i] = one.factor * values[:, i] + one.offset
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
        if self.pieces:
            return all(piece._is_unique(parts) for piece in self.pieces)
        return not self._probes or is_unique(self.compiled, self._probes, group_of(self.compiled, parts))

    @cached_property
    def _all_determined(self) -> Determined:
        """Return the record of a wrench that is fully determined at every sample."""
        return all_determined(self.t.size)

    def _determined(self, parts: list[Joint]) -> Determined:
        """Return directions in which the constraints determine the net wrench of joints of one body b."""
        if self._is_unique(parts):
            return self._all_determined
        return self._shares[1][id(parts[0])] if len(parts) == 1 else self._shares_of([parts]).determined[0]

    def reaction(
        self,
        *joints: Joint | str,
        axes: str = "world",
        shares: str = "least norm",
        stiffness: PairsOfJoints | None = None,
        tolerances: PairsOfJoints | None = None,
    ) -> Reaction:
        """Force [N] and moment [N m] of a joint on its body b at the joint's point.

        Components are along the axes of the world, or with ``axes="a"`` and ``"b"`` along the body axes of a or b, with
        ``"joint"`` along those of the joint: z its axis or normal, fixed in a, x and y across it. With several joints
        of one body b: their net wrench at the first one's point. ``unique`` says whether the constraints determine all
        of it, ``unique_force`` and ``unique_moment`` which components, ``determined_force`` and ``determined_moment``
        are the part they determine, in any direction; indeterminate shares are those of least norm, which depends on
        the unit of length, or as ``shares`` selects.

        Parameters
        ----------
        shares : "least norm", "elastic" or "range"
            How redundant joints share the loads that are not determined. "elastic": as stiff joints do, with the least
            energy ``sum lam_i^2 / (2 stiffness_i)`` over their rows. "range": "elastic", and in ``force_margin`` and
            ``moment_margin`` by how much each component may lie above or below, if rows are assembled as far apart as
            ``tolerances`` allow.
        stiffness : (translational [N/m], rotational [N m/rad]) or mapping of joints to such pairs
            Of one joint along and about the directions it holds, at its point; one pair applies to all joints, the key
            None to all that a mapping does not name. Only joints that share loads need a value. Couplings over several
            hinges: of their row, in its own unit.
        tolerances : (position [m], direction [rad]) or mapping of joints to such pairs
            Largest misalignment of b in each row of a joint; a point has rows along the world axes.

        Raises
        ------
        ValueError
            For an unknown joint, several joints of several bodies b, and a joint that shares loads and is not given.

        Examples
        --------
        >>> from mbsd3d import GROUND, Body, Revolute, System, accelerations
        >>> door = Body("door", 20.0, (2.0, 2.0, 2.0), com=(0.4, 0, 0))
        >>> hinges = [Revolute(GROUND, door, at=(0, 0, z), axis=(0, 0, 1), name=f"hinge {z}") for z in (-0.5, 0.5)]
        >>> hung = accelerations(System([door], hinges))
        >>> found = hung.reaction("hinge 0.5", shares="range", stiffness=(1e7, 1e3), tolerances=(1e-5, 1e-4))
        >>> found.force.round(2) + 0.0, found.force_margin.round(2)  # m g / 2 and 1e7 N/m 1e-5 m lengthwise
        (array([[-78.45,   0.  ,  98.1 ]]), array([[  0.24,   0.24, 100.  ]]))
        """
        given = Elasticity.of(self.compiled, shares, stiffness, tolerances)
        system = self.system
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
        if self.pieces:
            return joined_reactions(
                [
                    piece.reaction(*joints, axes=axes, shares=shares, stiffness=stiffness, tolerances=tolerances)
                    for piece in self.pieces
                ]
            )
        turned = axes_of(self, parts[0], axes)
        apart: np.ndarray | None = None
        wrenches: Sequence[np.ndarray] | np.ndarray
        if self._is_unique(parts):
            wrenches = self._wrenches(parts)
        elif given is None:
            wrenches = self._wrenches_by(self._shares[0], parts)
        else:
            origin = np.zeros((self.t.size, 3)) if isinstance(body, Ground) else self.position(body)
            arm, group = parts[0].reaction_points(self) - origin, group_of(self.compiled, parts)
            lam, apart = elastic_shares(self._rows, self.arrays["lam"], group, given, arm)
            wrenches = self._wrenches_by(lam, parts)
        net = wrenches[0] if len(parts) == 1 else sum(wrenches[1:], wrenches[0])
        force, moment, point = self._at_point(parts[0], net)
        found = self._determined(parts).reaction(force, moment, point, slice(None), turned)
        if shares != "range":
            return found
        apart = np.zeros((self.t.size, 6, 0)) if apart is None else apart
        moved = (x if turned is None else turned @ x for x in np.split(apart, 2, axis=1))
        of_force, of_moment = (np.abs(x).sum(axis=2) for x in moved)
        return replace(found, margins=(of_force, of_moment))

    def _wrenches(self, joints: Sequence[Joint]) -> list[np.ndarray]:
        """Return force and moment about O of their bodies b of joints, (samples, 6) each, by the run's multipliers."""
        if not self._keeps_reactions:
            return list(self._wrenches_by(self.arrays["lam"], joints))
        return [self._every_reaction[id(joint)][0] for joint in joints]

    @property
    def _keeps_reactions(self) -> bool:
        """Return whether the samples are so few that the reactions of all joints are computed at once and kept."""
        return 6 * len(self.system.joints) * self.t.size <= WRENCH_NUMBERS_MAX

    @cached_property
    def _every_reaction(self) -> dict[int, tuple[np.ndarray, np.ndarray]]:
        """Return of each joint, by id: force and moment about O of its body b (samples, 6), and `at_body_point`.

        Rows are evaluated once for all joints.
        """
        every, model, count = self.system.joints, self.compiled.model, self.t.size
        wrenches, out = np.empty((len(every), count, 6)), np.empty((len(every), count, 9))
        on = self._rows_on_b(every)
        local = self.compiled.frames.points(on[:, 2], [x.point() for x in every]) if every else np.zeros((0, 3))
        joint_reactions(model, self.compiled.data(), *self._samples(self.arrays["lam"]), on, local, wrenches, out)
        return {id(joint): (wrenches[i], out[i]) for i, joint in enumerate(every)}

    def _samples(self, lam: np.ndarray) -> list[np.ndarray]:
        """Return times, states, hinge coordinates and multipliers as kernels read them."""
        given = (self.t, self.arrays["state"], self.arrays["coordinate"], lam)
        return [np.ascontiguousarray(x) for x in given]

    def _rows_on_b(self, joints: Sequence[Joint]) -> np.ndarray:
        """Return (k, 3) first row of each joint, end of its rows, number of its body b."""
        compiled = self.compiled
        rows = [(compiled.rows[id(joint)], compiled.body_index[id(joint.b)]) for joint in joints]
        return np.array([(own.start, own.stop, body) for own, body in rows], np.int64).reshape(-1, 3)

    def _wrenches_by(self, lam: np.ndarray, joints: Sequence[Joint]) -> np.ndarray:
        """Return force and moment about O of their bodies b of k joints (k, samples, 6), by multipliers."""
        out = np.empty((len(joints), self.t.size, 6))
        joint_wrenches(self.compiled.model, self.compiled.data(), *self._samples(lam), self._rows_on_b(joints), out)
        return out

    def _at_point(self, joint: Joint, wrench: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return force, moment about the point of a joint, and that point, from force and moment about O of body b."""
        body, states = self.compiled.body_index[id(joint.b)], np.ascontiguousarray(self.arrays["state"])
        if has_own_point(joint):
            if self._keeps_reactions and wrench is self._every_reaction[id(joint)][0]:
                out = self._every_reaction[id(joint)][1]
            else:
                out = np.empty((self.t.size, 9))
                local = self.compiled.frames.points(np.array([body]), [joint.point()])[0]
                at_body_point(self.compiled.model, states, body, local, wrench, out)
            return out[:, :3], out[:, 3:6], out[:, 6:]
        point = joint.reaction_points(self)
        origin = np.zeros((self.t.size, 3)) if isinstance(joint.b, Ground) else self.position(joint.b)
        force = wrench[:, :3].copy()
        return force, wrench[:, 3:] - crosses(point - origin, force), point

    def effort(self, driver: Driver | str) -> np.ndarray:
        """Return torque [N m] or force [N] of a driver on b along its motion (samples,); (samples, k) for k rows."""
        part = self.system.part(driver, "joints")
        if not isinstance(part, Driver):
            raise InputError(f"'{self.system.name(part)}' ({type(part).__name__}) is not a driver; use reaction")
        if self.pieces:
            return np.concatenate([piece.effort(part) for piece in self.pieces])
        rows = self.compiled.rows[id(part)]
        lam = self.arrays["lam"] if self._is_unique([part]) else self._shares[0]
        effort = -lam[:, rows]
        return effort[:, 0] if effort.shape[1] == 1 else effort

    def _reflected_rate(self, x: Coordinate | TurnRate) -> np.ndarray:
        """Return the rate (samples,) that a reflected inertia has [rad/s or m/s]."""
        if isinstance(x, TurnRate):
            return np.einsum("ti,ti->t", self.body_axis(x.b, x.axis), self._turning(x.b) - self._turning(x.a))
        return self._coordinate_rate(x)

    def _reflected_energy(self) -> np.ndarray:
        """Return the kinetic energy (samples,) of the reflected inertias of joints [J]."""
        held = [pair for joint in self.system.joints for pair in joint.reflected()]
        return sum((0.5 * inertia * self._reflected_rate(x) ** 2 for x, inertia in held), np.zeros(self.t.size))

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
        return Energy(kinetic, potential, kinetic + potential, work, self._lost)

    @cached_property
    def _lost(self) -> np.ndarray:
        """Return the energy [J] lost in impacts so far (samples,)."""
        counts = [piece.t.size for piece in self.pieces] or [0]
        counts[0] += self.t.size - sum(counts)  # the start, where it is put before the samples
        lost = np.cumsum([0.0, *(event.lost for event in self.events)])
        return np.repeat(lost[: len(counts)], counts)

    def energy(self) -> Energy:
        """Return energies (kinetic, potential, total), work of drivers and other forces, and impact losses [J]."""
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
        1e5 m/s the energy of the whole would leave no digits for the motion within it.
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
        modes = dict(self.piece_at(sample).compiled.modes)
        return State(float(self.t[sample]), q, a["v"][sample].ravel(), own, coordinates, modes=modes)

    def piece_at(self, sample: int) -> "RunResult":
        """Return the part of the run between two events that has a sample, or the run itself."""
        ends = np.cumsum([piece.t.size for piece in self.pieces])
        return self.pieces[int(np.searchsorted(ends, sample % self.t.size, side="right"))] if self.pieces else self


def has_own_point(joint: Joint) -> bool:
    """Return whether the reaction of a joint is given at a point of its body b."""
    return type(joint).reaction_points is Joint.reaction_points


def unit_quaternions(q: np.ndarray) -> np.ndarray:
    """Return q with |e| = 1 for every body: without stabilisation the norms drift, which R(e) does not see."""
    poses = q.reshape(-1, 7).copy()
    e = poses[:, 3:]
    e /= np.sqrt((e * e).sum(axis=1, keepdims=True))
    return poses.ravel()


def world_velocities_of(states: np.ndarray, n: int) -> np.ndarray:
    """Return world velocities (r_dot, w) (samples, n, 6) from states y with u = (r_dot, R'w)."""
    v = np.empty((states.shape[0], n, 6))
    world_velocities(states, v)
    return v
