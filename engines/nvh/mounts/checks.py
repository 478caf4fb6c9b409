"""Checks of simple powertrains whose small motions theory knows; the general model must find the same.

Each returns quantity -> (computed, exact), or with a limit of their difference; what is exact comes from
`engines.closed_forms`, fed with numbers alone.
"""

from typing import Any

import numpy as np

from engines import closed_forms
from engines.nvh.mounts.mounts import Mount, bushings
from engines.nvh.mounts.powertrain import Equivalent
from engines.nvh.mounts.response import OnMounts
from engines.nvh.mounts.rigid_modes import rigid_modes
from mbsd3d import Body, System, linearize

Pairs = dict[str, tuple[Any, ...]]
MASS, INERTIA = 187.0, np.diag([6.3, 11.9, 13.1])  # kg, kg m^2


def mount(at: tuple[float, float, float], rates: tuple[float, float, float], damping: float = 0.0) -> Mount:
    """Return a mount with axes of the car and dampers in proportion to the rates [s]."""
    x, y, z = rates
    return Mount(f"mount at {at}", at, rates, (damping * x, damping * y, damping * z))


def one_freedom(frequencies: np.ndarray) -> Pairs:
    """Compare the response to a vertical force at the centre of mass of a powertrain on four equal mounts with
    theory."""
    share = 0.011  # damping over rate [s]
    placed = [mount((x, y, -0.2), (1.1e5, 1.4e5, 2.3e5), share) for x in (-0.31, 0.31) for y in (-0.22, 0.22)]
    rate = np.sqrt(4 * 2.3e5 / MASS)
    found = OnMounts(Equivalent(MASS, np.zeros(3), INERTIA, 0.12), placed)
    W = 2 * np.pi * frequencies
    up = found.receptance(0.0, W)[:, :, 2]  # of a vertical force
    computed = sum(found.handed_on(part, up, W)[:, 2] for part in placed)
    return {"transmissibility": (computed, closed_forms.transmissibility(W, rate, share * rate / 2))}


def bounce_and_pitch() -> Pairs:
    """Compare bounce and pitch about y on two pairs of mounts before and behind the centre of mass with theory."""
    rates, arms = (1.7e5, 2.9e5), (0.41, -0.27)
    placed = [mount((x, y, 0.0), (9e4, 7e4, k / 2)) for k, x in zip(rates, arms, strict=True) for y in (-0.2, 0.2)]
    squares, centres = closed_forms.bounce_and_pitch(MASS, np.sqrt(INERTIA[1, 1] / MASS), rates, arms)
    body = Body("powertrain", MASS, INERTIA)
    mine = [mode for mode in rigid_modes(body, placed) if mode.shares[2] + mode.shares[4] > 0.99]
    nodes = [mode.shape[2] / mode.shape[4] for mode in mine]  # a rotation about y moves x > 0 down
    return {
        "bounce and pitch": (2 * np.pi * np.array([mode.frequency for mode in mine]), squares),
        "centres of bounce and pitch": (np.array(nodes), centres),
    }


def three_coupled() -> Pairs:
    """Compare coupled sway, roll and yaw on mounts below the centre of mass, unequal in front and behind, with
    theory."""
    spots = [((0.35, 0.2, -0.15), 1.3e5), ((0.35, -0.2, -0.15), 1.3e5), ((-0.28, 0.24, -0.21), 0.8e5),
             ((-0.28, -0.24, -0.21), 0.8e5)]  # fmt: skip
    along, across, up = 0.9, 0.7, 1.6
    placed = [mount(at, (along * k, across * k, up * k)) for at, k in spots]
    rates = dict.fromkeys(("yy", "yx", "yz", "xx", "xz", "zz"), 0.0)
    for (x, y, z), k in spots:  # a point moves across by y - z theta_x + x theta_z
        ky, kx, kz = across * k, along * k, up * k
        rates["yy"] += ky
        rates["yx"] += -ky * z
        rates["yz"] += ky * x
        rates["xx"] += ky * z**2 + kz * y**2
        rates["xz"] += -ky * x * z
        rates["zz"] += ky * x**2 + kx * y**2
    body = Body("powertrain", MASS, INERTIA)
    mine = [m for m in rigid_modes(body, placed) if m.shares[1] + m.shares[3] + m.shares[5] > 0.99]
    known = closed_forms.three_coupled(MASS, (INERTIA[0, 0], INERTIA[2, 2]), rates)
    return {"sway, roll and yaw": (2 * np.pi * np.array([mode.frequency for mode in mine]), known)}


def mounted(placed: list[Mount]) -> System:
    """Return the body of the checks on its mounts."""
    body = Body("powertrain", MASS, INERTIA)
    return System([body], forces=bushings(placed, body), gravity=(0, 0, 0))


def spinning_rotor(rate: float) -> Pairs:
    """Compare pitch and yaw of a powertrain with equal stiffness about both, coupled by the spin of its crank H = J w,
    with theory.

    ``I_y a'' + k a + H b' = 0, I_z b'' + k b - H a' = 0``:  I_y I_z s^4 + (k (I_y + I_z) + H^2) s^2 + k^2 = 0.
    """
    k, J = 4.1e4, 0.31
    half = np.sqrt(k / (4 * 1.5e5))
    placed = [mount((x, 0.0, 0.0), (1e5, 1.5e5, 1.5e5)) for x in (-half, half)]
    placed += [mount((0.0, y, z), (1e-3, 5e4, 5e4)) for y, z in ((0.2, 0.0), (-0.2, 0.0), (0.0, 0.2), (0.0, -0.2))]
    body = Equivalent(MASS, np.zeros(3), INERTIA, J)
    stiff = 2 * 1.5e5 * half**2
    system = body.system(lambda part: bushings(placed, part), rate)
    values = np.abs(linearize(system).eigenvalues.imag)
    H, (_, B, C) = J * rate, np.diag(INERTIA)
    squares = np.roots([B * C, stiff * (B + C) + H**2, stiff**2])
    known = np.sort(np.sqrt(-squares.real))
    return {
        "pitch and yaw of a spinning crank": (np.array([values[np.argmin(np.abs(values - w))] for w in known]), known)
    }
