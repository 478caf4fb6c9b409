"""Installed versions, place of the compiled kernels, missing packages: the first thing to send with a bug report."""

import os
import platform
import re
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import click

from ..base.version import __version__

NAME_PATTERN, EXTRA_PATTERN = re.compile(r"[\w.-]+"), re.compile(r"extra == ['\"]([\w-]+)")
BASE_EXTRA = "base"


def revision() -> str:
    """Return what ``git describe`` says of a source tree, after a space; nothing for an installed package."""
    root = Path(__file__).resolve().parents[2]
    if not (root / ".git").exists():
        return ""
    command = ["git", "-C", str(root), "describe", "--tags", "--always", "--dirty"]
    try:
        found = subprocess.run(command, capture_output=True, text=True, timeout=10.0, check=True).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return ""
    return f" (source tree at {found})"


def needed() -> dict[str, list[str]]:
    """Return extra (`BASE_EXTRA` for what is always needed) -> names of distributions; empty where mbsd3d is not
    installed."""
    found: dict[str, list[str]] = {}
    try:
        lines = metadata.requires("mbsd3d") or []
    except metadata.PackageNotFoundError:
        return {}
    for line in lines:
        extra = EXTRA_PATTERN.search(line)
        found_name = NAME_PATTERN.match(line)
        name = found_name[0] if found_name else line
        if name != "mbsd3d":  # an extra that only names others
            found.setdefault(extra[1] if extra else BASE_EXTRA, []).append(name)
    return found


def installed(name: str) -> str | None:
    """Return the version of a distribution; None if it is missing."""
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None


def packages() -> list[str]:
    """Return one line per extra: versions, and how to install missing packages."""
    lines = []
    for extra, names in needed().items():
        versions = {name: installed(name) for name in names}
        text = ", ".join(f"{name} {version}" for name, version in versions.items() if version)
        lacking = [name for name, version in versions.items() if not version]
        if lacking:
            remedy = "pip install mbsd3d" if extra == BASE_EXTRA else f'pip install "mbsd3d[{extra}]"'
            text += f"{'; ' if text else ''}missing {', '.join(lacking)}: {remedy}"
        lines.append(f"{extra:<12}{text}")
    return lines or ["packages    mbsd3d is not installed: pip install ."]


def kernels() -> list[str]:
    """Return the place of compiled kernels, and whether all of them are there."""
    from ..compiler.cache_folder import CACHE_FOLDER, EQUATIONS_CACHE_FOLDER, is_warm, weak_folders

    files = (path for folder in (CACHE_FOLDER, EQUATIONS_CACHE_FOLDER) for path in folder.rglob("*") if path.is_file())
    size = sum(path.stat().st_size for path in files) / 1e6
    state = "compiled" if is_warm() else "not all compiled yet: mbsd3d warmup"
    if os.path.lexists(CACHE_FOLDER) and (weak := weak_folders(CACHE_FOLDER.parent, CACHE_FOLDER)):
        state = f"not kept, as a folder {weak}; see SECURITY.md"
    return [f"kernels     {state}; {size:.0f} MB in {CACHE_FOLDER}"]


def threads() -> list[str]:
    """Return the cores that this process may use, and the settings that change them."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    names = (
        "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS", "NUMBA_DISABLE_JIT", "MBSD3D_CACHE",
        "MBSD3D_PLAIN_NUMBA", "XDG_CACHE_HOME",
    )  # fmt: skip
    settings = [f"{name}={os.environ[name]}" for name in names if name in os.environ]
    return [f"threads     {cores} of {os.cpu_count()} cores{'; ' if settings else ''}{' '.join(settings)}"]


@click.command(epilog="Example: mbsd3d doctor")
def doctor() -> None:
    """Print versions, compiled kernels, threads and what is missing."""
    lines = [
        f"mbsd3d      {__version__}{revision()}",
        f"python      {platform.python_version()} ({sys.executable})",
        f"system      {platform.platform()}, {platform.machine()}",
        *threads(),
        *kernels(),
        *packages(),
    ]
    click.echo("\n".join(lines))
