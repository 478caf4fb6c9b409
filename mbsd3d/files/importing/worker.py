"""The guarded process that lets MuJoCo read a file: ``python -m mbsd3d.files.importing.worker FILE SECONDS``
prints facts as JSON.

It holds limits on time and memory, imports nothing else of the package, and gives numbers and names only. Points and
axes are world coordinates at the pose MuJoCo calls qpos0.
"""

import json
import os
import sys
from typing import Any

import numpy as np

from ...base.errors import InputError

SHOWN = 3  # groups of geoms below this are shown by MuJoCo; shapes for contacts alone are usually in group 3
MEMORY = 4 << 30  # [bytes] of address space, most of it never used


def limit(seconds: int) -> None:
    """Bounds on memory and CPU time [s], where the system has them."""
    try:
        import resource
    except ImportError:  # Windows: the parent's clock alone
        return
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


class Facts:
    """What the compiled model says."""

    def __init__(self, mujoco: Any, path: str, kind: str) -> None:
        spec = mujoco.MjSpec.from_file(path)
        spec.compiler.fusestatic = 0  # merged here by name, not there in silence
        self.mujoco, self.model = mujoco, spec.compile()
        guesses = kind == "robot" and spec.compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_AUTO
        self.guessed = {body.id for body in spec.bodies if guesses and not body.explicitinertial}
        self.data = mujoco.MjData(self.model)
        self.data.qpos[:] = self.model.qpos0
        mujoco.mj_kinematics(self.model, self.data)
        self.foreign: list[tuple[str, str]] = []

    def off(self, flag: str) -> bool:
        """Whether the file switches a part of the physics off."""
        flags = self.mujoco.mjtDisableBit
        constraints = ("CONTACT", "LIMIT", "EQUALITY", "FRICTIONLOSS")
        names = (flag, "CONSTRAINT") if flag in constraints else (flag,)
        return any(self.model.opt.disableflags & getattr(flags, f"mjDSBL_{name}") for name in names)

    def name(self, kind: str, i: int, otherwise: str = "") -> str:
        """Name of an element, or what else says which it is, or its kind and number."""
        found = self.mujoco.mj_id2name(self.model, getattr(self.mujoco.mjtObj, f"mjOBJ_{kind.upper()}"), i)
        return found or otherwise or f"{kind} {i}"

    def bodies(self) -> list[dict[str, Any]]:
        """Poses, masses, centres of mass and inertias about them, all in world axes."""
        m, d, found = self.model, self.data, []
        for i in range(m.nbody):
            C = d.ximat[i].reshape(3, 3)
            mass, moments = (0.0, np.zeros(3)) if i in self.guessed else (m.body_mass[i], m.body_inertia[i])
            found.append(
                {
                    "name": self.name("body", i),
                    "parent": int(m.body_parentid[i]),
                    "weld": 0 if m.body_mocapid[m.body_weldid[i]] >= 0 else int(m.body_weldid[i]),
                    "position": d.xpos[i],
                    "quaternion": d.xquat[i],
                    "mass": mass,
                    "centre": d.xipos[i],
                    "inertia": C @ np.diag(moments) @ C.T,
                    "geoms": [self.geom(k) for k in range(m.body_geomadr[i], m.body_geomadr[i] + m.body_geomnum[i])],
                }
            )
        return found

    def geom(self, i: int) -> dict[str, Any]:
        """Kind, sizes and pose of a geom, in world axes; whether MuJoCo would show it, and its colour if it has one."""
        m, d, quaternion = self.model, self.data, np.zeros(4)
        self.mujoco.mju_mat2Quat(quaternion, d.geom_xmat[i])
        rgba = m.geom_rgba[i]
        return {
            "type": self.mujoco.mjtGeom(m.geom_type[i]).name.removeprefix("mjGEOM_").lower(),
            "size": m.geom_size[i],
            "position": d.geom_xpos[i],
            "quaternion": quaternion,
            "shown": bool(m.geom_group[i] < SHOWN and rgba[3] > 0.0),
            "colour": None if np.allclose(rgba[:3], 0.5) else rgba[:3].clip(0.0, 1.0),
        }

    def joints(self) -> list[dict[str, Any]]:
        """Joints in the order of MuJoCo, which nests them from the parent to the body."""
        m, d, found = self.model, self.data, []
        springs, dampers = not self.off("SPRING"), not self.off("DAMPER")
        for i in range(m.njnt):
            kind = self.mujoco.mjtJoint(m.jnt_type[i]).name.removeprefix("mjJNT_").lower()
            q, v = m.jnt_qposadr[i], m.jnt_dofadr[i]
            found.append(
                {
                    "name": self.name("joint", i),
                    "type": kind,
                    "body": int(m.jnt_bodyid[i]),
                    "anchor": d.xanchor[i],
                    "axis": d.xaxis[i],
                    "stiffness": m.jnt_stiffness.ravel()[i] if springs else 0.0,
                    "damping": m.dof_damping.ravel()[v] if dampers else 0.0,
                    "rest": m.qpos_spring[q] - m.qpos0[q] if kind in ("hinge", "slide") else 0.0,
                }
            )
        return found

    def equalities(self) -> list[dict[str, Any]]:
        """Active loop closures and couplings."""
        m, found = self.model, []
        for i in range(0 if self.off("EQUALITY") else m.neq):
            kind, parts = self.mujoco.mjtEq(m.eq_type[i]).name.removeprefix("mjEQ_").lower(), []
            if kind == "joint":  # a mimic of URDF has no name
                parts = [int(m.eq_obj1id[i]), int(m.eq_obj2id[i])]
            name = self.name("equality", i, " by ".join(self.name("joint", k) for k in parts if k >= 0))
            if not m.eq_active0[i]:
                self.foreign.append(("equality", f"{name}, inactive at the start"))
            elif kind == "joint":
                found.append({"name": name, "type": kind, "joints": parts, "polynomial": m.eq_data[i, :5]})
            elif kind in ("connect", "weld"):
                found.append({"name": name, "type": kind, **self.ends(i, kind)})
            else:
                self.foreign.append(("equality", f"{name} ({kind})"))
        return found

    def ends(self, i: int, kind: str) -> dict[str, Any]:
        """Bodies and world points of a connection, and by how much a weld is turned at qpos0."""
        m, d = self.model, self.data
        ids, data = (int(m.eq_obj1id[i]), int(m.eq_obj2id[i])), m.eq_data[i]
        if m.eq_objtype[i] == self.mujoco.mjtObj.mjOBJ_SITE:
            bodies, points = [int(m.site_bodyid[k]) for k in ids], [d.site_xpos[k] for k in ids]
            turn = np.abs(d.site_xmat[ids[0]] - d.site_xmat[ids[1]]).max()
            return {"bodies": bodies, "points": points, "turn": turn}
        local = (data[0:3], data[3:6]) if kind == "connect" else (data[3:6], data[0:3])
        points = [d.xpos[k] + d.xmat[k].reshape(3, 3) @ x for k, x in zip(ids, local, strict=True)]
        wanted, error = np.zeros(4), np.zeros(9)
        self.mujoco.mju_mulQuat(wanted, d.xquat[ids[0]], data[6:10])
        self.mujoco.mju_quat2Mat(error, wanted)
        turn = np.abs(error - d.xmat[ids[1]]).max() if kind == "weld" else 0.0
        return {"bodies": list(ids), "points": points, "turn": turn}

    def list_foreign(self) -> None:
        """Everything that acts on the motion and has no counterpart here: (kind, what)."""
        m, add = self.model, self.foreign.append
        for kind in ("actuator", "tendon", "plugin", "flex"):
            count = getattr(m, f"n{kind}")
            if count and not (kind == "actuator" and self.off("ACTUATION")):
                add((kind, ", ".join(self.name(kind, i) for i in range(min(count, 10))) + f" ({count})"))
        for i in range(m.njnt):
            v, name = slice(m.jnt_dofadr[i], m.jnt_dofadr[i] + (6, 3, 1, 1)[m.jnt_type[i]]), self.name("joint", i)
            if m.jnt_limited[i] and not self.off("LIMIT"):
                add(("limit", f"range of {name}"))
            if m.dof_armature[v].any():
                add(("armature", name))
            if m.dof_frictionloss[v].any() and not self.off("FRICTIONLOSS"):
                add(("frictionloss", name))
            if m.jnt_stiffnesspoly[i].any() or m.dof_dampingpoly[v].any():
                add(("passive", f"polynomial stiffness or damping of {name}"))
        for i in np.flatnonzero(m.body_gravcomp).tolist():
            add(("gravcomp", self.name("body", i)))
        for i in self.guessed:
            if m.body_weldid[i] and m.body_mass[i]:
                body, mass = self.name("body", i), m.body_mass[i]
                add(("inertial", f"the {mass:.3g} kg that MuJoCo makes of the shapes of {body}"))
        for i in np.flatnonzero(m.body_mocapid >= 0).tolist():
            add(("mocap", self.name("body", i)))
        if m.nplastic:
            add(("passive", f"{m.nplastic} plastic joints"))
        if m.opt.density or m.opt.viscosity:
            add(("fluid", f"density {m.opt.density:g}, viscosity {m.opt.viscosity:g}"))
        if not self.off("CONTACT"):
            self.list_contacts()

    def list_contacts(self) -> None:
        """Geoms that could collide; MuJoCo leaves out those of one rigid group and of neighbours."""
        m, add = self.model, self.foreign.append
        for i in range(m.npair):
            add(("contact", self.name("pair", i)))
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
                    add(("contact", f"{self.name('geom', i)} with {self.name('geom', int(k))}, and perhaps others"))
                    return

    def all(self) -> dict[str, Any]:
        """Everything the parent needs."""
        m = self.model
        self.list_foreign()
        facts = {"bodies": self.bodies(), "joints": self.joints(), "equalities": self.equalities()}
        idle = {kind: int(getattr(m, f"n{kind}")) for kind in ("sensor", "key", "cam", "light", "site", "geom")}
        gravity = np.zeros(3) if self.off("GRAVITY") else m.opt.gravity
        return facts | {"gravity": gravity, "foreign": self.foreign, "idle": idle}


def plain(value: Any, what: str) -> Any:
    """The value as JSON can hold it; numbers that are not finite are a ValueError naming their part."""
    if isinstance(value, dict):
        name = value.get("name")
        return {key: plain(x, f"{key} of '{name}'" if name else f"{what} {key}") for key, x in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item, what) for item in value]
    if isinstance(value, np.ndarray | np.generic):
        if not np.isfinite(value).all():
            raise InputError(f"{what.strip()}: not finite: {value.tolist()}; give finite numbers")
        return value.tolist()
    return value


def main() -> None:
    """Print ``{"facts": ...}`` or ``{"error": ...}`` on the former standard output; MuJoCo's messages are dropped."""
    out, quiet = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(quiet, 1)
    os.dup2(quiet, 2)
    limit(int(sys.argv[2]))
    try:
        import mujoco

        answer = {"facts": plain(Facts(mujoco, sys.argv[1], sys.argv[3]).all(), "")}
    except ImportError as error:
        answer = {"error": f"needs the package mujoco ({error}); install it: pip install 'mbsd3d[import]'"}
    except (Exception, MemoryError) as error:
        answer = {"error": " ".join(str(error).split()) or type(error).__name__}
    with os.fdopen(out, "w") as stream:
        json.dump(answer, stream)


if __name__ == "__main__":
    main()
