"""Tables and figures of a study: what their numbers mean."""

from dataclasses import replace

import numpy as np
import pytest

from engines.balance import phasor
from engines.nvh import figures, tables
from engines.nvh.excitation import presets
from engines.nvh.mounts import mounts
from engines.nvh.study import Study


@pytest.fixture(scope="module")
def study() -> Study:
    return Study(presets.preset("inline_5"), mounts.car("saloon"), 2900.0, 0.7)


def test_shapes_move_one_mount_by_a_millimetre(study):
    arms = np.array([mount.at for mount in study.placed]) - study.body.rigid.com
    for row, mode in zip(tables.shapes(study)[1:], study.modes, strict=True):
        shape = np.array([float(x) for x in row[3:]])
        moved = np.linalg.norm(shape[:3] + np.cross(shape[3:], arms), axis=1)
        # three decimals of mm and mrad, arms below a metre
        assert moved.max() == pytest.approx(1.0, abs=3e-3)
        assert abs(shape @ mode.shape) == pytest.approx(np.linalg.norm(shape) * np.linalg.norm(mode.shape), rel=1e-4)


def test_shares_of_no_energy_have_no_sign():
    """On four alike mounts some shares are rounding of either sign."""
    rows = tables.modes(Study(presets.preset("single"), mounts.car("bench"), 5250.0))[1:]
    assert "0.0" in rows[0] and not any(cell.startswith("-") for row in rows for cell in row)
    assert [sum(map(float, row[3:])) for row in rows] == pytest.approx(6 * [100.0], abs=0.31)


def test_torque_over_the_cycle_has_the_orders_of_the_load(study):
    angle = np.linspace(0.0, 4 * np.pi, 1440, endpoint=False)
    lines = np.fft.rfft(sum(study.source.over_the_cycle(study.rpm, angle))) * 2 / angle.size
    known = study.source.at(study.rpm).torque
    # a sum of fewer orders than half the samples: exact but for rounding
    assert -lines[1 : known.size] == pytest.approx(known[1:], abs=1e-12 * np.abs(known).max())
    assert lines[0].real / 2 == pytest.approx(study.source.mean_torque, rel=1e-12)


def test_ripple_is_the_range_of_the_torque_and_what_it_does_to_a_free_crank(study):
    """The speed of a rotor under the torque less its mean, by sums over the crank angle."""
    angle = np.linspace(0.0, 4 * np.pi, 28801)
    torque = sum(study.source.over_the_cycle(study.rpm, angle))
    rate, J = study.preset.engine(study.rpm).rate, study.body.rotor
    speed = np.sqrt(rate**2 + 2 / J * np.cumsum(torque - torque[:-1].mean()) * angle[1])
    text = tables.ripple(study).split()
    assert (text[0], text[2]) == (f"{torque.min():.0f}", f"{torque.max():.0f}")
    # two digits
    assert float(text[-2]) == pytest.approx(100 * np.ptp(speed) / rate, rel=0.06)


def test_secondary_couples_are_in_the_table_of_loads(study):
    """F_2 a 4.980 of an inline five: a_2 of the series times the couple of its crank, car axes."""
    engine = study.preset.engine(study.rpm)
    second = phasor.block_load(engine, dyno=True)
    (row,) = (row for row in tables.loads(study)[1:] if row[0] == "2x")
    assert float(row[6]) == pytest.approx(np.abs(second.moment[2, :2]).max(), rel=1e-3)
    assert row[2:5] == ["0", "0", "0"]


def test_all_engines_are_listed_with_their_orders():
    rows = {row[0]: row[3:] for row in tables.engines()[1:]}
    assert set(rows) == set(presets.names())
    assert rows["inline_6"] == rows["v12"] == rows["boxer_6"] == ["0", "0", "0", "0"]
    chosen = presets.preset("inline_4")
    second = phasor.block_load(chosen.engine(chosen.redline), dyno=True).force[2]
    assert rows["inline_4"] == ["0", f"{np.linalg.norm(np.abs(second)):.0f}", "0", "0"]
    assert rows["inline_5"][3] != "0" != rows["v6_90"][3]


def test_what_is_transmitted_is_one_for_a_stiff_hold(study):
    """Mounts whose modes lie above 4 kHz: orders below 600 Hz arrive as they are, to (600 / 4000)^2."""
    stiff = [
        replace(mount, rates=tuple(1e6 * k for k in mount.rates), damping=(0.0, 0.0, 0.0)) for mount in study.placed
    ]
    for name in ("inline_4", "inline_5"):
        one = replace(study, preset=presets.preset(name))
        one.__dict__["placed"] = stiff
        for part in figures.transmitted(one, one.map, one.map.force):
            there = np.isfinite(part) & (one.map.rpm[:, None] * one.map.orders < 60 * 600.0)
            assert there.any() and part[there] == pytest.approx(1.0, abs=0.0225)
    assert figures.on_block(one)[1] == "N m"


def test_the_table_of_a_sweep_may_be_short(study):
    one = Study(presets.preset("single"), mounts.car("motorcycle"), 5200.0, 0.0)
    found = one.sweep(5, 1)
    assert found.cycles == 1 and len(tables.sweep(found)) == 6
    short = tables.sweep(found, 2)
    assert short[1][0] == "1500" and short[-1][0] == "9000" and len(short) in (3, 4)
