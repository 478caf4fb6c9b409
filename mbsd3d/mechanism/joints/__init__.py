"""Joints: data that lowers to rows of a few primitives. A new joint is one class in one of these files."""

from .joint import AxisJoint, Joint, PointJoint, coordinate_of
