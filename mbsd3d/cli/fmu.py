"""Command ``mbsd3d fmu``: a mechanism as an FMU for co-simulation."""

from pathlib import Path

import click

from .run import METHODS, method_of
from .support import (
    import_options,
    list_parameters,
    load_posed,
    parameters_option,
    pose_option,
    ready_folder,
    set_option,
)


@click.command(epilog="Example: mbsd3d fmu pendulum.toml --out pendulum.fmu")
@click.argument("file")
@click.option("--out", metavar="FILE.fmu", help="The FMU; default: the name of FILE, with .fmu, in this folder.")
@click.option("--input", "inputs", multiple=True, metavar="NAME", help="An input of the FMU; default: all. Repeatable.")
@click.option(
    "--parameter", "numbers", multiple=True, metavar="PART.FIELD",
    help="A number that the host may set before the start, e.g. spring.stiffness. Repeatable.",
)  # fmt: skip
@click.option("--method", type=click.Choice(METHODS), help="Integration method; default: DOP853.")
@click.option("--dt", type=float, help="Fixed step [s] of the method.")
@click.option("--rtol", type=float, default=1e-8, show_default=True, help="Tolerance: a step may err by a fifth of it.")
@click.option("--replace", is_flag=True, help="Replace an existing file.")
@import_options
@pose_option
@set_option
@parameters_option
def fmu(
    file: str, out: str | None, inputs: tuple[str, ...], numbers: tuple[str, ...], method: str | None,
    dt: float | None, rtol: float, replace: bool, drop: tuple[str, ...], pose: str | None,
    settings: tuple[str, ...], help_parameters: bool,
) -> None:  # fmt: skip
    """Write a mechanism as an FMU (FMI 3.0, co-simulation).

    FILE is a model file (.json, .toml), a model of MuJoCo (.xml, .mjcf), ROS (.urdf, .xacro) or Gazebo (.sdf), or a
    Python file with build(), which returns a System. The FMU runs where the host is Python with mbsd3d installed, as
    with FMPy. Needs the extra fmu.
    """
    if help_parameters:
        list_parameters(file)
    chosen = method_of(method, dt, None)
    target = Path(out or Path(file).with_suffix(".fmu").name)
    system, start = load_posed(file, drop, settings, pose)
    ready_folder(str(target.parent))
    made = system.to_fmu(
        target, state=start, inputs=inputs or None, parameters=numbers, method=chosen, rtol=rtol, replace=replace
    )
    from ..files.fmu import HOST

    click.echo(str(made))
    click.echo(f"mbsd3d: {HOST}", err=True)
