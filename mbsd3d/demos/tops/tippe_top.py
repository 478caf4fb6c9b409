"""A tippe top turns upside down and lifts its own weight, because it slides."""

import numpy as np

from mbsd3d import DOP853, GROUND, Body, Contact, CustomForce, PointOnPlane, System, rotation, shapes, simulate
from mbsd3d.rotations import matrix

from ..figure import Line
from ..form import Ablation, Beat, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import first
from ..quadrature import cross, motion
from ..rolling_stone import slid

G = 9.81  # m/s^2
STIFFNESS_PER_WEIGHT = 1e4  # [1/m] stiffness of the table over the weight of the top
CREEP_SPEED = 0.01  # [m/s] dry friction is full where the top slides much faster


def sliding(t, bodies, z, parameters, loads, z_dot):
    """Apply -c times the velocity of the lowest point of a sphere of radius r, moved to its centre."""
    c, r = parameters
    u, w = bodies[0].velocity, bodies[0].w
    loads[0, 0] = -c * (u[0] - r * w[1])
    loads[0, 1] = -c * (u[1] + r * w[0])
    loads[0, 3] = r * loads[0, 1]
    loads[0, 4] = -r * loads[0, 0]


def top_of(m, r, a, A, C, theta_deg, spin, sunk=0.0):
    """Return the top on the table, or penetrating it by a depth [m]."""
    tilt = np.radians(theta_deg)
    axis = np.array([np.sin(tilt), 0, np.cos(tilt)])
    form = [shapes.Sphere(r, at=(0, 0, 0)), shapes.Cylinder(0.2 * r, r, at=(0, 0, 1.3 * r), colour="orangered")]
    return Body("top", m, (A, A, C), com=(0, 0, -a), position=(0, 0, r - sunk), velocity=(0, 0, 0),
                orientation=rotation("y", tilt), omega=spin * axis, shape=form)  # fmt: skip


def mechanism(*, m=0.01, r=0.02, a=0.003, A=1.6e-6, C=1.5e-6, c=0.2, theta_deg=10.0, spin=200.0) -> System:
    """Build a sphere of radius r [m], G at a [m] below its centre, (A, A, C) [kg m^2] about G, sliding friction c [N
    s/m].
    """
    top = top_of(m, r, a, A, C, theta_deg, spin)
    table = PointOnPlane(GROUND, top, at=top.position, normal=(0, 0, 1), name="table")
    return System([top], [table], [CustomForce(sliding, on=top, parameters=(c, r), name="sliding")], (0, 0, -G))


def table_of(m):
    """Return (k, c) of a compliant table [N/m, N s/m]."""
    return STIFFNESS_PER_WEIGHT * m * G, m * np.sqrt(STIFFNESS_PER_WEIGHT * G)


def on_contact(*, m, r, a, A, C, mu, theta_deg, spin):
    """Build the same top on a compliant table, with dry friction mu."""
    top, (k, c) = top_of(m, r, a, A, C, theta_deg, spin, 1 / STIFFNESS_PER_WEIGHT), table_of(m)
    ball = shapes.Sphere(r, at=(0, 0, 0))
    rubs = Contact(GROUND, top, ball, stiffness=k, damping=c, friction=mu, creep=CREEP_SPEED, name="table")
    return System([top], forces=[rubs], gravity=(0, 0, -G))


def own(times, *, m, r, a, A, C, c, theta_deg, spin):
    """Integrate axis e, angular velocity w and velocity of G in the plane, by Newton and Euler at G, shape (times, 8).

    The normal force N follows from the height of G, r - a e_z, to whose acceleration w_dot is linear in N.
    """
    tilt, gap = np.radians(theta_deg), (C - A) / A
    e = np.array([np.sin(tilt), 0, np.cos(tilt)])

    def rate(_, y):
        ex, ey, ez, p, q, s, u, v = y.tolist()  # plain numbers: ten times faster here
        along = ex * p + ey * q + ez * s
        turn = cross((p, q, s), (ex, ey, ez))
        arm = (a * ex, a * ey, a * ez - r)
        slip = cross((p, q, s), arm)
        fx, fy = -c * (u + slip[0]), -c * (v + slip[1])
        moment = cross(arm, (fx, fy, 0.0))
        free = [moment[k] / A - gap * along * turn[k] for k in range(3)]  # A w_dot but for its part along e
        per_N = [arm[1] / A, -arm[0] / A, 0.0]
        for x in (free, per_N):
            part = (A / C - 1) * (ex * x[0] + ey * x[1] + ez * x[2])
            x[0], x[1], x[2] = x[0] + part * ex, x[1] + part * ey, x[2] + part * ez
        lift = cross(free, (ex, ey, ez))[2] + cross((p, q, s), turn)[2]
        N = (m * G - m * a * lift) / (1 + m * a * cross(per_N, (ex, ey, ez))[2])
        return [*turn, *(free[k] + N * per_N[k] for k in range(3)), fx / m, fy / m]

    return motion(rate, np.concatenate([e, spin * e, [0, 0]]), times)


def own_on_contact(times, *, m, r, a, A, C, mu, theta_deg, spin):
    """Return the cosine of the tilt on a compliant table; see `slid`; shape (times,)."""
    n, (k, c) = matrix(rotation("y", np.radians(theta_deg)))[2], table_of(m)
    return slid(times, m=m, g=G, I=(A, A, C), radii=(r, r, r), com=(0, 0, -a), k=k, c=c, mu=mu, creep=CREEP_SPEED,
                n=n, w=(0, 0, spin), v=(0, 0, 0), height=r - 1 / STIFFNESS_PER_WEIGHT - a * n[2])[:, 2]  # fmt: skip


def theory(*, m, r, a, A, C, c, mu, theta_deg, spin, t):
    """Return the values of own equations for both tables; Jellett's integral L . (r e_z - a e) is constant for any
    friction.
    """
    require(c >= 0, f"demo 'tippe_top': c = {c:g} N s/m: rubbing takes energy away; give c >= 0")
    top, ends = {"m": m, "r": r, "a": a, "A": A, "C": C, "theta_deg": theta_deg, "spin": spin}, np.array([0.0, t])
    y = own(ends, c=c, **top)[-1]
    return {
        "axis_height_cos": y[2],
        "jellett_Nms_m": C * spin * (a - r * np.cos(np.radians(theta_deg))),
        "spin_vertical_rad_s": y[5],
        "contact_axis_height_cos": own_on_contact(ends, mu=mu, **top)[-1],
    }


def measure(build, terms, *, m, r, a, A, C, c, theta_deg, spin, mu=0.2, t=4.0) -> Measured:
    """Measure attitude, Jellett's integral and spin about the vertical after t, then the same top with dry friction."""
    top, times = {"m": m, "r": r, "a": a, "A": A, "C": C, "theta_deg": theta_deg, "spin": spin}, np.linspace(0, t, 401)
    run = simulate(build(), t, rtol=1e-12, output=times, **terms)
    dry = simulate(on_contact(mu=mu, **top), t, method=DOP853(stiff="run"), rtol=1e-10, output=times, **terms)
    R, w = run.rotation("top"), run.omega_body("top")
    axis, soft = R[:, :, 2], dry.rotation("top")[:, 2, 2]
    L = np.einsum("tij,tj->ti", R, w * [A, A, C])
    jellett = np.einsum("ti,ti->t", L, a * axis - [0, 0, r])
    known = own(run.t, c=c, **top)
    curves = [
        Curve("cosine of the tilt [-]", run.t, axis[:, 2], (run.t, known[:, 2]), more=[Line("dry friction", soft)]),
        Curve("spin about its axis [rad/s]", run.t, w[:, 2], (run.t, np.sum(known[:, :3] * known[:, 3:6], axis=1))),
    ]
    values = {
        "axis_height_cos": axis[-1, 2], "jellett_Nms_m": jellett[-1], "spin_vertical_rad_s": run.omega("top")[-1, 2],
        "contact_axis_height_cos": soft[-1],
    }  # fmt: skip
    return Measured(values, [run], curves)


demo = Demo(
    __name__,
    title="The tippe top",
    question="Why does a tippe top turn upside down and raise its own weight?",
    beats=(
        Beat(0.0, "Spun on its round belly."),
        Beat(first(lambda run: run.body_axis("top", (0, 0, 1))[:, 2] < 0), "It lies down on its side ..."),
        Beat(
            first(lambda run: run.body_axis("top", (0, 0, 1))[:, 2] < -0.95),
            "... and gets up onto its stem: its weight has been lifted.",
        ),
    ),
    why="The top's centre of mass lies below the centre of its sphere, so that it touches the table a little off its "
    "axis and slides there. Friction acts at right angles to the spin and, as with any top, moves the axis "
    "sideways: here upwards, until it stands on its stem. The lift takes energy from the spin. One combination "
    "of the angular momenta cannot change: that along the line from the centre of mass to the contact, whatever "
    "the friction: in proportion to the speed, as computed first, or dry, on a table that gives way.",
    equation="Jellett: L . (r e_z - a e) = const",
    symbols={
        "L": Symbol("angular momentum", "N m s"),
        "r": Symbol("radius", "m", "r"),
        "a": Symbol("centre of mass below the middle", "m", "a"),
        "e": Symbol("axis of the top"),
        "e_z": Symbol("upwards"),
    },
    source="Cohen, Am. J. Phys. 45 (1977) 12; Bou-Rabee, Marsden, Romero, SIAM Review 50 (2008) 325; Jellett (1872)",
    quantities={
        "axis_height_cos": Quantity("cosine of the tilt at the end"),
        "jellett_Nms_m": Quantity("Jellett's integral", "kg m^3/s", absolute=1e-14),
        "spin_vertical_rad_s": Quantity("spin about the vertical", "rad/s"),
        "contact_axis_height_cos": Quantity(
            "cosine of the tilt at the end, dry friction and a table that gives way", absolute=1e-8
        ),  # a hundred times the tolerance of its run
    },
    ablation=Ablation(
        "friction",
        "it precesses for ever (without w x I w it would still turn over: its moments are nearly equal)",
        {"c": 0.0, "mu": 0.0},
    ),  # fmt: skip
    show={
        "curves": [("omega_body", "top"), ("com", "top")],
        "traces": [],
        "follow": "top",
        "hidden": ["joints"],
        "speed": 0.25,
    },
)
