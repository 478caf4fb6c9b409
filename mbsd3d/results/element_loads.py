"""Effect of a force element on one body: wrench, power, stored energy and stretch at every sample.

The kernel of all loads is called with a table that holds this element alone, without gravity: what it leaves in Q of a
body is the wrench of the element about O. No law is implemented twice.
"""

from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from ..base.checks import short_repr
from ..base.errors import InputError
from ..base.style import Sampled
from ..dynamics.batch import joint_wrenches, loads_of_sample, loads_of_samples
from ..equations.compiled import new_data
from ..mechanism.bodies import Body, Ground
from ..mechanism.force_element import ForceElement
from ..mechanism.forces.backlash import Backlash
from ..mechanism.forces.by_table import ForceCurve
from ..mechanism.forces.contact import Contact
from ..mechanism.forces.custom import SavedForce
from ..mechanism.forces.linear_actuator import LinearActuator
from ..mechanism.forces.rope import OverPulleys
from ..mechanism.forces.springs import SpringDamper
from ..mechanism.forces.tyre import Tyre
from ..mechanism.switching import is_switching
from .result import RunResult


@dataclass(frozen=True, repr=False)
class Load(Sampled):
    """Wrench of a force element on a body at its point there, world axes; all (samples, 3) in N, N m, m.

    ``power`` [W] is what the element gives to all its bodies, ``stored`` [J] the energy in it. ``length`` [m] or
    ``angle`` [rad] is the distance or the hinge coordinate along which it acts and ``rate`` how fast that changes;
    None where there is none. ``states``, ``state_rates``: internal states by name and their rates, (samples,) each.
    """

    force: np.ndarray
    moment: np.ndarray
    point: np.ndarray
    power: np.ndarray
    stored: np.ndarray
    length: np.ndarray | None = None
    angle: np.ndarray | None = None
    rate: np.ndarray | None = None
    states: dict[str, np.ndarray] = field(default_factory=dict)
    state_rates: dict[str, np.ndarray] = field(default_factory=dict)


@dataclass(frozen=True, repr=False, kw_only=True)
class TyreLoad(Load):
    """Load of a tyre on its wheel, (samples,) each; the point is the moving contact point.

    ``normal``, ``longitudinal`` (ahead), ``lateral`` (to the left) [N] and ``aligning`` moment [N m]; velocities of the
    tread ``slip_x``, ``slip_y`` and |speed| of the hub [m/s]; ``camber`` [rad] to the right; ``saturation``: the part
    of the grip that is used, 0 ... 1 (0 where it has no limit).
    """

    normal: np.ndarray
    longitudinal: np.ndarray
    lateral: np.ndarray
    aligning: np.ndarray
    slip_x: np.ndarray
    slip_y: np.ndarray
    speed: np.ndarray
    camber: np.ndarray
    saturation: np.ndarray

    @property
    def slip_angle(self) -> np.ndarray:
        """Return the angle from the rolling direction to the wheel's heading [rad], > 0 for a force to the left."""
        return -np.arctan2(self.slip_y, self.speed)

    @property
    def slip_ratio(self) -> np.ndarray:
        """Return slip over the speed of the hub, > 0 where the force is ahead; infinite or NaN at rest.

        The force points ahead on a driven wheel, and on one that is braked while it rolls back.
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            return -self.slip_x / self.speed


@dataclass(frozen=True, repr=False, kw_only=True)
class RopeLoad(Load):
    """Load of a rope or a belt on a body that it passes; its wrench is given at the first point or centre there.

    ``tension`` [N] of each section between ends and rough pulleys, of each strand of a belt (samples, k); ``wrap``
    [rad] on each pulley in turn, of a belt on the second one (samples, p).
    """

    tension: np.ndarray
    wrap: np.ndarray


def load_of(solution: RunResult, force: ForceElement | str, on: Body | Ground | str | None = None) -> Load:
    """Return the load of a force element; see `Solution.force`."""
    if solution.pieces:
        return joined_loads([load_of(piece, force, on) for piece in solution.pieces])
    system = solution.system
    part = system.part(force, "forces")
    if isinstance(part, SavedForce):
        raise InputError(
            f"solution.force: the function of '{system.name(part)}' was not saved with the solution, so its force is "
            "not known; read it before saving, or run the model again"
        )
    body = acted_body(solution, part, on)
    wrench, power, rates, shown = wrenches_about_O(solution, part, body)
    point = shown[:, :3] if part.shows else acting_points(solution, part, body)
    origin = 0.0 if isinstance(body, Ground) else solution.position(body)
    push = wrench[:, :3]
    stored = solution.arrays["potential"][:, system.forces.index(part)]
    own, own_rates = (dict(zip(part.state_names(), x.T, strict=True)) for x in (solution.state_of(part), rates))
    turn = wrench[:, 3:] - np.cross(point - origin, push)
    found: dict[str, Any] = {"force": push, "moment": turn, "point": point, "power": power, "stored": stored}
    found |= {**stretch(solution, part), "states": own, "state_rates": own_rates}
    if isinstance(part, OverPulleys):
        tension, wrap = tensions_and_wraps(solution, part)
        return RopeLoad(**found, tension=tension, wrap=wrap)
    if not isinstance(part, Tyre):
        return Load(**found)
    seen = dict(zip(part.shows, shown[:, 3:].T, strict=True))
    return TyreLoad(**found, **(seen | {"camber": np.arcsin(seen["camber"])}))


def joined_loads(pieces: list[Load]) -> Load:
    """Return the load of a run in pieces."""
    found: dict[str, Any] = {}
    for x in fields(pieces[0]):
        values = [getattr(one, x.name) for one in pieces]
        if isinstance(values[0], dict):
            found[x.name] = {key: np.concatenate([one[key] for one in values]) for key in values[0]}
        else:
            found[x.name] = None if values[0] is None else np.concatenate(values)
    return type(pieces[0])(**found)


def acted_body(solution: RunResult, part: ForceElement, on: Body | Ground | str | None) -> Body | Ground:
    """Return the body asked for: None = body b of two, the last one of a `CustomForce`."""
    bodies = list({id(body): body for body in part.record().bodies}.values())
    if on is None:
        return bodies[-1]
    for body in bodies:
        if on is body or (isinstance(on, str) and on == body.name):
            return body
    names = ", ".join(f"'{body.name}'" for body in bodies)
    what = f"solution.force: '{solution.system.name(part)}'"
    raise InputError(f"{what} does not act on {short_repr(getattr(on, 'name', on))}; it acts on {names}")


def acting_points(solution: RunResult, part: ForceElement, body: Body | Ground) -> np.ndarray:
    """Return the points (samples, 3) of `ForceElement.acts_at`, or where the joint gives its reaction."""
    if part.record().coordinate is not None and part.partners():
        return part.partners()[0].reaction_points(solution)
    if isinstance(part, Contact):
        return part.acting_points(solution)
    return solution.body_point(*part.acts_at(body))


def wrenches_about_O(
    solution: RunResult, part: ForceElement, body: Body | Ground
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return the wrench of a force element about O on a body, its power and its rates.

    The tuple is (force and moment (samples, 6), power given to all bodies (samples,), rates of the internal states
    (samples, k), what the law shows (samples, 12)).
    """
    compiled, arrays, samples = solution.compiled, solution.arrays, solution.t.size
    compiled.data()  # a custom function is compiled and its address in the table
    k = solution.system.forces.index(part)
    alone = compiled.forces_alone(slice(k, k + 1))
    data, index = new_data(alone), compiled.body_index[id(body)]
    wrench, power, shown = np.empty((samples, 6)), np.empty(samples), np.empty((samples, 12))
    rates = np.empty((samples, int(alone.force["states"][0])))
    named = (arrays[name] for name in ("state", "coordinate", "lam", "v"))
    *seen, v = (np.ascontiguousarray(x) for x in (solution.t, *named))
    loads_of_samples(alone, data, *seen, v, index, wrench, power, rates, shown)
    if is_switching(part):
        rows, held = compiled.rows[id(part)], np.zeros((1, samples, 6))
        joint_wrenches(compiled.model, compiled.data(), *seen, np.array([[rows.start, rows.stop, index]]), held)
        wrench += held[0]
    return wrench, power, rates, shown


def tensions_and_wraps(solution: RunResult, part: OverPulleys) -> tuple[np.ndarray, np.ndarray]:
    """Return (tensions (samples, k) [N], wraps (samples, p) [rad]) of a rope or a belt."""
    arrays, k = solution.arrays, solution.system.forces.index(part)
    alone = solution.compiled.forces_alone(slice(k, k + 1))
    data, tensions, wraps = new_data(alone), [], []
    for i in range(solution.t.size):
        loads_of_sample(alone, data, solution.t[i], arrays["state"][i], arrays["coordinate"][i], arrays["lam"][i])
        tension, wrap = part.read(data.scratch)
        tensions.append(tension.copy())
        wraps.append(wrap.copy())
    return np.array(tensions), np.array(wraps)


def stretch(solution: RunResult, part: ForceElement) -> dict[str, np.ndarray]:
    """Return the length or angle along which an element acts, and its rate."""
    x = part.record().coordinate
    if x is not None:
        values = solution.arrays["coordinate"][:, solution.compiled.coordinate(x)]
        return {"angle" if x.kind == "angle" else "length": values, "rate": solution._coordinate_rate(x)}
    if isinstance(part, Backlash):
        terms = list(zip((x.coordinate for x in part.record().measures), part.record().series[0], strict=True))
        rate = sum(weight * solution._coordinate_rate(x) for x, weight in terms)
        return {"angle": solution.measure(part.play), "rate": rate}
    if isinstance(part, SpringDamper | ForceCurve | LinearActuator):
        (p_a, v_a), (p_b, v_b) = (
            solution._point_motion(body, at) for body, at in ((part.a, part.at_a), (part.b, part.at_b))
        )
        length, opening = np.linalg.norm(p_b - p_a, axis=1), np.linalg.norm(v_b - v_a, axis=1)  # from no length
        along = np.einsum("ti,ti->t", p_b - p_a, v_b - v_a)
        return {"length": length, "rate": np.divide(along, length, out=opening, where=length > 0.0)}
    return {}
