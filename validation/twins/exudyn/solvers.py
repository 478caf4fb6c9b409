"""Exudyn module and its console; its solvers by name, settings of an expert, the loop."""

import re
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass
from importlib import metadata
from io import StringIO
from typing import Any

import numpy as np

from mbsd3d.errors import InputError
from mbsd3d.extend import loading
from validation.twins.base import Array, EngineFailed, EngineMissing, release

VERSION_MIN = (1, 13, 6)
"""Earlier versions name their settings otherwise, and have no coordinate of a hinge (MarkerBodiesRelative...)."""

VERSION_MIN_TEXT = ".".join(map(str, VERSION_MIN))


def exudyn() -> Any:
    """Import the module Exudyn on demand.

    EngineMissing if it is not installed or older than `VERSION_MIN`.
    """
    try:
        version = metadata.version("exudyn")
    except metadata.PackageNotFoundError:
        raise EngineMissing("Exudyn is not installed; pip install 'mbsd3d[validation]'") from None
    check_version(version)
    try:
        with loading():
            import exudyn as module
            import exudyn.itemInterface
    except ImportError as error:
        raise EngineMissing(f"Exudyn {version} does not load: {error}; install it again") from None
    return module


def check_version(version: str) -> None:
    """Raise EngineMissing for a version before `VERSION_MIN`."""
    if release(version) < VERSION_MIN:
        raise EngineMissing(
            f"Exudyn {version} is older than {VERSION_MIN_TEXT}; pip install -U 'exudyn>={VERSION_MIN_TEXT}'"
        )


@contextmanager
def quiet(module: Any) -> Iterator[StringIO]:
    """Silence the console of Exudyn within the block and keep its messages; restore the setting afterwards."""
    said, before = StringIO(), module.config.printToConsole
    try:
        with redirect_stdout(said), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Exudyn's own hints; what matters ends in an error text
            module.config.printToConsole = True
            yield said
    finally:
        module.config.printToConsole = before


CTRL_C_TEXTS = ("KeyboardInterrupt", "returned a result with an exception set")
"""What an error says where Ctrl-C met a function of Python that Exudyn calls, or Exudyn itself."""
SOLVERS = {
    "generalized-alpha": ("GeneralizedAlpha", 2),
    "index2": ("TrapezoidalIndex2", 2),
    "rk44": ("RK44", 4),
    "dopri5": ("DOPRI5", 5),
    "rk67": ("RK67", 6),
}
"""Name -> (name in Exudyn, order of the error in the step)."""

IMPLICIT_SOLVERS = ("generalized-alpha", "index2")  # solvers that take constraints

PULSES_MAX, LONG_RUN_WORK = 128, 1024
"""Records of a run at most, where fewer samples are asked for; body-steps between them at least (5 ms or more)."""

LINEAR_SOLVERS = {"dense": "EXUdense", "sparse": "EigenSparse", "full-pivot": "EigenDense"}
"""Linear solver -> name in Exudyn; "full-pivot" leaves out equations that repeat others."""


@dataclass(frozen=True)
class Scheme:
    """Integration scheme of Exudyn.

    ``solver``: a key of `SOLVERS`; ``spectral_radius``: of generalized-alpha, 0 to 1; 1 does not damp and can blow
    up; ``linear``: a key of `LINEAR_SOLVERS`; ``tolerance``: of Newton's iterations, relative; absolute 1e-2 of it, as
    Exudyn has them. Of the steps that dopri5 chooses, relative and absolute; ``adaptive``: let dopri5 choose its
    steps, none longer than the given ones; only the end is a sample then.
    """

    solver: str = "generalized-alpha"
    spectral_radius: float = 0.8
    linear: str = "dense"
    tolerance: float = 1e-8
    adaptive: bool = False

    def __post_init__(self) -> None:
        for name, known in (("solver", SOLVERS), ("linear", LINEAR_SOLVERS)):
            if getattr(self, name) not in known:
                raise InputError(
                    f"{name} {getattr(self, name)!r} is unknown; give one of {', '.join(map(repr, known))}"
                )
        if not 0.0 <= self.spectral_radius <= 1.0:
            raise InputError(f"spectral_radius {self.spectral_radius} is not a share; give 0 <= spectral_radius <= 1")
        if self.adaptive and self.solver != "dopri5":
            raise InputError(f"solver {self.solver!r} has fixed steps; adaptive=True goes with 'dopri5'")
        if not self.tolerance > 0.0:
            raise InputError(f"tolerance {self.tolerance} is not positive; give a number > 0")

    @property
    def implicit(self) -> bool:
        """Return whether the scheme takes constraints."""
        return self.solver in IMPLICIT_SOLVERS

    def __str__(self) -> str:
        if not self.implicit:
            return SOLVERS[self.solver][0] + (f", its own steps to {self.tolerance:g}" if self.adaptive else "")
        radius = f", spectral radius {self.spectral_radius:g}" if self.solver == "generalized-alpha" else ""
        return f"{SOLVERS[self.solver][0]}{radius}, modified Newton to {self.tolerance:g}, {self.linear} linear solver"

    def records(self, steps: int, samples: int, bodies: int) -> int:
        """Return the number of records per sample: up to `PULSES_MAX` in a long run, so that Ctrl-C is noticed between
        them.

        ValueError for samples between steps that dopri5 chooses.
        """
        if self.adaptive:
            if samples > 1:
                raise InputError(f"{samples} samples: steps that dopri5 chooses do not end on them; give samples=1")
            return 1
        most = max(1, min(PULSES_MAX, steps * bodies // LONG_RUN_WORK) // samples)
        return next(k for k in range(most, 0, -1) if steps // samples % k == 0)

    def settings(self, module: Any, start: float, t_end: float, steps: int, records: int) -> Any:
        """Return `SimulationSettings`: equal steps, records evenly among them; no files, nothing on the terminal."""
        out = module.SimulationSettings()
        out.solution.file.write = False
        out.solution.sensors.writePeriod = (t_end - start) / records
        integration, alpha = out.timeIntegration, out.timeIntegration.generalizedAlpha
        integration.startTime, integration.endTime, integration.numberOfSteps = start, t_end, steps
        integration.solverType = getattr(module.DynamicSolverType, SOLVERS[self.solver][0])
        integration.automaticStepSize, integration.adaptiveStep = self.adaptive, False  # no step is cut in silence
        bound = self.tolerance if self.adaptive else 1e30  # dopri5 judges its error at fixed steps too, and stops
        integration.absoluteTolerance = integration.relativeTolerance = bound
        alpha.spectralRadius = self.spectral_radius
        alpha.computeInitialAccelerations = False  # given, see `Equations.begin_with_accelerations`
        alpha.useNewmark = alpha.useIndex2Constraints = self.solver == "index2"
        newton = integration.newton
        newton.useModifiedNewton = True  # the Jacobian is kept while iterations converge
        newton.relativeTolerance, newton.absoluteTolerance = self.tolerance, 1e-2 * self.tolerance
        out.linearSolver.solverType = getattr(module.LinearSolverType, LINEAR_SOLVERS[self.linear])
        out.linearSolver.ignoreSingularJacobian = self.linear == "full-pivot"
        return out

    def open(self, module: Any) -> Any:
        """Return a solver of Exudyn."""
        return module.MainSolverImplicitSecondOrder() if self.implicit else module.MainSolverExplicit()


def opened(module: Any, mbs: Any, start: float) -> Any:
    """Return an initialised solver, for the matrices at the start."""
    solver = module.MainSolverImplicitSecondOrder()
    with quiet(module) as said:
        if not solver.InitializeSolver(mbs, Scheme().settings(module, start, start + 1.0, 1, 1)):
            raise EngineFailed(f"Exudyn does not start: {last_words(said.getvalue())}")
    return solver


def march(module: Any, mbs: Any, scheme: Scheme, start: float, t_end: float, steps: int, records: int) -> float:
    """Integrate, see `Scheme.settings`; return the seconds of the time loop.

    EngineFailed with the last lines of what Exudyn said.
    """
    solver, settings = scheme.open(module), scheme.settings(module, start, t_end, steps, records)
    with quiet(module) as said:
        try:
            fine = solver.InitializeSolver(mbs, settings)
            began = time.perf_counter()
            fine = fine and solver.SolveSteps(mbs, settings)
            seconds = time.perf_counter() - began
            solver.FinalizeSolver(mbs, settings)
        except (RuntimeError, ValueError, SystemError, module.ExudynError) as error:
            if any(sign in str(error) for sign in CTRL_C_TEXTS):
                raise KeyboardInterrupt from None
            raise EngineFailed(f"Exudyn stopped: {last_words(str(error) + said.getvalue())}") from None
    if not fine:
        when = f" at t = {mbs.systemData.GetTime():.6g} s"
        raise EngineFailed(f"Exudyn stopped{when}: {last_words(solver.GetErrorString() + said.getvalue())}")
    return seconds


def last_words(text: str) -> str:
    """Return the message of Exudyn on one line of at most 300 characters, without places in files."""
    text = re.sub(r"\[Python file [^]]*\]", "", text)
    words = " ".join(text.replace("*", " ").replace("=", " ").split())[:300] or "it gave no reason"
    return words + ("; rows that repeat each other need linear='full-pivot'" if "singular" in words else "")


def check_samples(found: Array, start: float, t_end: float, records: int, *values: Array) -> Array:
    """Return the times of all records; raise EngineFailed if one is missing or anything is not finite."""
    t = np.linspace(start, t_end, records + 1)
    if len(found) != len(t) or np.abs(found - t).max() > 1e-6 * (t[1] - t[0]):
        raise EngineFailed(f"Exudyn kept {len(found)} records of {len(t)}, the last at t = {found[-1]:.6g} s")
    for x in values:
        bad = ~np.isfinite(x.reshape(len(t), -1)).all(axis=1)
        if bad.any():
            raise EngineFailed(f"Exudyn: not finite from t = {t[np.argmax(bad)]:.6g} s on; give more steps")
    return t
