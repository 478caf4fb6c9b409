"""Command that plays a ride."""

from typing import TYPE_CHECKING, Any

import click

from mbsd3d.extend import can_view, port_option, watch

from . import bicycle_argument, tyre_options

if TYPE_CHECKING:
    from ..parameters import Parameters


@click.command(epilog="Example: mbsd3d bicycle play")
@bicycle_argument
@click.option("--speed", type=float, default=5.0, show_default=True, help="Speed at the start [m/s].")
@click.option("--assist", type=float, default=20.0, show_default=True, help="Initial balance assist [N m s/rad].")
@click.option("--torque", type=float, default=2.0, show_default=True, help="Largest torque of your arms [N m].")
@port_option
@tyre_options
def play(
    parameters: "Parameters", speed: float, assist: float, torque: float, port: int, fittings: dict[str, Any]
) -> None:  # fmt: skip
    """Ride a bicycle on tyres in the browser: steer by keys, change it while it rides.

    Left and right arrow (or J, L) are the torque of your arms, up and down (I, K) pedal and brake; on a gamepad the
    left stick, the right trigger and the left one. Sliders set speed, balance assist, trail, head angle and the spin of
    the wheels. Green under the speed: where it stays up by itself.
    Always on tyres. Ctrl-C ends it. Next: mbsd3d bicycle stability --tyres
    """
    can_view(needed=True)
    from ..rides.play import play as ride

    watch(ride(parameters, speed=speed, assist=assist, torque=torque, port=port, **fittings))
