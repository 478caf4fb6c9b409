"""Comparison of solutions with the reference cases, and the condition of each case."""

import json
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mbsd3d import Solution
from mbsd3d.errors import InputError
from validation.cases.reference import REFERENCES, Array, Case, _rotation


class Comparison(NamedTuple):
    """Computed values compared with reference values."""

    columns: dict[str, tuple[Array, Array]]
    """By label: computed and reference values at the times of the case, (n,) each."""
    error: float  # Greatest absolute difference, SI units
    scaled_error: float  # The same with each column divided by its largest reference value where that exceeds 1
    left_out: tuple[str, ...]  # Reference columns without a rule


def compare(case: Case, solution: Solution) -> Comparison:
    """Evaluate the outputs of a case in a solution and compare them with the reference.

    Quaternions are compared up to sign, angles up to whole turns (the computed value is brought next to the reference).

    ``case``: with n reference times; ``solution``: of ``case.system``; its samples must contain ``case.times``. Returns
    columns and errors. ValueError if a reference time is not among the samples of the solution.
    """
    reference = dict(zip(case.labels, case.reference.T, strict=True))
    computed = _columns(case, solution, reference)
    columns = {label: (computed[label], reference[label]) for label in case.labels if label in computed}
    return Comparison(
        columns,
        max((np.abs(a - b).max() for a, b in columns.values()), default=0.0),
        max((np.abs(a - b).max() / _scale(b) for a, b in columns.values()), default=0.0),
        tuple(label for label in case.labels if label not in computed),
    )


def _scale(column: Array) -> float:
    """Return the largest value of a column, at least 1."""
    return max(1.0, np.abs(column).max())


def _columns(case: Case, solution: Solution, near: Mapping[str, Array]) -> dict[str, Array]:
    """Return all columns that the case defines, by label; ``near`` holds values that fix signs and turns."""
    sample = _Sample(case, solution)
    columns: dict[str, Array] = {}
    for output in case.outputs:
        kind, name = output["kind"], output["name"]
        values = OUTPUTS[kind](sample, output)
        labels = [f"{name}_{axis}" for axis in AXES[kind]] if kind in AXES else [name]
        values = values if kind in AXES else values[:, None]
        if kind in ALIGN:
            values = ALIGN[kind](values, np.stack([near[label] for label in labels], axis=1))
        columns.update(zip(labels, values.T, strict=True))
    for label in set(case.labels) - set(columns):
        if label in EXTRAS:
            columns[label] = EXTRAS[label](sample)
    return columns


class _Sample:
    """Solution at the reference times of a case, read by body name."""

    def __init__(self, case: Case, solution: Solution) -> None:
        self.case = case
        self.solution = solution
        t = np.asarray(solution.t)
        self.rows = np.array([np.argmin(np.abs(t - time)) for time in case.times], dtype=int)
        missing = case.times[np.abs(t[self.rows] - case.times) > 1e-9]
        if missing.size:
            raise InputError(f"case '{case.id}': solution has no sample at t = {missing} s; pass output=case.times")
        self.start = {body["name"]: body for body in case.raw["bodies"]}

    def read(self, quantity: str, part: str) -> Array:
        """Return the values of a method of the solution for a part at the reference times."""
        return np.asarray(getattr(self.solution, quantity)(part))[self.rows]

    def point(self, body: str, point: ArrayLike | None) -> Array:
        """Return the position of a body-fixed point given by its initial world coordinates (None: centre of mass), (n,
        3).
        """
        centre = self.read("com", body)
        if point is None:
            return centre
        return centre + self.direction(body, np.subtract(point, self.start[body]["r0"]))

    def direction(self, body: str, vector: ArrayLike) -> Array:
        """Return the body-fixed vector given by its initial world components, (n, 3)."""
        return self.read("rotation", body) @ (_rotation(self.start[body]["q0"]).T @ np.asarray(vector, dtype=float))

    def velocity(self, body: str, point: ArrayLike | None) -> Array:
        """Return the velocity of such a point, ``v_O + w x (r_P - r_O)``, (n, 3) [m/s]."""
        arm = self.point(body, point) - self.read("position", body)
        return self.read("velocity", body) + np.cross(self.read("omega", body), arm)

    def angle(self, body: str, axis: ArrayLike) -> Array:
        """Return the rotation about a world axis since the start, for a body that turns about nothing else, (n,)."""
        turned = self.read("rotation", body) @ _rotation(self.start[body]["q0"]).T
        return _angle_about(turned, np.asarray(axis, dtype=float))

    def energy(self) -> Array:
        """Return the kinetic plus potential energy (weight and springs), (n,)."""
        energy = self.solution.energy()
        return (np.asarray(energy.kinetic) + np.asarray(energy.potential))[self.rows]


def _angle_about(turned: Array, axis: Array) -> Array:
    """Return the angle of rotations (n, 3, 3) about the unit ``axis`` (3,), from sine and cosine, (n,)."""
    axial = np.stack([turned[:, k, j] - turned[:, j, k] for j, k in ((1, 2), (2, 0), (0, 1))], axis=1) / 2
    return np.arctan2(axial @ (axis / np.linalg.norm(axis)), (np.trace(turned, axis1=1, axis2=2) - 1) / 2)


OUTPUTS: dict[str, Callable[[_Sample, Mapping[str, Any]], Array]] = {
    "pos": lambda sample, o: sample.point(o["body"], o.get("p")),
    "vel": lambda sample, o: sample.velocity(o["body"], o.get("p")),
    "dir": lambda sample, o: sample.direction(o["body"], o["d"]),
    "quat": lambda sample, o: sample.read("orientation", o["body"]),
    "w_body": lambda sample, o: sample.read("omega_body", o["body"]),
    "angle": lambda sample, o: sample.angle(o["body"], o["axis"]),
    "angrate": lambda sample, o: sample.read("omega", o["body"]) @ np.asarray(o["axis"], dtype=float),
    "energy": lambda sample, o: sample.energy(),
}

AXES = {"pos": "xyz", "vel": "xyz", "dir": "xyz", "w_body": "xyz", "quat": "wxyz"}
"""Suffixes of the outputs with several columns."""

ALIGN: dict[str, Callable[[Array, Array], Array]] = {
    "quat": lambda values, near: values * np.where(np.sum(values * near, axis=1) < 0, -1, 1)[:, None],
    "angle": lambda values, near: values + 2 * np.pi * np.round((near - values) / (2 * np.pi)),
}


def _motor_torque(sample: _Sample) -> Array:
    """Return the torque of the only motor on its body b [N m]."""
    motor = next(joint["name"] for joint in sample.case.raw["joints"] if joint["type"] == "motor")
    return sample.read("effort", motor)


def _steer_axis(sample: _Sample) -> Array:
    """Return the steering axis of the bicycle, world components at the start, (3,)."""
    return np.array(next(joint["axis"] for joint in sample.case.raw["joints"] if joint["name"] == "steer"))


def _steer(sample: _Sample) -> Array:
    """Return the angle of the handlebar relative to the rear frame about the steering axis [rad]."""
    relative = np.swapaxes(sample.read("rotation", "rearframe"), 1, 2) @ sample.read("rotation", "handlebar")
    return _angle_about(relative, _steer_axis(sample))


def _steer_rate(sample: _Sample) -> Array:
    """Return the rate of the steering angle, ``(w_handlebar - w_rearframe) . axis`` [rad/s]."""
    relative = sample.read("omega", "handlebar") - sample.read("omega", "rearframe")
    return np.sum(relative * sample.direction("rearframe", _steer_axis(sample)), axis=1)


def _forward_speed(sample: _Sample) -> Array:
    """Return the velocity of the rear hub along the x axis of the rear frame [m/s]."""
    return np.sum(sample.velocity("rearwheel", None) * sample.direction("rearframe", (1, 0, 0)), axis=1)


def _roll(sample: _Sample) -> Array:
    """Return the lean of the rear frame, ``asin(e_y . e_z)`` with e_y its lateral axis [rad]."""
    return np.arcsin(sample.direction("rearframe", (0, 1, 0))[:, 2])


def _roll_rate(sample: _Sample) -> Array:
    """Return the rate of the lean angle, ``(w x e_y) . e_z / cos(roll)`` [rad/s]."""
    lateral = sample.direction("rearframe", (0, 1, 0))
    return np.cross(sample.read("omega", "rearframe"), lateral)[:, 2] / np.cos(_roll(sample))


EXTRAS: dict[str, Callable[[_Sample], Array]] = {
    "E": lambda sample: sample.energy(),
    "motor_torque": _motor_torque,
    "roll": _roll,
    "roll_angle_rate": _roll_rate,
    "steer": _steer,
    "steer_rate": _steer_rate,
    "forward_speed_frame": _forward_speed,
    "roll_rate_bodyx": lambda sample: sample.read("omega_body", "rearframe")[:, 0],
}
"""Columns that appear in ``reference.values`` but not in ``outputs``."""


def condition(name: str) -> float:
    """Return the stored condition of a case: change of its outputs per relative change of the mechanism.

    It was measured by ``tests/helpers/conditions.py`` [-]. ValueError if none is stored.
    """
    path = REFERENCES / "conditions.json"
    stored = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    if name not in stored:
        raise InputError(f"case '{name}': no condition stored; measure it with tests/helpers/conditions.py")
    return float(stored[name])
