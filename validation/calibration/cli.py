"""``python -m validation.calibration``: thousands of runs with known truth, and what the certificate says of them."""

import os
import sys
from pathlib import Path
from typing import Any

import click

from mbsd3d.errors import InputError
from mbsd3d.extend import INTERRUPTED, Failure, ready_folder, write_atomically

RUNS = 2100
LINES, TABLE = "calibration.jsonl", "calibration.txt"


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.option("--runs", default=RUNS, show_default=True, type=click.IntRange(1), help="How many; families take turns.")
@click.option(
    "--seed", default=0, show_default=True, type=click.IntRange(0), help="Of the first run; the next have the next."
)
@click.option("--family", "names", multiple=True, metavar="NAME", help="Only this one, repeatable; --list shows them.")
@click.option("--list", "listed", is_flag=True, help="Names of the families, and nothing else.")
@click.option(
    "--out", type=click.Path(file_okay=False, path_type=Path), default=Path("out/calibration"), show_default=True,
    help="Folder for the runs, one a line, as they end; runs that are there already are not made again.",
)  # fmt: skip
@click.option("--fresh", is_flag=True, help="Make all runs again.")
@click.option("--jobs", default=os.cpu_count() or 1, show_default=True, type=click.IntRange(1), help="Processes.")
@click.option("--docs", is_flag=True, help="Write the table into docs/theory/certificate.md.")
def main(runs: int, seed: int, names: tuple, listed: bool, out: Path, fresh: bool, jobs: int, docs: bool) -> None:
    """Compare runs with their truth, over all methods, tolerances and steps, and count what certificate and estimate say.

    Nothing is to be wrong by more than a hundredth of its scale without a warning, nothing to fail that is right to ten
    times its tolerance. All runs take some minutes.
    """
    try:
        calibrate(runs, seed, names, listed, out, fresh, jobs, docs)
    except ValueError as error:
        raise Failure(str(error)) from None


def calibrate(runs: int, seed: int, names: tuple, listed: bool, out: Path, fresh: bool, jobs: int, docs: bool) -> None:
    """See `main`."""
    from validation.calibration import table
    from validation.calibration.families import FAMILIES

    unknown = [name for name in names if name not in FAMILIES]
    if unknown:
        raise InputError(f"family {unknown[0]!r} is unknown; give one of {', '.join(FAMILIES)}")
    if listed:
        click.echo("\n".join(FAMILIES))
        return
    ready_folder(str(out), "--out")
    records, complete = collect(wanted(runs, seed, names or tuple(FAMILIES)), out / LINES, fresh, jobs)
    lines = [*table.offenders(records), table.text(records)]
    click.echo("\n".join(lines))
    write_atomically(out / TABLE, ("\n".join(lines) + "\n").encode())
    if not complete:
        click.echo(f"\ninterrupted; {len(records)} runs are in {out / LINES}, the same command goes on", err=True)
        sys.exit(INTERRUPTED)
    if docs:
        from validation.calibration.texts import renew

        renew(records)


def wanted(runs: int, seed: int, names: tuple) -> list[tuple[str, int]]:
    """(family, seed) of every run."""
    return [(names[k % len(names)], seed + k // len(names)) for k in range(runs)]


def collect(cases: list[tuple[str, int]], path: Path, fresh: bool, jobs: int) -> tuple[list[Any], bool]:
    """(records, whether all are there): those of the file, and the others, appended to it one by one."""
    from validation.calibration.runs import code_digest, examined, stored

    if fresh:
        path.unlink(missing_ok=True)
    done = stored(path, code_digest())
    missing = [case for case in cases if case not in done]
    try:
        for record in examined(missing, path, jobs):
            done[record.family, record.seed] = record
            note(len(cases) - len(missing), len(cases), record)
            missing = missing[1:] if missing else missing
    except KeyboardInterrupt:
        return [done[case] for case in cases if case in done], False
    return [done[case] for case in cases], True


def note(k: int, count: int, record: Any) -> None:
    """What has just been done."""
    if sys.stderr.isatty():
        click.echo(f"\r\x1b[2K{k + 1}/{count} {record.family}", nl=False, err=True)
    elif (k + 1) % 100 == 0:
        click.echo(f"{k + 1}/{count}", err=True)
