"""Quantities to compare, from the poses and velocities of a `Motion` alone, and their natural sizes; the motion of
mbsd3d.

Of our motion also how wrong it may be, and how fast neighbouring motions part.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from mbsd3d import Solution, State, System, accelerations, simulate
from mbsd3d.extend import equations
from validation.twins.base import Array, Load, Motion

BASIC_QUANTITIES = ("position", "rotation", "velocity", "angular velocity")  # quantities that the others are made of
Known = tuple[Array, Array]  # projectors (n, 3, 3) onto the determined directions of a force and of a moment


class Quantity(NamedTuple):
    """Samples (n, parts, k) of a quantity, their parts, and the size that makes a difference relative."""

    values: Array
    parts: tuple[str, ...]
    scale: float


@dataclass(frozen=True)
class Sizes:
    """Natural sizes of a run, which correspond to an error of one hundred per cent.

    ``length, speed, spin``: [m, m/s, rad/s]; ``momentum, angular_momentum, energy, force, moment``: [kg m/s, kg m^2/s,
    J, N, N m].
    """

    length: float
    speed: float
    spin: float
    momentum: float
    angular_momentum: float
    energy: float
    force: float
    moment: float


def rotation_matrices(e: Array) -> Array:
    """Return (e0^2 - e_v'e_v) 1 + 2 e_v e_v' + 2 e0 [e_v]x of unit quaternions (..., 4) of either sign, shape (..., 3,
    3).
    """
    e0, v = e[..., :1, None], e[..., 1:]
    outer = v[..., :, None] * v[..., None, :]
    skew = np.cross(np.eye(3), v[..., None, :])  # row i of [v]x is e_i x v
    square = e0**2 - (v * v).sum(axis=-1)[..., None, None]
    return square * np.eye(3) + 2.0 * outer + 2.0 * e0 * skew


def momenta(system: System, motion: Motion) -> tuple[Array, Array, Array, Array]:
    """Return (p, L about the world's origin, kinetic energy, potential energy of the weight): (n, 3), (n, 3), (n,),
    (n,).
    """
    R = rotation_matrices(motion.orientation)
    n = motion.t.size
    p, L, kinetic, weight = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros(n), np.zeros(n)
    for i, body in enumerate(system.bodies):
        w = motion.omega[:, i]
        arm = R[:, i] @ body.com
        centre, v = motion.position[:, i] + arm, motion.velocity[:, i] + np.cross(w, arm)
        spin = np.einsum("tij,jk,tlk,tl->ti", R[:, i], body.inertia, R[:, i], w)
        p += body.mass * v
        L += body.mass * np.cross(centre, v) + spin
        kinetic += 0.5 * (body.mass * (v * v).sum(axis=1) + (w * spin).sum(axis=1))
        weight -= body.mass * centre @ system.gravity
    return p, L, kinetic, weight


def sizes(system: System, motion: Motion, length: float) -> Sizes:
    """Return sizes from a motion of a model of a given length [m]; a motion at rest has sizes too, from its weight."""
    span = float(motion.t[-1] - motion.t[0]) or 1.0
    mass = sum(body.mass for body in system.bodies) or 1.0
    pull = float(np.linalg.norm(system.gravity))
    turn = largest(motion.omega)
    speed = max(largest(motion.velocity - motion.velocity.mean(axis=1, keepdims=True)), largest(motion.velocity))
    speed = max(speed, turn * length, 1e-3 * np.sqrt(pull * length), 1e-3 * length / span)
    _, L, kinetic, weight = momenta(system, motion)
    loads = motion.reactions.values()
    moment = max([largest(load.moment) for load in loads], default=0.0)
    force = max([1e-3 * moment / length, *(largest(load.force) for load in loads)]) or mass * (pull or speed / span)
    reach = length + largest(motion.position)
    return Sizes(
        length=length,
        speed=speed,
        spin=max(turn, speed / length),
        momentum=mass * speed,
        angular_momentum=max(largest(L), mass * speed * reach * 1e-3),
        energy=max(float(kinetic.max()), float(np.ptp(weight)), 1e-3 * mass * speed**2),
        force=force,
        moment=max(moment, force * length),
    )


def running_max(values: Array) -> Array:
    """Return the greatest absolute value over all parts up to each sample, of (n, parts, k), shape (n,)."""
    return np.maximum.accumulate(np.abs(values).reshape(len(values), -1).max(axis=1, initial=0.0))


def largest(values: Array) -> float:
    """Return the largest absolute value, 0 for an empty array."""
    return float(np.abs(values).max(initial=0.0))


def quantities(
    system: System, motion: Motion, size: Sizes, joints: tuple[str, ...] = (), known: Mapping[str, Known] | None = None
) -> Mapping[str, Quantity]:
    """Return all quantities of a motion by name; reactions of ``joints``, with the joint's name as the part.

    ``known``: of joints whose reaction is determined in some directions, the projectors onto these.

    Rotations are compared as matrices (9 numbers): the sign of a quaternion and its jumps do not matter.
    """
    bodies = tuple(body.name for body in system.bodies)
    n, everything = motion.t.size, ("the whole",)
    p, L, kinetic, weight = momenta(system, motion)
    R = rotation_matrices(motion.orientation).reshape(n, len(bodies), 9)
    found = {
        "position": Quantity(motion.position, bodies, size.length),
        "rotation": Quantity(R, bodies, 1.0),
        "velocity": Quantity(motion.velocity, bodies, size.speed),
        "angular velocity": Quantity(motion.omega, bodies, size.spin),
        "momentum": Quantity(p[:, None], everything, size.momentum),
        "angular momentum": Quantity(L[:, None], everything, size.angular_momentum),
        "kinetic energy": Quantity(kinetic[:, None, None], everything, size.energy),
        "energy": Quantity((kinetic + weight)[:, None, None], everything, size.energy),
    }
    if joints:
        loads = [projected(motion.reactions[name], (known or {}).get(name)) for name in joints]
        found["reaction force"] = Quantity(np.stack([x.force for x in loads], axis=1), joints, size.force)
        found["reaction moment"] = Quantity(np.stack([x.moment for x in loads], axis=1), joints, size.moment)
    return found


def projected(load: Load, known: Known | None) -> Load:
    """Return the part of a load in the directions of projectors of its force and moment; all of it for None."""
    return load if known is None else Load(*(np.einsum("tij,tj->ti", D, x) for D, x in zip(known, load, strict=True)))


def known_in_part(solution: Solution) -> dict[str, Known]:
    """Return projectors onto the directions that the constraints determine, of joints whose reaction is not unique."""
    found = {solution.system.name(joint): solution.reaction(joint) for joint in solution.system.joints}
    return {name: (x.force_projector, x.moment_projector) for name, x in found.items() if not x.unique}


LOOSE_RTOL, TIGHT_RTOL = 1e-10, 1e-12
"""rtol of the run that is compared, TIGHT, and of the one that tells its error: 100 times looser."""
# [1] of the neighbouring start; far above the error of the runs, far below nonlinear growth
NEIGHBOUR_SPEED_RATIO = 1e-6
SINGULAR_VALUE_RATIO_MIN = 1e-9
"""Singular values of J below this part of the greatest are zero."""


@dataclass(frozen=True)
class Ours:
    """Motion of mbsd3d for the comparison with an engine.

    ``found``: quantity -> values; momentum and kinetic energy are those of `mbsd3d.Solution`, so that they are tested
    too; ``error``: quantity -> (n,) how wrong it may be up to each sample, relative; ``growth`` (n,): by how much
    neighbouring motions have parted up to each sample, relative to their start; ``open``: joints whose reaction the
    constraints do not determine, or not in all directions; ``known``: projectors onto the others.
    """

    motion: Motion
    size: Sizes
    found: dict[str, Quantity]
    error: dict[str, Array]
    growth: Array
    open: tuple[str, ...]
    known: Mapping[str, Known] = field(default_factory=dict)


def motion_of(solution: Solution) -> tuple[Motion, tuple[str, ...]]:
    """Return (poses, velocities and unique reactions of a solution, names of joints with other reactions)."""
    system = solution.system
    stack = {
        name: np.stack([getattr(solution, name)(body) for body in system.bodies], axis=1)
        for name in ("position", "orientation", "velocity", "omega")
    }
    found = {system.name(joint): solution.reaction(joint) for joint in system.joints}
    certain = {name: x for name, x in found.items() if {x.shown("force")[1], x.shown("moment")[1]} != {"none"}}
    loads = {name: Load(x.determined_force, x.determined_moment) for name, x in certain.items()}
    rest = tuple(name for name, x in found.items() if not x.unique)
    return Motion(t=solution.t, reactions=loads, seconds=solution.record.seconds, **stack), rest


def whole_run(system: System, t_end: float, state: State, rtol: float, output: Any) -> Any:
    """Return a solution up to t_end; raise KeyboardInterrupt if Ctrl-C ended it before."""
    solution = simulate(system, t_end, state=state, rtol=rtol, output=output)
    if (solution.record.stopped_by or "").startswith("interrupted"):
        raise KeyboardInterrupt
    return solution


def neighbour(system: System, state: State, size: Sizes) -> State:
    """Return the start with added general velocities, `NEIGHBOUR_SPEED_RATIO` of the run's speeds, that all joints
    allow.
    """
    J = equations(system, state)[2]
    units = np.tile([size.speed] * 3 + [size.spin] * 3, len(system.bodies))
    _, s, Vt = np.linalg.svd(J * units)
    free = Vt[int((s > SINGULAR_VALUE_RATIO_MIN * s.max(initial=0.0)).sum()) :]
    shift = free.T @ (free @ np.random.default_rng(1).normal(size=units.size))
    length = np.abs(shift).max(initial=0.0)
    return (
        replace(state, v=state.v + NEIGHBOUR_SPEED_RATIO * units * shift / length)
        if length > SINGULAR_VALUE_RATIO_MIN
        else state
    )


def ours_at(system: System, state: State, times: Array) -> Ours:
    """Simulate the motion of mbsd3d at the times with a tight tolerance; its error by a looser run, its sensitivity by
    a neighbouring one.
    """
    t_end = float(times[-1])
    tight, loose = (whole_run(system, t_end, state, rtol, times) for rtol in (TIGHT_RTOL, LOOSE_RTOL))
    motion, rest = motion_of(tight)
    size = sizes(system, motion, float(tight.compiled.model.length))
    joints, known = tuple(motion.reactions), known_in_part(tight)
    found = dict(quantities(system, motion, size, joints, known))
    p, energy = tight.momentum(), tight.energy()
    for name, values in (("momentum", p.linear), ("angular momentum", p.angular), ("kinetic energy", energy.kinetic)):
        found[name] = found[name]._replace(values=values.reshape(found[name].values.shape))
    looser = motion_of(loose)[0]
    less = quantities(system, looser, size, tuple(name for name in joints if name in looser.reactions), known)
    error = {name: parted(x, less[name]) for name, x in found.items() if name in less}
    start = neighbour(system, state, size)
    neighbouring = whole_run(system, t_end, start, LOOSE_RTOL, times)
    beside = quantities(system, motion_of(neighbouring)[0], size)
    away = np.max([parted(found[name], beside[name]) for name in BASIC_QUANTITIES], axis=0)
    growth = np.maximum(away / NEIGHBOUR_SPEED_RATIO, 1.0) if start is not state else np.ones(times.size)
    return Ours(motion, size, found, error, growth, rest, known)


def ours_at_start(system: System, state: State) -> Ours:
    """Return the state of mbsd3d at the start alone: sizes and unique reactions, nothing to estimate."""
    solution = accelerations(system, state)
    motion, rest = motion_of(solution)
    size = sizes(system, motion, float(solution.compiled.model.length))
    return Ours(motion, size, {}, {}, np.ones(1), rest)


def parted(one: Quantity, other: Quantity) -> Array:
    """Return the greatest relative difference up to each sample, shape (n,)."""
    if one.values.shape != other.values.shape:
        return np.full(len(one.values), np.inf)
    return running_max((one.values - other.values) / one.scale)
