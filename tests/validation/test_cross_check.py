"""`cross_check`: convergence on sequences of known limits, verdicts on real engines, and that mistakes are found."""

import json
import os
import subprocess
import sys
import types
from dataclasses import replace
from functools import partial
from pathlib import Path

import click
import numpy as np
import pytest
from click.testing import CliRunner
from helpers.models import all_joints_mechanism, consistent_state, pendulum

import validation
from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Fixed,
    PointOnLine,
    Prismatic,
    Ramp,
    Revolute,
    Solution,
    SpeedDriver,
    Spherical,
    SpringDamper,
    StateFeedback,
    System,
    measures,
    simulate,
)
from mbsd3d.extend import main
from mbsd3d.results.result import Momentum
from validation import cross_check
from validation.benchmark import planar_pairs as twins
from validation.cases.mechanisms import chain
from validation.crosscheck import check as checking
from validation.crosscheck import formulation, judge, step_refinement
from validation.crosscheck import mbsd3d_runs as own
from validation.crosscheck.mbsd3d_runs import momenta, motion_of, ours_at, rotation_matrices
from validation.crosscheck.result import Compared, CrossCheck, Finding
from validation.twins.base import EngineFailed, EngineMissing

LOOP = twins.four_bar()


def arm():
    """A pendulum with general numbers."""
    return pendulum(np.random.default_rng(5))[0]


def statuses(found):
    """{status of all findings of an engine}."""
    return {finding.status for finding in found.findings}


# -- convergence --


def sequence(order, runs=6, noise=0.0, limit=0.7):
    """x + c h^p + d h^(p+1) at h, h/2, ..., growing along four samples, and noise that doubles with every run."""
    rng, h = np.random.default_rng(2), 0.1 * 0.5 ** np.arange(runs)
    growth = np.array([0.0, 0.3, 0.6, 1.0])[:, None, None]
    rough = noise * 2.0 ** np.arange(runs)[:, None, None, None] * rng.normal(size=(runs, 4, 1, 2))
    shape = np.array([1.0, -0.4])
    return [limit + growth * (shape * x**order + 0.5 * x ** (order + 1)) + r for x, r in zip(h, rough, strict=True)]


@pytest.mark.parametrize("order", [1, 2, 4, 6])
def test_limit_and_order_of_a_sequence(order):
    runs = sequence(order)
    found = step_refinement.limit_of(runs, order)
    away = np.abs(found.values - 0.7).max()
    assert found.order == pytest.approx(order, abs=0.1)  # the next power still counts some per cent
    assert away <= 3.0 * found.error[-1]  # the estimate holds
    assert away < 0.1 * np.abs(runs[-1] - 0.7).max()  # and the limit is better than the finest run
    assert (np.diff(found.error) >= 0.0).all()


def test_an_order_fitted_to_two_gaps_does_not_make_a_limit_certain():
    one = [np.full((2, 1, 1), x) for x in (1.0, 0.5, 0.28)]  # gaps 0.5 and 0.22: of no power, and fitted exactly
    assert step_refinement.limit_of(one, 2.0).error[-1] > 0.05  # with order 2 the limit is 0.1 away


def test_runs_that_only_add_rounding_are_left_out():
    runs = sequence(4, runs=10, noise=1e-9)
    best, last = step_refinement.best_limit(runs, 4.0), step_refinement.limit_of(runs, 4.0)
    assert best.error[-1] < 0.3 * last.error[-1]  # the noise of the last run is 16 times that of run 6
    assert np.abs(best.values - 0.7).max() <= 3.0 * best.error[-1]


def test_runs_that_do_not_converge_have_an_error_as_large_as_they_scatter():
    runs = [np.full((3, 1, 1), x) for x in (1.0, 1.3, 0.9, 1.2)]
    found = step_refinement.limit_of(runs, 2.0)
    assert found.order < step_refinement.ORDER_MIN and found.error[-1] == pytest.approx(0.7)  # 0.3 and 0.4
    with pytest.raises(ValueError, match="three or more"):
        step_refinement.limit_of(runs[:2], 2.0)


# -- quantities --


def test_momenta_and_energies_from_poses_alone_are_those_of_the_solution():
    system = all_joints_mechanism(3, redundant=False)
    solution = simulate(system, 0.05, state=consistent_state(system, np.random.default_rng(3)), output=3)
    motion, rest = motion_of(solution)
    p, L, kinetic, weight = momenta(system, motion)
    energy, momentum = solution.energy(), solution.momentum()
    # two orders of summation over sixteen bodies
    assert np.allclose(p, momentum.linear, rtol=1e-12, atol=1e-11)
    assert np.allclose(L, momentum.angular, rtol=1e-12, atol=1e-11)
    assert np.allclose(kinetic, energy.kinetic, rtol=1e-12, atol=0) and not rest
    assert np.allclose(weight, energy.potential, rtol=1e-12, atol=0)  # no springs here
    R = rotation_matrices(motion.orientation)
    assert np.allclose(R @ R.swapaxes(-1, -2), np.eye(3), rtol=0, atol=1e-14)
    assert np.allclose(R[:, 2], solution.rotation(system.bodies[2]), rtol=0, atol=1e-15)
    assert np.array_equal(rotation_matrices(-motion.orientation), R)


def test_momenta_that_are_compared_are_those_of_the_solution(monkeypatch):
    """Else nothing would tell that they are wrong."""
    monkeypatch.setattr(Solution, "momentum", lambda self: Momentum(*2 * [np.full((self.t.size, 3), 7.0)]))
    system = pendulum()[0]
    found = ours_at(system, system.state(), np.linspace(0.0, 0.05, 3)).found
    assert all((found[name].values == 7.0).all() for name in ("momentum", "angular momentum"))


def test_growth_of_a_pendulum_that_stands_on_its_head():
    """About the upper equilibrium errors grow as cosh(k t), their turn as sinh(k t) / k; k^2 = m g l / I."""
    stick = Body("stick", 1.0, (0.02, 0.02, 0.001), com=(0, 0, 0.4))
    system = System([stick], [Revolute(GROUND, stick, at=(0, 0, 0), axis=(1, 0, 0))])
    rate = np.sqrt(9.81 * 0.4 / (0.02 + 0.16))
    times = np.linspace(0.0, 2.0, 5)
    ours = ours_at(system, system.state(), times)
    speed = np.cosh(rate * times)  # of the angular velocity, which the neighbour starts with
    turn = ours.size.spin / rate * np.sinh(rate * times)  # rotations are compared in radians
    expected = np.maximum(speed, turn)
    assert ours.growth[-1] == pytest.approx(
        expected[-1], rel=0.05
    )  # entries of R have up to 1, other sizes are similar
    assert max(error[-1] for error in ours.error.values()) < 1e-7  # rtol 1e-10, grown by 3000


# -- engines --


def test_a_hinge_agrees_with_both_engines_at_their_orders():
    check = cross_check(arm(), 0.6)
    assert check.passed and check.compared == ("MuJoCo", "Exudyn", "definitions") and not check.failures
    assert set(check.verdict.values()) == {"agrees"}
    tree, quantities = check.of("mujoco"), {x.quantity: x for x in check.of("MuJoCo").findings}
    assert tree.order == 4.0 and quantities["position"].order == pytest.approx(4.0, abs=0.2)
    assert quantities["position"].difference < 1e-9  # limits, not runs: the finest of those is 1e-8 away
    assert quantities["reaction force"].until == 0.6 and {"mass matrix", "acceleration"} <= set(quantities)


def test_a_loop_agrees_at_the_lower_order_of_soft_equalities():
    check = cross_check(LOOP.space(), 0.2)
    assert check.passed, check.table()
    orders = {engine.engine: engine.order for engine in check.engines if engine.order}
    assert orders == {"MuJoCo": 2.0, "Exudyn": 2.0}


def test_redundant_rows_leave_indeterminate_reactions_out_and_say_so():
    check = cross_check(LOOP.space(redundant=True), 0.1, engines=["exudyn", "definitions"])
    assert check.passed and "do not determine" in check.notes[0]
    assert ("Exudyn", "reaction force") not in check.verdict and check.verdict["Exudyn", "position"] == "agrees"


def test_what_is_determined_of_redundant_joints_is_compared():
    """The loads in the plane of a loop of four hinges, which no unique reaction would show."""
    check = cross_check(LOOP.space(redundant=True), 0.1, engines=["mujoco", "definitions"])
    assert check.passed and "do not determine of the reactions" in check.notes[0]
    for engine in ("MuJoCo", "definitions"):
        (force,) = (x for x in check.findings if (x.engine, x.quantity) == (engine, "reaction force"))
        assert force.difference < 1e-5  # MuJoCo's loops keep 1e-7 to 1e-6 of the size of reactions at any step


@pytest.mark.slow
def test_a_chaotic_motion_is_compared_as_long_as_it_can_be():
    """Four hinges at large angles: neighbours part a million times within 6 s, so limits are known only before."""
    check = cross_check(chain(4), 6.0, engines=["mujoco"], budget=2.0)
    assert check.growth > 1e4 and check.passed, check.table()
    ends = {x.until for x in check.findings if x.uncertainty is not None}
    assert len(ends) == 1 and 0.75 <= ends.pop() < 6.0  # an eighth of the time at least


def heavier(factory):
    """The factory with one body's mass up by a tenth of a per cent: a twin of another mechanism."""

    def twin(system, **settings):
        first, *rest = system.bodies
        other = replace(first, mass=1.001 * first.mass)
        joints = [
            replace(j, **{side: other for side in ("a", "b") if getattr(j, side) is first}) for j in system.joints
        ]
        return factory(System([other, *rest], joints, gravity=system.gravity), **settings)

    return twin


@pytest.fixture
def fake(monkeypatch):
    """Put a factory in the place of an engine's module."""

    def put(engine, twin):
        module = types.ModuleType(f"fake_{engine}")
        module.twin = twin
        monkeypatch.setitem(sys.modules, module.__name__, module)
        monkeypatch.setitem(checking.MODULES, engine, module.__name__)

    return put


def test_a_twin_of_another_mechanism_differs_and_no_setting_explains_it(fake):
    from validation.twins import mujoco

    fake("mujoco", heavier(mujoco.twin))
    check = cross_check(LOOP.space(), 0.2, engines=["mujoco"], budget=4.0)
    differs = {x.quantity for x in check.findings if x.status == "differs"}
    assert {"mass matrix", "angular acceleration", "angular velocity", "momentum", "reaction force"} <= differs
    assert not check.passed and "MuJoCo, mass matrix differs: by" in check.failures[0]
    assert not any(x.attributions for x in check.findings if x.status == "differs")


def test_softness_that_does_not_fall_with_the_step_is_proven_by_changing_it(fake):
    """Real MuJoCo, with the time constant of its equalities held fixed: its limit is a softer mechanism."""
    from validation.twins import mujoco

    def stays_soft(system, softness=16.0, **settings):
        made = mujoco.twin(system, softness=softness, **settings)
        run = made.run

        def fixed(t_end, steps, samples):
            made.softness = softness * steps / 256  # solref = softness h is the same at every step
            return run(t_end, steps, samples)

        made.run = fixed
        return made

    fake("mujoco", stays_soft)
    check = cross_check(LOOP.space(), 0.2, engines=["mujoco"], budget=4.0, tolerance=1e-8)
    (position,) = (x for x in check.findings if x.quantity == "position")
    assert position.status == "explained" and position.difference > 3.0 * position.uncertainty
    (proof,) = position.attributions
    assert "softness" in proof.cause and proof.after / proof.before == pytest.approx(0.25, abs=0.05)  # its square


@pytest.mark.slow
def test_a_lower_order_than_expected_is_said_with_the_number_of_the_step(fake):
    from validation.twins import mujoco

    def first_order(system, **settings):
        made = mujoco.twin(system, **settings)
        made.model.opt.integrator = 0  # semi-implicit Euler
        made.order = 4.0
        return made

    fake("mujoco", first_order)
    check = cross_check(arm(), 0.5, engines=["mujoco"], budget=3.0)
    found = {x.quantity: x for x in check.findings}
    assert found["position"].status == "explained" and found["position"].order == pytest.approx(1.0, abs=0.2)
    (proof,) = found["position"].attributions
    assert proof.after / proof.before == pytest.approx(0.5, abs=0.1)  # an error of order one
    assert "order 1.0" in found["position"].verdict


def suspect(difference, uncertainty=1e-9):
    """A finding that differs."""
    return Finding(
        "Exudyn", "position", "differs", difference=difference, uncertainty=uncertainty, tolerance=1e-6, part="arm"
    )


@pytest.mark.parametrize(
    ("stays", "before", "after", "status"),
    [
        (0.0, 1e-4, 5e-7, "explained"),
        (0.0, 1e-2, 5e-5, "differs"),  # a hundredth is left, and that is fifty tolerances
        (0.25, 1e-3, 0.26e-3, "explained"),
        (0.25, 1e-3, 0.4e-3, "differs"),
        (0.25, 0.4, 0.11, "differs"),  # nearly a quarter, but a defect of 1 % would not be seen
    ],
)
def test_what_a_cause_leaves_is_small_by_itself(monkeypatch, stays, before, after, status):
    monkeypatch.setitem(judge.CAUSES, "Exudyn", (judge.Cause("the cause", "tolerance", 1e-13, stays),))
    monkeypatch.setattr(judge, "changed", lambda *arguments: {"position": after})
    (found,) = judge.explained([suspect(before)], None, None, None, None)
    assert found.status == status


def test_what_is_not_a_number_is_the_worst_of_a_definition():
    entries = [(0.2, "arm", 2e-10, 1e-9), (np.nan, "rod", np.nan, 1e-9), (0.5, "arm", 5e-10, 1e-9)]
    found = formulation.finding("acceleration", entries, 1.0)
    assert (found.status, found.part) == ("differs", "rod")


@pytest.mark.parametrize(("known", "samples", "used"), [(5e-5, 33, 1e-4), (5e-3, 0, 1e-3)])
def test_a_tolerance_is_loosened_to_a_thousandth_at_most(monkeypatch, known, samples, used):
    """Of an engine whose limit is known to 5e-5 or 5e-3."""
    monkeypatch.setattr(judge, "horizon", lambda runs, tolerance, own: 33 * (tolerance >= known))
    monkeypatch.setattr(judge, "least_samples", lambda ours: 5)
    assert judge.reach(types.SimpleNamespace(ours=None), 1e-6) == (samples, pytest.approx(used))


def test_our_own_error_is_never_forgiven(monkeypatch):
    """Rows without J_dot v leave the joints: our run depends on its tolerance, which must not loosen the verdict."""
    upper = Body("upper", 1.5, (0.02, 0.03, 0.04), com=(0.05, 0.1, -0.1), position=(0, 0.5, -0.5))
    lower = Body("lower", 0.7, (0.01, 0.02, 0.015), com=(0.05, 0.0, -0.1), position=(0, 0.9, -0.9))
    shoulder = Revolute(GROUND, upper, at=(0, 0, 0), axis=(1, 0.1, 0.2))
    system = System([upper, lower], [shoulder, Revolute(upper, lower, at=(0, 0.7, -0.7), axis=(0.3, 1, 0.2))])
    monkeypatch.setattr(own, "simulate", partial(simulate, gamma=False))
    check = cross_check(system, 0.3, engines=["exudyn"], budget=2.0)
    assert not check.passed, check.table()


def test_what_differs_in_one_way_is_not_made_good_by_another(fake):
    """The first way differs at the start and cannot follow the motion; the others agree."""
    from validation.twins import exudyn

    def two_faced(system, formulation="rigid bodies", **settings):
        if formulation == "rigid bodies":
            return exudyn.twin(system, **settings)
        made = heavier(exudyn.twin)(system, formulation=formulation, **settings)
        made.run = lambda *arguments: (_ for _ in ()).throw(EngineFailed("too stiff"))
        return made

    fake("exudyn", two_faced)
    check = cross_check(arm(), 0.2, engines=["exudyn"], budget=2.0)
    assert not check.passed and "mass matrix differs" in check.failures[0]


def test_the_last_line_says_how_far_an_agreement_goes():
    """Half the time and a tolerance that had to be loosened are no plain agreement."""
    found = Finding("MuJoCo", "position", "agrees", difference=1e-5, uncertainty=1e-5, tolerance=1e-4, until=0.5)
    check = CrossCheck(1.0, 1e-6, (Compared("MuJoCo", (found,)),))
    assert check.table().endswith("agrees with MuJoCo (until 0.5 s of 1 s, within 1e-04)")


# -- what cannot be compared --


def test_an_engine_that_is_missing_is_not_compared_and_the_rest_goes_on(fake):
    def missing(system, **settings):
        raise EngineMissing("mujoco-core is not installed: pip install 'mbsd3d[validation]'")

    fake("mujoco", missing)
    check = cross_check(arm(), 0.2)
    assert check.verdict["MuJoCo", "everything"].startswith("not compared: mujoco-core is not installed: pip")
    assert check.passed and check.compared == ("Exudyn", "definitions")


@pytest.mark.parametrize(("seconds", "looks"), [(0.02, 9), (1.5, 6), (4.0, 2), (40.0, 2)])
def test_definitions_look_at_as_many_states_as_the_budget_allows(monkeypatch, seconds, looks):
    """A clock that a look takes ``seconds`` of, 10 in all; the start and the end are looked at whatever they cost."""
    now, seen, at_state = [0.0], [], formulation.at_state

    def slow(system, solution, k, size):
        now[0] += seconds
        seen.append(k)
        return at_state(system, solution, k, size)

    monkeypatch.setattr(formulation, "at_state", slow)
    monkeypatch.setattr(formulation, "time", types.SimpleNamespace(thread_time=lambda: now[0]))
    check = cross_check(arm(), 0.2, engines=["definitions"], budget=10.0)
    findings, text = check.of("definitions").findings, f"at {looks} of 9 states: 10 s are up"
    assert len(seen) == looks and seen[:2] == [0, 8] and findings[0].until == 0.2
    assert statuses(check.of("definitions")) == {"agrees"}
    assert {x.reason for x in findings} == ({text} if looks < 9 else {""})
    assert check.table().count(text) == (len(findings) if looks < 9 else 0)


@pytest.mark.parametrize("turns", [0.5, -0.5, 1.5, 1.0])
def test_definitions_count_turns_beyond_a_half_however_rounding_falls(turns):
    """At half a turn the angle of the definition is pi or -pi; a wheel without weight has moments and no forces."""
    wheel = Body("wheel", 2.0, ((0.3, 0.02, 0.0), (0.02, 0.4, 0.1), (0.0, 0.1, 0.5)))
    hinge = Revolute(GROUND, wheel, at=(0, 0, 0), axis=(0.3, -0.2, 0.9))
    system = System([wheel], [hinge, AngleDriver(hinge, Ramp(2 * np.pi * turns))], gravity=(0, 0, 0))
    check = cross_check(system, 1.0, engines=["definitions"])
    assert statuses(check.of("definitions")) == {"agrees"}


def knee(length=1.0, shank=0.4):
    """Two bodies on hinges askew, of a size [m], the second of a mass [kg]."""
    tall = Body("thigh", 2.0, length**2 * np.diag([0.05, 0.02, 0.06]), com=length * np.array([0.1, 0.05, -0.3]))
    lower = dict(com=length * np.array([0.02, 0.1, -0.2]), position=length * np.array([0.1, 0.1, -0.6]))
    low = Body("shank", shank, shank * length**2 * np.diag([0.02, 0.03, 0.04]), **lower)
    hip = Revolute(GROUND, tall, at=(0, 0, 0), axis=(0.3, -0.2, 0.9), name="hip")
    return System([tall, low], [hip, Revolute(tall, low, at=low.position, axis=(1, 0.2, 0.3), name="knee")])


@pytest.mark.parametrize("length", [1e-6, 1.0, 1e3])
def test_definitions_see_a_part_in_ten_million_in_any_unit_of_length(monkeypatch, length):
    """A model in micrometres is no better conditioned than one in metres: limits were 840 % of the acceleration."""
    system, solve = knee(length), formulation.solve
    assert statuses(cross_check(system, None, engines=["definitions"]).of("definitions")) == {"agrees"}

    def wrong(*given):
        found = solve(*given)
        return replace(found, acceleration=(1 + 1e-7) * found.acceleration, gaps=found.gaps + 1e-8)

    monkeypatch.setattr(formulation, "solve", wrong)
    found = cross_check(system, None, engines=["definitions"]).of("definitions").findings
    differ = {x.quantity for x in found if x.status == "differs"}
    assert differ == {"joint gaps", "acceleration", "angular acceleration"}


@pytest.mark.parametrize(("mass", "status"), [(0.0, "agrees"), (1e-6, "agrees"), (1e-14, "not compared")])
def test_definitions_say_where_rounding_alone_would_agree_with_anything(mass, status):
    """A cross without mass is held by its joints and judged; a ball of 1e-14 kg on 2 kg turns as rounding says."""
    system, at = knee(shank=0.4), (0.2, 0.3, -0.9)
    light = Body("light", mass, 3 * (0.01 * mass,), com=(0.1, 0, 0), position=at)
    shank = system.bodies[1]
    joint = Spherical(shank, light, at=at) if mass else Fixed(shank, light, at=at)
    found = cross_check(System([*system.bodies, light], [*system.joints, joint]), None, engines=["definitions"])
    assert found.of("definitions").findings[2].status == status, found.table()


def test_what_cannot_move_agrees_by_its_reactions():
    block = Body("block", 1.3, (0.1, 0.2, 0.25), com=(0.3, -0.1, 0.2), position=(0.1, 0.2, 0.3))
    found = cross_check(System([block], [Fixed(GROUND, block, at=(0, 0, 0), name="weld")]), 0.3)
    assert found.passed and set(found.followed) == {"MuJoCo", "Exudyn"}
    assert found.verdict["MuJoCo", "mass matrix"] == "not compared: MuJoCo has no degree of freedom here"
    assert found.verdict["MuJoCo", "reaction moment"] == "agrees"


def test_a_slider_that_moves_at_a_given_speed_agrees_everywhere():
    """MuJoCo let it slide freely, Exudyn refused it."""
    block = Body("block", 1.3, (0.1, 0.2, 0.25), com=(0.3, -0.1, 0.2), position=(0.1, 0.2, 0.3))
    arm = Body("arm", 0.7, (0.05, 0.02, 0.06), com=(0.1, 0.2, -0.1), position=(0.4, 0.1, 0.2))
    rail = Prismatic(GROUND, block, at=(0, 0.2, 0), axis=(1, 0.3, -0.2))
    joints = [rail, SpeedDriver(rail, Ramp(0.7, 0.2)), Revolute(block, arm, at=(0.3, 0, 0), axis=(0.2, 1, 0.4))]
    found = cross_check(System([block, arm], joints), 0.2)
    assert found.passed and set(found.followed) == {"MuJoCo", "Exudyn"}, found.table()


def test_an_engine_named_twice_is_compared_once():
    assert cross_check(arm(), None, engines=["definitions", "definitions"]).compared == ("definitions",)


def test_nothing_compared_does_not_pass():
    """A controller with a filter of its own has no place in the engines nor in the second formulation."""
    system = arm()
    (hinge,) = system.joints
    servo = StateFeedback(
        measures=[measures.angle(hinge)], gains=(3.0,), on=hinge, time_constant=0.05, name="servo", reference=(0.1,)
    )
    check = cross_check(System(system.bodies, [hinge], [servo]), 0.1)
    assert not check.passed and not check.failures and not check.compared
    assert all(x.status == "not compared" and "StateFeedback" in x.reason for x in check.findings), check.table()
    assert check.table().endswith("nothing was compared with another engine")


def test_an_engine_that_fails_on_the_way_keeps_what_was_found_at_the_start(fake):
    from validation.twins import mujoco

    def stops(system, **settings):
        made = mujoco.twin(system, **settings)
        made.run = lambda *arguments: (_ for _ in ()).throw(EngineFailed("NaN at t = 0.1 s"))
        return made

    fake("mujoco", stops)
    check = cross_check(arm(), 0.2, engines=["mujoco"], budget=0.5)
    assert check.verdict["MuJoCo", "acceleration"] == "agrees"
    assert "NaN at t = 0.1 s" in check.verdict["MuJoCo", "motion"]
    assert not check.passed and "no motion was compared; of MuJoCo only the start" in check.table()
    assert cross_check(arm(), None, engines=["mujoco"]).passed  # where no more was asked for


@pytest.mark.parametrize("what", ["velocity", "reaction of 'hinge'"])
def test_numbers_that_are_not_finite_are_not_compared(fake, what):
    from validation.twins import mujoco

    def spoilt(system, **settings):
        made = mujoco.twin(system, **settings)
        run = made.run

        def later(t_end, steps, samples):
            motion = run(t_end, steps, samples)
            values = motion.velocity if what == "velocity" else next(iter(motion.reactions.values())).moment
            values[-1] = np.nan
            return motion

        made.run = later
        return made

    fake("mujoco", spoilt)
    system = arm()
    name = what.replace("hinge", system.name(system.joints[0]))
    check = cross_check(system, 0.2, engines=["mujoco"], budget=0.5)
    assert not check.passed and f"{name} is not finite" in check.verdict["MuJoCo", "motion"]


def test_ctrl_c_in_a_run_keeps_the_start(fake):
    from validation.twins import mujoco

    def stopped(system, **settings):
        made = mujoco.twin(system, **settings)
        made.run = lambda *arguments: (_ for _ in ()).throw(KeyboardInterrupt)
        return made

    fake("mujoco", stopped)
    check = cross_check(arm(), 0.2)
    assert check.interrupted and check.verdict["MuJoCo", "mass matrix"] == "agrees"
    assert check.verdict["MuJoCo", "motion"] == check.verdict["Exudyn", "everything"] == "not compared: interrupted"


def test_ctrl_c_keeps_what_was_found(fake):
    def interrupted(system, **settings):
        raise KeyboardInterrupt

    fake("exudyn", interrupted)
    check = cross_check(arm(), 0.2)
    assert check.interrupted and not check.passed
    assert check.verdict["MuJoCo", "position"] == "agrees" and check.verdict["Exudyn", "everything"].endswith(
        "interrupted"
    )
    assert "interrupted" in check.table()


@pytest.mark.parametrize(
    ("changed", "text"),
    [
        ({"t_end": 0.0}, "does not lie after the start"),
        ({"engines": "mujoco"}, "give a list of mujoco"),
        ({"engines": ["chrono"]}, "'chrono' is unknown"),
        ({"tolerance": 0.1}, "outside 1e-9"),
        ({"budget": 0.0}, "above 0"),
        ({"state": 3}, "is not a State"),
    ],
)
def test_bad_input_is_named(changed, text):
    with pytest.raises(ValueError, match=text):
        cross_check(**{"system": arm(), "t_end": 1.0, **changed})


def test_the_whole_is_plain_data_and_a_figure():
    check = cross_check(arm(), 0.3, engines=["exudyn"])
    plain = json.loads(json.dumps(check.to_dict(), allow_nan=False))
    assert plain["passed"] and plain["engines"][0]["findings"][0]["verdict"] == "agrees"
    assert [axes.get_title() for axes in check.figure().axes] == ["Exudyn"]
    assert CrossCheck(1.0, 1e-6, ()).figure(dark=True).axes[0].get_title() == "no engine ran"
    assert validation.cross_check is checking.cross_check


# -- mutations --


def mutated(*arguments):
    """Outcomes of tests/helpers/mutations.py: kernel, mistake, {engine: quantities}."""
    paths = os.pathsep.join(sys.path)
    command = [sys.executable, "-m", "helpers.mutations", *arguments]
    done = subprocess.run(command, env={**os.environ, "PYTHONPATH": paths}, capture_output=True, text=True, check=True)
    return [json.loads(line) for line in done.stdout.splitlines()]


READ_AT_THE_START = {"row_speed"}  # a start whose J v is not what it should be is refused by our own run
NEVER_AT_REST = {"turn_rate"}
"""A start that a wrong J of a speed driver does not allow is refused by our own run, which names the joint."""


class Own(PointOnLine):
    """A joint of the user's, which nobody else has."""


def test_a_joint_of_ones_own_is_not_compared_and_named():
    load = Body("load", 3.0, (0.1, 0.2, 0.15), com=(0.1, 0.02, 0.03), position=(0.3, 0.1, -0.4), omega=(0.2, 0.1, 0.4))
    check = cross_check(System([load], [Own(GROUND, load, at=(0.3, 0, 0), axis=(1, 0.2, 0.1), name="rail")]), 0.1)
    assert not check.passed and not check.compared
    assert all(said.startswith("not compared: joint 'rail' (Own)") for said in check.verdict.values())


@pytest.mark.parametrize("kernels", [("roll",), pytest.param((), marks=pytest.mark.slow)], ids=len)
def test_a_mistake_in_any_row_kernel_is_found(kernels):
    outcomes = mutated("mujoco", "exudyn", "definitions", *kernels)
    assert len({kernel for kernel, *_ in outcomes}) == (len(kernels) or 14)
    for kernel, mistake, found in outcomes:
        if mistake == "none":
            assert not any(found.values()), (kernel, found)
        elif "error" in found:
            assert kernel in READ_AT_THE_START or (kernel in NEVER_AT_REST and "SpeedDriver" in found["error"])
        else:
            assert found["definitions"], (kernel, mistake)
            assert found["MuJoCo"] or found["Exudyn"], (kernel, mistake)


# -- command line --


ARM = """
from mbsd3d import GROUND, Body, Revolute, System

def build():
    bob = Body("bob", 1.0, (0.1, 0.11, 0.02), com=(0.1, 0.2, 0.05), position=(0, 0.6, -0.8))
    return System([bob], [Revolute(GROUND, bob, at=(0, 0, 0), axis=(1, 0.2, 0), name="hinge")])
"""


@pytest.fixture
def model(tmp_path, monkeypatch):
    """A folder with arm.py."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.py").write_text(ARM)
    return tmp_path


def run(*arguments):
    """Result of the command line."""
    return CliRunner().invoke(main, ["validate", *arguments])


def test_validate_prints_a_table_and_writes_page_and_data(model):
    done = run("arm.py", "--t-end", "0.3", "--json", "new/arm.json", "--html", "new/arm.html")
    assert done.exit_code == 0, done.output
    assert "agrees with MuJoCo, Exudyn" in done.output and "new/arm.html" in done.output
    plain, page = json.loads(Path("new/arm.json").read_text()), Path("new/arm.html").read_text()
    assert plain["model"] == "arm.py" and plain["passed"]
    assert (
        "<svg" in page and "✓" in page and "http://" not in page.replace("http://www.w3.org", "") and "src=" not in page
    )


def test_validate_ends_with_1_where_something_differs(model, fake):
    from validation.twins import exudyn

    fake("exudyn", heavier(exudyn.twin))
    done = run("arm.py", "--t-end", "0.2", "--engine", "exudyn", "--html", "arm.html", "--budget", "2")
    assert done.exit_code == 1 and "mbsd3d: Exudyn, mass matrix differs: by" in done.output
    assert '<tr class="fail">' in Path("arm.html").read_text()


@pytest.mark.parametrize(
    ("arguments", "code", "text"),
    [
        (["none.py"], 2, "No such file"),
        (["arm.py", "--t-end", "-1"], 2, "does not lie after the start"),
        (["arm.py", "--t-end", "0"], 2, "t_end = 0 s does not lie after the start"),
        (["arm.py", "--budget", "0"], 2, "budget 0 s; give seconds above 0"),
        (["arm.py", "--tolerance", "0"], 2, "tolerance 0 is outside"),
        (["arm.py", "--set", "length=2"], 2, "no such parameter"),
        (["arm.py", "--engine", "chrono"], 2, "chrono"),
        (["arm.py", "--tolerance", "1"], 2, "outside 1e-9"),
        (["arm.py", "--json", "/proc/none/x.json"], 2, "--json '/proc/none' cannot be written"),
        (["arm.py", "--html", "."], 2, "--html '.' is a folder"),
        (["arm.py", "--t-end", "0.1", "--engine", "definitions"], 0, "agrees with the definitions of the joints ("),
    ],
)
def test_exit_codes(model, arguments, code, text):
    done = run(*arguments)
    assert done.exit_code == code and text in done.output, done.output
    assert not isinstance(done.exception, Exception) or isinstance(done.exception, click.exceptions.Exit | SystemExit)


def test_a_mechanism_without_mass_is_refused_in_words():
    ghost = Body("ghost", 0.0, (0, 0, 0), position=(0.5, 0.1, 0.2))
    hinge = Revolute(GROUND, ghost, at=(0, 0, 0), axis=(0, 1, 0), name="hinge")
    with pytest.raises(ValueError, match="cross_check: no body has a mass.*give masses"):
        cross_check(System([ghost], [hinge, AngleDriver(hinge, Ramp(2.0))]), 1.0)


# -- a spring of no length, whose direction other engines lose at its anchor --


@pytest.mark.parametrize("damping", [0.0, 0.8])
def test_a_spring_through_its_own_anchor_is_that_of_other_engines(damping):
    """With a damper MuJoCo is refused: its line has the direction of x there."""
    pose = {"com": (0.11, -0.07, 0.23), "position": (0.4, -1.3, 0.8)}
    body = Body("bob", 1.7, (0.3, 0.25, 0.2), **pose, velocity=(0.6, -1.1, 0.4), omega=(2, -3, 1))
    at = body.position + np.array([0.2, 0.1, -0.3])
    spring = SpringDamper(GROUND, body, at_a=at, at_b=at, stiffness=37.0, damping=damping, length=0)
    found = {one.engine: statuses(one) for one in cross_check(System([body], [], [spring]), 0.2).engines}
    assert found.pop("MuJoCo") == ({"not compared"} if damping else {"agrees"})
    assert found.pop("definitions") == {"agrees"}
    assert found.pop("Exudyn") <= {"agrees", "explained"}
