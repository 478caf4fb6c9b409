"""Command ``mbsd3d import``: a model of another program as a file of this one, or the other way."""

import click

from .support import import_options, load_system, set_option


@click.command("import", epilog="Example: mbsd3d import robot.urdf --to robot.toml")
@click.argument("file")
@click.option("--to", "target", required=True, help="File to write: .toml, .json, .xml (MJCF), .urdf or .sdf.")
@import_options
@set_option
@click.option("--omit", multiple=True, metavar="NAME", help="Do not write this joint or force.")
@click.option(
    "--massless", is_flag=True, help="Write joints of several coordinates over links without mass (.urdf, .sdf)."
)
@click.option("--replace", is_flag=True, help="Replace an existing file.")
def convert(
    file: str, target: str, drop: tuple[str, ...], settings: tuple[str, ...], omit: tuple[str, ...], massless: bool,
    replace: bool,
) -> None:  # fmt: skip
    """Convert a model: read one of any format, write another.

    FILE is a model of MuJoCo (.xml, .mjcf), ROS (.urdf, .xacro) or Gazebo (.sdf), a model file (.json, .toml), or a
    Python file with build(), which returns a System. Reports what is soft or left out in the file that is written.
    """
    from ..api.model_input import write_as

    click.echo(write_as(load_system(file, drop, settings), target, omit, massless, replace))
