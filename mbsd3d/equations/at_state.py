"""Kernels at one state from Python: kinematics, rows and the scaled Jacobian."""

import numpy as np

from ..base.errors import InputError
from ..base.wording import counted
from ..dynamics.state_rates import largest_residuals, load_motion
from ..kernels.coordinates import coordinate
from ..kernels.kinematics import kinematics, pack_motion
from ..kernels.layout import Data
from ..kernels.rows import rows
from ..mechanism.joints import Joint
from ..mechanism.mechanism import Mechanism
from ..mechanism.state import State
from .compiled import Compiled, initial_states
from .jacobian import BlockRows, block_rows, displacement_units, scaled_rows


def pack(compiled: Compiled, state: State) -> np.ndarray:
    """Return y = (q, u, z) with u = (r_dot, R'w), audit states zero; missing internal states start as declared."""
    y = pack_states(compiled, state)
    pack_motion(state.q, state.v, y)
    return y


def pack_states(compiled: Compiled, state: State) -> np.ndarray:
    """Return y with internal states alone, q and u zero."""
    n = len(compiled.system.bodies)
    if state.q.size != 7 * n:
        raise InputError(
            f"state: {counted(state.q.size // 7, 'body')}, the system has {n}; give a state of this system"
        )
    y = np.zeros(13 * n + compiled.model.state.size)
    own = state.z if state.z.size else initial_states(compiled.system)
    if own.size != compiled.model.z_work:
        raise InputError(
            f"state: z has {own.size} internal states, the forces of the system have {compiled.model.z_work}; "
            "give a state "
            "of this system, or none"
        )
    y[13 * n : 13 * n + own.size] = own
    return y


def load_state(compiled: Compiled, data: Data, state: State) -> np.ndarray:
    """Evaluate kinematics and rows of ``data`` at a state; return y."""
    y = pack_states(compiled, state)
    if state.coordinates is not None:
        known = state.coordinates.size  # a condition on other hinges adds coordinates at the end of the table
        data.coordinate["value"][:known] = state.coordinates[: data.coordinate.size]
    data.coordinate["rate"] = 0.0
    data.unwrap_time[0] = state.t
    load_motion(compiled.model, data, state.t, state.q, state.v, y)
    return y


def driven_coordinates(compiled: Compiled, t: float) -> np.ndarray:
    """Return the references of hinge coordinates at a start: the signal where driven, else zero."""
    reference = np.zeros(compiled.model.coordinate.size)
    for joint, _ in compiled.drives:
        for row in joint.primitives:
            if len(row.coordinates) == 1 and row.signal is not None:
                reference[compiled.coordinate(row.coordinates[0])] = float(row.signal(t)) / row.values[0]
    return reference


def coordinate_row(compiled: Compiled, data: Data, i: int, t: float) -> tuple[float, np.ndarray]:
    """Return (value, gradient with respect to the world velocities (6 n,)) of hinge coordinate i."""
    n = compiled.model.body.size
    x, _, linear_a, angular_a, linear_b, angular_b = coordinate(compiled.model, data, i, t)
    row = np.zeros((n + 1, 6))
    a, b = compiled.model.coordinate["body"][i]
    row[a] += np.concatenate([linear_a, angular_a])
    row[b] += np.concatenate([linear_b, angular_b])
    return x, row[:n].ravel()


def joint_point(compiled: Compiled, data: Data, joint: Joint) -> np.ndarray:
    """Return the point (3,) of a joint at the pose in ``data``, carried by body b, world [m]."""
    body = data.body[compiled.body_index[id(joint.b)]]
    return body["r"] + body["R"].reshape(3, 3) @ joint.b.local_point(joint.point())


def load_rows(compiled: Compiled, data: Data, y: np.ndarray, t: float, coordinates: np.ndarray | None = None) -> None:
    """Evaluate kinematics and rows at y, hinge coordinates near those given or stored in the work space."""
    if coordinates is not None:
        data.coordinate["value"], data.coordinate["rate"], data.unwrap_time[0] = coordinates, 0.0, t
    kinematics(compiled.model, data, y)
    rows(compiled.model, data, t)


def rows_at(compiled: Compiled, data: Data, t: float, y: np.ndarray, coordinates: np.ndarray) -> BlockRows:
    """Return scaled rows at y, where the hinge coordinates are near those given."""
    load_rows(compiled, data, y, t, coordinates)
    return scaled_rows(compiled.model, data)


def check_quaternions(system: Mechanism, state: State) -> None:
    """Raise a ValueError for an orientation that is not a unit quaternion."""
    e = state.q.reshape(-1, 7)[:, 3:]
    squares = (e * e).sum(axis=1)
    if np.abs(squares - 1.0).max() <= 1e-6:
        return
    norms = np.sqrt(squares)
    for i in np.flatnonzero(~(np.abs(norms - 1.0) <= 1e-6)):
        raise InputError(
            f"state: the quaternion of '{system.name(system.bodies[i])}' has norm {norms[i]:.9g} instead of 1; divide "
            "it by that"
        )


def unmet(compiled: Compiled, data: Data, v: np.ndarray, tolerance: float) -> tuple[np.ndarray, str] | None:
    """Return (residual of all rows, its unit) of a start in ``data`` whose c or J v - b is too large; else None.

    ``tolerance`` of c, in units of the model's length and radians; J v - b may reach ten times as much.
    """
    if not data.row.size:
        return None
    position, slip = largest_residuals(compiled.model, data, np.arange(data.row.size))
    if position > tolerance:
        return data.row["c"], "m or rad"
    if slip > 10 * tolerance:
        speed = np.abs(v.reshape(-1, 6) / displacement_units(compiled.model.length, 1)).max(initial=0.0)
        if slip > 10 * tolerance * max(1.0, float(speed)):
            return block_rows(compiled.model, data).times(v) - data.row["b"], "m/s or rad/s"
    return None


def worst_joint(compiled: Compiled, residual: np.ndarray) -> tuple[str, float]:
    """Return (text naming the joint with the largest residual, its size)."""
    size = np.abs(residual) * compiled.model.row["scale"]
    k = int(np.argmax(size))
    joint = compiled.holders[compiled.row_joint[k]]
    group = residual[compiled.rows[id(joint)]]
    largest = np.linalg.norm(group[:3]) if compiled.model.row["metres"][k] else np.abs(residual[k])
    return f"{type(joint).__name__} '{compiled.system.name(joint)}'", float(largest)
