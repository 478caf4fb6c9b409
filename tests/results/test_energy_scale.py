"""What the energy audit divides by: a velocity v that errs by dv makes m v dv, seen from wherever one looks."""

import numpy as np
import pytest
from helpers.models import dropped_wheel

from mbsd3d import (
    DOP853,
    GROUND,
    Body,
    Bushing,
    Force,
    GeneralizedAlpha,
    RadauIIA,
    Revolute,
    Sine,
    SpringDamper,
    System,
    TorsionSpring,
    simulate,
)

METHODS = [DOP853(), RadauIIA(), GeneralizedAlpha()]


def pair(speed):
    """Two bodies on a spring, seen by somebody who flies past them."""
    past = speed * np.array([0.6, -0.64, 0.48])
    one = Body("one", 2.0, (0.1, 0.2, 0.25), com=(0.1, 0.0, 0.05), velocity=past + [0.1, 0.2, 0.0], omega=(1, 2, 0.3))
    two = Body("two", 1.0, (0.1, 0.12, 0.15), com=(0.0, 0.1, 0.05), position=(1.0, 0.2, 0.1),
               velocity=past + [0.0, -0.2, 0.1], omega=(0.0, -1.0, 0.5))  # fmt: skip
    spring = SpringDamper(one, two, at_a=(0.2, 0.1, 0), at_b=(0.8, 0.1, 0.2), stiffness=50.0, damping=0.3, length=0.5)
    return System([one, two], forces=[spring], gravity=(0, 0, 0))


@pytest.mark.parametrize("method", METHODS, ids=lambda method: type(method).__name__)
def test_the_verdict_is_the_same_from_a_train(method):
    runs = [simulate(pair(speed), 3.0, method=method, rtol=1e-6, output=31) for speed in (0.0, 1e2, 1e4)]
    still, slow, fast = (run.certificate["energy balance"].error for run in runs)
    assert all(run.certificate.passed for run in runs)
    assert fast < 3.0 * slow and fast < 3.0 * still  # the speed is a hundred times that


@pytest.mark.parametrize("method", METHODS[1:], ids=lambda method: type(method).__name__)
def test_a_body_that_falls_without_turning_has_the_energy_of_its_fall(method):
    """One body has no speed relative to the mean of all; what it does to the road is judged by what it brings along."""
    rng = np.random.default_rng(3)
    for _ in range(5):
        h, system = dropped_wheel(rng)
        run, exact = (simulate(system, 1.2, method=how, rtol=tight, output=31) for how, tight in (
            (method, 1e-6), (DOP853(), 1e-10)))  # fmt: skip
        assert np.abs(run.position("wheel") - exact.position("wheel")).max() < 1e-3 * h  # it is right, and passes
        assert run.certificate.passed, f"{system.name}\n{run.certificate}"


@pytest.mark.parametrize("method", METHODS, ids=lambda method: type(method).__name__)
def test_a_machine_that_has_come_to_rest_is_judged_by_how_it_moved(method):
    """Start and sample are at rest; what the method damped of the swing between is not a large share of nothing."""
    bob = Body("bob", 2.0, (0.1, 0.2, 0.25), com=(0.1, 0.05, -0.6))
    hinge = Revolute(GROUND, bob, at=(0, 0, 0), axis=(0.1, 1.0, 0.2), name="hinge")
    system = System([bob], [hinge], forces=[TorsionSpring(hinge, stiffness=0.0, damping=1.0)])
    state = system.assemble(angles={hinge: 2.5})
    late, whole = (simulate(system, 40.0, state=state, method=method, rtol=1e-6, output=x) for x in ([40.0], None))
    assert np.abs(late.arrays["v"]).max() < 1e-4 and late.certificate.passed, late.certificate
    first, second = (run.certificate["energy balance"].error for run in (late, whole))
    assert first <= second * (1.0 + 1e-9)


@pytest.mark.parametrize("method", [RadauIIA(dt=0.005), GeneralizedAlpha(0.005), RadauIIA()], ids=str)
def test_a_stiff_bushing_that_is_pushed_holds_more_energy_than_the_motion(method):
    """A slow push on a seat of 5e6 N/m: its deflection is F/k, so that it stores thousands of times m v^2."""
    seat = Body("seat", 1.5, (0.02, 0.03, 0.04), com=(0.05, -0.02, 0.1), position=(0.2, 0.1, -0.3))
    at, sizes, rates = seat.position + seat.com, np.array([700.0, 150.0, -300.0]), np.array([1.1, 0.4, 0.7])
    mount = Bushing(GROUND, seat, at=at, stiffness=5e6, turning_stiffness=4e5, damping=900.0, turning_damping=60.0)
    push = Force(seat, tuple(map(Sine, sizes, rates)), at, name="push")
    run = simulate(System([seat], forces=[mount, push], gravity=(0, 0, 0)), 2.0, method=method, output=41)
    force = sizes * np.sin(2 * np.pi * rates * run.t[:, None])
    late = run.t > 0.5  # the start has rung out; inertia and damping add 1e-5 and 1e-3 of the force
    assert (run.com(seat) - at)[late] == pytest.approx(force[late] / 5e6, abs=2e-3 * 700.0 / 5e6)
    assert run.certificate.passed, run.certificate
