"""The page of a study: one HTML file, and beside it the animation."""

from pathlib import Path

from mbsd3d.extend import digits, inline_svg, page_template, write_atomically
from validation.engine_balance.pages.site import TEMPLATES, playing
from validation.nvh import figures, tables
from validation.nvh.study import AGREES, Study

PERIOD = 4.0  # s that two turns take to watch


def write_page(study: Study, folder: str | Path) -> Path:
    """Write ``ENGINE-CAR.html`` and its view into a folder that exists; where the page is."""
    folder, name = Path(folder), f"{study.preset.name}-{study.car.name}"
    view = f"{name}-view.html"
    write_atomically(folder / view, playing(shown(study)).encode())
    drawn = {
        "cycle": figures.working_cycle(study),
        "bearings": figures.bearing_loads(study),
        "waterfall": figures.waterfall(study),
        "lines": figures.order_lines(study),
    }
    page = page_template("nvh.html", TEMPLATES).render(
        study=study, view=view, lines=tables.facts(study), agrees=study.difference <= AGREES, digits=digits,
        figures={key: as_svg(made, key) for key, made in drawn.items()}, loads=tables.loads(study),
        modes=tables.modes(study), mounts=tables.mounts(study), handed=tables.handed_on(study),
        bearings=tables.bearings(study), timing=tables.timing(study) if study.source.fitted else None,
    )  # fmt: skip
    return write_atomically(folder / f"{name}.html", page.encode())


def as_svg(made: object, key: str) -> object:
    """A figure as part of the page."""
    from markupsafe import Markup

    return Markup(inline_svg(made, f"{key}-"))


def shown(study: Study) -> str:
    """The moving engine on its mounts over one cycle, as a page."""
    run = study.run
    cycle = float(run.t[-1] - run.t[0]) / 4
    return run.animate(curves=(), traces=(), speed=4 * cycle / PERIOD / 4, title=study.preset.title).html
