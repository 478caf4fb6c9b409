"""A coin that rolls by friction approaches the coin of the textbook that cannot slip."""

import numpy as np

from mbsd3d import DOP853, GROUND, Body, Contact, Rolling, System, rotation, shapes, simulate

from ..form import GRAVITY, Ablation, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require

G = 9.81  # m/s^2
STIFFNESS_RATIOS = (1e-3, 1e-2, 0.1, 1.0)  # [1] of the tables over the stiffest


def mechanism(*, m=0.2, R=0.1, rho=0.01, I1=6e-4, I3=11e-4, tilt_deg=60.0, W=3.0, mu=0.6, stiffness=1e6) -> System:
    """Build a coin whose edge is a tube rho [m] about a circle R [m], moments (I1, I1, I3) [kg m^2], its axis tilted
    from the vertical, on a table of ``stiffness`` [1/m] times its weight and friction mu, or without slip (0).

    It starts in the steady motion in which its axis goes round at W [rad/s].
    """
    tilt, up = np.radians(tilt_deg), np.array([0, 0, 1])
    axis = np.array([np.sin(tilt), 0, np.cos(tilt)])
    omega = W * up + steady_spin(m, R, rho, I1, I3, tilt, W) * axis
    lowest = np.array([R * np.cos(tilt), 0, -R * np.sin(tilt) - rho])
    centre = np.array([0, 0, -lowest[2] - (1 / stiffness if stiffness else 0)])
    form = shapes.Torus(R, rho, colour="goldenrod")
    coin = Body("coin", m, (I1, I1, I3), position=centre, orientation=rotation("y", tilt), omega=omega,
                velocity=-np.cross(omega, lowest), shape=[form, shapes.Disc(R, rho)])  # fmt: skip
    if stiffness == 0:
        return System([coin], [Rolling(GROUND, coin, form, name="table")], gravity=(0, 0, -G))
    k = stiffness * m * G
    table = Contact(GROUND, coin, form, stiffness=k, damping=np.sqrt(k * m), friction=mu, name="table")
    return System([coin], forces=[table], gravity=(0, 0, -G))


def steady_spin(m, R, rho, I1, I3, tilt, W):
    """Return the spin s about its own axis, from W z x L = l x m (g z - W^2 X), linear in s [rad/s].

    L_x = sin(tilt) (I3 s + (I3 - I1) W cos(tilt)); the centre goes round at X = -(W R cos(tilt) + s h)/W from the
    vertical of the circle, h = R + rho sin(tilt).
    """
    c, s = np.cos(tilt), np.sin(tilt)
    drop, h = R * s + rho, R + rho * s
    per_spin = W * (s * I3 + m * drop * h)
    return -(W**2 * c * (s * (I3 - I1) + m * drop * R) + m * G * R * c) / per_spin


def theory(*, m, W, R, rho, I1, I3, tilt_deg, mu):
    """Return the steady motion, if friction holds it; the deflection of the table falls with one over its stiffness."""
    require(W != 0 and 0 < tilt_deg < 90, "the coin does not go round: give W other than 0 and a tilt below 90")
    tilt = np.radians(tilt_deg)
    way = W * R * np.cos(tilt) + steady_spin(m, R, rho, I1, I3, tilt, W) * (R + rho * np.sin(tilt))
    needed = abs(W * way) / G
    require(mu > needed, f"the coin slips: it needs friction {needed:.3f}, not {mu}; give a greater mu")
    return {"limit_rad_s": W, "order": 1.0, "exact_rad_s": W, "spare": mu - needed}


def rate_of(system, t, terms):
    """Return the mean rate of precession of the axis [rad/s], and the run."""
    run = simulate(system, t, method=DOP853(stiff="run"), rtol=1e-11, output=401, **terms)
    axis = run.rotation("coin")[:, :, 2]
    turn = np.unwrap(np.arctan2(axis[:, 1], axis[:, 0]))
    return (turn[-1] - turn[0]) / t, run


def film(build, *, stiffness) -> System:
    """Build what is seen: the coin on the softest table."""
    return build(stiffness=stiffness * STIFFNESS_RATIOS[0])


def measure(build, terms, *, tilt_deg, mu, stiffness, t=2.0) -> Measured:
    """Measure rates on tables of four stiffnesses and without slip; the limit and the order from the last two."""
    tables = stiffness * np.array(STIFFNESS_RATIOS)
    rates, runs = zip(*(rate_of(build(stiffness=k), t, terms) for k in (*tables, 0.0)), strict=True)
    off = np.log10(np.abs(np.array(rates[:-1]) - rates[-1]))
    ratio, powers, force = (
        STIFFNESS_RATIOS[-1] / STIFFNESS_RATIOS[-2],
        np.log10(tables),
        runs[-2].force("table").force[-1],
    )
    values = {
        "limit_rad_s": (ratio * rates[-2] - rates[-3]) / (ratio - 1),
        "order": (off[-2] - off[-1]) / np.log10(ratio),
        "exact_rad_s": rates[-1],
        "spare": mu - np.hypot(force[0], force[1]) / force[2],
    }
    lean = [np.degrees(np.arccos(run.rotation("coin")[:, 2, 2])) for run in runs]
    curves = [
        Curve("log of the difference in rate [rad/s]", powers, off, (powers, off[-1] + powers[-1] - powers),
              "log of stiffness over weight [1/m]", "the slope is -1"),
        Curve("tilt on the softest table [deg]", runs[0].t, lean[0], (runs[0].t, np.full_like(lean[0], tilt_deg))),
    ]  # fmt: skip
    return Measured(values, runs[:1], curves)


demo = Demo(
    __name__,
    title="Springs that become a rule",
    question="Is a coin that must not slip the same as a coin that is held by friction and a stiff table?",
    beats=(
        Beat(0.0, "A coin runs round on a table of stiff springs with friction."),
        Beat(1.047, "Half round, as fast as one that must not slip."),
    ),
    why="Rolling without slip is a rule: three numbers of the motion are given, whatever force that takes. "
    "A real edge sinks in a little and its friction gives way a little before it holds. Both need the same forces, so "
    "the way is as large as the force over the stiffness: ten times stiffer is ten times closer. The rule is the "
    "limit, and far cheaper to compute.",
    equation="W z x L = l x m (g z - W^2 X);  |W_k - W| ~ 1/k",
    symbols={
        "W": Symbol("rate at which the coin goes round", "rad/s", "W"),
        "W_k": Symbol("that on springs", "rad/s"),
        "k": Symbol("stiffness of the springs", "N/m", "stiffness"),
        "L": Symbol("angular momentum of the coin", "N m s"),
        "l": Symbol("from the contact to the centre", "m"),
        "X": Symbol("from the middle of the circle to the centre", "m"),
        "m": Symbol("coin", "kg", "m"),
        "g": GRAVITY,
        "z": Symbol("upwards"),
    },
    source="Routh, Advanced Rigid Dynamics; Brogliato, Nonsmooth Mechanics, on compliant contact as its limit",
    quantities={
        "limit_rad_s": Quantity("rate on springs, in the limit", "rad/s", relative=1e-5),
        "order": Quantity("power of 1/k with which the difference falls", absolute=0.1),
        "exact_rad_s": Quantity("rate without slip", "rad/s"),
        "spare": Quantity("friction to spare", absolute=1e-4),
    },
    ablation=Ablation("friction", "it falls, whatever the stiffness", {"mu": 0.0},
                      values=lambda W: {"exact_rad_s": W}),
    show={"curves": [("omega", "coin")], "traces": [], "speed": 0.5, "follow": "coin"},
    ranges={"mu": (0.55, 0.7), "I3": (9e-4, 11e-4), "rho": (0.008, 0.012), "stiffness": (8e5, 1e6)},
    sliders=(
        Control("mu", 0.36, 0.7, "", "friction"),
    ),
    attempt="let the table be more slippery: as long as friction holds, nothing changes.",
)  # fmt: skip
