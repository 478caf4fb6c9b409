"""Bounds hold all that moves, and the camera sees them."""

import numpy as np
import pytest

from mbsd3d import GROUND, Body, Revolute, SpringDamper, System, simulate
from mbsd3d.shapes import Lines
from mbsd3d.view.scene.artist import draw_system
from mbsd3d.view.scene.camera import directions, followed_body, frame_camera, sight
from mbsd3d.view.scene.drawing import bounds


def test_bounds_hold_all_frames():
    bar = Body("bar", 1.0, (1, 1, 1), com=(0.3, 0, 0), shape=Lines([(0, 0, 0), (0.7, 0, 0)]), omega=(0, 2.0, 0))
    system = System([bar], [Revolute(GROUND, bar, at=(0, 0, 0), axis=(0, 1, 0))], gravity=(0, 0, 0))
    run = simulate(system, np.pi, output=81)  # one turn, a sample at every quarter
    q = run.arrays["q"]
    r = np.concatenate([q[:, :, :3], np.zeros((81, 1, 3))], axis=1)
    e = np.concatenate([q[:, :, 3:], np.tile(GROUND.orientation, (81, 1, 1))], axis=1)
    drawing = draw_system(system)
    low, high = bounds(drawing._replace(pieces=[]), r, e)
    assert np.allclose([low[[0, 2]], high[[0, 2]]], [[-0.7, -0.7], [0.7, 0.7]], rtol=0, atol=1e-6)
    low, high = bounds(drawing._replace(pieces=[]), r[:1], e[:1])
    assert np.allclose([low[[0]], high[[0]]], [[0.0], [0.7]], rtol=0, atol=0.06)  # the axis wire is not along x or z


FLAT = ((1, 0, 2), (0, 0, 3), (0, 2, 0), (0, 0, 0), (1e-3, 2e-3, 1e-3), (1000, 10, 1))


@pytest.mark.parametrize("fov", [0.3, 0.7, 1.4])
@pytest.mark.parametrize("extent", [*FLAT, *np.random.default_rng(7).uniform(0.0, 3.0, size=(6, 3))])
def test_the_camera_sees_every_corner(extent, fov):
    low = np.array([0.3, -0.7, 1.1])
    high = low + extent
    camera = frame_camera(low, high, fov)
    towards = (camera.position - camera.look_at) / camera.distance
    assert np.linalg.norm(towards) == pytest.approx(1.0) and 0.2 < towards[2] < 0.6
    assert np.allclose(camera.look_at, 0.5 * (low + high))
    right = np.cross((0, 0, 1), towards)
    right /= np.linalg.norm(right)
    picture = np.array([right, np.cross(towards, right), towards])
    corners = np.array([(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
    seen = (corners - camera.position) @ picture.T
    spots = seen[:, :2] / -seen[:, 2:] / np.tan(0.5 * fov)
    assert seen[:, 2].max() < 0.0 and np.abs(spots).max() < 0.95
    if np.any(extent):
        assert np.abs(spots).max() > 0.85  # and it fills the picture


@pytest.mark.parametrize("aspect", [0.5, 1.0, 1.7])
@pytest.mark.parametrize("view", [None, (20.0, 35.0), (-130.0, -10.0), (75.0, 88.0)])
def test_a_window_of_any_shape_is_filled_from_any_side(view, aspect):
    points = np.random.default_rng(11).normal(size=(60, 3)) * (3.0, 1.0, 0.4) + (5.0, -2.0, 1.0)
    axes = directions(view)
    along = points @ axes.T
    first = sight(along.min(axis=0), along.max(axis=0), axes, 0.7)
    camera = first.camera(aspect)
    assert np.allclose(axes @ axes.T, np.eye(3), rtol=0, atol=1e-15) and np.linalg.det(axes) == pytest.approx(1.0)
    assert np.allclose(axes[1, 2], 0.0) and axes[2, 2] > 0.0  # upright
    seen = (points - camera.position) @ axes.T
    spots = seen[:, 1:] / -seen[:, :1] / np.tan(0.35) / (aspect, 1.0)
    assert seen[:, 0].max() < 0.0 and 0.5 < np.abs(spots).max() < 0.9
    if view:
        assert np.degrees(np.arctan2(*axes[0, 1::-1])) == pytest.approx(view[0])
        assert np.degrees(np.arcsin(axes[0, 2])) == pytest.approx(view[1])
    turning = sight(along.min(axis=0), along.max(axis=0), axes, 0.7, turns=True)
    assert turning.across >= first.across and turning.depth >= first.depth and turning.up > first.up


def test_the_camera_goes_along_with_what_travels():
    """By itself where the way is long beside the machine; the ground as what to follow keeps it where it is."""
    stone = Body("stone", 2.0, (0.1, 0.1, 0.1), velocity=(40.0, 0, 0), omega=(0, 0, 0))
    dust = Body("dust", 0.1, (0.01, 0.01, 0.01), position=(0.5, 0, 0), velocity=(40.0, 0, 0), omega=(0, 0, 0))
    system = System([dust, stone], gravity=(0, 0, 0))
    far, near = (simulate(system, t_end, output=11) for t_end in (2.0, 0.1))
    assert followed_body(far, None, False) == 1 and followed_body(near, None, False) == -1
    assert (
        followed_body(far, GROUND, False) == followed_body(far, "ground", True) == followed_body(far, None, True) == -1
    )
    assert followed_body(near, "dust", False) == 0


@pytest.mark.parametrize("other", ["stone", "ground"])
def test_the_camera_stays_with_what_a_spring_ties_to_the_ground(other):
    """The same fall of 20 m: tied to the ground the spring stays on the paper, tied to another stone it goes along."""
    stones = [Body(name, 2.0, (0.1, 0.1, 0.1), position=(x, 0, 0)) for name, x in (("bob", 0.0), ("stone", 0.3))]
    end = GROUND if other == "ground" else stones[1]
    spring = SpringDamper(end, stones[0], at_a=(0.3, 0, 0), at_b=(0, 0, 0), stiffness=1e-6)
    assert followed_body(simulate(System(stones, [], [spring]), 2.0, output=11), None) == (
        0 if end is not GROUND else -1
    )
