"""Call every kernel once, so that it is compiled."""

import math
import os
import time
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from mbsd3d import AngleDriver, Revolute, System


def compile_all() -> None:
    """Compile every kernel, by two processes where there are two cores: one finds the results of the other on disk."""
    from ..compiler.cache_folder import is_warm
    from .workers import working

    parts = (compile_explicit, compile_implicit)
    if is_warm() or (os.cpu_count() or 1) == 1:
        for part in parts:
            part()
        return
    with working(len(parts)) as pool:
        for done in [pool.submit(part) for part in parts]:
            done.result()


def fill_cells(last_first: bool = False) -> None:
    """Compile kernels that no run has called yet: laws of forces, rows, loops."""
    from ..compiler.late import uncompiled_kernels

    while cells := uncompiled_kernels():
        late, passed, number = cells[-1 if last_first else 0]
        late.fill(passed, number)


def pendulum() -> "tuple[System, System, Revolute, AngleDriver]":
    """Return (free pendulum, driven pendulum, hinge, driver)."""
    import mbsd3d as m

    arm = m.Body("arm", 1.0, (0.1, 0.2, 0.2), position=(0.5, 0, 0))
    hinge = m.Revolute(m.GROUND, arm, at=(0, 0, 0), axis=(0, 1, 0))
    driver = m.AngleDriver(hinge, m.Ramp(1.0))
    return m.System([arm], [hinge]), m.System([arm], [hinge, driver]), hinge, driver


def compile_explicit() -> None:
    """Run assembly, check, DOP853, certificate, reactions, small motions."""
    import mbsd3d as m

    free, _, hinge, _ = pendulum()
    free.assemble(measures={m.measures.position(free.bodies[0], axis=(0, 0, 1)): -0.05})
    free.check()
    solution = m.simulate(free, 1e-2, stop_when=m.measures.rate(hinge) > 1e3)
    str(solution.certificate)
    solution.reaction(hinge)
    m.linearize(free, free.assemble(angles={hinge: 0.5 * math.pi}))  # it hangs
    fill_cells()


def compile_implicit() -> None:
    """Run GeneralizedAlpha, RadauIIA and Kinematic."""
    import mbsd3d as m

    free, driven, hinge, driver = pendulum()
    m.simulate(free, 1e-2, method=m.GeneralizedAlpha(1e-3), stop_when=m.measures.rate(hinge) > 1e3)
    m.simulate(free, 1e-2, method=m.RadauIIA(), stop_when=m.measures.rate(hinge) > 1e3)
    m.simulate(driven, 1e-2, method=m.Kinematic())
    m.accelerations(driven).effort(driver)
    fill_cells(last_first=True)


@click.command(epilog="Example: mbsd3d warmup")
def warmup() -> None:
    """Compile all kernels, so that later runs need not wait."""
    began = time.perf_counter()
    compile_all()
    click.echo(f"all kernels are compiled ({time.perf_counter() - began:.1f} s)")
