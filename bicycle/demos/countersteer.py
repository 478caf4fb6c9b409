"""To turn right one must first steer left."""

from dataclasses import replace

import numpy as np
import scipy.linalg

from mbsd3d import System, simulate
from mbsd3d.extend import Ablation, Beat, Curve, Demo, Measured, Quantity, Ride, Symbol, moments, require

from ..linear.equations import canonical
from ..model.mechanism import steer_torque, whipple
from ..parameters import Meijaard2007
from .no_hands import SYMBOLS

RIDE_TORQUE = 2.0  # [N m] at the handlebar, of a reader who rides
SMALL_ANGLE = 1e-5  # [rad] lean and steer of the linear answer; their squares vanish, their rounding is 1e-13


def mechanism(*, v=5.0, torque=1.0) -> System:
    """Build the bicycle of the benchmark at v [m/s], a constant torque [N m] about the steer axis, to the right."""
    parameters = Meijaard2007()
    bicycle = whipple(parameters, speed=v)
    return replace(bicycle, forces=steer_torque(bicycle, parameters, torque))


def ride(*, v) -> Ride:
    """Build what a reader rides: his hands push the handlebar."""
    return Ride(mechanism(v=v, torque=RIDE_TORQUE), "Hold left or right: so you push the handlebar.", "frame")


def answer(times, v):
    """Return lean, steer and their rates to a torque of 1 N m at the handlebar, by the matrix exponential, shape
    (times, 4).
    """
    linear = canonical(Meijaard2007())
    A = np.zeros((5, 5))
    A[:4, :4], A[2:4, 4] = linear.A(v), np.linalg.solve(linear.M, [0.0, 1.0])
    return np.array([(scipy.linalg.expm(A * t) @ np.eye(5)[4])[:4] for t in times])


def theory(*, v, t1, t2):
    """Solve the linear equations of the benchmark: first with the torque, then against it."""
    require(v > 0, f"demo 'countersteer': v = {v:g} m/s; give a speed ahead, v > 0")
    early, late = answer([t1, t2], v)
    return {"early_steer_per_torque": early[1], "late_steer_per_torque": late[1], "late_lean_per_torque": late[0]}


def measure(build, terms, *, v, torque, t1=0.2, t2=2.0) -> Measured:
    """Measure steer and lean of the general model per torque, for a very small one; then the ride with the given
    torque.
    """
    times = np.unique([*np.linspace(0, t2, 201), t1, t2])
    known = answer(times, v)
    small = SMALL_ANGLE / np.abs(known[:, :2]).max()
    system = build(torque=small)
    run = simulate(system, times[-1], rtol=1e-13, output=times, **terms)
    lateral = run.body_axis(system.part("frame"), (0.0, 1.0, 0.0))
    lean, steer = np.arcsin(lateral[:, 2]) / small, run.angle("steer") / small
    early, late = np.searchsorted(times, [t1, t2])
    values = {
        "early_steer_per_torque": steer[early],
        "late_steer_per_torque": steer[late],
        "late_lean_per_torque": lean[late],
    }
    curves = [
        Curve("steer per torque [rad/(N m)]", times, steer, (times, known[:, 1])),
        Curve("lean per torque [rad/(N m)]", times, lean, (times, known[:, 0])),
    ]
    seen = simulate(build(), t2, rtol=1e-9, output=201, **terms)
    return Measured(values, [seen, run], curves)


demo = Demo(
    __name__,
    title="Countersteering",
    question="Why must one steer left to turn right?",
    beats=(
        Beat(0.0, "A push that would turn the bar to the right."),
        Beat(moments.most(lambda run: run.angle("steer")), "It steers right, and the bicycle falls to the left ..."),
        Beat(
            moments.first(lambda run: (run.t > 0.2) & (run.angle("steer") < 0)),
            "... so that it steers left, against the hand ...",
        ),
        Beat(moments.share(1.0), "... and rides a curve to the left."),
    ),
    why="Turning the handlebar to the right moves the wheels out to the right from under the rider, who then falls "
    "to the left, and a bicycle that leans left turns left. So a steady push that would turn the handlebar to "
    "the right first does so, and a moment later the bicycle leans left and steers left, against the hand.",
    equation="M q'' + v C_1 q' + (g K_0 + v^2 K_2) q = (0, T)",
    symbols={
        **SYMBOLS,
        "T": Symbol("torque at the bar", "N m", "torque"),
    },
    source="Meijaard et al., Proc. R. Soc. A 463 (2007) 1955; Limebeer, Sharp, IEEE Control Systems 26 (2006) 34",
    quantities={
        "early_steer_per_torque": Quantity("steer at t1 over torque", "rad/(N m)", relative=1e-6),
        "late_steer_per_torque": Quantity("steer at t2 over torque", "rad/(N m)", relative=1e-6),
        "late_lean_per_torque": Quantity("lean at t2 over torque", "rad/(N m)", relative=1e-6),
    },
    ablation=Ablation(
        "gyroscopic",
        "no moment turns the front wheel into the lean: the handlebar comes back late and swings over much further",
        values=lambda: {},
    ),
    show={"curves": [("angle", "steer"), ("omega", "frame")], "follow": "frame", "traces": []},
    ranges={"v": (4.0, 7.0), "t2": (1.5, 2.2), "torque": (0.5, 1.5)},
    sliders=(
        ("v", 4.0, 7.0, "m/s", "speed"),
        ("torque", -1.5, 1.5, "N m", "at the handlebar"),
    ),
    theory_moves=False,
    attempt="push the other way: all is mirrored. At every speed the bicycle first steers with the hand, and "
    "then against it.",
)
