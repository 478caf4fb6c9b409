"""Force elements: power belongs to stored energy, actions equal reactions, and the formulas of their docstrings."""

from dataclasses import replace

import numpy as np
import pytest
from models import (
    Evaluation,
    across,
    concrete_subclasses,
    derivative,
    direction,
    middle,
    public_classes,
    random_body,
    random_orientation,
    signal,
)

from mbsd3d import (
    GROUND,
    AeroDrag,
    Body,
    Brake,
    Bushing,
    CentralGravity,
    ConeStop,
    Contact,
    Cylindrical,
    EndStop,
    Force,
    ForceBetween,
    ForceCurve,
    JointFriction,
    LinearActuator,
    Polynomial,
    Prismatic,
    Revolute,
    Sine,
    Spherical,
    SpringDamper,
    System,
    Torque,
    TorqueBetween,
    TorqueCurve,
    TorsionSpring,
    Tyre,
    Weight,
    rotation,
    shapes,
)
from mbsd3d.base.rotations import exponential, matrix, multiply
from mbsd3d.dynamics.applied_forces import loads
from mbsd3d.equations.compiled import compile_system
from mbsd3d.kernels.coordinates import coordinate, coordinate_rate
from mbsd3d.kernels.kinematics import kinematics
from mbsd3d.mechanism import measures
from mbsd3d.mechanism.force_element import ForceElement
from mbsd3d.mechanism.forces.custom import CustomForce, SavedForce
from mbsd3d.mechanism.forces.feedback import StateFeedback

TOLERANCE = 1e-8
"""The limit set; the difference formula is good to 1e-12 times derivatives that reach 1e3 for bushing and tanh."""

T = 0.37


def _hinge(rng, a, b):
    return Revolute(a, b, at=middle(rng, a, b), axis=direction(rng))


def _slider(rng, a, b):
    return Prismatic(a, b, at=middle(rng, a, b), axis=direction(rng))


def _signals(rng):
    return (signal(rng, 0.5), Polynomial((0.3, -0.8, 1.1)), -0.7)


def _spring(rng, a, b):
    ends = dict(at_a=a.position + 0.3 * direction(rng), at_b=b.position + 0.3 * direction(rng))
    return SpringDamper(a, b, **ends, stiffness=7.0, damping=0.9, length=0.8)


def _bushing(rng, a, b):
    numbers = dict(
        stiffness=(5.0, 7.0, 3.0), turning_stiffness=(2.0, 1.3, 4.0), damping=(0.4, 0.7, 0.2),
        turning_damping=(0.3, 0.6, 0.5),
    )  # fmt: skip
    return Bushing(a, b, at=middle(rng, a, b), axes=random_orientation(rng), **numbers)


def _seen(joint):
    seen = [measures.angle(joint), measures.rate(joint)]
    return [joint], StateFeedback(measures=seen, gains=(2.0, 0.7), on=joint, reference=(0.4, -0.3))


def _rubber_band(t, bodies, z, parameters, loads, z_dot):
    """Progressive spring and damper along the line between two points, stiffening with time."""
    gap, speed = bodies[1].r - bodies[0].r, bodies[1].velocity - bodies[0].velocity
    length = np.sqrt(np.sum(gap * gap))
    pull = parameters[0] * (1.0 + t) * length**2 + parameters[1] * np.sum(gap * speed) / length
    loads[0, :3] = pull / length * gap
    loads[1, :3] = -loads[0, :3]
    loads[0, 3:] = parameters[2] * (bodies[1].w - bodies[0].w)
    loads[1, 3:] = -loads[0, 3:]


def _custom(rng, a, b):
    points = (middle(rng, a, b), b.position + 0.3 * direction(rng))
    return CustomForce(_rubber_band, on=(a, b), points=points, parameters=(3.0, 0.8, 0.4))


def _contact(rng, a, b, surface, **numbers):
    """Pressed into a plane of a, with states that the numbers below set: no pose leaves it."""
    normal = direction(rng)
    plane = (b.position + 3.0 * normal + direction(rng), normal)
    return [], Contact(a, b, surface, plane=plane, stiffness=0.8, **numbers)


STONE = dict(at=(0.1, -0.2, 0.15), orientation=rotation((1, 2, -1), 0.8))
LINING = dict(stiffness=1.7, damping=6.0)
STICKS = dict(
    exponent=1.5, damping=0.02, loss=0.01, friction=3.0, rolling=2.0, spinning=1.5, grip=1.2, grip_damping=0.3
)
SLIPS = dict(damping=0.02, friction=0.05, rolling=0.02, spinning=0.01, grip=1.2, grip_damping=0.3)
CREEPS = dict(loss=0.02, friction=0.4, rolling=0.3, spinning=0.2, creep=0.5)


def _on(joint, cls, **numbers):
    return [joint], cls(joint, **numbers)


def _tyre(rng, a, b, **given):
    """So large a tube that the general poses press it."""
    numbers = dict(radius=3.0, crown=2.4, stiffness=4.0, damping=0.1, trail=0.3, twisting=0.2, rolling_resistance=0.1)
    more = dict(cornering=1.3, longitudinal=1.7, camber=0.8, mu=0.7, standing_damping=0.4, standing_speed=2.0)
    more |= dict(relaxation=0.5, relaxation_x=0.3, nominal_load=6.0, grip_sensitivity=0.1, stiffness_sensitivity=0.2)
    more |= given
    plane = (b.position - np.array([0.3, 0.2, 1.1]), np.array([0.2, -0.1, 1.0]))
    return Tyre(a, b, axis=(0.3, 1.0, -0.2), plane=plane, centre=b.position + 0.2 * direction(rng), **numbers, **more)


STOP = dict(stiffness=3.0, damping=0.4)
BENT = [(-9.0, 4.0), (-1.0, 2.5), (0.3, 0.7), (1.5, -0.9), (4.0, -1.7), (9.0, -6.0)]


def _cone(rng, a, b, **limits):
    """A narrow cone that general poses leave, about axes that stand apart as built."""
    ball, axis = Spherical(a, b, at=middle(rng, a, b)), direction(rng)
    return [ball], ConeStop(ball, axis_a=axis, axis_b=axis + 0.2 * direction(rng), **limits, **STOP)


def _table(rng, a, b, **choice):
    ends = dict(at_a=a.position + 0.3 * direction(rng), at_b=b.position + 0.3 * direction(rng))
    return [], ForceCurve(a, b, **ends, points=BENT, length=0.8, **choice)


def _actuator(rng, a, b, thrust, stroke):
    ends = dict(at_a=a.position + 0.3 * direction(rng), at_b=b.position + 0.3 * direction(rng))
    return [], LinearActuator(a, b, **ends, thrust=thrust, rate=9.0, stroke=stroke, **STOP)


EXAMPLES = {
    "Force in world axes": lambda rng, a, b: ([], Force(b, _signals(rng), at=b.position + direction(rng))),
    "Force in body axes": lambda rng, a, b: ([], Force(b, _signals(rng), at=b.position + direction(rng), frame="body")),
    "Torque in world axes": lambda rng, a, b: ([], Torque(b, _signals(rng))),
    "Torque in body axes": lambda rng, a, b: ([], Torque(b, _signals(rng), frame="body")),
    "SpringDamper": lambda rng, a, b: ([], _spring(rng, a, b)),
    "SpringDamper without length": lambda rng, a, b: ([], replace(_spring(rng, a, b), length=0.0)),
    "TorsionSpring on a hinge": lambda rng, a, b: _on(
        _hinge(rng, a, b), TorsionSpring, stiffness=3.0, damping=0.7, angle=0.4
    ),
    "TorsionSpring on a slider": lambda rng, a, b: _on(
        _slider(rng, a, b), TorsionSpring, stiffness=3.0, damping=0.7, angle=0.4
    ),
    "JointFriction in a hinge": lambda rng, a, b: _on(
        _hinge(rng, a, b), JointFriction, coulomb=0.8, viscous=0.3, transition=0.5
    ),
    "JointFriction in a slider": lambda rng, a, b: _on(
        _slider(rng, a, b), JointFriction, coulomb=0.8, viscous=0.3, transition=0.5
    ),
    "Brake that holds": lambda rng, a, b: _on(_hinge(rng, a, b), Brake, torque=90.0 + signal(rng, 1.0), **LINING),
    "Brake that slips": lambda rng, a, b: _on(_slider(rng, a, b), Brake, torque=Polynomial((0.3, 0.1)), **LINING),
    "EndStop of a hinge": lambda rng, a, b: _on(_hinge(rng, a, b), EndStop, upper=-4.0, **STOP),
    "EndStop of a slide": lambda rng, a, b: _on(_slider(rng, a, b), EndStop, lower=7.0, upper=8.0, **STOP),
    "ConeStop of the swing": lambda rng, a, b: _cone(rng, a, b, half_angle=0.05),
    "ConeStop of the twist": lambda rng, a, b: _cone(rng, a, b, half_angle=3.1, twist=(0.1, 0.11)),
    "ConeStop of both": lambda rng, a, b: _cone(rng, a, b, half_angle=0.1, twist=(-0.03, 0.02)),
    "ForceCurve over the stretch": lambda rng, a, b: _table(rng, a, b),
    "ForceCurve over the rate": lambda rng, a, b: _table(rng, a, b, over="rate", between="monotone", beyond="line"),
    "TorqueCurve over the angle": lambda rng, a, b: _on(
        _hinge(rng, a, b), TorqueCurve, points=BENT, over="angle", between="monotone", beyond="hold"
    ),
    "TorqueCurve over the slide": lambda rng, a, b: _on(
        _slider(rng, a, b), TorqueCurve, points=[(x, 3.0 - y) for x, y in BENT], over="slide", beyond="line"
    ),
    "TorqueCurve over the rate": lambda rng, a, b: _on(_hinge(rng, a, b), TorqueCurve, points=BENT),
    "ForceBetween in axes of a": lambda rng, a, b: (
        [],
        ForceBetween(a, b, _signals(rng), at=b.position + direction(rng), frame="a"),
    ),
    "ForceBetween in world axes": lambda rng, a, b: ([], ForceBetween(a, b, _signals(rng))),
    "TorqueBetween in axes of b": lambda rng, a, b: ([], TorqueBetween(a, b, _signals(rng), frame="b")),
    "TorqueBetween in world axes": lambda rng, a, b: ([], TorqueBetween(a, b, _signals(rng))),
    "LinearActuator that pulls at its end": lambda rng, a, b: _actuator(rng, a, b, -2.0 + signal(rng, 0.1), (0.1, 0.2)),
    "LinearActuator that pushes at its end": lambda rng, a, b: _actuator(rng, a, b, 2.0, (20.0, 30.0)),
    "StateFeedback": lambda rng, a, b: _seen(_hinge(rng, a, b)),
    "CustomForce": lambda rng, a, b: ([], _custom(rng, a, b)),
    "Tyre": lambda rng, a, b: ([], _tyre(rng, a, b)),
    "Tyre with instant camber": lambda rng, a, b: ([], _tyre(rng, a, b, camber_lag=False)),
    "Bushing": lambda rng, a, b: ([], _bushing(rng, a, b)),
    "Contact that sticks": lambda rng, a, b: _contact(rng, a, b, shapes.Ellipsoid((0.7, 0.5, 0.3), **STONE), **STICKS),
    "Contact that slips": lambda rng, a, b: _contact(rng, a, b, shapes.Torus(0.4, 0.3, (3, -1, 2), **STONE), **SLIPS),
    "Contact that creeps": lambda rng, a, b: _contact(rng, a, b, shapes.Sphere(0.6, at=(0.1, -0.2, 0.1)), **CREEPS),
    "Weight": lambda rng, a, b: ([], Weight(a, b, acceleration=rng.normal(size=3))),
    "CentralGravity": lambda rng, a, b: ([], CentralGravity(a, b, at=a.position + direction(rng), mu=2.3)),
    "AeroDrag": lambda rng, a, b: ([], AeroDrag(b, drag_area=0.6, at=b.position + direction(rng), wind=_signals(rng))),
}
"""Name -> factory(rng, a, b) of (joints it needs, element)."""


every_element = pytest.mark.parametrize("name", EXAMPLES)
on_both = pytest.mark.parametrize("ground", [None, "a"])


class Loads(Evaluation):
    """Applied forces of a system at arbitrary states."""

    def at(self, q, v, t=T, z=0.0):
        """(Q (n + 1, 6) with the ground last, stored energy, power of the part that stores none)."""
        self.data.body["Q"] = 0.0
        y = self.state(q, v)
        y[13 * self.n : 13 * self.n + self.model.z_work] += z
        kinematics(self.model, self.data, y)
        loads(self.model, self.data, t)
        force = self.data.force
        return self.data.body["Q"].copy(), force["potential"].sum(), force["power"].sum()


def element(name, seed, ground=None):
    """(Loads, element) of two general bodies with one force element and no gravity."""
    rng = np.random.default_rng(seed)
    bodies = [random_body(rng, "one"), random_body(rng, "two")]
    joints, force = EXAMPLES[name](rng, GROUND if ground == "a" else bodies[0], bodies[1])
    return Loads(System(bodies=bodies, joints=joints, forces=[force], gravity=(0, 0, 0))), force


def test_every_force_element_has_an_example():
    rng = np.random.default_rng(0)
    bodies = [random_body(rng, "one"), random_body(rng, "two")]
    covered = {type(make(rng, *bodies)[1]) for make in EXAMPLES.values()}
    assert covered == concrete_subclasses(ForceElement) - {SavedForce}  # which has lost its function
    assert covered == public_classes(ForceElement)


def test_a_force_without_a_law_is_refused():
    class Wind(Force):
        law = None

    body = random_body(np.random.default_rng(0))
    with pytest.raises(
        ValueError, match=r"force 'gust' \(Wind\): its class has no compiled law; give it a kernel `law`"
    ):
        compile_system(System([body], forces=[Wind(body, (1.0, 0.0, 0.0), name="gust")]))


@every_element
@on_both
def test_power_is_minus_the_rate_of_energy_plus_the_reported_power(name, ground):
    on, _ = element(name, 3, ground)
    q, v = on.general(np.random.default_rng(4))
    q_dot = on.rates(v, q)
    z = 0.3 * np.random.default_rng(5).normal(size=on.model.z_work)
    Q, _, power = on.at(q, v, z=z)
    z_dot = on.data.state_rate.copy()
    stored = derivative(lambda h: on.at(q + h * q_dot, v, z=z + h * z_dot)[1])
    assert Q[:-1].ravel() @ v == pytest.approx(power - stored, abs=TOLERANCE)
    reported = [abs(x) for x in (stored, power) if x != 0.0]
    assert reported and min(reported) > 1e4 * TOLERANCE  # one per cent of either would be seen


@every_element
@on_both
def test_action_equals_reaction_unless_something_acts_from_outside(name, ground):
    on, _ = element(name, 5, ground)
    two = element(name, 5)[1]
    outside = GROUND in two.bodies() or isinstance(two, Weight)  # that of a moving frame
    q, v = on.general(np.random.default_rng(6))
    Q, *_ = on.at(q, v)
    r = np.vstack([q.reshape(-1, 7)[:, :3], np.zeros(3)])
    moments = Q[:, 3:] + np.cross(r, Q[:, :3])
    force, moment = np.abs(Q[:, :3].sum(axis=0)).max(), np.abs(moments.sum(axis=0)).max()
    assert np.abs(Q).max() > 0.1
    if outside:
        assert force + moment > 0.1
    else:
        assert force < 1e-14 and moment < 1e-13  # rounding of forces of order one, and of arms of a few metres


@every_element
def test_complex_step_equals_central_differences(name):
    real, _ = element(name, 7)
    exact = Loads(real.compiled.system, complex)
    rng = np.random.default_rng(8)
    q, v = real.general(rng)
    q_dot, v_dot = real.rates(v, q), rng.normal(size=v.size)

    def functions(on, h):
        Q, energy, power = on.at(q + h * q_dot, v + h * v_dot)
        return np.concatenate([Q.ravel(), [energy, power]])

    step = functions(exact, 1e-30j).imag / 1e-30
    assert np.abs(step - derivative(lambda h: functions(real, h))).max() < TOLERANCE


def test_weight_acts_at_the_centre_of_mass():
    rng = np.random.default_rng(9)
    body, g = random_body(rng), np.array([0.4, -1.3, -9.2])
    on = Loads(System(bodies=[body], gravity=g))
    q, v = on.general(rng)
    s = matrix(q[3:]) @ body.com
    Q = on.at(q, v)[0][0]
    weight = body.mass * g
    assert Q == pytest.approx(np.concatenate([weight, np.cross(s, weight)]), abs=1e-14 * np.linalg.norm(weight))


def test_quadratic_velocity_term_is_gyroscopic_plus_centripetal():
    rng = np.random.default_rng(10)
    body = random_body(rng)
    on = Loads(System(bodies=[body]))
    q, v = on.general(rng)
    on.at(q, v)
    R, w = matrix(q[3:]), v[3:]
    s, inertia = R @ body.com, R @ body.inertia @ R.T
    pull = body.mass * np.cross(w, np.cross(w, s))
    h = np.concatenate([pull, np.cross(w, inertia @ w) + np.cross(s, pull)])
    assert on.data.body["h"][0] == pytest.approx(h, abs=1e-13)  # rounding of numbers of order one


def points(on, name_of_point_a, name_of_point_b, element_, q, v):
    """World positions and velocities of two points of the element in a general pose."""
    found = []
    for body, point in ((element_.a, name_of_point_a), (element_.b, name_of_point_b)):
        k = on.compiled.body_index[id(body)]
        r, R = q.reshape(-1, 7)[k, :3], matrix(q.reshape(-1, 7)[k, 3:])
        arm = R @ body.local_point(point)
        velocity, w = v.reshape(-1, 6)[k, :3], v.reshape(-1, 6)[k, 3:]
        found.append((r + arm, velocity + np.cross(w, arm)))
    return found


def test_spring_and_damper_pull_along_the_line():
    on, spring = element("SpringDamper", 11)
    q, v = on.general(np.random.default_rng(12))
    (p_a, v_a), (p_b, v_b) = points(on, spring.at_a, spring.at_b, spring, q, v)
    length = np.linalg.norm(p_b - p_a)
    n = (p_b - p_a) / length
    speed = n @ (v_b - v_a)
    Q, energy, power = on.at(q, v)
    assert Q[1, :3] == pytest.approx(-(7.0 * (length - 0.8) + 0.9 * speed) * n, abs=1e-13)
    assert energy == pytest.approx(3.5 * (length - 0.8) ** 2, abs=1e-13)
    assert power == pytest.approx(-0.9 * speed**2, abs=1e-13)


def test_spring_length_defaults_to_the_reference_pose():
    rng = np.random.default_rng(13)
    body = random_body(rng)
    spring = SpringDamper(GROUND, body, at_a=direction(rng), at_b=body.position, stiffness=4.0)
    assert spring.length == pytest.approx(np.linalg.norm(body.position - spring.at_a), rel=1e-15)


@pytest.mark.parametrize("frame", ["world", "body"])
def test_force_and_torque_have_the_given_components(frame):
    rng = np.random.default_rng(14)
    body = random_body(rng)
    f, m, at = (Sine(0.8, 0.4, 0.3), 1.2, -0.4), (0.2, Sine(0.5, 0.7, 0.9), 0.6), body.position + direction(rng)
    on = Loads(System(bodies=[body], forces=[Force(body, f, at, frame), Torque(body, m, frame)], gravity=(0, 0, 0)))
    q, v = on.general(rng)
    R = matrix(q[3:])
    turn = R if frame == "body" else np.eye(3)
    force = turn @ [0.8 * np.sin(0.8 * np.pi * T + 0.3), 1.2, -0.4]
    moment = turn @ [0.2, 0.5 * np.sin(1.4 * np.pi * T + 0.9), 0.6]
    s = R @ body.local_point(at)
    Q = on.at(q, v)[0][0]
    assert Q == pytest.approx(np.concatenate([force, np.cross(s, force) + moment]), abs=1e-14)


def test_force_acts_at_the_centre_of_mass_if_no_point_is_given():
    rng = np.random.default_rng(15)
    body = random_body(rng)
    on = Loads(System(bodies=[body], forces=[Force(body, (1.0, -2.0, 0.5))], gravity=(0, 0, 0)))
    q, v = on.general(rng)
    s = matrix(q[3:]) @ body.com
    assert on.at(q, v)[0][0, 3:] == pytest.approx(np.cross(s, (1.0, -2.0, 0.5)), abs=1e-14)


def test_drag_opposes_the_velocity_relative_to_the_wind():
    rng = np.random.default_rng(16)
    body, wind = random_body(rng), np.array([3.0, -1.0, 0.7])
    at = body.position + direction(rng)
    drag = AeroDrag(body, drag_area=0.6, density=1.1, at=at, wind=wind)
    on = Loads(System(bodies=[body], forces=[drag], gravity=(0, 0, 0)))
    q, v = on.general(rng)
    s = matrix(q[3:]) @ body.local_point(at)
    u = v[:3] + np.cross(v[3:], s) - wind
    Q, _, power = on.at(q, v)
    force = -0.5 * 1.1 * 0.6 * np.linalg.norm(u) * u
    assert Q[0] == pytest.approx(np.concatenate([force, np.cross(s, force)]), abs=1e-13)
    assert power == pytest.approx(force @ (u + wind), abs=1e-13)


def turned_about_hinge(cls, turn, advance, rng):
    """(system, hinge, q, axis): body b turned by ``turn`` about and moved by ``advance`` along its hinge."""
    a, b = random_body(rng, "one"), random_body(rng, "two")
    hinge = cls(a, b, at=middle(rng, a, b), axis=direction(rng))
    q, e = np.concatenate([a.position, a.orientation, b.position, b.orientation]), exponential(turn * hinge.axis)
    q[7:10] = hinge.at + matrix(e) @ (b.position - hinge.at) + advance * hinge.axis
    q[10:] = multiply(e, b.orientation)
    return (a, b), hinge, q


@pytest.mark.parametrize("turn", [0.7, -2.9])
def test_torsion_spring_and_friction_turn_about_the_hinge(turn):
    rng = np.random.default_rng(17)
    bodies, hinge, q = turned_about_hinge(Revolute, turn, 0.0, rng)
    elements = [
        TorsionSpring(hinge, stiffness=3.0, damping=0.7, angle=0.4),
        JointFriction(hinge, coulomb=0.8, viscous=0.3, transition=0.5),
    ]
    on = Loads(System(bodies=bodies, joints=[hinge], forces=elements, gravity=(0, 0, 0)))
    v = rng.normal(size=12)
    rate = hinge.axis @ (v[9:] - v[3:6])
    load = -3.0 * (turn - 0.4) - 0.7 * rate - 0.8 * np.tanh(rate / 0.5) - 0.3 * rate
    Q, energy, power = on.at(q, v)
    assert Q[1] == pytest.approx(np.concatenate([np.zeros(3), load * hinge.axis]), abs=1e-13)
    assert Q[0] == pytest.approx(-Q[1], abs=1e-13)
    assert energy == pytest.approx(1.5 * (turn - 0.4) ** 2, abs=1e-13)
    assert power == pytest.approx((load + 3.0 * (turn - 0.4)) * rate, abs=1e-13)


def test_torsion_spring_on_a_slider_pushes_along_it():
    rng = np.random.default_rng(18)
    bodies, slider, q = turned_about_hinge(Prismatic, 0.0, 0.6, rng)
    on = Loads(
        System(
            bodies=bodies,
            joints=[slider],
            forces=[TorsionSpring(slider, stiffness=3.0, angle=0.1)],
            gravity=(0, 0, 0),
        )
    )
    Q, energy, _ = on.at(q, np.zeros(12))
    assert Q[1, :3] == pytest.approx(-3.0 * 0.5 * slider.axis, abs=1e-13)
    assert energy == pytest.approx(1.5 * 0.5**2, abs=1e-13)


def test_torsion_spring_counts_turns():
    rng = np.random.default_rng(19)
    bodies, hinge, q = turned_about_hinge(Cylindrical, 5.5 - 2 * np.pi, 0.2, rng)  # the pose does not show the turn
    on = Loads(System(bodies=bodies, joints=[hinge], forces=[TorsionSpring(hinge, stiffness=2.0)], gravity=(0, 0, 0)))
    i = on.compiled.coordinate(hinge.angle())
    on.data.coordinate["value"][i] = 5.0  # the last accepted state
    Q, energy, _ = on.at(q, np.zeros(12))
    assert coordinate(on.model, on.data, i, T)[0] == pytest.approx(5.5, abs=1e-13)
    assert Q[1, 3:] == pytest.approx(-2.0 * 5.5 * hinge.axis, abs=1e-12)
    assert energy == pytest.approx(5.5**2, abs=1e-12)


def test_hinge_rate_is_the_rate_of_the_angle():
    rng = np.random.default_rng(20)
    bodies, hinge, q = turned_about_hinge(Cylindrical, 1.1, 0.2, rng)
    on = Loads(System(bodies=bodies, joints=[hinge]))
    q, v = on.general(rng)
    i, q_dot = on.compiled.coordinate(hinge.angle()), on.rates(v, q)

    def angle(h):
        kinematics(on.model, on.data, on.state(q + h * q_dot, v))
        return coordinate(on.model, on.data, i, T)[0]

    rate = derivative(angle)
    angle(0.0)
    assert coordinate_rate(on.model, on.data, i, T) == pytest.approx(rate, abs=TOLERANCE)


def test_bushing_is_linear_for_small_displacements():
    rng = np.random.default_rng(21)
    body, axes = random_body(rng), random_orientation(rng)
    K, K_turn = np.array([5.0, 7.0, 3.0]), np.array([2.0, 1.3, 4.0])
    at = body.position + 0.4 * direction(rng)
    bushing = Bushing(GROUND, body, at=at, stiffness=K, turning_stiffness=K_turn, axes=axes)
    on = Loads(System(bodies=[body], forces=[bushing], gravity=(0, 0, 0)))
    shift, turn = 1e-5 * direction(rng), 1e-5 * across(rng, direction(rng))
    e = exponential(turn)
    q = np.concatenate([at + shift + matrix(e) @ (body.position - at), multiply(e, body.orientation)])
    Q, energy, _ = on.at(q, np.zeros(6))
    F = matrix(axes)
    force = -F @ (K * (F.T @ shift))
    moment = -F @ (K_turn * (F.T @ turn)) + np.cross(at + shift - q[:3], force)
    # second-order terms of displacements of 1e-5
    assert Q[0] == pytest.approx(np.concatenate([force, moment]), abs=1e-9)
    assert energy == pytest.approx(0.5 * (shift @ -force + turn @ (F @ (K_turn * (F.T @ turn)))), rel=1e-4, abs=0)


def test_bushing_moment_of_a_large_turn_about_one_axis():
    rng = np.random.default_rng(22)
    body, angle = random_body(rng), 2.2
    at = body.position + 0.4 * direction(rng)
    bushing = Bushing(GROUND, body, at=at, stiffness=9.0, turning_stiffness=(2.0, 1.3, 4.0))
    on = Loads(System(bodies=[body], forces=[bushing], gravity=(0, 0, 0)))
    e = rotation("y", angle)
    q = np.concatenate([at + matrix(e) @ (body.position - at), multiply(e, body.orientation)])
    Q, energy, _ = on.at(q, np.zeros(6))
    # U = 2 k sin^2(angle/2), M = -dU/dangle = -k sin(angle)
    assert Q[0] == pytest.approx([0, 0, 0, 0, -1.3 * np.sin(angle), 0], abs=1e-13)
    assert energy == pytest.approx(2.6 * np.sin(angle / 2) ** 2, abs=1e-13)


@pytest.mark.parametrize("place", [(0.0, 0.0, 0.0), (300.0, -200.0, 700.0)])
def test_a_torque_acts_at_no_point_and_gives_the_model_no_length(place):
    """The length of a free body is its largest radius of gyration, wherever it starts and whatever turns it."""
    body = Body("rotor", mass=2.0, inertia=(0.3, 0.5, 0.72), com=(0.2, -0.1, 0.3), position=place)
    system = System([body], forces=[Torque(body, (0.1, 0.2, 0.3))])
    rounding = 1e-15
    assert abs(system.lowered.model.length - np.sqrt(0.72 / 2.0)) < rounding
