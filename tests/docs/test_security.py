"""SECURITY.md and README.md say the limits and counts that the code and the tests have."""

import re
from pathlib import Path

import every_call
import hostile
import hostile_files
import pytest
import sweep_models
import watchdog

from bicycle.parameters.files import FILE_BYTES_MAX
from engines.balance.layouts import CYLINDERS_MAX
from engines.nvh.records import RECORD_BYTES_MAX, TABLE_BYTES_MAX
from engines.nvh.road.measured import LENGTH_MAX, POINTS_MAX
from mbsd3d.files.description import PARTS_MAX
from mbsd3d.files.importing import guarded, xml_scan
from mbsd3d.files.model_files import FILE_FORMATS
from mbsd3d.mechanism.shapes import surfaces

ROOT = Path(__file__).parents[2]
README, SECURITY, MAKEFILE = (
    (ROOT / name).read_text(encoding="utf-8") for name in ("README.md", "SECURITY.md", "Makefile")
)


def number(count):
    """As the texts write it."""
    return f"{count:,}".replace(",", " ")


def test_sizes_are_those_of_the_code():
    rows = {row.split("|")[1].split(" (")[0].strip(): row for row in SECURITY.splitlines() if row.startswith("|")}
    json, toml = (FILE_FORMATS[suffix].limit // 10**6 for suffix in (".json", ".toml"))
    assert f"| {json} MB, {toml} MB; {number(PARTS_MAX)} parts;" in rows["model files"]
    xml = f"{xml_scan.LIMIT // 10**6} MB and {number(xml_scan.COPIES)} elements"
    assert xml in rows["MJCF, URDF"] and f"{guarded.MEMORY >> 30} GB" in rows["MJCF, URDF"]
    assert f"| {surfaces.BYTES // 10**6} MB, {number(surfaces.TRIANGLES)} triangles;" in rows["meshes"]
    text, yaml = FILE_BYTES_MAX[".txt"] // 10**6, FILE_BYTES_MAX[".yml"] // 1000
    assert f"| {text} MB, {yaml} kB;" in rows["bicycle parameters"]
    record, table, road = (
        RECORD_BYTES_MAX // 10**6,
        TABLE_BYTES_MAX // 10**6,
        f"{number(POINTS_MAX)} points and {LENGTH_MAX / 1000:g} km of a road",
    )
    assert f"| {record} MB, {table} MB; {CYLINDERS_MAX} cylinders; {road}" in rows["engines, cars"]
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
