"""Reference cases: one mechanism per file, built through the public interface and compared with a trusted solution.

The files in ``references/`` give a mechanism by the centres of mass of its bodies and by joint points and axes in world
coordinates of the initial configuration; ``references/README.md`` explains the fields. ``load`` turns one into a
``System``; with ``shift`` the reference point O of every body is moved off its centre of mass, which changes the
description and the matrices but not the physics, so that every case tests the terms with r_G != 0 as well.
"""

import json
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mbsd3d import (
    GROUND,
    Body,
    Prismatic,
    Revolute,
    RollingDisc,
    SpeedDriver,
    Spherical,
    SpringDamper,
    System,
    Torque,
    Universal,
    simulate,
)

Array = NDArray[np.floating]
Shift = int | Mapping[str, ArrayLike] | None

REFERENCES = Path(__file__).parent / "references"
NOT_CASES = {"engine", "conditions"}
"""Files in the same folder that hold other data."""

SHIFT_SIZE = 0.5
"""Scatter of a seeded shift over the size of its body."""


@dataclass(frozen=True, eq=False)
class Case:
    """A mechanism with its reference solution.

    Attributes
    ----------
    id : str
        Name of the case.
    system : System
        The mechanism.
    t_end : float
        End of the simulation [s]; 0 where only the mechanism at its reference pose is of interest.
    outputs : tuple of mapping
        Definition of the output columns, as in the file.
    times : (n,) ndarray
        Times of the reference values [s].
    labels : tuple of str
        Names of the k reference columns.
    reference : (n, k) ndarray
        Reference values, SI units.
    dof_info : mapping
        Rows, rank, mobility (``dof``) and redundancy; empty if the file gives none.
    accuracy : float
        Absolute accuracy claimed for the reference; 0 for a closed form.
    raw : mapping
        The file.
    """

    id: str
    system: System = field(repr=False)
    t_end: float
    outputs: tuple[Mapping[str, Any], ...] = field(repr=False)
    times: Array = field(repr=False)
    labels: tuple[str, ...]
    reference: Array = field(repr=False)
    dof_info: Mapping[str, int] = field(repr=False)
    accuracy: float
    raw: Mapping[str, Any] = field(repr=False)


def names(*, timed: bool = False) -> list[str]:
    """Names of the cases in alphabetical order.

    Parameters
    ----------
    timed : bool
        Only those with a reference over time.

    Returns
    -------
    list of str
        Arguments for :func:`load`.
    """
    found = sorted(path.stem for path in REFERENCES.glob("*.json") if path.stem not in NOT_CASES)
    return [name for name in found if not timed or read(name)["outputs"] and read(name)["end_time"] > 0]


def read(name: str) -> dict[str, Any]:
    """Content of a case file.

    Parameters
    ----------
    name : str
        Name of the case.

    Returns
    -------
    dict
        The file.

    Raises
    ------
    ValueError
        If there is no such case.
    """
    path = REFERENCES / f"{name}.json"
    if name in NOT_CASES or not path.is_file():
        raise ValueError(f"case '{name}': not found; choose one of {', '.join(names())}")
    return json.loads(path.read_text(encoding="utf-8"))


def load(name: str, shift: Shift = None) -> Case:
    """Build a case.

    Parameters
    ----------
    name : str
        Name of the case.
    shift : int or mapping, optional
        Vectors from the centre of mass of each body to its reference point O, world axes at the initial configuration
        [m]: a mapping from body names to (3,), or a seed for general ones about half as long as the body. None puts O
        at the centre of mass.

    Returns
    -------
    Case
        System and reference.

    Raises
    ------
    ValueError
        If there is no such case, or it holds a part that this module cannot build.
    """
    return build(read(name), shift)


def build(raw: Mapping[str, Any], shift: Shift = None) -> Case:
    """Build a case from the content of a file; arguments as in :func:`load`."""
    bodies = _bodies(raw, _shifts(raw, shift))
    part = {**bodies, "ground": GROUND}
    system = System(
        bodies=list(bodies.values()),
        joints=[_make(JOINTS, spec, raw, part) for spec in raw["joints"]],
        forces=[_make(FORCES, spec, raw, part) for spec in raw.get("forces", [])],
        gravity=tuple(raw["gravity"]),
    )
    timed = [row for row in raw["reference"]["values"] if "t" in row] if raw["outputs"] and raw["end_time"] else []
    labels = tuple(key for key in (timed[0] if timed else ()) if key != "t")
    return Case(
        id=raw["id"],
        system=system,
        t_end=float(raw["end_time"]),
        outputs=tuple(raw["outputs"]),
        times=np.array([row["t"] for row in timed], dtype=float),
        labels=labels,
        reference=np.array([[row[key] for key in labels] for row in timed], dtype=float).reshape(
            len(timed), len(labels)
        ),
        dof_info=raw.get("dof_info", {}),
        accuracy=_accuracy(raw["reference"]["accuracy"]),
        raw=raw,
    )


def _accuracy(text: str) -> float:
    """Leading number of a text such as '4.1e-12 (...)', 0 for 'exact'."""
    number = re.match(r"[\d.]+(e-?\d+)?", text)
    return float(number.group()) if number else 0.0


def _bodies(raw: Mapping[str, Any], shifts: Mapping[str, Array]) -> dict[str, Body]:
    """Bodies with the reference point at centre of mass plus shift: r_G = -R' s, v_O = v_G + w x s."""
    bodies = {}
    for spec in raw["bodies"]:
        shift, motion = shifts[spec["name"]], {}
        if "w0" in spec:
            omega = np.array(spec["w0"])
            motion = {"velocity": np.array(spec["v0"]) + np.cross(omega, shift), "omega": omega}
        bodies[spec["name"]] = Body(
            spec["name"],
            spec["mass"],
            np.array(spec["inertia"]),
            com=-_rotation(spec["q0"]).T @ shift,
            position=np.array(spec["r0"]) + shift,
            orientation=np.array(spec["q0"]),
            **motion,
        )
    return bodies


def _shifts(raw: Mapping[str, Any], shift: Shift) -> dict[str, Array]:
    """Vector from centre of mass to reference point by body name, world axes [m]."""
    bodies = raw["bodies"]
    if shift is None:
        return {spec["name"]: np.zeros(3) for spec in bodies}
    if isinstance(shift, Mapping):
        unknown = set(shift) - {spec["name"] for spec in bodies}
        if unknown:
            raise ValueError(f"shift of {sorted(unknown)}: case '{raw['id']}' has no such body")
        return {spec["name"]: np.array(shift.get(spec["name"], np.zeros(3)), dtype=float) for spec in bodies}
    scatter = np.random.default_rng(shift).normal(size=(len(bodies), 3))
    return {spec["name"]: SHIFT_SIZE * _size(raw, spec) * x for spec, x in zip(bodies, scatter, strict=True)}


def _size(raw: Mapping[str, Any], body: Mapping[str, Any]) -> float:
    """Length of a body: to its farthest joint point, or its radius of gyration [m]."""
    mine = [j for j in raw["joints"] if body["name"] in (j["body_i"], j["body_j"])]
    reach = [np.linalg.norm(np.subtract(j["p"], body["r0"])) for j in mine if "p" in j]
    reach += [j["radius"] for j in mine if "radius" in j]
    inertia = np.array(body["inertia"])
    return max([*reach, np.sqrt((inertia if inertia.ndim == 1 else np.diag(inertia)).sum() / body["mass"])])


def _make(
    kinds: Mapping[str, Callable], spec: Mapping[str, Any], raw: Mapping[str, Any], part: Mapping[str, Any]
) -> Any:
    """Joint or force of the package from its entry in the file."""
    if spec["type"] not in kinds:
        raise ValueError(f"case '{raw['id']}': part type '{spec['type']}' unknown; add it to JOINTS or FORCES")
    return kinds[spec["type"]](spec, part)


def _pair(spec: Mapping[str, Any], part: Mapping[str, Any]) -> tuple[Any, Any]:
    """Bodies a and b of a joint: body_i and body_j of the file."""
    return part[spec["body_i"]], part[spec["body_j"]]


JOINTS: dict[str, Callable] = {
    "revolute": lambda s, part: Revolute(*_pair(s, part), at=s["p"], axis=s["axis"], name=s["name"]),
    "spherical": lambda s, part: Spherical(*_pair(s, part), at=s["p"], name=s["name"]),
    "universal": lambda s, part: Universal(
        *_pair(s, part), at=s["p"], axis_a=s["axis_i"], axis_b=s["axis_j"], name=s["name"]
    ),
    "prismatic": lambda s, part: Prismatic(*_pair(s, part), at=s["p"], axis=s["axis"], name=s["name"]),
    "motor": lambda s, part: SpeedDriver(*_pair(s, part), axis=s["axis"], speed=s["omega"], name=s["name"]),
    "rolling_disc": lambda s, part: RollingDisc(*_pair(s, part), axis=s["axis"], radius=s["radius"], name=s["name"]),
}

# a spring pulls its ends together when longer than L0, in the files and in the package alike
FORCES: dict[str, Callable] = {
    "spring": lambda s, part: SpringDamper(
        *_pair(s, part), at_a=s["p_i"], at_b=s["p_j"], stiffness=s["k"], damping=s["c"], length=s["L0"]
    ),
    "torque": lambda s, part: Torque(part[s["body"]], s["torque"], frame="world"),
}


class Comparison(NamedTuple):
    """Computed against reference values."""

    columns: dict[str, tuple[Array, Array]]
    """By label: computed and reference values at the times of the case, (n,) each."""
    error: float
    """Greatest absolute difference, SI units."""
    scaled_error: float
    """The same with each column divided by its largest reference value where that exceeds 1."""
    left_out: tuple[str, ...]
    """Reference columns without a rule."""


def compare(case: Case, solution: Any) -> Comparison:
    """Evaluate the outputs of a case in a solution and hold them against the reference.

    Quaternions are compared up to sign, angles up to whole turns (the computed value is brought next to the reference).

    Parameters
    ----------
    case : Case
        With n reference times.
    solution : Solution
        Of ``case.system``; its samples must contain ``case.times``.

    Returns
    -------
    Comparison
        Columns and errors.

    Raises
    ------
    ValueError
        If a reference time is not among the samples of the solution.
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
    """Largest value of a column, at least 1."""
    return max(1.0, np.abs(column).max())


def _columns(case: Case, solution: Any, near: Mapping[str, Array]) -> dict[str, Array]:
    """All columns that the case defines, by label; ``near`` holds values that fix signs and turns."""
    sample = _Sample(case, solution)
    columns = {}
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
    """A solution at the reference times of a case, read by body name."""

    def __init__(self, case: Case, solution: Any) -> None:
        self.case = case
        self.solution = solution
        t = np.asarray(solution.t)
        self.rows = np.array([np.argmin(np.abs(t - time)) for time in case.times], dtype=int)
        missing = case.times[np.abs(t[self.rows] - case.times) > 1e-9]
        if missing.size:
            raise ValueError(f"case '{case.id}': solution has no sample at t = {missing} s; pass output=case.times")
        self.start = {body["name"]: body for body in case.raw["bodies"]}

    def read(self, quantity: str, part: str) -> Array:
        """Values of a method of the solution for a part at the reference times."""
        return np.asarray(getattr(self.solution, quantity)(part))[self.rows]

    def point(self, body: str, point: ArrayLike | None) -> Array:
        """Position of a body-fixed point given by its initial world coordinates (None: centre of mass), (n, 3)."""
        centre = self.read("com", body)
        if point is None:
            return centre
        return centre + self.direction(body, np.subtract(point, self.start[body]["r0"]))

    def direction(self, body: str, vector: ArrayLike) -> Array:
        """Body-fixed vector given by its initial world components, (n, 3)."""
        return self.read("rotation", body) @ (_rotation(self.start[body]["q0"]).T @ np.asarray(vector, dtype=float))

    def velocity(self, body: str, point: ArrayLike | None) -> Array:
        """Velocity of such a point, ``v_O + w x (r_P - r_O)``, (n, 3)."""
        arm = self.point(body, point) - self.read("position", body)
        return self.read("velocity", body) + np.cross(self.read("omega", body), arm)

    def angle(self, body: str, axis: ArrayLike) -> Array:
        """Rotation about a world axis since the start, for a body that turns about nothing else, (n,)."""
        turned = self.read("rotation", body) @ _rotation(self.start[body]["q0"]).T
        return _angle_about(turned, np.asarray(axis, dtype=float))

    def energy(self) -> Array:
        """Kinetic plus potential energy (weight and springs), (n,)."""
        energy = self.solution.energy()
        return (np.asarray(energy.kinetic) + np.asarray(energy.potential))[self.rows]


def _rotation(quaternion: ArrayLike) -> Array:
    """Rotation matrix of a unit quaternion, body to world, (3, 3)."""
    e0, x, y, z = np.asarray(quaternion, dtype=float)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + 2 * e0 * cross + 2 * cross @ cross


def _angle_about(turned: Array, axis: Array) -> Array:
    """Angle of rotations (n, 3, 3) about the unit ``axis`` (3,), from sine and cosine, (n,)."""
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
    """Torque of the only motor on its body b [N m]."""
    motor = next(joint["name"] for joint in sample.case.raw["joints"] if joint["type"] == "motor")
    return sample.read("effort", motor)


def _steer_axis(sample: _Sample) -> Array:
    """Steering axis of the bicycle, world components at the start, (3,)."""
    return np.array(next(joint["axis"] for joint in sample.case.raw["joints"] if joint["name"] == "steer"))


def _steer(sample: _Sample) -> Array:
    """Angle of the handlebar relative to the rear frame about the steering axis [rad]."""
    relative = np.swapaxes(sample.read("rotation", "rearframe"), 1, 2) @ sample.read("rotation", "handlebar")
    return _angle_about(relative, _steer_axis(sample))


def _steer_rate(sample: _Sample) -> Array:
    """Rate of the steering angle, ``(w_handlebar - w_rearframe) . axis`` [rad/s]."""
    relative = sample.read("omega", "handlebar") - sample.read("omega", "rearframe")
    return np.sum(relative * sample.direction("rearframe", _steer_axis(sample)), axis=1)


def _forward_speed(sample: _Sample) -> Array:
    """Velocity of the rear hub along the x axis of the rear frame [m/s]."""
    return np.sum(sample.velocity("rearwheel", None) * sample.direction("rearframe", (1, 0, 0)), axis=1)


def _roll(sample: _Sample) -> Array:
    """Lean of the rear frame, ``asin(e_y . e_z)`` with e_y its lateral axis [rad]."""
    return np.arcsin(sample.direction("rearframe", (0, 1, 0))[:, 2])


def _roll_rate(sample: _Sample) -> Array:
    """Rate of that angle, ``(w x e_y) . e_z / cos(roll)`` [rad/s]."""
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
    """Stored condition of a case: change of its outputs per relative change of the mechanism.

    Parameters
    ----------
    name : str
        Name of the case.

    Returns
    -------
    float
        As measured by :func:`measure_condition` [-].

    Raises
    ------
    ValueError
        If none is stored.
    """
    path = REFERENCES / "conditions.json"
    stored = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    if name not in stored:
        raise ValueError(f"case '{name}': no condition stored; measure it with measure_condition")
    return float(stored[name])


def measure_condition(case: Case, perturbation: float = 1e-7, *, rtol: float = 1e-12, seeds: int = 5) -> float:
    """How much a small change of the mechanism is amplified at the output times.

    Gravity, the speed of everything (initial velocities and motors alike), masses and moments of inertia are changed by
    the relative amount ``perturbation`` times seeded normal numbers, and principal axes turned by such an angle [rad];
    the start stays consistent. The result is the greatest change of a column (over its largest value where that exceeds
    1) divided by ``perturbation``, over all seeds.

    Parameters
    ----------
    case : Case
        With a reference over time.
    perturbation : float
        Relative change, small enough for linearity and large against ``rtol`` times the result [-].
    rtol : float
        Tolerance of the runs [-].
    seeds : int
        Number of changes tried.

    Returns
    -------
    float
        Condition [-].
    """
    near = dict(zip(case.labels, case.reference.T, strict=True))

    def columns(run: Case) -> dict[str, Array]:
        return _columns(run, simulate(run.system, run.t_end, rtol=rtol, output=run.times), near)

    base, worst = columns(case), 0.0
    for seed in range(seeds):
        changed = columns(build(_perturbed(case.raw, perturbation, seed)))
        worst = max(worst, *(np.abs(changed[key] - base[key]).max() / _scale(base[key]) for key in base))
    return worst / perturbation


def _perturbed(raw: Mapping[str, Any], amount: float, seed: int) -> dict[str, Any]:
    """Copy of a case file with slightly other gravity, speed and bodies."""
    rng = np.random.default_rng(seed)
    gravity, speed = np.array(raw["gravity"]) * (1 + amount * rng.normal(size=3)), 1 + amount * rng.normal()
    joints = [{**spec, "omega": spec["omega"] * speed} if "omega" in spec else spec for spec in raw["joints"]]
    moving = [{**spec, **{key: speed * np.array(spec[key]) for key in ("v0", "w0")}} for spec in raw["bodies"]]
    bodies = [{**spec, **_perturbed_inertia(spec, amount, rng)} for spec in moving]
    return {**raw, "bodies": bodies, "joints": joints, "gravity": gravity}


def _perturbed_inertia(body: Mapping[str, Any], amount: float, rng: np.random.Generator) -> dict[str, Any]:
    """Slightly other mass and inertia; turned and scaled, so that the principal moments stay those of a body."""
    inertia = np.array(body["inertia"], dtype=float)
    inertia = np.diag(inertia) if inertia.ndim == 1 else inertia
    turn = _rotation([1.0, *(amount / 2 * rng.normal(size=3))])
    scale = 1 + amount * rng.normal()
    return {"mass": body["mass"] * (1 + amount * rng.normal()), "inertia": scale * turn @ inertia @ turn.T}


@dataclass(frozen=True, eq=False)
class RobotPose:
    """Inverse dynamics of the six-axis arm in one pose.

    Attributes
    ----------
    system : System
        The arm with ``torque`` applied at its hinges; its accelerations must be ``accelerations``.
    free : System
        The arm without torques; its accelerations must be ``free_accelerations``.
    angles, rates : dict
        By hinge [rad], [rad/s]: arguments of ``system.assemble``.
    accelerations, free_accelerations : (6,) ndarray
        Of the hinge angles [rad/s^2].
    torque, gravity_torque : (6,) ndarray
        About the hinge axes, on the outer link [N m]: for ``accelerations``; at rest.
    mass_matrix : (6, 6) ndarray
        In the hinge angles [kg m^2].
    tool : (3,) ndarray
        Position of the tool point [m].
    """

    system: System
    free: System
    angles: dict[Any, float]
    rates: dict[Any, float]
    accelerations: Array
    free_accelerations: Array
    torque: Array
    gravity_torque: Array
    mass_matrix: Array
    tool: Array

    def tool_position(self, centre: Array, rotation: Array) -> Array:
        """Tool point from the centre of mass (3,) [m] and the rotation (3, 3) of the last link, world."""
        raw = read("robot6r_inverse_dynamics")
        link, output = raw["bodies"][-1], raw["outputs"][0]
        return centre + rotation @ (_rotation(link["q0"]).T @ np.subtract(output["p"], link["r0"]))


def robot_poses(shift: Shift = None) -> list[RobotPose]:
    """Poses of the six-axis arm with the torques that belong to them.

    ``system.assemble(angles=pose.angles, rates=pose.rates)`` gives the state; :func:`hinge_accelerations` reads the
    accelerations of the angles from ``accelerations(pose.system, state)``.

    Parameters
    ----------
    shift : int or mapping, optional
        As in :func:`load`.

    Returns
    -------
    list of RobotPose
        In the order of the file.
    """
    raw = read("robot6r_inverse_dynamics")
    # the poses set their own velocities: the file's rest would contradict them
    bodies = [{key: spec[key] for key in spec if key not in ("v0", "w0")} for spec in raw["bodies"]]
    case = build({**raw, "bodies": bodies}, shift)
    joints = list(case.system.joints)
    return [_robot_pose(case, joints, row) for row in case.raw["reference"]["values"]]


def _robot_pose(case: Case, joints: list[Any], row: Mapping[str, Any]) -> RobotPose:
    """One pose of the arm; the hinge torques are fixed in the links on both sides."""
    forces = []
    body = {b.name: b for b in case.system.bodies}
    start = {spec["name"]: _rotation(spec["q0"]) for spec in case.raw["bodies"]}
    for spec, torque in zip(case.raw["joints"], row["tau"], strict=True):
        for name, sign in ((spec["body_j"], 1.0), (spec["body_i"], -1.0)):
            if name != "ground":
                axis = start[name].T @ np.array(spec["axis"])
                forces.append(Torque(body[name], sign * torque * axis, frame="body"))
    bodies, gravity = list(case.system.bodies), tuple(case.raw["gravity"])
    return RobotPose(
        system=System(bodies=bodies, joints=joints, forces=forces, gravity=gravity),
        free=case.system,
        angles=dict(zip(joints, row["q"], strict=True)),
        rates=dict(zip(joints, row["qd"], strict=True)),
        accelerations=np.array(row["qdd"]),
        free_accelerations=np.array(row["qdd_zero_torque"]),
        torque=np.array(row["tau"]),
        gravity_torque=np.array(row["gravity_torque"]),
        mass_matrix=np.array(row["M"]),
        tool=np.array(row["ee_position"]),
    )


def hinge_accelerations(solution: Any) -> Array:
    """Accelerations of the arm's hinge angles, ``u . (alpha_b - alpha_a)`` with u the hinge axis in the pose.

    Parameters
    ----------
    solution : Solution
        Of the arm, for example ``accelerations(pose.system, state)``, n samples.

    Returns
    -------
    (n, 6) ndarray
        [rad/s^2].
    """
    raw = read("robot6r_inverse_dynamics")
    start = {spec["name"]: _rotation(spec["q0"]) for spec in raw["bodies"]}
    result = []
    for spec in raw["joints"]:
        a, b = spec["body_i"], spec["body_j"]
        axis = solution.rotation(b) @ (start[b].T @ np.array(spec["axis"]))
        relative = solution.alpha(b) - (0.0 if a == "ground" else solution.alpha(a))
        result.append(np.sum(axis * relative, axis=1))
    return np.stack(result, axis=1)
