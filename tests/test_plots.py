"""Figures: units on every axis, the same bytes twice, and drawn bodies as large as the real ones."""

import re

import matplotlib.pyplot
import numpy as np
import pytest
from matplotlib.animation import PillowWriter
from matplotlib.figure import Figure
from PIL import Image
from test_files import LOWER_ARM, UPPER_ARM, WHEEL, pendulum

from mbsd3d import GROUND, Body, Revolute, RollingDisc, System, accelerations, inertia, measures, rotation, simulate
from mbsd3d.animation import Scene, animate, nearest
from mbsd3d.plots import PANELS, plot_quantity, save_figure, show_system
from mbsd3d.scene import outline


@pytest.fixture(scope="module")
def solution():
    """0.2 s of the pendulum."""
    return simulate(pendulum(), 0.2, output=21)


@pytest.mark.parametrize("quantity", [quantity for quantity in PANELS if quantity not in ("slide", "state")])
def test_every_axis_has_a_unit_and_nothing_is_cut(solution, quantity):
    figure = plot_quantity(solution, quantity)
    assert isinstance(figure, Figure) and not matplotlib.pyplot.get_fignums()
    figure.draw_without_rendering()
    assert all(re.search(r"\[.+\]$", axes.get_ylabel()) for axes in figure.axes)
    assert figure.axes[-1].get_xlabel() == "time [s]"
    for axes in figure.axes:
        for text in (axes.yaxis.label, axes.xaxis.label):
            box = text.get_window_extent()
            assert box.x0 >= 0 and box.y0 >= 0 and box.y1 <= figure.bbox.height


def test_one_part_shows_components_and_several_are_compared(solution):
    one, two = solution.plot("position", WHEEL), solution.plot("position", UPPER_ARM, LOWER_ARM)
    assert [line.get_label() for line in one.axes[0].lines] == ["x", "y", "z"] and len(one.axes) == 1
    assert [axes.get_ylabel() for axes in two.axes] == [f"position {k} [m]" for k in "xyz"]
    assert np.array_equal(two.axes[2].lines[1].get_ydata(), solution.position(LOWER_ARM)[:, 2])
    force, moment = solution.plot("reaction", "elbow").axes
    assert force.get_ylabel() == "reaction force of elbow [N]" and len(moment.lines) == 3
    assert np.array_equal(moment.lines[1].get_ydata(), solution.reaction("elbow").moment[:, 1])
    assert solution.plot("angle", "axle").axes[0].get_ylabel() == "angle of axle [rad]"


def test_a_figure_of_the_user_is_drawn_into(solution):
    figure = Figure()
    axes = figure.subplots(1, 2)
    assert plot_quantity(solution, "momentum", axes=axes) is figure and len(axes[1].lines) == 3
    with pytest.raises(ValueError, match="momentum of these parts needs 2 axes, not 1"):
        plot_quantity(solution, "momentum", axes=axes[0])


def test_refusals_name_what_there_is(solution):
    with pytest.raises(ValueError, match="quantity 'speed' is unknown; give one of energy, position, .*drift"):
        solution.plot("speed")
    with pytest.raises(ValueError, match="'foot' is not one of the bodies of this system; there are 'upper arm'"):
        solution.plot("com", "foot")
    with pytest.raises(ValueError, match="no joint of this system has the quantity slide"):
        solution.plot("slide")
    with pytest.raises(ValueError, match="energy is that of the whole system"):
        solution.plot("energy", WHEEL)


def test_shares_of_redundant_joints_are_marked():
    door = Body("door", 20.0, (8.0, 9.0, 1.0), position=(0.45, 0.0, 1.0), omega=(0, 0, 1))
    hinges = [
        Revolute(GROUND, door, at=(0, 0, z), axis=(0, 0, 1), name=name) for z, name in ((0.2, "low"), (1.8, "up"))
    ]
    figure = simulate(System([door], hinges), 0.05).plot("reaction")
    assert figure.axes[0].get_legend().get_title().get_text() == "not unique: low, up"


def test_one_sample_is_a_marked_point():
    line = accelerations(pendulum()).plot("alpha", WHEEL).axes[0].lines[0]
    assert line.get_marker() == "o" and line.get_xdata().size == 1


def test_drift_is_logarithmic_and_rounding_is_not_blown_up(solution):
    assert all(axes.get_yscale() == "log" for axes in solution.plot("drift").axes)
    low, high = solution.plot("position", UPPER_ARM, WHEEL).axes[0].get_ylim()
    assert high - low > 0.01  # both stand still


def test_files_are_the_same_bytes_twice(solution, tmp_path):
    for k, make in enumerate((lambda: solution.plot("reaction"), lambda: show_system(pendulum()))):
        first, second = (save_figure(make(), tmp_path / f"{name}{k}.v1") for name in "ab")
        assert [path.name for path in first] == [f"a{k}.v1.png", f"a{k}.v1.svg"]
        assert all(a.read_bytes() == b.read_bytes() for a, b in zip(first, second, strict=True))
        assert b"dc:date" not in first[1].read_bytes()


def test_picture_of_the_system(solution):
    axes = solution.system.show().axes[0]
    assert [axes.get_xlabel(), axes.get_ylabel(), axes.get_zlabel()] == ["x [m]", "y [m]", "z [m]"]
    names = {text.get_text().strip() for text in axes.texts}
    assert names == {UPPER_ARM, LOWER_ARM, WHEEL, "shoulder", "elbow", "axle", "motor"}
    grid = np.array(axes.lines[0].get_data_3d())
    drawn = [np.array(line.get_data_3d()[2]) for line in axes.lines]
    assert np.nanmax(grid[2]) == np.nanmin(np.concatenate(drawn))
    assert show_system(solution.system, solution.final).axes
    with pytest.raises(ValueError, match="state has 3 bodies, the system 1"):
        show_system(System([Body("stone", 1.0, (1, 1, 1))]), solution.final)


def extents(points: np.ndarray) -> np.ndarray:
    """Size along the axes."""
    return np.nanmax(points, axis=0) - np.nanmin(points, axis=0)


@pytest.mark.parametrize(
    ("moments", "size"),
    [
        (inertia.box(2.0, (0.3, 0.4, 0.7)), (0.3, 0.4, 0.7)),
        (inertia.cylinder(2.0, 0.2, 0.9, "y"), (0.4, 0.9, 0.4)),
        (inertia.cylinder(2.0, 0.35, 0.02, "x"), (0.02, 0.7, 0.7)),
        (inertia.rod(2.0, 1.5, "z"), (0.0, 0.0, 1.5)),
        (inertia.sphere(2.0, 0.3), (0.6, 0.6, 0.6)),
    ],
)
def test_simple_solids_are_drawn_in_their_size(moments, size):
    centre = np.array([0.1, -0.2, 0.3])
    points = outline(Body("solid", 2.0, moments, com=centre))
    # a circle is drawn with 48 chords: in turned principal axes it may miss its extreme by 1 - cos(pi / 48)
    assert np.allclose(extents(points), size, rtol=2.2e-3, atol=1e-8)
    assert np.allclose(np.nanmin(points, axis=0) + extents(points) / 2, centre, atol=2e-3 * max(size))


def test_an_own_shape_is_drawn_and_an_unknown_one_refused():
    frame = [(0, 0, 0), (1, 0, 0), (1, 1, 0)]
    assert np.array_equal(outline(Body("frame", 1.0, (1, 1, 1), shape=frame)), frame)
    assert extents(outline(Body("egg", 1.0, (1, 1, 1), shape="ellipsoid"))) == pytest.approx([np.sqrt(10)] * 3)
    assert outline(Body("pin", 0.0, (0, 0, 0))).shape == (0, 3)
    for shape in ("potato", {"a": 1}, [(0, 1)]):
        with pytest.raises(ValueError, match="body 'thing': shape .* is unknown; give 'ellipsoid'"):
            outline(Body("thing", 1.0, (1, 1, 1), shape=shape))


def test_the_contact_of_a_rolling_disc_travels():
    wheel = Body("wheel", 2.0, (0.06, 0.12, 0.06), position=(0, 0, 0.35), omega=(0, 8, 0))
    run = simulate(System([wheel], [RollingDisc(GROUND, wheel, axis=(0, 1, 0), radius=0.35)]), 0.5, output=6)
    scene = Scene(run.system)
    for k in range(run.t.size):
        contact = scene.lines(scene.pose(run.state(k)), 0.1)[-2][0]
        assert np.allclose(contact, [run.position(wheel)[k, 0], 0, 0], atol=1e-9)


def test_drawn_points_turn_with_the_body():
    arm = Body("arm", 1.0, inertia.rod(1.0, 2.0, "x"), position=(1, 2, 3), orientation=rotation("z", 90, degrees=True))
    scene = Scene(System([arm]))
    assert np.allclose(extents(scene.lines(scene.pose(None), 0.1)[0]), [0, 2, 0], atol=1e-9)


def test_animation_writes_its_frames(solution, tmp_path):
    film = animate(solution, fps=5, size=(4, 3))
    film.save(tmp_path / "motion.gif", writer=PillowWriter(fps=5))
    with Image.open(tmp_path / "motion.gif") as image:
        assert image.n_frames == 2 and image.size == (400, 300)


def test_frames_show_the_nearest_samples():
    t = np.array([0.0, 0.1, 0.4, 1.0])
    assert nearest(t, np.array([0.0, 0.04, 0.06, 0.26, 0.9, 1.0, 1.3])).tolist() == [0, 0, 1, 2, 3, 3, 3]
    assert nearest(np.array([2.0]), np.array([2.0, 2.1])).tolist() == [0, 0]


@pytest.mark.parametrize(
    ("options", "message"), [({"fps": 0}, "fps: 0"), ({"speed": -1}, "speed"), ({"size": (3,)}, "size")]
)
def test_animation_refuses(solution, options, message):
    with pytest.raises(ValueError, match=message):
        animate(solution, **options)


def test_a_stopped_run_is_animated_to_its_end(tmp_path):
    system = pendulum()
    run = simulate(system, 0.2, stop_when=measures.angle(system.joints[2]) > 0.1)
    film = run.animate(fps=10, speed=0.2, size=(3, 3))
    film.save(tmp_path / "motion.gif", writer="pillow")
    assert run.final.t < 0.2
