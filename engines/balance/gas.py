"""Gas forces of a four-stroke engine: on the pistons of the spatial model, and their harmonics.

The gas pushes the piston of cylinder i towards the crank with ``f(psi)`` and the head of the block as hard the other
way, psi being the crank angle since the cylinder fired, 0 <= psi < 4 pi. Piston and head together give no force and no
couple about x and y: the block feels the gas only as torque reaction, and that only if the torque leaves the engine
(driver on the dyno).

A half sine over the power stroke, ``f = peak sin psi`` for psi < pi, has orders m / 2 of crank speed:

    f = sum_m Re(f_m exp(i m psi / 2)),  f_0 = peak / (4 pi),
    f_m = peak / (2 pi) * integral_0^pi sin(psi) exp(-i m psi / 2) dpsi
        = peak (1 + exp(-i pi m / 2)) / (2 pi (1 - m^2 / 4)),  f_2 = -i peak / 4

Four of them, evenly in turn, add up to ``peak |sin q|`` with the 2x amplitude 4 peak / (3 pi): 4244.13 N for 10 kN.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from engines.balance.layouts import Engine, Layout
from mbsd3d import Force, System, Table
from mbsd3d.errors import InputError
from mbsd3d.extend import number

CYCLE_ANGLE = 4 * np.pi  # [rad] of a four-stroke cycle
SEARCHED_CYLINDERS_MAX = 16  # [1] cylinders; each doubles the number of firing orders


class FiringOrderError(InputError):
    """Error for a layout without a known firing order."""


Gas = Callable[[np.ndarray], np.ndarray]


def half_sine(peak: float = 10e3) -> Gas:
    """Return the function f(psi) of a half sine over the power stroke [N]; psi is counted from firing [rad], any array.

    ValueError if the peak is not positive.
    """
    peak = number(peak, "gas: peak", positive=True)

    def force(psi: np.ndarray) -> np.ndarray:
        psi = np.asarray(psi) % CYCLE_ANGLE
        return np.where(psi < np.pi, peak * np.sin(psi), 0.0)

    return force


def half_sine_phasors(peak: float, halves: int) -> np.ndarray:
    """Return the phasors f_0 ... f_halves of the half sine over orders 0, 1/2, 1 ... of crank speed [N]."""
    m = np.arange(halves + 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        f = peak * (1 + np.exp(-0.5j * np.pi * m)) / (2 * np.pi * (1 - m**2 / 4))
    f[0] /= 2
    if halves >= 2:
        f[2] = -0.25j * peak
    return f


def firing_angles(layout: Layout) -> np.ndarray:
    """Return the crank angles at which the cylinders fire, top dead centres in [0, 720) [degrees], shape (n,).

    The firing order of the layout, if the crank can do it and no other is more even; else the most even one. (Of the
    data file, the orders of I3 and I6 belong to cranks that turn the other way; those of V8_cross and
    V6_60_offset+60 number the cylinders from bank to bank, 1, 3, 5 ... opposite 2, 4, 6 ...)

    FiringOrderError for too many cylinders to search, without a firing order.
    """
    top = -np.array(layout.phases) % 360.0
    given = ordered(layout, top)
    if top.size > SEARCHED_CYLINDERS_MAX:
        if given is None:
            raise FiringOrderError(
                f"layout '{layout.name}': {top.size} cylinders; give a firing_order that its crank can do"
            )
        return given
    turns = np.arange(2 ** (top.size - 1))[:, None] >> np.arange(top.size - 1) & 1
    choices = np.column_stack([np.full(len(turns), top[0]), top[1:] + 360.0 * turns])
    best = choices[np.argmin(np.round(unevenness(choices), 6))]
    if given is not None and unevenness(given[None])[0] <= unevenness(best[None])[0] + 1e-6:
        return given
    return best


def unevenness(angles: np.ndarray) -> np.ndarray:
    """Return the mean square of the gaps between firings [degrees^2], (choices, n) -> (choices,)."""
    inorder = np.sort(angles, axis=1)
    gaps = np.diff(np.column_stack([inorder, inorder[:, 0] + 720.0]), axis=1)
    return np.mean(gaps**2, axis=1)


def ordered(layout: Layout, top: np.ndarray) -> np.ndarray | None:
    """Return the angles of the layout's own firing order [degrees], or None if the order takes more than two turns."""
    if layout.firing_order is None:
        return None
    order = [int(cylinder) - 1 for cylinder in layout.firing_order.split("-")]
    angles, last = np.zeros(top.size), top[order[0]] - 360.0
    for i in order:
        last += (top[i] - last - 1e-9) % 360.0 + 1e-9
        angles[i] = last
    return angles % 720.0 if last < top[order[0]] + 720.0 - 1e-6 else None


def firing_order(layout: Layout) -> str:
    """Return the firing order from cylinder 1 on, such as "1-3-4-2"."""
    order = np.argsort(np.round(firing_angles(layout), 6), kind="stable")
    return "-".join(str(i + 1) for i in np.roll(order, -int(np.flatnonzero(order == 0)[0])))


def force_phasors(engine: Engine, peak: float, halves: int) -> np.ndarray:
    """Return the sum of the half sines on all pistons as if they were parallel, orders 0, 1/2 ... halves / 2 [N]."""
    fired = np.radians(firing_angles(engine.layout))
    delay = np.exp(-0.5j * np.outer(np.arange(halves + 1), fired))
    return half_sine_phasors(peak, halves) * delay.sum(axis=1)


def forces(engine: Engine, gas: Gas, angle: np.ndarray) -> np.ndarray:
    """Return the gas force on each piston, towards the crank, at the crank angles q [rad], shape (samples, n)."""
    return gas(np.asarray(angle)[:, None] - np.radians(firing_angles(engine.layout)))


def torque(engine: Engine, gas: Gas, angle: np.ndarray) -> np.ndarray:
    """Return the torque of the gas on the crank [N m], ``-sum f_i s'(q_i)`` with s the position of the piston, shape
    (samples,).
    """
    q = np.asarray(angle)[:, None] + np.radians(engine.layout.phases)
    R, across = engine.radius, engine.radius * np.sin(q) - engine.offset
    slope = -R * np.sin(q) - across * R * np.cos(q) / np.sqrt(engine.rod_length**2 - across**2)
    return -np.sum(forces(engine, gas, angle) * slope, axis=1)


def with_gas(system: System, engine: Engine, gas: Gas, count: int) -> System:
    """Add gas forces for two turns to the engine of `spatial.build`, exact at ``count`` times per turn.

    Run it with ``spatial.turn(system, engine, turns=2, count=count)``, or a divisor of the count.
    """
    times = 2 * np.pi / engine.rate * np.arange(2 * count + 1) / count
    pushes, block = forces(engine, gas, engine.rate * times), system.part("block", "bodies")
    loads = []
    for i, (push, beta) in enumerate(zip(pushes.T, np.radians(engine.layout.bores), strict=True), start=1):
        piston, table = system.part(f"piston {i}", "bodies"), Table(times, push)
        u = np.array([np.cos(beta), np.sin(beta), 0.0])
        on_piston = tuple(-component * table for component in u)
        on_head = tuple(component * table for component in u)
        head = piston.position + engine.radius * u
        loads.append(Force(piston, on_piston, name=f"gas {i}"))
        loads.append(Force(block, on_head, at=head, name=f"head {i}"))
    return replace(system, forces=[*system.forces, *loads])
