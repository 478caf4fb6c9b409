"""A wheel inside a satellite makes the axis stable that no free body can spin about."""

import numpy as np

from mbsd3d import GROUND, Body, Revolute, Spherical, State, System, accelerations, shapes, simulate

from ..form import Ablation, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share

KICK = 1e-3  # [1] of the turn


def mechanism(*, I=(30.0, 50.0, 40.0), w=0.5, J=0.2, Omega=60.0) -> System:
    """Build a body I [kg m^2] turning at w about its middle axis z, wheel (J/2, J/2, J) in it at Omega more; centre
    fixed.
    """
    body = Body("satellite", 20.0, I, omega=(0, 0, w), shape=shapes.Box((1.2, 0.4, 0.9)))
    form = shapes.Disc(0.35, 0.1, "z", at=(0, 0, 0.55))
    wheel = Body("wheel", 1.0, (J / 2, J / 2, J), omega=(0, 0, w + Omega), shape=form)
    joints = [
        Spherical(GROUND, body, at=(0, 0, 0), name="centre"),
        Revolute(body, wheel, at=(0, 0, 0), axis=(0, 0, 1), name="bearing"),
    ]
    return System([body, wheel], joints, gravity=(0, 0, 0))


def kicked(system, w) -> State:
    """Return the start with a thousandth of the turn about the first axis besides."""
    start = system.state()
    return State(start.t, start.q, start.v + KICK * w * (np.eye(12)[3] + np.eye(12)[9]))


def film(build, *, w) -> tuple[System, State]:
    """Build what is seen: the start after a kick."""
    system = build()
    return system, kicked(system, w)


def square(I, w, J, Omega):
    """Return lambda^2 of the small motions of a gyrostat: -(h + (C - A) w)(h + (C - B) w) / (A B), h = J Omega."""
    a, b, c = I[0] + J / 2, I[1] + J / 2, I[2] + J
    h = J * Omega
    return -(h + (c - a) * w) * (h + (c - b) * w) / (a * b)


def theory(*, I, w, J, Omega):
    """Return growth with the wheel at rest in the body, nutation with the wheel on; zero where there is none."""
    require(w != 0 and J > 0, f"demo 'dual_spin': w = {w:g}, J = {J:g}: give a turn and a wheel")
    off, on = square(I, w, J, 0.0), square(I, w, J, Omega)
    return {"growth_wheel_off_1_s": np.sqrt(max(off, 0.0)), "nutation_wheel_on_rad_s": np.sqrt(max(-on, 0.0))}


def measure(build, terms, *, I, w, J, Omega) -> Measured:
    """Measure eigenvalues of the small motions."""
    values = {rate: small(build(Omega=rate), terms) for rate in {0.0, Omega}}
    calm = abs(I[1] - I[2]) * w / J  # speed of the wheel from which nothing grows
    rates = np.linspace(0, 3 * calm, 25)
    growth = [small(build(Omega=rate), terms)[0] for rate in rates]
    known = [np.sqrt(max(square(I, w, J, rate), 0.0)) for rate in rates]
    map_of = Curve(
        "growth [1/s]", rates, growth, (rates, known), "speed of the wheel [rad/s]", "calm from some speed on"
    )
    on = values[Omega][1]
    system = build()
    run = simulate(system, 40.0 / abs(w), state=kicked(system, w), rtol=1e-10, output=401, **terms)
    spin = Curve("rate about the wheel's axis [rad/s]", run.t, run.omega_body("satellite")[:, 2])
    return Measured({"growth_wheel_off_1_s": values[0.0][0], "nutation_wheel_on_rad_s": on}, [run], [map_of, spin])


def small(system, terms):
    """Return (growth, nutation) of the rates across the axis in body axes, where the rotation itself is no motion.

    The moments of a gyrostat are quadratic in the rates, so that their central differences are exact.
    """
    start, tilts = system.state(), np.eye(12)[[3, 4]] + np.eye(12)[[9, 10]]

    def rate(change):
        state = State(start.t, start.q, start.v + change)
        return accelerations(system, state, **terms).alpha("satellite")[0, :2]

    s = np.linalg.eigvals([rate(tilt) - rate(-tilt) for tilt in tilts]) / 2.0
    return max(s.real.max(), 0.0), s.imag.max()


demo = Demo(
    __name__,
    title="A wheel calms the forbidden axis",
    question="Can a wheel inside make the forbidden axis stable?",
    beats=(
        Beat(0.0, "It turns about its middle axis, which throws every body over ..."),
        Beat(share(0.5), "... but for the wheel that spins inside."),
        Beat(share(1.0), "After 80 s its axis still stands."),
    ),
    why="A free body cannot spin about its middle axis: the smallest error grows until it turns over. A wheel that "
    "spins along that axis adds angular momentum without adding inertia, so that the axis behaves as if its "
    "moment were the greatest. This keeps television satellites steady while their aerial, "
    "turning once a day, points down.",
    equation="lambda^2 = -(h + (C - A) w)(h + (C - B) w) / (A B); h = J W",
    symbols={
        "w": Symbol("spin about the middle axis", "rad/s", curve=(0, 2)),
        "A": Symbol("one moment across", "kg m^2", lambda I, J: I[0] + J / 2),
        "B": Symbol("the other one", "kg m^2", lambda I, J: I[1] + J / 2),
        "C": Symbol("moment about the middle axis", "kg m^2", lambda I, J: I[2] + J),
        "h": Symbol("angular momentum of the wheel", "N m s", lambda J, Omega: J * Omega),
        "J": Symbol("moment of the wheel", "kg m^2", "J"),
        "W": Symbol("spin of the wheel", "rad/s", "Omega"),
        "lambda": Symbol("growth of an error", "1/s"),
    },
    source="Hughes, Spacecraft Attitude Dynamics, ch. 6 (gyrostats)",
    quantities={
        "growth_wheel_off_1_s": Quantity("growth of an error, wheel off", "1/s"),
        "nutation_wheel_on_rad_s": Quantity("rate of the wobble, wheel on", "rad/s"),
    },
    ablation=Ablation("wheel", "with the wheel at rest errors grow and nothing wobbles", {"Omega": 0.0}),
    show={"curves": [("omega_body", "satellite")]},
    ranges={"I": [(28.0, 32.0), (48.0, 55.0), (38.0, 43.0)], "w": (0.3, 0.7)},
    sliders=(Control("Omega", 0.0, 90.0, "rad/s", "speed of the wheel"),),
    attempt="slow the wheel down: below 25 rad/s the satellite turns over.",
)
