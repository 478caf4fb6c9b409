"""Gallery: a front page by family and a page per demo, with players that share one copy of the viewer."""

import ast
import inspect
import io
import json
import re
import shlex
import sys
from collections.abc import Iterable, Mapping, Sequence
from functools import cache, partial
from hashlib import sha256
from importlib.util import resolve_name
from itertools import starmap
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from PIL import Image

from ..api.system import System
from ..api.viewable import AnimateOptions
from ..base.paths import write_atomically
from ..base.style import DARK, LIGHT, figure_style
from ..base.templates import TEMPLATE_FOLDER, page_template
from ..base.wording import COMPARED_DIGITS, digits, readable, relative, with_superscripts
from ..mechanism.state import State
from ..report.exhibits import inline_svg
from ..report.mathml import mathml
from ..view.explore.exploration import Exploration, Ghost, Theory
from ..view.explore.sliders import Slider
from ..view.page.recorder import client_head
from .base import Outcome, Row, Show
from .discovery import discover
from .figure import TIME_AXIS, Curve, figure_of
from .form import Control, Demo
from .parameters import OMITTABLE_TERMS, Values, lacking
from .report import to_json

VIEWER_FILE = "viewer.js"
PAGE_FILE_ENDINGS = (".html", "_seen.html", "_without.html", ".png", ".gif")  # of the names of a page's files
PICTURE_WIDTH = 320  # [pixels] of a picture on the front page
FILM_RATE, FILM_SECONDS, FILM_WIDTH = 8, 3.0, 480  # of the films there; in narrower ones the notes lie on each other
NOTES_MAX = 4  # [1] notes below a table; more can be unfolded
TYPOGRAPHY = (
    (r"\b(\w) x (?=\w\b|\()", "\\1 × "),  # between single letters: not the axis x of a sentence
    (" - ", " − "),
    (" -> ", " → "),
    (r"sqrt\(", "√("),
    ("_dot", "\u0307"),  # the dot above the letter before
    ("`", ""),
)
PACKAGE_FOLDER = Path(__file__).parent.parent
SOURCE_SUFFIXES = {".py", ".js", ".css", ".html"}
INVISIBLE_MOTION = 1e-6  # [m] or parts of a quaternion that nobody sees


def page(name: str, folder: Path) -> bool:
    """Write the page of one demo with its players, picture and numbers; False if it is there, and nothing has changed.

    The numbers come last, with a digest of every other file: what an interruption leaves is not a page.
    """
    demos = discover()
    demo, known = demos.find(name), list(demos.values())
    next_one = known[(known.index(demo) + 1) % len(known)]
    stamp, place = digest(demo, next_one), folder / f"{name}.json"
    if whole(folder, place, stamp):
        return False
    outcome = demo.run()
    solves = exploration(demo, outcome)
    players = [("the effect", player(outcome, "the effect", folder / f"{name}_seen.html", explore=solves))]
    taken = without(demo)
    if taken is not None and not (solves and solves.ghost):
        term, ablated = taken
        file = folder / f"{name}_without.html"
        players.append((lacking(term), player(ablated, lacking(term), file, beside=outcome)))
    else:
        (folder / f"{name}_without.html").unlink(missing_ok=True)
    texts = {label: prose(getattr(demo, label)) for label in ("question", "why", "source")}
    notes = [prose(note) for note in outcome.notes]
    html = page_template("demo.html").render(
        title=demo.title, name=name, family=demo.family, texts=texts, equation=mathml(demo.equation, demo.symbols),
        rows=[cells(row) for row in outcome.rows], figures=drawn(outcome, name),
        players=[found for found in players if found[1]], notes=notes, few=NOTES_MAX,
        parameters={key: json.dumps(value) for key, value in outcome.parameters.items()}, command=command(demo),
        code=source_of(demo), next_one=next_one, light=LIGHT, dark=DARK, solves=solves is not None,
        attempt=prose(demo.attempt), story=demo.story(first_view(outcome).solution) if outcome.views else (),
        symbols=[symbol_of(x) for x in demo.meanings(outcome.parameters)],
    )  # fmt: skip
    write_atomically(folder / f"{name}.html", html.encode("utf-8"))
    picture(outcome, folder / f"{name}.png")
    film(outcome, folder / f"{name}.gif")
    files = {path.name: sha256(path.read_bytes()).hexdigest() for path in files_of(name, folder)}
    found = {**json.loads(to_json(demo, outcome)), "digest": stamp, "files": files, "passed": outcome.passed}
    write_atomically(place, json.dumps(found, indent=1).encode("utf-8"))
    return True


def files_of(name: str, folder: Path) -> list[Path]:
    """Return those files of a demo's page that are there, beside its numbers."""
    return [path for end in PAGE_FILE_ENDINGS if (path := folder / f"{name}{end}").exists()]


def whole(folder: Path, place: Path, stamp: str) -> bool:
    """Return whether the page whose numbers are at a place is complete and made from sources of the digest
    ``stamp``."""
    try:
        found = json.loads(place.read_bytes())
        there = {path.name: sha256(path.read_bytes()).hexdigest() for path in files_of(place.stem, folder)}
        return found["digest"] == stamp and found["files"] == there
    except (OSError, ValueError, LookupError, TypeError):  # not there, not whole, or not of this kind
        return False


def front(names: Iterable[str], folder: Path) -> Path:
    """Write the viewer, and the front page of those demos whose pages are complete."""
    demos = discover()
    written = [name for name in names if (folder / f"{name}.json").exists()]
    families = {
        family: [demo for demo in members if demo.name in written] for family, members in demos.families().items()
    }
    script = f"document.write({json.dumps(client_head())});".encode()
    viewer = folder / VIEWER_FILE
    if not viewer.exists() or viewer.read_bytes() != script:
        write_atomically(viewer, script)
    films = {name for name in written if (folder / f"{name}.gif").exists()}
    html = page_template("gallery.html").render(
        title="Effects of motion in space, and of machines as they are built",
        families=families,
        films=films,
        light=LIGHT,
        dark=DARK,
    )
    return write_atomically(folder / "index.html", html.encode("utf-8"))


def drawn(outcome: Outcome, name: str) -> list[str]:
    """Draw each panel as a figure of its own, so that a narrow page sets them below each other; what is drawn over the
    time can have a cursor.
    """
    found = []
    for k, panel in enumerate(outcome.panels):
        figure = figure_of("", [panel])
        svg = inline_svg(figure, f"{name}-{k}-")
        if isinstance(panel.drawn, Curve) and panel.drawn.along == TIME_AXIS:
            svg = svg.replace("<svg", f'<svg data-time="{time_axis(figure)}"', 1)
        found.append(svg)
    return found


def time_axis(figure: Figure) -> str:
    """Return the limits of the time in the first axes of a figure [s], where they lie, and lower and upper end of the
    axes, in the units of its SVG.
    """
    axes, (width, height) = figure.axes[0], 72 * figure.get_size_inches()
    box = axes.get_position()
    ends = (*axes.get_xlim(), box.x0 * width, box.x1 * width, (1 - box.y0) * height, (1 - box.y1) * height)
    return " ".join(f"{x:.6g}" for x in ends)


def without(demo: Demo) -> tuple[str, Outcome] | None:
    """Return the outcome under the demo's own ablation, if it has one that runs."""
    try:
        return demo.ablation.term, demo.run(demo.ablation.term)
    except ValueError:
        return None


def exploration(demo: Demo, outcome: Outcome) -> Exploration | None:
    """Return what the page of a demo needs to solve its mechanism; None without sliders."""
    if not demo.sliders:
        return None
    values = outcome.parameters

    def build(**changes: float) -> System | tuple[System, State]:
        return demo.filmed(changed(values, changes))

    def numbers(**changes: float) -> list[float]:
        return [demo.expected(changed(values, changes))[key] for key in demo.quantities]

    ablation = demo.ablation
    sliders = [
        Slider(name, low, high, item(values, name), label, with_superscripts(unit), log)
        for name, low, high, unit, label, log in starmap(Control, demo.sliders)
    ]
    ghost = None
    if ablation.term in OMITTABLE_TERMS:
        ghost = Ghost(lacking(ablation.term), term=ablation.term)
    elif ablation.change.keys() <= set(inspect.signature(demo.mechanism).parameters):
        ghost = Ghost(lacking(ablation.term), change=ablation.change)
    labels = [(prose(x.label), with_superscripts(x.unit)) for x in demo.quantities.values()]
    readings = [reading_of(demo.readings.get(key)) for key in demo.quantities]
    return Exploration(build, sliders, ghost, Theory(numbers, labels, readings) if demo.theory_moves else None)


def symbol_of(given: Mapping[str, Any]) -> dict[str, object]:
    """Return a symbol of the equation as the page shows it: its sign, meaning, value and unit, and what moves with it.

    A value is a number, or else that of a line of a curve at the moment.
    """
    value, curve = given["value"], given["curve"]
    return {
        **given,
        "sign": mathml(given["letter"])[len("<p>") : -len("</p>")],
        "text": prose(given["text"]),
        "unit": with_superscripts(given["unit"]),
        "value": "" if value is None else digits(float(value), count=4),
        "curve": "" if curve is None else f"{curve[0]}.{curve[1]}",
        "parameter": given["parameter"] if isinstance(given["parameter"], str) else "",
    }


def place_of(name: str) -> tuple[str, int | None]:
    """Return the parameter that a slider moves, and which item of it: ("w", None) of "w", ("w", 1) of "w[1]"."""
    key, _, place = name.partition("[")
    return key, int(place[:-1]) if place else None


def item(values: Values, name: str) -> float:
    """Return the value of a number or of an item of a list, by the name of a slider."""
    key, place = place_of(name)
    return float(values[key] if place is None else values[key][place])


def changed(values: Values, changes: Values) -> dict[str, Any]:
    """Return values with some of them changed, by the names of sliders."""
    found = dict(values)
    for name, value in changes.items():
        key, place = place_of(name)
        found[key] = value if place is None else [value if k == place else x for k, x in enumerate(found[key])]
    return found


def reading_of(given: tuple[str, int, int] | None) -> dict[str, object] | None:
    """Return how the page finds a number of theory in its curves."""
    return given and dict(zip(("of", "curve", "line"), given, strict=True))


def player(
    outcome: Outcome, title: str, path: Path, beside: Outcome | None = None, explore: Exploration | None = None
) -> str:
    """Write the first view of an outcome as a page that takes the viewer from beside it; return its name, or "" for
    none.

    It can be compared with that of an outcome ``beside`` it.
    """
    if not outcome.views:
        path.unlink(missing_ok=True)
        return ""
    solution, options = first_view(outcome)
    quiet: AnimateOptions = {**options, "hidden": hidden(options), "title": title, "explore": explore}
    if beside is not None:
        quiet["beside"] = first_view(beside).solution
        stops = first_view(beside).options.get("captions", ())  # where the other one rests, this one does too
        quiet["captions"] = [(t, "") for t, _ in stops if solution.t[0] <= t <= solution.t[-1]]
    html = solution.animate(**quiet).html
    html = html.replace(client_head(), f'<script src="{VIEWER_FILE}"></script>')
    script = (TEMPLATE_FOLDER / "in_step.js").read_text(encoding="utf-8")
    html = html.replace("</body>", f"<script>\n{script}</script>\n</body>")
    write_atomically(path, html.encode("utf-8"))
    return path.name


def first_view(outcome: Outcome) -> Show:
    """Return the first view of an outcome."""
    return next(iter(outcome.views.values()))


def picture(outcome: Outcome, path: Path) -> None:
    """Write a small picture of the mechanism, or of the figure where there is none."""
    with figure_style():
        if outcome.views:
            solution, options = first_view(outcome)
            figure = solution.picture(
                solution.t[len(solution.t) // 3], size=(4.8, 3.6), hidden=hidden(options),
                traces=options.get("traces"), shown=options.get("shown", ()), view=options.get("view"),
                follow=options.get("follow"),
            )  # fmt: skip
        else:
            figure = outcome.figure
        raw, small = io.BytesIO(), io.BytesIO()
        figure.savefig(raw, format="png", dpi=100)
    image = Image.open(raw).convert("RGB")
    image = image.resize((PICTURE_WIDTH, round(image.height * PICTURE_WIDTH / image.width)), Image.Resampling.LANCZOS)
    image.quantize(128, dither=Image.Dither.NONE).save(small, "PNG", optimize=True)
    write_atomically(path, small.getvalue())


def film(outcome: Outcome, path: Path) -> None:
    """Write a small film of the mechanism, if it moves."""
    path.unlink(missing_ok=True)
    if not outcome.views:
        return
    solution, options = first_view(outcome)
    span = solution.t[-1] - solution.t[0]
    poses = [np.hstack([solution.position(x), solution.orientation(x)]) for x in solution.system.bodies]
    if span > 0.0 and np.ptp(np.hstack(poses), axis=0).max() > INVISIBLE_MOTION:
        speed = float(f"{span / FILM_SECONDS:.2g}")
        solution.export_gif(
            path, fps=FILM_RATE, speed=speed, width=FILM_WIDTH, hidden=hidden(options),
            traces=options.get("traces"), shown=options.get("shown", ()), view=options.get("view"),
            follow=options.get("follow"),
        )  # fmt: skip


def hidden(options: AnimateOptions) -> list[str]:
    """Return the layers that are hidden in a small view."""
    given = options.get("hidden", ())
    return sorted({"body names", "joint names", *([given] if isinstance(given, str) else given)})


def cells(row: Row) -> Sequence[str]:
    """Format a row of the table; a value that the tolerance does not tell from zero is 0."""
    numbers = (0.0 if abs(value) < 0.1 * row.tolerance else value for value in (row.computed, row.theory))
    texts = (row.text(value, partial(digits, count=COMPARED_DIGITS)) for value in numbers)
    return prose(row.label), *texts, relative(row.error, count=2)


def prose(text: str) -> str:
    """Replace keyboard characters of a text by typographic ones."""
    for typed, printed in TYPOGRAPHY:
        text = re.sub(typed, printed, text)
    return readable(text)


def command(demo: Demo) -> str:
    """Return a shell command with parameters to change: three numbers, or short values."""
    given = {name: f"{name}={json.dumps(value)}" for name, value in demo.parameters.items()}
    numbers = [given[name] for name, value in demo.parameters.items() if isinstance(value, float | int)]
    chosen = numbers[:3] or sorted(given.values(), key=len)[:1]
    return shlex.join(["mbsd3d", "demo", demo.name, *(word for text in chosen for word in ("--set", text))])


def source_of(demo: Demo) -> str:
    """Return the source text of the file of a demo."""
    return inspect.getsource(sys.modules[demo.module])


def digest(demo: Demo, following: Demo) -> str:
    """Return the digest of the package, of the demo with its helpers, and of name and title of the demo its page leads
    to.
    """
    files = sorted(map(file_of, needed(sys.modules[demo.module])))
    texts = [common(), following.name, following.title, *(path.read_text(encoding="utf-8") for path in files)]
    return sha256("\n".join(texts).encode()).hexdigest()


def needed(module: ModuleType) -> set[ModuleType]:
    """Return the module and, of its package, what it imports; without the files that all demos share."""
    found, waiting = set(), [module]
    while waiting:
        here = waiting.pop()
        found.add(here)
        package = here.__name__ if hasattr(here, "__path__") else here.__name__.rpartition(".")[0]
        for node in ast.walk(ast.parse(file_of(here).read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.level:
                base = resolve_name("." * node.level + (node.module or ""), package)
                named = [sys.modules.get(name) for name in (base, *(f"{base}.{word.name}" for word in node.names))]
                waiting += [x for x in named if x and x not in found and file_of(x) not in shared()]
    return found


def file_of(module: ModuleType) -> Path:
    """Return the file of a module."""
    return Path(inspect.getfile(module))


@cache
def shared() -> frozenset[Path]:
    """Return the files of the package, scripts and templates too, but for the families of demos."""
    families = PACKAGE_FOLDER / "demos"
    return frozenset(
        x for x in PACKAGE_FOLDER.rglob("*") if x.suffix in SOURCE_SUFFIXES and families not in x.parent.parents
    )


@cache
def common() -> str:
    """Return the digest of the shared files."""
    return sha256(b"".join(path.read_bytes() for path in sorted(shared()))).hexdigest()
