"""Shapes are as large as they say, closed, and turned and placed as asked; guesses have the inertia of their body."""

import numpy as np
import pytest
from helpers.models import random_body, random_inertia, random_orientation
from helpers.solids import SOLIDS, solid

from mbsd3d import Body, inertia, rotation
from mbsd3d.mechanism.shapes.homogeneous import shapes_of
from mbsd3d.mechanism.shapes.triangles import normals
from mbsd3d.rotations import matrix
from mbsd3d.shapes import Box, Capsule, Cylinder, Disc, Ellipsoid, Hull, Lines, MeshFile, Sphere, Torus

ROUND, BANDS, TURNS = 24, 12, 48  # sections of a ball about its axis and from pole to pole; of a cylinder


def polygon(n):
    """Area of a regular polygon over that of its circumcircle."""
    return np.sin(2.0 * np.pi / n) / (2.0 * np.pi / n)


def frustums(radius, height):
    """Volume of the surface of revolution of a polyline."""
    return np.pi / 3.0 * np.sum(np.diff(height) * (radius[1:] ** 2 + radius[1:] * radius[:-1] + radius[:-1] ** 2))


def ball_volume(radii):
    """Of the polyhedron in an ellipsoid."""
    turn = np.linspace(0.0, np.pi, BANDS + 1)
    return polygon(ROUND) * frustums(np.sin(turn), -np.cos(turn)) * np.prod(radii)


def capsule_volume(radius, length):
    """Of the polyhedron in a capsule."""
    turn = np.linspace(0.0, 0.5 * np.pi, 5)
    return polygon(ROUND) * (2.0 * frustums(radius * np.cos(turn), radius * np.sin(turn)) + np.pi * radius**2 * length)


VOLUMES = (  # of the solid with plane faces, and of the round one
    (0.3 * 0.4 * 0.7, 0.3 * 0.4 * 0.7),
    (ball_volume((0.3, 0.4, 0.7)), 4 / 3 * np.pi * 0.3 * 0.4 * 0.7),
    (ball_volume((0.6, 0.6, 0.6)), 4 / 3 * np.pi * 0.6**3),
    (polygon(TURNS) * np.pi * 0.3**2 * 0.8, np.pi * 0.3**2 * 0.8),
    (polygon(TURNS) * np.pi * 0.4**2 * 0.04, np.pi * 0.4**2 * 0.04),
    (polygon(36) * polygon(6) * 2 * np.pi**2 * 0.4 * 0.1**2, 2 * np.pi**2 * 0.4 * 0.1**2),
    (capsule_volume(0.2, 0.5), 4 / 3 * np.pi * 0.2**3 + np.pi * 0.2**2 * 0.5),
)


@pytest.mark.parametrize(("shape", "volumes"), list(zip(SOLIDS, VOLUMES, strict=True)), ids=lambda x: type(x).__name__)
def test_solids_are_closed_and_have_their_volume(shape, volumes):
    found = solid(shape)
    assert found.is_watertight and found.is_winding_consistent  # outward: the volume is positive
    assert found.volume == pytest.approx(volumes[0], rel=1e-12)
    assert 0.82 * volumes[1] < found.volume <= volumes[1] * (1 + 1e-12)  # 0.827 is a hexagon, the tube of the torus
    assert len(found.faces) <= 528  # a scene of 100 balls stays below 2 MB


def test_a_hull_is_the_convex_body_of_its_points():
    corners = np.array([(0.1, 0, 0), (1, 0.2, 0), (0, 1, 0.3), (0.2, 0.1, 1)])
    inner = np.random.default_rng(5).dirichlet((1, 1, 1, 1), 20) @ corners
    found = solid(Hull([*corners, *inner], at=(3, 0, 0)))
    assert found.is_watertight and found.is_winding_consistent and len(found.faces) == 4
    assert found.volume == pytest.approx(np.linalg.det(corners[1:] - corners[0]) / 6, rel=1e-12)  # outward
    assert np.allclose(found.bounds, [corners.min(axis=0) + (3, 0, 0), corners.max(axis=0) + (3, 0, 0)])


@pytest.mark.parametrize("shape", SOLIDS[3:], ids=lambda x: type(x).__name__)
def test_half_a_round_body_is_darker_in_sectors_about_its_axis(shape):
    mesh, turned = shape.about_z(), rotation("z", 90, degrees=True)
    centres = mesh.vertices[mesh.faces].mean(axis=1)
    order = np.lexsort(centres.round(9).T)
    again = np.lexsort((centres @ matrix(turned).T).round(9).T)
    assert mesh.shade.mean() == 0.5 and np.array_equal(mesh.shade[order], 1 - mesh.shade[again])


def test_octants_of_an_ellipsoid_alternate():
    mesh = Ellipsoid((0.3, 0.4, 0.7)).surface()
    side = np.sign(mesh.vertices[mesh.faces].mean(axis=1)).prod(axis=1)
    assert len(set(zip(side, mesh.shade, strict=True))) == 2


@pytest.mark.parametrize("seed", range(3))
def test_shapes_lie_where_they_are_put(seed):
    rng = np.random.default_rng(seed)
    body, turn, at = random_body(rng), random_orientation(rng), rng.normal(size=3)
    lengths = (0.3, 0.4, 0.7)
    assert np.allclose(solid(Box(lengths), body).center_mass, body.com, rtol=0, atol=1e-12)
    found = solid(Box(lengths, at=at, orientation=turn), body)
    R = matrix(turn) if np.shape(turn) == (4,) else turn
    assert np.allclose(found.center_mass, at, rtol=0, atol=1e-12)
    expected = R @ np.diag(inertia.box(found.volume, lengths)) @ R.T
    assert np.allclose(found.moment_inertia, expected, rtol=0, atol=1e-12)
    rod = solid(Cylinder(0.1, 2.0, at), body)
    assert np.ptp(rod.vertices @ at) == pytest.approx(2.0 * np.linalg.norm(at), rel=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_guesses_have_the_inertia_of_their_body(seed):
    rng = np.random.default_rng(seed)
    body = random_body(rng, shape="box")
    box, ellipsoid = shapes_of(body)[0], shapes_of(Body("b", body.mass, body.inertia, com=body.com))[0]
    found = solid(box, body)
    found.density = body.mass / found.volume
    assert np.allclose(found.moment_inertia, body.inertia, rtol=0, atol=1e-10 * body.inertia.max())
    assert np.allclose(found.center_mass, body.com, rtol=0, atol=1e-12)
    a, b, c = ellipsoid.radii**2
    R = matrix(ellipsoid.orientation)
    own = R @ np.diag([b + c, c + a, a + b]) @ R.T * body.mass / 5.0
    assert np.allclose(own, body.inertia, rtol=0, atol=1e-12 * body.inertia.max())
    radius, length = rng.uniform(0.2, 0.9, size=2)
    moments = inertia.cylinder(body.mass, radius, length, "xyz"[seed % 3])
    for turn in (np.eye(3), matrix(rotation(rng.normal(size=3), 1.2))):
        log = Body("log", body.mass, turn @ np.diag(moments) @ turn.T, shape="cylinder")
        guess = shapes_of(log)[0]
        assert (guess.radius, guess.length) == pytest.approx((radius, length), rel=1e-9)
        axis = matrix(guess.orientation)[:, "xyz".index(guess.axis)]
        assert abs(axis @ turn[:, seed % 3]) == pytest.approx(1.0, abs=1e-9)


def test_rods_and_plates_are_seen_and_points_are_not_guessed():
    rod = Body("rod", 2.0, inertia.rod(2.0, 1.5, "y"))
    radii = shapes_of(rod)[0].radii
    assert radii[1] == pytest.approx(np.sqrt(5 / 12) * 1.5) and np.allclose(
        radii[[0, 2]], 0.02 * radii[1]
    )  # that one sees it
    assert shapes_of(Body("pin", 0.0, (0, 0, 0))) == () == shapes_of(Body("mass", 1.0, (0, 0, 0)))
    for shape, message in (("box", "its inertia, which is 0"), ("cylinder", "its inertia, which is 0")):
        with pytest.raises(ValueError, match=f"body 'pin': shape '{shape}' follows from {message}; give a shape"):
            Body("pin", 1.0, (0, 0, 0), shape=shape)
    with pytest.raises(ValueError, match="body 'b': shape 'cylinder' needs two equal principal moments"):
        Body("b", 1.0, random_inertia(np.random.default_rng(1), 1.0), shape="cylinder")


def test_normals_leave_rims_sharp_and_sides_round():
    mesh = Cylinder(0.3, 0.8).surface()
    n, radial = normals(mesh), mesh.vertices * (1, 1, 0) / 0.3
    side = np.abs(n[:, 2]) < 1e-12
    assert np.allclose(np.abs(n[~side, 2]), 1.0) and side.sum() == 2 * TURNS
    assert np.allclose(n[side], radial[side], rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Box((1, 2)), r"Box: lengths: expected three numbers, got \(1, 2\)"),
        (lambda: Box((1, 0, 2)), r"Box: lengths: \[1.0, 0.0, 2.0\] are not all positive; give three numbers > 0"),
        (lambda: Box((1, 1, np.nan)), r"Box: lengths: \[ 1., *1., nan\] is not finite"),
        (lambda: Ellipsoid(0.3), "Ellipsoid: radii: expected three numbers"),
        (lambda: Sphere(-1), "Sphere: radius: -1.0 is not positive; give a number > 0"),
        (lambda: Cylinder(1, 0), "Cylinder: length: 0.0 is not positive"),
        (lambda: Cylinder(1, 1, "w"), "Cylinder: axis is 'w'; give 'x', 'y', 'z' or a vector that is not zero"),
        (lambda: Disc(1, axis=(0, 0, 0)), r"Disc: axis is \(0, 0, 0\); give"),
        (lambda: Disc(1, axis=tuple(np.zeros(3))), r"Disc: axis is \(0.0, 0.0, 0.0\); give"),  # not np.float64(0.0)
        (lambda: Disc(1, thickness=-2), "Disc: thickness: -2.0 is not positive"),
        (lambda: Torus(0.1, 0.1), "Torus: tube 0.1 is not below radius 0.1; give the radius of the centre line"),
        (lambda: Capsule("wide", 1), "Capsule: radius: expected a number, got 'wide'"),
        (lambda: Hull([(0, 0, 0)] * 3), r"Hull: points have shape \(3, 3\), or some are not finite; give 4 to 1000"),
        (lambda: Hull("abc"), "Hull: points are not numeric; give 4 to 1000 corners"),
        (lambda: Hull([(1, 1, 2), (2, 0, 2), (0, 3, 2), (5, 4, 2)]), "Hull: points lie in a plane; give"),
        (lambda: Hull([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, np.inf)]), "Hull: .* or some are not finite"),
        (lambda: Sphere(1, at=(0, 0)), "Sphere: at: expected three numbers"),
        (lambda: Sphere(1, orientation=(1, 1, 0, 0)), "Sphere: orientation: the quaternion .* has norm"),
        (lambda: Sphere(1, colour="blurple"), "Sphere: colour 'blurple' is unknown; give '#rrggbb' or a name"),
        (lambda: Sphere(1, colour="C1"), "Sphere: colour 'C1' is unknown"),
        (lambda: Sphere(1, colour="none"), "Sphere: colour 'none' is unknown"),
        (lambda: Sphere(1, colour=(1, 0, 0)), r"Sphere: colour \(1, 0, 0\) is unknown"),
        (
            lambda: MeshFile("part.iges"),
            r"MeshFile: path 'part.iges' is not a mesh; give one that ends in .stl, .obj",
        ),
        (lambda: MeshFile(3), "MeshFile: path is 3; give the name of a file"),
        (lambda: MeshFile("part.stl", 0), "MeshFile: scale: 0.0 is not positive"),
        (lambda: Lines([(0, 1)]), r"Lines: points have shape \(1, 2\); give \(k, 3\) numbers"),
        (lambda: Lines([(0, 0, 0), (1, np.nan, 0), (2, 0, 0)]), "Lines: 3 points, or some not finite; give"),
        (lambda: Lines([(0, 0, 0)]), "Lines: 1 points, or some not finite; give"),
        (lambda: Lines("abc"), "Lines: points are not numeric; give"),
    ],
)
def test_wrong_sizes_are_refused_when_built(make, message):
    with pytest.raises(ValueError, match=message):
        make()


@pytest.mark.parametrize("shape", ["potato", len, Box, {"a": 1}, [], [Box((1, 1, 1)), "box"], 3.0])
def test_unknown_shapes_are_refused_with_the_body(shape):
    with pytest.raises(ValueError, match="body 'thing': shape .* is unknown; give 'ellipsoid', 'box', 'cylinder', a"):
        Body("thing", 1.0, (1, 1, 1), shape=shape)


def test_names_of_colours_become_numbers():
    assert (Sphere(1, colour="tomato").colour, Sphere(1, colour="#12aBcd").colour) == ("#ff6347", "#12aBcd")
