"""Own engines and cars: files that are written and read, and the ones that say what is wrong with them."""

import json
from copy import deepcopy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from engines.nvh.cli import nvh
from engines.nvh.excitation import presets
from engines.nvh.export import export
from engines.nvh.mounts import mounts
from engines.nvh.records import data
from engines.nvh.road.vehicle import Vehicle
from engines.nvh.study import Study


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Files of an engine whose cylinders are counted from bank to bank, in a car that is known on its wheels."""
    made = tmp_path_factory.mktemp("records")
    export(Study(presets.preset("v6_60"), mounts.car("saloon"), 3000.0), made)
    return made


def test_what_is_written_is_read_as_the_same(folder):
    known = Study(presets.preset("v6_60"), mounts.car("saloon"), 3000.0)
    car = mounts.car(str(folder / "saloon.json"))
    found = Study(presets.preset(str(folder / "v6_60.json")), car, 3000.0, shell=str(folder / "saloon-modes.csv"))
    # files have nine digits
    size = np.abs(known.here.force).max()
    assert found.here.force == pytest.approx(known.here.force, abs=1e-6 * size)
    assert found.source.gas_torque == pytest.approx(known.source.gas_torque, abs=1e-6 * known.source.mean_torque)
    seat = known.cabin.seat(known.here)
    assert found.cabin.seat(found.here) == pytest.approx(seat, abs=1e-6 * np.abs(seat).max())
    B = [Vehicle("half", one.ride, linked=True).small_motions.B for one in (car, known.car)]
    assert np.array_equal(*B)


def test_mounts_of_ones_own_are_taken_as_they_are(folder):
    car = mounts.car(str(folder / "saloon.json"))
    heavy = replace(presets.preset("v12"), name="other")
    for mount, record in zip(mounts.mounts(car, heavy, 1e3), car.mounts.values(), strict=True):
        assert np.array_equal(mount.rates, record["rates"]) and np.array_equal(mount.at, record["at"])


def test_guides_of_ones_own(folder):
    """Links given in the car's file instead of a name."""

    ride = mounts.car("compact").ride
    own = [data("cars")["guides"]["double wishbone"], "multilink"]
    named, given = Vehicle("half", ride, True), Vehicle("half", ride | {"guides": own}, True)
    assert np.array_equal(named.small_motions.A, given.small_motions.A) and given.guides[0].kind == "own"
    with pytest.raises(ValueError, match="guide 'own': strut missing"):
        assert (
            Vehicle("half", ride | {"guides": [{k: own[0][k] for k in ("centre", "links")}, own[1]]}, True).guides == []
        )


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (dict(links=[1, 2]), r"guide 'own': links: \[1, 2\]; give names"),
        (dict(links={"arm": [[0, 1, 2]]}), "guide 'own': arm: .* give two points"),
        (dict(strut="here"), "guide 'own': strut: 'here'; give two points"),
        (dict(strut=[[0, 1, 2], [0, 1]]), "guide 'own': strut: expected three numbers"),
        (dict(centre=None), "guide 'own': centre: "),
        (3, "guides: 3; give a name, or a record of centre, links and strut"),
    ],
)
def test_guides_that_are_none_are_refused(change, text):
    own = data("cars")["guides"]["double wishbone"]
    given = own | change if isinstance(change, dict) else change
    with pytest.raises(ValueError, match=text):
        assert not Vehicle("half", mounts.car("compact").ride | {"guides": [given, "multilink"]}, True).guides


CAR = [
    (("title",), ["a"], "title .*; give a few words"),
    (("mounts", "left", "rates"), [0, 1e5, 1e5], r"mount 'left': rates\[0\]: 0.0 is not positive"),
    (("mounts", "left", "damping"), [1, -3, 1], r"mount 'left': damping\[1\]: -3.0 is below 0.0"),
    (("mounts", "left", "rates"), [1e5, 1e5], "rates: expected three numbers"),
    (("mounts", "left", "angle"), None, "mount 'left': angle missing; --export writes an example"),
    (("mounts", "left", "anlge"), 3, "mount 'left': anlge unknown; it has at, rates, damping, angle"),
    (("mounts",), {}, "no mounts"),
    (("mounts",), [1], "no mounts"),
    (("mounts", "left"), 7, "mount 'left': expected a record"),
    (("bounce",), 0.0, "bounce: 0.0 is not positive"),
    (("ride", "front"), None, "car 'it': ride: front missing"),
    (("shell", "colour"), "red", "car 'it': shell: colour unknown"),
    (("shell", "seat"), [0.1, 0.2], "car 'it': shell: seat: expected three numbers"),
    (("shell", "engine"), [0.1, 0.2, "x"], "car 'it': shell: engine"),
    (("shell", "turned"), "across", "car 'it': shell: turned"),
    (("wings",), 2, "car 'it': wings unknown"),
]
ENGINE = [
    (("title",), 5, "title 5; give a few words"),
    (("piston_mass",), -1, "engine 'it': piston_mass: -1.0 is not positive"),
    (("balanced",), -0.1, "balanced: -0.1 is below"),
    (("pins",), [0, 120], "2 pins, 6 bores, 6 stations"),
    (("firing_order",), "1-2-3", "give each of 6 cylinders once"),
    (("firing_order",), 5, "give each of 6 cylinders once"),
    (("firing_order",), "1-2-3-4-6-5", "does not suit its pins and bores; 1-"),
    (("block", "mass"), 0, "block: mass: 0.0 is not positive"),
    (("block", "box"), [1, 2, 0], r"block: box\[2\]"),
    (("idle",), 9000, "idle 9000 is not below the redline"),
    (("title",), None, "engine 'it': title missing"),
]


def changed(file: Path, where: tuple, value: object, folder: Path) -> str:
    """A file with one field changed, or taken out."""
    record = deepcopy(json.loads(file.read_text(encoding="utf-8")))
    part = record
    for key in where[:-1]:
        part = part[key]
    if value is None:
        del part[where[-1]]
    else:
        part[where[-1]] = value
    (folder / "it.json").write_text(json.dumps(record), encoding="utf-8")
    return str(folder / "it.json")


@pytest.mark.parametrize(("where", "value", "text"), CAR)
def test_cars_that_cannot_be_are_refused(folder, tmp_path, where, value, text):
    with pytest.raises(ValueError, match=text):
        mounts.car(changed(folder / "saloon.json", where, value, tmp_path))


@pytest.mark.parametrize(("where", "value", "text"), ENGINE)
def test_engines_that_cannot_be_are_refused(folder, tmp_path, where, value, text):
    with pytest.raises(ValueError, match=text):
        presets.preset(changed(folder / "v6_60.json", where, value, tmp_path))


def test_files_that_hold_no_record_are_refused(tmp_path):
    (tmp_path / "a.json").write_text("[1, 2]", encoding="utf-8")
    (tmp_path / "b.json").write_text("{", encoding="utf-8")
    (tmp_path / "d.json").write_bytes(b'{"title": \xff}')
    (tmp_path / "e.json").write_text("[" * 100_000, encoding="utf-8")
    (tmp_path / "f.json").write_text(" " * 1_000_001, encoding="utf-8")
    for name, text in (
        ("a", "give one record"),
        ("b", "is not JSON: Expecting property name"),
        ("c", "No such file"),
        ("d", "is not UTF-8 text .line 1.; give an engine file"),
        ("e", "is not JSON: maximum recursion"),
        ("f", "has 1000001 bytes; an engine file has at most 1000000"),
    ):
        with pytest.raises(ValueError, match=text):
            presets.preset(str(tmp_path / f"{name}.json"))


@pytest.mark.parametrize("value", [{}, [], 5, "x" * 999])
def test_fields_of_other_kinds_are_refused(folder, tmp_path, value):
    (tmp_path / "of_a_layout.json").write_text(json.dumps(data("engines")["engines"]["inline_4"]), encoding="utf-8")
    for file, field in ((tmp_path / "of_a_layout.json", "layout"), (folder / "v6_60.json", "pins")):
        with pytest.raises(ValueError, match=field):
            presets.preset(changed(file, (field,), value, tmp_path))


def test_names_that_are_nearly_right_are_guessed():
    with pytest.raises(ValueError, match="engine 'inline4' is unknown, did you mean 'inline_4'. There are single"):
        presets.preset("inline4")


def test_layouts_of_the_toy_engine_are_named_as_such():
    with pytest.raises(ValueError, match=r"'I4' is a layout of the toy engine .* real dimensions are single"):
        presets.preset("I4")


@pytest.mark.parametrize(("key", "value"), [("front", 1.0), ("brakes", 0.0)])
def test_shares_of_a_car_are_between_0_and_1(key, value):
    with pytest.raises(ValueError, match=f"{key} {value:g}; give a share between 0 and 1"):
        Vehicle("half", mounts.car("compact").ride | {key: value})


@pytest.mark.slow
def test_the_command_writes_and_reads_files(tmp_path):
    found = CliRunner().invoke(nvh, ["single", "--car", "motorcycle", "--export", str(tmp_path)])
    assert found.exit_code == 0, found.output
    assert sorted(path.name for path in tmp_path.iterdir()) == ["motorcycle.json", "single.json"]
    again = [str(tmp_path / "single.json"), "--car", str(tmp_path / "motorcycle.json")]
    found = CliRunner().invoke(nvh, [*again, "--sweep", "3", "--cycles", "2", "--page", str(tmp_path)])
    assert found.exit_code == 0, found.output
    page = (tmp_path / "single-motorcycle.html").read_text(encoding="utf-8")
    assert "3 speeds, 2 cycles each" in page
