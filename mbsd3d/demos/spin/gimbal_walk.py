"""A nodding gyroscope in gimbals drifts round with every nod, because the gimbals weigh something."""

import numpy as np

from mbsd3d import GROUND, Body, Revolute, System, measures, rotation, shapes, simulate

from ..form import Ablation, Beat, Control, Curve, Demo, Measured, Quantity, Symbol
from ..moments import share
from ..quadrature import swing, turning_point
from ..runs import half_swing


def mechanism(*, Co=0.02, Ai=0.004, Bi=0.006, Ci=0.005, A=0.01, C=0.018, spin=100.0, beta_deg=30.0, kick=10.0):
    """Build outer ring Co about z, inner ring (Ai, Bi, Ci), rotor (A, C, A) spinning along y, beta above the
    horizon."""
    turned, b = rotation("x", beta_deg, degrees=True), np.radians(beta_deg)
    axis = np.array([0.0, np.cos(b), np.sin(b)])
    outer = Body("outer ring", 1.0, (Co, Co, Co), omega=(0, 0, 0), shape=shapes.Torus(0.34, 0.02, "y"))
    inner = Body("inner ring", 0.5, (Ai, Bi, Ci), orientation=turned, omega=(kick, 0, 0),
                 shape=shapes.Torus(0.28, 0.015, "z"))  # fmt: skip
    rotor = Body("rotor", 2.0, (A, C, A), orientation=turned, omega=spin * axis + (kick, 0, 0),
                 shape=(shapes.Disc(0.18, 0.05, "y"), shapes.Cylinder(0.01, 0.55, "y")))  # fmt: skip
    joints = [
        Revolute(GROUND, outer, at=(0, 0, 0), axis=(0, 0, 1), name="outer"),
        Revolute(outer, inner, at=(0, 0, 0), axis=(1, 0, 0), name="inner"),
        Revolute(inner, rotor, at=(0, 0, 0), axis=axis, name="spin"),
    ]
    return System([outer, inner, rotor], joints, gravity=(0, 0, 0))


def theory(*, Co, Ai, Bi, Ci, A, C, spin, beta_deg, kick):
    """Solve Routh's equations: D phi' = h (sin b0 - sin b), (A + Ai) b'^2 + D phi'^2 = (A + Ai) kick^2; integrals over
    a nutation.
    """
    h, b0 = C * spin, np.radians(beta_deg)

    def drift(b):
        return h * (np.sin(b0) - np.sin(b)) / (Co + (Ci + A) * np.cos(b) ** 2 + Bi * np.sin(b) ** 2)

    def square(b):
        return kick**2 - h * (np.sin(b0) - np.sin(b)) * drift(b) / (A + Ai)

    low, high = (turning_point(square, b0, step, np.pi) for step in (-0.01, 0.01))
    time, walk = swing(square, low, high, drift)
    return {"nutation_period_s": 2 * time, "walk_per_nutation_rad": 2 * walk}


def measure(build, terms, *, A, C, spin, kick) -> Measured:
    """Measure half a nutation from its upper to its lower end; the other half is its mirror image in time."""
    system = build()
    down = half_swing(
        system, measures.rate(system.part("inner", "joints")), 4 * A / abs(C * spin), up=kick > 0, **terms
    )
    walk = down.angle("outer")[-1] - down.angle("outer")[0]
    period = 2 * (down.t[-1] - down.t[0])
    values = {"nutation_period_s": period, "walk_per_nutation_rad": 2 * walk}
    seen = simulate(system, 6 * period, rtol=1e-11, output=601, **terms)
    steps = np.arange(7)
    times = steps * build.theory["nutation_period_s"]
    walks = steps * build.theory["walk_per_nutation_rad"]
    path = Curve("outer ring [rad]", seen.t, seen.angle("outer"), (times, walks), title="the walk after every nutation")
    loops = Curve("inner ring [rad]", seen.angle("outer"), seen.angle("inner"), None, "outer ring [rad]")
    return Measured(values, [seen], [path, loops])


demo = Demo(
    __name__,
    title="The walk of a gyroscope in gimbals",
    question="Why does a nodding gyroscope in gimbals creep around although nothing pushes it?",
    beats=(
        Beat(0.0, "A push makes the gyroscope nod."),
        Beat(0.0867, "One nod is over, and it does not come back to where it was."),
        Beat(share(1.0), "Six nods have turned it by 6 degrees."),
    ),
    why="A kick makes the spin axis nod, and with every nod the outer ring swings to and fro. Its moment of inertia "
    "depends on how the inner ring stands: it is smaller while the rotor leans away from the horizon. So the "
    "ring swings farther one way than back, and creeps. With the axis horizontal both halves of the nod are "
    "alike, and the creep vanishes.",
    equation="phi' = h (sin b_0 - sin b) / (C_o + (C_i + A) cos^2 b + B_i sin^2 b)",
    symbols={
        "phi": Symbol("outer ring", "rad", curve=(0, 0)),
        "h": Symbol("angular momentum of the rotor", "N m s", lambda C, spin: C * spin),
        "b": Symbol("inner ring, from its start on", "rad", curve=(1, 0)),
        "b_0": Symbol("tilt at the start", "deg", "beta_deg"),
        "C_o": Symbol("moment of the outer ring about its axis", "kg m^2", "Co"),
        "B_i": Symbol("moment of the inner ring along the rotor", "kg m^2", "Bi"),
        "C_i": Symbol("moment of the inner ring across it", "kg m^2", "Ci"),
        "A": Symbol("moment of the rotor across its axis", "kg m^2", "A"),
    },
    source="Plymale, Goodstein, J. Appl. Mech. 22 (1955); Arnold, Maunder, Gyrodynamics (gimbal walk)",
    quantities={
        "nutation_period_s": Quantity("period of the nutation", "s"),
        "walk_per_nutation_rad": Quantity("walk per nutation", "rad"),
    },
    ablation=Ablation("tilt", "with the spin axis horizontal the walk vanishes", {"beta_deg": 0.0}),
    show={"curves": [("angle", "outer"), ("angle", "inner")], "traces": [("rotor", (0.0, 0.24, 0.14))], "speed": 0.1},
    ranges={"A": (0.01, 0.012), "C": (0.01, 0.019)},
    sliders=(
        Control("beta_deg", 0.0, 60.0, "deg", "tilt of the rotor"),
        Control("spin", 50.0, 200.0, "rad/s"),
        Control("kick", 2.0, 20.0, "rad/s"),
    ),
    attempt="level the rotor: the rings nod and come back, and nothing walks.",
)
