"""Counterpart model of free bodies and joints between them: absolute coordinates and constraints."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mbsd3d import GROUND, Body, Joint, State, System
from mbsd3d.extend import Coupling, Ground, matrix, multiply, one_thread, spanning
from validation.twins.base import Array, Kinetic, Load, Motion, NotExpressible, check_run
from validation.twins.exudyn.assembly import Assembly, Equations
from validation.twins.exudyn.joints import add_force_element, add_joint
from validation.twins.exudyn.solvers import SOLVERS, Scheme, check_samples, march, opened, quiet

SPARSE_BODIES_MIN = 10
"""Bodies from which the sparse linear solver is the faster one: chains, measured; 23 times faster at 60 bodies."""


class BodyTwin:
    """Counterpart model in absolute coordinates, see `validation.twins.base.Twin`; ``mbs`` is the system of Exudyn, for
    own settings.

    Where nothing else is asked for: bodies without joints by RK67; rows that repeat none by the index-2 trapezoidal
    rule, whose multipliers are of second order from the first sample on; else generalized-alpha, with full pivoting:
    where rows repeat each other no reactions are reported, they are one choice among many.

    ``module``: `exudyn`; ``state``: the start; ``rotation``: a key of `ROTATIONS`; ``**scheme``: of
    `Scheme`.
    """

    engine = "Exudyn"

    def __init__(self, module: Any, system: System, state: State, rotation: str, **scheme: Any) -> None:
        self.module, self.system, self.state, self.rotation = module, system, state, rotation
        Scheme(**scheme)  # refuses what it does not know before anything is built
        self.build()
        self.counts = {} if is_forest(system) else self.counted()
        self.repeated = self.counts.get("redundantConstraints", 0)  # a forest of joints has no repeated rows
        self.scheme = Scheme(**self.fitting() | scheme)
        if system.joints and not self.scheme.implicit:
            raise NotExpressible(
                f"joint '{system.name(system.joints[0])}': {self.scheme} takes no constraints; choose an implicit "
                "solver, or formulation='kinematic tree' for a tree of hinges and guides"
            )
        self.order = float(SOLVERS[self.scheme.solver][1])
        self.settings = f"rigid bodies with {rotation}s, {self.scheme}"

    def build(self) -> None:
        """Build the system of Exudyn."""
        self.model = Assembly(self.module, self.system, self.state, self.rotation)
        for joint in self.system.joints:
            add_joint(self.model, joint)
        for force in self.system.forces:
            add_force_element(self.model, force)
        self.mbs, item = self.model.mbs, self.module.itemInterface.SensorUserFunction
        self.recorder = self.mbs.AddSensor(item(sensorUserFunction=snapshot, storeInternal=True, writeToFile=False))
        self.mbs.Assemble()

    def fitting(self) -> dict[str, Any]:
        """Return solver, linear solver and tolerance that fit the system.

        Multipliers need Newton's iterations closer than motions do; with repeated rows left in, the residual of short
        steps does not fall that far.
        """
        if not self.system.joints:
            return {"solver": "rk67"}
        if self.repeated:
            return {"solver": "generalized-alpha", "linear": "full-pivot"}
        linear = "sparse" if len(self.system.bodies) > SPARSE_BODIES_MIN else "dense"
        return {"solver": "index2", "linear": linear, "tolerance": 1e-10}

    def degrees_of_freedom(self) -> dict[str, int]:
        """Return Exudyn's own count of all rows: 'degreeOfFreedom', 'redundantConstraints', 'nODE2', 'nAE', 'nPureAE'.

        'nAE' counts 'nPureAE' rows "multiplier = 0" too, which do not belong to the mechanism.
        """
        return dict(self.counts or self.counted())

    def counted(self) -> dict[str, int]:
        """Return the count of the existing rows."""
        with quiet(self.module), one_thread():
            return {key: int(value) for key, value in self.mbs.ComputeSystemDegreeOfFreedom().items()}

    def equations(self) -> Equations:
        """Return the equations at the start."""
        return Equations(self.model, opened(self.module, self.mbs, self.state.t), self.repeated > 0)

    def kinetic(self) -> Kinetic:
        """Return the mass matrix at the start, and the map from Exudyn's velocities."""
        equations = self.equations()
        M, own = equations.mass_matrix(), self.model.width
        return Kinetic(M[:own, :own], self.model.rates(self.model.poses(equations.q[None])[1][0]))

    def accelerations(self) -> Array:
        """Return the accelerations at the start, from Exudyn's M, f, J; see `equations`; shape (bodies, 6)."""
        return self.equations().accelerations()

    def run(self, t_end: float, steps: int, samples: int) -> Motion:
        """Integrate as `Twin.run`; raise ValueError for samples off the steps, and tables that end before."""
        check_run(self.engine, self.system, self.state.t, t_end, steps, samples)
        every = self.scheme.records(steps, samples, len(self.system.bodies))
        first = self.equations().begin_with_accelerations() if self.scheme.implicit else 0.0
        seconds = march(self.module, self.mbs, self.scheme, self.state.t, t_end, steps, samples * every)
        table = np.array(self.mbs.GetSensorStoredData(self.recorder))
        t = check_samples(table[:, 0], self.state.t, t_end, samples * every, table[:, 1:])[::every]
        n = self.mbs.systemData.ODE2Size()
        q, u, lam = np.split(table[::every, 1:], [n, 2 * n], axis=1)
        lam[0] = first
        position, turn = self.model.poses(q)
        v, orientation = self.model.velocities(turn, u), multiply(turn, self.model.reference)
        return Motion(t, position, orientation, v[..., :3], v[..., 3:], self.reactions(t, q, u, lam), seconds)

    def reactions(self, t: Array, q: Array, u: Array, lam: Array) -> dict[str, Load]:
        """Return the wrench -J' lam on body b of every joint, moved to the joint's point; none with redundant rows."""
        joints = () if self.repeated else self.system.joints
        if not joints:
            return {}
        equations, k = self.equations(), len(self.system.bodies)
        items = [self.model.objects[id(joint)] for joint in joints]
        rows = [np.concatenate([self.mbs.systemData.GetObjectLTGAE(item) for item in own]) for own in items]
        position, turn = self.model.poses(q)
        wrenches = np.zeros((len(t), len(joints), k, 6))  # on all bodies about their O, in world axes
        for i in range(len(t)):
            equations.load(q[i], u[i], t[i])
            J = equations.jacobian()
            for n, own in enumerate(rows):
                wrenches[i, n] = self.model.wrenches(turn[i], -J[own].T @ lam[i, own])
        carrier = Carrier(self.system, position, turn)
        return {self.system.name(j): carrier.load(j, wrenches[:, n]) for n, j in enumerate(joints)}


class Carrier:
    """Bodies over time, as joints read points and axes of a solution."""

    def __init__(self, system: System, position: Array, turn: Array) -> None:
        self.index = {id(body): i for i, body in enumerate(system.bodies)}
        self.place, self.axes = position, matrix(turn)

    def body_axis(self, body: Body | Ground, axis: Array) -> Array:
        """Return an axis given in the world at the reference pose, shape (samples, 3)."""
        if isinstance(body, Ground):
            return np.broadcast_to(axis, (len(self.place), 3))
        return self.axes[:, self.index[id(body)]] @ axis

    def body_point(self, body: Body | Ground, point: ArrayLike) -> Array:
        """Return a point given in the world at the reference pose, shape (samples, 3)."""
        if isinstance(body, Ground):
            return np.broadcast_to(point, (len(self.place), 3))
        return self.place[:, self.index[id(body)]] + self.body_axis(body, np.subtract(point, body.position))

    def load(self, joint: Joint, wrenches: Array) -> Load:
        """Return a joint's wrench on its body b at its point; the wrench on the ground balances the rest."""
        point = joint.reaction_points(self)
        if joint.b is GROUND:
            force = -wrenches[..., :3].sum(axis=1)
            moment = -(wrenches[..., 3:] + np.cross(self.place, wrenches[..., :3])).sum(axis=1)
            return Load(force, moment - np.cross(point, force))
        b = self.index[id(joint.b)]
        force, moment = wrenches[:, b, :3], wrenches[:, b, 3:]
        return Load(force, moment - np.cross(point - self.place[:, b], force))


def is_forest(system: System) -> bool:
    """Return whether the joints form trees: no loops, no couplings, no drivers."""
    joints = system.joints
    return len(spanning(joints)) == len(joints) and not any(isinstance(joint, Coupling) for joint in joints)


def snapshot(mbs: Any, t: float, sensors: Any, factors: Any, configuration: Any) -> Array:
    """Return all coordinates, velocities and multipliers by one call of Python per sample."""
    data = mbs.systemData
    return np.concatenate(
        [
            data.GetODE2Coordinates(configuration),
            data.GetODE2Coordinates_t(configuration),
            data.GetAECoordinates(configuration),
        ]
    )
