"""Parameters and models of bicycles: published figures, a second formulation, symmetries, and what is refused."""

import doctest
import pickle
from dataclasses import fields, replace
from importlib import import_module

import numpy as np
import pytest
from helpers.closed_forms.small_motions import bicycle_matrix
from helpers.page_limits import limits
from scipy.optimize import brentq

from bicycle import Meijaard2007, Parameters, general, kinematics, named, parameters, play, ride, rider, whipple
from bicycle.linear.equations import canonical
from bicycle.model.mechanism import Bicycle, PublishedBody
from bicycle.parameters import deviations, library, read_values
from mbsd3d import State, System, accelerations, simulate
from mbsd3d.errors import ArgumentError
from mbsd3d.rotations import exponential, matrix, multiply
from validation.theory import whipple_lagrange

BENCHMARK = Meijaard2007()
ROUND = replace(
    BENCHMARK, rR=0.31, rF=0.42, tR=0.05, tF=0.03, c=0.055, lam=0.35, xH=0.87, zH=-0.75, IHxz=0.011, name="round tyres"
)
"""Wheels of unequal size and crown, nothing zero or equal."""


MODULES = ("parameters.definition", "parameters", "model.mechanism", "linear.equations", "linear.general")


@pytest.mark.parametrize("module", [*MODULES, "linear.stability", "linear.critical"])
def test_examples_of_the_modules(module):
    found = doctest.testmod(import_module(f"bicycle.{module}"))
    assert found.attempted and not found.failed


# --- parameters -------------------------------------------------------------------------------------------------------


def test_fields_know_symbol_unit_and_meaning():
    known = {f.name: f.metadata for f in fields(Parameters) if f.metadata}
    assert set(known) == set(library()["parameters"]["values"]) | {"tR", "tF"}
    assert known["IBxz"]["unit"] == "kg m^2" and known["lam"]["symbol"] == "λ" and "trail" in known["c"]["meaning"]


def test_benchmark_is_the_published_one():
    assert BENCHMARK.lam == np.pi / 10 and {**BENCHMARK.values(), "lam": "pi/10"} == {
        **library()["parameters"]["values"],
        "tR": 0.0,
        "tF": 0.0,
    }
    assert named("Benchmark").values() == BENCHMARK.values()


def test_a_typo_is_an_error():
    with pytest.raises(TypeError, match="mb"):
        replace(BENCHMARK, mb=3.0)
    with pytest.raises(ValueError, match="'Brower'; did you mean Browser"):
        named("Brower")
    with pytest.raises(ValueError, match="'meijaard2008'; did you mean Meijaard2007"):
        named("meijaard2008")
    with pytest.raises(ValueError, match="'mine.json'; .*--list shows all, and parameter files end in .txt"):
        parameters.named("mine.json")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"rF": 0.0}, "radius of the front wheel rF: 0.0 is not positive"),
        ({"rR": -0.3}, "rR: -0.3 is not positive"),
        ({"mB": -1.0}, "mB: -1.0 is below 0"),
        ({"w": np.nan}, "wheelbase w: not finite"),
        ({"c": "8 cm"}, "trail c: expected a number"),
        ({"lam": 1.6}, "lam = 1.6 rad"),
        ({"tF": 0.4}, "tF = 0.4 exceeds rF = 0.35"),
        ({"IFyy": 0.3}, "front wheel .F.: inertia .* exceeds the sum .* unphysical=True"),
        ({"IBxx": -1.0}, r"frame and rider .B.: inertia .* < 0"),
        ({"mH": 0.0}, "mass is 0 but inertia is not"),
    ],
)
def test_impossible_values_name_bicycle_part_and_value(change, message):
    with pytest.raises(ValueError, match=f"bicycle 'Meijaard2007': .*{message}"):
        replace(BENCHMARK, **change)


def test_impossible_inertias_of_published_sets_need_the_flag():
    refused = []
    for name in parameters.names():
        try:
            named(name)
        except ValueError as error:
            assert "unphysical=True" in str(error)
            refused.append(name)
    assert len(parameters.names()) == 47 and set(refused) == {
        "benchmark-browser", "benchmark-extendedoptc", "benchmark-realizedopttwo", "Browser",
        "HC_Yellow", "HC_Yellowrev", "Yellow", "Yellowrev",
    }  # fmt: skip
    p = named("Browser", unphysical=True)
    frame = whipple(p).part("frame")
    assert isinstance(frame, PublishedBody) and frame.inertia[0, 2] == -p.IBxz and frame.inertia[2, 2] == p.IBzz
    with pytest.raises(ValueError, match="< 0"):
        replace(p, IBxx=-1.0)  # the flag does not allow everything


def test_standard_deviations_belong_to_the_measured_sets():
    assert deviations("Balanceassistv1")["IBxx"] == 0.018
    assert deviations("Tms") == {} and set(deviations("Rigid")) <= set(BENCHMARK.values())


TEXT = """# measured
{rest}
rF = 0.343 +/- 0.0002   # front
mH = 3.0 +/- 0.1, 3.2 +/- 0.2
IHzz = (7.1 +/- 0.2)e-03
"""


def lines(*left_out, **changed):
    values = {k: v for k, v in BENCHMARK.values().items() if k not in (*left_out, "tR", "tF")} | changed
    return "\n".join(f"{key} = {value!r}" for key, value in values.items())


def test_text_files_with_deviations(tmp_path):
    path = tmp_path / "mine.txt"
    path.write_text(TEXT.format(rest=lines("rF", "mH", "IHzz")))
    p = Parameters.from_file(path)
    assert (p.name, p.rF, p.IHzz, p.lam) == ("mine", 0.343, 7.1e-3, BENCHMARK.lam)
    assert p.mH == pytest.approx(3.1, rel=1e-15)
    spread = read_values(path)[1]
    assert spread == {"rF": 0.0002, "mH": pytest.approx(np.hypot(0.1, 0.2) / 2), "IHzz": pytest.approx(2e-4)}
    assert p.deviations == spread
    assert parameters.named(path) == parameters.named(str(path)) == p


def test_deviations_stay_with_their_set():
    rigid = parameters.named("Rigid")
    assert rigid.deviations == deviations("Rigid") and BENCHMARK.deviations == {}
    assert replace(rigid, c=0.1, name="more trail").deviations == rigid.deviations
    assert pickle.loads(pickle.dumps(rigid)) == rigid and hash(rigid) == hash(replace(rigid, deviations={}))
    given = {"c": 0.01, "w": 0.0}
    mine = replace(BENCHMARK, deviations=given)
    given["c"] = 1.0
    assert mine.deviations == {"c": 0.01}


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"cc": 0.1}, "bicycle 'Meijaard2007': deviation of 'cc': no such parameter"),
        ({"c": -0.1}, "deviation of c: -0.1"),
        ([0.1], "deviations = .0.1.; give them by symbol"),
    ],
)
def test_impossible_deviations_of_a_set_are_refused(given, message):
    with pytest.raises(ValueError, match=message):
        replace(BENCHMARK, deviations=given)


def test_yaml_files(tmp_path):
    path = tmp_path / "mine.yml"
    body = lines(v=3.0).replace(" = ", ": ").replace("\n", "\n  ")
    path.write_text(f"parameterization: benchmark\nvalues:\n  {body}\n")
    assert replace(Parameters.from_file(path), name="Meijaard2007") == BENCHMARK  # the speed v is not part of it


def test_files_of_other_editors_and_programs(tmp_path):
    marked, upper, powers = tmp_path / "marked.txt", tmp_path / "UPPER.TXT", tmp_path / "powers.yml"
    marked.write_text(lines(), encoding="utf-8-sig")  # a mark at the beginning
    upper.write_text(lines("mH") + "\nmH = 3.5,4.5", newline="\r\n")
    powers.write_text("values:\n  " + lines("IHzz").replace(" = ", ": ").replace("\n", "\n  ") + "\n  IHzz: 7e-3\n")
    assert Parameters.from_file(marked).values() == BENCHMARK.values()
    assert parameters.named(str(upper)).values() == BENCHMARK.values()
    assert Parameters.from_file(powers).IHzz == 7e-3  # which YAML takes for a text


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.txt", lines("rF"), "'.*a.txt': rF missing; a bicycle needs 26 numbers"),
        ("a.txt", "w = 1.02", "'.*a.txt': holds 1 of the 26 numbers of a bicycle; give w c lam g rR mR IRxx"),
        ("a.txt", "# none\n", "'.*a.txt': holds 0 of the 26 numbers of a bicycle; give w c lam"),
        ("a.txt", "", "'.*a.txt' is empty; give a parameter file"),
        ("a.txt", lines(rf=0.3), "rf unknown"),
        ("a.txt", lines() + "\nw = 1", "line 27: w is given twice"),
        ("a.txt", lines(w="wide"), "line 1: w = ''wide'' is not a number"),
        ("a.txt", "w 1.0", "line 1: 'w 1.0' is not of the form 'symbol = value'"),
        ("a.txt", lines(rR=0.0), "rR: 0.0 is not positive"),
        ("a.txt", lines("w") + "\nw = 1,02", "line 26: w = '1,02': write a decimal point"),
        ("a.txt", lines("w") + "\nw = 1,02 +/- 0,01", "write a decimal point"),
        ("a.txt", lines("w") + "\nw = 1.02 +/- -0.1", "deviation is not a finite number >= 0"),
        ("a.txt", lines("w") + "\nw = 1.02 +/- nan", "deviation is not a finite number >= 0"),
        ("a.csv", lines(), "end in .txt, .yml or .yaml"),
        ("a.yml", "parameterization: principal\nvalues: {}", "parameterization: benchmark"),
        ("a.yml", "values: {w: true}", "w = True is not a number"),
        ("a.yml", "a: &a [1]\nb: *a", "references"),
        ("a.yml", "a: [", "not valid YAML"),
        ("a.yml", "values: {w: 1.0, c: 0.1, w: 1.1}", "w is given twice"),
        ("a.yml", "values: {lam: pi/10}", "lam = 'pi/10' is not a number"),
    ],
)
def test_faulty_files_are_refused_with_their_place(tmp_path, name, text, message):
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(ValueError, match=message):
        Parameters.from_file(path)


# --- the model against published figures ------------------------------------------------------------------------------


def test_freedoms():
    system = whipple(BENCHMARK, speed=4.0, lean=0.2, steer=-0.3)
    found = system.check()
    assert (len(system.bodies), found.coordinates, found.velocities) == (4, 28, 24)
    assert (found.configuration_freedom, found.velocity_freedom) == (7, 3)
    free = System(system.bodies, system.joints[:3])
    assert free.check().mobility == 9


def test_static_wheel_loads():
    system, expected = whipple(BENCHMARK), library()["static_wheel_loads"]
    # at rest and held upright only for an instant: at lean zero it does not begin to fall
    found = accelerations(system)
    for joint, key in (("rear contact", "rear_N"), ("front contact", "front_N")):
        assert found.reaction(joint).force[0] == pytest.approx([0, 0, expected[key]], abs=1e-10)  # 1e-13 of 900 N


def angular(found, system):
    """(yaw, lean, pitch, steer, rear, front) accelerations [rad/s^2], z up, y left, from those of the bodies."""
    z, R = np.array([0, 0, 1.0]), found.rotation("frame")[0]
    y = R[:, 1]
    x = np.cross(y, z) / np.linalg.norm(np.cross(y, z))
    E = np.array([z, x, y]).T
    w, alpha = found.omega("frame")[0], found.alpha("frame")[0]
    yaw, lean, _ = np.linalg.solve(E, w)
    pitch = np.linalg.solve(E, w)[2]
    E_dot = np.array([0 * z, yaw * np.cross(z, x), np.cross(w, y)]).T  # the axes of the rates turn
    rates = np.linalg.solve(E, alpha - E_dot @ [yaw, lean, pitch])
    hinges = []
    for name in ("steer", "rear hub", "front hub"):
        joint = system.part(name, "joints")
        axis = found.rotation(joint.a)[0] @ joint.a.local_axis(joint.axis)
        hinges.append((found.alpha(joint.b)[0] - found.alpha(joint.a)[0]) @ axis)
    return np.array([*rates, *hinges])


def test_basu_mandal_table_1():
    """All nine accelerations of table 1 of Basu-Mandal, Chatterjee and Papadopoulos (2007)."""
    table = library()["basu_mandal_2007_table1"]
    q, qdot, ours = table["q"], table["qdot"], table["in_our_axes"]
    p = BENCHMARK
    system = whipple(
        p, p.rR * qdot["beta_r"], ours["lean_phi"], ours["steer_delta"], ours["lean_rate"], ours["steer_rate"]
    )
    found = accelerations(system)
    v = found.velocity("rear wheel")[0] * [-1, -1, 1]  # theirs: x backward, y right, z up
    assert v == pytest.approx([qdot["x"], qdot["y"], qdot["z"]], abs=1e-12)  # printed with 13 digits
    assert found.position("rear wheel")[0, 2] == pytest.approx(q["z"], abs=1e-12)
    assert found.rate("front hub")[0] == pytest.approx(qdot["beta_f"], abs=1e-11)
    expected = {key: float(x) for key, x in table["computed_qddot_18digits"].items()}
    place = found.acceleration("rear wheel")[0] * [-1, -1, 1]
    (limit,) = limits("validation.md", "nine accelerations")
    assert place == pytest.approx([expected[key] for key in "xyz"], abs=limit)
    # theirs: yaw to the left, psi = pi/2 - lean, pitch as here, steer to the left, wheels as here
    signs = [1, -1, 1, -1, 1, 1]
    angles = [expected[key] for key in ("theta", "psi", "phi", "psi_f", "beta_r", "beta_f")]
    # the state is printed with 13 digits, and the accelerations are up to 8
    assert angular(found, system) * signs == pytest.approx(angles, abs=limit)
    forces = table["computed_contact_forces_on_bike_xyz"]
    for joint, key in (("rear contact", "rear"), ("front contact", "front")):
        assert found.reaction(joint).force[0] * [1, -1, -1] == pytest.approx(forces[key], abs=1e-9)  # of 400 N


# --- the model against a second formulation ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    "motion",
    [(3.0, 0.3, -0.4, 0.5, -0.7), (-2.0, -0.5, 0.9, 1.1, 0.4), (4.6, 0.2, 2.9, -0.6, 0.8), (1.5, -0.9, -0.2, 0.7, 0.3)],
    ids=["forward", "backward", "reversed front end", "far over"],
)
@pytest.mark.parametrize("p", [BENCHMARK, ROUND], ids=lambda p: p.name)
def test_accelerations_in_generic_states(p, motion):
    speed, lean, steer, lean_rate, steer_rate = motion
    system = whipple(p, *motion)
    found = angular(accelerations(system), system)
    pose = system.state().q.reshape(4, 7)[1, 3:]
    pitch = np.arcsin(-matrix(pose)[2, 0] / np.cos(lean))  # R = Rx(lean) Ry(pitch), y left
    c, c_dot = whipple_lagrange.state(p, lean, steer, np.array([lean_rate, steer_rate, speed]), -pitch)
    assert c[4] == pytest.approx(-pitch, abs=1e-12)
    expected = whipple_lagrange.accelerations(p, c, c_dot)
    signs = [-1, 1, -1, 1, -1, -1]  # y right, z down: yaw, pitch and wheels turn the other way
    # differences of order eight, see STEP there; times the condition of a bicycle that is far over
    assert found * signs == pytest.approx(expected[2:], abs=1e-9 * np.abs(expected).max())


def test_linear_equations_with_round_tyres_and_unequal_wheels():
    (limit,) = limits("validation.md", "bicycle with round tyres")
    for speed in (-3.0, 4.6):
        expected = bicycle_matrix(ROUND, speed)
        found = general.linearization(whipple, ROUND, speed).A
        assert found == pytest.approx(expected, abs=limit * np.abs(expected).max())  # differences twice over
    sharp = general.linearization(whipple, replace(ROUND, tR=0.0, tF=0.0), 4.6).A
    assert np.abs(sharp - found).max() > 0.1  # the crown matters
    with pytest.raises(ValueError, match="knife-edge wheels, here tR = 0.05"):
        canonical(ROUND)


@pytest.mark.parametrize("name", parameters.names())
def test_all_published_sets_agree_with_the_closed_form(name):
    p = named(name, unphysical=True)
    expected, found = canonical(p), general.linear_equations(whipple, p, 8.0, check=False)
    (limit,) = limits("validation.md", "47 published bicycles")
    for speed in (0.0, 3.0, 8.0):
        A = expected.A(speed)
        assert found.A(speed) == pytest.approx(A, abs=limit * np.abs(A).max())  # rounding times the condition of M


@pytest.mark.parametrize("name", parameters.names())
def test_all_published_sets_ride(name):
    run = simulate(whipple(named(name, unphysical=True), 4.0, lean=0.1, steer=-0.05, lean_rate=0.2), 0.5)
    assert run.certificate.passed and run.t[-1] == 0.5


def test_two_mass_skate():
    """Point masses on massless wheels: singular mass matrices, and stable from 2.84 m/s."""
    p = replace(named("Tms"), lam=np.pi / 36)
    found, expected = general.linearization(whipple, p, 4.0), canonical(p)
    rounding = np.finfo(float).eps * np.linalg.cond(expected.M) * np.abs(found.A).max()
    assert found.A == pytest.approx(expected.A(4.0), abs=rounding)
    assert found.A == pytest.approx(bicycle_matrix(p, 4.0), abs=1e-9)
    assert np.all(found.eigenvalues.real < 0.0)
    assert np.any(general.linearization(whipple, p, 2.8).eigenvalues.real > 0.0)
    large = replace(p, rR=0.3, rF=0.2)  # the size of the wheels does not matter
    assert general.linearization(whipple, large, 4.0).A == pytest.approx(found.A, abs=rounding)


# --- symmetries -------------------------------------------------------------------------------------------------------

MOTION = {"speed": 3.7, "lean": 0.21, "steer": -0.34, "lean_rate": 0.6, "steer_rate": -0.9}


def test_mirrored_motions_have_mirrored_accelerations():
    left = {key: x if key == "speed" else -x for key, x in MOTION.items()}
    systems = [whipple(ROUND, **motion) for motion in (MOTION, left)]
    right, other = (angular(accelerations(system), system) for system in systems)
    assert other == pytest.approx(right * [-1, -1, 1, -1, 1, 1], abs=1e-10 * np.abs(right).max())


def test_turned_and_shifted_motions():
    system = whipple(ROUND, **MOTION)
    start, turn = system.state(), exponential(np.array([0, 0, 2.3]))
    R, shift = matrix(turn), np.array([30.0, -7.0, 0.0])
    q, v = start.q.reshape(4, 7).copy(), start.v.reshape(4, 6)
    q[:, :3] = q[:, :3] @ R.T + shift
    q[:, 3:] = [multiply(turn, e) for e in q[:, 3:]]
    moved = State(0.0, q.ravel(), np.hstack([v[:, :3] @ R.T, v[:, 3:] @ R.T]).ravel(), coordinates=start.coordinates)
    here, there = accelerations(system), accelerations(system, moved)
    size = np.abs(here.arrays["acceleration"]).max()
    for body in system.bodies:
        for quantity in ("acceleration", "alpha"):
            expected = getattr(here, quantity)(body)[0] @ R.T
            assert getattr(there, quantity)(body)[0] == pytest.approx(expected, abs=1e-10 * size)


@pytest.mark.parametrize("p", [BENCHMARK, ROUND], ids=lambda p: p.name)
def test_rescaled_bicycles(p):
    """Mass k and length l: eigenvalues go as 1/sqrt(l) at speeds that go as sqrt(l)."""
    k, l, speed = 3.7, 2.3, 5.0
    values = p.values()
    lengths = [key for key in values if key[0] in "wcrxzt"]
    for key in values:
        values[key] *= l if key in lengths else k * l**2 if key[0] == "I" else k if key[0] == "m" else 1.0
    one = general.linearization(whipple, p, speed).eigenvalues
    other = general.linearization(whipple, Parameters(**values), speed * np.sqrt(l)).eigenvalues
    assert np.sort_complex(other * np.sqrt(l)) == pytest.approx(np.sort_complex(one), abs=1e-10)


def test_backward_the_spectrum_is_negated():
    forth, back = (general.linearization(whipple, ROUND, v).eigenvalues for v in (5.3, -5.3))
    assert np.sort_complex(-back) == pytest.approx(np.sort_complex(forth), abs=1e-10)


# --- poses and starts -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("lean", "steer"), [(0.4, 0.3), (0.0, np.pi), (-0.7, 2.5), (0.2, -3.0), (1.2, -0.4)])
def test_wheels_stand_on_the_ground_in_every_pose(lean, steer):
    system = whipple(ROUND, 2.0, lean, steer, 0.3, -0.2)
    found = accelerations(system)  # refuses a state that does not meet the joints
    assert max(found.drift().position[0], found.drift().velocity[0]) < 1e-13
    assert found.angle("steer")[0] == pytest.approx(steer, abs=1e-14) and found.rate("steer")[0] == pytest.approx(-0.2)
    assert ROUND.rR * found.rate("rear hub")[0] == pytest.approx(2.0)
    assert np.arcsin(found.rotation("frame")[0][2, 1]) == pytest.approx(lean, abs=1e-14)


def test_the_start_stays_with_variants_and_files(tmp_path):
    system = whipple(BENCHMARK, **MOTION)
    same = replace(system, forces=())
    assert isinstance(same, Bicycle) and np.array_equal(same.state().q, system.state().q)
    run = simulate(system, 0.2)
    assert run.angle("steer")[0] == pytest.approx(MOTION["steer"]) and run.certificate.passed
    upright = whipple(BENCHMARK, 4.0, lean_rate=0.05)
    read = System.from_file(upright.to_file(tmp_path / "bicycle.toml"))
    assert np.abs(read.state().v - upright.state().v).max() < 1e-15
    assert type(read) is System  # a file holds the reference pose


@pytest.mark.parametrize(
    ("motion", "message"),
    [
        ({"lean": 1.6}, "lean = 1.6 rad: it lies on the ground"),
        ({"lean": np.nan}, "lean: not finite"),
        ({"speed": "fast"}, "speed: expected a number"),
    ],
)
def test_impossible_motions(motion, message):
    with pytest.raises(ValueError, match=f"bicycle 'Meijaard2007': {message}"):
        whipple(BENCHMARK, **motion)


def test_a_name_is_no_parameters():
    for ask in (whipple, rider.gains_of, play.play):
        with pytest.raises(ValueError, match="parameters = 'Browserins'; give a set, e.g. bicycle.named"):
            ask("Browserins", speed=5.0)
    with pytest.raises(ValueError, match="parameters = None; give a set"):
        canonical(None)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: whipple(BENCHMARK, v=5.0), "whipple: no argument 'v'; it takes parameters, speed"),
        (lambda: ride.run(BENCHMARK, 1.0), "run: missing a required .*argument: 'speed'; it takes parameters, t_end"),
        (lambda: replace(BENCHMARK, mb=3.0), "Parameters: no argument 'mb', did you mean 'mB'"),
    ],
)
def test_wrong_calls_are_explained(call, message):
    with pytest.raises(ArgumentError, match=message):
        call()


def test_no_pose_and_no_motion():
    high = replace(BENCHMARK, rF=3.0, c=2.0, name="high")  # its fork does not reach the ground when turned aside
    with pytest.raises(ValueError, match="bicycle 'high': at lean 1.3 rad and steer .* cannot stand on the ground"):
        whipple(high, 0.0, 1.3, 1.5)


def test_a_front_wheel_across_the_way_is_named():
    def rate(steer):
        return 1.0 / kinematics.rolling(BENCHMARK, kinematics.pose_of(BENCHMARK, 0.0, steer), 1.0, 0.0, 0.0)[0][1, 5]

    across = brentq(rate, 1.55, 1.65, xtol=1e-15)  # there the yaw rate passes infinity
    with pytest.raises(ValueError, match="no velocities let both wheels roll .* the front wheel points sideways"):
        whipple(BENCHMARK, 1.0, 0.0, across)
    assert np.abs(whipple(BENCHMARK, 0.0, 0.0, across).state().v).max() < 1e-12  # at rest it may stand so
