"""Closed loops of hinges from Denavit-Hartenberg numbers."""

from collections.abc import Callable
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from ..api.system import System
from ..base.checks import sequence
from ..base.errors import InputError, checks_arguments
from ..mechanism.bodies import GROUND, Body, Ground
from ..mechanism.joints.pairs import Revolute
from .links import Links, base_frame, link_body

CLOSURE_TOLERANCE = 1e-9  # [1] misfit of a loop over its size that rounding of typed parameters may leave
START_COUNTS = {2: 8, 3: 5}  # [1] of each free angle in the search for a closed pose, by their number
NEWTON_ITERATIONS_MAX = 30  # [1] of Newton; it doubles its digits in each where it converges at all


@checks_arguments
def hinge_loop(
    lengths: ArrayLike, twists: ArrayLike, offsets: ArrayLike, angles: ArrayLike, *,
    links: Links = None, position: ArrayLike = (0, 0, 0), orientation: ArrayLike = (1, 0, 0, 0),
    gravity: ArrayLike = (0, 0, -9.81),
) -> System:  # fmt: skip
    """Build a loop of n hinges from its Denavit-Hartenberg numbers; the last link is the ground.

    ``Rz(theta_1) Tz(d_1) Tx(a_1) Rx(alpha_1) ... Rz(theta_n) Tz(d_n) Tx(a_n) Rx(alpha_n) = 1``: hinge k turns about z
    of frame k - 1, and link k carries frame k, whose z is the axis of the next hinge. Bodies are "link 1" ...
    "link n - 1", joints "hinge 1" ... "hinge n". The reference point of a link is the origin of its frame, on the axis
    of its far hinge.

    Parameters
    ----------
    lengths, twists, offsets, angles : (n,) sequence
        a [m], alpha [rad], d [m] and theta [rad] of each link, n >= 3.
    links : (n - 1,) sequence of MassProperties, optional
        Mass, centre of mass and inertia of the moving links, in their frames; see `mbsd3d.inertia.combine`. None =
        round bars of 1 kg between the hinges, a twentieth of the longest link thick.
    position, orientation : (3,) and (4,) or (3, 3) array_like
        Frame 0 in the world [m]: its z is the axis of the first hinge, its x the one its angle is counted from.
    gravity : (3,) array_like
        [m/s^2], world.

    Returns
    -------
    System
        At rest or to be set moving by ``system.assemble(rates={"hinge 1": rate})``.

    Raises
    ------
    ValueError
        If the loop does not close, naming the misfit; for numbers of the wrong form.
    """
    numbers = table(lengths, twists, offsets, "hinge_loop")
    theta = np.array(sequence(angles, "hinge_loop: angles"))
    if theta.size != len(numbers):
        raise InputError(f"hinge_loop: {theta.size} angles for {len(numbers)} links; give one angle a hinge")
    return built("hinge_loop", numbers, theta, links, position, orientation, gravity)


def table(lengths: ArrayLike, twists: ArrayLike, offsets: ArrayLike, what: str) -> np.ndarray:
    """Return a, alpha, d as a table, shape (n, 3)."""
    columns = [
        sequence(x, f"{what}: {name}") for x, name in ((lengths, "lengths"), (twists, "twists"), (offsets, "offsets"))
    ]
    if len({len(x) for x in columns}) != 1 or len(columns[0]) < 3:
        sizes = ", ".join(str(len(x)) for x in columns)
        raise InputError(
            f"{what}: {sizes} lengths, twists and offsets; give one of each a link, for three links or more"
        )
    if not any(columns[0] + columns[2]):
        raise InputError(f"{what}: all lengths and offsets are 0; give links of some size")
    return np.array(columns).T


def built(
    what: str, numbers: np.ndarray, angles: np.ndarray, links: Links, position: ArrayLike, orientation: ArrayLike,
    gravity: ArrayLike,
) -> System:  # fmt: skip
    """Build the system of a loop that closes; raise ValueError with the misfit for others."""
    place = frames(numbers, angles)
    gap, turn, size = misfit(numbers, angles)
    if not max(gap / size, turn) < CLOSURE_TOLERANCE:
        raise InputError(f"{what}: the loop does not close at these parameters: its ends are {gap:.3g} m and "
                         f"{turn:.3g} rad apart; correct the parameters or the angles")  # fmt: skip
    base, thick = base_frame(position, orientation, what), 0.05 * size
    bodies = [
        link_body(what, k, base @ place[k], place[k - 1][:3, 3] - place[k][:3, 3], place[k][:3, :3], thick, links,
                  len(numbers) - 1)
        for k in range(1, len(numbers))
    ]  # fmt: skip
    parts: list[Body | Ground] = [GROUND, *bodies, GROUND]
    hinges = [
        Revolute(parts[k], parts[k + 1], at=at[:3, 3], axis=at[:3, 2], name=f"hinge {k + 1}")
        for k, at in enumerate(base @ T for T in place[:-1])
    ]
    return System(bodies, hinges, gravity=gravity)


def step(angle: float, length: float, twist: float, offset: float) -> np.ndarray:
    """Return ``Rz(theta) Tz(d) Tx(a) Rx(alpha)``, shape (4, 4)."""
    c, s, ca, sa = np.cos(angle), np.sin(angle), np.cos(twist), np.sin(twist)
    return np.array([
        [c, -s * ca, s * sa, length * c], [s, c * ca, -c * sa, length * s], [0.0, sa, ca, offset], [0.0, 0.0, 0.0, 1.0],
    ])  # fmt: skip


def frames(numbers: np.ndarray, angles: ArrayLike) -> list[np.ndarray]:
    """Return the frames 0 ... n (4, 4) in frame 0; the last is frame 0 where the loop closes."""
    place = [np.eye(4)]
    for (length, twist, offset), angle in zip(numbers, np.asarray(angles), strict=True):
        place.append(place[-1] @ step(angle, length, twist, offset))
    return place


def misfit(numbers: np.ndarray, angles: ArrayLike) -> tuple[float, float, float]:
    """Return (distance [m], angle [rad] between the ends of the loop, size [m] of the loop)."""
    end, size = frames(numbers, angles)[-1], max(np.abs(numbers[:, [0, 2]]).max(), 1e-300)
    turn = np.linalg.norm(end[:3, :3] - np.eye(3)) / np.sqrt(2.0)
    return float(np.linalg.norm(end[:3, 3])), float(turn), float(size)


def closed_angles(
    what: str, numbers: np.ndarray, spread: Callable[[np.ndarray], np.ndarray], free: int, near: ArrayLike | None
) -> np.ndarray:  # fmt: skip
    """Return all angles of a closed pose by Newton on the free ones, ``angles = spread(free)``, spread affine.

    From `near`, or from the first start of a lattice that ends in a pose with one degree of freedom. ValueError if
    there is none.
    """
    if near is not None:
        starts = [np.array(sequence(near, f"{what}: near"))]
        if starts[0].size != free:
            raise InputError(f"{what}: near has {starts[0].size} angles; give {free}")
    else:
        ticks = -np.pi + (np.arange(START_COUNTS[free]) + 0.6) * (
            2 * np.pi / START_COUNTS[free]
        )  # no tick at a multiple of a right angle
        starts = [np.array(x) for x in product(ticks, repeat=free)]
    zero = spread(np.zeros(free))
    slope = np.column_stack([spread(e) - zero for e in np.eye(free)])
    for x in starts:
        for _ in range(NEWTON_ITERATIONS_MAX):
            error, J = residual(numbers, zero + slope @ x)
            change = np.linalg.lstsq(J @ slope, -error, rcond=1e-12)[0]
            x = x + change * min(1.0, 1.0 / max(np.abs(change).max(), 1e-300))
            if np.abs(change).max() < 1e-14:
                break
        angles = np.remainder(zero + slope @ x + np.pi, 2 * np.pi) - np.pi
        gap, turn, size = misfit(numbers, angles)
        if max(gap / size, turn) < 1e-12 and one_freedom(numbers, angles):
            return angles
    raise InputError(f"{what}: no closed pose was found at angle {np.degrees(zero[0]):.6g} degrees from {len(starts)} "
                     "starts; choose another angle, other parameters, or give near=")  # fmt: skip


def screws(numbers: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Return axes and moments of the hinges about the origin of frame 0, lengths over the size of the loop, shape (6,
    n).
    """
    size = np.abs(numbers[:, [0, 2]]).max()
    return np.column_stack([np.r_[T[:3, 2], np.cross(T[:3, 3] / size, T[:3, 2])] for T in frames(numbers, angles)[:-1]])


def residual(numbers: np.ndarray, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return rotation and distance of the ends as a twist (6,), exact to first order, and its derivative (6, n)."""
    end, size = frames(numbers, angles)[-1], np.abs(numbers[:, [0, 2]]).max()
    R = end[:3, :3]
    turn = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    return np.r_[turn, end[:3, 3] / size], screws(numbers, angles)


def one_freedom(numbers: np.ndarray, angles: np.ndarray) -> bool:
    """Return whether the loop has exactly one degree of freedom: the screws of its hinges have rank n - 1."""
    values = np.linalg.svd(screws(numbers, angles))[1]
    rank = len(numbers) - 1
    return bool(values[rank - 1] > 1e-3 * values[0] and (rank == 6 or values[rank] < 1e-9 * values[0]))
