"""SECURITY.md and README.md say the limits and counts that the code and the tests have."""

import re
from pathlib import Path

import pytest
from helpers import every_call, hostile, hostile_files, sweep_models, watchdog

from bicycle.parameters import read_values
from engines.balance.layouts import CYLINDERS_MAX
from engines.nvh.cabin.table import read_modes
from engines.nvh.excitation.presets import preset
from engines.nvh.mounts.mounts import car
from engines.nvh.road.measured import LENGTH_MAX, POINTS_MAX, read_road
from mbsd3d import System, read_mjcf, read_sdf, shapes
from mbsd3d.files.description import PARTS_MAX
from mbsd3d.files.importing import guarded, xml_scan
from mbsd3d.mechanism.shapes import triangles

ROOT = Path(__file__).parents[2]
README, SECURITY, MAKEFILE = (
    (ROOT / name).read_text(encoding="utf-8") for name in ("README.md", "SECURITY.md", "Makefile")
)


def number(count):
    """As the texts write it."""
    return f"{count:,}".replace(",", " ")


ROWS = {row.split("|")[1].split(" (")[0].strip(): row for row in SECURITY.splitlines() if row.startswith("|")}


@pytest.mark.parametrize(
    ("row", "place", "name", "read"),
    [
        ("model files", 0, "a.json", System.from_file),
        ("model files", 1, "a.toml", System.from_file),
        ("MJCF, URDF, SDF", 0, "a.xml", read_mjcf),
        ("MJCF, URDF, SDF", 0, "a.sdf", read_sdf),
        ("meshes", 0, "a.stl", lambda path: shapes.MeshFile(path).surface()),
        ("bicycle parameters", 0, "a.txt", read_values),
        ("bicycle parameters", 1, "a.yml", read_values),
        ("engines, cars", 0, "a.json", lambda path: preset(str(path))),
        ("engines, cars", 0, "a.json", lambda path: car(str(path))),
        ("engines, cars", 1, "a.csv", read_road),
        ("engines, cars", 1, "a.csv", read_modes),
    ],
)
def test_a_file_is_refused_for_its_size_above_what_the_page_says(tmp_path, row, place, name, read):
    """One byte more is too many; at the limit what is wrong is something else."""
    count, unit = re.findall(r"(\d+) (MB|kB)", ROWS[row])[place]
    limit = int(count) * {"MB": 10**6, "kB": 1000}[unit]
    for size in (limit + 1, limit):
        with (tmp_path / name).open("wb") as file:
            file.truncate(size)
        with pytest.raises(ValueError, match=name) as found:
            read(tmp_path / name)
        assert bool(re.search(rf"(at most|more than) {limit}\b", str(found.value))) == (size > limit)


def test_counts_are_those_of_the_code():
    assert f"{number(PARTS_MAX)} parts;" in ROWS["model files"]
    assert f"{number(xml_scan.EXPANDED_ELEMENTS_MAX)} elements" in ROWS["MJCF, URDF, SDF"]
    assert f"{guarded.MEMORY_BYTES_MAX >> 30} GB" in ROWS["MJCF, URDF, SDF"]
    assert f"{number(triangles.MESH_TRIANGLES_MAX)} triangles;" in ROWS["meshes"]
    road = f"{number(POINTS_MAX)} points and {LENGTH_MAX / 1000:g} km of a road"
    assert f"{CYLINDERS_MAX} cylinders; {road}" in ROWS["engines, cars"]
    assert f"within {watchdog.SECONDS:.0f} s and {watchdog.MEGABYTES:.0f} MB" in SECURITY


def test_counts_of_models_files_and_kills_are_those_of_the_tests():
    kills = len(sweep_models.KILLED) * sweep_models.MOMENTS
    said = f"{number(hostile.COUNT)} models, {number(hostile_files.COUNT)} files, {kills} kills"
    assert said in README and f"are each killed at {sweep_models.ALL_MOMENTS} moments" in SECURITY
    assert f"{kills} of them" in SECURITY and f"MBSD3D_TEST_KILLS={sweep_models.ALL_MOMENTS}" in MAKEFILE
    assert f"{number(hostile.COUNT)} random models" in SECURITY
    assert f"{number(hostile_files.COUNT)} broken files" in SECURITY


@pytest.mark.slow
def test_count_of_wrong_calls(tmp_path):
    every_call.files(tmp_path)
    count = sum(len(given) * len(every_call.WRONG) for _, given in every_call.calls(tmp_path))
    for text in (README, SECURITY):
        said = re.search(r"(\d+ 000)\s+calls", text).group(1)
        assert 0.95 * count < int(said.replace(" ", "")) <= count
