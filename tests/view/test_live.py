"""The live view: quiet, moved by its clock, driven by a real browser, and gone when it is stopped."""

import re
import socket
import threading
import time

import numpy as np
import pytest
from helpers.browser import visit
from helpers.double_pendulum import LOWER_ARM, pendulum
from helpers.live_views import connected, knock, listens, until

from mbsd3d import Body, System, simulate
from mbsd3d.view.page import html, live, served
from mbsd3d.view.page.live import LiveView, mixed, place

NODE = "window.__viserMutable.nodePoseData['/bodies/1']"


@pytest.fixture(scope="module")
def solution():
    """Two seconds of a general mechanism."""
    return simulate(pendulum(), 2.0, output=101)


@pytest.fixture
def view(solution):
    """A running view."""
    with solution.animate(live=True, title="pendulum", shown=["reaction force"]) as view:
        yield view


def test_times_lie_between_frames():
    t = np.array([1.0, 1.5, 2.0])
    assert place(t, 1.0) == (0, 0.0) and place(t, 1.75) == (1, 0.5) and place(t, 2.0) == (1, 1.0)
    assert place(t[:1], 1.0) == (0, 0.0)
    values = np.array([[0.0, 2.0], [1.0, 4.0], [5.0, 4.0]])
    assert mixed(values, 1, 0.25).tolist() == [2.0, 4.0] and mixed(values, 2, 0.0).tolist() == [5.0, 4.0]


def test_it_says_nothing_and_leaves_nothing(solution, capfd):
    threads = threading.active_count()
    view = solution.animate(live=True)
    assert isinstance(view, LiveView) and listens(view.url) and view.url.startswith("http://127.0.0.1:")
    assert repr(view) == f"<live view: {view.url}>"
    view.stop()
    view.stop()  # twice does no harm
    assert not listens(view.url) and repr(view).endswith("(stopped)>")
    assert until(lambda: threading.active_count() <= threads)
    assert capfd.readouterr() == ("", "")


def test_time_passes_and_starts_again(view, solution):
    assert view.playing and view.speed == 1.0
    view.speed = 20.0
    seen = set()
    assert until(lambda: seen.add(view.time) or (2.0 in seen and len(seen) > 4 and view.time < max(seen)))
    assert min(seen) >= 0.0 and max(seen) == 2.0  # the last picture is shown before the first one comes again
    view.playing = False
    time.sleep(3 * live.FRAME_SECONDS)  # a picture that is being made
    before = view.time
    time.sleep(3 * live.FRAME_SECONDS)
    assert view.time == before


def test_wait_ends_with_ctrl_c(view, monkeypatch):
    def interrupted(_: float) -> bool:
        raise KeyboardInterrupt

    ended = threading.Event()
    monkeypatch.setattr(view._ended, "wait", interrupted)
    monkeypatch.setattr(view._thread, "join", lambda: None)  # its clock was interrupted too
    threading.Thread(target=lambda: (view.wait(), ended.set()), daemon=True).start()
    assert ended.wait(10.0) and not listens(view.url)


@pytest.mark.parametrize("variables", [{}, {"DISPLAY": ":0"}])
def test_open_says_where_there_is_no_browser(view, monkeypatch, variables):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(html.sys, "platform", "linux")
    monkeypatch.setattr(served.webbrowser, "get", lambda: None)
    monkeypatch.setattr(served.webbrowser, "open", lambda url: False)
    with pytest.raises(ValueError, match=re.escape(f"no browser was found on this machine; open {view.url} in one")):
        view.open()


def test_a_missing_package_is_named(solution, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "viser", None)
    with pytest.raises(
        ValueError, match=r"a live view needs viser 1.1.x, found none; install it: pip install 'viser==1.1.\*'"
    ):
        solution.animate(live=True)


def test_the_reference_pose_has_no_player(solution):
    with solution.system.show(live=True) as view:
        assert not view.playing and view._panel.slider is None and listens(view.url)


def test_any_name_can_be_shown():
    strange = Body("</script> \ud800 \"'\u00fc/x", 1.0, (1, 2, 2), omega=(1, 2, 3))
    with simulate(System([strange]), 2.0, output=5).animate(live=True, title="\ud800<b>") as view:
        assert until(lambda: view.time > 0.1) and listens(view.url)


def test_hidden_arrows_are_moved_when_they_are_shown(view):
    view.playing = False
    view.time = 1.5
    assert until(lambda: view._shown == 1.5)
    spin = view._stage.arrows[0]
    before = spin.batched_positions.copy()
    view._panel.switches["angular velocity"].value = True
    assert until(lambda: not np.array_equal(spin.batched_positions, before))


@pytest.mark.slow
def test_a_browser_sees_it_move_and_pauses_it(chromium, view, solution):
    view.speed = 0.2
    with visit(chromium, view.url, width=700, height=240) as seen:
        seen.wait(f"window.__viserMutable && {NODE} && document.querySelector('.uplot')")
        first = seen.run(f"{NODE}.position")
        seen.wait(f"p => Math.hypot(...{NODE}.position.map((x, i) => x - p[i])) > 1e-3", first)
        seen.page.get_by_role("button", name="Pause").click()
        assert until(lambda: not view.playing)
        seen.page.get_by_role("button", name="Play").wait_for()
        time.sleep(0.5)  # the last picture is on its way
        k = np.searchsorted(solution.t, view.time) - 1
        scale = view._stage.scale
        x = seen.run(f"Array.from({NODE}.position)")
        samples = solution.position(LOWER_ARM)[[k, k + 1]] * scale
        margin = 1e-3 * scale  # frames and samples are cut differently
        assert (x >= samples.min(axis=0) - margin).all() and (x <= samples.max(axis=0) + margin).all()
        seen.page.get_by_role("button", name="Play").click()
        assert until(lambda: view.playing)
        assert seen.complaints == []


def test_only_the_whole_address_opens_it(view):
    bare = view.url.partition("?")[0]
    port = view.url.partition("/?")[0].rpartition(":")[2]
    status, head = knock(view.url)
    assert status == 200 and "HttpOnly; SameSite=Strict" in head["Set-Cookie"]
    cookie = head["Set-Cookie"].partition(";")[0]
    assert knock(bare)[0] == 403 and knock(bare + "?token=x")[0] == 403
    assert knock(bare, Cookie=cookie)[0] == 200 and knock(bare, Cookie=cookie + "x")[0] == 403
    assert knock(view.url, Host="evil.example")[0] == 403 and knock(view.url, Host=f"evil.example:{port}")[0] == 403
    assert knock(view.url, Origin="http://evil.example")[0] == 403 and knock(view.url, Origin="null")[0] == 403
    assert knock(view.url, Origin=f"http://127.0.0.1:{port}")[0] == 200


def test_another_page_gets_no_scene(view):
    socket_headers = {
        "Upgrade": "websocket",
        "Sec_WebSocket_Version": "13",
        "Sec_WebSocket_Key": "eHh4eHh4eHh4eHh4eHh4eA==",
    }
    socket_headers |= {"Connection": "Upgrade", "Sec_WebSocket_Protocol": "viser-v1.1.1"}
    cookie = knock(view.url)[1]["Set-Cookie"].partition(";")[0]
    bare = view.url.partition("?")[0]
    assert knock(bare, **socket_headers)[0] == 403
    assert knock(bare, Origin="http://evil.example", Cookie=cookie, **socket_headers)[0] == 403
    assert knock(bare, Cookie=cookie, **socket_headers)[0] == 101


def test_two_hosts_are_refused(view):
    """What is served by viser stands behind the same guard."""
    host, port = re.fullmatch(r"http://(.+):(\d+)/.*", view.url).groups()
    for second in (f"{host}:{port}", "evil.example"):
        with socket.create_connection((host, int(port)), timeout=10) as line:
            line.sendall(f"GET / HTTP/1.1\r\nHost: {host}:{port}\r\nHost: {second}\r\n\r\n".encode())
            assert line.recv(4096).startswith(b"HTTP/1.1 400")


def test_it_stops_with_open_connections(solution, capfd):
    view = solution.animate(live=True)
    url, open_ones = view.url, connected(view)
    view.stop()  # how fast: tests/timing
    assert not listens(url)
    for one in open_ones:
        one.close_socket()
    said = capfd.readouterr()
    assert "Traceback" not in said.err and said.out == ""
