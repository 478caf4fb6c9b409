"""Relative equilibria: motions that only carry the mechanism along a symmetry, and the generator of that symmetry.

All bodies move with one velocity of translation c and one rotation Omega (about the vertical, where there is gravity),
and each may spin at a constant rate about an axis through its centre of mass that moves along:

    v_G = c + Omega x r_G,   w = Omega + spin,   a_G = Omega x v_G,   w_dot = Omega x w,   z_dot = 0.

In axes that turn with Omega such a motion is at rest, ``X_dot = (F - [Omega]x) X``. That this matrix is the same at
any time is no consequence of those equations (think of an unbalanced wheel) and is checked at a later state.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from ..base.quaternions import exponential, multiply, skew
from ..base.rotations import matrix
from ..kernels.layout import Model
from .variations import Variations


@dataclass(frozen=True, eq=False)
class Generator:
    """The motion along the symmetry: c [m/s] at the world origin, Omega [rad/s], spin (n, 3) [rad/s], world axes.

    ``residual`` is the largest violation of the conditions, in the model's units of length and time.
    """

    translation: np.ndarray
    rotation: np.ndarray
    spin: np.ndarray
    residual: float = 0.0

    @property
    def turning(self) -> bool:
        """True if the mechanism turns as a whole."""
        return bool(self.rotation.any())

    @property
    def axis_point(self) -> np.ndarray:
        """(3,) point of the turn axis nearest to the origin [m]; NaN without a rotation."""
        square = self.rotation @ self.rotation
        return np.cross(self.rotation, self.translation) / square if square else np.full(3, np.nan)

    def transport(self, n: int, k: int) -> np.ndarray:
        """(N, N) the matrix that applies [Omega]x to every vector of X."""
        return scipy.linalg.block_diag(np.kron(np.eye(4 * n), skew(self.rotation)), np.zeros((k, k)))


def symmetry_axes(model: Model) -> list[np.ndarray]:
    """Per body (3, 3) projector (body axes) on the directions in which a spin would change its inertia."""
    out = []
    for record in model.body:
        moments, C = np.linalg.eigh(record["inertia"].reshape(3, 3))
        low, high = np.diff(moments) <= 1e-9 * max(moments[-1], 1e-300)
        free = C if low and high else C[:, [2]] if low else C[:, [0]] if high else C[:, :0]
        out.append(np.eye(3) - free @ free.T)
    return out


def candidates(model: Model, at: Variations, y: np.ndarray, rate: float) -> list[Generator]:
    """Generators that explain the velocities and accelerations best, the one with the least rotation first.

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
    found = []
    for rows, right in extras:
        more = np.hstack([np.zeros((rows.shape[0], 3)), rows / rate])
        x = columns * np.linalg.lstsq(np.vstack([A, more]) * columns, np.r_[b, right / rate], rcond=1e-9)[0]
        Omega = up @ np.where(np.abs(x[3:]) < 1e-12 * rate, 0.0, x[3:])  # rounding is no rotation
        if all(np.abs(Omega - other.rotation).max() > 1e-9 * rate for other in found):
            found.append(Generator(x[:3], Omega, w - Omega))
    return found


def crosses(a: np.ndarray) -> np.ndarray:
    """(3 n, 3) matrix of Omega -> Omega x a_i."""
    return -skew(a).reshape(-1, 3)


def motion_residuals(model: Model, at: Variations, g: Generator, rate: float) -> tuple[np.ndarray, np.ndarray]:
    """(n,) violations per body of v_G = c + Omega x r_G, and of the two conditions on accelerations; dimensionless."""
    long, Omega = model.length * rate, g.rotation
    slip = np.abs(at.velocity[:, :3] - g.translation - np.cross(Omega, at.centre)).max(axis=1) / long
    a = np.abs(at.acceleration[:, :3] - np.cross(Omega, at.velocity[:, :3])).max(axis=1) / (long * rate)
    alpha = np.abs(at.acceleration[:, 3:] - np.cross(Omega, at.velocity[:, 3:])).max(axis=1) / rate**2
    return slip, np.maximum(a, alpha)


def carried(model: Model, at: Variations, g: Generator, y: np.ndarray, tau: float) -> tuple[np.ndarray, np.ndarray]:
    """(state y after the time tau along the generator, its rotation Q)."""
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
