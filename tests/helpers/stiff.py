"""Stiff models: the flyball governor of the IFToMM benchmark by hand, and a light sensor on a bushing."""

from functools import cache

import numpy as np
from scipy.integrate import solve_ivp

from mbsd3d import (
    GROUND,
    Body,
    Bushing,
    Fixed,
    Prismatic,
    Revolute,
    Spherical,
    SpringDamper,
    System,
    rotation,
)

# the IFToMM benchmark A05, stiff flyball governor
K, C, L0 = 8e5, 4e4, 0.5  # N/m, N s/m, m

ROD, BALL, SLIDER, GAUGE = 0.3, 5.0, 3.0, 0.01  # kg, kg, kg, m (rods and shaft 1 x 0.01 x 0.01 m)

OFFSET, START, OMEGA, G = 0.05, np.radians(30), 2 * np.pi, 9.81  # m from the axis, rad, rad/s, m/s^2

CENTRE = (ROD * 0.5 + BALL) / (ROD + BALL)  # m, from the hinge

ALONG = ROD * GAUGE**2 / 6

ACROSS = ROD * (1 + GAUGE**2) / 12 + ROD * (CENTRE - 0.5) ** 2 + BALL * (1 - CENTRE) ** 2


def governor():
    """Shaft, slider on it, two rods with balls, and the springs that replace the coupler rods."""
    thin, thick = ROD * (1 + GAUGE**2) / 12, ROD * GAUGE**2 / 6
    spin = (0, 0, OMEGA)
    shaft = Body("shaft", ROD, (thin, thin, thick), com=(0, 0, 0.5), omega=spin)
    slider = Body("slider", SLIDER, (SLIDER * 0.02 / 12,) * 3, position=(0, 0, 0.5), velocity=(0, 0, 0))
    joints = [
        Revolute(GROUND, shaft, at=(0, 0, 0), axis=(0, 0, 1)),
        Prismatic(shaft, slider, at=(0, 0, 0.5), axis=(0, 0, 1)),
    ]
    bodies, springs = [shaft, slider], []
    for name, side in (("right", 1.0), ("left", -1.0)):
        hinge = np.array([side * OFFSET, 0, 1])
        along = np.array([side * np.cos(START), 0, -np.sin(START)])
        frame = np.column_stack([along, (0, 1, 0), np.cross(along, (0, 1, 0))])
        rod = Body(
            name, ROD + BALL, (ALONG, ACROSS, ACROSS), com=(CENTRE, 0, 0), position=hinge, orientation=frame, omega=spin
        )
        bodies.append(rod)
        joints.append(Revolute(shaft, rod, at=hinge, axis=(0, 1, 0)))
        ends = {"at_a": (side * OFFSET, 0, 0.5), "at_b": hinge + 0.5 * along}
        springs.append(SpringDamper(slider, rod, **ends, stiffness=K, damping=C, length=L0, name=f"{name} coupler"))
    return System(bodies, joints, springs, gravity=(0, 0, -G))


def reduced(t, x):
    """The governor by hand: slider height s, rod angle b below the horizontal, angular momentum about the axis."""
    s, b, s_dot, b_dot, momentum = x
    hinged = ACROSS + (ROD + BALL) * CENTRE**2
    lever = 2 * OFFSET * (ROD + BALL) * CENTRE
    about = (
        ROD * GAUGE**2 / 6 + SLIDER * 0.02 / 12
        + 2 * ((ROD + BALL) * OFFSET**2 + lever * np.cos(b) + hinged * np.cos(b) ** 2 + ALONG * np.sin(b) ** 2)
    )  # fmt: skip
    slope = 2 * (-lever * np.sin(b) + 2 * (ALONG - hinged) * np.sin(b) * np.cos(b))
    gap = np.array([0.5 * np.cos(b), 1 - 0.5 * np.sin(b) - s])
    gap_b = np.array([-0.5 * np.sin(b), -0.5 * np.cos(b)])
    length = np.hypot(*gap)
    length_b, length_s = gap @ gap_b / length, -gap[1] / length
    pull = K * (length - L0) + C * (length_b * b_dot + length_s * s_dot)
    s_ddot = -G - 2 * pull * length_s / SLIDER
    spin = momentum / about
    b_ddot = (0.25 * spin**2 * slope + (ROD + BALL) * G * CENTRE * np.cos(b) - pull * length_b) / hinged
    return [s_dot, b_dot, s_ddot, b_ddot, 0.0]


@cache
def slider_height():
    """(times, s) of the benchmark by an implicit method of another kind on the reduced equations."""
    hinged = ACROSS + (ROD + BALL) * CENTRE**2
    about = (
        ROD * GAUGE**2 / 6 + SLIDER * 0.02 / 12
        + 2 * ((ROD + BALL) * OFFSET**2 + 2 * OFFSET * (ROD + BALL) * CENTRE * np.cos(START)
               + hinged * np.cos(START) ** 2 + ALONG * np.sin(START) ** 2)
    )  # fmt: skip
    times, start = np.linspace(0, 2, 41), [0.5, START, 0.0, 0.0, about * OMEGA]
    return times, solve_ivp(reduced, (0, 2), start, "Radau", times, rtol=1e-10, atol=1e-12).y[0]


def sensor(damping=2e4, rigid=False, mass=0.02):
    """A slow pendulum of general shape that carries a light sensor on a bushing of 1e8 N/m (or rigidly)."""
    arm = Body(
        "arm", 40.0, (9.0, 7.0, 8.0), com=(0.3, -0.4, -2.9), position=(0.3, 0.1, 0.2),
        orientation=rotation((1, 2, 0.5), 0.2),
    )  # fmt: skip
    at = arm.position + np.array([0.4, -0.3, -3.0])
    inertia = 1e-3 * mass * np.array([1.0, 1.2, 0.9])
    load = Body(
        "load", mass, inertia, com=(0.02, -0.01, 0.03), position=at + np.array([0.03, 0.02, -0.02]),
        orientation=rotation((1, -0.3, 0.5), 0.7),
    )  # fmt: skip
    pin, forces = Spherical(GROUND, arm, at=(0.25, 0.2, 0.1)), []
    if not rigid:
        stiff = {"stiffness": 1e8, "turning_stiffness": 1e5, "damping": damping, "turning_damping": 1e-3 * damping}
        forces = [Bushing(arm, load, at=at, axes=rotation((1, 2, 3), 0.4), name="mount", **stiff)]
    return System([arm, load], [pin, Fixed(arm, load, at=at)] if rigid else [pin], forces)
