"""Cross-check of a mechanism with other engines, from mass matrices to motions, judged by convergence."""

from collections.abc import Callable, Sequence
from functools import partial
from importlib import import_module
from typing import Any

import numpy as np

from mbsd3d import State, System
from mbsd3d.errors import InputError
from mbsd3d.extend import Progress, check_state, check_system, checks_arguments, model_digest, number
from validation.crosscheck.formulation import ENGINE as DEFINITIONS
from validation.crosscheck.formulation import compare_definitions, skipped
from validation.crosscheck.judge import Runs, curves, explained, judge_motion, judge_start, own_error
from validation.crosscheck.mbsd3d_runs import Ours, ours_at, ours_at_start
from validation.crosscheck.result import DIFFERS, SKIPPED, Compared, CrossCheck, Finding
from validation.crosscheck.step_refinement import INTERVAL_COUNT, climb, fastest_rate, first_steps
from validation.twins.base import EngineMissing, NotComparable, Twin

MODULES = {"mujoco": "validation.twins.mujoco", "exudyn": "validation.twins.exudyn"}
NAMES = {"mujoco": "MuJoCo", "exudyn": "Exudyn"}
ENGINES = (*MODULES, DEFINITIONS)
FORMULATIONS: dict[str, tuple[dict[str, Any], ...]] = {
    "mujoco": ({}, {"rods": "tendons"}),
    "exudyn": (
        {"formulation": "kinematic tree"},  # trees of hinges and sliders: explicit, without constraints
        {},
        {"tolerance": 1e-9},  # where Newton's iterations cannot reach the usual one
        {"linear": "full-pivot"},  # redundant rows
    ),
}
"""Settings of an engine's twin in the order they are tried: the most accurate one that takes the model counts."""
BUDGET_SECONDS = 10.0  # [s] of an engine's step refinement


class Interrupted(KeyboardInterrupt):
    """Interruption by Ctrl-C during the runs of an engine, with the findings so far."""

    def __init__(self, found: Compared) -> None:
        self.found = found


@checks_arguments
def cross_check(
    system: System,
    t_end: float | None,
    *,
    engines: Sequence[str] = ENGINES,
    state: State | None = None,
    tolerance: float = 1e-6,
    budget: float = BUDGET_SECONDS,
    progress: bool | None = None,
) -> CrossCheck:
    """Compare a mechanism's motion with the same mechanism in MuJoCo and Exudyn, and with its joints' definitions.

    Mass matrix and accelerations at the start, then poses, velocities, momenta, energies and unique reactions at 33
    samples. Every engine runs with ever shorter steps; what is compared is the limit these runs tend to, over the time
    in which it is known to the tolerance. A difference counts unless it vanishes with a cause that was changed.

    Parameters
    ----------
    system : System
    t_end : float or None
        [s]; None = mass matrix and accelerations at the start only.
    engines : sequence of str
        Of "mujoco", "exudyn" and "definitions" (not an engine: a second formulation, see `crosscheck.formulation`).
    state : State or None
        Start; None = ``system.state()``.
    tolerance : float
        Relative difference that counts as agreement; also up to where an engine's limit has to be known. If it is not
        for an eighth of the time, it is taken ten times larger, 1e-3 at most, and the findings and the last line say
        so. Our own motion has to be known to the tolerance that was asked for.
    budget : float
        Seconds of processor time that an engine's runs may take before no finer step is tried, and the definitions
        before no further state is looked at: what else the machine does changes no verdict.
    progress : bool or None
        Show a progress bar; None = on a terminal, after two seconds.

    Returns
    -------
    CrossCheck
        Also after Ctrl-C, with what was found; it has not passed then.

    Raises
    ------
    ValueError
        For input that makes no sense.
    IntegrationError
        If our own run fails.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Revolute, System
    >>> from validation import cross_check
    >>> arm = Body("arm", 1.2, (0.02, 0.1, 0.1), com=(0.4, 0, 0))
    >>> system = System([arm], [Revolute(GROUND, arm, at=(0, 0, 0), axis=(0, -1, 0), name="hinge")])
    >>> cross_check(system, 0.5, engines=["definitions"]).verdict["definitions", "acceleration"]
    'agrees'
    """
    start, times = check_input(system, t_end, engines, state, tolerance, budget)
    engines = tuple(dict.fromkeys(engines))
    if not any(body.mass for body in system.bodies):
        raise InputError("cross_check: no body has a mass, so nothing moves by laws that engines share; give masses")
    with Progress("compare", 0.0, 1.0 + len(engines), progress) as bar:
        ours = ours_at_start(system, start) if t_end is None else ours_at(system, start, times)
        found, interrupted = one_by_one(engines, partial(compare, system, start, ours, tolerance, budget), bar)
    own = float(own_error(ours)[-1]) if ours.error else 0.0
    end = float(ours.motion.t[-1])
    return CrossCheck(
        end, tolerance, tuple(found), float(ours.growth[-1]), own, interrupted, t_end is None, notes(ours),
        digest_of(system, start),
    )  # fmt: skip


def digest_of(system: System, start: State) -> str:
    """Return the digest of model and start; "" for a model with functions, which files cannot hold."""
    try:
        return model_digest(system, start)
    except InputError:
        return ""


def one_by_one(
    engines: Sequence[str], compare_with: Callable[..., Compared], bar: Progress
) -> tuple[list[Compared], bool]:
    """Return (findings about each engine, whether Ctrl-C ended them)."""
    found: list[Compared] = []
    for k, engine in enumerate(engines):
        bar.update(1.0 + k)
        try:
            found.append(compare_with(engine, lambda x, k=k: bar.update(1 + k + x)))
        except NotComparable as error:
            found.append(skipped(NAMES.get(engine, engine), str(error)))
        except KeyboardInterrupt as stop:
            found += [stop.found] if isinstance(stop, Interrupted) else []
            left = engines[k + isinstance(stop, Interrupted) :]
            return found + [skipped(NAMES.get(name, name), "interrupted") for name in left], True
    return found, False


def check_input(
    system: System, t_end: float | None, engines: Sequence[str], state: State | None, tolerance: float, budget: float
) -> tuple[State, np.ndarray]:
    """Return (start, sample times); raise ValueError for invalid input."""
    check_system(system, "cross_check")
    check_state(state, "cross_check")
    start = state or system.state()
    end = start.t + 1.0 if t_end is None else number(t_end, "cross_check: t_end")
    if not end > start.t:
        raise InputError(f"cross_check: t_end = {end:g} s does not lie after the start at {start.t:g} s; give more")
    if not system.bodies:
        raise InputError("cross_check: the system has no bodies; give one that moves")
    if isinstance(engines, str) or not engines:
        raise InputError(f"cross_check: engines {engines!r}: give a list of {', '.join(ENGINES)}")
    for engine in engines:
        if engine not in ENGINES:
            raise InputError(f"cross_check: engine {engine!r} is unknown; give one of {', '.join(ENGINES)}")
    if not 1e-9 <= number(tolerance, "cross_check: tolerance") <= 1e-3:
        raise InputError(f"cross_check: tolerance {tolerance:g} is outside 1e-9 ... 1e-3; give a number in this range")
    if not number(budget, "cross_check: budget") > 0.0:
        raise InputError(f"cross_check: budget {budget:g} s; give seconds above 0")
    return start, np.linspace(start.t, end, INTERVAL_COUNT + 1)


def compare(
    system: System, state: State, ours: Ours, tolerance: float, budget: float, engine: str,
    report: Callable[[float], None],
) -> Compared:  # fmt: skip
    """Return all findings about one engine, by its first formulation that takes the model to the end."""
    if engine == DEFINITIONS:
        end = float(ours.motion.t[-1])
        return compare_definitions(system, state, end if end > state.t else None, ours.size, budget)
    make = import_module(MODULES[engine]).twin
    halted, reason = None, NotComparable("no way to run it")
    for settings in FORMULATIONS[engine]:
        try:
            found = compare_way(
                partial(make, system, state=state, **settings), system, state, ours, tolerance, budget, report
            )
        except EngineMissing:
            raise
        except NotComparable as error:
            reason = error
            continue
        if found.steps or ours.motion.t.size == 1 or any(x.status == DIFFERS for x in found.findings):
            return found  # what differs in one way is not made good by another
        halted = halted or found
    if halted is None:
        raise reason
    return halted


def compare_way(
    make: Callable[..., Twin], system: System, state: State, ours: Ours, tolerance: float, budget: float, report: Any
) -> Compared:  # fmt: skip
    """Return all findings about an engine in one formulation; a motion it cannot follow is one of them."""
    twin, t_end = make(), float(ours.motion.t[-1])
    name, findings = twin.engine, judge_start(system, state, twin, ours, tolerance)
    if t_end == state.t:
        return Compared(name, tuple(explained(findings, make, system, state, ours)), twin.settings, twin.order)
    first = first_steps(t_end - state.t, fastest_rate(ours.motion))

    def runs_of(twin: Twin) -> Runs:
        return Runs(system, climb(twin, system, t_end, first, ours.size, 0.1 * tolerance, budget, report), ours)

    try:
        runs = runs_of(twin)
    except KeyboardInterrupt:
        findings.append(Finding(name, "motion", SKIPPED, reason="interrupted"))
        raise Interrupted(Compared(name, tuple(findings), twin.settings, twin.order)) from None
    except NotComparable as error:
        findings.append(Finding(name, "motion", SKIPPED, reason=str(error)))
        return Compared(name, tuple(explained(findings, make, system, state, ours)), twin.settings, twin.order)
    motion, span = judge_motion(runs, name, tolerance)
    findings = explained(findings + motion, make, system, state, ours, runs_of, span)
    ladder = runs.ladder
    return Compared(
        name, tuple(findings), twin.settings + silent(ladder.runs[-1], ours), twin.order, tuple(ladder.steps),
        tuple(run.seconds for run in ladder.runs), ladder.stopped, curves(runs, span),
    )  # fmt: skip


def silent(motion: Any, ours: Ours) -> str:
    """Return text on the unique reactions that an engine does not report."""
    missing = [f"'{name}'" for name in ours.motion.reactions if name not in motion.reactions]
    if not missing:
        return ""
    return "; reports no reactions" + (f" of {', '.join(missing)}" if motion.reactions else "")


def notes(ours: Ours) -> tuple[str, ...]:
    """Return notes on what is left out on purpose."""
    if not ours.open:
        return ()
    names = ", ".join(f"'{name}'" for name in ours.open)
    return (f"what the constraints do not determine of the reactions of {names} is not compared (redundant rows)",)
