"""Load on the block from planar models alone: one slider-crank per cylinder, summed over their planes.

Cylinder i of the plane z_i loads the block with the reactions of bearing, bore and driver turned round, (F_x, F_y)
and C about the crank axis. The sum of planes is

    F = sum F_i,   M = sum (-z_i F_iy, z_i F_ix, C_i)
"""

import numpy as np

from engines import planar
from engines.balance.harmonics import Harmonics
from engines.balance.layouts import Engine


def build(engine: Engine, i: int, gravity: tuple[float, float] = (0.0, 0.0)) -> planar.System:
    """Build cylinder i (from 0) as a planar mechanism at q = 0: "crank", "rod", "piston"; "bearing", "bore",
    "motor"."""
    alpha, beta = np.radians(engine.layout.pins[i]), np.radians(engine.layout.bores[i])
    u, v = np.array([np.cos(beta), np.sin(beta)]), np.array([-np.sin(beta), np.cos(beta)])
    R, L, e = engine.radius, engine.rod_length, engine.offset
    pin = R * np.array([np.cos(alpha), np.sin(alpha)])
    wrist = e * v + (pin @ u + np.sqrt(L**2 - (e - pin @ v) ** 2)) * u
    lean = np.arctan2(*(wrist - pin)[::-1])
    centre, throw = pin + engine.rod_fraction * (wrist - pin), (engine.crank_centre, 0.0)
    crank = planar.Body("crank", engine.crank_mass, engine.crank_mass * R**2, com=throw, angle=alpha)
    rod = planar.Body("rod", engine.rod_mass, engine.rod_inertia, position=centre, angle=lean)
    piston = planar.Body("piston", engine.pistons[i], engine.pistons[i] * R**2, position=wrist)
    bearing = planar.Revolute(planar.GROUND, crank, at=(0, 0), name="bearing")
    joints = [
        bearing,
        planar.Revolute(crank, rod, at=pin, name="crankpin"),
        planar.Revolute(rod, piston, at=wrist, name="wristpin"),
        planar.Slider(planar.GROUND, piston, at=wrist, axis=u, name="bore"),
        planar.AngleDriver(bearing, planar.rate(engine.rate), name="motor"),
    ]
    return planar.System([crank, rod, piston], joints, gravity=gravity)


def plane_load(solution: planar.Solution) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return force (samples, 2) [N] and couple about the crank axis [N m] of one cylinder on the block, and its driving
    torque [N m].
    """
    bearing, bore, torque = solution.reaction("bearing"), solution.reaction("bore"), solution.effort("motor")
    lever = bore.point[:, 0] * bore.force[:, 1] - bore.point[:, 1] * bore.force[:, 0]
    return (-bearing.force - bore.force, -(lever + bore.moment + torque), torque)


def harmonics(
    engine: Engine,
    orders: int = 6,
    *,
    article: bool = False,
    gravity: tuple[float, float] = (0.0, 0.0),
    dyno: bool = False,
) -> Harmonics:
    """Compute the harmonics 0 ... ``orders`` of the sum of planar models.

    ``article``: true drops the velocity-quadratic term m w x (w x s), as the published planar solver did: of the crank,
    since rod and piston are described about their centres of mass; ``gravity`` (2,): [m/s^2]; ``dyno``: the
    driving torque reacts outside of the block.
    """
    n = engine.samples(orders)
    times = 2 * np.pi / engine.rate * np.arange(n) / n
    force, moment, torque = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros(n)
    for i, z in enumerate(engine.stations):
        model = build(engine, i, gravity)
        push, couple, effort = plane_load(planar.kinematics(model, times, centripetal=not article))
        force[:, :2] += push
        moment += np.column_stack([-z * push[:, 1], z * push[:, 0], couple + dyno * effort])
        torque += effort
    return Harmonics(*(projected(values, orders) for values in (force, moment, torque)))


def projected(values: np.ndarray, orders: int) -> np.ndarray:
    """Return the phasors ``c_n = (2 / N) sum_k values_k exp(-2 pi i n k / N)``, half of it for n = 0, of one turn."""
    turn = np.outer(np.arange(orders + 1), np.arange(len(values))) / len(values)
    c = 2 / len(values) * np.tensordot(np.exp(-2j * np.pi * turn), values, axes=1)
    c[0] /= 2
    return c
