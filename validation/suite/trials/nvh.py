"""Engines in cars as cases: the full motion on the mounts against the linear map, main bearings, and simple mounts."""

from collections.abc import Callable, Iterable
from functools import partial

import numpy as np

from engines import planar
from engines.balance import planar_sum
from engines.nvh.cabin import checks as cabin_checks
from engines.nvh.control import skyhook
from engines.nvh.control.cancel import Cancel
from engines.nvh.excitation import balance_shafts, presets
from engines.nvh.excitation.loads import Source
from engines.nvh.excitation.main_bearings import cut_engine, cycle_run
from engines.nvh.mounts import checks, mounts
from engines.nvh.road.guide import guide
from engines.nvh.road.report import quarter_car, ride_of
from engines.nvh.road.ride import rms
from engines.nvh.study import AGREEMENT_SHARE_MAX, Study
from validation import theory
from validation.suite.findings import PLANE, THEORY, Finding, judged
from validation.suite.trials import valves
from validation.suite.trials.trial import Judge, Run, Trial, recorded

ENGINES_IN_CARS = (("inline_4", "compact", 3000.0), ("v8_cross", "saloon", 2500.0), ("twin_270", "motorcycle", 4000.0))
GUIDES, TRACK = ("double wishbone", "multilink"), 1.55
CUT_ENGINES = ("inline_4", "v6_90", "v8_cross")
RPM = 4000.0
ROLL_SHARE_MAX = 1e-2  # [1] of the largest force: second order of the roll by half a degree, and of the motion
ROUNDING_MAX = 1e-9  # [1] of the largest value; rounding of models with up to 26 bodies stays below 1e-12
TABLE_REASON = "a Table of 24 000 points a wheel takes them too long; tables are compared in other cases"
REPRESENTED_REASON = "I4 and V6_90_split30 represent engines, which have the same parts"
ROUGH_ROAD_CASES = [(kind, linked) for linked in (False, True) for kind in ("quarter", "half", "whole")]
SMALL_MOTION_TOLERANCE = {"quarter car": 1e-4, "half car": 0.01}
LINKED_TOLERANCE = 0.02
"""Of the acceleration at the seat: a body that pitches and rolls turns the guides of its wheels, links make arcs."""
FREQUENCIES = np.array([0.7, 4.1, 5.5, 9.3, 41.0])  # Hz, around a resonance at 5.6


def trials(quick: bool) -> list[Trial]:
    """Return engines on mounts, cut cranks, and powertrains that theory knows."""
    found = []
    for engine, car, rpm in ENGINES_IN_CARS[: 1 if quick else None]:
        title = f"{presets.preset(engine).title} on its mounts at {rpm:g} rpm, motored"
        make = partial(on_mounts, engine, car, rpm)
        found.append(
            Trial(f"nvh_{engine}", "engines in cars", title, make, {THEORY: by_order}, alone=REPRESENTED_REASON)
        )
    for engine in CUT_ENGINES[: 1 if quick else None]:
        title = f"main bearings of {presets.preset(engine).title}"
        judges: dict[str, Judge] = {PLANE: partial(throws, engine)}
        found.append(
            Trial(
                f"nvh_bearings_{engine}",
                "engines in cars",
                title,
                partial(cut, engine),
                judges,
                False,
                REPRESENTED_REASON,
            )
        )
    for name, title, pairs in (
        ("transmissibility", "one degree of freedom on four mounts", partial(checks.one_freedom, FREQUENCIES)),
        ("bounce_pitch", "bounce and pitch on two pairs of mounts", checks.bounce_and_pitch),
        ("sway_roll_yaw", "three coupled degrees of freedom on four mounts", checks.three_coupled),
        ("gyroscopic", "a spinning crank couples pitch and yaw", partial(checks.spinning_rotor, 400.0)),
        ("shafts", "balance shafts with assembly errors", shafts),
        ("skyhook", "a skyhook with a slow actuator", skyhook.one_body),
        ("active", "feed-forward on the second order, sample by sample", controlled),
        ("plate", "a shell that is a free plate", cabin_checks.free_plate),
        ("rigid_shell", "a shell without elastic modes", partial(cabin_checks.rigid_shell, "compact", "inline_3")),
    ):
        judges = {THEORY: partial(known, pairs)}
        found.append(Trial(f"nvh_{name}", "engines in cars", title, simple, judges, False, "closed forms judge it"))
    for kind in GUIDES:
        title = f"a wheel on a {kind}"
        name, make, judges = f"nvh_{kind.replace(' ', '_')}", partial(on_links, kind), {THEORY: by_lengths}
        found.append(Trial(name, "engines in cars", title, make, judges))
    found += valves.trials(quick)
    for kind, linked in ROUGH_ROAD_CASES[: 1 if quick else None]:
        name, title = f"nvh_{kind}_car{'_on_links' * linked}", f"{kind} car{' on links' * linked} on a rough road"
        make = partial(rough, kind, linked)
        found.append(Trial(name, "engines in cars", title, make, {THEORY: over_the_road}, alone=TABLE_REASON))
    return found


def shafts() -> checks.Pairs:
    """Compare the effect of faults: reaction of the engine with its geared shafts in space, and closed form [N], [N
    m]."""
    chosen = presets.preset("inline_4")
    fitted = balance_shafts.fitted(chosen, "raised")
    wrong = [balance_shafts.faulty(chosen, fitted, fault) for fault in balance_shafts.FAULTS]
    ways = balance_shafts.left_in_space, balance_shafts.left
    return {
        "what faults leave of the second order": tuple(np.array([way(chosen, x, RPM) for x in wrong]) for way in ways)
    }


def controlled() -> checks.Pairs:
    """Compare the force at the car under a sampled controller: the general model stepped, and the poles of its linear
    loop.
    """
    study = Study(presets.preset("inline_4"), mounts.car("compact"), 2700.0, 0.8)
    cancel = Cancel(study.on_mounts, study.source, study.rpm, 1, 2.0, 1500.0)
    step, count = 0.5 * cancel.path.limit(cancel.W), 300
    return {"force at the car": (cancel.run(step, count), cancel.predicted(step, count), ROLL_SHARE_MAX)}


def on_links(kind: str) -> Run:
    """Simulate a wheel on a plate that lifts it, by kinematics."""
    held = guide(kind, TRACK)
    return recorded(held.run(), held)


def by_lengths(made: Run) -> Iterable[Finding]:
    """Compare camber and toe-in with those from the lengths of the links alone."""
    held, found = made.source, {"toe": [0.0], "camber": [0.0]}
    for way in (1.0, -1.0):
        z = held.curves.z[way * held.curves.z > 1e-9][:: int(way)]
        axle = theory.five_link_poses(held.links.values(), held.centre, np.concatenate([[0.0], z]))[1][1:, :, 1]
        known = {"toe": np.arctan2(axle[:, 0], axle[:, 1]), "camber": -np.arcsin(axle[:, 2])}
        for name, values in known.items():
            found[name].append(np.abs([held.curves.at(name, x) for x in z] - values).max())
    for name, errors in found.items():
        yield judged(THEORY, f"{name} over the travel", float(max(errors)), 1e-8, "rad; twist by lines, to 1e-12")


def rough(kind: str, linked: bool) -> Run:
    """Simulate a saloon over a road of class C."""
    ride = ride_of(mounts.car("saloon"), kind, "C", 21.0, linked)
    return recorded(ride.run, ride)


def over_the_road(made: Run) -> Iterable[Finding]:
    """Compare the seat, wave by wave: a quarter car in closed form, the others by their small motions."""
    ride = made.source
    quarter = ride.vehicle.title == "quarter car"
    known = quarter_car(ride) if quarter else ride.seat
    note = f"relative to the root mean square; {'closed form of the' if quarter else 'small motions of the'} car"
    error = rms(ride.run_seat - known) / rms(known)
    yield judged(
        THEORY,
        "acceleration at the seat",
        error,
        SMALL_MOTION_TOLERANCE.get(ride.vehicle.title, LINKED_TOLERANCE),
        note,
    )


def on_mounts(engine: str, car: str, rpm: float) -> Run:
    """Simulate the full motion of a motored engine, settled."""
    study = Study(presets.preset(engine), mounts.car(car), rpm, 0.0)
    return recorded(study.run, study)


def by_order(made: Run) -> Iterable[Finding]:
    """Compare forces on the car, order by order: phasors in closed form through the linear map."""
    note = "closed form of the inertia, linear map of the mounts; relative to the largest order"
    yield judged(THEORY, "orders of the forces on the car", made.source.difference, AGREEMENT_SHARE_MAX, note)


def cut(engine: str) -> Run:
    """Simulate a cycle of a motored engine whose crank is cut in its bearings."""
    solution, _ = cycle_run(Source(presets.preset(engine), 0.0), RPM)
    return recorded(solution)


def throws(engine: str, made: Run) -> Iterable[Finding]:
    """Compare the loads of both ends of a throw with half of the planar models of its cylinders."""
    chosen = presets.preset(engine).engine(RPM)
    _, mains = cut_engine(Source(presets.preset(engine), 0.0), RPM)
    plane = [
        planar.kinematics(planar_sum.build(chosen, i), made.motion.t).reaction("bearing").force
        for i in range(len(chosen.stations))
    ]
    worst, size = 0.0, 0.0
    for k in range(mains.size - 1):
        mine = sum(force for force, z in zip(plane, chosen.stations, strict=True) if mains[k] < z < mains[k + 1])
        for end in ("front", "rear"):
            seen = made.motion.reaction(f"{end} {k + 1}").force[:, :2]
            worst, size = max(worst, np.abs(seen - mine / 2).max()), max(size, np.abs(seen).max())
    yield judged(PLANE, "loads of the main bearings", worst / size, ROUNDING_MAX, "relative to the largest load")


def simple() -> Run:
    """Return a mechanism at rest: only its linear equations are compared."""
    return Run(checks.mounted([checks.mount((0.3, y, -0.2), (1e5, 1e5, 2e5)) for y in (-0.2, 0.1)]))


def known(pairs: Callable[[], checks.Pairs], made: Run) -> Iterable[Finding]:
    """Compare with the values known from theory."""
    for quantity, (computed, exact, *limit) in pairs().items():
        error = np.abs(np.asarray(computed) - exact).max() / np.abs(exact).max()
        yield judged(THEORY, quantity, float(error), limit[0] if limit else 1e-8, "relative to the largest")
