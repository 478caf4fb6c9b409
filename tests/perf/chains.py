"""Measured speed: chains of hinges, the fast heavy top, process start, compilation. A script, not a test.

``python tests/perf/chains.py`` prints the table; ``README.md`` beside this file says what each line means.
"""

import os
import platform
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from mbsd3d import GROUND, RK4, Body, Revolute, Solution, System, simulate
from validation import cases
from validation.comparison import compare

REPEATS = 5
LENGTHS = (1, 3, 10, 30)  # bodies of a chain
STEP, BODY_STEPS = 1e-3, 300_000  # s; bodies x steps of a run: over a second, of which Python takes less than 1 %
TOP_ERROR = 1e-8  # of the fast heavy top against its reference, each output divided by its largest value above 1
LIMITS = {"chain": "1.5", "top": "15", "start": "1.5", "compile": "45"}

FIRST_RESULT = """
from mbsd3d import GROUND, Body, Spherical, System, simulate
top = Body("top", mass=15.0, inertia=(0.234375, 0.46875, 0.234375), position=(0, 1, 0), omega=(0, 150, -4.61538))
print(simulate(System([top], [Spherical(GROUND, top, at=(0, 0, 0))]), t_end=2.0).position(top)[-1])
"""
IMPORTS = "import numba, numpy, scipy.linalg, scipy.interpolate"


def chain(n: int) -> System:
    """n links of 0.2 m, hung up horizontally; hinge axes along y and z in turns, centres of mass off the hinges."""
    inertia = (1e-4, 8e-4, 7e-4)
    links = [Body(f"link {k}", 0.2, inertia, com=(0.1, 0.01, 0.005), position=(0.2 * k, 0, 0)) for k in range(n)]
    joints = [
        Revolute(links[k - 1] if k else GROUND, links[k], at=(0.2 * k, 0, 0), axis=((0, 1, 0), (0, 0, 1))[k % 2])
        for k in range(n)
    ]
    return System(links, joints)


def chain_times() -> list[tuple[float, Solution]]:
    """(least microseconds per body and evaluation, its run) by length: RK4 with projection, only both ends stored.

    In rounds over all lengths, so that a busy moment of the machine does not fall on all runs of one length.
    """
    systems, best = [chain(n) for n in LENGTHS], {}
    for _ in range(REPEATS):
        for n, system in zip(LENGTHS, systems, strict=True):
            run = simulate(system, STEP * (BODY_STEPS // n), method=RK4(STEP), output=2)
            value = 1e6 * run.record.seconds / run.record.evaluations / n
            best[n] = min(best.get(n, (value, run)), (value, run), key=lambda pair: pair[0])
    return [best[n] for n in LENGTHS]


def top_time() -> tuple[float, float, float, Solution]:
    """(least milliseconds, error, rtol, run) of the fast heavy top at the loosest rtol whose error is in bounds."""
    case, found = cases.load("heavy_top_fast"), None
    for rtol in 10.0 ** np.arange(-13.0, -6.0, 0.25):  # from the tight side: no error that is small by chance
        error = compare(case, simulate(case.system, case.t_end, rtol=rtol, output=case.times)).scaled_error
        if error > TOP_ERROR:
            break
        found = rtol, error
    rtol, error = found
    runs = [simulate(case.system, case.t_end, rtol=rtol, output=case.times) for _ in range(4 * REPEATS)]
    best = min(runs, key=lambda run: run.record.seconds)
    return 1e3 * best.record.seconds, error, rtol, best


def process_time(code: str, repeats: int = REPEATS, **environment: str) -> tuple[float, float]:
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


def machine() -> str:
    """Processor class, cores and versions: what the figures depend on."""
    import numba

    cpu = Path("/proc/cpuinfo")
    lines = cpu.read_text().splitlines() if cpu.is_file() else []
    names = [text.split(":")[1].strip() for text in lines if text.startswith("model name")]
    name = names[0] if names else platform.processor() or platform.machine()
    versions = f"Python {platform.python_version()}, numpy {np.__version__}, numba {numba.__version__}"
    load = f"; load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    return f"{name}, {os.cpu_count()} cores; {versions}{load}"


def line(quantity: str, value: str, limit: str, remark: str) -> None:
    """Print one line of the table."""
    print(f"{quantity:<44} {value:>10} {limit:>8}   {remark}", flush=True)


def main() -> None:
    """Measure and print."""
    print(machine())
    simulate(chain(2), 0.01, method=RK4(STEP))  # compiled before anything is timed
    line("quantity", "measured", "limit", "run")
    for n, (value, run) in zip(LENGTHS, chain_times(), strict=True):
        remark = f"{run.record.steps} steps, {run.record.evaluations} evaluations, {run.record.seconds:.3g} s"
        line(f"chain of {n} hinges, us/body/evaluation", f"{value:.2f}", LIMITS["chain"], remark)
    value, error, rtol, run = top_time()
    remark = f"error {error:.1e}, rtol {rtol:.1e}, {run.record.steps} steps, {run.record.evaluations} evaluations"
    line("fast heavy top, 2 s, ms", f"{value:.2f}", LIMITS["top"], remark)
    process_time(FIRST_RESULT, 1)  # its kernels are on disk from here on
    (imports, _), (first, busy) = process_time(IMPORTS), process_time(FIRST_RESULT)
    remark = f"{busy:.2f} s of a processor; {imports:.2f} s to import numba, numpy and scipy alone"
    line("process start to first result, s", f"{first:.2f}", LIMITS["start"], remark)
    first, busy = compile_time()
    line(
        "the same with an empty cache (compiling), s", f"{first:.1f}", LIMITS["compile"], f"{busy:.1f} s of a processor"
    )


if __name__ == "__main__":
    main()
