"""A glTF 2.0 asset under construction: arrays, materials, meshes, nodes and an animation, then the .glb file.

Equal arrays, materials and meshes are stored once. The binary chunk has three parts, each with one buffer view:
vertices, indices and the arrays of the animation.
"""

from collections.abc import Callable, Hashable, Mapping

import numpy as np

from ...base.errors import InputError
from ...base.style import channels, linear
from ...base.version import loading
from ...mechanism.shapes import Mesh
from ..scene.meshes import Skin, skin

try:
    with loading():
        import pygltflib
except ImportError:
    pygltflib = None

GLTF_FLOAT, GLTF_SHORT, GLTF_INT = 5126, 5123, 5125
COMPONENTS = {"<f4": GLTF_FLOAT, "<u2": GLTF_SHORT, "<u4": GLTF_INT}
TYPES = {(): "SCALAR", (3,): "VEC3", (4,): "VEC4"}
VIEWS: dict[str, dict[str, int]] = {
    "vertices": {"byteStride": 12, "target": 34962},
    "indices": {"target": 34963},
    "animation": {},
}
LINES, LINE_STRIP, TRIANGLES = 1, 3, 4
ROUGHNESS, METALLIC = 0.6, 0.1
Primitive = tuple[int, int, int, int | None, int | None]  # mode, material, accessors: points, normals, corners
STRIP_RESTART_INDEX = 0xFFFF  # the one index of 16 bits that glTF reserves


def short(values: np.ndarray) -> list[float]:
    """Return numbers rounded to single precision."""
    return [float(str(x)) for x in np.asarray(values, np.float32)]


class Asset:
    """Buffers, accessors and nodes of a glTF file under construction."""

    def __init__(self, about: Mapping[str, str | float], generator: str) -> None:
        if pygltflib is None:
            raise InputError("export_glb needs pygltflib, which mbsd3d comes with; install it: pip install pygltflib")
        self.gltf = pygltflib.GLTF2(scene=0, scenes=[pygltflib.Scene()])
        self.gltf.asset = pygltflib.Asset(generator=generator, extras=dict(about))
        self.animation = pygltflib.Animation(name="motion")
        self.chunks: dict[str, bytearray] = {}
        self.known: dict[Hashable, int] = {}
        self.skins: dict[Hashable, Skin] = {}

    def once(self, key: Hashable, kind: str, make: Callable[[], object]) -> int:
        """Return the place of an object in the list ``kind``; make it if the key is new."""
        things = getattr(self.gltf, kind)
        if (kind, key) not in self.known:
            self.known[kind, key] = len(things)
            things.append(make())
        return self.known[kind, key]

    def array(self, values: np.ndarray, view: str, bounds: bool = False) -> int:
        """Return the accessor of an array, with its lowest and highest values where glTF wants them."""
        values = np.ascontiguousarray(values)

        def make() -> object:
            chunk = self.chunks.setdefault(view, bytearray())
            chunk += bytes(-len(chunk) % 4)
            offset = len(chunk)
            chunk.extend(values.tobytes())
            low, high = (np.atleast_1d(f(values, axis=0)).tolist() if bounds else None for f in (np.min, np.max))
            return pygltflib.Accessor(
                bufferView=list(self.chunks).index(view), byteOffset=offset, componentType=COMPONENTS[values.dtype.str],
                normalized=None, count=len(values), type=TYPES[values.shape[1:]], min=low, max=high,
            )  # fmt: skip

        return self.once((view, bounds, values.dtype.str, values.shape, values.tobytes()), "accessors", make)

    def skin(self, mesh: Mesh) -> Skin:
        """Add a mesh with normals."""
        key = (np.asarray(mesh.vertices, "<f4").tobytes(), mesh.faces.tobytes(), mesh.shade.tobytes())
        if key not in self.skins:
            self.skins[key] = skin(mesh)
        return self.skins[key]

    def material(self, colour: str, brightness: float = 1.0, double_sided: bool = False) -> int:
        """Add a matt paint."""
        factor = [*linear(brightness * channels(colour) / 255.0).round(6).tolist(), 1.0]

        def make() -> object:
            paint = pygltflib.PbrMetallicRoughness(
                baseColorFactor=factor, metallicFactor=METALLIC, roughnessFactor=ROUGHNESS
            )
            name = f"{colour}{' dark' if brightness < 1.0 else ''}{' open' if double_sided else ''}"
            return pygltflib.Material(pbrMetallicRoughness=paint, doubleSided=double_sided, name=name)

        return self.once((tuple(factor), double_sided), "materials", make)

    def primitive(
        self,
        mode: int,
        material: int,
        points: np.ndarray,
        normals: np.ndarray | None = None,
        corners: np.ndarray | None = None,
    ) -> Primitive:
        """Add triangles or lines of a mesh."""
        kind = np.dtype("<u2" if len(points) <= STRIP_RESTART_INDEX else "<u4")
        ends = None if corners is None else self.array(np.asarray(corners, kind).ravel(), "indices")
        across = None if normals is None else self.array(np.asarray(normals, "<f4"), "vertices")
        return mode, material, self.array(np.asarray(points, "<f4"), "vertices", bounds=True), across, ends

    def mesh(self, name: str, primitives: list[Primitive]) -> int:
        """Add a mesh of primitives; one with the same primitives keeps the name of the first."""

        def make() -> object:
            parts = [
                pygltflib.Primitive(
                    attributes=pygltflib.Attributes(POSITION=points, NORMAL=normals),
                    indices=corners, mode=mode, material=material,
                )
                for mode, material, points, normals, corners in primitives
            ]  # fmt: skip
            return pygltflib.Mesh(name=name, primitives=parts)

        return self.once(tuple(primitives), "meshes", make)

    def node(
        self, name: str, place: Mapping[str, np.ndarray], parent: int | None = None, mesh: int | None = None
    ) -> int:
        """Add a node below its parent.

        ``place`` is translation (3,), rotation (x, y, z, w) and scale (3,) at the start.
        """
        index, nodes = len(self.gltf.nodes), self.gltf.nodes
        nodes.append(pygltflib.Node(name=name, mesh=mesh, **{key: short(value) for key, value in place.items()}))
        (self.gltf.scenes[0].nodes if parent is None else nodes[parent].children).append(index)
        return index

    def moving(
        self, name: str, places: Mapping[str, np.ndarray], parent: int, t: np.ndarray, mesh: int | None = None
    ) -> int:
        """Add a node with places (frames, 3 or 4) at times (frames,) [s]; what does not move gets no channel."""
        node = self.node(name, {key: values[0] for key, values in places.items()}, parent, mesh)
        for path, places_of in places.items():
            values = np.asarray(places_of, "<f4")
            if (values == values[0]).all():
                continue
            clock = self.array(np.asarray(t, "<f4"), "animation", bounds=True)
            sampler = pygltflib.AnimationSampler(input=clock, output=self.array(values, "animation"))
            target = pygltflib.AnimationChannelTarget(node=node, path=path)
            self.animation.channels.append(
                pygltflib.AnimationChannel(sampler=len(self.animation.samplers), target=target)
            )
            self.animation.samplers.append(sampler)
        return node

    def glb(self) -> bytes:
        """Return the bytes of the .glb file."""
        chunk = bytearray()
        for name, content in self.chunks.items():
            chunk += bytes(-len(chunk) % 4)
            view = pygltflib.BufferView(buffer=0, byteOffset=len(chunk), byteLength=len(content), **VIEWS[name])
            self.gltf.bufferViews.append(view)
            chunk += content
        self.gltf.animations = [self.animation] if self.animation.channels else []
        self.gltf.buffers = [pygltflib.Buffer(byteLength=len(chunk))]
        self.gltf.set_binary_blob(bytes(chunk))
        return b"".join(self.gltf.save_to_bytes())
