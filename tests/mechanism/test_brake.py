"""Brakes: slip with their torque, hold at rest without creep, lose energy, let go; a car and a bicycle on a slope."""

from dataclasses import replace

import numpy as np
import pytest

from bicycle import TYPICAL, Meijaard2007, whipple
from mbsd3d import GROUND, Body, Brake, Input, Planar, Prismatic, Pulse, Revolute, System, accelerations, simulate
from mbsd3d.demos.cars.car import Car, car

SLOPE = 0.3
DOWN = 9.81 / np.hypot(1.0, SLOPE)
STANDS = 1e-8  # m/s, ten times rtol: there is no creep, and what is left of the start rings off by 1e3 in 4 s


def flywheel(torque, omega=5.0, **more):
    """A disc with a brake that is off its centre of mass."""
    numbers = {"stiffness": 2e3, "damping": 20.0} | more
    disc = Body("disc", 2.0, (0.3, 0.4, 0.5), com=(0.1, 0.0, 0.05), omega=(0, 0, omega))
    hinge = Revolute(GROUND, disc, at=(0, 0, 0), axis=(0, 0, 1), name="hinge")
    return System([disc], [hinge], [Brake(hinge, torque=torque, name="brake", **numbers)], gravity=(0, 0, -9.81))


def test_it_slips_with_its_torque_and_then_stands():
    inertia, torque = 0.5 + 2.0 * 0.01, 1.3
    run = simulate(flywheel(torque), 4.0, rtol=1e-10, output=401)
    end = inertia * 5.0 / torque
    slips = run.t < end - 0.05
    expected = 5.0 * run.t - 0.5 * torque / inertia * run.t**2
    # its torque is less for a moment: only the yielding, T/k, starts from zero
    assert run.angle("hinge")[slips] == pytest.approx(expected[slips], abs=1e-8)
    assert abs(run.rate("hinge")[-1]) < STANDS
    assert run.angle("hinge")[-1] == pytest.approx(0.5 * inertia * 25.0 / torque, abs=2.0 * torque / 2e3)
    assert (
        run.certificate.passed and np.abs(run.energy().total - run.energy().work - run.energy().total[0]).max() < 1e-7
    )


def test_it_lets_go_when_it_is_released():
    torque = Pulse(50.0, start=0.0, edge=0.1, duration=1.0)
    loaded = replace(flywheel(torque, omega=0.0), gravity=(0.0, 3.0, 0.0))
    run = simulate(loaded, 1.6, rtol=1e-9, output=161)
    held = (run.t > 0.7) & (run.t < 0.85)
    assert np.abs(run.rate("hinge")[held]).max() < 1e-5  # what is left of the first 0.1 s
    assert run.rate("hinge")[-1] > 0.1


@pytest.mark.parametrize("pull", [0.0, -3.0])
def test_a_released_brake_is_none(pull):
    now = accelerations(flywheel(Input("pull", pull)))
    assert now.alpha("disc")[0] == pytest.approx(0.0, abs=1e-12)


def test_a_slide_is_braked_by_a_force():
    block = Body("block", 3.0, (0.1, 0.1, 0.1), velocity=(2.0, 0.0, 0.0))
    rail = Prismatic(GROUND, block, at=(0, 0, 0), axis=(1, 0, 0), name="rail")
    run = simulate(System([block], [rail], [Brake(rail, torque=6.0, stiffness=1e4, damping=200.0)]), 0.5, output=2)
    assert run.velocity("block")[-1, 0] == pytest.approx(1.0, abs=1e-7)


def test_a_car_stands_on_a_slope_by_its_brakes():
    free = replace(car(Car(), 0.0, 0.0), gravity=(-SLOPE * DOWN, 0.0, -DOWN))
    forces = [replace(one, standing_damping=0.5) if "tyre" in one.name else one for one in free.forces]
    brakes = [
        Brake(free.part(f"{name} hub", "joints"), torque=1600.0, stiffness=2e5, damping=8e3, name=f"{name} brake")
        for name in ("front left", "front right", "rear left", "rear right")
    ]
    parked = simulate(replace(free, forces=[*forces, *brakes]), 12.0, rtol=1e-9, output=13)
    assert np.abs(parked.velocity("chassis")[-1]).max() < STANDS
    assert np.abs(parked.omega("rear left wheel")[-1]).max() < STANDS
    rolls = simulate(free, 2.0, output=2)
    assert rolls.velocity("chassis")[-1, 0] < -3.0


def test_a_bicycle_stands_on_a_slope_by_its_brake():
    """Held upright by a plane; without its brake it rolls away."""
    tyres = TYPICAL | {"standing_damping": 0.5}
    system = whipple(Meijaard2007(), tyres=tyres)
    upright = Planar(GROUND, system.part("frame"), at=(0, 0, 0), normal=(0, 1, 0))
    brake = Brake(system.part("front hub", "joints"), torque=120.0, stiffness=2e4, damping=500.0)
    for forces, least, most in (((brake,), 0.0, STANDS), ((), 1.0, 50.0)):
        on = replace(
            system, joints=[*system.joints, upright], forces=[*system.forces, *forces],
            gravity=(SLOPE * DOWN, 0.0, -DOWN), start=None,
        )  # fmt: skip
        speed = np.abs(simulate(on, 12.0, rtol=1e-9, output=2).velocity("frame")[-1]).max()
        assert least <= speed < most


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"torque": -1.0}, "torque = -1; a brake has none below 0"),
        ({"stiffness": 0.0}, "stiffness: 0.0 is not positive"),
        ({"damping": -2.0}, "damping: -2.0 is not positive"),
        ({"torque": "full"}, "torque is 'full'"),
    ],
)
def test_what_is_no_brake_is_refused(given, text):
    with pytest.raises(ValueError) as error:
        flywheel(**{"torque": 1.0} | given)
    assert text in str(error.value)
