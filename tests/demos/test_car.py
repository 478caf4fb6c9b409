"""The car of the road demos against an independent program, and its single-track reduction against closed forms."""

import json
from pathlib import Path

import numpy as np
import pytest

from mbsd3d import GROUND, Body, Planar, Pulse, System, Tyre, linearize, measures, simulate
from mbsd3d.demos.road.car import WHEELS, Car, car, circle, circles
from mbsd3d.demos.road.car_limit import gradients, note

TRUTHS = json.loads(Path(__file__).with_name("car_truths.json").read_text(encoding="utf-8"))
RELAXATION = 1e-8  # [m]
MIRROR = [1, 0, 3, 2]
"""The independent program has its y axis to the right: its left wheels are our right ones."""


def test_steady_circles_of_an_independent_program():
    """To 95 % of the grip; both agree to 1e-12."""
    rows, last, v = TRUTHS["car_steady_circle"]["rows"], None, TRUTHS["car_steady_circle"]["v"]
    for row in rows[:1] + rows[2:]:
        last = circle(Car(), v, v * row["yaw_rate"], last)
        assert last.steer == pytest.approx(row["delta"], rel=1e-9)
        assert last.roll == pytest.approx(-row["roll"], rel=1e-9)
        assert last.drive == pytest.approx(row["drive_torque"], rel=1e-8)
        assert last.of_tyres("normal")[MIRROR] == pytest.approx(list(row["loads"].values()), rel=1e-9)
        assert last.of_tyres("lateral")[MIRROR] == pytest.approx(list(row["Fy"].values()), rel=1e-9)


def test_small_accelerations_have_the_closed_forms():
    p, known = TRUTHS["car_roll_linear"]["par"], TRUTHS["car_roll_linear"]["truth"]
    found = gradients(Car(), p["Iwy"])
    assert p["ay"] * found["roll_rad_s2_m"] == pytest.approx(known["phi"], rel=1e-12)
    assert p["ay"] * found["front_transfer_kg"] == pytest.approx(known["dFz_front"], rel=1e-12)
    assert p["ay"] * found["rear_transfer_kg"] == pytest.approx(known["dFz_rear"], rel=1e-12)
    assert p["ay"] * gradients(Car(), 0.0)["roll_rad_s2_m"] == pytest.approx(known["phi_without_gyro"], rel=1e-12)


def single_track(p, v):
    """A body in the plane on two linear tyres whose wheels are locked, without drag."""
    body = Body("car", p["m"], (2000.0, 2000.0, p["Iz"]), position=(0, 0, 0.3), velocity=(v, 0, 0))
    weight, L, tyres = p["m"] * 9.81, p["a"] + p["b"], []
    for x, C, other in ((p["a"], p["Cf"], p["b"]), (-p["b"], p["Cr"], p["a"])):
        N = weight * other / L
        numbers = {"cornering": C / N, "longitudinal": 1e-12, "mu": None, "relaxation": RELAXATION, "stiffness": 1e6}
        numbers["relaxation_x"] = 1e9  # what is ahead hardly deflects: a run that is steady but for 1e-8 1/s
        tyres.append(Tyre(GROUND, body, axis=(0, 1, 0), radius=0.3 + N / 1e6, centre=(x, 0, 0.3), **numbers))
    return System([body], [Planar(GROUND, body, at=(0, 0, 0.3), normal=(0, 0, 1))], tyres)


@pytest.mark.parametrize("v", ["10.0", "20.0", "40.0"])
def test_the_single_track_reduction_has_its_closed_forms(v):
    """Short relaxation lengths are short delays: of first order, and less than the limit."""
    p, known = TRUTHS["single_track_car"]["par"], TRUTHS["single_track_car"]["truth"]
    system = single_track(p, float(v))
    ahead = [measures.velocity(system.part("car"), axis=(0, 1, 0)), measures.heading_rate(system.part("car"))]
    slip = [measures.state(tyre, "lateral") for tyre in system.forces]
    A = linearize(system, outputs=[*ahead, *slip, measures.heading(system.part("car"))], tolerance=1e-5).A
    turned = np.eye(5)
    turned[0, -1] = float(v)  # the speed to the left over the car, not over the ground
    found = np.linalg.eigvals(np.linalg.solve(turned, A @ turned)[:4, :4])
    for pair in known["eig"][v]:
        assert np.abs(found - complex(*pair)).min() < 1e-6 * abs(complex(*pair))


@pytest.mark.slow
def test_bars_at_the_rear_let_the_rear_tyres_go_first():
    steps = (3.0, 3.0, 1.0)
    front, rear = (circles(Car(bar_f=f, bar_r=18e3 - f), 20.0, steps)[-1] for f in (18e3, 0.0))
    assert "front left" in note("at the front", front) and "rear left" in note("at the rear", rear)
    assert front.steer > 1.2 * rear.steer


def test_a_step_of_the_steer_settles_on_its_circle():
    """Within what a speed that nobody keeps loses in three seconds."""
    run = simulate(car(Car(), 20.0, Pulse(0.02, start=0.2, edge=0.3)), 3.0, output=[3.0])
    v = run.rotation("chassis")[-1][:, 0] @ run.velocity("chassis")[-1]
    there = circle(Car(), v, v * run.omega("chassis")[-1, 2])
    assert there.steer == pytest.approx(0.02, rel=5e-3) and 19.5 < v < 20.0
    loads = [run.force(f"{name} tyre").normal[-1] for name in WHEELS]
    assert there.of_tyres("normal") == pytest.approx(loads, rel=0.01)
    assert run.certificate.passed
