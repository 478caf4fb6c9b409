"""A ball on a turntable neither flies off nor turns with it: it runs in circles of its own."""

import numpy as np

from mbsd3d import GROUND, Body, Revolute, RollingDisc, SpeedDriver, System, shapes, simulate

from ..form import Ablation, Against, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require


def mechanism(*, r=0.05, k=0.4, Omega=3.5, v=0.2, x0=0.5) -> System:
    """Build a table at Omega [rad/s], ball of radius r [m] and inertia k m r^2 at (x0, 0), sent off along y at v
    [m/s]."""
    plate = shapes.Cylinder(np.hypot(x0, 4 * v) + 2 * r, 0.02, at=(0, 0, -0.01))
    table = Body("table", 5.0, (1, 1, 1), omega=(0, 0, Omega), shape=plate)
    ball = Body("ball", 0.5, (0.5 * k * r**2,) * 3, position=(x0, 0, r), velocity=(0, v, 0), shape=shapes.Sphere(r))
    joints = [
        Revolute(GROUND, table, at=(0, 0, 0), axis=(0, 0, 1), name="bearing"),
        SpeedDriver(GROUND, table, axis=(0, 0, 1), speed=Omega, name="motor"),
        RollingDisc(table, ball, axis=(0, 1, 0), radius=r, crown=r, name="contact"),
    ]
    return System([table, ball], joints)


def path(t, *, k, Omega, v, x0):
    """Return (x, y) of v' = W k/(1 + k) z x v, which turns the velocity at a constant rate, so the path is a circle
    [m].
    """
    rate = k / (1 + k) * Omega
    half = 0.5 * rate * t
    chord = v * t * np.sinc(half / np.pi)
    return x0 - chord * np.sin(half), chord * np.cos(half)


def theory(*, k, Omega, v, x0, t):
    """Return 2/7 of the table's rate for a solid ball, 2/5 for a hollow one, whatever the start."""
    require(v != 0, "demo 'ball_on_turntable': v = 0: the ball stays where it is; send it off")
    x, y = path(t, k=k, Omega=Omega, v=v, x0=x0)
    return {"circle_rate_rad_s": abs(k / (1 + k) * Omega), "x_m": x, "y_m": y}


def measure(build, terms, *, k, Omega, v, x0, t=4.0) -> Measured:
    """Measure the rate at which the velocity turns, and the position at t."""
    run = simulate(build(), t, rtol=1e-13, output=401, **terms)
    vx, vy, _ = run.velocity("ball").T
    x, y, _ = run.position("ball").T
    rate = abs(np.ptp(np.unwrap(np.arctan2(vy, vx)))) / t
    curve = Curve("y [m]", x, y, path(run.t, k=k, Omega=Omega, v=v, x0=x0), "x [m]", "seen from above", equal=True)
    return Measured({"circle_rate_rad_s": rate, "x_m": x[-1], "y_m": y[-1]}, [run], [curve])


demo = Demo(
    __name__,
    title="The ball on the turntable",
    question="Why does a ball on a turntable run in circles of its own, at 2/7 of the table's rate?",
    beats=(
        Beat(0.0, "A ball is rolled onto a turning table."),
        Beat(1.795, "The table has turned once, the ball has done 2/7 of a circle."),
        Beat(3.59, "Twice, and 4/7: the circle is its own, not that of the table."),
    ),
    why="The table drags the ball's lowest point sideways, the faster the farther out it is; the ball spins up and "
    "at the same time is pushed at right angles to its own velocity. A force that is always at right angles to "
    "the velocity and proportional to it makes circles, as a magnet does with electrons. Their rate does not "
    "depend on place, speed, size or mass: only on how the mass is spread, k = I/(m r^2).",
    equation="v' = W k/(1 + k) z x v; solid ball: k = 2/5, 2/7 of the rate of the table",
    symbols={
        "v": Symbol("speed of the ball at the start", "m/s", "v"),
        "W": Symbol("turn of the table", "rad/s", "Omega"),
        "k": Symbol("moment of the ball over m r^2", "", "k"),
        "z": Symbol("upwards"),
    },
    source="Weltner, Am. J. Phys. 47 (1979) 984; Burns, Am. J. Phys. 49 (1981) 56",
    quantities={
        "circle_rate_rad_s": Quantity("rate of the circle", "rad/s"),
        "x_m": Quantity("place at t, x", "m"),
        "y_m": Quantity("place at t, y", "m"),
    },
    ablation=Ablation("turning", "on a table at rest it runs straight on", {"Omega": 0.0}),
    against=Against("k", 0.05, 0.66, "I/(m r^2) [-]"),
    show={"curves": [("position", "ball")], "traces": [("ball", (0.5, 0, 0.05))], "hidden": ["ground grid"]},
    sliders=(
        Control("k", 0.1, 0.66, "", "moment of inertia over m r^2"),
        Control("Omega", 1.0, 6.0, "rad/s", "turntable"),
        Control("v", -0.4, 0.4, "m/s", "push"),
    ),
    attempt="take a hollow ball, 2/3: its circle takes two fifths of the turntable's rate. Push it "
    "otherwise: another circle, the same rate.",
)
