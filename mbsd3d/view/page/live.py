"""Live view served on this machine: the scene of the page, moved from Python, with viser's own panel.

`LiveView` holds the server and the thread that moves the scene; `mbsd3d.view.page.panel` makes its panel.
"""

import logging
import threading
import time
from typing import TYPE_CHECKING

import numpy as np

from .content import Content
from .guard import Visitors, guarded_serving
from .panel import Panel
from .recorder import import_viser, printable
from .served import HOST, Served
from .stage import Stage

if TYPE_CHECKING:
    from viser import ViserServer

FRAME_SECONDS = 1.0 / 30.0  # [s] from frame to frame


class LiveView(Served):
    """A running view; a context manager that stops it at its end.

    ``playing``, ``speed`` (seconds of the run per second) and ``time`` (shown [s]) can be read and set::

        with solution.animate(live=True) as view:
            view.open()
            view.wait()
    """

    kind = "live view"

    def __init__(self, content: Content, dark: bool | None = None) -> None:
        super().__init__()
        frames, self._content = content.frames, content
        self.playing, self.speed, self.time = frames.t.size > 1, content.speed, float(frames.t[0])
        self._shown: float | None = None  # time of the picture; None = make it anew
        self._visitors = Visitors()
        self._server = quiet_server(self._token, self._visitors)
        self.port = self._server.get_port()
        try:
            scene, camera, gui = self._server.scene, self._server.initial_camera, self._server.gui
            self._stage = Stage(scene, camera, *content[:4], content.shown, view=content.view)
            self._paths = [(node, node.points) for node in self._stage.traces]
            gui.set_panel_label(printable(content.title))
            gui.configure_theme(dark_mode=bool(dark), show_logo=False, show_share_button=False)
            self._panel = Panel(gui, self, self._stage, content, bool(dark))
        except BaseException:
            self._server.stop()
            raise
        self._thread = threading.Thread(target=self._run, name="mbsd3d live view", daemon=True)
        self._thread.start()

    def _close(self) -> None:
        """Stop the thread, then the server."""
        self._thread.join()
        self._server.get_event_loop().call_soon_threadsafe(self._visitors.dismiss)
        self._server.stop()

    def refresh(self) -> None:
        """Redraw the scene after other layers became visible."""
        self._shown = None

    def _run(self) -> None:
        """Advance and show the time until stopped."""
        before = time.perf_counter()
        while not self._ended.wait(FRAME_SECONDS):
            now = time.perf_counter()
            if self.playing:
                self.time = self._later(self.time + self.speed * (now - before))
            before = now
            if self.time != self._shown:
                self._shown = self.time
                with self._server.atomic():
                    self._show(self._shown)

    def _later(self, t: float) -> float:
        """Return the next time, from the start again after the end."""
        first, last = float(self._content.frames.t[0]), float(self._content.frames.t[-1])
        return first if t > last and self.time >= last else min(t, last)

    def _show(self, t: float) -> None:
        """Move the scene to a time; traces grow in whole frames."""
        k, share = place(self._content.frames.t, t)
        r, e = (mixed(values, k, share) for values in (self._content.frames.r, self._content.frames.e))
        self._stage.move(r, e / np.linalg.norm(e, axis=1, keepdims=True))
        for i, arrows in enumerate(self._content.arrows):
            if self._panel.shown(arrows.kind):
                self._stage.point(i, mixed(arrows.points, k, share), mixed(arrows.vectors, k, share))
        for node, points in self._paths:
            node.points = points[: k + 1]
        self._panel.show(t)


def place(t: np.ndarray, now: float) -> tuple[int, float]:
    """Return the frame before a time, and the share of the way to the next one."""
    k = int(np.clip(np.searchsorted(t, now, side="right") - 1, 0, max(t.size - 2, 0)))
    return k, float((now - t[k]) / (t[k + 1] - t[k])) if t.size > 1 else 0.0


def mixed(values: np.ndarray, k: int, share: float) -> np.ndarray:
    """Interpolate linearly between two frames."""
    return (1.0 - share) * values[k] + share * values[k + 1] if share else values[k]


def quiet_server(token: str, visitors: Visitors) -> "ViserServer":
    """Return a guarded server of viser on a free port that writes nothing to the terminal."""
    viser = import_viser("a live view")
    import rich  # which viser brings

    console = rich.get_console()
    logging.getLogger("websockets").addHandler(logging.NullHandler())  # tracebacks of those who hang up
    logging.getLogger("websockets").propagate = False
    with console.capture(), guarded_serving(token, visitors):
        server = viser.ViserServer(host=HOST, port=0, verbose=False)
    server.get_event_loop().call_soon_threadsafe(console.begin_capture)  # what its own thread says at the end
    return server
