"""Motions of MuJoCo in the coordinates of this package: what imports are compared with."""

import mujoco
import numpy as np

from mbsd3d import State, accelerations


def general_motion(model, seed=7, angle=0.3):
    """MuJoCo's data at a general state: accelerations of its own recursive dynamics."""
    rng, data = np.random.default_rng(seed), mujoco.MjData(model)
    data.qpos[:] = model.qpos0
    mujoco.mj_integratePos(model, data.qpos, rng.normal(size=model.nv), angle)
    data.qvel[:] = rng.normal(size=model.nv)
    mujoco.mj_forward(model, data)
    mujoco.mj_rnePostConstraint(model, data)
    return data


def spatial(function, model, data, name):
    """(linear, angular) velocity or acceleration of a body's origin, world axes."""
    out = np.zeros(6)
    function(model, data, mujoco.mjtObj.mjOBJ_XBODY, model.body(name).id, out, 0)
    return out[3:], out[:3]


def state_of(system, model, data):
    """The same state in our coordinates."""
    q = [np.concatenate([data.body(b.name).xpos, data.body(b.name).xquat]) for b in system.bodies]
    v = [np.concatenate(spatial(mujoco.mj_objectVelocity, model, data, b.name)) for b in system.bodies]
    return State(0.0, np.concatenate(q), np.concatenate(v))


def accelerations_of(system, model, data, names=None):
    """(bodies, 6) accelerations of origins and angular ones of MuJoCo, of all bodies or those named."""
    found = []
    for name in names or [body.name for body in system.bodies]:
        linear, angular = spatial(mujoco.mj_objectAcceleration, model, data, name)
        found.append(np.concatenate([linear + model.opt.gravity, angular]))  # it accelerates the world against gravity
    return np.array(found)


TOLERANCE = 1e-11  # relative: rounding of both codes is some 1e-14 times condition numbers of mass matrices up to 1e3


def difference(system, state, model, data, names=None):
    """Largest difference of our accelerations from those of MuJoCo, relative to the largest one."""
    ours, names = accelerations(system, state), names or [body.name for body in system.bodies]
    theirs = accelerations_of(system, model, data, names)
    found = np.array([np.concatenate([ours.acceleration(name)[0], ours.alpha(name)[0]]) for name in names])
    return np.abs(found - theirs).max() / np.abs(theirs).max()
