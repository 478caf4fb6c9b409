"""Between two speeds a bicycle rides itself: below it weaves, above it slowly capsizes."""

from dataclasses import replace
from functools import cache

import numpy as np
from scipy.optimize import brentq

from mbsd3d import Linearization, System, linearize, measures, simulate
from mbsd3d.extend import Ablation, Beat, Curve, Demo, Measured, Quantity, Ride, Symbol, moments

from ..linear.critical import critical_speeds
from ..linear.equations import canonical
from ..model.mechanism import outputs, steer_torque, whipple
from ..parameters import Meijaard2007

SEARCH_SPEEDS = np.arange(1.0, 16.1)  # [m/s] in which the critical speeds are sought
PUSH = 0.3  # [rad/s] of lean, after which it is seen
RIDE_TORQUE = 2.0  # [N m] at the handlebar, of a reader who rides
SYMBOLS = {  # of the equations of lean and steer
    "q": Symbol("lean and steer; the steer", "rad", curve=(0, 0)),
    "M": Symbol("masses"),
    "C_1": Symbol("what grows with the speed"),
    "K_0": Symbol("what the weight does"),
    "K_2": Symbol("what grows with the square of the speed"),
    "v": Symbol("speed", "m/s", "v"),
    "g": Symbol("weight of a kilogram", "N/kg", lambda: 9.81),
}
FALL_LEAN = 0.9  # [rad] of lean, at which the animation ends


def bicycle(spin):
    """Return the benchmark with the moments of its wheels about their axles multiplied by a factor."""
    found = Meijaard2007()
    return replace(found, IRyy=spin * found.IRyy, IFyy=spin * found.IFyy)


def mechanism(*, v=5.0, spin=1.0, push=0.0) -> System:
    """Build the bicycle of the benchmark, straight on at v [m/s]; spin 0: wheels without moment about their axles."""
    return whipple(bicycle(spin), speed=v, lean_rate=push)


def film(build) -> System:
    """Build what is seen: the bicycle after a push."""
    return build(push=PUSH)


def ride(*, v, spin) -> Ride:
    """Build what a reader rides: his hands push the handlebar, or let go of it."""
    parameters = bicycle(spin)
    system = whipple(parameters, speed=v)
    pushed = replace(system, forces=steer_torque(system, parameters, RIDE_TORQUE))
    return Ride(pushed, "Push the handlebar left or right, and let go: it rides itself.", "frame")


def theory(*, v, spin):
    """Solve M q'' + v C1 q' + (g K0 + v^2 K2) q = 0 of the benchmark: its eigenvalues at v and its critical speeds."""
    critical, weave = critical_speeds(bicycle(spin)), weave_of(canonical(bicycle(spin)).eigenvalues([v])[0])
    speeds = (x if np.isfinite(x) and x > 0 else np.inf for x in (critical.weave, critical.capsize))
    names = ("weave_speed_m_s", "capsize_speed_m_s", "weave_damping_1_s", "weave_rad_s")
    return dict(zip(names, (*speeds, weave.real, weave.imag), strict=True))


def weave_of(values):
    """Return the oscillating eigenvalue [1/s]."""
    return values[np.argmax(values.imag)]


def capsize_of(values):
    """Return the greatest real eigenvalue [1/s]."""
    return max(values[abs(values.imag) < 1e-9].real, default=np.nan)


def small_motions(system: System, terms) -> Linearization:
    """Linearize the motion in lean and steer."""
    return linearize(system, outputs=outputs(system), **terms)


def first_zero(function):
    """Return the first speed at which a rate changes its sign [m/s]; infinite if none does."""
    found = [function(v) for v in SEARCH_SPEEDS]
    for k in range(len(SEARCH_SPEEDS) - 1):
        if found[k] * found[k + 1] < 0:
            return brentq(function, SEARCH_SPEEDS[k], SEARCH_SPEEDS[k + 1], xtol=1e-13)
    return np.inf


def measure(build, terms, *, v, spin) -> Measured:
    """Measure eigenvalues of the general model, and the speeds at which they cross zero."""

    @cache
    def values(speed):
        return small_motions(build(v=speed), terms).eigenvalues

    weave = weave_of(values(v))
    found = {
        "weave_speed_m_s": first_zero(lambda speed: weave_of(values(speed)).real),
        "capsize_speed_m_s": first_zero(lambda speed: capsize_of(values(speed))),
        "weave_damping_1_s": weave.real,
        "weave_rad_s": weave.imag,
    }
    growth = [values(speed).real.max() for speed in SEARCH_SPEEDS]
    known = canonical(bicycle(spin)).eigenvalues(SEARCH_SPEEDS).real.max(axis=1)
    pushed = build(push=PUSH)
    fallen = measures.lean(pushed.part("frame")) > FALL_LEAN
    run = simulate(pushed, 3.0, rtol=1e-9, output=321, stop_when=fallen, **terms)
    curve = Curve(
        "fastest growth [1/s]", SEARCH_SPEEDS, growth, (SEARCH_SPEEDS, known), "speed [m/s]", "below 0 it rides itself"
    )
    lean = Curve("steer after a push [deg]", run.t, np.degrees(run.angle("steer")))
    return Measured(found, [run], [curve, lean])


demo = Demo(
    __name__,
    title="No hands",
    question="Between which speeds does a bicycle ride itself?",
    beats=(
        Beat(0.0, "A push from the side, and nobody holds on."),
        Beat(0.25, "It steers into the fall ..."),
        Beat(moments.share(1.0), "... and is upright again: at 5 m/s it rides itself."),
    ),
    why="A falling bicycle turns its front wheel into the fall: by the weight on the front part, by trail, and "
    "because the leaning front wheel is a gyroscope. On the curve it then rides it rights itself. If it is too "
    "slow this comes too late and it weaves, if it is too fast the steering is too calm and it slowly capsizes. "
    "In between it needs nobody. The command mbsd3d bicycle has more of this.",
    equation="M q'' + v C_1 q' + (g K_0 + v^2 K_2) q = 0; q = (lean, steer)",
    symbols=SYMBOLS,
    source="Meijaard, Papadopoulos, Ruina, Schwab, Proc. R. Soc. A 463 (2007) 1955 (benchmark)",
    quantities={
        "weave_speed_m_s": Quantity("speed from which it does not weave", "m/s"),
        "capsize_speed_m_s": Quantity("speed up to which it does not capsize", "m/s"),
        "weave_damping_1_s": Quantity("growth of the weave", "1/s"),
        "weave_rad_s": Quantity("rate of the weave", "rad/s"),
    },
    ablation=Ablation(
        "spin", "with wheels that have no moment about their axles it rides itself at no speed", {"spin": 0.0}
    ),
    show={"curves": [("angle", "steer"), ("omega", "frame")], "follow": "frame", "traces": []},
    ranges={"v": (4.5, 7.0), "spin": (0.7, 1.0), "push": None},
    sliders=(
        ("v", 3.8, 8.0, "m/s", "speed"),
        ("spin", 0.5, 1.0, "", "moment of the wheels"),
    ),
    attempt="ride slower than 4.3 m/s: it weaves more and more. In between it calms down by itself.",
)
