"""Pictures: points land where the camera's equations put them, near hides far, the same bytes twice."""

import io
from dataclasses import replace

import matplotlib.pyplot
import numpy as np
import pytest
from helpers.double_pendulum import LOWER_ARM, UPPER_ARM, WHEEL, pendulum
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from PIL import Image

from mbsd3d import GROUND, AngleDriver, Body, Ramp, Revolute, System, inertia, save_figure, simulate
from mbsd3d.base.style import muted_colour
from mbsd3d.extend import theme
from mbsd3d.rotations import matrix
from mbsd3d.shapes import Box, Sphere
from mbsd3d.view.picture.painter import Mosaic, Painter, new_sheet
from mbsd3d.view.picture.picture import painter_of
from mbsd3d.view.picture.shading import Solids, outlines, pointers_of, split_strokes, split_triangles
from mbsd3d.view.scene.artist import draw_system
from mbsd3d.view.scene.camera import Camera, frame_camera, lens_of, round_down, turned, window
from mbsd3d.view.scene.drawing import bounds, poses_of
from mbsd3d.view.scene.frames import frames_of
from mbsd3d.view.scene.overlays import arrows_of, traces_of

NAMES = ("body names", "joint names")

HIDDEN, BARE = (*NAMES, "ground grid"), ("bodies", "joints")
CAMERA = Camera(np.array([2.3, -3.1, 1.7]), np.array([0.2, 0.4, -0.3]), 4.5)


@pytest.fixture(scope="module")
def solution():
    """0.2 s of the pendulum."""
    return simulate(pendulum(), 0.2, output=21)


def seen_by(camera: Camera, points: np.ndarray) -> np.ndarray:
    """(k, 2) projection by the inverse of the camera's own frame, columns right, down, forward and place."""
    forward = camera.look_at - camera.position
    frame = np.eye(4)
    frame[:3, 2] = forward / np.sqrt(forward @ forward)
    frame[:3, 0] = np.array([frame[1, 2], -frame[0, 2], 0.0]) / np.hypot(*frame[:2, 2])
    frame[:3, 1] = np.cross(frame[:3, 2], frame[:3, 0])
    frame[:3, 3] = camera.position
    x, y, z, _ = np.linalg.solve(frame, np.column_stack([points, np.ones(len(points))]).T)
    return np.column_stack([x / z, -y / z])


def test_points_land_where_the_camera_puts_them():
    points = np.random.default_rng(3).uniform(-1.0, 1.0, (40, 3))
    found, depth = lens_of(CAMERA).project(points)
    assert np.allclose(found, seen_by(CAMERA, points), rtol=0, atol=1e-13)  # rounding
    assert np.all(depth > 0.0)
    above = lens_of(CAMERA).project(CAMERA.look_at + np.array([[0.0, 0.0, 0.1]]))[0][0]
    assert above[1] > 0.0 and abs(above[0]) < 1e-15


def test_a_turned_camera_stands_where_it_was_told_to():
    towards = turned(CAMERA, 30.0, 20.0).position - CAMERA.look_at
    assert np.degrees(np.arctan2(towards[1], towards[0])) == pytest.approx(30.0)
    assert np.degrees(np.arcsin(towards[2] / 4.5)) == pytest.approx(20.0)
    assert np.linalg.norm(towards) == pytest.approx(4.5)


def test_the_window_holds_all_and_has_the_ratio_of_the_paper():
    points = np.random.default_rng(4).normal(size=(30, 2)) * (3.0, 1.0)
    low, high = window(points, (6.0, 4.0))
    assert np.all(points > low) and np.all(points < high)
    assert (high - low)[0] / (high - low)[1] == pytest.approx(1.5)
    left = np.concatenate([points.min(axis=0) - low, high - points.max(axis=0)]) / np.tile(high - low, 2)
    assert left.min() == pytest.approx(0.06)  # of air, on every side
    assert np.all(np.ptp(window(np.zeros((1, 2)), (6.0, 4.0)), axis=0) > 0.0)  # a point is not blown up to infinity
    assert [round_down(x) for x in (0.1, 0.19, 0.2, 7.3, 1e-4)] == [0.1, 0.1, 0.2, 5.0, 1e-4]
    assert round_down(0.2 * (1.0 - 1e-12)) == 0.2  # rounding takes no step


def test_marks_of_the_bodies_lie_on_the_paper_where_they_should(solution):
    state = solution.state(13)
    r, e = poses_of(solution.system, state)
    painter = Painter(draw_system(solution.system), lens_of(CAMERA), r[None], e[None], (5.0, 4.0))
    axle = solution.body_point(solution.system.part(WHEEL), np.array([-0.4, 0.3, 0.2]))[13]
    spots = np.array([*(solution.com(name)[13] for name in (UPPER_ARM, LOWER_ARM, WHEEL)), axle])
    drawn = painter.on_paper(
        np.array([R @ t.point + p for t, R, p in of_tags(draw_system(solution.system).tags, r, e) if t.text != "elbow"])
    )
    expected = (seen_by(CAMERA, spots) - painter.corner) * painter.scale
    assert np.allclose(drawn[[0, 1, 2]], expected[:3], rtol=0, atol=1e-9) and np.allclose(
        drawn[4], expected[3], rtol=0, atol=1e-9
    )
    assert np.all(drawn > 0) and np.all(drawn < (360.0, 288.0))


def of_tags(tags: list, r: np.ndarray, e: np.ndarray) -> list[tuple]:
    """Names with the poses of their bodies."""
    R = matrix(e)
    return [(tag, R[tag.body], r[tag.body]) for tag in tags]


BOXES = [((0.9, 0.1, 0.0), (0.2, 0.5, 0.5), "#ff0000"), ((-0.6, 0.0, 0.1), (0.2, 1.3, 1.3), "#0000ff")]


def first_hit(eye: np.ndarray, ray: np.ndarray) -> int:
    """Which of the boxes a ray meets first: 0 or 1; -1 = none. By the slabs between opposite faces."""
    meets = []
    for centre, lengths, _ in BOXES:
        ends = (np.array(centre) + np.outer((-0.5, 0.5), lengths) - eye) / ray
        enter, leave = ends.min(axis=0).max(), ends.max(axis=0).min()
        meets.append(enter if enter < leave else np.inf)
    return int(np.argmin(meets)) if min(meets) < np.inf else -1


@pytest.mark.parametrize(("azimuth", "elevation"), [(1.0, 10.0), (35.0, 5.0), (179.0, 20.0), (150.0, -15.0)])
def test_the_nearer_of_two_boxes_hides_the_other(azimuth, elevation):
    bodies = [Body(tint, 1.0, (1, 1, 1), position=place, shape=Box(size, colour=tint)) for place, size, tint in BOXES]
    r, e = poses_of(System(bodies))
    lens = lens_of(turned(CAMERA, azimuth, elevation))
    painter = Painter(draw_system(System(bodies)), lens, r[None], e[None], (4.0, 3.0), layers=BARE)
    figure, axes = new_sheet((4.0, 3.0), theme(False))
    painter.paint(axes, [(r, e)])
    image, seen = pixels_of(figure), []
    for x, y in np.random.default_rng(8).uniform((40, 40), (360, 260), (400, 2)).astype(int):
        around = []  # only where all around is the same: not at edges, whose lines have a width
        for dx, dy in ((0, 0), (4, 0), (-4, 0), (0, 4), (0, -4)):
            paper = (np.array([x + dx, y + dy]) + 0.5) * 0.72 / painter.scale + painter.corner
            around.append(first_hit(lens.eye, np.array([*paper, 1.0]) @ lens.axes))
        if len(set(around)) == 1:
            red, green, blue = image[299 - y, x].astype(int)
            shown = -1 if min(red, green, blue) > 250 else (0 if red > blue else 1)
            if abs(red - blue) > 60 or shown == -1:  # neither outline nor direction mark
                seen.append((shown, around[0]))
    assert len(seen) > 200 and {x for _, x in seen} >= {-1, 1}
    assert all(shown == expected for shown, expected in seen)


def pixels_of(figure: Figure) -> np.ndarray:
    """(height, width, 3) image."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png")
    return np.array(Image.open(buffer).convert("RGB"))


def test_small_triangles_make_up_the_large_one():
    given = np.random.default_rng(5).normal(size=(3, 3, 3))
    parts, parent = split_triangles(given, np.array([0.2, 0.4, 9.0]))
    edges = np.linalg.norm(np.roll(parts, -1, axis=1) - parts, axis=2).max(axis=1)
    assert np.all(edges <= np.array([0.2, 0.4, 9.0])[parent]) and (parent == 2).sum() == 1
    cross = np.cross(parts[:, 1] - parts[:, 0], parts[:, 2] - parts[:, 0])
    whole = np.cross(given[:, 1] - given[:, 0], given[:, 2] - given[:, 0])
    for k in range(3):  # vectors of area: their sum says that nothing overlaps and no part is turned over
        assert np.allclose(cross[parent == k].sum(axis=0), whole[k], rtol=0, atol=1e-12)
        assert np.allclose(np.linalg.norm(cross[parent == k], axis=1).sum(), np.linalg.norm(whole[k]))
    strokes, _ = split_strokes(given[:, :2], 0.3)
    lengths = np.linalg.norm(strokes[:, 1] - strokes[:, 0], axis=1)
    assert lengths.max() <= 0.3 and lengths.sum() == pytest.approx(
        np.linalg.norm(given[:, 1] - given[:, 0], axis=1).sum()
    )


def test_a_box_shows_three_faces_and_nine_edges():
    drawing = draw_system(System([Body("box", 1.0, (1, 1, 1), shape=Box((0.3, 0.5, 0.7)))]))
    solids = Solids([piece for piece in drawing.pieces if piece.layer == "bodies"], 100.0)
    items = solids.placed(np.zeros((1, 3)), np.eye(3)[None], lens_of(CAMERA), 1.0)
    assert np.sum(items.width == 0.0) == 6 and np.sum(items.width > 0.0) == 9
    centres = items.corners[items.width == 0.0].mean(axis=1)
    outward = np.sign(CAMERA.position)
    assert np.all((centres * outward).max(axis=1) > 0.14)  # the faces towards the eye


def test_a_round_body_is_lit_from_above_left_and_shows_its_two_tints():
    image = pixels_of(
        System([Body("ball", 1.0, (1, 1, 1), shape=Sphere(1.0, colour="#808080"))]).picture(hidden=HIDDEN)
    )
    ball = image[..., 0].astype(float)
    rows, columns = np.nonzero(ball < 250)
    y, x = rows.mean(), columns.mean()
    height = np.ptp(rows)
    lit = ball[int(y - height / 4), int(x - height / 5)]
    shade = ball[int(y + height / 3), int(x + height / 5)]
    assert lit > shade + 30
    assert len(np.unique(ball[rows, columns].astype(int) // 8)) > 8


def test_strokes_become_bars_of_their_width():
    corners = np.array([[[0, 0], [3, 4], [3, 4]], [[0, 0], [1, 0], [0, 1]]], float)
    bar, triangle = outlines(corners, np.array([2.35, 0.0]))
    assert np.linalg.norm(bar[1] - bar[2]) == pytest.approx(2.0)  # and the line around it makes up the rest
    assert np.array_equal(triangle, corners[1][[0, 1, 2, 2]])


def test_names_lie_at_their_points_and_on_the_paper():
    rod = Body("a rod with a long name", 1.0, (0.1, 0.1, 0.01), position=(0.0, 0, 0))
    ring = Body("ring", 1.0, (0.1, 0.1, 0.1), position=(0.0, 0, 0))
    hinge = Revolute(GROUND, rod, at=(2.0, 0, 0), axis=(0, 1, 0), name="hinge")
    system = System([rod, ring], [hinge, AngleDriver(hinge, Ramp(1.0), name="motor")])
    figure = system.picture()
    drawing, (r, e) = draw_system(system), poses_of(system)
    lens = lens_of(frame_camera(*bounds(drawing, r[None], e[None])))
    painter = Painter(
        drawing,
        lens,
        r[None],
        e[None],
        (6.4, 4.8),
        layers=("bodies", "joints", "springs and rods", "traces", "ground grid", *NAMES),
    )
    written = {text.get_text(): text for text in figure.axes[0].texts}
    bodies, joints = (
        written["a rod with a long name, ring"],
        written["hinge, motor"],
    )  # what lies together shares a line
    for text, point, side in ((bodies, (0.0, 0, 0), 1.0), (joints, (2.0, 0, 0), -1.0)):
        at = painter.on_paper(np.array(point))
        box = text.get_window_extent(FigureCanvasAgg(figure).get_renderer()).get_points() * 72.0 / figure.dpi
        assert np.all(box[0] >= 0) and np.all(box[1] <= 72.0 * np.array([6.4, 4.8]))
        gap = box[0, 1] - at[1] if side > 0 else at[1] - box[1, 1]
        assert 0.0 < gap < 9.0 and box[0, 0] <= at[0] <= box[1, 0]  # less than a letter away


def test_arrows_are_to_scale_and_say_how_long_they_are():
    door = Body("door", 20.0, (8.0, 9.0, 1.0), position=(0.45, 0.1, 1.0), omega=(0, 0, 1))
    hinges = [
        Revolute(GROUND, door, at=(0, 0, z), axis=(0, 0, 1), name=name) for z, name in ((0.2, "low"), (1.8, "up"))
    ]
    run = simulate(System([door], hinges), 0.05, output=6)
    forces = next(x for x in arrows_of(run, frames_of(run, 6)) if x.kind == "reaction force")
    pointers = pointers_of(forces, 3, 0.8, lens_of(CAMERA))
    longest = np.linalg.norm(np.stack([run.reaction(j).force for j in hinges]), axis=-1).max()
    assert forces.longest == pytest.approx(longest)
    assert pointers.legend == f"reaction force, longest {longest:.3g} N, pale: not unique"
    assert pointers.pieces[0].colour == muted_colour(forces.colour) != forces.colour
    tip = run.reaction("low").point[3] + 0.8 / longest * run.reaction("low").force[3]
    reached = np.linalg.norm(pointers.pieces[0].mesh.vertices - tip, axis=1).min()
    assert reached < 1e-9  # the frames are the samples


def test_an_arrow_within_a_solid_is_seen():
    """A pin in the middle of a ball: the legend gave a length, and nothing was seen of it."""
    ball = Body("ball", 3.0, (0.3, 0.3, 0.3), position=(0.1, 0.2, 0.4), shape=Sphere(0.5))
    run = simulate(System([ball], [Revolute(GROUND, ball, at=(0.1, 0.2, 0.4), axis=(0, 1, 0.2))]), 0.1, output=3)
    red, green, blue = pixels_of(run.picture(shown="reaction force", hidden=HIDDEN)).astype(int).transpose(2, 0, 1)
    assert ((red > 2 * blue) & (red > green + 40)).sum() > 1000  # orange; the ball is blue


def test_picture_of_a_moment(solution):
    figure = solution.picture(0.1234, shown="reaction force", traces=[(LOWER_ARM, (0.32, 0.1, -0.4))])
    assert isinstance(figure, Figure) and not matplotlib.pyplot.get_fignums()
    texts = {text.get_text() for text in figure.axes[0].texts}
    assert {UPPER_ARM, LOWER_ARM, WHEEL, "shoulder", "elbow", "axle, motor", "t = 0.1234 s"} <= texts
    assert any(text.startswith("reaction force, longest ") for text in texts) and any("grid" in x for x in texts)
    assert "t = 0.2 s" in {text.get_text() for text in solution.picture().axes[0].texts}


def test_several_moments_in_one_picture(solution):
    one, three = (solution.picture(t, traces=(), hidden=HIDDEN) for t in (0.2, [0.0, 0.1, 0.2]))
    few, many = (polygons(figure) for figure in (one, three))
    assert 2.5 * few < many < 3.5 * few  # as many front faces in every pose, within a few
    assert "t = 0, 0.1, 0.2 s" in {text.get_text() for text in three.axes[0].texts}


def polygons(figure: Figure) -> int:
    """Painted triangles and strokes."""
    plain = [len(c.get_paths()) for c in figure.axes[0].collections if isinstance(c, PolyCollection)]
    return max(plain + [len(c.triangles) for c in figure.axes[0].get_children() if isinstance(c, Mosaic)])


@pytest.mark.slow
def test_files_of_pictures_are_the_same_bytes_twice(solution, tmp_path):
    first, second = (save_figure(solution.picture(0.1), tmp_path / name, pdf=True) for name in "ab")
    assert [path.suffix for path in first] == [".png", ".svg", ".pdf"]
    for a, b in zip(first, second, strict=True):
        assert a.read_bytes() == b.read_bytes()
        assert b"Date" not in a.read_bytes() and a.stat().st_size < 750_000


def test_a_path_seen_from_the_ground_is_that_without_a_base(solution):
    at = (0.32, 0.1, -0.4)
    plain, *seen = (
        pixels_of(solution.picture(traces=[(LOWER_ARM, at, *base)])) for base in ((), (GROUND,), ("ground",))
    )
    assert all(np.array_equal(plain, x) for x in seen)
    with pytest.raises(ValueError, match="'graund' is not one of the bodies"):
        solution.picture(traces=[(LOWER_ARM, at, "graund")])


def test_dark_paper_and_layers(solution):
    figure = solution.system.picture(dark=True)
    assert figure.get_facecolor()[:3] == pytest.approx(matplotlib.colors.to_rgb(theme(True).paper))
    assert pixels_of(figure).mean() < 80
    bare, marked = (
        solution.system.picture(**x)
        for x in ({"hidden": ["bodies", "joints"]}, {"shown": ("centre of mass", "reference point")})
    )
    assert polygons(bare) < polygons(marked)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"size": 3}, "size: 3 is not a pair"),
        ({"size": (1e6, 3)}, "size = 1e.06 x 3 inch; give at most 100 each way"),
        ({"size": (3, -1)}, "size: -1.0 is not positive"),
        ({"view": (1, 2, 3)}, "view: .* is not a pair"),
        ({"view": (0, 90)}, "elevation = 90; give -89"),
        ({"hidden": ("body",)}, "hidden: layer 'body' is unknown; give some of bodies"),
        ({"shown": ["force"]}, "shown: layer 'force' is unknown; give some of bodies"),
        ({"t": 0.3}, "t = 0.3 s is outside the run"),
        ({"t": []}, "give a time"),
        ({"t": "end"}, "t = 'end'; give a time"),
        ({"dark": "yes"}, "dark 'yes' is unknown; give True or False"),
        ({"traces": [("foot", (0, 0, 0))]}, "'foot' is not one of the bodies"),
        ({"traces": [(LOWER_ARM, (0, 0, 0), "foot")]}, "'foot' is not one of the bodies"),
        ({"traces": [(LOWER_ARM, (0, 0, 0), LOWER_ARM, 1)]}, "body from which it is seen"),
    ],
)
def test_pictures_refuse(solution, options, message):
    with pytest.raises(ValueError, match=message):
        solution.picture(**options)


def test_a_state_of_another_system_is_refused(solution):
    with pytest.raises(ValueError, match="state has 3 bodies, the system 1"):
        System([Body("stone", 1.0, (1, 1, 1))]).picture(solution.final)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e4])
def test_small_large_and_bare_systems(size):
    rod = Body("rod", 2.0, inertia.rod(2.0, size, "x"), position=(3 * size, 0, 0))
    point = Body("point", 0.0, (0, 0, 0), position=(0, size, 0))
    for system in (System([rod]), System([point]), System([rod, replace(point, name="other")])):
        image = pixels_of(system.picture())
        assert image.min() < 120  # something is drawn
    grid = next(x.get_text() for x in System([rod]).picture().axes[0].texts if "grid" in x.get_text())
    assert grid == {1e-3: "grid 0.2 mm", 1.0: "grid 0.2 m", 1e4: "grid 2 km"}[size]


def test_a_time_next_to_a_sample_is_that_sample(solution):
    almost = np.nextafter(solution.t[7], 1.0)
    assert np.array_equal(solution.at(float(almost)).q, solution.state(7).q)


@pytest.mark.parametrize("view", [None, (200.0, 15.0), (-60.0, -30.0)])
@pytest.mark.parametrize("velocity", [(-2.0, 6.0, 3.0), (31.0, -47.0, -19.0), (7.0, 0.4, 0.2)])
def test_a_path_from_behind_the_camera_is_before_it(velocity, view):
    """A point behind the eye would be drawn anywhere."""
    stone = Body("stone", 5.0, (0.4, 0.5, 0.6), velocity=velocity, omega=(0.3, 0.2, 0.7))
    motion, layers = simulate(System([stone]), 2.0, output=9), ("bodies", "traces")
    run = frames_of(motion, 40)
    paths = traces_of(motion, run)
    last = run.r[-1:], run.e[-1:]
    painter, _ = painter_of(
        System([stone]), *last, (6.4, 4.8), paths=paths, layers=layers, view=view, dark=False, drawn=slice(None)
    )
    seen, depth = painter.lens.project(paths[0].points)
    assert depth.min() > 0.1 * painter.lens.distance and np.abs(seen).max() < 6.0


def test_a_path_seen_from_a_body_is_drawn_where_the_body_is(solution):
    run = frames_of(solution, 9)
    at = np.array([0.32, 0.1, -0.4])
    alone, seen = traces_of(solution, run, [(WHEEL, at), (WHEEL, at, LOWER_ARM)])
    for k in range(run.t.size):  # where the carrier has it now, the point itself is
        now = seen.at(run.r[k], run.e[k])[k]
        np.testing.assert_allclose(now, alone.points[k], rtol=0.0, atol=1e-14)


def test_a_name_with_dollars_is_written_as_it_is():
    """Read as a formula, this one is an error of matplotlib's."""
    bead = System([Body("ma$$e_1", 1.0, (0.1, 0.1, 0.1), omega=(1.0, 0.3, 0.2))])
    figure = simulate(bead, 0.1, output=3).picture(shown=["body names"])
    figure.savefig(io.BytesIO())
    assert len(figure.axes) == 1
