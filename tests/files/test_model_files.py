"""Model files: every part comes back to the last bit, people can write them, what is no model is refused at once."""

import errno
import json
import os
import re

import numpy as np
import pytest
from click.testing import CliRunner
from helpers.forces import EXAMPLES as FORCES
from helpers.forces import LOCKS
from helpers.models import EXAMPLES, all_joints_mechanism, direction, example_system, random_body
from helpers.refused_models import FORMS, HOSTILE, check_refused

import mbsd3d
from mbsd3d import (
    GROUND,
    AeroDrag,
    Body,
    Constant,
    Cylindrical,
    Force,
    Input,
    Joint,
    Polynomial,
    Prismatic,
    Pulse,
    Ramp,
    Revolute,
    Signal,
    Sine,
    StateFeedback,
    System,
    Table,
    Torque,
    TorsionSpring,
    measures,
    simulate,
)
from mbsd3d.extend import ForceElement, compile_system, main
from mbsd3d.files.description import describe
from mbsd3d.files.schema import types
from mbsd3d.signals import Scaled, Sum

TABLE = Table([0.0, 0.13, 0.31, 0.7, 1.1], [0.2, -0.4, 0.3, 0.1, 0.7])
SIGNALS = (Constant(0.7), Ramp(0.3, -0.2), Sine(0.4, 1.3, 0.2, 0.1), Polynomial((0.3, -0.1, 0.7)), TABLE)
SIGNALS += (Sum((TABLE, Sine(0.1, 2.3))), Scaled(Ramp(0.3), -1.7), Pulse(0.3, 0.1, 0.2, 0.7), Input("wind", 0.4))


def all_signals(rng):
    """Bodies with velocities and a shape, on hinge and rail, under loads by every signal and a controller."""
    one, two = random_body(rng, "one"), random_body(rng, "two")
    three = random_body(rng, "three", velocity=rng.normal(size=3), omega=rng.normal(size=3), shape="box")
    hinge = Cylindrical(GROUND, one, at=one.position + 0.1, axis=direction(rng), name="hinge")
    rail = Prismatic(one, two, at=two.position - 0.2, axis=direction(rng))
    a, b, c, d, e, f, g, h, i = SIGNALS
    seen = [measures.angle(hinge), measures.velocity(two, axis=direction(rng), at=rng.normal(size=3))]
    forces = [
        Force(one, (a, b, c), at=rng.normal(size=3), frame="body"),
        Torque(two, (d, e, f), name="torque"),
        AeroDrag(two, drag_area=0.3, density=1.1, at=rng.normal(size=3), wind=(g, h, i)),
        StateFeedback(measures=seen, gains=(3.0, 0.4), on=hinge, reference=(0.1, 0.2), time_constant=0.05),
    ]
    return System([one, two, three], [hinge, rail], forces, gravity=(0.4, -0.8, -9.6))


def under(name, seed):
    """Two general bodies with a force element."""
    rng = np.random.default_rng(seed)
    bodies = [random_body(rng, "one"), random_body(rng, "two")]
    joints, force = FORCES[name](rng, *bodies)
    return System(bodies, joints, [force], gravity=(0.4, -0.8, -9.6))


def same_bits(first, second):
    """Equal shapes, types and bytes."""
    first, second = np.asarray(first), np.asarray(second)
    return first.shape == second.shape and first.dtype == second.dtype and first.tobytes() == second.tobytes()


def assert_same_model(first, second):
    """All compiled arrays equal, to the last bit."""
    models = compile_system(first).model, compile_system(second).model
    for name, a, b in zip(models[0]._fields, *models, strict=True):
        assert same_bits(a, b), name
    assert [body.shape for body in first.bodies] == [body.shape for body in second.bodies]


def round_trip(system, folder, form):
    """The system through a file."""
    return System.from_file(system.to_file(folder / f"model{form}"))


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("kind", EXAMPLES)
def test_every_joint_comes_back(tmp_path, kind, form):
    for seed in range(2):
        system = example_system(kind, seed)
        copy = round_trip(system, tmp_path, form)
        assert_same_model(system, copy)
        assert [type(joint) for joint in copy.joints] == [type(joint) for joint in system.joints]
        (tmp_path / f"model{form}").unlink()


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", [name for name in FORCES if name != "CustomForce"])  # it holds a function
def test_every_force_comes_back(tmp_path, name, form):
    for seed in range(2):
        system = under(name, seed)
        copy = round_trip(system, tmp_path, form)
        assert_same_model(system, copy)
        assert list(copy.names.values()) == list(system.names.values())
        (tmp_path / f"model{form}").unlink()


@pytest.mark.parametrize("form", FORMS)
def test_every_signal_comes_back(tmp_path, form):
    for seed in range(5):
        system = all_signals(np.random.default_rng(seed))
        copy = round_trip(system, tmp_path, form)
        assert_same_model(system, copy)
        assert "torque" in copy.names.values() and list(copy.names.values()) == list(system.names.values())
        (tmp_path / f"model{form}").unlink()


def test_no_part_is_forgotten():
    covered = {*EXAMPLES, *(type(under(name, 1).forces[0]) for name in FORCES), *map(type, SIGNALS)} | set(LOCKS)
    wanted = {kind for kind in types().values() if issubclass(kind, Joint | ForceElement | Signal)}
    assert {kind.__name__ for kind in wanted - covered} == {"SavedForce"}  # which has lost its function


@pytest.mark.parametrize("build", [all_joints_mechanism, lambda seed: all_signals(np.random.default_rng(seed))])
def test_simulations_are_equal_to_the_last_bit(tmp_path, build):
    system = build(3)
    runs = [simulate(x, 0.02, output=5) for x in (system, round_trip(system, tmp_path, ".json"))]
    runs.append(simulate(round_trip(system, tmp_path, ".toml"), 0.02, output=5))
    for name, array in runs[0].arrays.items():
        assert all(same_bits(array, run.arrays[name]) for run in runs[1:]), name


@pytest.mark.parametrize("form", FORMS)
def test_extreme_numbers_and_names_come_back(tmp_path, form):
    numbers = (5e-324, -0.0, 9.999999999999999e59)
    names = ("q\"uo'te", "ünï😀", "می\u200cخواهم", "back\\slash", "a.b", 'x"', "#", " ", "[a]", "''")
    bodies = [Body(name, 1.0, (1, 1, 1), position=numbers) for name in names]
    copy = round_trip(System(bodies, [Revolute(GROUND, bodies[1], at=(0, 0, 0), axis=(0, 0, 1))]), tmp_path, form)
    assert [body.name for body in copy.bodies] == list(names) and copy.joints[0].b is copy.bodies[1]
    assert all(same_bits(body.position, np.array(numbers)) for body in copy.bodies)


def test_files_are_short_and_read_like_the_call(tmp_path):
    bob = Body("bob", mass=1.5, inertia=(0.1, 0.1, 0.02), position=(0, 0, -0.5))
    hinge = Revolute(GROUND, bob, at=(0, 0, 0), axis=(0, 1, 0), name="hinge")
    system = System([bob], [hinge], [TorsionSpring(hinge, stiffness=2.0)])
    data = json.loads(system.to_file(tmp_path / "a.json").read_text())
    assert data["joints"] == [
        {"type": "Revolute", "name": "hinge", "a": "ground", "b": "bob", "at": [0.0, 0.0, 0.0], "axis": [0.0, 1.0, 0.0]}
    ]
    assert data["forces"] == [{"type": "TorsionSpring", "hinge": "hinge", "stiffness": 2.0}]
    text = system.to_file(tmp_path / "a.toml").read_text()
    assert '[[joints]]\ntype = "Revolute"\nname = "hinge"\na = "ground"\nb = "bob"\nat = [0.0, 0.0, 0.0]\n' in text


FILTERED = """
[[forces]]
type = "StateFeedback"
on = "Revolute 1"
gains = [3.0]
[[forces.measures]]
type = "Measure"
kind = "coordinate rate"
label = "spin"
unit = "rad/s"
coordinate = {type = "Coordinate", kind = "angle", a = "ground", b = "bob", axis = [0, 1, 0], axis_b = [0, 1, 0]}
"""


HAND = """
format = "mbsd3d system"
version = 2
gravity = [0, 0, -9.81]

[[bodies]]
name = "bob"
mass = 2
inertia = [0.1, 0.1, 0.02]
position = [0, 0, -0.5]

[[joints]]
type = "Revolute"
a = "ground"
b = "bob"
at = [0, 0, 0]
axis = [0, 2, 0]

[[joints]]
type = "AngleDriver"
hinge = "Revolute 1"
signal = {type = "Sine", amplitude = 0.3, frequency = 1}
"""


@pytest.fixture
def hand(tmp_path):
    """A model written by hand."""
    path = tmp_path / "hand.toml"
    path.write_text(HAND)
    return path


def test_a_model_written_by_hand(hand):
    system = System.from_file(hand)
    assert system.check().mobility == 0 and system.joints[1].hinge is system.joints[0]
    assert system.joints[0].axis.tolist() == [0, 1, 0] and system.bodies[0].mass == 2.0


def test_files_are_not_replaced_unless_asked(hand):
    system = System.from_file(hand)
    with pytest.raises(ValueError, match="hand.toml' exists; give replace=True"):
        system.to_file(hand)
    assert hand.read_text() == HAND
    system.to_file(hand, replace=True)
    assert_same_model(System.from_file(hand), system) and hand.read_text() != HAND


def test_a_full_disk_leaves_the_old_file(hand, monkeypatch):
    def full(handle):
        raise OSError(errno.ENOSPC, "No space left on device")

    system = System.from_file(hand)
    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(ValueError, match="hand.toml' cannot be written: No space left"):
        system.to_file(hand, replace=True)
    assert hand.read_text() == HAND and [path.name for path in hand.parent.iterdir()] == ["hand.toml"]


def test_functions_are_refused_by_name(tmp_path):
    class Own(Force):
        pass

    body = Body("box", 1.0, (1, 1, 1))
    with pytest.raises(ValueError, match="Own 'push'.*no functions and no classes of your own"):
        System([body], forces=[Own(body, (1, 2, 3), name="push")]).to_file(tmp_path / "a.json")
    hinge = Revolute(GROUND, body, at=(0, 0, 0), axis=(0, 0, 1))
    spring = TorsionSpring(hinge, stiffness=2.0, name="push")
    object.__setattr__(spring, "stiffness", lambda angle: angle)  # stands for any field that holds a function
    with pytest.raises(ValueError, match="TorsionSpring 'push': stiffness: a function cannot be written to a file"):
        System([body], [hinge], [spring]).to_file(tmp_path / "a.json")
    assert not list(tmp_path.iterdir())


def test_forces_by_a_function_are_kept_in_solutions_only(tmp_path):
    body = Body("box", 1.0, (1, 1, 1))
    push = Force(body, (1, 2, 3))
    object.__setattr__(push, "saved", lambda: Torque(body, (0.0, 0.0, 0.1)))  # as a CustomForce does
    system = System([body], forces=[push])
    with pytest.raises(ValueError, match="Force 'Force 1': its function cannot be written to a file"):
        system.to_file(tmp_path / "a.json")
    entry = describe(system, without_functions=True)["forces"][0]
    assert entry["type"] == "Torque" and entry["name"] == "Force 1"  # the name by which results are asked for


@pytest.mark.parametrize("name", ["model.yaml", "model", "model.npz"])
def test_other_suffixes_are_refused(tmp_path, name):
    with pytest.raises(ValueError, match=f"{name}': a model file ends in .json or .toml"):
        System([Body("box", 1.0, (1, 1, 1))]).to_file(tmp_path / name)
    with pytest.raises(ValueError, match=f"{name}': a model file ends in .json or .toml"):
        System.from_file(tmp_path / name)


def edit(**changes):
    """HAND with some texts replaced."""
    text = HAND
    for old, new in changes.values():
        assert old in text
        text = text.replace(old, new)
    return text


MISTAKES = [
    ("mass = 2", 'mass = "2"', r"Body 'bob': Expected `float`, got `str` - at `\$.bodies\[0\].mass`"),
    ("mass = 2", "mass = -2", r"body 'bob': mass: -2.0 is below 0.0.* - at `\$.bodies\[0\]`"),
    ("mass = 2", "mass = nan", r"nan is not finite - at `\$.bodies\[0\].mass`"),
    ("mass = 2", "mass = true", r"Expected `float`, got `bool` - at `\$.bodies\[0\].mass`"),
    ("mass = 2", "mass = 1" + "0" * 400, r"Number out of range - at `\$.bodies\[0\].mass`"),
    ("mass = 2", "mass = 1e999", r"inf is not finite - at `\$.bodies\[0\].mass`"),
    ("mass = 2", "mass = 2\nmas = 3", r"unknown field `mas` - at `\$.bodies\[0\]`; give name, mass"),
    ("mass = 2\n", "", r"missing required field `mass` - at `\$.bodies\[0\]`"),
    ("mass = 2", "mass = 2\nmass = 3", "line 9"),
    ("mass = 2", "mass = ", "line 8"),
    (
        "mass = 2",
        "mass = 2\nshape = {type = 'Lines', points = 2020-01-01}",
        r"not understood - at `\$.bodies\[0\].shape.points`",
    ),
    ("mass = 2", 'mass = {type = "None"}', r"Expected `float`, got `null` - at `\$.bodies\[0\].mass`"),
    ("-0.5]", "-0.5, 1]", r"Expected `array` of length <= 3 - at `\$.bodies\[0\].position`"),
    ("-0.5]", "inf]", r"inf is not finite - at `\$.bodies\[0\].position\[2\]`"),
    ('"ground"', '"Ground"', r"there is no body 'Ground' - at `\$.joints\[0\].a`; there are 'ground', 'bob'"),
    ('"Revolute 1"', '"Revolute 2"', r"there is no joint 'Revolute 2' - at `\$.joints\[1\].hinge`"),
    ('"Revolute 1"', '"bob"', r"there is no joint 'bob' - at `\$.joints\[1\].hinge`"),
    ('"Revolute"', '"Revolut"', r"type 'Revolut' is unknown - at `\$.joints\[0\]`; give one of AngleDriver"),
    ('"Revolute"', '"Body"', r"type 'Body' is unknown - at `\$.joints\[0\]`"),
    ('type = "Revolute"\n', "", r"type None is unknown - at `\$.joints\[0\]`"),
    ('"Sine"', '"os.system"', r"type 'os.system' is unknown - at `\$.joints\[1\].signal`"),
    (
        '"Sine", amplitude = 0.3, frequency = 1',
        '"Body", name = "a"',
        "type 'Body' is unknown.*give one of Constant, Input, Poly",
    ),
    ("frequency = 1", "frequency = []", r"Sine: Expected `float`, got `array` - at `\$.joints\[1\].signal.frequency`"),
    ("version = 2", "version = 3", "version 3 of the format - at `.*reads 2"),
    ("version = 2\n", "", "version None"),
    ('format = "mbsd3d system"', "", 'is no mbsd3d system; its first entry must be format: "mbsd3d system"'),
    ("gravity = [0, 0, -9.81]\n", "", "missing required field `gravity`"),
    ('type = "AngleDriver"', 'type = "AngleDriver"\nname = "bob"', "two parts are named 'bob'"),
    ("axis = [0, 2, 0]", "axis = [0, 0, 0]", r"axis has zero length; give a direction - at `\$.joints\[0\]`"),
    ("version = 2", 'version = 2\nnote = """\n"""', "texts of several lines"),
    ("version = 2", "version = 2\na" + ".a" * 100 + " = 1", "line 4 has more than 32 dots in one name"),
]


@pytest.mark.parametrize(("old", "new", "message"), MISTAKES)
def test_mistakes_are_named_with_their_place(hand, old, new, message):
    hand.write_text(edit(change=(old, new)))
    with pytest.raises(ValueError, match=rf"hand.toml': (?s:.*){message}"):
        System.from_file(hand)


def test_kinds_are_words(hand):
    hand.write_text(HAND + FILTERED)
    seen = System.from_file(hand).forces[0].measures[0]
    assert (seen.kind, seen.coordinate.kind) == ("coordinate rate", "angle")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            '"coordinate rate"',
            '"speed"',
            "Measure: kind 'speed' is unknown; give one of 'coordinate', 'coordinate rate'",
        ),
        ('"angle"', '"turn"', "Coordinate: kind 'turn' is unknown; give one of 'angle', 'slide'"),
        ('"coordinate rate"', "1", "Expected `str`, got `int`"),
    ],
)
def test_other_kinds_are_refused_with_their_place(hand, old, new, message):
    hand.write_text(HAND + FILTERED.replace(old, new))
    with pytest.raises(ValueError, match=rf"hand.toml': (?s:.*){message}.* - at `\$.forces\[0\].measures\[0\]"):
        System.from_file(hand)


def test_keys_that_stand_twice_are_refused_in_json(tmp_path):
    path = tmp_path / "a.json"
    path.write_text('{"format": "mbsd3d system", "format": "mbsd3d system"}')
    with pytest.raises(ValueError, match="a.json': key 'format' appears twice"):
        System.from_file(path)


LARGE = ("many numbers", "tables")  # take half a second each


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(
    "case", [pytest.param(case, marks=pytest.mark.slow if case in LARGE else ()) for case in HOSTILE]
)
def test_what_is_no_model_is_refused(tmp_path, case, form):
    check_refused(tmp_path, case, form)


def command(*arguments):
    """Run a command in this process."""
    result = CliRunner().invoke(main, [str(argument) for argument in arguments], prog_name="mbsd3d")
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return result


def test_check_and_run_take_model_files(hand, monkeypatch):
    monkeypatch.chdir(hand.parent)
    assert "mobility 0" in command("check", hand).stdout
    result = command("run", "hand.toml", "--t-end", 0.1, "--out", "results/swing.npz")
    assert result.exit_code == 0 and "passed" in result.stdout
    assert {path.name for path in (hand.parent / "results").iterdir()} == {
        f"swing.{k}" for k in ("npz", "csv", "png", "svg")
    }
    assert mbsd3d.load("results/swing.npz").t[-1] == 0.1


def test_check_and_run_take_models_of_mujoco(tmp_path):
    path = tmp_path / "arm.xml"
    inertial = '<inertial mass="2" pos="0 0 -0.6" diaginertia="0.1 0.1 0.02"/>'
    joint = '<joint name="hinge" axis="0 1 0" range="-1 1" limited="true"/>'
    path.write_text(f'<mujoco><worldbody><body name="bob">{joint}{inertial}</body></worldbody></mujoco>')
    result = command("check", path)
    assert result.exit_code == 0 and result.stderr == "mbsd3d: 1 joint, 1 body; inactive: 1 limit (watched)\n"
    for option in ("--leave-out", "--drop"):
        result = command("check", path, option, "limit,contact")
        assert result.exit_code == 0
        assert result.stderr == "mbsd3d: 1 joint, 1 body\nmbsd3d: left out limit: range of hinge\n"
    path.write_text(path.read_text().replace("<worldbody>", '<option density="1.3" wind="1 0 0"/><worldbody>'))
    refused = command("check", path)
    assert refused.exit_code == 2 and re.search(r"cannot import fluid: .*; give --leave-out fluid, or", refused.stderr)
    assert command("check", path, "--leave-out", "fluid").exit_code == 0


ROBOT = """<robot name="r"><link name="base">{0}</link><link name="arm">{0}<visual><geometry>
  <mesh filename="package://parts/a.stl"/></geometry></visual></link>
  <joint name="hinge" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 1 0.2"/>
  <limit lower="-1" upper="1" effort="5" velocity="1"/></joint></robot>""".format(
    '<inertial><origin xyz="0.1 0 0.4"/><mass value="2"/><inertia ixx="0.1" iyy="0.2" izz="0.15"/></inertial>'
)


def test_robots_float_or_are_fixed_as_the_options_say(tmp_path):
    """Messages are in the syntax of the shell."""
    path = tmp_path / "arm.urdf"
    path.write_text(ROBOT)
    said = command("check", path)
    assert "base is fixed; --floating frees it, --fixed says so" in said.stderr
    assert "inactive: 1 limit (watched), 1 effort limit, 1 velocity limit;" in said.stderr
    assert "no geometry (meshes missing)" in said.stderr
    assert command("check", path, "--floating").stdout.count("mobility 7 ") == 1
    fixed = command("check", path, "--fixed")
    assert "mobility 1 " in fixed.stdout and "is fixed" not in fixed.stderr
    wrong = command("check", tmp_path / "hand.toml", "--floating")
    assert "--floating applies to robots (.urdf, .xacro, .sdf) only" in wrong.stderr and wrong.exit_code == 2
    path.write_text(ROBOT.replace('"base"', '"world"'))
    refused = command("check", path, "--floating")
    assert "--floating: the root 'world' is the fixed frame; give --fixed, or a root with a mass" in refused.stderr


def test_packages_are_found_where_the_option_says(tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "robots").mkdir()
    corners = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
    (tmp_path / "parts" / "a.stl").write_text(corners + "endsolid a\n")
    path = tmp_path / "robots" / "arm.urdf"
    path.write_text(ROBOT)
    assert "meshes missing" in command("check", path).stderr
    found = command("check", path, "--package-path", tmp_path, "--fixed")
    assert found.exit_code == 0 and "missing" not in found.stderr
    wrong = command("check", path, "--package-path", tmp_path / "none")
    assert wrong.exit_code == 2 and "--package-path: " in wrong.stderr and "is not a folder" in wrong.stderr


def test_limits_become_stops_where_the_option_says(tmp_path):
    """In a robot, in what is converted, and nowhere in a file that has stops of its own."""
    path, made = tmp_path / "arm.urdf", tmp_path / "arm.toml"
    path.write_text(ROBOT)
    watched = command("check", path, "--fixed", "--limits", "watched")
    assert watched.exit_code == 0 and "1 limit (watched)" in watched.stderr
    stopped = command("check", path, "--fixed", "--limits", "stop")
    assert stopped.exit_code == 0 and "limit (watched)" not in stopped.stderr
    assert "1 stop, which a speed v enters by v / 300 s or less" in stopped.stderr
    assert command("import", path, "--fixed", "--limits", "stop", "--to", made).exit_code == 0
    (stop,) = System.from_file(made).forces
    assert (stop.lower, stop.upper) == (-1.0, 1.0)
    run = command("run", path, "--fixed", "--limits", "stop", "--t-end", 2, "--out", tmp_path / "arm.npz")
    assert run.exit_code == 0 and mbsd3d.load(tmp_path / "arm.npz").angle("hinge").max() < 1.05
    wrong = command("check", made, "--limits", "stop")
    assert wrong.exit_code == 2 and "--limits applies to imported models (.xml, " in wrong.stderr


def test_files_are_known_by_other_names_too(tmp_path):
    inertial = '<inertial mass="2" pos="0 0 -0.6" diaginertia="0.1 0.1 0.02"/>'
    text = f'<mujoco><worldbody><body name="bob"><joint axis="0 1 0"/>{inertial}</body></worldbody></mujoco>'
    (tmp_path / "arm.mjcf").write_text(text)
    assert "mobility 1 " in command("check", tmp_path / "arm.mjcf").stdout
    (tmp_path / "arm.urdf.xacro").write_text(ROBOT)  # nothing in it needs xacro
    assert "mobility 1 " in command("check", tmp_path / "arm.urdf.xacro", "--fixed").stdout


def test_run_starts_at_a_key_frame(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    inertial = '<inertial mass="2" pos="0 0 -0.6" diaginertia="0.1 0.1 0.02"/>'
    text = f'<body name="bob"><joint name="hinge" axis="0 1 0"/>{inertial}</body>'
    keys = '<keyframe><key name="home" qpos="0.4" qvel="1.5"/></keyframe>'
    (tmp_path / "arm.xml").write_text(f"<mujoco><worldbody>{text}</worldbody>{keys}</mujoco>")
    assert command("run", "arm.xml", "--t-end", 0.1, "--pose", "home", "--out", "arm.npz").exit_code == 0
    run = mbsd3d.load("arm.npz")
    assert (run.angle("hinge")[0], run.rate("hinge")[0]) == (pytest.approx(0.4), pytest.approx(1.5))
    wrong = command("run", "arm.xml", "--t-end", 0.1, "--pose", "away")
    assert wrong.exit_code == 2 and "--pose away: 'arm.xml' has no such key frame; there are home" in wrong.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("check", "none.json"), "'none.json' cannot be read: No such file"),
        (("check", "hand.txt"), "'hand.txt': give a model"),
        (("check", "hand.toml", "--drop", "contact"), "--leave-out applies to imported models"),
        (("run", "bad.toml", "--t-end", 1), r"'bad.toml': .*got `str` - at `\$.bodies\[0\].mass`"),
        (("run", "none.urdf", "--t-end", 1), "'none.urdf' cannot be read"),
    ],
)
def test_failures_of_the_commands_are_one_line(hand, monkeypatch, arguments, message):
    monkeypatch.chdir(hand.parent)
    (hand.parent / "bad.toml").write_text(edit(change=("mass = 2", 'mass = "2"')))
    result = command(*arguments)
    assert result.exit_code == 2 and len(result.stderr.splitlines()) == 1 and re.search(message, result.stderr)


@pytest.mark.parametrize(("old", "new"), [
    ('"coordinate rate"', '"coordinate"'), ('"coordinate rate"', '"position"'), ('"coordinate rate"', '"state"'),
    ('"unit": "m/s"', '"unit": "furlong"'), ('"unit": "m/s",', '"unit": "m/s", "point_b": [1, 2],'),
])  # fmt: skip
def test_measures_of_a_file_are_what_kernels_know(tmp_path, old, new):
    """A kernel would read past the end for a kind or a state that is not there, or a point of two numbers."""
    body = Body("cart", 1.3, (0.2, 0.3, 0.4), com=(0.1, 0.2, 0.3))
    rail = Prismatic(GROUND, body, at=(0, 0, 0), axis=(1, 2, 3), name="rail")
    servo = StateFeedback(measures=[measures.slide_rate(rail)], gains=(3.0,), on=rail, name="servo")
    path = System([body], [rail], [servo]).to_file(tmp_path / "cart.json")
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(ValueError, match="measure 'slide rate of rail': kind .* does not fit.*measures.0"):
        System.from_file(path)


@pytest.mark.parametrize(("field", "value", "message"), [
    ("axis", [0.0, 3.0, 0.0], r"axis = \[0.0, 3.0, 0.0\] is not a direction of length 1; build what it measures with"),
    ("axis_b", [], "axis_b = .* is not a direction"), ("zero_a", [1.0, 0.0, 0.0], "zero_a and zero_b belong together"),
    ("axis", [None, 1.0, 0.0], "axis: .None, 1.0, 0.0. is not numeric; give numbers - at"),
    ("point_b", [1.0], "point_b = .* is not three numbers"), ("kind", "path", "0 numbers are not those of a curve"),
    ("numbers", [1e9, 3.0, 4.0, 5.0, 6.0], "5 numbers are not those of a curve"),  # the kernels read far beyond them
    ("numbers", [2.0, 0.0, 1.0, *(40 * [0.5])], "43 numbers are not those"),  # two pieces have 42
])  # fmt: skip
def test_coordinates_of_a_file_are_what_kernels_can_read(tmp_path, field, value, message):
    arm = Body("arm", mass=1.0, inertia=(0.1, 0.2, 0.2), position=(0.5, 0, 0))
    hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=(0, 1, 0), name="hinge")
    control = StateFeedback(measures=[measures.angle(hinge)], gains=[3.0], on=hinge)
    path = System([arm], [hinge], [control]).to_file(tmp_path / "model.json")
    data = json.loads(path.read_text())
    found = data["forces"][0]["measures"][0]["coordinate"]
    found |= {"kind": "path"} if field == "numbers" else {}
    found[field] = value
    path.write_text(json.dumps(data))
    with pytest.raises(ValueError, match=message):
        System.from_file(path)
