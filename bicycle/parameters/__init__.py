"""Parameters of bicycles: their definition, published sets, parameter files.

Published are the benchmark bicycle of 2007, measured bicycles with and without rider, and optimised ones.
"""

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from mbsd3d.errors import InputError
from mbsd3d.extend import similar

from .definition import (
    MEANING,
    NOT_NEGATIVE,
    POSITIVE,
    SYMBOL,
    SYMBOLS,
    TYRES,
    UNIT,
    Parameters,
    check_set,
    checked_deviations,
)  # fmt: skip
from .files import is_file, read_values

__all__ = [
    "MEANING", "NOT_NEGATIVE", "POSITIVE", "SYMBOL", "SYMBOLS", "TYRES", "UNIT", "Meijaard2007", "Parameters",
    "check_set", "checked_deviations", "deviations", "entry_of", "fittings", "is_file", "library", "machines", "named",
    "names", "read_values",
]  # fmt: skip

DATA = Path(__file__).parent / "published.json"
SKATE_RADIUS = 0.1  # [m] of the massless wheels that replace skates, whose radius is published as zero


@cache
def library() -> dict[str, Any]:
    """Return the data file: sets, and published results to compare with."""
    return json.loads(DATA.read_text(encoding="utf-8"))


@cache
def machines() -> dict[str, Any]:
    """Return published machines on tyres by name: values, tyres (rear, front), damping of the steer, printed
    eigenvalues.
    """
    return json.loads(DATA.with_name("motorcycles.json").read_text(encoding="utf-8"))


def fittings(parameters: Parameters) -> dict[str, Any]:
    """Return the further arguments of `bicycle.whipple` for a published machine; empty for bicycles."""
    found = machines().get(parameters.name, {})
    return {key: found[key] for key in ("tyres", "steer_damping") if key in found}


def Meijaard2007() -> Parameters:
    """Return the benchmark bicycle with its rider (Meijaard et al. 2007, Table 1); lam = pi/10.

    Examples
    --------
    >>> Meijaard2007().mB
    85.0
    """
    return Parameters(**{**library()["parameters"]["values"], "lam": np.pi / 10}, name="Meijaard2007")


def names() -> list[str]:
    """Return the names of the published sets for `named`, in alphabetical order."""
    return sorted((entry["name"] for entry in library()["bicycles"]["sets"]), key=str.lower)


def entry_of(name: str) -> dict[str, Any]:
    """Return the entry of a set in the data file; the error for an unknown name suggests similar ones."""
    entries = {entry["name"]: entry for entry in library()["bicycles"]["sets"]}
    if name in entries:
        return entries[name]
    near = similar(name, ("Meijaard2007", *machines(), *entries))
    known = "mbsd3d bicycle compare --list shows all, and parameter files end in .txt, .yml or .yaml"
    hint = f"did you mean {', '.join(near)}?" if near else known
    raise InputError(f"there is no bicycle '{name}'; {hint}")


def named(name: str | Path, *, unphysical: bool = False) -> Parameters:
    """Return a published set, measured bicycles with and without rider and optimised ones, or that of a parameter file.

    Values are as published, also where copies contradict each other: APPDATA_Benchmark_ROUNDED is the benchmark with
    rounded values, and HC_Browser and HC_Pista have I_Rxx and I_Fxx exchanged against Browser and Pista.

    Parameters
    ----------
    name : str or Path
        One of `names`, "Meijaard2007", a machine on tyres: "Sharp1971", or a parameter file (.txt, .yml, .yaml),
        read by `Parameters.from_file`.
    unphysical : bool
        Accept moments of inertia that no rigid body has; a few sets need it.

    Returns
    -------
    Parameters
        With published standard deviations as `deviations`. Skates (radius 0) get massless wheels of radius
        `SKATE_RADIUS`, which do not change their motion.

    Raises
    ------
    ValueError
        For a name that is unknown, and as `Parameters` and `Parameters.from_file` do.

    Examples
    --------
    >>> from bicycle import named
    >>> named("Browserins").w
    1.121
    """
    if is_file(str(name)):
        return Parameters.from_file(name, unphysical=unphysical)
    name = str(name)
    if name == "Meijaard2007":
        return Meijaard2007()
    if name in machines():
        return Parameters(**machines()[name]["values"], name=name)
    values = dict(entry_of(name)["values"])
    for wheel in "RF":
        skate = not any(values[key] for key in (f"r{wheel}", f"m{wheel}", f"I{wheel}xx", f"I{wheel}yy"))
        values[f"r{wheel}"] = SKATE_RADIUS if skate else values[f"r{wheel}"]
    return Parameters(**values, name=name, unphysical=unphysical, deviations=deviations(name))


def deviations(name: str) -> dict[str, float]:
    """Return published standard deviations of a measured set by symbol [SI units], without those that are zero."""
    return {key: std for key, std in (entry_of(name).get("std") or {}).items() if std}
