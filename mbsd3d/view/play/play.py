"""Model that moves in real time while a browser shows it and changes its inputs."""

import json
import math
from collections import deque
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ...base.checks import number
from ...base.checks import short_repr as shown_text
from ...base.errors import InputError, MbsError
from ...base.progress import Progress
from ...mechanism.mechanism import Mechanism
from ...plotting.panels import Wanted
from ...results.motion import Motion
from ...results.result import RunResult
from ...run.live_run import PERIOD, Frame, Playing
from ..page.served import Served
from ..page.show import MotionOptions, motion_content, page_of
from ..scene.drawing import DEFAULT_LAYERS, Layers
from .play_page import NO_SHAPES, SECONDS, Look, ride_page, shapes_of
from .server import Server

PACE_RANGE = (0.01, 10.0)  # [s/s] of the model in a second
SLOW_LOOK_INTERVAL_FRAMES = 6  # [frames] from one look at what seldom changes to the next
Moment = tuple[float, *tuple[float | None, ...]]  # time [s] and curves; None: not finite


class Play(Served):
    """Live run in a browser; see `mbsd3d.api.playing.Play`."""

    kind = "play"

    def __init__(self, playing: Playing, look: Look, port: int) -> None:
        super().__init__()
        self._playing, self._look = playing, look
        self._controls = {control.name: control for control in playing.model.controls}
        self._history: deque[Moment] = deque(maxlen=round(SECONDS / PERIOD))
        self._told, self._count, self._ride, self._saving = "", 0, 0, False
        self._good: Mapping[str, Sequence[tuple[float, float]]] = {}
        self._drawn, self._shapes = playing.built.system, NO_SHAPES
        self._drawings = shapes_of(self._drawn) if playing.builds else NO_SHAPES
        self._pages = {"/": ride_page(playing.model, playing.built, look)}
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="mbsd3d play pages")
        self._server = Server(port, self._token, self._pages, self._greeting, self._hear, self._leave)
        self.port = self._server.port
        playing.start(self._publish)

    @property
    def t(self) -> float:
        """Return the time reached so far [s]."""
        return self._playing.segments.t

    @property
    def late(self) -> int:
        """Return the number of frames since the start or a reset that were ready after the next one was due."""
        return self._playing.late

    @property
    def values(self) -> dict[str, float]:
        """Return the values of the inputs now, by name."""
        return self._playing.now

    def set(self, name: str, value: float) -> None:
        """Set the value of an input, as its slider does.

        Raises
        ------
        ValueError
            If there is no such input here, or the value is not within its range.
        """
        if name not in self._controls:
            have = ", ".join(f"'{x}'" for x in self._controls) or "none"
            raise InputError(f"play: {shown_text(name)} has no slider; there are {have}")
        control, value = self._controls[name], number(value, f"play: '{name}'")
        if not control.low <= value <= control.high:
            raise InputError(f"play: '{name}' = {value:g} is not within {control.low:g} ... {control.high:g}")
        self._playing.do(self._playing.set, name, value).result()

    def reset(self) -> None:
        """Go back to the start."""
        self._playing.do(self._playing.reset).result()

    def solution(self) -> RunResult:
        """Return the run so far, of at most the last ten minutes, with a sample every 1/60 s."""
        return self._playing.do(self._playing.result).result()

    def _close(self) -> None:
        """Stop the model, then the server."""
        self._playing.stop()
        self._worker.shutdown(wait=False, cancel_futures=True)
        self._server.stop()

    def _publish(self, frame: Frame) -> None:
        """Send a frame, and news if there are any; called in the thread of the model."""
        curves = np.asarray(frame.seen.curves, float)
        self._remember(frame.t, curves)
        self._good = frame.seen.good
        if (system := self._playing.built.system) is not self._drawn:
            self._drawn = system
            self._worker.submit(self._redraw, system)
        self._count += 1
        news = self._news() if self._count % SLOW_LOOK_INTERVAL_FRAMES == 0 else ""
        self._told, news = news or self._told, news if news != self._told else ""
        head = [frame.t, frame.late, frame.share]
        self._server.publish(news, np.concatenate([head, curves, frame.poses.ravel()]).astype("<f8").tobytes())

    def _remember(self, t: float, curves: np.ndarray) -> None:
        """Keep the curves for browsers that open the page later."""
        if self._history and self._history[-1][0] > t:  # it was reset
            self._history.clear()
        if not self._history or self._history[-1][0] < t:
            self._history.append((t, *(x if math.isfinite(x) else None for x in curves.tolist())))

    def _state(self) -> dict[str, object]:
        """Return the values that seldom change."""
        playing = self._playing
        return {
            "values": playing.values, "held": playing.held, "good": self._good, "shapes": self._shapes,
            "running": playing.running, "over": playing.over, "pace": playing.pace, "note": playing.note,
            "since": playing.since, "ride": self._ride, "saving": self._saving,
        }  # fmt: skip

    def _news(self, **more: object) -> str:
        """Return what has changed, as JSON."""
        return json.dumps(self._state() | more, allow_nan=False)

    def _greeting(self) -> str:
        """Return what a browser needs that has just connected."""
        return self._news(history=list(self._history))

    def _hear(self, said: str) -> bool:
        """Obey a message of a browser, in the thread of the server; return False if it makes no sense."""
        playing, do = self._playing, self._playing.do
        match parsed(said):
            case {"set": str(name), "to": float(x)} if name in self._controls:
                do(playing.set, name, self._clipped(name, x))
            case {"hold": str(name), "to": float(x)} if name in self._controls:
                do(playing.hold, name, self._clipped(name, x))
            case {"hold": str(name), "to": None} if name in self._controls:
                do(playing.hold, name, None)
            case {"run": bool(on)}:
                do(playing.run, on)
            case {"watch": True}:
                do(playing.watch, True)
            case {"pace": float(x)} if PACE_RANGE[0] <= x <= PACE_RANGE[1]:
                do(playing.slow, x)
            case {"do": "reset"}:
                do(playing.reset)
            case {"do": "save"} if not self._saving:
                self._saving = True
                self._worker.submit(self._save)
            case _:
                return False
        return True

    def _clipped(self, name: str, value: float) -> float:
        """Return the value within the range of a control."""
        control = self._controls[name]
        return min(max(value, control.low), control.high)

    def _leave(self, last: bool) -> None:
        """Release the keys of a browser that has gone; after the last one the model waits for another."""
        self._playing.do(self._playing.held.clear)
        if last:
            self._playing.do(self._playing.watch, False)

    def _redraw(self, system: Mechanism) -> None:
        """Send the shapes of bodies that differ from those of the page."""
        if system is self._drawn:  # no newer one waits
            found = shapes_of(system)
            self._shapes = {name: shape for name, shape in found.items() if shape != self._drawings.get(name)}

    def _save(self) -> None:
        """Make a page of the run, which the browser then asks for."""
        try:
            page = ride_so_far(self.solution(), self._playing.built.curves, self._look)
        except MbsError as error:
            self._playing.note = f"the ride was not saved: {error}"
        else:
            self._pages.pop(f"/ride-{self._ride}.html", None)
            self._ride += 1
            self._pages[f"/ride-{self._ride}.html"] = page
        finally:
            self._saving = False


def ride_so_far(solution: Motion, curves: Wanted | None, look: Look) -> str:
    """Return a page of the run that needs no server."""
    follow = solution.system.bodies[look.followed] if look.followed >= 0 else None
    hidden = [layer for layer in (*DEFAULT_LAYERS, "body names") if layer not in look.layers]
    layers = Layers(look.layers, hidden)
    options = MotionOptions(layers, curves, title=look.title, follow=follow, view=look.view)
    with Progress("page", 0.0, 6.0) as progress:
        return page_of(motion_content(solution, options, progress), look.dark, "solution.animate").html


def parsed(said: str) -> object:
    """Parse JSON with finite numbers, all of them floats; return None for anything else."""
    try:
        return json.loads(said, parse_int=float, parse_constant=refused)
    except (ValueError, RecursionError):
        return None


def refused(word: str) -> None:
    """Refuse NaN and Infinity as numbers."""
    raise InputError(f"{word} is not finite")
