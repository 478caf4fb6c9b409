"""A right call of everything that is built without computing: parts, signals, shapes, methods, measures."""

from math import pi, sin
from pathlib import Path

import numpy as np

import mbsd3d as m
from mbsd3d import GROUND, inertia, linkages, measures, rotations, shapes, signals

MESH = Path(__file__).parent / "x.stl"
BAR = m.Body("bar", 1.3, (0.2, 0.3, 0.25), com=(0.1, 0.2, 0.0), position=(0.4, 0.1, -0.3), omega=(0, 0.3, 0))
BLOCK = m.Body("block", 0.8, (0.1, 0.12, 0.11), position=(1.2, 0.1, 0.3))
LOOSE = m.Body("loose", 1.0, (0.1, 0.1, 0.1), velocity=(0.3, 0, 0), omega=(0, 0, 1.0))
HINGE = m.Revolute(GROUND, BAR, at=(0, 0, 0), axis=(0, 1, 0), name="hinge")
SLIDER = m.Prismatic(GROUND, BLOCK, at=(1, 0, 0), axis=(1, 0, 0.2), name="slider")
MOTOR = m.SpeedDriver(SLIDER, 0.1, name="motor")
SPRING = m.SpringDamper(BAR, BLOCK, at_a=(0.5, 0, 0), at_b=(1.2, 0, 0), stiffness=10.0, name="spring")
BALL = m.Contact(GROUND, LOOSE, shapes.Sphere(0.3), stiffness=1e3)
RIGHT = pi / 2
SYSTEM = m.System([BAR, BLOCK, LOOSE], [HINGE, SLIDER, MOTOR], [SPRING], name="machine")
SWING = m.System([BAR], [HINGE])
PLANE = ((0.0, 0.1, -1.0), (0.1, 0.0, 1.0))
BAR_Q = (*BAR.position, *BAR.orientation)


def pull(t, bodies, z, parameters, loads, z_dot):
    """Of a CustomForce: a spring to the origin whose length lags."""
    loads[0, :3] = -parameters[0] * bodies[0].r * (1.0 - z[0])
    z_dot[0] = parameters[1] * (bodies[0].r[0] - z[0])


def parts():
    """(name, call, arguments) of what is built without computing."""
    pair = {"a": GROUND, "b": BAR}
    here, along = {"at": (0.1, 0.2, 0.3)}, {"axis": (0, 1, 0.1)}
    built = {"at": (0.1, 0.2, 0.3), "at_b": (0.1, 0.2, 0.3)}
    name = {"name": "part"}
    look = {"at": (0, 0, 0.1), "orientation": (1, 0, 0, 0), "colour": "#336699"}
    yield m.Body, {
        "name": "b", "mass": 1.0, "inertia": (1, 1, 1), "com": (0, 0, 0.1), "position": (0, 1, 0),
        "orientation": (1, 0, 0, 0), "velocity": (0, 0, 1), "omega": (0, 0, 1), "shape": shapes.Sphere(0.1),
    }  # fmt: skip
    yield (
        m.System,
        {"bodies": [BAR], "joints": [HINGE], "forces": [], "gravity": (0, 0, -9.81), "name": "x", "title": "y"},
    )
    for joint in (m.Revolute, m.Prismatic, m.Cylindrical, m.PointOnLine):
        yield joint, pair | built | along | {"axis_b": (0, 1, 0.1)} | name
    yield m.Screw, pair | built | along | {"pitch": 0.01} | name
    for joint in (m.Spherical, m.Fixed):
        yield joint, pair | built | name
    for joint in (m.Planar, m.PointOnPlane):
        yield joint, pair | built | {"normal": (0, 1, 0.1)} | name
    yield m.Parallel, pair | along | {"axis_b": (0, 1, 0.1)} | name
    yield m.Universal, pair | here | {"axis_a": (0, 1, 0), "axis_b": (0, 0, 1)} | name
    yield m.ConstantVelocity, pair | here | {"axis_a": (0, 1, 0), "axis_b": (0, 1, 0.3)} | name
    yield m.Perpendicular, pair | {"axis_a": (0, 1, 0), "axis_b": (0, 0, 1)} | name
    yield m.Distance, pair | {"at_a": (0, 0, 0), "at_b": (0, 0, 1), "length": 1.0} | name
    turn = 2 * pi * np.arange(40) / 40
    oval = np.column_stack([0.4 * np.cos(turn), 0.3 * np.sin(turn), 0 * turn])
    yield m.CurveContact, pair | here | {"curve": oval, "closed": True} | name
    yield m.CurveContact, pair | here | {"curve": oval, "pin": (0, 0, 1), "radius": 0.02, "closed": True} | name
    yield m.CurveContact, pair | here | {"curve": oval, "face": (0, 1, 0), "closed": True} | name
    yield m.Gear, {"hinge_a": HINGE, "hinge_b": m.Revolute(GROUND, BLOCK, **here, **along), "ratio": 2.0} | name
    yield m.GearMesh, {
        "hinge_a": HINGE, "hinge_b": m.Revolute(GROUND, BLOCK, at=(1, 0, 0), axis=(0, 1, 0)), "at": (0.4, 0, 0),
        "pressure_angle": 0.3, "helix_angle": 0.0, "flank": 1, "carrier": None,
    } | name  # fmt: skip
    yield m.RackPinion, {"pinion": HINGE, "rack": SLIDER, "radius": 0.1} | name
    yield m.Coupler, {
        "x": (HINGE,), "y": SLIDER, "coefficients": (0.1, 0.2, -0.3), "x_weights": (2.0,), "y_weights": (1.0,),
        "x_of": "angle", "y_of": ("slide",),
    } | name  # fmt: skip
    yield m.KnifeEdge, pair | here | {"lateral": (0, 1, 0)} | name
    yield m.KnifeEdge, pair | here | {"heading": (1, 0, 0)} | name
    yield (
        m.RollingDisc,
        pair | along | {"radius": 0.3, "crown": 0.01, "centre": (0.4, 0.1, 0), "plane": ((0, 0, -1), (0, 0, 1))},
    )
    yield m.AngleDriver, {"hinge": HINGE, "signal": 0.3} | name
    yield m.SlideDriver, {"slider": SLIDER, "signal": 0.3} | name
    yield m.SpeedDriver, {"joint": HINGE, "speed": 0.3} | name
    yield m.SpeedDriver, pair | along | {"speed": 0.3} | name
    yield m.SpeedDriver, pair | here | {"direction": (1, 0, 0), "speed": 0.3} | name
    yield m.PositionDriver, {"body": BAR, "signal": (0, None, 0.1)} | here | name
    yield m.OrientationDriver, pair | {"signal": (0, m.Ramp(0.3), 0.1)} | name
    yield m.OrientationDriver, pair | {"signal": (0.2,), "axes": ((1, 0, 0),)} | name
    yield m.Force, {"body": BAR, "force": (0, 0, 1), "frame": "body"} | here | name
    yield m.Torque, {"body": BAR, "torque": (0, 0, 1), "frame": "body"} | name
    yield m.SpringDamper, pair | {
        "at_a": (0, 0, 0), "at_b": (0, 0, 1), "stiffness": 3.0, "damping": 1.0, "length": 0.5
    } | name  # fmt: skip
    yield m.TorsionSpring, {"hinge": HINGE, "stiffness": 3.0, "damping": 0.1, "angle": 0.2} | name
    yield m.SumSpring, {"joints": (HINGE, SLIDER), "weights": (2.0, -1.0), "of": ("angle", "slide"), "stiffness": 3.0,
                        "damping": 0.1, "rest": (0.1, 0.2)} | name  # fmt: skip
    yield m.RotationSpring, pair | {"stiffness": 3.0, "damping": 0.1} | name
    yield (
        m.Brake,
        {"hinge": HINGE, "torque": m.Pulse(3.0, start=0.2, edge=0.1), "stiffness": 900.0, "damping": 20.0} | name,
    )
    yield m.Limit, {"joint": HINGE, "kind": "angle", "lower": -1.0, "upper": 2.0, "name": "elbow"}
    limits = {"stiffness": 900.0, "damping": 2.0}
    yield m.EndStop, {"joint": HINGE, "lower": -0.3, "upper": 9.0, "of": "angle"} | limits | name
    yield m.PointStop, pair | built | along | {"lower": -0.3, "upper": 0.4} | limits | name
    turned = m.Revolute(GROUND, BLOCK, **here, **along)
    yield m.Backlash, {"gear": m.Gear(HINGE, turned, ratio=2.0), "angle": 0.01} | limits | name
    yield m.PinPlay, pair | built | along | {
        "clearance": 1e-3, "exponent": 1.5, "loss": 0.2, "mu": 0.1, "creep": 1e-3, "pin_radius": 0.01
    } | limits | name  # fmt: skip
    yield m.ConeStop, {"joint": m.Spherical(GROUND, BAR, at=(0, 0, 0)), "axis_a": (1, 0, 0), "axis_b": (1, 0, 0.1),
                       "half_angle": 0.4, "twist": (-0.3, 0.5)} | limits | name  # fmt: skip
    yield m.RotationStop, {"joint": m.Spherical(GROUND, BAR, at=(0, 0, 0)), "angle": 0.4} | limits | name
    yield m.SumStop, {"joints": (HINGE, SLIDER), "weights": (2.0, -1.0), "of": ("angle", "slide"), "lower": -0.1,
                      "upper": 0.2} | limits | name  # fmt: skip
    yield m.LinearActuator, pair | limits | name | {
        "at_a": (0, 0, 0), "at_b": (0, 0, 1), "thrust": 30.0, "rate": 0.4, "stroke": (0.9, 1.5)
    }  # fmt: skip
    wheel = m.Pulley(HINGE, radius=0.1, sense=-1, centre=(0, 0, 1), axis=(0, 1, 0), turns=1)
    yield m.Pulley, {"on": HINGE, "radius": 0.1, "sense": -1, "centre": (0, 0, 1), "axis": (0, 1, 0), "turns": 1}
    yield m.Winch, {"on": BAR, "radius": 0.1, "sense": -1, "centre": (0, 0, 1), "axis": (0, 1, 0), "turns": 0}
    ends = ((GROUND, (-1.0, 0, 0)), (BLOCK, (1.2, 0, 0.3)))
    yield m.Rope, limits | name | {"points": ends, "pulleys": (wheel,), "mu": 0.3, "length": 9.0, "pretension": None}
    yield m.Belt, limits | name | {
        "hinge_a": HINGE, "hinge_b": m.Revolute(GROUND, BLOCK, at=(1, 0, 0), axis=(0, 1, 0)), "radii": (0.1, 0.2),
        "pretension": 50.0, "mu": 0.4, "crossed": True,
    }  # fmt: skip
    table = {"points": [(-1.0, -3.0), (0.0, 0.0), (2.0, 1.0)], "between": "monotone", "beyond": "hold"}
    yield m.ForceCurve, pair | table | {"at_a": (0, 0, 0), "at_b": (0, 0, 1), "over": "stretch", "length": 0.5} | name
    yield m.TorqueCurve, table | {"joint": HINGE, "over": "angle"} | name
    yield m.ForceBetween, pair | here | {"force": (0, 0, 1), "frame": "a"} | name
    yield m.TorqueBetween, pair | {"torque": (0, 0, 1), "frame": "b"} | name
    yield m.JointFriction, {"hinge": HINGE, "coulomb": 3.0, "viscous": 0.1, "transition": 0.02} | name
    yield m.Bushing, pair | here | {
        "stiffness": 3.0, "turning_stiffness": 1.0, "damping": 0.1, "turning_damping": 0.1, "axes": (1, 0, 0, 0)
    } | name  # fmt: skip
    yield m.AeroDrag, {"body": BAR, "drag_area": 0.3, "density": 1.2, "wind": (1, 0, 0)} | here | name
    yield (
        m.FluidDrag,
        {"body": BAR, "lengths": (0.3, 0.1, 0.2), "density": 1.2, "viscosity": 0.1}
        | here
        | {"axes": (1, 0, 0, 0)}
        | name,
    )
    yield m.Weight, {"a": GROUND, "b": BAR, "acceleration": (0, 0, -1.6)} | name
    yield m.CentralGravity, {"a": GROUND, "b": BAR, "at": (0, 0, -50.0), "mu": 300.0} | name
    yield m.CustomForce, {
        "function": pull, "on": (BAR,), "points": [(0.1, 0, 0)], "parameters": (2.0, 3.0), "states": (0.1,),
        "scales": (1.0,), "labels": ["lag"], "external": True,
    } | name  # fmt: skip
    floor = {"plane": PLANE}
    yield m.Rolling, pair | {"surface": shapes.Sphere(0.3)} | floor | name
    yield m.Contact, pair | floor | name | {
        "surface": shapes.Sphere(0.3), "stiffness": 1e3, "exponent": 1.5, "damping": 1.0, "loss": 0.1, "friction": 0.3,
        "rolling": 0.01, "spinning": 0.01, "grip": 2e3, "grip_damping": 3.0,
    }  # fmt: skip
    yield m.Contact, pair | {"surface": shapes.Sphere(0.3), "stiffness": 1e3, "friction": 0.3, "creep": 0.01}
    yield m.Contact, pair | {"surface": shapes.Sphere(0.3), "stiffness": 1e3, "other": shapes.Capsule(0.1, 0.4, "x")}
    yield m.Tyre, pair | along | name | {
        "radius": 0.3, "crown": 0.05, "stiffness": 1e5, "damping": 400.0, "cornering": 14.0, "longitudinal": 20.0,
        "camber": 0.1, "relaxation": 0.1, "relaxation_x": 0.05, "mu": 0.9, "trail": 0.02, "twisting": 0.01,
        "rolling_resistance": 0.01, "nominal_load": 800.0, "grip_sensitivity": 0.1, "stiffness_sensitivity": 0.1,
        "standing_damping": 0.1, "standing_speed": 0.1, "centre": (0.4, 0.1, 0), "plane": PLANE,
    }  # fmt: skip
    yield m.StateFeedback, {
        "measures": [measures.angle(HINGE)], "gains": [1.0], "on": HINGE, "reference": (0.1,), "time_constant": 0.1
    } | name  # fmt: skip
    yield m.DOP853, {"dt": None, "max_step": 0.1, "stiff": "stop"}
    yield m.RadauIIA, {"dt": None, "max_step": 0.1}
    yield m.GeneralizedAlpha, {"dt": None, "rho": 0.8, "max_step": 0.1}
    for method in (m.DOP853, m.RK4, m.RadauIIA, m.GeneralizedAlpha):
        yield method, {"dt": 0.01}
    yield m.Kinematic, {"max_step": 0.1}
    yield m.Constant, {"value": 1.0}
    yield m.Ramp, {"rate": 1.0, "offset": 0.3}
    yield m.Sine, {"amplitude": 1.0, "frequency": 2.0, "phase": 0.1, "offset": 0.2}
    yield m.Polynomial, {"coefficients": (1.0, 2.0)}
    yield m.Pulse, {"height": 1.0, "start": 0.1, "edge": 0.2, "duration": 1.0}
    yield m.Table, {"times": [0, 1, 2, 3], "values": [0, 1, 0, 2]}
    yield m.Input, {"name": "u", "value": 0.1}
    yield signals.Scaled, {"signal": m.Ramp(1.0), "factor": 2.0}
    yield signals.Sum, {"signals": (m.Ramp(1.0), m.Sine(1.0, 2.0))}
    for ask in (m.Ramp(1.0), m.Ramp(1.0).derivative, m.Ramp(1.0).second_derivative):
        yield ask, {"t": 1.0}
    yield signals.as_signal, {"value": 1.0, "what": "force 'push'"}
    yield m.Table([0, 1, 2, 3], [0, 1, 0, 2]), {"t": [0.5, 1.0]}
    yield m.RollingBearing, {"C": 1e4, "p": 3.0, "tilting": 0.1, "X": 0.5, "Y": 1.2, "e": 0.3}
    yield m.DeepGrooveBallBearing, {"C": 1e4, "p": 3.0, "tilting": 0.1, "C0": 5e3, "f0": 14.0}
    yield m.reliability_factor, {"reliability": 0.95}
    yield m.Samples, {"names": ("a",), "points": [[1.0], [2.0]]}
    yield m.samples, {"ranges": {"a": (0, 1)}, "count": 4, "method": "random", "seed": 3}
    yield m.State, {"t": 0.0, "q": BAR_Q, "v": [0.0] * 6, "z": []}
    yield shapes.Box, {"lengths": (1, 2, 3)} | look
    for shape in (shapes.Capsule, shapes.Cylinder):
        yield shape, {"radius": 0.1, "length": 0.3, "axis": "x"} | look
    yield shapes.Disc, {"radius": 0.1, "thickness": 0.02, "axis": "x"} | look
    yield shapes.Torus, {"radius": 0.1, "tube": 0.02, "axis": "x"} | look
    yield shapes.Ellipsoid, {"radii": (1, 2, 3)} | look
    yield shapes.Hull, {"points": [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]} | look
    yield shapes.Lines, {"points": [(0, 0, 0), (1, 2, 3)]} | look
    yield shapes.Sphere, {"radius": 0.1} | look
    yield shapes.MeshFile, {"path": str(MESH), "scale": 1.0} | look
    yield inertia.box, {"mass": 1.0, "lengths": (1, 2, 3)}
    yield inertia.ellipsoid, {"mass": 1.0, "radii": (1, 2, 3)}
    for solid, length in ((inertia.cone, "height"), (inertia.cylinder, "length"), (inertia.capsule, "length")):
        yield solid, {"mass": 1.0, "radius": 0.2, length: 0.3, "axis": "x"}
    yield inertia.rod, {"mass": 1.0, "length": 0.2, "radius": 0.01, "axis": "x"}
    yield inertia.sphere, {"mass": 1.0, "radius": 0.2}
    yield inertia.steiner, {"mass": 1.0, "offset": (1, 2, 3)}
    yield inertia.combine, {"parts": [(1.0, (0, 0, 0), (1, 1, 1))]}
    yield inertia.MassProperties, {"mass": 1.0, "com": (0, 0, 0), "inertia": (1, 1, 1)}
    yield rotations.rotation, {"axis": "z", "angle": 0.3, "degrees": False}
    yield rotations.as_quaternion, {"orientation": np.eye(3)}
    yield rotations.quaternion_from_matrix, {"R": np.eye(3)}
    for function in (rotations.H, rotations.conjugate, rotations.logarithm, rotations.matrix):
        yield function, {"e": (1, 0, 0, 0)}
    yield rotations.exponential, {"theta": (0.1, 0.2, 0.3)}
    yield rotations.multiply, {"p": (1, 0, 0, 0), "q": (1, 0, 0, 0)}
    yield rotations.skew, {"a": (0.1, 0.2, 0.3)}
    turn = {"angle": 0.7}
    twist, b = {"a": 0.3, "alpha": 0.7}, 0.3 / sin(0.7)
    yield linkages.bennett, twist | {"b": b * sin(1.9), "beta": 1.9} | turn | {
        "links": None, "position": (0, 0, 0), "orientation": (1, 0, 0, 0), "gravity": (0, 0, -9.81)
    }  # fmt: skip
    yield linkages.goldberg, twist | {"b": b * sin(1.9), "beta": 1.9, "c": b * sin(0.4), "gamma": 0.4} | turn
    yield linkages.myard, twist | {"b": b} | turn
    yield linkages.bricard, {"length": 0.3} | turn
    yield linkages.schatz, {"length": 0.3, "offset": 0.1} | turn
    yield linkages.hinge_loop, {
        "lengths": [0.7] * 6, "twists": [RIGHT, -RIGHT] * 3, "offsets": [0.0] * 6, "angles": [RIGHT] * 6
    }  # fmt: skip
    six = {"lengths": [0.7] * 3, "twists": [RIGHT, -RIGHT, RIGHT], "angle": RIGHT}
    yield linkages.bricard_plane, six | {"offsets": [0.0] * 2, "near": [RIGHT] * 3}
    general = {"lengths": [1.0, 1.3, 0.8], "twists": [0.9, 1.4, -1.1], "angle": 0.8}
    yield linkages.bricard_line, general | {"offsets": [0.2, 0.1, -0.3], "near": None}
    yield linkages.rssr, {
        "crank": 0.2, "rod": 0.6, "rocker": 0.6, "distance": 0.5, "twist": 1.0, "offsets": (0, 0), "branch": 1,
        "spin": False,
    } | turn  # fmt: skip
    yield linkages.sarrus, {"first": (0.3, 0.3), "second": (0.3, 0.3), "between": 1.5, "reach": 0.1} | turn


def measured():
    """Measures."""
    pair = {"a": BAR, "b": BLOCK}
    points = {"at_a": (0, 0, 0), "at_b": (0, 0, 1)}
    for measure in (measures.angle, measures.rate):
        yield measure, {"hinge": HINGE}
    for measure in (measures.slide, measures.slide_rate):
        yield measure, {"slider": SLIDER}
    for measure in (measures.position, measures.velocity):
        yield measure, {"body": BAR, "axis": (1, 0, 0), "at": (0, 0, 0)}
    yield measures.omega, {"body": BAR, "axis": (1, 0, 0)}
    for measure in (measures.lean, measures.lean_rate):
        yield measure, {"body": BAR, "lateral": (0, 1, 0)}
    for measure in (measures.heading, measures.heading_rate):
        yield measure, {"body": BAR, "forward": (1, 0, 0)}
    yield measures.camber, {"wheel": BAR, "axle": (0, 1, 0)}
    for measure in (measures.distance, measures.between):
        yield measure, pair | points
    for measure in (measures.offset, measures.offset_rate):
        yield measure, pair | points | {"along": (1, 0, 0)}
    for measure in (measures.turn, measures.turn_rate):
        yield measure, pair | {"about": (1, 0, 0)}
    yield measures.angle_between, pair | {"axis_a": (1, 0, 0), "axis_b": (0, 1, 0), "about": (0, 0, 1)}
    yield measures.reaction, {"joint": HINGE, "axis": (1, 0, 0.1), "of": "moment", "axes": "b"}
    for measure in (measures.clearance, measures.leaves, measures.normal_force, measures.touches):
        yield measure, {"contact": BALL}
    yield measures.tension, {"rope": next(make(**given) for make, given in parts() if make is m.Rope), "section": 0}
    yield measures.length, {"spring": SPRING}
    yield measures.state, {"force": next(make(**given) for make, given in parts() if make is m.StateFeedback)}
