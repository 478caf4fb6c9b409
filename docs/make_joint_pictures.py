"""Makes the pictures of the joints, three moments of a free motion: ``python docs/make_joint_pictures.py FOLDER``."""

import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from make_pictures import png

import mbsd3d as m
from mbsd3d import shapes
from mbsd3d.base.paths import write_atomically
from mbsd3d.view.scene.drawing import NAMES

X, Y, Z, HERE = (1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, 0)
SHAFT = (0.0, -0.5, np.sqrt(0.75))  # of the constant-velocity joint, 30 degrees off
BARE = (*NAMES, "traces", "ground grid")
EGG = shapes.Ellipsoid((0.2, 0.14, 0.14), colour="#d5731d")
TURNING = {"omega": (0.5, 0.9, 0.7)}
TURN = 2 * np.pi * np.arange(40) / 40
RING = np.column_stack([0.28 * np.cos(TURN) - 0.28, 0.26 * np.sin(TURN), 0.1 - 0.1 * np.cos(2 * TURN)])
JOINTS = {
    "Spherical": (lambda a, b: m.Spherical(a, b, at=HERE), TURNING),
    "Revolute": (lambda a, b: m.Revolute(a, b, at=HERE, axis=Y), {"omega": (0, 1.0, 0)}),
    "Universal": (lambda a, b: m.Universal(a, b, at=HERE, axis_a=X, axis_b=Y), {"omega": (0.6, 0.7, 0)}),
    "Prismatic": (lambda a, b: m.Prismatic(a, b, at=HERE, axis=Z), {"velocity": (0, 0, 0.35)}),
    "Cylindrical": (
        lambda a, b: m.Cylindrical(a, b, at=HERE, axis=Z),
        {"velocity": (0, 0, 0.35), "omega": (0, 0, 1.0)},
    ),
    "Screw": (lambda a, b: m.Screw(a, b, at=HERE, axis=Z, pitch=2.2), {"omega": (0, 0, 1.0)}),
    "Planar": (lambda a, b: m.Planar(a, b, at=HERE, normal=Z), {"velocity": (0.4, 0.25, 0), "omega": (0, 0, 0.8)}),
    "Fixed": (lambda a, b: m.Fixed(a, b, at=HERE), {}),
    "PointOnLine": (
        lambda a, b: m.PointOnLine(a, b, at=HERE, axis=X),
        {"velocity": (0.5, 0, 0), "omega": (-0.7, 0, 1)},
    ),
    "PointOnPlane": (
        lambda a, b: m.PointOnPlane(a, b, at=HERE, normal=Z),
        {"velocity": (0.5, 0.2, 0), "omega": (0, 0.8, 0)},
    ),
    "Distance": (lambda a, b: m.Distance(a, b, at_a=(0.2, 0, 0), at_b=(0, 0, 0.35)), {"velocity": (0, 0.5, 0)}),
    "Parallel": (lambda a, b: m.Parallel(a, b, axis=Z), {"velocity": (0.5, 0.3, 0.2), "omega": (0, 0, 0.8)}),
    "Perpendicular": (
        lambda a, b: m.Perpendicular(a, b, axis_a=X, axis_b=Z),
        {"velocity": (0.4, 0.3, 0.1), "omega": (0.8, 0, 0.0)},
    ),
    "ConstantVelocity": (
        lambda a, b: m.ConstantVelocity(a, b, at=HERE, axis_a=Z, axis_b=SHAFT),
        {"omega": (0.5, 0.4 * (1 + SHAFT[2]), -0.4 * SHAFT[1])},
    ),
    "CurveContact": (
        lambda a, b: m.CurveContact(a, b, RING, at=HERE, name="wire"),
        {"velocity": (0, 0.45, 0), "omega": (0.2, 0.2, 0.6)},
    ),
    "Rolling": (
        lambda a, b: m.Rolling(a, b, EGG, plane=((0, 0, -0.1), Z)),
        {"velocity": (0, 0.35, 0), "omega": (-2.5, 0, 0.5)},
    ),
    "RollingDisc": (
        lambda a, b: m.RollingDisc(a, b, axis=X, radius=0.25, plane=((0, 0, -0.1), Z)),
        {"velocity": (0, 0.5, 0), "omega": (-2.0, 0, 0.5)},
    ),
    "KnifeEdge": (lambda a, b: m.KnifeEdge(a, b, at=HERE, lateral=Y), {"velocity": (0.5, 0, 0), "omega": (0, 0, 0.8)}),
}


def pair(name: str) -> m.System:
    """Body b on a slab a, with the velocities that a joint leaves it."""
    make, moves = JOINTS[name]
    return m.System([(slab := ground()), (part := body(name, moves))], [held(slab), make(slab, part)], gravity=HERE)


def ground() -> m.Body:
    """The slab a."""
    return m.Body("a", 1.0, (1, 1, 1), position=(0, 0, -0.15), shape=shapes.Box((0.7, 0.7, 0.1), colour="#9a9a9a"))


def held(slab: m.Body) -> m.Joint:
    """Holds the slab."""
    return m.Fixed(m.GROUND, slab, at=(0, 0, -0.15))


def body(name: str, moves: Mapping) -> m.Body:
    """The part b: a pillar, or a wheel."""
    if name == "Rolling":
        return m.Body("b", 1.0, (0.02, 0.03, 0.03), position=(0, 0, 0.04), shape=EGG, **moves)
    if name == "RollingDisc":
        wheel = shapes.Disc(0.25, 0.05, axis="x", colour="#d5731d")
        return m.Body("b", 1.0, (0.03, 0.02, 0.02), position=(0, 0, 0.15), shape=wheel, **moves)
    turn = m.rotation("x", 30, degrees=True) if name == "ConstantVelocity" else (1, 0, 0, 0)
    pillar = shapes.Box((0.14, 0.2, 0.4), at=(0, 0, 0.3), colour="#d5731d")
    return m.Body("b", 1.0, (0.2, 0.2, 0.2), com=(0, 0, 0.3) if "velocity" not in moves else HERE, orientation=turn,
                  shape=pillar, **moves)  # fmt: skip


def make(folder: Path) -> list[Path]:
    """One picture a joint into a folder that exists."""
    done = []
    for name in JOINTS:
        run = m.simulate(pair(name), 0.8, output=[0.0, 0.4, 0.8])
        figure = run.picture([0.0, 0.4, 0.8], size=(3.0, 1.9), view=(-58, 22), hidden=BARE)
        done.append(write_atomically(folder / f"{name}.png", png(figure)))
    return done


if __name__ == "__main__":
    make(Path(sys.argv[1]))
