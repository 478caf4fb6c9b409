"""Engines and planar mechanisms as cases, and the planar judge: planar mechanisms solved again by the planar solver.

Loads on the block are compared in closed form, as a sum of planes and in space; planar mechanisms in plane and space.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from engines import planar
from engines.balance import balance, layouts, spatial
from engines.balance.layouts import Engine, names
from mbsd3d import GROUND, Constant, Joint, Kinematic, Prismatic, Revolute, SpeedDriver, SpringDamper, System, Torque
from mbsd3d.errors import InputError
from mbsd3d.extend import perpendiculars
from validation import reduce_to_planes
from validation.benchmark import planar_pairs as twins
from validation.cases.inline_four import CRANK_RATE, block_force, inline_four
from validation.suite.findings import PLANE, THEORY, Finding, judged, not_compared
from validation.suite.trials.trial import Run, Trial, run

PLANAR_TOLERANCE = 1e-12  # [1] of directions and distances: beyond rounding a mechanism is not planar
ORDER_MIN = 3.5  # [1] Runge-Kutta of order 4 shows at least this one while its error exceeds that of mbsd3d
STEP_COUNTS = (2000, 8000)  # [1] steps of the runs
COMPARED_SAMPLES = 9  # [1] samples of the comparison, the start and the end among them
DIFFERENCE_MAX = 1e-5
"""Largest error of the finest run where it falls at the right order: what is left is the planar method's own."""


class NotPlanarError(InputError):
    """Error for a mechanism that the planar solver cannot represent; the text names the part."""


@dataclass
class Flat:
    """Mechanism seen along ``axis``: x and y are the first rows of ``frame`` (3, 3)."""

    frame: np.ndarray
    bodies: dict[int, planar.Body] = field(default_factory=dict)
    joints: list[planar.Joint] = field(default_factory=list)
    loads: list[Any] = field(default_factory=list)

    def flat(self, vector: Any) -> np.ndarray:
        """Return the components of a vector in the plane, shape (2,)."""
        return self.frame[:2] @ np.asarray(vector, dtype=float)

    def of(self, body: Any) -> Any:
        """Return the planar body of a body."""
        return planar.GROUND if body is GROUND else self.bodies[id(body)]

    def sense(self, axis: np.ndarray, what: str) -> float:
        """Return +1 or -1 for an axis along or against the normal."""
        along = float(self.frame[2] @ axis)
        if abs(along) < 1.0 - PLANAR_TOLERANCE:
            raise NotPlanarError(f"the axis of {what} is not normal to the plane")
        return np.sign(along)


def normal_of(system: System) -> np.ndarray:
    """Return the axis that all hinges share."""
    hinges = [joint for joint in system.joints if isinstance(joint, Revolute)]
    if not hinges or any(not isinstance(joint, Revolute | Prismatic | SpeedDriver) for joint in system.joints):
        raise NotPlanarError("only hinges, slides and motors about one axis move in a plane")
    return hinges[0].axis


def flatten(system: System) -> tuple[planar.System, Flat]:
    """Return the planar model of a spatial mechanism.

    NotPlanarError naming the part that leaves the plane, or has no planar counterpart.
    """
    normal = normal_of(system)
    made = Flat(np.array([*perpendiculars(normal), normal]))
    for body in system.bodies:
        made.bodies[id(body)] = flat_body(made, body)
    for joint in system.joints:
        add_joint(made, system, joint)
    for force in system.forces:
        made.loads.append(flat_load(made, system, force))
    gravity = made.flat(system.gravity)
    return planar.System(list(made.bodies.values()), made.joints, made.loads, gravity), made


def flat_body(made: Flat, body: Any) -> planar.Body:
    """Return a planar body with its x axis along the plane's at the reference pose."""
    normal, omega = made.frame[2], None
    inertia = float(normal @ body.axes @ body.inertia @ body.axes.T @ normal)
    if body.omega is not None:
        omega = float(normal @ body.omega)
        if np.linalg.norm(body.omega - omega * normal) > PLANAR_TOLERANCE * max(1.0, abs(omega)):
            raise NotPlanarError(f"body '{body.name}' turns out of the plane at the start")
    velocity = None if body.velocity is None else made.flat(body.velocity)
    com, position = made.flat(body.centre - body.position), made.flat(body.position)
    return planar.Body(body.name, body.mass, inertia, com=com, position=position, velocity=velocity, omega=omega)


def add_joint(made: Flat, system: System, joint: Joint) -> None:
    """Add the planar counterpart of a joint; a second hinge on the same axis adds nothing in a plane."""
    what, ends = system.name(joint), (made.of(joint.a), made.of(joint.b))
    if isinstance(joint, Prismatic):
        if abs(made.frame[2] @ joint.axis) > PLANAR_TOLERANCE:
            raise NotPlanarError(f"the axis of {what} leaves the plane")
        made.joints.append(planar.Slider(*ends, at=made.flat(joint.at), axis=made.flat(joint.axis), name=what))
        return
    if not isinstance(joint, Revolute | SpeedDriver) or joint.axis is None:
        raise NotPlanarError(f"{what} moves a point, not a hinge")
    sense = made.sense(joint.axis, what)
    shared = [found for found in made.joints if isinstance(found, planar.Revolute) and {found.a, found.b} == {*ends}]
    if isinstance(joint, SpeedDriver):
        if not shared:
            raise NotPlanarError(f"{what} drives no hinge")
        sense = sense if shared[0].b is ends[1] else -sense
        speed = sense * constant(joint.speed, what)
        made.joints.append(planar.AngleDriver(shared[0], planar.rate(speed), name=what))
        return
    if not any(np.allclose(found.at, made.flat(joint.at), rtol=0.0, atol=PLANAR_TOLERANCE) for found in shared):
        made.joints.append(planar.Revolute(*ends, at=made.flat(joint.at), name=what))


def flat_load(made: Flat, system: System, force: Any) -> Any:
    """Return the planar counterpart of a force."""
    what = system.name(force)
    if isinstance(force, SpringDamper):
        ends: dict[str, Any] = {"at_a": made.flat(force.at_a), "at_b": made.flat(force.at_b), "length": force.length}
        values: dict[str, Any] = {"stiffness": force.stiffness, "damping": force.damping, "name": what}
        return planar.Spring(made.of(force.a), made.of(force.b), **ends, **values)
    if isinstance(force, Torque):
        torque = np.array([constant(part, what) for part in force.torque])
        made.sense(torque / np.linalg.norm(torque), what)
        return planar.Force(made.of(force.body), torque=float(made.frame[2] @ torque), name=what)
    raise NotPlanarError(f"{what} ({type(force).__name__}) has no planar counterpart here")


def constant(signal: Any, what: str) -> float:
    """Return the value of a constant signal; raise NotPlanarError for others."""
    if not isinstance(signal, Constant):
        raise NotPlanarError(f"{what} changes with time")
    return signal.value


def in_the_plane(made: Run) -> Iterable[Finding]:
    """Compare the centres of mass of all bodies with the planar mechanism."""
    try:
        system, flat = flatten(made.system)
    except ValueError as reason:
        return [not_compared(PLANE, str(reason))]
    return by_ladder(made, system, flat.frame)


def by_ladder(made: Run, system: planar.System, frame: np.ndarray) -> Iterable[Finding]:
    """Compare the centres of mass with a planar model, bodies of equal names: errors of its runs must fall at their
    order.
    """
    try:
        runs = [planar.simulate(system, made.t_end, dt=made.t_end / n, output=COMPARED_SAMPLES) for n in STEP_COUNTS]
    except ValueError as reason:
        yield not_compared(PLANE, str(reason))
        return
    rtol = made.motion.record.rtol
    ours = run(made.system, made.t_end, state=made.state, output=COMPARED_SAMPLES, rtol=rtol).motion
    errors = [apart(ours, frame, theirs) for theirs in runs]
    order = (
        float(np.log(errors[0] / errors[1]) / np.log(STEP_COUNTS[1] / STEP_COUNTS[0])) if errors[-1] > 0.0 else np.inf
    )
    limit = DIFFERENCE_MAX if order >= ORDER_MIN else made.accuracy
    text = f"{STEP_COUNTS[-1]} steps of {made.t_end / STEP_COUNTS[-1]:.3g} s, observed order {order:.2f}"
    yield judged(PLANE, "centres of mass", errors[-1], limit, text)


def apart(ours: Any, frame: np.ndarray, theirs: planar.Solution) -> float:
    """Return the largest distance of centres of mass over the largest of their coordinates, at least 1 m [-]."""
    found = np.array([ours.com(body) @ frame[:2].T for body in ours.system.bodies])
    known = np.array([theirs.com(body.name) for body in ours.system.bodies])
    return float(np.abs(found - known).max() / max(1.0, np.abs(found).max()))


GRAVITY = (1.3, -9.6)  # m/s^2, in the plane of the cylinders, along no axis
QUICK_LAYOUTS = ("single", "I4", "V8_cross")  # layouts of the short list
PEER_LAYOUTS = ("I4", "V6_90_split30")  # layouts that other engines are asked about; the others have the same parts
SAMPLES = 33


def trials(quick: bool) -> list[Trial]:
    """Return layouts of engines, the inline four of the sweeps, and planar mechanisms with and without redundant
    rows."""
    found = [layout(name) for name in (QUICK_LAYOUTS if quick else names())]
    found.append(Trial("inline_four", "engines", "inline four, driven, as a sum of planes", four, {PLANE: block}))
    for k, mechanism in enumerate(twins.mechanisms()):
        for redundant in (False, True):
            name = f"{mechanism.name.replace(' ', '_')}{'_redundant' if redundant else ''}"
            title = f"{mechanism.name} in a plane, in space {'with' if redundant else 'without'} redundant rows"
            judges = {PLANE: partial(twin, k)}
            found.append(Trial(f"planar_{name}", "planar mechanisms", title, partial(free, k, redundant), judges))
    return found


def layout(name: str) -> Trial:
    """Return the test case of an engine of `engines.balance`."""
    alone = (
        "" if name in PEER_LAYOUTS else f"{' and '.join(PEER_LAYOUTS)} represent the layouts, which have the same parts"
    )
    judges = {THEORY: partial(balanced, "phasor", THEORY), PLANE: partial(balanced, "planar", PLANE)}
    return Trial(f"engine_{name}", "engines", layouts.layout(name).title, partial(turning, name), judges, alone=alone)


def turning(name: str) -> Run:
    """Simulate one turn of the crank; the source holds the harmonics by three methods."""
    engine = Engine(layouts.layout(name))
    system = spatial.build(engine, gravity=(*GRAVITY, 0.0))
    solution = spatial.turn(system, engine)
    return Run(system, float(solution.t[-1]), solution, source=balance.compare(engine, gravity=GRAVITY))


def balanced(way: str, judge: str, made: Run) -> Iterable[Finding]:
    """Compare harmonics 0 to 6 of the load on the block: the model in space against another method."""
    found, engine = made.source.ways, made.source.engine
    error = found[way].difference(found["spatial"], engine.spacing) / engine.single
    yield judged(
        judge,
        "harmonics of the block load",
        error,
        balance.DISAGREEMENT_MAX,
        "relative to the 1x force of one cylinder",
    )


def four() -> Run:
    """Simulate one turn of the inline four."""
    return run(inline_four(), 2 * np.pi / CRANK_RATE, method=Kinematic(), output=SAMPLES)


def block(made: Run) -> Iterable[Finding]:
    """Compare the force on the block with a sum of planes."""
    ours = block_force(made.motion)
    known = reduce_to_planes(made.system).block_load(made.motion.t).force
    yield judged(
        PLANE, "force on the block", np.abs(ours - known).max() / np.abs(known).max(), balance.DISAGREEMENT_MAX
    )


def free(k: int, redundant: bool) -> Run:
    """Simulate a planar mechanism that runs freely in space for a turn of its first speed."""
    mechanism = twins.mechanisms()[k]
    return run(mechanism.space(redundant=redundant), mechanism.turn, output=SAMPLES)


def twin(k: int, made: Run) -> Iterable[Finding]:
    """Compare the same mechanism in the planar solver; its plane is x and y."""
    return by_ladder(made, twins.mechanisms()[k].plane(), np.eye(3))
