"""Quaternions and rotation matrices."""

from .base.quaternions import H as H
from .base.quaternions import conjugate as conjugate
from .base.quaternions import exponential as exponential
from .base.quaternions import logarithm as logarithm
from .base.quaternions import multiply as multiply
from .base.quaternions import skew as skew
from .base.rotations import as_quaternion as as_quaternion
from .base.rotations import matrix as matrix
from .base.rotations import quaternion_from_matrix as quaternion_from_matrix
from .base.rotations import rotation as rotation
