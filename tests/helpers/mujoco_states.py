"""Motions of MuJoCo in the coordinates of this package: what imports are compared with."""

import mujoco
import numpy as np
from numpy.polynomial import polynomial as poly

from mbsd3d import State, accelerations, read_mjcf


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


def numbers(values):
    return " ".join(repr(float(x)) for x in values)


def with_key(folder, text, qpos, qvel):
    """(imported system, its state, MuJoCo's model and data) at joint positions and velocities."""
    key = f'<keyframe><key name="k" qpos="{numbers(qpos)}" qvel="{numbers(qvel)}"/></keyframe>'
    text = text.replace("</mujoco>", f"{key}</mujoco>")
    path = folder / "model.xml"
    path.write_text(text)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    found = read_mjcf(path)
    return found, found.states["k"], model, data


def rigid(model, data, J, gamma):
    """Put the accelerations of MuJoCo's own M and loads under rigid rows J qacc = gamma into the data."""
    M = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, M)
    saddle = np.block([[M, J.T], [J, np.zeros((len(J), len(J)))]])
    load = data.qfrc_passive - data.qfrc_bias
    data.qacc[:] = np.linalg.solve(saddle, np.concatenate([load, gamma]))[: model.nv]
    mujoco.mj_rnePostConstraint(model, data)


def held_by(model, data, residual):
    """Put MuJoCo's accelerations under rigid rows residual(qpos) = 0 into the data; derivatives are exact to rounding.

    The residual is a polynomial of the coordinates, of degree up to 4, along qvel: seven points give J and J_dot v.
    """
    steps, n = 0.1 * np.arange(-3, 4), model.nv

    def at(direction, s):
        q = data.qpos.copy()
        mujoco.mj_integratePos(model, q, direction, s)
        return residual(q)

    def along(direction, order):
        values = np.array([at(direction, s) for s in steps])
        return poly.polyfit(steps, values, 6)[order] * (1, 1, 2)[order]

    J = np.stack([along(unit, 1) for unit in np.eye(n)], axis=1)
    rigid(model, data, J, -along(data.qvel, 2))
    return J


def closed(model, qpos, qvel, residual):
    """Positions and velocities near the given ones at which residual(qpos) = 0, by Newton's method."""
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = qpos, qvel
    mujoco.mj_normalizeQuat(model, data.qpos)
    for _ in range(30):
        mujoco.mj_forward(model, data)
        J = held_by(model, data, residual)
        step = -np.linalg.lstsq(J, residual(data.qpos), rcond=None)[0]
        mujoco.mj_integratePos(model, data.qpos, step, 1.0)
    data.qvel[:] -= np.linalg.lstsq(J, J @ data.qvel, rcond=None)[0]
    return data.qpos.copy(), data.qvel.copy()
