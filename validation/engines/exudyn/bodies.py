"""The twin of free bodies and joints between them: absolute coordinates and constraints."""

from typing import Any

import numpy as np

from mbsd3d import GROUND
from mbsd3d.couplings import GearMesh
from mbsd3d.rotations import matrix, multiply

from ..base import Array, EngineFailed, Kinetic, Load, Motion, NotExpressible
from .assembly import Assembly
from .equations import Equations
from .forces import add_force_element
from .joints import add_joint
from .library import quiet
from .solvers import SOLVERS, Scheme, check_samples, check_steps, march


class BodyTwin:
    """See `validation.engines.base.Twin`; ``mbs`` is the system of Exudyn, for settings of one's own.

    Parameters
    ----------
    module : module
        `exudyn`.
    system : System
    state : State
        The start.
    scheme : Scheme
    rotation : str
        A key of `ROTATIONS`.
    """

    engine = "Exudyn"

    def __init__(self, module: Any, system: Any, state: Any, scheme: Scheme, rotation: str) -> None:
        self.module, self.system, self.state, self.scheme = module, system, state, scheme
        if system.joints and not scheme.implicit:
            raise NotExpressible(
                f"joint '{system.name(system.joints[0])}': {scheme} takes no constraints; choose an implicit solver, or "
                "formulation='kinematic tree' for a tree of hinges and guides"
            )
        self.model = Assembly(module, system, state, rotation)
        for joint in system.joints:
            add_joint(self.model, joint)
        for force in system.forces:
            add_force_element(self.model, force)
        self.mbs = self.model.mbs
        self.recorder = self.mbs.AddSensor(
            module.itemInterface.SensorUserFunction(sensorUserFunction=snapshot, storeInternal=True, writeToFile=False)
        )
        self.mbs.Assemble()
        self.order = float(SOLVERS[scheme.solver][1])
        self.settings = f"rigid bodies with {rotation}s, {scheme}"

    def equations(self, scheme: Scheme | None = None) -> Equations:
        """The equations at the start."""
        solver = self.module.MainSolverImplicitSecondOrder()
        settings = (scheme or Scheme()).settings(self.module, self.state.t, self.state.t + 1.0, 1, 1)
        settings.timeIntegration.generalizedAlpha.computeInitialAccelerations = False
        with quiet(self.module) as said:
            if not solver.InitializeSolver(self.mbs, settings):
                raise EngineFailed(f"Exudyn does not start: {said.getvalue()}")
        return Equations(self.model, solver)

    def kinetic(self) -> Kinetic:
        """Mass matrix at the start, and the map from Exudyn's velocities."""
        equations = self.equations()
        return Kinetic(equations.mass_matrix(), self.model.rates(self.model.poses(equations.q[None])[1][0]))

    def accelerations(self) -> Array:
        """(bodies, 6) at the start, from Exudyn's M, f, J; see `equations`."""
        return self.equations().accelerations()

    def degrees_of_freedom(self) -> dict[str, int]:
        """Exudyn's own count: 'degreeOfFreedom', 'redundantConstraints', 'nODE2', 'nAE', 'nPureAE'."""
        with quiet(self.module):
            return self.mbs.ComputeSystemDegreeOfFreedom()

    def run(self, t_end: float, steps: int, samples: int) -> Motion:
        """See `Twin.run`."""
        check_steps(steps, samples)
        settings = self.scheme.settings(self.module, self.state.t, t_end, steps, samples)
        if self.scheme.implicit:
            self.equations().begin_with_accelerations()
        seconds = march(self.module, self.mbs, self.scheme, settings)
        table = np.array(self.mbs.GetSensorStoredData(self.recorder))
        t = check_samples(table[:, 0], self.state.t, t_end, samples, table[:, 1:])
        n = self.mbs.systemData.ODE2Size()
        q, u, lam = np.split(table[:, 1:], [n, 2 * n], axis=1)
        position, turn = self.model.poses(q)
        v = np.array([self.model.rates(e) @ rate for e, rate in zip(turn, u, strict=True)])
        v = v.reshape(len(t), -1, 6)
        orientation = multiply(turn, self.model.reference)
        loads = self.reactions(t, q, u, lam)
        return Motion(t, position, orientation, v[..., :3], v[..., 3:], loads, seconds)

    def determinate(self) -> list[Any]:
        """Joints whose reactions Exudyn gives: none where rows repeat each other, not those that carry tooth forces."""
        if self.scheme.linear == "full-pivot":
            return []
        meshes = [joint for joint in self.system.joints if isinstance(joint, GearMesh)]
        without = {id(part) for mesh in meshes for part in (mesh, *mesh.partners())}
        return [joint for joint in self.system.joints if id(joint) not in without]

    def reactions(self, t: Array, q: Array, u: Array, lam: Array) -> dict[str, Load]:
        """Wrench -J' lam on body b of every joint, moved to the joint's point."""
        joints = self.determinate()
        if not joints:
            return {}
        equations, k = self.equations(), len(self.system.bodies)
        wrenches = np.zeros((len(t), len(joints), k + 1, 6))  # about O, in world axes; the ground stands last
        for i in range(len(t)):
            equations.load(q[i], u[i], t[i])
            J, e = equations.jacobian(), self.model.poses(q[i : i + 1])[1][0]
            to_world = np.linalg.pinv(self.model.rates(e)).T
            for n, joint in enumerate(joints):
                rows = [r for item in self.model.objects[id(joint)] for r in self.mbs.systemData.GetObjectLTGAE(item)]
                wrenches[i, n, :k] = (to_world @ (-J[rows].T @ lam[i, rows])).reshape(k, 6)
        return {
            self.system.name(joint): self.at_point(joint, wrenches[:, n], q) for n, joint in enumerate(joints)
        }

    def at_point(self, joint: Any, wrenches: Array, q: Array) -> Load:
        """The wrench on body b at the joint's point; what acts on the ground balances the rest."""
        position, turn = self.model.poses(q)
        carrier = Carrier(self.system, position, turn)
        point = joint.reaction_points(carrier)
        if joint.b is GROUND:
            force = -wrenches[:, :-1, :3].sum(axis=1)
            moment = -(wrenches[:, :-1, 3:] + np.cross(position, wrenches[:, :-1, :3])).sum(axis=1)
            return Load(force, moment - np.cross(point, force))
        b = self.system.bodies.index(joint.b)
        force, moment = wrenches[:, b, :3], wrenches[:, b, 3:]
        return Load(force, moment - np.cross(point - position[:, b], force))


class Carrier:
    """Points and axes of bodies over time, as the joints ask for them."""

    def __init__(self, system: Any, position: Array, turn: Array) -> None:
        self.index = {id(body): i for i, body in enumerate(system.bodies)}
        self.position, self.axes = position, matrix(turn)

    def body_axis(self, body: Any, axis: Array) -> Array:
        """(samples, 3) of an axis given in the world at the reference pose."""
        if body is GROUND:
            return np.broadcast_to(axis, (len(self.position), 3))
        return self.axes[:, self.index[id(body)]] @ axis

    def body_point(self, body: Any, point: Array) -> Array:
        """(samples, 3) of a point given in the world at the reference pose."""
        if body is GROUND:
            return np.broadcast_to(point, (len(self.position), 3))
        return self.position[:, self.index[id(body)]] + self.body_axis(body, point - body.position)


def snapshot(mbs: Any, t: float, sensors: Any, factors: Any, configuration: Any) -> Array:
    """All coordinates, velocities and multipliers: one call of Python per sample."""
    data = mbs.systemData
    return np.concatenate(
        [
            data.GetODE2Coordinates(configuration),
            data.GetODE2Coordinates_t(configuration),
            data.GetAECoordinates(configuration),
        ]
    )
