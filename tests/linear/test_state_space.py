"""Linear models from inputs to outputs, against matrices written by hand and published numbers."""

import sys

import numpy as np
import pytest

from bicycle import Meijaard2007, whipple
from mbsd3d import (
    GROUND,
    AeroDrag,
    AngleDriver,
    Body,
    Bushing,
    Force,
    ForceBetween,
    LinearActuator,
    Parallel,
    Perpendicular,
    Polynomial,
    PositionDriver,
    Prismatic,
    Ramp,
    Revolute,
    SlideDriver,
    SpeedDriver,
    Spherical,
    SpringDamper,
    System,
    Torque,
    TorqueBetween,
    TorsionSpring,
    accelerations,
    linearize,
    measures,
    rotation,
    simulate,
    state_space,
)
from mbsd3d.errors import InputError
from mbsd3d.signals import Input, Sine

W = (1.0, 5.0, 20.0)  # [rad/s]
EXACT = 1e-10
"""Of H: rounding of matrices of order one, solved near resonance."""


def worst(found, expected):
    """Largest deviation over the largest value of each entry along the frequencies."""
    found, expected = np.asarray(found), np.asarray(expected)
    return np.abs(found - expected).max() / np.abs(expected).max()


def second_order(M, damping, K, loads, w):
    """(n, outputs, inputs) displacements of M q'' + C q' + K q = loads u."""
    return np.array([np.linalg.solve(K + 1j * x * damping - x**2 * M, loads) for x in np.atleast_1d(w)])


def test_chain_of_three_masses():
    m, k, c = np.array([1.0, 2.0, 0.5]), np.array([100.0, 200.0, 150.0]), np.array([0.5, 1.0, 0.2])
    way = np.array([2.0, 3.0, 6.0]) / 7.0
    bodies = [Body(f"m{i}", m[i], (0.1, 0.2, 0.15), com=(0.1, -0.2, 0.05), position=(i + 1.0) * way) for i in range(3)]
    rails = [Prismatic(GROUND, body, at=body.position, axis=way, name=f"rail{i}") for i, body in enumerate(bodies)]
    ends = [GROUND, *bodies]
    springs = [
        SpringDamper(ends[i], ends[i + 1], at_a=i * way, at_b=(i + 1) * way, stiffness=k[i], damping=c[i])
        for i in range(3)
    ]
    push = Force(bodies[2], [x * Input("push") for x in way])
    system = System(bodies, rails, [*springs, push], gravity=(0, 0, 0))
    last = measures.velocity(bodies[2], axis=way)
    model = state_space(system, outputs=[measures.slide(rails[0]), ("derivative", last), ("acceleration", "m2")])

    def banded(x):
        return np.diag(x + np.append(x[1:], 0.0)) - np.diag(x[1:], 1) - np.diag(x[1:], -1)

    expected = second_order(np.diag(m), banded(c), banded(k), np.array([[0.0], [0.0], [1.0]]), W)[:, :, 0]
    H = model.frequency_response(W).H[:, :, 0]
    assert worst(H[:, 0], expected[:, 0]) < EXACT
    acceleration = -(np.array(W) ** 2) * expected[:, 2]
    assert worst(H[:, 1], acceleration) < EXACT
    assert worst(H[:, 2:], acceleration[:, None] * way) < EXACT
    assert abs(model.D[1, 0] - 2.0) < 1e-12 and not model.D[0, 0]
    assert abs(H[1, 0] - (-0.08436249231978066 - 0.015548901526951903j)) < EXACT  # the same by other hands
    assert model.input_units == ("-",) and model.output_units[:2] == ("m", "m/s^2")


def cart_pole(upright):
    M, m, inertia, length, c = 1.0, 0.3, 0.006, 0.3, 0.1
    side = 1.0 if upright else -1.0
    cart = Body("cart", M, (0.1, 0.2, 0.3), com=(0.05, 0.02, -0.1))
    pole = Body("pole", m, (inertia, inertia, 0.001), com=(0, 0, side * length))
    rail = Prismatic(GROUND, cart, at=(0, 0, 0), axis=(1, 0, 0), name="rail")
    pin = Revolute(cart, pole, at=(0, 0, 0), axis=(0, 1, 0), name="pin")
    damper = SpringDamper(GROUND, cart, at_a=(-3, 0, 0), at_b=(0, 0, 0), stiffness=0.0, damping=c)
    system = System([cart, pole], [rail, pin], [damper, Force(cart, (Input("push"), 0, 0), at=(0, 0, 0), name="hand")])
    mass = np.array([[M + m, side * m * length], [side * m * length, inertia + m * length**2]])
    stiffness = np.diag([0.0, -side * m * 9.81 * length])
    return system, rail, pin, mass, np.diag([c, 0.0]), stiffness, m, side * length


@pytest.mark.parametrize("upright", [False, True])
def test_cart_and_pole(upright):
    system, rail, pin, M, damping, K, m, l = cart_pole(upright)
    outputs = [measures.slide(rail), measures.angle(pin), ("derivative", measures.slide_rate(rail)),
               ("derivative", measures.rate(pin)), ("reaction", pin)]  # fmt: skip
    model = state_space(system, outputs=outputs)
    H, w = model.frequency_response(W).H[:, :, 0], np.array(W)[:, None]
    expected = second_order(M, damping, K, np.array([[1.0], [0.0]]), W)[:, :, 0]
    acceleration = -(w**2) * expected
    assert worst(H[:, :2], expected) < EXACT and worst(H[:, 2:4], acceleration) < EXACT
    pin_force = m * (acceleration[:, 0] + l * acceleration[:, 1])
    assert worst(H[:, 4], pin_force) < EXACT
    assert np.abs(model.D[:2]).max() == 0.0 and worst(model.D[2:4, 0], np.linalg.inv(M)[:, 0]) < 1e-12
    assert abs(model.D[4, 0] - 0.05172413793103452) < 1e-12
    poles = np.linalg.eigvals(np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(M, np.hstack([K, damping]))]]))
    assert np.abs(np.sort_complex(model.poles) - np.sort_complex(poles)).max() < 1e-7  # numpy splits the double zero
    assert (model.poles == 0.0).sum() == 1 and model.inputs == ("push",) and model.input_units == ("N",)


def test_response_at_a_pole_names_the_mode():
    system, rail, pin, *_ = cart_pole(False)
    model = state_space(system, outputs=[measures.slide(rail), measures.angle(pin), measures.slide_rate(rail)])
    found = model.frequency_response([0.0, 1.0])
    assert np.isinf(found.H[0, 0, 0]) and np.isfinite(found.H[0, 1:]).all()  # a cart pushed for ever, pole upright
    assert abs(found.H[0, 1, 0]) < EXACT and abs(found.H[0, 2, 0] - 1.0 / 0.1) < 1e-9
    assert found.at_poles == ((0.0, "slide of 'rail'"),) and "infinite at 0 rad/s, a pole: slide of 'rail'" in repr(
        found
    )


def test_undamped_pole_on_the_axis():
    mass = Body("mass", 2.0, (1, 1, 1))
    rail = Prismatic(GROUND, mass, at=(0, 0, 0), axis=(1, 0, 0), name="rail")
    spring = SpringDamper(GROUND, mass, at_a=(-1, 0, 0), at_b=(0, 0, 0), stiffness=50.0)
    model = state_space(
        System([mass], [rail], [spring, Force(mass, (Input("u"), 0, 0))]), outputs=[measures.slide(rail)]
    )
    found = model.frequency_response([4.9, 5.0])
    assert np.isinf(found.H[1, 0, 0]) and found.at_poles == ((5.0, "slide of 'rail'"),)
    assert abs(found.H[0, 0, 0] - 1.0 / (50.0 - 2.0 * 4.9**2)) < EXACT


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_double_pendulum_with_a_motor_in_the_elbow(side):
    one, two = (
        Body(f"rod{i}", 1.0, (0.25 / 12,) * 2 + (1e-4,), position=(0, 0, side * (0.25 + 0.5 * i))) for i in (0, 1)
    )
    axis = (0, 1, 0)
    hip, elbow = Revolute(GROUND, one, at=(0, 0, 0), axis=axis), Revolute(one, two, at=(0, 0, side * 0.5), axis=axis)
    motor = Input("motor")
    system = System([one, two], [hip, elbow], [Torque(two, (0, motor, 0)), Torque(one, (0, -1.0 * motor, 0))])
    rates = [("derivative", measures.rate(x)) for x in (hip, elbow)]
    model = state_space(system, outputs=[measures.angle(hip), measures.angle(elbow), *rates])
    sums = np.array([[1.0, 0.0], [1.0, 1.0]])  # absolute angles of relative ones
    inertia, coupled = 0.25 / 12 + 0.25**2, 0.5 * 0.25
    M, weight = np.array([[inertia + 0.25, coupled], [coupled, inertia]]), 9.81
    K = -side * np.diag([0.25 + 0.5, 0.25]) * weight
    expected = second_order(M, 0.0 * M, K, np.array([[-1.0], [1.0]]), W)
    H = sums @ model.frequency_response(W).H[:, :2]
    assert worst(H, expected) < EXACT
    assert worst(sums @ model.D[2:], np.linalg.solve(M, [[-1.0], [1.0]])) < 1e-12
    assert worst(sums @ model.D[2:, 0], [-17.142857142857146, 37.71428571428572]) < 1e-12
    assert np.abs(np.sort((model.poles**2).real)[::2] - np.sort(-np.linalg.eigvals(np.linalg.solve(M, K)))).max() < 1e-9


def gyroscope():
    outer = Body("outer", 1.0, (0.01, 0.012, 0.01))
    inner = Body("inner", 1.0, (0.005, 0.006, 0.004))
    rotor = Body("rotor", 1.0, (0.005, 0.003, 0.003))
    posts = Revolute(GROUND, outer, at=(0, 0, 0), axis=(0, 0, 1), name="posts")
    pivot = Revolute(outer, inner, at=(0, 0, 0), axis=(0, 1, 0), name="pivot")
    shaft = Revolute(inner, rotor, at=(0, 0, 0), axis=(1, 0, 0), name="shaft")
    forces = [TorsionSpring(posts, stiffness=0.0, damping=0.002), Torque(outer, (0, 0, Input("tau_z"))),
              Torque(inner, (0, Input("tau_y"), 0))]  # fmt: skip
    return System([outer, inner, rotor], [posts, pivot, shaft], forces, gravity=(0, 0, 0)), posts, pivot, shaft


def test_gyroscope_in_gimbals():
    system, posts, pivot, shaft = gyroscope()
    model = state_space(
        system, system.assemble(rates={shaft: 400.0}), outputs=[measures.angle(posts), measures.angle(pivot)]
    )
    A_z, A_y, momentum, w = 0.01 + 0.004 + 0.003, 0.006 + 0.003, 0.005 * 400.0, (1.0, 50.0, 200.0)
    damping = np.array([[0.002, -momentum], [momentum, 0.0]])
    expected = second_order(np.diag([A_z, A_y]), damping, np.zeros((2, 2)), np.eye(2), w)
    assert worst(model.frequency_response(w).H, expected) < EXACT
    assert abs(np.abs(model.poles.imag).max() - 161.69041669) < 1e-2  # nutation without damping H / sqrt(A_z A_y)
    assert model.inputs == ("tau_z", "tau_y") and model.input_units == ("N m", "N m")


def test_gyroscope_on_a_driven_post():
    """The axis of a spinning rotor is turned by a driver: A_y th'' = -H u', and the effort carries H^2 / A_y u."""
    plain, posts, pivot, shaft = gyroscope()
    forces = [plain.forces[0]]
    system = System(
        plain.bodies, [posts, pivot, shaft, AngleDriver(posts, Input("u"), name="motor")], forces, plain.gravity
    )
    start = system.assemble(rates={shaft: 400.0})
    model = state_space(system, start, outputs=[measures.angle(pivot), ("effort", "motor"), ("alpha", "rotor")])
    A_z, A_y, momentum, s = 0.017, 0.009, 2.0, 1j * np.array(W)
    H = model.frequency_response(W).H[:, :, 0]
    assert worst(H[:, 0], -momentum / (A_y * s)) < EXACT
    assert worst(H[:, 1], A_z * s**2 + 0.002 * s + momentum**2 / A_y) < EXACT
    across = 400.0 * s - momentum / A_y * s  # about y: the axis of the spin turns about z, and the gimbal swings
    assert worst(H[:, 3], across) < EXACT and worst(H[:, 4], s**2 + 400.0 * momentum / A_y) < EXACT
    assert model.input_units == ("rad",)


def test_turntable_whose_turning_is_driven():
    """A mass on a radial spring of a turntable: r'' = (W^2 - k / m) r + 2 r0 W u', about a motion that turns."""
    J, m, k, free, rate = 0.3, 2.0, 900.0, 0.4, 8.0
    r0 = k * free / (k - m * rate**2)
    table = Body("table", 1.0, (0.2, 0.2, J), omega=(0, 0, rate))
    slug = Body("slug", m, (0.01, 0.01, 0.01), position=(r0, 0, 0))
    axle = Revolute(GROUND, table, at=(0, 0, 0), axis=(0, 0, 1), name="axle")
    slot = Prismatic(table, slug, at=(r0, 0, 0), axis=(1, 0, 0), name="slot")
    spring = SpringDamper(table, slug, at_a=(0, 0, 0), at_b=(r0, 0, 0), stiffness=k, length=free)
    motor = AngleDriver(axle, Ramp(rate) + Input("u"), name="motor")
    system = System([table, slug], [axle, slot, motor], [spring], gravity=(0, 0, 0))
    model = state_space(system, outputs=[measures.slide(slot), ("effort", "motor"), ("acceleration", slug)])
    s = 1j * np.array(W)
    slide = 2.0 * r0 * rate * s / (s**2 + k / m - rate**2)
    effort = (J + 0.01 + m * r0**2) * s**2 + 2.0 * m * r0 * rate * s * slide
    H = model.frequency_response(W).H[:, :, 0]
    assert worst(H[:, 0], slide) < EXACT and worst(H[:, 1], effort) < EXACT
    radial, across = (s**2 - rate**2) * slide - 2.0 * r0 * rate * s, r0 * s**2 + 2.0 * rate * s * slide
    turned = np.stack([radial, across - r0 * rate**2], axis=1)  # in axes that turn at the rate, not with u
    assert worst(H[:, 2:4], turned) < EXACT


def steered(speed, s):
    """(n, 3) lean, steer [rad/(N m)] and yaw rate [rad/(N m s)] per steer torque at s = i w [1/s].

    From M, C1, K0 and K2 of the benchmark bicycle, Meijaard et al. 2007, appendix.
    """
    M = np.array([[80.81722, 2.31941332208709], [2.31941332208709, 0.29784188199686]])
    C1 = np.array([[0.0, 33.86641391492494], [-0.85035641456978, 1.68540397397560]])
    K0 = np.array([[-80.95, -2.59951685249872], [-2.59951685249872, -0.80329488458618]])
    K2 = np.array([[0.0, 76.59734589573222], [0.0, 2.65431523794604]])
    wheelbase, trail, tilt = 1.02, 0.08, np.pi / 10
    s = np.asarray(s)[:, None, None]
    lean, steer = np.linalg.solve(M * s**2 + speed * C1 * s + 9.81 * K0 + speed**2 * K2, [[0.0], [1.0]])[..., 0].T
    return np.column_stack([lean, steer, (speed + trail * s[:, 0, 0]) * steer * np.cos(tilt) / wheelbase])


@pytest.mark.parametrize("speed", [0.5, 3.0, 5.0, 8.0])
def test_benchmark_bicycle(speed):
    plain = whipple(Meijaard2007(), speed=speed)
    frame, fork, steer = plain.part("frame"), plain.part("fork"), plain.part("steer", "joints")
    torque = Input("steer torque")
    motor = [Torque(fork, [x * torque for x in steer.axis]), Torque(frame, [-x * torque for x in steer.axis])]
    bicycle = System(plain.bodies, plain.joints, [*plain.forces, *motor])
    seen = [measures.lean(frame), measures.angle(steer), measures.omega(frame, axis=(0, 0, -1))]
    model = state_space(bicycle, plain.state(), outputs=seen)
    w = np.array([0.3, 1.0, 5.0, 20.0])
    assert worst(model.frequency_response(w).H[:, :, 0], steered(speed, 1j * w)) < 1e-8  # published digits
    B = state_space(bicycle, plain.state(), outputs=[("derivative", measures.lean_rate(frame)),
                                                     ("derivative", measures.rate(steer))]).D  # fmt: skip
    assert worst(B[:, 0], (-0.12409202541157413, 4.323840180804228)) < 1e-9  # published digits
    slow = model.frequency_response([1e-6]).H[0, :2, 0]  # heading and place drift as 1 / w^3, and no output sees them
    assert worst(slow.real, steered(speed, [0.0])[0, :2]) < 1e-8 and np.abs(slow.imag).max() < 1e-4


def quarter_car(ct):
    masses = {"seat": 80.0, "body": 280.0, "wheel": 38.0}
    road = Body("road", 0.0, (0, 0, 0))
    bodies = [Body(name, m, (1, 1, 1), position=(0, 0, 3.0 - i)) for i, (name, m) in enumerate(masses.items())]
    rails = [
        Prismatic(GROUND, body, at=body.position, axis=(0, 0, 1), name=f"{body.name} rail") for body in (*bodies, road)
    ]
    chain = [*bodies, road]
    laws = ((12000.0, 900.0), (18000.0, 1400.0), (190000.0, ct))
    springs = [
        SpringDamper(b, a, at_a=b.position, at_b=a.position, stiffness=k, damping=c)
        for a, b, (k, c) in zip(chain[:-1], chain[1:], laws, strict=True)
    ]
    joints = [*rails, SlideDriver(rails[-1], Input("road"), name="shaker")]
    return System(chain, joints, springs, gravity=(0, 0, 0)), rails


@pytest.mark.parametrize("ct", [0.0, 350.0])
def test_quarter_car_on_a_moving_road(ct):
    system, rails = quarter_car(ct)
    model = state_space(system, outputs=[*(measures.slide(x) for x in rails[:3]), ("effort", "shaker")])
    w = np.array([2.0, 10.0, 70.0])
    (ms, mb, mu), (ks, kb, kt), (cs, cb) = (80.0, 280.0, 38.0), (12000.0, 18000.0, 190000.0), (900.0, 1400.0)

    def banded(s, b, t):
        return np.array([[s, -s, 0.0], [-s, s + b, -b], [0.0, -b, b + t]])

    u = np.array([0.0, 0.0, 1.0])
    expected = np.array([
        np.linalg.solve(banded(ks, kb, kt) + 1j * x * banded(cs, cb, ct) - x**2 * np.diag([ms, mb, mu]),
                        (kt + 1j * x * ct) * u) for x in w
    ])  # fmt: skip
    H = model.frequency_response(w).H[:, :, 0]
    assert worst(H[:, :3], expected) < EXACT
    assert worst(H[:, 3], (kt + 1j * w * ct) * (1.0 - expected[:, 2])) < EXACT  # the road pushes the tyre up
    assert np.abs(model.D[:3]).max() == 0.0
    assert abs(model.D[3, 0] - (kt - ct**2 / mu)) < 1e-6 and abs(model.D1[3, 0] - ct) < 1e-9 and not model.D2.any()
    if not ct:
        assert abs(H[1, 2] - (0.9512670906129431 - 0.14488186173571982j)) < EXACT and model.proper


def rheonomic_pendulum():
    M, m, inertia, l = 1.0, 2.0, 0.05, 0.3
    cart, bob = Body("cart", M, (1, 1, 1)), Body("bob", m, (inertia, inertia, 0.01), com=(0.0, 0.0, -l))
    rail = Prismatic(GROUND, cart, at=(0, 0, 0), axis=(1, 0, 0), name="rail")
    pin = Revolute(cart, bob, at=(0, 0, 0), axis=(0, 1, 0), name="pin")
    return System([cart, bob], [rail, pin, SlideDriver(rail, Input("u"), name="motor")]), pin, (M, m, inertia, l)


def test_pendulum_on_a_driven_pivot():
    system, pin, (M, m, inertia, l) = rheonomic_pendulum()
    outputs = [measures.angle(pin), measures.rate(pin), ("derivative", measures.rate(pin)), ("effort", "motor")]
    model = state_space(system, outputs=outputs)
    J, w = inertia + m * l * l, np.array(W)
    angle = m * l * -(w**2) / (m * 9.81 * l - J * w**2)  # J th'' + m g l th = m l u''
    effort = (M + m) * -(w**2) - m * l * -(w**2) * angle
    H = model.frequency_response(W).H[:, :, 0]
    assert worst(H, np.stack([angle, 1j * w * angle, -(w**2) * angle, effort], axis=1)) < EXACT
    ratio = m * l / J
    assert abs(model.D[0, 0] - ratio) < 1e-12 and not model.D1[0, 0] and not model.D2[:2].any()
    assert abs(model.D1[1, 0] - ratio) < 1e-12 and abs(model.D2[2, 0] - ratio) < 1e-12
    assert abs(model.D[2, 0] + 66.75992438563327) < EXACT and abs(model.D[3, 0] - 40.05595463137997) < EXACT
    assert abs(model.D2[3, 0] - 1.434782608695652) < 1e-12
    proper = state_space(system, outputs=outputs, driver="acceleration")
    assert proper.proper and proper.inputs == ("acceleration of u",) and proper.input_units == ("m/s^2",)
    assert worst(proper.frequency_response(W).H[:, :, 0] * -(w[:, None] ** 2), H) < EXACT
    assert proper.states[-2:] == ("u", "rate of u")
    with pytest.raises(InputError, match=r'to_scipy: output .* driver="acceleration"'):
        model.to_scipy()


def test_driven_speed():
    """A flywheel on a torsion spring behind a hinge turned at a prescribed speed u: J q'' = -k (q - integral of u)."""
    hub, wheel = Body("hub", 1.0, (0.2, 0.2, 0.3)), Body("wheel", 2.0, (0.3, 0.3, 0.4))
    axle = Revolute(GROUND, hub, at=(0, 0, 0), axis=(0, 0, 1), name="axle")
    shaft = Revolute(hub, wheel, at=(0, 0, 0), axis=(0, 0, 1), name="shaft")
    motor = SpeedDriver(axle, Input("speed", 3.0), name="motor")
    system = System([hub, wheel], [axle, shaft, motor], [TorsionSpring(shaft, stiffness=5.0, damping=0.2)])
    start = system.assemble(rates={axle: 3.0, shaft: 0.0})
    model = state_space(system, start, outputs=[measures.omega(wheel, axis=(0, 0, 1)), ("effort", "motor")])
    s = 1j * np.array(W)
    wheel_per_speed = (5.0 + 0.2 * s) / (5.0 + 0.2 * s + 0.4 * s**2)
    effort = 0.3 * s + (5.0 / s + 0.2) * (1.0 - wheel_per_speed)
    assert worst(model.frequency_response(W).H[:, :, 0], np.stack([wheel_per_speed, effort], axis=1)) < EXACT
    proper = state_space(system, start, outputs=[("effort", "motor")], driver="acceleration")
    assert proper.inputs == ("rate of speed",) and worst(proper.frequency_response(W).H[:, 0, 0] * s, effort) < EXACT
    assert model.input_units == ("rad/s",)


def four_bar():
    ground, a, b, c = 0.4, 0.15, 0.35, 0.3
    guess = 0.520055115716321
    start = np.array([0.0, 0.0, 0.0])
    crank_end = a * np.array([np.cos(guess), 0.0, np.sin(guess)])
    far = np.array([ground, 0.0, 0.0])
    reach = far - crank_end
    d = np.linalg.norm(reach)
    along = (b * b - c * c + d * d) / (2.0 * d)
    up = np.array([-reach[2], 0.0, reach[0]]) / d
    knee = crank_end + along * reach / d + np.sqrt(b * b - along * along) * up

    def rod(name, mass, p, q):
        way = (q - p) / np.linalg.norm(q - p)
        inertia = mass * ((q - p) @ (q - p)) / 12.0 * (np.eye(3) - np.outer(way, way))
        return Body(name, mass, inertia + 1e-9 * np.outer(way, way), position=p, com=0.5 * (q - p))

    crank, coupler, rocker = (
        rod("crank", 0.5, start, crank_end),
        rod("coupler", 1.0, crank_end, knee),
        rod("rocker", 0.8, far, knee),
    )
    axis = (0, -1, 0)  # angles grow from x to z
    places = ((GROUND, crank, start), (crank, coupler, crank_end), (coupler, rocker, knee), (GROUND, rocker, far))
    hinges = [Revolute(p, q, at=at, axis=axis, name=name) for (p, q, at), name in zip(places, "ABCD", strict=True)]
    spring = TorsionSpring(hinges[0], stiffness=2.0, damping=0.05, angle=1.0 - guess)
    forces = [spring, Torque(crank, (0, -1.0 * Input("torque"), 0))]
    return System([crank, coupler, rocker], hinges, forces), hinges


def test_four_bar_with_redundant_hinges():
    system, hinges = four_bar()
    rest = system.equilibrium().state
    crank = measures.angle(hinges[0])
    model = state_space(
        system, rest, outputs=[crank, measures.angle(hinges[3]), ("derivative", measures.rate(hinges[0]))]
    )
    H = model.frequency_response([1.0, 9.0, 20.0]).H[:, :, 0]
    expected = [
        [0.7204370710061614 - 0.02598524029966842j, -0.08375091514394861 + 0.0030207879951169693j],
        [1.1057980935458254 - 1.0025824165414894j, -0.12854919052063124 + 0.11655035293410534j],
        [-0.2958718382092519 - 0.09693690896501296j, 0.0343951445762502 + 0.011268929881283191j],
    ]  # 40-digit derivatives of kinetic and potential energy
    assert worst(H[:, :2], expected) < 1e-8  # the equilibrium is found to some 1e-10
    assert abs(model.D[2, 0] / 89.89618248123462 - 1.0) < 1e-8
    assert abs(abs(model.poles[0]) / 11.207940940935828 - 1.0) < 1e-8
    with pytest.raises(InputError, match="reaction of 'B' is not determined"):
        state_space(system, rest, outputs=[("reaction", hinges[1])])


def hook(signals, torque=0.0):
    """A spatial double pendulum, its centres off all axes, that hangs on a hook moved in three directions."""
    top = Body("hook", 0.5, (0.1, 0.1, 0.1))
    one = Body("one", 2.0, (0.2, 0.3, 0.15), com=(0.02, -0.01, -0.4))
    inertia = ((0.1, 0.01, 0), (0.01, 0.12, 0.02), (0, 0.02, 0.05))
    two = Body("two", 1.0, inertia, com=(-0.1, 0.0, -0.3), position=(0.1, 0.05, -0.7))
    lift = PositionDriver(top, at=(0, 0, 0), signal=signals, name="lift")
    upright = [Parallel(GROUND, top, axis=(0, 0, 1)), Perpendicular(GROUND, top, axis_a=(1, 0, 0), axis_b=(0, 1, 0))]
    eye = Spherical(top, one, at=(0, 0, 0), name="eye")
    knee = Revolute(one, two, at=(0, 0, -0.8), axis=(1, 2, 0), name="knee")
    return System([top, one, two], [lift, *upright, eye, knee], [Torque(two, (0.3 * torque, torque, 0), name="motor")])


@pytest.mark.parametrize("k", [0, 1, 2])
def test_a_moved_hook_beside_an_instant_of_the_mechanism(k):
    """D2 and D of accelerations, reactions and efforts are what accelerations gain by u'' = 1 and by the torque 1."""
    inputs = [Input(f"u{i}") for i in range(3)]
    rest = hook(inputs).equilibrium().state
    parts = [("acceleration", "two"), ("alpha", "one"), ("reaction", "knee"), ("effort", "lift")]
    model = state_space(hook(inputs, Input("torque")), rest, outputs=parts)
    still = [0.0, 0.0, 0.0]
    moved = [Polynomial((0.0, 0.0, 0.5)) if i == k else 0.0 for i in range(3)]

    def seen(system):
        found = accelerations(system, rest)
        knee = found.reaction("knee")
        vectors = found.acceleration("two"), found.alpha("one"), knee.force, knee.moment, found.effort("lift")
        return np.concatenate([x.ravel() for x in vectors])

    plain = seen(hook(still))
    assert worst(model.D2[:, model.inputs.index(f"u{k}")], seen(hook(moved)) - plain) < 1e-11  # plain: 30 N
    torque = seen(hook(still, 1.0)) - plain
    assert worst(model.D[:, model.inputs.index("torque")], torque) < 1e-11
    assert model.output_units[-3:] == ("N",) * 3 and model.input_units[:3] == ("m",) * 3


def test_driver_that_cannot_move_is_named():
    arm, bob = Body("arm", 1.0, (0.1, 0.1, 0.1)), Body("bob", 1.0, (0.1, 0.1, 0.1), com=(0, 0, -0.3))
    hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=(0, 1, 0), name="hinge")
    pin = Revolute(arm, bob, at=(0, 0, 0), axis=(0, 1, 0), name="pin")
    drivers = [AngleDriver(hinge, Input("u"), name="motor"), AngleDriver(hinge, 0.0, name="lock")]
    with pytest.raises(InputError, match="input 'u' prescribes a motion that other joints or drivers do not allow"):
        state_space(System([arm, bob], [hinge, pin, *drivers]), outputs=[measures.angle(pin)])


def test_wind_on_a_body_is_not_linear():
    car = Body("car", 1200.0, (300, 900, 1000), com=(0.1, 0.0, 0.2), velocity=(30.0, 0, 0), omega=(0, 0, 0))
    rail = Prismatic(GROUND, car, at=(0, 0, 0), axis=(1, 0, 0), name="rail")
    drag = AeroDrag(car, at=car.position, drag_area=0.6, density=1.2, wind=(Input("wind", -4.0), 0, 0))
    pull = Force(car, (0.36 * 34.0**2, 0, 0))
    model = state_space(System([car], [rail], [drag, pull]), outputs=[measures.slide_rate(rail)])
    k = 0.72 * 34.0
    assert worst(model.frequency_response(W).H[:, 0, 0], k / (1j * 1200.0 * np.array(W) + k)) < EXACT
    assert model.input_units == ("m/s",)


def test_zeros_of_the_cart_pole():
    system, rail, pin, M, damping, K, m, l = cart_pole(False)
    model = state_space(
        system, outputs=[measures.slide(rail), measures.angle(pin), ("derivative", measures.slide_rate(rail))]
    )
    stuck = np.sqrt(K[1, 1] / M[1, 1])  # the pendulum on a cart held at its place
    cart = model.select("slide of rail").zeros
    assert np.abs(np.sort(cart.imag) - [-stuck, stuck]).max() < 1e-10 and np.abs(cart.real).max() < 1e-10
    pole = model.select(1).zeros  # th per push: s^2 cancels one of the two poles at zero and the pole of the damper
    assert np.abs(pole).max() < 1e-6 and pole.size == 2
    acceleration = model.select(2).zeros
    assert np.abs(np.sort(acceleration.imag) - [-stuck, 0, 0, stuck]).max() < 1e-10 and (acceleration == 0.0).sum() == 2
    with pytest.raises(InputError, match="zeros: 3 outputs and 1 input"):
        model.zeros  # noqa: B018
    with pytest.raises(InputError, match="select: outputs: 'here' is not one of"):
        model.select("here")


def test_step_and_other_packages():
    mass = Body("mass", 2.0, (1, 1, 1))
    rail = Prismatic(GROUND, mass, at=(0, 0, 0), axis=(1, 0, 0), name="rail")
    spring = SpringDamper(GROUND, mass, at_a=(-1, 0, 0), at_b=(0, 0, 0), stiffness=50.0, damping=4.0)
    model = state_space(
        System([mass], [rail], [spring, Force(mass, (Input("u"), 0, 0))]), outputs=[measures.slide(rail)]
    )
    t, fast = np.linspace(0.0, 3.0, 301), np.sqrt(24.0)
    expected = (1.0 - np.exp(-t) * (np.cos(fast * t) + np.sin(fast * t) / fast)) / 50.0
    assert np.abs(model.step(t)[:, 0, 0] - expected).max() < 1e-12
    other = model.to_scipy()
    H = other.C @ np.linalg.solve(5j * np.eye(2) - other.A, other.B) + other.D
    assert abs(H[0, 0] - 1.0 / (50.0 + 5j * 4.0 - 25.0 * 2.0)) < EXACT
    with pytest.raises(InputError, match="step: t must start at 0"):
        model.step([1.0, 2.0])
    figure = model.bode()
    curve = figure.axes[0].lines[0]
    assert abs(curve.get_ydata()[0] - np.abs(model.frequency_response(curve.get_xdata()[:1]).H[0, 0, 0])) < 1e-15
    assert [axes.get_xlabel() for axes in figure.axes] == ["", "frequency ω [rad/s]"]


def test_a_bode_plot_of_loads_tells_lines_apart_and_leaves_rounding_out():
    """The moments of a spring about its own point are rounding; six colours begin anew with dashes."""
    block = Body("block", 2.0, (0.1, 0.2, 0.3), com=(0.1, -0.2, 0.05), orientation=rotation((1, 2, 3), 0.7))
    mount = Bushing(GROUND, block, at=(0.1, 0.2, 0.3), stiffness=(2e3, 3e3, 4e3), turning_stiffness=300.0, name="mount")
    strut = SpringDamper(GROUND, block, at_a=(-1, 0.3, 0.7), at_b=(0.3, 0.1, 0.2), stiffness=200.0, name="strut")
    system = System([block], [], [mount, strut, Force(block, (Input("push"), 0, 0))])
    rest = system.equilibrium().state
    model = state_space(system, rest, outputs=[("force", mount), ("force", strut)])
    figure = model.bode()
    size = np.abs(model.frequency_response(figure.axes[0].lines[0].get_xdata()).H)
    assert figure.axes[0].get_ylim()[0] > 1e-16 * size.max()
    looks = [(line.get_color(), line.get_linestyle()) for line in figure.axes[0].lines]
    assert len(looks) == len(set(looks)) == 12


def test_python_control(monkeypatch):
    system, rail, *_ = cart_pole(False)
    model = state_space(system, outputs=[measures.slide(rail)])
    monkeypatch.setitem(sys.modules, "control", None)
    with pytest.raises(InputError, match="python-control is not installed; pip install control, or use to_scipy"):
        model.to_control()
    monkeypatch.undo()
    control = pytest.importorskip("control")
    other = model.to_control()
    assert isinstance(other, control.StateSpace) and other.output_labels == ["slide of rail"]
    assert worst(other(1j * 5.0), model.frequency_response([5.0]).H[0, 0, 0]) < 1e-9


def test_what_is_refused():
    system, rail, pin, *_ = cart_pole(False)
    seen = [measures.slide(rail)]
    for given, match in (
        ({"inputs": ["pull"], "outputs": seen}, "'pull' is not an input of this system; there are 'push'"),
        ({"inputs": ["push", Input("push")], "outputs": seen}, "'push' is given twice"),
        ({"inputs": [], "outputs": seen}, "no input"),
        ({"outputs": []}, "no output"),
        ({"outputs": ["rail"]}, "'rail' is not an output; give a measure"),
        ({"outputs": [("effort", "rail")]}, "'rail' .* is not a driver"),
        ({"outputs": seen, "driver": "speed"}, "state_space: driver"),
    ):
        with pytest.raises(ValueError, match=match):
            state_space(system, **given)


def test_input_that_does_not_act_alike_is_refused():
    wheel = Body("wheel", 2.0, (0.2, 0.2, 0.3), omega=(0, 0, 5.0), velocity=(0, 0, 0))
    axle = Revolute(GROUND, wheel, at=(0, 0, 0), axis=(0, 0, 1), name="axle")
    system = System([wheel], [axle], [Force(wheel, (0, Input("push"), 0), at=(0.3, 0, 0))])
    with pytest.raises(InputError, match="input 'push' does not act in the same way"):
        state_space(system, outputs=[measures.rate(axle)])
    system = System([wheel], [axle], [Torque(wheel, (0, 0, Input("turn")))])
    with pytest.raises(InputError, match="output 'position of wheel' is not the same function"):
        state_space(system, outputs=[measures.position(wheel, axis=(1, 0, 0), at=(0.3, 0.1, 0))])


def tilt(angle):
    """Rotation matrix about y."""
    return np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])


def precessing_top(torque):
    """A top in steady precession under gravity, with a torque about the vertical."""
    lean, spin, m, l = 0.5, 180.0, 1.5, 0.2
    I1, I3 = 0.02, 0.01  # about the centre of mass
    A = I1 + m * l * l
    a, b, c = A * np.cos(lean), -I3 * spin, m * 9.81 * l  # (I3 w3) W - A W^2 cos - m g l = 0, w3 = spin of the axis
    slow = (-b - np.sqrt(b * b - 4.0 * a * c)) / (2.0 * a)
    axis = tilt(lean)[:, 2]
    # w = W z + (w3 - W cos) axis, w3 along the axis
    omega = slow * np.array([0, 0, 1.0]) + (spin - slow * np.cos(lean)) * axis
    top = Body("top", m, (I1, I1, I3), com=(0, 0, l), orientation=rotation("y", lean), omega=omega, velocity=(0, 0, 0))
    pivot = Spherical(GROUND, top, at=(0, 0, 0), name="pivot")
    return System([top], [pivot], [Torque(top, (0, 0, torque))]), top, pivot


def test_top_in_steady_precession():
    """About a motion that turns: the vertical torque changes the spin about z of the whole, d(L_z)/dt = u."""
    system, top, pivot = precessing_top(Input("u"))
    model = state_space(system, outputs=[("reaction", pivot), ("alpha", top)])
    assert model.linearization.generator.turning
    assert linearize(system).eigenvalues.shape == model.poles.shape
    inertia = tilt(0.5) @ np.diag([0.02 + 1.5 * 0.04, 0.02 + 1.5 * 0.04, 0.01]) @ tilt(0.5).T
    alpha = np.linalg.solve(inertia, [0, 0, 1.0])
    assert worst(model.D[-3:, 0], alpha) < 1e-12
    centre = tilt(0.5) @ np.array([0, 0, 0.2])
    assert worst(model.D[:3, 0], 1.5 * np.cross(alpha, centre)) < 1e-12


def mounted_pendulum():
    """A pendulum on a cart, a bushing between the bob and the ground, off all centres and axes."""
    cart = Body("cart", 2.0, (1, 1, 1))
    bob = Body("bob", 1.0, (0.1, 0.2, 0.3), position=(0.1, 0.2, -0.5), com=(0.02, 0.03, 0.01))
    rail = Prismatic(GROUND, cart, at=(0, 0, 0), axis=(1, 0, 0), name="rail")
    pin = Revolute(cart, bob, at=(0, 0, 0), axis=(0, 1, 0), name="pin")
    turn = rotation((0.3, -1.0, 0.7), 0.9)
    forces = [
        SpringDamper(cart, GROUND, at_a=(0, 0, 0), at_b=(-1, 0, 0), stiffness=50.0, damping=4.0, name="spring"),
        Force(cart, (2.0 * Input("push"), 0, 0), name="shaker"),
        TorsionSpring(pin, stiffness=3.0, damping=0.2, name="coil"),
        Bushing(GROUND, bob, at=(0.3, 0.1, -0.6), stiffness=(100, 200, 300), turning_stiffness=(5, 6, 7), damping=3.0,
                turning_damping=0.4, axes=turn, name="mount"),
    ]  # fmt: skip
    return System([cart, bob], [rail, pin], forces), cart, bob, rail, pin


def test_forces_of_elements_are_outputs():
    """Laws of spring and coil, Newton and Euler of cart and bob with all forces that act on them."""
    system, cart, bob, rail, pin = mounted_pendulum()
    rest = system.equilibrium().state
    parts = ["spring", "shaker", "coil", "mount"]
    outputs = [measures.slide(rail), measures.angle(pin), ("acceleration", cart), ("acceleration", bob), ("alpha", bob),
               ("reaction", pin), *(("force", name) for name in parts)]  # fmt: skip
    model = state_space(system, rest, outputs=outputs)
    w = np.array(W)
    H = dict(zip(model.outputs, model.frequency_response(w).H[:, :, 0].T, strict=True))

    def vector(name, part):
        return np.array([H[f"{name} {axis} of {part}"] for axis in "xyz"])

    slide, angle = H["slide of rail"], H["angle of pin"]
    assert worst(vector("force", "spring")[0], -(50.0 + 4.0j * w) * slide) < EXACT  # on the cart: its last body
    assert worst(vector("moment", "coil")[1], -(3.0 + 0.2j * w) * angle) < EXACT
    assert worst(vector("force", "shaker")[0], np.full(3, 2.0)) < EXACT
    on_cart = vector("force", "spring") + vector("force", "shaker") - vector("force", "pin")
    assert worst(on_cart[0], 2.0 * vector("acceleration", "cart")[0]) < EXACT
    start = accelerations(system, rest)
    R, centre = start.rotation(bob)[0], start.com(bob)[0]
    s = R @ bob.com
    on_bob = vector("force", "pin") + vector("force", "mount")
    pull = vector("acceleration", "bob") - np.cross(s, vector("alpha", "bob"), axisb=0, axisc=0)
    assert worst(on_bob, pull) < EXACT
    turning, turn = np.zeros((3, 3), complex), np.outer((0, 1, 0), angle)
    # small turns move the arms of the forces at rest
    for name, load in (("pin", start.reaction(pin)), ("mount", start.force("mount"))):
        arm = load.point[0] - centre
        turning += vector("moment", name) + np.cross(arm, vector("force", name), axisb=0, axisc=0)
        turning += np.cross(np.cross(turn, arm, axisa=0, axisc=0), load.force[0], axisa=0, axisc=0)
    turning += vector("moment", "coil")
    assert worst(turning, R @ bob.inertia @ R.T @ vector("alpha", "bob")) < EXACT
    assert model.output_units[-3:] == ("N m",) * 3
    with pytest.raises(ValueError, match="'rubber' is not one of the forces"):
        state_space(system, rest, outputs=[("force", "rubber")])
    with pytest.raises(ValueError, match="'pin' is not one of the forces"):
        state_space(system, rest, outputs=[("force", pin)])


SHAKEN = 0.004  # [1] of the natural size; what is left is of its square


SETTLED = 50.0  # [s] the slowest mode has decayed to 1e-9 by then


@pytest.mark.parametrize("w", [0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 10.0, 15.0])
def test_shaken_pendulum_follows_the_response(w):
    """A run of the whole equations with a small sine about a damped pole, against |H| and phase."""
    cart, pole = Body("cart", 1.0, (0.1, 0.1, 0.1)), Body("pole", 0.3, (0.006, 0.006, 0.001), com=(0, 0, -0.3))
    rail = Prismatic(GROUND, cart, at=(0, 0, 0), axis=(1, 0, 0), name="rail")
    pin = Revolute(cart, pole, at=(0, 0, 0), axis=(0, 1, 0), name="pin")
    forces = [TorsionSpring(pin, stiffness=0.0, damping=0.03),
              SpringDamper(GROUND, cart, at_a=(-1, 0, 0), at_b=(0, 0, 0), stiffness=20.0, damping=6.0)]  # fmt: skip

    def shaken(signal):
        return System([cart, pole], [rail, pin], [*forces, Force(cart, (signal, 0, 0))])

    outputs = [measures.slide(rail), measures.angle(pin), ("reaction", pin)]
    H = state_space(shaken(Input("u")), outputs=outputs).frequency_response([w]).H[0, :, 0]
    period, force = 2.0 * np.pi / w, SHAKEN
    settled = period * np.ceil(SETTLED / period)
    times = settled + np.linspace(0.0, period, 257)[:-1]
    run = simulate(shaken(Sine(amplitude=force, frequency=w / (2.0 * np.pi))), times[-1], rtol=1e-11, output=times)
    seen = np.column_stack([run.measure(outputs[:2]), run.reaction(pin).force[:, :1]])
    found = 2j * (seen * np.exp(-1j * w * times)[:, None]).mean(axis=0) / force  # of A sin(w t + phase)
    assert np.abs(found / H[[0, 1, 2]] - 1.0).max() < 1e-6  # amplitude^2 of the pendulum


@pytest.mark.slow
def test_shaken_top_in_steady_precession():
    """The whole equations from the same start with a small vertical torque, against the step of the linear model."""
    system, top, pivot = precessing_top(Input("u"))
    lean = measures.lean(top, lateral=tilt(0.5)[:, 2])
    model = state_space(system, outputs=[lean, ("derivative", lean)])
    times = np.linspace(0.0, 0.3, 61)
    torque = 1e-5

    def run(signal):
        pushed, top, _ = precessing_top(signal)
        return simulate(pushed, 0.3, rtol=1e-12, output=times).measure(measures.lean(top, lateral=tilt(0.5)[:, 2]))

    assert worst((run(torque) - run(0.0)) / torque, model.step(times)[:, 0, 0]) < 1e-4  # torque^2 and 1e-12 / torque


def test_units_of_loads_between_bodies():
    cart, arm = Body("cart", 1.0, (0.1, 0.1, 0.1)), Body("arm", 0.5, (0.1, 0.1, 0.1), com=(0.3, 0, -0.2))
    rail = Prismatic(GROUND, cart, at=(0, 0, 0), axis=(1, 0, 0), name="rail")
    pin = Revolute(cart, arm, at=(0, 0, 0), axis=(0, 1, 0), name="pin")
    loads = [
        ForceBetween(GROUND, cart, (Input("push"), 0, 0)),
        TorqueBetween(cart, arm, (0, Input("motor"), 0)),
        LinearActuator(GROUND, cart, at_a=(-1, 0, 0), at_b=(0, 0, 0), thrust=Input("ram"), stroke=(0.5, 2),
                       stiffness=1e4),
    ]  # fmt: skip
    system = System(
        [cart, arm],
        [rail, pin],
        [*loads, SpringDamper(GROUND, arm, at_a=(0, 0, 1), at_b=(0.3, 0, -0.2), stiffness=20.0)],
    )
    model = state_space(system, system.equilibrium().state, outputs=[("derivative", measures.slide_rate(rail))])
    assert dict(zip(model.inputs, model.input_units, strict=True)) == {"push": "N", "motor": "N m", "ram": "N"}
    assert model.D[0, 0] == pytest.approx(model.D[0, 2], rel=1e-12)  # both push the cart along its rail
