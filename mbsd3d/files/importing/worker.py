"""The guarded process that lets MuJoCo read a file.

``python -m mbsd3d.files.importing.worker FILE SECONDS MASS FOLDER ...`` prints facts as JSON;
MASS is "whole" where the file gives the mass of all bodies together, else "parts".

It holds limits on time and memory, and gives numbers and names only. Points and axes are world
coordinates at the pose MuJoCo calls qpos0, with followers of joint equalities where these put them.
"""

import os
import sys
from collections.abc import Iterator
from math import factorial
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np
from numpy.polynomial.polynomial import polyder, polyval

from ...base.checks import check_size
from ...base.errors import InputError
from .facts import LENGTH_MIN
from .folders import Folders
from .guarded import reply

VISIBLE_GROUPS = 3  # [1] groups of geoms below this are shown by MuJoCo; contact shapes are usually in group 3
POSES_MAX = 100_000  # [1] of bodies in all key frames
RULE_ROUNDING = 1e-9  # [1] of the largest coordinate, by which equalities of one joint may differ: their digits
CLOSING_ITERATIONS_MAX = 60  # [1] steps to close loops: half of them for turns by the largest step, then quadratic
CLOSING_STEP_MAX = 0.2  # [rad, m] of a coordinate in a step
CLOSING_ROUNDING = 1e-12  # [1] of the extent of the model, by which a closed loop gapes
CLOSING_RANK = 1e-9  # [1] of the largest singular value, below which rows repeat each other
STAND_IN_RADIUS = 1e-3  # [m] of the ball that stands for a mesh that is not needed
TENDON_LOADS = {
    "stiffness": "SPRING", "stiffnesspoly": "SPRING", "damping": "DAMPER", "dampingpoly": "DAMPER",
    "frictionloss": "FRICTIONLOSS", "armature": "",
}  # fmt: skip
"""What makes a tendon pull always, and the flag that switches it off."""
LINEAR_LOADS = ("stiffness", "damping", "frictionloss", "armature")
"""Those of a fixed tendon that are built."""


class Facts:
    """What the compiled model says."""

    def __init__(self, mujoco: Any, path: str, folders: Folders, whole: bool) -> None:
        spec = specification(mujoco, Path(path))
        spec.compiler.fusestatic = spec.compiler.discardvisual = 0  # merged here by name, not there in silence
        self.mujoco = mujoco
        self.foreign: list[dict[str, Any]] = []  # what acts and is not among the facts
        self.said: list[str] = []
        looks = Undressed(mujoco, spec, folders, whole)
        self.model = spec.compile()
        self.files = {geom.id: file for geom, file in looks.geoms}
        self.missing = looks.missing
        self.gears = [int(getattr(mujoco.mjtTrn, f"mjTRN_{kind}")) for kind in ("JOINT", "JOINTINPARENT")]
        self.data = mujoco.MjData(self.model)
        self.start = self.closed(self.reference())
        self.data.qpos[:] = self.start
        mujoco.mj_kinematics(self.model, self.data)

    def reference(self) -> np.ndarray:
        """Return the reference pose: qpos0, with followers of joint equalities where these put them."""
        m, start = self.model, self.model.qpos0.copy()
        rules = [i for i in self.active_equalities() if m.eq_type[i] == self.mujoco.mjtEq.mjEQ_JOINT]
        followers = {i: m.jnt_qposadr[m.eq_obj1id[i]] for i in rules}
        for _ in rules:  # a follower may lead another
            for i, y in followers.items():
                start[y] = self.followed(i, start)
        for i, y in followers.items():
            name, wanted = self.name("joint", m.eq_obj1id[i]), self.followed(i, start)
            if abs(start[y] - wanted) > RULE_ROUNDING * max(1.0, np.abs(start).max()):
                raise InputError(
                    f"joint equality '{self.name('equality', i)}' puts '{name}' at {wanted:g}, others put it at "
                    f"{start[y]:g}; take one out"
                )
            if start[y] != m.qpos0[y]:
                self.said.append(f"'{name}' counts from {start[y]:g}, where it starts")
        self.said = list(dict.fromkeys(self.said))
        return start

    def closed(self, start: np.ndarray) -> np.ndarray:
        """Return the pose near ``start`` in which all connections and couplings hold, by Newton's method; say so.

        Steps are the least ones, in the velocities of MuJoCo, whose own residuals and Jacobian they use.
        """
        m, mujoco = self.model, self.mujoco
        m.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
        d, q = mujoco.MjData(m), start.copy()
        worst, gap, first, length = -1, 0.0, 0.0, LENGTH_MIN + float(m.stat.extent)
        for _ in range(CLOSING_ITERATIONS_MAX):
            d.qpos[:] = q
            mujoco.mj_fwdPosition(m, d)
            rows = [k for k in range(d.nefc) if self.closes(d, k)]
            if not rows or m.nv == 0:
                return start
            residual = d.efc_pos[rows]
            worst, gap = int(d.efc_id[rows[int(np.abs(residual).argmax())]]), float(np.abs(residual).max())
            first = first or gap
            if gap <= CLOSING_ROUNDING * length:
                break
            step = -np.linalg.lstsq(d.efc_J.reshape(d.nefc, m.nv)[rows], residual, rcond=CLOSING_RANK)[0]
            mujoco.mj_integratePos(m, q, step * min(1.0, CLOSING_STEP_MAX / np.abs(step).max()), 1.0)
        else:
            raise InputError(
                f"equality '{self.name('equality', worst)}' stays open by {gap:.3g} m or rad; correct its points, or "
                "the pose at the start (ref=)"
            )
        if first > CLOSING_ROUNDING * length:
            self.said.append(f"loops open by {first:.2g} m or rad are closed; joints count from the pose so found")
        return q

    def closes(self, d: Any, k: int) -> bool:
        """Return whether a row of constraints is one of an equality that is built."""
        kinds = self.mujoco.mjtEq
        built = (int(kinds.mjEQ_CONNECT), int(kinds.mjEQ_WELD), int(kinds.mjEQ_JOINT))
        return d.efc_type[k] == self.mujoco.mjtConstraint.mjCNSTR_EQUALITY and self.model.eq_type[d.efc_id[k]] in built

    def followed(self, i: int, q: np.ndarray) -> float:
        """Return where a joint equality puts its follower: y0 + a0 + a1 (x - x0) + ... + a4 (x - x0)^4.

        Without a leader it is y0 + a0.
        """
        m = self.model
        y, x = m.jnt_qposadr[m.eq_obj1id[i]], m.jnt_qposadr[m.eq_obj2id[i]]
        led = q[x] - m.qpos0[x] if m.eq_obj2id[i] >= 0 else 0.0
        return float(m.qpos0[y] + polyval(led, m.eq_data[i, :5]))

    def moved_length(self, i: int) -> float:
        """Return the length of a fixed tendon at the start, less that at qpos0."""
        joints, weights = self.wrapped(i)
        places = self.model.jnt_qposadr[joints]
        return float(weights @ (self.start[places] - self.model.qpos0[places]))

    def wrapped(self, i: int) -> tuple[list[int], np.ndarray]:
        """Return joints and coefficients, none zero, of a fixed tendon; none of a spatial one."""
        m = self.model
        own = slice(m.tendon_adr[i], m.tendon_adr[i] + m.tendon_num[i])
        acts = (m.wrap_type[own] == self.mujoco.mjtWrap.mjWRAP_JOINT) & (m.wrap_prm[own] != 0.0)
        return m.wrap_objid[own][acts].tolist(), m.wrap_prm[own][acts]

    def active_equalities(self) -> list[int]:
        """Return the numbers of the equalities that hold at the start."""
        m = self.model
        return [] if self.off("EQUALITY") else [i for i in range(m.neq) if m.eq_active0[i]]

    def add(self, kind: str, what: str, element: tuple[str, str] | None = None, count: int = 1) -> None:
        """Keep something that acts and has no counterpart here."""
        self.foreign.append({"kind": kind, "what": what, "element": element, "count": count})

    def off(self, flag: str) -> bool:
        """Return whether the file switches a part of the physics off."""
        flags = self.mujoco.mjtDisableBit
        constraints = ("CONTACT", "LIMIT", "EQUALITY", "FRICTIONLOSS")
        names = (flag, "CONSTRAINT") if flag in constraints else (flag,)
        return any(self.model.opt.disableflags & getattr(flags, f"mjDSBL_{name}") for name in names)

    @property
    def passive(self) -> bool:
        """Return whether forces that are neither springs nor dampers act: MuJoCo leaves them out where both are off."""
        return not (self.off("SPRING") and self.off("DAMPER"))

    def is_single(self, i: int) -> bool:
        """Return whether a joint is a hinge or slide, of one coordinate."""
        kinds = self.mujoco.mjtJoint
        return self.model.jnt_type[i] in (int(kinds.mjJNT_HINGE), int(kinds.mjJNT_SLIDE))

    def has_moved(self, i: int) -> bool:
        """Return whether a ball or free joint starts elsewhere than at its zero, from which its loads count."""
        places = slice(self.model.jnt_qposadr[i], self.model.jnt_qposadr[i] + (7, 4, 0, 0)[self.model.jnt_type[i]])
        return not np.array_equal(self.start[places], self.model.qpos0[places])

    def weak_motors(self) -> list[int]:
        """Return joints whose actuators balance weights, but are off or may be too weak for it."""
        m = self.model
        off = self.off("ACTUATION") or not m.nactuator
        return [i for i in range(m.njnt) if m.jnt_actgravcomp[i] and (off or m.jnt_actfrclimited[i])]

    def geared(self, i: int, load: str) -> float:
        """Return armature or damping that a hinge or slide has from its actuators: gear^2 times theirs."""
        m = self.model
        own = [k for k in range(m.nactuator) if m.actuator_trntype[k] in self.gears and m.actuator_trnid[k, 0] == i]
        gears = m.actuator_gear[m.actuator_outadr[own], 0]
        return float(gears**2 @ getattr(m, f"actuator_{load}")[own])

    def name(self, kind: str, i: int, otherwise: str = "") -> str:
        """Name of an element, or what else says which it is, or its kind and number."""
        found = self.mujoco.mj_id2name(self.model, getattr(self.mujoco.mjtObj, f"mjOBJ_{kind.upper()}"), i)
        return found or otherwise or f"{kind} {i}"

    def bodies(self) -> list[dict[str, Any]]:
        """Return poses, masses, centres of mass and inertias about them, all in world axes."""
        m, d, found = self.model, self.data, []
        balanced = self.passive and not self.weak_motors()
        for i in range(m.nbody):
            C = d.ximat[i].reshape(3, 3)
            found.append(
                {
                    "name": self.name("body", i),
                    "parent": int(m.body_parentid[i]),
                    "weld": 0 if m.body_mocapid[m.body_weldid[i]] >= 0 else int(m.body_weldid[i]),
                    "position": d.xpos[i],
                    "quaternion": d.xquat[i],
                    "mass": m.body_mass[i],
                    "centre": d.xipos[i],
                    "inertia": C @ np.diag(m.body_inertia[i]) @ C.T,
                    "gravcomp": m.body_gravcomp[i] if balanced else 0.0,
                    "fluid": self.box(i),
                    "geoms": [self.geom(k) for k in range(m.body_geomadr[i], m.body_geomadr[i] + m.body_geomnum[i])],
                }
            )
        return found

    def geom(self, i: int) -> dict[str, Any]:
        """Return kind, sizes and pose of a geom, in world axes; whether MuJoCo would show it, and its colour if any."""
        m, d, quaternion = self.model, self.data, np.zeros(4)
        self.mujoco.mju_mat2Quat(quaternion, d.geom_xmat[i])
        rgba, file = m.geom_rgba[i], self.files.get(i, ())
        return {
            "type": self.mujoco.mjtGeom(m.geom_type[i]).name.removeprefix("mjGEOM_").lower() if file == () else "file",
            "path": file[0] if file else None,
            "scale": file[1] if file else None,
            "size": m.geom_size[i],
            "position": d.geom_xpos[i],
            "quaternion": quaternion,
            "shown": bool(m.geom_group[i] < VISIBLE_GROUPS and rgba[3] > 0.0 and file is not None),
            "colour": None if np.allclose(rgba[:3], 0.5) else rgba[:3].clip(0.0, 1.0),
        }

    def joints(self) -> list[dict[str, Any]]:
        """Return joints in the order of MuJoCo, which nests them from the parent to the body."""
        m, d, found = self.model, self.data, []
        springs, dampers = not self.off("SPRING"), not self.off("DAMPER")
        for i in range(m.njnt):
            kind = self.mujoco.mjtJoint(m.jnt_type[i]).name.removeprefix("mjJNT_").lower()
            q, v, single = m.jnt_qposadr[i], m.jnt_dofadr[i], self.is_single(i)
            limited = m.jnt_limited[i] and kind != "free" and not self.off("LIMIT") and not self.has_moved(i)
            found.append(
                {
                    "name": self.name("joint", i),
                    "type": kind,
                    "body": int(m.jnt_bodyid[i]),
                    "anchor": d.xanchor[i],
                    "axis": d.xaxis[i],
                    "stiffness": m.jnt_stiffness.ravel()[i] if springs and not self.has_moved(i) else 0.0,
                    "damping": m.dof_damping.ravel()[v] + single * self.geared(i, "damping") if dampers else 0.0,
                    "armature": m.dof_armature[v] + self.geared(i, "armature") if single else m.dof_armature[v],
                    "friction": 0.0 if self.off("FRICTIONLOSS") else m.dof_frictionloss[v],
                    "rest": m.qpos_spring[q] - self.start[q] if single else 0.0,
                    "limit": m.jnt_range[i] - single * self.start[q] if limited else None,
                }
            )
        return found

    def equalities(self) -> list[dict[str, Any]]:
        """Return active loop closures and couplings."""
        m, found, active = self.model, [], set(self.active_equalities())
        for i in range(0 if self.off("EQUALITY") else m.neq):
            kind, parts = self.mujoco.mjtEq(m.eq_type[i]).name.removeprefix("mjEQ_").lower(), []
            if kind == "joint":
                parts = [int(m.eq_obj1id[i]), int(m.eq_obj2id[i])]
            name = self.name("equality", i, " by ".join(self.name("joint", k) for k in parts if k >= 0))
            element = ("equality", self.name("equality", i))
            if i not in active:
                self.add("switched-off", name, element)
            elif kind == "joint":
                shift = 0.0 if parts[1] < 0 else self.start[m.jnt_qposadr[parts[1]]] - m.qpos0[m.jnt_qposadr[parts[1]]]
                given = m.eq_data[i, :5] if parts[1] >= 0 else m.eq_data[i, :1]
                polynomial = [0.0, *shifted(given, shift)[1:]]  # the start meets it
                found.append({"name": name, "type": kind, "joints": parts, "polynomial": polynomial})
            elif kind == "tendon" and (sums := self.tied(i)):
                found.append({"name": name, "type": kind, **sums})
            elif kind in ("connect", "weld"):
                loose = kind == "weld" and m.eq_data[i, 10] == 0.0  # its torque is scaled by 0: it holds points only
                held = self.ends(i, kind)
                found.append({"name": name, "type": "connect" if loose else kind, **held})
            else:
                self.add("equality", f"{name} ({kind})", element)
        return found

    def tied(self, i: int) -> dict[str, Any]:
        """Return the sums y and x of a tendon equality, and its polynomial of x from the start; {} of spatial ones."""
        m = self.model
        y, x = int(m.eq_obj1id[i]), int(m.eq_obj2id[i])
        sums = [self.wrapped(k) if k >= 0 else ([], np.zeros(0)) for k in (y, x)]
        if not sums[0][0] or (x >= 0 and not sums[1][0]):
            return {}
        polynomial = shifted(m.eq_data[i, :5], self.moved_length(x)) if x >= 0 else m.eq_data[i, :1].copy()
        polynomial[0] -= self.moved_length(y)
        return {"sums": sums, "polynomial": polynomial}

    def tendons(self) -> list[dict[str, Any]]:
        """Return fixed tendons that have loads or limits; their lengths are counted from the start."""
        m, found = self.model, []
        for i in range(m.ntendon):
            joints, weights = self.wrapped(i)
            k = 0.0 if self.off("SPRING") else float(np.ravel(m.tendon_stiffness[i])[0])
            c = 0.0 if self.off("DAMPER") else float(np.ravel(m.tendon_damping[i])[0])
            friction = 0.0 if self.off("FRICTIONLOSS") else m.tendon_frictionloss[i]
            armature, limited = m.tendon_armature[i], bool(m.tendon_limited[i]) and not self.off("LIMIT")
            if joints and armature and not self.in_a_row(joints):
                name = self.name("tendon", i)
                self.said.append(f"armature of tendon '{name}' couples branches, between which MuJoCo leaves it out")
            if joints and (k or c or friction or armature or limited):
                start = weights @ self.start[m.jnt_qposadr[joints]]
                found.append({
                    "name": self.name("tendon", i), "joints": joints, "weights": weights, "stiffness": k, "damping": c,
                    "rest": m.tendon_lengthspring[i] - start, "limit": m.tendon_range[i] - start if limited else None,
                    "friction": friction, "armature": armature,
                })  # fmt: skip
        return found

    def in_a_row(self, joints: list[int]) -> bool:
        """Return whether the bodies of joints are on one branch of the tree."""
        rest, body = {int(self.model.jnt_bodyid[k]) for k in joints}, int(self.model.jnt_bodyid[joints].max())
        while body:  # a body has a higher number than the one that carries it
            rest.discard(body)
            body = int(self.model.body_parentid[body])
        return not rest

    def ends(self, i: int, kind: str) -> dict[str, Any]:
        """Return bodies and world points of a connection, at the pose in which it holds."""
        m, d = self.model, self.data
        ids, data = (int(m.eq_obj1id[i]), int(m.eq_obj2id[i])), m.eq_data[i]
        if m.eq_objtype[i] == self.mujoco.mjtObj.mjOBJ_SITE:
            return {"bodies": [int(m.site_bodyid[k]) for k in ids], "points": [d.site_xpos[k] for k in ids]}
        local = (data[0:3], data[3:6]) if kind == "connect" else (data[3:6], data[0:3])
        points = [d.xpos[k] + d.xmat[k].reshape(3, 3) @ x for k, x in zip(ids, local, strict=True)]
        return {"bodies": list(ids), "points": points}

    def list_foreign(self) -> None:
        """List everything that acts on the motion, always or at times, and is not among the facts."""
        m = self.model
        if m.nflex:
            names = [self.name("flex", i) for i in range(min(m.nflex, 10))]
            self.add("flex", ", ".join(names) + (f" and {m.nflex - 10} more" if m.nflex > 10 else ""), count=m.nflex)
        for i in range(m.ntendon):
            self.list_tendon(i)
        for i in range(m.njnt):
            v, name = slice(m.jnt_dofadr[i], m.jnt_dofadr[i] + (6, 3, 1, 1)[m.jnt_type[i]]), self.name("joint", i)
            if self.has_moved(i) and m.jnt_stiffness.ravel()[i] and not self.off("SPRING"):
                self.add("passive", f"stiffness of {name}, which has moved to close loops", ("joint", name))
            if self.has_moved(i) and m.jnt_limited[i] and not self.off("LIMIT"):
                self.add("limit", f"range of {name}, which has moved to close loops", ("joint", name))
            if self.curved(m.jnt_stiffnesspoly[i], m.dof_dampingpoly[v]):
                self.add("passive", f"polynomial stiffness or damping of {name}", ("joint", name))
        for i in range(m.nactuator):
            self.list_motor(i)
        for i in self.weak_motors() if self.passive and m.body_gravcomp.any() else ():
            name = self.name("joint", i)
            self.add("gravcomp", f"by the actuators of {name}, which are off or limited", ("joint", name))
        for i in np.flatnonzero(m.body_mocapid >= 0).tolist():
            self.add("mocap", self.name("body", i), ("body", self.name("body", i)))
        if m.nplastic:
            self.add("passive", f"{m.nplastic} plastic joints")
        if self.in_fluid:
            self.list_fluid()
        if m.opt.enableflags & self.mujoco.mjtEnableBit.mjENBL_SLEEP:
            self.add("sleep", "of bodies at rest", ("option", ""), count=0)
        if not self.off("CONTACT"):
            self.list_contacts()

    @property
    def in_fluid(self) -> bool:
        """Return whether a fluid acts on the bodies."""
        return self.passive and bool(self.model.opt.density or self.model.opt.viscosity)

    def list_fluid(self) -> None:
        """List what a fluid does that a box of the inertia of a body in a fluid at rest does not."""
        m = self.model
        if m.opt.wind.any():
            self.add("fluid", f"wind {' '.join(f'{x:g}' for x in m.opt.wind)}", ("option", ""))
        for i in np.flatnonzero(m.geom_fluid[:, 0] > 0.0).tolist():
            name = self.name("geom", i)
            self.add("fluid", f"the ellipsoid model of {name}", ("geom", name))

    def box(self, i: int) -> dict[str, Any] | None:
        """Return the box of inertia of a body, on which a fluid acts: edges L_i^2 = 6/m (I_j + I_k - I_i), and axes."""
        m, mass, I = self.model, float(self.model.body_mass[i]), self.model.body_inertia[i]
        if not self.in_fluid or mass < self.mujoco.mjMINVAL:
            return None
        quaternion = np.zeros(4)
        self.mujoco.mju_mat2Quat(quaternion, self.data.ximat[i])
        lengths = np.sqrt(np.maximum(I.sum() - 2.0 * I, 0.0) * 6.0 / mass)
        return {"lengths": lengths, "axes": quaternion, "density": m.opt.density, "viscosity": m.opt.viscosity}

    def curved(self, stiffness: Any, damping: Any) -> bool:
        """Return whether coefficients of higher powers act."""
        return bool(np.any(stiffness) and not self.off("SPRING") or np.any(damping) and not self.off("DAMPER"))

    def list_motor(self, i: int) -> None:
        """List armature and damping of an actuator, which act without command, where no single joint carries them."""
        m, name = self.model, self.name("actuator", i)
        single = m.actuator_trntype[i] in self.gears and self.is_single(m.actuator_trnid[i, 0])
        if m.actuator_armature[i] and not single:
            self.add("armature", f"of {name}, an actuator of no single hinge or slide", ("actuator", name))
        if self.curved(0.0, (m.actuator_dampingpoly[i].any(), m.actuator_damping[i] and not single)):
            self.add("passive", f"damping of {name}, an actuator", ("actuator", name))

    def actuators(self) -> list[dict[str, Any]]:
        """Return what actuators do: gear (g u + b0 + b1 l + b2 l_dot) along a joint with l = gear q, u the command.

        q counts as the file does, from ``origin`` at the reference pose.
        """
        m, found = self.model, []
        for i in range(0 if self.off("ACTUATION") else m.nactuator):
            joint, gear = int(m.actuator_trnid[i, 0]), float(m.actuator_gear[m.actuator_outadr[i], 0])
            name, why = self.name("actuator", i), self.why_asked(i)
            gain, (b0, b1, b2) = float(m.actuator_gainprm[i, 0]), m.actuator_biasprm[i, :3]
            if m.actuator_biastype[i] == self.mujoco.mjtBias.mjBIAS_NONE:
                b0 = b1 = b2 = 0.0
            command = m.actuator_ctrladr[i]  # an actuator may have several, or none
            span = m.actuator_ctrlrange[command] if not why and m.actuator_ctrllimited[command] else None
            forced = m.actuator_forcelimited[i] or (not why and m.jnt_actfrclimited[joint])
            found.append(
                {
                    "name": name, "joint": joint, "why": why, "gain": gear * gain, "constant": gear * b0,
                    "stiffness": -(gear**2) * b1, "damping": -(gear**2) * b2,
                    "origin": 0.0 if why else self.start[m.jnt_qposadr[joint]],
                    "range": span, "limited": bool(span is not None or forced),
                }
            )  # fmt: skip
        return found

    def why_asked(self, i: int) -> str:
        """Return why an actuator is neither a motor nor a servo of a hinge or slide, "" if it is one."""
        m, mujoco = self.model, self.mujoco
        if m.actuator_trntype[i] not in self.gears or not self.is_single(m.actuator_trnid[i, 0]):
            return "acts on no single hinge or slide"
        if m.opt.disableactuator & (1 << max(int(m.actuator_group[i]), 0)):
            return "is of a group that is switched off"
        if m.actuator_dyntype[i] != mujoco.mjtDyn.mjDYN_NONE or m.actuator_delay[i] > 0.0:
            return "has a state of its own"
        fixed = m.actuator_gaintype[i] == mujoco.mjtGain.mjGAIN_FIXED
        affine = m.actuator_gaintype[i] == mujoco.mjtGain.mjGAIN_AFFINE and not m.actuator_gainprm[i, 1:3].any()
        if not (fixed or affine) or m.actuator_biastype[i] not in (
            int(mujoco.mjtBias.mjBIAS_NONE), int(mujoco.mjtBias.mjBIAS_AFFINE),
        ):  # fmt: skip
            return "has a gain or bias that is not that of a motor or servo"
        if m.actuator_biastype[i] != mujoco.mjtBias.mjBIAS_NONE and m.actuator_biasprm[i, 1:3].max() > 0.0:
            return "pushes away from where it is, or along its motion"
        return ""

    def list_tendon(self, i: int) -> None:
        """List a tendon that pulls always, or whose length is limited; others only measure."""
        m, name = self.model, self.name("tendon", i)
        built = LINEAR_LOADS if self.wrapped(i)[0] else ()
        acts = [
            load.removesuffix("poly")
            for load, flag in TENDON_LOADS.items()
            if load not in built and np.any(getattr(m, f"tendon_{load}")[i]) and not (flag and self.off(flag))
        ]
        if acts:
            self.add("tendon", f"{name}, which has {' and '.join(dict.fromkeys(acts))}", ("tendon", name))
        if m.tendon_limited[i] and not self.off("LIMIT") and not self.wrapped(i)[0]:
            self.add("limit", f"length of tendon {name}, from which nothing hangs here", ("tendon", name))

    def list_contacts(self) -> None:
        """List geoms that could collide; MuJoCo leaves out those of one rigid group and of neighbours."""
        m = self.model
        if m.npair:
            self.add("contact", ", ".join(self.name("pair", i) for i in range(min(m.npair, 10))), count=0)
            return
        a = m.geom_bodyid
        group = m.body_weldid[a]
        above = m.body_weldid[m.body_parentid[group]]
        excluded = {int(x) for x in m.exclude_signature}
        for i in range(m.ngeom):
            j = slice(i + 1, None)
            able = (m.geom_contype[i] & m.geom_conaffinity[j]) | (m.geom_contype[j] & m.geom_conaffinity[i])
            near = (group[j] == above[i]) | (above[j] == group[i])
            near &= (group[i] != 0) & (group[j] != 0) & (not self.off("FILTERPARENT"))
            for k in i + 1 + np.flatnonzero((able != 0) & (group[j] != group[i]) & ~near):
                low, high = sorted((int(a[i]), int(a[k])))
                if (low << 16) + high not in excluded:
                    what = f"{self.name('geom', i)} with {self.name('geom', int(k))}, and perhaps others"
                    self.add("contact", what, count=0)
                    return

    def keys(self) -> list[dict[str, Any]]:
        """Return key frames: poses and velocities of all bodies, and what joints have moved since the start."""
        m = self.model
        found: list[dict[str, Any]] = []
        if m.nkey * m.nbody > POSES_MAX:
            self.said.append(f"{m.nkey} key frames of {m.nbody} bodies are not read, as they are too many")
            return found
        for k in range(m.nkey):
            d = self.mujoco.MjData(m)
            d.qpos[:], d.qvel[:] = m.key_qpos[k], m.key_qvel[k]
            self.mujoco.mj_normalizeQuat(m, d.qpos)
            for step in ("kinematics", "comPos", "comVel"):
                getattr(self.mujoco, f"mj_{step}")(m, d)
            twists = np.zeros((m.nbody, 6))
            for i in range(m.nbody):
                self.mujoco.mj_objectVelocity(m, d, self.mujoco.mjtObj.mjOBJ_XBODY, i, twists[i], 0)
            poses, name = np.concatenate([d.xpos, d.xquat], axis=1), self.name("key", k)
            joints = [self.moved(d, i) for i in range(m.njnt)]
            self.say_unread(k, name)
            found.append({"name": name, "time": m.key_time[k], "poses": poses, "joints": joints})
            found[-1]["twists"] = np.roll(twists, 3, axis=1)  # MuJoCo has (w, v)
        return found

    def say_unread(self, k: int, name: str) -> None:
        """Say what of a key frame is not among its state: mocap bodies that it moves, and states of actuators."""
        m, d = self.model, self.mujoco.MjData(self.model)
        moved = m.nmocap and not (
            np.array_equal(m.key_mpos[k].ravel(), d.mocap_pos.ravel())
            and np.array_equal(m.key_mquat[k].ravel(), d.mocap_quat.ravel())
        )
        if moved:
            self.said.append(f"key frame '{name}' moves mocap bodies, which stay where they are")
        if m.na and m.key_act[k].any():
            self.said.append(f"key frame '{name}' sets states of actuators, which are inactive")

    def moved(self, d: Any, i: int) -> dict[str, Any]:
        """Return what a joint has moved since the start, and its rate."""
        m = self.model
        q, v = m.jnt_qposadr[i], m.jnt_dofadr[i]
        slides, turns = (m.jnt_type[i] == getattr(self.mujoco.mjtJoint, f"mjJNT_{kind}") for kind in ("SLIDE", "HINGE"))
        return {
            "slides": bool(slides), "turns": bool(turns), "value": d.qpos[q] - self.start[q], "rate": d.qvel[v],
            "axis": d.xaxis[i], "anchor": d.xanchor[i], "turn": self.turned(d, i), "spin": d.qvel[v : v + 3],
        }  # fmt: skip

    def turned(self, d: Any, i: int) -> np.ndarray:
        """Return the quaternion by which a ball has turned the body since the start, in the axes of the body."""
        q, before, turn = self.model.jnt_qposadr[i], np.zeros(4), np.zeros(4)
        if self.model.jnt_type[i] == self.mujoco.mjtJoint.mjJNT_BALL:
            self.mujoco.mju_negQuat(before, self.start[q : q + 4])
            self.mujoco.mju_mulQuat(turn, before, d.qpos[q : q + 4])
        return turn

    def points(self) -> list[dict[str, Any]]:
        """Return sites at the reference pose."""
        m, d = self.model, self.data
        return [
            {
                "name": self.name("site", i), "body": int(m.site_bodyid[i]), "position": d.site_xpos[i],
                "axes": d.site_xmat[i],
            }
            for i in range(m.nsite)
        ]  # fmt: skip

    def all(self) -> dict[str, Any]:
        """Return everything the parent needs."""
        m = self.model
        self.list_foreign()
        facts: dict[str, Any] = {"bodies": self.bodies(), "joints": self.joints(), "equalities": self.equalities()}
        facts |= {"tendons": self.tendons()}
        facts |= {"keys": self.keys(), "points": self.points(), "said": self.said, "missing": self.missing}
        facts["actuators"] = self.actuators()
        idle = {kind: int(getattr(m, f"n{kind}")) for kind in ("sensor", "key", "cam", "light", "site", "geom")}
        gravity = np.zeros(3) if self.off("GRAVITY") else m.opt.gravity
        return facts | {"gravity": gravity, "foreign": self.foreign, "idle": idle}


class Undressed:
    """A specification without its looks: meshes, textures and materials are left where they give a mass only.

    ``whole``: the mass of all bodies is given, so that fixed ones matter.
    ``geoms``: those whose mesh was taken out, each with (path, scale) of its file, or None if it cannot be drawn.
    """

    def __init__(self, mujoco: Any, spec: Any, folders: Folders, whole: bool) -> None:
        self.mujoco, self.spec, self.folders, self.whole = mujoco, spec, folders, whole
        self.missing: list[str] = []
        self.geoms: list[tuple[Any, tuple[str, float] | None]] = []
        self.meshes = {mesh.name or PurePosixPath(mesh.file).stem: mesh for mesh in spec.meshes}
        self.stripped, spec.strippath = bool(spec.strippath), False
        needed = set()
        for body, matters in self.walk():
            for geom in body.geoms:
                named = geom.meshname or geom.hfieldname
                if named and matters and self.gives_mass(geom, body):
                    self.resolve(geom, body)
                    needed.add(geom.meshname)
                elif named or geom.type in (mujoco.mjtGeom.mjGEOM_MESH, mujoco.mjtGeom.mjGEOM_HFIELD):
                    self.undress(geom)
        self.colour()
        for light in spec.lights:
            light.texture = ""
        for kind in ("skins", "materials", "textures", "hfields"):
            for part in list(getattr(spec, kind)):
                spec.delete(part)
        for name, mesh in self.meshes.items():
            if name not in needed:
                spec.delete(mesh)

    def walk(self) -> Iterator[tuple[Any, bool]]:
        """Visit every body, and say whether its mass matters: it can move, or shares in a whole that is given."""
        waiting = [(self.spec.worldbody, False)]
        while waiting:
            body, matters = waiting.pop()
            matters = matters or bool(body.joints)
            yield body, matters
            waiting += [(child, matters or self.whole) for child in body.bodies]

    def gives_mass(self, geom: Any, body: Any) -> bool:
        """Return whether the mass of a body comes from this geom."""
        choices, wanted = self.mujoco.mjtInertiaFromGeom, self.spec.compiler.inertiafromgeom
        first, last = self.spec.compiler.inertiagrouprange
        weightless = geom.mass == 0.0 or geom.density == 0.0 or not first <= geom.group <= last
        if weightless or wanted == choices.mjINERTIAFROMGEOM_FALSE:
            return False
        return wanted == choices.mjINERTIAFROMGEOM_TRUE or not body.explicitinertial

    def file_of(self, mesh: Any) -> Path | None:
        """Return the file of a mesh, if it lies where it may."""
        name = PurePosixPath(mesh.file.replace("\\", "/")).name if self.stripped else mesh.file
        return self.folders.find(name, self.folders.home / self.spec.meshdir)

    def resolve(self, geom: Any, body: Any) -> None:
        """Let a mesh that gives a mass be read from where it lies."""
        if geom.hfieldname:
            raise InputError(
                f"height field '{geom.hfieldname}' gives the mass of body '{body.name}'; give the body an <inertial>"
            )
        mesh = self.meshes.get(geom.meshname)
        if mesh is None or not mesh.file:
            return  # MuJoCo says what is wrong, or makes the mesh itself
        path = self.file_of(mesh)
        if path is None:
            raise InputError(
                f"mesh file '{mesh.file}' gives the mass of body '{body.name}' and is not found in the folder of the "
                "model or in package_paths; put it there, or give the body an <inertial>"
            )
        mesh.file = str(path)

    def undress(self, geom: Any) -> None:
        """Put a small ball without mass in the place of a mesh: it collides as that would, for what is asked here."""
        mesh, file = self.meshes.get(geom.meshname), None
        if mesh is not None and mesh.file and geom.type == self.mujoco.mjtGeom.mjGEOM_MESH:
            path, scale = self.file_of(mesh), np.unique(mesh.scale)
            plain = not np.any(mesh.refpos) and np.array_equal(mesh.refquat, [1.0, 0.0, 0.0, 0.0])
            if path is not None and plain and scale.size == 1 and scale[0] > 0.0:
                file = (str(path), float(scale[0]))
            else:
                self.missing.append(f"{mesh.file}: {'mirrored, stretched or moved' if path else 'not found'}")
        geom.type, geom.size = self.mujoco.mjtGeom.mjGEOM_SPHERE, [STAND_IN_RADIUS, STAND_IN_RADIUS, STAND_IN_RADIUS]
        geom.meshname, geom.hfieldname, geom.mass = "", "", 0.0
        self.geoms.append((geom, file))

    def colour(self) -> None:
        """Give geoms the colours of their materials, which may be missing."""
        colours = {material.name: material.rgba for material in self.spec.materials}
        for geom in self.spec.geoms:
            if geom.material in colours and np.allclose(geom.rgba[:3], 0.5):
                geom.rgba = colours[geom.material]
        for kind in ("geoms", "sites", "tendons"):
            for part in getattr(self.spec, kind):
                part.material = ""


def specification(mujoco: Any, path: Path) -> Any:
    """Return what MuJoCo reads of a file; it knows the suffix .xml only."""
    if path.suffix == ".xml":
        return mujoco.MjSpec.from_file(str(path))
    os.chdir(path.parent)  # where it looks for what a text includes
    spec = mujoco.MjSpec.from_string(path.read_text(encoding="utf-8-sig").lstrip())
    spec.modelfiledir = str(path.parent)
    return spec


def shifted(polynomial: np.ndarray, by: float) -> np.ndarray:
    """Return the coefficients of p(x + by)."""
    return np.array([polyval(by, polyder(polynomial, k)) / factorial(k) for k in range(polynomial.size)])


def plain(value: Any, what: str) -> Any:
    """Return the value as JSON can hold it; numbers that are not finite are a ValueError naming their part."""
    if isinstance(value, dict):
        name = value.get("name")
        return {key: plain(x, f"{key} of '{name}'" if name else f"{what} {key}") for key, x in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item, what) for item in value]
    if isinstance(value, np.ndarray | np.generic):
        if not np.isfinite(value).all():
            raise InputError(f"{what.strip()}: not finite: {value.tolist()}; give finite numbers")
        check_size(np.asarray(value, float), what.strip())
        return value.tolist()
    return value


def facts_of(path: str, whole: str, given: list[str]) -> dict[str, Any]:
    """Return the facts of a file as JSON can hold them."""
    try:
        import mujoco
    except ImportError as error:
        raise InputError(f"needs the package mujoco ({error}); install it: pip install 'mbsd3d[import]'") from None
    return plain(Facts(mujoco, path, Folders(Path(path), given), whole == "whole").all(), "")


def main() -> None:
    """Print ``{"facts": ...}`` or ``{"error": ...}``; MuJoCo's messages are dropped."""
    path, seconds, whole, *given = sys.argv[1:]
    reply(int(seconds), lambda: {"facts": facts_of(path, whole, given)})


if __name__ == "__main__":
    main()
