"""The bicycle on tyres against an independent program, Sharp's motorcycle against its printed table, the limit of ideal
wheels, rides at the limit of grip."""

import json
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from bicycle import Meijaard2007, named, on_tyres, ride, stability, whipple
from bicycle.commands import fitted
from bicycle.commands.motion import refitted
from bicycle.linear import tyre_equations
from bicycle.parameters import fittings, machines
from bicycle.turns import on_tyres as turns_on_tyres
from mbsd3d import Pulse, linearize, simulate
from mbsd3d.extend import main

TRUTHS = json.loads(Path(__file__).with_name("tyre_truths.json").read_text(encoding="utf-8"))
P = Meijaard2007()
BRUSH = {
    "cornering": 14.3, "camber": 1.0, "relaxation": 0.1, "longitudinal": 20.0, "trail": 0.02, "mu": 0.9,
    "stiffness": 2e5, "damping": 400.0,
}  # fmt: skip


def numbers(row):
    """Arguments of `Tyre`, and crown radius, of a row of the truths."""
    words = {"ca": "cornering", "cg": "camber", "sig": "relaxation", "trail": "trail", "camber_lag": "camber_lag"}
    return {words[key]: x for key, x in row.items() if key in words}, row.get("rho", 0.0)


def complexes(pairs):
    return np.sort_complex([complex(*pair) for pair in pairs])


@pytest.mark.parametrize("row", TRUTHS["straight_running"]["rows"], ids=lambda row: str(row["tyre"]))
@pytest.mark.parametrize("speed", ["1.5", "5.0", "12.0"])
def test_eigenvalues_of_an_independent_program(row, speed):
    """Printed to 13 digits; both sides agree to 5e-12 of an eigenvalue."""
    tyres, crown = numbers(row["tyre"])
    found = on_tyres.eigenvalues(partial(whipple, tyres=tyres), replace(P, tR=crown, tF=crown), [float(speed)])[0]
    wanted = complexes(row["eigenvalues"][speed])
    assert (np.abs(found - wanted) / np.abs(wanted)).max() < 1e-10


@pytest.mark.slow
@pytest.mark.parametrize("k", [3, 4, 5])
def test_stable_range_of_an_independent_program(k):
    row = TRUTHS["straight_running"]["rows"][k]
    tyres, crown = numbers(row["tyre"])
    found = stability.study(replace(P, tR=crown, tF=crown), [3.5, 4.4, 5.0, 7.0], tyres=tyres)
    wanted = row["stability_limits"]
    assert [at.speed for at in found.limits] == pytest.approx([at["v"] for at in wanted], rel=1e-9)
    assert [at.frequency for at in found.limits] == pytest.approx([at["omega"] for at in wanted], abs=1e-7)


@pytest.mark.parametrize("k", [3, 4])
def test_ranges_without_a_grid(k):
    """The pencils find the limits of the independent program, of all speeds at once."""
    row = TRUTHS["straight_running"]["rows"][k]
    tyres, crown = numbers(row["tyre"])
    linear = tyre_equations.required_equations(partial(whipple, tyres=tyres), replace(P, tR=crown, tF=crown))
    (found,) = linear.stable()
    assert found == pytest.approx([at["v"] for at in row["stability_limits"]], rel=1e-9)


def test_equations_are_affine_in_the_speed_unless_something_fades():
    """A motorcycle too; damping of a tyre at rest fades with speed, so its limits lie between speeds of a grid."""
    p, v = named("Sharp1971"), 37.3
    build = partial(whipple, **fittings(p))
    found = tyre_equations.required_equations(build, p).A(v)
    assert found == pytest.approx(tyre_equations.matrix(build(p, speed=v), v), abs=1e-12 * np.abs(found).max())
    parked = BRUSH | {"standing_damping": 0.5}
    with pytest.raises(ValueError, match="leave out standing_damping"):
        tyre_equations.required_equations(partial(whipple, tyres=parked), P)
    limits = stability.study(P, np.linspace(4.0, 8.0, 4), tyres=parked).limits
    assert [at.speed for at in limits] == pytest.approx([4.49779, 6.84322], abs=2e-2)  # 1/(1 + (V/V0)^2) = 5e-4


def test_modes_do_not_depend_on_the_speeds_between():
    """Two speeds are enough to follow them by; the others stand where many small steps lead."""
    few, many = (stability.study(P, np.linspace(0.5, 10.0, n), tyres=BRUSH) for n in (2, 96))
    assert few.names == many.names and few.values == pytest.approx(many.values[[0, -1]], rel=1e-9)
    for name in ("weave", "capsize", "castering", "wobble"):
        wanted = many.values[45, many.names.index(name)]
        found = few.mode(name, many.speeds[45]).eigenvalue
        assert min(abs(found - wanted), abs(found - wanted.conjugate())) < 1e-8 * abs(wanted), name


def test_modes_that_hardly_oscillate_have_names():
    """A bicycle whose steer and head are damped has eight or more decays."""
    damped = {"steer_damping": 190.0, "head_stiffness": 700.0, "head_damping": 0.4}
    found = stability.study(P, [2.0, 4.4], tyres=BRUSH | {"relaxation": 2e-4}, **damped)
    assert sum(name in on_tyres.DECAY_NAMES for name in found.names) == 8 and len({*found.names}) == 10


def test_ranges_from_rest_or_backwards_are_those_ahead():
    """Two speeds, both unstable: the range between them is found by the equations of all speeds."""
    known = stability.study(P, [0.5, 8.0], tyres=BRUSH)
    for first in (0.0, -2.0):
        found = stability.study(P, [first, 8.0], tyres=BRUSH)
        assert len(found.stable) == 1 and found.stable[0] == pytest.approx(known.stable[0], rel=1e-12)


def test_pairs_of_eigenvalues_that_sum_to_zero():
    """Also where the range is a millimetre per second wide."""
    A = np.random.default_rng(5).normal(size=(5, 5))
    values = np.linalg.eigvals(A)
    sums = [values[i] + values[j] for i in range(5) for j in range(i)]
    assert np.poly(tyre_equations.pair_sums(A)) == pytest.approx(np.poly(sums).real, rel=1e-10)
    swings = tyre_equations.Affine(np.array([[-2.0, 3.0], [-3.0, 3.0]]), np.diag([0.0, -1.0]))  # 1 - v, 3 + 2 v
    assert swings.stable() == [pytest.approx((1.0, np.inf))] and swings.limits(np.array([1.5, 9.0])) == ()
    assert swings.limits(np.array([0.5, 9.0])) == (pytest.approx((1.0, np.sqrt(5.0))),)
    narrow = tyre_equations.Affine(np.diag([-2.0, 1.999]), np.diag([1.0, -1.0]))  # -2 + v and 1.999 - v
    assert narrow.stable() == [pytest.approx((1.999, 2.0))]


def test_stiff_tyres_are_ideal_wheels():
    """The difference is of first order in 1/C: tenfold less per decade, and as an independent program has it."""
    wanted, gaps = complexes(TRUTHS["limit_to_whipple"]["whipple_v5"]), []
    for row in TRUTHS["limit_to_whipple"]["rows"][:4]:
        build = partial(whipple, tyres={"cornering": row["ca"], "camber": 1.0, "relaxation": row["sig"]})
        found = on_tyres.eigenvalues(build, P, [5.0])[0]
        gaps.append(max(np.abs(found - s).min() for s in wanted))
        assert gaps[-1] == pytest.approx(row["max_diff"], abs=1e-7)  # 1e-14 of the tyre modes, 1e7 1/s
    assert np.divide(gaps[:-1], gaps[1:]) == pytest.approx(10.0, rel=0.01)


@pytest.mark.parametrize("speed", ["10", "50", "160"])
def test_sharp_1971(speed):
    """Computed to 1e-6 of an eigenvalue; printed to 0.011 1/s and 0.05 rad/s, three digits of a table of 1971."""
    p = named("Sharp1971")
    found = on_tyres.eigenvalues(partial(whipple, **fittings(p)), p, [0.3048 * float(speed)])[0]
    wanted = complexes(TRUTHS["sharp_1971"][speed]["all"])
    assert max(np.abs(found - s).min() / abs(s) for s in wanted) < 1e-8
    _, capsize, weave, weave_w, wobble, wobble_w = next(
        row for row in machines()["Sharp1971"]["printed"]["rows"] if row[0] == float(speed)
    )
    for s in (complex(capsize), complex(weave, weave_w), complex(wobble, wobble_w)):
        near = found[np.argmin(np.abs(found - s))]
        assert abs(near.real - s.real) < 0.011 and abs(near.imag - s.imag) < 0.05


def test_nine_freedoms_and_the_published_radius():
    system = whipple(P, speed=5.0, tyres=BRUSH)
    found = system.check()
    assert (found.configuration_freedom, found.velocity_freedom) == (9, 9)
    run = simulate(system, 1.0, output=2)
    assert run.position("rear wheel")[:, 2] == pytest.approx(P.rR, abs=1e-9)
    loads = [run.force(f"{wheel} tyre").normal[-1] for wheel in ("rear", "front")]
    share = P.front_load * P.mass * P.g
    assert loads == pytest.approx([P.mass * P.g - share, share], abs=1e-4)  # 2e5 N/m times 1e-10 m of the run


def test_history_of_an_independent_program():
    """Two seconds from a lean rate on brush tyres; both agree to 3e-11."""
    rows = TRUTHS["bicycle_on_brush_tyres"]["history"]["rows"]
    found = ride.run(P, 2.0, speed=5.0, lean_rate=0.1, tyres=BRUSH, rtol=1e-11, output=[row["t"] for row in rows])
    hub, table = found.solution.position("rear wheel"), {key: [row[key] for row in rows] for key in rows[0]}
    for key, values in {"lean": found.lean, "steer": found.steer, "yaw": found.heading, "x": hub[:, 0]}.items():
        assert values == pytest.approx(table[key], abs=1e-9), key
    assert -hub[:, 1] == pytest.approx(table["y"], abs=1e-9)
    assert hub[:, 2] == pytest.approx(table["z"], abs=1e-9)
    for wheel, key in (("rear", "zyR"), ("front", "zyF")):
        states = found.solution.force(f"{wheel} tyre").states["lateral"]
        assert states == pytest.approx(-np.array(table[key]), abs=1e-9)
    assert found.solution.certificate.passed and found.solution.certificate["energy balance"].error < 1e-8


def test_braking_lifts_the_rear_wheel():
    """As soon as the deceleration times the height of the centre of mass exceeds its distance from the front wheel."""
    weight = P.mass * P.g
    height = (P.mB * -P.zB + P.mH * -P.zH + P.mR * P.rR + P.mF * P.rF) / P.mass
    ahead = P.w * (1.0 - P.front_load)
    torque = weight * ahead / height * P.rF  # of the ground on the front wheel, at which the rear one is without load
    held = ride.run(P, 0.8, speed=8.0, brake=Pulse(0.85 * torque, 0.1, 0.2), tyres=BRUSH)
    lifted = ride.run(P, 0.8, speed=8.0, brake=Pulse(1.1 * torque, 0.1, 0.2), tyres=BRUSH)
    normal = [found.contacts["rear"].normal for found in (held, lifted)]
    assert 0.0 < normal[0].min() < 0.3 * weight
    assert normal[1].min() == 0.0
    assert lifted.pitch.min() < -0.005


def test_a_slide_on_a_wet_patch():
    """Grip that falls to a tenth for a while: the bicycle slides within the circle, and falls."""
    wet = 0.9 - Pulse(0.85, start=0.8, edge=0.05, duration=3.0)
    found = ride.run(P, 4.0, speed=6.0, lean=0.25, steer=0.1, tyres={**BRUSH, "mu": wet})
    used = np.array([found.solution.force(f"{wheel} tyre").saturation for wheel in ("rear", "front")])
    assert used.max() > 0.99 and used.max() <= 1.0 + 1e-14
    assert found.event.name == "fallen"


@pytest.mark.slow
def test_study_figure_and_command(tmp_path):
    found = stability.study(P, np.linspace(3.0, 8.0, 6), tyres=BRUSH)
    assert {"weave", "capsize", "castering"} <= {*found.names} and len(found.names) == 8
    assert "self-stable between 3 and 8 m/s: 4.49779 ... 6.84322 m/s" in str(found)
    weave = found.mode("weave", 5.0).eigenvalue
    every = complexes(TRUTHS["straight_running"]["rows"][3]["eigenvalues"]["5.0"])
    assert min(abs(weave - s) for s in every) < 1e-9 and abs(abs(weave.imag) - 4.1) < 0.01
    between = found.mode("capsize", 5.3).eigenvalue  # at the speed asked for, not at one of the grid
    assert between == pytest.approx(min(on_tyres.eigenvalues(found.build, P, [5.3])[0], key=abs), abs=1e-9)
    with pytest.raises(ValueError, match="from 3 to 8 m/s"):
        found.mode("weave", 9.0)
    out = ["--from", "3", "--to", "8", "--count", "4", "--tyre", "trail=0", "--out", str(tmp_path)]
    done = CliRunner().invoke(main, ["bicycle", "stability", *out], catch_exceptions=False)
    assert done.exit_code == 0 and "4.25414 ... 5.95697 m/s" in done.output
    assert (tmp_path / "stability_Meijaard2007_tyres.png").exists()


@pytest.mark.parametrize(
    ("tyres", "text"),
    [({"grip": 1.0, "law": 2}, "grip, law unknown"), ([{}], "rear, front"), ({"mu": -1.0}, "rear tyre.*mu"),
     ({"stiffness": 0.0}, "rear tyre.*stiffness: 0.0 is not positive"), ({"stiffness": "hard"}, "stiffness: expected"),
     (9.0, "rear, front"), ({3: 4.0}, "3 unknown")],
)  # fmt: skip
def test_errors(tyres, text):
    with pytest.raises(ValueError, match=text):
        whipple(P, tyres=tyres)


@pytest.mark.parametrize(("x", "share"), [(-0.3, -19.65), (1.2, 113.3)])
def test_a_bicycle_that_tips_is_not_put_on_tyres(x, share):
    """Ideal wheels may be held down; the reason is the same for all studies on tyres."""
    tipping = replace(P, xB=x, name="tipping")
    assert 100.0 * tipping.front_load == pytest.approx(share, rel=1e-3)
    with pytest.raises(ValueError, match=f"'tipping': it tips even at rest, with {share} % of its weight on the front"):
        stability.study(tipping, [3.0, 6.0], tyres={"mu": 0.9})


@pytest.mark.parametrize(
    "row",
    [
        pytest.param(row, marks=[pytest.mark.slow] * (row["lean"] > 0.1))
        for row in TRUTHS["bicycle_on_brush_tyres"]["steady"]
    ],
    ids=lambda row: f"{row['v']} m per s, {row['lean']} rad",
)
def test_steady_turns_of_an_independent_program(row):
    """Which has its y axis to the left and turns to the left where the lean is positive."""
    found = turns_on_tyres.turn(P, BRUSH, speed=row["v"], lean=row["lean"])
    keys = {"steer": "steer", "yaw_rate": "yaw_rate", "steer_torque": "steer_torque", "radius": "radius_rear_hub"}
    for name, key in keys.items():
        assert getattr(found, name) == pytest.approx(row[key], rel=1e-9), name
    assert found.drive_torque == pytest.approx(row["drive_torque_on_rear_wheel"], abs=1e-8)
    assert found.at.position("rear wheel")[0, 2] == pytest.approx(row["z_hub"], abs=1e-11)
    for wheel in ("rear", "front"):
        load, wanted = found.at.force(f"{wheel} tyre"), row[wheel]
        assert load.normal[0] == pytest.approx(wanted["N"], rel=1e-10)
        assert load.longitudinal[0] == pytest.approx(wanted["Fx"], abs=1e-7)
        assert load.lateral[0] == pytest.approx(-wanted["Fy"], rel=1e-9)


@pytest.mark.slow
def test_a_turn_straight_ahead():
    straight = turns_on_tyres.turn(P, BRUSH, speed=5.0, lean=0.0)
    with pytest.raises(ValueError, match="give t_end"):
        replace(straight, x=np.where(np.arange(13) == 4, 0.0, straight.x)).ride()
    assert straight.radius > 1e9 and straight.steer == pytest.approx(0.0, abs=1e-12)
    assert straight.saturation < 1e-9 and straight.steer_torque == pytest.approx(0.0, abs=1e-9)


@pytest.mark.slow
def test_turns_end_at_the_limit_of_grip(tmp_path):
    """And the bicycle rides the whole circle there."""
    found = turns_on_tyres.turns(P, BRUSH, 5.0, np.arange(0.1, 1.3, 0.1))
    assert 0.99 < found[-1].saturation < 1.0 and 0.89 < found[-1].friction < 0.9
    assert found[-1].lean < np.arctan(0.9)
    circle = found[-1].ride(rtol=1e-10)
    way = circle.solution.position("rear wheel")
    # it is unstable there: a hundred roundings grow by exp(6.5 t) in the 3.3 s of the circle, of 2.6 m radius, to 1e-4
    growth = linearize(found[-1].system, found[-1].state).eigenvalues.real.max()
    limit = 100 * np.finfo(float).eps * np.exp(growth * circle.t[-1])
    assert np.linalg.norm(way[-1] - way[0]) < limit * found[-1].radius
    assert np.ptp(circle.lean) < limit < 1e-4 and circle.solution.certificate.passed
    out = ["--speed", "5", "--tyre", "mu=0.3", "--out", str(tmp_path)]
    done = CliRunner().invoke(main, ["bicycle", "circles", *out], catch_exceptions=False)
    assert done.exit_code == 0 and "5 m/s: up to a lean of 16." in done.output


@pytest.mark.slow
def test_turns_are_those_of_both_wheels_whatever_leans_are_asked_for():
    """Slow turns are steered far, and a search from afar ends in wheelies, with less lean."""
    p = named("Rigid")
    fine, coarse = (turns_on_tyres.turns(p, BRUSH, 2.0, np.arange(step, 1.0, step))[-1] for step in (0.025, 0.2))
    assert fine.lean == pytest.approx(coarse.lean, abs=2 * turns_on_tyres.LEAN_STEP_MIN) and coarse.lean > 0.47
    assert min(load.normal[0] for load in fine.forces) > 100.0
    with pytest.raises(ValueError, match=r"none at 2 m/s and a lean of 0.6 rad; those .* end at a lean of 0.47"):
        turns_on_tyres.turn(p, BRUSH, speed=2.0, lean=0.6)


@pytest.mark.slow
def test_a_speed_without_turns_does_not_lose_the_others(tmp_path):
    asked = ["bicycle", "circles", "--tyre", "mu=0.1", "--speed", "6", "--speed", "0.3", "--out", str(tmp_path)]
    done = CliRunner().invoke(main, asked)
    assert done.exit_code == 0 and "6 m/s: up to a lean" in done.output and "none at 0.3 m/s" in done.output
    assert (tmp_path / "Meijaard2007_circles_tyres.csv").exists()
    assert CliRunner().invoke(main, asked[:4] + asked[6:]).exit_code == 2


def test_turns_of_linear_tyres_say_that_grip_has_no_limit(tmp_path, monkeypatch):
    one = turns_on_tyres.turn(P, BRUSH | {"mu": None}, speed=5.0, lean=0.1)
    monkeypatch.setattr(turns_on_tyres, "turns", lambda *_: [one])
    asked = ["bicycle", "circles", "Sharp1971", "--speed", "5", "--out", str(tmp_path)]
    done = CliRunner().invoke(main, asked, catch_exceptions=False)
    assert done.exit_code == 0 and "with no limit of grip and" in done.output


@pytest.mark.parametrize(
    ("name", "given", "wanted"),
    [
        ("HC_Pista", (False, (), None), []),
        ("HC_Pista", (True, ("mu=0.4", "camber_lag=false"), None), ["tyres", "mu0.4", "camber_lagFalse"]),
        ("HC_Pista", (False, (), (1800.0, 2.0)), ["tyres", "head_stiffness1800", "head_damping2"]),
        ("Sharp1971", (False, ("relaxation=0.3",), None), ["tyres", "relaxation0.3"]),
    ],
)
def test_no_ride_replaces_the_files_of_one_on_other_tyres(name, given, wanted):
    assert refitted(named(name), fitted(named(name), *given)) == wanted


def test_a_stiff_head_is_a_rigid_one():
    """The difference is of first order in 1/k; a soft one adds a degree of freedom, a wobble of 4 to 10 Hz."""
    rigid = on_tyres.eigenvalues(partial(whipple, tyres=BRUSH), P, [5.0])[0]
    gaps = []
    for k in (1e6, 1e7, 1e8):
        found = on_tyres.eigenvalues(partial(whipple, tyres=BRUSH, head_stiffness=k), P, [5.0])[0]
        gaps.append(max(np.abs(found - s).min() for s in rigid))
    assert np.divide(gaps[:-1], gaps[1:]) == pytest.approx(10.0, rel=0.05)
    soft = partial(whipple, tyres=BRUSH, head_stiffness=2000.0, head_damping=2.0)
    assert soft(P, speed=5.0).check().configuration_freedom == 10
    wobble = max(on_tyres.eigenvalues(soft, P, [5.0])[0], key=lambda s: s.real)
    assert 4.0 < abs(wobble.imag) / (2.0 * np.pi) < 10.0


def test_a_ride_with_a_soft_head():
    found = ride.run(P, 1.0, speed=5.0, lean=0.1, steer=0.2, tyres=BRUSH, head_stiffness=2e4, head_damping=20.0)
    twist = found.solution.angle("head twist")
    assert found.steer[0] == pytest.approx(0.2) and abs(twist[0]) < 1e-15 and 1e-4 < np.abs(twist).max() < 0.1
    assert found.solution.certificate.passed
    with pytest.raises(ValueError, match="without head_stiffness"):
        whipple(P, head_damping=1.0)
    with pytest.raises(ValueError, match="head_stiffness without tyres"):
        stability.study(P, head_stiffness=2000.0)
