"""A right call of every public name, and the same with one argument that people and programs give by mistake."""

import numpy as np
from matplotlib.figure import Figure

import mbsd3d as m
from helpers import hostile_files
from helpers.every_part import BAR, HINGE, LOOSE, MOTOR, SLIDER, SPRING, SWING, SYSTEM, measured, parts
from mbsd3d import GROUND, measures

NAN, INF = float("nan"), float("inf")
WRONG = (
    None, "", "hinje", "1mm", b"x", NAN, INF, -INF, -1, -1.5, 0, 1e-300, 1e308, 10**400, 1 + 2j, True, [], {}, (1, 2),
    (1, 2, 3), (0, 0, 0), (NAN, 0, 0), [[1, 2], [3, 4]], ["a", "b", "c"], [None] * 3, np.zeros((2, 2)), np.array("x"),
    np.zeros(0), object(), object, len, lambda: 3, GROUND, "\ud800", "\0", "x" * 5000, {"a": 1}, {1: None},
)  # fmt: skip


def build(length=1.0):
    """A pendulum."""
    bob = m.Body("bob", 1.0, (0.1, 0.1, 0.1), position=(0, 0, -length))
    return m.System([bob], [m.Revolute(GROUND, bob, at=(0, 0, 0), axis=(0, 1, 0), name="hinge")])


def played(**given):
    """A ride that is over at once."""
    sled = m.Body("sled", 2.0, (0.1, 0.1, 0.1), velocity=(0, 0, 0), omega=(0, 0, 0))
    m.System([sled], forces=[m.Force(sled, (m.Input("push"), 0, 19.62))]).play(**given).stop()


def last(solution):
    """Of a sweep."""
    return {"x": solution.t[-1]}


def files(folder):
    """That calls read."""
    (folder / "model.xml").write_text(hostile_files.MJCF)
    (folder / "model.urdf").write_text(hostile_files.URDF)
    (folder / "model.sdf").write_text(hostile_files.SDF)
    build().to_file(folder / "model.json")
    m.simulate(SYSTEM, 0.03, method=m.RK4(0.01), progress=False).save(folder / "run")


def questions(folder):
    """Systems and functions that compute."""
    quick = {"method": m.RK4(0.01), "output": 2, "progress": False}
    yield m.simulate, {
        "system": SYSTEM, "t_end": 0.02, "state": None, "method": m.RK4(0.01), "rtol": 1e-6, "output": 2,
        "stop_when": measures.angle(HINGE) < -3.0, "gyroscopic": True, "centripetal": True, "gamma": True,
        "stabilisation": "projection", "baumgarte": (20.0, 100.0), "as_built": 1e-3, "progress": False,
    }  # fmt: skip
    yield m.accelerations, {"system": SYSTEM, "state": None, "gyroscopic": True, "centripetal": True, "gamma": True}
    yield m.linearize, {
        "system": SWING, "state": None, "outputs": [measures.angle(HINGE)], "tolerance": 1e3, "gyroscopic": True,
    }  # fmt: skip
    yield m.state_space, {
        "system": m.System([BAR], [HINGE], [m.Torque(BAR, (0, m.Input("push"), 0))]), "state": None,
        "outputs": [measures.angle(HINGE)], "inputs": ["push"], "driver": "position",
        "tolerance": 1e3,
    }  # fmt: skip
    yield m.load, {"path": folder / "run.npz"}
    yield m.read_sdf, {
        "path": folder / "model.sdf", "leave_out": ["fluid"], "strict": False, "geometry": "draw",
        "inertia": "as given", "package_paths": [folder],
    }  # fmt: skip
    for read, name in ((m.read_mjcf, "model.xml"), (m.read_urdf, "model.urdf")):
        given = {"leave_out": ["fluid"], "strict": False, "geometry": "draw", "inertia": "as given"}
        given |= {"floating": None} if read is m.read_urdf else {}
        yield read, {"path": folder / name, "drop": ["limit"], "package_paths": [folder], "timeout": 30.0, **given}
    yield m.save_figure, {"figure": Figure(), "path": folder / "figure", "pdf": False}
    yield m.sweep, {
        "build": build, "grid": {"length": [1.0]}, "measure": last, "run": {"t_end": 0.01, **quick}, "executor": None,
        "ledger": folder / "sweep.db", "tag": "", "units": {"x": "s"}, "progress": False,
    }  # fmt: skip
    yield m.Stepper, {
        "system": SYSTEM, "state": None, "measures": (measures.angle(HINGE),), "method": m.RK4(0.01), "rtol": 1e-6,
        "as_built": 1e-3, "keep": True, "controllers": (),
    }  # fmt: skip
    yield SYSTEM.check, {"as_built": 1e-3}
    yield SYSTEM.state, {}
    yield SWING.equilibrium, {"state": None}
    yield SYSTEM.assemble, {
        "angles": {HINGE: 0.1}, "slides": {SLIDER: 0.1}, "rates": {HINGE: 0.3}, "measures": {}, "pinned": [LOOSE],
        "near": None, "t": 0.0,
    }  # fmt: skip
    yield SYSTEM.part, {"key": "hinge", "kind": "joints"}
    yield SYSTEM.to_file, {"path": folder / "model.json", "replace": True}
    swing = build()
    yield swing.to_mjcf, {"path": folder / "made.xml", "leave_out": ["hinge"], "replace": True}
    yield swing.to_urdf, {"path": folder / "made.urdf", "massless": False, "leave_out": (), "replace": True}
    yield swing.to_sdf, {
        "path": folder / "made.sdf", "massless": True, "leave_out": list(swing.joints), "replace": True
    }  # fmt: skip
    yield m.System.from_file, {"path": folder / "model.json"}
    yield SYSTEM.export_glb, {"path": folder / "model.glb"}
    yield (
        SYSTEM.picture,
        {"state": None, "shown": (), "hidden": ("joints",), "view": (30, 20), "size": (3, 2), "dark": True},
    )
    yield played, {
        "inputs": {"push": (-5, 5)}, "state": None, "curves": (), "method": m.RK4(0.01), "rtol": 1e-6, "as_built": 1e-3,
        "shown": (), "hidden": ("joints",), "follow": "sled", "view": (30, 20), "title": "x", "dark": True, "port": 0,
    }  # fmt: skip
    yield BAR.local_point, {"point": (0, 0, 0)}
    yield BAR.local_axis, {"axis": (0, 0, 1)}


def answers(folder):
    """What is asked of results."""
    run = m.simulate(SYSTEM, 0.03, method=m.RK4(0.01), progress=False)
    for ask in (run.position, run.orientation, run.rotation, run.velocity, run.omega, run.omega_body, run.com,
                run.acceleration, run.alpha):  # fmt: skip
        yield ask, {"body": BAR}
    yield run.point, {"body": BAR, "local": (0, 0, 0)}
    yield run.body_point, {"body": BAR, "point": (0, 0, 0)}
    yield run.body_axis, {"body": BAR, "axis": (0, 0, 1)}
    for ask in (run.angle, run.rate):
        yield ask, {"joint": HINGE}
    yield run.slide, {"joint": SLIDER}
    yield run.effort, {"driver": MOTOR}
    yield run.work, {"part": MOTOR}
    yield run.force, {"force": SPRING, "on": BAR}
    yield run.state_of, {"force": SPRING}
    yield run.measure, {"measures": measures.angle(HINGE)}
    yield run.state, {"sample": 1}
    yield run.at, {"t": 0.01}
    yield run.again, {"t_end": 0.03, "rtol": 1e-6}
    yield run.plot, {"quantity": "energy", "against": None, "degrees": False, "dark": False, "axes": None}
    yield lambda part: run.plot("angle", part), {"part": HINGE}
    yield lambda joint: run.reaction(joint), {"joint": HINGE}
    shared = {
        "axes": "b",
        "shares": "range",
        "stiffness": (1e8, 1e5),
        "tolerances": {HINGE: (1e-5, 1e-4), None: (0, 0)},
    }
    yield lambda **given: run.reaction(HINGE, **given), shared
    yield lambda name: run.certificate[name], {"name": "energy balance"}
    even = m.simulate(SYSTEM, 0.02, method=m.RK4(0.005), output=5, progress=False)
    yield even.spectrum, {"quantity": "reaction", "part": HINGE, "window": "hann", "after": 0.0}
    yield even.density, {"quantity": "reaction", "part": HINGE, "segments": 1, "after": 0.0}
    waves = m.spectrum(np.arange(8.0), np.arange(8.0), rate=None, window="hann")
    yield m.spectrum, {"t": np.arange(8.0), "values": np.arange(8.0), "rate": 0.9, "window": "hann"}
    yield waves.at, {"order": 0.125}
    yield waves.levels, {"reference": 1e-6}
    yield waves.plot, {"dark": False}
    yield even.density("reaction", HINGE, segments=1).plot, {"dark": False}
    yield run.report, {"path": folder / "report.html", "title": "run", "curves": ["energy"], "dark": False}
    yield run.save, {"path": folder / "again"}
    yield run.to_csv, {"path": folder / "run.csv"}
    yield run.picture, {"t": [0.0, 0.01], "traces": [BAR], "size": (3, 2), "dark": True}
    yield run.export_glb, {"path": folder / "run.glb", "frames": 2, "traces": [BAR]}
    yield m.bearing_load, {"solution": run, "joint": HINGE, "axis": (0, 1, 0), "frame": "a"}
    yield m.pin_stress, {
        "solution": run, "joint": HINGE, "diameter": 0.02, "cheek": 0.01, "link": 0.03, "gap": 0.001,
        "shear": "single", "lever": 0.01, "axis": (0, 1, 0), "holder": "a",
    }  # fmt: skip
    yield m.rainflow, {"history": [0.0, 1.0, 0.0]}
    yield m.SNCurve, {"amplitude": 1e8, "cycles": 1e6, "slope": 5.0, "slope_below": 9.0, "limit": False}
    yield m.miner, {
        "cycles": m.rainflow([0.0, 1.0]), "life": m.SNCurve(amplitude=1e8, cycles=1e6, slope=5), "strength": 1e9,
    }  # fmt: skip
    yield m.bearing_pair, {"solution": run, "joint": HINGE, "fixed": (0, 0.1, 0), "floating": (0, -0.1, 0)}
    small = m.linearize(SWING, outputs=[measures.angle(HINGE)], tolerance=1e3)
    yield small.plot, {}
    yield small.mode, {"k": 0}
    rotor = m.Body("rotor", 20.0, (0.4, 0.4, 0.25))
    held = [m.Bushing(GROUND, rotor, at=(0, 0, z), stiffness=1e6) for z in (-0.2, 0.3)]
    machine = m.System([rotor], forces=held, gravity=(0, 0, 0))
    whirl = {"system": machine, "spin": measures.omega(rotor, axis=(0, 0, 1))}
    yield m.campbell, {**whirl, "speeds": [0.0, 200.0], "state": None}
    yield m.campbell(**whirl, speeds=[0.0, 200.0]).critical_speeds, {"order": 1.0}
    pushed = m.System([BAR], [HINGE], [m.Torque(BAR, (0, m.Input("push"), 0))])
    model = m.state_space(pushed, outputs=[measures.angle(HINGE)], tolerance=1e3)
    yield model.frequency_response, {"w": [0.5, 1.0]}
    yield model.bode, {"w": [0.5, 1.0], "dark": False}
    yield model.step, {"t": [0.0, 0.5, 1.0]}
    yield model.select, {"outputs": [0], "inputs": "push"}
    stepper = m.Stepper(m.System([BAR], [HINGE], [m.Torque(BAR, (0, m.Input("u"), 0))]))
    yield stepper.advance, {"t": 0.01}
    yield stepper.set, {"key": "u", "value": 1.0}


def calls(folder):
    """All of them."""
    yield from parts()
    yield from measured()
    yield from answers(folder)
    yield from questions(folder)


def named(function):
    """As a person would write it."""
    return getattr(function, "__qualname__", None) or type(function).__name__
