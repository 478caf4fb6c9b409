"""Modes of a linearisation: numbers, labels and shapes that move."""

from dataclasses import dataclass, fields
from functools import cached_property
from typing import Self

import numpy as np

from ..base.checks import number, short_repr, whole
from ..base.concurrency import on_one_thread
from ..base.errors import AssemblyError, InputError
from ..base.style import Told
from ..constraints.poses.pose_equations import closed
from ..equations.at_state import coordinate_row, load_state
from ..equations.tree import build_spanning_tree
from ..mechanism.bodies import Body
from ..mechanism.joints import Joint
from ..results.motion import Motion
from .linearization import Linearization

SAMPLES_MAX = 100_000  # [samples] of the motion of a mode

MOTION_NAMES = ("x", "y", "z", "rotation about x", "rotation about y", "rotation about z")


@dataclass(frozen=True, eq=False, repr=False)
class Mode(Told):
    """One mode; see `mbsd3d.api.small_motions.Mode`."""

    linearization: "ModalAnalysis"
    eigenvalue: complex
    translation: np.ndarray
    rotation: np.ndarray
    vector: np.ndarray  # of the states (or outputs), same scale

    @property
    def frequency(self) -> float:
        """Return the damped frequency [Hz], 0 if it does not oscillate."""
        return abs(self.eigenvalue.imag) / (2.0 * np.pi)

    @property
    def natural_frequency(self) -> float:
        """Return |eigenvalue| / 2 pi [Hz]."""
        return abs(self.eigenvalue) / (2.0 * np.pi)

    @property
    def damping_ratio(self) -> float:
        """Return -Re / |eigenvalue|, negative where the motion grows; 0 for a zero eigenvalue."""
        return -self.eigenvalue.real / abs(self.eigenvalue) if self.eigenvalue else 0.0

    @property
    def time_to_double(self) -> float:
        """Return the time in which the amplitude doubles [s], infinite unless the mode grows."""
        return float(np.log(2.0) / self.eigenvalue.real) if self.eigenvalue.real > 0.0 else np.inf

    @property
    def time_to_half(self) -> float:
        """Return the time in which the amplitude halves [s], infinite unless the mode decays."""
        return float(-np.log(2.0) / self.eigenvalue.real) if self.eigenvalue.real < 0.0 else np.inf

    def __repr__(self) -> str:
        return f"<mode: {self.label}, {self.eigenvalue:.6g} 1/s>"

    def shape(self, body: Body | str) -> tuple[np.ndarray, np.ndarray]:
        """Return the complex (translation of the centre of mass [m], rotation [rad]) of a body, world axes."""
        k = self.linearization.compiled.body_index[id(self.linearization.system.part(body))]
        return self.translation[k], self.rotation[k]

    @cached_property
    def label(self) -> str:
        """Return the largest joint coordinate, or the largest displacement of a body if joints move little."""
        compiled, system = self.linearization.compiled, self.linearization.system
        length = compiled.model.length
        moves = np.hstack([self.translation / length, self.rotation])
        found = []
        for joint, kind, gradient in self.linearization.joint_gradients:
            change = gradient @ np.hstack([self.translation, self.rotation]).ravel()
            name = f"{kind} of '{system.name(joint)}'"
            found.append((abs(change) / (length if kind == "slide" else 1.0), name))
        largest = max((size for size, _ in found), default=0.0)
        if largest > 1e-9 and largest > np.abs(moves).max() / 3.0:
            return next(name for size, name in found if size > largest * (1.0 - 1e-6))  # of equal ones the first
        if not np.abs(moves).max() > 1e-9:
            return f"{self.linearization.states[int(np.argmax(np.abs(self.vector / self.linearization.scale)))]}"
        k = int(np.argmax(np.abs(moves).ravel() > np.abs(moves).max() * (1.0 - 1e-6)))
        return f"{MOTION_NAMES[k % 6]} of '{system.name(system.bodies[k // 6])}'"

    def motion(self, amplitude: float = 0.2, cycles: float = 2.0, samples: int = 101) -> Motion:
        """Return the mechanism moving in this mode, all joints closed; a monotonic motion is shown at rest.

        ``amplitude``: the largest displacement at its largest [model lengths or radians]; ``cycles``: periods, or for a
        mode that does not oscillate time constants, for a zero eigenvalue to and fro; ``samples`` 2 ... 100 000. The
        `Motion` has ``t``, ``position``, ``orientation``, ``com`` ... by body, and ``animate``. ValueError for other
        numbers; AssemblyError if the joints do not close at so large an amplitude.
        """
        amplitude, cycles = number(amplitude, "motion: amplitude"), number(cycles, "motion: cycles", positive=True)
        samples = whole(samples, "motion: samples", 2, SAMPLES_MAX)
        value = self.eigenvalue
        rate = (abs(value.imag) / (2.0 * np.pi)) or abs(value.real) or 1.0
        t = np.linspace(0.0, cycles / rate, samples)
        wave = np.exp(value * t) if value else np.sin(2.0 * np.pi * t).astype(complex)
        wave *= amplitude / np.abs(wave).max()
        return moving_poses(self, t, wave)


def moving_poses(mode: Mode, t: np.ndarray, wave: np.ndarray) -> Motion:
    """Return poses r + Re(translation wave), exp(Re(rotation wave)) o e, then closed by the joints."""
    found, compiled = mode.linearization, mode.linearization.compiled
    model, data, n = compiled.model, compiled.data(), compiled.model.body.size
    start = load_state(compiled, data, found.state)
    tree = build_spanning_tree(model, data)
    poses = np.empty((t.size, 7 * n))
    shape = np.hstack([mode.translation, mode.rotation]).ravel()
    for k in range(t.size):
        y = closed(model, data, tree, found.state.t, start, (shape * wave[k]).real)
        if y is None:
            raise AssemblyError(
                f"motion: the joints do not close at sample {k} of the mode '{mode.label}'",
                advice="give a smaller amplitude",
            )  # fmt: skip
        poses[k] = y[: 7 * n]
    return Motion(compiled, {"t": t, "q": poses.reshape(t.size, n, 7)})


@on_one_thread
def make_modes(linearization: "ModalAnalysis") -> tuple[Mode, ...]:
    """Return the modes of all eigenvalues, one per complex pair."""
    pairs = zip(linearization.eigenvalues, linearization.spectrum[1].T, strict=True)
    return tuple(mode_of(linearization, value, vector) for value, vector in pairs if value.imag >= 0.0)


def mode_of(linearization: "ModalAnalysis", value: complex, vector: np.ndarray) -> Mode:
    """Return the mode of an eigenvalue and a vector of the states or outputs."""
    n, size = linearization.compiled.model.body.size, linearization.units.x
    X = linearization.deviation(value, vector)
    moves = np.abs(X / size)[: 6 * n]
    if moves.max() <= 1e-9 * np.abs(X / size).max():  # only velocities or internal states take part
        moves = np.abs(X / size)
    k = int(np.argmax(moves > moves.max() * (1.0 - 1e-6)))  # of equal ones the first, whatever rounding does
    factor = size[k] / X[k]
    X, vector = X * factor, vector * factor
    pose = X[: 6 * n].reshape(n, 6)
    return Mode(linearization, complex(value), pose[:, :3], pose[:, 3:], vector)


@dataclass(frozen=True, eq=False, repr=False)
class ModalAnalysis(Linearization):
    """Linearisation with its modes; see `mbsd3d.Linearization`."""

    @classmethod
    def of(cls, found: Linearization) -> Self:
        """Return the modal analysis of linear equations."""
        return cls(**{x.name: getattr(found, x.name) for x in fields(Linearization)})

    @cached_property
    def modes(self) -> tuple[Mode, ...]:
        """Return one mode per real eigenvalue and per complex pair, in the order of the eigenvalues."""
        return make_modes(self)

    def mode(self, k: int) -> Mode:
        """Return mode number k, counted from zero."""
        if not isinstance(k, int | np.integer) or not -len(self.modes) <= k < len(self.modes):
            raise InputError(
                f"linearization.mode: {short_repr(k)} is not one of the {len(self.modes)} modes "
                f"0 ... {len(self.modes) - 1}"
            )
        return self.modes[k]

    @cached_property
    def joint_gradients(self) -> list[tuple[Joint, str, np.ndarray]]:
        """Return (joint, "angle" or "slide", (6 n,) gradient with respect to (r_G, theta)) of all joints."""
        compiled, found = self.compiled, []
        data, n = compiled.data(), compiled.model.body.size
        load_state(compiled, data, self.state)
        s = data.body["s"][:n]
        for joint in self.system.joints:
            for kind, x in (("angle", joint.angle()), ("slide", joint.slide())):
                if x is not None:
                    row = coordinate_row(compiled, data, compiled.coordinate(x), self.state.t)[1].reshape(n, 6).copy()
                    row[:, 3:] += np.cross(row[:, :3], s)  # delta r_O = delta r_G + s x delta theta
                    found.append((joint, kind, row.ravel()))
        return found

    def __repr__(self) -> str:
        """Return one line per mode."""
        g = self.generator
        steady = f", turning at {np.linalg.norm(g.rotation):.6g} rad/s as a whole" if g.turning else ""
        lines = [
            f"{self.A.shape[0]} states, residual {self.residual:.1e}{steady}",
            f"{'eigenvalue [1/s]':>28} {'f [Hz]':>11} {'damping':>10}  mode",
        ]
        for mode in self.modes:
            s, damping = mode.eigenvalue, mode.damping_ratio if abs(mode.damping_ratio) > 1e-9 else 0.0
            real = s.real if damping else 0.0  # rounding is not printed
            shown = f"{real:.6g} +- {s.imag:.6g}i" if s.imag else f"{real:.6g}"
            lines.append(f"{shown:>28} {mode.natural_frequency:>11.6g} {damping:>10.4f}  {mode.label}")
        return "\n".join(lines)
