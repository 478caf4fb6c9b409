"""Command ``python -m validation.calibration``: thousands of runs with known truth against their certificates."""

import sys
from pathlib import Path
from typing import Any

import click

from mbsd3d import SweepError
from mbsd3d.errors import InputError
from mbsd3d.extend import INTERRUPT_EXIT_CODE, Failure, Progress, ready_folder, write_atomically

RUN_COUNT = 2100
RECORD_FILE, TABLE_FILE = "calibration.jsonl", "calibration.txt"


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.option(
    "--runs", default=RUN_COUNT, show_default=True, type=click.IntRange(1), help="How many; families take turns."
)
@click.option("--seed", default=0, show_default=True, type=click.IntRange(0), help="First seed; the next runs add one.")
@click.option("--family", "names", multiple=True, metavar="NAME", help="Only this one, repeatable; --list shows them.")
@click.option("--list", "listed", is_flag=True, help="Names of the families, and nothing else.")
@click.option(
    "--out", type=click.Path(file_okay=False, path_type=Path), default=Path("out/calibration"), show_default=True,
    help="Folder for the runs, one per line, as they finish; runs that are stored there are not repeated.",
)  # fmt: skip
@click.option("--fresh", is_flag=True, help="Make all runs again.")
@click.option("--docs", is_flag=True, help="Write the table into docs/theory/certificate.md.")
def main(runs: int, seed: int, names: tuple, listed: bool, out: Path, fresh: bool, docs: bool) -> None:
    """Compare runs with their truth, over all methods and tolerances, and count the statements of certificate and
    estimate.

    Nothing is to be wrong by more than a hundredth of its scale without a warning, nothing to fail that is right to ten
    times its tolerance. All runs take some minutes.
    """
    try:
        calibrate(runs, seed, names, listed, out, fresh, docs)
    except (ValueError, SweepError) as error:
        raise Failure(str(error)) from None


def calibrate(runs: int, seed: int, names: tuple, listed: bool, out: Path, fresh: bool, docs: bool) -> None:
    """Run the calibration; see `main`."""
    from validation.calibration import table
    from validation.calibration.families import FAMILIES
    from validation.calibration.judge import cases
    from validation.calibration.texts import renew

    unknown = [name for name in names if name not in FAMILIES]
    if unknown:
        raise InputError(f"family {unknown[0]!r} is unknown; give one of {', '.join(FAMILIES)}")
    if listed:
        click.echo("\n".join(FAMILIES))
        return
    ready_folder(str(out), "--out")
    wanted = cases(runs, seed, names or tuple(FAMILIES))
    records = collect(wanted, out / RECORD_FILE, fresh)
    lines = [*table.offenders(records), table.text(records)]
    click.echo("\n".join(lines))
    write_atomically(out / TABLE_FILE, ("\n".join(lines) + "\n").encode())
    if len(records) < len(wanted):
        click.echo(f"\ninterrupted; {len(records)} runs are in {out / RECORD_FILE}, the same command goes on", err=True)
        sys.exit(INTERRUPT_EXIT_CODE)
    if docs:
        renew(records)


def collect(wanted: list[Any], path: Path, fresh: bool) -> list[Any]:
    """Yield the records of the file, and run those that are missing; Ctrl-C keeps the finished ones."""
    from validation.calibration.runs import code_digest, examined, stored

    if fresh:
        path.unlink(missing_ok=True)
    done = stored(path, code_digest())
    missing = [case for case in wanted if case not in done]
    try:
        with Progress("calibration", len(wanted) - len(missing), len(wanted)) as bar:
            for count, record in enumerate(examined(missing, path), start=len(wanted) - len(missing) + 1):
                done[record.family, record.seed] = record
                bar.update(count)
    except KeyboardInterrupt:
        pass
    return [done[case] for case in wanted if case in done]
