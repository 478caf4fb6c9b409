"""Touches far shorter than a step: none is passed over, whatever hides it, and flights cost no more steps."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from mbsd3d import (
    DOP853,
    GROUND,
    RK4,
    Body,
    Contact,
    GeneralizedAlpha,
    RadauIIA,
    Revolute,
    System,
    shapes,
    simulate,
)

TILT = Rotation.from_rotvec((0.4, -0.3, 0.7)).as_matrix()
BALL, STIFFNESS, LOSS = 0.05, 5e7, 2.0


def hammer(phase, rate, reach, depth, balanced):
    """A ball at the end of an arm sweeps over a plate, ``depth`` too near; balanced, its arm is a round flywheel."""
    turn = TILT @ Rotation.from_rotvec((0, -phase, 0)).as_matrix()
    inertia, com = ((0.3, 0.5, 0.3), (0, 0, 0)) if balanced else ((0.2, 0.5, 0.4), (0.02, 0.01, -0.4 * reach))
    arm = Body("arm", 1.7, inertia, com=com, orientation=turn, omega=-rate * TILT[:, 1])
    hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=TILT[:, 1])
    plate = TILT @ (0.2, -0.1, depth - reach - BALL), TILT[:, 2]
    ball = shapes.Sphere(BALL, at=(0, 0, -reach))
    contact = Contact(GROUND, arm, ball, stiffness=STIFFNESS, loss=LOSS, plane=plate)
    return System([arm], [hinge], [contact], gravity=(0, 0, 0)), arm


def swept(phase, rate, reach, depth, balanced, t_end):
    """Speed at the end by its own equation, I phi_ddot = -N reach sin(phi), in steps far shorter than a touch."""
    moment = 0.5 if balanced else 0.5 + 1.7 * (0.02**2 + (0.4 * reach) ** 2)

    def rates(_, y):
        phi, speed = y
        inside = depth - reach * (1.0 - np.cos(phi))
        closing = -reach * np.sin(phi) * speed
        normal = max(STIFFNESS * inside * (1.0 + LOSS * closing), 0.0) if inside > 0.0 else 0.0
        return speed, normal * reach * np.sin(phi) / moment

    shortest = np.sqrt(2.0 * depth / reach) / abs(rate)
    return solve_ivp(rates, (0.0, t_end), (phase, rate), rtol=1e-10, atol=1e-12, max_step=0.2 * shortest).y[1, -1]


@pytest.mark.parametrize("balanced", [True, False])
@pytest.mark.parametrize("method", [DOP853(), RadauIIA(), GeneralizedAlpha()], ids=lambda method: type(method).__name__)
def test_a_touch_that_a_step_passes_over_is_not_lost(method, balanced):
    """Of arms that sweep by once most steps had none of the touch; of flywheels, whose turning costs no steps, all."""
    rng = np.random.default_rng(5)
    for _ in range(6):
        given = rng.uniform(-2.5, -0.6), rng.uniform(8.0, 12.0), rng.uniform(0.4, 1.0), 10 ** rng.uniform(-4, -3)
        system, arm = hammer(*given, balanced)
        run = simulate(system, 0.5, method=method, rtol=1e-7, output=2)
        speed, theory = -run.omega(arm)[-1] @ TILT[:, 1], swept(*given, balanced, 0.5)
        assert given[1] - theory > 1e-4 * given[1]  # it does touch
        # rtol of the motion, grown by what a touch a thousandth of a radian earlier or later changes
        assert speed == pytest.approx(theory, rel=1e-4) and run.certificate.passed


def test_blows_of_every_turn_are_felt():
    """A fast flywheel would pass over six turns in a step."""
    given = -1.3, 40.0, 0.5, 1e-3
    system, arm = hammer(*given, balanced=True)
    run = simulate(system, 0.5, output=2)
    assert -run.omega(arm)[-1] @ TILT[:, 1] == pytest.approx(swept(*given, True, 0.5), rel=1e-6)


def test_a_spinning_ball_flies_in_few_steps():
    """What looks the same all the time may turn: 100 rad in flight."""
    ball = Body("ball", 0.4, (1e-3,) * 3, position=(0, 0, 1.0), velocity=(1.0, 0, 6.0), omega=(50.0, 70.0, -50.0))
    floor = Contact(GROUND, ball, shapes.Sphere(0.1), stiffness=1e5)
    flight = simulate(System([ball], [], [floor]), 1.0, output=2)
    alone = simulate(System([ball]), 1.0, output=2)
    assert flight.certificate.steps <= alone.certificate.steps + 2


@pytest.mark.parametrize(
    ("method", "off"), [(RK4(dt=0.0043), 7e-5), (DOP853(dt=0.0043), 2e-7), (DOP853(dt=0.02), 1e-5)]
)
def test_fixed_steps_are_split_where_a_damped_contact_lets_go(method, off):
    """It presses with k d + c d_dot until that vanishes, while the ball is still below the plane: m = 0.2, 3 m/s."""
    k, c, normal = 500.0, 4.0, TILT[:, 2]
    ball = Body("ball", 0.2, (1e-3, 2e-3, 2.5e-3), position=(0.3 + BALL) * normal, velocity=-3.0 * normal)
    floor = Contact(GROUND, ball, shapes.Sphere(BALL), stiffness=k, damping=c, plane=((0, 0, 0), normal))

    def lets_go(_, y):
        return k * y[0] + c * y[1]

    lets_go.terminal, lets_go.direction = True, -1
    own = solve_ivp(
        lambda t, y: (y[1], -lets_go(t, y) / 0.2), (0, 1), (0.0, 3.0), events=lets_go, rtol=1e-11, atol=1e-13
    )
    run = simulate(System([ball], forces=[floor], gravity=(0, 0, 0)), 0.6, method=method)
    assert run.certificate.passed
    assert run.velocity("ball")[-1] @ normal == pytest.approx(-own.y[1, -1], rel=off)  # of the order of the method
