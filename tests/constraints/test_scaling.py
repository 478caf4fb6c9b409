"""Large mechanisms: ranks against dense analysis, work and time in proportion to the bodies, memory of a run."""

import os
import subprocess
import sys
import tracemalloc

import numpy as np
import pytest
from helpers.models import at_reference, dense_rows, revolute_chain

from mbsd3d import RK4, PointOnLine, Revolute, System, simulate
from mbsd3d.constraints.elimination import Elimination
from mbsd3d.constraints.rank import choose_rows
from mbsd3d.equations.jacobian import scaled_rows
from mbsd3d.extend import build_spanning_tree, compile_system
from mbsd3d.results import record
from mbsd3d.results.record import Samples
from mbsd3d.rotations import conjugate, logarithm, multiply
from validation.cases.mechanisms import ladder


def work(system):
    """Numbers computed by the rank analysis, and by the tree and its loop rows."""
    compiled, data = at_reference(system)
    left = Elimination(scaled_rows(compiled.model, data), 1e-10)
    tree = build_spanning_tree(compiled.model, data)
    return sum(
        step.F.size * (1 + step.rest.size) for step in left.steps
    ), tree.link.size + tree.entry.size + tree.skyline.size


@pytest.mark.parametrize("build", [revolute_chain, ladder])
def test_work_is_proportional_to_the_number_of_bodies(build):
    small, large = work(build(80)), work(build(320))
    for few, many in zip(small, large, strict=True):
        assert np.log(many / few) / np.log(4.0) < 1.1  # 1, and the constant number of rows in the core


def spent(call):
    """(calls of functions, peak of the memory) of a call."""
    calls = []
    sys.setprofile(lambda frame, event, argument: calls.append(1) if event in ("call", "c_call") else None)
    try:
        call()
    finally:
        sys.setprofile(None)
    tracemalloc.start()
    try:
        call()
        return len(calls), tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.slow
@pytest.mark.parametrize("build, few", [(revolute_chain, 47), (ladder, 19)])  # no other test has kept their plans
def test_calls_and_memory_before_the_first_step_grow_in_proportion(build, few):
    """Four times the bodies: at most 4 for linear growth, 16 for quadratic; beside it, what does not grow."""
    found = []
    for n in (few, 4 * few):
        compiled, data = at_reference(build(n))
        parts = (
            lambda: compile_system(build(n)),  # noqa: B023
            lambda: choose_rows(compiled.model, data),  # noqa: B023
            lambda: build_spanning_tree(compiled.model, data),  # noqa: B023
            lambda: build(n).state(),  # noqa: B023
        )
        found.append([spent(part) for part in parts])
    assert (np.divide(*found[::-1]) < 5.0).all(), found


def test_check_of_a_chain_and_of_a_ladder():
    chain, rungs = revolute_chain(150).check(), ladder(25).check()
    assert (chain.rank, chain.rows, chain.mobility) == (750, 750, 150)
    assert chain.neighbour_ranks == () and rungs.neighbour_ranks == (305, 305)
    assert (rungs.rank, rungs.redundant, rungs.mobility) == (305, 75, 1)
    assert len(rungs.shares) == 76
    assert not any(share.force_unique and share.moment_unique for share in rungs.shares)


def test_cure_of_a_ladder_is_found_and_cures():
    """One hinge per loop becomes a point on a line: 2 of 5 rows."""
    n = 15
    system = ladder(n)
    (cure,) = system.check().cures
    assert cure.rows_removed == 3 * n
    weaker = dict(cure.replacements)
    assert set(weaker.values()) == {"PointOnLine"}
    joints = [PointOnLine(j.a, j.b, at=j.at, axis=j.axis) if system.name(j) in weaker else j for j in system.joints]
    cured = System(bodies=system.bodies, joints=joints)
    A = dense_rows(*at_reference(cured))
    assert np.linalg.matrix_rank(A, rtol=1e-10) == len(A) == 6 * len(system.bodies) - 1


@pytest.mark.parametrize("n", [2, 20])
def test_misfit_of_a_hinge_is_found_in_short_and_in_long_ladders(n):
    """The last hinge is built 1 um out of line along its axis: play, and the only misfit there is."""
    system, out = ladder(n), 1e-6
    *others, last = system.joints
    off = Revolute(last.a, last.b, at=last.at, at_b=last.at + out * last.axis, axis=last.axis, name="off")
    found = System(bodies=system.bodies, joints=[*others, off]).check()
    assert found.verdict.startswith("redundant within the as-built tolerance")
    assert (found.mobility, found.redundant) == (1, 3 * n)
    assert found.misfit == pytest.approx(out, rel=1e-3)  # second-order tilt of the rods


def test_a_ladder_assembles_as_parallelograms_do():
    """All rods turn by the angle of the first, no coupler turns."""
    n, angle = 20, 0.35
    system = ladder(n)
    state = system.assemble(angles={"foot 0": angle})
    for body, pose in zip(system.bodies, state.q.reshape(-1, 7), strict=True):
        turned = logarithm(multiply(pose[3:], conjugate(body.orientation)))
        expected = angle * system.joints[0].axis if body.name.startswith("rod") else np.zeros(3)
        np.testing.assert_allclose(turned, expected, rtol=0, atol=1e-12)  # rounding, times a condition of about 100


def test_reactions_of_a_ladder_are_told_apart():
    system = ladder(16)
    solution = simulate(system, 0.05, output=3)
    feet = [solution.reaction(f"foot {k}") for k in (0, 9)]
    assert not any(foot.unique for foot in feet)
    assert solution.certificate.passed, solution.certificate.failures


@pytest.mark.parametrize("expected", [0, 5, 64])
def test_samples_are_kept_whatever_their_number(expected):
    rng = np.random.default_rng(1)
    widths = (1, 5, 12, 3, 0, 2, 2, 2)
    rows = rng.normal(size=(64, sum(widths)))
    taken = Samples(widths, expected)
    for part in np.split(rows, [1, 1, 9, 40]):
        taken.take(part)
    arrays = taken.finished()
    assert tuple(arrays) == ("t", "y", "acceleration", "lam", "coordinate", "potential", "power", "residual")
    np.testing.assert_array_equal(np.concatenate(list(arrays.values()), axis=1), rows)
    assert all(array.flags.c_contiguous for array in arrays.values())


def test_a_small_buffer_gives_the_same_samples(monkeypatch):
    system, method = revolute_chain(3), RK4(0.01)
    whole = [simulate(system, 0.5, method=method, output=output) for output in (190, None)]
    monkeypatch.setattr(record, "BUFFER_NUMBERS", 1)
    monkeypatch.setattr(record, "BUFFER_SAMPLES_MIN", 2)
    for first, output in zip(whole, (190, None), strict=True):
        again = simulate(system, 0.5, method=method, output=output)
        for name, array in first.arrays.items():
            np.testing.assert_array_equal(again.arrays[name], array)


def test_a_run_holds_its_samples_once(monkeypatch):
    """Peak of what is allocated, certificate included, against what is stored."""
    monkeypatch.setattr(record, "BUFFER_NUMBERS", 2**16)
    system = revolute_chain(100)
    state = system.state()
    assert simulate(system, 0.004, state=state, method=RK4(0.001)).certificate.passed  # compiles what is measured below
    tracemalloc.start()
    solution = simulate(system, 0.4, state=state, method=RK4(0.001), output=401)
    assert solution.certificate.passed
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    stored = sum(array.nbytes for name, array in solution.arrays.items() if name not in ("q", "z"))  # views
    assert stored > 9e6
    assert peak < 1.6 * stored + 4e6  # a tenth for each temporary of one quantity; model and work space 4 MB


@pytest.mark.slow
def test_five_thousand_bodies_run():
    system = revolute_chain(5000)
    solution = simulate(system, 0.004, method=RK4(0.001), output=5)
    assert solution.certificate.passed, solution.certificate.failures


@pytest.mark.slow
def test_a_thousand_bodies_a_thousand_samples_in_400_megabytes():
    script = """if True:
        import resource
        from helpers.models import revolute_chain
        from mbsd3d import RK4, simulate
        def peak():
            return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        simulate(revolute_chain(3), 0.01, method=RK4(0.001)).certificate
        system = revolute_chain(1000)
        before = peak()
        solution = simulate(system, 0.999, method=RK4(0.001), output=1000)
        assert solution.certificate.passed, solution.certificate.failures
        print(peak() - before)
    """
    command = [sys.executable, "-c", script]
    path = {"PYTHONPATH": os.pathsep.join(sys.path)}
    found = subprocess.run(command, env={**os.environ, **path}, capture_output=True, text=True)
    assert found.returncode == 0, found.stderr[-2000:]
    assert float(found.stdout) < 400.0
