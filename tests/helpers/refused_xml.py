"""MJCF and URDF that are refused at once, and with which words."""

import pytest

from mbsd3d import read_mjcf

INERTIAL = '<inertial mass="{}" pos="0.11 -0.07 0.2" fullinertia="0.31 0.35 0.22 0.02 -0.03 0.04"/>'

BODY = '<body name="arm" pos="0 0 1"><joint name="hinge" axis="1 2 3" {joint}/>{more}' + INERTIAL.format(1) + "</body>"


def hostile(content, root="mujoco"):
    """A model with something in it."""
    return f"<{root}>{content}<worldbody>{BODY.format(joint='', more='')}</worldbody></{root}>"


COPIES = '<worldbody><replicate count="{}"><body>' + INERTIAL.format(1) + "</body></replicate></worldbody>"

HOSTILE = {
    "absolute include": (hostile('<include file="/etc/passwd"/>'), "outside of the folder"),
    "include above": (hostile('<include file="../secret.xml"/>'), "outside of the folder"),
    "include through a link": (hostile('<include file="link/secret.xml"/>'), "leads out of the folder"),
    "include in an include through a link": (hostile('<include file="parts/a.xml"/>'), "leads out of the folder"),
    "mesh that is a link": (hostile('<asset><mesh file="x/secret.stl"/></asset>'), "leads out of the folder"),
    "many files in many folders": (
        hostile(
            "".join(f'<compiler meshdir="d{i}"/>' for i in range(5000))
            + "<asset>"
            + "".join(f'<mesh file="m{i}.stl"/>' for i in range(9000))
            + "</asset>"
        ),
        "names more than 2000 files or 10 folders",
    ),
    "mesh elsewhere": (hostile('<asset><mesh file="/tmp/a.stl"/></asset>'), "line 1: <mesh> file names"),
    "meshdir elsewhere": (hostile('<compiler meshdir="/tmp"/>'), "<compiler> meshdir names"),
    "drive": (hostile('<asset><mesh file="C:\\a.stl"/></asset>'), "outside of the folder"),
    "scheme": (hostile('<asset><mesh file="http://a/b.stl"/></asset>'), "outside of the folder"),
    "package above": (hostile('<asset><mesh file="package://../b.stl"/></asset>'), "outside of the folder"),
    "include of itself": (hostile('<include file="model.xml"/>'), "more than 100 files"),
    "second include": (hostile('<include file="part.xml"/>'), "line 1: <include> file names '/etc/passwd'"),
    "2e6 copies": (hostile(COPIES.format(2_000_000)), "<replicate> makes more than 20000 elements|<body> makes more"),
    "copies of copies": (
        hostile("<worldbody>" + '<replicate count="1000">' * 3 + "<body/>" + "</replicate>" * 3 + "</worldbody>"),
        "more than 20000",
    ),
    "copies in words": (hostile(COPIES.format("many")), "give a whole number"),
    "large composite": (hostile('<worldbody><composite count="1000 1000 1"/></worldbody>'), "more than 20000"),
    "nan": (hostile("").replace('pos="0 0 1"', 'pos="nan 0 inf"'), "position of 'arm': not finite"),
    "nan mass": (hostile("").replace('mass="1"', 'mass="nan"'), "cannot read it|not finite"),
    "entities": ('<!DOCTYPE a [<!ENTITY b "cc">]>' + hostile(""), "entity b is declared"),
    "external entity": ('<!DOCTYPE a [<!ENTITY b SYSTEM "file:///etc/passwd">]><mujoco>&b;</mujoco>', "entity b"),
    "plugin": (hostile('<extension><plugin plugin="x"/></extension>'), "asks for a plugin"),
    "deep": ("<mujoco><worldbody>" + "<body>" * 300_000, "more than 20000|no XML"),
    "no end": ("<mujoco><worldbody>", r"line 1: no XML \(no element found\)"),
    "empty": ("", "is empty"),
    "other": (hostile("", "sdf"), "its root is <sdf>, not <mujoco>"),
    "unknown element": (hostile("<nonsense/>"), "MuJoCo cannot read it: .*nonsense"),
    "memory": (hostile('<size memory="1000G"/>'), "MuJoCo cannot read it: .*memory"),
    "texture of 30 GB": (
        hostile('<asset><texture name="t" type="2d" builtin="checker" width="60000" height="60000"/></asset>'),
        "cannot read it: .*memory",
    ),
    "mesh that takes minutes": (
        hostile('<asset><mesh name="m" builtin="supertorus" params="3000 1 1 1"/></asset>'),
        "MuJoCo (takes more than|cannot read it|broke off)",
    ),
    "mesh that is missing": (hostile('<asset><mesh file="a.stl"/></asset>'), "MuJoCo cannot read it: .*a.stl"),
}


def check_refused(outside, case):
    """A hostile model in a folder of its own, with links out of it, is refused in its words."""
    content, message = HOSTILE[case]
    (outside / "secret.xml").write_text("<mujocoinclude/>")
    folder = outside / "models"
    folder.mkdir()
    (folder / "link").symlink_to(outside)
    (folder / "secret.stl").symlink_to(outside / "secret.xml")
    (folder / "parts").mkdir()
    (folder / "parts" / "a.xml").write_text('<mujocoinclude><include file="b.xml"/></mujocoinclude>')
    (folder / "parts" / "b.xml").symlink_to(outside / "secret.xml")
    (folder / "part.xml").write_text('<mujocoinclude><include file="/etc/passwd"/></mujocoinclude>')
    (folder / "model.xml").write_text(content)
    with pytest.raises(ValueError, match=rf"(model|part|a).xml'(?s:.*)({message})"):
        read_mjcf(folder / "model.xml")
