"""Pages in a real browser, without a network: what is seen, and that it is where the equations put it."""

import sys

import numpy as np
import pytest
from helpers.browser import executable, launch, visit
from helpers.page_mechanism import ARM, BEAD, CRANK, PINK, TAIL
from helpers.pages import COUNT, END, HINGE, OUTSIDE, SETTLED, TITLE, covered, differing, opened, scene, seek, tick

from mbsd3d import GROUND, Body, Spherical, System, simulate
from mbsd3d.rotations import matrix
from mbsd3d.view.scene.artist import draw_system
from mbsd3d.view.scene.camera import directions, sight
from mbsd3d.view.scene.drawing import bounds
from mbsd3d.view.scene.frames import frames_of

POSITION_RESOLUTION, QUATERNION_RESOLUTION = 1e-5, 1e-5  # of a page [sizes of the mechanism], [1]

pytestmark = pytest.mark.slow


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


@pytest.mark.parametrize("required, outcome", [("", pytest.skip.Exception), ("required", pytest.fail.Exception)])
def test_a_missing_browser_is_said_with_the_remedy(monkeypatch, tmp_path, required, outcome):
    monkeypatch.setenv("MBSD3D_BROWSER", required)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CHROMIUM", raising=False)
    with pytest.raises(outcome, match=r"^no browser \(chromium, .*\) on PATH: install one .* or set CHROMIUM$"):
        executable()
    monkeypatch.setenv("CHROMIUM", "nowhere")
    with pytest.raises(outcome, match="^CHROMIUM=nowhere is not a program; set it to the path of Chromium or Chrome$"):
        executable()
    monkeypatch.setitem(sys.modules, "playwright.sync_api", None)
    with pytest.raises(outcome, match=r"need the package playwright; install it: pip install mbsd3d\[test\]$"):
        launch().__enter__()


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


def test_poses_of_the_scene_are_those_of_the_solution(page, motion):
    size, scale = draw_system(motion.system).size, page.run("mbsd3d.data.scale")
    read = """() => Object.fromEntries(Object.entries(__viserMutable.nodeRefFromName).filter(
      ([name]) => /^(.bodies.[0-9]+)?$/.test(name)).map(([name, node]) => [name, node.matrixWorld.elements]))"""
    for k in (0, 17, 43, COUNT - 1):
        seek(page, float(motion.t[k]))
        found = {name: np.reshape(elements, (4, 4)).T for name, elements in page.run(read).items()}
        for i, body in enumerate((CRANK, ARM, TAIL, BEAD)):
            pose = np.linalg.inv(found[""]) @ found[f"/bodies/{i}"]
            # half a step of the packed numbers, which the three coordinates have at most at once
            assert np.abs(pose[:3, 3] / scale - motion.position(body)[k]).max() < 0.51 * POSITION_RESOLUTION * size
            # R is quadratic in e: its elements change by at most 4 times what the four components change by
            assert np.abs(pose[:3, :3] - motion.rotation(body)[k]).max() < 4 * 0.51 * QUATERNION_RESOLUTION


def test_between_frames_bodies_are_between(page, motion):
    k, share = 20, 0.4
    seek(page, float(motion.t[k] + share * (motion.t[k + 1] - motion.t[k])))
    pose = page.run("__viserMutable.nodePoseData['/bodies/3']")
    r, e = ((1 - share) * x[k] + share * x[k + 1] for x in (motion.position(BEAD), motion.orientation(BEAD)))
    size = draw_system(motion.system).size
    assert (
        np.abs(np.array(pose["position"]) / page.run("mbsd3d.data.scale") - r).max() < 1.1 * POSITION_RESOLUTION * size
    )
    assert np.abs(matrix(np.array(pose["wxyz"])) - matrix(e / np.linalg.norm(e))).max() < 8 * QUATERNION_RESOLUTION


def test_a_body_is_seen_where_the_camera_equations_put_it(page, motion):
    tick(page, False, "body names")
    rgb = np.array([int(PINK[i : i + 2], 16) for i in (1, 3, 5)])
    for k in (0, 26, 49):
        seek(page, float(motion.t[k]))
        picture = scene(page).astype(int)
        # the hue, whatever the light: where full, far above where empty
        pink = picture[..., rgb > 0].min(axis=-1) - picture[..., rgb == 0].max(axis=-1) > 60
        assert pink.sum() > 100
        rows, columns = np.nonzero(pink)
        centre = 0.5 * np.array([columns.min() + columns.max() + 1, rows.min() + rows.max() + 1])
        # a sphere's outline is an ellipse about its centre to 1 % of its radius (10 px); pixels and smooth edges: 1 px
        assert np.abs(centre - projected(page, motion.com(BEAD)[k])[0]).max() < 1.5
    tick(page, True, "body names")


def test_the_first_view_is_the_camera_that_was_computed(page, motion):
    frames = frames_of(motion, COUNT)
    box = bounds(
        draw_system(motion.system),
        frames.r,
        frames.e,
        ("bodies", "joints", "springs and rods", "traces", "ground grid"),
        directions(None),
    )
    canvas = page.run("(({width, height}) => width / height)(document.getElementById('scene').getBoundingClientRect())")
    camera = sight(*box, directions(None), 0.7).camera(canvas)
    page.run(SETTLED)
    place, root, _, _ = camera_of(page)
    position = (np.linalg.inv(root) @ place[:, 3])[:3] / page.run("mbsd3d.data.scale")
    # the client keeps float32 numbers
    assert np.allclose(position, camera.position, rtol=0, atol=1e-4 * camera.distance)


@pytest.mark.parametrize("width, height", [(800, 460), (360, 640)])
def test_the_camera_holds_the_whole_motion(page, motion, width, height):
    page.page.set_viewport_size({"width": width, "height": height})
    page.run(SETTLED)
    page.page.locator("#camera").click()
    for t in np.linspace(0.0, END, 6):
        seek(page, float(t))
        assert page.run(OUTSIDE) == []
    tick(page, False, "ground grid", "body names")
    picture = page.pixels("#root")
    edge = np.concatenate([picture[2], picture[2:, 2], picture[2:, -3]])  # row 0 may be the line above
    assert np.ptp(edge, axis=0).max() <= 3  # nothing touches the border
    tick(page, True, "ground grid", "body names")


@pytest.mark.parametrize(
    "reader, dark, expected",
    [
        ("dark", None, True),
        pytest.param("light", True, True),
        pytest.param("dark", False, False),
    ],
)
def test_dark_and_light(chromium, motion, folder, reader, dark, expected):
    view = motion.system.show(dark=dark)
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


def test_a_notebook_shows_the_page_in_a_frame(chromium, motion, folder):
    path = folder / "notebook.html"
    path.write_text(f"<!doctype html><meta charset=utf-8><p>In [1]</p>{motion.system.show()._repr_html_()}", "utf-8")
    with visit(chromium, path, width=500, height=640) as seen:
        frame = seen.page.frame_locator("iframe")
        frame.locator("html[data-ready=yes]").wait_for()
        assert covered(seen.pixels("iframe"))[0] > 0.03 and seen.complaints == []


@pytest.mark.parametrize("reader", ["light", pytest.param("dark")])
def test_the_report_is_read_offline_on_any_screen_and_on_paper(chromium, motion, folder, reader):
    motion.report(folder / "report", title=TITLE)
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
    with opened(chromium, folder / "large.html", width=480, height=360) as seen:
        seek(seen, 0.7)
        k = int(np.searchsorted(run.t, 0.7))
        r = np.array(seen.run("__viserMutable.nodePoseData['/bodies/9'].position")) / seen.run("mbsd3d.data.scale")
        near = run.position("link 9")[k - 1 : k + 1]
        assert (
            np.abs(r - near).min(axis=0) <= np.ptp(near, axis=0) + POSITION_RESOLUTION * draw_system(run.system).size
        ).all()
