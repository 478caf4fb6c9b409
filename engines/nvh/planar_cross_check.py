"""Comparison of planar models with the engine in its car in space: exact, approximate, or impossible, each measured.

Where both exist the planar model (`flat`, closed forms, planar twins) is computed as well, and both are timed; what a
plane has no term for is named with its size, and with the time that it takes in space.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from engines import closed_forms, planar
from engines.balance import planar_sum, spatial
from engines.balance.harmonics import Harmonics
from engines.nvh.control.report import ActiveMount
from engines.nvh.excitation import balance_shafts, presets
from engines.nvh.excitation.loads import Source
from engines.nvh.excitation.main_bearings import TURN_SAMPLES, cut_engine
from engines.nvh.mounts.mounts import Car
from engines.nvh.mounts.rigid_modes import rigid_modes
from engines.nvh.mounts.roll_axis import roll_axis
from engines.nvh.planar_model import Flat, front_view
from engines.nvh.road.report import quarter_car, ride_of
from engines.nvh.road.ride import rms
from engines.nvh.study import Study
from engines.nvh.valvetrain.report import Valve
from mbsd3d import Kinematic, simulate
from mbsd3d.errors import InputError

ENGINE, COUPLE_ENGINE, RPM, SPEED = "inline_4", "inline_3", 4000.0, 20.0
OUT_OF_PLACE = balance_shafts.Fault("out of place", 0.02, (0.003, 0.005, -0.004))
EXACT, APPROXIMATE, IMPOSSIBLE = "exact", "approximate", "impossible"
WHEEL_TRAVEL = 0.06  # [m] of the comparison of the suspensions
RELATIVE_TOLERANCE = 1e-5  # [1] relative; the run over the road holds 2e-6, kinematics 1e-13


@dataclass(frozen=True)
class Line:
    """Line of the comparison: ``what``; ``verdict``; ``size``: of the difference, or of what is missing; ``term``:
    where it comes from; ``plane, space``: run time [s], None for a model that does not exist or costs nothing.
    """

    what: str
    verdict: str
    size: str
    term: str
    plane: float | None = None
    space: float | None = None


@dataclass(frozen=True)
class Planes:
    """Planar and spatial results of an engine in a car."""

    car: Car

    @cached_property
    def study(self) -> Study:
        """Return the study of the engine in the car."""
        return Study(presets.preset(ENGINE), self.car, RPM)

    @cached_property
    def lines(self) -> list[Line]:
        """Return all lines of the comparison, from crank to road; raise ValueError for a car with unknown wheels or
        shell.
        """
        if self.car.ride is None or self.car.shell is None:
            raise InputError(f"planes: wheels or shell of '{self.car.name}' are not known; give compact or saloon")
        return [
            self.block(), self.bearings(), self.shafts(), self.couple(), self.modes(), self.roll(), self.spin(),
            self.active(), self.cabin(), self.valve(), self.barrel(), *self.road(), *self.guides(),
        ]  # fmt: skip

    def block(self) -> Line:
        """Compare the forces of the engine on its block."""
        engine = self.study.preset.engine(RPM)
        plane, quick = timed(lambda: planar_sum.harmonics(engine))
        run, slow = timed(lambda: spatial.turn(spatial.build(engine), engine))
        off = largest(spatial.harmonics(run, engine), plane)
        return Line("forces of the engine", verdict(off), f"{off:.0e}", "sum of planes along the crank", quick, slow)

    def bearings(self) -> Line:
        """Compare the main bearings of the cut crank, motored."""
        engine, source = self.study.preset.engine(RPM), Source(self.study.preset, 0.0)
        cut, _ = cut_engine(source, RPM)
        times = 4 * np.pi / engine.rate * np.arange(2 * TURN_SAMPLES + 1) / (2 * TURN_SAMPLES)
        run, slow = timed(lambda: simulate(cut, float(times[-1]), method=Kinematic(), output=times))
        cylinders = range(len(engine.stations))
        plane, quick = timed(lambda: [planar.kinematics(planar_sum.build(engine, i), times) for i in cylinders])
        off = [
            np.abs(run.reaction(f"front {i + 1}").force[:, :2] - plane[i].reaction("bearing").force / 2).max()
            for i in cylinders
        ]
        share = max(off) / np.abs(plane[0].reaction("bearing").force).max()
        return Line("main bearings", verdict(share), f"{share:.0e}", "crank cut: half a throw each", quick, slow)

    def shafts(self) -> Line:
        """Compare balance shafts that are out of place by their order on the block."""
        preset = self.study.preset
        fitted = balance_shafts.faulty(preset, balance_shafts.fitted(preset, "raised"), OUT_OF_PLACE)
        plane, quick = timed(lambda: balance_shafts.left(preset, fitted, RPM))
        space, slow = timed(lambda: balance_shafts.left_in_space(preset, fitted, RPM))
        off = np.abs(space - plane).max() / np.abs(plane).max()
        return Line("balance shafts", verdict(off), f"{off:.0e}", "sum of planes along the crank", quick, slow)

    def couple(self) -> Line:
        """Compare the couple of an engine with three cylinders, balanced by shafts of the first order."""
        load, slow = timed(lambda: np.abs(Source(presets.preset(COUPLE_ENGINE), 0.0).at(RPM).six[2]))
        what, term = f"first order of {COUPLE_ENGINE}", "couple in the plane of the crank"
        return Line(what, IMPOSSIBLE, f"{max(load[4:]):.0f} N m", term, None, slow)

    def modes(self) -> Line:
        """Compare sway, bounce and roll of the powertrain in the plane across the crank."""
        body, placed = self.study.body.rigid, self.study.placed
        plane, quick = timed(lambda: Flat(self.study.on_mounts).modes())
        found, slow = timed(lambda: rigid_modes(body, placed))
        space = np.array([mode.frequency for mode in found])
        worst = max(np.abs(space - f).min() / f for f in plane)
        term = "mounts and masses off the plane"
        return Line("modes on the mounts", verdict(worst), f"{worst:.1%} in Hz", term, quick, slow)

    def roll(self) -> Line:
        """Compare the axis about which a torque about the crank turns the powertrain."""
        axis, slow = timed(lambda: roll_axis(self.study.body.rigid))
        lean = np.degrees(np.arccos(abs(axis[0])))
        return Line("torque-roll axis", IMPOSSIBLE, f"{lean:.1f} degrees", "products of inertia", None, slow)

    def spin(self) -> Line:
        """Measure the coupling of pitch and yaw by the spin of the crank."""
        _, slow = timed(lambda: self.study.on_mounts.answer(self.study.source, self.study.map.rpm))
        return Line(
            "spin of the crank", IMPOSSIBLE, f"{self.study.spin:.2%} of force", "w x J w, pitch to yaw", None, slow
        )

    def active(self) -> Line:
        """Compare the step from which an active mount is unstable."""
        cancel = ActiveMount(self.study).cancel
        flat = Flat(self.study.on_mounts)
        plane, quick = timed(lambda: flat.path(cancel).limit(cancel.W))
        space, slow = timed(lambda: replace(cancel).path.limit(cancel.W))
        off, term = plane / space - 1, "pitch and yaw of the powertrain"
        return Line("active mount", verdict(off), f"{off:+.1%} of the stable step", term, quick, slow)

    def cabin(self) -> Line:
        """Compare the acceleration of the seat rail over all speeds and orders with engine, mounts and shell in one
        plane.
        """
        study, flat = self.study, Flat(self.study.on_mounts)
        cabin, found = study.cabin, study.map
        plane, quick = timed(lambda: flat.seat(cabin, found.rpm, found.orders, found.load))
        space, slow = timed(lambda: cabin.seat(found) @ cabin.axes)
        off = float(np.linalg.norm(space - np.pad(plane, [(0, 0), (0, 0), (1, 0)])) / np.linalg.norm(space))
        return Line("shell, at the seat", verdict(off), f"{off:.0%} rms", "torsion, pitch and yaw", quick, slow)

    def valve(self) -> Line:
        """Compare the speed at which a valve leaves its cam: closed form over the spline of the lift, and
        multiplier."""
        train = Valve("cycloidal").train
        angle = np.linspace(0.0, 2 * np.pi, 20001)

        def closed() -> float:
            s, dds = train.cam.spline(angle), train.cam.spline(angle, 2)
            return 30 / np.pi * closed_forms.cams.float_rate(train.mass, train.rate, train.preload, s, dds)

        (plane, quick), (space, slow) = timed(closed), timed(train.floats_at)
        off = space / plane - 1
        return Line("valve on its cam", verdict(off), f"{abs(off):.0e}", "cam and valve in one plane", quick, slow)

    def barrel(self) -> Line:
        """Compare the side force on the guide of a cam whose axis is parallel to the travel of the valve."""
        made = Valve("cycloidal", None, "barrel")
        run, slow = timed(made.train.held)
        side = np.abs(run.reaction("cam").force[:, 1]).max()
        return Line("barrel cam", IMPOSSIBLE, f"{side:.0f} N aside", "drum turns about the valve's way", None, slow)

    def road(self) -> list[Line]:
        """Compare cars on a rough road."""
        quarter, half, whole = (ride_of(self.car, kind, "C", SPEED) for kind in ("quarter", "half", "whole"))
        linked = ride_of(self.car, "quarter", "C", SPEED, linked=True)
        known, quick = timed(lambda: quarter_car(quarter))
        (_, of_quarter), (_, of_linked), (_, of_whole), (_, of_half) = (
            timed(lambda ride=ride: replace(ride, vehicle=replace(ride.vehicle)).seat)
            for ride in (quarter, linked, whole, half)
        )
        off = rms(quarter.run_seat - known) / rms(known)
        by_links, by_roll = linked.weighted / quarter.weighted - 1, half.weighted / whole.weighted - 1
        small = "straight guide; small motions"
        return [
            Line("quarter car", verdict(off), f"{off:.0e}", small, quick, of_quarter),
            Line("wheel on its links", verdict(by_links), f"{by_links:+.1%} at the seat", "side motion and turn", quick,
                 of_linked),
            Line("half car", verdict(by_roll), f"{by_roll:+.1%} at the seat", "roll, two different tracks", of_half,
                 of_whole),
        ]  # fmt: skip

    def guides(self) -> list[Line]:
        """Compare the front suspension kinematics over wheel travel; raise ValueError if it has no double wishbone."""
        car = ride_of(self.car, "whole", "C", SPEED).vehicle
        held, corner = car.guides[0], car.corners[0]
        heights = np.linspace(-WHEEL_TRAVEL, WHEEL_TRAVEL, 41)
        (camber, ratio), quick = timed(lambda: front_view(held, heights))
        curves, slow = timed(lambda: replace(held).curves)
        off = 60 * np.degrees(np.abs(camber - np.interp(heights, curves.z, curves.camber)).max())
        by_ratio = np.abs(np.abs(ratio) / np.abs(np.interp(heights, curves.z, curves.ratio)) - 1).max()
        middle, loaded = heights.size // 2, car.by_load[0]
        flat = np.gradient(ratio, heights)[middle] / ratio[middle] * corner.load / corner.spring
        toe, ahead = 60 * np.degrees(curves.at("toe", WHEEL_TRAVEL)), 1e3 * curves.at("ahead", 0.0)
        size, travel = f"{off:.1f} minutes, ratio {by_ratio:.1%}", f"{1e3 * WHEEL_TRAVEL:.0f} mm"
        return [
            Line("camber and motion ratio", verdict(by_ratio), size, "axes of the arms not along the car", quick, slow),
            Line("load on the strut", verdict(flat / loaded - 1), f"{flat:.1%}, not {loaded:.1%} of stiffness",
                 "path of the strut's end out of the plane", quick, slow),
            Line("bump steer", IMPOSSIBLE, f"{toe:.0f} minutes", f"toe at {travel}, turn about z", None, slow),
            Line("anti-dive", IMPOSSIBLE, f"{ahead:.0f} mm per m", "in front view no x", None, slow),
        ]  # fmt: skip


def verdict(off: float) -> str:
    """Return the assessment of a relative difference."""
    return EXACT if abs(off) < RELATIVE_TOLERANCE else APPROXIMATE


def largest(space: Harmonics, plane: Harmonics) -> float:
    """Return the largest difference of forces and of torques over the largest of each [-]."""
    pairs = ((space.force, plane.force), (space.torque, plane.torque))
    return max(float(np.abs(a - b).max() / np.abs(b).max()) for a, b in pairs)


def timed(call: Callable, times: int = 2) -> tuple:
    """Return (result of a call, seconds of its fastest repetition)."""
    best = np.inf
    for _ in range(times):
        start = time.perf_counter()
        found = call()
        best = min(best, time.perf_counter() - start)
    return found, best


def table(car: Car) -> list[list[str]]:
    """Return the lines of the comparison as text."""
    rows = [["", "plane", "by", "term", "plane [ms]", "space [ms]"]]
    for line in Planes(car).lines:
        seconds = ("-" if x is None else f"{1e3 * x:.3g}" for x in (line.plane, line.space))
        rows.append([line.what, line.verdict, line.size, line.term, *seconds])
    return rows
