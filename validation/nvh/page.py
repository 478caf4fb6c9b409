"""The page of a study: one HTML file, and beside it the animation."""

from pathlib import Path

import numpy as np
from markupsafe import Markup

from mbsd3d.extend import digits, inline_svg, page_template, write_atomically
from validation.engine_balance.pages.site import TEMPLATES, playing
from validation.nvh import figures, tables
from validation.nvh.study import AGREES, Study

PERIOD = 4.0  # s that a cycle takes to watch


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
        figures={key: Markup(inline_svg(made, f"{key}-")) for key, made in drawn.items()}, loads=tables.loads(study),
        modes=tables.modes(study), mounts=tables.mounts(study), handed=tables.handed_on(study),
        bearings=tables.bearings(study), timing=tables.timing(study) if study.source.fitted else None,
    )  # fmt: skip
    return write_atomically(folder / f"{name}.html", page.encode())


def shown(study: Study) -> str:
    """The moving engine on its mounts, as a page."""
    cycle = 4 * np.pi / study.preset.engine(study.rpm).rate
    return study.run.animate(curves=(), traces=(), speed=cycle / PERIOD, title=study.preset.title).html
