"""What acts on a ridden bicycle besides its weight and the ground."""

from dataclasses import replace
from typing import Any

from mbsd3d import Force, Signal, Torque
from mbsd3d.mechanism.signals import as_signal

from .kinematics import steer_axis
from .models import Bicycle, whipple
from .parameters import Parameters


def steer_torque(system: Bicycle, parameters: Parameters, torque: Signal | float) -> list[Torque]:
    """Torque of the rider's arms about the steer axis [N m]: on the fork, to the right > 0, and back on the frame."""
    signal = as_signal(torque, "ride: torque")
    axis = steer_axis(parameters)[1]  # the bodies' own axes are the world's at the upright reference pose
    return [
        Torque(system.part(body), tuple(sign * x * signal for x in axis), frame="body", name=f"steer torque on {body}")
        for body, sign in (("fork", 1.0), ("frame", -1.0))
    ]


def ridden(parameters: Parameters, torque: Any, push: Any, **start: float) -> Bicycle:
    """The bicycle with the loads of a ride, at its start."""
    system = whipple(parameters, **start)
    forces = steer_torque(system, parameters, torque) if torque else []
    if push:
        sideways = -1.0 * as_signal(push, "ride: push")  # world y is to the left
        forces.append(Force(system.part("frame"), (0.0, sideways, 0.0), name="push"))
    return replace(system, forces=forces) if forces else system
