"""A tippe top turns upside down and lifts its own weight, because it slides."""

import numpy as np

from mbsd3d import DOP853, GROUND, Body, Contact, System, rotation, shapes, simulate
from mbsd3d.rotations import matrix

from ..form import Ablation, Curve, Demo, Measured, Quantity
from ..stones import slid

G = 9.81  # m/s^2
PER_WEIGHT = 1e4  # 1/m: stiffness of the table over the weight of the top


def table(m):
    """(k, c) of the table [N/m, N s/m]."""
    return PER_WEIGHT * m * G, m * np.sqrt(PER_WEIGHT * G)


def mechanism(*, m=0.01, r=0.02, a=0.003, A=1.6e-6, C=1.5e-6, mu=0.2, creep=0.01, theta_deg=10.0, spin=200.0) -> System:
    """Sphere of radius r [m], G at a [m] below its centre, (A, A, C) [kg m^2] about G, on friction mu, which is
    full where it slides much faster than ``creep`` [m/s]."""
    tilt, (k, c), ball = np.radians(theta_deg), table(m), shapes.Sphere(r, at=(0, 0, 0))
    axis = np.array([np.sin(tilt), 0, np.cos(tilt)])
    form = [ball, shapes.Cylinder(0.2 * r, r, at=(0, 0, 1.3 * r), colour="orangered")]
    top = Body("top", m, (A, A, C), com=(0, 0, -a), position=(0, 0, r - 1 / PER_WEIGHT), velocity=(0, 0, 0),
               orientation=rotation("y", tilt), omega=spin * axis, shape=form)  # fmt: skip
    rubs = Contact(GROUND, top, ball, stiffness=k, damping=c, friction=mu, creep=creep, name="table")
    return System([top], forces=[rubs], gravity=(0, 0, -G))


def own(times, *, m, r, a, A, C, mu, creep, theta_deg, spin):
    """(times, 10) of the vertical, angular velocity and velocity in axes of the top, and height; see `slid`."""
    n, (k, c) = matrix(rotation("y", np.radians(theta_deg)))[2], table(m)
    return slid(times, m=m, g=G, I=(A, A, C), radii=(r, r, r), com=(0, 0, -a), k=k, c=c, mu=mu, creep=creep,
                n=n, w=(0, 0, spin), v=(0, 0, 0), height=r - 1 / PER_WEIGHT - a * n[2])  # fmt: skip


def theory(*, m, r, a, A, C, mu, creep, theta_deg, spin, t):
    """Own equations for the attitude; Jellett's integral L . (r e_z - a e) is what it was, whatever the friction."""
    y = own(np.array([0.0, t]), m=m, r=r, a=a, A=A, C=C, mu=mu, creep=creep, theta_deg=theta_deg, spin=spin)[-1]
    jellett = C * spin * (a - r * np.cos(np.radians(theta_deg)))
    return {"axis_height_cos": y[2], "jellett_Nms_m": jellett, "spin_vertical_rad_s": y[:3] @ y[3:6]}


def measure(build, terms, *, m, r, a, A, C, mu, creep, theta_deg, spin, t=4.0) -> Measured:
    """Attitude, Jellett's integral and spin about the vertical after t."""
    run = simulate(build(), t, method=DOP853(stiff="run"), rtol=1e-11, output=np.linspace(0, t, 401), **terms)
    R, w = run.rotation("top"), run.omega_body("top")
    axis = R[:, :, 2]
    L = np.einsum("tij,tj->ti", R, w * [A, A, C])
    jellett = np.einsum("ti,ti->t", L, a * axis - [0, 0, r])
    known = own(run.t, m=m, r=r, a=a, A=A, C=C, mu=mu, creep=creep, theta_deg=theta_deg, spin=spin)
    curves = [
        Curve("cosine of the tilt [-]", run.t, axis[:, 2], (run.t, known[:, 2])),
        Curve("spin about its axis [rad/s]", run.t, w[:, 2], (run.t, known[:, 5])),
    ]
    values = {
        "axis_height_cos": axis[-1, 2], "jellett_Nms_m": jellett[-1], "spin_vertical_rad_s": run.omega("top")[-1, 2],
    }  # fmt: skip
    return Measured(values, [run], curves)


demo = Demo(
    __name__,
    title="The tippe top",
    question="Why does a tippe top turn upside down and raise its own weight?",
    why="The top's centre of mass lies below the centre of its sphere, so that it touches the table a little off its "
    "axis and slides there. Friction acts at right angles to the spin and, as with any top, moves the axis "
    "sideways: here upwards, until it stands on its stem. The lift takes energy from the spin. One combination "
    "of the angular momenta cannot change: that along the line from the centre of mass to the contact, whatever "
    "the friction.",
    equation="Jellett: L . (r e_z - a e) = const",
    source="Cohen, Am. J. Phys. 45 (1977) 12; Bou-Rabee, Marsden, Romero, SIAM Review 50 (2008) 325; Jellett (1872)",
    quantities={
        "axis_height_cos": Quantity("cosine of the tilt at the end"),
        "jellett_Nms_m": Quantity("Jellett's integral", "kg m^3/s", absolute=1e-14),
        "spin_vertical_rad_s": Quantity("spin about the vertical", "rad/s"),
    },
    ablation=Ablation(
        "friction",
        "without friction it precesses for ever (without w x I w it would still turn over: "
        "its moments are nearly equal)",
        {"mu": 0.0},
    ),  # fmt: skip
    show={"curves": [("omega_body", "top"), ("com", "top")], "traces": [], "follow": "top", "speed": 0.25},
)
