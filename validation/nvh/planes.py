"""What a plane can say about an engine in its car: exact, approximate, or impossible, each measured.

Where both exist the planar model is computed as well and timed; what a plane has no term for is named with its size.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import eigh

from mbsd3d import Kinematic, simulate
from validation.engine_balance import planar_sum, spatial
from validation.engine_balance.harmonics import Harmonics
from validation.nvh.engine import presets
from validation.nvh.engine.loads import Source
from validation.nvh.engine.main_bearings import COUNT, cut_engine
from validation.nvh.held.mounts import Car
from validation.nvh.held.rigid_modes import mass_matrix, rigid_modes
from validation.nvh.held.roll_axis import roll_axis, stiffness_matrix
from validation.nvh.road.report import quarter_car, ride_of
from validation.nvh.road.ride import rms
from validation.nvh.study import Study
from validation.twins import planar

ENGINE, PAIRED, RPM, SPEED = "inline_4", "inline_3", 4000.0, 20.0
ACROSS = (1, 2, 3)  # y, z, about x: the plane across the crank
EXACT, NEAR, NEVER = "exact", "approximate", "impossible"
FELT = 0.06  # m of travel
SAME = 1e-5  # relative: the run over the road holds 2e-6, kinematics 1e-13


@dataclass(frozen=True)
class Line:
    """``what``; ``verdict``; ``size``: of the difference, or of what is missing; ``term``: where it comes from;
    ``plane, space``: seconds, None for a model that does not exist or costs nothing.
    """

    what: str
    verdict: str
    size: str
    term: str
    plane: float | None = None
    space: float | None = None


@dataclass(frozen=True)
class Planes:
    """The comparison in a car that is known on its wheels."""

    car: Car

    @cached_property
    def study(self) -> Study:
        """The engine in the car."""
        return Study(presets.preset(ENGINE), self.car, RPM)

    @cached_property
    def lines(self) -> list[Line]:
        """All of them, in the order from crank to road."""
        return [self.block(), self.bearings(), self.couple(), self.modes(), self.roll(), self.spin(), *self.road()]

    def block(self) -> Line:
        """Forces of the engine on its block."""
        engine = self.study.preset.engine(RPM)
        plane, quick = timed(lambda: planar_sum.harmonics(engine))
        run, slow = timed(lambda: spatial.turn(spatial.build(engine), engine))
        off = largest(spatial.harmonics(run, engine), plane)
        return Line("forces of the engine", verdict(off), f"{off:.0e}", "sum of planes along the crank", quick, slow)

    def bearings(self) -> Line:
        """Main bearings of the cut crank, motored."""
        engine, source = self.study.preset.engine(RPM), Source(self.study.preset, 0.0)
        cut, _ = cut_engine(source, RPM)
        times = 4 * np.pi / engine.rate * np.arange(2 * COUNT + 1) / (2 * COUNT)
        run, slow = timed(lambda: simulate(cut, float(times[-1]), method=Kinematic(), output=times))
        cylinders = range(len(engine.stations))
        plane, quick = timed(lambda: [planar.kinematics(planar_sum.build(engine, i), times) for i in cylinders])
        off = [
            np.abs(run.reaction(f"front {i + 1}").force[:, :2] - plane[i].reaction("bearing").force / 2).max()
            for i in cylinders
        ]
        share = max(off) / np.abs(plane[0].reaction("bearing").force).max()
        return Line("main bearings", verdict(share), f"{share:.0e}", "crank cut: half a throw each", quick, slow)

    def couple(self) -> Line:
        """The couple of an engine with three cylinders, which balance shafts of the first order take."""
        load = np.abs(Source(presets.preset(PAIRED), 0.0).at(RPM).six[2])
        what, term = f"first order of {PAIRED}", "couple in the plane of the crank"
        return Line(what, NEVER, f"{max(load[4:]):.0f} N m", term)

    def modes(self) -> Line:
        """Sway, bounce and roll of the powertrain in the plane across the crank."""
        body, placed = self.study.body.rigid, self.study.placed
        part = np.ix_(ACROSS, ACROSS)
        (squares, _), quick = timed(lambda: eigh(stiffness_matrix(body, placed)[part], mass_matrix(body)[part]))
        found, slow = timed(lambda: rigid_modes(body, placed))
        plane, space = np.sqrt(squares) / (2 * np.pi), np.array([mode.frequency for mode in found])
        worst = max(np.abs(space - f).min() / f for f in plane)
        return Line(
            "modes on the mounts", verdict(worst), f"{worst:.1%} in Hz", "mounts and masses off the plane", quick, slow
        )

    def roll(self) -> Line:
        """The axis that a torque about the crank turns the powertrain about."""
        lean = np.degrees(np.arccos(abs(roll_axis(self.study.body.rigid)[0])))
        return Line("torque-roll axis", NEVER, f"{lean:.1f} degrees", "products of inertia")

    def spin(self) -> Line:
        """Pitch and yaw are coupled by the crank."""
        _, slow = timed(lambda: self.study.map, 1)
        return Line("spin of the crank", NEVER, f"{self.study.spin:.2%} of force", "w x J w, pitch to yaw", None, slow)

    def road(self) -> list[Line]:
        """Cars on a rough road, and what guides their wheels."""
        quarter, half, whole = (ride_of(self.car, kind, "C", SPEED) for kind in ("quarter", "half", "whole"))
        linked = ride_of(self.car, "quarter", "C", SPEED, linked=True)
        known, quick = timed(lambda: quarter_car(quarter))
        _, slow = timed(lambda: replace(quarter, vehicle=replace(quarter.vehicle)).seat)
        off = rms(quarter.run_seat - known) / rms(known)  # and all is compiled before times are taken
        (_, half_time), (_, whole_time) = (timed(lambda ride=ride: ride.run, 1) for ride in (half, whole))
        held = whole.vehicle.guides[0].curves
        toe = 60 * np.degrees(held.at("toe", FELT))
        linked_off, roll_off = linked.weighted / quarter.weighted - 1, half.weighted / whole.weighted - 1
        return [
            Line("quarter car", verdict(off), f"{off:.0e}", "straight guide; small motions", quick, slow),
            Line("wheel on its links", verdict(linked_off), f"{linked_off:+.1%} at the seat", "side motion and turn"),
            Line(
                "half car",
                verdict(roll_off),
                f"{roll_off:+.1%} at the seat",
                "roll, two different tracks",
                half_time,
                whole_time,
            ),
            Line("bump steer", NEVER, f"{toe:.0f} minutes", f"toe at {1e3 * FELT:.0f} mm, turn about z"),
        ]


def verdict(off: float) -> str:
    """Of a relative difference."""
    return EXACT if abs(off) < SAME else NEAR


def largest(space: Harmonics, plane: Harmonics) -> float:
    """Largest difference of forces and of torques over the largest of each."""
    pairs = ((space.force, plane.force), (space.torque, plane.torque))
    return max(float(np.abs(a - b).max() / np.abs(b).max()) for a, b in pairs)


def timed(call: Callable, times: int = 2) -> tuple:
    """(what it returns, seconds of its fastest call)."""
    best = np.inf
    for _ in range(times):
        start = time.perf_counter()
        found = call()
        best = min(best, time.perf_counter() - start)
    return found, best


def table(car: Car) -> list[list[str]]:
    """The lines as text."""
    rows = [["", "plane", "by", "term", "plane [ms]", "space [ms]"]]
    for line in Planes(car).lines:
        seconds = ("-" if x is None else f"{1e3 * x:.3g}" for x in (line.plane, line.space))
        rows.append([line.what, line.verdict, line.size, line.term, *seconds])
    return rows
