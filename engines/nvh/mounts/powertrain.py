"""Engine with a free block: the moving crank train in space, and its equivalent rigid body and rotor.

The moving engine is that of `engines.balance.spatial`, turned into car axes (x along the crank, z up the middle of the
bores), with a dyno on the ground that turns the crank evenly and bears torque alone. Of its mass matrix about the
middle of the crank, for motions of the block with the dyno turning on,

    M(q) = N'M N,   N = [1; -J_o^+ J_block]   the motions of all bodies that one of the block causes

the mean over a turn is that of a rigid body (mass, centre of mass, inertia: `Equivalent`), and the mean angular
momentum of the moving parts is that of a rotor, H = J w. What is left out, parts of M at twice the crank speed and
more, turns an order of the motion into its neighbours, by the share of the pistons in the mass.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from engines.balance import looks, shafts, spatial
from engines.balance.layouts import Engine
from engines.balance.pages.portrait import turned, upright
from engines.balance.shafts import Shaft
from engines.nvh.excitation.presets import THROW_INERTIA_RATIOS, Preset
from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Fixed,
    Kinematic,
    Perpendicular,
    Ramp,
    Revolute,
    Solution,
    SpeedDriver,
    State,
    System,
    inertia,
    shapes,
    simulate,
)  # fmt: skip
from mbsd3d.errors import InputError
from mbsd3d.extend import DenseEquations, skew

X = (1.0, 0.0, 0.0)
CRANK_ANGLES = 12  # [1] crank angles of a turn; harmonics of M up to 11 do not enter its mean
RIGID_TOLERANCE = 1e-6  # [1] relative difference of the mean mass matrix from that of a rigid body
DYNO_INERTIA = (0.2, 0.1, 0.1)  # [kg m^2] of the dynamometer, which turns at constant speed for any inertia
ROTOR_MASS_SHARE = 0.01  # [1] of the mass is in the rotor; only the sum counts


def moving_engine(
    preset: Preset, engine: Engine, fitted: Sequence[Shaft], *, frame: bool = True
) -> tuple[list[Body], list[Any]]:
    """Return (bodies, joints) of the engine with a free block, car axes, at q = 0: "block", "crank", "rod 1" ...,
    "dyno".

    ``fitted``: balance shafts, geared to the crank; ``frame``: draw the block as an open frame: the crank is seen.
    """
    R, block = upright(engine.layout), preset.block
    places = [spatial.place(engine, i) for i in range(len(engine.layout.pins))]
    drawn = looks.block(engine, places) if frame else None
    housing = Body("block", block.mass, R.T @ block.inertia @ R, com=R.T @ block.com, shape=drawn)
    crank = crankshaft(preset, engine, places)
    main = Revolute(housing, crank, at=(0, 0, 0), axis=spatial.Z, name="main 1")
    parts = [spatial.cylinder(engine, i, where, crank, housing, "spherical") for i, where in enumerate(places)]
    bodies, joints = ([part for some in kind for part in some] for kind in zip(*parts, strict=True))
    whole = turned(shafts.with_shafts(System([housing, crank, *bodies], [main, *joints]), engine, fitted), R)
    crank, end = whole.part("crank", "bodies"), engine.ends[1] + 1.5 * engine.spacing
    disc = shapes.Disc(0.6 * engine.radius, 0.3 * engine.spacing, "x", colour=looks.CASE)
    dyno = Body("dyno", 1.0, DYNO_INERTIA, position=(end, 0, 0), shape=disc)
    shaft = Revolute(GROUND, dyno, at=(end, 0, 0), axis=X, name="dyno bearing")
    coupling = Perpendicular(dyno, crank, axis_a=(0, 1, 0), axis_b=(0, 0, 1), name="coupling")
    drive = AngleDriver(shaft, Ramp(engine.rate), name="motor")
    return [*whole.bodies, dyno], [*whole.joints, shaft, coupling, drive]


def crankshaft(preset: Preset, engine: Engine, places: list[spatial.Place]) -> Body:
    """Return the throws with their counterweights, and the flywheel behind the last main bearing, as one body; axis
    along z.
    """
    swing, end = preset.throw_mass * engine.radius**2, engine.ends[1] + engine.spacing / 2
    parts = [(preset.throw_mass, where.throw, swing * np.array(THROW_INERTIA_RATIOS)) for where in places]
    J, radius = preset.flywheel, max(2.2 * engine.radius, 0.09)
    whole = inertia.combine([*parts, (2 * J / radius**2, (0, 0, end), (J / 2, J / 2, J))])
    wheel = shapes.Cylinder(radius, 0.15 * engine.spacing, "z", at=(0, 0, end), colour=looks.STEEL)
    return Body("crank", whole.mass, whole.inertia, com=whole.com, shape=[*looks.crank(engine, places), wheel])


@dataclass(frozen=True)
class Equivalent:
    """Rigid body and rotor equivalent to an engine, about the middle of the crank, car axes.

    ``mass`` [kg]; ``com`` (3,) [m]; ``inertia`` (3, 3): about the centre of mass [kg m^2], without what turns evenly
    about x; ``rotor``: J of H = J w [kg m^2].
    """

    mass: float
    com: np.ndarray
    inertia: np.ndarray
    rotor: float

    @cached_property
    def bodies(self) -> tuple[Body, Body]:
        """Return the bodies "powertrain" and "rotor": the rotor has `ROTOR_MASS_SHARE` of the mass, on the crank."""
        light = ROTOR_MASS_SHARE * self.mass
        disc = np.diag([self.rotor, self.rotor / 2, self.rotor / 2])
        com = self.com * self.mass / (self.mass - light)
        about = self.inertia + self.mass * (self.com @ self.com * np.eye(3) - np.outer(self.com, self.com))
        left = about - np.diag([0.0, self.rotor / 2, self.rotor / 2])
        left -= (self.mass - light) * (com @ com * np.eye(3) - np.outer(com, com))
        return Body("powertrain", self.mass - light, left, com=com), Body("rotor", light, disc)

    def system(self, forces: Any, rate: float) -> System:
        """Build both bodies with ``forces(body)`` on the powertrain and the rotor at a rate [rad/s]; no weight."""
        body, rotor = self.bodies
        hinge = Revolute(body, rotor, at=(0, 0, 0), axis=X, name="crank axis")
        even = SpeedDriver(GROUND, rotor, axis=X, speed=rate, name="even speed")
        return System([body, rotor], [hinge, even], forces(body), gravity=(0, 0, 0))

    @property
    def rigid(self) -> Body:
        """Return both bodies as one body at rest, "powertrain", the rotor locked."""
        locked = self.inertia + np.diag([self.rotor, 0.0, 0.0])
        return Body("powertrain", self.mass, locked, com=self.com)


def free_mass(dense: DenseEquations, state: State) -> np.ndarray:
    """Return the mass matrix N'M N of a system whose first body has six degrees of freedom and carries the rest, shape
    (6, 6).
    """
    terms = dense.at(state)
    N = carried(terms.J)
    return N.T @ terms.M @ N


def carried(J: np.ndarray) -> np.ndarray:
    """Return N, the velocities of all bodies that a velocity of the first one causes, for rows J, shape (6 n, 6)."""
    return np.vstack([np.eye(6), -np.linalg.lstsq(J[:, 6:], J[:, :6], rcond=1e-11)[0]])


def equivalent(preset: Preset, fitted: Sequence[Shaft] = ()) -> Equivalent:
    """Return the mean of the moving engine with its balance shafts; raise ValueError if it is not that of a rigid
    body."""
    engine = preset.engine(1000.0)
    bodies, joints = moving_engine(preset, engine, fitted, frame=False)
    system = System(bodies, joints, gravity=(0, 0, 0))
    still = held(bodies, joints, engine)
    states = [State(0.0, (at := still.state(k)).q, at.v) for k in range(CRANK_ANGLES)]
    dense = DenseEquations(system)
    M = np.mean([free_mass(dense, state) for state in states], axis=0)
    mass = float(M[0, 0])
    com = np.array([M[5, 1], M[3, 2], M[4, 0]]) / mass
    rigid = np.block([[mass * np.eye(3), -mass * skew(com)], [mass * skew(com), M[3:, 3:]]])
    off = np.abs(M - rigid).max() / mass
    if off > RIGID_TOLERANCE:
        raise InputError(f"engine '{preset.name}': its mean mass matrix is {off:.1g} off that of a rigid body")
    momentum = np.mean(still.momentum().angular[:CRANK_ANGLES, 0]) - DYNO_INERTIA[0] * engine.rate
    about = M[3:, 3:] - mass * (com @ com * np.eye(3) - np.outer(com, com))
    return Equivalent(mass, com, about, float(momentum / engine.rate))


def held(bodies: list[Body], joints: list[Any], engine: Engine) -> Solution:
    """Simulate a turn with the block fixed, ``CRANK_ANGLES`` samples and the first again."""
    mount = Fixed(GROUND, bodies[0], at=(0, 0, 0), name="mount")
    system = System(bodies, [*joints, mount], gravity=(0, 0, 0))
    return simulate(system, 2 * np.pi / engine.rate, method=Kinematic(), output=CRANK_ANGLES + 1)
