"""Two front wheels on leaning kingpins, joined by a tie rod: do they point at the same centre?"""

import numpy as np
from scipy.optimize import brentq

from mbsd3d import GROUND, AngleDriver, Body, Distance, Kinematic, Polynomial, Revolute, System, shapes, simulate

from ..form import Ablation, Beat, Control, Curve, Demo, Measured, Quantity, require
from ..moments import share

T = 1.0  # s, from straight on to the full angle


def mechanism(*, track=1.4, wheelbase=2.6, kingpin_deg=12.0, caster_deg=6.0, arm=0.15, arm_in_deg=15.0, left_deg=25.0):
    """Build knuckles that turn about kingpins leaning inwards and backwards; arms [m] point to the rear and inwards."""
    require(wheelbase > 0, f"demo 'steering_linkage': wheelbase = {wheelbase:g}; give a length > 0")
    bodies, joints, ends = [], [], []
    for name, side in (("left", 1), ("right", -1)):
        centre, axis, lever = geometry(side, track, kingpin_deg, caster_deg, arm, arm_in_deg)
        form = [shapes.Torus(0.24, 0.07, "y", at=(0, 0.1 * side, 0)), shapes.Cylinder(0.015, 0.4, tuple(axis)),
                shapes.Cylinder(0.012, arm, tuple(lever), at=0.5 * lever)]  # fmt: skip
        bodies.append(Body(f"{name} wheel", 15.0, (0.5, 1, 0.5), position=centre, shape=form))
        joints.append(Revolute(GROUND, bodies[-1], at=centre, axis=axis, name=f"{name} kingpin"))
        ends.append(centre + lever)
    turn = np.radians(left_deg)
    joints.append(AngleDriver(joints[0], Polynomial((0, 0, 3 * turn / T**2, -2 * turn / T**3)), name="steering"))
    joints.append(Distance(*bodies, at_a=ends[0], at_b=ends[1], name="tie rod"))
    return System(bodies, joints, gravity=(0, 0, 0))


def geometry(side, track, kingpin_deg, caster_deg, arm, arm_in_deg):
    """Return wheel centre, kingpin axis and steering arm of the left (1) or right (-1) wheel."""
    axis = np.array([-np.tan(np.radians(caster_deg)), -side * np.tan(np.radians(kingpin_deg)), 1.0])
    inwards = np.radians(arm_in_deg)
    lever = arm * np.array([-np.cos(inwards), -side * np.sin(inwards), 0])
    return np.array([0, side * track / 2, 0]), axis / np.linalg.norm(axis), lever


def rotated(vector, axis, angle):
    """Return a vector rotated about an axis (Rodrigues)."""
    return (vector * np.cos(angle) + np.cross(axis, vector) * np.sin(angle)
            + axis * (axis @ vector) * (1 - np.cos(angle)))  # fmt: skip


def heading(axle):
    """Return the angle of a wheel on the ground [rad] from its axle, which was along y."""
    return np.arctan2(-axle[0], axle[1])


def error(left, right, track, wheelbase):
    """Return cot(outer) - cot(inner) - track/wheelbase of headings [rad], zero where both axles meet that of the
    rear."""
    inner, outer = (left, right) if left > 0 else (-right, -left)
    return 1 / np.tan(outer) - 1 / np.tan(inner) - track / wheelbase


def right_angle(left, track, kingpin_deg, caster_deg, arm, arm_in_deg):
    """Return the steer angle about the right kingpin [rad], by the length of the tie rod."""
    (one, axis1, lever1), (two, axis2, lever2) = (
        geometry(side, track, kingpin_deg, caster_deg, arm, arm_in_deg) for side in (1, -1)
    )
    end, length = one + rotated(lever1, axis1, left), np.linalg.norm(one + lever1 - two - lever2)

    def miss(x):
        return np.linalg.norm(end - two - rotated(lever2, axis2, x)) - length

    require(miss(left - 0.5) * miss(left + 0.5) < 0, "demo 'steering_linkage': the tie rod does not reach that far; "
            "give a smaller left_deg or a longer arm")  # fmt: skip
    return brentq(miss, left - 0.5, left + 0.5, xtol=1e-15)


def theory(*, track, wheelbase, kingpin_deg, caster_deg, arm, arm_in_deg, left_deg):
    """Solve the closure of the tie rod; return headings of both wheels on the ground."""
    require(
        left_deg != 0, "demo 'steering_linkage': left_deg = 0: straight on there is no turning centre; give an angle"
    )
    left = np.radians(left_deg)
    right = right_angle(left, track, kingpin_deg, caster_deg, arm, arm_in_deg)
    axles = [rotated(np.array([0, 1.0, 0]), geometry(side, track, kingpin_deg, caster_deg, arm, arm_in_deg)[1], angle)
             for side, angle in ((1, left), (-1, right))]  # fmt: skip
    found = error(*map(heading, axles), track, wheelbase)
    return {"right_kingpin_deg": np.degrees(right), "ackermann_error": found}


def measure(build, terms, *, track, wheelbase, kingpin_deg, caster_deg, arm, arm_in_deg) -> Measured:
    """Measure the angle of the right kingpin, and where the axles meet, at the end."""
    run = simulate(build(), T, method=Kinematic(), output=81, **terms)
    left, right = run.angle("left kingpin"), run.angle("right kingpin")
    one, other = (heading(run.rotation(f"{name} wheel")[-1, :, 1]) for name in ("left", "right"))
    some = np.linspace(0, left[-1], 11)
    known = [right_angle(x, track, kingpin_deg, caster_deg, arm, arm_in_deg) for x in some]
    curve = Curve("right kingpin [deg]", np.degrees(left), np.degrees(right), (np.degrees(some), np.degrees(known)),
                  "left kingpin [deg]")  # fmt: skip
    values = {"right_kingpin_deg": np.degrees(right[-1]), "ackermann_error": error(one, other, track, wheelbase)}
    return Measured(values, [run], [curve])


demo = Demo(
    __name__,
    title="Steering with leaning kingpins",
    question="Do both front wheels point at the same turning centre when the kingpins lean?",
    beats=(
        Beat(0.0, "Straight on."),
        Beat(share(1.0), "25 and 22 degrees: they do not point at one centre."),
    ),
    why="To roll without scrubbing both front axles must meet on the line of the rear axle: the inner wheel has to "
    "turn more. Arms that point inwards to the rear do this roughly. But kingpins lean, inwards so that the "
    "steering comes back, and backwards so that the car runs straight; then the wheel's angle on the ground is "
    "not that of the kingpin, and a plane drawing of the linkage is wrong.",
    equation="cot(outer) - cot(inner) - track / wheelbase = 0 for one common centre",
    source="Dixon, Suspension Geometry and Computation; Genta, Morello, The Automotive Chassis; Ackermann (1818)",
    quantities={
        "right_kingpin_deg": Quantity("angle of the right kingpin", "deg"),
        "ackermann_error": Quantity("cot(outer) - cot(inner) - track/wheelbase"),
    },
    ablation=Ablation(
        "lean", "with upright kingpins it is the plane trapezoid", {"kingpin_deg": 0.0, "caster_deg": 0.0}
    ),
    show={"curves": [("angle", "left kingpin"), ("angle", "right kingpin")], "traces": []},
    sliders=(
        Control("arm_in_deg", 0.0, 25.0, "deg", "arms turned in"),
        Control("left_deg", 5.0, 35.0, "deg", "left wheel"),
    ),
    attempt="turn the arms in: at some angle the error of the steering crosses zero.",
)
