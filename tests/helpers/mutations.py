"""Row kernels with a mistake in them, and what `cross_check` says: a script that runs without the compiler.

``python -m helpers.mutations ENGINE ... [KERNEL ...]``, with tests/ on the path, prints one JSON line per mistake:
kernel, mistake, and the quantities that differ by engine, or how the run ended.
"""

import inspect
import json
import os
import sys

os.environ["NUMBA_DISABLE_JIT"] = "1"

import numpy as np

from helpers.models import consistent_state, direction, example_system, random_body
from mbsd3d import (
    GROUND,
    AngleDriver,
    ConstantVelocity,
    Distance,
    GearMesh,
    KnifeEdge,
    PointOnPlane,
    RollingDisc,
    Screw,
    SpeedDriver,
    Spherical,
    State,
    System,
    Universal,
)
from mbsd3d.dynamics import state_rates
from mbsd3d.kernels import rows
from validation import cross_check

SPAN = 0.02  # s, of the mistakes that only a run can show; the others are judged at the start
KERNELS = {
    "coincide": Spherical,
    "axis_dot": Universal,
    "axis_dot_difference": ConstantVelocity,
    "in_plane": PointOnPlane,
    "distance": Distance,
    "ratio": Screw,
    "mesh": GearMesh,
    "turn_rate": SpeedDriver,
    "no_sideslip": KnifeEdge,
    "roll": RollingDisc,
    "prescribe": AngleDriver,
    "axes_dot": Universal,
    "contact_row": RollingDisc,
    "row_speed": Screw,
}
"""Row kernel -> a joint type whose rows it fills."""

ONLY_IN_A_RUN = ("row_speed",)
BETWEEN_BODIES = (Screw, ConstantVelocity, SpeedDriver)
"""Types whose rows have no gamma on the ground; what loads them at rest is the ground."""


def mechanism(kind, moving=True):
    """A small system with a joint of that type, as general as both engines can take it."""
    if kind is not RollingDisc:
        return example_system(kind, 4, ground=None if kind in BETWEEN_BODIES and moving else "a")
    rng = np.random.default_rng(4)
    axis, normal = direction(rng), np.array([0.0, 0.0, 1.0])
    down = -(normal - (normal @ axis) * axis) / np.sqrt(1 - (normal @ axis) ** 2)
    disc = random_body(rng, "disc")
    centre = disc.position + 0.2 * direction(rng)
    plane = (centre + 0.5 * down, normal)
    rolling = RollingDisc(GROUND, disc, axis=axis, radius=0.5, centre=centre, plane=plane)
    return System([disc], [rolling], gravity=(0.3, -0.7, -9.6))


def wrong_rows(kernel, change):
    """The kernel, with ``change`` made to every row it fills."""
    names = list(inspect.signature(kernel).parameters)

    def mistaken(*arguments):
        kernel(*arguments)
        given = dict(zip(names, arguments, strict=True))
        p = given.get("p")
        for row in [given["row"]] if "row" in given else [given["d"].row[p.row + i] for i in range(3)]:
            change(row)

    return mistaken


def other_sign_of_gamma(row):
    """J_dot v with the wrong sign."""
    row.gamma = -row.gamma


def one_per_cent_of_gamma(row):
    """J_dot v a little off."""
    row.gamma *= 1.01


def one_entry_turned(row):
    """The largest entry of J with the wrong sign."""
    k = np.abs(row.J[1]).argmax()  # of body b: a is the ground in some
    row.J[1, k] = -row.J[1, k]


def one_per_cent_of_an_entry(row):
    """The largest entry of J a little off."""
    row.J[1, np.abs(row.J[1]).argmax()] *= 1.01


def mistakes(name):
    """Mistake -> (the kernel with it, whether the start moves: gamma vanishes at rest, and at rest any J fits v)."""
    kernel = getattr(rows, name)
    if name == "row_speed":
        return {"a speed that is not there": (lambda *arguments: kernel(*arguments) + 1e-3, True)}
    if name == "axes_dot":
        return {"rest of the other sign": (lambda *x: (lambda c, n, rest: (c, n, -rest))(*kernel(*x)), True)}
    changes = {other_sign_of_gamma: True, one_per_cent_of_gamma: True}
    if name != "prescribe":
        changes |= {one_entry_turned: False, one_per_cent_of_an_entry: False}
    return {f.__name__.replace("_", " "): (wrong_rows(kernel, f), moving) for f, moving in changes.items()}


def at_rest(system, state):
    """The state without velocities, as far as drivers allow."""
    return (
        state if any("Driver" in type(joint).__name__ for joint in system.joints) else State(0.0, state.q, 0 * state.v)
    )


def judged(system, state, engines, t_end=None):
    """{engine: quantities that differ}, or {"error": text}."""
    try:
        check = cross_check(system, t_end, state=state, engines=engines, budget=2.0, progress=False)
    except ValueError as error:
        return {"error": str(error)}
    return {x.engine: [f.quantity for f in x.findings if f.status == "differs"] for x in check.engines}


def put(name, kernel):
    """Another function in the place of a row kernel, wherever it is called from."""
    for module in (rows, state_rates):
        if hasattr(module, name):
            setattr(module, name, kernel)


def main(engines, only=()):
    """One line per mistake, the first of every kernel without any."""
    for name, kind in KERNELS.items():
        if only and name not in only:
            continue
        kernel, cases = getattr(rows, name), {"none": (getattr(rows, name), True)} | mistakes(name)
        for mistake, (mistaken, moving) in cases.items():
            system = mechanism(kind, moving)
            state = consistent_state(system, np.random.default_rng(1))  # before the mistake is made
            put(name, mistaken)
            t_end = SPAN if name in ONLY_IN_A_RUN else None
            found = judged(system, state if moving else at_rest(system, state), engines, t_end)
            put(name, kernel)
            print(json.dumps([name, mistake, found]), flush=True)


if __name__ == "__main__":
    main(
        [x for x in sys.argv[1:] if x in ("mujoco", "exudyn", "definitions")], [x for x in sys.argv[1:] if x in KERNELS]
    )
