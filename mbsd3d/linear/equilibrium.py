"""Static equilibrium: the pose at which a mechanism at rest stays at rest, and its stability.

At rest (v = 0) the constrained accelerations a and the rates of the internal states z are functions of the pose alone.
With xi the degrees of freedom of velocity (v = N xi) the pose follows the flow ``xi' = a``, downhill in the metric of
M, by steps

    [ 1/d - A_qq   -A_qz ] [ d xi ]   [ a     ]
    [    -A_zq     -A_zz ] [ d z  ] = [ z_dot ]        A: exact derivatives by complex steps

that start short and end as Newton's, d -> infinity; where the flow leaves a pose (A_qq has growing directions) d stays
short, so that no step jumps onto an unstable equilibrium. After every step the joints are closed; nonholonomic rows are
followed to the second order of a step, so where a rolling body comes to rest depends on its length.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.linalg

from ..base.checks import reporting_linalg_errors
from ..base.concurrency import on_one_thread
from ..base.errors import AssemblyError, EquilibriumError, InputError
from ..base.rotations import matrix
from ..base.style import Told
from ..compiler.cache_folder import mark_warm
from ..compiler.first_run import announce_compilation
from ..constraints.assembly import moved_report
from ..constraints.poses.pose_equations import closed
from ..equations.at_state import load_rows, load_state, unmet, worst_joint
from ..equations.compiled import Compiled, compile_system
from ..equations.jacobian import displacement_units
from ..equations.tree import build_spanning_tree
from ..kernels.coordinates import remember
from ..mechanism.forces.custom import check_runnable
from ..mechanism.mechanism import Mechanism
from ..mechanism.state import State
from .linearization import linearize_at
from .modes import ModalAnalysis
from .steady_motion import Units, natural_units, varies
from .variations import Field, Tangent, Variations, tangent_space

NEWTON_STEPS_MAX = 200  # [steps] of Newton's method; a chain far from its equilibrium takes some fifty
TRAVEL_MAX = 8.0  # [sizes of the mechanism] a body may move by; what goes farther does not come to rest
# [1] accelerations over length times rate squared, at which a pose is an equilibrium; Newton's method reaches 1e-15
EQUILIBRIUM_TOLERANCE = 1e-10
STEP_GROWTH_MAX = 1e8  # [1] of the steps: more would count a free fall as rounding
STEP_TURN_MAX = 0.2  # [rad, model lengths] of a motion in one step
ROUNDING = 1e-12  # [m, rad] printed as zero
GROWTH_RATE_ROUNDING = 1e-6  # [1] of the fastest rate: growth rates that are rounding of undamped modes


@dataclass(frozen=True, eq=False)
class Equilibrium(Told):
    """Pose of static equilibrium.

    ``state`` starts runs and `linearize` (its velocities are zero); ``residual`` is the largest acceleration left, in
    units of the model's length and fastest rate; ``steps`` were taken to it; ``moved`` is the displacement of every
    body from the start of the search (distance [m], angle [rad]).

    ``stability`` is "stable" (deviations decay), "stable, undamped" (they keep oscillating), "neutral" (some go on
    without a force), "unstable", "held" (joints and drivers leave no degree of freedom), or "unknown", with ``reason``.
    """

    system: Mechanism
    state: State
    residual: float
    steps: int
    moved: dict[str, tuple[float, float]]
    freedoms: int

    @cached_property
    def linearization(self) -> ModalAnalysis | ValueError | None:
        """Return small motions about it; None if nothing can move, an error where they are not linear."""
        if not self.freedoms:
            return None
        try:
            return ModalAnalysis.of(linearize_at(self.system, self.state))
        except ValueError as error:
            return error

    @cached_property
    def _kind(self) -> tuple[str, str]:
        found = self.linearization
        if found is None:
            return "held", "joints and drivers leave no degree of freedom"
        if isinstance(found, ValueError):
            return "unknown", str(found)
        values, calm = found.eigenvalues, GROWTH_RATE_ROUNDING * found.units.rate
        k = int(np.argmax(values.real))
        if values.size and values[k].real > calm:
            return "unstable", f"{label_of(found, values[k])} grows with {values[k].real:.4g} 1/s"
        if (values == 0.0).any():
            return "neutral", f"{int((values == 0.0).sum())} eigenvalues are zero"
        if (undamped := values.real > -calm).any():
            slowest = np.abs(values.imag[undamped]).min()
            return "stable, undamped", f"the slowest swings with {slowest / (2.0 * np.pi):.4g} Hz"
        return "stable", f"the slowest dies out with {-values.real.max():.4g} 1/s"

    @property
    def stability(self) -> str:
        """Return the stability of small deviations; see the class."""
        return self._kind[0]

    @property
    def reason(self) -> str:
        """Return the reason for this judgement of stability."""
        return self._kind[1]

    def __repr__(self) -> str:
        far = max(self.moved.items(), key=lambda item: max(item[1]), default=("nothing", (0.0, 0.0)))
        shift, turn = (x if x > ROUNDING else 0.0 for x in far[1])
        path = f"'{far[0]}' moved by {shift:.4g} m and {turn:.4g} rad" if shift or turn else "nothing moved"
        return f"<equilibrium: {self.stability} ({self.reason}); {path}; residual {self.residual:.1g}>"


def label_of(found: ModalAnalysis, value: complex) -> str:
    """Return the label of the mode of an eigenvalue."""
    return min(found.modes, key=lambda mode: abs(mode.eigenvalue - value)).label


def check_rest(system: Mechanism) -> None:
    """Raise an InputError if a signal moves: a machine at rest has constant ones."""
    parts: tuple[Any, ...] = (*system.joints, *system.forces)
    for part in parts:
        signals = [x.signal for x in part.primitives] if part in system.joints else part.record().signals
        if any(signal is not None and varies(signal, 0) for signal in signals):
            raise InputError(f"equilibrium: the signal of '{system.name(part)}' varies with time; give a constant")


@reporting_linalg_errors("equilibrium")
@on_one_thread
def find_equilibrium(system: Mechanism, start: State) -> Equilibrium:
    """Find the equilibrium that the mechanism comes to from a pose; errors as `mbsd3d.System.equilibrium`."""
    check_runnable(system)
    check_rest(system)
    compiled = compile_system(system)
    announce_compilation("linearisation")
    pose = State(start.t, start.q, np.zeros_like(start.v), start.z, start.coordinates)
    data = compiled.data()
    load_state(compiled, data, pose)
    if (gap := unmet(compiled, data, pose.v, 1e-8)) is not None:
        part, residual = worst_joint(compiled, gap[0])
        if np.abs(data.row["b"]).max(initial=0.0) > 0.0:
            why, advice = "a driver keeps the mechanism moving, so it has no rest", "give its signal a constant, or 0"
        else:
            why, advice = f"the start does not meet the joints ({gap[1]})", "start from system.assemble()"
        raise AssemblyError(f"equilibrium: {why}", part=part, residual=residual, time=start.t, advice=advice)
    field = Field(compiled, pose, 0)
    y, at, space, units, size, steps = search(field)
    mark_warm("linearisation")
    n = len(system.bodies)
    values = field.real.coordinate["value"].copy()
    rest = State(start.t, y[: 7 * n], np.zeros(6 * n), y[13 * n : 13 * n + compiled.model.z_work], values)
    return Equilibrium(system, rest, size, steps, moved_report(system, start, rest), space.velocity)


def search(field: Field) -> tuple[np.ndarray, Variations, Tangent, Units, float, int]:
    """Return (y, variations, tangent space, units, residual, steps) at the equilibrium."""
    model, y = field.compiled.model, field.y.copy()
    before, growth, n = None, 1.0, model.body.size
    begin = y[: 7 * n].reshape(n, 7)[:, :3].copy()
    far = TRAVEL_MAX * (model.length + np.ptp(begin, axis=0).max())
    for step in range(NEWTON_STEPS_MAX):
        at = field.at(field.t, y)
        space = tangent_space(field.compiled, at)
        units = natural_units(model, at, space, damped=False)
        size = unrest(at, units, model.length)
        last = unrest(before, units, model.length) if before else np.inf
        if size <= 1e-14 or (size <= EQUILIBRIUM_TOLERANCE and size > 0.1 * last):
            return y, at, space, units, size, step
        growth = min(4.0 * growth, STEP_GROWTH_MAX) if size <= 1.01 * last else max(1.0, growth / 4.0)
        before = at
        if np.abs(y[: 7 * n].reshape(n, 7)[:, :3] - begin).max() > far:
            break  # it falls, or drifts away
        X, dz = direction(at, space, units, model.body.size, growth / units.rate**2)
        y = moved(field, y, X, dz)
    raise EquilibriumError(
        f"no equilibrium after {step + 1} steps: {restless(field.compiled, y, at)}", residual=size, time=field.t,
        advice="hold the mechanism by a joint, spring or contact where it gives way, or start nearer with state=",
    )  # fmt: skip


def unrest(at: Variations, units: Units, length: float) -> float:
    """Return the largest acceleration and rate of an internal state, in units of length and rate."""
    one = displacement_units(length, at.acceleration.shape[0])
    z_unit = units.x[12 * at.acceleration.shape[0] :]
    sizes = np.abs(at.acceleration.ravel()) / (one * units.rate**2), np.abs(at.z_rate) / (z_unit * units.rate)
    return float(max(x.max(initial=0.0) for x in sizes))


def direction(at: Variations, space: Tangent, units: Units, n: int, d: float) -> tuple[np.ndarray, np.ndarray]:
    """Return (X (6 n,), dz) of a step of pseudo-time d along the flow."""
    moves = slice(space.configuration, space.configuration + space.velocity)
    N = space.E[6 * n : 12 * n, moves]
    free = space.chosen[moves]  # rows of the velocities in X_dot: accelerations
    x = np.r_[units.x[free - 6 * n], units.x[12 * n :]]
    rows = np.r_[units.x[free - 6 * n], units.x[12 * n :] / units.rate]  # so that both are in units of rate^2
    A = np.block([
        [at.F[free, : 6 * n] @ N, at.F[free, 12 * n :]],
        [at.F[12 * n :, : 6 * n] @ N, at.F[12 * n :, 12 * n :]],
    ]) * x / rows[:, None] / units.rate**2  # fmt: skip
    k = free.size
    a = np.r_[at.acceleration.ravel()[free - 6 * n], at.z_rate] / rows / units.rate**2
    growing = scipy.linalg.eigvals(A[:k, :k]).real.max(initial=0.0)
    short = max(1.0 / (d * units.rate**2), 2.0 * growing)
    matrix = np.diag(np.r_[np.full(k, short), np.zeros(A.shape[0] - k)]) - A
    step = scipy.linalg.lstsq(matrix, a, cond=1e-12)[0]
    X = N @ (step[:k] * x[:k])
    one = units.x[: 6 * n]
    factor = min(1.0, STEP_TURN_MAX / max(np.abs(X / one).max(initial=0.0), 1e-300))
    return factor * X, factor * step[k:] * x[k:]


def moved(field: Field, y: np.ndarray, X: np.ndarray, dz: np.ndarray) -> np.ndarray:
    """Return the state after a step that the joints allow; it is halved until they close."""
    compiled, model = field.compiled, field.compiled.model
    n = model.body.size
    tree = build_spanning_tree(model, field.real, field.rows_at(field.t, y))
    for half in 0.5 ** np.arange(12):
        found = closed(model, field.real, tree, field.t, y, half * X)
        if found is None:
            continue
        found[13 * n : 13 * n + model.z_work] += half * dz
        load_rows(compiled, field.real, found, field.t)
        remember(model, field.real, field.t)  # angles count their turns
        field.data.coordinate[:] = field.real.coordinate
        return found
    raise AssemblyError(
        "equilibrium: the joints do not close beside this pose", time=field.t,
        advice="it is a dead centre; start from another one with state=",
    )  # fmt: skip


def restless(compiled: Compiled, y: np.ndarray, at: Variations) -> str:
    """Return the body with the largest share ``m a_G^2 + alpha' I alpha`` of the unbalanced load.

    A light part may accelerate more, in its own units, than the one that carries it away.
    """
    bodies, n = compiled.system.bodies, len(compiled.system.bodies)
    R = matrix(y[: 7 * n].reshape(n, 7)[:, 3:])
    linear, angular = at.acceleration[:, :3], at.acceleration[:, 3:]
    centre = linear + np.cross(angular, np.einsum("nij,nj->ni", R, [body.com for body in bodies]))
    own = np.einsum("nji,nj->ni", R, angular)
    shares = [x.mass * a @ a + w @ x.inertia @ w for x, a, w in zip(bodies, centre, own, strict=True)]
    i = int(np.argmax(shares))
    sizes = np.linalg.norm(linear[i]), np.linalg.norm(angular[i])
    return (
        f"body '{compiled.system.name(bodies[i])}' still accelerates by {sizes[0]:.3g} m/s^2 and {sizes[1]:.3g} rad/s^2"
    )
