"""Steady turns: with a lean and a steer angle, the speed and the steer torque at which the bicycle goes on like that.

In a steady turn everything rotates about a vertical axis and the wheels spin. All velocities are proportional to one
scale s, accelerations of lean and steer are linear in s^2 and in the steer torque T:

    (lean'', steer'') = rest + s^2 motion + T torque = 0        (two equations, solved for s^2 and T)

The three columns come from accelerations of the general model. The speed is steady too, since a motion run backwards is
one as well. The rear contact is the origin, its track heads along x.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from mbsd3d import Linearization, State, accelerations, linearize, simulate
from mbsd3d.mechanism import measures

from .kinematics import Pose, X, Y, Z, foot, placed, pose_of, steer_axis
from .loads import steer_torque
from .models import Bicycle, outputs, whipple
from .motion import Ride
from .parameters import Parameters

NEAR = 0.02  # [rad] within which the pitch of a neighbour is looked for


class Balance(NamedTuple):
    """Accelerations of lean and steer (2,) at rest, per square of the scale of velocities, and per steer torque."""

    rest: np.ndarray
    motion: np.ndarray
    torque: np.ndarray

    @property
    def held(self) -> tuple[float, float]:
        """(s^2, T) of the steady turn; a negative s^2 is none."""
        square, torque = np.linalg.solve(np.column_stack([self.motion, self.torque]), -self.rest)
        return float(square), float(torque)


class Rolling(NamedTuple):
    """Velocities of a steady turn whose scale, sqrt(speed^2 + (w yaw rate)^2), is one; the rear wheel rolls forward."""

    speed: float  # of the rear contact along its track [m/s]
    yaw_rate: float  # to the right [rad/s]
    velocities: np.ndarray  # (4, 6) of O, and angular velocities


def course(p: Parameters, at: Pose) -> tuple[float, float]:
    """(speed of the rear contact, yaw rate about +z) at scale one: the front contact keeps to its track.

    ``speed x + yaw z x front`` has no part across the front wheel; both change sign smoothly from pose to pose.
    """
    ahead = np.cross(at.fork @ Y, Z)
    side = np.cross(Z, ahead / np.linalg.norm(ahead))
    speed, yaw = side @ np.cross(Z, at.contact), -side @ X
    size = np.hypot(speed, p.w * yaw)
    return float(speed / size), float(yaw / size)


def rolling(p: Parameters, at: Pose) -> Rolling:
    """All velocities of the turn in this pose."""
    speed, yaw = course(p, at)
    if (speed if abs(speed) > 1e-12 else -yaw) < 0.0:  # forward, or to the right where the rear contact rests
        speed, yaw = -speed, -yaw
    ahead = np.cross(at.fork @ Y, Z)
    ahead = ahead / np.linalg.norm(ahead)
    carried = [speed * X + yaw * np.cross(Z, point) for point in (at.rear, at.rear, at.front, at.front)]
    front_speed = (speed * X + yaw * np.cross(Z, at.contact)) @ ahead
    spins = []
    for axle, radius, crown, way, v in (
        (at.frame @ Y, p.rR, p.tR, X, speed),
        (at.fork @ Y, p.rF, p.tF, ahead, front_speed),
    ):  # the material point at the contact rests
        spins.append(-v / (np.cross(axle, foot(axle, radius, crown)) @ way) * axle)
    turns = [yaw * Z + spin for spin in (spins[0], 0.0, 0.0, spins[1])]
    return Rolling(float(speed), float(-yaw), np.hstack([carried, turns]))


class Turner:
    """A bicycle that is put into one steady turn after the other; neighbouring ones are found fast."""

    def __init__(self, parameters: Parameters) -> None:
        self.p, self.system = parameters, whipple(parameters)
        self.twisted = replace(self.system, forces=steer_torque(self.system, parameters, 1.0))
        self.axis, self.pitch = steer_axis(parameters)[1], 0.0
        self.squares: dict[tuple[float, float], float] = {}

    def pose(self, lean: float, steer: float) -> Pose:
        """The pose whose pitch is next to the last one's, else that with the least pitch."""

        def height(pitch: float) -> float:
            return placed(self.p, lean, steer, pitch).contact[2]

        low, high = self.pitch - NEAR, self.pitch + NEAR
        if abs(lean) < np.pi / 2 and height(low) * height(high) < 0.0:
            found = placed(self.p, lean, steer, brentq(height, low, high, xtol=1e-15, rtol=1e-15))
        else:
            found = pose_of(self.p, lean, steer)
        along = found.frame @ X
        self.pitch = float(-np.arctan2(along[2], along[0]))
        return found

    def state(self, lean: float, steer: float, square: float) -> State:
        """The state in which everything turns with the scale whose square is given."""
        at = self.pose(lean, steer)
        v = np.sqrt(square) * rolling(self.p, at).velocities
        return State(0.0, at.q, v.ravel(), coordinates=np.array([0.0, float(steer), 0.0]))

    def answer(self, system: Bicycle, state: State) -> np.ndarray:
        """(2,) accelerations of lean and steer [rad/s^2] where their rates are zero."""
        found = accelerations(system, state)
        frame, axle = found.alpha("frame")[0], found.rotation("frame")[0] @ Y
        axis = found.rotation("frame")[0] @ self.axis
        lean = np.cross(frame, axle)[2] / np.hypot(axle[0], axle[1])
        return np.array([lean, axis @ (found.alpha("fork")[0] - frame)])

    def balance(self, lean: float, steer: float) -> Balance:
        """The columns of the two equations."""
        scale = self.p.g * self.p.w  # of speed^2, for accuracy
        rest, moving = (self.answer(self.system, self.state(lean, steer, s)) for s in (0.0, scale))
        twisted = self.answer(self.twisted, self.state(lean, steer, 0.0))
        return Balance(rest, (moving - rest) / scale, twisted - rest)

    def square(self, lean: float, steer: float) -> float:
        """Square of the speed of the rear contact at which a steer torque holds the turn [m^2/s^2]; computed once."""
        if (lean, steer) not in self.squares:
            at = course(self.p, self.pose(lean, steer))[0]
            self.squares[lean, steer] = self.balance(lean, steer).held[0] * at**2
        return self.squares[lean, steer]

    def free(self, lean: float, steer: float) -> tuple[float, float]:
        """(misfit, s^2) without hands: zero misfit where one s^2 makes both accelerations vanish.

        The misfit is the cross product of the two columns over sin(steer), in (g/w)^2: a straight wheel makes no turn
        at any speed, so that the product alone would vanish there too.
        """
        scale = self.p.g * self.p.w
        rest, moving = (self.answer(self.system, self.state(lean, steer, s)) for s in (0.0, scale))
        motion = moving - rest
        misfit = (rest[0] * motion[1] - rest[1] * motion[0]) * (self.p.w / self.p.g) ** 2
        return float(misfit / np.sin(steer)), float(-scale * (rest @ motion) / (motion @ motion))

    def turn(self, lean: float, steer: float, square: float | None = None) -> "Turn":
        """The steady turn with these angles: hands-free with a square of the scale, else with the torque it needs.

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
            raise ValueError(
                f"bicycle '{self.p.name}': at lean {lean:.6g} rad and steer {steer:.6g} rad no speed makes a steady "
                f"turn (its square would be {square:.6g} m^2/s^2); lean more into the turn, or steer less"
            )
        state = self.state(lean, steer, square)
        at = self.pose(lean, steer)
        direction, smooth = rolling(self.p, at)[:2], course(self.p, at)[0]
        return Turn(self.p, float(lean), float(steer), square, torque, system, state, direction, smooth)


@dataclass(frozen=True, eq=False)
class Turn:
    """A steady turn; angles, rates and torque are positive to the right.

    Attributes
    ----------
    lean, steer : float
        [rad]
    square : float
        speed^2 + (w yaw_rate)^2 [m^2/s^2].
    torque : float
        Steer torque that holds it [N m]; 0 = hands-free.
    """

    parameters: Parameters
    lean: float
    steer: float
    square: float
    torque: float
    system: Bicycle
    state: State
    direction: tuple[float, float]  # speed and yaw rate at scale one
    course: float  # that speed with a sign that changes where the rear contact is the centre of the turn

    @property
    def speed(self) -> float:
        """Of the rear contact along its track [m/s]."""
        return float(np.sqrt(self.square)) * self.direction[0]

    @property
    def yaw_rate(self) -> float:
        """[rad/s]"""
        return float(np.sqrt(self.square)) * self.direction[1]

    @property
    def radius(self) -> float:
        """Of the track of the rear wheel [m], positive in a turn to the right."""
        return self.direction[0] / self.direction[1] if self.direction[1] else np.inf

    @cached_property
    def moment(self) -> Ride:
        """One sample of this turn: ``.contacts`` are the forces of the ground, ``.friction`` what they need."""
        return Ride(self.parameters, accelerations(self.system, self.state))

    def ride(self, t_end: float | None = None, **settings: Any) -> Ride:
        """Let it go on from here, for one round unless told otherwise [s]; settings as in `mbsd3d.simulate`."""
        if t_end is None and not self.yaw_rate:
            raise ValueError(f"bicycle '{self.parameters.name}': this turn is at rest, a round never ends; give t_end")
        end = 2.0 * np.pi / abs(self.yaw_rate) if t_end is None else t_end
        return Ride(self.parameters, simulate(self.system, end, state=self.state, **settings))

    @property
    def friction(self) -> float:
        """Coefficient of friction that keeps both wheels from slipping."""
        return self.moment.friction

    @property
    def load(self) -> float:
        """Of the wheel that is pressed to the ground least [N]; below zero the turn does not exist."""
        return min(float(contact.normal[0]) for contact in self.moment.contacts.values())

    @cached_property
    def linearization(self) -> Linearization:
        """Small motions about this turn: lean, steer, their rates, and the rate of the hub that turns faster."""
        hubs = [f"{wheel} hub" for wheel in ("rear", "front")]
        rates = [abs(float(self.moment.solution.rate(hub)[0])) for hub in hubs]
        hub = self.system.part(hubs[int(np.argmax(rates))], "joints")
        return linearize(self.system, self.state, outputs=[*outputs(self.system), measures.rate(hub)])

    @cached_property
    def eigenvalues(self) -> np.ndarray:
        """(4,) [1/s] without the zero that leads to the neighbouring turn (at constant torque)."""
        values = self.linearization.eigenvalues
        return np.delete(values, np.argmin(np.abs(values)))

    @property
    def growth(self) -> float:
        """Largest real part of the eigenvalues [1/s]; at rest with every sign, so never below zero."""
        return float(self.eigenvalues.real.max())

    @property
    def stable(self) -> bool:
        """True if small disturbances die out, but for a shift along the family of turns."""
        return self.growth < 0.0
