"""Ledgers that a command keeps for itself: damaged or of other work, they are begun anew; a user's is never deleted."""

import sqlite3

import pytest

from mbsd3d.errors import InputError
from mbsd3d.extend import Store

WORK = {"sources": "a1", "budget": 2.0}


@pytest.fixture
def path(tmp_path):
    store = Store(tmp_path / "work.db", WORK, "validation")
    store.put("four-bar", {"error": 3e-9})
    store.close()
    return tmp_path / "work.db"


def garbled(path, how):
    content = bytearray(path.read_bytes())
    if how == "no database":
        content = b"<html>not a database</html>" * 40
    elif how == "torn":
        content = content[: len(content) // 2]
    else:
        content[200 : len(content) - 100] = b"\xa5" * (len(content) - 300)
    path.write_bytes(content)


@pytest.mark.parametrize("how", ["no database", "torn", "overwritten"])
def test_a_damaged_one_is_begun_anew_by_its_command(path, how):
    garbled(path, how)
    store = Store(path, WORK, "validation", replace=True)
    assert store.all() == {}
    store.put("slider", {"error": 1e-9})
    store.close()
    again = Store(path, WORK, "validation", replace=True)
    assert again.all() == {"slider": {"error": 1e-9}}
    again.close()


@pytest.mark.parametrize("how", ["no database", "overwritten"])
def test_a_users_one_is_refused_and_kept(path, how):
    garbled(path, how)
    before = path.read_bytes()
    with pytest.raises(InputError, match="ledger '.*work.db' cannot be"):
        Store(path, WORK, "sweep").all()
    assert path.read_bytes() == before


def test_a_whole_one_goes_on(path):
    store = Store(path, WORK, "validation", replace=True)
    assert store.all() == {"four-bar": {"error": 3e-9}}
    store.close()


def test_one_in_use_is_not_deleted(path):
    """Another process writes: that is no damage."""
    other = sqlite3.connect(path, isolation_level=None)
    other.execute("PRAGMA locking_mode=EXCLUSIVE")
    other.execute("BEGIN EXCLUSIVE")
    with pytest.MonkeyPatch.context() as patch:
        plain = sqlite3.connect
        patch.setattr(sqlite3, "connect", lambda *given, **options: plain(*given, timeout=0.05, **options))
        with pytest.raises(InputError, match="locked"):
            Store(path, WORK, "validation", replace=True)
    other.rollback()
    other.close()
    store = Store(path, WORK, "validation", replace=True)
    assert store.all() == {"four-bar": {"error": 3e-9}}
    store.close()
