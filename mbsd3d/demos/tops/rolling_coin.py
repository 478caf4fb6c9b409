"""A coin rolls upright from a certain speed on."""

import numpy as np
from scipy.optimize import brentq

from mbsd3d import GROUND, Body, RollingDisc, State, System, linearize, measures, shapes, simulate

from ..form import GRAVITY, Ablation, Beat, Control, Curve, Demo, Measured, Quantity, Symbol
from ..moments import share

G = 9.81  # m/s^2
LYING_HEIGHT = 0.1  # [1] of the radius: a coin whose middle is lower lies, and its edge has no point of contact


def mechanism(*, m=0.01, a=0.012, I1=3.6e-7, I3=7.2e-7, v=0.15) -> System:
    """Build a coin of radius a [m] and moments (I1, I3, I1) [kg m^2] rolling along x at v [m/s], its axis along y."""
    form = shapes.Disc(a, 0.15 * a, "y")
    coin = Body("coin", m, (I1, I3, I1), position=(0, 0, a), velocity=(v, 0, 0), omega=(0, v / a, 0), shape=form)
    return System([coin], [RollingDisc(GROUND, coin, axis=(0, 1, 0), radius=a, name="edge")], gravity=(0, 0, -G))


def nudged(system, a, nudge) -> State:
    """Return the start with a rate of falling over besides [rad/s]."""
    start = system.state()
    return State(0.0, start.q, start.v + nudge * np.array([0, -a, 0, 1, 0, 0]))


def film(build, *, a, nudge) -> tuple[System, State]:
    """Build what is seen: the coin after a nudge."""
    system = build()
    return system, nudged(system, a, nudge)


def square(m, a, I1, I3, v):
    """Return lambda^2 of the lean: (I1 + m a^2) f'' = (m g a - (I3 + m a^2) I3 (v/a)^2 / I1) f."""
    return (m * G * a - (I3 + m * a**2) * I3 * (v / a) ** 2 / I1) / (I1 + m * a**2)


def theory(*, m, a, I1, I3, v):
    """Return v_c^2 = m g a^3 I1/(I3 (I3 + m a^2)), for a thin disc g a/3, and the growth below it."""
    critical = np.sqrt(m * G * a**3 * I1 / (I3 * (I3 + m * a**2)))
    return {"critical_speed_m_s": critical, "growth_1_s": np.sqrt(max(square(m, a, I1, I3, v), 0.0))}


def found_square(system, terms):
    """Return lambda^2 of the only motion that is not neutral [1/s^2]."""
    found = linearize(system, **terms).eigenvalues
    return (found[np.argmax(abs(found))] ** 2).real


def measure(build, terms, *, a, v, nudge=0.01) -> Measured:
    """Measure eigenvalues of straight rolling, and the speed at which the growing one vanishes."""
    low, high = 0.0, max(abs(v), 1e-3)
    while found_square(build(v=high), terms) > 0:
        low, high = high, 2 * high
    critical = brentq(lambda speed: found_square(build(v=speed), terms), low, high, xtol=1e-14)
    growth = np.sqrt(max(found_square(build(), terms), 0.0))
    system = build()
    down, start = measures.position(system.bodies[0], axis=(0, 0, 1)) < LYING_HEIGHT * a, nudged(system, a, nudge)
    run = simulate(system, 12 * np.sqrt(a / G), state=start, rtol=1e-10, output=401, stop_when=down, **terms)
    speeds = critical * np.sqrt(np.linspace(0.1, 2.0, 20))  # with the one where growth ends
    grown = [np.sqrt(max(found_square(build(v=speed), terms), 0.0)) for speed in speeds]
    known = [build.demo.call(theory, {**build.values, "v": speed})["growth_1_s"] for speed in speeds]
    lean = np.degrees(np.arcsin(np.clip(run.rotation("coin")[:, 2, 1], -1, 1)))
    curves = [Curve("growth [1/s]", speeds, grown, (speeds, known), "speed [m/s]"), Curve("lean [deg]", run.t, lean)]
    return Measured({"critical_speed_m_s": critical, "growth_1_s": growth}, [run], curves)


demo = Demo(
    __name__,
    title="The coin that does not fall",
    question="From which speed does a coin roll on its edge without falling?",
    beats=(
        Beat(0.0, "A coin rolls at 0.15 m/s, and is nudged."),
        Beat(share(1.0), "Too slow: the lean grows. From 0.2 m/s on it would right itself."),
    ),
    why="A leaning coin is pulled down by its weight. As it starts to fall, its spin turns it into the fall, and on "
    "the curve that it then rolls the centrifugal force sets it up again. Both parts grow with the square of the "
    "speed, the weight does not: above a certain speed the coin rights itself.",
    equation="v_c^2 = m g a^3 I_1 / (I_3 (I_3 + m a^2)); thin disc: v_c^2 = g a / 3",
    symbols={
        "v_c": Symbol("speed from which it does not fall", "m/s"),
        "m": Symbol("coin", "kg", "m"),
        "g": GRAVITY,
        "a": Symbol("radius", "m", "a"),
        "I_1": Symbol("moment across", "kg m^2", "I1"),
        "I_3": Symbol("moment along the axis", "kg m^2", "I3"),
    },
    source="Neimark, Fufaev, Dynamics of Nonholonomic Systems, ch. VI; Routh, Advanced Rigid Dynamics",
    quantities={
        "critical_speed_m_s": Quantity("speed from which it does not fall", "m/s"),
        "growth_1_s": Quantity("growth of the lean", "1/s"),
    },
    ablation=Ablation("speed", "at rest it falls at once", {"v": 0.0}),
    show={"curves": [("com", "coin")], "speed": 0.1},
    ranges={"I3": (5e-7, 6e-7)},
    sliders=(Control("v", 0.12, 0.4, "m/s", "speed"),),
    attempt="roll it faster than 0.2 m/s: after the same nudge it stays up. Slower, and it is down before the end.",
)
