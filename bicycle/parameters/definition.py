"""Parameters of a bicycle with ideal wheels, by the symbols of Meijaard, Papadopoulos, Ruina and Schwab (2007)."""

# ruff: noqa: N815 -- the symbols are those of the paper

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from mbsd3d.errors import InputError
from mbsd3d.extend import ChecksArguments, check_inertia, number

from .files import read_values


def quantity(symbol: str, unit: str, meaning: str, **more: Any) -> Any:
    """Declare a field with symbol, unit and meaning."""
    return field(metadata={"symbol": symbol, "unit": unit, "meaning": meaning}, **more)


@dataclass(frozen=True, kw_only=True)
class Parameters(metaclass=ChecksArguments):
    """Bicycle of four rigid bodies: rear wheel R, frame with rider B, fork with handlebar H, front wheel F.

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
        Crown radii of the tyres [m], 0 <= t <= r. Zero is the knife edge of the paper.
    name : str
        Shown in messages and figures.
    unphysical : bool
        Accept moments of inertia that no rigid body has: some published sets break the triangle rule.
    deviations : mapping of str to float
        Measured standard deviations by symbol, in the unit of the parameter; those left out are zero.

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
    deviations: Mapping[str, float] = field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        what = f"bicycle '{self.name}'"
        for key, meaning in MEANING.items():
            minimum = 0.0 if key in NOT_NEGATIVE else None
            value = number(getattr(self, key), f"{what}: {meaning} {key}", positive=key in POSITIVE, minimum=minimum)
            object.__setattr__(self, key, value)
        object.__setattr__(self, "deviations", checked_deviations(self.deviations, what))
        if not abs(self.lam) < np.pi / 2:
            raise InputError(f"{what}: steer axis tilt lam = {self.lam} rad; give one between -pi/2 and pi/2")
        for wheel in "RF":
            radius, crown = getattr(self, f"r{wheel}"), getattr(self, f"t{wheel}")
            if crown > radius:
                raise InputError(f"{what}: crown radius t{wheel} = {crown} exceeds r{wheel} = {radius}; give t <= r")
        if self.mass == 0.0:
            raise InputError(f"{what}: all masses are zero; give one of mR, mB, mH, mF")
        for part, body in BODIES.items():
            check_body(self, part, f"{what}: {body} ({part})")

    @property
    def mass(self) -> float:
        """Return the total mass [kg]."""
        return self.mR + self.mB + self.mH + self.mF

    def inertia(self, part: str) -> np.ndarray:
        """Return the inertia of part "R", "B", "H" or "F" about its centre of mass, axes x forward, y right, z down [kg
        m^2], shape (3, 3).
        """
        I = {axis: getattr(self, f"I{part}{axis}") for axis in (("xx", "yy") if part in "RF" else AXES)}
        xz = I.get("xz", 0.0)
        return np.array([[I["xx"], 0.0, xz], [0.0, I["yy"], 0.0], [xz, 0.0, I.get("zz", I["xx"])]])

    @property
    def front_load(self) -> float:
        """Return the share of the weight on the front wheel of the upright bicycle [-]: below 0 or above 1 it tips."""
        return (self.mB * self.xB + self.mH * self.xH + self.mF * self.w) / (self.w * self.mass)

    def values(self) -> dict[str, float]:
        """Return the numbers by symbol, in the order of the fields."""
        return {key: getattr(self, key) for key in MEANING}

    @classmethod
    def from_file(cls, path: str | Path, *, unphysical: bool = False) -> "Parameters":
        """Read a parameter file of BicycleParameters (.txt, .yml, .yaml), with its standard deviations.

        Parameters
        ----------
        path : str or Path
            ``.txt``: lines ``symbol = value``, ``symbol = value +/- deviation``, or several of these separated by
            commas, which are averaged; ``#`` starts a comment. ``.yml``, ``.yaml``: numbers below ``values:``.
        unphysical : bool
            Accept moments of inertia that no rigid body has.

        Returns
        -------
        Parameters
            Called as the file, without its ending.

        Raises
        ------
        ValueError
            Naming the file and the line or symbol: unknown, missing, given twice, or not a number.
        """
        values, deviations = read_values(path)
        unknown = [key for key in values if key not in MEANING]
        missing = [key for key in SYMBOLS if key not in values]
        if unknown:
            raise InputError(f"'{path}': {', '.join(map(str, unknown))} unknown; the symbols are {' '.join(MEANING)}")
        if 2 * len(missing) > len(SYMBOLS):
            found, symbols = len(SYMBOLS) - len(missing), " ".join(SYMBOLS)
            raise InputError(f"'{path}': holds {found} of the {len(SYMBOLS)} numbers of a bicycle; give {symbols}")
        if missing:
            raise InputError(f"'{path}': {', '.join(missing)} missing; a bicycle needs {len(SYMBOLS)} numbers")
        return cls(**values, name=Path(path).stem, unphysical=unphysical, deviations=deviations)


AXES = ("xx", "yy", "zz", "xz")
BODIES = {"R": "rear wheel", "B": "frame and rider", "H": "fork and handlebar", "F": "front wheel"}
SYMBOL, UNIT, MEANING = (
    {x.name: x.metadata[key] for x in fields(Parameters) if x.metadata} for key in ("symbol", "unit", "meaning")
)
TYRES = ("tR", "tF")
SYMBOLS = tuple(key for key in MEANING if key not in TYRES)  # The 25 parameters of the paper and g
POSITIVE = ("w", "rR", "rF")
NOT_NEGATIVE = ("g", "mR", "mB", "mH", "mF", "tR", "tF")


def checked_deviations(given: Mapping[str, float], what: str) -> dict[str, float]:
    """Return standard deviations by symbol, none of them zero; ValueError for unknown symbols and negative values."""
    if not isinstance(given, Mapping):
        raise InputError(f"{what}: deviations = {given!r:.80}; give them by symbol, e.g. {{'c': 0.01}}")
    found = {}
    for key, std in given.items():
        if key not in MEANING:
            raise InputError(f"{what}: deviation of '{key}': no such parameter; there are {', '.join(MEANING)}")
        found[key] = number(std, f"{what}: deviation of {key}", minimum=0.0)
    return {key: std for key, std in found.items() if std}


def check_body(parameters: Parameters, part: str, what: str) -> None:
    """Raise ValueError for an impossible inertia; ``unphysical`` allows one that only breaks the triangle rule."""
    inertia, mass = parameters.inertia(part), getattr(parameters, f"m{part}")
    try:
        check_inertia(inertia, mass, what)
    except ValueError as error:
        if mass == 0.0 or np.linalg.eigvalsh(inertia)[0] < 0.0:
            raise
        if not parameters.unphysical:
            raise InputError(f"{error}; to compute with it all the same give unphysical=True (--unphysical)") from None


def check_set(parameters: object, what: str) -> None:
    """Raise ValueError for anything but parameters, such as their name."""
    if not isinstance(parameters, Parameters | SimpleNamespace):  # the latter holds stacks of values
        raise InputError(f"{what}: parameters = {parameters!r:.80}; give a set, e.g. bicycle.named('Browserins')")
