"""Formulations and settings of the benchmark: those of `mbsd3d`, and those a knowledgeable user would choose of each
peer.

Left out, because each was tried and took at least twice as long for every error of the table: MuJoCo's Euler, implicit
and implicitfast (order 1), and pieces welded together for planar cuts; Exudyn's full Newton, and constraints for chains
of hinges. Left out as another model: rigid bodies in the plane. MuJoCo and Exudyn use one thread by default.
"""

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from mbsd3d import DOP853, System
from mbsd3d.extend import matrix
from validation.benchmark.problems import PLANAR_CUTS, Poses, Problem, poses, whole
from validation.twins import exudyn, mujoco
from validation.twins.base import NotComparable

TOLERANCES = tuple(10.0 ** -np.arange(1.5, 12.1, 0.5))
STEPS = tuple(2**k for k in range(4, 23))
PEERS = ("MuJoCo", "Exudyn")
ENGINES = ("mbsd3d", *PEERS)
CONSTRAINTS_LABEL = "constraints"  # in the label of a form with joints as in mbsd3d
# solref of loops: (softness h, dampratio)
SOLREF_SETTINGS = ((2.0, 1.0), (1.0, 1.0), (16.0, 0.5), (4.0, 0.5), (1.0, 0.7))
TREE_SOLVERS = ("rk44", "dopri5", "rk67")
IMPLICIT_SOLVERS = ("index2", "generalized-alpha")
ROTATIONS = ("rotation vector", "euler parameters")
SPECTRAL_RADIUS = 0.9  # [1] Exudyn's own default
TREE_LINKS_MAX = 200  # [1] links; at 300 a step of Exudyn takes half a second, and it grows with the cube
RUN_SECONDS_MAX = 5.0  # [s] of one run of mbsd3d
NEWTON_TOLERANCE = 1e-8  # [1] Exudyn's own default; tighter ones cost a tenth more and stop where masses are tiny


class Run(NamedTuple):
    """Seconds of the time loop, and the pose at its end."""

    seconds: float
    end: Poses


class Unfinished(NotComparable):
    """Error for a run that took longer than `RUN_SECONDS_MAX`."""


@contextmanager
def ended_after(seconds: float) -> Iterator[None]:
    """Interrupt the block after a time, for runs that would continue in ever smaller steps; raises `Unfinished`."""
    late: list[float] = []

    def interrupt(*_: Any) -> None:
        late.append(seconds)
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, interrupt)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    except KeyboardInterrupt:
        if not late:
            raise
        raise Unfinished(f"not at its end after {seconds:g} s") from None
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


@dataclass(frozen=True, eq=False)
class Candidate:
    """Formulation and setting that solve a problem.

    ``engine, label``: who, and formulation, integrator and settings; ``ladder``: numbers of steps, or tolerances, from
    coarse to fine; ``start``: builds the model and returns a function (setting) -> `Run`; raises NotComparable.
    """

    engine: str
    label: str
    ladder: tuple[float, ...]
    start: Callable[[], Callable[[float], Run]]


def ours(problem: Problem) -> Candidate:
    """Return the candidate of mbsd3d: DOP853 with adaptive steps, the default."""

    def start() -> Callable[[float], Run]:
        state = problem.system.state()

        def run(rtol: float) -> Run:
            method = DOP853(stiff="run")
            with ended_after(RUN_SECONDS_MAX):
                solution = whole(problem.system, problem.t_end, state=state, method=method, rtol=rtol)
            record = solution.record
            # rows chosen again on the way happen outside the compiled loop; the first choice belongs to the set-up
            seconds = record.loop_seconds if record.svd_calls <= 1 else record.seconds
            return Run(seconds, poses(solution))

        return run

    return Candidate("mbsd3d", "absolute coordinates, DOP853", TOLERANCES, start)


def of_peer(problem: Problem, peer: str) -> list[Candidate]:
    """Return all candidates of a peer."""
    return list({"MuJoCo": of_mujoco, "Exudyn": of_exudyn}[peer](problem))


def forms(problem: Problem) -> dict[str, Any]:
    """Return the forms of a problem, text -> system, as built first."""
    return {"as built": problem.system, **problem.forms}


def of_mujoco(problem: Problem) -> Iterator[Candidate]:
    """Return the candidates of MuJoCo: RK4 in joint coordinates; loops as built or with weaker cuts, each with several
    solref.
    """
    closed = problem.family in ("loop", "bicycle")
    for form, system in {text: x for text, x in forms(problem).items() if text != PLANAR_CUTS}.items():
        for softness, damping in SOLREF_SETTINGS if closed else SOLREF_SETTINGS[:1]:
            text = f", solref ({softness:g} h, {damping:g})" if closed else ""
            settings = {"softness": softness, "dampratio": damping} if closed else {}
            yield stepped("MuJoCo", f"{form}, RK4{text}", problem, system, settings)


def of_exudyn(problem: Problem) -> Iterator[Candidate]:
    """Return the candidates of Exudyn: trees and free bodies by explicit solvers, trees in hinge coordinates; joints as
    constraints by implicit ones.
    """
    if problem.family == "free body":
        for solver in TREE_SOLVERS:
            yield stepped("Exudyn", f"rotation vector, {solver}", problem, problem.system, {"solver": solver})
        yield adaptive(problem, problem.system, {})
        return
    if problem.tree is not None and len(problem.tree.bodies) > TREE_LINKS_MAX:

        def refuse() -> Callable[[float], Run]:
            raise NotComparable(f"a tree of more than {TREE_LINKS_MAX} links; a step takes too long")

        yield Candidate("Exudyn", "kinematic tree", (), refuse)
        return
    if problem.tree is not None:
        tree = {"formulation": "kinematic tree"}
        for solver in TREE_SOLVERS:
            yield stepped("Exudyn", f"kinematic tree, {solver}", problem, problem.tree, tree | {"solver": solver})
        if problem.family != "top":  # from a first step that is too long DOPRI5 does not come back
            yield adaptive(problem, problem.tree, tree)
        if problem.family == "chain":
            return
    for (form, system), solver, rotation in product(problem.determinate().items(), IMPLICIT_SOLVERS, ROTATIONS):
        settings = {
            "solver": solver,
            "rotation": rotation,
            "spectral_radius": SPECTRAL_RADIUS,
            "tolerance": NEWTON_TOLERANCE,
        }
        label = f"{form}, {CONSTRAINTS_LABEL}, {rotation.rstrip('s')}s, {solver}"
        yield stepped("Exudyn", label, problem, system, settings)
    if problem.repeats:  # slow, and the only way through singular poses
        settings = {
            "solver": "generalized-alpha",
            "linear": "full-pivot",
            "spectral_radius": SPECTRAL_RADIUS,
            "tolerance": NEWTON_TOLERANCE,
        }
        yield stepped(
            "Exudyn",
            f"as built, {CONSTRAINTS_LABEL}, full pivoting, generalized-alpha",
            problem,
            problem.system,
            settings,
        )


def twin(engine: str, system: System, settings: dict[str, Any]) -> Any:
    """Return the counterpart of a system in a peer."""
    return (mujoco if engine == "MuJoCo" else exudyn).twin(system, **settings)


def stepped(engine: str, label: str, problem: Problem, system: System, settings: dict[str, Any]) -> Candidate:
    """Return a candidate with equal steps."""

    def start() -> Callable[[float], Run]:
        model = twin(engine, system, settings)
        return lambda steps: read(problem, system, model.run(problem.t_end, int(steps), 1))

    return Candidate(engine, label, STEPS, start)


def adaptive(problem: Problem, system: System, settings: dict[str, Any]) -> Candidate:
    """Return a candidate with Exudyn's DOPRI5 and its own steps."""

    def start() -> Callable[[float], Run]:
        def run(tolerance: float) -> Run:
            chosen = settings | {"solver": "dopri5", "adaptive": True, "tolerance": tolerance}
            return read(problem, system, twin("Exudyn", system, chosen).run(problem.t_end, 16, 1))

        return run

    label = ("kinematic tree" if settings else "rotation vector") + ", dopri5 with its own steps"
    return Candidate("Exudyn", label, TOLERANCES, start)


def read(problem: Problem, system: System, motion: Any) -> Run:
    """Return the end of a motion for the bodies of the problem: a form may have massless bodies before them."""
    extra = len(system.bodies) - len(problem.system.bodies)
    return Run(motion.seconds, Poses(motion.position[-1, extra:], matrix(motion.orientation[-1, extra:])))
