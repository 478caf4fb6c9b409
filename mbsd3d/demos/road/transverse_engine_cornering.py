"""Effect of the engine of a car in a fast corner on the loads of the wheels, for both directions of the crankshaft."""

import numpy as np

from mbsd3d import (
    GROUND,
    Body,
    Joint,
    PointOnPlane,
    PositionDriver,
    Revolute,
    Sine,
    SpeedDriver,
    System,
    shapes,
    simulate,
)

from ..form import Ablation, Against, Beat, Control, Demo, Measured, Quantity, Symbol, require
from ..moments import share

G = 9.81  # m/s^2


def mechanism(*, m=1500.0, h=0.5, track=1.5, wheelbase=2.5, J=0.25, Omega=700.0, v=30.0, R=50.0, axis="y") -> System:
    """Build a car m [kg], G at h [m], on three feet, at v [m/s] on a circle R [m] to the left; crankshaft J at Omega
    along axis.
    """
    require(
        axis in ("x", "y"), f'demo \'transverse_engine_cornering\': axis = {axis!r}; give "y" (across) or "x" (along)'
    )
    turn, up = v / R, np.array([0, 0, 1.0])
    car = Body("car", m - 10.0, (500.0, 2000.0, 2200.0), position=h * up, velocity=(v, 0, 0), omega=turn * up,
               shape=body_of(wheelbase, track, h))  # fmt: skip
    spin = np.eye(3)["xyz".index(axis)]
    moments = J / 2 + J / 2 * spin
    crank = Body("crankshaft", 10.0, moments, position=h * up, omega=turn * up + Omega * spin,
                 shape=shapes.Cylinder(0.1, 0.7, axis, at=(0, 0, 0)))  # fmt: skip
    feet = {
        "front": (wheelbase / 2, 0, 0),
        "left": (-wheelbase / 2, track / 2, 0),
        "right": (-wheelbase / 2, -track / 2, 0),
    }
    turns = turn / (2 * np.pi)
    way = (Sine(R, turns), Sine(-R, turns, np.pi / 2, R), None)
    joints: list[Joint] = [PointOnPlane(GROUND, car, at=at, normal=up, name=name) for name, at in feet.items()]
    joints += [
        PositionDriver(car, at=(0, 0, 0), signal=way, name="road"),
        SpeedDriver(GROUND, car, axis=up, speed=turn, name="steering"),
        Revolute(car, crank, at=h * up, axis=spin, name="crank bearing"),
        SpeedDriver(car, crank, axis=spin, speed=Omega, name="engine speed"),
    ]
    return System([car, crank], joints, gravity=(0, 0, -G))


def body_of(wheelbase, track, h):
    """Draw a car about its centre of mass."""
    form = [shapes.Box((1.6 * wheelbase, 1.1 * track, 0.9 * h), at=(0, 0, 0.1 * h), colour="lightsteelblue"),
            shapes.Box((0.8 * wheelbase, track, 0.8 * h), at=(-0.1 * wheelbase, 0, 0.9 * h))]  # fmt: skip
    return form + [shapes.Cylinder(0.6 * h, 0.2, "y", at=(x * wheelbase / 2, y * track / 2, -0.4 * h), colour="dimgray")
                   for x in (-1, 1) for y in (-1, 1)]  # fmt: skip


def theory(*, m, h, track, wheelbase, J, Omega, v, R, axis):
    """Return the loads with the engine across: roll, right - left = 2 (m v^2 h/R + J W v/R)/track; along: pitch, the
    front by J W v/(R wheelbase).
    """
    gyro = J * Omega * v / R
    across = axis == "y"
    return {
        "right_minus_left_N": 2 * (m * v**2 * h / R + gyro * across) / track,
        "front_change_N": 0.0 if across else -gyro / wheelbase,
    }


def without_gyroscopic(*, m, h, track, J, Omega, v, R):
    """Return the values without the gyroscopic moment: half of it is I dw/dt of the turning crankshaft, and stays."""
    return {"right_minus_left_N": 2 * (m * v**2 * h / R + J / 2 * Omega * v / R) / track, "front_change_N": 0.0}


def measure(build, terms, *, m, v, R) -> Measured:
    """Measure the loads of the feet, against half the weight at the front."""
    run = simulate(build(), 0.2 * abs(R / v), rtol=1e-12, output=61, **terms)
    front, left, right = (run.reaction(name).force[:, 2].mean() for name in ("front", "left", "right"))
    return Measured({"right_minus_left_N": right - left, "front_change_N": front - m * G / 2}, [run])


demo = Demo(
    __name__,
    title="The engine in the corner",
    question="Does a transverse engine load the springs in a fast corner, and in which direction?",
    beats=(
        Beat(0.0, "In a fast corner the right springs carry 18 140 N more than the left."),
        Beat(share(0.5), "Of these the engine makes 140."),
    ),
    why="The crankshaft's angular momentum is carried round with the car, which takes a moment at right angles to "
    "it. An engine built across the car rolls it (it does not pitch it, as some books say): right and left loads "
    "change. One built along the car pitches it. But the share is small: of 18 140 N between right and left the "
    "engine makes 140 N, less than one per cent.",
    equation="right - left = 2 (m v^2 h / R + J W v / R) / track",
    symbols={
        "m": Symbol("car", "kg", "m"),
        "v": Symbol("speed", "m/s", "v"),
        "h": Symbol("height of the centre of mass", "m", "h"),
        "R": Symbol("curve", "m", "R"),
        "J": Symbol("moment of the crankshaft", "kg m^2", "J"),
        "W": Symbol("spin of the engine", "rad/s", "Omega"),
    },
    source="d(J W)/dt = w x H; Milliken, Milliken, Race Car Vehicle Dynamics (gyroscopic couples)",
    quantities={
        "right_minus_left_N": Quantity("right less left load", "N"),
        "front_change_N": Quantity("change of the front load", "N", absolute=1e-8),
    },
    ablation=Ablation(
        "gyroscopic",
        "half of the engine's share is lost; the other half is I dw/dt of the crankshaft",
        values=without_gyroscopic,
    ),  # fmt: skip
    against=Against("Omega", -900.0, 900.0, "speed of the crankshaft [rad/s]"),
    show={
        "curves": [("reaction", "left"), ("reaction", "right")],
        "shown": ["reaction force"],
        "traces": [],
        "hidden": ["joints", "joint names"],
        "follow": "car",
    },
    sliders=(
        Control("Omega", -900.0, 900.0, "rad/s", "engine"),
        Control("v", 10.0, 40.0, "m/s", "speed"),
        Control("J", 0.05, 1.0, "kg m^2", "crankshaft"),
    ),
    attempt="let the engine run backwards: the change of the loads turns round.",
)
