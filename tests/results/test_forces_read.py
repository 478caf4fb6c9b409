"""Loads of force elements against their textbook formulas, written with scipy's rotations on the motion of a run."""

import numpy as np
import pytest
from helpers.forces import EXAMPLES
from helpers.models import direction, middle, random_body, random_orientation
from scipy.spatial.transform import Rotation

from mbsd3d import (
    GROUND,
    AeroDrag,
    Backlash,
    Brake,
    Bushing,
    Constant,
    Contact,
    CustomForce,
    Cylindrical,
    Force,
    JointFriction,
    Prismatic,
    Revolute,
    RotationStop,
    Sine,
    SpringDamper,
    StateFeedback,
    System,
    Torque,
    TorsionSpring,
    accelerations,
    load,
    measures,
    shapes,
    simulate,
)
from mbsd3d.extend import perpendiculars
from validation.cases.examples import moving

ROUNDING = 1e-10  # sums of some ten products of numbers up to 1e2, with the slack of hinges that are closed to 1e-15


def band(t, bodies, z, parameters, loads, z_dot):
    """A pull along the line between two points, with a slow state, and a moment on the first body."""
    gap = bodies[1].r - bodies[0].r
    loads[0, :3] = (parameters[0] + z[0]) * gap
    loads[1, :3] = -loads[0, :3]
    loads[0, 3:] = parameters[1] * bodies[0].w
    z_dot[0] = 0.3 - z[0]


def machine():
    """Two free bodies and two on hinge and slider, under the elements whose formulas are written out below."""
    rng = np.random.default_rng(5)
    a, b, c, d = (random_body(rng, name) for name in "abcd")
    hinge = Revolute(a, c, at=middle(rng, a, c), axis=direction(rng), name="hinge")
    slider = Prismatic(GROUND, d, at=d.position + 0.2 * direction(rng), axis=direction(rng), name="slider")
    ends = dict(at_a=a.position + 0.3 * direction(rng), at_b=b.position + 0.3 * direction(rng))
    turned = random_orientation(rng)
    at = middle(rng, a, b)
    forces = [
        SpringDamper(a, b, **ends, stiffness=7.0, damping=0.9, length=0.8, name="spring"),
        TorsionSpring(hinge, stiffness=3.0, damping=0.7, angle=0.4, name="torsion"),
        TorsionSpring(slider, stiffness=5.0, damping=0.2, angle=-0.1, name="buffer"),
        Brake(slider, torque=0.6, stiffness=4.0, damping=0.7, name="brake"),
        JointFriction(slider, coulomb=0.8, viscous=0.3, transition=0.5, name="friction"),
        Bushing(a, b, at=at, axes=turned, stiffness=(5, 7, 3), turning_stiffness=(2, 1.3, 4), damping=(0.4, 0.7, 0.2),
                turning_damping=(0.3, 0.6, 0.5), name="bushing"),
        Force(b, (1.0, Sine(2.0, 3.0), -0.5), at=b.position + direction(rng), frame="body", name="thrust"),
        Torque(b, (0.4, Constant(0.2), Sine(0.3, 2.0)), frame="body", name="torque"),
        AeroDrag(b, drag_area=0.5, density=1.2, at=b.position + 0.4 * direction(rng), wind=(1, -2, 0.5), name="drag"),
        StateFeedback(measures=[measures.angle(hinge), measures.rate(hinge)], gains=(2.0, 0.7), on=hinge,
                      reference=(0.4, -0.3), time_constant=0.2, name="servo"),
        CustomForce(band, on=(a, b), points=(ends["at_a"], at), parameters=(0.6, -0.2), states={"slow": 1.5},
                    name="band"),
        Contact(a, b, shapes.Ellipsoid((0.5, 0.4, 0.2), orientation=turned), stiffness=1.4, exponent=1.2, damping=0.1,
                loss=0.2, friction=0.5, rolling=0.02, spinning=0.6, grip=3.0, grip_damping=0.8, name="touch",
                plane=(b.position + (1.0, 1.5, 0.7), (0.3, 0.8, 0.2))),
    ]  # fmt: skip
    return System([a, b, c, d], [hinge, slider], forces, gravity=(0.3, -0.7, -9.6))


@pytest.fixture(scope="module")
def run():
    return simulate(machine(), 0.5, output=7)


class Seen:
    """A body of a run by scipy's rotations: what the formulas need."""

    def __init__(self, run, name):
        self.body = run.system.part(name)
        self.r, self.v, self.w = run.position(name), run.velocity(name), run.omega(name)
        turn = Rotation.from_quat(run.orientation(name), scalar_first=True)
        self.R = turn.as_matrix() @ Rotation.from_quat(self.body.orientation, scalar_first=True).as_matrix().T

    def point(self, at):
        """(position, velocity) of a point given at the reference pose."""
        arm = self.R @ (np.asarray(at) - self.body.position)
        return self.r + arm, self.v + np.cross(self.w, arm)

    def axes(self, columns):
        return self.R @ columns


def along_hinge(run, name):
    """(axis, angle from the rotation vector, rate) of the hinge between a and c."""
    part, a, c = run.system.part(name, "joints"), Seen(run, "a"), Seen(run, "c")
    axis = a.axes(part.axis)
    relative = Rotation.from_matrix(np.swapaxes(a.R, 1, 2) @ c.R).as_rotvec()
    return axis, relative @ part.axis, np.einsum("ti,ti->t", axis, c.w - a.w)


def along_slider(run):
    part, d = run.system.part("slider", "joints"), Seen(run, "d")
    p, v = d.point(part.at)
    return part.axis, (p - part.at) @ part.axis, v @ part.axis, p


def close(found, expected):
    np.testing.assert_allclose(found, np.broadcast_to(expected, np.shape(found)), rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("name", EXAMPLES)
def test_every_force_is_read_as_it_acts(name):
    """Newton and Euler for the body it acts on: it alone and the joint that it needs accelerate the body."""
    rng = np.random.default_rng(13)
    bodies = [random_body(rng, "one"), random_body(rng, "two")]
    joints, force = EXAMPLES[name](rng, *bodies)
    system = System(bodies, joints, [force], gravity=(0, 0, 0))
    now, body = accelerations(system, moving(system, 5)), bodies[1]
    R, w, alpha, G = (x[0] for x in (now.rotation(body), now.omega(body), now.alpha(body), now.com(body)))
    arm, I = G - now.position(body)[0], R @ body.inertia @ R.T
    push = body.mass * (now.acceleration(body)[0] + np.cross(alpha, arm) + np.cross(w, np.cross(w, arm)))
    turn = I @ alpha + np.cross(w, I @ w)
    held = [(1.0 if joint.b is body else -1.0, now.reaction(joint)) for joint in joints]
    acting = [(1.0, now.force(force, on=body)), *held]
    close(sum(side * x.force[0] for side, x in acting), push)
    close(sum(side * (x.moment[0] + np.cross(x.point[0] - G, x.force[0])) for side, x in acting), turn)
    at_work = np.abs([*acting[0][1].force[0], *acting[0][1].moment[0]]).max() > 1e-3  # it does something here
    assert at_work or isinstance(force, Backlash | RotationStop)  # whose limits lie about the pose as built


def test_spring(run):
    part, a, b = run.system.part("spring", "forces"), Seen(run, "a"), Seen(run, "b")
    (p, u), (q, v) = a.point(part.at_a), b.point(part.at_b)
    length = np.linalg.norm(q - p, axis=1)
    n = (q - p) / length[:, None]
    rate = np.sum(n * (v - u), axis=1)
    pull = 7.0 * (length - 0.8) + 0.9 * rate
    found = run.force("spring")
    close(found.force, -pull[:, None] * n)
    close(found.moment, 0.0)
    close(found.point, q)
    close(found.length, length)
    close(found.rate, rate)
    close(found.power, -pull * rate)
    close(found.stored, 3.5 * (length - 0.8) ** 2)
    other = run.force(part, on="a")
    close(other.force, pull[:, None] * n)
    close(other.point, p)
    assert found.angle is None and found.states == {}


def test_torsion_spring_and_servo(run):
    axis, angle, rate = along_hinge(run, "hinge")
    found = run.force("torsion")
    load_size = -3.0 * (angle - 0.4) - 0.7 * rate
    close(found.force, 0.0)
    close(found.moment, load_size[:, None] * axis)
    close(found.angle, angle)
    close(found.rate, rate)
    close(found.power, load_size * rate)
    assert found.length is None
    servo = run.force("servo")
    seen = servo.states
    assert list(seen) == ["angle of hinge", "rate of hinge"]
    size = -2.0 * (seen["angle of hinge"] - 0.4) - 0.7 * (seen["rate of hinge"] + 0.3)
    close(servo.moment, size[:, None] * axis)
    close(run.force("servo", on="a").moment, -size[:, None] * axis)


def test_buffer_and_friction_of_a_slider(run):
    axis, slide, speed, point = along_slider(run)
    for name, size in (
        ("buffer", -5.0 * (slide + 0.1) - 0.2 * speed),
        ("friction", -0.8 * np.tanh(speed / 0.5) - 0.3 * speed),
    ):
        found = run.force(name)
        close(found.force, size[:, None] * axis)
        close(found.moment, 0.0)
        close(found.point, point)
        close(found.length, slide)
        close(found.rate, speed)
        close(run.force(name, on=GROUND).force, -size[:, None] * axis)


def test_bushing(run):
    part, a, b = run.system.part("bushing", "forces"), Seen(run, "a"), Seen(run, "b")
    F = a.axes(Rotation.from_quat(part.axes, scalar_first=True).as_matrix())
    G = b.axes(Rotation.from_quat(part.axes, scalar_first=True).as_matrix())
    into = np.swapaxes(F, 1, 2)
    (p, _), (q, v) = a.point(part.at), b.point(part.at)
    u = a.v + np.cross(a.w, q - a.r)  # of the point of a where that of b is
    d, d_dot = (np.einsum("tij,tj->ti", into, x) for x in (q - p, v - u))
    w = np.einsum("tij,tj->ti", into, b.w - a.w)
    e = Rotation.from_matrix(into @ G).as_quat(canonical=True)
    K, C, K_r, C_r = part.stiffness, part.damping, part.turning_stiffness, part.turning_damping
    force = -(K * d + C * d_dot)
    moment = -2 * (e[:, 3:] * K_r * e[:, :3] + np.cross(e[:, :3], K_r * e[:, :3])) - C_r * w
    found = run.force("bushing")
    close(found.force, np.einsum("tij,tj->ti", F, force))
    close(found.moment, np.einsum("tij,tj->ti", F, moment))
    close(found.point, q)
    close(found.power, np.sum(force * d_dot + moment * w, axis=1))
    close(run.force("bushing", on="a").moment, -found.moment)
    close(run.force("bushing", on="a").point, q)


def test_contact(run):
    part, a, b = run.system.part("touch", "forces"), Seen(run, "a"), Seen(run, "b")
    form, (at, normal) = part.surface, part.plane
    along = perpendiculars(normal)[0]
    n, x, y = (a.axes(axis) for axis in (normal, along, np.cross(normal, along)))
    turn = Rotation.from_quat(b.body.orientation, scalar_first=True) * Rotation.from_quat(
        form.orientation, scalar_first=True
    )
    E = b.R @ turn.as_matrix()
    local = np.einsum("tji,tj->ti", E, n) * form.radii
    arm = -np.einsum("tij,tj->ti", E, local * form.radii) / np.linalg.norm(local, axis=1)[:, None]
    q = b.point(b.body.centre)[0] + arm
    v = b.v + np.cross(b.w, q - b.r) - a.v - np.cross(a.w, q - a.r)
    depth, speed = np.sum(n * (a.point(at)[0] - q), axis=1), -np.sum(n * v, axis=1)
    N = 1.4 * depth**1.2 * (1 + 0.2 * speed) + 0.1 * speed
    assert depth.min() > 0.1 and N.min() > 0.1  # it is pressed all the time

    def clipped(deflection, rate, stiffness, damping, most):
        pull = stiffness * deflection + damping * rate
        size = np.maximum(np.linalg.norm(pull, axis=1), 1e-300)  # all bodies start at rest
        return pull * np.minimum(1.0, most / size)[:, None]

    found, w, s = run.force("touch"), b.w - a.w, 0.5
    z = np.column_stack(list(found.states.values()))
    flat = np.stack([x, y], axis=2)
    slip, roll, spin = (np.einsum("tik,ti->tk", c, u) for c, u in ((flat, v), (flat, w), (n[:, :, None], w)))
    F = clipped(z[:, :2], slip, 3.0, 0.8, 0.5 * N)
    M = clipped(z[:, 2:4], roll, 3.0 * s**2, 0.8 * s**2, 0.02 * N)
    T = clipped(z[:, 4:], spin, 3.0 * s**2, 0.8 * s**2, 0.6 * N)
    close(found.force, N[:, None] * n - np.einsum("tik,tk->ti", flat, F))
    close(found.moment, -np.einsum("tik,tk->ti", flat, M) - T * n)
    close(found.point, q)
    close(found.power, np.sum(found.force * v + found.moment * w, axis=1))
    close(run.force("touch", on="a").force, -found.force)
    close(found.stored, 1.4 * depth**2.2 / 2.2 + 1.5 * np.sum(z**2 * [1, 1, s**2, s**2, s**2], axis=1))
    close(run.measure(measures.normal_force(part)), N)
    for load_, most in ((F, 0.5 * N), (M, 0.02 * N), (T, 0.6 * N)):
        assert (np.abs(load_).max(axis=1)[1:] > 1e-3 * most[1:]).all()
    assert (np.linalg.norm(F, axis=1) < 0.499 * N).any() and (np.linalg.norm(M, axis=1) > 0.019 * N).any()


def test_loads_on_one_body(run):
    b, t = Seen(run, "b"), run.t
    R_b = b.R @ Rotation.from_quat(b.body.orientation, scalar_first=True).as_matrix()
    part = run.system.part("thrust", "forces")
    one = np.ones(t.size)
    expected = np.einsum("tij,tj->ti", R_b, np.column_stack([one, 2.0 * np.sin(6.0 * np.pi * t), -0.5 * one]))
    p, v = b.point(part.at)
    found = run.force("thrust")
    close(found.force, expected)
    close(found.moment, 0.0)
    close(found.point, p)
    close(found.power, np.sum(expected * v, axis=1))
    expected = np.einsum("tij,tj->ti", R_b, np.column_stack([0.4 * one, 0.2 * one, 0.3 * np.sin(4.0 * np.pi * t)]))
    found = run.force("torque")
    close(found.moment, expected)
    close(found.power, np.sum(expected * b.w, axis=1))
    part = run.system.part("drag", "forces")
    p, v = b.point(part.at)
    u = v - (1, -2, 0.5)
    found = run.force("drag")
    close(found.force, -0.3 * np.linalg.norm(u, axis=1)[:, None] * u)
    close(found.point, p)


def test_custom_force_on_each_body(run):
    part, a, b = run.system.part("band", "forces"), Seen(run, "a"), Seen(run, "b")
    p, q = a.point(part.points[0])[0], b.point(part.points[1])[0]
    slow = 0.3 + 1.2 * np.exp(-run.t)
    first, second = run.force("band", on="a"), run.force("band")
    np.testing.assert_allclose(first.states["slow"], slow, rtol=0, atol=1e-7)  # integrated, rtol 1e-8
    size = (0.6 + first.states["slow"])[:, None]
    close(first.force, size * (q - p))
    close(first.moment, -0.2 * a.w)
    close(first.point, p)
    close(second.force, -size * (q - p))
    close(second.moment, 0.0)
    close(second.point, q)


def test_all_loads_add_up_to_the_motion(run):
    """Newton for body b: the elements on it and gravity; no joint holds it."""
    body = run.system.part("b")
    total = np.array([[0.3, -0.7, -9.6]]) * body.mass
    for force in run.system.forces:
        if body in force.bodies():
            total = total + run.force(force, on=body).force
    arm, w, alpha = run.com("b") - run.position("b"), run.omega("b"), run.alpha("b")
    a_G = run.acceleration("b") + np.cross(alpha, arm) + np.cross(w, np.cross(w, arm))
    close(body.mass * a_G, total)


def test_slips_are_named(run):
    with pytest.raises(ValueError, match="'nix' is not one of the forces of this system; there are 'spring'"):
        run.force("nix")
    with pytest.raises(ValueError, match="'spring' does not act on 'c'; it acts on 'a', 'b'"):
        run.force("spring", on="c")
    with pytest.raises(ValueError, match="name each once"):
        CustomForce(band, on=(run.system.bodies[0], GROUND), states=(1.0, 2.0), labels=("x", "x"))


def test_tables_figures_and_files_hold_the_loads(run, tmp_path):
    table = run.to_xarray()
    spring = table["force"].sel(force_element="spring")
    np.testing.assert_array_equal(spring, run.force("spring").force)
    assert "band on a" in table["force_element"].values and "band.slow" in table["own_state"].values
    np.testing.assert_array_equal(table["force_angle"].sel(force_element="torsion"), run.force("torsion").angle)
    head = run.to_csv(tmp_path / "run").read_text().splitlines()[0]
    assert "spring.force.x [N]" in head and "torsion.force_angle_rate [rad/s]" in head and "band.slow" in head
    figure = run.plot("force", "spring")
    assert [axes.get_ylabel() for axes in figure.axes] == ["force of spring [N]"]
    assert len(run.plot("force").axes) == 2 and run.plot("power", "drag") and run.plot("length")
    again = load(run.save(tmp_path / "run"))
    close(again.force("spring").force, run.force("spring").force)
    assert again.system.part("band", "forces").labels == ("slow",)
    assert again.plot("force") and "spring.force.x" in again.to_csv(tmp_path / "again").read_text()
    with pytest.raises(ValueError, match="the function of 'band' was not saved"):
        again.force("band")


def test_a_cylindrical_joint_is_read_at_its_angle():
    rng = np.random.default_rng(8)
    body = random_body(rng, "nut")
    joint = Cylindrical(GROUND, body, at=body.position + 0.2 * direction(rng), axis=direction(rng), name="pin")
    solution = simulate(System([body], [joint], [TorsionSpring(joint, stiffness=2.0, angle=1.0, name="coil")]), 0.3)
    found = solution.force("coil")
    close(found.angle, solution.angle(joint))
    close(found.rate, solution.rate(joint))
