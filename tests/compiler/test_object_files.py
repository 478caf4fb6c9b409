"""Compiled code on disk: damaged, without room, or written by two at once, it is compiled anew and never wrong."""

import errno
import subprocess
import sys
from types import SimpleNamespace

import numba
import numpy as np
import pytest
from helpers.kept_code import area, fresh, hits

from mbsd3d.compiler import object_files
from mbsd3d.compiler.object_files import CodeFiles
from mbsd3d.errors import InputError
from mbsd3d.extend import keep_code

pytestmark = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled")


@pytest.fixture
def kept(tmp_path):
    """A folder with the code of one signature, and its file."""
    assert fresh(tmp_path)(3.0, 4.0) == 6.0
    (file,) = tmp_path.rglob("*.code")
    return tmp_path, file


def test_code_is_read_back(kept):
    again = fresh(kept[0])
    assert again(3.0, 4.0) == 6.0 and hits(again) == 1


SCRIPT = """
import sys
from pathlib import Path
import numba
import numpy as np
from mbsd3d.extend import keep_code

def scaled(A, b, power):
    if b.size != A.shape[0]:
        raise ValueError("sizes differ")
    return (A[0] * b ** power).sum() // 0.3

function = keep_code(numba.njit(scaled), Path(sys.argv[1]))
A, b = np.array([[2.0, 0.3], [0.4, 3.1]]), np.array([0.7, -1.9])
print(function(A, b, 3))
try:
    function(A, b[:1], 3)
except ValueError as error:
    print(error)
print(sum(function.stats.cache_hits.values()), "numba.np.arraymath" in sys.modules)
"""


def test_a_process_that_compiles_nothing_does_not_load_the_compiler(tmp_path):
    """Code that allocates, calls functions of numba, and raises, works as where it was compiled."""
    (tmp_path / "scaled.py").write_text(SCRIPT)
    command = [sys.executable, str(tmp_path / "scaled.py"), str(tmp_path / "code")]
    (*first, said), (*again, then) = (subprocess.check_output(command, text=True).splitlines() for _ in range(2))
    assert first == again and first[-1] == "sizes differ" and (said, then) == ("0 True", "1 False")


@pytest.mark.parametrize("share", [0.0, 0.01, 0.5, 0.999])
@pytest.mark.parametrize("how", ["cut", "changed"])
def test_damaged_code_is_compiled_anew(kept, capsys, share, how):
    folder, file = kept
    content = bytearray(file.read_bytes())
    place = int(share * len(content))
    if how == "cut":
        content = content[:place]
    else:
        content[place] ^= 0x10
    file.write_bytes(content)
    again = fresh(folder)
    assert again(3.0, 4.0) == 6.0 and hits(again) == 0
    assert "is damaged; what is, is compiled anew" in capsys.readouterr().err
    mended = fresh(folder)
    assert mended(3.0, 4.0) == 6.0 and hits(mended) == 1 and capsys.readouterr().err == ""


def test_signatures_have_files_of_their_own(kept):
    """Whoever writes first: no name is given twice, as numbers from an index are by two processes at once."""
    folder, file = kept
    other = fresh(folder)
    assert other(3.0 + 1e-20j, 4.0).imag == 2e-20 and file in (files := set(folder.rglob("*.code")))
    assert len(files) == 2
    again = fresh(folder)
    assert np.isrealobj(again(3.0, 4.0)) and np.iscomplexobj(again(3.0 + 0j, 4.0)) and hits(again) == 2


def test_what_a_function_takes_from_around_it_is_part_of_the_name(tmp_path):
    def scaled(k):
        return keep_code(numba.njit(lambda x: k * x), tmp_path)

    assert [scaled(k)(3.0) for k in (2.0, 5.0, 2.0)] == [6.0, 15.0, 6.0]
    assert len(list(tmp_path.rglob("*.code"))) == 2


def test_processors_have_files_of_their_own(tmp_path):
    """A folder in a home that several machines share."""
    files, processors = (
        CodeFiles(area, tmp_path, False),
        [("cpu", "old", ""), ("cpu", "new", ""), ("cpu", "new", "+fma")],
    )
    targets = [SimpleNamespace(codegen=lambda x=x: SimpleNamespace(magic_tuple=lambda: x)) for x in processors]
    assert len({files.path("signature", target) for target in targets}) == 3


def test_without_room_it_is_said_once_and_used_all_the_same(tmp_path, monkeypatch, capsys):
    def full(path):
        raise InputError(f"'{path}' cannot be written") from OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(object_files, "atomic_write", full)
    function = fresh(tmp_path)
    assert function(3.0, 4.0) == 6.0 and function(3, 4) == 6.0
    said = capsys.readouterr().err
    assert said.count("No space left on device") == said.count("MBSD3D_CACHE") == 1


def test_a_folder_that_cannot_be_made(tmp_path, capsys):
    (tmp_path / "taken").write_text("a file")
    assert fresh(tmp_path / "taken")(3.0, 4.0) == 6.0
    assert "compiled code cannot be kept" in capsys.readouterr().err
