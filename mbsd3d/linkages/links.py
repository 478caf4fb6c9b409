"""Bodies of a loop: as given, or round bars."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import as_tuple, short_repr, vector
from ..base.errors import InputError
from ..base.inertia import cylinder
from ..base.mass_properties import MassProperties
from ..base.rotations import as_quaternion, matrix
from ..mechanism.bodies import Body

Links = Sequence[MassProperties] | None
BAR_MASS = 1.0  # [kg] of a bar without a given mass


def base_frame(position: ArrayLike, orientation: ArrayLike, what: str) -> np.ndarray:
    """Return frame 0 in the world, shape (4, 4)."""
    base = np.eye(4)
    base[:3, :3] = matrix(as_quaternion(orientation, f"{what}: orientation"))
    base[:3, 3] = vector(position, f"{what}: position")
    return base


def bar(line: np.ndarray, radius: float) -> MassProperties:
    """Draw a round bar from the origin along a line (3,) [m], in the axes of the line."""
    length = float(np.linalg.norm(line))
    along = line / length if length > 0.0 else np.array([0.0, 0.0, 1.0])
    across, _, lengthwise = cylinder(BAR_MASS, radius, length)
    turned = across * np.eye(3) + (lengthwise - across) * np.outer(along, along)
    return MassProperties(BAR_MASS, 0.5 * line, turned)


def link_body(
    what: str, k: int, frame: np.ndarray, line: np.ndarray, axes: np.ndarray, radius: float, links: Links, count: int,
    name: str = "",
) -> Body:  # fmt: skip
    """Return link k at its frame (4, 4); `line` leads from its far to its near hinge, in the axes that `axes` turns
    from.
    """
    given = () if links is None else as_tuple(links, f"{what}: links", "a list of inertia.MassProperties")
    if not all(isinstance(link, MassProperties) for link in given):
        raise InputError(f"{what}: links {short_repr(links)}; give a list of inertia.MassProperties")
    if links is not None and len(given) != count:
        raise InputError(f"{what}: {len(given)} links given; it has {count} that move, the ground is the last one")
    own = bar(axes.T @ line, radius) if links is None else given[k - 1]
    return Body(name or f"link {k}", **vars(own), position=frame[:3, 3], orientation=frame[:3, :3])
