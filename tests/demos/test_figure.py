"""Curves of a demo: what fills the axis, what an ablation adds, and paths to one scale."""

import re
from dataclasses import replace

import numpy as np
import pytest

from mbsd3d.demos.figure import Line, Panel, figure_of, same
from mbsd3d.demos.panel_drawing import new_figure, spectrum_bars
from mbsd3d.extend import Curve, inline_svg, theme

T = np.linspace(0.0, 2.0, 41)
NOISE = 1e-15 * np.sin(37.0 * T)


def axes_of(curve, other=None):
    """Where a panel is drawn."""
    return figure_of("", [Panel(curve, other, "without it")]).axes[0]


@pytest.mark.parametrize("level", [88.2, -3e-4, 0.0])
def test_rounding_does_not_set_the_scale(level):
    curve, ablated = Curve("couple [N m]", T, level + NOISE), Curve("couple [N m]", T, 50.0 * np.sin(T) ** 2)
    low, high = axes_of(curve, ablated).get_ylim()
    assert low <= 0.0 and high >= ablated.y.max()  # the ablation does
    low, high = axes_of(curve).get_ylim()
    assert high - low >= 0.1 * abs(level)


def test_an_ablation_far_away_leaves_the_picture():
    low, high = axes_of(Curve("x [m]", T, np.sin(T)), Curve("x [m]", T, np.exp(9.0 * T))).get_ylim()
    assert -1.0 < low < 0.0 and 1.0 < high < 2.0


def test_an_ablation_that_turns_over_does_not_come_back():
    angle = np.degrees((np.exp(4.0 * T) + np.pi) % (2 * np.pi) - np.pi)
    drawn = axes_of(Curve("steer [deg]", T, 3.0 * np.cos(T)), Curve("steer [deg]", T, angle)).lines[1].get_ydata()
    first = np.argmax(np.isnan(drawn))
    assert 0 < first < T.size and np.isnan(drawn[first:]).all() and abs(drawn[first - 1]) > 36.0


def test_what_is_locked_is_a_mark():
    locked = Curve("angle [deg]", 0 * T, 0 * T)
    drawn = axes_of(Curve("angle [deg]", T, T), locked).lines[1]
    assert drawn.get_marker() == "x" and drawn.get_label() == "without it"


def test_the_same_curve_at_other_times_is_another():
    turns, slow = Curve("turn [deg]", T, 360.0 * T), Curve("turn [deg]", 1.4 * T, 360.0 * T)
    assert same(turns, turns) and not same(turns, slow)
    assert len(axes_of(turns, slow).lines) == 2 and len(axes_of(turns, turns).lines) == 1
    beside = replace(turns, more=[Line("other", T**2)])
    assert not same(turns, beside) and same(beside, beside)


def test_paths_seen_from_above_keep_their_shape_and_units_are_raised():
    axes = axes_of(Curve("y [m/s^2]", np.cos(T), 0.1 * np.sin(T), along="x [rad s^-1]", equal=True))
    assert axes.get_aspect() == 1.0
    assert (axes.get_ylabel(), axes.get_xlabel()) == ("y [m/s²]", "x [rad s⁻¹]")


def test_axes_in_space_have_the_colours_of_the_page():
    figure, (axes,) = new_figure("", ["3d: path"])
    axes.plot([0.0, 1.0], [0.2, 0.7], [0.1, 0.4], color=theme(False).lines[0])
    axes.set_xlabel("q")
    assert not re.search("#000000|: black", inline_svg(figure, "path-"))  # invisible on dark paper


def test_numbers_on_bars_have_the_colour_of_text_that_dark_pages_replace():
    figure, (axes,) = new_figure("bars", ["one"])
    spectrum_bars(axes, (1, 2), [("computed", [1.0, 0.1])], [1.0, 0.1])
    assert {text.get_color() for text in axes.texts} == {theme(False).ink}
