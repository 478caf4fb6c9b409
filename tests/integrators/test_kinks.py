"""Steps over a kink of a rate, as contacts make it when they open: the estimated error must see it wherever it lies."""

import numpy as np
import pytest
from helpers.models import dropped_wheel
from scipy.integrate import DOP853 as SCIPY

from mbsd3d import DOP853, GROUND, Body, Contact, RadauIIA, System, measures, shapes, simulate
from mbsd3d.integrators.dop853 import TABLE

PLACES = np.linspace(0.0, 1.0, 4001)  # of the kink in the step
c, (FIRST, SECOND, THIRD) = TABLE.c, TABLE.error


def of_kink(weights):
    """What a sum of rates makes of the rate max(t - place, 0)."""
    return weights @ np.maximum(c[:, None] - PLACES, 0.0)


def estimated(*fifth):
    """Largest estimate of fifth order, corrected by that of third order as in the time loop."""
    e5 = np.max([np.abs(of_kink(weights)) for weights in fifth], axis=0)
    return e5**2 / np.sqrt(e5**2 + 0.01 * of_kink(THIRD) ** 2 + 1e-300)


def test_both_estimates_are_of_fifth_order_with_the_same_leading_term():
    for power in range(5):
        assert abs(SECOND @ c**power) < 1e-15
    assert SECOND @ c**5 == pytest.approx(FIRST @ c**5, rel=1e-12)
    assert np.abs(SECOND).max() < np.abs(FIRST).max()  # rounding of rates counts no more than before


def test_a_kink_is_seen_wherever_it_lies():
    error = np.abs(of_kink(TABLE.b) - 0.5 * (1.0 - PLACES) ** 2)
    missed = error > 30.0 * estimated(FIRST, SECOND)
    alone = error > 30.0 * estimated(FIRST)
    assert not missed[PLACES < 0.999].any()
    assert alone.mean() > 0.02  # one estimate alone is blind there


@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-10, 1e-12])
def test_a_bouncing_wheel_passes_from_any_height(rtol):
    """A tyre with a damper leaves the road before it is round again: its power has a kink at each end of that."""
    rng = np.random.default_rng(8)
    for _ in range(25):
        _, system = dropped_wheel(rng)
        run = simulate(system, 1.2, rtol=rtol, output=61)
        assert run.certificate.passed, f"{system.name}\n{run.certificate}"


@pytest.mark.parametrize(
    ("method", "rtol", "t_end"), [(DOP853(), 1e-12, 1.0), (DOP853(), 1e-9, 1e5), (RadauIIA(), 1e-9, 1e5)], ids=str
)
def test_the_shortest_step_takes_a_jump_of_a_force(method, rtol, t_end):
    """A damped contact pushes at once when a ball touches: at rtol 1e-12, or in a run of a day, no step resolves that.

    The depth at rest between falling and rising is that of d_ddot + 2 a d_dot + w^2 d = g from d = 0.
    """
    r, m, w, damping, fall = 0.05, 0.3, 3e3, 0.1, 0.04
    a, g = damping * w, 9.81
    ball = Body("ball", m, (1e-4, 1.2e-4, 1.3e-4), position=(0.3, -0.2, r + fall), velocity=(0, 0, 0), omega=(0, 0, 0))
    floor = Contact(GROUND, ball, shapes.Sphere(r), stiffness=m * w**2, damping=2 * m * a)
    lowest = measures.velocity(ball, axis=(0, 0, 1)) > 0.0
    run = simulate(System([ball], forces=[floor]), t_end, method=method, rtol=rtol, output=2, stop_when=lowest)
    speed, turn = np.sqrt(2 * g * fall), np.sqrt(w**2 - a**2)
    A, B = -g / w**2, (speed - a * g / w**2) / turn
    rest = np.arctan2(turn * B - a * A, a * B + turn * A) / turn  # d_dot = 0
    depth = g / w**2 + np.exp(-a * rest) * (A * np.cos(turn * rest) + B * np.sin(turn * rest))
    # a step of 1e-14 t_end misses as much of the blow 2 a speed, and its depth by 1/w of that
    blow = 1e-14 * t_end * 2 * a * speed / w
    assert r - run.position(ball)[-1, 2] == pytest.approx(depth, rel=0, abs=10 * blow + 1e3 * rtol * r)
    assert run.certificate.passed, run.certificate


def test_the_coefficients_of_dop853_are_those_of_scipy():
    stages = SCIPY.n_stages
    pairs = (
        (TABLE.A, SCIPY.A[:stages, :stages]), (TABLE.b, SCIPY.B), (TABLE.c, SCIPY.C[:stages]), (TABLE.D, SCIPY.D),
        (TABLE.A_dense, SCIPY.A_EXTRA), (TABLE.c_dense, SCIPY.C_EXTRA), (TABLE.error[0], SCIPY.E5[:stages]),
        (TABLE.error[2], SCIPY.E3[:stages]),
    )  # fmt: skip
    for own, theirs in pairs:
        assert own.shape == theirs.shape and (own == theirs).all()
