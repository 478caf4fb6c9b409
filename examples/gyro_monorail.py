"""A monorail car on one rail, held upright by a gyroscope in a gimbal, as L. Brennan showed in 1909.

A car that falls is held only if the gimbal would fall too; friction in the gimbal then spoils it, and a servo that
pushes the gimbal the way it goes makes it good.

Prints::

    gimbal hangs   fastest growth   0.5825 1/s
    gimbal stands  fastest growth   0.0560 1/s
    and is pushed  fastest growth  -0.0141 1/s
    tilted by 0.02 rad, after 50 s it stays within 0.0107 rad
"""

from mbsd3d import GROUND, Body, Revolute, StateFeedback, System, TorsionSpring, linearize, measures, simulate

SPIN = 100.0  # [rad/s]


def car(mass_above, friction, push):
    """Car on a rail along x, gimbal about y with its mass above or below, rotor about z; (system, measures)."""
    body = Body("car", 2000.0, (800.0, 4000.0, 4000.0), position=(0, 0, 1.0))
    frame = Body("gimbal", 60.0, (2.0, 2.0, 2.0), position=(0, 0, 1.2), com=(0, 0, mass_above))
    rotor = Body("rotor", 300.0, (12.0, 12.0, 20.0), position=(0, 0, 1.2))
    rail = Revolute(GROUND, body, at=(0, 0, 0), axis=(1, 0, 0), name="rail")
    hinge = Revolute(body, frame, at=(0, 0, 1.2), axis=(0, 1, 0), name="gimbal hinge")
    spin = Revolute(frame, rotor, at=(0, 0, 1.2), axis=(0, 0, 1), name="spin")
    forces = [
        TorsionSpring(rail, stiffness=0.0, damping=4000.0, name="suspension"),
        TorsionSpring(hinge, stiffness=0.0, damping=friction, name="friction"),
        StateFeedback(measures=[measures.rate(hinge)], gains=(-push,), on=hinge, name="servo"),
    ]
    seen = [measures.angle(rail), measures.angle(hinge), measures.rate(rail), measures.rate(hinge)]
    return System([body, frame, rotor], [rail, hinge, spin], forces), seen


def spinning(system, tilt=0.0):
    """The rotor at speed, the car at a tilt [rad], all else at rest."""
    return system.assemble(angles={"rail": tilt}, rates={"spin": SPIN, "rail": 0.0, "gimbal hinge": 0.0})


cases = {"gimbal hangs": (-0.1, 5.0, 0.0), "gimbal stands": (0.1, 5.0, 0.0), "and is pushed": (0.1, 5.0, 19.0)}
for name, numbers in cases.items():
    system, seen = car(*numbers)
    print(
        f"{name:14s} fastest growth {linearize(system, spinning(system), outputs=seen).eigenvalues.real.max():8.4f} 1/s"
    )

system, _ = car(0.1, 5.0, 19.0)
run = simulate(system, 60.0, state=spinning(system, 0.02))
late = abs(run.angle("rail")[run.t > 50.0]).max()
print(f"tilted by 0.02 rad, after 50 s it stays within {late:.4f} rad")
figure = run.plot("angle", "rail", "gimbal hinge", degrees=True)
