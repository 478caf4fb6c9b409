"""Random MJCF models against MuJoCo: 16 of a fixed sample, 1000 in `make calibrate`."""

import os

import mujoco
import numpy as np
import pytest
from helpers.mujoco_states import TOLERANCE, closed, difference, held_by, with_key
from helpers.random_mjcf import TIE, random_mjcf
from numpy.polynomial import polynomial as poly

MODELS = int(os.environ.get("MBSD3D_TEST_RANDOM_MJCF", "16"))


def lengths(model, q):
    """Lengths of both tendons, from those at the zero of the file."""
    found = []
    for i in range(2):
        own = slice(model.tendon_adr[i], model.tendon_adr[i] + model.tendon_num[i])
        places = model.jnt_qposadr[model.wrap_objid[own]]
        found.append(model.wrap_prm[own] @ (q - model.qpos0)[places])
    return found


@pytest.mark.parametrize("seed", range(MODELS))
def test_accelerations_are_those_of_mujoco(tmp_path, seed):
    """At a general state, some radians from the zero; a tie of tendons is rigid here, and so it is made there."""
    text, names, tied = random_mjcf(seed)
    rng, model = np.random.default_rng(seed + 10_000), mujoco.MjModel.from_xml_string(text)
    q, v = model.qpos0.copy(), rng.normal(size=model.nv)
    mujoco.mj_integratePos(model, q, rng.normal(size=model.nv), 0.8)

    def residual(at):
        y, x = lengths(model, at)
        return np.array([y - poly.polyval(x, TIE)])

    if tied:
        q, v = closed(model, q, v, residual)
    found, state, model, data = with_key(tmp_path, text, q, v)
    if tied:
        held_by(model, data, residual)
    else:
        mujoco.mj_rnePostConstraint(model, data)
    M = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, M)
    rounding = TOLERANCE * max(1.0, 1e-3 * np.linalg.cond(M))  # of condition numbers up to 1e3, and beyond as it grows
    assert difference(found.system, state, model, data, names) < rounding
