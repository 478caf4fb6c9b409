"""Rating life of rolling bearings by ISO 281 under the loads of a run.

    P = F_r where |F_a| <= e F_r, else X F_r + Y |F_a|;   P_m = (int P^p |n| dt / int |n| dt)^(1/p);   L10 = (C / P_m)^p

with L10 in millions of revolutions, p = 3 for balls and 10/3 for rollers; the ratings come from the catalogue.
"""

from dataclasses import KW_ONLY, dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import number
from ..base.errors import InputError, explaining
from ..base.fields import Frozen, Number, kept, part_class
from .bearings import BearingLoad

BALL, ROLLER = 3.0, 10.0 / 3.0
"""Load-life exponents p."""

ROUNDING = 1e-9
"""Forces below this part of the greatest, moments below it times the model's length, are what is left of zero."""

AXIAL = (0.172, 0.345, 0.689, 1.03, 1.38, 2.07, 3.45, 5.17, 6.89)
LIMIT_RATIO = (0.19, 0.22, 0.26, 0.28, 0.30, 0.34, 0.38, 0.42, 0.44)
AXIAL_FACTOR = (2.30, 1.99, 1.71, 1.55, 1.45, 1.31, 1.15, 1.04, 1.00)
"""f0 F_a / C0, e and Y of single-row deep groove ball bearings, X = 0.56 (ISO 281, table 3; SKF catalogue, table 9)."""


@dataclass(frozen=True)
class RatingLife:
    """Basic rating life of 90 % reliability under the loads of a run, repeated for ever."""

    load: float  # mean equivalent dynamic load P_m [N]
    speed: float  # mean of the magnitude of the speed [rad/s]
    revolutions: float  # L10 [millions of revolutions]
    hours: float  # L10h [h]


@part_class(eq=True)
class Rating(Frozen):
    """Base class of rolling bearings.

    ``C``: basic dynamic load rating [N] > 0; ``p``: load-life exponent, `BALL` = 3 or `ROLLER` = 10/3; ``tilting``:
    tilting moment it can carry besides [N m].
    """

    _: KW_ONLY
    C: Number = kept(positive=True)
    p: Number = kept(default=BALL, positive=True)
    tilting: Number = kept(default=0.0, minimum=0.0)

    def factors(self, axial: np.ndarray) -> tuple[ArrayLike, ArrayLike, ArrayLike]:
        """(X, Y, e) under axial forces >= 0 [N]."""
        raise NotImplementedError

    def equivalent(self, radial: ArrayLike, axial: ArrayLike) -> np.ndarray:
        """Equivalent dynamic load P [N] of radial and axial forces [N]."""
        radial, axial = np.abs(radial), np.abs(axial)
        X, Y, e = self.factors(axial)
        return np.where(axial <= e * radial, radial, X * radial + Y * axial)

    def life(self, load: BearingLoad) -> RatingLife:
        """L10 and L10h under the loads and speeds of a run.

        ValueError if the bearing does not turn, is never loaded, or cannot carry the axial forces (Y = 0) or tilting
        moments.
        """
        what = f"{type(self).__name__}.life: '{load.name}'"
        zero = ROUNDING * np.abs(load.force).max(initial=0.0)
        if load.tilting.max() > self.tilting + zero * load.length:
            raise InputError(
                f"{what}: a tilting moment of {load.tilting.max():g} N m, the bearing carries {self.tilting:g}; "
                "give tilting=, or split the hinge with bearing_pair"
            )
        if np.abs(load.axial).max() > zero and not np.min(self.factors(np.abs(load.axial))[1]) > 0.0:
            raise InputError(f"{what}: an axial force of {np.abs(load.axial).max():g} N, but Y = 0; give X, Y and e")
        return self.life_of(load.t, self.equivalent(load.radial, load.axial), load.speed, what)

    def life_of(self, t: ArrayLike, load: ArrayLike, speed: ArrayLike, what: str = "life_of") -> RatingLife:
        """L10 of equivalent loads P [N] and speeds [rad/s] over times [s] (trapezoidal rule)."""
        t, load, speed = (np.asarray(x, float) for x in (t, load, np.abs(speed)))
        angle = np.trapezoid(speed, t)
        if not angle > 0.0:
            raise InputError(f"{what}: it does not turn in this run, so it has no rating life; size it by C0")
        mean = (np.trapezoid(load**self.p * speed, t) / angle) ** (1.0 / self.p)
        if not mean > 0.0:
            raise InputError(f"{what}: it is never loaded, so its life has no end; give a run with loads")
        revolutions, rate = (self.C / mean) ** self.p, angle / (t[-1] - t[0])
        return RatingLife(
            float(mean), float(rate), float(revolutions), float(revolutions * 1e6 * 2 * np.pi / rate / 3600.0)
        )


@part_class(eq=True)
class RollingBearing(Rating):
    """A bearing with the factors of its catalogue; the defaults are those of one that carries radial loads alone.

    ``X``, ``Y``: radial and axial factor; ``e``: the ratio |F_a| / F_r above which they count; ``C, p, tilting`` as
    `Rating`.

    >>> bearing = RollingBearing(C=7350.0, X=0.56, Y=1.6, e=0.3)
    >>> round(float(bearing.equivalent(2500.0, 1000.0)), 6)
    3000.0
    """

    _: KW_ONLY
    X: Number = kept(default=1.0, minimum=0.0)
    Y: Number = kept(default=0.0, minimum=0.0)
    e: Number = kept(default=0.0, minimum=0.0)

    def factors(self, axial: np.ndarray) -> tuple[float, float, float]:
        return self.X, self.Y, self.e


@part_class(eq=True)
class DeepGrooveBallBearing(Rating):
    """A single-row deep groove ball bearing of normal clearance: Y and e from f0 F_a / C0 by the table of ISO 281.

    Values between the rows are interpolated; below the first row its values hold, above the last is an error. ``C``,
    ``C0``: basic dynamic and static load rating [N] > 0; ``f0``: factor of the catalogue, 11 ... 17 by size; ``p,
    tilting`` as `Rating`.

    >>> bearing = DeepGrooveBallBearing(C=30700.0, C0=19000.0, f0=14.0)
    >>> [round(float(x), 3) for x in bearing.factors(19000.0 / 14.0 * 1.205)]  # half-way between two rows
    [0.56, 1.5, 0.29]
    """

    _: KW_ONLY
    C0: Number = kept(positive=True)
    f0: Number = kept(positive=True)

    def factors(self, axial: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        ratio = self.f0 * np.asarray(axial, float) / self.C0
        if ratio.max() > AXIAL[-1]:
            raise InputError(
                f"DeepGrooveBallBearing: f0 F_a / C0 = {ratio.max():g} is beyond the table, which ends at {AXIAL[-1]}; "
                "take a greater bearing, or one made for axial loads"
            )
        return 0.56, np.interp(ratio, AXIAL, AXIAL_FACTOR), np.interp(ratio, AXIAL, LIMIT_RATIO)


@explaining
def reliability_factor(reliability: float) -> float:
    """a1 of L_n = a1 L10: Weibull's ``(ln(1/R) / ln(1/0.9))^(1/1.5)``, which gives the table of ISO 281:1990.

    0.9 <= R < 1. (The table of the 2007 edition allows somewhat more: this is on the safe side.)

    >>> round(reliability_factor(0.95), 2)
    0.62
    """
    R = number(reliability, "reliability_factor: reliability", minimum=0.9)
    if R >= 1.0:
        raise InputError(f"reliability_factor: reliability {R:g}: no bearing is certain; give 0.9 <= R < 1, e.g. 0.95")
    return float((np.log(R) / np.log(0.9)) ** (1.0 / 1.5))
