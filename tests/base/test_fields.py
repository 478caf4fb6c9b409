"""Fields of parts: converted once, read-only, with two types; signatures that one can read."""

import dataclasses
import inspect

import numpy as np
import pytest

from mbsd3d import GROUND, Body, Revolute, SpringDamper, System, Tyre, rotation
from mbsd3d.errors import InputError

ROD = Body("rod", 1.2, (0.2, 0.3, 0.4), com=[0.1, 0.2, 0.3], position=np.array([0.4, -0.1, 0.7]))
HINGE = Revolute(GROUND, ROD, at=(0.1, 0.2, 0.3), axis=(1, 2, 2))


def test_what_is_kept_is_an_own_array_that_nobody_writes_into():
    given = np.array([0.3, 0.4, -0.5])
    body = Body("rod", 1.2, np.diag([0.2, 0.3, 0.4]), com=given, orientation=rotation((1, 2, 3), 0.7))
    given[0] = 9.0
    assert body.com.tolist() == [0.3, 0.4, -0.5]
    for array in (body.inertia, body.com, body.position, body.orientation, HINGE.at, HINGE.axis, HINGE.axis_b):
        assert not array.flags.writeable
    with pytest.raises(dataclasses.FrozenInstanceError, match="mass"):
        body.mass = 3.0


def test_defaults_that_follow_from_other_fields():
    assert HINGE.at_b is HINGE.at and HINGE.axis_b is HINGE.axis
    spring = SpringDamper(GROUND, ROD, at_a=(0, 0, 1), at_b=(1, 2, 3), stiffness=4.0)
    assert spring.length == 3.0
    with pytest.raises(InputError, match="'s' .SpringDamper.: at_a and at_b coincide, .* length=None"):
        SpringDamper(GROUND, ROD, at_a=(1, 2, 3), at_b=(1, 2, 3), stiffness=4.0, name="s")
    assert SpringDamper(GROUND, ROD, at_a=(1, 2, 3), at_b=(1, 2, 3), stiffness=4.0, length=0).length == 0.0
    moved = dataclasses.replace(HINGE, at_b=(0.1, 0.2, 0.4))
    assert moved.at_b[2] == 0.4 and moved.at.tolist() == HINGE.at.tolist()


@pytest.mark.parametrize(
    "value", [(1.0, 2, True), ("1", 2, 3), (1, 2), np.ones(4), np.array([1, 2, np.nan]), 3.0, None]
)
def test_no_quick_way_takes_what_the_long_one_refuses(value):
    with pytest.raises(InputError, match="body 'rod': com: "):
        Body("rod", 1.2, (0.2, 0.3, 0.4), com=value)
    with pytest.raises(InputError, match="body 'rod': inertia|body 'rod': com"):
        Body("rod", 1.2, value)


def test_the_quick_way_for_an_inertia_gives_the_bits_of_the_long_one_and_refuses_what_it_refuses():
    rng = np.random.default_rng(7)
    for k in range(500):
        A = rng.normal(size=(3, 3))
        J = A @ A.T * 10.0 ** rng.integers(-6, 7)
        good = np.trace(J) * np.eye(3) - J  # int r^2 1 - r r' dm of any cloud
        good = 0.5 * (good + good.T)
        assert Body("b", 2.0, good).inertia.tobytes() == Body("b", 2.0, good.tolist()).inertia.tobytes()
        moments = np.linalg.eigvalsh(good)
        assert (Body("b", 2.0, moments).inertia == np.diag(moments)).all()
        R, largest = np.linalg.qr(A)[0], 1.001 + 0.1 * k
        bad = R @ np.diag([1.0, 2.0, 3.0 * largest]) @ R.T
        for inertia in (0.5 * (bad + bad.T), (1.0, 2.0, 3.0 * largest), -good, good + np.triu(A, 1)):
            with pytest.raises(InputError, match="body 'b': inertia"):
                Body("b", 2.0, inertia)
    assert not Body("b", 2.0, (0, 0, 0)).inertia.any() and Body("b", 2.0, (4, 4, 0)).inertia[0, 0] == 4.0


@pytest.mark.parametrize("kind", [Body, Revolute, SpringDamper, System, Tyre])
def test_signatures_say_what_is_accepted_in_words(kind):
    text = str(inspect.signature(kind))
    assert "array_like" in text and not {"numpy", "_typing", "Stored", "Vector"} & set(text.replace(".", " ").split())
    assert len(text) < 700
