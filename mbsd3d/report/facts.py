"""Contents of a report: facts, tables and sentences about a run as plain text; no layout."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, TypeVar

import numpy as np

from ..base.wording import counted, digits, triple
from ..constraints.redundancy import Diagnosis
from ..mechanism.drivers import Driver
from ..mechanism.joints import Joint
from ..results.checks.check import scales_of
from ..results.columns import columns_of_effort, loads_of
from ..results.result import RunResult

TABLE_ROWS_MAX = 40  # [1] rows of a table
ROW_ANALYSIS_COST_MAX = 1e7  # [1] bodies cubed times samples whose redundant rows are decomposed: some seconds
LOAD_COST_MAX = 3e5  # [1] samples times forces whose loads are computed: some seconds
UNIQUENESS_WORDS = {"all": "determined", "part": "determined in part", "none": "indeterminate"}
Listed = TypeVar("Listed")
REACTION_COST_MAX = 1e7  # [1] bodies times samples times joints whose reactions are computed: some seconds


@dataclass(frozen=True)
class Table:
    """Rows of texts under a head, with a note below; the first ``words`` columns are words, the others numbers."""

    caption: str
    head: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]
    words: int = 1
    note: str = ""


def shortened(parts: Iterable[Listed], what: str) -> tuple[list[Listed], str]:
    """Return the first parts of a long list, and a sentence on its length."""
    parts = list(parts)
    more = len(parts) - TABLE_ROWS_MAX
    note = f"The first {TABLE_ROWS_MAX} of {len(parts)} {what}, and {more} more." if more > 0 else ""
    return parts[:TABLE_ROWS_MAX], note


def run_facts(solution: RunResult) -> list[tuple[str, str]]:
    """Return model, method and settings of a run; without its run time, so that the same run gives the same report."""
    record, system, t = solution.record, solution.system, solution.t
    adaptive = record.method.dt is None and not record.kinematic
    first, last = digits(t[0], count=6), digits(t[-1], count=6)
    span = first if t.size == 1 else f"{first} … {last}"
    facts = [
        ("model", ", ".join([counted(len(system.bodies), "body"), counted(len(system.joints), "joint"),
                             counted(len(system.forces), "force")])),
        ("gravity", f"{triple(system.gravity)} m/s²"),
        ("time", f"{span} s, {counted(t.size, 'sample')}"),
        ("method", method_text(record.method) + (f", rtol {digits(record.rtol)}" if adaptive else "")),
        ("steps", f"{record.steps} accepted, {record.rejected} rejected, with "
                  f"{counted(record.evaluations, 'evaluation')} of the equations"),
    ]  # fmt: skip
    if record.tolerance:
        misfit = record.tolerance * solution.compiled.model.length
        facts.append(("tolerance", f"redundant rows may be violated by {digits(misfit)} m as built"))
    return [*facts, ("stabilisation", record.switches.stabilisation)]


def method_text(method: Any) -> str:
    """Return a method with its settings that are not defaults."""
    chosen = [(x.name, getattr(method, x.name)) for x in fields(method) if getattr(method, x.name) != x.default]
    return " ".join([type(method).__name__, ", ".join(f"{name} = {value}" for name, value in chosen)]).strip()


def warnings(solution: RunResult) -> list[str]:
    """Return caveats about the numbers, as sentences."""
    record, found = solution.record, []
    terms = {
        "gyroscopic": "the gyroscopic term w × I w",
        "centripetal": "the centripetal term m w × (w × s)",
        "gamma": "the term −J_dot v of the acceleration rows",
    }
    for switch, term in terms.items():
        if not getattr(record.switches, switch):
            found.append(f"Switched off: {term}. The real mechanism moves otherwise.")
    if record.switches.stabilisation != "projection":
        found.append(f"The joints are held by stabilisation “{record.switches.stabilisation}”, not by projection.")
    if record.stopped_by:
        ended = "The run was" if record.stopped_by.startswith("interrupted") else "The run was stopped by"
        found.append(f"{ended} {record.stopped_by}.")
    if record.kinematic:
        found.append(
            "The drivers determine the motion: it was solved, not integrated, so no energy balance is checked."
        )
    if solution.t.size == 1:
        found.append("There is a single sample: values at one instant, no curves.")
    return found


def body_table(solution: RunResult) -> Table:
    """Return the mass properties of the bodies and their largest speeds."""
    bodies, note = shortened(solution.system.bodies, "bodies")
    length, v = solution.compiled.model.length, solution.arrays["v"]
    v = np.linalg.norm(v.reshape(*v.shape[:2], 2, 3), axis=3)
    fastest, rows = v.max(axis=(0, 1)), []
    for body in bodies:
        reached = v[:, solution.system.bodies.index(body)].max(axis=0)
        speed, spin = (digits(x, size) for x, size in zip(reached, fastest, strict=True))
        moments = triple(np.linalg.eigvalsh(body.inertia))
        rows.append((body.name, digits(body.mass), triple(body.com, length), moments, speed, spin))
    head = ("body", "mass [kg]", "centre of mass [m]", "principal moments [kg m²]", "speed [m/s]", "turning [rad/s]")
    text = (
        "Centre of mass from the reference point, body axes; moments about it. Largest speed of that point and rate of "
        f"turning. {note}"
    )
    return Table("Bodies", head, rows, note=text.strip())


def loaded_joints(solution: RunResult) -> tuple[list[Joint], str]:
    """Return all joints but drivers, or of many those with the largest multipliers, and a sentence on the choice."""
    joints = [joint for joint in solution.system.joints if not isinstance(joint, Driver)]
    if len(joints) <= TABLE_ROWS_MAX:
        return joints, ""
    lam = np.abs(solution.arrays["lam"]).max(axis=0, initial=0.0)
    load = [lam[solution.compiled.rows[id(joint)]].max(initial=0.0) for joint in joints]
    chosen = sorted(range(len(joints)), key=lambda k: (-load[k], k))[:TABLE_ROWS_MAX]
    text = f"The {TABLE_ROWS_MAX} of {len(joints)} joints with the largest multipliers, "
    text += f"and {len(joints) - TABLE_ROWS_MAX} more."
    return [joints[k] for k in sorted(chosen)], text


def thinned(solution: RunResult) -> tuple[RunResult, str]:
    """Return the solution with so few samples that its reactions and loads take seconds, and a sentence on the choice.

    Where constraints leave shares open, the rows are decomposed at every sample.
    """
    samples, bodies = solution.t.size, len(solution.system.bodies)
    steps = samples * bodies * min(len(solution.system.joints), TABLE_ROWS_MAX) / REACTION_COST_MAX
    steps = max(steps, samples * min(len(solution.system.forces), TABLE_ROWS_MAX) / LOAD_COST_MAX)
    if solution.record.rows_left_out != 0 and len(solution.system.joints):
        steps = max(steps, samples * bodies**3 / ROW_ANALYSIS_COST_MAX)
    step = min(int(np.ceil(steps)), samples)
    if step <= 1:
        return solution, ""
    arrays = {name: values[::step] for name, values in solution.arrays.items()}
    return replace(solution, arrays=arrays), f"From one sample in {step}, to save time."


def largest_load(values: np.ndarray, t: np.ndarray, size: float) -> tuple[str, str]:
    """Return the largest magnitude of a vector over time, and its time [s]."""
    norms = np.linalg.norm(values, axis=1)
    k = int(np.argmax(norms))
    text = digits(float(norms[k]), size)
    return text, digits(float(t[k])) if text != "0" else "–"


def joint_table(solution: RunResult, few: RunResult, diagnosis: Diagnosis) -> Table:
    """Return joints, their redundant rows, and their largest reactions."""
    joints, cut = loaded_joints(solution)
    scale, system, rows = scales_of(solution), solution.system, []
    shares = {share.joint: share for share in diagnosis.shares}
    for joint in joints:
        reaction, name = few.reaction(joint), system.name(joint)
        share = shares.get(f"{type(joint).__name__} '{name}'")
        n_rows = sum(row.n_rows for row in joint.primitives)
        repeated = f"{share.involved} of {n_rows}" if share else f"0 of {n_rows}"
        (forces, of_force), (moments, of_moment) = reaction.shown("force"), reaction.shown("moment")
        pushed, turned = largest_load(forces, few.t, scale.force), largest_load(moments, few.t, scale.moment)
        known = (
            UNIQUENESS_WORDS[of_force]
            if of_force == of_moment
            else f"force {UNIQUENESS_WORDS[of_force]}, moment {UNIQUENESS_WORDS[of_moment]}"
        )
        between = " – ".join("ground" if body is None else body.name for body in (joint.a, joint.b))
        rows.append((name, type(joint).__name__, between, known, repeated, *pushed, *turned))
    loads = ("force [N]", "at [s]", "moment [N\u00a0m]", "at [s]")
    head = ("joint", "type", "between", "reaction", "redundant rows", *loads)
    text = "Largest reactions on the second body, at the joint's point."
    if any("in part" in row[3] for row in rows):
        text += " Of those determined in part it is this part."
    if any("indeterminate" in row[3] for row in rows):
        text += " Indeterminate ones are shares of least norm: the stiffness of the parts decides, not the model."
    return Table("Joints and their largest reactions", head, rows, words=4, note=" ".join(filter(None, [text, cut])))


def driver_table(solution: RunResult, few: RunResult) -> Table:
    """Return drivers: their work and the largest drive force or torque."""
    drivers, note = shortened((joint for joint in solution.system.joints if isinstance(joint, Driver)), "drivers")
    scale, rows = scales_of(solution), []
    for driver in drivers:
        work = digits(float(solution.work(driver)[-1]), scale.energy)
        for k, column in enumerate(columns_of_effort(few, driver)):
            size = scale.force if column.unit == "N" else scale.moment
            effort, when = largest_load(column.values[:, None], few.t, size)
            rows.append((column.part, type(driver).__name__, f"{effort} {column.unit}", when, work if k == 0 else ""))
    head = ("driver", "type", "largest effort", "at [s]", "work [J]")
    return Table("Drivers", head, rows, words=2, note=note)


def force_table(solution: RunResult, few: RunResult) -> Table:
    """Return force elements: their stored energy, their work, and their largest loads."""
    forces, note = shortened(solution.system.forces, "forces")
    scale, rows = scales_of(solution), []
    for force in forces:
        stored = solution.arrays["potential"][:, solution.system.forces.index(force)]
        work = float(solution.work(force)[-1])
        on = " – ".join(body.name for body in force.bodies())
        joules = [digits(x, scale.energy) for x in (float(stored.min()), float(stored.max()), work)]
        load = next(iter(loads_of(few, force).values()), None)
        largest = ("–",) * 4
        if load is not None:
            largest = (*largest_load(load.force, few.t, scale.force), *largest_load(load.moment, few.t, scale.moment))
        rows.append((solution.system.name(force), type(force).__name__, on, *joules, *largest))
    loads = ("force [N]", "at [s]", "moment [N\u00a0m]", "at [s]")
    head = ("force", "type", "on", "least energy [J]", "greatest [J]", "work [J]", *loads)
    text = "Largest loads on the second body, at the point of the element there."
    return Table("Forces", head, rows, words=3, note=" ".join(filter(None, [text, note])))


def tables(solution: RunResult, few: RunResult, diagnosis: Diagnosis) -> list[Table]:
    """Return the tables of all parts; ``few`` has the samples with reactions."""
    parts = [joint_table(solution, few, diagnosis), driver_table(solution, few), force_table(solution, few)]
    return [table for table in (body_table(solution), *parts) if table.rows]


def freedom_facts(diagnosis: Diagnosis) -> list[tuple[str, str]]:
    """Return counts and rank of `System.check`."""
    d = diagnosis
    facts = [
        ("assessment", d.verdict),
        ("velocities", f"{d.velocities} of {counted(d.coordinates // 7, 'body')}"),
        ("constraint rows", f"{d.rows}, of rank {d.rank}: {d.redundant} redundant"),
        ("mobility", f"degrees of freedom: {d.mobility} of velocity, {d.configuration_freedom} of position"),
        ("Gruebler count", f"{d.gruebler}".replace("-", "−") + (" (does not see geometry)" if d.redundant else "")),
    ]
    facts += [("remedy", cure.text) for cure in d.cures[:3]]
    return [*facts, *(("note", text) for text in d.notes)]


def drift_facts(solution: RunResult) -> list[tuple[str, str]]:
    """Return the largest residuals of the joints, and the energy balance in joules."""
    drift, energy = solution.drift(), solution.energy()
    facts = []
    if solution.compiled.model.row.size:
        for name, values, unit in (("gap", drift.position, "m or rad"), ("slip", drift.velocity, "m/s or rad/s")):
            k = int(np.argmax(values))
            facts.append(
                (f"largest {name}", f"{digits(float(values[k]), count=2)} {unit} at {digits(solution.t[k])} s")
            )
    if not solution.record.kinematic and solution.t.size > 1:
        size = scales_of(solution).energy
        gained, work = (float(x[-1] - x[0]) for x in (energy.total, energy.work))
        did = f"drivers and other forces did {digits(work, size)} J of work"
        left = digits(gained - work, count=2)
        facts.append(("energy", f"changed by {digits(gained, size)} J; {did}; left over {left} J"))
    return facts
