"""Linear equations of a bicycle from the general model, for all speeds from two of them.

Velocities enter the equations of motion only in the quadratic terms of the accelerations, and all velocities of a
straight run are proportional to the speed v. So the derivative of the accelerations by velocities is linear in v, that
by displacements 1 and v^2, exactly:

    q'' = - v C1 q' - (K0 + v^2 K2) q,      q = (lean, steer)

Two linearisations, at rest and at one speed, hold everything. A third at another speed confirms it; a model whose other
forces depend on speed (air drag, tyres) fails this check and is linearised at every speed.

`mbsd3d.linearize` finds by itself which deviations the joints allow. For a bicycle that runs straight those of lean,
steer and their rates are known in closed form, by a complex step through `bicycle.model.kinematics`. So four directions
replace 48, at a tenth of the cost, which maps of thousands of bicycles need. The rows of the model and its
accelerations show whether these deviations belong to it; a model that refuses them is left to `linearize`.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from mbsd3d import AssemblyError, Linearization, System, linearize
from mbsd3d.errors import InputError
from mbsd3d.extend import (
    COMPLEX_STEP,
    Field,
    Tree,
    build_spanning_tree,
    compile_system,
    directions,
    number,
    on_one_thread,
)

from ..model.kinematics import placed, rolling
from ..model.mechanism import NAMES, outputs
from ..parameters import Parameters
from .equations import Canonical, checked_speeds

Build = Callable[..., System]
"""``build(parameters, speed=v)`` returns a bicycle with a body "frame" and a hinge "steer" that runs straight."""
AGREEMENT_TOLERANCE = 1e-9
"""How well a third speed must confirm two, relative to the largest entry: rounding leaves 1e-12, drag far more."""
COORDINATES, VELOCITIES, ROWS = 28, 24, 21
ROW_RESIDUAL_MAX = 1e-9  # [1] of the largest entry: residual of the rows along a deviation; rounding leaves 1e-14


def linearization(build: Build, parameters: Parameters, speed: float) -> Linearization:
    """Return `mbsd3d.linearize` of the straight run at a speed [m/s], with lean, steer and their rates as outputs."""
    system = build(parameters, speed=float(speed))
    return linearize(system, outputs=outputs(system))


def linear_equations(
    build: Build, parameters: Parameters, speed: float = 5.0, *, check: bool = True
) -> Canonical | None:
    """Return the linear equations of a model in the form of the paper, divided by M; None if they do not have that
    form.

    Parameters
    ----------
    build : callable
        ``build(parameters, speed=v)`` returns the bicycle, e.g. `bicycle.whipple`.
    parameters : Parameters
    speed : float
        Of the second linearisation [m/s], not zero: best the largest of interest.
    check : bool
        Whether `linearize` at 0.6 times the speed must agree; not needed for further bicycles of a model that passed.

    Returns
    -------
    Canonical or None
        M is the unit matrix, g = 1; ``A``, ``eigenvalues`` as of the closed form.
    """
    if number(speed, "linear equations: speed") == 0.0:
        raise InputError("linear equations: speed = 0; give another one, e.g. 5 m/s")
    rest, running = matrices(build, parameters, speed)
    if np.abs(rest[2:, 2:]).max() > AGREEMENT_TOLERANCE * np.abs(running).max():  # damping at rest
        return None
    added = (running - rest)[2:]
    found = Canonical(M=np.eye(2), C1=-added[:, 2:] / speed, K0=-rest[2:, :2], K2=-added[:, :2] / speed**2, g=1.0)
    if check:
        between = linearization(build, parameters, 0.6 * speed).A
        if np.abs(between - found.A(0.6 * speed)).max() > AGREEMENT_TOLERANCE * np.abs(running).max():
            return None
    return found


def required_equations(build: Build, parameters: Parameters, speed: float = 5.0, *, check: bool = True) -> Canonical:
    """Return `linear_equations`; raise ValueError for a model that does not have their form."""
    found = linear_equations(build, parameters, speed, check=check)
    if found is None:
        raise InputError(
            f"bicycle '{parameters.name}': a force depends on speed otherwise than through the motion, so modes and "
            "critical speeds follow from no polynomial; see stability.eigenvalues, speed by speed"
        )
    return found


def matrices(build: Build, parameters: Parameters, speed: float) -> tuple[np.ndarray, np.ndarray]:
    """Return A at rest and at a speed: from four deviations where these are known, else by `linearize`."""
    known = output_matrices(build(parameters, speed=float(speed)), parameters, float(speed))
    return known or (linearization(build, parameters, 0.0).A, linearization(build, parameters, speed).A)


def deviations(p: Parameters, centres: np.ndarray, speed: float) -> np.ndarray:
    """Return X of `mbsd3d.variations` for unit lean, steer, lean rate and steer rate, by complex steps, shape (48, 4).

    The pitch that goes with lean and steer is the same to the left and to the right, so it is of second order.
    ``centres`` (4, 3) are the centres of mass of rear wheel, frame, fork, front wheel from their O at the hubs [m].
    """
    columns = []
    for lean, steer, lean_rate, steer_rate in 1j * COMPLEX_STEP * np.eye(4):
        at = placed(p, lean, steer, 0.0)
        motion, _ = rolling(p, at, speed, lean_rate, steer_rate)
        R = np.array([at.frame, at.frame, at.fork, at.fork])
        s = np.einsum("bij,bj->bi", R, centres)
        r_G = np.array([at.rear, at.rear, at.front, at.front]) + s
        theta = np.stack([R[:, 2, 1], R[:, 0, 2], R[:, 1, 0]], axis=-1)  # R = 1 + [theta]x
        v, w = motion[:, :3], motion[:, 3:]
        v_G = v + np.cross(w, s)
        columns.append(
            np.concatenate([np.hstack([r_G, theta]).ravel(), np.hstack([v_G, w]).ravel()]).imag / COMPLEX_STEP
        )
    return np.array(columns).T


@on_one_thread
def output_matrices(system: System, p: Parameters, speed: float) -> tuple[np.ndarray, np.ndarray] | None:
    """Return A (4, 4) of lean, steer and rates, at rest and at the speed [m/s] at which ``system`` runs; None:
    `linearize`.
    """
    if [body.name for body in system.bodies] != [*NAMES.values()]:
        return None
    start, seen = system.state(), outputs(system)
    compiled = compile_system(system, tuple(seen))
    field = Field(compiled, start, len(seen))
    if compiled.model.z_work or compiled.model.row.size != ROWS:
        return None
    tree = build_spanning_tree(compiled.model, field.real, None, complex)
    X = deviations(p, compiled.model.body["com"], speed)
    found = []
    for share in (0.0, 1.0):  # of the speed: all velocities of a straight run, and those that lean and steer add to it
        y, along = field.y.copy(), X.copy()
        y[COORDINATES:] *= share
        along[VELOCITIES:, :2] *= share
        if (A := matrix_at(field, tree, y, along)) is None:
            return None
        found.append(A)
    return found[0], found[1]


def matrix_at(field: Field, tree: Tree, y: np.ndarray, X: np.ndarray) -> np.ndarray | None:
    """Return the rates of the outputs along the deviations; None if the joints or the motion do not allow them."""
    model = field.compiled.model
    moves = directions(model, y)
    try:
        here, change = field.derivatives(tree, 0.0, y, moves @ X)
        rates = np.vstack([change["position_rate"], change["acceleration"]])
        A = field.output_rates(0.0, y, moves @ rates)
    except AssemblyError:
        return None
    holonomic = model.row["holonomic"] == 1
    slip = np.abs(change["slip"]).max(), np.abs(change["c"][holonomic]).max()
    force = np.abs(here["acceleration"]).max() + np.abs(change["outputs"] - np.eye(4)).max()
    return A if max(*slip, force) <= ROW_RESIDUAL_MAX * max(1.0, np.abs(X).max(), np.abs(A).max()) else None


def eigenvalues(build: Build, parameters: Parameters, speeds: ArrayLike) -> np.ndarray:
    """Compute eigenvalues of the lean and steer motion of the general model about straight runs [1/s].

    Parameters
    ----------
    build : callable
        ``build(parameters, speed=v)`` returns the bicycle, e.g. `bicycle.whipple`.
    parameters : Parameters
    speeds : (n,) array_like
        [m/s]

    Returns
    -------
    (n, 4) complex ndarray
        [1/s], each row by real part, conjugates together.

    Examples
    --------
    >>> from bicycle import Meijaard2007, whipple
    >>> eigenvalues(whipple, Meijaard2007(), [0.0]).real.round(6)
    array([[-5.530944, -3.131643,  3.131643,  5.530944]])
    """
    speeds = checked_speeds(speeds)
    fastest = float(speeds[np.argmax(np.abs(speeds))]) or 1.0
    if speeds.size > 3:
        found = linear_equations(build, parameters, fastest)
        if found is not None:
            return found.eigenvalues(speeds)
    return np.array([np.sort_complex(linearization(build, parameters, v).eigenvalues) for v in speeds])
