"""The certificate of a result: what was checked, how large the errors are, and why it fails if it does.

Every check is made from the stored samples with the true equations, whatever the teaching switches dropped:
constraint residuals, energy against work, momentum against impulse, Newton-Euler residuals, acceleration rows.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .kernels.batch import newton_euler, row_defects


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
    switches: Any
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
            f"  {'ok  ' if c.passed else 'FAIL'} {c.name:<22} {c.error:9.2e}  (limit {c.limit:.0e})" for c in self.checks
        ]
        lines += [f"  {text}" for text in (*self.notes, *((self.stopped_by,) if self.stopped_by else ()))]
        if self.error is not None:
            order = "" if self.order is None else f", observed order {self.order:.2f}"
            lines.append(f"  estimated global error {self.error:.2e} (model lengths, radians){order}")
        return "\n".join(lines)


def certify(solution: Any) -> Certificate:
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


def notes(solution: Any) -> tuple[str, ...]:
    """Facts that are neither good nor bad."""
    events = solution.record.rank_events
    return tuple(f"rank event at t = {t:.6g} s: {rank} rows kept ({why})" for t, rank, why, _ in events)


def residual_checks(solution: Any) -> list[Check]:
    """Constraint residuals at the samples."""
    model, drift = solution.compiled.model, solution.drift()
    reach = 1.0 + float(np.abs(solution.arrays["q"][..., :3]).max(initial=0.0)) / model.length
    speed = max(float(np.abs(solution.arrays["v"]).max(initial=0.0)), 1.0)
    floor = max(solution.record.tolerance, 1e-12 * reach)
    scale = max(model.length, 1.0)
    return [
        Check("joint gaps", float(drift.position.max(initial=0.0)) / scale, floor, "joints drift apart"),
        Check("joint velocities", float(drift.velocity.max(initial=0.0)) / (scale * speed), floor, "J v = b is violated"),
    ]


def balance_checks(solution: Any, limit: float) -> list[Check]:
    """Energy against work, momentum against impulse; relative to the greatest exchanged amount."""
    model, energy, momentum = solution.compiled.model, solution.energy(), solution.momentum()
    if solution.record.kinematic:
        return []  # no ODE, so nothing was integrated along; the Newton-Euler residuals are the check
    z = solution.arrays["z"]
    scale = max(float(energy.kinetic.max(initial=0.0)), float(np.ptp(energy.potential)), 1e-300)
    gap = energy.total - energy.total[:1] - (energy.work - energy.work[:1])
    impulse = z[:, model.z_impulse :]
    checks = [Check("energy balance", float(np.abs(gap).max(initial=0.0)) / scale, limit, "energy appears or vanishes")]
    sizes = momentum_sizes(solution)
    for name, value, j, size in (
        ("momentum balance", momentum.linear, 0, sizes[0]),
        ("angular momentum", momentum.angular, 3, sizes[1]),
    ):
        lost = value - value[:1] - (impulse[:, j : j + 3] - impulse[:1, j : j + 3])
        checks.append(Check(name, float(np.abs(lost).max(initial=0.0)) / size, limit, "an inertial term is missing"))
    return checks


def momentum_sizes(solution: Any) -> tuple[float, float]:
    """Greatest sums of |p| and |L| over bodies: the scales of the balances."""
    linear, angular = np.zeros(solution.t.size), np.zeros(solution.t.size)
    for body in solution.system.bodies:
        p = body.mass * np.linalg.norm(solution.velocity(body), axis=1)
        linear += p
        linear += body.mass * np.linalg.norm(body.com) * np.linalg.norm(solution.omega(body), axis=1)
        spin = np.linalg.norm(solution.omega_body(body) @ body.inertia, axis=1)
        angular += spin + (np.linalg.norm(solution.position(body), axis=1) + solution.compiled.model.length) * p
    floor = 1e-300
    linear_size = max(float(linear.max(initial=0.0)), floor)
    angular_size = max(float(angular.max(initial=0.0)), linear_size * solution.compiled.model.length, floor)
    return max(linear_size, angular_size / (1e3 * solution.compiled.model.length)), angular_size


def equation_checks(solution: Any) -> list[Check]:
    """Newton-Euler residual per body, and rows against the accelerations, with the true terms."""
    compiled, arrays, t = solution.compiled, solution.arrays, solution.t
    data, n = compiled.data(), len(solution.system.bodies)
    model = compiled.model._replace(gamma=1.0, stabilisation=0)
    acceleration = np.ascontiguousarray(arrays["acceleration"])
    out = np.zeros((t.size, n, 4))
    newton_euler(model, data, t, arrays["state"], acceleration, arrays["lam"], out)
    # floors: centripetal and gyroscopic terms of the greatest spin, so that free and balanced bodies have a scale too
    mass, spin = solution.system.total_mass(), float(np.abs(arrays["v"][..., 3:]).max(initial=0.0))
    speed = float(np.abs(arrays["v"][..., :3]).max(initial=0.0))
    floor = mass * (model.length * spin**2 + speed * spin) + 1e-300
    force = max(float(out[..., 2].max(initial=0.0)), floor)
    moment = max(float(out[..., 3].max(initial=0.0)), floor * model.length, 1e-3 * force * model.length)
    error = max(float(out[..., 0].max(initial=0.0)) / force, float(out[..., 1].max(initial=0.0)) / moment)
    worst = int(np.argmax((out[..., 0] / force + out[..., 1] / moment).max(axis=0))) if t.size else 0
    name = solution.system.name(solution.system.bodies[worst])
    checks = [Check("Newton-Euler", error, 1e-8, f"the equations of body '{name}' are not met")]
    if model.row.size:
        defect = np.zeros(t.size)
        row_defects(model, data, t, arrays["state"], acceleration, defect)
        size = max(float(np.abs(acceleration).max(initial=0.0)), 1e-300)
        tolerance = max(1e-8, solution.record.tolerance)
        error = float(defect.max(initial=0.0)) * max(model.length, 1.0) / size
        checks.append(Check("acceleration rows", error, tolerance, "accelerations tear the joints apart"))
    return checks
