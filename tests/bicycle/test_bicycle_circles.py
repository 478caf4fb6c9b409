"""Steady turns of the general model against Newton and Euler by hand, closed forms, and runs that go on turning."""

import doctest
from dataclasses import replace

import matplotlib
import numpy as np
import pytest
from click.testing import CliRunner
from helpers.closed_forms.steady_turn import steady_turn
from scipy.optimize import brentq

from bicycle import Meijaard2007, circles, named
from bicycle.linear.equations import canonical
from bicycle.model.kinematics import Height, placed
from bicycle.model.mechanism import steer_torque
from bicycle.parameters import library
from bicycle.turns.circles import plot_circles
from bicycle.turns.families import Curve, Search, follow_all
from bicycle.turns.turning import TurnSolver
from mbsd3d import Pulse, accelerations
from mbsd3d.extend import main

matplotlib.use("Agg")
BENCHMARK = Meijaard2007()
TYRES = replace(BENCHMARK, tR=0.04, tF=0.07, rF=0.31, IHxz=-0.01, name="tyres")
CAPSIZE = float(library()["critical_speeds"]["capsize"]["printed"])


def by_hand(p, lean, steer):
    return steady_turn(p, lean, steer, (p.tR, p.tF))


@pytest.mark.parametrize("p", [BENCHMARK, TYRES, named("Browserins")], ids=lambda p: p.name)
@pytest.mark.parametrize(("lean", "steer"), [(0.3, 0.2), (0.55, 0.1), (0.17, 0.4), (-0.7, 2.9), (0.02, 0.006)])
def test_turns_are_those_of_newton_and_euler(p, lean, steer):
    known, found = by_hand(p, lean, steer), circles.turn(p, lean, steer)
    weight = p.g * (p.mR + p.mB + p.mH + p.mF)
    assert known.residual < 1e-13  # nine equations, eight unknowns
    assert found.square == pytest.approx(known.square, rel=1e-10)
    assert found.torque == pytest.approx(known.torque, abs=1e-11 * weight)
    sign = np.sign(known.direction[0])
    assert np.array(found.direction) == pytest.approx(sign * known.direction, abs=1e-12)
    for wheel, force in (("rear", known.rear), ("front", known.front)):  # theirs: x along the rear track, y right, down
        assert found.moment.contacts[wheel].force[0] == pytest.approx(force * [1, -1, -1], abs=1e-10 * weight)
    assert found.moment.lean[0] == pytest.approx(lean, abs=1e-14)
    assert found.moment.yaw_rate[0] == pytest.approx(found.yaw_rate, rel=1e-12)


def on_the_family(turner, steer):
    """(lean, speed) of the hands-free circle near straight running."""
    lean = brentq(lambda lean: turner.free(lean, steer)[0], 1.5 * steer, 6.0 * steer, xtol=1e-16)
    return lean, turner.turn(lean, steer, square=turner.free(lean, steer)[1]).speed


def test_hands_free_circles_begin_at_the_capsize_speed():
    turner = TurnSolver(BENCHMARK)
    (a, v_a), (b, v_b) = (on_the_family(turner, steer) for steer in (0.003, 0.0015))
    limit = (v_b * a**2 - v_a * b**2) / (a**2 - b**2)  # speed = limit + const lean^2 + O(lean^4), lean 0.01
    assert limit == pytest.approx(CAPSIZE, rel=1e-8)
    linear = canonical(BENCHMARK)
    ratio = linear.K0 * linear.g + limit**2 * linear.K2
    assert b / 0.0015 == pytest.approx(-ratio[0, 1] / ratio[0, 0], rel=1e-4)  # terms of second order


def test_nearly_straight_turn_is_as_stable_as_straight_running():
    turn = circles.turn(BENCHMARK, 1e-4, 4e-5)
    expected = canonical(BENCHMARK).eigenvalues([turn.speed])[0]
    miss = np.abs(turn.eigenvalues[:, None] - expected).min(axis=1)
    assert miss.max() < 1e-6  # terms of second order in a lean of 1e-4, times rates of 13


def misfit(t, signal, eigenvalues):
    """What is left of a signal after the best combination of exponentials, over its size."""
    waves = np.exp(np.outer(t, eigenvalues))
    basis = np.hstack([waves.real, waves.imag])
    left = signal - basis @ np.linalg.lstsq(basis, signal, rcond=None)[0]
    return np.abs(left).max() / np.abs(signal).max()


@pytest.mark.parametrize(("lean", "steer"), [(0.1, 0.05), (0.2, 0.12), (0.35, 0.3)])
def test_turn_that_is_disturbed_comes_back_or_leaves_by_its_eigenvalues(lean, steer):
    """In a steady turn the rates of lean and steer are zero; after a pulse they are sums of exp(eigenvalue t)."""
    turn = circles.turn(BENCHMARK, lean, steer)
    torques = steer_torque(turn.system, BENCHMARK, turn.torque + Pulse(1e-4, 0.0, 0.05, 0.1))
    found = replace(turn, system=replace(turn.system, forces=torques)).ride(1.6, rtol=1e-13, output=161)
    after = found.t >= 0.1
    for signal in (found.lean_rate[after], found.steer_rate[after]):
        # rates of 2e-5 rad/s have as large a share that is nonlinear; steps of 1e-13 leave 1e-11 rad/s, less than that
        assert misfit(found.t[after], signal, turn.eigenvalues) < 5e-5
        assert misfit(found.t[after], signal, 1.1 * turn.eigenvalues) > 1e-2  # the ablation: shifted by a tenth


def test_a_turn_goes_on_for_a_round():
    turn = circles.turn(BENCHMARK, 0.25, 0.15)
    found = turn.ride(rtol=1e-11, output=73)
    # some hundred steps of 1e-11 add up, and what they leave in lean and steer turns into heading and place
    assert np.degrees(found.heading[-1]) == pytest.approx(360.0, abs=1e-5)
    assert np.diff(found.heading) == pytest.approx(np.full(72, 2 * np.pi / 72), abs=1e-8)
    centre = np.array([0.0, -turn.radius])
    distance = np.linalg.norm(found.contacts["rear"].point[:, :2] - centre, axis=1)
    assert distance == pytest.approx(np.full(73, turn.radius), abs=1e-7)
    assert found.lean == pytest.approx(np.full(73, 0.25), abs=1e-8)
    assert found.solution.certificate.passed


def test_mirrored_turn_is_the_mirror_image():
    right, left = circles.turn(TYRES, 0.31, 0.22), circles.turn(TYRES, -0.31, -0.22)
    assert left.speed == pytest.approx(right.speed, rel=1e-12)
    assert left.torque == pytest.approx(-right.torque, rel=1e-9)
    assert left.yaw_rate == pytest.approx(-right.yaw_rate, rel=1e-12)
    assert left.radius == pytest.approx(-right.radius, rel=1e-12)
    assert np.sort_complex(left.eigenvalues) == pytest.approx(np.sort_complex(right.eigenvalues), abs=1e-8)


def test_turns_held_at_a_speed():
    for turn in circles.held(BENCHMARK, 5.0, [0.05, -0.3]):
        assert turn.speed == pytest.approx(5.0, rel=1e-10)
        known = by_hand(BENCHMARK, turn.lean, turn.steer)
        assert turn.torque == pytest.approx(known.torque, abs=1e-9)
        assert np.sign(turn.steer) == np.sign(turn.lean) == np.sign(turn.radius)


def test_what_one_speed_needed_helps_the_next():
    shared = TurnSolver(BENCHMARK)
    circles.held(BENCHMARK, 4.0, [0.3], turner=shared)
    first = len(shared.squares)
    (turn,), (alone,) = circles.held(BENCHMARK, 5.0, [0.3], turner=shared), circles.held(BENCHMARK, 5.0, [0.3])
    assert len(shared.squares) - first < 0.6 * first
    assert turn.steer == pytest.approx(alone.steer, rel=1e-10) and turn.torque == pytest.approx(alone.torque, abs=1e-9)


def test_a_bar_shows_how_far_the_torques_are(monkeypatch):
    monkeypatch.setattr(circles, "LEANS", np.array([0.1, 0.2]))
    told, turns, failed = [], [], []
    monkeypatch.setattr(circles.Progress, "update", lambda bar, value: told.append((bar.title, value)))
    circles.held_if_possible(BENCHMARK, (5.0, 7.0), turns, failed.append)
    assert [len(group) for group in turns] == [2, 2] and not failed
    assert told == [("circles: steer torques", value) for value in (0.0, 0.5, 1.0, 1.5)]


def test_families_tell_of_every_point():
    told = []
    search = Search.of(BENCHMARK, 0.15, told.append)
    x = search.seeds(np.radians(8.0))[0]
    points, _ = search.follow(x, search.curve.direction(x))
    assert len(told) >= len(points) > 3


@pytest.mark.slow
def test_torques_are_drawn_as_a_smooth_line_through_the_turns():
    turns = circles.held(BENCHMARK, 5.0, np.radians([5.0, 10.0, 15.0, 20.0]))
    points, line = plot_circles(BENCHMARK, [], [turns, turns[:1]]).axes[3].lines[:2]
    assert np.allclose(line.get_xydata()[::10], points.get_xydata(), rtol=0, atol=1e-12)
    middle = circles.held(BENCHMARK, 5.0, [np.radians(12.5)])[0].torque
    straight = np.interp(12.5, *points.get_xydata().T)
    assert abs(np.interp(12.5, *line.get_xydata().T) - middle) < 0.5 * abs(straight - middle)


@pytest.mark.slow
def test_pivoting_about_the_rear_contact():
    turn = circles.pivot(BENCHMARK, 1.5)
    known = by_hand(BENCHMARK, turn.lean, turn.steer)
    assert abs(turn.radius) < 1e-12 and abs(turn.speed) < 1e-12
    assert turn.yaw_rate == pytest.approx(1.5, rel=1e-9)
    # at rest and in motion the accelerations vanish at nearly the same lean: a condition of 1e3
    assert turn.square == pytest.approx(known.square, rel=1e-8) and turn.torque == pytest.approx(known.torque, abs=1e-8)
    found = turn.ride(1.0, rtol=1e-10)
    assert np.ptp(found.contacts["rear"].point, axis=0).max() < 1e-6  # m: the condition times 1e-8 rad/s^2, as above
    assert np.ptp(found.contacts["front"].point, axis=0).max() > 1.0


def test_curve_follows_a_circle_and_finds_its_top():
    curve = Curve(lambda x: x @ x - 0.25, longest=0.1)
    points = [start := np.array([0.5, 0.0])]
    for x in curve.follow(start, np.array([0.0, 1.0])):
        points.append(x)
        if len(points) > 34:
            break
    points = np.array(points)
    assert np.abs(np.linalg.norm(points, axis=1) - 0.5).max() < 1e-12
    turns = np.unwrap(np.arctan2(points[:, 1], points[:, 0]))
    assert (np.diff(turns) > 0.0).all() and turns[-1] > 2.0 * np.pi  # all the way round, never back
    top = curve.locate(*points[np.flatnonzero(np.diff(points[:, 1]) < 0)[0] + np.array([-1, 1])], lambda x: x[0])
    assert top == pytest.approx([0.0, 0.5], abs=1e-8)


def test_curve_ends_where_its_function_does():
    def f(x):
        if x[0] > 1.0:
            raise ValueError("no such place")
        return x[1] - x[0] ** 2

    points = list(Curve(f).follow(np.zeros(2), np.array([1.0, 0.0])))
    assert 0.99 < points[-1][0] <= 1.0


@pytest.mark.parametrize("bend", [0.03, 0.003, 1e-4])
def test_curve_follows_a_sharp_bend_wherever_the_last_step_before_it_ends(bend):
    """A step that ends within the bend tells nothing of the direction there; at 1e-4 seven of 21 came through."""
    curve = Curve(lambda x: x[1] - np.hypot(x[0], bend))
    for start in np.linspace(-1.0, -0.9, 21):
        points = curve.follow(np.array([start, np.hypot(start, bend)]), np.sqrt(0.5) * np.array([1.0, -1.0]))
        assert any(x[0] > 0.5 for _, x in zip(range(100), points, strict=False))


@pytest.mark.slow
def test_a_family_goes_round_its_sharp_bend_and_is_found_once():
    """Round tyres bend the second family within 0.1 degrees, near a lean of -16.6 and a steer angle of 134.6."""
    search = Search.of(replace(BENCHMARK, tR=0.02, tF=0.02), 0.1, lambda done: None)
    ends = [frozenset(kinds) for *_, kinds in follow_all(search)]
    straight, reversed_end = {"at rest", "straight ahead"}, {"nearly lying", "straight, front end reversed"}
    assert ends == [straight, {"nearly lying", "a wheel lifts"}, reversed_end]


@pytest.fixture(scope="module")
def found():
    return circles.families(BENCHMARK, longest=0.15)


@pytest.mark.slow
def test_families_of_the_benchmark(found):
    ends = {frozenset(family.ends) for family in found}
    assert frozenset({"at rest", "straight ahead"}) in ends
    assert any("straight, front end reversed" in family.ends for family in found)
    for family in found:
        for turn in family.turns[1:-1:3]:
            known = by_hand(BENCHMARK, turn.lean, turn.steer)
            assert abs(known.torque) < 1e-6 * max(1.0, known.square)  # corrected to 1e-9 of lean and steer, steep there
            assert turn.square == pytest.approx(known.square, rel=1e-6) and turn.load > 0.0
            assert turn.torque == 0.0


@pytest.mark.slow
def test_largest_lean_is_one_and_lies_on_its_family(found):
    first = next(family for family in found if "at rest" in family.ends)
    top = dict(first.special)["largest lean"]
    assert top.lean >= first.values("lean").max()

    def lean(steer):
        return brentq(lambda x: by_hand(BENCHMARK, x, steer).torque, 0.35, 0.45, xtol=1e-14)

    h = 0.01
    assert lean(top.steer) == pytest.approx(top.lean, abs=1e-8)
    assert abs(lean(top.steer + h) - lean(top.steer - h)) < 1e-4  # h^3 times the third derivative: the top is flat
    assert lean(top.steer) > max(lean(top.steer + h), lean(top.steer - h))


@pytest.mark.slow
def test_static_limit_stands_and_reversed_family_begins_at_its_capsize_speed(found):
    first = next(family for family in found if "at rest" in family.ends)
    still = first.turns[0] if first.ends[0] == "at rest" else first.turns[-1]
    known = by_hand(BENCHMARK, still.lean, still.steer)
    assert abs(known.square) < 1e-6 and abs(known.torque) < 1e-6 and still.speed < 1e-3
    reversed_ = next(family for family in found if "straight, front end reversed" in family.ends)
    last = reversed_.turns[-1] if "straight" in reversed_.ends[1] else reversed_.turns[0]
    assert last.speed == pytest.approx(reversed_capsize(), rel=1e-4)  # steer 1e-3 from straight


def reversed_capsize():
    """Capsize speed of the bicycle with its front part turned by half a turn about the steer axis, as parameters."""
    p = BENCHMARK
    axis = np.array([np.sin(p.lam), 0.0, np.cos(p.lam)])
    half = 2.0 * np.outer(axis, axis) - np.eye(3)
    on_axis = np.array([p.w + p.c, 0.0, 0.0])
    hub = on_axis + half @ ([p.w, 0.0, -p.rF] - on_axis)
    G = on_axis + half @ ([p.xH, 0.0, p.zH] - on_axis)
    pitch = brentq(lambda x: height_of_front(p, hub, x), -0.3, 0.3, xtol=1e-15)
    R = np.array([[np.cos(pitch), 0, np.sin(pitch)], [0, 1.0, 0], [-np.sin(pitch), 0, np.cos(pitch)]])
    rear = np.array([0.0, 0.0, -p.rR])
    moved = lambda point: rear + R @ (np.asarray(point) - rear)  # noqa: E731
    front, head, axis = moved(hub), moved(on_axis), R @ axis
    ground = head - axis * head[2] / axis[2]
    H, B = R @ half @ inertia(p, "H") @ half.T @ R.T, R @ inertia(p, "B") @ R.T
    G, GB = moved(G), moved([p.xB, 0.0, p.zB])
    turned = replace(
        p, w=front[0], c=ground[0] - front[0], lam=np.arctan2(axis[0], axis[2]), xH=G[0], zH=G[2], xB=GB[0], zB=GB[2],
        IHxx=H[0, 0], IHzz=H[2, 2], IHxz=H[0, 2], IBxx=B[0, 0], IBzz=B[2, 2], IBxz=B[0, 2], unphysical=True,
    )  # fmt: skip
    linear = canonical(turned)
    K0, K2 = linear.g * linear.K0, linear.K2
    return np.sqrt(-np.linalg.det(K0) / (K0[0, 0] * K2[1, 1] - K0[1, 0] * K2[0, 1]))  # det(g K0 + v^2 K2) = 0


def inertia(p, part):
    return p.inertia(part)


def height_of_front(p, hub, pitch):
    rear = np.array([0.0, 0.0, -p.rR])
    arm = hub - rear
    return rear[2] - np.sin(pitch) * arm[0] + np.cos(pitch) * arm[2] + p.rF


@pytest.mark.slow
def test_command_writes_what_it_says(found, tmp_path, monkeypatch):
    monkeypatch.setattr(circles, "families", lambda parameters, keep: keep.extend(found))
    answer = CliRunner().invoke(main, ["bicycle", "circles", "--speed", "5", "--out", str(tmp_path)])
    assert answer.exit_code == 0, answer.output
    assert "largest lean" in answer.output and "24.069" in answer.output
    assert {path.suffix for path in tmp_path.iterdir()} == {".csv", ".png", ".svg"}
    header, *rows = (tmp_path / "Meijaard2007_circles.csv").read_text(encoding="utf-8").splitlines()
    assert len(rows) > sum(len(family.turns) for family in found) and header.startswith("family,lean [rad]")


@pytest.mark.slow
def test_tables_keep_names_with_a_point(tmp_path, monkeypatch):
    monkeypatch.setattr(circles, "families", lambda parameters, keep: None)
    lines = [f"{key} = {value!r}" for key, value in BENCHMARK.values().items() if key[0] != "t"]
    (tmp_path / "bike.v2.txt").write_text("\n".join(lines))
    arguments = ["bicycle", "circles", str(tmp_path / "bike.v2.txt"), "--speed", "5", "--out", str(tmp_path / "out")]
    assert CliRunner().invoke(main, arguments).exit_code == 0
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        f"bike.v2_circles.{x}" for x in ("csv", "png", "svg")
    }


@pytest.mark.slow
def test_interrupted_command_keeps_what_was_found(found, tmp_path, monkeypatch):
    def interrupted(parameters, keep):
        keep.append(found[0])
        raise KeyboardInterrupt

    monkeypatch.setattr(circles, "families", interrupted)
    answer = CliRunner().invoke(main, ["bicycle", "circles", "--out", str(tmp_path)])
    assert answer.exit_code == 130 and "interrupted; what was found until then is kept" in answer.output
    rows = (tmp_path / "Meijaard2007_circles.csv").read_text(encoding="utf-8").splitlines()
    assert len(rows) == 1 + len(found[0].turns)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: circles.turn(BENCHMARK, 0.1, 0.0), "steer = 0: a straight wheel makes no turn"),
        (lambda: circles.turn(BENCHMARK, 0.3, np.pi), "steer = 3.14159: a straight wheel makes no turn"),
        (lambda: circles.turn(BENCHMARK, 0.3, -0.25), "no speed makes a steady turn"),
        (lambda: circles.turn(BENCHMARK, 1.7, 0.1), "lies on the ground"),
        (lambda: circles.held(BENCHMARK, 0.0, [0.1]), "circles.held: speed"),
        (lambda: circles.held(BENCHMARK, 5.0, [0.0]), "an upright bicycle goes straight"),
        (lambda: circles.held(BENCHMARK, 0.2, [0.6]), "no steady turn of 0.2 m/s at lean 34.38"),
        (lambda: circles.pivot(BENCHMARK, 0.0), "circles.pivot: yaw_rate"),
        (lambda: circles.families(replace(BENCHMARK, g=0.0)), "without gravity there are no steady turns"),
    ],
)
def test_bad_input_names_what_is_wrong(call, message):
    with pytest.raises(ValueError, match=message):
        call()


def test_examples():
    result = doctest.testmod(circles)
    assert result.attempted and not result.failed


def test_turns_backwards_are_refused_before_circles_are_sought(tmp_path):
    answer = CliRunner().invoke(main, ["bicycle", "circles", "--speed", "5", "--speed", "-3", "--out", str(tmp_path)])
    assert answer.exit_code == 2 and "circles: --speed: -3.0 is not positive; give a number > 0" in answer.stderr


@pytest.mark.parametrize("p", [BENCHMARK, TYRES], ids=lambda p: p.name)
def test_the_height_of_the_front_contact_is_that_of_the_placed_bicycle(p):
    rng = np.random.default_rng(41)
    for lean, steer in zip(rng.uniform(-1.3, 1.3, 20), rng.uniform(-3.0, 3.0, 20), strict=True):
        pitches = rng.uniform(-1.4, 1.4, 5)
        known = [placed(p, lean, steer, pitch).contact[2] for pitch in pitches]
        assert Height(p, lean, steer)(pitches) == pytest.approx(known, abs=1e-14)


def test_columns_are_accelerations_of_the_general_model():
    """Accelerations of lean and steer of `accelerations` at three states, and their differences."""
    turner = TurnSolver(TYRES)
    lean, steer, scale = 0.31, 0.27, TYRES.g * TYRES.w
    at = turner.pose(lean, steer)

    def swing(system, square):
        now = accelerations(system, turner.state(at, steer, square))
        frame, fork, axle = now.alpha("frame")[0], now.alpha("fork")[0], at.frame[:, 1]
        return np.array(
            [np.cross(frame, axle)[2] / np.hypot(axle[0], axle[1]), at.frame @ turner.axis @ (fork - frame)]
        )

    rest, moving, pushed = swing(turner.system, 0.0), swing(turner.system, scale), swing(turner.with_torque, 0.0)
    found = turner.columns(lean, steer, torque=True)
    for column, known in zip(found, (rest, moving - rest, pushed - rest), strict=True):
        assert column == pytest.approx(known, rel=1e-9, abs=1e-9)
