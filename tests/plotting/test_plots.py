"""Figures: units on every axis, the same bytes twice."""

import os
import re
import subprocess
import sys
from types import SimpleNamespace

import matplotlib.pyplot
import numpy as np
import pytest
from helpers.double_pendulum import LOWER_ARM, UPPER_ARM, WHEEL, pendulum
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from mbsd3d import GROUND, Body, Clutch, Revolute, SpeedDriver, System, accelerations, save_figure, simulate
from mbsd3d.extend import theme
from mbsd3d.plotting.default_curves import default_curves
from mbsd3d.plotting.panels import acts, panels_of
from mbsd3d.plotting.plots import plot_quantity

QUANTITIES = (
    "energy", "position", "orientation", "velocity", "omega", "omega_body", "acceleration", "alpha", "com", "angle",
    "rate", "reaction", "effort", "force", "power", "length", "momentum", "drift",
)  # fmt: skip


@pytest.fixture(scope="module")
def solution():
    """0.2 s of the pendulum."""
    return simulate(pendulum(), 0.2, output=21)


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_every_axis_has_a_unit_and_nothing_is_cut(solution, quantity):
    figure = plot_quantity(solution, quantity)
    assert isinstance(figure, Figure) and not matplotlib.pyplot.get_fignums()
    figure.draw_without_rendering()
    assert all(re.search(r"\[.+\]$", axes.get_ylabel()) for axes in figure.axes)
    assert figure.axes[-1].get_xlabel() == "time [s]"
    for axes in figure.axes:
        for text in (axes.yaxis.label, axes.xaxis.label):
            box = text.get_window_extent()
            assert box.x0 >= 0 and box.y0 >= 0 and box.y1 <= figure.bbox.height


def test_one_part_shows_components_and_several_are_compared(solution):
    one, two = solution.plot("position", WHEEL), solution.plot("position", UPPER_ARM, LOWER_ARM)
    assert [line.get_label() for line in one.axes[0].lines] == ["x", "y", "z"] and len(one.axes) == 1
    assert [axes.get_ylabel() for axes in two.axes] == [f"position {k} [m]" for k in "xyz"]
    assert np.array_equal(two.axes[2].lines[1].get_ydata(), solution.position(LOWER_ARM)[:, 2])
    force, moment = solution.plot("reaction", "elbow").axes
    assert force.get_ylabel() == "reaction force of elbow [N]" and len(moment.lines) == 3
    assert np.array_equal(moment.lines[1].get_ydata(), solution.reaction("elbow").moment[:, 1])
    assert solution.plot("angle", "axle").axes[0].get_ylabel() == "angle of axle [rad]"


def test_a_figure_of_the_user_is_drawn_into(solution):
    figure = Figure()
    axes = figure.subplots(1, 2)
    assert plot_quantity(solution, "momentum", axes=axes) is figure and len(axes[1].lines) == 3
    with pytest.raises(ValueError, match="momentum of these parts needs 2 axes, not 1"):
        plot_quantity(solution, "momentum", axes=axes[0])


def test_refusals_name_what_there_is(solution):
    with pytest.raises(ValueError, match="quantity 'speed' is unknown; give one of energy, position, .*drift"):
        solution.plot("speed")
    with pytest.raises(ValueError, match="'foot' is not one of the bodies of this system; there are 'upper arm'"):
        solution.plot("com", "foot")
    with pytest.raises(ValueError, match="no joint of this system has the quantity slide"):
        solution.plot("slide")
    with pytest.raises(ValueError, match="plot: degrees 'no' is unknown; give True or False"):
        solution.plot("angle", degrees="no")
    with pytest.raises(ValueError, match="energy belongs to the whole system"):
        solution.plot("energy", WHEEL)


def test_shares_of_redundant_joints_are_marked():
    door = Body("door", 20.0, (8.0, 9.0, 1.0), position=(0.45, 0.0, 1.0), omega=(0, 0, 1))
    hinges = [
        Revolute(GROUND, door, at=(0, 0, z), axis=(0, 0, 1), name=name) for z, name in ((0.2, "low"), (1.8, "up"))
    ]
    figure = simulate(System([door], hinges), 0.05).plot("reaction")
    assert figure.axes[0].get_legend().get_title().get_text() == "not unique: low, up"


def test_one_sample_is_a_marked_point():
    line = accelerations(pendulum()).plot("alpha", WHEEL).axes[0].lines[0]
    assert line.get_marker() == "o" and line.get_xdata().size == 1


def test_drift_is_logarithmic_and_rounding_is_not_blown_up(solution):
    assert all(axes.get_yscale() == "log" for axes in solution.plot("drift").axes)
    low, high = solution.plot("position", UPPER_ARM, WHEEL).axes[0].get_ylim()
    assert high - low > 0.01  # both stand still


def test_several_quantities_share_the_time_axis(solution):
    figure = solution.plot(["energy", ("angle", "axle"), ("position", UPPER_ARM, WHEEL)])
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert labels == ["energy [J]", "angle of axle [rad]", *(f"position {k} [m]" for k in "xyz")]
    assert np.array_equal(figure.axes[1].lines[0].get_ydata(), solution.angle("axle"))
    assert [bool(axes.get_legend()) for axes in figure.axes] == [True, False, True, False, False]


def test_a_quantity_over_another_one(solution):
    axes = solution.plot("rate", "axle", against="angle").axes[0]
    assert axes.get_xlabel() == "angle of axle [rad]" and axes.lines[0].get_markevery() is None  # 21 samples: all
    assert np.array_equal(axes.lines[0].get_xdata(), solution.angle("axle"))
    assert np.array_equal(axes.lines[0].get_ydata(), solution.rate("axle"))
    axes = solution.plot("energy", against=("angle", "axle"), degrees=True).axes[0]
    assert axes.get_xlabel() == "angle of axle [°]" and len(axes.lines) == 4
    assert np.allclose(axes.lines[2].get_xdata(), np.degrees(solution.angle("axle")), rtol=1e-15, atol=0)
    both = solution.plot("velocity", UPPER_ARM, against=("velocity", UPPER_ARM)).axes[0]
    assert all(np.array_equal(*line.get_data()) for line in both.lines)


def test_the_start_of_a_path_is_marked():
    run = simulate(pendulum(), 0.1, output=60)
    line = run.plot("rate", "axle", against="angle").axes[0].lines[0]
    assert (line.get_marker(), line.get_markevery()) == ("o", [0])
    assert run.plot("rate", "axle").axes[0].lines[0].get_marker() == "None"


def test_angles_in_degrees(solution):
    for quantity, part, unit in (("angle", "axle", "°"), ("omega", WHEEL, "°/s"), ("alpha", WHEEL, "°/s²")):
        axes = solution.plot(quantity, part, degrees=True).axes[0]
        assert axes.get_ylabel().replace("\n", " ").endswith(f"[{unit}]")
        values = np.degrees(getattr(solution, quantity)(part).reshape(solution.t.size, -1))
        assert np.allclose(np.transpose([line.get_ydata() for line in axes.lines]), values, rtol=1e-15, atol=0)
    assert solution.plot("drift", degrees=True).axes[0].get_ylabel() == "position drift [m or rad]"  # rows of both


def test_dark_paper(solution):
    figure = solution.plot("reaction", dark=True)
    figure.draw_without_rendering()
    assert (
        to_hex(figure.get_facecolor()) == theme(True).paper
        and figure.axes[0].lines[1].get_color() == theme(True).lines[1]
    )
    texts = [x for axes in figure.axes for x in (axes.yaxis.label, *axes.get_yticklabels(), *axes.get_xticklabels())]
    texts += [figure.axes[-1].xaxis.label, *figure.axes[0].get_legend().get_texts()]
    assert {to_hex(text.get_color()) for text in texts} == {theme(True).ink}


def test_names_are_written_as_they_are():
    names = ("_hidden", "$x^2$", r"a $\frac$", "ä <b>")
    bodies = [Body(name, 1.0, (0.1, 0.2, 0.3), position=(k, 0, 0)) for k, name in enumerate(names)]
    figure = simulate(System(bodies), 0.1, output=3).plot("com")
    figure.draw_without_rendering()  # where a formula that is none would fail
    assert tuple(text.get_text() for text in figure.axes[0].get_legend().get_texts()) == names


def test_a_long_legend_names_the_strongest():
    """Of 100 bodies on a line, shuffled, the ten farthest ones, which alone have colours and whole widths."""
    places = np.random.default_rng(3).permutation(100) - 50.3  # of both signs, no two of one size
    bodies = [Body(f"b{k}", 1.0, (0.1, 0.2, 0.3), position=(x, 0, 0)) for k, x in enumerate(places)]
    axes = simulate(System(bodies), 0.1, output=3).plot("com").axes[0]
    texts = [text.get_text() for text in axes.get_legend().get_texts()]
    far = np.argsort(-np.abs(places))[:10]
    assert texts == [*(f"b{k}" for k in far), "and 90 smaller ones"] and len(axes.lines) == 100
    plain = {k for k, line in enumerate(axes.lines) if to_hex(line.get_color()) == theme(False).muted}
    assert plain == set(range(100)).difference(far)
    assert len({(axes.lines[k].get_color(), axes.lines[k].get_linestyle()) for k in far}) == 10


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda s: s.plot(["energy", "speed"]), "quantity 'speed' is unknown"),
        (lambda s: s.plot([]), "is not a quantity; give a name, or a list"),
        (lambda s: s.plot(3), "3 is not a quantity"),
        (lambda s: s.plot([("angle", "axle"), 3.0]), "is not a quantity; give a name"),
        (lambda s: s.plot(["energy"], WHEEL), "with several quantities each has its own parts"),
        (lambda s: s.plot("energy", against="position"), "against 'position' is not a single axis; give a scalar"),
        (lambda s: s.plot("energy", against="reaction"), "against 'reaction' is not a single axis"),
        (lambda s: s.plot("omega", WHEEL, against="energy"), "belongs to the whole system"),
        (lambda s: s.plot("omega", WHEEL, against=("energy",)), "has the lines kinetic, .*, none of 'x'; give one"),
        (lambda s: s.plot("energy", against=3), "3.* is not a quantity"),
    ],
)
def test_wrong_wishes(solution, call, message):
    with pytest.raises(ValueError, match=message):
        call(solution)


FRESH = """
import sys
from helpers.double_pendulum import pendulum
from mbsd3d import simulate
from mbsd3d import save_figure
save_figure(simulate(pendulum(), 0.1, output=9).plot(["energy", "drift", "reaction"], dark=True), sys.argv[1], pdf=True)
"""


@pytest.mark.slow
def test_files_are_the_same_bytes_in_another_process(tmp_path):
    for name, seed in (("one", "1"), ("two", "2")):
        environment = {**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": os.pathsep.join(sys.path)}
        subprocess.run([sys.executable, "-c", FRESH, str(tmp_path / name)], env=environment, check=True)
    for suffix in (".png", ".svg", ".pdf"):
        first, second = ((tmp_path / f"{name}{suffix}").read_bytes() for name in ("one", "two"))
        assert first == second and len(first) > 1000


@pytest.mark.slow
def test_files_are_the_same_bytes_twice(solution, tmp_path):
    first, second = (save_figure(solution.plot("reaction"), tmp_path / f"{name}.v1") for name in "ab")
    assert [path.name for path in first] == ["a.v1.png", "a.v1.svg"]
    assert all(a.read_bytes() == b.read_bytes() for a, b in zip(first, second, strict=True))
    assert b"dc:date" not in first[1].read_bytes()


def test_a_moment_that_is_rounding_beside_the_force_is_flat():
    """A pendulum in its plane: the hinge carries 10 N and no moment, which comes out as some 1e-16 N m."""
    rod = Body("rod", 1.0, (0.1, 0.1, 0.1), position=(0.3, 0, 0.1), com=(0.2, 0, -0.05))
    swing = simulate(System([rod], [Revolute(GROUND, rod, at=(0, 0, 0), axis=(0, 1, 0), name="hinge")]), 1.0)
    force, moment = swing.plot("reaction", "hinge").axes
    assert np.diff(force.get_ylim()) > 5.0 and np.diff(moment.get_ylim()) > 0.1


@pytest.mark.parametrize(("moment", "counts"), [(1e-7, False), (1e-3, True)])
def test_a_moment_far_away_is_rounding_of_the_arm(moment, counts):
    """A force of 1 N at 1e6 m is moved there to 1e-10 N m of rounding, times some."""
    force, moment, point = np.array([[0.0, 1.0, 0.0]]), np.array([[0.0, 0.0, moment]]), np.full((1, 3), 1e6)
    load = SimpleNamespace(force=force, moment=moment, point=point)
    assert acts(load, "moment") == counts and acts(load, "force")


def test_a_plot_without_a_quantity_is_what_a_page_shows():
    crank, rod = (Body(name, 1.0, (0.1, 0.2, 0.2), position=(x, 0.1, 0)) for name, x in (("crank", 0.5), ("rod", 1.5)))
    hinge = Revolute(GROUND, crank, at=(0, 0, 0), axis=(0, 1, 0), name="hinge")
    knee = Revolute(crank, rod, at=(1, 0, 0), axis=(0, 1, 0.2), name="knee")
    run = simulate(System([crank, rod], [hinge, knee, SpeedDriver(hinge, 3.0, name="motor")]), 0.3, output=11)
    labels = [axes.get_ylabel() for axes in run.plot().axes]
    assert labels == ["angle [rad]", "energy [J]", "effort of motor [N m]", "|reaction force| [N]",
                      "|reaction moment| [N m]"]  # fmt: skip
    fall = simulate(System([Body("stone", 1.0, (0.1, 0.2, 0.2))]), 0.3, output=11)
    assert len(fall.plot().axes) == 2  # no joints: angular velocity and energies
    with pytest.raises(ValueError, match="plot: parts without a quantity; give one"):
        run.plot(None, hinge)


def test_one_quantity_with_its_part_is_drawn_as_in_a_list(solution):
    hinge = solution.system.joints[0]
    for part in (hinge, hinge.name):
        alone, listed = solution.plot(("reaction", part)), solution.plot([("reaction", part)])
        assert [x.get_ylabel() for x in alone.axes] == [x.get_ylabel() for x in listed.axes]
    assert len(solution.plot(("angle", "energy")).axes) > 1


def test_two_quantities_are_pointed_to_a_list(solution):
    with pytest.raises(
        ValueError, match=r"'energy' is a quantity, not a part; several are a list: \['angle', 'energy'\]"
    ):
        solution.plot("angle", "energy")


def test_what_switches_is_drawn_as_engaged_or_not():
    one = Body("one", 1.0, (0.3, 0.3, 0.5), omega=(0, 0, 6.5))
    two = Body("two", 1.0, (0.6, 0.6, 1.0), omega=(0, 0, 0))
    shaft = Revolute(GROUND, one, at=(0, 0, 0), axis=(0, 0, 1), name="shaft")
    bearing = Revolute(one, two, at=(0, 0, 0.1), axis=(0, 0, 1), name="bearing")
    clutch = Clutch(bearing, torque=2.0, engaged=True, name="clutch")
    run = simulate(System([one, two], [shaft, bearing], [clutch]), 3.0)
    (panel,) = panels_of(run, "engaged")
    ((name, values),) = panel.lines
    locks = 6.5 / (2.0 / 0.5 + 2.0 / 1.0)  # the rates meet
    assert name == "clutch" and run.events[0].t == pytest.approx(locks, rel=1e-9)
    assert np.array_equal(values[run.t < locks - 1e-6], np.zeros(np.sum(run.t < locks - 1e-6)))
    assert values[run.t > locks + 1e-6].min() == 1.0 and values.shape == run.t.shape
    assert "engaged" in {entry[0] for entry in default_curves(run) if isinstance(entry, tuple)}
    for some in (run, simulate(System([one, two], [shaft, bearing], [clutch]), 0.5)):  # the second one never locks
        axes = some.plot("engaged", "clutch").axes[0]
        assert axes.get_ylabel().startswith("engaged") and axes.get_ylim() == pytest.approx((-0.05, 1.05), abs=1e-12)
    for part in ("shaft", shaft):
        with pytest.raises(ValueError, match="engaged: give parts that switch at events; .* 'clutch'"):
            run.plot("engaged", part)
