"""Measured speed, against MuJoCo where there is a twin. A script, not a test: times depend on the machine.

``python -m validation.benchmark`` prints the tables on an idle machine. Peers run interleaved, round by round in one
process, so that a busy moment falls on both; every figure is the best of its rounds. Trust ratios, not times.
"""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable

import numpy as np

from mbsd3d import DOP853, RK4, Solution, State, System, simulate

from . import cases
from .comparison import compare
from .machine import machine
from .mechanisms import chain, ladder, mujoco_chain

ROUNDS = 5
LENGTHS = (3, 10, 30, 100, 300)
STEP, BODY_STEPS = 1e-3, 60_000  # s; bodies x steps of a run: a quarter of a second
TOP_ERROR = 1e-8  # of the fast heavy top against its reference, each output divided by its largest value above 1

FIRST_RESULT = """
from mbsd3d import GROUND, Body, Spherical, System, simulate
top = Body("top", mass=15.0, inertia=(0.234375, 0.46875, 0.234375), position=(0, 1, 0), omega=(0, 150, -4.61538))
print(simulate(System([top], [Spherical(GROUND, top, at=(0, 0, 0))]), t_end=2.0).position(top)[-1])
"""
IMPORTS = "import numba, numpy, scipy.linalg, scipy.interpolate"


def interleaved(*runs: Callable[[], float], rounds: int = ROUNDS) -> list[float]:
    """Least seconds of every run, taken in turns."""
    best = [np.inf] * len(runs)
    for _ in range(rounds):
        best = [min(least, run()) for least, run in zip(best, runs, strict=True)]
    return best


def our_seconds(system: System, start: State, method: object, t_end: float, rtol: float = 1e-8) -> float:
    """Seconds of the time loop; only both ends are stored."""
    return simulate(system, t_end, state=start, method=method, rtol=rtol, output=2).record.loop_seconds


def mujoco_seconds(model: object, steps: int) -> tuple[float, object]:
    """(seconds, end) of `steps` steps from the reference pose, in one call of the compiled loop."""
    import mujoco

    data = mujoco.MjData(model)
    mujoco.mj_step(model, data)  # its first call sets up the work space
    mujoco.mj_resetData(model, data)
    began = time.perf_counter()
    mujoco.mj_step(model, data, steps)
    return time.perf_counter() - began, data


def per_evaluation(lengths: tuple = LENGTHS) -> list[tuple[int, float, float]]:
    """(n, ours, MuJoCo's) microseconds per body and evaluation of chains: RK4 at one step, ours with projection."""
    found = []
    for n in lengths:
        steps = max(BODY_STEPS // n, 20)
        system, twin = chain(n), mujoco_chain(n, STEP)
        start = system.state()
        ours, theirs = interleaved(
            lambda s=system, x=start, k=steps: our_seconds(s, x, RK4(STEP), k * STEP),
            lambda m=twin, k=steps: mujoco_seconds(m, k)[0],
        )
        found.append((n, 1e6 * ours / (4 * steps * n), 1e6 * theirs / (4 * steps * n)))
    return found


def growth(mechanism: Callable[[int], System], sizes: tuple, steps: int = 50) -> list[tuple[int, float]]:
    """(bodies, microseconds per body and evaluation) of a mechanism by its size; RK4 with projection."""
    found = []
    for size in sizes:
        system = mechanism(size)
        start, n = system.state(), len(system.bodies)
        (seconds,) = interleaved(lambda s=system, x=start: our_seconds(s, x, RK4(STEP), steps * STEP), rounds=3)
        found.append((n, 1e6 * seconds / (4 * steps * n)))
    return found


def exponent(rows: list[tuple]) -> float:
    """Exponent p of the whole cost n * (cost per body) ~ n^p, least squares in logarithms."""
    n, cost = np.array([row[0] for row in rows], float), np.array([row[1] for row in rows], float)
    return float(np.polyfit(np.log(n), np.log(n * cost), 1)[0])


def tip(solution: Solution) -> np.ndarray:
    """Where the last link of a chain is at the end [m]."""
    return solution.position(solution.system.bodies[-1])[-1]


def equal_accuracy(n: int, t_end: float, error: float) -> dict[str, float]:
    """Seconds until the tip of a chain of n is right to `error` [m]: ours (DOP853), MuJoCo's (RK4), both converged.

    The truth is our run at rtol 1e-12; `agreement` is MuJoCo's distance from it at its finest step: not our code.
    """
    system = chain(n)
    start = system.state()
    truth = tip(simulate(system, t_end, state=start, rtol=1e-12, output=2))
    rtol = 1e-12
    while np.linalg.norm(tip(simulate(system, t_end, state=start, rtol=10**0.5 * rtol, output=2)) - truth) <= error:
        rtol *= 10**0.5  # from the tight side: no error that is small by chance
    for steps in 2 ** np.arange(6, 22):
        _, data = mujoco_seconds(mujoco_chain(n, t_end / steps), int(steps))
        distance = np.linalg.norm(data.xpos[n] - truth)
        if distance <= error:
            break
    twin = mujoco_chain(n, t_end / steps)
    ours, theirs = interleaved(
        lambda: our_seconds(system, start, DOP853(), t_end, rtol), lambda: mujoco_seconds(twin, int(steps))[0]
    )
    return {"ours": ours, "mujoco": theirs, "rtol": rtol, "dt": t_end / steps, "agreement": distance}


def top_time() -> tuple[float, float, float, Solution]:
    """(least milliseconds, error, rtol, run) of the fast heavy top at the loosest rtol whose error is in bounds."""
    case, found = cases.load("heavy_top_fast"), None
    for rtol in 10.0 ** np.arange(-13.0, -6.0, 0.25):  # from the tight side: no error that is small by chance
        error = compare(case, simulate(case.system, case.t_end, rtol=rtol, output=case.times)).scaled_error
        if error > TOP_ERROR:
            break
        found = rtol, error
    rtol, error = found
    runs = [simulate(case.system, case.t_end, rtol=rtol, output=case.times) for _ in range(4 * ROUNDS)]
    best = min(runs, key=lambda run: run.record.seconds)
    return 1e3 * best.record.seconds, error, rtol, best


def process_time(code: str, repeats: int = ROUNDS, **environment: str) -> tuple[float, float]:
    """(wall, processor) seconds of a new Python process that runs ``code``, the fastest one."""
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
    """(wall, processor) seconds from the start of a process to its first result with an empty kernel cache, once."""
    with tempfile.TemporaryDirectory() as folder:
        return process_time(FIRST_RESULT, 1, MBSD3D_CACHE=folder)


def check_seconds(system: System) -> float:
    """Seconds of a whole `check`: mobility, redundant rows, cures."""
    began = time.perf_counter()
    system.check()
    return time.perf_counter() - began


def show(title: str, head: str, rows: list[str]) -> None:
    """Print one table."""
    print(f"\n{title}\n{head}", *rows, sep="\n", flush=True)


def main() -> None:
    """Measure and print."""
    print(machine("numpy", "numba", "mujoco"))
    simulate(chain(2), 0.01, method=RK4(STEP))  # compiled before anything is timed
    rows = per_evaluation()
    lines = [f"{n:6} {ours:8.2f} {theirs:8.2f} {theirs / ours:8.2f}" for n, ours, theirs in rows]
    exponents = exponent(rows), exponent([(n, theirs) for n, _, theirs in rows])
    lines.append(f"cost ~ n^{exponents[0]:.2f}, MuJoCo n^{exponents[1]:.2f}")
    show("Chain of hinges, RK4(1 ms): us per body and evaluation", "     n     ours   MuJoCo    ratio", lines)
    lines = []
    for n, t_end, error in ((3, 1.0, 1e-8), (10, 0.5, 1e-8), (30, 0.5, 1e-8), (100, 0.5, 1e-8)):
        x = equal_accuracy(n, t_end, error)
        lines.append(
            f"{n:6} {error:8.0e} {1e3 * x['ours']:9.2f} {1e3 * x['mujoco']:9.2f} {x['mujoco'] / x['ours']:7.2f}"
            f"   rtol {x['rtol']:.0e}, dt {x['dt']:.1e} s, distance {x['agreement']:.1e} m"
        )
    show("Chain of hinges, equal accuracy: ms", "     n   error      ours    MuJoCo   ratio", lines)
    for name, mechanism, sizes in (("Chain", chain, (30, 300, 1000, 5000)), ("Ladder", ladder, (10, 30, 100, 300))):
        rows = growth(mechanism, sizes)
        lines = [f"{n:6} {cost:8.2f} {cost / rows[0][1]:8.2f}" for n, cost in rows]
        show(
            f"{name}: us per body and evaluation, cost ~ n^{exponent(rows):.2f}", "bodies     ours  ratio to first",
            lines,
        )  # fmt: skip
    seconds = [check_seconds(system) for system in (chain(1000), ladder(100))]
    show("check()", "", [f"chain of 1000: {seconds[0]:.2f} s, ladder of 100: {seconds[1]:.2f} s"])
    value, error, rtol, run = top_time()
    show(
        "Fast heavy top, 2 s", "",
        [f"{value:.2f} ms, error {error:.1e}, rtol {rtol:.1e}, {run.record.steps} steps"],
    )  # fmt: skip
    process_time(FIRST_RESULT, 1)  # its kernels are on disk from here on
    (imports, _), (first, busy), (cold, cold_busy) = process_time(IMPORTS), process_time(FIRST_RESULT), compile_time()
    show(
        "Process start to first result", "",
        [
            f"{first:.2f} s ({busy:.2f} s of a processor; {imports:.2f} s to import numba, numpy and scipy alone)",
            f"{cold:.1f} s with an empty kernel cache ({cold_busy:.1f} s of a processor)",
        ],
    )  # fmt: skip


if __name__ == "__main__":
    main()
