"""Families of hands-free circles: found on sections of constant steer angle, followed as curves of lean and steer."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from mbsd3d.errors import InputError
from mbsd3d.extend import Result

from ..parameters import Parameters
from .turning import Turn, TurnSolver

SECTION_STEERS = tuple(np.radians([8.0, 30.0, 60.0, 100.0, 130.0, 165.0, 176.0]))
SECTION_LEANS = np.radians(np.linspace(-62.0, 62.0, 42))  # [rad] at which families are sought
LEAN_MAX = np.radians(80.0)  # [rad] lean at which a family ends
STEER_MIN = 1e-3  # [rad] steer from straight at which a family ends
POINTS_MAX = 400  # [1] points to either side
DIFFERENCE_STEP = 1e-6  # [1] of x, for derivatives along a curve
CORRECTIONS_MAX = 12
CORRECTION_TOLERANCE = 1e-9  # [1] error of x before the last correction
STEP_TURN_MAX = 0.3  # [rad] turn of a step from the tangent before it; its arc is 0.25 of that as high as it is long


@dataclass(frozen=True, eq=False, repr=False)
class Family(Result):
    """Hands-free circles along one curve of lean and steer, both wheels pressed to the ground."""

    turns: tuple[Turn, ...]  # from one end to the other
    ends: tuple[str, str]  # why the family ends there
    special: tuple[tuple[str, Turn], ...]  # "largest lean", "stability changes", "about the rear contact"

    def values(self, name: str) -> np.ndarray:
        """Return a quantity of all turns, e.g. "lean", "speed", "radius", "stable", shape (n,)."""
        return np.array([getattr(turn, name) for turn in self.turns])

    def __str__(self) -> str:
        (lean, steer, speed) = (self.values(name) for name in ("lean", "steer", "speed"))
        lines = [
            f"{len(self.turns)} hands-free circles: lean {lean.min():.4f} ... {lean.max():.4f} rad, "
            f"steer {steer.min():.4f} ... {steer.max():.4f} rad, speed {speed.min():.4f} ... {speed.max():.4f} m/s",
            f"  ends: {self.ends[0]}; {self.ends[1]}",
        ]
        lines += [f"  {what}: {turn}" for what, turn in self.special]
        return "\n".join(lines)


def across(along: np.ndarray) -> np.ndarray:
    """Return the direction at a right angle."""
    return np.array([-along[1], along[0]])


def turned(along: np.ndarray, angle: float) -> np.ndarray:
    """Return a direction rotated by an angle [rad]."""
    return np.cos(angle) * along + np.sin(angle) * across(along)


def angle(a: np.ndarray, b: np.ndarray) -> float:
    """Return the angle from direction a to direction b [rad]."""
    return float(np.arctan2(across(a) @ b, a @ b))


@dataclass(frozen=True)
class Curve:
    """Curve ``f(x) = 0`` with x (2,) of order one; steps have lengths between ``shortest`` and ``longest``.

    Where f raises ValueError the curve ends.
    """

    f: Callable[[np.ndarray], float]
    longest: float = 0.08
    shortest: float = 2e-5

    def direction(self, x: np.ndarray) -> np.ndarray:
        """Return the unit vector along the curve at one of its points, shape (2,)."""
        slope = np.array([self.f(x + DIFFERENCE_STEP * e) - self.f(x - DIFFERENCE_STEP * e) for e in np.eye(2)])
        return across(slope) / np.hypot(*slope)

    def tangent(self, x: np.ndarray, along: np.ndarray) -> np.ndarray:
        """Return `direction`, oriented like ``along``; ``along`` itself where the curve ends."""
        try:
            found = self.direction(x)
        except ValueError:
            return along
        return found if found @ along > 0.0 else -found

    def corrected(self, x: np.ndarray, along: np.ndarray, reach: float) -> np.ndarray | None:
        """Return the point of the curve next to x at a right angle to ``along`` (secant method); None if none is in
        reach.
        """
        normal = across(along)
        a, b = 0.0, 0.01 * reach
        f_a, f_b = self.f(x), self.f(x + b * normal)
        for _ in range(CORRECTIONS_MAX):
            if f_a == f_b:
                return x + b * normal if f_b == 0.0 else None
            a, b, f_a = b, b - f_b * (b - a) / (f_b - f_a), f_b
            if abs(b) > reach:
                return None
            if abs(b - a) < CORRECTION_TOLERANCE:  # the secant method squares such an error
                return x + b * normal
            f_b = self.f(x + b * normal)
        return None

    def follow(self, x: np.ndarray, along: np.ndarray) -> Iterator[np.ndarray]:
        """Yield points after x, first in the direction ``along`` of the curve there, until the curve ends.

        Tangent and curvature at a point are those of the parabola through it and the two before; a step turns by
        `STEP_TURN_MAX` at most. Where no step is short enough, the parabola was wrong: the curve turns sharply there.
        """
        length, bend, last, before, exact = 0.5 * self.longest, 0.0, 0.0, along, True
        while length > self.shortest:
            guess = turned(along, np.clip(0.5 * bend * length, -STEP_TURN_MAX, STEP_TURN_MAX))
            new = self.step(x, guess, length)
            chord = guess if new is None else (new - x) / np.linalg.norm(new - x)
            turn = angle(along, chord)
            if new is None or abs(turn) > STEP_TURN_MAX:
                length *= 0.5
                if length <= self.shortest and not exact:
                    along, bend, length, exact = self.tangent(x, along), 0.0, last, True
                continue
            yield new
            size, miss = float(np.linalg.norm(new - x)), abs(angle(guess, chord))
            if last:
                bend = 2.0 * angle(before, chord) / (last + size)
                turn = 0.5 * bend * size
            else:  # the tangent at the first point is known
                bend = 2.0 * turn / size
            x, along, before, last, exact = new, turned(chord, turn), chord, size, False
            length = min(length * (2.0 if miss < 0.02 else 1.0 if miss > 0.1 else 1.3), self.longest)

    def step(self, x: np.ndarray, along: np.ndarray, length: float) -> np.ndarray | None:
        """Return the point a step further, or None at the end of the curve."""
        try:
            return self.corrected(x + length * along, along, 0.5 * length)
        except ValueError:
            return None

    def locate(self, a: np.ndarray, b: np.ndarray, value: Callable[[np.ndarray], float]) -> np.ndarray | None:
        """Return the point between two neighbours a and b at which ``value`` is zero; None if it cannot be reached."""
        along = (b - a) / np.linalg.norm(b - a)

        def point(share: float) -> np.ndarray:
            found = self.corrected(a + share * (b - a), along, float(np.linalg.norm(b - a)))
            if found is None:
                raise InputError("no point between the neighbours")
            return found

        try:
            return point(brentq(lambda share: value(point(share)), 0.0, 1.0, xtol=1e-9))
        except ValueError:
            return None


@dataclass
class Search:
    """Search for the families of one bicycle, and the continuation along each."""

    turner: TurnSolver
    curve: Curve
    tell: Callable[[float], None]  # of the number of sections done, at every point
    done: int = 0

    @classmethod
    def of(cls, parameters: Parameters, longest: float, tell: Callable[[float], None]) -> "Search":
        """Return curves on which the two equations without hands agree on a speed."""
        turner = TurnSolver(parameters)
        return cls(turner, Curve(lambda x: turner.free(*x)[0], longest), tell)

    def square(self, x: np.ndarray) -> float:
        """Return the square of the scale of velocities [m^2/s^2]."""
        return self.turner.free(*x)[1]

    def turn(self, x: np.ndarray) -> Turn:
        """Return the circle at a point."""
        return self.turner.turn(x[0], x[1], square=max(self.square(x), 0.0))

    def seeds(self, steer: float) -> list[np.ndarray]:
        """Return points of a section: sign changes over the lean where a real speed belongs to them."""

        def misfit(lean: float) -> float:
            return self.turner.free(lean, steer)[0]

        found, values = [], []
        for lean in SECTION_LEANS:
            try:
                values.append(misfit(lean))
            except ValueError:  # no such pose
                values.append(np.nan)
        for k in np.flatnonzero(np.array(values[:-1]) * np.array(values[1:]) < 0.0):
            x = np.array([brentq(misfit, *SECTION_LEANS[k : k + 2], xtol=1e-12), steer])
            if self.square(x) > 0.0 and self.pressed(x) > 0.0:
                found.append(x)
        return found

    def follow(self, x: np.ndarray, along: np.ndarray) -> tuple[list[np.ndarray], str]:
        """Return (points after x, why there are no more)."""
        points = [x]
        for new in self.curve.follow(x, along):
            self.tell(self.done)
            end = self.end(points[-1], new)
            if end:
                return points[1:] + ([] if end[1] is None else [end[1]]), end[0]
            points.append(new)
            if len(points) > 6 and np.linalg.norm(new - x) < np.linalg.norm(new - points[-2]):
                return points[1:], "closed"
            if len(points) > POINTS_MAX:
                return points[1:], "not followed further"
        return points[1:], "not followed further"

    def end(self, before: np.ndarray, new: np.ndarray) -> tuple[str, np.ndarray | None] | None:
        """Return (name, last point) if the family ends between two points."""
        for name, straight, sign in (("straight ahead", 0.0, 1.0), ("straight, front end reversed", np.pi, -1.0)):
            if sign * (new[1] - straight) <= STEER_MIN:
                limit = straight + sign * STEER_MIN
                return name, self.curve.locate(before, new, steer_over(limit))
        if self.square(new) < 0.0:
            x = self.curve.locate(before, new, self.square)
            if x is None or abs(self.square(x)) < self.fast:
                return "at rest", x
            return "a wheel lifts", self.curve.locate(before, x, self.pressed)  # long before the speed is infinite
        if abs(new[0]) > LEAN_MAX:
            return "nearly lying", self.curve.locate(before, new, lambda x: abs(x[0]) - LEAN_MAX)
        if self.pressed(new) < 0.0:
            return "a wheel lifts", self.curve.locate(before, new, self.pressed)
        return None

    @property
    def fast(self) -> float:
        """Return a square of the scale that no bicycle reaches [m^2/s^2]."""
        return 1e4 * self.turner.p.g * self.turner.p.w

    def pressed(self, x: np.ndarray) -> float:
        """Return the smaller of the two wheel loads [N]; below zero too where the speed is unbounded."""
        return self.turn(x).load if 0.0 <= self.square(x) < self.fast else -1.0


def steer_over(limit: float) -> Callable[[np.ndarray], float]:
    """Return the function of a point that tells how far its steer angle is beyond a limit [rad]."""
    return lambda x: x[1] - limit


def beside(x: np.ndarray, families: Sequence[list[np.ndarray]]) -> bool:
    """Return whether a point lies on a known family, on the arc over a step."""
    for points in families:
        a, b = np.array(points[:-1]), np.array(points[1:])
        if not a.size:
            continue
        share = np.clip(np.sum((x - a) * (b - a), axis=1) / np.sum((b - a) ** 2, axis=1), 0.0, 1.0)
        miss = np.linalg.norm(a + share[:, None] * (b - a) - x, axis=1)
        if np.any(miss < 0.3 * STEP_TURN_MAX * np.linalg.norm(b - a, axis=1) + 1e-6):
            return True
    return False


def follow_all(search: Search) -> Iterator[tuple[int, list[np.ndarray], tuple[str, str]]]:
    """Yield (number of sections done, points of a family, its ends), one family after the other."""
    families: list[list[np.ndarray]] = []
    for k, steer in enumerate(SECTION_STEERS):
        search.done = k
        for x in search.seeds(steer):
            if beside(x, families):
                continue
            along = search.curve.direction(x)
            back, first = search.follow(x, -along)
            on, last = ([x], first) if first == "closed" else search.follow(x, along)
            families.append([*reversed(back), x, *on] if first != "closed" else [x, *back, x])
            yield k, families[-1], (first, last)


def special_points(search: Search, points: list[np.ndarray], turns: Sequence[Turn]) -> list[tuple[str, Turn]]:
    """Return the entries of `Family.special`, in the order of the family."""

    def growth(x: np.ndarray) -> float:
        along = search.curve.direction(x)
        return float(along[0] * np.sign(along[1] or 1.0))

    lean = np.abs([turn.lean for turn in turns])
    tests: list[tuple[str, np.ndarray, Callable[[np.ndarray], float]]] = [
        ("largest lean", np.diff(lean, append=lean[-1]), growth),
        ("stability changes", np.array([turn.growth for turn in turns]), lambda x: search.turn(x).growth),
        ("about the rear contact", np.array([turn.course for turn in turns]), lambda x: search.turn(x).course),
    ]
    found = []
    for name, values, value in tests:
        for k in np.flatnonzero(values[:-1] * values[1:] < 0.0).tolist():
            summit = name == "largest lean"
            if summit and values[k] < 0.0:
                continue  # a least lean
            x = search.curve.locate(points[k], points[min(k + 1 + summit, len(points) - 1)], value)
            if x is not None:
                found.append((k, name, search.turn(x)))
    return [(name, turn) for _, name, turn in sorted(found, key=lambda entry: entry[0])]
