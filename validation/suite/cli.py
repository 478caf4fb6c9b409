"""``mbsd3d validate`` without a model: all cases, the table on the screen, page and JSON in a folder."""

from typing import Any

import click

from mbsd3d.extend import INTERRUPTED, ready_folder

DIFFERENT = 1  # exit code
OUT = "out/validation"
BUDGETS = {True: 0.2, False: 2.0}  # s of an engine for a case: of the short list, of the long one


def validate_all(
    *, out: str = OUT, names: tuple[str, ...] = (), quick: bool = False, fresh: bool = False, only_list: bool = False
) -> None:
    """Run the suite, show and write what it found; exit code 1 if something differs, 130 after Ctrl-C."""
    from .ledger import Ledger, identity
    from .listing import chosen, trials
    from .suite import Suite

    if only_list:
        list_cases(quick)
        return
    everything = chosen(trials(quick), names)
    folder = ready_folder(out)
    budget = BUDGETS[quick]
    suite = Suite(everything, Ledger(folder, identity(budget=budget), fresh), quick, budget)
    if suite.records:
        kept = f"{len(suite.records)} of {len(everything)} cases are in {suite.ledger.path}"
        click.echo(f"mbsd3d: {kept}; --fresh forgets them", err=True)
    try:
        suite.run()
    except KeyboardInterrupt:
        show(suite, folder)
        click.echo(f"mbsd3d: interrupted, {len(suite.left)} cases are left; the same command goes on", err=True)
        raise click.exceptions.Exit(INTERRUPTED) from None
    show(suite, folder)
    if suite.failed:
        click.echo(f"mbsd3d: {', '.join(record.name for record in suite.failed)} differ", err=True)
        raise click.exceptions.Exit(DIFFERENT)


def show(suite: Any, folder: Any) -> None:
    """Table on the screen, files in the folder."""
    from .table import text

    if suite.records:
        click.echo(text(suite.records))
    for path in suite.write(folder):
        click.echo(str(path))


def list_cases(quick: bool) -> None:
    """Names and titles of all cases."""
    from .listing import trials

    found = trials(quick)
    width = max(len(trial.name) for trial in found)
    click.echo("\n".join(f"{trial.name:{width}}  {trial.title}" for trial in found))
