"""A bicycle ridden by hand: small motions at all speeds from two, another bicycle under way, falls, the page."""

import inspect
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from helpers.browser import visit
from helpers.live_views import until

from bicycle import Meijaard2007, named, on_tyres, play, whipple
from bicycle.model.kinematics import steer_axis
from bicycle.rides.rider_mass import carried, faster, lowest
from mbsd3d import Solution, Stepper, accelerations, simulate
from mbsd3d.extend import main
from mbsd3d.results.record import RunOptions
from mbsd3d.run.live_run import Playing

PERIOD = 1.0 / 60.0  # [s] from one frame to the next, as docs/how/stepping.md says

P = Meijaard2007()
ROUND = replace(P, tR=0.02, tF=0.03)
TYRES = {
    "cornering": 12.1, "camber": 1.1, "relaxation": 0.12, "longitudinal": 18.0, "trail": 0.015, "mu": 0.8,
    "stiffness": 1.5e5, "damping": 300.0,
}  # fmt: skip


def turning(p=ROUND, **more):
    """A bicycle in a leaned, steered and rolling state of the nonlinear model, after half a second."""
    start = {"lean": 0.1, "steer": 0.05, "lean_rate": 0.2, "steer_rate": -0.3}
    stepper = Stepper(whipple(p, 4.7, tyres=TYRES, **start, **more))
    stepper.advance(0.5)
    return stepper.state


def test_the_same_bicycle_goes_on_as_it_is():
    state = turning()
    same = carried(state, ROUND, replace(ROUND, IRyy=0.5 * ROUND.IRyy))
    assert np.allclose(same.q, state.q, rtol=0, atol=1e-13) and np.allclose(same.v, state.v, rtol=0, atol=1e-12)
    assert same.t == state.t and np.array_equal(same.z, state.z)


@pytest.mark.parametrize("change", [{"c": -0.03}, {"lam": 0.05}, {"c": 0.19, "lam": 0.6}])
def test_another_front_end_is_mounted_under_way(change):
    """Joints closed in place and speed, the same angles and rates, both wheels as deep in the ground, the same ride."""
    state, new = turning(), replace(ROUND, **change)
    begun, system = carried(state, ROUND, new), whipple(new, 4.7, tyres=TYRES)
    now, was = accelerations(system, begun), accelerations(whipple(ROUND, 4.7, tyres=TYRES), state)  # refuses gaps
    for joint in ("rear hub", "steer", "front hub"):
        assert now.angle(joint) == pytest.approx(was.angle(joint), abs=1e-12)
        assert now.rate(joint) == pytest.approx(was.rate(joint), abs=1e-9)
    front = {
        name: (run.position("front wheel")[0], run.rotation("front wheel")[0])
        for name, run in (("now", now), ("was", was))
    }
    assert lowest(*front["now"], new) == pytest.approx(lowest(*front["was"], ROUND), abs=1e-12)
    assert np.array_equal(now.position("frame"), was.position("frame"))
    turn = now.rotation("frame")[0] @ was.rotation("frame")[0].T  # of the pitch alone, and a small one
    angle = np.arccos((np.trace(turn) - 1.0) / 2.0)
    assert angle < 0.02 and abs(turn[2, 1]) < 1.0
    assert now.omega("frame")[0] == pytest.approx(turn @ was.omega("frame")[0], abs=1e-12)
    axis = now.rotation("frame")[0] @ steer_axis(new)[1]
    assert now.rotation("fork")[0] @ steer_axis(new)[1] == pytest.approx(axis, abs=1e-12)
    stepper = Stepper(system, begun)
    stepper.advance(begun.t + 0.2)
    assert stepper.solution().certificate.passed


def test_another_speed_keeps_the_proportions():
    state = turning()
    begun = faster(state, 6.0, 4.7)
    assert np.allclose(begun.v, state.v * 6.0 / 4.7, rtol=1e-15, atol=0) and np.array_equal(begun.q, state.q)
    with pytest.raises(ValueError, match=r"moves at 0.1 m/s, too slowly to be made faster; reset it"):
        faster(state, 6.0, 0.1)


def ridden(p=P, speed=5.0, assist=0.0, torque=2.0, **fittings):
    """A bicycle that is played, without a clock and a page."""
    made = Playing(play.Riding(p, speed, assist, torque, fittings), RunOptions(rtol=1e-6))
    made.watched = True
    return made


def seconds(made, duration):
    """Go on; the frames."""
    return [made.frame() for _ in range(round(duration / PERIOD))]


def curves(frames):
    """Name -> (frames,) of all panels."""
    names = [name for panel in play.PANELS for name in panel.lines]
    return dict(zip(names, np.array([frame.seen.curves for frame in frames]).T, strict=True))


def pushed(made, value=2.0, duration=0.2):
    """A short press of a key to the right."""
    made.hold("steer torque", value)
    seconds(made, duration)
    made.hold("steer torque", None)


def test_it_falls_without_assist_and_stays_up_with_it():
    bare, helped = ridden(speed=3.0), ridden(speed=3.0, assist=20.0)
    for made in (bare, helped):
        pushed(made)
    assert seconds(bare, 6.0)[-1].seen.over.startswith("fallen") and bare.over
    seen = curves(seconds(helped, 12.0))
    assert not helped.over and abs(seen["lean"][-1]) < 1.0 < np.abs(seen["lean"]).max()
    # the assist is k lean_rate
    rate = np.gradient(np.radians(seen["lean"]), PERIOD)
    assert seen["assist"][5:-5] == pytest.approx(20.0 * rate[5:-5], abs=0.02 * np.abs(seen["assist"]).max())


@pytest.mark.parametrize(("tilt", "over"), [(59.0, False), (61.0, True)])
def test_a_frame_that_is_tilted_by_sixty_degrees_has_fallen(monkeypatch, tilt, over):
    riding = play.Riding(P, 5.0, 0.0, 2.0, {})
    monkeypatch.setattr(riding, "linearised", lambda: None)
    values, upward = {control.name: control.value for control in riding.controls}, np.radians(90.0 - tilt)
    assert riding.seen(values, [0.1, 0.0, 0.0, upward, 5.0, 0.0]).over.startswith("fallen") is over


def test_a_torque_to_the_right_leans_it_to_the_left():
    made = ridden()
    made.hold("steer torque", 2.0)
    seen = curves(seconds(made, 0.3))
    assert seen["steer"][3] > 0.0 and seen["lean"][-1] < -0.5 and set(seen["rider"]) == {2.0}


def test_a_beginner_who_holds_the_key_stays_up():
    """With what `play` starts with; 4 s of the whole torque to the right lean and steer it to the left."""
    made = ridden(assist=inspect.signature(play.play).parameters["assist"].default)
    made.hold("steer torque", 2.0)
    seen = curves(seconds(made, 4.0))
    assert not made.over and -30.0 < seen["lean"][-1] < -5.0 and seen["steer"][-1] < -1.0
    assert "right to go left" in made.model.controls[0].hint


def test_the_speed_of_the_rear_hub_swings_without_energy():
    """It rises as the bicycle leans into a curve: the hub runs outside the centre of mass, which keeps its speed."""
    fall = simulate(whipple(P, 5.0, lean_rate=1.2, tyres=TYRES), 0.6, output=61, rtol=1e-8)
    whole, momentum = fall.energy().kinetic + fall.energy().potential, fall.momentum().linear
    assert (np.diff(whole) < 1e-5 * whole[0]).all() and whole[-1] > 0.995 * whole[0]  # tyres take, and never give
    hub, centre = (np.hypot(*v[:, :2].T) for v in (fall.velocity("rear wheel"), momentum / P.mass))
    assert np.ptp(hub) > 0.3 > 0.1 > np.ptp(centre)


def test_pedal_brake_and_speed():
    made = ridden(assist=20.0)
    made.hold("pedal", play.PEDAL_TORQUE_MAX)
    seconds(made, 0.5)  # in which the tyres come to their slip
    early, late = curves(seconds(made, 0.5))["speed"][[0, -1]]
    mass = P.mass + P.IRyy / P.rR**2 + P.IFyy / P.rF**2  # driven by the torque over the radius
    assert late - early == pytest.approx(play.PEDAL_TORQUE_MAX / P.rR / mass * 29.0 * PERIOD, rel=0.02)  # 1.3 % of slip
    made.hold("pedal", None)
    made.set("speed", 2.0)
    assert made.frame().seen.values["speed"] == pytest.approx(2.0, abs=0.06)  # the tyres still give back what they took
    made.hold("brake", play.BRAKE_TORQUE_MAX)
    seconds(made, 2.5)
    front = Solution.of(made.result()).rate("front hub")
    assert made.model.held < 0.02 and front.min() > -0.3  # it stops, but for what the brake yields: T/k = 3 mrad
    made.hold("pedal", 0.5 * play.PEDAL_TORQUE_MAX)
    assert curves(seconds(made, 0.3))["speed"].max() < 0.06  # held against the pedal
    made.hold("pedal", None)
    made.hold("brake", None)
    made.reset()
    assert made.frame().seen.values["speed"] == pytest.approx(2.0, abs=1e-3)  # that of the slider, not of the end


def test_it_becomes_another_bicycle_while_it_rides():
    made = ridden(ROUND, assist=10.0, tyres=TYRES)
    pushed(made)
    before = made.frame()
    for name, value in (("trail", 0.03), ("head angle", 80.0), ("wheel spin", 30.0), ("balance assist", 15.0)):
        made.set(name, value)
        after = made.frame()
        jump = np.abs(after.poses[1, :3] - before.poses[1, :3] - made.segments.velocities[6:9] * PERIOD).max()
        assert made.since == before.t and jump < 2e-3 and made.note == ""
        before = after
    p = made.built.system
    assert p.part("rear wheel").inertia[1, 1] == pytest.approx(0.3 * P.IRyy)
    axis = p.part("steer", "joints").axis
    assert np.degrees(np.arctan2(-axis[2], axis[0])) == pytest.approx(80.0) and made.model.now.c == 0.03
    assert not made.over and seconds(made, 1.0)[-1].t == pytest.approx(before.t + 1.0)


def test_growth_and_range_are_those_of_the_present_bicycle():
    made = ridden(ROUND, speed=4.0, assist=5.0, tyres=TYRES)
    made.set("trail", 0.05)
    assert np.isnan(made.frame().seen.curves[3])  # a thread looks for it
    made.model.thread.join()
    seen = made.frame()
    if np.isnan(seen.seen.curves[3]):  # that of the bicycle before came first
        made.model.thread.join()
        seen = made.frame()
    p = replace(ROUND, c=0.05)
    build = lambda p, speed: play.with_assist(whipple(p, speed, tyres=TYRES), 5.0)  # noqa: E731
    values = on_tyres.eigenvalues(build, p, [seen.seen.values["speed"]])[0]
    wanted = [values.real[np.abs(values.imag) > 1e-6].max(), values.real[np.abs(values.imag) <= 1e-6].max()]
    assert seen.seen.curves[3:5] == pytest.approx(wanted, rel=1e-6)
    limits = on_tyres.study(p, [1.5, 3.0, 4.0, 6.0, 9.0], build).limits
    assert seen.seen.good["speed"][-1] == pytest.approx([at.speed for at in limits], abs=1e-6)


@pytest.mark.slow
def test_growth_is_shown_of_tyres_that_are_damped_at_rest():
    """Their equations are not affine in the speed: found at some speeds, and looked up between."""
    made = ridden(speed=5.0, tyres=TYRES | {"standing_damping": 0.5})
    made.frame()
    made.model.thread.join()
    seen, build = made.frame().seen, made.model.straight
    for v in (0.7, 5.0):
        values = on_tyres.eigenvalues(lambda p, speed: made.model.system(p, 0.0, speed), P, [v])[0]
        wanted = [values.real[np.abs(values.imag) > 1e-6].max(), values.real[np.abs(values.imag) <= 1e-6].max()]
        assert build.growth(v) == pytest.approx(wanted, rel=1e-3, abs=1e-4)
    assert seen.curves[3:5] == pytest.approx(build.growth(seen.values["speed"]))
    (stable,) = seen.good["speed"]
    limits = on_tyres.study(P, np.linspace(3.0, 9.0, 4), lambda p, speed: made.model.system(p, 0.0, speed)).limits
    assert stable == pytest.approx([at.speed for at in limits], rel=1e-4)


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"speed": 0.1}, "speed = 0.1 is not within 0.5 ... 12 m/s"),
        ({"speed": float("nan")}, "play: speed: not finite"),
        ({"speed": 1e9}, "speed = 1e+09 is not within 0.5 ... 50 m/s"),
        ({"speed": "5"}, "play: speed: expected a number, got '5'"),
        ({"assist": -3.0}, "balance assist = -3 is not within 0 ... 50 N m s/rad"),
        ({"torque": 0.0}, "play: torque: 0.0 is not positive"),
        ({"head_stiffness": 2000.0}, "ridden with a rigid head tube; leave out head_stiffness (--head)"),
        ({"tyres": {"grip": 1.0}}, "tyres: grip unknown"),
    ],
)
def test_what_cannot_be_ridden_is_refused(given, text):
    with pytest.raises(ValueError) as error:
        play.play(P, **given)
    assert text in str(error.value)


def test_the_command_refuses_in_one_line():
    for arguments, text in (
        (["Meijard2007"], "there is no bicycle 'Meijard2007'; did you mean Meijaard2007?"),
        (["--speed", "0.1"], "speed = 0.1 is not within 0.5 ... 12 m/s"),
        (["--head", "2000", "2"], "leave out head_stiffness (--head)"),
    ):
        done = CliRunner().invoke(main, ["bicycle", "play", *arguments])
        assert done.exit_code == 2 and text in done.output and "Traceback" not in done.output


def test_a_machine_is_ridden_on_its_own_tyres():
    made = ridden(named("Sharp1971"), speed=20.0, torque=20.0)
    assert abs(curves(seconds(made, 0.5))["lean"]).max() < 1e-6 and made.built.system.part("front tyre", "forces")


PAD = """() => {
    const buttons = Array.from({length: 17}, (_, k) => ({value: k === 7 ? 0.55 : 0}));
    window.pad = {id: "pad", connected: true, mapping: "standard", axes: [-1, 0, 0, 0], buttons};
    navigator.getGamepads = () => [window.pad];
}"""


@pytest.mark.slow
def test_a_gamepad_steers_pedals_and_brakes(chromium):
    with play.play(P, dark=False) as made, visit(chromium, made.url, width=480) as seen:
        seen.wait("document.documentElement.dataset.ready === 'yes'")
        seen.page.keyboard.press("Space")  # it pauses: only what is asked for counts
        seen.run(PAD)  # the stick to the left, the trigger of the pedal half way
        assert until(
            lambda: made.values["pedal"] == 0.5 * play.PEDAL_TORQUE_MAX and made.values["steer torque"] == -2.0
        )
        seen.run("window.pad.axes[0] = window.pad.buttons[7].value = 0")
        assert until(lambda: made.values["pedal"] == made.values["steer torque"] == 0.0)
        seen.run("window.pad.buttons[6].value = 1")
        assert until(lambda: made.values["brake"] == play.BRAKE_TORQUE_MAX)
        assert seen.complaints == []


@pytest.mark.slow
@pytest.mark.parametrize("assist", [0.0, 20.0])
def test_a_browser_rides_it(chromium, assist):
    """Keys change the steer; it stays up with assist, falls without; the page survives a reload."""
    with play.play(P, speed=3.0, assist=assist, dark=False) as made, visit(chromium, made.url, width=480) as seen:
        ready = "document.documentElement.dataset.ready === 'yes'"
        seen.wait(ready)
        seen.wait("mbsd3d.last !== null && mbsd3d.last[0] > 0.2")
        assert abs(seen.run("mbsd3d.last[4]")) < 1e-6  # steer
        seen.page.keyboard.down("ArrowRight")
        # degrees of lean, and of steer: to the right first, whatever it does later, which a slow page may miss
        assert until(lambda: any(abs(row[1]) > 0.5 for row in list(made._history)))
        assert max(row[2] for row in made._history) > 0.3
        seen.page.keyboard.up("ArrowRight")
        if not assist:
            seen.page.get_by_text("fallen: reset (R) stands it up again").wait_for()
            seen.page.keyboard.press("r")
            seen.page.get_by_text("fallen").wait_for(state="hidden")
            return
        seen.page.reload()
        seen.wait(ready)
        before = made.t
        seen.page.get_by_role("slider", name="trail").fill("0.04")
        seen.wait("mbsd3d.state.shapes['/bodies/2/wire0'] !== undefined || Object.keys(mbsd3d.state.shapes).length > 0")
        seen.wait("t => mbsd3d.last[0] > t + 5", before)
        assert abs(seen.run("mbsd3d.last[3]")) < 20.0 and seen.complaints == []
        assert seen.run("mbsd3d.state.good.speed.length") >= 1
