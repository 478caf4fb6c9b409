"""Counterpart model of a `System` in Exudyn: rigid bodies with constraints, or a kinematic tree in minimal
coordinates."""

from typing import Any, Literal, overload

from mbsd3d import State, System
from mbsd3d.errors import InputError
from validation.twins.base import EngineFailed, Twin, check_met, start_of
from validation.twins.exudyn.assembly import ROTATIONS
from validation.twins.exudyn.bodies import BodyTwin
from validation.twins.exudyn.joints import FORCES, JOINTS
from validation.twins.exudyn.minimal import TreeTwin
from validation.twins.exudyn.solvers import exudyn, last_words

EXPRESSES, EXPRESSES_FORCES = tuple(JOINTS), tuple(FORCES)  # classes
FORMULATIONS = ("rigid bodies", "kinematic tree")


@overload
def twin(
    system: System,
    *,
    state: State | None = None,
    formulation: Literal["rigid bodies"] = "rigid bodies",
    rotation: str = "rotation vector",
    **scheme: Any,
) -> BodyTwin: ...
@overload
def twin(
    system: System,
    *,
    state: State | None = None,
    formulation: str,
    rotation: str = "rotation vector",
    **scheme: Any,
) -> Twin: ...
def twin(
    system: System,
    *,
    state: State | None = None,
    formulation: str = "rigid bodies",
    rotation: str = "rotation vector",
    **scheme: Any,
) -> Twin:
    """Return the counterpart model of a system in Exudyn.

    Parameters
    ----------
    system : System
    state : State or None
        The start; None = ``system.state()``.
    formulation : str
        "rigid bodies": six coordinates a body and constraints, implicit solvers (explicit ones for free bodies).
        "kinematic tree": hinge coordinates of a tree of Revolute, Prismatic, Cylindrical and Universal joints, any
        solver; no reactions.
    rotation : str
        Of rigid bodies: "rotation vector" (Lie group) or "euler parameters".
    **scheme
        Fields of `Scheme`: solver "generalized-alpha", "index2", "rk44", "dopri5" or "rk67", spectral_radius, linear
        "dense", "sparse" or "full-pivot", tolerance, adaptive. What is not given is chosen to fit:
        see `BodyTwin`; "rk67" for kinematic trees.

    Returns
    -------
    BodyTwin or TreeTwin
        A `Twin`; ``twin.mbs`` is the system of Exudyn.

    Raises
    ------
    EngineMissing
        If Exudyn is not installed, or too old.
    NotExpressible
        For a part that Exudyn, or the formulation, has no element for.
    EngineFailed
        If Exudyn itself refuses the model.
    ValueError
        For an unknown setting, no System, a state of another system, or one that its joints do not allow.

    Examples
    --------
    >>> from mbsd3d import Body, System
    >>> stone = Body("stone", 1.0, (0.1, 0.2, 0.3), position=(0, 0, 2), velocity=(3, 0, 0), omega=(0, 1, 4))
    >>> motion = twin(System([stone])).run(0.5, steps=8, samples=1)
    >>> round(float(motion.position[-1, 0, 2]), 9)  # 2 - g t^2 / 2
    0.77375
    """
    for name, value, known in (
        ("formulation", formulation, FORMULATIONS), ("rotation", rotation, tuple(ROTATIONS)),
    ):  # fmt: skip
        if value not in known:
            raise InputError(f"{name} {value!r} is unknown; give one of {', '.join(map(repr, known))}")
    module = exudyn()
    start = start_of(system, state, "Exudyn")
    check_met(system, start)
    try:
        if formulation == "kinematic tree":
            return TreeTwin(module, system, start, **scheme)
        return BodyTwin(module, system, start, rotation, **scheme)
    except module.ExudynError as error:
        raise EngineFailed(f"Exudyn does not take the model: {last_words(str(error))}") from None
