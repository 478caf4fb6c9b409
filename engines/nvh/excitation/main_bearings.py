"""Loads of the main bearings of an engine over a cycle, from the multipliers of a crank that is cut in its bearings.

A crank of one piece in three or more bearings is indeterminate. As is usual, every throw is a body of its own in two
bearings half a gap beyond its cylinders, those of a V side by side on it; throws hand on torque, no bending. A bearing
carries the ends of the throws on both sides. The weight of the flywheel is left out, the block stands still.
"""

from dataclasses import dataclass

import numpy as np

from engines.balance import spatial
from engines.balance.gas import forces as gas_forces
from engines.nvh.excitation.loads import Source, along
from engines.nvh.excitation.presets import THROW_INERTIA_RATIOS
from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Force,
    Joint,
    Kinematic,
    Perpendicular,
    PointOnLine,
    PointOnPlane,
    Ramp,
    Revolute,
    RollingBearing,
    Solution,
    System,
    Table,
    inertia,
    simulate,
)  # fmt: skip

TURN_SAMPLES = 180  # [1] samples of a turn
ROLLER_LIFE_EXPONENT = 10.0 / 3.0  # [1] of the life of roller bearings, ISO 281
BEARING_SPACING_RATIO = 0.4  # [1] of the bore spacing; nearer cylinders have no bearing between them
Z = spatial.Z


@dataclass(frozen=True)
class Bearing:
    """A main bearing over a cycle: ``name``; ``angle`` (s,) [degrees]; ``force`` (s, 2): of the block on the crank, in
    the plane of the cylinders [N]; ``pressure``: largest over diameter times width [Pa]; ``mean``: equivalent load of a
    roller bearing [N]; ``hours``: its L10h [h].
    """

    name: str
    angle: np.ndarray
    force: np.ndarray
    pressure: float
    mean: float
    hours: float

    @property
    def radial(self) -> np.ndarray:
        """Return the radial force [N], shape (s,)."""
        return np.linalg.norm(self.force, axis=1)


def cut_engine(source: Source, rpm: float) -> tuple[System, np.ndarray]:
    """Build the engine with a throw of the crank for cylinders side by side; return it with the places of its main
    bearings [m].

    Joints "front k", "rear k" of throw k, "bore i"; axes of `engines.balance`: the crank along z.
    """
    engine = source.preset.engine(rpm)
    places = [spatial.place(engine, i) for i in range(len(engine.layout.pins))]
    order, stations = np.argsort(engine.stations, kind="stable"), np.sort(engine.stations)
    gaps = np.flatnonzero(np.diff(stations) > BEARING_SPACING_RATIO * engine.spacing)
    mains = np.array([engine.ends[0], *(stations[gaps] + stations[gaps + 1]) / 2, engine.ends[1]])
    bodies: list[Body] = []
    joints: list[Joint] = []
    loads = []
    for k, mine in enumerate(np.split(order, gaps + 1)):
        throw = throw_of([places[i].throw for i in mine], source.preset.throw_mass, engine.radius, f"throw {k + 1}")
        ends = zip(("front", "rear"), mains[k : k + 2], strict=True)
        joints += [PointOnLine(GROUND, throw, at=(0, 0, at), axis=Z, name=f"{end} {k + 1}") for end, at in ends]
        joints.append(PointOnPlane(GROUND, throw, at=(0, 0, mains[k]), normal=Z, name=f"thrust {k + 1}"))
        for i in mine:
            new_bodies, new_joints = spatial.cylinder(engine, i, places[i], throw, GROUND, "spherical")
            bodies += new_bodies
            joints += new_joints
        bodies.append(throw)
    throws = [body for body in bodies if body.name.startswith("throw")]
    dyno = Body("dyno", 1.0, (0.1, 0.1, 0.2), position=(0, 0, mains[-1] + engine.spacing))
    shaft = Revolute(GROUND, dyno, at=dyno.position, axis=Z, name="shaft")
    for a, b in zip([*throws[1:], dyno], throws, strict=True):
        joints.append(Perpendicular(a, b, axis_a=(1, 0, 0), axis_b=(0, 1, 0), name=f"torque of {b.name}"))
    joints += [shaft, AngleDriver(shaft, Ramp(engine.rate), name="motor")]
    if source.cycle is not None:
        times = 4 * np.pi / engine.rate * np.arange(4 * TURN_SAMPLES + 1) / (4 * TURN_SAMPLES)
        pushes = gas_forces(engine, source.cycle.force, engine.rate * times)
        pistons = {body.name: body for body in bodies}
        for i, (push, where) in enumerate(zip(pushes.T, places, strict=True), start=1):
            loads.append(Force(pistons[f"piston {i}"], along(-where.bore, Table(times, push)), name=f"gas {i}"))
    return System([*bodies, dyno], joints, loads, gravity=(0, 0, 0)), mains


def throw_of(centres: list[np.ndarray], mass: float, radius: float, name: str) -> Body:
    """Return the throws of one station as one body with its reference point on the axis."""
    own = mass * radius**2 * np.array(THROW_INERTIA_RATIOS)
    whole = inertia.combine([(mass, centre, own) for centre in centres])
    return Body(name, whole.mass, whole.inertia, com=whole.com)


def cycle_run(source: Source, rpm: float) -> tuple[Solution, np.ndarray]:
    """Simulate two turns of the cut engine by kinematics; return them with the places of its main bearings."""
    system, mains = cut_engine(source, rpm)
    end = 4 * np.pi / source.preset.engine(rpm).rate
    return simulate(system, end, method=Kinematic(), output=2 * TURN_SAMPLES + 1), mains


def main_bearings(source: Source, rpm: float) -> list[Bearing]:
    """Return the main bearings over a cycle, from the free end on."""
    solution, mains = cycle_run(source, rpm)
    rate, preset, found = source.preset.engine(rpm).rate, source.preset, []
    roller = RollingBearing(C=preset.roller_rating, p=ROLLER_LIFE_EXPONENT)
    for k in range(mains.size):
        ends = [f"rear {k}"] * (k > 0) + [f"front {k + 1}"] * (k < mains.size - 1)
        force = np.sum([solution.reaction(end).force[:, :2] for end in ends], axis=0)
        radial = np.linalg.norm(force, axis=1)
        life = roller.life_of(solution.t, radial, np.full(radial.size, rate))
        pressure = float(radial.max() / (preset.main_diameter * preset.main_width))
        angle = np.degrees(rate * solution.t)
        found.append(Bearing(f"main {k + 1}", angle, force, pressure, life.load, life.hours))
    return found
