"""The certificate of a result: the checks, the size of the errors, and why it fails if it does.

Every check is made from the stored samples with the true equations, whatever the teaching switches dropped:
constraint residuals, energy against work, momentum against impulse, Newton-Euler residuals, acceleration rows.
"""

from dataclasses import dataclass, field

import numpy as np

from ..base.checks import shown
from ..base.errors import NameMissingError
from ..base.style import html_text
from ..dynamics.batch import newton_euler, row_defects
from ..equations.compiled import Switches
from ..integrators.method import Method
from ..mechanism.forces.custom import SavedForce
from .record import Record
from .run_samples import RunSamples

USEFUL = 1e-2  # model lengths or radians: a motion further off than a hundredth is of no use, whatever was asked for
ADDED = 1e3  # times rtol is what local errors may add up to over a run
# Pivot of a singular position, where rows with singular values below LET_GO are; by how much they may then gape, and
# accelerations miss them: three times the most at poses 1e-8 ... 1e-3 rad off change points of 1 to 40 four-bars.
PASSED, LET_GO, MAY_GAPE, MAY_MISS = 1e-4, 1e-4, 1e-10, 1e-5
# What rounding leaves in the balances, at any rtol: over the least pivot of a run, and at most, however near it came to
# singular positions; three times the worst of 420 runs of four-bars with windows, each over some twenty of them.
ROUNDED, MOST_ROUNDED, REGULAR = 3e-12, 5e-7, 1e-9
TRAVEL = 1e-6  # of the energy of a machine that flies on as a whole is a size too: it is known to rounding only
LOCAL = 10.0  # times rtol a step: a hundred times what it may err


@dataclass(frozen=True)
class Check:
    """One check: a relative error against its limit."""

    name: str
    error: float
    limit: float
    meaning: str

    @property
    def passed(self) -> bool:
        """True if the error is within its limit."""
        return bool(self.error <= self.limit)


@dataclass(frozen=True)
class Certificate:
    """How a result was computed and how far it can be trusted.

    ``passed`` is True if every check is within its limit and the run reached its end; ``failures`` says what is not.
    The checks are of local consistency: whether every sample meets the equations and the balances. How far the motion
    is from the true one is the global error: ``error``, ``order`` and ``doubling`` (the time [s] in which
    errors double, if they grow exponentially) are None until `Solution.estimate` has compared with tighter runs.
    """

    method: str
    rtol: float
    steps: int
    rejected: int
    evaluations: int
    svd_calls: int
    rank_events: tuple
    seconds: float
    switches: Switches
    checks: tuple[Check, ...]
    stopped_by: str | None = None
    error: float | None = None
    order: float | None = None
    doubling: float | None = None
    notes: tuple[str, ...] = field(default=())

    @property
    def passed(self) -> bool:
        """True if no check fails and the run was not interrupted."""
        return not self.failures

    @property
    def failures(self) -> tuple[str, ...]:
        """One sentence per check that failed."""
        found = [f"{c.name} {c.error:.2e} exceeds {c.limit:.0e}: {c.meaning}" for c in self.checks if not c.passed]
        if self.error is not None and not self.error <= USEFUL:
            remedy = "tighten rtol or shorten the step" if self.doubling is None else "shorten the run"
            found.append(
                f"global error {self.error:.2e} exceeds {USEFUL:.0e}: {self.growth or 'steps are coarse'}; {remedy}"
            )
        if self.stopped_by and self.stopped_by.startswith("interrupted"):
            found.append(self.stopped_by)
        return tuple(found)

    @property
    def growth(self) -> str:
        """What errors do in an unstable motion, in words; empty for one that is not, or not known to be."""
        return "" if self.doubling is None else f"the motion is unstable, errors double every {self.doubling:.3g} s"

    def __getitem__(self, name: str) -> Check:
        """A check by its name."""
        for check in self.checks:
            if isinstance(name, str) and check.name == name:
                return check
        raise NameMissingError(f"no check {shown(name)}; there are {', '.join(repr(c.name) for c in self.checks)}")

    def __str__(self) -> str:
        dropped = [k for k in ("gyroscopic", "centripetal", "gamma") if not getattr(self.switches, k)]
        head = f"{'passed' if self.passed else 'FAILED'}: {self.method}, rtol {self.rtol:g}, {self.steps} steps "
        head += f"({self.rejected} rejected), {self.evaluations} evaluations, {self.seconds:.3g} s"
        lines = [head]
        if dropped or self.switches.stabilisation != "projection":
            text = ", ".join(f"without {k}" for k in dropped) or "all terms"
            lines.append(f"  teaching: {text}; stabilisation {self.switches.stabilisation}")
        lines.append(f"  local consistency: {'ok' if all(c.passed for c in self.checks) else 'FAILED'}")
        lines.append(f"  global error: {self.global_error}")
        lines += [
            f"  {'ok  ' if c.passed else 'FAIL'} {c.name:<22} {c.error:9.2e}  (limit {c.limit:.0e})"
            for c in self.checks
        ]
        lines += [f"  {text}" for text in (*self.notes, *((self.stopped_by,) if self.stopped_by else ()))]
        return "\n".join(lines)

    @property
    def global_error(self) -> str:
        """What is known of the distance from the true motion."""
        if self.error is None:
            return "unknown; solution.estimate() finds it"
        order = "" if self.order is None else f", observed order {self.order:.2f}"
        verdict = "ok" if self.error <= USEFUL else f"FAILED, limit {USEFUL:.0e}"
        growth = f"; {self.growth}" if self.growth else ""
        return f"{verdict}, {self.error:.2e} (model lengths, radians){order}{growth}"

    def _repr_html_(self) -> str:
        return html_text(str(self))


def certify(solution: RunSamples) -> Certificate:
    """Make all checks of a solution."""
    record = solution.record
    limit = drift_limit(record)
    checks = [*residual_checks(solution), *balance_checks(solution, limit), *equation_checks(solution)]
    return Certificate(
        method=str(record.method),
        rtol=record.rtol,
        steps=record.steps,
        rejected=record.rejected,
        evaluations=record.evaluations,
        svd_calls=record.svd_calls,
        rank_events=tuple(record.rank_events),
        seconds=record.seconds,
        switches=record.switches,
        checks=tuple(checks),
        stopped_by=record.stopped_by,
        notes=notes(solution),
    )


def drift_limit(record: Record) -> float:
    """What errors of the steps may add up to, in the scales of the run: never more than they explain or is useful."""
    explained = LOCAL * record.rtol * record.steps if record.method.dt is None and record.method.order else np.inf
    rounding = max(REGULAR, min(MOST_ROUNDED, ROUNDED / max(record.nearest, ROUNDED)))
    return min(USEFUL, max(min(ADDED * record.rtol, explained), rounding))


def gaping(record: Record) -> float:
    """How far joints may gape that the integration holds, by Baumgarte's terms; 0 where projection closes them."""
    return drift_limit(record) if record.switches.stabilisation == "baumgarte" else 0.0


def notes(solution: RunSamples) -> tuple[str, ...]:
    """Singular positions, rank events, and checks that could not be made."""
    events = solution.record.rank_events
    found = [f"rank event at t = {t:.6g} s: {rank} rows kept ({why})" for t, rank, why, _ in events]
    if solution.record.nearest < PASSED:
        inexact = "accelerations and reactions there are not exact"
        found.append(f"the run passes a singular position; it goes on along the tangent of the motion; {inexact}")
    found += [text for joint in solution.system.joints for text in joint.notes(solution)]
    return (*found, *(f"Newton-Euler not checked: {name} was saved without its function" for name in lost(solution)))


def lost(solution: RunSamples) -> list[str]:
    """Names of the forces whose functions were not saved."""
    system = solution.system
    return [f"force '{system.name(force)}'" for force in system.forces if isinstance(force, SavedForce)]


def residual_checks(solution: RunSamples) -> list[Check]:
    """Constraint residuals at the samples."""
    model, drift, record = solution.compiled.model, solution.drift(), solution.record
    reach = 1.0 + float(np.abs(solution.arrays["q"][..., :3]).max(initial=0.0)) / model.length
    speed = max(float(np.abs(solution.arrays["v"]).max(initial=0.0)), 1.0)
    floor, near = max(record.tolerance, 1e-12 * reach, gaping(record)), record.nearest < PASSED
    gap, miss = (MAY_GAPE, LET_GO * drift_limit(record)) if near else (0.0, 0.0)  # of rows let go: not projected
    scale = max(model.length, 1.0)
    gaps, rates = (float(values.max(initial=0.0)) / scale for values in (drift.position, drift.velocity / speed))
    return [
        Check("joint gaps", gaps, max(floor, gap), "joints drift apart"),
        Check("joint velocities", rates, max(floor, miss), "J v = b is violated"),
    ]


@dataclass(frozen=True)
class Scales:
    """Characteristic sizes of a run that the absolute errors are divided by; never zero."""

    acceleration: float
    force: float
    moment: float
    momentum: float
    angular_momentum: float
    energy: float


def scales_of(solution: RunSamples) -> Scales:
    """Sizes from the run itself, with floors from gravity, so that a mechanism at rest has scales too."""
    arrays, system, length = solution.arrays, solution.system, solution.compiled.model.length
    spin = float(np.abs(arrays["v"][..., 3:]).max(initial=0.0))
    speed = float(np.abs(arrays["v"][..., :3] - arrays["v"][..., :3].mean(axis=1, keepdims=True)).max(initial=0.0))
    speed = max(speed, length * spin)
    a = float(np.abs(arrays["acceleration"][..., :3]).max(initial=0.0))
    a = max(a, float(np.linalg.norm(system.gravity)), length * spin**2) or 1.0
    mass = system.total_mass() or 1.0
    reach = float(np.abs(arrays["q"][..., :3]).max(initial=0.0)) + length
    absolute = float(np.abs(arrays["v"][..., :3]).max(initial=0.0)) + length * spin
    momentum = mass * max(absolute, 1e-3 * np.sqrt(a * length))
    speed = max(speed, np.sqrt(1e-3 * a * length))
    return Scales(
        acceleration=a,
        force=mass * a,
        moment=mass * a * length,
        momentum=momentum,
        angular_momentum=momentum * reach,
        energy=mass * max(speed * max(speed, absolute), TRAVEL * absolute**2),  # a speed v that errs by dv: m v dv
    )


def balance_checks(solution: RunSamples, limit: float) -> list[Check]:
    """Energy against work, momentum against impulse."""
    model, energy, momentum = solution.compiled.model, solution.energy(), solution.momentum()
    if solution.record.kinematic:
        return []  # no ODE, so nothing was integrated along; the Newton-Euler residuals are the check
    scale, impulse = scales_of(solution), solution.arrays["z"][:, model.z_impulse :]
    gap = change(energy.total) - change(energy.work)
    lost = change(momentum.linear) - change(impulse[:, :3])
    turned = change(momentum.angular) - change(impulse[:, 3:])
    return [
        Check("energy balance", largest(gap) / scale.energy, limit, energy_meaning(solution.record.method)),
        Check("momentum balance", largest(lost) / scale.momentum, limit, "an inertial term is missing"),
        Check("angular momentum", largest(turned) / scale.angular_momentum, limit, "an inertial term is missing"),
    ]


def energy_meaning(method: Method) -> str:
    """The likely cause of an energy defect."""
    if method.rho < 1.0:
        return f"energy vanishes, by numerical damping of rho = {method.rho:g} if by nothing else: shorten the step"
    return "energy appears or vanishes"


def change(values: np.ndarray) -> np.ndarray:
    """Difference from the first sample."""
    return values - values[:1]


def largest(values: np.ndarray) -> float:
    """Largest absolute value, 0 for none."""
    return float(np.abs(values).max(initial=0.0))


def equation_checks(solution: RunSamples) -> list[Check]:
    """Newton-Euler residual per body, and rows against the accelerations, with the true terms."""
    compiled, arrays, t = solution.compiled, solution.arrays, solution.t
    data, n, scale = compiled.data(), len(solution.system.bodies), scales_of(solution)
    model = compiled.model._replace(gamma=1.0, stabilisation=0)
    out = np.zeros((t.size, n, 4))
    coordinates = np.ascontiguousarray(arrays["coordinate"])
    newton_euler(model, data, t, arrays["state"], coordinates, arrays["acceleration"], arrays["lam"], out)
    force, moment = max(largest(out[..., 2]), scale.force), max(largest(out[..., 3]), scale.moment)
    relative = np.maximum(out[..., 0] / force, out[..., 1] / moment)
    worst = int(np.argmax(relative.max(axis=0))) if t.size else 0
    meaning = f"the equations of body '{solution.system.name(solution.system.bodies[worst])}' are not met"
    gap = gaping(solution.record)  # Baumgarte's terms correct accelerations by it; `saddle` takes joints as closed
    checks = [] if lost(solution) else [Check("Newton-Euler", largest(relative), max(1e-8, gap), meaning)]
    if model.row.size:
        defect = np.zeros(t.size)
        row_defects(model, data, t, arrays["state"], coordinates, arrays["acceleration"], defect)
        singular = MAY_MISS if solution.record.nearest < PASSED else 0.0
        limit = max(1e-8, solution.record.tolerance, gap, singular, min(rounding_of_turning(solution, scale), 1e-5))
        error = largest(defect) * model.length / scale.acceleration
        checks.append(Check("acceleration rows", error, limit, "accelerations tear the joints apart"))
    return checks


def rounding_of_turning(solution: RunSamples, scale: Scales) -> float:
    """Rounding of the moments of the run as an acceleration of the body that turns most easily, relative.

    Joint forces F at an arm L cancel in the moment about the centre of mass of a small body to eps F L, which turns it
    by eps F L / I.
    """
    moments = [np.linalg.eigvalsh(body.inertia)[0] for body in solution.system.bodies if body.mass > 0.0]
    least = min((moment for moment in moments if moment > 0.0), default=np.inf)
    return 4.0 * np.finfo(float).eps * scale.moment / least * solution.compiled.model.length / scale.acceleration
