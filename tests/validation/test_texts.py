"""Times in README.md and docs/ are those of docs/measured.json, and that file is what a measurement says."""

import json

import pytest

from mbsd3d.errors import InputError
from validation.benchmark import speed as benchmark
from validation.benchmark.precision import Climb, Point, Row, save
from validation.benchmark.problems import PROBLEMS
from validation.benchmark.texts import (
    MEASURED_FILE,
    PROBLEMS_BY_PAGE,
    README_PROBLEMS,
    ROOT,
    kernels,
    measured,
    renewed,
    speed,
    times,
)

DATA = json.loads((ROOT / MEASURED_FILE).read_text(encoding="utf-8"))


def test_texts_show_what_was_measured():
    for path, text in renewed(ROOT, DATA).items():
        assert path.read_text(encoding="utf-8") == text, f"{path}: python -m validation.benchmark.texts renews it"


def test_a_new_time_changes_both_texts():
    changed = {**DATA, "ms": {**DATA["ms"], "RSSR": ["1.61", "72", ">370"]}}
    assert all("| RSSR | 1.61 | 72 | > 370 |" in text for text in renewed(ROOT, changed).values())
    assert all(text != path.read_text(encoding="utf-8") for path, text in renewed(ROOT, changed).items())


def test_older_times_say_so():
    for of_now in (True, False):
        data = {**DATA, "kernels": kernels() if of_now else "of before"}
        texts = renewed(ROOT, data).values()
        assert all(("The kernels have changed since." in " ".join(text.split())) != of_now for text in texts)


def test_problems_exist():
    assert set(README_PROBLEMS) <= set(DATA["ms"]) <= set(PROBLEMS)
    assert set(PROBLEMS_BY_PAGE) == {"README.md", "docs/performance.md"}


def test_measured_is_what_the_benchmark_stored(tmp_path, monkeypatch):
    ours = Climb("mbsd3d", "DOP853", (Point(1e-3, 0.002, 1e-5), Point(1e-4, 0.004, 1e-7)))
    never = Climb("Exudyn", "constraints", (Point(1e-3, 0.5, 1e-3),))
    row = Row("RSSR", "loop", 3, 16, (ours, never))
    save(tmp_path / "precision.json", [row], "A processor, 2 cores; Python 3; load 0.1", complete=True)
    with pytest.raises(InputError, match=r"speed\.json: not found"):
        measured(tmp_path)
    costs = {benchmark.chain: [(10, 0.5), (40, 0.5)], benchmark.ladder: [(10, 0.5), (40, 1.0)]}  # n^1, n^1.5
    for name, told in {
        "per_evaluation": lambda: [(10, 0.5, 0.25), (40, 0.5, 1.0)],
        "growth": lambda mechanism, sizes: costs[mechanism],
        "check_seconds": lambda system: 0.51,
        "process_time": lambda *code: (0.88, 0.8),
        "compile_time": lambda: (31.2, 60.0),
    }.items():
        monkeypatch.setattr(benchmark, name, told)
    benchmark.main(tmp_path / "speed.json")
    found = measured(tmp_path)
    # the middle of two points in logarithms: 1e-6 lies half way, so sqrt(2 * 4) ms
    assert found["ms"] == {"RSSR": ["2.83", "-", ">500"]} and found["machine"] == "A processor, 2 cores; Python 3"
    assert "| RSSR | 2.83 | - | > 500 |" in times(found, ("RSSR", "Bricard"))
    assert "Bricard" not in times(found, ("RSSR", "Bricard"))
    assert "n^1.00 from 10 to 40 links, and as n^1.50" in speed(found)
    assert "| MuJoCo, RK4 | 0.25 | 1.00 |" in speed(found) and "| 0.9; 31 |" in speed(found)
