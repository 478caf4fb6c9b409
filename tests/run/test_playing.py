"""A model that is played: slices against one run, keys over sliders, pieces, ends, refusals; no clock, no browser."""

import threading

import numpy as np
import pytest
from helpers.models import crane

from mbsd3d import GROUND, AngleDriver, Body, Input, Revolute, Solution, Stepper, System, Torque, measures
from mbsd3d.errors import MbsError
from mbsd3d.extend import Built, Control, Panel, Seen
from mbsd3d.results.record import RunOptions
from mbsd3d.run import live_run as module
from mbsd3d.run.live_model import plain
from mbsd3d.run.live_run import Playing

PERIOD = 1.0 / 60.0  # [s] from one frame to the next, as docs/how/stepping.md says


def playing(system=None, ranges=None, **options):
    """The crane, watched and at its start."""
    system = system or crane()
    made = Playing(plain(system, system.state(), ranges or {"push": (-2.0, 3.0)}, **options), RunOptions(rtol=1e-6))
    made.watched = True
    return made


def frames(made, count):
    """Some frames; the last one."""
    for _ in range(count):
        found = made.frame()
    return found


def test_a_ride_is_the_stepper_with_the_same_inputs():
    made, stepper = playing(), Stepper(crane(), rtol=1e-6)
    for k in range(30):
        if k == 7:
            made.set("push", 2.0)
            stepper.set("push", 2.0)
        if k == 15:
            made.hold("push", -2.0)
            stepper.set("push", -2.0)
        if k == 22:
            made.hold("push", None)
            stepper.set("push", 2.0)
        frame = made.frame()
        stepper.advance(stepper.t + PERIOD)
    q = stepper.q.reshape(-1, 7)
    assert frame.t == stepper.t and np.array_equal(frame.poses[:, :3], q[:, :3])
    assert np.allclose(frame.poses[:, 3:], q[:, 3:], rtol=0, atol=1e-15)
    ride = Solution.of(made.result())
    assert ride.t.size == 31 and ride.certificate.passed
    assert np.array_equal(ride.angle("pin"), stepper.solution().angle("pin"))
    # frame by frame: the value that held in the slice before it
    assert list(frame.seen.curves) == [*made.segments.measured, 2.0]
    assert ride.at(0.123).q == pytest.approx(stepper.solution().at(0.123).q, abs=1e-12)


def test_nothing_moves_before_somebody_looks_nor_while_it_is_paused():
    made = playing()
    made.watched = False
    assert frames(made, 3).t == 0.0
    made.watch(True)
    assert frames(made, 3).t == pytest.approx(3 * PERIOD)
    made.run(False)
    assert frames(made, 2).t == pytest.approx(3 * PERIOD)
    made.run(True)
    made.slow(0.1)
    assert frames(made, 5).t == pytest.approx(3.5 * PERIOD)


def test_reset_goes_back_and_keeps_the_sliders():
    made = playing()
    start = made.frame().poses
    made.set("push", 3.0)
    frames(made, 20)
    made.reset()
    assert made.segments.t == 0.0 and made.now == {"push": 3.0} and made.result().t.size == 0
    again = made.frame()
    assert again.t == PERIOD and not np.array_equal(again.poses, start)  # another push from the first slice on


def test_a_long_ride_is_kept_in_pieces(monkeypatch):
    whole = frames(playing(), 50)
    monkeypatch.setattr(module, "LONGEST", 20)
    made = playing()
    last = frames(made, 50)
    assert made.since == pytest.approx(40 * PERIOD) and made.result().t[0] == made.since
    # a new piece begins with another step: both are the motion within some times the tolerance of the run
    assert last.t == whole.t and np.allclose(last.poses, whole.poses, rtol=0, atol=1e-5)


def test_what_fails_ends_the_ride_until_it_is_reset():
    arm = Body("arm", 1.0, (0.1, 0.1, 0.1), com=(0.2, 0.1, 0.3))
    hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=(0.3, 1, 0.2), name="hinge")
    system = System([arm], [hinge], [Torque(arm, (0.0, Input("blow", 0.0), 0.0))])
    made = playing(system, {"blow": (0.0, 1e60)})
    made.frame()
    made.set("blow", 1e60)
    frame = frames(made, 3)
    assert made.over and not made.moving and made.note and frame.t <= 3 * PERIOD
    made.run(True)
    assert not made.running
    made.set("blow", 0.0)
    made.reset()
    assert frames(made, 2).t == pytest.approx(2 * PERIOD) and not made.over and made.note == ""


def test_a_slice_without_end_is_left_when_it_is_stopped():
    made = playing()
    made.start(lambda frame: None)
    made.patience.over.set()  # as if it were stopped in the middle of a slice
    made.do(made.set, "push", 1.0).result(10.0)
    threads = threading.active_count()
    made.stop()
    assert threading.active_count() == threads - 1 and made.do(made.result).result(1.0).t.size >= 1


class Stick:
    """A pendulum whose length is a control that makes it anew, and whose angle a control follows."""

    controls = (Control("length", 0.2, 2.0, 1.0, "m", builds=True), Control("angle", -3.0, 3.0, 0.5, builds=True))
    panels = (Panel("angle", "rad", ("angle",)),)

    def built(self, values, state):
        length = values["length"]
        if length > 1.5:
            raise MbsError("too long")
        stick = Body("stick", 1.0, (0.1, 0.1, 0.1), com=(0, 0, -length))
        hinge = Revolute(GROUND, stick, at=(0, 0, 0), axis=(0, 1, 0), name="hinge")
        system = System([stick], [hinge])
        rate = 0.0 if state is None else state.v[4]
        begun = system.assemble(
            angles={hinge: values["angle"]}, rates={hinge: rate}, t=0.0 if state is None else state.t
        )
        return Built(system, begun, [measures.angle(hinge)])

    def inputs(self, values, measured):
        return {}

    def seen(self, values, measured):
        over = "over the top" if abs(measured[0]) > 2.9 else ""
        return Seen(measured, {"angle": float(measured[0])}, {"length": [(0.2, 1.5)]}, over)


def test_a_model_made_anew_goes_on_from_where_it_is():
    made = Playing(Stick(), RunOptions())
    made.watched = True
    before, rate = frames(made, 20), made.segments.velocities[4]
    made.set("length", 0.5)
    after, angle = made.frame(), before.seen.curves[0]
    assert made.since == before.t and after.t == pytest.approx(before.t + PERIOD)
    alpha = -9.81 * 0.5 * np.sin(angle) / (0.1 + 0.5**2)  # of the shorter one, which keeps angle and rate
    expected = angle + rate * PERIOD + 0.5 * alpha * PERIOD**2
    assert after.seen.curves[0] == pytest.approx(expected, abs=1e-4)  # the next term of the series is 2e-5
    assert rate < -1.0 and made.now["angle"] == after.seen.curves[0]
    made.set("length", 1.9)  # refused: it stays as it was
    system = made.built.system
    frames(made, 2)
    assert made.note == "too long" and made.now["length"] == 0.5 and made.built.system is system and made.running
    made.set("angle", 2.95)
    assert frames(made, 1).seen.over and made.over and made.note == "over the top"


@pytest.mark.parametrize(
    ("ranges", "text"),
    [
        ({"psh": (-1, 1)}, "'psh' is not an input of this system, did you mean 'push'? There are 'push', 'twist'"),
        ({"push": (1, -1)}, "input 'push': the range 1 ... -1 is empty or the wrong way round; give low < high"),
        ({"push": (1, 1)}, "input 'push': the range 1 ... 1 is empty"),
        ({"push": (1, 2)}, "input 'push' starts with 0.4, outside 1 ... 2; give a range that holds it"),
        ({"push": 3}, "input 'push': 3 is not a sequence; give a range (low, high)"),
        ({"push": (1, 2, 3)}, "input 'push': (1, 2, 3) is not a range; give (low, high)"),
        ({"push": (0, float("nan"))}, "input 'push': not finite (nan); give a finite number"),
        ([("push", 1)], "inputs = [('push', 1)]; give a dict"),
    ],
)
def test_ranges_that_make_no_sense_are_refused(ranges, text):
    system = crane()
    with pytest.raises(ValueError) as error:
        plain(system, system.state(), ranges)
    assert text in str(error.value)


def test_an_input_that_moves_a_driver_has_no_slider():
    arm = Body("arm", 1.0, (0.1, 0.1, 0.1))
    hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=(0, 1, 0))
    system = System([arm], [hinge, AngleDriver(hinge, Input("angle"), name="motor")])
    with pytest.raises(ValueError, match="input 'angle' prescribes the motion of driver 'motor'"):
        plain(system, system.state(), {"angle": (-1, 1)})


def test_curves_are_grouped_by_unit():
    system = crane()
    pin, rail = system.part("pin", "joints"), system.part("rail", "joints")
    wanted = [measures.rate(pin), measures.slide(rail), measures.angle(pin)]
    made = plain(system, system.state(), {}, wanted)
    assert [panel.unit for panel in made.panels] == ["rad/s", "m", "rad"]
    assert [x.label for x in made.measures] == ["rate of pin", "slide of rail", "angle of pin"]
    usual = plain(system, system.state(), {"push": (0, 1)})
    assert [panel.lines for panel in usual.panels] == [("angle of pin",), ("slide of rail",), ("push",)]
    arms = [Body(f"arm {k}", 1.0, (1, 1, 1)) for k in (1, 2)]
    unnamed = System(arms, [Revolute(GROUND, arm, at=(0, 0, 0), axis=(0, 1, 0)) for arm in arms])
    assert plain(unnamed, unnamed.state()).panels[0].lines == ("angle of Revolute 1", "angle of Revolute 2")
    free = System([Body("stone", 1.0, (1, 1, 1))])
    assert plain(free, free.state()).panels[0].lines == ("x of stone", "y of stone", "z of stone")
    with pytest.raises(ValueError, match="is not in the system"):
        plain(free, free.state(), {}, wanted)
    with pytest.raises(ValueError, match="curves: 3 is not a measure"):
        plain(free, free.state(), {}, [3])
