"""Runs of the suite: exit codes, what is kept of a run that was killed, and the files it writes."""

import json
import os
import re
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import closing, suppress
from dataclasses import replace

import pytest
from click.testing import CliRunner
from helpers.browser import visit

from mbsd3d.extend import main
from validation.cases import comparison
from validation.cases import reference as cases
from validation.suite import findings
from validation.suite.findings import Finding, Record, not_compared
from validation.suite.page import content_of, encoded, page_of
from validation.suite.suite import Suite, examined, store
from validation.suite.trials import references
from validation.suite.trials.trial import Trial

FAST = ("coriolis_slider", "eig_hanging_pendulum")
"""Cases of a few tenths of a second, engines included; one with a motion and one without."""


def validate(*arguments):
    """(exit code, what is printed) of ``mbsd3d validate``."""
    result = CliRunner().invoke(main, ["validate", *map(str, arguments)], prog_name="mbsd3d")
    assert result.exception is None or isinstance(result.exception, SystemExit), result.output  # no traceback
    return result.exit_code, result.output


def only(*chosen):
    """Options for some cases."""
    return [text for name in chosen for text in ("--case", name)]


def record(verdict="agrees", judge="theory", name="case", **numbers):
    """A record with one finding."""
    return Record(name, "group", "title", (Finding(judge, verdict, "quantity", **numbers),))


def test_finished_records_are_kept_bit_for_bit(tmp_path):
    full = examined(references.trial_of("coriolis_slider"), 0.05)
    other = record(error=1e-9, limit=1e-8)
    kept = store(tmp_path, budget=1.0)
    for found in (full, other):
        kept.put(found.name, found.to_dict())
    assert Suite([], store(tmp_path, budget=1.0)).found == {"coriolis_slider": full, "case": other}
    assert store(tmp_path, fresh=True, budget=1.0).all() == {}


def test_records_of_other_sources_or_settings_are_forgotten(monkeypatch, tmp_path):
    store(tmp_path, budget=1.0).put("case", 1)
    assert store(tmp_path, budget=1.0).all() == {"case": 1}
    assert store(tmp_path, budget=2.0).all() == {}
    store(tmp_path, budget=2.0).put("case", 1)
    monkeypatch.setattr("validation.suite.suite.SOURCE_PATTERNS", ("*.py",))  # as if the references were others
    assert store(tmp_path, budget=2.0).all() == {}


def test_table_and_page_of_every_verdict():
    many = [record(name=f"many {k}", error=1e-9, limit=1e-8) for k in range(findings.LISTED_CASES_MAX)]
    many.append(record("differs", name="wrong <b>", error=0.3, limit=1e-8, note="<script>alert(1)</script>"))
    other = Record("other", "few", "title", (not_compared("MuJoCo", "no element for Screw"),))
    explained = record("explained", "MuJoCo", "soft", error=0.1, limit=1e-6)
    explained = replace(explained, group="few", attributions=({"engine": "MuJoCo", "before": 0.1, "after": 0.025},))
    shown = [*many, other, explained]
    text = findings.table(shown)
    assert "group: 31 cases" in text and "30 agrees, 1 differs" in text and "0.1*" not in text and "1e-01*" in text
    assert "wrong <b>: theory: quantity 3.00e-01 (limit 1e-08): <script>" in text
    assert "MuJoCo, not compared 1 times: no element for Screw (1)" in text
    assert "33 cases: 30 agree, 1 explained, 1 differ, 1 not compared (no judge but the certificate)" in text
    content = content_of(shown, quick=True, complete=False)
    html = page_of(shown, content)
    assert "<script" not in html and "&lt;script&gt;" in html and "SOMETHING DIFFERS" in html
    assert "interrupted" in html and "0.025" in html
    assert json.loads(encoded(content))["counts"] == {"agrees": 30, "differs": 1, "not compared": 1, "explained": 1}


@pytest.mark.slow
def test_a_run_of_two_cases_from_table_to_files(tmp_path):
    code, said = validate(*only(*FAST), "--quick", "--out", tmp_path)
    assert code == 0, said
    assert all(name in said for name in FAST) and "0 differ, 0 not compared" in said
    html, data = (tmp_path / "validation.html").read_text(), json.loads((tmp_path / "validation.json").read_text())
    assert not re.search(r"""(src|href)=(?!["'](#|data:))|https?://|@import|url\(""", html)
    assert html.count("data:image/webp") == 2 and "<svg" in html and "@page" in html
    assert data["format"] == 1 and data["verdict"] == "agrees" and data["complete"] and data["quick"]
    assert [case["name"] for case in data["cases"]] == list(FAST)
    for finding in (finding for case in data["cases"] for finding in case["findings"]):
        assert set(finding) == {"judge", "verdict", "quantity", "error", "limit", "note"}
        assert finding["judge"] in data["judges"] and finding["verdict"] in ("agrees", "explained", "not compared")
    again, said = validate(*only(*FAST, "eig_fourbar2_hanging"), "--quick", "--out", tmp_path)
    assert again == 0 and "2 of 3 cases are in" in said
    kept = json.loads((tmp_path / "validation.json").read_text())["cases"][: len(FAST)]
    assert [case["seconds"] for case in kept] == [case["seconds"] for case in data["cases"]]  # they were not run again
    code, said = validate(*only(FAST[1]), "--quick", "--fresh", "--out", tmp_path)
    assert code == 0 and "are in" not in said


def test_a_changed_reference_value_makes_the_run_fail(tmp_path, monkeypatch):
    copy = tmp_path / "references"
    shutil.copytree(cases.REFERENCES, copy)
    path = copy / "coriolis_slider.json"
    raw = json.loads(path.read_text())
    raw["reference"]["values"][-1]["s_x"] *= 1 + 1e-6
    path.write_text(json.dumps(raw))
    monkeypatch.setattr(cases, "REFERENCES", copy)
    monkeypatch.setattr(comparison, "REFERENCES", copy)
    code, said = validate(*only("coriolis_slider"), "--quick", "--out", tmp_path)
    assert code == 1 and "mbsd3d: coriolis_slider differ" in said and "reference: 8 columns" in said
    assert "SOMETHING DIFFERS" in (tmp_path / "validation.html").read_text()
    assert json.loads((tmp_path / "validation.json").read_text())["verdict"] == "differs"


def test_ctrl_c_keeps_what_is_finished(tmp_path):
    def interrupted():
        raise KeyboardInterrupt

    first = references.trial_of("eig_hanging_pendulum")
    suite = Suite([first, Trial("second", "g", "t", interrupted)], store(tmp_path), True, 0.05, show=False)
    with pytest.raises(KeyboardInterrupt):
        suite.run()
    assert [found.name for found in suite.records] == [first.name] and [left.name for left in suite.left] == ["second"]
    page, data = suite.write(tmp_path)
    assert "interrupted" in page.read_text() and not json.loads(data.read_text())["complete"]


def test_bad_input_ends_in_one_line_before_any_work(tmp_path):
    (tmp_path / "file").write_text("")
    for arguments, words in [
        (["--case", "nothing"], "--case 'nothing': there is no such case; --list names them all"),
        (["--out", tmp_path / "file"], "is a file; give a folder"),
        (["--t-end", "0"], "--t-end is for a MODEL; give one"),
        (["model.json", "--quick"], "--quick is for all cases; leave it or MODEL out"),
    ]:
        code, said = validate(*arguments)
        assert code == 2 and words in said and said.count("\n") == 1
    code, said = validate("--list", "--quick")
    assert code == 0 and "heavy_top_fast" in said and "random_019" in said and "random_020" not in said
    code, said = validate("--list", "--case", "random_0*", "--case", "heavy_top_fast")
    assert code == 0 and said.count("\n") == 101 and "heavy_top_fast" in said and "random_100" not in said


def in_ledger(folder):
    """Number of finished cases in a ledger that is being written."""
    with suppress(sqlite3.OperationalError), closing(sqlite3.connect(folder / "validation.db")) as file:
        return file.execute("SELECT COUNT(*) FROM cells").fetchone()[0]
    return 0  # it is being made


@pytest.mark.slow
def test_a_killed_run_goes_on(tmp_path):
    wanted = [*only(*FAST, "top_slow_precession"), "--quick", "--out", str(tmp_path)]
    started = subprocess.Popen([sys.executable, "-m", "validation", *wanted], stdout=subprocess.DEVNULL)
    while in_ledger(tmp_path) < 1 and started.poll() is None:
        time.sleep(0.01)
    started.send_signal(signal.SIGKILL)
    started.wait()
    finished = in_ledger(tmp_path)
    assert 1 <= finished
    assert not (tmp_path / "validation.html").exists() or finished == 3  # killed half-way, if the machine let us
    code, said = validate(*wanted)
    assert code == 0 and f"{finished} of 3 cases are in" in said and "3 cases: " in said


@pytest.mark.slow
def test_many_cases_go_to_processes(tmp_path):
    some = ("coriolis_slider", "door_two_hinges", "eig_hanging_pendulum", "eig_fourbar2_hanging", "random_003")
    code, said = validate(*only(*some), "--quick", "--out", tmp_path)
    assert code == 0 and "5 cases" in said
    data = json.loads((tmp_path / "validation.json").read_text())
    assert [case["name"] for case in data["cases"]] == list(some)  # in the order asked for, not as they came


@pytest.mark.slow
def test_the_page_in_a_browser(chromium, tmp_path):
    validate(*only(*FAST), "--quick", "--out", tmp_path)
    for scheme in ("light", "dark"):
        with visit(chromium, tmp_path / "validation.html", width=420, color_scheme=scheme) as seen:
            assert seen.run("document.documentElement.scrollWidth") <= 420  # wide tables scroll within the page
            assert seen.run("document.querySelectorAll('main').length") == 1
        with visit(chromium, tmp_path / "validation.html", width=1200, color_scheme=scheme) as seen:
            assert seen.complaints == []
            assert seen.run("document.documentElement.scrollWidth") <= 1200
            assert seen.run("[...document.images].every(image => image.complete && image.naturalWidth > 300)")
            assert seen.run("document.querySelectorAll('section.case').length") == len(FAST)


MISTAKEN = """
from helpers import mutations
from mbsd3d.cli import main
from mbsd3d.kernels import rows
from validation.suite.trials import references

references.SHORTER_CASE["exudyn_rollingCoinTest"] = "without the compiler it takes minutes"
mutations.put("roll", mutations.wrong_rows(rows.roll, mutations.one_per_cent_of_gamma))
main(["validate", "--case", "exudyn_rollingCoinTest", "--quick", "--out", {out!r}])
"""


@pytest.mark.slow
def test_a_wrong_row_kernel_makes_the_run_fail(tmp_path):
    """One per cent of J_dot v of a rolling disc, in a process without the compiler."""
    command = [sys.executable, "-c", MISTAKEN.format(out=str(tmp_path))]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert done.returncode == 1, done.stdout + done.stderr
    assert "exudyn_rollingCoinTest differ" in done.stderr and "reference: 10 columns" in done.stdout
