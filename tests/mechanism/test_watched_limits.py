"""Limits that are watched: what they accept, and what becomes of them in copies, files and other systems."""

import copy
import pickle

import numpy as np
import pytest

from mbsd3d import GROUND, Body, Limit, Prismatic, Revolute, Spherical, System, load, simulate

ARM = Body("arm", mass=2.0, inertia=(0.1, 0.5, 0.4), com=(0.1, 0.2, 0.3), omega=None)
RAM = Body("ram", mass=1.0, inertia=(0.1, 0.2, 0.2), position=(1.0, 0, 0))
HINGE = Revolute(GROUND, ARM, at=(0.1, 0, 0), axis=(0.2, 0.3, 1), name="hinge")
RAIL = Prismatic(ARM, RAM, at=(1, 0, 0), axis=(1, 0.2, 0.1), name="rail")


def system(**given):
    """An arm with a ram, both limited."""
    limits = [Limit(HINGE, "angle", None, 0.5, "elbow"), Limit(RAIL, "slide", -0.2, 0.1)]
    return System([ARM, RAM], [HINGE, RAIL], limits=limits, notes=["inactive:\n1 actuator"], **given)


def test_the_largest_excess_and_its_time_are_said_by_every_run(tmp_path):
    run = simulate(system(), 0.8, state=system().assemble(rates={"hinge": 2.0, "rail": -1.0}), output=41)
    angle, slide = run.angle("hinge"), run.slide("rail")
    beyond = [np.maximum(angle - 0.5, 0.0), np.maximum(np.maximum(slide - 0.1, -0.2 - slide), 0.0)]
    expected = [
        f"limit of '{name}' passed by {x.max():.3g} {unit} at {run.t[x.argmax()]:.4g} s"
        for name, unit, x in zip(("elbow", "rail"), ("rad", "m"), beyond, strict=True)
    ]
    assert all(x.max() > 0.1 for x in beyond)
    assert [note for note in run.certificate.notes if note.startswith("limit")] == expected
    assert run.certificate.notes[0] == "inactive: 1 actuator" and run.certificate.passed
    again = load(run.save(tmp_path / "run"))
    assert again.certificate.notes == run.certificate.notes


def test_a_run_inside_its_limits_says_nothing():
    held = System([ARM], [HINGE], limits=[Limit(HINGE, "angle", 0.0, 3.0)], gravity=(0, 0, 0))
    run = simulate(held, 0.1, state=held.assemble(rates={"hinge": 1.0}))
    assert not [note for note in run.certificate.notes if note.startswith("limit")]  # it starts on its lower limit


@pytest.mark.parametrize("suffix", ["json", "toml"])
def test_limits_and_notes_go_to_files_and_copies(tmp_path, suffix):
    for again in (
        System.from_file(system().to_file(tmp_path / f"arm.{suffix}")),
        copy.deepcopy(system()),
        pickle.loads(pickle.dumps(system())),
    ):
        hinge, rail = again.limits
        assert (hinge.lower, hinge.upper, hinge.name) == (None, 0.5, "elbow")
        assert (rail.kind, rail.lower, rail.upper) == ("slide", -0.2, 0.1) and again.notes == ("inactive: 1 actuator",)
        assert hinge.joint is again.joints[0] and rail.joint is again.joints[1]


def test_a_joint_that_lets_go_takes_its_limit_along():
    released = system().release("rail", system().state())
    assert [limit.joint.name for limit in released.system.limits] == ["hinge"]
    assert released.system.notes == system().notes


BALL = Spherical(GROUND, ARM, at=(0, 0, 0), name="ball")
WRONG = [
    (lambda: Limit(BALL, "angle", 0.0, 1.0), "limit of 'ball': Spherical 'ball' has no angle"),
    (lambda: Limit(HINGE, "turn", 0.0, 1.0), "limit of 'hinge': kind 'turn' is unknown; give 'angle' or 'slide'"),
    (lambda: Limit(HINGE, "angle", 1.0, 0.0), "limit of 'hinge': lower 1 exceeds upper 0; exchange them"),
    (lambda: Limit(HINGE, "angle", np.nan, 0.0), "limit of 'hinge': lower"),
    (lambda: Limit("hinge", "angle"), "'hinge' is not a joint"),
    (
        lambda: System([ARM], [HINGE], limits=[Limit(RAIL, "slide", 0, 1)]),
        "limit of 'rail': its joint is not in the sys",
    ),
    (lambda: System([ARM], [HINGE], limits=["hinge"]), "limits: 'hinge' is not a limit; give Limit"),
    (lambda: System([ARM], [HINGE], limits=3), "limits: 3 is not a sequence"),
    (lambda: System([ARM], [HINGE], notes=[3]), "notes: 3 is not a string"),
    (lambda: System([ARM], [HINGE], notes=["a\x1b[2Jb"]), "notes name .* holds control characters"),
    (lambda: Limit(HINGE, "angle", 0.0, 1.0, "a\x1b[2Jb"), "limit: name .* holds control characters"),
]


@pytest.mark.parametrize(("make", "message"), WRONG)
def test_wrong_limits_are_named(make, message):
    with pytest.raises(ValueError, match=message):
        make()
