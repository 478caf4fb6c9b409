"""Cost of spatial coordinates: run-time ratio of planar mechanisms solved in space to a planar solver of equal
tolerance.

``python -m validation.benchmark.planar_cost`` measures slider-crank, four-bar and inline four of `planar_pairs` in one
process, all forms in turns, round by round, so that a busy moment falls on all. Times are those of the compiled loops,
which last about a millisecond, medians over many rounds; beside the ratio of medians is the ratio of least times,
which is the same on an idle machine. Trust ratios, not times.

Both solvers run Runge-Kutta of order 4 and close the joints after every step. In space a body has seven coordinates
and six velocities instead of three and three, and a hinge five rows instead of two.
"""

import json
import os
import time
from collections.abc import Callable
from typing import NamedTuple

import click
import numpy as np

from engines import planar
from mbsd3d import DOP853, RK4, Kinematic, simulate, sweep
from validation.benchmark.planar_pairs import Floor, Mechanism, mechanisms, noise_floors
from validation.cases import inline_four as engine
from validation.machine import machine

ROUND_COUNT = 100  # [1] of all forms in turns
TURN_STEP = 1 / 400  # [1] of a turn of the crank
BODY_STEPS = 150  # [1] bodies x steps of a run at a fixed step
POSITION_ERROR_MAX = 1e-8  # [1] of the largest distance from the origin: position error after a turn
RATIO_GOAL, SWEEP_GOAL, FLOOR_GOAL = 8.0, 5.0, 1e-12  # at most; [-], [s], [-]
SWEEP_CELLS = 30  # [1] cells of the design sweep, squared
FORMS = {
    "plane": ("plane", {}),
    "space": ("space", {}),
    "space, redundant": ("space", {"redundant": True}),
    "plane, O = G": ("plane", {"centroidal": True}),
    "space, O = G": ("space", {"centroidal": True}),
}


class Cost(NamedTuple):
    """Cost of one form of a mechanism at a fixed step."""

    mechanism: str
    form: str
    per_second: float  # Median seconds of the loop per simulated second
    per_evaluation: float  # The same per evaluation [s]; 4 a step and one at the end
    ratio: float  # To the planar solver; of forms with O = G to the same form with O off G
    least: float  # The same ratio of the least times


class Accuracy(NamedTuple):
    """Cost of one turn at an error of at most `POSITION_ERROR_MAX`."""

    mechanism: str
    form: str
    setting: str
    error: float
    per_second: float
    ratio: float
    least: float


class Tax(NamedTuple):
    """All measurements of the cost of spatial coordinates."""

    machine: str
    costs: list[Cost]
    accuracies: list[Accuracy]
    floors: list[Floor]
    sweep: dict[str, float]


def runner(mechanism: Mechanism, form: str, setting: float, part: float = 1.0) -> Callable:
    """Return a function that runs a part of a turn and returns (seconds of the loop, (n, 2) last positions).

    ``setting`` is a number of steps of RK4 per turn, or a tolerance below 1 of DOP853.
    """
    kind, options = FORMS[form]
    system, t_end = getattr(mechanism, kind)(**options), part * mechanism.turn
    names = [link.name for link in mechanism.links]
    start = system.state() if kind == "space" else None
    method, rtol = (RK4(mechanism.turn / setting), 1e-8) if setting >= 1 else (DOP853(), setting)

    def run() -> tuple[float, np.ndarray]:
        if kind == "plane":
            flat = planar.simulate(system, t_end, dt=mechanism.turn / setting, output=2)
            return flat.seconds, np.array([flat.position(name)[-1] for name in names])
        solution = simulate(system, t_end, state=start, method=method, rtol=rtol, output=2)
        return solution.record.loop_seconds, np.array([solution.position(name)[-1, :2] for name in names])

    return run


def interleaved(runs: list[Callable], rounds: int) -> np.ndarray:
    """Return the seconds of all runs, taken in turns, shape (rounds, runs); a first round, left out, compiles."""
    return np.array([[run()[0] for run in runs] for _ in range(rounds + 1)])[1:]


def fixed_step(mechanism: Mechanism, rounds: int = ROUND_COUNT) -> list[Cost]:
    """Measure the cost of all forms at one fixed step."""
    steps = BODY_STEPS // len(mechanism.links)
    seconds = interleaved([runner(mechanism, form, 1 / TURN_STEP, steps * TURN_STEP) for form in FORMS], rounds)
    found, simulated = [], steps * TURN_STEP * mechanism.turn
    for k, form in enumerate(FORMS):
        peer = 0 if k < 3 else k - 3
        cost, ratio, least = against(seconds, k, peer)
        found.append(Cost(mechanism.name, form, cost / simulated, cost / (4 * steps + 1), ratio, least))
    return found


def against(seconds: np.ndarray, k: int, peer: int) -> tuple[float, float, float]:
    """Return (median, ratio to the median of the peer, ratio of the least times) of column k."""
    middle, least = np.median(seconds, axis=0), seconds.min(axis=0)
    return float(middle[k]), float(middle[k] / middle[peer]), float(least[k] / least[peer])


def equal_accuracy(mechanism: Mechanism, rounds: int = ROUND_COUNT) -> list[Accuracy]:
    """Measure the cost at equal accuracy: RK4 in the plane and in space at their own least steps, DOP853 in space.

    The truth is DOP853 at 1e-13 in space; the planar runs come to it without any of its code.
    """
    truth = runner(mechanism, "space", 1e-13)()[1]
    size = max(np.abs(link.origin).max() for link in mechanism.links)

    def loosest(form: str, settings: np.ndarray) -> tuple[str, float, float]:
        """Return (form, setting, error) of the last setting, from the tight side, before the error grows too large."""
        found = form, settings[0], np.inf
        for setting in settings:
            error = float(np.abs(runner(mechanism, form, setting)()[1] - truth).max() / size)
            if error > POSITION_ERROR_MAX:
                break
            found = form, setting, error
        return found

    counts = np.round(2.0 ** np.arange(10.0, 4.0, -0.25))
    chosen = [loosest("plane", counts), loosest("space", counts), loosest("space", 10.0 ** np.arange(-9.0, -4.0, 0.25))]
    seconds = interleaved([runner(mechanism, form, setting) for form, setting, _ in chosen], rounds)
    rows = []
    for k, (form, setting, error) in enumerate(chosen):
        word = f"RK4, {setting:.0f} steps a turn" if setting >= 1 else f"DOP853, rtol {setting:.1e}"
        cost, ratio, least = against(seconds, k, 0)
        rows.append(Accuracy(mechanism.name, form, word, error, cost / mechanism.turn, ratio, least))
    return rows


def design_sweep(cells: int = SWEEP_CELLS) -> dict[str, float]:
    """Return the seconds of cells^2 spatial inline fours with `Kinematic` on all cores, the start of processes
    included.
    """
    grid = {"radius": np.linspace(0.5, 1.0, cells), "rod_length": np.linspace(1.5, 4.0, cells)}
    run = {"t_end": 2 * np.pi / engine.CRANK_RATE, "method": Kinematic(), "output": engine.TURN_SAMPLES + 1}
    began, before = time.perf_counter(), os.times()
    table = sweep(engine.inline_four, grid, engine.orders, run=run, executor="processes", progress=False)
    wall, after = time.perf_counter() - began, os.times()
    busy = sum(after[:4]) - sum(before[:4])
    return {"cells": cells**2, "failed": int(table.attrs["failed"]), "seconds": wall, "processor": busy}


def measure(rounds: int = ROUND_COUNT, cells: int = SWEEP_CELLS) -> Tax:
    """Measure everything, in one process."""
    costs = [row for mechanism in mechanisms() for row in fixed_step(mechanism, rounds)]
    accuracies = [row for mechanism in mechanisms() for row in equal_accuracy(mechanism, rounds)]
    return Tax(machine("numpy", "numba"), costs, accuracies, noise_floors(), design_sweep(cells))


def verdicts(tax: Tax) -> list[tuple[str, float, float, bool]]:
    """Return (what, measured, goal, whether it is met)."""
    spatial = [row.ratio for row in tax.costs if row.form in ("space", "space, redundant")]
    floor = max(value for row in tax.floors for value in row[2:] if value is not None)
    rows = [
        ("largest ratio space / plane, equal step", max(spatial), RATIO_GOAL),
        ("largest noise floor", floor, FLOOR_GOAL),
        (f"seconds of {tax.sweep['cells']} designs", tax.sweep["seconds"], SWEEP_GOAL),
    ]
    return [(what, value, goal, bool(value <= goal)) for what, value, goal in rows]


def lines(tax: Tax) -> list[str]:
    """Return the lines of the table."""
    said = [tax.machine, "", f"RK4, a step of {TURN_STEP:g} turns, medians of the compiled loop"]
    said.append(f"{'':34}{'ms per s':>9}{'us/eval.':>10}{'ratio':>7}{'least':>7}  against")
    for row in tax.costs:
        peer = "plane" if "O = G" not in row.form else row.form.split(",")[0]
        said.append(
            f"{row.mechanism:14}{row.form:20}{1e3 * row.per_second:9.3f}{1e6 * row.per_evaluation:10.2f}"
            f"{row.ratio:7.2f}{row.least:7.2f}  {peer}"
        )
    said += ["", f"Equal accuracy: positions after a turn right to {POSITION_ERROR_MAX:g}"]
    said.append(f"{'':42}{'error':>9}{'ms per s':>10}{'ratio':>7}{'least':>7}")
    said += [
        f"{row.mechanism:14}{row.form:7}{row.setting:21}{row.error:9.1e}{1e3 * row.per_second:10.3f}{row.ratio:7.2f}"
        f"{row.least:7.2f}"
        for row in tax.accuracies
    ]
    said += ["", "Noise floor of 1 - 1 = 0, relative", f"{'':48}{'plane':>9}{'space':>9}{'redundant':>11}"]
    for floor in tax.floors:
        plane = f"{floor.plane:9.1e}" if floor.plane is not None else f"{'-':>9}"
        said.append(f"{floor.mechanism:14}{floor.what:34}{plane}{floor.space:9.1e}{floor.redundant:11.1e}")
    said += ["", "Design sweep"]
    said.append("{cells} inline fours in space: {seconds:.1f} s, {processor:.1f} s of processors".format(**tax.sweep))
    said += ["", f"{'':42}{'measured':>10}{'goal':>9}"]
    for what, value, goal, met in verdicts(tax):
        said.append(f"{what:42}{value:10.3g}{goal:9.3g}  {'met' if met else 'MISSED'}")
    return said


@click.command()
@click.option("--json", "as_json", is_flag=True, help="JSON instead of the table.")
@click.option("--rounds", default=ROUND_COUNT, show_default=True, type=click.IntRange(1), help="Of all forms in turns.")
def main(as_json: bool, rounds: int) -> None:
    """Measure the cost of spatial coordinates against a planar solver; trust ratios, on an idle machine."""
    tax = measure(rounds)
    rows = {key: [row._asdict() for row in getattr(tax, key)] for key in ("costs", "accuracies", "floors")}
    found = [dict(zip(("what", "measured", "goal", "met"), row, strict=True)) for row in verdicts(tax)]
    data = {"machine": tax.machine, **rows, "sweep": tax.sweep, "verdicts": found}
    click.echo(json.dumps(data, indent=1) if as_json else "\n".join(lines(tax)))


if __name__ == "__main__":
    main()


if __name__ == "__main__":
    main(prog_name="python -m validation.benchmark.planar_cost")
