"""Conditions of speed measurements: processor, cores, versions, load."""

import os
import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path


def machine(*packages: str) -> str:
    """Return processor class, cores, versions of Python and of ``packages``, load; none of them is imported.

    ``packages``: names of distributions; those that are not installed are said to be absent.

    Examples
    --------
    >>> "no-such-engine absent" in machine("numpy", "no-such-engine")
    True
    """
    cpu = Path("/proc/cpuinfo")
    lines = cpu.read_text().splitlines() if cpu.is_file() else []
    names = [text.split(":")[1].strip() for text in lines if text.startswith("model name")]
    name = names[0] if names else platform.processor() or platform.machine()
    versions = ", ".join([f"Python {platform.python_version()}", *map(installed, packages)])
    load = f"; load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    return f"{name}, {os.cpu_count()} cores; {versions}{load}"


def installed(package: str) -> str:
    """Return name and version of a distribution."""
    try:
        return f"{package} {version(package)}"
    except PackageNotFoundError:
        return f"{package} absent"
