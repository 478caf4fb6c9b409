"""Solutions as tables for other programs: an xarray Dataset, a CSV file, and the meaning of every column."""

import csv
import io
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .drivers import PositionDriver
from .files import package_version, with_suffix, write_atomically
from .measures import state
from .solution import Solution


class Quantity(NamedTuple):
    """What a column of numbers means."""

    unit: str
    frame: str
    description: str


QUANTITIES = {
    "position": Quantity("m", "world", "position of the reference point O"),
    "orientation": Quantity("1", "body -> world", "unit quaternion (e0, e1, e2, e3), scalar first, active"),
    "velocity": Quantity("m/s", "world", "velocity of the reference point O"),
    "omega": Quantity("rad/s", "world", "angular velocity"),
    "omega_body": Quantity("rad/s", "body", "angular velocity"),
    "acceleration": Quantity("m/s^2", "world", "acceleration of the reference point O"),
    "alpha": Quantity("rad/s^2", "world", "angular acceleration"),
    "com": Quantity("m", "world", "position of the centre of mass"),
    "angle": Quantity("rad", "joint", "angle of b relative to a, unwrapped, 0 at the reference pose; NaN: has none"),
    "slide": Quantity("m", "joint", "displacement of b relative to a, 0 at the reference pose; NaN: has none"),
    "rate": Quantity("rad/s", "joint", "rate of the angle; NaN: has none"),
    "slide_rate": Quantity("m/s", "joint", "rate of the slide of a joint without angle; NaN: has none"),
    "reaction_force": Quantity("N", "world", "force of the joint on its body b"),
    "reaction_moment": Quantity("N m", "world", "moment of the joint on its body b about reaction_point"),
    "reaction_point": Quantity("m", "world", "point at which the reaction is given"),
    "reaction_unique": Quantity("1", "none", "1: determined by the constraints, 0: a least-norm share"),
    "effort": Quantity("N m or N", "joint", "torque or force of the driver on b along its motion, see driver_unit"),
    "state": Quantity("see state_unit", "none", "own state of a force, e.g. of a filter; -: as the user defined it"),
    "kinetic": Quantity("J", "world", "kinetic energy"),
    "potential": Quantity("J", "world", "potential energy of gravity and springs"),
    "total": Quantity("J", "world", "kinetic and potential energy"),
    "work": Quantity("J", "world", "work done by drivers and by forces that store no energy"),
    "linear_momentum": Quantity("kg m/s", "world", "momentum"),
    "angular_momentum": Quantity("kg m^2/s", "world", "angular momentum about the world origin"),
    "position_drift": Quantity("m or rad", "none", "largest residual of the joints"),
    "velocity_drift": Quantity("m/s or rad/s", "none", "largest velocity residual of the joints"),
}

BODY_QUANTITIES = ("position", "orientation", "velocity", "omega", "omega_body", "acceleration", "alpha", "com")


class Column(NamedTuple):
    """One quantity of one part: (samples,) or (samples, components), or one value for all samples."""

    kind: str
    part: str
    quantity: str
    unit: str
    values: np.ndarray


def columns(solution: Solution) -> list[Column]:
    """All quantities of all parts; kind is "body", "joint", "driver", "own_state" or "" for the whole system."""
    system, found = solution.system, []

    def add(kind: str, part: str, quantity: str, values: Any) -> None:
        found.append(Column(kind, part, quantity, QUANTITIES[quantity].unit, np.asarray(values)))

    for body in system.bodies:
        for quantity in BODY_QUANTITIES:
            add("body", body.name, quantity, getattr(solution, quantity)(body))
    for joint in system.joints:
        name, turns, slides = system.name(joint), joint.angle() is not None, joint.slide() is not None
        for quantity, has in (("angle", turns), ("slide", slides), ("rate", turns)):
            if has:
                add("joint", name, quantity, getattr(solution, quantity)(joint))
        if slides and not turns:
            add("joint", name, "slide_rate", solution.rate(joint))
        for quantity, values in vars(solution.reaction(joint)).items():
            add("joint", name, f"reaction_{quantity}", values)
    for driver in dict.fromkeys(driver for driver, _ in solution.compiled.drives):
        found += columns_of_effort(solution, driver)
    for force in system.forces:
        found += columns_of_states(solution, force)
    for quantity, values in vars(solution.energy()).items():
        add("", "energy", quantity, values)
    for owner in ("momentum", "drift"):
        for quantity, values in vars(getattr(solution, owner)()).items():
            add("", "", f"{quantity}_{owner}", values)
    return found


def columns_of_effort(solution: Solution, driver: Any) -> list[Column]:
    """One column per row of a driver; a driver of several rows is named with the axis or the number of the row."""
    effort = solution.effort(driver).reshape(solution.t.size, -1)
    units = [unit for row in driver.rows() for unit in ["N" if row.in_metres else "N m"] * row.n_rows]
    if isinstance(driver, PositionDriver):
        labels = [f".{axis}" for axis, signal in zip("xyz", driver.signal, strict=True) if signal is not None]
    else:
        labels = [""] if len(units) == 1 else [f".{k}" for k in range(len(units))]
    names = [solution.system.name(driver) + label for label in labels]
    return [Column("driver", name, "effort", *rest) for name, *rest in zip(names, units, effort.T, strict=True)]


def columns_of_states(solution: Solution, force: Any) -> list[Column]:
    """One column per own state of a force, named by its number."""
    name, values = solution.system.name(force), solution.state_of(force).T
    return [Column("own_state", f"{name}.{k}", "state", state(force, k).unit, z) for k, z in enumerate(values)]


def components(values: np.ndarray) -> tuple[str, tuple[str, ...]]:
    """Dimension and labels of the components of a column."""
    if values.ndim < 2:
        return "", ()
    return ("axis", ("x", "y", "z")) if values.shape[1] == 3 else ("quaternion", ("e0", "e1", "e2", "e3"))


def to_csv(solution: Solution, path: str | Path) -> Path:
    """Write a table with one row per sample and one column per component, e.g. ``crank.position.x [m]``.

    Parameters
    ----------
    solution : Solution
        Its numbers are written such that they read back equal.
    path : str or Path
        ".csv" is appended if it is missing; an older file is replaced in one go.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    ValueError
        If the folder cannot be written.
    """
    header, table = ["time [s]"], [solution.t]
    for column in columns(solution):
        labels = [f".{label}" for label in components(column.values)[1]] or [""]
        name = ".".join(text for text in (column.part, column.quantity) if text)
        header += [f"{name}{label} [{column.unit}]" for label in labels]
        values = np.broadcast_to(column.values, solution.t.shape) if column.values.ndim == 0 else column.values
        table += list(values.reshape(solution.t.size, len(labels)).T)
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(header)
    rows.writerows(zip(*(values.astype(float).tolist() for values in table), strict=True))
    return write_atomically(with_suffix(path, ".csv"), text.getvalue().encode())


def to_xarray(solution: Solution) -> Any:
    """All quantities as an xarray Dataset; ``dataset.to_netcdf(path, engine="h5netcdf")`` writes it.

    Parameters
    ----------
    solution : Solution
        Of any system.

    Returns
    -------
    xarray.Dataset
        Dimensions time, body, joint, driver, own_state (of forces), axis (x, y, z) and quaternion (e0 ... e3); every
        variable carries units, frame and description. Quantities a joint does not have are NaN.
    """
    import xarray

    found, system = columns(solution), solution.system
    efforts, states = ([column for column in found if column.kind == kind] for kind in ("driver", "own_state"))
    names = {
        "body": [body.name for body in system.bodies],
        "joint": [system.name(joint) for joint in system.joints],
        "driver": [column.part for column in efforts],
        "own_state": [column.part for column in states],
    }
    grouped: dict[tuple[str, str], list[Column]] = {}
    for column in found:
        grouped.setdefault((column.kind, column.quantity), []).append(column)
    variables = {key[1]: variable(key[0], group, names, solution.t.size) for key, group in grouped.items()}
    labels = {"axis": ["x", "y", "z"], "quaternion": ["e0", "e1", "e2", "e3"]} | {k: v for k, v in names.items() if v}
    labels["time"] = ("time", solution.t, {"units": "s", "description": "time"})
    if efforts:
        labels["driver_unit"] = ("driver", [column.unit for column in efforts])
    if states:
        labels["state_unit"] = ("own_state", [column.unit for column in states])
    return xarray.Dataset(variables, labels, attributes(solution))


def variable(kind: str, group: list[Column], names: dict[str, list[str]], samples: int) -> tuple[list[str], Any, dict]:
    """Dimensions, values and attributes of one quantity of all parts of a kind."""
    unit, frame, description = QUANTITIES[group[0].quantity]
    attrs = {"units": unit, "frame": frame, "description": description}
    values = group[0].values
    dimension = [name for name in components(values)[:1] if name]
    if not kind:
        return ["time", *dimension], values, attrs
    if values.ndim == 0:
        return [kind], np.array([int(column.values) for column in group]), attrs
    whole = np.full((samples, len(names[kind]), *values.shape[1:]), np.nan)
    for column in group:
        whole[:, names[kind].index(column.part)] = column.values
    return ["time", kind, *dimension], whole, attrs


def attributes(solution: Solution) -> dict[str, Any]:
    """What netCDF can hold of how the solution was made."""
    certificate = solution.certificate
    return {
        "method": str(solution.record.method),
        "rtol": float(solution.record.rtol),
        "steps": int(solution.record.steps),
        "stopped_by": solution.record.stopped_by or "end of the run",
        "certificate_passed": int(certificate.passed),
        "certificate": str(certificate),
        "gravity": solution.system.gravity.tolist(),
        "mbsd3d_version": package_version(),
    }
