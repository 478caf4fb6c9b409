"""Page of a study: one HTML file, with the animation in a second one."""

import os
from pathlib import Path

import numpy as np
from markupsafe import Markup

from engines.balance.pages.site import TEMPLATES, playing
from engines.nvh import figures, tables
from engines.nvh.control.report import ActiveMount
from engines.nvh.control.report import figure as active_figure
from engines.nvh.study import AGREEMENT_SHARE_MAX, Study, Sweep
from mbsd3d.extend import digits, inline_svg, page_template, write_atomically

ANIMATION_SECONDS = 4.0  # [s] that a cycle takes in the animation
SWEEP_ROWS = 13  # [1] rows of the table of a sweep


def write_page(
    study: Study,
    folder: str | Path,
    active: ActiveMount | None = None,
    swept: Sweep | None = None,
    sound: str | Path | None = None,
) -> Path:
    """Write ``ENGINE-CAR.html`` and its view into a folder that exists, with an active mount, full motions over the
    speed and a sound if given; return the path of the page.
    """
    folder, name = Path(folder), f"{study.preset.name}-{study.car.name}"
    view = f"{name}-view.html"
    write_atomically(folder / view, playing(shown(study)).encode())
    drawn = {
        "cycle": figures.working_cycle(study),
        "block": figures.waterfall(study, *figures.on_block(study)),
        "bearings": figures.bearing_loads(study),
        "waterfall": figures.waterfall(study, figures.handed(study.map.force), "N"),
        "lines": figures.order_lines(study, swept),
        "transmissibility": figures.transmissibility(study, swept),
    }
    shown_tables = dict.fromkeys(("faults", "heights", "sweep", "felt", "shell", "most", "paths")) | {
        "loads": tables.loads(study), "bearings": tables.bearings(study), "modes": tables.modes(study),
        "shapes": tables.shapes(study), "mounts": tables.mounts(study), "handed": tables.handed_on(study),
    }  # fmt: skip
    if study.source.fitted:
        shown_tables |= {"faults": tables.faults(study), "heights": tables.heights(study)}
    if active is not None:
        drawn["active"] = active_figure(active)
    if swept is not None:
        shown_tables["sweep"] = tables.sweep(swept, SWEEP_ROWS)
    if study.shell_known:
        drawn["seat"] = figures.seat_lines(study)
        shown_tables |= {"felt": tables.felt(study), "shell": tables.shell(study)}
        shown_tables["most"], shown_tables["paths"] = tables.paths(study)
    page = page_template("nvh.html", TEMPLATES).render(
        study=study, why=tables.why(study), view=view, lines=tables.facts(study),
        agrees=study.difference <= AGREEMENT_SHARE_MAX, digits=digits,
        figures={key: Markup(inline_svg(made, f"{key}-")) for key, made in drawn.items()}, active=active, swept=swept,
        sound=None if sound is None else Path(os.path.relpath(sound, folder)).as_posix(), **shown_tables,
    )  # fmt: skip
    return write_atomically(folder / f"{name}.html", page.encode())


def shown(study: Study) -> str:
    """Render the moving engine on its mounts as a page."""
    cycle = 4 * np.pi / study.preset.engine(study.rpm).rate
    return study.run.animate(
        curves=(), traces=(), hidden=("body names",), speed=cycle / ANIMATION_SECONDS, title=study.preset.title
    ).html
