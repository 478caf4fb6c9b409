"""Engines with real dimensions: counterweights, gas, loads on the block, main bearings."""

from dataclasses import replace

import numpy as np
import pytest

from engines import planar
from engines.balance import gas, layouts, phasor, planar_sum, spatial
from engines.balance.pages.portrait import upright
from engines.nvh.excitation import presets
from engines.nvh.excitation.combustion import Cycle, cycle_of
from engines.nvh.excitation.loads import Source
from engines.nvh.excitation.main_bearings import cut_engine, cycle_run, main_bearings
from mbsd3d import spectrum

ROUNDING = 1e-11  # of sums over some hundred samples, relative


@pytest.mark.parametrize("name", presets.names())
def test_every_engine_has_dimensions_of_the_stated_ranges(name):
    chosen = presets.preset(name)
    engine, area = chosen.engine(chosen.redline), np.pi / 4 * (100 * chosen.bore) ** 2
    assert 5.0 < 1e3 * chosen.piston_mass / area < 9.0 and 5.0 < 1e3 * chosen.rod_mass / area < 10.0
    assert 1.45 < chosen.rod_length / chosen.stroke < 1.9
    assert np.linalg.eigvalsh(chosen.block.inertia).min() > 0.0
    assert engine.crank_centre < 0.0 < engine.rate
    mean_speed = 2 * chosen.stroke * chosen.redline / 60
    assert 15.0 < mean_speed < 27.0  # m/s of the pistons: what engines of series bear


def test_half_of_the_reciprocating_mass_in_the_counterweights_balances_a_cross_plane_v8():
    chosen = presets.preset("v8_cross")
    loads = [phasor.block_load(replace(chosen, balanced=share).engine(4000.0)).moment[1, :2] for share in (0.5, 0.4)]
    assert np.abs(loads[0]).max() < ROUNDING * np.abs(loads[1]).max()


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (dict(compression=1.0), "compression 1 is not above 1"),
        (dict(start=10.0, duration=150.0), "burning must end before the outlet opens"),
        (dict(bore=-0.1), "bore"),
        (dict(opening=200.0), "at 180 or before"),
    ],
)
def test_impossible_cycles_are_refused(change, text):
    with pytest.raises(ValueError, match=text):
        replace(cycle_of(presets.preset("inline_4")), **change)


@pytest.mark.parametrize("call", [lambda: presets.preset("v9"), lambda: presets.preset("v10").engine(0.0)])
def test_unknown_engines_and_speeds_are_refused(call):
    with pytest.raises(ValueError, match="v9.*there are single|rpm"):
        call()


@pytest.mark.parametrize("load", [0.05, 1.2, float("nan")])
def test_loads_that_no_throttle_gives_are_refused(load):
    with pytest.raises(ValueError, match="load"):
        cycle_of(presets.preset("single"), load)


def test_sudden_burning_has_the_efficiency_of_otto():
    """Burning within a degree around dead centre, outlet at bottom dead centre, no work of gas exchange."""
    cycle = replace(cycle_of(presets.preset("boxer_4")), start=-0.5, duration=1.0, opening=180.0, inlet=1e5, outlet=1e5)
    # the volume changes by 2e-4 of itself within the degree
    assert cycle.work / cycle.heat == pytest.approx(1 - cycle.compression ** (1 - cycle.gamma), rel=1e-4)


def test_without_heat_compression_is_adiabatic():
    cycle = replace(cycle_of(presets.preset("v12")), used=1e-12, opening=180.0)
    psi, p = cycle.samples
    closed = psi < np.pi - 0.1
    constant = p[closed] * cycle.volume(psi[closed]) ** cycle.gamma
    assert np.ptp(constant) < 1e-9 * constant.mean()


@pytest.mark.parametrize("name", ["inline_3", "v6_90", "boxer_6"])
def test_mean_torque_is_the_work_of_all_cylinders_over_two_turns(name):
    """The torque comes from virtual power at the crank, the work from the area of the p-V diagram."""
    source = Source(presets.preset(name), 0.8)
    cylinders = len(source.preset.layout.pins)
    # the spline of p is integrated by different rules
    assert source.mean_torque == pytest.approx(cylinders * source.cycle.work / (4 * np.pi), rel=1e-8)


@pytest.mark.parametrize(("name", "rpm"), [("inline_4", 2300.0), ("v6_60", 4100.0)])
def test_load_on_the_block_is_that_of_the_engine_in_space_with_its_gas(name, rpm):
    source, count = Source(presets.preset(name), 0.7), 240
    engine = source.preset.engine(rpm)
    system = gas.with_gas(spatial.build(engine, driver="dyno"), engine, source.cycle.force, 4 * count)
    solution = spatial.turn(system, engine, turns=2, count=count)
    R = upright(engine.layout)
    loads = [part @ R.T for part in spatial.block_load(solution)]
    seen = spectrum(solution.t, np.column_stack([*loads, solution.effort("motor")]), rate=engine.rate)
    known = source.at(rpm)
    found = np.array([seen.at(order) for order in known.orders])
    scale = np.abs(known.six).max()
    # orders that 240 samples a turn fold back of a gas that has all orders
    assert np.abs(found - np.column_stack([known.six, known.torque])).max() < 1e-5 * scale


def test_main_bearings_of_a_throw_share_what_the_planar_crank_bears():
    source = Source(presets.preset("single"), 0.0)
    solution, mains = cycle_run(source, 5300.0)
    engine = source.preset.engine(5300.0)
    known = planar.kinematics(planar_sum.build(engine, 0), solution.t).reaction("bearing").force / 2
    for bearing in main_bearings(source, 5300.0):
        assert np.abs(bearing.force - known).max() < ROUNDING * np.abs(known).max()
    assert mains == pytest.approx(engine.ends)


def test_cylinders_of_a_v_side_by_side_share_a_throw():
    """Rods 18 mm apart on one throw: two bearings, not three, each with its share of the planar cranks by the lever."""
    plan = layouts.Layout("V2", "staggered V twin", (10, 40), (30, -25), (-0.012, 0.006), spacing=0.1)
    source = Source(replace(presets.preset("single"), layout=plan, spacing=0.1), 0.0)
    engine, (solution, mains) = source.preset.engine(5300.0), cycle_run(source, 5300.0)
    assert mains == pytest.approx([-0.062, 0.056])
    cranks = [planar.kinematics(planar_sum.build(engine, i), solution.t).reaction("bearing").force for i in (0, 1)]
    front = [(mains[1] - z) / (mains[1] - mains[0]) for z in plan.stations]
    for bearing, shares in zip(main_bearings(source, 5300.0), (front, np.subtract(1, front)), strict=True):
        known = shares[0] * cranks[0] + shares[1] * cranks[1]
        assert np.abs(bearing.force - known).max() < ROUNDING * np.abs(known).max()


@pytest.mark.parametrize("name", presets.names())
def test_every_crank_has_a_bearing_between_its_throws(name):
    source = Source(presets.preset(name), 0.0)
    assert len(cut_engine(source, 1000.0)[1]) == len(set(source.preset.layout.stations)) + 1


def test_bearings_and_bores_together_are_the_load_on_the_block():
    """With gas: forces of bearings, bores and heads in the cut engine against the closed form of the whole."""
    source, rpm = Source(presets.preset("v8_flat"), 1.0), 3700.0
    solution, mains = cycle_run(source, rpm)
    engine = source.preset.engine(rpm)
    force = np.zeros((solution.t.size, 3))
    for k in range(1, mains.size):
        force -= solution.reaction(f"front {k}").force + solution.reaction(f"rear {k}").force
    for i in range(len(engine.stations)):
        force -= solution.reaction(f"bore {i + 1}").force + solution.force(f"gas {i + 1}").force
    seen = spectrum(solution.t, force, rate=engine.rate)
    known = phasor.block_load(engine).force
    found = np.array([seen.at(order) for order in range(len(known))])
    assert np.abs(found - known).max() < 1e-9 * np.abs(known).max()


def test_a_cut_crank_is_determinate():
    system, _ = cut_engine(Source(presets.preset("inline_3"), 1.0), 3000.0)
    found = system.check()
    assert found.redundant == 0 and found.velocity_freedom == 0


def test_rating_life_follows_from_the_loads():
    source = Source(presets.preset("twin_270"), 1.0)
    bearing = main_bearings(source, 4000.0)[1]
    mean = np.mean(bearing.radial[:-1] ** (10 / 3)) ** 0.3  # whole cycles: the mean is the trapezoidal rule
    hours = (source.preset.roller_rating / mean) ** (10 / 3) * 1e6 / (60 * 4000.0)
    assert bearing.mean == pytest.approx(mean, rel=1e-12) and bearing.hours == pytest.approx(hours, rel=1e-12)
    area = source.preset.main_diameter * source.preset.main_width
    assert bearing.pressure == pytest.approx(bearing.radial.max() / area)


def test_a_motored_engine_has_no_gas():
    assert isinstance(Source(presets.preset("v10"), 0.5).cycle, Cycle)
    assert Source(presets.preset("v10"), 0.0).cycle is None and Source(presets.preset("v10"), 0.0).mean_torque == 0.0


def test_a_charge_has_the_heat_of_petrol_and_air():
    """A stoichiometric mixture burns with 2.7 to 2.9 MJ/kg; the charge fills the cylinder at the inlet's pressure."""
    cycle = cycle_of(presets.preset("inline_4"))
    whole = cycle.volume(np.pi)
    assert whole == pytest.approx(cycle.swept * cycle.compression / (cycle.compression - 1))
    mass = cycle.inlet * whole / (287.0 * cycle.temperature)
    assert 2.7e6 < cycle.heat / cycle.used / mass < 2.9e6


def test_gas_at_the_pressure_of_the_crankcase_pushes_nothing():
    cycle = replace(cycle_of(presets.preset("inline_4")), outlet=101325.0 + 2500.0)
    assert cycle.force(np.array([1.5 * np.pi])) == pytest.approx(2500.0 * cycle.area, rel=1e-6)  # the outlet is open
