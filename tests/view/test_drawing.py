"""What is drawn lies where the numbers say, in its true size, and the camera sees all of it."""

import numpy as np
import pytest
from helpers.models import (
    EXAMPLES,
    all_joints_mechanism,
    example_system,
    random_body,
    random_orientation,
    revolute_chain,
)

from mbsd3d import (
    GROUND,
    Body,
    ConeStop,
    EndStop,
    GearMesh,
    Joint,
    Revolute,
    Rolling,
    RollingDisc,
    Spherical,
    SpringDamper,
    State,
    System,
    rotation,
)
from mbsd3d.rotations import matrix, multiply
from mbsd3d.shapes import Box, Cylinder, Disc, MeshFile
from mbsd3d.view.page.show import page_layers
from mbsd3d.view.scene.artist import draw_system
from mbsd3d.view.scene.drawing import Layers, poses_of

LAYERS = {"bodies", "joints", "centre of mass", "reference point"}


def world(points, body, poses):
    """Points of a body in world coordinates."""
    r, e = poses
    return points @ matrix(e[body]).T + r[body]


def middle(points):
    """Of the extent of points, which for solids with symmetry is their centre."""
    return 0.5 * (np.nanmin(points, axis=0) + np.nanmax(points, axis=0))


def layer(drawing, name):
    """Pieces of one layer."""
    return [piece for piece in drawing.pieces if piece.layer == name]


@pytest.fixture(scope="module")
def moving():
    """A mechanism with all joints, and one state of it after everything has moved as one body."""
    system = all_joints_mechanism(2)
    rng = np.random.default_rng(4)
    turn, shift = random_orientation(rng), rng.normal(size=3)
    q = np.concatenate([[*matrix(turn) @ b.position + shift, *multiply(turn, b.orientation)] for b in system.bodies])
    state = State(0.0, q, np.zeros(6 * len(system.bodies)))
    return system, state, lambda x: matrix(turn) @ x + shift


def test_marks_lie_at_centres_of_mass_and_reference_points(moving):
    system, state, move = moving
    drawing, poses = draw_system(system), poses_of(system, state)
    assert {piece.layer for piece in drawing.pieces} == LAYERS
    for name, points in (
        ("centre of mass", [body.centre for body in system.bodies]),
        ("reference point", [body.position for body in system.bodies]),
    ):
        for body, piece, point in zip(system.bodies, layer(drawing, name), points, strict=True):
            assert piece.name == body.name and system.bodies[piece.body] is body
            assert np.allclose(world(middle(piece.mesh.vertices), piece.body, poses), move(point), rtol=0, atol=1e-12)


def test_names_lie_at_centres_of_mass_and_joint_points(moving):
    system, state, move = moving
    drawing, poses = draw_system(system), poses_of(system, state)
    tags = {tag.text: tag for tag in drawing.tags}
    assert list(tags) == [system.name(part) for part in (*system.bodies, *system.joints)]
    for part in (*system.bodies, *system.joints):
        tag = tags[system.name(part)]
        point = part.centre if isinstance(part, Body | RollingDisc) else part.point()
        point = part.outline.centre if isinstance(part, Rolling) else point
        if tag.body < len(system.bodies):  # what is fixed in the ground stays
            assert np.allclose(world(tag.point, tag.body, poses), move(point), rtol=0, atol=1e-12)


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("kind", EXAMPLES, ids=lambda kind: kind.__name__)
def test_every_joint_has_a_solid_at_its_point_and_its_axes(kind, seed):
    if kind is Rolling:
        return  # the surface is drawn with the body
    system = example_system(kind, seed)
    joint, drawing, poses = system.joints[-1], draw_system(system), poses_of(system)
    name = system.name(joint)
    own = [piece for piece in layer(drawing, "joints") if piece.name == name]
    points = [joint.point()]
    if kind is RollingDisc:
        points = [joint.centre]
    elif joint.partners():
        points = [part.point() for part in joint.partners()]
    if isinstance(joint, GearMesh):
        points = [
            axle.point + (joint.at - axle.point) @ axle.axis * axle.axis for axle in map(joint.axle, joint.partners())
        ]
    drawn = [world(piece.mesh.vertices, piece.body, poses) for piece in own]
    for point in points:  # the solids are symmetric about their points
        assert any(np.allclose(vertices.mean(axis=0), point, rtol=0, atol=1e-9) for vertices in drawn), name
    wires = [wire for wire in drawing.wires if wire.layer == "joints" and wire.name == name]
    axes = {k: getattr(joint, k, None) for k in ("axis", "axis_a", "axis_b", "normal", "lateral")}
    directions = np.array([np.diff(world(wire.points, wire.body, poses), axis=0)[0] for wire in wires])
    for axis in (axis for axis in axes.values() if axis is not None):
        lengths = np.linalg.norm(directions, axis=1)
        assert np.max(np.abs(directions @ axis) / lengths) == pytest.approx(1.0, abs=1e-12)


def test_axes_stay_with_the_body_they_are_fixed_in():
    rng = np.random.default_rng(8)
    one, two = random_body(rng, "one"), random_body(rng, "two")
    at, axis, axis_b = rng.normal(size=3), (1.0, 2.0, 2.0), (1.0, 2.0, 2.1)
    hinge = Revolute(one, two, at=at, at_b=at + 0.01, axis=axis, axis_b=axis_b)
    drawing = draw_system(System([one, two], [hinge]))
    first, second = (wire for wire in drawing.wires if wire.layer == "joints")
    poses = poses_of(System([one, two]))
    assert (first.body, second.body) == (0, 1)
    for wire, point, direction in ((first, at, hinge.axis), (second, at + 0.01, hinge.axis_b)):
        ends = world(wire.points, wire.body, poses)
        assert np.allclose(middle(ends), point, rtol=0, atol=1e-12)
        assert np.allclose(np.cross(ends[1] - ends[0], direction), 0.0, rtol=0, atol=1e-12)


def test_a_new_joint_needs_no_glyph_of_its_own():
    class Wing(Revolute):
        """A joint this package does not know."""

    class Odd(Joint):
        """Without anything but two bodies."""

        a, b = GROUND, None

        def rows(self):
            return []

    body = random_body(np.random.default_rng(3))
    Odd.b = body
    system = System([body], [Wing(GROUND, body, at=(0, 0, 0), axis=(1, 2, 2)), Odd(name="odd")])
    names = [piece.name for piece in layer(draw_system(system), "joints")]
    assert names == ["Wing 1", "odd"]


def test_bodies_are_drawn_true_to_scale_after_a_turn():
    rng = np.random.default_rng(5)
    lengths, turn = np.array([0.9, 0.04, 2.0]), random_orientation(rng)
    leaf = random_body(rng, "leaf", shape=[Box(lengths, at=(0.1, 0.2, 0.3), colour="tomato"), Disc(0.2, axis="x")])
    system = System([leaf])
    state = State(0.0, np.array([1.0, 2.0, 3.0, *(2.0 * turn)]), np.zeros(6))  # viewers need unit quaternions
    poses = poses_of(system, state)
    assert np.allclose(poses[1][0], turn) and np.array_equal(poses[1][1], GROUND.orientation)
    box, disc = layer(draw_system(system), "bodies")
    assert (box.colour, disc.colour) == ("#ff6347", "#0072B2")
    corners = (world(box.mesh.vertices, 0, poses) - (1, 2, 3)) @ matrix(turn) - (0.1, 0.2, 0.3)
    assert np.allclose(np.abs(corners), 0.5 * lengths, rtol=0, atol=1e-12)
    assert np.allclose(world(disc.mesh.vertices, 0, poses).mean(axis=0), matrix(turn) @ leaf.com + (1, 2, 3))


def test_wheels_have_their_outer_radius_and_touch_the_floor():
    wheel = Body("wheel", 2.0, (0.06, 0.12, 0.06), position=(0.3, 0.1, 0.35), orientation=rotation("y", 0.4))
    disc = RollingDisc(GROUND, wheel, axis=(0, 1, 0), radius=0.35)
    drawing = draw_system(System([wheel], [disc]))
    reach = [np.linalg.norm(piece.mesh.vertices, axis=1).max() for piece in drawing.pieces]
    assert max(reach) == pytest.approx(0.35, rel=1e-12)  # the ring; the lens of the body is inside
    assert drawing.floor == pytest.approx(0.0, abs=0.002 * 0.35)  # a ring of 60 chords
    hub = Body("hub", 2.0, (0.06, 0.12, 0.06), position=(0.3, 0.1, 0.35), shape=Disc(0.1, axis="y"))
    (own,) = layer(draw_system(System([hub], [RollingDisc(GROUND, hub, axis=(0, 1, 0), radius=0.35)])), "bodies")
    assert np.ptp(own.mesh.vertices[:, 0]) == pytest.approx(0.2)


def test_arms_and_links_reach_the_joints(moving):
    system, state, move = moving
    rng = np.random.default_rng(6)
    a, b = system.bodies[1], system.bodies[4]
    at_a, at_b = rng.normal(size=3), rng.normal(size=3)
    spring = SpringDamper(a, b, at_a=at_a, at_b=at_b, stiffness=40.0, name="spring")
    drawing = draw_system(System(system.bodies, system.joints, [spring]))
    poses = poses_of(system, state)
    link = next(link for link in drawing.links if link.name == "spring")
    assert np.allclose([world(x, k, poses) for k, x in link.ends], [move(at_a), move(at_b)], rtol=0, atol=1e-12)
    assert len(drawing.links) == 1 + sum(type(joint).__name__ == "Distance" for joint in system.joints)
    arms = {wire.body: world(wire.points, wire.body, poses) for wire in drawing.wires if wire.layer == "bodies"}
    assert np.allclose(arms[1][::3], move(a.centre), rtol=0, atol=1e-12) and np.isnan(arms[1][2::3]).all()
    assert np.linalg.norm(arms[4] - move(at_b), axis=1)[-1] < 1e-12


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_pictures_of_small_and_large_things_are_the_same(scale):
    def model(length):
        shape = Box(length * np.array((0.3, 0.4, 0.9)), at=(0.0, 0.0, 0.2 * length))
        body = Body("b", 1.0, (1, 2, 2), com=(0.0, 0.1 * length, 0.0), position=(0, 0, length), shape=shape)
        return System([body], [Revolute(GROUND, body, at=(0, 0, 2 * length), axis=(1, 2, 2))])

    one, other = draw_system(model(1.0)), draw_system(model(scale))
    assert (other.size, other.floor) == pytest.approx((scale * one.size, scale * one.floor), rel=1e-9)
    for a, b in zip((*one.pieces, *one.wires), (*other.pieces, *other.wires), strict=True):
        first, second = (x.mesh.vertices if hasattr(x, "mesh") else x.points for x in (a, b))
        assert np.allclose(scale * first, second, rtol=1e-9, atol=1e-9 * scale, equal_nan=True)


def test_the_least_of_systems_and_a_long_chain_are_drawn():
    point = draw_system(System([Body("pin", 0.0, (0, 0, 0), com=(0.1, 0, 0), position=(0, 0, 5))]))
    assert point.size == 1.0 and len(layer(point, "bodies")) == 1 and point.floor == 5.0
    wire = System([Body("wire", 1.0, (1, 1, 1), shape=[(0, 0, 0), (0, 0, 2)])])
    drawing = draw_system(wire)
    assert layer(drawing, "bodies") == [] and drawing.size == 2.0 and drawing.wires[0].layer == "bodies"
    drawing = draw_system(revolute_chain(100))
    assert len(layer(drawing, "bodies")) == len(layer(drawing, "joints")) == 100
    barrel = np.ptp(layer(drawing, "joints")[7].mesh.vertices, axis=0).max()
    assert (
        barrel < np.ptp(layer(drawing, "bodies")[7].mesh.vertices, axis=0).max()
    )  # sized after the links, not the chain


@pytest.mark.parametrize(("radius", "lines"), [(0.002, 1), (0.02, 0)])
def test_what_is_too_thin_for_a_screen_is_a_line_too(radius, lines):
    """Of 5 m in a window 1000 pixels wide 4 mm are less than one: a page showed nothing there."""
    axis, centre = np.array([0.6, -0.48, 0.64]), np.array([0.3, 0.2, -0.4])
    body = Body("needle", 1.0, (2.0, 2.0, 0.1), com=centre, position=(1, 2, 3), shape=Cylinder(radius, 5.0, axis=axis))
    wires = draw_system(System([body])).wires
    assert len(wires) == lines
    for wire in wires:
        ends = wire.points if (wire.points[1] - wire.points[0]) @ axis > 0.0 else wire.points[::-1]
        assert np.allclose(ends, centre + np.outer([-2.5, 2.5], axis), rtol=0, atol=radius)


def test_two_drawings_are_the_same():
    first, second = (draw_system(all_joints_mechanism(3)) for _ in range(2))
    assert repr(first) == repr(second)
    pairs = zip(first.pieces, second.pieces, strict=True)
    assert all(np.array_equal(a.mesh[k], b.mesh[k]) for a, b in pairs for k in range(3))


def test_what_cannot_be_drawn_names_the_body():
    body = Body("crank", 1.0, (1, 1, 1), shape=MeshFile("none.stl"))
    with pytest.raises(ValueError, match="body 'crank': MeshFile 'none.stl': cannot be read: .*; give a file that exi"):
        draw_system(System([body]))
    with pytest.raises(ValueError, match="state has 2 bodies, the system 1; give a state of this system"):
        poses_of(System([body]), State(0.0, np.ones(14), np.zeros(12)))


@pytest.mark.parametrize(
    ("places", "named"),
    [
        ([(0.3, -0.1, 0.2)], True),
        ([(0, 0, 0), (0.4, 1.0, -0.7)], True),
        ([(0, 0, 0), (0.4, 1.0, -0.7), (0.41, 1.02, -0.7)], False),  # one name would lie on the other
        ([(0.2, 0.1, 0.3)] * 2, False),
        ([(k, 0.3 * k, 0) for k in range(12)], True),
        ([(k, 0.3 * k, 0) for k in range(13)], False),
    ],
)
def test_names_that_would_hide_the_scene_wait_for_their_switch(places, named):
    system = System([Body(f"body {k}", 1.0, (1, 1, 1), position=place) for k, place in enumerate(places)])
    assert ("body names" in page_layers(system, Layers())) == named
    assert "body names" in page_layers(system, Layers(shown="body names"))
    assert "body names" not in page_layers(system, Layers(hidden="body names"))


def test_limits_of_a_stop_are_drawn_where_they_are():
    part, axis = Body("part", 1.0, (0.1, 0.1, 0.1), position=(0.4, 0.2, 0.1)), np.array([1.0, -2.0, 2.0]) / 3.0
    hinge = Revolute(GROUND, part, at=(0.1, -0.2, 0.3), axis=axis)
    system = System([part], [hinge], [EndStop(hinge, lower=-0.4, upper=0.9, stiffness=400.0, name="stop")])
    wires = [wire for wire in draw_system(system).wires if wire.name == "stop"]
    on_a = [wire.points[1] - wire.points[0] for wire in wires if wire.body == 1]
    angle = np.arctan2(np.cross(*on_a) @ axis, on_a[0] @ on_a[1])
    assert angle == pytest.approx(1.3, abs=1e-12) and len(wires) == 3


def test_the_rim_is_drawn_at_the_half_angle():
    body = Body("arm", 1.4, (0.2, 0.3, 0.12), com=(0.1, 0.2, -0.4))
    ball = Spherical(GROUND, body, at=(0.1, 0.2, 0.3))
    stop = ConeStop(ball, axis_a=(1, 2, 2), half_angle=0.5, stiffness=300.0, name="stop")
    rim, hand = (wire for wire in draw_system(System([body], [ball], [stop])).wires if wire.name == "stop")
    away = rim.points - [0.1, 0.2, 0.3]
    assert away @ stop.axis_a / np.linalg.norm(away, axis=1) == pytest.approx(np.cos(0.5), abs=1e-12)
    assert rim.body == 1 and hand.body == 0
