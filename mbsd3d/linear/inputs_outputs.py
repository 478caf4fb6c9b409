"""Effect of inputs on small motions, and of small motions on outputs.

With input values u that set forces, and u, u', u'' that prescribe motions, deviations X of `variations` obey

    X = E x + P0 u + P1 u',   X_dot = F X + G0 u + G1 u' + G2 u'',   y = Y X + Z0 u + Z1 u' + Z2 u''.

A driver row ``c = g(q) - f`` has ``C X = u`` and ``J v = u'``, so P0 and P1 are particular solutions whose states x
are zero, and ``J v_dot = ... + u''`` gives G2; a row of a prescribed speed has ``J v = u``. F and Y are complex steps.
G and Z come from one more solution of the saddle point with the change of loads and of gamma as its right side: it is
linear, so they are exact to rounding.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg

from ..base.checks import as_tuple, short_repr
from ..base.errors import AssemblyError, InputError
from ..constraints.rank import choose_rows
from ..dynamics.state_rates import solve_for_loads
from ..equations.at_state import load_rows
from ..equations.compiled import Compiled, set_input, with_own_inputs
from ..equations.jacobian import RANK_TOLERANCE, displacement_units
from ..equations.tables import signals_of
from ..equations.tree import build_spanning_tree
from ..kernels import kinds
from ..kernels.kinematics import kinematics
from ..kernels.layout import Tree
from ..mechanism.bodies import GROUND, Body
from ..mechanism.drivers import Driver
from ..mechanism.force_element import ForceElement
from ..mechanism.forces.contact import Contact
from ..mechanism.joints import Joint
from ..mechanism.measures import Measure, check_members
from ..mechanism.mechanism import Mechanism
from ..mechanism.signals.signal import Input
from ..results.result import RunResult
from ..solver.saddle_point import SOLVED
from .variations import COMPLEX_STEP, Field, Tangent, Variations, directions, loads_and_rates, solve, values

DIFFERENCE_WEIGHTS = (4 / 5, -1 / 5, 4 / 105, -1 / 280)  # [1] of f(u + k h) - f(u - k h), k = 1 ... 4: error O(h^8)
DIFFERENCE_STEP = 2.0**-6  # [1] h over the larger of |u| and 1: h^8 is some 4e-15, rounding over h 7e-15
DIFFERENCE_TOLERANCE = 1e-9  # [1] of the derivative: what steps h and h / 2 may differ by
ORDERS = 3  # u, u', u''

Wanted = Measure | tuple[Any, ...]


@dataclass(frozen=True, eq=False)
class Effects:
    """Changes at a state of n bodies by a unit change of each of k inputs."""

    load: np.ndarray  # (k, n, 6) force and moment about O, world
    z_rate: np.ndarray  # (k, z_work)
    motion: np.ndarray  # (rows, k) of f in c = g(q) - f
    speed: np.ndarray  # (rows, k) of f in J v = f


def names_of(
    system: Mechanism, inputs: Sequence[Input | str] | None, asked: str = "state_space"
) -> tuple[str, ...]:  # fmt: skip
    """Return the names of the inputs that are asked for, all of the system for None; errors name who asked."""
    have = dict.fromkeys(term.input[0] for _, signal in signals_of(system) for term in signal.terms() if term.input)
    inputs = tuple(have) if inputs is None else (inputs,) if isinstance(inputs, Input | str) else inputs
    names = []
    for x in as_tuple(inputs, f"{asked}: inputs", "a list of Input signals or their names"):
        name = x.name if isinstance(x, Input) else x
        if not isinstance(name, str) or name not in have:
            there = ", ".join(f"'{x}'" for x in have) or "none"
            raise InputError(
                f"{asked}: inputs: {short_repr(name)} is not an input of this system; there are {there}: "
                "give a force, torque or driver an mbsd3d.Input"
            )
        if name in names:
            raise InputError(f"{asked}: inputs: '{name}' is given twice; give each input once")
        names.append(name)
    if not names:
        raise InputError(f"{asked}: no input; give a force, torque or driver an mbsd3d.Input")
    return tuple(names)


def factors(compiled: Compiled, signal: int, name: str) -> list[float]:
    """Return the factors of an input in a signal of the tables, one per term; empty if it does not read it."""
    first, end = compiled.model.signal[signal] if signal >= 0 else (0, 0)
    return [x.factor for x in compiled.inputs if x.name == name and first <= x.term < end]


def input_unit(compiled: Compiled, name: str) -> str:
    """Return the unit of an input, "-" for one that sets different quantities or a multiple of one."""
    found, model = [], compiled.model
    for primitive in model.primitive:
        row = model.row[primitive["row"]]
        unit = ("m" if row["metres"] else "rad") + ("" if row["holonomic"] else "/s")
        found += [(unit, x) for x in factors(compiled, primitive["signal"], name)]
    for force, table in zip(compiled.system.forces, model.force, strict=True):
        found += [(force.signal_unit(), x) for signal in table["signal"] for x in factors(compiled, signal, name)]
    units = {unit if abs(factor) == 1.0 else "-" for unit, factor in found}
    return units.pop() if len(units) == 1 else "-"


def effects_of(field: Field, t: float, y: np.ndarray, names: Sequence[str]) -> Effects:
    """Return what each input changes at a state y whose rows are loaded."""
    compiled = field.compiled
    model, rows = compiled.model, compiled.model.row.size
    load = np.zeros((len(names), model.body.size, 6))
    z_rate, motion, speed = np.zeros((len(names), model.z_work)), *np.zeros((2, rows, len(names)))
    for j, name in enumerate(names):
        load[j], z_rate[j] = change_of_loads(field, t, y, name)
        for primitive in model.primitive:
            row = primitive["row"]
            if primitive["kind"] == kinds.ORIENT and factors(compiled, primitive["signal"], name):
                driver = compiled.system.name(compiled.holders[compiled.row_joint[row]])
                raise InputError(f"state_space: input '{name}' sets an orientation, of '{driver}'; give that input to "
                                 "an AngleDriver on a hinge, or to a torque")  # fmt: skip
            prescribed = motion if model.row["holonomic"][row] == 1 else speed
            prescribed[row, j] += sum(factors(compiled, primitive["signal"], name))
    return Effects(load, z_rate, motion, speed)


def change_of_loads(
    field: Field, t: float, y: np.ndarray, name: str, only: int | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return d(force and moment about O)/du (n, 6) and d(rates of internal states)/du of all laws that read an input.

    Central differences of order 8 of these laws alone: exact to rounding where a law is linear in u, as nearly all are.
    ``only``: of one force element.
    """
    model = field.compiled.model
    reads = np.array([any(factors(field.compiled, x, name) for x in own) for own in model.force["signal"]], bool)
    alone = field.compiled.forces_alone(reads if only is None else reads & (np.arange(reads.size) == only))
    n = model.body.size
    if not alone.force.size:
        return np.zeros((n, 6)), np.zeros(model.z_work)
    own, data = with_own_inputs(replace(field.compiled, model=alone)), field.loaded_alone(alone, y)
    start = next(x.start for x in field.compiled.inputs if x.name == name)

    def at(u: float) -> np.ndarray:
        set_input(own, name, u)
        return loads_and_rates(own.model, data, t)

    def slope(h: float) -> np.ndarray:
        return sum(c * (at(start + k * h) - at(start - k * h)) for k, c in enumerate(DIFFERENCE_WEIGHTS, 1)) / h

    h = DIFFERENCE_STEP * max(abs(start), 1.0)
    wide, narrow = slope(h), slope(0.5 * h)
    if not np.abs(wide - narrow).max() <= DIFFERENCE_TOLERANCE * np.abs(narrow).max():
        raise InputError(f"state_space: the force that reads input '{name}' has no derivative at {start:g}; start from "
                         "another value")  # fmt: skip
    return wide[: 6 * n].reshape(n, 6), wide[6 * n :]


def particular(
    field: Field, at: Variations, space: Tangent, effects: Effects, names: Sequence[str]
) -> tuple[np.ndarray, np.ndarray]:
    """Return P0, P1 (N, k): the deviations of unit u and u' whose states x are zero."""
    model, k = field.compiled.model, len(names)
    n = 6 * model.body.size
    column, scale = displacement_units(model.length, model.body.size)[:, None], model.row["scale"][:, None]

    def solution(A: np.ndarray, right: np.ndarray) -> np.ndarray:
        if not A.size or not right.any():
            return np.zeros((n, k))
        return column * scipy.linalg.lstsq(scale * A * column.T, scale * right, cond=RANK_TOLERANCE)[0]

    P0, P1 = np.zeros((2, at.F.shape[0], k))
    P0[:n] = solution(at.C[:, :n], effects.motion)
    P0[n : 2 * n] = solution(at.D[:, n : 2 * n], effects.speed - at.D @ P0)
    P1[n : 2 * n] = solution(at.D[:, n : 2 * n], effects.motion)
    P0, P1 = (P - space.E @ P[space.chosen] for P in (P0, P1))
    left = scale * np.hstack([at.C @ P0 - effects.motion, at.D @ P0 - effects.speed, at.D @ P1 - effects.motion])
    size = np.abs(scale * np.hstack([effects.motion, effects.speed])).max(initial=0.0)
    if np.abs(left).max(initial=0.0) > 1e-7 * size:
        name = names[int(np.argmax(np.abs(left).max(axis=0))) % k]
        raise InputError(f"state_space: input '{name}' prescribes a motion that other joints or drivers do not allow; "
                         "see system.check()")  # fmt: skip
    return P0, P1


class Output(NamedTuple):
    """One output, or the components of one."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    powers: tuple[float, float, float]  # its size is length^a rate^b (mass of all bodies)^c
    measure: int = -1  # which measure it is,
    derivative: bool = False  # or whose rate
    read: Callable[[np.ndarray, np.ndarray], np.ndarray] | None = None  # tables of bodies and rows -> (columns, k)
    vector: bool = False  # whether three components each turn with a mechanism that turns as a whole
    element: int | None = None  # which force element alone the table of bodies belongs to


VECTORS = {"acceleration": ("m/s^2", (1.0, 2.0, 0.0)), "alpha": ("rad/s^2", (0.0, 2.0, 0.0))}
KINDS = (
    "a measure, ('derivative', measure), ('acceleration' or 'alpha', body), ('reaction', joint), ('effort', driver) or "
    "('force', element)"
)


def checked_wanted(system: Mechanism, outputs: Sequence[Wanted]) -> list[Wanted]:
    """Return the outputs as a list, each a measure of this system or a pair (quantity, part)."""
    given = (
        [outputs] if isinstance(outputs, Measure) else as_tuple(outputs, "state_space: outputs", f"a list of {KINDS}")
    )
    found: list[Wanted] = []
    for x in given:
        pair = isinstance(x, tuple | list) and len(x) == 2
        measure = x[1] if pair and x[0] == "derivative" else x
        if isinstance(measure, Measure):
            check_members(system, measure, "state_space: outputs")
            found.append(x)
        elif pair and x[0] in VECTORS:
            found.append((x[0], system.part(x[1], "bodies")))
        elif pair and x[0] in ("reaction", "effort"):
            found.append((x[0], system.part(x[1], "joints")))
        elif pair and x[0] == "force":
            found.append((x[0], system.part(x[1], "forces")))
        else:
            raise InputError(f"state_space: outputs: {short_repr(x)} is not an output; give {KINDS}")
    if not found:
        raise InputError(f"state_space: no output; give {KINDS}")
    return found


def measures_of(wanted: Sequence[Wanted]) -> tuple[Measure, ...]:
    """Return the measures that outputs read, one each."""
    return tuple(
        x if isinstance(x, Measure) else x[1] for x in wanted if isinstance(x, Measure) or x[0] == "derivative"
    )


def outputs_of(field: Field, wanted: Sequence[Wanted], start: RunResult) -> list[Output]:
    """Return the outputs; ``start``: accelerations and reactions at the state, which say what is determined."""
    found, measures = [], 0
    for x in wanted:
        if isinstance(x, Measure) or x[0] == "derivative":
            rate = not isinstance(x, Measure)
            one: Measure = x if isinstance(x, Measure) else x[1]
            name = f"rate of change of {one.label}" if rate else one.label
            found.append(
                Output((name,), (per_second(one.unit) if rate else one.unit,), (0.0, 0.0, 0.0), measures, rate)
            )
            measures += 1
        elif x[0] in VECTORS:
            found.append(vector_output(field, *x))
        elif x[0] == "effort":
            found.append(effort_output(field, x[1], start))
        elif x[0] == "force":
            found += force_outputs(field, x[1])
        else:
            found += reaction_outputs(field, x[1], start)
    return found


def per_second(unit: str) -> str:
    """Return the unit of the rate of change of a quantity."""
    return {"m/s": "m/s^2", "rad/s": "rad/s^2"}.get(unit, f"{unit}/s")


def vector_output(field: Field, kind: str, body: Body) -> Output:
    """Return the acceleration of the reference point of a body, or its angular acceleration."""
    i, part = field.compiled.body_index[id(body)], slice(0, 3) if kind == "acceleration" else slice(3, 6)
    unit, powers = VECTORS[kind]
    names = tuple(f"{kind} {axis} of {field.compiled.system.name(body)}" for axis in "xyz")
    return Output(names, (unit,) * 3, powers, read=lambda bodies, rows: bodies["acceleration"][:, i, part], vector=True)


def effort_output(field: Field, driver: Joint, start: RunResult) -> Output:
    """Return the torque or force of a driver."""
    compiled, name = field.compiled, field.compiled.system.name(driver)
    if not isinstance(driver, Driver):
        raise InputError(f"state_space: outputs: '{name}' ({type(driver).__name__}) is not a driver; give its reaction")
    check_unique(start, driver, "effort")
    rows = compiled.rows[id(driver)]
    metres = compiled.model.row["metres"][rows] == 1
    names = tuple(f"effort of {name}" + (f" [{k}]" if metres.size > 1 else "") for k in range(metres.size))
    units, powers = tuple("N" if x else "N m" for x in metres), (1.0 if metres[0] else 2.0, 2.0, 1.0)
    return Output(names, units, powers, read=lambda bodies, table: -table["lam"][:, rows])


def reaction_outputs(field: Field, joint: Joint, start: RunResult) -> list[Output]:
    """Return force and moment of a joint on its body b at the joint's point; the force alone where that travels."""
    check_unique(start, joint, "reaction")
    wrench = partial(wrench_on_b, field, joint)
    both = wrench_outputs(field.compiled.system.name(joint), wrench)
    return both if type(joint).reaction_points is Joint.reaction_points else both[:1]


def wrench_outputs(
    name: str, wrench: Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]], element: int | None = None
) -> list[Output]:
    """Return force and moment of a part; ``wrench``: of the tables of bodies and rows, (columns, 3) each."""
    force = Output(tuple(f"force {axis} of {name}" for axis in "xyz"), ("N",) * 3, (1.0, 2.0, 1.0),
                   read=lambda *tables: wrench(*tables)[0], vector=True, element=element)  # fmt: skip
    moment = Output(tuple(f"moment {axis} of {name}" for axis in "xyz"), ("N m",) * 3, (2.0, 2.0, 1.0),
                    read=lambda *tables: wrench(*tables)[1], vector=True, element=element)  # fmt: skip
    return [force, moment]


def force_outputs(field: Field, part: ForceElement) -> list[Output]:
    """Return force and moment of an element on its last body but the ground; the force alone if its point travels."""
    compiled = field.compiled
    body = [x for x in part.record().bodies if x is not GROUND][-1]
    index, point = compiled.body_index[id(body)], fixed_point(part, body)
    place = np.zeros(3) if point is None else body.local_point(point)

    def wrench(bodies: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        load = bodies["Q"][:, index]
        arm = bodies["R"][:, index].reshape(-1, 3, 3) @ place
        return load[:, :3], load[:, 3:] - np.cross(arm, load[:, :3])

    both = wrench_outputs(compiled.system.name(part), wrench, compiled.system.forces.index(part))
    return both[:1] if point is None else both


def fixed_point(part: ForceElement, body: Body) -> np.ndarray | None:
    """Return the point of a body at which an element acts on it, world at the reference pose; None where it travels."""
    x = part.record().coordinate
    if x is not None and part.partners():
        joint = part.partners()[0]
        return body.position if x.kind == "angle" else joint.point() if body is joint.b else None
    carrier, point = part.acts_at(body)
    return None if part.shows or isinstance(part, Contact) or carrier is not body else point


def wrench_on_b(field: Field, joint: Joint, bodies: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return force and moment (columns, 3) of the rows of a joint on its body b, about the joint's point."""
    compiled = field.compiled
    own, index = compiled.rows[id(joint)], compiled.body_index[id(joint.b)]
    on_b = compiled.model.row["body"][own] == index
    total = -np.einsum("ks,ck,cksj->cj", on_b, rows["lam"][:, own], rows["J"][:, own])
    arm = np.broadcast_to(joint.point(), (len(rows), 3))
    if joint.b is not GROUND:
        arm = bodies["R"][:, index].reshape(-1, 3, 3) @ joint.b.local_point(joint.point())
    return total[:, :3], total[:, 3:] - np.cross(arm, total[:, :3])


def check_unique(start: RunResult, joint: Joint, what: str) -> None:
    """Raise an error for reactions that the constraints do not determine."""
    if not start.reaction(joint).unique:
        raise InputError(
            f"state_space: outputs: the {what} of '{start.system.name(joint)}' is not determined, since joints are "
            "redundant; leave it out or remove the redundancy, see system.check()"
        )


class Matrices(NamedTuple):
    """All linear maps at one state: N deviations, k inputs, p outputs; Y and Z of derivatives are still zero."""

    effects: Effects
    G: np.ndarray  # (3, N, k)
    Y: np.ndarray  # (p, N)
    Z: np.ndarray  # (3, p, k)


def matrices(
    field: Field, at: Variations, t: float, y: np.ndarray, names: Sequence[str], outputs: Sequence[Output]
) -> Matrices:
    """Return the effects of inputs and the maps of outputs at a state."""
    model, moves = field.compiled.model, directions(field.compiled.model, y)
    load_rows(field.compiled, field.real, y, t)
    chosen = choose_rows(model, field.real)
    tree = build_spanning_tree(model, field.real, chosen, complex)
    effects = effects_of(field, t, y, names)
    n, N, k = model.body.size, moves.shape[1], len(names)
    table = field.columns(tree, t, y, moves) if any(x.read for x in outputs) else {}
    forced = forced_columns(field, tree, t, y, effects)
    G = np.zeros((ORDERS, N, k))
    G[:, 6 * n : 12 * n] = forced_change(values(model, *forced)["acceleration"], k)
    G[0, 12 * n :] = effects.z_rate.T
    tables: dict[
        int | None, tuple[np.ndarray, np.ndarray]
    ] = {}  # of bodies, moved and forced: of all or of one element
    if table:
        tables[None] = table["body"], forced[0]
    for element in dict.fromkeys(x.element for x in outputs if x.element is not None):
        moved = element_columns(field, element, t, y[:, None] + 1j * COMPLEX_STEP * moves)
        tables[element] = moved, forced_element(field, element, t, y, names)
    Y, Z = [], []
    for x in outputs:
        p = len(x.names)
        if x.read:
            bodies, forced_bodies = tables[x.element]
            Y.append(x.read(bodies, table["row"]).imag.T / COMPLEX_STEP)
            Z.append(forced_change(x.read(forced_bodies, forced[1]), k))
        else:
            Y.append(at.L[[x.measure]])
            Z.append(np.zeros((ORDERS, p, k)))
    return Matrices(effects, G, np.vstack(Y), np.concatenate(Z, axis=1))


def element_columns(field: Field, element: int, t: float, states: np.ndarray) -> np.ndarray:
    """Return tables of bodies (c, n + 1) with the loads of one force element alone at complex states (ny, c)."""
    alone = field.compiled.forces_alone(slice(element, element + 1))
    data = field.loaded_alone(alone, states[:, 0], complex)
    found = []
    for y in states.T:
        kinematics(alone, data, np.ascontiguousarray(y))
        loads_and_rates(alone, data, t)
        found.append(data.body.copy())
    return np.array(found)


def forced_element(field: Field, element: int, t: float, y: np.ndarray, names: Sequence[str]) -> np.ndarray:
    """Return tables of bodies (3 k, n + 1) whose imaginary parts are what unit u, u', u'' change of one element."""
    body = element_columns(field, element, t, y[:, None].astype(complex))
    found = np.repeat(body, ORDERS * len(names), axis=0)
    for j, name in enumerate(names):
        found["Q"][j, : field.compiled.model.body.size] += (
            1j * COMPLEX_STEP * change_of_loads(field, t, y, name, element)[0]
        )
    return found


def forced_change(columns: np.ndarray, k: int) -> np.ndarray:
    """Return (3, p, k) derivatives with respect to u, u', u'' from complex columns (3 k, p)."""
    return columns.imag.reshape(ORDERS, k, -1).swapaxes(1, 2) / COMPLEX_STEP


def forced_columns(
    field: Field, tree: Tree, t: float, y: np.ndarray, effects: Effects
) -> tuple[np.ndarray, np.ndarray]:
    """Return tables of bodies and rows (3 k, ...) whose imaginary parts are what unit u, u', u'' change at once."""
    model, data, n = field.compiled.model, field.data, field.compiled.model.body.size
    solve(model, data, tree, t, y.astype(complex))
    body, row, force, found = data.body.copy(), data.row.copy(), data.force.copy(), []
    k = effects.load.shape[0]
    nothing, still = np.zeros((k, n, 6)), np.zeros((row.size, k))
    for load, gamma in ((effects.load, still), (nothing, effects.speed), (nothing, effects.motion)):
        for j in range(k):
            data.body[:], data.row[:], data.force[:] = body, row, force
            data.body["Q"][:n] += 1j * COMPLEX_STEP * load[j]
            data.row["gamma"] += 1j * COMPLEX_STEP * gamma[:, j]
            if solve_for_loads(model, data, tree) != SOLVED:
                raise AssemblyError("state_space: the equations of motion have no solution", time=t,
                                    advice="see system.check()")  # fmt: skip
            bodies, rows = body.copy(), row.copy()
            bodies["acceleration"][:n] = data.body["acceleration"][:n]
            rows["lam"] = data.row["lam"]
            found.append((bodies, rows))
    return np.array([x for x, _ in found]), np.array([x for _, x in found])


def with_derivatives(found: Matrices, F: np.ndarray, outputs: Sequence[Output]) -> Matrices:
    """Fill in the rates of measures: y = L X has y' = L (F X + G0 u + G1 u' + G2 u'')."""
    rates, place = [], 0
    for x in outputs:
        if x.derivative:
            rates.append(place)
        place += len(x.names)
    Y, Z = found.Y.copy(), found.Z.copy()
    Z[:, rates] = found.Y[rates] @ found.G
    Y[rates] = found.Y[rates] @ F
    return found._replace(Y=Y, Z=Z)


def turned(outputs: Sequence[Output], Q: np.ndarray) -> np.ndarray:
    """Return the matrix (p, p) that turns vectors among the outputs with the mechanism."""
    return scipy.linalg.block_diag(*(Q[:3, :3] if x.vector else np.eye(len(x.names)) for x in outputs))
