"""The solver of a page: rows, loads and accelerations are those of the kernels, runs those of Python."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.forces import EXAMPLES as FORCES
from helpers.models import EXAMPLES as JOINTS
from helpers.models import example_system, pendulum, random_body, revolute_chain
from helpers.node import run_in_node
from helpers.view import T, terms_of_kernels

from mbsd3d import GROUND, Body, Revolute, Spherical, SpringDamper, System, accelerations, shapes, simulate
from mbsd3d.extend import compile_system, discover, load_state
from mbsd3d.view.explore.drawn import MARKS, parts_of, picture_over
from mbsd3d.view.explore.lowered import lowered, method
from mbsd3d.view.explore.sliders import Slider

AT_A_STATE = """
found = given.map(({model, y, t}) => {
  const x = makeSolver(model, null).at(t, Float64Array.from(y));
  const names = ["c", "J", "b", "gamma", "Q", "h", "acceleration", "ownRate"];
  return {...Object.fromEntries(names.map((name) => [name, Array.from(x[name])])), stored: x.stored, power: x.power};
});
"""
RUN = """
found = given.map(({model, method, times}) => {
  const poses = [], solver = makeSolver(model, method);
  const note = () => poses.push(solver.bodies.slice(0, -1).flatMap(({r, e}) => [...r, ...e]));
  const run = solver.start(times, note, 1e-10);
  while (run.advance(5));
  return {poses, failed: run.failed, gap: run.gap, drift: run.drift / run.scale, ...run.count};
});
"""


def moved(system, seed):
    """A state at general poses off the constraints, with general velocities, at no special time."""
    rng, n, state = np.random.default_rng(seed), len(system.bodies), system.state()
    q = state.q.reshape(n, 7) + 0.1 * rng.standard_normal((n, 7))
    q[:, 3:] /= np.linalg.norm(q[:, 3:], axis=1)[:, None]
    return replace(state, q=q.ravel(), v=3.0 * rng.standard_normal(6 * n), t=T)


def compare(found, known, names):
    """The same numbers to 1e-13: both are the same operations, which compilers may put into another order."""
    for name in names:
        ours = np.ravel(found[name])[: np.size(known[name])]
        size = max(1.0, np.abs(known[name]).max(initial=0.0))
        np.testing.assert_allclose(ours, np.ravel(known[name]), rtol=1e-13, atol=1e-13 * size, err_msg=name)


UNKNOWN = {"CurveContact", "Coupler", "OrientationDriver", "Switched", "Breaks"}


def test_rows_of_every_joint_are_those_of_the_kernels():
    cases, known = [], []
    for cls in JOINTS:
        system = example_system(cls, 2)
        if cls.__name__ in UNKNOWN:
            with pytest.raises(ValueError, match="leave out the sliders"):
                lowered(system, system.state())
            continue
        case, rows = terms_of_kernels(system, moved(system, 5))
        cases.append(case), known.append(rows)
    assert len(cases) > 25
    for found, rows in zip(run_in_node(("solver.js",), AT_A_STATE, cases), known, strict=True):
        assert np.abs(rows["J"]).max() > 0.1 and np.abs(rows["gamma"]).max() > 0.1  # general numbers are compared
        compare(found, rows, ("c", "J", "b", "gamma", "h"))


def test_loads_of_every_force_are_those_of_the_kernels():
    cases, known, seen = [], [], set()
    for name in FORCES:
        rng = np.random.default_rng(7)
        bodies = [random_body(rng, "one"), random_body(rng, "two")]
        joints, force = FORCES[name](rng, *bodies)
        system = System(bodies, joints, [force], gravity=(0, 0, 0))
        try:
            case, found = terms_of_kernels(system, moved(System(bodies), 6))
        except ValueError as error:
            assert "leave out the sliders" in str(error)
            continue
        seen.add(type(force).__name__)
        cases.append(case), known.append(found)
    assert seen == {"AeroDrag", "Bushing", "CentralGravity", "Contact", "Force", "JointFriction", "SpringDamper",
                    "Torque", "TorsionSpring", "Tyre", "Weight"}  # fmt: skip
    for found, values in zip(run_in_node(("solver.js",), AT_A_STATE, cases), known, strict=True):
        assert np.abs(values["Q"]).max() > 0.01
        compare({**found, "work": found["power"]}, values, ("Q", "stored", "work", "ownRate"))


def loop(seed=3):
    """Four general bodies on hinges, whose last one hangs on a ball of the ground, with a damped spring across."""
    chain = revolute_chain(4, seed)
    first, last = chain.bodies[0], chain.bodies[-1]
    ball = Spherical(GROUND, last, at=last.centre + 0.2)
    ends = {"at_a": first.centre + 0.1, "at_b": last.centre - 0.1}
    return System(chain.bodies, [*chain.joints, ball], [SpringDamper(first, last, **ends, stiffness=40.0, damping=0.3)])


@pytest.mark.parametrize("term", [None, "gyroscopic", "centripetal", "gamma"])
def test_accelerations_are_those_of_the_kernels_with_and_without_a_term(term):
    """Equal to 1e-9: S is solved to 1e-12 of its diagonal, and both errors grow by its condition."""
    system, terms = loop(), {} if term is None else {term: False}
    state = simulate(system, 0.5).state(-1)
    known = accelerations(system, state, **terms)
    y = load_state(compile_system(system), compile_system(system).data(), state)
    model = {**lowered(system, state), "terms": terms}
    (found,) = run_in_node(("solver.js",), AT_A_STATE, [{"model": model, "y": [*y[: 13 * 4], 0.0], "t": state.t}])
    ours = np.array(found["acceleration"]).reshape(-1, 6)
    for i, body in enumerate(system.bodies):
        alpha = known.alpha(body)[0]
        np.testing.assert_allclose(ours[i, 3:], alpha, rtol=1e-9, atol=1e-9 * np.linalg.norm(alpha))


def test_bodies_without_mass_or_with_a_flat_inertia_move_as_in_python():
    """A coupler without mass and a bar without thickness between two bodies; equal to 1e-9, as the others are."""
    rng, chain = np.random.default_rng(4), revolute_chain(4, 6)
    bare = [
        replace(chain.bodies[1], mass=0.0, inertia=(0.0, 0.0, 0.0)),
        replace(chain.bodies[2], inertia=np.diag([0.0, 0.3, 0.3])),
    ]
    bodies = [chain.bodies[0], *bare, chain.bodies[3]]
    moved_to = dict(zip(map(id, chain.bodies), bodies, strict=True))
    joints = [replace(x, a=moved_to.get(id(x.a), x.a), b=moved_to[id(x.b)]) for x in chain.joints]
    system = System(bodies, joints, gravity=rng.normal(size=3))
    state = simulate(system, 0.3).state(-1)
    y = load_state(compile_system(system), compile_system(system).data(), state)
    model = lowered(system, state)
    assert [body["light"] for body in model["body"]] == [0, 1, 1, 0]
    (found,) = run_in_node(("solver.js",), AT_A_STATE, [{"model": model, "y": [*y[: 13 * 4], 0.0], "t": state.t}])
    known, ours = accelerations(system, state), np.array(found["acceleration"]).reshape(-1, 6)
    for i, body in enumerate(bodies):
        alpha = known.alpha(body)[0]
        np.testing.assert_allclose(ours[i, 3:], alpha, rtol=1e-9, atol=1e-9 * np.linalg.norm(alpha))


def four_bar(*, reach, lean):
    """Two bars with shapes that depend on numbers, a spring between them, and a hinge on a leaning axis."""
    axis = (np.sin(lean), 0.3, np.cos(lean))
    long = shapes.Box((reach, 0.1, 0.05 + 0.1 * lean**2))
    one = Body("one", 1.0, (1, 1, 1), position=(0.5 * reach, 0, 0), shape=long)
    two = Body("two", 1.0, (1, 1, 1), position=(reach, 0.4 + lean, 0.2), shape=shapes.Cylinder(0.1 * reach, 0.5))
    hinges = [Revolute(GROUND, one, at=(0, 0, 0), axis=axis), Revolute(one, two, at=(reach, 0, 0), axis=axis)]
    spring = SpringDamper(GROUND, two, at_a=(0, lean, 1), at_b=(reach, 0.4 + lean, 0.2), stiffness=3.0)
    return System([one, two], hinges, [spring])


def test_the_picture_follows_the_sliders():
    """At other values too each number is within a thousandth of the picture's size of what is drawn for them."""
    sliders, origin = [Slider("reach", 0.6, 1.4, 1.0), Slider("lean", 0.1, 1.0, 0.3)], np.array([0.1, -0.2, 0.3])
    shapes_over, stale = picture_over(four_bar, sliders, origin)
    assert {x["key"] for x in shapes_over} == {"vertices", "points", "ends"} and stale <= set(MARKS)
    for a, b in np.random.default_rng(3).uniform(-1, 1, (5, 2)):
        known, size = parts_of(four_bar(reach=sliders[0].at(a), lean=sliders[1].at(b)), origin)
        ladders = [np.polynomial.chebyshev.chebvander([x], 12)[0] for x in (a, b)]
        for x in shapes_over:
            found = sum(x["unit"] * ladders[0][i] * ladders[1][j] * np.array(numbers) for (i, j), numbers in x["terms"])
            drawn = known[x["node"], x["key"]]
            if drawn.layer == "joints":  # may be turned about their axes: no farther than they are thick
                found, drawn = (np.sort(np.linalg.norm(y.reshape(-1, 3), axis=1)) for y in (found, drawn.numbers))
                np.testing.assert_allclose(found, drawn, rtol=0, atol=0.03 * size)
            else:
                np.testing.assert_allclose(found, drawn.numbers, rtol=0, atol=2e-3 * size)


def runs(systems, times, **terms):
    """What the page's solver finds of some systems, at its times."""
    given = [
        {"model": {**lowered(x, x.state()), "terms": terms}, "method": method(), "times": times.tolist()}
        for x in systems
    ]
    return run_in_node(("solver.js",), RUN, given)


MECHANISMS = {
    "loop": (loop, 1.0), "pendulum": (lambda: pendulum()[0], 2.0),
    **{name: (discover()[name].mechanism, t) for name, t in (
        ("dzhanibekov", 10.0), ("heavy_top", 1.0), ("spherical_pendulum", 3.0), ("rolling_coin", 3.0), ("door", 2.0),
        ("rssr", 2.0), ("cardan", 2.0), ("bennett", 2.0), ("foucault", 20.0), ("helical_thrust", 1.0),
        ("falling_cat", 0.6), ("propeller_shake", 0.02), ("spinning_egg", 0.3), ("slide_to_roll", 2.0),
        ("wheel_drop", 0.6), ("step_steer", 0.5),
    )},
}  # fmt: skip


@pytest.mark.parametrize("name", MECHANISMS)
def test_runs_are_those_of_python(name):
    """To 1e-6 of the size of the mechanism and radians; joints close to rounding, and energy stays."""
    make, t = MECHANISMS[name]
    system, times = make(), np.linspace(0.0, t, 41)
    known = simulate(system, t, rtol=1e-11, output=times)
    (found,) = runs([system], times)
    assert not found["failed"] and found["gap"] < 1e-12
    length = compile_system(system).model.length
    poses = np.array(found["poses"]).reshape(times.size, -1, 7)
    for i, body in enumerate(system.bodies):
        assert np.abs(poses[:, i, :3] - known.position(body)).max() < 1e-6 * length
        product = np.abs((poses[:, i, 3:] * known.orientation(body)).sum(axis=1))
        assert np.sqrt(np.maximum(1.0 - product.min() ** 2, 0.0)) < 1e-6  # half the angle between both
    kept = 1e-5 if name == "wheel_drop" else 1e-7  # a damper acts at once where it lands: the power jumps within a step
    assert found["drift"] is None or found["drift"] < kept  # None: driven, pose by pose
