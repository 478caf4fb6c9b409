"""Engines in the pose of their pictures: crank level, bores up, and cylinders spaced like those of a real engine.

The motion of a cylinder does not depend on its station, so that only the picture changes. `shown` is that engine in
motion, for animations; `sketch` draws it in parallel perspective at q = 0, from back to front, for paper.
"""

from dataclasses import fields, replace
from typing import Any

import numpy as np
from markupsafe import Markup
from scipy.spatial import ConvexHull

from engines.balance import looks, spatial
from engines.balance.layouts import Engine, Layout
from engines.balance.pages import drawings
from mbsd3d import GROUND, Body, Joint, Solution, System
from mbsd3d.extend import VIEW_AXES, matrix

DRAWING_SIZE, DRAWING_MARGIN = np.array([360.0, 250.0]), 12.0  # width and height
CIRCLE_ANGLES = np.linspace(0, 2 * np.pi, 37)[:-1]  # [rad] of the points of a circle


def upright(layout: Layout) -> np.ndarray:
    """Return the rotation into a world whose x is the crank axis and whose z is the middle of the bores, shape (3, 3).

    Opposed bores have no middle; they lie level, at right angles to z.
    """
    beta = np.radians(layout.bores)
    middle = np.array([np.cos(beta).sum(), np.sin(beta).sum(), 0.0])
    if np.linalg.norm(middle) < 1e-9:
        middle = np.array([-np.sin(beta[0]), np.cos(beta[0]), 0.0])
    up = middle / np.linalg.norm(middle)
    axis = np.array([0.0, 0.0, 1.0])
    return np.stack([axis, np.cross(up, axis), up])


def turned(system: System, R: np.ndarray) -> System:
    """Return the mechanism rotated by R: every position and direction v becomes R v.

    ``system``: without forces; bodies at rest or with what the joints give them; ``R`` (3, 3): rotation. The names stay
    the same.
    """
    found: dict[int, Any] = {id(GROUND): GROUND}
    for body in system.bodies:
        orientation = R @ matrix(body.orientation)
        found[id(body)] = replace(body, position=R @ body.position, orientation=orientation)
    for joint in system.joints:
        values = {}
        for field in fields(joint):
            value = getattr(joint, field.name)
            if isinstance(value, Body | Joint) or value is GROUND:
                values[field.name] = found[id(value)]
            elif field.name.startswith(("at", "axis")):
                values[field.name] = R @ value
        found[id(joint)] = replace(joint, **values)
    bodies, joints = ([found[id(part)] for part in parts] for parts in (system.bodies, system.joints))
    return System(bodies, joints, gravity=R @ system.gravity)


def shown(engine: Engine) -> Solution:
    """Simulate one turn of the engine for its animation, upright and with its cylinders apart."""
    apart = looks.pictured(engine)
    return spatial.turn(turned(spatial.build(apart), upright(engine.layout)), apart)


def sketch(engine: Engine) -> Markup:
    """Draw the engine upright and with its cylinders apart, as `shown` animates it."""
    engine = looks.pictured(engine)
    to_paper = VIEW_AXES @ upright(engine.layout)  # towards the reader, right, up
    items = [item for i in range(len(engine.stations)) for item in cylinder(engine, spatial.place(engine, i))]
    stations, half, (low, high) = np.unique(np.round(engine.stations, 9)), 0.38 * looks.width(engine), engine.ends
    journals = zip([low, *(stations + half)], [*(stations - half), high], strict=True)
    items += [("crank", np.array([(0, 0, a), (0, 0, b)])) for a, b in journals]
    seen = [(kind, points @ to_paper.T) for kind, points in items]
    seen.sort(key=lambda item: round(float(item[1][:, 0].mean()), 9))
    flat = np.concatenate([points[:, 1:] for _, points in seen])
    low, extent = flat.min(axis=0), np.ptp(flat, axis=0)
    scale = float(np.min((DRAWING_SIZE - 2 * DRAWING_MARGIN) / extent))
    width, height = extent * scale + 2 * DRAWING_MARGIN
    body = "".join(
        shape(kind, (points - (0, *low)) * scale + DRAWING_MARGIN, scale * engine.radius) for kind, points in seen
    )
    return drawings.svg(width, height, body, f"{engine.layout.name} in space", f"0 {-height:.2f}")


def cylinder(engine: Engine, where: spatial.Place) -> list[tuple[str, np.ndarray]]:
    """Return webs, pin and rod of a cylinder as lines and its piston as two rings, (k, 3) each, world axes of the
    engine [m].
    """
    end, axis = np.array([0, 0, 0.38 * looks.width(engine)]), where.pin * (0, 0, 1)
    across, along = np.cross((0, 0, 1), where.bore), 0.55 * engine.radius * where.bore
    ring = looks.bore_radius(engine) * (
        np.outer(np.cos(CIRCLE_ANGLES), across) + np.outer(np.sin(CIRCLE_ANGLES), (0, 0, 1))
    )
    skirt, crown = where.wrist - 0.35 * along + ring, where.wrist + 0.65 * along + ring
    return [
        ("crank", np.array([axis - end, where.pin - end, where.pin + end, axis + end])),
        ("rod", np.array([where.pin, where.wrist])),
        ("piston", np.concatenate([skirt, crown])),
    ]


def shape(kind: str, points: np.ndarray, radius: float) -> str:
    """Draw a part from (k, 3) points (towards the reader, right, up); ``radius`` is the crank radius in the drawing."""
    z = points[:, 1:] @ (1, 1j)
    if kind != "piston":
        width = (0.2 if kind == "crank" else 0.16) * radius
        return f'<g stroke-width="{width:.2f}">{drawings.stroke(kind, *z)}</g>'
    hull, n = z[ConvexHull(points[:, 1:]).vertices], CIRCLE_ANGLES.size
    open_to_reader = points[:n, 0].mean() > points[n:, 0].mean()
    face = drawings.area("skirt", *z[:n]) if open_to_reader else drawings.area("crown", *z[n:])
    return drawings.area("piston", *hull) + face
