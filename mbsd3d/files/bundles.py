"""Bundles: a run with all that is needed to make it again, in one file, and its verification.

A bundle is an uncompressed zip file: the solution (model, settings, samples), the model and the certificate as text,
versions and processor, a comparison with other engines, files attached, and a proof with the digest (SHA-256) of each
and of the run made again. Digests find damage and mistakes; they are no signature, since whoever changes an entry can
write its new digest too.
"""

import hashlib
import io
import json
import platform
import zipfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..base.checks import as_tuple, short_repr
from ..base.errors import InputError, MbsError
from ..base.paths import as_path, package_version, with_suffix, write_atomically
from ..base.style import Result
from ..compiler.numba_private import llvm
from ..kernels.kinds import ANGLE, SLIDE
from ..mechanism.mechanism import Mechanism
from ..mechanism.state import State
from ..results.certificate import Certificate, certificate_of
from ..results.result import RunResult
from ..run.global_error import distances
from ..run.repeat import repeat
from .description import describe, read_system
from .solutions import DAMAGED_FILE_ERRORS, STATE_SLICES, STORED_ARRAYS, read_solution, solution_bytes

BUNDLE_KIND, BUNDLE_VERSION = "mbsd3d bundle", 1
SOLUTION, MODEL, CERTIFICATE, ENVIRONMENT, PROOF = (
    "solution.npz", "model.json", "certificate.txt", "environment.json", "proof.json",
)  # fmt: skip
COMPARISON = "comparison.json"  # with other engines, where it was given
ATTACHED = "attached/"
PACKAGES = ("numpy", "scipy", "numba", "llvmlite")
MOMENT = (1980, 1, 1, 0, 0, 0)  # of every entry, so that the same run gives the same bytes
LIMIT_MIN = 1e-9  # [model lengths, rad] rounding of another processor, over a long run
COORDINATE_FACTOR = 10.0  # [1] of the limit: an angle or slide has the errors of two bodies, and a lever
COMPARISON_TYPES = {"digest": str, "summary": str, "passed": bool, "t_end": float}
PROOF_TYPES = {"format": str, "version": int, "passed": bool, "run": str, "digests": dict}


@dataclass(frozen=True, repr=False)
class Verification(Result):
    """What the verification of a bundle found, line by line.

    >>> from tempfile import TemporaryDirectory
    >>> from mbsd3d import Body, System, simulate, verify
    >>> stone = Body("stone", 1.0, (0.1, 0.2, 0.3), velocity=(0, 0, 3.0), omega=(0.1, 2.0, 0))
    >>> with TemporaryDirectory() as folder:
    ...     print(verify(simulate(System([stone]), 1.0, output=11).bundle(f"{folder}/flight")))
    files: as they were written
    computed with: the same versions and processor
    run made again: identical to the bit
    certificate: passes
    verified
    """

    passed: bool
    identical: bool  # the run made again has the same bits
    difference: float  # [model lengths, rad] of the run made again, the largest
    limit: float  # [model lengths, rad] of this difference
    lines: tuple[str, ...]

    def __str__(self) -> str:
        return "\n".join(self.lines)


def write_bundle(
    run: RunResult, path: str | Path, certificate: Certificate, attach: Iterable[str | Path], comparison: Any = None
) -> Path:
    """Write the bundle of a run; see `Solution.bundle`."""
    if not run.t.size or (run.record.stopped_by or "").startswith("interrupted"):
        raise InputError("solution.bundle: the run was interrupted or kept no sample; run it to its end")
    again, limit = repeat(run), limit_of(certificate)
    difference = apart(run, again)
    if not difference <= limit:
        raise InputError(
            f"solution.bundle: the run made again differs by {difference:.2g}, more than its error {limit:.2g}; a "
            "force, controller or input of this model depends on more than the state, which a bundle cannot hold"
        )
    entries = {
        SOLUTION: solution_bytes(run),
        MODEL: as_json(describe(run.system)),
        CERTIFICATE: f"{certificate}\n".encode(),
        ENVIRONMENT: as_json(environment()),
        **({} if comparison is None else {COMPARISON: as_json(comparison_of(run, comparison))}),
        **{ATTACHED + file.name: file.read_bytes() for file in attached(attach)},
    }
    proof = {
        "format": BUNDLE_KIND, "version": BUNDLE_VERSION, "passed": certificate.passed,
        "run": run_digest(again), "digests": {name: digest(content) for name, content in entries.items()},
    }  # fmt: skip
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_STORED) as archive:
        for name, content in {**entries, PROOF: as_json(proof)}.items():
            archive.writestr(zipfile.ZipInfo(name, MOMENT), content)
    return write_atomically(with_suffix(path, ".zip"), buffer.getvalue())


def comparison_of(run: RunResult, comparison: Any) -> dict[str, Any]:
    """Return a comparison with other engines as data; InputError for one of another model or start."""
    found = comparison.to_dict() if callable(getattr(comparison, "to_dict", None)) else None
    if not isinstance(found, dict) or not {*COMPARISON_TYPES} <= {*found}:
        raise InputError(
            f"solution.bundle: comparison {short_repr(comparison)}; give the result of validation.cross_check(system, "
            "t_end)"
        )
    if found["digest"] != model_digest(run.system, run.start):
        raise InputError(
            "solution.bundle: the comparison is of another model or start; compare the system of this solution, from "
            "the same state"
        )
    return found


def model_digest(system: Mechanism, start: State) -> str:
    """Return a digest of a model and its start, by which a comparison with other engines is known."""
    found = hashlib.sha256(as_json(describe(system)))
    for part in (start.q, start.v, start.z, start.t):
        found.update(np.ascontiguousarray(part, float).tobytes())
    return found.hexdigest()


def attached(files: Iterable[str | Path]) -> list[Path]:
    """Return files to attach, each under a name of its own."""
    remedy = "a list of files"
    if isinstance(files, str):
        raise InputError(f"solution.bundle: attach '{files}' is one file; give {remedy}")
    found = [as_path(file, "attach") for file in as_tuple(files, "solution.bundle: attach", remedy)]
    for file in found:
        if not file.is_file():
            raise InputError(f"solution.bundle: attach '{file}' is not a file; give files that exist")
    if len({file.name for file in found}) < len(found):
        raise InputError("solution.bundle: attach has two files of one name; rename one")
    return found


def verify(path: str | Path) -> Verification:
    """Make the run of a bundle again and compare; see `mbsd3d.verify`."""
    source = as_path(path, "bundle.zip")
    if not source.is_file():
        raise InputError(f"'{source}' does not exist; give a file written by solution.bundle(path)")
    try:
        entries = read_entries(source)
        proof = read_object(entries, PROOF, PROOF_TYPES)
        if (proof["format"], proof["version"]) != (BUNDLE_KIND, BUNDLE_VERSION):
            raise InputError(f"it is '{proof['format']}' of version {proof['version']}")
        changed = changed_entries(entries, proof["digests"])
        run = read_solution(io.BytesIO(entries[SOLUTION])) if not changed else None
        then = read_object(entries, ENVIRONMENT, dict.fromkeys(environment(), str))
        model = json.loads(entries[MODEL])
        if run is not None and describe(read_system(model)[0]) != describe(run.system):
            raise InputError(f"{MODEL} is not the model of {SOLUTION}")
        other = read_object(entries, COMPARISON, COMPARISON_TYPES) if COMPARISON in entries else None
        if run is not None and other is not None and other["digest"] != model_digest(run.system, run.start):
            raise InputError(f"{COMPARISON} is of another model or start")
    except DAMAGED_FILE_ERRORS as error:
        reason = str(error) or type(error).__name__
        raise InputError(
            f"'{source}' cannot be read as a bundle ({reason}); give a file written by solution.bundle(path)"
        ) from error
    if run is None:
        return Verification(False, False, np.inf, 0.0, (f"changed since it was written: {', '.join(changed)}",))
    return compared(run, proof, then, entries[CERTIFICATE], other)


def compared(
    run: RunResult, proof: Mapping[str, Any], then: Mapping[str, str], told: bytes, other: Mapping[str, Any] | None
) -> Verification:
    """Make a run again and hold it, and its certificate, against what its bundle says."""
    certificate, now = certificate_of(run), environment()
    limit, verdict = limit_of(certificate), certificate.passed
    others = [f"{name} {then.get(name, '-')}, here {value}" for name, value in now.items() if then.get(name) != value]
    lines = [
        "files: as they were written",
        f"computed with: {'; '.join(others) or 'the same versions and processor'}",
    ]
    try:
        again = repeat(run)
    except MbsError as error:
        lines += [f"run made again: it fails, {error}", "NOT verified"]
        return Verification(False, False, np.inf, limit, tuple(lines))
    identical, difference = run_digest(again) == proof["run"], apart(run, again)
    close, as_then = difference <= limit, verdict == proof["passed"]
    as_then &= bool(others) or set(f"{certificate}".splitlines()) <= set(told.decode(errors="replace").splitlines())
    far = f"differs by {difference:.2e}, limit {limit:.2e}"
    words = {True: "passes", False: "does not pass"}
    lines += [
        f"run made again: {'identical to the bit' if identical and close else far}",
        f"certificate: {words[verdict]}{'' if as_then else ', unlike then'}",
    ]
    if other is not None:
        lines.append(f"other engines, as they were then until {other['t_end']:g} s: {other['summary']}")
    if not others and not identical:
        lines.append("with the same versions and processor the bits must be the same: the installation is another one")
    passed = close and as_then and (identical or bool(others))
    doubts = [] if verdict else ["its certificate does not pass"]
    doubts += [] if other is None or other["passed"] else ["no other engine confirms it"]
    end = f"verified{', but ' if doubts else ''}{' and '.join(doubts)}" if passed else "NOT verified"
    return Verification(passed, identical, difference, limit, (*lines, end))


def limit_of(certificate: Certificate) -> float:
    """Return how far a run made again may be from one with this certificate [model lengths, rad]."""
    return max(LIMIT_MIN, certificate.error or 0.0)


def apart(run: RunResult, again: RunResult) -> float:
    """Return how far a run made again is from a run [model lengths, rad]: poses, and its share of angles and slides."""
    times, i, j = np.intersect1d(run.t, again.t, return_indices=True)
    if np.unique(run.t).size > times.size:
        return np.inf
    own = run.compiled.own_coordinates
    units = np.full(own, np.inf)  # of the way along a curve: none, it may turn sharply
    kinds_of = run.compiled.model.coordinate["kind"][:own]
    units[kinds_of == ANGLE], units[kinds_of == SLIDE] = 1.0, run.compiled.model.length
    turned = np.abs(run.arrays["coordinate"][i, :own] - again.arrays["coordinate"][j, :own])
    shares = turned / (COORDINATE_FACTOR * units)
    return float(max(distances(run, again).max(initial=0.0), shares.max(initial=0.0)))


def read_entries(source: Path) -> dict[str, bytes]:
    """Return the entries of a bundle; refuse names and compression that `write_bundle` never makes."""
    with zipfile.ZipFile(source) as archive:
        infos = archive.infolist()
        known = {SOLUTION, MODEL, CERTIFICATE, ENVIRONMENT, PROOF}
        names = [info.filename for info in infos]
        odd = [name for name in names if name not in {*known, COMPARISON} and not name.startswith(ATTACHED)]
        if odd or len(set(names)) < len(names) or not known <= set(names):
            raise InputError(f"it holds '{odd[0]}', which no bundle has" if odd else "entries are missing or double")
        if any(info.compress_type != zipfile.ZIP_STORED for info in infos):
            raise InputError("it is compressed, which no bundle is")
        return {name: archive.read(name) for name in names}


def read_object(entries: Mapping[str, bytes], name: str, types: Mapping[str, type]) -> dict[str, Any]:
    """Return the JSON object of an entry that has these values at least."""
    found = json.loads(entries[name])
    if not isinstance(found, dict):
        raise InputError(f"{name} is not an object")
    odd = [key for key, kind in types.items() if type(found.get(key)) is not kind]
    if odd:
        raise InputError(f"{name}: {odd[0]} is {short_repr(found.get(odd[0]))}")
    return found


def changed_entries(entries: Mapping[str, bytes], digests: Mapping[str, str]) -> list[str]:
    """Return the entries that are not as the proof says."""
    there = {name: digest(content) for name, content in entries.items() if name != PROOF}
    return sorted(name for name in {*there, *digests} if there.get(name) != digests.get(name))


def run_digest(run: RunResult) -> str:
    """Return the digest of all numbers of a run."""
    found = hashlib.sha256()
    for name in sorted({*STORED_ARRAYS} - {*STATE_SLICES}):
        found.update(name.encode() + np.ascontiguousarray(run.arrays[name], float).tobytes())
    return found.hexdigest()


def digest(content: bytes) -> str:
    """Return the SHA-256 digest of an entry."""
    return hashlib.sha256(content).hexdigest()


def as_json(data: Any) -> bytes:
    """Return data as JSON text to read."""
    return (json.dumps(data, indent=1, allow_nan=False) + "\n").encode()


def environment() -> dict[str, str]:
    """Return what bits depend on: versions, system and processor."""
    versions = {name: __import__(name).__version__ for name in PACKAGES}
    return {
        "mbsd3d": package_version(), "python": platform.python_version(), **versions,
        "system": platform.platform(), "processor": str(llvm.get_host_cpu_name()),
    }  # fmt: skip
