"""Replay of the steps of a run with the derivatives of its state by parameters p, each parameter a column.

    M da + J' dlam = d(Q - h) - dM a - dJ' lam        J da = d gamma - dJ a        dy_dot by rates(dy, da)

d(...) is the imaginary part of the kernels at complex tables T + i e dT/dp and a complex state y + i e dy/dp, with the
real a and lam; the factor on the left is that of the real step, which all columns share. The steps of an explicit
method are linear in the rates, so columns go through them as the state does; step lengths are those of the real run.
"""

from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ..compiler.arguments import by_reference
from ..compiler.decorators import inner_kernel, kernel
from ..dynamics.applied_forces import loads, right_sides
from ..dynamics.contact_steps import watch_contacts
from ..dynamics.spinning import find_spins, rate_without_spin, restore_spin
from ..dynamics.state_rates import (
    FACTOR_FROM_OTHER_POSE,
    PROJECTED,
    audit_rates,
    evaluate,
    project_and_evaluate,
)
from ..kernels.coordinates import coordinate, remember
from ..kernels.kinds import PROJECTION
from ..kernels.kinematics import displace, kinematics, normalise, push_velocities, rates
from ..kernels.layout import Model
from ..kernels.measures import measure
from ..kernels.rows import row_speed, rows
from ..kernels.vectors import add_scaled, copy, mat, put, rotate, rotate_back, vec
from ..solver.saddle_point import SOLVED, solve_refined, subtract_known
from .memory import NO_SOLUTION, NOT_CLOSING, RUNNING
from .runge_kutta import stages

COMPLEX_STEP = 1e-30  # [1] imaginary part of a complex step: its square is lost, and no difference is taken


@by_reference
class Columns(NamedTuple):
    """Derivatives by k parameters along a replay, and what is needed for them; ny numbers in a state of n bodies."""

    where: np.ndarray  # places of the imaginary parts that parameters change in `numbers`, side by side
    change: np.ndarray  # by how much: dT/dp
    ends: np.ndarray  # (k + 1,) where the changes of each parameter start
    numbers: np.ndarray  # all numbers of the complex tables, as one array of floats
    Y: np.ndarray  # (k, ny) dy/dp
    rate: np.ndarray  # (k, ny) their rates
    K: np.ndarray  # (stages, k, ny) rates of the stages of a step
    base: np.ndarray  # (ny,) real state of a stage
    y: np.ndarray  # (ny,) complex state
    dy: np.ndarray  # (ny,) its rate
    acceleration: np.ndarray  # (n, 6) real ones of the state at hand
    alpha: np.ndarray  # (n, 3)
    lam: np.ndarray  # (rows,)
    states: np.ndarray  # (samples, ny) real states of the replay at the samples of the run
    out: np.ndarray  # (samples, k, width) derivatives there: y, accelerations, lam, hinge coordinates, potential, power


@inner_kernel
def set_parameter(c, j, step):
    """Set the imaginary parts of the tables for column j; 0 takes them out."""
    for k in range(c.ends[j], c.ends[j + 1]):
        c.numbers[c.where[k]] = step * c.change[k]


@inner_kernel
def keep_solution(m, d, c):
    """Copy accelerations and multipliers of the real state, which the columns overwrite."""
    for i in range(m.body.shape[0]):
        copy(c.acceleration[i], d.body[i].acceleration)
        copy(c.alpha[i], d.body[i].alpha)
    for k in range(m.row.shape[0]):
        c.lam[k] = d.row[k].lam


@inner_kernel
def put_solution(m, d, c):
    """Put accelerations and multipliers of the real state back."""
    for i in range(m.body.shape[0]):
        copy(d.body[i].acceleration, c.acceleration[i])
        copy(d.body[i].alpha, c.alpha[i])
    for k in range(m.row.shape[0]):
        d.row[k].lam = c.lam[k]


@inner_kernel
def set_state(c, y, change, scale):
    """Set the complex state y + i scale change."""
    for k in range(y.shape[0]):
        c.y[k] = complex(y[k], scale * change[k])


@inner_kernel
def no_load(m, d):
    """Clear the upper right side."""
    for i in range(m.body.shape[0]):
        for j in range(6):
            d.body[i].top[j] = 0.0
        put(d.body[i].turn, (0.0, 0.0, 0.0))


@kernel
def rate_of_column(m, d, s, mc, dc, c, t):
    """Set the rate c.dy of the complex state c.y with the parameter that is set; return False where there is none."""
    kinematics(mc, dc, c.y)
    rows(mc, dc, t)
    loads(mc, dc, t)
    right_sides(mc, dc)
    subtract_known(mc, dc, c.acceleration, c.lam)
    no_load(m, d)
    for i in range(m.body.shape[0]):
        body, out = dc.body[i], d.body[i]
        turn = rotate(mat(body.R), vec(body.turn))
        for j in range(3):
            out.top[j] = body.top[j].imag
            out.top[3 + j] = (body.top[3 + j] + turn[j]).imag
    for k in range(m.row.shape[0]):
        d.row[k].bottom = dc.row[k].bottom.imag
    if solve_refined(m, d, s) != SOLVED:
        return False
    for i in range(m.body.shape[0]):
        body = dc.body[i]
        for j in range(6):
            body.acceleration[j] = complex(c.acceleration[i, j], d.body[i].acceleration[j])
        put(
            body.alpha, rotate_back(mat(body.R), (body.acceleration[3], body.acceleration[4], body.acceleration[5]))
        )  # fmt: skip
    for k in range(m.row.shape[0]):
        dc.row[k].lam = complex(c.lam[k], d.row[k].lam)
    rates(mc, dc, c.dy)
    audit_rates(mc, dc, c.dy)
    return True


@kernel
def project_column(m, d, s, mc, dc, c, t):
    """Put the complex state on the constraints with the factor of the real pose, positions first; False: it cannot."""
    normalise(m, c.y)
    if m.stabilisation != PROJECTION:
        return True
    for velocities in range(2):
        kinematics(mc, dc, c.y)
        rows(mc, dc, t)
        no_load(m, d)
        for k in range(m.row.shape[0]):
            d.row[k].bottom = -(row_speed(mc, dc, k) if velocities == 1 else dc.row[k].c).imag
        if solve_refined(m, d, s) != SOLVED:
            return False
        for i in range(m.body.shape[0]):
            body = dc.body[i]
            for j in range(6):
                body.acceleration[j] = complex(0.0, d.body[i].acceleration[j])
            for j in range(3):
                body.alpha[j] = complex(0.0, d.body[i].alpha[j])
        if velocities == 1:
            push_velocities(mc, dc, c.y)
        else:
            displace(mc, dc, c.y)
    return True


@inner_kernel
def columns_of_stage(m, d, s, mc, dc, own, run, c, i, h):
    """Set the rates of all columns at stage i of the step h, whose real state is in d; return False without one."""
    table, x = own.table, own.table.c[i] * h
    keep_solution(m, d, c)
    good = True
    for j in range(c.Y.shape[0]):
        set_state(c, c.base, c.Y[j], COMPLEX_STEP)
        for stage in range(i):
            if table.A[i, stage] != 0.0:
                for k in range(c.base.shape[0]):
                    c.y[k] += complex(0.0, COMPLEX_STEP * h * table.A[i, stage] * c.K[stage, j, k])
        restore_spin(m, run, x, c.y)
        set_parameter(c, j, COMPLEX_STEP)
        good = good and rate_of_column(m, d, s, mc, dc, c, run.now.t + x)
        set_parameter(c, j, 0.0)
        rate_without_spin(m, run, x, c.y, c.dy)
        for k in range(c.base.shape[0]):
            c.K[i, j, k] = c.dy[k].imag / COMPLEX_STEP
    put_solution(m, d, c)
    return good


@inner_kernel
def write_column(m, mc, dc, c, j, sample, t):
    """Store the derivatives of column j at a sample whose complex evaluation is in dc."""
    out, k = c.out[sample, j], c.Y.shape[1]
    copy(out[:k], c.Y[j])
    for i in range(m.body.shape[0]):
        for x in range(6):
            out[k + x] = dc.body[i].acceleration[x].imag / COMPLEX_STEP
        k += 6
    for i in range(m.row.shape[0]):
        out[k + i] = dc.row[i].lam.imag / COMPLEX_STEP
    k += m.row.shape[0]
    for i in range(m.coordinate.shape[0]):
        out[k + i] = coordinate(mc, dc, i, t)[0].imag / COMPLEX_STEP
    k += m.coordinate.shape[0]
    for i in range(m.force.shape[0]):
        out[k + i] = dc.force[i].potential.imag / COMPLEX_STEP
        out[k + m.force.shape[0] + i] = dc.force[i].power.imag / COMPLEX_STEP


@kernel
def arrive(m, d, s, mc, dc, run, c, t, sample):
    """Project state and columns at t, where run.y and c.Y are; set their rates, and store a sample (-1: none)."""
    status, result = project_and_evaluate(m, d, s, t, run.y, run.dy, FACTOR_FROM_OTHER_POSE)
    if status != PROJECTED:
        return NOT_CLOSING
    if result != SOLVED:
        return NO_SOLUTION
    keep_solution(m, d, c)
    good = True
    for j in range(c.Y.shape[0]):
        set_parameter(c, j, COMPLEX_STEP)
        set_state(c, run.y, c.Y[j], COMPLEX_STEP)
        good = good and project_column(m, d, s, mc, dc, c, t)
        for k in range(run.y.shape[0]):
            c.y[k] = complex(run.y[k], c.y[k].imag)
            c.Y[j, k] = c.y[k].imag / COMPLEX_STEP
        good = good and rate_of_column(m, d, s, mc, dc, c, t)
        for k in range(run.y.shape[0]):
            c.rate[j, k] = c.dy[k].imag / COMPLEX_STEP
        if sample >= 0:
            write_column(m, mc, dc, c, j, sample, t)
        set_parameter(c, j, 0.0)
    put_solution(m, d, c)
    if sample >= 0:
        copy(c.states[sample], run.y)
    remember(m, d, t)
    run.now.t = t
    return RUNNING if good else NO_SOLUTION


@kernel
def differentiate_measure(m, d, s, mc, dc, run, c, i, out):
    """Set the derivatives out (k,) of measure i by the parameters at run.y; False where there is none."""
    keep_solution(m, d, c)
    good = True
    for j in range(c.Y.shape[0]):
        set_parameter(c, j, COMPLEX_STEP)
        set_state(c, run.y, c.Y[j], COMPLEX_STEP)
        good = good and rate_of_column(m, d, s, mc, dc, c, run.now.t)
        out[j] = measure(mc, dc, i, run.now.t).imag / COMPLEX_STEP
        set_parameter(c, j, 0.0)
    put_solution(m, d, c)
    return good


@inner_kernel
def move_columns(m, run, own, c, h):
    """Move all columns over the step h; c.base is its end before spins are put back."""
    for j in range(c.Y.shape[0]):
        set_state(c, c.base, c.Y[j], COMPLEX_STEP)
        for stage in range(own.table.b.shape[0]):
            for k in range(c.base.shape[0]):
                c.y[k] += complex(0.0, COMPLEX_STEP * h * own.table.b[stage] * c.K[stage, j, k])
        restore_spin(m, run, h, c.y)
        for k in range(c.base.shape[0]):
            c.Y[j, k] = c.y[k].imag / COMPLEX_STEP


@inner_kernel
def replay_step(m, d, s, mc, dc, own, run, c, t, sample):
    """Take the step to t from a state that has arrived."""
    table, K, h = own.table, own.K, t - run.now.t
    find_spins(m, run, h)
    copy(K[0], run.dy)
    rate_without_spin(m, run, 0.0, run.y, K[0])
    for j in range(c.Y.shape[0]):
        set_state(c, run.y, c.Y[j], COMPLEX_STEP)
        for k in range(run.y.shape[0]):
            c.dy[k] = complex(run.dy[k], COMPLEX_STEP * c.rate[j, k])
        rate_without_spin(m, run, 0.0, c.y, c.dy)
        for k in range(run.y.shape[0]):
            c.K[0, j, k] = c.dy[k].imag / COMPLEX_STEP
    for i in range(1, table.c.shape[0]):
        copy(c.base, run.y)
        for stage in range(i):
            if table.A[i, stage] != 0.0:
                add_scaled(c.base, h * table.A[i, stage], K[stage])
        copy(run.work, c.base)
        restore_spin(m, run, table.c[i] * h, run.work)
        if evaluate(m, d, s, run.now.t + table.c[i] * h, run.work, K[i]) != SOLVED:
            return NO_SOLUTION
        if not columns_of_stage(m, d, s, mc, dc, own, run, c, i, h):
            return NO_SOLUTION
        rate_without_spin(m, run, table.c[i] * h, run.work, K[i])
    copy(c.base, run.y)
    for stage in range(table.b.shape[0]):
        add_scaled(c.base, h * table.b[stage], K[stage])
    move_columns(m, run, own, c, h)
    copy(run.y, c.base)
    restore_spin(m, run, h, run.y)
    return arrive(m, d, s, mc, dc, run, c, t, sample)


@kernel
def replay(m, d, s, mc, dc, own, run, c, times, samples):
    """Take the steps that end at ``times`` [s], which are the samples of these numbers (-1: none) of the run.

    m, d, s: real tables, work space and tree; mc, dc: complex ones. Return RUNNING, or why a step has no solution.
    """
    for i in range(times.shape[0]):
        status = replay_step(m, d, s, mc, dc, own, run, c, times[i], samples[i])
        if status != RUNNING:
            return status
    return RUNNING


@kernel
def gaps_at(m, d, run, t, y):
    """Store clearances, their rates and the loads of contacts and stops at a state in run.gaps[:, 1]."""
    kinematics(m, d, y)
    watch_contacts(m, d, run, 1, t)


@kernel
def gaps_ahead(m, d, s, own, run, x):
    """Store the same x after a state that has arrived, by one step; return False where it has no solution."""
    find_spins(m, run, x)
    good = stages(m, d, s, own, run, x)
    gaps_at(m, d, run, run.now.t + x, run.trial)
    return good


class ComplexTables(NamedTuple):
    """Complex tables of a model in one piece of memory."""

    model: Model
    numbers: np.ndarray  # all of them as floats
    where: np.ndarray  # places of the imaginary parts in it, in the order of `numbers_of`


TABLES = ("body", "primitive", "row", "coordinate", "reflected", "force", "signal", "term", "measure")
VECTORS = ("term_data", "number", "gravity")
# Fields that decide on the length of steps and on units of errors, never on the motion.
NOT_OF_THE_MOTION = {("body", "symmetry"), ("body", "axis"), ("row", "scale"), ("force", "address")}


def fields_of(model: Model) -> list[tuple[str, str, np.dtype]]:
    """Return (table, field, type of one number) of all fields of the tables."""
    return [
        (name, field, getattr(model, name).dtype[field].base)
        for name in TABLES
        for field in getattr(model, name).dtype.names
    ]


def numbers_of(model: Model) -> np.ndarray:
    """Return all numbers of the tables on which the motion depends, side by side."""
    found = [
        getattr(model, name)[field].ravel() * (0.0 if (name, field) in NOT_OF_THE_MOTION else 1.0)
        for name, field, kind in fields_of(model)
        if kind.kind == "f"
    ]
    return np.concatenate([*found, *(getattr(model, name) for name in VECTORS)])


def structure_of(model: Model) -> list[np.ndarray]:
    """Return all whole numbers of the tables: what stands where."""
    return [
        getattr(model, name)[field]
        for name, field, kind in fields_of(model)
        if kind.kind != "f" and (name, field) not in NOT_OF_THE_MOTION
    ]


@cache
def with_numbers(kind: np.dtype, number: type | np.dtype) -> np.dtype:
    """Return the type of a table with other numbers in the place of floats; made once, since that is slow."""
    fields = (kind.fields or {}).items()
    return np.dtype([(name, number if x.base.kind == "f" else x.base, x.shape) for name, (x, *_) in fields])


def complex_tables(model: Model) -> ComplexTables:
    """Return the tables with complex numbers, which are those of the model."""

    kinds = {name: with_numbers(getattr(model, name).dtype, complex) for name in TABLES}
    pairs = {name: with_numbers(getattr(model, name).dtype, np.dtype((np.int64, 2))) for name in TABLES}
    sizes = [kinds[name].itemsize * getattr(model, name).size for name in TABLES]
    sizes += [16 * getattr(model, name).size for name in VECTORS]
    ends = np.cumsum([0, *sizes])
    memory = np.zeros(int(ends[-1]), np.uint8)
    places = np.arange(ends[-1] // 8, dtype=np.int64).view(np.uint8)
    found: list[np.ndarray] = []
    changed: dict[str, Any] = {}
    for name, first, end in zip((*TABLES, *VECTORS), ends[:-1], ends[1:], strict=True):
        given, piece, place = getattr(model, name), memory[first:end], places[first:end]
        if name in VECTORS:
            changed[name] = piece.view(complex)
            changed[name][:] = given
            found.append(place.view(np.int64)[1::2])
            continue
        changed[name], numbered = piece.view(kinds[name]), place.view(pairs[name])
        for field in given.dtype.names:
            changed[name][field] = given[field]
            if given.dtype[field].base.kind == "f":
                found.append(numbered[field][..., 1].ravel())
    return ComplexTables(model._replace(**changed), memory.view(float), np.concatenate(found))


def new_columns(
    model: Model, tables: ComplexTables, changes: np.ndarray, Y: np.ndarray, stages: int, samples: int
) -> Columns:
    """Return the memory of columns with these changes (k, numbers) of the tables and derivatives Y (k, ny) at first."""
    k, ny = Y.shape
    on = [np.flatnonzero(row) for row in changes]
    width = ny + 6 * model.body.size + model.row.size + model.coordinate.size + 2 * model.force.size
    n = model.body.size
    return Columns(
        where=np.concatenate([tables.where[i] for i in on]),
        change=np.concatenate([row[i] for row, i in zip(changes, on, strict=True)]),
        ends=np.cumsum([0, *(i.size for i in on)]),
        numbers=tables.numbers, Y=Y.copy(), rate=np.zeros((k, ny)), K=np.zeros((stages, k, ny)), base=np.zeros(ny),
        y=np.zeros(ny, complex), dy=np.zeros(ny, complex), acceleration=np.zeros((n, 6)), alpha=np.zeros((n, 3)),
        lam=np.zeros(model.row.size), states=np.zeros((samples, ny)), out=np.zeros((samples, k, width)),
    )  # fmt: skip
