"""FMUs by FMPy: valid, equal to a stepper in the process, taken back, with parameters, certificates and errors."""

import json
import sys
import zipfile
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from helpers.forces import EXAMPLES as FORCES
from helpers.models import EXAMPLES, direction, random_body

from mbsd3d import (
    GROUND,
    RK4,
    AngleDriver,
    Body,
    Contact,
    CustomForce,
    Force,
    GeneralizedAlpha,
    Input,
    Prismatic,
    Ramp,
    Revolute,
    Spherical,
    SpringDamper,
    Stepper,
    System,
    Table,
    Torque,
    TorsionSpring,
    measures,
    shapes,
)
from mbsd3d.extend import main

pytest.importorskip("pythonfmu3", reason="the extra fmu is not installed")
fmpy = pytest.importorskip("fmpy", reason="the extra fmu is not installed")

from fmpy.validation import validate_fmu  # noqa: E402
from helpers.fmu_host import FMICallException, half_of_a_pair, hosted, write_controller  # noqa: E402


def stand(stiffness=3.0, pole=0.3):
    """A pole on a cart, with a spring, an input, and names that FMI must quote."""
    cart = Body("cart", 1.0, (0.1, 0.1, 0.1))
    bob = Body("the pole", pole, (0.02, 0.02, 0.001), com=(0, 0.02, 0.5))
    rail = Prismatic(GROUND, cart, at=(0, 0, 0), axis=(1, 0, 0), name="rail")
    pin = Revolute(cart, bob, at=(0, 0, 0), axis=(0, 1, 0), name="pin")
    forces = [Force(cart, (Input("push"), 0, 0)), TorsionSpring(pin, stiffness=stiffness, name="spring")]
    return System([cart, bob], [rail, pin], forces, name="stand")


def written(system, folder, name="model", **given):
    """An FMU of a system in a folder."""
    return system.to_fmu(folder / f"{name}.fmu", **given)


def stepper_of(system, state=None, **given):
    """The same motion in the process, with the angle and the rate of the pin."""
    pin = system.joints[1]
    return Stepper(system, state, measures=[measures.angle(pin), measures.rate(pin)], **given)


def test_what_is_written_is_valid_and_says_its_units(tmp_path):
    path = written(stand(), tmp_path, parameters=["spring.stiffness", "the pole.mass"])
    assert validate_fmu(str(path)) == []
    found = fmpy.read_model_description(str(path))
    assert found.fmiVersion == "3.0" and found.coSimulation.needsExecutionTool
    assert found.coSimulation.canGetAndSetFMUstate and not found.coSimulation.canSerializeFMUstate
    assert "Python with mbsd3d installed" in found.description
    known = {x.name: (x.causality, x.variability, x.unit) for x in found.modelVariables}
    assert known["push"] == ("input", "continuous", "N")
    assert known["pin.angle"] == ("output", "continuous", "rad")
    assert known["rail.slide_rate"] == ("output", "continuous", "m/s")
    assert known["'the pole'.omega[2]"] == ("output", "continuous", "rad/s")
    assert known["'the pole'.mass"][:2] == known["spring.stiffness"][:2] == ("parameter", "fixed")
    assert known["certificate.passed"][0] == known["certificate.worst"][0] == "output"
    base = {x.name: x.baseUnit for x in found.unitDefinitions}
    assert (base["N"].kg, base["N"].m, base["N"].s) == (1, 1, -2) and (base["rad/s"].rad, base["rad/s"].s) == (1, -1)


SWITCHING = ("Switched", "Breaks", "Clutch", "Freewheel", "Ratchet")  # a Stepper refuses them
JOINTS = {cls.__name__: make for cls, make in EXAMPLES.items() if cls.__name__ not in SWITCHING}
# functions, and stops beyond which the reference pose lies
OUT_OF_PLACE = ("CustomForce", "ConeStop", "EndStop", "LinearActuator", "PointStop", "PinPlay")
MODELS = [
    *JOINTS,
    *(name for name in FORCES if not name.startswith(OUT_OF_PLACE)),
]


def example(name):
    """A system in general position that has the part, with a torque by an input, and its start."""
    rng = np.random.default_rng(4)
    bodies = [random_body(rng, letter) for letter in "abcd"]
    if name in JOINTS:
        made, forces = JOINTS[name](rng, *bodies), []
        joints = list(made) if isinstance(made, list | tuple) else [made]
    else:
        joints, force = FORCES[name](rng, *bodies[:2])
        forces = [force]
    used = {id(body) for part in (*joints, *forces) for body in part.bodies()}
    bodies = [body for body in bodies if id(body) in used]
    turned = Torque(bodies[-1], (0.3 * Input("twist"), Input("twist"), 0.1))
    system = System(bodies, joints, [*forces, turned])
    return system, system.assemble()


@pytest.mark.parametrize("name", MODELS[::2])
def test_a_model_in_an_fmu_is_that_of_a_stepper(name, tmp_path):
    """All positions and velocities after steps of 0.1, 0.01 and 0.001 s, with an input that changes at each step."""
    system, start = example(name)
    seen = {f"{b.name}.{k}": measures.position(b, axis=np.eye(3)[k]) for b in system.bodies for k in range(3)}
    seen |= {f"{b.name}.w{k}": measures.omega(b, axis=np.eye(3)[k]) for b in system.bodies for k in range(3)}
    own = Stepper(system, start, measures=list(seen.values()))
    with hosted(written(system, tmp_path, outputs=seen, state=start), tmp_path / "unzipped") as host:
        host.start(twist=0.4)
        t = 0.0
        for length in (0.1, 0.01, 0.001, 0.01, 0.1):
            push = float(np.sin(40.0 * t))
            host.set(twist=push)
            own.set("twist", push)
            host.step(t, length)
            own.advance(t + length)
            t += length
            assert np.abs(np.array(host.get(*seen)) - own.measured).max() < 1e-9
        host.fmu.terminate()
        assert host.passed == own.solution().certificate.passed


@pytest.mark.parametrize("length", [0.1, 0.01, 0.001])
@pytest.mark.parametrize("method", [None, GeneralizedAlpha(dt=0.005), RK4(0.004)], ids=str)
def test_communication_steps(length, method, tmp_path):
    system = stand()
    own = stepper_of(system, system.assemble(angles={system.joints[1]: 0.3}), method=method)
    path = written(system, tmp_path, state=system.assemble(angles={system.joints[1]: 0.3}), method=method)
    with hosted(path, tmp_path / "unzipped") as host:
        host.start(push=1.5)
        own.set("push", 1.5)
        for k in range(round(0.3 / length)):
            host.step(k * length, length)
            own.advance(k * length + length)
        assert np.abs(np.array(host.get("pin.angle", "pin.rate")) - own.measured).max() < 1e-9


def test_a_controller_in_another_fmu_holds_the_pole(tmp_path):
    """Upright cart and pole, P 60, I 40, D 8, held over 10 ms; from equations of the two coordinates at 1e-13."""
    M, m, inertia, arm, g = 1.0, 0.3, 0.006, 0.3, 9.81
    cart = Body("cart", M, (0.1, 0.1, 0.1))
    pole = Body("pole", m, (inertia, inertia, inertia), com=(0, 0, arm))
    rail = Prismatic(GROUND, cart, at=(0, 0, 0), axis=(1, 0, 0), name="rail")
    pin = Revolute(cart, pole, at=(0, 0, 0), axis=(0, 1, 0), name="pin")
    system = System([cart, pole], [rail, pin], [Force(cart, (Input("push"), 0, 0))], gravity=(0, 0, -g))
    plant = written(system, tmp_path, "plant", state=system.assemble(angles={pin: 0.2}), rtol=1e-11)
    pid = write_controller(tmp_path)
    with hosted(plant, tmp_path / "one") as host, hosted(pid, tmp_path / "other") as control:
        host.start()
        control.start()
        forces = []
        for k in range(100):
            angle, rate = host.get("pin.angle", "pin.rate")
            control.set(angle=angle, rate=rate)
            forces += control.get("u")
            host.set(push=forces[-1])
            control.step(0.01 * k, 0.01)
            host.step(0.01 * k, 0.01)
        x = host.get("rail.slide", "pin.angle", "rail.slide_rate", "pin.rate")
        assert host.passed
    known = [0.3046555031148647, -0.017269397837915697, 0.1590138844005208, 0.01704745092788565]
    assert x == pytest.approx(known, abs=1e-9)
    assert (forces[0], forces[-1]) == (pytest.approx(12.0, abs=1e-12), pytest.approx(-0.21667426364132591, abs=1e-8))


def bouncing():
    """A ball that bounces and slips under a wind that is set."""
    ball = Body(
        "ball", 1.5, (0.01, 0.012, 0.008), position=(0, 0, 0.15), velocity=(1.0, 0.3, 0), omega=(3.0, 1.0, -5.0)
    )
    floor = Contact(GROUND, ball, shapes.Sphere(0.1), stiffness=2e4, loss=0.3, friction=0.3)
    return System([ball], forces=[floor, Force(ball, (Input("push"), 0, 0))])


@pytest.mark.parametrize("model", [stand, bouncing])
def test_going_back_is_true(model, tmp_path):
    """To the last bit: with states of forces, several states kept at once, and one taken before the start."""
    with hosted(written(model(), tmp_path), tmp_path / "unzipped") as host:
        names = [name for name, x in host.places.items() if x.causality == "output" and name != "certificate.passed"]
        before = host.fmu.getFMUState()
        host.start(push=1.0)

        def go(t, pushes):
            for k, push in enumerate(pushes):
                host.set(push=push)
                host.step(t + 0.05 * k, 0.05)
            return host.get(*names), host.passed

        go(0.0, [1.0, 2.0])
        there = host.fmu.getFMUState()
        one = go(0.1, [3.0, -1.0, 0.5])
        later = host.fmu.getFMUState()
        other = go(0.25, [7.0])
        host.fmu.setFMUState(there)
        go(0.1, [-9.0])
        host.fmu.setFMUState(there)
        assert go(0.1, [3.0, -1.0, 0.5]) == one
        host.fmu.setFMUState(later)
        assert go(0.25, [7.0]) == other != one
        host.fmu.setFMUState(before)
        for state in (before, there, later):
            host.fmu.freeFMUState(state)


def test_parameters_are_set_before_the_start(tmp_path):
    path = written(stand(), tmp_path, parameters=["spring.stiffness", ("the pole", "mass")])
    own = stepper_of(stand(stiffness=11.0, pole=0.7))
    own.set("push", 2.0)
    own.advance(0.4)
    with hosted(path, tmp_path / "unzipped") as host:
        host.fmu.setFloat64([host.places["'the pole'.mass"].valueReference], [0.7])
        host.start(spring__stiffness=11.0, push=2.0)
        host.step(0.0, 0.4)
        assert host.get("pin.angle", "pin.rate") == pytest.approx(own.measured, abs=1e-12)


def test_the_certificate_is_in_the_log(tmp_path):
    with hosted(written(stand(), tmp_path), tmp_path / "unzipped") as host:
        host.start(push=1.0)
        for k in range(5):
            host.step(0.02 * k, 0.02)
        assert host.passed and 0.0 < host.get("certificate.worst")[0] < 1.0
        back = host.fmu.getFMUState()
        host.fmu.setFMUState(back)
        host.fmu.freeFMUState(back)
        host.fmu.terminate()
        text = host.lines[-1][1]
    assert text.startswith("stand, mbsd3d ")
    for part in (
        "passed: DOP853", "rtol 1e-08", "joint gaps", "energy balance", "1 time back to an earlier state; model ",
        "inputs held over communication steps of up to 0.02 s",
    ):  # fmt: skip
        assert part in text


def test_the_certificate_says_what_holding_creates(tmp_path):
    """An undamped pair of masses in two FMUs: its energy grows by what the jumps at both ports say, to H^2.

    The work at the ports is that of the forces, from the energies of the halves.
    """
    m1, m2, k1, kc, length = 1.1, 0.6, 90.0, 70.0, 0.001
    near, x1, rail1 = half_of_a_pair("near", m1, k1 + kc, 0.0, kc * Input("x2"), x=1.0)
    far, x2, rail2 = half_of_a_pair("far", m2, kc, 0.0, kc * Input("x1"))
    one = near.to_fmu(tmp_path / "near.fmu", outputs={"x1": x1, "v1": measures.slide_rate(rail1)}, rtol=1e-10)
    two = far.to_fmu(tmp_path / "far.fmu", outputs={"x2": x2, "v2": measures.slide_rate(rail2)}, rtol=1e-10)
    with hosted(one, tmp_path / "one") as here, hosted(two, tmp_path / "two") as there:
        here.start()
        there.start(x1=1.0)
        for k in range(501):
            (x1, v1), (x2, v2) = here.get("x1", "v1"), there.get("x2", "v2")
            here.set(x2=x2)
            there.set(x1=x1)
            if k < 500:
                here.step(length * k, length)
                there.step(length * k, length)
        assert here.get("x1") + there.get("x2") == [x1, x2]
        work, created = np.array([host.get("certificate.work", "certificate.created") for host in (here, there)]).T
    gained = 0.5 * (m1 * v1**2 + m2 * v2**2 + k1 * x1**2 + kc * (x2 - x1) ** 2 - k1 - kc)
    assert created.sum() == pytest.approx(gained, rel=0.005) and gained > 1.0  # 0.003 at 1 ms, and half of it at half
    own = 0.5 * np.array([m1 * v1**2 + (k1 + kc) * (x1**2 - 1.0), m2 * v2**2 + kc * x2**2])
    assert work == pytest.approx(own, abs=1e-6)


def test_another_start_time(tmp_path):
    """A force that depends on time, from 5 s on: the first step says when it is."""
    block = Body("block", 2.0, (0.1, 0.1, 0.1), velocity=(0, 0, 0), omega=(0, 0, 0))
    system = System([block], forces=[Force(block, (Ramp(4.0), 0, 19.62))])
    with hosted(written(system, tmp_path), tmp_path / "unzipped") as host:
        host.start(t=5.0)
        host.step(5.0, 0.1)
        assert host.get("time") == [5.1]
        assert host.get("block.velocity[1]") == pytest.approx([5.1**2 - 5.0**2], rel=1e-8)


def test_an_output_of_another_start_time_is_refused(tmp_path):
    """What was read before the first step holds for any start time, or the step says that it does not."""
    block = Body("block", 2.0, (0.1, 0.1, 0.1), velocity=(0, 0, 0), omega=(0, 0, 0))
    rail = Prismatic(GROUND, block, at=(0, 0, 0), axis=(0, 1, 0), name="rail")
    system = System([block], [rail], [Force(block, (Ramp(4.0) + Input("push"), 0, 19.62))])
    seen = {"pull": measures.reaction(rail, axis=(-1, 0, 0)), "x": measures.position(block, axis=(1, 0, 0))}
    path = written(system, tmp_path, outputs=seen)
    with hosted(path, tmp_path / "one") as host:
        host.start(t=5.0, push=1.0)
        assert host.get("x") == [0.0]
        host.set(push=2.0)
        host.step(5.0, 0.1)
        assert host.get("pull") == pytest.approx([4.0 * 5.1 + 2.0], rel=1e-9)
    with hosted(path, tmp_path / "two") as host:
        host.start(t=5.0, push=1.0)
        host.get("pull")
        host.set(push=2.0)
        failing(host, lambda: host.step(5.0, 0.1), "'pull' was read before the first step, of 0 s: the start", "pull")
    late = written(system, tmp_path, "late", outputs=seen, state=replace(system.state(), t=5.0))
    assert float(fmpy.read_model_description(str(late)).defaultExperiment.startTime) == 5.0
    with hosted(late, tmp_path / "three") as host:
        host.start(t=5.0, push=1.0)
        assert host.get("pull") == pytest.approx([4.0 * 5.0 + 1.0], rel=1e-12)
        host.step(5.0, 0.1)


def failing(host, call, words, output="pin.angle"):
    """A call that is an error whose sentence is in the log; from now on there is no value."""
    with pytest.raises(FMICallException) as caught:
        call()
    assert caught.value.status == 3  # fmi3Error; 4 would be fatal for all instances
    assert host.lines[-1][0] == 3 and words in host.lines[-1][1], host.lines
    assert np.isnan(host.get(output)[0])


def test_errors_are_errors_with_their_sentence(tmp_path):
    system = stand()
    table = Table([0.0, 0.1, 0.2, 0.3], [0.0, 1.0, 0.0, 1.0])
    short = System(system.bodies, system.joints, [*system.forces, Torque(system.bodies[1], (0, table, 0))])
    path = written(short, tmp_path, parameters=["the pole.mass"])
    with hosted(path, tmp_path / "one") as host:
        host.start()
        host.step(0.0, 0.2)
        there = host.fmu.getFMUState()
        failing(host, lambda: host.step(0.2, 0.2), "the table covers 0 s to 0.3 s")
        failing(host, lambda: host.step(0.4, 0.1), "the table covers 0 s to 0.3 s")  # and so it stays
        host.fmu.setFMUState(there)
        host.step(0.2, 0.1)
        assert np.isfinite(host.get("pin.angle")[0])
        failing(host, lambda: host.step(0.1, 0.1), "a step from 0.1 s is asked for, but the FMU is at 0.3 s")
        host.fmu.freeFMUState(there)
    with hosted(path, tmp_path / "two") as host:
        host.fmu.setFloat64([host.places["'the pole'.mass"].valueReference], [-1.0])
        host.start()
        failing(host, lambda: host.step(0.0, 0.1), "mass")
        assert not host.passed and host.get("certificate.worst") == [np.inf]
    with hosted(path, tmp_path / "four") as host:
        host.start()
        host.step(0.0, 0.1)
        host.fmu.setFloat64([host.places["'the pole'.mass"].valueReference], [2.0])
        failing(host, lambda: host.step(0.1, 0.1), "parameter ''the pole'.mass' is set after the start")
        host.fmu.terminate()
        assert not host.passed and "failed: parameter" in host.lines[-1][1] and "joint gaps" in host.lines[-1][1]
    with hosted(path, tmp_path / "three") as host:
        host.start(push=np.nan)
        failing(host, lambda: host.step(0.0, 0.1), "input 'push': not finite")


def test_what_cannot_be_an_fmu_is_refused(tmp_path, monkeypatch):
    system, path = stand(), tmp_path / "model.fmu"
    cart, pole = system.bodies
    pin = system.joints[1]
    driven = System([cart, pole], [*system.joints, AngleDriver(pin, Input("angle"), name="motor")])
    ball = System([cart], [Spherical(GROUND, cart, at=(0, 0, 0))])
    own = System([cart], forces=[CustomForce(lambda t, b, z, p, loads, z_dot: None, on=(cart,), name="own")])
    foreign = measures.angle(stand().joints[1])
    for use, message in (
        (lambda: driven.to_fmu(path), "to_fmu: input 'angle' prescribes the motion of driver 'motor', and would"),
        (lambda: own.to_fmu(path), "CustomForce 'own': its function cannot be written to a file"),
        (lambda: system.to_fmu(path, inputs=["pull"]), "to_fmu: inputs: 'pull' is not an input of this system"),
        (lambda: system.to_fmu(path, outputs=[foreign]), "to_fmu: outputs"),
        (lambda: system.to_fmu(path, outputs=["angle"]), "'angle' is not a measure"),
        (lambda: system.to_fmu(path, outputs=[measures.angle(pin)] * 2), "two are named '.*'; give a dict"),
        (lambda: system.to_fmu(path, outputs={"push": measures.angle(pin)}), "two are named 'push'"),
        (lambda: system.to_fmu(path, outputs={"time": measures.angle(pin)}), "two are named 'time'; give a dict"),
        (lambda: system.to_fmu(path, outputs={"certificate.work": measures.angle(pin)}), "two are named 'certificate"),
        (lambda: system.to_fmu(path, parameters=["spring"]), "'spring' is of no part; give e.g. 'spring.stiffness'"),
        (lambda: system.to_fmu(path, parameters=["spring.hinge"]), "'hinge' of 'spring' .* is not a number"),
        (lambda: system.to_fmu(path, state=ball.state()), "state"),
        (lambda: system.to_fmu(tmp_path / "model.zip"), "an FMU ends in .fmu"),
        (lambda: system.to_fmu(path, rtol=7.0), "rtol 7 is outside"),
    ):
        with pytest.raises(ValueError, match=message):
            use()
    assert not path.exists()
    driven.to_fmu(path, inputs=())
    with pytest.raises(ValueError, match="exists; give replace=True"):
        system.to_fmu(path)
    monkeypatch.setitem(sys.modules, "pythonfmu3", None)
    with pytest.raises(ValueError, match=r"needs the package pythonfmu3; install it: pip install 'mbsd3d\[fmu\]'"):
        system.to_fmu(path, replace=True)


def test_the_model_in_it_is_a_plain_description(tmp_path):
    """No pickle, no code of the model: JSON that other programs may read, and a script that hands it over."""
    path = written(stand(), tmp_path)
    with zipfile.ZipFile(path) as archive:
        found = json.loads(archive.read("resources/mbsd3d_fmu.json"))
    assert [body["name"] for body in found["system"]["bodies"]] == ["cart", "the pole"]
    assert len(found["hash"]) == 64


def test_the_command(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    stand().to_file("stand.json")
    done = CliRunner().invoke(main, ["fmu", "stand.json", "--parameter", "spring.stiffness", "--input", "push"])
    assert done.exit_code == 0 and "stand.fmu" in done.output
    assert "it runs where the host is Python with mbsd3d installed, as with FMPy" in done.output
    assert validate_fmu("stand.fmu") == []
    again = CliRunner().invoke(main, ["fmu", "stand.json"])
    assert again.exit_code == 2 and "exists; give replace=True" in again.output
    assert CliRunner().invoke(main, ["fmu", "stand.json", "--replace", "--out", "stand.fmu"]).exit_code == 0


def test_springs_between_directions_stay_what_they_are(tmp_path):
    """A spring between points in general position comes back from the file bit for bit: the same motion."""
    rng = np.random.default_rng(1)
    a, b = random_body(rng, "a"), random_body(rng, "b")
    spring = SpringDamper(
        a, b, at_a=a.position + direction(rng), at_b=b.position, stiffness=30.0, damping=1.0, length=0.5
    )
    system = System([a, b], forces=[spring])
    own = Stepper(system, measures=[measures.position(b, axis=(0, 1, 0))])
    own.advance(0.5)
    with hosted(written(system, tmp_path), tmp_path / "unzipped") as host:
        host.start()
        host.step(0.0, 0.5)
        assert host.get("b.position[2]") == own.measured.tolist()
