"""Forces of an engine on its mounts: the linear map over speed and orders, and the full run it must agree with.

Small motions of rigid body and rotor on the mounts (`state_space`) answer a load F about the middle of the crank by the
motion ``x = H F``. The rotor turns evenly at w and adds gyroscopic terms, so the dynamic stiffness H^-1 is linear in w,
and two rates hold all. What the mounts hand on is

    f = (K_j + i W C_j) u_j,     W = order * w,  u_j of the point of mount j
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import block_diag

from engines.balance.gas import forces as gas_forces
from engines.balance.pages.portrait import upright
from engines.nvh.excitation.loads import Source, along
from engines.nvh.mounts.mounts import Mount, bushings
from engines.nvh.mounts.powertrain import Equivalent, carried, moving_engine
from engines.nvh.mounts.rigid_modes import mass_matrix
from mbsd3d import (
    Body,
    Force,
    Input,
    Solution,
    State,
    StateSpace,
    System,
    Table,
    Torque,
    measures,
    simulate,
    spectrum,
    state_space,
)
from mbsd3d.errors import InputError
from mbsd3d.extend import DenseEquations, ForceElement, Measure, exponential, matrix, quaternion_from_matrix, skew

GAS_TABLE_POINTS = 720  # [1] points of the gas force over a cycle
RTOL = 1e-8
REFERENCE_RATE = 100.0  # [rad/s] of the second model; the dynamic stiffness is linear in the rate
LOADS = tuple(f"{kind} {axis}" for kind in ("force", "moment") for axis in "xyz")


@dataclass(frozen=True)
class Map:
    """Forces of the mounts on the car, by speed and order.

    ``rpm`` (s,); ``orders`` (n,); ``force`` (s, n, mounts, 3) phasors [N]; ``load`` (s, n, 6): of the engine on its
    block, about the middle of the crank; ``motion`` (s, n, 6): of the powertrain's middle of the crank [m], [rad].
    """

    rpm: np.ndarray
    orders: np.ndarray
    force: np.ndarray
    load: np.ndarray
    motion: np.ndarray

    @property
    def total(self) -> np.ndarray:
        """Return the sum of the forces over the mounts [N], shape (s, n, 3)."""
        return self.force.sum(axis=2)


@dataclass(frozen=True)
class OnMounts:
    """Powertrain on its mounts.

    ``torque``: that the engine gives on average [N m]; its reaction rolls the block, and small motions are those about
    that position; ``gyroscopic``: whether the crank's spin counts.
    """

    body: Equivalent
    placed: Sequence[Mount]
    torque: float = 0.0
    gyroscopic: bool = True

    def forces(self, body: Body) -> list[ForceElement]:
        """Return the mounts and the reaction to the mean torque as force elements."""
        return [*bushings(self.placed, body), Torque(body, (-self.torque, 0.0, 0.0), name="mean torque")]

    @cached_property
    def rest(self) -> np.ndarray:
        """Return position of the middle of the crank [m] and orientation under the mean torque without weight, shape
        (7,).
        """
        body = self.body.rigid
        return System([body], forces=self.forces(body), gravity=(0, 0, 0)).equilibrium().state.q

    @property
    def roll(self) -> float:
        """Return the roll angle of `rest` about x [rad]."""
        return float(2.0 * np.arctan2(self.rest[4], self.rest[3]))

    def model(self, rate: float) -> StateSpace:
        """Return the linear model about `rest` from force and moment at the middle of the crank, car axes, to its
        displacement and rotation and to their rates, the crank turning at a rate [rad/s].
        """
        spin = rate if self.gyroscopic else 0.0
        system = self.body.system(lambda body: [*self.forces(body), *pushed(body)], spin)
        axis = matrix(self.rest[3:])[:, 0]
        v = np.concatenate([np.zeros(9), axis * spin / axis[0]])
        start = State(0.0, np.tile(self.rest, 2), v)
        return state_space(system, start, inputs=LOADS, outputs=six_freedoms(system.bodies[0]))

    @cached_property
    def ends(self) -> tuple[StateSpace, StateSpace]:
        """Return `model` at rest and at `REFERENCE_RATE`."""
        return self.model(0.0), self.model(REFERENCE_RATE)

    def receptance(self, rate: float, W: np.ndarray) -> np.ndarray:
        """Return the motions (6) of the middle of the crank by loads (6) there at rates W, the crank turning at a rate
        [rad/s], shape (n, 6, 6).
        """
        still, turning = (np.linalg.inv(end.frequency_response(W).H[:, :6]) for end in self.ends)
        return np.linalg.inv(still + (turning - still) * (rate / REFERENCE_RATE))

    def answer(self, source: Source, rpm: ArrayLike) -> Map:
        """Compute the linear map over speeds [1/min] > 0; raise ValueError for others."""
        speeds = np.asarray(rpm, dtype=float)
        if speeds.size == 0 or not (speeds > 0).all():
            raise InputError(f"map: rpm from {speeds.min(initial=0.0):g}; give speeds above 0, the crank turns")
        turn = np.kron(np.eye(2), matrix(self.rest[3:]))
        force, load, motion = [], [], []
        for speed in speeds:
            rate, given = 2 * np.pi * speed / 60, source.at(speed)
            late = np.exp(-1j * given.orders * self.roll)[:, None]  # a crank angle counts from the block
            W, push = given.orders * rate, late * (given.six @ turn.T)
            x = (self.receptance(rate, W) @ push[..., None])[..., 0]
            x[0] = 0.0  # the mean is in `rest`
            motion.append(x)
            load.append(given.six)
            force.append(np.stack([self.handed_on(mount, x, W) for mount in self.placed], axis=1))
        return Map(speeds, given.orders, np.array(force), np.array(load), np.array(motion))

    def handed_on(self, mount: Mount, motion: np.ndarray, W: np.ndarray) -> np.ndarray:
        """Return the force of a mount on the car for motions (n, 6) of the middle of the crank at rates W [rad/s],
        shape (n, 3).
        """
        u = motion @ self.head(mount).T
        return u @ mount.stiffness + 1j * W[:, None] * (u @ mount.dampers)

    def head(self, mount: Mount) -> np.ndarray:
        """Return the matrix from the motion of the middle of the crank to that of a mount's head, shape (3, 6)."""
        return shift(matrix(self.rest[3:]) @ mount.at)[:3]

    def feet(self, rate: float, W: np.ndarray) -> np.ndarray:
        """Return the dynamic stiffness D of the mounts' feet at rates W, the crank turning [N/m], shape (n, 3 mounts, 3
        mounts).

        With Z of the mounts alone and Y the receptance of the mounted powertrain at their heads, ``D = Z - Z Y Z``.
        """
        heads = np.vstack([self.head(mount) for mount in self.placed])
        Y = heads @ self.receptance(rate, np.asarray(W)) @ heads.T
        k, c = (block_diag(*[getattr(mount, part) for mount in self.placed]) for part in ("stiffness", "dampers"))
        Z = k + 1j * np.asarray(W)[:, None, None] * c
        return Z - Z @ Y @ Z

    @property
    def mass(self) -> np.ndarray:
        """Return the mass matrix about the middle of the crank, axes of the block, shape (6, 6)."""
        rigid = shift(self.body.com)
        return rigid.T @ mass_matrix(self.body) @ rigid


def pushed(body: Body) -> list[ForceElement]:
    """Return the force and the moment on a body at the origin whose components are the inputs `LOADS`."""
    signals = tuple(Input(name) for name in LOADS)
    return [Force(body, signals[:3], at=(0, 0, 0), name="load"), Torque(body, signals[3:], name="load moment")]


def six_freedoms(body: Body) -> list[Measure]:
    """Return measures of a body at its reference point at the origin: displacement, rotation, and their rates."""
    axes, still = np.eye(3), dict(at=(0, 0, 0))
    moved = [measures.position(body, axis=axis, **still) for axis in axes]
    turned = [measures.lean(body, lateral=(0, 1, 0)), measures.lean(body, lateral=(-1, 0, 0)), measures.heading(body)]
    rates = [measures.velocity(body, axis=axis, **still) for axis in axes]
    return [*moved, *turned, *rates, *[measures.omega(body, axis=axis) for axis in axes]]


def shift(arm: np.ndarray) -> np.ndarray:
    """Return the matrix from displacement and rotation at a point to those at the point an arm away [m], shape (6,
    6)."""
    whole = np.eye(6)
    whole[:3, 3:] = -skew(arm)
    return whole


def whole_system(source: Source, held: OnMounts, rpm: float, cycles: int) -> System:
    """Build the moving engine on its mounts with its gas forces for whole cycles of two turns; no weight.

    The gas knows the crank angle from the block as it is rolled on average.
    """
    engine = source.preset.engine(rpm)
    bodies, joints = moving_engine(source.preset, engine, source.fitted)
    loads: list[ForceElement] = [*bushings(held.placed, bodies[0])]
    if source.cycle is not None:
        count = GAS_TABLE_POINTS * cycles
        times = 4 * np.pi / engine.rate * np.arange(count + 1) / GAS_TABLE_POINTS
        pushes = gas_forces(engine, source.cycle.force, engine.rate * times - held.roll)
        R, pistons = upright(engine.layout), {body.name: body for body in bodies}
        for i, (push, beta) in enumerate(zip(pushes.T, np.radians(engine.layout.bores), strict=True), start=1):
            piston, table = pistons[f"piston {i}"], Table(times, push)
            u = R @ (np.cos(beta), np.sin(beta), 0.0)
            # axes of the piston and of the block, so that both stay opposite while the block rocks
            mine, its = piston.axes.T @ u, bodies[0].axes.T @ u
            loads.append(Force(piston, along(-mine, table), frame="body", name=f"gas {i}"))
            head = piston.position + 0.1 * engine.radius * u
            loads.append(Force(bodies[0], along(its, table), at=head, frame="body", name=f"head {i}"))
    return System(bodies, joints, loads, gravity=(0, 0, 0), name=f"{source.preset.name} on mounts")


def start(system: System, held: OnMounts, source: Source, rpm: float) -> State:
    """Return the state at t = 0 of the linear answer: the mean position of the block plus its small motion and rate."""
    linear, rate = held.answer(source, [rpm]), source.preset.engine(rpm).rate
    motion, block = linear.motion[0], system.bodies[0]
    W = (linear.orders * rate)[:, None]
    moved, speed = motion.sum(axis=0).real, (1j * W * motion).sum(axis=0).real
    turn = matrix(exponential(moved[3:])) @ matrix(held.rest[3:])
    middle, q = held.rest[:3] + moved[:3], []
    for body in system.bodies:
        on_ground = body.name == "dyno"
        position = body.position if on_ground else middle + turn @ body.position
        axes = body.axes if on_ground else turn @ body.axes
        q.append(np.concatenate([position, quaternion_from_matrix(axes)]))
    near = State(0.0, np.concatenate(q), np.zeros(6 * len(q)))
    closed = system.assemble(near=near, pinned=[block])
    return replace(closed, v=closed.v + carried(DenseEquations(system).at(closed).J) @ (speed - closed.v[:6]))


def whole_run(
    source: Source, held: OnMounts, rpm: float, *, settle: float = 1.0, kept: int = 4, count: int = 144,
    **options: Any,
) -> Solution:  # fmt: skip
    """Simulate the full motion from the state of the linear answer over ``kept`` cycles, ``count`` samples a turn.

    What the linear answer misses at the start has the time ``settle`` [s] to die out.
    """
    engine = source.preset.engine(rpm)
    cycle = 4 * np.pi / engine.rate
    before = max(int(np.ceil(settle / cycle)), 1)
    system = whole_system(source, held, rpm, before + kept)
    times = cycle * (before + np.arange(2 * count * kept + 1) / (2 * count))
    state = start(system, held, source, rpm)
    return simulate(system, float(times[-1]), state=state, output=times, rtol=RTOL, **options)


def run_orders(solution: Solution, placed: Sequence[Mount], rate: float, orders: np.ndarray) -> np.ndarray:
    """Return the phasors of the forces on the car in a full run [N], the crank at angle ``rate * t``, shape (n, mounts,
    3).
    """
    forces = np.hstack([-solution.force(mount.name).force for mount in placed])
    seen = spectrum(solution.t, forces, rate=rate)
    return np.array([seen.at(order) for order in orders]).reshape(len(orders), len(placed), 3)
