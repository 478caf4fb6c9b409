"""A pendulum of general shape with its motion in closed form."""

import numpy as np

from helpers.models import (
    pendulum,
)
from validation import theory
from validation.cases import reference as cases


def swinging(rate=2.4, start=0.6):
    """(system, hinge, state, angle(t)) of a pendulum of general shape with its closed form."""
    rng = np.random.default_rng(22)
    system, body, hinge = pendulum(rng)
    upright = system.gravity / np.linalg.norm(system.gravity)
    frame = cases._rotation(body.orientation)
    arm = body.position + frame @ body.com - hinge.at
    arm = arm - hinge.axis * (hinge.axis @ arm)
    pull = upright - hinge.axis * (hinge.axis @ upright)
    offset = np.arctan2(hinge.axis @ np.cross(pull, arm), pull @ arm)
    inertia = hinge.axis @ frame @ body.inertia @ frame.T @ hinge.axis + body.mass * arm @ arm
    weight = 9.81 * np.linalg.norm(pull)
    frequency = theory.pendulum_frequency(inertia, body.mass, np.linalg.norm(arm), weight)
    state = system.assemble(angles={hinge: start - offset}, rates={hinge: rate})
    return system, hinge, state, lambda t: theory.pendulum_motion(t, frequency, start, rate)[0] - offset
