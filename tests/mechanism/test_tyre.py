"""Tyres: the brush model in steady slip, the friction circle, standing, dropping, shimmy, and what is read of them."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.models import Evaluation
from scipy.optimize import brentq

from mbsd3d import (
    GROUND,
    Body,
    JointFriction,
    Prismatic,
    Revolute,
    SpeedDriver,
    System,
    Table,
    Tyre,
    accelerations,
    linearize,
    load,
    measures,
    simulate,
)
from mbsd3d.dynamics.applied_forces import loads
from mbsd3d.kernels.kinematics import kinematics

RADIUS, HUB, K = 0.32, 0.31, 1e5
BRUSH = dict(cornering=11.0, longitudinal=17.0, relaxation=0.12, relaxation_x=0.07, mu=0.8, trail=0.03)


def rig(angle, drive, speed, **tyre):
    """A wheel on a carriage along x, turned to the left [rad], with a hub that goes at a multiple of rolling."""
    axle, ahead = np.array([-np.sin(angle), np.cos(angle), 0.0]), np.array([np.cos(angle), np.sin(angle), 0.0])
    at, spin = (0.0, 0.0, HUB), drive * speed * ahead[0] / HUB
    carriage = Body("carriage", 30.0, (1.0, 1.0, 1.0), position=at)
    wheel = Body("wheel", 8.0, (0.3, 0.3, 0.3), position=at)
    slider, hub = Prismatic(GROUND, carriage, at=at, axis=(1, 0, 0)), Revolute(carriage, wheel, at=at, axis=axle)
    on = Tyre(GROUND, wheel, axis=axle, radius=RADIUS, crown=0.05, stiffness=K, name="tyre", **tyre)
    motors = [SpeedDriver(slider, speed), SpeedDriver(hub, spin)]
    return System([carriage, wheel], [slider, hub, *motors], [on]), on


def brush(tyre, N, slip_x, slip_y):
    """(F_x, F_y, M_z) of the brush model with theoretical slips and equal friction in all directions."""
    mu, pull = BRUSH["mu"], np.array([tyre.longitudinal * slip_x, tyre.cornering * slip_y])
    size = np.linalg.norm(pull)
    theta = min(size / (3.0 * mu), 1.0)
    F = mu * N * (3.0 * theta - 3.0 * theta**2 + theta**3) * pull / size
    return *F, -tyre.trail * (1.0 - theta) ** 3 / (1.0 - theta + theta**2 / 3.0) * F[1]


@pytest.mark.parametrize(
    ("angle", "drive"), [(0.02, 1.0), (-0.05, 1.01), (0.12, 0.97), (0.3, 1.0), (-0.1, 1.4), (0.1, 0.0), (1e-7, 1.1)]
)
def test_steady_slip_is_the_brush_model(angle, drive):
    """To what 60 relaxation lengths leave of the start, and the run's own errors."""
    system, tyre = rig(angle, drive, 6.0, **BRUSH)
    seen = simulate(system, 1.2, rtol=1e-11, output=2).force("tyre")
    N = K * (RADIUS - HUB)
    forces = brush(tyre, N, drive - 1.0, np.tan(angle))
    assert seen.normal[-1] == pytest.approx(N, rel=1e-12)
    found = np.array([seen.longitudinal[-1], seen.lateral[-1], seen.aligning[-1]])
    assert found == pytest.approx(forces, abs=1e-8 * N)
    assert seen.slip_angle[-1] == pytest.approx(angle, abs=1e-12)
    assert seen.slip_ratio[-1] == pytest.approx(drive - 1.0, abs=1e-12)


def test_a_grip_that_falls_below_zero_is_that_of_ice():
    """A spline through 0.9, 0.9, 0.02, 0.02 swings below zero on its way: the forces stay within a hundredth."""
    grip = Table([0.0, 0.1, 0.15, 0.3, 0.5], [0.9, 0.9, 0.02, 0.02, 0.02])
    times = np.linspace(0.0, 0.5, 101)
    system, _ = rig(0.1, 1.05, 6.0, **{**BRUSH, "mu": grip})
    seen = simulate(system, 0.5, output=times).force("tyre")
    used, most = np.hypot(seen.longitudinal, seen.lateral) / seen.normal, np.maximum(grip(times), 0.01)
    assert grip(times).min() < -0.01 and (used <= most * (1.0 + 1e-12)).all()
    assert used[-1] == pytest.approx(0.02, rel=1e-9)


def test_rolling_back_is_rolling_ahead_in_a_mirror():
    """Across the way: forces to the side stay, those along it and moments about the normal turn round."""
    seen = []
    for speed in (3.0, -3.0):
        tyre = rig(0.05, 1.0, speed, **BRUSH, camber=1.1, twisting=0.01)[1]
        lean = np.array([0.0, np.cos(0.3), np.sin(0.3)])
        wheel = Body("wheel", 8.0, (0.3, 0.4, 0.5), position=(0, 0, 0.3), velocity=(speed, 0.2, 0.0),
                     omega=1.02 * speed / 0.3 * lean)  # fmt: skip
        on = replace(tyre, b=wheel, axis=lean, centre=None)
        y = accelerations(System([wheel], forces=[on]))
        seen.append(accelerations(y.system, replace(y.final, z=np.array([-0.01 * np.sign(speed), -0.02]))).force(on))
    ahead, back = seen
    assert ahead.aligning[0] > 0.1 and ahead.lateral[0] == pytest.approx(back.lateral[0], rel=1e-12)
    for name in ("longitudinal", "aligning"):
        assert getattr(back, name)[0] == pytest.approx(-getattr(ahead, name)[0], rel=1e-12)


def test_on_a_belt_that_runs_back_it_is_as_on_the_road():
    """The same motion, seen from the carriage."""
    system, tyre = rig(0.12, 0.97, 6.0, **BRUSH)
    belt = Body("belt", 30.0, (1.0, 1.0, 1.0), position=(1.0, 2.0, 3.0))
    slider, motor = Prismatic(GROUND, belt, at=(0, 0, 0), axis=(1, 0, 0)), system.joints[2]
    held = [replace(motor, speed=0.0), SpeedDriver(slider, -6.0)]
    moved = replace(
        system, bodies=[*system.bodies, belt], joints=[*system.joints[:2], slider, *held, system.joints[3]],
        forces=[replace(tyre, a=belt)],
    )  # fmt: skip
    for name in ("normal", "longitudinal", "lateral", "aligning", "slip_x", "slip_y", "speed"):
        known, found = (getattr(simulate(x, 0.2, rtol=1e-11, output=9).force("tyre"), name) for x in (system, moved))
        assert found == pytest.approx(known, abs=1e-8 * np.abs(known).max())


def loaded_tyre(rng, **numbers):
    """A tyre on a general plane, pressed by 9 mm at the reference pose, camber up to a radian."""
    normal, axis = rng.normal(size=3), rng.normal(size=3)
    normal /= np.linalg.norm(normal)
    axis -= 0.7 * normal * (normal @ axis)
    wheel = Body("wheel", 8.0, (0.3, 0.4, 0.5), com=(0.1, -0.05, 0.02), position=rng.normal(size=3))
    lean = normal @ axis / np.linalg.norm(axis)
    height = 0.25 * np.sqrt(1.0 - lean**2) + 0.05 - 0.009
    centre = wheel.position + 0.1 * rng.normal(size=3)
    plane = (centre - height * normal, normal)
    return Tyre(GROUND, wheel, axis=axis, radius=0.3, crown=0.05, stiffness=K, centre=centre, plane=plane, **numbers)


def test_friction_never_leaves_the_circle():
    """At a thousand states with deflections and slips of all sizes, with the damper of standing."""
    rng = np.random.default_rng(3)
    numbers = {**BRUSH, "camber": 1.2, "standing_damping": 0.5, "nominal_load": 500.0, "grip_sensitivity": 0.15}
    used = []
    for _ in range(100):
        tyre = loaded_tyre(rng, **numbers, stiffness_sensitivity=0.2)
        on = Evaluation(System([tyre.b], forces=[tyre]))
        for _ in range(10):
            q, _ = on.reference()
            y = on.state(q, 10.0 ** rng.uniform(-3, 1) * rng.normal(size=6))
            y[13:15] = 10.0 ** rng.uniform(-3, 2) * rng.normal(size=2)
            kinematics(on.model, on.data, y)
            loads(on.model, on.data, 0.0)
            N, F_x, F_y = on.data.force["shown"][0, 3:6]
            if N > 0.0:
                grip = 0.8 * max(1.0 - 0.15 * (N / 500.0 - 1.0), 0.1)
                used.append(np.hypot(F_x, F_y) / (grip * N))
                assert used[-1] == pytest.approx(on.data.force["shown"][0, 11], rel=1e-12)
    assert len(used) > 400 and max(used) < 1.0 + 1e-14 and max(used) > 0.99 and min(used) < 0.3


def test_force_acts_at_the_contact_point_with_an_opposite_one_on_the_plane():
    rng = np.random.default_rng(4)
    tyre = loaded_tyre(rng, **BRUSH, camber=0.9)
    system = System([tyre.b], forces=[tyre])
    seen, back = (accelerations(system).force(tyre, on=on) for on in (tyre.b, GROUND))
    at, n = tyre.plane
    assert (seen.point[0] - at) @ n == pytest.approx(0.0, abs=1e-15)
    assert seen.force[0] @ n == pytest.approx(seen.normal[0], rel=1e-13)
    assert seen.normal[0] == pytest.approx(K * 0.009, rel=1e-9)
    assert back.point[0] == pytest.approx(seen.point[0], abs=1e-15)
    assert back.force[0] == pytest.approx(-seen.force[0], abs=1e-12)
    assert back.moment[0] == pytest.approx(-seen.moment[0], abs=1e-12)


def trolley(slope, **tyre):
    """A body on four locked wheels that stands across a slope that also falls ahead."""
    body = Body("trolley", 60.0, (4.0, 9.0, 11.0), com=(0.05, 0.02, 0.1), position=(0, 0, 0.297))
    wheels = [
        Tyre(GROUND, body, axis=(0, 1, 0), radius=0.3, crown=0.03, stiffness=K, centre=(x, y, 0.297), **tyre)
        for x in (-0.6, 0.6)
        for y in (-0.4, 0.4)
    ]
    down = 9.81 / np.hypot(1.0, slope)
    return System([body], forces=wheels, gravity=(0.8 * slope * down, -0.6 * slope * down, -down))


def test_a_parked_wheel_stands_on_a_slope():
    """30 %, down to the fall line at 37 degrees: it stands, where the deflection holds it, without creeping."""
    numbers = dict(cornering=14.0, longitudinal=20.0, relaxation=0.1, mu=0.9, standing_damping=0.5)
    run = simulate(trolley(0.3, **numbers), 20.0, output=[19.0, 20.0])
    assert np.abs(run.velocity("trolley")[-1]).max() < 1e-8  # rtol
    assert np.abs(np.diff(run.position("trolley"), axis=0)).max() < 1e-8
    used = [run.force(tyre).saturation[-1] for tyre in run.system.forces]
    assert 0.2 < min(used) and max(used) < 0.45  # 0.3/0.9, shared as the loads are not
    assert run.certificate["energy balance"].error < 1e-8


def test_it_slides_on_a_slope_steeper_than_the_grip():
    """With the acceleration of Coulomb's law, g (sin - mu cos), once all of every contact patch slides."""
    run = simulate(trolley(0.6, mu=0.4, cornering=14.0, relaxation=0.05, standing_damping=0.5), 2.0, output=[1.5, 2.0])
    pull = 9.81 * (0.6 - 0.4) / np.hypot(1.0, 0.6)
    gained = np.linalg.norm(np.diff(run.velocity("trolley"), axis=0)[0])
    assert gained == pytest.approx(0.5 * pull, rel=0.02)  # it turns a little: the loads of its wheels differ


def test_drop_of_a_wheel():
    """A damped spring that only presses: closed form of one impact with release while it is still compressed."""
    m, k, c, g, h = 20.0, 1.5e5, 300.0, 9.81, 0.1
    wheel = Body("wheel", m, (0.5, 1.0, 0.5), position=(0, 0, 0.3 + h))
    tyre = Tyre(GROUND, wheel, axis=(0, 1, 0), radius=0.3, crown=0.03, stiffness=k, damping=c, name="tyre")
    lifted = System([wheel], [Prismatic(GROUND, wheel, at=(0, 0, 0.4), axis=(0, 0, 1))], [tyre])
    rate, v, sag = c / (2.0 * m), np.sqrt(2.0 * g * h), m * g / k
    omega = np.sqrt(k / m - rate**2)

    def sink(t):
        """(depth, its rate) after the touch."""
        b = (v - rate * sag) / omega
        x = np.exp(-rate * t) * (-sag * np.cos(omega * t) + b * np.sin(omega * t))
        x_dot = -rate * x + np.exp(-rate * t) * omega * (sag * np.sin(omega * t) + b * np.cos(omega * t))
        return x + sag, x_dot

    released = brentq(lambda t: k * sink(t)[0] + c * sink(t)[1], 0.02, 0.05, xtol=1e-15)
    assert -sink(released)[1] / v == pytest.approx(0.759947801207112, rel=1e-12)  # of an independent program
    touch = np.sqrt(2.0 * h / g)
    times = np.array([touch + 0.4 * released, touch + released + 0.01])
    run = simulate(lifted, times[1], rtol=1e-11, output=times)
    x, x_dot = sink(0.4 * released)
    assert run.position("wheel")[0, 2] == pytest.approx(0.3 - x, abs=1e-9)
    assert run.force("tyre").normal == pytest.approx([k * x + c * x_dot, 0.0], abs=1e-3)
    assert run.velocity("wheel")[1, 2] == pytest.approx(-sink(released)[1] - 0.01 * g, abs=1e-6)


@pytest.mark.parametrize("speed", [0.2, 1.0, 5.0, 20.0])
def test_shimmy_of_a_trailing_wheel(speed):
    """Characteristic polynomial I s^2 + k s + C (e + t) (e s + V)/(sigma s + V) = 0 of a wheel behind its kingpin."""
    I, C, sigma, e, t, k, N = 0.6, 6000.0, 0.1, 0.05, 0.02, 2.0, 1000.0
    at, m = (-e, 0, HUB), 8.0
    cart = Body("cart", 50.0, (1.0, 1.0, 1.0), position=(0, 0, HUB), velocity=(speed, 0, 0))
    fork = Body("fork", 1.0, (0.3, 0.2, 0.4), position=(0, 0, HUB))
    wheel = Body("wheel", m, (0.2 - m * e**2, 0.3, 0.2 - m * e**2), position=at, omega=(0, speed / HUB, 0))
    rail = Prismatic(GROUND, cart, at=(0, 0, HUB), axis=(1, 0, 0))
    king = Revolute(cart, fork, at=(0, 0, HUB), axis=(0, 0, 1))
    hub = Revolute(fork, wheel, at=at, axis=(0, 1, 0))
    tyre = Tyre(
        GROUND, wheel, axis=(0, 1, 0), radius=HUB + N / K, crown=0.02, stiffness=K, mu=None, cornering=C / N,
        relaxation=sigma, trail=t,
    )  # fmt: skip
    system = System([cart, fork, wheel], [rail, king, hub], [tyre, JointFriction(king, viscous=k)])
    outputs = [measures.angle(king), measures.rate(king), measures.state(tyre, "lateral")]
    found = np.sort_complex(linearize(system, outputs=outputs).eigenvalues)
    arm = C * (e + t)
    wanted = np.sort_complex(np.roots([sigma * I, I * speed + sigma * k, k * speed + arm * e, arm * speed]))
    assert found == pytest.approx(wanted, rel=1e-9)


def test_load_sensitivity_and_instant_camber():
    rng = np.random.default_rng(6)
    at = dict(camber=1.1, mu=None)
    lagged = loaded_tyre(rng, **at)
    at_once = loaded_tyre(rng, **at, camber_lag=False)
    plain, instant = (accelerations(System([x.b], forces=[x])).force(x) for x in (lagged, at_once))
    assert plain.lateral[0] == 0.0 and plain.states["lateral"][0] == 0.0  # its deflection has yet to grow
    assert instant.lateral[0] == pytest.approx(-1.1 * instant.normal[0] * np.sin(instant.camber[0]), rel=1e-12)
    sensitive = loaded_tyre(rng, camber=1.1, mu=None, camber_lag=False, nominal_load=1800.0, stiffness_sensitivity=0.3)
    seen = accelerations(System([sensitive.b], forces=[sensitive])).force(sensitive)
    share = 1.0 - 0.3 * (seen.normal[0] / 1800.0 - 1.0)
    assert seen.lateral[0] == pytest.approx(-share * 1.1 * seen.normal[0] * np.sin(seen.camber[0]), rel=1e-12)


def test_what_is_left_out_follows_what_is_replaced():
    """Longitudinal stiffness and relaxation are those of the lateral direction, also of a tyre that is changed."""
    system, tyre = rig(0.1, 1.05, 6.0, cornering=11.0, relaxation=0.12)
    changed = replace(tyre, cornering=5.0, relaxation=0.3)
    known = replace(changed, longitudinal=5.0, relaxation_x=0.3)
    assert (tyre.ahead, changed.ahead) == ((11.0, 0.12), (5.0, 0.3)) and changed.longitudinal is None
    assert replace(changed, relaxation_x=0.07).ahead == (5.0, 0.07)
    seen = [simulate(replace(system, forces=[one]), 0.1).force("tyre") for one in (changed, known)]
    assert np.array_equal(seen[0].longitudinal, seen[1].longitudinal) and seen[0].longitudinal[-1] > 100.0


def test_a_saved_run_has_its_tyres(tmp_path):
    system, _ = rig(0.1, 1.05, 4.0, **BRUSH)
    run = simulate(system, 0.1, output=5)
    again = load(run.save(tmp_path / "rig"))
    for name in ("normal", "lateral", "slip_angle", "saturation"):
        assert (getattr(again.force("tyre"), name) == getattr(run.force("tyre"), name)).all()
    assert {*run.force("tyre").states} == {"longitudinal", "lateral"}


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        (dict(crown=0.4), "exceeds the outer radius"),
        (dict(mu=0.0), "mu"),
        (dict(grip_sensitivity=0.1), "without nominal_load"),
        (dict(axis=(0, 0, 1)), "lies flat on the plane"),
        (dict(relaxation=-0.1), "relaxation"),
        (dict(camber_lag="no"), "camber_lag"),
    ],
)
def test_errors_name_the_tyre(wrong, text):
    wheel = Body("wheel", 8.0, (0.3, 0.4, 0.5), position=(0, 0, 0.3))
    with pytest.raises(ValueError, match=f"'left'.*{text}"):
        Tyre(GROUND, wheel, **(dict(axis=(0, 1, 0), radius=0.3, stiffness=K, name="left") | wrong))
