"""Files that are broken on purpose: every kind that this package reads, changed as by a disk, a hand or a foe.

`broken(seed, samples)` writes one and returns (kind, function that reads it).
"""

import io
import json
import sqlite3
import zipfile
from pathlib import Path

import numpy as np

import mbsd3d
from bicycle.parameters import read_values
from engines.nvh.cabin.table import read_modes
from engines.nvh.excitation.presets import preset
from engines.nvh.mounts.mounts import car, mounts
from engines.nvh.records import data
from engines.nvh.road.measured import read_road
from mbsd3d import GROUND, Body, Prismatic, Ramp, Revolute, Sine, SpeedDriver, SpringDamper, System, Table, shapes
from mbsd3d.sweeps.experiment import Experiment, Outcome
from mbsd3d.sweeps.grids import make_grid
from mbsd3d.sweeps.store import Ledger, identity

COUNT = 10_000  # files that are tried
NUMBERS = ("1e400", "-1e400", "nan", "inf", "1e308", "5e-324", "-0.0", "1e60", "9" * 400, "0x10", "1_000", "1,5", "")
TEXTS = (
    "",
    "null",
    "true",
    "[]",
    "{}",
    '"x"',
    "[[[[",
    "}}}}",
    "\x00",
    "\ufeff",
    "é",
    "<!DOCTYPE a>",
    "&amp;",
    "*a",
    "- - -",
)
KINDS = (
    "json", "toml", "npz", "mjcf", "urdf", "txt", "yaml", "ledger", "stl", "obj", "ply", "engine", "car", "shell",
    "road", "sdf",
)  # fmt: skip
SUFFIX = {"mjcf": "xml", "ledger": "db", "engine": "json", "car": "json", "shell": "csv", "road": "csv"}


def model():
    """A system with a bit of everything."""
    a = Body("a", 1.0, (0.1, 0.2, 0.2), position=(0.1, 0.2, 0.3), shape=shapes.Box((0.1, 0.2, 0.3)))
    b = Body("b", 2.0, (0.1, 0.2, 0.2), position=(0.6, 0.2, 0.3))
    hinge = Revolute(GROUND, a, at=(0, 0, 0), axis=(0, 1, 0), name="hinge")
    rail = Prismatic(a, b, at=(0.6, 0.2, 0.3), axis=(1, 0, 0), name="rail")
    motor = SpeedDriver(hinge, Ramp(1.0) + 2.0 * Sine(0.3, 4.0), name="motor")
    table = Table(np.linspace(0, 9, 7), np.arange(7.0))
    spring = SpringDamper(a, b, at_a=(0, 0, 0), at_b=(1, 0, 0), stiffness=5.0, name="spring")
    return System([a, b], [hinge, rail, motor], [spring, mbsd3d.Force(b, (table, 0, 1.0), name="push")])


MJCF = """<mujoco><option gravity="0 0 -9.81"/><worldbody><body name="bob" pos="0 0 1"><joint name="hinge" axis="0 1 0"
damping="0.2"/><inertial mass="2" pos="0 0 -0.6" diaginertia="0.1 0.1 0.02"/><geom type="box" size="0.1 0.2 0.3"/>
<body name="arm"><joint name="rail" type="slide" axis="1 0 0"/><inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/>
</body></body></worldbody></mujoco>"""
URDF = """<robot name="swing"><link name="frame"/><link name="bob"><inertial><origin xyz="0 0 -0.6"/><mass value="2"/>
<inertia ixx="0.1" iyy="0.1" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="continuous"><parent link="frame"/><child link="bob"/><axis xyz="0 1 0"/></joint></robot>"""
SDF = """<sdf version="1.9"><world name="w"><gravity>0 0 -9.8</gravity><model name="m">
<link name="frame"><pose>0 0 1 0.1 0.2 0.3</pose></link>
<frame name="f" attached_to="frame"><pose relative_to="bob">1 2 3 0 0 0</pose></frame>
<link name="bob"><inertial><pose>0 0 -0.6 0 0 0</pose><mass>2</mass>
<inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.02</izz></inertia></inertial></link>
<joint name="hinge" type="revolute"><parent>frame</parent><child>bob</child><axis><xyz expressed_in="f">0 1 0</xyz>
<dynamics><damping>0.1</damping></dynamics></axis></joint>
<model name="n"><link name="l"/></model><joint name="cross" type="universal"><parent>n::l</parent><child>bob</child>
<axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2></joint></model><state world_name="s"><model name="m">
<link name="bob"><pose>1 0 0 0 0 0</pose><velocity>1 0 0 0 0 0</velocity></link></model></state></world></sdf>"""
OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 1 3 4\n"
PLY = (
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 2\n"
    "property list uchar int vertex_index\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n3 0 1 3\n"
)
STL = "solid s\n" + "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n" * 2
STL += "endsolid s\n"


class Samples:
    """Sound files of every kind, made once."""

    def __init__(self, folder):
        self.folder, system = Path(folder), model()
        for kind in ("json", "toml"):
            system.to_file(self.folder / f"sound.{kind}", replace=True)
        mbsd3d.accelerations(system).save(self.folder / "sound.npz")
        self.content = {kind: (self.folder / f"sound.{kind}").read_bytes() for kind in ("json", "toml", "npz")}
        texts = {"mjcf": MJCF, "urdf": URDF, "sdf": SDF, "obj": OBJ, "ply": PLY, "stl": STL}
        texts["txt"] = "w = 1.02\nc = 0.08\nlam = 0.31 +/- 0.01\ng = 9.81\n"
        texts["yaml"] = "parameterization: benchmark\nvalues:\n  w: 1.02\n  c: 0.08\n  lam: 0.314\n  mB: 85.0\n"
        engine = {key: value for key, value in data("engines")["engines"]["inline_4"].items() if key != "layout"}
        own = {"pins": [0, 180, 180, 0], "bores": [0] * 4, "stations": [-0.1, 0, 0.1, 0.2], "firing_order": "1-3-4-2"}
        texts |= {"engine": json.dumps(engine | own), "car": json.dumps(data("cars")["cars"]["compact"])}
        texts["shell"] = "\n".join(
            ["mode,frequency,damping,place,x,y,z"]
            + [f"{k},{k}.5,.02,{x},0,0,.1" for k in (1, 2) for x in ("a", "seat")]
        )
        texts["road"] = "x,left,right\n" + "".join(f"{0.3 * k:.1f},0.01,{0.002 * (k % 5):g}\n" for k in range(40))
        self.content |= {kind: text.encode() for kind, text in texts.items()}


def changed(rng, content):
    """Bytes with one to four changes."""
    for _ in range(rng.integers(1, 5)):
        kind, size = int(rng.integers(9)), max(len(content), 1)
        i, j = sorted(int(x) for x in rng.integers(0, size, 2))
        if kind == 0:
            content = content[:i]
        elif kind == 1:
            content = content[:i] + content[j:]
        elif kind == 2:
            content = content[:i] + bytes(rng.integers(0, 256, 3, dtype=np.uint8)) + content[i + 3 :]
        elif kind == 3:
            content = content[:j] + content[i:j] * int(rng.integers(1, 40)) + content[j:]
        elif kind in (4, 5):
            content = with_number(rng, content)
        elif kind == 6:
            text = TEXTS[rng.integers(len(TEXTS))].encode()
            content = content[:i] + text + content[i:]
        elif kind == 7:
            sign = b'[{(<-"&'[rng.integers(7)]
            content = content[:i] + bytes([sign]) * int(rng.choice([5, 500, 20_000])) + content[i:]
        else:
            lines = content.split(b"\n")
            rng.shuffle(lines)
            content = b"\n".join(lines)
    return content


def with_number(rng, content):
    """One number of a text made extreme."""
    places = [k for k, sign in enumerate(content) if 48 <= sign <= 57]
    if not places:
        return content
    k = places[rng.integers(len(places))]
    end = k
    while end < len(content) and chr(content[end]) in "0123456789.eE+-":
        end += 1
    return content[:k] + NUMBERS[rng.integers(len(NUMBERS))].encode() + content[end:]


def changed_json(rng, data):
    """A value somewhere in nested data replaced by another type."""
    nonsense = [
        None,
        True,
        10**400,
        "x",
        [],
        {},
        [[]],
        -1,
        "1e5",
        1e300,
        {"type": "Body"},
        {"float": "nan"},
        ["a"] * 50,
    ]
    place = data
    while isinstance(place, dict | list) and place:
        keys = list(place) if isinstance(place, dict) else list(range(len(place)))
        key = keys[rng.integers(len(keys))]
        if rng.random() < 0.4 or not isinstance(place[key], dict | list):
            place[key] = nonsense[rng.integers(len(nonsense))]
            break
        place = place[key]
    return data


def changed_npz(rng, content):
    """A result whose text or arrays are others."""
    with np.load(io.BytesIO(content), allow_pickle=False) as stored:
        arrays = {name: stored[name] for name in stored.files}
    name = list(arrays)[rng.integers(len(arrays))]
    choice = int(rng.integers(5))
    if choice == 0:
        text = json.dumps(changed_json(rng, json.loads(bytes(arrays["json"]))))
        arrays["json"] = np.frombuffer(text.encode(), np.uint8)
    elif choice == 1:
        del arrays[name]
    elif choice == 2:
        arrays[name] = np.zeros(int(rng.integers(0, 9)))
    elif choice == 3:
        arrays[name] = np.full_like(arrays[name], 255)
    else:
        arrays["x" * int(rng.integers(1, 99))] = np.zeros(3)
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    return buffer.getvalue()


def bomb(rng):
    """A small file that unpacks to gigabytes."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        head = io.BytesIO()
        np.lib.format.write_array_header_1_0(head, {"descr": "<f8", "fortran_order": False, "shape": (2**27,)})
        archive.writestr("state.npy", head.getvalue() + bytes(2**24))
        for k in range(rng.integers(1, 30)):
            archive.writestr(f"a{k}.npy", bytes(2**22))
    return buffer.getvalue()


def ledger(rng, path):
    """A ledger whose contents somebody else has written, or bytes of one that are damaged."""
    experiment, cells = Experiment(build, measure, {"t_end": 0.1}), make_grid({"mass": [1.0, 2.0]})
    path.unlink(missing_ok=True)
    own = identity(experiment, cells, "")
    book = Ledger(path, own, 2)
    book.keep(0, Outcome({"value": 1.5, "row": [1.0, 2.0]}))
    book.close()
    odd = [
        None, "null", "[]", '{"values": null}', '{"values": {"value": null}}', '{"values": {"value": "x"}}', "[" * 5000,
        '{"values": {"value": 1e999}}', '{"values": {}, "error": 3}', b"\xff", 3, 1e300, '{"settings": 3}', "",
    ]  # fmt: skip
    with sqlite3.connect(path, isolation_level=None) as file:
        choice, value = int(rng.integers(6)), odd[rng.integers(len(odd))]
        if choice == 0:
            file.execute("DROP TABLE cells")
            file.execute("CREATE TABLE cells (cell, outcome)")
            file.execute("INSERT INTO cells VALUES (?, ?)", (odd[rng.integers(len(odd))], value))
        elif choice == 1:
            file.execute("DROP TABLE sweep")
            file.execute("CREATE TABLE sweep (digest, identity)")
            file.execute("INSERT INTO sweep VALUES (?, ?)", ("0" * 64, value))
        elif choice == 2:
            file.execute("UPDATE cells SET cell = 7")
        elif choice == 3:
            file.execute("DROP TABLE sweep")
            file.execute("CREATE VIEW sweep AS SELECT 1 AS digest")
        elif choice == 4:
            file.execute("INSERT OR REPLACE INTO cells VALUES (1, ?)", (json.dumps({"values": {"value": [1.0]}}),))
    file.close()
    if rng.random() < 0.5:
        path.write_bytes(changed(rng, path.read_bytes()))

    def read():
        again = Ledger(path, own, 2)
        try:
            again.finished()
        finally:
            again.close()

    return read


def read_engine(path):
    """An engine that turns."""
    found = preset(str(path))
    return found.engine(found.idle), found.block.inertia


def read_car(path):
    """With its mounts under an engine."""
    return mounts(car(str(path)), preset("inline_4"))


def build(mass):
    return System([Body("b", mass, (1, 1, 1))])


def measure(solution):
    return 1.0


def broken(seed, samples):
    """(kind, function that reads a broken file)."""
    rng = np.random.default_rng([seed, 16])
    share = [
        9,
        9,
        9,
        1,
        1,
        9,
        9,
        9,
        5,
        5,
        5,
        9,
        9,
        5,
        5,
        9,
    ]  # MuJoCo reads in a process of its own, which takes half a second
    kind = KINDS[rng.choice(len(KINDS), p=np.array(share) / sum(share))]
    path = samples.folder / f"broken.{SUFFIX.get(kind, kind)}"
    if kind == "ledger":
        return kind, ledger(rng, path)
    content = samples.content[kind]
    if SUFFIX.get(kind, kind) == "json" and rng.random() < 0.6:
        content = json.dumps(changed_json(rng, json.loads(content))).encode()
    elif kind == "npz" and rng.random() < 0.8:
        content = bomb(rng) if rng.random() < 0.1 else changed_npz(rng, content)
    else:
        content = changed(rng, content)
    path.write_bytes(content)
    readers = {
        "json": System.from_file, "toml": System.from_file, "npz": mbsd3d.load, "txt": read_values, "yaml": read_values,
        "mjcf": mbsd3d.read_mjcf, "urdf": mbsd3d.read_urdf, "engine": read_engine, "car": read_car, "shell": read_modes,
        "road": read_road, "sdf": mbsd3d.read_sdf,
    }  # fmt: skip
    if kind in readers:
        return kind, lambda: readers[kind](path)
    return kind, lambda: shapes.MeshFile(str(path)).surface()
