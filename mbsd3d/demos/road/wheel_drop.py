"""Dropped wheel: it rebounds slower than its damping suggests, since nothing holds it to the road."""

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from mbsd3d import GROUND, Body, Contact, System, measures, shapes, simulate

from ..form import GRAVITY, Ablation, Against, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import first

G = 9.81  # m/s^2


def mechanism(*, m=20.0, k=1.5e5, c=300.0, h=0.1, r=0.3) -> System:
    """Build a wheel m [kg] with a tyre k [N/m], c [N s/m] at a height h [m] over the road; outer radius r [m]."""
    tube = 0.1 * r
    wheel = Body("wheel", m, (0.3 * m * r**2, 0.6 * m * r**2, 0.3 * m * r**2), position=(0, 0, r + h),
                 velocity=(0, 0, 0), omega=(0, 0, 0), shape=shapes.Torus(r - tube, tube, "y"))  # fmt: skip
    road = Contact(GROUND, wheel, shapes.Torus(r - tube, tube, "y"), stiffness=k, damping=c, name="road")
    return System([wheel], forces=[road], gravity=(0, 0, -G))


def pressed(m, k, c, h):
    """Return x(t), x'(t) and N(t) = k x + c x' of the depth after contact: m x'' = m g - N."""
    rate, sag, v = c / (2 * m), m * G / k, np.sqrt(2 * G * h)
    w = np.sqrt(k / m - rate**2)
    b = (v - rate * sag) / w

    def depth(t):
        wave = np.exp(-rate * t) * (b * np.sin(w * t) - sag * np.cos(w * t))
        return sag + wave, -rate * wave + np.exp(-rate * t) * w * (b * np.cos(w * t) + sag * np.sin(w * t))

    return depth, lambda t: np.dot((k, c), depth(t)), w


def theory(*, m, k, c, h):
    """Return depth and force of a damped spring without tension; it separates where N = 0, before the depth is 0."""
    require(c < 0.9 * np.sqrt(4 * k * m), "the tyre would not swing: give less damping c")
    depth, N, w = pressed(m, k, c, h)
    end = brentq(N, 1e-9 / w, 1.5 * np.pi / w, xtol=1e-16)
    lowest = minimize_scalar(lambda t: -N(t), bounds=(0, end), method="bounded", options={"xatol": 1e-12}).x
    return {
        "restitution": -depth(end)[1] / np.sqrt(2 * G * h), "contact_ms": 1e3 * end,
        "depth_at_release_mm": 1e3 * depth(end)[0], "largest_N": max(N(lowest), N(0.0)),
    }  # fmt: skip


def measure(build, terms, *, m, k, c, h) -> Measured:
    """Measure the fall to the contact, and on to the separation; events are located, not read from samples."""
    system = build()
    road, wheel = system.part("road", "forces"), system.part("wheel")
    fall = simulate(system, 2 * np.sqrt(2 * h / G), rtol=1e-11, stop_when=measures.touches(road), **terms)
    up = simulate(system, fall.final.t + 1.0, state=fall.final, rtol=1e-11, stop_when=measures.leaves(road), **terms)
    times = np.linspace(fall.final.t, up.final.t, 401)
    press = simulate(system, up.final.t, state=fall.final, rtol=1e-11, output=times, **terms)
    force, depth = press.measure(measures.normal_force(road)), -press.measure(measures.clearance(road))
    first, last = fall.velocity(wheel)[-1, 2], up.velocity(wheel)[-1, 2]
    peak = np.argmax(force[1:-1]) + 1
    parabola = np.polyfit(times[peak - 1 : peak + 2] - times[peak], force[peak - 1 : peak + 2], 2)
    highest = max(parabola[2] - parabola[1] ** 2 / (4 * parabola[0]), force[0])
    values = {
        "restitution": -last / first, "contact_ms": 1e3 * (up.final.t - fall.final.t),
        "depth_at_release_mm": 1e3 * -up.measure(measures.clearance(road))[-1], "largest_N": highest,
    }  # fmt: skip
    known, N, _ = pressed(m, k, c, h)
    t = times - times[0]
    curves = [
        Curve("force of the road [N]", 1e3 * t, force, (1e3 * t, [N(x) for x in t]), along="time after the touch [ms]"),
        Curve("depth [mm]", 1e3 * t, 1e3 * depth, (1e3 * t, 1e3 * known(t)[0]), along="time after the touch [ms]"),
    ]
    whole = simulate(system, 1.2, rtol=1e-9, output=601, **terms)
    return Measured(values, [whole], curves)


demo = Demo(
    __name__,
    title="A wheel is dropped",
    question="Why does a dropped wheel leave the road before its tyre is round again?",
    beats=(
        Beat(0.0, "Dropped from 10 cm."),
        Beat(first(lambda run: run.position('wheel')[:, 2] < 0.3), "It touches the road."),
        Beat(first(lambda run: np.gradient(run.position('wheel')[:, 2]) > 0), "Flat as it will be."),
        Beat(first(lambda run: (run.t > 0.15) & (run.position('wheel')[:, 2] > 0.3)),
             "Gone, before it was round again: it flies up less high."),
    ),
    why="Spring and damper of a tyre act side by side. On the way up the damper pulls down, and where it pulls as hard "
    "as the spring still presses nothing is left: the road cannot hold the wheel, which goes with its tyre still "
    "pressed. What it keeps of its speed follows from one damped half wave. Without damping it keeps all of it.",
    equation="m z'' = m g - k z - c z'; N = k z + c z' >= 0",
    symbols={
        "z": Symbol("how deep the tyre is pressed in", "m"),
        "N": Symbol("force of the road", "N"),
        "m": Symbol("wheel", "kg", "m"),
        "k": Symbol("stiffness of the tyre", "N/m", "k"),
        "c": Symbol("damping of the tyre", "N s/m", "c"),
        "g": GRAVITY,
    },
    source="Goldsmith, Impact (1960), chapter 4; worked out here",
    quantities={
        "restitution": Quantity("speed it keeps, as a share", "-", relative=1e-8),
        "contact_ms": Quantity("time on the road", "ms", relative=1e-8),
        "depth_at_release_mm": Quantity("depth at release", "mm", relative=1e-6, absolute=1e-7),
        "largest_N": Quantity("largest force of the road", "N", relative=1e-6),
    },
    ablation=Ablation("damping", "it leaves as fast as it came, with a round tyre", {"c": 0.0}),
    against=Against("c", 0.0, 1500.0, "damping of the tyre [N s/m]"),
    show={"speed": 0.25, "curves": [("position", "wheel"), "energy"]},
    sliders=(
        Control("c", 0.0, 500.0, "N s/m", "damping"),
        Control("h", 0.05, 0.3, "m", "height"),
    ),
    attempt="take the damping away: it comes back to where it was let go.",
)  # fmt: skip
