"""Valve on a rotating cam, held down by a spring: as a constraint, and with a contact that can open.

As a constraint its face or its roller stays on the cam, and the force of the cam on it is the multiplier: where it
would have to pull, the valve floats. Along the angle it is ``a + b w^2``, so that two speeds say from which one on. In
the contact

    F = k d (1 + c d_dot),   d = s(angle) + base - height,   d > 0 and F > 0

is the part of the force along the way of the valve. On a face it acts at the point s' beside the axis; a roller it
pushes aside as well, by ``F s' / p`` at the height p over the axis, on a drum ``F s' / R``. Always the cam bears the
torque ``-F s'``: what the cam does is what the valve gets. The spring is one without mass, or a chain of masses that
can surge.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from engines.nvh.valvetrain.cam import Cam, Z
from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    CustomForce,
    Force,
    Kinematic,
    Prismatic,
    Ramp,
    Revolute,
    Solution,
    SpringDamper,
    System,
    arctan2,
    shapes,
    simulate,
)  # fmt: skip
from mbsd3d.errors import InputError
from mbsd3d.extend import ForceElement, Ground, number

SPRING_LENGTH = 0.06  # [m] of the spring under the closed valve
SECOND_SPEED_RATIO = 0.5  # [1] of the speed, for the second run of the constraint
TURN_SAMPLES = 1440  # [1] samples of a turn
RTOL = 1e-9


def press(t, bodies, z, parameters, loads, z_dot):
    """Apply the contact force of a follower (bodies[1]) on a cam (bodies[0]); parameters: k, c, base, kind of the cam,
    then the spline's pieces.
    """
    cam, valve = bodies[0], bodies[1]
    stiffness, damping, base, kind = parameters[0], parameters[1], parameters[2], parameters[3]
    count = (parameters.size - 4) // 4
    if kind < 2:
        turn, spin = arctan2(cam.R[2, 1], cam.R[1, 1]), cam.w[0]
    else:
        turn, spin = arctan2(cam.R[1, 0], cam.R[0, 0]), cam.w[2]
    place = turn / (2 * np.pi) * count
    piece = int(np.floor(place.real))
    x = (place - piece) / count * 2 * np.pi
    at = 4 + 4 * (piece % count)
    cubic, square, slope, lift = parameters[at], parameters[at + 1], parameters[at + 2], parameters[at + 3]
    s = ((cubic * x + square) * x + slope) * x + lift
    beside = (3 * cubic * x + 2 * square) * x + slope
    arm = valve.r - cam.r
    depth = s + base - arm[2]
    rate = beside * spin - (valve.velocity[2] - cam.velocity[2])
    force = stiffness * depth * (1 + damping * rate)
    if depth.real > 0.0 and force.real > 0.0:
        loads[0, 2], loads[1, 2] = -force, force
        if kind == 0:
            loads[0, 3], loads[1, 3] = -beside * force, beside * force
        else:
            side = -beside * force / arm[2] if kind == 1 else beside * force / arm[0]
            loads[0, 1], loads[1, 1] = -side, side
            loads[0, 3], loads[0, 4] = arm[2] * side - arm[1] * force, arm[0] * force
            loads[0, 5] = -arm[0] * side


@dataclass(frozen=True)
class Train:
    """Valve train: a cam and its valve.

    ``mass`` of all that goes with the valve [kg]; ``rate, preload`` of its spring [N/m], [N]; ``rpm`` of the camshaft;
    ``contact``: k [N/m]; ``damping``: c [s/m]; ``coils``: mass of the spring [kg], ``pieces`` it is cut into, 0:
    without mass; ``loss``: share of critical damping of its pieces. ValueError for numbers that are not positive
    (preload, damping, loss: negative), or a number of pieces that is not whole.
    """

    cam: Cam
    mass: float = 0.11
    rate: float = 28e3
    preload: float = 250.0
    rpm: float = 3000.0
    contact: float = 3e7
    damping: float = 0.3
    coils: float = 0.05
    pieces: int = 0
    loss: float = 0.01

    def __post_init__(self) -> None:
        for name in ("mass", "rate", "rpm", "contact", "coils"):
            number(getattr(self, name), f"valve: {name}", positive=True)
        for name in ("preload", "damping", "loss"):
            number(getattr(self, name), f"valve: {name}", minimum=0.0)
        if self.pieces < 0 or self.pieces != int(self.pieces):
            raise InputError(f"valve: {self.pieces} pieces of a spring; give a whole number, 0: without mass")

    @property
    def turn(self) -> float:
        """Return the rate of the camshaft [rad/s]."""
        return 2 * np.pi * self.rpm / 60

    @cached_property
    def parts(self) -> tuple[list[Body], list, list]:
        """Return (bodies, joints, forces) without the connection of cam and valve: "camshaft", "valve", pieces of the
        spring.
        """
        start, (of_cam, end) = self.cam.at, self.cam.looks
        shaft = Body("camshaft", 1.0, (1e-3, 1e-3, 1e-3), shape=of_cam)
        stem = [*end, shapes.Cylinder(0.004, 0.05, "z", at=(0, 0, 0.025))]
        valve = Body("valve", self.mass, 3 * (1e-4 * self.mass,), position=start, shape=stem)
        bearing = Revolute(GROUND, shaft, at=(0, 0, 0), axis=self.cam.axis, name="cam bearing")
        turned = AngleDriver(bearing, Ramp(self.turn), name="motor")
        joints = [bearing, turned, Prismatic(GROUND, valve, at=valve.position, axis=Z, name="guide")]
        bodies, n = [shaft, valve], self.pieces
        forces: list[ForceElement] = [Force(valve, (0, 0, -self.preload), name="preload")]
        ends: list[Body | Ground] = [valve]
        for k in range(n):
            at = start + (0, 0, SPRING_LENGTH * (k + 1) / (n + 1))
            piece = Body(
                f"piece {k + 1}", self.coils / n, 3 * (1e-5,), position=at, shape=shapes.Disc(0.012, 0.002, "z")
            )
            joints.append(Prismatic(GROUND, piece, at=at, axis=Z, name=f"guide {k + 1}"))
            bodies.append(piece)
            ends.append(piece)
        stiff = (n + 1) * self.rate
        loss = 2 * self.loss * np.sqrt(stiff * self.coils / n) if n else 0.0
        for k, (a, b) in enumerate(zip(ends, [*ends[1:], GROUND], strict=True)):
            top = start + (0, 0, SPRING_LENGTH * (k + 1) / (n + 1))
            forces.append(
                SpringDamper(a, b, at_a=a.position, at_b=top, stiffness=stiff, damping=loss, name=f"coil {k + 1}")
            )
        return bodies, joints, forces

    def held(self) -> Solution:
        """Simulate a turn with the valve on the cam, base circle to base circle, by kinematics; the spring without
        mass.
        """
        bodies, joints, forces = replace(self, pieces=0).parts
        times = 2 * np.pi / self.turn * np.arange(TURN_SAMPLES + 1) / TURN_SAMPLES
        system = System(bodies, [*joints, self.cam.touch(*bodies)], forces, gravity=(0, 0, 0))
        return simulate(system, float(times[-1]), method=Kinematic(), output=times)

    def pushed(self) -> np.ndarray:
        """Return the force of the cam on the valve in that turn [N], negative where it would have to pull, shape
        (samples,).
        """
        return self.held().reaction("cam").force[:, 2]

    def floats_at(self) -> float:
        """Return the speed of the camshaft [1/min] from which the multiplier would have to pull; inf if none."""
        slow = replace(self, rpm=SECOND_SPEED_RATIO * self.rpm)
        here, there = self.pushed(), slow.pushed()
        b = (here - there) / (self.turn**2 - slow.turn**2)
        a = here - b * self.turn**2
        pulled = b < -1e-9 * np.abs(b).max()
        return float(60 / (2 * np.pi) * np.sqrt(np.min(a[pulled] / -b[pulled]))) if pulled.any() else np.inf

    def free(self, turns: int = 2) -> Solution:
        """Simulate the full motion with the contact, from rest on the base circle; return the last turn,
        ``TURN_SAMPLES`` samples.
        """
        bodies, joints, forces = self.parts
        pieces = self.cam.spline.c.T
        # the cam starts with its nose down
        shift = pieces.shape[0] // 2
        law = self.contact, self.damping, self.cam.height, self.cam.kind
        numbers = (*law, *np.roll(pieces, shift, axis=0).ravel())
        touch = CustomForce(press, on=bodies[:2], parameters=numbers, name="contact")
        system = System(bodies, joints, [*forces, touch], gravity=(0, 0, 0))
        turn = 2 * np.pi / self.turn
        times = turn * (turns - 1 + np.arange(TURN_SAMPLES + 1) / TURN_SAMPLES)
        return simulate(system, float(times[-1]), output=times, rtol=RTOL)

    def gap(self, run: Solution) -> np.ndarray:
        """Return the gap between valve and cam along the travel of the valve, negative where they are pressed together
        [m], shape (samples,).
        """
        angle = np.pi + self.turn * run.t
        return run.position("valve")[:, 2] - self.cam.height - self.cam.spline(np.mod(angle, 2 * np.pi))
