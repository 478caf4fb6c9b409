"""Mechanisms of any size: a chain of hinges with its MuJoCo twin, a ladder of parallelograms."""

from typing import Any

import numpy as np

from mbsd3d import GROUND, Body, Revolute, System, rotation
from mbsd3d.rotations import matrix

LINK, MASS, INERTIA, COM = 0.2, 0.2, (1e-4, 8e-4, 7e-4), (0.1, 0.01, 0.005)  # m, kg, kg m^2, m
AXES = ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def chain(n: int) -> System:
    """n links of 0.2 m held out horizontally; hinge axes along y and z in turns, centres of mass off the hinges."""
    links = [Body(f"link {k}", MASS, INERTIA, com=COM, position=(LINK * k, 0, 0)) for k in range(n)]
    joints = [
        Revolute(links[k - 1] if k else GROUND, links[k], at=(LINK * k, 0, 0), axis=AXES[k % 2], name=f"hinge {k}")
        for k in range(n)
    ]
    return System(links, joints)


def mujoco_chain(n: int, dt: float) -> Any:
    """The same chain as a MuJoCo model in its n relative angles, RK4 with the step dt."""
    import mujoco

    spec = mujoco.MjSpec()
    spec.option.integrator, spec.option.timestep = mujoco.mjtIntegrator.mjINT_RK4, dt
    spec.option.gravity = (0.0, 0.0, -9.81)
    parent = spec.worldbody
    for k in range(n):
        parent = parent.add_body(
            pos=(LINK if k else 0.0, 0.0, 0.0), mass=MASS, ipos=COM, inertia=INERTIA, explicitinertial=True
        )
        parent.add_joint(type=mujoco.mjtJoint.mjJNT_HINGE, axis=AXES[k % 2])
    return spec.compile()


def ladder(n: int, tilt: float = 0.7, lean: float = 0.4) -> System:
    """n parallelograms side by side in a tilted plane, neighbours share a rod: one freedom, 3 n redundant rows.

    The rods lean by an angle [rad]; at a right angle all rods lie on one line, a singular pose.
    """
    R = matrix(rotation((1.0, 2.0, 3.0), tilt))
    axis, com = R[:, 1], (0.03, 0.01, -0.05)
    foot = [np.array([1.0 * k, 0.0]) for k in range(n + 1)]
    head = [at + [np.sin(lean), np.cos(lean)] for at in foot]

    def place(x: float, z: float) -> np.ndarray:
        return R @ np.array([x, 0.0, z])

    def rod(name: str, near: np.ndarray, far: np.ndarray, mass: float) -> Body:
        inertia = (0.02 * mass, 0.09 * mass, 0.085 * mass)
        return Body(name, mass, inertia, com=com, position=place(*(0.45 * near + 0.55 * far)), orientation=R)

    rods = [rod(f"rod {k}", foot[k], head[k], 1.0 + 0.1 * (k % 3)) for k in range(n + 1)]
    couplers = [rod(f"coupler {k}", head[k], head[k + 1], 1.3 - 0.1 * (k % 2)) for k in range(n)]
    joints = [Revolute(GROUND, rods[k], at=place(*foot[k]), axis=axis, name=f"foot {k}") for k in range(n + 1)]
    for k in range(n):
        joints.append(Revolute(rods[k], couplers[k], at=place(*head[k]), axis=axis, name=f"left {k}"))
        joints.append(Revolute(couplers[k], rods[k + 1], at=place(*head[k + 1]), axis=axis, name=f"right {k}"))
    return System([*rods, *couplers], joints)
