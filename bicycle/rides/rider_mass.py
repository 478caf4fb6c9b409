"""Change of a bicycle during a ride: the state of the new one that continues that of the old."""

import numpy as np

from mbsd3d import State
from mbsd3d.errors import InputError
from mbsd3d.extend import as_quaternion, matrix

from ..model.kinematics import X, Y, Z, foot, hubs, rotation_about, steer_axis
from ..parameters import Parameters

SPEED_MIN = 0.3  # [m/s] below which velocities cannot be scaled
PITCH_ITERATIONS = 6  # [1] of the pitch until both wheels stand as before; each leaves a hundredth of the error or less


def faster(state: State, speed: float, now: float) -> State:
    """Scale all velocities so that the rear hub moves at another speed [m/s]."""
    if now < SPEED_MIN:
        raise InputError(f"the bicycle moves at {now:.2g} m/s, too slowly to be made faster; reset it")
    return State(state.t, state.q, state.v * speed / now, state.z, state.coordinates)


def carried(state: State, old: Parameters, new: Parameters) -> State:
    """Return the state with frame and rear wheel unchanged, the front end at the same steer angle and rates in its new
    mounting.

    Then all is turned about the rear hub until the front wheel stands as deep in the ground as before. Bodies: rear
    wheel, frame, fork, front wheel, as in `whipple`; both bicycles have the same wheels.
    """
    q, v = state.q.reshape(4, 7), state.v.reshape(4, 6)
    R = [matrix(e) for e in q[:, 3:]]
    depth = lowest(q[3, :3], R[3], old)
    (rear, front), (at, axis) = hubs(new), steer_axis(new)
    before = steer_axis(old)[1]
    if state.coordinates is None:
        raise InputError("the state has no angles of hinges, so its steer angle is not known; give one of a run")
    steer, rate = state.coordinates[1], (R[1] @ before) @ (v[2, 3:] - v[1, 3:])
    spin = R[3][:, 1] @ (v[3, 3:] - v[2, 3:])
    frame, hub, rolled = R[1], q[1, :3], R[2].T @ R[3]
    fork = frame @ rotation_about(axis, steer)
    reach = frame @ (at - rear), fork @ (front - at)

    omega = v[1, 3:] + rate * (frame @ axis)
    speed = v[1, :3] + np.cross(v[1, 3:], reach[0]) + np.cross(omega, reach[1])
    place = hub + reach[0] + reach[1]
    places = np.array([hub, hub, place, place])
    turns = [R[0], frame, fork, fork @ rolled]
    motion = np.array([v[0], v[1], [*speed, *omega], [*speed, *(omega + spin * fork @ Y)]])

    across = np.cross(Z, frame @ X)
    across /= np.linalg.norm(across)
    for _ in range(PITCH_ITERATIONS):
        ahead = np.cross(across, Z) @ (places[3] - hub)
        turn = rotation_about(across, (lowest(places[3], turns[3], new) - depth) / ahead)
        places, turns = hub + (places - hub) @ turn.T, [turn @ one for one in turns]
        motion = (motion.reshape(8, 3) @ turn.T).reshape(4, 6)
    e = np.array([as_quaternion(one, "carried") for one in turns])
    e *= np.sign((e * q[:, 3:]).sum(axis=1, keepdims=True))  # of the same sign as before
    return State(state.t, np.column_stack([places, e]).ravel(), motion.ravel(), state.z, state.coordinates)


def lowest(hub: np.ndarray, R: np.ndarray, p: Parameters) -> float:
    """Return the height of the lowest point of a front wheel [m], zero where it stands."""
    return float(hub[2] + foot(R[:, 1], p.rF, p.tF)[2])
