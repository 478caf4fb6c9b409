"""Powertrains on mounts: closed forms, mean crank train, linear map against the full motion, torque-roll axis."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from engines.balance import phasor
from engines.nvh.cli import nvh
from engines.nvh.excitation import presets
from engines.nvh.excitation.loads import Source
from engines.nvh.mounts import checks, mounts
from engines.nvh.mounts import roll_axis as roll_axis_module
from engines.nvh.mounts.powertrain import equivalent
from engines.nvh.mounts.response import OnMounts
from engines.nvh.mounts.rigid_modes import rigid_modes, sag
from engines.nvh.mounts.roll_axis import decouple, roll_axis, roll_share, stiffness_matrix
from engines.nvh.study import Study
from engines.nvh.tables import why
from mbsd3d import inertia
from mbsd3d.extend import main as mbsd3d

FORMS = (
    lambda: checks.one_freedom(np.array([0.7, 4.1, 5.5, 9.3, 41.0])),
    checks.bounce_and_pitch,
    checks.three_coupled,
    lambda: checks.spinning_rotor(730.0),
)


def placed_of(engine: str, car: str) -> tuple:
    """(equivalent, mounts) of an engine in a car."""
    body = equivalent(presets.preset(engine))
    return body, mounts.mounts(mounts.car(car), presets.preset(engine), body.mass)


@pytest.mark.parametrize("form", FORMS)
def test_simple_powertrains_move_as_theory_says(form):
    for computed, exact in form().values():
        assert np.abs(computed - exact).max() < 1e-8 * np.abs(exact).max()


def test_mass_and_place_of_the_mean_crank_train():
    """Pistons stand on average at a_0 of their series, all that turns with the pin stands on the axis."""
    chosen = presets.preset("inline_3")
    engine, found = chosen.engine(1000.0), equivalent(chosen)
    n, flywheel = 3, 2 * chosen.flywheel / max(2.2 * engine.radius, 0.09) ** 2
    mass = chosen.block.mass + flywheel + n * (chosen.throw_mass + chosen.rod_mass + chosen.piston_mass)
    assert found.mass == pytest.approx(mass, rel=1e-12)
    up = chosen.block.mass * chosen.block.com[2] + n * phasor.reciprocating(engine) * phasor.place(engine, 3)[0]
    # harmonics from the 12th on fold back onto the mean of 12 angles
    assert found.com[2] == pytest.approx(up / mass, rel=1e-9)


def test_powertrain_and_rotor_together_are_the_locked_body():
    found = equivalent(presets.preset("inline_3"))
    whole = inertia.combine([(body.mass, body.com, body.inertia) for body in found.bodies])
    assert whole.mass == pytest.approx(found.mass, rel=1e-14)
    assert whole.com == pytest.approx(found.rigid.com, abs=1e-14)
    assert whole.inertia == pytest.approx(found.rigid.inertia, abs=1e-13)  # of some kg m^2


def test_momentum_of_the_mean_crank_train():
    """H / w of crank, flywheel, and of pistons and rods as two masses each and the defect J: mean of J phi' is none."""
    chosen = presets.preset("boxer_4")
    engine, found = chosen.engine(1000.0), equivalent(chosen)
    throw = chosen.throw_mass * (0.8 * engine.radius**2 + engine.crank_centre**2)
    pins = (1 - engine.rod_fraction) * engine.rod_mass * engine.radius**2
    assert found.rotor == pytest.approx(chosen.flywheel + 4 * (throw + pins), rel=1e-9)


def test_the_dynamic_stiffness_is_linear_in_the_speed():
    body, placed = placed_of("inline_3", "compact")
    held = OnMounts(body, placed, 70.0)
    W = np.array([20.0, 90.0, 400.0])
    known = held.model(260.0).frequency_response(W).H[:, :6]
    assert held.receptance(260.0, W) == pytest.approx(known, abs=1e-9 * np.abs(known).max())
    assert np.abs(known - held.receptance(0.0, W)).max() > 0.01 * np.abs(known).max()


@pytest.mark.parametrize(("engine", "car", "rpm", "load"), [("single", "motorcycle", 5200.0, 0.0),
                                                            ("inline_3", "compact", 2900.0, 0.6)])  # fmt: skip
def test_linear_map_and_full_motion_agree(engine, car, rpm, load):
    study = Study(presets.preset(engine), mounts.car(car), rpm, load)
    assert study.run.certificate.passed
    # the mass matrix changes by the pistons' share of the mass, 1 % of it, twice a turn
    assert study.difference < 3e-3 and why(study) == ""


def test_near_resonance_it_is_said_where_full_motion_and_map_part():
    study = Study(presets.preset("single"), mounts.car("motorcycle"), 1500.0)
    order, mode, share = study.nearest
    assert study.difference > 0.01 and order == 1.0
    # the mode is excited from below or above: its share in closed form, by the modes of the powertrain at rest
    damped = [
        (abs(2j * z / (1 - (25.0 / f) ** 2 + 2j * z * 25.0 / f)), f)
        for f, z in ((m.frequency, 0.06 * m.frequency / study.car.bounce) for m in study.modes)
    ]
    known, at = max(damped)
    # rolled by the mean torque, with a crank that spins and has no share in the roll
    assert mode == pytest.approx(at, rel=0.1) and share == pytest.approx(known, rel=0.4) and share > 0.2
    size, off = study.differences
    assert why(study).startswith(f"most in 1x, 25.0 Hz, by {off.max():.2g} N, beside a mode of")
    assert "neighbours" not in why(study) and off.max() < size[off.argmax()]


def test_an_order_that_the_map_has_not_comes_from_its_neighbours():
    """A balanced engine rolled by its torque: what is left is a hundredth of a newton."""
    study = Study(presets.preset("boxer_6"), mounts.car("compact"), 4125.0)
    order, _, share = study.nearest
    assert order == 2.0 and share < 0.2
    assert np.abs(study.here.load[0, np.flatnonzero(study.here.orders == 2.0)]).max() < 1e-6 * study.source.mean_torque
    assert why(study).endswith("off resonance; moving masses turn its neighbours into it")


def test_a_sweep_is_the_full_motion_at_each_speed():
    study = Study(presets.preset("single"), mounts.car("motorcycle"), 5200.0, 0.0)
    found = study.sweep(3)
    assert found.map.rpm == pytest.approx(np.linspace(study.preset.idle, study.preset.redline, 3))
    last = replace(study, rpm=study.preset.redline)
    # the sweep has fewer samples of the same motion, in other steps of a tolerance of 1e-8
    assert found.full[-1] == pytest.approx(last.run_force, abs=1e-5 * np.abs(last.run_force).max())
    assert found.off[1:].max() < 5e-3
    assert found.off[-1] == pytest.approx(last.difference, abs=1e-5)


def test_without_the_spin_of_the_crank_the_map_misses_the_full_motion():
    """A light block with a heavy flywheel: the full run is nearer to the map with the gyroscopic terms."""
    study = Study(replace(presets.preset("inline_3"), flywheel=0.6), mounts.car("compact"), 2000.0, 0.0)
    blind = replace(study.on_mounts, gyroscopic=False).answer(study.source, [study.rpm])
    off = np.abs(study.run_force[1:] - blind.force[0, 1:]).max()
    assert off > 10 * study.differences[1].max()


def test_mounts_in_one_place_hold_nothing(tmp_path):
    own = {name: dict(at=[0, 0, 0], rates=[1e5, 1e5, 1e5], damping=[1, 1, 1], angle=0) for name in "abc"}
    file = tmp_path / "it.json"
    file.write_text(json.dumps(dict(title="it", bounce=None, mounts=own)), encoding="utf-8")
    found = CliRunner().invoke(nvh, ["single", "--car", str(file)])
    assert "3 mounts leave 3 motions free; give three that are not in line" in str(found.exception)


def test_mean_torque_and_mounts_balance():
    body, placed = placed_of("inline_4", "compact")
    held = OnMounts(body, placed, 150.0)
    rest = held.rest
    assert held.roll < 0.0  # against the crank
    stiffness = stiffness_matrix(body.rigid, placed)
    turned = np.linalg.solve(stiffness, [0, 0, 0, -150.0, 0, 0])
    # the roll of half a degree is large enough for 1 % of second order
    assert held.roll == pytest.approx(turned[3], rel=0.02)
    assert np.linalg.norm(rest[3:]) == pytest.approx(1.0)


@pytest.mark.parametrize(("engine", "car"), [("inline_4", "compact"), ("boxer_4", "saloon")])
def test_sag_is_weight_over_stiffness(engine, car):
    body, placed = placed_of(engine, car)
    shift, turn = sag(body.rigid, placed)
    weight = np.array([0, 0, -9.81 * body.mass, 0, 0, 0])
    known = np.linalg.solve(stiffness_matrix(body.rigid, placed), weight)
    # mounts turn the load they carry through the angle of the sag, 0.002 rad
    assert np.concatenate([shift, turn]) == pytest.approx(known, abs=0.01 * np.abs(known).max())


def test_shares_of_kinetic_energy_add_up_and_modes_are_those_of_stiffness_and_mass():
    body, placed = placed_of("v6_90", "saloon")
    found = rigid_modes(body.rigid, placed)
    M = np.diag([body.mass] * 3 + [0.0] * 3)
    M[3:, 3:] = body.rigid.inertia
    values = np.linalg.eigvals(np.linalg.solve(M, stiffness_matrix(body.rigid, placed)))
    known = np.sort(np.sqrt(values.real)) / (2 * np.pi)
    assert [mode.frequency for mode in found] == pytest.approx(known, rel=1e-9)
    assert all(mode.shares.sum() == pytest.approx(1.0) for mode in found)


def test_a_decoupled_powertrain_turns_about_its_torque_roll_axis_alone():
    body, placed = placed_of("inline_4", "compact")
    found = decouple(body.rigid, placed)
    assert roll_share(body.rigid, placed)[0] < 0.9
    assert roll_share(body.rigid, found.mounts)[0] == pytest.approx(1.0, abs=1e-12)
    assert found.moved <= 0.15 and found.rates <= 2.0
    for old, new in zip(placed, found.mounts, strict=True):  # of one rubber: damping goes with the rates
        assert np.divide(new.damping, old.damping) == pytest.approx(np.divide(new.rates, old.rates))
    bare = [replace(mount, damping=(0.0, 0.0, 0.0)) for mount in found.mounts]
    K, M = stiffness_matrix(body.rigid, bare), np.zeros((6, 6))
    M[:3, :3], M[3:, 3:] = body.mass * np.eye(3), body.rigid.inertia
    for w in (20.0, 47.0, 130.0):
        moved = np.linalg.solve(K - w**2 * M, [0, 0, 0, 1.0, 0, 0])
        axis = moved[3:] / np.linalg.norm(moved[3:])
        assert np.abs(np.cross(axis, roll_axis(body.rigid))).max() < 1e-9
        assert np.linalg.norm(moved[:3]) < 1e-9 * np.linalg.norm(moved[3:])


@pytest.mark.parametrize(("engine", "car", "left"), [("inline_4", "saloon", 1e-12), ("inline_4", "bench", 0.027)])
def test_decoupling_ends_where_it_can_and_where_it_cannot(engine, car, left, monkeypatch):
    """Mounts of the saloon get there in few steps; those of the bench may not go far enough, and it is soon known."""
    asked, bare = [], roll_axis_module.left_over
    monkeypatch.setattr(roll_axis_module, "left_over", lambda *given: asked.append(1) or bare(*given))
    body, placed = placed_of(engine, car)
    found = decouple(body.rigid, placed)
    assert found.after < left < found.before
    assert len(asked) < 5000  # 18 and 24 numbers to find; 50000 without an end


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: checks.mount((0, 0, 0), (1e5, 0.0, 1e5)), r"rates\[1\]"),
        (lambda: checks.mount((0, 0, 0), (1e5, 1e5, 1e5), -1e-3), r"damping\[0\]"),
        (lambda: mounts.car("tank"), "car 'tank' is unknown; there are compact"),
        (lambda: Study(presets.preset("single"), mounts.car("bench"), 9001.0), "beyond the redline"),
        (lambda: Study(presets.preset("single"), mounts.car("bench"), 0.0), "rpm"),
        (lambda: Study(presets.preset("single"), mounts.car("bench"), 1e-9), "idles at 1500; give 150 up"),
        (lambda: Study(presets.preset("single"), mounts.car("bench"), 900.0).sweep(1), r"give 2 \.\.\. 1000"),
        (lambda: Study(presets.preset("single"), mounts.car("bench"), 3000.0, 1.5), "load 1.5"),
        (lambda: decouple(checks.mounted([]).bodies[0], [], reach=0.0), "reach"),
        (lambda: decouple(checks.mounted([]).bodies[0], [], factor=1.0), "leaves the rates as they are"),
        (
            lambda: OnMounts(*placed_of("single", "bench")).answer(Source(presets.preset("single")), [-100.0, 500.0]),
            "give speeds above 0",
        ),
        (
            lambda: rigid_modes(checks.mounted([]).bodies[0], [checks.mount((0.1, 0, z), (1e5,) * 3) for z in (0, 1)]),
            "1 motions free; give three that are not in line",
        ),
    ],
)
def test_impossible_mounts_and_speeds_are_refused(call, text):
    with pytest.raises(ValueError, match=text):
        call()


def test_the_command_names_what_there_is():
    listed = CliRunner().invoke(nvh, ["--list"])
    assert listed.exit_code == 0
    assert all(name in listed.output for name in (*presets.names(), *mounts.names()))
    missing = CliRunner().invoke(mbsd3d, ["nvh", "v9"])
    assert missing.exit_code == 2 and "there are single" in missing.output


@pytest.mark.slow
def test_the_command_writes_a_page(tmp_path):
    found = CliRunner().invoke(nvh, ["single", "--car", "motorcycle", "--rpm", "4000", "--page", str(tmp_path)])
    assert found.exit_code == 0, found.output
    assert "modes on the mounts" in found.output and "main 2" in found.output
    page = (tmp_path / "single-motorcycle.html").read_text(encoding="utf-8")
    places = re.findall(r'<a href="#(\w+)">', page)
    assert len(places) >= 4 and re.findall(r'<section class="whole" id="(\w+)">', page) == places
    assert page.count("<main>") == 1
    assert (
        page.count("<svg") == 6
        and "single-motorcycle-view.html" in page
        and "http://" not in page.replace("http://www.w3.org", "")
    )
    assert (tmp_path / "single-motorcycle-view.html").stat().st_size > 1e5
