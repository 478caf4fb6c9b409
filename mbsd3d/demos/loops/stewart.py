"""A platform on six legs carries anything, but not at every angle."""

import numpy as np

from mbsd3d import (
    GROUND,
    Body,
    Distance,
    Kinematic,
    LengthDriver,
    System,
    Table,
    Torque,
    accelerations,
    rotation,
    shapes,
    simulate,
)

from ..form import Ablation, Beat, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share

G = 9.81  # m/s^2
YAW_SECONDS, YAW_SAMPLES = 3.0, 121  # [s] in which the platform yaws, and places by which its legs are driven


def corners(Rb, Rp, half_base_deg, half_top_deg, h, yaw_deg):
    """Return feet and heads of the legs: pairs of feet at 0, 120, 240 degrees, pairs of heads between them [m], shape
    (6, 3) each.
    """
    thirds = np.repeat([0.0, 120.0, 240.0], 2)
    foot = np.radians(thirds + np.tile([1, -1], 3) * half_base_deg + np.tile([0, 120], 3))
    head = np.radians(thirds + 60 - np.tile([1, -1], 3) * half_top_deg + yaw_deg)
    return (Rb * np.stack([np.cos(foot), np.sin(foot), 0 * foot], axis=1),
            np.stack([Rp * np.cos(head), Rp * np.sin(head), h + 0 * head], axis=1))  # fmt: skip


def mechanism(*, Rb=1.0, Rp=0.6, half_base_deg=10.0, half_top_deg=15.0, h=0.9, yaw_deg=80.0, m=100.0, torque=50.0):
    """Build feet on a circle Rb [m], platform m [kg] of radius Rp at h [m], turned by a yaw; a torque [N m] about z on
    it.
    """
    feet, heads = corners(Rb, Rp, half_base_deg, half_top_deg, h, yaw_deg)
    turned = rotation("z", yaw_deg, degrees=True)
    plate = Body("platform", m, (0.1 * m * Rp**2,) * 3, position=(0, 0, h), orientation=turned,
                 shape=shapes.Cylinder(1.1 * Rp, 0.04))  # fmt: skip
    legs = [Distance(GROUND, plate, at_a=foot, at_b=head, name=f"leg {k + 1}")
            for k, (foot, head) in enumerate(zip(feet, heads, strict=True))]  # fmt: skip
    return System([plate], legs, [Torque(plate, (0, 0, torque), name="load")], gravity=(0, 0, -G))


def yawing(build, Rb, Rp, half_base_deg, half_top_deg, h, yaw_deg):
    """Return the simulator whose legs change their lengths so that it yaws from 0 to the angle, at the same height."""
    t = np.linspace(0.0, YAW_SECONDS, YAW_SAMPLES)
    yaws = yaw_deg * (10 - 15 * (t / YAW_SECONDS) + 6 * (t / YAW_SECONDS) ** 2) * (t / YAW_SECONDS) ** 3
    places = [corners(Rb, Rp, half_base_deg, half_top_deg, h, yaw) for yaw in yaws]
    lengths = np.array([np.linalg.norm(heads - feet, axis=1) for feet, heads in places]).T
    held = build(yaw_deg=0.0)
    legs = [LengthDriver(leg.a, leg.b, at_a=leg.at_a, at_b=leg.at_b, length=Table(t, length), name=leg.name)
            for leg, length in zip(held.joints, lengths, strict=True)]  # fmt: skip
    return System(held.bodies, legs, held.forces, gravity=(0, 0, -G))


def thrusts(feet, heads, h, m, torque):
    """Return the compressions of the legs [N] that balance weight and torque: one 6x6 system of forces and moments
    about the middle, shape (6,).
    """
    along = (heads - feet) / np.linalg.norm(heads - feet, axis=1)[:, None]
    wrenches = np.vstack([along.T, np.cross(heads - [0, 0, h], along).T])
    require(np.linalg.cond(wrenches) < 1e9, "demo 'stewart': here the six legs leave the platform loose (det J "
            "= 0, as at "
            "a yaw of 90 degrees); give another yaw_deg")  # fmt: skip
    return np.linalg.solve(wrenches, [0, 0, m * G, 0, 0, -torque])


def theory(*, Rb, Rp, half_base_deg, half_top_deg, h, yaw_deg, m, torque):
    """Return the statics of the platform."""
    feet, heads = corners(Rb, Rp, half_base_deg, half_top_deg, h, yaw_deg)
    found = thrusts(feet, heads, h, m, torque)
    return {"leg1_thrust_N": found[0], "leg2_thrust_N": found[1]}


def pushes(run):
    """Return the forces of the legs on the platform along the legs [N], shape (6,)."""
    found = []
    for leg in run.system.joints:
        along = (leg.at_b - leg.at_a) / leg.length
        found.append(float(run.reaction(leg).force[0] @ along))
    return found


def measure(build, terms, *, Rb, Rp, half_base_deg, half_top_deg, h, yaw_deg) -> Measured:
    """Measure the reactions of the legs at rest, and how they grow with the yaw; the film yaws to it."""
    system = build()
    here = pushes(accelerations(system, **terms))
    yaws = np.linspace(0, 85, 18)
    over = [pushes(accelerations(build(yaw_deg=yaw), **terms))[0] for yaw in yaws]
    known = [theory(**{**build.values, "yaw_deg": yaw})["leg1_thrust_N"] for yaw in yaws]
    moving = yawing(build, Rb, Rp, half_base_deg, half_top_deg, h, yaw_deg)
    run = simulate(moving, YAW_SECONDS, method=Kinematic(), output=YAW_SAMPLES, **terms)
    curve = Curve(
        "push of leg 1 [N]", yaws, over, (yaws, known), "yaw [deg]", "no limit as the yaw comes to 90 degrees"
    )
    return Measured({"leg1_thrust_N": here[0], "leg2_thrust_N": here[1]}, [run], [curve])


demo = Demo(
    __name__,
    title="The limit of a flight simulator",
    question="Why may a flight simulator never yaw by 90 degrees?",
    beats=(
        Beat(0.0, "Six legs carry the cabin with little force."),
        Beat(share(0.5), "It turns, and the legs lie down like threads of a screw."),
        Beat(share(1.0), "80 degrees: leg 1 pulls with 2300 N. At 90 nothing would hold it."),
    ),
    why="Six legs with ball ends hold six degrees of freedom, if their lines are independent. As the platform yaws, "
    "the legs lean more and more like the threads of a screw, and at 90 degrees all six lines belong to one family: a "
    "small twist changes none of their lengths. Shortly before, a small torque asks for huge forces, and at 90 degrees "
    "the platform is loose.",
    equation="J^T f = load; f without limit where det J = 0: 90 degrees",
    symbols={
        "f": Symbol("push of the legs; upwards that of leg 1", "N", curve=(0, 2), arrow="reaction force"),
        "J": Symbol("rates of the legs over those of the cabin"),
        "T": Symbol("means transposed"),
    },
    source="Fichter, Int. J. Robotics Res. 5 (1986) 157; Ma, Angeles, Architecture singularities (1991)",
    quantities={
        "leg1_thrust_N": Quantity("push of leg 1", "N"),
        "leg2_thrust_N": Quantity("push of leg 2", "N"),
    },
    alone="its legs follow tables of lengths",
    ablation=Ablation("yaw", "straight the legs share the weight", {"yaw_deg": 0.0}),
    show={
        "curves": [("reaction", "leg 1"), ("reaction", "leg 2")],
        "shown": ["reaction force"],
        "traces": [],
        "hidden": ["joint names"],
    },
    ranges={"yaw_deg": (20.0, 80.0)},
)
