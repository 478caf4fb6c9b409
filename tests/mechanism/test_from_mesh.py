"""Bodies from meshes: closed forms of boxes, prisms and solids put together, every fault, and hostile files."""

import base64
import json
import struct
import sys
import zipfile

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from mbsd3d import GROUND, Body, Revolute, System
from mbsd3d.inertia import box, combine

BOX_FACES = np.array(
    [(0, 2, 1), (0, 3, 2), (4, 5, 6), (4, 6, 7), (0, 1, 5), (0, 5, 4), (1, 2, 6), (1, 6, 5), (2, 3, 7), (2, 7, 6),
     (3, 0, 4), (3, 4, 7)]
)  # fmt: skip
TURN = Rotation.from_rotvec(0.7 * np.array([1, 2, 3]) / np.sqrt(14)).as_matrix()
TRIANGLE = "<triangle v1='{}' v2='{}' v3='{}'/>"


def block(lengths, R=TURN, at=(1.0, -2.0, 0.5)):
    corners = 0.5 * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    corners = np.array([(*c, z) for z in (-0.5, 0.5) for c in corners]) * lengths
    return corners @ np.transpose(R) + at, BOX_FACES


def prism(outline, height):
    """A prism over a closed polygon about the axis z, its ends fans of triangles from their middle points."""
    n = len(outline)
    low, high = (np.column_stack([outline, np.full(n, z)]) for z in (-0.5 * height, 0.5 * height))
    vertices = np.concatenate([low, high, [(0, 0, -0.5 * height), (0, 0, 0.5 * height)]])
    faces = []
    for i in range(n):
        j = (i + 1) % n
        faces += [(i, j, n + j), (i, n + j, n + i), (j, i, 2 * n), (n + i, n + j, 2 * n + 1)]
    return vertices, np.array(faces)


def ngon(n, radius, step=1):
    turn = 2 * np.pi * step * np.arange(n) / n
    return radius * np.column_stack([np.cos(turn), np.sin(turn)])


def both(*meshes):
    starts = np.cumsum([0, *(len(v) for v, _ in meshes[:-1])])
    faces = [f + start for (_, f), start in zip(meshes, starts, strict=True)]
    return np.concatenate([v for v, _ in meshes]), np.concatenate(faces)


def obj(path, vertices, faces):
    rows = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    path.write_text("\n".join(rows + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces.tolist()]))


def ply(path, vertices, faces):
    head = f"ply\nformat ascii 1.0\nelement vertex {len(vertices)}\nproperty double x\nproperty double y\n"
    head += f"property double z\nelement face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    rows = [" ".join(map(repr, v)) for v in vertices.tolist()] + [f"3 {a} {b} {c}" for a, b, c in faces.tolist()]
    path.write_text(head + "\n".join(rows) + "\n")


def stl(path, vertices, faces):
    rows = b"".join(struct.pack("<12fH", 0, 0, 0, *vertices[face].ravel(), 0) for face in faces)
    path.write_bytes(bytes(80) + struct.pack("<I", len(faces)) + rows)


def gltf(path, vertices, faces):
    data = vertices.astype("<f4").tobytes() + faces.astype("<u4").tobytes()
    size, count = 12 * len(vertices), 3 * len(faces)
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    views = [{"buffer": 0, "byteOffset": 0, "byteLength": size},
             {"buffer": 0, "byteOffset": size, "byteLength": len(data) - size}]  # fmt: skip
    accessors = [
        {"bufferView": 0, "componentType": 5126, "count": len(vertices), "type": "VEC3"},
        {"bufferView": 1, "componentType": 5125, "count": count, "type": "SCALAR"},
    ]
    primitive = {"attributes": {"POSITION": 0}, "indices": 1}
    whole = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
             "meshes": [{"primitives": [primitive]}], "accessors": accessors, "bufferViews": views,
             "buffers": [{"uri": uri, "byteLength": len(data)}]}  # fmt: skip
    path.write_text(json.dumps(whole))


def object_xml(vertices, faces, number=1):
    points = "".join(f"<vertex x='{x!r}' y='{y!r}' z='{z!r}'/>" for x, y, z in vertices.tolist())
    sides = "".join(TRIANGLE.format(*face) for face in faces.tolist())
    mesh = f"<mesh><vertices>{points}</vertices><triangles>{sides}</triangles></mesh>"
    return f"<object id='{number}' type='model'>{mesh}</object>"


def threemf(path, resources, build, unit="unit='centimeter'"):
    space = "xmlns='http://schemas.microsoft.com/3dmanufacturing/core/2015/02'"
    model = f"<?xml version='1.0' encoding='UTF-8'?><model {unit} {space}><resources>{resources}</resources>"
    relation = "Type='http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel' Target='/3D/part.model'"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("_rels/.rels", f"<Relationships><Relationship Id='r' {relation}/></Relationships>")
        archive.writestr("3D/part.model", f"{model}<build>{build}</build></model>")


def test_a_box_has_its_closed_form_also_far_away(tmp_path):
    """2700 kg/m^3 times 0.2 x 0.3 x 0.5 m, turned and moved; 1e4 m away the corners keep 12 digits of their 16."""
    inertia = TURN @ np.diag(81.0 * np.array([0.34, 0.29, 0.13]) / 12) @ TURN.T
    for name, write, scale, unit, rounding in (
        ("a.obj", obj, 1e3, "mm", 1e-12), ("a.ply", ply, 1 / 0.0254, "in", 1e-12), ("a.stl", stl, 1.0, 1.0, 1e-6),
        ("a.gltf", gltf, 1.0, None, 1e-6),
    ):  # fmt: skip
        vertices, faces = block((0.2, 0.3, 0.5))
        write(tmp_path / name, vertices * scale, faces)
        body = Body.from_mesh("box", tmp_path / name, density=2700.0, unit=unit)
        assert body.mass == pytest.approx(81.0, rel=rounding)
        assert body.com == pytest.approx([1.0, -2.0, 0.5], rel=rounding)
        assert np.abs(body.inertia - inertia).max() < 3 * rounding
    far = np.array([1e4, -1e4, 5e3])
    obj(tmp_path / "far.obj", vertices + far, faces)
    body = Body.from_mesh("box", tmp_path / "far.obj", density=2700.0, unit="m")
    assert np.abs(body.inertia - inertia).max() < 1e-9
    assert body.com - far == pytest.approx([1.0, -2.0, 0.5], abs=1e-10)


@pytest.mark.parametrize("n", [5, 32, 128])
def test_a_prism_has_the_mass_of_its_polygon(tmp_path, n):
    """Area n/2 R^2 sin(2 pi/n); Izz = m R^2 (2 + cos(2 pi/n))/6, Ixx = Izz/2 + m h^2/12 (exact for the polyhedron)."""
    R, h, rho, a = 0.3, 0.8, 7800.0, 2 * np.pi / n
    mass = rho * h * n / 2 * R**2 * np.sin(a)
    Izz = mass * R**2 * (2 + np.cos(a)) / 6
    ply(tmp_path / "a.ply", *prism(ngon(n, R), h))
    body = Body.from_mesh("prism", tmp_path / "a.ply", density=rho, unit="m")
    assert body.mass == pytest.approx(mass, rel=1e-13)
    assert np.diag(body.inertia) == pytest.approx([Izz / 2 + mass * h**2 / 12] * 2 + [Izz], rel=1e-12)
    if n == 32:
        assert (body.mass, Izz) == pytest.approx((1753.0035975081219, 78.37990979919178), rel=1e-13)


def test_random_solids_add_up(tmp_path):
    """Two convex bodies apart, of 40 random corners: as the tetrahedra of their hulls, put together by `combine`."""
    rng = np.random.default_rng(7)
    meshes, parts = [], []
    for at in ((0.3, 0.1, -0.2), (4.0, -1.0, 2.5)):
        points = rng.normal(size=(40, 3)) + at
        found = ConvexHull(points)
        faces = found.simplices.copy()
        inward = np.einsum("ij,ij->i", np.cross(*(points[faces[:, k]] - points[faces[:, 0]] for k in (1, 2))),
                           found.equations[:, :3]) < 0  # fmt: skip
        faces[inward] = faces[inward][:, ::-1]
        meshes.append((points, faces))
        middle = points.mean(axis=0)
        for face in faces:
            corners = np.vstack([points[face], middle])
            mass = 3.0 * abs(np.linalg.det(corners[:3] - middle)) / 6
            arms = corners - corners.mean(axis=0)
            spread = mass / 20 * arms.T @ arms  # of a tetrahedron about its centre
            parts.append((mass, corners.mean(axis=0), np.trace(spread) * np.eye(3) - spread))
    whole = combine(parts)
    obj(tmp_path / "two.obj", *both(*meshes))
    body = Body.from_mesh("two", tmp_path / "two.obj", density=3.0, unit="m")
    assert body.mass == pytest.approx(whole.mass, rel=1e-12)
    assert body.com == pytest.approx(whole.com, rel=1e-12)
    assert np.abs(body.inertia - whole.inertia).max() < 1e-12 * np.abs(whole.inertia).max()


def test_a_cavity_is_taken_away(tmp_path):
    outer, (inner, faces) = block((1.0, 1.0, 1.0)), block((0.5, 0.5, 0.5))
    obj(tmp_path / "hollow.obj", *both(outer, (inner, faces[:, ::-1])))
    body = Body.from_mesh("hollow", tmp_path / "hollow.obj", density=2.0, unit="m")
    assert body.mass == pytest.approx(1.75, rel=1e-12)
    assert np.diag(body.inertia) == pytest.approx(box(2.0, (1, 1, 1)) - box(0.25, (0.5, 0.5, 0.5)), rel=1e-12)


def test_a_mesh_inside_out_is_turned_back_and_said(tmp_path):
    vertices, faces = block((0.2, 0.3, 0.5))
    obj(tmp_path / "a.obj", vertices, faces[:, ::-1])
    message = "body 'box': mesh '.*a.obj': is turned inside out; it is turned back"
    with pytest.warns(UserWarning, match=message) as said:
        body = Body.from_mesh("box", tmp_path / "a.obj", density=2700.0, unit="m")
    assert body.mass == pytest.approx(81.0, rel=1e-12)
    assert said[0].filename == __file__


def flipped(vertices, faces):
    faces = faces.copy()
    faces[4] = faces[4][::-1]
    return vertices, faces


CUBE, STAR = block((1, 1, 1)), prism(ngon(5, 1.0, step=2), 1.0)
FAULTS = {
    "open": ((CUBE[0], CUBE[1][:-1]), "is open, 3 of its edges have an odd number of triangles; close its holes"),
    "flipped": (flipped(*CUBE), "is not turned one way.*at 3 of its edges.*unify its normals"),
    "overlap": (both(CUBE, (CUBE[0] + 0.5, CUBE[1])), "overlaps itself, .* go 2 times round"),
    "small overlap": (both(CUBE, (CUBE[0] + TURN @ [0.98, 0, 0], CUBE[1])), "overlaps itself"),
    "star": (STAR, "overlaps itself"),
    "one of two turned": (both(block((2, 2, 2)), (CUBE[0] + 9.0, CUBE[1][:, ::-1])), "parts that are turned inside"),
    "cavity that leaves": (both(CUBE, (CUBE[0] * 0.5 + 0.9, CUBE[1][:, ::-1])), "parts that are turned inside out"),
    "flat": ((CUBE[0][:4], np.array([(0, 1, 2), (0, 2, 1)])), "enclose no volume"),
}


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("seed", range(3))
def test_faults_are_named(tmp_path, fault, seed):
    """Whatever the pose and size; nothing of it gives a mass."""
    (vertices, faces), message = FAULTS[fault]
    rng = np.random.default_rng(seed)
    vertices = 10.0 ** rng.uniform(-3, 3) * vertices @ Rotation.random(random_state=seed).as_matrix().T
    obj(tmp_path / "bad.obj", vertices + rng.normal(size=3), faces)
    with pytest.raises(ValueError, match=f"body 'part': mesh '.*bad.obj': .*{message}"):
        Body.from_mesh("part", tmp_path / "bad.obj", density=1.0, unit="mm")


@pytest.mark.parametrize(
    ("name", "given", "message"),
    [
        ("a.obj", {"density": 1.0}, 'OBJ files have no unit; give unit=, one of "m"'),
        ("a.obj", {"density": 1.0, "unit": "furlong"}, "unit 'furlong' is unknown"),
        ("a.obj", {"density": 1.0, "unit": -1.0}, "unit.*-1"),
        ("a.obj", {"density": 0.0, "unit": "m"}, "density"),
        ("a.obj", {"density": 1.0, "unit": "m", "shape": "meshes"}, "shape 'meshes' is unknown"),
        ("a.obj", {"density": 1.0, "unit": "m", "com": (0, 0, 0)}, "com is no argument for a mesh"),
        ("b.iges", {"density": 1.0}, "IGES files hold curved surfaces, which are not read; export a mesh"),
        ("b.txt", {"density": 1.0}, "is not a mesh; give one that ends in"),
        ("none.stl", {"density": 1.0, "unit": "m"}, "cannot be read: No such file"),
        ("c.gltf", {"density": 1.0}, "save it as .glb"),
    ],
)
def test_wrong_calls_are_explained(tmp_path, name, given, message):
    obj(tmp_path / "a.obj", *CUBE)
    (tmp_path / "c.gltf").write_text('{"asset": {"version": "2.0"}, "buffers": [{"uri": "/etc/passwd"}]}')
    with pytest.raises(ValueError, match=message):
        Body.from_mesh("part", tmp_path / name, **given)


def test_a_path_is_asked_for():
    with pytest.raises(ValueError, match="body 'part': mesh is 3; give the name of a file"):
        Body.from_mesh("part", 3, density=1.0)


def test_3mf_builds_what_it_places_in_its_unit(tmp_path):
    """A block placed twice through an object of objects, once as a mirror image; both count, in centimetres."""
    vertices, faces = block((1.0, 2.0, 3.0), at=(0.0, 0.0, 0.0))
    parts = "<component objectid='1' transform='0 1 0 -1 0 0 0 0 1 5 0 0'/>"
    parts += "<component objectid='1' transform='-1 0 0 0 1 0 0 0 1 0 7 0'/>"
    resources = object_xml(vertices, faces) + f"<object id='2'><components>{parts}</components></object>"
    threemf(tmp_path / "two.3mf", resources, "<item objectid='2' transform='1 0 0 0 1 0 0 0 1 0 0 4'/>")
    body = Body.from_mesh("two", tmp_path / "two.3mf", density=1e6)
    quarter, mirror = np.array([(0, -1, 0), (1, 0, 0), (0, 0, 1)]), np.diag((-1, 1, 1))
    one = TURN @ np.diag(box(6.0, (0.01, 0.02, 0.03))) @ TURN.T
    whole = combine([(6.0, (0.05, 0, 0.04), quarter @ one @ quarter.T), (6.0, (0, 0.07, 0.04), mirror @ one @ mirror)])
    assert body.mass == pytest.approx(12.0, rel=1e-12)
    assert body.com == pytest.approx(whole.com, abs=1e-14)
    assert np.abs(body.inertia - whole.inertia).max() < 1e-15
    drawn = body.shape.mesh(body)
    assert (len(drawn.faces), drawn.vertices[:, 1].max() > 0.07) == (24, True)
    with pytest.raises(ValueError, match="unit is 0.001 m, but the file is in units of 0.01 m; leave unit out"):
        Body.from_mesh("two", tmp_path / "two.3mf", density=1.0, unit="mm")
    threemf(tmp_path / "mm.3mf", object_xml(vertices, faces), "<item objectid='1'/>", unit="")
    assert Body.from_mesh("one", tmp_path / "mm.3mf", density=1e9).mass == pytest.approx(6.0, rel=1e-12)


CYCLE = "<object id='1'><components><component objectid='1'/><component objectid='1'/></components></object>"


@pytest.mark.parametrize(
    ("resources", "build", "message"),
    [
        (CYCLE, "<item objectid='1'/>", "nests more than 32 objects or places more than"),
        (object_xml(*CUBE), "<item objectid='9'/>", "is no 3MF"),
        (object_xml(*CUBE), "", "builds nothing"),
        (object_xml(*CUBE), "<item objectid='1' xmlns:p='p' p:path='/3D/other.model'/>", "further models"),
        ("<!-- " + " " * 21_000_000 + "-->", "", "bytes unpacked"),
        (object_xml(CUBE[0], CUBE[1] + 5), "<item objectid='1'/>", "not finite or not there"),
    ],
)
def test_hostile_3mf_files_are_refused(tmp_path, resources, build, message):
    threemf(tmp_path / "bad.3mf", resources, build)
    with pytest.raises(ValueError, match=message):
        Body.from_mesh("part", tmp_path / "bad.3mf", density=1.0)


def test_gltf_files_without_data_are_not_filled_with_zeros(tmp_path):
    primitive = {"attributes": {"POSITION": 0}}
    whole = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
             "meshes": [{"primitives": [primitive]}],
             "accessors": [{"componentType": 5126, "count": 300_000_000, "type": "VEC3"}]}  # fmt: skip
    text = json.dumps(whole).encode()
    (tmp_path / "a.gltf").write_bytes(text)
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sIIII", b"glTF", 2, 20 + len(text), len(text), 0x4E4F534A)
    (tmp_path / "a.glb").write_bytes(head + text)
    for name in ("a.gltf", "a.glb"):
        with pytest.raises(ValueError, match="accessors of more numbers than the file"):
            Body.from_mesh("part", tmp_path / name, density=1.0)


def test_3mf_declares_no_entities(tmp_path):
    with zipfile.ZipFile(tmp_path / "bad.3mf", "w") as archive:
        archive.writestr("_rels/.rels", "<!DOCTYPE a [<!ENTITY b SYSTEM 'file:///etc/passwd'>]><a>&b;</a>")
    with pytest.raises(ValueError, match="declares entities"):
        Body.from_mesh("part", tmp_path / "bad.3mf", density=1.0)


def test_it_is_drawn_saved_and_moved_as_any_other_body(tmp_path):
    vertices, faces = block((0.2, 0.3, 0.5))
    obj(tmp_path / "a.obj", vertices * 1e3, faces)
    body = Body.from_mesh(
        "arm", tmp_path / "a.obj", density=2700.0, unit="mm", position=(0.1, 0.2, 0.3), omega=(0, 0, 1)
    )
    corners = body.shape.mesh(body).vertices
    assert corners.min(axis=0) == pytest.approx(vertices.min(axis=0), rel=1e-12)
    assert corners.max(axis=0) == pytest.approx(vertices.max(axis=0), rel=1e-12)
    system = System([body], [Revolute(GROUND, body, at=(0.1, 0.2, 0.3), axis=(0.3, 1, 0.2))])
    assert system.check().mobility == 1
    system.to_file(tmp_path / "model.toml")
    again = System.from_file(tmp_path / "model.toml").bodies[0]
    assert (again.mass, again.inertia.tolist(), again.shape.path) == (body.mass, body.inertia.tolist(), body.shape.path)
    assert Body.from_mesh("arm", tmp_path / "a.obj", density=1.0, unit="mm", shape=None).shape is None


def test_fine_meshes_are_read_where_they_need_not_be_drawn(tmp_path):
    n = 5001
    obj(tmp_path / "fine.obj", *prism(ngon(n, 1.0), 1.0))
    with pytest.raises(
        ValueError, match='20004 triangles, more than 20000; decimate it, or do not draw it: shape="box"'
    ):
        Body.from_mesh("disc", tmp_path / "fine.obj", density=1.0, unit="m")
    body = Body.from_mesh("disc", tmp_path / "fine.obj", density=1.0, unit="m", shape="cylinder")
    assert body.mass == pytest.approx(n / 2 * np.sin(2 * np.pi / n), rel=1e-12)


# STEP


def step_text(radius, height, place, unit):
    """A STEP file of a cylinder along z: three faces, two circles and a seam."""
    rows = []

    def add(kind, *given):
        rows.append(f"#{len(rows) + 1}={kind}({','.join(map(str, given))});")
        return f"#{len(rows)}"

    def among(parts):
        return f"({','.join(map(str, parts))})"

    def point(x, y, z):
        at = (f"{a + b:.9E}" for a, b in zip(place, (x, y, z), strict=True))
        return add("CARTESIAN_POINT", "''", among(at))

    def direction(*x):
        return add("DIRECTION", "''", among(map(float, x)))

    def axes(z):
        return add("AXIS2_PLACEMENT_3D", "''", point(0, 0, z), direction(0, 0, 1), direction(1, 0, 0))

    def face(surface, edges, sense):
        oriented = [add("ORIENTED_EDGE", "''", "*", "*", edge, ".T." if along else ".F.") for edge, along in edges]
        bound = add("FACE_OUTER_BOUND", "''", add("EDGE_LOOP", "''", among(oriented)), ".T.")
        return add("ADVANCED_FACE", "''", among([bound]), surface, ".T." if sense else ".F.")

    corners = [add("VERTEX_POINT", "''", point(radius, 0, z)) for z in (0, height)]
    circles = [add("CIRCLE", "''", axes(z), f"{radius:.9E}") for z in (0, height)]
    low, high = (add("EDGE_CURVE", "''", v, v, c, ".T.") for v, c in zip(corners, circles, strict=True))
    line = add("LINE", "''", point(radius, 0, 0), add("VECTOR", "''", direction(0, 0, 1), 1.0))
    seam = add("EDGE_CURVE", "''", *corners, line, ".T.")
    side = add("CYLINDRICAL_SURFACE", "''", axes(0), f"{radius:.9E}")
    faces = [face(side, [(low, True), (seam, True), (high, False), (seam, False)], True)]
    faces += [face(add("PLANE", "''", axes(z)), [(x, up)], up) for z, x, up in ((0, low, False), (height, high, True))]
    solid = add("MANIFOLD_SOLID_BREP", "''", add("CLOSED_SHELL", "''", among(faces)))
    length = add("", f"LENGTH_UNIT()NAMED_UNIT(*){unit}")
    angle = add("", "NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.)")
    solid_angle = add("", "NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT()")
    units = f"GLOBAL_UNIT_ASSIGNED_CONTEXT(({length},{angle},{solid_angle}))"
    context = add("", f"GEOMETRIC_REPRESENTATION_CONTEXT(3){units}REPRESENTATION_CONTEXT('','')")
    shape = add("ADVANCED_BREP_SHAPE_REPRESENTATION", "''", among([solid]), context)
    app = add("APPLICATION_CONTEXT", "'automotive design'")
    product = add("PRODUCT", "'part'", "'part'", "''", among([add("PRODUCT_CONTEXT", "''", app, "'mechanical'")]))
    form = add("PRODUCT_DEFINITION_FORMATION", "''", "''", product)
    part = add("PRODUCT_DEFINITION", "''", "''", form, add("PRODUCT_DEFINITION_CONTEXT", "''", app, "'design'"))
    add("SHAPE_DEFINITION_REPRESENTATION", add("PRODUCT_DEFINITION_SHAPE", "''", "''", part), shape)
    head = "HEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n"
    head += "FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\nDATA;\n"
    return f"ISO-10303-21;\n{head}" + "\n".join(rows) + "\nENDSEC;\nEND-ISO-10303-21;\n"


@pytest.mark.parametrize(("unit", "metres"), [("SI_UNIT(.MILLI.,.METRE.)", 1e-3), ("SI_UNIT($,.METRE.)", 1.0)])
def test_step_files_are_read_in_their_unit(tmp_path, unit, metres):
    """The moments of a cylinder, of which chords 0.05 rad apart lack at most (0.05 rad)^2 / 6 = 4e-4; of r^4 twice."""
    pytest.importorskip("cascadio")
    r, h, place = 0.03, 0.07, np.array([0.1, 0.02, 0.03])
    (tmp_path / "part.STEP").write_text(step_text(r / metres, h / metres, place / metres, unit))
    part = Body.from_mesh("part", tmp_path / "part.STEP", density=7800.0)
    mass = 7800.0 * np.pi * r**2 * h
    assert -4e-4 < part.mass / mass - 1.0 < -1e-6
    assert np.abs(part.com - place - (0, 0, h / 2)).max() < 1e-7  # float32 of the triangles
    across = mass * (3 * r**2 + h**2) / 12
    assert np.abs(part.inertia - np.diag([across, across, mass * r**2 / 2])).max() < 8e-4 * across
    drawn = part.shape.mesh(part).vertices
    assert np.abs(drawn.max(axis=0) - place - (r, r, h)).max() < 1e-6
    with pytest.raises(ValueError, match="unit is 0.0254 m, but the file is in units of 1 m; leave unit out"):
        Body.from_mesh("part", tmp_path / "part.STEP", density=7800.0, unit="in")


def test_broken_step_files_are_refused(tmp_path):
    pytest.importorskip("cascadio")
    whole = step_text(30.0, 70.0, (0, 0, 0), "SI_UNIT(.MILLI.,.METRE.)")
    for text in ("nonsense", whole[:900], whole.replace("CLOSED_SHELL", "OPEN_SHELL_OF")):
        (tmp_path / "part.stp").write_text(text)
        with pytest.raises(
            ValueError, match="body 'part': mesh '.*part.stp': (holds no surfaces|is open|is no|has no)"
        ):
            Body.from_mesh("part", tmp_path / "part.stp", density=7800.0)


def test_without_cascadio_the_extra_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "cascadio", None)
    (tmp_path / "part.stp").write_text("ISO-10303-21;")
    with pytest.raises(
        ValueError, match=r"STEP files hold curved surfaces, which need .*: pip install 'mbsd3d\[step\]'"
    ):
        Body.from_mesh("part", tmp_path / "part.stp", density=1.0)
