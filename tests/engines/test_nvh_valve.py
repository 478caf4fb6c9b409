"""Valves on cams: laws in closed form, float, the contact against the constraint, surge, cams with a cusp."""

from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from engines.closed_forms import cams
from engines.nvh.cli import nvh
from engines.nvh.valvetrain.cam import Cam, RollerCam, cam
from engines.nvh.valvetrain.report import Valve
from engines.nvh.valvetrain.train import Train
from mbsd3d import SlideDriver, System, linearize

LAWS = ("cycloidal", "harmonic", "polynomial")
FOLLOWERS = ("flat", "roller", "barrel")

LIFT, HALF, BASE = 0.0083, np.radians(72.0), 0.0285
KNOWN = {"cycloidal": cams.cycloidal, "harmonic": cams.harmonic}
ANGLE = np.linspace(-np.pi, np.pi, 20001)


def train(law: str = "cycloidal", follower: str = "flat", **changes: object) -> Train:
    return Train(cam(law, LIFT, HALF, BASE, follower), mass=0.13, rate=31e3, preload=270.0, **changes)


def test_the_outline_under_a_roller_is_that_of_theory():
    chosen = cam("harmonic", LIFT, HALF, BASE, "roller")
    angle = 2 * np.pi * np.arange(720) / 720 - np.pi
    s, ds, _ = cams.harmonic(angle, LIFT, HALF)
    known = -cams.roller_cam(angle, s, ds, BASE + chosen.roller, chosen.roller)  # the nose down
    # slopes of the spline where the acceleration of the law jumps: its jump, 0.022 m, times h / 8, and less elsewhere
    assert chosen.outline[:-1, 1:] == pytest.approx(known, abs=3e-5)


def test_a_roller_touches_the_rim_of_its_drum_from_its_radius():
    """Nearest point of the rim to the middle of the roller, by distances alone."""
    chosen = cam("cycloidal", LIFT, HALF, BASE, "barrel")
    points, fine = chosen.outline, np.radians([171.2, 140.1, 200.3])
    for turn in fine:
        c, s = np.cos(turn), np.sin(turn)
        at = points @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T
        middle = np.array([chosen.base, 0.0, chosen.spline((turn + np.pi) % (2 * np.pi))])
        # points stand 0.25 mm apart: half of it across a distance of 9 mm is 1e-6 m
        assert np.linalg.norm(at - middle, axis=1).min() == pytest.approx(chosen.roller, abs=1e-6)


@pytest.mark.parametrize("follower", ["roller", "barrel"])
def test_a_roller_in_contact_is_pushed_aside_as_on_the_constraint(follower):
    chosen = train(follower=follower, rpm=1300.0)
    run, still = chosen.free(), chosen.held()
    assert run.certificate.passed and not still.certificate.notes
    force, held = run.force("contact").force, still.reaction("cam").force
    size = held[:, 2].max()
    # it swings in its contact, as a face does
    assert np.abs(force - held).max() < 0.03 * size and np.abs(held[:, 1]).max() > 0.1 * size
    # frictionless: at right angles to the way of the roller's middle on its cam
    slope = chosen.cam.spline(np.mod(np.pi + chosen.turn * run.t, 2 * np.pi), 1)
    arm = chosen.cam.base if follower == "barrel" else -run.position("valve")[:, 2]
    assert force[:, 1] == pytest.approx(force[:, 2] * slope / arm, abs=1e-9 * size)
    assert run.effort("motor") == pytest.approx(force[:, 2] * slope, abs=1e-9 * size * LIFT)


def test_a_valve_that_floats_flies_as_one_equation_says():
    chosen = train("harmonic", "barrel")
    chosen = replace(chosen, rpm=1.02 * chosen.floats_at())
    run = chosen.free()
    numbers = (chosen.rate, chosen.preload), (chosen.contact, chosen.damping)
    known = cams.bounce(lambda angle: cams.harmonic(angle, LIFT, HALF), chosen.turn, chosen.mass, *numbers, run.t)
    # lift by a spline whose slope is 3e-5 off where the acceleration jumps; blows hand on 1e-6 of the lift
    assert run.position("valve")[:, 2] == pytest.approx(known, abs=1e-5 * LIFT)
    assert "lifts off" in chosen.held().certificate.notes[0]


@pytest.mark.parametrize("law", KNOWN)
def test_the_spline_of_a_cam_has_the_derivatives_of_its_law(law):
    spline = cam(law, LIFT, HALF, BASE).spline
    # away from the ends of the lift, where the acceleration of a harmonic cam jumps; s'' is a line over half a degree:
    # h^2 / 8 (2 pi / half)^2 = 2.4e-4 at most
    inside = (np.abs(ANGLE) < 0.9 * HALF) & (np.abs(ANGLE) > 1e-3)
    for order, known in enumerate(KNOWN[law](ANGLE[inside], LIFT, HALF)):
        found = spline(np.mod(ANGLE[inside], 2 * np.pi), order)
        assert found == pytest.approx(known, abs=3e-4 * np.abs(known).max())


def test_a_cam_pushes_up_its_flat_follower():
    """The highest point of the turned outline is the height of the follower, beside the axis by s'."""
    chosen = cam("polynomial", LIFT, HALF, BASE)
    for turn in np.radians([-61.2, -20.1, 3.3, 47.2, 130.1]):
        _, x, y = -chosen.outline.T  # the nose up
        # across is y of the world, a turn about x takes y towards z
        across, up = x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn)
        top = up.argmax()
        # points stand half a degree apart, up to 0.3 mm: half of it to the side, 1e-6 m below the top
        assert up[top] == pytest.approx(BASE + chosen.spline(turn % (2 * np.pi)), abs=2e-6)
        assert across[top] == pytest.approx(chosen.spline(turn % (2 * np.pi), 1), abs=3e-4)


@pytest.mark.parametrize("law", KNOWN)
def test_a_multiplier_says_when_the_valve_floats(law):
    chosen = train(law)
    s, _, dds = KNOWN[law](ANGLE, LIFT, HALF)
    known = 30 / np.pi * cams.float_rate(chosen.mass, chosen.rate, chosen.preload, s, dds)
    assert chosen.floats_at() == pytest.approx(known, rel=1e-4)
    for share, sign in ((0.99, 1), (1.01, -1)):
        assert np.sign(replace(chosen, rpm=share * known).pushed().min()) == sign


def test_harmonic_cams_float_at_the_nose():
    chosen = train("harmonic")
    known = np.sqrt((chosen.preload + chosen.rate * LIFT) * 2 * HALF**2 / (chosen.mass * LIFT * np.pi**2))
    assert chosen.floats_at() == pytest.approx(30 / np.pi * known, rel=1e-4)


def test_below_float_the_contact_does_what_the_constraint_does():
    chosen = train(rpm=1500.0)
    run = chosen.free()
    assert run.certificate.passed
    still, force = chosen.held(), run.force("contact").force[:, 2]
    held = chosen.pushed()
    # the valve swings on the contact at 2.4 kHz, which the cam hardly excites
    assert np.abs(force - held).max() < 0.03 * held.max()
    # and sinks in by F / k
    assert chosen.gap(run) == pytest.approx(-force / chosen.contact, abs=0.02 * held.max() / chosen.contact)
    # the cam bears the torque -F s'
    slope = chosen.cam.spline(np.mod(np.pi + chosen.turn * run.t, 2 * np.pi), 1)
    assert run.effort("motor") == pytest.approx(force * slope, abs=1e-9 * np.abs(force * slope).max())
    # as in the constraint, but at the nose, where the third derivative of the lift jumps
    assert still.effort("motor") == pytest.approx(held * slope, abs=3e-5 * np.abs(held * slope).max())


def test_beyond_float_the_valve_leaves_the_cam_and_comes_back_hard():
    chosen = train()
    chosen = replace(chosen, rpm=1.1 * chosen.floats_at())
    run = chosen.free()
    gap = chosen.gap(run)
    assert run.certificate.passed and gap.max() > 1e-4
    assert run.force("contact").force[:, 2].max() > 1.5 * chosen.pushed().max()
    # off the cam nothing but the spring acts
    up = run.acceleration("valve")[:, 2]
    height = run.position("valve")[:, 2] - BASE
    off = gap > 1e-6
    assert up[off] == pytest.approx(-(chosen.preload + chosen.rate * height[off]) / chosen.mass, rel=1e-9)


def test_a_spring_of_pieces_surges_at_its_frequencies():
    chosen = train(pieces=6, loss=0.0)
    bodies, (bearing, _, guide, *guides), forces = chosen.parts
    still = SlideDriver(guide, 0.0, name="closed")
    system = System(bodies, [bearing, guide, *guides, still], forces, gravity=(0, 0, 0))
    found = np.unique(np.abs(linearize(system).eigenvalues.imag).round(6))
    assert found[found > 1.0] == pytest.approx(cams.surge(chosen.coils, chosen.rate, 6), rel=1e-6)
    continuous = np.pi * np.sqrt(chosen.rate / chosen.coils)
    # the ends of n pieces are worth half a piece, and the next order is 1/n^2
    assert cams.surge(chosen.coils, chosen.rate, 400)[0] == pytest.approx(continuous * (1 - 0.5 / 400), rel=1 / 400**2)


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: cam("cycloidal", LIFT, HALF, 0.012), "a cusp; give a base above"),
        (lambda: cam("flat", LIFT, HALF, BASE), "there are cycloidal"),
        (lambda: cam("harmonic", LIFT, HALF, BASE, "ball"), "follower 'ball' is unknown; there are flat, roller"),
        (lambda: Valve("harmonic", 1.0).train, "rpm 1; give 100 or more"),
        (lambda: RollerCam(np.full(20, 0.001), BASE, roller=0.0), "cam: roller"),
        (lambda: cam("cycloidal", LIFT, 0.2, BASE, "roller"), "a cusp; give a roller below"),
        (lambda: cam("cycloidal", LIFT, 0.2, BASE, "barrel"), "a cusp; give a roller below"),
        (lambda: cam("harmonic", -LIFT, HALF, BASE), "cam: lift"),
        (lambda: cam("harmonic", LIFT, 4.0, BASE), "half a turn"),
        (lambda: Cam(np.zeros(5), BASE), "8 or more"),
        (lambda: Cam(np.full(20, np.nan), BASE), "finite"),
        (lambda: train(rpm=0.0), "valve: rpm"),
        (lambda: train(damping=-0.1), "valve: damping"),
        (lambda: train(pieces=1.5), "whole number"),
    ],
)
def test_cams_and_valves_that_cannot_be_are_refused(call, text):
    with pytest.raises(ValueError, match=text):
        call()


def test_the_base_that_an_error_asks_for_is_enough():
    with pytest.raises(ValueError, match="above") as error:
        cam("cycloidal", LIFT, HALF, 0.012)
    base = 1e-3 * float(str(error.value).split("above ")[1].split()[0])
    assert cam("cycloidal", LIFT, HALF, base + 1e-5).radius.min() > 0


def test_the_command_line_knows_all_followers():
    """Each can be built by the name that the option takes."""
    (option,) = (x for x in nvh.params if x.name == "follower")
    assert tuple(option.type.choices) == FOLLOWERS
    assert all(cam("harmonic", LIFT, HALF, BASE, follower) for follower in FOLLOWERS)


@pytest.mark.slow
@pytest.mark.parametrize(("law", "follower"), list(zip(LAWS, FOLLOWERS, strict=True)))
def test_the_command_shows_what_floats(law, follower, tmp_path):
    found = CliRunner().invoke(nvh, ["--valve", law, "--follower", follower, "--page", str(tmp_path)])
    assert found.exit_code == 0, found.output
    assert "floats from" in found.output and "lifts off" in found.output
    name = f"valve-{law}" + ("" if follower == "flat" else f"-{follower}")
    assert (tmp_path / f"{name}.html").stat().st_size > 1e4
