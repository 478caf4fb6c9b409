"""Kernels that are compiled when they are first called: none earlier, each once, with the numbers of plain Python."""

import math
import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext
from typing import Annotated

import numba
import numpy as np
import pytest
from numba.core import types

from mbsd3d.compiler import first_run
from mbsd3d.compiler import late as module
from mbsd3d.compiler.decorators import inner_kernel, kernel, late_kernel
from mbsd3d.compiler.late import late_choice

pytestmark = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled")


@pytest.fixture
def compiled(monkeypatch):
    """Names of what has been compiled for a cell, in order."""
    found, plain = [], module.Late.compiled

    def noted(self, passed, number):
        found.append(self.kernels[number].__name__)
        return plain(self, passed, number)

    monkeypatch.setattr(module.Late, "compiled", noted)
    return found


Pair = Annotated[tuple, lambda x: types.UniTuple(x, 2)]  # real or complex, as its argument


def test_it_is_compiled_at_the_first_call_and_once(compiled):
    @late_kernel
    def heavy(x) -> Pair:
        return 3.0 * x, x * x

    @kernel
    def light(x, much):
        return heavy(x)[0] + heavy(x)[1] if much else x

    assert light(2.0, False) == 2.0 and compiled == []
    assert light(2.0, True) == 10.0 and light(5.0, True) == 40.0 and compiled == ["heavy"]
    assert light(2.0 + 1j, True) == 9.0 + 7.0j and compiled == ["heavy", "heavy"]


def test_cells_for_other_types_have_other_names():
    @late_kernel
    def heavy(x) -> Pair:
        return 3.0 * x, x * x

    known = [(one,) for one in (types.float64, types.complex128)]
    symbols = [heavy.symbol(passed) for passed in known]
    assert [module.LATE_SYMBOLS[symbol][2] for symbol in symbols] == known
    for symbol in symbols:  # nobody else can find a kernel of this test
        del module.LATE_SYMBOLS[symbol]


def test_a_number_says_which(compiled):
    @inner_kernel
    def double(a, x):
        a[0] = 2.0 * x

    @inner_kernel
    def square(a, x):
        a[0] = x * x

    either = late_choice(__name__, "either", (double, square))

    @kernel
    def all_of(which, a, x):
        for number in which:
            either(number, a, x)

    a = np.zeros(1)
    all_of(np.array([1, 1]), a, 5.0)
    assert a[0] == 25.0 and compiled == ["square"]
    all_of(np.array([1, 0]), a, 5.0)
    assert a[0] == 10.0 and compiled == ["square", "double"]


class Mine(Exception):  # noqa: N818
    """What a handler of the user's raises."""


@pytest.fixture
def slowly(monkeypatch):
    """Kernels of cells take 0.2 s to compile, longer than a signal to come; the names of the handlers' exceptions."""
    plain, handlers = module.Late.compiled, {}

    def slow(self, passed, number):
        time.sleep(0.2)
        return plain(self, passed, number)

    monkeypatch.setattr(module.Late, "compiled", slow)
    for number, error in ((signal.SIGALRM, TimeoutError), (signal.SIGINT, KeyboardInterrupt), (signal.SIGUSR1, Mine)):

        def handle(number, frame, error=error):
            raise error(f"signal {number}")

        handlers[number] = signal.signal(number, handle)
    yield {TimeoutError: signal.SIGALRM, KeyboardInterrupt: signal.SIGINT, Mine: signal.SIGUSR1}
    for number, handler in handlers.items():
        signal.signal(number, handler)


@pytest.mark.parametrize(
    ("decorator", "error", "after"),
    [
        (kernel, TimeoutError, 0.0),
        (kernel, TimeoutError, 0.1),
        (kernel, KeyboardInterrupt, 0.1),
        (kernel, Mine, 0.15),
        (numba.njit(_nrt=False), TimeoutError, 0.1),
    ],
)
def test_what_a_handler_raises_waits_for_the_kernel(slowly, compiled, decorator, error, after):
    """Before it is compiled and meanwhile; plain functions of numba keep Python's lock, and let go of it here."""

    @late_kernel
    def slow(x) -> float:
        return 7.0 * x

    @decorator
    def above(x):
        return slow(x)

    above.compile("float64(float64)")
    sender = threading.Timer(after, os.kill, (os.getpid(), slowly[error]))
    with pytest.raises(error, match="signal"):
        sender.start()
        above(2.0)
        time.sleep(5.0)
    sender.join()
    assert above(3.0) == 21.0 and compiled == ["slow"]


@pytest.mark.parametrize("after", [0.01, 0.05, 0.12])
def test_what_a_handler_raises_breaks_no_compilation(slowly, after):
    """Of a function that Python calls: raised at once, and the next call finds the code or waits for it."""

    @kernel
    def above(x, y):
        found = x * y
        for k in range(7):
            found += math.sin(k * x) * math.atan2(x, y) if k > 9 else 0.0
        return found

    with pytest.raises(TimeoutError, match="signal"):
        signal.setitimer(signal.ITIMER_REAL, after)
        above(2.0, 1.0)
        time.sleep(5.0)
    assert above(3.0, -2.0) == -6.0 and len(above.overloads) == 1


def test_errors_of_the_compiler_are_the_same_in_a_thread():
    @kernel
    def wrong(x):
        return x.missing

    with pytest.raises(numba.errors.TypingError, match="missing"):
        wrong(1.0)


def test_where_no_thread_can_be_started_the_caller_compiles(monkeypatch, compiled):
    """As in functions that Python calls when it ends."""

    def refused(*_):
        raise RuntimeError("can't create new thread at interpreter shutdown")

    monkeypatch.setattr(module._thread, "start_new_thread", refused)
    monkeypatch.setattr(threading.Thread, "start", refused)
    monkeypatch.setattr(module, "announce_if_slow", lambda name: nullcontext())
    monkeypatch.setattr(module, "NAPS_MAX", 50)
    monkeypatch.setattr(sys, "unraisablehook", lambda _: None)

    @late_kernel
    def slow(x) -> float:
        return 7.0 * x

    @kernel
    def above(x):
        return slow(x)

    assert above(2.0) == 14.0 and above(3.0) == 21.0 and compiled == ["slow"]


def test_signals_in_a_row_leave_the_kernel_whole(slowly, compiled):
    """A handler every 2 ms, as a sampling profiler has it; every call is counted, and none is lost."""

    @late_kernel
    def slow(x) -> float:
        return 7.0 * x

    @kernel
    def above(x):
        return slow(x)

    count = []
    signal.signal(signal.SIGALRM, lambda *_: count.append(1))
    signal.setitimer(signal.ITIMER_REAL, 2e-3, 2e-3)
    try:
        assert above(2.0) == 14.0
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
    assert count and compiled == ["slow"]


def test_threads_that_call_it_at_once_wait_for_one_kernel(slowly, compiled):
    @late_kernel
    def slow(x) -> float:
        return 7.0 * x

    @kernel
    def above(x):
        return slow(x)

    above.compile("float64(float64)")
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(above, [1.0, 2.0, 3.0, 4.0])) == [7.0, 14.0, 21.0, 28.0]


WRONG = """
from mbsd3d.base.errors import KernelError
from mbsd3d.compiler.decorators import kernel, late_kernel
@late_kernel
def wrong(x) -> int: return 0.5 * x
@late_kernel
def right(x) -> float: return 3.5 * x
@kernel
def above(x, y): return wrong(x) if y > 0.0 else int(right(x))
@kernel
def good(x): return right(x)
told = []
for _ in range(2):  # the second call meets the stand-in
    try:
        above(1.0, 1.0)
    except KernelError as error:
        told.append(str(error))
print("above:", told[0].partition("InputError: ")[2].partition(";")[0])
print("good:", good(2.0))
print(told[1], above(1.0, -1.0))
"""


def test_one_that_cannot_be_compiled_is_an_error_and_the_next_run_works(tmp_path):
    (tmp_path / "wrong.py").write_text(WRONG)
    done = subprocess.run([sys.executable, "wrong.py"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split("\n")[:2] == ["above: wrong returns float64, not int64", "good: 7.0"]
    assert "wrong cannot be compiled: InputError" in done.stdout


def test_a_long_compilation_is_said(monkeypatch, capsys):
    monkeypatch.setattr(first_run, "SLOW_COMPILE_SECONDS", 0.05)
    with first_run.announce_if_slow("tyre"):
        time.sleep(0.2)
    with first_run.announce_if_slow("spring"):
        pass
    assert capsys.readouterr().err == "mbsd3d: compiling tyre, once after installation ...\n"


SECOND = """
import sys, time
from mbsd3d.compiler import first_run
first_run.WORK = "from mbsd3d.compiler.first_run import end_with_parent; end_with_parent(); import time; time.sleep(60)"
first_run.os.cpu_count = lambda: 2
first_run.start_second()
print(first_run.others[0].pid, flush=True)
time.sleep(60)
"""


@pytest.mark.skipif(os.name != "posix", reason="kill -9")
@pytest.mark.parametrize("sign", [signal.SIGKILL, pytest.param(signal.SIGTERM, marks=pytest.mark.slow)])
def test_the_second_process_ends_with_the_first(sign):
    environment = {name: value for name, value in os.environ.items() if name != "MBSD3D_SECOND"}
    first = subprocess.Popen([sys.executable, "-c", SECOND], stdout=subprocess.PIPE, text=True, env=environment)
    pid = int(first.stdout.readline())
    time.sleep(0.1)
    first.send_signal(sign)
    first.wait()
    ends = time.monotonic() + 10.0
    while time.monotonic() < ends:
        try:
            os.kill(pid, 0)
        except ProcessLookupError:
            return
        time.sleep(0.02)
    os.kill(pid, signal.SIGKILL)
    raise AssertionError("the second process lives on")
