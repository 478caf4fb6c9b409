"""Workers for cells: threads, processes that may die, or any other `concurrent.futures.Executor`.

Threads are the batch: each drives the compiled loop of a single run, which holds no lock, while another one builds the
next system. One parallel loop over stacked models was measured as fast (178 against 172 ms for 128 engines, serial
316 ms, equal bits), but has to wait until all its systems are built.
"""

import gc
import multiprocessing
import os
import signal
import time
from collections import deque
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, ProcessPoolExecutor, ThreadPoolExecutor, wait
from contextlib import contextmanager
from functools import partial
from multiprocessing.connection import wait as wait_for_end
from threading import Thread
from typing import Any, NamedTuple

from ..base.checks import short_repr
from ..base.concurrency import Turns, keep_one_thread, one_thread_for_all, taking_turns
from ..base.errors import InputError, SweepError
from ..base.paths import drop_pieces
from ..base.wording import counted
from .experiment import Outcome

WORKER_DEATH_MESSAGE = (
    "WorkerDied: the process of this cell ended twice without a word (killed, out of memory, or os._exit); "
    "run the cell alone to see why"
)
KILLED_WORKER_NAME = "KilledWorker"  # of distributed, by its name: it may not be installed
WORKER_GRACE_SECONDS = 1.0  # [s] for a worker to end by itself
CELLS_IN_FLIGHT_MAX = 1000  # [1] tasks in flight on an executor of the user, whose workers are not known
BATCH_SECONDS = 0.02  # [s] of work that goes to a process at a time: to send a task costs some 0.4 ms
BATCHES_MIN = 64  # [1] batches at least into which the cells that are left are divided: workers end together
START_ADVICE = "put the call of sweep under if __name__ == '__main__':, since new processes import the script"


class Timed(NamedTuple):
    """Outcomes of several cells."""

    outcomes: list[Outcome]
    seconds: float  # s, of a cell


def outcomes(
    call: Callable, cells: list[dict], todo: list[int], executor: Any
) -> Generator[tuple[int, Outcome], None, None]:
    """Yield (cell, outcome) in the order in which cells finish."""
    if executor is None or executor == "threads":
        turns = Turns()
        with one_thread_for_all(), closing(ThreadPoolExecutor(cores(), "sweep"), turns.close) as pool:
            yield from stream(pool, partial(by_turns, turns, call), cells, deque(todo), 2 * cores(), deque())
    elif executor == "processes":
        yield from on_processes(call, cells, deque(todo))
    else:
        pool = executor if isinstance(executor, Executor) else executor.get_executor()
        left: deque[int] = deque(todo)
        suspects: deque[int] = deque()
        yield from stream(pool, call, cells, left, CELLS_IN_FLIGHT_MAX, left, suspects)
        again = partial(call)  # a cluster knows a task by its content, and would return the old answer
        yield from stream(pool, again, cells, suspects, 1, left)  # alone, only the culprit loses its worker again
        left.extend(suspects)
        if left:
            raise SweepError(
                f"the executor {type(executor).__name__} broke before {counted(len(left), 'cell')} had finished",
                advice="executor='processes' goes on with fresh processes and names the cell that killed one",
            )


def by_turns(turns: Turns, call: Callable, cell: dict) -> Outcome:
    """Run one cell; its Python code runs when it is the turn of this thread."""
    with taking_turns(turns):
        return call(cell)


def check_executor(executor: Any, functions: list[Callable]) -> None:
    """Raise ValueError for an unknown executor, and for functions that cannot go to another process."""
    if isinstance(executor, str) and executor == "processes":
        for function in functions:
            place = getattr(function, "__qualname__", "")
            if "<" in place:
                raise InputError(
                    f"sweep: {place} cannot go to another process; define it at the top of a module, or use threads"
                )
    elif executor is not None and not isinstance(executor, Executor):
        if not hasattr(executor, "get_executor") and not (isinstance(executor, str) and executor == "threads"):
            raise InputError(
                f"sweep: executor {short_repr(executor)}; give None, 'threads', 'processes', "
                "a concurrent.futures.Executor or a distributed.Client"
            )


def cores() -> int:
    """Return the number of cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def closing(pool: Executor, abandon: Callable[[], None] | None = None) -> Iterator[Executor]:
    """Close a pool at the end of the block; on an error running cells are abandoned: processes are told to end."""
    try:
        yield pool
    except BaseException:
        if abandon is not None:
            abandon()
        workers = list((getattr(pool, "_processes", None) or {}).values())  # public from Python 3.14 on
        pool.shutdown(wait=False, cancel_futures=True)
        for worker in workers:
            worker.terminate()
        for worker in workers:
            if not wait_for_end([worker.sentinel], WORKER_GRACE_SECONDS):
                worker.kill()
        raise
    pool.shutdown()


def stream(
    pool: Executor,
    call: Callable,
    cells: list[dict],
    queue: deque,
    window: int,
    lost: deque,
    suspects: deque | None = None,
) -> Generator[tuple[int, Outcome], None, None]:
    """Run the queue with at most ``window`` tasks in flight; if the pool breaks, those in flight go to ``lost``.

    A cluster blames every cell that its dead workers held, the culprit or not: these go to ``suspects`` where given.
    Of many cells several make a task, as soon as one has shown how long they take.
    """
    running: dict[Any, list[int]] = {}
    broken, seconds = False, 0.0  # s, of a cell; 0 = not known yet
    batched = len(queue) >= 2 * BATCHES_MIN and window > 1 and not isinstance(pool, ThreadPoolExecutor)
    try:
        while running or (queue and not broken):
            most = min(window, BATCHES_MIN) if batched and not seconds else window
            while queue and len(running) < most and not broken:
                size = min(int(BATCH_SECONDS / seconds), len(queue) // BATCHES_MIN) if batched and seconds else 1
                taken = [queue.popleft() for _ in range(max(size, 1))]
                task = (timed, call, [cells[i] for i in taken]) if batched else (call, cells[taken[0]])
                try:
                    future = pool.submit(*task)
                except RuntimeError:  # broken since the last look at it, or closed by its owner
                    queue.extendleft(reversed(taken))
                    broken = True
                    break
                running[future] = taken
                if future.done():
                    break
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                taken, error = running.pop(future), None if future.cancelled() else future.exception()
                if future.cancelled() or isinstance(error, BrokenExecutor):
                    lost.extend(taken)
                    broken = True
                elif isinstance(error, KeyboardInterrupt):
                    raise error
                elif suspects is not None and type(error).__name__ == KILLED_WORKER_NAME:
                    suspects.extend(taken)
                elif error is not None and len(taken) > 1:  # one of them: each alone will tell
                    queue.extendleft(reversed(taken))
                    batched = False
                elif error is not None:
                    yield taken[0], Outcome({}, f"{type(error).__name__}: {error}")
                else:
                    found = future.result()
                    if isinstance(found, Timed):
                        seconds = found.seconds
                        yield from zip(taken, found.outcomes, strict=True)
                    else:
                        yield taken[0], found
    finally:
        for future in running:
            future.cancel()


def timed(call: Callable, cells: list[dict]) -> Timed:
    """Run cells one after the other."""
    began = time.perf_counter()
    found = [call(cell) for cell in cells]
    return Timed(found, (time.perf_counter() - began) / len(cells))


def begin_worker() -> None:
    """Leave Ctrl-C to the parent, and end with it in every case."""
    told = []
    if os.name == "posix":  # elsewhere a process that is told to end is not asked
        reader, writer = os.pipe()
        os.set_blocking(writer, False)
        signal.set_wakeup_fd(writer)
        signal.signal(signal.SIGTERM, lambda *_: None)  # the thread answers: Python has no turn in the compiler
        told = [reader]
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    keep_one_thread()
    gc.freeze()  # what was imported is no garbage: cells allocate much, and would have it looked through each time
    Thread(target=end_in_time, args=(told,), daemon=True).start()


def end_in_time(told: list[int]) -> None:
    """End when told to, or with the parent, also by ``kill -9``: at once, and leave no file that is not whole."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait_for_end([parent.sentinel, *told])
        drop_pieces()
        os._exit(1)


class Deaf(ProcessPoolExecutor):
    """Process pool whose processes, which begin within `submit`, never receive Ctrl-C, not even before
    `begin_worker`."""

    def submit(self, *call: Any, **given: Any) -> Any:
        """Submit a call as `Executor.submit`, with Ctrl-C ignored."""
        if os.name != "posix":
            return super().submit(*call, **given)
        before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
        try:
            return super().submit(*call, **given)
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


def process_pool(workers: int) -> ProcessPoolExecutor:
    """Return a pool of spawned processes, in which threads and libraries start afresh."""
    return Deaf(workers, multiprocessing.get_context("spawn"), begin_worker)


def on_processes(call: Callable, cells: list[dict], queue: deque) -> Generator[tuple[int, Outcome], None, None]:
    """Run cells in own processes; those in flight when one dies are tried once more, each alone."""
    while queue:
        lost: deque[int] = deque()
        workers = min(cores(), len(queue))
        with closing(process_pool(workers)) as pool:
            start(pool, workers)
            yield from stream(pool, call, cells, queue, 2 * cores(), lost)
        yield from one_by_one(call, cells, lost)


def start(pool: Executor, workers: int) -> None:
    """Start all workers side by side, as each waiting task brings one more; raise SweepError where no task comes
    back."""
    try:
        for started in [pool.submit(cores) for _ in range(workers)]:
            started.result()
    except BrokenExecutor as error:
        raise SweepError("the worker processes do not start", advice=START_ADVICE) from error


def one_by_one(call: Callable, cells: list[dict], queue: deque) -> Generator[tuple[int, Outcome], None, None]:
    """Run each cell in a new process: a cell that kills it is the cause."""
    while queue:
        lost: deque[int] = deque()
        with closing(process_pool(1)) as pool:
            yield from stream(pool, call, cells, queue, 1, lost)
        for cell in lost:
            yield cell, Outcome({}, WORKER_DEATH_MESSAGE)
