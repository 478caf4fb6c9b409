"""Poses at rest against potential energies minimised by scipy, closed forms, and long damped runs."""

import numpy as np
import pytest
from helpers.models import direction, middle, random_body
from scipy.optimize import brentq, minimize

from mbsd3d import (
    GROUND,
    AngleDriver,
    AssemblyError,
    Body,
    Bushing,
    Contact,
    CustomForce,
    EquilibriumError,
    Fixed,
    Force,
    KnifeEdge,
    Planar,
    Polynomial,
    Prismatic,
    Revolute,
    RollingDisc,
    Sine,
    SpeedDriver,
    Spherical,
    SpringDamper,
    StateFeedback,
    System,
    Torque,
    TorsionSpring,
    accelerations,
    measures,
    rotation,
    shapes,
    simulate,
)
from mbsd3d.mechanism.forces.custom import SavedForce
from mbsd3d.rotations import matrix

G = 9.81


def pendulum(*forces, angle=0.0):
    arm = Body("arm", mass=2.0, inertia=(0.1, 0.5, 0.5), com=(0.5, 0, 0))
    hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=(0, 1, 0), name="hinge")
    return System([arm], [hinge], [make(hinge) for make in forces]), hinge


def test_an_arm_on_a_torsion_spring():
    system, hinge = pendulum(lambda x: TorsionSpring(x, stiffness=40.0, damping=0.3))
    rest = system.equilibrium()
    x = brentq(lambda x: 40.0 * x - 2.0 * G * 0.5 * np.cos(x), 0.0, 1.0)
    assert rest.state.coordinates[0] == pytest.approx(x, abs=1e-13)
    assert rest.stability == "stable" and rest.residual < 1e-13
    stiffness, inertia = 40.0 + 2.0 * G * 0.5 * np.sin(x), 0.5 + 2.0 * 0.25
    roots = np.roots([inertia, 0.3, stiffness])
    assert f"{-roots.real.max():.4g} 1/s" in rest.reason
    assert np.abs(accelerations(system, rest.state).alpha("arm")).max() < 1e-12
    assert simulate(system, 1.0, state=rest.state, output=3).angle(hinge) == pytest.approx(x, abs=1e-10)


@pytest.mark.parametrize("start", [0.3, -1.57, 3.0, -np.pi / 2 + 1e-6])
def test_a_pendulum_comes_down_from_anywhere(start):
    system, hinge = pendulum()
    rest = system.equilibrium(system.assemble(angles={hinge: start}))
    assert rest.state.coordinates[0] == pytest.approx(np.pi / 2, abs=1e-12)
    assert rest.stability == "stable, undamped" and "0.4985 Hz" in rest.reason  # sqrt(m g l / I) / 2 pi


@pytest.mark.parametrize("damping", [2.0, 400.0])
def test_what_dies_out_beside_a_swing_is_not_the_swing(damping):
    """Slower than the pendulum, in 2.4 s to and fro or not at all."""
    swing, _ = pendulum()
    cart = Body("cart", 1.5, (0.1, 0.1, 0.2), position=(2.0, 1.0, 0.5))
    rail = Prismatic(GROUND, cart, at=(2.0, 1.0, 0.5), axis=(1, 2, 0))
    ends = {"at_a": (1.0, -1.0, 0.5), "at_b": (2.0, 1.0, 0.5)}
    spring = SpringDamper(GROUND, cart, **ends, stiffness=10.0, damping=damping)
    rest = System([*swing.bodies, cart], [*swing.joints, rail], [spring]).equilibrium()
    assert rest.stability == "stable, undamped" and "0.4985 Hz" in rest.reason


def test_a_start_that_is_an_equilibrium_stays_one():
    system, hinge = pendulum()
    rest = system.equilibrium(system.assemble(angles={hinge: -np.pi / 2}))
    assert rest.steps == 0 and rest.stability == "unstable"
    assert rest.reason == f"angle of 'hinge' grows with {np.sqrt(2.0 * G * 0.5):.4g} 1/s"
    assert max(rest.moved["arm"]) < 1e-15


def test_preloaded_springs_on_a_double_pendulum():
    """Against the least potential energy of the two angles; springs are long before they carry anything."""
    L, m = (0.7, 0.5), (1.3, 0.8)
    bodies = [
        Body("upper", m[0], (0.01, 0.05, 0.05), com=(L[0] / 2, 0, 0)),
        Body("lower", m[1], (0.01, 0.04, 0.04), com=(L[1] / 2, 0, 0), position=(L[0], 0, 0)),
    ]
    joints = [
        Revolute(GROUND, bodies[0], at=(0, 0, 0), axis=(0, 1, 0), name="top"),
        Revolute(*bodies, at=(L[0], 0, 0), axis=(0, 1, 0), name="knee"),
    ]
    anchor, k, free = np.array([0.9, 0.0, 0.8]), 30.0, 0.6
    spring = SpringDamper(
        GROUND, bodies[1], at_a=anchor, at_b=(L[0] + L[1], 0, 0), stiffness=k, damping=1.0, length=free
    )
    system = System(bodies, joints, [spring])

    def energy(angles):
        a, b = angles[0], angles[0] + angles[1]
        knee = L[0] * np.array([np.cos(a), 0, -np.sin(a)])
        tip = knee + L[1] * np.array([np.cos(b), 0, -np.sin(b)])
        stretch = np.linalg.norm(tip - anchor) - free
        return G * (m[0] * knee[2] / 2 + m[1] * (knee[2] + tip[2]) / 2) + 0.5 * k * stretch**2

    rest = system.equilibrium()
    found = minimize(energy, rest.state.coordinates[:2] + 0.05, method="BFGS", options={"gtol": 1e-10})
    assert rest.state.coordinates[:2] == pytest.approx(found.x, abs=1e-6)  # of BFGS: sqrt of rounding
    assert rest.stability.startswith("stable")


def test_a_spatial_mechanism_comes_to_rest_where_a_long_run_does():
    rng = np.random.default_rng(2)
    a, b, c = bodies = [random_body(rng, x) for x in "abc"]
    joints = [
        Spherical(a, b, at=middle(rng, a, b)),
        Revolute(b, c, at=middle(rng, b, c), axis=direction(rng)),
    ]
    forces = [
        Bushing(GROUND, x, at=x.position + 0.3 * direction(rng), stiffness=rng.uniform(5, 200, 3),
                turning_stiffness=rng.uniform(1, 20, 3), damping=rng.uniform(3, 9, 3), turning_damping=2.0)
        for x in bodies
    ]  # fmt: skip
    system = System(bodies, joints, forces, gravity=(0.5, -1.0, -9.0))
    rest = system.equilibrium()
    assert rest.stability == "stable"
    end = simulate(system, 60.0, rtol=1e-9, output=2).final
    q, found = end.q.reshape(-1, 7), rest.state.q.reshape(-1, 7)
    assert q[:, :3] == pytest.approx(found[:, :3], abs=1e-7)
    assert np.abs(np.sum(q[:, 3:] * found[:, 3:], axis=1)) == pytest.approx(1.0, abs=1e-12)


def integral(t, bodies, z, parameters, loads, z_dot):
    """A controller that turns the arm until its height is what it should be."""
    z_dot[0] = bodies[0].r[2] - parameters[0]
    loads[0, 4] = 40.0 * z[0] + 60.0 * (bodies[0].r[2] - parameters[0]) - 4.0 * bodies[0].velocity[2]


def test_own_states_come_to_rest_too():
    def servo(hinge):
        seen = [measures.angle(hinge)]
        return StateFeedback(measures=seen, gains=[50.0], on=hinge, reference=[-0.2], time_constant=0.1, name="servo")

    system, hinge = pendulum(servo, lambda x: TorsionSpring(x, stiffness=0.0, damping=2.0))
    rest = system.equilibrium()
    x = brentq(lambda x: -50.0 * (x + 0.2) + 2.0 * G * 0.5 * np.cos(x), -1.0, 1.0)
    assert rest.state.z == pytest.approx([x], abs=1e-12) and rest.state.coordinates[0] == pytest.approx(x, abs=1e-12)
    arm = Body("arm", mass=2.0, inertia=(0.1, 0.5, 0.5), com=(0.5, 0, 0))
    hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=(0, 1, 0))
    hold = CustomForce(integral, on=arm, points=[(1.0, 0, 0)], parameters=[0.25], states={"sum": 0.0})
    rest = System([arm], [hinge], [hold]).equilibrium()
    assert -np.sin(rest.state.coordinates[0]) == pytest.approx(0.25, abs=1e-12)  # height of the point at 1 m
    assert rest.state.z[0] == pytest.approx(-2.0 * G * 0.5 * np.cos(rest.state.coordinates[0]) / 40.0, abs=1e-12)


def test_nonholonomic_rows_say_where_it_may_go():
    """A sled on a slope, heading along a blade, on a spring: only the pull along the blade counts."""
    ahead = np.array([0.8, 0.6, 0.0])
    sled = Body("sled", 3.0, (0.1, 0.2, 0.2), com=(0.0, 0.0, 0.0))
    slope = Planar(GROUND, sled, at=(0, 0, 0), normal=(0, 0, 1))
    blade = KnifeEdge(GROUND, sled, at=(0, 0, 0), lateral=np.cross((0, 0, 1), ahead))
    pull = Bushing(GROUND, sled, at=(0, 0, 0), stiffness=20.0, turning_stiffness=1e3, damping=3.0, turning_damping=9.0)
    system = System([sled], [slope, blade], [pull], gravity=(1.0, -0.3, -9.7))
    rest = system.equilibrium()
    along = 3.0 * np.dot((1.0, -0.3, -9.7), ahead) / 20.0
    assert rest.state.q[:3] == pytest.approx(along * ahead, abs=1e-9)


def test_a_weighted_disc_rolls_until_its_weight_is_low():
    disc = Body("disc", 1.0, (0.02, 0.04, 0.02), com=(0.06, 0, 0), position=(0, 0, 0.3))
    roll = RollingDisc(GROUND, disc, axis=(0, 1, 0), radius=0.3, centre=(0, 0, 0.3))
    upright = Bushing(GROUND, disc, at=(0, 0, 0.3), stiffness=(0, 50, 0), turning_stiffness=0.0)
    start = System([disc], [roll], [upright]).equilibrium().state
    turned = start.q[3:7]
    assert abs(turned @ rotation("y", 90, degrees=True)) == pytest.approx(1.0, abs=1e-9)
    # the path is followed in steps of at most 0.2 rad, each straight for the centre of mass, which is 0.06 m off
    assert start.q[0] == pytest.approx(0.3 * np.pi / 2, abs=0.06 * 0.2)


def test_neutral_and_held():
    rng = np.random.default_rng(1)
    stone = random_body(rng, "stone")
    adrift = System([stone], gravity=(0, 0, 0)).equilibrium()
    assert adrift.stability == "neutral" and adrift.reason == "12 eigenvalues are zero"
    held = System([stone], [Fixed(GROUND, stone, at=(0, 0, 0))]).equilibrium()
    assert held.stability == "held" and held.linearization is None
    said = "<equilibrium: held (joints and drivers leave no degree of freedom); nothing moved; residual "
    assert repr(held).startswith(said)
    turned = AngleDriver(Revolute(GROUND, stone, at=(0, 0, 1), axis=(0, 1, 0)), 0.0)
    assert System([stone], [turned.hinge, turned]).equilibrium().stability == "held"


@pytest.mark.parametrize("law", [{}, {"creep": 1e-3}, {"rolling": 0.01, "spinning": 0.02}])
@pytest.mark.parametrize("gap", [1e-3, 0.37])
def test_what_rubs_comes_down_onto_the_floor(law, gap):
    """In the air nothing but the weight acts, while friction has rates of its own: k d^1.5 = m g in the end."""
    ball = Body("ball", 2.0, (0.01, 0.02, 0.025), com=(0.02, 0.01, -0.03), position=(0.1, 0.2, 0.2 + gap))
    form = shapes.Sphere(0.2, at=ball.com)
    floor = Contact(GROUND, ball, form, stiffness=3e5, exponent=1.5, damping=300.0, friction=0.6, **law)
    rest = System([ball], forces=[floor]).equilibrium()
    depth = 0.2 - (rest.state.q[2] + (matrix(rest.state.q[3:]) @ ball.com)[2])
    assert depth == pytest.approx((2.0 * 9.81 / 3e5) ** (2.0 / 3.0), rel=1e-8)


def test_failures_are_named():
    rng = np.random.default_rng(1)
    stone = random_body(rng, "stone")
    with pytest.raises(EquilibriumError, match=r"body 'stone' still accelerates by 9.81 m/s\^2.*; hold the mechanism"):
        System([stone]).equilibrium()
    with pytest.raises(ValueError, match="equilibrium: the signal of 'push' varies with time; give a constant"):
        System([stone], forces=[Force(stone, (Sine(1.0, 2.0), 0, 0), name="push")]).equilibrium()
    rail = Prismatic(GROUND, stone, at=stone.position, axis=(1, 0, 0), name="rail")
    hinge = Revolute(GROUND, stone, at=stone.position, axis=(1, 0, 0), name="hinge")
    with pytest.raises(ValueError, match="the signal of 'motor' varies with time"):
        System([stone], [hinge, AngleDriver(hinge, Polynomial((0.0, 1.0)), name="motor")]).equilibrium()
    system = System([stone], [rail])
    astray = system.state()
    astray.q[1] += 0.01
    with pytest.raises(AssemblyError, match="equilibrium: the start does not meet the joints.*'rail'.*assemble"):
        system.equilibrium(astray)
    with pytest.raises(ValueError, match="equilibrium: state 3 is not a State"):
        system.equilibrium(3)


def test_a_speed_driver_has_no_rest():
    disc = Body("disc", 1.0, (0.1, 0.1, 0.2))
    hinge = Revolute(GROUND, disc, at=(0, 0, 0), axis=(0, 0, 1))
    motor = SpeedDriver(GROUND, disc, axis=(0, 0, 1), speed=3.0, name="motor")
    with pytest.raises(AssemblyError, match="a driver keeps the mechanism moving, so it has no rest.*'motor'"):
        System([disc], [hinge, motor]).equilibrium()


def test_a_force_that_lost_its_function_is_named():
    arm = pendulum()[0].bodies[0]
    with pytest.raises(ValueError, match="force 'lost': its function was not saved"):
        System([arm], forces=[SavedForce(on=(arm,), name="lost")]).equilibrium()


@pytest.mark.parametrize("size", [0.01, 1.0, 100.0])
def test_what_leaves_is_named_and_not_what_spins_on_it(size):
    """A pushed trolley: its wheel of a tenth of the size turns faster, in rad/s^2, than the trolley is accelerated."""
    trolley = Body("trolley", 40.0, size**2 * np.array([3.0, 4.0, 5.0]), position=size * np.array([0.3, 0.1, 0.4]))
    at = size * np.array([0.8, 0.2, 0.1])
    wheel = Body("wheel", 1.0, size**2 * np.array([2e-3, 4e-3, 2e-3]), position=at)
    rail = Prismatic(GROUND, trolley, at=trolley.position, axis=(1, 0, 0), name="rail")
    axle = Revolute(trolley, wheel, at=at, axis=(0, 1, 0), name="axle")
    turn = RollingDisc(GROUND, wheel, axis=(0, 1, 0), radius=0.1 * size, name="tread")
    system = System([wheel, trolley], [rail, axle, turn], [Force(trolley, (30.0, 0, 0))])
    with pytest.raises(EquilibriumError, match=r"body 'trolley' still accelerates by 0.7.* m/s"):
        system.equilibrium()


def test_what_falls_is_named_and_not_what_swings_beside_it():
    """A fan turns at hundreds of rad/s^2, a stone falls at g."""
    stone = Body("stone", 5.0, (0.03, 0.04, 0.05), position=(0.3, 0.2, 5.0), com=(0.1, 0.0, 0.2))
    fan = Body("fan", 0.1, (1e-5, 2e-5, 1e-5), position=(1, 1, 0))
    hinge = Revolute(GROUND, fan, at=(1, 1, 0), axis=(0, 1, 0), name="hinge")
    system = System([fan, stone], [hinge], [Torque(fan, (0, 6e-3, 0))])
    with pytest.raises(EquilibriumError, match=r"body 'stone' still accelerates by 9.81 m/s"):
        system.equilibrium()
