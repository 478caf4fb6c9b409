"""Poses that are singular or nearly so: said beforehand, with the joints that could move; silence elsewhere."""

import re

import numpy as np
import pytest
from helpers.models import revolute_chain

from mbsd3d import GROUND, Body, Fixed, Prismatic, Revolute, SlideDriver, Spherical, System, Universal, rotation
from mbsd3d.demos.turning.wrist_singularity import wrist
from mbsd3d.rotations import matrix
from validation import cases


def warned(system):
    """Whether the pose is called nearly singular."""
    return any("nearly singular" in note for note in system.check().notes)


def test_a_wrist_is_seen_to_come_near_to_its_stretched_pose():
    """The angle between axes 4 and 6 is what is lost: the least singular value falls in proportion to its sine."""
    near, nearer = (wrist(1.0, miss, 0.0).check() for miss in (0.5, 0.05))
    slope = np.sin(np.radians(0.5)) / np.sin(np.radians(0.05))
    assert near.least_singular / nearer.least_singular == pytest.approx(
        slope, rel=1e-4
    )  # next order: the angle squared
    (note,) = nearer.notes
    assert note.startswith("nearly singular: 'axis 4' and 'axis 6' can all but move")
    assert f"{1.0 / nearer.least_singular:.0f} times" in note
    assert not warned(wrist(1.0, 30.0, 0.0))


def test_reference_mechanisms_are_not_near():
    assert [name for name in cases.names() if warned(cases.load(name).system)] == []
    assert not warned(revolute_chain(200))


def press(size):
    """A crank 0.02 rad before its dead centre and a rod, whose piston is driven; size 1: crank of 0.7 m."""
    pin, head = size * 0.7 * np.array([np.cos(0.02), np.sin(0.02), 0.0]), size * np.array([2.6, 0.0, 0.0])
    numbers = dict(com=size * np.array([0.1, 0.05, -0.02]))
    crank, rod, piston = (
        Body(name, 1.0, size**2 * np.array([0.1, 0.2, 0.2]), position=at, **numbers)
        for name, at in (("crank", 0.5 * pin), ("rod", 0.5 * (pin + head)), ("piston", head))
    )
    bore = Prismatic(GROUND, piston, at=head, axis=(1, 0, 0), name="bore")
    joints = [
        Revolute(GROUND, crank, at=(0, 0, 0), axis=(0, 0, 1), name="main"),
        Spherical(crank, rod, at=pin, name="big end"),
        Universal(rod, piston, at=head, axis_a=(0, 0, 1), axis_b=(0, 1, 0), name="small end"),
        bore,
        SlideDriver(bore, 0.0, name="drive"),
    ]
    return System([crank, rod, piston], joints)


@pytest.mark.parametrize("size", [0.02, 1.0, 1000.0])
def test_joints_that_could_move_are_the_same_at_any_size(size):
    """Crank and rod turn about their own points by like angles; the pin of the piston hardly turns."""
    (note,) = press(size).check().notes
    assert note.startswith("nearly singular: 'main' and 'big end' can all but move")


def test_a_long_beam_is_soft_and_not_singular():
    """Of welded pieces singular values fall evenly, far below the largest: none is about to be lost."""
    pieces = [Body(f"piece {k}", 1.0, (0.1, 0.2, 0.2), position=(k + 0.5, 0.1, -0.2)) for k in range(20)]
    welds = [Fixed(a, b, at=(k, 0, 0)) for k, (a, b) in enumerate(zip([GROUND, *pieces], pieces, strict=False))]
    found = System(pieces, welds).check()
    assert found.least_singular < 0.01 and not found.notes


def flat_four_bar_with_chain(balls):
    """A parallelogram whose rods lie on one line, tilted in space, beside a chain of rods on balls."""
    R = matrix(rotation((1.0, 0.3, -0.7), 0.8))
    rods = [
        Body(f"rod {k}", 1.0 + k, (0.1, 0.2, 0.25), com=(0.1, 0.05, 0.02), position=x * R[:, 0])
        for k, x in enumerate((0.4, 1.5, 2.6))
    ]
    left, coupler, right = rods
    pins = [(GROUND, left, 0), (left, coupler, 1), (coupler, right, 3), (GROUND, right, 2)]
    joints = [Revolute(a, b, at=x * R[:, 0], axis=R[:, 2], name=f"pin {x}") for a, b, x in pins]
    links, above = [], GROUND
    for k in range(balls):
        at = np.array([0.3 + 0.4 * k, 0.2 * np.sin(k), -k])
        links.append(Body(f"link {k}", 1.0, (0.1, 0.2, 0.25), com=(0.1, 0, 0.2), position=at))
        joints.append(Spherical(above, links[-1], at=at, name=f"ball {k}"))
        above = links[-1]
    return System([*rods, *links], joints)


@pytest.mark.parametrize("balls", [0, 3, 25])
def test_what_moves_beside_a_singular_loop_is_not_named(balls):
    """Beside it the rods turn alike or against each other; gained are pins that turn by 1, -2, 0, -1 or 1, -1, 1, 1."""
    notes, rank = flat_four_bar_with_chain(balls).check().notes, 16 + 3 * balls
    (note,) = (note for note in notes if not note.startswith("freedom"))
    assert note.startswith(f"singular (rank {rank}, {rank + 1} beside it): ")
    assert {"pin 0", "pin 1", "pin 2"} <= set(re.findall("'(.*?)'", note)) <= {f"pin {k}" for k in range(4)}
