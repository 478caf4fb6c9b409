"""Forces by functions of the user's: none is stepped over unseen, none has a memory, and what fails is named."""

import numba
import numpy as np
import pytest

from mbsd3d import (
    DOP853,
    GROUND,
    RK4,
    Body,
    CustomForce,
    GeneralizedAlpha,
    IntegrationError,
    Kinematic,
    Prismatic,
    RadauIIA,
    Ramp,
    SlideDriver,
    Stepper,
    System,
    load,
    simulate,
)

COM = np.array([0.1, -0.2, 0.3])
ADAPTIVE = pytest.mark.parametrize("method", [DOP853(), RadauIIA(), GeneralizedAlpha()], ids=lambda x: type(x).__name__)
WITH_COMPILER = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="needs the compiler")


def blow(t, bodies, z, parameters, loads, z_dot):
    """A force along x from a time on, for a while."""
    if parameters[0] <= t < parameters[0] + parameters[1]:
        loads[0, 0] = parameters[2]


def gate(t, bodies, z, parameters, loads, z_dot):
    """A force along y near a place on the way along x."""
    if parameters[0] - parameters[1] < bodies[0].r[0].real < parameters[0] + parameters[1]:
        loads[0, 1] = parameters[2]


def cam(t, bodies, z, parameters, loads, z_dot):
    """A force along z within an angle of each turn about z."""
    ahead = np.cos(parameters[0]) * bodies[0].R[0, 0] + np.sin(parameters[0]) * bodies[0].R[1, 0]
    if ahead.real > np.cos(parameters[1]):
        loads[0, 2] = parameters[2]


def counts(t, bodies, z, parameters, loads, z_dot):
    parameters[0] += 1.0
    loads[0, 0] = parameters[0]


def draws(t, bodies, z, parameters, loads, z_dot):
    loads[0, 0] = np.random.random()


def latches(t, bodies, z, parameters, loads, z_dot):
    """Twice the force once the body has been beyond a place."""
    if bodies[0].r[0].real > 0.7:
        parameters[0] = 2.0
    loads[0, 0] = parameters[0]


def stops(t, bodies, z, parameters, loads, z_dot):
    if bodies[0].r[0].real > 0.4:
        raise ValueError("beyond the rail")
    loads[0, 0] = 1.5


def loses_a_state(t, bodies, z, parameters, loads, z_dot):
    z_dot[0] = 1.0
    z_dot[1] = np.sqrt(0.3 - t)


def sled(function, parameters=(), mass=2.0, speed=(0.0, 0.0, 0.0), spin=0.0, **given):
    """A body pushed at its centre of mass, which lies beside its reference point."""
    body = Body("sled", mass, (0.1, 0.12, 0.13), com=COM, velocity=speed, omega=(0, 0, spin))
    force = CustomForce(function, on=body, points=[COM], parameters=parameters, name="own", **given)
    return System([body], forces=[force], gravity=(0, 0, 0))


@ADAPTIVE
@pytest.mark.parametrize(
    ("start", "duration", "force", "mass"),
    [(0.5037, 0.01, 100.0, 2.0), (7.13, 3e-4, -2e3, 0.7), (1e-3, 0.02, 5.0, 31.0)],
)
def test_steps_end_where_a_force_jumps(method, start, duration, force, mass):
    system = sled(blow, (start, duration, force), mass, times=(start + duration, start))
    run = simulate(system, 10.0, method=method, rtol=1e-6)
    gained = force * duration / mass
    assert run.velocity("sled")[-1, 0] == pytest.approx(gained, rel=1e-9)  # constant between jumps: rounding of times
    way = gained * (10.0 - start - 0.5 * duration)
    assert run.position("sled")[-1, 0] == pytest.approx(way, rel=1e-6)
    assert run.certificate.passed and run.certificate.rejected < 10 and run.certificate.steps < 60
    assert run.estimate().error < 1e-6 * abs(way)


def strict(t, bodies, z, parameters, loads, z_dot):
    """As `blow`, at its ends the other way round."""
    if parameters[0] < t <= parameters[0] + parameters[1]:
        loads[0, 0] = parameters[2]


@ADAPTIVE
def test_a_jump_may_belong_to_either_side(method):
    run = simulate(sled(strict, (3.3, 0.07, 4.0), times=(3.3, 3.37)), 5.0, method=method, rtol=1e-6)
    assert run.velocity("sled")[-1, 0] == pytest.approx(0.14, rel=1e-9)
    assert run.certificate.rejected < 10


@ADAPTIVE
def test_steps_are_as_short_as_a_force_asks(method):
    run = simulate(sled(blow, (4.321, 0.013, 70.0), max_step=0.012), 6.0, method=method, rtol=1e-6)
    assert np.diff(run.t).max() <= 0.012 * (1.0 + 1e-12)
    assert run.velocity("sled")[-1, 0] == pytest.approx(0.5 * 0.013 * 70.0, rel=1e-4)
    assert not run.certificate.notes


def test_slices_see_jumps_too():
    stepper = Stepper(sled(blow, (5.0, 0.01, 100.0), times=(5.0, 5.01)))
    stepper.advance(4.0)
    stepper.advance(9.0)
    assert stepper.v[0] == pytest.approx(0.5, rel=1e-9)


STEPPED_OVER = {
    "a blow": (sled(blow, (6.321, 0.01, 100.0)), 10.0),
    "a short blow": (sled(blow, (0.777, 0.001, -300.0), mass=0.4), 1.0),
    "a gate": (sled(gate, (1.734, 0.01, 50.0), speed=(1.0, 0.3, 0.0)), 3.0),
}


@pytest.mark.parametrize(
    "method", [DOP853(), RadauIIA(), GeneralizedAlpha(), RK4(0.05), GeneralizedAlpha(0.05)], ids=str
)
@pytest.mark.parametrize("what", STEPPED_OVER)
def test_an_estimate_finds_what_the_run_stepped_over(what, method):
    system, t_end = STEPPED_OVER[what]
    run = simulate(system, t_end, method=method, rtol=1e-6)
    assert "force 'own' was not looked for between the stages of steps" in str(run.certificate)
    assert "max_step=" in run.certificate.notes[0] and "times=" in run.certificate.notes[0]
    found = run.estimate()
    assert not found.passed and found.error > 0.1


@pytest.mark.parametrize("method", [DOP853(), RadauIIA(), GeneralizedAlpha()], ids=lambda x: type(x).__name__)
def test_what_acts_in_each_turn_is_met_by_the_estimate(method):
    """0.2 rad of each turn: the run may meet it in some turns; the estimate meets it, by a tolerance or a probe."""
    system = sled(cam, (2.0, 0.1, 3.0), spin=4.0)
    run = simulate(system, 9.0, method=method, rtol=1e-4)
    share = 0.2 / (2 * np.pi)
    right = 9.0 * share * 3.0 / 2.0  # within one blow of the last turn
    missed = abs(run.velocity("sled")[-1, 2] - right) > 0.1 * right
    assert not (missed and run.estimate().passed)


def test_an_estimate_says_which_force_it_met():
    run = simulate(STEPPED_OVER["a blow"][0], 10.0)
    assert run.certificate.steps <= 4 and run.certificate.passed  # nothing moves: nobody could know
    found = run.estimate()
    assert "'own' acts there" in found.notes[-1] and "global error" in found.failures[0]
    way = 0.5 * (10.0 - 6.326)
    assert found.error == pytest.approx(way / run.compiled.model.length, rel=1e-3)


def smooth(t, bodies, z, parameters, loads, z_dot):
    loads[0, 0] = -parameters[0] * bodies[0].r[0]


@pytest.mark.parametrize("method", [DOP853(), RK4(0.01), GeneralizedAlpha(0.002)], ids=lambda x: type(x).__name__)
def test_an_estimate_of_a_smooth_force_stays_small(method):
    run = simulate(sled(smooth, (3.0,), speed=(0.4, 0, 0)), 3.0, method=method)
    found, w = run.estimate(), np.sqrt(1.5)
    x = 0.1 * np.cos(w * run.t) + 0.4 / w * np.sin(w * run.t)  # of the centre of mass, at 0.1 at first
    true = np.abs(run.com("sled")[:, 0] - x).max() / run.compiled.model.length
    assert found.passed and found.error == pytest.approx(true, rel=0.3, abs=1e-9)


def test_fixed_steps_longer_than_a_force_allows_are_refused():
    system = sled(blow, (0.5, 0.01, 1.0), max_step=0.01)
    with pytest.raises(
        ValueError, match="force 'own' .CustomForce.: its max_step = 0.01 s is shorter than .* 0.05 s; give a dt"
    ):
        simulate(system, 1.0, method=RK4(0.05))
    assert simulate(system, 1.0, method=RK4(0.01)).certificate.notes == ()


def test_steps_of_a_force_that_take_days_are_refused():
    with pytest.raises(ValueError, match="force 'own' .CustomForce.: max_step = 1e-10 s needs 1e.10 steps"):
        simulate(sled(blow, (0.5, 0.01, 1.0), max_step=1e-10), 1.0)


def test_poses_that_follow_from_drivers_are_not_stepped_over():
    body = Body("sled", 2.0, (0.1, 0.12, 0.13))
    rail = Prismatic(GROUND, body, at=(0, 0, 0), axis=(1, 0, 0))
    force = CustomForce(blow, on=body, parameters=(0.5, 0.01, 100.0), name="own")
    run = simulate(System([body], [rail, SlideDriver(rail, Ramp(0.3))], [force]), 1.0, method=Kinematic(), output=11)
    assert not any("own" in note for note in run.certificate.notes)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"times": 0.5}, "'own'.*times: 0.5 is not a sequence"),
        ({"times": (0.1, np.inf)}, "'own'.*times no. 2: not finite"),
        ({"times": ("soon",)}, "'own'.*times no. 1: expected a number"),
        ({"max_step": 0.0}, "'own'.*max_step: 0.0 is not positive"),
        ({"max_step": np.nan}, "'own'.*max_step: not finite"),
        ({"max_step": None}, "'own'.*max_step: expected a number"),
    ],
)
def test_wrong_times_and_steps_are_named(given, message):
    with pytest.raises(ValueError, match=message):
        sled(blow, (0.5, 0.01, 1.0), **given)


def test_times_and_steps_are_saved(tmp_path):
    run = simulate(sled(blow, (0.5, 0.01, 1.0), times=(0.51, 0.5, 0.5), max_step=0.3), 1.0)
    (force,) = load(run.save(tmp_path / "run")).system.forces
    assert force.times == (0.5, 0.51) and force.max_step == 0.3


@pytest.mark.parametrize("function", [counts, draws])
def test_a_function_with_a_memory_does_not_start(function):
    """Random numbers let a run go on without end: no step is short enough for its error."""
    with pytest.raises(ValueError, match="force 'own' .CustomForce.: the force is not a function of state: .*states="):
        simulate(sled(function, (1.0,)), 1.0)


@pytest.mark.parametrize("method", [DOP853(), RK4(0.01)], ids=lambda x: type(x).__name__)
def test_a_memory_that_shows_later_is_found(method):
    with pytest.raises(IntegrationError, match="not a function of state: .* gives 1.0 and 2.0.*force 'own'") as caught:
        simulate(sled(latches, (1.0,)), 4.0, method=method)
    assert caught.value.solution.t.size > 1


@WITH_COMPILER
@pytest.mark.parametrize("method", [DOP853(), RK4(0.01)], ids=lambda x: type(x).__name__)
def test_an_exception_of_a_function_is_told(method):
    with pytest.raises(
        IntegrationError, match="its function raises ValueError: beyond the rail.*force 'own'"
    ) as caught:
        simulate(sled(stops), 5.0, method=method)
    reached = np.sqrt(2 * (0.4 - COM[0]) / 0.75)
    assert caught.value.time == pytest.approx(reached, abs=0.011)  # a step before


@pytest.mark.filterwarnings("ignore:invalid value encountered in sqrt")
@pytest.mark.parametrize("method", [DOP853(), RK4(0.01)], ids=lambda x: type(x).__name__)
def test_a_rate_of_a_state_that_is_no_number_names_the_force(method):
    system = sled(loses_a_state, states={"level": 0.0, "flow": 1.0})
    with pytest.raises(IntegrationError, match="not finite: the rate of its state 'flow'.*force 'own'"):
        simulate(system, 1.0, method=method)
