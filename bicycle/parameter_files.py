"""The text and YAML formats in which BicycleParameters keeps parameter sets."""

import re
from pathlib import Path
from typing import Any

from .parameters import SYMBOLS, TYRES

LARGEST = 1_000_000  # bytes: a parameter file has some hundred
UNCERTAIN = re.compile(r"^\(?([^()]+?)\s*\+/-\s*([^()]+?)\)?(e[+-]?\d+)?$", re.IGNORECASE)


def read_values(path: str | Path) -> tuple[dict[str, float], dict[str, float]]:
    """Numbers of a parameter file.

    Parameters
    ----------
    path : str or Path
        ``.txt``: lines ``symbol = value``, ``symbol = value +/- deviation`` or several of these separated by commas,
        which are averaged; ``#`` starts a comment. ``.yml``, ``.yaml``: numbers below ``values:``, of the
        parameterization ``benchmark``. An entry v, the speed of a study, is no part of the bicycle and is left out.

    Returns
    -------
    values, deviations : dict
        By symbol; standard deviations only where the file gives them.

    Raises
    ------
    ValueError
        Naming the file and the line or entry: a symbol unknown, missing or given twice, or a text that is no number.
    """
    path = Path(path)
    readers = {".txt": text_entries, ".yml": yaml_entries, ".yaml": yaml_entries}
    if path.suffix not in readers:
        raise ValueError(f"'{path}': parameter files end in .txt, .yml or .yaml")
    if path.stat().st_size > LARGEST:
        raise ValueError(f"'{path}': larger than {LARGEST} bytes, so it is no parameter file")
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError:
        raise ValueError(f"'{path}': not a text; give a parameter file of BicycleParameters") from None
    values, deviations = readers[path.suffix](path, text)
    values.pop("v", None)
    deviations.pop("v", None)
    unknown = [key for key in values if key not in (*SYMBOLS, *TYRES)]
    missing = [key for key in SYMBOLS if key not in values]
    if unknown:
        raise ValueError(f"'{path}': {', '.join(map(str, unknown))} unknown; there are {' '.join((*SYMBOLS, *TYRES))}")
    if missing:
        raise ValueError(f"'{path}': {', '.join(missing)} missing; a bicycle needs all of {' '.join(SYMBOLS)}")
    return values, deviations


def text_entries(path: Path, text: str) -> tuple[dict[str, float], dict[str, float]]:
    """Lines ``symbol = value +/- deviation, ...``."""
    values, deviations = {}, {}
    for i, line in enumerate(text.splitlines(), 1):
        content = line.split("#")[0].strip()
        if not content:
            continue
        key, equals, right = (part.strip() for part in content.partition("="))
        where = f"'{path}', line {i}"
        if not equals or not key:
            raise ValueError(f"{where}: '{content}' is no 'symbol = value'")
        if key in values:
            raise ValueError(f"{where}: {key} stands twice; give it once")
        pairs = [value_and_deviation(part.strip(), f"{where}: {key}") for part in right.split(",")]
        values[key] = sum(value for value, _ in pairs) / len(pairs)
        if any(spread is not None for _, spread in pairs):  # of the mean of independent measurements
            deviations[key] = sum((spread or 0.0) ** 2 for _, spread in pairs) ** 0.5 / len(pairs)
    return values, deviations


def value_and_deviation(text: str, what: str) -> tuple[float, float | None]:
    """(value, deviation or None) of "0.1", "0.1 +/- 0.02" or "(1.2 +/- 0.3)e-05"."""
    match = UNCERTAIN.match(text)
    parts = [part + (match[3] or "") for part in match.groups()[:2]] if match else [text]
    try:
        value, *spread = map(float, parts)
    except ValueError:
        raise ValueError(f"{what} = '{text}' is no number; write e.g. 0.35 or 0.35 +/- 0.01") from None
    return value, spread[0] if spread else None


def yaml_entries(path: Path, text: str) -> tuple[dict[str, float], dict[str, float]]:
    """The mapping ``values`` of a YAML file without references, which could grow without end."""
    import yaml

    try:
        if any(isinstance(token, yaml.AliasToken) for token in yaml.scan(text)):
            raise ValueError(f"'{path}': references (*name) are not read; write the numbers out")
        content: Any = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise ValueError(f"'{path}': no YAML: {error}") from None
    kind = content.get("parameterization", "benchmark") if isinstance(content, dict) else None
    values = content.get("values") if isinstance(content, dict) else None
    if kind != "benchmark" or not isinstance(values, dict):
        raise ValueError(f"'{path}': give 'parameterization: benchmark' and the numbers below 'values:'")
    for key, value in values.items():
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ValueError(f"'{path}': {key} = {value!r} is no number; write e.g. 0.35")
    return {key: float(value) for key, value in values.items()}, {}
