"""A driven loop that locks: the run ends there, names the driver and the pose, and keeps what was closed."""

import numpy as np
import pytest

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    IntegrationError,
    Kinematic,
    Ramp,
    Revolute,
    System,
    rotation,
    simulate,
)
from mbsd3d.rotations import matrix

CRANK, ROD, ROCKER, FRAME, START = 0.5, 0.6, 0.5, 1.0, 0.9  # m, rad


def four_bar(rate):
    """A four-bar in a tilted plane, its crank driven from 0.9 rad at ``rate`` [rad/s]."""
    tilt, off = matrix(rotation((1, 2, -1), 0.7)), np.array([0.3, -0.2, 0.5])
    A, D = np.zeros(3), np.array([FRAME, 0, 0])
    P = CRANK * np.array([np.cos(START), 0, np.sin(START)])
    span = D - P
    length = np.linalg.norm(span)
    inner = np.arccos((ROD**2 + length**2 - ROCKER**2) / (2 * ROD * length)) + np.arctan2(span[2], span[0])
    Q = P + ROD * np.array([np.cos(inner), 0, np.sin(inner)])
    A, P, Q, D = (tilt @ point + off for point in (A, P, Q, D))
    axis = tilt @ np.array([0, -1.0, 0])  # turns the crank from x to z
    ends = {"crank": (A, P), "rod": (P, Q), "rocker": (Q, D)}
    crank, rod, rocker = (
        Body(name, 1.0, (0.01, 0.02, 0.02), position=(p + q) / 2 + 0.05 * axis, com=(0.03, 0.02, -0.01))
        for name, (p, q) in ends.items()
    )
    pairs = ((GROUND, crank, A), (crank, rod, P), (rod, rocker, Q), (rocker, GROUND, D))
    hinges = [Revolute(a, b, at=at, axis=axis, name=f"hinge {k}") for k, (a, b, at) in enumerate(pairs)]
    return System([crank, rod, rocker], [*hinges, AngleDriver(hinges[0], Ramp(rate), name="motor")])


@pytest.mark.slow  # 20 s
@pytest.mark.parametrize("rate", [2.0, -2.0])
@pytest.mark.parametrize("output", [31, 2])
def test_a_locked_loop_names_its_driver_and_the_pose(rate, output):
    with pytest.raises(
        IntegrationError, match="driver 'motor' .AngleDriver. at .* locks .* drive it less far"
    ) as caught:
        simulate(four_bar(rate), 3.0, method=Kinematic(), output=output)
    # rod and rocker in one line: (ROD + ROCKER)^2 = CRANK^2 + FRAME^2 - 2 CRANK FRAME cos(angle)
    farthest = np.arccos((CRANK**2 + FRAME**2 - (ROD + ROCKER) ** 2) / (2 * CRANK * FRAME))
    travel = farthest - START if rate > 0 else farthest + START
    assert abs(rate) * caught.value.time == pytest.approx(travel, abs=1e-3)  # no step reaches a singular pose itself
    kept = caught.value.solution
    assert kept.drift().position.max() < 1e-10 and (kept.t <= caught.value.time).all()
