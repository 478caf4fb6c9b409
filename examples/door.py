"""A door on two hinges: redundant, its motion and the sum of its hinge forces certain, the share of each hinge not.

Prints::

    counted -4 degrees of freedom, there is 1; first remedy: remove 'upper' (Revolute) (5 rows, all independent)
    share of the upper hinge unique: False
    both together: [ -7.898  -4.315 196.2  ] N
    of equal stiffness: [-59.282 -32.386  98.1  ] N above, up to 100 N more for 10 um along the axis
    hung on one: [-67.564   0.      0.   ] N above; True
    statics and spin: -67.564 N above
"""

from mbsd3d import GROUND, Body, PointOnLine, Revolute, Spherical, System, inertia, simulate

leaf = Body("door", 20.0, inertia.box(20.0, (0.9, 0.04, 2.0)), com=(0.45, 0, 0), omega=(0, 0, 1.0))
upper = Revolute(GROUND, leaf, at=(0, 0, 0.7), axis=(0, 0, 1), name="upper")
lower = Revolute(GROUND, leaf, at=(0, 0, -0.7), axis=(0, 0, 1), name="lower")
door = System([leaf], [upper, lower])
found = door.check()
print(f"counted {found.gruebler} degrees of freedom, there is {found.mobility}; first remedy: {found.cures[0].text}")

swing = simulate(door, 0.5)
print("share of the upper hinge unique:", swing.reaction(upper).unique)
print("both together:", swing.reaction(upper, lower).force[-1].round(3), "N")
alike = swing.reaction(upper, shares="range", stiffness=(1e7, 1e3), tolerances=(1e-5, 0.0))
print("of equal stiffness:", alike.force[-1].round(3), "N above, ", end="")
print(f"up to {alike.force_margin[-1, 2]:.0f} N more for 10 um along the axis")

carrying = Spherical(GROUND, leaf, at=(0, 0, -0.7), name="lower")  # as doors are hung: one hinge carries
guiding = PointOnLine(GROUND, leaf, at=(0, 0, 0.7), axis=(0, 0, 1), name="upper")
hung = simulate(System([leaf], [carrying, guiding]), 0.5)
print("hung on one:", hung.reaction(guiding).force[0].round(3), "N above;", hung.reaction(carrying).unique)
print(f"statics and spin: {-20 * 9.81 * 0.45 / 1.4 - 20 * 0.45 * 1.0**2 / 2:.3f} N above")
figure = hung.picture(shown=["reaction force"])
