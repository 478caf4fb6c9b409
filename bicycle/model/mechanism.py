"""Whipple bicycle as a mechanism: four bodies, three hinges, two wheels that roll without slip or run on tyres.

World axes of `mbsd3d`: x forward, y left, z up. Lean and steer are positive to the right, as in the paper, whose
parameters have y right and z down. Reference points are the hubs: O of rear wheel and frame at the rear hub, O of fork
and front wheel at the front hub.
"""

from collections.abc import Sequence
from dataclasses import field
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from mbsd3d import (
    GROUND,
    Body,
    Joint,
    JointFriction,
    Revolute,
    RollingDisc,
    Signal,
    State,
    System,
    Torque,
    TorsionSpring,
    measures,
    shapes,
)
from mbsd3d.errors import InputError
from mbsd3d.extend import ForceElement, Measure, as_signal, checks_arguments, cross, part_class

from ..parameters import Parameters, check_set
from .kinematics import Pose, hubs, pose_of, steer_axis, velocities_of
from .tyres import Tyres, tyres_of

NAMES = {"R": "rear wheel", "B": "frame", "H": "fork", "F": "front wheel"}
PAPER_TO_MODEL = np.diag([1.0, -1.0, -1.0])  # from the axes of the paper to those of the model
HEAD_TUBE_LENGTH = 0.12  # [m] of the head tube in drawings


@part_class()
class Bicycle(System):
    """`System` whose reference pose is upright with zero steer, and which starts from another state.

    So the angle of the joint "steer" is the steer angle. `dataclasses.replace` adds forces or joints and keeps the
    start.
    """

    start: State | None = field(default=None, kw_only=True)

    def state(self, *, as_built: float | None = None) -> State:
        """Return the initial state with the given lean, steer and rates and the pitch at which both wheels stand."""
        return self.start or super().state(as_built=as_built)


@checks_arguments
def whipple(
    parameters: Parameters,
    speed: float = 0.0,
    lean: float = 0.0,
    steer: float = 0.0,
    lean_rate: float = 0.0,
    steer_rate: float = 0.0,
    *,
    tyres: Tyres | None = None,
    steer_damping: float = 0.0,
    head_stiffness: float | None = None,
    head_damping: float = 0.0,
) -> Bicycle:
    """Build the bicycle of Whipple and Carvallo: rear wheel, frame with rider, fork with handlebar, front wheel.

    Bodies "rear wheel", "frame", "fork", "front wheel"; joints "rear hub", "steer", "front hub", "rear contact",
    "front contact". The rear contact starts at the origin, heading along x. With ``tyres`` the forces "rear tyre" and
    "front tyre" stand in for the two contacts: nine degrees of freedom; the start is that of ideal wheels.

    Parameters
    ----------
    parameters : Parameters
        With round tyres where tR, tF are not zero.
    speed : float
        r_R times the rate of the rear hub [m/s], positive forward.
    lean, steer : float
        At the start, positive to the right [rad]; steer pi is the reversed front end.
    lean_rate, steer_rate : float
        [rad/s]
    tyres : mapping, pair of them or None
        What `mbsd3d.Tyre` takes besides geometry, for both wheels or (rear, front), e.g. `bicycle.TYPICAL`.
        Under its weight the bicycle stands on the radii r and crowns t of its parameters.
    steer_damping : float
        Of a damper about the steer axis [N m s/rad].
    head_stiffness, head_damping : float or None, float
        Of a head tube that yields [N m/rad, N m s/rad]: joint "head twist", at right angles to the steer axis, to a
        body "head" without mass, which bears the steer. None = rigid.

    Raises
    ------
    ValueError
        For anything but `Parameters`, or if there is no pose in which both wheels stand on the ground, or no velocities
        with which both roll.

    Examples
    --------
    >>> from bicycle import Meijaard2007, whipple
    >>> found = whipple(Meijaard2007(), speed=4.0, lean=0.1, steer=-0.2).check()
    >>> found.configuration_freedom, found.velocity_freedom
    (7, 3)
    """
    check_set(parameters, "whipple")
    place = pose_of(parameters, lean, steer)
    motion = velocities_of(parameters, place, speed, lean_rate, steer_rate)
    upright = lean == steer == 0.0  # then the reference pose is the start, and a model file holds all of it
    bodies = bodies_of(parameters, motion if upright else np.full((4, 6), None))
    q, v, angles = place.q, motion.ravel(), [0.0, float(steer), 0.0]
    joints, z = joints_of(parameters, bodies), np.zeros(0)
    forces: list[ForceElement] = []
    if tyres is not None:
        joints, forces, z = joints[:3], [*tyres_of(parameters, bodies, tyres)], np.zeros(4)
    if head_stiffness is not None:
        head, joints[1], twist, spring = head_of(parameters, bodies, head_stiffness, head_damping)
        bodies, joints, forces = [*bodies, head], [*joints, twist], [*forces, spring]
        (q, v), angles = head_state(place, q, motion), [*angles, 0.0]
    elif head_damping:
        raise InputError(f"whipple: head_damping = {head_damping:g} without head_stiffness; give it in N m/rad")
    if steer_damping:
        forces.append(JointFriction(joints[1], viscous=steer_damping, name="steer damper"))
    start = State(0.0, q, v, z=z, coordinates=np.array(angles))
    return Bicycle(bodies, joints, forces, gravity=(0.0, 0.0, -parameters.g), start=start)


def bodies_of(p: Parameters, motion: np.ndarray) -> list[Body]:
    """Return the four bodies, upright; ``motion`` (4, 6) holds their velocities, or None."""
    rear, front = hubs(p)
    centre: dict[str, ArrayLike] = {"R": rear, "B": (p.xB, 0.0, -p.zB), "H": (p.xH, 0.0, -p.zH), "F": front}
    bodies = []
    for (part, name), v in zip(NAMES.items(), motion, strict=True):
        hub = rear if part in "RB" else front
        kind = Body if not p.unphysical else PublishedBody
        moving = {} if v[0] is None else {"velocity": v[:3], "omega": v[3:]}
        mass, inertia, com = (
            getattr(p, f"m{part}"),
            PAPER_TO_MODEL @ p.inertia(part) @ PAPER_TO_MODEL,
            np.subtract(centre[part], hub),
        )
        bodies.append(kind(name, mass, inertia, com=com, position=hub, shape=shape_of(p, part), **moving))
    return bodies


def joints_of(p: Parameters, bodies: Sequence[Body]) -> list[Joint]:
    """Return three hinges and two rolling contacts."""
    wheel_r, frame, fork, wheel_f = bodies
    (rear, front), (at, axis) = hubs(p), steer_axis(p)
    axle = (0.0, 1.0, 0.0)  # to the left: a wheel that rolls forward turns in the positive sense
    return [
        Revolute(frame, wheel_r, at=rear, axis=axle, name="rear hub"),
        Revolute(frame, fork, at=at, axis=axis, name="steer"),
        Revolute(fork, wheel_f, at=front, axis=axle, name="front hub"),
        RollingDisc(GROUND, wheel_r, axis=axle, radius=p.rR, crown=p.tR, centre=rear, name="rear contact"),
        RollingDisc(GROUND, wheel_f, axis=axle, radius=p.rF, crown=p.tF, centre=front, name="front contact"),
    ]


def head_of(
    p: Parameters, bodies: Sequence[Body], stiffness: float, damping: float
) -> tuple[Body, Revolute, Revolute, TorsionSpring]:  # fmt: skip
    """Return (body "head" without mass, joint "steer" on it, joint "head twist" on the frame, spring "head spring").

    The axis of twist lies in the plane of the frame, goes through the head and points ahead: the frame gives about it
    as its tubes twist, and the front wheel moves sideways.
    """
    (at, axis), (_, frame, fork, _) = steer_axis(p), bodies
    ahead = np.cross((0.0, 1.0, 0.0), -axis)
    tube = shapes.Lines([tuple(-0.5 * HEAD_TUBE_LENGTH * axis), tuple(0.5 * HEAD_TUBE_LENGTH * axis)])
    head = Body("head", 0.0, (0, 0, 0), position=at, shape=tube)
    twist = Revolute(frame, head, at=at, axis=ahead, name="head twist")
    spring = TorsionSpring(twist, stiffness=stiffness, damping=damping, name="head spring")
    return head, Revolute(head, fork, at=at, axis=axis, name="steer"), twist, spring


def head_state(place: Pose, q: np.ndarray, motion: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (q, v) of the bicycle and of its head, which moves with the frame (row 1 of q and ``motion`` (4, 6))."""
    v, omega = motion[1, :3], motion[1, 3:]
    there = v + cross(omega, place.head - place.rear)
    return np.concatenate([q, place.head, q[10:14]]), np.concatenate([motion.ravel(), there, omega])


@part_class(repr=False)
class PublishedBody(Body):
    """Body whose inertia may break the triangle rule, as some published ones do."""

    def __post_init__(self) -> None:
        published = np.array(self.inertia, dtype=float)
        # a multiple of the unit matrix makes any inertia a possible one
        object.__setattr__(self, "inertia", published + np.trace(np.abs(published)) * np.eye(3) * bool(self.mass))
        super().__post_init__()
        published.setflags(write=False)
        object.__setattr__(self, "inertia", published)


def outputs(system: System) -> list[Measure]:
    """Return lean, steer and their rates: outputs for `linearize` that leave out position, heading and wheel angles."""
    frame, steer = system.part("frame"), system.part("steer", "joints")
    return [measures.lean(frame), measures.angle(steer), measures.lean_rate(frame), measures.rate(steer)]


def steer_torque(system: Bicycle, parameters: Parameters, torque: Signal | float) -> list[Torque]:
    """Return the torque of the rider's arms about the steer axis [N m]: on the fork, to the right > 0, and back on the
    frame.
    """
    signal = as_signal(torque, "ride: torque")
    axis = steer_axis(parameters)[1]  # the bodies' own axes are the world's at the upright reference pose
    return [
        Torque(system.part(body), tuple(sign * x * signal for x in axis), frame="body", name=f"steer torque on {body}")
        for body, sign in (("fork", 1.0), ("frame", -1.0))
    ]


RIDER_MASS_MIN = 40.0  # [kg] of the frame; on a lighter one nobody sits
HANDLEBAR = ((-0.16, 0.3, 0.0), (0.0, 0.28, 0.03), (0.0, -0.28, 0.03), (-0.16, -0.3, 0.0))  # [sizes] from the stem


@lru_cache(maxsize=64)
def spoked_wheel(radius: float, tube: float) -> tuple[shapes.Shape, ...]:
    """Return a tyre and spokes about the hub [m]; made once for all bicycles that share it."""
    angles = np.linspace(0.0, 2.0 * np.pi, 9)[:-1]
    rim = [(radius * np.cos(a), 0.0, radius * np.sin(a)) for a in angles]
    spokes = [point for end in rim for point in ((0.0, 0.0, 0.0), end)]
    return shapes.Torus(radius - tube, tube, "y"), shapes.Lines(spokes)


def shape_of(p: Parameters, part: str) -> Sequence[shapes.Shape]:
    """Return the shapes of a part, from its hub [m]: wheels with rims and spokes, tubes of frame and fork with its
    handlebar, and the rider on a frame that is heavy enough for one, else the frame's mass.
    """
    if part in "RF":
        r = getattr(p, f"r{part}")
        tube = max(getattr(p, f"t{part}") if getattr(p, f"t{part}") < 0.3 * r else 0.0, 0.04 * r)
        return spoked_wheel(float(r), float(tube))
    (rear, front), (head, axis) = hubs(p), steer_axis(p)
    size = float(max(p.w, 2.0 * max(p.rR, p.rF)))
    stem = head - 0.2 * size * axis
    if part == "H":
        bar = [stem + size * np.array(point) for point in HANDLEBAR]
        return [shapes.Lines(np.array([front, head, stem]) - front), shapes.Lines(np.array(bar) - front)]
    crank, seat = np.array([0.4 * p.w, 0.0, p.rR]), np.array([0.2 * p.w, 0.0, 2.0 * max(p.rR, p.rF) + 0.2 * size])
    tubes = shapes.Lines(np.array([rear, crank, head, seat, rear, seat, crank]) - rear)
    if p.mB < RIDER_MASS_MIN:
        return [tubes, shapes.Sphere(0.08 * p.w, at=np.array([p.xB, 0.0, -p.zB]) - rear)]
    return [tubes, *rider(seat - rear, stem - rear, crank - rear, size)]


def rider(seat: np.ndarray, stem: np.ndarray, crank: np.ndarray, size: float) -> list[shapes.Shape]:
    """Return head, trunk, arms and legs of a rider on a seat, with hands on the bar and feet on the pedals [m]."""
    hip = seat + size * np.array([0.0, 0.0, 0.06])
    shoulder = hip + size * np.array([0.22, 0.0, 0.44])
    limbs = [(hip, shoulder, 0.09)]
    for side, pedal in ((1.0, 0.16), (-1.0, -0.16)):  # the cranks stand level, one foot in front
        across = size * side * np.array([0.0, 1.0, 0.0])
        hand = stem + size * np.array(HANDLEBAR[0 if side > 0.0 else -1])
        elbow = 0.5 * (shoulder + hand) + 0.2 * across - size * np.array([0.02, 0.0, 0.08])
        foot = crank + 0.12 * across + size * np.array([pedal, 0.0, 0.03])
        knee = 0.5 * (hip + foot) + 0.09 * across + size * np.array([0.2, 0.0, 0.08])
        limbs += [(shoulder + 0.14 * across, elbow, 0.035), (elbow, hand, 0.03)]
        limbs += [(hip + 0.08 * across, knee, 0.055), (knee, foot, 0.04)]
    return [
        shapes.Sphere(0.1 * size, at=shoulder + size * np.array([0.07, 0.0, 0.2])),
        *(limb(*x, size) for x in limbs),
    ]


def limb(start: np.ndarray, end: np.ndarray, thickness: float, size: float) -> shapes.Capsule:
    """Return a capsule between two points [m]; ``thickness`` is its radius over the size of the bicycle."""
    way = end - start
    return shapes.Capsule(thickness * size, float(np.linalg.norm(way)), way, at=0.5 * (start + end))
