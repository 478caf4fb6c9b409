"""Mechanisms that the reader of a page moves himself: motions are those of Python with the same forces."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.browser import visit
from helpers.node import run_in_node

from mbsd3d import Body, Sine, System, Torque, simulate
from mbsd3d.extend import Ride, discover
from mbsd3d.view.explore.ridden import ride_data

# Pushed one way, let go, pushed the other way a little: frames of 1/60 s
RIDE = """
found = given.map((what) => {
  const ridden = makeRidden(what), poses = [];
  for (const [frame, factor] of [[30, 0.7], [60, 0], [90, -0.4]]) {
    while (ridden.seen.frames < frame) ridden.go(frame, factor, 5);
    poses.push([...ridden.seen.r, ...ridden.seen.e]);
  }
  return {poses, fallen: ridden.fallen};
});
"""


@pytest.mark.parametrize("name", ["countersteer", "no_hands"])
def test_a_ride_is_that_of_python(name):
    demo = discover()[name]
    ride = demo.call(demo.ride, demo.parameters)
    data = ride_data(ride, ride.system, np.array([0.3, -0.2, 0.1]))
    (found,) = run_in_node(("solver.js", "ridden.js"), RIDE, [data])
    state, n = None, len(ride.system.bodies)
    for k, factor in enumerate((0.7, 0.0, -0.4)):
        forces = [replace(x, torque=tuple(factor * m for m in x.torque)) for x in ride.system.forces]
        run = simulate(replace(ride.system, forces=forces), 0.5 * (k + 1), state=state, rtol=1e-11)
        state = run.state(-1)
        poses = np.array(found["poses"][k])
        places = np.array([run.position(body)[-1] for body in run.system.bodies]) - (0.3, -0.2, 0.1)
        # to 1e-6 of the wheelbase of about a metre, and radians
        np.testing.assert_allclose(poses[: 3 * n].reshape(n, 3), places, rtol=0.0, atol=1e-6)
        turns = poses[3 * (n + 1) :].reshape(n + 1, 4)[:n]
        same = [abs(turn @ run.orientation(x)[-1]) for turn, x in zip(turns, run.system.bodies, strict=True)]
        assert min(same) > 1 - 1e-12
    assert np.abs(run.angle("steer")).max() > 0.01 and not found["fallen"]


def test_what_cannot_be_ridden_is_refused():
    stone, other = Body("stone", 1.0, (1, 1, 1)), Body("other", 1.0, (1, 1, 1))
    with pytest.raises(ValueError, match=r"ride: its bodies \['other'\] are not those of the film, \['stone'\]"):
        ride_data(Ride(System([other]), "", "other"), System([stone]), np.zeros(3))
    shaken = System([stone], forces=[Torque(stone, (0.0, 0.0, Sine(1.0, 2.0)))])
    with pytest.raises(ValueError, match="ride: a force changes with the time"):
        ride_data(Ride(shaken, "", "stone"), System([stone]), np.zeros(3))


@pytest.mark.slow
@pytest.mark.parametrize("width", [900, 360])
def test_a_page_is_ridden_by_keys_and_buttons(chromium, tmp_path, width):
    demo = discover()["countersteer"]
    show = demo.run().views[demo.name]
    show.solution.animate(tmp_path / "ride", **show.options)
    with visit(chromium, tmp_path / "ride.html", width=width, height=700) as page:
        page.wait("document.documentElement.dataset.ready === 'yes'")
        page.page.locator("#ride").press("Enter")
        assert not page.page.locator("#scrub").is_visible() and page.page.locator("#hint").is_visible()
        place = "Array.from(mbsd3d.rider.ridden.seen.r.slice(3, 5))"
        page.page.keyboard.down("ArrowRight")
        page.wait(f"{place}[0] > 3")
        page.page.keyboard.up("ArrowRight")
        page.page.locator("#left").hover()
        page.page.mouse.down()
        page.wait("mbsd3d.rider.ridden.fallen")
        page.page.mouse.up()
        assert page.page.locator("#hint").text_content().startswith("It fell after")
        page.page.keyboard.press("Escape")
        page.wait("!mbsd3d.rider.riding")
        assert page.page.locator("#scrub").is_visible() and page.run("document.body.scrollWidth") <= width
        assert page.complaints == [] and page.run("mbsd3d.time") == 0.0
