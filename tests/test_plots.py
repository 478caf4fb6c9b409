"""Figures: units on every axis, the same bytes twice."""

import re

import matplotlib.pyplot
import numpy as np
import pytest
from matplotlib.figure import Figure
from test_files import LOWER_ARM, UPPER_ARM, WHEEL, pendulum

from mbsd3d import GROUND, Body, Revolute, System, accelerations, simulate
from mbsd3d.plots import PANELS, plot_quantity, save_figure


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
    first, second = (save_figure(solution.plot("reaction"), tmp_path / f"{name}.v1") for name in "ab")
    assert [path.name for path in first] == ["a.v1.png", "a.v1.svg"]
    assert all(a.read_bytes() == b.read_bytes() for a, b in zip(first, second, strict=True))
    assert b"dc:date" not in first[1].read_bytes()
