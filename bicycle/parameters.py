"""Parameters of a bicycle with ideal wheels, by the symbols of Meijaard, Papadopoulos, Ruina and Schwab (2007)."""

# ruff: noqa: N815 -- the symbols are those of the paper

import json
from dataclasses import dataclass, field, fields
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from mbsd3d.base.checks import number
from mbsd3d.base.mass_properties import check_inertia

DATA = Path(__file__).parent / "data" / "bicycle.json"
SKATE_RADIUS = 0.1
"""[m] of the massless wheels that stand for skates, whose radius is published as zero."""


def quantity(symbol: str, unit: str, meaning: str, **more: Any) -> Any:
    """A field that knows what it is."""
    return field(metadata={"symbol": symbol, "unit": unit, "meaning": meaning}, **more)


@dataclass(frozen=True, kw_only=True)
class Parameters:
    """A bicycle of four rigid bodies: rear wheel R, frame with rider B, fork with handlebar H, front wheel F.

    Axes of the paper: origin at the rear contact, x forward, y right, z down, so that centres of mass have z < 0. SI
    units. Frame and fork are symmetric about the plane y = 0, wheels about their axles. `dataclasses.replace` makes
    variants.

    Parameters
    ----------
    w, c, lam : float
        Wheelbase [m], trail [m], tilt of the steer axis from the vertical [rad].
    ... : float
        As ``for field in dataclasses.fields(Parameters)`` says: ``field.metadata`` holds symbol, unit and meaning.
    tR, tF : float
        Crown radii of the tyres [m], 0 <= t <= r: a round rim rolls without slip. The paper's wheels have knife edges.
    name : str
        Of this set, in messages and figures.
    unphysical : bool
        Accept moments of inertia that no body has: some published sets break the triangle rule.

    Raises
    ------
    ValueError
        Naming bicycle, part, value and remedy.

    Examples
    --------
    >>> from dataclasses import fields, replace
    >>> from bicycle import Meijaard2007
    >>> light = replace(Meijaard2007(), mB=60.0, name="light rider")
    >>> light.mB, light.w
    (60.0, 1.02)
    >>> {f.name: f.metadata.get("unit") for f in fields(light)}["IBxx"]
    'kg m^2'
    """

    w: float = quantity("w", "m", "wheelbase")
    c: float = quantity("c", "m", "trail")
    lam: float = quantity("λ", "rad", "steer axis tilt")
    g: float = quantity("g", "m/s^2", "gravity")
    rR: float = quantity("r_R", "m", "radius of the rear wheel")
    mR: float = quantity("m_R", "kg", "mass of the rear wheel")
    IRxx: float = quantity("I_Rxx", "kg m^2", "moment of inertia of the rear wheel about a diameter")
    IRyy: float = quantity("I_Ryy", "kg m^2", "moment of inertia of the rear wheel about its axle")
    xB: float = quantity("x_B", "m", "centre of mass of frame and rider, forward")
    zB: float = quantity("z_B", "m", "centre of mass of frame and rider, down")
    mB: float = quantity("m_B", "kg", "mass of frame and rider")
    IBxx: float = quantity("I_Bxx", "kg m^2", "inertia of frame and rider, xx")
    IByy: float = quantity("I_Byy", "kg m^2", "inertia of frame and rider, yy")
    IBzz: float = quantity("I_Bzz", "kg m^2", "inertia of frame and rider, zz")
    IBxz: float = quantity("I_Bxz", "kg m^2", "inertia of frame and rider, xz")
    xH: float = quantity("x_H", "m", "centre of mass of fork and handlebar, forward")
    zH: float = quantity("z_H", "m", "centre of mass of fork and handlebar, down")
    mH: float = quantity("m_H", "kg", "mass of fork and handlebar")
    IHxx: float = quantity("I_Hxx", "kg m^2", "inertia of fork and handlebar, xx")
    IHyy: float = quantity("I_Hyy", "kg m^2", "inertia of fork and handlebar, yy")
    IHzz: float = quantity("I_Hzz", "kg m^2", "inertia of fork and handlebar, zz")
    IHxz: float = quantity("I_Hxz", "kg m^2", "inertia of fork and handlebar, xz")
    rF: float = quantity("r_F", "m", "radius of the front wheel")
    mF: float = quantity("m_F", "kg", "mass of the front wheel")
    IFxx: float = quantity("I_Fxx", "kg m^2", "moment of inertia of the front wheel about a diameter")
    IFyy: float = quantity("I_Fyy", "kg m^2", "moment of inertia of the front wheel about its axle")
    tR: float = quantity("t_R", "m", "crown radius of the rear tyre", default=0.0)
    tF: float = quantity("t_F", "m", "crown radius of the front tyre", default=0.0)
    name: str = "bicycle"
    unphysical: bool = False

    def __post_init__(self) -> None:
        what = f"bicycle '{self.name}'"
        for key in (*SYMBOLS, *TYRES):
            positive, least = key in POSITIVE, 0.0 if key in NOT_NEGATIVE else None
            value = number(getattr(self, key), f"{what}: {MEANING[key]} {key}", positive=positive, minimum=least)
            object.__setattr__(self, key, value)
        if not abs(self.lam) < np.pi / 2:
            raise ValueError(f"{what}: steer axis tilt lam = {self.lam} rad; give one between -pi/2 and pi/2")
        for wheel in "RF":
            radius, crown = getattr(self, f"r{wheel}"), getattr(self, f"t{wheel}")
            if crown > radius:
                raise ValueError(f"{what}: crown radius t{wheel} = {crown} exceeds r{wheel} = {radius}; give t <= r")
        if self.mass == 0.0:
            raise ValueError(f"{what}: all masses are zero; give one of mR, mB, mH, mF")
        for part, body in BODIES.items():
            check_body(self, part, f"{what}: {body} ({part})")

    @property
    def mass(self) -> float:
        """Of everything [kg]."""
        return self.mR + self.mB + self.mH + self.mF

    def inertia(self, part: str) -> np.ndarray:
        """(3, 3) inertia of part "R", "B", "H" or "F" about its centre of mass, axes x forward, y right, z down."""
        I = {axis: getattr(self, f"I{part}{axis}") for axis in (("xx", "yy") if part in "RF" else AXES)}
        xz = I.get("xz", 0.0)
        return np.array([[I["xx"], 0.0, xz], [0.0, I["yy"], 0.0], [xz, 0.0, I.get("zz", I["xx"])]])

    @property
    def front_load(self) -> float:
        """Share of the weight that the front wheel carries when it stands upright: below 0 or above 1 it tips."""
        return (self.mB * self.xB + self.mH * self.xH + self.mF * self.w) / (self.w * self.mass)

    def values(self) -> dict[str, float]:
        """The numbers by symbol, in the order of the fields."""
        return {key: getattr(self, key) for key in (*SYMBOLS, *TYRES)}

    @classmethod
    def from_file(cls, path: str | Path, *, unphysical: bool = False) -> "Parameters":
        """Read a parameter file of BicycleParameters; see `bicycle.parameter_files.read_values`."""
        from .parameter_files import read_values

        values, _ = read_values(path)
        return cls(**values, name=Path(path).stem, unphysical=unphysical)


AXES = ("xx", "yy", "zz", "xz")
BODIES = {"R": "rear wheel", "B": "frame and rider", "H": "fork and handlebar", "F": "front wheel"}
SYMBOL, UNIT, MEANING = (
    {x.name: x.metadata[key] for x in fields(Parameters) if x.metadata} for key in ("symbol", "unit", "meaning")
)
TYRES = ("tR", "tF")
SYMBOLS = tuple(key for key in MEANING if key not in TYRES)
"""The 25 parameters of the paper and g."""
POSITIVE = ("w", "rR", "rF")
NOT_NEGATIVE = ("g", "mR", "mB", "mH", "mF", "tR", "tF")


def check_body(parameters: Parameters, part: str, what: str) -> None:
    """Refuse an inertia that no body has, unless it is allowed by flag."""
    try:
        check_inertia(parameters.inertia(part), getattr(parameters, f"m{part}"), what)
    except ValueError as error:
        moments = np.linalg.eigvalsh(parameters.inertia(part))
        triangle = moments[0] >= 0.0 and getattr(parameters, f"m{part}") > 0.0  # all that can be wrong otherwise
        if not triangle:
            raise
        if not parameters.unphysical:
            raise ValueError(f"{error}; to compute with it all the same give unphysical=True (--unphysical)") from None


@cache
def library() -> dict[str, Any]:
    """The data file of this package."""
    return json.loads(DATA.read_text(encoding="utf-8"))


def Meijaard2007() -> Parameters:
    """The benchmark bicycle with its rider (Meijaard et al. 2007, Table 1); lam = pi/10.

    Examples
    --------
    >>> Meijaard2007().mB
    85.0
    """
    return Parameters(**{**library()["parameters"]["values"], "lam": np.pi / 10}, name="Meijaard2007")


def names() -> list[str]:
    """Names of the published sets for `named`, in alphabetical order."""
    return sorted((entry["name"] for entry in library()["bicycles"]["sets"]), key=str.lower)


def entry_of(name: str) -> dict[str, Any]:
    """The entry of the library, with a hint at names that are spelled alike."""
    from difflib import get_close_matches

    entries = {entry["name"]: entry for entry in library()["bicycles"]["sets"]}
    if name in entries:
        return entries[name]
    lower = {known.lower(): known for known in ("Meijaard2007", *entries)}
    near = [lower[text] for text in get_close_matches(str(name).lower(), lower, 3, 0.6)]
    known = "mbsd3d bicycle compare --list shows all, and parameter files end in .txt, .yml or .yaml"
    hint = f"did you mean {', '.join(near)}?" if near else known
    raise ValueError(f"there is no bicycle '{name}'; {hint}")


def named(name: str, *, unphysical: bool = False) -> Parameters:
    """A published set: measured bicycles with and without rider, and optimised ones.

    Sets stand as published, also where copies contradict each other: APPDATA_Benchmark_ROUNDED is the benchmark with
    rounded values, and I_Rxx and I_Fxx of Browser and of HC_Browser, the same bicycle with a rider, are exchanged, so
    are those of Pista and HC_Pista.

    Parameters
    ----------
    name : str
        One of `names`, or "Meijaard2007".
    unphysical : bool
        Accept moments of inertia that no body has; a few sets need it.

    Returns
    -------
    Parameters
        As published; skates (radius 0) get massless wheels of radius `SKATE_RADIUS`, which their equations do not feel.

    Raises
    ------
    ValueError
        If there is no such set, or its inertia breaks the triangle rule.

    Examples
    --------
    >>> named("Browserins").w
    1.121
    """
    if name == "Meijaard2007":
        return Meijaard2007()
    values = dict(entry_of(name)["values"])
    for wheel in "RF":
        skate = not any(values[key] for key in (f"r{wheel}", f"m{wheel}", f"I{wheel}xx", f"I{wheel}yy"))
        values[f"r{wheel}"] = SKATE_RADIUS if skate else values[f"r{wheel}"]
    return Parameters(**values, name=name, unphysical=unphysical)


def deviations(name: str) -> dict[str, float]:
    """Standard deviations of a measured set by symbol, those that are published and not zero; same units."""
    return {key: std for key, std in (entry_of(name).get("std") or {}).items() if std}


def find(text: str, *, unphysical: bool = False) -> Parameters:
    """What a user of the command line calls a bicycle: the name of a set, or a parameter file."""
    from .parameter_files import is_file

    return Parameters.from_file(text, unphysical=unphysical) if is_file(text) else named(text, unphysical=unphysical)
