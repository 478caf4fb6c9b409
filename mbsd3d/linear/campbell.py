"""Whirl frequencies of rotors over their speed, tracked by mode shape, and critical speeds.

A mode is followed from speed to speed by its shape (modal assurance criterion) and its frequency, not by its place in
the list. The sense of its orbit is that of the signed area which rotor bodies and the tips of their axes sweep: with
axis n, a displacement d = Re(d0 exp(i w t)) sweeps ``pi i n . (conj(d0) x d0) / 2`` in a turn. Of modes of one
frequency any combination is a mode; those of largest and smallest area are taken: circles forward and backward.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike
from scipy.optimize import brentq, linear_sum_assignment

from ..base.checks import floats, number, reporting_linalg_errors
from ..base.errors import AssemblyError, InputError
from ..base.rotations import matrix
from ..base.style import Told
from ..base.wording import counted
from ..constraints.velocities import with_velocities
from ..equations.at_state import load_state
from ..equations.compiled import compile_system
from ..mechanism.bodies import Body
from ..mechanism.drivers import AngleDriver, SpeedDriver
from ..mechanism.joints import Joint, coordinate_of
from ..mechanism.mechanism import Mechanism
from ..mechanism.signals.curves import Ramp
from ..mechanism.state import State
from .linearization import linearize_at
from .modes import ModalAnalysis, make_modes

SHAPE_MIN = 0.9  # [1] of the assurance criterion: below it two modes of one frequency mix, and a shape is no reference
ROTOR_SPIN_MIN = 0.5  # [1] of the spin: bodies that turn at least so fast about the axis are rotors
SENSE_MIN = 1e-3  # [1] of the largest area of an orbit: below it the orbit is a line
ZERO_FREQUENCY = 1e-9  # [1] of the fastest rate: below it a mode does not oscillate
EQUAL_FREQUENCY = 1e-8  # [1] of the fastest rate: eigenvalues nearer than that are one
ORBIT_MIN = 1e-9  # [1] of the whole motion: rotors that move less have no orbit
SPEED_ROUNDING = 1e-12  # [1] of a critical speed


class Whirl(NamedTuple):
    """One oscillating mode at one speed."""

    eigenvalue: complex  # [1/s], frequency above 0
    shape: np.ndarray  # (12 n,) displacements and rotations of all bodies, of unit norm in model lengths and radians
    sense: float  # -1 backward ... 1 forward
    label: str


class Critical(NamedTuple):
    """Speed at which a mode is excited by a multiple of the speed."""

    speed: float  # [rad/s]
    frequency: float  # [rad/s]
    whirl: str  # "forward", "backward" or "planar"
    mode: int  # column of the diagram
    label: str


@dataclass(frozen=True, eq=False, repr=False)
class Campbell(Told):
    """Whirl frequencies over the speed; see `mbsd3d.Campbell`."""

    speeds: np.ndarray  # (n,) [rad/s]
    eigenvalues: np.ndarray  # (n, k) [1/s], NaN where a mode does not oscillate
    sense: np.ndarray  # (n, k) -1 backward ... 1 forward
    labels: tuple[str, ...]
    whirls_at: Callable[[float], list[Whirl]]
    shapes: tuple[tuple[np.ndarray | None, ...], ...]  # of each speed and mode

    @property
    def frequencies(self) -> np.ndarray:
        """Return the whirl frequencies (n, k) [rad/s]."""
        return self.eigenvalues.imag

    @property
    def whirl(self) -> tuple[str, ...]:
        """Return the sense of each mode: "forward", "backward", "planar", or "mixed" where it changes with speed."""
        found = []
        for column in self.sense.T:
            names = {sense_name(x) for x in column[np.isfinite(column)]} - {"planar"}
            found.append(names.pop() if len(names) == 1 else "mixed" if names else "planar")
        return tuple(found)

    def critical_speeds(self, order: float = 1.0) -> tuple[Critical, ...]:
        """Return where a whirl frequency is ``order`` times the speed, within the range of speeds."""
        order, found = number(order, "critical_speeds: order", positive=True), []
        gap = self.frequencies - order * np.abs(self.speeds)[:, None]
        for mode, column in enumerate(gap.T):
            for i in np.flatnonzero(column[:-1] * column[1:] <= 0.0).tolist():
                if column[i] == 0.0 and i > 0:  # found as the end of the interval before
                    continue
                found.append(self.crossing(mode, i, order))
        return tuple(sorted(found, key=lambda x: x.speed))

    def crossing(self, mode: int, i: int, order: float) -> Critical:
        """Return the critical speed of a mode between speeds i and i + 1."""
        near = [x for x in (self.shapes[i][mode], self.shapes[i + 1][mode]) if x is not None]

        def nearest(speed: float) -> Whirl:
            guess = np.interp(speed, self.speeds[i : i + 2], self.frequencies[i : i + 2, mode])
            return min(self.whirls_at(speed), key=lambda x: min(distance(x, shape, guess) for shape in near))

        def gap(speed: float) -> float:
            return nearest(speed).eigenvalue.imag - order * abs(speed)

        low, high = self.speeds[i], self.speeds[i + 1]
        ends = gap(low), gap(high)
        speed = low if ends[0] == 0.0 else high if ends[1] == 0.0 else brentq(gap, low, high, rtol=SPEED_ROUNDING)
        there = nearest(speed)
        return Critical(float(speed), there.eigenvalue.imag, sense_name(there.sense), mode, there.label)

    def __repr__(self) -> str:
        """Return one line per mode and per critical speed."""
        first, last = self.speeds[0], self.speeds[-1]
        lines = [
            f"{counted(self.speeds.size, 'speed')} {first:g} ... {last:g} rad/s",
            "  whirl [rad/s] at first and last  sense     mode",
        ]
        for k, (label, whirl) in enumerate(zip(self.labels, self.whirl, strict=True)):
            ends = self.frequencies[[0, -1], k]
            lines.append(f"{ends[0]:>16.6g} {ends[1]:>16.6g}  {whirl:<8}  {label}")
        lines += [f"critical at {x.speed:.6g} rad/s, {x.whirl}: {x.label}" for x in self.critical_speeds()]
        return "\n".join(lines)


def sense_name(sense: float) -> str:
    """Return the word for the sense of an orbit."""
    return "planar" if abs(sense) < SENSE_MIN else "forward" if sense > 0.0 else "backward"


def distance(whirl: Whirl, shape: np.ndarray, frequency: float) -> float:
    """Return how much a mode differs from a shape and a frequency [rad/s]: 0 if equal."""
    change = abs(whirl.eigenvalue.imag - frequency) / max(whirl.eigenvalue.imag, frequency)
    return 1.0 - assurance(whirl.shape, shape) + change


def assurance(a: np.ndarray, b: np.ndarray) -> float:
    """Return the modal assurance criterion |a* b|^2 of two shapes of unit norm."""
    return float(np.abs(a.conj() @ b) ** 2)


def spinning_state(system: Mechanism, rest: State, rotor: Body, axis: np.ndarray, speed: float) -> State:
    """Return a state in which a rotor turns about its centre of mass at a speed [rad/s], all else as it is at rest."""
    k = next(i for i, body in enumerate(system.bodies) if body is system.part(rotor))
    v, w = rest.v.reshape(-1, 6).copy(), speed * axis
    arm = matrix(rest.q.reshape(-1, 7)[k, 3:]) @ rotor.com
    v[k] = np.concatenate([-np.cross(w, arm), w])
    return replace(rest, v=v.ravel())


def pedestal(hinge: Joint) -> list[Body]:
    """Return the body that stands still while a hinge turns: body a, if neither is the ground."""
    return [hinge.a] if isinstance(hinge.a, Body) and isinstance(hinge.b, Body) else []


def driven_at(system: Mechanism, hinge: Joint, speed: float, t: float) -> Mechanism:
    """Return a system whose drivers of a hinge turn it at a constant speed [rad/s] from where it is at a time [s]."""

    def driven(joint: Joint) -> Joint:
        if isinstance(joint, AngleDriver) and joint.hinge is hinge:
            return replace(joint, signal=Ramp(speed, float(joint.signal(t)) - speed * t))
        if isinstance(joint, SpeedDriver) and joint.joint is hinge:
            return replace(joint, speed=speed)
        return joint

    joints = [driven(joint) for joint in system.joints]
    changed = any(new is not old for new, old in zip(joints, system.joints, strict=True))
    return replace(system, joints=joints) if changed else system


def turning_state(system: Mechanism, rest: State, hinge: Joint, speed: float) -> State:
    """Return a state in which a hinge turns at a speed [rad/s] and its pedestal stands still."""
    compiled = compile_system(system)
    data = compiled.data()
    load_state(compiled, data, rest)
    still = pedestal(hinge)
    try:
        return with_velocities(compiled, data, rest, {hinge: speed}, near=rest, still=still)
    except AssemblyError as error:
        if not still:
            raise
        raise InputError(
            f"campbell: spin: '{system.name(hinge)}' cannot turn while its body a, '{still[0].name}', stands still "
            f"({error}); give the pedestal as body a of the hinge, the rotor as b"
        ) from None


def axis_of(system: Mechanism, rest: State, hinge: Joint) -> np.ndarray:
    """Return the axis (3,) of a hinge as it stands in a pose, in the sense in which its rotor turns."""
    axis = coordinate_of(hinge, "angle", "campbell: spin").axis
    for body in pedestal(hinge):
        k = next(i for i, one in enumerate(system.bodies) if one is system.part(body))
        axis = matrix(rest.q.reshape(-1, 7)[k, 3:]) @ body.local_axis(axis)
    return axis if isinstance(hinge.b, Body) else -axis


def whirls(system: Mechanism, state: State, axis: np.ndarray, speed: float) -> list[Whirl]:
    """Return the oscillating modes at a speed [rad/s] about an axis (3,), by frequency."""
    linear = ModalAnalysis.of(linearize_at(system, state))
    length, n = linear.compiled.model.length, len(system.bodies)
    spin = state.v.reshape(n, 6)[:, 3:] @ axis
    rotors = np.flatnonzero(np.abs(spin) >= ROTOR_SPIN_MIN * abs(speed)) if speed else np.arange(n)
    modes = [x for x in make_modes(linear) if x.eigenvalue.imag > ZERO_FREQUENCY * linear.units.rate]
    found = []
    for group in groups([x.eigenvalue for x in modes], EQUAL_FREQUENCY * linear.units.rate):
        shapes = np.array([np.hstack([modes[k].translation / length, modes[k].rotation]) for k in group])
        senses, turns = orbits(shapes, rotors, axis, speed)
        for sense, mixed in zip(senses, np.einsum("ji,jbk->ibk", turns, shapes), strict=True):
            shape = mixed.ravel() / np.linalg.norm(mixed)
            found.append(Whirl(modes[group[0]].eigenvalue, shape, float(sense), modes[group[0]].label))
    return found


def groups(values: list[complex], tolerance: float) -> list[list[int]]:
    """Return the indices of equal values among values that are sorted by frequency."""
    found: list[list[int]] = []
    for k, value in enumerate(values):
        if found and abs(value - values[found[-1][0]]) <= tolerance:
            found[-1].append(k)
        else:
            found.append([k])
    return found


def orbits(shapes: np.ndarray, rotors: np.ndarray, axis: np.ndarray, speed: float) -> tuple[np.ndarray, np.ndarray]:
    """Return (areas that orbits sweep in the sense of the spin over those of circles, (k, k) mixtures that do so).

    ``shapes`` (k, n, 6): displacements in model lengths and rotations of modes of one frequency.
    """
    own = shapes[:, rotors]
    d = np.concatenate([own[..., :3], np.cross(own[..., 3:], axis)], axis=1)
    area = 1j * np.einsum("ibk,jbk->ij", d.conj(), np.cross(d, axis)) * (-1.0 if speed < 0.0 else 1.0)
    size = np.einsum("ibk,jbk->ij", d.conj(), d) + ORBIT_MIN * np.einsum("ibk,jbk->ij", shapes.conj(), shapes)
    return scipy.linalg.eigh(area, size + ORBIT_MIN * np.trace(size).real * np.eye(len(size)))


@reporting_linalg_errors("campbell")
def campbell_of(at: Callable[[float], tuple[Mechanism, State]], axis: np.ndarray, speeds: ArrayLike) -> Campbell:
    """Return the diagram; ``at``: the system and its steady motion at a speed [rad/s] about an axis (3,)."""
    speeds = floats(speeds, "campbell: speeds", "two or more speeds in rad/s, ascending")
    if speeds.ndim != 1 or speeds.size < 2 or not (np.diff(speeds) > 0.0).all():
        raise InputError("campbell: speeds: give two or more speeds in rad/s, ascending")

    def whirls_at(speed: float) -> list[Whirl]:
        return whirls(*at(speed), axis, speed)

    found = [whirls_at(speed) for speed in speeds.tolist()]
    if not any(found):
        raise InputError("campbell: no mode oscillates at these speeds; give bearings stiffness")
    tracks = track(found)
    values, sense = np.full((2, speeds.size, len(tracks)), complex(np.nan, np.nan))
    for k, places in enumerate(tracks):
        for i, j in places.items():
            values[i, k], sense[i, k] = found[i][j].eigenvalue, found[i][j].sense
    shapes = tuple(
        tuple(found[i][places[i]].shape if i in places else None for places in tracks) for i in range(speeds.size)
    )
    labels = tuple(found[max(places)][places[max(places)]].label for places in tracks)
    return Campbell(speeds, values, sense.real, labels, whirls_at, shapes)


def track(found: list[list[Whirl]]) -> list[dict[int, int]]:
    """Return modes as {speed: place in its list}, followed from the last speed, where shapes differ, to the first."""
    last = len(found) - 1
    tracks = [{last: j} for j in range(len(found[last]))]
    known = [(x.shape, x.eigenvalue.imag) for x in found[last]]
    for i in range(last - 1, -1, -1):
        cost = np.array([[distance(x, *one) for x in found[i]] for one in known]).reshape(len(known), len(found[i]))
        rows, columns = linear_sum_assignment(cost)
        for k, j in zip(rows.tolist(), columns.tolist(), strict=True):
            one = found[i][j]
            tracks[k][i] = j
            alike = assurance(one.shape, known[k][0]) >= SHAPE_MIN
            known[k] = (one.shape if alike else known[k][0], one.eigenvalue.imag)
        for j in sorted(set(range(len(found[i]))) - set(columns.tolist())):
            tracks.append({i: j})
            known.append((found[i][j].shape, found[i][j].eigenvalue.imag))
    return tracks
