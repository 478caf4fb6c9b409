"""Identities of quaternions and rotation matrices at general values, and every refusal."""

import doctest

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mbsd3d import GROUND, Body, Revolute, measures, rotation
from mbsd3d.base import rotations
from mbsd3d.kernels.kinematics import displace_body
from mbsd3d.rotations import (
    H,
    as_quaternion,
    conjugate,
    exponential,
    logarithm,
    matrix,
    multiply,
    quaternion_from_matrix,
    skew,
)

ROUNDING = 1e-14  # a few dozen operations on numbers of order 1
OMEGA = np.array([0.7, -1.3, 2.1])


@pytest.fixture
def e():
    """(4, 5, 4) unit quaternions in general position, scalar parts of both signs."""
    values = np.random.default_rng(20).normal(size=(4, 5, 4))
    return values / np.linalg.norm(values, axis=-1, keepdims=True)


def test_examples():
    result = doctest.testmod(rotations)
    assert result.attempted and not result.failed


def test_H_has_the_entries_of_the_definition():
    e0, e1, e2, e3 = 0.1, 0.2, 0.3, 0.4
    expected = [[-e1, -e2, -e3], [e0, e3, -e2], [-e3, e0, e1], [e2, -e1, e0]]
    np.testing.assert_array_equal(H([e0, e1, e2, e3]), expected)


def test_H_is_orthonormal_and_perpendicular_to_e(e):
    identity = np.swapaxes(H(e), -1, -2) @ H(e)
    np.testing.assert_allclose(identity, np.broadcast_to(np.eye(3), identity.shape), rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(np.einsum("...i,...ij->...j", e, H(e)), 0.0, rtol=0, atol=ROUNDING)


def test_H_gives_the_rate_of_a_rotation_with_world_omega(e):
    dt = 1e-5
    ahead, behind = (multiply(exponential(s * dt * OMEGA), e) for s in (1, -1))
    # central difference: dt^2 |omega|^3 / 48 = 4e-11, rounding 1e-16 / dt = 1e-11
    np.testing.assert_allclose((ahead - behind) / (2 * dt), 0.5 * H(e) @ OMEGA, rtol=0, atol=1e-10)


def test_matrix_turns_with_world_omega(e):
    dt = 1e-5
    ahead, behind = (matrix(multiply(exponential(s * dt * OMEGA), e)) for s in (1, -1))
    # central difference: dt^2 |omega|^3 / 6 = 3e-10
    np.testing.assert_allclose((ahead - behind) / (2 * dt), skew(OMEGA) @ matrix(e), rtol=0, atol=1e-9)


def test_second_derivative_uses_H_of_the_rate(e):
    dt, alpha = 1e-4, np.array([-0.4, 0.9, 0.3])
    ahead, behind = (multiply(exponential(s * dt * OMEGA + 0.5 * dt**2 * alpha), e) for s in (1, -1))
    rate = 0.5 * H(e) @ OMEGA
    expected = 0.5 * (H(e) @ alpha + H(rate) @ OMEGA)
    # second difference: dt^2 |omega|^4 / 200 = 2e-9, rounding 4e-16 / dt^2 = 4e-8
    np.testing.assert_allclose((ahead - 2 * e + behind) / dt**2, expected, rtol=0, atol=2e-7)


def test_matrix_is_a_rotation_and_ignores_the_length(e):
    R = matrix(e)
    np.testing.assert_allclose(R @ np.swapaxes(R, -1, -2), np.broadcast_to(np.eye(3), R.shape), rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(np.linalg.det(R), 1.0, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(matrix(3.0 * e), R, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(matrix(-e), R, rtol=0, atol=ROUNDING)


def test_matrix_agrees_with_scipy(e):
    scalar_last = np.roll(e.reshape(-1, 4), -1, axis=-1)
    np.testing.assert_allclose(
        matrix(e).reshape(-1, 3, 3), Rotation.from_quat(scalar_last).as_matrix(), rtol=0, atol=ROUNDING
    )


def test_matrix_round_trip(e):
    back = quaternion_from_matrix(matrix(e))
    np.testing.assert_allclose(back, np.where(e[..., :1] < 0, -e, e), rtol=0, atol=ROUNDING)


def test_matrix_round_trip_at_half_turns():
    axes = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [0.6, 0, -0.8], [0.48, -0.6, 0.64]])
    e = np.concatenate([np.zeros((5, 1)), axes], axis=1)
    np.testing.assert_allclose(matrix(quaternion_from_matrix(matrix(e))), matrix(e), rtol=0, atol=ROUNDING)


def test_multiply_composes_and_conjugate_inverts(e):
    p, q = e[:2], e[2:]
    np.testing.assert_allclose(matrix(multiply(p, q)), matrix(p) @ matrix(q), rtol=0, atol=ROUNDING)
    identity = multiply(p, conjugate(p))
    np.testing.assert_allclose(identity, np.broadcast_to([1.0, 0, 0, 0], p.shape), rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("angle", [1e-300, 1e-160, 1e-9, 0.3, 2.0, np.pi - 1e-9])
def test_logarithm_inverts_exponential(angle):
    theta = angle * np.array([0.48, -0.6, 0.64])
    # relative to the angle: conditioning is 1 down to the smallest numbers
    np.testing.assert_allclose(logarithm(exponential(theta)), theta, rtol=1e-14, atol=1e-15 * angle)


def test_exponential_inverts_logarithm(e):
    theta = logarithm(e)
    assert np.all(np.linalg.norm(theta, axis=-1) <= np.pi)
    np.testing.assert_allclose(exponential(theta), np.where(e[..., :1] < 0, -e, e), rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(logarithm(2.5 * e), theta, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("angle", [1e-300, 1e-9, 1.5e-4, 1e-2, 0.7, 3.0, 40.0])
def test_bodies_are_turned_by_the_same_exponential(angle, e):
    turn, shift, y = angle * np.array([0.48, -0.6, 0.64]), np.array([0.3, -1.2, 0.7]), np.zeros(10)
    y[3:] = 0.2, -0.4, 0.9, *e[0, 0]
    displace_body(y, 3, tuple(shift), tuple(turn))
    assert y == pytest.approx([0.0, 0.0, 0.0, 0.5, -1.6, 1.6, *multiply(exponential(turn), e[0, 0])], abs=1e-15)


def test_zero_angle_is_exact():
    np.testing.assert_array_equal(exponential(np.zeros(3)), [1, 0, 0, 0])
    np.testing.assert_array_equal(logarithm([-1.0, 0, 0, 0]), np.zeros(3))


def test_skew_is_the_cross_product():
    a, b = np.random.default_rng(3).normal(size=(2, 6, 3))
    np.testing.assert_allclose(np.einsum("...ij,...j->...i", skew(a), b), np.cross(a, b), rtol=0, atol=ROUNDING)


def test_rotation_turns_right_handed():
    x, y, z = np.eye(3)
    np.testing.assert_allclose(matrix(rotation("x", 90, degrees=True)) @ y, z, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(matrix(rotation("y", np.pi / 2)) @ z, x, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(matrix(rotation("z", np.pi / 2)) @ x, y, rtol=0, atol=ROUNDING)


def test_rotation_takes_axes_of_any_length_and_many_angles():
    axis, angles = np.array([0.48, -0.6, 0.64]), np.array([[0.3, -1.2, 4.0]])
    expected = exponential(angles[..., None] * axis)
    for length in (1e-200, 1.0, 1e200):
        np.testing.assert_allclose(rotation(length * axis, angles), expected, rtol=0, atol=ROUNDING)


def test_as_quaternion_takes_both_forms_and_keeps_the_sign(e):
    for one in e.reshape(-1, 4):
        np.testing.assert_allclose(as_quaternion(one), one, rtol=0, atol=ROUNDING)
        np.testing.assert_allclose(matrix(as_quaternion(matrix(one))), matrix(one), rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("turn", [(0, 0, 0), (np.pi, 0, 0), (0, np.pi, 0), (0, 0, np.pi), (1.9, 1.9, -1.8)])
def test_one_matrix_has_the_quaternion_of_a_stack(turn):
    """Each of the four components is the largest one somewhere: half turns, and near them."""
    rng = np.random.default_rng(7)
    for off in (np.zeros(3), 1e-3 * rng.normal(size=3), 0.3 * rng.normal(size=3)):
        R = matrix(exponential(turn + off))
        np.testing.assert_allclose(as_quaternion(R), quaternion_from_matrix(R), rtol=0, atol=ROUNDING)


def test_as_quaternion_normalises_what_was_typed_with_seven_digits():
    typed = as_quaternion([0.9238795, 0.0, 0.3826834, 0.0])
    assert abs(np.linalg.norm(typed) - 1.0) < ROUNDING


@pytest.mark.parametrize(
    ("orientation", "message"),
    [
        (
            [1, 0, 0, 0.01],
            r"wheel: the quaternion \[1.  , 0.  , 0.  , 0.01\] has norm 1.00005 instead of 1; give rotations.normalize",
        ),
        ([0, 0, 0, 0], "has norm 0 instead of 1"),
        ([1, 0, np.nan, 0], r"wheel: \[ 1.,  0., nan,  0.\] is not finite; give a unit quaternion"),
        (np.diag([1, 1, -1]), "wheel: the matrix is left-handed .* reverse one axis"),
        (2 * np.eye(3), "wheel: the matrix is not orthonormal, R'R differs from 1 by 3; its columns"),
        (np.full((3, 3), np.inf), "is not finite"),
        ([1, 0, 0], r"wheel: shape \(3,\) is not an orientation; give a unit quaternion"),
        ("upright", "wheel: 'upright' is not numeric"),
    ],
)
def test_as_quaternion_refuses(orientation, message):
    with pytest.raises(ValueError, match=message):
        as_quaternion(orientation, "wheel")


@pytest.mark.parametrize(
    ("axis", "angle", "message"),
    [
        ((0, 0, 0), 1.0, "rotation: axis has zero length"),
        ("Z", 1.0, "rotation: axis is 'Z'; give 'x', 'y', 'z' or a vector"),
        ((1, 0), 1.0, r"rotation: axis has shape \(2,\)"),
        ((np.nan, 0, 1), 1.0, "rotation: axis: .* is not finite"),
        ("x", np.nan, "rotation: angle: nan is not finite; give a number"),
    ],
)
def test_rotation_refuses(axis, angle, message):
    with pytest.raises(ValueError, match=message):
        rotation(axis, angle)


@pytest.mark.parametrize(
    ("function", "value", "message"),
    [
        (matrix, [0, 0, 0, 0], "one is zero or not finite"),
        (logarithm, [0, 0, 0, np.nan], "one is zero or not finite"),
        (matrix, [1, 0, 0], r"quaternion: shape \(3,\) is wrong; give \(..., 4\)"),
        (H, 1.0, r"quaternion: shape \(\) is wrong"),
        (conjugate, [1, 0, 0], "quaternion: shape"),
        (exponential, [1, 0], "rotation vector: shape"),
        (skew, [1, 0], "vector: shape"),
        (quaternion_from_matrix, np.eye(4), r"R: shape \(4, 4\) is not a rotation matrix"),
        (quaternion_from_matrix, np.stack([np.eye(3), -np.eye(3)]), "R: the matrix is left-handed"),
    ],
)
def test_shapes_and_values_are_refused(function, value, message):
    with pytest.raises(ValueError, match=message):
        function(value)


def test_a_direction_may_be_a_letter():
    arm = Body("arm", 1.0, (1.0, 1.0, 1.0), position=(0.3, 0.2, 0.1))
    for letter, axis in zip("xyz", np.eye(3), strict=True):
        assert (Revolute(GROUND, arm, at=(0.0, 0.0, 0.0), axis=letter).axis == axis).all()
        assert (measures.omega(arm, axis=letter).axis == axis).all()
    with pytest.raises(ValueError, match=r"axis is 'w'; give 'x', 'y', 'z' or a vector"):
        Revolute(GROUND, arm, at=(0.0, 0.0, 0.0), axis="w")


def test_normalize_keeps_the_direction():
    given = np.array([[0.6, 0.0, 0.79, 0.1], [-3.0, 4.0, 12.0, 1e-3]])
    unit = rotations.normalize(given)
    np.testing.assert_allclose(np.linalg.norm(unit, axis=1), 1.0, rtol=1e-15, atol=0.0)
    np.testing.assert_allclose(rotations.matrix(unit), rotations.matrix(given), rtol=0.0, atol=1e-15)
    with pytest.raises(ValueError, match="zero"):
        rotations.normalize((0.0, 0.0, 0.0, 0.0))


def test_perpendiculars_that_are_carried_follow_their_axes_where_others_jump():
    """Axes that turn past the place where another world axis becomes the least along them, and their partners."""
    carried, away = rotations.Carried(), rotations.perpendiculars(np.array([0.0, 0.6, 0.8]))[0]
    steps, paths = [np.linspace(0.2, 1.3, 400), np.linspace(1.3, 0.2, 400)], []
    axes = [np.array([np.cos(a) * np.cos(b), np.sin(a) * np.cos(b), np.sin(b)]) for a, b in zip(*steps, strict=True)]
    plain = [rotations.perpendiculars(z)[0] for z in axes]
    assert max(np.linalg.norm(np.diff(plain, axis=0), axis=1)) > 0.5
    for z in axes:
        with carried.again():
            found = rotations.perpendiculars(z), rotations.matched_perpendiculars(z, away)
        for (x, y), about in zip(found, (z, away), strict=True):
            np.testing.assert_allclose([x, y, about] @ np.transpose([x, y, about]), np.eye(3), rtol=0, atol=1e-14)
            np.testing.assert_allclose(np.cross(x, y), about, rtol=0, atol=1e-14)
        paths.append(found[0][0])
    assert max(np.linalg.norm(np.diff(paths, axis=0), axis=1)) < 0.01  # axes move by 0.004 a step
    np.testing.assert_array_equal(paths[0], plain[0])
    np.testing.assert_array_equal(rotations.perpendiculars(axes[-1])[0], plain[-1])
