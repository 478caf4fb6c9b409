"""Equations of small motions about an equilibrium or a steady motion, as one matrix A."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np
import scipy.linalg

from ..base.checks import number, reporting_linalg_errors, short_repr
from ..base.concurrency import on_one_thread
from ..base.errors import InputError
from ..base.style import Told
from ..compiler.cache_folder import mark_warm
from ..compiler.first_run import announce_compilation
from ..constraints.poses.pose_equations import closed
from ..equations.compiled import Compiled, Switches, compile_system, modes_at
from ..equations.jacobian import RANK_TOLERANCE, displacement_units
from ..equations.tree import build_spanning_tree
from ..mechanism.measures import Measure, check_members
from ..mechanism.mechanism import Mechanism
from ..mechanism.state import State
from ..results.record import RunOptions
from ..run.friction import check_slipping
from ..run.simulation import accelerations_at, check_state, check_system
from .steady_motion import Generator, Units, check_signals, find_generator, natural_units
from .variations import (
    COMPLEX_STEP,
    Field,
    Tangent,
    Variations,
    directions,
    loads_and_rates,
    solve,
    tangent_space,
)

CORNER_STEP = 1e-8  # [m, rad, m/s, rad/s, 1] to both sides of a state: far above rounding, far below any motion
CORNER_JUMP = 1e-6  # [1] of the slopes: far above rounding; smooth laws differ by less, or by what falls with the step
SLOPE_MIN = 1e-3  # [1] of the largest slope: smaller ones may be rounding, as forces along an axis that is not loaded
SINGULAR_VALUE_ROUNDING = 1e-13  # [1] of the norm of A: singular values that rounding makes of zero


@on_one_thread
def spectrum(A: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return eigenvalues and vectors (columns) of a dimensionless matrix, zeros divided out first.

    Cyclic coordinates leave Jordan blocks of zeros, of which an eigenvalue solver makes 1e-8, or 1e-5 where blocks are
    longer. Here null spaces are split off one by one, ``Q'AQ = [[N, X], [0, B]]`` with N nilpotent, so zeros are exact
    and B has no others. The vectors of zeros span the null spaces of A, A^2, ...; the first ones are eigenvectors.
    """
    n, k = A.shape[0], 0
    Q, cut = np.eye(n), SINGULAR_VALUE_ROUNDING * np.linalg.norm(A, 2)
    while k < n:
        _, s, Vt = scipy.linalg.svd((Q.T @ A @ Q)[k:, k:])
        null = int((s <= cut).sum())
        if not null:
            break
        Q[:, k:] = Q[:, k:] @ np.roll(Vt, null, axis=0).T
        k += null
    T = Q.T @ A @ Q
    values, W = scipy.linalg.eig(T[k:, k:]) if k < n else (np.zeros(0), np.zeros((0, 0)))
    N, X = T[:k, :k], T[:k, k:]
    top = [np.linalg.solve(value * np.eye(k) - N, X @ w) for value, w in zip(values, W.T, strict=True)]
    upper = np.array(top).reshape(values.size, k).T
    vectors = Q @ np.block([[np.eye(k), upper], [np.zeros((n - k, k)), W]]).astype(complex)
    values = np.r_[np.zeros(k), values].astype(complex)
    order = sorted(range(n), key=lambda i: (sorting(values[i]), i))
    return values[order], vectors[:, order]


def sorting(value: complex) -> tuple[int, int, bool]:
    """Return the key that sorts by frequency, then growth, the conjugate last; rounding does not change the order."""
    return round(abs(value.imag) / 1e-9), round(value.real / 1e-9), value.imag < 0.0


@dataclass(frozen=True, eq=False, repr=False)
class Linearization(Told):
    """Linear equations ``x_dot = A x`` of small deviations from a motion; see `mbsd3d.Linearization`."""

    compiled: Compiled
    state: State
    generator: Generator
    space: Tangent
    units: Units
    full: np.ndarray  # (n_x, n_x) A of the states x
    A: np.ndarray
    residual: float
    outputs: tuple[Measure, ...] = ()
    L: np.ndarray | None = None  # (outputs, n_x) y = L x

    @property
    def system(self) -> Mechanism:
        """Return the system that was linearised."""
        return self.compiled.system

    @property
    def states(self) -> tuple[str, ...]:
        """Return the names of the states or outputs."""
        return tuple(x.label for x in self.outputs) or self.space.names(self.system)

    @property
    def state_units(self) -> tuple[str, ...]:
        """Return the units of `states`."""
        return tuple(x.unit for x in self.outputs) or self.space.unit_names(self.compiled.model)

    @cached_property
    def scale(self) -> np.ndarray:
        """Return the sizes (n,) of the states that belong to a motion of one model length."""
        x = self.units.x[self.space.chosen]
        return x if self.L is None else np.linalg.norm(self.L * x, axis=1)

    @cached_property
    def spectrum(self) -> tuple[np.ndarray, np.ndarray]:
        """Return (eigenvalues, vectors of the states as columns)."""
        values, vectors = spectrum(self.A * self.scale / self.scale[:, None] / self.units.rate)
        return values * self.units.rate, vectors * self.scale[:, None]

    @property
    def eigenvalues(self) -> np.ndarray:
        """Return the eigenvalues [1/s] sorted by frequency, then real part."""
        return self.spectrum[0]

    def deviation(self, value: complex, vector: np.ndarray) -> np.ndarray:
        """Return (N,) X of all bodies for a vector of states, or of outputs: L x = y, (A - s) x least."""
        if self.L is None:
            return self.space.E @ vector
        x = self.units.x[self.space.chosen]
        shifted = self.full * x / x[:, None] / self.units.rate - value / self.units.rate * np.eye(x.size)
        L = self.L * x / self.scale[:, None]
        seen, unseen = np.linalg.pinv(L) @ (vector / self.scale), scipy.linalg.null_space(L)
        if unseen.shape[1]:
            seen = seen - unseen @ np.linalg.lstsq(shifted @ unseen, shifted @ seen, rcond=1e-12)[0]
        return self.space.E @ (x * seen)


@reporting_linalg_errors("linearize")
@on_one_thread  # small dense algebra: more threads only wait for each other
def linearize_at(
    system: Mechanism,
    state: State,
    *,
    outputs: Sequence[Measure] | None = None,
    tolerance: float = 1e-8,
    switches: Switches | None = None,
) -> Linearization:
    """Linearise the equations of motion; arguments and errors as `mbsd3d.linearize`."""
    check_system(system, "linearize")
    tolerance = number(tolerance, "linearize: tolerance", positive=True)
    outputs = checked_outputs(system, outputs)
    found, motion = analyse(system, state, outputs, tolerance, switches or Switches())
    return with_outputs(replace(found, outputs=outputs), motion, tolerance) if outputs else found


class SteadyMotion(NamedTuple):
    """Variations of the equations at two states of one steady motion."""

    field: Field
    at: Variations
    later: Variations
    Q: np.ndarray  # (N, N) rotation of X up to the later state


def analyse(
    system: Mechanism, state: State, measures: tuple[Measure, ...], tolerance: float, switches: Switches
) -> tuple[Linearization, SteadyMotion]:
    """Return the linear equations of all states, and the variations they come from, with those of the measures."""
    check_signals(system)
    check_state(state, "linearize", needed=True)
    options = RunOptions(switches=switches)
    start = accelerations_at(system, state, options).state(0)  # refuses a state that does not meet the joints
    compiled = compile_system(system, measures, options.switches, modes_at(system, start))
    announce_compilation("linearisation")
    field = Field(compiled, start, len(measures))
    check_slipping(compiled, field.real, field.y, start.t, "linearize")
    at = field.at(field.t, field.y)
    space = tangent_space(compiled, at)
    if not space.E.shape[1]:
        raise InputError("linearize: joints and drivers leave no degree of freedom, nothing can deviate; free a joint")
    check_regular(field, space)
    units = natural_units(compiled.model, at, space)
    check_corners(field, space, units)
    generator, later, Q = find_generator(field, at, space, units, tolerance)
    whole, error = matrix_of(compiled, at, space, generator, units, tolerance)
    mark_warm("linearisation")
    error = max(error, generator.residual)
    found = Linearization(compiled, start, generator, space, units, whole, whole, error)
    return found, SteadyMotion(field, at, later, Q)


def checked_outputs(system: Mechanism, outputs: Sequence[Measure] | None) -> tuple[Measure, ...]:
    """Return the measures, after a check that they are of parts of this system."""
    if isinstance(outputs, Measure):
        outputs = (outputs,)
    if not isinstance(outputs, Sequence | None) or isinstance(outputs, str):
        raise InputError(
            f"linearize: outputs = {short_repr(outputs)} is not a sequence; give a list of mbsd3d.measures"
        )
    for x in outputs or ():
        if not isinstance(x, Measure):
            raise InputError(f"linearize: outputs: {short_repr(x)} is not a measure; build one with mbsd3d.measures")
        check_members(system, x, "linearize: outputs")
        if x.joint is not None:
            raise InputError(f"linearize: outputs: {x.label} is not a function of the states alone; give others")
    return tuple(outputs or ())


def check_regular(field: Field, space: Tangent) -> None:
    """Raise an error where the rank of the rows is not the same all around: small motions are not linear there."""
    model, chosen = field.compiled.model, field.rows_at(field.t, field.y)
    tree, random = build_spanning_tree(model, field.real, chosen), np.random.default_rng(0)
    unit = displacement_units(model.length, model.body.size)
    X = space.E[: unit.size, : space.configuration] @ random.normal(size=space.configuration)
    for step in 0.02 * X / np.abs(X / unit).max(initial=1e-300) * np.array([[1.0], [-1.0]]):
        y = closed(model, field.real, tree, field.t, field.y, step)
        beside = None if y is None else field.rows_at(field.t, y).size
        if beside != chosen.size:
            there = "do not close" if y is None else f"have rank {beside}"
            raise InputError(
                f"linearize: singular position: the joints' rows have rank {chosen.size} here and {there} beside it, "
                "so small motions are not linear; move away from the dead centre"
            )


def check_corners(field: Field, space: Tangent, units: Units) -> None:
    """Raise an error for a force whose law has a corner at the state, as a damper with two slopes at rest.

    Derivatives along a displacement, and along a change of velocities, are compared on both sides: of a smooth law
    their difference falls with the step.
    """
    compiled = field.compiled
    tree = build_spanning_tree(compiled.model, field.real, field.rows_at(field.t, field.y), complex)

    def of_all(y: np.ndarray) -> np.ndarray:
        solve(compiled.model, field.data, tree, field.t, y)
        moving = field.data.body["acceleration"][: compiled.model.body.size].ravel()
        return np.concatenate([moving, field.data.state_rate[: compiled.model.z_work]]).imag

    x = np.random.default_rng(0).normal(size=space.chosen.size) * units.x[space.chosen]
    moves = directions(compiled.model, field.y) @ space.E
    for part in (slice(0, space.configuration), slice(space.configuration, None)):
        move = moves[:, part] @ x[part]
        move /= np.abs(move).max(initial=1e-300)
        if not has_corner(of_all, field.y, move):
            continue
        for i, force in enumerate(compiled.system.forces):
            if has_corner(partial(slope_of_force, field, i), field.y, move):
                raise InputError(
                    f"linearize: the law of {type(force).__name__} '{compiled.system.name(force)}' has a corner at "
                    "this state, with another slope on each side, so small motions are not linear; linearise beside "
                    "it, or give a law that is smooth there"
                )


def has_corner(slope: Callable[[np.ndarray], np.ndarray], y: np.ndarray, move: np.ndarray) -> bool:
    """Return True where slopes (imaginary parts) along a move differ on both sides of y, however small the step is."""

    def jump(step: float) -> np.ndarray:
        after, before = (slope(y + (side * step + 1j * COMPLEX_STEP) * move) for side in (1.0, -1.0))
        size = np.abs(after) + np.abs(before)
        return np.abs(after - before) / np.maximum(size, max(SLOPE_MIN * size.max(initial=0.0), 1e-300))

    wide, narrow = jump(CORNER_STEP), jump(0.01 * CORNER_STEP)
    return bool(((narrow > CORNER_JUMP) & (narrow > 0.5 * wide)).any())


def slope_of_force(field: Field, i: int, y: np.ndarray) -> np.ndarray:
    """Return the imaginary parts of loads and internal-state rates of force element i at a complex state."""
    alone = field.compiled.forces_alone(slice(i, i + 1))
    return loads_and_rates(alone, field.loaded_alone(alone, y, complex), field.t).imag


def matrix_of(
    compiled: Compiled, at: Variations, space: Tangent, generator: Generator, units: Units, tolerance: float
) -> tuple[np.ndarray, float]:
    """Return (A, largest residual of (F - [Omega]x) E = E A): the tangent space is carried into itself."""
    transported = (at.F - generator.transport(compiled.model.body.size, compiled.model.z_work)) @ space.E
    A = transported[space.chosen]
    columns = units.x[space.chosen]
    left = np.abs((transported - space.E @ A) * columns / units.x[:, None]).max() / units.rate
    if left > 10.0 * tolerance:
        raise InputError(
            f"linearize: what the joints allow is not the same all along the motion (residual {left:.2g}); "
            "linearise about an equilibrium or a steady motion"
        )
    return A, float(left)


def with_outputs(found: Linearization, motion: SteadyMotion, tolerance: float) -> Linearization:
    """Eliminate what the outputs do not depend on: return the unique A_y with L A = A_y L."""
    _, at, later, Q = motion
    x, E = found.units.x[found.space.chosen], found.space.E
    L = at.L @ E
    size = np.linalg.norm(L * x, axis=1)
    names = [f"'{measure.label}'" for measure in found.outputs]
    for name, measure, value in zip(names, found.outputs, at.outputs, strict=True):
        if measure.kind == "distance" and value == 0.0:
            raise InputError(f"linearize: output {name} is zero, where a distance has no derivative; give a position")
    changed = np.abs((later.L @ Q @ E - L) * x).max(axis=1)
    for name, length, change in zip(names, size, changed, strict=True):
        if length == 0.0 or change > 10.0 * tolerance * length:
            why = "does not depend on the states" if length == 0.0 else "is not the same function all along the motion"
            raise InputError(f"linearize: output {name} {why}; leave it out or give another")
    scaled, A = L * x / size[:, None], found.full * x / x[:, None] / found.units.rate
    s = scipy.linalg.svdvals(scaled)
    if len(names) > x.size or s[-1] <= RANK_TOLERANCE * s[0]:
        raise InputError(f"linearize: the outputs {', '.join(names)} depend on each other; leave one out")
    A_y = scaled @ A @ np.linalg.pinv(scaled)
    left = np.abs(scaled @ A - A_y @ scaled).max(axis=1)
    k = int(np.argmax(left))
    if left[k] > 10.0 * tolerance * max(1.0, np.abs(A_y).max()):
        raise InputError(
            f"linearize: the outputs do not close: the rate of {names[k]} depends on more than the outputs (residual "
            f"{left[k]:.2g}); add what it depends on, e.g. rates of the angles"
        )
    A_y *= found.units.rate * size[:, None] / size
    return replace(found, L=L, A=A_y, residual=max(found.residual, float(left[k])))
