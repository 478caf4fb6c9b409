"""Command line, one file a command. Commands import heavy packages when they run, so that help is quick."""

import click

from ..base.version import __version__
from .check import check
from .convert import convert
from .demo import demo
from .doctor import doctor
from .fmu import fmu
from .gallery import gallery
from .play import play
from .run import run
from .show import show
from .support import Commands
from .sweep import sweep
from .warmup import warmup


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, "--version", prog_name="mbsd3d", message="%(prog)s %(version)s")
def main() -> None:
    """Simulate spatial multibody dynamics: demos, checks and runs of mechanisms."""


@main.command(epilog="Example: mbsd3d version")
def version() -> None:
    """Print the version."""
    click.echo(f"mbsd3d {__version__}")


@main.command(epilog="Example: mbsd3d verify flight.zip")
@click.argument("file")
def verify(file: str) -> None:
    """Make the run of a bundle again and compare.

    FILE is what solution.bundle(path) wrote. With the same versions and processor the run must be identical to the bit,
    elsewhere within its stated error. The exit code is 1 if it is not, or if the file was changed.
    """
    from ..files.bundles import verify as verify_bundle

    found = verify_bundle(file)
    click.echo(str(found))
    if not found.passed:
        raise click.exceptions.Exit(1)


for command in (check, convert, demo, doctor, fmu, gallery, play, run, show, sweep, warmup):
    main.add_command(command)
