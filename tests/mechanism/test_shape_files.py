"""Mesh files are drawn as they are or refused; shapes come back from model and result files."""

import numpy as np
import pytest
import trimesh
from helpers.models import random_body
from helpers.solids import PLAIN, SOLIDS, solid

from mbsd3d import Body, System, load, rotation, simulate
from mbsd3d.files.description import identical
from mbsd3d.rotations import matrix
from mbsd3d.shapes import Disc, Lines, MeshFile


@pytest.mark.parametrize("kind", ["stl", "obj", "ply", "glb"])
def test_mesh_files_are_drawn_from_o_in_their_scale(tmp_path, kind):
    body, turn = random_body(np.random.default_rng(3)), rotation((1, 2, 3), 0.7)
    original = trimesh.creation.box((300, 400, 700), transform=trimesh.transformations.translation_matrix((20, 0, 90)))
    original.export(tmp_path / f"part.{kind}")
    shape = MeshFile(tmp_path / f"part.{kind}", 0.001, orientation=turn)
    mesh, found = shape.mesh(body), solid(shape, body)
    assert isinstance(shape.path, str) and found.is_watertight
    assert found.volume == pytest.approx(0.084, rel=1e-6)  # STL and GLB hold 4-byte numbers
    assert np.allclose(found.center_mass, matrix(turn) @ (0.02, 0, 0.09), rtol=0, atol=1e-6)
    assert len(mesh.vertices) == 24  # its edges are sharp
    assert len(mesh.shade) == len(mesh.faces) == 12


def test_mesh_files_that_cannot_be_drawn_are_refused(tmp_path):
    def refused(name, message):
        with pytest.raises(ValueError, match=message):
            MeshFile(tmp_path / name).mesh(PLAIN)

    refused("none.stl", r"MeshFile '.*none.stl': cannot be read: No such file or directory; give a file that exists")
    (tmp_path / "folder.obj").mkdir()
    refused("folder.obj", "MeshFile '.*folder.obj': is not a file, is empty or")
    fine = trimesh.creation.icosphere(5)  # 20 480 triangles
    fine.export(tmp_path / "fine.stl")
    refused("fine.stl", "has 20480 triangles, at most 20000 are drawn; decimate it")
    (tmp_path / "points.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n")
    refused("points.obj", "has no triangles; give a mesh of a surface")
    (tmp_path / "nan.obj").write_text("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    refused("nan.obj", "has corners that are not finite or not there; repair it")
    head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    head += "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n"
    (tmp_path / "wild.ply").write_text(head + "3 0 1 7\n")
    refused("wild.ply", "has corners that are not finite or not there; repair it")
    for kind in ("stl", "obj", "ply", "glb"):
        (tmp_path / f"text.{kind}").write_text("What is this?\n")
        refused(f"text.{kind}", f"MeshFile '.*text.{kind}': (is no {kind.upper()} .*; save|has no triangles)")
        (tmp_path / f"empty.{kind}").write_text("")
        refused(f"empty.{kind}", f"MeshFile '.*empty.{kind}': is not a file, is empty or")


ALL = [
    *SOLIDS, Disc(0.3, 0.02, colour="tomato", at=(0.1, 0.2, 0.3)), MeshFile("../none.stl", 0.001),
    Lines([(0, 0, 0), (1, 2, 3), (np.nan,) * 3, (1, 1, 1), (2, 0, 2)], orientation=rotation("x", 0.3)),
]  # fmt: skip


@pytest.mark.parametrize("form", [".toml", ".json"])
def test_shapes_come_back_from_model_files(tmp_path, form):
    shapes = [ALL, "cylinder", None, *ALL]
    bodies = [Body(f"body {k}", 1.0, (1, 1, 1), shape=shape) for k, shape in enumerate(shapes)]
    again = System.from_file(System(bodies).to_file(tmp_path / f"model{form}"))
    assert all(identical(a.shape, b.shape) for a, b in zip(bodies, again.bodies, strict=True))
    assert (again.bodies[-2].shape.path, len(again.bodies[0].shape)) == ("../none.stl", len(ALL))


def test_shapes_come_back_from_result_files(tmp_path):
    run = simulate(System([Body("stone", 1.0, (1, 1, 1), omega=(0, 0, 1), shape=ALL)]), 0.1, output=3)
    assert identical(load(run.save(tmp_path / "run")).system.bodies[0].shape, run.system.bodies[0].shape)


@pytest.mark.parametrize(
    ("shape", "message"),
    [
        ("{type = 'Disk', radius = 1.0}", r"type 'Disk' is unknown - at `\$.bodies\[0\].shape`; give one of Box, Caps"),
        ("{type = 'Revolute'}", r"type 'Revolute' is unknown - at `\$.bodies\[0\].shape`; give one of Box"),
        ("{radius = 1.0}", r"type None is unknown - at `\$.bodies\[0\].shape`; give one of Box"),
        ("[{type = 'Disc', radius = -1.0}]", r"Disc: radius: -1.0 is not positive.* - at `\$.bodies\[0\].shape\[0\]`"),
        (
            "{type = 'Box', lengths = [1.0, 2.0]}",
            r"Expected `array` of length >= 3 - at `\$.bodies\[0\].shape.lengths`",
        ),
        (
            "{type = 'Sphere', radius = 1.0, color = 'red'}",
            "unknown field `color` - at .*; give at, orientation, colour",
        ),
        ("'egg'", r"body 'b': shape 'egg' is unknown; .* - at `\$.bodies\[0\]`"),
        ("7", r"Body 'b': Expected .* got `int` - at `\$.bodies\[0\].shape`"),
    ],
)
def test_wrong_shapes_in_model_files_are_named_with_their_place(tmp_path, shape, message):
    path = tmp_path / "model.toml"
    head = "format = 'mbsd3d system'\nversion = 2\ngravity = [0.0, 0.0, 0.0]\n"
    path.write_text(f"{head}[[bodies]]\nname = 'b'\nmass = 1.0\ninertia = [1.0, 1.0, 1.0]\nshape = {shape}\n")
    with pytest.raises(ValueError, match=message):
        System.from_file(path)
