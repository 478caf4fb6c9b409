"""The shaft as a stack of slices, one per station."""

import numpy as np

from validation.engines import planar
from validation.planes.shaft import EXACT, Failure, Shaft, tensor


def throw(shaft: Shaft, joints: list, bodies: dict) -> complex:
    """Sum of the arms from the axis to the pins of a unit [m], x + i y; a weld is none."""
    crank = bodies[id(shaft.body)]
    pins = [joint for joint in joints if joint.a is crank and not isinstance(joint, planar.Fixed)]
    return complex(*sum((pin(joint, crank) - shaft.point for joint in pins), np.zeros(2)))


def pin(joint: planar.Joint, body: planar.Body) -> np.ndarray:
    """Where a hinge, massless rod or weld holds a body (2,) [m]."""
    if isinstance(joint, planar.Distance):
        return joint.at_a if joint.a is body else joint.at_b
    return joint.at


def cut(
    shaft: Shaft, z: np.ndarray, throws: np.ndarray, bodies: dict
) -> tuple[np.ndarray, list[planar.Body], list[Failure]]:
    """Heights and bodies of the slices of the shaft, and the product of inertia that they leave out.

    With U = m r_G and P = int (z - z_G) r dm as complex numbers x + i y from the axis: slice i of mass mu_i carries
    u s_i + (U - u sum s) mu_i / m, u by least squares from ``u sum s_i = U``, ``u sum (z_i - z_G) s_i = P``. Masses
    keep m and m z_G: the last slice, half of the shaft, is left out if the stations stand about z_G. A shaft that is no
    stack of such throws may do better with u = 0: then so.
    """
    body, k = shaft.body, len(z)
    com, inertia = shaft.rows.height(body.centre), tensor(shaft, body)
    whole = body.mass * complex(*(shaft.rows.flat(body.centre) - shaft.point))
    product = -complex(*inertia[:2, 2])
    rest = abs(z.mean() - com) > EXACT * shaft.rows.length
    heights = np.append(z, 2 * com - z.mean())[: k + rest]
    shares = np.append(np.full(k, (0.5 if rest else 1.0) / k), 0.5)[: k + rest]
    levers = np.array([throws.sum(), (z - com) @ throws / shaft.rows.length])
    moments = np.array([whole, product / shaft.rows.length])
    seen = np.linalg.norm(levers) > EXACT * np.abs(throws).max()
    found = [np.vdot(levers, moments) / np.vdot(levers, levers), 0.0] if seen else [0.0]
    u = min(found, key=lambda u: abs(product - u * ((z - com) @ throws)))
    carried = u * np.append(throws, 0.0)[: k + rest] + (whole - u * throws.sum()) * shares
    slices = [
        planar.Body(
            body.name, share * body.mass, share * inertia[2, 2], position=shaft.point,
            com=np.array([moment.real, moment.imag]) / (share * body.mass),
        )
        for share, moment in zip(shares, carried, strict=True)
    ]  # fmt: skip
    left = abs(product - u * ((z - com) @ throws))
    if left <= EXACT * np.trace(inertia):
        return heights, slices, []
    text = "has a product of inertia with its axis beyond that of its throws"
    return heights, slices, [Failure("H4", body.name, text, left, "kg m^2")]
