"""Solutions as tables for other programs: an xarray Dataset, a CSV file, and the meaning of every column."""

import csv
import io
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.paths import package_version, with_suffix, write_atomically
from ..results.certificate import certificate_of
from ..results.columns import QUANTITIES, Column, columns, components
from ..results.result import RunResult

if TYPE_CHECKING:
    from pandas import DataFrame
    from xarray import Dataset

FORMULA_CHARACTERS = ("=", "+", "-", "@", "\t", "\r")  # first characters by which a spreadsheet knows a formula


def to_csv(solution: RunResult, path: str | Path) -> Path:
    """Write a CSV file; see `Solution.to_csv`."""
    header, values = wide(solution)
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow([harmless(name) for name in header])
    rows.writerows(zip(*(column.tolist() for column in values), strict=True))
    content = text.getvalue().encode(errors="replace")  # halves of characters in names, as pages have them
    return write_atomically(with_suffix(path, ".csv"), content)


def to_dataframe(solution: RunResult) -> "DataFrame":
    """Make a pandas DataFrame; see `Solution.to_dataframe`."""
    import pandas

    header, values = wide(solution)
    index = pandas.Index(values[0], name=header[0])
    return pandas.DataFrame(np.column_stack(values[1:]), index, header[1:])


def wide(solution: RunResult) -> tuple[list[str], list[np.ndarray]]:
    """Return (names, (samples,) values) of one column per component of every quantity, the time first."""
    header, table = ["time [s]"], [solution.t]
    for column in columns(solution):
        labels = [f".{label}" for label in components(column.values)[1]] or [""]
        name = ".".join(text for text in (column.part, column.quantity) if text)
        header += [f"{name}{label} [{column.unit}]" for label in labels]
        values = column.values.reshape(-1, len(labels))  # one row for all samples, or as many
        table += list(np.broadcast_to(values, (solution.t.size, len(labels))).T)
    return header, [values.astype(float) for values in table]


def harmless(name: str) -> str:
    """Return a text that no spreadsheet takes for a formula: names may come from files of other people."""
    return f"'{name}" if name[:1] in FORMULA_CHARACTERS else name


def to_xarray(solution: RunResult) -> "Dataset":
    """Make an xarray Dataset; see `Solution.to_xarray`."""
    import xarray

    found, system = columns(solution), solution.system
    efforts, loads, states = ([x for x in found if x.kind == kind] for kind in ("driver", "force_element", "own_state"))
    names = {
        "body": [body.name for body in system.bodies],
        "joint": [system.name(joint) for joint in system.joints],
        "driver": [column.part for column in efforts],
        "force_element": list(dict.fromkeys(column.part for column in loads)),
        "own_state": [column.part for column in states],
    }
    grouped: dict[tuple[str, str], list[Column]] = {}
    for column in found:
        grouped.setdefault((column.kind, column.quantity), []).append(column)
    variables = {key[1]: variable(key[0], group, names, solution.t.size) for key, group in grouped.items()}
    labels: dict[str, Any] = {"axis": ["x", "y", "z"], "quaternion": ["e0", "e1", "e2", "e3"]}
    labels |= {k: v for k, v in names.items() if v}
    labels["time"] = ("time", solution.t, {"units": "s", "description": "time"})
    if efforts:
        labels["driver_unit"] = ("driver", [column.unit for column in efforts])
    if states:
        labels["state_unit"] = ("own_state", [column.unit for column in states])
    return xarray.Dataset(variables, labels, attributes(solution))


def variable(
    kind: str, group: list[Column], names: dict[str, list[str]], samples: int
) -> tuple[list[str], Any, dict[str, Any]]:
    """Return dimensions, values and attributes of one quantity of all parts of a kind."""
    unit, frame, description = QUANTITIES[group[0].quantity]
    attrs = {"units": unit, "frame": frame, "description": description}
    values = group[0].values
    dimension = [name for name in components(values)[:1] if name]
    if not kind:
        return ["time", *dimension], values, attrs
    if values.dtype == bool:  # one for all samples
        return [kind, *dimension], np.array([column.values for column in group], int), attrs
    whole = np.full((samples, len(names[kind]), *values.shape[1:]), np.nan)
    for column in group:
        whole[:, names[kind].index(column.part)] = column.values
    return ["time", kind, *dimension], whole, attrs


def attributes(solution: RunResult) -> dict[str, Any]:
    """Return what netCDF can hold of how the solution was made."""
    certificate = certificate_of(solution)
    return {
        "method": str(solution.record.method),
        "rtol": float(solution.record.rtol),
        "steps": int(solution.record.steps),
        "stopped_by": solution.record.stopped_by or "end of the run",
        "certificate_passed": int(certificate.passed),
        "certificate": str(certificate),
        "title": solution.system.title or "",
        "gravity": solution.system.gravity.tolist(),
        "mbsd3d_version": package_version(),
    }
