"""An engine's spin turns a pull on the stick into a swing of the nose to the side."""

from typing import Any

import numpy as np

from mbsd3d import Body, Revolute, SpeedDriver, System, Torque, shapes, simulate

from ..form import Ablation, Against, Beat, Control, Curve, Demo, Measured, Quantity, Symbol
from ..moments import share
from ..quadrature import motion, quaternion_rate

AIRFRAME = (
    shapes.Capsule(0.42, 4.6, "x", at=(-1.0, 0, 0)),
    shapes.Box((1.3, 8.0, 0.08), at=(0.4, 0, -0.95)),
    shapes.Box((1.3, 7.2, 0.08), at=(0.2, 0, 0.45)),
    shapes.Box((0.1, 0.1, 1.4), at=(0.3, 2.4, -0.25)),
    shapes.Box((0.1, 0.1, 1.4), at=(0.3, -2.4, -0.25)),
    shapes.Box((0.9, 0.08, 1.0), at=(-3.5, 0, -0.6)),
    shapes.Box((0.9, 2.8, 0.08), at=(-3.5, 0, 0)),
)
ENGINE = (
    shapes.Cylinder(0.5, 0.6, "x", at=(1.7, 0, 0)),
    shapes.Box((0.06, 0.22, 2.5), at=(2.1, 0, 0), colour="sienna"),
)
START_AXES = np.diag([1.0, -1.0, -1.0])  # axes of the start in world axes: x ahead, y to the right, z down


def mechanism(*, I=(700.0, 1000.0, 1500.0), J=6.0, Omega=130.0, M=500.0) -> System:
    """Build an airframe of moments I [kg m^2], engine (J, J/2, J/2) at Omega [rad/s] along its nose x, moment M [N m]
    about y.
    """
    jet = Body("aircraft", 500.0, I, orientation=START_AXES, shape=AIRFRAME)
    spin: dict[str, Any] = {"orientation": START_AXES, "omega": (Omega, 0, 0)}
    engine = Body("engine", 60.0, (J, J / 2, J / 2), **spin, shape=ENGINE)
    shaft = Revolute(jet, engine, at=(0, 0, 0), axis=(1, 0, 0), name="shaft")
    speed = SpeedDriver(jet, engine, axis=(1, 0, 0), speed=Omega, name="speed")
    return System([jet, engine], [shaft, speed], [Torque(jet, (0, M, 0), frame="body")], gravity=(0, 0, 0))


def euler(t, *, I, J, Omega, M):
    """Integrate orientation and angular velocity: I w' + w x (I w + h) = M in body axes, shape (times, 7)."""
    moments, h, torque = np.add(I, (J, J / 2, J / 2)), np.array([J * Omega, 0, 0]), np.array([0, M, 0])

    def rate(_, y):
        e, w = y[:4], y[4:]
        return np.concatenate([quaternion_rate(e, w), (torque - np.cross(w, moments * w + h)) / moments])

    return motion(rate, np.array([1.0, 0, 0, 0, 0, 0, 0]), t)


def sideways(x, y, z):
    """Return the angle [deg] to the right between the nose and its initial vertical plane, without a jump over the
    top."""
    return np.degrees(np.arctan2(y, np.hypot(x, z)))


def known_sideways(e):
    """Return the same angle for quaternions (samples, 4) from the axes of the start."""
    e0, e1, e2, e3 = e.T
    return sideways(1 - 2 * (e2**2 + e3**2), 2 * (e1 * e2 + e0 * e3), 2 * (e1 * e3 - e0 * e2))


def theory(*, I, J, Omega, M, t):
    """Solve Euler's equations of a gyrostat; for small angles r = J W theta / I_z."""
    times = np.linspace(0, t, 41)
    y = euler(times, I=I, J=J, Omega=Omega, M=M)
    return {"yaw_rate_rad_s": y[-1, 6], "nose_sideways_deg": known_sideways(y[:, :4])[-1]}


def measure(build, terms, *, I, J, Omega, M, t=2.0) -> Measured:
    """Measure yaw rate and angle of the nose to the side after t."""
    run = simulate(build(), t, rtol=1e-13, output=np.linspace(0, t, 201), **terms)
    side, y = sideways(*(run.rotation("aircraft")[:, :, 0] @ START_AXES.T).T), euler(run.t, I=I, J=J, Omega=Omega, M=M)
    curve = Curve("nose to the side [deg]", run.t, side, (run.t, known_sideways(y[:, :4])))
    values = {"yaw_rate_rad_s": run.omega_body("aircraft")[-1, 2], "nose_sideways_deg": side[-1]}
    return Measured(values, [run], [curve])


demo = Demo(
    __name__,
    title="An aircraft that raises its nose swings it sideways",
    question="Why does a fighter with a rotary engine swing sideways when its pilot pulls up?",
    beats=(
        Beat(0.0, "The pilot pulls: the moment acts upwards only."),
        Beat(share(0.5), "The nose goes up ..."),
        Beat(share(1.0), "... and to the side, where nobody has pushed it."),
    ),
    why="A rotary engine turns with its propeller and carries angular momentum along the nose. Raising the nose turns "
    "this arrow, and an arrow turns only under a moment at right angles to it: if nothing gives that moment, the "
    "aircraft yaws. With the engine stopped nothing turns sideways, with the engine reversed the nose goes to the "
    "other side. A jet does the same, by a degree or two: its rotor is light beside its airframe.",
    equation="I w' + w x (I w + h) = M; h = J W along the nose; small angles: r = J W theta / I_z",
    symbols={
        "w": Symbol("turning", "rad/s", curve=(0, 1)),
        "r": Symbol("to the side", "rad/s", curve=(0, 2)),
        "I": Symbol("moments of the aircraft", "kg m^2"),
        "I_z": Symbol("that about its upright axis", "kg m^2", lambda I: I[2]),
        "h": Symbol("angular momentum of the engine", "N m s", lambda J, Omega: J * Omega, arrow="angular momentum"),
        "J": Symbol("moment of the engine", "kg m^2", "J"),
        "W": Symbol("spin of the engine", "rad/s", "Omega"),
        "M": Symbol("pull of the pilot", "N m", "M"),
        "theta": Symbol("rise of the nose", "rad"),
    },
    source="Hughes, Spacecraft Attitude Dynamics (gyrostats); Stevens, Lewis, Aircraft Control and Simulation",
    quantities={
        "yaw_rate_rad_s": Quantity("yaw rate at the end", "rad/s"),
        "nose_sideways_deg": Quantity("nose to the side at the end", "deg"),
    },
    ablation=Ablation("engine", "the engine stands still and the nose goes straight up", {"Omega": 0.0}),
    against=Against("Omega", -200.0, 200.0, "speed of the engine [rad/s]", computed=3),
    show={"curves": [("omega_body", "aircraft")], "shown": ["angular momentum"]},
    ranges={"I": [(600.0, 800.0), (900.0, 1100.0), (1400.0, 1600.0)]},
    sliders=(
        Control("Omega", 0.0, 200.0, "rad/s", "spin of the engine"),
        Control("M", 100.0, 600.0, "N m", "moment"),
    ),
    theory_moves=False,
    attempt="stop the engine: pulling up no longer turns the nose aside.",
)
