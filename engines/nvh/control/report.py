"""Active mount in a study: the order it cancels, its settling time and power, and the limit of a skyhook."""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from engines.nvh.control.cancel import Cancel
from engines.nvh.control.skyhook import Skyhook, limit, on_mounts
from engines.nvh.mounts.mounts import bushings
from engines.nvh.mounts.rigid_modes import mass_matrix
from engines.nvh.study import Study
from mbsd3d import Body, Mode, System, linearize
from mbsd3d.errors import InputError
from mbsd3d.extend import LINE_WIDTH_POINTS, new_figure, style_axes

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SAMPLE_RATE = 2000.0  # [Hz] samples a second of the controller
STEP_RATIO, RUN_SECONDS = 0.2, 1.0  # step over its limit; s of the run
FIGURE_SAMPLES = 120  # [1] samples of a figure at either end
SKYHOOK_GAIN_RATIO = 0.1  # [1] gain of the skyhook over its limit


@dataclass(frozen=True)
class ActiveMount:
    """Upright mount with the largest force along z and the order that causes it; ValueError if none is upright."""

    study: Study

    @cached_property
    def cancel(self) -> Cancel:
        """Return the feed-forward control of the order."""
        study, force = self.study, np.abs(self.study.here.force[0, :, :, 2])
        upright = [not mount.angle for mount in study.placed]
        if not any(upright):
            raise InputError(f"active mount: no mount of '{study.car.name}' is upright; give another car")
        order, which = np.unravel_index((force * upright).argmax(), force.shape)
        return Cancel(
            study.on_mounts, study.source, study.rpm, int(which), float(study.here.orders[order]), SAMPLE_RATE
        )

    @cached_property
    def steps(self) -> tuple[float, float]:
        """Return (step of the controller, the step from which it is unstable)."""
        most = self.cancel.path.limit(self.cancel.W)
        return STEP_RATIO * most, most

    @cached_property
    def force(self) -> np.ndarray:
        """Return the force on the car in the general model [N], shape (samples,)."""
        return self.cancel.run(self.steps[0], int(RUN_SECONDS * SAMPLE_RATE))

    @cached_property
    def known(self) -> np.ndarray:
        """Return the force on the car by the poles of the linear loop [N], shape (samples,)."""
        return self.cancel.predicted(self.steps[0], self.force.size)

    @property
    def difference(self) -> float:
        """Return the difference of general model and poles over the force at the start [-]."""
        return float(np.abs(self.force - self.known).max() / abs(self.cancel.force))

    @cached_property
    def hook(self) -> tuple[float, float, float]:
        """Return (limit of the gain [N s/m], damping ratio of the mode that lifts the mount most, without a skyhook and
        with `SKYHOOK_GAIN_RATIO` of the limit).
        """
        body, placed, at = self.study.body.rigid, self.study.placed, self.cancel.mount.at
        most = limit(lambda gain: on_mounts(body, placed, Skyhook(at, gain)))
        bare = System([body], forces=bushings(placed, body), gravity=(0, 0, 0))
        hooked = on_mounts(body, placed, Skyhook(at, SKYHOOK_GAIN_RATIO * most))
        before, after = (lifting(system, body, at).damping_ratio for system in (bare, hooked))
        return most, before, after

    @property
    def rows(self) -> list[list[str]]:
        """Return the rows of the table."""
        cancel, (step, most), (gain, before, after) = self.cancel, self.steps, self.hook
        left = np.abs(self.force[-int(SAMPLE_RATE / 10) :]).max()
        size, power = cancel.actuator
        slowest = cancel.path.time(cancel.W, step)
        return [
            ["active mount", cancel.mount.name],
            ["order", f"{cancel.order:g}x, {cancel.W / (2 * np.pi):.1f} Hz, {abs(cancel.force):.2f} N along z"],
            ["feed-forward", f"{SAMPLE_RATE:g} samples/s, step {step:.3g}, unstable from {most:.3g}"],
            ["slowest part", f"falls to 1/e in {slowest:.3f} s"],
            [f"after {RUN_SECONDS:g} s", f"{left:.3g} N, {20 * np.log10(left / abs(cancel.force)):.1f} dB"],
            ["actuator", f"{size:.2f} N, {power:.2f} W to the powertrain"],
            ["poles and general model", f"differ by {self.difference:.2%}"],
            [
                "skyhook",
                f"stable up to {gain:.4g} N s/m; {SKYHOOK_GAIN_RATIO:.0%} of it damps by {after:.3f}, not {before:.3f}",
            ],
        ]


def figure(found: ActiveMount) -> "Figure":
    """Plot the force on the car from the start of the controller on: general model, sample by sample, and its linear
    loop.
    """
    ends = (slice(0, FIGURE_SAMPLES), slice(found.force.size - FIGURE_SAMPLES, None))
    t = 1e3 * np.arange(found.force.size) / SAMPLE_RATE
    with new_figure(7.5, 2.8) as (made, look):
        for axes, part, title in zip(made.subplots(1, 2), ends, ("first", "last"), strict=True):
            style_axes(axes, look)
            axes.plot(
                t[part], found.known[part], color=look.colour(0), linewidth=LINE_WIDTH_POINTS, label="linear loop"
            )
            axes.plot(t[part], found.force[part], ".", color=look.ink, markersize=3, label="general model")
            axes.set(xlabel="time [ms]", ylabel="force at the car [N]" if title == "first" else "")
            axes.set_title(f"{title} {1e3 * FIGURE_SAMPLES / SAMPLE_RATE:g} ms", loc="left")
            axes.ticklabel_format(axis="y", style="plain", useOffset=False)
        made.legend(*axes.get_legend_handles_labels(), frameon=False, labelcolor=look.ink, ncols=2,
                    loc="outside lower right")  # fmt: skip
    return made


def lifting(system: System, body: Body, at: tuple[float, float, float]) -> Mode:
    """Return the mode that lifts a point of the body most for its energy."""
    M, arm = mass_matrix(body), np.array(at) - body.com

    def lift(mode: Mode) -> float:
        shape = np.concatenate([mode.translation[0], mode.rotation[0]])
        energy = (shape.conj() @ M @ shape).real
        return float(abs(shape[2] + np.cross(shape[3:], arm)[2]) ** 2 / energy) if energy > 0.0 else 0.0

    return max(linearize(system).modes, key=lift)
