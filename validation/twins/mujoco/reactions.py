"""Reactions of the joints at a state that MuJoCo has evaluated: on body b, at the joint's point, world axes.

A tree joint carries the interaction force of its body (``cfrc_int``); what acts along its coordinates is of springs and
couplings, and taken off. MuJoCo's sum does not know the actuators at sites: their loads are passed to it as external
forces for the sum.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from mbsd3d import GROUND, GearMesh, Joint, Torque
from mbsd3d.extend import Piece
from validation.twins.mujoco.build import Sketch
from validation.twins.mujoco.couplings import Coupling, loads_of
from validation.twins.mujoco.loads import Loads

Wrench = tuple[np.ndarray, np.ndarray]


class Reactions:
    """Reactions of one model; `all` reads them from the data."""

    def __init__(
        self, made: Sketch, loads: Loads, couplings: list[Coupling], tendons: list, mujoco: Any, model: Any
    ) -> None:
        self.made, self.loads, self.tendons = made, loads, tendons
        self.mujoco, self.model = mujoco, model
        welded = {id(piece.joint) for piece in made.layout.extra}
        meshes = [c for c in couplings if isinstance(c.part, GearMesh)]
        split = {id(h) for c in meshes for h in (c.part.hinge_a, c.part.hinge_b) if id(h) in welded}
        self.meshes = [c for c in meshes if not {id(c.part.hinge_a), id(c.part.hinge_b)} & split]
        self.tree = [(p, p.joint) for p in made.layout.pieces if p.joint is not None and id(p.joint) not in split]
        self.along = [c for c in couplings if not loads_of(c.part) and c not in self.meshes]
        self.held = [c for c in self.along if c not in meshes]

    def all(self, data: Any) -> dict[str, Wrench]:
        """Return joint name -> (force, moment); the forces of a mesh whose hinge is on a piece of a gear are not
        known."""
        self.tell_applied(data)
        self.mujoco.mj_rnePostConstraint(self.model, data)
        data.xfrc_applied[:] = 0.0
        along = self.along_coordinates(data)
        name = self.made.system.name
        found = {name(joint): self.of_piece(data, piece, joint, along) for piece, joint in self.tree}
        found |= {name(joint): self.of_closure(data, joint) for joint in self.made.layout.closing}
        found |= {name(c.part): self.of_coupling(data, c) for c in self.held}
        found |= {name(mesh): (force, np.zeros(3)) for mesh, force in self.tooth_forces(data)}
        for rod, _, equality in self.tendons:
            found[name(rod)] = self.pull(data, rod, self.tension(data, equality)), np.zeros(3)
        return {name(j): found[name(j)] for j in self.made.system.joints if name(j) in found}

    def rows(self, data: Any, equality: str) -> np.ndarray:
        """Return the constraint forces of an equality."""
        number = self.model.equality(equality).id
        kind = int(self.mujoco.mjtConstraint.mjCNSTR_EQUALITY)
        return data.efc_force[(data.efc_type == kind) & (data.efc_id == number)]

    def tension(self, data: Any, equality: str) -> float:
        """Return the constraint force of an equality of tendons; 0 where MuJoCo leaves out its row because nothing
        moves it.
        """
        return float(self.rows(data, equality).sum())

    def number(self, body: Any) -> int:
        """Return the number of a body in MuJoCo."""
        return self.model.body(self.made.layout.main[id(body)].name).id

    def point(self, data: Any, body: Any, point: np.ndarray) -> np.ndarray:
        """Return the present position of a point of a body, given at the reference pose."""
        if body is GROUND:
            return point
        k = self.number(body)
        return data.xpos[k] + data.xmat[k].reshape(3, 3) @ body.local_point(point)

    def axis(self, data: Any, body: Any, axis: np.ndarray) -> np.ndarray:
        """Return the present direction of an axis of a body, given at the reference pose."""
        if body is GROUND:
            return axis
        k = self.number(body)
        return data.xmat[k].reshape(3, 3) @ body.local_axis(axis)

    def pull(self, data: Any, part: Any, tension: float) -> np.ndarray:
        """Return the force on b of an element that pushes b away from a with ``tension`` [N]."""
        span = self.point(data, part.b, part.at_b) - self.point(data, part.a, part.at_a)
        return tension * span / np.linalg.norm(span)

    def tell_applied(self, data: Any) -> None:
        """Set applied loads as external ones at the centres of mass, for the sum only."""
        for body, at, force, moment in (*self.applied(data), *self.on_teeth(data)):
            if body is not GROUND:
                k = self.number(body)
                data.xfrc_applied[k, :3] += force
                data.xfrc_applied[k, 3:] += moment + np.cross(at - data.xipos[k], force)

    def applied(self, data: Any) -> Iterator[tuple[Any, np.ndarray, np.ndarray, np.ndarray]]:
        """Return (body, point, force, moment) of applied loads."""
        for actuator, part in self.loads.applied:
            k = self.model.actuator(actuator).id
            linear, turning = np.split(data.actuator_force[k] * self.model.actuator_gear[k], 2)
            if part.frame == "body":
                R = data.xmat[self.number(part.body)].reshape(3, 3)
                linear, turning = R @ linear, R @ turning
            at = part.body.position if isinstance(part, Torque) else part.at
            yield part.body, self.point(data, part.body, at), linear, turning

    def on_teeth(self, data: Any) -> Iterator[tuple[Any, np.ndarray, np.ndarray, np.ndarray]]:
        """Return (gear, pitch point, force, no moment) where the couplings turn the gears: the same motion, other
        bearing loads.
        """
        for mesh, force in self.tooth_forces(data):
            at = self.point(data, mesh.support(), mesh.at)
            for gear, sign in ((mesh.a, -1.0), (mesh.b, 1.0)):
                yield gear, at, sign * force, np.zeros(3)

    def tooth_forces(self, data: Any) -> Iterator[tuple[GearMesh, np.ndarray]]:
        """Yield (mesh, force on gear b): its row is the work of a unit force along the line of action."""
        for coupling in self.meshes:
            mesh = coupling.part
            yield mesh, self.tension(data, coupling.equality) * self.axis(data, mesh.support(), mesh.direction())

    def along_coordinates(self, data: Any) -> dict[str, float]:
        """Return the generalised force of springs and couplings along each joint coordinate [N or N m]."""
        total: dict[str, float] = {}
        pulls = [
            (part.terms, slope * self.tension(data, c.equality))
            for c in self.along for part, slope in c.parts(data, self.model)
        ]  # fmt: skip
        for tendon, terms, stiffness, damping in self.loads.turning:
            k = self.model.tendon(tendon).id
            rest = self.model.tendon_lengthspring[k, 0]
            pulls.append((terms, -stiffness * (data.ten_length[k] - rest) - damping * data.ten_velocity[k]))
        for terms, pull in pulls:
            for key, factor in terms.items():
                total[key] = total.get(key, 0.0) + factor * pull
        return total

    def of_piece(self, data: Any, piece: Piece, joint: Joint, along: dict[str, float]) -> Wrench:
        """Return the reaction of the joint of a piece: the load of its parent on it, or for body a the opposite."""
        free = self.made.joints[piece.number]
        k, sense = self.model.body(piece.name).id, 1.0 if piece.is_b else -1.0
        at = self.point(data, joint.b, joint.point())
        moment, force = sense * np.split(data.cfrc_int[k], 2)[0], sense * data.cfrc_int[k, 3:]
        moment = moment + np.cross(data.subtree_com[self.model.body_rootid[k]] - at, force)
        for name in [piece.named("slide", c) for c in free.slides]:
            if along.get(name):
                force = force - sense * along[name] * data.xaxis[self.model.joint(name).id]
        for name in [piece.named("turn", c) for c in range(0 if free.turns is None else len(free.turns))]:
            if along.get(name):
                moment = moment - sense * along[name] * data.xaxis[self.model.joint(name).id]
        return force, moment

    def of_closure(self, data: Any, joint: Joint) -> Wrench:
        """Return the reaction of coincident points: the site on b comes first, so that the forces act on b."""
        at, force, moment = self.point(data, joint.b, joint.point()), np.zeros(3), np.zeros(3)
        for equality in self.made.closures[id(joint)]:
            rows = self.rows(data, equality)
            if not rows.size:  # MuJoCo leaves out rows that nothing can violate: bodies that are rigid by other joints
                continue
            site = data.site_xpos[self.model.eq_obj1id[self.model.equality(equality).id]]
            force, moment = force + rows, moment + np.cross(site - at, rows)
        return force, moment

    def of_coupling(self, data: Any, coupling: Coupling) -> Wrench:
        """Return the reaction on body b of the joint of a coupling, by every coordinate of the row that moves this
        body.
        """
        tension, force, moment = self.tension(data, coupling.equality), np.zeros(3), np.zeros(3)
        for part, slope in coupling.parts(data, self.model):
            for x, factor in part.coordinates:
                sense = float(x.b is coupling.part.b) - float(x.a is coupling.part.b)
                load = sense * slope * factor * tension * self.axis(data, x.a, x.axis)
                force, moment = (force + load, moment) if x.kind == "slide" else (force, moment + load)
        return force, moment
