"""The command `mbsd3d import`: one format into another, and one line for what is wrong."""

import re

import pytest
from click.testing import CliRunner

from mbsd3d import GROUND, Body, KnifeEdge, Revolute, Spherical, System, read_sdf, read_urdf
from mbsd3d.extend import main


def call(*arguments):
    """Run a command in this process."""
    return CliRunner().invoke(main, [str(x) for x in arguments])


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with a pendulum as a model file."""
    monkeypatch.chdir(tmp_path)
    bob = Body("bob", 1.0, (0.1, 0.2, 0.15), com=(0.1, 0, 0.2), position=(0, 0, -1))
    System([bob], [Revolute(GROUND, bob, at=(0, 0, 0), axis=(0.1, 1, 0), name="hinge")]).to_file("model.toml")
    cart = Body("cart", 1.0, (0.1, 0.2, 0.15))
    System([cart], [KnifeEdge(GROUND, cart, at=(0, 0, 0), lateral=(0, 1, 0), name="edge")]).to_file("cart.json")
    ball = Spherical(GROUND, bob, at=(0, 0, 0), name="ball")
    System([bob], [ball]).to_file("ball.json")
    return tmp_path


def test_models_go_from_format_to_format(folder):
    names = ["model.toml", "a.xml", "b.urdf", "c.sdf", "d.mjcf", "e.json"]
    for first, second in zip(names, names[1:], strict=False):
        result = call("import", first, "--to", second)
        assert result.exit_code == 0 and f"'{second}'" in result.output, result.output
    before, after = System.from_file("model.toml"), System.from_file("e.json")
    assert [x.name for x in after.joints] == ["hinge"]
    first, second = (x.bodies[0] for x in (before, after))
    assert abs(first.centre - second.centre).max() < 1e-15
    assert call("check", "c.sdf").exit_code == call("check", "d.mjcf").exit_code == 0
    assert read_sdf("c.sdf").system.bodies[0].mass == 1.0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("model.toml", "--to", "a.txt"), "--to a.txt: the name ends in no format; give .toml, .json, .xml, .urdf"),
        (("model.toml", "--to", "model.toml"), "exists; give --replace to replace it"),
        (("model.toml", "--to", "a.json", "--omit", "hinge"), "--omit is for formats of other programs"),
        (("model.toml", "--to", "a.xml", "--massless"), "--massless is for .urdf and .sdf"),
        (("cart.json", "--to", "a.sdf"), "SDF cannot hold joint 'edge' .*give --omit 'edge', or change the system"),
        (("ball.json", "--to", "a.urdf"), "give --massless"),
        (("model.txt", "--to", "a.sdf"), r"give a model \(.json, .toml, .xml, .mjcf, .urdf, .xacro, .sdf\)"),
    ],
)
def test_what_is_wrong_is_one_line(folder, arguments, message):

    result = call("import", *arguments)
    assert result.exit_code == 2 and re.search(message, result.output), result.output


def test_parts_are_left_out_on_request(folder):
    result = call("import", "cart.json", "--to", "a.sdf", "--omit", "edge")
    assert result.exit_code == 0 and "inactive: edge" in result.output
    assert call("import", "ball.json", "--to", "a.urdf", "--massless").exit_code == 0
    assert len(read_urdf("a.urdf").system.joints) == 3
