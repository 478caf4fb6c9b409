"""What a page needs to solve its mechanism again: tables over the sliders, terms to omit, a ghost, and readings of what
it shows."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np

from ...base.errors import InputError
from ...mechanism.bodies import GROUND
from ...mechanism.couplings import GearMesh
from ...mechanism.joints import Joint
from ...plotting.default_curves import default_curves, seen_panels
from ...plotting.panels import AXIS_NAMES, Panel, Wanted
from ...results.columns import BODY_QUANTITIES
from ...results.result import RunResult
from ..scene.overlays import Arrows, Points, Trace, is_ground, trace_point
from .drawn import picture_over
from .lowered import Tables, lowered, method
from .sliders import Build, Slider, Values, aligned, fitted, flat, shown, tables_over, varying

THEORY_ERROR_MAX, THEORY_DEGREES = 1e-6, (4, 12, 16)  # [1] of the size of a number of theory; of its polynomials
READ_OF_BODIES = frozenset({"position", "velocity", "com", "omega", "omega_body", "orientation"})
Reading = dict[str, Any] | None  # how a number is read from the solved motion; None: the page cannot


class Ghost(NamedTuple):
    """Second run in the same picture: with other values, or without a term of the equations."""

    label: str
    change: Mapping[str, Any] = {}
    term: str = ""


class Theory(NamedTuple):
    """Numbers by formulas: of the values of the sliders, and their names with units."""

    numbers: Callable[..., Sequence[float]]  # (**values)
    labels: Sequence[tuple[str, str]]
    readings: Sequence[Reading] = ()  # by which the page finds them itself


@dataclass(frozen=True, eq=False)
class Exploration:
    """Mechanism that a page solves: how it is built from the values of the sliders, and what else can be switched."""

    build: Build
    sliders: Sequence[Slider] = ()
    ghost: Ghost | None = None
    theory: Theory | None = None


def exploration_data(
    given: Exploration, run: RunResult, origin: np.ndarray, wanted: tuple[Wanted | None, Points | None],
    drawn: tuple[Sequence[Arrows], Sequence[Trace]],
) -> dict[str, Any]:  # fmt: skip
    """Return what the script of the page reads; ``wanted``: the curves and traces that were asked for, ``drawn``: the
    arrows and traces of the run, ``origin``: about which the scene is drawn.

    Raises
    ------
    ValueError
        If the solver of a page cannot solve this mechanism, or the run does not start as ``build`` says.
    """
    found = tables_over(given.build, given.sliders)
    if not same_start(lowered(run.system, run.start), found["tables"]):
        raise InputError(
            f"page that solves: the run does not start as the mechanism with {shown(starts(given))}; give the "
            "values of the run as the starts of the sliders"
        )
    shapes, stale = picture_over(given.build, given.sliders, origin)
    curves, traces = wanted
    curves = default_curves(run) if curves is None else curves
    traces = [x.name for x in drawn[1]] if traces is None else traces
    return {
        **found,
        "method": method(),
        "origin": origin.tolist(),
        "sliders": [{**asdict(x), "label": x.text} for x in given.sliders],
        "terms": terms_of(run),
        "ghost": ghost_data(given),
        "theory": theory_data(given),
        "curves": [lines for entry in curves for lines in readings_of(run, entry)],
        "traces": [trace_data(run, entry) for entry in traces],
        "arrows": [arrows_data(run, kind) for kind in drawn[0]],
        "joints": [joint_data(run, joint) for joint in run.system.joints],
        "com": [body.com.tolist() for body in run.system.bodies],
        "shapes": shapes,
        "stale": sorted(stale),
    }


def same_start(one: Tables, other: Tables) -> bool:
    """Return whether two tables are the same but for rounding."""
    (rest, _, values), (known, _, expected) = flat(one), flat(aligned(other, one))
    return rest == known and bool(np.allclose(values, expected, rtol=1e-12, atol=1e-12))


def arrows_data(run: RunResult, kind: Arrows) -> list[int] | None:
    """Return the places of the bodies or joints whose arrows these are; None where the page cannot give them."""
    if kind.kind in ("angular velocity", "angular momentum"):
        return [[body.name for body in run.system.bodies].index(name) for name in kind.names]
    joints = {run.system.name(x): i for i, x in enumerate(run.system.joints) if joint_data(run, x)}
    return [joints[name] for name in kind.names] if joints.keys() >= set(kind.names) else None


def starts(given: Exploration) -> Values:
    """Return the values at which the sliders start."""
    return {x.name: x.start for x in given.sliders}


def terms_of(run: RunResult) -> list[str]:
    """Return the terms whose omission may change something."""
    I = run.compiled.model.body["inertia"].reshape(-1, 3, 3)
    sphere = np.trace(I, axis1=1, axis2=2)[:, None, None] / 3.0 * np.eye(3)
    found = ["gyroscopic"] if np.abs(I - sphere).max() > 1e-9 * np.abs(I).max() else []
    found += ["centripetal"] if run.compiled.model.body["com"].any() else []
    return found + (["gamma"] if run.compiled.model.row.size else [])


def ghost_data(given: Exploration) -> dict[str, Any] | None:
    """Return label and tables of the ghost, or the term that it lacks; None where it has other parts."""
    ghost = given.ghost
    if ghost is None:
        return None
    if ghost.term:
        return {"label": ghost.label, "term": ghost.term}
    others = [x for x in given.sliders if x.name not in ghost.change]

    def build(**values: float) -> Any:
        return given.build(**{**values, **ghost.change})

    try:
        found = tables_over(build, others)
    except ValueError:
        return None
    return {"label": ghost.label, **found, "sliders": [x.name for x in others]}


def theory_data(given: Exploration) -> dict[str, Any] | None:
    """Return the numbers of theory over the sliders; those whose polynomials miss them are left out."""
    theory = given.theory
    if theory is None:
        return None

    def numbers(values: Values) -> np.ndarray:
        return np.array(theory.numbers(**values), float)

    first = numbers(starts(given))
    try:
        found, error = fitted(
            numbers, given.sliders, lambda x: np.abs(x).reshape(-1, first.size).max(axis=0), THEORY_DEGREES
        )
    except (ValueError, ArithmeticError):
        return None  # there is a place within the ranges where the formulas do not hold
    lines = []
    for j, (label, unit) in enumerate(theory.labels):
        if error[j] <= THEORY_ERROR_MAX:
            terms = varying(["value"], first[j : j + 1], found[..., j : j + 1], len(given.sliders))
            reading = theory.readings[j] if theory.readings else None
            line = {"label": label, "unit": unit, "start": float(first[j]), "reading": reading}
            lines.append({**line, "terms": terms[0]["terms"] if terms else []})
    return {"lines": lines} if lines else None


def readings_of(run: RunResult, entry: Any) -> list[list[Reading]]:
    """Return how each line of the panels of an entry of ``curves`` is read."""
    quantity, *parts = (entry,) if isinstance(entry, str) or not isinstance(entry, Iterable) else tuple(entry)
    return [
        [reading_of(run, quantity, parts, panel, k) for k in range(len(panel.lines))]
        for panel in seen_panels(run, [entry])
    ]


def reading_of(run: RunResult, quantity: Any, parts: Sequence[Any], panel: Panel, k: int) -> Reading:
    """Return how line ``k`` of a panel is read; None: the page cannot."""
    system, index, (name, _) = run.system, run.compiled.body_index, panel.lines[k]
    if quantity in BODY_QUANTITIES and quantity in READ_OF_BODIES:
        bodies = [system.part(part) for part in parts] or list(system.bodies)
        if len(bodies) == 1:
            return {"of": quantity, "body": index[id(bodies[0])], "axis": k}
        axis = [*AXIS_NAMES, "e0", "e1", "e2", "e3"].index(panel.label.rpartition(" ")[2]) % 3
        return {"of": quantity, "body": index[id(bodies[k])], "axis": axis} if quantity != "orientation" else None
    if quantity in ("angle", "slide", "rate"):
        joint = joint_named(run, name, parts)
        x = joint.angle() or joint.slide() if quantity != "slide" else joint.slide()
        name = "rate" if quantity == "rate" else "coordinate"
        return None if x is None else {"of": name, "coordinate": run.compiled.coordinate(x)}
    if quantity == "effort":
        driver = joint_named(run, name, parts)
        rows = run.compiled.rows[id(driver)]
        known = rows.stop == rows.start + 1 and run._is_unique([driver])
        return {"of": "effort", "row": rows.start} if known else None
    if quantity == "force" and panel.unit == "[N]":
        forces = [system.part(part, "forces") for part in parts]
        force = forces[0] if len(forces) == 1 else system.part(name, "forces")
        return {"of": "push", "force": system.forces.index(force), "axis": k if len(forces) == 1 else -1}
    if quantity == "energy":
        return {"of": "energy", "part": name}
    if quantity == "reaction" and not panel.note and "not unique" not in name:
        own = joint_named(run, name, parts) if panel.label.startswith("|") else None
        joint = own or joint_named(run, panel.label.rpartition(" of ")[2], parts)
        if joint_data(run, joint) is None:
            return None
        kind = "force" if "force" in panel.label.split(" of ")[0] else "moment"
        return {"of": kind, "joint": system.joints.index(joint), "axis": -1 if own else AXIS_NAMES.index(name)}
    return None


def joint_named(run: RunResult, name: str, parts: Sequence[Any]) -> Joint:
    """Return the joint of a line, by its name or as the only one that was asked for."""
    joints = [run.system.part(part, "joints") for part in parts]
    return joints[0] if len(joints) == 1 else run.system.part(name, "joints")


def trace_data(run: RunResult, entry: Any) -> dict[str, Any]:
    """Return the body of a trace, its point in the axes of the body, and the body from which it is seen."""
    body, point, base = trace_point(run.system, entry)
    index = run.compiled.body_index
    return {
        "body": index[id(body)],
        "point": point.tolist(),
        "base": len(index) - 1 if is_ground(base) else index[id(base)],
    }


def joint_data(run: RunResult, joint: Joint) -> dict[str, Any] | None:
    """Return rows, body b and point of a joint whose reaction the page can give, and the body that carries the point;
    None of others."""
    rows, index = run.compiled.rows[id(joint)], run.compiled.body_index
    known = type(joint).reaction_points in (Joint.reaction_points, GearMesh.reaction_points)
    if not known or joint.b is GROUND or not run._is_unique([joint]):
        return None
    carrier = joint.support() if isinstance(joint, GearMesh) else joint.b
    return {
        "rows": [rows.start, rows.stop], "body": index[id(joint.b)], "on": index[id(carrier)],
        "point": carrier.local_point(joint.point()).tolist(),
    }  # fmt: skip
