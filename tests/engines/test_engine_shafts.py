"""Balance shafts, gas forces and firing orders of engines, and the tables of the studies."""

from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from engines.balance import cli, gas, phasor, report, shafts, spatial
from engines.balance.layouts import Engine, Layout, layout
from engines.balance.shafts import Shaft
from mbsd3d import spectrum

LIMIT = 1e-9  # of F_single; rounding stays below 1e-12
UNEVEN = dict(rpm=37.0, radius=0.8, rod_length=1.7, crank_centre=0.35, rod_fraction=0.37, piston_mass=4.4)


def balanced(engine: Engine, wanted: list, **options: object) -> tuple[list, np.ndarray, np.ndarray]:
    """Shafts, what they should leave, what the spatial engine with them has left."""
    load = phasor.block_load(engine, dyno=bool(options))
    found = shafts.balance(engine, load, wanted, **options)
    system = spatial.build(engine, driver="dyno" if options else "block")
    turn = spatial.turn(shafts.with_shafts(system, engine, found), engine)
    left = shafts.engine_load(spatial.harmonics(turn, engine), wanted[0].order)
    return found, shafts.remainder(engine, load, found), left


def test_two_shafts_null_the_second_order_of_the_four():
    engine = Engine("I4")
    found, theory, left = balanced(engine, [shafts.Shaft(2, 1, (0.2, 0.5)), shafts.Shaft(2, -1, (0.2, -0.5))])
    each = 16.44438394420787 / 2 / (2 * engine.rate) ** 2  # kg m: half the force, at twice the speed
    assert [abs(shaft.unbalance[0]) for shaft in found] == pytest.approx([each, each])
    np.testing.assert_allclose(np.abs([theory, left]), 0.0, rtol=0, atol=LIMIT * engine.single)


def test_one_shaft_leaves_half_and_turns_it_round():
    engine = Engine("I4")
    _, theory, left = balanced(engine, [shafts.Shaft(2, 1)])
    np.testing.assert_allclose(left, theory, rtol=0, atol=LIMIT * engine.single)
    assert np.abs(left[:2]) == pytest.approx([16.44438394420787 / 2] * 2)


def test_shafts_at_different_heights_null_the_torque_too():
    engine = Engine("I4")
    start = [shafts.Shaft(2, 1, (0.0, 0.5)), shafts.Shaft(2, -1, (0.0, -0.5))]
    found, theory, left = balanced(engine, start, torque=True)
    assert np.abs(phasor.block_load(engine, dyno=True).moment[2, 2]) == pytest.approx(17.43, abs=5e-3)  # N m, before
    np.testing.assert_allclose(np.abs([theory, left]), 0.0, rtol=0, atol=LIMIT * engine.single)
    assert found[0].position[0] - found[1].position[0] == pytest.approx(17.43197 / (16.44438 / 2), rel=1e-5)


def test_counterweights_and_one_backward_shaft_null_the_couple_of_the_three():
    engine = Engine("I3", **UNEVEN)
    planes = (-0.12, 0.07)
    wanted = [shafts.Shaft(1, 1, (0, 0), planes), shafts.Shaft(1, -1, (0.3, 0.4), planes)]
    found, theory, left = balanced(engine, wanted)
    np.testing.assert_allclose(np.abs([theory, left]), 0.0, rtol=0, atol=LIMIT * engine.single)
    assert sum(found[1].unbalance) == pytest.approx(0.0, abs=1e-12)  # kg m: a couple alone


def test_counterweights_alone_balance_the_even_v6():
    engine = Engine("V6_60_offset+60", **UNEVEN)
    _, _, left = balanced(engine, [shafts.Shaft(1, 1, (0, 0), (-0.1, 0.1))])
    np.testing.assert_allclose(np.abs(left), 0.0, rtol=0, atol=LIMIT * engine.single)


def test_half_sine_of_the_gas_by_series():
    peak, turns = 7e3, 2 * np.pi * np.arange(4001) / 2000
    seen = spectrum(turns, gas.half_sine(peak)(turns), rate=1.0)
    found = np.array([seen.at(m / 2) for m in range(9)])
    # the kinks fold back 2 (m / N)^2 of the series at most
    np.testing.assert_allclose(gas.half_sine_phasors(peak, 8), found, rtol=0, atol=2 * peak * (4 / 4000) ** 2)


def test_second_order_of_the_gas_of_the_four():
    """4244.13 N is the sum of the four gas forces: 4 peak / (3 pi)."""
    assert np.abs(gas.force_phasors(Engine("I4"), 10e3, 4)[4]) == pytest.approx(4244.131815783876, rel=1e-12)


@pytest.mark.parametrize(("name", "offset"), [("I3", 0.008), ("V6_90_shared", 0.0)])
def test_the_block_feels_the_gas_only_as_torque_reaction(name, offset):
    engine, pulse, count = Engine(name, offset=offset), gas.half_sine(), 48
    for driver in ("block", "dyno"):
        system = spatial.build(engine, driver=driver)
        fired = spatial.turn(gas.with_gas(system, engine, pulse, count), engine, turns=2, count=count)
        cold = spatial.turn(system, engine, turns=2, count=count)
        (force, moment), (still, quiet) = spatial.block_load(fired), spatial.block_load(cold)
        torque = gas.torque(engine, pulse, engine.rate * fired.t)
        reaction = np.outer(-torque if driver == "dyno" else 0 * torque, (0, 0, 1))
        np.testing.assert_allclose(force, still, rtol=0, atol=1e-8)  # N, of 10 kN
        np.testing.assert_allclose(moment - quiet, reaction, rtol=0, atol=1e-7)  # N m, of 30 kN m
        np.testing.assert_allclose(fired.effort("motor") - cold.effort("motor"), -torque, rtol=0, atol=1e-7)
        assert np.ptp(torque) > 5e3


def test_shafts_that_bear_couples_alone_stay_where_they_are():
    engine = Engine("boxer4")
    load, ends = phasor.block_load(engine, dyno=True), tuple(engine.stations[[0, -1]])
    pair = [Shaft(2, way, (0.3 * way, 0.1), ends) for way in (1, -1)]
    still = shafts.balance(engine, load, pair, torque=True)
    assert [shaft.position for shaft in still] == [shaft.position for shaft in pair]
    assert not any(shaft.pulls for shaft in still)
    weights = shafts.balance(engine, load, [Shaft(1, 1, planes=(-0.2, 0.2))], torque=True)
    assert weights[0].on_crank and weights[0].position == (0.0, 0.0)
    assert not Shaft(1, 1, (0.1, 0.0)).on_crank  # beside it, it turns on a bearing of its own


def test_firing_order_of_many_cylinders():
    many = Layout("W18", "three banks of six", [0.0, 240.0, 120.0] * 6, [0.0] * 18, range(18))
    with pytest.raises(ValueError, match="layout 'W18': 18 cylinders; give a firing_order that its crank can do"):
        gas.firing_angles(many)
    named = replace(many, firing_order="-".join(str(1 + 3 * k % 18 + k // 6) for k in range(18)))
    with pytest.raises(ValueError, match="give a firing_order"):  # this one takes many turns
        gas.firing_angles(named)
    assert sorted(set(gas.firing_angles(replace(layout("V12_60"), firing_order=None)) % 60)) == [0.0]


@pytest.mark.parametrize("order", ["1-3", "1-1", "1", "0-1", "1-x", "", 12])
def test_a_firing_order_names_every_cylinder_once(order):
    with pytest.raises(ValueError, match="layout 'twin': firing_order .*; give each of 2 cylinders once, '1-3-4-2'"):
        Layout("twin", "parallel twin", (0, 180), (0, 0), (0, 0.1), firing_order=order)


def test_firing_orders():
    assert gas.firing_order(layout("I4")) == "1-3-4-2"
    assert gas.firing_order(layout("I5")) == "1-2-4-5-3"
    assert gas.firing_order(layout("I3")) == "1-2-3"  # 1-3-2 is that of the crank mirrored
    for name, known, bank in (("V8_cross", "1-8-4-3-6-5-7-2", 4), ("V6_60_offset+60", "1-2-3-4-5-6", 3)):
        first = name.startswith("V8")  # odd numbers in the first bank, or in the second
        order = [int(c) - 1 for c in gas.firing_order(layout(name)).split("-")]
        numbers = [2 * (c % bank) + (1 if (c < bank) == first else 2) for c in order]
        start = numbers.index(1)
        assert "-".join(map(str, numbers[start:] + numbers[:start])) == known
    gaps = np.diff(np.sort(gas.firing_angles(layout("V6_90_shared"))))
    assert sorted(set(gaps.round(9))) == [90.0, 120.0, 150.0]


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (lambda: shafts.Shaft(0, 1), "shaft of order 0, direction 1"),
        (lambda: shafts.Shaft(1, 1, (0, 0), (0, 1), (1j,)), "2 planes, 1 unbalances"),
        (lambda: balanced(Engine("I4"), [shafts.Shaft(1, 1), shafts.Shaft(2, 1)]), "one order at a time"),
        (lambda: balanced(Engine("I4"), [shafts.Shaft(8, 1)]), "harmonics up to 6"),
    ],
)
def test_errors_of_shafts(wrong, message):
    with pytest.raises(ValueError, match=message):
        wrong()


@pytest.mark.slow
def test_studies_on_the_command_line():
    found = CliRunner().invoke(cli.main, ["I4", "--gas", "10000", "--shafts", "--sweep"])
    assert found.exit_code == 0
    lines = [line.split() for line in found.output.splitlines()]
    gas_line = next(cells for cells in lines if cells[:2] == ["2x", "4244.13"])
    assert gas_line[2] == gas_line[3] and gas_line[4] == "0"  # torque = reaction of the block, nothing else
    assert next(cells for cells in lines if cells[:2] == ["2x", "both"])[2:4] == ["16.4444", "0"]
    swept = {cells[0]: cells[1:4] for cells in lines if len(cells) == 7 and cells[0].startswith("0.")}
    assert swept == {r: 3 * [f] for r, f in zip(
        ("0.6667", "0.5", "0.3333", "0.25"), ("23.3943", "16.4444", "10.5353", "7.79995"), strict=True
    )}  # fmt: skip
    assert CliRunner().invoke(cli.main, ["--shafts"]).exit_code == 2


def test_counterweights_take_the_forward_half():
    rows = {row[0]: row for row in report.balance_shafts(Engine("V6_90_shared")).rows}
    assert rows["1x forward"][4] == "0" and rows["1x backward"][4] != "0"
    assert rows["2x both"][4] == "0" and rows["2x forward"][4] != "0"


@pytest.mark.parametrize(
    "rod_length, force", [(1.5, 23.39428502785078), (2.0, 16.44438394420787), (3.0, 10.5353), (4.0, 7.79995)]
)
def test_second_order_of_the_four_by_orders_of_its_solution(rod_length, force):
    """The published 2x force over R / L, closed form: read from the mount by the public call."""
    engine = replace(Engine("I4"), rod_length=rod_length)
    system = spatial.build(engine, driver="block")
    solution = spatial.turn(system, engine)
    seen = solution.orders("main 1", "reaction", "mount", per_turn=256)
    digits = 1e-9 if rod_length <= 2.0 else 5e-5  # given digits
    assert abs(np.abs(seen.at(2)).max() - force) < digits and np.abs(seen.at(1)).max() < 1e-8
    over_time = solution.spectrum("reaction", "mount").at(2 * engine.rate / (2.0 * np.pi))
    assert np.abs(over_time).max() == pytest.approx(force, abs=digits)
