"""Moments of inertia of simple homogeneous solids about their centres of mass, and of parts put together.

Masses [kg] and lengths [m] are finite and not negative, ``axis`` is "x", "y" or "z", else a ValueError. The solids
return the principal moments (3,) about the centre of mass, body axes [kg m^2].
"""

import numpy as np
from numpy.typing import ArrayLike

from .checks import as_tuple, short_repr
from .errors import InputError, checks_arguments
from .mass_properties import _size
from .rotations import AXES


@checks_arguments
def box(mass: float, lengths: ArrayLike) -> np.ndarray:
    """Return the moments of a box with edges ``lengths`` (lx, ly, lz): ``Ixx = m (ly^2 + lz^2) / 12`` and cyclic.

    >>> box(12.0, (1.0, 2.0, 3.0))
    array([13., 10.,  5.])
    """
    edges = as_tuple(lengths, "box: lengths", "three lengths (lx, ly, lz)")
    if len(edges) != 3:
        raise InputError(f"box: {len(edges)} edges given; give three lengths (lx, ly, lz)")
    squares = np.array([_size(edge, "box", name) for edge, name in zip(edges, ("lx", "ly", "lz"), strict=True)]) ** 2
    return _size(mass, "box", "mass") * (squares.sum() - squares) / 12.0


@checks_arguments
def cylinder(mass: float, radius: float, length: float, axis: str = "z") -> np.ndarray:
    """Return the moments of a solid cylinder: ``m r^2 / 2`` along its axis, ``m (3 r^2 + l^2) / 12`` across.

    >>> cylinder(12.0, 1.0, 2.0, "x")
    array([6., 7., 7.])
    """
    m, r, l = _size(mass, "cylinder", "mass"), _size(radius, "cylinder", "radius"), _size(length, "cylinder", "length")
    return _axial(0.5 * m * r**2, m * (3.0 * r**2 + l**2) / 12.0, axis, "cylinder")


@checks_arguments
def sphere(mass: float, radius: float) -> np.ndarray:
    """Return the moments of a solid sphere: ``2 m r^2 / 5`` about every axis.

    >>> sphere(5.0, 2.0)
    array([8., 8., 8.])
    """
    return np.full(3, 0.4 * _size(mass, "sphere", "mass") * _size(radius, "sphere", "radius") ** 2)


@checks_arguments
def ellipsoid(mass: float, radii: ArrayLike) -> np.ndarray:
    """Return the moments of a solid ellipsoid with half axes ``radii`` (a, b, c): ``Ixx = m (b^2 + c^2) / 5``, cyclic.

    >>> ellipsoid(5.0, (1.0, 2.0, 3.0))
    array([13., 10.,  5.])
    """
    axes = as_tuple(radii, "ellipsoid: radii", "three half axes (a, b, c)")
    if len(axes) != 3:
        raise InputError(f"ellipsoid: {len(axes)} half axes given; give three (a, b, c)")
    squares = np.array([_size(x, "ellipsoid", name) for x, name in zip(axes, "abc", strict=True)]) ** 2
    return _size(mass, "ellipsoid", "mass") * (squares.sum() - squares) / 5.0


@checks_arguments
def capsule(mass: float, radius: float, length: float, axis: str = "z") -> np.ndarray:
    """Return the moments of a solid capsule: a cylinder of ``length`` with half balls on its ends, beyond the length.

    With the masses c of the cylinder and b of both half balls: along its axis ``c r^2 / 2 + 2 b r^2 / 5``, across
    ``c (3 r^2 + l^2) / 12 + b (2 r^2 / 5 + l^2 / 4 + 3 r l / 8)``.

    >>> capsule(5.0, 2.0, 0.0)  # a sphere
    array([8., 8., 8.])
    """
    m, r, l = _size(mass, "capsule", "mass"), _size(radius, "capsule", "radius"), _size(length, "capsule", "length")
    whole = l + 4.0 / 3.0 * r  # length of the cylinder of the same volume
    c = m * l / whole if whole else m
    b = m - c
    across = c * (3.0 * r**2 + l**2) / 12.0 + b * (0.4 * r**2 + 0.25 * l**2 + 0.375 * r * l)
    return _axial(0.5 * c * r**2 + 0.4 * b * r**2, across, axis, "capsule")


@checks_arguments
def rod(mass: float, length: float, axis: str = "z", radius: float = 0.0) -> np.ndarray:
    """Return the moments of a rod: ``m l^2 / 12`` across, nothing along; those of a `cylinder` if it has a radius.

    >>> rod(12.0, 2.0)
    array([4., 4., 0.])
    """
    m, l, r = _size(mass, "rod", "mass"), _size(length, "rod", "length"), _size(radius, "rod", "radius")
    return cylinder(m, r, l, _letter(axis, "rod"))


@checks_arguments
def cone(mass: float, radius: float, height: float, axis: str = "z") -> np.ndarray:
    """Return the moments of a solid cone: ``3 m r^2 / 10`` along its axis, ``3 m (4 r^2 + h^2) / 80`` across.

    The centre of mass lies on the axis, h/4 from the base and 3h/4 from the tip; which end is the tip does not matter.

    >>> cone(80.0, 1.0, 2.0)
    array([24., 24., 24.])
    """
    m, r, h = _size(mass, "cone", "mass"), _size(radius, "cone", "radius"), _size(height, "cone", "height")
    return _axial(0.3 * m * r**2, 3.0 * m * (4.0 * r**2 + h**2) / 80.0, axis, "cone")


def _axial(along: float, across: float, axis: str, what: str) -> np.ndarray:
    """Return the (3,) moments of a body of revolution."""
    return np.where(np.array(AXES[_letter(axis, what)]) == 1.0, along, across)


def _letter(axis: str, what: str) -> str:
    """Return the axis, if it is one of the three letters."""
    if not isinstance(axis, str) or axis not in AXES:
        raise InputError(f"{what}: axis is {short_repr(axis)}; give 'x', 'y' or 'z' (others: orientation in combine)")
    return axis
