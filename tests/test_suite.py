"""The suite of all cases: its judges, its verdicts and exit codes, what it keeps and what it writes."""

import json
import re
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace

import numpy as np
import pytest
from browser import visit
from click.testing import CliRunner

from mbsd3d.cli import main
from mbsd3d.demos.base import discover
from validation import cases, comparison
from validation.engine_balance.layouts import names
from validation.suite import engines, listing, plane, randoms, references, table
from validation.suite.document import content_of, encoded
from validation.suite.findings import (
    AGREES,
    CERTIFICATE,
    DIFFERS,
    EXPLAINED,
    JUDGES,
    MUJOCO,
    NOT_COMPARED,
    PLANE,
    REFERENCE,
    THEORY,
    Finding,
    Record,
    judged,
    not_compared,
)
from validation.suite.ledger import Ledger, identity
from validation.suite.page import page_of
from validation.suite.suite import Suite, examined, lost
from validation.suite.trial import Trial, examine, run

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


def record(verdict=AGREES, judge=THEORY, name="case", **numbers):
    """A record with one finding."""
    return Record(name, "group", "title", (Finding(judge, verdict, "quantity", **numbers),))


def test_the_list_holds_everything():
    everything, short = listing.trials(), listing.trials(quick=True)
    found = [trial.name for trial in everything]
    assert len(found) == len(set(found))
    assert set(cases.names()) <= set(found)
    assert {f"demo_{demo}" for demo in discover()} <= {name.removesuffix("_") for name in found}
    assert {f"engine_{name}" for name in names()} <= set(found)
    assert sum(trial.group == "random mechanisms" for trial in everything) == randoms.MANY == 200
    assert sum(trial.group == "random mechanisms" for trial in short) == randoms.FEW == 20
    assert {trial.name for trial in short} <= set(found)
    assert set(references.STANDING) == set(cases.names()) - set(cases.names(timed=True))


@pytest.mark.parametrize("name", cases.names())
def test_reference_cases_agree_with_file_theory_and_plane(name):
    found, made = examine(references.trial_of(name))
    assert found.failures == () and found.verdict == AGREES
    assert {finding.judge for finding in found.findings} <= set(JUDGES)
    assert made.system.bodies


def test_closed_forms_and_planar_models_judge_the_cases_that_have_them():
    with_theory = [name for name in cases.names() if name in references.CLOSED_FORMS]
    assert len(with_theory) == 12
    flat = ("coriolis_slider", "door_two_hinges", "iftomm_A02_fourbar_N2", "iftomm_A03_andrews")
    for name in flat:
        found = examine(references.trial_of(name))[0]
        assert found.worst(PLANE).verdict == AGREES


@pytest.mark.parametrize("switch", ["gyroscopic", "centripetal", "gamma"])
def test_wrong_equations_differ_from_file_and_theory(switch):
    def wrong():
        case = cases.load("heavy_top_fast", references.SHIFT)
        return run(case.system, case.t_end, output=case.times, source=case, accuracy=1e-7, **{switch: False})

    found = examine(replace(references.trial_of("heavy_top_fast"), make=wrong))[0]
    assert found.verdict == DIFFERS
    assert {CERTIFICATE, REFERENCE, THEORY} <= {finding.judge for finding in found.failures}


def test_a_planar_model_a_thousandth_heavier_differs():
    made = references.moving("iftomm_A03_andrews")
    system, flat = plane.flatten(made.system)
    (clean,) = plane.by_ladder(made, system, flat.frame)
    object.__setattr__(system.bodies[0], "mass", 1.001 * system.bodies[0].mass)
    object.__setattr__(system.bodies[0], "inertia", 1.001 * system.bodies[0].inertia)
    (heavier,) = plane.by_ladder(made, replaced(system), flat.frame)
    assert clean.verdict == AGREES and heavier.verdict == DIFFERS and heavier.error > 100 * clean.error


def replaced(system):
    """The same planar system without what it has computed."""
    return type(system)(system.bodies, system.joints, system.loads, system.gravity)


def test_what_leaves_the_plane_is_named():
    for name, part in (("gyro_gimbal_wheel", "body 'wheel'"), ("sarrus_linkage", "ba"), ("iftomm_A01_pendulum", "bob")):
        found = examine(references.trial_of(name))[0].worst(PLANE)
        assert found.verdict == NOT_COMPARED and part in found.note


def test_engines_and_planar_mechanisms_agree():
    for trial in engines.trials(quick=True):
        found = examine(trial)[0]
        assert found.verdict == AGREES, table.differences([found])
        assert found.worst(PLANE).verdict == AGREES


def test_random_mechanisms_move_and_keep_their_seed():
    for seed in range(4):
        first, second = (randoms.started(seed) for _ in range(2))
        assert np.abs(first.state.v).max() > 0.3 and first.t_end >= randoms.SHORTEST
        assert np.array_equal(first.solution.arrays["q"], second.solution.arrays["q"])


def test_reactions_of_a_gear_whose_hinges_stand_on_one_body():
    """Its body b bears the torques of both hinges; seed 10 has such a gear, and MuJoCo can express it."""
    found = examined(randoms.trial_of(10), 0.1)
    moments = [finding for finding in found.of(MUJOCO) if finding.quantity == "reaction moment"]
    assert [finding.verdict for finding in moments] == [AGREES]


def test_verdict_of_a_case_is_that_of_its_worst_judge():
    agrees, differs = judged(THEORY, "x", 1e-9, 1e-8), judged(THEORY, "x", 1e-7, 1e-8)
    explained, silent = Finding(MUJOCO, EXPLAINED, "y", 0.1, 1e-6, "cause"), not_compared(MUJOCO, "no such part")
    own = judged(CERTIFICATE, "run", 0.0, 1.0)
    for findings, verdict in [
        ((own,), NOT_COMPARED), ((own, silent), NOT_COMPARED), ((own, agrees, silent), AGREES),
        ((own, agrees, explained), EXPLAINED), ((own, agrees, explained, differs), DIFFERS),
    ]:  # fmt: skip
        assert Record("n", "g", "t", findings).verdict == verdict
    for wrong in (np.nan, np.inf, 2e-8):
        assert judged(THEORY, "x", wrong, 1e-8).verdict == DIFFERS
    assert judged(THEORY, "x", np.inf, 1e-8).error is None  # JSON has no word for it
    assert Record("n", "g", "t", (agrees, differs)).worst(THEORY) is differs


def test_a_judge_that_breaks_and_a_run_that_fails_are_findings():
    def breaks(made):
        raise TypeError("no\nnumber")

    trial = replace(references.trial_of("coriolis_slider"), judges={THEORY: breaks})
    (finding,) = examine(trial)[0].failures
    assert finding.judge == THEORY and finding.note == "stopped: TypeError: no number"

    def fails():
        raise ValueError("body 'x': mass -1")

    found, made = examine(replace(trial, make=fails))
    assert made is None and found.verdict == DIFFERS and "mass -1" in found.failures[0].note
    assert lost(trial, "WorkerDied: ...").verdict == DIFFERS


def test_an_engine_that_is_missing_is_not_compared(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    found = examined(references.trial_of("coriolis_slider"), 0.05)
    assert found.verdict == AGREES and found.worst(MUJOCO).verdict == NOT_COMPARED
    assert "install" in found.worst(MUJOCO).note
    assert "MuJoCo, not compared" in table.text([found])


def test_ledger_keeps_records_and_leaves_out_a_line_cut_off(tmp_path):
    own = identity(budget=1.0)
    ledger = Ledger(tmp_path, own)
    full = examined(references.trial_of("coriolis_slider"), 0.05)
    ledger.put(full)
    ledger.put(record(error=1e-9, limit=1e-8))
    assert Ledger(tmp_path, own).records == {"coriolis_slider": full, "case": record(error=1e-9, limit=1e-8)}
    text = ledger.path.read_text()
    ledger.path.write_text(text[:-30])
    assert list(Ledger(tmp_path, own).records) == ["coriolis_slider"]
    assert Ledger(tmp_path, {**own, "sources": "others"}).records == {}


def test_identity_follows_sources_and_settings(monkeypatch, tmp_path):
    assert identity(budget=1.0) == identity(budget=1.0) != identity(budget=2.0)
    assert re.fullmatch("[0-9a-f]{64}", identity()["sources"])


def test_table_and_page_of_every_verdict():
    many = [record(name=f"many {k}", error=1e-9, limit=1e-8) for k in range(table.MANY)]
    many.append(record(DIFFERS, name="wrong <b>", error=0.3, limit=1e-8, note="<script>alert(1)</script>"))
    other = Record("other", "few", "title", (not_compared(MUJOCO, "no element for Screw"),))
    explained = record(EXPLAINED, MUJOCO, "soft", error=0.1, limit=1e-6)
    explained = replace(explained, group="few", attributions=({"engine": MUJOCO, "before": 0.1, "after": 0.025},))
    shown = [*many, other, explained]
    text = table.text(shown)
    assert "group: 31 cases" in text and "30 agrees, 1 differs" in text and "0.1*" not in text and "1e-01*" in text
    assert "wrong <b>: theory: quantity 3.00e-01 (limit 1e-08): <script>" in text
    assert "MuJoCo, not compared 1 times: no element for Screw (1)" in text
    assert "33 cases: 30 agree, 1 explained, 1 differ, 1 not compared (no judge but the certificate)" in text
    content = content_of(shown, quick=True, complete=False)
    html = page_of(shown, content)
    assert "<script" not in html and "&lt;script&gt;" in html and "SOMETHING DIFFERS" in html
    assert "interrupted" in html and "0.025" in html
    assert json.loads(encoded(content))["counts"] == {AGREES: 30, DIFFERS: 1, NOT_COMPARED: 1, EXPLAINED: 1}


def test_a_run_of_two_cases_from_table_to_files(tmp_path):
    code, said = validate(*only(*FAST), "--quick", "--out", tmp_path)
    assert code == 0, said
    assert all(name in said for name in FAST) and "2 cases: 2 agree, 0 explained, 0 differ, 0 not compared" in said
    html, data = (tmp_path / "validation.html").read_text(), json.loads((tmp_path / "validation.json").read_text())
    assert not re.search(r"""(src|href)=(?!["'](#|data:))|https?://|@import|url\(""", html)
    assert html.count("data:image/webp") == 2 and "<svg" in html and "@page" in html
    assert data["format"] == 1 and data["verdict"] == AGREES and data["complete"] and data["quick"]
    assert [case["name"] for case in data["cases"]] == list(FAST)
    for finding in (finding for case in data["cases"] for finding in case["findings"]):
        assert set(finding) == {"judge", "verdict", "quantity", "error", "limit", "note"}
        assert finding["judge"] in data["judges"] and finding["verdict"] in (AGREES, EXPLAINED, NOT_COMPARED)
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
    assert json.loads((tmp_path / "validation.json").read_text())["verdict"] == DIFFERS


def test_ctrl_c_keeps_what_is_finished(tmp_path):
    def interrupted():
        raise KeyboardInterrupt

    first = references.trial_of("eig_hanging_pendulum")
    suite = Suite([first, Trial("second", "g", "t", interrupted)], Ledger(tmp_path, {}), True, 0.05, show=False)
    with pytest.raises(KeyboardInterrupt):
        suite.run()
    assert [found.name for found in suite.records] == [first.name] and [left.name for left in suite.left] == ["second"]
    page, data = suite.write(tmp_path)
    assert "interrupted" in page.read_text() and not json.loads(data.read_text())["complete"]


def test_bad_input_ends_in_one_line_before_any_work(tmp_path):
    (tmp_path / "file").write_text("")
    for arguments, words in [
        (["--case", "nothing"], "--case 'nothing': there is no such case; --list names them all"),
        (["--out", tmp_path / "file"], "cannot be written"),
        (["--t-end", "2"], "--t-end is for a MODEL"),
        (["model.json", "--quick"], "--quick is for all cases, without MODEL"),
    ]:
        code, said = validate(*arguments)
        assert code == 2 and words in said and said.count("\n") == 1
    code, said = validate("--list", "--quick")
    assert code == 0 and "heavy_top_fast" in said and "random_019" in said and "random_020" not in said


def in_ledger(folder):
    """Number of finished cases in a ledger that is being written."""
    path = folder / "validation.jsonl"
    return max(path.read_text().count("\n") - 1, 0) if path.is_file() else 0


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
    assert code == 0 and f"{finished} of 3 cases are in" in said and "3 cases: 3 agree" in said


@pytest.mark.slow
def test_many_cases_go_to_processes(tmp_path):
    some = ("coriolis_slider", "door_two_hinges", "eig_hanging_pendulum", "eig_fourbar2_hanging", "random_003")
    code, said = validate(*only(*some), "--quick", "--out", tmp_path)
    assert code == 0 and "5 cases" in said
    data = json.loads((tmp_path / "validation.json").read_text())
    assert [case["name"] for case in data["cases"]] == list(some)  # in the order asked for, not as they came


def test_the_page_in_a_browser(chromium, tmp_path):
    validate(*only(*FAST), "--quick", "--out", tmp_path)
    for scheme in ("light", "dark"):
        with visit(chromium, tmp_path / "validation.html", width=1200, color_scheme=scheme) as seen:
            assert seen.complaints == []
            assert seen.run("document.documentElement.scrollWidth") <= 1200
            assert seen.run("[...document.images].every(image => image.complete && image.naturalWidth > 300)")
            assert seen.run("document.querySelectorAll('section.case').length") == len(FAST)
