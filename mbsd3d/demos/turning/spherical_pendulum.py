"""A pendulum pushed sideways draws an ellipse, and the ellipse slowly turns."""

import numpy as np

from mbsd3d import GROUND, Body, Distance, System, measures, shapes, simulate

from ..form import GRAVITY, Ablation, Against, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..quadrature import swing
from ..runs import next_turn

G = 9.81  # m/s^2


def mechanism(*, l=1.0, theta_deg=60.0, phi_rate=1.5) -> System:
    """Build a bob on a rod of l [m] at an angle theta from the vertical, sent off sideways at phi_rate [rad/s]."""
    angle = np.radians(theta_deg)
    place = l * np.array([np.sin(angle), 0, -np.cos(angle)])
    side = (0, phi_rate * l * np.sin(angle), 0)
    bob = Body("bob", 1.0, (1e-3, 1e-3, 1e-3), position=place, velocity=side, shape=shapes.Sphere(0.12 * l))
    return System([bob], [Distance(GROUND, bob, at_a=(0, 0, 0), at_b=place, name="rod")], gravity=(0, 0, -G))


def theory(*, l, theta_deg, phi_rate):
    """Integrate u'^2 = 2 (E + g l u)(1 - u^2)/l^2 - h^2/l^4, u = cos theta; phi' = h/(l^2 (1 - u^2)): quadratures in d
    = 1 - u.
    """
    start = 1 - np.cos(np.radians(theta_deg))
    momentum, rate = phi_rate * start * (2 - start), G / l  # h/l^2
    energy = 0.5 * phi_rate * momentum - rate * (1 - start)  # E/l^2
    # u'^2 is 2 g/l (d - start)(other - d)(third - d), whose last two roots solve d^2 - total d + product = 0
    total, product = 3 + energy / rate - start, momentum**2 / (2 * rate * start)
    third = 0.5 * total + np.sqrt(0.25 * total**2 - product)
    low, high = sorted((start, product / third))
    require(momentum != 0 and high - low > 1e-6, "demo 'spherical_pendulum': a plane swing, or a circle without "
            "turning "
            "points; give another phi_rate")  # fmt: skip

    def square(d):
        return 2 * rate * (d - low) * (high - d) * (third - d)

    time, turn = swing(square, low, high, lambda d: abs(momentum) / (d * (2 - d)))
    return {"half_nutation_s": time, "apsidal_angle_deg": np.degrees(turn)}


def measure(build, terms, *, l, theta_deg, phi_rate) -> Measured:
    """Measure from the start, where the height is greatest or least, to where it is least or greatest."""
    system = build()
    rises = phi_rate**2 * l * np.cos(np.radians(theta_deg)) > G
    height = measures.velocity(system.bodies[0], axis=(0, 0, 1))
    half = next_turn(system, height, np.sqrt(l / G), rising=bool(rises), **terms)
    run = simulate(system, 10 * half.t[-1], rtol=1e-12, output=801, **terms)
    x, y, z = run.position("bob").T
    path = simulate(system, half.t[-1], rtol=1e-12, output=101, **terms).position("bob")
    turn = abs(np.ptp(np.unwrap(np.arctan2(path[:, 1], path[:, 0]))))
    steps, sign = np.arange(11), np.sign(phi_rate)
    angles = np.radians(build.theory["apsidal_angle_deg"]) * steps * sign
    ends = half.position("bob")[:, :2]
    reach = np.where(steps % 2, *np.linalg.norm(ends, axis=1)[::-1])
    apses = (reach * np.cos(angles), reach * np.sin(angles))
    seen = Curve("y [m]", x, y, apses, "x [m]", "from above; theory: the apses", equal=True)
    values = {"half_nutation_s": half.t[-1], "apsidal_angle_deg": np.degrees(turn)}
    return Measured(values, [run], [seen, Curve("height [m]", run.t, z)])


demo = Demo(
    __name__,
    title="The ellipse that turns",
    question="Why does a pendulum's ellipse slowly turn?",
    beats=(
        Beat(0.0, "Farthest out."),
        Beat(0.5392, "Nearest. In a plane ellipse this would be 90 degrees on: it is 105."),
        Beat(1.0785, "Farthest again, past where it began by 29 degrees."),
    ),
    why="For small swings a pendulum has the same period in all directions, and its path closes. Wide swings are "
    "slower, so between its greatest and its least distance the bob goes round by more than a quarter turn "
    "(always by more: Puiseux). What has not come round after one swing is added at the next, and the ellipse "
    "becomes a rosette.",
    equation="u'^2 = 2 (E + g l u)(1 - u^2)/l^2 - h^2/l^4; phi' = h/(l^2 (1 - u^2)); u = cos theta",
    symbols={
        "u": Symbol("cosine of the angle; the height of the bob is -l u", "m", curve=(0, 2)),
        "theta": Symbol("angle at the start", "deg", "theta_deg"),
        "phi": Symbol("direction from above; its rate at the start", "rad/s", "phi_rate"),
        "l": Symbol("length", "m", "l"),
        "g": GRAVITY,
        "h": Symbol(
            "twice the area swept each second",
            "m^2/s",
            lambda l, theta_deg, phi_rate: l**2 * float(np.sin(np.radians(theta_deg))) ** 2 * phi_rate,
        ),
        "E": Symbol("energy per kilogram", "m^2/s^2"),
    },
    source="Whittaker, Analytical Dynamics, par. 55; Landau, Lifshitz, Mechanics, par. 14",
    quantities={
        "half_nutation_s": Quantity("time from the farthest to the nearest place", "s"),
        "apsidal_angle_deg": Quantity("angle between them", "deg"),
    },
    ablation=Ablation(
        "sideways", "a small push sideways leaves the quarter turn of a plane swing", {"phi_rate": 0.01}
    ),  # fmt: skip
    against=Against("theta_deg", 5.0, 60.0, "angle at the start [deg]"),
    show={"curves": [("position", "bob")], "traces": [("bob", (0.866, 0, -0.5))]},
    sliders=(
        Control("theta_deg", 10.0, 80.0, "deg", "angle at the start"),
        Control("phi_rate", 0.5, 3.0, "rad/s", "push sideways"),
    ),
    readings={"half_nutation_s": ("turning", 0, 2)},
    attempt="start at 10 degrees: the ellipse nearly closes. Start at 80, and it turns by a fifth with every swing.",
)
