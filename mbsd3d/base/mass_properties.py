"""Mass, centre of mass and inertia of parts put together, and which inertia a body can have."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .checks import (
    MAGNITUDE_MAX,
    MAGNITUDE_MIN,
    PLAIN_NUMBER_TYPES,
    as_tuple,
    check_size,
    floats,
    number,
    plain_three,
    vector,
)
from .errors import ChecksArguments, InputError, checks_arguments
from .rotations import _text, as_quaternion, matrix

# [1] of the largest moment; a flat body lies on the limit, where rounding falls on either side
TRIANGLE_RULE_TOLERANCE = 1e-9


@dataclass(frozen=True, eq=False)
class MassProperties(metaclass=ChecksArguments):
    """Mass, centre of mass and inertia of a rigid body; ``Body(name, **vars(properties))`` takes them as they are.

    >>> from mbsd3d.inertia import box, rod
    >>> hammer = combine([(0.3, (0, 0, 0.15), rod(0.3, 0.3)), (0.5, (0, 0, 0.3), box(0.5, (0.1, 0.03, 0.03)))])
    >>> hammer.com.round(5)
    array([0.     , 0.     , 0.24375])
    """

    mass: float  # [kg]
    com: np.ndarray  # (3,) in the axes and from the origin the parts were given in [m]
    inertia: np.ndarray  # (3, 3) about ``com``, in the same axes [kg m^2]


@checks_arguments
def combine(parts: Iterable[tuple[Any, ...] | MassProperties]) -> MassProperties:
    """Combine parts to one rigid body: ``m = sum m_i``, ``c = sum m_i c_i / m``, Steiner's rule for the inertia.

    ``I = sum R_i I_i R_i' + m_i (d_i'd_i 1 - d_i d_i')`` with ``d_i = c_i - c``.

    A part is (mass, com, inertia) or (mass, com, inertia, orientation): mass [kg]; centre of mass (3,) in the common
    axes [m]; inertia about it, (3,) or (3, 3), in the part's axes [kg m^2]; orientation part axes -> common axes as a
    quaternion or matrix (none: common axes). A result of `combine` in the same axes is a part too. ValueError for no
    part, a part of another form or with an impossible inertia, or masses that add up to zero.

    >>> from mbsd3d.inertia import sphere
    >>> barbell = combine([(2.0, (0, 0, 0.5), sphere(2.0, 0.1)), (2.0, (0, 0, -0.5), sphere(2.0, 0.1))])
    >>> barbell.mass, barbell.inertia.diagonal().round(3)
    (4.0, array([1.016, 1.016, 0.016]))
    """
    given = as_tuple(parts, "combine: parts", "a list of (mass, com, inertia)")
    whole = put_together([_part(i, part) for i, part in enumerate(given)])
    if whole.mass == 0.0:
        raise InputError(f"combine: the mass of {len(given)} parts is 0, without a centre of mass; give one a mass")
    return whole


def put_together(parts: list[tuple[float, np.ndarray, np.ndarray]]) -> MassProperties:
    """Return the rigid body made of (mass, com, inertia about it) in common axes; the inertias are not checked.

    Without mass its centre is the origin.
    """
    mass = sum(m for m, _, _ in parts)
    com = sum((m * c for m, c, _ in parts), np.zeros(3)) / (mass or 1.0)
    total = sum((I + steiner(m, c - com) for m, c, I in parts), np.zeros((3, 3)))
    return MassProperties(mass, com, total)


@checks_arguments
def steiner(mass: float, offset: ArrayLike) -> np.ndarray:
    """Return what a mass [kg] adds to the inertia at ``d = offset`` (3,) [m]: ``m (d'd 1 - d d')`` [kg m^2]."""
    d = vector(offset, "steiner: offset")
    return number(mass, "steiner: mass") * (d @ d * np.eye(3) - np.outer(d, d))


def check_inertia(inertia: ArrayLike, mass: float, what: str, *, as_given: bool = False) -> np.ndarray:
    """Return an inertia as an exactly symmetric matrix (3, 3), or raise a ValueError if no body can have it.

    A body has moments ``I1, I2, I3 >= 0`` of which none exceeds the sum of the two others, since ``I1 + I2 - I3 = 2 int
    z^2 dm`` (tolerance 1e-9 of the largest entry). A mass without inertia is a point; without mass there is no inertia
    either. ``inertia`` (3,) or (3, 3) [kg m^2], body axes; ``what`` names the part, "body 'wheel'"; ``as_given``: take
    moments >= 0 that break the rule of the sum, with which the motion is defined all the same.
    """
    plain = _plain_inertia(inertia, mass)
    if plain is not None:
        return plain
    m = _size(mass, what, "mass")
    I, largest = _finite_inertia(inertia, what)
    if largest > 0.0 and m == 0.0:
        raise InputError(f"{what}: mass is 0 but inertia is not; give a mass, or inertia (0, 0, 0) for a massless body")
    if I.ndim == 1:
        _check_moments(np.sort(I), TRIANGLE_RULE_TOLERANCE * largest, what, as_given)
        return np.diag(I)
    if np.max(np.abs(I - I.T)) > TRIANGLE_RULE_TOLERANCE * largest:
        raise InputError(f"{what}: inertia is not symmetric, {_text(I)}; make Iij and Iji equal")
    I = 0.5 * (I + I.T)
    _check_moments(np.linalg.eigvalsh(I), TRIANGLE_RULE_TOLERANCE * largest, what, as_given)
    return I


def _plain_inertia(inertia: ArrayLike, mass: float) -> np.ndarray | None:
    """Return a new matrix of an inertia that a body can have beyond doubt; None for whatever needs a closer look.

    Beyond doubt: moments within the triangle rule, or a matrix that is symmetric to the last bit and has a positive
    definite ``tr(I) 1 - 2 I``.
    """
    if type(mass) not in PLAIN_NUMBER_TYPES or not MAGNITUDE_MIN <= mass <= MAGNITUDE_MAX:
        return None
    moments = plain_three(inertia)
    if moments is not None:
        a, b, c = moments.tolist()
        total = a + b + c
        if not (b + c >= a and a + c >= b and a + b >= c and (total == 0.0 or total > 3.0 * MAGNITUDE_MIN)):
            return None
        I = np.zeros((3, 3))
        I[0, 0], I[1, 1], I[2, 2] = a, b, c
        return I
    if type(inertia) is not np.ndarray or inertia.shape != (3, 3) or inertia.dtype != np.float64:
        return None
    (a, d, e), (d_T, b, f), (e_T, f_T, c) = inertia.tolist()
    x, y, z = b + c - a, a + c - b, a + b - c
    if not (d == d_T and e == e_T and f == f_T and x > 0.0 and MAGNITUDE_MIN < a + b + c < MAGNITUDE_MAX):
        return None
    y, z, w = y - 4.0 * d * d / x, z - 4.0 * e * e / x, 2.0 * f + 4.0 * d * e / x  # Cholesky
    return inertia.copy() if y > 0.0 and z - w * w / y > 0.0 else None


def _check_moments(moments: np.ndarray, tolerance: float, what: str, as_given: bool) -> None:
    """Refuse principal moments (ascending) that no distribution of mass has."""
    remedy = "check the signs and units, and that it is taken about the centre of mass"
    if moments[0] < -tolerance:
        raise InputError(f"{what}: inertia has the principal moments {_text(moments)}, {moments[0]:.9g} < 0; {remedy}")
    rest = moments[0] + moments[1]
    if moments[2] > rest + tolerance and not as_given:
        raise InputError(
            f"{what}: inertia has the principal moments {_text(moments)}; "
            f"{moments[2]:.9g} exceeds the sum {rest:.9g} of the two others, which no body has; {remedy}, "
            "or give inertia_as_given=True"
        )


def _finite_inertia(inertia: ArrayLike, what: str) -> tuple[np.ndarray, float]:
    """Return three moments or a matrix of finite floats, and the largest of them by size."""
    remedy = "three moments or a 3x3 matrix about the centre of mass [kg m^2]"
    I = floats(inertia, f"{what}: inertia", remedy)
    if I.shape not in ((3,), (3, 3)):
        raise InputError(f"{what}: inertia has shape {I.shape}; give {remedy}")
    check_size(I, f"{what}: inertia")
    largest = max(map(abs, I.ravel().tolist()))
    if 0.0 < largest < MAGNITUDE_MIN:
        raise InputError(f"{what}: inertia {_text(I)} is below {MAGNITUDE_MIN:.0e}; check the units, or give zeros")
    return I, largest


def _part(number: int, part: tuple[Any, ...] | MassProperties) -> tuple[float, np.ndarray, np.ndarray]:
    """Return mass, centre of mass and inertia of one part, turned into the common axes."""
    what = f"combine: part {number}"
    if isinstance(part, MassProperties):
        part = (part.mass, part.com, part.inertia)
    part = as_tuple(part, what, "(mass, com, inertia)")
    if len(part) not in (3, 4):
        raise InputError(f"{what} has {len(part)} entries; give (mass, com, inertia) and possibly an orientation")
    I = check_inertia(part[2], part[0], what)
    if len(part) == 4:
        R = matrix(as_quaternion(part[3], f"{what}: orientation"))
        I = R @ I @ R.T
        I = 0.5 * (I + I.T)
    return float(part[0]), vector(part[1], f"{what}: com"), I


def _size(value: float, what: str, name: str) -> float:
    """Return a finite number that is not negative."""
    x = number(value, f"{what}: {name}", minimum=0.0)
    if 0.0 < x < MAGNITUDE_MIN:
        raise InputError(f"{what}: {name} {x} is below {MAGNITUDE_MIN:.0e}; check the units, or give 0")
    return x
