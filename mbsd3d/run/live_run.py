"""A live run: a model that moves in real time, in a thread of its own, while its controls change."""

import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from typing import NamedTuple, TypeVar

import numpy as np

from ..base.errors import MbsError
from ..base.progress import Progress
from ..results.record import RunOptions
from ..results.result import RunResult, unit_quaternions
from .live_model import Built, Playable, Seen
from .segments import Segments

T = TypeVar("T")
PERIOD = 1.0 / 60.0  # [s] from one frame to the next
LONGEST = 10 * 60 * 60  # frames that are kept: ten minutes; then a new run begins
WINDOW = 60  # frames over which it is seen whether the model keeps up


class Frame(NamedTuple):
    """Poses of the moving bodies at one time."""

    t: float  # [s]
    late: int  # frames that came after the next one was due
    share: float  # of the pace asked for that is reached
    seen: Seen
    poses: np.ndarray  # (n, 7) r [m], e


class GivenUpError(Exception):
    """Raised when a live run is stopped within a segment."""


class Patience(Progress):
    """Progress display that stops a segment whose result is no longer needed."""

    def __init__(self) -> None:
        super().__init__("", 0.0, 1.0, False)
        self.over = threading.Event()

    def update(self, now: float) -> None:
        """Raise a GivenUpError once the time is up."""
        if self.over.is_set():
            raise GivenUpError


class Playing:
    """A model at its start; `start` lets it move: a segment of ``pace / 60`` s every 1/60 s.

    A frame that is ready after the next one was due is late: the clock of the model then waits for it.

    ``values`` are those of the controls, ``held`` those of pressed keys, which go first. Methods are called in the
    thread, by `do`.

    Raises
    ------
    MbsError
        If the model, its state or its first segment cannot run.
    """

    def __init__(self, model: Playable, options: RunOptions) -> None:
        self.model, self.options = model, options
        self.values = {control.name: control.value for control in model.controls}
        self.held: dict[str, float] = {}
        self.running, self.pace, self.late, self.note = True, 1.0, 0, ""
        self.watched, self.over, self.patience = False, False, Patience()
        self.wishes: deque[tuple[Future, Callable]] = deque()
        self.reached: deque[tuple[float, float]] = deque(maxlen=WINDOW)  # clock, time of the model
        self.builds = [control.name for control in model.controls if control.builds]
        trial = self.segments_of(model.built(self.values, None))  # compiles, and finds what cannot run
        trial.advance(trial.t + PERIOD)
        self.begin(model.built(self.values, None))
        self._ended = threading.Event()
        self._thread: threading.Thread | None = None

    def start(self, publish: Callable[[Frame], None]) -> None:
        """Start the thread; ``publish`` gets every frame in it."""
        thread = threading.Thread(target=self._run, args=(publish,), name="mbsd3d play", daemon=True)
        self._thread = thread
        thread.start()

    def stop(self) -> None:
        """End the thread, within the work of 0.05 s."""
        self._ended.set()
        self.patience.over.set()
        if self._thread is not None:
            self._thread.join()
        self.grant()

    def do(self, what: Callable[..., T], *arguments: object) -> "Future[T]":
        """Call a method between two segments; the future gets its return value or exception."""
        future: Future[T] = Future()
        self.wishes.append((future, lambda: what(*arguments)))
        if self._thread is not None and not self._thread.is_alive():
            self.grant()
        return future

    def _run(self, publish: Callable[[Frame], None]) -> None:
        """Publish frame by frame until the run is stopped."""
        due = time.perf_counter()
        while not self._ended.wait(max(due - time.perf_counter(), 0.0)):
            publish(self.frame())
            due += PERIOD
            if (now := time.perf_counter()) > due:
                self.late, due = self.late + self.moving, now

    def frame(self) -> Frame:
        """Apply the pending commands, integrate one segment and return the new frame."""
        self.grant()
        if self.moving:
            self.advance()
        segments = self.segments
        seen = self.model.seen(self.now, segments.measured)
        for name, value in seen.values.items():
            self.values[name] = self.built_with[name] = value
        if seen.over and self.running:
            self.end(seen.over)
        poses = unit_quaternions(segments.memory.y[: 7 * segments.model.body.size]).reshape(-1, 7)
        return Frame(segments.t, self.late, self.share(), seen, poses)

    @property
    def moving(self) -> bool:
        """Return whether time passes: the run goes on and a page is connected."""
        return self.running and self.watched

    @property
    def now(self) -> dict[str, float]:
        """Return the value of every control; pressed keys go first."""
        return self.values | self.held

    def share(self) -> float:
        """Return the share of the pace that is reached, over the last frames."""
        if not self.moving or len(self.reached) < WINDOW:
            return 1.0
        (clock, t), (last, now) = self.reached[0], self.reached[-1]
        return min((now - t) / (self.pace * (last - clock)), 1.0)

    def advance(self) -> None:
        """Set the inputs and integrate one segment."""
        segments = self.segments
        try:
            for name, value in self.model.inputs(self.now, segments.measured).items():
                segments.set(name, value)
            segments.advance(segments.t + self.pace * PERIOD)
        except GivenUpError:
            self.patience.over.clear()
        except MbsError as error:
            self.end(str(error))
        self.reached.append((time.perf_counter(), segments.t))
        if segments.samples.count + int(segments.memory.now["written"]) > LONGEST:
            self.begin(self.built._replace(state=segments.state))

    def segments_of(self, built: Built) -> Segments:
        """Return a run in segments of a model."""
        return Segments(built.system, built.state, self.options, built.measures)

    def begin(self, built: Built) -> None:
        """Begin a new run with a model."""
        segments = self.segments_of(built)
        segments.progress, self.built = self.patience, built
        self.segments, self.since, self.built_with = (
            segments,
            segments.t,
            {name: self.now[name] for name in self.builds},
        )
        self.reached.clear()

    def grant(self) -> None:
        """Apply the commands given since the last segment."""
        while self.wishes:
            future, what = self.wishes.popleft()
            try:
                future.set_result(what())
            except Exception as error:
                self.note = str(error)
                future.set_exception(error)
        changed = [name for name in self.builds if self.now[name] != self.built_with[name]]
        if changed and not self.over:
            try:
                self.begin(self.model.built(self.now, self.segments.state))
            except MbsError as error:  # it stays as it was
                self.note = str(error)
                self.values |= self.built_with
                self.held = {name: value for name, value in self.held.items() if name not in changed}

    def set(self, name: str, value: float) -> None:
        """Give a control a value."""
        self.values[name] = value

    def hold(self, name: str, value: float | None) -> None:
        """Give a control a value as long as a key is pressed; None = it is released."""
        self.held.pop(name, None)
        if value is not None:
            self.held[name] = value

    def run(self, on: bool) -> None:
        """Resume or pause the run."""
        self.running = on and not self.over
        self.reached.clear()

    def watch(self, on: bool) -> None:
        """Resume the run when a page connects; pause it when the last one disconnects."""
        self.watched = on
        self.reached.clear()

    def slow(self, pace: float) -> None:
        """Set the seconds of the model per second."""
        self.pace = pace
        self.reached.clear()

    def reset(self) -> None:
        """Restart from the initial state with the present controls."""
        self.begin(self.model.built(self.now, None))
        self.running, self.over, self.note, self.late = True, False, "", 0

    def end(self, why: str) -> None:
        """Mark the run as ended until it is reset."""
        self.running, self.over, self.note = False, True, why

    def result(self) -> RunResult:
        """Return the run since `since`: since the start, or since the model was made anew."""
        return self.segments.solution()
