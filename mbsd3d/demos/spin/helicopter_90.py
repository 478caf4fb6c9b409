"""A blade on a flapping hinge responds to a moment that turns with it a quarter turn late."""

import numpy as np

from mbsd3d import (
    DOP853,
    GROUND,
    Body,
    Revolute,
    Sine,
    SpeedDriver,
    State,
    System,
    Torque,
    TorsionSpring,
    rotation,
    shapes,
    simulate,
)

from ..form import Ablation, Against, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share

# [1] of one turn, or of one swing if that is faster; the flap is a sine: one turn gives its coefficient
TURN_SAMPLES = 96
START_VARIATION_MIN = 1e-6  # [rad] variation of the start; its rounding is 1e-10, its square 1e-12
LAG_TOLERANCE = 1e-8  # [rad] of lag, four times the second order in the flap
SHOWN_FLAP = 0.1  # [rad] of flap in the run that is shown
STIFFNESS_RATIO_MAX = 1e6  # [1] of a hinge over I W^2: it swings a thousand times a turn


def mechanism(*, m=10.0, L=5.0, e=0.0, Omega=40.0, M0=1.0, c=3000.0, k=0.0) -> System:
    """Build a blade of mass m [kg] and length L [m], hinge at e [m] with damper c [N m s/rad] and spring k [N
    m/rad]."""
    hub = Body("hub", 20.0, (1, 1, 1), omega=(0, 0, Omega), shape=rotor(L, abs(e)))
    moments, form = m * L**2 / 12 * np.array([0, 1, 1]), shapes.Box((L, 0.07 * L, 0.01 * L))
    blade = Body("blade", m, moments, position=(e, 0, 0), com=(L / 2, 0, 0), shape=form)
    shaft = Revolute(GROUND, hub, at=(0, 0, 0), axis=(0, 0, 1), name="shaft")
    flap = Revolute(hub, blade, at=(e, 0, 0), axis=(0, -1, 0), name="flap")
    motor = SpeedDriver(GROUND, hub, axis=(0, 0, 1), speed=Omega, name="motor")
    push = Torque(blade, (0, Sine(-M0, Omega / (2 * np.pi), np.pi / 2), 0), frame="body", name="push")
    hinge = TorsionSpring(flap, stiffness=k, damping=c, name="hinge")
    return System([hub, blade], [shaft, flap, motor], [push, hinge], gravity=(0, 0, 0))


def rotor(L, e):
    """Draw hub, mast, and the other blades, which stay in the plane that the first one leaves."""
    others = [
        shapes.Box((L, 0.07 * L, 0.01 * L), at=(e + L / 2) * along, orientation=rotation("z", turn), colour="dimgray")
        for turn in np.pi / 2 * np.arange(1, 4)
        for along in [np.array([np.cos(turn), np.sin(turn), 0])]
    ]
    return [shapes.Cylinder(0.05 * L + e, 0.06 * L), shapes.Cylinder(0.025 * L, 0.3 * L, at=(0, 0, -0.15 * L)), *others]


def theory(*, m, L, e, Omega, M0, c, k):
    """Return lag and flap of I b'' + c b' + (I W^2 (1 + 3 e/2 L) + k) b = M0 cos W t for a small flap b of a uniform
    blade.
    """
    require(Omega > 0 and c > 0, "demo 'helicopter_90': give Omega > 0 and c > 0: undamped, the start never dies out")
    require(M0 > 0, f"demo 'helicopter_90': M0 = {M0:g}: the lag is that behind a push; give M0 > 0")
    require(abs(e) <= L, f"demo 'helicopter_90': e = {e:g} m is more than the blade is long; give less than {L:g}")
    inertia = m * L**2 / 3
    most = STIFFNESS_RATIO_MAX * inertia * Omega**2
    require(
        abs(k) <= most, f"demo 'helicopter_90': k = {k:g} N m/rad holds the blade rigidly; give less than {most:.3g}"
    )
    found = lag_and_flap(inertia * Omega**2 * 3 * e / (2 * L) + k, c * Omega, M0)
    require(found["flap_rad"] ** 2 * inertia * Omega / c < LAG_TOLERANCE, f"demo 'helicopter_90': a flap of "
            f"{found['flap_rad']:.2g} rad is too large for linear theory; give less M0, or more c")  # fmt: skip
    return found


def without_gyroscopic(*, m, L, e, Omega, M0, c, k):
    """Return the values without w x I w: the centrifugal stiffness is that of a point mass, I W^2 (3/4 + 3 e/2 L)."""
    inertia = m * L**2 / 3
    return lag_and_flap(inertia * Omega**2 * (1.5 * e / L - 0.25) + k, c * Omega, M0)


def lag_and_flap(in_phase, across, moment):
    """Return lag [deg] and size [rad] of the response to a moment."""
    return {"lag_deg": np.degrees(np.arctan2(across, in_phase)), "flap_rad": moment / np.hypot(in_phase, across)}


def film(build, *, e, Omega, M0) -> tuple[System, State]:
    """Build what is seen: a push so strong that the flap shows, and the start that theory has for it."""
    found = build.theory
    system, lag = build(M0=SHOWN_FLAP / found["flap_rad"] * M0), np.radians(found["lag_deg"])
    start, turned = system.state(), rotation((0, -1, 0), SHOWN_FLAP * np.cos(lag))
    moving = [0, Omega * e, 0, 0, -SHOWN_FLAP * Omega * np.sin(lag), Omega]
    return system, State(0.0, [*start.q[:10], *turned], [*start.v[:6], *moving])


def measure(build, terms, *, m, L, Omega, M0, c, k) -> Measured:
    """Measure the periodic flap: the fixed point of the map from turn to turn, which is affine."""
    system, turn, inertia = build(), 2 * np.pi / Omega, m * L**2 / 3
    samples = TURN_SAMPLES * int(np.ceil(max(1.0, np.sqrt(abs(k) / inertia) / Omega, c / (inertia * Omega))))

    def after(angle, rate, *, system=system, **settings):
        state = system.assemble(angles={"flap": angle}, rates={"flap": rate})
        return simulate(system, turn, state=state, method=DOP853(dt=turn / samples), **settings, **terms)

    size = max(build.theory["flap_rad"], START_VARIATION_MIN)  # that of the answer, in which the map is affine
    starts = np.array([[0, 0], [size, 0], [0, size * Omega]])
    ends = np.array([[run.angle("flap")[-1], run.rate("flap")[-1]] for run in (after(*x, output=2) for x in starts)])
    slope = (ends[1:] - ends[0]).T / np.array([size, size * Omega])
    start = np.linalg.solve(np.eye(2) - slope, ends[0])
    run = after(*start, output=TURN_SAMPLES + 1)
    more = SHOWN_FLAP / build.theory["flap_rad"]
    shown, begin = film(build, e=build.values["e"], Omega=Omega, M0=M0)
    large = simulate(shown, turn, state=begin, method=DOP853(dt=turn / samples), output=TURN_SAMPLES + 1, **terms)
    notes = [f"seen here with a push {more:.2g} times as strong, and with three blades more that nobody pushes"]
    flap = run.angle("flap")
    first = 2 * np.mean(flap[:-1] * np.exp(1j * Omega * run.t[:-1]))  # conjugate of the coefficient of exp(i W t)
    azimuth = np.degrees(Omega * run.t)
    wanted = build.theory["flap_rad"] * np.cos(Omega * run.t - np.radians(build.theory["lag_deg"]))
    push = Curve("flap [rad]", azimuth, flap, (azimuth, wanted), "place of the push [deg]", "the push is highest at 0")
    lag = (np.degrees(np.angle(first)) + 90) % 360 - 90  # between 0 and 180, of which rounding leaves either end
    return Measured({"lag_deg": lag, "flap_rad": abs(first)}, [large], [push], notes=notes)


demo = Demo(
    __name__,
    title="The rotor's quarter turn",
    question="Why must a helicopter's swashplate push a quarter turn before the place where the rotor shall tilt?",
    beats=(
        Beat(0.0, "Here the blade is pushed up hardest, and it is level."),
        Beat(share(0.25), "A quarter turn later it is highest."),
        Beat(share(0.5), "Pushed down hardest, and level again."),
        Beat(share(0.75), "Lowest: the push is answered a quarter turn late."),
    ),
    why="The centrifugal force pulls a blade back into the plane of the rotor like a spring, and this spring makes "
    "it swing exactly once a turn. A push that comes once a turn is therefore in resonance, and at resonance any "
    "swing follows its push by a quarter of a period. A hinge away from the shaft makes the spring stiffer, and "
    "the lag smaller.",
    equation="I b'' + c b' + (I W^2 (1 + 3e/2L) + k) b = M_0 cos W t; tan(lag) = c W / (I W^2 3e/2L + k)",
    symbols={
        "b": Symbol("flap", "rad", curve=(0, 0)),
        "I": Symbol("moment of a blade about its hinge", "kg m^2", lambda m, L: m * L**2 / 3),
        "W": Symbol("turn of the rotor", "rad/s", "Omega"),
        "e": Symbol("hinge outside the shaft", "m", "e"),
        "L": Symbol("length of a blade", "m", "L"),
        "c": Symbol("damping by the air", "N m s", "c"),
        "k": Symbol("spring at the hinge", "N m", "k"),
        "M_0": Symbol("push", "N m", "M0"),
        "t": Symbol("time", "s"),
    },
    source="Johnson, Helicopter Theory (flapping); Leishman, Principles of Helicopter Aerodynamics (flapping blade)",
    quantities={
        "lag_deg": Quantity("lag of the flap behind the push", "deg"),
        "flap_rad": Quantity("size of the flap", "rad", absolute=1e-13, relative=1e-7),
    },
    ablation=Ablation(
        "gyroscopic",
        "the spring is that of a point mass, too weak by a quarter, and the lag above 90 degrees",
        values=without_gyroscopic,
    ),
    against=Against("e", 0.0, 1.0, "offset of the hinge [m]"),
    show={"curves": [("angle", "flap")], "traces": [("blade", (5.0, 0, 0))], "view": (-58.0, 18.0)},
    sliders=(
        Control("e", 0.0, 2.0, "m", "hinge off the shaft"),
        Control("c", 2000.0, 8000.0, "N m s/rad", "damping"),
    ),
    attempt="move the hinge off the shaft: the blade no longer swings in step with the turn, and the lag "
    "falls below 90 degrees.",
)
