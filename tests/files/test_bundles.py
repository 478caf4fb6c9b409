"""Bundles: a run made again from its file is the same to the bit, and what was changed is found."""

import io
import json
import zipfile
from dataclasses import replace
from hashlib import sha256

import numpy as np
import pytest
from click.testing import CliRunner
from helpers.double_pendulum import pendulum

from mbsd3d import (
    GROUND,
    RK4,
    Body,
    CustomForce,
    EndStop,
    GeneralizedAlpha,
    RadauIIA,
    Revolute,
    System,
    load,
    measures,
    simulate,
    verify,
)
from mbsd3d.errors import InputError
from mbsd3d.extend import main
from validation import cross_check


@pytest.fixture(scope="module")
def run():
    return simulate(pendulum(), 0.5, output=11)


@pytest.fixture
def bundle(run, tmp_path):
    return run.bundle(tmp_path / "run")


def hinged(**stop):
    """A flap that falls on a rigid stop and bounces: a run in pieces."""
    flap = Body("flap", 1.3, (0.1, 0.2, 0.15), com=(0.3, 0.1, 0.0), position=(0.1, 0.0, 0.4))
    hinge = Revolute(GROUND, flap, at=(0.1, 0.0, 0.4), axis=(0.2, 1.0, 0.1), name="hinge")
    return System([flap], [hinge], [EndStop(hinge, upper=0.5, **stop)])


def cases():
    yield "steps", lambda: simulate(pendulum(), 0.4)
    yield "fixed steps", lambda: simulate(pendulum(), 0.4, method=RK4(1e-3), output=5)
    yield "implicit", lambda: simulate(pendulum(), 0.4, method=RadauIIA(), rtol=1e-7)
    yield "alpha", lambda: simulate(pendulum(), 0.4, method=GeneralizedAlpha(1e-3), output=5)
    yield "ablation", lambda: simulate(pendulum(), 0.4, gyroscopic=False)
    yield "bounces", lambda: simulate(hinged(restitution=0.6), 1.0, output=21)
    start = pendulum()
    fallen = measures.position(start.bodies[0], at=(0.1, 0.2, 0.3), axis="z") < -10.0
    yield "condition", lambda: simulate(start, 0.4, stop_when=fallen, output=5)


@pytest.mark.parametrize("made", [made for _, made in cases()], ids=[name for name, _ in cases()])
def test_a_run_made_again_is_the_same_to_the_bit(made, tmp_path):
    found = verify(made().bundle(tmp_path / "run"))
    assert found.passed and found.identical and found.difference <= found.limit, str(found)


def test_a_bundle_holds_what_it_says_and_the_same_run_gives_the_same_bytes(run, bundle, tmp_path):
    note = tmp_path / "findings.json"
    note.write_text('{"mujoco": 1e-9}')
    other = run.bundle(tmp_path / "other", attach=[note])
    with zipfile.ZipFile(bundle) as one, zipfile.ZipFile(other) as two:
        assert {*two.namelist()} - {*one.namelist()} == {"attached/findings.json"}
        assert two.read("solution.npz") == one.read("solution.npz")
        assert "global error" in one.read("certificate.txt").decode()
        model = json.loads(one.read("model.json"))
    assert [body["name"] for body in model["bodies"]] == [body.name for body in run.system.bodies]
    assert verify(other).passed


def rewritten(bundle, entries, target):
    """A bundle with some entries changed, and its proof by whom one lets."""
    with zipfile.ZipFile(bundle) as archive:
        known = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(target, "w") as archive:
        for name, content in {**known, **entries}.items():
            archive.writestr(name, content)
    return target


def test_what_was_changed_is_named(bundle, tmp_path):
    changed = rewritten(bundle, {"certificate.txt": b"all is well"}, tmp_path / "changed.zip")
    found = verify(changed)
    assert not found.passed and "certificate.txt" in str(found)
    called = CliRunner().invoke(main, ["verify", str(changed)])
    assert called.exit_code == 1 and "certificate.txt" in called.stdout
    assert CliRunner().invoke(main, ["verify", str(bundle)]).exit_code == 0


def elsewhere(bundle, target, **proof_changes):
    """The bundle as another processor would have written it, with a proof that fits."""
    with zipfile.ZipFile(bundle) as archive:
        place, proof = json.loads(archive.read("environment.json")), json.loads(archive.read("proof.json"))
    text = json.dumps(place | {"processor": "another one"}).encode()
    proof["digests"]["environment.json"] = sha256(text).hexdigest()
    proof = proof | {"run": "0" * 64} | proof_changes
    return rewritten(bundle, {"environment.json": text, "proof.json": json.dumps(proof)}, target)


def test_elsewhere_the_stated_error_counts(bundle, tmp_path):
    found = verify(elsewhere(bundle, tmp_path / "there.zip"))
    assert found.passed and not found.identical and "processor another one" in str(found)


def foreign(bundle, target, other, *names):
    """The bundle with entries of another one, and a proof that fits."""
    with zipfile.ZipFile(bundle) as one, zipfile.ZipFile(other) as two:
        taken, proof = {name: two.read(name) for name in names}, json.loads(one.read("proof.json"))
    proof["digests"] |= {name: sha256(content).hexdigest() for name, content in taken.items()}
    return rewritten(bundle, taken | {"proof.json": json.dumps(proof)}, target)


def with_array(bundle, target, name, change):
    """The bundle with another array in its solution, and a proof that fits."""
    with zipfile.ZipFile(bundle) as archive:
        arrays = dict(np.load(io.BytesIO(archive.read("solution.npz"))))
        proof = json.loads(archive.read("proof.json"))
    change(arrays[name])
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    proof["digests"]["solution.npz"] = sha256(buffer.getvalue()).hexdigest()
    return rewritten(bundle, {"solution.npz": buffer.getvalue(), "proof.json": json.dumps(proof)}, target)


def test_samples_model_and_certificate_of_another_run_do_not_pass_though_the_digests_fit(bundle, tmp_path):
    heavy = pendulum()
    heavier = System([replace(heavy.bodies[0], mass=9.0)])
    other = simulate(heavier, 0.5, output=11).bundle(tmp_path / "heavier")
    assert not verify(foreign(bundle, tmp_path / "told.zip", other, "certificate.txt")).passed
    with pytest.raises(ValueError, match=r"model.json is not the model of solution.npz"):
        verify(foreign(bundle, tmp_path / "model.zip", other, "model.json"))

    def turn(values):
        values[5, 0] += 1e-6  # of an angle, which the certificate does not look at

    found = verify(with_array(bundle, tmp_path / "turned.zip", "coordinate", turn))
    assert not found.passed and found.difference == pytest.approx(1e-7, rel=1e-6), str(found)

    def later(values):
        values += 1e-7

    assert "it fails" in str(verify(with_array(bundle, tmp_path / "later.zip", "t", later)))


def test_samples_far_from_the_run_made_again_do_not_pass_on_the_same_installation(bundle, tmp_path):
    """The run made again has the bits of the proof, the samples of the bundle have not."""

    def aside(values):
        values[:, :3] += 1e-5 * np.sin(np.arange(len(values)))[:, None] ** 2

    found = verify(with_array(bundle, tmp_path / "aside.zip", "state", aside))
    assert found.identical and not found.passed and found.difference > found.limit and "differs by" in str(found)


def test_another_verdict_or_other_bits_of_the_same_installation_do_not_pass(bundle, tmp_path):
    assert not verify(elsewhere(bundle, tmp_path / "verdict.zip", passed=False)).passed
    with zipfile.ZipFile(bundle) as archive:
        proof = json.loads(archive.read("proof.json")) | {"run": "0" * 64}
    found = verify(rewritten(bundle, {"proof.json": json.dumps(proof)}, tmp_path / "bits.zip"))
    assert not found.passed and "the bits must be the same" in str(found)


def idle(t, bodies, z, parameters, loads, z_dot):
    """A force that does nothing, by a function."""


def test_what_cannot_be_made_again_is_refused(run, tmp_path):
    ball = Body("ball", 1.0, (0.1, 0.1, 0.1))
    pushed = System([ball], forces=[CustomForce(idle, on=(GROUND, ball), name="push")])
    with pytest.raises(ValueError, match="push"):
        simulate(pushed, 0.1).bundle(tmp_path / "run")
    with pytest.raises(ValueError, match="attach '.*none.json' is not a file"):
        run.bundle(tmp_path / "run", attach=[tmp_path / "none.json"])
    for one in ("none.json", tmp_path / "none.json"):
        with pytest.raises(ValueError, match="attach.*give a list of files"):
            run.bundle(tmp_path / "run", attach=one)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("proof.json", change)
        for change in (
            {"passed": 1}, {"passed": None}, {"digests": []}, {"digests": "x"}, {"run": None}, {"version": True},
            {"version": 10**400}, {"format": float("nan")},
        )
    ]
    + [("environment.json", change) for change in (None, [], "x", 7, {"numpy": 3})],
)  # fmt: skip
def test_values_of_a_wrong_kind_are_refused_in_a_sentence(bundle, tmp_path, name, value):
    with zipfile.ZipFile(bundle) as archive:
        own, proof = json.loads(archive.read(name)), json.loads(archive.read("proof.json"))
    text = json.dumps(own | value if isinstance(value, dict) else value).encode()
    if name != "proof.json":
        proof["digests"][name] = sha256(text).hexdigest()
    entries = {"proof.json": json.dumps(proof).encode()} | {name: text}
    with pytest.raises(ValueError, match="cannot be read as a bundle"):
        verify(rewritten(bundle, entries, tmp_path / "bad.zip"))


def test_encrypted_files_are_refused_in_a_sentence(run, bundle, tmp_path):
    for path, read in ((bundle, verify), (run.save(tmp_path / "run.npz"), load)):
        raw = bytearray(path.read_bytes())
        for mark, offset in ((b"PK\x01\x02", 8), (b"PK\x03\x04", 6)):
            at = raw.find(mark)
            while at >= 0:
                raw[at + offset] |= 1
                at = raw.find(mark, at + 4)
        path.write_bytes(raw)
        with pytest.raises(ValueError, match="cannot be read as .*encrypted"):
            read(path)


@pytest.mark.parametrize("damage", ["missing", "text", "truncated", "foreign", "compressed"])
def test_what_is_no_bundle_is_refused_in_a_sentence(bundle, tmp_path, damage):
    path = tmp_path / "bad.zip"
    if damage == "text":
        path.write_text("no zip")
    elif damage == "truncated":
        path.write_bytes(bundle.read_bytes()[:2000])
    elif damage == "foreign":
        rewritten(bundle, {"../evil": b"x"}, path)
    elif damage == "compressed":
        with zipfile.ZipFile(bundle) as old, zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as new:
            for name in old.namelist():
                new.writestr(name, old.read(name))
    with pytest.raises(ValueError, match=r"does not exist|cannot be read as a bundle"):
        verify(path)


def test_a_comparison_with_other_engines_is_kept_and_told(tmp_path):
    system = pendulum()
    seen = cross_check(system, 0.5, engines=["definitions"])
    path = simulate(system, 0.5, output=11).bundle(tmp_path / "run", comparison=seen)
    found = verify(path)
    assert found.passed and found.identical, str(found)
    told = [line for line in found.lines if line.startswith("other engines, as they were then until 0.5 s: ")]
    assert told == [f"other engines, as they were then until 0.5 s: {str(seen).splitlines()[-1]}"]
    with zipfile.ZipFile(path) as archive:
        kept = json.loads(archive.read("comparison.json"))
    assert kept["engines"][0]["findings"] and kept["passed"] and kept["tolerance"] == seen.tolerance
    doubted = verify(simulate(system, 0.5).bundle(tmp_path / "doubt", comparison=replace(seen, interrupted=True)))
    assert doubted.passed and doubted.lines[-1] == "verified, but no other engine confirms it"
    other = simulate(hinged(restitution=0.6), 0.5, output=11)
    with pytest.raises(InputError, match="the comparison is of another model or start; compare the system of this"):
        other.bundle(tmp_path / "other", comparison=seen)
    with pytest.raises(InputError, match="comparison 3; give the result of validation.cross_check"):
        other.bundle(tmp_path / "other", comparison=3)
