"""Couplings and drivers in Exudyn: conditions on hinge coordinates and rates."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from mbsd3d import AngleDriver, Constant, Gear, PositionDriver, RackPinion, SlideDriver, SpeedDriver
from mbsd3d.extend import Coordinate, evaluate
from validation.twins.base import NotExpressible
from validation.twins.exudyn.assembly import Assembly


class Expression(NamedTuple):
    """One line how, and the function that adds the elements."""

    how: str
    add: Callable[[Assembly, Any, str], None]


def follow(signal: Any, order: int = 0) -> Callable[[float], float]:
    """A signal or a derivative as f(t); a table goes on outside its interval, where differences at its ends need it."""
    terms = signal.terms()
    return lambda t: float(evaluate(terms, t, order))


def hinge_coordinate(model: Assembly, x: Coordinate, what: str) -> int:
    """Marker of a hinge coordinate, which Exudyn measures about one axis."""
    if np.linalg.norm(x.axis - x.axis_b) > 1e-12:  # rounding of unit vectors
        raise NotExpressible(f"{what}: the axes on both sides differ as built; Exudyn measures an angle about one axis")
    return model.coordinate(x)


def couple(model: Assembly, joint: Any, driven: Coordinate, ratio: float, by: Coordinate, what: str) -> None:
    """driven = ratio by."""
    markers = [hinge_coordinate(model, x, what) for x in (driven, by)]
    model.connect(joint, model.items.ObjectConnectorCoordinate(markerNumbers=markers, factor1=ratio))


def add_gear(model: Assembly, joint: Any, what: str) -> None:
    """angle b = ratio angle a."""
    couple(model, joint, joint.hinge_b.angle(), joint.ratio, joint.hinge_a.angle(), what)


def add_rack(model: Assembly, joint: Any, what: str) -> None:
    """slide = radius angle."""
    couple(model, joint, joint.rack.slide(), joint.radius, joint.pinion.angle(), what)


def prescribe(model: Assembly, x: Coordinate, signal: Any, what: str) -> Any:
    """x = f(t)."""
    markers = [model.zero, hinge_coordinate(model, x, what)]
    if isinstance(signal, Constant):
        return model.items.ObjectConnectorCoordinate(markerNumbers=markers, offset=signal.value)
    place, rate = follow(signal), follow(signal, 1)
    return model.items.ObjectConnectorCoordinate(
        markerNumbers=markers,
        offsetUserFunction=lambda mbs, t, item, offset: place(t),
        offsetUserFunction_t=lambda mbs, t, item, offset: rate(t),
    )


def add_angle_driver(model: Assembly, joint: Any, what: str) -> None:
    """theta = f(t)."""
    model.connect(joint, prescribe(model, joint.hinge.angle(), joint.signal, what))


def add_slide_driver(model: Assembly, joint: Any, what: str) -> None:
    """s = f(t)."""
    model.connect(joint, prescribe(model, joint.slider.slide(), joint.signal, what))


def add_position_driver(model: Assembly, joint: Any, what: str) -> None:
    """Displacements along world axes."""
    for axis, signal in zip(np.eye(3), joint.signal, strict=True):
        if signal is not None:
            x = Coordinate("slide", joint.a, joint.b, axis, axis, joint.at, joint.at)
            model.connect(joint, prescribe(model, x, signal, what))


def add_speed_driver(model: Assembly, joint: Any, what: str) -> None:
    """x_a . (w_b - w_a) = f(t), a condition on velocities."""
    if joint.axis is None:
        raise NotExpressible(f"{what}: moves a point at a given speed; Exudyn has a row for speeds of turning only")
    x, speed = Coordinate("angle", joint.a, joint.b, joint.axis, joint.axis), follow(joint.speed)
    moving = {}
    if not isinstance(joint.speed, Constant):
        moving = {"offsetUserFunction_t": lambda mbs, t, item, offset: speed(t)}
    markers, first = [model.zero, model.coordinate(x, counted=False)], speed(model.state.t)
    item = model.items.ObjectConnectorCoordinate(markerNumbers=markers, velocityLevel=True, offset=first, **moving)
    model.connect(joint, item)


COUPLINGS: dict[type, Expression] = {
    Gear: Expression("CoordinateConstraint of two angles", add_gear),
    RackPinion: Expression("CoordinateConstraint of slide and angle", add_rack),
    AngleDriver: Expression("CoordinateConstraint with offset f(t)", add_angle_driver),
    SlideDriver: Expression("CoordinateConstraint with offset f(t)", add_slide_driver),
    PositionDriver: Expression("CoordinateConstraint per direction with offset f(t)", add_position_driver),
    SpeedDriver: Expression("CoordinateConstraint on velocities", add_speed_driver),
}
"""Class -> how it is expressed."""
