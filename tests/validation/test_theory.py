"""The closed forms against the reference files, against each other and against independent arithmetic."""

import json
from decimal import Decimal, localcontext
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from helpers.closed_forms import cardan as shafts
from helpers.closed_forms import rotations
from helpers.closed_forms import slider_crank as crank_theory

from validation import theory

REFERENCES = Path(__file__).parents[2] / "validation" / "references"


def read(name):
    return json.loads((REFERENCES / f"{name}.json").read_text(encoding="utf-8"))


def columns(name, *labels):
    """Times (n,) and reference columns (n, k) of a case."""
    rows = read(name)["reference"]["values"]
    return np.array([row["t"] for row in rows]), np.array([[row[label] for label in labels] for row in rows])


def same_rotation(rotation, quaternions):
    """Greatest difference between rotations and reference quaternions up to sign."""
    mine = rotations.quaternion(rotation).astype(float)
    signs = np.sign(np.sum(mine * quaternions, axis=1))[:, None]
    return np.abs(signs * mine - quaternions).max()


def test_taylor_series_of_the_fast_top_equal_the_reference():
    t, q = columns("heavy_top_fast", "q_w", "q_x", "q_y", "q_z")
    w = columns("heavy_top_fast", "w_x", "w_y", "w_z")[1]
    com = columns("heavy_top_fast", "com_x", "com_y", "com_z")[1]
    motion = theory.spinning_body(
        t, (15.234375, 0.46875, 15.234375), (0, 150, -4.61538), weight_moment=(0, 15 * 9.81, 0)
    )
    # both are 80-bit series, the file rounds to double: 1e-13 leaves room for machines with 64-bit long doubles
    assert np.abs(motion.omega_body - w).max() < 1e-13 * 150
    assert same_rotation(motion.rotation, q) < 1e-13
    assert np.abs(motion.rotation[:, :, 1] - com).max() < 1e-13


def test_taylor_series_do_not_depend_on_body_axes():
    inertia, omega, moment = np.diag([0.7, 0.4, 0.9]), np.array([1.1, -2.0, 0.6]), np.array([0.3, -0.2, 0.8])
    turn = theory.rotation_matrix((0.3, -0.5, 0.2, 0.9)).astype(float)
    plain = theory.spinning_body([0.7, 1.9], inertia, omega, weight_moment=moment)
    turned = theory.spinning_body(
        [0.7, 1.9], turn.T @ inertia @ turn, turn.T @ omega, rotations.quaternion(turn), weight_moment=turn.T @ moment
    )
    # body axes turned by R_0 from the same start: R = R_plain R_0; double-precision inputs
    assert np.abs(turned.rotation - plain.rotation @ turn).max() < 1e-13


def test_nutation_of_the_fast_top():
    t, z = columns("heavy_top_fast", "com_z")
    closed = read("heavy_top_fast")["reference"]["closed_form"]
    motion = rotations.nutation(15.234375, 0.46875, 150.0, 15 * 9.81, np.pi / 2, 0.0, -4.61538)
    assert np.abs(motion.height(t) - z[:, 0]).max() < 1e-14
    assert [motion.lowest, motion.highest, motion.third] == pytest.approx(
        [closed["u1"], closed["u2"], closed["u3"]], abs=1e-14
    )
    assert motion.rate == pytest.approx(closed["nu"], rel=1e-14)
    # the file gives the time from the highest to the lowest point, half a period
    assert motion.period == pytest.approx(2 * closed["nutation_period"], rel=1e-13)


def test_nutation_starting_anywhere_equals_the_taylor_series():
    A, C, spin, moment, tilt, tilt_rate, precession = 0.9, 0.35, 21.0, 7.0, 0.8, -1.3, 2.1
    omega = (tilt_rate, precession * np.sin(tilt), spin)
    half = (np.cos(tilt / 2), np.sin(tilt / 2), 0.0, 0.0)
    t = np.array([0.11, 0.57, 1.9])
    series = theory.spinning_body(t, (A, A, C), omega, half, weight_moment=(0, 0, moment))
    height = rotations.nutation(A, C, spin, moment, tilt, tilt_rate, precession).height(t)
    # roots of a cubic in double precision
    assert np.abs(height - series.rotation[:, 2, 2]).max() < 1e-13


def test_steady_precession_is_steady():
    case = read("top_slow_precession")
    A, C, moment, tilt = 0.02 + 2 * 0.3**2, 0.015, 2 * 9.81 * 0.3, np.pi / 3
    slow, fast = theory.steady_precession(A, C, 150.0, moment, tilt)
    assert slow == pytest.approx(case["reference"]["Omega"], rel=1e-14)
    t, com = columns("top_slow_precession", "com_x", "com_y", "com_z")
    for rate in (slow, fast):
        half = (np.cos(tilt / 2), -np.sin(tilt / 2), 0.0, 0.0)
        omega = (0.0, -rate * np.sin(tilt), 150.0)
        axis = theory.spinning_body(t, (A, A, C), omega, half, weight_moment=(0, 0, moment)).rotation[:, :, 2]
        circle = [-np.sin(tilt) * np.sin(rate * t), np.sin(tilt) * np.cos(rate * t), np.full(3, np.cos(tilt))]
        # the rate is rounded to double: 1e-16 of 21 rad/s over 2 s
        assert np.abs(axis - np.transpose(circle)).max() < 1e-13
        if rate == slow:
            assert np.abs(0.3 * axis - com).max() < 1e-14


def test_gimbal_wheel_precesses_at_the_slow_root_of_a_horizontal_axis():
    slow, fast = theory.steady_precession(0.3, 0.09375, 100.0, 3 * 9.81 * 0.2, np.pi / 2)
    assert slow == pytest.approx(read("gyro_gimbal_wheel")["reference"]["Omega"], rel=1e-14)
    assert fast == np.inf


def test_sleeping_top_threshold_is_where_small_tilts_start_to_grow():
    A, C, moment = 0.31, 0.12, 2.7
    critical = rotations.sleeping_spin(A, C, moment)
    assert theory.steady_precession(A, C, critical * (1 + 1e-12), moment, 0.0) == pytest.approx(
        [C * critical / (2 * A)] * 2, rel=1e-5
    )
    for factor, lowest in ((1.05, np.cos(1e-3) - 1e-4), (0.95, 0.97)):
        # tilted by 1e-4 and upright in momentum: a stable top stays near that, an unstable one falls
        top = rotations.nutation(A, C, factor * critical, moment, 1e-4, 0.0, C * factor * critical / (2 * A))
        assert (top.lowest > lowest) == (factor > 1)


def test_top_errors_name_value_and_remedy():
    with pytest.raises(ValueError, match="steady precession needs at least"):
        theory.steady_precession(1.0, 0.1, 1.0, 5.0, 0.2)
    with pytest.raises(ValueError, match="weight_moment"):
        rotations.nutation(1.0, 0.5, 10.0, -1.0, 0.3, 0.0, 0.0)
    with pytest.raises(ValueError, match="sort them"):
        theory.spinning_body([1.0, 0.5], (1, 2, 3), (0, 0, 1))


def test_flips_equal_the_reference():
    t, q = columns("free_dzhanibekov", "q_w", "q_x", "q_y", "q_z")
    w = columns("free_dzhanibekov", "w_x", "w_y", "w_z")[1]
    motion = theory.free_body(t, (1, 2, 3), (1e-3, 5, 1e-3))
    # the file's own error bound; the test below shows that the closed form is four digits better
    assert np.abs(motion.omega_body - w).max() < 1.8e-10
    assert same_rotation(motion.rotation, q) < 1.8e-10
    reference = read("free_dzhanibekov")["reference"]
    # the file takes 1 - m from a rounded m = 1 - 8e-8, which costs 1e-9 of the quarter period
    assert rotations.flip_interval((1, 2, 3), (1e-3, 5, 1e-3)) == pytest.approx(reference["flip_interval"], abs=2e-9)


def decimal_motion(t_end, steps, inertia, omega, order=30):
    """Body rates and rotation at the end of a free motion, Taylor series with 34 digits."""
    with localcontext() as context:
        context.prec = 34
        inertia, w = [Decimal(x) for x in inertia], [Decimal(float(x)) for x in omega]
        gains = [(inertia[i - 2] - inertia[i - 1]) / inertia[i] for i in range(3)]
        rows = [[Decimal(int(i == j)) for j in range(3)] for i in range(3)]
        step = Decimal(t_end) / steps
        for _ in range(steps):
            rates, axes = [w], [rows]
            for n in range(order):
                products = [sum(rates[k][i - 2] * rates[n - k][i - 1] for k in range(n + 1)) for i in range(3)]
                rates.append([gain * product / (n + 1) for gain, product in zip(gains, products, strict=True)])
                axes.append([decimal_cross(axes, rates, i, n) for i in range(3)])
            w = [sum(rates[n][i] * step**n for n in range(order + 1)) for i in range(3)]
            rows = [[sum(axes[n][i][j] * step**n for n in range(order + 1)) for j in range(3)] for i in range(3)]
        return np.array(w, dtype=float), np.array(rows, dtype=float)


def decimal_cross(axes, rates, i, n):
    """Coefficient n + 1 of a world axis in body axes, g_dot = g x w."""
    pairs = [(axes[k][i], rates[n - k]) for k in range(n + 1)]
    return [sum(g[j - 2] * w[j - 1] - g[j - 1] * w[j - 2] for g, w in pairs) / (n + 1) for j in range(3)]


@pytest.mark.slow
def test_twenty_flips_equal_integration_with_34_digits():
    inertia, omega = (1, 2, 3), (-1e-2, 5.0, 1e-2)
    t_end = 101.0
    assert 20 <= t_end / rotations.flip_interval(inertia, omega) < 21
    # step 0.134 s: the series of order 30 end at 1e-16 of the smallest digit that matters (order 36: same digits)
    w, rotation = decimal_motion(t_end, 750, inertia, omega)
    motion = theory.free_body([t_end], inertia, omega)
    # 5e-14 found over 2000 samples; 80-bit Taylor series reach 2e-11 here
    assert np.abs(motion.omega_body[0] - w).max() < 1e-12
    assert np.abs(motion.rotation[0] - rotation).max() < 1e-12


@pytest.mark.parametrize(
    ("inertia", "omega"),
    [
        ((3.0, 1.3, 2.2), (0.2, -0.7, 1.3)),
        pytest.param((3.0, 1.3, 2.2), (1.9, 0.3, -0.8), marks=pytest.mark.slow),
        pytest.param((1.3, 2.2, 3.0), (0.9, -0.4, 0.2), marks=pytest.mark.slow),
        pytest.param((2.2, 3.0, 1.3), (0.4, 0.6, -1.7), marks=pytest.mark.slow),
        pytest.param((2.2, 1.3, 3.0), (-0.7, -1.1, 0.3), marks=pytest.mark.slow),
        ((0.1, 4.0, 4.05), (0.3, 1.0, -5.0)),
        ((1.1, 1.1, 1.9), (0.3, -0.4, 0.5)),
        pytest.param((1.9, 1.1, 1.9), (0.3, -0.4, 0.5), marks=pytest.mark.slow),
    ],
)
def test_free_body_equals_the_taylor_series(inertia, omega):
    t = np.linspace(0, 40, 9)
    start = (0.5, 0.1, -0.7, 0.3)
    closed, series = theory.free_body(t, inertia, omega, start), theory.spinning_body(t, inertia, omega, start)
    # Carlson integrals in double precision times up to 200 rad of precession; slender bodies amplify by their n
    assert np.abs(closed.omega_body - series.omega_body).max() < 1e-12
    assert np.abs(closed.rotation - series.rotation).max() < 1e-11  # 200 rad, n = 40, roundoff 2e-16: 2e-12


def test_free_body_on_the_separatrix():
    # I_p (I_m - I_p) w_p^2 = I_q (I_q - I_m) w_q^2, exactly in binary: 1 * 3 * 4^2 = 6 * 2 * 2^2
    inertia, omega = (1.0, 4.0, 6.0), (4.0, 0.5, -2.0)
    assert theory.polhode(inertia, omega).m1 == 0.0
    assert rotations.flip_interval(inertia, omega) == np.inf
    t = np.array([0.0, 0.4, 1.1, 2.3])
    closed, series = theory.free_body(t, inertia, omega), theory.spinning_body(t, inertia, omega)
    # the series leave the separatrix by exp(lam t) times 1e-19
    assert np.abs(closed.omega_body - series.omega_body).max() < 1e-14
    assert np.abs(closed.rotation - series.rotation).max() < 1e-14
    late = theory.free_body([30.0], inertia, omega).omega_body[0]
    assert np.abs(late[[0, 2]]).max() < 1e-15


def test_steady_rotations():
    t = np.array([0.0, 0.8, 2.5])
    for inertia, omega in (((2.0, 3.0, 4.0), (0.0, -1.7, 0.0)), ((1.5, 1.5, 1.5), (0.4, -0.2, 0.9))):
        motion = theory.free_body(t, inertia, omega, (0.2, 0.4, -0.1, 0.7))
        series = theory.spinning_body(t, inertia, omega, (0.2, 0.4, -0.1, 0.7))
        assert np.abs(motion.rotation - series.rotation).max() < 1e-15
        assert rotations.flip_interval(inertia, omega) == np.inf
    assert np.abs(theory.free_body(t, (1, 2, 3), (0, 0, 0)).rotation - np.eye(3)).max() == 0.0


def test_middle_axis_changes_sides_at_the_flip_interval():
    inertia, omega = (1.3, 2.2, 3.0), (0.02, 1.9, -0.05)
    interval = rotations.flip_interval(inertia, omega)
    t = np.linspace(0.0, 2.0, 7)
    first, second, third = (theory.free_body(t + k * interval, inertia, omega).omega_body for k in range(3))
    assert np.abs(second[:, 1] + first[:, 1]).max() < 1e-14
    assert np.abs(third - first).max() < 1e-14


def test_symmetric_free_body_equals_the_general_one():
    t, omega, start = np.linspace(0, 9, 7), (0.3, -1.2, 2.6), (0.1, 0.8, -0.5, 0.4)
    simple = rotations.free_symmetric_body(t, 1.7, 2.3, omega, start)
    general = theory.free_body(t, (1.7, 1.7, 2.3), omega, start)
    assert np.abs(simple.rotation - general.rotation).max() < 1e-14
    assert np.abs(simple.omega_body - general.omega_body).max() < 1e-14


def test_free_body_errors_name_value_and_remedy():
    with pytest.raises(ValueError, match="three positive principal moments"):
        theory.free_body([0.0], (1, -2, 3), (1, 1, 1))
    with pytest.raises(ValueError, match="transverse must be positive"):
        rotations.free_symmetric_body([0.0], 0.0, 1.0, (1, 1, 1))
    with pytest.raises(ValueError, match="m1"):
        theory.quarter_period(1.5)
    with pytest.raises(ValueError, match="reflect the motion"):
        theory.elliptic_phase(0.8, -0.6, 0.3)


@pytest.mark.parametrize("m1", [1.0, 0.3, 1e-4, 1e-9, 1e-15, 0.0])
def test_jacobi_functions_near_the_separatrix(m1):
    u = np.linspace(-0.99, 0.99, 8) * min(theory.quarter_period(m1), 15.0)
    value = theory.jacobi(u, m1)
    back = [theory.elliptic_phase(float(s), float(c), m1) for s, c in zip(value.sn, value.cn, strict=True)]
    # sn and cn rounded to double leave 1e-16 / dn in u
    assert np.abs((u - back) * value.dn).max() < 1e-15
    assert np.abs(value.dn**2 + (1 - np.longdouble(m1)) * value.sn**2 - 1).max() < 1e-18 * 10
    if m1:
        far = theory.jacobi(u + 6 * np.longdouble(theory.quarter_period(m1)), m1)
        # K is a double, 3 half periods of up to 18 each; sn and cn change by that times dn, dn by that times cn
        assert np.abs([far.sn + value.sn, far.cn + value.cn, far.dn - value.dn]).max() < 3e-14
        assert np.abs(far.am - value.am - 3 * np.pi).max() < 3e-14


def test_cardan_joint_equals_the_reference():
    case, bend = read("cardan_single_45"), np.pi / 4
    t, values = columns("cardan_single_45", "phi_in", "phi_out", "w_out", "motor_torque")
    angle = 10.0 * t
    mine = [
        angle,
        shafts.cardan_angle(angle, bend),
        theory.cardan_rate(angle, bend, 10.0),
        theory.cardan_motor_torque(angle, bend, 10.0, 0.08),
    ]
    assert np.abs(np.transpose(mine) - values).max() < 1e-13
    fine = np.linspace(0, np.pi, 200001)
    peak = theory.cardan_motor_torque(fine, bend, 10.0, 0.08).max()
    # the true maximum to 16 digits; the file holds a maximum over coarse samples, 4e-5 below it
    assert peak == pytest.approx(7.516463193050302, rel=1e-9)
    assert peak == pytest.approx(case["reference"]["max_motor_torque"], rel=5e-5)
    rates = theory.cardan_rate(np.array([0.0, np.pi / 2]), bend, 10.0)
    assert rates == pytest.approx([case["reference"]["w_out_min"], case["reference"]["w_out_max"]], rel=1e-14)
    assert rates[1] / rates[0] == pytest.approx(shafts.cardan_ratio(bend), rel=1e-14)


def test_cardan_rates_are_derivatives_of_the_angle():
    bend, rate, acceleration, h = 0.6, 3.0, -1.7, 1e-4
    t = np.linspace(0.1, 2.0, 9)

    def angle(t):
        return rate * t + acceleration * t**2 / 2

    out = [shafts.cardan_angle(angle(t + k * h), bend) for k in (-1, 0, 1)]
    speed = rate + acceleration * t
    # central differences: h^2 of the third derivative, and rounding over h^2
    assert np.abs((out[2] - out[0]) / (2 * h) - theory.cardan_rate(angle(t), bend, speed)).max() < 2e-6
    second = theory.cardan_acceleration(angle(t), bend, speed, acceleration)
    assert np.abs((out[2] - 2 * out[1] + out[0]) / h**2 - second).max() < 2e-5


def test_cardan_harmonics():
    amplitudes = crank_theory.harmonic_amplitudes(lambda angle: theory.cardan_rate(angle, np.pi / 6), 8)
    assert amplitudes[0] == pytest.approx(1.0, rel=1e-14)
    assert amplitudes[2::2] == pytest.approx(shafts.cardan_harmonics(np.pi / 6, 4), abs=1e-15)
    assert np.abs(amplitudes[1::2]).max() < 1e-15
    assert shafts.cardan_harmonics(np.pi / 6, 2) == pytest.approx([0.14359, 0.01031], abs=5e-6)


def test_double_cardan_shaft():
    angle = np.linspace(-4.0, 9.0, 41)
    assert np.abs(shafts.double_cardan_ratio(angle, 0.5, 0.5) - 1).max() < 1e-14
    # yokes crossed: the two errors add up instead
    ratio = shafts.double_cardan_ratio(np.linspace(0, np.pi, 1801), 0.5, 0.5, np.pi / 2)
    assert ratio.max() / ratio.min() == pytest.approx(shafts.cardan_ratio(0.5) ** 2, rel=1e-12)
    with pytest.raises(ValueError, match="right angle"):
        shafts.cardan_angle(0.1, 1.6)


def test_pendulum_released_horizontally():
    t, values = columns("iftomm_A01_pendulum", "P_x", "P_y", "V_x", "V_y")
    angle, rate = theory.pendulum_motion(t, np.sqrt(9.81), -np.pi / 2)
    s, c = np.sin(angle), np.cos(angle)
    # the reference claims 1e-13
    assert np.abs(np.transpose([s, -c, rate * c, rate * s]) - values).max() < 5e-13


def test_parallel_fourbars_turn_like_one_pendulum():
    reference = read("iftomm_A02_fourbar_N2")["reference"]
    t, values = columns("iftomm_A02_fourbar_N2", "th0", "VB0_x", "VB0_y")
    frequency = np.sqrt(reference["b"] / reference["a"])
    angle, rate = theory.pendulum_motion(t, frequency, np.pi, -1.0)
    # 3e-15 against 40-digit arithmetic; the angles in the file are 9e-12 off, not 1e-12 as it says
    assert np.abs(angle - np.pi - values[:, 0]).max() < 1e-11
    assert np.abs(np.transpose([rate * np.cos(angle), rate * np.sin(angle)]) - values[:, 1:]).max() < 1e-10
    hanging = read("eig_fourbar2_hanging")["reference"]["omega"][0]
    assert frequency == pytest.approx(hanging, rel=1e-15)


def test_hanging_rod():
    omega = read("eig_hanging_pendulum")["reference"]["omega"][0]
    inertia = 0.8416666666666667 + 10 * 0.5**2
    assert theory.pendulum_frequency(inertia, 10.0, 0.5) == pytest.approx(omega, rel=1e-15)


def test_door_with_tilted_hinges():
    t, values = columns("door_two_hinges", "angle", "rate")
    tilt = np.radians(5.0)
    inertia, mass, arm = 20 * (0.9**2 + 0.04**2) / 12 + 20 * 0.45**2, 20.0, 0.45
    frequency = theory.pendulum_frequency(inertia, mass, arm, 9.81 * np.sin(tilt))
    angle, rate = theory.pendulum_motion(t, frequency, np.pi / 3)
    assert np.abs(np.transpose([angle - np.pi / 3, rate]) - values).max() < 1e-12


@pytest.mark.parametrize(
    ("angle", "rate"), [(0.3, -1.1), (-2.9, 0.4), (1.0, 5.9), (-2.0, -6.2), (7.0, 0.5), (9.0, 7.0)]
)
def test_pendulum_obeys_its_equation(angle, rate):
    frequency, h = 2.3, 1e-4
    t = np.linspace(0.0, 4.0, 23)
    swing = [theory.pendulum_motion(t + k * h, frequency, angle, rate) for k in (-1, 0, 1)]
    assert [swing[1][0][0], swing[1][1][0]] == pytest.approx([angle, rate], abs=1e-12)
    # central differences at h = 1e-4: truncation h^2 w0^4 and rounding 1e-15 / h
    assert np.abs((swing[2][0] - swing[0][0]) / (2 * h) - swing[1][1]).max() < 1e-6
    assert np.abs((swing[2][1] - swing[0][1]) / (2 * h) + frequency**2 * np.sin(swing[1][0])).max() < 2e-6
    energy = swing[1][1] ** 2 / 2 - frequency**2 * np.cos(swing[1][0])
    assert np.abs(energy - energy[0]).max() < 1e-12


def test_pendulum_limits():
    angle, rate = theory.pendulum_motion([0.0, 1.0], 2.0, 0.0, 0.0)
    assert np.all(angle == 0) and np.all(rate == 0)
    # rate 2 w0 at the bottom just reaches the top: sin(phi / 2) = tanh(w0 t)
    for rate in (4.0, -4.0):
        angle, _ = theory.pendulum_motion(np.array([0.3, 1.1]), 2.0, 0.0, rate)
        assert np.sin(angle / 2) == pytest.approx(np.sign(rate) * np.tanh([0.6, 2.2]), rel=1e-14)
    with pytest.raises(ValueError, match="positive"):
        theory.pendulum_frequency(0.0, 1.0, 1.0)


def test_slider_on_a_turning_arm():
    t, values = columns("coriolis_slider", "s_x", "s_y", "v_x", "v_y", "motor_torque")
    r, speed = theory.arm_slider(t, 3.0, 0.1)
    c, s = np.cos(3 * t), np.sin(3 * t)
    torque = theory.arm_slider_torque(1.5, 3.0, r, speed)
    mine = np.transpose([r * c, r * s, speed * c - 3 * r * s, speed * s + 3 * r * c, torque])
    # torques up to 547 N m
    assert np.abs(mine - values).max() < 1e-12 * 550
    r, speed = theory.arm_slider(np.array([0.0, 0.4]), 2.0, 0.3, -0.7)
    # energy in the turning frame: r_dot^2 - w^2 r^2 is constant
    assert speed**2 - 4 * r**2 == pytest.approx([0.7**2 - 4 * 0.3**2] * 2, rel=1e-13)


def test_disc_rolling_in_a_circle():
    case = read("rolling_disc_circular")
    body, reference = case["bodies"][0], case["reference"]
    motion = theory.rolling_circle(0.3048, 0.05, 1.905e-4, 3.81e-4, 0.5, np.radians(5.0))
    assert motion.precession == pytest.approx(-reference["alpha_dot"], rel=1e-13)
    assert -motion.spin == pytest.approx(reference["gamma_dot"], rel=1e-13)
    assert motion.period == pytest.approx(reference["period"], rel=1e-13)
    assert motion.centre_radius == pytest.approx(reference["radius_com"], rel=1e-14)
    assert motion.centre_height == pytest.approx(body["r0"][2], rel=1e-14)
    axis = np.array(case["joints"][0]["axis"])
    # the file goes round clockwise
    omega = -motion.precession * np.array([0, 0, 1]) - motion.spin * axis
    assert omega == pytest.approx(body["w0"], rel=1e-13, abs=1e-14)
    with pytest.raises(ValueError, match="lean"):
        theory.rolling_circle(1.0, 0.05, 1e-4, 2e-4, 0.5, -0.1)


ENGINE = json.loads((REFERENCES.parents[1] / "engines" / "references" / "engine.json").read_text(encoding="utf-8"))
TOY = ENGINE["toy_set_1"]
RATE = TOY["omega"]


def toy(length=None, crank_centre=None):
    crank, rod = TOY["crank"], TOY["rod"]
    return crank_theory.SliderCrank(
        radius=TOY["R"],
        rod_length=length or TOY["L"],
        crank_mass=crank["mass"],
        crank_centre=crank["cg_from_pivot"] if crank_centre is None else crank_centre,
        rod_mass=rod["mass"],
        rod_fraction=rod["cg_fraction_from_crankpin"],
        rod_inertia=rod["cg_inertia"],
        piston_mass=TOY["piston"]["mass"],
    )


ANGLES = np.radians(np.arange(0.0, 360.0, 0.1))
DOWN = (0.0, -9.81)
"""Gravity of the inverse-dynamics figures: at right angles to the bore (the guide carries 7 kg g = 68.67 N)."""


def block_force_amplitudes(mechanism, centripetal=True):
    """Of the orders 0 ... 8, along the bore and across it."""

    def force(q, axis):
        return crank_theory.block_force(mechanism, q, RATE, centripetal)[:, axis]

    return [crank_theory.harmonic_amplitudes(partial(force, axis=axis), 8) for axis in (0, 1)]


@pytest.mark.parametrize(("centripetal", "first"), [(True, "1x_true"), (False, "1x_article")])
def test_block_force_has_the_published_harmonics_and_no_others(centripetal, first):
    published = ENGINE["single_cylinder_closed_form_N"]
    bore, across = block_force_amplitudes(toy(), centripetal)
    assert bore[[1, 2, 4, 6]] == pytest.approx(np.abs([published[k] for k in (first, "2x", "4x", "6x")]), abs=1e-12)
    assert max(*bore[[0, 3, 5, 7]], *across[2:], across[0]) < 1e-13
    lost = 0.0 if centripetal else RATE**2 * TOY["crank"]["mass"] * TOY["crank"]["cg_from_pivot"]
    assert across[1] == pytest.approx(published["perp_1x"] - lost, abs=1e-12)
    assert (toy().reciprocating, toy().rotating_moment) == (TOY["m_recip"], TOY["U_rot_full"])


def test_rod_ratio_sweep_of_the_inline_four():
    for key, force in ENGINE["sweep_RL_I4_2x"].items():
        assert 4 * block_force_amplitudes(toy(length=float(key[2:])))[0][2] == pytest.approx(force, rel=1e-12)


def test_driving_torque_peaks():
    with_gravity = crank_theory.slider_crank_torque(toy(), ANGLES, RATE, gravity=DOWN)
    without = crank_theory.slider_crank_torque(toy(), ANGLES, RATE)
    # published with 6 digits; 0.1 deg sampling is 3e-7 off the peak
    assert np.abs(with_gravity).max() == pytest.approx(33.1231, abs=1e-4)
    assert np.abs(without).max() == pytest.approx(6.8925, abs=1e-4)
    amplitudes = crank_theory.harmonic_amplitudes(lambda q: crank_theory.slider_crank_torque(toy(), q, RATE), 6)
    # inertia torque of the inline four, 17.43 N m at twice shaft speed, and 3.19 N m per cylinder at three times
    assert [4 * amplitudes[2], amplitudes[3]] == pytest.approx([17.43, 3.19], abs=0.005)
    assert amplitudes[0] < 1e-14


def test_pin_forces_of_the_toy_engine():
    published = ENGINE["single_cylinder_inverse_dynamics_g_9.81"]["theta0"]
    true, without = (
        crank_theory.slider_crank_loads(toy(), ANGLES, RATE, gravity=DOWN, centripetal=flag) for flag in (True, False)
    )
    mine = {
        "bearing_full": true.bearing,
        "bearing_missing_h": without.bearing,
        "crank_rod_pin": true.crankpin,
        "rod_slider_pin": true.wristpin,
    }
    for key, force in mine.items():
        assert np.linalg.norm(force[0]) == pytest.approx(published[key], abs=0.005)
    assert true.guide[0] == pytest.approx(published["guide"], abs=0.005)
    assert true.torque[0] == pytest.approx(published["driving_torque"], abs=0.005)
    for loads, extremes in ((true, (34.74, 44.82)), (without, (35.76, 43.73))):
        size = np.linalg.norm(loads.bearing, axis=1)
        assert [size.min(), size.max()] == pytest.approx(extremes, abs=0.005)


def test_torque_by_energy_equals_torque_by_forces():
    mechanism = crank_theory.SliderCrank(0.31, 0.83, 1.7, 0.12, 0.9, 0.37, 0.041, 1.3, crank_inertia=0.07)
    arguments = dict(gravity=(2.1, -7.3), acceleration=-4.4)
    torque = crank_theory.slider_crank_torque(mechanism, ANGLES, 5.2, **arguments)
    loads = crank_theory.slider_crank_loads(mechanism, ANGLES, 5.2, **arguments)
    assert torque == pytest.approx(loads.torque, abs=1e-12)
    # work of the driving torque over a turn at constant speed is zero, with gravity too
    steady = crank_theory.slider_crank_torque(mechanism, ANGLES, 5.2, gravity=(2.1, -7.3))
    assert abs(steady.mean()) < 1e-13


def test_slider_crank_errors_name_value_and_remedy():
    with pytest.raises(ValueError, match="must exceed the crank radius"):
        toy(length=0.9)


def test_ghost_quaternion_after_one_turn():
    omega = np.array([1.2, -0.4, 2.0])
    e = rotations.ghost_quaternion([2 * np.pi / np.linalg.norm(omega)], omega)[0]
    assert np.linalg.norm(e) == pytest.approx(np.sqrt(1 + np.pi**2), rel=1e-15)
    turned = np.trace(theory.rotation_matrix(e).astype(float))
    assert np.arccos((turned - 1) / 2) == pytest.approx(rotations.ghost_angle(1.0), rel=1e-12)
    assert rotations.ghost_angle(1.0) == pytest.approx(2 * np.arctan(np.pi), rel=1e-15)


def test_quaternion_inverts_rotation_matrix():
    rng = np.random.default_rng(3)
    e = rng.normal(size=(20, 4))
    e /= np.linalg.norm(e, axis=1)[:, None]
    assert same_rotation(np.array([theory.rotation_matrix(x) for x in e]), e) < 1e-15
