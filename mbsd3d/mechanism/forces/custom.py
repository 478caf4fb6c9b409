"""Forces by a function of the user's, compiled once and called from the compiled time loop through its address."""

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numba
import numpy as np
from numpy.typing import ArrayLike

from ...base.checks import listed, number, sequence, shown, vector
from ...base.errors import InputError
from ...compiler.decorators import inner_kernel
from ...compiler.pointer_call import call
from ...kernels.force_laws import series
from ...kernels.layout import CUSTOM_FORCE_BODIES_MAX
from ...kernels.vectors import add, add6, arm, clear, cross, dot, mat, pair, point, point_velocity, put, sub, vec
from ..bodies import GROUND, Body, Ground
from ..force_element import ForceElement, ForceRecord
from ..mechanism import Mechanism
from .own_functions import RETURNED, callback, reason, uncompiled

ARGUMENTS = ("t", "bodies", "z", "parameters", "loads", "z_dot")


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
    """Loads of a custom force at its points; a function that is missing or does not return leaves the power NaN."""
    for i in range(p.bodies):
        place(d.body[p.body[i]], d.pose[i], arm(d.body[p.body[i]], p.point[i]))
    clear(d.wrench)
    d.wrench[RETURNED] = np.nan
    z, z_dot = d.z[p.state : p.state + p.states], d.state_rate[p.state : p.state + p.states]
    clear(z_dot)
    address = p.address[1] if np.iscomplexobj(d.wrench) else p.address[0]
    if address != 0:
        numbers = series(m, p, 0, p.numbers)
        call(address, t, d.pose, p.bodies, z, p.states, numbers, p.numbers, d.wrench, z_dot)
    out.power = d.wrench[RETURNED]
    for i in range(p.bodies):
        body, pose = d.body[p.body[i]], d.pose[i]
        force, moment = pair(d.wrench[6 * i : 6 * i + 6])
        out.power += dot(force, vec(pose.velocity)) + dot(moment, vec(pose.w))
        add6(body.Q, force, add(moment, cross(sub(vec(pose.r), vec(body.r)), force)))


@dataclass(frozen=True, eq=False)
class FunctionForce(ForceElement):
    """What a force by a function is besides its function; see `CustomForce`."""

    law = staticmethod(custom)

    on: Any = field(kw_only=True)
    points: Sequence[ArrayLike] | None = field(default=None, kw_only=True)
    parameters: Sequence[float] = field(default=(), kw_only=True)
    states: Sequence[float] | Mapping[str, float] = field(default=(), kw_only=True)
    scales: Sequence[float] | None = field(default=None, kw_only=True)
    labels: Sequence[str] | None = field(default=None, kw_only=True)
    external: bool = field(default=False, kw_only=True)
    times: Sequence[float] = field(default=(), kw_only=True)
    max_step: float = field(default=np.inf, kw_only=True)

    def check(self, what: str) -> None:
        if not isinstance(self.on, Body | Ground | list | tuple):
            raise InputError(f"{what}: on {shown(self.on)}; give a Body, GROUND or a tuple of them")
        on = (self.on,) if isinstance(self.on, Body | Ground) else tuple(self.on)
        if not 1 <= len(on) <= CUSTOM_FORCE_BODIES_MAX:
            raise InputError(f"{what}: acts on {len(on)} bodies; give 1 to {CUSTOM_FORCE_BODIES_MAX}")
        for body in on:
            if not isinstance(body, Body | Ground):
                raise InputError(f"{what}: {shown(body)} is not a body; give a Body or GROUND")
        given = [np.zeros(3) if b is GROUND else b.position for b in on] if self.points is None else self.points
        given = listed(given, f"{what}: points", "one per body")
        points = tuple(vector(point, f"{what}: point no. {k + 1}") for k, point in enumerate(given))
        if len(points) != len(on):
            raise InputError(f"{what}: {len(points)} points for {len(on)} bodies; give one per body")
        named = isinstance(self.states, Mapping)
        states = sequence(self.states.values() if named else self.states, f"{what}: states")
        names = list(map(str, range(len(states)))) if self.labels is None else self.labels
        labels = listed(self.states if named else names, f"{what}: labels", "names")
        if len(labels) != len(states) or len(set(labels)) < len(labels) or not all(isinstance(x, str) for x in labels):
            raise InputError(f"{what}: labels {shown(labels)} for {len(states)} states; name each once")
        scales = (1.0,) * len(states) if self.scales is None else sequence(self.scales, f"{what}: scales")
        if len(scales) != len(states) or min(scales, default=1.0) <= 0.0:
            raise InputError(f"{what}: scales {shown(scales)} for {len(states)} states; give one number > 0 per state")
        parameters = sequence(self.parameters, f"{what}: parameters")
        if not isinstance(self.external, bool):
            raise InputError(f"{what}: external {shown(self.external)}; give True or False")
        times = tuple(sorted(set(sequence(self.times, f"{what}: times"))))
        unbound = isinstance(self.max_step, float) and self.max_step == np.inf
        longest = np.inf if unbound else number(self.max_step, f"{what}: max_step", positive=True)
        self.set(on=on, points=points, parameters=parameters, states=states, scales=scales, labels=labels)
        self.set(times=times, max_step=longest)

    def record(self) -> ForceRecord:
        scales = tuple((scale, 0.0, 0.0) for scale in self.scales)
        return ForceRecord(self.on, self.points, series=(self.parameters,), states=self.states, scales=scales)

    def state_names(self) -> tuple[str, ...]:
        return self.labels

    def address(self, dtype: type) -> int | Callable:
        """Address of the function for real or complex numbers; 0 = none."""
        raise NotImplementedError


@dataclass(frozen=True, eq=False)
class SavedForce(FunctionForce):
    """A `CustomForce` read back with a saved solution: without its function, so the system cannot be run again."""

    def address(self, dtype: type) -> int | Callable:
        return 0


@dataclass(frozen=True, eq=False)
class CustomForce(FunctionForce):
    """Loads of a function of your own, plain or jitted by numba; the time loop calls it without being recompiled.

    A run asks for the loads at the stages of its steps only, which grow as long as the motion allows: a blow of 10 ms,
    or one within a centimetre, is stepped over and nobody knows of it. Give ``times`` at which it begins and ends, or
    ``max_step``, the shortest time that it acts.

    The function has the fixed signature ``function(t, bodies, z, parameters, loads, z_dot)``:

    ========== ================= ===================================================================================
    t          float             time [s]
    bodies     (k,) records      per point: ``.r`` (3,) position [m], ``.R`` (3, 3) orientation body -> world,
                                 ``.velocity`` (3,) of the point [m/s], ``.w`` (3,) angular velocity [rad/s]; world
    z          (n,)              own states
    parameters (p,) float        the numbers given
    loads      (k, 6)            to be filled: force [N] at the point and moment about it [N m], world; zero before
    z_dot      (n,)              to be filled: rates of the own states [1/s]; zero before
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
        Initial values of the own states.
    scales : sequence of float or None
        Sizes against which errors of the own states are measured while they are smaller; None = 1 for each.
    labels : sequence of str or None
        Names of the own states, where ``states`` does not give them; None = "0", "1", ...
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
            raise InputError(f"{what}: function {shown(self.function)} is not a function; give a plain or a jitted one")
        if len(inspect.signature(plain).parameters) != len(ARGUMENTS):
            raise InputError(f"{what}: function '{plain.__name__}' must take the arguments {', '.join(ARGUMENTS)}")
        self.address(float)

    def address(self, dtype: type) -> int | Callable:
        if numba.config.DISABLE_JIT:
            return uncompiled(self.function)
        if dtype not in self.callbacks:
            try:
                self.callbacks[dtype] = callback(self.function, dtype)
            except Exception as error:  # numba has several families of them
                raise InputError(self.uncompilable(dtype, reason(error))) from error
        return self.callbacks[dtype].address

    def __getstate__(self) -> dict:
        """Copies and pickles compile the function again: addresses are those of one process."""
        return {**vars(self), "callbacks": {}}

    def uncompilable(self, dtype: type, why: str) -> str:
        """What to say of a function that numba refuses."""
        force = f"force '{self.name}' (CustomForce)" if self.name else "CustomForce without a name"
        kind, remedy = "", "use what numba supports"
        if dtype is complex:
            kind = " for the complex numbers of exact derivatives (GeneralizedAlpha, linearize)"
            remedy = "compare real parts, x.real < 0, and use np functions, mbsd3d.arctan2(y, x) for the one of np"
        return f"{force}: function '{self.function.__name__}' does not compile{kind}: {why}; {remedy}"

    def saved(self) -> "SavedForce":
        """What of it a file can hold: all but the function."""
        return SavedForce(
            on=self.on, points=self.points, parameters=self.parameters, states=self.states, scales=self.scales,
            labels=self.labels, external=self.external, times=self.times, max_step=self.max_step, name=self.name,
        )  # fmt: skip


def check_runnable(system: Mechanism) -> None:
    """ValueError for a system whose custom forces have lost their functions."""
    for force in system.forces:
        if isinstance(force, SavedForce):
            raise InputError(
                f"force '{system.name(force)}': its function was not saved with the solution, so the system cannot be "
                "run; build it again with CustomForce(function, ...)"
            )
