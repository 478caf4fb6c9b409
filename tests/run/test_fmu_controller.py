"""Controllers in FMUs beside a stepper: against own equations, the order of the coupling, energies, refusals."""

import re
import sys
import zipfile

import numpy as np
import pytest
from scipy.linalg import expm

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    FmuController,
    Force,
    Input,
    IntegrationError,
    Prismatic,
    Revolute,
    SpringDamper,
    Stepper,
    System,
    load,
    measures,
)

pytest.importorskip("pythonfmu3", reason="the extra fmu is not installed")
pytest.importorskip("fmpy", reason="the extra fmu is not installed")

from helpers.fmu_host import half_of_a_pair, write_controller, write_old_controller  # noqa: E402

M, POLE, INERTIA, ARM = 1.0, 0.3, 0.006, 0.3


def stand():
    """The upright cart and pole, and its start at 0.2 rad."""
    cart = Body("cart", M, (0.1, 0.1, 0.1))
    pole = Body("pole", POLE, (INERTIA, INERTIA, INERTIA), com=(0, 0, ARM))
    rail = Prismatic(GROUND, cart, at=(0, 0, 0), axis=(1, 0, 0), name="rail")
    pin = Revolute(cart, pole, at=(0, 0, 0), axis=(0, 1, 0), name="pin")
    system = System([cart, pole], [rail, pin], [Force(cart, (Input("push"), 0, 0), name="motor")])
    return system, rail, pin, system.assemble(angles={pin: 0.2})


def controlled(path, every=0.01, **given):
    """A controller for it."""
    system, rail, pin, start = stand()
    reads = {"angle": measures.angle(pin), "rate": measures.rate(pin)}
    pid = FmuController(path, reads=reads, sets={"u": "push"}, every=every)
    seen = [measures.slide(rail), measures.angle(pin), measures.slide_rate(rail), measures.rate(pin)]
    return Stepper(system, start, measures=seen, controllers=[pid], **given)


def test_a_controller_holds_the_pole(tmp_path):
    """u = P th + I S + D th' of 10 ms, from equations of the two coordinates at 1e-13."""
    run = controlled(write_controller(tmp_path), rtol=1e-11)
    run.advance(0.305)  # not a sample: they go on as if it had not been asked for
    run.advance(1.0)
    known = [0.3046555031148647, -0.017269397837915697, 0.1590138844005208, 0.01704745092788565]
    assert run.measured == pytest.approx(known, abs=1e-9)
    solution = run.solution()
    assert solution.certificate.passed
    assert solution.record.inputs["push"][0] == (0.0, pytest.approx(12.0, abs=1e-12))
    assert len(solution.record.inputs["push"]) == 100
    assert solution.again().final.q == pytest.approx(solution.final.q, abs=1e-9)  # by what was set, without the FMU


def test_the_certificate_says_what_passed_at_the_ports(tmp_path):
    """The work of the push over the cart, and what its jumps say, by sums of the samples of the run."""
    run = controlled(write_controller(tmp_path))
    run.advance(0.5)
    solution = run.solution()
    energy = solution.energy()
    push = np.array([value for _, value in solution.record.inputs["push"]])
    speed = solution.velocity("cart")[:, 0]
    assert solution.t.size == 51
    shift = np.diff(solution.position("cart")[:, 0])
    given = float((push * shift).sum())  # F dx is the work of a force that holds
    assert given == pytest.approx(energy.total[-1] - energy.total[0], rel=1e-6)
    created = float((-np.diff(push) * speed[1:-1]).sum() * 0.005)  # half of what the power jumps by, times H
    note = next(text for text in solution.certificate.notes if text.startswith("controller 'pid.fmu'"))
    assert "sampled every 0.01 s, values held (order 1)" in note
    said = [float(x) for x in re.findall(r"(?:gave|created) (\S+) J", note)]
    assert said == [pytest.approx(given, rel=1e-5), pytest.approx(created, rel=1e-5)]  # six digits are said
    assert abs(created) > 0.01 * abs(given)  # what holding does
    path = solution.save(tmp_path / "run")
    assert note in load(path).certificate.notes


def test_the_coupling_is_of_order_one(tmp_path):
    """A damper in an FMU, u = -c v held over H, against the damped motion: errors halve with H."""
    m, k, c = 1.3, 90.0, 2.1
    block = Body("block", m, (0.1, 0.1, 0.1), position=(0.4, 0, 0), velocity=(0, 0, 0), omega=(0, 0, 0))
    rail = Prismatic(GROUND, block, at=(0.4, 0, 0), axis=(1, 0, 0), name="rail")
    spring = SpringDamper(GROUND, block, at_a=(-5.0, 0, 0), at_b=(0.4, 0, 0), stiffness=k, length=5.0)
    system = System([block], [rail], [spring, Force(block, (Input("damping"), 0, 0))])
    path = write_controller(tmp_path, "damper", P=0.0, I=0.0, D=-c)
    rate, w = c / (2 * m), np.sqrt(k / m - (c / (2 * m)) ** 2)
    exact = 0.4 * np.exp(-rate) * (np.cos(w) + rate / w * np.sin(w))
    errors = []
    for every in (0.02, 0.01, 0.005):
        damper = FmuController(path, reads={"rate": measures.slide_rate(rail)}, sets={"u": "damping"}, every=every)
        run = Stepper(system, measures=[measures.slide(rail)], controllers=[damper])
        run.advance(1.0)
        errors.append(abs(run.measured[0] + 0.4 - exact))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx([1.0, 1.0], abs=0.15)  # terms of H^2 are a tenth at 0.02 s


M1, M2, K1, KC, CC = 1.1, 0.6, 90.0, 70.0, 0.7  # [kg], [kg], [N/m], [N/m], [N s/m]


def two_halves(folder, coupling, every, t_end, damping=CC):
    """A pair of masses, the first in the process, the second in an FMU: x1, v1 go there, x2, v2 come back."""
    there, x2, rail2 = half_of_a_pair("far", M2, KC, damping, KC * Input("x1") + damping * Input("v1"))
    path = there.to_fmu(
        folder / "far.fmu", outputs={"x2": x2, "v2": measures.slide_rate(rail2)}, rtol=1e-10, replace=True
    )
    here, x1, rail1 = half_of_a_pair("near", M1, K1 + KC, damping, KC * Input("x2") + damping * Input("v2"), x=1.0)
    v1 = measures.slide_rate(rail1)
    far = FmuController(path, reads={"x1": x1, "v1": v1}, sets={"x2": "x2", "v2": "v2"}, every=every, coupling=coupling)
    run = Stepper(here, measures=[x1, v1], controllers=[far], rtol=1e-10)
    run.advance(t_end)
    return run


@pytest.mark.parametrize(("coupling", "order"), [("held", 1.0), ("extrapolated", 2.0)])
def test_the_order_of_the_coupling_of_two_halves(coupling, order, tmp_path):
    """A damped pair of masses cut at its spring, against the matrix exponential of the whole."""
    A = np.array([
        [0, 1, 0, 0], [-(K1 + KC) / M1, -CC / M1, KC / M1, CC / M1],
        [0, 0, 0, 1], [KC / M2, CC / M2, -KC / M2, -CC / M2],
    ])  # fmt: skip
    exact = expm(0.4 * A)[:2, 0]
    errors = []
    for every in (0.008, 0.004, 0.002):
        run = two_halves(tmp_path, coupling, every, 0.4)
        errors.append(np.abs(run.measured - exact).max())
        assert f"values {coupling} (order {order:.0f})" in run.solution().certificate.notes[0]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx(order, abs=0.16)  # terms of the next order: a tenth at 8 ms
    again = run.solution().again()  # with the slopes
    assert again.final.q == pytest.approx(run.solution().final.q, abs=1e-8)
    read = load(run.solution().save(tmp_path / "halves"))
    assert read.certificate.passed and read.record.inputs == run.solution().record.inputs


def test_two_controllers_at_different_rates(tmp_path):
    """Both samples are met; what one sets does not reach the other before the next sample."""
    system, rail, pin, start = stand()
    paths = [write_controller(tmp_path, name, P=0.0, I=0.0, D=d) for name, d in (("one", 2.0), ("two", -1.0))]
    forces = [*system.forces, Force(system.bodies[1], (Input("tip"), 0, 0), at=(0, 0, 0.6))]
    system = System(system.bodies, system.joints, forces)
    both = [
        FmuController(paths[0], reads={"rate": measures.rate(pin)}, sets={"u": Input("push")}, every=0.02),
        FmuController(paths[1], reads={"rate": measures.slide_rate(rail)}, sets={"u": "tip"}, every=0.03),
    ]
    run = Stepper(system, start, controllers=both)
    own = Stepper(system, start, measures=[measures.rate(pin), measures.slide_rate(rail)])
    run.advance(0.12)
    for k in range(12):
        rate, speed = own.measured
        if k % 2 == 0:
            own.set("push", 2.0 * rate)
        if k % 3 == 0:
            own.set("tip", -speed)
        own.advance(0.01 * (k + 1))
    assert run.q == pytest.approx(own.q, abs=1e-9)
    assert len(run.solution().certificate.notes) == 2


def test_units_with_a_factor_are_refused(tmp_path):
    """The same FMU with its angle in degrees."""
    system, rail, pin, start = stand()
    with zipfile.ZipFile(write_controller(tmp_path)) as found, zipfile.ZipFile(tmp_path / "deg.fmu", "w") as made:
        for entry in found.namelist():
            content = found.read(entry)
            if entry == "modelDescription.xml":
                text = content.decode().replace('name="angle"', 'name="angle" unit="deg"')
                unit = '<Unit name="deg"><BaseUnit rad="1" factor="0.0174532925"/></Unit>'
                content = text.replace(
                    "<LogCategories>", f"<UnitDefinitions>{unit}</UnitDefinitions><LogCategories>"
                ).encode()
            made.writestr(entry, content)
    pid = FmuController(tmp_path / "deg.fmu", reads={"angle": measures.angle(pin)}, sets={"u": "push"}, every=0.01)
    with pytest.raises(ValueError, match="'deg.fmu': 'angle' is in deg; export it in SI units and radians"):
        Stepper(system, start, controllers=[pid])


def test_errors_of_the_fmu_name_it(tmp_path):
    system, rail, pin, start = stand()
    stand_fmu = system.to_fmu(tmp_path / "other.fmu", state=start, outputs={"angle": measures.angle(pin)})
    wild = FmuController(stand_fmu, reads={"push": measures.slide(rail)}, sets={"angle": "push"}, every=0.1)
    run = Stepper(system, start, controllers=[wild])
    run.advance(0.3)
    assert run.inputs["push"] != 0.0
    script = write_controller(tmp_path, "broken", D='float("nan")')
    broken = FmuController(script, reads={"rate": measures.rate(pin)}, sets={"u": "push"}, every=0.1)
    with pytest.raises(ValueError, match="input 'push': not finite"):
        Stepper(system, start, controllers=[broken]).advance(0.2)


def test_refusals(tmp_path, monkeypatch):
    system, rail, pin, start = stand()
    path = write_controller(tmp_path)
    angle = {"angle": measures.angle(pin)}
    (tmp_path / "text.fmu").write_text("no archive")

    def made(path=path, reads=angle, sets=None, every=0.01, **given):
        return FmuController(path, reads=reads, sets={"u": "push"} if sets is None else sets, every=every, **given)

    for use, message in (
        (lambda: made("none.fmu"), "'none.fmu' does not exist; give an FMU"),
        (lambda: made(reads={"angle": 1.0}), "reads: 'angle': 1.0; give a name and a measure"),
        (lambda: made(reads=[1.0]), r"reads = \[1.0\]; give a dict of name and a measure"),
        (lambda: made(sets={}), "sets is empty"),
        (lambda: made(every=0.0), "FmuController: every"),
        (lambda: made(coupling="cubic"), "FmuController: coupling 'cubic'"),
        (lambda: made(parameters={"P": "x"}), "parameters: 'P': 'x'; give a name and a number"),
    ):
        with pytest.raises(ValueError, match=message):
            use()
    driven = System(system.bodies, [*system.joints, AngleDriver(pin, Input("push"), name="motor")])
    for controllers, message in (
        ([made(reads={"angel": angle["angle"]})], "'pid.fmu' has no input 'angel', did you mean 'angle'? There are"),
        ([made(sets={"v": "push"})], "'pid.fmu' has no output 'v'; there are 'u'"),
        ([made(sets={"u": "pull"})], "sets 'pull', which is not an input of this system; there are 'push'"),
        ([made(), made()], "two set the input 'push'; let one set it"),
        ([made(tmp_path / "text.fmu")], "'text.fmu' cannot be loaded"),
        ([3.0], "Stepper: controllers: 3.0 is none; give an FmuController"),
        ([made(reads={"angle": measures.angle(stand()[2])})], "Stepper: measures"),
    ):
        with pytest.raises(ValueError, match=message.replace("?", r"\?")):
            Stepper(system, start, controllers=controllers)
    with pytest.raises(ValueError, match="sets 'push', which prescribes the motion of driver 'motor'"):
        Stepper(driven, driven.assemble(), controllers=[made(reads={})])
    run = Stepper(system, start, controllers=[made()])
    with pytest.raises(ValueError, match="input 'push' is set by 'pid.fmu'; leave it to it"):
        run.set("push", 1.0)
    with pytest.raises(ValueError, match="^FmuController: 'pid.fmu' does not offer its state"):
        run.snapshot()
    monkeypatch.setitem(sys.modules, "fmpy", None)
    with pytest.raises(ValueError, match=r"needs the package fmpy; install it: pip install 'mbsd3d\[fmu\]'"):
        Stepper(system, start, controllers=[made()])


def test_snapshots_with_a_controller(tmp_path):
    """A PID that gives its sum away: all ways to a time lead to the same bits, between samples too."""
    run = controlled(write_controller(tmp_path, goes_back=True))
    run.advance(0.105)
    there = run.snapshot()
    run.advance(0.3)
    one, notes = (run.measured.tolist(), run.t), run.solution().certificate.notes
    later = run.snapshot()
    run.advance(0.4)
    other = run.measured.tolist()
    for _ in range(2):
        run.restore(there)
        run.advance(0.3)
        assert (run.measured.tolist(), run.t) == one and run.solution().certificate.notes == notes
    run.restore(later)
    run.advance(0.4)
    assert run.measured.tolist() == other
    fresh = controlled(write_controller(tmp_path))
    for t in (0.105, 0.3, 0.4):
        fresh.advance(t)
    assert fresh.measured.tolist() == other


def test_a_controller_of_fmi_2_is_the_same(tmp_path):
    """The same law and numbers, and back to a snapshot."""
    pytest.importorskip("pythonfmu", reason="pythonfmu, which writes FMUs of FMI 2.0, is not installed")
    run = controlled(write_old_controller(tmp_path), rtol=1e-11)
    run.advance(0.305)
    there = run.snapshot()
    run.advance(1.0)
    once = run.measured
    assert once[0] == pytest.approx(0.3046555031148647, abs=1e-9)
    run.restore(there)
    run.advance(1.0)
    assert np.array_equal(run.measured, once)


@pytest.mark.parametrize("coupling", ["held", "extrapolated"])
def test_snapshots_with_a_mechanism_in_the_fmu(coupling, tmp_path):
    run = two_halves(tmp_path, coupling, 0.01, 0.1)
    there, found = run.snapshot(), []
    for _ in range(2):
        run.restore(there)
        run.advance(0.2)
        found.append((run.measured.tolist(), run.inputs, run.solution().certificate.notes))
    assert found[0] == found[1]


def test_an_fmu_that_fails_ends_the_run(tmp_path):
    """A mechanism in an FMU whose table ends: the sentence of its log is in the error."""
    from mbsd3d import Table

    system, rail, pin, start = stand()
    table = Table([0.0, 0.1, 0.2, 0.3], [0.0, 1.0, 0.0, 1.0])
    short = System(system.bodies, system.joints, [*system.forces, Force(system.bodies[0], (table, 0, 0))])
    path = short.to_fmu(tmp_path / "short.fmu", outputs={"angle": measures.angle(pin)})
    follower = FmuController(path, reads={"push": measures.slide(rail)}, sets={"angle": "push"}, every=0.1)
    run = Stepper(system, start, controllers=[follower])
    with pytest.raises(IntegrationError, match=r"the FMU reports an error: .*the table covers 0 s to 0.3 s") as caught:
        run.advance(1.0)
    assert "'short.fmu'" in str(caught.value) and run.t == pytest.approx(0.3)
