"""Mechanisms in general position run here and in MuJoCo, for the tests of the twin."""

import numpy as np
import pytest

from helpers.models import EXAMPLES, across, consistent_state, direction, middle, random_body
from mbsd3d import (
    GROUND,
    Coupler,
    Cylindrical,
    Force,
    Gear,
    GearMesh,
    JointFriction,
    Planar,
    RackPinion,
    Ramp,
    Revolute,
    Sine,
    Spherical,
    SpringDamper,
    System,
    Torque,
    TorsionSpring,
    Universal,
    accelerations,
    simulate,
)
from mbsd3d.equations.dense_solvers import inertia_about_origin
from validation.twins.mujoco import twin

mujoco = pytest.importorskip("mujoco")

GRAVITY = (0.4, -0.8, -9.6)
SETTLED = 1024  # steps to 0.4 s; the rows swing in from rest with a time of 16 steps, much less than the first sample
LEFT = 4e-6  # m, rad: (w h)^2 of second order, with rates of 10 rad/s and the finer run's steps of 0.4 s / 2048


def bodies_of(seed):
    """Four general bodies beside each other."""
    rng = np.random.default_rng(seed)
    return rng, [random_body(rng, f"body {k}", position=[0.9 * k, 0.5 * (-1) ** k, 0.2 * k]) for k in range(4)]


def tree(cls, seed=5):
    """A joint in general position between the ground and a body, or among several, and a body that hangs on it."""
    rng, (first, second, third, last) = bodies_of(seed)
    if cls is GearMesh:
        joints = EXAMPLES[cls](rng, first, second, third, None)
    elif cls in (Coupler, Gear, RackPinion):
        joints = EXAMPLES[cls](rng, GROUND, first, first, second)
    else:
        joints = EXAMPLES[cls](rng, GROUND, first, None, None)
    joints.append(Revolute(first, last, at=middle(rng, first, last), axis=direction(rng), name="last"))
    used = {id(body) for joint in joints for body in (joint.a, joint.b)}
    return System([body for body in (first, second, third, last) if id(body) in used], joints, gravity=GRAVITY)


def loop(cls, seed=1):
    """Three bodies on balls, hung on the ground, and a joint from the last to the first that closes them to a loop."""
    rng, (first, second, third, _) = bodies_of(seed)
    balls = [(GROUND, first, (0, 0.1, 0.3)), (first, second, (0.5, 0.2, 0.1)), (second, third, (1.3, 0.1, 0.1))]
    joints = [Spherical(a, b, at=at) for a, b, at in balls]
    joints += EXAMPLES[cls](rng, third, first, None, None)
    return System([first, second, third], joints, gravity=GRAVITY)


def start(system):
    """The reference pose in general motion."""
    return consistent_state(system, np.random.default_rng(3))


class Pair:
    """A system run here and in MuJoCo from the same start."""

    def __init__(self, system, state=None, t_end=0.4, **settings):
        self.system, self.state, self.t_end = system, state or start(system), t_end
        self.twin = twin(system, state=self.state, **settings)
        self.solution = simulate(system, t_end, state=self.state, rtol=1e-12, output=5)

    def errors(self, steps):
        """Largest differences of positions, velocities and of what is determined of reactions, after the start."""
        motion, apart = self.twin.run(self.t_end, steps, 4), np.zeros(3)
        for i, body in enumerate(self.system.bodies):
            for k, quantity in enumerate(("position", "velocity", "omega")):
                found, ours = getattr(motion, quantity)[:, i], getattr(self.solution, quantity)(body)
                apart[min(k, 1)] = max(apart[min(k, 1)], np.abs(found - ours).max())
        for name, load in motion.reactions.items():
            ours = self.solution.reaction(name)
            for D, x, y in zip(
                (ours.force_projector, ours.moment_projector), load, (ours.force, ours.moment), strict=True
            ):
                apart[2] = max(apart[2], np.abs(np.einsum("tij,tj->ti", D, x - y))[1:].max())
        return apart

    def orders(self, steps):
        """Order of the three from ``steps`` and twice as many, and the smaller errors."""
        coarse, fine = self.errors(steps), self.errors(2 * steps)
        return np.log2(coarse / fine), fine


def instant(pair):
    """Relative differences of mass matrix and accelerations at the start."""
    system, state, kinetic = pair.system, pair.state, pair.twin.kinetic()
    n = len(system.bodies)
    M = np.zeros((n, 6, n, 6))
    for i, body in enumerate(system.bodies):
        M[i, :, i] = inertia_about_origin(state.q[7 * i + 3 : 7 * i + 7], body.com, body.mass, body.inertia)
    M = kinetic.map.T @ M.reshape(6 * n, 6 * n) @ kinetic.map
    found = accelerations(system, state)
    ours = np.array([[*found.acceleration(b)[0], *found.alpha(b)[0]] for b in system.bodies])
    apart = np.abs(pair.twin.accelerations() - ours).max() / np.abs(ours).max()
    return np.abs(kinetic.matrix - M).max() / np.abs(M).max(), apart


def forces(bodies, joints):
    """Every force MuJoCo has, components of time among them, in both frames, rest values of both signs."""
    first, second, third, last = bodies
    return [
        Force(second, (3.0, -2.0, 1.0), at=second.position + 0.3),
        Force(third, (3.0, Sine(2.0, 1.0, 0.3, 0.2), 1.0), at=third.position + 0.2, frame="body"),
        Torque(last, (0.3, 0.5, -0.4)),
        Torque(first, (0.3, Ramp(0.5, 0.1), -0.4), frame="body"),
        SpringDamper(
            first, last, at_a=first.position + 0.1, at_b=last.position - 0.2, stiffness=20.0, damping=0.7, length=1.1
        ),
        TorsionSpring(joints[0], stiffness=9.0, damping=0.4, angle=-0.3),
        TorsionSpring(joints[3], stiffness=9.0, damping=0.4, angle=0.3),
        JointFriction(joints[1], viscous=0.3),
    ]


def loaded(*more):
    """A chain whose joints stand both ways round, with all forces; ``more`` makes joints from the bodies and joints."""
    rng, bodies = bodies_of(5)
    first, second, third, last = bodies
    axis = direction(rng)
    joints = [
        Revolute(GROUND, first, at=middle(rng, GROUND, first), axis=direction(rng), name="hinge"),
        Cylindrical(second, first, at=middle(rng, first, second), axis=direction(rng), name="tube"),
        Universal(third, second, at=middle(rng, third, second), axis_a=axis, axis_b=across(rng, axis)),
        Planar(last, third, at=middle(rng, third, last), normal=direction(rng), name="table"),
    ]
    joints += [make(bodies, joints) for make in more]
    return System(bodies, joints, forces(bodies, joints), gravity=GRAVITY)
