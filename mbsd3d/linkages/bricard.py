"""Loops of six hinges: Bricard's with a line or a plane of symmetry, his orthogonal one, and Schatz's."""

import numpy as np
from numpy.typing import ArrayLike

from ..api.system import System
from ..base.checks import number, sequence
from ..base.errors import InputError, checks_arguments
from .dh import built, closed_angles, table
from .links import Links

RIGHT_ANGLE = 0.5 * np.pi


@checks_arguments
def bricard_line(
    lengths: ArrayLike, twists: ArrayLike, offsets: ArrayLike, angle: float, *,
    near: ArrayLike | None = None, links: Links = None, position: ArrayLike = (0, 0, 0),
    orientation: ArrayLike = (1, 0, 0, 0), gravity: ArrayLike = (0, 0, -9.81),
) -> System:  # fmt: skip
    """Build Bricard's line-symmetric linkage: opposite links are equal, ``a_k = a_{k+3}``, and so are twists and
    offsets.

    Opposite angles are equal: the half loop is a half-turn about the line, ``(A_1 A_2 A_3)^2 = 1``.

    Parameters
    ----------
    lengths, twists, offsets : (3,) sequence
        a [m], alpha [rad], d [m] of links 1, 2, 3, those of 4, 5, 6 as well; link 6 is the ground.
    angle : float
        theta_1 [rad].
    near : (2,) sequence, optional
        theta_2, theta_3 [rad] of a pose near by: a loop has several at one angle. None = the first one found.
    links, position, orientation, gravity
        As in `hinge_loop`.

    Raises
    ------
    ValueError
        If the loop has no pose with this angle.
    """
    angle = number(angle, "bricard_line: angle")
    numbers = np.vstack(2 * [table(lengths, twists, offsets, "bricard_line")])
    _six("bricard_line", numbers)
    angles = closed_angles("bricard_line", numbers, lambda x: np.array([angle, *x, angle, *x]), 2, near)
    return built("bricard_line", numbers, angles, links, position, orientation, gravity)


@checks_arguments
def bricard_plane(
    lengths: ArrayLike, twists: ArrayLike, offsets: ArrayLike, angle: float, *,
    near: ArrayLike | None = None, links: Links = None, position: ArrayLike = (0, 0, 0),
    orientation: ArrayLike = (1, 0, 0, 0), gravity: ArrayLike = (0, 0, -9.81),
) -> System:  # fmt: skip
    """Build Bricard's plane-symmetric linkage: the axes 1 and 4 lie in the plane, the others are mirrored in it.

    ``a_6 = a_1, a_5 = a_2, a_4 = a_3``; ``alpha_6 = -alpha_1, alpha_5 = -alpha_2, alpha_4 = -alpha_3``; ``d_1 = d_4 =
    0, d_6 = -d_2, d_5 = -d_3``; then ``theta_6 = theta_2, theta_5 = theta_3``. A twist of ``pi - alpha`` in a table is
    the same axis counted the other way.

    Parameters
    ----------
    lengths, twists : (3,) sequence
        a [m] and alpha [rad] of links 1, 2, 3; link 6 is the ground.
    offsets : (2,) sequence
        d_2, d_3 [m].
    angle : float
        theta_1 [rad].
    near : (3,) sequence, optional
        theta_2, theta_3, theta_4 [rad] of a pose near by. None = the first one found.
    links, position, orientation, gravity
        As in `hinge_loop`.

    Raises
    ------
    ValueError
        If the loop has no pose with this angle.
    """
    angle = number(angle, "bricard_plane: angle")
    half = table(lengths, twists, (0.0, *sequence(offsets, "bricard_plane: offsets")), "bricard_plane")
    a, alpha, d = half.T
    numbers = np.c_[np.r_[a, a[::-1]], np.r_[alpha, -alpha[::-1]], np.r_[d, 0.0, -d[2], -d[1]]]
    _six("bricard_plane", numbers)
    angles = closed_angles("bricard_plane", numbers, lambda x: np.array([angle, x[0], x[1], x[2], x[1], x[0]]), 3, near)
    return built("bricard_plane", numbers, angles, links, position, orientation, gravity)


@checks_arguments
def bricard(
    length: float, angle: float, *, links: Links = None, position: ArrayLike = (0, 0, 0),
    orientation: ArrayLike = (1, 0, 0, 0), gravity: ArrayLike = (0, 0, -9.81),
) -> System:  # fmt: skip
    """Build Bricard's orthogonal linkage of six equal links: the A04 of the IFToMM library is ``bricard(1.0, pi / 2)``.

    Twists are 90 and -90 degrees in turns, no offsets; angles are theta, phi in turns with
    ``cos(theta) + cos(phi) + cos(theta) cos(phi) = 0``, so ``|theta| <= 120`` degrees. At 90 degrees the links are
    edges of a cube.

    Parameters
    ----------
    length : float
        a [m].
    angle : float
        theta_1 [rad].
    links, position, orientation, gravity
        As in `hinge_loop`; link 6 is the ground.

    Raises
    ------
    ValueError
        If the loop has no pose with this angle, or the length is not positive.
    """
    length, angle = number(length, "bricard: length"), number(angle, "bricard: angle")
    if not length > 0.0 or not np.cos(angle) > -0.5:
        raise InputError(f"bricard: length {length:g} m, angle {np.degrees(angle):.6g} degrees; give a positive length "
                         "and an angle between -120 and 120 degrees, where the loop closes")  # fmt: skip
    phi = float(np.arccos(-np.cos(angle) / (1.0 + np.cos(angle))))
    numbers = np.array([[length, RIGHT_ANGLE, 0.0], [length, -RIGHT_ANGLE, 0.0]] * 3)
    return built("bricard", numbers, np.array([angle, phi] * 3), links, position, orientation, gravity)


@checks_arguments
def schatz(
    length: float, angle: float, *, offset: float = 0.0, links: Links = None, position: ArrayLike = (0, 0, 0),
    orientation: ArrayLike = (1, 0, 0, 0), gravity: ArrayLike = (0, 0, -9.81),
) -> System:  # fmt: skip
    """Build Schatz's linkage, that of the Turbula mixer: two parallel shafts in the ground carry three links of a.

    Links of 0, a, a, a, 0 and sqrt(3) a in the ground; twists of 90 degrees, 0 in the ground; offsets d_1 = -d_6.
    ``2 cos(theta_2) = -sqrt(3) cos(theta_1)``, ``tan(theta_3 / 2) = -sqrt(3) sin(theta_1)``,
    ``2 tan(theta_1) tan(theta_6) = -1``.

    Parameters
    ----------
    length : float
        a [m].
    angle : float
        theta_1 of the first shaft [rad].
    offset : float
        d_1 [m], along the shafts; it changes no angle.
    links, position, orientation, gravity
        As in `hinge_loop`.

    Raises
    ------
    ValueError
        If the length is not positive or the angle not finite.
    """
    length = number(length, "schatz: length", positive=True)
    angle, offset = number(angle, "schatz: angle"), number(offset, "schatz: offset")
    numbers = length * np.array([0.0, 1.0, 1.0, 1.0, 0.0, np.sqrt(3.0)])
    numbers = np.c_[numbers, RIGHT_ANGLE * np.array([1, 1, 1, 1, 1, 0]), [offset, 0, 0, 0, 0, -offset]]
    third = -2.0 * np.arctan(np.sqrt(3.0) * np.sin(angle))
    known = np.array([angle, np.arccos(-0.5 * np.sqrt(3.0) * np.cos(angle)), third])
    angles = closed_angles("schatz", numbers, lambda x: np.r_[known, x], 3, None)
    return built("schatz", numbers, angles, links, position, orientation, gravity)


def _six(what: str, numbers: np.ndarray) -> None:
    """Raise ValueError unless there are six links."""
    if len(numbers) != 6:
        raise InputError(f"{what}: {len(numbers) // 2} links given; give the numbers of three")
