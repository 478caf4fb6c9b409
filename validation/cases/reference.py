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
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

import mbsd3d
from mbsd3d.errors import InputError

Array = NDArray[np.floating]
Shift = int | Mapping[str, ArrayLike] | None

REFERENCES = Path(__file__).parents[1] / "references"
NOT_CASES = {"engine", "conditions"}  # Files in the same folder that hold other data

SHIFT_SIZE = 0.5  # Scatter of a seeded shift over the size of its body


@dataclass(frozen=True, eq=False)
class Case:
    """Mechanism with its reference solution.

    ``id``: name of the case; ``system``: the mechanism; ``t_end``: end of the simulation [s]; 0 where only the
    mechanism at its reference pose is of interest; ``outputs``: definition of the output columns, as in the file;
    ``times`` (n,): times of the reference values [s]; ``labels``: names of the k reference columns; ``reference``
    (n, k): reference values, SI units; ``dof_info``: rows, rank, mobility (``dof``) and redundancy; empty if the file
    gives none; ``accuracy``: absolute accuracy claimed for the reference; 0 for a closed form; ``raw``: the file.
    """

    id: str
    system: mbsd3d.System = field(repr=False)
    t_end: float
    outputs: tuple[Mapping[str, Any], ...] = field(repr=False)
    times: Array = field(repr=False)
    labels: tuple[str, ...]
    reference: Array = field(repr=False)
    dof_info: Mapping[str, int] = field(repr=False)
    accuracy: float
    raw: Mapping[str, Any] = field(repr=False)


def names(*, timed: bool = False) -> list[str]:
    """Return the names of the cases in alphabetical order.

    ``timed``: only those with a reference over time. Returns arguments for :func:`load`.
    """
    found = sorted(path.stem for path in REFERENCES.glob("*.json") if path.stem not in NOT_CASES)
    return [name for name in found if not timed or read(name)["outputs"] and read(name)["end_time"] > 0]


def read(name: str) -> dict[str, Any]:
    """Read the content of a case file.

    ``name``: name of the case. Returns the file. ValueError if there is no such case.
    """
    path = REFERENCES / f"{name}.json"
    if name in NOT_CASES or not path.is_file():
        raise InputError(f"case '{name}': not found; choose one of {', '.join(names())}")
    return json.loads(path.read_text(encoding="utf-8"))


def load(name: str, shift: Shift = None) -> Case:
    """Build a reference case by its name.

    ``shift``: vectors from the centre of mass of each body to its reference point O, world axes at the initial
    configuration [m]: a mapping from body names to (3,), or a seed for general ones about half as long as the body;
    None puts O at the centre of mass. ValueError if there is no such case, or it holds a part that this module cannot
    build.
    """
    return build(read(name), shift)


def build(raw: Mapping[str, Any], shift: Shift = None) -> Case:
    """Build a case from the content of a file; arguments as in :func:`load`."""
    bodies = _bodies(raw, _shifts(raw, shift))
    part = {**bodies, "ground": mbsd3d.GROUND}
    system = mbsd3d.System(
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
    """Return the leading number of a text such as '4.1e-12 (...)', 0 for 'exact'."""
    number = re.match(r"[\d.]+(e-?\d+)?", text)
    return float(number.group()) if number else 0.0


def _bodies(raw: Mapping[str, Any], shifts: Mapping[str, Array]) -> dict[str, mbsd3d.Body]:
    """Return bodies with the reference point at centre of mass plus shift: r_G = -R' s, v_O = v_G + w x s."""
    bodies = {}
    for spec in raw["bodies"]:
        shift, motion = shifts[spec["name"]], {}
        if "w0" in spec:
            omega = np.array(spec["w0"])
            motion = {"velocity": np.array(spec["v0"]) + np.cross(omega, shift), "omega": omega}
        bodies[spec["name"]] = mbsd3d.Body(
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
    """Return the vector from centre of mass to reference point by body name, world axes [m]."""
    bodies = raw["bodies"]
    if shift is None:
        return {spec["name"]: np.zeros(3) for spec in bodies}
    if isinstance(shift, Mapping):
        unknown = set(shift) - {spec["name"] for spec in bodies}
        if unknown:
            raise InputError(f"shift of {sorted(unknown)}: case '{raw['id']}' has no such body")
        return {spec["name"]: np.array(shift.get(spec["name"], np.zeros(3)), dtype=float) for spec in bodies}
    scatter = np.random.default_rng(shift).normal(size=(len(bodies), 3))
    return {spec["name"]: SHIFT_SIZE * _size(raw, spec) * x for spec, x in zip(bodies, scatter, strict=True)}


def _size(raw: Mapping[str, Any], body: Mapping[str, Any]) -> float:
    """Return the length of a body: to its farthest joint point, or its radius of gyration [m]."""
    mine = [j for j in raw["joints"] if body["name"] in (j["body_i"], j["body_j"])]
    reach = [np.linalg.norm(np.subtract(j["p"], body["r0"])) for j in mine if "p" in j]
    reach += [j["radius"] for j in mine if "radius" in j]
    inertia = np.array(body["inertia"])
    return max([*reach, np.sqrt((inertia if inertia.ndim == 1 else np.diag(inertia)).sum() / body["mass"])])


def _make(
    kinds: Mapping[str, Callable], spec: Mapping[str, Any], raw: Mapping[str, Any], part: Mapping[str, Any]
) -> Any:
    """Build a joint or force of the package from its entry in the file."""
    if spec["type"] not in kinds:
        raise InputError(f"case '{raw['id']}': part type '{spec['type']}' unknown; add it to JOINTS or FORCES")
    return kinds[spec["type"]](spec, part)


def _pair(spec: Mapping[str, Any], part: Mapping[str, Any]) -> tuple[Any, Any]:
    """Return bodies a and b of a joint: body_i and body_j of the file."""
    return part[spec["body_i"]], part[spec["body_j"]]


JOINTS: dict[str, Callable] = {
    "revolute": lambda s, part: mbsd3d.Revolute(*_pair(s, part), at=s["p"], axis=s["axis"], name=s["name"]),
    "spherical": lambda s, part: mbsd3d.Spherical(*_pair(s, part), at=s["p"], name=s["name"]),
    "universal": lambda s, part: mbsd3d.Universal(
        *_pair(s, part), at=s["p"], axis_a=s["axis_i"], axis_b=s["axis_j"], name=s["name"]
    ),
    "prismatic": lambda s, part: mbsd3d.Prismatic(*_pair(s, part), at=s["p"], axis=s["axis"], name=s["name"]),
    "motor": lambda s, part: mbsd3d.SpeedDriver(*_pair(s, part), axis=s["axis"], speed=s["omega"], name=s["name"]),
    "rolling_disc": lambda s, part: mbsd3d.RollingDisc(
        *_pair(s, part), axis=s["axis"], radius=s["radius"], name=s["name"]
    ),
}

# a spring pulls its ends together when longer than L0, in the files and in the package alike
FORCES: dict[str, Callable] = {
    "spring": lambda s, part: mbsd3d.SpringDamper(
        *_pair(s, part), at_a=s["p_i"], at_b=s["p_j"], stiffness=s["k"], damping=s["c"], length=s["L0"]
    ),
    "torque": lambda s, part: mbsd3d.Torque(part[s["body"]], s["torque"], frame="world"),
}


def _rotation(quaternion: ArrayLike) -> Array:
    """Return the rotation matrix of a unit quaternion, body to world, (3, 3)."""
    e0, x, y, z = np.asarray(quaternion, dtype=float)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + 2 * e0 * cross + 2 * cross @ cross
