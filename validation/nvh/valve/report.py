"""Table, figure and page of a valve train over the speed."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from markupsafe import Markup

from bicycle.output import new_figure
from mbsd3d import Solution
from mbsd3d.extend import LINE, digits, dress, inline_svg, number, page_template, write_atomically
from validation.engine_balance.pages.site import TEMPLATES, playing
from validation.nvh.valve.cam import cam
from validation.nvh.valve.train import Train

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LIFT, HALF, BASE = 0.008, np.radians(75.0), 0.024  # m, of an ordinary cam with a flat follower (assumed)
SHARES = (0.5, 0.8, 0.95, 1.05, 1.2)  # of the speed of float
PIECES = 8  # of a spring that surges
PERIOD = 6.0  # s that a turn takes to watch


@dataclass(frozen=True)
class Valve:
    """A cam of a law with the valve of `Train`, at a speed of the camshaft [1/min]; None: 5 % above that of float."""

    law: str
    rpm: float | None = None

    @cached_property
    def train(self) -> Train:
        """The train at the speed."""
        train = Train(cam(self.law, LIFT, HALF, BASE))
        speed = SHARES[-2] * train.floats_at() if self.rpm is None else number(self.rpm, "valve: rpm", positive=True)
        return Train(train.cam, rpm=speed)

    @cached_property
    def floats(self) -> float:
        """Speed of the camshaft from which on the valve floats [1/min]."""
        return Train(self.train.cam).floats_at()

    @cached_property
    def run(self) -> Solution:
        """The motion in the contact, the spring without mass."""
        return self.train.free()

    @cached_property
    def surging(self) -> Solution:
        """The same with a spring that has a mass."""
        return Train(self.train.cam, rpm=self.train.rpm, pieces=PIECES).free()

    @cached_property
    def rows(self) -> list[list[str]]:
        """Over the speed: the multiplier of the constraint beside what the contact does."""
        table = [["1/min", "spring", "constraint, least [N]", "contact, most [N]", "open [degrees]", "gap [mm]"]]
        for rpm in sorted({*(share * self.floats for share in SHARES), self.train.rpm}):
            for words, pieces in (("without mass", 0), (f"{PIECES} pieces", PIECES)):
                train = Train(self.train.cam, rpm=rpm, pieces=pieces)
                run = train.free()
                gap, force = train.gap(run), run.force("contact").force[:, 2]
                least = f"{train.pushed().min():.1f}" if pieces == 0 else ""
                open_for = f"{360 * (gap[:-1] > 0).mean():.1f}"
                table.append(
                    [f"{rpm:.0f}", words, least, f"{force.max():.0f}", open_for, f"{1e3 * max(gap.max(), 0):.3f}"]
                )
        return table

    @property
    def facts(self) -> str:
        """Cam, valve and spring in a line."""
        radius, train = 1e3 * self.train.cam.radius.min(), self.train
        return (
            f"{self.law} cam, lift {1e3 * LIFT:g} mm, base {1e3 * BASE:g} mm, least radius {radius:.2f} mm; "
            f"valve {1e3 * train.mass:g} g, spring {train.rate / 1e3:g} N/mm with {train.preload:g} N; "
            f"floats from {self.floats:.1f} 1/min of the camshaft on"
        )


def figure(valve: Valve) -> "Figure":
    """Force of the cam and lift over a turn at the speed: constraint, contact, contact with a spring that surges."""
    train = valve.train
    with new_figure(7.5, 5.0) as (made, look):
        force, lift = made.subplots(2, 1, sharex=True)
        for axes in (force, lift):
            dress(axes, look)
        angle = 360 * np.arange(valve.run.t.size) / (valve.run.t.size - 1) - 180
        force.plot(angle, train.pushed(), color=look.ink, linewidth=LINE, label="constraint")
        lift.plot(angle, 1e3 * train.cam.spline(np.radians(angle) % (2 * np.pi)), color=look.ink, linewidth=LINE)
        for k, (run, words) in enumerate(((valve.run, "contact"), (valve.surging, "contact, spring surges"))):
            force.plot(angle, run.force("contact").force[:, 2], color=look.colour(k), linewidth=LINE, label=words)
            height = run.position("valve")[:, 2] - train.cam.base
            lift.plot(angle, 1e3 * height, color=look.colour(k), linewidth=LINE)
        force.set(ylabel="force of the cam [N]")
        lift.set(xlabel="cam angle from the nose [degrees]", ylabel="lift [mm]", xticks=range(-180, 181, 60))
        made.legend(frameon=False, labelcolor=look.ink, ncols=3, loc="outside lower right")
    return made


def write_page(valve: Valve, folder: str | Path) -> Path:
    """Write ``valve-LAW.html`` and its view into a folder that exists; where the page is."""
    folder, view = Path(folder), f"valve-{valve.law}-view.html"
    speed = 60 / valve.train.rpm / PERIOD
    shown = valve.surging.animate(curves=(), traces=(), speed=speed, title=f"{valve.law} cam").html
    write_atomically(folder / view, playing(shown).encode())
    page = page_template("valve.html", TEMPLATES).render(
        valve=valve, view=view, digits=digits, figure=Markup(inline_svg(figure(valve), "valve-"))
    )
    return write_atomically(folder / f"valve-{valve.law}.html", page.encode())
