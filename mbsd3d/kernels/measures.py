"""Measures: scalar functions of the state."""

from typing import Annotated

import numpy as np
from numba import types

from ..compiler.arguments import Reference
from ..compiler.decorators import inner_kernel, kernel, late_kernel
from ..compiler.late import late
from .coordinates import arctan2, coordinate, coordinate_rate, number_of, sum_and_rate
from .kinds import (
    CLEARANCE,
    COORDINATE,
    COORDINATE_RATE,
    EXCESS,
    GAP,
    HOLDING,
    LEAN,
    OWN_STATE,
    POSITION,
    PRESS,
    REACTION_FORCE,
    REACTION_MOMENT,
    SUM,
    TENSION,
    TURN,
    VELOCITY,
)
from .ropes import tension_of_section
from .surfaces import contact_parameters, meeting, pressure
from .vectors import arm, cross, dot, pair, point, point_velocity, scale, sub, vec


def of_measure(m: Reference, d: Reference, *given: types.Type) -> types.Type:
    """Return the types of the results of `measure`."""
    return number_of(d)


MeasureValue = Annotated[complex, of_measure]


@late_kernel
def of_contact(m, d, p) -> MeasureValue:
    """Return clearance [m] or normal force [N] of a contact."""
    f = m.force[p.force]
    own = contact_parameters(m.number, f.number)
    plane, _, _, gap, velocity = meeting(own, f, d.body[f.body[0]], d.body[f.body[1]])
    return gap if p.kind == CLEARANCE else pressure(own, gap, -dot(plane[2], velocity))[0]


@late_kernel
def of_sum(m, d, p, t) -> MeasureValue:
    """Return the weighted sum of the coordinates that a force reads."""
    return sum_and_rate(m, d, m.force[p.force], t)[0]


@late_kernel
def of_tension(m, d, p, t) -> MeasureValue:
    """Return the tension [N] of a section of a rope or belt; its number from 0 stands as its row."""
    return tension_of_section(m, d, m.force[p.force], p.row, t)


@inner_kernel
def joint_reaction(m, d, p):
    """Return the reaction of a joint on its body b: force, and moment about the joint's point on b.

    ``p`` is the record of what reads it, a measure or a force. Rows and multipliers are those at hand.
    """
    b = d.body[p.body[1]]
    force, moment = scale(0.0, vec(b.w)), scale(0.0, vec(b.w))
    for k in range(p.row, p.row + p.rows):
        for slot in range(4):
            if m.row[k].body[slot] == p.body[1]:
                linear, angular = pair(d.row[k].J[slot])
                force = sub(force, scale(d.row[k].lam, linear))
                moment = sub(moment, scale(d.row[k].lam, angular))
    return force, sub(moment, cross(arm(b, p.point[1]), force))


@late_kernel
def of_reaction(m, d, p) -> MeasureValue:
    """Return a component of the force [N] or moment [N m] of a joint on its body b, or its size where no axis is given.

    The multipliers and rows in ``d`` must be those of its state: see `dynamics.state_rates.evaluate`.
    """
    force, moment = joint_reaction(m, d, p)
    load = force if p.kind == REACTION_FORCE else moment
    axis = arm(d.body[p.body[0]], p.axis)
    return dot(axis, load) if dot(axis, axis).real > 0.0 else np.sqrt(dot(load, load))


@late
@kernel
def measure(m, d, i, t) -> MeasureValue:
    """Return measure i: hinge coordinate or rate, point along an axis (b relative to a), w . axis, lean, or others."""
    p = m.measure[i]
    if p.kind == COORDINATE:
        return coordinate(m, d, p.coordinate, t)[0]
    if p.kind == COORDINATE_RATE:
        return coordinate_rate(m, d, p.coordinate, t)
    if p.kind == OWN_STATE:
        return d.z[p.state]
    if p.kind == CLEARANCE or p.kind == PRESS:
        return of_contact(m, d, p)
    if p.kind == REACTION_FORCE or p.kind == REACTION_MOMENT:
        return of_reaction(m, d, p)
    if p.kind == HOLDING:
        return -d.row[p.row].lam
    if p.kind == SUM:
        return of_sum(m, d, p, t)
    if p.kind == TENSION:
        return of_tension(m, d, p, t)
    if p.kind == EXCESS:
        return -d.row[p.row].lam - p.axis[0] * d.force[p.force].load
    a, b, axis = d.body[p.body[0]], d.body[p.body[1]], vec(p.axis)
    sa, sb = arm(a, p.point[0]), arm(b, p.point[1])
    gap = sub(point(b, sb), point(a, sa))
    if p.kind == POSITION:
        return dot(axis, gap)
    if p.kind == GAP:
        return np.sqrt(dot(gap, gap))
    if p.kind == VELOCITY:
        return dot(axis, sub(point_velocity(b, sb), point_velocity(a, sa)))
    if p.kind == TURN:
        return dot(axis, sub(vec(b.w), vec(a.w)))
    side = arm(b, p.axis)  # lean: elevation of the body's lateral axis
    level = np.sqrt(side[0] * side[0] + side[1] * side[1])
    if p.kind == LEAN:
        return arctan2(side[2], level)
    side_dot = cross(vec(b.w), side)
    return (side_dot[2] * level - side[2] * (side[0] * side_dot[0] + side[1] * side_dot[1]) / level) / dot(side, side)
