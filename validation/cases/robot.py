"""Six-axis arm in the poses of its file, with the torques that belong to them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from mbsd3d import Solution, System, Torque
from validation.cases.reference import Array, Case, Shift, _rotation, build, read


@dataclass(frozen=True, eq=False)
class RobotPose:
    """Inverse dynamics of the six-axis arm in one pose.

    ``system``: the arm with ``torque`` applied at its hinges; its accelerations must be ``accelerations``; ``free``:
    the arm without torques; its accelerations must be ``free_accelerations``; ``angles, rates``: by hinge [rad],
    [rad/s]: arguments of ``system.assemble``; ``accelerations, free_accelerations`` (6,): of the hinge angles
    [rad/s^2].
    """

    system: System
    free: System
    angles: dict[Any, float]
    rates: dict[Any, float]
    accelerations: Array
    free_accelerations: Array


def robot_poses(shift: Shift = None) -> list[RobotPose]:
    """Return the poses of the six-axis arm with the torques that belong to them.

    ``system.assemble(angles=pose.angles, rates=pose.rates)`` gives the state; :func:`hinge_accelerations` reads the
    accelerations of the angles from ``accelerations(pose.system, state)``.

    ``shift``: as in :func:`load`. They come in the order of the file.
    """
    raw = read("robot6r_inverse_dynamics")
    # the poses set their own velocities: the file's rest would contradict them
    bodies = [{key: spec[key] for key in spec if key not in ("v0", "w0")} for spec in raw["bodies"]]
    case = build({**raw, "bodies": bodies}, shift)
    joints = list(case.system.joints)
    return [_robot_pose(case, joints, row) for row in case.raw["reference"]["values"]]


def _robot_pose(case: Case, joints: list[Any], row: Mapping[str, Any]) -> RobotPose:
    """Return one pose of the arm; the hinge torques are fixed in the links on both sides."""
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
    )


def hinge_accelerations(solution: Solution) -> Array:
    """Return the accelerations of the arm's hinge angles, ``u . (alpha_b - alpha_a)`` with u the hinge axis in the pose
    [rad/s^2].

    ``solution``: of the arm, for example ``accelerations(pose.system, state)``, n samples. Returns (n, 6): [rad/s^2].
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
