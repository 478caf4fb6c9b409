"""The parameters of a bicycle with ideal wheels, by the symbols of Meijaard, Papadopoulos, Ruina and Schwab (2007).

They are read from parameter files of BicycleParameters, text (.txt) or YAML (.yml, .yaml).
"""

# ruff: noqa: N815 -- the symbols are those of the paper

import re
from dataclasses import dataclass, field, fields
from math import hypot, inf
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from mbsd3d.extend import check_inertia, number

Numbers = dict[str, float]
FORMATS = (".txt", ".yml", ".yaml")
LARGEST = {".txt": 1_000_000, ".yml": 50_000, ".yaml": 50_000}  # bytes: a parameter file has some hundred
NESTED = re.compile(r"(?:[-?:!]\s+){8}|(?:[\[{][^\]}]*){8}|\d(?::\d+){3}")  # lists of lists, and numbers to base 60
POWER_OF_TEN = re.compile(r"[+-]?\d+e[+-]?\d+", re.IGNORECASE)
DECIMAL_COMMA = re.compile(r"(?<![.\d])\d+,\d")  # would be read as two measurements
UNCERTAIN = re.compile(r"^\(?([^()]+?)\s*\+/-\s*([^()]+?)\)?(e[+-]?\d+)?$", re.IGNORECASE)


def is_file(path: str | Path) -> bool:
    """Whether a name belongs to a parameter file, by its ending."""
    return Path(path).suffix.lower() in FORMATS


def read_values(path: str | Path) -> tuple[Numbers, Numbers]:
    """The numbers of a parameter file.

    Parameters
    ----------
    path : str or Path
        ``.txt``: lines ``symbol = value``, ``symbol = value +/- deviation`` or several of these separated by commas,
        which are averaged; ``#`` starts a comment. ``.yml``, ``.yaml``: numbers below ``values:``, of the
        parameterization ``benchmark``. An entry v, the speed of a study, is skipped.

    Returns
    -------
    values, deviations : dict
        By symbol; standard deviations only where the file gives them.

    Raises
    ------
    ValueError
        Naming the file and the line or entry: a symbol given twice, or not a number.
    """
    path = Path(path)
    if not is_file(path):
        raise ValueError(f"'{path}': parameter files end in .txt, .yml or .yaml")
    if path.stat().st_size > LARGEST[path.suffix.lower()]:
        most = LARGEST[path.suffix.lower()]
        raise ValueError(f"'{path}': larger than {most} bytes; give a parameter file of BicycleParameters")
    try:
        text = path.read_text(encoding="utf-8-sig")  # editors of Windows begin with a mark
    except UnicodeDecodeError:
        raise ValueError(f"'{path}': not a text file; give a parameter file of BicycleParameters") from None
    entries = text_entries if path.suffix.lower() == ".txt" else yaml_entries
    values, deviations = entries(path, text)
    values.pop("v", None)
    deviations.pop("v", None)
    return values, deviations


def text_entries(path: Path, text: str) -> tuple[Numbers, Numbers]:
    """Lines ``symbol = value +/- deviation, ...``."""
    values, deviations = {}, {}
    for i, line in enumerate(text.splitlines(), 1):
        content = line.split("#")[0].strip()
        if not content:
            continue
        key, equals, right = (part.strip() for part in content.partition("="))
        where = f"'{path}', line {i}"
        if not equals or not key:
            raise ValueError(f"{where}: '{content}' is not of the form 'symbol = value'")
        if key in values:
            raise ValueError(f"{where}: {key} is given twice; give it once")
        if DECIMAL_COMMA.search(right):
            raise ValueError(f"{where}: {key} = '{right}': write a decimal point, or a blank between two measurements")
        pairs = [value_and_deviation(part.strip(), f"{where}: {key}") for part in right.split(",")]
        values[key] = sum(value for value, _ in pairs) / len(pairs)
        if any(spread is not None for _, spread in pairs):  # deviation of the mean of independent measurements
            deviations[key] = hypot(*(spread or 0.0 for _, spread in pairs)) / len(pairs)
    return values, deviations


def value_and_deviation(text: str, what: str) -> tuple[float, float | None]:
    """(value, deviation or None) of "0.1", "0.1 +/- 0.02" or "(1.2 +/- 0.3)e-05"."""
    match = UNCERTAIN.match(text)
    parts = [part + (match[3] or "") for part in match.groups()[:2]] if match else [text]
    try:
        value, *spread = map(float, parts)
    except ValueError:
        raise ValueError(f"{what} = '{text}' is not a number; write e.g. 0.35 or 0.35 +/- 0.01") from None
    if spread and not 0.0 <= spread[0] < inf:
        raise ValueError(f"{what} = '{text}': the deviation is not a finite number >= 0; give one, or none")
    return value, spread[0] if spread else None


def yaml_entries(path: Path, text: str) -> tuple[Numbers, Numbers]:
    """The mapping ``values`` of a YAML file; references are refused, since they can expand without end."""
    if NESTED.search(text):
        raise ValueError(
            f"'{path}': lists in lists, or numbers to base 60; a parameter file has names and numbers only"
        )
    try:
        if any(isinstance(token, yaml.AliasToken) for token in yaml.scan(text)):
            raise ValueError(f"'{path}': references (*name) are not supported; write the numbers out")
        twice = repeated(yaml.compose(text))
        content: Any = yaml.safe_load(text)
    except (yaml.YAMLError, RecursionError) as error:
        raise ValueError(f"'{path}': not valid YAML: {error}") from None
    except (TypeError, OverflowError) as error:  # of keys that are lists, and numbers of many digits
        raise ValueError(f"'{path}': {error}; give names and numbers") from None
    if twice:
        raise ValueError(f"'{path}': {', '.join(twice)} is given twice; give it once")
    kind = content.get("parameterization", "benchmark") if isinstance(content, dict) else None
    values = content.get("values") if isinstance(content, dict) else None
    if kind != "benchmark" or not isinstance(values, dict):
        raise ValueError(f"'{path}': give 'parameterization: benchmark' and the numbers below 'values:'")
    return {key: plain_number(value, f"'{path}': {key}") for key, value in values.items()}, {}


def repeated(node: yaml.Node | None) -> list[str]:
    """Keys given twice in a mapping of a YAML tree; the loader would keep the last."""
    if not isinstance(node, yaml.MappingNode):
        return []
    keys = [key.value for key, _ in node.value]
    here = sorted({key for key in keys if keys.count(key) > 1})
    return here + [key for _, below in node.value for key in repeated(below)]


def plain_number(value: Any, what: str) -> float:
    """A number of a YAML file; YAML reads 7e-3, without a point, as a text."""
    if isinstance(value, int | float) and not isinstance(value, bool) or POWER_OF_TEN.fullmatch(str(value)):
        x = float(str(value))
        if abs(x) < inf:
            return x
    raise ValueError(f"{what} = {str(value)[:80]!r} is not a number; write e.g. 0.35")


def quantity(symbol: str, unit: str, meaning: str, **more: Any) -> Any:
    """A field with symbol, unit and meaning."""
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
        Crown radii of the tyres [m], 0 <= t <= r. Zero is the knife edge of the paper.
    name : str
        Shown in messages and figures.
    unphysical : bool
        Accept moments of inertia that no rigid body has: some published sets break the triangle rule.

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
        for key, meaning in MEANING.items():
            minimum = 0.0 if key in NOT_NEGATIVE else None
            value = number(getattr(self, key), f"{what}: {meaning} {key}", positive=key in POSITIVE, minimum=minimum)
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
        """Share of the weight that the front wheel carries when it is upright: below 0 or above 1 it tips."""
        return (self.mB * self.xB + self.mH * self.xH + self.mF * self.w) / (self.w * self.mass)

    def values(self) -> dict[str, float]:
        """The numbers by symbol, in the order of the fields."""
        return {key: getattr(self, key) for key in MEANING}

    @classmethod
    def from_file(cls, path: str | Path, *, unphysical: bool = False) -> "Parameters":
        """Read a parameter file of BicycleParameters (.txt, .yml, .yaml); see `bicycle.parameters.read_values`.

        Raises
        ------
        ValueError
            Naming the file and the line or symbol: unknown, missing, given twice, or not a number.
        """
        values, _ = read_values(path)
        unknown = [key for key in values if key not in MEANING]
        missing = [key for key in SYMBOLS if key not in values]
        if unknown:
            raise ValueError(f"'{path}': {', '.join(map(str, unknown))} unknown; the symbols are {' '.join(MEANING)}")
        if missing:
            raise ValueError(f"'{path}': {', '.join(missing)} missing; a bicycle needs all of {' '.join(SYMBOLS)}")
        return cls(**values, name=Path(path).stem, unphysical=unphysical)


AXES = ("xx", "yy", "zz", "xz")
BODIES = {"R": "rear wheel", "B": "frame and rider", "H": "fork and handlebar", "F": "front wheel"}
SYMBOL, UNIT, MEANING = (
    {x.name: x.metadata[key] for x in fields(Parameters) if x.metadata} for key in ("symbol", "unit", "meaning")
)
TYRES = ("tR", "tF")
SYMBOLS = tuple(key for key in MEANING if key not in TYRES)  # The 25 parameters of the paper and g
POSITIVE = ("w", "rR", "rF")
NOT_NEGATIVE = ("g", "mR", "mB", "mH", "mF", "tR", "tF")


def check_body(parameters: Parameters, part: str, what: str) -> None:
    """Refuse an impossible inertia; ``unphysical`` allows one that only breaks the triangle rule."""
    inertia, mass = parameters.inertia(part), getattr(parameters, f"m{part}")
    try:
        check_inertia(inertia, mass, what)
    except ValueError as error:
        if mass == 0.0 or np.linalg.eigvalsh(inertia)[0] < 0.0:
            raise
        if not parameters.unphysical:
            raise ValueError(f"{error}; to compute with it all the same give unphysical=True (--unphysical)") from None
