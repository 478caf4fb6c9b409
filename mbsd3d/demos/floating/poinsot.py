"""A free body, its ellipsoid of inertia rolling on a plane in space: after one round it is turned by an area."""

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import ellipk

from mbsd3d import GROUND, Body, Fixed, System, shapes, simulate
from mbsd3d.base.rotations import H, matrix, quaternion_from_matrix

from ..form import Ablation, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share
from ..quadrature import motion

SIZE = 0.5  # [m] of the longest half axis of the ellipsoid
ROUNDS, PATH_COUNT = 3, 361  # [1] rounds of the run, points of the drawn curves
LIFTED = 1.03  # [1] of the ellipsoid: the curve on it lies a little outside


def constants(I, w):
    """Return twice the energy [J], angular momentum [N m s], and the number of the axis that the spin goes round."""
    i, w = np.array(I), np.array(w)
    double, L = float(i @ w**2), float(np.linalg.norm(i * w))
    return double, L, 2 if L**2 > double * i[1] else 0


def upright(I, w):
    """Return the orientation in which the angular momentum points up, (3, 3)."""
    up = np.array(I) * np.array(w)
    up = up / np.linalg.norm(up)  # in the body
    aside = np.cross(up, (0.0, 1.0, 0.0))
    aside /= np.linalg.norm(aside)
    return np.array([aside, np.cross(up, aside), up])


def mechanism(*, I=(1.0, 1.9, 2.6), w=(1.2, 1.0, 1.3)) -> System:
    """Build a body with moments I [kg m^2] at w [rad/s], body axes, its ellipsoid of inertia x' I x = 2 T and the plane
    that it rolls on, w . L / L = 2 T / L from its centre; curves where they touch are drawn on both.
    """
    double, L, _ = constants(I, w)
    half = np.sqrt(double / np.array(I))
    scale, turned = SIZE / half.max(), upright(I, w)
    t = np.linspace(0.0, ROUNDS * period(I, w), ROUNDS * PATH_COUNT)
    spins, e = tumbling(I, w, turned, t)
    on_body = LIFTED * scale * spins[: PATH_COUNT + 1]
    on_plane = scale * np.einsum("tij,tj->ti", matrix(e), spins)
    form = shapes.Ellipsoid(scale * half, colour="steelblue"), shapes.Lines(on_body, colour="gold")
    body = Body("body", 1.0, I, omega=turned @ np.array(w), orientation=quaternion_from_matrix(turned), shape=form)
    height = np.array([0.0, 0.0, scale * double / L])
    around = np.linspace(0.0, 2.0 * np.pi, 73)
    rim = 1.2 * SIZE * np.column_stack([np.cos(around), np.sin(around), 0.0 * around])
    drawn = shapes.Lines(on_plane - height, colour="crimson"), shapes.Lines(rim, colour="gray")
    plane = Body("plane", 1.0, (1, 1, 1), position=height, shape=drawn)
    return System([body, plane], [Fixed(GROUND, plane, at=height, name="space")], gravity=(0, 0, 0))


def tumbling(I, w, turned, times):
    """Return angular velocities [rad/s] (times, 3), body axes, and unit quaternions (times, 4): Euler's equations."""
    i = np.array(I)

    def rate(_, y):
        spin = y[:3]
        return np.concatenate([np.cross(i * spin, spin) / i, 0.5 * H(y[3:]) @ (matrix(y[3:]) @ spin)])

    y = motion(rate, np.concatenate([w, quaternion_from_matrix(turned)]), times, rtol=1e-9)
    return y[:, :3], y[:, 3:] / np.linalg.norm(y[:, 3:], axis=1)[:, None]


def period(I, w):
    """Return the time [s] after which the spin is what it was: 4 K(m) / p, axes 1 and 3 exchanged for a round about
    axis 1.
    """
    i = np.array(I)
    double, L, around = constants(I, w)
    a, b, c = i if around == 2 else i[::-1]
    wide = (c - b) * (L**2 - double * a)
    require(wide > 0.0, "demo 'poinsot': the spin lies on the separatrix or on an axis; give another w")
    m = (b - a) * (double * c - L**2) / wide
    return 4 * ellipk(m) / np.sqrt(wide / i.prod())


def solid_angle(I, w):
    """Return the solid angle [sr] of the cone of L in the body, the integral of 1 - cos over the angle about its axis.

    On it sum l^2 = 1 and sum l^2 / I = 2 T / L^2, so the square of its distance from the axis is r^2 (c^2 / I_1 + s^2 /
    I_2 - 1 / I_3) = 2 T / L^2 - 1 / I_3.
    """
    inverse = 1 / np.array(I)
    double, L, around = constants(I, w)
    first, second = (k for k in range(3) if k != around)

    def one_less_cosine(angle):
        across = inverse[first] * np.cos(angle) ** 2 + inverse[second] * np.sin(angle) ** 2 - inverse[around]
        return 1.0 - np.sqrt(1.0 - (double / L**2 - inverse[around]) / across)

    return quad(one_less_cosine, 0.0, 2 * np.pi, epsabs=1e-13, epsrel=1e-13)[0]


def theory(*, I, w):
    """Return the period, and the turn 2 T tau / L less the solid angle, of a round about axis 3, or more by it, about
    axis 1, as that goes the other way round.
    """
    require(I[0] < I[1] < I[2], f"demo 'poinsot': I = {I}: give three moments that grow")
    double, L, around = constants(I, w)
    tau = period(I, w)
    turn = double * tau / L + (-1 if around == 2 else 1) * solid_angle(I, w)
    return {"turn_deg": np.degrees(wrapped(turn)), "round_s": tau, "plane_rad_s": double / L, "leaves_rad_s": 0.0}


def wrapped(angle):
    """Return an angle within half a turn of 0 [rad]."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


def measure(build, terms, *, I, w) -> Measured:
    """Measure when the spin comes back, how far the body has then turned about L, and w . L / L."""
    tau = period(I, w)
    run = simulate(build(), ROUNDS * tau, rtol=1e-12, output=ROUNDS * 400 + 1, **terms)
    k = int(np.argmin(np.abs(w)))  # a spin that passes its start twice a round, once each way

    def spin(t):
        state = run.at(t)
        return float(matrix(state.q[3:7])[:, k] @ state.v[3:6])

    early, late = 0.9 * tau, 1.1 * tau
    moves = (spin(early) - w[k]) * (spin(late) - w[k]) < 0.0
    found = brentq(lambda t: spin(t) - w[k], early, late, xtol=1e-13) if moves else tau
    start, end = (matrix(run.at(t).q[3:7]) for t in (0.0, found))
    up = np.array([0.0, 0.0, 1.0])
    moved = end @ start.T
    aside = moved @ (1.0, 0.0, 0.0)
    turn = np.arctan2(np.cross((1.0, 0.0, 0.0), aside) @ up, aside[0])
    height = run.omega("body") @ up
    values = {
        "turn_deg": np.degrees(turn), "round_s": found, "plane_rad_s": height[0],
        "leaves_rad_s": np.ptp(height),
    }  # fmt: skip
    rates = run.omega_body("body")
    curves = [
        Curve("spin about axis 2, in the body [rad/s]", run.t, rates[:, 1]),
        Curve("y of the contact [rad/s]", run.omega("body")[:, 0], run.omega("body")[:, 1], along="x [rad/s]",
              title="on the plane", equal=True),
    ]  # fmt: skip
    return Measured(values, [run], curves)


demo = Demo(
    __name__,
    title="The body that rolls on a plane in space",
    question="How far has a tumbling body turned when its spin comes back to where it was?",
    beats=(
        Beat(0.0, "The ellipsoid of its moments touches a plane that nobody built."),
        Beat(share(0.16), "It rolls on it and never slips."),
        Beat(6.7734, "The spin is where it was in the body, and the body is turned by 39 degrees."),
    ),
    why="Energy and angular momentum stay, so the tip of the spin keeps its distance from the middle along the angular "
    "momentum: the ellipsoid of inertia rolls without slip on a plane that nobody built. On the ellipsoid the contact "
    "runs round a closed curve, and after one round the spin in the body is what it was. The body is not: it has "
    "turned about the angular momentum, by an angle of which one part is an area, that of the cone which the angular "
    "momentum draws in the body.",
    equation="w . L/L = 2 T/L; turn = 2 T tau/L - area of the cone of L",
    symbols={
        "w": Symbol("spin, about the first axis of the body", "rad/s", curve=(0, 0), arrow="angular velocity"),
        "L": Symbol("angular momentum", "N m s", lambda I, w: float(np.linalg.norm(np.multiply(I, w))),
                    arrow="angular momentum"),
        "T": Symbol("energy", "J", lambda I, w: 0.5 * float(np.dot(I, np.square(w)))),
        "tau": Symbol("time of a round", "s"),
    },
    source="Poinsot, Theorie nouvelle de la rotation (1834); Montgomery, American Journal of Physics 59 (1991) 394",
    quantities={
        "turn_deg": Quantity("turn about L after one round", "deg", absolute=1e-6),
        "round_s": Quantity("time of a round", "s", relative=1e-9),
        "plane_rad_s": Quantity("distance of the plane, in spin", "rad/s"),
        "leaves_rad_s": Quantity("how far that changes", "rad/s"),
    },
    ablation=Ablation("gyroscopic", "the spin stays where it is in the body, and nothing rolls",
                      values=lambda *, I, w: {"plane_rad_s": constants(I, w)[0] / constants(I, w)[1]}),
    show={"curves": [("omega_body", "body")], "shown": ["angular velocity", "angular momentum"], "traces": [],
          "view": (-60, 40), "hidden": ["joints", "joint names", "body names"]},
    ranges={"I": ((0.95, 1.05), (1.85, 1.95), (2.5, 2.7))},
    sliders=(
        Control("w[1]", 0.3, 1.8, "rad/s", "spin about the middle axis"),
    ),
    attempt="spin it more about the middle axis: the curve on the ellipsoid opens towards the separatrix, "
    "and that on the plane waves wider.",
)  # fmt: skip
