"""Sweeps against closed forms; the same bits from every executor; input that makes no sense; figures."""

import json
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
import xarray
from helpers.sweep_models import GRID, LOCAL, RUN, deadly, history, known, ratio, shafts, speed, speed_of, touchy, wheel
from scipy.stats import norm, sobol_indices, spearmanr, triang, uniform

from mbsd3d import Kinematic, Samples, SweepError, samples, simulate, sweep
from validation.cases.inline_four import CRANK_RATE, inline_four, orders

ROOT = Path(__file__).parents[2]
ENGINE = json.loads((ROOT / "engines" / "references" / "engine.json").read_text())


def test_every_cell_has_the_closed_form():
    """Ratio of a Cardan joint 1 / cos^2, least and greatest input angle among the samples; dimensions as given."""
    bends = np.radians([7.0, 31.0, 52.0])
    table = sweep(
        shafts, {"turns": [0.5, 1.5], "bend": bends}, ratio, run={"output": 97, "rtol": 1e-6},
        units={"bend": "rad", "torque": "N m"}, tag="first",
    )  # fmt: skip
    assert table["ratio"].dims == ("turns", "bend") and table["ratio"].shape == (2, 3)
    # 96 samples per half turn and per turn and a half: both extremes, 0 and 90 degrees, are hit; projection holds them
    np.testing.assert_allclose(table["ratio"].values, [1 / np.cos(bends) ** 2] * 2, rtol=1e-12)
    assert table["bend"].attrs["units"] == "rad" and table["torque"].attrs["units"] == "N m"
    assert (
        table.attrs["runs"] == "DOP853(dt=None, max_step=inf, stiff='stop'), rtol 1e-06"
        and table.attrs["tag"] == "first"
    )
    assert table.attrs["failed"] == 0 and table.attrs["cells"] == 6 and (table["error"] == "").all()


@pytest.mark.slow
def test_numbers_are_those_of_single_runs_whatever_the_executor():
    single = [speed(simulate(wheel(a, b), **RUN)) for a in GRID["torque"] for b in GRID["inertia"]]
    with ThreadPoolExecutor(3) as pool:
        tables = [sweep(wheel, GRID, speed, run=RUN, executor=kind) for kind in (None, "processes", pool)]
    for table in tables:
        assert table["speed"].values.ravel().tolist() == single
    np.testing.assert_allclose(tables[0]["speed"], known(GRID), rtol=LOCAL)


def test_arrays_have_a_dimension_of_their_own_and_the_table_is_written(tmp_path):
    table = sweep(wheel, GRID, history, run=RUN)
    assert table["angle"].dims == ("torque", "inertia", "angle_index")
    t = np.linspace(0.0, RUN["t_end"], RUN["output"])
    expected = speed_of(2.4, 0.7, t) * t / 2
    np.testing.assert_allclose(table["angle"].sel(torque=2.4, inertia=0.7), expected, rtol=LOCAL, atol=1e-12)
    table.to_netcdf(tmp_path / "table.nc", engine="h5netcdf")
    with xarray.open_dataset(tmp_path / "table.nc", engine="h5netcdf") as copy:
        xarray.testing.assert_identical(copy.load(), table)


def test_settings_may_depend_on_the_cell():
    table = sweep(wheel, GRID, speed, run=lambda torque, inertia: RUN | {"t_end": torque * inertia})
    t = np.multiply.outer(GRID["torque"], GRID["inertia"])
    np.testing.assert_allclose(table["speed"], known(GRID) * t / RUN["t_end"], rtol=LOCAL)


@pytest.mark.parametrize("method", ["sobol", "latin hypercube", "random"])
def test_samples_are_seeded_and_spread(method):
    ranges = {"torque": (1.0, 3.0), "inertia": (0.2, 0.7)}
    found, same, other = (samples(ranges, 16, method=method, seed=seed) for seed in (5, 5, 6))
    assert np.array_equal(found.points, same.points) and not np.array_equal(found.points, other.points)
    assert (found.points > (1.0, 0.2)).all() and (found.points < (3.0, 0.7)).all()
    if method != "random":  # one point in each sixteenth of each range
        strata = np.floor((found.points - (1.0, 0.2)) / (2.0, 0.5) * 16)
        assert (np.sort(strata, axis=0) == np.arange(16)[:, None]).all()
    table = sweep(wheel, found, speed, run=RUN, units={"inertia": "kg m^2"})
    assert table["speed"].dims == ("sample",) and table["inertia"].attrs["units"] == "kg m^2"
    np.testing.assert_allclose(table["speed"], speed_of(table["torque"], table["inertia"]), rtol=LOCAL)


def test_samples_of_distributions_have_their_percentiles():
    """Of scrambled Sobol points one lies in each of n strata: a probability errs by 1/n."""
    of = {"torque": norm(3.0, 0.2), "inertia": triang(0.3, 1.0, 2.0), "load": (1.0, 5.0), "gain": uniform(1.0, 4.0)}
    n = 1024
    found = samples(of, n, seed=3).points
    for column, one in zip(found.T, (*list(of.values())[:2], uniform(1.0, 4.0), of["gain"]), strict=True):
        assert np.abs(one.cdf(np.sort(column)) - (np.arange(n) + 0.5) / n).max() < 1.0 / n


def test_samples_with_correlation():
    """That of normal variables is their own; of any others the rank correlation is 6/pi asin(rho/2)."""
    given = {("torque", "inertia"): 0.6, ("load", "torque"): -0.4}
    of = {"torque": norm(3.0, 0.2), "inertia": norm(1.0, 0.1), "load": (1.0, 5.0)}
    found = samples(of, 4096, seed=3, correlation=given).points
    expected = {(0, 1): 0.6, (0, 2): 6.0 / np.pi * np.arcsin(-0.2), (1, 2): 0.0}
    assert np.corrcoef(found[:, :2].T)[0, 1] == pytest.approx(0.6, abs=0.01)  # even points err by less than 1 / sqrt(n)
    for (i, j), rho in expected.items():
        exact = 6.0 / np.pi * np.arcsin(0.3) if (i, j) == (0, 1) else rho
        assert spearmanr(found[:, i], found[:, j]).statistic == pytest.approx(exact, abs=0.01)
    np.testing.assert_allclose(found[:, 1].mean(), 1.0, rtol=0.0, atol=1e-3)


@pytest.mark.slow
def test_sensitivities_by_sobol_indices():
    """speed = f(torque) g(inertia): first-order indices V_f E_g^2 / V and E_f^2 V_g / V, by Gauss-Legendre."""

    def moments(function, low, high):
        x, w = np.polynomial.legendre.leggauss(40)
        values = function(low + (x + 1) * (high - low) / 2)
        return w @ values / 2, w @ values**2 / 2 - (w @ values / 2) ** 2

    (e_f, v_f), (e_g, v_g) = moments(lambda x: x, 1.0, 1.8), moments(lambda x: 1 / (x + 0.1), 0.2, 0.7)
    whole = v_f * v_g + v_f * e_g**2 + e_f**2 * v_g
    func = lambda x: sweep(wheel, Samples(("torque", "inertia"), x.T), speed, run=RUN)["speed"].values  # noqa: E731
    found = sobol_indices(func=func, n=128, dists=[uniform(1.0, 0.8), uniform(0.2, 0.5)], rng=3)
    expected = [v_f * e_g**2 / whole, e_f**2 * v_g / whole]  # 0.24, 0.74
    np.testing.assert_allclose(found.first_order, expected, rtol=0, atol=0.06)  # 128 Sobol points: errors up to 0.03


def test_a_failing_cell_says_why_and_the_others_go_on():
    table = sweep(touchy, GRID, speed, run=RUN)
    failed = np.array(GRID["torque"])[:, None] > [2.5] * 3
    assert (table["error"].values[failed] == "RuntimeError: no motor gives 3.1 N m").all()
    assert (table["error"].values[~failed] == "").all() and table.attrs["failed"] == 3
    assert np.isnan(table["speed"].values[failed]).all()
    np.testing.assert_allclose(table["speed"].values[~failed], known(GRID)[~failed], rtol=LOCAL)


ONCE = {"torque": [1.0], "inertia": [0.2]}
BAD = {
    "empty grid": (lambda: sweep(wheel, {}, speed, run=RUN), "grid is empty; give at least one parameter"),
    "no mapping": (lambda: sweep(wheel, [1.0], speed, run=RUN), "give a mapping"),
    "no values": (lambda: sweep(wheel, {"torque": []}, speed, run=RUN), "'torque' has no values"),
    "NaN": (lambda: sweep(wheel, {"torque": [1.0, np.nan]}, speed, run=RUN), "'torque': value 1 is nan"),
    "twice": (lambda: sweep(wheel, {"torque": [1.0, 1.0]}, speed, run=RUN), "'torque': a value appears twice"),
    "texts among numbers": (lambda: sweep(wheel, {"torque": [1, "a"]}, speed, run=RUN), "'torque': 1 would become '1'"),
    "two dimensions": (lambda: sweep(wheel, {"torque": [[1.0]]}, speed, run=RUN), "'torque'.*list of numbers"),
    "unknown parameter": (
        lambda: sweep(wheel, {"torqe": [1.0]}, speed, run=RUN), "build does not take .*'torqe'.*takes torque, inertia"
    ),
    "missing parameter": (lambda: sweep(touchy, {"torque": [1.0]}, speed, run=RUN), "build does not take .*'inertia'"),
    "unknown argument of simulate": (
        lambda: sweep(wheel, ONCE, speed, run={"t_ned": 1.0}), "no argument 't_ned'; it has t_end"
    ),
    "run of another kind": (lambda: sweep(wheel, ONCE, speed, run=1.0), "run 1.0; give a mapping"),
    "measure": (lambda: sweep(wheel, ONCE, "speed", run=RUN), "measure 'speed' is not a function"),
    "build": (lambda: sweep("wheel", ONCE, speed, run=RUN), "build 'wheel' is not a function"),
    "units": (lambda: sweep(wheel, ONCE, speed, run=RUN, units="rad"), "units 'rad'; give a mapping"),
    "executor": (lambda: sweep(wheel, ONCE, speed, run=RUN, executor="cluster"), "executor 'cluster'; give None"),
    "a function without a place": (
        lambda: sweep(lambda torque, inertia: wheel(), ONCE, speed, run=RUN, executor="processes"),
        "cannot go to another process; define it at the top of a module",
    ),
    "empty range": (lambda: samples({"torque": (2.0, 1.0)}, 4), "range of 'torque' is empty"),
    "NaN range": (lambda: samples({"torque": (np.nan, 1.0)}, 4), "least 'torque'.*not finite"),
    "no power of two": (lambda: samples({"torque": (0.0, 1.0)}, 12), "12 is not a power of two"),
    "unknown method": (lambda: samples({"torque": (0.0, 1.0)}, 4, method="halton"), "method 'halton' is unknown"),
    "no distribution": (lambda: samples({"torque": 3.0}, 4), "range 3.0 of 'torque'; give .* or a distribution"),
    "correlation of no one": (
        lambda: samples({"torque": (0.0, 1.0)}, 4, correlation={("torque", "load"): 0.5}),
        r"correlation of \('torque', 'load'\); give two of torque",
    ),
    "correlations of no variables": (
        lambda: samples({"torque": (0.0, 1.0), "load": (0.0, 1.0)}, 4, correlation={("torque", "load"): 1.5}),
        "is that of no variables; give smaller numbers",
    ),
    "NaN point": (lambda: Samples(("torque",), [[1.0], [np.nan]]), "'torque' of point 1 is not finite"),
    "taken name": (lambda: sweep(wheel, {"error": [1.0]}, speed, run=RUN), "'error' is taken"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_input_is_named_before_anything_runs(monkeypatch, name):
    call, words = BAD[name]
    monkeypatch.setattr("mbsd3d.sweeps.sweep.outcomes", lambda *cells: pytest.fail("something runs"))
    with pytest.raises(ValueError, match=words):
        call()


WRONG = {
    "text": (wheel, lambda solution: "fast", RUN, "measure returned 'value' = 'fast'; return a number"),
    "matrix": (wheel, lambda s: {"q": s.position("wheel")}, RUN, r"'q' = an array of shape \(33, 3\)"),
    "complex": (wheel, lambda solution: {"z": 1j}, RUN, "'z' = 1j; return a number"),
    "name of a parameter": (wheel, lambda solution: {"torque": 1.0}, RUN, "a value named 'torque', as a parameter"),
    "name of an index": (wheel, lambda solution: {"a": [1.0], "a_index": 5.0}, RUN, "named 'a_index', as a parameter"),
    "no name": (wheel, lambda solution: {3: 1.0}, RUN, "a value named 3"),
    "no system": (lambda torque, inertia: None, speed, RUN, "build returned NoneType; return a System"),
    "no settings": (wheel, speed, lambda torque, inertia: None, "run returned NoneType; return a dict of arguments"),
    "no end": (wheel, speed, {"rtol": 1e-6}, r"no t_end; give run=dict\(t_end=\.\.\.\)"),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_functions_that_return_something_else_stop_the_sweep(name):
    build, measure, run, words = WRONG[name]
    with pytest.raises(SweepError, match=rf"cell \d+ \(torque=.*{words}") as caught:
        sweep(build, GRID, measure, run=run)
    assert caught.value.dataset["error"].shape == (4, 3)


def test_units_of_what_there_is_not_stop_the_sweep():
    with pytest.raises(SweepError, match="units of 'sped': give one of torque, inertia, speed"):
        sweep(wheel, GRID, speed, run=RUN, units={"torque": "N m", "sped": "rad/s"})


def test_cells_that_measure_different_things_stop_the_sweep():
    with pytest.raises(SweepError, match="return the same names and lengths everywhere") as caught:
        sweep(wheel, GRID, lambda s: s.rate("hinge")[: 5 if s.rate("hinge")[-1] < 1.0 else 6], run=RUN)
    assert np.isfinite(caught.value.dataset["value"].values).any()


def test_the_bar_shows_the_time_that_remains(monkeypatch, capsys):
    monkeypatch.setattr("mbsd3d.base.progress.BAR_DELAY_SECONDS", 0.0)
    monkeypatch.setenv("FORCE_COLOR", "1")  # rich draws a bar that changes only on a terminal
    sweep(wheel, GRID, speed, run=RUN, progress=True)
    said = capsys.readouterr().err
    assert "sweep of 12 cells" in said and "0:00:0" in said


@pytest.mark.parametrize("length", ENGINE["sweep_RL_I4_2x"])
def test_the_inline_four_shakes_as_published(length):
    """Second order of the force on the block by the length of the rods; the first order cancels."""
    turn = simulate(inline_four(rod_length=float(length[2:])), 2 * np.pi / CRANK_RATE, method=Kinematic(), output=37)
    found = orders(turn)
    assert found["force_2x"] == pytest.approx(ENGINE["sweep_RL_I4_2x"][length], rel=1e-11)  # digits of the file: 16
    assert found["force_1x"] < 1e-12  # N, rounding of forces of 50 N
    if length == "L=2.0":
        assert found["torque_2x"] == pytest.approx(17.43, abs=0.005)  # N m, as the file prints it


@pytest.mark.slow
def test_a_cluster_of_two_workers():
    """The same bits from a cluster, given as a client or as its executor; the cell that kills its worker is named."""
    from distributed import Client, LocalCluster

    expected = sweep(wheel, GRID, speed, run=RUN)
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        cluster.adapt(minimum=2, maximum=2)  # a worker killed while it starts on a busy machine is replaced
        for executor in (client, client.get_executor()):
            assert expected["speed"].equals(sweep(wheel, GRID, speed, run=RUN, executor=executor)["speed"])
        table = sweep(deadly, GRID, speed, run=RUN, executor=client)
    killed = ((table["torque"] == 2.0) & (table["inertia"] == 0.4)).values
    assert "KilledWorker" in str(table["error"].values[killed][0])
    assert table["speed"].values[~killed].tolist() == expected["speed"].values[~killed].tolist()
