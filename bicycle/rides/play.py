"""Live ride of a bicycle on tyres in the browser: torques by keys, and its parameters by sliders while it rides."""

import threading
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from mbsd3d import Input, State, StateFeedback, measures
from mbsd3d.errors import InputError, MbsError
from mbsd3d.extend import Built, Control, Measure, Panel, Play, Seen, number, play_model

from ..linear.tyre_equations import Affine, SpeedBySpeed, Table, equations
from ..model.mechanism import Bicycle
from ..model.tyres import TYPICAL
from ..parameters import Parameters, check_set
from .manoeuvres import FALLEN
from .ride import elevation, ridden
from .rider_mass import carried, faster

PEDAL_TORQUE_MAX, BRAKE_TORQUE_MAX = 40.0, 60.0  # [N m] at the rear and the front hub
SPEED_MAX = 50.0  # [m/s] of a live ride
ASSIST_GAIN_MAX = 50.0  # [N m s/rad] of the balance assist
ASSIST_GAIN = 20.0  # [N m s/rad] at the start: at 5 m/s it stays up when the key is held for 4 s, with 10 it falls
STEERING_HINT = "Press right to go left: it steers right, leans left, and turns left."
TRAIL_CHANGE_MAX, HEAD_ANGLE_CHANGE_MAX = 0.12, 20.0  # [m], [degrees] to both sides
SPIN_MIN = 2.0  # [%] of a wheel's inertia about its axle; a wheel without inertia would have no equation of its own
CAMERA_DIRECTION = (-155.0, 16.0)  # [degrees] behind the rider, and a little to the right
FREQUENCY_ROUNDING = 1e-6  # [rad/s] below which an eigenvalue does not oscillate
SPEED_MIN, SPEED_COUNT = 0.02, 31  # [m/s], count: where motions are found of tyres that are damped at rest
SPEED_CONTROL = 3  # index of the control
KEYS = {
    "steer torque": (("ArrowLeft", "ArrowRight"), ("j", "l")),
    "pedal": (("", "ArrowUp"), ("", "i")),
    "brake": (("", "ArrowDown"), ("", "k")),
}
Key = tuple[Parameters, float]  # a bicycle and its assist
PANELS = (
    Panel("lean and steer", "°", ("lean", "steer")),
    Panel("speed", "m/s", ("speed",)),
    Panel("growth of small motions at this speed", "1/s", ("that oscillate", "that do not")),
    Panel("torque about the steer axis", "N m", ("rider", "assist")),
)


def play(
    parameters: Parameters,
    *,
    speed: float = 5.0,
    assist: float = ASSIST_GAIN,
    torque: float = 2.0,
    dark: bool | None = None,
    port: int = 0,
    **fittings: Any,
) -> Play:
    """Simulate a bicycle on tyres in real time, in a browser on this machine; see `mbsd3d.System.play`.

    Parameters
    ----------
    speed : float
        At the start [m/s].
    assist : float
        k at the start of a steer torque T = k lean_rate [N m s/rad], which steers into the fall; 0 = none.
    torque : float
        Largest one of the rider about the steer axis [N m].
    dark, port
        As for `mbsd3d.System.play`.
    **fittings
        ``tyres`` and ``steer_damping`` as in `whipple`; without ``tyres`` `bicycle.TYPICAL` ones.

    Raises
    ------
    ValueError
        For numbers outside their ranges, a head tube that yields, a port in use, or a missing package.
    """
    check_set(parameters, "play")
    riding, title = Riding(parameters, speed, assist, torque, fittings), f"{parameters.name} on tyres"
    return play_model(
        riding, follow="frame", view=CAMERA_DIRECTION, hidden="body names", title=title, dark=dark, port=port
    )


class Riding:
    """Live model of a bicycle: its controls, its curves, and its rebuilding after a change."""

    panels = PANELS

    def __init__(
        self, parameters: Parameters, speed: float, assist: float, torque: float, fittings: Mapping[str, Any]
    ) -> None:
        if fittings.get("head_stiffness") is not None:
            raise InputError("play: a bicycle is ridden with a rigid head tube; leave out head_stiffness (--head)")
        self.parameters, self.now = parameters, parameters
        self.fittings = {"tyres": TYPICAL, **fittings}
        self.controls = controls_of(parameters, speed, assist, torque)
        self.asked = self.held = speed  # what it starts with, and what it moves with
        self.wanted: Key = (parameters, assist)
        self.straight: Straight | None = None
        self.thread: threading.Thread | None = None

    def built(self, values: Mapping[str, float], state: State | None) -> Built:
        """Build the bicycle of these numbers, at its start or from a state."""
        p = changed(self.parameters, values)
        if state is not None:
            begun = state if p == self.now else carried(state, self.now, p)
            if values["speed"] != self.held:
                begun, self.asked = faster(begun, values["speed"], self.held), values["speed"]
        system = self.system(p, values["balance assist"], self.asked)
        self.now, self.wanted = p, (p, values["balance assist"])
        lean, steer, *_ = seen = measures_of(system)
        shown: list[Measure | str | tuple[str, str]] = [
            lean,
            steer,
            ("force", "rear tyre"),
            ("force", "front tyre"),
            "energy",
        ]
        return Built(system, system.state() if state is None else begun, seen, shown)

    def system(self, p: Parameters, assist: float, speed: float) -> Bicycle:
        """Build the bicycle with its rider's torques, straight ahead."""
        names = {"torque": "steer torque", "drive": "pedal", "brake": "brake"}
        loads: dict[str, Any] = {load: Input(name) for load, name in names.items()}
        return with_assist(ridden(p, push=0.0, speed=speed, **loads, **self.fittings), assist)

    def inputs(self, values: Mapping[str, float], measured: Sequence[float] | np.ndarray) -> Mapping[str, float]:
        """Return the torques of the rider [N m]."""
        return {name: values[name] for name in ("steer torque", "pedal", "brake")}

    def seen(self, values: Mapping[str, float], measured: Sequence[float] | np.ndarray) -> Seen:
        """Return angles, speed, growth of small motions about straight running at this speed, torques."""
        lean, steer, lean_rate, upward, along, across = map(float, measured)
        speed = self.held = float(np.hypot(along, across))
        over = "" if upward > np.pi / 2 - FALLEN else "fallen: reset (R) stands it up again"
        torques = values["steer torque"], values["balance assist"] * lean_rate
        now = self.linearised()
        growth, good = (now.growth(speed), now.ranges) if now else ((np.nan, np.nan), ())
        curves = [np.degrees(lean), np.degrees(steer), speed, *growth, *torques]
        return Seen(curves, {"speed": speed}, {"speed": good}, over)

    def linearised(self) -> "Straight | None":
        """Return small motions of the present bicycle; None while its thread computes them."""
        if self.straight is not None and self.straight.key == self.wanted:
            return self.straight
        if self.thread is None or not self.thread.is_alive():
            self.thread = threading.Thread(target=self.linearise, args=(self.wanted,), daemon=True)
            self.thread.start()
        return None

    def linearise(self, key: Key) -> None:
        """Find the small motions of a bicycle with an assist."""
        fastest = self.controls[SPEED_CONTROL].high
        build = lambda p, speed: self.system(p, key[1], speed)  # noqa: E731
        try:
            exact, speeds = equations(build, key[0]), np.geomspace(SPEED_MIN, fastest, SPEED_COUNT)
            found: Affine | Table | None = exact.table(speeds) if isinstance(exact, SpeedBySpeed) else exact
        except MbsError:  # it cannot run straight at all speeds: no curve, no range
            found = None
        ranges = [(part.low, min(part.high, fastest)) for part in found.stable()] if found else []
        self.straight = Straight(key, found, ranges)


class Straight(NamedTuple):
    """Small motions of a bicycle about straight running, at all speeds."""

    key: Key
    equations: Affine | Table | None
    ranges: list[tuple[float, float]]  # in which it stays up by itself [m/s]

    def growth(self, speed: float) -> list[float]:
        """Return the fastest growth [1/s] of oscillating and of other motions; NaN where there are none."""
        if self.equations is None:
            return [np.nan, np.nan]
        values = np.linalg.eigvals(self.equations.A(speed))
        waves = np.abs(values.imag) > FREQUENCY_ROUNDING
        return [float(values.real[some].max()) if some.any() else np.nan for some in (waves, ~waves)]


def controls_of(p: Parameters, speed: float, assist: float, torque: float) -> list[Control]:
    """Return the controls of a live ride: torques by keys, the rest by sliders."""
    torque, speed = number(torque, "play: torque", positive=True), number(speed, "play: speed")
    fastest, angle = min(max(12.0, 2.0 * speed), SPEED_MAX), 90.0 - float(np.degrees(p.lam))
    made = [
        Control(
            "steer torque",
            -torque,
            torque,
            0.0,
            "N m",
            KEYS["steer torque"],
            "left stick",
            springs=True,
            hint=STEERING_HINT,
        ),  # fmt: skip
        Control("pedal", 0.0, PEDAL_TORQUE_MAX, 0.0, "N m", KEYS["pedal"], "right trigger", springs=True),
        Control("brake", 0.0, BRAKE_TORQUE_MAX, 0.0, "N m", KEYS["brake"], "left trigger", springs=True),
        Control("speed", 0.5, fastest, speed, "m/s", builds=True),
        Control("balance assist", 0.0, ASSIST_GAIN_MAX, number(assist, "play: assist"), "N m s/rad", builds=True),
        Control("trail", p.c - TRAIL_CHANGE_MAX, p.c + TRAIL_CHANGE_MAX, p.c, "m", builds=True),
        Control("head angle", angle - HEAD_ANGLE_CHANGE_MAX, angle + HEAD_ANGLE_CHANGE_MAX, angle, "°", builds=True),
        Control("wheel spin", SPIN_MIN, 100.0, 100.0, "%", builds=True),
    ]
    for control in made:
        if not control.low <= control.value <= control.high:
            span = f"{control.low:g} ... {control.high:g} {control.unit}"
            raise InputError(f"play: {control.name} = {control.value:g} is not within {span}")
    return made


def changed(p: Parameters, values: Mapping[str, float]) -> Parameters:
    """Return the bicycle with the trail, head angle and spin of the sliders; a slider at its start changes nothing."""
    spin = values["wheel spin"] / 100.0
    changes: dict[str, Any] = {"c": values["trail"], "IRyy": spin * p.IRyy, "IFyy": spin * p.IFyy}
    if values["head angle"] != 90.0 - np.degrees(p.lam):
        changes["lam"] = float(np.radians(90.0 - values["head angle"]))
    return replace(p, **changes)


def with_assist(system: Bicycle, gain: float) -> Bicycle:
    """Add the steer torque k lean_rate between frame and fork."""
    seen = [measures.lean_rate(system.part("frame"))]
    feedback = StateFeedback(measures=seen, gains=[-gain], on=system.part("steer", "joints"), name="assist")
    return replace(system, forces=[*system.forces, feedback])


def measures_of(system: Bicycle) -> list[Measure]:
    """Return measures of lean, steer, lean rate, elevation of the frame, velocity of the rear hub along x and y."""
    frame, wheel = system.part("frame"), system.part("rear wheel")
    angle = measures.angle(system.part("steer", "joints"))
    seen = [measures.lean(frame), angle, measures.lean_rate(frame), elevation(system)]
    return [*seen, *(measures.velocity(wheel, axis=axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)))]
