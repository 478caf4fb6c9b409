"""Whole engine in space: crank, rods and pistons on a block held by one fixed joint.

The main bearings are redundant on purpose, with hinges as pins the rods too; the reaction of the fixed joint is unique
all the same. It carries the load of the moving parts on the block, turned round, and the block's own weight:

    F = -F_mount - m_block g,    M = -M_mount      about the origin, where the block has its centre of mass
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

import mbsd3d
from engines.balance import looks
from engines.balance.harmonics import Harmonics
from engines.balance.layouts import Engine
from mbsd3d import spectrum
from mbsd3d.errors import InputError
from mbsd3d.extend import Ground

Z = (0.0, 0.0, 1.0)
BLOCK_MASS = 100.0  # kg; at rest, only its weight counts


@dataclass(frozen=True)
class Place:
    """Positions of the parts of cylinder i at the reference pose, world axes [m]."""

    pin: np.ndarray
    wrist: np.ndarray
    throw: np.ndarray  # Centre of mass of the throw
    bore: np.ndarray  # Direction of the bore, towards the head


def place(engine: Engine, i: int) -> Place:
    """Return the positions of the parts of cylinder i (from 0) at q = 0 [m]."""
    alpha, beta, z = np.radians(engine.layout.pins[i]), np.radians(engine.layout.bores[i]), engine.stations[i]
    throw, u = np.array([np.cos(alpha), np.sin(alpha), 0.0]), np.array([np.cos(beta), np.sin(beta), 0.0])
    v, centre = np.cross(Z, u), np.array([0.0, 0.0, z])
    pin = engine.radius * throw
    reach = np.sqrt(engine.rod_length**2 - (pin @ v - engine.offset) ** 2)
    wrist = (pin @ u + reach) * u + engine.offset * v
    return Place(centre + pin, centre + wrist, centre + engine.crank_centre * throw, u)


def build(
    engine: Engine, *, pins: str = "spherical", driver: str = "block", gravity: Any = (0.0, 0.0, 0.0), bearings: int = 2
) -> mbsd3d.System:
    """Build the engine at q = 0 as a mechanism.

    ``pins``: "spherical": the rods have a ball and a universal joint, all their rows are independent; "revolute":
    on two hinges, three rows of each cylinder repeat others; ``driver``: "block": the driving torque reacts on the
    block; "dyno": on the ground, through a coupling of torque only; ``gravity`` (3,): [m/s^2]; ``bearings``: main
    bearings, evenly from end to end. Bodies "block", "crank", "rod 1", "piston 1" ...; joints "mount", "main 1"
    ..., "crankpin 1", "wristpin 1", "bore 1" ...; "motor". ValueError for an unknown option, or at rpm 0.
    """
    what = f"engine '{engine.layout.name}'"
    if pins not in ("revolute", "spherical"):
        raise InputError(f"{what}: pins {pins!r} are unknown; give 'revolute' or 'spherical'")
    if driver not in ("block", "dyno"):
        raise InputError(f"{what}: driver on {driver!r}; give 'block' or 'dyno'")
    if bearings < 1:
        raise InputError(f"{what}: {bearings} main bearings; give 1 or more")
    places = [place(engine, i) for i in range(len(engine.layout.pins))]
    block = mbsd3d.Body("block", BLOCK_MASS, 3 * (BLOCK_MASS,), shape=looks.block(engine, places))
    crank = crankshaft(engine, places)
    mount = mbsd3d.Fixed(mbsd3d.GROUND, block, at=(0, 0, 0), name="mount")
    seats = np.linspace(*engine.ends, bearings) if bearings > 1 else [0.0]
    mains = [
        mbsd3d.Revolute(block, crank, at=(0, 0, z), axis=Z, name=f"main {k}") for k, z in enumerate(seats, start=1)
    ]
    parts = [cylinder(engine, i, where, crank, block, pins) for i, where in enumerate(places)]
    parts.append(motor(engine, crank, mains[0], driver))
    bodies, joints = ([part for some in kind for part in some] for kind in zip(*parts, strict=True))
    return mbsd3d.System([block, crank, *bodies], [mount, *mains, *joints], gravity=gravity)


def crankshaft(engine: Engine, places: list[Place]) -> mbsd3d.Body:
    """Return all throws as one body with its reference point on the axis; throws of different cylinders may share a
    pin.
    """
    mass, swing = engine.crank_mass, engine.crank_mass * engine.radius**2
    throws = [(mass, where.throw, swing * np.array([0.02, 0.02, 0.03])) for where in places]
    whole = mbsd3d.inertia.combine(throws)
    return mbsd3d.Body("crank", whole.mass, whole.inertia, com=whole.com, shape=looks.crank(engine, places))


def cylinder(
    engine: Engine, i: int, where: Place, crank: mbsd3d.Body, block: mbsd3d.Body | Ground, pins: str
) -> tuple[list[mbsd3d.Body], list[mbsd3d.Joint]]:
    """Return rod and piston of cylinder i (from 0), and their joints; the reference points are the centres of mass."""
    x = (where.wrist - where.pin) / engine.rod_length
    turn = np.column_stack([x, np.cross(Z, x), Z])
    centre, thin = where.pin + engine.rod_fraction * engine.rod_length * x, 0.03 * engine.rod_inertia
    moments = (thin, engine.rod_inertia, engine.rod_inertia)
    rod_shape, piston_shape = looks.rod(engine), looks.piston(engine, where.bore)
    rod = mbsd3d.Body(f"rod {i + 1}", engine.rod_mass, moments, position=centre, orientation=turn, shape=rod_shape)
    mass = engine.pistons[i]
    own = 3 * (0.2 * mass * engine.radius**2,)
    piston = mbsd3d.Body(f"piston {i + 1}", mass, own, position=where.wrist, shape=piston_shape)
    big, small = f"crankpin {i + 1}", f"wristpin {i + 1}"
    joints: list[mbsd3d.Joint]
    if pins == "revolute":
        joints = [mbsd3d.Revolute(crank, rod, at=where.pin, axis=Z, name=big),
                  mbsd3d.Revolute(piston, rod, at=where.wrist, axis=Z, name=small)]  # fmt: skip
    else:
        joints = [mbsd3d.Spherical(crank, rod, at=where.pin, name=big),
                  mbsd3d.Universal(piston, rod, at=where.wrist, axis_a=Z, axis_b=turn[:, 1], name=small)]  # fmt: skip
    bore = mbsd3d.Prismatic(block, piston, at=where.wrist, axis=where.bore, name=f"bore {i + 1}")
    return [rod, piston], [*joints, bore]


def motor(
    engine: Engine, crank: mbsd3d.Body, main: mbsd3d.Revolute, driver: str
) -> tuple[list[mbsd3d.Body], list[mbsd3d.Joint]]:
    """Return the parts that keep the crank at constant speed: a driver in the first main bearing, or a rotor beside the
    engine.

    Rotor and crank share one row, x of the rotor at right angles to y of the crank, which bears torque about z only.
    """
    if driver == "block":
        return [], [mbsd3d.AngleDriver(main, mbsd3d.Ramp(engine.rate), name="motor")]
    end = engine.ends[1] + engine.spacing
    rotor = mbsd3d.Body("dyno", 1.0, (0.1, 0.1, 0.2), position=(0, 0, end), shape=looks.dyno(engine))
    shaft = mbsd3d.Revolute(mbsd3d.GROUND, rotor, at=(0, 0, end), axis=Z, name="dyno bearing")
    coupling = mbsd3d.Perpendicular(rotor, crank, axis_a=(1, 0, 0), axis_b=(0, 1, 0), name="coupling")
    return [rotor], [shaft, coupling, mbsd3d.AngleDriver(shaft, mbsd3d.Ramp(engine.rate), name="motor")]


def turn(
    system: mbsd3d.System, engine: Engine, *, turns: int = 1, count: int | None = None, **options: Any
) -> mbsd3d.Solution:
    """Simulate whole turns of the crank at constant speed by kinematics, ``count`` samples a turn and the first one
    again.
    """
    n = turns * (count or engine.samples())
    return mbsd3d.simulate(system, turns * 2 * np.pi / engine.rate, method=mbsd3d.Kinematic(), output=n + 1, **options)


def block_load(solution: mbsd3d.Solution) -> tuple[np.ndarray, np.ndarray]:
    """Return force [N] and moment about the origin [N m] of the moving parts on the block, (samples, 3) each, world
    axes.
    """
    mount, block = solution.reaction("mount"), solution.system.bodies[0]
    return -mount.force - block.mass * solution.system.gravity, -mount.moment


def harmonics(solution: mbsd3d.Solution, engine: Engine, orders: int = 6) -> Harmonics:
    """Return the harmonics 0 ... ``orders`` of block load and driving torque of whole turns."""
    force, moment = block_load(solution)
    every = np.column_stack([force, moment, solution.effort("motor")])
    seen = spectrum(solution.t, every, rate=engine.rate)
    found = np.array([seen.at(order) for order in range(orders + 1)])
    return Harmonics(found[:, :3], found[:, 3:6], found[:, 6])
