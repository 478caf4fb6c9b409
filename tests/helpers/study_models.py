"""Mechanisms of `tests/data/studies.json` by its parameters: what `Study` takes, and the sweep of its entries."""

import json
from pathlib import Path

import numpy as np

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    CentralGravity,
    Contact,
    Distance,
    Fixed,
    Prismatic,
    Ramp,
    Revolute,
    RollingDisc,
    Sine,
    Spherical,
    SpringDamper,
    System,
    TorsionSpring,
    Universal,
    measures,
    rotation,
    shapes,
)

TRUTH = {x["name"]: x for x in json.loads((Path(__file__).parents[1] / "data" / "studies.json").read_text())}
Y = (0.0, 1.0, 0.0)


def pendulum(l, g, th0, J, m):
    """Physical pendulum released at rest, until its lowest point."""
    bob = Body("bob", m, (J, J, J), position=(l * np.sin(th0), 0, -l * np.cos(th0)), omega=(0, 0, 0))
    hinge = Revolute(GROUND, bob, at=(0, 0, 0), axis=Y, name="hinge")
    return System([bob], [hinge], gravity=(0, 0, -g)), {"stop_when": measures.position(bob, axis=(1, 0, 0)) < 0.0}


def grazing(x_stop, l, g, th0, J, m):
    """The same until it has swung to the other side."""
    system, _ = pendulum(l, g, th0, J, m)
    return system, {"stop_when": measures.position(system.bodies[0], axis=(1, 0, 0)) < x_stop}


def oscillator(m, k, c, x0, t):
    """Mass, spring and damper along x, released at x0."""
    box = Body("box", m, (0.1, 0.1, 0.1), position=(1.0 + x0, 0, 0), velocity=(0, 0, 0))
    rail = Prismatic(GROUND, box, at=(0, 0, 0), axis=(1, 0, 0))
    spring = SpringDamper(GROUND, box, at_a=(0, 0, 0), at_b=(1.0 + x0, 0, 0), stiffness=k, damping=c, length=1.0)
    return System([box], [rail], [spring]), {"t_end": t}


def free_body(I1, I2, I3, a, b, t):
    """Free body that spins about the axis of its middle moment, up to t."""
    body = Body("body", 1.0, (I1, I2, I3), omega=(a, b, 0))
    return System([body], gravity=(0, 0, 0)), {"t_end": t}


def top(spin, m, h, I3, I1, th, g):
    """Heavy top released with its axis at rest, until it is lowest."""
    axis = np.array([np.sin(th), 0, np.cos(th)])
    turn = rotation(Y, th)
    body = Body("top", m, (I1, I1, I3), position=(0, 0, 0), com=(0, 0, h), orientation=turn, omega=spin * axis)
    pivot = Spherical(GROUND, body, at=(0, 0, 0))
    rises = measures.velocity(body, axis=(0, 0, 1), at=h * axis) > 0.0
    return System([body], [pivot], gravity=(0, 0, -g)), {"stop_when": rises}


def ball(h, k, m, g, t):
    """Ball of radius 0.1 m that falls by h on a linear spring without damping."""
    one = Body("ball", m, (0.004, 0.004, 0.004), position=(0, 0, 0.1 + h), velocity=(0, 0, 0), omega=(0, 0, 0))
    floor = Contact(GROUND, one, shapes.Sphere(0.1), stiffness=k, exponent=1.0, damping=0.0)
    return System([one], forces=[floor], gravity=(0, 0, -g)), {"t_end": t}


def cardan(bend):
    """Two shafts and a cross, turned evenly by a quarter of a turn."""
    away = np.array([np.cos(bend), 0, np.sin(bend)])
    one = Body("in", 1.0, (0.1, 0.1, 0.1))
    other = Body("out", 1.0, (0.1, 0.1, 0.1))
    first = Revolute(GROUND, one, at=(0, 0, 0), axis=(1, 0, 0), name="first")
    last = Revolute(GROUND, other, at=(0, 0, 0), axis=away, name="last")
    cross = Universal(one, other, at=(0, 0, 0), axis_a=Y, axis_b=np.cross(away, Y))
    return System([one, other], [first, last, cross, AngleDriver(first, Ramp(1.0))], gravity=(0, 0, 0))


def four_bar(r, cl, rk, px, pz, th):
    """Four-bar with frame of 1 m, built at a crank angle of 1.1 rad and driven to th; coupler point (px, pz)."""
    built = 1.1
    B = r * np.array([np.cos(built), 0, np.sin(built)])
    D = np.array([1.0, 0, 0])
    gap = D - B
    apart = np.sqrt(gap @ gap)
    along = (cl * cl - rk * rk + apart * apart) / (2 * apart)
    ahead = gap / apart
    C = B + along * ahead + np.sqrt(cl * cl - along * along) * np.array([-ahead[2], 0, ahead[0]])
    crank = Body("crank", 1.0, (0.1, 0.1, 0.1), position=B / 2)
    coupler = Body("coupler", 1.0, (0.1, 0.1, 0.1), position=(B + C) / 2)
    rocker = Body("rocker", 1.0, (0.1, 0.1, 0.1), position=(D + C) / 2)
    drive = Revolute(GROUND, crank, at=(0, 0, 0), axis=(0, -1, 0), name="drive")
    others = [Revolute(crank, coupler, at=B, axis=Y), Revolute(coupler, rocker, at=C, axis=Y)]
    others.append(Revolute(GROUND, rocker, at=D, axis=Y))
    u = (C - B) / cl
    point = B + px * u + pz * np.array([-u[2], 0, u[0]])
    tip = Body("tip", 0.1, (0.1, 0.1, 0.1), position=point)
    system = System(
        [crank, coupler, rocker, tip],
        [drive, *others, Fixed(coupler, tip, at=point), AngleDriver(drive, Ramp(th - built))],
    )
    return system


def damped_pendulum(l, J, c, m=1.3, th0=0.8):
    """Physical pendulum with a damper in its hinge, released at rest."""
    bob = Body("bob", m, (J, J, J), position=(l * np.sin(th0), 0, -l * np.cos(th0)), omega=(0, 0, 0))
    hinge = Revolute(GROUND, bob, at=(0, 0, 0), axis=Y, name="hinge")
    return System([bob], [hinge], [TorsionSpring(hinge, stiffness=0.0, damping=c)])


def orbit(mu, r0, v0):
    """A stone about a centre, until it has gone half round."""
    stone = Body("stone", 2.0, (1, 1, 1), position=(r0, 0, 0), velocity=(0, v0, 0), omega=(0, 0, 0))
    force = CentralGravity(GROUND, stone, at=(0, 0, 0), mu=mu)
    return System([stone], forces=[force], gravity=(0, 0, 0)), {
        "stop_when": measures.position(stone, axis=(0, 1, 0)) < 0.0
    }


def disc(r, g, v):
    """Thin uniform disc that rolls straight on."""
    one = Body(
        "disc",
        1.0,
        (0.25 * r * r, 0.5 * r * r, 0.25 * r * r),
        position=(0, 0, r),
        velocity=(v, 0, 0),
        omega=(0, v / r, 0),
    )
    return System([one], [RollingDisc(GROUND, one, axis=Y, radius=r)], gravity=(0, 0, -g))


def sleeping_top(m, h, I1, I3, g, spin):
    """Upright top; I1 about its pivot."""
    own = I1 - m * h * h
    body = Body("top", m, (own, own, I3), com=(0, 0, h), omega=(0, 0, spin))
    return System([body], [Spherical(GROUND, body, at=(0, 0, 0))], gravity=(0, 0, -g))


def two_masses(m1, m2, k1, k2):
    """Two masses in a row, each on a spring."""
    one, other = (Body(n, m, (0.1, 0.1, 0.1), position=(x, 0, 0)) for n, m, x in (("one", m1, 1.0), ("other", m2, 2.0)))
    rails = [Prismatic(GROUND, body, at=body.position, axis=(1, 0, 0)) for body in (one, other)]
    springs = [
        SpringDamper(a, b, at_a=(x, 0, 0), at_b=(x + 1, 0, 0), stiffness=k, length=1.0)
        for a, b, x, k in ((GROUND, one, 0.0, k1), (one, other, 1.0, k2))
    ]
    return System([one, other], rails, springs, gravity=(0, 0, 0))


def arm_on_spring(k, m, g, l):
    """A level arm on a torsion spring, which is loose there."""
    arm = Body("arm", m, (0.1, 0.1, 0.1), position=(l, 0, 0))
    hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=Y, name="hinge")
    return System([arm], [hinge], [TorsionSpring(hinge, stiffness=k)], gravity=(0, 0, -g))


def cone(l, g, th, w):
    """Point mass on a string that goes round at the angle th."""
    place = (l * np.sin(th), 0, -l * np.cos(th))
    stone = Body("stone", 1.0, (1, 1, 1), position=place, velocity=(0, w * l * np.sin(th), 0), omega=(0, 0, 0))
    return System([stone], [Distance(GROUND, stone, at_a=(0, 0, 0), at_b=stone.position)], gravity=(0, 0, -g))


DH = (
    (0, 0, np.pi / 2), (0.4318, 0.1, 0), (0.0203, 0.15, -np.pi / 2), (0, 0.4318, np.pi / 2), (0, 0, -np.pi / 2),
    (0, 0.06, 0),
)  # fmt: skip
LINK = {
    "m": 2.0, "x": 0.05, "y": -0.03, "z": 0.07, "XX": 0.05, "YY": 0.06, "ZZ": 0.055, "XY": 0.004, "YZ": -0.003,
    "ZX": 0.005,
}  # fmt: skip


def link_parameters():
    """Ten parameters of each link of the arm, some percent apart."""
    return {f"{name}{i}": value * (1.0 + 0.07 * i) for i in range(1, 7) for name, value in LINK.items()}


def arm_6r(gravity, **p):
    """Arm of the Denavit-Hartenberg table DH, driven in all hinges by sines."""
    T, bodies, joints = np.eye(4), [], []
    for i, (a, d, alpha) in enumerate(DH, 1):
        axis, place = T[:3, 2], T[:3, 3]
        c, s = np.cos(alpha), np.sin(alpha)
        T = T @ np.array([[1, 0, 0, a], [0, c, -s, 0], [0, s, c, d], [0, 0, 0, 1.0]])
        XX, YY, ZZ, XY, YZ, ZX = (p[f"{name}{i}"] for name in ("XX", "YY", "ZZ", "XY", "YZ", "ZX"))
        inertia = [[XX, XY, ZX], [XY, YY, YZ], [ZX, YZ, ZZ]]
        com = (p[f"x{i}"], p[f"y{i}"], p[f"z{i}"])
        bodies.append(Body(f"link{i}", p[f"m{i}"], inertia, com=com, position=T[:3, 3], orientation=T[:3, :3]))
        base = bodies[-2] if i > 1 else GROUND
        joints.append(Revolute(base, bodies[-1], at=place, axis=axis, name=f"hinge{i}"))
        drive = Sine(0.9 + 0.1 * i, 0.31 + 0.113 * i, 0.0) + Sine(0.4, 0.9 - 0.07 * i, 0.0)
        joints.append(AngleDriver(joints[-1], drive, name=f"drive{i}"))
    return System(bodies, joints, gravity=gravity)


def slider_crank(along, across, R=0.05, L=0.2, rod_mass=0.4, rod_centre=0.5, piston_mass=0.6, speed=100.0):
    """Slider-crank at its outer dead centre, with a counterweight of mass times arm (along, across) [kg m]."""
    still = (1e-3, 1e-3, 1e-3)
    crank = Body("crank", 1.0, still, com=(along, 0, across))
    rod = Body("rod", rod_mass, still, position=(R, 0, 0), com=(rod_centre * L, 0, 0))
    piston = Body("piston", piston_mass, still, position=(R + L, 0, 0))
    drive = Revolute(GROUND, crank, at=(0, 0, 0), axis=Y, name="drive")
    pins = [Revolute(crank, rod, at=(R, 0, 0), axis=Y), Revolute(rod, piston, at=(R + L, 0, 0), axis=Y)]
    bore = Prismatic(GROUND, piston, at=(R + L, 0, 0), axis=(1, 0, 0), name="bore")
    motor = AngleDriver(drive, Ramp(speed), name="motor")
    return System([crank, rod, piston], [drive, *pins, bore, motor], gravity=(0, 0, 0))


def shaking(solution):
    """Mean square of the force on the ground over a turn whose end is its start [N^2]."""
    force = sum(solution.reaction(joint).force[:-1] for joint in ("drive", "bore"))
    return float((force**2).sum(axis=1).mean())


def wishbones(y, z, arm=0.35):
    """Suspension with equal parallel arms; the inner joint of its tie rod is off by (y, z)."""
    light = (0.01, 0.01, 0.01)
    lower = Body("lower", 2.0, light, position=(0, 0.3 + arm / 2, 0.2))
    upper = Body("upper", 2.0, light, position=(0, 0.3 + arm / 2, 0.45))
    upright = Body("upright", 12.0, (0.2, 0.2, 0.2), position=(0, 0.3 + arm, 0.3))
    inner = [
        Revolute(GROUND, b, at=(0, 0.3, h), axis=(1, 0, 0), name=f"{b.name} hinge")
        for b, h in ((lower, 0.2), (upper, 0.45))
    ]
    outer = [Spherical(b, upright, at=(0, 0.3 + arm, h)) for b, h in ((lower, 0.2), (upper, 0.45))]
    rod = Distance(GROUND, upright, at_a=(-0.12, 0.3 + y, 0.3 + z), at_b=(-0.12, 0.3 + arm, 0.3))
    motor = AngleDriver(inner[0], Sine(0.25, 0.25))
    return System([lower, upper, upright], [*inner, *outer, rod, motor])


def steer(solution):
    """Angle by which the upright has turned about z at each sample [rad]."""
    R = solution.rotation("upright")
    return np.arctan2(R[:, 1, 0], R[:, 0, 0])


def truth(name):
    """Return (parameters, value, derivatives in their order) of an entry."""
    one = TRUTH[name]
    return one["parameters"], one["value"], np.array([one["derivatives"][x] for x in one["parameters"]])
