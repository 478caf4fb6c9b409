"""glTF files, read back without the code that wrote them: the container, the numbers, and where every body is."""

import json
import struct

import numpy as np
import pytest
import trimesh
from helpers.double_pendulum import LOWER_ARM, UPPER_ARM, WHEEL, pendulum
from helpers.models import pair_at

from mbsd3d import (
    GROUND,
    Body,
    Distance,
    Spherical,
    System,
    Universal,
    accelerations,
    linearize,
    rotation,
    shapes,
    simulate,
)
from mbsd3d.base.style import channels, linear
from mbsd3d.shapes import Mesh
from mbsd3d.view.scene.meshes import rolled, skin, unit_coil, unit_rod

COMPONENT = {5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTH = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}
SINGLE = 2.0**-23  # resolution of a number in the file


class File:
    """A .glb file taken apart after the specification (version 2.0, sections 3 and 4)."""

    def __init__(self, path):
        content = path.read_bytes()
        magic, version, length = struct.unpack_from("<4sII", content)
        assert (magic, version, length) == (b"glTF", 2, len(content)) and length % 4 == 0
        size, kind = struct.unpack_from("<I4s", content, 12)
        assert kind == b"JSON" and size % 4 == 0
        self.document = json.loads(content[20 : 20 + size])
        binary, kind = struct.unpack_from("<I4s", content, 20 + size)
        assert kind == b"BIN\0" and 28 + size + binary == length
        self.chunk = content[28 + size :]
        assert 0 <= len(self.chunk) - self.document["buffers"][0]["byteLength"] < 4
        self.nodes, self.names = self.document["nodes"], [node["name"] for node in self.document["nodes"]]
        self.parent = {child: i for i, node in enumerate(self.nodes) for child in node.get("children", ())}

    def array(self, index):
        accessor = self.document["accessors"][index]
        view = self.document["bufferViews"][accessor["bufferView"]]
        kind, width = np.dtype(COMPONENT[accessor["componentType"]]), WIDTH[accessor["type"]]
        offset, count = accessor.get("byteOffset", 0), accessor["count"] * width
        assert offset % 4 == 0 and view.get("byteOffset", 0) % 4 == 0 and count > 0
        assert offset + count * kind.itemsize <= view["byteLength"]
        assert view["byteOffset"] + view["byteLength"] <= len(self.chunk)
        assert view.get("byteStride", width * kind.itemsize) == width * kind.itemsize
        values = np.frombuffer(self.chunk, kind, count, view["byteOffset"] + offset)
        return values.reshape(-1, width)

    def channels(self, name, path):
        """Times and values of a node's animation."""
        for animation in self.document.get("animations", ()):
            for channel in animation["channels"]:
                if channel["target"] == {"node": self.names.index(name), "path": path}:
                    sampler = animation["samplers"][channel["sampler"]]
                    assert sampler["interpolation"] == "LINEAR"
                    return self.array(sampler["input"])[:, 0], self.array(sampler["output"])
        return None

    def local(self, name, frame):
        """(4, 4) of a node at a frame."""
        node, scale = self.nodes[self.names.index(name)], {"translation": [0] * 3, "rotation": [0, 0, 0, 1]}
        values = {**scale, "scale": [1, 1, 1], **node}
        values.update(
            {path: x[1][frame] for path in ("translation", "rotation", "scale") if (x := self.channels(name, path))}
        )
        x, y, z, w = np.asarray(values["rotation"], float)
        R = np.eye(3) + 2.0 * (w * cross(x, y, z) + cross(x, y, z) @ cross(x, y, z))
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = R * np.asarray(values["scale"], float), values["translation"]
        return T

    def world(self, name, point, frame=0):
        """World position, y up, of a point of a node."""
        x = np.append(point, 1.0)
        while name is not None:
            x = self.local(name, frame) @ x
            name = self.names[self.parent[i]] if (i := self.names.index(name)) in self.parent else None
        return x[:3]

    def check(self):
        """What the specification asks of the whole, of accessors, meshes and animations."""
        self.check_whole()
        for i, accessor in enumerate(self.document["accessors"]):
            values = self.array(i)
            assert np.isfinite(values).all()
            for key, function in (("min", np.min), ("max", np.max)):
                assert key not in accessor or accessor[key] == function(values, axis=0).tolist()
        for mesh in self.document["meshes"]:
            for part in mesh["primitives"]:
                self.check_primitive(part)
        for animation in self.document.get("animations", ()):
            assert len({sampler["input"] for sampler in animation["samplers"]}) == 1  # one clock
            for channel in animation["channels"]:
                sampler = animation["samplers"][channel["sampler"]]
                times, values = self.array(sampler["input"])[:, 0], self.array(sampler["output"])
                assert "min" in self.document["accessors"][sampler["input"]]
                assert times[0] == 0.0 and (np.diff(times) > 0).all() and len(times) == len(values)
                if channel["target"]["path"] == "rotation":
                    assert np.allclose(np.linalg.norm(values, axis=1), 1.0, rtol=0, atol=4 * SINGLE)
                    assert ((values[1:] * values[:-1]).sum(axis=1) > 0.0).all()
        return self

    def check_whole(self):
        """Rules of the Khronos validator on nodes, references and extensions."""
        document = self.document
        assert document["asset"]["version"] == "2.0" and len(document["buffers"]) == 1
        children = [child for node in self.nodes for child in node.get("children", ())]
        assert len(children) == len(set(children))  # one parent each
        (roots,) = [scene["nodes"] for scene in document["scenes"]]
        assert sorted([*roots, *children]) == list(range(len(self.nodes)))  # a tree that holds all, and nothing twice
        for node in self.nodes:
            assert "matrix" not in node  # it would rule out animation
            assert abs(np.linalg.norm(node.get("rotation", (0, 0, 0, 1))) - 1.0) < 4 * SINGLE
        for animation in document.get("animations", ()):
            targets = [(channel["target"]["node"], channel["target"]["path"]) for channel in animation["channels"]]
            assert len(targets) == len(set(targets))
        parts = [part for mesh in document["meshes"] for part in mesh["primitives"]]
        samplers = [sampler for animation in document.get("animations", ()) for sampler in animation["samplers"]]
        corners = {part["indices"] for part in parts if "indices" in part}
        points = {index for part in parts for index in part["attributes"].values()}
        clocks = {sampler[end] for sampler in samplers for end in ("input", "output")}
        views = [{document["accessors"][i]["bufferView"] for i in which} for which in (corners, points, clocks)]
        assert not (views[0] & views[1] or views[0] & views[2] or views[1] & views[2])  # one use each
        assert corners | points | clocks == set(range(len(document["accessors"])))  # nothing is left over
        assert set.union(*views) == set(range(len(document["bufferViews"])))
        assert {part["material"] for part in parts} == set(range(len(document["materials"])))
        assert {node["mesh"] for node in self.nodes if "mesh" in node} == set(range(len(document["meshes"])))
        for i in corners:  # the largest number of a type would begin a new strip
            assert self.array(i).max() < np.iinfo(np.dtype(COMPONENT[document["accessors"][i]["componentType"]])).max
        used = set(document.get("extensionsUsed", ()))
        found = {
            name for place in (document, *self.nodes, *document["materials"]) for name in place.get("extensions", ())
        }
        assert used == found and set(document.get("extensionsRequired", ())) <= used

    def check_primitive(self, part):
        points = part["attributes"]["POSITION"]
        assert {"min", "max"} <= set(self.document["accessors"][points])
        assert part["mode"] in (1, 3, 4) and part["material"] < len(self.document["materials"])
        if "indices" in part:
            corners = self.array(part["indices"])
            assert corners.max() < len(self.array(points)) and corners.size % (3 if part["mode"] == 4 else 2) == 0
        if part["mode"] == 4:
            normals = self.array(part["attributes"]["NORMAL"])
            assert len(normals) == len(self.array(points))
            assert np.allclose(np.linalg.norm(normals, axis=1), 1.0, rtol=0, atol=4 * SINGLE)


def cross(x, y, z):
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], float)


def y_up(points):
    return np.asarray(points) @ np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]]).T


@pytest.fixture(scope="module")
def solution():
    """A second of the pendulum; the lower arm turns by about 2 rad."""
    return simulate(pendulum(), 1.0, output=41)


@pytest.fixture(scope="module")
def file(solution, tmp_path_factory):
    return File(solution.export_glb(tmp_path_factory.mktemp("gltf") / "pendulum", frames=41))


def test_the_file_is_what_the_specification_asks(file):
    file.check()
    assert file.document["asset"]["version"] == "2.0" and file.document["asset"]["generator"].startswith("mbsd3d ")
    about = file.document["asset"]["extras"]
    assert about["title"] == "upper arm, lower arm and wheel" and about["length"] == "m" and about["duration"] == 1.0
    assert {UPPER_ARM, LOWER_ARM, WHEEL, "upper arm shape", "elbow on lower arm", "SpringDamper 1"} <= set(file.names)
    assert len(set(file.names)) == len(file.names)


def test_every_body_is_where_the_solution_says(file, solution):
    point = np.array([0.13, -0.21, 0.34])
    for k in (0, 7, 23, 40):
        for body in solution.system.bodies:
            expected = y_up(solution.point(body, point)[k])
            # both ends of the chain translation + rotation * point are rounded to single precision
            assert np.abs(file.world(body.name, point, k) - expected).max() < 4 * SINGLE
    times, _ = file.channels(LOWER_ARM, "translation")
    assert np.allclose(times, solution.t, rtol=SINGLE, atol=0)


def test_a_spring_reaches_from_end_to_end(file, solution):
    spring = solution.system.forces[0]
    for k in (0, 11, 40):
        for tip, (body, at) in enumerate(((spring.a, spring.at_a), (spring.b, spring.at_b))):
            expected = y_up(solution.body_point(body, at)[k])
            assert np.abs(file.world("SpringDamper 1", (0.0, 0.0, tip), k) - expected).max() < 4 * SINGLE


def test_another_reader_finds_the_bodies(solution, tmp_path):
    scene = trimesh.load(solution.export_glb(tmp_path / "run.glb"))
    up = np.eye(4)
    up[:3, :3] = y_up(np.eye(3)).T
    for body in solution.system.bodies:
        placed, _ = scene.graph.get(body.name)
        expected = np.eye(4)
        expected[:3, :3], expected[:3, 3] = solution.rotation(body)[0], solution.position(body)[0]
        assert np.allclose(placed, up @ expected, rtol=0, atol=4 * SINGLE)


def test_paths_are_those_of_the_points(solution, tmp_path):
    at = (0.32, 0.1, -0.4)
    drawn = File(solution.export_glb(tmp_path / "run.glb", frames=41, traces=[(LOWER_ARM, at)])).check()
    paths = [mesh["primitives"][0] for mesh in drawn.document["meshes"] if mesh["name"].startswith("path of ")]
    assert [path["mode"] for path in paths] == [3]
    points = drawn.array(paths[0]["attributes"]["POSITION"])
    expected = solution.body_point(solution.system.bodies[1], np.array(at))
    assert np.abs(points - expected).max() < 4 * SINGLE


def test_a_path_seen_from_a_body_lies_in_its_axes_and_goes_with_it(solution, tmp_path):
    carrier, at = solution.system.bodies[1], np.array([0.32, 0.1, -0.4])
    trace = (WHEEL, at, LOWER_ARM)
    drawn = File(solution.export_glb(tmp_path / "run.glb", frames=41, traces=[trace])).check()
    (mesh,) = [k for k, mesh in enumerate(drawn.document["meshes"]) if mesh["name"].startswith("path of ")]
    points = drawn.array(drawn.document["meshes"][mesh]["primitives"][0]["attributes"]["POSITION"])
    world = solution.body_point(WHEEL, at) - solution.position(carrier)
    expected = np.einsum("tji,tj->ti", solution.rotation(carrier), world)
    assert np.abs(points - expected).max() < 4 * SINGLE
    nodes = drawn.document["nodes"]
    (node,) = [k for k, node in enumerate(nodes) if node.get("mesh") == mesh]
    assert [node_.get("name") for node_ in nodes if node in node_.get("children", ())] == [LOWER_ARM]


def test_the_same_solution_gives_the_same_bytes(solution, tmp_path):
    first, second = (solution.export_glb(tmp_path / name).read_bytes() for name in ("a.glb", "b"))
    assert first == second and (tmp_path / "b.glb").exists()


def test_time_starts_at_zero_and_modes_move(solution, tmp_path):
    later = simulate(solution.system, 1.2, state=solution.final, output=5)
    file = File(later.export_glb(tmp_path / "later")).check()
    assert file.document["asset"]["extras"]["start"] == 1.0
    assert file.channels(WHEEL, "rotation")[0][-1] == pytest.approx(0.2, rel=SINGLE)
    bob = Body("bob", 1.0, (0.1, 0.2, 0.15), position=(0.1, 0.2, -1), com=(0.02, 0.03, 0.01))
    hung = System([bob], [Spherical(GROUND, bob, at=(0.12, 0.23, 0.4))])
    mode = linearize(hung, hung.state()).modes[-1].motion()
    moving = File(mode.export_glb(tmp_path / "mode", frames=mode.t.size)).check()
    assert np.abs(moving.world("bob", bob.com, 3) - y_up(mode.com(bob)[3])).max() < 4 * SINGLE


def test_one_sample_and_a_pose_stand_still(tmp_path):
    system = pendulum()
    for path in (accelerations(system).export_glb(tmp_path / "sample"), system.export_glb(tmp_path / "pose")):
        still = File(path).check()
        assert "animations" not in still.document
        assert np.allclose(still.world(WHEEL, (0, 0, 0)), y_up(system.bodies[2].position), rtol=0, atol=SINGLE)


@pytest.mark.parametrize("unit", [1e-3, 1e3])
def test_small_and_large_mechanisms(unit, tmp_path):
    arm = Body(
        "arm", 2.0, np.array([0.02, 0.03, 0.04]) * unit**2, com=np.array([0.1, -0.2, 0.3]) * unit,
        position=np.array([0.3, 0.2, 0.1]) * unit, orientation=rotation((1, 2, 3), 0.7), omega=(0.3, 5.0, 0.2),
    )  # fmt: skip
    hinge = Spherical(GROUND, arm, at=np.array([0.3, 0.25, 0.1]) * unit)
    run = simulate(System([arm], [hinge], gravity=(0, 0, 0)), 1.0, output=11)
    moving, point = File(run.export_glb(tmp_path / "arm", frames=11)).check(), np.array([0.1, -0.2, 0.3]) * unit
    for k in (0, 5, 10):
        assert np.abs(moving.world("arm", point, k) - y_up(run.com(arm)[k])).max() < 4 * SINGLE * unit


def test_far_from_the_origin_nothing_is_coarse(tmp_path):
    """Single precision has steps of a quarter of a metre there; numbers in the file are of the mechanism's size."""
    o = np.array([2.1e6, -3.3e6, 4.7e5])
    near, far = (File(pair_at(x).export_glb(tmp_path / f"pose{x[0]:g}")).check() for x in (0.0 * o, o))
    for name in ("arm", "bob", "SpringDamper 1"):
        for point in ((0.0, 0.0, 0.0), (0.1, -0.2, 1.0)):
            assert np.abs(far.world(name, point) - near.world(name, point) - y_up(o)).max() < 2e-5
    lines = []
    for file in (near, far):
        mesh = next(mesh for mesh in file.document["meshes"] if mesh["name"] == "Universal 1 on ground")
        lines.append(np.ptp(file.array(mesh["primitives"][0]["attributes"]["POSITION"]), axis=0))
    assert np.allclose(*lines, rtol=0, atol=2e-5)


def test_names_are_kept_letter_by_letter(tmp_path):
    names = ['Rad "vorn" \\ 1/2 <b>', "Ωmega 🚲", " x ", "ground floor"]
    bodies = [Body(name, 1.0, (1, 2, 2), position=(k, 0, 0)) for k, name in enumerate(names)]
    assert set(names) <= set(File(System(bodies).export_glb(tmp_path / "names")).check().names)


def test_bodies_without_mass_and_rods_of_joints(tmp_path):
    point = Body("point", 0.0, (0, 0, 0), position=(0.3, 0.1, 0.2))
    bob = Body("bob", 1.0, (0.1, 0.1, 0.2), position=(0.5, 0.4, 0.1))
    system = System([point, bob], [Distance(point, bob, at_a=(0.3, 0.1, 0.2), at_b=(0.5, 0.5, 0.1), name="rod")])
    drawn = File(system.export_glb(tmp_path / "rod")).check()
    assert "point" in drawn.names
    assert np.allclose(drawn.world("rod", (0, 0, 1)), y_up((0.5, 0.5, 0.1)), rtol=0, atol=4 * SINGLE)


def test_open_meshes_are_seen_from_behind(tmp_path):
    funnel = trimesh.Trimesh([(0, 0, 0), (1, 0, 0.1), (0, 1, 0), (0.2, 0.1, 1)], [(0, 1, 3), (1, 2, 3), (2, 0, 3)])
    funnel.export(tmp_path / "funnel.stl")
    bodies = [
        Body("funnel", 1.0, (1, 2, 2), shape=shapes.MeshFile(tmp_path / "funnel.stl")),
        Body("ball", 1.0, (1, 2, 2), position=(2, 0, 0), shape=shapes.Sphere(0.3)),
    ]
    drawn = File(System(bodies).export_glb(tmp_path / "two")).check()  # 9 short indices: what follows is aligned
    materials, sides = drawn.document["materials"], {}
    for mesh in drawn.document["meshes"]:
        sides[mesh["name"]] = {materials[part["material"]]["doubleSided"] for part in mesh["primitives"]}
    assert sides == {"funnel shape": {True}, "ball shape": {False}}


def chain(n):
    """A hanging chain of n links on universal joints."""
    bodies, joints, before = [], [], GROUND
    for k in range(n):
        bodies.append(Body(f"link {k}", 1.0, (0.001, 0.002, 0.002), position=(0.1 * k, 0, 0), com=(0.05, 0.01, 0)))
        joints.append(Universal(before, bodies[-1], at=(0.1 * k, 0, 0), axis_a=(0, 1, 0), axis_b=(0, 0, 1)))
        before = bodies[-1]
    return System(bodies, joints)


@pytest.mark.slow
def test_large_files_stay_small(tmp_path):
    path = simulate(chain(10), 0.5, output=41).export_glb(tmp_path / "ten", frames=1000)
    assert path.stat().st_size < 2e6 and len(File(path).channels("link 9", "rotation")[0]) == 1000
    many = chain(1000).export_glb(tmp_path / "thousand")
    assert many.stat().st_size < 2e6 and "link 999" in File(many).names


def test_a_fast_spin_keeps_to_one_sheet(tmp_path):
    top = Body("top", 15.0, (0.23, 0.47, 0.24), position=(0.1, 1, 0), com=(0, 0.02, 0.01), omega=(0, 150, -4.6))
    run = simulate(System([top], [Spherical(GROUND, top, at=(0, 0, 0))]), 0.3, output=300)
    _, values = File(run.export_glb(tmp_path / "top")).check().channels("top", "rotation")
    assert values[:, 3].min() < -0.9 and values[:, 3].max() > 0.9  # it went through both


def test_wrong_input_is_refused(solution, tmp_path):
    with pytest.raises(ValueError, match="frames = 1.5; give a whole number"):
        solution.export_glb(tmp_path / "run", frames=1.5)
    with pytest.raises(ValueError, match="'foot' is not one of the bodies"):
        solution.export_glb(tmp_path / "run", traces=[("foot", (0, 0, 0))])
    with pytest.raises(ValueError, match="cannot be written"):
        solution.export_glb(tmp_path / "no such folder" / "run")
    assert not list(tmp_path.iterdir())


def test_colours_become_linear():
    # IEC 61966-2-1: ((0.5020 + 0.055) / 1.055)^2.4 = 0.2159, and 10/255/12.92 below the knee
    assert linear(channels("#80ff0a") / 255.0) == pytest.approx([0.215861, 1.0, 0.003035], abs=1e-6)


def test_normals_are_those_of_the_solids():
    body = Body("body", 2.0, (0.1, 0.2, 0.25), com=(0.1, -0.2, 0.3))
    ball, can = (skin(shape.mesh(body)) for shape in (shapes.Sphere(0.4), shapes.Cylinder(0.2, 0.5)))
    # the triangles at the poles weigh more than those below: half a band of 18 degrees is 0.16 rad
    assert ball.closed and np.allclose(ball.normals, (ball.vertices - body.com) / 0.4, rtol=0, atol=0.16)
    side = np.abs(can.normals[:, 2]) < 0.5
    # weighed by their angles, what is left and right of a corner counts alike
    out = (can.vertices - body.com)[side, :2] / 0.2
    assert can.closed and np.allclose(can.normals[side, :2], out, rtol=0, atol=1e-12)
    assert np.allclose(np.abs(can.normals[~side, 2]), 1.0) and 0 < side.sum() < len(side)
    assert skin(shapes.Box((0.3, 0.4, 0.7), orientation=rotation((1, 2, 3), 0.4)).mesh(body)).closed


def test_odd_meshes_get_normals():
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [5, 5, 5]])
    sheet = np.array([[0, 1, 2], [0, 2, 1], [0, 1, 1], [1, 2, 3]])  # two sides of one triangle, none, a third
    found = skin(Mesh(corners, sheet, np.array([0, 1, 1, 0])))
    assert len(found.faces) == 3 and found.shade.tolist() == [0, 1, 0] and not found.closed
    assert found.vertices.max() == 1.0  # the corner without a face is left out
    assert np.allclose(np.linalg.norm(found.normals, axis=1), 1.0)
    assert np.array_equal(found.normals[found.faces[:2, 0]], [[0, 0, 1], [0, 0, -1]])
    assert not skin(Mesh(corners, sheet[:1], np.zeros(1, int))).closed


def test_links_turn_without_spinning():
    s = np.linspace(0.0, 1.0, 200)[:, None]
    spans = np.hstack([np.sin(9 * s), np.cos(5 * s) * 0.3, np.cos(9 * s)]) * (1.5 + s)
    lengths, e = rolled(spans, 1e-6)
    x, y, z, w = np.roll(e, -1, axis=1).T
    tips = np.column_stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
    assert np.allclose(tips * lengths[:, None], spans, rtol=0, atol=1e-12)
    turns = 2 * np.arccos(np.clip((e[1:] * e[:-1]).sum(axis=1), -1, 1))
    straight = np.arccos(np.clip((tips[1:] * tips[:-1]).sum(axis=1), -1, 1))
    assert np.allclose(turns, straight, rtol=0, atol=1e-6)  # arccos near 1 loses half the digits
    through = np.array([[0, 0, 2.0], [0, 0, 1.0], [0, 0, 0], [0, 0, -1.0]])
    lengths, e = rolled(through, 1e-6)
    assert lengths.tolist() == [2.0, 1.0, 1e-6, 1.0] and np.array_equal(e[0], e[2]) and abs(e[3] @ e[2]) < 1e-12


def test_coils_and_rods_have_their_outside_outside():
    for mesh in (unit_coil(), unit_rod()):
        assert mesh.vertices[:, 2].min() == pytest.approx(0.0, abs=0.01)
        assert trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).volume > 0.0
