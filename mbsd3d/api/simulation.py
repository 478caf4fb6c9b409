"""`simulate` and `accelerations`: from a system and a state to a `Solution`."""

from numpy.typing import ArrayLike

from ..base.errors import IntegrationError, checks_arguments
from ..equations.compiled import BAUMGARTE_FACTORS, Switches
from ..integrators.dop853 import DOP853
from ..integrators.method import Method
from ..mechanism.measures import Condition
from ..mechanism.state import State
from ..results.record import RunOptions
from ..run.simulation import accelerations_at, check_state, check_system, run_to
from .solution import Solution, publish_solution
from .system import System


@checks_arguments
def simulate(
    system: System,
    t_end: float,
    *,
    state: State | None = None,
    method: Method | None = None,
    rtol: float = 1e-8,
    output: int | ArrayLike | None = None,
    stop_when: Condition | None = None,
    gyroscopic: bool = True,
    centripetal: bool = True,
    gamma: bool = True,
    stabilisation: str = "projection",
    baumgarte: tuple[float, float] = BAUMGARTE_FACTORS,
    as_built: float | None = None,
    progress: bool | str | None = None,
) -> Solution:
    """Integrate a mechanism from a state to ``t_end``.

    Parameters
    ----------
    system : System
    t_end : float
        End time [s], hit exactly.
    state : State or None
        Start; None = ``system.state()``, the reference pose with solved velocities.
    method : DOP853, RK4, GeneralizedAlpha, RadauIIA, Kinematic or None
        None = DOP853().
    rtol : float
        Relative tolerance: a step may err by 0.2 rtol (`DOP853`) or up to 0.1 rtol (implicit methods), relative to the
        model's length, one radian and the greatest speed so far.
    output : None, int or array
        Every accepted step, a number of equally spaced samples, or the sample times [s] (hit exactly).
    stop_when : Condition
        A measure compared with a value, e.g. ``measures.angle(hinge) > 1.2``; the run ends where it first comes true,
        at a time as exact as the method. A rise above the value and back within one step is detected if it is the only
        one in that step; ``max_step`` (or ``dt``) of the method limits how short an event may be. A run may start at
        the value: a condition that becomes false there, by the sign of its rate, is armed at once, any other once it
        has been false; the certificate names one that was never armed.
    gyroscopic, centripetal, gamma, stabilisation, baumgarte
        Teaching switches: False drops w x I w, m w x (w x s), -J_dot v; stabilisation "none", "baumgarte" (with
        factors a [1/s] and b [1/s^2] of gamma -= a (J v - b) + b c) or "projection".
    as_built : float or None
        Tolerance [m] within which redundant rows may be violated, for parts built slightly out of line.
    progress : bool, "lines" or None
        Show a progress bar; None = on a terminal, after two seconds; "lines" = a line every few seconds, for logs.

    Returns
    -------
    Solution
        Also after Ctrl-C, with the samples so far; its certificate says so.

    Raises
    ------
    ValueError
        For invalid input.
    IntegrationError
        With time, part and advice; ``error.solution`` holds the samples so far.

    Examples
    --------
    >>> from mbsd3d import Body, System, measures, simulate
    >>> stone = Body("stone", 1.0, (0.1, 0.1, 0.1), velocity=(0, 0, 3.0), omega=(0, 0, 0))
    >>> flight = simulate(System([stone]), 1.0, stop_when=measures.velocity(stone, axis=(0, 0, 1)) < 0.0)
    >>> round(float(flight.position(stone)[-1, 2]), 9)  # v^2 / (2 g)
    0.458715596
    """
    switches = Switches(gyroscopic, centripetal, gamma, stabilisation, baumgarte)
    method = DOP853() if method is None else method
    options = RunOptions(method, rtol, output, stop_when, as_built, progress, switches)
    start = start_of(system, state, "simulate", options.as_built)
    try:
        return Solution.of(run_to(system, start, t_end, options))
    except IntegrationError as error:
        publish_solution(error)
        raise


@checks_arguments
def accelerations(
    system: System,
    state: State | None = None,
    *,
    gyroscopic: bool = True,
    centripetal: bool = True,
    gamma: bool = True,
    as_built: float | None = None,
) -> Solution:
    """Return accelerations and reactions at one state: a `Solution` with a single sample.

    ``accelerations(system, state).acceleration(body)[0]``, ``.reaction(joint).force[0]``, ``.effort(driver)[0]``.
    The teaching switches drop the same terms as in `simulate`, and ``as_built`` [m] permits the same misfit of parts.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Revolute, System, accelerations
    >>> arm = Body("arm", mass=2.0, inertia=(0.1, 0.5, 0.5), com=(0.5, 0, 0))
    >>> system = System([arm], [Revolute(GROUND, arm, at=(0, 0, 0), axis=(0, 1, 0), name="hinge")])
    >>> now = accelerations(system)
    >>> round(float(now.alpha(arm)[0, 1]), 12)  # m g l / (I_G + m l^2) about y
    9.81
    >>> round(float(now.reaction("hinge").force[0, 2]), 12)  # m (g - l alpha)
    9.81
    """
    options = RunOptions(as_built=as_built, switches=Switches(gyroscopic, centripetal, gamma))
    start = start_of(system, state, "accelerations", options.as_built)
    try:
        return Solution.of(accelerations_at(system, start, options))
    except IntegrationError as error:
        publish_solution(error)
        raise


def start_of(system: System, state: State | None, what: str, as_built: float | None = None) -> State:
    """Return the given state, or the initial state of the system if none is given."""
    check_system(system, what)
    check_state(state, what)
    return state or system.state(as_built=as_built)
