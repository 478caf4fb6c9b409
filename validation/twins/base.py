"""What a twin of a `System` in another engine answers, in the coordinates of `mbsd3d`, and how it refuses."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

import numpy as np

from mbsd3d import Joint

Array = np.ndarray


class NotComparable(ValueError):  # noqa: N818 - a verdict, not a mistake
    """An engine that cannot take part: the verdict is "not compared: <this text>"."""


class EngineMissing(NotComparable):
    """The engine is not installed, or of a version with a known bug."""


class NotExpressible(NotComparable):
    """The model has a part that the engine has no element for; the text names the part and the reason."""


class EngineFailed(NotComparable):
    """The engine stopped, diverged or returned NaN; the text says when, and what it said itself."""


def label(system: Any, part: Any) -> str:
    """How errors name a part: "joint 'hinge' (Revolute)"."""
    kind = "joint" if isinstance(part, Joint) else "force"
    return f"{kind} '{system.name(part)}' ({type(part).__name__})"


def refused(system: Any, part: Any, reasons: Mapping[type, str], otherwise: str) -> NotExpressible:
    """The error for a part that no table of an engine has: its known reason, or what holds for any new class."""
    return NotExpressible(f"{label(system, part)}: {reasons.get(type(part), otherwise)}")


def release(version: str) -> tuple[int, int, int]:
    """Version as three numbers, without what marks it as a preview: "4.1.0rc1" is (4, 1, 0)."""
    first, second, third = (re.findall(r"(?:^|\.)(\d+)", version) + ["0"] * 3)[:3]
    return int(first), int(second), int(third)


class Load(NamedTuple):
    """What a joint does to its body b, at the joint's point on b, world axes: force [N], moment [N m], each (n, 3)."""

    force: Array
    moment: Array


@dataclass(frozen=True)
class Motion:
    """A motion sampled at times t (n,), bodies in the order of ``system.bodies``; O and axes as `mbsd3d` has them.

    Attributes
    ----------
    position, velocity : (n, bodies, 3) arrays
        Of the reference point O, world [m, m/s].
    orientation : (n, bodies, 4) array
        Unit quaternion, scalar first, body to world; either sign.
    omega : (n, bodies, 3) array
        World [rad/s].
    reactions : mapping
        Joint name -> `Load`; only joints whose reaction the engine reports.
    seconds : float
        Wall time of the engine's own time loop [s].
    """

    t: Array
    position: Array
    orientation: Array
    velocity: Array
    omega: Array
    reactions: Mapping[str, Load] = field(default_factory=dict)
    seconds: float = 0.0


def finite(motion: Motion, engine: str) -> Motion:
    """The motion, or EngineFailed if anything in it is not finite: such numbers compare as neither more nor less."""
    loads = {f"reaction of '{name}'": np.concatenate(load, axis=1) for name, load in motion.reactions.items()}
    poses = {name: getattr(motion, name) for name in ("position", "orientation", "velocity", "omega")}
    for name, values in (poses | loads).items():
        good = np.isfinite(values.reshape(motion.t.size, -1)).all(axis=1)
        if not good.all():
            raise EngineFailed(f"{engine}: {name} is not finite from t = {motion.t[np.argmin(good)]:.6g} s on")
    return motion


class Kinetic(NamedTuple):
    """Kinetic energy in the engine's own velocities u (m,): ``T = u' matrix u / 2``, with our v = ``map`` u.

    ``map`` is (6 bodies, m); v holds (r_dot of O, world omega) body by body.
    """

    matrix: Array
    map: Array


class Twin(Protocol):
    """A `System` as another engine has it, from the same start.

    Attributes
    ----------
    engine, settings : str
        "MuJoCo"; formulation, integrator and what else a reader needs to repeat it.
    order : float
        Expected order of the error in the step.
    """

    engine: str
    settings: str
    order: float

    def kinetic(self) -> Kinetic | None:
        """Mass matrix at the start; None where the engine does not give it."""

    def accelerations(self) -> Array:
        """(bodies, 6): acceleration of O and world angular acceleration at the start."""

    def run(self, t_end: float, steps: int, samples: int) -> Motion:
        """``steps`` equal steps to t_end, of which every (steps / samples)-th is kept, and the start.

        EngineFailed if the engine stops, or anything is not finite.
        """
