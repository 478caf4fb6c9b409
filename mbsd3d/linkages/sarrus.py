"""Sarrus' linkage: six hinges, three and three parallel, that guide a platform along a straight line."""

import numpy as np
from numpy.typing import ArrayLike

from ..api.system import System
from ..base.checks import number, sequence
from ..base.errors import InputError, checks_arguments
from ..mechanism.bodies import GROUND, Body, Ground
from ..mechanism.joints.pairs import Revolute
from .links import Links, base_frame, link_body

STRAIGHT_LEG_ANGLE = 1e-6  # [rad] a leg whose links lie on one line within this angle has a singular pose
Z = np.array([0.0, 0.0, 1.0])


@checks_arguments
def sarrus(
    first: ArrayLike, second: ArrayLike, between: float, angle: float, *, reach: float = 0.0,
    links: Links = None, position: ArrayLike = (0, 0, 0), orientation: ArrayLike = (1, 0, 0, 0),
    gravity: ArrayLike = (0, 0, -9.81),
) -> System:  # fmt: skip
    """Build Sarrus' linkage: two legs of two links in two vertical planes guide a platform exactly along z, without a
    slide.

    The first leg's plane is xz, the second's is turned from it by `between` about z. The leg's three hinges are
    parallel, normal to its plane, the lowest and the highest `reach` from the z axis. The height of the platform is
    ``h = l_1 sin(angle) + sqrt(l_2^2 - l_1^2 cos^2(angle))``; the second leg takes the height over. Links "link 1",
    "link 2" of the first leg from below, "link 3" the platform, "link 4", "link 5" of the second leg from above;
    hinges in the same order.

    Parameters
    ----------
    first, second : (2,) sequence
        Lower and upper link of each leg [m] > 0.
    between : float
        Angle between the planes of the legs [rad], no multiple of pi.
    angle : float
        Of the first leg's lower link above the xy plane, outwards [rad], 0 < angle < pi.
    reach : float
        Of the lowest and highest hinges from the z axis [m].
    links : (5,) sequence of MassProperties, optional
        In frames at the upper end of each link of a leg (x from its lower end, z normal to its plane), and at the
        platform's height on the z axis, turned as frame 0. None = as in `hinge_loop`.
    position, orientation, gravity
        As in `hinge_loop`: frame 0 has its origin in the plane of the lowest hinges.

    Raises
    ------
    ValueError
        If a leg does not reach the height or is straight, or the planes coincide.
    """
    reach = number(reach, "sarrus: reach")
    lower, upper = (_leg(leg, name) for leg, name in ((first, "first"), (second, "second")))
    if abs(np.sin(number(between, "sarrus: between"))) < STRAIGHT_LEG_ANGLE:
        raise InputError(
            f"sarrus: between {between:g} rad: legs in one plane leave the platform two degrees of freedom"
        )
    rest = lower[1] ** 2 - (lower[0] * np.cos(number(angle, "sarrus: angle"))) ** 2
    if rest < 0.0:
        raise InputError(f"sarrus: at angle {angle:g} rad the first leg of {lower[0]:g} m and {lower[1]:g} m cannot "
                         "end above its foot; choose a steeper angle or a longer upper link")  # fmt: skip
    height = lower[0] * np.sin(angle) + np.sqrt(rest)
    knees = [_knee(leg, height, name) for leg, name in ((lower, "first"), (upper, "second"))]
    base, thick = base_frame(position, orientation, "sarrus"), 0.05 * max(*lower, *upper)
    frame, line = [], []
    for knee, turn in zip(knees, (0.0, between), strict=True):
        out = np.array([np.cos(turn), np.sin(turn), 0.0])
        ends = [reach * out, (reach + knee[0]) * out + knee[1] * Z, reach * out + height * Z]
        frame += [_frame(near, far, out) for near, far in zip(ends[:-1], ends[1:], strict=True)]
        line += [near - far for near, far in zip(ends[:-1], ends[1:], strict=True)]
    top = np.eye(4)
    top[:3, 3] = height * Z
    return _system(base, [*frame[:2], top, *frame[:1:-1]], line, between, reach, thick, links, gravity)


def _system(
    base: np.ndarray, place: list[np.ndarray], line: list[np.ndarray], between: float, reach: float, thick: float,
    links: Links, gravity: ArrayLike,
) -> System:  # fmt: skip
    """Build bodies at their frames 1 ... 5, and hinges at the ends of the legs."""
    out = [np.array([np.cos(turn), np.sin(turn), 0.0]) for turn in (0.0, between)]
    height = place[2][2, 3]
    lines = [line[0], line[1], reach * (out[0] + out[1]), line[3], line[2]]
    bodies = [
        link_body("sarrus", k + 1, base @ T, along, T[:3, :3], thick, links, 5)
        for k, (T, along) in enumerate(zip(place, lines, strict=True))
    ]
    at = [reach * out[0], place[0][:3, 3], reach * out[0] + height * Z, reach * out[1] + height * Z, place[4][:3, 3],
          reach * out[1]]  # fmt: skip
    parts: list[Body | Ground] = [GROUND, *bodies, GROUND]
    R = base[:3, :3]
    axes = [np.cross(out[k // 3], Z) for k in range(6)]
    hinges = [
        Revolute(parts[k], parts[k + 1], at=R @ at[k] + base[:3, 3], axis=R @ axes[k], name=f"hinge {k + 1}")
        for k in range(6)
    ]
    return System(bodies, hinges, gravity=gravity)


def _leg(lengths: ArrayLike, name: str) -> tuple[float, ...]:
    found = sequence(lengths, f"sarrus: {name} leg")
    if len(found) != 2 or min(found) <= 0.0:
        raise InputError(f"sarrus: {name} leg {found}: give two lengths > 0")
    return found


def _knee(leg: tuple[float, ...], height: float, name: str) -> tuple[float, float]:
    """Return (outwards, up) of the hinge between the links of a leg whose upper end is above its foot [m]."""
    up = (leg[0] ** 2 - leg[1] ** 2 + height**2) / (2.0 * height) if height > 0.0 else 0.0
    if height <= 0.0 or not abs(up) < leg[0] * np.cos(STRAIGHT_LEG_ANGLE):
        raise InputError(f"sarrus: the {name} leg of {leg[0]:g} m and {leg[1]:g} m does not reach the height "
                         f"{height:g} m or is straight there; choose another angle or other lengths")  # fmt: skip
    return float(np.sqrt(leg[0] ** 2 - up**2)), float(up)


def _frame(near: np.ndarray, far: np.ndarray, out: np.ndarray) -> np.ndarray:
    """Return the frame at the far end: x from the near end, z normal to the leg's plane."""
    T, x, z = np.eye(4), (far - near) / np.linalg.norm(far - near), np.cross(out, Z)
    T[:3, :3], T[:3, 3] = np.column_stack([x, np.cross(z, x), z]), far
    return T
