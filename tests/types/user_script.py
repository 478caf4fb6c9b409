"""What a user writes, for type checkers: every line here is right, but for those marked, which must stay errors."""

import dataclasses

import numpy as np

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Bushing,
    Contact,
    Force,
    GearMesh,
    KnifeEdge,
    PositionDriver,
    Ramp,
    Revolute,
    RollingDisc,
    Screw,
    SpeedDriver,
    SpringDamper,
    StateFeedback,
    System,
    TorsionSpring,
    Tyre,
    Universal,
    load,
    measures,
    shapes,
    signals,
    simulate,
)

arm = Body("arm", mass=2.0, inertia=(0.1, 0.5, 0.5), com=(0.5, 0, 0), velocity=(0, 0, 0))
fork = Body("fork", mass=1, inertia=np.eye(3), position=[0, 0, 1], shape=shapes.Box((0.9, 0.04, 2.0)))
hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=(0, 1, 0), name="hinge")
other = Revolute(GROUND, fork, at=(0.3, 0, 1), axis=(0, 1, 0))
cross = Universal(arm, fork, at=(1, 0, 0), axis_a=(0, 1, 0), axis_b=(0, 0, 1))
spring = SpringDamper(GROUND, arm, at_a=(0, 0, 1), at_b=(1, 0, 0), stiffness=100.0, damping=1.0)
motor = AngleDriver(hinge, Ramp(2.0))
steady = AngleDriver(hinge, 0.3)
system = System([arm], [hinge], [spring])
solution = simulate(system, 1.0)
push = Force(arm, (1.0, 0, signals.Sine(0.1, 2.0)))
mount = Bushing(GROUND, arm, at=(0, 0, 0), stiffness=(1e3, 2e3, 3e3))
floor = Contact(GROUND, arm, shapes.Sphere(0.1), stiffness=1e4)
tyre = Tyre(GROUND, arm, axis=(0, 1, 0), radius=0.3, stiffness=1e5)
disc = RollingDisc(GROUND, arm, axis=(0, 1, 0), radius=0.3)
blade = KnifeEdge(GROUND, arm, at=(0, 0, 0), heading=(1, 0, 0))
lift = PositionDriver(arm, at=(0, 0, 0), signal=(None, None, 1.0))
turn = SpeedDriver(hinge, 3.0)
teeth = GearMesh(hinge, other, at=(0.1, 0, 0))
servo = StateFeedback(measures=[measures.angle(hinge)], gains=[2.0], on=hinge)

u01 = arm.inertia[0, 0] + arm.inertia.trace()
u02 = hinge.axis @ arm.position
u03 = spring.at_b - spring.at_a
u04 = arm.position + arm.axes @ arm.com
u05 = arm.orientation[0] ** 2
u06 = spring.length * 2.0
u07 = arm.velocity[2] if arm.velocity is not None else 0.0
u08 = hinge.at - arm.position
u09 = hinge.at_b - hinge.at
u10 = hinge.axis_b.copy()
u11 = np.cross(cross.axis_a, cross.axis_b) + cross.axis_a
u12 = cross.at_b[0] - cross.at[0]
u13 = motor.signal(0.5)
u14 = steady.signal(0.5).shape
u15 = system.joints[0].b.name
u16 = len(system.bodies) + system.bodies[0].mass
u17 = system.gravity[2]
u18 = [joint.at for joint in system.joints if isinstance(joint, Revolute)][0][0]
u19 = solution.system.bodies[0].com.sum() + solution.t[-1]
u20 = dataclasses.replace(arm, position=(0, 0, 1)).position[2]
u21 = [force.name or "nameless" for force in system.forces]
u22 = push.force[2].derivative(0.1) + push.at[0]
u23 = mount.stiffness.max() / mount.damping.max() + mount.axes[0]
u24 = floor.plane[1] @ floor.b.centre + floor.exponent
u25 = tyre.centre - tyre.plane[0] + tyre.radius * tyre.axis
u26 = disc.centre[2] - disc.radius
u27 = blade.lateral @ blade.at
u28 = [signal for signal in lift.signal if signal is not None][0](1.0)
u29 = turn.speed(0.0) + turn.a.position + turn.b.position
u30 = teeth.at[0] * teeth.ratio + teeth.pressure_angle
u31 = [gain * wanted for gain, wanted in zip(servo.gains, servo.reference, strict=True)]
u32 = servo.measures[0].label.upper()
u33 = system.state().q[:3] + system.state().t
u34 = Screw(GROUND, arm, at=(0, 0, 0), axis=(0, 0, 1), pitch=0.01).pitch ** 2
u35 = TorsionSpring(hinge, stiffness=30.0).angle - 0.5
u36 = shapes.Cylinder(0.1, 0.5).radius * shapes.Ellipsoid((1, 2, 3)).radii[0]
u37 = (2.0 * Ramp(1.0) + 3.0)(np.linspace(0.0, 1.0, 3))[1]
u38 = signals.Table([0, 1, 2, 3], [0, 1, 4, 9]).times[-1] + signals.Polynomial((1.0, 2)).coefficients[0]
u39 = load("run.npz").system.joints[0].a.position
u40 = hinge.b.centre - hinge.a.centre
u41 = system.show(hidden="joints").html + solution.animate("run", curves=["energy", ("angle", hinge)]).html
u42 = [system.show(live=True).url, solution.animate(traces=[(arm, (0, 0, 1))], live=True).url]
u43 = {"push": (-5.0, 5.0)}
u44 = system.play(u43).late

w01 = Body("bad", mass="heavy", inertia=(1, 1, 1))  # type: ignore[arg-type]
arm.mass = 3.0  # type: ignore[arg-type]
w02 = Revolute(GROUND, arm, at=(0, 0, 0))  # type: ignore[call-arg]
w03 = SpringDamper(GROUND, arm, at_a=(0, 0, 0), at_b=(1, 0, 0))  # type: ignore[call-arg]
w04 = System([hinge])  # type: ignore[list-item]
w05 = AngleDriver(arm, 0.3)  # type: ignore[arg-type]
w06 = hinge.pitch  # type: ignore[attr-defined]
w07 = SpringDamper(GROUND, arm, (0, 0, 0), at_b=(1, 0, 0), stiffness=1.0)  # type: ignore[call-arg, arg-type]
w08 = solution.animate(live=True).html  # type: ignore[attr-defined]
w09 = solution.animate(curve=["energy"])  # type: ignore[call-overload]
