"""Joints: data that lowers to rows of a few primitives. A new joint is one class in one of these files."""

from .conditions import ConstantVelocity, Distance, Parallel, Perpendicular, PointOnLine, PointOnPlane
from .curve_contact import CurveContact
from .joint import AxisJoint, Joint, PointJoint, coordinate_of
from .pairs import Cylindrical, Fixed, Planar, Prismatic, Revolute, Screw, Spherical, Universal
