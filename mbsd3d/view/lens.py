"""The camera of the pictures: world points to the plane of the paper in perspective, and the window that shows all."""

from typing import NamedTuple

import numpy as np

from .drawing import Camera

NEAR = 0.02  # of the camera's distance: what is nearer to the eye is drawn as if it were there
AIR = 0.06  # of the window, on every side


class Lens(NamedTuple):
    """An eye, and the directions right, up and forward as rows."""

    eye: np.ndarray  # (3,) world [m]
    axes: np.ndarray  # (3, 3) unit vectors, world
    distance: float  # to the point one looks at [m]

    def project(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """World points (..., 3) as (..., 2) on a paper at distance 1 from the eye, and their depths (...) [m].

        With d = p - eye: depth = d . forward, x = d . right / depth, y = d . up / depth.
        """
        seen = (points - self.eye) @ self.axes.T
        depth = seen[..., 2]
        return seen[..., :2] / np.maximum(depth, NEAR * self.distance)[..., None], depth


def lens_of(camera: Camera) -> Lens:
    """The lens of a camera that stands upright: z of the world is up on the paper.

    Parameters
    ----------
    camera : Camera
        Not straight above or below what it looks at.

    Returns
    -------
    Lens
        Rows of ``axes``: right, up, forward.
    """
    forward = np.asarray(camera.look_at, float) - camera.position
    distance = float(np.linalg.norm(forward))
    forward = forward / distance
    right = np.cross(forward, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    return Lens(np.asarray(camera.position, float), np.array([right, np.cross(right, forward), forward]), distance)


def turned(camera: Camera, azimuth: float, elevation: float) -> Camera:
    """The same camera moved about the point it looks at.

    Parameters
    ----------
    camera : Camera
        Its distance stays.
    azimuth, elevation : float
        Of the eye as seen from that point [degrees]; from the world's x axis about z, and above the horizon.

    Returns
    -------
    Camera
        The new one.
    """
    turn, rise = np.radians(azimuth), np.radians(elevation)
    towards = np.array([np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)])
    return camera._replace(position=camera.look_at + camera.distance * towards)


def window(points: np.ndarray, shape: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """The part of the paper that holds all points, with air, in the ratio of a picture.

    Parameters
    ----------
    points : (k, 2) ndarray
        Projected points.
    shape : (float, float)
        Width and height of the picture, any unit.

    Returns
    -------
    (2,) ndarray, (2,) ndarray
        Lower left and upper right corner.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    width, height = shape
    unit = max((high - low) / (width, height)) / (1.0 - 2.0 * AIR) or 1e-3
    half = 0.5 * unit * np.array([width, height])
    middle = 0.5 * (low + high)
    return middle - half, middle + half


def round_cell(length: float) -> float:
    """The largest of 1, 2, 5 times a power of ten [m] that is not above ``length``."""
    power = 10.0 ** np.floor(np.log10(length))
    return float(next(f * power for f in (5.0, 2.0, 1.0) if f * power <= length * (1.0 + 1e-9)))
