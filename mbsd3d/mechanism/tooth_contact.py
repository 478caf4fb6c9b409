"""Geometry of a tooth contact at a pitch point: parallel axes, intersecting axes (bevel), crossed axes, hypoid gears.

Gear i turns about the line (p_i, u_i); d_i leads from it to the pitch point P at right angles, r_i = |d_i|. The pitch
surfaces touch in P; their common tangent plane is spanned by the pitch velocity t = u x d / r of gear a and by its
element g (along the axis, or from the apex of its cone to P); e is its normal, away from the axis of gear a. Of hypoid
gears each has a cone of its own: the plane holds the velocities of both, e = t_a x t_b, and g = e x t meets the axis.
"""

from dataclasses import dataclass

import numpy as np

from ..base.errors import InputError

COLLINEAR_TOLERANCE = 1e-6
"""Sine of the angle below which given directions count as one, and part of a length below which it counts as zero."""
PITCH_SINE_MIN = 1e-2
"""Least sine of the angle between the velocities of hypoid gears in the pitch plane, which they must determine."""


@dataclass(frozen=True)
class Axle:
    """Axis of a gear: a point on it and its unit direction, world coordinates at the reference pose [m]."""

    point: np.ndarray
    axis: np.ndarray

    def arm(self, at: np.ndarray) -> np.ndarray:
        """The perpendicular from the axis to a point, (3,) [m]."""
        reach = at - self.point
        return reach - (reach @ self.axis) * self.axis


def apex(a: Axle, b: Axle) -> np.ndarray:
    """The point where two axes in one plane meet, (3,)."""
    along = np.linalg.lstsq(np.column_stack([a.axis, -b.axis]), b.point - a.point, rcond=None)[0][0]
    return a.point + along * a.axis


def pitch_frame(a: Axle, b: Axle, at: np.ndarray, what: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(t, e, g) of gear a at the pitch point: along its velocity, away from its axis, along the tooth of a spur gear.

    ValueError where the point cannot be the pitch point of two pitch surfaces that touch.
    """
    arms = [axle.arm(at) for axle in (a, b)]
    radii = [float(np.linalg.norm(arm)) for arm in arms]
    if min(radii) < COLLINEAR_TOLERANCE * max(1.0, *radii):
        raise InputError(f"{what}: at = {at.tolist()} lies on an axis; give the point where the pitch circles touch")
    t, t_b = (np.cross(axle.axis, arm) / r for axle, arm, r in zip((a, b), arms, radii, strict=True))
    if np.linalg.norm(np.cross(arms[0], arms[1])) < COLLINEAR_TOLERANCE * radii[0] * radii[1]:
        g = a.axis  # parallel axes, or crossed ones with P on their common perpendicular
    elif np.linalg.norm(np.cross(t, t_b)) < COLLINEAR_TOLERANCE:
        g = at - apex(a, b)  # bevel gears: all in one plane
        g /= np.linalg.norm(g)
    else:
        g = np.cross(common_normal(a, b, t, t_b, at, what), t)
    if abs(g @ a.axis) < COLLINEAR_TOLERANCE:
        raise InputError(f"{what}: gear a is a flat crown wheel; give the hinge of the pinion as hinge_a")
    g = g * np.sign(g @ a.axis)
    e = np.cross(t, g)
    return t, e * np.sign(e @ arms[0]), g


def common_normal(a: Axle, b: Axle, t_a: np.ndarray, t_b: np.ndarray, at: np.ndarray, what: str) -> np.ndarray:
    """e = t_a x t_b / |t_a x t_b|: the normal of the pitch plane of hypoid gears.

    ValueError for axes that are parallel or meet, and where the velocities are too nearly parallel to say which plane.
    """
    across, normal = np.cross(a.axis, b.axis), np.cross(t_a, t_b)
    sine = np.linalg.norm(across)
    apart = abs((b.point - a.point) @ across) / sine if sine > COLLINEAR_TOLERANCE else 0.0
    if apart < COLLINEAR_TOLERANCE * np.linalg.norm(a.arm(at)):
        raise InputError(
            f"{what}: at = {at.tolist()} is not a pitch point of these axes: they "
            f"{'meet' if sine > ALIGNED else 'are parallel'}, so it must lie in their common plane; only axes that "
            "cross may have it elsewhere"
        )
    if np.linalg.norm(normal) < PITCH_SINE_MIN:
        raise InputError(
            f"{what}: at = {at.tolist()}: both gears move there in nearly one direction, so the pitch plane of these "
            "hypoid gears is not certain; move it, or let the axes meet"
        )
    return normal / np.linalg.norm(normal)


def line_of_action(
    a: Axle, b: Axle, at: np.ndarray, pressure: float, helix: float, flank: int, what: str
) -> np.ndarray:
    """Unit direction n of the force on gear b through the pitch point, world at the reference pose (3,).

    n = +-(t cos(helix) - g sin(helix)) cos(pressure) +- e sin(pressure): normal to the tooth trace of gear a; the first
    sign turns gear b forwards (flank 1) or backwards (-1), the second presses every external gear towards its axis.
    """
    t, e, g = pitch_frame(a, b, at, what)
    arm, other = a.arm(at), b.arm(at)
    inside = e @ other > 0.0  # internal mesh: both axes on one side, the gear of the smaller radius is the external one
    if inside and abs(np.linalg.norm(arm) - np.linalg.norm(other)) < COLLINEAR_TOLERANCE * np.linalg.norm(arm):
        raise InputError(f"{what}: the gears of this internal mesh have one pitch circle; give a pitch point off it")
    side = -1.0 if inside and np.linalg.norm(arm) > np.linalg.norm(other) else 1.0
    trace_normal = t * np.cos(helix) - g * np.sin(helix)
    turn = trace_normal @ np.cross(b.axis, other)
    if min(abs(turn), abs(trace_normal @ t) * np.linalg.norm(other)) < 1e-6 * np.linalg.norm(other):
        raise InputError(f"{what}: helix_angle {helix:g} rad: the teeth of a gear run along its motion; give another")
    return flank * np.sign(turn) * trace_normal * np.cos(pressure) + side * e * np.sin(pressure)
