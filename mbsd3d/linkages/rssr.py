"""The spatial four-bar RSSR: crank and rocker on crossing shafts, a rod with ball joints between them."""

import numpy as np
from numpy.typing import ArrayLike

from ..api.system import System
from ..base.checks import check_choice, number, sequence, short_repr
from ..base.errors import InputError, checks_arguments
from ..mechanism.bodies import GROUND
from ..mechanism.joints.pairs import Revolute, Spherical, Universal
from .dh import step
from .links import Links, base_frame, link_body


@checks_arguments
def rssr(
    crank: float, rod: float, rocker: float, distance: float, twist: float, angle: float, *,
    offsets: ArrayLike = (0, 0), branch: int = 1, spin: bool = False, links: Links = None,
    position: ArrayLike = (0, 0, 0), orientation: ArrayLike = (1, 0, 0, 0), gravity: ArrayLike = (0, 0, -9.81),
) -> System:  # fmt: skip
    """Build the RSSR linkage: ``|p_rocker(psi) - p_crank(theta)| = rod``, that is ``E cos(psi) + F sin(psi) = G``.

    The crank turns about z of frame 0, its pin at ``(crank cos(theta), crank sin(theta), offset_1)``; the rocker turns
    about z of the frame ``Tx(distance) Rx(twist)``, its pin there at ``(rocker cos(psi), rocker sin(psi), offset_2)``.
    Bodies "crank", "rod", "rocker"; joints "crank shaft", "crank pin", "rocker pin", "rocker shaft".

    Parameters
    ----------
    crank, rod, rocker : float
        Lengths [m] > 0.
    distance, twist : float
        Of the shafts [m], [rad].
    angle : float
        theta [rad].
    offsets : (2,) array_like
        Of the pins along their shafts [m].
    branch : 1 or -1
        Which of the two poses: psi is the greater or the smaller one seen from ``atan2(F, E)``.
    spin : bool
        True: both pins are Spherical, and the rod is free to spin about its own line, a second degree of freedom.
        False: the rocker pin is Universal, with its cross along the rocker's shaft.
    links : (3,) sequence of MassProperties, optional
        Of crank, rod, rocker, in frames with the origin in the pin farther from the crank's shaft, for the rocker in
        its pin; axes of frame 0. None = as in `hinge_loop`.
    position, orientation, gravity
        As in `hinge_loop`.

    Raises
    ------
    ValueError
        If the rod does not reach at this angle, naming by how much; if the rod lies along the rocker's shaft and does
        not spin.
    """
    for name, value in (("crank", crank), ("rod", rod), ("rocker", rocker)):
        number(value, f"rssr: {name}", positive=True)
    offset = sequence(offsets, "rssr: offsets")
    angle = number(angle, "rssr: angle")
    check_choice(branch, (1, -1), "rssr: branch")
    check_choice(spin, (True, False), "rssr: spin")
    if len(offset) != 2:
        raise InputError(f"rssr: offsets {short_repr(offset)}; give two")
    shaft = step(0.0, number(distance, "rssr: distance"), number(twist, "rssr: twist"), 0.0)
    hub = np.array([0.0, 0.0, offset[0]])
    pin = hub + crank * np.array([np.cos(angle), np.sin(angle), 0.0])
    far_hub, axis = shaft[:3, 3] + offset[1] * shaft[:3, 2], shaft[:3, 2]
    psi = _rocker_angle(shaft[:3, :3].T @ (pin - far_hub), rod, rocker, branch, angle)
    far = far_hub + rocker * shaft[:3, :3] @ np.array([np.cos(psi), np.sin(psi), 0.0])
    base = base_frame(position, orientation, "rssr")
    thick, R = 0.05 * max(crank, rod, rocker), base[:3, :3]
    bodies = [
        link_body("rssr", k, base @ _at(end), start - end, np.eye(3), thick, links, 3, name)
        for k, (name, start, end) in enumerate(
            (("crank", hub, pin), ("rod", pin, far), ("rocker", far_hub, far)), start=1
        )
    ]

    def world(point: np.ndarray) -> np.ndarray:
        return R @ point + base[:3, 3]

    ends = (
        Revolute(GROUND, bodies[0], at=world(hub), axis=R[:, 2], name="crank shaft"),
        Spherical(bodies[0], bodies[1], at=world(pin), name="crank pin"),
        Revolute(GROUND, bodies[2], at=world(far_hub), axis=R @ axis, name="rocker shaft"),
    )
    across = np.cross(axis, far - pin)
    last: Spherical | Universal
    if spin:
        last = Spherical(bodies[1], bodies[2], at=world(far), name="rocker pin")
    elif np.linalg.norm(across) > 1e-6 * rod:
        last = Universal(bodies[1], bodies[2], at=world(far), axis_a=R @ across, axis_b=R @ axis, name="rocker pin")
    else:
        raise InputError(
            "rssr: the rod lies along the rocker's shaft, where a Universal cannot hold its spin; spin=True"
        )
    return System(bodies, [ends[0], ends[1], last, ends[2]], gravity=gravity)


def _rocker_angle(arm: np.ndarray, rod: float, rocker: float, branch: int, angle: float) -> float:
    """Return psi [rad] with ``|rocker (cos psi, sin psi, 0) - arm| = rod``, arm from the rocker's hub to the crank
    pin."""
    reach = 2.0 * rocker * float(np.hypot(arm[0], arm[1]))
    need = float(arm @ arm) + rocker**2 - rod**2
    if not abs(need) <= reach:
        near, far = np.sqrt([max(arm @ arm + rocker**2 - reach, 0.0), arm @ arm + rocker**2 + reach])
        raise InputError(f"rssr: at angle {np.degrees(angle):.6g} degrees the pins can be {near:.9g} m to {far:.9g} m "
                         f"apart, and the rod is {rod:.9g} m; choose a rod or an angle that closes")  # fmt: skip
    return float(np.arctan2(arm[1], arm[0]) + branch * np.arccos(need / reach))


def _at(point: np.ndarray) -> np.ndarray:
    T = np.eye(4)
    T[:3, 3] = point
    return T
