"""Bodies, ground and markers of a `System` in Exudyn, and the equations of motion of Exudyn at a state.

The frame of a body in Exudyn is along the world axes at the reference pose of `mbsd3d` and has the same reference
point O, so a marker is where and how the world sees it there, relative rotations are zero at the reference pose, and
hinge coordinates of both sides count alike. With A the rotation of Exudyn: A = R R_ref'.

    [ M  J' ] [ u_dot ]   [ f                   ]
    [ J  0  ] [  lam  ] = [ -J_dot u + f_t_dot  ]

in its own velocities u. Exudyn has no J_dot and drops the second derivative of prescribed motions when it solves for
the first accelerations; both are differences of its own J u and of its equations on velocities along the motion.
"""

from typing import Any, Protocol

import numpy as np

from mbsd3d import GROUND, State, System
from mbsd3d.extend import Coordinate, H, conjugate, exponential, logarithm, matrix, multiply, on_one_thread, skew
from validation.twins.base import Array, EngineFailed

ROTATIONS = {"rotation vector": 3, "euler parameters": 4}  # How an orientation is described -> coordinates it takes


class ForceModel(Protocol):
    """What force elements add their items to: bodies, or a tree of hinges."""

    system: System
    state: State
    module: Any
    items: Any
    mbs: Any
    zero: int

    def marker(self, body: Any, point: Array, axes: Array | None = None) -> int:
        """Return the marker of a frame on a body."""

    def coordinate(self, x: Coordinate) -> int:
        """Return the marker of a hinge coordinate."""

    def velocity_sensor(self, body: Any, point: Array) -> int:
        """Return a sensor of the world velocity of a body's point."""

    def connect(self, part: Any, item: Any) -> None:
        """Add a connector of a part."""


class Assembly:
    """Mechanism under construction: item numbers of Exudyn by part.

    ``module``: `exudyn`; ``state``: the start; ``rotation``: a key of `ROTATIONS`.
    """

    def __init__(self, module: Any, system: System, state: State, rotation: str) -> None:
        self.system, self.state, self.rotation = system, state, rotation
        self.module, self.items = module, module.itemInterface
        self.container = module.SystemContainer()
        self.mbs = self.container.AddSystem()
        self.body = {id(GROUND): self.mbs.AddObject(self.items.ObjectGround())}
        self.nodes: dict[int, int] = {}
        self.reference = np.array([body.orientation for body in system.bodies])
        self.start = multiply(state.q.reshape(-1, 7)[:, 3:], conjugate(self.reference))
        for k, body in enumerate(system.bodies):
            self.body[id(body)] = self.add_body(k, body)
        self.objects: dict[int, list[int]] = {}
        self.zero_node = self.mbs.AddNode(self.items.NodePointGround())
        self.zero = self.mbs.AddMarker(self.items.MarkerNodeCoordinate(nodeNumber=self.zero_node, coordinate=0))

    @property
    def width(self) -> int:
        """Return the number of coordinates of the bodies; behind them are those whose velocities are internal states of
        forces.
        """
        return len(self.system.bodies) * (3 + ROTATIONS[self.rotation])

    def add_body(self, k: int, body: Any) -> int:
        """Add a rigid body with its weight."""
        q, v = self.state.q.reshape(-1, 7)[k], self.state.v.reshape(-1, 6)[k]
        com, inertia = body.axes @ body.com, body.axes @ body.inertia @ body.axes.T
        I_O = inertia + body.mass * skew(com) @ skew(com).T  # Exudyn wants it about O
        shift, e = q[:3] - body.position, self.start[k]
        rest: tuple[int, ...]
        if self.rotation == "rotation vector":
            node, rest, turn = self.items.NodeRigidBodyRotVecLG, (0, 0, 0), logarithm(e)
        else:
            node, rest, turn = self.items.NodeRigidBodyEP, (1, 0, 0, 0), e - (1, 0, 0, 0)
        self.nodes[id(body)] = self.mbs.AddNode(
            node(
                referenceCoordinates=[*body.position, *rest], initialCoordinates=[*shift, *turn],
                initialVelocities=[*v[:3], *(self.unspin(e) @ v[3:])],
            )
        )  # fmt: skip
        number = self.mbs.AddObject(
            self.items.ObjectRigidBody(
                mass=body.mass, centerOfMass=com, nodeNumber=self.nodes[id(body)],
                inertia=[I_O[0, 0], I_O[1, 1], I_O[2, 2], I_O[1, 2], I_O[0, 2], I_O[0, 1]],
            )
        )  # fmt: skip
        if self.system.gravity.any():
            mass = self.mbs.AddMarker(self.items.MarkerBodyMass(bodyNumber=number))
            self.mbs.AddLoad(self.items.LoadMassProportional(markerNumber=mass, loadVector=self.system.gravity))
        return number

    def marker(self, body: Any, point: Array, axes: Array | None = None) -> int:
        """Return the marker of a frame on a body: point and axes (columns), world at the reference pose."""
        place = np.eye(4)
        place[:3, 3] = point - body.position
        if axes is not None:
            place[:3, :3] = axes
        return self.mbs.AddMarker(self.items.MarkerBodyRigid(bodyNumber=self.body[id(body)], localHT=place))

    def velocity_sensor(self, body: Any, point: Array) -> int:
        """Return a sensor of the world velocity of a body's point."""
        item = self.items.SensorBody(
            bodyNumber=self.body[id(body)], localPosition=point - body.position, writeToFile=False,
            outputVariableType=self.module.OutputVariableType.Velocity,
        )  # fmt: skip
        return self.mbs.AddSensor(item)

    def coordinate(self, x: Coordinate, counted: bool = True) -> int:
        """Return the marker of a hinge coordinate; angles are unwrapped from step to step by a data node, if
        counted."""
        bodies = [self.body[id(x.a)], self.body[id(x.b)]]
        if x.kind == "slide":
            return self.mbs.AddMarker(
                self.items.MarkerBodiesRelativeTranslationCoordinate(
                    bodyNumbers=bodies, axis0=x.axis,
                    localPosition0=x.point_a - x.a.position, localPosition1=x.point_b - x.b.position,
                )
            )  # fmt: skip
        turns = {}
        if counted:
            angle = self.angle_at_start(x)
            node = self.items.NodeGenericData(numberOfDataCoordinates=1, initialCoordinates=[angle])
            turns = {"nodeNumber": self.mbs.AddNode(node)}
        return self.mbs.AddMarker(
            self.items.MarkerBodiesRelativeRotationCoordinate(bodyNumbers=bodies, axis0=x.axis, **turns)
        )

    def angle_at_start(self, x: Coordinate) -> float:
        """Return the angle of a hinge at the start [rad], with its turns."""
        if self.state.coordinates is not None:
            return float(self.state.coordinates[self.system.lowered.coordinate(x)])
        turn = {id(GROUND): np.array([1.0, 0.0, 0.0, 0.0])}
        turn |= {id(body): e for body, e in zip(self.system.bodies, self.start, strict=True)}
        relative = multiply(conjugate(turn[id(x.a)]), turn[id(x.b)])
        return float(np.remainder(2 * np.arctan2(relative[1:] @ x.axis, relative[0]) + np.pi, 2 * np.pi) - np.pi)

    def connect(self, part: Any, item: Any) -> None:
        """Add a connector of a joint or force."""
        self.objects.setdefault(id(part), []).append(self.mbs.AddObject(item))

    def poses(self, q: Array) -> tuple[Array, Array]:
        """Return (n, bodies, 3) positions of O and (n, bodies, 4) Exudyn's rotations from coordinates (n, all)."""
        x = q[:, : self.width].reshape(len(q), len(self.system.bodies), -1)
        position = x[..., :3] + [body.position for body in self.system.bodies]
        if self.rotation == "rotation vector":
            return position, exponential(x[..., 3:])
        e = x[..., 3:] + (1.0, 0.0, 0.0, 0.0)
        return position, e / np.linalg.norm(e, axis=-1, keepdims=True)

    def spin(self, e: Array) -> Array:
        """Return the matrices from Exudyn's rates of rotation to world angular velocity, at rotations e (..., 4), shape
        (..., 3, k).
        """
        return matrix(e) if self.rotation == "rotation vector" else 2 * H(e).swapaxes(-1, -2)

    def unspin(self, e: Array) -> Array:
        """Return the inverse matrices; transposed, world moments from Exudyn's generalised ones; shape (..., k, 3)."""
        return matrix(e).swapaxes(-1, -2) if self.rotation == "rotation vector" else 0.5 * H(e)

    def velocities(self, e: Array, u: Array) -> Array:
        """Return (r_dot, w) from rotations (n, bodies, 4) and Exudyn's velocities (n, all), shape (n, bodies, 6)."""
        u = u[:, : self.width].reshape(*e.shape[:2], -1)
        return np.concatenate([u[..., :3], (self.spin(e) @ u[..., 3:, None])[..., 0]], axis=-1)

    def wrenches(self, e: Array, g: Array) -> Array:
        """Return force and moment about O in world axes from Exudyn's generalised forces (all,), shape (bodies, 6)."""
        g = g[: self.width].reshape(len(e), -1)
        return np.concatenate([g[:, :3], (self.unspin(e).swapaxes(1, 2) @ g[:, 3:, None])[..., 0]], axis=1)

    def rates(self, e: Array) -> Array:
        """Return the matrix from Exudyn's velocities to (r_dot, w) of all bodies, at rotations e (bodies, 4), shape (6
        bodies, m).
        """
        k = 3 + ROTATIONS[self.rotation]
        out = np.zeros((6 * len(e), k * len(e)))
        for i, spin in enumerate(self.spin(e)):
            out[6 * i : 6 * i + 3, k * i : k * i + 3] = np.eye(3)
            out[6 * i + 3 : 6 * i + 6, k * i + 3 : k * i + k] = spin
        return out


DIFFERENCE_STEP = 2e-3
"""Of the differences, in times the reciprocal of the fastest rate: 3e-14 of the fifth derivative against rounding."""


class Equations:
    """Assembled model at its start, and at any state that is loaded; ``repeated``: redundant rows."""

    def __init__(self, model: Assembly, solver: Any, repeated: bool) -> None:
        self.model, self.mbs, self.solver, self.repeated = model, model.mbs, solver, repeated
        self.q = np.array(self.mbs.systemData.GetODE2Coordinates())
        self.u = np.array(self.mbs.systemData.GetODE2Coordinates_t())
        self.size, self.rows = len(self.q), self.mbs.systemData.AEsize()

    def load(self, q: Array, u: Array, t: float) -> None:
        """Set the current state."""
        now = self.model.module.ConfigurationType.Current
        self.mbs.systemData.SetODE2Coordinates(q, now)
        self.mbs.systemData.SetODE2Coordinates_t(u, now)
        self.mbs.systemData.SetTime(t, now)

    def mass_matrix(self) -> Array:
        """Return M at the current state."""
        self.solver.ComputeMassMatrix(self.mbs)
        return np.array(self.solver.GetSystemMassMatrix())

    def force(self) -> Array:
        """Return f at the current state."""
        self.solver.ComputeODE2RHS(self.mbs)
        return np.array(self.solver.GetSystemResidual())[: self.size]

    def jacobian(self) -> Array:
        """Return J at the current state, for rows on positions and on velocities."""
        if not self.rows:
            return np.zeros((0, self.size))
        self.solver.SetSystemJacobian(np.zeros((self.size + self.rows,) * 2))
        self.solver.ComputeJacobianAE(self.mbs, 1.0, 1.0, 1.0, False)
        return np.array(self.solver.GetSystemJacobian())[self.size :, : self.size]

    def speeds(self) -> Array:
        """Return the residuals of the rows on velocities at the current state."""
        self.solver.ComputeAlgebraicEquations(self.mbs, True)
        return np.array(self.solver.GetSystemResidual())[self.size :]

    def moved(self, h: float) -> Array:
        """Return the coordinates of the start moved by its velocities for a time h [s]."""
        k, width = len(self.model.system.bodies), self.model.width
        q, u = self.q[:width].reshape(k, -1).copy(), self.u[:width].reshape(k, -1)
        q[:, :3] += h * u[:, :3]
        e = self.model.poses(self.q[None])[1][0]
        if self.model.rotation == "rotation vector":
            q[:, 3:] = logarithm(multiply(e, exponential(h * u[:, 3:])))
        else:  # the sphere's own great circle
            rate = np.linalg.norm(u[:, 3:], axis=1, keepdims=True)
            q[:, 3:] = np.cos(h * rate) * e + h * np.sinc(h * rate / np.pi) * u[:, 3:] - (1.0, 0.0, 0.0, 0.0)
        return np.concatenate([q.ravel(), self.q[width:]])

    def bias(self) -> Array:
        """Return J u_dot of the rows at the start: -J_dot u and the terms of prescribed motions."""
        t, h = self.model.state.t, DIFFERENCE_STEP / max(1.0, float(np.abs(self.u).max()))

        def rates(h: float) -> Array:
            self.load(self.moved(h), self.u, t)
            turning = self.jacobian() @ self.u
            self.load(self.q, self.u, t + h)
            return turning + self.speeds()

        near, far = rates(h) - rates(-h), rates(2 * h) - rates(-2 * h)
        return -(8 * near - far) / (12 * h)

    @on_one_thread
    def change(self) -> tuple[Array, Array]:
        """Return u_dot and multipliers at the start; of least norm with redundant rows."""
        right = self.bias()
        self.load(self.q, self.u, self.model.state.t)
        M, J, lam = self.mass_matrix(), self.jacobian(), np.zeros(self.rows)
        own = J.any(axis=1)  # Exudyn has a row "multiplier = 0" for every free direction of a joint
        left = np.block([[M, J[own].T], [J[own], np.zeros((own.sum(),) * 2)]])
        both = np.concatenate([self.force(), right[own]])
        try:
            found = np.linalg.lstsq(left, both, rcond=1e-11)[0] if self.repeated else np.linalg.solve(left, both)
        except np.linalg.LinAlgError as error:
            raise EngineFailed(f"Exudyn's equations have no solution at the start: {error}") from None
        lam[own] = found[self.size :]
        return found[: self.size], lam

    def accelerations(self) -> Array:
        """Return d/dt (r_dot, w) at the start, shape (bodies, 6)."""
        e = self.model.poses(self.q[None])[1][0]
        change = self.change()[0][: self.model.width]
        return (self.model.rates(e) @ change).reshape(-1, 6)  # the change of the map adds A (W x W) = 0

    def begin_with_accelerations(self) -> Array:
        """Set the initial accelerations of every run; return their multipliers.

        Exudyn's own solve forgets how prescribed motions accelerate, and its first sample holds no multipliers.
        """
        change, multipliers = self.change()
        self.mbs.systemData.SetODE2Coordinates_tt(change, self.model.module.ConfigurationType.Initial)
        return multipliers
