"""Steady turns: the speed and the steer torque that keep a lean and a steer angle constant.

In a steady turn everything rotates about a vertical axis and the wheels spin. All velocities are proportional to one
scale s, accelerations of lean and steer are linear in s^2 and in the steer torque T:

    (lean'', steer'') = rest + s^2 motion + T torque = 0        (two equations, solved for s^2 and T)

The three columns come from the dense equations of the general model, of which only the right side differs. The speed
is constant too, since the motion reversed in time is a motion as well. The rear contact is the origin, its track heads
along x.
"""

from abc import abstractmethod
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from mbsd3d import Linearization, State, accelerations, linearize, measures, simulate
from mbsd3d.errors import InputError
from mbsd3d.extend import DenseEquations, Result, saddle_matrix

from ..model.kinematics import Height, Pose, X, Y, Z, foot, placed, pose_of, steer_axis
from ..model.mechanism import Bicycle, outputs, steer_torque, whipple
from ..parameters import Parameters
from ..rides.motion import Ride

PITCH_SEARCH_RANGE = 0.02  # [rad] within which the pitch of a neighbour is sought


class Balance(NamedTuple):
    """Accelerations of lean and steer (2,) at rest, per square of the scale of velocities, and per steer torque."""

    rest: np.ndarray
    motion: np.ndarray
    torque: np.ndarray

    @property
    def held(self) -> tuple[float, float]:
        """Return (s^2, T) of the steady turn; a negative s^2 means that there is no such turn."""
        square, torque = np.linalg.solve(np.column_stack([self.motion, self.torque]), -self.rest)
        return float(square), float(torque)


class UnitTurn(NamedTuple):
    """Velocities of a steady turn whose scale, sqrt(speed^2 + (w yaw rate)^2), is one; the rear wheel rolls forward."""

    speed: float  # of the rear contact along its track [m/s]
    yaw_rate: float  # to the right [rad/s]
    velocities: np.ndarray  # (4, 6) of O, and angular velocities


def heading(at: Pose) -> np.ndarray:
    """Return the horizontal direction in which the front wheel rolls."""
    ahead = np.cross(at.fork @ Y, Z)
    return ahead / np.linalg.norm(ahead)


def course(p: Parameters, at: Pose) -> tuple[float, float]:
    """Return (speed of the rear contact, yaw rate about +z) at scale one: the front contact follows its track.

    ``speed x + yaw z x front`` has no component across the front wheel; both change sign smoothly from pose to pose.
    """
    side = np.cross(Z, heading(at))
    speed, yaw = side @ np.cross(Z, at.contact), -side @ X
    size = np.hypot(speed, p.w * yaw)
    return float(speed / size), float(yaw / size)


def unit_turn(p: Parameters, at: Pose) -> UnitTurn:
    """Return all velocities of the turn in this pose."""
    speed, yaw = course(p, at)
    if (speed if abs(speed) > 1e-12 else -yaw) < 0.0:  # forward, or to the right where the rear contact rests
        speed, yaw = -speed, -yaw
    ahead = heading(at)
    carried = [speed * X + yaw * np.cross(Z, point) for point in (at.rear, at.rear, at.front, at.front)]
    front_speed = (speed * X + yaw * np.cross(Z, at.contact)) @ ahead

    def spin(axle: np.ndarray, radius: float, crown: float, way: np.ndarray, v: float) -> np.ndarray:
        """Return the angular velocity of a wheel about its axle whose material point at the contact rests [rad/s]."""
        return -v / (np.cross(axle, foot(axle, radius, crown)) @ way) * axle

    rear, front = spin(at.frame @ Y, p.rR, p.tR, X, speed), spin(at.fork @ Y, p.rF, p.tF, ahead, front_speed)
    turns = [yaw * Z + own for own in (rear, 0.0, 0.0, front)]
    return UnitTurn(float(speed), float(-yaw), np.hstack([carried, turns]))


class TurnSolver:
    """Steady turns of one bicycle, one after the other; neighbours are found fast."""

    def __init__(self, parameters: Parameters) -> None:
        self.p, self.system = parameters, whipple(parameters)
        self.with_torque = replace(self.system, forces=steer_torque(self.system, parameters, 1.0))
        self.dense, self.dense_with_torque = DenseEquations(self.system), DenseEquations(self.with_torque)
        self.bodies = {body.name: k for k, body in enumerate(self.system.bodies)}
        self.axis, self.pitch = steer_axis(parameters)[1], 0.0
        self.squares: dict[tuple[float, float], float] = {}
        self.misfits: dict[tuple[float, float], tuple[float, float]] = {}

    def pose(self, lean: float, steer: float) -> Pose:
        """Return the pose whose pitch is next to the last one's, else that with the least pitch."""
        height, low, high = (
            Height(self.p, lean, steer),
            self.pitch - PITCH_SEARCH_RANGE,
            self.pitch + PITCH_SEARCH_RANGE,
        )
        if abs(lean) < np.pi / 2 and height(low) * height(high) < 0.0:
            found = placed(self.p, lean, steer, brentq(height, low, high, xtol=1e-15, rtol=1e-15))
        else:
            found = pose_of(self.p, lean, steer)
        along = found.frame @ X
        self.pitch = float(-np.arctan2(along[2], along[0]))
        return found

    def state(self, at: Pose, steer: float, square: float) -> State:
        """Return the state in which everything moves with the scale whose square is given."""
        v = np.sqrt(square) * unit_turn(self.p, at).velocities
        return State(0.0, at.q, v.ravel(), coordinates=np.array([0.0, float(steer), 0.0]))

    def columns(self, lean: float, steer: float, *, torque: bool) -> list[np.ndarray]:
        """Return accelerations of lean and steer (2,) where their rates are zero: at rest, by the motion at the square
        g w of the scale, and, if requested, by a steer torque of 1 N m.

        They belong to right sides (Q, 0), (-h, gamma) and (Q_torque, 0) of the same equations.
        """
        at = self.pose(lean, steer)
        state = self.state(at, steer, self.p.g * self.p.w)
        M, Q, h, J, gamma = self.dense.at(state)
        sides = [(Q, 0.0 * gamma), (-h, gamma)]
        if torque:
            sides.append((self.dense_with_torque.at(state).Q - Q, 0.0 * gamma))
        right = np.array([np.concatenate(side) for side in sides])
        v_dot = np.linalg.solve(saddle_matrix(M, J), right.T).T[:, : Q.size].reshape(-1, 4, 6)
        frame, fork = (v_dot[:, self.bodies[name], 3:] for name in ("frame", "fork"))
        axle = at.frame @ Y
        leans = (frame[:, 0] * axle[1] - frame[:, 1] * axle[0]) / np.hypot(axle[0], axle[1])
        return list(np.column_stack([leans, (fork - frame) @ (at.frame @ self.axis)]))

    def balance(self, lean: float, steer: float) -> Balance:
        """Return the columns of the two equations."""
        rest, motion, torque = self.columns(lean, steer, torque=True)
        return Balance(rest, motion / (self.p.g * self.p.w), torque)

    def square(self, lean: float, steer: float) -> float:
        """Return the square of the speed of the rear contact at which a steer torque holds the turn [m^2/s^2];
        cached."""
        if (lean, steer) not in self.squares:
            at = course(self.p, self.pose(lean, steer))[0]
            self.squares[lean, steer] = self.balance(lean, steer).held[0] * at**2
        return self.squares[lean, steer]

    def free(self, lean: float, steer: float) -> tuple[float, float]:
        """Return (misfit, s^2) without hands: where the misfit is zero, one s^2 makes both accelerations vanish.

        The misfit is the cross product of the two columns over sin(steer), in (g/w)^2. The product alone would vanish
        for a straight wheel too, which makes no turn at any speed.
        """
        if (lean, steer) not in self.misfits:
            rest, motion = self.columns(lean, steer, torque=False)
            misfit = (rest[0] * motion[1] - rest[1] * motion[0]) * (self.p.w / self.p.g) ** 2 / np.sin(steer)
            square = -self.p.g * self.p.w * (rest @ motion) / (motion @ motion)
            self.misfits[lean, steer] = float(misfit), float(square)
        return self.misfits[lean, steer]

    def turn(self, lean: float, steer: float, square: float | None = None) -> "Turn":
        """Return the steady turn with these angles: hands-free if the square of the scale is given, else with a steer
        torque.

        Raises
        ------
        ValueError
            If there is no such pose, or the turn would need an imaginary speed.
        """
        torque, system = 0.0, self.system
        if square is None:
            square, torque = self.balance(lean, steer).held
            system = replace(self.system, forces=steer_torque(self.system, self.p, torque))
        if square < 0.0:
            raise InputError(
                f"bicycle '{self.p.name}': at lean {lean:.6g} rad and steer {steer:.6g} rad no speed makes a steady "
                f"turn (its square would be {square:.6g} m^2/s^2); lean more into the turn, or steer less"
            )
        at = self.pose(lean, steer)
        state = self.state(at, steer, square)
        direction, smooth = unit_turn(self.p, at)[:2], course(self.p, at)[0]
        return Turn(self.p, float(lean), float(steer), square, torque, system, state, direction, smooth)


class SteadyTurn(Result):
    """Base of turns on ideal wheels and on tyres: a bicycle, its state, and a constant yaw rate."""

    parameters: Parameters
    system: Bicycle
    state: State

    @property
    @abstractmethod
    def yaw_rate(self) -> float:
        """Return the yaw rate to the right [rad/s]."""

    def ride(self, t_end: float | None = None, **settings: Any) -> Ride:
        """Simulate the turn until ``t_end`` [s], None = for one round; settings as in `mbsd3d.simulate`."""
        if t_end is None and not self.yaw_rate:
            raise InputError(f"bicycle '{self.parameters.name}': without yaw rate no round ends this turn; give t_end")
        end = 2.0 * np.pi / abs(self.yaw_rate) if t_end is None else t_end
        return Ride(self.parameters, simulate(self.system, end, state=self.state, **settings))


@dataclass(frozen=True, eq=False, repr=False)
class Turn(SteadyTurn):
    """Steady turn; angles, rates and torque are positive to the right."""

    parameters: Parameters
    lean: float  # [rad]
    steer: float
    square: float  # speed^2 + (w yaw_rate)^2 [m^2/s^2]
    torque: float  # that holds it [N m]; 0 = hands-free
    system: Bicycle
    state: State
    direction: tuple[float, float]  # speed and yaw rate at scale one
    course: float  # that speed, with a sign that changes where the turn is about the rear contact

    @property
    def speed(self) -> float:
        """Return the speed of the rear contact along its track [m/s]."""
        return float(np.sqrt(self.square)) * self.direction[0]

    @property
    def yaw_rate(self) -> float:
        """Return the yaw rate [rad/s]."""
        return float(np.sqrt(self.square)) * self.direction[1]

    @property
    def radius(self) -> float:
        """Return the radius of the track of the rear wheel [m], positive in a turn to the right."""
        return self.direction[0] / self.direction[1] if self.direction[1] else np.inf

    @cached_property
    def moment(self) -> Ride:
        """Return one sample of this turn: ``.contacts`` are the forces of the ground, ``.friction`` the coefficient
        needed.
        """
        return Ride(self.parameters, accelerations(self.system, self.state))

    @property
    def friction(self) -> float:
        """Return the coefficient of friction that prevents slip of both wheels."""
        return self.moment.friction

    @property
    def load(self) -> float:
        """Return the smaller of the two wheel loads [N]; below zero the turn does not exist."""
        return min(float(contact.normal[0]) for contact in self.moment.contacts.values())

    @cached_property
    def linearization(self) -> Linearization:
        """Linearize the motion about this turn: lean, steer, their rates, and the rate of the hub that turns faster."""
        hubs = [f"{wheel} hub" for wheel in ("rear", "front")]
        rates = [abs(float(self.moment.solution.rate(hub)[0])) for hub in hubs]
        hub = self.system.part(hubs[int(np.argmax(rates))], "joints")
        return linearize(self.system, self.state, outputs=[*outputs(self.system), measures.rate(hub)])

    @cached_property
    def eigenvalues(self) -> np.ndarray:
        """Return the eigenvalues [1/s], without the zero that belongs to the shift to a neighbouring turn at constant
        torque, shape (4,).
        """
        values = self.linearization.eigenvalues
        return np.delete(values, np.argmin(np.abs(values)))

    @property
    def growth(self) -> float:
        """Return the largest real part of the eigenvalues [1/s]; never below zero at rest, where they come in pairs
        +-s.
        """
        return float(self.eigenvalues.real.max())

    @property
    def stable(self) -> bool:
        """Return whether small disturbances decay, except for a shift along the family of turns."""
        return self.growth < 0.0

    def __str__(self) -> str:
        return (
            f"{self.parameters.name}: steady turn at {self.speed:.6g} m/s, lean {self.lean:.6g} rad, "
            f"steer {self.steer:.6g} rad, radius {self.radius:.6g} m, steer torque {self.torque:.6g} N m"
        )
