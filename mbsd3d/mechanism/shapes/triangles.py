"""Triangles of solids: surfaces of revolution, blocks, and mesh files.

Vertices are shared across smooth edges only, so that `normals` shade a round side round and leave a rim sharp.
"""

import json
import logging
import stat
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...base.errors import InputError
from ...base.version import loading
from .threemf import read_3mf

STEP_SUFFIXES = (".step", ".stp")
"""Files of curved surfaces, which cascadio turns into triangles."""
MESH_SUFFIXES = (".stl", ".obj", ".ply", ".3mf", ".glb", ".gltf", *STEP_SUFFIXES)
STEP_ANGLE = 0.05  # [rad] between neighbouring triangles of a curved surface: a cylinder lacks some 1e-4 of its mass
STEP_SAG_RATIO = 0.01  # [1] of the length of an edge, from which triangles may be off; the angle is the tighter bound
MESH_TRIANGLES_MAX = 20_000  # [triangles] of a mesh file: more make pages that open slowly
MASS_TRIANGLES_MAX = 200_000  # [triangles] of a mesh that gives a mass: some seconds of checking
MESH_BYTES_MAX = 100_000_000  # [bytes] of a mesh file: a larger one is not read
STL_HEADER_BYTES, STL_TRIANGLE_BYTES = 84, 50  # [bytes] of a binary STL file
SHARP_EDGE_ANGLE = np.radians(30)  # [rad] edges of mesh files that bend by more stay sharp
SPHERE_SECTIONS, SPHERE_BANDS = 24, 12  # [1] about the axis and from pole to pole of a ball: 528 triangles
CYLINDER_SECTIONS = 48  # [1] multiples of 4, so that sectors end at edges


class Mesh(NamedTuple):
    """Triangles in body axes from the reference point O."""

    vertices: np.ndarray  # (k, 3) [m]
    faces: np.ndarray  # (m, 3) corners, counter-clockwise seen from outside
    shade: np.ndarray  # (m,) 0 or 1: faces with 1 are drawn darker, so that one sees a round body turn


def normals(mesh: Mesh) -> np.ndarray:
    """Return (k, 3) unit normals of the vertices: means over their faces, weighted with the angles there."""
    corners = mesh.vertices[mesh.faces]  # (m, 3, 3)
    following, previous = (np.roll(corners, shift, axis=1) - corners for shift in (-1, 1))
    across = np.cross(following, previous)
    area = np.linalg.norm(across, axis=2, keepdims=True)
    angle = np.arctan2(area[..., 0], np.sum(following * previous, axis=2))
    unit = np.divide(across, area, out=np.zeros_like(across), where=area > 0.0)
    found = np.zeros_like(mesh.vertices)
    np.add.at(found, mesh.faces, angle[..., None] * unit)
    length = np.linalg.norm(found, axis=1, keepdims=True)
    return np.divide(found, length, out=np.zeros_like(found), where=length > 0.0)


def moved(mesh: Mesh, R: np.ndarray, r: np.ndarray) -> Mesh:
    """Return the mesh turned by R (3, 3), its columns possibly of other lengths, and shifted by r [m]."""
    return mesh._replace(vertices=mesh.vertices @ R.T + r)


def joined(*meshes: Mesh) -> Mesh:
    """Join several meshes to one."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=True)]
    vertices, shade = ([mesh[k] for mesh in meshes] for k in (0, 2))
    return Mesh(np.concatenate(vertices), np.concatenate(faces), np.concatenate(shade))


def revolved(profile: np.ndarray, sections: int) -> Mesh:
    """Return what a smooth profile (k, 2) of radius and height [m] sweeps out about z; quarters alternate in shade.

    The outside lies to the right of the profile; a profile that ends where it starts is closed.
    """
    radius, height = np.asarray(profile, float).T
    turn = 2.0 * np.pi * np.arange(sections) / sections
    points = np.empty((radius.size, sections, 3))
    points[..., 0], points[..., 1] = np.outer(radius, np.cos(turn)), np.outer(radius, np.sin(turn))
    points[..., 2] = height[:, None]
    grid = np.arange(radius.size * sections).reshape(-1, sections)
    grid[radius == 0.0] = grid[radius == 0.0][:, :1]  # a ring on the axis is one point
    if np.array_equal(profile[0], profile[-1]):
        grid[-1] = grid[0]
    low, high = grid[:-1], grid[1:]
    low_next, high_next = np.roll(low, -1, axis=1), np.roll(high, -1, axis=1)
    faces = np.stack([low, low_next, high_next, low, high_next, high], axis=-1).reshape(-1, 3)
    shade = np.tile(np.repeat(4 * np.arange(sections) // sections % 2, 2), radius.size - 1)
    solid = np.array([len(set(face)) == 3 for face in faces.tolist()])
    used, faces = np.unique(faces[solid], return_inverse=True)
    return Mesh(points.reshape(-1, 3)[used], faces.reshape(-1, 3), shade[solid])


@cache
def ball() -> Mesh:
    """Return the unit ball; octants alternate in shade."""
    polar = np.linspace(0.0, np.pi, SPHERE_BANDS + 1)
    radius = np.where((polar > 0.0) & (polar < np.pi), np.sin(polar), 0.0)
    mesh = revolved(np.column_stack([radius, -np.cos(polar)]), SPHERE_SECTIONS)
    upper = mesh.vertices[mesh.faces, 2].sum(axis=1) > 0.0
    return mesh._replace(shade=(mesh.shade + upper) % 2)


@cache
def cylinder(sections: int = CYLINDER_SECTIONS) -> Mesh:
    """Return the cylinder of radius 1 and length 1 about z, with sharp rims."""
    profiles = [(0, -0.5), (1, -0.5)], [(1, -0.5), (1, 0.5)], [(1, 0.5), (0, 0.5)]
    return joined(*(revolved(np.array(profile, float), sections) for profile in profiles))


@cache
def block() -> Mesh:
    """Return the cube with edges 1; every side has its own corners."""
    vertices = np.empty((6, 4, 3))
    around = 0.5 * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    for axis in range(3):
        for side, corners in enumerate((around[::-1], around)):  # below seen from below, above from above
            vertices[2 * axis + side][:, [axis - 2, axis - 1]] = corners
            vertices[2 * axis + side][:, axis] = side - 0.5
    faces = np.arange(0, 24, 4)[:, None, None] + np.array([(0, 1, 2), (0, 2, 3)])
    return Mesh(vertices.reshape(-1, 3), faces.reshape(-1, 3), np.zeros(12, int))


def hull(points: np.ndarray) -> Mesh:
    """Return the convex hull of points (k, 3); every triangle has its own corners. QhullError if flat."""
    from scipy.spatial import ConvexHull  # a tenth of a second, for hulls alone

    found = ConvexHull(points)
    corners = points[found.simplices]  # (m, 3, 3)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inward = np.sum(across * found.equations[:, :3], axis=1) < 0.0
    corners[inward] = corners[inward][:, ::-1]
    count = len(corners)
    return Mesh(corners.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3), np.zeros(count, int))


def torus(radius: float, tube: float, sections: int = 36, around: int = 6) -> Mesh:
    """Return the ring about z: a circle of radius ``tube`` whose centre runs along one of ``radius`` [m]."""
    turn = 2.0 * np.pi * np.arange(around + 1) / around
    profile = np.column_stack([radius + tube * np.cos(turn), tube * np.sin(turn)])
    profile[-1] = profile[0]
    return revolved(profile, sections)


def capsule(radius: float, length: float) -> Mesh:
    """Return the cylinder about z with half balls on its ends, both beyond ``length`` [m]."""
    polar = np.linspace(0.0, 0.5 * np.pi, 5)
    end = radius * np.column_stack([np.where(polar > 0.0, np.sin(polar), 0.0), np.cos(polar)]) + (0.0, 0.5 * length)
    return revolved(np.concatenate([end * (1, -1), end[::-1]]), SPHERE_SECTIONS)


def read_mesh(path: str, what: str) -> Mesh:
    """Return the triangles of a file, with separate vertices at edges sharper than 30 degrees.

    ValueError for a file that is missing, too large, not a mesh, or has too many triangles, none, or some not finite.
    """
    found = check_mesh(path, what)
    import trimesh

    found.merge_vertices(merge_tex=True, merge_norm=True)
    smooth = trimesh.graph.smooth_shade(found, angle=SHARP_EDGE_ANGLE)
    faces = np.array(smooth.faces, int)
    return Mesh(np.array(smooth.vertices, float), faces, np.zeros(len(faces), int))


def check_mesh(path: str, what: str) -> Any:
    """Return the triangles of a file that can be drawn, as trimesh has them; see `read_mesh` for its errors."""
    found, _ = load_mesh(path, what)
    count = len(found.faces)
    if count > MESH_TRIANGLES_MAX:
        raise InputError(f"{what}: has {count} triangles, at most {MESH_TRIANGLES_MAX} are drawn; decimate it")
    return found


def binary_stl(content: bytes) -> np.ndarray | None:
    """Return corners (3 n, 3) of the triangles of a binary STL file, None for another file."""
    count = int.from_bytes(content[80:84], "little")
    if count == 0 or len(content) != STL_HEADER_BYTES + STL_TRIANGLE_BYTES * count:
        return None
    rows = np.frombuffer(
        content, np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("of", "<u2")]), count, STL_HEADER_BYTES
    )
    return rows["corners"].reshape(-1, 3).astype(float)


def check_gltf(content: bytes) -> None:
    """Refuse a glTF or GLB file whose accessors without data, which are filled with zeros, exceed the file."""
    binary = content[:4] == b"glTF"
    text = content[20 : 20 + int.from_bytes(content[12:16], "little")] if binary else content
    empty = [accessor for accessor in json.loads(text).get("accessors", ()) if "bufferView" not in accessor]
    if sum(int(accessor["count"]) for accessor in empty) > len(content):
        raise InputError("has accessors of more numbers than the file")


def triangulated(content: bytes, what: str) -> bytes:
    """Return the surfaces of a STEP file as GLB, in metres, by cascadio; nothing else is opened."""
    try:
        import cascadio
    except ImportError:
        raise InputError(
            f"{what}: STEP files hold curved surfaces, which need the package cascadio: pip install 'mbsd3d[step]'; or "
            "export a mesh, best as 3MF, which keeps its unit"
        ) from None
    fine = {"tol_linear": STEP_SAG_RATIO, "tol_relative": True, "tol_angular": STEP_ANGLE}
    found = cascadio.load(content, "step", use_parallel=False, **fine)
    if not found:
        raise InputError(f"{what}: holds no surfaces that OpenCASCADE can read; export it again, or a mesh as 3MF")
    return found


def load_mesh(path: str, what: str) -> tuple[Any, float | None]:
    """Return the triangles of a file as trimesh has them, checked, and its unit [m]; None where its format has none."""
    with loading():
        import trimesh

    file, kind = Path(path), Path(path).suffix.lower()[1:]
    try:
        state = file.stat()
        content = b"" if not stat.S_ISREG(state.st_mode) or state.st_size > MESH_BYTES_MAX else file.read_bytes()
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise InputError(f"{what}: cannot be read: {why}; give a file that exists") from error
    if not content:
        raise InputError(f"{what}: is not a file, is empty or has more than {MESH_BYTES_MAX} bytes; give a mesh")
    if f".{kind}" in STEP_SUFFIXES:
        content, kind = triangulated(content, what), "glb"
    options = {"skip_materials": True} if kind in ("obj", "glb", "gltf") else {}
    unit = 1.0 if kind in ("glb", "gltf") else None
    logging.getLogger("trimesh").disabled = True  # it prints tracebacks of what it can do without
    try:  # from memory, so that a mesh cannot name further files
        if kind in ("glb", "gltf"):
            check_gltf(content)
        corners = binary_stl(content) if kind == "stl" else None
        if corners is not None:
            found = trimesh.Trimesh(corners, np.arange(len(corners)).reshape(-1, 3), process=False)
        elif kind == "3mf":
            vertices, faces, unit = read_3mf(content, MASS_TRIANGLES_MAX)
            found = trimesh.Trimesh(vertices, faces, process=False)
        else:
            found = trimesh.load_mesh(BytesIO(content), file_type=kind, process=False, **options)
    except Exception as error:  # parsers of foreign data fail in their own ways
        remedy = "save the mesh again"
        if kind == "gltf":
            remedy = "save it as .glb, which needs no further files"
        raise InputError(f"{what}: is no {kind.upper()} ({' '.join(str(error).split())[:80]}); {remedy}") from error
    check_triangles(found, what)
    return found, unit


def check_triangles(found: Any, what: str) -> None:
    """Check the vertices and faces of a mesh of trimesh."""
    if len(getattr(found, "faces", ())) == 0:
        raise InputError(f"{what}: has no triangles; give a mesh of a surface")
    corners, faces = np.asarray(found.vertices), np.asarray(found.faces)
    if corners.ndim != 2 or corners.shape[1] != 3 or faces.ndim != 2 or faces.shape[1] != 3:
        raise InputError(f"{what}: has corners of {corners.shape[1:]} numbers; give triangles in space")
    if not np.isfinite(corners).all() or faces.min() < 0 or faces.max() >= len(corners):
        raise InputError(f"{what}: has corners that are not finite or not there; repair it")
