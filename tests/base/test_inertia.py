"""Inertias against exact quadrature, Steiner's rule against a body cut in two, and every refusal."""

import doctest

import numpy as np
import pytest

from mbsd3d import rotation
from mbsd3d.base import mass_properties
from mbsd3d.extend import check_inertia
from mbsd3d.inertia import box, combine, cone, cylinder, rod, sphere, steiner
from mbsd3d.rotations import matrix

ROUNDING = 1e-13  # relative: sums of at most a few hundred terms


def moments(points, masses):
    """Mass, centre of mass and inertia about it of mass points, by the definition."""
    com = masses @ points / masses.sum()
    d = points - com
    squares = np.sum(d**2, axis=1)
    return (
        masses.sum(),
        com,
        np.einsum("k,kij->ij", masses, squares[:, None, None] * np.eye(3) - d[:, :, None] * d[:, None]),
    )


def solid_of_revolution(profile, bottom, top):
    """Points and weights of a quadrature that is exact for quadratic functions on a body with a linear profile.

    Gauss in z (degree 4 + 3), Gauss in the radius (degree 3), equal angles around (harmonics below 8).
    """
    x, w = np.polynomial.legendre.leggauss(6)
    z, wz = 0.5 * (top - bottom) * x + 0.5 * (top + bottom), 0.5 * (top - bottom) * w
    rho, wr = 0.5 * x + 0.5, 0.5 * w
    angle = np.arange(8) * np.pi / 4
    Z, Rho, Angle = np.meshgrid(z, rho, angle, indexing="ij")
    radius = Rho * profile(Z)
    weights = (wz[:, None, None] * wr[None, :, None] * np.pi / 4) * radius * profile(Z)
    points = np.stack([radius * np.cos(Angle), radius * np.sin(Angle), Z], axis=-1)
    return points.reshape(-1, 3), weights.ravel()


def test_examples():
    result = doctest.testmod(mass_properties)
    assert result.attempted and not result.failed


def test_cone_by_quadrature():
    r, h = 0.37, 1.21
    volume, com, I = moments(*solid_of_revolution(lambda z: r * (1 - z / h), 0.0, h))
    np.testing.assert_allclose(volume, np.pi * r**2 * h / 3, rtol=ROUNDING)
    np.testing.assert_allclose(com, [0, 0, h / 4], rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(np.diag(cone(volume, r, h)), I, rtol=0, atol=ROUNDING)


def test_cylinder_by_quadrature():
    r, l = 0.37, 1.21
    volume, _, I = moments(*solid_of_revolution(lambda z: r + 0 * z, -l / 2, l / 2))
    np.testing.assert_allclose(np.diag(cylinder(volume, r, l)), I, rtol=0, atol=ROUNDING)
    np.testing.assert_array_equal(rod(volume, l, radius=r), cylinder(volume, r, l))


def test_sphere_is_a_stack_of_discs():
    r = 0.8
    x, w = np.polynomial.legendre.leggauss(4)  # exact to degree 7; the integrand has degree 4
    z, masses = r * x, r * w * np.pi * (r**2 - (r * x) ** 2)
    across = np.sum(masses * ((r**2 - z**2) / 4 + z**2))
    np.testing.assert_allclose(sphere(masses.sum(), r), across, rtol=ROUNDING)


def test_box_by_quadrature():
    lengths = np.array([0.3, 0.7, 1.1])
    x, w = np.polynomial.legendre.leggauss(2)
    points = np.stack(np.meshgrid(x, x, x, indexing="ij"), axis=-1).reshape(-1, 3) * lengths / 2
    masses = 2.9 * np.einsum("i,j,k->ijk", w, w, w).ravel() / 8
    np.testing.assert_allclose(np.diag(box(2.9, lengths)), moments(points, masses)[2], rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("solid", [cylinder, cone])
def test_axis_moves_the_axial_moment(solid):
    along_z = solid(2.0, 0.3, 0.9)
    np.testing.assert_array_equal(solid(2.0, 0.3, 0.9, axis="x"), along_z[[2, 0, 1]])
    np.testing.assert_array_equal(solid(2.0, 0.3, 0.9, axis="y"), along_z[[0, 2, 1]])


def test_thin_rod_has_no_axial_moment():
    np.testing.assert_allclose(rod(3.0, 2.0, axis="x"), [0.0, 1.0, 1.0], rtol=ROUNDING)


def test_every_solid_is_possible():
    for solid in (box(1, (0.2, 0.5, 0.0)), cylinder(1, 0.5, 0.0), rod(1, 0.7), sphere(1, 0.0), cone(1, 0.3, 0.0)):
        np.testing.assert_array_equal(check_inertia(solid, 1.0, "solid"), np.diag(solid))


def test_combine_puts_a_box_together_again():
    """A box, turned and moved, cut at 30 % of its length; one half is described in axes of its own."""
    lengths, cut, mass = np.array([0.9, 0.5, 0.2]), 0.3, 4.2
    e, centre = rotation((1, -2, 3), 0.8), np.array([0.4, -0.7, 1.3])
    R = matrix(e)
    left, right = lengths * [cut, 1, 1], lengths * [1 - cut, 1, 1]
    at_left = centre + R @ [-(lengths[0] - left[0]) / 2, 0, 0]
    at_right = centre + R @ [(lengths[0] - right[0]) / 2, 0, 0]
    inertia_right = R @ np.diag(box((1 - cut) * mass, right)) @ R.T
    whole = combine([
        (cut * mass, at_left, box(cut * mass, left), e),
        ((1 - cut) * mass, at_right, inertia_right),
    ])  # fmt: skip
    assert whole.mass == pytest.approx(mass, rel=ROUNDING)
    np.testing.assert_allclose(whole.com, centre, rtol=ROUNDING)
    np.testing.assert_allclose(whole.inertia, R @ np.diag(box(mass, lengths)) @ R.T, rtol=0, atol=ROUNDING)


def test_combine_of_points_is_the_definition_and_nests():
    rng = np.random.default_rng(11)
    points, masses = rng.normal(size=(5, 3)), rng.uniform(0.5, 2.0, size=5)
    parts = [(m, p, np.zeros(3)) for m, p in zip(masses, points, strict=True)]
    mass, com, I = moments(points, masses)
    for body in (combine(parts), combine([combine(parts[:2]), *parts[2:]])):
        assert body.mass == pytest.approx(mass, rel=ROUNDING)
        np.testing.assert_allclose(body.com, com, rtol=0, atol=ROUNDING)
        np.testing.assert_allclose(body.inertia, I, rtol=0, atol=20 * ROUNDING)


def test_combine_takes_a_massless_part():
    body = combine([(2.0, (1, 2, 3), (1, 1, 1)), (0.0, (9, 9, 9), (0, 0, 0))])
    np.testing.assert_array_equal(body.com, [1, 2, 3])
    np.testing.assert_array_equal(body.inertia, np.eye(3))


def test_steiner_is_the_inertia_of_a_point():
    d, omega = np.array([0.3, -0.8, 1.7]), np.array([1.1, 0.4, -0.6])
    np.testing.assert_allclose(steiner(2.5, d) @ omega, 2.5 * np.cross(d, np.cross(omega, d)), rtol=ROUNDING)


def test_check_inertia_returns_a_symmetric_copy():
    given = np.array([[1.0, 0.1, 0.2], [0.1 + 1e-12, 1.2, 0.05], [0.2, 0.05, 1.4]])
    checked = check_inertia(given, 1.0, "part")
    np.testing.assert_array_equal(checked, checked.T)
    np.testing.assert_allclose(checked, given, rtol=0, atol=1e-12)
    assert not np.shares_memory(checked, given)
    np.testing.assert_array_equal(check_inertia((0, 0, 0), 0.0, "massless"), np.zeros((3, 3)))
    np.testing.assert_array_equal(check_inertia((0, 0, 0), 1.0, "point"), np.zeros((3, 3)))


def test_check_inertia_forgives_rounding_of_a_flat_body():
    check = check_inertia(np.array([1.0, 2.0, 3.0 * (1 + 1e-10)]) * 1e-7, 1.0, "plate")
    assert check[2, 2] > 3e-7


@pytest.mark.parametrize(
    ("inertia", "mass", "message"),
    [
        ((1, 1, 3), 1.0, r"wheel: .* \[1., 1., 3.\]; 3 exceeds the sum 2 of the two others, which no body has; check"),
        ((1, -1, 1), 1.0, r"wheel: inertia has the principal moments \[-1.,  1.,  1.\], -1 < 0; check the signs"),
        ([[1, 0.1, 0], [0, 1, 0], [0, 0, 1]], 1.0, "wheel: inertia is not symmetric, .* make Iij and Iji equal"),
        ([[1, 1.2, 0], [1.2, 1, 0], [0, 0, 2]], 1.0, "-0.2 < 0"),
        ((1, np.nan, 1), 1.0, "wheel: inertia: .* is not finite; give three moments or a 3x3 matrix"),
        ((1, 1), 1.0, r"wheel: inertia has shape \(2,\); give three moments"),
        ("solid", 1.0, "wheel: inertia: 'solid' is not numeric"),
        ((1, 1, 1), 0.0, "wheel: mass is 0 but inertia is not; give a mass, or inertia"),
        ((1, 1, 1), -2.0, r"wheel: mass: -2.0 is below 0.0; give a number >= 0"),
        ((1, 1, 1), np.nan, r"wheel: mass: not finite \(nan\)"),
        ((1, 1, 1), None, "wheel: mass: expected a number, got None"),
    ],
)
def test_check_inertia_refuses(inertia, mass, message):
    with pytest.raises(ValueError, match=message):
        check_inertia(inertia, mass, "wheel")


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: box(1, (1, 2)), r"box: 2 edges given; give three lengths \(lx, ly, lz\)"),
        (lambda: box(1, (1, -2, 3)), r"box: ly: -2.0 is below 0.0; give a number >= 0"),
        (lambda: cylinder(1, 1, 1, axis="w"), "cylinder: axis is 'w'; give 'x', 'y' or 'z'"),
        (lambda: rod(1, np.inf), r"rod: length: not finite \(inf\)"),
        (lambda: rod(1, 1, axis=(0, 0, 1)), r"rod: axis is \(0, 0, 1\)"),
        (lambda: sphere(-1, 1), "sphere: mass: -1.0 is below 0"),
        (lambda: cone(1, "wide", 1), "cone: radius: expected a number, got 'wide'"),
        (lambda: combine([]), "combine: the mass of 0 parts is 0"),
        (lambda: combine([(1.0, (0, 0, 0))]), r"combine: part 0 has 2 entries; give \(mass, com, inertia\)"),
        (lambda: combine([(1.0, (0, 0), (1, 1, 1))]), r"combine: part 0: com: expected three numbers, got \(0, 0\)"),
        (
            lambda: combine([(1.0, "left", (1, 1, 1))]),
            "part 0: com: 'left' is not numeric; give three numbers",
        ),
        (lambda: combine([(1.0, (0, 0, 0), (1, 1, 3))]), "combine: part 0: inertia has the principal moments"),
        (lambda: combine([(1.0, (0, 0, 0), (1, 1, 1), (1, 1, 0, 0))]), "combine: part 0: orientation: the quaternion"),
    ],
)
def test_solids_and_combine_refuse(call, message):
    with pytest.raises(ValueError, match=message):
        call()
