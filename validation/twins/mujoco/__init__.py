"""Counterpart model of a `System` in MuJoCo: a tree of joints, loops closed by soft equalities.

Two traps of MuJoCo 4.0.1 that are dodged here, both measured: ``mj_jacDot`` is wrong where a ball comes before a slide
in one body (0.6 m/s^2 off at speeds of 1 m/s), so that joints of a point on a line or plane are the last to span the
tree; and with a heavy body in the model its solver keeps the last forces at the usual tolerance of 1e-8 (1.6e-2 m off
where 1e-24 leaves 3.8e-6), so that `TOLERANCE` is far below.
"""

from typing import Any

import mbsd3d
from mbsd3d import State, System
from mbsd3d.errors import InputError
from mbsd3d.extend import TABLE, lay_out, number
from validation.twins.base import NotExpressible, refused, release, start_of
from validation.twins.mujoco.build import sketch
from validation.twins.mujoco.couplings import Motors, couple
from validation.twins.mujoco.loads import load_all
from validation.twins.mujoco.reactions import Reactions
from validation.twins.mujoco.rods import add_tendons, set_lengths
from validation.twins.mujoco.simulator import SPARSE_BUG_VERSION, MujocoTwin, require

EXPRESSES = (
    *TABLE, mbsd3d.ConstantVelocity, mbsd3d.Coupler, mbsd3d.Distance, mbsd3d.Gear, mbsd3d.RackPinion, mbsd3d.GearMesh,
    mbsd3d.AngleDriver, mbsd3d.SlideDriver, mbsd3d.SpeedDriver,
)  # fmt: skip
"""Joint classes: of `TABLE` by joints of MuJoCo, couplings and drivers by sums of their coordinates (no Table)."""

REFUSED: dict[type, str] = {
    mbsd3d.RollingDisc: "MuJoCo rolls by contact with friction only, which slips",
    mbsd3d.KnifeEdge: "MuJoCo has no row on velocities alone",
}


def twin(
    system: System, *, state: State | None = None, softness: float = 16.0, dampratio: float = 0.5, rods: str = "joints"
) -> MujocoTwin:  # fmt: skip
    """Return the counterpart model of a system in MuJoCo.

    Parameters
    ----------
    system : System
    state : State or None
        Start; None is ``system.state()``.
    softness, dampratio : float
        Equalities have ``solref = (softness h, dampratio)``, h the step: stiffness 1 / (softness dampratio h)^2,
        damping 2 / (softness h). At 2 and 1 the stages of RK4, which leave the rows by h^2, see accelerations that do
        not fall with h: velocities have order 1 then, reactions 0. From 16 and 0.5 on positions and velocities are of
        order 2, and so are reactions, but those of some loops keep 1e-7 to 1e-6 of their size at any h. MuJoCo raises
        smaller values of softness to 2; the twin switches that off.
    rods : str
        "joints" or "tendons", what a Distance becomes: exact but for a direction in which it is lost, or everywhere
        but with a greater error.

    Returns
    -------
    MujocoTwin
        With MuJoCo's ``model`` and ``data``, run by RK4: trees have order 4, loops 2, as their softness falls with the
        square of the step.

    Raises
    ------
    EngineMissing
        Without MuJoCo, or with one too old.
    NotExpressible
        Naming the part MuJoCo has no element for.
    ValueError
        For settings out of range, no System, or a state that the joints do not allow.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Revolute, System
    >>> bob = Body("bob", mass=1.0, inertia=(0.1, 0.1, 0.02), position=(0.6, 0, -0.8))
    >>> hinge = Revolute(GROUND, bob, at=(0, 0, 0), axis=(0, 1, 0), name="hinge")
    >>> motion = twin(System([bob], [hinge])).run(1.0, steps=256, samples=4)
    >>> motion.position[-1, 0, ::2].round(6).tolist(), motion.reactions["hinge"].force[-1, ::2].round(4).tolist()
    ([-0.586308, -0.810088], [4.3413, 6.8901])
    """
    mujoco = require()
    softness = number(softness, "MuJoCo: softness", positive=True)
    dampratio = number(dampratio, "MuJoCo: dampratio", positive=True)
    if rods not in ("joints", "tendons"):
        raise InputError(f"MuJoCo: rods {rods!r} is unknown; give 'joints' or 'tendons'")
    start = start_of(system, state, "MuJoCo")
    for joint in system.joints:
        if type(joint) not in EXPRESSES:
            raise refused(system, joint, REFUSED, "MuJoCo has no such element")
    return assembled(mujoco, system, start, rods == "joints", softness, dampratio)


def assembled(mujoco: Any, system: System, start: State, rods: bool, softness: float, dampratio: float) -> MujocoTwin:
    """Return the counterpart model of a system whose joints MuJoCo has; ``rods``: a Distance becomes joints, else a
    tendon.
    """
    dense = release(mujoco.__version__) == SPARSE_BUG_VERSION
    made = sketch(mujoco, system, lay_out(system, rods), dense)
    motors, tendons = Motors(mujoco, made.spec, system.bodies), add_tendons(made)
    couplings, loads = couple(made, motors), load_all(made)
    model = compile_spec(mujoco, made, softness)
    set_lengths(model, tendons)
    reactions = Reactions(made, loads, couplings, tendons, mujoco, model)
    soft = f", solref ({softness:g} h, {dampratio:g})" if model.neq else ""
    thin = f", inertia 1e-14 m L^2 or kg m^2 where it is less ({', '.join(made.raised)})" if made.raised else ""
    solver = ", dense Jacobian (4.0.0 factors sparse ones wrongly)" if dense else ""
    return MujocoTwin(
        made, model, mujoco.MjData(model), start, reactions, loads, couplings, motors, softness, dampratio,
        f"MuJoCo {mujoco.__version__}: RK4{soft}{solver}{thin}", 2.0 if model.neq else 4.0,
    )  # fmt: skip


def compile_spec(mujoco: Any, made: Any, softness: float) -> Any:
    """Compile the model; if MuJoCo refuses it, the error quotes MuJoCo."""
    if softness < 2.0:
        made.spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_REFSAFE)
    try:
        return made.spec.compile()
    except ValueError as error:
        raise NotExpressible(f"MuJoCo refuses the model: {' '.join(str(error).split())}") from None
