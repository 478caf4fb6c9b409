"""Command on riders: five loops over a course, and balance assist."""

from typing import TYPE_CHECKING, Any

import click
import numpy as np

from mbsd3d.errors import InputError
from mbsd3d.extend import ready_folder

from . import bicycle_argument, dark_option, out_option, report, saved, tyre_options

if TYPE_CHECKING:
    from ..parameters import Parameters
    from ..riders.rider import Gains

COURSE_NAMES = ("lane-change", "slalom")
ASSIST_GAINS = (0.0, -5.0, -10.0, -25.0, -50.0)
ASSIST_SPEEDS = np.linspace(0.1, 15.0, 150)
"""[m/s] Between two of which a limit of assist is sought."""
SPEED_MIN, SPEED_MAX, SPEED_COUNT = 2.0, 12.0, 41
"""[m/s] Of handling quality over the speed."""


@click.command(epilog="Example: mbsd3d bicycle rider Browserins")
@bicycle_argument
@click.option(
    "--course", type=click.Choice(COURSE_NAMES), default="lane-change", show_default=True, help="Course to follow."
)
@click.option("--speed", type=float, default=5.0, show_default=True, help="Speed at the start [m/s].")
@click.option(
    "--gains", type=float, nargs=5, default=None, metavar="STEER RATE ROLL HEADING WAY",
    help="Gains of the five loops, from the inside out; default: by rule, for this bicycle and speed.",
)  # fmt: skip
@click.option("--t-end", type=float, default=12.0, show_default=True, help="End of the ride [s].")
@tyre_options
@dark_option
@out_option
def rider(
    parameters: "Parameters", course: str, speed: float, gains: tuple[float, ...] | None, t_end: float,
    fittings: dict[str, Any], dark: bool, out: str,
) -> None:  # fmt: skip
    """Simulate a rider who closes five loops: gains, handling quality over the speed, and a course in the nonlinear
    model.

    Gains, factors of the closed loops, handling quality, and the self-stable speeds with roll-rate feedback (balance
    assist) are those of ideal wheels; with --tyres the course is ridden on tyres. Writes figures and tables (.csv) of
    handling and course. Next: mbsd3d bicycle ride
    """
    from ..riders import handling
    from ..riders.assist import into_the_fall, regulator, roll_rate, stable_ranges
    from ..riders.rider import LOOPS, Gains, eigenvalues, factors, gains_of
    from ..rides.course import COURSES, figure, run

    folder = ready_folder(out)
    given = Gains(*gains) if gains else gains_of(parameters, speed)
    for count, name in enumerate(LOOPS, 1):
        click.echo(f"{name:18} {given[count - 1]:10.5g}  {factors(eigenvalues(parameters, speed, given, count))}")
    over = handling.study(parameters, np.linspace(SPEED_MIN, SPEED_MAX, SPEED_COUNT))
    click.echo(f"{over}\n  with these gains at {speed:g} m/s: {quality(parameters, speed, given)}")
    laws = {f"roll-rate feedback {k:4g} N m s/rad": roll_rate(k) for k in ASSIST_GAINS}
    laws |= {"steer into the fall, -20 N m/rad, -10 N m s/rad": into_the_fall(-20.0, -10.0)}
    laws["linear-quadratic regulator"] = regulator(parameters)
    click.echo(f"feedback, tried from {ASSIST_SPEEDS[0]:g} to {ASSIST_SPEEDS[-1]:g} m/s:")
    for name, law in laws.items():
        ranges = [f"{low:.5f} ... {high:.5f} m/s" for low, high in stable_ranges(parameters, law, ASSIST_SPEEDS)]
        click.echo(f"{name}: stable on ideal wheels {', '.join(ranges) or 'nowhere'}")
    found = run(parameters, COURSES[course], speed=speed, gains=given, t_end=t_end, **fittings)
    click.echo(str(found))
    rated = folder / f"handling_{parameters.name}"
    report(*saved(over.figure(dark=dark), rated), over.to_csv(rated))
    target = folder / f"{parameters.name}_{course}{'_tyres' * bool(fittings)}"
    report(*saved(figure(found, course.replace("-", " "), dark=dark), target), found.to_csv(target))
    if not found.ride.solution.certificate.passed:
        raise click.exceptions.Exit(1)


def quality(parameters: "Parameters", speed: float, gains: "Gains") -> str:
    """Return the peak of the metric as text, or why there is none."""
    from ..riders.handling import peak

    try:
        return "{:.4g} at {:.4g} rad/s".format(*peak(parameters, speed, gains))
    except InputError as error:
        return str(error)
