"""Poses over time, read by part, the common base of runs and modes; and the motion of a run."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import shown, vector
from ..base.directions import crosses
from ..base.errors import InputError
from ..base.rotations import matrix
from ..equations.compiled import Compiled, compile_system, new_data, tables_of
from ..kernels.coordinates import coordinate_rate, measure, remember
from ..kernels.kinematics import kinematics
from ..mechanism.bodies import GROUND, Body, Ground
from ..mechanism.force_element import ForceElement
from ..mechanism.joints import Joint, coordinate_of
from ..mechanism.measures import Measure, check_members
from ..mechanism.mechanism import Mechanism
from ..mechanism.primitives import Coordinate


class Poses:
    """Reading of ``arrays["q"]`` (samples, n, 7) at times ``t``; parts are given as objects or by name."""

    compiled: Compiled
    arrays: dict[str, np.ndarray]
    t: np.ndarray

    @property
    def system(self) -> Mechanism:
        """The system that moves."""
        return self.compiled.system

    def _body(self, body: Body | str) -> int:
        index = self.compiled.body_index.get(id(body), self.compiled.model.body.size)
        return index if index < self.compiled.model.body.size else self.compiled.body_index[id(self.system.part(body))]

    def position(self, body: Body | str) -> np.ndarray:
        """Reference point of a body [m]."""
        return self.arrays["q"][:, self._body(body), :3]

    def orientation(self, body: Body | str) -> np.ndarray:
        """(samples, 4) unit quaternion of a body, scalar first, body -> world."""
        return self.arrays["q"][:, self._body(body), 3:]

    def rotation(self, body: Body | str) -> np.ndarray:
        """(samples, 3, 3) rotation matrix of a body, body -> world."""
        return matrix(self.orientation(body))

    def com(self, body: Body | str) -> np.ndarray:
        """Centre of mass [m]."""
        return self.point(body, self.system.part(body).com)

    def point(self, body: Body | str, local: ArrayLike) -> np.ndarray:
        """World position of a point given in body axes from the reference point [m]."""
        return self.position(body) + self.rotation(body) @ vector(local, "point: local")

    def body_axis(self, body: Body | Ground | str, axis: ArrayLike) -> np.ndarray:
        """(samples, 3) world direction of an axis fixed in a body (or GROUND), given at the reference pose."""
        if body is GROUND:
            return np.broadcast_to(vector(axis, "body_axis: axis"), (self.t.size, 3))
        return self.rotation(body) @ self.system.part(body).local_axis(axis)

    def body_point(self, body: Body | Ground | str, point: ArrayLike) -> np.ndarray:
        """(samples, 3) world position of a point fixed in a body (or GROUND), given at the reference pose [m]."""
        if body is GROUND:
            return np.broadcast_to(vector(point, "body_point: point"), (self.t.size, 3))
        return self.point(body, self.system.part(body).local_point(point))


class RunMotion(Poses):
    """Reading of velocities, accelerations, joint coordinates, measures and own states of a run, by part."""

    @property
    def t(self) -> np.ndarray:
        """(samples,) times [s]."""
        return self.arrays["t"]

    def velocity(self, body: Body | str) -> np.ndarray:
        """Velocity of the reference point [m/s]."""
        return self.arrays["v"][:, self._body(body), :3]

    def omega(self, body: Body | str) -> np.ndarray:
        """Angular velocity [rad/s], world axes."""
        return self.arrays["v"][:, self._body(body), 3:]

    def omega_body(self, body: Body | str) -> np.ndarray:
        """Angular velocity [rad/s], body axes."""
        return np.einsum("tji,tj->ti", self.rotation(body), self.omega(body))

    def acceleration(self, body: Body | str) -> np.ndarray:
        """Acceleration of the reference point [m/s^2]."""
        return self.arrays["acceleration"][:, self._body(body), :3]

    def alpha(self, body: Body | str) -> np.ndarray:
        """Angular acceleration [rad/s^2], world axes."""
        return self.arrays["acceleration"][:, self._body(body), 3:]

    def _coordinate(self, joint: Joint | str, kind: str) -> np.ndarray:
        part = self.system.part(joint, "joints")
        return self.compiled.coordinate(coordinate_of(part, kind, f"solution.{kind}"))

    def angle(self, joint: Joint | str) -> np.ndarray:
        """(samples,) angle of a hinge [rad], unwrapped, zero at the reference pose."""
        return self.arrays["coordinate"][:, self._coordinate(joint, "angle")]

    def slide(self, joint: Joint | str) -> np.ndarray:
        """(samples,) displacement of a sliding joint [m]."""
        return self.arrays["coordinate"][:, self._coordinate(joint, "slide")]

    def rate(self, joint: Joint | str) -> np.ndarray:
        """(samples,) rate of a hinge's angle [rad/s], or of a slide [m/s] where there is no angle."""
        part = self.system.part(joint, "joints")
        x = part.angle() or part.slide()
        if x is None:
            raise InputError(f"'{self.system.name(part)}' has no angle and no slide; give a hinge or a slider")
        return self._coordinate_rate(x)

    def _coordinate_rate(self, x: Coordinate) -> np.ndarray:
        """(samples,) rate of a hinge coordinate [rad/s or m/s]."""
        if x.kind not in ("angle", "slide"):
            return self.measure(Measure("coordinate rate", f"rate of a {x.kind}", "m/s", x.a, x.b, coordinate=x))
        axis = self.body_axis(x.a, x.axis)
        w_a, w_b = (np.zeros((self.t.size, 3)) if body is GROUND else self.omega(body) for body in (x.a, x.b))
        if x.kind == "angle":
            return np.einsum("ti,ti->t", axis, w_b - w_a)
        p_b, v_b = self._point_motion(x.b, x.point_b)
        v_a_there = 0.0 if x.a is GROUND else self.velocity(x.a) + crosses(w_a, p_b - self.position(x.a))
        return np.einsum("ti,ti->t", axis, v_b - v_a_there)

    def _point_motion(self, body: Body | Ground, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """World position and velocity of a body point given at the reference pose."""
        if body is GROUND:
            return np.broadcast_to(point, (self.t.size, 3)), np.zeros((self.t.size, 3))
        return self._carried(body, body.local_point(point))

    def _carried(self, body: Body, local: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """World position and velocity of a point given in body axes from the reference point."""
        arm = self.rotation(body) @ local
        return self.position(body) + arm, self.velocity(body) + crosses(self.omega(body), arm)

    def measure(self, measures: Measure | Sequence[Measure]) -> np.ndarray:
        """(samples,) values of one of `mbsd3d.measures`, (samples, k) of k of them.

        Angles of hinges are those of the run. Other angles, e.g. headings, are followed from sample to sample: between
        two of them the mean of both rates must tell the turn to within half a turn.
        """
        wanted = tuple(measures) if isinstance(measures, list | tuple) else (measures,)
        for one in wanted:
            if not isinstance(one, Measure):
                raise InputError(f"solution.measure: {shown(one)} is not a measure; build one with mbsd3d.measures")
            check_members(self.system, one, "solution.measure")
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
            values[k] = [measure(model, data, i, t) for i in range(len(wanted))]
            remember(model, data, t)
        return values[:, 0] if isinstance(measures, Measure) else values

    def state_of(self, force: ForceElement | str) -> np.ndarray:
        """(samples, k) own states of a force element, e.g. of a filter or a `CustomForce`."""
        part = self.system.part(force, "forces")
        entry = self.compiled.model.force[self.system.forces.index(part)]
        return self.arrays["z"][:, entry["state"] : entry["state"] + entry["states"]]
