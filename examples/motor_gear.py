"""A motor with a torque that falls with its speed drives a drum through a gear: which ratio winds up fastest?

Prints::

    ratio  8: 0.7008 s (closed form 0.7008 s), motor at 80.0 rad/s
    ratio 14: 0.5273 s (closed form 0.5273 s), motor at 140.0 rad/s
    ratio 20: 0.5356 s (closed form 0.5356 s), motor at 200.0 rad/s
    ratio 26: 0.7046 s (closed form 0.7046 s), motor at 260.0 rad/s
"""

import numpy as np

from mbsd3d import GROUND, Body, Gear, Revolute, System, TorqueCurve, measures, simulate

STALL, FREE = 4.0, 300.0  # N m at rest, rad/s without load
ROTOR, DRUM, WANTED = 2e-3, 1.8, 10.0  # kg m^2 about the shafts, rad/s of the drum

Z = (0, 0, 1)


def winch(ratio):
    """Return the run of the drum from rest to the speed wanted, and both hinges."""
    rotor = Body("rotor", 3.0, (2e-3, 2e-3, ROTOR))
    drum = Body("drum", 25.0, (1.2, 1.2, DRUM), position=(0.4, 0, 0))
    fast = Revolute(GROUND, rotor, at=(0, 0, 0), axis=Z, name="motor shaft")
    slow = Revolute(GROUND, drum, at=(0.4, 0, 0), axis=Z, name="drum shaft")
    gear = Gear(fast, slow, ratio=-1 / ratio, name="gear")
    motor = TorqueCurve(fast, points=[(-FREE, 2 * STALL), (0.0, STALL), (FREE, 0.0)], name="motor")
    system = System([rotor, drum], [fast, slow, gear], [motor])
    return simulate(system, 60.0, stop_when=measures.rate(slow) < -WANTED), fast


for ratio in (8.0, 14.0, 20.0, 26.0):
    run, fast = winch(ratio)
    time_constant = (ROTOR + DRUM / ratio**2) * FREE / STALL  # at the motor shaft
    exact = -time_constant * np.log(1 - WANTED * ratio / FREE)
    print(f"ratio {ratio:2.0f}: {run.t[-1]:.4f} s (closed form {exact:.4f} s), motor at {run.rate(fast)[-1]:.1f} rad/s")
figure = run.plot("rate", fast)
