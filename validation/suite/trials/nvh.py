"""Engines in cars as cases: the full motion on the mounts against the linear map, main bearings, and simple mounts."""

from collections.abc import Callable, Iterable
from functools import partial

import numpy as np

from validation import theory
from validation.engine_balance import planar_sum
from validation.nvh.engine import presets
from validation.nvh.engine.loads import Source
from validation.nvh.engine.main_bearings import cut_engine, cycle_run
from validation.nvh.held import checks, mounts
from validation.nvh.road.report import ride_of
from validation.nvh.road.ride import rms
from validation.nvh.study import AGREES, Study
from validation.suite.findings import PLANE, THEORY, Finding, judged
from validation.suite.trials.trial import Run, Trial
from validation.twins import planar

IN_CARS = (("inline_4", "compact", 3000.0), ("v8_cross", "saloon", 2500.0), ("twin_270", "motorcycle", 4000.0))
CUT = ("inline_4", "v6_90", "v8_cross")
RPM = 4000.0
LIMIT = 1e-9  # of the largest: rounding of models with up to 26 bodies stays below 1e-12
STANDS = "a Table of 24 000 points a wheel takes them too long; tables are compared in other cases"
ALONE = "I4 and V6_90_split30 represent engines, which have the same parts"
ROUGH = ("quarter", "linked", "half", "whole")
SMALL = {"quarter": 1e-4, "linked": 0.02, "half": 0.01, "whole": 0.02}
"""Of the acceleration at the seat: a body that pitches and rolls turns the guides of its wheels, links make arcs."""
FREQUENCIES = np.array([0.7, 4.1, 5.5, 9.3, 41.0])  # Hz, around a resonance at 5.6


def trials(quick: bool) -> list[Trial]:
    """Engines on mounts, cut cranks, and powertrains that theory knows."""
    found = []
    for engine, car, rpm in IN_CARS[: 1 if quick else None]:
        title = f"{presets.preset(engine).title} on its mounts at {rpm:g} rpm, motored"
        make = partial(on_mounts, engine, car, rpm)
        found.append(Trial(f"nvh_{engine}", "engines in cars", title, make, {THEORY: by_order}, alone=ALONE))
    for engine in CUT[: 1 if quick else None]:
        title = f"main bearings of {presets.preset(engine).title}"
        judges = {PLANE: partial(throws, engine)}
        found.append(
            Trial(f"nvh_bearings_{engine}", "engines in cars", title, partial(cut, engine), judges, False, ALONE)
        )
    for name, title, pairs in (
        ("transmissibility", "one freedom on four mounts", partial(checks.one_freedom, FREQUENCIES)),
        ("bounce_pitch", "bounce and pitch on two pairs of mounts", checks.bounce_and_pitch),
        ("sway_roll_yaw", "three coupled freedoms on four mounts", checks.three_coupled),
        ("gyroscopic", "a spinning crank couples pitch and yaw", partial(checks.spinning_rotor, 400.0)),
    ):
        judges = {THEORY: partial(known, pairs)}
        found.append(Trial(f"nvh_{name}", "engines in cars", title, simple, judges, False, "closed forms judge it"))
    for kind in ROUGH[: 1 if quick else None]:
        title = f"{kind} car on a rough road"
        judges = {THEORY: over_the_road}
        found.append(Trial(f"nvh_{kind}_car", "engines in cars", title, partial(rough, kind), judges, alone=STANDS))
    return found


def rough(kind: str) -> Run:
    """A saloon over a road of class C."""
    ride = ride_of(mounts.car("saloon"), kind, "C", 21.0)
    return Run(ride.run.system, float(ride.run.t[-1]), ride.run, source=ride)


def over_the_road(made: Run) -> Iterable[Finding]:
    """The seat, wave by wave: a quarter car in closed form, the others by their small motions."""
    ride = made.source
    note = "relative to the root mean square; small motions of the car"
    if ride.vehicle.kind == "quarter":
        (corner,), note = ride.vehicle.corners, "relative to the root mean square; closed form of the quarter car"
        masses = ride.vehicle.mass, corner.mass
        tyre = corner.tyre, corner.tyre_damping
        body, _ = theory.quarter_car(ride.rates, masses, (corner.spring, corner.damper), tyre)
        known = -(ride.rates**2) * body * ride.under(corner)
    else:
        known = ride.seat
    yield judged(
        THEORY, "acceleration at the seat", rms(ride.run_seat - known) / rms(known), SMALL[ride.vehicle.kind], note
    )


def on_mounts(engine: str, car: str, rpm: float) -> Run:
    """The full motion of a motored engine, settled."""
    study = Study(presets.preset(engine), mounts.car(car), rpm, 0.0)
    return Run(study.run.system, float(study.run.t[-1]), study.run, source=study)


def by_order(made: Run) -> Iterable[Finding]:
    """Forces on the car, order by order: phasors in closed form through the linear map."""
    note = "closed form of the inertia, linear map of the mounts; relative to the largest order"
    yield judged(THEORY, "orders of the forces on the car", made.source.difference, AGREES, note)


def cut(engine: str) -> Run:
    """A cycle of a motored engine whose crank is cut in its bearings."""
    solution, _ = cycle_run(Source(presets.preset(engine), 0.0), RPM)
    return Run(solution.system, float(solution.t[-1]), solution)


def throws(engine: str, made: Run) -> Iterable[Finding]:
    """Both ends of a throw carry half of what the planar models of its cylinders bear."""
    chosen = presets.preset(engine).engine(RPM)
    _, mains = cut_engine(Source(presets.preset(engine), 0.0), RPM)
    plane = [
        planar.kinematics(planar_sum.build(chosen, i), made.solution.t).reaction("bearing").force
        for i in range(len(chosen.stations))
    ]
    worst, size = 0.0, 0.0
    for k in range(mains.size - 1):
        mine = sum(force for force, z in zip(plane, chosen.stations, strict=True) if mains[k] < z < mains[k + 1])
        for end in ("front", "rear"):
            seen = made.solution.reaction(f"{end} {k + 1}").force[:, :2]
            worst, size = max(worst, np.abs(seen - mine / 2).max()), max(size, np.abs(seen).max())
    yield judged(PLANE, "loads of the main bearings", worst / size, LIMIT, "relative to the largest load")


def simple() -> Run:
    """Only the linear equations are compared: nothing moves."""
    return Run(checks.mounted([checks.mount((0.3, y, -0.2), (1e5, 1e5, 2e5)) for y in (-0.2, 0.1)]))


def known(pairs: Callable[[], checks.Pairs], made: Run) -> Iterable[Finding]:
    """What theory knows."""
    for quantity, (computed, exact) in pairs().items():
        error = np.abs(np.asarray(computed) - exact).max() / np.abs(exact).max()
        yield judged(THEORY, quantity, float(error), 1e-8, "relative to the largest")
