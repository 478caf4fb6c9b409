"""Limits of locks, friction and ropes: loads held, loop gain of friction, belts, planes of pulleys."""

from typing import NamedTuple

import numpy as np

from ...constraints.rank import tree_over_rows
from ...dynamics.batch import loads_of_sample
from ...dynamics.joint_friction import friction_feedback
from ...equations.compiled import Compiled
from ...kernels.layout import Data, Tree
from ...mechanism.forces.belt import Belt
from ...mechanism.forces.dry_friction import DryFriction
from ...mechanism.forces.rope import OverPulleys
from ...mechanism.lock import Lock
from ...mechanism.measures import UNIT_EXPONENTS
from ...solver.saddle_point import factor
from ..element_loads import tensions_and_wraps
from ..result import RunResult
from .check import Check, scales_of

OF_GAIN = "friction: greatest gain on itself"
GAIN_SAMPLES = 200  # [samples] of a run at which the gain is looked at
GAIN_WARNED = 0.5  # [1] from which the loads depend on mu out of proportion: w grows like 1 / (1 - gain)
HELD = "held loads"
HELD_LOAD_MAX = 0.01  # [1] of the load: far more than events are missed by, far less than what a missed one leaves
HELD_LOAD_SHARE = 1e-6  # [1] of the greatest multiplier: a load below it is rounding
PASSED = "limits of locks"
PASSED_MAX = 1e-6  # [1] of the size of a value: a hundred times what an event is seen late by
FLEET_ANGLE_MAX = 0.1  # [rad] of a span out of the plane of its pulley: loads err by half its square, 0.5 %


class Gain(NamedTuple):
    """Spectral radius of dg/dw, w = g(reaction under w), and the friction that takes most part in its mode."""

    value: float
    friction: DryFriction


def gain_at(compiled: Compiled, data: Data, tree: Tree) -> Gain:
    """Return the gain with the rows, loads, multipliers and factor at hand."""
    numbers = np.flatnonzero(compiled.model.force["rows"])
    k = numbers.size
    D, presses, columns, none, missed = (np.zeros(x) for x in ((k, k), (k, 2, 3), (k, k, 2, 3), k, k))
    friction_feedback(compiled.model, data, tree, numbers, presses, columns, none, missed, D)
    if not np.isfinite(D).all():
        return Gain(np.nan, compiled.system.forces[numbers[0]])
    values, right = np.linalg.eig(D)
    left = np.linalg.eig(D.T)
    most = int(np.argmax(np.abs(values)))
    same = int(np.argmin(np.abs(left[0] - values[most])))
    share = np.abs(right[:, most] * left[1][:, same])  # whatever the units of the loads
    return Gain(float(np.abs(values[most])), compiled.system.forces[numbers[int(np.argmax(share))]])


def friction_notes(solution: RunResult) -> list[str]:
    """Return notes on the greatest loop gain of friction in a run, and on loads at rest that are not unique."""
    pieces = solution.pieces or (solution,)
    found = [x for piece in pieces for x in gains(piece)]
    if not found:
        return []
    modes = [item for piece in pieces for item in piece.compiled.modes.items()]
    shared = dict.fromkeys(name for name, mode in modes if mode.name == "resting")
    names = ", ".join(f"'{name}'" for name in shared)
    apart = [f"friction at rest beside what holds it, whose share of the load is not unique: {names}"] if shared else []
    (gain, friction), at = max(found, key=lambda each: each[0].value)
    text = f"{OF_GAIN} {gain:.2g} at t = {at:.4g} s ('{solution.system.name(friction.joint)}')"
    if gain >= GAIN_WARNED:
        text += f"; it jams from 1 on, and loads err by {1.0 / (1.0 - gain):.2g} times what mu errs by"
    return [text, *apart]


def held_checks(solution: RunResult) -> list[Check]:
    """Return the check that rows of locks bear no more than they can at any sample of a run without events.

    More means that the event at which they let go was missed. Where one does, its last sample may be behind a jump of
    the load, at a time that is right to rounding.
    """
    system, compiled, t = solution.system, solution.compiled, solution.t
    modes, lam = compiled.modes, solution.arrays["lam"]
    held = [x for x in system.forces if isinstance(x, Lock) and system.name(x) in modes]
    held = [x for x in held if x.holds(modes[system.name(x)]) and compiled.rows[id(x)]]
    if not held or not t.size:
        return []
    capacity = capacities_at_samples(solution, held)
    least, worst = HELD_LOAD_SHARE * np.abs(lam).max(initial=0.0), (0.0, held[0], 0)
    for k, part in enumerate(held):
        load = -lam[:, compiled.rows[id(part)].start]
        mode = modes[system.name(part)]
        if system.name(part) in solution.derived.get("switch at the end", ()) and load.size > 1:
            load = load[:-1]
        most = capacity[: load.size, k]
        beyond = np.array([part.excess(x, mode, y) for x, y in zip(load, most, strict=True)])
        size = max(float(np.abs(load).max()), float(np.abs(load - beyond).max()), least) or 1.0
        worst = max(worst, (float(beyond.max()) / size, part, int(beyond.argmax())), key=lambda each: each[0])
    error, part, k = worst
    meaning = f"the row of '{system.name(part)}' bears more than it holds at t = {t[k]:.4g} s; shorten the step"
    return [Check(HELD, error, HELD_LOAD_MAX, meaning)]


def limit_checks(solution: RunResult) -> list[Check]:
    """Return the check that no lock of a run without events is where it would have switched, at any sample.

    There the run has missed an impact on a stop, a tooth or freewheel that catches, or the end of a slip. A single
    sample is the state before an impact at the start.
    """
    system, modes, size = solution.system, solution.compiled.modes, scales_of(solution)
    parts = [x for x in system.forces if isinstance(x, Lock) and system.name(x) in modes]
    bounds = [(part, bound) for part in parts for bound in part.bounds(modes[system.name(part)])]
    if not bounds or solution.t.size < 2:
        return []
    values = solution.measure([bound.measure for _, bound in bounds])
    worst = (0.0, parts[0], 0)
    for (part, bound), x in zip(bounds, values.T, strict=True):
        of_length, of_speed = UNIT_EXPONENTS[bound.measure.unit]
        expected = solution.compiled.model.length**of_length * size.speed**of_speed
        beyond = bound.direction * (x - bound.value) / max(abs(bound.value), expected)
        worst = max(worst, (float(beyond.max()), part, int(beyond.argmax())), key=lambda each: each[0])
    error, part, k = worst
    where = f"beyond its limit at t = {solution.t[k]:.4g} s: an event was missed"
    meaning = f"'{system.name(part)}' is {where}; shorten the step"
    return [Check(PASSED, error, PASSED_MAX, meaning)]


def capacities_at_samples(solution: RunResult, parts: list[Lock]) -> np.ndarray:
    """Return the capacity of friction of parts (samples, parts) [N or N m], from the multipliers at the samples."""
    compiled, arrays = solution.compiled, solution.arrays
    numbers = [solution.system.forces.index(part) for part in parts]
    found = np.zeros((solution.t.size, len(parts)))
    if compiled.model.frictions:
        data = compiled.data()
        for k, t in enumerate(solution.t):
            loads_of_sample(compiled.model, data, t, arrays["state"][k], arrays["coordinate"][k], arrays["lam"][k])
            found[k] = data.force["load"][numbers]
    return found


def gains(solution: RunResult) -> list[tuple[Gain, float]]:
    """Return the gain at samples of a run without events, with their times [s]."""
    compiled, arrays, t = solution.compiled, solution.arrays, solution.t
    if not compiled.model.frictions or not t.size:
        return []
    data, tree, found = compiled.data(), None, []
    samples = np.unique(np.linspace(0, t.size - 1, min(t.size, GAIN_SAMPLES)).astype(int))
    for k in samples.tolist():
        known = arrays["state"][k], arrays["coordinate"][k], arrays["lam"][k]
        loads_of_sample(compiled.model, data, t[k], *known)
        if tree is None or tree.state.worn == 1:
            tree = tree_over_rows(compiled.model, data, solution.record.tolerance)
        factor(compiled.model, data, tree)
        found.append((gain_at(compiled, data, tree), float(t[k])))
    return found


def fleet_angle(solution: RunResult, rope: OverPulleys) -> float:
    """Return the largest angle [rad] of a span out of the plane of its pulley in a run."""
    largest = 0.0
    for span in rope.path.spans:
        if span.in_plane:
            x = span.ways[0]
            gap = solution.body_point(x.b, x.point_b) - solution.body_point(x.a, x.point_a)
            off = np.einsum("ti,ti->t", solution.body_axis(x.a, x.axis), gap)
            largest = max(largest, float(np.arcsin(np.abs(off) / np.linalg.norm(gap, axis=1)).max()))
    return largest


def rope_checks(solution: RunResult) -> list[Check]:
    """Return the checks of all ropes and belts of a run: those nearest to failing."""
    ropes = [x for x in solution.system.forces if isinstance(x, OverPulleys)]
    if not ropes:
        return []
    name = solution.system.name
    angle, rope = max(((fleet_angle(solution, x), x) for x in ropes), key=lambda each: each[0])
    remedy = "keep its bodies in that plane by joints, or lead it through an eye"
    found = [Check("planes of ropes", angle, FLEET_ANGLE_MAX, f"'{name(rope)}' leaves the plane of a pulley; {remedy}")]
    belts = [x for x in ropes if isinstance(x, Belt) and x.mu is not None]
    if belts:
        share, t, belt = max((slip_of(solution, x) for x in belts), key=lambda each: each[0])
        meaning = (
            f"'{name(belt)}' slips on its pulley at t = {t:.4g} s, ln(T_high/T_low) > mu phi; give more pretension"
        )
        found.append(Check("grip of belts", share, 1.0, meaning))
    return found


def slip_of(solution: RunResult, belt: Belt) -> tuple[float, float, Belt]:
    """Return (largest share of its grip that a belt uses, its time [s], the belt)."""
    tensions, wraps = tensions_and_wraps(solution, belt)
    shares = belt.slip(tensions, belt.wraps(wraps))
    worst = int(np.argmax(shares))
    return float(shares[worst]), float(solution.t[worst]), belt
