"""Judges of the reference cases: the values of their files, their degrees of freedom, eigenvalues, and the robot's
torques.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from mbsd3d import accelerations, linearize, measures
from validation import cases
from validation.benchmark.counts import Count, counted, counted_by_exudyn
from validation.cases.comparison import compare, condition
from validation.cases.robot import hinge_accelerations, robot_poses
from validation.suite.findings import FREEDOMS, PLANE, REFERENCE, THEORY, Finding, judged, not_compared
from validation.suite.trials.closed_forms import CLOSED_FORMS, Pairs
from validation.suite.trials.engines import in_the_plane
from validation.suite.trials.trial import LONG_RUN_REASON, RTOL, Run, Trial, run

SHIFT_SEED = 7
"""Seed of the shifts that put every reference point off its centre of mass: r_G = 0 would hide half of the terms."""
START_ROUNDING = 1e-10
"""Of eigenvalues and accelerations without a time loop, relative: rounding 1e-16 times a condition of up to 1e5."""
RTOL_BY_CASE = {"iftomm_A02_fourbar_N2": 1e-8}
"""Cases that pass singular positions -> rtol; tighter ones end closer to them, and rounding is amplified by more."""
ROUNDING_BY_CASE = {"free_dzhanibekov": 1e-6}
"""Cases whose error is rounding -> allowed: 2e-16 in 400 steps at random, times 6 flips and (5 / 1e-3)^2, is 7e-7."""
SHORTER_CASE = {
    "chain100_spherical": "chain10_spherical",
    "bicycle_M3": "bicycle_M1",
    "iftomm_rscr_slidercrank": "rssr_driven",
}
"""Case -> the one compared with other engines in its place when the run must be short."""


def trials(quick: bool = False) -> list[Trial]:
    """Return one test case per file of ``references/``."""
    found = [trial_of(name) for name in cases.names()]
    if not quick:
        return found
    return [
        replace(trial, alone=LONG_RUN_REASON.format(SHORTER_CASE[trial.name])) if trial.name in SHORTER_CASE else trial
        for trial in found
    ]


def trial_of(name: str) -> Trial:
    """Return the test case of a case file; without a motion, the other values of the file."""
    title, timed = cases.read(name)["title"], name in cases.names(timed=True)
    if timed:
        judges = {FREEDOMS: freedoms, REFERENCE: reference, THEORY: closed_form, PLANE: in_the_plane}
        return Trial(name, "references", title, partial(moving, name), judges)
    judges = {FREEDOMS: freedoms, REFERENCE: STATIC_JUDGES[name], THEORY: closed_form}
    return Trial(name, "references", title, partial(standing, name), judges)


def moving(name: str) -> Run:
    """Simulate a case at the times of its reference."""
    case, rtol = cases.load(name, SHIFT_SEED), RTOL_BY_CASE.get(name, RTOL)
    return run(case.system, case.t_end, output=case.times, source=case, accuracy=allowed(case, rtol), rtol=rtol)


def standing(name: str) -> Run:
    """Return a case of which only the start counts."""
    case = cases.load(name, SHIFT_SEED)
    return Run(case.system, source=case, accuracy=START_ROUNDING)


def allowed(case: cases.Case, rtol: float = RTOL) -> float:
    """Return the allowed scaled error: ten times the effect of a relative error of ``rtol`` on the case.

    At 1e-10 never more than 1e-7, or what rounding comes to. The floor of 100 rtol covers the errors of some
    hundred steps that add up in a case of condition 1.
    """
    most = ROUNDING_BY_CASE.get(case.id, 1e-7) * (rtol / RTOL)
    return min(most, max(10 * condition(case.id), 100) * rtol + case.accuracy)


def reference(made: Run) -> Iterable[Finding]:
    """Compare the columns of the file; raise an error for one without a rule."""
    found = compare(made.source, made.motion)
    yield judged(REFERENCE, f"{len(found.columns)} columns", found.scaled_error, made.accuracy)
    if found.left_out:
        yield judged(REFERENCE, "columns without a rule", len(found.left_out), 0, ", ".join(found.left_out))


def freedoms(made: Run) -> Iterable[Finding]:
    """Compare rows, rank, redundant rows and degrees of freedom with the counts of the file and of Exudyn."""
    return counts(made, {"the file": counted_in(made.source), "Exudyn": counted_by_exudyn(made.system)})


def counts(made: Run, known: Mapping[str, Count | str]) -> Iterable[Finding]:
    """Compare rows, rank, mobility and redundant rows with the counts of others, or report why these have none."""
    ours = counted(made.system)
    for who, theirs in known.items():
        if isinstance(theirs, str):
            yield not_compared(FREEDOMS, f"{who}: {theirs.removeprefix('not compared: ')}")
            continue
        wrong = sum(x != y for x, y in zip(ours, theirs, strict=True))
        text = ", ".join(f"{name} {x}" for name, x in theirs._asdict().items())
        text += f"; ours {', '.join(map(str, ours))}" if wrong else ""
        yield judged(FREEDOMS, f"counts of {who} that differ", wrong, 0, text)


def counted_in(case: cases.Case) -> Count | str:
    """Return the count of the file."""
    known = case.dof_info
    return Count(known["rows"], known["rank"], known["dof"], known["redundant"]) if known else "it counts no rows"


def closed_form(made: Run) -> Iterable[Finding]:
    """Return the closed form of the case, if there is one."""
    law = CLOSED_FORMS.get(made.source.id)
    if law is None:
        yield not_compared(THEORY, "there is no closed form of this motion")
        return
    yield from theory_of(law, made)


def theory_of(law: Callable[[Run], Pairs], made: Run) -> Iterable[Finding]:
    """Compare with the closed-form values of a reference case."""
    for quantity, (ours, exact) in law(made).items():
        ours, exact = np.asarray(ours), np.asarray(exact, dtype=float)
        yield judged(THEORY, quantity, np.abs(ours - exact).max() / max(1.0, np.abs(exact).max()), made.accuracy)


def pendulum_frequency(made: Run) -> Iterable[Finding]:
    """Compare the only eigenvalue of a pendulum or of two hanging four-bars with the file."""
    known = made.source.raw["reference"]["omega"][0]
    found = np.abs(linearize(made.system).eigenvalues.imag).max()
    yield judged(REFERENCE, "frequency", abs(found - known) / known, START_ROUNDING)


def bicycle_eigenvalues(made: Run) -> Iterable[Finding]:
    """Compare eigenvalues of the benchmark bicycle over speed with the published ones."""
    raw, worst = made.source.raw, 0.0
    for row in raw["reference"]["values"]:
        system = cases.build(at_speed(raw, row["v"]), SHIFT_SEED).system
        frame, steer = system.part("rearframe"), system.part("steer", "joints")
        seen = [measures.lean(frame), measures.angle(steer), measures.lean_rate(frame), measures.rate(steer)]
        found, known = linearize(system, outputs=seen).eigenvalues, np.array([complex(*x) for x in row["eigenvalues"]])
        worst = max(worst, np.abs(found[:, None] - known).min(axis=0).max() / np.abs(known).max())
    yield judged(REFERENCE, f"eigenvalues at {len(raw['reference']['values'])} speeds", worst, START_ROUNDING)


def at_speed(raw: dict, speed: float) -> dict:
    """Return the benchmark bicycle running straight at a speed [m/s]; its steering axis to all digits, 18 degrees
    back."""
    tilt, stored = np.pi / 10, np.linalg.norm(raw["bodies"][0]["v0"])
    moving = [{**b, **{key: [x * speed / stored for x in b[key]] for key in ("v0", "w0")}} for b in raw["bodies"]]
    joints = [dict(joint) for joint in raw["joints"]]
    steer = next(joint for joint in joints if joint["name"] == "steer")
    steer.update(p=[1.1 - 0.9 * np.sin(tilt), 0, 0.9 * np.cos(tilt)], axis=[-np.sin(tilt), 0, np.cos(tilt)])
    return {**raw, "bodies": moving, "joints": joints}


def robot(made: Run) -> Iterable[Finding]:
    """Compare accelerations of the six-axis arm in its poses, with and without torques, with the file."""
    for k, pose in enumerate(robot_poses(SHIFT_SEED)):
        state = pose.system.assemble(angles=pose.angles, rates=pose.rates)
        for system, known in ((pose.system, pose.accelerations), (pose.free, pose.free_accelerations)):
            found = hinge_accelerations(accelerations(system, state))[0]
            error = np.abs(found - known).max() / max(1.0, np.abs(known).max())
            yield judged(REFERENCE, f"accelerations in pose {k}", error, START_ROUNDING)


STATIC_JUDGES = {
    "bicycle_eigenvalues": bicycle_eigenvalues,
    "eig_fourbar2_hanging": pendulum_frequency,
    "eig_hanging_pendulum": pendulum_frequency,
    "robot6r_inverse_dynamics": robot,
}
"""Case without a motion -> judge of what its file holds."""
