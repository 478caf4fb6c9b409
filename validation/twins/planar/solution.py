"""Results of the planar solver, read by part."""

from typing import Any, NamedTuple

import numpy as np

from validation.twins.planar import rows as kinds
from validation.twins.planar.joints import Driver, Rolling, SlideDriver
from validation.twins.planar.system import System


class Reaction(NamedTuple):
    """Of a joint on its body b."""

    force: np.ndarray  # (k, 2) world [N]
    moment: np.ndarray  # (k,) about ``point`` [N m]
    point: np.ndarray  # (k, 2) world [m]


class Energy(NamedTuple):
    """(k,) each [J]; potential of weight and springs."""

    kinetic: np.ndarray
    potential: np.ndarray

    @property
    def total(self) -> np.ndarray:
        """Kinetic and potential."""
        return self.kinetic + self.potential


def turned(angle: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """R(angle) vector, (k,), (2,) -> (k, 2)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]], axis=-1)


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a x b, the component out of the plane."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


class Solution:
    """Samples of a run; bodies, joints and drivers are given by themselves or by their names."""

    def __init__(self, system: System, t: np.ndarray, arrays: tuple, seconds: float) -> None:
        self.system, self.t, self.seconds = system, t, seconds
        self._q, self._v, self._a, self._wrench = arrays

    def _row(self, array: np.ndarray, body: Any) -> np.ndarray:
        """(k, 3) of a body; zeros for the ground."""
        if getattr(body, "name", body) == "ground":
            return np.zeros((len(self.t), 3))
        return array[:, self.system.part(body, "bodies")]

    def position(self, body: Any) -> np.ndarray:
        """(k, 2) of the reference point O [m]."""
        return self._row(self._q, body)[:, :2]

    def angle(self, body: Any) -> np.ndarray:
        """(k,) direction of the x axis of a body, not wrapped [rad]."""
        return self._row(self._q, body)[:, 2]

    def velocity(self, body: Any) -> np.ndarray:
        """(k, 2) of O [m/s]."""
        return self._row(self._v, body)[:, :2]

    def omega(self, body: Any) -> np.ndarray:
        """(k,) [rad/s]."""
        return self._row(self._v, body)[:, 2]

    def acceleration(self, body: Any) -> np.ndarray:
        """(k, 2) of O [m/s^2]."""
        return self._row(self._a, body)[:, :2]

    def alpha(self, body: Any) -> np.ndarray:
        """(k,) [rad/s^2]."""
        return self._row(self._a, body)[:, 2]

    def point(self, body: Any, local: np.ndarray) -> np.ndarray:
        """(k, 2) of a point given in body axes from O [m]."""
        return self.position(body) + turned(self.angle(body), local)

    def com(self, body: Any) -> np.ndarray:
        """(k, 2) centre of mass [m]."""
        return self.point(body, self.system.bodies[self.system.part(body, "bodies")].com)

    def reaction(self, joint: Any) -> Reaction:
        """Force and moment of a joint on its body b, at its point (of a rolling disc: the contact).

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
        """(k,) torque [N m] or force along the axis [N] of a driver on body b."""
        joint = self.system.joints[self.system.part(driver, "joints")]
        if not isinstance(joint, Driver):
            raise ValueError(f"{self.system.name(joint)} is not a driver; ask for its reaction")
        reaction = self.reaction(joint)
        if not isinstance(joint, SlideDriver):
            return reaction.moment
        slider = joint.through
        return np.sum(reaction.force * turned(self.angle(slider.a), slider.a.local(slider.axis)), axis=1)

    def energy(self) -> Energy:
        """Kinetic energy m v_G^2 / 2 + I_G w^2 / 2; potential of weight and springs."""
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
