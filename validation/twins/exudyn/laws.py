"""Force elements that Exudyn does not have: loads of bodies by functions of Python.

Own states are velocities of coordinates of their own, of unit mass, so that the solvers of Exudyn keep their order.
The laws are those of `validation.twins.laws`. Place and motion of the bodies are Exudyn's own at every evaluation.
"""

from typing import Any

import numpy as np

from mbsd3d import GROUND
from validation.twins.base import Array, NotExpressible
from validation.twins.exudyn.assembly import Assembly, ForceModel
from validation.twins.laws import LAWS
from validation.twins.laws.moving import Moving, Push, own_states


def moving(model: Assembly, mbs: Any, body: Any) -> Moving:
    """Return a body at its state in Exudyn."""
    if body is GROUND:
        return Moving(body, np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3))
    kinds, number = model.module.OutputVariableType, model.body[id(body)]
    wanted = (kinds.Position, kinds.RotationMatrix, kinds.Velocity, kinds.AngularVelocity)
    r, R, v, omega = (np.array(mbs.GetObjectOutputBody(number, kind, [0.0, 0.0, 0.0])) for kind in wanted)
    return Moving(body, r, R.reshape(3, 3), v, omega)


def add_law(model: ForceModel, force: Any, what: str) -> None:
    """Add loads on the bodies a, b of a force, and coordinates whose velocities are its internal states.

    Turns of a hinge are not counted: none of these laws asks for its angle.
    """
    if not isinstance(model, Assembly):
        raise NotExpressible(f"{what}: a kinematic tree has no place for its law; take the formulation 'rigid bodies'")
    law, start = LAWS[type(force)](force, what), own_states(model.system, force, model.state.z)
    count, node = len(start), None
    if count:
        still = [0.0] * count
        node = model.mbs.AddNode(model.items.NodeGenericODE2(
            referenceCoordinates=still, initialCoordinates=still, initialCoordinates_t=start,
            numberOfODE2Coordinates=count,
        ))  # fmt: skip
    last: dict[str, Any] = {}

    def now(mbs: Any, t: float) -> tuple[Push, tuple[Moving, Moving]]:
        """Return the law at the state that Exudyn evaluates, and a, b there; called up to five times per state."""
        a, b = (moving(model, mbs, body) for body in (law.a, law.b))
        kind = model.module.OutputVariableType.Coordinates_t
        z = np.atleast_1d(mbs.GetNodeOutput(node, kind)) if count else np.zeros(0)
        key = b"".join(x.tobytes() for x in (np.array(t), a.r, a.R, a.v, a.omega, b.r, b.R, b.v, b.omega, z))
        if last.get("key") != key:
            last.update(key=key, found=law.push(t, a, b, z, 0.0))
        return last["found"], (a, b)

    for sign, k in law.sides:
        body = (law.a, law.b)[k]
        marker = model.marker(body, body.position)

        def push(mbs: Any, t: float, vector: Any, sign: float = sign) -> Array:
            return sign * now(mbs, t)[0].force

        def turn(mbs: Any, t: float, vector: Any, sign: float = sign, k: int = k) -> Array:
            found, sides = now(mbs, t)
            return sign * found.moment(sides[k].r)

        model.mbs.AddLoad(model.items.LoadForceVector(markerNumber=marker, loadVectorUserFunction=push))
        model.mbs.AddLoad(model.items.LoadTorqueVector(markerNumber=marker, loadVectorUserFunction=turn))
    if count:

        def rates(mbs: Any, t: float, item: int, q: Any, q_t: Any) -> Array:
            return now(mbs, t)[0].rates

        item = model.items.ObjectGenericODE2(nodeNumbers=[node], massMatrix=np.eye(count), forceUserFunction=rates)
        model.connect(force, item)
