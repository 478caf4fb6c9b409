"""Tyres as cases: a free wheel against a second formulation, a motorcycle against its published eigenvalues."""

from collections.abc import Iterable
from dataclasses import asdict
from functools import partial

import numpy as np
from scipy.integrate import solve_ivp

from bicycle import named, on_tyres, whipple
from bicycle.parameters import fittings, machines
from mbsd3d import GROUND, Body, System, Tyre, rotation
from validation.suite.findings import REFERENCE, THEORY, Finding, judged
from validation.suite.trials.trial import Run, Trial, run
from validation.theory.free_wheel import Rubber, Wheel, derivative

TYRE = Rubber(
    radius=0.33, crown=0.04, stiffness=4e4, damping=400.0, cornering=12.0, longitudinal=16.0, camber=0.8,
    relaxation=0.13, relaxation_x=0.08, mu=0.7, trail=0.025, twisting=0.004, rolling_resistance=0.006,
    nominal_load=70.0, grip_sensitivity=0.03, stiffness_sensitivity=0.05,
)  # fmt: skip
WHEEL = Wheel(mass=6.0, axial=0.31, diametral=0.17, tyre=TYRE)
T_END, SAMPLES, RTOL = 0.5, 11, 1e-9
DIFFERENCE_MAX = 1e-7  # [1] of the second formulation: a hundred times its tolerance
PRINTED_TOLERANCE = 0.011, 0.05  # [1/s, rad/s] of a table with three digits
SHORT_RUN_REASON = "in a short run tyres are compared with theory and print only"
FOOT_LENGTH = 0.3048  # [m] of a foot


def trials(quick: bool) -> list[Trial]:
    """Return a wheel thrown onto the ground, and the motorcycle of Sharp (1971)."""
    alone = SHORT_RUN_REASON if quick else ""
    return [
        Trial(
            "wheel_on_tyre", "tyres", "thrown: it slides and rolls, leaning", thrown, {THEORY: written_out},
            alone=alone,
        ),
        Trial(
            "motorcycle_sharp_1971", "tyres", "the standard machine, 70 ft/s", partial(motorcycle, 70.0 * FOOT_LENGTH),
            {REFERENCE: printed}, alone=alone,
        ),
    ]  # fmt: skip


def thrown() -> Run:
    """Simulate a leaning wheel that touches down with too little spin."""
    w = WHEEL
    body = Body(
        "wheel", w.mass, (w.diametral, w.axial, w.diametral), position=(0, 0, 0.33), velocity=(4.0, 0.3, -0.2),
        omega=(0.4, 7.0, 0.5), orientation=rotation("x", 0.2),
    )  # fmt: skip
    axle = (0.0, np.cos(0.2), np.sin(0.2))
    tyre = Tyre(GROUND, body, axis=axle, name="tyre", **asdict(w.tyre))
    return run(System([body], forces=[tyre]), T_END, output=SAMPLES)


def written_out(made: Run) -> Iterable[Finding]:
    """Compare position, attitude and deflections with the second formulation, integrated by scipy."""
    found, start = made.motion, made.motion.state(0)
    y = np.concatenate([start.q, start.v, start.z])
    known = solve_ivp(lambda _, y: derivative(WHEEL, y), (0.0, T_END), y, "LSODA", found.t, rtol=RTOL, atol=1e-11).y.T
    yield judged(THEORY, "place [m]", np.abs(found.position("wheel") - known[:, :3]).max(), DIFFERENCE_MAX)
    yield judged(THEORY, "attitude", np.abs(found.orientation("wheel") - known[:, 3:7]).max(), DIFFERENCE_MAX)
    deflections = np.column_stack([*found.force("tyre").states.values()])
    yield judged(THEORY, "deflections", np.abs(deflections - known[:, 13:]).max(), DIFFERENCE_MAX)


def motorcycle(speed: float) -> Run:
    """Simulate the standard machine with a small lean rate."""
    p = named("Sharp1971")
    system = whipple(p, speed, lean_rate=0.05, **fittings(p))
    return run(system, 1.0, state=system.state(), output=SAMPLES, source=p)


def printed(made: Run) -> Iterable[Finding]:
    """Compare the forty published eigenvalues: capsize, weave and wobble at eight speeds."""
    p, away = made.source, np.zeros(2)
    for v, capsize, *pairs in machines()[p.name]["printed"]["rows"]:
        found = on_tyres.eigenvalues(partial(whipple, **fittings(p)), p, [FOOT_LENGTH * v])[0]
        for s in (complex(capsize), complex(*pairs[:2]), complex(*pairs[2:])):
            gap = found[np.argmin(np.abs(found - s))] - s
            away = np.maximum(away, (abs(gap.real), abs(gap.imag)))
    yield judged(REFERENCE, "growth, printed [1/s]", float(away[0]), PRINTED_TOLERANCE[0])
    yield judged(REFERENCE, "frequency, printed [rad/s]", float(away[1]), PRINTED_TOLERANCE[1])
