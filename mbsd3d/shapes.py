"""What bodies look like."""

from .mechanism.shapes.shape import Shape as Shape
from .mechanism.shapes.shape import Solid as Solid
from .mechanism.shapes.solids import Box as Box
from .mechanism.shapes.solids import Capsule as Capsule
from .mechanism.shapes.solids import Cylinder as Cylinder
from .mechanism.shapes.solids import Disc as Disc
from .mechanism.shapes.solids import Ellipsoid as Ellipsoid
from .mechanism.shapes.solids import Hull as Hull
from .mechanism.shapes.solids import Lines as Lines
from .mechanism.shapes.solids import MeshFile as MeshFile
from .mechanism.shapes.solids import Sphere as Sphere
from .mechanism.shapes.solids import Torus as Torus
from .mechanism.shapes.triangles import Mesh as Mesh
