"""An engine as one wants to see it: crank level, bores up, cylinders far enough apart to look like an engine.

The motion of a cylinder does not depend on its station, so that only the picture changes.
"""

from dataclasses import fields, replace
from typing import Any

import numpy as np

from mbsd3d import GROUND, Body, Joint, Solution, System
from mbsd3d.rotations import matrix

from . import looks, spatial
from .layouts import Engine, Layout


def upright(layout: Layout) -> np.ndarray:
    """(3, 3) rotation into a world whose x is the crank axis and whose z is the middle of the bores.

    Opposed bores have no middle; they lie level, at right angles to z.
    """
    beta = np.radians(layout.bores)
    middle = np.array([np.cos(beta).sum(), np.sin(beta).sum(), 0.0])
    if np.linalg.norm(middle) < 1e-9:
        middle = np.array([-np.sin(beta[0]), np.cos(beta[0]), 0.0])
    up = middle / np.linalg.norm(middle)
    axis = np.array([0.0, 0.0, 1.0])
    return np.stack([axis, np.cross(up, axis), up])


def turned(system: System, R: np.ndarray) -> System:
    """The same mechanism in a world turned by R: every place and direction v becomes R v.

    Parameters
    ----------
    system : System
        Without forces; bodies at rest or with what the joints give them.
    R : (3, 3) ndarray
        Rotation.

    Returns
    -------
    System
        With the same names.
    """
    found: dict[int, Any] = {id(GROUND): GROUND}
    for body in system.bodies:
        orientation = R @ matrix(body.orientation)
        found[id(body)] = replace(body, position=R @ body.position, orientation=orientation)
    for joint in system.joints:
        values = {}
        for field in fields(joint):
            value = getattr(joint, field.name)
            if isinstance(value, Body | Joint) or value is GROUND:
                values[field.name] = found[id(value)]
            elif field.name.startswith(("at", "axis")):
                values[field.name] = R @ value
        found[id(joint)] = replace(joint, **values)
    bodies, joints = ([found[id(part)] for part in parts] for parts in (system.bodies, system.joints))
    return System(bodies, joints, gravity=R @ system.gravity)


def shown(engine: Engine) -> Solution:
    """One turn of the engine, upright and with its cylinders apart."""
    apart = looks.pictured(engine)
    return spatial.turn(turned(spatial.build(apart), upright(engine.layout)), apart)
