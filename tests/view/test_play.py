"""The page of a ride and its server: who is let in, what is said and understood, saved rides; and a real browser."""

import asyncio
import json
import re
import socket
import struct
import threading
from contextlib import contextmanager

import numpy as np
import pytest
from helpers.browser import visit
from helpers.live_views import knock, listens, until
from helpers.models import crane
from helpers.pages import SETTLED

from mbsd3d import GROUND, Body, Input, Revolute, Solution, System, Torque
from mbsd3d.view.page.stage import swing
from mbsd3d.view.play.play import Play, parsed, ride_so_far
from mbsd3d.view.play.play_page import pivot_of
from mbsd3d.view.play.server import Outlet
from mbsd3d.view.scene.camera import directions, sight

FIELD_OF_VIEW = 0.7  # [rad] vertical

PERIOD = 1.0 / 60.0  # [s] from one frame to the next, as docs/how/stepping.md says

READY = "document.documentElement.dataset.ready === 'yes'"
RANGES = {"push": (-6.0, 6.0), "twist": (-1.5, 2.5)}
LINES = 4  # of the panels: angle of pin, slide of rail, two inputs


@pytest.fixture
def ride():
    """A ride that waits for somebody to look."""
    with crane(name="crane <b>").play(RANGES) as made:
        yield made


@contextmanager
def looking(ride, watch=True):
    """A browser's side of the socket, without a browser."""
    from websockets.sync.client import connect

    cookie = knock(ride.url)[1]["Set-Cookie"].partition(";")[0]
    address = ride.url.partition("?")[0].replace("http", "ws") + "live"
    with connect(address, additional_headers={"Cookie": cookie}, compression=None) as line:
        line.say = lambda **said: line.send(json.dumps(said))
        if watch:
            line.say(watch=True)
        yield line


def heard(line, wanted):
    """The first text or frame that is wanted, within the patience of a minute."""
    while True:
        said = line.recv(timeout=60.0)
        said = json.loads(said) if isinstance(said, str) else np.frombuffer(said, "<f8")
        if wanted(said):
            return said


def is_frame(said):
    return isinstance(said, np.ndarray)


def test_it_says_nothing_and_leaves_nothing(capfd):
    threads = threading.active_count()
    ride = crane().play(RANGES)
    assert isinstance(ride, Play) and listens(ride.url) and ride.url.startswith("http://127.0.0.1:")
    assert repr(ride) == f"<play: {ride.url}>" and ride.t == 0.0 and ride.late == 0
    with looking(ride) as line:
        heard(line, is_frame)
        ride.stop()
    ride.stop()  # twice does no harm
    assert not listens(ride.url) and repr(ride).endswith("(stopped)>")
    assert until(lambda: threading.active_count() <= threads)
    assert capfd.readouterr() == ("", "")
    assert isinstance(ride.solution(), Solution)  # what was ridden is still there


def test_only_the_whole_address_opens_it(ride):
    bare = ride.url.partition("?")[0]
    port = ride.url.partition("/?")[0].rpartition(":")[2]
    status, head = knock(ride.url)
    assert status == 200 and "HttpOnly; SameSite=Strict" in head["Set-Cookie"] and head["Cache-Control"] == "no-store"
    assert head["Content-Type"].startswith("text/html")
    cookie = head["Set-Cookie"].partition(";")[0]
    upgrade = {
        "Upgrade": "websocket", "Connection": "Upgrade", "Sec_WebSocket_Version": "13",
        "Sec_WebSocket_Key": "eHh4eHh4eHh4eHh4eHh4eA==",
    }  # fmt: skip
    assert knock(bare)[0] == 403 and knock(bare + "?token=x")[0] == 403 and knock(bare, Cookie=cookie)[0] == 200
    assert knock(bare + "nothing", Cookie=cookie)[0] == 404 and knock(bare + "live", Cookie=cookie)[0] == 404
    assert knock(bare + "live", **upgrade)[0] == 403
    assert knock(bare + "live", Cookie=cookie, Origin="http://evil.example", **upgrade)[0] == 403
    assert knock(bare + "live", Cookie=cookie, Host=f"evil.example:{port}", **upgrade)[0] == 403
    assert knock(bare + "live", Cookie=cookie, Origin=f"http://127.0.0.1:{port}", **upgrade)[0] == 101


def asked(url, path, *lines):
    """Status of a request of whatever bytes."""
    host, port = re.fullmatch(r"http://(.+):(\d+)/.*", url).groups()
    own = [f"GET {path} HTTP/1.1".encode(), *(line.replace("PORT", port).encode("latin-1") for line in lines)]
    with socket.create_connection((host, int(port)), timeout=10) as line:
        line.sendall(b"\r\n".join([*own, b"Connection: close", b"", b""]))
        head = line.recv(4096)
    return int(head.split()[1])


HOST = "Host: 127.0.0.1:PORT"
TURNED_AWAY = {
    "two hosts": (HOST, HOST),
    "two names": (HOST, "Host: localhost:PORT"),
    "a foreign one first": ("Host: evil.example:PORT", HOST),
    "three": (HOST, HOST, "host: 127.0.0.1:PORT"),
    "two origins": (HOST, "Origin: http://127.0.0.1:PORT", "Origin: http://127.0.0.1:PORT"),
    "two cookies": (HOST, "Cookie: a=1", "Cookie: b=2"),
}


@pytest.mark.parametrize("lines", TURNED_AWAY.values(), ids=TURNED_AWAY)
def test_a_request_that_means_two_things_is_refused(ride, lines):
    token = ride.url.partition("?")[2]
    for path in ("/", f"/?{token}", "/live"):
        assert asked(ride.url, path, *lines) == 400
    assert asked(ride.url, f"/?{token}", HOST) == 200


def test_odd_requests_are_no_error_of_the_server(ride):
    token = ride.url.partition("?")[2]
    odd = [
        ("/", "Cookie: a@b=1; (=2"), ("/", "Cookie: \xe4\xff=\xfe"), ("//[", "A: b"), ("//[?token=%ff%00", "A: b"),
        ("/?token=%f0%9f", "A: b"), ("/?" + "&" * 2000, "A: b"), ("/?token=%00", "Upgrade: a", "Upgrade: b"),
        ("/live", "Upgrade: websocket", "Upgrade: websocket"),
    ]  # fmt: skip
    for path, *lines in odd:
        assert 400 <= asked(ride.url, path, HOST, *lines) < 500, (path, lines)
    port = re.search(r":(\d+)/", ride.url)[1]
    cookie = f"Cookie: a@b=1; (=2; mbsd3d-{port}={token.partition('=')[2]}"
    assert asked(ride.url, "//[", HOST, cookie) in (403, 404)
    assert 400 <= asked(ride.url, "/") < 500  # no host at all


def test_frames_hold_the_poses_and_the_curves(ride):
    with looking(ride) as line:
        frame = heard(line, lambda said: is_frame(said) and said[0] > 10 * PERIOD)
        solution = ride.solution()
        assert frame.size == 3 + LINES + 2 * 7
        k = int(np.argmin(np.abs(solution.t - frame[0])))
        assert solution.t[k] == pytest.approx(frame[0], abs=1e-12)
        pin, rail = solution.angle("pin")[k], solution.slide("rail")[k]
        assert frame[3 : 3 + LINES] == pytest.approx([pin, rail, 0.4, 0.0], abs=1e-9)
        poses = frame[3 + LINES :].reshape(2, 7)
        assert poses[1, :3] == pytest.approx(solution.position("load")[k], abs=1e-9)
        assert poses[1, 3:] == pytest.approx(solution.orientation("load")[k], abs=1e-9)


def test_it_waits_until_somebody_looks_and_when_nobody_does(ride):
    with looking(ride, watch=False) as line:
        for _ in range(3):
            assert heard(line, is_frame)[0] == 0.0
        line.say(watch=True)
        heard(line, lambda said: is_frame(said) and said[0] > 0.0)
        line.say(hold="push", to=6.0)
        assert until(lambda: ride.values["push"] == 6.0)
    assert until(lambda: ride.values["push"] == 0.4)  # who has gone presses no key
    assert until(lambda: not ride._playing.moving)
    before = ride.t
    with looking(ride) as line:  # a page that was loaded again gets what it has missed
        history = heard(line, lambda said: "history" in said)["history"]
        assert history[0][0] == 0.0 and history[-1][0] == before and len(history[0]) == 1 + LINES
        heard(line, lambda said: is_frame(said) and said[0] > before)


def test_keys_go_before_sliders(ride):
    with looking(ride) as line:
        line.say(set="push", to=2)
        line.say(hold="push", to=-60.0)  # an end of the range, at most
        assert until(lambda: ride.values == {"push": -6.0, "twist": 0.0})
        line.say(hold="push", to=None)
        assert until(lambda: ride.values["push"] == 2.0)
        ride.set("twist", 1.0)
        assert heard(line, lambda said: not is_frame(said) and said["values"]["twist"] == 1.0)["held"] == {}
        line.say(run=False)
        assert heard(line, lambda said: not is_frame(said) and not said["running"])["over"] is False
        line.say(pace=0.1)
        line.say(run=True)
        assert until(lambda: ride._playing.pace == 0.1 and ride._playing.moving)
        before = ride.t
        line.say(do="reset")
        assert until(lambda: ride.t < before)
        ride.reset()
        assert ride.values == {"push": 2.0, "twist": 1.0}


@pytest.mark.parametrize(
    "said",
    [
        '{"set": "motor", "to": 1}', '{"set": "push", "to": NaN}', '{"set": "push", "to": "1"}', '{"set": "push"}',
        '{"set": "push", "to": true}', '{"pace": 1000}', '{"pace": -1}', '{"do": "exec"}', "push", "[" * 4000, "",
        '{"run": 1}', '{"set": ["push"], "to": 1}',
    ],
)  # fmt: skip
def test_what_makes_no_sense_ends_the_conversation(ride, said):
    from websockets.exceptions import ConnectionClosedError

    with looking(ride) as line:
        line.send(said)
        with pytest.raises(ConnectionClosedError, match="not understood"):
            heard(line, lambda _: False)
    assert ride.values == {"push": 0.4, "twist": 0.0}


def test_numbers_are_finite_floats():
    assert parsed('{"to": 3}') == {"to": 3.0} and type(parsed('{"to": 3}')["to"]) is float
    assert parsed("Infinity") is None and parsed("{") is None


def test_inputs_are_named_by_themselves_too():
    system = crane()
    with system.play({Input("push"): (-6.0, 6.0)}) as made:
        assert list(made.values) == ["push"]


def test_python_may_set_what_has_a_slider(ride):
    ride.set("push", 3)
    assert ride.values["push"] == 3.0
    for name, value, text in (
        ("motor", 1, "'motor' has no slider; there are 'push', 'twist'"),
        ("push", 7, "'push' = 7 is not within -6 ... 6"),
        ("push", None, "'push': expected a number, got None"),
    ):
        with pytest.raises(ValueError, match=re.escape(text)):
            ride.set(name, value)


def test_a_ride_is_saved_as_a_page(ride):
    with looking(ride) as line:
        heard(line, lambda said: is_frame(said) and said[0] > 30 * PERIOD)
        line.say(do="save")
        heard(line, lambda said: not is_frame(said) and said["ride"] == 1 and not said["saving"])
        cookie = knock(ride.url)[1]["Set-Cookie"].partition(";")[0]
        assert knock(ride.url.partition("?")[0] + "ride-1.html", Cookie=cookie)[0] == 200
        page = ride._pages["/ride-1.html"]
        assert "crane &lt;b&gt;" in page and "angle of pin" in page and "reaction force" in page
        line.say(do="save")
        heard(line, lambda said: not is_frame(said) and said["ride"] == 2)
        assert sorted(ride._pages) == ["/", "/ride-2.html"]  # one is kept


def test_a_saved_ride_is_seen_from_where_it_was():
    with crane().play(RANGES, view=(70.0, 35.0)) as made, looking(made) as line:
        heard(line, lambda said: is_frame(said) and said[0] > 3 * PERIOD)
        run = made.solution()
        saved = ride_so_far(run, None, made._look)
    assert saved == run.animate(view=(70.0, 35.0)).html != run.animate().html


def test_a_ride_that_cannot_be_saved_is_told(ride):
    with looking(ride, watch=False) as line:
        line.say(do="save")
        said = heard(line, lambda said: not is_frame(said) and said["note"])
        assert said["note"].startswith("the ride was not saved: the solution has no samples") and said["ride"] == 0


def test_a_port_in_use_is_refused(ride):
    port = int(re.search(r":(\d+)/", ride.url)[1])
    threads = threading.active_count()
    with pytest.raises(ValueError, match=f"port {port} cannot be used: .*; give another one, or 0 for any"):
        crane().play(port=port)
    assert threading.active_count() == threads
    for wrong in (-1, 70000, 80.5, "http", True):
        with pytest.raises(ValueError, match="give a whole number up to 65535"):
            crane().play(port=wrong)
    with pytest.raises(ValueError, match="'car' is not one of the bodies of this system"):
        crane().play(follow="car")


def test_a_slow_browser_gets_the_newest(ride):
    """What it does not take is not piled up: one frame and one text wait for it at most."""

    async def fed():
        sent, gate = [], asyncio.Event()

        class Line:
            async def send(self, piece):
                await gate.wait()
                sent.append(piece)

        made = Outlet()
        task = asyncio.create_task(made.feed(Line()))
        for k in range(100):
            made.put(f"{k}" if k < 50 else "", struct.pack("<d", k))
            await asyncio.sleep(0)
        gate.set()
        await asyncio.sleep(0.01)
        task.cancel()
        return sent

    assert asyncio.run(fed()) == ["0", struct.pack("<d", 0), "49", struct.pack("<d", 99)]


def test_the_first_view_holds_what_may_swing_up():
    """Round the one point of the ground that all hangs on; a rail, two points and wheels hold no such ball."""
    low, high = np.array([-0.1, 0.2, -0.9]), np.array([0.3, 0.4, 0.1])
    arm = Body("arm", 1.0, (0.1, 0.1, 0.1), position=(0.1, 0.3, -0.4))
    pin, end = (Revolute(GROUND, arm, at=(0.2, 0.3, z), axis=(0, 1, 0)) for z in (0.0, -0.8))
    axes, ball = directions((30.0, 20.0)), np.linalg.norm((0.3, 0.1, 0.9))
    seen = swing(pivot_of(System([arm], [pin])), low, high, axes)
    camera = sight(*seen.seen, axes, FIELD_OF_VIEW).camera()
    assert np.allclose(camera.look_at, pin.at)
    assert ball < camera.distance * np.sin(0.5 * FIELD_OF_VIEW) < 1.1 * ball  # with little air
    assert pivot_of(System([arm], [pin, end])) is None and pivot_of(crane()) is None
    assert pivot_of(System([arm], [], [Torque(arm, (0, 0, 1))])) is None


# a real browser


@pytest.fixture(scope="module")
def tab(chromium):
    """A page of a ride with the camera going along, and the ride."""
    with crane(name="crane").play(RANGES, follow="trolley", dark=False) as ride:
        with visit(chromium, ride.url, width=480, height=320) as seen:
            seen.wait(READY)
            yield seen, ride
            assert seen.complaints == []


def place_of(seen, body):
    """Position of a body in the scene [m]."""
    return np.array(
        seen.run(f"Array.from(__viserMutable.nodePoseData['/bodies/{body}'].position, (x) => x / mbsd3d.data.scale)")
    )


@pytest.mark.slow
def test_keys_are_pressed_and_released(tab):
    seen, ride = tab
    keyboard = seen.page.keyboard
    for key, name, value, rest in (
        ("ArrowRight", "push", 6.0, 0.4), ("ArrowLeft", "push", -6.0, 0.4), ("l", "push", 6.0, 0.4),
        ("ArrowUp", "twist", 2.5, 0.0), ("k", "twist", -1.5, 0.0),
    ):  # fmt: skip
        keyboard.down(key)
        assert until(lambda name=name, value=value: ride.values[name] == value)
        keyboard.down(key)  # a key that repeats
        keyboard.up(key)
        assert until(lambda name=name, rest=rest: ride.values[name] == rest)
    keyboard.down("l")
    keyboard.down("ArrowUp")
    assert until(lambda: ride.values == {"push": 6.0, "twist": 2.5})
    seen.run("window.dispatchEvent(new Event('blur'))")  # another window has the keys now
    assert until(lambda: ride.values == {"push": 0.4, "twist": 0.0})
    keyboard.up("l")
    keyboard.up("ArrowUp")


PAD = """(pads) => {
    window.pads = pads.map((pad) => ({...pad, connected: true, buttons: Array.from({length: 17}, () => ({value: 0}))}));
    navigator.getGamepads = () => [null, ...window.pads];
    window.dispatchEvent(new Event("gamepadconnected"));
}"""


@pytest.mark.slow
def test_a_gamepad_goes_its_share_of_the_way(tab):
    seen, ride = tab
    at_rest = {"mapping": "standard", "axes": [0.03, -0.04, 0.0, 0.0]}
    other = {"id": "joystick", "mapping": "", "axes": [1.0, 1.0]}  # of no known layout: not used
    seen.run(PAD, [{"id": "pad", **at_rest}, other])
    line = seen.page.locator("#pads")
    assert line.text_content() == (
        "pad: left stick: push, left stick up: twist; joystick: not of the standard layout, so it is not used"
    )
    for axes, push, twist in (
        ([1.0, 0.0], 6.0, 0.0), ([-1.0, -1.0], -6.0, 2.5), ([0.55, 0.55], 3.2, -0.75), ([0.0, 0.0], 0.4, 0.0)
    ):  # fmt: skip
        seen.run("axes => window.pads[0].axes = [...axes, 0, 0]", axes)
        wanted = pytest.approx({"push": push, "twist": twist}, abs=1e-12)
        assert until(lambda wanted=wanted: ride.values == wanted)
    ride.set("push", 2.0)  # a stick at rest holds nothing
    assert until(lambda: ride.values["push"] == 2.0)
    seen.run("window.pads[0].axes = [1, 0, 0, 0]")
    assert until(lambda: ride.values["push"] == 6.0)
    seen.run("window.pads = []; window.dispatchEvent(new Event('gamepaddisconnected'))")
    assert until(lambda: ride.values["push"] == 2.0) and line.is_hidden()
    ride.set("push", 0.4)


@pytest.mark.slow
def test_the_scene_moves_as_the_model_does(tab):
    seen, ride = tab
    seen.page.keyboard.press("Space")
    assert until(lambda: not ride._playing.running)
    state = ride._playing.segments.state.q.reshape(2, 7)
    seen.wait("x => Math.abs(mbsd3d.drawn - x) < 1e-9", ride.t)
    seen.run(SETTLED)
    for body in (0, 1):
        assert place_of(seen, body) == pytest.approx(state[body, :3], abs=1e-6)
    assert seen.page.locator("#pace").text_content() == "paused"
    assert float(seen.page.locator("#time").text_content()[4:-2]) == pytest.approx(ride.t, abs=0.006)
    seen.page.locator("#play").click()
    assert until(lambda: ride._playing.moving)


@pytest.mark.slow
def test_the_page_survives_a_reload(tab):
    seen, ride = tab
    slider = seen.page.get_by_role("slider", name="twist")
    slider.fill("1.5")
    assert until(lambda: ride.values["twist"] == 1.5)
    before = ride.t
    seen.page.reload()
    seen.wait(READY)
    assert float(slider.input_value()) == pytest.approx(1.5, abs=2e-3) and ride.values["twist"] == 1.5
    seen.wait("t => mbsd3d.last !== null && mbsd3d.last[0] > t", before)
    assert seen.run("mbsd3d.frames") > 1  # the curves go on
    slider.dblclick(position={"x": 3, "y": 3})
    assert until(lambda: ride.values["twist"] == 0.0)


@pytest.mark.slow
def test_buttons_reset_slow_down_and_save(tab):
    seen, ride = tab
    before = ride.t
    seen.page.get_by_role("button", name="reset", exact=True).click()
    assert until(lambda: ride.t < before)
    seen.page.locator("#speed").select_option("0.1")
    assert until(lambda: ride._playing.pace == 0.1)
    with seen.page.expect_download() as waiting:
        seen.page.get_by_role("button", name="save the ride").click()
    assert waiting.value.suggested_filename == "crane.html"
    seen.page.locator("#speed").select_option("1")
    assert until(lambda: ride._playing.pace == 1.0)


@pytest.mark.slow
def test_the_page_says_when_it_was_stopped(tab):  # the last one: it ends the ride of the others
    seen, ride = tab
    ride.stop()
    seen.page.get_by_text("The ride has ended").wait_for()
    errors = [text for text in seen.complaints if "ERR_CONNECTION_REFUSED" not in text]
    assert errors == []
    seen.errors.clear()
