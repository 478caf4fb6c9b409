"""Every quantity of every part of a run as columns of numbers, and the meaning of each column."""

from typing import NamedTuple

import numpy as np

from ..mechanism.bodies import GROUND
from ..mechanism.drivers import Driver, OrientationDriver, PositionDriver
from ..mechanism.force_element import ForceElement
from ..mechanism.forces.custom import FunctionForce, SavedForce
from ..mechanism.measures import state
from .element_loads import Load, load_of
from .result import RunResult


class Quantity(NamedTuple):
    """Name, unit and components of one result quantity."""

    unit: str
    frame: str
    description: str


QUANTITIES = {
    "position": Quantity("m", "world", "position of the reference point O"),
    "orientation": Quantity("1", "body -> world", "unit quaternion (e0, e1, e2, e3), scalar first, active"),
    "velocity": Quantity("m/s", "world", "velocity of the reference point O"),
    "omega": Quantity("rad/s", "world", "angular velocity"),
    "omega_body": Quantity("rad/s", "body", "angular velocity"),
    "acceleration": Quantity("m/s^2", "world", "acceleration of the reference point O"),
    "alpha": Quantity("rad/s^2", "world", "angular acceleration"),
    "com": Quantity("m", "world", "position of the centre of mass"),
    "angle": Quantity("rad", "joint", "angle of b relative to a, unwrapped, 0 at the reference pose; NaN: has none"),
    "slide": Quantity("m", "joint", "displacement of b relative to a, 0 at the reference pose; NaN: has none"),
    "rate": Quantity("rad/s", "joint", "rate of the angle; NaN: has none"),
    "slide_rate": Quantity("m/s", "joint", "rate of the slide of a joint without angle; NaN: has none"),
    "reaction_force": Quantity("N", "world", "force of the joint on its body b"),
    "reaction_moment": Quantity("N m", "world", "moment of the joint on its body b about reaction_point"),
    "reaction_point": Quantity("m", "world", "point at which the reaction is given"),
    "reaction_unique": Quantity(
        "1", "none", "1: determined by the constraints, 0: at least in part a least-norm share"
    ),
    "reaction_unique_force": Quantity("1", "world", "1: this component of the force is determined by the constraints"),
    "reaction_unique_moment": Quantity(
        "1", "world", "1: this component of the moment is determined by the constraints"
    ),
    "reaction_determined_force": Quantity("N", "world", "part of reaction_force that is determined; NaN: all of it"),
    "reaction_determined_moment": Quantity(
        "N m", "world", "part of reaction_moment that is determined; NaN: all of it"
    ),
    "effort": Quantity("N m or N", "joint", "torque or force of the driver on b along its motion, see driver_unit"),
    "force": Quantity("N", "world", "force of the element on its body b; on each body of a custom force"),
    "force_moment": Quantity("N m", "world", "moment of the element on that body about force_point"),
    "force_point": Quantity("m", "world", "point at which the load of the element is given"),
    "force_power": Quantity("W", "none", "power of the element, given to all its bodies"),
    "force_stored": Quantity("J", "none", "energy stored in the element"),
    "force_length": Quantity("m", "none", "length of a spring, or the slide the element acts along; NaN: has none"),
    "force_angle": Quantity("rad", "none", "angle of the hinge the element acts about, unwrapped; NaN: has none"),
    "force_length_rate": Quantity("m/s", "none", "rate of force_length; NaN: has none"),
    "force_angle_rate": Quantity("rad/s", "none", "rate of force_angle; NaN: has none"),
    "state": Quantity("see state_unit", "none", "internal state of a force, e.g. a filter; -: as the user defined it"),
    "kinetic": Quantity("J", "world", "kinetic energy"),
    "potential": Quantity("J", "world", "potential energy of gravity and springs"),
    "total": Quantity("J", "world", "kinetic and potential energy"),
    "work": Quantity("J", "world", "work done by drivers and by forces that store no energy"),
    "lost": Quantity("J", "world", "energy lost in impacts"),
    "linear_momentum": Quantity("kg m/s", "world", "momentum"),
    "angular_momentum": Quantity("kg m^2/s", "world", "angular momentum about the world origin"),
    "position_drift": Quantity("m or rad", "none", "largest residual of the joints"),
    "velocity_drift": Quantity("m/s or rad/s", "none", "largest velocity residual of the joints"),
}


BODY_QUANTITIES = ("position", "orientation", "velocity", "omega", "omega_body", "acceleration", "alpha", "com")
REACTION_QUANTITIES = ("force", "moment", "point", "unique", "unique_force", "unique_moment")
DETERMINED_QUANTITIES = ("determined_force", "determined_moment")  # of reactions that are not unique


class Column(NamedTuple):
    """One quantity of one part: (samples,) or (samples, components); of truth values one, or (components,), for all."""

    kind: str
    part: str
    quantity: str
    unit: str
    values: np.ndarray


def columns(solution: RunResult) -> list[Column]:
    """Return all quantities of all parts; kind is "body", "joint", "driver", "force_element", "own_state"
    or "" for the whole system."""
    system, found = solution.system, []

    def add(kind: str, part: str, quantity: str, values: np.ndarray) -> None:
        found.append(Column(kind, part, quantity, QUANTITIES[quantity].unit, np.asarray(values)))

    for body in system.bodies:
        for quantity in BODY_QUANTITIES:
            add("body", body.name, quantity, getattr(solution, quantity)(body))
    for joint in system.joints:
        name, turns, slides = system.name(joint), joint.angle() is not None, joint.slide() is not None
        for quantity, has in (("angle", turns), ("slide", slides), ("rate", turns)):
            if has:
                add("joint", name, quantity, getattr(solution, quantity)(joint))
        if slides and not turns:
            add("joint", name, "slide_rate", solution.rate(joint))
        reaction = solution.reaction(joint)
        for quantity in REACTION_QUANTITIES + DETERMINED_QUANTITIES * (not reaction.unique):
            add("joint", name, f"reaction_{quantity}", getattr(reaction, quantity))
    for driver in dict.fromkeys(driver for driver, _ in solution.compiled.drives):
        found += columns_of_effort(solution, driver)
    for force in system.forces:
        found += columns_of_force(solution, force)
        found += columns_of_states(solution, force)
    for quantity, values in solution.energy().shown().items():
        add("", "energy", quantity, values)
    for owner in ("momentum", "drift"):
        for quantity, values in vars(getattr(solution, owner)()).items():
            add("", "", f"{quantity}_{owner}", values)
    return found


def columns_of_effort(solution: RunResult, driver: Driver) -> list[Column]:
    """Return one column per row of a driver; several rows are named with the axis or the number of the row."""
    effort = solution.effort(driver).reshape(solution.t.size, -1)
    units = [unit for row in driver.rows() for unit in ["N" if row.in_metres else "N m"] * row.n_rows]
    if isinstance(driver, PositionDriver):
        labels = [f".{axis}" for axis, signal in zip("xyz", driver.signal, strict=True) if signal is not None]
    elif isinstance(driver, OrientationDriver):
        labels = [".x", ".y", ".z"]
    else:
        labels = [""] if len(units) == 1 else [f".{k}" for k in range(len(units))]
    names = [solution.system.name(driver) + label for label in labels]
    return [Column("driver", name, "effort", unit, x) for name, unit, x in zip(names, units, effort.T, strict=True)]


def loads_of(solution: RunResult, force: ForceElement) -> dict[str, Load]:
    """Return loads of a force by name: on body b, or on every body of a custom force; none where it is lost."""
    if isinstance(force, SavedForce):
        return {}
    name = solution.system.name(force)
    bodies = list({id(body): body for body in force.record().bodies if body is not GROUND}.values())
    if not isinstance(force, FunctionForce) or len(bodies) == 1:
        return {name: load_of(solution, force)}
    return {f"{name} on {body.name}": load_of(solution, force, body) for body in bodies}


def columns_of_force(solution: RunResult, force: ForceElement) -> list[Column]:
    """Return wrench, power, energy and stretch of a force."""
    found = []
    for k, (name, load) in enumerate(loads_of(solution, force).items()):
        shown: dict[str, np.ndarray | None] = {
            "force": load.force,
            "force_moment": load.moment,
            "force_point": load.point,
        }
        if k == 0:  # of the whole element
            kind = "angle" if load.angle is not None else "length"
            shown |= {"force_power": load.power, "force_stored": load.stored}
            shown |= {f"force_{kind}": getattr(load, kind), f"force_{kind}_rate": load.rate}
        found += [Column("force_element", name, x, QUANTITIES[x].unit, y) for x, y in shown.items() if y is not None]
    return found


def columns_of_states(solution: RunResult, force: ForceElement) -> list[Column]:
    """Return one column per internal state of a force, by its name or number."""
    name, values = solution.system.name(force), zip(force.state_names(), solution.state_of(force).T, strict=True)
    return [Column("own_state", f"{name}.{own}", "state", state(force, k).unit, z) for k, (own, z) in enumerate(values)]


def components(values: np.ndarray) -> tuple[str, tuple[str, ...]]:
    """Return the dimension and labels of the components of a column."""
    if values.ndim == 0 or (values.ndim == 1 and values.dtype != bool):
        return "", ()
    return ("axis", ("x", "y", "z")) if values.shape[-1] == 3 else ("quaternion", ("e0", "e1", "e2", "e3"))
