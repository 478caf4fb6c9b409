"""Counterpart model of a tree in its hinge coordinates; also for explicit solvers."""

from functools import cached_property
from typing import Any

import numpy as np

from mbsd3d import GROUND, State, System
from mbsd3d.extend import Coordinate, multiply, quaternion_from_matrix
from validation.twins.base import Array, Kinetic, Motion, NotExpressible, check_run
from validation.twins.exudyn.joints import add_force_element
from validation.twins.exudyn.solvers import SOLVERS, Scheme, check_samples, march, opened
from validation.twins.exudyn.tree import SHIFT, TURN, Frame, Link, links_of

OUTPUTS = ("Position", "RotationMatrix", "Velocity", "AngularVelocity")
ACCELERATION_OUTPUTS = ("Acceleration", "AngularAcceleration")
WORLD_FRAME = Frame(np.zeros(3), np.eye(3))


class Tree:
    """Items of Exudyn for one tree, with the interface of `Assembly` for force elements."""

    def __init__(self, module: Any, system: System, state: State) -> None:
        self.module, self.items, self.system, self.state = module, module.itemInterface, system, state
        self.links, self.numbers = links_of(system, state)
        self.container = module.SystemContainer()
        self.mbs = self.container.AddSystem()
        self.ground = self.mbs.AddObject(self.items.ObjectGround())
        self.zero = self.mbs.AddMarker(
            self.items.MarkerNodeCoordinate(nodeNumber=self.mbs.AddNode(self.items.NodePointGround()), coordinate=0)
        )
        n = len(self.links)
        self.node = self.mbs.AddNode(
            self.items.NodeGenericODE2(
                numberOfODE2Coordinates=n, referenceCoordinates=[0.0] * n, initialCoordinates_t=[0.0] * n,
                initialCoordinates=[link.value for link in self.links],
            )
        )  # fmt: skip
        self.object = self.mbs.AddObject(self.tree_item())
        self.link_of = {id(link.body): k for k, link in enumerate(self.links) if link.body is not None}

    def tree_item(self) -> Any:
        """Return the item of all links."""
        module, here = self.module, [link.here for link in self.links]
        parents = [WORLD_FRAME if link.parent < 0 else here[link.parent] for link in self.links]
        turns = [up.axes.T @ link.there.axes for up, link in zip(parents, self.links, strict=True)]
        offsets = [up.axes.T @ (link.there.point - up.point) for up, link in zip(parents, self.links, strict=True)]
        masses, centres, inertias = map(list, zip(*(own_inertia(link) for link in self.links), strict=True))
        return self.items.ObjectKinematicTree(
            nodeNumber=self.node, gravity=self.system.gravity, linkParents=[link.parent for link in self.links],
            jointTypes=[getattr(module.JointType, link.kind) for link in self.links],
            jointTransformations=module.Matrix3DList(turns), jointOffsets=module.Vector3DList(offsets),
            linkMasses=masses, linkCOMs=module.Vector3DList(centres), linkInertiasCOM=module.Matrix3DList(inertias),
        )  # fmt: skip

    def marker(self, body: Any, point: Array, axes: Array | None = None) -> int:
        """Return the marker of a frame on a link or on the ground: point and axes (columns), world at the reference
        pose.
        """
        place, axes = np.eye(4), np.eye(3) if axes is None else axes
        if body is GROUND:
            place[:3, :3], place[:3, 3] = axes, point
            return self.mbs.AddMarker(self.items.MarkerBodyRigid(bodyNumber=self.ground, localHT=place))
        k = self.link_of[id(body)]
        here = self.links[k].here
        place[:3, :3], place[:3, 3] = here.axes.T @ axes, here.axes.T @ (point - here.point)
        return self.mbs.AddMarker(
            self.items.MarkerKinematicTreeRigid(objectNumber=self.object, linkNumber=k, localHT=place)
        )

    def coordinate(self, x: Coordinate) -> int:
        """Return the marker of a hinge coordinate."""
        kind = TURN if x.kind == "angle" else SHIFT
        for joint in self.system.joints:
            found = joint.angle() if kind == TURN else joint.slide()
            if found is not None and (found.a, found.b) == (x.a, x.b) and (found.axis == x.axis).all():
                return self.mbs.AddMarker(
                    self.items.MarkerNodeCoordinate(nodeNumber=self.node, coordinate=self.numbers[kind, id(joint)])
                )
        raise NotExpressible(f"an {x.kind} between '{x.a.name}' and '{x.b.name}': no hinge of the tree has it")

    def sensor(self, body: Any, point: Array, output: str) -> int:
        """Return a sensor at a point of a body, world at the reference pose; sensors of the motion are stored."""
        k = self.link_of[id(body)]
        here = self.links[k].here
        item = self.items.SensorKinematicTree(
            objectNumber=self.object, linkNumber=k, localPosition=here.axes.T @ (point - here.point),
            outputVariableType=getattr(self.module.OutputVariableType, output), writeToFile=False,
            storeInternal=output in OUTPUTS,
        )  # fmt: skip
        return self.mbs.AddSensor(item)

    def velocity_sensor(self, body: Any, point: Array) -> int:
        """Return a sensor of the world velocity of a body's point."""
        return self.sensor(body, point, "Velocity")

    def connect(self, part: Any, item: Any) -> None:
        """Add a connector of a force element."""
        self.mbs.AddObject(item)


def own_inertia(link: Link) -> tuple[float, Array, Array]:
    """Return mass, centre and central inertia in the frame of a link."""
    body, here = link.body, link.here
    if body is None:
        return 0.0, np.zeros(3), np.zeros((3, 3))
    turn = here.axes.T @ body.axes
    return body.mass, here.axes.T @ (body.centre - here.point), turn @ body.inertia @ turn.T


class TreeTwin:
    """Counterpart model in hinge coordinates, see `validation.twins.base.Twin`; ``mbs`` is the system of Exudyn, for
    own settings.

    It reports no reactions: hinge coordinates have no constraint forces.
    """

    engine = "Exudyn"

    def __init__(self, module: Any, system: System, state: State, **scheme: Any) -> None:
        self.module, self.system, self.state = module, system, state
        self.scheme = Scheme(**{"solver": "rk67"} | scheme)
        self.model = Tree(module, system, state)
        for force in system.forces:
            add_force_element(self.model, force)
        self.mbs = self.model.mbs
        self.sensors, self.later = (
            {name: self.at_origins(name) for name in names} for names in (OUTPUTS, ACCELERATION_OUTPUTS)
        )
        item = module.itemInterface.SensorUserFunction(sensorUserFunction=pulse, storeInternal=True, writeToFile=False)
        self.mbs.AddSensor(item)
        self.mbs.Assemble()
        self.order, self.settings = float(SOLVERS[self.scheme.solver][1]), f"kinematic tree, {self.scheme}"
        self.start()

    def at_origins(self, output: str) -> list[int]:
        """Return a sensor at the reference point of every body."""
        return [self.model.sensor(body, body.position, output) for body in self.system.bodies]

    def start(self) -> None:
        """Set the hinge rates of the start: those whose velocities of the bodies are the given ones."""
        rates, off = np.zeros(len(self.model.links)), 0.0
        if self.state.v.any():
            rates = np.linalg.lstsq(self.map, self.state.v, rcond=None)[0]
            off = np.abs(self.map @ rates - self.state.v).max()
        if off > 1e-8 * max(1.0, float(np.abs(self.state.v).max())):  # consistent starts are exact to 1e-12
            raise NotExpressible(f"the velocities at the start miss the joints by {off:.2g}; assemble the state first")
        for configuration in (self.module.ConfigurationType.Initial, self.module.ConfigurationType.Current):
            self.mbs.systemData.SetODE2Coordinates_t(rates, configuration)

    def values(self, *sensors: list[int]) -> Array:
        """Return two vectors per body, shape (6 bodies,)."""
        pairs = [[self.mbs.GetSensorValues(k) for k in own] for own in zip(*sensors, strict=True)]
        return np.array(pairs, float).ravel()

    @cached_property
    def map(self) -> Array:
        """Return the matrix from hinge rates to (r_dot, w) of the bodies at the start, shape (6 bodies, m); slow for
        hundreds of links.
        """
        now, n = self.module.ConfigurationType.Current, len(self.model.links)
        before = np.array(self.mbs.systemData.GetODE2Coordinates_t(now))
        out = np.empty((6 * len(self.system.bodies), n))
        for k, unit in enumerate(np.eye(n)):
            self.mbs.systemData.SetODE2Coordinates_t(unit, now)
            out[:, k] = self.values(self.sensors["Velocity"], self.sensors["AngularVelocity"])
        self.mbs.systemData.SetODE2Coordinates_t(before, now)
        return out

    def kinetic(self) -> Kinetic:
        """Return the mass matrix in the hinge rates at the start."""
        solver = opened(self.module, self.mbs, self.state.t)
        solver.ComputeMassMatrix(self.mbs)
        return Kinetic(np.array(solver.GetSystemMassMatrix()), self.map)

    def change(self) -> Array:
        """Return the accelerations of the hinge coordinates at the start, from Exudyn's M and right side; they become
        current.
        """
        solver = opened(self.module, self.mbs, self.state.t)
        solver.ComputeMassMatrix(self.mbs)
        solver.ComputeODE2RHS(self.mbs)
        change = np.linalg.solve(solver.GetSystemMassMatrix(), solver.GetSystemResidual()[: len(self.model.links)])
        self.mbs.systemData.SetODE2Coordinates_tt(change, self.module.ConfigurationType.Current)
        return change

    def accelerations(self) -> Array:
        """Return the accelerations at the start, shape (bodies, 6)."""
        self.change()
        return self.values(*self.later.values()).reshape(-1, 6)

    def run(self, t_end: float, steps: int, samples: int) -> Motion:
        """Integrate as `Twin.run`; raise ValueError for samples off the steps, and tables that end before."""
        check_run(self.engine, self.system, self.state.t, t_end, steps, samples)
        every = self.scheme.records(steps, samples, len(self.system.bodies))
        if self.scheme.implicit:
            self.mbs.systemData.SetODE2Coordinates_tt(self.change(), self.module.ConfigurationType.Initial)
        seconds = march(self.module, self.mbs, self.scheme, self.state.t, t_end, steps, samples * every)
        stored = {
            name: np.array([self.mbs.GetSensorStoredData(k) for k in own]).swapaxes(0, 1)
            for name, own in self.sensors.items()
        }
        t = check_samples(stored["Position"][:, 0, 0], self.state.t, t_end, samples * every, *stored.values())[::every]
        position, turn, velocity, omega = (stored[name][::every, :, 1:] for name in OUTPUTS)
        frames = np.array([self.model.links[self.model.link_of[id(body)]].here.axes for body in self.system.bodies])
        turn = turn.reshape(len(t), -1, 3, 3) @ frames.swapaxes(1, 2)
        orientation = multiply(quaternion_from_matrix(turn), np.array([b.orientation for b in self.system.bodies]))
        return Motion(t, position, orientation, velocity, omega, {}, seconds)


def pulse(mbs: Any, t: float, sensors: Any, factors: Any, configuration: Any) -> list[float]:
    """Return to Python for a moment, so that Ctrl-C is noticed."""
    return [t]
