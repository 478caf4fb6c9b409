"""Kernels that are compiled when they are first called: none earlier, each once, with the numbers of plain Python."""

import subprocess
import sys
import time

import numba
import numpy as np
import pytest
from numba.core import types

from mbsd3d.compiler import announcing
from mbsd3d.compiler import late as module
from mbsd3d.compiler.jit import inner_kernel, kernel, late_kernel
from mbsd3d.compiler.late import FAILED, late_choice

pytestmark = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled")


@pytest.fixture
def compiled(monkeypatch):
    """Names of what has been compiled for a cell, in order."""
    found, plain = [], module.Late.compiled

    def noted(self, passed, number):
        found.append(self.kernels[number].__name__)
        return plain(self, passed, number)

    monkeypatch.setattr(module.Late, "compiled", noted)
    return found


def pair(x):
    """Real or complex, as its argument."""
    return types.UniTuple(x, 2)


def test_it_is_compiled_at_the_first_call_and_once(compiled):
    @late_kernel
    def heavy(x) -> pair:
        return 3.0 * x, x * x

    @kernel
    def light(x, much):
        return heavy(x)[0] + heavy(x)[1] if much else x

    assert light(2.0, False) == 2.0 and compiled == []
    assert light(2.0, True) == 10.0 and light(5.0, True) == 40.0 and compiled == ["heavy"]
    assert light(2.0 + 1j, True) == 9.0 + 7.0j and compiled == ["heavy", "heavy"]


def test_cells_for_other_types_have_other_names():
    @late_kernel
    def heavy(x) -> pair:
        return 3.0 * x, x * x

    known = [(one,) for one in (types.float64, types.complex128)]
    symbols = [heavy.symbol(passed) for passed in known]
    assert [module.LATE[symbol][2] for symbol in symbols] == known
    for symbol in symbols:  # nobody else can find a kernel of this test
        del module.LATE[symbol]


def test_a_number_says_which(compiled):
    @inner_kernel
    def double(a, x):
        a[0] = 2.0 * x

    @inner_kernel
    def square(a, x):
        a[0] = x * x

    either = late_choice(__name__, "either", (double, square))

    @kernel
    def all_of(which, a, x):
        for number in which:
            either(number, a, x)

    a = np.zeros(1)
    all_of(np.array([1, 1]), a, 5.0)
    assert a[0] == 25.0 and compiled == ["square"]
    all_of(np.array([1, 0]), a, 5.0)
    assert a[0] == 10.0 and compiled == ["square", "double"]


@pytest.mark.slow
def test_ctrl_c_waits_for_the_kernel(monkeypatch):
    @late_kernel
    def slow(x) -> float:
        return 7.0 * x

    @kernel
    def above(x):
        return slow(x)

    plain, tries = module.Late.compiled, []

    def interrupted(self, passed, number):
        tries.append(number)
        if len(tries) == 1:
            raise KeyboardInterrupt
        return plain(self, passed, number)

    monkeypatch.setattr(module.Late, "compiled", interrupted)
    found = []
    with pytest.raises(KeyboardInterrupt):
        found.append(above(2.0))
        time.sleep(10.0)
    assert found == [14.0] and above(3.0) == 21.0 and len(tries) == 2


WRONG = """
from mbsd3d.compiler.jit import kernel, late_kernel
@late_kernel
def wrong(x) -> int: return 0.5 * x
@kernel
def above(x): return wrong(x)
above(1.0)
"""


def test_one_that_cannot_be_compiled_ends_the_process(tmp_path):
    (tmp_path / "wrong.py").write_text(WRONG)
    done = subprocess.run([sys.executable, "wrong.py"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == FAILED and "wrong returns float64, not int64" in done.stderr


def test_a_long_compilation_is_said(monkeypatch, capsys):
    monkeypatch.setattr(announcing, "SILENT", 0.05)
    with announcing.not_silent("tyre"):
        time.sleep(0.2)
    with announcing.not_silent("spring"):
        pass
    assert capsys.readouterr().err == "mbsd3d: compiling tyre, once after installation ...\n"
