"""MJCF and URDF that are refused at once, and with which words."""

import pytest

from mbsd3d import read_mjcf

INERTIAL = '<inertial mass="{}" pos="0.11 -0.07 0.2" fullinertia="0.31 0.35 0.22 0.02 -0.03 0.04"/>'

BODY = '<body name="arm" pos="0 0 1"><joint name="hinge" axis="1 2 3" {joint}/>{more}' + INERTIAL.format(1) + "</body>"


def hostile(content, root="mujoco"):
    """A model with something in it."""
    return f"<{root}>{content}<worldbody>{BODY.format(joint='', more='')}</worldbody></{root}>"


def needed(mesh, compiler=""):
    """A model in which a mesh gives the mass of a body."""
    body = '<body name="b"><joint/><geom type="mesh" mesh="m"/></body>'
    return f"<mujoco><compiler {compiler}/><asset>{mesh}</asset><worldbody>{body}</worldbody></mujoco>"


COPIES = '<worldbody><replicate count="{}"><body>' + INERTIAL.format(1) + "</body></replicate></worldbody>"
HOSTILE = {
    "absolute include": (hostile('<include file="/etc/passwd"/>'), "outside of the folder"),
    "include above": (hostile('<include file="../secret.xml"/>'), "leads out of the folder"),
    "include through a link": (hostile('<include file="link/secret.xml"/>'), "leads out of the folder"),
    "include in an include through a link": (hostile('<include file="parts/a.xml"/>'), "leads out of the folder"),
    "model in many folders": (
        hostile("".join(f'<compiler meshdir="d{i}"/>' for i in range(5000)) + '<asset><model file="a.xml"/></asset>'),
        "names more than 2000 files or 10 folders",
    ),
    "model above": (hostile('<compiler meshdir=".."/><asset><model file="a.xml"/></asset>'), "leads out of the folder"),
    "mesh that is a link": (needed('<mesh name="m" file="x/secret.stl"/>'), "secret.stl' gives the mass of body 'b'"),
    "height field that has mass": (
        hostile(
            '<compiler settotalmass="3"/><asset><hfield name="h" nrow="2" ncol="2" size="1 1 1 1"/></asset><worldbody>'
            '<body name="hill"><geom type="hfield" hfield="h"/></body></worldbody>'
        ),
        "height field 'h' gives the mass of body 'hill'; give the body an <inertial>",
    ),
    "mesh elsewhere": (needed('<mesh name="m" file="/tmp/a.stl"/>'), "'/tmp/a.stl' gives the mass"),
    "mesh above": (needed('<mesh name="m" file="../secret.stl"/>'), "'../secret.stl' gives the mass"),
    "meshdir elsewhere": (needed('<mesh name="m" file="a.stl"/>', 'meshdir="/tmp"'), "'a.stl' gives the mass"),
    "drive": (needed('<mesh name="m" file="C:\\a.stl"/>'), "gives the mass"),
    "scheme": (needed('<mesh name="m" file="http://a/b.stl"/>'), "gives the mass"),
    "package above": (needed('<mesh name="m" file="package://../b.stl"/>'), "gives the mass"),
    "zero in a name": (needed('<mesh name="m" file="a&#1;b.stl"/>'), "no XML"),
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
    "large mass": (hostile("").replace('mass="1"', 'mass="1e200"'), "is beyond the largest magnitude 1e.60"),
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
    "mesh that takes minutes": (
        needed('<mesh name="m" builtin="supertorus" params="3000 1 1 1"/>'),
        "MuJoCo (takes more than|cannot read it|broke off)",
    ),
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
