"""Command ``mbsd3d run``: a simulation with its files."""

from typing import TYPE_CHECKING

import click

from ..base.errors import InputError
from .interruption import INTERRUPT_EXIT_CODE
from .support import (
    can_view,
    import_options,
    keep,
    list_parameters,
    load_posed,
    parameters_option,
    pose_option,
    ready_target,
    set_option,
    undisturbed,
)  # fmt: skip

if TYPE_CHECKING:
    from ..integrators.method import Method

METHODS = ("DOP853", "RK4", "GeneralizedAlpha", "RadauIIA", "Kinematic")


def method_of(name: str | None, dt: float | None, stiff: str | None) -> "Method":
    """Return the method of the options; raise an error for options it does not take."""
    import mbsd3d

    given = {key: value for key, value in (("dt", dt), ("stiff", stiff)) if value is not None}
    name = name or "DOP853"
    takes = {"DOP853": ("dt", "stiff"), "Kinematic": ()}.get(name, ("dt",))
    wrong = [key for key in given if key not in takes]
    if wrong:
        raise InputError(f"--{wrong[0]} is nothing that {name} takes; leave it out, or give another --method")
    if name == "RK4" and dt is None:
        raise InputError("--method RK4 needs --dt, its step [s]")
    return getattr(mbsd3d, name)(**given)


@click.command(epilog="Example: mbsd3d run pendulum.py --t-end 2 --set mass=3 --view")
@click.argument("file")
@click.option("--t-end", type=float, default=5.0, show_default=True, help="End of the run [s].")
@click.option("--method", type=click.Choice(METHODS), help="Integration method; default: DOP853.")
@click.option("--dt", type=float, help="Fixed step [s] of the method.")
@click.option(
    "--stiff", type=click.Choice(["stop", "run"]), help="Whether DOP853 continues with a stiff model; default: stop."
)
@click.option("--rtol", type=float, default=1e-8, show_default=True, help="Tolerance: a step may err by a fifth of it.")
@click.option("--output", type=int, help="Number of equally spaced samples; default: every step.")
@click.option("--view", "viewed", is_flag=True, help="Also write a page (.html) that shows the motion.")
@click.option(
    "--report", "reported", is_flag=True, help="Also write a report (_report.html): certificate, tables, curves."
)
@import_options
@pose_option
@set_option
@parameters_option
@click.option("--out", default="out", show_default=True, help="Folder for the results, or the name of the .npz file.")
def run(
    file: str,
    t_end: float,
    method: str | None,
    dt: float | None,
    stiff: str | None,
    rtol: float,
    output: int | None,
    viewed: bool,
    reported: bool,
    drop: tuple[str, ...],
    pose: str | None,
    settings: tuple[str, ...],
    help_parameters: bool,
    out: str,
) -> None:
    """Simulate a mechanism.

    FILE is a model file (.json, .toml), a model of MuJoCo (.xml, .mjcf), ROS (.urdf, .xacro) or Gazebo (.sdf), or a
    Python file with build(), which returns a System. Writes a solution (.npz, read by mbsd3d.load), a table (.csv) and
    a figure of the energies. Ctrl-C keeps the samples so far. The exit code is 1 if the certificate fails.
    """
    can_view(needed=viewed)
    if help_parameters:
        list_parameters(file)
    chosen = method_of(method, dt, stiff)
    system, start = load_posed(file, drop, settings, pose)
    target = ready_target(file, out, ".npz")
    from ..api.simulation import simulate
    from ..base.errors import IntegrationError
    from ..plotting.plots import save_figure

    try:
        solution = simulate(system, t_end, state=start, method=chosen, rtol=rtol, output=output)
    except IntegrationError as error:
        keep(error.solution, target)
        raise
    if (solution.record.stopped_by or "").startswith("interrupted"):
        click.echo(f"mbsd3d: {solution.record.stopped_by}", err=True)
        keep(solution, target)
        raise click.exceptions.Exit(INTERRUPT_EXIT_CODE)
    with undisturbed():
        saved = solution.save(target)
    for path in (saved, solution.to_csv(target), *save_figure(solution.plot(), target)):
        click.echo(str(path))
    if viewed:
        click.echo(str(solution.animate(title=target.name).save(target)))
    if reported:
        page = solution.report(title=target.name).save(target.with_name(f"{target.name}_report"))
        click.echo(str(page))
    click.echo(str(solution.certificate))
    if not solution.certificate.passed:
        raise click.exceptions.Exit(1)
