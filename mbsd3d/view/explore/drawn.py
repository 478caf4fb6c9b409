"""Picture of a mechanism over the sliders of its page: corners of meshes, points of lines, ends of springs and rods."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...base.errors import InputError
from ...base.rotations import Carried
from ...mechanism.mechanism import Mechanism
from ..scene.artist import draw_system
from ..scene.drawing import MARKS
from ..scene.nodes import ghost_nodes, mesh_nodes, wire_nodes
from .sliders import Build, Slider, Values, built, fitted

SEEN, UNIT = 1e-3, 1e-4  # [1] of the size of the picture: what one sees; of the whole numbers that stand in the page
DEGREES = (4, 12)  # of the polynomials
Name = tuple[Any, str]  # node, or (group, place) of a spring or rod; what of it


class Drawn(NamedTuple):
    """Numbers of a node of the picture, about its origin."""

    layer: str
    numbers: np.ndarray


def parts_of(system: Mechanism, origin: np.ndarray) -> tuple[dict[Name, Drawn], float]:
    """Return what is drawn of a mechanism by its names in the page, and the size of the picture [m]."""
    drawing, ground = draw_system(system), len(system.bodies)

    def near(body: int, points: np.ndarray) -> np.ndarray:
        return (points - origin if body == ground else points).ravel()

    found: dict[Name, Drawn] = {}
    for x in mesh_nodes(drawing):
        found[x.name, "vertices"] = Drawn(x.layer, near(x.body, x.mesh.vertices))
    for y in wire_nodes(drawing):
        found[y.name, "points"] = Drawn(y.layer, near(y.body, y.segments))
    for body, mesh in ghost_nodes(drawing):
        if body != ground:
            found[f"/ghosts/{body}/mesh", "vertices"] = Drawn("bodies", mesh.vertices.ravel())
    kinds = [[x for x in drawing.links if x.spring == spring] for spring in (True, False)]
    for group, links in enumerate(kind for kind in kinds if kind):
        for i, link in enumerate(links):
            ends = np.concatenate([near(*end) for end in link.ends])
            found[(group, i), "ends"] = Drawn("springs and rods", ends)
            if link.rounds:
                found[(group, i), "rounds"] = Drawn("springs and rods", np.array(link.rounds.arms, float))
    return found, drawing.size


def picture_over(build: Build, sliders: Sequence[Slider], origin: np.ndarray) -> tuple[list[dict[str, Any]], set[str]]:
    """Return what of the picture the sliders change, as polynomials of them, and the layers that cannot follow."""
    start, carried = {x.name: x.start for x in sliders}, Carried()

    def at(values: Values) -> tuple[dict[Name, Drawn], float]:
        system = built(build, values)[0]
        with carried.again():
            return parts_of(system, origin)

    first, size = at(start)
    ends = [at({**start, x.name: end})[0] for x in sliders for end in (x.low, x.high)]
    stale = {
        part.layer for one, other in ((x, y) for end in ends for x, y in ((first, end), (end, first)))
        for name, part in one.items() if name not in other or other[name].numbers.size != part.numbers.size
    }  # fmt: skip
    moving = [
        name for name, part in first.items() if part.layer not in stale
        and max((np.abs(end[name].numbers - part.numbers).max() for end in ends), default=0.0) > 1e-6 * size
    ]  # fmt: skip
    stale |= {first[name].layer for name in moving if name[1] == "rounds" or first[name].layer in MARKS}
    moving = [name for name in moving if first[name].layer not in stale]
    if not moving:
        return [], stale

    def numbers(values: Values) -> np.ndarray:
        found, _ = at(values)
        parts = [found[name].numbers for name in moving if name in found]
        if [x.size for x in parts] != [first[name].numbers.size for name in moving]:
            raise InputError("the picture has other parts there")
        return np.concatenate(parts)

    try:
        found, error = fitted(numbers, sliders, lambda x: np.full(x.shape[-1], size), DEGREES, UNIT)
    except ValueError:
        return [], stale | {first[name].layer for name in moving}
    cuts = np.cumsum([first[name].numbers.size for name in moving])[:-1]
    errors, terms = np.split(error, cuts), np.split(found, cuts, axis=-1)
    stale |= {first[name].layer for name, x in zip(moving, errors, strict=True) if x.max() > SEEN}
    whole = [
        {"node": name[0], "key": name[1], "unit": UNIT * size, "terms": whole_terms(x, UNIT * size)}
        for name, x in zip(moving, terms, strict=True) if first[name].layer not in stale
    ]  # fmt: skip
    return whole, stale


def whole_terms(found: np.ndarray, unit: float) -> list[list[list[int]]]:
    """Return (degrees, numbers in units) of the terms that are not zero."""
    rounded = np.rint(found / unit).astype(int)
    degrees = np.argwhere(rounded.any(axis=-1))
    return [[place.tolist(), rounded[tuple(place)].tolist()] for place in degrees]
