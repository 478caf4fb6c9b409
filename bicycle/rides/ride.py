"""Rides: nonlinear runs of the Whipple bicycle under the loads of rider and wind, until the end or a fall."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import brentq

from mbsd3d import (
    AeroDrag,
    Brake,
    Force,
    IntegrationError,
    Signal,
    Solution,
    System,
    Torque,
    accelerations,
    measures,
    simulate,
)
from mbsd3d.errors import InputError
from mbsd3d.extend import Measure, as_signal, checks_arguments, number

from ..model.mechanism import Bicycle, steer_torque, whipple
from ..model.tyres import Tyres
from ..parameters import Parameters
from .manoeuvres import FALLEN
from .motion import WHEELS, Event, Ride, ground_force, on_tyres

LINING = {"stiffness": 2e4, "damping": 500.0}
"""Of the brake [N m/rad, N m s/rad]: 100 N m turn a wheel that it holds by 0.3 degrees."""


@checks_arguments
def run(
    parameters: Parameters,
    t_end: float = 10.0,
    *,
    speed: float,
    lean: float = 0.0,
    steer: float = 0.0,
    lean_rate: float = 0.0,
    steer_rate: float = 0.0,
    torque: Signal | float = 0.0,
    push: Signal | float = 0.0,
    drive: Signal | float = 0.0,
    brake: Signal | float = 0.0,
    drag: float = 0.0,
    tyres: Tyres | None = None,
    steer_damping: float = 0.0,
    head_stiffness: float | None = None,
    head_damping: float = 0.0,
    fallen: float = FALLEN,
    held_down: bool = False,
    rtol: float = 1e-8,
    output: int | Sequence[float] | None = None,
    progress: bool | None = None,
) -> Ride:
    """Simulate a bicycle without control.

    Parameters
    ----------
    t_end : float
        End of the ride [s].
    speed, lean, steer, lean_rate, steer_rate : float
        The start, as in `whipple` [m/s, rad, rad/s].
    torque : Signal or float
        Of the rider on the handlebar [N m], to the right > 0.
    push : Signal or float
        Horizontal force on the centre of mass of frame and rider [N], to the right of the first heading > 0.
    drive, brake : Signal or float
        Torque on the rear wheel, ahead > 0, and torque at which the front brake slips, >= 0 [N m]; frame and fork bear
        them. A wheel that stands is held.
    drag : float
        c_d A of frame and rider in still air of 1.225 kg/m^3 [m^2], at their centre of mass; a rider has about 0.6.
    tyres, steer_damping, head_stiffness, head_damping
        As in `whipple`. Tyres slide and leave the ground: only a fall ends such a ride.
    fallen : float
        Tilt of the frame that ends the ride [rad], 0 < fallen < pi/2.
    held_down : bool
        Go on where the ground would have to pull at a wheel, as if it ran on a rail. The two-mass skate needs this: its
        weight is in front of both wheels.
    rtol, output, progress
        As in `mbsd3d.simulate`.

    Returns
    -------
    Ride
        Up to ``event`` if it fell ("fallen") or a wheel left the ground ("rear wheel unloaded", "front wheel
        unloaded"): an ideal wheel would be held down from there on. Unloading is detected at the samples and then
        located to 1e-9 s. Ctrl-C keeps what was computed.

    Raises
    ------
    ValueError
        If the bicycle has fallen at the start, a wheel is not pressed to the ground there, or a value is not a number.
    IntegrationError
        If the run cannot go on; its ``solution`` holds the samples.

    Examples
    --------
    >>> from bicycle import Meijaard2007, ride
    >>> print(ride.run(Meijaard2007(), speed=2.0, lean_rate=0.05).event.name)
    front wheel unloaded
    """
    limit = number(fallen, "ride: fallen", positive=True)
    if limit >= 0.5 * np.pi:
        raise InputError(f"ride: fallen = {limit:.6g} rad; give a tilt below pi/2")
    system = ridden(
        parameters, torque, push, drive, brake, drag, speed=speed, lean=lean, steer=steer, lean_rate=lean_rate,
        steer_rate=steer_rate, tyres=tyres, steer_damping=steer_damping, head_stiffness=head_stiffness,
        head_damping=head_damping,
    )  # fmt: skip
    settings = {"state": system.state(), "rtol": rtol, "output": output, "progress": progress}
    return ended(parameters, system, t_end, limit, held_down or on_tyres(system.forces), settings)


def ended(
    parameters: Parameters, system: Bicycle, t_end: float, limit: float, held_down: bool, settings: dict[str, Any]
) -> Ride:  # fmt: skip
    """Return the ride until its end, a fall, or a wheel that lifts, repeated up to that moment."""
    check_start(parameters, Ride(parameters, accelerations(system, settings["state"])), limit, held_down)
    upward = elevation(system)
    try:
        found = simulate(system, t_end, stop_when=upward < 0.5 * np.pi - limit, **settings)
    except IntegrationError as error:
        found = error.solution  # an ideal wheel that is held down may lead anywhere
        if held_down or unloading(system, found) is None:
            raise
    event = None if held_down else unloading(system, found)
    if event is None:
        stopped = (found.record.stopped_by or "").startswith(upward.label)
        return Ride(parameters, found, Event("fallen", float(found.final.t)) if stopped else None)
    if settings["output"] is not None:
        settings["output"] = [*found.t[found.t < event.t], event.t]
    return Ride(parameters, simulate(system, event.t, **settings), event)


def ridden(
    parameters: Parameters,
    torque: Signal | float,
    push: Signal | float,
    drive: Signal | float = 0.0,
    brake: Signal | float = 0.0,
    drag: float = 0.0,
    **start: Any,
) -> Bicycle:
    """Build the bicycle with the loads of a ride, at its start."""
    system = whipple(parameters, **start)
    forces, begun = list(system.forces), system.state()
    if torque:
        forces += steer_torque(system, parameters, torque)
    if drive:
        forces += axle_torque(system, "rear wheel", "frame", as_signal(drive, "ride: drive"), "drive")
    if brake:
        hub = system.part("front hub", "joints")
        forces.append(Brake(hub, torque=as_signal(brake, "ride: brake"), **LINING, name="brake"))
        begun = replace(begun, z=np.r_[begun.z, 0.0])  # it has not yielded
    if drag:
        forces.append(AeroDrag(system.part("frame"), drag_area=drag, name="drag"))
    if push:
        sideways = -1.0 * as_signal(push, "ride: push")  # world y is to the left
        forces.append(Force(system.part("frame"), (0.0, sideways, 0.0), name="push"))
    return replace(system, forces=forces, start=begun)


def axle_torque(system: Bicycle, wheel: str, bearer: str, torque: Signal, name: str) -> list[Torque]:
    """Return a torque about the axle of a wheel, ahead > 0, and back on the body that carries the wheel [N m]."""
    return [
        Torque(system.part(body), (0.0, sign * torque, 0.0), frame="body", name=f"{name} torque on {body}")
        for body, sign in ((wheel, 1.0), (bearer, -1.0))
    ]


def elevation(system: Bicycle) -> Measure:
    """Return a measure of the elevation of the frame's upward direction [rad]: pi/2 minus the tilt in any direction."""
    return measures.lean(system.part("frame"), lateral=(0.0, 0.0, 1.0))


def loads(solution: Solution) -> dict[str, np.ndarray]:
    """Return the upward force of the ground on each wheel [N], shape (n,)."""
    return {wheel: ground_force(solution, wheel)[1][:, 2] for wheel in WHEELS}


def check_start(parameters: Parameters, start: Ride, limit: float, held_down: bool) -> None:
    """Raise ValueError for a start at which the bicycle has fallen, or the ground would have to pull at a wheel."""
    what, tilt = f"bicycle '{parameters.name}'", np.arccos(np.clip(start.solution.rotation("frame")[0, 2, 2], -1, 1))
    if tilt >= limit:
        raise InputError(f"{what}: tilted by {tilt:.4g} rad at the start, where {limit:.4g} counts as fallen")
    for wheel, load in loads(start.solution).items():
        if load[0] <= 0.0 < parameters.g and not held_down:
            share = parameters.front_load
            remedy = f"it tips even at rest, with {100.0 * share:.4g} % of its weight on the front wheel; give "
            if 0.0 < share < 1.0:
                remedy = "give a slower or more upright start, or "
            raise InputError(
                f"{what}: the {wheel} wheel is not pressed to the ground at the start (load {load[0]:.6g} N); {remedy}"
                "held_down=True (ride --held-down) for a ground that can pull"
            )


def unloading(system: System, solution: Solution) -> Event | None:
    """Return the first moment of a run of a system at which a wheel is no longer pressed to the ground."""
    if not np.any(system.gravity):
        return None
    found = []
    for wheel, load in loads(solution).items():
        lifted = np.flatnonzero(load <= 0.0)
        if lifted.size:
            k = int(lifted[0])
            t = (
                brentq(load_at, *solution.t[k - 1 : k + 1], args=(system, solution, wheel), xtol=1e-9)
                if k
                else solution.t[0]
            )
            found.append(Event(f"{wheel} wheel unloaded", float(t)))
    return min(found, key=lambda event: event.t, default=None)


def load_at(t: float, system: System, solution: Solution, wheel: str) -> float:
    """Return the upward force on a wheel at any time of a run [N]."""
    return float(loads(accelerations(system, solution.at(t)))[wheel][0])


def view(found: Ride, path: str | Path | None = None, title: str | None = None) -> Any:
    """Write a page that follows the frame: traces of both hubs, and steer, loads and energies as curves.

    Names of bodies are hidden: frame and rear wheel have the same reference point.
    """
    system = found.solution.system
    traces = [(body, body.position) for body in (system.part(f"{wheel} wheel") for wheel in WHEELS)]
    kind, contact = ("force", "tyre") if on_tyres(system.forces) else ("reaction", "contact")
    curves: list[str | tuple[str, ...]] = [
        ("angle", "steer"),
        *((kind, f"{wheel} {contact}") for wheel in WHEELS),
        "energy",
    ]
    shown = found.solution.animate(
        title=title, traces=traces, curves=curves, shown="reaction force", hidden="body names", follow="frame"
    )
    return shown if path is None else shown.save(path)
