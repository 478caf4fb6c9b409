"""Quantities of a solution as panels of named lines with label and unit; no plotting."""

import textwrap
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple, TypeGuard

import numpy as np

from ..base.checks import short_repr
from ..base.errors import InputError
from ..base.figure import Figure
from ..base.style import LIGHT, figure_style, style_axes
from ..base.wording import with_superscripts
from ..equations.compiled import holders_of
from ..linear.modes import ModalAnalysis
from ..mechanism.bodies import Body
from ..mechanism.force_element import ForceElement
from ..mechanism.forces.custom import SavedForce
from ..mechanism.joints import Joint
from ..mechanism.measures import Measure
from ..mechanism.switching import is_switching
from ..results.checks.check import scales_of
from ..results.columns import BODY_QUANTITIES, QUANTITIES, Column, columns_of_effort, columns_of_states, loads_of
from ..results.element_loads import Load, load_of
from ..results.reactions import Reaction
from ..results.result import RunResult

Part = Body | Joint | ForceElement | str
PlotQuantity = str | Measure | tuple[str | Measure | Part, ...]  # with or without parts
Wanted = Iterable[PlotQuantity]
Line = tuple[str, np.ndarray]  # name, values (samples,)
QUANTITY_LABELS = {
    "omega": "angular velocity", "omega_body": "angular velocity, body axes", "alpha": "angular acceleration",
    "com": "centre of mass", "orientation": "quaternion",
}  # fmt: skip
CHANGE_SHARE_MIN, CHANGE_SHARE_MAX = 1e-9, 0.03  # [1] of the largest energy: below is rounding, above one sees it
AXIS_NAMES, QUATERNION_NAMES = ("x", "y", "z"), ("e0", "e1", "e2", "e3")


class Panel(NamedTuple):
    """Pair of axes: label, unit in brackets, named lines (samples,), a note above the legend, values that it shows."""

    label: str
    unit: str
    lines: list[Line]
    note: str = ""
    log: bool = False
    shows: tuple[float, ...] = ()  # whatever the lines are
    size: float = 0.0  # what such a quantity amounts to in this run; 1e-9 of it is rounding

    def in_degrees(self) -> "Panel":
        """Return the panel in degrees, if it is in radians."""
        for unit in ("rad", "rad/s", "rad/s²"):
            if self.unit == f"[{unit}]":
                lines = [(name, np.degrees(values)) for name, values in self.lines]
                size = float(np.degrees(self.size))
                return self._replace(unit=f"[{unit.replace('rad', '°')}]", lines=lines, size=size)
        return self


def natural_sizes(solution: RunResult) -> dict[str, float]:
    """Return what quantities amount to in a run, by their units as printed on an axis."""
    scale, length = scales_of(solution), float(solution.compiled.model.length)
    return {
        "[m]": length, "[m/s]": scale.rate * length, "[m/s²]": scale.acceleration, "[rad]": 1.0,
        "[rad/s]": scale.rate, "[rad/s²]": scale.acceleration / length, "[N]": scale.force, "[N m]": scale.moment,
        "[kg m/s]": scale.momentum, "[kg m²/s]": scale.angular_momentum, "[J]": scale.energy,
        "[W]": scale.energy * scale.rate,
    }  # fmt: skip


def unit_of(quantity: str) -> str:
    """Return the unit as it is printed on an axis."""
    unit = QUANTITIES[quantity].unit
    return "[-]" if unit == "1" else f"[{with_superscripts(unit)}]"


def vector_panels(label: str, unit: str, names: Sequence[str], parts: dict[str, np.ndarray]) -> list[Panel]:
    """Return the components of one part in one panel; of several parts a panel per component."""
    if len(parts) == 1:
        part, values = next(iter(parts.items()))
        owner = f" of {part}" if part else ""
        return [Panel(label + owner, unit, list(zip(names, values.T, strict=True)))]
    return [
        Panel(f"{label} {name}", unit, [(part, values[:, k]) for part, values in parts.items()])
        for k, name in enumerate(names)
    ]


def body_panels(solution: RunResult, quantity: str, parts: tuple[Part, ...]) -> list[Panel]:
    """Return panels of a quantity of bodies; none given = all."""
    bodies = [solution.system.part(part) for part in parts] or solution.system.bodies
    names = QUATERNION_NAMES if quantity == "orientation" else AXIS_NAMES
    found = {body.name: getattr(solution, quantity)(body) for body in bodies}
    return vector_panels(QUANTITY_LABELS.get(quantity, quantity), unit_of(quantity), names, found)


def joint_panels(solution: RunResult, quantity: str, parts: tuple[Part, ...]) -> list[Panel]:
    """Return panels of angle, displacement or rate of joints; none given = all that have one."""
    system = solution.system
    joints = [system.part(part, "joints") for part in parts]
    if not joints:
        kinds = {"rate": ("angle", "slide")}.get(quantity, (quantity,))
        joints = [joint for joint in system.joints if any(getattr(joint, kind)() is not None for kind in kinds)]
    groups: dict[str, list[Line]] = {}
    for joint in joints:
        name = "slide_rate" if quantity == "rate" and joint.angle() is None else quantity
        groups.setdefault(name, []).append((system.name(joint), getattr(solution, quantity)(joint)))
    if not groups:
        raise InputError(f"no joint of this system has the quantity {quantity}; give another quantity")
    return [scalar_panel(name.replace("_", " "), unit_of(name), lines) for name, lines in groups.items()]


def scalar_panel(label: str, unit: str, lines: list[Line]) -> Panel:
    """Return a panel of lines of one unit; a single one is named by the axis."""
    return Panel(f"{label} of {lines[0][0]}" if len(lines) == 1 else label, unit, lines)


def effort_panels(solution: RunResult, quantity: str, parts: tuple[Part, ...]) -> list[Panel]:
    """Return panels of drive torques and forces; none given = all."""
    drivers = [solution.system.part(part, "joints") for part in parts]
    drivers = drivers or list(dict.fromkeys(driver for driver, _ in solution.compiled.drives))
    if not drivers:
        raise InputError("this system has no driver, so there is no effort; give another quantity")
    return panels_by_unit("effort", [column for driver in drivers for column in columns_of_effort(solution, driver)])


def state_panels(solution: RunResult, quantity: str, parts: tuple[Part, ...]) -> list[Panel]:
    """Return panels of internal states of forces; none given = all."""
    forces = [solution.system.part(part, "forces") for part in parts] or solution.system.forces
    found = [column for force in forces for column in columns_of_states(solution, force)]
    if not found:
        raise InputError("these forces have no internal states; give another quantity")
    return panels_by_unit("state", found)


def panels_by_unit(label: str, found: Sequence[Column]) -> list[Panel]:
    """Return one panel per unit."""
    groups: dict[str, list[Line]] = {}
    for column in found:
        groups.setdefault(column.unit, []).append((column.part, column.values))
    return [scalar_panel(label, f"[{unit}]", lines) for unit, lines in groups.items()]


def reaction_panels(solution: RunResult, quantity: str, parts: tuple[Part, ...]) -> list[Panel]:
    """Return panels of force and moment: components of one joint, magnitudes of several; none given = all."""
    system = solution.system
    joints = [system.part(part, "joints") for part in parts] or system.joints
    if not joints:
        raise InputError("this system has no joint, so there is no reaction; give another quantity")
    found = {system.name(joint): solution.reaction(joint) for joint in joints}
    make = reaction_components if len(joints) == 1 else reaction_sizes
    return [panel for kind in ("force", "moment") for panel in make(found, kind, unit_of(f"reaction_{kind}"))]


def reaction_components(found: dict[str, Reaction], kind: str, unit: str) -> list[Panel]:
    """Return the components of the force or moment of one joint; components that are not unique are marked.

    Where open and determined directions are mixed in them, the components of the determined part.
    """
    ((name, reaction),) = found.items()
    values, known = reaction.shown(kind)
    mask, D = getattr(reaction, f"unique_{kind}"), getattr(reaction, f"{kind}_projector")
    mixed = known == "part" and np.trace(D, axis1=1, axis2=2).max() > mask.sum() + 0.5  # more directions than axes
    if known == "part" and not mixed:
        values = getattr(reaction, kind)
    axes = AXIS_NAMES if mixed else [x if own else f"{x}, not unique" for x, own in zip(AXIS_NAMES, mask, strict=True)]
    note = "the determined part" if mixed else ""
    return [p._replace(note=note) for p in vector_panels(f"reaction {kind}", unit, axes, {name: values})]


def reaction_sizes(found: dict[str, Reaction], kind: str, unit: str) -> list[Panel]:
    """Return the magnitudes of the determined forces or moments of several joints."""
    shown = {name: reaction.shown(kind) for name, reaction in found.items()}
    notes = []
    for text, wanted in (("determined part", "part"), ("not unique", "none")):
        names = ", ".join(name for name, (_, known) in shown.items() if known == wanted)
        notes += textwrap.wrap(f"{text}: {names}", 26) if names else []
    sizes = [(name, np.linalg.norm(values, axis=1)) for name, (values, _) in shown.items()]
    return [Panel(f"|reaction {kind}|", unit, sizes, "\n".join(notes))]


def force_panels(solution: RunResult, quantity: str, parts: tuple[Part, ...]) -> list[Panel]:
    """Return panels of force and moment of force elements: components of one, magnitudes of several; none given =
    all."""
    found = {name: load for force in forces_of(solution, parts) for name, load in loads_of(solution, force).items()}
    panels = []
    for kind in ("force", "moment"):
        values, unit = {name: getattr(x, kind) for name, x in found.items()}, "[N]" if kind == "force" else "[N m]"
        values = {name: x for name, x in values.items() if acts(found[name], kind)}
        if len(found) == 1:
            panels += vector_panels(kind, unit, AXIS_NAMES, values) if values else []
        elif values:
            panels.append(Panel(f"|{kind}|", unit, [(name, np.linalg.norm(x, axis=1)) for name, x in values.items()]))
    return panels or [Panel("force", "[N]", [(name, np.linalg.norm(x.force, axis=1)) for name, x in found.items()])]


def acts(load: Load, kind: str) -> bool:
    """Return whether an element has a force, or a moment, besides the rounding of moving the other to its point."""
    if kind == "force":
        return bool(load.force.any())
    reach = np.abs(load.point).max(initial=0.0) + 1.0
    return np.abs(load.moment).max(initial=0.0) > 1e-12 * reach * np.abs(load.force).max(initial=0.0)


def forces_of(solution: RunResult, parts: tuple[Part, ...]) -> Sequence[ForceElement]:
    """Return the given force elements; none given = all whose load is known."""
    forces = [solution.system.part(part, "forces") for part in parts]
    forces = forces or [force for force in solution.system.forces if not isinstance(force, SavedForce)]
    if not forces:
        raise InputError("this system has no force whose load is known; give another quantity")
    return forces


def power_panels(solution: RunResult, quantity: str, parts: tuple[Part, ...]) -> list[Panel]:
    """Return the panel of the power of force elements on all their bodies; none given = all."""
    lines = [(solution.system.name(x), load_of(solution, x).power) for x in forces_of(solution, parts)]
    return [scalar_panel("power", "[W]", lines)]


def length_panels(solution: RunResult, quantity: str, parts: tuple[Part, ...]) -> list[Panel]:
    """Return panels of lengths of springs, and displacements along which forces act; none given = all that have one."""
    loads = [(solution.system.name(x), load_of(solution, x).length) for x in forces_of(solution, parts)]
    lines = [(name, length) for name, length in loads if length is not None]
    if not lines:
        raise InputError("these forces have no length; give another quantity")
    return [scalar_panel("length", "[m]", lines)]


def energy_panels(solution: RunResult, quantity: str, parts: tuple[Part, ...]) -> list[Panel]:
    """Return the panel of kinetic, potential and total energy, and work.

    Changes since the start where one would not see them beside what stays, as beside the energy of a fast rotor.
    """
    lines = solution.energy().shown()
    largest = max(float(np.abs(values).max()) for values in lines.values())
    change = max(float(np.ptp(values)) for values in lines.values())
    if CHANGE_SHARE_MIN * largest < change < CHANGE_SHARE_MAX * largest:
        return [Panel("change of energy", "[J]", [(name, values - values[0]) for name, values in lines.items()])]
    return [Panel("energy", "[J]", list(lines.items()))]


def engaged_parts(solution: RunResult) -> dict[str, tuple[Joint | ForceElement, np.ndarray]]:
    """Return of the parts that switch at events, by name, (the part, 1 while its rows hold, else 0 (samples,))."""
    pieces = solution.pieces or (solution,)
    counts = [piece.t.size for piece in pieces]
    counts[0] += solution.t.size - sum(counts)  # the start, where it is put before the samples
    found: dict[str, tuple[Joint | ForceElement, np.ndarray]] = {}
    for part in (part for part in holders_of(solution.system) if is_switching(part)):
        rows = [piece.compiled.rows[id(part)] for piece in pieces]
        found[solution.system.name(part)] = part, np.repeat([float(x.stop > x.start) for x in rows], counts)
    return found


def engaged_panels(solution: RunResult, quantity: str, parts: tuple[Part, ...]) -> list[Panel]:
    """Return the panel of what parts that switch at events do: 1 while their rows hold, else 0; none given = all."""
    known = engaged_parts(solution)
    asked = [part if isinstance(part, str) else solution.system.name(part) for part in parts] or list(known)
    if not asked or not known.keys() >= set(asked):
        have = ", ".join(f"'{name}'" for name in known) or "none"
        raise InputError(f"engaged: give parts that switch at events; in this system there are {have}")
    panel = scalar_panel("engaged", "[-]", [(name, known[name][1]) for name in asked])
    return [panel._replace(shows=(0.0, 1.0))]


def momentum_panels(solution: RunResult, quantity: str, parts: tuple[Part, ...]) -> list[Panel]:
    """Return panels of momentum, and angular momentum about the world origin."""
    panels = []
    for kind, values in vars(solution.momentum()).items():
        panels += vector_panels(f"{kind} momentum", unit_of(f"{kind}_momentum"), AXIS_NAMES, {"": values})
    return panels


def drift_panels(solution: RunResult, quantity: str, parts: tuple[Part, ...]) -> list[Panel]:
    """Return the panels of constraint residuals."""
    return [
        Panel(f"{kind} drift", unit_of(f"{kind}_drift"), [("largest", values)], log=True)
        for kind, values in vars(solution.drift()).items()
    ]


PANELS: dict[str, Callable[[RunResult, str, tuple[Part, ...]], list[Panel]]] = {
    "energy": energy_panels,
    **dict.fromkeys(BODY_QUANTITIES, body_panels),
    **dict.fromkeys(("angle", "slide", "rate"), joint_panels),
    "reaction": reaction_panels,
    "effort": effort_panels,
    "force": force_panels,
    "power": power_panels,
    "length": length_panels,
    "state": state_panels,
    "engaged": engaged_panels,
    "momentum": momentum_panels,
    "drift": drift_panels,
}
SYSTEM_QUANTITIES = ("energy", "momentum", "drift")


def measure_panels(solution: RunResult, measures: Sequence[Measure]) -> list[Panel]:
    """Return panels of measures over time: those of one unit share a panel."""
    groups: dict[str, list[Line]] = {}
    for measure, values in zip(measures, solution.measure(measures).T, strict=True):
        groups.setdefault(with_superscripts(measure.unit), []).append((measure.label, values))
    return [Panel(lines[0][0] if len(lines) == 1 else "measures", f"[{unit}]", lines) for unit, lines in groups.items()]


def panels_of(solution: RunResult, quantity: str | Measure | Wanted, parts: tuple[Part, ...] = ()) -> list[Panel]:
    """Return panels of a quantity of some parts (none = all that have it), or of several quantities; see
    `plot_quantity`.
    """
    if isinstance(quantity, Measure):
        return sized(solution, measure_panels(solution, measures_only((quantity, *parts))))
    if not isinstance(quantity, str):
        wanted: Wanted = [quantity] if is_one_with_parts(quantity) else quantity
        return panels_of_several(solution, wanted, parts)
    if quantity not in PANELS:
        raise InputError(f"quantity {short_repr(quantity)} is unknown; give one of {', '.join(PANELS)}")
    if others := [part for part in parts if isinstance(part, str) and part in PANELS]:
        raise InputError(f"'{others[0]}' is a quantity, not a part; several are a list: {[quantity, *others]}")
    if parts and quantity in SYSTEM_QUANTITIES:
        raise InputError(f"{quantity} belongs to the whole system; give no parts")
    return sized(solution, PANELS[quantity](solution, quantity, parts))


def sized(solution: RunResult, panels: list[Panel]) -> list[Panel]:
    """Return panels with the natural size of their quantity."""
    sizes = natural_sizes(solution)
    return [panel._replace(size=sizes.get(panel.unit, 0.0)) for panel in panels]


def is_one_with_parts(wanted: Any) -> TypeGuard[tuple[str | Part, ...]]:
    """Return whether a tuple is one quantity with its parts, as ("reaction", hinge), and no list of quantities."""
    return (
        isinstance(wanted, tuple)
        and len(wanted) > 1
        and isinstance(wanted[0], str)
        and all(isinstance(part, Part) and part not in PANELS for part in wanted[1:])
    )


def measures_only(entries: tuple[Any, ...]) -> tuple[Measure, ...]:
    """Return measures that share axes; raise an error for anything else among them."""
    for entry in entries:
        if not isinstance(entry, Measure):
            raise InputError(f"{short_repr(entry)} is not a measure, as others in the list are; give measures alone")
    return entries


def panels_of_several(solution: RunResult, wanted: Wanted, parts: tuple[Part, ...]) -> list[Panel]:
    """Return panels of a list of quantities, each with or without parts."""
    example = "e.g. ['energy', ('angle', 'hinge'), measures.distance(a, b)]"
    if parts:
        raise InputError(f"curves: with several quantities each has its own parts; give {example}")
    try:
        entries: list[tuple[Any, ...]] = [
            (entry,) if isinstance(entry, str | Measure) else tuple(entry) for entry in wanted
        ]
    except TypeError:
        entries = []
    if not entries or not all(entry and isinstance(entry[0], str | Measure) for entry in entries):
        raise InputError(
            f"{short_repr(wanted)} is not a quantity; give a name, or a list of names and tuples, {example}"
        )
    return [panel for name, *own in entries for panel in panels_of(solution, name, tuple(own))]


MARKERS = "osD^v<>pP*X"


def plot_eigenvalues(linearization: ModalAnalysis) -> Figure:
    """Plot eigenvalues in the complex plane, one mark per mode and one for all zeros; the growing half is tinted."""
    look = LIGHT
    with figure_style(look):
        figure = Figure(figsize=(7.5, 4.6), layout="constrained")
        axes, values = figure.subplots(), linearization.eigenvalues
        marks = [(mode.label, mode.eigenvalue) for mode in linearization.modes if mode.eigenvalue]
        zeros = int((values == 0.0).sum())
        for k, (label, s) in enumerate([*marks, *([(f"{zeros} zero" + "s" * (zeros > 1), 0j)] if zeros else [])]):
            points = np.array([s, s.conjugate()] if s.imag else [s])
            style: dict[str, Any] = {
                "color": look.colour(k) if s else look.ink,
                "marker": MARKERS[k % len(MARKERS)] if s else "x",
            }
            axes.plot(points.real, points.imag, linestyle="none", markerfacecolor="none", label=label, **style)
        axes.axhline(0.0, color=look.muted, linewidth=0.8)
        axes.axvline(0.0, color=look.muted, linewidth=0.8)
        size = float(np.abs(values).max(initial=0.0)) or 1.0
        low, high = min(values.real.min(), 0.0) - 0.1 * size, max(values.real.max(), 0.0) + 0.1 * size
        axes.set_xlim(low, high)
        axes.axvspan(0.0, high, color=look.lines[1], alpha=0.06, linewidth=0.0)
        axes.set_ylim(*np.array([-1.1, 1.1]) * max(np.abs(values.imag).max(), 0.1 * size))
        style_axes(axes, look)
        axes.set_xlabel("real part (growth) [1/s]")
        axes.set_ylabel("imaginary part [rad/s]")
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False, fontsize=9, labelcolor=look.ink)
    return figure
