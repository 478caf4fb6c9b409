"""Table, figure and page of a valve train over the speed."""

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from markupsafe import Markup

from engines.balance.pages.site import TEMPLATES, playing
from engines.nvh.valvetrain.cam import RollerCam, cam
from engines.nvh.valvetrain.train import Train
from mbsd3d import Solution
from mbsd3d.errors import InputError
from mbsd3d.extend import (
    LINE_WIDTH_POINTS,
    digits,
    inline_svg,
    new_figure,
    number,
    page_template,
    style_axes,
    write_atomically,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CAM_LIFT, CAM_HALF_ANGLE = 0.008, np.radians(75.0)  # m, rad, of an ordinary cam (assumed)
BASE_RADIUS = {"flat": 0.024, "roller": 0.018, "barrel": 0.036}  # [m] of the cam, by its follower
FLOAT_SPEED_RATIOS = (0.5, 0.8, 0.95, 1.05, 1.2)  # [1] of the float speed
SPRING_MASSES = 8  # [1] masses of a spring with surge
CAM_SPEED_MIN = 100.0  # [1/min] an idling engine turns its camshaft at 300
ANIMATION_SECONDS = 6.0  # [s] that a turn takes in the animation


@dataclass(frozen=True)
class Valve:
    """Cam of a law with the valve of `Train` on a ``follower``, "flat", "roller" or "barrel", at a speed of the
    camshaft [1/min]; None: 5 % above that of float. ValueError for a speed that is not positive, or below
    `CAM_SPEED_MIN`.
    """

    law: str
    rpm: float | None = None
    follower: str = "flat"

    @cached_property
    def train(self) -> Train:
        """Return the valve train at the speed."""
        train = Train(cam(self.law, CAM_LIFT, CAM_HALF_ANGLE, BASE_RADIUS.get(self.follower, 0.0), self.follower))
        speed = (
            FLOAT_SPEED_RATIOS[-2] * train.floats_at()
            if self.rpm is None
            else number(self.rpm, "valve: rpm", positive=True)
        )
        if speed < CAM_SPEED_MIN:
            raise InputError(
                f"valve: rpm {speed:g}; give {CAM_SPEED_MIN:g} or more: slower ones only feel their spring"
            )
        return Train(train.cam, rpm=speed)

    @cached_property
    def floats(self) -> float:
        """Return the speed of the camshaft from which on the valve floats [1/min]."""
        return Train(self.train.cam).floats_at()

    @cached_property
    def held(self) -> Solution:
        """Return a turn with the valve held on the cam."""
        return self.train.held()

    @cached_property
    def run(self) -> Solution:
        """Return the motion with the contact, the spring without mass."""
        return self.train.free()

    @cached_property
    def surging(self) -> Solution:
        """Return the motion with the contact and a spring that has a mass."""
        return self.surging_train.free()

    @property
    def surging_train(self) -> Train:
        """Return the valve train with a spring of `SPRING_MASSES`."""
        return replace(self.train, pieces=SPRING_MASSES)

    @cached_property
    def rows(self) -> list[list[str]]:
        """Tabulate over the speed the multiplier of the constraint and the behaviour of the contact."""
        table = [["1/min", "spring", "constraint, least [N]", "contact, most [N]", "open [degrees]", "gap [mm]"]]
        for rpm in sorted({*(share * self.floats for share in FLOAT_SPEED_RATIOS), self.train.rpm}):
            for words, pieces in (("without mass", 0), (f"{SPRING_MASSES} pieces", SPRING_MASSES)):
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
        """Return cam, valve and spring in a line."""
        train, chosen = self.train, self.train.cam
        return (
            f"{self.title}, lift {1e3 * CAM_LIFT:g} mm, base {1e3 * chosen.base:g} mm, {self.touched}least radius "
            f"{1e3 * chosen.radius.min():.2f} mm; valve {1e3 * train.mass:g} g, spring {train.rate / 1e3:g} N/mm with "
            f"{train.preload:g} N; floats from {self.floats:.1f} 1/min of the camshaft on"
        )

    @property
    def title(self) -> str:
        """Return law and follower of the cam in words."""
        return f"{self.law} {'barrel cam' if self.follower == 'barrel' else f'cam, {self.follower} follower'}"

    @property
    def touched(self) -> str:
        """Return size, lateral deflection and side force of a roller in a line; nothing for a flat face."""
        chosen = self.train.cam
        if not isinstance(chosen, RollerCam):
            return ""
        side = np.abs(self.held.reaction("cam").force[:, 1]).max()
        return (
            f"roller {1e3 * chosen.roller:g} mm, pressure angle up to {np.degrees(chosen.lean):.1f} degrees, side "
            f"force on the guide up to {side:.0f} N at {self.train.rpm:.0f} 1/min, "
        )

    @property
    def verdict(self) -> str:
        """Return the assessment of the constraint, which holds in both directions."""
        return "; ".join(self.held.certificate.notes) or f"stays on its cam at {self.train.rpm:.0f} 1/min"

    @property
    def name(self) -> str:
        """Return the name of the page."""
        return f"valve-{self.law}" + f"-{self.follower}" * (self.follower != "flat")


def figure(valve: Valve) -> "Figure":
    """Plot force of the cam and lift over a turn at the speed: constraint, contact, contact with a spring that
    surges."""
    train = valve.train
    with new_figure(7.5, 5.0) as (made, look):
        force, lift = made.subplots(2, 1, sharex=True)
        for axes in (force, lift):
            style_axes(axes, look)
        angle = 360 * np.arange(valve.run.t.size) / (valve.run.t.size - 1) - 180
        force.plot(angle, train.pushed(), color=look.ink, linewidth=LINE_WIDTH_POINTS, label="constraint")
        lift.plot(
            angle, 1e3 * train.cam.spline(np.radians(angle) % (2 * np.pi)), color=look.ink, linewidth=LINE_WIDTH_POINTS
        )
        for k, (run, words) in enumerate(((valve.run, "contact"), (valve.surging, "contact, spring surges"))):
            force.plot(
                angle, run.force("contact").force[:, 2], color=look.colour(k), linewidth=LINE_WIDTH_POINTS, label=words
            )
            height = run.position("valve")[:, 2] - train.cam.height
            lift.plot(angle, 1e3 * height, color=look.colour(k), linewidth=LINE_WIDTH_POINTS)
        force.set(ylabel="force of the cam [N]")
        lift.set(xlabel="cam angle from the nose [degrees]", ylabel="lift [mm]", xticks=range(-180, 181, 60))
        made.legend(frameon=False, labelcolor=look.ink, ncols=3, loc="outside lower right")
    return made


def write_page(valve: Valve, folder: str | Path) -> Path:
    """Write the page of a valve, ``valve-LAW.html`` if its follower is flat, and its view into a folder that exists;
    return the path of the page.
    """
    folder, view = Path(folder), f"{valve.name}-view.html"
    speed = 60 / valve.train.rpm / ANIMATION_SECONDS
    shown = valve.surging.animate(curves=(), traces=(), hidden=("body names",), speed=speed, title=valve.title).html
    write_atomically(folder / view, playing(shown).encode())
    page = page_template("valve.html", TEMPLATES).render(
        valve=valve, view=view, digits=digits, figure=Markup(inline_svg(figure(valve), "valve-"))
    )
    return write_atomically(folder / f"{valve.name}.html", page.encode())
