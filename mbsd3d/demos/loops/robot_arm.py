"""Inverse dynamics of a six-axis arm: the torque of every motor for a given motion."""

import numpy as np

from mbsd3d import GROUND, AngleDriver, Body, Kinematic, Polynomial, Revolute, System, accelerations, shapes, simulate

from ...mechanism.bodies import Ground
from ..form import Ablation, Beat, Control, Curve, Demo, Measured, Quantity, Symbol
from ..moments import share

G = 9.81  # m/s^2
RIGHT_ANGLE = np.pi / 2


def mechanism(
    *,
    a=(0.0, 0.4, 0.05, 0.0, 0.0, 0.0),
    d=(0.6, 0.0, 0.1, 0.4, 0.0, 0.1),
    alpha=(RIGHT_ANGLE, 0.0, RIGHT_ANGLE, -RIGHT_ANGLE, RIGHT_ANGLE, 0.0),
    q=(0.3, 0.7, -0.4, 0.5, 0.8, -0.6),
    qd=(1.0, -0.8, 1.2, 2.0, -1.5, 3.0),
    qdd=(2.0, 1.0, -3.0, 4.0, 5.0, -6.0),
    mass=(10.0, 8.0, 6.0, 3.0, 2.0, 1.0),
    com=((0, -0.2, 0.05), (-0.2, 0, 0.03), (0.01, 0.02, 0.05), (0, -0.1, 0.01), (0.005, 0, 0.03), (0, 0, -0.04)),
    I=((0.2, 0.1, 0.2), (0.05, 0.3, 0.3), (0.04, 0.05, 0.03),
       (0.02, 0.01, 0.02), (0.004, 0.004, 0.003), (0.001, 0.001, 0.0008)),
    pace=1.0,
) -> System:  # fmt: skip
    """Build links by Denavit-Hartenberg numbers; com [m] and I [kg m^2] in the frame at each link's end; q, qd, qdd of
    the joints, these run ``pace`` times as fast.
    """
    frame, bodies, joints = np.eye(4), [], []
    before: Body | Ground = GROUND
    for k in range(6):
        end = frame @ step(a[k], d[k], alpha[k], q[k])
        here, R = end[:3, 3], end[:3, :3]
        form = bar(R.T @ (frame[:3, 3] - here), R.T @ frame[:3, 2])
        link = Body(f"link {k + 1}", mass[k], I[k], com=com[k], position=here, orientation=R, shape=form)
        joint = Revolute(before, link, at=frame[:3, 3], axis=frame[:3, 2], name=f"joint {k + 1}")
        motion = Polynomial((0, pace * qd[k], pace**2 * qdd[k] / 2))
        joints += [joint, AngleDriver(joint, motion, name=f"motor {k + 1}")]
        bodies.append(link)
        frame, before = end, link
    return System(bodies, joints, gravity=(0, 0, -G))


def step(a, d, alpha, theta):
    """Return Rz(theta) Tz(d) Tx(a) Rx(alpha) as (4, 4)."""
    c, s, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
    return np.array([[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d], [0, 0, 0, 1]])


def bar(start, axis):
    """Draw a link from a point to its origin, with a motor at the point."""
    motor = shapes.Cylinder(0.06, 0.14, tuple(axis), at=start, colour="dimgray")
    long = np.linalg.norm(start)
    return [motor, shapes.Capsule(0.04, long, tuple(start), at=0.5 * start)] if long > 0.02 else [motor]


def torques(a, d, alpha, q, qd, qdd, mass, com, I):
    """Compute torques by recursive Newton-Euler in the frames of the links: motion outwards, forces and moments inwards
    [N m], shape (6,).
    """
    z, w, dw, accel = np.array([0, 0, 1.0]), np.zeros(3), np.zeros(3), np.array([0, 0, G])
    links = []
    for k in range(6):
        T = step(a[k], d[k], alpha[k], q[k])
        R = T[:3, :3].T  # into the frame of this link
        dw = R @ (dw + qdd[k] * z + np.cross(w, qd[k] * z))
        w = R @ (w + qd[k] * z)
        p = R @ T[:3, 3]
        accel = R @ accel + np.cross(dw, p) + np.cross(w, np.cross(w, p))
        s, inertia = np.asarray(com[k]), np.asarray(I[k])
        force = mass[k] * (accel + np.cross(dw, s) + np.cross(w, np.cross(w, s)))
        links.append((R, p, s, force, inertia * dw + np.cross(w, inertia * w)))
    f, n, R_next, found = np.zeros(3), np.zeros(3), np.eye(3), []
    for R, p, s, force, moment in reversed(links):
        f, n = R_next.T @ f, R_next.T @ n
        n = n + np.cross(p, f) + np.cross(p + s, force) + moment
        f = f + force
        found.append(float(n @ (R @ z)))
        R_next = R
    return np.array(found[::-1])


def theory(*, a, d, alpha, q, qd, qdd, mass, com, I, pace):
    """Return the torques of all motors [N m]."""
    found = torques(a, d, alpha, q, pace * np.array(qd), pace**2 * np.array(qdd), mass, com, I)
    return {f"torque{k + 1}_Nm": found[k] for k in range(6)}


def measure(build, terms, *, a, d, alpha, q, qd, qdd, mass, com, I, pace) -> Measured:
    """Measure the torques of the drivers at the given state, and along a motion of half a second."""
    system = build()
    now = accelerations(system, **terms)
    run = simulate(system, 0.5, method=Kinematic(), output=101, **terms)
    q, qd, qdd = np.array([q, pace * np.array(qd), pace**2 * np.array(qdd)])
    along = (torques(a, d, alpha, q + qd * t + qdd * t**2 / 2, qd + qdd * t, qdd, mass, com, I) for t in run.t)
    known = np.array(list(along)).T
    curves = [
        Curve(f"torque of motor {k + 1} [N m]", run.t, run.effort(f"motor {k + 1}"), (run.t, known[k]))
        for k in range(3)
    ]
    return Measured({f"torque{k + 1}_Nm": now.effort(f"motor {k + 1}")[0] for k in range(6)}, [run], curves)


demo = Demo(
    __name__,
    title="The torques of a robot arm",
    question="What torque does every motor of a six-axis arm need?",
    beats=(
        Beat(0.0, "Motor 2 holds 63 N m: the weight of all that is outside it."),
        Beat(share(1.0), "In full motion motor 3 needs less than half of what it held."),
    ),
    why="Every motor carries all links beyond it: their weights, their accelerations, and the gyroscopic moments of "
    "links that turn about several axes at once. The recursion of Newton and Euler goes outwards for the motion "
    "and back inwards for the forces. Here it is done twice, by that recursion and by constraints of bodies with "
    "seven coordinates each; neither shares anything with the other.",
    equation="outwards: w, w', a; inwards: f = m a, n = I w' + w x I w; torque = n . z",
    symbols={
        "w": Symbol("turning of a link", "rad/s"),
        "a": Symbol("acceleration of its centre of mass", "m/s^2"),
        "m": Symbol("its mass", "kg"),
        "I": Symbol("its moments", "kg m^2"),
        "f": Symbol("force at its joint", "N"),
        "n": Symbol("moment at its joint; about the axis that of motor 2", "N m", curve=(1, 0)),
        "z": Symbol("axis of the joint"),
    },
    source="Luh, Walker, Paul (1980); Featherstone, Rigid Body Dynamics Algorithms",
    quantities={f"torque{k}_Nm": Quantity(f"torque of motor {k}", "N m") for k in range(1, 7)},
    ablation=Ablation("motion", "at rest only weights are left", {"qd": [0.0] * 6, "qdd": [0.0] * 6}),
    show={"curves": [("effort", f"motor {k}") for k in range(1, 7)], "traces": [], "speed": 0.1},
    ranges={"alpha": None, "com": None, "I": None},  # moments one by one at random are those of no body,
    sliders=(Control("pace", 0.1, 2.0, "", "pace of the motion"),),
    attempt="move it ten times slower: what is left are the weights. Twice as fast, and inertia rules.",
)
