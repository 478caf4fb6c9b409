"""A fast top stands upright (a sleeping top); below a certain spin it falls."""

import numpy as np
from scipy.optimize import brentq

from mbsd3d import GROUND, Body, Spherical, State, System, linearize, shapes, simulate

from ..form import GRAVITY, Ablation, Beat, Control, Curve, Demo, Measured, Quantity, Symbol
from ..moments import share

G = 9.81  # m/s^2


def mechanism(*, m=0.5, It=0.0008, I3=0.0006, l=0.05, spin=60.0) -> System:
    """Build an upright top of mass m [kg], moments (It, It, I3) [kg m^2] about G, G at l [m] over the pivot, spin
    [rad/s].
    """
    form = (shapes.Disc(0.8 * l, 0.25 * l), shapes.Cylinder(0.06 * l, 2 * l, at=(0, 0, 0)))
    top = Body("top", m, (It, It, I3), position=(0, 0, l), omega=(0, 0, spin), shape=form)
    return System([top], [Spherical(GROUND, top, at=(0, 0, 0), name="pivot")], gravity=(0, 0, -G))


def nudged(system, l, nudge) -> State:
    """Return the start with a rate of falling over besides [rad/s]."""
    start = system.state()
    return State(0.0, start.q, start.v + nudge * np.array([0, l, 0, -1, 0, 0]))


def film(build, *, l, nudge) -> tuple[System, State]:
    """Build what is seen: the top after a nudge."""
    system = build()
    return system, nudged(system, l, nudge)


def theory(*, m, It, I3, l, spin):
    """Return w_c = 2 sqrt(A m g l)/C, and below it the growth sqrt(4 A m g l - C^2 w^2)/(2 A), A about the pivot."""
    A, weight = It + m * l**2, m * G * l
    square = 4 * A * weight - (I3 * spin) ** 2
    return {"critical_spin_rad_s": 2 * np.sqrt(A * weight) / I3, "growth_1_s": np.sqrt(max(square, 0)) / (2 * A)}


def without_gyroscopic(*, m, It, l, spin):
    """Return the values without w x I w: only I dw/dt of the turning axis is left, as if C of the top were It."""
    return theory(m=m, It=It, I3=It, l=l, spin=spin)


def split(system, terms):
    """Return ((lambda_1 - lambda_2)/2)^2 of nutation and precession, positive for an unstable top, negative for a
    stable one.
    """
    found = linearize(system, **terms).eigenvalues
    pair = sorted(found[found.imag > 0], key=abs)[-2:]
    return ((pair[0] - pair[1]) ** 2).real / 4 if len(pair) == 2 else found.real.max() ** 2


def measure(build, terms, *, l, spin, nudge=0.05) -> Measured:
    """Measure eigenvalues of the upright top, and the spin at which two of them meet."""
    low, high = 0.0, max(abs(spin), 1.0)
    while split(build(spin=high), terms) > 0:
        low, high = high, 2 * high
    critical = brentq(lambda w: split(build(spin=w), terms), low, high, xtol=1e-12)
    growth = max(linearize(build(), **terms).eigenvalues.real.max(), 0.0)
    system = build()
    run = simulate(system, 12 * np.sqrt(l / G), state=nudged(system, l, nudge), rtol=1e-10, output=401, **terms)
    lean = np.degrees(np.arccos(np.clip(run.rotation("top")[:, 2, 2], -1, 1)))
    spins = critical * np.sqrt(np.linspace(0.3, 1.7, 15))  # with the one where growth ends
    grown = [max(linearize(build(spin=w), **terms).eigenvalues.real.max(), 0.0) for w in spins]
    known = [build.demo.call(theory, {**build.values, "spin": w})["growth_1_s"] for w in spins]
    curves = [
        Curve("growth [1/s]", spins, grown, (spins, known), "spin [rad/s]"),
        Curve("lean after a nudge [deg]", run.t, lean),
    ]
    return Measured({"critical_spin_rad_s": critical, "growth_1_s": growth}, [run], curves)


demo = Demo(
    __name__,
    title="The sleeping top",
    question="Why does a fast top stand as if asleep, and at which speed does it wake?",
    beats=(
        Beat(0.0, "Upright at 60 rad/s, and nudged."),
        Beat(share(1.0), "Too slow to sleep: its lean grows. From 75 rad/s on it would stand."),
    ),
    why="Upright, the weight pulls a leaning top away from the vertical. A spinning top answers to this moment at "
    "right angles: it circles instead of falling. Two motions are possible, a quick nutation and a slow "
    "precession; as the spin slows down their rates come together, and where they meet the top wakes: its lean "
    "grows.",
    equation="w_c = 2 sqrt(A m g l) / C; below: growth = sqrt(4 A m g l - C^2 w^2) / (2 A)",
    symbols={
        "w_c": Symbol("spin at which it wakes", "rad/s"),
        "w": Symbol("spin", "rad/s", "spin", arrow="angular momentum"),
        "A": Symbol("moment across, at the pivot", "kg m^2", lambda m, l, It: It + m * l**2),
        "C": Symbol("moment along the axis", "kg m^2", "I3"),
        "m": Symbol("top", "kg", "m"),
        "g": GRAVITY,
        "l": Symbol("from the pivot to the centre of mass", "m", "l"),
    },
    source="Goldstein, Classical Mechanics, 5.7; Klein, Sommerfeld, Theory of the Top",
    quantities={
        "critical_spin_rad_s": Quantity("spin at which it wakes", "rad/s"),
        "growth_1_s": Quantity("growth of the lean", "1/s"),
    },
    ablation=Ablation(
        "gyroscopic", "the top behaves as if its moment about the axis were that across it", values=without_gyroscopic
    ),
    show={"curves": [("com", "top"), ("omega_body", "top")], "shown": ["angular momentum"]},
    sliders=(
        Control("spin", 40.0, 120.0, "rad/s"),
        Control("nudge", 0.01, 0.2, "rad/s"),
    ),
    attempt="spin it faster than 75 rad/s: it sleeps, whatever the nudge. Slower, and the smallest nudge wakes it.",
)
