"""The twin in Exudyn: what it refuses and how, engine failures, versions; quiet, repeatable, nothing written."""

import os
import signal
import threading
from types import SimpleNamespace
from unittest.mock import Mock

import numpy as np
import pytest
from helpers.forces import EXAMPLES as FORCES
from helpers.models import public_classes, random_body, revolute_chain

from mbsd3d import (
    GROUND,
    AngleDriver,
    AssemblyError,
    Body,
    Brake,
    Distance,
    Fixed,
    Gear,
    Joint,
    Polynomial,
    Revolute,
    SpeedDriver,
    Spherical,
    State,
    System,
    Table,
    Torque,
    TorsionSpring,
    simulate,
)
from mbsd3d.extend import ForceElement
from validation import cases
from validation.twins.base import EngineFailed, EngineMissing, NotExpressible

pytest.importorskip("exudyn", reason="the engine Exudyn is not installed")

from helpers.exudyn_models import distances, tree  # noqa: E402

from validation.twins.exudyn import EXPRESSES, EXPRESSES_FORCES, FORMULATIONS, twin  # noqa: E402
from validation.twins.exudyn.joints import REFUSED as REFUSED_FORCES  # noqa: E402
from validation.twins.exudyn.solvers import Scheme, check_version  # noqa: E402

SWALLOWED = "Error in Python USER FUNCTION: SystemError: <built-in method> returned a result with an exception set"


def test_tables_hold_public_classes_and_say_how():
    assert set(EXPRESSES) <= public_classes(Joint)
    assert set(EXPRESSES_FORCES) | set(REFUSED_FORCES) <= public_classes(ForceElement)
    assert not set(EXPRESSES_FORCES) & set(REFUSED_FORCES)


class Weld(Fixed):
    """A joint of a user's own."""


def test_refused_joint():
    """A class that no table knows is refused by name."""
    body = random_body(np.random.default_rng(1))
    with pytest.raises(NotExpressible, match="joint 'seam' .Weld.: Exudyn has no element for it"):
        twin(System([body], [Weld(GROUND, body, at=(0.1, 0.2, 0.3), name="seam")]))


UNKNOWN = [name for name in FORCES if name.split()[0] not in {cls.__name__ for cls in EXPRESSES_FORCES}]


@pytest.mark.parametrize("name", [name for name in UNKNOWN if name != "CustomForce"])  # which takes 9 s to compile
def test_refused_forces(name):
    rng = np.random.default_rng(3)
    one, two = random_body(rng, "one"), random_body(rng, "two")
    joints, force = FORCES[name](rng, one, two)
    reason = REFUSED_FORCES.get(type(force), "Exudyn has no element for it")
    with pytest.raises(NotExpressible, match=f"force '{type(force).__name__} 1' .{type(force).__name__}.: {reason}"):
        twin(System([one, two], joints, [force]))


def test_refused_variants():
    """Parts that it has, in a way that it has not; what a tree has not; solvers that take no constraints."""
    rng = np.random.default_rng(6)
    a, b = random_body(rng, "a"), random_body(rng, "b")
    hinge = Revolute(GROUND, a, at=a.position, axis=(1, 2, 2))
    crooked = Revolute(GROUND, a, at=a.position, axis=(1, 2, 2), axis_b=(1, 2, 2.001))
    sprung = System([a], [crooked], [TorsionSpring(crooked, stiffness=1.0)])
    lining = {"torque": 1.0, "stiffness": 9.0, "damping": 1.0}
    braked = System([a], [crooked], [Brake(crooked, **lining)])
    for parts, settings, text in (
        (sprung, {"state": sprung.assemble()}, "force 'TorsionSpring 1' .*axes on both sides differ"),
        (braked, {"state": braked.assemble()}, "force 'Brake 1' .*axes on both sides differ"),
        (System([a], [hinge], [Brake(hinge, **lining)]), {"formulation": "kinematic tree"}, "take .*'rigid bodies'"),
        (System([a], [SpeedDriver(GROUND, a, direction=(1, 2, 2), speed=0.3)]), {}, "SpeedDriver 1' .*no slider leads"),
        (System([a], [hinge]), {"solver": "rk44"}, "takes no constraints"),
        (System([a, b], [hinge]), {"formulation": "kinematic tree"}, "body 'b': is free"),
        (System([a], [Spherical(GROUND, a, at=(0, 0, 0))]), {"formulation": "kinematic tree"}, "has only Revolute"),
        (System([a, b], [Revolute(a, b, at=(0, 0, 0), axis=(1, 2, 3))]), {"formulation": "kinematic tree"}, "hang on"),
        (cases.load("door_two_hinges").system, {"formulation": "kinematic tree"}, "closes a loop"),
    ):
        with pytest.raises(NotExpressible, match=text):
            twin(parts, **settings)


def test_bad_settings():
    system = revolute_chain(1)
    for settings, text in (
        ({"solver": "euler"}, "solver 'euler' is unknown; give one of 'generalized-alpha'"),
        ({"linear": "lu"}, "linear 'lu' is unknown"),
        ({"rotation": "angles"}, "rotation 'angles' is unknown"),
        ({"formulation": "minimal"}, "formulation 'minimal' is unknown"),
        ({"spectral_radius": 1.5}, "spectral_radius 1.5 is not a share"),
        ({"tolerance": 0.0}, "tolerance 0.0 is not positive"),
        ({"solver": "rk44", "adaptive": True}, "adaptive=True goes with 'dopri5'"),
    ):
        with pytest.raises(ValueError, match=text):
            twin(system, **settings)
    for steps, samples in ((10, 4), (0, 1), (8, 0)):
        with pytest.raises(ValueError, match="samples do not divide"):
            twin(system).run(1.0, steps, samples)
    with pytest.raises(ValueError, match="does not lie after the start"):
        twin(system).run(0.0, 8, 1)
    with pytest.raises(ValueError, match="Exudyn: state 'start' is not a State"):
        twin(system, state="start")
    with pytest.raises(ValueError, match="2 bodies, the system has 1"):
        twin(system, state=revolute_chain(2).state())


def test_runs_out_of_range():
    """Counts that are not whole numbers and ends that are no time, in either formulation."""
    for formulation in FORMULATIONS:
        made = twin(revolute_chain(1), formulation=formulation)
        for steps, samples in ((64.0, 4), (64, 4.0), (True, 1), (64, None)):
            with pytest.raises(ValueError, match="Exudyn: .* do not divide .*give a whole number >= 1"):
                made.run(1.0, steps, samples)
        for t_end in (np.inf, np.nan, -1.0, None):
            with pytest.raises(ValueError, match=f"t_end = {t_end} s does not lie after the start at 0 s"):
                made.run(t_end, 64, 4)


def test_what_is_no_system():
    for given in (None, [], revolute_chain):
        with pytest.raises(ValueError, match="Exudyn: .* is not a System; give System"):
            twin(given)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_states_that_the_joints_do_not_allow(formulation):
    """Positions and velocities off a joint, quaternions off the sphere: refused as `simulate` refuses them."""
    system, state = tree()
    twin(system, state=state, formulation=formulation)
    aside, fast, long = np.zeros(28), np.zeros(24), np.ones(28)
    aside[0], fast[2], long[10:14] = 1e-6, 1e-4, 1 + 1e-5
    for q, v, text in (
        (state.q + aside, state.v, "state: joint '.* is off by 1e-06 m or rad; start from"),
        (state.q, state.v + fast, "state: joint '.* is off by 0.0001 m/s or rad/s; start from"),
        (long * state.q, state.v, "the quaternion of 'two' has norm 1.00001 instead of 1; divide it by that"),
    ):
        off = State(state.t, q, v, state.z, state.coordinates)
        with pytest.raises(ValueError, match=text):
            twin(system, state=off, formulation=formulation)
        with pytest.raises((ValueError, AssemblyError)):
            simulate(system, state.t + 0.1, state=off)


def test_drivers_and_gears_must_be_met_at_the_start():
    rng = np.random.default_rng(8)
    a, b = random_body(rng, "a"), random_body(rng, "b")
    hinges = [Revolute(GROUND, x, at=x.position + 0.3, axis=(1, 2, 2), name=f"hinge {x.name}") for x in (a, b)]
    driven = System([a], [hinges[0], AngleDriver(hinges[0], Polynomial((0.1, 0.0, 3.0)), name="motor")])
    geared = System([a, b], [*hinges, Gear(*hinges, ratio=-2.0, name="gear")])
    later, turned = driven.assemble(t=0.2), geared.assemble(angles={"hinge a": 0.2})
    alone = System([a, b], hinges).assemble(angles={"hinge a": 0.2})
    twin(driven, state=later), twin(geared, state=turned)
    for system, state, text in (
        (driven, State(0.0, later.q, later.v), "joint 'motor' .AngleDriver. is off by 0.12 m or rad"),
        (driven, State(0.2, later.q, 0 * later.v), "joint 'motor' .AngleDriver. is off by 1.2 m/s or rad/s"),
        (geared, State(0.0, alone.q, 0 * alone.v), "joint 'gear' .Gear. is off by 0.4 m or rad"),
    ):
        with pytest.raises(ValueError, match=text):
            twin(system, state=state)


def test_tables():
    """A driver and a force by tables that begin and end with the run; a longer run is refused as mbsd3d does."""
    rng = np.random.default_rng(7)
    times = np.linspace(0.0, 0.4, 9)
    body = random_body(rng, "b")
    hinge = Revolute(GROUND, body, at=body.position + 0.3, axis=(1, 2, 2))
    driver = AngleDriver(hinge, Table(times, np.sin(3 * times)))
    system = System([body], [hinge, driver], [Torque(body, (0.3, Table(times, np.cos(5 * times)), 0.1))])
    made, truth = twin(system), simulate(system, 0.4, rtol=1e-11, output=5)
    assert np.abs(made.accelerations()[0, 3:] - truth.alpha(body)[0]).max() < 1e-9
    assert (distances(made.run(0.4, 512, 4), truth) < 1e-4).all()
    with pytest.raises(ValueError, match="the table covers 0 s to 0.4 s and is asked for 0 s to 0.5 s"):
        made.run(0.5, 8, 1)


def test_own_steps_of_dopri5():
    """Adaptive steps end where asked, within a tolerance; samples in between are refused."""
    system, state = tree()
    made = twin(system, state=state, formulation="kinematic tree", solver="dopri5", adaptive=True, tolerance=1e-10)
    end = made.run(state.t + 0.3, 4, 1)
    truth = simulate(system, state.t + 0.3, state=state, rtol=1e-12, output=2)
    assert (distances(end, truth) < 1e-8).all()  # 100 local errors of 1e-10
    with pytest.raises(ValueError, match="give samples=1"):
        made.run(state.t + 0.3, 4, 2)


def test_failures_say_when_and_why():
    """A step far too long: Newton's failure ends in an error of one line."""
    case = cases.load("heavy_top_fast")
    with pytest.raises(EngineFailed, match=r"Exudyn stopped at t = [\d.]+ s: ") as raised:
        twin(case.system).run(2.0, 8, 1)
    assert "\n" not in str(raised.value) and ".py" not in str(raised.value)
    with pytest.raises(EngineFailed, match="not finite from t"):
        twin(cases.load("free_dzhanibekov").system, solver="rk44").run(1e6, 16, 16)


def test_motion_without_mass():
    """A point mass that nothing keeps from turning: singular equations are said, not solved."""
    point = Body("point", 1.0, (0, 0, 0), position=(0.3, 0.1, -1.0), velocity=(0, 0, 0), omega=(0, 0, 0))
    rod = Distance(GROUND, point, at_a=(0, 0, 0), at_b=(0.3, 0.1, -1.0))
    state = State(0.0, np.array([0.3, 0.1, -1.0, 1, 0, 0, 0]), np.zeros(6))
    with pytest.raises(EngineFailed, match="no solution at the start: Singular"):
        twin(System([point], [rod]), state=state).accelerations()


def test_versions():
    check_version("1.13.6"), check_version("1.14.0.dev1"), check_version("2.0")
    check_version("1.14rc1"), check_version("2.0.0rc1.post2")
    with pytest.raises(EngineMissing, match="Exudyn 1.12.99 is older than 1.13.6; pip install"):
        check_version("1.12.99")
    with pytest.raises(EngineMissing, match="Exudyn 1.13rc1 is older than 1.13.6; pip install"):
        check_version("1.13rc1")


def test_quiet_and_repeatable(capfd, tmp_path, monkeypatch):
    """Nothing on the terminal, no files, the same bits again."""
    monkeypatch.chdir(tmp_path)
    system, state = tree()
    made = twin(system, state=state)
    first, second = (made.run(state.t + 0.1, 16, 2) for _ in range(2))
    made.accelerations(), made.degrees_of_freedom()
    with pytest.raises(EngineFailed):
        twin(cases.load("door_two_hinges").system, solver="index2", linear="dense").run(0.5, 4, 1)
    assert (first.position == second.position).all() and (first.omega == second.omega).all()
    assert tuple(capfd.readouterr()) == ("", "") and not list(tmp_path.iterdir())


def test_interrupt():
    """Ctrl-C ends a long run as what it is, between two records; the twin can run again."""
    made = twin(cases.load("iftomm_A04_bricard").system)
    with pytest.raises(KeyboardInterrupt):
        threading.Timer(0.2, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
        made.run(10.0, 128 * 1024, 1)
    assert made.mbs.systemData.GetTime() < 5.0  # one record of 0.08 s, two on a fast machine
    assert made.run(10.0 / 128, 1024, 1).t[-1] == 10.0 / 128


@pytest.mark.parametrize("kind", [SystemError, RuntimeError])
def test_an_interrupt_that_exudyn_does_not_hand_on(monkeypatch, kind):
    """Seen in 12 of 100 runs of a chain of 30 bodies: Exudyn returns, and Python finds the interrupt in its result."""
    solver = SimpleNamespace(InitializeSolver=lambda *_: True, SolveSteps=Mock(side_effect=kind(SWALLOWED)))
    monkeypatch.setattr(Scheme, "open", lambda *_: solver)
    with pytest.raises(KeyboardInterrupt):
        twin(cases.load("iftomm_A04_bricard").system).run(0.1, 16, 1)
