"""Command ``mbsd3d play``: a mechanism in real time, in the browser, with sliders and keys for its inputs."""

import click

from ..base.errors import InputError
from .support import can_view, import_options, load_system, parameters_option, set_option, watch

port_option = click.option(
    "--port", type=click.IntRange(0, 65535), default=0, help="Port on this machine; default: any free one."
)


def ranges(given: tuple[str, ...]) -> dict[str, tuple[float, float]]:
    """Read texts NAME=LOW:HIGH as name -> (low, high)."""
    found = {}
    for text in given:
        name, _, span = text.rpartition("=")
        low, colon, high = span.partition(":")
        try:
            found[name] = (float(low), float(high))
        except ValueError:
            name = ""
        if not (name and colon):
            raise InputError(f"--input '{text}': give NAME=LOW:HIGH, e.g. --input motor=-5:5")
    return found


@click.command(epilog="Example: mbsd3d play pendulum.py")
@click.argument("file")
@click.option(
    "--input", "inputs", multiple=True, metavar="NAME=LOW:HIGH",
    help="Range of an input, e.g. motor=-5:5; gives it a slider and keys. Repeatable.",
)  # fmt: skip
@click.option("--follow", metavar="BODY", help="The camera follows this body and turns with it.")
@click.option("--rtol", type=float, default=1e-6, show_default=True, help="Tolerance: a step may err by a fifth of it.")
@port_option
@import_options
@set_option
@parameters_option
def play(
    file: str, inputs: tuple[str, ...], follow: str | None, rtol: float, port: int, drop: tuple[str, ...],
    settings: tuple[str, ...], help_parameters: bool,
) -> None:  # fmt: skip
    """Simulate a mechanism in real time in the browser, and change its inputs during the run.

    FILE is a model file (.json, .toml), a model of MuJoCo (.xml, .mjcf), ROS (.urdf, .xacro) or Gazebo (.sdf), or a
    Python file with build(), which returns a System. Forces, torques and references of controllers that are Input
    signals get sliders and keys, and with --input the motors and servos of an imported model. The page is served on
    this machine only, to whoever has its address. Ctrl-C ends it.
    """
    can_view(needed=True)
    given = ranges(inputs)
    system = load_system(file, drop, settings, help_parameters, inputs=bool(given))
    watch(system.play(given, follow=follow, rtol=rtol, port=port))
