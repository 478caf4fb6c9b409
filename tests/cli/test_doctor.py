"""`mbsd3d doctor`: what a report of a bug must say, and what it says of a package that is missing."""

from importlib import metadata

from click.testing import CliRunner

from mbsd3d import __version__
from mbsd3d.cli import doctor
from mbsd3d.compiler import cache_folder
from mbsd3d.extend import CACHE_FOLDER, main


def said():
    result = CliRunner().invoke(main, ["doctor"])
    assert result.exit_code == 0
    return {line.split()[0]: line for line in result.output.splitlines()}


def test_doctor_says_versions_kernels_and_threads():
    lines = said()
    assert __version__ in lines["mbsd3d"] and str(CACHE_FOLDER) in lines["kernels"] and "cores" in lines["threads"]
    assert f"numpy {metadata.version('numpy')}" in lines["base"] and "missing" not in lines["base"]


def test_doctor_says_why_kernels_are_not_kept(tmp_path, monkeypatch):
    (tmp_path / "root" / "digest").mkdir(parents=True)
    (tmp_path / "root").chmod(0o777)
    monkeypatch.setattr(cache_folder, "CACHE_FOLDER", tmp_path / "root" / "digest")
    assert "not kept, as a folder can be written by others; see SECURITY.md" in said()["kernels"]


def test_doctor_names_what_is_missing_and_its_extra(monkeypatch):
    module = __import__("mbsd3d.cli.doctor", fromlist=["installed"])
    known = module.installed
    monkeypatch.setattr(module, "installed", lambda name: None if name == "distributed" else known(name))
    assert 'missing distributed: pip install "mbsd3d[cluster]"' in said()["cluster"]


def test_doctor_runs_where_mbsd3d_is_not_installed(monkeypatch):
    def no_metadata(name):
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(metadata, "requires", no_metadata)
    assert "pip install ." in said()["packages"]


def test_doctor_is_a_command():
    assert doctor is main.commands["doctor"]
