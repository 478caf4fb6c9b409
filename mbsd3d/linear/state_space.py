"""State-space models of small motions: from input signals to measures, accelerations, reactions and efforts.

    x' = A x + B0 u + B1 u' + B2 u'',   y = C x + D0 u + D1 u' + D2 u''      x: states of the linearisation

has u' and u'' only where inputs prescribe motions. With z = x - B2 u' - (B1 + A B2) u it becomes

    z' = A z + B u,   y = C z + D u + D1 u' + D2 u'',   B = B0 + A B1 + A^2 B2,
    D = D0 + C (B1 + A B2),   and C B2 added to D1.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike

from ..base.checks import as_tuple, check_choice, check_size, floats, number, reporting_linalg_errors, short_repr
from ..base.concurrency import on_one_thread
from ..base.errors import InputError
from ..base.style import Told
from ..base.wording import counted
from ..equations.compiled import Switches
from ..mechanism.mechanism import Mechanism
from ..mechanism.signals.signal import Input
from ..mechanism.state import State
from ..results.record import RunOptions
from ..run.simulation import accelerations_at, check_system
from .inputs_outputs import (
    Matrices,
    Output,
    Wanted,
    checked_wanted,
    input_unit,
    matrices,
    measures_of,
    names_of,
    outputs_of,
    particular,
    turned,
    with_derivatives,
)
from .linearization import SteadyMotion, analyse, spectrum
from .modes import ModalAnalysis, mode_of
from .steady_motion import later_state
from .variations import Variations

if TYPE_CHECKING:
    import scipy.signal
    from control import StateSpace as ControlModel

POLE_ROUNDING = 1e-12  # [1] of the fastest rate: a frequency nearer to a pole than that is at the pole
RESIDUE_ROUNDING = 1e-9  # [1] of the sizes of its factors: a residue below that is none, the pole does not show
FEEDTHROUGH_ROUNDING = 1e-12  # [1] of the size of an output: what rounding makes of no dependence on u' or u''
FREQUENCY_COUNT = 601  # [1] frequencies of a Bode plot: lightly damped peaks show
SEEN_ROUNDING = 1e-12  # [1] of A: what rounding leaves of a state that no output sees, some 1e-15, is below it
RANK_ROUNDING = 1e-10  # [1] of the largest singular value: rank decisions for zeros


@dataclass(frozen=True, eq=False, repr=False)
class FrequencyResponse(Told):
    """Frequency response of a `StateSpace`; see `mbsd3d.FrequencyResponse`."""

    w: np.ndarray  # (n,) [rad/s]
    H: np.ndarray  # (n, outputs, inputs) complex
    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    output_units: tuple[str, ...]
    input_units: tuple[str, ...]
    at_poles: tuple[tuple[float, str], ...]  # (frequency [rad/s], mode) where entries of H are infinite

    def __repr__(self) -> str:
        """Return size and range, and where H is infinite."""
        sizes = counted(len(self.outputs), "output"), counted(len(self.inputs), "input")
        count = counted(self.w.size, "frequency")
        lines = [f"<frequency response: {', '.join(sizes)}, {count} {self.w.min():g} ... {self.w.max():g} rad/s>"]
        return "\n".join([*lines, *(f"infinite at {w:g} rad/s, a pole: {mode}" for w, mode in self.at_poles)])


@dataclass(frozen=True, eq=False, repr=False)
class StateSpace(Told):
    """Linear model ``z' = A z + B u, y = C z + D u + D1 u' + D2 u''``; see `mbsd3d.StateSpace`."""

    linearization: ModalAnalysis
    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    D1: np.ndarray
    D2: np.ndarray
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    state_units: tuple[str, ...]
    input_units: tuple[str, ...]
    output_units: tuple[str, ...]
    scale: np.ndarray  # (n,) sizes of the states in a motion of one model length
    rate: float  # [1/s] fastest of stiffness, damping, rotation, gravity
    input_scale: np.ndarray  # (k,) sizes of the inputs that cause such a motion
    orders: tuple[int, ...]  # of the derivatives of each input that act: 0 of a load, 1 of a speed, 2 of a motion

    @property
    def proper(self) -> bool:
        """Return True if outputs depend on the inputs alone, not on u' and u''."""
        return not (self.D1.any() or self.D2.any())

    def select(
        self,
        outputs: Sequence[str | int] | str | int | None = None,
        inputs: Sequence[str | int] | str | int | None = None,
    ) -> Self:
        """Return the model of some outputs and inputs, given by name or number; None = all."""
        rows, columns = index(self.outputs, outputs, "outputs"), index(self.inputs, inputs, "inputs")
        both = np.ix_(rows, columns)
        return replace(
            self, B=self.B[:, columns], C=self.C[rows], D=self.D[both], D1=self.D1[both], D2=self.D2[both],
            inputs=tuple(self.inputs[k] for k in columns), input_units=tuple(self.input_units[k] for k in columns),
            outputs=tuple(self.outputs[k] for k in rows), output_units=tuple(self.output_units[k] for k in rows),
        )  # fmt: skip

    @property
    def scaled(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return dimensionless (A, B, C): states over `scale`, time times `rate`."""
        x = self.scale
        return self.A * x / x[:, None] / self.rate, self.B / x[:, None] / self.rate, self.C * x

    @cached_property
    def seen(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return dimensionless (A, B, C) of the combinations of states that outputs depend on.

        A heading or a place that no output sees would leave its own rounding over w, to the power of its drift.
        """
        A, B, C = self.scaled
        V = seen_states(A, C)
        return V @ A @ V.T, V @ B, C @ V.T

    @cached_property
    def poles(self) -> np.ndarray:
        """Return the eigenvalues of A [1/s], by frequency, then real part; zeros are exact."""
        return spectrum(self.scaled[0])[0] * self.rate

    @cached_property
    def zeros(self) -> np.ndarray:
        """Return the invariant zeros [1/s] of a model with as many outputs as inputs."""
        if len(self.inputs) != len(self.outputs):
            raise InputError(
                f"zeros: {counted(len(self.outputs), 'output')} and {counted(len(self.inputs), 'input')}; "
                "zeros are those of a square model: "
                "give .select(outputs=..., inputs=...).zeros"
            )
        model = self if self.proper else driven_by_acceleration(self)
        A, B, C = model.scaled
        return invariant_zeros(A, B, C, model.D) * self.rate

    def frequency_response(self, w: ArrayLike) -> FrequencyResponse:
        """Return ``H = C (i w - A)^-1 B + D + i w D1 - w^2 D2`` at frequencies w (n,) [rad/s].

        At a pole on the axis, as w = 0 with a coordinate that nothing holds, entries that show it are infinite, and
        `FrequencyResponse.at_poles` names the mode; other entries are their limits.
        """
        given = np.atleast_1d(floats(w, "frequency_response: w", "frequencies in rad/s"))
        if given.ndim != 1 or not given.size:
            raise InputError(f"frequency_response: w has shape {given.shape}; give one or more frequencies in rad/s")
        check_size(given, "frequency_response: w")
        A, B, C = self.scaled
        seen_A, seen_B, seen_C = self.seen
        values, vectors = spectrum(A)
        H, poles = np.empty((given.size, *self.D.shape), complex), []
        for k, omega in enumerate(given.tolist()):
            s = 1j * omega / self.rate
            near = np.abs(values - s) <= POLE_ROUNDING * max(1.0, abs(s))
            if near.any():
                H[k], motion = at_pole(A, B, C, s, vectors, near)
                if motion is not None:
                    poles.append((omega, self.name_of(1j * omega, motion * self.scale)))
            else:
                H[k] = seen_C @ np.linalg.solve(s * np.eye(len(seen_A)) - seen_A, seen_B.astype(complex))
            H[k] += self.D + 1j * omega * self.D1 - omega**2 * self.D2
        return FrequencyResponse(given, H, self.outputs, self.inputs, self.output_units, self.input_units, tuple(poles))

    def name_of(self, s: complex, vector: np.ndarray) -> str:
        """Return the name of what moves most in the mode of a pole, given by its states (n,)."""
        own = vector[: len(self.linearization.states)]
        if not np.abs(own / self.scale[: own.size]).max() > 1e-9 * np.abs(vector / self.scale).max():
            return "the prescribed motion"
        return mode_of(self.linearization, s, own.astype(complex)).label

    def step(self, t: ArrayLike) -> np.ndarray:
        """Return the outputs (samples, outputs, inputs) after a unit step of each input, at equally spaced t from 0."""
        t = floats(t, "step: t", "times [s]")
        if t.ndim != 1 or t.size < 2 or t[0] != 0.0 or not np.allclose(np.diff(t), t[-1] / (t.size - 1), rtol=1e-9):
            raise InputError("step: t must start at 0 with equal steps; give e.g. numpy.linspace(0.0, 5.0, 501)")
        from scipy import signal  # a quarter of a second: only who asks for it waits for it

        A, B, C, D = self.proper_matrices("step")
        found = np.empty((t.size, *D.shape))
        for j in range(D.shape[1]):
            one = signal.StateSpace(A, B[:, [j]], C, D[:, [j]])
            found[:, :, j] = signal.lsim(one, np.ones(t.size), t)[1].reshape(t.size, -1)
        return found

    def to_scipy(self) -> "scipy.signal.StateSpace":
        """Return the `scipy.signal.StateSpace`."""
        from scipy import signal  # only who asks for it waits for it

        return signal.StateSpace(*self.proper_matrices("to_scipy"))

    def to_control(self) -> "ControlModel":
        """Return the `control.StateSpace` of the package python-control, with the names of states, inputs, outputs."""
        given = self.proper_matrices("to_control")
        try:
            import control
        except ImportError:
            raise InputError(
                "to_control: python-control is not installed; pip install control, or use to_scipy()"
            ) from None
        names = {key: [x.replace(".", "_") for x in getattr(self, key)] for key in ("states", "inputs", "outputs")}
        return control.ss(*given, **names)

    def proper_matrices(self, what: str) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return (A, B, C, D), or raise an error for outputs that depend on u' or u''."""
        if self.proper:
            return self.A, self.B, self.C, self.D
        row = int(np.argmax(np.abs(self.D1).max(axis=1) + np.abs(self.D2).max(axis=1)))
        raise InputError(
            f"{what}: output '{self.outputs[row]}' depends on rate or acceleration of a prescribed motion, which "
            '(A, B, C, D) cannot hold; leave it out, or give state_space(..., driver="acceleration")'
        )

    def __repr__(self) -> str:
        """Return names, units and poles."""
        sizes = (len(self.states), "state"), (len(self.inputs), "input"), (len(self.outputs), "output")
        rows = [", ".join(counted(*size) for size in sizes)]
        for title, names, units in (
            ("input", self.inputs, self.input_units), ("output", self.outputs, self.output_units),
        ):  # fmt: skip
            rows += [f"{title:>7}  {name} [{unit}]" for name, unit in zip(names, units, strict=True)]
        kept = [s for s in self.poles if s.imag >= 0.0]
        tiny = 1e-9 * self.rate
        text = [f"{s.real if abs(s.real) > tiny else 0.0:.6g}" + (f" +- {s.imag:.6g}i" if s.imag else "") for s in kept]
        return "\n".join([*rows, f"  poles  {', '.join(text)} [1/s]"])


def index(names: tuple[str, ...], wanted: Any, what: str) -> list[int]:
    """Return the numbers of outputs or inputs given by name or number."""
    if wanted is None:
        return list(range(len(names)))
    found = []
    for x in [wanted] if isinstance(wanted, str | int) else as_tuple(wanted, f"select: {what}", "names or numbers"):
        k = names.index(x) if isinstance(x, str) and x in names else x
        if isinstance(k, bool) or not isinstance(k, int | np.integer) or not -len(names) <= k < len(names):
            raise InputError(f"select: {what}: {short_repr(x)} is not one of {', '.join(map(repr, names))}")
        found.append(int(k) % len(names))
    return found


def seen_states(A: np.ndarray, C: np.ndarray) -> np.ndarray:
    """Return an orthonormal basis (k, n), in rows, of what C, C A, C A^2, ... depend on."""
    size, least = np.linalg.norm(C, axis=1), SEEN_ROUNDING * max(1.0, float(np.linalg.norm(A, 2)))
    V, new = np.zeros((0, len(A))), C[size > 0.0] / size[size > 0.0, None]
    while len(V) < len(A):
        for _ in range(2):  # a second time for what rounding leaves of the first
            new = new - new @ V.T @ V
        _, s, rows = np.linalg.svd(new, full_matrices=False)
        fresh = rows[s > least]
        if not len(fresh):
            break
        V, new = np.vstack([V, fresh]), fresh @ A
    return V


def at_pole(
    A: np.ndarray, B: np.ndarray, C: np.ndarray, s: complex, vectors: np.ndarray, near: np.ndarray
) -> tuple[np.ndarray, np.ndarray | None]:
    """Return (C (s - A)^-1 B at a pole, the states that grow fastest): infinite where the pole shows, else the limit.

    ``vectors`` split A into the part of the pole and the rest, which is regular there. None where nothing shows.
    """
    left = np.linalg.inv(vectors)
    b, c = left @ B, C @ vectors
    block = left @ A @ vectors
    N = block[np.ix_(near, near)] - s * np.eye(near.sum())
    rest = np.linalg.solve(s * np.eye((~near).sum()) - block[np.ix_(~near, ~near)], b[~near])
    H = c[:, ~near] @ rest
    largest = np.outer(np.linalg.norm(c, axis=1), np.linalg.norm(b, axis=0))
    term, infinite, fastest = b[near], np.zeros(H.shape, bool), None
    for _ in range(int(near.sum())):  # (s' - N)^-1 = 1 / s' + N / s'^2 + ...
        shows = np.abs(c[:, near] @ term) > RESIDUE_ROUNDING * largest
        if shows.any():
            fastest = vectors[:, near] @ term[:, int(np.argmax(shows.any(axis=0)))]
        infinite |= shows
        term = N @ term
    return np.where(infinite, complex(np.inf), H), fastest


def usual_frequencies(poles: np.ndarray) -> np.ndarray:
    """Return frequencies (n,) [rad/s] from a tenth of the slowest pole beside zero to ten times the fastest."""
    sizes = np.abs(poles[poles != 0.0])
    low, high = (sizes.min(), sizes.max()) if sizes.size else (1.0, 1.0)
    return np.geomspace(0.1 * low, 10.0 * high, FREQUENCY_COUNT)


@on_one_thread
def invariant_zeros(A: np.ndarray, B: np.ndarray, C: np.ndarray, D: np.ndarray) -> np.ndarray:
    """Return the eigenvalues of the motions that inputs can keep out of all outputs.

    V, the largest space with an input such that C x + D u = 0 and A x + B u stays in V, is found from all of space by
    steps; there is no rounding at infinity, where a pencil has the zeros that it lacks.
    """
    columns = np.linalg.norm(np.vstack([B, D]), axis=0)
    columns[columns == 0.0] = 1.0
    rows = np.linalg.norm(np.hstack([C, D / columns]), axis=1)[:, None]
    rows[rows == 0.0] = 1.0
    B, C, D = B / columns, C / rows, D / columns / rows
    n = len(A)
    V = np.eye(n)
    while True:
        W = scipy.linalg.null_space(V.T) if V.shape[1] < n else np.zeros((n, 0))
        inside = np.hstack([W.T, np.zeros((W.shape[1], B.shape[1]))])
        conditions = np.vstack([np.hstack([C, D]), np.hstack([W.T @ A, W.T @ B]), inside])
        pairs = scipy.linalg.null_space(conditions, rcond=RANK_ROUNDING)
        new = scipy.linalg.orth(pairs[:n], rcond=RANK_ROUNDING) if pairs.shape[1] else np.zeros((n, 0))
        if new.shape[1] == V.shape[1]:
            break
        V = new
    if not V.shape[1]:
        return np.zeros(0, complex)
    u = np.linalg.lstsq(np.vstack([D, W.T @ B]), -np.vstack([C @ V, W.T @ A @ V]), rcond=RANK_ROUNDING)[0]
    return spectrum(V.T @ (A @ V + B @ u))[0]


@reporting_linalg_errors("state_space")
@on_one_thread
def state_space_at(
    system: Mechanism, state: State, inputs: Sequence[Input | str] | None, outputs: Sequence[Wanted], *,
    driver: str = "position", tolerance: float = 1e-8,
) -> StateSpace:  # fmt: skip
    """Return the state-space model; arguments and errors as `mbsd3d.state_space`."""
    check_system(system, "state_space")
    check_choice(driver, ("position", "acceleration"), "state_space: driver")
    tolerance = number(tolerance, "state_space: tolerance", positive=True)
    names, wanted = names_of(system, inputs), checked_wanted(system, outputs)
    linear, motion = analyse(system, state, measures_of(wanted), tolerance, Switches())
    start = accelerations_at(system, linear.state, RunOptions())
    found = outputs_of(motion.field, wanted, start)
    model = build(ModalAnalysis.of(linear), motion, names, found, tolerance)
    return driven_by_acceleration(model) if driver == "acceleration" else model


def build(
    linear: ModalAnalysis, motion: SteadyMotion, names: Sequence[str], outputs: list[Output], tolerance: float
) -> StateSpace:
    """Return the model whose inputs are the signals themselves."""
    field, at, later, Q = motion
    compiled, space = linear.compiled, linear.space
    transport = linear.generator.transport(compiled.model.body.size, compiled.model.z_work)
    t, y, _ = later_state(field, at, linear.generator, linear.units)
    here = with_derivatives(matrices(field, at, field.t, field.y, names, outputs), at.F - transport, outputs)
    there = with_derivatives(matrices(field, later, t, y, names, outputs), later.F - transport, outputs)
    P = np.zeros_like(here.G)
    P[:2] = particular(field, at, space, here.effects, names)
    sizes = Sizes.of(linear, at, here, P, outputs)
    check_constant(linear, motion, names, outputs, (here, there), P, sizes, tolerance)
    A, C = linear.A, here.Y @ space.E
    B, D = ((at.F - transport) @ P + here.G)[:, space.chosen], here.Y @ P + here.Z
    shift = B[1] + A @ B[2]  # z = x - B2 u' - (B1 + A B2) u
    D = np.stack([D[0] + C @ shift, D[1] + C @ B[2], D[2]])
    D[1:][np.abs(D[1:]) * sizes.u * sizes.powers[1:] <= FEEDTHROUGH_ROUNDING * sizes.y[:, None]] = 0.0
    holonomic, speed = here.effects.motion.any(axis=0), here.effects.speed.any(axis=0)
    return StateSpace(
        linearization=linear, A=A, B=B[0] + A @ shift, C=C, D=D[0], D1=D[1], D2=D[2],
        states=linear.states, inputs=tuple(names), outputs=tuple(x for one in outputs for x in one.names),
        state_units=linear.state_units, input_units=tuple(input_unit(compiled, name) for name in names),
        output_units=tuple(x for one in outputs for x in one.units),
        scale=linear.scale, rate=linear.units.rate, input_scale=sizes.u,
        orders=tuple(np.where(holonomic, 2, np.where(speed, 1, 0)).tolist()),
    )  # fmt: skip


class Sizes(NamedTuple):
    """Sizes of inputs and outputs that belong to a motion of one model length."""

    u: np.ndarray  # (k,)
    y: np.ndarray  # (p,)
    powers: np.ndarray  # (3, 1, 1) of the rate, of u, u', u''

    @classmethod
    def of(
        cls, linear: ModalAnalysis, at: Variations, here: Matrices, P: np.ndarray, outputs: Sequence[Output]
    ) -> "Sizes":
        """Return the sizes: of inputs by the motion they cause, or where joints hold by the loads."""
        length, rate, x = linear.compiled.model.length, linear.units.rate, linear.units.x[:, None]
        mass = sum(body.mass for body in linear.system.bodies) or 1.0
        powers = rate ** np.arange(3.0)[:, None, None]
        motion = np.maximum(np.abs(P / x * powers), np.abs(here.G / x * powers) / rate).max(axis=(0, 1))
        load = np.abs(here.effects.load * np.repeat([1.0, 1.0 / length], 3)).max(axis=(1, 2), initial=0.0)
        effect = np.maximum(motion, load / (mass * length * rate**2))
        y = []
        for one in outputs:
            a, b, c = one.powers
            seen = 0.0 if one.read else np.linalg.norm(at.L[one.measure] * x[:, 0]) * (rate if one.derivative else 1.0)
            y += [length**a * rate**b * mass**c if one.read else seen or 1.0] * len(one.names)
        return cls(1.0 / np.where(effect > 0.0, effect, 1.0), np.array(y), powers)


def check_constant(
    linear: ModalAnalysis,
    motion: SteadyMotion,
    names: Sequence[str],
    outputs: Sequence[Output],
    found: tuple[Matrices, Matrices],
    P: np.ndarray,
    sizes: Sizes,
    tolerance: float,
) -> None:
    """Raise an error for inputs or outputs that act or are seen in another way at a later time of a steady motion."""
    here, there = found
    later, Q, rate, x = motion.later, motion.Q, linear.units.rate, linear.units.x[:, None]
    u, scale = sizes.u * sizes.powers, linear.compiled.model.row["scale"][:, None]
    effects, turned_P = there.effects, Q @ P
    acts = [np.abs((Q.T @ there.G - here.G) * u / x).max(axis=(0, 1)) / rate]
    for left, order in (
        (later.C @ turned_P[0] - effects.motion, 0), (later.D @ turned_P[0] - effects.speed, 0),
        (later.D @ turned_P[1] - effects.motion, 1),
    ):  # fmt: skip
        acts.append(np.abs(scale * left * u[order]).max(axis=0, initial=0.0))
    worst = np.max(acts, axis=0)
    if worst.max() > 10.0 * tolerance:
        raise InputError(
            f"state_space: input '{names[int(np.argmax(worst))]}' does not act in the same way all along the motion, "
            "as a force on a point that turns; leave it out"
        )
    back = turned(outputs, Q).T
    change = back @ there.Y @ Q - here.Y
    moves = [linear.space.E * linear.units.x[linear.space.chosen], P[0] * u[0], P[1] * u[1]]
    seen = np.abs(np.hstack([*(change @ X for X in moves), *((back @ there.Z - here.Z) * u)]))
    worst = seen.max(axis=1) / sizes.y
    if worst.max() > 10.0 * tolerance:
        label = [name for one in outputs for name in one.names][int(np.argmax(worst))]
        raise InputError(f"state_space: output '{label}' is not the same function all along the motion; leave it out")


def driven_by_acceleration(model: StateSpace) -> StateSpace:
    """Return the model whose prescribed motions u and u' are states, and u'' the input (of speeds: u and u')."""
    k, p = len(model.inputs), len(model.outputs)
    first = np.flatnonzero(np.array(model.orders) >= 1)  # u is a state,
    second = np.flatnonzero(np.array(model.orders) == 2)  # u' too
    n, m, r = len(model.A), first.size, second.size
    A, B = np.zeros((n + m + r, n + m + r)), np.zeros((n + m + r, k))
    A[:n, :n], A[:n, n : n + m] = model.A, model.B[:, first]
    C = np.hstack([model.C, model.D[:, first], model.D1[:, second]])
    D, D1 = model.D.copy(), np.zeros((p, k))
    for j, order in enumerate(model.orders):
        if order:
            B[:n, j], D[:, j] = 0.0, (model.D1, model.D2)[order - 1][:, j]
            B[n + m + np.flatnonzero(second == j) if order == 2 else n + np.flatnonzero(first == j), j] = 1.0
        else:
            B[:n, j] = model.B[:, j]
    for i, j in enumerate(second.tolist()):
        A[n + np.flatnonzero(first == j), n + m + i] = 1.0
    words, per = ("{}", "rate of {}", "acceleration of {}"), ("", "/s", "/s^2")
    names, units = model.inputs, model.input_units

    def labelled(which: Sequence[int], order: int) -> tuple[tuple[str, ...], tuple[str, ...]]:
        return tuple(words[order].format(names[j]) for j in which), tuple(units[j] + per[order] for j in which)

    (u, u_unit), (v, v_unit) = labelled(first.tolist(), 0), labelled(second.tolist(), 1)
    return replace(
        model, A=A, B=B, C=C, D=D, D1=D1, D2=D1.copy(), states=(*model.states, *u, *v),
        state_units=(*model.state_units, *u_unit, *v_unit),
        inputs=tuple(words[order].format(name) for order, name in zip(model.orders, names, strict=True)),
        input_units=tuple(unit + per[order] for order, unit in zip(model.orders, units, strict=True)),
        scale=np.concatenate([model.scale, model.input_scale[first], model.input_scale[second] * model.rate]),
        input_scale=model.input_scale * model.rate ** np.array(model.orders, float), orders=(0,) * k,
    )  # fmt: skip
