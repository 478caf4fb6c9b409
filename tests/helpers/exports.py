"""Random mechanisms of general values, and their states in the frames of exported files."""

import mujoco
import numpy as np

import mbsd3d
from helpers.mujoco_states import general_motion, state_of
from mbsd3d import GROUND, Body, Prismatic, Revolute, State, System, TorsionSpring, accelerations
from mbsd3d.extend import matrix, quaternion_from_matrix

TREE_JOINTS = ("Revolute", "Prismatic", "Cylindrical", "Universal", "Planar", "Spherical", "Fixed")
PLAIN_JOINTS = ("Revolute", "Prismatic", "Fixed")


def direction(rng):
    """A unit vector in no special direction."""
    x = rng.normal(size=3)
    return x / np.linalg.norm(x)


def body(rng, name):
    """A body with r_G != 0, oblique principal axes and orientation."""
    A = rng.normal(size=(3, 3))
    inertia = 0.1 * (np.trace(A @ A.T) * np.eye(3) - A @ A.T) + 0.01 * np.eye(3)  # of points of mass: a body has it
    e = rng.normal(size=4)
    place = {
        "com": 0.2 * rng.normal(size=3),
        "position": 0.5 * rng.normal(size=3),
        "orientation": e / np.linalg.norm(e),
    }
    return Body(name, rng.uniform(0.5, 3.0), inertia, **place)


def joint(rng, kind, a, b, name):
    """A joint at a general place, with its bodies in either order."""
    if rng.random() < 0.5:
        a, b = b, a
    at, axis, cls = 0.5 * rng.normal(size=3), direction(rng), getattr(mbsd3d, kind)
    if kind == "Universal":
        across = np.cross(axis, direction(rng))
        return cls(a, b, at=at, axis_a=axis, axis_b=across / np.linalg.norm(across), name=name)
    if kind == "Planar":
        return cls(a, b, at=at, normal=axis, name=name)
    return cls(a, b, at=at, name=name, **({} if kind in ("Spherical", "Fixed") else {"axis": axis}))


def random_tree(seed, kinds=TREE_JOINTS, count=5, springs=False):
    """A tree of bodies on the ground, or of a floating base for odd seeds."""
    rng = np.random.default_rng(seed)
    bodies, joints = [body(rng, f"b{i}") for i in range(count)], []
    for i, one in enumerate(bodies):
        before = bodies[rng.integers(i)] if i else GROUND
        if i or seed % 2 == 0:
            joints.append(joint(rng, rng.choice(kinds) if i else "Revolute", before, one, f"j{i}"))
    hinges = [x for x in joints if isinstance(x, Revolute | Prismatic)]
    loads = [TorsionSpring(x, stiffness=springs * 3.0, damping=0.4, angle=0.3, name=f"{x.name} spring") for x in hinges]
    return System(bodies, joints, loads)


def states_of(system, text, count=20):
    """(model, data) of MuJoCo and the state here, at random poses and velocities."""
    model = mujoco.MjModel.from_xml_string(text)
    for seed in range(count):
        data = general_motion(model, seed, angle=0.6)  # poses do not show whole turns
        yield model, data, state_of(system, model, data)


def poses(system, state):
    """Name -> r, R, r_dot, w of every body."""
    q, v = state.q.reshape(-1, 7), state.v.reshape(-1, 6)
    return {b.name: (q[i, :3], matrix(q[i, 3:]), v[i, :3], v[i, 3:]) for i, b in enumerate(system.bodies)}


def carried(system, state, read, frames):
    """The same state of a system that was read back, whose bodies have the frames of the file."""
    found, q, v = poses(system, state), [], []
    for one in read.bodies:
        frame = frames[one.name]
        r, R, r_dot, w = found[frame.body]
        d = R @ frame.position
        q += [*(r + d), *quaternion_from_matrix(R @ frame.axes)]
        v += [*(r_dot + np.cross(w, d)), *w]
    return State(0.0, np.array(q), np.array(v))


def brought_back(system, state, read, frames):
    """The state of the system whose export was read back, from one of the latter that knows all frames."""
    found, where = poses(read, state), {point.body: (name, point) for name, point in frames.items()}
    q, v = [], []
    for one in system.bodies:
        name, frame = where[one.name]
        r, R, r_dot, w = found[name]
        axes = R @ frame.axes.T
        d = -axes @ frame.position
        q += [*(r + d), *quaternion_from_matrix(axes)]
        v += [*(r_dot + np.cross(w, d)), *w]
    return State(0.0, np.array(q), np.array(v))


def difference(system, state, read, there, frames):
    """Largest difference of accelerations of O and angular ones, over the largest of them."""
    ours, theirs, w = accelerations(system, state), accelerations(read, there), poses(system, state)
    largest, worst = 0.0, 0.0
    for one in read.bodies:
        if one.name not in frames:  # without mass, between joints
            continue
        frame = frames[one.name]
        _, R, _, omega = w[frame.body]
        d, alpha = R @ frame.position, ours.alpha(frame.body)[0]
        a = ours.acceleration(frame.body)[0] + np.cross(alpha, d) + np.cross(omega, np.cross(omega, d))
        wanted = np.concatenate([a, alpha])
        found = np.concatenate([theirs.acceleration(one)[0], theirs.alpha(one)[0]])
        largest, worst = max(largest, np.abs(wanted).max()), max(worst, np.abs(found - wanted).max())
    return worst / largest


def read_back(system, made, read, count=20):
    """Largest difference of a tree from what was read back of its export, at random states of MuJoCo."""
    text, worst = system.to_mjcf(leave_out=system.forces).text, 0.0
    for _, _, state in states_of(system, text, count):
        worst = max(worst, difference(system, state, read, carried(system, state, read, made.frames), made.frames))
    return worst


def read_back_by_coordinates(system, made, read, driven, reach=0.5, count=20):
    """The same from random values and rates of coordinates of what was read back, assembled there."""
    rng, worst = np.random.default_rng(0), 0.0
    for _ in range(count):
        values, rates = ({x: scale * rng.normal() for x in driven} for scale in (reach, 2.0))
        slides = {x: 0.2 * values[x] for x in driven if read.part(x, "joints").angle() is None}
        angles = {x: values[x] for x in driven if x not in slides}
        there = read.assemble(angles=angles, slides=slides, rates=rates)
        state = brought_back(system, there, read, made.frames)
        worst = max(worst, difference(system, state, read, there, made.frames))
    return worst
