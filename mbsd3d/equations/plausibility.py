"""Parts that are legal but unlikely: inertias in other units than the lengths, bodies that nothing acts on."""

import numpy as np

from ..mechanism.bodies import GROUND, Body
from ..mechanism.mechanism import Mechanism

GYRATION_RATIO_MAX = 100.0  # [1] radius of gyration over the size of the mechanism; inertias in kg mm^2 make it 1000
MASS_SHARE_MIN = 1e-3  # [1] of the whole mass; spinning parts are modelled with less where another body has their mass
UNBALANCE_MAX = 1e-2  # [m] distance of a centre of mass from a bearing that says nothing about the size of a rotor


def loose_bodies(system: Mechanism) -> list[str]:
    """Return what to say of bodies without any joint or force, in a mechanism that has some; its bodies are all meant
    to move freely where there are none.
    """
    held = {id(body) for part in (*system.joints, *system.forces) for body in part.bodies()}
    if not held:
        return []
    loose = [body for body in system.bodies if id(body) not in held]
    return [f"body '{system.name(body)}' has no joint and no force: nothing but gravity acts on it" for body in loose]


def doubtful_inertias(system: Mechanism) -> list[str]:
    """Return what to say of bodies whose radius of gyration is many times the size of the mechanism."""
    size, found, least = mechanism_size(system), [], MASS_SHARE_MIN * system.total_mass()
    for body in system.bodies if size > 0.0 else ():
        radius = radius_of_gyration(body) if body.mass > least else 0.0
        if radius > GYRATION_RATIO_MAX * size:
            found.append(
                f"body '{system.name(body)}': its radius of gyration is {radius:.3g} m, {radius / size:.0f} times the "
                f"size of the mechanism ({size:.3g} m); give mass in kg, inertia in kg m^2 and lengths in m"
            )
    return found


def radius_of_gyration(body: Body) -> float:
    """Return the largest radius of gyration of a body about its centre of mass [m], 0 for one without mass."""
    return float(np.sqrt(np.linalg.eigvalsh(body.inertia)[-1] / body.mass)) if body.mass > 0.0 else 0.0


def mechanism_size(system: Mechanism) -> float:
    """Return the size of a mechanism at its reference pose [m]: how far the points of joints and forces are apart, or a
    centre of mass from one of its own; 0 where all are at one place.
    """
    joints = [(body, joint.point()) for joint in system.joints for body in joint.bodies()]
    records = [force.record() for force in system.forces]
    pairs = joints + [pair for r in records if r.points for pair in zip(r.bodies, r.points, strict=True)]
    if not pairs:
        return 0.0
    apart = float(np.linalg.norm(np.ptp([point for _, point in pairs], axis=0)))
    arms = [float(np.linalg.norm(point - body.centre)) for body, point in pairs if body is not GROUND]
    return max([apart, *(arm for arm in arms if arm > UNBALANCE_MAX)])
