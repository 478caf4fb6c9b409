"""Figures and pictures of a report, embedded in its page."""

import base64
import io
import re
import textwrap

import numpy as np
from markupsafe import Markup
from matplotlib.figure import Figure

from ..base.checks import as_tuple
from ..base.errors import InputError
from ..base.style import LIGHT, figure_style
from ..mechanism.drivers import Driver
from ..mechanism.joints import Joint
from ..plotting.panels import PlotQuantity, Wanted
from ..plotting.plots import plot_quantity
from ..results.result import RunResult
from ..view.picture.picture import picture_of_solution, picture_of_system
from .facts import loaded_joints

CHOSEN_LINES_MAX = 6  # [1] lines of a figure that is chosen here
PICTURE_BODIES_MAX = 200  # [1] bodies of a picture
LABEL_CHARACTERS_MAX = 18  # [1] characters of a label beside an axis of this height
PICTURE_SIZE = (7.2, 3.8)  # [inch] width and height of a picture


def wanted_curves(
    solution: RunResult, few: RunResult, curves: Wanted | None
) -> list[tuple[RunResult, PlotQuantity, str]]:
    """Return (what to plot, entry for `plot`, caption) of every figure; ``few`` has the samples with reactions."""
    if curves is not None:
        if isinstance(curves, str):
            raise InputError(f"report: curves '{curves:.80}' is a single text; give a list, e.g. ['energy']")
        return [(solution, entry, "") for entry in as_tuple(curves, "report: curves", "a list, e.g. ['energy']")]
    if solution.t.size == 1:
        return []
    energies = "Energies, and the work of drivers and of forces that store none."
    system = solution.system
    found: list[tuple[RunResult, PlotQuantity, str]] = [(solution, "energy", energies)]
    for kind, name in (("angle", "Angles"), ("slide", "Displacements")):
        joints = [joint for joint in system.joints if getattr(joint, kind)() is not None]
        moved = {id(joint): float(np.ptp(getattr(solution, kind)(joint))) for joint in joints}
        chosen = most(joints, moved)
        if chosen:
            cut = f" that change most, {len(chosen)} of {len(joints)}" if len(joints) > len(chosen) else ""
            found.append((solution, (kind, *chosen), f"{name} of the joints{cut}."))
    joints, count = loaded_joints(solution)[0], sum(not isinstance(joint, Driver) for joint in system.joints)
    loads = {id(joint): float(np.linalg.norm(few.reaction(joint).force, axis=1).max()) for joint in joints}
    chosen = most(joints, loads)
    if chosen:
        cut = f" with the largest forces, {len(chosen)} of {count}" if count > len(chosen) else ""
        found.append((few, ("reaction", *chosen), f"Reactions of the joints{cut}."))
    if solution.compiled.drives:
        found.append((few, "effort", "Efforts of the drivers."))
    if not joints:
        shown = system.bodies[:CHOSEN_LINES_MAX]
        found.append((solution, ("omega_body", *shown), "Angular velocity in body axes."))
        found.append((solution, ("com", *shown), "Centre of mass."))
    return found


def most(joints: list[Joint], sizes: dict[int, float]) -> list[Joint]:
    """Return the joints with the largest sizes, in the order of the model."""
    kept = sorted(joints, key=lambda joint: -sizes[id(joint)])[:CHOSEN_LINES_MAX]
    return [joint for joint in joints if joint in kept]


def figure_of(number: int, solution: RunResult, entry: PlotQuantity, caption: str) -> dict[str, str]:
    """Return a figure as inline SVG, with a caption and an alternative text."""
    figure = plot_quantity(solution, [entry])
    figure.set_size_inches(7.5, 0.7 + 1.55 * len(figure.axes))  # four panels go on an A4 page
    for axes in figure.axes:
        axes.yaxis.label.set_text("\n".join(textwrap.wrap(axes.get_ylabel(), LABEL_CHARACTERS_MAX)))
    labels = ", ".join(axes.get_ylabel().replace("\n", " ") for axes in figure.axes)
    return {"svg": Markup(inline_svg(figure, f"f{number}-")), "caption": caption, "label": f"{labels} over time"}


def inline_svg(figure: Figure, prefix: str) -> str:
    """Return a figure as an SVG element for a page, with unique ids and the page's colour variables (see
    report.html)."""
    buffer = io.StringIO()
    with figure_style():
        figure.savefig(buffer, format="svg", metadata=dict.fromkeys(("Creator", "Date", "Format", "Type")))
    text = buffer.getvalue()
    text = re.sub(r"<!--.*?-->|<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.S)
    text = re.sub(r' (width|height)="[\d.]+pt"', "", text, count=2)
    text = re.sub(r'\b(id="|href="#|url\(#)', rf"\g<1>{prefix}", text)
    # a hundredth of a point is enough for the eye
    text = re.sub(r'\bd="[^"]*"', lambda d: re.sub(r"(\.\d\d)\d+", r"\1", d.group()), text)
    names = {getattr(LIGHT, name): name for name in ("paper", "ink", "muted", "grid", "good", "bad")}
    names |= {tint: f"line{k}" for k, tint in enumerate(LIGHT.lines)}
    for tint, name in names.items():
        text = re.sub(tint, f"var(--{name})", text, flags=re.I)
    return re.sub(r"\n\s*", "\n", text)


def picture_of(solution: RunResult, dark: bool | None) -> list[dict[str, str]]:
    """Return the mechanism at the last sample as images for light and dark paper; none for too many bodies to
    distinguish.
    """
    if len(solution.system.bodies) > PICTURE_BODIES_MAX:
        return []
    images = []
    for sheet in (False, True) if dark is None else (bool(dark),):
        if solution.t.size > 1:
            figure = picture_of_solution(solution, float(solution.t[-1]), size=PICTURE_SIZE, dark=sheet)
        else:
            figure = picture_of_system(solution.system, solution.state(0), size=PICTURE_SIZE, dark=sheet)
        buffer = io.BytesIO()
        with figure_style():
            figure.savefig(buffer, format="webp", dpi=150, pil_kwargs={"quality": 80})
        source = f"data:image/webp;base64,{base64.b64encode(buffer.getvalue()).decode()}"
        images.append({"paper": "dark" if sheet else "light", "source": source})
    return images
