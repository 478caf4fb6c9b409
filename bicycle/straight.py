"""The linear equations of a straight run from four deviations that are known in closed form.

`mbsd3d.linearize` finds by itself what the joints allow. Of a bicycle that runs straight it is known: the deviations
that belong to a unit of lean, steer and their rates follow from `bicycle.kinematics` by a complex step. So the general
equations of motion are needed for four directions instead of 48, at a tenth of the cost, which maps of thousands of
bicycles need. That the joints allow these directions is read off the model's own rows, and that the run is steady off
its accelerations; a model to which either does not apply is left to `linearize`.
"""

import numpy as np

from mbsd3d import AssemblyError, System
from mbsd3d.base.concurrency import on_one_thread
from mbsd3d.constraints.row_choice import schur_of
from mbsd3d.equations.compiled import compile_system
from mbsd3d.linear.variations import STEP, Field, cross, directions

from .kinematics import placed, rolling
from .models import outputs
from .parameters import Parameters

COORDINATES, VELOCITIES, ROWS = 28, 24, 21
ALLOWED = 1e-9
"""Largest residual of the rows along a deviation, in units of the largest entry; rounding leaves 1e-14."""


def deviations(p: Parameters, centres: np.ndarray, speed: float) -> np.ndarray:
    """(48, 4) X of `mbsd3d.linear.variations` for unit lean, steer, lean rate and steer rate, by complex steps.

    The pitch that goes with lean and steer is of second order, since it is the same to the left and to the right.

    Parameters
    ----------
    p : Parameters
    centres : (4, 3) ndarray
        Centres of mass of rear wheel, frame, fork, front wheel from their O at the hubs [m].
    speed : float
        [m/s]
    """
    columns = []
    for lean, steer, lean_rate, steer_rate in 1j * STEP * np.eye(4):
        at = placed(p, lean, steer, 0.0)
        motion, _ = rolling(p, at, speed, lean_rate, steer_rate)
        R = np.array([at.frame, at.frame, at.fork, at.fork])
        s = np.einsum("bij,bj->bi", R, centres)
        r_G = np.array([at.rear, at.rear, at.front, at.front]) + s
        theta = np.stack([R[:, 2, 1], R[:, 0, 2], R[:, 1, 0]], axis=-1)  # R = 1 + [theta]x
        v, w = motion[:, :3], motion[:, 3:]
        v_G = v + cross(w, s)
        columns.append(np.concatenate([np.hstack([r_G, theta]).ravel(), np.hstack([v_G, w]).ravel()]).imag / STEP)
    return np.array(columns).T


@on_one_thread
def output_matrices(system: System, p: Parameters, speed: float) -> tuple[np.ndarray, np.ndarray] | None:
    """A (4, 4) at rest and at the speed of the system, of its `bicycle.models.outputs`; None: use `linearize`.

    Parameters
    ----------
    system : System
        A bicycle that runs straight, e.g. ``whipple(p, speed)``.
    p : Parameters
    speed : float
        The same speed [m/s].
    """
    if [body.name for body in system.bodies] != ["rear wheel", "frame", "fork", "front wheel"]:
        return None
    start, seen = system.state(), outputs(system)
    compiled = compile_system(system, tuple(seen))
    field = Field(compiled, start, len(seen))
    if compiled.model.z_work or compiled.model.row.size != ROWS:
        return None
    schur = schur_of(compiled.model, np.arange(ROWS), complex)
    X = deviations(p, compiled.model.body["com"], speed)
    found = []
    for share in (0.0, 1.0):  # of the speed: all velocities of a straight run, and those that lean and steer add to it
        y, along = field.y.copy(), X.copy()
        y[COORDINATES:] *= share
        along[VELOCITIES:, :2] *= share
        found.append(matrix_at(field, schur, y, along))
    return None if any(A is None for A in found) else (found[0], found[1])


def matrix_at(field: Field, schur: object, y: np.ndarray, X: np.ndarray) -> np.ndarray | None:
    """L F X, the rates of the outputs along the deviations; None if the joints or the motion do not allow them."""
    model = field.compiled.model
    moves = directions(model, y)
    try:
        here, change = field.derivatives(schur, 0.0, y, moves @ X)
        rates = np.vstack([change["position_rate"], change["acceleration"]])
        A = field.output_rates(0.0, y, moves @ rates)
    except AssemblyError:
        return None
    holonomic = model.row["holonomic"] == 1
    slip = np.abs(change["slip"]).max(), np.abs(change["c"][holonomic]).max()
    force = np.abs(here["acceleration"]).max() + np.abs(change["outputs"] - np.eye(4)).max()
    return A if max(*slip, force) <= ALLOWED * max(1.0, np.abs(X).max(), np.abs(A).max()) else None
