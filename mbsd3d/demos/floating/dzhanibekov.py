"""A free body spun about its middle axis turns over, again and again, at the interval the elliptic integral gives."""

import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipkm1

from mbsd3d import Body, System, rotation, shapes, simulate
from mbsd3d.base.rotations import matrix

from ..figure import Line, Path
from ..form import Ablation, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import first, share
from ..panel_drawing import rim

NAMES, SAMPLES = ("least moment", "middle moment", "greatest moment"), 1501
COLOUR_PLACES = (1, 0, 2)  # of the middle, least and greatest handle among the bodies, whose colours lines have
UPRIGHT_ORIENTATIONS = (rotation("y", -np.pi / 2), rotation("x", np.pi / 2), rotation("z", 0.0))
MIDDLE_NAME = NAMES[1]

OFF_SHARE_MIN = 5e-5  # [1] of the spin; errors of a run grow as the rate that starts the flips does
# [1] share of `excess` in its terms, times off / spin; below it rounding moves the flips by 1e-7 s
EXCESS_SHARE_MIN = 1e-5


def spins(axis: int, spin: float, off: float) -> np.ndarray:
    """Return the initial angular velocity, body axes [rad/s]: ``spin`` about an axis, ``off`` about the others."""
    return np.where(np.arange(3) == axis, spin, off)


def mechanism(*, m=1.5, I=(1.0, 2.0, 3.0), spin=5.0, off=1e-3) -> System:
    """Build three equal handles with moments I [kg m^2] side by side, spun [rad/s] each about another axis, which is
    upright, and a little about the others.
    """
    bar, stem = shapes.Capsule(0.16, 2.4, "x"), shapes.Capsule(0.16, 1.1, "y", at=(0, 0.75, 0))
    bodies = [
        Body(name, m, I, position=(2.7 * k, 1.7 * k, 0), orientation=turned, velocity=(0, 0, 0),
             omega=matrix(turned) @ spins(k, spin, off), shape=(bar, stem))
        for k, (name, turned) in enumerate(zip(NAMES, UPRIGHT_ORIENTATIONS, strict=True))
    ]  # fmt: skip
    return System(bodies, gravity=(0, 0, 0))


def flip_interval(i: np.ndarray, w: np.ndarray) -> float:
    """Return 2 K(k) / p [s] for I1 < I2 < I3 and L^2 > 2 T I2, with 1 - k = (I3 - I1) D / ((I3 - I2)(L^2 - 2 T I1)).

    p^2 = (I3 - I2)(L^2 - 2 T I1) / (I1 I2 I3); D = L^2 - 2 T I2 = sum of I (I - I2) w^2, written so because the
    difference of the two large numbers has no digits left. For D < 0 the least and the greatest axis change roles.
    """
    excess = (i * (i - i[1])) @ w**2
    require(
        abs(excess * w[0]) > EXCESS_SHARE_MIN * (i * abs(i - i[1])) @ w**2 * abs(w[1]),
        "demo 'dzhanibekov': I lies on the separatrix, I1 (I2 - I1) = I3 (I3 - I2), or next to it: the body turns over "
        "once and for ever later; give another middle moment",
    )
    if excess < 0:
        i, w = i[::-1], w[::-1]
    wide = (i[2] - i[1]) * (i**2 @ w**2 - i @ w**2 * i[0])
    return 2 * ellipkm1((i[2] - i[0]) * excess / wide) / np.sqrt(wide / i.prod())


def theory(*, I, spin, off, t):
    """Solve Euler's equations by elliptic functions; energy and angular momentum stay."""
    require(I[0] < I[1] < I[2], f"demo 'dzhanibekov': I = {I}: give three moments that grow")
    require(abs(spin) > 3 * abs(off) > 0, f"demo 'dzhanibekov': off = {off:g}: give a small rate that is not 0")
    require(abs(off) > OFF_SHARE_MIN * abs(spin), f"demo 'dzhanibekov': off = {off:g} grows out of rounding; give "
            f"{OFF_SHARE_MIN * abs(spin):.2g} or more")  # fmt: skip
    i, w = np.array(I), spins(1, spin, off)
    interval, L = flip_interval(i, w), matrix(UPRIGHT_ORIENTATIONS[1]) @ (i * w)
    require(
        t > 2.5 * interval, f"demo 'dzhanibekov': t = {t:g} s holds no two flips; give more than {2.5 * interval:g}"
    )
    named = {f"L{axis}_Nms": value for axis, value in zip("xyz", L, strict=True)}
    return {"flip_interval_s": interval, "energy_J": 0.5 * i @ w**2, **named}


def flips(run):
    """Return the times at which the spin of the middle handle about its middle axis changes its sign [s]."""

    def spin(t):
        state = run.at(t)
        return float(matrix(state.q[10:14])[:, 1] @ state.v[9:12])

    w = run.omega_body(MIDDLE_NAME)[:, 1]
    return np.array([brentq(spin, *run.t[k : k + 2], xtol=1e-12) for k in np.flatnonzero(w[:-1] * w[1:] < 0.0)])


def polhodes(I):
    """Return paths of L / L in the body for some energies: sum of l^2 / I = c on the unit sphere, (points, 3) each."""
    i, turn, paths = 1 / np.array(I), np.linspace(0, 2 * np.pi, 121), []
    for level in (0.03, 0.25, 0.6, 0.999):
        for around, sign in ((0, 1), (0, -1), (2, 1), (2, -1)):
            c, path = i[around] + level * (i[1] - i[around]), np.zeros((turn.size, 3))
            path[:, 1] = np.sqrt((c - i[around]) / (i[1] - i[around])) * np.cos(turn)
            path[:, 2 - around] = np.sqrt((c - i[around]) / (i[2 - around] - i[around])) * np.sin(turn)
            path[:, around] = sign * np.sqrt(1 - path[:, 1] ** 2 - path[:, 2 - around] ** 2)
            paths.append(path)
    return paths


def measure(build, terms, *, m, I, spin, off, t=30.0) -> Measured:
    """Measure the mean interval of the flips, energy and angular momentum of the middle handle at t."""
    run = simulate(build(), t, rtol=1e-12, output=SAMPLES, **terms)
    times, rates = flips(run), [run.omega_body(name) for name in NAMES]
    local = [w * np.array(I) for w in rates]
    L = run.rotation(MIDDLE_NAME)[-1] @ local[1][-1]
    seen = [momentum / np.linalg.norm(momentum, axis=1)[:, None] for momentum in local]
    tilts = [np.degrees(np.arccos(np.clip(path[:, k], -1, 1))) for k, path in enumerate(seen)]
    interval = np.diff(times).mean() if times.size > 1 else np.inf
    values = {"flip_interval_s": interval, "energy_J": 0.5 * rates[1][-1] @ local[1][-1]}
    values |= dict(zip(("Lx_Nms", "Ly_Nms", "Lz_Nms"), L, strict=True))
    known = times[:1] + build.theory["flip_interval_s"] * np.arange(int(t / interval) if times.size > 1 else 0)
    known = known[known < t]
    spins_of = [Line(f"about axis {k + 1}", rates[1][:, k]) for k in (0, 2)]
    curves = [
        Curve("angular velocity, body axes [rad/s]", run.t, rates[1][:, 1], (known, 0 * known) if known.size else None,
              title="spun about the middle axis; theory: when it flips", name="about axis 2", more=spins_of,
              colours=COLOUR_PLACES),
        Path([f"L{k} / L [-]" for k in (1, 2, 3)], seen[1], "angular momentum seen from the body", "axis 2",
             [Line("axis 1", seen[0]), Line("axis 3", seen[2])], [rim(), *polhodes(I)], globe=True,
             colours=COLOUR_PLACES),
        Curve("spin axis to angular momentum [deg]", run.t, tilts[1], title="only the middle axis turns over",
              name="middle moment", more=[Line("least moment", tilts[0]), Line("greatest moment", tilts[2])],
              colours=COLOUR_PLACES),
    ]  # fmt: skip
    return Measured(values, [run], curves)


demo = Demo(
    __name__,
    title="Dzhanibekov effect: the tumbling of the middle axis",
    question="Why does a wing nut in space turn over again and again?",
    beats=(
        Beat(0.0, "Three equal spins: about the least, the middle and the greatest axis."),
        Beat(first(lambda run: run.omega_body('middle moment')[:, 1] < 0), "Only the middle one turns over."),
        Beat(first(lambda run: run.omega_body('middle moment')[:, 1] < -4.99),
             "It spins quietly upside down, and its angular momentum has not moved."),
        Beat(share(1.0), "The two others have not left their axes."),
    ),
    why="In a plane w and I w are parallel, so a free body spins on for ever. In space they are not, and w x I w moves "
    "the spin through the body. About the axes of least and greatest moment it stays near; about the middle axis the "
    "smallest error grows until the body has turned over, and then again. No torque is at work: energy and angular "
    "momentum stay as they are.",
    equation="I w_dot = -w x I w; interval = 2 K(k) / p; p^2 = (I_3 - I_2)(L^2 - 2 T I_1) / (I_1 I_2 I_3)",
    symbols={
        "w": Symbol("spin of the middle one about its middle axis", "rad/s", curve=(1, 1)),
        "L": Symbol("angular momentum", "N m s", arrow="angular momentum"),
        "I": Symbol("moments of a handle", "kg m^2"),
        "I_1": Symbol("least", "kg m^2", lambda I: I[0]),
        "I_2": Symbol("middle", "kg m^2", lambda I: I[1]),
        "I_3": Symbol("greatest", "kg m^2", lambda I: I[2]),
        "T": Symbol("energy", "J", lambda I, spin, off: 0.5 * (I[1] * spin**2 + (I[0] + I[2]) * (off * 1.0) ** 2)),
        "p": Symbol("rate within the elliptic functions", "rad/s"),
        "K": Symbol("complete elliptic integral"),
        "k": Symbol("its modulus"),
    },
    source="Landau, Lifshitz, Mechanics, par. 37 (asymmetrical top: period 4 K/p of the elliptic functions)",
    quantities={
        "flip_interval_s": Quantity("interval between flips", "s", 1e-8, 1e-7),
        "energy_J": Quantity("energy of the middle one at t", "J", 1e-11, 1e-10),
        **{f"L{axis}_Nms": Quantity(f"its angular momentum {axis} at t", "N m s", 1e-11, 1e-10) for axis in "xyz"},
    },
    ablation=Ablation("gyroscopic", "no axis turns over, and the angular momentum does not stay",
                      values=lambda: {"flip_interval_s": np.inf}),
    show={"curves": [("omega_body", name) for name in NAMES], "traces": [], "shown": ["angular momentum"]},
    ranges={"I": [(1.0, 1.2), (1.9, 2.1), (2.7, 2.9)]},
    sliders=(Control("off", 5e-4, 0.2, "rad/s", "error of the spin", logarithmic=True),
             Control("spin", 3.0, 8.0, "rad/s")),
    readings={"flip_interval_s": ("crossings", 3, 1)},
    attempt="enlarge the error of the spin tenfold: the body turns over sooner, but only by a second and a half, "
    "as the error grows exponentially. Then omit the gyroscopic term.",
)  # fmt: skip
