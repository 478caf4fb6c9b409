"""Mechanisms of any size: a chain of hinges with its MuJoCo counterpart, parallelograms, a top, a Stewart platform."""

from typing import Any

import numpy as np

from mbsd3d import GROUND, Body, Prismatic, Revolute, Spherical, SpringDamper, System, Universal, rotation
from mbsd3d.extend import Ground, matrix

LINK_LENGTH, LINK_MASS, LINK_INERTIA, LINK_COM = 0.2, 0.2, (1e-4, 8e-4, 7e-4), (0.1, 0.01, 0.005)  # m, kg, kg m^2, m
AXES = ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def chain(n: int) -> System:
    """Return n links of 0.2 m held out horizontally; hinge axes alternate along y and z, centres of mass off the
    hinges.
    """
    links = [
        Body(f"link {k}", LINK_MASS, LINK_INERTIA, com=LINK_COM, position=(LINK_LENGTH * k, 0, 0)) for k in range(n)
    ]
    joints = [
        Revolute(
            links[k - 1] if k else GROUND, links[k], at=(LINK_LENGTH * k, 0, 0), axis=AXES[k % 2], name=f"hinge {k}"
        )
        for k in range(n)
    ]
    return System(links, joints)


def mujoco_chain(n: int, dt: float) -> Any:
    """Return the same chain as a MuJoCo model in its n relative angles, RK4 with the step dt [s]."""
    import mujoco

    spec = mujoco.MjSpec()
    spec.option.integrator, spec.option.timestep = mujoco.mjtIntegrator.mjINT_RK4, dt
    spec.option.gravity = (0.0, 0.0, -9.81)
    parent = spec.worldbody
    for k in range(n):
        parent = parent.add_body(
            pos=(LINK_LENGTH if k else 0.0, 0.0, 0.0),
            mass=LINK_MASS,
            ipos=LINK_COM,
            inertia=LINK_INERTIA,
            explicitinertial=True,
        )
        parent.add_joint(type=mujoco.mjtJoint.mjJNT_HINGE, axis=AXES[k % 2])
    return spec.compile()


def ladder(n: int, tilt: float = 0.7, lean: float = 0.4) -> System:
    """Return n parallelograms side by side in a tilted plane that share rods: one degree of freedom, 3 n redundant
    rows.

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


def four_bars(n: int) -> System:
    """Return n four-bar windows of slender rods of 1 m and 1 kg, upright at 1 rad/s: the N-four-bar of the IFToMM
    library.

    Gravity along -y. One degree of freedom; at +-90 degrees all rods lie on one line and there are n + 1. In space 3 n
    of the rows are redundant. Names, order and start are those of ``references/iftomm_A02_fourbar_N2.json``.
    """
    slender, upright = (1e-3, 1 / 12, 1 / 12), rotation("z", np.pi / 2)
    rods = [
        Body(f"rod{k}", 1.0, slender, position=(k, 0.5, 0), orientation=upright, velocity=(0.5, 0, 0), omega=(0, 0, -1))
        for k in range(n + 1)
    ]
    couplers = [
        Body(f"coupler{k}", 1.0, slender, position=(k + 0.5, 1, 0), velocity=(1, 0, 0), omega=(0, 0, 0))
        for k in range(n)
    ]

    def hinge(a: Body | Ground, b: Body, x: float, y: float, name: str) -> Revolute:
        return Revolute(a, b, at=(x, y, 0), axis=(0, 0, 1), name=name)

    joints = [hinge(GROUND, rods[k], k, 0, f"A{k}") for k in range(n + 1)]
    for k in range(n):
        joints.append(hinge(rods[k], couplers[k], k, 1, f"B{k}l"))
        joints.append(hinge(couplers[k], rods[k + 1], k + 1, 1, f"B{k}r"))
    return System([*rods, *couplers], joints, gravity=(0, -9.81, 0))


def slow_top() -> System:
    """Return a top of three different moments with a large nutation, its centre of mass off its axis."""
    body = Body(
        "top", 2.0, (0.02, 0.024, 0.012), com=(0.01, -0.02, 0.25), omega=(1.5, -0.7, 60.0),
        orientation=rotation((0.8, 0.5, 0.1), 0.9),
    )  # fmt: skip
    return System([body], [Spherical(GROUND, body, at=(0, 0, 0), name="pivot")])


def stewart() -> System:
    """Return a moving Stewart platform on six legs with springs: Universal, Prismatic and Spherical joints, 6 degrees
    of freedom.
    """
    platform = Body(
        "platform", 20.0, (1.2, 1.4, 2.3), com=(0.02, -0.03, 0.04), position=(0, 0, 1.0),
        velocity=(0.2, -0.1, 0.15), omega=(0.3, 0.4, -0.5),
    )  # fmt: skip
    bodies, joints, forces = [platform], [], []
    for k in range(6):
        # pairs of feet 20 degrees apart, pairs of heads 40 degrees apart and turned by 60 degrees
        foot = _on_circle(0.9, 120 * (k // 2) + (10 if k % 2 else -10), 0.0)
        head = _on_circle(0.5, 120 * ((k + 1) // 2) - 60 + (-20 if k % 2 else 20), 1.0)
        along = (head - foot) / np.linalg.norm(head - foot)
        across = np.cross(along, (0, 0, 1)) / np.linalg.norm(np.cross(along, (0, 0, 1)))
        axes = np.column_stack([across, np.cross(along, across), along])
        barrel = Body(f"barrel {k}", 2.0, (0.05, 0.051, 0.002), com=(0, 0.01, 0.25), position=foot, orientation=axes)
        piston = Body(f"piston {k}", 1.0, (0.02, 0.0205, 0.001), com=(0.005, 0, -0.2), position=head, orientation=axes)
        bodies += [barrel, piston]
        joints += [
            Universal(GROUND, barrel, at=foot, axis_a=axes[:, 1], axis_b=across, name=f"foot {k}"),
            Prismatic(barrel, piston, at=foot, axis=along, name=f"slide {k}"),
            Spherical(piston, platform, at=head, name=f"head {k}"),
        ]
        forces.append(SpringDamper(barrel, piston, at_a=foot, at_b=head, stiffness=2e3, damping=2.0))
    return System(bodies, joints, forces)


def _on_circle(radius: float, degrees: float, height: float) -> np.ndarray:
    """Return the point of a horizontal circle about the z axis [m]."""
    angle = np.radians(degrees)
    return np.array([radius * np.cos(angle), radius * np.sin(angle), height])
