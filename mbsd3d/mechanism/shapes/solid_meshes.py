"""Mass, centre of mass and inertia of homogeneous solids that triangles enclose, and what such triangles may not be."""

import warnings
from pathlib import Path
from typing import Any

import numpy as np

from ...base.checks import number, short_repr
from ...base.errors import InputError
from ...base.mass_properties import MassProperties
from ...base.wording import counted
from .triangles import MASS_TRIANGLES_MAX, MESH_SUFFIXES, load_mesh

UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "in": 0.0254, "ft": 0.3048}  # [m]
CAD_SUFFIXES = (".iges", ".igs", ".brep", ".sldprt", ".ipt", ".catpart", ".f3d", ".fcstd")
PROBES = 400  # [points] in the box around a mesh, and as many beside its surface, where it is checked to be a solid
PROBE_OFFSET_SHARE = 1e-5  # [1] of the diagonal of a mesh, of a probe from the surface: thinner walls are rare
PROBE_PAIRS_MAX = 100_000  # [pairs] of points and triangles at a time: some 10 MB, which stay in the cache
VOLUME_ROUNDING = 1e-12  # [1] of the cube of the diagonal: a volume below it is that of flat triangles
UNIT_ROUNDING = 1e-12  # [1] by which a unit given may differ from that of the file
CALLER_FRAMES = 4  # [frames] from here to the user's call of Body.from_mesh


def metres_of(unit: Any, own: float | None, path: str, what: str) -> float:
    """Return the unit of a mesh file [m]: that of its format, else the one given."""
    names = ", ".join(f'"{name}"' for name in UNITS)
    given = None
    if isinstance(unit, str):
        if unit not in UNITS:
            raise InputError(f"{what}: unit {short_repr(unit)} is unknown; give one of {names}, or metres per unit")
        given = UNITS[unit]
    elif unit is not None:
        given = number(unit, f"{what}: unit", positive=True)
    if own is None:
        if given is None:
            kind = Path(path).suffix[1:].upper()
            raise InputError(f"{what}: {kind} files have no unit; give unit=, one of {names}, or metres per unit")
        return given
    if given is not None and abs(given - own) > UNIT_ROUNDING * own:
        raise InputError(f"{what}: unit is {given:g} m, but the file is in units of {own:g} m; leave unit out")
    return own


def solid_of(path: str, density: float, unit: Any, what: str, triangles_max: int) -> tuple[MassProperties, float]:
    """Return the mass properties of the homogeneous solid of a mesh file, in its axes, and its unit [m].

    ValueError, starting with ``what``, unless its triangles enclose a volume, each part of it once.
    """
    suffix = Path(path).suffix.lower()
    if suffix in CAD_SUFFIXES:
        raise InputError(
            f"{what}: {suffix[1:].upper()} files hold curved surfaces, which are not read; export a mesh, best as 3MF, "
            "which keeps its unit"
        )
    if suffix not in MESH_SUFFIXES:
        raise InputError(f"{what} is not a mesh; give one that ends in {', '.join(MESH_SUFFIXES)}")
    density = number(density, f"{what}: density", positive=True)
    found, own = load_mesh(path, what)
    metres = metres_of(unit, own, path, what)
    if len(found.faces) > triangles_max:
        remedy = "decimate it"
        if triangles_max < MASS_TRIANGLES_MAX:
            remedy += f', or do not draw it: shape="box", or None, allows {MASS_TRIANGLES_MAX}'
        raise InputError(f"{what}: has {len(found.faces)} triangles, more than {triangles_max}; {remedy}")
    vertices, faces = shared(np.asarray(found.vertices, float) * metres, np.asarray(found.faces))
    check_closed(faces, what)
    shift = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))  # far away plain sums would lose the inertia
    corners = (vertices - shift)[faces]
    diagonal = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    volume = float(six_volumes(corners).sum()) / 6.0
    if abs(volume) <= VOLUME_ROUNDING * diagonal**3:
        raise InputError(f"{what}: its triangles enclose no volume; give a solid")
    if volume < 0.0:
        corners = corners[:, ::-1]
        warnings.warn(f"{what}: is turned inside out; it is turned back", stacklevel=CALLER_FRAMES)
    check_winding(corners, diagonal, what)
    return integrated(corners, density, shift), metres


def shared(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices without repetitions, and faces that have three different ones."""
    vertices, place = np.unique(vertices + 0.0, axis=0, return_inverse=True)  # -0 becomes 0
    faces = place.reshape(-1)[faces]
    a, b, c = faces.T
    return vertices, faces[(a != b) & (b != c) & (c != a)]


def check_closed(faces: np.ndarray, what: str) -> None:
    """Refuse a surface with edges: each must be run through as often one way as the other by its triangles."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    way = np.where(edges[:, 0] < edges[:, 1], 1, -1)
    _, place, count = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True)
    excess = np.bincount(place.reshape(-1), weights=way, minlength=len(count))
    if odd := int(np.sum(count % 2 == 1)):
        raise InputError(f"{what}: is open, {odd} of its edges have an odd number of triangles; close its holes")
    if turned := int(np.sum(excess != 0)):
        raise InputError(
            f"{what}: is not turned one way, the triangles at {turned} of its edges disagree on its outside; "
            "unify its normals"
        )


def six_volumes(corners: np.ndarray) -> np.ndarray:
    """Return six times the signed volumes of the tetrahedra from the origin to triangles (m, 3, 3)."""
    a, b, c = corners.transpose(1, 0, 2)
    return np.einsum("ij,ij->i", a, np.cross(b, c))


def integrated(corners: np.ndarray, density: float, shift: np.ndarray) -> MassProperties:
    """Return the mass properties of the solid inside triangles (m, 3, 3) that stand off by ``shift``.

    Over a tetrahedron from the origin with D = a.(b x c) and s = a + b + c: ``int dV = D/6``, ``int x dV = D s/24``,
    ``int x x' dV = D (a a' + b b' + c c' + s s')/120``; exact for the polyhedron.
    """
    D, s = six_volumes(corners), corners.sum(axis=1)
    mass = density * D.sum() / 6.0
    com = density / mass * (D @ s) / 24.0
    second = np.einsum("i,ikj,ikl->jl", D, corners, corners) + np.einsum("i,ij,il->jl", D, s, s)
    spread = density / 120.0 * second - mass * np.outer(com, com)
    I = np.trace(spread) * np.eye(3) - spread
    return MassProperties(float(mass), com + shift, 0.5 * (I + I.T))


def check_winding(corners: np.ndarray, diagonal: float, what: str) -> None:
    """Refuse triangles that enclose some point twice or from behind: they would count its mass twice or negative."""
    random = np.random.default_rng(0)  # the same points for the same file
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    inside_box = low + (high - low) * random.random((PROBES, 3))
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(across, axis=1)
    chosen = random.choice(len(corners), PROBES // 2, p=area / area.sum())
    shares = random.dirichlet((1.0, 1.0, 1.0), PROBES // 2)
    at = np.einsum("ik,ikj->ij", shares, corners[chosen])
    away = PROBE_OFFSET_SHARE * diagonal * across[chosen] / area[chosen, None]
    numbers = winding_numbers(np.concatenate([inside_box, at + away, at - away]), corners)
    if numbers.max() > 1:
        raise InputError(
            f"{what}: overlaps itself, its triangles go {counted(int(numbers.max()), 'time')} round some point; "
            "unite its solids"
        )
    if numbers.min() < 0:
        raise InputError(f"{what}: has parts that are turned inside out; unify its normals")


def winding_numbers(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Return how often closed triangles (m, 3, 3) go round each point (k, 3): their solid angles over 4 pi.

    ``tan(angle/2) = a.(b x c) / (abc + (a.b) c + (b.c) a + (c.a) b)`` with the corners from the point.
    """
    found = np.empty(len(points), int)
    by_corner = np.ascontiguousarray(corners.transpose(1, 2, 0))  # (3 corners, 3 coordinates, m)
    step = max(1, PROBE_PAIRS_MAX // len(corners))
    for k in range(0, len(points), step):
        a, b, c = (corner[:, None] - points[k : k + step].T[..., None] for corner in by_corner)
        la, lb, lc = (np.sqrt(np.sum(x * x, axis=0)) for x in (a, b, c))
        ab, bc, ca = (np.sum(x * y, axis=0) for x, y in ((a, b), (b, c), (c, a)))
        volume = (
            a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
        )
        angles = 2.0 * np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb)
        found[k : k + step] = np.rint(angles.sum(axis=1) / (4.0 * np.pi))
    return found
