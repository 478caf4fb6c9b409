"""Poses that are nearly singular: said beforehand, with the joints that could move; silence elsewhere."""

import numpy as np
import pytest
from models import revolute_chain

from mbsd3d.demos.turning.wrist_singularity import wrist
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
