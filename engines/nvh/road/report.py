"""Tables, figure and page of a ride on a road."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from markupsafe import Markup

from engines import closed_forms
from engines.balance.pages.site import TEMPLATES, playing
from engines.nvh.mounts.mounts import Car
from engines.nvh.road.measured import Measured, read_road
from engines.nvh.road.profile import SPATIAL_FREQUENCY_MAX, Road
from engines.nvh.road.ride import Ride, rms, verdict, weight
from engines.nvh.road.vehicle import GRAVITY, KINDS, Vehicle
from mbsd3d import linearize, simulate
from mbsd3d.errors import InputError
from mbsd3d.extend import (
    LINE_WIDTH_POINTS,
    digits,
    inline_svg,
    new_figure,
    number,
    page_template,
    style_axes,
    write_atomically,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Rows = list[list[str]]
SPEEDS = np.arange(5.0, 45.1, 2.5)  # m/s
FIGURE_CLASSES = "ABCD"  # classes of a figure
TABLE_TRAVELS = (-0.06, -0.03, 0.0, 0.03, 0.06)  # [m] wheel travels in the table of a suspension
ANIMATION_SECONDS, ANIMATION_FRAMES = 4.0, 201  # s and pictures of the animation
BRAKING_RATIO = 0.5  # [1] of gravity: deceleration under braking


def ride_of(car: Car, kind: str, road: str, speed: float, linked: bool = False) -> Ride:
    """Return a car on a road of a class or of a file (with a dot in its name); raise ValueError if its wheels are
    unknown.
    """
    if car.ride is None:
        raise InputError(f"car '{car.name}' is not known on its wheels; give compact or saloon")
    speed = number(speed, "ride: speed", positive=True)
    return Ride(Vehicle(kind, car.ride, linked, speed), read_road(road) if "." in road else Road(road), speed)


def rides_of(car: Car, road: str, speed: float) -> list[Ride]:
    """Return quarter, half and whole car with wheels on slides and on links; the last is the whole car on its links."""
    return [ride_of(car, kind, road, speed, linked) for linked in (False, True) for kind in KINDS]


def quarter_car(ride: Ride) -> np.ndarray:
    """Return the phasors of the acceleration at the seat of a quarter car in closed form [m/s^2], shape (k,)."""
    (corner,) = ride.vehicle.corners
    rates = (corner.spring, corner.damper), (corner.tyre, corner.tyre_damping)
    body, _ = closed_forms.quarter_car(ride.rates, (ride.vehicle.mass, corner.mass), *rates)
    return -(ride.rates**2) * body * ride.under(corner)


def comfort(rides: list[Ride]) -> Rows:
    """Tabulate the vibration at the seat of every car, by small motions and in the full motion."""
    rows = [["car", "verdict", "a [m/s^2]", "a_w [m/s^2]", "a_w, full motion", "differ by [%]", "freedoms"]]
    for ride in rides:
        full = rms(weight(ride.rates / (2 * np.pi)) * ride.run_seat)
        numbers = f"{rms(ride.seat):.4f}", f"{ride.weighted:.4f}", f"{full:.4f}", f"{100 * ride.difference:.2g}"
        rows.append([ride.vehicle.title, ride.verdict, *numbers, str(ride.vehicle.at_seat.size)])
    return rows


def modes(ride: Ride) -> Rows:
    """Tabulate the small motions of the car on its wheels."""
    rows, r = [["mode", "mostly", "Hz", "damping"]], ride.vehicle.ride
    system = ride.vehicle.system()
    for mode in linearize(system).modes:
        if mode.frequency > 0.0:
            up, (roll, pitch, _) = np.abs(mode.translation[:, 2]), np.abs(mode.rotation[0])
            moved = {"heave": up[0], "roll": roll * r["track"] / 2, "pitch": pitch * r["wheelbase"] / 2}
            moved |= {f"hop, {body.name.split()[0]}": z for body, z in zip(system.bodies[1:], up[1:], strict=True)}
            name = max(moved, key=moved.__getitem__)
            rows.append([str(len(rows)), name, f"{mode.frequency:.3f}", f"{mode.damping_ratio:.3f}"])
    return rows


def struts(ride: Ride) -> Rows:
    """Tabulate the loads of springs, dampers and tyres in the full motion."""
    rows = [["wheel", "", "travel rms [mm]", "most [mm]", "damper most [m/s]", "strut most [N]", "tyre rms [N]",
             "tyre least [N]"]]  # fmt: skip
    for corner in ride.vehicle.corners:
        strut, tyre = ride.run.force(f"spring of {corner.name}"), ride.tyre_load(corner)
        assert strut.length is not None and strut.rate is not None  # of a spring
        travel, force = 1e3 * (strut.length - strut.length.mean()), np.linalg.norm(strut.force, axis=1)
        values = travel.std(), np.abs(travel).max(), np.abs(strut.rate).max(), force.max(), tyre.std(), tyre.min()
        rows.append([corner.name, "", *(f"{x:.4g}" for x in values)])
    return rows


def lifted(ride: Ride) -> str:
    """Return in a line which wheel would leave the road most, and for how long; nothing if none does."""
    loads = {corner.name: ride.tyre_load(corner) for corner in ride.vehicle.corners}
    name = min(loads, key=lambda wheel: loads[wheel].min())
    least, share = loads[name].min(), (loads[name] < 0.0).mean()
    if least >= 0.0:
        return ""
    return (
        f"the {name} would leave the road on {100 * share:.2g} % of the way: its tyre, a linear one, pulls with up to "
        f"{-least:.0f} N there"
    )


def guides(vehicle: Vehicle) -> Rows:
    """Tabulate the suspension kinematics of both axles over the wheel travel."""
    rows = [["axle", "guide", "up [mm]", "toe-in [min]", "camber [deg]", "outwards [mm]", "motion ratio",
             "roll centre [mm]"]]  # fmt: skip
    for axle, held in zip(("front", "rear"), vehicle.guides, strict=True):
        for z in TABLE_TRAVELS:
            toe, camber, track, ratio, centre = (
                round(held.curves.at(name, z), 9) + 0.0 for name in ("toe", "camber", "track", "ratio", "roll_centre")
            )
            values = f"{60 * np.degrees(toe):.1f}", f"{np.degrees(camber):.2f}", f"{1e3 * track:.1f}"
            rows.append([axle, held.kind, f"{1e3 * z:g}", *values, f"{-ratio:.4f}", f"{1e3 * centre:.0f}"])
    return rows


def braking(vehicle: Vehicle) -> str:
    """Return anti-dive and anti-lift in a line, and their effect on the car under braking."""
    (dive, lift), front = vehicle.anti, vehicle.ride["brakes"]
    linked, slid = (np.degrees(Vehicle("whole", vehicle.ride, on).braked(BRAKING_RATIO)) for on in (True, False))
    return (
        f"anti-dive in front {dive:.0%}, anti-lift behind {lift:.0%}, {front:.0%} of braking in front; at "
        f"{BRAKING_RATIO * GRAVITY:.1f} m/s^2 the body dives by {linked:.2f} degrees, on slides it would by {slid:.2f}"
    )


def preloads(vehicle: Vehicle) -> str:
    """Return in a line the effect of the loads of the struts on the stiffness at the wheels."""
    front, rear = vehicle.by_load
    return (
        f"as the motion ratio changes over the travel, the load of the strut is {front:+.1%} of the stiffness at the "
        f"wheel in front, {rear:+.1%} behind; the spring is the rest"
    )


def guide_figure(vehicle: Vehicle) -> "Figure":
    """Plot toe-in, camber and motion ratio of both axles over the travel."""
    degree = np.degrees(1.0)
    shown = ("toe", "toe-in [min]", 60 * degree), ("camber", "camber [°]", degree), ("ratio", "motion ratio", -1.0)
    with new_figure(7.5, 2.8) as (made, look):
        for axes, (name, label, scale) in zip(made.subplots(1, 3), shown, strict=True):
            style_axes(axes, look)
            for k, (axle, held) in enumerate(zip(("front", "rear"), vehicle.guides, strict=True)):
                values, line = scale * getattr(held.curves, name), f"{axle}, {held.kind}"
                axes.plot(values, 1e3 * held.curves.z, color=look.colour(k), linewidth=LINE_WIDTH_POINTS, label=line)
            axes.set(xlabel=label, ylabel="up [mm]" if name == "toe" else "")
        made.legend(
            *axes.get_legend_handles_labels(), frameon=False, labelcolor=look.ink, ncols=2, loc="outside lower right"
        )
    return made


def figure(ride: Ride) -> "Figure":
    """Plot the acceleration at the seat over frequency, and weighted over the speed on several roads."""
    f = ride.rates / (2 * np.pi)
    with new_figure(7.5, 5.4) as (made, look):
        upper, lower = made.subplots(2, 1)
        for axes in (upper, lower):
            style_axes(axes, look)
        width = f[1] - f[0]
        band = np.abs(ride.seat) / np.sqrt(2 * width)
        upper.loglog(f, np.abs(ride.run_seat) / np.sqrt(2 * width), ".", color=look.colour(1), markersize=3)
        upper.loglog(f, band, color=look.colour(0), linewidth=LINE_WIDTH_POINTS)
        upper.loglog(f, band * np.abs(weight(f)), color=look.ink, linewidth=LINE_WIDTH_POINTS)
        upper.set(xlabel="frequency [Hz]", ylabel="m/s² per √Hz")
        upper.set_title("lines: small motions, below weighted by W_k; dots: full motion", loc="left")
        for axis in (upper.xaxis, upper.yaxis):
            axis.set_major_formatter(lambda x, _: f"{x:g}")
        rolling = [replace(ride.vehicle, speed=float(speed)) for speed in SPEEDS]
        for k, kind in enumerate(FIGURE_CLASSES):
            over = [Ride(vehicle, Road(kind), speed).weighted for vehicle, speed in zip(rolling, SPEEDS, strict=True)]
            lower.plot(SPEEDS, over, color=look.colour(k), linewidth=LINE_WIDTH_POINTS, label=f"class {kind}")
        lower.plot([ride.speed], [ride.weighted], "o", color=look.ink)
        lower.set(xlabel="speed [m/s]", ylabel="weighted [m/s²]", ylim=(0.0, None))
        made.legend(frameon=False, labelcolor=look.ink, ncols=len(FIGURE_CLASSES), loc="outside lower right")
    return made


def response_figure(rides: list[Ride]) -> "Figure":
    """Plot the acceleration of the body over that of the road: quarter cars by small motions, and in closed form."""
    slid, linked = (ride for ride in rides if ride.vehicle.kind == "quarter")
    f = slid.rates / (2 * np.pi)
    with new_figure(7.5, 2.8) as (made, look):
        axes = made.add_subplot()
        style_axes(axes, look)
        for k, (ride, label) in enumerate(((slid, "wheel on a slide"), (linked, "wheel on its links"))):
            gain = np.abs(ride.seat / (ride.rates**2 * ride.under(ride.vehicle.corners[0])))
            axes.loglog(f, gain, color=look.colour(k), linewidth=LINE_WIDTH_POINTS, label=label)
        few = np.unique(np.geomspace(1, f.size, 25).astype(int) - 1)
        known = np.abs(quarter_car(slid) / (slid.rates**2 * slid.under(slid.vehicle.corners[0])))
        axes.loglog(f[few], known[few], "o", color=look.ink, markersize=3, label="closed form")
        axes.set(xlabel="frequency [Hz]", ylabel="body over road")
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_formatter(lambda x, _: f"{x:g}")
        axes.legend(frameon=False, labelcolor=look.ink, loc="lower left")
    return made


def left_out(ride: Ride) -> str:
    """Return in a line the waves of a road from a file that are left out; nothing for a road class."""
    if not isinstance(ride.road, Measured):
        return ""
    shortest = 1e3 / SPATIAL_FREQUENCY_MAX
    return f"waves below {shortest:.0f} mm do not count: {1e3 * ride.road.left_out:.2g} mm rms of the road"


def write_page(car: Car, rides: list[Ride], folder: str | Path) -> Path:
    """Write ``ride-CAR.html`` and its view into a folder that exists, of the last of some rides with the others for
    comparison; return the path of the page.
    """
    folder, view, ride = Path(folder), f"ride-{car.name}-view.html", rides[-1]
    run, end = ride.run, float(ride.run.t[0]) + ANIMATION_SECONDS
    film = simulate(ride.system, end, state=run.state(0), output=np.linspace(run.t[0], end, ANIMATION_FRAMES))
    title = car.title.split(",")[0]
    shown = film.animate(curves=(), traces=(), hidden=("body names",), speed=1.0, title=title).html
    write_atomically(folder / view, playing(shown).encode())
    page = page_template("ride.html", TEMPLATES).render(
        car=car, ride=ride, view=view, verdict=verdict(ride.weighted), digits=digits,
        figure=Markup(inline_svg(figure(ride), "ride-")), comfort=comfort(rides), modes=modes(ride),
        struts=struts(ride), guides=guides(ride.vehicle), braking=braking(ride.vehicle), left_out=left_out(ride),
        preloads=preloads(ride.vehicle), lifted=lifted(ride),
        guide_figure=Markup(inline_svg(guide_figure(ride.vehicle), "guide-")),
        response=Markup(inline_svg(response_figure(rides), "response-")),
    )  # fmt: skip
    return write_atomically(folder / f"ride-{car.name}.html", page.encode())
