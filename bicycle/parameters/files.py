"""Parameter files of BicycleParameters, as text (.txt) or YAML (.yml, .yaml)."""

import re
from math import hypot, inf
from pathlib import Path
from typing import Any

import yaml

from mbsd3d.errors import InputError
from mbsd3d.extend import as_path, read_text

Numbers = dict[str, float]
FORMATS = (".txt", ".yml", ".yaml")
FILE_BYTES_MAX = {".txt": 1_000_000, ".yml": 50_000, ".yaml": 50_000}  # [bytes] a parameter file has some hundred
# Lists of lists, numbers to base 60, and those without end: what a parser takes minutes for.
NESTED_PATTERN = re.compile(r"(?:[-?:!]\s+){8}|(?:[\[{][^\]}]*){8}|\d(?::\d+){3}|\d{1000}")
POWER_OF_TEN_PATTERN = re.compile(r"[+-]?\d+e[+-]?\d+", re.IGNORECASE)
DECIMAL_COMMA_PATTERN = re.compile(r"(?<![.\d])\d+,\d")  # would be read as two measurements
UNCERTAIN_PATTERN = re.compile(r"^\(?([^()]+?)\s*\+/-\s*([^()]+?)\)?(e[+-]?\d+)?$", re.IGNORECASE)


def is_file(path: str | Path) -> bool:
    """Return whether a name belongs to a parameter file, by its ending."""
    return Path(path).suffix.lower() in FORMATS


def read_values(path: str | Path) -> tuple[Numbers, Numbers]:
    """Read the numbers of a parameter file.

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
        Naming the file and the line or entry: a symbol given twice, or not a number; a file that cannot be read.
    """
    path = as_path(path, "bicycle.txt")
    if not is_file(path):
        raise InputError(f"'{path}': parameter files end in .txt, .yml or .yaml")
    text = read_text(path, FILE_BYTES_MAX[path.suffix.lower()], "parameter")
    entries = text_entries if path.suffix.lower() == ".txt" else yaml_entries
    values, deviations = entries(path, text)
    values.pop("v", None)
    deviations.pop("v", None)
    return values, deviations


def text_entries(path: Path, text: str) -> tuple[Numbers, Numbers]:
    """Read lines ``symbol = value +/- deviation, ...``."""
    values, deviations = {}, {}
    for i, line in enumerate(text.splitlines(), 1):
        content = line.split("#")[0].strip()
        if not content:
            continue
        key, equals, right = (part.strip() for part in content.partition("="))
        where = f"'{path}', line {i}"
        if not equals or not key:
            raise InputError(f"{where}: '{content}' is not of the form 'symbol = value'")
        if key in values:
            raise InputError(f"{where}: {key} is given twice; give it once")
        if DECIMAL_COMMA_PATTERN.search(right):
            raise InputError(f"{where}: {key} = '{right}': write a decimal point, or a blank between two measurements")
        pairs = [value_and_deviation(part.strip(), f"{where}: {key}") for part in right.split(",")]
        values[key] = sum(value for value, _ in pairs) / len(pairs)
        if any(spread is not None for _, spread in pairs):  # deviation of the mean of independent measurements
            deviations[key] = hypot(*(spread or 0.0 for _, spread in pairs)) / len(pairs)
    return values, deviations


def value_and_deviation(text: str, what: str) -> tuple[float, float | None]:
    """Read (value, deviation or None) of "0.1", "0.1 +/- 0.02" or "(1.2 +/- 0.3)e-05"."""
    match = UNCERTAIN_PATTERN.match(text)
    parts = [part + (match[3] or "") for part in match.groups()[:2]] if match else [text]
    try:
        value, *spread = map(float, parts)
    except ValueError:
        raise InputError(f"{what} = '{text}' is not a number; write e.g. 0.35 or 0.35 +/- 0.01") from None
    if spread and not 0.0 <= spread[0] < inf:
        raise InputError(f"{what} = '{text}': the deviation is not a finite number >= 0; give one, or none")
    return value, spread[0] if spread else None


def yaml_entries(path: Path, text: str) -> tuple[Numbers, Numbers]:
    """Read the mapping ``values`` of a YAML file; raise ValueError for references, since they can expand without
    end."""
    if NESTED_PATTERN.search(text):
        raise InputError(
            f"'{path}': lists in lists, numbers to base 60 or without end; a parameter file has names and numbers only"
        )
    try:
        if any(isinstance(token, yaml.AliasToken) for token in yaml.scan(text)):
            raise InputError(f"'{path}': references (*name) are not supported; write the numbers out")
        twice = repeated(yaml.compose(text))
        content: Any = yaml.safe_load(text)
    except (yaml.YAMLError, RecursionError) as error:
        raise InputError(f"'{path}': not valid YAML: {error}") from None
    except (TypeError, OverflowError) as error:  # of keys that are lists, and numbers of many digits
        raise InputError(f"'{path}': {error}; give names and numbers") from None
    if twice:
        raise InputError(f"'{path}': {', '.join(twice)} is given twice; give it once")
    kind = content.get("parameterization", "benchmark") if isinstance(content, dict) else None
    values = content.get("values") if isinstance(content, dict) else None
    if kind != "benchmark" or not isinstance(values, dict):
        raise InputError(f"'{path}': give 'parameterization: benchmark' and the numbers below 'values:'")
    return {key: plain_number(value, f"'{path}': {key}") for key, value in values.items()}, {}


def repeated(node: yaml.Node | None) -> list[str]:
    """Return keys given twice in a mapping of a YAML tree; the loader would keep the last."""
    if not isinstance(node, yaml.MappingNode):
        return []
    keys = [key.value for key, _ in node.value]
    here = sorted({key for key in keys if keys.count(key) > 1})
    return here + [key for _, below in node.value for key in repeated(below)]


def short(value: Any) -> str:
    """Return a value as it prints, cut; a text of digits for integers too long to print."""
    return str(value)[:80] if isinstance(value, int) and abs(value) > 10**80 else repr(value)[:80]


def plain_number(value: Any, what: str) -> float:
    """Read a number of a YAML file; YAML reads 7e-3, without a point, as a text."""
    if isinstance(value, int | float) and not isinstance(value, bool) or POWER_OF_TEN_PATTERN.fullmatch(str(value)):
        number = float(str(value))
        if abs(number) < inf:
            return number
    raise InputError(f"{what} = {short(value)} is not a number; write e.g. 0.35")
