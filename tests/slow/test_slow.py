"""Longer checks: the package without its compiler, and the change point of the four-bar from many reference points."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from mbsd3d import IntegrationError, simulate
from validation import cases
from validation.cases.comparison import compare
from validation.suite.trials.references import RTOL_BY_CASE, allowed

ROOT = Path(__file__).parents[2]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["test_rows", "test_loads", "test_saddle", "test_assembly"])
def test_everything_runs_without_the_compiler(name):
    """The same tests on plain Python: what a debugger and a coverage tool see."""
    command = [sys.executable, "-m", "pytest", "-q", "-x", *map(str, ROOT.glob(f"tests/*/{name}.py"))]
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    found = subprocess.run(command, env=environment, capture_output=True, text=True, cwd=ROOT)
    assert found.returncode == 0, found.stdout[-3000:]


@pytest.mark.slow
@pytest.mark.parametrize("rtol", [1e-6, 1e-7, 1e-8])
@pytest.mark.parametrize("shift", range(7, 13))
def test_the_change_point_passes_from_any_reference_point(shift, rtol):
    """Ten passages of a singular position."""
    case = cases.load("iftomm_A02_fourbar_N2", shift)
    solution = simulate(case.system, case.t_end, rtol=rtol, output=case.times)
    assert compare(case, solution).scaled_error < allowed(case, rtol)


@pytest.mark.slow
@pytest.mark.parametrize("rtol", [1e-9, 1e-10])
@pytest.mark.parametrize("shift", range(7, 13))
def test_tight_tolerances_keep_the_branch_or_stop_at_the_change_point(shift, rtol):
    """Steps end within 1e-3 rad of the position and closer; rounding over the square of that is the error."""
    case = cases.load("iftomm_A02_fourbar_N2", shift)
    try:
        solution = simulate(case.system, case.t_end, rtol=rtol, output=case.times)
    except IntegrationError as stop:  # 2 of 234 runs with masses that differ by rounding
        assert "singularity" in str(stop)
    else:
        assert compare(case, solution).scaled_error < 1e-2  # another branch is off by 1


@pytest.mark.slow
@pytest.mark.parametrize("name", cases.names(timed=True))
@pytest.mark.parametrize("shift", [21, 22, 23])
def test_cases_from_further_reference_points(name, shift):
    case, rtol = cases.load(name, shift), RTOL_BY_CASE.get(name, 1e-9)
    solution = simulate(case.system, case.t_end, rtol=rtol, output=case.times)
    assert compare(case, solution).scaled_error < allowed(case, rtol)
    assert solution.certificate.passed, solution.certificate.failures
