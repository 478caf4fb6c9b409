"""A tricycle in a curve: its inner wheel lifts where a car would still slide."""

import numpy as np

from mbsd3d import GROUND, AngleDriver, Body, Pulse, Revolute, System, Tyre, measures, shapes, simulate

from ..form import Ablation, Beat, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import first, share

G = 9.81  # m/s^2
BASE = 1.2  # m between the axles
HEAD, FORK, WHEEL, SPIN_MOMENT = 0.6, 4.0, 3.0, 0.12  # m above the road, kg, kg, kg m^2 of a wheel about its axle
RADIUS, CROWN = 0.28, 0.02  # m of a wheel, and of its rim's roundness
AXLE = (0, 1, 0)  # of all wheels, to the left
STEERED, SLOW = 0.5, 12.0  # s when it begins to steer, and how long a turn takes that grows slowly
SMALL = 0.02  # [1] of the steer, where loads are proportional to the acceleration
LAST = 0.05  # [1] of the inner load, which can still be measured
LOW = 0.3  # m: the centre of mass of a tricycle that one lies in
OVER = 1.0  # rad of lean at which the film ends


def places(track):
    """Return the wheels' places on the road, the front one at the origin."""
    return {"front": (0.0, 0.0), "left": (-BASE, track / 2), "right": (-BASE, -track / 2)}


def frame_form(track, back, h):
    """Draw frame, axle, seat and rider."""
    head, rear, com = np.array([0, 0, HEAD]), np.array([-BASE, 0, RADIUS]), np.array([-back, 0, h])
    seat = np.array([-0.75 * BASE, 0, h])

    def bar(start, end, radius, colour):
        middle, way = 0.5 * (start + end), end - start
        return shapes.Cylinder(radius, float(np.linalg.norm(way)), way, at=middle - com, colour=colour)

    axle = [np.array([-BASE, side * track / 2, RADIUS]) for side in (1, -1)]
    body = shapes.Cylinder(0.14, 0.55, "z", at=seat + (0.05, 0, 0.3) - com, colour="steelblue")
    skull = shapes.Sphere(0.13, at=seat + (0.05, 0, 0.75) - com, colour="peru")
    return (bar(head, rear, 0.03, "crimson"), bar(*axle, 0.02, "gray"), bar(rear, seat, 0.025, "crimson"), body, skull)


def mechanism(*, track=0.75, back=0.8, h=0.72, m=100.0, stiffness=1.2e5, v=6.4, steer=0.12, edge=1.0) -> System:
    """Build a tricycle at v [m/s]: frame with rider m [kg], its centre of mass ``back`` [m] behind the front wheel's
    contact and h [m] over the road, on three tyres; it steers to the left within ``edge`` [s] and coasts.
    """
    sag = m * G / 3 / stiffness
    rolling = {"velocity": (v, 0, 0), "omega": (0, v / RADIUS, 0)}
    hubs = {name: np.array([x, y, RADIUS - sag]) for name, (x, y) in places(track).items()}
    wheels = {name: Body(name, WHEEL, (0.06, SPIN_MOMENT, 0.06), position=hub, **rolling) for name, hub in hubs.items()}
    straight = {"velocity": (v, 0, 0), "omega": (0, 0, 0)}
    frame = Body("frame", m, (14.0, 18.0, 10.0), position=(-back, 0, h), shape=frame_form(track, back, h),
                 **straight)  # fmt: skip
    bar = shapes.Cylinder(0.02, 0.5, "y", at=(0, 0, 0.3)), shapes.Cylinder(0.025, 0.6, "z")
    fork = Body("fork", FORK, (0.2, 0.2, 0.05), position=(0, 0, HEAD), shape=bar, **straight)
    head = Revolute(frame, fork, at=(0, 0, HEAD), axis=(0, 0, 1), name="head")
    hinges = [
        Revolute(fork if name == "front" else frame, wheel, at=hubs[name], axis=AXLE, name=f"{name} hub")
        for name, wheel in wheels.items()
    ]
    handlebar = AngleDriver(head, Pulse(steer, start=STEERED, edge=edge), name="handlebar")
    tyres = [
        Tyre(GROUND, wheel, axis=AXLE, radius=RADIUS, crown=CROWN, stiffness=stiffness, cornering=12.0,
             relaxation=0.15, name=f"{name} tyre")
        for name, wheel in wheels.items()
    ]  # fmt: skip
    return System([frame, fork, *wheels.values()], [head, *hinges, handlebar], tyres, gravity=(0, 0, -G))


def theory(*, track, back, h, m, stiffness):
    """Balance moments about the line on the road below the middle: the acceleration of all masses, the weight that
    leans with them on its tyres, and the turning of the wheels' spins carry a load D from the inner to the outer wheel.

    It goes at an even speed here; a turn that coasts slows down, which takes one percent off the rear wheels.
    The lean is 2 D / (k track); where a wheel leans, the contact goes aside by its roundness less its depth.
    """
    require(back < BASE, f"demo 'tricycle': back = {back:g} m puts its weight behind the rear axle; give < {BASE:g}")
    masses = np.array([m, FORK, WHEEL, 2 * WHEEL])
    behind, built = np.array([back, 0.0, 0.0, BASE]), m * G / 3 / stiffness  # how deep all tyres are at the start
    rear = G * (masses @ behind) / BASE
    front = G * masses.sum() - rear
    pressed = np.array([front, rear / 2]) / stiffness
    heights = np.array([h, HEAD, RADIUS - built, RADIUS - built])
    heights -= pressed[0] - built + (pressed[1] - pressed[0]) * behind / BASE  # as it settles
    high = masses @ heights
    leans = G * high - np.array([front, rear]) @ (CROWN - pressed)
    moved = (high + 3 * SPIN_MOMENT / RADIUS) / (track - 2 * leans / (stiffness * track))
    return {"moved_per_acceleration_kg": moved, "rear_load_N": rear, "last_load_at_m_s2": (1 - LAST) * rear / 2 / moved}


def across(run):
    """Return the acceleration of the common centre of mass to the left of the frame [m/s^2], (times,)."""
    masses = [body.mass for body in run.system.bodies]
    pull = sum(mass * run.acceleration(body) for mass, body in zip(masses, run.system.bodies, strict=True)) / sum(
        masses
    )
    return np.einsum("ti,ti->t", pull, run.body_axis("frame", AXLE))


def loads(run):
    """Return the loads of the left, inner, and the right, outer, rear wheel [N], (times, 2)."""
    return np.column_stack([run.force(f"{side} tyre").normal for side in ("left", "right")])


def measure(build, terms, *, steer) -> Measured:
    """Measure a slight turn; the acceleration at which a twentieth of the inner wheel's load is left, in a turn that
    grows slowly (infinite if it never is); and the turn that is seen, until it has tipped over.
    """
    settings = {"rtol": 1e-10, **terms}
    gentle = simulate(build(steer=SMALL * steer), 4.0, output=401, **settings)
    moved, rear = np.ptp(loads(gentle)[-1]) / 2 / across(gentle)[-1], loads(gentle)[-1].sum()
    slowly = build(edge=SLOW, steer=1.5 * steer)
    slow = simulate(slowly, SLOW, output=1201, stop_when=leaning(slowly), **settings)
    sideways, inner = across(slow), loads(slow)[:, 0]
    few = np.flatnonzero(inner < LAST * rear / 2)[:1]
    limit = np.interp(-LAST * rear / 2, -inner[few[0] - 1 :][:2], sideways[few[0] - 1 :][:2]) if few.size else np.inf
    seen = build()
    run = simulate(seen, 4.0, output=401, stop_when=leaning(seen), **settings)
    before = slice(None, few[0] if few.size else None, 10)
    known = build.theory["moved_per_acceleration_kg"]
    curves = [
        Curve("load of the inner wheel [N]", sideways[before], inner[before],
              (sideways[before], rear / 2 - known * sideways[before]), along="acceleration across [m/s^2]",
              title="in a turn that grows slowly"),
        Curve("load of the inner wheel [N]", run.t, loads(run)[:, 0], title="in the turn that is seen"),
    ]  # fmt: skip
    values = {"moved_per_acceleration_kg": moved, "rear_load_N": rear, "last_load_at_m_s2": limit}
    return Measured(values, [run], curves)


def leaning(system):
    """Return the condition that the frame has tipped over."""
    return measures.lean(system.part("frame")) > OVER


def without_height(*, track, back, m, stiffness):
    """Return what is left with its weight near the road: it never comes near lifting."""
    found = theory(track=track, back=back, h=LOW, m=m, stiffness=stiffness)
    return {**found, "last_load_at_m_s2": np.inf}


demo = Demo(
    __name__,
    title="The tricycle that lifts a wheel",
    question="Why does a tricycle lift its inner wheel in a curve that a bicycle leans into?",
    beats=(
        Beat(0.0, "Straight on, at 6.4 m/s."),
        Beat(0.5, "The handlebar turns to the left. It cannot lean into the curve."),
        Beat(first(lambda run: loads(run)[:, 0] < 1.0), "The inner wheel carries nothing any more ..."),
        Beat(first(lambda run: run.com("left")[:, 2] > 0.4), "... and lifts, as only one wheel in front can hold."),
        Beat(share(1.0), "Over."),
    ),
    why="A bicycle leans until its weight and the curve balance on two contacts in line. A tricycle stands: the curve "
    "acts at the height of its rider, and only the two wheels behind can answer, by a load that goes from the inner "
    "one to the outer one. The front wheel, in the middle, bears none of it, and where the weight lies far ahead the "
    "rear wheels have little to give. Soft tyres lean it outwards, and the wheels' spins push the same way: in the "
    "plane there would be neither.",
    equation="D track = (m h + 3 J/r) a + G 2 D/(k track); the wheel lifts at D = N",
    symbols={
        "D": Symbol("load that goes to the outer wheel", "N"),
        "a": Symbol("acceleration across", "m/s^2"),
        "m": Symbol("frame and rider", "kg", "m"),
        "h": Symbol("height of the centre of mass", "m", "h"),
        "J": Symbol("moment of a wheel along its axle", "kg m^2", lambda: SPIN_MOMENT),
        "r": Symbol("wheel", "m", lambda: RADIUS),
        "k": Symbol("stiffness of a tyre", "N/m", "stiffness"),
        "G": Symbol("weight times its height over the contacts", "N m"),
        "N": Symbol("load of the inner wheel", "N", curve=(0, 2)),
    },
    source="balance of moments; Huston, Graves, Johnson, SAE Technical Paper 820139 (1982): three-wheeled vehicles",
    quantities={
        "moved_per_acceleration_kg": Quantity("load from inner to outer wheel, per acceleration", "kg", relative=5e-4),
        "rear_load_N": Quantity("load of both rear wheels", "N", relative=5e-4),
        "last_load_at_m_s2": Quantity("a twentieth of the inner load is left at", "m/s^2", relative=0.015),
    },
    ablation=Ablation("height", "with its weight near the road no load moves, and it slides first", {"h": LOW},
                      values=without_height),
    show={"curves": [("force", "left tyre"), ("force", "right tyre")], "traces": [], "follow": "frame",
          "hidden": ["joints", "joint names", "body names"], "view": (200.0, 15.0), "speed": 0.5},
    ranges={"back": (0.75, 0.82), "track": (0.72, 0.78), "steer": (0.11, 0.13), "v": (6.3, 6.6)},
)  # fmt: skip
