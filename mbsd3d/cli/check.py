"""Command ``mbsd3d check``: degrees of freedom and redundant joints."""

import click

from .support import import_options, load_system, parameters_option, set_option


@click.command(epilog="Example: mbsd3d check door.toml")
@click.argument("file")
@import_options
@set_option
@parameters_option
def check(file: str, drop: tuple[str, ...], settings: tuple[str, ...], help_parameters: bool) -> None:
    """Find the degrees of freedom and redundant joints of a mechanism.

    FILE is a model file (.json, .toml), a model of MuJoCo (.xml, .mjcf), ROS (.urdf, .xacro) or Gazebo (.sdf), or a
    Python file with build(), which returns a System. The exit code is 1 if it is locked or cannot close.
    """
    diagnosis = load_system(file, drop, settings, help_parameters).check()
    click.echo(str(diagnosis))
    if diagnosis.verdict.startswith(("locked", "cannot close")):
        raise click.exceptions.Exit(1)
