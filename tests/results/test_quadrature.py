"""What drivers determine is right at any step, and does not fail by what the quadrature of the steps makes of it."""

import numpy as np
import pytest

from mbsd3d import (
    DOP853,
    GROUND,
    RK4,
    AngleDriver,
    Body,
    Cylindrical,
    Gear,
    GeneralizedAlpha,
    PointOnLine,
    Prismatic,
    RackPinion,
    RadauIIA,
    Ramp,
    Revolute,
    Sine,
    Spherical,
    System,
    Torque,
    Universal,
    rotation,
    simulate,
)
from mbsd3d.rotations import matrix

SKEW = matrix(rotation((0.3, -0.8, 0.5), 1.9))


def cardan(rate, angle):
    """(system, output hinge): two shafts at an angle, on general axes, the first driven."""
    d, x, z = (SKEW @ v for v in ((np.cos(angle), np.sin(angle), 0), (1.0, 0, 0), (0, 0, 1.0)))
    first = Body("in", 1.0, (0.02, 0.03, 0.04), com=(0.01, 0.02, 0.0), position=-0.5 * x)
    second = Body("out", 1.5, (0.03, 0.05, 0.06), com=(0.0, 0.03, 0.01), position=0.5 * d)
    hinge = Revolute(GROUND, first, at=-0.3 * x, axis=x, name="in hinge")
    seat = Cylindrical(GROUND, second, at=0.4 * d, axis=d, name="out hinge")
    cross = Universal(first, second, at=(0, 0, 0), axis_a=z, axis_b=np.cross(d, z), name="cross")
    stay = PointOnLine(GROUND, second, at=0.6 * d, axis=d, name="stay")
    return System([first, second], [hinge, seat, cross, stay, AngleDriver(hinge, Ramp(rate), name="motor")]), seat


def output_angle(angle, turn):
    """tan b = cos(angle) tan a, counted."""
    return np.unwrap(np.arctan2(np.cos(angle) * np.sin(turn), np.cos(turn)))


CASES = [
    (RK4(0.05), 10.0, 0.5), (RK4(0.02), 40.0, 0.5), (RK4(0.05), 20.0, 0.9), (DOP853(dt=0.05), 20.0, 1.0),
    (GeneralizedAlpha(0.01), 10.0, 0.5), (GeneralizedAlpha(0.03), 17.0, 0.35), (RadauIIA(dt=0.02), 40.0, 0.5),
]  # fmt: skip


@pytest.mark.parametrize(("method", "rate", "angle"), CASES, ids=str)
def test_driven_shafts_pass_at_any_step(method, rate, angle):
    """Energy missed 4e-2 of its size, impulses 2e-2, and "an inertial term is missing" was said."""
    system, seat = cardan(rate, angle)
    run = simulate(system, 2.0, method=method)
    turned = output_angle(angle, rate * run.t)
    assert np.abs(np.diff(rate * run.t)).max() < 2.0  # so that the counting here follows
    assert run.angle(seat) == pytest.approx(turned, abs=1e-11)
    assert run.certificate.passed, run.certificate
    assert run.estimate().passed and run.estimate().error < 1e-11


@pytest.mark.parametrize(("method", "rate", "angle"), CASES[:4], ids=str)
@pytest.mark.parametrize("switch", ["gyroscopic", "centripetal"])
def test_a_missing_term_fails_in_driven_shafts(method, rate, angle, switch):
    run = simulate(cardan(rate, angle)[0], 2.0, method=method, **{switch: False})
    assert "Newton-Euler" in {check.name for check in run.certificate.checks if not check.passed}
    check = run.certificate["Newton-Euler"]
    assert check.error > 100 * check.limit


@pytest.mark.parametrize("method", [RK4(0.05), GeneralizedAlpha(0.02), RadauIIA(dt=0.05)], ids=str)
def test_driven_shafts_beside_a_slow_pendulum_pass(method):
    """What is free is right to 1e-4 of a radian; what is driven leaves work and impulse open by as much and more."""
    shafts, seat = cardan(12.0, 0.6)
    bob = Body("bob", 0.8, (0.02, 0.03, 0.01), com=(0.0, 0.1, -0.9), position=(2.0, 0, 0))
    pivot = Revolute(GROUND, bob, at=(2.0, 0, 0), axis=(0.2, 1.0, 0.1), name="pivot")
    system = System([*shafts.bodies, bob], [*shafts.joints, pivot])
    state = system.assemble(angles={pivot: 0.4})
    run = simulate(system, 2.0, state=state, method=method, output=21)
    exact = simulate(system, 2.0, state=state, rtol=1e-11, output=21)
    assert np.abs(run.angle(pivot) - exact.angle(pivot)).max() < 1e-3
    assert run.certificate.passed, run.certificate
    wrong = simulate(system, 2.0, state=state, method=method, gyroscopic=False).certificate
    assert wrong["Newton-Euler"].error > 100 * wrong["Newton-Euler"].limit


GRAVITY = np.array([0.5, -9.81, 0.3])


def crank(r, l, rate, start=0.4):
    """(system, effort at an angle): a driven slider-crank in the plane z = 0 and its motor by virtual work."""
    pin = r * np.array([np.cos(start), np.sin(start), 0])
    end = np.array([pin[0] + np.sqrt(l * l - pin[1] ** 2), 0, 0])
    coms = {"crank": (0.02, 0.01, 0), "rod": (0.03, -0.02, 0)}
    wheel = Body("crank", 1.0, (0.01, 0.01, 0.02), com=coms["crank"])
    rod = Body("rod", 0.7, (0.01, 0.02, 0.02), com=coms["rod"], position=pin)
    block = Body("block", 0.5, (0.01, 0.01, 0.01), position=end)
    main = Revolute(GROUND, wheel, at=(0, 0, 0), axis=(0, 0, 1), name="main")
    joints = [
        main, Spherical(wheel, rod, at=pin), Universal(rod, block, at=end, axis_a=(0, 1, 0), axis_b=(0, 0, 1)),
        Prismatic(GROUND, block, at=end, axis=(1, 0, 0), name="slide"), AngleDriver(main, Ramp(rate), name="motor"),
    ]  # fmt: skip

    def turned(v, by):
        return np.array([np.cos(by) * v[0] - np.sin(by) * v[1], np.sin(by) * v[0] + np.cos(by) * v[1], 0 * by])

    def places(q):  # of the centres of mass at the crank's angle q; of r = l beyond dead centre too
        lean = -q if r == l else -np.arcsin(r * np.sin(q) / l)
        before = -start if r == l else -np.arcsin(r * np.sin(start) / l)
        at = r * np.array([np.cos(q), np.sin(q), 0 * q])
        block_at = np.array([at[0] + l * np.cos(lean), 0 * q, 0 * q])
        return [turned(coms["crank"], q - start), at + turned(coms["rod"], lean - before), block_at], lean

    def energy(q):  # at a steady rate, by a complex step
        step = 1e-30
        (here, _), (moved, leant) = places(q), places(q + 1j * step)
        speeds = [rate * np.imag(x) / step for x in moved]
        spins = [rate, rate * np.imag(leant) / step, 0.0]
        kinetic = sum(
            0.5 * b.mass * v @ v + 0.5 * b.inertia[2, 2] * w * w
            for b, v, w in zip((wheel, rod, block), speeds, spins, strict=True)
        )
        return kinetic - sum(b.mass * GRAVITY @ x for b, x in zip((wheel, rod, block), here, strict=True))

    def effort(q, h=1e-3):  # dE/dq, of sixth order in h
        return sum(c * (energy(q + k * h) - energy(q - k * h)) for k, c in ((1, 0.75), (2, -0.15), (3, 1 / 60))) / h

    return System([wheel, rod, block], joints, gravity=GRAVITY), effort


@pytest.mark.parametrize(("r", "l", "rate"), [(0.2, 0.2, 6.0), (0.31, 0.31, -5.3), (0.2, 0.3, 6.0)])
@pytest.mark.parametrize(
    "method", [GeneralizedAlpha(0.002), GeneralizedAlpha(), GeneralizedAlpha(0.005, rho=0.5)], ids=str
)
def test_a_slider_crank_passes_with_the_right_effort(r, l, rate, method):
    system, effort = crank(r, l, rate)
    run = simulate(system, 1.3, method=method, rtol=1e-7, output=27)
    found, right = run.effort("motor"), np.array([effort(0.4 + rate * t) for t in run.t])
    clear = np.abs(np.cos(0.4 + rate * run.t)) > 0.2 if r == l else np.ones(27, bool)  # not at dead centre
    assert found[clear] == pytest.approx(right[clear], abs=1e-7 * np.abs(right).max())  # differences of sixth order
    assert run.certificate.passed, run.certificate


def rack(radius, torque, signal=None, com=(0.1, 0.02, 0.0)):
    """(system, hinge, slider): a rack on a pinion, pushed by a torque or driven."""
    pinion, bar = Body("pinion", 1.0, (0.01, 0.012, 0.02)), Body("rack", 2.0, (0.01, 0.012, 0.02), com=com)
    hinge = Revolute(GROUND, pinion, at=(0, 0, 0), axis=(0, 0, 1), name="pinion hinge")
    slider = Prismatic(GROUND, bar, at=(0, -radius, 0), axis=(1, 0, 0), name="slider")
    joints = [hinge, slider, RackPinion(hinge, slider, radius=radius)]
    if signal is not None:
        return System([pinion, bar], [*joints, AngleDriver(hinge, signal)]), hinge, slider
    return System([pinion, bar], joints, [Torque(pinion, (0, 0, torque))]), hinge, slider


@pytest.mark.parametrize("method", [DOP853(), RadauIIA(), GeneralizedAlpha(0.01), RK4(1e-3)], ids=str)
@pytest.mark.parametrize(("radius", "torque"), [(0.05, 2.0), (0.21, -7.0)])
def test_an_estimate_of_a_rack_over_many_turns_tells_its_error(method, radius, torque):
    system, hinge, slider = rack(radius, torque)
    run = simulate(system, 2.0, method=method, rtol=1e-7)
    angle = torque / (0.02 + 2.0 * radius**2) * run.t**2 / 2.0
    wrong = np.abs(run.angle(hinge) - angle).max()
    found = run.estimate()
    assert wrong < 1e-2 and found.passed
    assert found.error == pytest.approx(wrong, rel=0.3, abs=2e-6)


@pytest.mark.parametrize("method", [GeneralizedAlpha(0.01), RK4(0.02), RadauIIA(dt=0.008)], ids=str)
def test_a_driven_rack_passes_at_any_step(method):
    """Its motor's work is known to 1e-3 in steps of a third of a radian of the sine."""
    system, hinge, slider = rack(0.07, 0.0, Sine(5.0, 3.0))
    run = simulate(system, 2.0, method=method, rtol=1e-6)
    assert run.slide(slider) == pytest.approx(0.07 * run.angle(hinge), abs=1e-12)
    assert run.certificate.passed and run.estimate().passed


def train(torque):
    """(system, hinges, angular acceleration): two wheels in gear on skew axes, their centres of mass off their axes."""
    axes = [SKEW @ v for v in ((0.0, 0.6, 0.8), (1.0, 0.0, 0.0))]
    bodies = [Body(f"wheel {k}", 1.2 - 0.3 * k, (0.03, 0.03, 0.03), com=0.05 * np.cross(axes[k], (0.3, 0.8, -0.5)),
                   position=(0.9 * k, 0.2, -0.4 * k)) for k in range(2)]  # fmt: skip
    hinges = [
        Revolute(GROUND, b, at=b.position + 0.1 * u, axis=u, name=f"hinge {k}")
        for k, (b, u) in enumerate(zip(bodies, axes, strict=True))
    ]
    gear = Gear(*hinges, ratio=-1.6)
    about = [0.03 + b.mass * (b.com @ b.com - (b.com @ u) ** 2) for b, u in zip(bodies, axes, strict=True)]
    load = Torque(bodies[0], torque * axes[0])
    return System(bodies, [*hinges, gear], [load], (0, 0, 0)), hinges, torque / (about[0] + 1.6**2 * about[1])


@pytest.mark.parametrize(
    ("method", "t_end"),
    [(GeneralizedAlpha(0.0024), 1.5), (GeneralizedAlpha(0.01), 2.0), (RK4(0.004), 1.5), (RadauIIA(dt=0.01), 1.5)],
    ids=str,
)
@pytest.mark.parametrize("torque", [4.0, -2.5])
def test_bearings_of_a_gear_train_may_be_badly_integrated(method, t_end, torque):
    """Its acceleration is constant and any method has it right; the bearings turn with the centres of mass."""
    system, hinges, alpha = train(torque)
    run = simulate(system, t_end, method=method)
    angle = 0.5 * alpha * run.t**2
    assert run.angle(hinges[0]) == pytest.approx(angle, abs=1e-5 * abs(angle[-1]))
    assert run.certificate.passed, run.certificate
    wrong = simulate(system, t_end, method=method, centripetal=False).certificate
    assert {"momentum balance", "Newton-Euler"} <= {check.name for check in wrong.checks if not check.passed}


def test_the_difference_of_the_quadratures_is_the_error_of_the_impulse():
    """Of a body held on a rod that turns evenly: the impulse of its bearing is m v, known in closed form."""
    rate, arm = 3.0, np.array([0.7, 0.2, 0.0])
    body = Body("bob", 1.7, (0.01, 0.02, 0.015), com=arm, orientation=(1, 0, 0, 0))
    hinge = Revolute(GROUND, body, at=(0, 0, 0), axis=(0, 0, 1), name="hinge")
    system = System([body], [hinge, AngleDriver(hinge, Ramp(rate))], gravity=(0, 0, 0))
    for method, most in ((GeneralizedAlpha(0.02), 1.2), (RK4(0.1), 80.0), (RadauIIA(dt=0.1), 1e3)):
        run = simulate(system, 2.0, method=method)
        impulse = run.arrays["z"][:, run.compiled.model.z_impulse :][:, :3]
        v = np.cross((0, 0, rate), run.com("bob"))
        wrong = np.linalg.norm(impulse - impulse[0] - 1.7 * (v - v[0]), axis=1).max()
        assert 0.8 * wrong <= run.record.open_audit[1] <= most * wrong, (
            method
        )  # the second quadrature is of fifth order


@pytest.mark.slow
def test_a_tolerance_that_cannot_be_reached_is_not_asked_for():
    """The tighter run of the estimate, at rtol 1e-11 by a method of order 2 over dead centre, found no step."""
    run = simulate(crank(0.2, 0.2, 6.0)[0], 1.0, method=GeneralizedAlpha(), rtol=1e-8)
    assert run.estimate().passed
