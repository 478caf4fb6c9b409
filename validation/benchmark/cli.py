"""Command ``python -m validation.benchmark``: work against precision, redundancy against peers, and the speed of
mbsd3d.
"""

import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from mbsd3d.errors import InputError
from mbsd3d.extend import INTERRUPT_EXIT_CODE, Failure, ready_folder, write_atomically

PARTS = ("precision", "redundancy", "speed")
LEDGER, DATA, TEXT, FIGURE = "precision.db", "precision.json", "precision.txt", "work_precision"
SPEED = "speed.json"


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.option(
    "--part", "parts", multiple=True, type=click.Choice(PARTS), help="Parts to measure; repeatable; default: all."
)
@click.option(
    "--mechanism", "names", multiple=True, metavar="NAME", help="Only this one, repeatable; --list shows them."
)
@click.option("--list", "listed", is_flag=True, help="Names of the mechanisms, and nothing else.")
@click.option(
    "--out", type=click.Path(file_okay=False, path_type=Path), default=Path("out/benchmark"), show_default=True,
    help="Folder for precision.json, precision.txt, speed.json and the figure; an interrupted run goes on from there.",
)  # fmt: skip
@click.option("--fresh", is_flag=True, help="Start again instead of continuing an interrupted run.")
@click.option(
    "--stored", is_flag=True, help="Measure nothing: draw table and figure from the results of an earlier run in --out."
)
@click.option(
    "--pictures", type=click.Path(file_okay=False, path_type=Path), help="Also write the figure to this file."
)
def main(parts: tuple, names: tuple, listed: bool, out: Path, fresh: bool, stored: bool, pictures: Path | None) -> None:
    """Measure speed: error against run time of mbsd3d, MuJoCo and Exudyn, redundant rows, and mbsd3d alone.

    All engines run in turns, in one process and on one thread, each with the best of the settings that are tried.
    Trust ratios, not times, and only those of an idle machine. Everything takes less than ten minutes.
    """
    try:
        run(parts or (("precision",) if names or stored else PARTS), names, listed, out, fresh, stored, pictures)
    except ValueError as error:
        raise Failure(str(error)) from None


def run(parts: tuple, names: tuple, listed: bool, out: Path, fresh: bool, stored: bool, pictures: Path | None) -> None:
    """Run the parts of the benchmark; see `main`."""
    from validation.benchmark.problems import PROBLEMS

    unknown = [name for name in names if name not in PROBLEMS]
    if unknown:
        raise InputError(f"mechanism {unknown[0]!r} is unknown; give one of {', '.join(PROBLEMS)}")
    if listed:
        click.echo("\n".join(PROBLEMS))
        return
    if stored:
        from validation.benchmark.precision import load

        ready(out, pictures)
        show(load(out / DATA), out, pictures)
        return
    # its build without range checks, which is what one measures; read at its first import
    vars(sys)["exudynFast"] = True
    if "precision" in parts:
        precision(names or tuple(PROBLEMS), out, fresh, pictures)
    if "redundancy" in parts:
        from validation.benchmark.counts import report

        click.echo("\n" + "\n".join(report()))
    if "speed" in parts:
        from validation.benchmark import speed

        ready_folder(str(out), "--out")
        speed.main(out / SPEED)


def precision(names: tuple, out: Path, fresh: bool, pictures: Path | None) -> None:
    """Measure problems one by one, storing after each; Ctrl-C keeps what there is."""
    from mbsd3d.extend import Store
    from validation.benchmark.precision import PACKAGES, from_dict, identity, measure, save
    from validation.benchmark.problems import PROBLEMS
    from validation.machine import machine

    ready(out, pictures)
    store, where = Store(out / LEDGER, identity(), "benchmark", replace=True), machine(*PACKAGES)
    if fresh:
        store.clear()
    rows = [from_dict(row) for row in store.all().values()]
    if rows:
        click.echo(f"going on with {store.path}: {len(rows)} measured (--fresh begins anew)", err=True)
    try:
        for k, name in enumerate(names):
            if name in {row.name for row in rows}:
                continue
            click.echo(f"{k + 1}/{len(names)} {name} ...", err=True)
            rows.append(measure(PROBLEMS[name](), note))
            store.put(name, asdict(rows[-1]))
    except KeyboardInterrupt:
        save(out / DATA, rows, where, complete=False)
        click.echo(f"\ninterrupted; {len(rows)} problems are in {store.path}, the same command goes on", err=True)
        show(rows, out, pictures)
        sys.exit(INTERRUPT_EXIT_CODE)
    save(out / DATA, rows, where, complete=True)
    store.clear()
    click.echo(where)
    show(rows, out, pictures)


def ready(out: Path, pictures: Path | None) -> None:
    """Check that the folders can be written, before anything is measured."""
    for option, folder in {"--out": out, "--pictures": pictures}.items():
        if folder:
            ready_folder(str(folder), option)


def note(text: str) -> None:
    """Print what is being measured."""
    if sys.stderr.isatty():
        click.echo(f"\r\x1b[2K    {text}", nl=False, err=True)


def show(rows: list[Any], out: Path, pictures: Path | None) -> None:
    """Print and write the rows."""
    from mbsd3d import save_figure
    from validation.benchmark.tables import FIGURE_PROBLEMS, report, work_precision

    if not rows:
        return
    lines = report(rows)
    click.echo("\n".join(lines))
    write_atomically(out / TEXT, ("\n".join(lines) + "\n").encode())
    if any(row.name in FIGURE_PROBLEMS for row in rows):
        for folder in filter(None, (out, pictures)):
            save_figure(work_precision(rows), folder / FIGURE)
