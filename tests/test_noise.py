"""The switch of the suite that puts noise on masses: it reaches the kernels, and stays a possible body."""

import os

import numpy as np
from helpers.noise import perturbed

from mbsd3d import Body, System
from mbsd3d.extend import check_inertia

BODY = Body("block", 3.0, [[2.0, 0.1, 0.2], [0.1, 3.0, 0.3], [0.2, 0.3, 4.0]])


def test_noise_has_its_size_and_keeps_the_inertia_symmetric():
    other = perturbed(BODY, 1e-3)
    inertia = check_inertia(other.inertia, other.mass, "block")
    assert 1e-5 < np.abs(inertia / BODY.inertia - 1.0).max() < 1e-3 and 1e-5 < abs(other.mass / 3.0 - 1.0) < 1e-3
    assert (perturbed(BODY, 1e-3).inertia == other.inertia).all()


def test_the_switch_reaches_the_kernels():
    size = float(os.environ.get("MBSD3D_TEST_NOISE", "0"))
    table = System([BODY], []).lowered.model.body[0]
    expected = perturbed(BODY, size)
    assert table["mass"] == expected.mass and (table["inertia"].reshape(3, 3) == expected.inertia).all()
    assert (size > 0.0) == (table["mass"] != BODY.mass or (table["inertia"].reshape(3, 3) != BODY.inertia).any())
