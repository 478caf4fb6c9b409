"""What a result depends on: every effect is that of the changed model built by hand."""

import csv

import numpy as np
import pytest

from mbsd3d import (
    GROUND,
    Body,
    Bushing,
    CustomForce,
    Force,
    Gear,
    Polynomial,
    Prismatic,
    Revolute,
    SlideDriver,
    Spherical,
    SpringDamper,
    Study,
    System,
    TorsionSpring,
    errors,
    explain,
    measures,
    rotation,
    simulate,
)

RUN = {"t_end": 0.8, "output": 41, "rtol": 1e-10}


def drive(stiffness=30.0, mass=2.0, *, spring=True, gravity=(0.3, 0.1, -9.7), second=True):
    """An arm on a spring, geared to a rotor; axes and centres of mass at general places."""
    arm = Body("arm", mass, (0.11, 0.2, 0.16), com=(0.2, 0.05, -0.1), position=(0.1, 0.2, 0.3), omega=(0.1, 1.0, 0.2))
    rotor = Body("rotor", 0.7, (0.01, 0.012, 0.009), com=(0.01, 0.0, 0.02), position=(-0.4, 0.3, 0.2))
    hinge = Revolute(GROUND, arm, at=(0.1, 0.2, 0.3), axis=(0.1, 1.0, 0.2), name="hinge")
    axle = Revolute(GROUND, rotor, at=(-0.4, 0.3, 0.2), axis=(0.3, 1.0, -0.2), name="axle")
    joints = [hinge, axle] + ([Gear(hinge, axle, ratio=-2.5, name="gear")] if second else [])
    rope = SpringDamper(GROUND, arm, at_a=(0.9, 0.1, 0.2), at_b=(0.3, 0.2, 0.2), stiffness=3.0, name="rope")
    forces = [TorsionSpring(hinge, stiffness=stiffness, damping=0.1, name="spring")] if spring else []
    return System([arm, rotor], joints, [*forces, rope], gravity=gravity)


def measure(solution):
    return {
        "angle": solution.angle("hinge")[-1],
        "load": np.linalg.norm(solution.reaction("axle").force, axis=1),
    }


def effect(system):
    """The relative change against the model as it is, by two runs."""
    new, old = (measure(simulate(x, **RUN)) for x in (system, drive()))
    apart = new["load"] - old["load"]
    most = apart[np.abs(apart).argmax()] / np.abs(old["load"]).max()
    return {"angle": (new["angle"] - old["angle"]) / abs(old["angle"]), "load": most}


@pytest.fixture(scope="module")
def found():
    return explain(drive, measure, run=RUN, parameters={"stiffness": 30.0, "mass": 2.0})


def test_effects_are_those_of_the_changed_model(found):
    by_part = {(x.part, x.change): x for x in found.effects}
    wanted = {
        ("gravity", "left out"): drive(gravity=(0, 0, 0)),
        ("spring", "left out"): drive(spring=False),
        ("gear", "left out"): drive(second=False),
        ("parameter stiffness", "+1 %"): drive(stiffness=30.3),
        ("spring: stiffness", "+1 %"): drive(stiffness=30.3),
        ("arm: mass", "+1 %"): drive(mass=2.02),
    }
    for key, system in wanted.items():
        for name, value in effect(system).items():
            assert by_part[key].values[name] == pytest.approx(value, rel=1e-12, abs=1e-13), (key, name)
    assert by_part["gyroscopic term w x I w", "left out"].values["angle"] == 0.0  # an arm on a hinge


def test_what_refers_to_a_part_goes_with_it(found):
    parts = [x.part for x in found.effects]
    assert "axle (with gear)" in parts and "hinge (with gear, spring)" in parts
    failed = {x.part: x.error for x in found.groups["no run"]}
    assert set(failed) == {
        "axle (with gear)",
        "hinge (with gear, spring)",
    }  # measured, so nothing is left to read
    assert all("is not one of the joints" in text for text in failed.values())


def test_lists_are_ranked_and_written_in_every_form(found, tmp_path):
    for kind in ("left out", "+1 %"):
        sizes = [x.largest for x in found.groups[kind]]
        assert sizes == sorted(sizes, reverse=True) and sizes[0] > 0.0
    assert str(found).splitlines()[0].split() == ["left", "out", "angle", "load"]
    with found.to_csv(tmp_path / "why").open() as file:
        rows = [*csv.DictReader(file)]
    assert len(rows) == len(found.effects) and float(rows[2]["angle"]) == found.effects[2].values["angle"]
    assert "<svg" in found.page(tmp_path / "why").html and (tmp_path / "why.html").exists()
    assert len(found.figure().axes) == 2
    assert "<table>" in found._repr_html_()


def test_a_system_is_explained_without_parameters():
    found = explain(drive(), measure, run=RUN, percent=5.0)
    value = {x.part: x.values for x in found.effects if x.change == "+5 %"}["spring: stiffness"]
    assert value["angle"] == pytest.approx(effect(drive(stiffness=31.5))["angle"], rel=1e-12)


def test_a_study_brings_measure_run_and_parameters(found):
    study = Study(drive, {"stiffness": 30.0, "mass": 2.0}, measure, RUN)
    of_study = explain(study)
    assert [(x.part, x.change, x.values) for x in of_study.effects] == [
        (x.part, x.change, x.values) for x in found.effects
    ]
    later = Study(drive, {"mass": 2.0}, measure, lambda mass: {**RUN, "t_end": 0.4 * mass})
    assert explain(later, parameters={"stiffness": 30.0}).effects[0].values == found.effects[0].values
    for given, message in (
        ({"build": Study(drive, {"mass": 2.0}, lambda system: system.total_mass())}, "no run; give .*t_end"),
        ({"build": drive(), "run": RUN}, "no measure; give"),
        ({"build": drive(), "measure": measure}, "no run; give"),
    ):
        with pytest.raises(errors.InputError, match=message):
            explain(**given)


def test_an_output_that_is_no_number_is_no_effect():
    found = explain(
        drive(), lambda run: np.log(run.angle("hinge")[-1]) if abs(run.system.gravity[0]) else np.nan, run=RUN
    )
    (failed,) = (x for x in found.effects if x.part == "gravity")
    assert "is not a number" in failed.error and failed in found.groups["no run"]


def idle(t, bodies, z, parameters, loads, z_dot):
    """A force by a function."""


def test_what_it_refuses():
    system = drive()
    with pytest.raises(ValueError, match="run has state, which belongs to one system"):
        explain(system, measure, run={**RUN, "state": system.state()})
    with pytest.raises(ValueError, match="run has stop_when"):
        explain(system, measure, run={**RUN, "stop_when": measures.angle(system.joints[0]) > 3.0})
    with pytest.raises(ValueError, match="parameters are for build"):
        explain(system, measure, run=RUN, parameters={"mass": 1.0})
    with pytest.raises(ValueError, match="percent"):
        explain(system, measure, run=RUN, percent=0.0)
    with pytest.raises(errors.SweepError, match="the model as it is does not run: .*'none'"):
        explain(system, lambda run: run.angle("none")[-1], run=RUN)
    own = CustomForce(idle, on=(GROUND, system.bodies[0]), name="own")
    with pytest.raises(ValueError, match="own"):
        explain(System(system.bodies, system.joints, [own]), measure, run=RUN)


def test_vectors_and_lists_of_numbers_are_changed_as_a_whole():
    def pushed(force=(1.0, -2.0, 0.5), coefficients=(0.0, 0.2, 0.4), turning=(3.0, 2.0, 4.0)):
        arm = Body("arm", 2.0, (0.11, 0.2, 0.16), com=(0.2, 0.05, -0.1), position=(0.1, 0.2, 0.3))
        slider = Prismatic(GROUND, arm, at=(0.1, 0.2, 0.3), axis="x", name="slider")
        tip = Body("tip", 0.7, (0.01, 0.012, 0.009), com=(0.01, 0.0, 0.02), position=(0.4, 0.3, 0.2))
        ball = Spherical(arm, tip, at=(0.4, 0.3, 0.2), name="ball")
        drive = SlideDriver(slider, Polynomial(coefficients), name="drive")
        turn = rotation((1, 2, 3), 0.4)
        rubber = Bushing(
            arm, tip, at=(0.4, 0.3, 0.2), stiffness=1.0, turning_stiffness=turning, axes=turn, name="rubber"
        )
        push = Force(tip, force=force, at=(0.5, 0.1, 0.1), name="push")
        return System([arm, tip], [slider, ball, drive], [rubber, push])

    def turned(run):
        return run.omega("tip")[-1]

    run = {"t_end": 0.3, "output": 4, "rtol": 1e-10}
    found = explain(pushed(), turned, run=run)
    assert not found.groups["no run"]
    values = {x.part: x.values["turned"] for x in found.groups["+1 %"]}
    base = turned(simulate(pushed(), **run))
    for part, system in {
        "push: force 1 value": pushed(force=(1.0, -2.02, 0.5)),
        "drive: signal coefficients": pushed(coefficients=(0.0, 0.202, 0.404)),
        "rubber: turning_stiffness": pushed(turning=(3.03, 2.02, 4.04)),
    }.items():
        apart = turned(simulate(system, **run)) - base
        assert values[part] == pytest.approx(apart[np.abs(apart).argmax()] / np.abs(base).max(), rel=1e-9), part
    assert not {x for x in values if "axes" in x or "at" in x.split()}


@pytest.mark.parametrize(("result", "found"), [(np.nan, "nan"), ([1.0, np.nan], "nan"), ([], r"\[\]"), ({}, "nothing")])
def test_an_output_of_the_unchanged_model_is_a_number(result, found):
    with pytest.raises(errors.SweepError, match=f"model as it is measure returned .*{found}"):
        explain(drive(), lambda run: result, run={"t_end": 0.01})


def needs(stiffness, *, mass=2.0):
    """A model with a parameter that must be given."""
    return drive(stiffness, mass)


@pytest.mark.parametrize(
    ("build", "given", "message"),
    [
        (needs, {}, "explain: build does not take the parameters none .*it takes stiffness, mass"),
        (needs, {"parameters": {"stifness": 3.0}}, "explain: build does not take the parameters stifness"),
        (needs, {"parameters": [3.0]}, "explain: parameters .*give a mapping"),
        (needs, {"parameters": {"stiffness": 3.0}, "run": None}, "explain: no run; give the arguments"),
        ("model.toml", {}, "explain: build 'model.toml' is not a function"),
    ],
)
def test_what_it_is_given_is_checked_first(build, given, message):
    with pytest.raises(ValueError, match=message):
        explain(build, measure, **{"run": RUN, **given})
