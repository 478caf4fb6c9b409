"""A telescope that follows a satellite past the zenith must whip round."""

import numpy as np

from mbsd3d import GROUND, AngleDriver, Body, Kinematic, Parallel, Ramp, Revolute, System, shapes, simulate

from ..form import Ablation, Against, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share

SAMPLES = 401  # odd: the culmination is among them


def mechanism(*, w=1.0, miss_deg=2.0) -> System:
    """Build a line of sight led at w [rad/s] on a great circle that misses the zenith; gimbals about z and a level
    axis.
    """
    miss = np.radians(miss_deg)
    normal = (0, -np.cos(miss), np.sin(miss))
    sight = Body("line of sight", 1.0, (1, 1, 1), shape=shapes.Cylinder(0.01, 1.5, "x", at=(0.75, 0, 0)))
    outer = Body("outer gimbal", 1.0, (1, 1, 1), shape=shapes.Torus(0.5, 0.03, "x"))
    form = (shapes.Cylinder(0.12, 0.6, "x", at=(0.1, 0, 0)), shapes.Cylinder(0.03, 1.0, "y"))
    inner = Body("telescope", 1.0, (1, 1, 1), shape=form)
    pass_over = Revolute(GROUND, sight, at=(0, 0, 0), axis=normal, name="pass")
    joints = [
        pass_over,
        AngleDriver(pass_over, Ramp(w), name="satellite"),
        Revolute(GROUND, outer, at=(0, 0, 0), axis=(0, 0, 1), name="azimuth"),
        Revolute(outer, inner, at=(0, 0, 0), axis=(0, -1, 0), name="height"),
        Parallel(sight, inner, axis=(1, 0, 0), name="boresight"),
    ]
    return System([sight, outer, inner], joints, gravity=(0, 0, 0))


def azimuth_rate(angle, w, miss_deg):
    """Return w sin(miss)/(1 - cos^2(miss) sin^2(angle)) for an angle along the pass, counted from the horizon
    [rad/s]."""
    miss = np.radians(miss_deg)
    return w * np.sin(miss) / (1 - np.cos(miss) ** 2 * np.sin(angle) ** 2)


def theory(*, w, miss_deg):
    """Return the rate at the culmination: the line of sight moves at w on a circle of radius sin(miss) about the
    vertical.
    """
    require(0 < miss_deg <= 90, f"demo 'gimbal_lock': miss_deg = {miss_deg:g}; give 0 < miss_deg <= 90: at 0 the "
            "telescope would have to turn by 180 degrees at once")  # fmt: skip
    return {"outer_rate_peak_rad_s": abs(w) / np.sin(np.radians(miss_deg))}


def measure(build, terms, *, w, miss_deg) -> Measured:
    """Measure the greatest rate of the outer gimbal during the pass."""
    run = simulate(build(), np.pi / abs(w), method=Kinematic(), output=SAMPLES, **terms)
    rate = run.rate("azimuth")
    curve = Curve("rate of the azimuth [rad/s]", run.t, rate, (run.t, azimuth_rate(w * run.t, w, miss_deg)))
    height = Curve("height of the line of sight [deg]", run.t, np.degrees(run.angle("height")))
    return Measured({"outer_rate_peak_rad_s": abs(rate).max()}, [run], [curve, height])


demo = Demo(
    __name__,
    title="Gimbal lock",
    question="Why may a camera or a telescope not look at the zenith?",
    beats=(
        Beat(0.0, "The target passes at an even pace."),
        Beat(1.3, "It comes near the zenith ..."),
        Beat(share(0.5), "... and the mount whips half round."),
    ),
    why="Two axes are enough to look anywhere, but at the zenith the line of sight lies along the outer axis, and a "
    "turn about it moves nothing. A target that passes close by must be followed by swinging round half a "
    "revolution while it crosses the gap: the closer, the faster, without limit. No third coordinate helps; "
    "every pair of angles has such poles.",
    equation="rate of the outer axis = w sin(miss) / (1 - cos^2(miss) sin^2(w t)) <= w / sin(miss)",
    symbols={
        "w": Symbol("rate of the target", "rad/s", "w"),
        "t": Symbol("time", "s"),
    },
    source="Hughes, Spacecraft Attitude Dynamics, ch. 2; Wie, Space Vehicle Dynamics and Control, 5.2",
    quantities={"outer_rate_peak_rad_s": Quantity("greatest rate of the outer axis", "rad/s")},
    ablation=Ablation("zenith", "on a pass along the horizon the rate is w", {"miss_deg": 90.0}),
    against=Against("miss_deg", 2.0, 90.0, "miss of the zenith [deg]"),
    show={"curves": [("rate", "azimuth"), ("angle", "height")], "traces": [("line of sight", (1.5, 0, 0))]},
    sliders=(
        Control("miss_deg", 2.0, 90.0, "deg", "miss of the zenith", logarithmic=True),
        Control("w", 0.5, 1.0, "rad/s", "rate of the line of sight"),
    ),
    attempt="pass nearer to the zenith: the outer axis has to go round faster, without limit.",
)
