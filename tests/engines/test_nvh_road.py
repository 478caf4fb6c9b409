"""Cars on rough roads: spectra of the road, weighting of the standard, quarter car in closed form, full motions."""

import numpy as np
import pytest
from click.testing import CliRunner

from engines import closed_forms
from engines.nvh.cli import nvh
from engines.nvh.mounts import mounts
from engines.nvh.planar_cross_check import Planes
from engines.nvh.road.profile import Road
from engines.nvh.road.report import ride_of
from engines.nvh.road.ride import Ride, rms, verdict, weight
from engines.nvh.road.vehicle import Vehicle

BODY_HEIGHT = 0.25  # [m] of a body's centre of mass above the wheels' centres

PUBLISHED = {1.0: 0.482, 2.0: 0.531, 3.15: 0.804, 4.0: 0.967, 5.0: 1.039, 6.3: 1.054, 8.0: 1.036, 10.0: 0.988,
             12.5: 0.902, 16.0: 0.768, 20.0: 0.636, 31.5: 0.405, 50.0: 0.246, 80.0: 0.132}  # fmt: skip
"""W_k of the standard's table at thirds of octaves."""


def vehicle(kind: str, **changes: object) -> Vehicle:
    """The compact car with some other numbers."""
    return Vehicle(kind, mounts.car("compact").ride | changes)


def test_weighting_is_that_of_the_standard():
    for frequency, value in PUBLISHED.items():
        # the table holds for exact thirds of octaves, up to 0.8 % beside their names
        assert abs(weight(frequency)) == pytest.approx(value, rel=0.012)


def test_words_of_the_standard():
    assert verdict(0.3) == "not uncomfortable" and verdict(0.7) == "fairly uncomfortable"
    assert verdict(4.0) == "extremely uncomfortable"
    assert [verdict(x) for x in (0.63, 0.6301)] == ["a little uncomfortable", "fairly uncomfortable"]


@pytest.mark.parametrize("kind", ["A", "D"])
def test_both_tracks_have_the_spectrum_of_their_class(kind):
    road = Road(kind, 190.0, seed=3)
    count = 1200  # above two samples of the shortest wave
    for side in (0, 1):
        lines = np.fft.rfft(road.height(road.length * np.arange(count) / count, side)) * 2 / count
        k = np.round(road.waves * road.length).astype(int)
        density = np.abs(lines[k]) ** 2 / 2 * road.length
        assert density == pytest.approx(road.spectrum(road.waves), rel=1e-9, abs=0)
    at_reference = {"A": 16e-6, "D": 1024e-6}[kind]
    assert road.spectrum(0.1) == pytest.approx(at_reference)


def test_long_waves_lift_both_sides_and_short_ones_each_alone():
    road = Road("B", 1000.0, seed=1)
    left, right = road.amplitudes
    alike = np.real(left * right.conj()) / np.abs(left * right)
    assert alike[road.waves < 0.02].min() > 0.8
    assert abs(alike[road.waves > 1.0].mean()) < 0.1


def test_waves_between_share_a_part_of_their_amplitude():
    """Mean of cos(angle between a and a + b e^(i phi)) over the phases, with a = exp(-n / 0.3), a^2 + b^2 = 1."""
    alike = []
    for seed in range(60):
        road = Road("B", 1000.0, seed=seed)
        left, right = road.amplitudes
        band = (road.waves > 0.2) & (road.waves < 0.21)
        alike.append((np.real(left * right.conj()) / np.abs(left * right))[band])
    a, turn = np.exp(-0.205 / 0.3), np.exp(2j * np.pi * np.arange(1000) / 1000)
    right = a + np.sqrt(1 - a**2) * turn
    known = np.mean(right.real / np.abs(right))
    assert np.mean(alike) == pytest.approx(known, abs=0.1)  # four deviations of the mean of 540 waves


def test_the_seed_decides_the_road():
    assert np.array_equal(Road("C", seed=5).amplitudes, Road("C", seed=5).amplitudes)
    assert not np.allclose(Road("C", seed=5).amplitudes, Road("C", seed=6).amplitudes)


def test_small_motions_of_a_quarter_car():
    car, w = vehicle("quarter"), 2 * np.pi * np.geomspace(0.2, 60.0, 31)
    (corner,) = car.corners
    push = corner.tyre + 1j * w * corner.tyre_damping
    found = car.small_motions.frequency_response(w).H[..., 0] * push[:, None]
    spring, tyre = (corner.spring, corner.damper), (corner.tyre, corner.tyre_damping)
    body, wheel = closed_forms.quarter_car(w, (car.mass, corner.mass), spring, tyre)
    assert found[:, 0] == pytest.approx(body, rel=1e-9) and found[:, 1] == pytest.approx(wheel, rel=1e-9)


@pytest.mark.parametrize(
    ("kind", "inertia", "base"), [("half", "pitch_inertia", "wheelbase"), ("whole", "roll_inertia", "track")]
)
def test_a_symmetric_car_bounces_as_a_quarter_car_and_leans_against_its_weight(kind, inertia, base):
    """Wheels move aside by HEIGHT a as the body leans by a, and bear it beside its centre of mass."""
    same = dict(front=0.5, unsprung=[36, 36], spring=[23e3, 23e3], damper=[1600, 1600], tyre=[2e5, 2e5])
    car, quarter = vehicle(kind, **same), vehicle("quarter", **same)
    found, bounce = (x.small_motions.poles for x in (car, quarter))
    n, arm, (corner, *_) = len(car.corners), car.ride[base] / 2, quarter.corners
    turning = car.ride[inertia] * car.part + n * 36 * (0.05 + BODY_HEIGHT**2)  # wheels turn with the body
    M = np.diag([turning, n * 36])

    def of(spring: float, tyre: float) -> np.ndarray:
        return n * np.array([[spring * arm**2, -spring * arm], [-spring * arm, spring + tyre]])

    K, C = of(23e3, 2e5), of(1600, corner.tyre_damping)
    K[0, 0] -= car.mass * 9.81 * BODY_HEIGHT
    lean = np.linalg.eigvals(
        np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    )
    for value in (*bounce, *lean):
        assert np.abs(found - value).min() < 1e-8 * abs(value)


@pytest.mark.parametrize(("kind", "limit"), [("quarter", 1e-4), pytest.param("half", 0.01, marks=pytest.mark.slow)])
def test_full_motion_over_the_road_is_that_of_small_motions(kind, limit):
    ride = Ride(vehicle(kind), Road("B", 190.0, seed=2), 35.0)
    assert ride.run.certificate.passed
    for corner in ride.vehicle.corners if kind == "quarter" else ():
        known = ride.road.height(ride.speed * ride.run.t + corner.x, corner.side)
        assert ride.sampled(ride.under(corner)) == pytest.approx(known, abs=1e-12)
        # the road bears and accelerates both masses: the splines through its push are off by (2 pi / 16)^4 / 384 of it
        borne = sum(x.mass * (9.81 + ride.run.acceleration(x)[:, 2]) for x in ride.run.system.bodies)
        assert ride.tyre_load(corner) == pytest.approx(
            borne, abs=1e-4 * np.abs(ride.sampled(ride.pushed(corner))).max()
        )
    # the guides of the wheels turn with a body that pitches by a few thousandths
    assert ride.difference < limit


def test_a_rough_road_is_rough_as_its_class():
    weighted = [Ride(vehicle("whole"), Road(kind), 20.0).weighted for kind in "AC"]
    assert weighted[1] / weighted[0] == pytest.approx(4.0)  # 16 times the spectrum, a linear car
    assert rms(Ride(vehicle("whole"), Road("C"), 20.0).seat) > weighted[1]


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: Road("X"), "class 'X'; give one of A, B"),
        (lambda: Road("A", 50.0), "too short for its waves"),
        (lambda: Road("A", float("nan")), "road: length"),
        (lambda: Ride(vehicle("half"), Road("A"), 0.0), "ride: speed"),
        (lambda: vehicle("third"), "kind 'third' is unknown; give one of quarter"),
        (lambda: vehicle("half", spring=[0.0, 1e4]), "spring"),
        (lambda: vehicle("half", damper=[-1.0, 1e3]), "damping"),
        (lambda: vehicle("half", unsprung=[40.0]), "unsprung: 1 in a list; give two, front and rear"),
        (lambda: vehicle("half", guides="multilink"), "guides: 'multilink'; give two, front and rear"),
        (lambda: vehicle("half", seat=[0.1, "left"]), "seat"),
        (lambda: Planes(mounts.car("bench")).lines, "'bench' are not known; give compact or saloon"),
        (lambda: ride_of(mounts.car("bench"), "half", "C", 20.0), "not known on its wheels"),
    ],
)
def test_roads_and_cars_that_cannot_be_are_refused(call, text):
    with pytest.raises(ValueError, match=text):
        call()


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ([], "give one of LAYOUT, --road"),
        (["single", "--road", "C"], "give one of LAYOUT, --road"),
        (["single", "--speed", "3"], "--speed does not go with LAYOUT"),
        (["--road", "C", "--rpm", "3000"], "--rpm does not go with --road"),
        (["--valve", "harmonic", "--car", "saloon"], "--car does not go with --valve"),
        (["single", "--rpm", "0"], "rpm"),
        (["single", "--sweep", "0", "--car", "bench"], "sweep of 0 speeds"),
        (["--planes", "--page", "x"], "--page does not go with --planes"),
        (["--valve", "flat"], "cam 'flat' is unknown; there are cycloidal"),
        (["--valve", "harmonic", "--rpm", "-5"], "rpm"),
    ],
)
def test_options_that_do_not_belong_together_are_refused(arguments, text):
    found = CliRunner().invoke(nvh, arguments)
    assert found.exit_code and text in str(found.exception)


@pytest.mark.slow
def test_the_command_writes_a_page_of_a_ride(tmp_path):
    found = CliRunner().invoke(nvh, ["--road", "B", "--speed", "28", "--page", str(tmp_path)])
    assert found.exit_code == 0, found.output
    assert all(f"{kind} car on links" in found.output for kind in ("quarter", "half", "whole"))
    page = (tmp_path / "ride-compact.html").read_text(encoding="utf-8")
    assert page.count("<svg") == 3 and "ride-compact-view.html" in page
