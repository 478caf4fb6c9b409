"""Truth table: every published figure of the toy engines with its value by assumption and its true value."""

from functools import cache
from typing import Any, NamedTuple

import numpy as np

from engines.balance import spatial
from engines.balance.layouts import Engine, data
from engines.balance.published.claims import Row, actual, assumed, couple, family, force, frames, peaks
from engines.balance.published.corrections import corrections

AGREES = "agrees"
CENTRIPETAL = "m w x (w x s) of the crank was left out"
PITCH = "pitch plane, " + CENTRIPETAL
ONE_STATION = "opposed pistons do not share a station; staggered"
ALONG = "forces across the bores and m w x (w x s) were left out"
ANIMATED_LAYOUTS = {
    "V8_cross_in_sequence": "V8_cross",
    "V10_72_steps_of_144": "V10",
}  # shown with all cranks of that kind
GRAVITY = (0.0, -9.81, 0.0)


class Single(NamedTuple):
    """One turn of the single cylinder in steps of 0.1 degree: bore along x, weight along -y."""

    bearing: np.ndarray  # (3601,) size of the force of the main bearing [N]
    crankpin: np.ndarray  # (3601,) [N]
    wristpin: np.ndarray  # (3601,) [N]
    guide: np.ndarray  # (3601,) force of the bore across its axis [N]
    torque: np.ndarray  # (3601,) of the driver [N m]


@cache
def single(weight: bool, centripetal: bool = True) -> Single:
    """Simulate the single cylinder in space, with or without weight, with or without m w x (w x s)."""
    engine = Engine("single")
    model = spatial.build(engine, gravity=GRAVITY if weight else (0, 0, 0), bearings=1)
    turn = spatial.turn(model, engine, count=3600, centripetal=centripetal)
    main, crankpin, wristpin = (
        np.linalg.norm(turn.reaction(name).force, axis=1) for name in ("main 1", "crankpin 1", "wristpin 1")
    )
    return Single(main, crankpin, wristpin, np.abs(turn.reaction("bore 1").force[:, 1]), turn.effort("motor"))


def published_checks() -> list[Row]:
    """Return the figures of articles and e-book, in the order of the data file."""
    checks, values = data()["published_checks"], checked()
    found = []
    for check, (about, article, true, verdict) in zip(checks, values, strict=True):
        unit = "N m" if "orque" in check["what"] or "moment" in check["what"] or "M_" in check["what"] else "N"
        published = check["published"]
        found.append(
            Row("published_checks", check["what"].strip(), unit, published, article, true, verdict, family(about))
        )
    return found


def checked() -> list[tuple[str, Any, Any, str]]:
    """Return (beginnings of the layouts, assumed, actual, verdict) of every published check."""
    flat, flat_real, boxer_real = "flat4_shared_face_to_face", "flat4_shared", "boxer4"
    cross = "V8_cross_in_sequence"
    real = couple(actual("V8_cross"), 1)
    preset = f"{ALONG}; the real crank [0, 90, 270, 180] has {real:.3f}"
    still, heavy, wrong = single(False), single(True), single(True, False)
    return [
        both("I4", "I4", force, 2, AGREES),
        both("flat4", flat, couple, 1, PITCH),
        ("flat4", couple(assumed(flat), 2), couple(actual(flat_real), 2), ONE_STATION),
        ("boxer4", couple(assumed("boxer4_face_to_face"), 1), couple(actual(boxer_real), 1), AGREES),
        ("boxer4", couple(assumed("boxer4_face_to_face"), 2), couple(actual(boxer_real), 2), ONE_STATION),
        both("I3", "I3", couple, 1, PITCH),
        both("single", "single", force, 1, CENTRIPETAL),
        both("single", "single", force, 2, AGREES),
        both("single", "single", force, 4, AGREES),
        both("V8_flat", "V8_flat", force, 2, AGREES),
        ("V8_flat", force(assumed("V8_flat"), 4, 1), force(actual("V8_flat"), 4, 1), AGREES),
        ("V8_cross", couple(assumed(cross), 1, 0), couple(actual(cross), 1, 0), preset),
        ("V8_cross", couple(assumed(cross), 1, 1), couple(actual(cross), 1, 1), preset),
        both("V8_cross", cross, couple, 2, "agrees for that preset; 0 for the real crank"),
        both("I4", "I4", force, 4, AGREES),
        *(both("I4", "I4", force, 2, AGREES, length) for length in (1.5, 2.0, 3.0, 4.0)),
        ("single", np.abs(still.torque).max(), np.abs(still.torque).max(), AGREES),
        ("single", np.abs(heavy.torque).max(), np.abs(heavy.torque).max(), AGREES),
        ("single", wrong.bearing.min(), heavy.bearing.min(), CENTRIPETAL),
        ("single", wrong.bearing.max(), heavy.bearing.max(), CENTRIPETAL),
        ("single", None, (heavy.bearing.min(), heavy.bearing.max()), AGREES),
    ]


def both(
    about: str, name: str, part: Any, order: int, verdict: str, rod_length: float = 2.0
) -> tuple[str, float, float, str]:
    """Return a component of a layout, assumed and actual."""
    return about, part(assumed(name, rod_length), order), part(actual(name, rod_length), order), verdict


def gifs() -> list[Row]:
    """Return the peaks of the second toy set: assumed in the 60 frames, actual between them."""
    found = []
    for name, check in data()["toy_set_2"]["checks"].items():
        seen, between = [values.max() for values in frames(name)], peaks(name)
        k = int(np.argmax(check["published"][1:]))  # of force and moment, the one the source shows
        published = check["published"][1 + k]
        verdict = AGREES if abs(between[k] - seen[k]) < 5e-4 else "peak of 60 frames; two harmonics of the force only"
        what, unit = (f"peak force {name}", "N") if k == 0 else (f"peak moment {name}", "N m")
        found.append(
            Row(
                "toy_set_2",
                what,
                unit,
                published,
                seen[k],
                between[k],
                verdict,
                family(ANIMATED_LAYOUTS.get(name, name)),
            )
        )
    return found


def at_top() -> list[Row]:
    """Return the single cylinder at q = 0 under its weight, with and without m w x (w x s)."""
    stated = data()["single_cylinder_inverse_dynamics_g_9.81"]["theta0"]
    wrong, true = (single(True, centripetal) for centripetal in (False, True))
    parts = (
        ("bearing, centripetal term missing", "bearing_missing_h", wrong.bearing, CENTRIPETAL),
        ("bearing", "bearing_full", true.bearing, AGREES),
        ("crankpin", "crank_rod_pin", true.crankpin, AGREES),
        ("wristpin", "rod_slider_pin", true.wristpin, AGREES),
        ("guide", "guide", true.guide, AGREES),
        ("driving torque", "driving_torque", true.torque, AGREES),
    )
    found = []
    for what, key, values, verdict in parts:
        actual = float(true.bearing[0] if values is wrong.bearing else values[0])
        unit, source = "N m" if values is true.torque else "N", "single cylinder, q = 0"
        found.append(Row(source, what, unit, stated[key], float(values[0]), actual, verdict, ("single",)))
    return found


def rows() -> list[Row]:
    """Return the whole truth table."""
    return [*published_checks(), *gifs(), *at_top(), *corrections()]
