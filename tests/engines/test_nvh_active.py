"""Active mounts: limits in closed form, poles against the general model step by step."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner

from engines.closed_forms import skyhook_limit
from engines.nvh.cli import nvh
from engines.nvh.control.cancel import Cancel, Path
from engines.nvh.control.report import ActiveMount
from engines.nvh.control.skyhook import Skyhook, growth, limit, on_mounts, push
from engines.nvh.excitation import presets
from engines.nvh.mounts import mounts
from engines.nvh.study import Study
from mbsd3d import GROUND, Body, Force, Prismatic, Sine, SpringDamper, System, linearize, simulate


@pytest.fixture(scope="module")
def cancel():
    study = Study(presets.preset("inline_4"), mounts.car("compact"), 2700.0, 0.8)
    return Cancel(study.on_mounts, study.source, 2700.0, 1, 2.0, 1500.0)


MASS, STIFFNESS, DAMPING = 178.0, 2.3e5, 640.0


def hooked(gain: float, corner: float, share: float) -> System:
    """A body on a spring and a skyhook."""
    body = Body("body", MASS, (1, 2, 3), com=(0.1, -0.2, 0.3))
    slide = Prismatic(GROUND, body, at=(0, 0, 0), axis=(0, 0, 1))
    spring = SpringDamper(GROUND, body, at_a=(0, 0, -0.3), at_b=(0, 0, 0), stiffness=STIFFNESS, damping=DAMPING)
    hook = Skyhook((0.2, 0.1, 0.0), gain, corner, share)
    return System([body], [slide], [spring, hook.force(body)], gravity=(0, 0, 0))


@pytest.mark.parametrize("gain", [0.0, 1e-9])
def test_own_states_that_motion_does_not_reach_keep_their_eigenvalues(gain):
    """The actuator alone is an oscillator, the body on its spring another one."""
    corner, share = 370.0, 0.6
    expected = np.concatenate([np.roots([MASS, DAMPING, STIFFNESS]), np.roots([1, 2 * share * corner, corner**2])])
    found = linearize(hooked(gain, corner, share)).eigenvalues
    np.testing.assert_allclose(np.sort_complex(found), np.sort_complex(expected), rtol=1e-9)


@pytest.mark.parametrize(("corner", "share"), [(370.0, 0.6), (90.0, 0.3)])
def test_a_skyhook_with_a_slow_actuator_is_unstable_from_where_routh_says(corner, share):
    def build(gain: float) -> System:
        return hooked(gain, corner, share)

    known = skyhook_limit(MASS, DAMPING, STIFFNESS, corner, share)
    assert limit(build) == pytest.approx(known, rel=1e-8)
    assert growth(build(0.9 * known)) < 0 < growth(build(1.1 * known))


def test_what_a_skyhook_does_to_the_car_is_against_what_it_does_to_the_engine():
    """Forces add up to nothing, and so do their moments about any point."""
    car, engine = (
        SimpleNamespace(r=np.array(r), velocity=np.array([0.0, 0.0, 0.7])) for r in ((1, 2, 3), (1.4, 1.7, 3))
    )
    loads, z_dot = np.zeros((2, 6)), np.zeros(2)
    push(0.0, (car, engine), np.array([31.0, -5.0]), (600.0, 370.0, 0.6), loads, z_dot)
    assert loads[1, :3].tolist() == [0.0, 0.0, -31.0]
    assert np.abs(loads[:, :3].sum(0)).max() == 0.0
    moment = loads[:, 3:].sum(0) + np.cross(car.r, loads[0, :3]) + np.cross(engine.r, loads[1, :3])
    assert np.abs(moment).max() < 1e-13  # rounding of 60 N m
    assert z_dot == pytest.approx([-5.0, 370.0**2 * (600.0 * 0.7 - 31.0) + 2 * 0.6 * 370.0 * 5.0], rel=1e-15)


def test_a_skyhook_damps_the_bounce(cancel):
    found = ActiveMount(Study(presets.preset("inline_4"), mounts.car("compact"), 2700.0, 0.8))
    most, before, after = found.hook
    assert after > 1.5 * before
    body, placed = cancel.held.body.rigid, cancel.held.placed
    assert growth(on_mounts(body, placed, Skyhook(found.cancel.mount.at, 1.05 * most))) > 0


def test_a_path_that_is_a_gain_alone_has_the_limit_of_theory():
    path = Path(np.zeros((0, 0)), np.zeros(0), np.zeros(0), -1.7, 1e-3)
    assert path.gain(300.0) == pytest.approx(-1.7)
    assert path.limit(300.0) == pytest.approx(2 / 1.7**2, rel=1e-9)  # 1 - step g^2 > -1


def test_the_sampled_path_is_that_of_the_mount(cancel):
    """At many samples a period the held path is the continuous one: force of mount and actuator on the car."""
    fine = replace(cancel, rate=4e5)
    held, W = fine.held, fine.W
    D = held.feet(fine.turning, np.array([W]))[0]
    at = 3 * fine.which + 2
    # force at the car per force on the head: Z Y - 1 = - D / Z for a mount whose axes are those of the car
    Z = fine.mount.rates[2] + 1j * W * fine.mount.damping[2]
    assert fine.path.gain(W) == pytest.approx(-D[at, at] / Z, rel=2e-3)  # half a sample late: W T / 2


@pytest.mark.parametrize("share", [0.05, 0.5])
def test_poles_say_what_the_general_model_does(cancel, share):
    step, count = share * cancel.path.limit(cancel.W), 300
    known = cancel.predicted(step, count)
    # second order of a roll by half a degree
    assert np.abs(cancel.run(step, count) - known).max() < 5e-3 * abs(cancel.force)


def test_what_they_differ_by_is_of_second_order(cancel):
    """No mean torque, and a load of a tenth: the difference is a hundredth."""
    held, load = replace(cancel.held, torque=0.0), cancel.source.at(cancel.rpm)
    off = []
    for share in (1.0, 0.1):
        small = replace(load, force=share * load.force, moment=share * load.moment)
        source = SimpleNamespace(at=lambda rpm, small=small: small, inertia=cancel.source.inertia)
        one = replace(cancel, held=held, source=source)
        step = 0.5 * one.path.limit(one.W)
        off.append(np.abs(one.run(step, 200) - one.predicted(step, 200)).max())
    assert off[1] == pytest.approx(0.01 * off[0], rel=0.02)


def test_beyond_the_limit_the_force_grows(cancel):
    step = 2.0 * cancel.path.limit(cancel.W)
    size = np.abs(np.linalg.eigvals(cancel.path.loop(cancel.W, step))).max()
    found = np.abs(cancel.run(step, 600))
    early, late = found[200:300].max(), found[500:600].max()
    # 300 samples later, in a growth that beats with the order
    assert np.log(late / early) == pytest.approx(300 * np.log(size), rel=0.1)


def test_the_order_goes_and_the_actuator_gives_what_is_said(cancel):
    step = 0.2 * cancel.path.limit(cancel.W)
    count = int(8 * cancel.path.time(cancel.W, step) * cancel.rate)
    left = cancel.predicted(step, count)
    assert np.abs(left[-60:]).max() < 2e-3 * abs(cancel.force)
    size, power = cancel.actuator
    # at the end the mount's force and the actuator's cancel: |f + G u| = 0
    assert size == pytest.approx(abs(cancel.force / cancel.path.gain(cancel.W)))
    # the same force as a sine on the general model, settled: what it gives on average over ten periods
    system, period = cancel.system(), 2 * np.pi / cancel.W
    phase = np.angle(-cancel.force / cancel.path.gain(cancel.W)) + np.pi / 2
    push = Force(system.bodies[0], (0, 0, Sine(size, 1 / period, phase)), at=cancel.mount.at, name="push")
    driven, times = replace(system, forces=[*system.forces[:-1], push]), period * np.linspace(100, 110, 401)
    given = simulate(driven, times[-1], state=cancel.start(), output=times).force("push").power[:-1].mean()
    assert power == pytest.approx(given, rel=2e-3)  # the map is of first order


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (dict(which=7), "there are 0 to 2"),
        (dict(order=0.3), "a half or a whole one"),
        (dict(rate=200.0), "give 360 Hz or more"),
        (dict(rpm=-1.0), "rpm"),
    ],
)
def test_controllers_that_cannot_be_are_refused(cancel, change, text):
    with pytest.raises(ValueError, match=text):
        replace(cancel, **change)


def test_inclined_mounts_and_undamped_ones_are_refused():
    study = Study(presets.preset("boxer_4"), mounts.car("saloon"), 2000.0)
    with pytest.raises(ValueError, match="stands askew"):
        Cancel(study.on_mounts, study.source, 2000.0, 0, 2.0, 2000.0)
    bare = [replace(mount, damping=(0.0, 0.0, 0.0)) for mount in study.placed]
    with pytest.raises(ValueError, match="give mounts with dampers"):
        limit(lambda gain: on_mounts(study.body.rigid, bare, Skyhook((0, 0, 0), gain)))
    compact = Study(presets.preset("inline_4"), mounts.car("compact"), 2000.0)
    bare = replace(compact.on_mounts, placed=[replace(mount, damping=(0.0, 0.0, 0.0)) for mount in compact.placed])
    loop = Cancel(bare, compact.source, 2000.0, 0, 2.0, 2000.0)
    with pytest.raises(ValueError, match="active mount: unstable or undamped without it; give mounts with dampers"):
        loop.path.limit(loop.W)


@pytest.mark.slow
def test_the_command_shows_an_active_mount(tmp_path):
    found = CliRunner().invoke(nvh, ["inline_4", "--active", "--page", str(tmp_path)])
    assert found.exit_code == 0, found.output
    assert "feed-forward" in found.output and "stable up to" in found.output
    assert (tmp_path / "inline_4-compact.html").read_text(encoding="utf-8").count("<svg") == 8
