"""Tyres at a slip angle, also driven: the brush model, up to the friction circle."""

import numpy as np

from mbsd3d import GROUND, Body, Prismatic, Revolute, SpeedDriver, System, Tyre, shapes, simulate

from ...results.element_loads import TyreLoad
from ..figure import Line
from ..form import Ablation, Against, Beat, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share

STEER_ANGLES = (0.5, 1, 1.5, 2, 3, 4, 5, 6, 8, 10, 12, 15)  # [deg] of the wheels that roll freely
SLIPS = (
    -0.6,
    -0.4,
    -0.25,
    -0.15,
    -0.1,
    -0.06,
    -0.03,
    0.0,
    0.03,
    0.06,
    0.1,
    0.15,
    0.25,
    0.4,
    0.6,
)  # of those that are driven or braked
FILMED_SLIPS = (0.0, 0.06, 0.15, 0.6)  # of the few that the film shows


def mechanism(
    *,
    load=800.0,
    cornering=12.0,
    longitudinal=17.0,
    mu=0.9,
    trail=0.025,
    relaxation=0.1,
    angle=4.0,
    v=8.0,
    r=0.32,
    few=0,
) -> System:
    """Build wheels side by side on carriages at v [m/s], each steered to the left, the last ones by angle [deg], and
    driven; or a few of these only.

    Tyres with a radius r [m] under a load [N]; cornering, longitudinal [1/rad], mu, trail and relaxation [m].
    """
    require(load > 0 and v > 0, "the wheels roll under a load: give load > 0 and v > 0")
    stiffness = load / 0.01  # it sinks by 10 mm
    bodies, joints, forces = [], [], []
    for k, (degrees, slip) in enumerate(wheels(angle, few)):
        turn, at = np.radians(degrees), np.array([0.0, -1.5 * r * k, r - 0.01])
        axle, ahead = np.array([-np.sin(turn), np.cos(turn), 0]), np.array([np.cos(turn), np.sin(turn), 0])
        spin = (1 + slip) * v * ahead[0] / at[2]
        carriage = Body(f"carriage {k}", 30.0, (1, 1, 1), position=at, velocity=(v, 0, 0), shape=shapes.Lines([
            (-r, 0, 1.1 * r), (r, 0, 1.1 * r), (0, 0, 1.1 * r), (0, 0, 0)]))  # fmt: skip
        wheel = Body(f"wheel {k}", 8.0, (0.2, 0.4, 0.2), position=at, omega=spin * axle, shape=[
            shapes.Torus(r - 0.03, 0.03, axle), shapes.Lines([-0.05 * axle, 0.05 * axle])])  # fmt: skip
        rail = Prismatic(GROUND, carriage, at=at, axis=(1, 0, 0), name=f"rail {k}")
        hub = Revolute(carriage, wheel, at=at, axis=axle, name=f"hub {k}")
        joints += [rail, hub, SpeedDriver(rail, v, name=f"way {k}"), SpeedDriver(hub, spin, name=f"motor {k}")]
        forces.append(Tyre(
            GROUND, wheel, axis=axle, radius=r, crown=0.03, stiffness=stiffness, cornering=cornering,
            longitudinal=longitudinal, mu=mu, trail=trail, relaxation=relaxation, name=f"tyre {k}",
        ))  # fmt: skip
        bodies += [carriage, wheel]
    return System(bodies, joints, forces)


def wheels(angle, few=0):
    """Return (steer [deg], slip) of every wheel, or of a few."""
    if few:
        return [(angle, slip) for slip in FILMED_SLIPS]
    return [(float(x), 0.0) for x in STEER_ANGLES] + [(angle, slip) for slip in SLIPS]


def brush(slip_x, slip_y, *, load, cornering, longitudinal, mu, trail):
    """Return (F_x, F_y, M_z) of the brush model of Pacejka: bristles that stick in front, slide behind; theta = s/3."""
    pull = np.array([longitudinal * slip_x, cornering * slip_y])
    theta = np.minimum(np.hypot(*pull) / (3 * mu), 1)
    F_x, F_y = load * pull * (1 - theta + theta**2 / 3) * np.minimum(1, 3 * mu / np.fmax(np.hypot(*pull), 3 * mu))
    return F_x, F_y, -trail * (1 - theta) ** 3 / (1 - theta + theta**2 / 3) * F_y


def theory(*, load, cornering, longitudinal, mu, trail, angle):
    """Return the forces of free rolling at the angle, and of a wheel driven so hard, at the same angle, that it
    slides."""
    tyre = {"load": load, "cornering": cornering, "longitudinal": longitudinal, "mu": mu, "trail": trail}
    side = np.tan(np.radians(angle))
    _, free, moment = brush(0.0, side, **tyre)
    drive, left, _ = brush(SLIPS[-1], side, **tyre)
    return {
        "side_force_N": float(free), "aligning_N_m": float(moment), "left_of_it_N": float(left),
        "drive_force_N": float(drive),
    }  # fmt: skip


def measure(build, terms, *, load, cornering, longitudinal, mu, trail, relaxation, angle, v) -> Measured:
    """Measure forces after sixty relaxation lengths, of all wheels at once."""
    run = simulate(build(), 60 * relaxation / v, rtol=1e-11, output=61, **terms)
    film = simulate(build(few=1), 60 * relaxation / v, rtol=1e-11, output=61, **terms)
    loads = (run.force(f"tyre {k}") for k in range(len(wheels(angle))))
    F = np.array([(x.longitudinal[-1], x.lateral[-1], x.aligning[-1]) for x in loads if isinstance(x, TyreLoad)])
    free, driven = F[: len(STEER_ANGLES)], F[len(STEER_ANGLES) :]
    straight = len(STEER_ANGLES) + SLIPS.index(0.0)
    values = {
        "side_force_N": F[straight, 1], "aligning_N_m": F[straight, 2], "left_of_it_N": driven[-1, 1],
        "drive_force_N": driven[-1, 0],
    }  # fmt: skip
    tyre = {"load": load, "cornering": cornering, "longitudinal": longitudinal, "mu": mu, "trail": trail}
    slips, angles = np.array(SLIPS), np.array(STEER_ANGLES, float)
    _, side, moment = brush(0 * angles, np.tan(np.radians(angles)), **tyre)
    along, across, _ = brush(slips, np.tan(np.radians(angle)) + 0 * slips, **tyre)
    whole, sideways = np.hypot(*driven[:, :2].T), Line("sideways", driven[:, 1], theory=(slips, across))
    curves = [
        Curve("side force [N]", STEER_ANGLES, free[:, 1], (angles, side), along="slip angle [deg]"),
        Curve("aligning moment [N m]", STEER_ANGLES, free[:, 2], (angles, moment), along="slip angle [deg]"),
        Curve("force [N]", SLIPS, whole, (slips, np.hypot(along, across)), along="slip, braked < 0 < driven [-]",
              title=f"at {angle:g} deg", name="force", more=[sideways]),
    ]  # fmt: skip
    return Measured(values, [film, run], curves)


demo = Demo(
    __name__,
    title="Slip of tyres",
    question="Why does a wheel lose its grip sideways when it is driven or braked hard?",
    beats=(
        Beat(0.0, "All four at 4 degrees of slip: the first rolls freely, each further one is driven harder."),
        Beat(share(0.5), "484 N sideways where it rolls freely, 59 N where it is driven hardest."),
    ),
    why="Bristles of the tread stick to the road where they come in and are bent by the slip, until they slide at the "
    "rear of the patch. The more slip, the more of the patch slides, and the force bends off to what friction gives. "
    "Friction knows no directions of its own: what is spent on driving is missing sideways, and the force stays in a "
    "circle. The moment that turns the wheel back fades first, which a driver feels.",
    equation="F = mu N (1 - (1 - s/3)^3),  s = |(C_x slip, C_y tan(angle))| / mu,  s <= 3",
    symbols={
        "F": Symbol("force of the tyre; sideways, rolling freely", "N", curve=(0, 1)),
        "N": Symbol("load", "N", "load"),
        "mu": Symbol("friction", "", "mu"),
        "s": Symbol("slip"),
        "C_x": Symbol("stiffness ahead, over the load", "", "longitudinal"),
        "C_y": Symbol("stiffness sideways, over the load", "", "cornering"),
    },
    source="Pacejka, Tire and Vehicle Dynamics (2012), section 3.2",
    quantities={
        "side_force_N": Quantity("side force when it rolls freely", "N", relative=1e-7),
        "aligning_N_m": Quantity("moment that turns it back", "N m", relative=1e-7, absolute=1e-6),
        "left_of_it_N": Quantity("side force left when it is driven hard", "N", relative=1e-7),
        "drive_force_N": Quantity("drive force then", "N", relative=1e-7),
    },
    ablation=Ablation("limit", "where grip has no limit, driving takes little from the side force", {"mu": 90.0}),
    against=Against("angle", 0.5, 15.0, "slip angle [deg]"),
    show={"follow": "carriage 1", "speed": 0.1, "curves": [("force", "tyre 0"), ("force", "tyre 3")], "traces": [],
          "view": (-60, 35)},
    ranges={"few": None},
)  # fmt: skip
