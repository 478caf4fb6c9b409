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
from .warmup import warmup


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, "--version", prog_name="mbsd3d", message="%(prog)s %(version)s")
def main() -> None:
    """Simulate spatial multibody dynamics: demos, checks and runs of mechanisms."""


@main.command()
def version() -> None:
    """Print the version."""
    click.echo(f"mbsd3d {__version__}")


for command in (check, convert, demo, doctor, fmu, gallery, play, run, show, warmup):
    main.add_command(command)
