"""Tables of rows from plans that mechanisms share: the numbers of each, and no trace of the one before."""

import numpy as np
import pytest
from helpers.study_models import four_bar

from mbsd3d import GROUND, Body, Joint, Kinematic, Revolute, Spherical, SpringDamper, System, simulate, sweep
from mbsd3d.equations import plans, tree
from mbsd3d.errors import InputError
from mbsd3d.mechanism.primitives import coincide
from validation.cases.examples import mechanism
from validation.cases.inline_four import CRANK_RATE, block_force, inline_four
from validation.cases.loops import FAMILIES

PLANS = [plans.plan_of]
PLANS += [tree.spanning_tree, tree.loop_plan, tree.planned_tables]
ROUNDING = 4e-16  # of the largest term of R'(p - r)


def forget():
    """As in a new process."""
    for plan in PLANS:
        plan.cache_clear()


def engine(seed):
    """Engines of other strokes and rods."""
    rng = np.random.default_rng(seed)
    return inline_four(rng.uniform(0.5, 1.0), rng.uniform(1.5, 4.0), rod_mass=rng.uniform(1.0, 5.0))


def numbers(build, seed):
    """All tables, the start, and all samples of a short run, as bytes."""
    system = build(seed)
    settings = {"method": Kinematic(), "output": 9} if build is engine else {"rtol": 1e-6, "output": 5}
    motion = simulate(system, 0.2 * 2 * np.pi / CRANK_RATE, **settings)
    loads = [block_force(motion)] if build is engine else [motion.reaction(joint).force for joint in system.joints]
    return as_bytes([*system.lowered.model, *motion.arrays.values(), motion.final.q, motion.final.v, *loads])


def as_bytes(arrays):
    return [np.asarray(x).tobytes() for x in arrays]


@pytest.mark.parametrize("name", ["engine", *FAMILIES])
def test_mechanisms_alike_share_a_plan_and_no_number(name):
    """To the last bit as in a new process, whichever of the same structure came before."""
    build = engine if name == "engine" else lambda seed: FAMILIES[name](np.random.default_rng(seed))
    forget()
    alone = numbers(build, 2)
    forget()
    before = build(1)
    tables = as_bytes(before.lowered.model)
    assert numbers(build, 2) == alone
    assert as_bytes(before.lowered.model) == tables
    assert plans.plan_of.cache_info().misses == 1


@pytest.mark.parametrize("seed", range(12))
def test_tables_hold_each_vector_in_the_axes_of_its_body(seed):
    """Part by part, by the definition: every kind of joint, no axis aligned; what no primitive has stays zero."""
    system = mechanism(seed)
    model, bodies = system.lowered.model, [*system.bodies, GROUND]
    rows = [row for joint in system.joints for row in joint.primitives]
    for row, line in zip(rows, model.primitive, strict=True):
        used = len(row.bodies)
        assert [bodies[i] for i in line["body"][:used]] == list(row.bodies) and (line["body"][used:] == -1).all()
        for name, given in (("point", row.points), ("axis", row.axes), ("second_axis", row.second_axes)):
            read = "local_point" if name == "point" else "local_axis"
            expected = np.zeros((4, 3))
            for slot, (body, x) in enumerate(zip(row.bodies, given, strict=False)):
                expected[slot] = getattr(body, read)(x)
            size = max([1.0, *(np.abs(x).max() for x in given)])
            np.testing.assert_allclose(line[name], expected, rtol=0, atol=8 * ROUNDING * size)
    assert model.row.size == sum(row.n_rows for row in rows)
    scales = np.repeat([1.0 / model.length if row.in_metres else 1.0 for row in rows], [row.n_rows for row in rows])
    assert (model.row["scale"] == scales).all()


class Astray(Joint):
    """A joint whose rows are not numbers."""

    def __init__(self, a, b, at):
        super().__init__()
        for name, value in (("a", a), ("b", b), ("at", at)):
            object.__setattr__(self, name, value)

    def check(self, what):
        pass

    def rows(self):
        return [coincide(self.a, self.b, self.at, self.at)]


def test_rows_that_are_no_numbers_are_refused():
    rod = Body("rod", mass=1.2, inertia=(0.2, 0.3, 0.25), com=(0.1, 0.2, 0.3), position=(0.4, -0.1, 0.7))
    hinge = Revolute(GROUND, rod, at=(0.1, 0.2, 0.3), axis=(1, 2, 2))
    system = System([rod], [hinge, Astray(GROUND, rod, np.array([0.0, np.nan, 1.0]))])
    with pytest.raises(InputError, match="points of rows: .* is not finite"):
        system.lowered  # noqa: B018  # made when it is asked for


def changing(k):
    """A slider whose structure depends on k: with a spring or without, of three or of five joints."""
    one = Body("one", 1.0 + 0.1 * k, (0.1, 0.2, 0.15), com=(0.05, 0.02, -0.1), position=(0.3, 0.1, 0.2))
    hinge = Revolute(GROUND, one, at=(0.1, 0.0, 0.3), axis=(1.0, 2.0, 0.1 * k))
    if k % 3 == 1:
        return System([one], [hinge])
    spring = SpringDamper(GROUND, one, at_a=(0, 0, 1), at_b=(0.3, 0.1, 0.1 + 0.01 * k), stiffness=30.0 + k)
    if k % 3 == 2:
        return System([one], [hinge], [spring])
    other = Body("other", 0.7, (0.1, 0.1, 0.2), position=(0.9, 0.2, 0.1))
    return System([one, other], [hinge, Spherical(one, other, at=(0.5, 0.1, 0.2 + 0.01 * k))], [spring])


def last(solution):
    return {"q": solution.final.q[:7]}


@pytest.mark.parametrize("executor", ["threads", "processes"])
def test_structures_may_change_within_a_sweep_and_cells_may_fail(executor):
    run = {"t_end": 0.1, "rtol": 1e-6, "output": 2}
    table = sweep(failing, {"k": np.arange(8)}, last, run=run, executor=executor)
    assert [bool(text) for text in table["error"].values] == [k == 5 for k in range(8)]
    for k in (0, 1, 2, 3, 4, 6, 7):
        forget()
        alone = simulate(changing(k), progress=False, **run)
        assert (table["q"].values[k] == alone.final.q[:7]).all()


def failing(k):
    return changing(k) if k != 5 else System([Body("none", -1.0, (1, 1, 1))])


def test_velocities_of_redundant_loops_are_those_of_the_dense_equations():
    """Four hinges in a plane, of which three rows repeat others; with a rate asked for the start is solved densely."""
    system = four_bar(0.4, 1.0, 0.8, 0.5, 0.2, 2.3)
    rate = 2.3 - 1.1
    found, dense = system.state(), system.assemble(rates={"drive": rate})
    np.testing.assert_allclose(found.v, dense.v, rtol=0, atol=1e-13 * rate)  # both solve to rounding
