"""What bodies look like."""

from .mechanism.shapes.base import Shape as Shape
from .mechanism.shapes.base import Solid as Solid
from .mechanism.shapes.kinds import Box as Box
from .mechanism.shapes.kinds import Capsule as Capsule
from .mechanism.shapes.kinds import Cylinder as Cylinder
from .mechanism.shapes.kinds import Disc as Disc
from .mechanism.shapes.kinds import Ellipsoid as Ellipsoid
from .mechanism.shapes.kinds import Hull as Hull
from .mechanism.shapes.kinds import Lines as Lines
from .mechanism.shapes.kinds import MeshFile as MeshFile
from .mechanism.shapes.kinds import Sphere as Sphere
from .mechanism.shapes.kinds import Torus as Torus
from .mechanism.shapes.surfaces import Mesh as Mesh
