"""Command ``mbsd3d demo``: effects that exist only in space, compared with theory."""

import ast
import time
from collections.abc import Iterator
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import click
from click.core import ParameterSource

from ..base.errors import InputError
from .support import Failure, can_view, out_option, ready_folder, watch
from .warmup import compile_all

if TYPE_CHECKING:
    from ..demos.base import Outcome, Row
    from ..demos.discovery import Demos
    from ..demos.form import Demo

DEMOS = "mbsd3d.demos"  # the package, and the entry points of other packages


@click.command(epilog="Example: mbsd3d demo helicopter_90 --set Omega=30 --view")
@click.argument("name", required=False)
@click.option("--all", "everything", is_flag=True, help="Run all demos.")
@click.option("--list", "only_list", is_flag=True, help="List the demos (as without arguments).")
@click.option("--set", "changes", multiple=True, metavar="NAME=VALUE", help="Change a parameter; values are JSON.")
@click.option("--without", metavar="TERM", help="Leave out a term, e.g. gyroscopic, to see its effect.")
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
    if name and (everything or only_list):
        raise Failure(f"a name ('{name}') and --all or --list exclude each other; give one")
    for given, option in ((watched, "--view"), (changes, "--set"), (without, "--without"), (as_json, "--json")):
        if given and not name:
            raise Failure(f"{option} {'shows' if watched else 'is for'} one demo; give its name")
    if only_list or not (name or everything):
        list_demos()
        return
    from ..demos.discovery import discover
    from ..demos.parameters import settings
    from ..demos.report import summary

    demos = discover()
    say_broken(demos)
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


def say_broken(demos: "Demos") -> None:
    """Name the demos of other packages that could not be loaded."""
    for broken, reason in demos.broken.items():
        click.echo(f"mbsd3d: demo '{broken}' of {reason}", err=True)


def list_demos() -> None:
    """Print all demos by family, each with its question."""
    try:
        questions = read_questions()
    except (ValueError, ImportError, OSError, SyntaxError):  # of another package: its import says what is wrong
        from ..demos.discovery import discover

        demos = discover()
        say_broken(demos)
        questions = [Question(demo.family, demo.name, demo.question) for demo in demos.values()]
    click.echo(contents(questions))


class Question(NamedTuple):
    """A demo as it is listed."""

    family: str
    name: str
    question: str


def contents(questions: list[Question]) -> str:
    """Return demos by family, each with its question."""
    width = max((len(demo.name) for demo in questions), default=0)
    families: dict[str, list[str]] = {}
    for demo in questions:
        families.setdefault(demo.family, []).append(f"  {demo.name:{width}}  {demo.question}")
    return "\n\n".join("\n".join([f"{family}:", *lines]) for family, lines in families.items())


def read_questions() -> list[Question]:
    """Return all demos from their sources, in the order of `discover`; importing them takes two seconds.

    ValueError where a source does not say them as plain text.
    """
    packages = [DEMOS, *(entry.value for entry in metadata.entry_points(group=DEMOS))]
    return [found for package in packages for found in questions_of(folder_of(package))]


def folder_of(package: str) -> Path:
    """Return the folder of a package that is not imported."""
    spec = find_spec(package)
    if spec is None or not spec.submodule_search_locations:
        raise InputError(f"the sources of package '{package}' are not found; repair or remove it")
    return Path(spec.submodule_search_locations[0])


def questions_of(folder: Path) -> Iterator[Question]:
    """Yield the demos of a package and of the packages in it, those by their PLACE."""
    family = (ast.get_docstring(parsed(folder)) or "").partition("\n")[0].rstrip(".")
    for path in sorted(folder.glob("[!_]*.py")):
        demo = assigned(parsed(path)).get("demo")
        if isinstance(demo, ast.Call):
            text = next((given.value for given in demo.keywords if given.arg == "question"), None)
            yield Question(family, path.stem, ast.literal_eval(text) if text else "")
    inner = sorted(found.parent for found in folder.glob("*/__init__.py"))
    for package in sorted(inner, key=place_of):
        yield from questions_of(package)


def place_of(folder: Path) -> int:
    """Return the place of a family among the others."""
    place = assigned(parsed(folder)).get("PLACE")
    return int(ast.literal_eval(place)) if place else 0


def parsed(path: Path) -> ast.Module:
    """Return the syntax tree of a module, or of a package by its folder."""
    return ast.parse((path / "__init__.py" if path.is_dir() else path).read_text(encoding="utf-8"))


def assigned(module: ast.Module) -> dict[str, ast.expr]:
    """Return what a module assigns to single names."""
    return {
        line.targets[0].id: line.value
        for line in module.body
        if isinstance(line, ast.Assign) and isinstance(line.targets[0], ast.Name)
    }


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
