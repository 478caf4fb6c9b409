"""`pin_stress`: the stresses of the pin of a joint over a run, sampled at their extrema."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import check_choice, short_repr
from ..base.errors import InputError, checks_arguments
from ..mechanism.joints import Joint
from ..results.bearings import loads_across
from ..results.pins import Pin, PinStress, stress_of
from ..run.repeat import has_changed_inputs
from .solution import Solution

PARTS_PER_STEP = 4  # [parts] of a step of the run: a step of order 8 may hold a turn back and forth
VARIATION_TOLERANCE = 1e-5  # [1] of the way that fibres and load go up and down: what another run may still add to it
RUNS_MAX = 8  # [runs]
TURNING_SAMPLES_MAX = 1_000_000  # [samples]
SAME_TIME = 1e-10  # [1] of the run: times nearer to each other are one
GAIN_MIN = 1e-7  # [1] of the greatest value: a turning point that lies beyond a sample by less is that sample


@checks_arguments
def pin_stress(
    solution: Solution,
    joint: Joint | str,
    *,
    diameter: float,
    cheek: float,
    link: float,
    gap: float = 0.0,
    shear: str = "double",
    lever: float | None = None,
    axis: ArrayLike | None = None,
    holder: str = "a",
) -> PinStress:
    """Return the stresses of the pin of a joint: shear, bending, and the bending of each fibre around it.

    The reaction across the axis is taken in the axes of the part that holds the pin, so that a load that rotates
    relative to the pin loads its fibres in turn. The run is repeated with samples at the extrema of the fibre stresses.

    Parameters
    ----------
    solution : Solution
    joint : Revolute, Cylindrical, Spherical, Universal, ...
    diameter, cheek, link, gap : float
        Of the pin d; widths a of each cheek and b of the link; distance g between them [m].
    shear : "double" or "single"
        In a fork, ``M = F/2 (a/2 + g + b/4)``; or on one cheek that holds it like a cantilever, with a pressure that
        changes linearly over its width: ``M = F (e + x/2 - x^2 / (6 a))``, ``e = g + b/2``, ``x = a^2 / (3 a + 6 e)``.
    lever : float or None
        M / F [m] of another support; None = as ``shear`` says.
    axis : (3,) array_like or None
        Of the pin, world at the reference pose; None = the joint's own.
    holder : "a" or "b"
        The body of the joint in which the pin does not turn.

    Returns
    -------
    PinStress
        ``.bending``, ``.shear``, ``.bound``, ``.pressures``, ``.fibres``, ``.life(curve)``.

    Raises
    ------
    ValueError
        If redundant constraints leave the reaction across the axis undetermined, a joint does not rotate or has no
        axis, or a length is not positive.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Revolute, System, accelerations, pin_stress
    >>> jib = Body("jib", mass=815.494, inertia=(9.0, 9.0, 9.0))
    >>> pin = Revolute(GROUND, jib, at=(0, 0, 0), axis=(0, 1, 0), name="pin")
    >>> pin_stress(accelerations(System([jib], [pin])), pin, diameter=0.012, cheek=0.008, link=0.02, gap=0.001)
    <pin 'pin': 8000 N at most; bending 235.8 MPa, shear 35.37 MPa, bound 243.6 MPa; tilting moment 0 N m, not in it>
    """
    if not isinstance(solution, Solution):
        raise InputError(f"pin_stress: {short_repr(solution)} is not a solution; give one of simulate(...)")
    check_choice(holder, ("a", "b"), "pin_stress: holder")
    pin = Pin(diameter=diameter, cheek=cheek, link=link, gap=gap, shear=shear, lever=lever)

    def read(run: Solution) -> PinStress:
        return stress_of(pin, loads_across(run, joint, axis, holder, "pin_stress"), holder, run.record.rtol)

    def turning(run: Solution) -> np.ndarray:
        stress = read(run)
        return np.column_stack([stress.fibres, stress.bending])  # the load peaks between the peaks of two fibres

    stress = read(solution)
    return stress if solution.t.size < 2 else read(at_turning_points(solution, turning))


def at_turning_points(solution: Solution, read: Callable[[Solution], np.ndarray]) -> Solution:
    """Return a run with samples at the extrema of all columns (samples, k) of what is read from it.

    Every sample is one of the run itself; between two of them a parabola only says when to look. What is found does not
    overshoot, so that the way of all columns up and down can only grow, until it is known.
    """
    steps = solution if has_changed_inputs(solution) else solution.again(output=None)
    within = (steps.t >= solution.t[0]) & (steps.t <= solution.t[-1])  # a run may be sampled in part
    times = apart(np.union1d(solution.t, subdivided(steps.t[within])))
    way = 0.0
    for _ in range(RUNS_MAX):
        if times.size > TURNING_SAMPLES_MAX:
            raise InputError(
                f"pin_stress: {times.size} turning points are too many; give a shorter run, of one cycle of the load"
            )
        run = solution.again(output=times)
        values = read(run)
        before, way = way, float(np.abs(np.diff(values, axis=0)).sum())
        if way - before <= VARIATION_TOLERANCE * way:
            return run
        times = apart(np.union1d(run.t, new_times(run.t, values)))
        if times.size == run.t.size:
            return run
    return run


def subdivided(t: np.ndarray) -> np.ndarray:
    """Return times (k,) and those that divide each interval between them into equal parts."""
    if t.size < 2:
        return t
    inside = t[:-1, None] + np.diff(t)[:, None] * np.arange(PARTS_PER_STEP) / PARTS_PER_STEP
    return np.append(inside.ravel(), t[-1])


def apart(t: np.ndarray) -> np.ndarray:
    """Return times (k,) without those that follow another one at once; the last one stays."""
    kept = np.append(np.diff(t) > SAME_TIME * (t[-1] - t[0]), True)
    kept[0] = True
    return t[kept]


def new_times(t: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the times at which parabolas through neighbouring samples of columns turn, where no sample is yet."""
    low, high = np.diff(values, axis=0)[:-1], np.diff(values, axis=0)[1:]
    least = GAIN_MIN * np.abs(values).max(initial=0.0)
    row, column = np.nonzero((low * high < 0.0) & (np.maximum(np.abs(low), np.abs(high)) > least))
    before, after = t[row + 1] - t[row], t[row + 2] - t[row + 1]
    rise, fall = low[row, column] / before, high[row, column] / after  # slopes in the middle of both intervals
    bend = (fall - rise) / (0.5 * (before + after))
    slope = rise + 0.5 * before * bend  # at the sample between them
    ahead = np.abs(0.5 * slope * slope / bend) > least
    return np.unique((t[row + 1] - slope / bend)[ahead])
