"""Tables of a mechanism as plain lists and numbers, from which `view/page/assets/solver.js` forms the same equations.

What the solver of a page does not know is refused: such pages keep their replay.
"""

from typing import Any

import numpy as np

from ...base.errors import InputError
from ...constraints.rank import Analysis
from ...equations.at_state import driven_coordinates, load_state
from ...equations.compiled import Compiled, compile_system
from ...equations.jacobian import scaled_rows
from ...integrators.dop853_coefficients import E3, E5, A, B, C
from ...kernels import kinds
from ...mechanism.force_element import ForceElement
from ...mechanism.mechanism import Mechanism
from ...mechanism.state import State

# By number: rows of hinges, slides, balls, couplings, drivers, rolling, gear teeth; angles and slides
KNOWN_ROWS = frozenset(range(kinds.MESH + 1))
KNOWN_COORDINATES = frozenset({kinds.ANGLE, kinds.SLIDE})
KNOWN_FORCES = frozenset({
    "AeroDrag", "Bushing", "CentralGravity", "Contact", "Force", "JointFriction", "SpringDamper", "Torque",
    "TorsionSpring", "Tyre", "Weight",
})  # fmt: skip

Tables = dict[str, Any]


def lowered(system: Mechanism, state: State) -> Tables:
    """Return the tables of a mechanism that starts at a state, as JSON has them.

    Raises
    ------
    ValueError
        If a part has rows, a law or states of its own that the solver of a page does not know.
    """
    compiled = compile_system(system)
    check_known(compiled)
    model, data = compiled.model, compiled.data()
    y = load_state(compiled, data, state)
    found = Analysis(scaled_rows(model, data))
    start = driven_coordinates(compiled, state.t) if state.coordinates is None else state.coordinates
    return {
        "body": [
            {**record, "light": int(inverse == 0.0)}
            for record, inverse in zip(
                records(model.body, ("mass", "com", "inertia")), model.body["inv_mass"], strict=True
            )
        ],
        "primitive": records(
            model.primitive,
            ("kind", "row", "rows", "body", "point", "axis", "second_axis", "value", "coordinate", "signal"),
        ),
        "row": records(model.row, ("body", "holonomic", "scale", "drive")),
        "coordinate": [
            {**record, "start": float(value)}
            for record, value in zip(
                records(model.coordinate, ("kind", "body", "point", "axis")),
                start[: model.coordinate.size],
                strict=True,
            )
        ],
        "force": [force_record(force, compiled, i) for i, force in enumerate(system.forces)],
        "state": states(compiled, y[13 * model.body.size :][: model.z_work]),
        "signal": signals(compiled),
        "gravity": model.gravity.tolist(),
        "length": float(model.length),
        "driven": bool(found.rank == 6 * model.body.size and (model.row["holonomic"] == 1).all() and model.z_work == 0),
        "start": {"q": state.q.tolist(), "v": state.v.tolist()},
    }


def check_known(compiled: Compiled) -> None:
    """Raise a ValueError with the first part that the solver of a page does not know."""
    system, model = compiled.system, compiled.model
    for k, p in enumerate(model.primitive):
        if int(p["kind"]) not in KNOWN_ROWS:
            joint = compiled.holders[compiled.row_joint[model.primitive["row"][k]]]
            refuse(
                f"'{system.name(joint)}' ({type(joint).__name__}): its rows are not among those of the page's solver"
            )
    for force in system.forces:
        known = type(force).__name__ in KNOWN_FORCES and getattr(force, "other", None) is None
        if not known:
            refuse(f"'{system.name(force)}' ({type(force).__name__}): its law is not among those of the page's solver")
    if not set(model.coordinate["kind"].tolist()) <= KNOWN_COORDINATES:
        refuse("a hinge coordinate is neither an angle nor a slide")
    if compiled.modes:
        refuse(f"'{next(iter(compiled.modes))}' switches at events")
    if model.reflected.size:
        refuse("a joint has a reflected inertia")


def refuse(why: str) -> None:
    """Raise the error that says why a page cannot solve."""
    raise InputError(f"page that solves: {why}; leave out the sliders, and the page replays the run")


def records(table: np.ndarray, names: tuple[str, ...]) -> list[dict[str, Any]]:
    """Return some fields of a table, record by record."""
    return [{name: record[name].tolist() for name in names} for record in table]


def force_record(force: ForceElement, compiled: Compiled, i: int) -> dict[str, Any]:
    """Return the record of force element ``i``, with the parameters of its law by name."""
    fields = ("body", "point", "frame", "signal", "coordinate", "option", "state", "states")
    given = records(compiled.model.force[i : i + 1], fields)[0]
    counts, values = force.law_parameters.counts, force.law_parameters.pack(force.record().parameters)
    named, place = {}, 0
    for name, count in counts.items():
        named[name] = values[place] if count == 1 else values[place : place + count]
        place += count
    return {"law": type(force).__name__, **given, **named}


def states(compiled: Compiled, own: np.ndarray) -> list[dict[str, float]]:
    """Return the states that force elements own at the start, with the units of their errors."""
    return [
        {"unit": float(x["unit"]), "power": float(x["power"]), "start": float(z)}
        for x, z in zip(compiled.model.state[: own.size], own, strict=True)
    ]


def signals(compiled: Compiled) -> list[list[dict[str, Any]]]:
    """Return the terms of each signal."""
    term, data = compiled.model.term, compiled.model.term_data
    return [
        [
            {"kind": int(x["kind"]), "data": data[x["first"] : x["end"]].tolist()}
            for x in term[own["first"] : own["end"]]
        ]
        for own in compiled.model.signal
    ]


def method() -> dict[str, list[Any]]:
    """Return the coefficients of the steps, of order 8."""
    lines = [row[:k].tolist() for k, row in enumerate(A)]
    return {"A": lines, "B": B.tolist(), "C": C.tolist(), "E3": E3.tolist(), "E5": E5.tolist()}
