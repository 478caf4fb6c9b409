"""Whipple bicycle in eight generalised coordinates, independent of `mbsd3d` and of the models in `bicycle`.

    c = (x, y, yaw, lean, pitch, steer, rear angle, front angle),  axes of the literature: x forward, y right, z down
    [ Mc A' ] [ c_ddot ]   [ F - Jv' m (Jv_dot c_dot) - Jw' (I Jw_dot c_dot + w x I w) ]
    [ A  0  ] [ lambda ] = [ -A_dot c_dot                                              ],   A c_dot = 0

x, y is the rear contact, so that the rear wheel stands on the ground whatever c is; A holds the speeds at which the
front contact leaves the ground and both contacts slip. Places and orientations of the four bodies are written as
functions of c; their derivatives Jv, Jw are complex steps, the rates of these along c_dot differences of order eight.
Parameters are given by any object with the symbols of Meijaard et al. (2007) and crown radii tR, tF of round tyres.
"""

from typing import Any

import numpy as np

Array = np.ndarray
COMPLEX_STEP = 1e-40
DIFFERENCE_STEP, DIFFERENCE_WEIGHTS = 2e-3, {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}
"""Central differences of order eight; at 2e-3 truncation and rounding are both near 1e-13."""
X, Y, Z = np.eye(3)


def rotation(axis: Array, angle: Any) -> Array:
    """Return the rotation about an axis by Rodrigues' formula, shape (3, 3)."""
    a, b, c = axis
    K = np.array([[0, -c, b], [c, 0, -a], [-b, a, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def places(p: Any, c: Array) -> tuple[list[Array], list[Array], list[Array]]:
    """Return (centres of mass, orientations, contact points) of the bodies R, B, H, F and the wheels R, F."""
    x, y, yaw, lean, pitch, steer, spin_r, spin_f = c
    frame = rotation(Z, yaw) @ rotation(X, lean) @ rotation(Y, pitch)
    fork = frame @ rotation(np.array([np.sin(p.lam), 0, np.cos(p.lam)]), steer)
    contact_r = np.array([x, y, 0 * x])
    hub_r = contact_r - foot(frame @ Y, p.rR, p.tR)
    corner = np.array([p.w + p.c, 0, 0])  # where the steer axis meets the ground of the upright bicycle
    head = hub_r + frame @ (corner + [0, 0, p.rR])
    hub_f = head + fork @ (np.array([p.w, 0, -p.rF]) - corner)
    centre_b = hub_r + frame @ np.array([p.xB, 0, p.zB + p.rR])
    centre_h = head + fork @ (np.array([p.xH, 0, p.zH]) - corner)
    turned = [frame @ rotation(Y, spin_r), frame, fork, fork @ rotation(Y, spin_f)]
    return [hub_r, centre_b, centre_h, hub_f], turned, [contact_r, hub_f + foot(fork @ Y, p.rF, p.tF)]


def foot(axle: Array, radius: float, crown: float) -> Array:
    """Return the vector from the centre of a wheel to its lowest point [m]."""
    down = Z - axle[2] * axle
    return (radius - crown) * down / np.sqrt(down @ down) + crown * Z


def jacobians(p: Any, c: Array) -> tuple[Array, Array, Array]:
    """Return (Jv (4, 3, 8), Jw (4, 3, 8), A (5, 8)) at c."""
    Jv, Jw, height = np.empty((4, 3, 8)), np.empty((4, 3, 8)), np.empty(8)
    centres, turned, contacts = places(p, c)
    for k in range(8):
        moved, rotated, touched = places(p, c + 1j * COMPLEX_STEP * np.eye(8)[k])
        for b in range(4):
            spin = (rotated[b].imag / COMPLEX_STEP) @ turned[b].T
            Jv[b, :, k], Jw[b, :, k] = moved[b].imag / COMPLEX_STEP, (spin[2, 1], spin[0, 2], spin[1, 0])
        height[k] = touched[1].imag[2] / COMPLEX_STEP
    slips = [
        (Jv[b] + np.cross(Jw[b], contact - centres[b], axisa=0, axisc=0))[:2]
        for b, contact in zip((0, 3), contacts, strict=True)
    ]
    return Jv, Jw, np.vstack([height, *slips])


def rates(p: Any, c: Array, c_dot: Array) -> tuple[Array, Array, Array]:
    """Return d/dt of `jacobians` along c_dot."""
    found: list[Array] = 3 * [np.zeros(())]
    for k, weight in DIFFERENCE_WEIGHTS.items():
        ahead, behind = jacobians(p, c + k * DIFFERENCE_STEP * c_dot), jacobians(p, c - k * DIFFERENCE_STEP * c_dot)
        found = [x + weight * (a - b) / DIFFERENCE_STEP for x, a, b in zip(found, ahead, behind, strict=True)]
    return found[0], found[1], found[2]


def inertias(p: Any) -> tuple[Array, Array]:
    """Return masses (4,) and inertias (4, 3, 3) about the centres of mass, body axes."""
    wheels = [np.diag([getattr(p, f"I{k}xx"), getattr(p, f"I{k}yy"), getattr(p, f"I{k}xx")]) for k in "RF"]
    bodies = []
    for k in "BH":
        xx, yy, zz, xz = (getattr(p, f"I{k}{axes}") for axes in ("xx", "yy", "zz", "xz"))
        bodies.append(np.array([[xx, 0, xz], [0, yy, 0], [xz, 0, zz]]))
    return np.array([p.mR, p.mB, p.mH, p.mF]), np.array([wheels[0], *bodies, wheels[1]])


def accelerations(p: Any, c: Array, c_dot: Array) -> Array:
    """Return c_ddot without torques of a rider, shape (8,)."""
    (m, I), (_, turned, _) = inertias(p), places(p, c)
    (Jv, Jw, A), (Jv_dot, Jw_dot, A_dot) = jacobians(p, c), rates(p, c, c_dot)
    M, F = np.zeros((8, 8)), np.zeros(8)
    for b in range(4):
        J = turned[b] @ I[b] @ turned[b].T
        w = Jw[b] @ c_dot
        M += m[b] * Jv[b].T @ Jv[b] + Jw[b].T @ J @ Jw[b]
        F += m[b] * Jv[b].T @ (p.g * Z - Jv_dot[b] @ c_dot) - Jw[b].T @ (J @ Jw_dot[b] @ c_dot + np.cross(w, J @ w))
    saddle = np.block([[M, A.T], [A, np.zeros((5, 5))]])
    return np.linalg.solve(saddle, np.concatenate([F, -A_dot @ c_dot]))[:8]


def state(p: Any, lean: float, steer: float, given: Array, pitch: float = 0.0) -> tuple[Array, Array]:
    """Return (c, c_dot) with both wheels on the ground; ``given`` are lean rate, steer rate and speed r_R |rear
    spin|."""
    c = np.array([0.0, 0.0, 0.0, lean, pitch, steer, 0.0, 0.0])
    for _ in range(50):
        step = -places(p, c)[2][1][2] / jacobians(p, c)[2][0, 4]
        c[4] += step
        if abs(step) < 1e-16:
            break
    A = jacobians(p, c)[2]
    chosen, rest = [3, 5, 6], [0, 1, 2, 4, 7]
    c_dot = np.zeros(8)
    c_dot[chosen] = given[0], given[1], -given[2] / p.rR  # y points to the right: a wheel that rolls forward turns back
    c_dot[rest] = np.linalg.solve(A[:, rest], -A[:, chosen] @ c_dot[chosen])
    return c, c_dot
