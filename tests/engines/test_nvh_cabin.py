"""Shell and seat: beam in closed form, reciprocity, and a rigid shell as a body of the general model."""

from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.io import wavfile

from engines import closed_forms
from engines.nvh.cabin import checks
from engines.nvh.cabin.seat import Cabin
from engines.nvh.cabin.shell import ModalShell, beam_shell
from engines.nvh.cabin.sound import write_sound
from engines.nvh.cli import nvh
from engines.nvh.excitation import presets
from engines.nvh.excitation.loads import Source
from engines.nvh.mounts import mounts
from engines.nvh.mounts.response import Map

ELASTIC_MODES = 4  # [1] of each kind in a shell made of a beam

BEAM = dict(mass=900.0, roll_inertia=400.0, length=4.1, bending=26.0, lateral=37.0, torsion=31.0, damping=0.02)
RIGID = 6


def test_frequencies_of_a_free_beam():
    shell = beam_shell(**BEAM)
    f = np.sort(shell.rates) / (2 * np.pi)
    squares = (closed_forms.bending_roots(ELASTIC_MODES) / closed_forms.bending_roots(1)[0]) ** 2
    known = [*(26.0 * squares), *(37.0 * squares), *(31.0 * np.arange(1, ELASTIC_MODES + 1))]
    assert f[:RIGID] == pytest.approx(0.0, abs=1e-12)
    # 40 elements: torsion with linear ones is off by (4 pi / 40)^2 / 24 relative to the first mode, bending by less
    assert f[RIGID:] == pytest.approx(np.sort(known), rel=5e-3)


def test_shapes_of_a_free_beam():
    shell, s = beam_shell(**BEAM), np.linspace(0.0, 1.0, 23)
    axis = np.stack([BEAM["length"] * (s - 0.5), 0 * s, 0 * s], axis=1)
    for k, root in enumerate(closed_forms.bending_roots(ELASTIC_MODES)):
        found = next(
            shape(axis)[:, 2] for w, shape in zip(shell.rates, shell.shapes, strict=True)
            if np.isclose(w / (2 * np.pi), 26.0 * (root / closed_forms.bending_roots(1)[0]) ** 2, rtol=1e-3, atol=0)
        )  # fmt: skip
        known = closed_forms.bending_shape(root, s) / np.sqrt(BEAM["mass"])
        assert abs(found @ known) / np.linalg.norm(known) ** 2 == pytest.approx(1.0, rel=1e-4), k
        assert np.linalg.norm(found) == pytest.approx(np.linalg.norm(known), rel=1e-4)
    beside = axis + [0, 0.5, -0.3]
    twist = next(x for w, x in zip(shell.rates, shell.shapes, strict=True) if np.isclose(w / (2 * np.pi), 31.0))(beside)
    known = closed_forms.torsion_shape(1, s) / np.sqrt(BEAM["roll_inertia"])
    assert np.abs(twist[:, 2]) == pytest.approx(0.5 * np.abs(known), abs=1e-3 * np.abs(known).max())
    assert twist[:, 1] == pytest.approx(0.6 * twist[:, 2]) and not twist[:, 0].any()


def test_forces_and_motions_of_the_shell_are_reciprocal():
    shell, a, b = beam_shell(**BEAM), np.array([[1.2, 0.4, -0.1]]), np.array([[-0.3, 0.1, 0.5]])
    w = np.array([90.0, 260.0])
    a, b = shell.at(a), shell.at(b)
    assert shell.receptance(w, a, b) == pytest.approx(np.swapaxes(shell.receptance(w, b, a), 1, 2), rel=1e-12, abs=0)


@pytest.mark.parametrize(("car", "engine"), [("compact", "inline_3"), ("saloon", "boxer_4")])
def test_a_rigid_shell_is_a_body_of_the_general_model(car, engine):
    """Shell, powertrain and spinning rotor as bodies on bushings: the same acceleration of the seat."""
    ((found, known),) = checks.rigid_shell(car, engine).values()
    assert found == pytest.approx(known, rel=1e-6, abs=1e-9)


def test_paths_add_up_and_a_stiffer_shell_is_felt_less():
    held = checks.held_in("saloon", "v6_90")
    found = held.answer(Source(presets.preset("v6_90")), [1500.0])
    car = mounts.car("saloon")
    cabin, heavy = Cabin(car, held), Cabin(replace(car, shell=car.shell | {"mass": 1e9, "roll_inertia": 1e9}), held)
    assert cabin.paths(found).sum(axis=(2, 3)) == pytest.approx(cabin.seat(found), abs=1e-15)
    assert not cabin.seat(found)[:, 0].any()
    # a shell of great mass stands still: forces are those on fixed feet, acceleration is their sum over the mass
    assert np.abs(heavy.seat(found)).max() < 1e-4 * np.abs(cabin.seat(found)).max()


def test_a_mode_at_the_frequency_of_an_order_is_heard():
    """One mode of frequency f: the receptance at resonance is 1 / (2 i z w^2) times the shapes."""
    w, at = 2 * np.pi * 40.0, np.array([[1.0, 2.0, 3.0]])
    shell = ModalShell(np.array([w]), np.array([0.05]), [lambda x: 2.0 * x])
    there = shell.at(at)
    assert shell.receptance([w], there, there)[0] == pytest.approx(4 * np.outer(at, at) / (2j * 0.05 * w**2))


def test_the_sound_of_one_order_rises_with_the_speed(tmp_path):
    speeds, orders = np.linspace(900.0, 6000.0, 7), np.array([0.0, 0.5, 1.0, 1.5, 2.0])
    found = Map(speeds, orders, *(np.zeros((7, 5, 1, 3)),) * 3)
    seat = np.zeros((7, 5, 3), dtype=complex)
    seat[:, 4, 2] = 1.0
    rate, samples = wavfile.read(write_sound(found, seat, tmp_path / "order.wav"))
    assert samples.dtype == np.int16 and samples.size == int(rate * 8.0)
    crossings = np.diff(np.signbit(samples)).sum() / 2
    assert crossings == pytest.approx(2 * speeds.mean() / 60 * 8.0, abs=1)


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: beam_shell(**BEAM | {"bending": 0.0}), "shell: bending"),
        (lambda: beam_shell(**BEAM | {"damping": -0.1}), "damping of mode"),
        (lambda: ModalShell(np.ones(2), np.ones(1), []), "2 rates, 1 dampings, 0 shapes"),
        (lambda: Cabin(mounts.car("bench"), checks.held_in("bench", "single")), "its shell is not known"),
    ],
)
def test_shells_that_cannot_be_are_refused(call, text):
    with pytest.raises(ValueError, match=text):
        call()


def test_a_sound_is_a_wave_file():
    found = CliRunner().invoke(nvh, ["single", "--car", "compact", "--sound", "x.mp3"])
    assert "--sound 'x.mp3'; give a file that ends in .wav" in str(found.exception)


def test_sound_needs_a_shell():
    found = CliRunner().invoke(nvh, ["single", "--car", "bench", "--sound", "x.wav"])
    assert "give compact or saloon" in str(found.exception)
