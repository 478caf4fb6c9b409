"""Every kernel called once, so that it is compiled."""

import math
import time

import click


def compile_all() -> None:
    """Run a pendulum through every method and every check: each kernel is called once."""
    import mbsd3d as m

    arm = m.Body("arm", 1.0, (0.1, 0.2, 0.2), position=(0.5, 0, 0))
    hinge = m.Revolute(m.GROUND, arm, at=(0, 0, 0), axis=(0, 1, 0))
    driver = m.AngleDriver(hinge, m.Ramp(1.0))
    free, driven = m.System([arm], [hinge]), m.System([arm], [hinge, driver])
    free.assemble(measures={m.measures.position(arm, axis=(0, 0, 1)): -0.05})
    free.check()
    for system, method in ((free, m.DOP853()), (free, m.GeneralizedAlpha(1e-3)), (driven, m.Kinematic())):
        stop = m.measures.rate(hinge) > 1e3 if system is free else None
        solution = m.simulate(system, 1e-2, method=method, stop_when=stop)
        str(solution.certificate)
        solution.reaction(hinge)
    m.accelerations(driven).effort(driver)
    m.linearize(free, free.assemble(angles={hinge: 0.5 * math.pi}))  # it hangs


@click.command()
def warmup() -> None:
    """Compile all kernels, so that nothing else has to wait."""
    began = time.perf_counter()
    compile_all()
    click.echo(f"all kernels are compiled ({time.perf_counter() - began:.1f} s)")
