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
    Belt,
    Body,
    Clutch,
    ConeStop,
    EndStop,
    GearMesh,
    Joint,
    Prismatic,
    Revolute,
    Rolling,
    RollingDisc,
    RotationStop,
    Spherical,
    SpringDamper,
    State,
    SumSpring,
    SumStop,
    System,
    rotation,
    simulate,
)
from mbsd3d.rotations import matrix, multiply
from mbsd3d.shapes import Box, Cylinder, Disc, MeshFile
from mbsd3d.view.page.show import page_layers
from mbsd3d.view.scene.artist import draw_system
from mbsd3d.view.scene.drawing import DEFAULT_LAYERS, Layers, poses_of
from mbsd3d.view.scene.frames import frames_at
from mbsd3d.view.scene.overlays import arrows_of

LAYERS = {"bodies", "joints", "inertia ellipsoids", "centre of mass", "reference point"}


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


@pytest.mark.parametrize("crossed", [False, True])
def test_strands_of_a_belt_are_tangents_of_its_pulleys(crossed):
    """In a pose in which an arm has turned one pulley about the other; both circles are drawn to scale."""
    axis, along = np.array([1.0, 2.0, -2.0]) / 3.0, np.array([2.0, 1.0, 2.0]) / 3.0
    arm, one, two = (
        Body("arm", 1.0, (1, 1, 1)),
        Body("one", 1.0, (1, 1, 1)),
        Body("two", 1.0, (1, 1, 1), position=along),
    )
    first, second = Revolute(GROUND, one, at=(0, 0, 0), axis=axis), Revolute(arm, two, at=along, axis=-axis)
    swing = Revolute(GROUND, arm, at=(0, 0, 0), axis=axis)
    radii = (0.3, 0.2)
    belt = Belt(first, second, radii=radii, stiffness=1.0, crossed=crossed, name="belt")
    system = System([arm, one, two], [swing, first, second], [belt])
    r, e = poses_of(system, system.assemble(angles={swing: 0.7, first: 1.1, second: -0.4}))
    drawing = draw_system(system)
    assert len(drawing.links) == 2
    centres = np.array([[0, 0, 0], np.cos(0.7) * along + np.sin(0.7) * np.cross(axis, along)])
    sides = []
    for k, link in enumerate(drawing.links):
        ends = np.array(link.placed(lambda body, point: matrix(e[body]) @ point + r[body]))
        order = [0, 1] if k == 0 else [1, 0]
        arms = ends - centres[order]
        assert np.linalg.norm(arms, axis=1) == pytest.approx(np.array(radii)[order], abs=1e-12)
        assert arms @ (ends[1] - ends[0]) == pytest.approx([0, 0], abs=1e-12) and abs(arms @ axis).max() < 1e-12
        assert (arms[0] @ arms[1] < 0.0) == crossed
        sides.append(arms[0] @ np.cross(axis, centres[1]))
    assert sides[0] * sides[1] * (-1.0 if crossed else 1.0) < 0.0
    rims = [x for x in drawing.pieces if x.name == "belt" and np.ptp(x.mesh.vertices, axis=0).max() > 0.35]
    seen = {x.body: np.linalg.norm(x.mesh.vertices, axis=1).max() for x in rims}
    assert seen[1] == pytest.approx(0.3, rel=1e-3) and seen[2] == pytest.approx(0.2, rel=1e-3)


def held(count, **options):
    """A body with r_G != 0, turned, with ``count`` balls to the ground, and their places."""
    rng = np.random.default_rng(8)
    body = Body("link", 2.0, (0.02, 0.03, 0.04), com=(0.1, -0.2, 0.3), position=rng.normal(size=3),
                orientation=random_orientation(rng), **options)  # fmt: skip
    places = rng.normal(size=(count, 3))
    return System([body], [Spherical(GROUND, body, at=at) for at in places]), np.vstack([places, body.centre])


@pytest.mark.parametrize("count", [2, 3, 5])
def test_a_body_without_a_shape_is_a_link_between_its_joints(count):
    """The mesh holds every joint and the centre of mass, and in any direction goes beyond them by one radius."""
    system, places = held(count)
    drawing, poses = draw_system(system), poses_of(system)
    own = layer(drawing, "bodies")
    assert len(own) == 1
    corners = world(own[0].mesh.vertices, 0, poses)
    ways = np.random.default_rng(9).normal(size=(50, 3))
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    beyond = (corners @ ways.T).max(axis=0) - (places @ ways.T).max(axis=0)
    radius = beyond.max()
    assert 0.0 < radius < 0.02 * np.ptp(places, axis=0).max()
    assert beyond.min() > 0.96 * radius  # a ball of 24 by 12 faces lacks 1 - cos(7.5 deg) cos(7.5 deg) = 0.017 of it


def test_the_ellipsoid_of_a_link_is_a_hidden_layer():
    system, _ = held(2)
    body = system.bodies[0]
    shown = layer(draw_system(system), "inertia ellipsoids")
    alone = layer(draw_system(System([Body("link", 2.0, (0.02, 0.03, 0.04), com=(0.1, -0.2, 0.3))])), "bodies")
    assert np.allclose(shown[0].mesh.vertices, alone[0].mesh.vertices, rtol=0, atol=1e-15)
    assert shown[0].body == 0 and shown[0].name == body.name
    assert "inertia ellipsoids" not in Layers().visible(DEFAULT_LAYERS)
    assert "inertia ellipsoids" in Layers(shown="inertia ellipsoids").visible(DEFAULT_LAYERS)


@pytest.mark.parametrize("system", [held(1)[0], held(0)[0], held(2, shape=Box((0.1, 0.2, 0.3)))[0]])
def test_other_bodies_are_drawn_as_before(system):
    """With one joint or none, where a rod would show no turn, or with a shape of its own."""
    drawing = draw_system(system)
    whole = middle(layer(drawing, "bodies")[0].mesh.vertices)
    assert np.allclose(whole, system.bodies[0].com, rtol=0, atol=1e-12) and not layer(drawing, "inertia ellipsoids")


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


def test_the_hands_of_a_rotation_stop_come_to_their_rims_where_it_stops():
    """A turn by the limit about an axis across both hands leads both there; any other one leads neither beyond."""
    body = Body("arm", 1.4, (0.2, 0.3, 0.12), com=(0.1, 0.2, -0.4), position=(0.2, -0.1, 0.3))
    ball = Spherical(GROUND, body, at=(0.1, 0.2, 0.3))
    stop = RotationStop(ball, angle=0.7, stiffness=300.0, name="stop")
    wires = [wire for wire in draw_system(System([body], [ball], [stop])).wires if wire.name == "stop"]
    rims = [wire.points - [0.1, 0.2, 0.3] for wire in wires if wire.body == 1]
    hands = [wire.points[1] - wire.points[0] for wire in wires if wire.body == 0]
    lengths = [np.linalg.norm(hand) for hand in hands]
    directions = [hand / length for hand, length in zip(hands, lengths, strict=True)]
    assert directions[0] == pytest.approx((body.centre - ball.at) / np.linalg.norm(body.centre - ball.at), abs=1e-12)
    assert directions[0] @ directions[1] == pytest.approx(0.0, abs=1e-12)
    for rim, hand, length in zip(rims, directions, lengths, strict=True):
        assert rim @ hand == pytest.approx(np.full(len(rim), length * np.cos(0.7)), abs=1e-12)
    across = np.cross(*directions)
    for axis in (across, across + directions[0], (0.3, -0.8, 0.6)):
        moved = [np.arccos(hand @ matrix(rotation(axis, 0.7)) @ hand) for hand in directions]
        assert max(moved) <= 0.7 + 1e-12 and (axis is not across or moved == pytest.approx([0.7, 0.7], abs=1e-12))


@pytest.mark.parametrize(("kind", "spring"), [(SumStop, False), (SumSpring, True)])
def test_a_sum_over_joints_is_strung_from_one_to_the_next(kind, spring):
    bodies = [Body(f"part {k}", 1.0, (0.1, 0.1, 0.1), position=(0.3 * k, 0.1, 0.2), com=(0, 0, 0.1)) for k in range(3)]
    slides = [Prismatic(GROUND, body, at=body.position + (0, 0, 0.05), axis=(1, 2, 2)) for body in bodies]
    limit = {} if spring else {"upper": 0.4}
    string = kind(slides, weights=(1, -2, 0.5), stiffness=300.0, name="string", **limit)
    found = [link for link in draw_system(System(bodies, slides, [string])).links if link.name == "string"]
    assert [[body for body, _ in link.ends] for link in found] == [[0, 1], [1, 2]]
    assert all(link.spring == spring for link in found)
    for body, point in (end for link in found for end in link.ends):
        assert bodies[body].position + point == pytest.approx(slides[body].at, abs=1e-12)


def test_limits_of_a_sum_over_one_joint_are_those_of_its_slide():
    part, axis = Body("part", 1.0, (0.1, 0.1, 0.1), position=(0.4, 0.2, 0.1)), np.array([1.0, -2.0, 2.0]) / 3.0
    slide = Prismatic(GROUND, part, at=(0.1, -0.2, 0.3), axis=axis)
    stop = SumStop(slide, weights=(-2,), lower=-0.3, upper=0.8, stiffness=400.0, name="stop")
    wires = [wire for wire in draw_system(System([part], [slide], [stop])).wires if wire.name == "stop"]
    places = [(wire.points.mean(axis=0) - slide.at) @ axis for wire in wires if wire.body == 1]
    assert sorted(places) == pytest.approx([-0.4, 0.15], abs=1e-12) and len(wires) == 3


BOX = Box((1.0, 0.4, 0.6))


def world_wires(system, body):
    """The wires of the stop in the world at the reference pose, and the corners of the body in its axes."""
    found = []
    for wire in draw_system(system).wires:
        if wire.name == "stop":
            owner = (*system.bodies, GROUND)[wire.body]
            found.append(owner.position + wire.points @ matrix(owner.orientation).T)
    return found


def inside(points, body):
    """Whether points of the world lie in the box of the body."""
    local = (points - body.position) @ body.axes - body.com
    return (np.abs(local) < 0.5 * BOX.lengths).all(axis=1)


def along(wire):
    """Points along a polyline."""
    share = np.linspace(0.0, 1.0, 21)[:, None]
    return np.concatenate([(1.0 - share) * a + share * b for a, b in zip(wire[:-1], wire[1:], strict=True)])


@pytest.mark.parametrize("kind", ["angle", "slide", "cone"])
def test_thick_bodies_do_not_hide_the_marks_of_a_stop(kind):
    turn = rotation((0.4, -0.2, 0.9), 0.8)
    body = Body("block", 5.0, (1, 1, 1), com=(0.1, 0.05, 0.02), position=(0.3, -0.1, 0.2), orientation=turn, shape=BOX)
    x, y, z = body.axes.T
    numbers = {"stiffness": 1e3, "name": "stop"}
    if kind == "cone":
        joint = Spherical(GROUND, body, at=body.centre)
        stop = ConeStop(joint, axis_a=x, axis_b=x, half_angle=0.3, **numbers)
    else:
        joint = (Revolute if kind == "angle" else Prismatic)(GROUND, body, at=body.centre, axis=z)
        stop = EndStop(joint, lower=-0.2, upper=0.25, **numbers)
    wires = world_wires(System([body], [joint], [stop]), body)
    assert len(wires) == (2 if kind == "cone" else 3)
    for wire in wires:  # all of an instrument's hands, the ends of bars, the whole rim and the tip in it
        hidden = inside(along(wire), body)
        assert not hidden.any() if kind == "angle" or len(wire) > 2 else not hidden[-1]


def test_what_is_engaged_has_an_arrow_while_it_holds():
    one = Body("one", 1.0, (0.3, 0.3, 0.5), omega=(0, 0, 6.5))
    two = Body("two", 1.0, (0.6, 0.6, 1.0), position=(0, 0, 0.4), omega=(0, 0, 0))
    shaft = Revolute(GROUND, one, at=(0, 0, 0), axis=(0, 0, 1), name="shaft")
    bearing = Revolute(one, two, at=(0, 0, 0.1), axis=(0, 0, 1), name="bearing")
    clutch = Clutch(bearing, torque=2.0, engaged=True, name="clutch")
    run = simulate(System([one, two], [shaft, bearing], [clutch]), 2.0, output=41)
    frames = frames_at(run, np.array([0.2, 1.0, 1.2, 1.9]))  # it locks at 1.083 s
    (arrows,) = (x for x in arrows_of(run, frames) if x.kind == "engaged")
    assert arrows.names == ["clutch"] and arrows.vectors[:, 0, 2].tolist() == [0.0, 0.0, 1.0, 1.0]
    assert arrows.points[:, 0] == pytest.approx(np.tile([0, 0, 0.1], (4, 1)), abs=1e-9)
    assert run.picture(1.9, shown=["engaged"]).axes
