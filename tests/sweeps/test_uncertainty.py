"""Percentiles and Sobol' indices against closed forms and scipy; ledgers of studies; what is refused."""

import os
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest
from helpers import study_models as models
from helpers.sweep_models import RUN, speed, touchy, wheel
from scipy.stats import norm, sobol_indices, triang, uniform

from mbsd3d import Body, Study, SweepError, System, explain, fit, samples, sweep, uncertainty
from mbsd3d.errors import InputError

NAMED = {
    "normal": (("normal", 3.0, 0.2), norm(3.0, 0.2)),
    "uniform": (("uniform", -1.0, 5.0), uniform(-1.0, 6.0)),
    "triangular": (("triangular", 1.0, 1.6, 3.0), triang(0.3, 1.0, 2.0)),
    "range": ((-1.0, 5.0), uniform(-1.0, 6.0)),
}


@pytest.mark.parametrize("name", NAMED)
def test_distributions_by_name_are_those_of_scipy(name):
    given, same = NAMED[name]
    found = samples({"x": given, "y": (0.0, 1.0)}, 256, seed=3).points
    # a ratio of numbers of one digit is rounded
    np.testing.assert_allclose(found, samples({"x": same, "y": (0.0, 1.0)}, 256, seed=3).points, rtol=1e-15, atol=1e-15)
    assert np.abs(same.cdf(np.sort(found[:, 0])) - (np.arange(256) + 0.5) / 256).max() < 1.0 / 256


WRONG = {
    "unknown": (("gaussian", 1.0, 2.0), "distribution of 'x' 'gaussian' is unknown; give 'normal' or 'uniform' or"),
    "too few": (
        ("normal", 1.0),
        r"range \('normal', 1.0\) of 'x'; give \(least, greatest\), \('normal', mean,",
    ),
    "no spread": (("normal", 1.0, 0.0), "standard deviation 0 of 'x'; give a number > 0"),
    "order": (
        ("triangular", 1.0, 3.0, 2.0),
        r"range of 'x' is empty, 1 ... 3 ... 2; give \(least, likeliest",
    ),
    "text": (("uniform", 1.0, "two"), "greatest 'x': expected a number, got 'two'"),
    "name alone": ("normal", "range 'normal' of 'x'; give"),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_distributions_are_refused(name):
    given, words = WRONG[name]
    with pytest.raises(InputError, match="samples: " + words):
        samples({"x": given}, 4)
    with pytest.raises(InputError, match="uncertainty: " + words):
        uncertainty(ishigami, {"x": given}, 4)


def ishigami(a, b, c):
    """Ishigami and Homma's function: a and c act together only."""
    return {"y": np.sin(a) + 7.0 * np.sin(b) ** 2 + 0.1 * c**4 * np.sin(a), "still": np.full(a.size, 1e9)}


ANGLES = {name: ("uniform", -np.pi, np.pi) for name in "abc"}


def test_indices_of_a_closed_form():
    """V = 1/2 + 49/8 + p pi^4/5 + p^2 pi^8/18 with p = 0.1: shares of a, of b, and of a with c."""
    alone, pair = 0.5 * (1.0 + 0.1 * np.pi**4 / 5.0) ** 2, 0.1**2 * np.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    whole = alone + 49.0 / 8.0 + pair
    n = 8192
    found = uncertainty(ishigami, ANGLES, n, seed=4).sobol
    np.testing.assert_allclose(found.first["y"], [alone / whole, 49 / 8 / whole, 0.0], rtol=0.0, atol=0.02)  # 2/sqrt(n)
    np.testing.assert_allclose(
        found.total["y"], [(alone + pair) / whole, 49 / 8 / whole, pair / whole], rtol=0.0, atol=0.02
    )
    assert (found.first["still"] == 0.0).all() and (found.total["still"] == 0.0).all()
    assert found.ranked("y") == [0, 1, 2] and found.names == ("a", "b", "c")


def test_indices_are_those_of_scipy_for_the_same_points():
    found = uncertainty(ishigami, ANGLES, 128, seed=6).sobol
    same = sobol_indices(func=lambda x: ishigami(*x)["y"], n=128, dists=[uniform(-np.pi, 2 * np.pi)] * 3, rng=6)
    np.testing.assert_allclose(found.first["y"], same.first_order, rtol=0.0, atol=1e-13)  # rounding of sums
    np.testing.assert_allclose(found.total["y"], same.total_order, rtol=0.0, atol=1e-13)


def test_intervals_hold_the_exact_indices_as_often_as_they_say():
    """Of 60 seeds and three parameters; points of a Sobol sequence are better than random ones, so more are held."""
    alone, pair = 0.5 * (1.0 + 0.1 * np.pi**4 / 5.0) ** 2, 0.1**2 * np.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    whole = alone + 49.0 / 8.0 + pair
    exact = np.array([[alone, 49.0 / 8.0, 0.0], [alone + pair, 49.0 / 8.0, pair]]) / whole
    held = []
    for seed in range(60):
        shares = uncertainty(ishigami, ANGLES, 512, seed=seed).sobol
        held += [
            (low <= x) & (x <= high) for (low, high), x in zip(shares.confidence_interval("y"), exact, strict=True)
        ]
        assert np.array_equal(shares.confidence_interval("y"), shares.confidence_interval("y"))
    assert 0.93 <= np.mean(held) <= 1.0  # 360 of 95 %: four standard deviations below would be 0.90


def growth(solution):
    """Speed and angles of the wheel."""
    return {"speed": solution.rate("hinge")[-1], "angle": solution.angle("hinge")[::8]}


TORQUE = ("triangular", 1.0, 1.6, 2.2)
INERTIA = ("normal", 0.4, 0.02)


def spread(executor=None, ledger=None, count=32):
    study = Study(wheel, {"torque": 1.7, "inertia": 0.3}, growth, RUN, units={"speed": "rad/s"}, ledger=ledger)
    return uncertainty(study, {"torque": TORQUE, "inertia": INERTIA}, count, seed=2, executor=executor)


def test_runs_of_a_study_spread_as_the_closed_form(tmp_path):
    """speed = torque t / (inertia + 0.1): its values at the points, its percentiles, and its shares."""
    found = spread()
    torque, inertia = found.samples.points.T
    expected = torque * RUN["t_end"] / (inertia + 0.1)
    np.testing.assert_allclose(found.values["speed"], expected, rtol=1e-6)  # rtol of the run
    assert found.values["angle"].shape == (64, 5) and found.sobol.total["angle"].shape == (2, 5)
    np.testing.assert_allclose(found.percentiles("speed", (5, 95)), np.percentile(expected, (5, 95)), rtol=1e-6)
    np.testing.assert_array_equal(found.percentiles("angle")[:, 0], np.zeros(3))
    # variance of the torque a^2/24 ... of a triangle over that of a product of independent factors
    v_t, v_i = triang(0.5, 1.0, 1.2).var() / 1.6**2, (0.02 / 0.5) ** 2
    np.testing.assert_allclose(found.sobol.total["speed"], [v_t / (v_t + v_i), v_i / (v_t + v_i)], rtol=0.0, atol=0.05)
    assert "64 points of 2 parameters" in str(found) and "torque" in str(found).splitlines()[4]
    rows = found.to_csv(tmp_path / "points").read_text().splitlines()
    assert len(rows) == 65 and rows[0].startswith("torque,inertia,speed,angle[0]")
    assert float(rows[1].split(",")[2]) == found.values["speed"][0]
    shares = found.sobol.to_csv(tmp_path / "shares").read_text().splitlines()
    assert len(shares) == 3 and shares[0].startswith("parameter,first of speed,first of speed from")
    assert len(found.figure().axes) == 4 and len(found.figure(dark=True).axes) == 4


def test_parameters_without_a_distribution_stay_at_x0():
    study = Study(wheel, {"torque": 1.7, "inertia": 0.3}, speed, RUN)
    found = uncertainty(study, {"inertia": (0.2, 0.5)}, 8)
    np.testing.assert_allclose(
        found.values["speed"], 1.7 * RUN["t_end"] / (found.samples.points[:, 0] + 0.1), rtol=1e-6
    )


def test_studies_without_a_run_are_measured():
    def frequency(system):
        return float(np.sqrt(system.forces[0].stiffness / system.bodies[0].mass))

    def box(k, m):
        return models.oscillator(m, k, 0.0, 0.1, 1.0)[0]

    found = uncertainty(Study(box, {"k": 50.0, "m": 2.0}, frequency), {"k": ("normal", 50.0, 1.0)}, 16)
    np.testing.assert_allclose(found.values["frequency"], np.sqrt(found.samples.points[:, 0] / 2.0), rtol=1e-15)


def test_correlated_parameters_have_percentiles_only():
    study = Study(wheel, {"torque": 1.7, "inertia": 0.3}, growth, RUN)
    found = uncertainty(study, {"torque": TORQUE, "inertia": INERTIA}, 64, correlation={("torque", "inertia"): 0.9})
    assert found.sobol is None and found.samples.points.shape == (64, 2) and len(found.figure().axes) == 2
    assert np.corrcoef(found.samples.points.T)[0, 1] > 0.8
    # inertia grows with torque: the speed spreads less than of independent parameters
    assert np.ptp(found.percentiles("speed", (5, 95))) < np.ptp(spread(count=64).percentiles("speed", (5, 95)))


@pytest.mark.slow
def test_the_same_numbers_from_processes():
    one, other = spread(), spread("processes")
    for name in one.values:
        assert np.array_equal(one.values[name], other.values[name])
        assert np.array_equal(one.sobol.total[name], other.sobol.total[name])


def test_runs_that_fail_are_told_and_leave_no_index():
    study = Study(touchy, {"torque": 2.0, "inertia": 0.3}, speed, RUN)
    found = uncertainty(study, {"torque": (2.2, 2.6)}, 16)
    failed = found.samples.points[:, 0] > 2.5
    assert np.array_equal(np.isnan(found.values["speed"]), failed) and 0 < failed.sum() < 16
    assert np.isnan(found.sobol.total["speed"]).all()
    assert "runs failed, the first: cell" in str(found) and "no motor gives" in str(found)
    with pytest.raises(SweepError, match="no run succeeded; the first: cell 0 .*no motor gives"):
        uncertainty(study, {"torque": (2.6, 2.8)}, 4)


BAD = {
    "count": (lambda: uncertainty(ishigami, ANGLES, 12), "count 12 is not a power of two"),
    "seed": (lambda: uncertainty(ishigami, ANGLES, 8, seed=-1), "seed = -1; give a whole number >= 0"),
    "study": (lambda: uncertainty(3, ANGLES, 8), "study 3; give a Study, or a function"),
    "distributions": (lambda: uncertainty(ishigami, [1.0], 8), "distributions .*; give a mapping"),
    "parameter": (
        lambda: uncertainty(Study(wheel, {"torque": 1.0}, speed, RUN), {"force": (0, 1)}, 8),
        "no parameter 'force'; it has torque",
    ),
    "function": (lambda: uncertainty(lambda a, b, c: a, ANGLES, 8), "the function returned .*; return arrays by name"),
    "shape": (
        lambda: uncertainty(lambda a, b, c: {"y": a[1:]}, ANGLES, 8), r"'y' has shape \(39,\); return 40 values",
    ),
    "correlation": (
        lambda: uncertainty(ishigami, ANGLES, 8, correlation=np.zeros(3)), "correlation array.*; give a mapping",
    ),
    "output": (lambda: uncertainty(ishigami, ANGLES, 8).percentiles("z"), "no output 'z'; there are y, still"),
    "percent": (lambda: uncertainty(ishigami, ANGLES, 8).percentiles("y", 110), "at 110; give percents, 0 ... 100"),
    "level": (lambda: uncertainty(ishigami, ANGLES, 8).sobol.confidence_interval("y", 95.0), "level 95; give a prob"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_input_is_refused(name):
    call, words = BAD[name]
    with pytest.raises(InputError, match=words):
        call()


# --- ledgers of studies -----------------------------------------------------------------------------------------------


class Counted:
    """Builds a stone, and counts how often; the call after ``until`` is interrupted."""

    def __init__(self, until=10**9):
        self.calls, self.until = 0, until

    def __call__(self, speed, mass):
        self.calls += 1
        if self.calls > self.until:
            raise KeyboardInterrupt
        motion = dict(position=(0.1, 0.2, 0.0), velocity=(speed, 0.3, 0.0), omega=(0.2, 0, 0))
        return System([Body("stone", mass, (0.1, 0.2, 0.15), com=(0.05, 0, 0.02), **motion)])


def place(solution):
    return {"x": solution.position("stone")[:, 0]}


def stone(build, ledger, run=None):
    return Study(build, {"speed": 1.0, "mass": 2.0}, place, run or {"t_end": 0.5, "output": 3}, ledger=ledger)


def test_a_study_finds_its_points_in_the_ledger(tmp_path):
    first, again = Counted(), Counted()
    one, other = stone(first, tmp_path / "s.db"), stone(again, tmp_path / "s.db")
    expected = one.gradient()
    value = one.fun([1.3, 2.0])
    other = stone(again, tmp_path / "s.db")
    found = other.gradient()
    assert (
        again.calls == 0 and np.array_equal(found.jac, expected.jac) and np.array_equal(found.values, expected.values)
    )
    assert np.array_equal(found.estimate, expected.estimate) and found.names == expected.names
    assert np.array_equal(other.fun([1.3, 2.0]), value) and again.calls == 0
    other.fun([1.4, 2.0])
    assert again.calls == 1
    finer = stone(again, tmp_path / "s.db", {"t_end": 0.5, "output": 3, "rtol": 1e-9})
    finer.fun([1.3, 2.0])  # another run, in the same file
    assert again.calls == 2


def test_an_interrupted_fit_goes_on(tmp_path):
    t = np.array([0.1, 0.4, 0.9])
    data = {"t": t, "x": 0.1 + 1.7 * t + 0.05 * t}

    def fitted(build, ledger=None):
        study = Study(lambda speed: build(speed, 2.0), {"speed": 1.0}, place, {"t_end": 1.0}, ledger=ledger)
        return fit(study, data)

    whole = Counted()
    expected = fitted(whole)
    with pytest.raises(KeyboardInterrupt):
        fitted(Counted(whole.calls // 2), tmp_path / "fit.db")
    rest = Counted()
    found = fitted(rest, tmp_path / "fit.db")
    assert found.x[0] == expected.x[0] and found.nfev == expected.nfev and 0 < rest.calls < whole.calls
    none = Counted()
    assert fitted(none, tmp_path / "fit.db").x[0] == expected.x[0] and none.calls == 0


def test_an_interrupted_uncertainty_goes_on(tmp_path):
    def spread_of(build, ledger=None):
        spread = {"speed": ("normal", 1.0, 0.1), "mass": (1.0, 3.0)}
        return uncertainty(stone(build, ledger), spread, 32, executor=in_place())

    expected = spread_of(Counted())
    first = spread_of(Counted(40), tmp_path / "u.db")
    assert first.stopped_by == "stopped after 40 of 128 runs" and np.isnan(first.sobol.total["x"]).all()
    assert "stopped after 40 of 128 runs" in str(first)
    rest = Counted()
    found = spread_of(rest, tmp_path / "u.db")
    assert rest.calls == 88 and np.array_equal(found.values["x"], expected.values["x"])
    assert np.array_equal(found.sobol.total["x"], expected.sobol.total["x"])


def in_place():
    """An executor that runs each task where it is submitted."""
    from concurrent.futures import Executor, Future

    class InPlace(Executor):
        def submit(self, fn, /, *args, **kwargs):
            future = Future()
            future.set_result(fn(*args, **kwargs))
            return future

    return InPlace()


def test_an_interrupted_explanation_goes_on(tmp_path):
    def why(build, ledger=None):
        return explain(
            build, place, run={"t_end": 0.5, "output": 3}, parameters={"speed": 1.0, "mass": 2.0}, executor=in_place(),
            ledger=ledger,
        )  # fmt: skip

    whole = Counted()
    expected = why(whole)
    first = why(Counted(3), tmp_path / "why.db")  # the model, as it is, and without a term; then Ctrl-C
    assert len(first.groups["no run"]) == len(expected.effects) - 1
    rest = Counted()
    found = why(rest, tmp_path / "why.db")
    assert [x for x in found.effects] == [x for x in expected.effects] and rest.calls < whole.calls
    with pytest.raises(InputError, match="belongs to another sweep, it differs in .*tag"):
        explain(
            Counted(), place, run={"t_end": 0.5, "output": 3}, parameters={"speed": 1.1, "mass": 2.0},
            ledger=tmp_path / "why.db",
        )  # fmt: skip


def test_the_ledger_of_another_study_is_refused(tmp_path):
    stone(Counted(), tmp_path / "s.db").fun()
    with pytest.raises(InputError, match="study: ledger .* belongs to another study, it differs in measure; give"):
        Study(Counted(), {"speed": 1.0, "mass": 2.0}, growth, {"t_end": 0.5}, ledger=tmp_path / "s.db")


# --- batches ----------------------------------------------------------------------------------------------------------

MANY = {"torque": np.linspace(1.0, 2.0, 40).tolist(), "inertia": np.linspace(0.2, 0.9, 5).tolist()}  # 200 cells


def test_cells_go_to_an_executor_in_batches():
    sizes = []

    class Noting(type(in_place())):
        def submit(self, fn, /, *args, **kwargs):
            sizes.append(len(args[-1]))
            return super().submit(fn, *args, **kwargs)

    table = sweep(wheel, MANY, speed, run=RUN, executor=Noting())
    assert sum(sizes) == 200 and sizes[0] == 1 and max(sizes) > 1
    assert table["speed"].equals(sweep(wheel, MANY, speed, run=RUN)["speed"])


def unsendable(torque, inertia):
    """What it raises cannot come back from another process."""
    if os.environ.get("MBSD3D_MARK") == "no" and (torque, inertia) == (MANY["torque"][20], MANY["inertia"][0]):
        os._exit(3)
    return wheel(torque, inertia)


@pytest.mark.slow
def test_a_batch_whose_process_dies_costs_one_cell(monkeypatch):
    monkeypatch.setenv("MBSD3D_MARK", "no")
    table = sweep(unsendable, MANY, speed, run=RUN, executor="processes")
    assert table.attrs["failed"] == 1 and "WorkerDied" in str(table["error"].values[20, 0])


@pytest.mark.slow
def test_batches_on_a_pool_of_the_user():
    with ProcessPoolExecutor(2) as pool:
        table = sweep(wheel, MANY, speed, run=RUN, executor=pool)
    assert table["speed"].equals(sweep(wheel, MANY, speed, run=RUN)["speed"])
