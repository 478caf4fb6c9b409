"""Quaternions and rotation matrices."""

from .base.rotations import H as H
from .base.rotations import as_quaternion as as_quaternion
from .base.rotations import conjugate as conjugate
from .base.rotations import exponential as exponential
from .base.rotations import logarithm as logarithm
from .base.rotations import matrix as matrix
from .base.rotations import multiply as multiply
from .base.rotations import normalize as normalize
from .base.rotations import quaternion_from_matrix as quaternion_from_matrix
from .base.rotations import rotation as rotation
from .base.rotations import skew as skew
