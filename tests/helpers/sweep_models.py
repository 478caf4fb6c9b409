"""What the sweeps of the tests build and measure: at the top of a module, so that other processes find it."""

import os
import signal
import sys
import time
from pathlib import Path

import numpy as np

from mbsd3d import GROUND, Body, Force, Revolute, System
from mbsd3d.base.paths import atomic_write
from mbsd3d.demos.shafts.cardan import mechanism

RUN = {"t_end": 0.4, "rtol": 1e-6, "output": 33}


def shafts(bend, turns):
    """The Cardan demo over a number of turns of its input."""
    return mechanism(bend_deg=np.degrees(bend)), {"t_end": 2 * np.pi / 10.0 * turns}


def ratio(solution):
    spin = solution.omega_body("driven")[:, 0]
    return {"ratio": spin.max() / spin.min(), "torque": np.abs(solution.effort("motor")).max()}


def wheel(torque=1.7, inertia=0.3):
    """A disc off its centre of mass about the vertical, turned by a constant force: uniformly accelerated."""
    body = Body("wheel", 2.0, (inertia, inertia, inertia), com=(0.2, -0.1, 0.05))
    hinge = Revolute(GROUND, body, at=(0, 0, 0), axis=(0, 0, 1), name="hinge")
    push = Force(body, (0.0, torque, 0.0), at=(1.0, 0.0, 0.0), frame="body")
    return System([body], [hinge], [push])


def speed(solution):
    return solution.rate("hinge")[-1]


def history(solution):
    return {"angle": solution.angle("hinge"), "speed": solution.rate("hinge")[-1]}


def speed_of(torque, inertia, t=RUN["t_end"]):
    """Closed form: torque t over the moment about the axis, Steiner's part m (x^2 + y^2) = 0.1 kg m^2 included."""
    return torque * t / (inertia + 0.1)


def known(grid):
    """Closed form of the last speed in every cell."""
    return speed_of(*np.meshgrid(*grid.values(), indexing="ij"))


def touchy(torque, inertia):
    """Fails as users' builds do, where the torque is greatest."""
    if torque > 2.5:
        raise RuntimeError(f"no motor gives {torque} N m")
    return wheel(torque, inertia)


def deadly(torque, inertia):
    """Takes its process along in the cell (2.0, 0.4)."""
    if (torque, inertia) == (2.0, 0.4):
        os.kill(os.getpid(), signal.SIGKILL)
    return wheel(torque, inertia)


def deadly_once(torque, inertia):
    """Takes its process along the first time only; $MBSD3D_MARK remembers."""
    mark = Path(os.environ["MBSD3D_MARK"])
    if (torque, inertia) == (2.0, 0.4) and not mark.exists():
        mark.touch()
        os._exit(3)
    return wheel(torque, inertia)


def counted(torque, inertia):
    """Leaves a line per call in $MBSD3D_MARK, and takes a while; half a second after $MBSD3D_FAST calls."""
    mark = Path(os.environ["MBSD3D_MARK"])
    with mark.open("a") as handle:
        handle.write(f"{torque} {inertia}\n")
    time.sleep(0.02 if mark.read_text().count("\n") < int(os.environ.get("MBSD3D_FAST", 1000)) else 0.5)
    return wheel(torque, inertia)


def half_written(folder):
    """Holds a file that is not whole."""
    with atomic_write(folder / "table.csv") as part, part.open("xb") as handle:
        handle.write(b"t [s],")
        handle.flush()
        (folder / "begun").touch()
        time.sleep(60.0)


LOCAL = 1e-6  # the rtol of RUN: steps err by a tenth of it, and there are few
GRID = {"torque": [1.0, 2.0, 2.4, 3.1], "inertia": [0.2, 0.4, 0.7]}
LONG = {"torque": np.linspace(1.0, 2.0, 40).tolist(), "inertia": np.linspace(0.2, 0.9, 4).tolist()}  # 160 cells
EXECUTORS = ("threads", "processes", "distributed")
KILLED = (*EXECUTORS, "gallery", "play", "live")  # what is killed, each at so many moments
MOMENTS, ALL_MOMENTS = 3, 30  # in `make slow`, and in `make kills`


def noted(arriving, path):
    """Outcomes as they come in, each written down before it is handed on."""
    with path.open("a", buffering=1) as file:
        for cell, outcome in arriving:
            file.write(f"{cell}\n")
            yield cell, outcome


def cluster():
    """A cluster of two worker processes on this machine."""
    from distributed import Client

    return Client(n_workers=2, threads_per_worker=1, dashboard_address=None)


def main(ledger, limit=None, executor=None):
    """A process of its own: sweeps LONG; prints what came out of Ctrl-C or of a full disk."""
    import resource

    from mbsd3d import SweepError
    from mbsd3d.sweeps import sweep as module

    sweep, outcomes = module.sweep, module.outcomes
    module.outcomes = lambda *given: noted(outcomes(*given), Path(f"{ledger}.arrived"))
    if limit and int(limit):
        resource.setrlimit(resource.RLIMIT_FSIZE, (int(limit), int(limit)))
    print("ready", flush=True)
    pool = cluster() if executor == "distributed" else executor
    try:
        table = sweep(counted, LONG, speed, run=RUN, ledger=ledger, executor=pool)
    except SweepError as error:
        print(error)
        table = error.dataset
    print(f"finished {int(np.isfinite(table['speed']).sum())}; {table.attrs['stopped_by']}")


if __name__ == "__main__":
    main(*sys.argv[1:])
