"""A ride keeps up with the clock, on an idle machine (``make timing``): key to pose, frames, a bicycle made anew."""

import time

import numpy as np
import pytest
from helpers.browser import launch, visit
from helpers.models import crane

from bicycle import Meijaard2007, play
from mbsd3d.results.record import RunOptions
from mbsd3d.run.live_run import Playing

PERIOD = 1.0 / 60.0  # [s] from one frame to the next, as docs/how/stepping.md says

pytestmark = pytest.mark.timing

READY = "document.documentElement.dataset.ready === 'yes'"
# Times [ms] from a key going down until poses that know it are on the page; `place` of its input in a frame. When they
# are painted is up to the graphics card, which a test has none of.
PRESSES = """async ([place, count]) => {
  const until = (done) => new Promise((ready) => {
    const look = () => (done() ? ready(performance.now()) : setTimeout(look, 0));
    look();
  });
  const key = (kind, i) => window.dispatchEvent(new KeyboardEvent(kind, {key: i % 2 ? "j" : "l"}));
  const rest = mbsd3d.last[place], found = [];
  for (let i = 0; i < count; i++) {
    await new Promise((ready) => setTimeout(ready, 100 + (37 * i) % 50)); // at any phase of the frames
    const began = performance.now();
    key("keydown", i);
    found.push((await until(() => mbsd3d.last[place] !== rest)) - began);
    key("keyup", i);
    await until(() => mbsd3d.last[place] === rest);
  }
  return found;
}"""


def test_a_key_moves_the_poses_within_60_ms():
    with crane().play({"push": (-6.0, 6.0)}) as ride, launch() as browser:
        with visit(browser, ride.url, width=480, height=320) as seen:
            seen.wait(READY)
            seen.page.wait_for_timeout(1000)
            found = np.array(seen.run(PRESSES, [3 + 2, 40]))
            assert np.median(found) < 30.0 and np.quantile(found, 0.9) <= 60.0, found


def test_a_bicycle_keeps_up_with_the_clock():
    made = Playing(play.Riding(Meijaard2007(), 5.0, 10.0, 2.0, {}), RunOptions(rtol=1e-6))
    made.watched = True
    made.start(lambda frame: None)
    time.sleep(1.0)
    late, t, began = made.late, made.segments.t, time.perf_counter()
    time.sleep(5.0)
    passed = time.perf_counter() - began
    assert made.segments.t - t == pytest.approx(passed, rel=0.01) and made.late - late <= 3  # of 300
    made.stop()


def test_another_bicycle_is_there_within_a_frame():
    made = Playing(play.Riding(Meijaard2007(), 5.0, 10.0, 2.0, {}), RunOptions(rtol=1e-6))
    made.model.linearised = lambda: None  # which has a thread of its own
    made.watched, spent = True, []
    for trail in np.linspace(0.05, 0.1, 40):
        made.set("trail", float(trail))
        began = time.thread_time()
        made.frame()
        spent.append(time.thread_time() - began)
    assert np.median(spent) < 0.6 * PERIOD  # 6 ms of processor time
