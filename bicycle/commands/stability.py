"""Command on eigenvalues over the speed, of ideal wheels and of tyres."""

from typing import TYPE_CHECKING, Any

import click
import numpy as np

from mbsd3d.extend import Failure, can_view, number, ready_folder

from . import bicycle_argument, dark_option, out_option, report, saved, tyre_options

if TYPE_CHECKING:
    from ..parameters import Parameters


@click.command(epilog="Example: mbsd3d bicycle stability Browserins")
@bicycle_argument
@click.option("--from", "first", type=float, help="Lowest speed [m/s], may be negative; default 0.")
@click.option("--to", "last", type=float, help="Highest speed [m/s]; default 10.")
@click.option("--count", type=click.IntRange(2, 100_000), help="Number of speeds; default 401.")
@click.option("--mode", "shown", help="Also write a page (.html) that shows this mode: weave, capsize or castering,")
@click.option("--speed", type=float, default=5.0, show_default=True, help="at this speed [m/s].")
@tyre_options
@dark_option
@out_option
def stability(
    parameters: "Parameters", first: float | None, last: float | None, count: int | None, shown: str | None,
    speed: float, fittings: dict[str, Any], dark: bool, out: str,
) -> None:  # fmt: skip
    """Compute eigenvalues over the speed: weave, capsize, castering and the stable range.

    BICYCLE is a name, e.g. Browserins, or a file with parameters (.txt, .yml). Writes a figure and a table (.csv). On
    tyres: from 0.5 m/s in 96 steps; Sharp1971 is a motorcycle on its own tyres, at 3 to 50 m/s.
    """
    from ..linear.stability import check_mode, study

    low, high, most = (0.0, 10.0, 401) if not fittings else (0.5, 10.0, 96)
    if "steer_damping" in fittings:
        low, high, most = 3.0, 50.0, 95
    first, last = low if first is None else first, high if last is None else last
    count = most if count is None else count
    if not -np.inf < first < last < np.inf:
        raise Failure(f"--from {first:g} is not below --to {last:g}; give two finite speeds in m/s")
    if fittings:
        stability_on_tyres(parameters, np.linspace(first, last, count), (shown, speed), fittings, dark, out)
        return
    if shown:
        check_mode(shown)
        number(speed, "--speed")
        can_view(needed=True)
    folder = ready_folder(out)
    found = study(parameters, np.linspace(first, last, count))
    target = folder / f"stability_{parameters.name}"
    click.echo(f"{parameters.name}\n{found.critical}")
    if found.closed is not None:
        click.echo(f"general model and closed form differ by {found.difference:.1e} 1/s")
    report(*saved(found.figure(dark=dark), target), found.to_csv(target))
    if shown:
        page = found.mode(shown, speed).animate(title=f"{parameters.name}: {shown} at {speed:g} m/s")
        report(page.save(folder / f"{shown}_{parameters.name}"))


def stability_on_tyres(
    parameters: "Parameters", speeds: np.ndarray, shown: tuple[str | None, float], fittings: dict[str, Any], dark: bool,
    out: str,
) -> None:  # fmt: skip
    """Compute the same on tyres, with printed eigenvalues where there are some."""
    from ..linear.stability import study

    can_view(needed=bool(shown[0]))
    folder = ready_folder(out)
    found = study(parameters, speeds, **fittings)
    click.echo(f"{parameters.name} on tyres\n{found}")
    target = folder / f"stability_{parameters.name}_tyres"
    report(*saved(found.figure(dark=dark), target), found.to_csv(target))
    if shown[0]:
        title = f"{parameters.name} on tyres: {shown[0]} at {shown[1]:g} m/s"
        report(found.mode(*shown).animate(title=title).save(folder / f"{shown[0]}_{parameters.name}_tyres"))
