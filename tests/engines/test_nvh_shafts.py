"""Balance shafts of engines with real dimensions: what they take, faults of fitting, the full motion with them."""

import numpy as np
import pytest

from engines.balance.pages.portrait import upright
from engines.nvh import tables
from engines.nvh.excitation import balance_shafts, presets
from engines.nvh.excitation.balance_shafts import Fault
from engines.nvh.excitation.loads import Source
from engines.nvh.mounts import mounts
from engines.nvh.study import Study

ROUNDING = 1e-9  # of what is there without shafts


def orders(name: str, kind: str | None, order: int) -> np.ndarray:
    """(6,) amplitudes of the load on the block, motored."""
    chosen = presets.preset(name)
    shafts = () if kind is None else tuple(balance_shafts.fitted(chosen, kind))
    return np.abs(Source(chosen, 0.0, shafts).at(5100.0).six[2 * order])


@pytest.mark.parametrize(
    ("name", "kind", "order", "taken"),
    [
        ("inline_4", "lanchester", 2, (1, 2)),
        ("inline_4", "raised", 2, (1, 2, 3)),
        ("v8_flat", "lanchester", 2, (1, 2)),
        ("single", "first", 1, (1, 2)),
        ("inline_3", "first", 1, (4, 5)),
        ("v6_90", "first", 1, (4, 5)),
    ],
)
def test_shafts_take_their_order(name, kind, order, taken):
    bare, left = orders(name, None, order), orders(name, kind, order)
    assert left[list(taken)].max() < ROUNDING * bare.max()
    assert bare[list(taken)].max() > 0.01 * bare.max()


def test_shafts_at_one_height_leave_the_torque_of_the_inertia():
    bare, left = orders("inline_4", None, 2), orders("inline_4", "lanchester", 2)
    assert left[3] == pytest.approx(bare[3], rel=1e-9)


SPEED = 4000.0
WHOLE = orders("inline_4", None, 2)[2] * (SPEED / 5100) ** 2  # N: the 2x force without shafts


def remains(kind: str, **fault: object) -> np.ndarray:
    """(5,) phasors of forces, couples and torque that faulty shafts of the inline four leave."""
    chosen = presets.preset("inline_4")
    shafts = balance_shafts.faulty(chosen, balance_shafts.fitted(chosen, kind), Fault("", **fault))
    found = balance_shafts.left(chosen, shafts, SPEED)
    space = balance_shafts.left_in_space(chosen, shafts, SPEED)
    assert np.abs(space - found).max() < ROUNDING * WHOLE
    return found


@pytest.mark.parametrize("degrees", [1.0, 7.5, 40.0])
def test_late_shafts_leave_twice_the_sine_of_half_the_angle(degrees):
    found = remains("lanchester", phase=np.radians(degrees))
    assert np.abs(found[:2]).max() == pytest.approx(2 * np.sin(np.radians(degrees) / 2) * WHOLE, rel=1e-9)


def test_shafts_out_of_place_leave_their_force_times_the_distance():
    """Along the crank a couple, aside a torque; up nothing, but for one alone, whose sideways force has then an arm."""
    d = 0.0037
    along, aside, up = (remains("raised", moved=tuple(d * e)) for e in np.eye(3))
    assert np.abs(along) == pytest.approx([0, 0, *np.abs(along[2:4]), 0], abs=1e-9 * WHOLE)
    assert np.abs(along[2:4]).max() == pytest.approx(d * WHOLE, rel=1e-9)
    assert np.abs(aside) == pytest.approx([0, 0, 0, 0, d * WHOLE], abs=1e-9 * WHOLE)
    assert np.abs(up) == pytest.approx(np.zeros(5), abs=1e-9 * WHOLE)
    for moved in ((0, d, 0), (0, 0, d)):
        one = remains("raised", moved=moved, one=True)
        assert np.abs(one) == pytest.approx([0, 0, 0, 0, d * WHOLE / 2], abs=1e-9 * WHOLE)
    both = remains("raised", moved=(d, -2 * d, d), phase=0.02, heavy=0.01)
    assert np.abs(both[:2]).max() == pytest.approx(abs(1 - 1.01 * np.exp(0.02j)) * WHOLE, rel=1e-9)


@pytest.mark.parametrize("name", ["inline_4", "v8_flat"])
def test_shafts_are_moved_along_the_crank_to_its_left_and_up(name):
    chosen, moved = presets.preset(name), (0.004, -0.007, 0.003)
    shafts = balance_shafts.fitted(chosen, "lanchester")
    for old, new in zip(shafts, balance_shafts.faulty(chosen, shafts, Fault("", moved=moved)), strict=True):
        places = ([*shaft.position, shaft.planes[0]] for shaft in (new, old))
        assert upright(chosen.layout) @ np.subtract(*places) == pytest.approx(moved)


def test_one_heavy_shaft_leaves_a_force_that_turns():
    found = remains("lanchester", heavy=0.02, one=True)
    assert np.abs(found[:2]) == pytest.approx([0.01 * WHOLE] * 2, rel=1e-9)


def test_counterweights_are_never_late():
    chosen = presets.preset("single")
    shafts = balance_shafts.fitted(chosen, "first")
    late = balance_shafts.faulty(chosen, shafts, Fault("", phase=0.3))
    for a, b in zip(shafts, late, strict=True):
        assert (a == b) == a.on_crank


@pytest.mark.parametrize("share", [0.0, 0.4, 1.0, 1.3])
def test_the_roll_is_linear_in_the_height_of_the_shafts(share):
    chosen = presets.preset("inline_4")
    full = balance_shafts.fitted(chosen, "raised")
    up = upright(chosen.layout)[2, :2]
    best = abs(np.subtract(*(np.array(shaft.position) @ up for shaft in full)))
    bare = abs(balance_shafts.left(chosen, balance_shafts.fitted(chosen, "lanchester"), SPEED)[4])
    found = balance_shafts.left(chosen, balance_shafts.apart(chosen, full, share * best), SPEED)
    assert abs(found[4]) == pytest.approx(abs(1 - share) * bare, abs=1e-9 * bare)
    assert np.abs(found[:4]) == pytest.approx(np.zeros(4), abs=1e-9 * WHOLE)


@pytest.mark.parametrize("name", ["boxer_4", "inline_5", "v6_60", "v8_flat"])
def test_where_no_height_helps_raised_shafts_are_refused(name):
    """Shafts that bear couples alone were moved by rounding over rounding, those of the boxer four by 1e14 m."""
    with pytest.raises(ValueError, match="has no 2x force upwards, without which raised shafts help nothing"):
        balance_shafts.fitted(presets.preset(name), "raised")
    study = Study(presets.preset(name), mounts.car("compact"), 3000.0, shafts="lanchester")
    assert tables.heights(study) is None


@pytest.mark.parametrize(("name", "kind"), [("inline_6", "lanchester"), ("v12", "first"), ("single", "third")])
def test_shafts_that_help_nothing_are_refused(name, kind):
    with pytest.raises(ValueError, match="that .* shafts could take|unknown; there are lanchester"):
        balance_shafts.fitted(presets.preset(name), kind)
    if name == "single":
        alone = balance_shafts.fitted(presets.preset(name), "first")
        with pytest.raises(ValueError, match="1 shafts have no height between them; give a pair"):
            balance_shafts.apart(presets.preset(name), alone, 0.1)


def test_the_full_motion_with_geared_shafts_is_that_of_the_linear_map():
    study = Study(presets.preset("single"), mounts.car("motorcycle"), 4300.0, 0.0, "first")
    assert study.run.certificate.passed
    # as without shafts: the pistons' share of the mass changes the mass matrix
    assert study.difference < 5e-3
    # what is left is the torque of one shaft beside the crank
    bare = Study(presets.preset("single"), mounts.car("motorcycle"), 4300.0, 0.0)
    assert np.abs(study.run_force[2]).max() < 0.5 * np.abs(bare.here.force[0, 2]).max()
