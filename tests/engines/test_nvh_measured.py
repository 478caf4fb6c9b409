"""Roads from tables: heights, waves, a car over them, and tables with gaps."""

import numpy as np
import pytest
from click.testing import CliRunner

from engines import closed_forms
from engines.nvh.cli import nvh
from engines.nvh.mounts import mounts
from engines.nvh.road.measured import Measured, read_road
from engines.nvh.road.ride import Ride
from engines.nvh.road.vehicle import Vehicle

RNG = np.random.default_rng(7)
X = 3.0 + 0.25 * np.arange(161)  # steps above half of the shortest wave: nothing is left out
Z = 0.01 * np.cumsum(RNG.standard_normal((2, X.size)), axis=1)


def test_heights_are_those_of_the_table_and_of_its_mirror_image():
    road = Measured("table", X, Z)
    for side in (0, 1):
        found = road.height(X - X[0], side)
        assert found - found[0] == pytest.approx(Z[side] - Z[side, 0], abs=1e-13)
        assert road.height(road.length - (X - X[0]), side) == pytest.approx(found, abs=1e-12)
    assert road.left_out == 0.0


def test_waves_that_are_too_short_are_counted():
    x = np.linspace(0.0, 60.0, 1201)
    wave = 0.003 * np.cos(2 * np.pi * 5.0 * x)
    road = Measured("ribs", x, np.tile(wave, (2, 1)))
    assert road.left_out == pytest.approx(0.003 / np.sqrt(2), rel=1e-9)
    assert np.abs(road.height(x, 0)).max() < 1e-12
    assert Measured("one rib", x, np.stack([0.1 * wave, wave])).left_out == road.left_out  # of the rougher track
    with pytest.raises(ValueError, match="'ribs' is level: no wave of 0.35 m or more"):
        Ride(Vehicle("quarter", mounts.car("compact").ride), road, 20.0)


def test_a_quarter_car_over_one_wave_of_a_table():
    """The amplitude of the table's wave times the closed form."""
    count, waves = 401, 12
    x = np.linspace(0.0, 50.0, count)
    road = Measured("wave", x, np.tile(0.02 * np.cos(np.pi * waves * x / 50.0) + 0.4, (2, 1)))
    ride = Ride(Vehicle("quarter", mounts.car("compact").ride), road, 20.0)
    (corner,), w = ride.vehicle.corners, 2 * np.pi * waves / 100.0 * 20.0
    spring, tyre = (corner.spring, corner.damper), (corner.tyre, corner.tyre_damping)
    body, _ = closed_forms.quarter_car(np.array([w]), (ride.vehicle.mass, corner.mass), spring, tyre)
    assert ride.seat[waves - 1] == pytest.approx(-(w**2) * 0.02 * body[0], rel=1e-9)
    others = np.delete(ride.seat, waves - 1)
    assert np.abs(others).max() < 1e-9 * abs(ride.seat[waves - 1])
    # splines through 16 points of the shortest wave
    assert ride.difference < 1e-4 and ride.run.certificate.passed


def test_a_file_is_read_with_one_track_or_two(tmp_path):
    two, one = tmp_path / "two.csv", tmp_path / "one.csv"
    np.savetxt(two, np.vstack([X, Z]).T, delimiter=", ", header="x, left, right", comments="", fmt="%.17g")
    np.savetxt(
        one, np.vstack([X, Z[0]]).T, delimiter=",", header="x,z", comments="\ufeff", fmt="%.17g", encoding="utf-8"
    )
    assert np.array_equal(read_road(two).z, Z) and np.array_equal(read_road(two).x, X)
    assert np.array_equal(read_road(one).z, Z[[0, 0]])


def lines(change: str) -> str:
    """A table with a fault."""
    rows = [f"{x:g},{a:g},{b:g}" for x, a, b in zip(X, *Z, strict=True)]
    text = {
        "gap": rows[:50] + rows[52:], "cell": [*rows[:50], "15.5,,0.1", *rows[51:]], "order": rows[:50] + rows[40:],
        "nan": [*rows[:50], "15.5,nan,0.1", *rows[51:]], "short": rows[:10],
        "steep": [*rows[:51], *(f"{x:g},0.8,0.8" for x in X[51:])], "less": [*rows[:50], "15.5,0.1", *rows[51:]],
    }.get(change, rows)  # fmt: skip
    return "\n".join(["x,left,right" if change != "header" else "s,a,b", *text])


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ("gap", "a gap of 0.75 m after point 50, x = 15.25 m; points stand 0.25 m"),
        ("cell", "line 52: left is ''; give a number"),
        ("nan", "line 52: left is 'nan'"),
        ("order", "x goes from 15.25 to 13 m after point 50; give places in order"),
        ("steep", "a step of 0.9387 m after point 51, x = 15.5 m; give heights in m, from point to point 0.5 m"),
        ("short", "10 points; give 20 to 20000"),
        ("less", "line 52 has 2 values; give 3"),
        ("header", "line 1 must be 'x,left,right' or 'x,z'"),
    ],
)
def test_tables_that_are_no_road_are_refused(tmp_path, change, text):
    (tmp_path / "road.csv").write_text(lines(change), encoding="utf-8")
    with pytest.raises(ValueError, match="road 'road.csv': ") as found:
        read_road(tmp_path / "road.csv")
    assert text in str(found.value)


def test_other_files_and_short_roads_are_refused(tmp_path):
    with pytest.raises(ValueError, match="No such file or directory; give a file that exists"):
        read_road(tmp_path / "none.csv")
    with pytest.raises(ValueError, match="2 m long; give 5 to 5000 m"):
        Measured("short", np.linspace(0, 2, 40), np.zeros((2, 40)))


@pytest.mark.slow
def test_the_command_takes_a_file(tmp_path):
    (tmp_path / "road.csv").write_text(lines(""), encoding="utf-8")
    found = CliRunner().invoke(nvh, ["--road", str(tmp_path / "road.csv")])
    assert found.exit_code == 0, found.output
    assert "compact car on road.csv at 20 m/s" in found.output and "waves below 353 mm" in found.output
