"""Stresses of pins against beams under their pressures, loads in closed form, loads that turn; damage; refusals."""

import numpy as np
import pytest
from helpers.models import direction, random_body
from scipy.integrate import cumulative_trapezoid

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Force,
    Input,
    Pulse,
    Ramp,
    Revolute,
    SNCurve,
    SpeedDriver,
    Spherical,
    Stepper,
    System,
    accelerations,
    pin_stress,
    rotations,
    simulate,
)

STEEL = SNCurve(amplitude=150e6, cycles=2e6, slope=5)
FORK = {"diameter": 0.012, "cheek": 0.008, "link": 0.02, "gap": 0.001}


def held(load=8000.0, **changes):
    """A body whose weight of 8000 N hangs on one pin, and the stresses of it."""
    jib = Body("jib", load / 9.81, (9.0, 8.0, 7.0))
    pin = Revolute(GROUND, jib, at=(0, 0, 0), axis=(3.0, 1.0, 0.0), name="pin")
    return pin_stress(accelerations(System([jib], [pin])), pin, **(FORK | changes))


def test_double_shear_in_closed_form():
    """d = 12 mm, cheeks 8 mm, link 20 mm, gaps 1 mm: the numbers by hand."""
    pin = held()
    known = {
        "load": 8000.0, "shear": 35367765.1315323, "shear_peak": 47157020.17537639, "moment": 40.0,
        "bending": 235785100.876882, "bound": 243612910.6322551, "von_mises": 235785100.876882,
    }  # fmt: skip
    for name, value in known.items():
        assert getattr(pin, name) == pytest.approx([value], rel=1e-12), name
    assert pin.pressures == (pytest.approx([8000 / (0.012 * 0.02)]), pytest.approx([8000 / (2 * 0.012 * 0.008)]))
    stubby = held(link=0.001, cheek=0.001, gap=0.0)
    assert stubby.von_mises == pytest.approx([81678354.87730251], rel=1e-12)  # the axis: sqrt(3) 4/3 tau


@pytest.mark.parametrize("shear", ["double", "single"])
def test_bending_is_that_of_a_beam_under_its_pressures(shear):
    """The pressures integrated twice along the pin, on grids that meet the edges: the trapezoids err by 1e-7."""
    rng = np.random.default_rng(7)
    for _ in range(5):
        a, g, b = rng.uniform(0.003, 0.03, 3)
        F = 8000.0
        n = 4000
        cheek, gap, link = (np.linspace(0, w, n + 1) for w in (a, g, b))
        if shear == "double":
            x = np.concatenate([cheek, a + gap, a + g + link, a + g + b + gap, a + 2 * g + b + cheek])
            parts = [F / 2 / a, 0.0, -F / b, 0.0, F / 2 / a]
            pressure = np.repeat(parts, n + 1)
        else:
            e = g + b / 2  # over the cheek p0 + p1 s, s from its face inwards, in balance with F at -e
            p0, p1 = np.linalg.solve([[a, a**2 / 2], [a**2 / 2, a**3 / 3]], [F, -F * e])
            x = np.concatenate([link, b + gap, b + g + cheek])
            pressure = np.concatenate([np.full(n + 1, -F / b), np.zeros(n + 1), p0 + p1 * cheek])
        force = cumulative_trapezoid(pressure, x, initial=0.0)
        moment = np.abs(cumulative_trapezoid(force, x, initial=0.0))
        assert abs(force[-1]) < 1e-9 * F and moment[-1] < 1e-6 * moment.max()
        pin = held(F, cheek=a, gap=g, link=b, shear=shear)
        assert pin.moment == pytest.approx([moment.max()], rel=1e-6)
        assert pin.shear == pytest.approx(
            [F / ({"double": 2, "single": 1}[shear] * 0.25 * np.pi * 0.012**2)], rel=1e-12
        )


def test_a_lever_of_your_own():
    assert held(lever=0.03).moment == pytest.approx([240.0], rel=1e-12)
    assert held(lever=0.0).bending == pytest.approx([0.0])


def spinning(axis, turns=1.0):
    """A disc whose eccentric mass pulls with 8000 N, about a general axis, by a motor."""
    w, n = np.sqrt(8000.0 / (20.0 * 0.01)), np.asarray(axis) / np.linalg.norm(axis)
    out = np.cross(n, (0.3, 0.4, 0.5))
    out *= 0.01 / np.linalg.norm(out)
    disc = Body("disc", 20.0, (1.0, 1.0, 1.0), com=out, position=(0.1, 0.2, 0.3))
    hinge = Revolute(GROUND, disc, at=(0.1, 0.2, 0.3), axis=n, name="hinge")
    motor = SpeedDriver(GROUND, disc, axis=n, speed=float(w))
    return simulate(System([disc], [hinge, motor], gravity=(0, 0, 0)), turns * 2 * np.pi / w), hinge


def test_a_turning_load_counts_in_the_axes_of_the_holder():
    """|F| never changes; in the part that holds the pin every fibre is bent to and fro, in the other one none is."""
    run, hinge = spinning((1.0, -2.0, 0.5))
    pin = pin_stress(run, hinge, **FORK)
    assert pin.load == pytest.approx(8000.0, rel=1e-8)
    life = pin.life(STEEL)
    assert [pin.cycles(k).range.max() for k in (0, 3, 17)] == pytest.approx([2 * 235785100.87688198] * 3, rel=1e-6)
    # one turn ends half way for all fibres but the one that the load points to at the start; they are 10 degrees apart
    one = 4.798389555613175e-06
    assert one * (1 - 0.02) < life.damage.max() < one * (1 + 1e-5)
    assert life.runs == 1.0 / life.damage.max() and life.hours == pytest.approx(life.runs * run.t[-1] / 3600)
    assert np.abs(pin_stress(run, hinge, holder="b", **FORK).life(STEEL).damage).max() == 0.0


def test_many_turns_are_as_many_cycles():
    """20 turns: 20 cycles of each fibre but for what the first and the last turn leave open: at most one."""
    run, hinge = spinning((1.0, 0.2, 3.0), turns=20.0)
    pin = pin_stress(run, hinge, **FORK)
    one = 1.0 / STEEL(pin.fibres.max())
    assert pin.life(STEEL).damage == pytest.approx(20.0 * one, rel=0.06)
    assert pin.life(STEEL).damage.max() == pytest.approx(20.0 * one, rel=0.02)


def carried():
    """An arm on a driver about a general axis under gravity: hinge, motor, and its load in closed form."""
    rng = np.random.default_rng(2)
    arm, n = random_body(rng, "arm"), direction(rng)
    at = rng.normal(size=3)
    hinge = Revolute(GROUND, arm, at=at, axis=n, name="hinge")
    w = 2.5
    system = System([arm], [hinge, AngleDriver(hinge, Ramp(w))])

    def force(t):
        """Of the arm on the pin across the axis (3,): weight and what bends its centre of mass into a circle."""
        out = rotations.matrix(rotations.rotation(n, w * t)) @ (arm.centre - at)
        out = out - n * (n @ out)
        pull = arm.mass * (np.array([0, 0, -9.81]) + w * w * out)
        return pull - n * (n @ pull)

    return system, hinge, force


def test_stresses_follow_the_load_in_closed_form():
    system, hinge, force = carried()
    pin = pin_stress(simulate(system, 3.0, output=4), hinge, **FORK)
    loads = np.array([force(t) for t in pin.t])
    per_force = 32 * 0.5 * (0.004 + 0.001 + 0.005) / (np.pi * 0.012**3)
    assert pin.bending == pytest.approx(per_force * np.linalg.norm(loads, axis=1), rel=1e-7)  # rtol 1e-8
    around = loads @ loads.T  # the same force seen in the holder's axes, but for where its first axis points
    assert np.abs(pin.force @ pin.force.T - around).max() < 1e-7 * around.max()


def test_turning_points_are_met_however_few_samples_the_run_has():
    """The greatest and least stress of every fibre against a fine search; 4 samples a turn and a half would miss it."""
    system, hinge, force = carried()
    pin = pin_stress(simulate(system, 4.0, output=5), hinge, **FORK)
    fine = np.array([force(t) for t in np.linspace(0.0, 4.0, 40001)])
    seen = np.array([force(t) for t in pin.t])
    axes = np.linalg.lstsq(pin.force, seen, rcond=None)[0]  # (2, 3) across the pin, world: which way its fibres lie
    towards = np.stack([np.cos(pin.angles), np.sin(pin.angles)])
    expected = np.ptp(fine @ axes.T @ towards, axis=0) * pin.bending_per_force
    assert np.ptp(pin.fibres, axis=0) == pytest.approx(expected, rel=1e-6)  # the search misses (w dt)^2 / 8 = 1e-8
    assert [pin.cycles(k).range.max() for k in range(36)] == pytest.approx(np.ptp(pin.fibres, axis=0), rel=1e-12)


def test_the_greatest_load_is_met_between_two_fibres():
    """A load along a line halfway between two fibres peaks where they do, one that turns past its peak does not."""
    bob = Body("bob", 2.0, (0.01, 0.02, 0.03), com=(0.7, 0.1, -0.1))
    axis = np.array([0.3, -0.5, 0.8]) / np.sqrt(0.98)
    pin = Revolute(GROUND, bob, at=(0, 0, 0), axis=axis, name="pin")
    system = System([bob], [pin])
    start = system.assemble(angles={pin: 0.0}, rates={pin: 4.0})
    across = simulate(system, 2.0, state=start, output=20001).reaction(pin).force @ (np.eye(3) - np.outer(axis, axis))
    stress = pin_stress(simulate(system, 2.0, state=start, output=41), pin, **FORK)
    assert stress.load.max() == pytest.approx(np.linalg.norm(across, axis=1).max(), rel=1e-6)  # the search misses 1e-7


def test_a_pulse_between_samples_is_found():
    """A push of 40 ms that no sample of the run shows."""
    jib = Body("jib", 100.0, (9.0, 8.0, 7.0))
    pin = Revolute(GROUND, jib, at=(0, 0, 0), axis=(0, 1, 0), name="pin")
    push = Force(jib, (Pulse(5000.0, 0.33, 0.015, 0.04), 0, 0))
    run = simulate(System([jib], [pin], [push], gravity=(0, 0, 0)), 1.0, output=5)
    assert np.abs(run.reaction(pin).force).max() < 1e-6
    assert pin_stress(run, pin, **FORK).load.max() == pytest.approx(5000.0, rel=1e-6)


def test_runs_of_a_stepper():
    jib = Body("jib", 100.0, (9.0, 8.0, 7.0))
    pin = Revolute(GROUND, jib, at=(0, 0, 0), axis=(0, 1, 0), name="pin")
    stepper = Stepper(System([jib], [pin], [Force(jib, (Input("push"), 0, 0))], gravity=(0, 0, 0)))
    for k, push in enumerate((2000.0, -1000.0, 500.0)):
        stepper.set("push", push)
        stepper.advance(0.1 * (k + 1))
    stress = pin_stress(stepper.solution(), pin, **FORK)
    assert np.ptp(stress.force[:, :], axis=0).max() == pytest.approx(3000.0, rel=1e-9)


def test_what_is_not_determined_is_refused_by_name():
    door = Body("door", 30.0, (2.0, 1.0, 1.0), com=(0.4, 0, 1.0))
    hinges = [
        Revolute(GROUND, door, at=(0, 0, z), axis=(0, 0, 1), name=name) for z, name in ((0.2, "low"), (1.8, "up"))
    ]
    still = accelerations(System([door], hinges))
    with pytest.raises(
        ValueError, match=r"pin_stress: 'low' \(Revolute\): redundant constraints leave its reaction open"
    ):
        pin_stress(still, "low", **FORK)
    # a flat four-bar: the forces in its plane are determined, moments across the axes are not
    crank = Body("crank", 1.0, (0.1, 0.1, 0.1), position=(0, 0, 0.1))
    rod = Body("rod", 2.0, (0.1, 0.1, 0.1), position=(0.25, 0, 0.3))
    lever = Body("lever", 1.5, (0.1, 0.1, 0.1), position=(0.5, 0, 0.2))
    y = (0, 1, 0)
    pins = [
        Revolute(GROUND, crank, at=(0, 0, 0), axis=y), Revolute(crank, rod, at=(0, 0, 0.2), axis=y, name="big end"),
        Revolute(rod, lever, at=(0.5, 0, 0.4), axis=y), Revolute(GROUND, lever, at=(0.5, 0, 0), axis=y),
    ]  # fmt: skip
    stress = pin_stress(accelerations(System([crank, rod, lever], pins)), "big end", **FORK)
    assert np.isnan(stress.tilting) and "tilting moment not determined, not in it" in repr(stress)
    assert np.isfinite(stress.bound).all()


def test_refusals_and_words():
    assert repr(held()).startswith("<pin 'pin': 8000 N at most; bending 235.8 MPa, shear 35.37 MPa, bound 243.6 MPa")
    jib = Body("jib", 100.0, (9.0, 8.0, 7.0))
    ball = Spherical(GROUND, jib, at=(0, 0, 0), name="ball")
    still = accelerations(System([jib], [ball]))
    assert pin_stress(still, ball, axis=(0, 1, 0), **FORK).load == pytest.approx([981.0])
    for change, message in (
        ({"diameter": 0.0}, "pin_stress: diameter"),
        ({"gap": -0.1}, "pin_stress: gap"),
        ({"shear": "triple"}, "pin_stress: shear 'triple' is unknown; give"),
        ({"holder": "c"}, "pin_stress: holder 'c' is unknown; give 'a' or 'b'"),
        ({"axis": None}, r"pin_stress: 'ball' \(Spherical\) has no axis; give axis="),
    ):
        with pytest.raises(ValueError, match=message):
            pin_stress(still, ball, **({"axis": (0, 1, 0)} | FORK | change))
    with pytest.raises(ValueError, match="pin_stress: 3.0 is not a solution"):
        pin_stress(3.0, ball, **FORK)
    with pytest.raises(ValueError, match="'pin' has no fibre 36; give 0 ... 35"):
        held().cycles(36)
