"""Double lane change: a driver steers at a point that runs ahead of him on the course."""

import numpy as np
from scipy.interpolate import CubicSpline

from mbsd3d import Pulse, System, linearize, measures, simulate

from ..figure import Line
from ..form import Ablation, Beat, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import first, most
from .car import SHOW_OPTIONS, WHEELS, Car
from .driver import closed, followed
from .linear import Y

APPROACH_LENGTH, LANE_LENGTHS = 45.0, (30.0, 25.0, 25.0)  # m before it, over, in the other lane, and back
SMALL_WIDTH, TIGHT_RTOL = 1e-4, 1e-12  # m of course: what is of second order has no say; tolerance of the run
SAMPLES = 601
SPEED_RATIO = 1.4  # [1] of the second run over the first
TURNED_AWAY_RATIO = 0.7  # [1] distance of the point ahead, over the first one, of a car that has turned away


def course_of(width, v, preview):
    """Return (position of the point to the left, over time; its times of change)."""
    start = APPROACH_LENGTH / v - preview
    rise, stay, fall = (x / v for x in LANE_LENGTHS)
    breaks = [start, start + rise, start + rise + stay, start + rise + stay + fall]
    step = Pulse(width, start=start, edge=rise)
    return step - Pulse(width, start=breaks[2], edge=fall), breaks


def mechanism(*, ms=1400.0, h=0.55, a=1.2, b=1.5, v=22.0, width=3.5, preview=0.5, lag=0.05) -> System:
    """Build the car at v, a course to the left by width [m]; the driver sees ``preview`` [s] ahead and lags by ``lag``
    [s].
    """
    require(v > 0.0 and preview > 0.0, f"demo 'double_lane_change': v = {v:g} m/s, preview = {preview:g} s; give > 0")
    require(
        preview * v < APPROACH_LENGTH,
        f"demo 'double_lane_change': the point starts on the course; give preview < {APPROACH_LENGTH / v:g} s",
    )
    return followed(Car(ms=ms, h=h, a=a, b=b), v, course_of(width, v, preview)[0], preview, lag)


def highest(t, x):
    """Return the largest value of a curve, between its samples too."""
    curve = CubicSpline(t, x)
    return float(curve(curve.derivative().roots(extrapolate=False)).max())


def features(t, y, slow):
    """Return the farthest positions to the left and then to the right, per width, and the slowest mode of car and
    driver.
    """
    left = int(np.argmax(y))
    return {
        "left_share": highest(t, y),
        "right_share": highest(t[left:], -y[left:]),
        "damping_1_s": float(-slow.real),
        "frequency_rad_s": float(abs(slow.imag)),
    }


def by_hand(c, v, preview, lag, t):
    """Return (path to the left per width, slowest eigenvalue) of `closed`."""
    small, (course, breaks) = closed(c, v, preview, lag), course_of(SMALL_WIDTH, v, preview)
    s = np.linalg.eigvals(small.A)
    return small.respond(course, t, breaks)[0][:, Y] / SMALL_WIDTH, s[np.argmin(np.abs(s))]


def times_of(v):
    """Return sample times over the course and 40 m beyond [s]."""
    return np.linspace(0.0, (APPROACH_LENGTH + sum(LANE_LENGTHS) + 40.0) / v, SAMPLES)


def theory(*, ms, h, a, b, v, preview, lag):
    """Return the features of the small motions of `closed`."""
    t = times_of(v)
    return features(t, *by_hand(Car(ms=ms, h=h, a=a, b=b), v, preview, lag, t))


def slowest(found):
    """Return the eigenvalue of the slowest mode with lateral motion of the car."""
    aside = [mode.eigenvalue for mode in found.modes if abs(mode.translation[0, 1]) > abs(mode.translation[0, 0])]
    return min((s for s in aside if s != 0.0), key=abs)


def measure(build, terms, *, ms, h, a, b, v, preview, lag, width) -> Measured:
    """Measure a very narrow course, its small motions, the given course, and the same course faster."""

    def driven(v, **changes):
        system = build(v=v, **changes)
        turned = (
            measures.offset(system.part("chassis"), system.part("point"), along=(1, 0, 0))
            < TURNED_AWAY_RATIO * preview * v
        )
        return simulate(system, times_of(v)[-1], output=times_of(v), rtol=1e-6, stop_when=turned, **terms)

    t = times_of(v)
    small = simulate(build(width=SMALL_WIDTH), t[-1], output=t, rtol=TIGHT_RTOL, **terms)
    y = small.position("chassis")[:, 1] / SMALL_WIDTH
    values = features(t, y, slowest(linearize(build(width=0.0), **terms)))
    known = by_hand(Car(ms=ms, h=h, a=a, b=b), v, preview, lag, t)[0]
    runs = {speed: driven(speed) for speed in (v, SPEED_RATIO * v)}
    notes = [said(run, speed, preview, width) for speed, run in runs.items()]
    return Measured(values, [*runs.values()], curves(t, y, known, runs, preview, width), notes=notes)


def ways(run):
    """Return the positions (n,) ahead and (n,) to the left [m]."""
    return run.position("chassis")[:, :2].T


def said(run, v, preview, width):
    """Return in a line how near the car stays to the course, or when it spins."""
    x, y = ways(run)
    away = np.abs(y - course_of(width, v, preview)[0](x / v - preview)).max()
    used = np.array([run.force(f"{name} tyre").saturation for name in WHEELS]).max()
    end = f"and turns away after {x[-1]:.0f} m" if run.certificate.stopped_by else "and comes to the end"
    return f"at {v:.3g} m/s: up to {away:.2f} m off the course, {100.0 * used:.0f} % of the grip of a tyre, {end}"


def curves(t, y, known, runs, preview, width):
    """Draw the narrow course, the wide one at both speeds, and how the driver steers."""
    (v, run), (fast, other) = runs.items()
    x = ways(run)[0]
    course = course_of(width, v, preview)[0](x / v - preview)
    steer = {speed: np.degrees(one.angle("front left slide")) for speed, one in runs.items()}
    name, second = (f"{speed:.3g} m/s" for speed in runs)
    return [
        Curve("way to the left over the width, narrow [-]", v * t, y, (v * t, known), "way ahead [m]", name=name),
        Curve(
            "way to the left [m]", x, ways(run)[1], along="way ahead [m]", name=name,
            more=[Line(second, *ways(other)[::-1]), Line("course", course)],
        ),
        Curve(
            "steer [deg]", x, steer[v], along="way ahead [m]", name=name,
            more=[Line(second, steer[fast], ways(other)[0])],
        ),
    ]  # fmt: skip


demo = Demo(
    __name__,
    title="A double lane change",
    question="How does a driver bring a car into the other lane and back, and why does he lose it a little faster?",
    beats=(
        Beat(0.0, "The driver looks ahead to the point that he follows."),
        Beat(first(lambda run: run.com('chassis')[:, 1] > 1.75), "Out into the other lane ..."),
        Beat(most(lambda run: run.com('chassis')[:, 1]), "... and beyond it ..."),
        Beat(most(lambda run: -run.com('chassis')[:, 1]), "... and back, past the first one: the tail has swung."),
    ),
    why="He looks at a point of the course ahead and steers the circle that leads through it; that is all he needs. "
    "But his hands lag behind his eyes, and a fast car lags behind its steer, so that it swings about the course, "
    "ever more weakly damped the faster it is. On the way back the tyres are asked for more than they have, the "
    "tail comes round, and steering at the point no longer helps.",
    equation="steer = 2 (L + K v^2) e/s^2",
    symbols={
        "e": Symbol("how far the point looked at lies beside", "m"),
        "s": Symbol("how far ahead it lies", "m", lambda v, preview: v * preview),
        "L": Symbol("wheelbase", "m", lambda a, b: a + b),
        "K": Symbol("understeer", "rad s^2/m"),
        "v": Symbol("speed", "m/s", "v"),
    },
    source="ISO 3888-1 (double lane change); Milliken, Milliken, Race Car Vehicle Dynamics",
    quantities={
        "left_share": Quantity("farthest to the left, over the width", "", relative=1e-5),
        "right_share": Quantity("farthest to the right afterwards, over the width", "", relative=1e-4),
        "damping_1_s": Quantity("damping of the slowest swing of car and driver", "1/s", relative=1e-7),
        "frequency_rad_s": Quantity("its frequency", "rad/s", relative=1e-7),
    },
    ablation=Ablation("haste", "a driver who looks 0.9 s ahead swings half as far", {"preview": 0.9}),
    alone="MuJoCo has no such tyre, and Exudyn no bar between two wheels",
    show={
        **SHOW_OPTIONS,
        "curves": [("angle", "front left slide"), ("force", "front right tyre")],
        "traces": ["chassis", "point"],
    },
    ranges={"a": (1.1, 1.2), "v": (19.0, 24.0), "preview": (0.48, 0.6)},
)  # fmt: skip
