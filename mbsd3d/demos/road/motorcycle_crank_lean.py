"""A motorcycle whose crankshaft turns backwards leans a little less in the same curve."""

import numpy as np
from scipy.optimize import brentq

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Kinematic,
    Parallel,
    PositionDriver,
    Ramp,
    Revolute,
    Sine,
    System,
    accelerations,
    rotation,
    shapes,
    simulate,
)

from ..form import GRAVITY, Ablation, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share

G, SPINNING_MASS = 9.81, 1e-9  # m/s^2; kg of what only spins


def mechanism(*, m=250.0, h=0.6, Iyy=30.0, Izz=25.0, Jw=1.2, r=0.3, Jc=0.03, N=5.0, v=40.0, R=160.0,
              lean_deg=45.0, crank=1) -> System:  # fmt: skip
    """Build a frame m, (Iyy, Iyy, Izz), G at h, hinged on a base that runs round a circle R to the left at v; wheels of
    sum Jw.

    The crankshaft turns N times as fast as the wheels of radius r, forwards (crank 1) or backwards (-1).
    """
    lean, turn, wheel = np.radians(lean_deg), v / R, v / r
    tilt, up = rotation("x", -lean), np.array([0, 0, 1.0])
    axle, along = np.array([0, np.cos(lean), -np.sin(lean)]), np.array([0, np.sin(lean), np.cos(lean)])
    base = Body("base", 0.0, (0, 0, 0), shape=shapes.Box((1.4, 0.05, 0.005), at=(0, 0, 0), colour="gray"))
    turns = turn / (2 * np.pi)
    way = (Sine(R, turns), Sine(-R, turns, np.pi / 2, R), 0.0)
    frame = Body("motorcycle", m, (Iyy, Iyy, Izz), position=h * along, orientation=tilt, shape=machine(r - h))
    joints = [
        PositionDriver(base, at=(0, 0, 0), signal=way, name="way"),
        level := Parallel(GROUND, base, axis=up, name="level"),
        AngleDriver(level, Ramp(turn), name="turn"),
        hinge := Revolute(base, frame, at=(0, 0, 0), axis=(-1, 0, 0), name="lean"),
        AngleDriver(hinge, 0.0, name="balance"),
    ]
    bodies = [base, frame]
    spinners = {"front wheel": (0.7, r, Jw / 2, wheel), "rear wheel": (-0.7, r, Jw / 2, wheel),
                "crankshaft": (0.0, h, Jc, crank * N * wheel)}  # fmt: skip
    for name, (x, height, J, rate) in spinners.items():
        at = x * np.eye(3)[0] + height * along
        look = shapes.Torus(r - 0.05, 0.05, "y") if x else shapes.Cylinder(0.06, 0.4, "y")
        bodies.append(Body(name, SPINNING_MASS, (J, J, J), position=at, orientation=tilt, shape=look))
        axis = Revolute(frame, bodies[-1], at=at, axis=axle, name=f"{name} axle")
        joints += [axis, AngleDriver(axis, Ramp(rate), name=f"{name} speed")]
    return System(bodies, joints, gravity=(0, 0, -G))


def machine(low):
    """Draw engine, tank, seat, fork, swing arm and a rider; the axles stand at x = 0.7 and -0.7, at the height
    ``low``."""

    def bar(start, end, radius):
        start, end = np.array(start), np.array(end)
        return shapes.Cylinder(radius, np.linalg.norm(end - start), tuple(end - start), at=(start + end) / 2)

    rider = [bar((-0.35, 0, 0.3), (0.1, 0, 0.75), 0.15), shapes.Sphere(0.13, at=(0.22, 0, 0.88), colour="dimgray")]
    return [
        shapes.Box((0.6, 0.28, 0.35), at=(0, 0, -0.08)),
        shapes.Box((0.5, 0.26, 0.2), at=(0.15, 0, 0.22)),
        shapes.Box((0.6, 0.22, 0.1), at=(-0.4, 0, 0.2)),
        *(bar((0.7, y, low), (0.45, y, 0.35), 0.03) for y in (-0.1, 0.1)),
        *(bar((-0.7, y, low), (-0.2, y, -0.15), 0.03) for y in (-0.1, 0.1)),
        bar((0.42, -0.33, 0.38), (0.42, 0.33, 0.38), 0.02),
        *rider,
    ]


def moment(a, spin, m, h, Iyy, Izz, v, R):
    """Return the moment about the line of the tyres [N m], positive if the motorcycle falls."""
    W, s, c = v / R, np.sin(a), np.cos(a)
    return m * G * h * s - m * W**2 * (R - h * s) * h * c - spin * W * c - W**2 * (Izz - Iyy) * s * c


def theory(*, m, h, Iyy, Izz, Jw, r, Jc, N, v, R):
    """Solve m g h sin a = m W^2 (R - h sin a) h cos a + S W cos a + W^2 (Izz - Iyy) sin a cos a, S = sum J w."""
    require(R > h and v > 0, "demo 'motorcycle_crank_lean': give v > 0 and R > h")

    def lean(sign):
        spin = Jw * v / r + sign * Jc * N * v / r
        return np.degrees(brentq(moment, 0.0, np.radians(89.9), args=(spin, m, h, Iyy, Izz, v, R), xtol=1e-14))

    return {"lean_forward_crank_deg": lean(1), "lean_backward_crank_deg": lean(-1)}


def film(build) -> System:
    """Build what is seen: the lean without moment in the hinge, crank forwards."""
    return build(lean_deg=build.theory["lean_forward_crank_deg"])


def measure(build, terms, *, Jw, Jc, N, r, m, h, Iyy, Izz, v, R) -> Measured:
    """Measure the lean without moment in the hinge."""

    def held(lean_deg, crank):
        return accelerations(build(lean_deg=lean_deg, crank=crank), **terms).effort("balance")[0]

    forward, backward = (brentq(held, 0.0, 89.0, args=(sign,), xtol=1e-11) for sign in (1, -1))
    leans = np.linspace(backward - 1, forward + 1, 9)
    efforts = [held(lean, 1) for lean in leans]
    known = [-moment(np.radians(lean), (Jw + Jc * N) * v / r, m, h, Iyy, Izz, v, R) for lean in leans]
    run = simulate(build(lean_deg=forward), 2 * np.pi * R / v / 8, method=Kinematic(), output=121, **terms)
    curve = Curve("moment that would hold it, crank forwards [N m]", leans, efforts, (leans, known), "lean [deg]")
    return Measured({"lean_forward_crank_deg": forward, "lean_backward_crank_deg": backward}, [run], [curve])


demo = Demo(
    __name__,
    title="Racing motorcycles turn their cranks backwards",
    question="Why do racing motorcycles turn their crankshaft backwards?",
    beats=(
        Beat(0.0, "The same curve, the same speed."),
        Beat(share(0.5), "A crank that turns backwards needs less lean: 46.1 instead of 46.3 degrees."),
    ),
    why="Wheels and crankshaft are gyroscopes that the curve carries round. Turning forwards they try to lift the "
    "motorcycle out of its lean, so that it must lean farther to balance the same curve. A crankshaft that turns "
    "backwards takes part of that away: two tenths of a degree here, and less resistance to being thrown from "
    "one side to the other.",
    equation="m g h sin a = m W^2 (R - h sin a) h cos a + S W cos a + W^2 (I_z - I_y) sin a cos a; S = sum of J w",
    symbols={
        "a": Symbol("lean from the level", "rad"),
        "m": Symbol("motorcycle with rider", "kg", "m"),
        "h": Symbol("centre of mass over the road, upright", "m", "h"),
        "R": Symbol("curve", "m", "R"),
        "W": Symbol("rate round the curve", "rad/s", lambda v, R: v / R),
        "g": GRAVITY,
        "S": Symbol("angular momentum of all that spins", "N m s"),
        "I_z": Symbol("moment about its upright axis", "kg m^2", "Izz"),
        "I_y": Symbol("moment across", "kg m^2", "Iyy"),
        "J": Symbol("moment of a wheel", "kg m^2", "Jw"),
        "w": Symbol("its spin", "rad/s", lambda v, r: v / r),
    },
    source="Cossalter, Motorcycle Dynamics, ch. 4; Foale, Motorcycle Handling and Chassis Design",
    quantities={
        "lean_forward_crank_deg": Quantity("lean, crank forwards", "deg"),
        "lean_backward_crank_deg": Quantity("lean, crank backwards", "deg"),
    },
    ablation=Ablation("crank", "both lean alike", {"Jc": 1e-9}),
    show={
        "curves": [("effort", "balance")],
        "follow": "motorcycle",
        "hidden": ["joints", "joint names"],
        "traces": [],
        "view": (200.0, 12.0),
    },
    ranges={"lean_deg": None},
    may_vanish=("Jc",),
    sliders=(
        Control("Jc", 0.001, 0.3, "kg m^2", "crankshaft"),
        Control("v", 30.0, 50.0, "m/s", "speed"),
    ),
    attempt="take a heavier crankshaft: running forwards it asks for more lean, backwards for less.",
)
