"""A coin spun on the table stops in a finite time by a little rolling friction."""

import numpy as np

from mbsd3d import DOP853, GROUND, Body, Contact, System, rotation, shapes, simulate
from mbsd3d.rotations import matrix

from ..form import GRAVITY, Ablation, Beat, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share
from ..rolling_stone import rolled

G = 9.81  # m/s^2
STIFFNESS_PER_WEIGHT = 1e6  # [1/m] the table deflects by 1 um, far less than the height of the edge during the run


def moments(m, a):
    """Return the moments of inertia of a thin disc (I1, I1, I3) [kg m^2]."""
    return np.array([0.25, 0.25, 0.5]) * m * a**2


def start(m, a, rho, tilt_deg):
    """Return (angular velocity, height of the centre) in the steady motion whose centre is at rest.

    Its axis goes round at W, and it spins about it at S [rad/s]:
    W^2 = m g R / (sin(tilt) (I1 - I3 rho sin(tilt)/h)) and S = -W R cos(tilt)/h, R = a - rho, h = R + rho sin(tilt).
    """
    tilt, R, (I1, _, I3) = np.radians(tilt_deg), a - rho, moments(m, a)
    s, h = np.sin(tilt), R + rho * np.sin(tilt)
    W = np.sqrt(m * G * R / (s * (I1 - I3 * rho * s / h)))
    S = -W * R * np.cos(tilt) / h
    return np.array([S * s, 0, W + S * np.cos(tilt)]), R * s + rho


def mechanism(*, m=0.1, a=0.04, rho=0.002, tilt_deg=10.0, mu=0.8, arm=3e-4) -> System:
    """Build a thin disc of radius a [m] with an edge rounded by rho [m], on friction mu; arm [m] times the normal force
    is the moment against rolling.
    """
    omega, height = start(m, a, rho, tilt_deg)
    tilt, k, edge = np.radians(tilt_deg), STIFFNESS_PER_WEIGHT * m * G, shapes.Torus(a - rho, rho, colour="silver")
    low = np.array([(a - rho) * np.cos(tilt), 0, -height])
    form = [edge, shapes.Disc(a - rho, 1.6 * rho), shapes.Box((1.2 * a, 0.12 * a, 2.2 * rho), colour="orangered")]
    disc = Body("disc", m, moments(m, a), position=(0, 0, height - 1 / STIFFNESS_PER_WEIGHT),
        orientation=rotation("y", tilt),
                velocity=-np.cross(omega, low), omega=omega, shape=form)  # fmt: skip
    table = Contact(GROUND, disc, edge, stiffness=k, damping=np.sqrt(k * m), friction=mu, rolling=arm, name="table")
    return System([disc], forces=[table], gravity=(0, 0, -G))


def end(a, tilt_deg, arm):
    """Return the time left at a small tilt, of a thin disc [s]: E = 3/2 m g a tilt and E' = -arm m g W tilt, W^2 = 4
    g/(a tilt).
    """
    return 1.5 * a / arm * np.sqrt(a * np.radians(tilt_deg) / G)


def own(times, *, m, a, rho, tilt_deg, arm):
    """Return (tilt [rad], energy [J], friction it needs) by the disc's own equations without slip on a rigid table."""
    back, (omega, _) = matrix(rotation("y", np.radians(tilt_deg))).T, start(m, a, rho, tilt_deg)
    R, I = a - rho, moments(m, a)
    y = rolled(times, m=m, g=G, I=np.diag(I), radii=(R, R, 0), tube=rho, n=back[:, 2], w=back @ omega, arm=arm)
    n, w, slope = y[:, :3], y[:, 3:6], np.hypot(y[:, 0], y[:, 1])
    reach = n * [R, R, 0] / slope[:, None] + rho * n  # from the edge to the centre
    speed = np.linalg.norm(np.cross(w, reach), axis=1)
    energy = 0.5 * (w**2 @ I + m * speed**2) + m * G * (R * slope + rho)
    round_ = (np.sum(n * w, axis=1) - w[:, 2] * n[:, 2]) / slope**2  # the centre runs in a circle
    return np.arctan2(slope, n[:, 2]), energy, speed * round_ / G


def theory(*, m, a, rho, tilt_deg, mu, arm, t):
    """Return the end time, and by the disc's own equations the remaining tilt and energy at t."""
    require(0 < tilt_deg <= 20 and rho <= 0.1 * a, "the end is known for thin coins at small tilts: give a tilt of at "
            "most 20 degrees and an edge rho of at most 0.1 a")  # fmt: skip
    require(arm > 0, "without friction against rolling it never ends: give an arm above 0")
    last = end(a, tilt_deg, arm)
    require(t < 0.9 * last, f"t = {t:g} s is too near to its end after {last:.3g} s: give less than {0.9 * last:.3g}")
    tilt, energy, needed = own(np.array([0.0, t]), m=m, a=a, rho=rho, tilt_deg=tilt_deg, arm=arm)
    require(mu > needed[-1], f"the coin slips before: it needs friction {needed[-1]:.3f}, not {mu}; give a greater mu "
            "or an earlier end t")  # fmt: skip
    return {"ends_s": last, "tilt_deg": np.degrees(tilt[-1]), "lost_J": energy[0] - energy[-1],
            "spare": mu - needed[-1]}  # fmt: skip


def measure(build, terms, *, m, a, rho, tilt_deg, mu, arm, t=3.2) -> Measured:
    """Measure the end time from the square root of the tilt, which falls linearly, and tilt and energy at t."""
    run = simulate(build(), t, method=DOP853(stiff="run"), rtol=1e-9, output=801, **terms)
    axis, energy = run.rotation("disc")[:, :, 2], run.energy().total
    tilt = np.arctan2(np.hypot(axis[:, 0], axis[:, 1]), axis[:, 2])
    slope, root = np.polyfit(run.t[400:], np.sqrt(tilt[400:]), 1)
    ends = -root / slope if tilt[-1] < 0.9 * tilt[0] else np.inf
    pace = np.gradient(np.unwrap(np.arctan2(axis[:, 1], axis[:, 0])), run.t) / (2 * np.pi)
    known = own(run.t, m=m, a=a, rho=rho, tilt_deg=tilt_deg, arm=arm)[0]
    left = 1 - run.t / end(a, tilt_deg, arm) if arm else np.ones_like(run.t)
    hum = np.sqrt(4 * G / (a * np.radians(tilt_deg))) / left / (2 * np.pi)
    curves = [
        Curve("tilt [deg]", run.t, np.degrees(tilt), (run.t, np.degrees(known))),
        Curve("rounds of the contact [Hz]", run.t, pace, (run.t, hum), title="theory: thin disc"),
    ]
    force = run.force("table").force[-1]
    values = {"ends_s": ends, "tilt_deg": np.degrees(tilt[-1]), "lost_J": energy[0] - energy[-1],
              "spare": mu - np.hypot(force[0], force[1]) / force[2]}  # fmt: skip
    return Measured(values, [run], curves)


demo = Demo(
    __name__,
    title="The end of Euler's disc",
    question="Why does a spun coin, which loses its energy so slowly, stop all of a sudden with a shriek?",
    beats=(
        Beat(0.0, "10 degrees aslant: a low hum."),
        Beat(share(0.5), "Lower, and faster."),
        Beat(share(1.0), "1.5 degrees. Its last moment, at 5.2 s, was known at the start."),
    ),
    why="The flatter the coin lies, the faster its contact runs around the edge. Friction against rolling takes its "
    "share from every round, so the loss per second grows just as the energy runs out: the tilt falls as the square "
    "of the time that is left and the hum rises as one over it. Both come to their end at a moment that is known from "
    "the start. The last part is not shown: the centre drifts into circles, for which friction is too weak at last, "
    "and a coin that lies on its whole edge touches in no one point.",
    equation="t = 3/2 (a / arm) sqrt(a tilt / g);  tilt ~ (t - now)^2,  W ~ 1 / (t - now)",
    symbols={
        "t": Symbol("time until the end", "s"),
        "a": Symbol("radius", "m", "a"),
        "g": GRAVITY,
        "W": Symbol("rate of the contact", "rad/s"),
    },
    source="Moffatt, Nature 404 (2000) 833; Leine, Archive of Applied Mechanics 79 (2009) 1063",
    quantities={
        "ends_s": Quantity("it ends after", "s", relative=0.03),  # the formula is of first order in tilt and rho/a
        "tilt_deg": Quantity("tilt at t", "deg", relative=3e-3),  # the table gives way
        "lost_J": Quantity("energy lost by t", "J", relative=1e-3, absolute=1e-6),
        "spare": Quantity("friction to spare at t", absolute=0.03),  # it wobbles by that much
    },
    ablation=Ablation("loss", "with no friction against rolling it goes round for ever", {"arm": 0.0},
                      values=lambda: {"ends_s": np.inf, "lost_J": 0.0}),
    show={"curves": [("omega", "disc")], "traces": [], "speed": 0.1},
    ranges={"tilt_deg": (9.5, 11.0), "mu": (0.75, 0.9), "a": (0.037, 0.043), "arm": (2.8e-4, 3.1e-4), "t": (2.4, 2.8)},
)  # fmt: skip
