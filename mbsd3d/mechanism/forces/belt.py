"""Belts between two pulleys: a strand on each side, pulled by the rims, taut by a pretension."""

from dataclasses import KW_ONLY
from math import inf, pi

import numpy as np

from ...base.errors import InputError
from ...base.fields import Number, NumberOrNone, Numbers, Truth, kept, part_class
from ..joints import Joint, coordinate_of
from ..pulleys import Pulley, Winch, path_of
from .rope import OverPulleys, Sections


@part_class()
class Belt(OverPulleys):
    """A belt between two pulleys on hinges: each strand has the tension ``max(0, F + k e + d e_dot)``.

    e is how far a strand is stretched beyond the reference pose, by the turning of both pulleys, each body b of its
    hinge, and by the motion of their axes; F is the pretension. Beyond it a strand is slack. The load acts along the
    common tangents on both pulleys, and so on their bearings. Energy ``(F + k e)^2 / (2 k)`` of each strand.

    The belt does not slip. With ``mu=`` the certificate compares the tensions with Eytelwein's limit,
    ``T_high <= e^(mu phi) T_low`` with the wrap phi of either pulley, and fails where a sample exceeds it; without, it
    is taken to hold, as a toothed belt does. As the first pulley drives about its axis, the first strand is the one
    that slackens. ``solution.force(belt)`` has the tensions and the wrap of the second pulley.

    Parameters
    ----------
    hinge_a, hinge_b : Joint
        Hinges with parallel axes; the pulleys lie in one plane across them.
    radii : (R_a, R_b)
        Radii of the centre line of the belt [m].
    stiffness, damping : float
        k > 0 [N/m] and d >= 0 [N s/m] of each strand.
    pretension : float
        F >= 0 [N] of each strand at the reference pose.
    mu : float or None
        Friction between belt and pulleys; None = no limit.
    crossed : bool
        True if the strands cross, so the pulleys turn in opposite senses.

    Raises
    ------
    ValueError
        For a joint without an angle, axes that are not parallel, pulleys out of one plane, one inside the other
        (crossed: that touch), and radii that are not two numbers above 0.

    Examples
    --------
    >>> from mbsd3d import GROUND, Belt, Body, Revolute, System, accelerations
    >>> at = (("motor", 0.0, 3.0), ("fan", 0.6, 1.0))
    >>> motor, fan = (Body(n, 1.0, (0.01, 0.01, 0.02), position=(x, 0, 0), omega=(0, 0, w)) for n, x, w in at)
    >>> first, second = (Revolute(GROUND, body, at=body.position, axis=(0, 0, 1)) for body in (motor, fan))
    >>> belt = Belt(first, second, radii=(0.05, 0.15), stiffness=2e4, damping=15.0, pretension=200.0)
    >>> now = accelerations(System([motor, fan], [first, second], [belt]))
    >>> bool(abs(now.alpha(fan)[0, 2]) < 1e-9)  # at the ratio of its radii nothing is stretched
    True
    """

    hinge_a: Joint
    hinge_b: Joint
    _: KW_ONLY
    radii: Numbers = kept()
    stiffness: Number = kept(positive=True)
    damping: Number = kept(default=0.0, minimum=0.0)
    pretension: Number = kept(default=0.0, minimum=0.0)
    mu: NumberOrNone = kept(default=None, positive=True)
    crossed: Truth = kept(default=False)

    def check(self, what: str) -> None:
        if len(self.radii) != 2 or min(self.radii) <= 0.0:
            raise InputError(f"{what}: radii = {self.radii}; give two numbers above 0")
        for hinge in (self.hinge_a, self.hinge_b):
            coordinate_of(hinge, "angle", what)
        if self.hinge_a.b is self.hinge_b.b:
            raise InputError(f"{what}: both hinges carry '{self.hinge_a.b.name}'; give two pulleys")
        path_of(self.passed(), what)

    def passed(self) -> tuple[Pulley, ...]:
        """Return the pulleys in the order of the strands, which begin and end at a mark on the first one."""
        axes = [coordinate_of(hinge, "angle", "").axis_b for hinge in (self.hinge_a, self.hinge_b)]
        along = -1 if float(axes[0] @ axes[1]) < 0.0 else 1
        first = Winch(self.hinge_a, radius=self.radii[0], sense=1)
        return first, Pulley(self.hinge_b, radius=self.radii[1], sense=-along if self.crossed else along), first

    def sections(self) -> Sections:
        k, stretch = self.stiffness, self.pretension / self.stiffness
        return Sections([0.0, inf, 0.0], [k, k], [self.damping] * 2, [stretch, stretch])

    def partners(self) -> tuple:
        return (self.hinge_a, self.hinge_b)

    def wraps(self, second: np.ndarray) -> np.ndarray:
        """Return the wraps (samples, 2) of both pulleys, from those (samples, 1) of the second one [rad]."""
        return np.hstack([second if self.crossed else 2.0 * pi - second, second])

    def slip(self, tensions: np.ndarray, wraps: np.ndarray) -> np.ndarray:
        """Return ln(T_high / T_low) / (mu phi) of the pulley that is nearest to slipping; it slips from 1 on."""
        if self.mu is None:
            return np.zeros(len(tensions))
        low, high = tensions.min(axis=1), tensions.max(axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            grip = np.where(high > 0.0, np.log(high / low), 0.0)
        return grip / (self.mu * wraps.min(axis=1))
