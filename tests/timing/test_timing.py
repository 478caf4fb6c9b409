"""Limits in seconds, for an idle machine: ``make timing`` runs them, and neither of the two suites does."""

import json
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from helpers import refused_models, refused_xml
from helpers.models import revolute_chain
from helpers.sweep_models import ratio, shafts

from bicycle import TYPICAL, Meijaard2007, whipple
from mbsd3d import RK4, Kinematic, Stepper, read_urdf, simulate, sweep
from mbsd3d.view.scene.artist import draw_system
from validation.benchmark.precision import measure
from validation.benchmark.problems import PROBLEMS
from validation.benchmark.speed import tyre_seconds
from validation.cases.inline_four import CRANK_RATE, inline_four, orders
from validation.cases.mechanisms import ladder

pytestmark = pytest.mark.timing

ROOT = Path(__file__).parents[2]
FORCE_2X = json.loads((ROOT / "engines" / "references" / "engine.json").read_text())["sweep_RL_I4_2x"]["L=1.5"]
BRIEF = 5.0  # s in which a file that cannot be read is refused


@contextmanager
def within(limit):
    """At most so many seconds."""
    began = time.perf_counter()
    yield
    assert time.perf_counter() - began < limit


def command(*arguments):
    """The command line in a process of its own."""
    code = "from mbsd3d.cli import main; main(prog_name='mbsd3d')"
    return subprocess.Popen([sys.executable, "-c", code, *map(str, arguments)], stdout=subprocess.PIPE, text=True)


def test_help_comes_at_once():
    command("--help").communicate()
    with within(0.6):  # 0.1 s on a free machine
        assert "Usage: mbsd3d" in command("--help").communicate()[0]


def test_ctrl_c_ends_a_run_at_once(tmp_path):
    (tmp_path / "arm.py").write_text(
        "from mbsd3d import GROUND, Body, Revolute, System\n"
        "def build():\n"
        "    arm = Body('arm', 1.0, (0.1, 0.1, 0.02), position=(0, 0.6, -0.8))\n"
        "    print('ready', flush=True)\n"
        "    return System([arm], [Revolute(GROUND, arm, at=(0, 0, 0), axis=(1, 0, 0))])\n"
    )
    running = command("run", tmp_path / "arm.py", "--t-end", 1e9, "--output", 1_000_000, "--out", tmp_path)
    assert running.stdout.readline() == "ready\n"
    time.sleep(5.0)
    running.send_signal(signal.SIGINT)
    with within(1.5):  # 0.2 s on a free machine
        running.communicate()
    assert running.returncode == 130


@pytest.mark.parametrize("form", refused_models.FORMS)
@pytest.mark.parametrize("case", refused_models.HOSTILE)
def test_what_is_no_model_is_refused_at_once(tmp_path, case, form):
    with within(BRIEF):
        refused_models.check_refused(tmp_path, case, form)


@pytest.mark.parametrize("case", refused_xml.HOSTILE)
def test_hostile_files_are_refused_at_once(tmp_path, case):
    with within(BRIEF):
        refused_xml.check_refused(tmp_path, case)


def test_a_thousand_bodies_are_drawn_in_three_seconds():
    chain = revolute_chain(1000)
    with within(3.0):  # 0.4 s on a free machine
        draw_system(chain)


def test_a_robot_of_a_thousand_links_is_read_in_time_that_grows_with_its_links(tmp_path):
    """Each joint has friction, whose damping asks for what hangs on it: summed anew for each, it takes 8 s."""
    mass = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>'
    links = "".join(f'<link name="l{i}">{mass}</link>' for i in range(1001))
    joints = "".join(
        f'<joint name="j{i}" type="continuous"><parent link="l{i}"/><child link="l{i + 1}"/><axis xyz="0 0 1"/>'
        '<dynamics friction="0.1"/></joint>'
        for i in range(1000)
    )
    path = tmp_path / "robot.urdf"
    path.write_text(f'<robot name="r">{links}{joints}</robot>')
    with within(3.0):  # 0.3 s on a free machine
        read_urdf(path, floating=False)


@pytest.mark.parametrize(("build", "n"), [(revolute_chain, 1000), (ladder, 100)])
def test_check_of_a_large_system(build, n):
    system = build(n)
    with within(10.0):
        system.check()


def figure(build, grid, measure, run):
    """(dataset, wall seconds, processor seconds of this process) of a sweep on threads, the second of two."""
    for _ in range(2):
        wall, processor = time.perf_counter(), time.process_time()
        table = sweep(build, grid, measure, run=run, executor="threads")
        wall, processor = time.perf_counter() - wall, time.process_time() - processor
    return table, wall, processor


def building(build, cells):
    """Processor seconds of describing a System, mean of the cells."""
    began = time.process_time()
    for cell in cells:
        build(**cell)
    return (time.process_time() - began) / len(cells)


def test_900_engines():
    """An engine is solved in 6 to 7 times the time of describing it, 10 with two threads that take turns.

    The figure in seconds depends on the machine (5 to 15 s on two cores):
    ``python -m validation.benchmark.planar_cost`` prints it.
    """
    grid = {"radius": np.linspace(0.5, 1.0, 30), "rod_length": np.linspace(1.5, 4.0, 30)}
    run = {"t_end": 2 * np.pi / CRANK_RATE, "method": Kinematic(), "output": 37}
    cells = [{"radius": 0.5 + 0.005 * k, "rod_length": 1.5 + 0.025 * k} for k in range(100)]
    before = building(inline_four, cells)
    table, wall, processor = figure(inline_four, grid, orders, run)
    one = (before + building(inline_four, cells)) / 2
    print(f"900 engines: {wall:.1f} s, {processor:.1f} s of processor time; describing one {1e3 * one:.2f} ms")
    assert table.attrs["failed"] == 0 and processor < 15.0 * 900 * one
    found = float(table["force_2x"].sel(radius=1.0, rod_length=1.5))
    assert found == pytest.approx(FORCE_2X, rel=1e-11)  # digits of the file: 16


def test_900_cardan_transients():
    """The target is 10 s on two cores that have nothing else to do, so 20 s of processor time."""
    bends = np.radians(np.linspace(1.0, 60.0, 900))
    table, wall, processor = figure(shafts, {"bend": bends, "turns": [1.0]}, ratio, {"rtol": 1e-6, "output": 65})
    print(f"900 Cardan transients: {wall:.1f} s, {processor:.1f} s of processor time")
    assert table.attrs["failed"] == 0 and processor < 20.0
    np.testing.assert_allclose(table["ratio"][:, 0], 1 / np.cos(bends) ** 2, rtol=1e-12)


@pytest.mark.parametrize("name", ["Bricard", "top slow"])
def test_loops_and_tops_take_their_peers_longer(name):
    """Measured on a busy machine: 20 for Bricard's MuJoCo at 1e-8, 34 for the top's."""
    row = measure(PROBLEMS[name]())
    assert row.ratio("MuJoCo", 1e-8)[0] > 2.0 and row.ratio("Exudyn", 1e-6)[0] > 1.5


def test_a_tyre_costs_a_third_of_a_microsecond():
    tyre_seconds(rounds=1)  # compiled
    assert tyre_seconds() < 0.3e-6


def test_twenty_seconds_on_tyres():
    """Measured 0.04 s, at rtol 1e-6."""
    bicycle = whipple(Meijaard2007(), 5.0, lean_rate=0.1, tyres=TYPICAL)
    start, best = bicycle.state(), np.inf
    for _ in range(4):
        began = time.process_time()
        simulate(bicycle, 20.0, state=start, rtol=1e-6, output=201)
        best = min(best, time.process_time() - began)
    assert best < 0.3


def test_a_slice_costs_little_more_than_its_step():
    """At most 50 us beside the compiled loop's own step; the step of one slice is taken from one run of as many."""
    system, count, h = revolute_chain(3), 2000, 1e-4
    run = simulate(system, count * h, method=RK4(h), output=2)
    run = simulate(system, count * h, method=RK4(h), output=2)
    stepper = Stepper(system, method=RK4(h))
    stepper.advance(h)
    began = time.perf_counter()
    for k in range(2, count):
        stepper.advance(k * h)
    spent = (time.perf_counter() - began) / (count - 2)
    assert spent - run.record.loop_seconds / count < 50e-6
