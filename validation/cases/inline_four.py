"""Inline four in space: one crank with four throws, four rods, four pistons; every row independent.

The crank turns about y, the bores point along z, the cylinders are side by side along y, evenly about the origin:

    pin i = R (sin q_i, 0, cos q_i) + y_i e_y,   q_i = q + (0, 180, 180, 0) degrees,   q = rate t

Each throw carries the mass ``crank_mass`` at ``crank_centre`` from the axis. A spherical crankpin and a universal
wristpin leave the rod no degree of freedom and no redundant row: 9 bodies, 54 coordinates, 54 rows with the driver.
"""

import numpy as np

import mbsd3d
from mbsd3d.errors import InputError

CRANK_RATE = 2 * np.pi * 10 / 60  # [rad/s] 10 rpm, the toy engine of references/engine.json
THROW_SIDES = (1.0, -1.0, -1.0, 1.0)  # throws up or down at the reference pose
CYLINDER_PLACES = np.array([-1.5, -0.5, 0.5, 1.5])  # [1] of the cylinders along the crank, in units of the spacing
TURN_SAMPLES = 36  # [1] every 10 degrees of one turn; orders from 32 on alias, 1e-12 of those measured for R/L <= 2/3


def inline_four(
    radius: float = 1.0, rod_length: float = 2.0, *, rate: float = CRANK_RATE,
    spacing: float = 0.2, crank_mass: float = 2.0,
    crank_centre: float = 0.5, rod_mass: float = 4.0, rod_fraction: float = 0.5, rod_inertia: float = 1 / 3,
    piston_mass: float = 5.0,
) -> mbsd3d.System:  # fmt: skip
    """Build the engine at q = 0, pistons 1 and 4 up, without gravity.

    ``radius, rod_length``: crank radius R and rod length L > R [m]; ``rate``: crank speed [rad/s]; ``spacing``:
    distance of neighbouring cylinders [m]; ``crank_mass, crank_centre``: mass of one throw [kg] and distance of its
    centre of mass from the axis [m]; ``rod_mass, rod_fraction, rod_inertia``: [kg]; distance of the rod's centre of
    mass from the crankpin over L; inertia about it, across the rod [kg m^2]; ``piston_mass``: [kg]. Bodies
    "crank", "rod 1" ... "piston 4"; joints "bearing", "crankpin 1", "wristpin 1", "bore 1" ...; "motor". ValueError if
    the rod is not longer than the crank.

    Examples
    --------
    >>> inline_four().check().mobility
    0
    """
    if not 0.0 < radius < rod_length:
        raise InputError(f"inline_four: rod_length {rod_length} m must exceed the crank radius {radius} m, and that 0")
    crank = crankshaft(spacing * CYLINDER_PLACES, crank_mass, crank_centre)
    bearing = mbsd3d.Revolute(mbsd3d.GROUND, crank, at=(0, 0, 0), axis=(0, 1, 0), name="bearing")
    bodies, joints = [crank], [bearing, mbsd3d.AngleDriver(bearing, mbsd3d.Ramp(rate), name="motor")]
    for i, (place, side) in enumerate(zip(spacing * CYLINDER_PLACES, THROW_SIDES, strict=True), start=1):
        pin, wrist = np.array([0.0, place, side * radius]), np.array([0.0, place, side * radius + rod_length])
        moments = (rod_inertia, rod_inertia, 0.03 * rod_inertia)
        rod = mbsd3d.Body(f"rod {i}", rod_mass, moments, com=(0, 0, rod_fraction * rod_length), position=pin)
        piston = mbsd3d.Body(f"piston {i}", piston_mass, (0.2 * piston_mass,) * 3, position=wrist)
        bodies += [rod, piston]
        joints += [
            mbsd3d.Spherical(crank, rod, at=pin, name=f"crankpin {i}"),
            mbsd3d.Universal(piston, rod, at=wrist, axis_a=(0, 1, 0), axis_b=(1, 0, 0), name=f"wristpin {i}"),
            mbsd3d.Prismatic(mbsd3d.GROUND, piston, at=wrist, axis=(0, 0, 1), name=f"bore {i}"),
        ]
    return mbsd3d.System(bodies, joints, gravity=(0, 0, 0))


def crankshaft(places: np.ndarray, mass: float, centre: float) -> mbsd3d.Body:
    """Return four throws as one body with its reference point on the axis; each with its moments of inertia."""
    at = np.stack([np.zeros(4), places, centre * np.array(THROW_SIDES)], axis=1)
    com = at.mean(axis=0)
    arms = at - com
    inertia = mass * (np.sum(arms**2) * np.eye(3) - arms.T @ arms + 4 * np.diag([0.01, 0.02, 0.01]))
    return mbsd3d.Body("crank", 4 * mass, inertia, com=com)


def block_force(solution: mbsd3d.Solution) -> np.ndarray:
    """Return the force of bearing and bores on the block [N], shape (samples, 3)."""
    names = ["bearing", *(f"bore {i}" for i in range(1, 5))]
    return -np.sum([solution.reaction(name).force for name in names], axis=0)


def amplitudes(values: np.ndarray) -> np.ndarray:
    """Return the amplitudes of the orders 0, 1, 2 ... of one turn of samples, the last one a repetition of the
    first."""
    return 2 * np.abs(np.fft.rfft(values[:-1])) / (values.size - 1)


def orders(solution: mbsd3d.Solution) -> dict[str, float]:
    """Return the amplitudes at 1, 2 and 4 times crank speed of the force on the block along the bores [N], and of the
    torque [N m].
    """
    force, torque = amplitudes(block_force(solution)[:, 2]), amplitudes(solution.effort("motor"))
    return {f"force_{order}x": float(force[order]) for order in (1, 2, 4)} | {"torque_2x": float(torque[2])}
