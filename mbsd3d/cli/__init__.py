"""The command line: demos, checking and running models, warming up. Nothing heavy is imported before it is needed."""

import time
from typing import Any

import click

from .support import INTERRUPTED, Commands, Failure, can_view, keep, load, ready_folder, ready_target, watch


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
def main() -> None:
    """Spatial multibody dynamics: demos, checks and runs of mechanisms."""


out_option = click.option("--out", default="out", show_default=True, help="Folder for the results; made if missing.")


@main.command()
@click.argument("name", required=False)
@click.option("--all", "everything", is_flag=True, help="Run all demos.")
@click.option("--list", "only_list", is_flag=True, help="List the demos (as without arguments).")
@click.option("--view", "watched", is_flag=True, help="Show its motion in the browser, until Ctrl-C.")
@out_option
def demo(name: str | None, everything: bool, only_list: bool, watched: bool, out: str) -> None:
    """Show an effect that exists only in space.

    Prints computed numbers beside their theory; figure, data and a page that shows the motion go to --out.
    """
    from ..demos.base import discover
    from ..demos.report import listing, report, write

    demos = discover()
    for broken, reason in demos.broken.items():
        click.echo(f"mbsd3d: demo '{broken}' of {reason}", err=True)
    key = name and name.replace("-", "_")
    if key and (everything or only_list):
        raise Failure(f"a name ('{name}') and --all or --list exclude each other; give one")
    if watched and not key:
        raise Failure("--view shows one demo; give its name")
    if key and key not in demos:
        raise Failure(f"there is no demo '{name}'; there are {', '.join(demos)}")
    if only_list or not (key or everything):
        width = max(map(len, demos))
        click.echo("\n".join(f"{demo.name:{width}}  {demo.title}" for demo in demos.values()))
        return
    pages = can_view(needed=watched)
    folder, failed = ready_folder(out), []
    for shown in demos.values() if everything else [demos[key]]:
        outcome = shown.run()
        click.echo(report(shown, outcome))
        click.echo(f"{listing(write(shown, outcome, folder, pages=pages))}\n")
        failed += [] if outcome.passed else [shown.name]
    if watched:
        watch_demo(outcome, shown.name)
    if failed:
        click.echo(f"mbsd3d: theory is not met by {', '.join(failed)}", err=True)
        raise click.exceptions.Exit(1)


def watch_demo(outcome: Any, name: str) -> None:
    """Serve the first view of a demo until Ctrl-C."""
    if not outcome.views:
        raise Failure(f"demo '{name}' has no view")
    solution, options = next(iter(outcome.views.values()))
    watch(solution.animate(live=True, **options))


drop_option = click.option(
    "--drop", multiple=True, metavar="KIND", help="Leave out what cannot be imported (.xml, .urdf), e.g. contact."
)


@main.command()
@click.argument("file")
@drop_option
def check(file: str, drop: tuple[str, ...]) -> None:
    """Find the freedoms and redundant joints of a mechanism.

    FILE is a model file (.json, .toml), a model of MuJoCo (.xml) or ROS (.urdf), or a Python file with build(), which
    returns a System. The exit code is 1 if it is locked or cannot close.
    """
    diagnosis = load(file, drop).check()
    click.echo(str(diagnosis))
    if diagnosis.verdict.startswith(("locked", "cannot close")):
        raise click.exceptions.Exit(1)


@main.command()
@click.argument("file")
@click.option("--t-end", type=float, required=True, help="End of the run [s].")
@click.option("--rtol", type=float, default=1e-8, show_default=True, help="Local relative error of a step.")
@click.option("--output", type=int, help="Number of equally spaced samples; without it every step.")
@click.option("--view", "viewed", is_flag=True, help="Write a page (.html) too that shows the motion.")
@click.option(
    "--report", "reported", is_flag=True, help="Write a report (_report.html) too: certificate, tables, curves."
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
    keeps what was computed. The exit code is 1 if the certificate fails.
    """
    can_view(needed=viewed)
    system = load(file, drop)
    target = ready_target(file, out, ".npz")
    from ..base.errors import IntegrationError
    from ..plotting.plots import save_figure
    from ..run.simulation import simulate

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


@main.command()
@click.argument("file")
@drop_option
@click.option("--out", default="out", show_default=True, help="Folder for the page, or the name of the .html file.")
def show(file: str, drop: tuple[str, ...], out: str) -> None:
    """Draw a mechanism at its reference pose.

    FILE is a model file (.json, .toml), a model of MuJoCo (.xml) or ROS (.urdf), or a Python file with build(), which
    returns a System. Writes one page (.html) that needs no network.
    """
    can_view(needed=True)
    system = load(file, drop)
    target = ready_target(file, out, ".html")
    click.echo(str(system.show(title=target.name).save(target)))


@main.command()
def warmup() -> None:
    """Compile all kernels, so that nothing else has to wait."""
    from .warmup import compile_all

    began = time.perf_counter()
    compile_all()
    click.echo(f"all kernels are compiled ({time.perf_counter() - began:.1f} s)")


@main.command()
def version() -> None:
    """Print the version."""
    from .. import __version__

    click.echo(f"mbsd3d {__version__}")
