"""A gripper with a closed loop: a cylinder pulls a slide, two links turn the fingers. How hard do they hold the part?

Prints::

    mobility 1, redundant rows: 0
    the cylinder pulls with 400 N, the slide comes to rest after 7.48 mm
    the fingers hold the part with 107.4 N; statics of the linkage 107.4 N
"""

import numpy as np

from mbsd3d import GROUND, Body, Force, Joint, PointOnLine, Prismatic, Revolute, SpringDamper, System, shapes, simulate

PULL, STIFF = 400.0, 4e3  # N of the cylinder, N/m of the part
Y = (0, 1, 0)
PIVOT, HEEL, TIP = np.array([0.05, 0, 0]), np.array([0.008, 0, -0.01]), np.array([0.025, 0, 0.07])  # of a finger [m]
START = np.array([0.0, 0, -0.05])  # the pin of the slide [m]
LEFT = np.array([-1, 1, 1])  # the mirror

slide = Body("slide", 0.3, (1e-4, 1e-4, 1e-4), position=START, shape=shapes.Box((0.02, 0.02, 0.015)))
guide = Prismatic(GROUND, slide, at=START, axis=(0, 0, 1), name="guide")
bodies: list[Body] = [slide]
joints: list[Joint] = [guide]
for side, mirror in (("right", 1), ("left", LEFT)):
    pivot, heel, tip = (mirror * point for point in (PIVOT, HEEL, TIP))
    middle = (heel + tip + pivot) / 3
    plate = shapes.Hull([x - middle + (0, y, 0) for x in (heel, tip, pivot) for y in (-0.006, 0.006)])
    finger = Body(f"{side} finger", 0.2, (2e-4, 2e-4, 5e-5), position=middle, shape=plate)
    link = Body(f"{side} link", 0.05, (2e-5, 2e-5, 5e-6), position=(START + heel) / 2)
    bodies += [finger, link]
    joints += [
        Revolute(GROUND, finger, at=pivot, axis=Y, name=f"{side} pivot"),
        Revolute(slide, link, at=START, axis=Y, name=f"{side} pin"),
        PointOnLine(link, finger, at=heel, axis=Y, name=f"{side} heel"),  # a hinge there would be redundant
    ]
right, left = bodies[1], bodies[3]
part = SpringDamper(right, left, at_a=TIP, at_b=LEFT * TIP, stiffness=STIFF, damping=80.0, name="part")
cylinder = Force(slide, (0, 0, -PULL), name="cylinder")
gripper = System(bodies, joints, [part, cylinder], gravity=(0, 0, 0), name="gripper")
found = gripper.check()
print(f"mobility {found.mobility}, redundant rows: {found.redundant}")

run = simulate(gripper, 0.3)
print(f"the cylinder pulls with {PULL:.0f} N, the slide comes to rest after {-1e3 * run.slide(guide)[-1]:.2f} mm")
pin, pivot = run.position(slide)[-1], PIVOT
heel, tip = run.body_point(right, HEEL)[-1], run.body_point(right, TIP)[-1]
along = (pin - heel) / np.linalg.norm(pin - heel)  # of the link
tension = PULL / 2 / -along[2]
lever = np.cross(heel - pivot, along)[1]
statics = -tension * lever / (tip - pivot)[2]
held = STIFF * (2 * TIP[0] - 2 * tip[0])
print(f"the fingers hold the part with {held:.1f} N; statics of the linkage {statics:.1f} N")
figure = run.picture(shown=["reaction force"], hidden=["body names", "joint names"], view=(-80, 12))
