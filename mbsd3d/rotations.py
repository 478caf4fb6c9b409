"""Quaternions and rotation matrices."""

from .base.quaternions import H, conjugate, exponential, logarithm, multiply, skew
from .base.rotations import as_quaternion, matrix, quaternion_from_matrix, rotation

__all__ = [
    "H", "as_quaternion", "conjugate", "exponential", "logarithm", "matrix", "multiply", "quaternion_from_matrix",
    "rotation", "skew",
]  # fmt: skip
