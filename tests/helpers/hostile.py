"""Random models with the numbers, texts and objects that people and programs give by mistake; and who raised an error.

`model(seed)` is a recipe: calling it builds the parts and asks one or more things of the system. Half of the values are
sensible, so that many models run, and fail where only a run can fail.
"""

import dis
from pathlib import Path

import numpy as np

import mbsd3d
from mbsd3d import GROUND, measures
from mbsd3d.errors import MbsError

COUNT = 10_000  # models that are tried
ROOT = Path(__file__).parents[2]
OURS = tuple(str(ROOT / name) for name in ("mbsd3d", "bicycle", "engines", "validation"))
METHODS = "/mbsd3d/integrators/"  # compiled with the kernels: their few errors are plain ones
SIZES = (1e-300, 1e-110, 1e-30, 1e-9, 1e-3, 1.0, 1e3, 1e9, 1e30, 1e110, 1e300)
NONSENSE = (
    float("nan"), float("inf"), -float("inf"), -1.0, 0.0, 10**400, -(10**400), 1e308, 5e-324, True, None, "x", "1mm",
    "", 1 + 2j, [], [1], (1, 2), {}, np.zeros((2, 2)), np.array(["a"]), object, len, b"1", np.nan, [[1, 2, 3]] * 3,
    [None] * 3, np.float32(2.0), np.int64(3), "nan",
)  # fmt: skip
STEPS = (*NONSENSE, 1e-300, 1e-30, 0.01, 0.3, 1e30)
NAMES = ("", " ", "a\nb", "=1+1", "<b>", "ground", "\ud800", 3, None, "x" * 10_000, "é", "a.b", True)


class Model:
    """Values drawn from a seed: ``wild`` of them are extreme or nonsense."""

    def __init__(self, seed, wild):
        self.rng = np.random.default_rng([seed, 15])
        self.wild = wild * float(self.rng.choice([0.0, 0.03, 0.1, 0.3, 1.0]))

    def odd(self, share=1.0):
        return self.rng.random() < self.wild * share

    def pick(self, values):
        return values[int(self.rng.integers(len(values)))]

    def number(self, low=0.1, high=2.0):
        if self.odd(0.3):
            return self.pick(NONSENSE)
        size = self.pick(SIZES) if self.odd() else 1.0
        return float(size * self.rng.uniform(low, high))

    def vector(self, size=1.0):
        if self.odd(0.2):
            return self.pick(NONSENSE)
        if self.odd(0.5):
            return tuple(self.number(-2.0, 2.0) for _ in range(3))
        if self.odd(0.5):
            return self.pick([(0, 0, 0), (1, 0, 0), (0, 0, 1), (0, 0, -1), (1e-200, 0, 0)])
        return tuple((size * self.rng.normal(size=3)).tolist())

    def name(self):
        return self.pick(NAMES) if self.odd(0.3) else self.pick(("", "", "one", "two", "three")) or None

    def signal(self, depth=0):
        kind = int(self.rng.integers(8 if depth < 2 else 6))
        if kind < 2:
            return self.number(-1.0, 1.0)
        if kind == 2:
            return mbsd3d.Ramp(self.number(), self.number())
        if kind == 3:
            return mbsd3d.Sine(self.number(), self.number(), phase=self.number())
        if kind == 4:
            return mbsd3d.Polynomial([self.number(-1, 1) for _ in range(self.rng.integers(0, 7))])
        if kind == 5:
            count = int(self.rng.integers(0, 6))
            steps = [self.number(0.01, 0.3) for _ in range(count)]
            times = np.cumsum(steps).tolist() if all(isinstance(x, float) for x in steps) else steps
            return mbsd3d.Table(times, [self.number(-1, 1) for _ in range(count)])
        if kind == 6:
            parts = [x for x in (self.signal(depth + 1), self.signal(depth + 1)) if isinstance(x, mbsd3d.Signal)]
            return sum(parts, mbsd3d.Constant(0.0))
        return mbsd3d.Pulse(self.number(), self.number(), self.number())

    def body(self, k):
        options = {}
        for key in ("com", "position", "velocity", "omega"):
            if self.rng.random() < (0.8 if key == "position" else 0.3):
                options[key] = self.vector()
        if self.rng.random() < 0.3:
            options["orientation"] = self.pick([self.vector(), (1, 0, 0, 0), tuple(self.rng.normal(size=4)), np.eye(3)])
        if self.odd(0.3):
            options["shape"] = self.pick(["box", "ball", 3, mbsd3d.shapes.Box, [(0, 0, 0), (1, 1, 1)], NONSENSE[2]])
        inertia = self.pick([(0.2, 0.3, 0.4), (0.2, 0.2, 0.4), self.vector(), (0, 0, 0), np.diag([1, 1, 1.5])])
        name = self.pick(NAMES) if self.odd(0.1) else f"b{k}"
        return mbsd3d.Body(name, self.pick([1.0, 2.0, self.number(), 0.0]), inertia, **options)

    def joint(self, bodies, joints):
        a, b = (self.pick([GROUND, *bodies]) if self.odd(0.1) else x for x in self.pair(bodies))
        at, axis, name = self.vector(), self.vector(), self.name()
        m = mbsd3d
        made = [
            lambda: m.Revolute(a, b, at=at, axis=axis, name=name),
            lambda: m.Revolute(a, b, at=at, axis=axis, at_b=self.vector(), name=name),
            lambda: m.Spherical(a, b, at=at, name=name),
            lambda: m.Universal(a, b, at=at, axis_a=axis, axis_b=self.vector(), name=name),
            lambda: m.Prismatic(a, b, at=at, axis=axis, name=name),
            lambda: m.Cylindrical(a, b, at=at, axis=axis, name=name),
            lambda: m.Planar(a, b, at=at, normal=axis, name=name),
            lambda: m.Fixed(a, b, at=at, name=name),
            lambda: m.PointOnLine(a, b, at=at, axis=axis, name=name),
            lambda: m.PointOnPlane(a, b, at=at, normal=axis, name=name),
            lambda: m.Distance(a, b, at_a=at, at_b=self.vector(), name=name),
            lambda: m.Parallel(a, b, axis=axis, name=name),
            lambda: m.Perpendicular(a, b, axis_a=axis, axis_b=self.vector(), name=name),
            lambda: m.ConstantVelocity(a, b, at=at, axis_a=axis, axis_b=self.vector(), name=name),
            lambda: m.Screw(a, b, at=at, axis=axis, pitch=self.number(), name=name),
            lambda: m.KnifeEdge(a, b, at=at, lateral=axis, name=name),
            lambda: m.RollingDisc(a, b, axis=axis, radius=self.number(), crown=self.pick([0.0, self.number()])),
            lambda: m.SpeedDriver(a, b, axis=axis, speed=self.signal(), name=name),
            lambda: m.SpeedDriver(a, b, direction=axis, at=at, speed=self.signal(), name=name),
            lambda: m.PositionDriver(b, at=at, signal=(self.signal(), None, self.signal()), name=name),
        ]  # fmt: skip
        if joints:
            old, other = self.pick(joints), self.pick(joints)
            made += [
                lambda: m.AngleDriver(old, self.signal(), name=name),
                lambda: m.SlideDriver(old, self.signal(), name=name),
                lambda: m.SpeedDriver(old, self.signal(), name=name),
                lambda: m.Gear(old, other, ratio=self.number(-2, 2), name=name),
                lambda: m.RackPinion(old, other, radius=self.number(), name=name),
                lambda: m.Coupler(old, other, coefficients=self.vector(), name=name),
                lambda: m.GearMesh(old, other, at=at, pressure_angle=self.number(), helix_angle=self.number()),
            ]  # fmt: skip
        return self.pick(made)()

    def pair(self, bodies):
        k = int(self.rng.integers(len(bodies)))
        return self.pick([GROUND, *bodies[:k]]), bodies[k]

    def force(self, bodies, joints):
        a, b = self.pair(bodies)
        m, at, name = mbsd3d, self.vector(), self.name()
        made = [
            lambda: m.Force(b, (self.signal(), 0, self.signal()), at=at, frame=self.pick(["world", "body"]), name=name),
            lambda: m.Torque(b, (self.signal(), 0, 1.0), name=name),
            lambda: m.SpringDamper(a, b, at_a=at, at_b=self.vector(), stiffness=self.number(), damping=self.number(),
                                   length=self.pick([None, self.number()]), name=name),
            lambda: m.Bushing(a, b, at=at, stiffness=self.number(), turning_stiffness=self.pick([self.number(), at]),
                              damping=self.number(), name=name),
            lambda: m.AeroDrag(b, drag_area=self.number(), density=self.number(), wind=(self.signal(), 0, 0)),
            lambda: m.Weight(a, b, acceleration=at, name=name),
            lambda: m.CentralGravity(a, b, at=at, mu=self.number(), name=name),
            lambda: m.ForceBetween(a, b, (self.signal(), 0, 1.0), at=at, frame=self.pick(["world", "a"]), name=name),
            lambda: m.TorqueBetween(a, b, (self.signal(), 0, 1.0), frame=self.pick(["world", "b"]), name=name),
            lambda: m.ForceCurve(a, b, at_a=at, at_b=self.vector(), points=[(-9.0, self.number()), (9.0, 1.0)],
                                 beyond=self.pick(["refuse", "hold", "line"]), name=name),
        ]  # fmt: skip
        if joints:
            on = self.pick(joints)
            made += [
                lambda: m.TorsionSpring(on, stiffness=self.number(), damping=self.number(), name=name),
                lambda: m.Brake(on, torque=self.number(), stiffness=self.number(), damping=self.number(), name=name),
                lambda: m.EndStop(on, lower=self.pick([None, -0.6]), upper=self.number(), stiffness=self.number(),
                                  name=name),
                lambda: m.ConeStop(on, axis_a=at, half_angle=self.number(), stiffness=self.number(), name=name),
                lambda: m.TorqueCurve(on, points=[(-9.0, self.number()), (9.0, 1.0)], name=name),
                lambda: m.JointFriction(on, coulomb=self.number(), transition=self.number(), name=name),
                lambda: m.StateFeedback(measures=[measures.angle(on)], gains=[self.number()], on=on,
                                        time_constant=self.pick([None, self.number()]), name=name),
            ]  # fmt: skip
        return self.pick(made)()

    def parts(self, count, make):
        """Those that are not refused."""
        found = []
        for _ in range(count):
            try:
                found.append(make(found))
            except ValueError as error:
                if foreign(error):
                    raise
        return found

    def system(self):
        k = iter(range(99))
        bodies = self.parts(self.rng.integers(1, 5), lambda _: self.body(next(k)))
        bodies = bodies or [mbsd3d.Body("b", 1.0, (1, 1, 1))]
        joints = self.parts(self.rng.integers(0, 6), lambda found: self.joint(bodies, found))
        forces = self.parts(self.rng.integers(0, 4), lambda _: self.force(bodies, joints))
        options = {"gravity": self.vector()} if self.odd(0.5) else {}
        return mbsd3d.System(bodies, joints, forces, **options)

    def settings(self):
        """Arguments of `simulate`."""
        m = mbsd3d
        found = {"output": self.pick([2, 5, None, [0.0, 0.01]]), "progress": False}
        methods = [m.DOP853(dt=0.003), m.RK4(0.002), m.GeneralizedAlpha(0.005), m.Kinematic()]
        if not self.wild:  # steps that follow a force of 1e30 N take their time, and should
            methods += [None, None, m.DOP853(), m.GeneralizedAlpha()]
        found["method"] = self.pick(methods)
        if self.odd(0.5):
            keys = "rtol as_built output method baumgarte gyroscopic stabilisation state stop_when gamma"
            key = self.pick(keys.split())
            found[key] = self.pick([*NONSENSE, 10**18, "baumgarte", (1e300, 1e300), [0.0, 0.0], [1e308], 0.01])
        if self.odd(0.3):
            found["method"] = self.pick([
                lambda: m.DOP853(dt=self.pick(STEPS)), lambda: m.RK4(self.pick(STEPS)), lambda: m.RK4,
                lambda: m.GeneralizedAlpha(self.pick(STEPS), self.number()), lambda: m.DOP853,
            ])()  # fmt: skip
        return found


def ask(seed, wild):
    """Build a random model and ask something of it; whatever is wrong must be said by an error of this package."""
    model = Model(seed, wild)
    system = model.system()
    t_end = model.number(0.01, 0.05) if model.odd(0.3) else 0.03
    question = int(model.rng.integers(8))
    if question == 0:
        str(system.check())
        return
    if question == 1:
        mbsd3d.linearize(system)
        return
    if question == 2:
        system.equilibrium()
        return
    if question == 3:
        angles = {model.pick([*system.joints, "nix"]): model.number(-1, 1)} if system.joints else [1]
        system.assemble(angles=angles)
        return
    if question == 4:
        now = mbsd3d.accelerations(system)
        str(now.certificate)
        return
    solution = mbsd3d.simulate(system, t_end, **model.settings())
    str(solution.certificate)
    for force in system.forces:
        solution.force(force)
    solution.to_dataframe()
    if question == 5:
        solution.measure(list(measures.between(GROUND, system.bodies[0]).values()))


def foreign(error):
    """Whether an error was not raised by a statement of this package, or is none of its errors."""
    last = error.__traceback__
    while last.tb_next is not None:
        last = last.tb_next
    code = last.tb_frame.f_code
    raised = code.co_code[last.tb_lasti] == dis.opmap["RAISE_VARARGS"]
    kind = ValueError if METHODS in code.co_filename else MbsError
    return not (isinstance(error, kind) and raised and code.co_filename.startswith(OURS))
