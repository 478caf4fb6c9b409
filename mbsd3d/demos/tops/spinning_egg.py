"""A hard-boiled egg that is spun on its side rises and stands on its end."""

import numpy as np

from mbsd3d import DOP853, GROUND, Body, Contact, System, rotation, shapes, simulate
from mbsd3d.rotations import matrix

from ..form import Ablation, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import first
from ..rolling_stone import slid
from .tippe_top import STIFFNESS_PER_WEIGHT, table_of

G = 9.81  # m/s^2
ASPECT_RATIO_MAX, LEAN_MAX = (
    1.42,
    11.0,
)  # over its breadth; deg from lying: beyond, the balance is off by more than a part in 100


def moments(m, a, b):
    """Return (A, A, C) of a homogeneous egg [kg m^2]."""
    return m / 5 * np.array([a**2 + b**2, a**2 + b**2, 2 * b**2])


def height(a, b, tilt):
    """Return the height of the centre over the table [m]."""
    return np.hypot(a * np.cos(tilt), b * np.sin(tilt))


def mechanism(*, m=0.06, a=0.029, b=0.022, mu=0.2, creep=0.01, tilt_deg=85.0, spin=160.0) -> System:
    """Build an egg of length 2 a and breadth 2 b [m], its axis tilted from the vertical, spun about the vertical
    [rad/s], on friction mu, which is full where it slides much faster than ``creep`` [m/s].
    """
    tilt, (k, c), form = np.radians(tilt_deg), table_of(m), shapes.Ellipsoid((b, b, a))
    mark = shapes.Torus(0.999 * b, 0.04 * b, colour="orangered")
    egg = Body("egg", m, moments(m, a, b), position=(0, 0, height(a, b, tilt) - 1 / STIFFNESS_PER_WEIGHT),
        velocity=(0, 0, 0),
               orientation=rotation("y", tilt), omega=(0, 0, spin), shape=[form, mark])  # fmt: skip
    rubs = Contact(GROUND, egg, form, stiffness=k, damping=c, friction=mu, creep=creep, name="table")
    return System([egg], forces=[rubs], gravity=(0, 0, -G))


def own(times, *, m, a, b, mu, creep, tilt_deg, spin):
    """Integrate the vertical, angular velocity and velocity in axes of the egg, and height; see `slid`; shape (times,
    10).
    """
    tilt, (k, c) = np.radians(tilt_deg), table_of(m)
    n = matrix(rotation("y", tilt))[2]
    return slid(times, m=m, g=G, I=moments(m, a, b), radii=(b, b, a), com=(0, 0, 0), k=k, c=c, mu=mu, creep=creep,
                n=n, w=spin * n, v=(0, 0, 0), height=height(a, b, tilt) - 1 / STIFFNESS_PER_WEIGHT)  # fmt: skip


def seen(mu, *, m, a, b, creep, tilt_deg, spin, t):
    """Return attitude and spin at t by own equations."""
    y = own(np.array([0.0, t]), m=m, a=a, b=b, mu=mu, creep=creep, tilt_deg=tilt_deg, spin=spin)[-1]
    return {"axis_height_cos": y[2], "spin_vertical_rad_s": y[:3] @ y[3:6]}


def slippery(*, m, a, b, creep, tilt_deg, spin, t):
    """Return the same values without friction."""
    return seen(0.0, m=m, a=a, b=b, creep=creep, tilt_deg=tilt_deg, spin=spin, t=t)


def theory(*, m, a, b, mu, creep, tilt_deg, spin, t):
    """Return the values of own equations, and the spin on its end by Jellett's integral, nearly constant for a fast
    egg.

    Where the gyroscopic moments balance, L = A W along the vertical, and L times the height stays: A W h = C W_1 a.
    """
    require(a > b > 0, f"an egg is longer than it is broad: give a above b = {b}, not {a}")
    require(
        a < ASPECT_RATIO_MAX * b and abs(tilt_deg - 90) < LEAN_MAX,
        "the moments balance from the start on in a stout egg that "
        f"lies: give a below {ASPECT_RATIO_MAX} b and tilt_deg within {LEAN_MAX} of 90",
    )
    found, (A, _, C) = seen(mu, m=m, a=a, b=b, creep=creep, tilt_deg=tilt_deg, spin=spin, t=t), moments(m, a, b)
    require(found["axis_height_cos"] > 0.9, f"the egg does not stand after t = {t} s: give a greater t or mu, and a "
            "spin near 160 rad/s: a slow egg never stands, a fast one rises slowly")  # fmt: skip
    return {**found, "stands_at_rad_s": A * spin * height(a, b, np.radians(tilt_deg)) / (C * a)}


def measure(build, terms, *, m, a, b, mu, creep, tilt_deg, spin, t=2.5) -> Measured:
    """Measure attitude and spin about the vertical at t, when it stands."""
    run = simulate(build(), t, method=DOP853(stiff="run"), rtol=1e-11, output=801, **terms)
    axis, vertical = run.rotation("egg")[:, :, 2], run.omega("egg")[:, 2]
    y = own(run.t, m=m, a=a, b=b, mu=mu, creep=creep, tilt_deg=tilt_deg, spin=spin)
    curves = [
        Curve("tilt [deg]", run.t, np.degrees(np.arccos(axis[:, 2])), (run.t, np.degrees(np.arccos(y[:, 2])))),
        Curve("spin about the vertical [rad/s]", run.t, vertical, (run.t, np.sum(y[:, :3] * y[:, 3:6], axis=1))),
    ]
    values = {"axis_height_cos": axis[-1, 2], "spin_vertical_rad_s": vertical[-1], "stands_at_rad_s": vertical[-1]}
    return Measured(values, [run], curves)


demo = Demo(
    __name__,
    title="The spinning egg",
    question="Why does a hard-boiled egg that is spun on its side stand up on its end?",
    beats=(
        Beat(0.0, "Spun on its side."),
        Beat(first(lambda run: run.com('egg')[:, 2] > 0.0255), "It slips a little at its foot, and that lifts it."),
        Beat(first(lambda run: run.com('egg')[:, 2] > 0.0288), "It stands."),
    ),
    why="A spinning egg that leans touches the table off the vertical through its middle, so its shell slides there. "
    "That friction acts across the axis, and as with any top the axis turns at right angles to the push: up. It goes "
    "slowly, because a fast spin keeps the gyroscopic moments in balance all the way. Then the angular momentum "
    "times the height hardly changes: the egg rises and its angular momentum falls, but its spin grows a little, as "
    "its moment of inertia is smallest on its end. A raw egg cannot, its inside does not spin along.",
    equation="Jellett, nearly: A W h = const;  C W_1 a = A W b",
    symbols={
        "W": Symbol("spin about the vertical", "rad/s", curve=(0, 2)),
        "h": Symbol("height of the centre", "m", curve=(1, 2)),
        "W_1": Symbol("spin when it stands", "rad/s"),
        "a": Symbol("half length", "m", "a"),
        "b": Symbol("half width", "m", "b"),
        "A": Symbol("moment across", "kg m^2", lambda m, a, b: m * (a**2 + b**2) / 5),
        "C": Symbol("moment along", "kg m^2", lambda m, b: 2 * m * b**2 / 5),
    },
    source="Moffatt, Shimomura, Nature 416 (2002) 385; Moffatt, Shimomura, Branicki, Proc. R. Soc. A 460 (2004) 3643",
    quantities={
        "axis_height_cos": Quantity("cosine of the tilt at t", relative=1e-7),
        "spin_vertical_rad_s": Quantity("spin about the vertical at t", "rad/s"),
        "stands_at_rad_s": Quantity("it stands spinning at", "rad/s", relative=1e-2),  # the balance is not exact
    },
    ablation=Ablation("friction", "it stays on its side", {"mu": 0.0}, values=slippery),
    show={"curves": [("omega", "egg"), ("com", "egg")], "traces": [], "follow": "egg", "speed": 0.1},
    ranges={"mu": (0.18, 0.24), "tilt_deg": (80.0, 88.0), "spin": (150.0, 175.0), "a": (0.028, 0.031),
            "b": (0.0215, 0.0225), "t": (2.4, 2.8)},
    sliders=(
        Control("spin", 130.0, 180.0, "rad/s"),
        Control("mu", 0.18, 0.24, "", "friction"),
    ),
    theory_moves=False,
    attempt="spin it slower: it stands up later, or not at all.",
)  # fmt: skip
