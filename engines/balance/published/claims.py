"""Published figures of the toy engines and their origin: the assumptions of the sources, and the physics.

The article's figures are those of cylinders without m_c w^2 r_c of the crank, pushed and pulled along their bores only:
``assumed``. ``actual`` is the load of the masses as declared. Couples of either in units of F a are those of the
assumed force of one cylinder, which makes them numbers of the layout alone.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from engines.balance import phasor
from engines.balance.harmonics import Harmonics, half_axes
from engines.balance.layouts import Engine, layout, names
from mbsd3d.errors import InputError

TOY_FORCE = 4 * np.pi**2  # [N] m R w^2 of toy_set_2: 1 kg, 1 m, 60 rpm
TOY_SPACING = 0.6  # [m] of the cylinders of toy_set_2
FRAME_COUNT = 60  # [1] frames of two turns


@dataclass(frozen=True)
class Row:
    """Figure as published, as the source's assumptions give it, and as it is."""

    source: str
    what: str
    unit: str
    published: float | None
    assumed: float | None
    actual: float | tuple[float, float] | None
    verdict: str
    layouts: tuple[str, ...] = ()  # Names of those it is about


def family(beginnings: str) -> tuple[str, ...]:
    """Return the names of the layouts that begin with one of some words, such as "I4 V8_cross".

    ValueError for a word with which none begins.
    """
    found = {word: [name for name in names() if name.startswith(word)] for word in beginnings.split()}
    for word, layouts in found.items():
        if not layouts:
            raise InputError(f"no layout begins with '{word}'; there are {', '.join(names())}")
    return tuple(name for layouts in found.values() for name in layouts)


@cache
def assumed(name: str, rod_length: float = 2.0) -> Harmonics:
    """Compute the block load of a layout with the first toy set, under the article's assumptions."""
    return phasor.block_load(Engine(name, rod_length=rod_length), article=True, across=False)


@cache
def actual(name: str, rod_length: float = 2.0) -> Harmonics:
    """Compute the block load of a layout with the first toy set."""
    return phasor.block_load(Engine(name, rod_length=rod_length))


def force(h: Harmonics, order: int, axis: int = 0) -> float:
    """Return the amplitude of F_x or F_y (axis 0, 1) [N]."""
    return float(np.abs(h.force[order, axis]))


def couple(h: Harmonics, order: int, axis: int = 1) -> float:
    """Return the amplitude of M_x or M_y (axis 0, 1) [N m]."""
    return float(np.abs(h.moment[order, axis]))


def ellipse(h: Harmonics, order: int) -> tuple[float, float]:
    """Return the long and the short half axis of the couple [N m]."""
    long, short = half_axes(h.forward[order, 1], h.backward[order, 1])
    return float(long), float(short)


def turning(h: Harmonics, order: int) -> tuple[float, float]:
    """Return the forward and the backward part of the couple [N m]."""
    return float(np.abs(h.forward[order, 1])), float(np.abs(h.backward[order, 1]))


def ripple(name: str, order: int) -> float:
    """Return the amplitude of the driving torque of an order [N m]."""
    return float(np.abs(actual(name).torque[order]))


def per_spacing(name: str, order: int, value: float) -> float:
    """Return a couple of `assumed` over F a [-]: F is that order of one cylinder, a the spacing of the layout."""
    return value / force(assumed("single"), order) / layout(name).spacing


def below(name: str, order: int = 6) -> float:
    """Return the largest force, or couple over the spacing, of the orders 1 ... order - 1 [N]."""
    h = actual(name)
    couples = np.abs(h.moment[1:order, :2]) / layout(name).spacing
    return float(max(np.abs(h.force[1:order]).max(), couples.max()))


def relative(name: str, order: int, kind: str) -> list[float]:
    """Return half axes ("ellipse") or forward and backward part ("turning") of the couple over F a [-]."""
    pair = ellipse(assumed(name), order) if kind == "ellipse" else turning(assumed(name), order)
    return [per_spacing(name, order, value) for value in pair]


def toy_load(name: str, theta: np.ndarray, orders: tuple[int, ...] = (1, 2)) -> tuple[np.ndarray, np.ndarray]:
    """Return |F| [N] and |M| [N m] of the second toy set at crank angles theta from pin 1 on the bisector of the banks.

    Two harmonics along every bore, F1 cos q + F1 / 2 cos 2 q; stations as for a bore spacing of 0.6 m.
    """
    plan = layout(name)
    beta, z = np.radians(plan.bores), np.array(plan.stations) * TOY_SPACING / plan.spacing
    q = theta[:, None] + beta.mean() + np.radians(plan.phases)
    along = sum(TOY_FORCE / order * np.cos(order * q) for order in orders)
    x, y = along * np.cos(beta), along * np.sin(beta)
    return np.hypot(x.sum(axis=1), y.sum(axis=1)), np.hypot(y @ z, x @ z)


def frames(name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return |F| [N] and |M| [N m] in the 60 frames of two turns, (60,) each."""
    return toy_load(name, 4 * np.pi * np.arange(FRAME_COUNT) / FRAME_COUNT)


def peaks(name: str, orders: tuple[int, ...] = (1, 2)) -> tuple[float, float]:
    """Return the peaks of |F| [N] and |M| [N m] between the frames, at every hundredth of a degree."""
    found = toy_load(name, 2 * np.pi * np.arange(36000) / 36000, orders)
    return float(found[0].max()), float(found[1].max())
