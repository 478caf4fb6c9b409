"""Models of other programs: MJCF and URDF, read by MuJoCo in a separate process.

What has no counterpart here is named in an error; it is left out only if the caller names its kind in ``drop``.
"""

import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from math import ceil
from pathlib import Path
from typing import Any

from ...base.checks import as_tuple, number, short_repr
from ...base.errors import InputError
from ...base.paths import as_path
from .builder import KINDS, Builder, Imported
from .xml_scan import Scan

SUFFIXES = {"mujoco": "xml", "robot": "urdf"}  # by the root of the file
LONGEST = 86400.0  # s
WALL_OVER_CPU_TIME = 5.0  # times the processor time allowed: what the clock may show on a busy machine
OUT_OF_TIME = -getattr(signal, "SIGXCPU", 0) or None  # exit code; Windows has none


def read_xml(path: str | Path, kind: str, drop: Sequence[str], timeout: float) -> Imported:
    """Scan, let the worker compile, build."""
    path, timeout = as_path(path, f"model.{SUFFIXES[kind]}"), number(timeout, "timeout", positive=True)
    if timeout > LONGEST:
        raise InputError(f"timeout: {timeout:g} s is more than a day; give at most {LONGEST:g}")
    drop = (drop,) if isinstance(drop, str) else as_tuple(drop, "drop", "kinds of parts")
    if unknown := [x for x in drop if not isinstance(x, str) or x not in KINDS]:
        raise InputError(
            f"'{path}': drop: {short_repr(unknown[0])} is not a kind of part; give some of {', '.join(KINDS)}"
        )
    scan = Scan(path)
    scan.read(path)
    scan.check_named()
    if path.suffix[1:] not in SUFFIXES.values():
        raise InputError(f"'{path}': MuJoCo reads files by their name; give it one that ends in .{SUFFIXES[kind]}")
    if scan.kind != kind:
        raise InputError(f"'{path}': its root is <{scan.kind}>, not <{kind}>; use the reader of its format")
    try:
        return Builder(compiled_facts(path, kind, timeout), scan.unknown, drop).build()
    except ValueError as error:
        raise InputError(f"'{path}': {error}") from error


def compiled_facts(path: Path, kind: str, timeout: float) -> dict[str, Any]:
    """What the worker says, or why it says nothing."""
    command = [sys.executable, "-m", "mbsd3d.files.importing.worker", str(path.absolute()), str(ceil(timeout)), kind]
    place = str(Path(__file__).resolve().parents[3])
    extra = {"PYTHONPATH": os.pathsep.join(filter(None, (place, os.environ.get("PYTHONPATH"))))}
    extra |= {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}  # every thread takes address space
    with tempfile.TemporaryDirectory() as folder:  # MuJoCo writes a log into its working directory
        try:
            done = subprocess.run(
                command, capture_output=True, cwd=folder, env=os.environ | extra, timeout=WALL_OVER_CPU_TIME * timeout
            )
            slow = done.returncode == OUT_OF_TIME
        except subprocess.TimeoutExpired:
            slow = True
    if slow:
        raise InputError(f"MuJoCo takes more than {timeout:g} s to read it; make it smaller, or raise timeout")
    try:
        answer = json.loads(done.stdout)
    except ValueError:
        raise InputError(
            f"MuJoCo broke off while reading it (exit code {done.returncode}): a limit of memory or time, or a fault; "
            "make the model smaller"
        ) from None
    if "error" in answer:
        raise InputError(f"MuJoCo cannot read it: {answer['error']}")
    return answer["facts"]
