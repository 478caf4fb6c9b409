"""``mbsd3d demo``: effects that exist only in space, beside their theory."""

import time
from typing import TYPE_CHECKING

import click

from .support import Failure, can_view, out_option, ready_folder, watch

if TYPE_CHECKING:
    from ..demos.base import Outcome


@click.command()
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
    for k, shown in enumerate(demos.values() if everything else [demos[key]]):
        began = time.perf_counter()
        if everything:
            click.echo(f"mbsd3d: demo {k + 1} of {len(demos)}, {shown.name} ...", err=True)
        outcome = shown.run()
        click.echo(report(shown, outcome))
        click.echo(f"{listing(write(shown, outcome, folder, pages=pages))}\n")
        if everything:
            click.echo(f"mbsd3d: {shown.name} took {time.perf_counter() - began:.1f} s", err=True)
        failed += [] if outcome.passed else [shown.name]
    if watched:
        watch_demo(outcome, shown.name)
    if failed:
        click.echo(f"mbsd3d: theory is not met by {', '.join(failed)}", err=True)
        raise click.exceptions.Exit(1)


def watch_demo(outcome: "Outcome", name: str) -> None:
    """Serve the first view of a demo until Ctrl-C."""
    if not outcome.views:
        raise Failure(f"demo '{name}' has no view")
    solution, options = next(iter(outcome.views.values()))
    watch(solution.animate(live=True, **options))
