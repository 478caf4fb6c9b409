"""Joints: data that lowers to rows of a few primitives. A new joint is one class in one of these files."""

from .joint import (
    AxisJoint as AxisJoint,
)
from .joint import (
    Joint as Joint,
)
from .joint import (
    PointJoint as PointJoint,
)
from .joint import (
    angle_of as angle_of,
)
from .joint import (
    coordinate_of as coordinate_of,
)
from .joint import (
    slide_of as slide_of,
)
