"""The twin in Exudyn: every joint and force it expresses against mbsd3d, closed forms and files; orders, redundancy."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.forces import EXAMPLES as FORCES
from helpers.models import across, direction, random_body, random_inertia

from bicycle import TYPICAL, Meijaard2007, whipple
from mbsd3d import GROUND, Body, GearMesh, Prismatic, Pulse, Revolute, System, accelerations, simulate
from mbsd3d.demos.cars.car import Car, car
from mbsd3d.rotations import matrix
from validation import cases
from validation.theory.torque_free import free_body
from validation.twins.base import EngineFailed

pytest.importorskip("exudyn", reason="the engine Exudyn is not installed")

from helpers.exudyn_models import EVERY, check_start, example, judge, moving, tree  # noqa: E402

from validation.twins.exudyn import EXPRESSES_FORCES, twin  # noqa: E402


@pytest.mark.parametrize(("cls", "ground"), EVERY, ids=lambda x: getattr(x, "__name__", x))
def test_joint(cls, ground):
    """Every joint it expresses, with all of mass matrix, accelerations, motion and reactions."""
    system = example(cls, ground)
    state = moving(system)
    made, fine = judge(system, state, state.t + 0.12, solver="index2")
    check_start(system, state, made)
    assert set(fine.reactions) == {system.name(joint) for joint in system.joints}


EXPRESSED = [name for name in FORCES if name.split()[0] in {c.__name__ for c in EXPRESSES_FORCES}]


@pytest.mark.parametrize(("name", "ground"), [(name, side) for name in EXPRESSED for side in (None, "a")])
def test_force(name, ground):
    """Every force element it expresses; bodies without joints by its explicit solver of sixth order."""
    rng = np.random.default_rng(3)
    bodies = [random_body(rng, "one"), random_body(rng, "two")]
    joints, force = FORCES[name](rng, GROUND if ground else bodies[0], bodies[1])
    system = System(bodies[1:] if ground else bodies, joints, [force])
    state = moving(system)
    finer = 4 if "creeps" in name else 1  # where the slip is slow its friction changes fast
    made, _ = judge(system, state, state.t + 0.2, solver="index2" if joints else "rk67", finer=finer)
    check_start(system, state, made)


@pytest.mark.parametrize("solver", ["rk44", "dopri5", "rk67", "generalized-alpha"])
def test_kinematic_tree(solver):
    """Hinge coordinates of a tree, by explicit solvers of orders 4, 5, 6 and the implicit one of order 2."""
    system, state = tree()
    made, fine = judge(system, state, state.t + 0.4, solver=solver, formulation="kinematic tree")
    check_start(system, state, made)
    assert fine.reactions == {} and made.kinetic().matrix.shape == (6, 6)


@pytest.mark.parametrize("solver", ["generalized-alpha", "index2"])
@pytest.mark.parametrize("rotation", ["rotation vector", "euler parameters"])
def test_rotations_and_solvers(solver, rotation):
    """Both descriptions of orientations with both implicit solvers; multipliers of generalized-alpha ring at first."""
    system, state = tree()
    judged = judge(system, state, state.t + 0.2, solver=solver, rotation=rotation, reactions=solver == "index2")
    check_start(system, state, judged[0])


def test_free_body_is_the_closed_form():
    """A general torque-free body against Jacobi's functions; the spin about O off the centre of mass."""
    rng = np.random.default_rng(8)
    inertia, omega, com = np.array([0.3, 0.5, 0.7]), np.array([1.3, -0.8, 2.1]), np.array([0.3, -0.1, 0.2])
    body = Body("stone", 2.0, inertia, com=com, position=rng.normal(size=3), velocity=np.zeros(3), omega=omega)
    motion = twin(System([body], gravity=(0, 0, 0))).run(2.0, 512, 4)
    exact = free_body(motion.t, inertia, omega)  # the body stands along the world at the start
    R = matrix(motion.orientation[:, 0])
    assert np.abs(R - exact.rotation).max() < 1e-12  # 512 steps of sixth order and their rounding
    centre = motion.position[:, 0] + R @ com  # moves uniformly with its first velocity omega x com
    assert np.abs(centre - centre[0] - motion.t[:, None] * np.cross(omega, com)).max() < 1e-12


def test_reaction_is_the_closed_form():
    """A rotor on a fixed axis without torque: force -m w^2 r on the axis, moment w x I_P w, turning with it."""
    rng = np.random.default_rng(9)
    axis, rate, mass = direction(rng), 7.0, 1.7
    body = random_body(rng, "rotor", mass=mass, inertia=random_inertia(rng, mass))
    at = body.position + 0.3 * direction(rng)
    omega = rate * axis
    body = Body(
        "rotor", mass, body.inertia, com=body.com, position=body.position, orientation=body.orientation, omega=omega,
        velocity=np.cross(omega, body.position - at),
    )  # fmt: skip
    bearing = Revolute(GROUND, body, at=at, axis=axis, name="bearing")
    motion = twin(System([body], [bearing], gravity=(0, 0, 0))).run(0.5, 4096, 4)
    arm = body.centre - at
    inertia = body.axes @ body.inertia @ body.axes.T + mass * ((arm @ arm) * np.eye(3) - np.outer(arm, arm))
    force, moment = mass * np.cross(omega, np.cross(omega, arm)), np.cross(omega, inertia @ omega)
    for k, t in enumerate(motion.t):  # the angle of the trapezoidal rule is off by (w h)^2 / 12 of itself: 2e-7 rad
        turn = matrix(np.array([np.cos(rate * t / 2), *(np.sin(rate * t / 2) * axis)]))
        load = motion.reactions["bearing"]
        assert np.abs(load.force[k] - turn @ force).max() < 1e-6 * np.linalg.norm(force)
        assert np.abs(load.moment[k] - turn @ moment).max() < 1e-6 * np.linalg.norm(moment)


def case_error(name, steps, shift=5, **settings):
    """Greatest distance of the positions of a reference case from its file [m], r_G != 0."""
    case = cases.load(name, shift=shift)
    made = twin(case.system, **settings)
    error = 0.0
    for t, row in zip(case.times, case.reference, strict=True):
        motion = made.run(t, int(steps * t / case.t_end) or 1, 1)
        for output in (output for output in case.outputs if output["kind"] == "pos" and "p" not in output):
            columns = [case.labels.index(f"{output['name']}_{x}") for x in "xyz"]
            k, body = next((k, b) for k, b in enumerate(case.system.bodies) if b.name == output["body"])
            centre = motion.position[-1, k] + matrix(motion.orientation[-1, k]) @ body.com
            error = max(error, np.abs(centre - row[columns]).max())
    return error


@pytest.mark.parametrize("name", ["exudyn_rollingCoinTest", "heavy_top_fast"])
def test_reference_case(name):
    """The rolling coin of its own test suite, and the fast top: positions of the files, at second order."""
    errors = [case_error(name, steps) for steps in (4000, 8000)]
    # the top turns by 0.04 rad a step: error 5e-3 m at 1 m
    assert 1.8 < np.log2(errors[0] / errors[1]) < 2.2 and errors[1] < 1e-2


def test_a_bicycle_on_tyres():
    """Nine degrees of freedom and four deflections, leaning into a curve; the tyres are bristles in a patch."""
    on = {**TYPICAL, "twisting": 0.004, "standing_damping": 0.3, "nominal_load": 400.0, "grip_sensitivity": 0.1}
    system = whipple(Meijaard2007(), 5.0, lean=0.1, steer=0.05, lean_rate=0.2, tyres=on)
    state = simulate(system, 0.2, state=system.state(), rtol=1e-11, output=2).final
    made, _ = judge(system, state, state.t + 0.05, solver="index2")
    check_start(system, state, made)


def test_a_car_that_slides():
    """Steered hard at 18 m/s, but for its roll bars, which Exudyn has on the ground only: 1e-12 of 20 m/s^2."""
    c = Car(ms=1250.0, h=0.6, a=1.1, b=1.6, track=1.45, mu=0.9)
    whole = car(c, 18.0, Pulse(0.12, start=0.0, edge=0.3))
    system = replace(whole, forces=[force for force in whole.forces if not force.name.endswith("bar")])
    state = simulate(system, 0.6, rtol=1e-11, output=2).final
    now, known = accelerations(system, state), twin(system, state=state).accelerations()
    ours = np.array([np.r_[now.acceleration(body)[0], now.alpha(body)[0]] for body in system.bodies])
    assert max(now.force(f"front {side} tyre").saturation[0] for side in ("left", "right")) > 0.95
    assert known == pytest.approx(ours, abs=1e-8)


@pytest.mark.slow
def test_bicycle_of_the_files():
    """M1 of the nonlinear benchmark over 5 s: rolling wheels against the file, which no engine made."""
    errors = [case_error("bicycle_M1", steps) for steps in (2000, 4000)]
    # the weave of 3.4 rad/s in steps of 1.25 ms: h^2 w^2 / 12 is 1.5e-6 of the way, 3e-5 m of 20 m
    assert 1.8 < np.log2(errors[0] / errors[1]) < 2.2 and errors[1] < 1e-4


def test_redundant_rows():
    """Counted as in the file; solved with full pivoting, without reactions; refused by the dense solver."""
    case = cases.load("door_two_hinges", shift=2)
    made = twin(case.system)
    found = made.degrees_of_freedom()
    assert found["redundantConstraints"] == case.dof_info["redundant"] == 5
    assert found["degreeOfFreedom"] == case.dof_info["dof"]
    assert "full-pivot" in made.settings and "GeneralizedAlpha" in made.settings
    with pytest.raises(EngineFailed, match="singular.*linear='full-pivot'"):
        twin(case.system, solver="index2", linear="dense").run(0.5, 64, 4)


@pytest.mark.slow
def test_counts_of_all_cases():
    """Exudyn's rows, redundancy and freedom are those of the files."""
    for name in cases.names():
        case = cases.load(name)
        if case.dof_info:
            found = twin(case.system).degrees_of_freedom()
            counts = found["nAE"] - found["nPureAE"], found["redundantConstraints"], found["degreeOfFreedom"]
            assert counts == tuple(case.dof_info[key] for key in ("rows", "redundant", "dof")), name


@pytest.mark.parametrize("settings", [{"solver": "index2"}, {"solver": "rk44", "formulation": "kinematic tree"}])
def test_parts_as_built(settings):
    """Points and axes that differ on both sides: the frames of each side are its own."""
    rng = np.random.default_rng(12)
    a, b = random_body(rng, "a"), random_body(rng, "b")
    axes = [direction(rng) for _ in range(2)]
    off = [axis + 0.03 * direction(rng) for axis in axes]
    at = [body.position + 0.3 * direction(rng) for body in (a, b)]
    hinge = Revolute(GROUND, a, at=at[0], axis=axes[0], at_b=at[0] + 0.05 * direction(rng), axis_b=off[0])
    guide = Prismatic(b, a, at=at[1], axis=axes[1], at_b=at[1] + 0.05 * direction(rng), axis_b=off[1])
    system = System([a, b], [hinge, guide])
    state = simulate(system, 0.2, state=system.assemble(), rtol=1e-11, output=2).final
    made, _ = judge(system, state, state.t + 0.3, **settings)
    check_start(system, state, made)


def test_planetary_gears():
    """A planet between a helical sun and a ring that is the ground, on a turning carrier: motion and tooth forces."""
    rng = np.random.default_rng(3)
    axis, at = direction(rng), np.array([0.1, 0.2, 0.3])
    out = across(rng, axis)
    sun, carrier, planet = (random_body(rng, name) for name in ("sun", "carrier", "planet"))
    hub = Revolute(GROUND, sun, at=at, axis=axis)
    arm = Revolute(GROUND, carrier, at=at + 0.1 * axis, axis=axis)
    pin = Revolute(carrier, planet, at=at + 0.5 * out, axis=axis)
    inner = GearMesh(hub, pin, at=at + 0.3 * out, carrier=carrier, helix_angle=0.2, name="inner")
    outer = GearMesh(arm, pin, at=at + 0.7 * out, carrier=carrier, name="outer")
    system = System([sun, carrier, planet], [hub, arm, pin, inner, outer])
    state = moving(system)
    made, fine = judge(system, state, state.t + 0.2, solver="index2")
    check_start(system, state, made)
    assert {"inner", "outer"} < set(fine.reactions)
