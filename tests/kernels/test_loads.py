"""Force elements: power belongs to stored energy, actions equal reactions, and the formulas of their docstrings."""

import numpy as np
import pytest
from helpers.forces import EXAMPLES, LOCKS
from helpers.models import (
    Evaluation,
    across,
    concrete_subclasses,
    derivative,
    direction,
    middle,
    public_classes,
    random_body,
    random_orientation,
)

from mbsd3d import (
    GROUND,
    AeroDrag,
    Body,
    Bushing,
    Cylindrical,
    FluidDrag,
    Force,
    JointFriction,
    Prismatic,
    Revolute,
    Rope,
    Sine,
    SpringDamper,
    System,
    Torque,
    TorsionSpring,
    Weight,
    Winch,
    rotation,
)
from mbsd3d.dynamics.applied_forces import loads
from mbsd3d.extend import ForceElement, compile_system
from mbsd3d.kernels.coordinates import coordinate, coordinate_rate
from mbsd3d.kernels.kinematics import kinematics
from mbsd3d.mechanism.forces.custom import SavedForce
from mbsd3d.rotations import exponential, matrix, multiply

TOLERANCE = 1e-8
"""The limit set; the difference formula is good to 1e-12 times derivatives that reach 1e3 for bushing and tanh."""

T = 0.37


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
    covered = {type(make(rng, *bodies)[1]) for make in EXAMPLES.values()} | set(LOCKS)
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
        size = max(1.0, np.abs(Q[:, :3]).max())
        assert force < 1e-14 * size and moment < 1e-13 * size  # rounding of forces, and of arms of a few metres


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


def test_a_box_is_resisted_by_a_fluid():
    """The numbers of the definition, and the same in a frame that is turned in a body about a point beside O."""
    m, I, v, w = 0.4, np.array([0.004, 0.005, 0.006]), np.array([1.0, -2.0, 0.5]), np.array([3.0, -1.0, 2.0])
    lengths = np.sqrt(6.0 / m * (I.sum() - 2.0 * I))
    rng = np.random.default_rng(17)
    body, turn = random_body(rng), matrix(random_orientation(rng))
    at = body.position + direction(rng)
    drag = FluidDrag(body, lengths=lengths, density=1.3, viscosity=0.02, at=at, axes=body.axes @ turn)
    on = Loads(System(bodies=[body], forces=[drag], gravity=(0, 0, 0)))
    q, _ = on.general(rng)
    R = matrix(q[3:])
    F, s = R @ turn, R @ body.local_point(at)
    spin = F @ w
    Q, _, power = on.at(q, np.concatenate([F @ v - np.cross(spin, s), spin]))
    force, moment = np.array([-0.0886573, 0.28051187, -0.0398683]), np.array([-0.00416375, 0.00130945, -0.00276069])
    assert F.T @ Q[0, :3] == pytest.approx(force, abs=1e-7)  # the digits of the numbers
    assert F.T @ (Q[0, 3:] - np.cross(s, Q[0, :3])) == pytest.approx(moment, abs=1e-8)
    assert power == pytest.approx(force @ v + moment @ w, abs=1e-6)


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


def test_a_bearing_has_its_rate_and_its_acceleration():
    """Of the end of a rope seen from a drum: its angle there, and J_dot v at velocities that do not change."""
    rng = np.random.default_rng(23)
    a, b = random_body(rng, "one"), random_body(rng, "two")
    centre, end = a.position + 0.3 * direction(rng), b.position + 0.3 * direction(rng)
    axis = across(rng, (end - centre) / np.linalg.norm(end - centre))
    drum = Winch(a, radius=0.1, sense=1, centre=centre, axis=axis)
    rope = Rope((drum, (b, end)), stiffness=1.0)
    on, bearing = Loads(System([a, b], forces=[rope])), rope.path.spans[0].ways[0]
    i, (q, v) = on.compiled.coordinate(bearing), on.general(rng)

    def seen(h):
        """Angle and rate after both bodies have moved on evenly for h."""
        poses, twists = q.reshape(2, 7).copy(), v.reshape(2, 6)
        poses[:, :3] += h * twists[:, :3]
        for pose, twist in zip(poses, twists, strict=True):
            pose[3:] = multiply(exponential(h * twist[3:]), pose[3:])
        kinematics(on.model, on.data, on.state(poses.ravel(), v))
        return np.array([coordinate(on.model, on.data, i, T)[0], coordinate_rate(on.model, on.data, i, T)])

    rate, acceleration = derivative(seen)
    angle, rate_found = seen(0.0)
    (r_a, R_a), (r_b, R_b) = ((x[:3], matrix(x[3:])) for x in q.reshape(2, 7))
    gap = a.axes @ R_a.T @ (r_b + R_b @ b.local_point(end) - r_a) - (centre - a.position)  # as if a had not moved
    x, y = gap @ bearing.zero_a, gap @ np.cross(axis, bearing.zero_a)
    assert angle == pytest.approx(np.arctan2(y, x), abs=1e-13)
    assert rate_found == pytest.approx(rate, abs=TOLERANCE)
    assert coordinate(on.model, on.data, i, T)[1] == pytest.approx(acceleration, abs=TOLERANCE)


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
