"""A worn slider-crank: twice a turn the piston lets go of its pin, flies through the play and knocks. How hard?

Prints::

    play 0.02 mm: let go at 74.529, knock at 81.852 deg with 0.046566 m/s; free flight: 74.529, 81.852 deg, 0.046566 m/s
    play 0.10 mm: let go at 74.529, knock at 87.128 deg with 0.134335 m/s; free flight: 74.529, 87.128 deg, 0.134335 m/s
    play 0.50 mm: let go at 74.529, knock at 96.335 deg with 0.382073 m/s; free flight: 74.529, 96.335 deg, 0.382073 m/s
    five times the play, 5^(2/3) = 2.92 times the speed, as the rod runs away with the cube of the time
"""

import numpy as np
from scipy.optimize import brentq

from mbsd3d import GROUND, AngleDriver, Body, PointOnPlane, PointStop, Prismatic, Ramp, Revolute, System, simulate

R, L, W, PISTON = 0.045, 0.150, 100.0, 0.5  # m of crank and rod, rad/s, kg of the piston


def place(angle):
    """Return the end of the rod along the bore [m]."""
    return R * np.cos(angle) + np.sqrt(L**2 - (R * np.sin(angle)) ** 2)


def slope(function, angle):
    """Return the derivative of a function."""
    return np.imag(function(angle + 1e-30j)) / 1e-30


def rate(angle):
    """Return the derivative of `place` by the angle."""
    return -R * np.sin(angle) * (1 + R * np.cos(angle) / np.sqrt(L**2 - (R * np.sin(angle)) ** 2))


def worn(play):
    """Return the machine at its outer dead centre; the bearing is worn along the bore, by a play [m]."""
    end = np.array([R + L, 0, 0])
    crank = Body("crank", 2.0, (4e-3, 4e-3, 4e-3))
    rod = Body("rod", 0.3, (1e-3, 1e-3, 1e-3), position=(R + L / 2, 0, 0))
    piston = Body("piston", PISTON, (3e-4, 3e-4, 3e-4), position=end)
    main = Revolute(GROUND, crank, at=(0, 0, 0), axis="z", name="main bearing")
    joints = [
        main,
        Revolute(crank, rod, at=(R, 0, 0), axis="z", name="big end"),
        Prismatic(GROUND, piston, at=end, axis="x", name="bore"),
        PointOnPlane(piston, rod, at=end, normal="y", name="bearing across the bore"),
        AngleDriver(main, Ramp(W), name="motor"),
    ]
    along = PointStop(
        piston, rod, at=end, axis="x", lower=-play / 2, upper=play / 2, restitution=0.0,
        name="bearing",
    )  # fmt: skip
    return System([crank, rod, piston], joints, [along], gravity=(0, 0, 0), name="worn slider-crank")


def knock(play):
    """Return the angles of letting go and of the knock [rad], and its speed [m/s]; between them the piston flies."""
    leaves = brentq(lambda angle: slope(rate, angle), 0.5, 2.0)  # where the end of the rod is fastest

    def apart(angle):
        return place(angle) - place(leaves) - rate(leaves) * (angle - leaves)

    lands = brentq(lambda angle: apart(angle) - play, leaves + 1e-3, leaves + 1.5)
    return leaves, lands, W * abs(rate(lands) - rate(leaves))


for play in (0.02e-3, 0.1e-3, 0.5e-3):
    run = simulate(worn(play), 2 * np.pi / W, rtol=1e-10)
    gone, hit = run.events[1:3]  # the first one closes the play of the start
    leaves, lands, speed = knock(play)
    print(f"play {1e3 * play:.2f} mm: let go at {np.degrees(W * gone.t):.3f}, knock at ", end="")
    print(f"{np.degrees(W * hit.t):.3f} deg with {np.sqrt(2 * hit.lost / PISTON):.6f} m/s; free flight: ", end="")
    print(f"{np.degrees(leaves):.3f}, {np.degrees(lands):.3f} deg, {speed:.6f} m/s")
print("five times the play, 5^(2/3) = 2.92 times the speed, as the rod runs away with the cube of the time")
figure = run.picture(hidden=["body names", "joint names"])
