"""Pages in a real browser, without a network: what is seen, where it is seen, and that every control does its work."""

import time
from contextlib import contextmanager

import numpy as np
import pytest
from browser import visit
from moving import ARM, BEAD, CRANK, PINK, TAIL, mechanism

from mbsd3d import GROUND, Body, Spherical, System, simulate
from mbsd3d.rotations import matrix
from mbsd3d.view.content import LENGTH, TURN
from mbsd3d.view.drawing import bounds, draw_system, frame_camera
from mbsd3d.view.motion import frames_of

END, COUNT = 0.6, 61  # s, samples: frames at the same times, so that nothing is interpolated
TITLE = "Probe <b>ä</b> & \"q\" </title>"  # fmt: skip
HINGE = "<i>Lager</i> 1/2"
READY = "document.documentElement.dataset.ready === 'yes'"
# Three pictures after the client took its last messages: then what is seen is what was asked for
SETTLED = """async () => {
  const picture = () => new Promise((done) => requestAnimationFrame(done));
  do { await picture(); } while (__viserMutable.messageQueue.length);
  for (let i = 0; i < 3; i++) { __viserMutable.requestRender(); await picture(); }
}"""


@contextmanager
def opened(browser, path, **options):
    """A page that is ready; leaving it fails if it complained of anything."""
    with visit(browser, path, query="?fixedDpr=1", **options) as seen:  # else the client draws coarser where it is slow
        seen.wait(READY)
        seen.run(SETTLED)
        yield seen
        assert seen.complaints == []


@pytest.fixture(scope="module")
def solution():
    """0.6 s of a crank, an arm, a tail on a spring and a bead that flies."""
    return simulate(mechanism(), END, output=COUNT)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Of the pages; with a space and an umlaut in its name."""
    return tmp_path_factory.mktemp("meine Ansichten ä")


@pytest.fixture(scope="module")
def film(solution, folder):
    """The page of the motion."""
    solution.animate(folder / "film", frames=COUNT, title=TITLE)
    return folder / "film.html"


@pytest.fixture(scope="module")
def open_film(chromium, film):
    """One window for all tests that do not need their own."""
    with opened(chromium, film, width=900, height=560) as seen:
        yield seen


@pytest.fixture
def page(open_film):
    """The window as at the start: paused at the first frame, first view, wide."""
    open_film.page.set_viewport_size({"width": 900, "height": 560})
    open_film.page.locator("#switches").evaluate("e => { e.open = false; }")
    open_film.page.mouse.move(450, 5)
    seek(open_film, 0.0)
    open_film.page.locator("#camera").click()
    return open_film


def seek(seen, t):
    """Bring the page to a time, as its slider does, and wait for the picture."""
    seen.run("t => { mbsd3d.play(false); mbsd3d.seek(t); }", t)
    seen.run(SETTLED)


def scene(seen):
    """The picture of the mechanism."""
    return seen.pixels("#scene")


def differing(first, second):
    """Number of pixels that differ by more than the rounding of colours."""
    return int((np.abs(first.astype(int) - second).max(axis=2) > 3).sum())


def covered(picture):
    """Share of the pixels that are not paper, the most frequent colour."""
    colours, counts = np.unique(picture.reshape(-1, 3), axis=0, return_counts=True)
    return 1.0 - counts.max() / counts.sum(), len(colours)


def tick(seen, on, *names):
    """Set switches by clicking them, in the panel opened for it."""
    panel = seen.page.locator("#switches summary")
    panel.click()
    for name in names:
        seen.page.get_by_role("checkbox", name=name, exact=True).set_checked(on)
    panel.click()
    seen.run(SETTLED)


def camera_of(seen):
    """Camera and root of the scene: matrices (4, 4) of position in the client's world, and fov [rad], aspect."""
    found = seen.run("""() => {
      const {camera, nodeRefFromName} = __viserMutable;
      return [camera.matrixWorld.elements, nodeRefFromName[""].matrixWorld.elements, camera.fov, camera.aspect];
    }""")
    place, root = (np.reshape(elements, (4, 4)).T for elements in found[:2])
    return place, root, np.radians(found[2]), found[3]


def projected(seen, points):
    """World points (k, 3) [m] in pixels of the scene from its top left corner, (k, 2): the pinhole camera."""
    place, root, fov, aspect = camera_of(seen)
    points = np.atleast_2d(points) * seen.run("mbsd3d.data.scale")
    local = (np.linalg.inv(place) @ root @ np.column_stack([points, np.ones(len(points))]).T)[:3].T
    sight = local[:, :2] / -local[:, 2:] / np.tan(fov / 2) / [aspect, 1.0]  # -1 ... 1 in the picture
    box = seen.page.locator("#scene").bounding_box()
    return (0.5 + 0.5 * sight * [1, -1]) * [box["width"], box["height"]]


def test_the_harness_sees_what_goes_wrong(chromium, tmp_path):
    bad = tmp_path / "bad.html"
    bad.write_text("""<img src="http://example.org/a.png"><script>
      fetch("https://example.com/b").catch(() => 0); new WebSocket("wss://example.com/c"); console.error("oh"); no();
    </script>""")
    with visit(chromium, bad) as seen:
        seen.page.wait_for_timeout(200)
    text = "\n".join(seen.complaints)
    for part in ("http://example.org/a.png", "https://example.com/b", "wss://example.com/c", "console: oh", "uncaught"):
        assert part in text


def test_names_and_title_stand_on_the_page_as_given(page):
    assert page.page.title() == TITLE and page.page.locator("h1").text_content() == TITLE
    assert HINGE in page.page.locator("#curves").text_content()
    assert page.run("document.querySelectorAll('#page b:not(figcaption b), #page i:not(.mark)').length") == 0
    assert page.complaints == []


def test_the_scene_is_not_blank_and_moves(page):
    first = scene(page)
    share, colours = covered(first)
    assert share > 0.05 and colours > 200
    seek(page, 0.31)
    second = scene(page)
    assert differing(first, second) > 0.01 * first[..., 0].size
    seek(page, 0.0)
    assert differing(first, scene(page)) == 0  # the same time is the same picture


def test_poses_of_the_scene_are_those_of_the_solution(page, solution):
    size, scale = draw_system(solution.system).size, page.run("mbsd3d.data.scale")
    read = """() => Object.fromEntries(Object.entries(__viserMutable.nodeRefFromName).filter(
      ([name]) => /^(.bodies.[0-9]+)?$/.test(name)).map(([name, node]) => [name, node.matrixWorld.elements]))"""
    for k in (0, 17, 43, COUNT - 1):
        seek(page, float(solution.t[k]))
        found = {name: np.reshape(elements, (4, 4)).T for name, elements in page.run(read).items()}
        for i, body in enumerate((CRANK, ARM, TAIL, BEAD)):
            pose = np.linalg.inv(found[""]) @ found[f"/bodies/{i}"]
            # half a step of the packed numbers, which the three coordinates have at most at once
            assert np.abs(pose[:3, 3] / scale - solution.position(body)[k]).max() < 0.51 * LENGTH * size
            # R is quadratic in e: its elements change by at most 4 times what the four components change by
            assert np.abs(pose[:3, :3] - solution.rotation(body)[k]).max() < 4 * 0.51 * TURN


def test_between_frames_bodies_are_between(page, solution):
    k, share = 20, 0.4
    seek(page, float(solution.t[k] + share * (solution.t[k + 1] - solution.t[k])))
    pose = page.run("__viserMutable.nodePoseData['/bodies/3']")
    r, e = ((1 - share) * x[k] + share * x[k + 1] for x in (solution.position(BEAD), solution.orientation(BEAD)))
    size = draw_system(solution.system).size
    assert np.abs(np.array(pose["position"]) / page.run("mbsd3d.data.scale") - r).max() < 1.1 * LENGTH * size
    assert np.abs(matrix(np.array(pose["wxyz"])) - matrix(e / np.linalg.norm(e))).max() < 8 * TURN


def test_a_body_is_seen_where_the_camera_equations_put_it(page, solution):
    tick(page, False, "body names")
    rgb = np.array([int(PINK[i : i + 2], 16) for i in (1, 3, 5)])
    for k in (0, 26, 49):
        seek(page, float(solution.t[k]))
        picture = scene(page).astype(int)
        # the hue, whatever the light: where full, far above where empty
        pink = picture[..., rgb > 0].min(axis=-1) - picture[..., rgb == 0].max(axis=-1) > 60
        assert pink.sum() > 100
        rows, columns = np.nonzero(pink)
        centre = 0.5 * np.array([columns.min() + columns.max() + 1, rows.min() + rows.max() + 1])
        # a sphere's outline is an ellipse about its centre to 1 % of its radius (10 px); pixels and smooth edges: 1 px
        assert np.abs(centre - projected(page, solution.com(BEAD)[k])[0]).max() < 1.5
    tick(page, True, "body names")


def test_the_first_view_is_the_camera_that_was_computed(page, solution):
    frames = frames_of(solution, COUNT)
    camera = frame_camera(*bounds(draw_system(solution.system), frames.r, frames.e))
    place, root, _, _ = camera_of(page)
    position = (np.linalg.inv(root) @ place[:, 3])[:3] / page.run("mbsd3d.data.scale")
    assert np.allclose(position, camera.position, atol=1e-4 * camera.distance)  # the client keeps float32 numbers


OUTSIDE = """() => {
  const {nodeRefFromName, camera} = __viserMutable, outside = [];
  for (const [name, node] of Object.entries(nodeRefFromName)) {
    if (!node || !/^.(bodies|links|traces)/.test(name)) continue;
    node.updateWorldMatrix(true, false);
    node.traverse((part) => {
      const points = part.geometry?.attributes;
      if (!part.visible || !points || part.isInstancedMesh) return;
      const corners = points.instanceStart ? [points.instanceStart, points.instanceEnd] : [points.position];
      const at = new node.position.constructor();
      for (const list of corners) for (let i = 0; i < list.count; i++) {
        at.fromBufferAttribute(list, i).applyMatrix4(part.matrixWorld).project(camera);
        if (Math.max(Math.abs(at.x), Math.abs(at.y)) > 1) return outside.push(name);
      }
    });
  }
  return outside;
}"""


@pytest.mark.parametrize("width, height", [(900, 560), (360, 640)])
def test_the_camera_holds_the_whole_motion(page, solution, width, height):
    page.page.set_viewport_size({"width": width, "height": height})
    page.run(SETTLED)
    page.page.locator("#camera").click()
    for t in np.linspace(0.0, END, 9):
        seek(page, float(t))
        assert page.run(OUTSIDE) == []
    tick(page, False, "ground grid", "body names")
    picture = page.pixels("#root")
    edge = np.concatenate([picture[2], picture[2:, 2], picture[2:, -3]])  # row 0 may be the line above
    assert np.ptp(edge, axis=0).max() <= 3  # nothing touches the border
    tick(page, True, "ground grid", "body names")


def test_play_goes_at_the_chosen_speed_and_pause_holds(page):
    page.page.locator("#speed").select_option("0.1")
    page.run("""() => { window.log = []; const note = (now) => {
      log.push([now / 1000, mbsd3d.time]); if (log.length < 1000) requestAnimationFrame(note); };
      requestAnimationFrame(note); }""")
    page.page.locator("#play").click()
    page.wait("mbsd3d.time > 0.1")
    page.page.keyboard.press("Space")  # pressed on the button that has the focus
    page.wait("!mbsd3d.playing")
    log = np.array(page.run("log"))
    log = log[(log[:, 1] > 0.0) & (log[:, 1] < log[-1, 1])]
    real, model = np.ptp(log, axis=0)
    # page and log are called once a picture, in any order: they differ by at most the longest picture
    assert abs(model - 0.1 * real) <= 0.1 * np.diff(log[:, 0]).max() + 1e-9 and real > 0.5
    held = page.run("mbsd3d.time")
    first = scene(page)
    page.page.wait_for_timeout(300)
    assert page.run("mbsd3d.time") == held and differing(first, scene(page)) == 0
    assert page.page.locator("#play").get_attribute("aria-label") == "play"


def test_keys(page):
    step, press = END / (COUNT - 1), page.page.keyboard.press
    time = lambda: page.run("mbsd3d.time")  # noqa: E731
    page.page.locator("#scene").click(position={"x": 200, "y": 200})
    press("ArrowRight"), press("ArrowRight"), press("ArrowRight"), press("ArrowLeft")
    assert time() == pytest.approx(2 * step)
    press("End")
    assert time() == pytest.approx(END) and not page.run("mbsd3d.playing")
    press("ArrowRight")
    assert time() == pytest.approx(END)
    press("Home")
    assert time() == 0.0
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
    page.page.locator("#play").click()  # from the start again
    page.wait("mbsd3d.playing && mbsd3d.time > 0")
    assert page.run("mbsd3d.time") < END
    page.page.locator("#play").click()
    loop.check()


def test_every_switch_changes_the_picture_and_back(page):
    page.page.set_viewport_size({"width": 480, "height": 360})  # small pictures are drawn quickly
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
        name = page.page.locator("#switches label").nth(i).text_content()
        assert differing(first, scene(page)) > 20, name
        boxes.nth(i).set_checked(on)
        page.run(SETTLED)
        assert differing(first, scene(page)) == 0, name
    for i in range(len(before)):
        boxes.nth(i).set_checked(False)
    page.run(SETTLED)
    assert covered(page.pixels("#root"))[0] < 0.01  # the measure of "not blank" says no to paper alone
    for i, on in enumerate(before):
        boxes.nth(i).set_checked(on and i > 0)
    page.run(SETTLED)


def cursor(seen):
    """Place of the cursor of the first curve [px from its left]: the one line that is ink from top to bottom."""
    ink = 255.0 - seen.pixels("#curves canvas.plot").max(axis=2)
    sums = ink.sum(axis=0)
    k = int(sums.argmax())
    near = np.arange(k - 1, k + 2)
    assert sums[near].sum() > 0.6 * 200 * len(ink)  # most of the height, in a colour nearly black
    return float((near * sums[near]).sum() / sums[near].sum())


def test_curves_follow_the_time_and_scrub_it(page, solution):
    columns = {}
    for k in (0, 15, 44, COUNT - 1):
        seek(page, float(solution.t[k]))
        columns[k] = cursor(page)
        shown = page.page.locator("#curves figure").first.locator("output").first.text_content()
        assert float(shown.replace("\u2212", "-")) == pytest.approx(solution.angle(HINGE)[k], rel=5e-4, abs=1e-9)
    width = columns[COUNT - 1] - columns[0]
    for k, column in columns.items():
        assert abs(column - columns[0] - width * solution.t[k] / END) <= 1.0  # one pixel
    box = page.page.locator("#curves canvas.plot").nth(1).bounding_box()
    page.page.mouse.click(box["x"] + columns[44] + 0.5, box["y"] + 40)
    page.run(SETTLED)
    assert page.run("mbsd3d.time") == pytest.approx(solution.t[44], abs=1.5 * END / width)
    page.page.mouse.down()
    page.page.mouse.move(box["x"] + columns[15] + 0.5, box["y"] + 40, steps=3)
    page.page.mouse.up()
    page.run(SETTLED)
    assert page.run("mbsd3d.time") == pytest.approx(solution.t[15], abs=1.5 * END / width)
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


@pytest.mark.parametrize("width, height", [(1280, 720), (560, 700), (360, 640), (640, 360)])
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


@pytest.mark.parametrize(
    "reader, dark, expected", [("dark", None, True), ("dark", False, False), ("light", True, True)]
)
def test_dark_and_light(chromium, solution, folder, reader, dark, expected):
    view = solution.system.show(dark=dark)
    with opened(chromium, view.save(folder / "paper"), width=420, height=320, color_scheme=reader) as seen:
        picture = seen.pixels("#root")
        share, colours = covered(picture)
        assert bool(picture[2].mean() < 60) is expected and share > 0.05 and colours > 200
        header = seen.pixels("header").reshape(-1, 3).mean()
        assert bool(header < 90) is expected
        assert seen.page.locator("#play, #scrub, #curves").count() == 0  # a pose alone has no player


def test_a_client_without_the_hook_says_so(chromium, film):
    with visit(chromium, film) as seen:
        seen.page.add_init_script("Object.defineProperty(window, '__viserMutable', {get() {}, set() {}})")
        seen.page.clock.install()
        seen.page.reload()
        seen.wait("document.querySelectorAll('#curves canvas').length > 0")
        seen.page.clock.fast_forward(60_000)
        seen.wait("!document.getElementById('message').textContent.startsWith('Loading')")
        assert "3D scene did not start" in seen.page.locator("#message").text_content()
        assert seen.page.locator("#message").is_visible() and seen.page.locator("#play").is_enabled()


def test_without_webgl_the_curves_work(chromium, film):
    with visit(chromium, film) as seen:
        seen.page.add_init_script("""const get = HTMLCanvasElement.prototype.getContext;
          HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
            return kind.startsWith("webgl") ? null : get.call(this, kind, ...rest); };""")
        seen.page.reload()
        seen.page.get_by_text("no WebGL").wait_for()
        seen.run("mbsd3d.seek(0.15)")
        seen.wait("document.getElementById('time').textContent === 't = 0.150 s'")
        assert seen.page.locator("#curves canvas.plot").first.is_visible()


def test_a_notebook_shows_the_page_in_a_frame(chromium, solution, folder):
    path = folder / "notebook.html"
    path.write_text(f"<!doctype html><meta charset=utf-8><p>In [1]</p>{solution.system.show()._repr_html_()}", "utf-8")
    with visit(chromium, path, width=500, height=640) as seen:
        frame = seen.page.frame_locator("iframe")
        frame.locator("html[data-ready=yes]").wait_for()
        assert covered(seen.pixels("iframe"))[0] > 0.03 and seen.complaints == []


@pytest.mark.parametrize("reader", ["light", "dark"])
def test_the_report_is_read_offline_on_any_screen_and_on_paper(chromium, solution, folder, reader):
    solution.report(folder / "report", title=TITLE)
    with visit(chromium, folder / "report.html", width=900, height=700, color_scheme=reader) as seen:
        assert seen.page.locator("h1").first.text_content().strip() == TITLE.strip()
        text = seen.page.locator("body").text_content()
        for name in (CRANK, ARM, TAIL, BEAD, HINGE):
            assert name in text
        picture = seen.pixels()
        assert bool(picture[4, 4].mean() < 90) is (reader == "dark") and covered(picture)[1] > 50
        assert seen.page.locator("svg").count() >= 2 and seen.page.locator("table").count() >= 3
        seen.page.set_viewport_size({"width": 390, "height": 700})
        assert seen.run("document.documentElement.scrollWidth <= innerWidth")
        assert seen.page.pdf(format="A4", prefer_css_page_size=True).startswith(b"%PDF")
        assert seen.complaints == []


def chain(links):
    """Bodies in a row on balls, each turned against the last."""
    bodies, joints, before = [], [], GROUND
    for i in range(links):
        at = (0.3 * i, 0.02 * i, -0.01 * i)
        body = Body(f"link {i}", 0.5 + 0.05 * i, (0.002, 0.005, 0.006), com=(0.15, 0.01, 0.02), position=at)
        bodies.append(body)
        joints.append(Spherical(before, body, at=at))
        before = body
    return System(bodies, joints)


def test_ten_bodies_and_a_thousand_frames(chromium, folder):
    run = simulate(chain(10), 1.0, rtol=1e-5, output=1000)
    view = run.animate(folder / "large", frames=1000)
    assert (view.bodies, view.frames) == (10, 1000) and (folder / "large.html").stat().st_size < 2e6
    start = time.perf_counter()
    with opened(chromium, folder / "large.html", width=480, height=360) as seen:
        assert time.perf_counter() - start < 30.0  # 2 s on a quiet machine; beyond this something is wrong, not slow
        seek(seen, 0.7)
        k = int(np.searchsorted(run.t, 0.7))
        r = np.array(seen.run("__viserMutable.nodePoseData['/bodies/9'].position")) / seen.run("mbsd3d.data.scale")
        near = run.position("link 9")[k - 1 : k + 1]
        assert (np.abs(r - near).min(axis=0) <= np.ptp(near, axis=0) + LENGTH * draw_system(run.system).size).all()
