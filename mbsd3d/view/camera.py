"""From where a mechanism is seen."""

from typing import NamedTuple

import numpy as np

AIR = 1.12  # of the picture around the box
AZIMUTH, HEIGHT = np.radians((-58.0, 22.0))  # of the camera, seen from the middle
VIEW = np.array([  # towards the camera, right, up
    (np.cos(HEIGHT) * np.cos(AZIMUTH), np.cos(HEIGHT) * np.sin(AZIMUTH), np.sin(HEIGHT)),
    (-np.sin(AZIMUTH), np.cos(AZIMUTH), 0.0),
    (-np.sin(HEIGHT) * np.cos(AZIMUTH), -np.sin(HEIGHT) * np.sin(AZIMUTH), np.cos(HEIGHT)),
])  # fmt: skip


class Camera(NamedTuple):
    """Where one looks from, world [m]; z is up."""

    position: np.ndarray
    look_at: np.ndarray
    distance: float


def frame_camera(low: np.ndarray, high: np.ndarray, fov: float = 0.7) -> Camera:
    """A camera that sees the whole box at an oblique angle, with a little air, in a picture at least as wide as high.

    A corner at w from the middle is seen if its distances across the view are below (d - w . u) tan(fov / 2), with u
    towards the camera and d the distance.

    Parameters
    ----------
    low, high : (3,) ndarray
        Corners of the box, world [m]; it may be flat, or a point (then it is taken as 1 m wide).
    fov : float
        Vertical angle of view [rad].

    Returns
    -------
    Camera
        Looking at the middle of the box.
    """
    low, high = np.asarray(low, float), np.asarray(high, float)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    half = half if half.any() else np.full(3, 0.5)
    towards, right, up = VIEW
    w = half * np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    across = AIR * np.abs(w @ np.column_stack([right, up])).max(axis=1)
    distance = float((w @ towards + across / np.tan(0.5 * fov)).max())
    return Camera(middle + distance * towards, middle, distance)
