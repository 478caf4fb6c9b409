"""Our own motion at given times, how wrong it may be, and how fast neighbouring motions part."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mbsd3d import State, accelerations, simulate
from validation.crosscheck.ladder import running_max
from validation.crosscheck.quantities import POSES, Quantity, Sizes, quantities, sizes
from validation.twins.base import Array, Load, Motion
from validation.twins.definitions.equations import constraint_rows

LOOSE, TIGHT = 1e-10, 1e-12
"""rtol of the run that is compared, TIGHT, and of the one that tells its error: 100 times looser."""
NUDGE = 1e-6
"""Of the neighbouring start, relative: far above the error of the runs, far below what bends the growth."""
RANK = 1e-9
"""Singular values of J below this part of the greatest are zero, as in `validation.twins.definitions.equations`."""


@dataclass(frozen=True)
class Ours:
    """What is compared with an engine.

    ``found``: quantity -> values; momentum and kinetic energy are those of `mbsd3d.Solution`, so that they are tested
    too; ``error``: quantity -> (n,) how wrong it may be up to each sample, relative; ``growth`` (n,): by how much
    neighbouring motions have parted up to each sample, relative to their start; ``open``: joints whose reaction the
    constraints do not determine.
    """

    motion: Motion
    size: Sizes
    found: dict[str, Quantity]
    error: dict[str, Array]
    growth: Array
    open: tuple[str, ...]


def motion_of(solution: Any) -> tuple[Motion, tuple[str, ...]]:
    """(poses, velocities and unique reactions of a solution, names of joints whose reaction is not unique)."""
    system = solution.system
    stack = {
        name: np.stack([getattr(solution, name)(body) for body in system.bodies], axis=1)
        for name in ("position", "orientation", "velocity", "omega")
    }
    found = {system.name(joint): solution.reaction(joint) for joint in system.joints}
    loads = {name: Load(x.force, x.moment) for name, x in found.items() if x.unique}
    rest = tuple(name for name, x in found.items() if not x.unique)
    return Motion(t=solution.t, reactions=loads, seconds=solution.record.seconds, **stack), rest


def whole_run(system: Any, t_end: float, state: State, rtol: float, output: Any) -> Any:
    """A solution up to t_end; KeyboardInterrupt if Ctrl-C ended it before."""
    solution = simulate(system, t_end, state=state, rtol=rtol, output=output)
    if (solution.record.stopped_by or "").startswith("interrupted"):
        raise KeyboardInterrupt
    return solution


def neighbour(system: Any, state: State, size: Sizes) -> State:
    """The start with general velocities added, NUDGE of the run's speeds, that all joints allow."""
    J = constraint_rows(system, state)[0] if system.joints else np.zeros((0, state.v.size))
    units = np.tile([size.speed] * 3 + [size.spin] * 3, len(system.bodies))
    _, s, Vt = np.linalg.svd(J * units)
    free = Vt[int((s > RANK * s.max(initial=0.0)).sum()) :]
    shift = free.T @ (free @ np.random.default_rng(1).normal(size=units.size))
    length = np.abs(shift).max(initial=0.0)
    return replace(state, v=state.v + NUDGE * units * shift / length) if length > RANK else state


def ours_at(system: Any, state: State, times: Array) -> Ours:
    """Our motion at the times, by a tight run; its error by a looser one, its sensitivity by a neighbouring one."""
    t_end = float(times[-1])
    tight, loose = (whole_run(system, t_end, state, rtol, times) for rtol in (TIGHT, LOOSE))
    motion, rest = motion_of(tight)
    size = sizes(system, motion, float(tight.compiled.model.length))
    joints = tuple(motion.reactions)
    found = dict(quantities(system, motion, size, joints))
    p, energy = tight.momentum(), tight.energy()
    for name, values in (("momentum", p.linear), ("angular momentum", p.angular), ("kinetic energy", energy.kinetic)):
        found[name] = found[name]._replace(values=values.reshape(found[name].values.shape))
    less = motion_of(loose)[0]
    less = quantities(system, less, size, tuple(name for name in joints if name in less.reactions))
    error = {name: parted(x, less[name]) for name, x in found.items() if name in less}
    start = neighbour(system, state, size)
    beside = whole_run(system, t_end, start, LOOSE, times)
    beside = quantities(system, motion_of(beside)[0], size)
    away = np.max([parted(found[name], beside[name]) for name in POSES], axis=0)
    growth = np.maximum(away / NUDGE, 1.0) if start is not state else np.ones(times.size)
    return Ours(motion, size, found, error, growth, rest)


def ours_at_start(system: Any, state: State) -> Ours:
    """The same at the start alone: sizes and unique reactions, nothing to estimate."""
    solution = accelerations(system, state)
    motion, rest = motion_of(solution)
    size = sizes(system, motion, float(solution.compiled.model.length))
    return Ours(motion, size, {}, {}, np.ones(1), rest)


def parted(one: Quantity, other: Quantity) -> Array:
    """(n,) greatest relative difference up to each sample."""
    if one.values.shape != other.values.shape:
        return np.full(len(one.values), np.inf)
    return running_max((one.values - other.values) / one.scale)
