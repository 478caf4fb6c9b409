"""Figures of a solution over time and of a system in space. Nothing shows by itself: every function returns a Figure.

Colours are those of Okabe and Ito, lines differ in their dashes too once the colours are used up.
"""

import io
import textwrap
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib
import numpy as np
from cycler import cycler
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from matplotlib.ticker import NullFormatter
from mpl_toolkits.mplot3d.proj3d import proj_transform

from .animation import COLOURS, GREY, Scene, bounds, colour, draw, prepare
from .files import write_atomically
from .state import State
from .tables import BODY_QUANTITIES, QUANTITIES, Column, columns_of_effort, columns_of_states

CYCLE = cycler(linestyle=["-", "--", ":", "-."]) * cycler(color=COLOURS)
FEW = 40  # samples that are marked one by one: straight lines between few of them could mislead
DECADE = -18  # smallest residual shown; what is below is chance
WORDS = {
    "omega": "angular velocity", "omega_body": "angular velocity, body axes", "alpha": "angular acceleration",
    "com": "centre of mass", "orientation": "quaternion",
}  # fmt: skip
AXIS_NAMES, QUATERNION_NAMES = ("x", "y", "z"), ("e0", "e1", "e2", "e3")


class Panel(NamedTuple):
    """One pair of axes: label, unit in brackets, named lines (samples,), a note above the legend."""

    label: str
    unit: str
    lines: list[tuple[str, np.ndarray]]
    note: str = ""
    log: bool = False


def unit_of(quantity: str) -> str:
    """Unit as it is printed on an axis."""
    unit = QUANTITIES[quantity].unit
    return "[-]" if unit == "1" else f"[{unit.replace('^2', '²')}]"


def vector_panels(label: str, unit: str, names: Sequence[str], parts: dict[str, np.ndarray]) -> list[Panel]:
    """One part: its components in one panel. Several: a panel per component."""
    if len(parts) == 1:
        part, values = next(iter(parts.items()))
        owner = f" of {part}" if part else ""
        return [Panel(label + owner, unit, list(zip(names, values.T, strict=True)))]
    return [
        Panel(f"{label} {name}", unit, [(part, values[:, k]) for part, values in parts.items()])
        for k, name in enumerate(names)
    ]


def body_panels(solution: Any, quantity: str, parts: tuple) -> list[Panel]:
    """A quantity of bodies; none given = all."""
    bodies = [solution.system.part(part) for part in parts] or solution.system.bodies
    names = QUATERNION_NAMES if quantity == "orientation" else AXIS_NAMES
    found = {body.name: getattr(solution, quantity)(body) for body in bodies}
    return vector_panels(WORDS.get(quantity, quantity), unit_of(quantity), names, found)


def joint_panels(solution: Any, quantity: str, parts: tuple) -> list[Panel]:
    """Angle, slide or rate of joints; none given = all that have one."""
    system = solution.system
    joints = [system.part(part, "joints") for part in parts]
    if not joints:
        kinds = {"rate": ("angle", "slide")}.get(quantity, (quantity,))
        joints = [joint for joint in system.joints if any(getattr(joint, kind)() is not None for kind in kinds)]
    groups: dict[str, list] = {}
    for joint in joints:
        name = "slide_rate" if quantity == "rate" and joint.angle() is None else quantity
        groups.setdefault(name, []).append((system.name(joint), getattr(solution, quantity)(joint)))
    if not groups:
        raise ValueError(f"plot: no joint of this system has the quantity {quantity}; give another quantity")
    return [scalar_panel(name.replace("_", " "), unit_of(name), lines) for name, lines in groups.items()]


def scalar_panel(label: str, unit: str, lines: list[tuple[str, np.ndarray]]) -> Panel:
    """Lines of one unit; a single one is named by the axis."""
    return Panel(f"{label} of {lines[0][0]}" if len(lines) == 1 else label, unit, lines)


def effort_panels(solution: Any, quantity: str, parts: tuple) -> list[Panel]:
    """Torques and forces of drivers; none given = all."""
    drivers = [solution.system.part(part, "joints") for part in parts]
    drivers = drivers or list(dict.fromkeys(driver for driver, _ in solution.compiled.drives))
    if not drivers:
        raise ValueError("plot: this system has no driver, so there is no effort; give another quantity")
    return panels_by_unit("effort", [column for driver in drivers for column in columns_of_effort(solution, driver)])


def state_panels(solution: Any, quantity: str, parts: tuple) -> list[Panel]:
    """Own states of forces; none given = all."""
    forces = [solution.system.part(part, "forces") for part in parts] or solution.system.forces
    found = [column for force in forces for column in columns_of_states(solution, force)]
    if not found:
        raise ValueError("plot: these forces have no own states; give another quantity")
    return panels_by_unit("state", found)


def panels_by_unit(label: str, found: Sequence[Column]) -> list[Panel]:
    """One panel per unit."""
    groups: dict[str, list] = {}
    for column in found:
        groups.setdefault(column.unit, []).append((column.part, column.values))
    return [scalar_panel(label, f"[{unit}]", lines) for unit, lines in groups.items()]


def reaction_panels(solution: Any, quantity: str, parts: tuple) -> list[Panel]:
    """Force and moment: components of one joint, magnitudes of several; none given = all."""
    system = solution.system
    joints = [system.part(part, "joints") for part in parts] or system.joints
    if not joints:
        raise ValueError("plot: this system has no joint, so there is no reaction; give another quantity")
    found = {system.name(joint): solution.reaction(joint) for joint in joints}
    shared = ", ".join(name for name, reaction in found.items() if not reaction.unique)
    note = "\n".join(textwrap.wrap(f"not unique: {shared}", 26)) if shared else ""
    panels = []
    for kind in ("force", "moment"):
        unit, values = unit_of(f"reaction_{kind}"), {name: getattr(x, kind) for name, x in found.items()}
        if len(joints) == 1:
            panels += [p._replace(note=note) for p in vector_panels(f"reaction {kind}", unit, AXIS_NAMES, values)]
        else:
            sizes = [(name, np.linalg.norm(x, axis=1)) for name, x in values.items()]
            panels.append(Panel(f"|reaction {kind}|", unit, sizes, note))
    return panels


def energy_panels(solution: Any, quantity: str, parts: tuple) -> list[Panel]:
    """Kinetic, potential and total energy, and work."""
    return [Panel("energy", "[J]", list(vars(solution.energy()).items()))]


def momentum_panels(solution: Any, quantity: str, parts: tuple) -> list[Panel]:
    """Momentum, and angular momentum about the world origin."""
    panels = []
    for kind, values in vars(solution.momentum()).items():
        panels += vector_panels(f"{kind} momentum", unit_of(f"{kind}_momentum"), AXIS_NAMES, {"": values})
    return panels


def drift_panels(solution: Any, quantity: str, parts: tuple) -> list[Panel]:
    """Constraint residuals."""
    return [
        Panel(f"{kind} drift", unit_of(f"{kind}_drift"), [("largest", values)], log=True)
        for kind, values in vars(solution.drift()).items()
    ]


PANELS: dict[str, Callable[[Any, str, tuple], list[Panel]]] = {
    "energy": energy_panels,
    **dict.fromkeys(BODY_QUANTITIES, body_panels),
    **dict.fromkeys(("angle", "slide", "rate"), joint_panels),
    "reaction": reaction_panels,
    "effort": effort_panels,
    "state": state_panels,
    "momentum": momentum_panels,
    "drift": drift_panels,
}
OF_THE_SYSTEM = ("energy", "momentum", "drift")


def plot_quantity(solution: Any, quantity: str, *parts: Any, axes: Any = None) -> Figure:
    """A quantity over time.

    Parameters
    ----------
    solution : Solution
        What to plot.
    quantity : str
        "energy", "momentum", "drift"; of bodies "position", "orientation", "velocity", "omega", "omega_body",
        "acceleration", "alpha", "com"; of joints "angle", "slide", "rate", "reaction"; of drivers "effort"; of forces
        "state" (own states).
    *parts : Body, Joint, ForceElement or str
        Whose; none = all that have it. Components of one part share a panel; several parts are compared component by
        component (reactions: by magnitude).
    axes : matplotlib Axes, sequence of them, or None
        Where to draw, one per panel; None = a new figure.

    Returns
    -------
    matplotlib.figure.Figure
        Not shown; a notebook shows it when it is the last value of a cell, `save_figure` writes it.

    Raises
    ------
    ValueError
        For an unknown quantity or part, a part without the quantity, or a wrong number of axes.
    """
    if quantity not in PANELS:
        raise ValueError(f"plot: quantity {quantity!r} is unknown; give one of {', '.join(PANELS)}")
    if parts and quantity in OF_THE_SYSTEM:
        raise ValueError(f"plot: {quantity} is that of the whole system; give no parts")
    panels = PANELS[quantity](solution, quantity, parts)
    if axes is None:
        figure = Figure(figsize=(7.5, 1.0 + 2.3 * len(panels)), layout="constrained")
        figure.get_layout_engine().set(w_pad=0.1, h_pad=0.06)
        targets = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    else:
        targets = np.ravel(np.asarray(axes, dtype=object))
    if len(targets) != len(panels):
        raise ValueError(f"plot: {quantity} of these parts needs {len(panels)} axes, not {len(targets)}; give as many")
    before: list[str] = []
    for target, panel in zip(targets, panels, strict=True):
        names = [name for name, _ in panel.lines]
        draw_panel(target, solution.t, panel, legend=names != before)
        alike = [values for other in panels if other.unit == panel.unit for _, values in other.lines]
        set_range(target, panel, float(np.nanmax(np.abs(alike), initial=0.0)))
        before = names
    if axes is not None:
        for target in targets[:-1]:
            target.set_xlabel("time [s]")
    targets[-1].set_xlabel("time [s]")
    return targets[0].figure


def draw_panel(axes: Any, t: np.ndarray, panel: Panel, legend: bool) -> None:
    """Lines, grid, label and legend of a panel; the legend stands beside the data, never on it."""
    axes.set_prop_cycle(CYCLE)
    for name, values in panel.lines:
        shown = np.where(values > 0.0, values, np.nan) if panel.log else values
        axes.plot(t, shown, label=name, linewidth=1.5, marker="o" if t.size <= FEW else None, markersize=3)
    axes.grid(True, color="#d9d9d9", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    if t.size > 1:
        margin = 0.01 * (t[-1] - t[0])
        axes.set_xlim(t[0] - margin, t[-1] + margin)
    axes.set_ylabel("\n".join(textwrap.wrap(f"{panel.label} {panel.unit}", 30)))
    if legend and (len(panel.lines) > 1 or panel.note):
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False, title=panel.note or None)


def set_range(axes: Any, panel: Panel, size: float) -> None:
    """Whole decades on a logarithmic axis; rounding is not blown up: ``size`` is the largest value of this unit."""
    values = np.concatenate([values for _, values in panel.lines])
    values = values[np.isfinite(values) & (values > 0.0 if panel.log else True)]
    if not values.size:
        return
    low, high = float(values.min()), float(values.max())
    if panel.log:
        last = np.ceil(np.log10(high))
        axes.set_yscale("log")
        axes.set_ylim(10.0 ** min(max(np.floor(np.log10(low)), DECADE), last - 1.0), 10.0**last)
        axes.yaxis.set_minor_formatter(NullFormatter())
    elif high - low < 1e-9 * size:
        axes.set_ylim(low - 0.05 * size, high + 0.05 * size)


def show_system(system: Any, state: State | None = None) -> Figure:
    """The mechanism in space: bodies, centres of mass (o), reference points (+), joints and their axes, names.

    Bodies are drawn as the solids that have their mass and inertia, all directions and sizes true to scale.

    Parameters
    ----------
    system : System
        What to draw.
    state : State or None
        Pose; None = the reference pose.

    Returns
    -------
    matplotlib.figure.Figure
        Not shown; see `plot_quantity`.

    Raises
    ------
    ValueError
        If the state is one of another system, or a shape is unknown.
    """
    scene = Scene(system)
    pose = scene.pose(state)
    low, high = bounds([scene.lines(pose, 0.0)])
    size = float((high - low).max())
    lines = scene.lines(pose, 0.15 * size)
    figure = Figure(figsize=(8, 6.4))
    axes = figure.add_axes((0.02, 0.02, 0.92, 0.96), projection="3d")
    prepare(axes, low, high)
    draw(axes, scene, lines)
    labels = [(body.name, lines[4 * i + 2][0], colour(i)) for i, body in enumerate(system.bodies)]
    labels += [(system.name(mark.joint), point, "black") for mark, point in zip(scene.joints, lines[-2], strict=True)]
    write_labels(axes, labels)
    style = {"color": GREY, "linestyle": "none", "markerfacecolor": "none"}
    marks = (("o", "centre of mass"), ("+", "reference point"), ("D", "joint"))
    handles = [Line2D([], [], marker=marker, label=text, **style) for marker, text in marks]
    figure.legend(handles=handles, loc="lower left", frameon=False, fontsize=9, ncols=3)
    return figure


def write_labels(axes: Any, labels: list[tuple[str, np.ndarray, str]]) -> None:
    """Names right of their points, moved by whole lines up or down where they would overlap."""
    width, height, taken = 6.2, 13.0, []  # [pixel] of a letter and a line at 9 points and 100 dpi
    axes.apply_aspect()
    view = axes.get_proj()
    for name, point, tint in labels:
        x, y = axes.transData.transform(proj_transform(*point, view)[:2])
        for shift in sorted(range(-6, 7), key=lambda k: (abs(k), k)):
            place = (x, x + width * (len(name) + 2), y - height * shift)
            if not any(place[0] < b and a < place[1] and abs(place[2] - c) < height for a, b, c in taken):
                break
        taken.append(place)
        text = "\n" * (2 * max(shift, 0)) + f"   {name}" + "\n" * (2 * max(-shift, 0))
        halo = [withStroke(linewidth=2.5, foreground="white")]
        axes.text(*point, text, color=tint, fontsize=9, va="center", linespacing=1.0, path_effects=halo)


def save_figure(figure: Figure, path: str | Path) -> list[Path]:
    """Write a figure as PNG (150 dpi) and SVG; the same figure gives the same bytes.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        What to write.
    path : str or Path
        Without suffix.

    Returns
    -------
    list of Path
        The two files.

    Raises
    ------
    ValueError
        If the folder cannot be written.
    """
    path, written = Path(path), []
    options = {".png": {"dpi": 150, "metadata": {"Software": None}}, ".svg": {"metadata": {"Date": None}}}
    with matplotlib.rc_context({"svg.hashsalt": "mbsd3d"}):
        for suffix, settings in options.items():
            buffer = io.BytesIO()
            figure.savefig(buffer, format=suffix[1:], facecolor="white", **settings)
            written.append(write_atomically(path.with_name(path.name + suffix), buffer.getvalue()))
    return written
