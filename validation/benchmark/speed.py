"""Speed of mbsd3d: cost per evaluation compared with MuJoCo, growth with the size, `check`, and the start of a process.

Peers run interleaved, round by round in one process, so that a busy moment falls on both; every figure is the best of
its rounds. Trust ratios, not times.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from mbsd3d import GROUND, RK4, Body, State, System, Tyre, simulate
from mbsd3d.extend import write_atomically
from validation.cases.mechanisms import chain, ladder, mujoco_chain
from validation.machine import machine

ROUND_COUNT = 5
CHAIN_LENGTHS = (3, 10, 30, 100, 300)
STEP_SECONDS, BODY_STEPS = 1e-3, 60_000  # s; bodies x steps of a run: a quarter of a second

FIRST_RESULT_CODE = """
from mbsd3d import GROUND, Body, Spherical, System, simulate
top = Body("top", mass=15.0, inertia=(0.234375, 0.46875, 0.234375), position=(0, 1, 0), omega=(0, 150, -4.61538))
print(simulate(System([top], [Spherical(GROUND, top, at=(0, 0, 0))]), t_end=2.0).position(top)[-1])
"""
IMPORT_CODE = "import numba, numpy, scipy.linalg, scipy.interpolate"


def interleaved(*runs: Callable[[], float], rounds: int = ROUND_COUNT) -> list[float]:
    """Return the least seconds of every run, taken in turns."""
    best = [np.inf] * len(runs)
    for _ in range(rounds):
        best = [min(least, run()) for least, run in zip(best, runs, strict=True)]
    return best


def our_seconds(system: System, start: State, method: RK4, t_end: float) -> float:
    """Return the seconds of the time loop; only both ends are stored."""
    return simulate(system, t_end, state=start, method=method, output=2).record.loop_seconds


def mujoco_seconds(model: object, steps: int) -> float:
    """Return the seconds of `steps` steps from the reference pose, in one call of the compiled loop."""
    import mujoco

    data = mujoco.MjData(model)
    mujoco.mj_step(model, data)  # its first call sets up the work space
    mujoco.mj_resetData(model, data)
    began = time.perf_counter()
    mujoco.mj_step(model, data, steps)
    return time.perf_counter() - began


def per_evaluation(lengths: tuple = CHAIN_LENGTHS) -> list[tuple[int, float, float]]:
    """Return (n, mbsd3d, MuJoCo) with microseconds per body and evaluation of chains: RK4 at one step, mbsd3d with
    projection.
    """
    found = []
    for n in lengths:
        steps = max(BODY_STEPS // n, 20)
        system, twin = chain(n), mujoco_chain(n, STEP_SECONDS)
        start = system.state()
        ours, theirs = interleaved(
            partial(our_seconds, system, start, RK4(STEP_SECONDS), steps * STEP_SECONDS),
            partial(mujoco_seconds, twin, steps),
        )
        found.append((n, 1e6 * ours / (4 * steps * n), 1e6 * theirs / (4 * steps * n)))
    return found


def growth(mechanism: Callable[[int], System], sizes: tuple, steps: int = 50) -> list[tuple[int, float]]:
    """Return (bodies, microseconds per body and evaluation) of a mechanism by its size; RK4 with projection."""
    found = []
    for size in sizes:
        system = mechanism(size)
        start, n = system.state(), len(system.bodies)
        (seconds,) = interleaved(partial(our_seconds, system, start, RK4(STEP_SECONDS), steps * STEP_SECONDS), rounds=3)
        found.append((n, 1e6 * seconds / (4 * steps * n)))
    return found


def exponent(rows: list[tuple]) -> float:
    """Return the exponent p of the whole cost n * (cost per body) ~ n^p, least squares in logarithms."""
    n, cost = np.array([row[0] for row in rows], float), np.array([row[1] for row in rows], float)
    return float(np.polyfit(np.log(n), np.log(n * cost), 1)[0])


def process_time(code: str, repeats: int = ROUND_COUNT, **environment: str) -> tuple[float, float]:
    """Return (wall, processor) seconds of a new Python process that runs ``code``, the fastest one."""
    found = []
    for _ in range(repeats):
        before, began = os.times(), time.perf_counter()
        subprocess.run(
            [sys.executable, "-c", code], env=os.environ | environment, check=True, capture_output=True, timeout=600
        )
        seconds, after = time.perf_counter() - began, os.times()
        busy = after.children_user + after.children_system - before.children_user - before.children_system
        found.append((seconds, busy))
    return min(found)


def compile_time() -> tuple[float, float]:
    """Return (wall, processor) seconds from the start of a process to its first result with an empty kernel cache,
    once.
    """
    with tempfile.TemporaryDirectory() as folder:
        return process_time(FIRST_RESULT_CODE, 1, MBSD3D_CACHE=folder)


def check_seconds(system: System) -> float:
    """Return the seconds of a whole `check`: mobility, redundant rows, remedies."""
    began = time.perf_counter()
    system.check()
    return time.perf_counter() - began


def tyre_seconds(wheels: int = 8, rounds: int = 25) -> float:
    """Return the time a tyre adds to an evaluation of its wheel [s], its two states included: least times of RK4, in
    turns.
    """
    rolling = [
        Body(f"wheel {k}", 8.0, (0.3, 0.5, 0.3), position=(0, k, 0.3), velocity=(5.0, 0.1, 0), omega=(0.01, 16.0, 0.1))
        for k in range(wheels)
    ]
    usual: dict[str, Any] = {
        "radius": 0.305,
        "crown": 0.03,
        "stiffness": 1e5,
        "camber": 1.0,
        "trail": 0.02,
        "rolling_resistance": 5e-3,
    }
    tyres = [Tyre(GROUND, wheel, axis=(0, 1, 0), **usual) for wheel in rolling]
    free, pressed = System(rolling), System(rolling, forces=tyres)
    steps = BODY_STEPS // wheels // 4
    pairs = [(system, system.state()) for system in (free, pressed)]
    runs = [
        lambda s=system, x=start: our_seconds(s, x, RK4(STEP_SECONDS), steps * STEP_SECONDS) for system, start in pairs
    ]
    without, with_tyres = interleaved(*runs, rounds=rounds)
    return (with_tyres - without) / (4 * steps * wheels)


def show(title: str, head: str, rows: list[str]) -> None:
    """Print one table."""
    print(f"\n{title}\n{head}", *rows, sep="\n", flush=True)


class Speed(NamedTuple):
    """Measurements of speed; costs in microseconds per body and evaluation, times in seconds."""

    chain: list[tuple[int, float, float]]  # (links, ours, MuJoCo's) at RK4
    growing: dict[str, list[tuple[int, float]]]  # "chain", "ladder" -> (bodies, ours)
    check: tuple[float, float]  # of a chain of 1000 links, of a ladder of 100 four-bars
    start: tuple[float, float]  # of a process to its first result; with an empty kernel cache


def measure() -> Speed:
    """Measure and print."""
    simulate(chain(2), 0.01, method=RK4(STEP_SECONDS))  # compiled before anything is timed
    rows = per_evaluation()
    lines = [f"{n:6} {ours:8.2f} {theirs:8.2f} {theirs / ours:8.2f}" for n, ours, theirs in rows]
    exponents = exponent(rows), exponent([(n, theirs) for n, _, theirs in rows])
    lines.append(f"cost ~ n^{exponents[0]:.2f}, MuJoCo n^{exponents[1]:.2f}")
    show("Chain of hinges, RK4(1 ms): us per body and evaluation", "     n     ours   MuJoCo    ratio", lines)
    growing = {"chain": growth(chain, (30, 300, 1000, 5000)), "ladder": growth(ladder, (10, 30, 100, 300))}
    for name, found in growing.items():
        lines = [f"{n:6} {cost:8.2f} {cost / found[0][1]:8.2f}" for n, cost in found]
        title = f"{name.capitalize()}: us per body and evaluation, cost ~ n^{exponent(found):.2f}"
        show(title, "bodies     ours  ratio to first", lines)
    long, wide = check_seconds(chain(1000)), check_seconds(ladder(100))
    show("check()", "", [f"chain of 1000: {long:.2f} s, ladder of 100: {wide:.2f} s"])
    show("Tyre", "", [f"{1e6 * tyre_seconds():.3f} us per evaluation"])
    process_time(FIRST_RESULT_CODE, 1)  # its kernels are on disk from here on
    (imports, _), (first, busy), (cold, cold_busy) = (
        process_time(IMPORT_CODE),
        process_time(FIRST_RESULT_CODE),
        compile_time(),
    )
    show(
        "Process start to first result", "",
        [
            f"{first:.2f} s ({busy:.2f} s of a processor; {imports:.2f} s to import numba, numpy and scipy alone)",
            f"{cold:.1f} s with an empty kernel cache ({cold_busy:.1f} s of a processor)",
        ],
    )  # fmt: skip
    return Speed(rows, growing, (long, wide), (first, cold))


def main(path: Path) -> None:
    """Measure, print, and store as JSON."""
    print(machine("numpy", "numba", "mujoco-core"))
    write_atomically(path, (json.dumps(measure()._asdict(), indent=1) + "\n").encode())
