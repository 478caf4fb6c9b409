"""Where compiled code is kept: in a folder named after the digest of what it was made from."""

import hashlib
import os
import re
import tempfile
from contextlib import suppress
from functools import cache
from pathlib import Path

import numba

PACKAGE = Path(__file__).resolve().parent.parent
A_KERNEL = re.compile(rb"^\s*@\w*kernel\b", re.MULTILINE)


def compiled_sources() -> list[Path]:
    """All files of every folder that holds a kernel, and this one: what kernels use is in one of them."""
    files = sorted(PACKAGE.rglob("*.py"))
    folders = {Path(__file__).resolve().parent, *(path.parent for path in files if A_KERNEL.search(path.read_bytes()))}
    return [path for path in files if path.parent in folders]


def _digest(sources: list[Path]) -> str:
    """Digest of sources that are compiled: numba alone misses an edit in a callee of another file."""
    text = hashlib.sha256(numba.__version__.encode())
    for path in sources:
        text.update(path.read_bytes())
    return text.hexdigest()[:16]


def _cache_root() -> Path:
    """``$MBSD3D_CACHE``, else the user's cache folder, else a folder of the user's own in the temporary directory."""
    if "MBSD3D_CACHE" in os.environ:
        return Path(os.environ["MBSD3D_CACHE"])
    home = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
    root = home / "mbsd3d"
    try:
        root.mkdir(parents=True, exist_ok=True)
    except OSError:
        root = Path(tempfile.gettempdir()) / f"mbsd3d-{os.getuid() if hasattr(os, 'getuid') else 'cache'}"
    return root


# No other kernel uses the integrators: an edit there leaves the code of all others valid.
INTEGRATORS = "integrators"
CACHE = _cache_root() / _digest(compiled_sources())
EQUATIONS = CACHE.parent / _digest([path for path in compiled_sources() if path.parent.name != INTEGRATORS])


def marker(part: str) -> Path:
    """The file that says a part has been compiled."""
    return CACHE / f"complete-{part.replace(' ', '-')}"


def is_warm(part: str = "kernels") -> bool:
    """True when a part of the compiled code of exactly this source is on disk, or none is compiled at all."""
    return bool(numba.config.DISABLE_JIT) or marker(part).exists()


@cache
def mark_warm(part: str = "kernels") -> None:
    """Note on disk that a part has been compiled."""
    if not is_warm(part):
        with suppress(OSError):  # said where the code itself could not be written
            CACHE.mkdir(parents=True, exist_ok=True)
            marker(part).touch()
