"""Relative equilibria: whether a state is one, and whether its linear equations are constant along the motion.

All bodies move with one velocity of translation c and one rotation Omega (about the vertical, where there is gravity),
and each may spin at a constant rate about an axis through its centre of mass that moves along:

    v_G = c + Omega x r_G,   w = Omega + spin,   a_G = Omega x v_G,   w_dot = Omega x w,   z_dot = 0.

In axes that turn with Omega such a motion is at rest, ``X_dot = (F - [Omega]x) X``. That this matrix is the same at
any time does not follow from those equations (think of an unbalanced wheel) and is checked at a later state.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.linalg

from ..base.errors import InputError
from ..base.rotations import exponential, matrix, multiply, skew
from ..equations.at_state import worst_joint
from ..equations.jacobian import displacement_units
from ..kernels import kinds
from ..kernels.layout import Model
from ..mechanism.mechanism import Mechanism
from ..mechanism.signals import Signal
from .variations import Field, Tangent, Variations

BALANCING_PASSES = 20  # [passes] over the matrix, each of which goes half of the way for a pair


@dataclass(frozen=True, eq=False)
class Units:
    """Units that make the linear equations dimensionless."""

    x: np.ndarray  # (N,) of the entries of X: length, radian, and their rates
    rate: float  # [1/s]


def natural_units(model: Model, at: Variations, space: Tangent, damped: bool = True) -> Units:
    """Return the model's length, and as rate the fastest of stiffness, damping if wanted, rotation, gravity."""
    n, c, v = 6 * model.body.size, space.configuration, space.velocity
    one = displacement_units(model.length, 2 * model.body.size)
    chosen = space.chosen[: c + v]
    pull = np.abs((at.F @ space.E)[n : 2 * n, : c + v] / one[:n, None] * one[chosen])
    stiffness, damping = pull[:, :c].max(initial=0.0), pull[:, c:].max(initial=0.0)
    fall = np.linalg.norm(model.gravity) / model.length
    rate = max(np.sqrt(stiffness), damping if damped else 0.0, np.abs(at.velocity[:, 3:]).max(), np.sqrt(fall)) or 1.0
    x = np.r_[one[:n], rate * one[:n], np.ones(model.z_work)]
    for j in range(2 * n, x.size):  # internal states: what causes a unit acceleration, or what a unit motion causes
        cause, effect = np.abs(at.F[n : 2 * n, j] / x[n : 2 * n]).max(), np.abs(at.F[j, : 2 * n] * x[: 2 * n]).max()
        x[j] = rate / cause if cause else effect / rate or 1.0
    balance(at.F, x, 2 * n)
    return Units(x, float(rate))


def balance(F: np.ndarray, x: np.ndarray, first: int) -> None:
    """Scale the internal states x from ``first`` on, until what each causes is as large as what causes it.

    Internal states that drive each other may have sizes that the motion does not determine.
    """
    for _ in range(BALANCING_PASSES if x.size > first else 0):
        for j in range(first, x.size):
            causes, caused = np.abs(F[:, j] / x) * x[j], np.abs(F[j] * x) / x[j]
            causes[j] = caused[j] = 0.0
            if causes.any() and caused.any():
                x[j] *= np.sqrt(caused.sum() / causes.sum())


def check_signals(system: Mechanism) -> None:
    """Raise an InputError unless motions are uniform and speeds and loads constant: only these give fixed equations."""
    for joint in system.joints:
        for row in joint.rows():
            speed = row.kind in (kinds.TURN_RATE, kinds.NO_SIDESLIP)
            degree = 0 if speed or row.kind == kinds.ORIENT else 1  # ramps of several turns make no uniform one
            if row.signal is not None and varies(row.signal, degree):
                what = "a constant or a ramp" if degree else "a constant speed" if speed else "a constant"
                raise InputError(f"linearize: the signal of '{system.name(joint)}' varies with time; give {what}")
    for force in system.forces:
        if any(signal is not None and varies(signal, 0) for signal in force.record().signals):
            raise InputError(f"linearize: the signal of '{system.name(force)}' varies with time; give a constant")


def varies(signal: Signal, degree: int) -> bool:
    """Return True if a signal is more than a polynomial of this degree."""
    for term in signal.terms():
        if term.kind == kinds.POLYNOMIAL:
            more = term.data[degree + 1 :]
        elif term.kind == kinds.SINE:
            more = term.data[0] * term.data[1:2]
        else:
            pieces = term.data[int(term.data[0]) + 2 :].reshape(-1, 4)
            more = pieces[:, : 3 - degree]  # where there is none, pieces joined smoothly are one
        if np.any(more != 0.0):
            return True
    return False


@dataclass(frozen=True, eq=False)
class Generator:
    """Motion along the symmetry: c [m/s] at the world origin, Omega [rad/s], spin (n, 3) [rad/s], world axes.

    ``residual`` is the largest violation of the conditions, in the model's units of length and time.
    """

    translation: np.ndarray
    rotation: np.ndarray
    spin: np.ndarray
    residual: float = 0.0

    @property
    def turning(self) -> bool:
        """Return True if the mechanism turns as a whole."""
        return bool(self.rotation.any())

    @property
    def axis_point(self) -> np.ndarray:
        """Return the point (3,) of the turn axis nearest to the origin [m]; NaN without a rotation."""
        square = self.rotation @ self.rotation
        return np.cross(self.rotation, self.translation) / square if square else np.full(3, np.nan)

    def transport(self, n: int, k: int) -> np.ndarray:
        """Return the matrix (N, N) that applies [Omega]x to every vector of X."""
        return scipy.linalg.block_diag(np.kron(np.eye(4 * n), skew(self.rotation)), np.zeros((k, k)))


def symmetry_axes(model: Model) -> list[np.ndarray]:
    """Return for each body the projector (3, 3), body axes, on directions in which a spin changes its inertia."""
    out = []
    for record in model.body:
        moments, C = np.linalg.eigh(record["inertia"].reshape(3, 3))
        low, high = np.diff(moments) <= 1e-9 * max(moments[-1], 1e-300)
        free = C if low and high else C[:, [2]] if low else C[:, [0]] if high else C[:, :0]
        out.append(np.eye(3) - free @ free.T)
    return out


def candidates(model: Model, at: Variations, y: np.ndarray, rate: float) -> list[Generator]:
    """Return the generators that explain velocities and accelerations best, the one with least rotation first.

    Least squares for (c, Omega). Where these leave a part of Omega open (everything on the axis), further ones follow:
    such that the inertia of all bodies is the same at any time, or that one of the bodies is carried along.
    """
    n, g = model.body.size, model.gravity
    up = (g / np.linalg.norm(g))[:, None] if g.any() else np.eye(3)
    long, square = model.length * rate, model.length * rate**2
    unit = np.kron(np.ones((n, 1)), np.eye(3)) / long
    A = np.vstack([
        np.hstack([unit, crosses(at.centre) / long @ up]),
        np.hstack([np.zeros((3 * n, 3)), crosses(at.velocity[:, :3]) / square @ up]),
        np.hstack([np.zeros((3 * n, 3)), crosses(at.velocity[:, 3:]) / rate**2 @ up]),
    ])  # fmt: skip
    a, alpha, w = at.acceleration[:, :3], at.acceleration[:, 3:], at.velocity[:, 3:]
    b = np.concatenate([at.velocity[:, :3].ravel() / long, a.ravel() / square, alpha.ravel() / rate**2])
    columns = np.r_[np.full(3, long), np.full(up.shape[1], rate)]
    extras = [(np.zeros((0, up.shape[1])), np.zeros(0))]
    if np.linalg.matrix_rank(A * columns, tol=1e-9) < columns.size:
        R = [matrix(e) for e in y[: 7 * n].reshape(n, 7)[:, 3:]]
        P = np.vstack([r @ p @ r.T for r, p in zip(R, symmetry_axes(model), strict=True)])
        extras.append((P @ up, np.concatenate([p @ x for p, x in zip(P.reshape(n, 3, 3), w, strict=True)])))
        extras += [(up, x) for x in w]
    found: list[Any] = []
    for rows, right in extras:
        more = np.hstack([np.zeros((rows.shape[0], 3)), rows / rate])
        x = columns * np.linalg.lstsq(np.vstack([A, more]) * columns, np.r_[b, right / rate], rcond=1e-9)[0]
        Omega = up @ np.where(np.abs(x[3:]) < 1e-12 * rate, 0.0, x[3:])  # rounding is not a rotation
        if all(np.abs(Omega - other.rotation).max() > 1e-9 * rate for other in found):
            found.append(Generator(x[:3], Omega, w - Omega))
    return found


def crosses(a: np.ndarray) -> np.ndarray:
    """Return the matrix (3 n, 3) of Omega -> Omega x a_i."""
    return -skew(a).reshape(-1, 3)


def motion_residuals(model: Model, at: Variations, g: Generator, rate: float) -> tuple[np.ndarray, np.ndarray]:
    """Return violations (n,) of v_G = c + Omega x r_G and of the two conditions on accelerations; dimensionless."""
    long, Omega = model.length * rate, g.rotation
    slip = np.abs(at.velocity[:, :3] - g.translation - np.cross(Omega, at.centre)).max(axis=1) / long
    a = np.abs(at.acceleration[:, :3] - np.cross(Omega, at.velocity[:, :3])).max(axis=1) / (long * rate)
    alpha = np.abs(at.acceleration[:, 3:] - np.cross(Omega, at.velocity[:, 3:])).max(axis=1) / rate**2
    return slip, np.maximum(a, alpha)


def carried(model: Model, at: Variations, g: Generator, y: np.ndarray, tau: float) -> tuple[np.ndarray, np.ndarray]:
    """Return (state y after the time tau along the generator, its rotation Q)."""
    n, later, twist = model.body.size, y.copy(), np.zeros((4, 4))
    twist[:3, :3], twist[:3, 3] = skew(g.rotation), g.translation
    motion = scipy.linalg.expm(twist * tau)
    Q, turn = motion[:3, :3], exponential(g.rotation * tau)
    for i in range(n):
        e = multiply(turn, multiply(exponential(g.spin[i] * tau), y[7 * i + 3 : 7 * i + 7]))
        R = matrix(e)
        s, w = R @ model.body["com"][i], Q @ at.velocity[i, 3:]
        later[7 * i : 7 * i + 3] = Q @ at.centre[i] + motion[:3, 3] - s
        later[7 * i + 3 : 7 * i + 7] = e
        u = 7 * n + 6 * i
        later[u : u + 3] = Q @ at.velocity[i, :3] - np.cross(w, s)
        later[u + 3 : u + 6] = R.T @ w
    return later, Q


def find_generator(
    field: Field, at: Variations, space: Tangent, units: Units, tolerance: float
) -> tuple[Generator, Variations, np.ndarray]:
    """Return (generator, variations at a later state of the same motion, rotation of X up to there).

    ValueError for any other motion, with the body or joint, the residual and the remedy.
    """
    model, system = field.compiled.model, field.compiled.system
    wrong, changing = [], []
    for g in candidates(model, at, field.y, units.rate):
        slip, drift = motion_residuals(model, at, g, units.rate)
        if max(slip.max(), drift.max(), rest_of_states(at, units, model)) > tolerance:
            wrong.append((max(slip.max(), drift.max()), motion_message(system, at, units, slip, drift, model)))
            continue
        later, Q = later_variations(field, at, g, units)
        change, part = change_along(field, at, later, Q, space, units)
        if change <= 10.0 * tolerance:
            return replace(g, residual=float(max(slip.max(), drift.max(), change))), later, Q
        changing.append((change, change_message(change, part)))
    raise InputError(f"linearize: {min(changing or wrong)[1]}")


def rest_of_states(at: Variations, units: Units, model: Model) -> float:
    """Return the largest rate of an internal state of a force element, dimensionless."""
    return float(np.abs(at.z_rate / units.x[12 * model.body.size :]).max(initial=0.0)) / units.rate


def motion_message(
    system: Mechanism, at: Variations, units: Units, slip: np.ndarray, drift: np.ndarray, model: Model
) -> str:
    """Return why the state is not a relative equilibrium, by body."""
    if max(slip.max(), drift.max()) <= rest_of_states(at, units, model):
        k = int(np.argmax(np.abs(at.z_rate)))
        return f"internal state z{k} of a force element changes at {at.z_rate[k]:.3g}/s; start from its steady value"
    i, residual = int(np.argmax(np.maximum(slip, drift))), max(slip.max(), drift.max())
    body, remedy = f"body '{system.name(system.bodies[i])}'", "linearise about an equilibrium or a steady motion"
    a = np.linalg.norm(at.acceleration[i, :3]), np.linalg.norm(at.acceleration[i, 3:])
    if max(a[0] / model.length, a[1]) < residual * units.rate**2:
        return f"{body} does not move with the mechanism as a whole (residual {residual:.2g}); {remedy}"
    return (
        f"{body} accelerates by {a[0]:.3g} m/s^2 and {a[1]:.3g} rad/s^2, not as in a steady motion (residual "
        f"{residual:.2g}): not an equilibrium; {remedy}, e.g. from system.assemble() with its angles and rates"
    )


def later_state(field: Field, at: Variations, g: Generator, units: Units) -> tuple[float, np.ndarray, np.ndarray]:
    """Return (time, state y, rotation of X) after a radian of the fastest rotation, or a length."""
    model = field.compiled.model
    turn, drift = max(np.abs(g.spin).max(), np.abs(g.rotation).max()), np.abs(g.translation).max() / model.length
    speed = next((x for x in (turn, drift) if x > 1e-6 * units.rate), units.rate)  # below that: rounding, at rest
    tau = 1.0 / speed
    y, Q = carried(model, at, g, field.y, tau)
    N = 12 * model.body.size
    whole = np.eye(at.F.shape[0])
    whole[:N, :N] = np.kron(np.eye(N // 3), Q)
    return field.t + tau, y, whole


def later_variations(field: Field, at: Variations, g: Generator, units: Units) -> tuple[Variations, np.ndarray]:
    """Return the variations at `later_state`, and the rotation of X."""
    t, y, whole = later_state(field, at, g, units)
    return field.at(t, y), whole


def change_along(
    field: Field, at: Variations, later: Variations, Q: np.ndarray, space: Tangent, units: Units
) -> tuple[float, str]:
    """Return (largest change of rows, accelerations and F along the motion, dimensionless; the part with it)."""
    compiled, x = field.compiled, units.x[space.chosen]
    model, E = compiled.model, Q @ space.E * x
    scale = model.row["scale"]
    left = np.abs(np.column_stack([later.C @ E, later.c])).max(axis=1, initial=0.0) * scale
    speed = np.abs(np.column_stack([later.D @ E, later.slip])).max(axis=1, initial=0.0) * scale / units.rate
    row = np.maximum(left, speed)
    n = 6 * model.body.size
    turned = np.kron(np.eye(n // 3), Q[:3, :3]) @ at.acceleration.ravel()
    drift = np.abs(later.acceleration.ravel() - turned) / units.x[n : 2 * n]
    field_change = np.abs(later.F @ E - Q @ at.F @ (space.E * x)) / units.x[:, None]
    both = field_change.max(axis=1)
    both[n : 2 * n] = np.maximum(both[n : 2 * n], drift)
    both /= units.rate
    if row.max(initial=0.0) > both.max():
        return float(row.max()), worst_joint(compiled, row / scale)[0]
    k = int(np.argmax(both))
    if k >= 2 * n:
        return float(both[k]), f"internal state z{k - 2 * n} of a force element"
    return float(both[k]), f"body '{compiled.system.name(compiled.system.bodies[k % n // 6])}'"


def change_message(change: float, part: str) -> str:
    """Return the message that the equations are periodic at best."""
    return (
        f"the linear equations change along the motion (by {change:.2g}, most at {part}): something that turns is not "
        "symmetric about its axis, or a part holds the motion to a place or a time; eigenvalues do not exist, make it "
        "symmetric or integrate over a period"
    )
