"""What is compared: quantities of a `Motion`, computed from poses and velocities alone, and their natural sizes."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from validation.twins.base import Array, Motion

POSES = ("position", "rotation", "velocity", "angular velocity")
"""Quantities that the others are made of."""


class Quantity(NamedTuple):
    """Samples (n, parts, k) of a quantity, whose they are, and by what a difference is divided to be relative."""

    values: Array
    parts: tuple[str, ...]
    scale: float


@dataclass(frozen=True)
class Sizes:
    """Natural sizes of a run: what an error of one hundred per cent would be.

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
    """(e0^2 - e_v'e_v) 1 + 2 e_v e_v' + 2 e0 [e_v]x, (..., 3, 3), of unit quaternions (..., 4) of either sign."""
    e0, v = e[..., :1, None], e[..., 1:]
    outer = v[..., :, None] * v[..., None, :]
    skew = np.cross(np.eye(3), v[..., None, :])  # row i of [v]x is e_i x v
    square = e0**2 - (v * v).sum(axis=-1)[..., None, None]
    return square * np.eye(3) + 2.0 * outer + 2.0 * e0 * skew


def momenta(system: Any, motion: Motion) -> tuple[Array, Array, Array, Array]:
    """(p, L about the world's origin, kinetic energy, potential energy of the weight): (n, 3), (n, 3), (n,), (n,)."""
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


def sizes(system: Any, motion: Motion, length: float) -> Sizes:
    """From a motion of a model of a given length [m]; a motion at rest has sizes too, from its weight."""
    span = float(motion.t[-1] - motion.t[0]) or 1.0
    mass = sum(body.mass for body in system.bodies) or 1.0
    pull = float(np.linalg.norm(system.gravity))
    turn = largest(motion.omega)
    speed = max(largest(motion.velocity - motion.velocity.mean(axis=1, keepdims=True)), largest(motion.velocity))
    speed = max(speed, turn * length, 1e-3 * np.sqrt(pull * length), 1e-3 * length / span)
    _, L, kinetic, weight = momenta(system, motion)
    loads = motion.reactions.values()
    force = max([largest(load.force) for load in loads], default=0.0) or mass * (pull or speed / span)
    reach = length + largest(motion.position)
    return Sizes(
        length=length,
        speed=speed,
        spin=max(turn, speed / length),
        momentum=mass * speed,
        angular_momentum=max(largest(L), mass * speed * reach * 1e-3),
        energy=max(float(kinetic.max()), float(np.ptp(weight)), 1e-3 * mass * speed**2),
        force=force,
        moment=max(max([largest(load.moment) for load in loads], default=0.0), force * length),
    )


def largest(values: Array) -> float:
    """Largest absolute value, 0 for none."""
    return float(np.abs(values).max(initial=0.0))


def quantities(system: Any, motion: Motion, size: Sizes, joints: tuple[str, ...] = ()) -> Mapping[str, Quantity]:
    """All quantities of a motion by name; reactions of ``joints``, with the joint's name as the part.

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
        loads = [motion.reactions[name] for name in joints]
        found["reaction force"] = Quantity(np.stack([x.force for x in loads], axis=1), joints, size.force)
        found["reaction moment"] = Quantity(np.stack([x.moment for x in loads], axis=1), joints, size.moment)
    return found
