"""Quaternions and rotation matrices."""

from .base.quaternions import *
from .base.rotations import *
