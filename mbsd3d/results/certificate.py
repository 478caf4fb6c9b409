"""The certificate of a result: what was checked, how large the errors are, and why it fails if it does.

Every check is made from the stored samples with the true equations, whatever the teaching switches dropped:
constraint residuals, energy against work, momentum against impulse, Newton-Euler residuals, acceleration rows.
"""

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from ..base.style import html_text
from ..equations.compiled import Switches
from ..integrators.method import Method
from ..kernels.batch import newton_euler, row_defects
from ..mechanism.forces.custom import SavedForce

if TYPE_CHECKING:
    from .run_result import RunResult


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
    ``error`` and ``order`` are None until `estimate` has compared with a tighter run.
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
    notes: tuple[str, ...] = field(default=())

    @property
    def passed(self) -> bool:
        """True if nothing speaks against the result."""
        return not self.failures

    @property
    def failures(self) -> tuple[str, ...]:
        """One sentence per check that failed."""
        found = [f"{c.name} {c.error:.2e} exceeds {c.limit:.0e}: {c.meaning}" for c in self.checks if not c.passed]
        if self.stopped_by and self.stopped_by.startswith("interrupted"):
            found.append(self.stopped_by)
        return tuple(found)

    def __getitem__(self, name: str) -> Check:
        """A check by its name."""
        for check in self.checks:
            if check.name == name:
                return check
        raise KeyError(f"no check '{name}'; there are {', '.join(repr(c.name) for c in self.checks)}")

    def __str__(self) -> str:
        dropped = [k for k in ("gyroscopic", "centripetal", "gamma") if not getattr(self.switches, k)]
        head = f"{'passed' if self.passed else 'FAILED'}: {self.method}, rtol {self.rtol:g}, {self.steps} steps "
        head += f"({self.rejected} rejected), {self.evaluations} evaluations, {self.svd_calls} SVD, "
        head += f"{len(self.rank_events)} rank events, {self.seconds:.3g} s"
        lines = [head]
        if dropped or self.switches.stabilisation != "projection":
            text = ", ".join(f"without {k}" for k in dropped)
            lines.append(f"  teaching: {text or 'all terms'}; stabilisation {self.switches.stabilisation}")
        lines += [
            f"  {'ok  ' if c.passed else 'FAIL'} {c.name:<22} {c.error:9.2e}  (limit {c.limit:.0e})"
            for c in self.checks
        ]
        lines += [f"  {text}" for text in (*self.notes, *((self.stopped_by,) if self.stopped_by else ()))]
        if self.error is not None:
            order = "" if self.order is None else f", observed order {self.order:.2f}"
            lines.append(f"  estimated global error {self.error:.2e} (model lengths, radians){order}")
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        return html_text(str(self))


def certify(solution: "RunResult") -> Certificate:
    """Make all checks of a solution."""
    record = solution.record
    limit = max(1e3 * record.rtol, 1e-9)  # the local error adds up over the run
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


def notes(solution: "RunResult") -> tuple[str, ...]:
    """Facts that are neither good nor bad."""
    events = solution.record.rank_events
    found = [f"rank event at t = {t:.6g} s: {rank} rows kept ({why})" for t, rank, why, _ in events]
    return (*found, *(f"Newton-Euler not checked: {name} was saved without its function" for name in lost(solution)))


def lost(solution: "RunResult") -> list[str]:
    """Names of the forces whose functions are not there any more."""
    system = solution.system
    return [f"force '{system.name(force)}'" for force in system.forces if isinstance(force, SavedForce)]


def residual_checks(solution: "RunResult") -> list[Check]:
    """Constraint residuals at the samples."""
    model, drift = solution.compiled.model, solution.drift()
    reach = 1.0 + float(np.abs(solution.arrays["q"][..., :3]).max(initial=0.0)) / model.length
    speed = max(float(np.abs(solution.arrays["v"]).max(initial=0.0)), 1.0)
    floor = max(solution.record.tolerance, 1e-12 * reach)
    scale = max(model.length, 1.0)
    return [
        Check("joint gaps", float(drift.position.max(initial=0.0)) / scale, floor, "joints drift apart"),
        Check(
            "joint velocities", float(drift.velocity.max(initial=0.0)) / (scale * speed), floor, "J v = b is violated"
        ),
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


def scales_of(solution: "RunResult") -> Scales:
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
    return Scales(
        acceleration=a,
        force=mass * a,
        moment=mass * a * length,
        momentum=momentum,
        angular_momentum=momentum * reach,
        energy=mass * max(speed**2, 1e-3 * a * length),
    )


def balance_checks(solution: "RunResult", limit: float) -> list[Check]:
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
    """What a lack of energy may come from."""
    if method.rho < 1.0:
        return f"energy vanishes, by numerical damping of rho = {method.rho:g} if by nothing else: shorten the step"
    return "energy appears or vanishes"


def change(values: np.ndarray) -> np.ndarray:
    """Difference from the first sample."""
    return values - values[:1]


def largest(values: np.ndarray) -> float:
    """Largest absolute value, 0 for none."""
    return float(np.abs(values).max(initial=0.0))


def equation_checks(solution: "RunResult") -> list[Check]:
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
    name = solution.system.name(solution.system.bodies[worst])
    meaning = f"the equations of body '{name}' are not met"
    checks = [] if lost(solution) else [Check("Newton-Euler", largest(relative), 1e-8, meaning)]
    if model.row.size:
        defect = np.zeros(t.size)
        row_defects(model, data, t, arrays["state"], arrays["acceleration"], defect)
        error, tolerance = largest(defect) * model.length / scale.acceleration, max(1e-8, solution.record.tolerance)
        checks.append(Check("acceleration rows", error, tolerance, "accelerations tear the joints apart"))
    return checks


def estimate(solution: "RunResult") -> Certificate:
    """The certificate with a global error estimate: the same run at tighter settings, compared at the samples.

    Adaptive: rtol/32 and rtol/1024; fixed steps: dt/2 and dt/4. The error is the largest difference of positions (model
    lengths) and angles [rad] from the tightest run; the order is log2 of the ratio of successive differences for fixed
    steps, and the exponent of rtol for adaptive ones.
    """
    record = solution.record
    if record.method.dt is None and record.rtol < 3.2e-12:
        raise ValueError(
            f"estimate: rtol {record.rtol:g} leaves no room for a tighter run; estimate at 1e-11 or looser"
        )
    finer, finest = refined(solution, 1), refined(solution, 2)
    first, second = distance(solution, finest), distance(finer, finest)
    factor = 32.0 if record.method.dt is None else 2.0
    order = float(np.log(first / second) / np.log(factor)) if 0.0 < second < first else None
    return replace(solution.certificate, error=first, order=order)


def refined(solution: "RunResult", level: int) -> "RunResult":
    """The run again, ``level`` times refined."""
    method = solution.record.method
    if method.dt is None:
        return solution.again(rtol=max(solution.record.rtol / 32**level, 1e-13))
    return solution.again(method=replace(method, dt=method.dt / 2**level))


def distance(one: "RunResult", other: "RunResult") -> float:
    """Largest difference of poses at common samples: positions in model lengths, rotation angles in radians."""
    a, b = one.arrays["q"], other.arrays["q"]
    shift = np.linalg.norm(a[..., :3] - b[..., :3], axis=-1) / one.compiled.model.length
    turn = 2.0 * np.minimum(
        np.linalg.norm(a[..., 3:] - b[..., 3:], axis=-1), np.linalg.norm(a[..., 3:] + b[..., 3:], axis=-1)
    )
    return float(np.maximum(shift, turn).max(initial=0.0))
