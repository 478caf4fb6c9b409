"""A pendulum keeps its plane among the stars while the Earth turns under it."""

import numpy as np

from mbsd3d import GROUND, Body, Distance, Revolute, SpeedDriver, System, Weight, shapes, simulate

from ..form import GRAVITY, Ablation, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share
from ..quadrature import cross, motion

G = 9.81  # m/s^2


def mechanism(*, l=10.0, lat_deg=48.85, Omega_e=0.03, amp=2.0) -> System:
    """Build a laboratory (x north, y west, z up) turning with the Earth; bob on a rod of l [m], released amp [m] to the
    north.
    """
    place = np.array([amp, 0, -np.sqrt(l**2 - amp**2)])
    rate = earth(lat_deg, Omega_e)
    floor = shapes.Cylinder(1.5 * amp, 0.01 * l, at=(0, 0, -1.02 * l))
    lab = Body("laboratory", 1.0, (1, 1, 1), omega=rate, shape=floor)
    velocity = np.cross(rate, place)
    bob = Body("bob", 28.0, (1, 1, 1), position=place, velocity=velocity, omega=rate, shape=shapes.Sphere(0.02 * l))
    joints = [
        Revolute(GROUND, lab, at=(0, 0, 0), axis=earth(lat_deg, 1.0), name="axis of the Earth"),
        SpeedDriver(GROUND, lab, axis=earth(lat_deg, 1.0), speed=Omega_e, name="day"),
        Distance(lab, bob, at_a=(0, 0, 0), at_b=place, name="rod"),
    ]
    weight = Weight(lab, bob, acceleration=(0, 0, -G), name="weight")
    return System([lab, bob], joints, [weight], gravity=(0, 0, 0))


def earth(lat_deg, Omega_e):
    """Return the angular velocity of the Earth in the axes north, west, up [rad/s]."""
    lat = np.radians(lat_deg)
    return Omega_e * np.array([np.cos(lat), 0, np.sin(lat)])


def own(times, *, l, lat_deg, Omega_e, amp):
    """Integrate r'' = g - 2 O x v - O x (O x r) - k r in the laboratory, k so that |r| stays l, shape (times, 3)."""
    O = tuple(earth(lat_deg, Omega_e).tolist())

    def rate(_, y):
        r, v = y[:3].tolist(), y[3:].tolist()
        coriolis, outwards = cross(O, v), cross(O, cross(O, r))
        a = [-2 * coriolis[k] - outwards[k] - (G if k == 2 else 0) for k in range(3)]
        pull = sum(v[k] ** 2 + r[k] * a[k] for k in range(3)) / l**2
        return [*v, *(a[k] - pull * r[k] for k in range(3))]

    return motion(rate, np.array([amp, 0, -np.sqrt(l**2 - amp**2), 0, 0, 0]), times)[:, :3]


def theory(*, l, lat_deg, Omega_e, amp, t):
    """Return the values of own equations in the turning laboratory; for small swings the plane turns at -O sin(lat)."""
    require(abs(amp) < l, f"demo 'foucault': amp = {amp:g} m is not less than the rod, {l:g} m; give less")
    north, west, _ = own(np.array([0.0, t]), l=l, lat_deg=lat_deg, Omega_e=Omega_e, amp=amp)[-1]
    return {"north_m": north, "west_m": west}


def measure(build, terms, *, l, lat_deg, Omega_e, amp, t=44.0) -> Measured:
    """Measure the position of the bob in the laboratory after t, and its path."""
    run = simulate(build(), t, rtol=1e-13, output=np.linspace(0, t, 1001), **terms)
    north, west, _ = np.einsum("tji,tj->it", run.rotation("laboratory"), run.position("bob"))
    known = own(run.t, l=l, lat_deg=lat_deg, Omega_e=Omega_e, amp=amp)
    trail = Curve(
        "west [m]", north, west, (known[::8, 0], known[::8, 1]), "north [m]", "the trail in the sand", equal=True
    )
    return Measured({"north_m": north[-1], "west_m": west[-1]}, [run], [trail])


demo = Demo(
    __name__,
    title="Foucault's pendulum",
    question="How does a pendulum show that the Earth turns?",
    beats=(
        Beat(0.0, "The pendulum swings in one plane."),
        Beat(22.0, "The floor has turned under it by 28 degrees."),
        Beat(share(1.0), "57 degrees. The Earth has turned by 76."),
    ),
    why="The pendulum keeps its plane as well as it can, and the floor turns under it. Only the part of the Earth's "
    "turn about the local vertical counts, sin(latitude) of it: a whole turn a day at the pole, none at the equator. "
    "Released at rest from the floor it does not pass through the middle, because it starts with the floor's own "
    "sideways motion. (The Earth turns 410 times too fast here, so that the plane turns by 57 degrees in 44 s.)",
    equation="r'' = g - 2 W x r' - W x (W x r) - k r; small swings turn at -W sin(lat)",
    symbols={
        "r": Symbol("place of the bob", "m", curve=(0, 0)),
        "W": Symbol("turn of the Earth, much quickened", "rad/s", "Omega_e"),
        "g": GRAVITY,
        "k": Symbol("pull of the wire, over mass and length", "1/s^2"),
    },
    source="Landau, Lifshitz, Mechanics, par. 39; Foucault (1851)",
    quantities={"north_m": Quantity("place at t, north", "m"), "west_m": Quantity("place at t, west", "m")},
    ablation=Ablation("rotation", "on an Earth at rest it swings to and fro in one plane", {"Omega_e": 0.0}),
    show={
        "curves": [("position", "bob")],
        "traces": [("bob", (1, 0, -9.95), "laboratory")],
        "follow": "laboratory",
        "view": (-60, 40),
    },
    sliders=(
        Control("lat_deg", 10.0, 80.0, "deg", "latitude"),
        Control("Omega_e", 0.005, 0.06, "rad/s", "rate of the Earth"),
    ),
    theory_moves=False,
    attempt="go towards the equator: the plane turns ever more slowly. Towards the pole it turns with the Earth.",
)
