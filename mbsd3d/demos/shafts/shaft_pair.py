"""Massless shafts that meet at an angle and turn slowly: the moments of their joint."""

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Joint,
    Kinematic,
    PointOnLine,
    Ramp,
    Revolute,
    Solution,
    System,
    Torque,
    rotation,
    shapes,
    simulate,
)
from mbsd3d.base.style import GREY

TURN_SAMPLES = 361  # [1] of one turn, the quarters among them: there couples and rates have their extremes
SHAFT_LENGTH = 1.0  # [m] from the joint to the support of the driven shaft


def shaft(sign: float) -> tuple[shapes.Shape, ...]:
    """Return a shaft along x that ends at the joint, with a disc at its other end."""
    bar = shapes.Cylinder(0.04, 0.9, "x", at=(sign * 0.5, 0, 0))
    return (
        bar,
        shapes.Disc(0.15, 0.05, "x", at=(sign * 0.95, 0, 0)),
        shapes.Box((0.1, 0.2, 0.06), at=(sign * 0.05, 0, 0)),
    )


@lru_cache(maxsize=64)
def forked(outer: float | None, *forks: tuple[float, str]) -> tuple[shapes.Shape, ...]:
    """Draw a shaft along x about its middle: a disc at the end ``outer``, and forks (end, axis of their pin).

    Drawn once, since the shafts of many bends look alike.
    """
    ends = [end - np.sign(end) * 0.16 for end, _ in forks] + ([] if outer is None else [outer])
    made: list[shapes.Shape] = [
        shapes.Cylinder(0.04, abs(ends[0] - ends[1]), "x", at=(0.5 * (ends[0] + ends[1]), 0, 0))
    ]
    if outer is not None:
        made.append(shapes.Disc(0.18, 0.04, "x", at=(outer, 0, 0)))
    for end, pin in forks:
        across = np.array([0.0, pin == "y", pin == "z"])
        inner = end - np.sign(end) * 0.16
        made.append(shapes.Box(np.array([0.04, 0.06, 0.06]) + 0.2 * across, at=(inner, 0, 0)))
        for side in (-0.115, 0.115):
            place = side * across + [0.5 * (inner + end) + 0.01 * np.sign(end), 0, 0]
            made.append(shapes.Box(np.array([0.22, 0.06, 0.06]) - 0.03 * across, at=place))
        made.append(shapes.Cylinder(0.02, 0.28, pin, at=(end, 0, 0), colour=GREY))
    return tuple(made)


def shaft_pair(joint: Callable[..., Joint], bend_deg: float, torque: float, **axes: object) -> System:
    """Build a driving shaft along x and a driven shaft bent in the xy plane, with ``joint`` and its axes between them
    at the origin.
    """
    bend = np.radians(bend_deg)
    along = np.array([np.cos(bend), np.sin(bend), 0])
    drive = Body("drive", 0.0, (0, 0, 0), shape=shaft(-1))
    driven = Body("driven", 0.0, (0, 0, 0), orientation=rotation("z", bend), shape=shaft(1))
    bearing = Revolute(GROUND, drive, at=(0, 0, 0), axis=(1, 0, 0), name="bearing")
    joints = [
        bearing,
        AngleDriver(bearing, Ramp(1.0), name="motor"),
        joint(drive, driven, at=(0, 0, 0), name="joint", **axes),
        PointOnLine(GROUND, driven, at=SHAFT_LENGTH * along, axis=along, name="support"),
    ]
    load = Torque(driven, (-torque, 0, 0), frame="body", name="load")
    return System([drive, driven], joints, [load], gravity=(0, 0, 0))


def one_turn(system: System, **terms: Any) -> tuple[Solution, np.ndarray, np.ndarray, np.ndarray]:
    """Return the run, couples on driving and driven shaft [N m] and the output's rate over that of the input, at the
    samples.

    The bearing of the driving shaft stands at the joint, so its moment across the shaft is the couple; on the driven
    shaft the couple is held by a pair of forces at joint and support.
    """
    run = simulate(system, 2 * np.pi, method=Kinematic(), output=TURN_SAMPLES, **terms)
    on_driving = np.linalg.norm(run.reaction("bearing").moment[:, 1:], axis=1)
    on_driven = SHAFT_LENGTH * np.linalg.norm(run.reaction("support").force, axis=1)
    return run, on_driving, on_driven, run.omega_body("driven")[:, 0]
