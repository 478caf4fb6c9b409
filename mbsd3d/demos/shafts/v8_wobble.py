"""A cross-plane V8 has a couple of constant size, a flat-plane V8 has none."""

import numpy as np

from mbsd3d import GROUND, AngleDriver, Body, Distance, Kinematic, Prismatic, Ramp, Revolute, System, shapes, simulate

from ..form import Ablation, Against, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share

THROW_ANGLES = {"cross": (0, 90, 270, 180), "flat": (0, 180, 180, 0)}  # [deg] of the four throws
TURN_SAMPLES = 97  # [1] of one turn


def mechanism(*, m=0.5, r=0.045, rod=0.15, spacing=0.11, omega=600.0, plane="cross") -> System:
    """Build eight pistons m [kg] in two banks at 90 degrees, massless rods, four throws r [m] at a spacing along x."""
    require(plane in THROW_ANGLES, f"demo 'v8_wobble': plane = {plane!r}; give one of {', '.join(THROW_ANGLES)}")
    places = spacing * (1.5 - np.arange(4))
    angles = np.radians(THROW_ANGLES[plane])
    throws = list(zip(places, r * np.stack([0 * angles, -np.sin(angles), np.cos(angles)], axis=1), strict=True))
    form = [shapes.Cylinder(0.4 * r, 4 * spacing, "x")]
    form += [shapes.Cylinder(0.35 * r, 0.5 * spacing, "x", at=(x, *at[1:])) for x, at in throws]
    crank = Body("crank", 10.0, (0.05, 0.1, 0.1), shape=form)
    turn = Revolute(GROUND, crank, at=(0, 0, 0), axis=(1, 0, 0), name="main bearings")
    bodies, joints = [crank], [turn, AngleDriver(turn, Ramp(omega), name="motor")]
    for k, (x, at) in enumerate(throws):
        for bank, side in (("left", 1), ("right", -1)):
            bore = np.array([0, side, 1]) / np.sqrt(2)
            along = at @ bore
            pin = np.array([x, 0, 0]) + (along + np.sqrt(rod**2 - (at @ at - along**2))) * bore
            name = f"{bank} {k + 1}"
            frame = np.column_stack([(1, 0, 0), np.cross(bore, (1, 0, 0)), bore])
            piston = Body(name, m, (1e-4,) * 3, position=pin, orientation=frame, shape=shapes.Cylinder(0.9 * r, r))
            bodies.append(piston)
            joints += [Prismatic(GROUND, piston, at=pin, axis=bore, name=f"bore {name}"),
                       Distance(crank, piston, at_a=at + (x, 0, 0), at_b=pin, name=f"rod {name}")]  # fmt: skip
    return System(bodies, joints, gravity=(0, 0, 0))


def theory(*, m, r, rod, spacing, plane, omega):
    """Return the couple: each pair in a right-angled V equals one mass on its throw; sum of x e^(i throw) = (3 + i)
    spacing.
    """
    require(rod > r, f"demo 'v8_wobble': rod = {rod:g} m is not longer than the throw, {r:g} m; give a longer one")
    size = (plane == "cross") * np.sqrt(10) * m * r * spacing * omega**2
    return {"couple_cross_plane_Nm": size, "couple_flat_plane_Nm": 0.0}


def couple(run):
    """Return the moment of all bearings and bores on the block about its middle [N m], shape (samples, 3)."""
    total = 0.0
    for joint in run.system.joints:
        if isinstance(joint, Revolute | Prismatic):
            load = run.reaction(joint)
            total = total - load.moment - np.cross(load.point, load.force)
    return total


def measure(build, terms, *, omega) -> Measured:
    """Measure the size of the couple across the crankshaft during one turn, for both crankshafts."""
    settings = {"method": Kinematic(), "output": TURN_SAMPLES, **terms}
    turn = 2 * np.pi / abs(omega)
    run, flat = simulate(build(), turn, **settings), simulate(build(plane="flat"), turn, **settings)
    found, level = couple(run), np.linalg.norm(couple(flat)[:, 1:], axis=1)
    size, degrees = np.linalg.norm(found[:, 1:], axis=1), np.degrees(abs(omega) * run.t)
    known = build.theory["couple_cross_plane_Nm"]
    around = 2 * np.pi * np.arange(49) / 49
    curves = [
        Curve("size of the couple [N m]", degrees, size, (degrees, np.full(degrees.size, known)), "crank [deg]"),
        Curve("couple about z [N m]", found[:, 1], found[:, 2], (known * np.cos(around), known * np.sin(around)),
              "couple about y [N m]"),
    ]  # fmt: skip
    return Measured({"couple_cross_plane_Nm": size.max(), "couple_flat_plane_Nm": level.max()}, [run, flat], curves)


demo = Demo(
    __name__,
    title="The wobble of a V8",
    question="Why do cross-plane V8s wobble without shaking, and flat-plane ones do not wobble?",
    beats=(
        Beat(0.0, "The couple on the block points sideways ..."),
        Beat(share(0.25), "... and goes round with the crank ..."),
        Beat(share(0.5), "... always about as large: the block wobbles like a hula hoop."),
    ),
    why="Two pistons in a right-angled V push like a single mass that goes round with their throw. Four throws in a "
    "cross have their resultant in the middle, so nothing shakes; but they stand at different places along the "
    "shaft, and their moments leave a couple that turns with the crank at constant size. Weights on the crank "
    "can cancel it. The flat crank is its own mirror image and has none; it shakes sideways twice a turn "
    "instead.",
    equation="cross plane: sqrt(10) m r s w^2; flat plane: 0",
    symbols={
        "m": Symbol("piston", "kg", "m"),
        "r": Symbol("throw", "m", "r"),
        "s": Symbol("distance of two throws", "m", "spacing"),
        "w": Symbol("turn", "rad/s", "omega"),
    },
    source="Taylor, The Internal Combustion Engine II, ch. 8; Den Hartog, Mechanical Vibrations, ch. 5",
    quantities={
        "couple_cross_plane_Nm": Quantity("couple on the block, cross plane", "N m"),
        "couple_flat_plane_Nm": Quantity("couple on the block, flat plane", "N m"),
    },
    ablation=Ablation(
        "cross",
        "a flat crank has no couple",
        {"plane": "flat"},
        values=lambda: {"couple_cross_plane_Nm": 0.0, "couple_flat_plane_Nm": 0.0},
    ),  # fmt: skip
    against=Against("omega", 100.0, 900.0, "speed of the crank [rad/s]"),
    show={"curves": [("reaction", "main bearings")], "traces": [], "speed": 0.005},
    sliders=(
        Control("omega", 300.0, 900.0, "rad/s", "speed"),
        Control("spacing", 0.08, 0.14, "m", "between the cranks"),
    ),
    attempt="run it twice as fast: it wobbles four times as hard.",
)
