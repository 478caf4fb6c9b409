"""assemble(near=): the motion of a known state goes on where it can, and what a user gave is met or refused."""

import numpy as np
import pytest
from helpers.chains import INERTIA, arm, four_bar

from mbsd3d import GROUND, AngleDriver, AssemblyError, Body, Ramp, Revolute, System, accelerations, simulate
from mbsd3d.equations.dense_solvers import mass_matrix_of
from mbsd3d.equations.jacobian import block_rows
from mbsd3d.extend import compile_system, load_state

RATES = {"hinge 0": 3.0, "hinge 1": -2.0, "hinge 2": 5.0}


def rates(system, state, names=RATES):
    found = accelerations(system, state)
    return [found.rate(name)[0] for name in names]


@pytest.mark.parametrize("links", [3, 30], ids=["dense", "sparse"])
def test_a_chain_that_is_moved_keeps_its_rates(links):
    system = arm(links)
    start = system.assemble(rates=RATES)
    moved = system.assemble(angles={"hinge 0": 2.0, "hinge 1": 20.0}, near=start)
    assert rates(system, moved) == pytest.approx(list(RATES.values()), abs=1e-9)
    assert accelerations(system, moved).angle("hinge 1")[0] == pytest.approx(20.0, abs=1e-11)


@pytest.mark.parametrize("make", [arm, four_bar])
def test_an_unchanged_state_stays(make):
    system = make()
    joint = system.joints[0]
    start = simulate(system, 0.2, state=system.assemble(rates={joint: 2.0})).final
    again = system.assemble(near=start, t=start.t)
    np.testing.assert_allclose(again.v, start.v, rtol=0, atol=1e-11 * np.abs(start.v).max())
    np.testing.assert_allclose(again.q, start.q, rtol=0, atol=1e-12)


def test_a_loop_that_is_moved_goes_on_and_a_rate_asked_for_wins():
    system = four_bar()
    start = system.assemble(angles={"drive": 0.4}, rates={"drive": 3.0})
    beside = system.assemble(angles={"drive": 0.4 + 1e-4}, near=start)
    assert rates(system, beside, ["drive"]) == pytest.approx([3.0], abs=3e-3)  # in proportion to the way
    assert accelerations(system, beside).drift().velocity[0] < 1e-12
    wanted = system.assemble(angles={"drive": 1.4}, near=start, rates={"drive": -1.0})
    assert rates(system, wanted, ["drive"]) == pytest.approx([-1.0], abs=1e-12)


def test_a_rate_changes_the_rest_as_a_blow_would():
    """At the same pose: J dv = 0 beside the blow, and M dv a combination of its rows: dv'M w = 0 for what is free."""
    system = arm()
    start = system.assemble(angles={"hinge 1": 0.7}, rates=RATES)
    struck = system.assemble(near=start, rates={"hinge 1": 1.0})
    compiled = compile_system(system)
    data = compiled.data()
    load_state(compiled, data, start)
    others = [system.assemble(near=start, rates={**dict.fromkeys(RATES, 0.0), name: 1.0}).v for name in RATES]
    M = mass_matrix_of(compiled.model, data, True)
    free = [others[0], others[2]]  # motions in which hinge 1 rests
    change = struck.v - start.v
    assert np.abs(block_rows(compiled.model, data).times(change)).max() < 1e-11
    assert np.abs([w @ M @ change for w in free]).max() < 1e-11 * np.abs(M).max()
    assert rates(system, struck)[0] != pytest.approx(3.0, abs=0.1)


def test_drivers_say_how_fast():
    system = four_bar()
    driven = System(system.bodies, [*system.joints, AngleDriver(system.joints[0], Ramp(4.0))])
    start = driven.state()
    later = driven.assemble(near=start, t=2.0)
    assert rates(driven, later, ["drive"]) == pytest.approx([4.0], abs=1e-12)
    assert accelerations(driven, later).angle("drive")[0] == pytest.approx(8.0, abs=1e-12)


def test_velocities_of_the_description_count_while_the_state_has_them():
    stone = Body("stone", 2.0, INERTIA, com=(0.1, 0.02, 0.03), velocity=(1.0, 2.0, 3.0))
    free = System([stone])
    np.testing.assert_array_equal(free.assemble(near=free.state()).v[:3], [1.0, 2.0, 3.0])
    fallen = simulate(free, 1.0, state=free.state()).final
    np.testing.assert_allclose(free.assemble(near=fallen).v, fallen.v, rtol=0, atol=1e-12)
    swung = Body("swung", 2.0, INERTIA, com=(0.1, 0.02, 0.03), position=(0.4, 0, 0), velocity=(0.0, 0.8, 0.0))
    hinged = System([swung], [Revolute(GROUND, swung, at=(0, 0, 0), axis=(0, 0, 1), name="pin")])
    assert rates(hinged, hinged.assemble(near=hinged.state()), ["pin"]) == pytest.approx([2.0], abs=1e-12)
    with pytest.raises(AssemblyError, match="the given velocities contradict a joint"):
        hinged.assemble(angles={"pin": 0.5}, near=hinged.state())  # it would be (-0.38, 0.70, 0)
    later = simulate(hinged, 0.3).final
    moved = hinged.assemble(angles={"pin": 0.5}, near=later)
    assert rates(hinged, moved, ["pin"]) == pytest.approx(rates(hinged, later, ["pin"]), rel=1e-9)
