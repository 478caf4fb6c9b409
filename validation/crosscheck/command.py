"""``mbsd3d validate MODEL``."""

import json
from pathlib import Path

import click

from mbsd3d.extend import INTERRUPTED, load_system, ready_folder, write_atomically
from validation.crosscheck.check import BUDGET, ENGINES, cross_check


def validate_model(
    model: str,
    *,
    t_end: float = 1.0,
    engines: tuple[str, ...] = ENGINES,
    tolerance: float = 1e-6,
    budget: float = BUDGET,
    json_file: str | None = None,
    html_file: str | None = None,
    drop: tuple[str, ...] = (),
) -> None:
    """Compare a model of any kind, print the table, write what was asked for; exit code 1 if it has not passed."""
    for option, target in {"--json": json_file, "--html": html_file}.items():
        if target is not None:
            ready_folder(str(Path(target).parent), option)
            if Path(target).is_dir():
                raise ValueError(f"{option} '{target}' is a folder; give a file in it")
    check = cross_check(load_system(model, drop), t_end, engines=engines, tolerance=tolerance, budget=budget)
    click.echo(check.table())
    if json_file:
        text = json.dumps({"model": Path(model).name, **check.to_dict()}, indent=1, ensure_ascii=False, allow_nan=False)
        write(json_file, f"{text}\n")
    if html_file:
        from validation.crosscheck.page import page

        write(html_file, page(check, Path(model).stem))
    for failure in check.failures:
        click.echo(f"mbsd3d: {failure}", err=True)
    if check.interrupted:
        raise click.exceptions.Exit(INTERRUPTED)
    if not check.passed:
        raise click.exceptions.Exit(1)


def write(file: str, text: str) -> None:
    """A text file, whole or not at all; says where it is."""
    write_atomically(Path(file), text.encode())
    click.echo(file)
