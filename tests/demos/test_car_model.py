"""The car of the demos against an independent program, equations written out by hand, and closed forms."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from mbsd3d import Pulse, linearize, simulate
from mbsd3d.demos.cars import single_track
from mbsd3d.demos.cars.car import Car, Engine, car
from mbsd3d.demos.cars.circle import Balance, circle, circles
from mbsd3d.demos.cars.linear import linear
from mbsd3d.demos.cars.roll_bars import note
from mbsd3d.demos.cars.theory import limit, roll_gradient, transfers, trims
from mbsd3d.demos.discovery import own_demos

G = 9.81  # [m/s^2]
WHEELS = ("front left", "front right", "rear left", "rear right")

TRUTHS = json.loads(Path(__file__).with_name("car_truths.json").read_text(encoding="utf-8"))
MIRROR = [1, 0, 3, 2]
"""The independent program has its y axis to the right: its left wheels are our right ones."""
OTHER = Car(1300, 0.6, 1.3, 1.35, 1.4, 2e4, 3e4, 9e3, 2e3, 0.9, 35, 1.4, 0.31, 1.8e5, less_stiffness=0.31)


def test_steady_circles_of_an_independent_program():
    """To 95 % of the grip; both agree to 1e-12."""
    rows, last, v = TRUTHS["car_steady_circle"]["rows"], None, TRUTHS["car_steady_circle"]["v"]
    for row in rows:
        last = circle(Car(), v, v * row["yaw_rate"], last)
        assert last.steer == pytest.approx(row["delta"], rel=1e-9)
        assert last.roll == pytest.approx(-row["roll"], rel=1e-9)
        assert last.drive == pytest.approx(row["drive_torque"], rel=1e-8)
        assert last.of_tyres("normal")[MIRROR] == pytest.approx(list(row["loads"].values()), rel=1e-9)
        assert last.of_tyres("lateral")[MIRROR] == pytest.approx(list(row["Fy"].values()), rel=1e-9)


def test_small_accelerations_have_the_closed_forms():
    p, known = TRUTHS["car_roll_linear"]["par"], TRUTHS["car_roll_linear"]["truth"]
    found = Car(Iw=p["Iwy"])
    assert p["ay"] * roll_gradient(found) == pytest.approx(known["phi"], rel=1e-12)
    assert p["ay"] * transfers(found) == pytest.approx([known["dFz_front"], known["dFz_rear"]], rel=1e-12)
    assert p["ay"] * roll_gradient(found, 0.0) == pytest.approx(known["phi_without_gyro"], rel=1e-12)


@pytest.mark.parametrize("c", [Car(), OTHER])
@pytest.mark.parametrize(("spin", "terms"), [(1.0, {}), (0.5, {"gyroscopic": False})])
def test_small_motions_are_those_written_out_by_hand(c, spin, terms):
    """All sixteen to the side; they share neither rows nor forces nor derivatives."""
    known = np.linalg.eigvals(linear(c, 23.0, spin).A)
    found = linearize(car(c, 23.0, 0.0), **terms).eigenvalues
    for s in known[np.abs(known) > 1e-6]:
        assert np.abs(found - s).min() < 1e-10 * abs(s)


@pytest.mark.parametrize("v", ["10.0", "20.0", "30.0", "40.0"])
def test_the_single_track_reduction_has_its_closed_forms(v):
    p, known = TRUTHS["single_track_car"]["par"], TRUTHS["single_track_car"]["truth"]
    named = {key: p[key] for key in ("m", "Iz", "a", "b", "Cf", "Cr")}
    demo = own_demos()["single_track"]
    s, gain = single_track.response(lambda **more: demo.mechanism(**named, **more), float(v), {})
    assert abs(s - complex(*known["eig"][v][0])) < 1e-6 * abs(s)
    assert gain == pytest.approx(known["yaw_gain"][v], rel=1e-10)
    theory = demo.theory(**named, v=float(v))
    assert theory["characteristic_m_s"] == pytest.approx(known["V_characteristic"], rel=1e-12)
    outcome = demo.run(**named, v=float(v)) if v == "20.0" else None
    assert outcome is None or outcome.quantities["characteristic_m_s"].error < 1e-6


@pytest.mark.parametrize("v", [8.0, 31.0])
def test_the_single_track_is_that_of_commonroad(v):
    """Its equations with other numbers; a little of its drive shifts the loads, and makes both axles differ."""
    model = pytest.importorskip("vehiclemodels.vehicle_dynamics_st", reason="pip install commonroad-vehicle-models")
    m, Iz, a, b, Cf, Cr, h = 1430.0, 2150.0, 1.18, 1.52, 71e3, 88e3, 0.5
    pull = (G * b - (a + b) * Cf / (Cf + Cr) * G) / h  # h m pull is what its loads shift by
    tire = SimpleNamespace(p_dy1=1.0, p_ky1=-(Cf + Cr) / (m * G))
    limits = {"steering": SimpleNamespace(min=-1, max=1, v_min=-1, v_max=1)}
    limits["longitudinal"] = SimpleNamespace(v_switch=100.0, a_max=20.0, v_min=-1.0, v_max=100.0)
    p = SimpleNamespace(a=a, b=b, h_s=h, m=m, I_z=Iz, tire=tire, **limits)

    def rates(x):
        return np.array(model.vehicle_dynamics_st([0, 0, x[2], v, 0, x[0], x[1]], [0.0, pull], p))[5:]

    J = np.column_stack([rates(e) for e in np.eye(3)])  # it is linear in yaw rate, slip angle and steer
    known = max(np.linalg.eigvals(J[:, :2]), key=lambda s: (s.imag, s.real))
    numbers = {"m": m, "Iz": Iz, "a": a, "b": b, "Cf": Cf, "Cr": Cr}
    s, gain = single_track.response(lambda **more: single_track.mechanism(**numbers, **more), v, {})
    assert abs(s - known) < 1e-6 * abs(known)
    assert gain == pytest.approx(-np.linalg.solve(J[:, :2], J[:, 2])[0], rel=1e-6)


def test_trims_follow_the_circles_to_the_limit():
    """By rows of the circles: what they leave out, the lean of the wheels in a large roll, is of second order in it."""
    known = trims(Car(), 20.0)
    a = [one.acceleration for one in known]
    steer, loads = CubicSpline(a, [one.steer for one in known]), CubicSpline(a, [one.loads[MIRROR] for one in known])
    for row in TRUTHS["car_steady_circle"]["rows"][:4]:
        assert float(steer(row["ay"])) == pytest.approx(row["delta"], rel=row["roll"] ** 2)
        assert loads(row["ay"]) == pytest.approx(list(row["loads"].values()), rel=row["roll"] ** 2)


@pytest.mark.slow
def test_the_limit_is_a_top_of_the_curve():
    """Beyond it the steer goes on and the acceleration falls; no step of the way changes it by a thousandth."""
    found = circles(Car(), 20.0)
    assert all(b.acceleration > a.acceleration for a, b in zip(found, found[1:], strict=False))
    slippery = Car(mu=0.2)
    known = limit(slippery, 20.0).acceleration  # by trims, which leave out the lean of the wheels
    assert circles(slippery, 20.0)[-1].acceleration == pytest.approx(known, rel=2e-3)
    assert circles(Car(), 20.0, step=2.0)[-1].acceleration == pytest.approx(found[-1].acceleration, rel=2e-3)
    with pytest.raises(ValueError, match="no circle at 20 m/s and 8.7 m/s\\^2"):
        circle(Car(), 20.0, 8.7, found[-1])


@pytest.mark.slow
def test_the_end_with_the_bars_lets_go_first():
    rear, front = (circles(Car(bar_f=f, bar_r=18e3 - f), 20.0, step=7.0) for f in (0.0, 18e3))
    assert "the inner rear tyre is the first" in note(0.0, rear)
    assert "the inner front tyre is the first" in note(1.0, front)
    assert front[-1].steer > 2.0 * rear[-1].steer


def test_a_step_of_the_steer_settles_on_its_circle():
    """The circle keeps its speed, the run slows by a share of g: so much do its tyres and their loads differ."""
    run = simulate(car(Car(), 20.0, Pulse(0.02, start=0.2, edge=0.3)), 3.0, output=[3.0])
    ahead = run.rotation("chassis")[-1][:, 0]
    v, slows = ahead @ run.velocity("chassis")[-1], -ahead @ run.acceleration("chassis")[-1] / 9.81
    assert 0.0 < slows < 0.01
    there = circle(Car(), v, v * run.omega("chassis")[-1, 2])
    assert there.steer == pytest.approx(0.02, rel=2 * slows) and 19.5 < v < 20.0
    loads = [run.force(f"{name} tyre").normal[-1] for name in WHEELS]
    assert there.of_tyres("normal") == pytest.approx(loads, rel=2 * slows)
    assert run.certificate.passed


def test_an_engine_along_the_car_pitches_it_and_does_not_roll_it():
    outcome = own_demos()["engine_in_the_car"].run(axis="x", Omega=600.0)
    assert outcome.passed and outcome.quantities["pitch_by_engine_rad_s2_m"].theory < -1e-5
    with pytest.raises(ValueError, match="axis = 'z'; give \"y\""):
        own_demos()["engine_in_the_car"].run(axis="z")


def test_a_circle_of_the_car_with_an_engine_is_steady():
    """Its state runs on as it is: the same speed, roll and loads after half a second."""
    c = Car(engine=Engine(0.25, 700.0, (0.0, 1.0, 0.0)))
    there = circle(c, 20.0, 5.0)
    balance = Balance(c, 20.0, {})
    system = car(c, 20.0, None, there.drive)
    state = balance.state(there.x)
    run = simulate(system, there.drive + 0.5, state=state, output=[there.drive + 0.5])
    assert np.linalg.norm(run.velocity("chassis")[-1]) == pytest.approx(np.hypot(20.0, there.x[3]), rel=1e-7)
    loads = [run.force(f"{name} tyre").normal[-1] for name in WHEELS]
    assert loads == pytest.approx(there.of_tyres("normal"), rel=1e-6)
