"""Balance shafts of engines with real dimensions: what they take, late ones, and the full motion with them."""

import numpy as np
import pytest

from validation.nvh.engine import balance_shafts, presets
from validation.nvh.engine.loads import Source
from validation.nvh.held import mounts
from validation.nvh.study import Study

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


@pytest.mark.parametrize("degrees", [1.0, 7.5, 40.0])
def test_late_shafts_leave_twice_the_sine_of_half_the_angle(degrees):
    chosen, phase = presets.preset("inline_4"), np.radians(degrees)
    fitted = balance_shafts.fitted(chosen, "lanchester")
    whole = orders("inline_4", None, 2)[2] * (4000 / 5100) ** 2
    assert balance_shafts.left(chosen, fitted, 4000.0, phase)[0] == pytest.approx(
        2 * np.sin(phase / 2) * whole, rel=1e-9
    )


@pytest.mark.parametrize(("name", "kind"), [("inline_6", "lanchester"), ("v12", "first"), ("single", "third")])
def test_shafts_that_help_nothing_are_refused(name, kind):
    with pytest.raises(ValueError, match="that .* shafts could take|unknown; there are lanchester"):
        balance_shafts.fitted(presets.preset(name), kind)


def test_the_full_motion_with_geared_shafts_is_that_of_the_linear_map():
    study = Study(presets.preset("single"), mounts.car("motorcycle"), 4300.0, 0.0, "first")
    assert study.run.certificate.passed
    # as without shafts: the pistons' share of the mass changes the mass matrix
    assert study.difference < 5e-3
    # what is left is the torque of one shaft beside the crank
    bare = Study(presets.preset("single"), mounts.car("motorcycle"), 4300.0, 0.0)
    assert np.abs(study.run_force[2]).max() < 0.5 * np.abs(bare.here.force[0, 2]).max()
