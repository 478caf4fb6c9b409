"""Forces by a user function, compiled once and called by address from the compiled time loop."""

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, field
from typing import Any

import numba
import numpy as np
from numpy.typing import ArrayLike

from ...base.checks import as_tuple, number, sequence, short_repr, vector
from ...base.errors import InputError
from ...base.fields import (
    Number,
    Numbers,
    NumbersOrDerived,
    Stored,
    kept,
    part_class,
    true_or_false,
)
from ...base.wording import counted
from ...compiler.arguments import call
from ...compiler.decorators import inner_kernel
from ...kernels.force_laws import series
from ...kernels.layout import CUSTOM_FORCE_BODIES_MAX
from ...kernels.vectors import add, add6, arm, clear, cross, dot, mat, pair, point, point_velocity, put, sub, vec
from ..bodies import Body, Ground, as_body_or_ground
from ..force_element import ForceElement, ForceRecord
from ..mechanism import Mechanism
from .own_functions import RETURN_FLAG_INDEX, callback, reason, uncompiled

CUSTOM_ARGUMENTS = ("t", "bodies", "z", "parameters", "loads", "z_dot")


@inner_kernel
def place(body, pose, s):
    """Fill what the function reads of the point of a body at O + s."""
    R = mat(body.R)
    put(pose.r, point(body, s))
    put(pose.velocity, point_velocity(body, s))
    put(pose.w, vec(body.w))
    for i in range(3):
        for j in range(3):
            pose.R[i, j] = R[3 * i + j]


@inner_kernel
def custom(m, d, p, out, t):
    """Apply the loads of a custom force at its points; the power is NaN where the function is missing or fails."""
    for i in range(p.bodies):
        place(d.body[p.body[i]], d.pose[i], arm(d.body[p.body[i]], p.point[i]))
    clear(d.wrench)
    d.wrench[RETURN_FLAG_INDEX] = np.nan
    z, z_dot = d.z[p.state : p.state + p.states], d.state_rate[p.state : p.state + p.states]
    clear(z_dot)
    address = p.address[1] if np.iscomplexobj(d.wrench) else p.address[0]
    if address != 0:
        numbers = series(m, p, 0, p.numbers)
        call(address, t, d.pose, p.bodies, z, p.states, numbers, p.numbers, d.wrench, z_dot)
    out.power = d.wrench[RETURN_FLAG_INDEX]
    for i in range(p.bodies):
        body, pose = d.body[p.body[i]], d.pose[i]
        force, moment = pair(d.wrench[6 * i : 6 * i + 6])
        out.power += dot(force, vec(pose.velocity)) + dot(moment, vec(pose.w))
        add6(body.Q, force, add(moment, cross(sub(vec(pose.r), vec(body.r)), force)))


def as_bodies(value: Any, what: str, part: Any) -> tuple[Body | Ground, ...]:
    """Convert to one body or up to as many as a function can act on."""
    if not isinstance(value, Body | Ground | list | tuple):
        raise InputError(f"{what} {short_repr(value)}; give a Body, GROUND or a tuple of them")
    on = (value,) if isinstance(value, Body | Ground) else tuple(value)
    if not 1 <= len(on) <= CUSTOM_FORCE_BODIES_MAX:
        raise InputError(
            f"{what.removesuffix(': on')}: acts on {counted(len(on), 'body')}; give 1 to {CUSTOM_FORCE_BODIES_MAX}"
        )
    return tuple(as_body_or_ground(body, what, part) for body in on)


def as_points(value: Any, what: str, part: Any) -> tuple[np.ndarray, ...]:
    """Convert to world points at the reference pose."""
    given = as_tuple(value, what, "one per body")
    return tuple(vector(point, f"{what.removesuffix('s')} no. {k + 1}") for k, point in enumerate(given))


def reference_points(force: Any) -> tuple[np.ndarray, ...]:
    """Return the reference point of each body."""
    return tuple(body.position for body in force.on)


def as_labels(value: Any, what: str, part: Any) -> tuple[str, ...]:
    """Convert the names of internal states: those of a mapping of states, else as given."""
    return as_tuple(part.states if isinstance(part.states, Mapping) else value, what, "names")


def names_of_states(force: Any) -> tuple[str, ...]:
    """Return the names of a mapping of states, else numbers."""
    if isinstance(force.states, Mapping):
        return tuple(force.states)
    return tuple(map(str, range(len(sequence(force.states, f"{force.what()}: states")))))


def as_states(value: Any, what: str, part: Any) -> tuple[float, ...]:
    """Convert the initial values of internal states, with or without names."""
    return sequence(value.values() if isinstance(value, Mapping) else value, what)


def as_times(value: Any, what: str, part: Any) -> tuple[float, ...]:
    """Sort the times, each once."""
    return tuple(sorted(set(sequence(value, what))))


def as_longest_step(value: Any, what: str, part: Any) -> float:
    """Accept a number > 0, or infinity."""
    return value if isinstance(value, float) and value == np.inf else number(value, what, positive=True)


class BodiesOrGround(Stored[Body | Ground | Sequence[Body | Ground], tuple[Body | Ground, ...]]):
    """Bodies; a single one needs no sequence."""

    accepts = "Body | Ground | Sequence[Body | Ground]"
    convert = staticmethod(as_bodies)


class PointsOrDerived(Stored[Sequence[ArrayLike] | None, tuple[np.ndarray, ...]]):
    """Points; None = the reference points of the bodies."""

    accepts, file_type = "Sequence[array_like] | None", list
    convert = staticmethod(as_points)


class LabelsOrDerived(Stored[Sequence[str] | None, tuple[str, ...]]):
    """Names; None = those of the states, or numbers."""

    accepts, file_type = "Sequence[str] | None", list[str]
    convert = staticmethod(as_labels)


class States(Stored[Sequence[float] | Mapping[str, float], tuple[float, ...]]):
    """Numbers, or a mapping of names to numbers."""

    accepts, file_type = "Sequence[float] | Mapping[str, float]", list[float] | dict
    convert = staticmethod(as_states)


@part_class()
class FunctionForce(ForceElement):
    """Base class of a force by a function, without the function itself; see `CustomForce`."""

    law = staticmethod(custom)

    _: KW_ONLY
    on: BodiesOrGround = kept()
    points: PointsOrDerived = kept(default=None, derived=reference_points)
    parameters: Numbers = kept(default=())
    labels: LabelsOrDerived = kept(default=None, derived=names_of_states)
    states: States = kept(default=())
    scales: NumbersOrDerived = kept(default=None, derived=lambda force: (1.0,) * len(force.states))
    external: bool = kept(default=False, by=true_or_false)
    times: Numbers = kept(default=(), by=as_times)
    max_step: Number = kept(default=np.inf, by=as_longest_step)

    def check(self, what: str) -> None:
        count = len(self.states)
        if len(self.points) != len(self.on):
            raise InputError(
                f"{what}: {counted(len(self.points), 'point')} for {counted(len(self.on), 'body')}; give one per body"
            )
        texts = all(isinstance(x, str) for x in self.labels)
        fits = texts and len(self.labels) == len(set(self.labels)) == count
        if not fits:
            raise InputError(f"{what}: labels {short_repr(self.labels)} for {count} states; name each once")
        if len(self.scales) != count or min(self.scales, default=1.0) <= 0.0:
            raise InputError(
                f"{what}: scales {short_repr(self.scales)} for {count} states; give one number > 0 per state"
            )

    def record(self) -> ForceRecord:
        scales = tuple((scale, 0.0, 0.0) for scale in self.scales)
        return ForceRecord(self.on, self.points, series=(self.parameters,), states=self.states, scales=scales)

    def state_names(self) -> tuple[str, ...]:
        return self.labels

    def address(self, dtype: type, parameters: type = float) -> int | Callable:
        """Return the address of the function for real or complex numbers, and parameters; 0 = none."""
        raise NotImplementedError


@part_class()
class SavedForce(FunctionForce):
    """A `CustomForce` read back with a saved solution: without its function, so the system cannot be run again."""

    def address(self, dtype: type, parameters: type = float) -> int | Callable:
        return 0


@part_class()
class CustomForce(FunctionForce):
    """Loads of a function of your own, plain or jitted by numba; the time loop calls it without being recompiled.

    A run asks for the loads at the stages of its steps only, which grow as long as the motion allows: a blow of 10 ms,
    or one within a centimetre, may fall between stages and be missed. Give ``times`` at which it begins and ends, or
    ``max_step``, the shortest time that it acts.

    The function has the fixed signature ``function(t, bodies, z, parameters, loads, z_dot)``:

    ========== ================= ===================================================================================
    t          float             time [s]
    bodies     (k,) records      per point: ``.r`` (3,) position [m], ``.R`` (3, 3) orientation body -> world,
                                 ``.velocity`` (3,) of the point [m/s], ``.w`` (3,) angular velocity [rad/s]; world
    z          (n,)              internal states
    parameters (p,) float        the numbers given
    loads      (k, 6)            to be filled: force [N] at the point and moment about it [N m], world; zero before
    z_dot      (n,)              to be filled: rates of the internal states [1/s]; zero before
    ========== ================= ===================================================================================

    It returns nothing, and fills the same for the same arguments: a run stops where it remembers something from one
    call to the next, or draws random numbers; memory belongs into ``z``.
    A place beyond the end of an array stops the run with an error, unless the function is jitted already: numba then
    checks it only if told so (``boundscheck=True``).
    Forces between bodies must be given for each of them, with opposite signs, or a run does not start, unless they are
    ``external``. Nothing is stored (potential 0): the power ``sum(force . velocity + moment . w)`` is integrated as
    its work, so the energy balance stays exact.
    The arrays are complex where derivatives are taken by a complex step: use ``np`` functions, `mbsd3d.arctan2` for the
    angle of two coordinates, and neither ``abs``, ``np.linalg.norm`` nor comparisons of what depends on them (write
    ``x.real < 0``). One function shared by many forces is compiled once; what differs belongs into ``parameters``.

    Parameters
    ----------
    function : callable
        See above. Compiled when the force is made; a second time, for complex numbers, when these are first used.
    on : Body or sequence of up to 4
        Bodies it reads and acts on, in the order of ``bodies`` and ``loads``; GROUND is allowed.
    points : sequence of (3,) array_like or None
        A point of each body, world at the reference pose [m]; None = their reference points.
    parameters : sequence of float
    states : sequence of float, or mapping of a name to a float
        Initial values of the internal states.
    scales : sequence of float or None
        Sizes against which errors of the internal states are measured while they are smaller; None = 1 for each.
    labels : sequence of str or None
        Names of the internal states, where ``states`` does not give them; None = "0", "1", ...
    external : bool
        True for a load from outside on several bodies, or on one that depends on others: it need not balance.
    times : sequence of float
        Times [s] at which its loads jump: steps end there, and the next ones begin behind the jump.
    max_step : float
        Longest step [s] of a run with this force: a stage of every method meets what lasts as long.

    Raises
    ------
    ValueError
        For a function that does not compile or takes other arguments, and for wrong bodies, points, numbers or times.

    Examples
    --------
    Two magnets attracting each other with ``strength / gap^2``:

    >>> import numpy as np
    >>> from mbsd3d import GROUND, Body, CustomForce, System, accelerations
    >>> def magnet(t, bodies, z, parameters, loads, z_dot):
    ...     gap = bodies[1].r - bodies[0].r
    ...     square = np.sum(gap * gap)
    ...     loads[0, :3] = parameters[0] / square * gap / np.sqrt(square)
    ...     loads[1, :3] = -loads[0, :3]
    >>> ball = Body("ball", mass=0.5, inertia=(1e-3, 1e-3, 1e-3), position=(0, 0, 2))
    >>> pull = CustomForce(magnet, on=(GROUND, ball), parameters=(8.0,), name="magnet")
    >>> system = System([ball], forces=[pull], gravity=(0, 0, 0))
    >>> round(float(accelerations(system).acceleration(ball)[0, 2]), 12)
    -4.0
    """

    function: Callable
    callbacks: dict = field(default_factory=dict, init=False, repr=False)  # keeps the code at the addresses alive

    def check(self, what: str) -> None:
        super().check(what)
        plain = getattr(self.function, "py_func", self.function)
        if not inspect.isfunction(plain):
            raise InputError(
                f"{what}: function {short_repr(self.function)} is not a function; give a plain or a jitted one"
            )
        if len(inspect.signature(plain).parameters) != len(CUSTOM_ARGUMENTS):
            raise InputError(
                f"{what}: function '{plain.__name__}' must take the arguments {', '.join(CUSTOM_ARGUMENTS)}"
            )
        self.address(float)

    def address(self, dtype: type, parameters: type = float) -> int | Callable:
        if numba.config.DISABLE_JIT:
            return uncompiled(self.function)
        if (dtype, parameters) not in self.callbacks:
            try:
                self.callbacks[dtype, parameters] = callback(self.function, dtype, parameters)
            except Exception as error:  # numba has several families of them
                raise InputError(self.uncompilable(dtype, reason(error))) from error
        return self.callbacks[dtype, parameters].address

    def __getstate__(self) -> dict:
        """Leave the addresses out: copies and pickles compile the function again."""
        return {**vars(self), "callbacks": {}}

    def uncompilable(self, dtype: type, why: str) -> str:
        """Return the error message for a function that numba rejects."""
        force = f"force '{self.name}' (CustomForce)" if self.name else "CustomForce without a name"
        kind, remedy = "", "use what numba supports"
        if dtype is complex:
            kind = " for the complex numbers of exact derivatives (GeneralizedAlpha, linearize, Study)"
            remedy = "compare real parts, x.real < 0, and use np functions, mbsd3d.arctan2(y, x) for the one of np"
        return f"{force}: function '{self.function.__name__}' does not compile{kind}: {why}; {remedy}"

    def saved(self) -> "SavedForce":
        """Return the force without its function, as a file can store it."""
        return SavedForce(
            on=self.on, points=self.points, parameters=self.parameters, states=self.states, scales=self.scales,
            labels=self.labels, external=self.external, times=self.times, max_step=self.max_step, name=self.name,
        )  # fmt: skip


def check_runnable(system: Mechanism) -> None:
    """Raise a ValueError for a system whose custom forces have lost their functions."""
    for force in system.forces:
        if isinstance(force, SavedForce):
            raise InputError(
                f"force '{system.name(force)}': its function was not saved with the solution, so the system cannot be "
                "run; build it again with CustomForce(function, ...)"
            )
