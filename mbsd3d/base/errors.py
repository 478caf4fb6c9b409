"""What is refused and what fails: one base class, and errors that say when, at which part, by how much, what to do."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np


class MbsError(ValueError):
    """Base of what this package raises of its own; a `ValueError`, as all that it refuses is.

    ``except ValueError`` catches wrong input and failures of runs, ``except MbsError`` the latter.

    The message is ``<what> at t = <time> s: <part>, residual <residual>; <advice>``, with what is None left out.

    Parameters
    ----------
    what : str
        What failed, without a full stop.
    time : float, optional
        Time of the failure [s].
    part : str, optional
        The body, joint or force concerned, e.g. ``"joint 'hinge' (Revolute)"``.
    residual : float, optional
        The largest residual, in the unit of the row that failed (m, rad, m/s, ...).
    solution : object, optional
        What was computed up to ``time``; None if nothing was.
    advice : str, optional
        What to change, e.g. ``"use GeneralizedAlpha()"``.
    """

    def __init__(
        self,
        what: str,
        *,
        time: float | None = None,
        part: str | None = None,
        residual: float | None = None,
        solution: Any = None,
        advice: str | None = None,
    ) -> None:
        # The whole sentence is the only argument of the base class, so that a copy from another process reads the same.
        super().__init__(_sentence(what, time, part, residual, advice))
        self.time = time
        self.part = part
        self.residual = residual
        self.solution = solution
        self.advice = advice


@contextmanager
def solvable(what: str) -> Iterator[None]:
    """Turn what the linear algebra inside cannot solve into an error of this package."""
    try:
        yield
    except (np.linalg.LinAlgError, OverflowError) as error:
        raise MbsError(
            f"{what}: {error}",
            advice="masses, inertias, lengths or stiffnesses differ by too many orders of magnitude; check the units",
        ) from error


class AssemblyError(MbsError):
    """No configuration or velocity satisfies the joints.

    >>> print(AssemblyError("the loop cannot be closed", part="joint 'crank'", residual=2e-3, advice="shorten the rod"))
    the loop cannot be closed: joint 'crank', residual 0.002; shorten the rod
    """


class IntegrationError(MbsError):
    """The integrator could not go on; ``solution`` holds the samples up to ``time``.

    >>> print(IntegrationError("the model is stiff", time=0.25, part="force 'mount'", advice="use GeneralizedAlpha()"))
    the model is stiff at t = 0.25 s: force 'mount'; use GeneralizedAlpha()
    """


class EquilibriumError(MbsError):
    """A mechanism comes to no rest, or not near where it was looked for.

    >>> print(EquilibriumError("no equilibrium: body 'stone' falls", advice="hold it"))
    no equilibrium: body 'stone' falls; hold it
    """


class SweepError(MbsError):
    """A sweep had to stop; ``dataset`` holds the cells that had finished.

    >>> print(SweepError("the ledger cannot be written: disk is full", advice="make room and run the sweep again"))
    the ledger cannot be written: disk is full; make room and run the sweep again
    """

    def __init__(self, what: str, *, dataset: Any = None, advice: str | None = None) -> None:
        super().__init__(what, advice=advice)
        self.dataset = dataset


def _sentence(what: str, time: float | None, part: str | None, residual: float | None, advice: str | None) -> str:
    """One sentence from the pieces that are known."""
    when = "" if time is None else f" at t = {time:.6g} s"
    size = None if residual is None else f"residual {residual:.3g}"
    where = ", ".join(piece for piece in (part, size) if piece)
    return what + when + (f": {where}" if where else "") + (f"; {advice}" if advice else "")
