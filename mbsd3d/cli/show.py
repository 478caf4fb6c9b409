"""Command ``mbsd3d show``: the mechanism at its reference pose."""

import click

from .support import (
    can_view,
    import_options,
    list_parameters,
    load_posed,
    parameters_option,
    pose_option,
    ready_target,
    set_option,
)


@click.command(epilog="Example: mbsd3d show robot.urdf")
@click.argument("file")
@import_options
@pose_option
@set_option
@parameters_option
@click.option("--out", default="out", show_default=True, help="Folder for the page, or the name of the .html file.")
def show(
    file: str, drop: tuple[str, ...], pose: str | None, settings: tuple[str, ...], help_parameters: bool, out: str
) -> None:
    """Draw a mechanism at its reference pose.

    FILE is a model file (.json, .toml), a model of MuJoCo (.xml, .mjcf), ROS (.urdf, .xacro) or Gazebo (.sdf), or a
    Python file with build(), which returns a System. Writes one page (.html) that needs no network.
    """
    can_view(needed=True)
    if help_parameters:
        list_parameters(file)
    system, state = load_posed(file, drop, settings, pose)
    target = ready_target(file, out, ".html")
    click.echo(str(system.show(state=state, title=target.name).save(target)))
