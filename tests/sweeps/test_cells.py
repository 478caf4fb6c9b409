"""Cells of a sweep one after the other in one process: no number of one reaches another, to the last bit."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.sweep_models import shafts, wheel
from threadpoolctl import threadpool_info

from bicycle import Meijaard2007, whipple
from mbsd3d import GROUND, Body, Cylindrical, Kinematic, Revolute, Spherical, SpringDamper, System, simulate, sweep
from mbsd3d.errors import AssemblyError
from validation.cases.inline_four import CRANK_RATE, inline_four, orders


def four_bar(x):
    """A crank, a coupler and a rocker across the axis (1, 2, 2)/3, on a spring: their lengths and stiffness vary."""
    axes = np.array([[2, -2, 1], [1, 2, 2], [2, 1, -2]]) / 3.0  # in the plane, out of it, in the plane
    points = np.array([(0, 0), (0.1, 0.3 + 0.05 * x), (0.9, 0.6 + 0.1 * x), (0.8, 0)]) @ axes[[0, 2]] + (0.2, -0.1, 0.4)

    def link(name, start, end, mass):
        along = end - start
        length = np.linalg.norm(along)
        frame = np.column_stack([along / length, axes[1], np.cross(along / length, axes[1])])
        moments = (0.01 * mass, mass * length**2 / 12, mass * length**2 / 12)
        return Body(name, mass, moments, com=(0.5 * length, 0.02, 0.01), position=start, orientation=frame)

    A0, A, B, B0 = points
    crank, coupler, rocker = link("crank", A0, A, 1.0 + x), link("coupler", A, B, 2.0), link("rocker", B0, B, 1.5)
    joints = [
        Revolute(GROUND, crank, at=A0, axis=axes[1], name="crank hinge"),
        Revolute(crank, coupler, at=A, axis=axes[1], name="pin"),
        Spherical(coupler, rocker, at=B, name="ball"),
        Cylindrical(GROUND, rocker, at=B0, axis=axes[1], name="rocker hinge"),
    ]
    spring = SpringDamper(
        GROUND, rocker, at_a=(1.2, 0.3, 0.2), at_b=B, stiffness=200.0 + 90.0 * x, damping=2.0, length=0.3
    )
    return System([crank, coupler, rocker], joints, [spring])


CELLS = {
    "inline four": (
        lambda x: inline_four(0.5 + 0.3 * x, 1.5 + 2.0 * x),
        {"t_end": np.pi / CRANK_RATE, "method": Kinematic(), "output": 13},
    ),
    "cardan": (lambda x: shafts(0.1 + 0.9 * x, 1.0)[0], {"t_end": 0.3, "rtol": 1e-6, "output": 17}),
    "four-bar": (four_bar, {"t_end": 0.4, "rtol": 1e-6, "output": 11}),
    "bicycle": (
        lambda x: whipple(replace(Meijaard2007(), c=0.07 + 0.02 * x), 4.6, lean_rate=0.1),
        {"t_end": 0.3, "rtol": 1e-6, "output": 7},
    ),
}


def samples(system, run, **more):
    """All samples and reactions of a run, as bytes."""
    motion = simulate(system, progress=False, **run, **more)
    loads = [motion.reaction(joint) for joint in system.joints]
    numbers = [*motion.arrays.values(), *(x for load in loads for x in (load.force, load.moment, load.point))]
    return [np.asarray(x).tobytes() for x in numbers]


@pytest.mark.parametrize("name", CELLS)
def test_cells_do_not_touch_each_other(name):
    build, run = CELLS[name]
    first = samples(build(0.3), run)
    other = samples(build(0.8), run)
    assert first != other and samples(build(0.3), run) == first


@pytest.mark.parametrize("name", CELLS)
def test_a_start_asked_for_before_changes_no_bit(name):
    """Also after a start elsewhere, whose spanning tree is another one."""
    build, run = CELLS[name]
    system = build(0.4)
    alone = samples(build(0.4), run)
    start = system.state()
    assert samples(system, run, state=start) == alone
    simulate(system, progress=False, **{**run, "t_end": 0.5 * run["t_end"]}, state=start)
    elsewhere = simulate(system, progress=False, **run).final
    simulate(system, progress=False, **{**run, "t_end": 1.5 * run["t_end"]}, state=elsewhere)
    assert samples(system, run) == alone


def test_reactions_of_one_joint_are_those_of_all():
    """Of a run of many samples one joint is computed at a time: the same motion at the same times, the same bits."""
    build, run = CELLS["four-bar"]
    few = np.linspace(0.0, 0.4, 11)
    many = np.unique(np.concatenate([few, np.linspace(0.0, 0.4, 7000)]))
    short = simulate(build(0.2), **{**run, "output": few})
    long = simulate(build(0.2), **{**run, "output": many})
    shared = np.isin(many, few)
    for name in ("crank hinge", "pin", "ball", "rocker hinge"):
        one, other = short.reaction(name), long.reaction(name)
        for x in ("force", "moment", "point"):
            assert np.array_equal(getattr(one, x), getattr(other, x)[shared])


def blas_threads():
    return [x["num_threads"] for x in threadpool_info() if x["user_api"] == "blas"]


def most_blas_threads(solution):
    return {"threads": max(blas_threads())}


@pytest.mark.parametrize("executor", ["threads", pytest.param("processes", marks=pytest.mark.slow)])
def test_linear_algebra_of_all_cells_takes_one_thread(executor):
    """Cells that begin and end at any time: none gives another one back its threads. Afterwards they are as before."""
    before = blas_threads()
    grid = {"torque": np.linspace(1.0, 2.0, 30), "inertia": [0.3, 0.7]}
    found = sweep(wheel, grid, most_blas_threads, run={"t_end": 0.1, "rtol": 1e-6}, executor=executor)
    assert (found["threads"] == 1.0).all() and blas_threads() == before


def test_velocities_that_are_all_given_are_taken_to_the_last_bit():
    """Without joints; with one that they contradict they are refused as before."""
    given = {"velocity": (0.31, -2.7, 1.9), "omega": (5.3, 0.1, -7.7)}
    bodies = [Body(name, 1.7, (0.2, 0.3, 0.4), com=(0.1, 0.2, -0.3), **given) for name in "ab"]
    v = System(bodies).state().v
    assert v.tolist() == 2 * [*given["velocity"], *given["omega"]]
    with pytest.raises(AssemblyError, match="the given velocities contradict a joint"):
        System(bodies, [Spherical(GROUND, bodies[0], at=(0.4, 0.1, 0.2))]).state()


@pytest.mark.slow
def test_engines_have_the_same_bits_on_threads_and_in_new_processes():
    grid = {"radius": [0.5, 0.61, 0.83], "rod_length": [1.5, 2.7]}
    run = {"t_end": 2 * np.pi / CRANK_RATE, "method": Kinematic(), "output": 37}
    threads, processes = (sweep(inline_four, grid, orders, run=run, executor=kind) for kind in ("threads", "processes"))
    for name in ("force_1x", "force_2x", "force_4x", "torque_2x"):
        single = [
            orders(simulate(inline_four(r, length), progress=False, **run))[name]
            for r in grid["radius"] for length in grid["rod_length"]
        ]  # fmt: skip
        assert threads[name].values.ravel().tolist() == processes[name].values.ravel().tolist() == single
