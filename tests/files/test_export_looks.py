"""Shapes and velocities at the start in exported files: as MuJoCo has them, and as they are read back."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from helpers.exports import TREE_JOINTS, body, direction, random_tree, states_of
from helpers.mujoco_states import TOLERANCE
from helpers.mujoco_states import difference as from_mujoco

from mbsd3d import GROUND, Body, PointOnPlane, Revolute, State, System, read_mjcf, read_sdf, read_urdf, rotation, shapes
from mbsd3d.extend import matrix

pytestmark = pytest.mark.filterwarnings("ignore:.*(inactive|is fixed):UserWarning")

READ = {"mjcf": ("xml", read_mjcf), "urdf": ("urdf", read_urdf), "sdf": ("sdf", read_sdf)}
ROUNDING = 1e-14  # [m, 1] of poses through a quaternion or three angles


def made_of(*look):
    """A hinged body with looks, in a general place."""
    rng = np.random.default_rng(5)
    one = replace(body(rng, "one"), shape=list(look))
    return System([one], [Revolute(GROUND, one, at=rng.normal(size=3), axis=direction(rng), name="hinge")])


PLACE = {"at": (0.3, -0.2, 0.5), "orientation": rotation((1, 2, -1), 0.8), "colour": "#3366cc"}
AXIS = (0.4, -0.5, 0.7)
SOLIDS = {
    "box": shapes.Box((0.2, 0.3, 0.5), **PLACE),
    "sphere": shapes.Sphere(0.2, **PLACE),
    "cylinder": shapes.Cylinder(0.2, 0.7, AXIS, **PLACE),
    "disc": shapes.Disc(0.4, 0.1, AXIS, **PLACE),
    "capsule": shapes.Capsule(0.2, 0.7, AXIS, **PLACE),
    "ellipsoid": shapes.Ellipsoid((0.2, 0.3, 0.5), **PLACE),
    "torus": shapes.Torus(0.4, 0.1, AXIS, **PLACE),
    "hull": shapes.Hull(np.random.default_rng(2).normal(size=(12, 3)), **PLACE),
}
BY_MESH = {
    "mjcf": ("torus", "hull"),
    "urdf": ("capsule", "ellipsoid", "torus", "hull"),
    "sdf": ("torus", "hull"),
}


def surface_of(system):
    """Area, centroid and second moments of the drawn surface of the only body, in the world: what it looks like."""
    one = system.bodies[0]
    corners = one.shape[0].mesh(one).vertices[one.shape[0].mesh(one).faces] @ one.axes.T + one.position
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = 0.5 * np.linalg.norm(across, axis=1)
    middle = corners.mean(axis=1)
    return area.sum(), area @ middle / area.sum(), np.einsum("k,ki,kj->ij", area, middle, middle)


@pytest.mark.parametrize("kind", SOLIDS)
@pytest.mark.parametrize("fmt", READ)
def test_shapes_look_the_same_where_they_are_read_back(tmp_path, fmt, kind):
    """The triangles of a round body may be turned about its axis, which keeps its second moments to rounding."""
    system = made_of(SOLIDS[kind])
    suffix, read = READ[fmt]
    made = getattr(system, f"to_{fmt}")(tmp_path / f"model.{suffix}")
    found = read(made.path)
    assert found.missing == () and bool(made.meshes) == (kind in BY_MESH[fmt])
    assert sorted(x.name for x in tmp_path.iterdir()) == sorted([f"model.{suffix}", *made.meshes])
    assert found.system.bodies[0].shape[0].colour == "#3366cc"
    for mine, theirs in zip(surface_of(system), surface_of(found.system), strict=True):
        assert np.abs(mine - theirs).max() < 1e-12 * np.abs(mine).max()


def test_mujoco_draws_shapes_that_touch_nothing_and_weigh_nothing(tmp_path):
    several = [replace(shape, at=(0.1 * k, 0, 0)) for k, shape in enumerate(SOLIDS.values())]
    system = made_of(*several)
    made = system.to_mjcf(tmp_path / "model.xml")
    model = mujoco.MjModel.from_xml_path(str(made.path))
    assert model.ngeom == len(SOLIDS) and model.body_mass[1] == system.bodies[0].mass
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert data.ncon == 0
    one = system.bodies[0]
    for k, (kind, shape) in enumerate(zip(SOLIDS, several, strict=True)):
        if kind in BY_MESH["mjcf"]:  # MuJoCo has them about their own centres
            continue
        assert np.abs(data.geom_xpos[k] - (one.position + one.axes @ shape.at)).max() < ROUNDING
        R = one.axes @ matrix(shape.orientation)
        if kind in ("box", "ellipsoid"):
            assert np.abs(data.geom_xmat[k].reshape(3, 3) - R).max() < ROUNDING
        elif kind != "sphere":
            assert np.abs(data.geom_xmat[k].reshape(3, 3)[:, 2] - R @ AXIS / np.linalg.norm(AXIS)).max() < ROUNDING
    sizes = {"box": (0.1, 0.15, 0.25), "capsule": (0.2, 0.35, 0), "disc": (0.4, 0.05, 0), "ellipsoid": (0.2, 0.3, 0.5)}
    for kind, size in sizes.items():
        assert model.geom_size[list(SOLIDS).index(kind)] == pytest.approx(size)


@pytest.mark.parametrize("fmt", READ)
def test_a_mesh_is_written_beside_in_metres_and_once(tmp_path, fmt):
    """Two bodies with one mesh share its file, which stays where it is when a model is written again."""
    rows = ["v 0 0 0", "v 60 0 0", "v 0 50 0", "v 0 0 40", "f 1 3 2", "f 1 2 4", "f 1 4 3", "f 2 3 4"]
    (tmp_path / "corner.obj").write_text("\n".join(rows))
    mesh = shapes.MeshFile(tmp_path / "corner.obj", 1e-3, at=(0.1, 0.2, 0.3))
    bodies = [Body(f"strange / name {k}", 1.0, (0.1, 0.1, 0.1), shape=mesh) for k in range(2)]
    suffix, read = READ[fmt]
    folder = tmp_path / "out"
    folder.mkdir()
    write = getattr(System(bodies), f"to_{fmt}")
    made = write(folder / f"model.{suffix}")
    (name,) = made.meshes
    assert name.startswith("strange_name_0_") and (folder / name).read_text() == made.meshes[name]
    assert write(folder / f"model.{suffix}", replace=True).meshes == made.meshes == write().meshes
    found = read(made.path)
    for one in found.system.bodies:
        assert np.abs(one.shape[0].mesh(one).vertices.max(axis=0) - (0.16, 0.25, 0.34)).max() < ROUNDING


def test_what_cannot_be_drawn_is_said():
    lines = Body("lines", 1.0, (0.1, 0.1, 0.1), shape=[(0, 0, 0), (1, 0, 0)])
    gone = Body("gone", 1.0, (0.1, 0.1, 0.1), shape=shapes.MeshFile("nowhere.stl"))
    plain = Body("plain", 1.0, (0.1, 0.1, 0.1))
    for fmt in READ:
        made = getattr(System([lines, gone, plain]), f"to_{fmt}")()
        assert any("shape of 'lines' is not written: other programs draw no lines" in x for x in made.said)
        assert any("shape of 'gone' is not written: MeshFile 'nowhere.stl': cannot be read" in x for x in made.said)
        assert not any("'plain' is not" in x for x in made.said) and made.meshes == {}


# velocities at the start


def moving(system, seed):
    """The same system, whose bodies are given velocities that its joints allow."""
    start = system.state()
    v = np.random.default_rng(seed).normal(size=start.v.size)
    v = system.assemble(near=State(0.0, start.q, v)).v.reshape(-1, 6)
    bodies = {id(b): replace(b, velocity=x[:3], omega=x[3:]) for b, x in zip(system.bodies, v, strict=True)}
    joints = [replace(x, a=bodies.get(id(x.a), x.a), b=bodies.get(id(x.b), x.b)) for x in system.joints]
    return System(list(bodies.values()), joints)


@pytest.mark.parametrize("seed", range(6))
def test_velocities_at_the_start_are_a_key_frame_of_mujoco(tmp_path, seed):
    system = moving(random_tree(seed, TREE_JOINTS), seed)
    start = system.state()
    assert np.abs(start.v).max() > 0.1
    made = system.to_mjcf(tmp_path / "model.xml")
    model = mujoco.MjModel.from_xml_path(str(made.path))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    mujoco.mj_rnePostConstraint(model, data)
    scale = np.abs(start.v).max()
    for one, v in zip(system.bodies, start.v.reshape(-1, 6), strict=True):
        spin = np.zeros(6)
        number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, one.name)
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, number, spin, 0)
        assert np.abs(spin - [*v[3:], *v[:3]]).max() < TOLERANCE * scale
    assert from_mujoco(system, start, model, data) < TOLERANCE
    found = read_mjcf(made.path)
    assert set(found.states) == {"start"}
    there = {x.name: found.states["start"].v[6 * i : 6 * i + 6] for i, x in enumerate(found.system.bodies)}
    where = {x.name: start.v[6 * i : 6 * i + 6] for i, x in enumerate(system.bodies)}
    assert max(np.abs(there[name] - where[name]).max() for name in there) < TOLERANCE * scale


def test_velocities_of_a_loop_and_over_massless_bodies_are_a_key_frame(tmp_path):
    rng = np.random.default_rng(8)
    one, two, bare = body(rng, "one"), body(rng, "two"), Body("bare", 0.0, (0, 0, 0), position=rng.normal(size=3))
    at = rng.normal(size=(4, 3))
    joints = [
        Revolute(GROUND, one, at=at[0], axis=direction(rng), name="drive"),
        Revolute(one, bare, at=at[1], axis=direction(rng), name="first"),
        Revolute(bare, two, at=at[1] + 0.1, axis=direction(rng), name="second"),
        PointOnPlane(two, GROUND, at=at[3], normal=direction(rng), name="closing"),
    ]
    for system in (System([one, two, bare], joints[:3]), System([one, two, bare], joints)):
        start = moving(system, 5).state()
        made = moving(system, 5).to_mjcf(tmp_path / "model.xml", replace=True)
        found = read_mjcf(made.path)
        there = {x.name: found.states["start"].v[6 * i : 6 * i + 6] for i, x in enumerate(found.system.bodies)}
        where = {x.name: start.v[6 * i : 6 * i + 6] for i, x in enumerate(system.bodies)}
        scale = np.abs(start.v).max()
        assert max(np.abs(there[name] - where[name]).max() for name in ("one", "two")) < TOLERANCE * scale > 0.0


def test_velocities_at_the_start_are_a_state_of_a_world(tmp_path):
    system = moving(random_tree(3, ("Revolute", "Prismatic", "Spherical")), 3)
    start = system.state()
    found = read_sdf(system.to_sdf(tmp_path / "model.sdf").path)
    there = found.states["start"]
    order = [[x.name for x in system.bodies].index(x.name) for x in found.system.bodies]
    v = start.v.reshape(-1, 6)[order]
    assert np.abs(there.v.reshape(-1, 6) - v).max() < ROUNDING * np.abs(v).max()
    assert np.abs(there.q.reshape(-1, 7)[:, :3] - start.q.reshape(-1, 7)[order, :3]).max() < ROUNDING
    chain = moving(random_tree(4, ("Revolute", "Cylindrical")), 4).to_sdf(massless=True)
    assert "<state" not in chain.text and any("a state has none of links without mass" in x for x in chain.said)


def test_velocities_that_a_file_does_not_hold_are_said():
    system = moving(random_tree(2, ("Revolute", "Prismatic")), 2)
    assert "velocities at the start have no place in URDF" in system.to_urdf().said
    still = random_tree(2, ("Revolute", "Prismatic"))
    assert not any("velocities" in x for x in (*still.to_urdf().said, *still.to_mjcf().said, *still.to_sdf().said))
    assert "keyframe" not in still.to_mjcf().text and "<state" not in still.to_sdf().text
    bob = Body("bob", 1.0, (0.1, 0.1, 0.1), omega=(0, 0, 2.0))
    bent = System([bob], [Revolute(GROUND, bob, at=(0, 0, 0), axis=(0, 0, 1), axis_b=(0, 0.2, 1), name="hinge")])
    assert any("velocities at the start are not written" in x for x in bent.to_mjcf().said)


def test_a_wrong_velocity_would_show():
    system = moving(random_tree(1, TREE_JOINTS), 1)
    text = system.to_mjcf().text
    last = text.split('qvel="')[1].split('"')[0].split()[-1]
    assert text.count(last) == 1
    model, data, _ = next(states_of(system, text.replace(last, repr(float(last) + 1e-6)), 1))
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    mujoco.mj_rnePostConstraint(model, data)
    assert from_mujoco(system, system.state(), model, data) > TOLERANCE
