"""A Celtic stone refuses to spin one way: it starts to rock, stops and turns back."""

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from mbsd3d import GROUND, Body, Rolling, System, rotation, shapes, simulate
from mbsd3d.rotations import matrix

from ..form import GRAVITY, Ablation, Beat, Control, Curve, Demo, Measured, Quantity, Symbol
from ..moments import first
from ..rolling_stone import rolled

G = 9.81  # m/s^2


def mechanism(*, m=1.0, a=0.2, b=0.03, c=0.02, I=(2e-4, 16e-4, 17e-4), delta_deg=-2.0, wobble=0.05, spin=5.0) -> System:
    """Build an ellipsoid of half axes a, b, c [m] with principal moments I [kg m^2] about axes that are turned by delta
    about its short one; it spins about the vertical and wobbles about its long axis [rad/s].
    """
    form = shapes.Ellipsoid((a, b, c), orientation=rotation("z", -delta_deg, degrees=True))
    stone = Body("stone", m, I, position=(0, 0, c), orientation=rotation("z", delta_deg, degrees=True),
                 velocity=(0, -wobble * c, 0), omega=(wobble, 0, spin), shape=form)  # fmt: skip
    return System([stone], [Rolling(GROUND, stone, form, name="table")], gravity=(0, 0, -G))


def own(times, *, m, a, b, c, I, delta_deg, wobble, spin, rtol=1e-11):
    """Integrate the vertical and w in axes of the surface, and the turn, by the stone's own equations, shape (times,
    7).
    """
    turn = matrix(rotation("z", delta_deg, degrees=True))
    return rolled(times, m=m, g=G, I=turn @ np.diag(I) @ turn.T, radii=(a, b, c), n=(0, 0, 1), w=(wobble, 0, spin),
                  rtol=rtol)  # fmt: skip


def theory(*, m, a, b, c, I, delta_deg, wobble, spin, t):
    """Return the spin about the vertical and its integral by own equations."""
    stone = {"m": m, "a": a, "b": b, "c": c, "I": I, "delta_deg": delta_deg, "wobble": wobble, "spin": spin}
    y = own(np.array([0.0, t]), rtol=3e-14, **stone)[-1]  # a reversal makes small differences a million times larger
    return {"spin_at_t_rad_s": y[:3] @ y[3:6], "turned_rad": y[6]}


def measure(build, terms, *, m, a, b, c, I, delta_deg, wobble, spin, t=4.0) -> Measured:
    """Measure the spin about the vertical and its integral."""
    run = simulate(build(), t, rtol=1e-13, output=6401, **terms)
    y = own(run.t, m=m, a=a, b=b, c=c, I=I, delta_deg=delta_deg, wobble=wobble, spin=spin)
    vertical = run.omega("stone")[:, 2]
    turned = CubicHermiteSpline(run.t, vertical, run.alpha("stone")[:, 2]).integrate(0, t)
    lift = np.degrees(np.arccos(np.clip(run.rotation("stone")[:, 2, 2], -1, 1)))
    curves = [
        Curve("spin [rad/s]", run.t, vertical, (run.t, np.sum(y[:, :3] * y[:, 3:6], axis=1))),
        Curve("rocking [deg]", run.t, lift, (run.t, np.degrees(np.arccos(np.clip(y[:, 2], -1, 1))))),
    ]
    return Measured({"spin_at_t_rad_s": vertical[-1], "turned_rad": turned}, [run], curves)


demo = Demo(
    __name__,
    title="The rattleback",
    question="Why does a Celtic stone refuse to spin one way and turn back?",
    beats=(
        Beat(0.0, "Spun one way."),
        Beat(first(lambda run: run.omega("stone")[:, 2] < 4.0), "It begins to rattle: all its spin goes into that."),
        Beat(first(lambda run: run.omega("stone")[:, 2] < 0), "It stands, and turns back."),
    ),
    why="The stone's mass lies a little askew to its surface. So a spin and a rocking that are independent in a "
    "symmetric stone now feed each other: spun the wrong way, the slightest rocking grows and takes all the energy "
    "of the spin, and the rocking then pushes the stone around the other way. Rolling without slip takes no "
    "energy, so the motion run backwards is possible too, but that one needs just the right rocking to start with.",
    equation="(I - m S(a)^2) w' = -w x I w - m a x (w x (a' + w x a) + g n),  a = D n / sqrt(n . D n)",
    symbols={
        "w": Symbol("spin about the vertical", "rad/s", curve=(0, 2)),
        "I": Symbol("moments of the stone", "kg m^2"),
        "m": Symbol("stone", "kg", "m"),
        "a": Symbol("from the centre of mass to the contact", "m"),
        "D": Symbol("squares of the half axes", "m^2"),
        "n": Symbol("the vertical, seen from the stone"),
        "S": Symbol("matrix of the cross product with a", "m"),
        "g": GRAVITY,
    },
    source="Walker (1896); Bondi, Proc. R. Soc. A 405 (1986) 265; Garcia, Hubbard, Proc. R. Soc. A 418 (1988) 165",
    quantities={
        "spin_at_t_rad_s": Quantity("spin about the vertical at the end", "rad/s", relative=1e-6),
        "turned_rad": Quantity("turned by", "rad", relative=1e-6),
    },
    ablation=Ablation("skew", "with the mass along the surface it spins on", {"delta_deg": 0.0}),
    show={"curves": [("omega", "stone")], "traces": [], "follow": "stone", "speed": 0.5},
    ranges={"I": [(1.9e-4, 2.1e-4), (15.5e-4, 16.5e-4), (16.5e-4, 17.5e-4)], "a": None, "b": None, "c": None},
    sliders=(
        Control("spin", -5.0, 7.0, "rad/s"),
        Control("delta_deg", -3.0, 3.0, "deg", "skew"),
    ),
    theory_moves=False,
    attempt="spin it the other way: it goes on. Turn the skew round, and the ways change places.",
)
