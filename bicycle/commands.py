"""``mbsd3d bicycle STUDY``: every study is a module of this package that holds its click command as ``command``."""

from importlib import import_module, util

import click

STUDIES = ("stability", "sensitivity", "why", "ride", "circles", "frequency", "compare")


class Studies(click.Group):
    """Commands that are imported when they are asked for."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Studies in the order of a course."""
        return [name for name in STUDIES if util.find_spec(f"bicycle.{name}")]

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        """The ``command`` of a study; one that has none is not listed."""
        known = name in self.list_commands(ctx)
        return getattr(import_module(f"bicycle.{name}"), "command", None) if known else None


@click.group(cls=Studies)
def bicycle() -> None:
    """Stability, sensitivity, rides and circles of bicycles with ideal wheels.

    BICYCLE is a name, e.g. Browser, or a file with parameters (.txt, .yml); without it the benchmark bicycle of 2007.
    """
