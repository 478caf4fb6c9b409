"""Pages of systems and runs: what they hold is what was computed, and nothing in them can break or leave them."""

import base64
import json
import os
import re
import subprocess
import sys
import threading
import zlib

import numpy as np
import pytest
import trimesh
from helpers.models import pair_at

from mbsd3d import GROUND, Body, Revolute, Spherical, SpringDamper, System, linearize, simulate
from mbsd3d.mechanism.shapes.triangles import ball, block, capsule, cylinder, normals, torus
from mbsd3d.rotations import matrix
from mbsd3d.view.page import html as page
from mbsd3d.view.page import show
from mbsd3d.view.page.content import pack
from mbsd3d.view.page.recorder import Recording, import_viser
from mbsd3d.view.page.stage import Stage
from mbsd3d.view.play.play_page import shapes_of
from mbsd3d.view.scene.artist import draw_system
from mbsd3d.view.scene.camera import length_text, round_down, round_up
from mbsd3d.view.scene.frames import frames_of, sensible_speed
from mbsd3d.view.scene.meshes import arrow, flat_normals, laid
from mbsd3d.view.scene.overlays import arrows_of, curves_of

# steps of what a page holds: [sizes of the mechanism], [1], [lengths of the longest arrow], [ranges of the curve]
POSITION_RESOLUTION, QUATERNION_RESOLUTION, ARROW_RESOLUTION, CURVE_RESOLUTION = 1e-5, 1e-5, 2e-4, 1e-6

EVIL = "</script><script>alert(1)</script> <img src=x onerror=alert(2)> \"'\\ /a//b {{ 7 }} \u2028 ü 😀 \ud800"
NAMED = EVIL.replace("\u2028", "")  # names are of one line


def unpack(packed):
    """What `pack` was given, to half a step; NaN where a value was not finite."""
    raw = np.frombuffer(zlib.decompress(base64.b64decode(packed["data"])), np.uint8)
    zigzag = np.ascontiguousarray(raw.reshape(4, -1).T).view("<u4").astype(np.uint32).ravel()
    frames = packed["shape"][0]
    rows = ((zigzag >> 1) ^ (-(zigzag & 1).astype(np.int32)).view(np.uint32)).view(np.int32).reshape(-1, frames)
    for _ in range(2):
        rows = np.cumsum(rows, axis=1, dtype=np.int32)
    values = np.where(rows == -(2**31), np.nan, rows * packed["step"])
    return np.ascontiguousarray(values.T).reshape(packed["shape"])


def chain(count: int = 2, size: float = 1.0, first: str = NAMED) -> System:
    """Bodies in a chain with general axes, centres of mass and inertias, and a spring to the ground."""
    rng, at, bodies, joints = np.random.default_rng(5), np.zeros(3), [], []
    for i in range(count):
        tip = at + 0.4 * size * rng.uniform(0.3, 1.0, 3) * (1, -1, -1)
        before, inertia = bodies[-1] if bodies else GROUND, size**2 * np.array([0.02, 0.03, 0.025])
        name, com = first if i == 0 else f"link {i}", 0.05 * size * rng.normal(size=3)
        bodies.append(
            Body(
                name,
                1.0 + i,
                inertia,
                com=com,
                position=0.5 * (at + tip),
                orientation=laid(rng.normal(size=(1, 3)))[0],
            )
        )
        kind = {"at": at, "name": f"joint {i}"}
        joints.append(
            Spherical(before, bodies[i], **kind) if i % 2 else Revolute(before, bodies[i], axis=(0.2, 1, 0.3), **kind)
        )
        at = tip
    spring = SpringDamper(GROUND, bodies[-1], at_a=(size, 0, 0.1 * size), at_b=at, stiffness=20.0 / size, damping=0.1)
    return System(bodies, joints, [spring])


@pytest.fixture(scope="module")
def run():
    return simulate(chain(), 1.5)


@pytest.fixture(scope="module")
def view(run):
    return run.animate(title=EVIL, frames=201)


def data_of(view: page.View) -> dict:
    """What the player reads."""
    return json.loads(re.search(r'<script id="data" type="application/json">(.*?)</script>', view.html, re.DOTALL)[1])


def test_poses_and_curves_are_those_of_the_run(run, view):
    data, frames, drawing = data_of(view), frames_of(run, 201), draw_system(run.system)
    times = data["times"]
    assert np.allclose(times["first"] + times["step"] * np.arange(times["count"]), frames.t, rtol=1e-13, atol=0)
    r, e = unpack(data["poses"]["r"]), unpack(data["poses"]["e"])
    # rounding to the nearest step: half a step, and what doubles of that size leave
    assert np.abs(r - frames.r).max() <= 0.5001 * POSITION_RESOLUTION * drawing.size
    assert np.abs(e - frames.e).max() <= 0.5001 * QUATERNION_RESOLUTION
    assert np.allclose(
        r[-1, :-1],
        [run.position(body)[-1] for body in run.system.bodies],
        rtol=0,
        atol=POSITION_RESOLUTION * drawing.size,
    )
    assert (r[:, -1] == 0.0).all() and data["moving"] == [0, 1]
    for curve, packed in zip(curves_of(run, frames), data["curves"], strict=True):
        assert packed["label"] == curve.label
        for (name, values), line in zip(curve.lines, packed["lines"], strict=True):
            assert line["name"] == name
            bound = max(CURVE_RESOLUTION * np.ptp(values), 1e-9 * np.abs(values).max())
            assert np.abs(unpack(line["values"]) - values).max() <= 0.5001 * bound


def test_arrows_are_those_of_the_run(run, view):
    data, frames, size = data_of(view), frames_of(run, 201), draw_system(run.system).size
    kinds = arrows_of(run, frames)
    assert [kind["kind"] for kind in data["arrows"]] == [kind.kind for kind in kinds]
    assert "reaction force" in {kind.kind for kind in kinds}
    for kind, packed in zip(kinds, data["arrows"], strict=True):
        longest = np.sqrt((kind.vectors**2).sum(axis=-1)).max()
        assert np.isclose(packed["longest"], longest) and np.isclose(packed["factor"] * longest, 0.4 * size)
        assert np.abs(unpack(packed["vectors"]) - kind.vectors).max() <= 0.5001 * ARROW_RESOLUTION * longest
        assert np.abs(unpack(packed["points"]) - kind.points).max() <= 0.5001 * ARROW_RESOLUTION * size
        assert packed["heads"] == (1 if kind.unit == "N" else 2)


def test_links_are_where_the_parts_are(run, view):
    (ends,), spring = data_of(view)["links"][0]["ends"], run.system.forces[0]
    assert ends[0] == [2, list(spring.at_a)]
    body = run.system.bodies[ends[1][0]]
    assert np.allclose(body.position + body.axes @ ends[1][1], spring.at_b, rtol=0, atol=1e-12)


def test_names_can_do_nothing(view):
    assert view.html.count("<script") == view.html.count("</script>") == 4
    assert "alert(1)</script>" not in view.html and "<img src=x" not in view.html
    assert "<h1>&lt;/script&gt;" in view.html and "{{ 7 }}" in view.html
    view.html.encode("utf-8")


def test_the_page_holds_all_it_needs(view):
    own = re.sub(r'<script data-p=.*?</script>|__VISER_EMBED_DATA__ = ".*?"', "", view.html, flags=re.DOTALL)
    assert not re.search(r"""(src|href|url)\s*[=(]\s*["']?(?!data:)[a-z]*:?//""", own)
    assert "import(" not in own and "fetch(" not in own


@pytest.mark.slow
def test_the_same_bytes_twice_and_in_another_process(run):
    make = "System([Body('stone', 1.0, (1, 2, 2))]).show().html"
    here = System([Body("stone", 1.0, (1, 2, 2))]).show().html
    write = f"import sys\nfrom mbsd3d import Body, System\nsys.stdout.buffer.write({make}.encode())"
    other = {**os.environ, "PYTHONHASHSEED": "7"}
    there = subprocess.run([sys.executable, "-c", write], capture_output=True, env=other, check=True)
    assert there.stdout.decode() == here
    assert run.animate(frames=50).html == run.animate(frames=50).html


@pytest.mark.slow
def test_pages_are_small():
    run = simulate(chain(10, first="first"), 1.0, output=1000)
    view = run.animate(frames=1000)
    assert view.frames == 1000 and view.bodies == 10
    assert len(view.html.encode()) < 2e6


def test_frames_fall_only_if_nobody_asked_for_them(run, monkeypatch):
    full = run.animate()
    monkeypatch.setattr(show, "MOTION_BYTES_MAX", 20_000)
    assert 2 <= run.animate().frames < full.frames
    assert run.animate(frames=full.frames).html == full.html


def test_saved_shown_and_described(view, tmp_path, monkeypatch):
    path = view.save(tmp_path / "motion.v1")
    assert path.name == "motion.v1.html" and path.read_text(encoding="utf-8") == view.html
    assert re.fullmatch(r"<view: 2 bodies, 201 frames of 1.5 s, [\d.]+ MB; .save\(path\) or .open\(\)>", repr(view))
    frame = view._repr_html_()
    assert frame.startswith("<iframe srcdoc=") and "<script" not in frame
    with pytest.raises(ValueError, match="cannot be written"):
        view.save(tmp_path / "missing" / "motion")
    for name, remedy in (("motion.MP4", "export_mp4"), ("motion.gif", "export_gif"), ("motion.png", "save_figure")):
        with pytest.raises(ValueError, match=rf"{name}': a view is a page \(.html\); {remedy}"):
            view.save(tmp_path / name)
    monkeypatch.setattr("mbsd3d.view.page.html.has_browser", lambda: False)
    monkeypatch.setattr("tempfile.mkdtemp", lambda prefix: str(tmp_path))
    with pytest.raises(ValueError, match=r"no browser could be started; open '.*view.html'"):
        view.open()


def test_a_state_is_shown(run):
    written = run.system.show(state=run.final)
    r, size = unpack(data_of(written)["poses"]["r"]), draw_system(run.system).size
    assert np.abs(r[0, :-1] - run.final.q.reshape(-1, 7)[:, :3]).max() <= POSITION_RESOLUTION * size
    assert "frames" not in repr(written) and 'id="play"' not in written.html
    assert 'id="time"' in written.html and 'id="time"' not in run.system.show().html
    with pytest.raises(ValueError, match="state has 2 bodies, the system 1"):
        System([Body("stone", 1.0, (1, 1, 1))]).show(state=run.final)


def test_a_mode_is_animated():
    rod = Body("rod", mass=2.0, inertia=(0.06, 0.06, 0.001), position=(0.1, 0, -0.3))
    mode = linearize(System([rod], [Revolute(GROUND, rod, at=(0.1, 0, 0), axis=(0, 1, 0))])).mode(0)
    shown = mode.motion(amplitude=0.1, samples=25).animate(frames=25)
    assert data_of(shown)["curves"] == [] and 'id="curves"' not in shown.html


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"frames": 1}, "frames = 1; give a whole number from 2"),
        ({"frames": True}, "frames = True"),
        ({"frames": 2.5}, "frames = 2.5"),
        ({"speed": 0}, "speed: 0.0 is not positive"),
        ({"title": 3}, "title = 3; give a text"),
        ({"dark": "yes"}, "dark = 'yes'; give True, False"),
        ({"curves": ["angles"]}, "quantity 'angles' is unknown"),
        ({"hidden": 3}, "hidden: 3 is not a sequence; give a list"),
        ({"shown": "joints", "hidden": ["joints"]}, "shown, hidden: layer 'joints' is in both"),
        ({"shown": ["arrows"]}, "layer 'arrows' is unknown; give some of bodies, body names"),
        ({"beside": 5}, "beside 5 is not a solution; give one, or None"),
        ({"captions": [(99.0, "late")]}, "caption 'late' at 99 s is not within the run; give 0 ... "),
        ({"captions": [(0.1, "a", "b")]}, "is not a pair (time, text); give one"),
        ({"captions": [("now", "here")]}, "time of a caption"),
        ({"path": 5}, "path = 5 names no file"),
        (
            {"path": "nowhere/page"},
            "'nowhere/page.html' cannot be written: there is no folder 'nowhere'; make it first",
        ),
        ({"path": ""}, "path = '' names no file; give a name such as 'result.html'"),
        ({"follow": "nobody"}, "'nobody' is not one of the bodies"),
        ({"follow": 0, "live": True}, "the camera of a live view does not go along"),
        ({"live": "yes"}, "live = 'yes'; give True for a server on this machine, or False"),
        ({"traces": [("nobody", (0, 0, 0))]}, "'nobody' is not one of the bodies"),
    ],
)
def test_wrong_options(run, options, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        run.animate(**options)


def test_a_page_that_follows_a_body_is_seen_from_near(run):
    near, wide = (data_of(run.animate(frames=9, follow=x)) for x in (run.system.bodies[1], None))
    assert near["followed"] == 1 and wide["followed"] == -1
    assert sum(near["sight"]) < sum(wide["sight"])


def test_a_page_beside_another_holds_as_much_and_draws_arrows_to_its_scale(run):
    short, options = simulate(run.system, 0.02, output=3), {"frames": 3, "shown": ["angular momentum"]}
    wide, alone, beside = map(
        data_of, (run.animate(**options), short.animate(**options), short.animate(**options, beside=run))
    )
    assert sum(alone["sight"]) < 0.99 * sum(wide["sight"])
    assert beside["sight"] == pytest.approx(wide["sight"], rel=1e-3)
    scales = [{kind["kind"]: kind["factor"] for kind in data["arrows"]}["angular momentum"] for data in (wide, beside)]
    assert scales[0] == pytest.approx(scales[1], rel=1e-3)


def test_a_wrong_state():
    with pytest.raises(ValueError, match="show: state = 3; give a State"):
        System([Body("stone", 1.0, (1, 1, 1))]).show(state=3)


def test_a_page_is_named_after_its_bodies():
    system = chain(2, first="drum")
    assert "<h1>drum: reference pose</h1>" in System(system.bodies[:1]).show().html
    moving = simulate(system, 0.1, output=3).animate(frames=2)
    assert "<title>drum and link 1</title>" in moving.html and "<h1>drum and link 1</h1>" in moving.html


def test_the_grid_of_a_long_flight_is_seen():
    """Viser's own grid fades out at 100 scene units; here the camera is some 10 000 away."""
    stone = Body("stone", 1.0, (0.01, 0.02, 0.03), velocity=(70, 10, 70), omega=(1, 5, 2))
    drawing, frames = draw_system(system := System([stone])), frames_of(simulate(system, 14.0))
    recording = Recording("test")
    Stage(recording.scene, camera := recording.camera, drawing, frames)
    away = np.linalg.norm(np.subtract(camera.position, camera.look_at))
    assert away > 1000.0 and recording.scene._handle_from_node_name["/grid"].fade_distance > 2.0 * away


def test_a_run_of_one_moment_is_a_still_page(run):
    moment = run.again(0.1, output=[0.1]).animate()
    assert moment.frames == 1 and data_of(moment)["curves"] == []
    assert 'id="time"' in moment.html and 'id="play"' not in moment.html


def test_a_missing_or_other_viser(monkeypatch):
    viser = import_viser("show")
    monkeypatch.setattr(viser, "__version__", "2.0.1")
    with pytest.raises(
        ValueError, match=r"show needs viser 1.1.x, found 2.0.1; install it: pip install 'viser==1.1.\*'"
    ):
        import_viser("show")
    monkeypatch.setitem(sys.modules, "viser", None)
    with pytest.raises(
        ValueError, match=r"system.show needs viser 1.1.x, found none; install it: pip install 'viser==1.1.\*'"
    ):
        System([Body("stone", 1.0, (1, 1, 1))]).show()


def test_no_server_no_thread_no_word(run, capfd):
    before = threading.active_count()
    run.animate(frames=10)
    assert threading.active_count() == before and capfd.readouterr() == ("", "")


@pytest.mark.parametrize("frames", [1, 2, 57])
def test_packed_arrays_come_back(frames):
    values = np.random.default_rng(1).normal(size=(frames, 3, 2)) * [1.0, 1e3]
    values[0, 0, 0], values[-1, 2, 1] = np.nan, np.inf
    again, finite = unpack(pack(values, 1e-4)), np.isfinite(values)
    assert np.isnan(again[~finite]).all()
    assert np.abs(again - values)[finite].max() <= 0.5001e-4
    wide = pack(1e9 * values, 1e-4)  # steps too small for 30 bits are made larger
    assert np.abs(unpack(wide) - 1e9 * values)[finite].max() <= 0.5001 * wide["step"]
    assert wide["step"] < 3e-9 * np.abs(1e9 * values[finite]).max()
    assert (unpack(pack(np.zeros((frames, 0)), 0.0)) == 0.0).all()


@pytest.mark.parametrize("size", [1e-3, 1.0, 4e3])
def test_scenes_are_some_units_large(size):
    run = simulate(chain(size=size), 0.02)
    drawing, frames, recording = draw_system(run.system), frames_of(run, 3), Recording("show")
    stage = Stage(recording.scene, recording.camera, drawing, frames, arrows_of(run, frames))
    assert 0.5 <= drawing.size * stage.scale < 5.0 and np.isclose(np.log10(stage.scale) % 1.0, 0.0)
    assert np.allclose([node.position for node in stage.bodies], frames.r[0] * stage.scale)
    assert np.allclose(matrix(np.array([node.wxyz for node in stage.bodies])), matrix(frames.e[0]))


def test_a_page_far_from_the_origin_is_that_of_the_same_near_it():
    """Single precision, in which pages draw, has steps of a quarter of a metre there; shares of the size are left."""
    systems = [pair_at(k * np.array([2.1e6, -3.3e6, 4.7e5])) for k in (0.0, 1.0)]
    near, far = (data_of(simulate(x, 0.1, output=5, rtol=1e-6).animate(frames=5)) for x in systems)
    moved = (unpack(far["poses"]["r"]) - unpack(near["poses"]["r"]))[:, :-1]
    assert np.abs(moved).max() < 60.0 and np.ptp(moved, axis=(0, 1)).max() < 1e-3  # the same motion, near
    assert near["sight"] == pytest.approx(far["sight"], rel=1e-3) and not unpack(far["poses"]["r"])[:, -1].any()
    assert np.allclose(
        unpack(far["arrows"][0]["points"]), unpack(near["arrows"][0]["points"]) + moved[0, 0], rtol=0, atol=1e-3
    )
    ends = [np.array(x["links"][0]["ends"][0][0][1]) for x in (near, far)]  # of the spring on the ground
    assert np.allclose(ends[1] - ends[0], moved[0, 0], rtol=0, atol=1e-3)
    shapes = [shapes_of(x) for x in systems]
    for node, arrays in shapes[0].items():
        for key in arrays:
            one, other = (np.reshape(shape[node][key], (-1, 3)) for shape in shapes)
            assert np.allclose(np.ptp(one, axis=0), np.ptp(other, axis=0), rtol=0, atol=1e-4)
    assert shapes[0].keys() == shapes[1].keys()


def test_rods_and_arrows_lie_along_vectors():
    vectors = np.vstack([np.random.default_rng(2).normal(size=(20, 3)), [0, 0, 2], [0, 0, -3], [1e-6, 0, -1]])
    directions = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    for rest in ([0, 0, 1], np.roll(directions, 1, axis=0), -directions):
        e = laid(vectors, rest)
        assert np.allclose(np.linalg.norm(e, axis=1), 1.0)
        assert np.abs(matrix(e)[:, :, 2] - directions).max() < 1e-9  # opposite to rest a third of the digits is lost
    assert np.allclose(laid(np.zeros((1, 3))), [[1, 0, 0, 0]])


@pytest.mark.parametrize(
    "mesh", [block(), cylinder(), cylinder(24), ball(), torus(0.3, 0.02), capsule(0.2, 0.5), arrow(1), arrow(2)]
)
def test_vertices_are_shared_across_smooth_edges_only(mesh):
    flat = flat_normals(mesh.vertices[mesh.faces])
    bends = np.einsum("mci,mi->mc", normals(mesh)[mesh.faces], flat)
    off_axis = np.linalg.norm(mesh.vertices[mesh.faces][..., :2], axis=2) > 1e-9  # tips and poles have no normal
    assert bends[off_axis].min() > np.cos(
        np.radians(35.0)
    )  # 60 degrees about the tube of a torus, of which a corner sees half


@pytest.mark.parametrize("heads", [1, 2])
def test_arrows_reach_from_zero_to_one(heads):
    found = arrow(heads)
    assert np.isclose(found.vertices[:, 2].max(), 1.0) and np.isclose(found.vertices[:, 2].min(), 0.0)
    assert trimesh.Trimesh(found.vertices, found.faces).volume > 0.0  # faces look outwards


def test_round_numbers():
    assert [sensible_speed(t) for t in (0.0, 0.628, 1.9, 2.0, 30.0, 31.0, 4e4)] == [1, 0.05, 0.2, 1, 1, 2, 5000]
    assert [round_up(x) for x in (0.1, 0.11, 0.3, 7.0, 2e-5)] == [0.1, 0.2, 0.5, 10.0, 2e-5]
    assert [length_text(x) for x in (0.0005, 0.01, 500.0, 2000.0)] == ["0.5 mm", "0.01 m", "500 m", "2 km"]
    assert [round_down(x) for x in (0.1, 0.11, 0.3, 7.0, 2e-5)] == [0.1, 0.1, 0.2, 5.0, 2e-5]
