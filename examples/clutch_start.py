"""A car starts by its clutch: what turns to heat depends on the speeds, not on how softly the driver lets it come.

Prints::

    100 N m: slips for 0.4382 s, then both turn at 53.933 rad/s; heat 4382.02 J
    200 N m: slips for 0.2191 s, then both turn at 53.933 rad/s; heat 4382.02 J
    400 N m: slips for 0.1096 s, then both turn at 53.933 rad/s; heat 4382.02 J
    J1 J2 / (J1 + J2) dw^2 / 2 = 4382.02 J, both end at 53.933 rad/s
    on the gas: 6190.48 J, closed form 6190.48 J
"""

from matplotlib.figure import Figure

from mbsd3d import GROUND, Body, Clutch, Revolute, System, Torque, simulate

ENGINE, SPEED = 0.30, 200.0  # kg m^2, rad/s of the engine with its flywheel
CAR = 1300.0 * (0.30 / 12.0) ** 2  # kg m^2 of the car as the clutch feels it, by wheel radius and first gear


def started(grip, gas=0.0):
    """Return the run in which the clutch takes hold, for torques of clutch and engine [N m]."""
    flywheel = Body("engine", 30.0, (ENGINE, 0.2, 0.2), omega=(SPEED, 0, 0))
    gearbox = Body("car at the gearbox", 20.0, (CAR, 0.5, 0.5), position=(0.2, 0, 0))
    crank = Revolute(GROUND, flywheel, at=(0, 0, 0), axis="x", name="crank")
    pilot = Revolute(flywheel, gearbox, at=(0.1, 0, 0), axis="x", name="pilot bearing")
    clutch = Clutch(pilot, torque=grip, engaged=True, name="clutch")
    system = System([flywheel, gearbox], [crank, pilot], [clutch, Torque(flywheel, (gas, 0, 0))], gravity=(0, 0, 0))
    return simulate(system, 2.0)


half = 0.5 * ENGINE * CAR / (ENGINE + CAR) * SPEED**2
figure = Figure(figsize=(6.4, 3.6), layout="constrained")
axes = figure.subplots()
for grip in (100.0, 200.0, 400.0):
    run = started(grip)
    locks, speed, heat = run.events[0].t, run.rate("crank")[-1], -run.work("clutch")[-1]
    print(f"{grip:.0f} N m: slips for {locks:.4f} s, then both turn at {speed:.3f} rad/s; heat {heat:.2f} J")
    axes.plot(run.t, run.omega("engine")[:, 0], label=f"engine, {grip:.0f} N m")
    axes.plot(run.t, run.omega("car at the gearbox")[:, 0], label=f"car, {grip:.0f} N m")
print(f"J1 J2 / (J1 + J2) dw^2 / 2 = {half:.2f} J, both end at {SPEED * ENGINE / (ENGINE + CAR):.3f} rad/s")
gas, grip = 80.0, 200.0
longer = SPEED / (grip / ENGINE + grip / CAR - gas / ENGINE)
print(f"on the gas: {-started(grip, gas).work('clutch')[-1]:.2f} J, closed form {0.5 * grip * SPEED * longer:.2f} J")
axes.set(xlabel="time [s]", ylabel="speed at the gearbox [rad/s]")
axes.legend()
