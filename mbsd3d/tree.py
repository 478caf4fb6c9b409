"""Forward kinematics of the spanning tree: moving everything beyond a hinge by its angle or slide."""

from typing import Any

import numpy as np

from .kernels import kinds
from .model import Compiled
from .rotations import exponential, matrix, multiply
from .state import State


def swing(compiled: Compiled, pose: State, targets: list[tuple[Any, float]]) -> State:
    """Forward kinematics: everything beyond a joint in the spanning tree moves by the asked-for angle or slide."""
    system, index = compiled.system, compiled.body_index
    n = len(system.bodies)
    poses = pose.q.reshape(n, 7).copy()
    for x, value in targets:
        beyond = bodies_beyond(system, index, x)
        if beyond is None:
            continue  # the joint closes a loop: Newton's task
        side = next(body for body in (x.b, x.a) if index[id(body)] in beyond)
        sign = 1.0 if side is x.b else -1.0
        fixed = x.a if side is x.b else x.b
        i = index[id(fixed)]
        e, r = (fixed.orientation, fixed.position) if i == n else (poses[i, 3:], poses[i, :3])
        own = x.axis if fixed is x.a else x.axis_b
        axis = matrix(e) @ fixed.local_axis(own)
        point_of = x.point_a if fixed is x.a else x.point_b
        pivot = r + matrix(e) @ fixed.local_point(hinge_point(system, x, point_of))
        for k in beyond:
            if x.kind == kinds.SLIDE:
                poses[k, :3] += sign * value * axis
                continue
            turn = exponential(sign * value * axis)
            poses[k, :3] = pivot + matrix(turn) @ (poses[k, :3] - pivot)
            poses[k, 3:] = multiply(turn, poses[k, 3:])
    return State(pose.t, poses.ravel(), pose.v, pose.z)


def hinge_point(system: Any, x: Any, default: np.ndarray) -> np.ndarray:
    """A point on the hinge line, world at the reference pose."""
    for joint in system.joints:
        own = joint.angle()
        if own is not None and own.a is x.a and own.b is x.b and np.array_equal(own.axis, x.axis):
            return getattr(joint, "at", default)
    return default


def bodies_beyond(system: Any, index: dict[int, int], x: Any) -> set[int] | None:
    """Bodies that hang on the ground through this hinge only; None where the hinge is part of a loop."""
    ground = len(system.bodies)
    links: dict[int, set[int]] = {i: set() for i in range(ground + 1)}
    pair = {index[id(x.a)], index[id(x.b)]}
    for joint in system.joints:
        ends = [index[id(body)] for body in joint.bodies()]
        for i in ends:
            links[i].update(j for j in ends if j != i and {i, j} != pair)
    reached, queue = {ground}, [ground]
    while queue:
        for j in links[queue.pop()] - reached:
            reached.add(j)
            queue.append(j)
    inside = pair & reached
    if len(inside) != 1:
        return None
    start = (pair - inside).pop()
    beyond, queue = {start}, [start]
    while queue:
        for j in links[queue.pop()] - beyond:
            beyond.add(j)
            queue.append(j)
    return beyond


def loop_weights(compiled: Compiled) -> np.ndarray:
    """1 for the rows of a spanning tree of joints, 1e-4 for those that close loops."""
    weights, group = np.ones(compiled.model.row.size), {}

    def root(i: int) -> int:
        while group.get(i, i) != i:
            group[i] = group.get(group[i], group[i])  # shortens the way for the next time
            i = group[i]
        return i

    for joint in compiled.system.joints:
        roots = {root(compiled.body_index[id(body)]) for body in joint.bodies()}
        if len(roots) == 1:
            weights[compiled.rows[id(joint)]] = 1e-4
        for i in roots:
            group[i] = min(roots)
    return weights
