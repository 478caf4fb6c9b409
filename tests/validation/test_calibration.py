"""The calibration judges as its page says, keeps what is done, and its table is that of docs/."""

import json
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from mbsd3d import DOP853
from validation.calibration import runs, table, texts
from validation.calibration.cli import main
from validation.calibration.families import FAMILIES
from validation.calibration.judge import Record, build, cases, compare, examine, march

RIGHT = Record("wheel", 1, "RK4", "step fine", "RK4(dt=0.01)", 1e-8, True, False, error=1e-9, relative=1e-9,
               worst="wheel", passed=True, estimate="agrees", estimated=1e-9)  # fmt: skip


def test_outcomes_are_what_the_page_says():
    lost = replace(RIGHT, error=6.28, relative=0.02)  # 314 rad: a turn is two hundredths of it
    assert lost.wrong and lost.silent and not lost.right
    assert not replace(lost, estimate="warns").silent and not replace(lost, warned=True).silent
    assert not replace(lost, stopped="no finite solution").silent
    assert replace(lost, error=np.nan).silent and replace(lost, error=np.inf).silent
    failed = replace(RIGHT, passed=False, warned=True)
    assert failed.false_alarm and not failed.silent
    assert not replace(failed, relative=1.1e-7).false_alarm and replace(failed, relative=0.9e-7).false_alarm
    assert not replace(failed, unsure=True).false_alarm
    assert replace(RIGHT, estimate="raises").false_alarm and not RIGHT.false_alarm
    loose = replace(RIGHT, rtol=5e-3, fixed=False, estimate="warns", error=2e-3, relative=1e-4)
    assert not loose.false_alarm and replace(loose, error=9e-4).false_alarm


def test_a_lost_turn_is_an_error_however_far_a_hinge_has_turned():
    problem, _ = build("wheel", 5)
    run = march(problem, DOP853(), 1e-9, 7)
    assert compare(problem, run)[0] < 1e-7
    reading = problem.readings[0]
    short = replace(reading, computed=lambda run: reading.computed(run) - 2.0 * np.pi)
    assert compare(replace(problem, readings=[short]), run)[0] == pytest.approx(2.0 * np.pi, abs=1e-6)


def test_a_stop_that_is_missed_is_an_error():
    problem, _ = build("stopped_wheel", 3)
    found = march(problem, DOP853(), 1e-9, None)
    assert len(found) == 4 and compare(problem, found)[0] < 1e-6
    assert compare(problem, march(replace(problem, stops=()), DOP853(), 1e-9, None))[0] > 0.1


@pytest.mark.parametrize("family", FAMILIES)
def test_truths_begin_where_the_mechanism_is(family):
    """At t = 0 nothing has turned: a truth of another place or another zero shows at once."""
    problem, settings = build(family, 4)
    begun = replace(problem, stops=(), t_end=1e-9)
    assert compare(begun, march(begun, DOP853(), 1e-8, [1e-9]))[0] < 1e-6  # speeds of up to 1e3 times the nanosecond
    assert settings.name in problem.methods


def test_counts_add_up():
    records = [RIGHT, replace(RIGHT, error=1.0, relative=1.0), replace(RIGHT, passed=False, warned=True),
               replace(RIGHT, passed=False, warned=True, error=1e-4, relative=1e-4), replace(RIGHT, stopped="singular"),
               replace(RIGHT, error=1.0, warned=True, passed=False), replace(RIGHT, error=1.0, estimate="warns"),
               replace(RIGHT, error=1.0, warned=True)]  # fmt: skip
    assert table.rows(records)[0] == ["RK4", "step fine", "8", *["1"] * 8, "1.0e+00, 1.0e+00"]
    text = "\n".join(table.offenders(records))
    assert text.count("--family wheel --seed 1 --runs 1") == 3


def test_runs_that_are_done_are_not_made_again(tmp_path, monkeypatch):
    path, case = tmp_path / "runs.jsonl", ("wheel", 5)
    (record,) = runs.examined([case], path)
    assert record.error == examine(*case).error
    assert runs.stored(path, runs.code_digest()) == {case: record}
    assert runs.stored(path, "another code") == {}
    path.write_text(path.read_text(encoding="utf-8") + '{"family": "whe', encoding="utf-8")
    assert runs.stored(path, runs.code_digest()) == {case: record}


@pytest.mark.slow
def test_command(tmp_path, monkeypatch):
    asked = ["--family", "wheel", "--family", "nut", "--runs", "3", "--out", str(tmp_path)]
    first = CliRunner().invoke(main, asked)
    assert first.exit_code == 0, first.output
    assert len((tmp_path / "calibration.jsonl").read_text(encoding="utf-8").splitlines()) == 3
    monkeypatch.setattr(runs, "examine", lambda *case: pytest.fail(f"{case} was made again"))
    assert CliRunner().invoke(main, asked).output == first.output
    refused = CliRunner().invoke(main, ["--family", "hwheel", "--out", str(tmp_path)])
    assert refused.exit_code and "'hwheel' is unknown" in refused.output


def test_families_take_turns():
    assert cases(5, 10, ("a", "b")) == [("a", 10), ("b", 10), ("a", 11), ("b", 11), ("a", 12)]


def test_page_shows_what_was_measured():
    found = json.loads((texts.ROOT / texts.FIGURES_FILE).read_text(encoding="utf-8"))
    page = (texts.ROOT / texts.PAGE_FILE).read_text(encoding="utf-8")
    assert texts.renewed(page, found) == page
    assert found["runs"] >= 2000 and found["families"] == len(FAMILIES)


def test_new_figures_change_the_page(tmp_path):
    for name in (texts.FIGURES_FILE, texts.PAGE_FILE):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
    (tmp_path / texts.PAGE_FILE).write_text(
        "before\n<!-- calibration -->\n<!-- end of calibration -->\n", encoding="utf-8"
    )
    texts.renew([RIGHT], tmp_path)
    text = (tmp_path / texts.PAGE_FILE).read_text(encoding="utf-8")
    assert "| RK4 | step fine | 1 | 1 | 0 | 0 |" in text and text.startswith("before\n")
