"""A hydraulic cylinder on a boom, against the law of cosines and virtual work."""

import numpy as np
import pytest

from mbsd3d import GROUND, Body, LengthDriver, Polynomial, Revolute, System, accelerations, rotation, simulate
from mbsd3d.rotations import matrix

R = matrix(rotation((0.4, -0.9, 0.3), 0.8))  # the plane of the boom lies along no axis
PIVOT = np.array([0.3, -0.7, 1.1])
A, B, MASS, ARM, INERTIA = np.array([0.3, -0.4]), np.array([1.0, 0.1]), 200.0, 1.5, 600.0


def boom(length):
    """Return a boom on a hinge, drawn level, with a cylinder between frame and boom."""
    along, up, axis = R.T
    inertia = R @ np.diag([20.0, INERTIA - MASS * ARM**2 + 10.0, INERTIA - MASS * ARM**2]) @ R.T
    body = Body("boom", MASS, inertia, com=(ARM + 0.2) * along, position=PIVOT - 0.2 * along)
    hinge = Revolute(GROUND, body, at=PIVOT, axis=axis, name="hinge")
    at_a, at_b = (PIVOT + x * along + y * up for x, y in (A, B))
    cylinder = LengthDriver(GROUND, body, at_a=at_a, at_b=at_b, length=length, name="cylinder")
    return System([body], [hinge, cylinder], gravity=-9.81 * up)


def test_a_cylinder_lifts_a_boom():
    system = boom(Polynomial((1.2, 0.1, 0.025)))
    now = accelerations(system, system.assemble())
    axis = R[:, 2]
    assert now.angle("hinge")[0] == pytest.approx(0.7239108441219103, abs=1e-9)
    assert now.omega("boom")[0] @ axis == pytest.approx(0.24273401821882046, abs=1e-9)
    assert now.alpha("boom")[0] @ axis == pytest.approx(0.15232122447146657, abs=1e-9)
    assert now.effort("cylinder")[0] == pytest.approx(5574.0246455543975, rel=1e-9)


def test_its_work_lifts_the_boom():
    system = boom(Polynomial((1.2, 0.1, 0.025)))
    run = simulate(system, 1.0, state=system.assemble())
    energy = run.energy()
    assert run.certificate.passed
    assert run.work("cylinder")[-1] == pytest.approx(energy.total[-1] - energy.total[0], rel=1e-8)
    ends = [run.body_point("boom", system.joints[1].at_b), system.joints[1].at_a]
    length = np.linalg.norm(ends[0] - ends[1], axis=1)
    assert np.abs(length - (1.2 + 0.1 * run.t + 0.025 * run.t**2)).max() < 1e-10


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"at_b": PIVOT + R @ (*A, 0.0)}, "coincide"),
        ({"length": -0.2}, "length is -0.2 m"),
        ({"length": "1"}, "length"),
    ],
)
def test_what_is_refused(given, text):
    body = Body("boom", MASS, (1, 1, 1))
    ends = {"at_a": PIVOT + R @ (*A, 0.0), "at_b": PIVOT, "length": 1.0}
    with pytest.raises(ValueError, match=text):
        LengthDriver(GROUND, body, **(ends | given), name="cylinder")
