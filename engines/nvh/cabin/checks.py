"""Checks of shells against theory or the general model; quantity -> (computed, exact), as `mounts.checks`."""

from functools import cached_property

import numpy as np

from engines import closed_forms
from engines.nvh.cabin.plate import plate_modes
from engines.nvh.cabin.seat import Cabin
from engines.nvh.cabin.shell import ModalShell
from engines.nvh.excitation import presets
from engines.nvh.excitation.loads import Source
from engines.nvh.mounts import mounts
from engines.nvh.mounts.checks import Pairs
from engines.nvh.mounts.powertrain import equivalent
from engines.nvh.mounts.response import LOADS, Map, OnMounts, pushed, shift, six_freedoms
from mbsd3d import Body, Bushing, System, state_space


def free_plate(ratio: float = 2.3) -> Pairs:
    """Compare a plate of Poisson's ratio 0 with a beam in bending."""
    found, known = plate_modes(ratio, 1.0, 0.0)[0] * ratio**2, closed_forms.bending_roots(2) ** 2
    return {"bending of a free plate": (np.array([found[np.abs(found - x).argmin()] for x in known]), known)}


def held_in(car: str, engine: str) -> OnMounts:
    """Return an engine on the mounts of a car, without the roll by a mean torque."""
    body = equivalent(presets.preset(engine))
    return OnMounts(body, mounts.mounts(mounts.car(car), presets.preset(engine), body.mass))


class Rigid(Cabin):
    """Cabin whose shell has no elastic modes."""

    @cached_property
    def shell(self) -> ModalShell:
        """Return the rigid modes of the shell."""
        shell = super().shell
        shapes = [shape for rate, shape in zip(shell.rates, shell.shapes, strict=True) if rate == 0.0]
        return ModalShell(np.zeros(len(shapes)), np.zeros(len(shapes)), shapes)


def rigid_shell(car: str, engine: str, rpm: float = 1700.0) -> Pairs:
    """Compare a shell without elastic modes with a body of the general model."""
    held = held_in(car, engine)
    cabin = Rigid(mounts.car(car), held)
    answer = held.answer(Source(presets.preset(engine), 0.7), [rpm])
    return {"seat of a rigid shell": (cabin.seat(answer)[0], of_bodies(cabin, answer))}


def of_bodies(cabin: Cabin, answer: Map) -> np.ndarray:
    """Return the phasors of the seat's acceleration: shell, powertrain and spinning rotor as bodies on bushings, shape
    (n, 3).
    """
    r, R, held = cabin.record, cabin.axes, cabin.held
    m, rate = r["mass"], 2 * np.pi * answer.rpm[0] / 60
    bent = m * r["length"] ** 2 / 12
    shell = Body("shell", m, R.T @ np.diag([r["roll_inertia"], bent, bent]) @ R, com=-R.T @ r["engine"])
    apart = held.body.system(pushed, rate)
    powertrain, rotor = apart.bodies
    forces = [
        Bushing(shell, powertrain, at=x.at, stiffness=x.rates, damping=x.damping, axes=x.axes) for x in held.placed
    ]
    both = System([powertrain, rotor, shell], apart.joints, [*forces, *apart.forces], gravity=(0, 0, 0))
    W, found = answer.orders[1:] * rate, np.zeros((answer.orders.size, 3), dtype=complex)
    H = state_space(both, inputs=LOADS, outputs=six_freedoms(shell)[:6]).frequency_response(W).H
    to_seat = R @ shift(np.array(R.T @ (np.array(r["seat"]) - r["engine"])))[:3]
    found[1:] = -(W[:, None] ** 2) * (to_seat @ H @ answer.load[0, 1:, :, None])[..., 0]
    return found
