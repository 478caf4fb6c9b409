"""Shapes of the parts of an engine, for drawings only. Lengths follow crank radius and spacing."""

from dataclasses import replace
from typing import Any

import numpy as np

from engines.balance.layouts import Engine
from mbsd3d import shapes

STEEL, ROD, PISTON, CASE = "#8a939c", "#c46a2b", "#2f6f9f", "#9aa3ab"


def width(engine: Engine) -> float:
    """Return the length of one throw along the crank [m]: the smallest distance of two stations, at most the crank
    radius.
    """
    gaps = np.diff(np.unique(np.round(engine.stations, 9)))
    return float(min([engine.radius, engine.spacing, *gaps]))


def bore_radius(engine: Engine) -> float:
    """Return the radius of a piston [m]; bores of one bank are a spacing apart."""
    same = [
        abs(a - b)
        for a, u in zip(engine.stations, engine.layout.bores, strict=True)
        for b, v in zip(engine.stations, engine.layout.bores, strict=True)
        if u == v and abs(a - b) > 1e-9
    ]
    return 0.44 * float(min([2.0 * engine.radius, *same]))


def pictured(engine: Engine) -> Engine:
    """Return the engine with bores as far apart as its pistons need; the toy engine has a stroke of 20 bore
    spacings."""
    gaps = np.diff(np.unique(np.round(engine.stations, 9)))
    closest = float(gaps.min()) if gaps.size else engine.spacing
    return replace(engine, spacing=engine.spacing * 1.4 * engine.radius / closest)


def crank(engine: Engine, places: list[Any]) -> list[shapes.Shape]:
    """Draw the crank: main journals along z between the throws, and two webs and a pin of each throw."""
    thick, wide = 0.09 * engine.radius, width(engine)
    low, high = engine.ends
    stations = np.unique(np.round(engine.stations, 9))
    starts, stops = [low, *(stations + 0.32 * wide)], [*(stations - 0.32 * wide), high]
    parts: list[shapes.Shape] = [
        shapes.Cylinder(thick, b - a, "z", at=(0, 0, (a + b) / 2), colour=STEEL)
        for a, b in zip(starts, stops, strict=True)
    ]
    for where in places:
        x, z = where.pin * (1, 1, 0) / engine.radius, where.pin[2]
        turn = np.column_stack([x, np.cross((0, 0, 1), x), (0, 0, 1)])
        parts.append(shapes.Cylinder(thick, 0.8 * wide, "z", at=where.pin, colour=STEEL))
        for side in (-0.38, 0.38):
            at = 0.4 * engine.radius * x + (0, 0, z + side * wide)
            edges = (1.4 * engine.radius, 0.36 * engine.radius, 0.12 * wide)
            parts.append(shapes.Box(edges, at=at, orientation=turn, colour=STEEL))
    return parts


def rod(engine: Engine) -> list[shapes.Shape]:
    """Draw a rod as a beam between two eyes; body axes: x from crankpin to wristpin, O at the centre of mass."""
    L, f, wide = engine.rod_length, engine.rod_fraction, width(engine)
    beam = (L, 0.12 * engine.radius, 0.2 * wide)
    return [
        shapes.Box(beam, at=((0.5 - f) * L, 0, 0), colour=ROD),
        shapes.Cylinder(0.17 * engine.radius, 0.3 * wide, "z", at=(-f * L, 0, 0), colour=ROD),
        shapes.Cylinder(0.11 * engine.radius, 0.3 * wide, "z", at=((1 - f) * L, 0, 0), colour=ROD),
    ]


def piston(engine: Engine, bore: np.ndarray) -> shapes.Shape:
    """Draw a piston as a cylinder along its bore, the wristpin in its lower half."""
    height = 0.55 * engine.radius
    return shapes.Cylinder(bore_radius(engine), height, tuple(bore), at=0.15 * height * bore, colour=PISTON)


def block(engine: Engine, places: list[Any]) -> shapes.Shape:
    """Draw the block as lines: two rings for each bore, and the crank axis; the axes of the bores pass the crank at the
    offset.
    """
    angle, radius = np.linspace(0, 2 * np.pi, 33), bore_radius(engine)
    low, high = engine.ends
    strokes = [np.array([(0, 0, low - 0.3 * engine.radius), (0, 0, high + 0.3 * engine.radius)])]
    for where in places:
        v = np.cross((0, 0, 1), where.bore)
        centre = engine.offset * v + (0, 0, where.pin[2])
        ring = radius * (np.outer(np.cos(angle), v) + np.outer(np.sin(angle), (0, 0, 1)))
        for reach in (engine.rod_length - engine.radius, engine.rod_length + 1.35 * engine.radius):
            strokes.append(centre + reach * where.bore + ring)
    gap = np.full((1, 3), np.nan)
    return shapes.Lines(np.vstack([row for stroke in strokes for row in (stroke, gap)][:-1]), colour=CASE)


def dyno(engine: Engine) -> shapes.Shape:
    """Draw the dynamometer as a disc."""
    return shapes.Disc(0.6 * engine.radius, 0.3 * engine.spacing, colour=CASE)


def shaft(engine: Engine, planes: np.ndarray, angles: np.ndarray) -> list[shapes.Shape]:
    """Draw a thin shaft along z with a weight in each plane at its angle [rad]; O lies on the axis of the shaft."""
    low, high = engine.ends
    rod = shapes.Cylinder(0.05 * engine.radius, high - low, "z", at=(0, 0, (low + high) / 2), colour=STEEL)
    parts: list[shapes.Shape] = [rod]
    for z, angle in zip(planes, angles, strict=True):
        side = 0.12 * engine.radius * np.array([np.cos(angle), np.sin(angle), 0.0])
        parts.append(shapes.Cylinder(0.16 * engine.radius, 0.4 * width(engine), "z", at=side + (0, 0, z), colour=ROD))
    return parts
