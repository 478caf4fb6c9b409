"""Interface of a counterpart model of a `System` in another engine, in the coordinates of `mbsd3d`, and its errors.

Every twin checks its start and its runs in the same way.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from numbers import Real
from typing import Any, NamedTuple, Protocol

import numpy as np

from mbsd3d import Joint, SpeedDriver, State, System
from mbsd3d.errors import InputError, MbsError
from mbsd3d.extend import (
    Coordinate,
    check_quaternions,
    check_signals,
    check_state,
    check_system,
    driven_coordinates,
    load_state,
    new_data,
    pack,
    slide_of,
    unmet,
    worst_joint,
)

Array = np.ndarray


class NotComparable(MbsError):  # noqa: N818 - a verdict, not a mistake
    """Error of an engine that cannot take part: the verdict is "not compared: <this text>"."""


class EngineMissing(NotComparable):
    """Error of an engine that is not installed, or of a version with a known bug."""


class NotExpressible(NotComparable):
    """Error of a model with a part that the engine has no element for; the text names the part and the reason."""


class EngineFailed(NotComparable):
    """Error of an engine that stopped, diverged or returned NaN; the text says when, and quotes the engine."""


def label(system: System, part: Any) -> str:
    """Return the name of a part for errors: "joint 'hinge' (Revolute)"."""
    kind = "joint" if isinstance(part, Joint) else "force"
    return f"{kind} '{system.name(part)}' ({type(part).__name__})"


def refuse_reflected(system: System, joint: Joint) -> None:
    """Raise NotExpressible for a joint with a reflected inertia."""
    if joint.reflected():
        raise NotExpressible(f"{label(system, joint)}: no reflected inertia is written for it")


def refused(system: System, part: Any, reasons: Mapping[type, str], otherwise: str) -> NotExpressible:
    """Return the error for a part that no table of an engine has: its known reason, or what holds for any new class."""
    return NotExpressible(f"{label(system, part)}: {reasons.get(type(part), otherwise)}")


def release(version: str) -> tuple[int, int, int]:
    """Return a version as three numbers, without its preview mark: "4.1.0rc1" is (4, 1, 0)."""
    first, second, third = (re.findall(r"(?:^|\.)(\d+)", version) + ["0"] * 3)[:3]
    return int(first), int(second), int(third)


def speed_of(driver: SpeedDriver, what: str, engine: str) -> Coordinate:
    """Return the angle or displacement whose speed a driver prescribes; raise NotExpressible for a point without a
    slider.
    """
    if driver.axis is not None:
        return Coordinate("angle", driver.a, driver.b, driver.axis, driver.axis)
    if driver.joint is None:
        raise NotExpressible(f"{what}: moves a point that no slider leads; {engine} gives speeds to hinges and slides")
    return slide_of(driver.joint)


class Load(NamedTuple):
    """Reaction of a joint on its body b, at the joint's point on b, world axes: force [N], moment [N m], each (n,
    3)."""

    force: Array
    moment: Array


@dataclass(frozen=True)
class Motion:
    """Motion sampled at times t (n,), bodies in the order of ``system.bodies``; O and axes as `mbsd3d` has them.

    ``position, velocity`` (n, bodies, 3): of the reference point O, world [m, m/s]; ``orientation`` (n, bodies, 4):
    unit quaternion, scalar first, body to world; either sign; ``omega`` (n, bodies, 3): world [rad/s]; ``reactions``:
    joint name -> `Load`; only joints whose reaction the engine reports; ``seconds``: wall time of its time loop [s].
    """

    t: Array
    position: Array
    orientation: Array
    velocity: Array
    omega: Array
    reactions: Mapping[str, Load] = field(default_factory=dict)
    seconds: float = 0.0


def finite(motion: Motion, engine: str) -> Motion:
    """Return the motion; raise EngineFailed if it is not finite: such numbers compare as neither more nor less."""
    loads = {f"reaction of '{name}'": np.concatenate(load, axis=1) for name, load in motion.reactions.items()}
    poses = {name: getattr(motion, name) for name in ("position", "orientation", "velocity", "omega")}
    for name, values in (poses | loads).items():
        good = np.isfinite(values.reshape(motion.t.size, -1)).all(axis=1)
        if not good.all():
            raise EngineFailed(f"{engine}: {name} is not finite from t = {motion.t[np.argmin(good)]:.6g} s on")
    return motion


class Kinetic(NamedTuple):
    """Kinetic energy in the engine's own velocities u (m,): ``T = u' matrix u / 2``, with the v of mbsd3d = ``map`` u.

    ``map`` is (6 bodies, m); v holds (r_dot of O, world omega) body by body.
    """

    matrix: Array
    map: Array


class Twin(Protocol):
    """Counterpart model of a `System` in another engine, from the same start.

    ``engine, settings``: "MuJoCo"; formulation, integrator and what else a reader needs to repeat it; ``order``:
    expected order of the error in the step.
    """

    engine: str
    settings: str
    order: float

    def kinetic(self) -> Kinetic | None:
        """Return the mass matrix at the start; None where the engine does not give it."""

    def accelerations(self) -> Array:
        """Return the acceleration of O and world angular acceleration at the start, shape (bodies, 6)."""

    def run(self, t_end: float, steps: int, samples: int) -> Motion:
        """Integrate ``steps`` equal steps to t_end, of which every (steps / samples)-th is kept, and the start.

        EngineFailed if the engine stops, or anything is not finite.
        """


START_TOLERANCE = 1e-8  # [1] of the model's length, or [rad]: joints of a start, as `mbsd3d.simulate` requires


def start_of(system: System, state: State | None, engine: str) -> State:
    """Return the start, a state of this system; raise ValueError that names the fault of either."""
    check_system(system, engine)
    check_state(state, engine)
    start = system.state() if state is None else state
    pack(system.lowered, start)
    check_quaternions(system, start)
    return start


def check_met(system: System, start: State) -> None:
    """Raise ValueError naming the joint, driver or gear that a start does not satisfy, as `mbsd3d.simulate` does."""
    compiled = system.lowered
    data = new_data(compiled.model)  # no loads: functions of forces need not be compiled
    known = driven_coordinates(compiled, start.t) if start.coordinates is None else start.coordinates
    load_state(compiled, data, State(start.t, start.q, start.v, start.z, known))
    missed = unmet(compiled, data, start.v, START_TOLERANCE)
    if missed is not None:
        residual, unit = missed
        worst = int(np.argmax(np.abs(residual) * compiled.model.row["scale"]))
        part = label(system, system.joints[compiled.row_joint[worst]])
        raise InputError(
            f"state: {part} is off by {worst_joint(compiled, residual)[1]:.3g} {unit}; "
            "start from system.state() or system.assemble()"
        )


def check_run(engine: str, system: System, start: float, t_end: float, steps: int, samples: int) -> None:
    """Raise ValueError if samples do not lie on steps, the end is not after the start, or tables end before it."""
    whole = all(isinstance(n, int | np.integer) and not isinstance(n, bool) and n >= 1 for n in (steps, samples))
    if not whole or steps % samples:
        raise InputError(
            f"{engine}: {samples!r} samples do not divide {steps!r} steps; give a whole number >= 1 of samples, and of "
            "steps a multiple of it"
        )
    if not isinstance(t_end, Real) or not start < t_end < np.inf:
        raise InputError(
            f"{engine}: a run that is not after the start: t_end = {t_end} s does not lie after the start at "
            f"{start:g} s; give a later, finite one"
        )
    check_signals(system.lowered, start, t_end)
