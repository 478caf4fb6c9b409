"""What this package takes from numba beyond its documented interface is there, and is taken in one place."""

import ast
import os
import subprocess
import sys
from pathlib import Path

import numba
import pytest

import mbsd3d
from mbsd3d.compiler import numba_private

SOURCES = sorted(Path(mbsd3d.__file__).parent.rglob("*.py"))
PRIVATE = ("numba.core", "llvmlite", "numba.np", "numba.typed")


def imported(path):
    """Return the modules that a file imports."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and not node.level:
            yield node.module
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)


def test_one_file_takes_what_is_private():
    found = {path.name for path in SOURCES for name in imported(path) if name.startswith(PRIVATE)}
    assert found == {"numba_private.py"}


@pytest.mark.parametrize("name", numba_private.__all__)
def test_every_name_is_there(name):
    assert getattr(numba_private, name) is not None


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled")
def test_libraries_say_what_they_define_and_call():
    @numba.njit
    def inner(x):
        return 2.0 * x

    inner(1.0)
    made = inner.overloads[(numba.float64,)]
    assert numba_private.address_of(made) > 0 and "inner" in numba_private.symbol_of(made)
    name, kind, (code, _) = numba_private.object_code(made)
    assert kind == "object" and code and name
    assert isinstance(numba_private.declarations(made), list) and not numba_private.is_compiling()


PLAIN = """
from numba.core.dispatcher import Dispatcher
from mbsd3d.compiler.decorators import kernel, late_kernel
from mbsd3d.compiler.late import late_choice
@late_kernel
def half(x) -> float: return 0.5 * x
@kernel
def above(x): return half(x) + 1.0
@kernel
def first(a): a[0] = 1.0
@kernel
def second(a): a[0] = 2.0
choose = late_choice(__name__, "choose", [first, second])
@kernel
def chosen(k, a): choose(k, a)
import numpy as np
a = np.zeros(1)
chosen(1, a)
print(isinstance(half, Dispatcher), above(3.0), a[0], type(above._cache).__name__)
"""


@pytest.mark.slow
@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled")
def test_plain_numba_does_without_files_and_late_kernels(tmp_path):
    (tmp_path / "plain.py").write_text(PLAIN)
    done = subprocess.run(
        [sys.executable, "plain.py"], cwd=tmp_path, capture_output=True, text=True,
        env={**os.environ, "MBSD3D_PLAIN_NUMBA": "1"},
    )  # fmt: skip
    assert done.stdout.split() == ["True", "2.5", "2.0", "NullCache"], done.stderr
