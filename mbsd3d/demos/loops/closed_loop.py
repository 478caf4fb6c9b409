"""Single loops of hinges by their Denavit-Hartenberg numbers: their closure, continuation and models."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Fixed,
    Joint,
    Kinematic,
    Polynomial,
    Revolute,
    Solution,
    System,
    shapes,
    simulate,
)

from ...base.errors import InputError
from ...mechanism.bodies import Ground

Angles = Sequence[float] | np.ndarray  # [rad]
Look = Callable[[np.ndarray, np.ndarray, np.ndarray, np.ndarray, float], list[shapes.Shape]]
T = 2.0  # s, of a turn of the driven hinge from rest to rest
SAMPLES = 121
CLOSURE_TOLERANCE = 1e-9  # [1] share of the length, and [rad]


class Loop(NamedTuple):
    """Loop in which link i leads from hinge i to hinge i + 1 by Rz(theta_i) Tz(d_i) Tx(a_i) Rx(alpha_i); the last one
    is the ground.
    """

    a: Sequence[float]  # m
    alpha: Sequence[float]  # rad
    d: Sequence[float]  # m

    def step(self, k: int, theta: float) -> np.ndarray:
        """Return the transform of link k, shape (4, 4)."""
        c, s, ca, sa = np.cos(theta), np.sin(theta), np.cos(self.alpha[k]), np.sin(self.alpha[k])
        return np.array([
            [c, -s * ca, s * sa, self.a[k] * c],
            [s, c * ca, -c * sa, self.a[k] * s],
            [0, sa, ca, self.d[k]],
            [0, 0, 0, 1],
        ])  # fmt: skip

    def frames(self, theta: Angles) -> list[np.ndarray]:
        """Return the frames of all hinges, (4, 4) each, and once more of the first one, around the loop."""
        found = [np.eye(4)]
        for k, angle in enumerate(theta):
            found.append(found[-1] @ self.step(k, angle))
        return found

    def gap(self, theta: Angles) -> np.ndarray:
        """Return the gap of the loop's end from its beginning, lengths over that of the loop, shape (12,)."""
        end = self.frames(theta)[-1]
        return np.concatenate([(end[:3, :3] - np.eye(3)).ravel(), end[:3, 3] / np.sum(np.abs([*self.a, *self.d]))])

    def close(self, first: float, others: Angles) -> np.ndarray:
        """Solve for angles that close the loop for a given first one, near a guess for the others [rad]."""
        found = least_squares(lambda x: self.gap([first, *x]), others, xtol=3e-16, ftol=3e-16, gtol=3e-16)
        theta = np.array([first, *found.x])
        for _ in range(2):  # down to rounding, which least squares leave at its root
            theta[1:] -= np.linalg.lstsq(found.jac, self.gap(theta), rcond=1e-8)[0]
        if np.abs(self.gap(theta)).max() > CLOSURE_TOLERANCE:
            raise InputError(f"the loop does not close near these angles (gap {np.abs(self.gap(theta)).max():.1g}); "
                             "give lengths and angles that close")  # fmt: skip
        return theta

    def follow(self, theta: Angles, turn: float, steps: int = 60) -> np.ndarray:
        """Return the angles while the first one turns, continued from a closed start [rad], shape (steps + 1, n)."""
        found = [np.asarray(theta)]
        for first in theta[0] + turn * np.arange(1, steps + 1) / steps:
            ahead = 2 * found[-1] - found[-2] if len(found) > 1 else found[-1]
            found.append(self.close(first, ahead[1:]))
        return np.array(found)

    def system(
        self, theta: Angles, turn: float, misfit: float = 0.0, thick: float = 0.05, look: Look | None = None,
        carried: Sequence[shapes.Shape] = (),
    ) -> System:  # fmt: skip
        """Build links and hinges, the first hinge driven by a turn in T seconds.

        ``misfit`` makes the third side (in a four-bar the second) longer by this share: its far hinge is moved.
        ``look`` draws a link by the points and axes of its hinges and a length; None = `link`. A body of its own, which
        is not part of the loop, shows the side that is the ground. ``carried`` is drawn on the middle link too, about
        its middle, in world axes.
        """
        frames, size = self.frames(theta), thick * max(np.abs([*self.a, *self.d]))
        points = [frame[:3, 3] for frame in frames[:-1]]
        axes = [frame[:3, 2] for frame in frames[:-1]]
        moved = 2 if len(points) == 4 else 3
        points[moved] = points[moved] + misfit * (points[moved] - points[moved - 1])
        drawn = [(look or link)(points[k], points[k + 1], axes[k], axes[k + 1], size) for k in range(len(points) - 1)]
        middle = len(drawn) // 2
        drawn[middle] = [*drawn[middle], *carried]
        bodies = [
            Body(f"link {k + 1}", 1.0, (0.01, 0.01, 0.01), position=0.5 * (points[k] + points[k + 1]), shape=shape)
            for k, shape in enumerate(drawn)
        ]
        closing = (look or link)(points[-1], points[0], axes[-1], axes[0], size)
        frame = Body("frame", 1.0, (0.01, 0.01, 0.01), position=0.5 * (points[-1] + points[0]), shape=closing)
        chain: list[Body | Ground] = [GROUND, *bodies, GROUND]
        joints: list[Joint] = [
            Revolute(chain[k], chain[k + 1], at=points[k], axis=axes[k], name=f"hinge {k + 1}")
            for k in range(len(points))
        ]
        joints.append(Fixed(GROUND, frame, at=frame.position, name="base"))
        joints.append(AngleDriver(joints[0], Polynomial((0, 0, 3 * turn / T**2, -2 * turn / T**3)), name="motor"))
        return System([*bodies, frame], joints, gravity=(0, 0, 0))


def link(start: np.ndarray, end: np.ndarray, axis: np.ndarray, other: np.ndarray, size: float) -> list[shapes.Shape]:
    """Draw a rod between two hinges, with a pin along each axis."""
    middle, along = 0.5 * (start + end), end - start
    pins: list[shapes.Shape] = [
        shapes.Cylinder(0.8 * size, 4 * size, tuple(way), at=place - middle, colour="gray")
        for place, way in ((start, axis), (end, other))
    ]
    long = float(np.linalg.norm(along))
    return pins + ([shapes.Cylinder(0.5 * size, long, tuple(along), at=(0, 0, 0))] if long > size else [])


def mobile(system: System) -> bool:
    """Return whether a loop moves without its motor."""
    return System(system.bodies, system.joints[:-1], gravity=(0, 0, 0)).check().mobility > 0


def run_loop(system: System, **terms: Any) -> tuple[Solution, np.ndarray]:
    """Return a run, and the turns of all hinges [deg]; of a locked loop at rest."""
    count = len(system.bodies)
    if not mobile(system):
        held = System(system.bodies, [*system.joints[:-1], AngleDriver(system.joints[0], 0.0)], gravity=(0, 0, 0))
        run = simulate(held, T, method=Kinematic(), output=SAMPLES, **terms)
        return run, np.zeros((SAMPLES, count))
    run = simulate(system, T, method=Kinematic(), output=SAMPLES, **terms)
    return run, np.degrees([run.angle(f"hinge {k + 1}") for k in range(count)]).T
