"""Command ``mbsd3d validate``: a model of the user's, or every case, against other engines and closed forms."""

import json
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mbsd3d.errors import InputError
from mbsd3d.extend import INTERRUPT_EXIT_CODE, load_system, ready_folder, write_atomically

if TYPE_CHECKING:
    from validation.suite.suite import Suite

ENGINES = ("mujoco", "exudyn", "definitions")  # of crosscheck.check, which is imported when it is needed
SUITE_OPTIONS = ("quick", "names", "only_list", "fresh", "out")
"""Options of the suite of all cases; the others are those of MODEL."""
DIFFERENCE_EXIT_CODE = 1  # exit code
OUT_FOLDER = "out/validation"
BUDGET_SECONDS = {True: 0.2, False: 2.0}  # [s] of an engine for a case: of the short list, of the long one


@click.command(epilog="Example: mbsd3d validate door.toml --t-end 2 --html door.html")
@click.argument("model", required=False)
@click.option("--t-end", type=float, help="MODEL: end of the comparison [s].  [default: 1]")
@click.option(
    "--engine", "engines", multiple=True, type=click.Choice(ENGINES),
    help="MODEL: compare with this one only; may be given more than once.  [default: all]",
)  # fmt: skip
@click.option("--tolerance", type=float, help="MODEL: relative difference that counts as agreement.  [default: 1e-6]")
@click.option("--budget", type=float, help="MODEL: processor seconds for the runs of an engine.  [default: 10]")
@click.option("--json", "json_file", type=click.Path(), metavar="FILE", help="MODEL: write the findings to this file.")
@click.option(
    "--html", "html_file", type=click.Path(), metavar="FILE", help="MODEL: write a page to this file (offline)."
)
@click.option(
    "--leave-out",
    "--drop",
    "drop",
    multiple=True,
    metavar="KIND,...",
    help="MODEL: leave out parts that act and cannot be imported (.xml, .urdf), e.g. fluid,tendon.",
)
@click.option(
    "--set", "changes", multiple=True, metavar="NAME=VALUE", help="MODEL: a parameter of build(...) of a Python file."
)
@click.option("--quick", is_flag=True, help="Cases: the short list, in less than a minute.")
@click.option(
    "--case", "names", multiple=True, metavar="NAME", help="Cases: only this one (or a pattern); may be repeated."
)
@click.option("--list", "only_list", is_flag=True, help="Cases: list them and exit.")
@click.option("--fresh", is_flag=True, help="Cases: discard the results of an interrupted run.")
@click.option("--out", help="Cases: folder for the report, made if missing.  [default: out/validation]")
def validate(model: str | None, **options: Any) -> None:
    """Compare MODEL, or every reference case, with MuJoCo and Exudyn.

    MODEL is a model file (.json, .toml), a model of MuJoCo (.xml) or ROS (.urdf), or a Python file with build(), which
    returns a System. Mass matrix, accelerations, motion, energies, momenta and reactions are compared, each engine at
    ever shorter steps. The exit code is 1 if anything differs without a proven cause, or if no engine could compare.
    The engines: pip install 'mbsd3d[validation]'.

    Without MODEL all cases are compared with theory, the planar solver, their definitions and the engines; the report
    is a page (.html) and its numbers (.json). An interrupted run continues with the same command. The exit code is 1
    if anything differs without a proven cause.
    """
    given = {name: value for name, value in options.items() if value is not None and value is not False and value != ()}
    wrong = [name for name in given if (name in SUITE_OPTIONS) == (model is not None)]
    if wrong:
        option = next(x.opts[0] for x in click.get_current_context().command.params if x.name == wrong[0])
        raise InputError(f"{option} is for {'all cases; leave it or MODEL out' if model else 'a MODEL; give one'}")
    if model is None:
        validate_all(**given)
    else:
        validate_model(model, **given)


def validate_model(
    model: str, json_file: str | None = None, html_file: str | None = None, drop: tuple[str, ...] = (),
    changes: tuple[str, ...] = (), t_end: float = 1.0, **settings: Any,
) -> None:  # fmt: skip
    """Compare a model of any kind, print the table, write the requested files; exit code 1 if it has not passed."""
    from validation.crosscheck import cross_check

    for option, target in {"--json": json_file, "--html": html_file}.items():
        if target is not None:
            ready_folder(str(Path(target).parent), option)
            if Path(target).is_dir():
                raise InputError(f"{option} '{target}' is a folder; give a file in it")
    check = cross_check(load_system(model, drop, changes), t_end, **settings)
    click.echo(check.table())
    if json_file:
        text = json.dumps({"model": Path(model).name, **check.to_dict()}, indent=1, ensure_ascii=False, allow_nan=False)
        write(json_file, f"{text}\n")
    if html_file:
        from validation.crosscheck.page import page

        write(html_file, page(check, Path(model).stem))
    for failure in check.failures:
        click.echo(f"mbsd3d: {failure}", err=True)
    if check.interrupted or not check.passed:
        raise click.exceptions.Exit(INTERRUPT_EXIT_CODE if check.interrupted else DIFFERENCE_EXIT_CODE)


def write(file: str, text: str) -> None:
    """Write a text file, whole or not at all, and print its path."""
    write_atomically(Path(file), text.encode())
    click.echo(file)


def validate_all(
    *,
    out: str = OUT_FOLDER,
    names: tuple[str, ...] = (),
    quick: bool = False,
    fresh: bool = False,
    only_list: bool = False,
) -> None:
    """Run the suite, show and write its findings; exit code 1 if something differs, 130 after Ctrl-C."""
    from validation.suite.suite import Suite, store
    from validation.suite.trials import chosen, trials

    found = chosen(trials(quick), names)
    if only_list:
        width = max(len(trial.name) for trial in found)
        click.echo("\n".join(f"{trial.name:{width}}  {trial.title}" for trial in found))
        return
    folder, budget = ready_folder(out), BUDGET_SECONDS[quick]
    with closing(store(folder, fresh, budget=budget)) as kept:
        judge(Suite(found, kept, quick, budget), folder)


def judge(suite: "Suite", folder: Path) -> None:
    """Run a suite and report its end."""
    if suite.records:
        kept = f"{len(suite.records)} of {len(suite.trials)} cases are in {suite.store.path}"
        click.echo(f"mbsd3d: {kept}; --fresh forgets them", err=True)
    try:
        suite.run()
    except KeyboardInterrupt:
        show(suite, folder)
        click.echo(f"mbsd3d: interrupted, {len(suite.left)} cases are left; the same command goes on", err=True)
        raise click.exceptions.Exit(INTERRUPT_EXIT_CODE) from None
    show(suite, folder)
    if suite.failed:
        click.echo(f"mbsd3d: {', '.join(record.name for record in suite.failed)} differ", err=True)
        raise click.exceptions.Exit(DIFFERENCE_EXIT_CODE)


def show(suite: "Suite", folder: Path) -> None:
    """Print the table, and write the files to the folder."""
    from validation.suite.findings import table

    if suite.records:
        click.echo(table(suite.records))
    for path in suite.write(folder):
        click.echo(str(path))
