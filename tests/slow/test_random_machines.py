"""Random machines with stops, freewheels, clutches, friction from loads and rows that switch, against equations of
their own: 50 of each kind, 1000 in `make calibrate`."""

import os

import numpy as np
import pytest
from helpers.plane_machines import SecondFormulation, random_machine, system_of
from helpers.plane_mechanisms import Undecided, march, random_plane
from helpers.plane_mechanisms import system_of as system_of_plane
from helpers.space_machines import march as march_in_space
from helpers.space_machines import random_chain
from helpers.space_machines import system_of as system_in_space

from mbsd3d import Cylindrical, IntegrationError, simulate

pytestmark = pytest.mark.slow

MACHINES = int(os.environ.get("MBSD3D_TEST_RANDOM_MACHINES", "50"))
EVENTS, T_END = 5, 4.0
TOLERANCE = 1e-5  # [s, rad, m, rad/s, m/s] of the first events; hops lower than this end elsewhere in both


def is_grazed(run, event):
    """Whether a part was touched and nothing came of it, as by rounding where it has just been left."""
    touched = event.action in ("is struck at its lower limit", "is struck at its upper limit", "locks")
    return touched and not event.impulses and run.at(event.t).modes[event.part].name == "open"


@pytest.mark.parametrize("seed", range(MACHINES))
def test_the_first_events_are_those_of_the_second_formulation(seed):
    machine = random_machine(seed)
    system, start, joints = system_of(machine)
    second, known = SecondFormulation(machine), []
    while len(known) < EVENTS and (found := second.next_event(T_END)) is not None:
        if known and found[0] - known[-1][0] < TOLERANCE:
            break  # hops that end in rest, which the second formulation does not close
        known.append((*found, second.q.copy(), second.v.copy()))
    known = known[:-1] if second.together else known  # which is one impact of both here
    until = known[-1][0] + 1e-3 if len(known) == EVENTS else T_END
    run = simulate(system, until, state=start, rtol=1e-11)
    events = [event for event in run.events if not is_grazed(run, event)]
    assert run.certificate.passed and len(events) >= len(known)
    assert all(run.rate(x).min() > -1e-8 for x, wheel in zip(joints, machine.wheels, strict=True) if wheel)
    for event, (t, k, q, v) in zip(events, known, strict=False):
        assert abs(event.t - t) < TOLERANCE and f"part{k}" in event.what
        after = int(np.searchsorted(run.t, event.t, side="right")) - 1
        values = [run.angle(x)[after] if x.angle() is not None else run.slide(x)[after] for x in joints]
        rates = [run.rate(x)[after] for x in joints]
        assert np.abs(np.array(values) - q).max() < TOLERANCE and np.abs(np.array(rates) - v).max() < TOLERANCE


def values_of(run, plane, joints):
    """Return (values, rates) of all coordinates (samples, joints), NaN where a joint has none or another one."""
    values, rates = np.full((2, run.t.size, len(joints)), np.nan)
    for k, (pair, x) in enumerate(zip(plane.pairs, joints, strict=True)):
        if not pair.plain:
            values[:, k] = run.slide(x) if pair.kind == "guide" else run.angle(x)
            rates[:, k] = np.nan if isinstance(x, Cylindrical) else run.rate(x)
    return values, rates


def hands_over(event):
    """Return whether a part takes the load of another one over, and nothing moves otherwise than before."""
    return "holds" in event.action or "reaches its limit" in event.action


@pytest.mark.parametrize("seed", [*range(MACHINES), 120, 238, 297])
def test_mechanisms_with_friction_from_loads_move_as_the_second_formulation(seed):
    """Chains, slider-cranks, four-bars and swinging guides; samples between events are compared as well."""
    plane = random_plane(seed)
    try:
        known, samples, why = march(plane, EVENTS, 3.0)
    except Undecided as error:
        pytest.skip(f"the second formulation leaves it open: {error}")
    until = known[-1][0] + 1e-3 if known and (why or len(known) == EVENTS) else 3.0
    samples = [x for x in samples if x[0] < until]
    system, start, joints = system_of_plane(plane)
    try:
        run = simulate(system, until, state=start, rtol=1e-10, output=np.unique([0.0, *(x[0] for x in samples), until]))
    except IntegrationError as error:
        assert any(f"'{system.name(part)}'" in str(error) for part in (*system.joints, *system.forces))
        pytest.skip(f"refused by name: {error}")
    assert run.certificate.passed
    times = np.array([event.t for event in run.events])
    assert all(np.abs(times - t).min(initial=np.inf) < TOLERANCE for t, _ in known)
    last = known[-1][0] if known else until
    beyond = [x for x in run.events if x.t < last and not hands_over(x)]
    assert all(np.abs(np.array([t for t, _ in known]) - x.t).min() < TOLERANCE for x in beyond)
    values, rates = values_of(run, plane, joints)
    for t, q, v in samples:
        k = int(np.searchsorted(run.t, t))
        assert np.nanmax(np.abs(values[k] - q), initial=0.0) < TOLERANCE
        if np.abs(times - t).min(initial=np.inf) > TOLERANCE:  # else before the one and after the other
            assert np.nanmax(np.abs(rates[k] - v), initial=0.0) < TOLERANCE


@pytest.mark.parametrize("seed", range(MACHINES))
def test_chains_in_space_with_a_stop_or_a_clutch_move_as_kane_says(seed):
    """General directions, centres of mass off the joints, rotors at joints; every check of the certificate passes."""
    machine = random_chain(seed)
    system, start, joints = system_in_space(machine)
    known = march_in_space(machine, 1.5, EVENTS)
    # ends at an event, which the velocities behind belong to, or at the end
    run = simulate(system, known.t, state=start, rtol=1e-10)
    assert run.certificate.passed, run.certificate
    events = [event.t for event in run.events if not is_grazed(run, event)]
    before = [t for t in known.events if t < known.t - TOLERANCE]
    assert len(events) >= len(before)
    assert np.allclose(events[: len(before)], before, rtol=0.0, atol=TOLERANCE)
    kinds = zip(joints, machine.chain.slides, strict=True)
    values = [run.slide(x)[-1] if slides else run.angle(x)[-1] for x, slides in kinds]
    assert np.allclose(values, known.q, rtol=TOLERANCE, atol=TOLERANCE)
