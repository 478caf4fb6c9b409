"""Bennett's loop of four hinges and loops of five made of two of them: Goldberg, Myard."""

import numpy as np
from numpy.typing import ArrayLike

from ..api.system import System
from ..base.checks import number
from ..base.errors import InputError, checks_arguments
from .dh import built
from .links import Links

PROPORTION_TOLERANCE = 1e-9  # [1] relative misfit of Bennett's condition that rounding of typed parameters may leave


@checks_arguments
def bennett(
    a: float, alpha: float, b: float, beta: float, angle: float, *, links: Links = None,
    position: ArrayLike = (0, 0, 0), orientation: ArrayLike = (1, 0, 0, 0), gravity: ArrayLike = (0, 0, -9.81),
) -> System:  # fmt: skip
    """Build Bennett's linkage: four hinges, opposite links equal, ``a / sin(alpha) = b / sin(beta)``, no offsets.

    Its angles obey ``theta_3 = -theta_1``, ``theta_4 = -theta_2`` and ``tan(theta_1 / 2) tan(theta_2 / 2) =
    sin((beta + alpha) / 2) / sin((beta - alpha) / 2)``. Links are a, b, a, b; the last one is the ground. Kutzbach's
    count gives -2 degrees of freedom; it has one.

    Parameters
    ----------
    a, b : float
        Distances of neighbouring axes [m].
    alpha, beta : float
        Their twists [rad].
    angle : float
        theta_1 [rad], between the ground link's and the first link's common normals, not a multiple of pi.
    links, position, orientation, gravity
        As in `hinge_loop`.

    Raises
    ------
    ValueError
        If Bennett's condition does not hold, with the length that would close; at a pose where all axes meet one line.
    """
    proportion("bennett", "a, alpha", a, alpha, "b, beta", b, beta)
    first, second = pair("bennett", alpha, beta, angle)
    angles = np.array([first, second, -first, -second])
    numbers = np.array([[a, alpha, 0.0], [b, beta, 0.0], [a, alpha, 0.0], [b, beta, 0.0]])
    return built("bennett", numbers, angles, links, position, orientation, gravity)


@checks_arguments
def goldberg(
    a: float, alpha: float, b: float, beta: float, c: float, gamma: float, angle: float, *, links: Links = None,
    position: ArrayLike = (0, 0, 0), orientation: ArrayLike = (1, 0, 0, 0), gravity: ArrayLike = (0, 0, -9.81),
) -> System:  # fmt: skip
    """Build Goldberg's linkage of five hinges: two Bennett loops (a, b) and (c, b) without their common link b.

    ``a / sin(alpha) = b / sin(beta) = c / sin(gamma)``; links of a + c, b, c, a, b with twists alpha + gamma, beta,
    gamma, alpha, beta; the last one is the ground.

    Parameters
    ----------
    a, b, c : float
        Lengths of the links of the two Bennett loops [m].
    alpha, beta, gamma : float
        Their twists [rad].
    angle : float
        theta_1 [rad], not a multiple of pi.
    links, position, orientation, gravity
        As in `hinge_loop`.

    Raises
    ------
    ValueError
        If Bennett's condition does not hold for both loops, with the length that would close.
    """
    proportion("goldberg", "a, alpha", a, alpha, "b, beta", b, beta)
    proportion("goldberg", "c, gamma", c, gamma, "b, beta", b, beta)
    numbers = [[a + c, alpha + gamma], [b, beta], [c, gamma], [a, alpha], [b, beta]]
    angles = two_loops("goldberg", alpha, beta, gamma, angle)
    return built("goldberg", np.c_[numbers, np.zeros(5)], angles, links, position, orientation, gravity)


@checks_arguments
def myard(
    a: float, alpha: float, b: float, angle: float, *, links: Links = None, position: ArrayLike = (0, 0, 0),
    orientation: ArrayLike = (1, 0, 0, 0), gravity: ArrayLike = (0, 0, -9.81),
) -> System:  # fmt: skip
    """Build Myard's linkage of five hinges, symmetric to a plane: two mirrored Bennett loops with a twist of 90
    degrees.

    ``a / sin(alpha) = b``; links of 0, b, a, a, b with twists 2 alpha - pi, pi / 2, pi - alpha, alpha, pi / 2; the
    last one is the ground. The first link has crossing axes.

    Parameters
    ----------
    a, b : float
        Lengths [m].
    alpha : float
        Twist of the links a [rad].
    angle : float
        theta_1 [rad], between the ground link and the link with crossing axes; not a multiple of pi.
    links, position, orientation, gravity
        As in `hinge_loop`.

    Raises
    ------
    ValueError
        If ``a / sin(alpha) = b`` does not hold, with the length that would close.
    """
    proportion("myard", "a, alpha", a, alpha, "b, pi / 2", b, np.pi / 2)
    numbers = [[0.0, 2 * alpha - np.pi], [b, np.pi / 2], [a, np.pi - alpha], [a, alpha], [b, np.pi / 2]]
    angles = two_loops("myard", alpha, np.pi / 2, alpha - np.pi, angle) + [0.0, 0.0, np.pi, np.pi, 0.0]
    return built("myard", np.c_[numbers, np.zeros(5)], angles, links, position, orientation, gravity)


def proportion(what: str, one: str, a: float, alpha: float, other: str, b: float, beta: float) -> None:
    """Raise ValueError where ``a sin(beta) = b sin(alpha)`` does not hold."""
    for name, value in ((one, a), (one, alpha), (other, b), (other, beta)):
        number(value, f"{what}: one of {name}")
    left, right = a * np.sin(beta), b * np.sin(alpha)
    if min(abs(np.sin(alpha)), abs(np.sin(beta))) < PROPORTION_TOLERANCE or not a or not b:
        raise InputError(f"{what}: ({one}) = ({a:g}, {alpha:g}), ({other}) = ({b:g}, {beta:g}): give "
                         "lengths other than 0 and twists that are not multiples of pi")  # fmt: skip
    if not abs(left - right) <= PROPORTION_TOLERANCE * max(abs(left), abs(right)):
        raise InputError(f"{what}: Bennett's condition a / sin(alpha) = b / sin(beta) does not hold for ({one}) "
                         f"and ({other}): {a / np.sin(alpha):.9g} m and {b / np.sin(beta):.9g} m; with these twists, "
                         f"{a:.9g} m goes with {a * np.sin(beta) / np.sin(alpha):.12g} m")  # fmt: skip


def pair(what: str, alpha: float, beta: float, angle: float) -> tuple[float, float]:
    """Return (theta_1, theta_2) of a Bennett loop whose first link has the twist alpha [rad]."""
    angle = number(angle, f"{what}: angle")
    if abs(np.sin(angle)) < PROPORTION_TOLERANCE or abs(np.sin(0.5 * (beta - alpha))) < PROPORTION_TOLERANCE:
        raise InputError(f"{what}: angle {angle:g} at twists {alpha:g} and {beta:g} rad folds the loop onto a line "
                         "or gives equal links; choose an angle no multiple of pi and unequal twists")  # fmt: skip
    ratio = np.sin(0.5 * (beta + alpha)) / np.sin(0.5 * (beta - alpha))
    return float(angle), float(2.0 * np.arctan(ratio / np.tan(0.5 * angle)))


def two_loops(what: str, alpha: float, beta: float, gamma: float, angle: float) -> np.ndarray:
    """Return the angles of two Bennett loops with the common link b, their links a and c made one at the common hinge
    [rad], shape (5,).

    There the second loop's angle is that of the first plus pi, as both links lie on one line, on either side.
    """
    first, second = pair(what, alpha, beta, angle)
    third = pair(what, gamma, beta, second + np.pi)[1]
    return np.array([first, -third, second + np.pi, third - first + np.pi, -second])
