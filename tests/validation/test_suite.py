"""The suite of all cases: its list, its judges, and the verdicts they come to."""

import sys
from dataclasses import replace

import numpy as np
import pytest

from bicycle.parameters import fittings
from engines.balance.layouts import names
from mbsd3d.extend import discover
from validation import cases
from validation.suite import findings as words
from validation.suite import trials as listing
from validation.suite.findings import JUDGES, Finding, Record, judged, not_compared
from validation.suite.suite import examined, lost
from validation.suite.trials import bicycles, engines, families, references, tyres, vehicles
from validation.suite.trials.trial import examine, run


def test_the_list_holds_everything():
    everything, short = listing.trials(), listing.trials(quick=True)
    found = [trial.name for trial in everything]
    assert len(found) == len(set(found))
    assert set(cases.names()) <= set(found)
    shown = {name.removeprefix("gallery_") for name in found}
    assert set(discover()) <= shown
    assert {f"engine_{name}" for name in names()} <= set(found)
    assert sum(trial.group == "random mechanisms" for trial in everything) == families.RANDOM_COUNT == 200
    assert sum(trial.group == "random mechanisms" for trial in short) == families.QUICK_RANDOM_COUNT == 20
    assert {trial.name for trial in short} <= set(found)
    assert set(references.STATIC_JUDGES) == set(cases.names()) - set(cases.names(timed=True))


@pytest.mark.parametrize("name", cases.names())
def test_reference_cases_agree_with_file_theory_and_plane(name):
    found, made = examine(references.trial_of(name))
    assert found.failures == () and found.verdict == "agrees"
    assert {finding.judge for finding in found.findings} <= set(JUDGES)
    assert made.system.bodies


def test_closed_forms_and_planar_models_judge_the_cases_that_have_them():
    with_theory = [name for name in cases.names() if name in references.CLOSED_FORMS]
    assert len(with_theory) == 12
    flat = ("coriolis_slider", "door_two_hinges", "iftomm_A02_fourbar_N2", "iftomm_A03_andrews")
    for name in flat:
        found = examine(references.trial_of(name))[0]
        assert found.worst("plane").verdict == "agrees"


@pytest.mark.parametrize("switch", ["gyroscopic", "centripetal", "gamma"])
def test_wrong_equations_differ_from_file_and_theory(switch):
    def wrong():
        case = cases.load("heavy_top_fast", references.SHIFT_SEED)
        return run(case.system, case.t_end, output=case.times, source=case, accuracy=1e-7, **{switch: False})

    found = examine(replace(references.trial_of("heavy_top_fast"), make=wrong))[0]
    assert found.verdict == "differs"
    assert {"certificate", "reference", "theory"} <= {finding.judge for finding in found.failures}


def test_a_planar_model_a_thousandth_heavier_differs():
    made = references.moving("iftomm_A03_andrews")
    system, flat = engines.flatten(made.system)
    (clean,) = engines.by_ladder(made, system, flat.frame)
    object.__setattr__(system.bodies[0], "mass", 1.001 * system.bodies[0].mass)
    object.__setattr__(system.bodies[0], "inertia", 1.001 * system.bodies[0].inertia)
    (heavier,) = engines.by_ladder(made, replaced(system), flat.frame)
    assert clean.verdict == "agrees" and heavier.verdict == "differs" and heavier.error > 100 * clean.error


def replaced(system):
    """The same planar system without what it has computed."""
    return type(system)(system.bodies, system.joints, system.loads, system.gravity)


def test_what_leaves_the_plane_is_named():
    for name, part in (("gyro_gimbal_wheel", "body 'wheel'"), ("sarrus_linkage", "ba"), ("iftomm_A01_pendulum", "bob")):
        found = examine(references.trial_of(name))[0].worst("plane")
        assert found.verdict == "not compared" and part in found.note


def test_engines_and_planar_mechanisms_agree():
    for trial in engines.trials(quick=True):
        found = examine(trial)[0]
        assert found.verdict == "agrees", words.differences([found])
        assert found.worst("plane").verdict == "agrees"


@pytest.mark.slow
def test_bicycles_follow_lagrange_and_a_heavier_one_does_not():
    benchmark = bicycles.trials(quick=True)[0]
    found, made = examine(benchmark)
    assert found.verdict == "agrees" and len(found.of("theory")) == 3 and len(found.of("reference")) == 1
    heavier = replace(bicycles.BENCHMARK, mB=1.001 * bicycles.BENCHMARK.mB)
    wrong = replace(made, source=made.source | {"parameters": heavier})
    assert {finding.verdict for finding in bicycles.lagrange(wrong)} == {"differs"}


def test_a_free_wheel_agrees_and_one_of_other_grip_does_not(monkeypatch):
    found, made = examine(tyres.trials(quick=True)[0])
    assert found.verdict == "agrees" and len(found.of("theory")) == 3
    other = replace(tyres.TYRE, mu=1.001 * tyres.TYRE.mu)
    monkeypatch.setattr(tyres, "WHEEL", replace(tyres.WHEEL, tyre=other))
    assert {finding.verdict for finding in tyres.written_out(made)} == {"differs"}


def test_a_motorcycle_has_its_printed_eigenvalues_and_one_of_other_damping_does_not(monkeypatch):
    found, made = examine(tyres.trials(quick=True)[1])
    assert found.verdict == "agrees" and len(found.of("reference")) == 2
    monkeypatch.setattr(tyres, "fittings", lambda p: fittings(p) | {"steer_damping": 7.2})
    assert {finding.verdict for finding in tyres.printed(made)} == {"differs"}


@pytest.mark.slow
@pytest.mark.parametrize("trial", vehicles.trials(quick=False), ids=lambda trial: trial.name)
def test_vehicles_off_the_ground_agree_with_the_engines(trial):
    """The brake slips, stops the wheel within the run, and holds it; MuJoCo says why it takes no part there."""
    pytest.importorskip("mujoco")
    pytest.importorskip("exudyn")
    found = examined(trial, 5.0)
    assert found.verdict == "agrees" and found.worst("Exudyn").verdict == "agrees", words.differences([found])
    if trial.make is vehicles.braked:
        rate = np.abs(trial.make().solution.rate("hub"))
        assert rate[0] == pytest.approx(9.0) and rate[-1] < 1e-3
        assert "a soft row that creeps" in found.of("MuJoCo")[0].note
    else:
        assert found.worst("MuJoCo").verdict == "agrees"


def test_four_bars_in_a_row_have_the_rows_that_counting_gives():
    (trial,) = families.ladders(quick=True)
    found = examine(trial)[0]
    assert found.verdict == "agrees"
    assert {finding.verdict for finding in found.of("freedoms")} == {"agrees"} and len(found.of("freedoms")) == 2
    assert "rows 155, rank 125" in found.of("freedoms")[0].note


@pytest.mark.slow
def test_forty_four_bars_with_605_rows_of_rank_485():
    found = examine(families.ladders(quick=False)[1])[0]
    assert found.verdict == "agrees" and "rows 605, rank 485" in found.of("freedoms")[0].note


@pytest.mark.slow
@pytest.mark.slow
def test_of_a_demo_of_forgotten_terms_the_whole_equations_are_judged():
    (trial,) = listing.chosen(families.demonstrations(quick=True), ("gallery_wall",))
    record, made = examine(trial)
    assert len(made.source.solutions) > 1 and record.verdict == "agrees"
    assert made.solution is not next(iter(made.source.solutions.values()))


def test_random_mechanisms_move_and_keep_their_seed():
    for seed in range(4):
        first, second = (families.started(seed) for _ in range(2))
        assert np.abs(first.state.v).max() > 0.3 and first.t_end >= families.T_END_MIN
        assert np.array_equal(first.solution.arrays["q"], second.solution.arrays["q"])


@pytest.mark.slow
def test_reactions_of_a_gear_whose_hinges_stand_on_one_body():
    """Its body b bears the torques of both hinges; seed 10 has such a gear, and MuJoCo can express it."""
    found = examined(families.random(10), 2.0)  # s: three halvings of the step take a fraction of it
    moments = [finding for finding in found.of("MuJoCo") if finding.quantity == "reaction moment"]
    # how many runs fit into the time decides whether the error of the peer's step is seen
    assert len(moments) == 1 and moments[0].verdict in ("agrees", "explained")


def test_verdict_of_a_case_is_that_of_its_worst_judge():
    agrees, differs = judged("theory", "x", 1e-9, 1e-8), judged("theory", "x", 1e-7, 1e-8)
    explained, silent = Finding("MuJoCo", "explained", "y", 0.1, 1e-6, "cause"), not_compared("MuJoCo", "no such part")
    own = judged("certificate", "run", 0.0, 1.0)
    for findings, verdict in [
        ((own,), "not compared"), ((own, silent), "not compared"), ((own, agrees, silent), "agrees"),
        ((own, agrees, explained), "explained"), ((own, agrees, explained, differs), "differs"),
    ]:  # fmt: skip
        assert Record("n", "g", "t", findings).verdict == verdict
    for wrong in (np.nan, np.inf, 2e-8):
        assert judged("theory", "x", wrong, 1e-8).verdict == "differs"
    assert judged("theory", "x", np.inf, 1e-8).error is None  # JSON has no word for it
    assert Record("n", "g", "t", (agrees, differs)).worst("theory") is differs


def test_a_judge_that_breaks_and_a_run_that_fails_are_findings():
    def breaks(made):
        raise TypeError("no\nnumber")

    trial = replace(references.trial_of("coriolis_slider"), judges={"theory": breaks})
    (finding,) = examine(trial)[0].failures
    assert finding.judge == "theory" and finding.note == "stopped: TypeError: no number"

    def fails():
        raise ValueError("body 'x': mass -1")

    found, made = examine(replace(trial, make=fails))
    assert made is None and found.verdict == "differs" and "mass -1" in found.failures[0].note
    assert lost(trial, "WorkerDied: ...").verdict == "differs"


def test_an_engine_that_is_missing_is_not_compared(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    found = examined(references.trial_of("coriolis_slider"), 0.05)
    assert found.verdict != "differs" and found.worst("MuJoCo").verdict == "not compared"
    assert "install" in found.worst("MuJoCo").note
    assert "MuJoCo, not compared" in words.table([found])
