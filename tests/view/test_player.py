"""The controls of a page in a real browser: each does its work, by mouse and by key, in any window."""

import numpy as np
import pytest
from helpers.pages import COUNT, END, HINGE, SETTLED, covered, differing, opened, scene, seek
from helpers.printed_numbers import number

from mbsd3d.view.page.html import asset

pytestmark = pytest.mark.slow


def test_play_goes_at_the_chosen_speed_and_pause_holds(page):
    page.page.locator("#speed").select_option("0.1")
    page.run("""() => { window.log = []; const note = (now) => {
      log.push([now / 1000, mbsd3d.time]); if (log.length < 10000) requestAnimationFrame(note); };
      requestAnimationFrame(note); }""")
    page.page.locator("#play").click()
    page.wait("mbsd3d.time > 0.3")  # so long that a few slow pictures do not matter
    page.page.keyboard.press("Space")  # pressed on the button that has the focus
    page.wait("!mbsd3d.playing")
    log = np.array(page.run("log"))
    log = log[(log[:, 1] > 0.0) & (log[:, 1] < log[-1, 1])]
    real, model = np.ptp(log, axis=0)
    # page and log are called once a picture, in any order: they differ by at most the longest picture
    assert abs(model - 0.1 * real) <= 0.1 * np.diff(log[:, 0]).max() + 1e-9 and real > 0.5
    held = page.run("mbsd3d.time")
    page.run(SETTLED)
    first = scene(page)
    page.page.wait_for_timeout(300)
    assert page.run("mbsd3d.time") == held and differing(first, scene(page)) == 0
    assert page.page.locator("#play").get_attribute("aria-label") == "play"


def test_keys(page):
    step, press = END / (COUNT - 1), page.page.keyboard.press
    time = lambda: page.run("mbsd3d.time")  # noqa: E731
    page.page.locator("#scene").click(position={"x": 200, "y": 200})
    first, camera = scene(page), page.run("[...__viserMutable.camera.matrixWorld.elements]")
    press("ArrowRight"), press("ArrowRight"), press("ArrowRight"), press("ArrowLeft")
    assert time() == pytest.approx(2 * step)
    press("End")
    assert time() == pytest.approx(END) and not page.run("mbsd3d.playing")
    press("ArrowRight")
    assert time() == pytest.approx(END)
    press("Home")
    assert time() == 0.0
    for key in "wasdqe":
        page.page.keyboard.press(key, delay=60)
    page.run(SETTLED)
    assert page.run("[...__viserMutable.camera.matrixWorld.elements]") == camera  # the client's own keys are off
    assert differing(first, scene(page)) == 0
    press("Space")
    page.wait("mbsd3d.playing && mbsd3d.time > 0")
    press("Space")
    assert not page.run("mbsd3d.playing") and time() > 0.0
    page.page.locator("#forth").click(), page.page.locator("#back").click()
    assert time() / step == pytest.approx(round(time() / step))
    page.run(SETTLED)
    assert page.page.locator("#time").text_content() == f"t = {time():.3f} s"


def test_the_slider_scrubs(page):
    box = page.page.locator("#scrub").bounding_box()
    page.page.mouse.click(box["x"] + 0.25 * box["width"], box["y"] + 0.5 * box["height"])
    page.run(SETTLED)
    # the thumb keeps half its width (8 px) from the ends
    assert page.run("mbsd3d.time") == pytest.approx(0.25 * END, abs=END * 10 / box["width"])
    assert page.page.locator("#time").text_content() == f"t = {page.run('mbsd3d.time'):.3f} s"


def test_the_camera_goes_along_with_a_body(page):
    """The eye is shifted by what the body has moved, and stays as it was turned and zoomed."""
    eye = "() => __viserMutable.camera.matrixWorld.elements.slice()"
    choice = page.page.locator("#follow")
    place = choice.locator("option").last.get_attribute("value")
    body = f"() => __viserMutable.nodeRefFromName['/bodies/{place}'].matrixWorld.elements.slice()"
    page.page.locator("#switches summary").click()
    choice.select_option(place)
    page.page.locator("#switches summary").click()
    poses = []
    for t in (0.0, 0.4 * END, 0.9 * END):
        seek(page, t)
        poses.append((page.run(eye), page.run(body)))
    eyes, bodies = np.swapaxes(np.array(poses), 0, 1)
    moved = np.diff(bodies[:, 12:15], axis=0)
    assert np.linalg.norm(moved, axis=1).min() > 0.05
    assert np.abs(np.diff(eyes[:, 12:15], axis=0) - moved).max() < 1e-4  # the poses on a page are rounded to 1e-5
    assert np.abs(np.ptp(eyes[:, :12], axis=0)).max() < 1e-6
    choice.evaluate("e => { e.value = -1; e.dispatchEvent(new Event('change')); }")
    seek(page, 0.0)
    assert np.abs(np.array(page.run(eye)) - eyes[2]).max() < 1e-6  # it stays where it is
    page.page.locator("#camera").click()


def test_a_page_goes_along_with_a_body_from_the_start(chromium, motion, folder):
    """Seen from near; the view that is reset is where the body is now."""
    eye = "() => __viserMutable.camera.matrixWorld.elements.slice()"
    view = motion.animate(frames=COUNT, follow=motion.system.bodies[-1])
    with opened(chromium, view.save(folder / "along"), width=800, height=460) as seen:
        place = seen.page.locator("#follow").input_value()
        assert int(place) == len(motion.system.bodies) - 1
        body = f"() => __viserMutable.nodeRefFromName['/bodies/{place}'].matrixWorld.elements.slice()"
        poses = []
        for t in (0.0, 0.9 * END):
            seek(seen, t)
            poses.append((seen.run(eye), seen.run(body)))
        eyes, bodies = np.swapaxes(np.array(poses), 0, 1)[..., 12:15]
        assert np.linalg.norm(bodies[1] - bodies[0]) > 0.05
        assert np.abs(eyes[1] - eyes[0] - (bodies[1] - bodies[0])).max() < 1e-4  # poses are rounded to 1e-5
        seen.page.locator("#camera").click()
        seen.run(SETTLED)
        assert np.abs(np.array(seen.run(eye))[12:15] - eyes[1]).max() < 1e-4


def test_loop(page):
    page.page.locator("#speed").select_option("0.5")
    loop = page.page.locator("#loop")
    page.run(f"mbsd3d.seek({0.9 * END})")
    page.page.locator("#play").click()
    page.wait(f"mbsd3d.time < {0.5 * END}")
    assert page.run("mbsd3d.playing")
    loop.uncheck()
    page.run(f"mbsd3d.seek({0.9 * END})")
    page.wait("!mbsd3d.playing")
    assert page.run("mbsd3d.time") == pytest.approx(END)
    page.page.locator("#speed").select_option("0.1")
    page.page.locator("#play").click()  # from the start again
    page.wait(f"mbsd3d.playing && mbsd3d.time > 0 && mbsd3d.time < {END}")
    page.page.locator("#play").click()
    loop.check()


def test_every_switch_changes_the_picture_and_back(page):
    page.page.set_viewport_size({"width": 800, "height": 340})  # small pictures are drawn quickly
    legend = page.page.locator("#legend")
    legend.evaluate("e => { e.style.visibility = 'hidden'; }")  # the scene itself has to change
    seek(page, 0.2)
    boxes = page.page.locator("#switches input")
    page.page.locator("#switches summary").click()
    page.page.locator("#switches label", has_text="see through").locator("input").check()
    page.run(SETTLED)
    before, first = [boxes.nth(i).is_checked() for i in range(boxes.count())], scene(page)
    assert len(before) == 14
    for i, on in enumerate(before):
        boxes.nth(i).set_checked(not on)
        page.run(SETTLED)
        assert differing(first, scene(page)) > 20, page.page.locator("#switches label").nth(i).text_content()
        boxes.nth(i).set_checked(on)
    page.run(SETTLED)
    assert differing(first, scene(page)) == 0
    for i in range(len(before)):
        boxes.nth(i).set_checked(False)
    page.run(SETTLED)
    assert covered(page.pixels("#root"))[0] < 0.01  # the measure of "not blank" says no to paper alone
    for i, on in enumerate(before):
        boxes.nth(i).set_checked(on and i > 0)
    legend.evaluate("e => { e.style.visibility = ''; }")
    page.run(SETTLED)


def cursor(seen):
    """Place of the cursor of the first curve [px from its left]: the one line that is ink from top to bottom."""
    ink = 255.0 - seen.pixels("#curves canvas.plot").max(axis=2)
    sums = ink.sum(axis=0)
    k = int(sums.argmax())
    near = np.arange(k - 1, k + 2)
    assert sums[near].sum() > 0.6 * 200 * len(ink)  # most of the height, in a colour nearly black
    return float((near * sums[near]).sum() / sums[near].sum())


def test_curves_follow_the_time_and_scrub_it(page, motion):
    columns = {}
    for k in (0, 15, 44, COUNT - 1):
        seek(page, float(motion.t[k]))
        columns[k] = cursor(page)
        shown = page.page.locator("#curves figure").first.locator("output").first.text_content()
        assert float(shown.replace("\u2212", "-")) == pytest.approx(motion.angle(HINGE)[k], rel=5e-4, abs=1e-9)
    width = columns[COUNT - 1] - columns[0]
    for k, column in columns.items():
        assert abs(column - columns[0] - width * motion.t[k] / END) <= 1.0  # one pixel
    box = page.page.locator("#curves canvas.plot").nth(1).bounding_box()
    page.page.mouse.click(box["x"] + columns[44] + 0.5, box["y"] + 40)
    page.run(SETTLED)
    assert page.run("mbsd3d.time") == pytest.approx(motion.t[44], abs=1.5 * END / width)
    page.page.mouse.down()
    page.page.mouse.move(box["x"] + columns[15] + 0.5, box["y"] + 40, steps=3)
    page.page.mouse.up()
    page.run(SETTLED)
    assert page.run("mbsd3d.time") == pytest.approx(motion.t[15], abs=1.5 * END / width)
    assert abs(cursor(page) - columns[15]) <= 1
    page.page.locator("#show-curves").uncheck()
    assert not page.page.locator("#curves").is_visible()
    page.page.locator("#show-curves").check()


def test_dragging_turns_the_view_and_reset_brings_it_back(page):
    first = scene(page)
    box = page.page.locator("#scene").bounding_box()
    x, y = box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"]
    for act in (lambda: page.page.mouse.move(x + 80, y + 40, steps=4), lambda: page.page.mouse.wheel(0, -300)):
        page.page.mouse.move(x, y), page.page.mouse.down()
        act()
        page.page.mouse.up()
        page.page.wait_for_timeout(400)  # the view glides to rest
        assert differing(first, scene(page)) > 0.05 * first[..., 0].size
        page.page.keyboard.press("c")
        page.run(SETTLED)
        page.page.wait_for_timeout(100)
        assert differing(first, scene(page)) == 0


@pytest.mark.parametrize(
    "width, height",
    [
        (1280, 720),
        pytest.param(560, 700, marks=pytest.mark.slow),
        (360, 640),
        pytest.param(640, 360, marks=pytest.mark.slow),
    ],
)
def test_every_control_can_be_reached_in_any_window(page, width, height):
    page.page.set_viewport_size({"width": width, "height": height})
    page.run(SETTLED)
    hidden = page.run("""() => [...document.querySelectorAll(
        "footer button, #scrub, #speed, #loop, #show-curves, #switches summary, #time")].filter((control) => {
      const box = control.getBoundingClientRect();
      const top = document.elementFromPoint(box.x + box.width / 2, box.y + box.height / 2);
      return !(top && (control.contains(top) || top.contains(control))) || box.right > innerWidth + 1;
    }).map((control) => control.id || control.tagName)""")
    assert hidden == []
    assert page.run("document.documentElement.scrollWidth <= innerWidth && scrollY === 0")
    box = page.page.locator("#scene").bounding_box()
    assert box["width"] >= 0.4 * width and box["height"] >= 0.25 * height
    canvas = page.page.locator("#root canvas").first.bounding_box()
    assert abs(canvas["width"] - box["width"]) <= 1 and abs(canvas["height"] - box["height"]) <= 1
    assert covered(scene(page))[0] > 0.02


def test_the_divider_gives_the_curves_more_room_by_key_and_mouse(page):
    divider, curves = page.page.locator("#divider"), page.page.locator("#curves")
    widths = [curves.bounding_box()["width"]]
    divider.focus()
    page.page.keyboard.press("ArrowLeft")
    widths.append(curves.bounding_box()["width"])
    box = divider.bounding_box()
    page.page.mouse.move(box["x"] + 3, 200), page.page.mouse.down()
    page.page.mouse.move(box["x"] - 77, 200, steps=3), page.page.mouse.up()
    page.run(SETTLED)
    widths.append(curves.bounding_box()["width"])
    assert widths[1] > widths[0] + 10 and widths[2] == pytest.approx(widths[1] + 80, abs=8)  # half the divider
    scene_box, canvas = (page.page.locator(name).first.bounding_box() for name in ("#scene", "#root canvas"))
    assert abs(canvas["width"] - scene_box["width"]) <= 1 and page.run("mbsd3d.time") == 0.0
    page.run("document.getElementById('page').style.removeProperty('--share')")


def test_every_axis_has_two_values_at_least(page):
    """One value alone, such as 0, tells no scale."""
    ticks = "(() => {" + asset("curves.js") + "return [[-15, 14.9, 1], [-0.9, 1.9, 2], [3, 71, 3], [0.11, 0.19, 3]]"
    for found in page.run(ticks + ".map((x) => ticks(...x).found)})()"):
        assert 2 <= len(found) <= 8


def test_values_beside_an_axis_are_told_apart_and_have_room(page):
    """Far from zero, tiny and huge: read back, each is its value to a hundredth of the step between two of them."""
    ranges = [[882900, 882950], [-5e12, 1.2e13], [-2.6e-5, 4e-5], [200000.12, 200000.19], [-1e-9, 3e-9], [0.4, 7.3]]
    pick = "[low, high]) => { const {found, step} = ticks(low, high, 4), texts = found.map((v) => tickText(v, step));"
    take = "return [found, step, texts, makeAxes(400, 120, low, high, 0, 1).left]"
    found = page.run("(() => {" + asset("curves.js") + f"return {ranges}.map(({pick} {take} }}) }})()")
    for values, step, texts, left in found:
        read = [number(text) for text in texts]
        assert np.allclose(read, values, rtol=0.0, atol=0.01 * step), texts
        assert max(map(len, texts)) * 5.0 < left, texts  # a digit of 11 pixels is more than 5 wide


def test_values_of_a_legend_end_without_zeros(page):
    values = [1e-3, -2.5e-4, 1e7, 12.5, 0.0, -1.2346e-7]
    found = page.run("(() => {" + asset("curves.js") + f"return {values}.map((x) => valueText(x)) }})()")
    assert found == ["0.001", "−2.5 · 10⁻⁴", "10⁷", "12.5", "0", "−1.235 · 10⁻⁷"]
