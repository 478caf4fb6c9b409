"""A limit of time and memory around a call of a test: what is refused is refused at once."""

import resource
import signal
from contextlib import contextmanager

SECONDS, MEGABYTES = 5.0, 500.0


class TooLong(BaseException):
    """Not an Exception, so that nothing swallows it."""


@contextmanager
def watched(what, seconds=SECONDS, megabytes=MEGABYTES):
    """Fail with ``what`` if the body takes longer, on this process's own time, or more memory."""

    def late(*_):
        raise TooLong(f"{what}: more than {seconds} s")

    before, peak = signal.signal(signal.SIGPROF, late), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    signal.setitimer(signal.ITIMER_PROF, seconds)  # processor time: other processes do not count
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
    grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - peak) / 1024.0
    assert grown < megabytes, f"{what}: {grown:.0f} MB"
