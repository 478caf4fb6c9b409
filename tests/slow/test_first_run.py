"""The first run of all: two processes compile what it needs, and no more."""

import os
import subprocess
import sys

import pytest

RUN = """
from mbsd3d import GROUND, Body, Revolute, System, simulate
arm = Body("arm", 2.0, (0.1, 0.2, 0.25), com=(0.5, 0.1, 0.0))
hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=(1, 2, 3))
print(repr(simulate(System([arm], [hinge]), 0.5).angle(hinge)[-1]))
"""


def started(cache, **more):
    given = {"env": os.environ | {"MBSD3D_CACHE": str(cache)} | more, "capture_output": True, "text": True}
    done = subprocess.run([sys.executable, "-c", RUN], check=True, **given)
    return done, [file.name.partition(".")[0] for file in cache.rglob("*.code")]


@pytest.mark.slow
def test_the_first_run_compiles_what_it_needs_by_two(tmp_path):
    alone, one = started(tmp_path / "one", MBSD3D_SECOND="1")
    both, two = started(tmp_path / "two")
    assert both.stdout == alone.stdout and "compiling kernels" in both.stderr
    assert sorted(set(one)) == sorted(set(two)) and {"advance", "evaluate", "kinematics"} <= set(two)
    assert not set(two) & {"tyre", "contact", "solve_dense", "factor_loops", "roll", "mesh", "spline", "first_crossing"}
    again, _ = started(tmp_path / "two")
    assert again.stdout == alone.stdout and again.stderr == ""
