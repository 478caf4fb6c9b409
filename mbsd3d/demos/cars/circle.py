"""Steady circles of a car at a constant speed, up to the last one that its tyres can hold."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from scipy.optimize import approx_fprime, root

from mbsd3d import Ramp, Solution, State, accelerations

from ...base.errors import InputError
from ...base.rotations import matrix, multiply
from ...equations.compiled import Switches
from ...run.accelerations import Rates
from .car import UP, WHEELS, Car, car

UNKNOWN_SIZES = np.array([0.01, 0.001, 0.01, 0.1, 0.01, *[0.01] * 4, *[1.0] * 4, 100.0, *[0.01] * 8, 1.0])
"""Of the unknowns of a circle: roll, pitch, height, speed to the left, steer, travels, spins, drive, deflections,
acceleration."""
RESIDUAL_MAX = 1e-8  # [m/s^2, rad/s^2] largest residual acceleration; rounding leaves 1e-12
DIFFERENCE_STEP = 1e-7  # [1] of the unknowns in `UNKNOWN_SIZES`, for derivatives
STEP_FIRST, STEP_MAX, STEP_MIN = 2.0, 5.0, 0.7
"""m/s^2 of the first circle; from one to the next, in `UNKNOWN_SIZES` of all unknowns, where mu is 1: less with less
grip."""
STEP_COSINE_MIN = 0.5  # [1] of the angle between two steps, below which the second one has left the curve
Closing = Callable[[np.ndarray], float]


@dataclass(frozen=True, eq=False)
class Circle:
    """Steady circle to the left; roll to the right and nose down are positive [rad]."""

    speed: float  # [m/s] of the centre of mass, ahead
    x: np.ndarray  # (23,) the unknowns as solved, see `UNKNOWN_SIZES`
    at: Solution  # one sample

    @property
    def acceleration(self) -> float:
        """Return the speed times yaw rate [m/s^2]."""
        return float(self.x[22])

    @property
    def roll(self) -> float:
        """Return the roll angle [rad]."""
        return float(self.x[0])

    @property
    def pitch(self) -> float:
        """Return the pitch angle [rad]."""
        return float(self.x[1])

    @property
    def steer(self) -> float:
        """Return the steer angle [rad]."""
        return float(self.x[4])

    @property
    def drive(self) -> float:
        """Return the torque on the rear wheels that keeps the speed [N m]."""
        return float(self.x[13])

    def of_tyres(self, quantity: str) -> np.ndarray:
        """Return a quantity of `Solution.force` of the tyres, in the order of `WHEELS`, shape (4,)."""
        return np.array([getattr(self.at.force(f"{name} tyre"), quantity)[0] for name in WHEELS])


class Balance:
    """Residual of a state against a steady circle; the drive grows by 1 N m a second, so the time says how large it
    is."""

    def __init__(self, c: Car, speed: float, terms: Mapping[str, Any]) -> None:
        self.c, self.speed, self.terms = c, speed, terms
        self.system = car(c, speed, None, Ramp(1.0))
        self.rates = Rates(self.system, self.state(self.start(0.0)), Switches(**terms))

    def start(self, acceleration: float) -> np.ndarray:
        """Return the unknowns of a car that neither rolls nor slips, shape (23,)."""
        x = np.zeros(UNKNOWN_SIZES.size)
        x[[2, 4, 22]] = self.c.h, self.c.wheelbase * acceleration / self.speed**2, acceleration
        x[9:13] = self.speed / self.c.r
        return x

    def state(self, x: np.ndarray) -> State:
        """Return the state of the unknowns: the chassis rolls about the line ahead, then pitches about its own axis."""
        (roll, pitch, steer), centre, turn = 0.5 * x[[0, 1, 4]], x[2] * UP, x[22] / self.speed * UP
        e = np.outer([np.cos(pitch), np.sin(pitch)], [np.cos(roll), np.sin(roll)]).ravel()
        steered = multiply(e, np.array([np.cos(steer), 0.0, 0.0, np.sin(steer)]))
        (R, S), v = matrix(np.stack([e, steered])), np.array([self.speed, x[3], 0.0])
        turned = {True: (steered, S[:, 1]), False: (e, R[:, 1])}  # front wheels and rear ones
        q, rates = [centre, e], [v, turn]
        for k, name in enumerate(WHEELS):
            arm, (e_wheel, axle) = R @ (self.c.place(name) + x[5 + k] * UP), turned[name.startswith("front")]
            q += [centre + arm, e_wheel] * 2
            there = v + np.array([-turn[2] * arm[1], turn[2] * arm[0], 0.0])
            rates += [there, turn, there, turn + x[9 + k] * axle]
        if self.c.engine:
            q, rates = [*q, centre, e], [*rates, v, turn + R @ self.c.engine.spin]
        return State(x[13], np.concatenate(q), np.concatenate(rates), z=x[14:22])

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """Return the accelerations of chassis, travels and spins over those of a circle, and rates of the deflections,
        shape (22,).
        """
        state = self.state(x)
        a, z_dot = self.rates(state)
        r_dot, e, w = state.v.reshape(-1, 6)[:, :3], state.q.reshape(-1, 7)[:, 3:], x[22] / self.speed
        gap = a[:, :3] - w * np.column_stack([-r_dot[:, 1], r_dot[:, 0], np.zeros(len(a))])
        R = matrix(e[:9:2])  # chassis, then carrier and wheel of each corner
        travels, spins = gap[2:9:2] @ R[0, :, 2], np.einsum("ni,ni->n", R[1:, :, 1], a[2:9:2, 3:])
        return np.concatenate([a[0, 3:], gap[0], travels, spins, z_dot])

    def solve(self, start: np.ndarray, closing: Closing) -> Circle | None:
        """Solve for the circle near unknowns that satisfies one more equation; None if there is none."""

        def left(x: np.ndarray) -> np.ndarray:
            return np.append(self(UNKNOWN_SIZES * x), closing(x))

        @cache  # the root finder asks twice for those at the start
        def slopes(x: bytes) -> np.ndarray:
            return approx_fprime(np.frombuffer(x), left, DIFFERENCE_STEP)

        found = root(left, start / UNKNOWN_SIZES, jac=lambda x: slopes(x.tobytes()), tol=1e-12)
        if not np.abs(found.fun).max() < RESIDUAL_MAX:
            return None
        x = UNKNOWN_SIZES * found.x
        return Circle(self.speed, x, accelerations(self.system, self.state(x), **self.terms))


def circle(
    c: Car, speed: float, acceleration: float, near: Circle | None = None, terms: Mapping[str, bool] | None = None
) -> Circle:  # fmt: skip
    """Compute the circle at a speed [m/s] and an acceleration to the left [m/s^2], starting from another one.

    Raises
    ------
    InputError
        If there is none near it: beyond the grip of the tyres there is none.
    """
    balance = Balance(c, speed, terms or {})
    start = balance.start(acceleration) if near is None else near.x
    found = balance.solve(start, lambda x: x[22] - acceleration)
    if found is None:
        raise InputError(
            f"car: no circle at {speed:g} m/s and {acceleration:.4g} m/s^2 is found; give a smaller acceleration, or a "
            "circle near it"
        )
    return found


def circles(c: Car, speed: float, terms: Mapping[str, bool] | None = None, step: float = STEP_MAX) -> list[Circle]:
    """Compute circles of rising acceleration at a speed [m/s] up to the limit, beyond which there is none.

    From circle to circle along the curve of all unknowns, which goes on where the acceleration has its top; when it
    falls, back by two and on with half of the ``step``, until that is short: the limit is met to a part in a thousand.
    """
    balance, size = Balance(c, speed, terms or {}), min(1.0, c.mu)
    found, step = [circle(c, speed, share * size * STEP_FIRST, terms=terms) for share in (0.5, 1.0)], size * step
    while step > size * STEP_MIN:
        last, along = found[-1], ahead(found[-2], found[-1])
        there = balance.solve(*beyond(last, along, step))
        if there is None or ahead(last, there) @ along < STEP_COSINE_MIN:
            step *= 0.5
        elif there.acceleration > last.acceleration:
            found.append(there)
        else:
            found, step = found[: max(len(found) - 1, 2)], 0.5 * step  # the top may lie before the last one
    return found


def ahead(one: Circle, other: Circle) -> np.ndarray:
    """Return the unit vector from one circle to another, in `UNKNOWN_SIZES`, shape (23,)."""
    way = (other.x - one.x) / UNKNOWN_SIZES
    return way / np.linalg.norm(way)


def beyond(one: Circle, along: np.ndarray, step: float) -> tuple[np.ndarray, Closing]:
    """Return the start of the search for a circle one step further along, and the equation of that step."""
    start = one.x / UNKNOWN_SIZES + step * along
    return UNKNOWN_SIZES * start, lambda x: along @ (x - start)
