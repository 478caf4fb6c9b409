"""Stability of bicycles: published eigenvalues and critical speeds, modes followed over the speed, figure, command."""

import csv
import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from helpers.page_limits import limits
from numpy.polynomial import Polynomial

from bicycle import Meijaard2007, critical, equations, general, named, parameters, stability, whipple
from bicycle.linear.critical import double_roots
from bicycle.linear.equations import canonical, follow
from bicycle.model.mechanism import Bicycle, outputs
from bicycle.parameters import library
from mbsd3d import TorsionSpring
from mbsd3d.extend import main

BENCHMARK = Meijaard2007()
TABLE = library()["eigenvalue_table"]["rows"]
CRITICAL = library()["critical_speeds"]


def expected(row):
    return np.sort_complex([complex(float(re), float(im)) for re, im in row["computed"]])


# --- published numbers ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("row", TABLE, ids=lambda row: f"{row['v']} m per s")
def test_published_eigenvalues(row):
    """Meijaard et al. (2007), table 2, recomputed to 20 digits."""
    values, (closed, modelled) = expected(row), limits("validation.md", "benchmark bicycle, eigenvalues")
    assert canonical(BENCHMARK).eigenvalues(row["v"])[0] == pytest.approx(values, abs=closed)
    assert general.eigenvalues(whipple, BENCHMARK, [row["v"]])[0] == pytest.approx(values, abs=modelled)


def test_general_model_at_all_speeds_from_two():
    speeds = np.array([row["v"] for row in TABLE], float)
    found = stability.eigenvalues(whipple, BENCHMARK, speeds)
    assert found == pytest.approx(np.array([expected(row) for row in TABLE]), abs=1e-11)
    with pytest.raises(ValueError, match="finite speeds in m/s"):
        stability.eigenvalues(whipple, BENCHMARK, [1.0, np.inf])
    with pytest.raises(ValueError, match="finite speeds in m/s"):
        canonical(BENCHMARK).eigenvalues([np.nan])


@pytest.mark.parametrize("build", [None, whipple], ids=["closed form", "general model"])
def test_critical_speeds(build):
    found = stability.critical_speeds(BENCHMARK, build)
    (limit,) = limits("validation.md", "weave, capsize, double root")
    assert found.weave == pytest.approx(float(CRITICAL["weave"]["computed"]), abs=limit)
    assert found.weave_rate == pytest.approx(float(CRITICAL["weave"]["omega_computed"]), abs=1e-10)
    assert found.capsize == pytest.approx(float(CRITICAL["capsize"]["computed"]), abs=limit)
    (meeting,) = found.double_roots
    assert meeting.speed == pytest.approx(float(CRITICAL["double_real_root"]["computed_v"]), abs=limit)
    assert meeting.eigenvalue == pytest.approx(float(CRITICAL["double_real_root"]["printed_eig"]), abs=1e-10)
    assert found.stable == [(found.weave, found.capsize)]
    assert "stable    4.292383 ... 6.024262 m/s" in str(found)


def test_a_front_end_without_mass_has_the_equations_of_the_general_model():
    light = dict.fromkeys(("mH", "IHxx", "IHyy", "IHzz", "IHxz", "mF", "IFxx", "IFyy"), 0.0)
    p, speeds = replace(Meijaard2007(), **light), [0.0, 3.0, 7.0, 16.0]
    found = general.eigenvalues(whipple, p, speeds)
    assert found == pytest.approx(canonical(p).eigenvalues(speeds), abs=1e-8 * np.abs(found).max())


def test_critical_speeds_do_not_depend_on_the_speeds_shown():
    for speeds in ([0.0, 1e-4], [-0.01, 0.02], [0.0, 300.0]):
        found = stability.study(BENCHMARK, speeds).critical
        assert found.weave == pytest.approx(float(CRITICAL["weave"]["computed"]), abs=1e-10)
        assert found.capsize == pytest.approx(float(CRITICAL["capsize"]["computed"]), abs=1e-10)


# --- the general model ------------------------------------------------------------------------------------------------

ROUND = replace(BENCHMARK, tR=0.05, tF=0.03, rF=0.42, name="round tyres")
ROUNDED = 3e-12
"""Of the largest entry of A: unit roundoff times the condition of M (up to 1200), in both of two ways to it."""


@pytest.mark.parametrize("p", [ROUND, named("Tms"), named("Yellowrev", unphysical=True)], ids=lambda p: p.name)
def test_known_deviations_give_what_linearize_gives(p):
    rest, running = general.output_matrices(whipple(p, 7.0), p, 7.0)
    for A, speed in ((rest, 0.0), (running, 7.0)):
        whole = general.linearization(whipple, p, speed).A
        assert A == pytest.approx(whole, abs=ROUNDED * np.abs(whole).max())
    between = general.linearization(whipple, p, 2.9).A  # neither of the two: the equations are polynomials in v
    found = general.linear_equations(whipple, p, 7.0).A(2.9)
    assert found == pytest.approx(between, abs=ROUNDED * np.abs(between).max())


def test_deviations_of_another_bicycle_are_noticed():
    """The rows of the model refuse deviations that do not belong to it."""
    for change in ({"c": 0.081}, {"rF": 0.351}, {"lam": 0.315}):
        assert general.output_matrices(whipple(BENCHMARK, 7.0), replace(BENCHMARK, **change), 7.0) is None


def damped(p, speed=0.0):
    """A bicycle with a damper at the steer axis, which depends on velocities, but not on the speed."""
    bare = whipple(p, speed)
    return replace(bare, forces=[TorsionSpring(bare.joints[1], stiffness=0.0, damping=2.5)])


def test_a_model_of_another_form_is_linearised_at_every_speed():
    assert general.linear_equations(damped, BENCHMARK, 6.0) is None
    assert general.linear_equations(damped, BENCHMARK, 6.0, check=False) is None
    speeds, linear = np.array([0.5, 2.0, 4.0, 6.0]), canonical(BENCHMARK)
    A = linear.A(speeds)
    A[:, 2:, 3] -= np.linalg.solve(linear.M, [0.0, 2.5])
    found = general.eigenvalues(damped, BENCHMARK, speeds)
    assert found == pytest.approx(np.sort_complex(np.linalg.eigvals(A)), abs=1e-11)
    with pytest.raises(ValueError, match="depends on speed otherwise"):
        stability.critical_speeds(BENCHMARK, damped)


def test_other_mechanisms_are_left_to_linearize():
    bare = whipple(BENCHMARK, 5.0)
    renamed = Bicycle(bare.bodies[::-1], bare.joints, gravity=bare.gravity)
    assert general.output_matrices(renamed, BENCHMARK, 5.0) is None


def test_speeds_and_cells_of_maps_are_cheap(monkeypatch):
    """Of 200 speeds one is linearised, as a check of the polynomials; of a cell of a map none."""
    built, linearised, linearization = [], [], general.linearization
    build = lambda parameters, speed: built.append(speed) or whipple(parameters, speed=speed)  # noqa: E731
    monkeypatch.setattr(general, "linearization", lambda *a: linearised.append(a[2]) or linearization(*a))
    general.eigenvalues(build, BENCHMARK, np.linspace(0.0, 10.0, 200))
    assert (built, linearised) == ([10.0, 6.0], [6.0])
    general.linear_equations(build, BENCHMARK, check=False)
    assert (built, linearised) == ([10.0, 6.0, 5.0], [6.0])


# --- modes over the speed ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name", ["Meijaard2007", "Yellow", "HC_Bluenose", "HC_Optimal06", "Tms", "benchmark-extendedoptc"]
)
def test_modes_are_continuous_and_each_is_used_once(name):
    linear = canonical(named(name, unphysical=True))
    speeds = np.linspace(0.0, 12.0, 241)
    values, vectors = follow(linear, speeds)
    assert np.sort_complex(values) == pytest.approx(linear.eigenvalues(speeds), abs=1e-9)
    for k in (0, 80, 240):
        A = linear.A(speeds[k])
        assert np.abs(A @ vectors[k] - vectors[k] * values[k]).max() < 1e-10 * np.abs(A).max()
    # near a double root modes move as the root of the distance: there a step of 0.05 m/s is not a measure
    q = critical.quartic(linear.M, linear.C1, linear.g * linear.K0, linear.K2)
    meet = np.array([x.speed for x in double_roots(q)])
    away = np.array([np.abs(meet - v).min(initial=9.0) > 0.15 for v in (speeds[1:] + speeds[:-1]) / 2])
    steps = np.abs(np.diff(values, axis=0)).max(axis=1)[away]
    # evenly they would move by 1/240 of the way; 0.15 m/s beside a double root, as a root, a few times faster. Modes
    # that are taken for each other would jump by their distance, tenths of the largest
    assert steps.max() < 0.02 * np.abs(values).max()


def test_modes_keep_their_names_where_growths_cross():
    values, _ = follow(canonical(BENCHMARK), np.linspace(0.0, 10.0, 201))
    growth = values.real
    assert np.any(growth[:, 0] > growth[:, 2]) and np.any(growth[:, 0] < growth[:, 2])  # weave and capsize cross
    assert np.all(values[20:, 0].imag > 0.0) and np.all(values[:, 2:].imag == 0.0)
    assert values[20:, 1] == pytest.approx(values[20:, 0].conj(), abs=1e-12)
    assert np.all(growth[:, 3] < growth[:, 2]) and equations.NAMES[3] == "castering"
    assert growth[0, :2] == pytest.approx([3.1316, 5.5309], abs=1e-4)  # split at rest, the slower first
    for row, k in zip(TABLE[1:], range(20, 201, 20), strict=True):
        assert growth[k, 2] == pytest.approx(float(row["printed"]["capsize"]), abs=1e-11)
        assert growth[k, 3] == pytest.approx(float(row["printed"]["castering"]), abs=1e-11)


def test_weave_speed_is_where_weave_ends_and_not_where_it_begins_again():
    """h = -(w - 2) (w - 6) / 10 with w = v^2: a pair of roots of p crosses the axis to the left."""
    q = critical.Quartic(*map(np.array, (1.0, 1.0, [4.0, -0.9], [1.0, 0.1], [4.2, -1.5])))
    speed = critical.weave(q)
    assert speed == pytest.approx(np.sqrt(2.0), rel=1e-12)
    growth = [np.roots(q.at(v)[::-1]).real.max() for v in (0.99 * speed, 1.01 * speed)]
    assert growth[0] > 1e-4 and growth[1] < -1e-4


def test_names_do_not_depend_on_the_grid():
    linear = canonical(named("Yellow", unphysical=True))
    fine, coarse = follow(linear, np.linspace(0.0, 10.0, 501))[0], follow(linear, np.linspace(0.0, 10.0, 11))[0]
    assert fine[::50] == pytest.approx(coarse, abs=1e-9)


def test_backward_modes_are_those_of_the_negated_spectrum():
    forth, back = (follow(canonical(BENCHMARK), sign * np.linspace(0.2, 8.0, 40))[0] for sign in (1.0, -1.0))
    assert -back[:, [2, 3]] == pytest.approx(forth[:, [2, 3]], abs=1e-10)


@pytest.mark.parametrize("name", parameters.names())
def test_double_roots_are_where_the_number_of_real_modes_changes(name):
    linear = canonical(named(name, unphysical=True))
    q = critical.quartic(linear.M, linear.C1, linear.g * linear.K0, linear.K2)
    found = [x.speed for x in double_roots(q)]
    grid = np.linspace(1e-4, 12.0, 1201)
    real = np.sum(np.abs(linear.eigenvalues(grid).imag) < 1e-9, axis=1)
    changes = [(low, high) for low, high, a, b in zip(grid, grid[1:], real, real[1:], strict=False) if a != b]
    assert len(changes) == sum(grid[0] < v < grid[-1] for v in found)
    for (low, high), v in zip(changes, found, strict=False):
        assert low < v < high
    for v, s in double_roots(q):
        nearest = np.sort(np.abs(linear.eigenvalues(v)[0] - s))[:2]
        assert nearest[1] < 1e-5 * abs(s)  # a double eigenvalue is known to the root of rounding, as a number s to all


def test_double_roots_far_from_each_other_are_all_found():
    """The powers of the discriminant are of very different size where c(w) vanishes at a low speed."""
    far = replace(
        BENCHMARK, w=0.49, c=0.146, lam=0.023, g=13.0, rR=0.29, mR=3.4, IRxx=0.11, IRyy=0.21, xB=0.64, zB=-1.25, mB=78,
        IBxx=15.7, IByy=9.9, IBzz=3.7, IBxz=-2.26, xH=1.21, zH=-1.16, mH=4.4, IHxz=-0.0185, rF=0.61, mF=2.6, IFxx=0.23,
        IFyy=0.21, unphysical=True, name="short",
    )  # fmt: skip
    linear = canonical(far)
    grid = np.linspace(0.01, 30.0, 3000)
    real = np.sum(np.abs(linear.eigenvalues(grid).imag) < 1e-9, axis=1)
    (changes,) = np.nonzero(np.diff(real))
    found = [x.speed for x in stability.critical_speeds(far).double_roots]
    assert len(found) == len(changes) == 2 and found[1] > 6.0 * found[0]
    assert all(grid[k] < v < grid[k + 1] for k, v in zip(changes, found, strict=True))


def two_pairs(a, b, c, e, gap=0.0):
    """Product of two quadratics a s^2 + b v s + c + e v^2 plus a constant: two pairs of modes that hardly meet."""
    return critical.Quartic(
        a=a[0] * a[1],
        b=a[0] * b[1] + a[1] * b[0],
        c=np.array([a[0] * c[1] + a[1] * c[0], a[0] * e[1] + a[1] * e[0] + b[0] * b[1]]),
        d=np.array([b[0] * c[1] + b[1] * c[0], b[0] * e[1] + b[1] * e[0]]),
        e=np.array([c[0] * c[1] + gap, c[0] * e[1] + c[1] * e[0]]),
    )


PAIRS = [
    ((1.0, 1.3), (0.7, 2.1), (-9.3, -8.1), (0.0, 0.6)),
    ((1.0, 1.3), (0.7, 2.1), (-3.3, 4.1), (0.0, -0.6)),
    ((1.7, 0.8), (0.9, 2.9), (-5.3, -6.1), (0.0, 1.1)),
]


def crossings(a, b, c, e):
    """(v, s) where a mode of one quadratic is one of the other, by their resultant, a polynomial in v^2."""
    w, stiff = Polynomial([0.0, 1.0]), [Polynomial([c[k], e[k]]) for k in (0, 1)]
    same, slope = a[0] * stiff[1] - a[1] * stiff[0], a[0] * b[1] - a[1] * b[0]
    roots = (same**2 - slope * (b[0] * stiff[1] - b[1] * stiff[0]) * w).roots()
    speeds = np.sqrt(np.sort([x.real for x in roots if abs(x.imag) < 1e-12 and x.real > 0.0]))
    return [(v, -same(v * v) / (slope * v)) for v in speeds]


@pytest.mark.parametrize("pairs", PAIRS)
def test_modes_that_cross_without_feeling_each_other_meet_there(pairs):
    """The discriminant has a double root there, which rounding splits, into a complex pair or into two speeds."""
    found = np.array([x.speed for x in double_roots(two_pairs(*pairs))])
    assert crossings(*pairs) and (np.diff(found) > 0.0).all()  # none is told twice
    for v, _ in crossings(*pairs):
        assert np.abs(found - v).min() < 1e-6 * v  # the root of rounding, as often as the terms cancel


@pytest.mark.parametrize("pairs", PAIRS)
def test_modes_that_hardly_feel_each_other_meet_twice(pairs):
    """f g + k = 0 near f = g = 0: they meet at v +- 2 sqrt(f_s g_s k) / |f_s g_v - f_v g_s|, to the order of k."""
    a, b, c, e = pairs
    for v, s in crossings(*pairs):
        f_s, g_s = (2.0 * a[k] * s + b[k] * v for k in (0, 1))
        f_v, g_v = (b[k] * s + 2.0 * e[k] * v for k in (0, 1))
        gap = 1e-8 * np.sign(f_s * g_s)
        apart = 2.0 * np.sqrt(f_s * g_s * gap) / abs(f_s * g_v - f_v * g_s)
        found = np.array([x.speed for x in double_roots(two_pairs(*pairs, gap)) if abs(x.speed - v) < 3.0 * apart])
        assert found - v == pytest.approx([-apart, apart], rel=1e-2)  # the next term is smaller by sqrt(k) = 1e-4


def test_mode_that_moves():
    found = stability.study(BENCHMARK, np.linspace(0.0, 8.0, 41))
    assert found.difference < 1e-11
    for name, speed, value in (
        ("weave", 4.0, 0.41325331521124 + 3.07910818603206j),
        ("castering", 5.0, -14.0783896927982),
    ):
        mode = found.mode(name, speed)
        assert mode.eigenvalue == pytest.approx(value, abs=1e-11)
        assert mode.motion(amplitude=0.05, samples=5).position("frame").shape == (5, 3)
    with pytest.raises(ValueError, match="give weave, capsize or castering"):
        found.mode("wobble", 4.0)


# --- figure, table, command -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_figure(dark):
    found = stability.study(BENCHMARK, np.linspace(-2.0, 8.0, 101))
    figure = found.figure(dark=dark)
    growth, frequency = figure.axes
    assert growth.get_ylabel() == "growth, Re(s) [1/s]" and frequency.get_xlabel() == "speed [m/s]"
    labels = [text.get_text() for text in growth.get_legend().get_texts()]
    assert set(labels) == {"self-stable", "weave", "capsize", "castering", "closed form (2007)"}
    texts = [text.get_text() for text in growth.texts]
    assert texts == ["weave 4.292 m/s", "capsize 6.024 m/s"]


@pytest.mark.parametrize("speeds", [[-4.0, -3.0], [5.0], [3.0, 0.5, 0.1, 0.3]])
def test_figure_of_any_speeds(speeds):
    found = stability.study(BENCHMARK, speeds)
    weave = found.figure().axes[0].lines
    drawn = [line for line in weave if np.array_equal(line.get_ydata(), found.values[:, 0].real)]
    assert len(drawn) == 1 and np.array_equal(drawn[0].get_xdata(), speeds) and drawn[0].get_label() == "weave"


def test_figure_without_a_closed_form():
    axes = stability.study(ROUND, [0.0, 1.0, 2.0, 3.0]).figure().axes[0]
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["weave", "capsize", "castering"]


def test_table(tmp_path):
    found = stability.study(BENCHMARK, np.linspace(0.0, 8.0, 17))
    with found.to_csv(tmp_path / "modes").open() as file:
        head, *rows = csv.reader(file)
    assert head[:3] == ["speed [m/s]", "Re weave [1/s]", "Im weave [1/s]"] and len(rows) == 17
    read = np.array(rows, float)
    assert np.array_equal(read[:, 0], found.speeds) and np.array_equal(read[:, 1::2] + 1j * read[:, 2::2], found.values)


def test_tables_keep_names_with_a_point(tmp_path):
    found = stability.study(BENCHMARK, [5.0])
    assert found.to_csv(tmp_path / "bike.v2").name == "bike.v2.csv"


def test_names_of_close_critical_speeds_stand_beside_each_other():
    found = stability.study(named("Browserins"), np.linspace(0.0, 10.0, 21))
    figure = found.figure()
    figure.draw_without_rendering()
    low, high = (text.get_window_extent() for text in figure.axes[0].texts)
    assert low.x1 < high.x0


def run(*arguments):
    return CliRunner().invoke(main, ["bicycle", "stability", *arguments])


def test_command(tmp_path):
    done = run("Browser", "--unphysical", "--count", "21", "--mode", "weave", "--out", str(tmp_path))
    assert done.exit_code == 0, done.output
    assert "stable    4.195376 ... 4.350112 m/s" in done.output and "closed form differ by" in done.output
    written = {path.name for path in tmp_path.iterdir()}
    assert written == {f"stability_Browser.{x}" for x in ("png", "svg", "csv")} | {"weave_Browser.html"}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["Browser"], "--unphysical"),
        (["Brows"], "did you mean"),
        (["nowhere.txt"], "nowhere.txt"),
        (["--from", "5", "--to", "5"], "--from 5 is not below --to 5"),
        (["--from", "-inf"], "give two finite speeds in m/s"),
        (["--mode", "weave", "--speed", "nan"], "--speed: not finite"),
        (["--tyre", "rolling_resistance=0.004"], "leave out rolling_resistance"),
        (["--mode", "wobble"], "give weave, capsize or castering"),
    ],
)
def test_faulty_commands_end_with_one_line(tmp_path, arguments, message):
    done = run(*arguments, "--out", str(tmp_path))
    assert done.exit_code == 2 and message in done.output
    assert len(done.output.strip().splitlines()) == 1


def test_help_is_quick_and_says_units():
    code = "import sys; from mbsd3d.cli import main\nmain(['bicycle', '--help'], standalone_mode=False)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "stability" in done.stdout and "weave, capsize" in done.stdout
    text = run("--help").output
    assert "[m/s]" in text and named(re.search(r"e\.g\. (\w+)", text)[1]).mB > 0.0  # a set that is not refused


def test_outputs_are_lean_steer_and_their_rates():
    assert [x.unit for x in outputs(whipple(BENCHMARK))] == ["rad", "rad", "rad/s", "rad/s"]
