"""Mechanisms that the tests share: seeded, in general position, reference points off the centres of mass."""

import numpy as np

import mbsd3d
from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    ConstantVelocity,
    Contact,
    Cylindrical,
    Distance,
    Fixed,
    Force,
    Gear,
    Input,
    KnifeEdge,
    Parallel,
    Perpendicular,
    Planar,
    PointOnLine,
    PointOnPlane,
    PositionDriver,
    Prismatic,
    RackPinion,
    Revolute,
    RollingDisc,
    Screw,
    SlideDriver,
    SpeedDriver,
    Spherical,
    SpringDamper,
    State,
    System,
    Torque,
    Universal,
    shapes,
)
from mbsd3d.constraints.assembly import reference_pose
from mbsd3d.equations.jacobian import block_rows, scaled_rows
from mbsd3d.extend import compile_system, load_state
from mbsd3d.kernels.kinematics import kinematics
from mbsd3d.kernels.rows import rows
from mbsd3d.rotations import matrix, multiply
from validation.cases.examples import (  # noqa: F401  # the tests take all of them from here
    EXAMPLES,
    NOT_ON_GROUND,
    across,
    direction,
    middle,
    random_body,
    random_inertia,
    random_orientation,
    rolling_plane,
    signal,
)


def derivative(function, step=1e-3):
    """d function / dh at h = 0, central difference of fourth order: 3e-14 of the fifth derivative, rounding 1e-13."""
    near, far = (function(h) - function(-h) for h in (step, 2 * step))
    return (8 * near - far) / (12 * step)


def moved_reference(body, shift):
    """The same body with its reference point moved by ``shift`` (body axes): com, position and velocity follow."""
    R = matrix(body.orientation)
    arm = R @ np.asarray(shift, float)
    omega = np.zeros(3) if body.omega is None else body.omega
    return Body(
        body.name,
        body.mass,
        body.inertia,
        com=body.com - shift,
        position=body.position + arm,
        orientation=body.orientation,
        velocity=None if body.velocity is None else body.velocity + np.cross(omega, arm),
        omega=body.omega,
    )


def example_system(cls, seed, ground=None):
    """Four general bodies with one joint of ``cls``; ``ground`` = "a" or "b" puts GROUND on that side."""
    rng = np.random.default_rng(seed)
    bodies = [random_body(rng, name) for name in ("one", "two", "three", "four")]
    a, b, c, d = bodies
    a, b = (GROUND if ground == "a" else a), (GROUND if ground == "b" else b)
    return System(bodies=bodies, joints=EXAMPLES[cls](rng, a, b, c, d), gravity=(0.3, -0.7, -9.6))


def rotation_matrix(e):
    """R = 1 + 2 (e0 [e_v]x + [e_v]x^2) / e'e for real or complex (n, 4)."""
    skew = np.zeros((len(e), 3, 3), e.dtype)
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        skew[:, j, i], skew[:, i, j] = e[:, 1 + k], -e[:, 1 + k]
    return np.eye(3) + 2 * (e[:, :1, None] * skew + skew @ skew) / (e * e).sum(axis=1)[:, None, None]


class Evaluation:
    """A system compiled for evaluation at arbitrary states, with e_dot = H w / 2 written out once more."""

    def __init__(self, system, dtype=float, switches=None):
        self.compiled = compile_system(system, switches=switches)
        self.model = self.compiled.model
        self.data = self.compiled.data(dtype)
        self.n = self.model.body.size
        self.dtype = dtype

    def reference(self):
        """(q, v) at the reference pose, v = 0."""
        bodies = self.compiled.system.bodies
        return np.concatenate([np.concatenate([b.position, b.orientation]) for b in bodies]), np.zeros(6 * self.n)

    def general(self, rng, away=0.4):
        """(q, v): a pose off the reference pose and general velocities."""
        q = self.reference()[0].reshape(self.n, 7)
        q[:, :3] += away * rng.normal(size=(self.n, 3))
        turn = np.concatenate([np.ones((self.n, 1)), 0.5 * away * rng.normal(size=(self.n, 3))], axis=1)
        q[:, 3:] = multiply(turn / np.linalg.norm(turn, axis=1)[:, None], q[:, 3:])
        return q.ravel(), rng.normal(size=6 * self.n)

    def rates(self, v, q):
        """q_dot from world velocities: e_dot = (-e_v . w, e0 w + w x e_v) / 2."""
        q, v = q.reshape(self.n, 7), v.reshape(self.n, 6)
        e, w = q[:, 3:], v[:, 3:]
        scalar = -np.einsum("bi,bi->b", e[:, 1:], w)
        vector = e[:, :1] * w + np.cross(w, e[:, 1:])
        return np.concatenate([v[:, :3], scalar[:, None] / 2, vector / 2], axis=1).ravel()

    def normalised(self, q):
        """q with unit quaternions (real arithmetic only; R(e) does not need it)."""
        q = q.reshape(self.n, 7).copy()
        q[:, 3:] /= np.sqrt((q[:, 3:] ** 2).sum(axis=1))[:, None]
        return q.ravel()

    def state(self, q, v):
        """y = (q, u, z), u = (r_dot, R'w)."""
        e, v = q.reshape(self.n, 7)[:, 3:], v.reshape(self.n, 6)
        u = np.concatenate([v[:, :3], np.einsum("bji,bj->bi", rotation_matrix(e), v[:, 3:])], axis=1)
        return np.concatenate([q, u.ravel(), np.zeros(self.model.state.size)]).astype(self.dtype)

    def rows(self, q, v, t):
        """(c, J, b, gamma) at a state."""
        kinematics(self.model, self.data, self.state(q, v))
        rows(self.model, self.data, t)
        row = self.data.row
        return row["c"].copy(), block_rows(self.model, self.data).dense(), row["b"].copy(), row["gamma"].copy()

    def speed(self, q, v, t):
        """J v - b at a state."""
        _, J, b, _ = self.rows(q, v, t)
        return J @ v - b


def consistent_state(system, rng, t=0.0):
    """The reference pose with general velocities that meet J v = b."""
    evaluation = Evaluation(system)
    q, zero = evaluation.reference()
    _, J, b, _ = evaluation.rows(q, zero, t)
    v = rng.normal(size=zero.size)
    for _ in range(2):  # the second solve takes away the rounding of the first
        v += np.linalg.lstsq(J, b - J @ v, rcond=1e-11)[0]
    return State(t, q, v)


TREE = (
    Universal, Revolute, Spherical, Prismatic, Cylindrical, Planar, ConstantVelocity, Fixed, Screw, PointOnLine,
    RollingDisc, Parallel, PointOnPlane, KnifeEdge, Perpendicular, Distance,
)  # fmt: skip


def all_joints_mechanism(seed, *, grounded=True, drivers=True, redundant=True, light=1.0, gravity=(0.4, -0.8, -9.6)):
    """Sixteen bodies in a zigzag, a joint of every type, all drivers, a loop, and a door of two hinges.

    Parameters
    ----------
    grounded : bool
        False leaves it floating, without gravity unless given.
    drivers, redundant : bool
        With a driver of every type (the one of position only on the ground); with a second hinge on one axis.
    light : float
        Mass ratio of every second body to the others.
    """
    rng = np.random.default_rng(seed)
    bodies, joints, previous = [], [], GROUND
    for k, cls in enumerate(TREE):
        place = np.array([0.9 * k, 0.8 * (-1.0) ** k, 0.3 * k % 0.7]) + 0.2 * rng.normal(size=3)
        mass = rng.uniform(0.7, 2.0) * (light if k % 2 else 1.0)
        bodies.append(random_body(rng, f"body{k}", mass=mass, position=place))
        if k or grounded:
            joints += EXAMPLES[cls](rng, previous, bodies[-1], None, None)
        previous = bodies[-1]
    if not grounded:
        bodies.append(random_body(rng, "side", position=bodies[5].position + 1.0))
        joints += EXAMPLES[TREE[0]](rng, bodies[5], bodies[-1], None, None)
    found = {type(joint): joint for joint in joints}
    joints.append(Gear(found[Revolute], found[Cylindrical], ratio=-1.7))
    joints.append(RackPinion(found[Screw], found[Prismatic], radius=0.4))
    joints.append(
        Distance(bodies[3], bodies[8], at_a=bodies[3].position + 0.3, at_b=bodies[8].position - 0.2, name="loop")
    )
    if redundant:
        hinge = found[Revolute]
        joints.append(Revolute(hinge.a, hinge.b, at=hinge.at + 0.6 * hinge.axis, axis=hinge.axis, name="second hinge"))
    if drivers:
        joints.append(AngleDriver(found[Planar], signal(rng)))
        joints.append(SlideDriver(found[Prismatic], signal(rng)))
        joints.append(SpeedDriver(bodies[10], bodies[11], axis=direction(rng), speed=signal(rng, 0.4)))
        if grounded:
            joints.append(PositionDriver(bodies[-1], at=bodies[-1].position + 0.3, signal=(signal(rng), None, None)))
    return System(bodies=bodies, joints=joints, gravity=gravity)


def pendulum(rng=None, *, joint=Revolute, arm=0.6, **fields):
    """(system, body, joint): a body of general shape on a joint of the ground, hanging about 0.6 m beside it."""
    rng = rng or np.random.default_rng(11)
    body = random_body(rng, "bob", **{"position": arm * direction(rng), **fields})
    at, axis = 0.2 * direction(rng), direction(rng)
    made = Spherical(GROUND, body, at=at) if joint is Spherical else joint(GROUND, body, at=at, axis=axis)
    return System(bodies=[body], joints=[made]), body, made


def spinning_wheel(rate):
    """(system, hinge): a wheel of general inertia that nothing loads, so that it turns at its rate [rad/s] for good."""
    axis = np.array([2.0, -3.0, 6.0]) / 7.0
    wheel = Body("wheel", 1.3, (0.11, 0.23, 0.17), com=(0.02, -0.05, 0.03), velocity=(0, 0, 0), omega=rate * axis)
    hinge = Revolute(GROUND, wheel, at=(0, 0, 0), axis=axis)
    return System(bodies=[wheel], joints=[hinge], gravity=(0, 0, 0)), hinge


def dropped_wheel(rng):
    """(height [m], a wheel that falls without turning on a tyre that only presses)."""
    h, damping, m, r = rng.uniform((0.05, 100.0, 10.0, 0.2), (0.3, 800.0, 30.0, 0.4))
    wheel = Body("wheel", m, (0.3 * m * r**2, 0.6 * m * r**2, 0.31 * m * r**2), position=(0.3, -0.2, r + h),
                 velocity=(0, 0, 0), omega=(0, 0, 0))  # fmt: skip
    road = Contact(GROUND, wheel, shapes.Torus(0.9 * r, 0.1 * r, "y"), stiffness=1.5e5, damping=damping)
    return h, System([wheel], forces=[road], gravity=(0, 0, -9.81), name=f"{h:.4f} m, {damping:.1f} N s/m")


def same_rotation(first, second):
    """Greatest distance of unit quaternions that stand for the same rotation up to sign."""
    first, second = np.asarray(first, float), np.asarray(second, float)
    return float(np.minimum(np.abs(first - second).max(axis=-1), np.abs(first + second).max(axis=-1)).max())


def public_classes(base):
    """Concrete public classes below ``base``, by the names the package exports."""
    found = {getattr(mbsd3d, name) for name in mbsd3d.__all__ if isinstance(getattr(mbsd3d, name), type)}
    return {cls for cls in found if issubclass(cls, base) and cls is not base}


def concrete_subclasses(base):
    """All classes of the package below ``base`` that have no subclasses of their own, exported or not."""
    found, queue = set(), [base]
    while queue:
        below = [cls for cls in queue.pop().__subclasses__() if cls.__module__.split(".")[0] == "mbsd3d"]
        queue += below
        found |= {cls for cls in below if not any(c.__module__.startswith("mbsd3d") for c in cls.__subclasses__())}
    return found


def revolute_chain(n, seed=1):
    """A hanging chain of n links with alternating axes, neither along the links nor aligned, r_G != 0."""
    rng = np.random.default_rng(seed)
    axes = [np.array([0.9, 0.4, 0.17]), np.array([-0.35, 0.9, 0.26])]
    along = np.array([0.3, 0.1, -1.0])
    bodies, joints, before, at = [], [], GROUND, np.array([0.2, -0.1, 0.4])
    for k in range(n):
        step = 0.8 * along + 0.02 * rng.normal(size=3)
        mass = rng.uniform(0.8, 1.2)
        body = Body(f"link {k}", mass, random_inertia(rng, mass), com=(0.05, -0.08, 0.03), position=at + 0.4 * step,
                    orientation=random_orientation(rng))  # fmt: skip
        joints.append(Revolute(before, body, at=at, axis=axes[k % 2], name=f"hinge {k}"))
        bodies.append(body)
        before, at = body, at + step
    return System(bodies=bodies, joints=joints)


def random_loops(seed, n=14):
    """n general bodies on a random tree of joints, loops closed by joints that coincide there, doubled hinges, a gear.

    At the reference pose every joint closes, so loops are consistent; some rows repeat others.
    """
    rng = np.random.default_rng(seed)
    bodies, joints = [], []
    kinds = (Revolute, Spherical, Universal, Prismatic, Cylindrical, Fixed, Planar)
    for k in range(n):
        bodies.append(random_body(rng, f"body {k}", position=np.array([0.8 * k, 0.5 * (-1.0) ** k, 0.3 * (k % 3)])))
        before = GROUND if k == 0 else bodies[rng.integers(max(0, k - 3), k)]
        joints += EXAMPLES[kinds[rng.integers(len(kinds))]](rng, before, bodies[-1], None, None)
        if k % 3 == 1:  # a second hinge on the axis of the first: five redundant rows
            joints.append(Revolute(before, bodies[-1], at=middle(rng, before, bodies[-1]), axis=direction(rng)))
            at = joints[-1].at + 0.4 * joints[-1].axis
            joints.append(Revolute(before, bodies[-1], at=at, axis=joints[-1].axis))
    for _ in range(n // 3):
        a, b = rng.choice(n, size=2, replace=False)
        joints += EXAMPLES[kinds[rng.integers(len(kinds))]](rng, bodies[a], bodies[b], None, None)
    hinges = [joint for joint in joints if isinstance(joint, Revolute)]
    joints.append(Gear(hinges[0], hinges[-1], ratio=-1.7))
    return System(bodies=bodies, joints=joints)


def at_reference(system):
    """(compiled, data) with the rows of the reference pose."""
    compiled = compile_system(system)
    data = compiled.data()
    load_state(compiled, data, reference_pose(system))
    return compiled, data


def dense_rows(compiled, data):
    """The whole scaled J."""
    return scaled_rows(compiled.model, data).dense()


def pair_at(o: np.ndarray) -> System:
    """A pendulum of two with a spring to the ground, about a point of the world."""
    arm = Body("arm", 2.0, (0.02, 0.03, 0.04), com=(0.1, -0.2, 0.3), position=o + (0.3, 0.2, 0.1))
    bob = Body("bob", 1.0, (0.03, 0.02, 0.04), position=o + (0.7, 0.1, 0.2))
    hook = Universal(GROUND, arm, at=o + (0.3, 0.25, 0.1), axis_a=(0.6, 0, 0.8), axis_b=(0.0, 1.0, 0.0))
    spring = SpringDamper(GROUND, bob, at_a=o + (1.1, 0.4, 0.7), at_b=o + (0.7, 0.1, 0.3), stiffness=20.0)
    return System([arm, bob], [hook, Spherical(arm, bob, at=o)], [spring])


def crane(**more):
    """A trolley on a slanted rail that is pushed, and a load with its centre of mass off its hinge."""
    rail = np.array([0.8, 0.36, 0.48])
    trolley = Body("trolley", 1.4, (0.1, 0.2, 0.3), com=(0.02, -0.03, 0.01), position=(0.3, 0.1, 0.2))
    load = Body("load", 0.7, (0.02, 0.03, 0.01), com=(0.11, 0.05, -0.4), position=(0.3, 0.1, 0.1))
    joints = [
        Prismatic(GROUND, trolley, at=trolley.position, axis=rail, name="rail"),
        Revolute(trolley, load, at=load.position, axis=(0.2, 1.0, -0.1), name="pin"),
    ]
    push = Input("push", 0.4)
    forces = [
        Force(trolley, tuple(3.0 * x * push for x in rail)),
        Torque(load, (0.0, Input("twist"), 0.0), name="twist"),
    ]
    return System([trolley, load], joints, forces, **more)
