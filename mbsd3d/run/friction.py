"""Friction by reactions in a run: the normal load must be determinate, and the joint must not jam or come to rest.

A joint that slips in more than one way is held by no row: without elastic slip its friction has a direction only while
it slips. Where it comes to rest and would not move on in either way, an adaptive method goes on in ever shorter steps,
and fixed steps go to and fro: both are ended.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..base.errors import InputError, IntegrationError
from ..constraints.rank import tree_over_rows
from ..constraints.redundancy import diagnose
from ..dynamics.applied_forces import loads
from ..dynamics.joint_friction import HOLDS_ITSELF, pressing_loads
from ..dynamics.state_rates import evaluate
from ..equations.at_state import load_rows
from ..equations.compiled import Compiled
from ..integrators.memory import Run
from ..kernels.layout import Data, Tree
from ..mechanism.forces.dry_friction import DryFriction
from ..results.checks.friction import gain_at
from ..results.reactions import RunRows, tolerance_of
from ..results.result import RunResult
from ..solver.saddle_point import SOLVED

STEPS_TO_REST = 3.0  # [steps] within which a joint comes to rest that is watched
STEPS_LOOKED_AHEAD = 100.0  # [steps] within which those may come to rest whose friction is turned round for the test
SLOPE_SHARE = 1e-3  # [1] of a step: over which the difference goes that gives the rate of a slip speed
HELD_GAIN = 0.99  # [1] at the last state before friction holds itself, which a run does not reach


class Blamed(NamedTuple):
    """The joint whose friction ends a run, why, and what to do."""

    part: str
    what: str
    advice: str


def check_friction_loads(start: RunRows) -> None:
    """Raise an InputError for friction by loads that the joints do not determine at the start.

    A share that is open, J' N = 0 with N != 0, must leave what presses as it is.
    """
    compiled = start.compiled
    if not compiled.model.frictions:
        return
    for found, _ in start.probes():
        data, limit = compiled.data(), tolerance_of(found)
        start.probe(0, data)  # loads the rows
        for k, force in enumerate(compiled.system.forces):
            if isinstance(force, DryFriction) and open_load(compiled, data, found, k) > limit:
                joint = compiled.system.name(force.joint)
                cures = diagnose(compiled.system, None).cures
                remedy = f"; {cures[0].text}" if cures else "; see system.check()"
                raise InputError(
                    f"force '{compiled.system.name(force)}' (DryFriction): the joints do not determine what presses in "
                    f"'{joint}', as rows repeat each other{remedy}"
                )


def open_load(compiled: Compiled, data: Data, found: list, k: int) -> float:
    """Return the largest pressing load of force k by a unit share that the joints leave open, made dimensionless."""
    model, largest = compiled.model, 0.0
    unit = model.length / compiled.system.forces[k].record().parameters["lever"]
    for island in found:
        for share in island.N.T:
            presses = np.zeros((2, 3))
            data.row["lam"] = 0.0
            data.row["lam"][island.rows] = share * model.row["scale"][island.rows]
            pressing_loads(model, data, k, presses)
            largest = max(largest, float(np.linalg.norm(presses, axis=1).max()) * unit)
    return largest


def find_held_friction(compiled: Compiled, data: Data, y: np.ndarray, t: float) -> Blamed | None:
    """Return the joint whose friction holds itself at a state, if it does."""
    if not compiled.model.frictions:
        return None
    load_rows(compiled, data, y, t)
    if not np.isfinite(data.row["J"]).all():
        return None
    tree = tree_over_rows(compiled.model, data, 0.0)
    status = evaluate(compiled.model, data, tree, t, y, np.empty_like(y))
    gain = gain_at(compiled, data, tree)
    if status != HOLDS_ITSELF and not gain.value >= HELD_GAIN:
        return None
    joint = gain.friction.joint
    size = "a longer guide, " if gain.friction.guide_length is not None else "a smaller radius, "
    return Blamed(
        f"{type(joint).__name__} '{compiled.system.name(joint)}'",
        f"friction holds itself, gain {gain.value:.3g}: from 1 on it jams, or moves in more than one way",
        f"give {size}a smaller mu or a guided load nearer to the axis",
    )


def unyielding(compiled: Compiled) -> np.ndarray:
    """Return the places of the forces that act by friction and hold a joint at rest in no way."""
    forces = compiled.system.forces
    return np.array([k for k, f in enumerate(forces) if isinstance(f, DryFriction) and f.needs_slip], int)


def slip_speeds(compiled: Compiled, data: Data, t: float, y: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    """Return the slip speeds [rad/s or m/s] of some forces at a state."""
    load_rows(compiled, data, y, t, data.coordinate["value"])
    loads(compiled.model, data, t)
    return -data.force["rate"][numbers]


def check_slipping(compiled: Compiled, data: Data, y: np.ndarray, t: float, what: str) -> None:
    """Raise an InputError for friction without elastic slip in a joint at rest."""
    numbers = unyielding(compiled)
    for k in numbers[slip_speeds(compiled, data, t, y, numbers) == 0.0] if numbers.size else ():
        force = compiled.system.forces[k]
        raise InputError(
            f"{what}: force '{compiled.system.name(force)}' (DryFriction): joint '{compiled.system.name(force.joint)}' "
            "is at rest, where friction has no direction; give it a rate, or the friction yields="
        )


class RestWatch:
    """Watches for joints that come to rest and stay there, with friction that has no direction at rest."""

    def __init__(self, compiled: Compiled, dt: float | None) -> None:
        self.compiled, self.dt, self.numbers, self.seen = compiled, dt, unyielding(compiled), False

    def check(self, run: Run, data: Data, tree: Tree, ended: bool, solution: Callable[[], RunResult]) -> None:
        """Raise an IntegrationError for a joint that stays at rest: at two returns to Python, or when fixed steps end.

        Adaptive steps that have reached the end are right within their tolerance.
        """
        if not self.numbers.size or (ended and self.dt is None):
            return
        found = self.standing(run, data, tree)
        if found is not None and (self.seen or ended):
            name = self.compiled.system.name
            raise IntegrationError(
                "the joint comes to rest, where its friction has no direction",
                time=float(run.now.t), part=f"{type(found.joint).__name__} '{name(found.joint)}'", solution=solution(),
                advice=f"give '{name(found)}' (DryFriction) yields=, by which it holds, or end the run earlier",
            )  # fmt: skip
        self.seen = found is not None

    def standing(self, run: Run, data: Data, tree: Tree) -> DryFriction | None:
        """Return friction whose joint comes to rest within some steps and moves on neither forwards nor backwards.

        With mu < 0 friction acts as if the joint slipped the other way.
        """
        compiled, t, y = self.compiled, float(run.now.t), run.y.copy()
        own, rates = compiled.data(), np.empty((2, y.size))
        own.coordinate[:], own.unwrap_time[:] = data.coordinate, data.unwrap_time
        if evaluate(compiled.model, own, tree, t, y, rates[0]) != SOLVED:
            return None
        speeds = -own.force["rate"][self.numbers]
        h = self.dt or float(run.now.step)
        step = SLOPE_SHARE * h
        slopes = (slip_speeds(compiled, own, t, y + step * rates[0], self.numbers) - speeds) / step
        slowing = (speeds > 0.0) & (slopes < 0.0) & (speeds <= -slopes * STEPS_LOOKED_AHEAD * h)
        if not slowing.any():
            return None
        number = compiled.model.number.copy()
        number[compiled.model.force["number"][self.numbers[slowing]]] *= -1.0  # mu stands first
        if evaluate(compiled.model._replace(number=number), own, tree, t, y, rates[1]) != SOLVED:
            return None
        back = (slip_speeds(compiled, own, t, y + step * rates[1], self.numbers) - speeds) / step
        near = speeds <= np.maximum(-slopes, back) * STEPS_TO_REST * h  # fixed steps pass rest by as much
        stands = np.flatnonzero(slowing & near & (back >= 0.0))
        return compiled.system.forces[self.numbers[stands[0]]] if stands.size else None
