"""Command ``mbsd3d demo``: effects that exist only in space, compared with theory."""

import time
from typing import TYPE_CHECKING

import click
from click.core import ParameterSource

from .support import Failure, can_view, out_option, ready_folder, watch
from .warmup import compile_all

if TYPE_CHECKING:
    from ..demos.base import Outcome, Row
    from ..demos.form import Demo


@click.command()
@click.argument("name", required=False)
@click.option("--all", "everything", is_flag=True, help="Run all demos.")
@click.option("--list", "only_list", is_flag=True, help="List the demos (as without arguments).")
@click.option("--set", "changes", multiple=True, metavar="NAME=VALUE", help="Change a parameter; values are JSON.")
@click.option("--without", metavar="TERM", help="Leave out a term, e.g. gyroscopic, and see what is lost.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object; no files unless --out is given.")
@click.option("--view", "watched", is_flag=True, help="Show its motion in the browser, until Ctrl-C.")
@out_option
@click.pass_context
def demo(
    context: click.Context,
    name: str | None,
    everything: bool,
    only_list: bool,
    changes: tuple[str, ...],
    without: str | None,
    as_json: bool,
    watched: bool,
    out: str,
) -> None:
    """Show an effect that exists only in space.

    Prints computed numbers beside their theory; figure, data and a page that shows the motion go to --out.
    """
    from ..demos.discovery import discover
    from ..demos.parameters import settings
    from ..demos.report import contents, summary

    demos = discover()
    for broken, reason in demos.broken.items():
        click.echo(f"mbsd3d: demo '{broken}' of {reason}", err=True)
    if name and (everything or only_list):
        raise Failure(f"a name ('{name}') and --all or --list exclude each other; give one")
    for given, option in ((watched, "--view"), (changes, "--set"), (without, "--without"), (as_json, "--json")):
        if given and not name:
            raise Failure(f"{option} {'shows' if watched else 'is for'} one demo; give its name")
    if only_list or not (name or everything):
        click.echo(contents(demos.families()))
        return
    if name:
        shown = demos.find(name)
        values = settings(changes)
        silent = as_json and context.get_parameter_source("out") is ParameterSource.DEFAULT
        outcome = run_one(shown, without, values, None if silent else out, as_json, watched)
        failed = [] if outcome.passed or without else [shown.name]
        if watched:
            watch_demo(outcome, shown.name)
    else:
        rows = run_all(list(demos), out)
        failed = [key for key, found in rows.items() if not all(row.passed for row in found)]
        click.echo(summary(rows))
    if failed:
        click.echo(f"mbsd3d: theory is not met by {', '.join(failed)}", err=True)
        raise click.exceptions.Exit(1)


def run_one(
    shown: "Demo", without: str | None, values: dict[str, object], out: str | None, as_json: bool, watched: bool
) -> "Outcome":
    """Run a demo, print its table (or object), and write its files if there is a folder for them."""
    from ..demos.report import listing, report, to_json, write

    pages = out is not None and can_view(needed=watched)
    folder = None if out is None else ready_folder(out)
    outcome = shown.run(without, **values)
    click.echo(to_json(shown, outcome, without) if as_json else report(shown, outcome, without))
    if folder is not None:
        written = listing(write(shown, outcome, folder, pages=pages, without=without))
        click.echo(f"{written}\n", err=as_json)
    return outcome


def run_all(names: list[str], out: str) -> "dict[str, tuple[Row, ...]]":
    """Run all demos, by two processes where there are two cores; return their rows in the order of the list."""
    from concurrent.futures import as_completed

    from ..demos.report import run_and_write
    from .workers import working

    pages = can_view()
    folder, began, rows = ready_folder(out), time.perf_counter(), {}
    click.echo("mbsd3d: compiling kernels that are not yet ...", err=True)
    compile_all()
    with working(2) as pool:
        tasks = {pool.submit(run_and_write, name, folder, pages): name for name in names}
        for k, task in enumerate(as_completed(tasks)):
            text, rows[tasks[task]] = task.result()
            click.echo(text)
            spent = time.perf_counter() - began
            click.echo(f"mbsd3d: demo {k + 1} of {len(names)}, {tasks[task]}, after {spent:.0f} s", err=True)
    return {name: rows[name] for name in names}


def watch_demo(outcome: "Outcome", name: str) -> None:
    """Serve the first view of a demo until Ctrl-C."""
    if not outcome.views:
        raise Failure(f"demo '{name}' has no view")
    solution, options = next(iter(outcome.views.values()))
    watch(solution.animate(live=True, **options))
