"""Triangles of 3MF files: a ZIP archive with a model in XML, objects with transforms, and a unit."""

import zipfile
from collections.abc import Iterator
from io import BytesIO
from typing import TYPE_CHECKING

import numpy as np

from ...base.errors import InputError

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

METRES = {"micron": 1e-6, "millimeter": 1e-3, "centimeter": 1e-2, "inch": 0.0254, "foot": 0.3048, "meter": 1.0}
"""Units of a 3MF file [m]; without one it is in millimetres."""
RELATIONS = "_rels/.rels"  # the file of the archive that says which file is the model
XML_BYTES_MAX = 20_000_000  # [bytes] of the model, unpacked: some 250 000 triangles, which take 300 MB as a tree
NESTING_MAX = 32  # [1] objects in objects
OBJECTS_MAX = 10_000  # [1] objects that are placed, those in objects too


def read_3mf(content: bytes, triangles_max: int) -> tuple[np.ndarray, np.ndarray, float]:
    """Return vertices (k, 3) and faces (m, 3) of what a 3MF file builds, and its unit [m]; ValueError if it is none.

    At most ``triangles_max`` triangles.
    """
    with zipfile.ZipFile(BytesIO(content)) as archive:
        root = xml_of(archive, model_name(archive))
    unit = root.get("unit", "millimeter")
    if unit not in METRES:
        raise InputError(f"is in the unit '{unit[:20]}', not one of {', '.join(METRES)}")
    objects = {found.get("id"): found for found in root.iter() if tag(found) == "object"}
    points: list[np.ndarray] = []
    faces: list[np.ndarray] = []
    count = triangles = 0
    for mesh, place in placed_meshes(root, objects):
        corners, sides = numbers(mesh, "vertex", ("x", "y", "z")), numbers(mesh, "triangle", ("v1", "v2", "v3"))
        triangles += len(sides)
        if len(points) >= OBJECTS_MAX or triangles > triangles_max:
            raise InputError(f"places more than {triangles_max} triangles or {OBJECTS_MAX} objects")
        points.append(corners @ place[:3] + place[3])
        turned_over = np.linalg.det(place[:3]) < 0.0  # a mirror image
        faces.append((sides[:, ::-1] if turned_over else sides).astype(int) + count)
        count += len(corners)
    if not points:
        raise InputError("builds nothing")
    return np.concatenate(points), np.concatenate(faces), METRES[unit]


def model_name(archive: zipfile.ZipFile) -> str:
    """Return the name of the model in the archive."""
    for relation in xml_of(archive, RELATIONS):
        if relation.get("Type", "").endswith("/3dmodel"):
            return relation.get("Target", "").lstrip("/")
    raise InputError("names no model")


def xml_of(archive: zipfile.ZipFile, name: str) -> "Element":
    """Return the root of an XML file of the archive that declares nothing: no entities grow, and no file is opened."""
    if archive.getinfo(name).file_size > XML_BYTES_MAX:
        raise InputError(f"has more than {XML_BYTES_MAX} bytes unpacked")
    plain = archive.read(name).decode("utf-8-sig")
    if "<!DOCTYPE" in plain or "<!ENTITY" in plain:
        raise InputError("declares entities")
    from xml.etree import ElementTree  # takes a few milliseconds, of every start

    return ElementTree.fromstring(plain)


def tag(element: "Element") -> str:
    """Return the name of an element without its name space."""
    return element.tag.rpartition("}")[2]


def numbers(mesh: "Element", name: str, keys: tuple[str, ...]) -> np.ndarray:
    """Return (k, 3) numbers of the elements of a name."""
    rows = [[float(part.attrib[key]) for key in keys] for part in mesh.iter() if tag(part) == name]
    return np.array(rows, float).reshape(-1, 3)


def placed_meshes(root: "Element", objects: "dict[str | None, Element]") -> "Iterator[tuple[Element, np.ndarray]]":
    """Yield each mesh that is built, with its place (4, 3): rows of a point (x, y, z, 1) times it are the point."""
    waiting = [(item, np.eye(4, 3), 0) for part in root.iter() if tag(part) == "build" for item in part][::-1]
    visited = 0
    while waiting:
        item, outer, depth = waiting.pop()
        visited += 1
        if depth > NESTING_MAX or visited > OBJECTS_MAX:
            raise InputError(f"nests more than {NESTING_MAX} objects or places more than {OBJECTS_MAX}")
        if any(key.endswith("}path") for key in item.attrib):
            raise InputError("has parts in further models of the archive")
        own = np.array(item.get("transform", "1 0 0 0 1 0 0 0 1 0 0 0").split(), float).reshape(4, 3)
        place = own @ outer[:3]
        place[3] += outer[3]
        found = objects[item.get("objectid")]
        for part in found.iter():
            if tag(part) == "mesh":
                yield part, place
            elif tag(part) == "component":
                waiting.append((part, place, depth + 1))
