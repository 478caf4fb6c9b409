"""`Stepper`: a simulation that advances segment by segment, with inputs set in between."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..base.checks import as_tuple, check_choice, short_repr
from ..base.errors import ChecksArguments, InputError, IntegrationError, checks_method_arguments
from ..integrators.dop853 import DOP853
from ..integrators.method import Method
from ..mechanism.measures import Measure
from ..mechanism.signals.signal import Input
from ..mechanism.state import State
from ..results.record import RunOptions
from ..run.controllers import Coupling, FmuController, advance_coupled
from ..run.segments import Segments, Snapshot
from .simulation import start_of
from .solution import Solution, publish_solution
from .system import System


@checks_method_arguments
class Stepper(metaclass=ChecksArguments):
    """A mechanism that is integrated segment by segment: for controllers, co-simulation, live runs and learning.

    Everything that a run has prepared is kept between two segments, so that each costs little more than its steps; a
    segment is at least one step of the method. A value to which an `Input` is `set` is held, or continued with a slope,
    until the next change.

    Parameters
    ----------
    system : System
    state : State or None
        Start; None = ``system.state()``.
    measures : sequence of measures
        What `measured` returns, e.g. ``[measures.angle(hinge), measures.rate(hinge)]``.
    method, rtol, as_built
        As for `simulate`. Steps of ``dt`` are fitted to each segment.
    keep : bool
        Whether the end of each segment is a sample of `solution`.
    controllers : sequence of FmuController
        Sampled controllers in FMUs; `advance` goes from sample to sample.

    Raises
    ------
    ValueError
        For invalid input.
    AssemblyError
        If the state does not meet the joints.

    Examples
    --------
    >>> from mbsd3d import Body, Force, Input, Stepper, System
    >>> sled = Body("sled", 2.0, (0.1, 0.1, 0.1), velocity=(0, 0, 0), omega=(0, 0, 0))
    >>> stepper = Stepper(System([sled], forces=[Force(sled, (Input("push"), 0, 19.62))]))
    >>> stepper.set("push", 4.0)
    >>> stepper.advance(1.0)
    >>> stepper.set("push", 0.0)
    >>> stepper.advance(2.0)
    >>> float(stepper.q[0].round(9)), float(stepper.v[0].round(9))  # 1 m in the push, 2 m/s after it
    (3.0, 2.0)
    """

    def __init__(
        self,
        system: System,
        state: State | None = None,
        *,
        measures: Sequence[Measure] = (),
        method: Method | None = None,
        rtol: float = 1e-8,
        as_built: float | None = None,
        keep: bool = True,
        controllers: Sequence[FmuController] = (),
    ) -> None:
        check_choice(keep, (True, False), "Stepper: keep")
        options = RunOptions(DOP853() if method is None else method, rtol, as_built=as_built)
        measures = as_tuple(measures, "Stepper: measures", "a list of mbsd3d.measures")
        controllers = checked(controllers)
        read = [x for controller in controllers for x in controller.reads.values()]
        start = start_of(system, state, "Stepper", options.as_built)
        self._run, self._shown = Segments(system, start, options, (*measures, *read)), len(measures)
        self._run.keep = keep
        self._coupled: list[Coupling] = []
        for x in controllers:
            first = self._shown + sum(len(other.controller.reads) for other in self._coupled)
            self._coupled.append(Coupling(x, self._run, first))

    def __repr__(self) -> str:
        return f"<stepper: at t = {self.t:g} s, by {self._run.options.method}>"

    def set(self, key: Input | str, value: float, slope: float = 0.0) -> None:
        """Set an input, given as object or by name, to a value held from now on or continued with a slope.

        From the time t of this call on it is ``value + slope (time - t)``, with the slope in its unit per second. If
        two models set each other's inputs, the error is proportional to the time H between two changes with held
        values, and to H^2 with the slopes of the last two: ``slope = (now - before) / H``.

        Raises
        ------
        ValueError
            If the system has no such input, a number is not finite, or the input prescribes a motion, which must not
            jump.

        Examples
        --------
        >>> from mbsd3d import Body, Force, Input, Stepper, System
        >>> sled = Body("sled", 2.0, (0.1, 0.1, 0.1), velocity=(0, 0, 0), omega=(0, 0, 0))
        >>> stepper = Stepper(System([sled], forces=[Force(sled, (Input("push"), 0, 19.62))]))
        >>> stepper.set("push", 1.0, slope=6.0)
        >>> stepper.advance(1.0)
        >>> float(stepper.v[0].round(9)), stepper.inputs  # (1 + 6 / 2) / m
        (2.0, {'push': 7.0})
        """
        name = key.name if isinstance(key, Input) else key
        for x in self._coupled:
            if name in x.controller.inputs.values():
                raise InputError(f"Stepper: input '{name}' is set by '{x.controller.name}'; leave it to it")
        self._run.set(key, value, slope)

    def advance(self, t: float) -> None:
        """Integrate to time t [s]; the last step ends exactly there.

        Raises
        ------
        ValueError
            If t is not later than the time reached, or a table of a signal ends before t.
        IntegrationError
            With time, part and advice; ``error.solution`` holds what was kept.
        """
        try:
            if self._coupled:
                advance_coupled(self._run, self._coupled, t)
            else:
                self._run.advance(t)
        except IntegrationError as error:
            publish_solution(error)
            raise

    def snapshot(self) -> Snapshot:
        """Return a snapshot of the run, to `restore` later: for trials, predictive control, FMUs that step back.

        It costs a copy of the work space and of the samples kept so far; with ``keep=False`` there are none of these. A
        controller in an FMU is restored from the state that the FMU reports, and is as exact as that state.

        Raises
        ------
        ValueError
            If the FMU of a controller does not offer its state.
        IntegrationError
            If such an FMU reports an error.

        Examples
        --------
        >>> from mbsd3d import Body, Force, Input, Stepper, System
        >>> sled = Body("sled", 2.0, (0.1, 0.1, 0.1), velocity=(0, 0, 0), omega=(0, 0, 0))
        >>> stepper = Stepper(System([sled], forces=[Force(sled, (Input("push"), 0, 19.62))]))
        >>> start = stepper.snapshot()
        >>> for push in (4.0, -2.0):
        ...     stepper.restore(start)
        ...     stepper.set("push", push)
        ...     stepper.advance(1.0)
        ...     print(round(float(stepper.q[0]), 9), stepper.inputs)
        1.0 {'push': 4.0}
        -0.5 {'push': -2.0}
        """
        kept = tuple(x.snapshot() for x in self._coupled)
        return replace(self._run.snapshot(), controllers=kept)

    def restore(self, snapshot: Snapshot) -> None:
        """Continue from a snapshot of this stepper, to the last bit as it would have gone on from there.

        Inputs get the values that they had, and `solution` the samples kept until then. This also works after an
        `IntegrationError`.

        Raises
        ------
        ValueError
            For a snapshot of another stepper.
        IntegrationError
            Where the FMU of a controller reports an error.
        """
        self._run.restore(snapshot)
        for x, kept in zip(self._coupled, snapshot.controllers, strict=True):
            x.restore(kept)

    @property
    def t(self) -> float:
        """Return the time reached so far [s]."""
        return self._run.t

    @property
    def q(self) -> np.ndarray:
        """Return the coordinates now (7 n,), per body (r, e): reference point [m, world] and unit quaternion."""
        return self._run.memory.y[: 7 * self._run.model.body.size].copy()

    @property
    def v(self) -> np.ndarray:
        """Return the velocities now (6 n,), per body (r_dot, w) [m/s], [rad/s], both world."""
        return self._run.velocities

    @property
    def z(self) -> np.ndarray:
        """Return the internal states of the force elements now (k,), in their order."""
        first = 13 * self._run.model.body.size
        return self._run.memory.y[first : first + self._run.model.z_work].copy()

    @property
    def measured(self) -> np.ndarray:
        """Return the values of the measures asked for, now (measures,)."""
        return self._run.measured[: self._shown]

    @property
    def inputs(self) -> dict[str, float]:
        """Name of every input -> the value it has now."""
        return self._run.inputs

    @property
    def state(self) -> State:
        """Return the state reached: other runs may start from it, with what `inputs` are set to there anew."""
        return self._run.state

    def solution(self) -> Solution:
        """Return the samples kept: at the start and end of every segment, taken before an input changes there.

        Its certificate is for the motion under the inputs as they were set; `estimate` and `at` repeat the segments.
        """
        run = self._run.solution()
        run.record.coupled = tuple(x.note() for x in self._coupled)
        return Solution.of(run)


def checked(controllers: Sequence[FmuController]) -> tuple[FmuController, ...]:
    """Return controllers; a ValueError for anything else, and for an input that two of them set."""
    found = as_tuple(controllers, "Stepper: controllers", "a list of FmuController")
    for x in found:
        if not isinstance(x, FmuController):
            raise InputError(f"Stepper: controllers: {short_repr(x)} is none; give an FmuController")
    names = [name for x in found for name in x.inputs.values()]
    if twice := [name for name in names if names.count(name) > 1]:
        raise InputError(f"Stepper: controllers: two set the input '{twice[0]}'; let one set it")
    return found
