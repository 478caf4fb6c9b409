"""Whirl of rotors over their speed, against the 4 x 4 matrices of rigid rotors and closed forms."""

import numpy as np
import pytest

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Bushing,
    Cylindrical,
    Ramp,
    Revolute,
    Sine,
    SpeedDriver,
    System,
    TorsionSpring,
    Universal,
    campbell,
    measures,
    rotation,
)
from mbsd3d.errors import InputError
from mbsd3d.linear.campbell import Whirl, track
from mbsd3d.rotations import matrix

M, I_P, I_T = 20.0, 0.6, 0.4
TILT = rotation((0.3, -0.8, 0.5), 1.1)  # of the shaft: no axis is aligned
AXIS = matrix(TILT)[:, 2]


def rotor(a, b, kx=1e6, ky=1e6, polar=I_P, com=(0.0, 0.0, 0.0)):
    """A rigid rotor on bearings at distances a and b from its centre of mass, along an axis that is not aligned."""
    R = matrix(TILT)
    body = Body("rotor", M, (I_T, I_T, polar), com=com, position=-R @ com, orientation=TILT)
    bearings = [
        Bushing(GROUND, body, at=place * AXIS, stiffness=(kx, ky, 2e5), axes=TILT, name=f"bearing {k}")
        for k, place in enumerate((a, -b))
    ]
    return System([body], forces=bearings, gravity=(0, 0, 0)), measures.omega(body, axis=AXIS)


def whirl_frequencies(spin, a, b, k, polar=I_P):
    """Positive whirl frequencies of m x'' = -..., I_t th'' -+ I_p spin th' = -...: x and y as one complex motion."""
    K = k * np.array([[2.0, a - b], [a - b, a * a + b * b]])
    mass, gyro = np.diag([M, I_T]), np.diag([0.0, -1j * polar * spin])
    zero, one = np.zeros((2, 2)), np.eye(2)
    s = np.linalg.eigvals(np.block([[zero, one], [-np.linalg.solve(mass, K), -np.linalg.solve(mass, gyro)]]))
    return s.imag  # positive: forward


TRUTHS = {  # 4 x 4 matrix: a = 0.3, b = 0.2
    0.0: (307.530869750164, 307.5308697501644, 574.8258554994782, 574.8258554994786),
    300.0: (296.5411754587412, 310.81452193257803, 403.83949851472613, 839.5661520408895),
    900.0: (196.9003683531882, 313.17095833311384, 325.1039959627862, 1558.8334059828617),
}


def lateral(found, k):
    """Frequencies of the modes that are not along the shaft [rad/s], ascending, and their senses."""
    keep = np.flatnonzero(np.abs(found.frequencies[k] - np.sqrt(2 * 2e5 / M)) > 1e-6)
    order = keep[np.argsort(found.frequencies[k, keep])]
    return found.frequencies[k, order], found.sense[k, order]


def test_rotor_on_two_bearings():
    system, spin = rotor(0.3, 0.2, com=(0.02, -0.01, 0.05))
    found = campbell(system, spin=spin, speeds=list(TRUTHS))
    for k, (speed, expected) in enumerate(TRUTHS.items()):
        frequencies, sense = lateral(found, k)
        assert np.abs(frequencies / expected - 1.0).max() < 1e-8  # bushings far off their centre, at rest: rounding
        signed = whirl_frequencies(speed, 0.3, 0.2, 1e6)
        assert np.abs(np.sort(np.abs(signed)) / expected - 1.0).max() < 1e-10
        if speed:
            assert np.abs(sense - np.sign(signed[np.argsort(np.abs(signed))])).max() < 1e-6  # circles


@pytest.mark.parametrize("count", [4, 25])
def test_modes_are_followed_through_crossings(count):
    """Backward conical and both translational whirls cross; a mode keeps its column."""
    system, spin = rotor(0.25, 0.25)
    speeds = np.linspace(0.0, 600.0, count)
    found = campbell(system, spin=spin, speeds=speeds)
    half, stiff = I_P * speeds / (2 * I_T), 2e6 * 0.25**2 / I_T
    curves = {"forward": half + np.sqrt(half**2 + stiff), "backward": -half + np.sqrt(half**2 + stiff)}
    translation = np.sqrt(2e6 / M)
    for sense, expected in curves.items():
        k = np.argmin(np.abs(found.frequencies[-1] - expected[-1]))
        assert found.whirl[k] == sense and np.abs(found.frequencies[:, k] / expected - 1.0).max() < 1e-9
    flat = np.flatnonzero(np.abs(found.frequencies[-1] - translation) < 1e-6)
    assert flat.size == 2 and np.abs(found.frequencies[:, flat] / translation - 1.0).max() < 1e-9
    critical = found.critical_speeds()
    axial = np.sqrt(2 * 2e5 / M)
    conical = [x for x in critical if min(abs(x.speed - translation), abs(x.speed - axial)) > 1.0]
    assert len(conical) == 1 and conical[0].whirl == "backward"  # I_p > I_t: the forward one is never met
    assert conical[0].speed == pytest.approx(np.sqrt(2e6 * 0.25**2 / (I_T + I_P)), rel=1e-9)
    assert [x.speed for x in critical if abs(x.speed - translation) < 1.0] == pytest.approx([translation] * 2, rel=1e-9)
    assert "critical at 353.553 rad/s, backward" in repr(found)


def test_shapes_decide_where_frequencies_swap():
    """Two modes exchange their frequencies from one speed to the next; a third appears."""
    one, two, three = np.eye(3, dtype=complex)
    before = [Whirl(90j, one, 1.0, "one"), Whirl(110j, two, 1.0, "two")]
    after = [Whirl(91j, two, 1.0, "two"), Whirl(109j, one, 1.0, "one"), Whirl(300j, three, 1.0, "three")]
    assert track([before, after]) == [{1: 0, 0: 1}, {1: 1, 0: 0}, {1: 2}]
    assert track([after, before]) == [{1: 0, 0: 1}, {1: 1, 0: 0}, {0: 2}]


def test_forward_conical_critical_speed_of_a_long_rotor():
    polar = 0.25
    system, spin = rotor(0.25, 0.25, polar=polar)
    found = campbell(system, spin=spin, speeds=np.linspace(0.0, 1200.0, 7))
    critical = [x.speed for x in found.critical_speeds() if x.whirl == "forward"]
    assert max(critical) == pytest.approx(np.sqrt(2e6 * 0.25**2 / (I_T - polar)), rel=1e-9)
    twice = [x.speed for x in found.critical_speeds(2.0) if x.whirl == "forward"]
    # (2 W)^2 I_t - 2 W I_p W = 2 k a^2
    assert max(twice) == pytest.approx(np.sqrt(2e6 * 0.25**2 / (4 * I_T - 2 * polar)), rel=1e-9)


def test_bearings_of_two_stiffnesses():
    """Orbits are ellipses; of speeds between the two lateral frequencies the sense still follows from the mode."""
    system, spin = rotor(0.3, 0.2, kx=1e6, ky=1.6e6)
    found = campbell(system, spin=spin, speeds=[0.0, 300.0])
    frequencies, sense = lateral(found, 1)
    K = np.zeros((4, 4))
    for at in (0.3, -0.2):
        for k, (x, tilt) in ((1e6, (0, 2)), (1.6e6, (1, 3))):  # slopes x' and y' of the axis
            d = np.zeros(4)
            d[x], d[tilt] = 1.0, at
            K += k * np.outer(d, d)
    mass, gyro = np.diag([M, M, I_T, I_T]), np.zeros((4, 4))
    gyro[2, 3], gyro[3, 2] = I_P * 300.0, -I_P * 300.0
    A = np.block([[np.zeros((4, 4)), np.eye(4)], [-np.linalg.solve(mass, K), -np.linalg.solve(mass, gyro)]])
    expected = np.sort(np.linalg.eigvals(A).imag)[4:]
    assert np.abs(frequencies / expected - 1.0).max() < 1e-9
    assert 0.01 < np.abs(sense).min() and np.abs(sense).max() < 0.99  # ellipses
    assert np.abs(lateral(found, 0)[1]).max() < 1e-12  # lines, without spin


@pytest.mark.parametrize("place", [0.3, 0.2])
def test_jeffcott_rotor_with_a_gyroscopic_disc(place):
    """A disc on a light elastic shaft on rigid bearings, in the middle of the span and off it.

    Flexibilities of the beam at the disc: a^2 b^2, a b (b - a), a^2 - a b + b^2, each over 3 E I L. In the middle the
    shaft bends without tilting the disc: sqrt(48 E I / (m L^3)) at any speed. Off it the disc tilts too, and the
    gyroscopic moment shifts the forward critical speed, w = W with I_t - I_p for I_t.
    """
    span, bending, m, polar, across = 0.6, 3.2e3, 12.0, 0.5, 0.26  # [m], E I [N m^2], [kg], [kg m^2]
    a, b = place, span - place
    flexibility = np.array([[a * a * b * b, a * b * (b - a)], [a * b * (b - a), a * a - a * b + b * b]])
    K = np.linalg.inv(flexibility / (3.0 * bending * span))
    lever = K[0, 1] / K[0, 0]  # along the shaft, to the point where a push does not tilt
    disc = Body("disc", m, (across, across, polar), orientation=TILT)
    shaft = Bushing(
        GROUND, disc, at=lever * AXIS, axes=TILT, stiffness=(K[0, 0], K[0, 0], 1e8),
        turning_stiffness=(K[1, 1] - K[0, 0] * lever**2,) * 2 + (0.0,), name="shaft",
    )  # fmt: skip
    speeds = [0.0, 150.0, 300.0, 450.0]
    system = System([disc], forces=[shaft], gravity=(0, 0, 0))
    found = campbell(system, spin=measures.omega(disc, axis=AXIS), speeds=speeds)
    mass = np.diag([m, across])
    for i, speed in enumerate(speeds):
        gyro = np.diag([0.0, -1j * polar * speed])
        known = np.linalg.eigvals(np.block([
            [np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(mass, K), -np.linalg.solve(mass, gyro)]
        ])).imag  # fmt: skip
        for w, sense in zip(np.abs(known), np.sign(known), strict=True):
            near = np.abs(found.frequencies[i] - w) < 1e-7 * w
            assert near.any() and (speed == 0.0 or np.abs(found.sense[i][near] - sense).min() < 1e-6)
    squares = np.linalg.eigvals(np.linalg.solve(np.diag([m, across - polar]), K)).real
    forward = [x.speed for x in found.critical_speeds() if x.whirl == "forward"]
    assert forward == pytest.approx([np.sqrt(max(squares))], rel=1e-8)  # I_p > I_t: there is one
    middle = np.sqrt(48.0 * bending / (m * span**3))
    assert (abs(forward[0] / middle - 1.0) < 1e-8) == (a == b)


def overhung(polar):
    """A disc at the end of a light shaft that a universal joint and a bushing hold, driven by a hinge of the ground."""
    reach, at, k = 0.5, 0.3, 4e5
    housing = Body("housing", 0.0, (0, 0, 0))
    disc = Body("disc", 8.0, (0.05, 0.05, polar), com=(0, 0, reach))
    joints = [
        Universal(GROUND, housing, at=(0, 0, 0), axis_a=(1, 0, 0), axis_b=(0, 1, 0)),
        Revolute(housing, disc, at=(0, 0, 0), axis=(0, 0, 1), name="shaft"),
    ]
    return housing, disc, joints, reach, at, k


@pytest.mark.parametrize("motor", [None, lambda x: AngleDriver(x, Sine(0.3, 2.0)), lambda x: SpeedDriver(x, Ramp(7.0))])
def test_overhung_rotor_on_a_hinge(motor):
    """I about the joint: I w^2 - I_p W w = k a^2 forward, I w^2 + I_p W w = k a^2 backward; a motor keeps the speed."""
    polar = 0.09
    housing, disc, joints, reach, at, k = overhung(polar)
    mount = Bushing(GROUND, housing, at=(0, 0, at), stiffness=(k, k, 0.0))
    drives = [motor(joints[1])] if motor else []
    system = System([housing, disc], [*joints, *drives], [mount], gravity=(0, 0, 0))
    speeds = [0.0, 200.0, 400.0]
    found = campbell(system, spin=joints[1], speeds=speeds)
    inertia = 0.05 + 8.0 * reach**2
    for i, speed in enumerate(speeds):
        b, stiff = polar * speed / (2 * inertia), k * at * at / inertia
        for sign, name in ((1.0, "forward"), (-1.0, "backward")):
            column = found.whirl.index(name)
            assert found.frequencies[i, column] == pytest.approx(sign * b + np.sqrt(b * b + stiff), rel=1e-9)
    forward = next(x for x in found.critical_speeds() if x.whirl == "forward")
    assert forward.speed == pytest.approx(np.sqrt(k * at * at / (inertia - polar)), rel=1e-9)


def test_mode_that_oscillates_only_with_spin():
    """A disc held at its centre of mass: no tilting stiffness, the nutation I_p W / I_t; without spin it drifts."""
    disc = Body("disc", 10.0, (0.1, 0.1, 0.15))
    middle = Bushing(GROUND, disc, at=(0, 0, 0), stiffness=(4e4, 4e4, 1e6))
    system = System([disc], forces=[middle], gravity=(0, 0, 0))
    found = campbell(system, spin=measures.omega(disc, axis=(0, 0, 1)), speeds=[-20.0, 0.0, 50.0, 100.0])
    k = int(np.flatnonzero(np.isnan(found.frequencies[1]))[0])
    assert found.frequencies[[0, 2, 3], k] == pytest.approx([30.0, 75.0, 150.0], rel=1e-9)
    assert found.whirl[k] == "forward" and np.isnan(found.sense[1, k])


def test_what_is_refused():
    system, spin = rotor(0.3, 0.2)
    with pytest.raises(InputError, match="campbell: spin: .*give a hinge, or measures.omega"):
        campbell(system, spin="rotor", speeds=[0.0, 1.0])
    for wrong in ([1.0], [1.0, 0.5], [[0.0, 1.0]]):
        with pytest.raises(InputError, match="campbell: speeds: give two or more"):
            campbell(system, spin=spin, speeds=wrong)
    slider = Cylindrical(GROUND, system.bodies[0], at=(0, 0, 0), axis=AXIS)
    with pytest.raises(InputError, match="no mode oscillates"):
        campbell(System(system.bodies, [slider], gravity=(0, 0, 0)), spin=slider, speeds=[0.0, 1.0])
    figure = campbell(system, spin=spin, speeds=[0.0, 200.0, 400.0]).plot()
    assert figure.axes[0].get_ylabel() == "whirl frequency [rad/s]" and len(figure.axes[0].lines) == 7


def on_a_pedestal(polar):
    """A rotor in a hinge of a housing on two bushings, and a vane on a coil spring that turns about the same axis."""
    housing = Body("housing", 7.0, (0.3, 0.3, 0.5), orientation=TILT, com=(0, 0, 0.1))
    disc = Body("disc", 5.0, (0.1, 0.1, polar), orientation=TILT, position=0.25 * AXIS, com=(0, 0, 0.05))
    vane = Body("vane", 1.0, (0.01, 0.01, 0.02), orientation=TILT, position=-0.2 * AXIS)
    hinge = Revolute(housing, disc, at=0.25 * AXIS, axis=AXIS, name="spin")
    swing = Revolute(housing, vane, at=-0.2 * AXIS, axis=AXIS, name="swing")
    mounts = [Bushing(GROUND, housing, at=z * AXIS, stiffness=(k, k, 1e5), axes=TILT, turning_stiffness=(0, 0, 50.0),
                      name=f"mount {z}") for z, k in ((0.3, 2e5), (-0.1, 3e5))]  # fmt: skip
    coil = TorsionSpring(swing, stiffness=300.0, name="coil")
    return System([housing, disc, vane], [hinge, swing], [*mounts, coil], gravity=(0, 0, 0)), hinge


def test_rotor_in_a_housing_on_springs():
    """The housing stands still while its rotor spins; turning modes about the axis are planar.

    Criticals: (K - w^2 (M -+ J)) q = 0 of the slope and displacement of housing and rotor, which move as one.
    """
    polar = 0.15
    system, hinge = on_a_pedestal(polar)
    found = campbell(system, spin=hinge, speeds=np.linspace(0.0, 1500.0, 7))
    K, mass = np.zeros((2, 2)), np.diag([0.0, 0.3 + 0.1 + 0.01])
    for z, k in ((0.3, 2e5), (-0.1, 3e5)):
        K += k * np.outer((1.0, z), (1.0, z))
    for z, m in ((0.1, 7.0), (0.3, 5.0), (-0.2, 1.0)):
        mass += m * np.outer((1.0, z), (1.0, z))
    gyro = np.diag([0.0, polar])
    for word, sign in (("forward", -1.0), ("backward", 1.0)):
        squares = np.linalg.eigvals(np.linalg.solve(mass + sign * gyro, K)).real
        expected = np.sort(np.sqrt(squares[squares > 0.0]))
        speeds = [x.speed for x in found.critical_speeds() if x.whirl == word]
        assert speeds == pytest.approx(expected, rel=1e-9)
    assert found.whirl.count("planar") == 3  # along the axis, and two of turning about it


def test_pedestal_given_as_body_b():
    housing, disc, joints, *_ = overhung(0.09)
    hinge = Revolute(disc, housing, at=(0, 0, 0), axis=(0, 0, 1), name="shaft")
    system = System([housing, disc], [joints[0], hinge], gravity=(0, 0, 0))
    with pytest.raises(InputError, match="'shaft' cannot turn while its body a, 'disc', stands still"):
        campbell(system, spin=hinge, speeds=[0.0, 100.0])
