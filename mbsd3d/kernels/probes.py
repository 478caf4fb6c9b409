"""Measures: scalar functions of the state used by stop_when, assemble and StateFeedback."""

import numpy as np

from .coordinates import arctan2, coordinate, coordinate_rate
from .jit import kernel
from .kinds import COORDINATE, COORDINATE_RATE, GAP, LEAN, OWN_STATE, POSITION, TURN, VELOCITY
from .vectors import arm, cross, dot, point, point_velocity, sub, vec


@kernel
def measure(m, d, i, t):
    """Value of measure i: hinge coordinate or rate, point along an axis (b relative to a), w . axis, lean,
    distance, own state of a force element."""
    p = m.measure[i]
    if p.kind == COORDINATE:
        return coordinate(m, d, p.coordinate, t)[0]
    if p.kind == COORDINATE_RATE:
        return coordinate_rate(m, d, p.coordinate, t)
    if p.kind == OWN_STATE:
        return d.z[p.state]
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
