"""Studies of bicycles: critical speeds, sensitivity, ablations, frequency response, comparison."""

import doctest
import json
from dataclasses import is_dataclass, replace
from functools import partial
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.optimize import brentq

import bicycle
from bicycle import (
    TYPICAL,
    Meijaard2007,
    circles,
    compare,
    critical,
    frequency,
    general,
    handling,
    named,
    ride,
    sensitivity,
    stability,
    whipple,
    why,
)  # fmt: skip
from bicycle.linear.critical import double_roots
from bicycle.linear.equations import canonical
from bicycle.linear.tyre_equations import eigenvalues
from bicycle.linear.why import two_mass_skate
from bicycle.pages import ideal_or_tyres
from bicycle.pages.compare import write_page
from bicycle.pages.side_view import semi_axes, side_view
from bicycle.parameters import library, names
from bicycle.turns import on_tyres as turns_on_tyres
from bicycle.turns.families import Family
from mbsd3d import Sine, Torque, simulate
from mbsd3d.extend import main

BENCHMARK = Meijaard2007()
TYRES = json.loads(Path(__file__).with_name("tyre_truths.json").read_text(encoding="utf-8"))
PUBLISHED = library()["critical_speeds"]
ROUND = replace(BENCHMARK, rR=0.31, tR=0.05, tF=0.03, c=0.055, IHxz=0.011, name="round tyres")


def growth(linear, speed):
    """Fastest growth [1/s] by an eigenvalue solver."""
    return linear.eigenvalues([speed]).real.max()


@pytest.mark.parametrize("module", ["sensitivity", "maps", "why", "frequency"])
def test_examples_print_what_they_say(module):
    found = doctest.testmod(import_module(f"bicycle.linear.{module}"))
    assert found.attempted and not found.failed


# --- critical speeds --------------------------------------------------------------------------------------------------


def test_critical_speeds_are_the_published_ones():
    q = critical.polynomial(BENCHMARK)
    (stable,) = critical.ranges(q)
    for found, key in ((critical.weave(q), "weave"), (critical.capsize(q), "capsize")):
        assert abs(found - float(PUBLISHED[key]["computed"])) < 5e-14  # the data file: no tighter than that
    assert stable == (critical.weave(q), critical.capsize(q))
    assert abs(critical.weave_rate(q, stable.low) - float(PUBLISHED["weave"]["omega_computed"])) < 5e-14


def random_equations(count, seed):
    """M, C1, K0, K2 of random linear equations, some of them stable; the first column of K2 is zero."""
    rng = np.random.default_rng(seed)
    half = rng.normal(size=(count, 2, 2))
    M = half @ half.transpose(0, 2, 1) + 0.1 * np.eye(2)
    C1, K0, K2 = rng.normal(size=(3, count, 2, 2)) + np.array([[1.0, 0.3], [-0.3, 1.0]])
    K2[..., 0] = 0.0
    return M, C1, K0, K2


def spectra(M, C1, K0, K2, v):
    """(n, 4) eigenvalues at the speeds v (n,) by an eigenvalue solver."""
    A, v = np.zeros((len(v), 4, 4)), v[:, None, None]
    A[:, :2, 2:] = np.eye(2)
    A[:, 2:, :2] = -np.linalg.solve(M, K0 + v**2 * K2)
    A[:, 2:, 2:] = -np.linalg.solve(M, v * C1)
    return np.linalg.eigvals(A)


def test_conditions_of_hurwitz_agree_with_eigenvalues_of_random_equations():
    equations = random_equations(3000, seed=4)
    q, v = critical.quartic(*equations), np.random.default_rng(5).uniform(0.1, 6.0, (3000, 1))
    by_conditions = critical.decays(q, v)[:, 0]
    fastest = spectra(*equations, v[:, 0]).real.max(axis=1)
    clear = np.abs(fastest) > 1e-9  # closer to the border rounding decides
    assert 50 < by_conditions.sum() < 2900 and np.array_equal(by_conditions[clear], fastest[clear] < 0.0)
    first = np.transpose(critical.first_range(q))
    for k in range(300):
        found = critical.ranges(critical.Quartic(*(x[k] for x in q)))
        assert any(part.low < v[k, 0] < part.high for part in found) == by_conditions[k]
        assert np.array_equal(first[k], found[0] if found else (np.nan, np.nan), equal_nan=True)


def test_weave_speeds_of_random_equations_have_an_imaginary_pair():
    equations = random_equations(2000, seed=8)
    q = critical.quartic(*equations)
    v, rate = critical.weave(q), critical.weave_rate(q, critical.weave(q))
    exist = np.isfinite(v)
    assert 300 < exist.sum() < 1700
    values = spectra(*(x[exist] for x in equations), v[exist])
    away = np.abs(values - 1j * rate[exist, None]).min(axis=1)
    assert np.all(away < 1e-7 * np.abs(values).max(axis=1))  # rounding; its root where two pairs meet


@pytest.mark.parametrize("name", names())
def test_ranges_of_published_sets_begin_and_end_where_growth_changes_its_sign(name):
    linear = canonical(named(name, unphysical=True))
    found = critical.ranges(critical.polynomial(named(name, unphysical=True)))
    speeds = np.linspace(0.013, 30.0, 700)
    inside = np.any([(speeds > part.low) & (speeds < part.high) for part in found], axis=0) if found else False
    assert np.array_equal(linear.eigenvalues(speeds).real.max(axis=1) < 0.0, inside & np.ones(700, bool))
    for end in (v for part in found for v in part if 0.0 < v < np.inf):
        assert growth(linear, end - 1e-6) * growth(linear, end + 1e-6) < 0.0


def test_a_range_of_a_hundredth_of_a_millimetre_per_second_is_found():
    def width(trail):
        return np.diff(critical.first_range(critical.polynomial(replace(BENCHMARK, c=trail))))[0]

    trail = brentq(lambda c: np.nan_to_num(width(c)) - 1e-5, -0.0085, 0.0, xtol=1e-16)
    (part,) = critical.ranges(critical.polynomial(replace(BENCHMARK, c=trail)))
    assert abs(part.high - part.low - 1e-5) < 1e-10
    linear = canonical(replace(BENCHMARK, c=trail))
    assert growth(linear, sum(part) / 2) < 0.0 < min(growth(linear, part.low - 1e-5), growth(linear, part.high + 1e-5))


def test_ranges_of_the_general_model_with_round_tyres_end_where_its_spectrum_says():
    (part,) = critical.ranges(critical.model_polynomial(ROUND))
    for v in part:
        sides = [general.linearization(whipple, ROUND, x).eigenvalues.real.max() for x in (v - 1e-6, v + 1e-6)]
        assert sides[0] * sides[1] < 0.0
    sharp = critical.ranges(critical.polynomial(replace(ROUND, tR=0.0, tF=0.0)))[0]
    assert abs(part.low - sharp.low) > 1e-3  # crowns do matter


def test_no_speed_leads_a_two_mass_skate_to_capsize():
    q = critical.polynomial(two_mass_skate())
    assert np.isnan(critical.capsize(q)) and critical.ranges(q)[0].high == np.inf
    assert abs(critical.weave(q) - 2.841) < 5e-4  # of the literature, as the data file has it


# --- derivatives ------------------------------------------------------------------------------------------------------


def model_speeds(parameters):
    """Weave, capsize, double root from the general model."""
    q = critical.model_polynomial(parameters, check=False)
    return np.array([critical.weave(q), critical.capsize(q), double_roots(q)[0].speed])


@pytest.mark.parametrize("key", ["w", "c", "lam", "g", "rF", "xB", "zB", "mB", "IBxz", "xH", "IHxz", "IFxx", "IRyy"])
def test_derivatives_agree_with_differences_of_the_general_model(key):
    base = replace(BENCHMARK, IFyy=0.2, IRyy=0.11)  # off the limit of the triangle rule
    found = sensitivity.derivatives(base)
    h = 1e-3 * max(abs(getattr(base, key)), 0.1)
    speeds = [model_speeds(replace(base, **{key: getattr(base, key) + k * h})) for k in (-2, -1, 1, 2)]
    slopes = (speeds[0] - 8 * speeds[1] + 8 * speeds[2] - speeds[3]) / (12 * h)
    known = np.array([x[key] for x in found.by.values()])
    # truncation h^4 = 1e-12 times fifth derivatives, rounding 1e-11 / h
    assert np.all(np.abs(slopes - known) < 1e-6 * np.maximum(np.abs(known), 1e-2 / max(abs(getattr(base, key)), 0.1)))


def test_derivatives_obey_the_rules_of_dimensions():
    found = sensitivity.derivatives(named("Crescendo"))
    mass = [key for key in BENCHMARK.values() if key[0] in "mI"]
    length = {key: 1.0 for key in ("w", "c", "rR", "xB", "zB", "xH", "zH", "rF")} | {
        k: 2.0 for k in BENCHMARK.values() if k[0] == "I"
    }
    for name, v in found.speeds.items():
        change = {key: getattr(found.parameters, key) * slope for key, slope in found.by[name].items()}
        size = sum(map(abs, change.values()))
        assert abs(sum(change[key] for key in mass)) < 1e-12 * size  # twice the mass, the same speed
        assert abs(sum(k * change[key] for key, k in length.items()) - v / 2) < 1e-12 * size  # v^2 / (g L) stays
        assert abs(change["g"] - v / 2) < 1e-12 * size


@pytest.mark.parametrize("name", ["Benchmark", "Crescendo", "HC_Bluenose", "HC_Optimal06"])
def test_the_double_root_is_where_two_growing_modes_meet(name):
    """Decaying modes of the last three meet at a lower speed."""
    v = sensitivity.derivatives(named(name)).speeds["double root"]
    low, high = np.sort(canonical(named(name)).eigenvalues([v])[0].real)[-2:]
    assert low > 0.0 and high - low < 1e-5 * high  # a double eigenvalue is known to the root of rounding


def test_derivatives_of_the_general_model_are_those_of_the_closed_form():
    closed, model = sensitivity.derivatives(BENCHMARK), sensitivity.derivatives(BENCHMARK, whipple)
    for name, slopes in closed.by.items():
        assert abs(closed.speeds[name] - model.speeds[name]) < 1e-10
        for key, slope in slopes.items():
            change = max(abs(getattr(BENCHMARK, key)), 0.1)  # differences of 1e-3 of this
            # truncation 1e-12 times fifth derivatives, and rounding 1e-11 over the step
            assert abs(model.by[name][key] - slope) * change < 1e-7 * closed.speeds[name]


@pytest.mark.slow
def test_derivatives_by_forward_differences_next_to_zero():
    light = replace(BENCHMARK, mR=1.5e-4, name="light rear wheel")  # a central difference would need negative masses
    closed, model = sensitivity.derivatives(light), sensitivity.derivatives(light, whipple)
    for name, slopes in closed.by.items():
        # a wheel of 0.15 g makes 1e-9 m/s of rounding, which stands over a step of 1e-4 kg
        assert abs(model.by[name]["mR"] - slopes["mR"]) < 1e-4 < abs(slopes["mR"])


@pytest.mark.parametrize("zero", ["IFyy", *(pytest.param(x, marks=pytest.mark.slow) for x in ("IRyy", "IFxx"))])
def test_derivatives_by_forward_differences_where_a_wheel_has_no_inertia(zero):
    point = replace(BENCHMARK, **{zero: 0.0}, unphysical=True)
    closed, model = sensitivity.derivatives(point), sensitivity.derivatives(point, whipple)
    for name, slopes in closed.by.items():
        for key, slope in slopes.items():
            change = max(abs(getattr(point, key)), 0.1)
            # one-sided: six times the truncation and seven times the rounding of central differences
            assert abs(model.by[name][key] - slope) * change < 1e-6 * closed.speeds[name]


@pytest.mark.parametrize("side", [1e-12, -1e-12])
def test_an_answer_against_the_torque_is_drawn_at_180_degrees(side):
    """On whichever side of the cut of the angle rounding puts it."""
    H = np.full((1, 3, 2, 2), -1.0 + 1j * side)
    found = frequency.Response(BENCHMARK, np.array([5.0]), np.array([0.1, 1.0, 10.0]), H, np.array([-1.0]))
    phases = [axes.lines[0].get_ydata() for axes in frequency.plot_response(found).axes if "phase" in axes.get_ylabel()]
    assert len(phases) == 2
    assert np.array(phases) == pytest.approx(180.0)


@pytest.mark.parametrize("kind", sensitivity.DIFFERENCES)
def test_differences_are_exact_for_polynomials_of_fourth_degree(kind):
    places, weights = sensitivity.DIFFERENCES[kind]
    slopes = [np.dot(weights, np.array(places, float) ** degree) for degree in range(5)]
    assert slopes == pytest.approx([0, 1, 0, 0, 0], abs=1e-12)


@pytest.mark.slow
def test_a_crown_as_large_as_its_wheel_can_only_become_smaller():
    ball = replace(BENCHMARK, tR=BENCHMARK.rR, tF=0.01)
    assert np.isfinite([*sensitivity.derivatives(ball, whipple).by["weave"].values()]).all()


def test_a_body_without_mass_has_no_derivative_by_its_inertia():
    with pytest.raises(ValueError, match="IRxx = 0 can be changed to neither side .* mass is 0 but inertia is not"):
        sensitivity.derivatives(named("Tms"), whipple)


@pytest.mark.slow
def test_derivatives_with_round_tyres_obey_the_rule_of_lengths():
    found = sensitivity.derivatives(ROUND, whipple)
    length = dict.fromkeys(("w", "c", "rR", "xB", "zB", "xH", "zH", "rF", "tR", "tF"), 1.0)
    length |= {key: 2.0 for key in BENCHMARK.values() if key[0] == "I"}
    for name, v in found.speeds.items():
        change = [k * getattr(ROUND, key) * found.by[name][key] for key, k in length.items()]
        assert abs(sum(change) - v / 2) < 1e-8 * sum(map(abs, change))
        assert abs(ROUND.tR * found.by[name]["tR"]) > 1e-3  # crowns do matter


def test_derivatives_print_and_write_all_parameters(tmp_path):
    found = sensitivity.derivatives(BENCHMARK)
    rows = found.to_csv(tmp_path / "slopes").read_text().splitlines()
    assert len(rows) == 27 and rows[2].startswith("c,0.08,") and f"{found.by['weave']['c']!r}" in rows[2]
    assert "trail" in str(found) and len(sensitivity.plot_derivatives(found).axes) == 3
    with pytest.raises(ValueError, match="HC_Optimal10': it has neither weave nor capsize"):
        sensitivity.derivatives(named("HC_Optimal10"))
    with pytest.raises(ValueError, match="knife-edge"):
        sensitivity.derivatives(ROUND)


# --- uncertainty ------------------------------------------------------------------------------------------------------

MEASURED = named("Browserins")


def test_small_deviations_spread_the_speeds_as_the_derivatives_say():
    slopes, small = sensitivity.derivatives(MEASURED), {"c": 1e-5, "lam": 2e-5, "xH": 1e-5, "IFyy": 3e-6, "mF": 1e-4}
    found = sensitivity.monte_carlo(MEASURED, small, n=20_000, seed=3)
    for name in ("weave", "capsize"):
        values = found.outputs[f"{name} speed"]
        # the standard deviation of 20 000 samples is known to 0.5 %
        assert abs(values.std() / slopes.spread(name, small) - 1.0) < 0.025
        assert found.share(f"{name} speed") == 1.0
        assert abs(found.quantiles(f"{name} speed")[1] - slopes.speeds[name]) < 0.05 * values.std()
    n = 1024
    indices = sensitivity.sobol(MEASURED, small, n=n, seed=3)
    for name in ("weave", "capsize"):
        variances = np.array([(slopes.by[name][key] * std) ** 2 for key, std in small.items()])
        for shares in (indices.first, indices.total):  # linear: both are the shares; Sobol's points err by 2/n ... 10/n
            assert np.abs(shares[f"{name} speed"] - variances / variances.sum()).max() < 16 / n


def test_samples_repeat_with_their_seed_and_go_to_a_file(tmp_path):
    first, second, other = (sensitivity.monte_carlo(MEASURED, n=50, seed=seed) for seed in (5, 5, 6))
    assert np.array_equal(first.inputs, second.inputs) and not np.array_equal(first.inputs, other.inputs)
    assert len(first.deviations) == 26  # as published with this set
    rows = first.to_csv(tmp_path / "samples").read_text().splitlines()
    assert len(rows) == 51 and rows[1].count(",") == 29
    assert float(rows[1].split(",")[26]) == first.outputs["weave speed"][0]


def test_samples_with_an_inertia_that_no_body_has_are_counted():
    base = replace(BENCHMARK, IBxx=3.0, IBzz=9.5, IBxz=0.0, name="long")  # 1.5 kg m^2 from the limit IByy < IBxx + IBzz
    found = sensitivity.monte_carlo(base, {"IByy": 1.5}, n=4000, seed=2)
    outside = found.inputs[:, 0]
    assert abs(found.impossible - np.mean((outside > 12.5) | (outside < 6.5))) == 0.0
    assert abs(found.impossible - 0.16) < 0.02 and "% have an inertia of frame or fork" in str(found)


def test_samples_are_judged_by_their_principal_moments():
    keys = ("IBxx", "IByy", "IBzz", "IBxz")
    base = replace(BENCHMARK, IBxx=3.0, IByy=11.0, IBzz=9.5, IBxz=4.2, name="long")
    found = sensitivity.monte_carlo(base, dict.fromkeys(keys, 0.5), n=2000, seed=3)
    xx, yy, zz, xz = found.inputs.T
    mean, radius = (xx + zz) / 2.0, np.hypot((xx - zz) / 2.0, xz)
    moments = np.sort([mean - radius, mean + radius, yy], axis=0)
    assert found.impossible == np.mean(moments[2] > moments[0] + moments[1]) and 0.1 < found.impossible < 0.9
    plain = np.mean((xx + zz < yy) | (xx + yy < zz) | (yy + zz < xx))
    assert found.impossible > plain + 0.05  # the product of inertia matters


def test_speeds_that_some_samples_do_not_have_are_counted():
    narrow = replace(BENCHMARK, c=-0.007, name="narrow")
    found = sensitivity.monte_carlo(narrow, {"c": 0.002}, n=4000, seed=1)
    share = found.share("lowest stable speed")
    assert abs(share - 0.6915) < 0.03  # stable from c = -0.008 on, half a deviation away; 4 sigma of 4000 samples
    assert np.sum(found.outputs["stable width"] == 0.0) == np.sum(np.isnan(found.outputs["lowest stable speed"]))
    indices = sensitivity.sobol(narrow, {"c": 0.002, "mB": 1.0}, n=256)
    assert np.isnan(indices.total["lowest stable speed"]).all() and indices.total["stable width"][0] > 0.9


@pytest.mark.parametrize(
    ("deviations", "options", "message"),
    [
        (None, {}, "no standard deviations; give them by symbol"),
        ({"cc": 0.1}, {}, "deviation of 'cc': no such parameter"),
        ({"c": -0.1}, {}, "deviation of c: -0.1"),
        ({"tR": 0.01}, {}, "deviation of tR: samples are solved for knife-edge wheels; leave it out"),
        ({"c": "much"}, {}, "deviation of c: expected a number, got 'much'"),
        ({"rF": 0.3}, {}, "a sample has rF = -.*give a smaller deviation of rF"),
        ({"lam": 0.5}, {}, "a sample has lam = .*give a smaller deviation of lam"),
        ({"c": 0.01}, {"n": 1}, "n = 1; give a whole number >= 2"),
        ({"c": 0.01}, {"seed": -1}, "seed = -1; give a whole number >= 0"),
    ],
)
def test_impossible_deviations_are_refused(deviations, options, message):
    with pytest.raises(ValueError, match=message):
        sensitivity.monte_carlo(BENCHMARK, deviations, **options)
    if "sample" not in message:
        with pytest.raises(ValueError, match=message):
            sensitivity.sobol(BENCHMARK, deviations, **options)


# --- maps -------------------------------------------------------------------------------------------------------------

AXES = {"c": [-0.02, 0.04, 0.11], "lam": [0.12, 0.33]}


def test_a_map_holds_the_ranges_of_its_cells_both_ways(tmp_path):
    closed, model = sensitivity.stable_map(BENCHMARK, AXES), sensitivity.stable_map(BENCHMARK, AXES, whipple)
    for i, c in enumerate(AXES["c"]):
        for j, lam in enumerate(AXES["lam"]):
            found = critical.ranges(critical.polynomial(replace(BENCHMARK, c=c, lam=lam)))
            low, high = found[0] if found else (np.nan, np.nan)
            for chart, limit in ((closed, 1e-13), (model, 1e-10)):
                assert np.allclose([chart.low[i, j], chart.high[i, j]], [low, high], rtol=0, atol=limit, equal_nan=True)
    assert np.isnan(closed.low).any() and np.isfinite(closed.low).any() and model.missing == 0
    rows = closed.to_csv(tmp_path / "map").read_text().splitlines()
    assert rows[0] == "c [m],lam [rad],low [m/s],high [m/s]" and len(rows) == 7
    assert float(rows[4].split(",")[2]) == closed.low[1, 1]
    assert [axes.get_title() for axes in sensitivity.plot_map(closed).axes[:2]] == [
        "lowest self-stable speed",
        "width of the self-stable range",
    ]


@pytest.mark.parametrize("name", ["c", "mB", "lam"])
def test_stable_speeds_over_one_parameter_end_where_growth_changes_its_sign(name):
    values = getattr(BENCHMARK, name) * np.array([1.3, 0.6, 1.0])
    found = sensitivity.stable_speeds(BENCHMARK, name, values)
    assert np.array_equal(found.values, np.sort(values)) and np.isfinite(found.low).all()
    for k, value in enumerate(found.values):
        linear = canonical(replace(BENCHMARK, **{name: value}))
        for speed, inside in ((found.low[k], 1.0), (found.high[k], -1.0)):
            root = brentq(lambda v, linear=linear: growth(linear, v), speed - 0.01, speed + 0.01, xtol=1e-13)
            assert abs(root - speed) < 1e-8  # [m/s] growth has rounding errors of some 1e-13 1/s and a slope of order 1
            assert growth(linear, speed + 1e-4 * inside) < 0.0 < growth(linear, speed - 1e-4 * inside)
        assert found.ranges(k)[0] == (found.low[k], found.high[k])
    assert found.weave[1] == found.low[1] and found.capsize[1] == found.high[1]


def test_stable_speeds_of_the_general_model_with_round_tyres(tmp_path):
    values = [0.04, 0.06, 0.09]
    model = sensitivity.stable_speeds(BENCHMARK, "c", values, whipple)
    closed = sensitivity.stable_speeds(BENCHMARK, "c", values)
    assert np.allclose([model.low, model.high], [closed.low, closed.high], rtol=0, atol=1e-10)  # as maps
    crowns = sensitivity.stable_speeds(ROUND, "tF", [0.0, 0.03], whipple)
    assert crowns.ranges(1) == critical.critical_speeds(ROUND, whipple).stable
    rows = closed.to_csv(tmp_path / "trail").read_text().splitlines()
    assert rows[0] == "c [m],weave [m/s],capsize [m/s],low [m/s],high [m/s]" and len(rows) == 4
    assert float(rows[2].split(",")[3]) == closed.low[1]


def test_stable_speeds_show_where_there_are_none():
    found = sensitivity.stable_speeds(BENCHMARK, "c", np.linspace(-0.05, 0.1, 31))
    none = np.isnan(found.low)
    assert none[0] and not none[-1] and found.ranges(0) == [] and np.array_equal(none, ~found.stable.any(axis=1))
    assert "c = -0.05 m: stable at no speed" in str(found) and f"for {np.sum(~none)} values" in str(found)
    (axes,) = found.figure().axes
    assert axes.get_xlabel() == "trail c [m]"
    assert [line.get_label() for line in axes.lines] == ["weave", "capsize", "as built"]
    skate = sensitivity.stable_speeds(two_mass_skate(), "mB", [8.0, 10.0])  # nothing ends its range
    assert np.isinf(skate.high).all() and skate.figure(dark=True).axes[0].get_ylim()[1] < 100.0


def test_stable_speeds_keep_what_was_computed_before_ctrl_c():
    calls = []

    def interrupted(parameters, speed):
        calls.append(speed)
        if len(calls) > 3:
            raise KeyboardInterrupt
        return whipple(parameters, speed)

    found = sensitivity.stable_speeds(BENCHMARK, "c", [0.04, 0.06, 0.08, 0.1], interrupted)
    done = 4 - found.missing
    assert 1 <= done < 4 and np.isnan(found.low[done:]).all() and np.isfinite(found.low[:done]).all()
    assert f"{found.missing} left out by Ctrl-C" in str(found)


@pytest.mark.parametrize(
    ("name", "values", "message"),
    [
        ("cc", [0.1, 0.2], "stable_speeds of 'Meijaard2007': there is no parameter 'cc'"),
        ("c", [0.1], "one value of c; give two or more"),
        ("w", [1.0, -1.0], "wheelbase w: -1.0 is not positive"),
        ("tR", [0.0, 0.1], "closed form has no crown radius"),
    ],
)
def test_impossible_values_of_one_parameter_are_refused(name, values, message):
    with pytest.raises(ValueError, match=message):
        sensitivity.stable_speeds(BENCHMARK, name, values)


def test_a_map_keeps_what_was_computed_before_ctrl_c():
    calls = []

    def interrupted(parameters, speed):
        calls.append(speed)
        if len(calls) > 3:
            raise KeyboardInterrupt
        return whipple(parameters, speed)

    found = sensitivity.stable_map(BENCHMARK, {"c": [0.04, 0.06, 0.08, 0.1], "lam": [0.3]}, interrupted)
    whole = sensitivity.stable_map(BENCHMARK, {"c": [0.04, 0.06, 0.08, 0.1], "lam": [0.3]})
    done = 4 - found.missing
    assert 1 <= done < 4 and np.allclose(found.low[:done], whole.low[:done], rtol=0, atol=1e-10)
    assert np.isnan(found.low[done:]).all()


def test_endless_ranges_of_a_map_are_no_blanks():
    found = sensitivity.stable_map(two_mass_skate(), {"c": [0.0, 0.01], "zB": [-1.2, -1.0, 0.3]})
    assert np.isinf(found.high).any() and np.isnan(found.high).any()
    for axes in sensitivity.plot_map(found).axes[:2]:
        shown = np.ma.getmaskarray(axes.collections[0].get_array()).reshape(3, 2)
        assert np.array_equal(shown, np.isnan(found.low.T))


def test_sets_that_are_left_out_share_one_line():
    found, left_out = compare.chosen([], unphysical=False)
    assert len(found) == 1 + 47 - 8 and len(left_out) == 1 and "Browser, HC_Yellow" in left_out[0]
    assert compare.chosen([], unphysical=True)[1] == []


@pytest.mark.parametrize(
    ("axes", "message"),
    [
        ({"c": [0.1]}, "1 parameters; give two"),
        ({"c": [0.1], "lambda": [0.1]}, "no parameter 'lambda'"),
        ({"c": [0.1], "lam": [np.nan]}, "values of lam"),
        ({"c": [0.1], "lam": "steep"}, "values of lam: 'steep'; give a list of finite numbers"),
        ({"c": [0.1], "w": [1.0, -1.0]}, "wheelbase w: -1.0 is not positive"),
        ({"c": [0.1], "IBxx": [9.0, 30.0]}, "frame and rider .B.: inertia .* exceeds the sum"),
        ({"tR": [0.0, 0.4], "c": [0.1]}, "tR = 0.4 exceeds rR"),
        ({"tR": [0.0, 0.1], "c": [0.1]}, "closed form has no crown radius"),
    ],
)
def test_impossible_maps_are_refused(axes, message):
    with pytest.raises(ValueError, match=message):
        sensitivity.stable_map(BENCHMARK, axes)


@pytest.mark.parametrize("study", [sensitivity.derivatives, why.ablations, lambda p: sensitivity.stable_map(p, AXES)])
def test_a_name_is_no_set(study):
    with pytest.raises(ValueError, match=r"parameters = 'Rigid'; give a set, e.g. bicycle.named"):
        study("Rigid")


# --- why --------------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_ablations_of_the_benchmark_are_confirmed_by_the_general_model(tmp_path):
    found = why.ablations(BENCHMARK)
    rows = {row.name: row for row in found.rows}
    assert len(rows) == 16 and found.missing == 0
    assert all(row.confirmed and row.difference < 1e-10 for row in found.rows)
    for name in ("no spin momentum", "no trail, no spin momentum", "steering locked"):
        assert rows[name].ranges == [] and rows[name].growth > 1.0
    (narrow,) = rows["no trail"].ranges
    assert abs(narrow.high - narrow.low - 0.196) < 1e-3  # 0.2 m/s wide, and found
    fall = np.sqrt(9.81 * 80.95 / 80.81722)  # the printed matrices
    assert abs(rows["steering locked"].growth - fall) < 1e-12
    assert rows["two-mass skate: no trail, no spin"].ranges[0].high == np.inf
    lines = why.to_csv(found, tmp_path / "why").read_text().splitlines()
    assert len(lines) == 1 + len(found.rows) and "2.933073 ... 3.128986 m/s" in str(found)


@pytest.mark.parametrize("hanging", [{"zB": 0.9}, {"g": 0.0}])
def test_a_locked_bicycle_that_hangs_or_floats_does_not_fall(hanging):
    row = why.locked(replace(BENCHMARK, **hanging), whipple, 5.0)
    assert row.growth == 0.0 and row.confirmed


def test_growths_of_ablations_are_those_of_an_eigenvalue_solver():
    found = why.ablations(MEASURED, None)
    for row in found.rows:
        if row.name != "steering locked":
            assert abs(row.growth - growth(canonical(row.parameters), found.speed)) < 1e-9
    balanced = {row.name: row.parameters for row in found.rows}["front mass on the steer axis"]
    p, mass = balanced, balanced.mH + balanced.mF
    x, z = (p.mH * p.xH + p.mF * p.w) / mass, (p.mH * p.zH - p.mF * p.rF) / mass
    away = (x - p.w - p.c) * np.cos(p.lam) - z * np.sin(p.lam)  # distance from the steer axis
    assert abs(away) < 1e-15  # some roundings of lengths below 1 m


def test_ablations_keep_what_was_computed_before_ctrl_c():
    calls = []

    def interrupted(parameters, speed):
        calls.append(speed)
        if len(calls) > 12:
            raise KeyboardInterrupt
        return whipple(parameters, speed)

    found = why.ablations(BENCHMARK, interrupted)
    assert 0 < len(found.rows) < 5 and found.missing == 16 - len(found.rows)
    assert all(row.confirmed for row in found.rows) and len(why.plot_ablations(found).axes) == 1


def test_a_variant_that_cannot_be_had_says_why_and_the_others_stay():
    found = why.ablations(two_mass_skate(), None)
    problems = {row.name: row.problem for row in found.rows if row.problem}
    assert list(problems) == ["front mass on the steer axis"] and "steer has no inertia" in str(found)
    assert all(np.isfinite(row.growth) for row in found.rows if not row.problem)
    light = replace(BENCHMARK, mH=0.0, IHxx=0.0, IHyy=0.0, IHzz=0.0, IHxz=0.0)
    assert "the fork has no mass (mH = 0)" in str(why.ablations(light, None))


def test_what_another_model_does_is_not_confirmed():
    def heavier(parameters, speed):
        return whipple(replace(parameters, mB=parameters.mB + 0.01), speed)

    def falls_faster(parameters, speed):
        return whipple(replace(parameters, IBzz=parameters.IBzz + 0.01), speed)

    assert why.ablated("as built", BENCHMARK, heavier, 5.0).confirmed is False
    vertical = replace(BENCHMARK, lam=0.0)  # stable at no speed, so that its growth alone tells
    assert why.ablated("vertical", vertical, whipple, 5.0).confirmed
    assert why.ablated("vertical", vertical, falls_faster, 5.0).confirmed is False
    found = why.ablated("as built", BENCHMARK, whipple, 5.0)
    beside = [critical.Range(part.low, part.high + 3e-6) for part in found.ranges]
    assert found.confirmed and not why.in_spectrum(replace(found, ranges=beside), whipple, 5.0)


def test_a_slow_capsize_is_confirmed_too():
    bluenose = replace(named("HC_Bluenose"), IRyy=0.0)  # growth changes by 3e-4 1/s per m/s
    found = why.ablated("rear wheel without spin momentum", bluenose, whipple, 9.0)
    assert found.confirmed and found.difference < 1e-9


@pytest.mark.slow
def test_ablations_with_round_tyres_come_from_the_general_model():
    found = why.ablations(ROUND)
    assert all(row.confirmed in (True, None) for row in found.rows) and found.rows[0].model == found.rows[0].ranges
    with pytest.raises(ValueError, match="knife-edge"):
        why.ablations(ROUND, None)


@pytest.mark.slow
def test_ablations_on_tyres(tmp_path):
    """Ranges that an independent program has, growths of an eigenvalue solver, and ideal wheels beside them."""
    found = why.ablations(BENCHMARK, tyres=TYPICAL, progress=False)
    rows = {row.name: row for row in found.rows}
    assert not any(row.problem for row in found.rows) and found.missing == 0
    plain, trailing = (TYRES["straight_running"]["rows"][k]["stability_limits"] for k in (0, 3))
    wanted = {0.02: [at["v"] for at in trailing], 0.0: [at["v"] for at in plain]}
    assert rows["as built"].ranges[0] == pytest.approx(wanted[0.02], rel=1e-9)
    assert rows["tyres without pneumatic trail"].ranges[0] == pytest.approx(wanted[0.0], rel=1e-9)
    ideal = {row.name: row for row in why.ablations(BENCHMARK, None).rows}
    for name, row in rows.items():
        if row.ideal and name in ideal:
            assert critical.difference(row.ideal, ideal[name].ranges) < 1e-9, name
    heavy = eigenvalues(partial(whipple, tyres=TYPICAL), rows["fork 0.1 m back"].parameters, [found.speed])
    assert rows["fork 0.1 m back"].growth == pytest.approx(heavy.real.max(), abs=1e-9)
    assert rows["steering locked"].growth == pytest.approx(
        ideal["steering locked"].growth, rel=0.02
    )  # slip helps little
    assert "ideal wheels: 4.292383 ... 6.024262 m/s" in str(found)
    assert len(why.plot_ablations(found).axes) == 1
    assert why.to_csv(found, tmp_path / "why").read_text().splitlines()[1].startswith("as built,4.49779")
    with pytest.raises(ValueError, match="without tyres; give tyres"):
        why.ablations(BENCHMARK, head_stiffness=1e3)
    with pytest.raises(ValueError, match="leave out standing_damping"):
        why.ablations(BENCHMARK, tyres=TYPICAL | {"standing_damping": 0.1})


# --- frequency --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("parameters", [BENCHMARK, named("Yellowrev", unphysical=True)], ids=["benchmark", "Yellowrev"])
def test_frequency_response_of_the_general_model_is_that_of_the_closed_form(parameters):
    speeds, omega = [1.7, 5.0, 8.3], np.geomspace(0.05, 80.0, 9)
    found = frequency.response(parameters, speeds, omega)
    for v, H, fastest in zip(speeds, found.H, found.growth, strict=True):
        linear = canonical(parameters)
        for w, h in zip(omega, H, strict=True):  # the inverse of the dynamic stiffness, not of a state space
            stiffness = -(w**2) * linear.M + 1j * w * v * linear.C1 + linear.g * linear.K0 + v**2 * linear.K2
            known = np.linalg.inv(stiffness)
            assert np.abs(h - known).max() < 1e-10 * np.abs(known).max()
        assert abs(fastest - growth(linear, v)) < 1e-9


def test_a_slow_torque_to_one_side_leads_to_the_other_below_the_capsize_speed():
    slow, fast = frequency.response(BENCHMARK, [5.0, 8.0], [1e-5]).H[:, 0, :, 1].real
    assert np.all(slow < 0.0) and np.all(fast > 0.0)


def test_a_shaken_handlebar_answers_as_the_frequency_response_says():
    speed, omega, size = 5.0, 6.0, 1e-3
    bicycle = whipple(BENCHMARK, speed)
    fork, frame, down = bicycle.part("fork"), bicycle.part("frame"), bicycle.part("steer", "joints").axis
    shake = [Torque(body, [Sine(sign * size * x, omega / (2 * np.pi)) for x in down], frame="body")
             for body, sign in ((fork, 1.0), (frame, -1.0))]  # fmt: skip
    t = 44.0 + np.linspace(0.0, 2 * np.pi / omega, 65)[:-1]  # the slowest mode has decayed by exp(-0.32 * 44) = 7e-7
    run = simulate(replace(bicycle, forces=shake), float(t[-1]), rtol=1e-10, output=np.r_[0.0, t])
    steer = run.angle("steer")[1:]
    answer = 2j * np.mean(steer * np.exp(-1j * omega * t)) / size
    known = frequency.response(BENCHMARK, speed, [omega]).H[0, 0, 1, 1]
    assert abs(answer - known) < 1e-5 * abs(known)  # what is left of the start, and of amplitude^2


def test_frequency_response_on_stiff_tyres_is_that_of_ideal_wheels():
    """The difference is of first order in 1/C and in the relaxation, and grows with the frequency."""
    omega = [0.05, 2.0, 30.0]
    known = frequency.response(BENCHMARK, 4.0, omega).H
    stiff = {"cornering": 1e6, "camber": 1.0, "relaxation": 1e-5, "stiffness": 1e6}
    found = frequency.response(BENCHMARK, 4.0, omega, tyres=stiff)
    assert np.abs(found.H - known).max(axis=(0, 2, 3)) == pytest.approx(0.0, abs=5e-6 * np.abs(known).max())
    assert len(frequency.plot_response(found, beside=found).axes) == 8
    for wrong in ({"build": None, "tyres": stiff}, {"steer_damping": 1.0}):
        with pytest.raises(ValueError, match="ideal wheels; leave out tyres|without tyres; give tyres"):
            frequency.response(BENCHMARK, 4.0, omega, **wrong)


def test_a_shaken_handlebar_on_tyres_answers_as_the_frequency_response_says():
    """The nonlinear run, with slip, at a frequency between weave and wobble."""
    speed, omega, size, start = 5.0, 20.0, 1e-3, 21.0  # the weave has decayed by exp(-0.57 * 21) = 6e-6
    t = start + np.linspace(0.0, 4 * np.pi / omega, 65)[:-1]
    shake, times = Sine(size, omega / (2 * np.pi)), np.r_[0.0, t]
    shaken = ride.run(BENCHMARK, t[-1], speed=speed, torque=shake, tyres=TYPICAL, rtol=1e-10, output=times)
    answer = 2j * np.mean(shaken.steer[1:] * np.exp(-1j * omega * t)) / size
    known = frequency.response(BENCHMARK, speed, [omega], tyres=TYPICAL).H[0, 0, 1, 1]
    assert abs(answer - known) < 1e-4 * abs(known)  # what is left of the start, hundred times as large as the answer


@pytest.mark.parametrize("frequencies", [[0.0], [-1.0], [np.nan], [], [[1.0]]])
def test_impossible_frequencies_are_refused(frequencies):
    with pytest.raises(ValueError, match="frequencies: .*; give one or more positive ones"):
        frequency.response(BENCHMARK, 5.0, frequencies)


def test_frequency_table_holds_every_point(tmp_path):
    found = frequency.response(BENCHMARK, [4.0, 6.0], [1.0, 2.0, 3.0], None)
    rows = [row.split(",") for row in found.to_csv(tmp_path / "bode").read_text().splitlines()]
    assert len(rows) == 7 and float(rows[5][2]) == found.H[1, 1, 0, 0].real
    figure = frequency.plot_response(found, dark=True)
    assert len(figure.axes) == 8 and figure.axes[0].get_ylabel() == "magnitude [rad/(N m)]"


# --- comparison -------------------------------------------------------------------------------------------------------


def test_an_ellipsoid_is_drawn_with_its_own_axes():
    mass, a, b, c, turn = 7.3, 0.9, 0.31, 0.2, 0.6  # semi-axes in the plane and across it, turned from x to z
    second = np.diag([a**2, c**2, b**2]) * mass / 5.0
    R = np.array([[np.cos(turn), 0.0, -np.sin(turn)], [0.0, 1.0, 0.0], [np.sin(turn), 0.0, np.cos(turn)]])
    moments = R @ second @ R.T
    semi, found = semi_axes(np.trace(moments) * np.eye(3) - moments, mass)
    assert np.allclose(semi, [b, a], rtol=1e-12, atol=0)  # by rising length
    assert abs(np.sin(np.radians(found) - turn - np.pi / 2)) < 1e-12  # an axis has no direction


def test_wheel_loads_and_masses_of_the_page_are_the_published_ones():
    found, loads = compare.entry(BENCHMARK), library()["static_wheel_loads"]
    total = loads["rear_N"] + loads["front_N"]
    assert abs(BENCHMARK.front_load - loads["front_N"] / total) < 1e-14 and abs(BENCHMARK.mass * 9.81 - total) < 1e-9
    assert found.difference < 1e-10 and "with rider" in found.source


def test_a_page_shows_all_bicycles_and_needs_no_network(tmp_path):
    wanted = [BENCHMARK, named("Tms"), ROUND]
    found = compare.entries(wanted)
    page = write_page(tmp_path, found, left_out=["bicycle 'Bent': <no frame>"], views=0).read_text()
    for text in (
        "Meijaard2007",
        "round tyres",
        "4.2924",
        "at which speeds",
        "Left out: bicycle &#39;Bent&#39;: &lt;no",
    ):
        assert text in page
    assert page.count("<article") == 3 and "http://" not in page.replace("http://www.w3.org", "")
    assert page == write_page(tmp_path, found, left_out=["bicycle 'Bent': <no frame>"], views=0).read_text()
    assert len(page) < 200_000 and not (tmp_path / "views").exists()
    rows = compare.to_csv(found, tmp_path / "bicycles").read_text().splitlines()
    assert len(rows) == 4 and rows[1].startswith("Meijaard2007,4.29238")
    with pytest.raises(ValueError, match="two bicycles are called 'Tms'"):
        write_page(tmp_path, [found[1], found[1]])
    with pytest.raises(ValueError, match="no bicycles"):
        write_page(tmp_path, [])


@pytest.mark.slow
def test_views_stand_beside_the_page(tmp_path):
    page = write_page(tmp_path, compare.entries([BENCHMARK, MEASURED]), views=1).read_text()
    assert (tmp_path / "views" / "Meijaard2007.html").stat().st_size > 100_000
    assert 'href="views/Meijaard2007.html"' in page and "views/Browserins" not in page


@pytest.mark.slow
@pytest.mark.slow
def test_a_page_shows_what_ideal_wheels_leave_out(tmp_path):
    """Beside the ranges of ideal wheels; a skate, whose wheels have no inertia, says why it does not run on tyres."""
    skate = run("compare", "Meijaard2007", "Tms", "--tyre", "trail=0", "--views", 0, "--out", tmp_path)
    assert skate.exit_code == 0 and "4.292383 ... 6.024262 m/s  4.254140 ... 5.956966 m/s" in skate.output
    assert "not possible: bicycle 'Tms': IRyy and IFyy = 0: on a tyre a wheel turns freely" in skate.output
    page = (tmp_path / "compare" / "index.html").read_text()
    assert "4.254 … 5.957" in page and "Effects that ideal wheels leave out" in page and "not possible" in page
    first, second = (tmp_path / "compare" / "bicycles.csv").read_text().splitlines()[1:]
    assert float(first.split(",")[5]) == pytest.approx(4.25414, abs=1e-5) and second.split(",")[5] == "nan"
    assert (tmp_path / "compare" / "ideal_or_tyres_Meijaard2007.png").stat().st_size > 20_000
    with pytest.raises(ValueError, match="no tyres to compare"):
        ideal_or_tyres.figure(BENCHMARK, {})


@pytest.mark.slow
def test_all_published_sets_are_compared():
    found = compare.entries([named(name, unphysical=True) for name in names()])
    assert len(found) == 47 and max(x.difference for x in found) < 1e-8  # the largest belongs to 19 m/s
    assert all("<svg" in side_view(x.parameters) for x in found)


# --- command line -----------------------------------------------------------------------------------------------------


def run(*arguments):
    return CliRunner().invoke(main, ["bicycle", *map(str, arguments)], prog_name="mbsd3d")


def names_in(folder):
    return {path.name for path in folder.rglob("*") if path.is_file()}


def test_commands_write_what_they_say(tmp_path):
    result = run("why", "Crescendo", "--closed-form", "--out", tmp_path)
    assert result.exit_code == 0 and "4.804625 ... 6.105215 m/s" in result.output
    assert names_in(tmp_path) == {"why_Crescendo.png", "why_Crescendo.svg", "why_Crescendo.csv"}
    result = run("compare", "Meijaard2007", "Tms", "--views", 0, "--out", tmp_path / "two")
    assert result.exit_code == 0 and "above 2.84" in result.output
    assert names_in(tmp_path / "two") == {"bicycles.csv", "index.html"}


@pytest.mark.slow
def test_commands_with_many_figures_write_what_they_say(tmp_path):
    maps = ("--map", "c=0:0.1:3", "--map", "lam=0.2:0.5:3")
    result = run("sensitivity", "Browserins", "--samples", 100, *maps, "--out", tmp_path)
    assert result.exit_code == 0, result.output
    assert "100 samples of Browserins" in result.output and "in 100.0 % of them" in result.output
    assert run("frequency", "--speed", 4.5, "--count", 5, "--out", tmp_path).exit_code == 0
    stems = ("sensitivity_Browserins", "uncertainty_Browserins", "map_Browserins", "frequency_Meijaard2007")
    pictures = {f"{stem}.{kind}" for stem in stems for kind in ("png", "svg", "csv")}
    assert names_in(tmp_path) == pictures | {"sobol_Browserins.csv"}


def test_a_map_needs_no_critical_speeds(tmp_path):
    result = run("sensitivity", "HC_Optimal10", "--map", "c=0:0.1:3", "--map", "lam=0.2:0.5:3", "--out", tmp_path)
    assert result.exit_code == 0 and "nor a double root: only the map is written" in result.output
    assert names_in(tmp_path) == {f"map_HC_Optimal10.{kind}" for kind in ("png", "svg", "csv")}


def test_deviations_of_a_file_are_used(tmp_path):
    def of(found):
        return found.quantiles("weave speed")

    lines = [f"{key} = {value!r}" for key, value in BENCHMARK.values().items() if key not in ("tR", "tF")]
    text = "\n".join(lines).replace("c = 0.08", "c = 0.08 +/- 0.001")
    (tmp_path / "mine.txt").write_text(text)
    result = run("sensitivity", tmp_path / "mine.txt", "--samples", 40, "--out", tmp_path)
    assert result.exit_code == 0 and "40 samples of mine" in result.output, result.output
    mine = named(tmp_path / "mine.txt")
    found = sensitivity.monte_carlo(mine, n=40)
    assert np.array_equal(of(found), of(sensitivity.monte_carlo(BENCHMARK, {"c": 0.001}, n=40)))
    assert f"weave speed          {of(found)[0]:9.4f}" in result.output
    assert run("compare", "--list").output.splitlines()[0] == "Meijaard2007"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["sensitivity", "--deviation", "c=wide"], "--deviation c: 'wide' is not a number"),
        (["sensitivity", "--deviation", "cc=1"], "deviation of 'cc'"),
        (["sensitivity", "--map", "c=0:0.1:3"], "--map is given 1 times"),
        (["sensitivity", "--map", "c=0:0.1:3", "--map", "lam=0:1"], "write SYMBOL=FROM:TO:COUNT"),
        (["sensitivity", "--map", "c=0:0.1:3", "--map", "tR=0:0.1:3"], "give build=bicycle.whipple (--model)"),
        (["sensitivity", "--map", "c=0:0.1:3", "--map", "c=0:1:3"], "--map c is given twice"),
        (["sensitivity", "--deviation", "c=1", "--deviation", "c=2"], "--deviation c is given twice"),
        (["sensitivity", "HC_Optimal10"], "has neither weave nor capsize speed"),
        (["frequency", "--from", "3", "--to", "1"], "0 < from < to"),
        (["why", "Brower"], "did you mean Browser"),
        (["compare", "Browser"], "--unphysical"),
        (["compare", "Tms", "Tms"], "two bicycles are called 'Tms'"),
    ],
)
def test_bad_input_ends_with_one_line_and_exit_code_2(arguments, message, tmp_path):
    result = run(*arguments, "--out", tmp_path)
    assert result.exit_code == 2 and message in result.output
    assert result.output.count("\n") == 1 and result.output.startswith("mbsd3d: ")


# --- results in a console and in a notebook ---------------------------------------------------------------------------

MINE = replace(named("Rigid"), name="<mine>")


def family(turns):
    return Family(tuple(turns), ("a wheel is unloaded", "straight ahead"), (("largest lean", turns[-1]),))


RESULTS = {
    "stability": lambda: stability.study(MINE),
    "on tyres": lambda: stability.study(MINE, [4.0, 5.0, 6.0], tyres=TYPICAL),
    "critical speeds": lambda: stability.critical_speeds(MINE),
    "equations": lambda: canonical(MINE),
    "response": lambda: frequency.response(MINE, np.linspace(1.0, 9.0, 33), [0.1, 1.0], None),
    "derivatives": lambda: sensitivity.derivatives(MINE),
    "samples": lambda: sensitivity.monte_carlo(MINE, n=100),
    "indices": lambda: sensitivity.sobol(MINE, n=64),
    "map": lambda: sensitivity.stable_map(MINE, AXES),
    "stable speeds": lambda: sensitivity.stable_speeds(MINE, "c", np.linspace(0.0, 0.1, 1001)),
    "why": lambda: why.ablations(MINE, None),
    "variant": lambda: why.ablations(MINE, None).rows[0],
    "handling": lambda: handling.study(MINE, [4.0, 6.0]),
    "ride": lambda: ride.run(MINE, 0.1, speed=5.0),
    "turn": lambda: circles.turn(MINE, lean=0.3, steer=0.2),
    "turn on tyres": lambda: turns_on_tyres.turn(MINE, TYPICAL, speed=5.0, lean=0.2),
    "family": lambda: family([circles.turn(MINE, lean, 0.2) for lean in (0.3, 0.4)]),
    "entry": lambda: compare.entry(MINE),
}


@pytest.mark.parametrize("study", RESULTS)
def test_a_result_fits_a_console_and_a_notebook(study):
    found = RESULTS[study]()
    lines = repr(found).splitlines()
    assert 1 <= len(lines) <= 12 and max(map(len, lines)) <= 200  # a console of half a screen
    whole = str(found).splitlines()
    assert lines == whole or (lines[:11] == whole[:11] and f"{len(whole) - 11} more lines" in lines[11])
    page = found._repr_html_()
    assert "max-height" in page and "<mine>" not in page and len(page) < 8000


def test_every_dataclass_of_the_studies_prints_as_a_result():
    inputs = {"Parameters", "Course", "Manoeuvre", "Bicycle", "PublishedBody", "Curve", "Search"}
    modules = [import_module(x.name) for x in walk_packages(bicycle.__path__, "bicycle.") if ".commands" not in x.name]
    kinds = {x for module in modules for x in vars(module).values() if isinstance(x, type) and is_dataclass(x)}
    own = {x for x in kinds if x.__module__.startswith("bicycle.") and x.__name__ not in inputs}
    assert len(own) >= 18
    assert {x.__name__ for x in own if not hasattr(x, "_repr_html_") or "__repr__" in vars(x)} == set()
