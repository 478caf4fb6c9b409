"""Check starts: penetration, the usual effect of a length in millimetres or a missing height, and forces by functions.

A tyre must have its hub above the plane in every start. A `Contact` may be as soft as one likes and start from a state
of a run in which it sank: as built it is judged by what presses it, elsewhere where it starts deeper than its surface
is large, as a plane does that a hinge has turned behind. A stop may be pressed in, but not by the reference pose.

Forces by functions are asked for what every run needs of them: loads in pairs, no memory, the times at which they jump
and the longest step.
"""

from collections.abc import Callable

import numpy as np

from ..base.checks import short_repr
from ..base.errors import InputError, IntegrationError
from ..dynamics.applied_forces import loads
from ..equations.compiled import Compiled, new_data
from ..integrators.method import Method
from ..kernels.kinematics import kinematics
from ..kernels.layout import Data, Model
from ..mechanism.bodies import GROUND
from ..mechanism.forces.contact import STANDARD_GRAVITY, Contact
from ..mechanism.forces.custom import CustomForce, FunctionForce
from ..mechanism.forces.end_stop import Stop
from ..mechanism.forces.own_functions import RETURN_FLAG_INDEX, uncompiled
from ..mechanism.forces.tyre import Tyre
from ..mechanism.mechanism import Mechanism
from ..mechanism.rounded import RoundBar
from ..results.motion import Motion
from ..results.result import RunResult
from .events import EVENT_TIME_ROUNDING

PENETRATION_SHARE_MAX = 0.9
"""[1] Largest initial penetration, as a share of the distance from the centre to the lowest point."""
CONTACT_LOAD_MAX = 10.0
"""[1] Largest force of a contact as built, in weights of its body: a soft contact may penetrate deeply under load."""

CENTRES_DISTANCE_MIN = 1e-9  # [1] of the distance at which round surfaces touch: less has no direction but rounding
DEPTH_RATIO_MAX = 4.0
"""[1] of a contact that starts elsewhere than as built: depth of the lowest point over its distance below the centre;
4 is twice the diameter of a sphere, so that the plane is a diameter above its top."""
LIMIT_ROUNDING = 1e-14  # [1] of a turn or of the farthest place: depth of a start at the limit of a stop
RESULTANT_ROUNDING = 1e-9  # [1] of the loads themselves: more than their sums round to
MEMORY_ADVICE = "keep what it remembers in states=, with its rate in z_dot, and give random numbers as a signals.Table"


def check_initial_penetration(compiled: Compiled, y: np.ndarray) -> None:
    """Refuse a wheel or surface that starts in the plane up to its centre: any `Tyre`, a `Contact` as built.

    Elsewhere a `Contact` may start deep, but not far deeper than its surface is large.
    """
    if not any([isinstance(force, Contact | Tyre) for force in compiled.system.forces]):
        return
    n = compiled.model.body.size
    start = Motion(compiled, {"t": np.zeros(1), "q": y[: 7 * n].reshape(1, n, 7)})
    for force in compiled.system.forces:
        if not isinstance(force, Contact | Tyre):
            continue
        if isinstance(force, Contact) and force.bar is not None:
            check_centres(compiled, force, force.bar, start)
            continue
        at, normal = force.plane
        up, centre = start.body_axis(force.a, normal)[0], start.body_point(force.b, force.outline.centre)[0]
        height = float(up @ (centre - start.body_point(force.a, at)[0]))
        below = float(up @ (centre - force.outline.moving(start, force.a, force.b, normal)[0]))
        if height >= (1.0 - PENETRATION_SHARE_MAX) * below:
            continue
        if isinstance(force, Contact) and is_supported(force, below - height):
            continue
        built = isinstance(force, Tyre) or is_as_built(force, centre, below)
        if not built and below - height <= DEPTH_RATIO_MAX * below:
            continue
        advice = "check its size (in m), its position and the plane"
        if not built:
            advice = "all behind a plane is solid: start on its open side, or limit a hinge by an EndStop"
        raise InputError(
            f"force '{compiled.system.name(force)}' ({type(force).__name__}): '{force.b.name}' starts "
            f"{below - height:.4g} m deep in the plane, its centre at {height:.4g} m and {below:.4g} m above its "
            f"lowest point; {advice}"
        )


def check_centres(compiled: Compiled, contact: Contact, bar: RoundBar, start: Motion) -> None:
    """Refuse a sphere that starts in the middle of another surface, or nearly there unless it is as soft as that."""
    centres = start.body_point(contact.b, contact.outline.centre)
    distance, touch = float(np.linalg.norm(bar.moving(start, contact.a, centres))), bar.radius + contact.outline.size
    kind, name = type(contact.other).__name__.lower(), compiled.system.name(contact)
    if distance <= CENTRES_DISTANCE_MIN * touch:
        middle = "axis" if bar.half > 0.0 else "centre"
        raise InputError(
            f"force '{name}' (Contact): the centre of the sphere of '{contact.b.name}' starts on the {middle} of the "
            f"{kind} of '{contact.a.name}', so that no direction leads out; move one of them"
        )
    if distance < (1.0 - PENETRATION_SHARE_MAX) * touch and not is_supported(contact, touch - distance):
        raise InputError(
            f"force '{name}' (Contact): '{contact.b.name}' starts {touch - distance:.4g} m deep in the {kind} of "
            f"'{contact.a.name}', {distance:.4g} m beside its middle; check sizes (in m) and positions"
        )


def is_supported(contact: Contact, depth: float) -> bool:
    """Return whether the contact is so soft that its force at a depth [m] is some weights of its body at most."""
    return contact.stiffness * depth**contact.exponent <= CONTACT_LOAD_MAX * STANDARD_GRAVITY * contact.b.mass


def is_as_built(contact: Contact, centre: np.ndarray, depth: float) -> bool:
    """Return whether the centre of the surface is where the reference pose has it."""
    return bool(np.linalg.norm(centre - contact.outline.centre) <= 1e-9 * depth)


def check_stops(compiled: Compiled, data: Data, y: np.ndarray) -> None:
    """Raise a ValueError for a stop that starts from the reference pose of its bodies, and that beyond a limit.

    ``data`` has the hinge coordinates of the start: some turns away, the pose is the same and may lie within.
    """
    n, index = compiled.model.body.size, compiled.body_index
    farthest = max(compiled.model.length, float(np.abs(y[: 7 * n].reshape(n, 7)[:, :3]).max()))
    for force in compiled.system.forces:
        if not isinstance(force, Stop):
            continue
        x, depth = force.record().coordinate, force.depth_as_built()
        size = 2.0 * np.pi if x is not None and x.kind != "slide" else farthest
        if depth <= LIMIT_ROUNDING * size:
            continue
        if x is not None and x.kind != "slide" and data.coordinate["value"][compiled.coordinate(x)] != 0.0:
            continue
        poses = [(y[7 * i : 7 * i + 7], body) for body in force.bodies() if (i := index[id(body)]) < n]
        if all(np.array_equal(pose, [*body.position, *body.orientation]) for pose, body in poses):
            raise InputError(
                f"force '{compiled.system.name(force)}' ({type(force).__name__}): the reference pose is {depth:.4g} "
                "beyond its limit, where angles and slides are 0; move the limit, or start inside with assemble()"
            )


def own_forces(system: Mechanism) -> list[tuple[int, FunctionForce]]:
    """Return the forces by functions, with their numbers."""
    return [(k, force) for k, force in enumerate(system.forces) if isinstance(force, FunctionForce)]


def with_jumps(turns: np.ndarray, system: Mechanism, t_start: float) -> np.ndarray:
    """Return times [s] (k, 2) at which steps end and the next ones begin: those given, and beside each jump."""
    times = [t for _, force in own_forces(system) for t in force.times]
    if not times:
        return turns
    jumps = np.array(times, float)
    beside = EVENT_TIME_ROUNDING * np.maximum(np.abs(jumps), abs(t_start))
    found = [*map(tuple, turns), *zip(jumps - beside, jumps + beside, strict=True)]
    return np.array(sorted(found), float).reshape(-1, 2)


def longest_step(method: Method, system: Mechanism) -> float:
    """Return the longest step [s] that the method and all forces allow; ValueError for fixed steps beyond that."""
    longest = method.max_step
    for _, force in own_forces(system):
        if method.dt is not None and method.dt > force.max_step:
            raise InputError(
                f"force '{system.name(force)}' (CustomForce): its max_step = {force.max_step:g} s is "
                f"shorter than the fixed steps of {method.dt:g} s; give a dt as short, or a method with adaptive steps"
            )
        longest = min(longest, force.max_step)
    return longest


def alone(compiled: Compiled, k: int) -> tuple[Model, Data]:
    """Return (model, work space) in which force k and nothing else acts."""
    model = compiled.forces_alone(slice(k, k + 1))
    return model, new_data(model)


def ask(model: Model, data: Data, y: np.ndarray, t: float) -> None:
    """Evaluate the loads at a state."""
    kinematics(model, data, y)
    loads(model, data, t)


def places(model: Model) -> tuple[slice, slice]:
    """Return where the internal states and the parameters of the only force stand."""
    (x,) = model.force
    return slice(x["state"], x["state"] + x["states"]), slice(x["number"], x["number"] + x["numbers"])


def exception_of(compiled: Compiled, k: int, y: np.ndarray, t: float) -> Exception | None:
    """Return what the function of force k raises at a state, if it does; it is run once more as Python to tell."""
    model, data = alone(compiled, k)
    ask(model, data, y, t)
    if data.wrench[RETURN_FLAG_INDEX] == 0.0:
        return None
    force = compiled.system.forces[k]
    if not isinstance(force, CustomForce):
        return None
    try:
        with np.errstate(all="ignore"):
            plain, poses = uncompiled(force.function), data.pose.view(np.recarray)
            own, numbers = places(model)
            z, given = data.z[own], model.number[numbers].copy()
            plain(t, poses, model.force["bodies"][0], z, z.size, given, given.size, data.wrench, data.state_rate[own])
    except Exception as error:  # whatever the user's code raises
        return error
    return None


def check_balance(compiled: Compiled, y: np.ndarray, t: float) -> None:
    """Refuse a `CustomForce` on several moving bodies whose loads leave a resultant, unless it is external.

    Sum F = 0 and sum (M + r x F) = 0 over its bodies, r the reference points, at the state and time given.
    """
    for k, force in own_forces(compiled.system):
        if force.external or len(set(map(id, force.on))) < 2:
            continue
        if any(body is GROUND for body in force.on):
            continue
        model, data = alone(compiled, k)
        ask(model, data, y, t)
        push, turn = data.body["Q"][:-1, :3], data.body["Q"][:-1, 3:]
        lever = np.cross(data.body["r"][:-1], push)
        left, most = np.abs(push.sum(0)).max(), np.abs(push).max()
        twist, largest = np.abs((turn + lever).sum(0)).max(), max(np.abs(turn).max(), np.abs(lever).max())
        if left > RESULTANT_ROUNDING * most or twist > RESULTANT_ROUNDING * largest:
            names = ", ".join(f"'{body.name}'" for body in force.on)
            raise InputError(
                f"force '{compiled.system.name(force)}' (CustomForce): its loads on {names} leave {left:.3g} N and "
                f"{twist:.3g} N m; give each body the opposite of what the others get, or external=True if something "
                "outside pushes"
            )


class MemoryWatch:
    """Evaluates the functions at the start again from time to time: their results must never change.

    One that remembers or draws random numbers leaves no step whose error could be estimated.
    """

    def __init__(self, compiled: Compiled, y: np.ndarray, t: float) -> None:
        self.y, self.t = y.copy(), t
        own = own_forces(compiled.system)
        self.forces = [
            (f"force '{compiled.system.name(force)}' (CustomForce)", *alone(compiled, k)) for k, force in own
        ]
        self.first: dict[str, np.ndarray] = {}

    def what_changed(self) -> tuple[str, str] | None:
        """Return (force, what it gives at the start now and before) of the first whose function has a memory."""
        for name, model, data in self.forces:
            ask(model, data, self.y, self.t)
            own, numbers = places(model)
            found = np.concatenate([data.body["Q"].ravel(), data.state_rate[own], model.number[numbers]])
            first = self.first.setdefault(name, found)
            if not np.array_equal(first, found, equal_nan=True):
                at = int(np.argmax(first != found))
                both = " and ".join(short_repr(float(values[at])) for values in (first, found))
                return name, f"at one and the same state it gives {both}"
        return None

    def check_start(self) -> None:
        """Raise a ValueError for a force that gives different loads when asked twice."""
        self.what_changed()
        if changed := self.what_changed():
            part, what = changed
            raise InputError(f"{part}: the force is not a function of state: {what}; {MEMORY_ADVICE}")

    def check(self, t: float, solution: Callable[[], RunResult]) -> None:
        """Raise an IntegrationError for a force that now gives other loads at the start than it did."""
        if changed := self.what_changed():
            part, what = changed
            raise IntegrationError(
                f"the force is not a function of state: {what}",
                time=t,
                part=part,
                solution=solution(),
                advice=MEMORY_ADVICE,
            )
