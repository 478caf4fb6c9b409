"""Valves on cams as cases: multiplier and float, contact and bounce, surge, checked by cam laws."""

from collections.abc import Iterable
from functools import partial

import numpy as np

from engines import closed_forms
from engines.nvh.valvetrain.report import CAM_HALF_ANGLE, CAM_LIFT, Valve
from mbsd3d import SlideDriver, System, linearize
from validation.suite.findings import THEORY, Finding, judged
from validation.suite.trials.trial import Run, Trial, recorded

OWN_FORCE_REASON, CURVE_REASON = "the contact is a force of one's own", "no other engine has contacts on curves"
CLOSED_FORM_REASON = "closed forms judge it"
CONTACT_RPM = 1500.0  # [1/min] float begins at 3574
SPLINE_MARGIN = 0.16  # [rad] from the ends and the nose of a lift: where its derivatives jump the spline oscillates


def trials(quick: bool) -> list[Trial]:
    """Return a flat face in contact, rollers held, a valve that bounces, a spring; the first of them for a quick
    run."""
    found = [
        Trial(f"nvh_valve{name}", "engines in cars", title, make, {THEORY: judge}, alone=alone)
        for name, title, make, judge, alone in (
            ("", f"valve on a cam in contact at {CONTACT_RPM:g} 1/min", valve, on_the_cam, OWN_FORCE_REASON),
            ("_roller", "valve held on a cam by a roller", partial(held, "harmonic", "roller"), pushed, CURVE_REASON),
            ("_barrel", "valve held on the rim of a drum", partial(held, "cycloidal", "barrel"), pushed, CURVE_REASON),
            (
                "_float",
                "valve that leaves a drum and bounces",
                partial(floating, "cycloidal", "barrel"),
                bounced,
                OWN_FORCE_REASON,
            ),
            ("_surge", "a spring of eight pieces over a closed valve", surging, surged, CLOSED_FORM_REASON),
        )
    ]
    return found[: 1 if quick else None]


def valve() -> Run:
    """Simulate a valve in contact with its cam, well below the float speed."""
    made = Valve("cycloidal", CONTACT_RPM)
    return recorded(made.run, made)


def speed_of_float(made: Valve) -> Finding:
    """Compare the speed from which the multiplier pulls with the law of the cam."""
    train = made.train
    s, _, dds = getattr(closed_forms.cams, made.law)(np.linspace(-np.pi, np.pi, 20001), CAM_LIFT, CAM_HALF_ANGLE)
    known = 30 / np.pi * closed_forms.cams.float_rate(train.mass, train.rate, train.preload, s, dds)
    return judged(THEORY, "speed of float", abs(made.floats / known - 1), 1e-4, "lift by a spline of half degrees")


def on_the_cam(made: Run) -> Iterable[Finding]:
    """Compare the float speed and the force of the contact with the law of the cam."""
    train = made.source.train
    yield speed_of_float(made.source)
    angle = (train.turn * made.motion.t) % (2 * np.pi) - np.pi
    s, _, dds = closed_forms.cams.cycloidal(angle, CAM_LIFT, CAM_HALF_ANGLE)
    force = train.mass * dds * train.turn**2 + train.preload + train.rate * s
    off = np.abs(made.motion.force("contact").force[:, 2] - force).max() / force.max()
    yield judged(THEORY, "force of the contact", float(off), 0.03, "relative to the largest; the valve swings on it")


def held(law: str, follower: str) -> Run:
    """Simulate a turn with the valve held on its cam, above the float speed, by kinematics."""
    made = Valve(law, None, follower)
    return recorded(made.held, made)


def pushed(made: Run) -> Iterable[Finding]:
    """Compare the float speed, multiplier, side force and torque with the law of the cam."""
    train, law, run = made.source.train, getattr(closed_forms.cams, made.source.law), made.motion
    yield speed_of_float(made.source)
    angle = (train.turn * run.t) % (2 * np.pi) - np.pi
    s, ds, dds = law(angle, CAM_LIFT, CAM_HALF_ANGLE)
    along = train.mass * dds * train.turn**2 + train.preload + train.rate * s
    aside = ds / train.cam.base if made.source.follower == "barrel" else -ds / (train.cam.height + s)
    smooth = np.min([np.abs(np.abs(angle) - CAM_HALF_ANGLE), np.abs(angle)], axis=0) > SPLINE_MARGIN
    force, note = run.reaction("cam").force, "relative to the largest, away from jumps of the law's derivatives"
    for what, found, exact in (
        ("force of the cam", force[:, 2], along),
        ("side force", force[:, 1], along * aside),
        ("torque of the camshaft", run.effort("motor"), along * ds),
    ):
        yield judged(THEORY, what, float(np.abs(found - exact)[smooth].max() / np.abs(exact).max()), 1e-5, note)
    lean = np.abs(np.arctan(aside)).max()
    yield judged(THEORY, "pressure angle", float(abs(train.cam.lean / lean - 1)), 1e-4, "largest of half degrees")


def floating(law: str, follower: str) -> Run:
    """Simulate a valve above its float speed, in a contact that opens."""
    made = Valve(law, None, follower)
    return recorded(made.run, made)


def bounced(made: Run) -> Iterable[Finding]:
    """Compare every flight and impact of two turns with one equation of motion along the law."""
    train, run = made.source.train, made.motion

    def law(angle: float) -> tuple[float, float, float]:
        return getattr(closed_forms.cams, made.source.law)(angle, CAM_LIFT, CAM_HALF_ANGLE)

    numbers = (train.rate, train.preload), (train.contact, train.damping)
    known = closed_forms.cams.bounce(law, train.turn, train.mass, *numbers, run.t)
    off = np.abs(run.position("valve")[:, 2] - train.cam.height - known).max() / train.gap(run).max()
    yield judged(THEORY, "height over two turns", float(off), 1e-4, "of the largest gap; lift by a spline, and blows")


def surging() -> Run:
    """Return a spring over a valve that a slide holds shut; nothing moves."""
    bodies, (bearing, _, guide, *guides), forces = Valve("cycloidal", CONTACT_RPM).surging_train.parts
    joints = [bearing, guide, *guides, SlideDriver(guide, 0.0, name="closed")]
    return Run(System(bodies, joints, forces, gravity=(0, 0, 0)))


def surged(made: Run) -> Iterable[Finding]:
    """Compare the frequencies of the chain with its closed form, and the first one with that of a continuous spring."""
    train = Valve("cycloidal", CONTACT_RPM).surging_train
    values = np.abs(linearize(made.system).eigenvalues)
    found = np.unique(values[values > 1.0].round(6))
    known = closed_forms.cams.surge(train.coils, train.rate, train.pieces)
    yield judged(THEORY, "frequencies of surge", float(np.abs(found / known - 1).max()), 1e-8, "relative")
