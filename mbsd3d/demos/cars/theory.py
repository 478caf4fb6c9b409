"""Theory of a car in a steady circle without its mechanism: closed forms, and four tyres under a rigid body.

The closed forms hold where the lateral acceleration is small. The trim holds up to the limit, but for what the lean of
the wheels and the geometry of a large roll do: up to 1.5 % of it.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import approx_fprime, root

from ...base.errors import InputError
from ..form import GRAVITY, Symbol, require
from .car import WHEELS, Car, G

ROLL_SYMBOLS = {  # of the equation of the roll in a steady turn
    "h": Symbol("height of its centre of mass", "m", "h"),
    "m_w": Symbol("wheel", "kg"),
    "r": Symbol("wheel", "m"),
    "I_w": Symbol("moment of a wheel along its axle", "kg m^2"),
    "K_f": Symbol("roll stiffness in front", "N m/rad"),
    "K_r": Symbol("roll stiffness at the rear", "N m/rad"),
    "g": GRAVITY,
}

WHEEL_PLACES = np.array([*WHEELS.values()])  # [1] (4, 2) ahead 1, behind -1; left 1, right -1
FRONT_WHEELS, WHEEL_SIDES = WHEEL_PLACES[:, 0] > 0, WHEEL_PLACES[:, 1]
ROLL_MAX = 0.175  # [rad] of the trims
ROLL_TOLERANCE = 0.5 * ROLL_MAX**2  # [1] of the limit: error of heights and tracks of the rolled car
# [1] of the load at rest; with less a wheel is about to lift off, and loads are no longer linear in ay
LOAD_SHARE_MIN = 0.05
STEP_MAX, STEP_MIN = (
    0.1,
    0.02,
)  # of the slip at which a tyre would be used up if it were linear; of that step, at the end
DIFFERENCE_STEP = 1e-7  # [1] of the unknowns, for derivatives


def axle_stiffnesses(c: Car) -> np.ndarray:
    """Return front and rear stiffness [N m/rad] over the roll of the car: springs and bar, in series with the tyres,
    shape (2,).
    """
    half = 0.5 * c.track**2
    ends = ((c.kf, c.bar_f), (c.kr, c.bar_r))
    return np.array([1.0 / (1.0 / (k * half + bar) + 1.0 / (c.kt * half)) for k, bar in ends])


def roll_gradient(c: Car, spin: float = 1.0) -> float:
    """Return the roll over lateral acceleration [rad s^2/m].

    (ms h + 4 mw r + 4 Iw/r)/(K - (ms h + 4 mw r) g): the wheels lean with the car but for what springs and bars give,
    and their spin v/r is carried round, Iw v/r times v/R each. ``spin``: share of that which is counted.
    """
    height = c.ms * c.h + 4.0 * c.mw * c.r
    return float((height + 4.0 * spin * c.Iw / c.r) / (axle_stiffnesses(c).sum() - height * G))


def textbook_roll_gradient(c: Car) -> float:
    """Return the roll gradient of textbooks, ms h/(K - ms h g): the wheels neither lean nor spin [rad s^2/m]."""
    return float(c.ms * c.h / (axle_stiffnesses(c).sum() - c.ms * c.h * G))


def transfers(c: Car, spin: float = 1.0) -> np.ndarray:
    """Return the load that goes from left to right, front and rear, over lateral acceleration [kg], shape (2,)."""
    return axle_stiffnesses(c) * roll_gradient(c, spin) / c.track


def understeer_gradient(c: Car) -> float:
    """Return the steer over lateral acceleration, beyond wheelbase over radius [rad s^2/m]."""
    return sum(sign * c.load(name) / c.stiffness(name) for name, sign in (("front left", 1), ("rear left", -1))) / G


@dataclass(frozen=True)
class Trim:
    """Four tyres under a rigid body in a circle at a steady speed; arrays in the order of `WHEELS`."""

    acceleration: float  # [m/s^2]
    steer: float  # [rad]
    slip_angles: np.ndarray  # (4,) [rad]
    loads: np.ndarray  # (4,) [N]
    used: np.ndarray  # (4,) of the grip


def tyre_forces(c: Car, loads: np.ndarray, slips: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (forces (4, 2) ahead and to the left of brush tyres at theoretical slips, shares of the grip that they
    use).
    """
    over = loads / c.nominal_load - 1.0
    C = np.array([c.longitudinal, c.cornering]) * (1.0 - c.less_stiffness * over)[:, None]
    grip = c.mu * (1.0 - c.less_grip * over)
    pull = C * slips
    s = np.linalg.norm(pull, axis=1) / grip
    used = 1.0 - (1.0 - np.minimum(s, 3.0) / 3.0) ** 3
    return pull * (loads * used / np.maximum(s, 1e-300))[:, None], used


class Planar:
    """Equations of a trim; unknowns: speed to the left, steer, drive, slips of the driven wheels, acceleration."""

    def __init__(self, c: Car, speed: float) -> None:
        self.c, self.v = c, speed
        self.m, self.height = c.ms + 4.0 * c.mw, c.ms * c.h + 4.0 * c.mw * c.r
        self.static = np.array([c.load(name) for name in WHEELS])
        self.over = transfers(c)[np.where(FRONT_WHEELS, 0, 1)]
        self.at = np.array([c.place(name)[:2] for name in WHEELS])

    def parts(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return (slip angles, loads, forces in axes of the car, shares of the grip used)."""
        c, (left, steer, _, *driven, a) = self.c, x
        turn = a / self.v
        loads = (
            self.static
            - WHEEL_SIDES * self.over * a
            + WHEEL_PLACES[:, 0] * self.height * turn * left / (2.0 * c.wheelbase)
        )
        toe = np.where(FRONT_WHEELS, steer, 0.0)
        velocity = np.stack([self.v - turn * self.at[:, 1], left + turn * self.at[:, 0]], axis=1)
        cos, sin = np.cos(toe), np.sin(toe)
        along, across = cos * velocity[:, 0] + sin * velocity[:, 1], cos * velocity[:, 1] - sin * velocity[:, 0]
        angles = -np.arctan2(across, along)
        ahead = np.array([0.0, 0.0, *driven])
        slips = np.stack([ahead, np.tan(angles)], axis=1)
        pulls, used = tyre_forces(c, loads, slips)
        forces = np.stack([cos * pulls[:, 0] - sin * pulls[:, 1], sin * pulls[:, 0] + cos * pulls[:, 1]], axis=1)
        return angles, loads, forces, used

    def left_over(self, x: np.ndarray) -> np.ndarray:
        """Return the residuals of the forces against those of a circle [m/s^2], and of the two halves of the drive,
        shape (5,).
        """
        _, _, forces, _ = self.parts(x)
        turn = x[5] / self.v
        wanted = self.m * np.array([-turn * x[0], x[5]])
        moment = self.at[:, 0] @ forces[:, 1] - self.at[:, 1] @ forces[:, 0]
        moment -= 2.0 * self.c.mw * (self.c.a - self.c.b) * x[5]  # the wheels' masses
        over = forces.sum(axis=0) - wanted
        return np.array([*over, moment / self.c.wheelbase, *(forces[2:, 0] - 0.5 * x[2])]) / self.m

    def trim(self, x: np.ndarray) -> Trim:
        """Return the trim of a solution of the equations."""
        angles, loads, _, used = self.parts(x)
        return Trim(float(x[5]), float(x[1]), angles, loads, used)


def trims(c: Car, speed: float) -> list[Trim]:
    """Compute trims at a speed [m/s] of rising slip angles, front and rear added up, to the largest acceleration.

    They end where the acceleration falls, or where the inner driven wheel spins and there are no more of them.

    Raises
    ------
    ValueError
        If there are none, or an inner wheel lifts before the limit.
    """
    require(speed > 0.0 and c.mu > 0.0, f"car: no circles at {speed:g} m/s, mu = {c.mu:g}; give numbers above 0")
    planar, found, last = Planar(c, speed), [], np.zeros(6)
    slip, step = 0.0, STEP_MAX * c.mu / c.cornering
    ahead, shortest = np.array([-0.5 * speed, 0.5, 0.0, 0.0, 0.0, 0.5 * c.cornering * G]), STEP_MIN * step
    while step > shortest:
        x = solved(planar, last + step * ahead, slip + step)
        if x is None or x[5] < last[5]:
            step *= 0.5
            continue
        ahead, last, slip = (x - last) / step, x, slip + step
        found.append(planar.trim(x))
    least = found[-1].loads.min()
    lifted = f"car: at the limit a wheel bears {least:.4g} N, so it lifts; give less grip, or a lower or wider car"
    require(least > 0.0, lifted)
    return found


def limit(c: Car, speed: float) -> Trim:
    """Return the last of the trims; raise InputError where the car rolls far or a wheel lifts off, since they no longer
    hold.
    """
    if roll_gradient(c) > 0:
        last = trims(c, speed)[-1]
        least = min(load / c.load(name) for load, name in zip(last.loads, WHEELS, strict=True))
        if roll_gradient(c) * last.acceleration < ROLL_MAX and least > LOAD_SHARE_MIN:
            return last
    raise InputError(
        "theory of the limit is one of small angles and four wheels on the road, and this car rolls far or lifts one; "
        "give less h or mu, more track, or stiffer springs and bars"
    )


def solved(planar: Planar, x: np.ndarray, slip: float) -> np.ndarray | None:
    """Solve for unknowns near some with slip angles that add up [rad]; None if there are none; shape (6,)."""

    def left(x: np.ndarray) -> np.ndarray:
        c, v = planar.c, planar.v
        both = x[1] - (2.0 * x[0] + (c.a - c.b) * x[5] / v) / v
        return np.append(planar.left_over(x), both - slip)

    found = root(left, x, jac=lambda x: approx_fprime(x, left, DIFFERENCE_STEP), tol=1e-12)
    return found.x if np.abs(found.fun).max() < 1e-9 else None
