"""Quaternions and rotation matrices."""

from .base.rotations import *
