"""What a plane can say: verdicts follow from what is measured, and planar models are exact where they should be."""

import re
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from helpers.page_limits import DOCS

from engines.nvh.cabin.seat import Cabin
from engines.nvh.cli import nvh
from engines.nvh.control.cancel import Cancel
from engines.nvh.excitation import presets
from engines.nvh.excitation.loads import Source
from engines.nvh.mounts import checks, mounts
from engines.nvh.mounts.powertrain import Equivalent
from engines.nvh.mounts.response import OnMounts
from engines.nvh.planar_cross_check import Planes, verdict
from engines.nvh.planar_model import Flat, front_view
from engines.nvh.road.guide import Guide

VERDICT = re.compile(r"[ |](?:exact|approximate|impossible)  ?")


@pytest.fixture(scope="module")
def planes():
    return Planes(mounts.car("saloon"))


def test_cylinders_in_planes_of_their_own_are_summed_exactly(planes):
    for line in (planes.block(), planes.bearings()):
        assert line.verdict == "exact" and float(line.size) < 1e-10
        assert 0 < line.plane and 0 < line.space


def test_a_plane_has_no_couple_and_no_gyroscopic_term(planes):
    assert [line.verdict for line in (planes.couple(), planes.roll(), planes.spin())] == 3 * ["impossible"]
    assert float(planes.couple().size.split()[0]) > 100.0
    assert float(planes.roll().size.split()[0]) > 0.5


def test_modes_across_the_crank_are_near():
    line = Planes(mounts.car("bench")).modes()
    assert line.verdict == "approximate" and float(line.size.split("%")[0]) < 20.0


@pytest.fixture(scope="module")
def mirrored() -> OnMounts:
    """A powertrain that is its own mirror image in the plane across the crank, its crank without spin."""
    body = Equivalent(190.0, np.array([0.0, 0.03, 0.08]), np.array([[6.3, 0, 0], [0, 11.9, 0.7], [0, 0.7, 13.1]]), 0.0)
    spots = ((0.15, -0.2, (1.1e5, 1.4e5, 2.3e5)), (-0.24, 0.05, (0.9e5, 1.2e5, 1.7e5)))
    return OnMounts(body, [checks.mount((x, y, z), k, 0.003) for y, z, k in spots for x in (-0.3, 0.3)])


def test_a_plane_is_exact_for_a_mirror_image(mirrored):
    """Modes, path of an actuator pair in the middle, and the seat through a shell that is symmetric, too."""
    flat, source, rpm = Flat(mirrored), Source(presets.preset("inline_4"), 0.6), np.array([900.0, 2700.0])
    space = np.sort(np.abs(mirrored.model(0.0).poles.imag))
    known = np.linalg.eigvals(np.block([[np.zeros((3, 3)), np.eye(3)], [
        -np.linalg.solve(flat.mass, flat.heads.T @ part @ flat.heads) for part in flat.rates]]))  # fmt: skip
    for value in np.abs(known.imag):
        assert np.abs(space - value).min() < 1e-10 * value
    car = mounts.car("compact")
    car = replace(car, shell=car.shell | {"engine": [1.3, 0.0, -0.05], "seat": [-0.2, 0.0, -0.3]})
    cabin, found = Cabin(car, mirrored), mirrored.answer(source, rpm)
    out = np.delete(np.arange(6), (1, 2, 3))  # all but y, z and about x
    assert not np.abs(found.load[..., out]).max() > 1e-9 * np.abs(found.load).max()
    seat = cabin.seat(found) @ cabin.axes
    plane = flat.seat(cabin, rpm, found.orders, found.load)
    assert plane == pytest.approx(seat[..., 1:], rel=1e-6, abs=1e-9 * np.abs(seat).max())
    assert np.abs(seat[..., 0]).max() < 1e-9 * np.abs(seat).max()


def test_an_actuator_in_the_plane_has_the_path_of_the_plane(mirrored):
    """One mount more in the plane itself, with the actuator beside it."""
    held = OnMounts(mirrored.body, [*mirrored.placed, checks.mount((0.0, 0.1, -0.25), (1e5, 1.3e5, 2.1e5), 0.004)])
    cancel = Cancel(held, Source(presets.preset("inline_4"), 0.6), 2400.0, 4, 2.0, 1800.0)
    path = Flat(held).path(cancel)
    assert path.gain(cancel.W) == pytest.approx(cancel.path.gain(cancel.W), rel=1e-10)
    assert path.limit(cancel.W) == pytest.approx(cancel.path.limit(cancel.W), rel=1e-9)


def test_the_front_view_is_exact_for_arms_that_turn_about_x():
    """The tie rod goes parallel to the lower arm: no toe, all in the plane."""
    lower, upper = ((0.37, 0.18), (0.7, 0.155)), ((0.46, 0.45), (0.66, 0.47))
    links = {
        f"{name} arm, {end}": ((x, *ends[0]), (0.0, *ends[1]))
        for name, ends in (("lower", lower), ("upper", upper)) for end, x in (("front", 0.13), ("rear", -0.21))
    }  # fmt: skip
    links["tie rod"] = ((-0.14, *lower[0]), (-0.14, *lower[1]))
    held = Guide("flat", (0.0, 0.755, 0.3), links, ((0.0, 0.5, 0.72), (0.0, 0.64, 0.18)))
    z = held.curves.z
    camber, ratio = front_view(held, z)
    assert camber == pytest.approx(held.curves.camber, abs=1e-9) and np.ptp(held.curves.camber) > 0.02
    assert np.abs(held.curves.toe).max() < 1e-9
    # second differences over uneven steps of the sine that lifts the wheel
    assert ratio[1:-1] == pytest.approx(held.curves.ratio[1:-1], abs=1e-4)
    assert np.gradient(ratio, z)[2:-2] == pytest.approx(held.curves.bend[2:-2], abs=1e-2)
    assert np.ptp(held.curves.bend) > 0.1


def test_what_moves_out_of_the_plane_is_near(planes):
    active, cabin, guides = planes.active(), planes.cabin(), planes.guides()
    assert [line.verdict for line in (active, cabin, *guides)] == [
        "approximate",
        "approximate",
        "approximate",
        "approximate",
        "impossible",
        "impossible",
    ]
    assert all(0 < line.space for line in (active, cabin, *guides)) and 0 < cabin.plane
    assert planes.shafts().verdict == planes.valve().verdict == "exact"


def test_a_difference_decides_the_verdict():
    assert verdict(-1e-3) == "approximate" and verdict(1e-7) == "exact"


@pytest.mark.slow
def test_the_table_of_the_command_is_that_of_the_page():
    run = CliRunner().invoke(nvh, ["--planes"])
    assert run.exit_code == 0, run.output
    said = [re.split(r"\s{2,}", line) for line in run.stdout.splitlines() if VERDICT.search(line)]
    page = (DOCS / "engines.md").read_text(encoding="utf-8")
    shown = [[cell.strip() for cell in line.split("|")[1:-1]] for line in page.splitlines() if VERDICT.search(line)]
    assert [line[1] for line in shown] == [line[1] for line in said] and len(shown) >= 10
    for ours, theirs in zip(shown, said, strict=True):
        number, found = (abs(float(re.search(r"[\d.]+(e-\d+)?", line[2])[0])) for line in (ours, theirs))
        if ours[1] == "exact":  # nothing, of the size of rounding or of the run's tolerance
            assert found < 10 * max(number, 1e-13), ours
        else:
            assert found == pytest.approx(number, rel=0.06), ours  # two digits
