"""Processes with limits on time and memory, in which other programs read files from anywhere."""

import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ...base.errors import InputError

WALL_OVER_CPU_TIME = 5.0  # [1] of the processor time allowed, for the clock of a busy machine
TIMEOUT_EXIT_CODE = -getattr(signal, "SIGXCPU", 0) or None  # Windows has none
MEMORY_BYTES_MAX = 4 << 30  # [bytes] of address space, most of it never used


def limit(seconds: int) -> None:
    """Set bounds on memory and CPU time [s], where the system has them."""
    try:
        import resource
    except ImportError:  # Windows: the parent's clock alone
        return
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES_MAX, MEMORY_BYTES_MAX))
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def reply(seconds: int, work: Callable[[], dict[str, Any]]) -> None:
    """Print what ``work()`` returns, or its error, as JSON on the former standard output; all else is dropped."""
    out, quiet = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(quiet, 1)
    os.dup2(quiet, 2)
    limit(seconds)
    try:
        answer = work()
    except (Exception, MemoryError) as error:
        answer = {"error": " ".join(str(error).split()) or type(error).__name__}
    with os.fdopen(out, "w") as stream:
        json.dump(answer, stream)


def answer_of(module: str, arguments: list[str], timeout: float, who: str) -> dict[str, Any]:
    """Return what a guarded process prints as JSON, or raise an InputError if it takes too long or breaks off."""
    place = str(Path(__file__).resolve().parents[3])
    extra = {"PYTHONPATH": os.pathsep.join(filter(None, (place, os.environ.get("PYTHONPATH"))))}
    extra |= {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}  # every thread takes address space
    with tempfile.TemporaryDirectory() as folder:  # MuJoCo writes a log into its working directory
        try:
            command = [sys.executable, "-m", module, *arguments]
            done = subprocess.run(
                command, capture_output=True, cwd=folder, env=os.environ | extra, timeout=WALL_OVER_CPU_TIME * timeout
            )
            slow = done.returncode == TIMEOUT_EXIT_CODE
        except subprocess.TimeoutExpired:
            slow = True
    if slow:
        raise InputError(f"{who} takes more than {timeout:g} s to read it; make it smaller, or raise timeout")
    try:
        return json.loads(done.stdout)
    except ValueError:
        raise InputError(
            f"{who} broke off while reading it (exit code {done.returncode}): a limit of memory or time, or a fault; "
            "make the model smaller"
        ) from None
