"""``mbsd3d run``: a simulation with its files."""

import click

from .support import INTERRUPTED, can_view, drop_option, keep, load_system, ready_target


@click.command()
@click.argument("file")
@click.option("--t-end", type=float, required=True, help="End of the run [s].")
@click.option("--rtol", type=float, default=1e-8, show_default=True, help="Local relative error of a step.")
@click.option("--output", type=int, help="Number of equally spaced samples; without it every step.")
@click.option("--view", "viewed", is_flag=True, help="Also write a page (.html) that shows the motion.")
@click.option(
    "--report", "reported", is_flag=True, help="Also write a report (_report.html): certificate, tables, curves."
)
@drop_option
@click.option("--out", default="out", show_default=True, help="Folder for the results, or the name of the .npz file.")
def run(
    file: str,
    t_end: float,
    rtol: float,
    output: int | None,
    viewed: bool,
    reported: bool,
    drop: tuple[str, ...],
    out: str,
) -> None:
    """Simulate a mechanism.

    FILE is a model file (.json, .toml), a model of MuJoCo (.xml) or ROS (.urdf), or a Python file with build(), which
    returns a System. Writes a solution (.npz, read by mbsd3d.load), a table (.csv) and a figure of the energies. Ctrl-C
    keeps the samples so far. The exit code is 1 if the certificate fails.
    """
    can_view(needed=viewed)
    system = load_system(file, drop)
    target = ready_target(file, out, ".npz")
    from ..api.simulation import simulate
    from ..base.errors import IntegrationError
    from ..plotting.plots import save_figure

    try:
        solution = simulate(system, t_end, rtol=rtol, output=output)
    except IntegrationError as error:
        keep(error.solution, target)
        raise
    if (solution.record.stopped_by or "").startswith("interrupted"):
        click.echo(f"mbsd3d: {solution.record.stopped_by}", err=True)
        keep(solution, target)
        raise click.exceptions.Exit(INTERRUPTED)
    for path in (solution.save(target), solution.to_csv(target), *save_figure(solution.plot("energy"), target)):
        click.echo(str(path))
    if viewed:
        click.echo(str(solution.animate(title=target.name).save(target)))
    if reported:
        page = solution.report(title=target.name).save(target.with_name(f"{target.name}_report"))
        click.echo(str(page))
    click.echo(str(solution.certificate))
    if not solution.certificate.passed:
        raise click.exceptions.Exit(1)
