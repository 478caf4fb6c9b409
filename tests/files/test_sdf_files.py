"""SDF files that include others, masses that follow from geometry, what floats, and older versions."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mbsd3d import Fixed, accelerations, read_sdf

pytestmark = pytest.mark.filterwarnings("ignore:.*inactive:UserWarning")

MASS = "<inertial><mass>2</mass><inertia><ixx>0.3</ixx><iyy>0.4</iyy><izz>0.2</izz></inertia></inertial>"
HINGE = (
    '<joint name="j" type="revolute"><parent>base</parent><child>arm</child><axis><xyz>0.2 1 0.1</xyz></axis></joint>'
)
ARM = f"""<pose>9 9 9 0 0 0</pose><link name="base">{MASS}</link>
  <link name="arm"><pose>0 0.1 0.5 0.2 0 0.3</pose>{MASS}</link>{HINGE}
  <frame name="tip" attached_to="arm"><pose>0.1 -0.2 0.4 0.3 -0.5 0.7</pose></frame>"""


def sdf(path, body, version="1.9"):
    """A file; its folder is made."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f'<sdf version="{version}">{body}</sdf>')
    return path


def arm(folder, name="arm", body=ARM):
    """A folder that is a model, whose model.config names files of two versions."""
    sdf(folder / name / "old.sdf", "<model/>", "1.4")
    path = sdf(folder / name / "new.sdf", f'<model name="robot">{body}</model>')
    names = '<sdf version="1.4">old.sdf</sdf><sdf version="1.9">new.sdf</sdf>'
    (folder / name / "model.config").write_text(f"<model><name>n</name>{names}</model>")
    return path


def include(uri, more="", merge=""):
    """An <include>."""
    return f"<include{merge}><uri>{uri}</uri>{more}</include>"


MERGE = ' merge="true"'
POSE = "<pose>1 2 3 0.4 -0.3 0.9</pose>"
URIS = {
    "model://arm": "given", "package://arm/new.sdf": "given", "arm": "given", "model://near": "beside",
    "near": "beside", "near/new.sdf": "beside", "./near/../near": "beside", "file://{beside}/near/new.sdf": "beside",
    "../given/arm": "given",
}  # fmt: skip


@pytest.mark.parametrize("uri", URIS)
def test_models_are_included_from_where_files_may_be(tmp_path, uri):
    """The model of another file has the name and the pose that the including file gives, whatever its own are."""
    arm(tmp_path / "given")
    arm(tmp_path / "here", "near")
    body = include(uri.format(beside=tmp_path / "here"), f"<name>left</name>{POSE}")
    path = sdf(
        tmp_path / "here" / "world.sdf", f'<world name="w">{body}{include("near", "<name>right</name>")}</world>'
    )
    found = read_sdf(path, package_paths=[tmp_path / "given"])
    bodies = {body.name: body for body in found.system.bodies}
    assert list(bodies) == ["left::base", "left::arm", "right::base", "right::arm"]
    assert bodies["left::base"].position.tolist() == [1.0, 2.0, 3.0]
    assert bodies["right::base"].position.tolist() == [9.0, 9.0, 9.0]  # its own
    R = Rotation.from_euler("xyz", (0.4, -0.3, 0.9))
    assert np.abs(bodies["left::arm"].position - ((1, 2, 3) + R.apply((0, 0.1, 0.5)))).max() < 1e-14
    if URIS[uri] == "given":
        with pytest.raises(ValueError, match=r"line 1, <include>: model '.*' is not found .*; give the folder"):
            read_sdf(path)


def test_one_included_model_moves_as_if_it_were_written_out(tmp_path):
    arm(tmp_path)
    alone = read_sdf(sdf(tmp_path / "alone.sdf", f'<world name="w"><model name="robot">{ARM}</model></world>'))
    found = read_sdf(sdf(tmp_path / "world.sdf", f'<world name="w">{include("arm")}</world>'))
    a, b = (accelerations(x.system, x.system.assemble(rates={"j": 3.0})) for x in (alone, found))
    assert np.array_equal(a.acceleration("arm"), b.acceleration("arm")) and np.abs(a.alpha("arm")).max() > 0.1
    assert [x.name for x in found.system.bodies] == ["base", "arm"]


def test_the_frame_that_an_include_names_is_put_at_its_pose(tmp_path):
    arm(tmp_path)
    placed = include("arm", f"<placement_frame>tip</placement_frame>{POSE}")
    found = read_sdf(sdf(tmp_path / "m.sdf", f'<model name="m"><link name="l">{MASS}</link>{placed}</model>'))
    tip = found.points["robot::tip"]
    body = next(x for x in found.system.bodies if x.name == tip.body)
    assert np.abs(body.position + body.axes @ tip.position - (1, 2, 3)).max() < 1e-14
    R = Rotation.from_euler("xyz", (0.4, -0.3, 0.9)).as_matrix()
    assert np.abs(body.axes @ tip.axes - R).max() < 1e-14
    with pytest.raises(ValueError, match="<include>: has a <placement_frame> and no <pose> for it; give one"):
        read_sdf(
            sdf(
                tmp_path / "m.sdf",
                f'<model name="m">{include("arm", "<placement_frame>tip</placement_frame>")}</model>',
            )
        )


def test_a_merged_model_has_its_parts_in_the_model_around_it(tmp_path):
    """Names count there without a prefix, and poses from the place of the include."""
    arm(tmp_path)
    weld = '<joint name="w" type="fixed"><parent>mount</parent><child>base</child></joint>'
    ground = '<joint name="g" type="ball"><parent>world</parent><child>mount</child></joint>'
    body = f'<link name="mount">{MASS}</link>{include("arm", POSE, MERGE)}{weld}{ground}'
    found = read_sdf(sdf(tmp_path / "m.sdf", f'<model name="m">{body}</model>', "1.10"))
    assert [x.name for x in found.system.bodies] == ["mount", "arm"] and found.merged == {"base": "mount"}
    assert found.points["tip"].body == "arm" and found.system.check().mobility == 4
    R = Rotation.from_euler("xyz", (0.4, -0.3, 0.9))
    assert np.abs(found.system.bodies[1].position - ((1, 2, 3) + R.apply((0, 0.1, 0.5)))).max() < 1e-14
    still = body.replace(POSE, "<static>1</static>")
    with pytest.raises(ValueError, match="merges a model that it makes static; give <static> to the model around it"):
        read_sdf(sdf(tmp_path / "m.sdf", f'<model name="m">{still}</model>', "1.10"))
    twice = body.replace('name="mount"', 'name="arm"')
    with pytest.raises(ValueError, match="the name 'arm' another frame has"):
        read_sdf(sdf(tmp_path / "m.sdf", f'<model name="m">{twice}</model>', "1.10"))


def test_files_of_an_included_model_lie_beside_it(tmp_path):
    """Meshes are named from the file that names them, and errors name it too."""
    look = '<visual name="v"><geometry><mesh><uri>{}</uri></mesh></geometry></visual>'
    body = f'<link name="l">{MASS}{look.format("part.stl")}{look.format("model://arm/part.stl")}</link>'
    arm(tmp_path / "models", body=body)
    (tmp_path / "models" / "arm" / "part.stl").write_text(
        "solid s\n" + "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
        "endsolid s\n"
    )
    world = f'<world name="w">{include("model://arm")}</world>'
    found = read_sdf(sdf(tmp_path / "world.sdf", world), package_paths=[tmp_path / "models"])
    assert found.missing == () and len(found.system.bodies[0].shape) == 2
    arm(tmp_path / "models", body='\n<link name="l"><inertial><mass>x</mass></inertial></link>')
    with pytest.raises(ValueError, match=r"'.*world.sdf': 'arm/new.sdf', line 2, <mass>='x' is not a finite number"):
        read_sdf(tmp_path / "world.sdf", package_paths=[tmp_path / "models"])


def test_what_an_include_may_not_do_is_refused(tmp_path):
    arm(tmp_path / "in")
    secret = arm(tmp_path, "secret")
    sdf(tmp_path / "hidden" / "model.sdf", f'<model name="robot">{ARM}</model>')  # no folder says it is a package
    link = tmp_path / "in" / "linked"
    link.symlink_to(secret.parent)
    for uri in ("../secret", f"file://{secret}", str(secret), "model://../secret", "linked", "model://hidden", "", "/"):
        path = sdf(tmp_path / "in" / "world.sdf", f'<world name="w">{include(uri)}</world>')
        with pytest.raises(ValueError, match=r"<include>: model '.*' is not found in the folder of the file"):
            read_sdf(path)
    for uri, message in {
        "https://a.org/models/arm": "is not found",
        "arm/model.config": "is not found|lies elsewhere|is <model>",
    }.items():
        with pytest.raises(ValueError, match=message):
            read_sdf(sdf(tmp_path / "in" / "world.sdf", f'<world name="w">{include(uri)}{include("none")}</world>'))
    config = tmp_path / "in" / "arm" / "model.config"
    config.write_text('<model><sdf version="1.9">../../secret/new.sdf</sdf></model>')
    with pytest.raises(
        ValueError, match="<sdf>: '../../secret/new.sdf' lies elsewhere; put it beside the model.config"
    ):
        read_sdf(sdf(tmp_path / "in" / "world.sdf", f'<world name="w">{include("arm")}</world>'))


def test_models_that_are_missing_are_listed_and_left_out_on_request(tmp_path):
    """What is left out stands in the certificate of every run; joints to it are then refused."""
    arm(tmp_path)
    lost = "".join(include(f"https://a.org/models/m{k}") for k in range(7))
    path = sdf(tmp_path / "w.sdf", f'<world name="w">{lost}{include("arm")}</world>')
    message = (
        "line 1, <include>: model 'https://a.org/models/m0', .*m4' and 2 more is not found .*leave_out=.\"include\"."
    )
    with pytest.raises(ValueError, match=message):
        read_sdf(path)
    found = read_sdf(path, leave_out=["include"])
    assert found.dropped == tuple(f"include: model 'https://a.org/models/m{k}'" for k in range(7))
    assert found.system.notes[-1].startswith("left out: include: model 'https://a.org/models/m0';")
    joint = '<joint name="j" type="ball"><parent>m0::x</parent><child>robot::base</child></joint>'
    sdf(path, f'<world name="w">{include("none", "<name>m0</name>")}{include("arm")}{joint}</world>')
    with pytest.raises(ValueError, match="<parent>: 'm0::x' is in no model"):
        read_sdf(path, leave_out=["include"])


def test_circles_and_bombs_of_includes_are_refused(tmp_path):
    for name, other in ("ab", "ba"):
        sdf(tmp_path / name / "model.sdf", f'<model name="{name}">{include(f"../{other}")}</model>')
    with pytest.raises(ValueError, match="<include>: '../a' includes itself; cut the circle"):
        read_sdf(tmp_path / "a" / "model.sdf", package_paths=[tmp_path])
    for k in range(30):
        twice = "".join(include(f"../m{k + 1}", f"<name>{x}</name>") for x in "ab")
        sdf(tmp_path / f"m{k}" / "model.sdf", f'<model name="m">{twice if k < 29 else "<link/>"}</model>')
    with pytest.raises(ValueError, match="more than 20000 elements are included; use fewer"):
        read_sdf(tmp_path / "m0" / "model.sdf", package_paths=[tmp_path])


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (include("light"), ""),
        (include("two"), "'two' holds 2 models; include a file of one"),
        (include("arm", '<experimental:params><link name="base"/></experimental:params>'), "changes the model where"),
        (include("old"), "'old/model.sdf', line 1, <sdf>: version 1.2 is older than 1.4"),
        (include("robot"), "its root is <robot>, not <sdf>"),
        ('<population name="p"/>', "its models are made where it runs; write them out"),
    ],
)
def test_what_is_no_single_model_is_said(tmp_path, more, message):
    arm(tmp_path)
    sdf(tmp_path / "light" / "model.sdf", '<light name="sun" type="point"/>')
    sdf(tmp_path / "two" / "model.sdf", '<model name="a"/><model name="b"/>')
    sdf(tmp_path / "old" / "model.sdf", '<model name="a"/>', "1.2")
    (tmp_path / "robot").mkdir()
    (tmp_path / "robot" / "model.sdf").write_text("<robot/>")
    path = sdf(tmp_path / "w.sdf", f'<world name="w">{include("arm")}{more}</world>')
    if not message:
        assert read_sdf(path).idle["light"] == 1
        return
    with pytest.raises(ValueError, match=message):
        read_sdf(path)


def test_an_include_may_make_a_model_static(tmp_path):
    arm(tmp_path)
    body = include("arm", "<static>true</static>") + include("arm", "<name>other</name>")
    found = read_sdf(sdf(tmp_path / "w.sdf", f'<world name="w">{body}</world>'))
    assert [x.name for x in found.system.bodies] == ["other::base", "other::arm"]


# mass by geometry


def of_revolution(radius, low, high, density, count=80):
    """Mass, centre of mass along z, and moments (across, along) about it of a body of revolution, by Gauss' rule."""
    x, w = np.polynomial.legendre.leggauss(count)
    z, w = 0.5 * (high - low) * x + 0.5 * (high + low), 0.5 * (high - low) * w
    r = radius(z)
    m = density * np.sum(w * np.pi * r**2)
    com = density * np.sum(w * np.pi * r**2 * z) / m
    across = density * np.sum(w * (np.pi * r**4 / 4 + np.pi * r**2 * z**2)) - m * com**2
    return m, com, across, density * np.sum(w * np.pi * r**4 / 2)


def solids():
    """Kind -> element, and mass, centre of mass and inertia of density 1 by integration."""
    r, l = 0.3, 0.8
    found = {}
    rod = of_revolution(lambda z: r + 0 * z, -l / 2, l / 2, 1.0)
    tip = of_revolution(lambda z: r * (0.5 - z / l), -l / 2, l / 2, 1.0)
    ball = of_revolution(lambda z: np.sqrt(r**2 - z**2), -r, r, 1.0)
    caps = of_revolution(lambda z: np.sqrt(r**2 - (z - l / 2) ** 2), l / 2, l / 2 + r, 1.0)
    m = rod[0] + 2 * caps[0]
    both = (m, 0.0, rod[2] + 2 * (caps[2] + caps[0] * caps[1] ** 2), rod[3] + 2 * caps[3])
    sizes = f"<radius>{r}</radius><length>{l}</length>"
    for kind, (m, com, across, along), text in (
        ("cylinder", rod, sizes), ("cone", tip, sizes), ("capsule", both, sizes), ("sphere", ball, sizes),
    ):  # fmt: skip
        found[kind] = f"<{kind}>{text}</{kind}>", m, np.array([0, 0, com]), np.diag([across, across, along])
    a = np.array([0.2, 0.5, 0.9])
    m, I = np.prod(a), np.prod(a) / 12 * np.diag([a[1] ** 2 + a[2] ** 2, a[0] ** 2 + a[2] ** 2, a[0] ** 2 + a[1] ** 2])
    found["box"] = "<box><size>0.2 0.5 0.9</size></box>", m, np.zeros(3), I
    unit = of_revolution(lambda z: np.sqrt(1 - z**2), -1, 1, 1.0)
    squares = np.prod(a) * 0.5 * unit[3] * a**2  # int x^2 dV of the unit ball is half of its moment; stretched
    I = np.diag(squares.sum() - squares)
    found["ellipsoid"] = "<ellipsoid><radii>0.2 0.5 0.9</radii></ellipsoid>", np.prod(a) * unit[0], np.zeros(3), I
    m, C = np.prod(a) / 6, np.outer(a, a) * np.prod(a) * (1 + np.eye(3)) / 120  # corner at the origin; int x x' dV
    com = a / 4 * (1, -1, 1)
    C = C * np.outer((1, -1, 1), (1, -1, 1)) - m * np.outer(com, com)
    scale = "<mesh><uri>corner.obj</uri><scale>0.2 -0.5 0.9</scale></mesh>"
    found["mesh"] = scale, m, com, np.trace(C) * np.eye(3) - C
    return found


def corner(folder):
    """The mesh of the tetrahedron between the origin and the unit points."""
    rows = ["v 0 0 0", "v 1 0 0", "v 0 1 0", "v 0 0 1", "f 1 3 2", "f 1 2 4", "f 1 4 3", "f 2 3 4"]
    (folder / "corner.obj").write_text("\n".join(rows))


FIFTY = '<inertial auto="TRUE"><density>50</density></inertial>'


@pytest.mark.parametrize("kind", list(solids()))
def test_the_mass_of_a_link_is_that_of_its_geometry(tmp_path, kind):
    """Gauss' rule of 80 points and closed forms of a tetrahedron: a few units in the last place of square roots."""
    corner(tmp_path)
    text, m, com, I = solids()[kind]
    auto = f'<inertial auto="true"><density>700</density></inertial><collision name="c"><geometry>{text}</geometry>'
    body = read_sdf(
        sdf(tmp_path / "m.sdf", f'<model name="m"><link name="l">{auto}</collision></link></model>')
    ).system.bodies[0]
    assert body.mass == pytest.approx(700 * m, rel=1e-13)
    assert np.abs(body.com - com).max() < 1e-13
    assert np.abs(body.inertia - 700 * I).max() < 1e-13 * 700 * np.abs(I).max()


def test_several_parts_add_up_at_their_poses(tmp_path):
    """Densities of a part, of the link, of water; poses in named frames; a mass that is given scales the whole."""
    corner(tmp_path)
    rng = np.random.default_rng(8)
    poses, angles = rng.normal(size=(4, 3)), rng.uniform(-3, 3, (4, 3))
    where = [
        f"{' '.join(map(repr, r.tolist()))} {' '.join(map(repr, a.tolist()))}"
        for r, a in zip(poses, angles, strict=True)
    ]
    kinds = ("box", "cone", "mesh")
    turns = [Rotation.from_euler("xyz", a) for a in angles]

    def model(inertial, densities):
        parts = "".join(
            f'<collision name="{kind}"><pose{" relative_to=" + repr("f") if kind == "mesh" else ""}>{where[k]}</pose>'
            f"<geometry>{solids()[kind][0]}</geometry>{densities[k]}</collision>"
            for k, kind in enumerate(kinds)
        )
        frame = f'<frame name="f" attached_to="l"><pose>{where[3]}</pose></frame>'
        text = f'<model name="m"><link name="l"><pose>1 2 3 0.3 0.2 0.1</pose>{inertial}{parts}</link>{frame}</model>'
        return read_sdf(sdf(tmp_path / "m.sdf", text)).system.bodies[0]

    def wanted(densities):
        m, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
        for k, kind in enumerate(kinds):
            _, volume, com, I = solids()[kind]
            r, R = poses[k], turns[k]
            if kind == "mesh":
                r, R = poses[3] + turns[3].apply(r), turns[3] * R
            c, I = r + R.apply(com), R.as_matrix() @ I @ R.as_matrix().T
            m, first = m + densities[k] * volume, first + densities[k] * volume * c
            second += densities[k] * (I + volume * (c @ c * np.eye(3) - np.outer(c, c)))
        com = first / m
        return m, com, second - m * (com @ com * np.eye(3) - np.outer(com, com))

    for inertial, tags, densities, share in (
        ('<inertial auto="true"/>', ("", "<density>300</density>", ""), (1000, 300, 1000), 1.0),
        (FIFTY, ("", "<density>300</density>", ""), (50, 300, 50), 1.0),
        ('<inertial auto="true"><mass>5</mass></inertial>', ("", "", ""), (1000, 1000, 1000), 5.0),
    ):
        body, (m, com, I) = model(inertial, tags), wanted(densities)
        share = share / m if share != 1.0 else 1.0
        assert body.mass == pytest.approx(share * m, rel=1e-13)
        assert np.abs(body.com - com).max() < 1e-12
        assert np.abs(body.inertia - share * I).max() < 1e-12 * share * np.abs(I).max()


@pytest.mark.parametrize(
    ("shape", "message"),
    [
        ("<plane/>", "<plane>: is not a solid; give box, sphere"),
        ("<box><size>1 0 1</size></box>", "<box>: a size is not positive"),
        ("<mesh><uri>none.stl</uri></mesh>", "mesh 'none.stl', which gives the mass of link 'l', is not found"),
        ("<mesh><uri>open.obj</uri></mesh>", "mesh 'open.obj', which gives the mass of link 'l': is open"),
        ("<mesh><uri>a.dae</uri></mesh>", "mesh 'a.dae'.* is not a mesh; give one that ends in"),
        ("<mesh><uri>corner.obj</uri><submesh><name>a</name></submesh></mesh>", "by a part of it"),
        ("", "<collision>: has no <geometry> with a shape"),
    ],
)
def test_geometry_that_gives_no_mass_is_refused(tmp_path, shape, message):
    corner(tmp_path)
    (tmp_path / "open.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (tmp_path / "a.dae").write_text("<COLLADA/>")
    auto = f'<inertial auto="true"/><collision name="c"><geometry>{shape}</geometry></collision>'
    with pytest.raises(ValueError, match=message):
        read_sdf(sdf(tmp_path / "m.sdf", f'<model name="m"><link name="l">{auto}</link></model>'))


# what floats


def test_what_nothing_holds_floats_or_is_fixed(tmp_path):
    path = sdf(tmp_path / "m.sdf", f'<model name="m">{ARM}</model>')
    found = read_sdf(path)
    assert found.said[1:] == ("base floats; floating=False fixes, floating=True says so",)
    assert found.system.check().mobility == 7
    assert read_sdf(path, floating=True).said[1:] == () and read_sdf(path, floating=True).system.check().mobility == 7
    fixed = read_sdf(path, floating=False)
    assert fixed.said[1:] == ("fixed: base",) and fixed.system.check().mobility == 1
    assert fixed.merged == {"base": "ground"}


def test_a_model_that_the_world_holds_cannot_float(tmp_path):
    held = '<joint name="w" type="ball"><parent>world</parent><child>base</child></joint>'
    path = sdf(tmp_path / "m.sdf", f'<model name="m">{ARM}{held}</model>')
    assert read_sdf(path, floating=False).system.check().mobility == 4  # nothing to fix
    with pytest.raises(ValueError, match="floating=True: static models or joints hold all links to the world"):
        read_sdf(path, floating=True)
    with pytest.raises(ValueError, match="floating"):
        read_sdf(path, floating="yes")


# older versions


@pytest.mark.parametrize(
    ("version", "more", "in_model"),
    [("1.4", "", True), ("1.5", "", False), ("1.6", "<use_parent_model_frame>1</use_parent_model_frame>", True),
     ("1.6", "<use_parent_model_frame>0</use_parent_model_frame>", False), ("1.9", "", False)],
)  # fmt: skip
def test_axes_of_older_versions_are_in_their_frames(tmp_path, version, more, in_model):
    place = "<pose>0 0 1 0.4 -0.3 0.9</pose>"
    ends = "<parent>world</parent><child>l</child>"
    hinge = f'<joint name="j" type="revolute">{ends}<axis><xyz>1 0 0</xyz>{more}</axis></joint>'
    gravity = "<physics><gravity>0 0 -3</gravity></physics>"
    model = f'<model name="m"><pose>0 0 0 0 0 0.5</pose><link name="l">{place}{MASS}</link>{hinge}</model>'
    body = f'<world name="w">{gravity}{model}</world>'
    found = read_sdf(sdf(tmp_path / "m.sdf", body, version)).system
    model = Rotation.from_euler("xyz", (0, 0, 0.5))
    wanted = (model if in_model else model * Rotation.from_euler("xyz", (0.4, -0.3, 0.9))).apply((1, 0, 0))
    assert np.abs(found.joints[0].axis - wanted).max() < 1e-15
    assert found.gravity[2] == (-9.8 if version == "1.9" else -3.0) and not isinstance(found.joints[0], Fixed)


def test_poses_of_older_versions_name_their_frame(tmp_path):
    body = f'<link name="a"><pose>0 0 1 0 0 0</pose>{MASS}</link>'
    body += f'<link name="b"><pose frame="a">0 0 2 0 0 0</pose>{MASS}</link>'
    found = read_sdf(sdf(tmp_path / "m.sdf", f'<model name="m">{body}</model>', "1.6")).system
    assert found.bodies[1].position.tolist() == [0.0, 0.0, 3.0]


def test_a_joint_of_older_versions_may_have_the_name_of_a_link(tmp_path):
    joint = '<joint name="arm" type="ball"><parent>base</parent><child>arm</child></joint>'
    body = f'<link name="base">{MASS}</link><link name="arm">{MASS}</link>{joint}'
    found = read_sdf(sdf(tmp_path / "m.sdf", f'<model name="m">{body}</model>', "1.6"))
    assert found.system.joints[0].name == "arm (joint)"
    assert "joint 'arm' is named 'arm (joint)', as a link has its name" in found.said
    with pytest.raises(ValueError, match="the name 'arm' another frame has"):
        read_sdf(sdf(tmp_path / "m.sdf", f'<model name="m">{body}</model>', "1.7"))


# what other readers pass over


def test_comments_stand_before_the_head_and_hold_what_they_like(tmp_path):
    head = "<!-- a licence -- of\ntwo lines -->\n<?xml version='1.0'?>\n"
    (tmp_path / "m.sdf").write_text(f'{head}<sdf version="1.9"><model name="m"><!-- -p 1 --x -->{ARM}</model></sdf>')
    assert len(read_sdf(tmp_path / "m.sdf").system.bodies) == 2
    (tmp_path / "m.sdf").write_text(f'{head}<sdf version="1.9"><model name="m"><!-- -->\n<link/></model></sdf>')
    with pytest.raises(ValueError, match="line 5, <link>: has no name"):
        read_sdf(tmp_path / "m.sdf")
    link = '<link name="a"><inertial><mass><![CDATA[<!-- 3 -->]]></mass></inertial></link>'
    with pytest.raises(ValueError, match="<mass>='<!-- 3 -->' is not a finite number"):
        read_sdf(sdf(tmp_path / "m.sdf", f'<model name="m">{link}</model>'))


@pytest.mark.parametrize(("text", "upper"), [("1.79769e+308", None), ("1e16", None), ("inf", None), ("3e2", 300.0)])
def test_limits_beyond_all_magnitudes_are_none(tmp_path, text, upper):
    limit = f"<limit><lower>-1</lower><upper>{text}</upper></limit></axis>"
    path = sdf(tmp_path / "m.sdf", f'<model name="m">{ARM.replace("</axis>", limit)}</model>')
    (found,) = read_sdf(path).system.limits
    assert (found.lower, found.upper) == (-1.0, upper)
    heavy = ARM.replace("<mass>2</mass>", "<mass>1e300</mass>")
    with pytest.raises(ValueError, match="inf kg; give a finite mass"):
        read_sdf(sdf(tmp_path / "m.sdf", f'<model name="m">{heavy}</model>'))


def test_a_file_in_which_nothing_can_move_is_refused(tmp_path):
    path = sdf(tmp_path / "m.sdf", f'<model name="m"><static>true</static>{ARM}</model>')
    with pytest.raises(ValueError, match="static models or fixed joints hold all links to the world, and nothing can"):
        read_sdf(path)
