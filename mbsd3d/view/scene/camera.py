"""Camera: position of the eye, what it follows, perspective, and round lengths for the ground grid."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...base.checks import number, short_repr
from ...base.errors import InputError
from ...mechanism.bodies import GROUND, Body, Ground
from ...mechanism.mechanism import Mechanism
from ...results.motion import Motion
from .glyphs import Spanning

FRAMING_FACTOR = 1.12  # [1] of the box that is seen: margin around it
NEAR_PLANE_SHARE = 0.02  # [camera distances] from the eye within which nothing is drawn
VIEW_TANGENT_MAX = 2.0  # [1] tangent of the angle from the middle of the view up to which a path is seen well
FOLLOW_CAMERA_TRAVEL = 20.0  # [sizes of the mechanism] it travels by before the camera follows by itself
FOLLOW_HEIGHT_FACTOR = 1.4  # [1] of the height of a mechanism that the camera follows; it may rise and tip over
WINDOW_MARGIN = 0.06  # [1] of a window, on every side
CAMERA_AZIMUTH, CAMERA_ELEVATION = np.radians((-58.0, 22.0))  # [rad] of the camera, seen from the middle

COS_AZIMUTH, COS_ELEVATION = np.cos((CAMERA_AZIMUTH, CAMERA_ELEVATION))
SIN_AZIMUTH, SIN_ELEVATION = np.sin((CAMERA_AZIMUTH, CAMERA_ELEVATION))
VIEW_AXES = np.array([  # towards the camera, right, up
    (COS_ELEVATION * COS_AZIMUTH, COS_ELEVATION * SIN_AZIMUTH, SIN_ELEVATION),
    (-SIN_AZIMUTH, COS_AZIMUTH, 0.0),
    (-SIN_ELEVATION * COS_AZIMUTH, -SIN_ELEVATION * SIN_AZIMUTH, COS_ELEVATION),
])  # fmt: skip
ROUND_NUMBERS = np.array([1.0, 2.0, 5.0, 10.0])


class Camera(NamedTuple):
    """Eye and target, world [m]; z is up."""

    position: np.ndarray
    look_at: np.ndarray
    distance: float


def frame_camera(low: np.ndarray, high: np.ndarray, fov: float = 0.7) -> Camera:
    """Return a camera that sees the whole box at an oblique angle, in a picture at least as wide as high.

    A corner at w from the middle is seen if its distances across the view are below (d - w . u) tan(fov / 2), with u
    towards the camera, d the distance and fov the vertical angle of view [rad]. A point is taken as a box of 1 m.
    """
    low, high = np.asarray(low, float), np.asarray(high, float)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    half = half if half.any() else np.full(3, 0.5)
    towards, right, up = VIEW_AXES
    w = half * np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    across = FRAMING_FACTOR * np.abs(w @ np.column_stack([right, up])).max(axis=1)
    distance = float((w @ towards + across / np.tan(0.5 * fov)).max())
    return Camera(middle + distance * towards, middle, distance)


class Sight(NamedTuple):
    """Box along the directions of a view: its middle, world [m], and its extent in camera distances [m].

    A window of width over height ``a`` shows the whole box from ``depth + max(across / a, up)``.
    """

    axes: np.ndarray  # (3, 3) towards the camera, right, up: rows, world
    middle: np.ndarray
    depth: float
    across: float
    up: float

    def camera(self, aspect: float = 1.0) -> Camera:
        """Return the camera that sees the box in a window of this width over its height."""
        distance = self.depth + max(self.across / aspect, self.up)
        return Camera(self.middle + distance * self.axes[0], self.middle, distance)


def sight(low: np.ndarray, high: np.ndarray, axes: np.ndarray, fov: float, *, turns: bool = False) -> Sight:
    """Return how a box is seen whose corners are given along ``axes`` [m], with a margin.

    Its nearer face, h tan(fov / 2) / (d - depth) of the window high, is what limits the distance d. What ``turns``
    about the vertical is as wide as it is deep, and higher when it tips over. A point is taken as a box of 1 m.
    """
    middle, half = axes.T @ (0.5 * (low + high)), 0.5 * (high - low)
    half = half if half.any() else np.full(3, 0.5)
    depth, right, up = turning(half) if turns else half
    per_metre = FRAMING_FACTOR / np.tan(0.5 * fov)
    return Sight(axes, middle, float(depth), float(per_metre * right), float(per_metre * up))


def turning(half: np.ndarray) -> np.ndarray:
    """Return half a box along a view (3,) that still holds its content when this turns about the vertical and tips."""
    return np.array([*np.full(2, half[:2].max()), FOLLOW_HEIGHT_FACTOR * half[2]])


def turning_box(low: np.ndarray, high: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Return the corners (8, 3) of the box for what turns, world [m]; the lowest and highest are along ``axes``."""
    middle, half = 0.5 * (low + high), turning(0.5 * (high - low))
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    return np.asarray((middle + signs * half) @ axes)


def directions(view: Sequence[float] | None) -> np.ndarray:
    """Return (3, 3) towards the camera, right and up at an azimuth and an elevation [degrees]; None = the default."""
    if view is None:
        return VIEW_AXES
    azimuth, elevation = np.radians(checked_view(view))
    (c, s), (cz, sz) = (np.cos(azimuth), np.sin(azimuth)), (np.cos(elevation), np.sin(elevation))
    return np.array([(cz * c, cz * s, sz), (-s, c, 0.0), (-sz * c, -sz * s, cz)])


def stood_back(camera: Camera, points: np.ndarray) -> Camera:
    """Return the camera moved back until points (k, 3), world [m], are before it and not distorted.

    With w from the point one looks at and u towards the camera this is ``|w - (w . u) u| <= ASIDE (d - w . u)``.
    """
    towards = (camera.position - camera.look_at) / camera.distance
    w = points - camera.look_at
    along = w @ towards
    aside = np.linalg.norm(w - along[:, None] * towards, axis=1)
    distance = float((along + aside / VIEW_TANGENT_MAX).max(initial=camera.distance))
    return camera._replace(position=camera.look_at + distance * towards, distance=distance)


def turned(camera: Camera, azimuth: float, elevation: float) -> Camera:
    """Return the camera turned about its target: azimuth from x about z, elevation above the horizon [degrees]."""
    towards = directions((azimuth, elevation))[0]
    return camera._replace(position=camera.look_at + camera.distance * towards)


def seen_from(camera: Camera, view: Sequence[float] | None) -> Camera:
    """Return the camera at an azimuth and an elevation [degrees]; None = as it is. ValueError for anything else."""
    return camera if view is None else turned(camera, *checked_view(view))


def checked_view(view: Sequence[float]) -> tuple[float, float]:
    """Return azimuth and elevation [degrees] of a camera that stands upright."""
    azimuth, elevation = pair(view, "view")
    if not -89.0 <= elevation <= 89.0:
        raise InputError(f"view: elevation = {elevation:g}; give -89 ... 89 degrees")
    return azimuth, elevation


def pair(value: Sequence[float], what: str) -> tuple[float, float]:
    """Return two numbers."""
    if np.shape(value) != (2,):
        raise InputError(f"{what}: {short_repr(value)} is not a pair; give two numbers")
    return number(value[0], what), number(value[1], what)


def followed_body(motion: Motion, follow: Body | Ground | str | None, live: bool = False) -> int:
    """Return the number of the body that the camera follows, or -1; None = the heaviest of those that travel.

    In a system that a spring or rod ties to the ground none does: a picture that leaves the ground loses that part.
    """
    system = motion.system
    if isinstance(follow, Ground) or follow == GROUND.name or (follow is None and live):
        return -1
    if follow is None:
        parts = (*system.joints, *system.forces)
        if any(isinstance(part, Spanning) and (part.a is GROUND or part.b is GROUND) for part in parts):
            return -1
        heaviest = max(range(len(system.bodies)), key=lambda i: system.bodies[i].mass)
        joined = (point for joint in system.joints for row in joint.primitives for point in row.points)
        start = np.array([*(body.centre for body in system.bodies), *joined])
        size = max(motion.compiled.model.length, float(np.ptp(start, axis=0).max()))
        way = float(np.ptp(motion.com(system.bodies[heaviest]), axis=0).max(initial=0.0)) if motion.t.size else 0.0
        return heaviest if way > FOLLOW_CAMERA_TRAVEL * size else -1
    if live:
        raise InputError(f"follow = {follow!r}: the camera of a live view does not go along; leave follow out")
    return number_of(system, follow)


def number_of(system: Mechanism, body: Body | str) -> int:
    """Return the place of a body, given as such or by name, among the bodies."""
    found = system.part(body)
    return next(i for i, other in enumerate(system.bodies) if other is found)


class Lens(NamedTuple):
    """Eye, and the directions right, up and forward as rows."""

    eye: np.ndarray  # (3,) world [m]
    axes: np.ndarray  # (3, 3) unit vectors, world
    distance: float  # to the point one looks at [m]

    def project(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return world points (..., 3) as (..., 2) on a paper at distance 1 from the eye, and their depths (...) [m].

        With d = p - eye: depth = d . forward, x = d . right / depth, y = d . up / depth.
        """
        seen = (points - self.eye) @ self.axes.T
        depth = seen[..., 2]
        return seen[..., :2] / np.maximum(depth, NEAR_PLANE_SHARE * self.distance)[..., None], depth

    def before(self, polygons: np.ndarray) -> np.ndarray:
        """Return for polygons (..., k, 3), world, whether all of their corners are before the eye."""
        return np.asarray((self.project(polygons)[1] > NEAR_PLANE_SHARE * self.distance).all(axis=-1))


def lens_of(camera: Camera) -> Lens:
    """Return the lens of an upright camera, which looks neither straight up nor straight down."""
    forward = np.asarray(camera.look_at, float) - camera.position
    distance = float(np.linalg.norm(forward))
    forward = forward / distance
    right = np.cross(forward, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    return Lens(np.asarray(camera.position, float), np.array([right, np.cross(right, forward), forward]), distance)


def window(points: np.ndarray, shape: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Return lower left and upper right corner of the part of the paper that holds all projected points (k, 2).

    ``shape`` is the width and height of the picture in any unit.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    unit = max((high - low) / shape) / (1.0 - 2.0 * WINDOW_MARGIN) or 1e-3
    half, middle = 0.5 * unit * np.array(shape), 0.5 * (low + high)
    return middle - half, middle + half


def round_up(length: float) -> float:
    """Return 1, 2 or 5 times a power of ten, not below ``length``."""
    steps = ROUND_NUMBERS * 10.0 ** np.floor(np.log10(length))
    return float(f"{steps[steps >= length][0]:.1g}")


def round_down(length: float) -> float:
    """Return 1, 2 or 5 times a power of ten, not above ``length``."""
    steps = ROUND_NUMBERS * 10.0 ** np.floor(np.log10(length))
    return float(f"{steps[steps <= length * (1.0 + 1e-9)][-1]:.1g}")


def length_text(length: float) -> str:
    """Return a length as text, in a unit in which it is a usual number."""
    unit, factor = ("mm", 1e3) if length < 0.01 else ("km", 1e-3) if length >= 1000.0 else ("m", 1.0)
    return f"{length * factor:g} {unit}"
