"""Engines as cases: loads on the block in closed form, as a sum of planes and in space; planar mechanisms in space."""

from collections.abc import Iterable
from functools import partial

import numpy as np

from mbsd3d import Kinematic
from validation import reduce_to_planes
from validation.cases.inline_four import RATE, block_force, inline_four
from validation.engine_balance import balance, spatial
from validation.engine_balance.layouts import Engine, names
from validation.suite.findings import PLANE, THEORY, Finding, judged
from validation.suite.trials.plane import by_ladder
from validation.suite.trials.trial import Run, Trial, run
from validation.tax import pairs as twins

GRAVITY = (1.3, -9.6)  # m/s^2, in the plane of the cylinders, along no axis
SHORT = ("single", "I4", "V8_cross_real")  # Layouts of the short list
PEERED = ("I4", "V6_90_split30")  # Layouts that other engines are asked about; the others have the same parts
SAMPLES = 33


def trials(quick: bool) -> list[Trial]:
    """Layouts of engines, the inline four of the sweeps, and planar mechanisms with and without redundant rows."""
    found = [layout(name) for name in (SHORT if quick else names())]
    found.append(Trial("inline_four", "engines", "inline four, driven, as a sum of planes", four, {PLANE: block}))
    for k, mechanism in enumerate(twins.mechanisms()):
        for redundant in (False, True):
            name = f"{mechanism.name.replace(' ', '_')}{'_redundant' if redundant else ''}"
            title = f"{mechanism.name} in a plane, in space {'with' if redundant else 'without'} redundant rows"
            judges = {PLANE: partial(twin, k)}
            found.append(Trial(f"planar_{name}", "planar mechanisms", title, partial(free, k, redundant), judges))
    return found


def layout(name: str) -> Trial:
    """An engine of `validation.engine_balance`."""
    alone = "" if name in PEERED else f"{' and '.join(PEERED)} represent the layouts, which have the same parts"
    judges = {THEORY: partial(balanced, "phasor", THEORY), PLANE: partial(balanced, "planar", PLANE)}
    return Trial(f"engine_{name}", "engines", Engine(name).layout.title, partial(turning, name), judges, alone=alone)


def turning(name: str) -> Run:
    """One turn of the crank; the source holds the harmonics three ways."""
    engine = Engine(name)
    system = spatial.build(engine, gravity=(*GRAVITY, 0.0))
    solution = spatial.turn(system, engine)
    return Run(system, float(solution.t[-1]), solution, source=balance.compare(engine, gravity=GRAVITY))


def balanced(way: str, judge: str, made: Run) -> Iterable[Finding]:
    """Harmonics 0 to 6 of the load on the block: the model in space against another way."""
    found, engine = made.source.ways, made.source.engine
    error = found[way].difference(found["spatial"], engine.spacing) / engine.single
    yield judged(judge, "harmonics of the block load", error, balance.LIMIT, "relative to the 1x force of one cylinder")


def four() -> Run:
    """One turn of the inline four."""
    return run(inline_four(), 2 * np.pi / RATE, method=Kinematic(), output=SAMPLES)


def block(made: Run) -> Iterable[Finding]:
    """Force on the block as a sum of planes."""
    ours = block_force(made.solution)
    known = reduce_to_planes(made.system).block_load(made.solution.t).force
    yield judged(PLANE, "force on the block", np.abs(ours - known).max() / np.abs(known).max(), balance.LIMIT)


def free(k: int, redundant: bool) -> Run:
    """A planar mechanism that runs freely in space for a turn of its first speed."""
    mechanism = twins.mechanisms()[k]
    return run(mechanism.space(redundant=redundant), mechanism.turn, output=SAMPLES)


def twin(k: int, made: Run) -> Iterable[Finding]:
    """The same mechanism in the planar solver; its plane is x and y."""
    return by_ladder(made, twins.mechanisms()[k].plane(), np.eye(3))
