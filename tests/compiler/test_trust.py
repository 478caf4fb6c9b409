"""Code on disk runs with the user's rights: none is read that anybody else can have written, and none is unpickled."""

import os
import pickle
import shutil
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest
from helpers.kept_code import area, fresh, hits

from mbsd3d.compiler import cache_folder, object_files
from mbsd3d.compiler.object_files import checksum
from mbsd3d.extend import keep_code

pytestmark = [
    pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled"),
    pytest.mark.skipif(os.name != "posix", reason="owners and modes of POSIX"),
]
NAMES = ("MBSD3D_CACHE", "XDG_CACHE_HOME", "HOME", "TMPDIR", "TEMP", "TMP")


@pytest.fixture
def surroundings(tmp_path, monkeypatch):
    """A home, a folder for temporary files and a working directory; the names in the environment can be set."""
    for name in NAMES:
        monkeypatch.delenv(name, raising=False)
    for name in ("home", "temporary", "downloaded"):
        (tmp_path / name).mkdir()
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("TMPDIR", str(tmp_path / "temporary"))
    monkeypatch.chdir(tmp_path / "downloaded")
    return tmp_path


USUAL = "home/.cache/mbsd3d"
FALLBACK = f"temporary/mbsd3d-{os.geteuid() if os.name == 'posix' else ''}"


@pytest.mark.parametrize(
    ("given", "folder"),
    [
        ({}, USUAL),
        ({"XDG_CACHE_HOME": ""}, USUAL),
        ({"XDG_CACHE_HOME": "."}, USUAL),
        ({"XDG_CACHE_HOME": "caches/mine"}, USUAL),
        ({"MBSD3D_CACHE": ""}, USUAL),
        ({"MBSD3D_CACHE": "kernels"}, USUAL),
        ({"MBSD3D_CACHE": "../temporary"}, USUAL),
        ({"MBSD3D_CACHE": "", "XDG_CACHE_HOME": ""}, USUAL),
        ({"MBSD3D_CACHE": "~/kernels"}, "home/kernels"),
        ({"XDG_CACHE_HOME": "~/caches"}, "home/caches/mbsd3d"),
        ({"MBSD3D_CACHE": "~nobody-of-this-name/kernels"}, USUAL),
        ({"HOME": ""}, FALLBACK),
        ({"HOME": "."}, FALLBACK),
        ({"HOME": "/dev/null"}, FALLBACK),
        ({"HOME": "", "XDG_CACHE_HOME": "~/caches"}, FALLBACK),
    ],
)
def test_the_folder_is_never_in_the_working_directory(surroundings, monkeypatch, given, folder):
    for name, value in given.items():
        monkeypatch.setenv(name, value)
    if given.get("HOME") == "" and "XDG_CACHE_HOME" in given:  # expands to the top folder, where root may write
        assert surroundings / "downloaded" not in cache_folder._cache_root().parents
        return
    assert cache_folder._cache_root() == surroundings / folder


def test_a_named_folder_is_taken_as_it_is(surroundings, monkeypatch):
    monkeypatch.setenv("MBSD3D_CACHE", str(surroundings / "kernels"))
    assert cache_folder._cache_root() == surroundings / "kernels" and not (surroundings / "kernels").exists()


def test_without_home_and_user_nobody_is_asked_for_it(surroundings, monkeypatch):
    """A container that is run by a number."""

    def unknown(number):
        raise KeyError(f"getpwuid(): uid not found: {number}")

    monkeypatch.delenv("HOME")
    monkeypatch.setattr("pwd.getpwuid", unknown)
    assert cache_folder._cache_root() == surroundings / FALLBACK
    monkeypatch.setenv("XDG_CACHE_HOME", str(surroundings / "caches"))
    assert cache_folder._cache_root() == surroundings / "caches" / "mbsd3d"


@pytest.mark.parametrize("name", ["", ".", "downloaded"])
def test_temporary_files_do_not_go_to_the_working_directory(surroundings, monkeypatch, name):
    """`tempfile` takes it where there is no other folder, and for a relative name."""
    monkeypatch.setenv("TMPDIR", name)
    monkeypatch.setenv("HOME", "")
    assert cache_folder._cache_root().parent in (Path("/tmp"), Path("/var/tmp"), Path(os.devnull))


def test_a_folder_that_is_made_is_open_to_this_user_alone(surroundings, monkeypatch):
    monkeypatch.setenv("HOME", "/dev/null")
    root, before = cache_folder._cache_root(), os.umask(0o002)  # the umask of many systems, by which groups may write
    try:
        assert fresh(root / "digest")(3.0, 4.0) == 6.0
    finally:
        os.umask(before)
    made = [root, *root.rglob("*")]
    assert len(made) == 4 and all(path.stat().st_mode & 0o077 == 0 for path in made)
    again = fresh(root / "digest")
    assert again(3.0, 4.0) == 6.0 and hits(again) == 1


@pytest.fixture
def kept(tmp_path):
    """(folder of the digest, file of the code) below a root that is private."""
    root = tmp_path / "root"
    assert fresh(root / "digest")(3.0, 4.0) == 6.0
    (file,) = root.rglob("*.code")
    return root / "digest", file


def places(kept):
    """From the root of the cache to the file."""
    folder, file = kept
    return [folder.parent, folder, file.parent, file]


@pytest.mark.parametrize("depth", range(4))
@pytest.mark.parametrize("mode", [0o020, 0o002])
def test_what_others_can_write_is_not_run(kept, capsys, depth, mode):
    place = places(kept)[depth]
    place.chmod(place.stat().st_mode | mode)
    again = fresh(kept[0])
    assert again(3.0, 4.0) == 6.0 and hits(again) == 0
    assert again(3, 4) == 6 and hits(again) == 0
    assert capsys.readouterr().err.count("can be written by others") == 1
    third = fresh(kept[0])  # a file is replaced by one's own, a folder is as it was
    assert third(3.0, 4.0) == 6.0 and hits(third) == (depth == 3)
    assert len(list(kept[0].rglob("*.code"))) == (2 if depth == 3 else 1)


@pytest.mark.parametrize("depth", range(4))
def test_links_are_not_followed(kept, tmp_path, capsys, depth):
    place = places(kept)[depth]
    shutil.move(place, tmp_path / "elsewhere")
    place.symlink_to(tmp_path / "elsewhere")
    again = fresh(kept[0])
    assert again(3.0, 4.0) == 6.0 and hits(again) == 0
    assert capsys.readouterr().err.count("is a link") == 1


def test_another_users_folder_is_not_used(kept, monkeypatch, capsys):
    """Made beforehand under the name that is known: neither read nor written."""
    before = kept[1].read_bytes()
    monkeypatch.setattr(cache_folder.os, "geteuid", lambda: os.getuid() + 1)
    again = fresh(kept[0])
    assert again(3.0, 4.0) == 6.0 and again(3, 4) == 6 and hits(again) == 0
    said = capsys.readouterr().err
    assert said.count("belongs to another user") == said.count("MBSD3D_CACHE") == 1
    assert [*kept[0].rglob("*.code")] == [kept[1]] and kept[1].read_bytes() == before


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root gives files away")
@pytest.mark.parametrize("depth", range(4))
def test_what_belongs_to_another_user_is_not_run(kept, capsys, depth):
    os.chown(places(kept)[depth], 12345, -1)
    again = fresh(kept[0])
    assert again(3.0, 4.0) == 6.0 and hits(again) == 0
    assert capsys.readouterr().err.count("belongs to another user") == 1


class Payload:
    """Leaves a file where it is unpickled."""

    def __init__(self, place):
        self.place = place

    def __reduce__(self):
        return Path.touch, (self.place,)


def test_nothing_is_unpickled(kept, tmp_path):
    """Not even what stands in the user's own folder, with the sum that fits."""
    for content in (pickle.dumps(Payload(tmp_path / "run")), b"\x00" * 100, b"", (3).to_bytes(8, "little") + b"{}]"):
        kept[1].write_bytes(checksum(content) + content)
        again = fresh(kept[0])
        assert again(3.0, 4.0) == 6.0 and hits(again) == 0
    assert not (tmp_path / "run").exists()


def test_a_file_brings_no_module_in(kept, tmp_path, monkeypatch):
    """Names lead to what is there already: code found on disk has nothing imported."""
    (tmp_path / "foreign.py").write_text("raise SystemExit('imported')")
    monkeypatch.syspath_prepend(tmp_path)
    content = kept[1].read_bytes()[object_files.CHECKSUM_BYTES :]
    size = int.from_bytes(content[:8], "little")
    text = content[8 : 8 + size].replace(b'"needed": []', b'"needed": [["s", "foreign", "f", []]]')
    content = len(text).to_bytes(8, "little") + text + content[8 + size :]
    kept[1].write_bytes(checksum(content) + content)
    again = fresh(kept[0])
    assert again(3.0, 4.0) == 6.0 and hits(again) == 0 and "foreign" not in sys.modules


def test_types_go_to_disk_and_back(tmp_path):
    """Whatever kernels take and return: records, named tuples by value and by reference, complex, none."""
    from helpers.kept_code import Inner, Outer

    given = Outer(Inner(3, np.arange(5.0)), 0.25, np.zeros(5, [("p", float, 3), ("k", np.int32)]), (7.0, 2.0))
    table = np.asfortranarray(np.arange(6.0).reshape(2, 3))
    table.setflags(write=False)

    def parts(outer, table, z, flag):
        return outer.limits, (outer.factor, 3, z, flag), table[1, 2] + outer.table[2].p[1] + outer.inner.weights[4]

    for found in (0, 1):
        made = keep_code(numba.njit(parts), tmp_path)
        assert made(given, table, 2.0 + 1j, True) == ((7.0, 2.0), (0.25, 3, 2.0 + 1j, True), 9.0)
        assert hits(made) == found


def test_what_cannot_be_written_is_compiled_at_every_start(tmp_path, capsys):
    for _ in range(2):
        made = keep_code(numba.njit(lambda time: time), tmp_path)
        assert made(np.timedelta64(3, "s")) == np.timedelta64(3, "s") and hits(made) == 0
    assert not list(tmp_path.rglob("*.code")) and capsys.readouterr().err == ""


@pytest.mark.parametrize("name", cache_folder.CODE_SETTINGS)
def test_other_settings_are_other_code_and_another_marker(monkeypatch, tmp_path, name):
    monkeypatch.setattr(cache_folder, "CACHE_FOLDER", tmp_path / "digest")
    folder, names = tmp_path / "code", []
    for value in ("1", "2"):
        monkeypatch.setattr(numba.config, name, getattr(numba.config, name) if value == "1" else 7)
        cache_folder.marker.cache_clear()
        names.append(cache_folder.marker("kernels").name)
    cache_folder.marker.cache_clear()
    assert len(set(names)) == 2 and folder not in tmp_path.iterdir()


def test_another_python_is_not_warm(monkeypatch, tmp_path):
    """Whose code is under other names: it would compile for minutes without a word."""
    monkeypatch.setattr(cache_folder, "CACHE_FOLDER", tmp_path / "root" / "digest")
    cache_folder.marker.cache_clear()
    cache_folder.mark_warm.cache_clear()
    cache_folder.mark_warm("loop")
    assert cache_folder.is_warm("loop") and not cache_folder.is_warm("another loop")
    for other in ((3, 99, 0), (4, 0, 0)):
        cache_folder.marker.cache_clear()
        with monkeypatch.context() as patch:
            patch.setattr(cache_folder.sys, "version_info", other)
            assert not cache_folder.is_warm("loop")
    cache_folder.marker.cache_clear()
    assert cache_folder.is_warm("loop")
    (tmp_path / "root").chmod(0o777)
    assert not cache_folder.is_warm("loop")
    cache_folder.marker.cache_clear()
    cache_folder.mark_warm.cache_clear()


WHERE = "from mbsd3d.compiler.cache_folder import CACHE_FOLDER; print(CACHE_FOLDER)"


@pytest.mark.slow
def test_a_container_run_by_number(tmp_path):
    """No home and no entry for the user: a user namespace makes one whom nobody knows."""
    unshare = shutil.which("unshare")
    given = [unshare or "", "--user", "--map-user=54321", "--map-group=54321"]
    if unshare is None or subprocess.run([*given, "true"], capture_output=True).returncode:
        pytest.skip("user namespaces cannot be made here")
    command = [*given, sys.executable, "-c", WHERE]
    environment = {"TMPDIR": str(tmp_path), "PYTHONPATH": str(Path(cache_folder.PACKAGE_FOLDER).parent)}
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert Path(done.stdout.strip()).parent == tmp_path / "mbsd3d-54321"


def test_the_plain_function_stays(tmp_path):
    assert keep_code(area, tmp_path) is area
