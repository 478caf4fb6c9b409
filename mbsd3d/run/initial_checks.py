"""Reject starts with deep penetration, the usual effect of a length in millimetres or a missing height.

A tyre must have its hub above the plane in every start. A `Contact` may be as soft as one likes and start from a state
of a run in which it sank: as built it is judged by what presses it, elsewhere where it starts deeper than its surface
is large, as an end stop does that a hinge has turned behind its plane.
"""

import numpy as np

from ..base.errors import InputError
from ..equations.compiled import Compiled
from ..mechanism.forces.contact import WEIGHT, Contact
from ..mechanism.forces.tyre import Tyre
from ..results.motion import Motion

PENETRATION_SHARE_MAX = 0.9
"""[1] Largest initial penetration, as a share of the distance from the centre to the lowest point."""
CONTACT_LOAD_MAX = 10.0
"""[1] Largest force of a contact as built, in weights of its body: a soft contact may penetrate deeply under load."""

DEPTH_RATIO_MAX = 4.0
"""[1] of a contact that starts elsewhere than as built: depth of the lowest point over its distance below the centre;
4 is twice the diameter of a sphere, so that the plane is a diameter above its top."""


def check_initial_penetration(compiled: Compiled, y: np.ndarray) -> None:
    """ValueError for a wheel or surface that starts in the plane up to its centre: any `Tyre`, a `Contact` as built.

    Elsewhere a `Contact` may start deep, but not far deeper than its surface is large.
    """
    n = compiled.model.body.size
    start = Motion(compiled, {"t": np.zeros(1), "q": y[: 7 * n].reshape(1, n, 7)})
    for force in compiled.system.forces:
        if not isinstance(force, Contact | Tyre):
            continue
        at, normal = force.plane
        up, centre = start.body_axis(force.a, normal)[0], start.body_point(force.b, force.outline.centre)[0]
        height = float(up @ (centre - start.body_point(force.a, at)[0]))
        below = float(up @ (centre - force.outline.moving(start, force.a, force.b, normal)[0]))
        if height >= (1.0 - PENETRATION_SHARE_MAX) * below:
            continue
        if isinstance(force, Contact) and is_supported(force, below - height):
            continue
        built = isinstance(force, Tyre) or is_as_built(force, centre, below)
        if not built and below - height <= DEPTH_RATIO_MAX * below:
            continue
        advice = "check its size (in m), its position and the plane"
        if not built:
            advice = "all behind a plane is solid: start on its open side, or stop it by a CustomForce of its angle"
        raise InputError(
            f"force '{compiled.system.name(force)}' ({type(force).__name__}): '{force.b.name}' starts "
            f"{below - height:.4g} m deep in the plane, its centre at {height:.4g} m and {below:.4g} m above its "
            f"lowest point; {advice}"
        )


def is_supported(contact: Contact, depth: float) -> bool:
    """Return whether the contact is so soft that its force at a depth [m] is some weights of its body at most."""
    return contact.stiffness * depth**contact.exponent <= CONTACT_LOAD_MAX * WEIGHT * contact.b.mass


def is_as_built(contact: Contact, centre: np.ndarray, depth: float) -> bool:
    """Return whether the centre of the surface is where the reference pose has it."""
    return bool(np.linalg.norm(centre - contact.outline.centre) <= 1e-9 * depth)
