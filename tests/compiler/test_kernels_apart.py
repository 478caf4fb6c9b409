"""Kernels that call each other by name, and structures that go by address: the numbers are those of numba's own way."""

import subprocess
import sys

import numba
import numpy as np
import pytest
from helpers.kept_code import Inner, Outer

pytestmark = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled")

KERNELS = """
import sys
from pathlib import Path
import numba
from mbsd3d.compiler.object_files import keep_code

def one_more(count): return [numba.njit(lambda x, k=k: x + k)(1.0) for k in range(count)]
one_more(int(sys.argv[2]))  # so that numba numbers what follows otherwise

@numba.njit
def below(x): return 3.0 * x
@numba.njit
def above(x): return 1.0 + below(x) * below(x + 1.0)
@numba.njit
def within(x): return below(x) - 1.0
@numba.njit
def top(x): return 11.0 * within(x)
below, above, top = (keep_code(made, Path(sys.argv[1]), apart=True) for made in (below, above, top))
within = keep_code(within, Path(sys.argv[1]))
"""
RUN = "import pair; print(pair.{0}(2.0), *(sum(f._cache_hits.values()) for f in (pair.{0}, pair.below)))"


def start(folder, before, name="above"):
    """Value of a kernel, and whether its code and that of `below` were found on disk, in a process of its own."""
    given = [sys.executable, "-c", RUN.format(name), folder / "code", str(before)]
    done = subprocess.run(given, cwd=folder, capture_output=True)
    assert done.returncode == 0, done.stderr.decode()
    value, *found = done.stdout.split()
    assert float(value) == 55.0
    return [int(hits) for hits in found]


@pytest.mark.slow
def test_the_one_that_is_called_may_come_from_another_process(tmp_path):
    (tmp_path / "pair.py").write_text(KERNELS)
    assert start(tmp_path, 0) == [0, 0]
    assert start(tmp_path, 0) == [1, 1]
    (called,) = tmp_path.rglob("below*.code")
    called.unlink()
    assert start(tmp_path, 3) == [1, 0]  # compiled anew, under another name than its caller knows
    assert start(tmp_path, 1) == [1, 1]


@pytest.mark.slow
def test_a_name_of_another_process_is_handed_on(tmp_path):
    """`top` takes in `within`, from a file that calls `below` by the name it had in the process that wrote it."""
    (tmp_path / "pair.py").write_text(KERNELS)
    assert start(tmp_path, 0, "top") == [0, 0]
    for file in (*tmp_path.rglob("below*.code"), *tmp_path.rglob("top*.code")):
        file.unlink()
    assert start(tmp_path, 3, "top")[0] == 0
    assert start(tmp_path, 1, "top") == [1, 1]


def test_the_caller_holds_no_copy(tmp_path):
    (tmp_path / "pair.py").write_text(KERNELS)
    code = "import pair; pair.above(2.0); (text,) = pair.above.inspect_llvm().values(); print(text)"
    given = [sys.executable, "-c", code, tmp_path / "code", "0"]
    lines = subprocess.run(given, cwd=tmp_path, capture_output=True, text=True, check=True).stdout.splitlines()
    assert [line.split()[0] for line in lines if "4pair5below" in line and "@_ZN" in line and "call" not in line] == [
        "declare"
    ]


LATER = """
from numba.core import event
with event.install_recorder("numba:compile") as found:
    from mbsd3d import DOP853, GROUND, Body, GeneralizedAlpha, RadauIIA, Revolute, System, simulate
    arm = Body("arm", 2.0, (0.1, 0.2, 0.25), com=(0.5, 0.1, 0.0))
    for method in (DOP853(), RadauIIA(), GeneralizedAlpha(dt=1e-2)):
        simulate(System([arm], [Revolute(GROUND, arm, at=(0, 0, 0), axis=(1, 2, 3))]), 0.05, method=method).certificate
print([made.data["dispatcher"] for _, made in found.buffer if made.is_start])
"""


@pytest.mark.slow
def test_a_later_process_compiles_nothing():
    def compiled():
        given = [sys.executable, "-c", LATER]
        return subprocess.run(given, capture_output=True, text=True, check=True).stdout.strip()

    assert compiled() == "[]" or compiled() == "[]"  # the first one may be the first of all


@numba.njit(_nrt=False, no_cpython_wrapper=True)
def mark(outer, i):
    outer.table[i].p[1] += outer.factor
    return outer.inner.weights[i] * outer.limits[1] + outer.inner.count


@numba.njit(_nrt=False)
def total(outer):
    found = 0.0
    for i in range(outer.table.shape[0]):
        found += mark(outer, i)
    return found


def test_structures_go_by_address():
    outer = Outer(Inner(3, np.arange(5.0)), 0.25, np.zeros(5, [("p", float, 3)]), (7.0, 2.0))
    for times in (1, 2):
        assert total(outer) == 35.0
        assert np.array_equal(outer.table["p"], np.tile([0.0, 0.25 * times, 0.0], (5, 1)))
    assert total(outer._replace(limits=(0.0, 1.0), factor=0.0)) == 25.0
    other = outer._replace(inner=Inner(1, np.arange(5) * 1j))
    assert total(other) == 5 + 20j and len(total.signatures) == 2
    with pytest.raises(numba.errors.TypingError, match="Unknown attribute 'missing'"):
        numba.njit(lambda outer: outer.missing)(outer)
