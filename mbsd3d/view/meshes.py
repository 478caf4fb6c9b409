"""Triangles as a scene wants them: corners split at sharp edges, arrows of length 1, tinted colours."""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

SHARP = 0.6  # angle between two faces [rad] from which on their edge is drawn as one
SECTIONS = 12


def creased(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same triangles, in order, such that only faces which meet smoothly share corners.

    Scenes average the normals of the faces at a corner: a box would look like a ball.
    """
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1).astype(np.int64)
    key = edges[:, 0] * len(vertices) + edges[:, 1]
    order = np.argsort(key, kind="stable")
    same = key[order][1:] == key[order][:-1]
    a, b = order[:-1][same] // 3, order[1:][same] // 3
    smooth = (normals[a] * normals[b]).sum(axis=1) > np.cos(SHARP)
    a, b = a[smooth], b[smooth]
    patch = connected_components(coo_matrix((np.ones(a.size), (a, b)), shape=(len(faces),) * 2), directed=False)[1]
    split = faces.ravel().astype(np.int64) * (int(patch.max(initial=0)) + 1) + np.repeat(patch, 3)
    _, first, new = np.unique(split, return_index=True, return_inverse=True)
    return vertices[faces.ravel()[first]], new.reshape(-1, 3)


def alone(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The given faces with those vertices only that they use."""
    low = int(faces.min())
    used = np.zeros(int(faces.max()) - low + 1, bool)
    used[faces - low] = True
    return vertices[low : low + used.size][used], (np.cumsum(used) - 1)[faces - low]


def arrow(heads: int) -> tuple[np.ndarray, np.ndarray]:
    """An arrow from the origin to (0, 0, 1) with one head or two, one behind the other."""
    shaft, head, long = 0.018, 0.055, 0.17
    profile = [(0.0, 0.0), (shaft, 0.0), (shaft, 1.0 - heads * long)]
    for k in range(heads, 0, -1):
        profile += [(head, 1.0 - k * long), (shaft if k > 1 else 0.0, 1.0 - (k - 1) * long)]
    return revolved(profile)


def revolved(profile: list[tuple[float, float]]) -> tuple[np.ndarray, np.ndarray]:
    """(radius, height) turned about z, bottom to top; sharp edges are split."""
    import trimesh

    mesh = trimesh.creation.revolve(np.array(profile), sections=SECTIONS)
    return creased(np.asarray(mesh.vertices), np.asarray(mesh.faces))


def tint(colour: str, shade: int = 0, *, pale: bool = False) -> tuple[int, int, int]:
    """RGB of "#rrggbb"; darker for shade 1, half way to grey if pale."""
    rgb = np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)], float)
    rgb = rgb * 0.72 if shade else rgb
    rgb = 0.45 * rgb + 0.55 * 190.0 if pale else rgb
    return tuple(int(x) for x in np.rint(rgb))


def linear(colours: np.ndarray) -> np.ndarray:
    """RGB 0 ... 255 without the display's curve: viser takes colours of copies as they are."""
    x = np.asarray(colours) / 255.0
    return np.rint(255.0 * np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)).astype(np.uint8)
