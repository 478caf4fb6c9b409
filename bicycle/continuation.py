"""Curves ``f(x) = 0`` in a plane, followed point by point."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

DIFFERENCE = 1e-6  # of x, for derivatives
CORRECTIONS = 12
CLOSE = 1e-9  # error of x before the last correction
SHARPEST = 0.3  # turn of a step [rad]


def across(along: np.ndarray) -> np.ndarray:
    """The direction at a right angle."""
    return np.array([-along[1], along[0]])


def turned(along: np.ndarray, angle: float) -> np.ndarray:
    """A direction turned by an angle [rad]."""
    return np.cos(angle) * along + np.sin(angle) * across(along)


def angle(a: np.ndarray, b: np.ndarray) -> float:
    """From direction a to direction b [rad]."""
    return float(np.arctan2(across(a) @ b, a @ b))


@dataclass(frozen=True)
class Curve:
    """``f(x) = 0`` with x (2,) of order one; steps between the given lengths [of x].

    A function that raises ValueError does not exist there: the curve ends.
    """

    f: Callable[[np.ndarray], float]
    longest: float = 0.08
    shortest: float = 2e-5

    def direction(self, x: np.ndarray) -> np.ndarray:
        """(2,) unit vector along the curve at one of its points."""
        slope = [self.f(x + DIFFERENCE * e) - self.f(x - DIFFERENCE * e) for e in np.eye(2)]
        return across(np.array(slope)) / np.hypot(*slope)

    def corrected(self, x: np.ndarray, along: np.ndarray, reach: float) -> np.ndarray | None:
        """The point of the curve next to x at a right angle to ``along`` (secant method); None if none is in reach."""
        normal = across(along)
        a, b = 0.0, 0.01 * reach
        f_a, f_b = self.f(x), self.f(x + b * normal)
        for _ in range(CORRECTIONS):
            if f_a == f_b:
                return x + b * normal if f_b == 0.0 else None
            a, b, f_a = b, b - f_b * (b - a) / (f_b - f_a), f_b
            if abs(b) > reach:
                return None
            if abs(b - a) < CLOSE:  # the secant method squares such an error
                return x + b * normal
            f_b = self.f(x + b * normal)
        return None

    def follow(self, x: np.ndarray, along: np.ndarray) -> Iterator[np.ndarray]:
        """Points after x, first in the direction ``along`` of the curve there, as far as it goes.

        Tangent and curvature at a point are those of the parabola through it and the two before; a step turns by
        SHARPEST at most.
        """
        length, bend, last, before = 0.5 * self.longest, 0.0, 0.0, along
        while length > self.shortest:
            guess = turned(along, np.clip(0.5 * bend * length, -SHARPEST, SHARPEST))
            new = self.step(x, guess, length)
            chord = guess if new is None else (new - x) / np.linalg.norm(new - x)
            turn = angle(along, chord)
            if new is None or abs(turn) > SHARPEST:
                length *= 0.5
                continue
            yield new
            size, miss = np.linalg.norm(new - x), abs(angle(guess, chord))
            if last:
                bend = 2.0 * angle(before, chord) / (last + size)
                turn = 0.5 * bend * size
            else:  # the tangent at the first point is known
                bend = 2.0 * turn / size
            x, along, before, last = new, turned(chord, turn), chord, size
            length = min(length * (2.0 if miss < 0.02 else 1.0 if miss > 0.1 else 1.3), self.longest)

    def step(self, x: np.ndarray, along: np.ndarray, length: float) -> np.ndarray | None:
        """The point a step further, or None where there is none."""
        try:
            return self.corrected(x + length * along, along, 0.5 * length)
        except ValueError:
            return None

    def locate(self, a: np.ndarray, b: np.ndarray, value: Callable[[np.ndarray], float]) -> np.ndarray | None:
        """The point between two neighbours a and b at which ``value`` is zero; None if it cannot be reached."""
        along = (b - a) / np.linalg.norm(b - a)

        def point(share: float) -> np.ndarray:
            found = self.corrected(a + share * (b - a), along, np.linalg.norm(b - a))
            if found is None:
                raise ValueError("no point between the neighbours")
            return found

        try:
            return point(brentq(lambda share: value(point(share)), 0.0, 1.0, xtol=1e-9))
        except ValueError:
            return None
