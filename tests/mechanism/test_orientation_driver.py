"""A driven orientation against closed forms of rotations, scipy's rotations and Euler's equations."""

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import mbsd3d
from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Input,
    Kinematic,
    OrientationDriver,
    Polynomial,
    PositionDriver,
    Ramp,
    Revolute,
    Sine,
    Spherical,
    System,
    Table,
    rotation,
    simulate,
)
from mbsd3d.rotations import matrix, multiply

PIVOT = np.array([0.4, -0.2, 0.7])
INERTIA = np.array([[0.31, 0.02, -0.04], [0.02, 0.42, 0.03], [-0.04, 0.03, 0.25]])
VECTOR = (Polynomial((0.0, 0.9, 3.1)), Sine(2.0, 0.7), Polynomial((0.0, -2.0, 0.0, 1.7)))  # to 9 rad, from 0 on


def rotor(**fields):
    """A body of general shape whose reference point, pose and centre of mass lie along no axis."""
    turned = {"orientation": rotation((0.3, -0.8, 0.5), 1.1)} | fields
    return Body("rotor", 1.7, INERTIA, com=(0.05, -0.11, 0.08), position=PIVOT + (0.1, 0.2, -0.1), **turned)


def driven(signal, axes=None, base=GROUND, more=()):
    """A rotor on a ball joint that a driver turns relative to the base."""
    body = rotor()
    pivot = Spherical(base, body, at=PIVOT, name="pivot")
    driver = OrientationDriver(base, body, signal=signal, axes=axes, name="driver")
    parts = [body] if base is GROUND else [base, body]
    return System(parts, [*more, pivot, driver], gravity=(0.3, -0.7, -9.6))


def by_difference(function, t, step=2e-3):
    """df/dt by a central difference of order six, whose rounding is 1e-13 of f."""
    terms = ((1, 0.75), (2, -0.15), (3, 1 / 60))
    return sum(c * (function(t + k * step) - function(t - k * step)) for k, c in terms) / step


def world_rate(R, t):
    """The angular velocity of a rotation R(t), from its matrix."""
    W = by_difference(R, t) @ R(t).T
    return np.array([W[2, 1], W[0, 2], W[1, 0]])


def check_motion(system, prescribed, times, *, limit=1e-8):
    """Orientation, angular velocity and acceleration of the rotor are those of a matrix R(t) in front of its start."""
    run = simulate(system, times[-1], state=system.assemble(), method=Kinematic(), output=times)
    R_0 = matrix(system.part("rotor").orientation)
    for k, t in enumerate(run.t):
        assert np.abs(run.rotation("rotor")[k] - prescribed(t) @ R_0).max() < 1e-12
        # the difference errs by step^6 times the seventh derivative, some 1e5 at 20 rad/s
        assert np.abs(run.omega("rotor")[k] - world_rate(prescribed, t)).max() < limit
        alpha = by_difference(lambda x: world_rate(prescribed, x), t)
        assert np.abs(run.alpha("rotor")[k] - alpha).max() < 100.0 * limit
    assert run.certificate.passed
    return run


def test_a_rotation_vector_over_several_turns():
    def prescribed(t):
        return Rotation.from_rotvec([float(f(t)) for f in VECTOR]).as_matrix()

    times = np.linspace(0.02, 1.5, 24)
    check_motion(driven(VECTOR), prescribed, times)
    assert np.linalg.norm([float(f(1.5)) for f in VECTOR]) > 2 * np.pi


def test_near_zero_nothing_cancels():
    tiny = [1e-5 * f for f in VECTOR]
    system = driven(tiny)
    run = simulate(system, 0.5, method=Kinematic(), output=[0.1, 0.5])
    for k, t in enumerate(run.t):
        x, v, a = (np.array([float(f) for f in y]) for y in zip(
            *((f(t), f.derivative(t), f.second_derivative(t)) for f in tiny), strict=True))  # fmt: skip
        # the left Jacobian to second order: what is left out is of order 1e-15
        assert np.abs(run.omega("rotor")[k] - v - np.cross(x, v) / 2).max() < 1e-13
        assert np.abs(run.alpha("rotor")[k] - a - np.cross(x, a) / 2).max() < 1e-12


def test_coning():
    """exp(phi n) with n turning at w: w_n = sin(phi) n' + (1 - cos phi) n x n', in closed form."""
    phi, w = 2.3, 4.0
    f = w / (2 * np.pi)
    system = driven((Sine(phi, f, np.pi / 2), Sine(phi, f), 0.0))
    run = simulate(system, 1.0, state=system.assemble(), rtol=1e-11, output=20)
    n = np.column_stack([np.cos(w * run.t), np.sin(w * run.t), 0 * run.t])
    n_rate = w * np.column_stack([-np.sin(w * run.t), np.cos(w * run.t), 0 * run.t])
    omega = np.sin(phi) * n_rate + (1 - np.cos(phi)) * np.cross(n, n_rate)
    alpha = -np.sin(phi) * w**2 * n  # n x n' is constant
    assert np.abs(run.omega("rotor") - omega).max() < 1e-11
    assert np.abs(run.alpha("rotor") - alpha).max() < 1e-10
    assert run.certificate.passed


AXES = ((0.2, -0.4, 1.0), (1.0, 0.3, 0.1), (-0.3, 0.5, 0.9))


@pytest.mark.parametrize("many", [1, 2, 3])
def test_turns_one_after_the_other(many):
    axes, signals = AXES[:many], VECTOR[:many]

    def prescribed(t):
        R = Rotation.identity()
        for axis, f in zip(axes, signals, strict=True):
            R = R * Rotation.from_rotvec(float(f(t)) * np.array(axis) / np.linalg.norm(axis))
        return R.as_matrix()

    check_motion(driven(signals, axes), prescribed, np.linspace(0.02, 1.2, 12))


def test_relative_to_a_base_that_turns():
    base = Body("base", 2.0, (0.3, 0.4, 0.5), position=(0.1, 0, 0.2), orientation=rotation((1, 2, -1), 0.6))
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    hinge = Revolute(GROUND, base, at=(0.1, 0.3, 0), axis=axis, name="hinge")
    swing = Sine(1.3, 0.6)
    system = driven(VECTOR, base=base, more=[hinge, AngleDriver(hinge, swing)])

    def prescribed(t):
        turn = Rotation.from_rotvec(float(swing(t)) * axis)
        return (turn * Rotation.from_rotvec([float(f(t)) for f in VECTOR])).as_matrix()

    check_motion(system, prescribed, np.linspace(0.02, 1.0, 10))


def test_moment_of_a_spinning_top_that_is_led_round():
    """R = Rz(2 t) Rx(0.4) Rz(1.5 t^2): I alpha + w x I w of a published set of values."""
    top = Body("top", 1.0, (0.2, 0.5, 0.6))
    angles = (Ramp(2.0), 0.4, Polynomial((0.0, 0.0, 1.5)))
    driver = OrientationDriver(GROUND, top, signal=angles, axes=((0, 0, 1), (1, 0, 0), (0, 0, 1)), name="driver")
    system = System([top], [Spherical(GROUND, top, at=(0, 0, 0)), driver])
    for method in (Kinematic(), None):
        run = simulate(system, 0.7, state=system.assemble(), method=method, rtol=1e-11)
        moment, omega = run.reaction("driver").moment[-1], run.omega(top)[-1]
        assert moment == pytest.approx([1.5786201382101224, 1.0154446241663806, 1.4678048448085483], rel=1e-8)
        assert omega[0] == pytest.approx(0.8058796205892881, rel=1e-8)
        assert moment @ omega == pytest.approx(6.905714634013742, rel=1e-8)
        assert run.effort("driver")[-1] == pytest.approx(run.rotation(top)[-1].T @ moment, rel=1e-10)


def test_its_work_is_the_energy_of_the_run():
    system = driven(VECTOR)
    run = simulate(system, 1.0, rtol=1e-10)
    energy = run.energy()
    assert run.certificate.passed
    gained = energy.total[-1] - energy.total[0]
    assert run.work("driver")[-1] == pytest.approx(gained, rel=1e-8)
    assert abs(gained) > 1.0
    power = np.einsum("ti,ti->t", run.reaction("driver").moment, run.omega("rotor"))
    assert np.trapezoid(power, run.t) == pytest.approx(gained, rel=2e-2)  # of a rule over the steps of the run


def test_it_holds_every_turn_and_nothing_else():
    found = System([body := rotor()], [OrientationDriver(GROUND, body, signal=VECTOR)]).check()
    assert found.mobility == 3 and found.rank == 3
    assert driven(VECTOR).check().mobility == 0


@pytest.mark.parametrize("start", [(2.5, -1.1, 0.8), (0.0, 0.0, np.pi), (0.0, -2.0, 2.0), (5.0, 0.0, 0.0)])
def test_far_starts_are_found(start):
    """Also half a turn, where twice the sine of half the miss is not to be told from its opposite."""
    system = driven(start)
    state = system.assemble()
    expected = Rotation.from_rotvec(start).as_matrix() @ matrix(rotor().orientation)
    assert np.abs(matrix(state.q[3:7]) - expected).max() < 1e-12


def test_measured_orientations_pass_whole_turns():
    times = np.linspace(0.0, 1.5, 61)
    vectors = np.array([[float(f(t)) for f in VECTOR] for t in times])
    quaternions = np.array([multiply(rotation(x, np.linalg.norm(x)), (1.0, 0, 0, 0)) if x.any() else (1.0, 0, 0, 0)
                            for x in vectors]) * np.where(np.arange(61) % 2, -1.0, 1.0)[:, None]  # fmt: skip
    body = rotor()
    from_vectors = OrientationDriver.from_table(GROUND, body, times, vectors)
    unwrapped = OrientationDriver.from_table(GROUND, body, times, quaternions, name="measured")
    for one, other in zip(from_vectors.signal, unwrapped.signal, strict=True):
        assert np.abs(one.values - other.values).max() < 1e-12
    system = System([body], [PositionDriver(body, at=PIVOT, signal=(0, 0, 0)), unwrapped])
    run = simulate(system, 1.5, method=Kinematic(), output=[0.4, 1.23])
    for k, t in enumerate(run.t):  # a spline errs by the fourth power of its step, 25 ms
        expected = Rotation.from_rotvec([float(f(t)) for f in VECTOR]).as_matrix() @ matrix(body.orientation)
        assert np.abs(run.rotation(body)[k] - expected).max() < 1e-5


def test_files_keep_it(tmp_path):
    system = driven((Table([0, 1, 2, 3], [0, 0.2, 0.5, 0.1]), 0.3, Input("yaw", 0.0)), AXES)
    system.to_file(tmp_path / "model.toml")
    again = System.from_file(tmp_path / "model.toml")
    one, other = (x.assemble().q for x in (system, again))
    assert np.array_equal(one, other) or np.abs(one - other).max() < 1e-15  # the last digit of a direction
    run = simulate(driven(VECTOR), 0.2, output=3)
    run.save(tmp_path / "run.npz")
    known = mbsd3d.load(tmp_path / "run.npz")
    assert np.array_equal(known.effort("driver"), run.effort("driver"))
    run.to_csv(tmp_path / "run.csv")
    assert "driver.x" in (tmp_path / "run.csv").read_text().splitlines()[0]


def test_without_gamma_the_run_does_not_pass():
    """The teaching switch drops J_dot v of its rows and keeps what the signals prescribe."""
    run = simulate(driven(VECTOR), 0.5, gamma=False)
    assert not run.certificate.passed


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"signal": (0.1, 0.2)}, "2 signals, but a rotation vector has three"),
        ({"signal": 0.1, "axes": AXES[:2]}, "1 signals, but there are 2 axes"),
        ({"signal": (0.1, 0.2, 0.3, 0.4)}, "give one signal or three"),
        ({"signal": "x"}, "give one signal or three"),
        ({"signal": (0.1, None, 0.2)}, r"signal\[1\]"),
        ({"signal": 0.1, "axes": (0, 0, 0)}, r"axes\[0\]"),
        ({"signal": 0.1, "axes": (1, 2)}, "one direction"),
    ],
)
def test_what_is_refused(given, text):
    with pytest.raises(ValueError, match=f"'driver'.*{text}"):
        OrientationDriver(GROUND, rotor(), name="driver", **given)


def test_tables_that_are_refused():
    for rows, text in (
        (np.ones((5, 2)), "have shape"), (np.ones((5, 4)), r"orientations\[0\].*norm"), ("x", "not numeric")
    ):  # fmt: skip
        with pytest.raises(ValueError, match=text):
            OrientationDriver.from_table(GROUND, rotor(), np.arange(5.0), rows)


def test_linear_models_refuse_what_they_cannot_follow():
    def floating(first):
        return System([body := rotor()], [OrientationDriver(GROUND, body, signal=(first, 0, 0), name="driver")],
                      gravity=(0, 0, 0))  # fmt: skip

    system = floating(Input("yaw"))
    with pytest.raises(ValueError, match="'yaw' sets an orientation, of 'driver'"):
        mbsd3d.state_space(system, system.state(), outputs=[("alpha", "rotor")])
    ramp = floating(Ramp(1.0))
    with pytest.raises(ValueError, match="'driver' varies with time; give a constant"):
        mbsd3d.linearize(ramp, ramp.state())


def test_axes_may_be_letters(tmp_path):
    body = Body("body", 1.0, (0.1, 0.2, 0.15))
    pivot = Spherical(GROUND, body, at=(0, 0, 0))
    pairs = [
        ("y", [(0, 1, 0)]),
        (("x", "z"), [(1, 0, 0), (0, 0, 1)]),
        (("z", (1, 2, 3), "x"), [(0, 0, 1), (1, 2, 3), (1, 0, 0)]),
    ]
    for letters, axes in pairs:
        signal = (0.1,) * len(axes)
        driver, same = (OrientationDriver(GROUND, body, signal=signal, axes=x, name="led") for x in (letters, axes))
        assert np.array_equal(driver.axes, same.axes)
        path = System([body], [pivot, driver]).to_file(tmp_path / f"{len(axes)}.toml")
        assert np.abs(System.from_file(path).joints[1].axes - same.axes).max() < 1e-15
    path = tmp_path / "model.json"
    System([body], [pivot, OrientationDriver(GROUND, body, signal=0.1, axes=(3, 0, 0))]).to_file(path)
    document = json.loads(path.read_text())
    document["joints"][1]["axes"] = "y"
    path.write_text(json.dumps(document))
    assert np.array_equal(System.from_file(path).joints[1].axes, [(0, 1, 0)])
    for wrong in ("q", ["z", "q"], "zxz"):
        with pytest.raises(ValueError, match="axes is .*; give 'x', 'y', 'z' or a vector"):
            OrientationDriver(GROUND, body, signal=(0.1, 0.2, 0.3), axes=wrong)
