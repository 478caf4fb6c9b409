"""Files: what is read back is what was written, to the last bit; what is not a file of ours is refused and not run."""

import csv
import json
import pickle
from pathlib import Path

import numpy as np
import pytest
import xarray
from helpers.double_pendulum import LOWER_ARM, UPPER_ARM, WHEEL, pendulum

import mbsd3d
from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Gear,
    PositionDriver,
    Ramp,
    Revolute,
    RollingDisc,
    System,
    Table,
    load,
    measures,
    rotation,
    simulate,
)
from mbsd3d.extend import compile_system, write_atomically
from mbsd3d.files.description import describe, read_system
from mbsd3d.files.schema import types
from mbsd3d.results.columns import QUANTITIES
from mbsd3d.shapes import Solid


@pytest.fixture(scope="module")
def solution():
    """0.2 s of the pendulum."""
    return simulate(pendulum(), 0.2)


@pytest.fixture
def stored(solution, tmp_path) -> Path:
    """The pendulum in a file."""
    return solution.save(tmp_path / "run")


def same_bits(first, second) -> bool:
    """Equal shapes, types and bytes."""
    first, second = np.asarray(first), np.asarray(second)
    return first.shape == second.shape and first.dtype == second.dtype and first.tobytes() == second.tobytes()


def same_model(first: System, second: System) -> bool:
    """Equal compiled arrays."""
    models = compile_system(first).model, compile_system(second).model
    return all(same_bits(a, b) for a, b in zip(*models, strict=True))


def change_text(path: Path, change) -> None:
    """Write the file again with its text changed."""
    with np.load(path) as npz:
        arrays = dict(npz)
    document = json.loads(bytes(arrays.pop("json")))
    change(document)
    np.savez(path, json=np.frombuffer(json.dumps(document).encode(), np.uint8), **arrays)


def test_arrays_and_results_come_back_to_the_last_bit(solution, stored):
    copy = load(stored)
    assert copy.arrays.keys() == solution.arrays.keys()
    assert all(same_bits(copy.arrays[name], solution.arrays[name]) for name in copy.arrays)
    assert same_model(copy.system, solution.system)
    for joint in solution.system.joints:
        name = solution.system.name(joint)
        old, new = vars(solution.reaction(joint)), vars(copy.reaction(name))
        assert all(same_bits(old[key], new[key]) for key in old)
    assert copy.record == solution.record
    assert str(copy.certificate) == str(solution.certificate)
    assert same_bits(copy.effort("motor"), solution.effort("motor"))
    assert same_bits(copy.final.q, solution.final.q)


def test_a_run_that_a_measure_stopped_comes_back(tmp_path):
    """The measure has a coordinate of its own, which is none of the system's."""
    system = pendulum()
    turn = measures.heading(system.part(UPPER_ARM))
    run = simulate(system, 0.05, stop_when=turn > 10.0)
    copy = load(run.save(tmp_path / "stopped"))
    assert same_bits(copy.arrays["state"], run.arrays["state"])
    assert same_bits(copy.final.coordinates, run.arrays["coordinate"][-1, : len(copy.final.coordinates)])
    assert run.arrays["coordinate"].shape[1] == copy.arrays["coordinate"].shape[1] + 1


def test_a_loaded_solution_goes_on(solution, stored):
    assert same_bits(load(stored).at(0.13).q, solution.at(0.13).q)
    assert load(stored).plot("energy").axes


def test_a_start_before_the_first_sample_is_kept(tmp_path):
    run = simulate(pendulum(), 0.05, output=[0.05])
    copy = load(path := run.save(tmp_path / "late"))
    assert same_bits(copy.at(0.03).q, run.at(0.03).q) and str(copy.certificate) == str(run.certificate)
    change_text(path, lambda document: document.pop("start"))  # as older files: nothing is known before the sample
    assert load(path).start.t == 0.05 and load(path).certificate.passed


def test_method_switches_and_estimate_are_kept(tmp_path):
    from dataclasses import replace

    run = simulate(pendulum(), 0.02, method=mbsd3d.RK4(0.01), gyroscopic=False, stabilisation="none")
    run = run.with_certificate(replace(run.certificate, error=1.25e-7, order=3.9, doubling=0.7))
    copy = load(run.save(tmp_path / "run"))
    assert copy.record.method == mbsd3d.RK4(0.01)
    assert copy.record.switches == run.record.switches and copy.compiled.model.gyroscopic == 0.0
    assert (copy.certificate.error, copy.certificate.order, copy.certificate.doubling) == (1.25e-7, 3.9, 0.7)


def test_suffix_is_added_and_an_old_file_replaced(solution, tmp_path):
    (tmp_path / "run.v2.npz").write_text("old")
    path = solution.save(tmp_path / "run.v2")
    assert path.name == "run.v2.npz" and load(tmp_path / "run.v2").t.size == solution.t.size
    assert [file.name for file in tmp_path.iterdir()] == ["run.v2.npz"]


def test_a_name_may_be_as_long_as_the_system_lets_it(solution, tmp_path):
    assert solution.save(tmp_path / (251 * "n")).name == 251 * "n" + ".npz"
    with pytest.raises(ValueError, match="a name of 256 bytes; give one of at most 255"):
        solution.save(tmp_path / (252 * "n"))


@pytest.mark.parametrize("folder", ["missing", "file"])
def test_unwritable_folder_is_named(solution, tmp_path, folder):
    (tmp_path / "file").write_text("")
    with pytest.raises(ValueError, match="run.npz' cannot be written: .*folder that exists"):
        solution.save(tmp_path / folder / "run")


def test_a_failed_write_leaves_the_old_file(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("old")
    with pytest.raises(TypeError):
        write_atomically(path, "no bytes")
    assert path.read_text() == "old" and len(list(tmp_path.iterdir())) == 1


class Payload:
    """Leaves a trace when it is unpickled."""

    def __init__(self, trace: Path) -> None:
        self.trace = trace

    def __reduce__(self):
        return Path.touch, (self.trace,)


def test_pickles_are_not_opened(stored, tmp_path):
    trace = tmp_path / "trace"
    with np.load(stored) as npz:
        arrays = dict(npz)
    arrays["t"] = np.array([Payload(trace)], dtype=object)
    np.savez(stored, **arrays)
    with pytest.raises(ValueError, match="run.npz' cannot be read.*run the simulation again"):
        load(stored)
    stored.write_bytes(pickle.dumps(Payload(trace)))
    with pytest.raises(ValueError, match="no complete .npz file"):
        load(stored)
    assert not trace.exists()


def test_truncated_and_damaged_files_are_refused(stored):
    whole = stored.read_bytes()
    damaged = bytearray(whole)
    damaged[len(whole) // 3] ^= 0xFF
    for content in (b"", whole[:-1], whole[: len(whole) // 2], whole[:100], bytes(damaged)):
        stored.write_bytes(content)
        with pytest.raises(ValueError, match="run.npz' cannot be read"):
            load(stored)


def test_missing_file_and_other_npz_are_refused(tmp_path):
    with pytest.raises(ValueError, match="nothing.npz' does not exist"):
        load(tmp_path / "nothing")
    np.savez(tmp_path / "other.npz", t=np.zeros(3))
    with pytest.raises(ValueError, match="other.npz' cannot be read.*'json'"):
        load(tmp_path / "other.npz")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d.update(version=99), r"version 99 of the format - at `\$.version`, this mbsd3d reads 2"),
        (lambda d: d.update(format="x"), "is no mbsd3d solution"),
        (lambda d: d["system"]["joints"][0].update(type="os.system"), "type 'os.system' is unknown"),
        (lambda d: d["system"]["bodies"][0].update(mass=-1.0), "mass: -1.0 is below 0"),
        (lambda d: d["system"]["joints"].pop(), "array 'lam' has shape|array 'state' has shape"),
        (lambda d: d.update(record=d["final"]), "type 'State' is unknown - at `\\$.record`; give one of Record"),
        (lambda d: d["final"].update(q=[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], v=[0.0] * 6), "final state does not fit"),
        (lambda d: d["final"].update(coordinates=[0.1] * 9), "final state does not fit"),
    ],
)
def test_changed_text_is_refused(stored, change, message):
    change_text(stored, change)
    with pytest.raises(ValueError, match=message):
        load(stored)


def test_arrays_that_do_not_fit_the_system_are_refused(stored):
    with np.load(stored) as npz:
        arrays = dict(npz)
    for name, array in (("lam", arrays["lam"][:, 1:]), ("state", arrays["state"].astype(np.float32)), ("v", None)):
        changed = arrays | {name: array}
        np.savez(stored, **{key: value for key, value in changed.items() if value is not None})
        with pytest.raises(ValueError, match=f"'{name}'"):
            load(stored)


def test_every_public_part_can_be_written():
    homes = ("parts", "joints", "couplings", "contacts", "drivers", "forces", "signals", "integrators")
    public = [getattr(mbsd3d, name) for name in mbsd3d.__all__]
    parts = [kind for kind in public if isinstance(kind, type) and kind.__module__.split(".")[1] in homes]
    abstract = {"Joint", "Driver", "Signal"}
    assert {kind.__name__ for kind in parts} - abstract <= types().keys()
    assert not abstract & types().keys()


def couplings() -> System:
    """References to joints, also to later ones, a table, and fields that hold pairs, None and the ground."""
    rng = np.random.default_rng(3)
    first, second, hand, disc = (
        Body(name, 1.0, (0.01, 0.012, 0.02), position=rng.normal(size=3), orientation=rotation(rng.normal(size=3), 1.1))
        for name in ("first", "second", "hand", "disc")
    )
    hinges = [Revolute(GROUND, body, at=body.position, axis=rng.normal(size=3)) for body in (first, second)]
    grip = PositionDriver(hand, at=hand.position, signal=(0.5, None, -Table([0, 1, 2, 4], [0, 1, 8, 64])), name="grip")
    plane = ((0.1, 0.2, 0.3), (0.2, -0.1, 3.0))
    rolling = RollingDisc(GROUND, disc, axis=(0.1, 2.0, 0.3), radius=0.3, plane=plane)
    return System(
        [first, second, hand, disc], [Gear(*hinges, ratio=-1 / 3), *hinges, AngleDriver(hinges[0], 0.1), grip, rolling]
    )


@pytest.mark.parametrize("build", [pendulum, couplings])
def test_description_survives_json_to_the_last_bit(build):
    system = build()
    data = json.loads(json.dumps(describe(system), allow_nan=False))
    copy = read_system(data)[0]
    assert describe(copy) == data and same_model(copy, system)


def test_references_stay_references():
    copy = read_system(describe(couplings()))[0]
    gear, first, second, motor, grip, rolling = copy.joints
    assert (gear.hinge_a, gear.hinge_b, motor.hinge) == (first, second, first)
    assert grip.body is copy.bodies[2] and grip.signal[1] is None and rolling.a is GROUND


def test_normalising_twice_changes_nothing():
    rng = np.random.default_rng(5)
    for _ in range(500):  # about one in three lengths of a normalised vector differs from 1 in its last bit
        body = Body("b", 1.0, (1, 1, 1), orientation=rotation(rng.normal(size=3), rng.normal()))
        hinge = Revolute(GROUND, body, at=(0, 0, 0), axis=rng.normal(size=3))
        again = Body("b", 1.0, (1, 1, 1), orientation=body.orientation)
        assert same_bits(again.orientation, body.orientation)
        assert same_bits(Revolute(GROUND, body, at=(0, 0, 0), axis=hinge.axis).axis, hinge.axis)


def test_a_class_or_function_of_the_user_is_refused():
    class Own(Revolute):
        pass

    class OwnShape(Solid):
        def check(self, what):
            pass

    body = Body("door", 1.0, (1, 1, 1), shape=OwnShape())
    with pytest.raises(ValueError, match="Body 'door': shape: an OwnShape cannot be written to a file"):
        describe(System([body]))
    body = Body("door", 1.0, (1, 1, 1))
    with pytest.raises(ValueError, match="Own 'Own 1'.*no classes of your own"):
        describe(System([body], [Own(GROUND, body, at=(0, 0, 0), axis=(0, 0, 1))]))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d.update(version=1), "version 1"),
        (lambda d: d.update(joints={}), r"Expected `array`, got `object` - at `\$.joints`"),
        (lambda d: d.update(colour=1), "unknown field `colour` - at `"),
        (lambda d: d["joints"].__setitem__(0, 7), r"Expected `object`, got `int` - at `\$.joints\[0\]`"),
        (lambda d: d["joints"][5].update(a="nobody"), r"there is no body 'nobody' - at `\$.joints\[5\].a`"),
        (lambda d: d["joints"][5].update(a=True), r"Expected `str`, got `bool` - at `\$.joints\[5\].a`"),
        (lambda d: d["joints"][5].update(plane=[{"eval": "1"}]), r"not understood - at `\$.joints\[5\].plane\[0\]`"),
        (
            lambda d: d["joints"][0].update(colour=1),
            r"unknown field `colour` - at `\$.joints\[0\]`; give name, hinge_a",
        ),
        (lambda d: d["joints"][0].pop("ratio"), r"missing required field `ratio` - at `\$.joints\[0\]`"),
        (lambda d: d["joints"][0].update(hinge_a="Gear 1"), "joint 'Gear 1' refers to itself"),
        (lambda d: d["joints"][4].update(at=["x", 0, 0]), r"Expected `float`, got `str` - at `\$.joints\[4\].at\[0\]`"),
        (lambda d: d["joints"][4]["signal"].__setitem__(0, {"type": "Sum", "signals": [5]}), r"signals\[0\]`"),
        (
            lambda d: d["joints"][4]["signal"].__setitem__(0, {"type": "Sum", "signals": []}),
            r"joints\[4\].signal\[0\]`",
        ),
        (lambda d: d["bodies"][0].update(inertia=[1.0, 1.0, 5.0]), r"principal moments.* - at `\$.bodies\[0\]`"),
        (lambda d: d.update(gravity=[0.0, 0.0, float("nan")]), r"nan is not finite - at `\$.gravity\[2\]`"),
        (lambda d: d["bodies"].append(d["bodies"][0]), r"two bodies are named 'first' - at `\$.bodies\[4\].name`"),
        (
            lambda d: d["joints"][4].update(name="Revolute 1"),
            r"two joints are named 'Revolute 1' - at `\$.joints\[4\]`",
        ),
    ],
)
def test_bad_descriptions_are_refused(change, message):
    data = describe(couplings())
    change(data)
    with pytest.raises(ValueError, match=message):
        read_system(data)[0]


def test_csv_holds_the_exact_numbers(solution, tmp_path):
    path = solution.to_csv(tmp_path / "table")
    with path.open(newline="") as handle:
        header, *rows = csv.reader(handle)
    table = dict(zip(header, np.array(rows, float).T, strict=True))
    assert path.name == "table.csv" and len(table) == len(header)
    assert same_bits(table["time [s]"], solution.t)
    assert same_bits(table["lower arm.position.x [m]"], solution.position(LOWER_ARM)[:, 0])
    assert same_bits(table["wheel.omega_body.z [rad/s]"], solution.omega_body(WHEEL)[:, 2])
    assert same_bits(table["elbow.reaction_moment.y [N m]"], solution.reaction("elbow").moment[:, 1])
    assert same_bits(table["axle.angle [rad]"], solution.angle("axle"))
    assert same_bits(table["motor.effort [N m]"], solution.effort("motor"))
    assert same_bits(table["energy.kinetic [J]"], solution.energy().kinetic)
    assert same_bits(table["angular_momentum.z [kg m^2/s]"], solution.momentum().angular[:, 2])
    assert "elbow.angle [rad]" not in table and set(table["elbow.reaction_unique [1]"]) == {1.0}


def test_dataset_has_names_units_and_survives_netcdf(solution, tmp_path):
    data = solution.to_xarray()
    assert np.array_equal(data.com.sel(body=LOWER_ARM), solution.com(LOWER_ARM))
    assert np.array_equal(data.reaction_force.sel(joint="elbow"), solution.reaction("elbow").force)
    assert np.array_equal(data.effort.sel(driver="motor"), solution.effort("motor"))
    assert np.array_equal(data.rate.sel(joint="axle"), solution.rate("axle"))
    assert np.isnan(data.angle.sel(joint="elbow")).all()
    assert all({"units", "frame", "description"} <= variable.attrs.keys() for variable in data.data_vars.values())
    assert data.orientation.dims == ("time", "body", "quaternion") and data.velocity.attrs["units"] == "m/s"
    assert data.attrs["certificate_passed"] == 1 and data.attrs["method"].startswith("DOP853")
    data.to_netcdf(tmp_path / "run.nc", engine="h5netcdf")
    with xarray.open_dataset(tmp_path / "run.nc", engine="h5netcdf") as copy:
        assert copy.identical(data)


def test_a_free_body_has_no_joint_variables(tmp_path):
    run = simulate(System([Body("stone", 1.0, (1, 2, 2.5), omega=(1, 2, 3))]), 0.01)
    data = run.to_xarray()
    data.to_netcdf(tmp_path / "run.nc", engine="h5netcdf")
    assert "reaction_force" not in data and "joint" not in data.dims
    assert same_bits(load(run.save(tmp_path / "run")).arrays["v"], run.arrays["v"])


def test_units_of_rates_are_those_of_what_changes():
    rates = {"velocity": "position", "rate": "angle", "slide_rate": "slide", "velocity_drift": "position_drift"}
    for rate, of in rates.items():
        assert QUANTITIES[rate].unit == " or ".join(f"{unit}/s" for unit in QUANTITIES[of].unit.split(" or "))
    assert QUANTITIES["acceleration"].unit == "m/s^2" and QUANTITIES["alpha"].unit == "rad/s^2"


def test_efforts_of_a_driver_with_several_rows_are_named_by_axis():
    hand = Body("hand", 1.0, (0.01, 0.01, 0.01), position=(1, 2, 3))
    grip = PositionDriver(hand, at=(1, 2, 3), signal=(0.0, None, Ramp(0.1)), name="grip")
    data = simulate(System([hand], [grip]), 0.01, output=3).to_xarray()
    assert data.driver.values.tolist() == ["grip.x", "grip.z"] and data.driver_unit.values.tolist() == ["N", "N"]
    assert np.allclose(data.effort.sel(driver="grip.z"), 9.81)  # carries the weight
