"""Models of other programs: MJCF, read by MuJoCo in a separate process, URDF and SDF.

What acts on every motion is built, or the file is refused; it is left out only if the caller names its kind. What acts
at times or on command is inactive, and said.
"""

import warnings
from collections.abc import Callable, Sequence
from math import ceil
from pathlib import Path
from typing import Any

from ...base.checks import as_tuple, check_choice, number, short_repr
from ...base.errors import InputError
from ...base.fields import true_or_false
from ...base.paths import as_path
from .builder import Builder, Choices
from .facts import Facts
from .folders import Folders, as_folders
from .guarded import answer_of
from .imported import KINDS, Imported
from .sdf import SdfModel
from .urdf import Robot
from .xml_scan import Scan

TIMEOUT_SECONDS_MAX = 86400.0  # [s]
CALLER_FRAMES = 5  # [frames] from here to the user's call of a reader


def read_mujoco(path: str | Path, timeout: float, package_paths: Any, **choices: Any) -> Imported:
    """Scan an MJCF file, let the worker compile it, build."""
    path, timeout = as_path(path, "model.xml"), as_timeout(timeout)
    chosen, folders = chosen_of(path, **choices), Folders(path, as_folders(package_paths))
    scan = Scan(path, folders)
    scan.read(path)
    scan.check_named()
    if path.suffix not in (".xml", ".mjcf"):
        raise InputError(f"'{path}': MuJoCo reads files by their name; give it one that ends in .xml or .mjcf")
    if scan.kind != "mujoco":
        other = "name it .urdf, read_urdf reads it" if scan.kind == "robot" else "give a model of MuJoCo"
        raise InputError(f"'{path}': its root is <{scan.kind}>, not <mujoco>; {other}")
    return built(path, lambda: compiled_facts(path, timeout, folders, scan.whole), chosen, scan.place_of)


def read_robot(path: str | Path, timeout: float, package_paths: Any, floating: bool | None, **choices: Any) -> Imported:
    """Read a URDF file, build."""
    path, timeout = as_path(path, "model.urdf"), as_timeout(timeout)
    if floating is not None:
        true_or_false(floating, "floating", None)
    chosen, folders = chosen_of(path, **choices), Folders(path, as_folders(package_paths))
    robot = Robot(path, folders, floating, timeout, chosen.inputs)
    return built(path, robot.facts, chosen, robot.place_of)


def read_simulation(path: str | Path, package_paths: Any, floating: bool | None, **choices: Any) -> Imported:
    """Read an SDF file, build."""
    path = as_path(path, "model.sdf")
    if floating is not None:
        true_or_false(floating, "floating", None)
    chosen = chosen_of(path, inputs=False, **choices)
    model = SdfModel(path, Folders(path, as_folders(package_paths)), floating, chosen.leave_out)
    return built(path, model.facts, chosen, model.place_of)


def as_timeout(value: Any) -> float:
    """Accept a time [s] that is no more than a day."""
    timeout = number(value, "timeout", positive=True)
    if timeout > TIMEOUT_SECONDS_MAX:
        raise InputError(f"timeout: {timeout:g} s is more than a day; give at most {TIMEOUT_SECONDS_MAX:g}")
    return timeout


def chosen_of(
    path: Path,
    *,
    leave_out: Sequence[str],
    drop: Sequence[str],
    strict: bool,
    geometry: str,
    inertia: str,
    inputs: bool,
    limits: str,
) -> Choices:
    """Check the choices of a caller, and return them."""
    kinds: list[str] = []
    for what, given in (("leave_out", leave_out), ("drop", drop)):
        names = (given,) if isinstance(given, str) else as_tuple(given, what, "kinds of parts")
        if unknown := [x for x in names if not isinstance(x, str) or x not in KINDS]:
            have = ", ".join(sorted(KINDS))
            raise InputError(f"'{path}': {what}: {short_repr(unknown[0])} is not a kind of part; give some of {have}")
        kinds += names
    check_choice(geometry, ("draw", "ignore"), "geometry")
    check_choice(inertia, ("as given", "refuse"), "inertia")
    check_choice(limits, ("watched", "stop"), "limits")
    strict, inputs = true_or_false(strict, "strict", None), true_or_false(inputs, "inputs", None)
    return Choices(tuple(kinds), strict, inertia, geometry, inputs, limits)


def built(path: Path, facts: Callable[[], Facts], choices: Choices, place_of: Callable[[str, str], str]) -> Imported:
    """Build a system; errors name the file, and one warning says what is inactive or was chosen for the caller."""
    try:
        read = facts()
        found = Builder(read, choices, place_of).build()
    except ValueError as error:
        raise InputError(f"'{path}': {error}") from error
    said = [f"inactive: {found.inactive}"] if found.inactive else []
    said += read.get("chosen", ())
    if said:
        warnings.warn(f"'{path}': {'; '.join(said)}", stacklevel=CALLER_FRAMES)
    return found


def compiled_facts(path: Path, timeout: float, folders: Folders, whole: bool) -> Facts:
    """Return what the worker tells, or raise an InputError that says why it tells nothing."""
    arguments = [str(path.absolute()), str(ceil(timeout)), "whole" if whole else "parts", *map(str, folders.given)]
    answer = answer_of("mbsd3d.files.importing.worker", arguments, timeout, "MuJoCo")
    if "error" in answer:
        raise InputError(f"MuJoCo cannot read it: {answer['error']}")
    return answer["facts"]
