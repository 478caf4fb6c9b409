"""Tables of a study as rows of text, header first, for the command line and for the page."""

import numpy as np
from scipy.integrate import cumulative_simpson

from engines.balance.pages.portrait import upright
from engines.nvh.cabin.seat import rms
from engines.nvh.excitation import balance_shafts, presets
from engines.nvh.excitation.loads import Source
from engines.nvh.mounts.rigid_modes import DIRECTIONS
from engines.nvh.study import AGREEMENT_SHARE_MAX, Study, Sweep
from mbsd3d.errors import InputError

Rows = list[list[str]]
ORDER_SHARE_MIN = 1e-3  # [1] of the largest order; smaller ones are left out
FORCE_SHARE_MIN = 1e-6  # [1] of the 1x force of a cylinder; smaller forces are those of moments
RESONANCE_SHARE = 0.2  # [1] of the amplitude at resonance; beyond it motions are too large for a linear map
SHELL_FREQUENCY_MAX = 200.0  # [Hz] modes of a shell beyond it are left out


def figure(x: float, size: float = 0.0) -> str:
    """Format a number: four digits, 0 for rounding of a value of this size."""
    return "0" if abs(x) <= 1e-9 * size else f"{x:.4g}"


def engines() -> Rows:
    """Tabulate all engines, with the orders that their layout leaves at the redline."""
    rows = [["", "engine", "1/min", "1x [N]", "2x [N]", "1x [N m]", "2x [N m]"]]
    for name in presets.names():
        chosen = presets.preset(name)
        six, single = np.abs(Source(chosen, 0.0).at(chosen.redline).six), chosen.engine(chosen.redline).single
        sizes = [np.linalg.norm(six[2 * k, part]) for part in (slice(0, 3), slice(4, 6)) for k in (1, 2)]
        numbers = (f"{x:.0f}" if x > ORDER_SHARE_MIN * single else "0" for x in sizes)
        rows.append([name, chosen.title, f"{chosen.idle:g}-{chosen.redline:g}", *numbers])
    return rows


def on_engine(study: Study) -> list[tuple[str, Rows]]:
    """Return (title, table) from the block to the forces on the car."""
    found = [("load on the block", loads(study))]
    if study.source.fitted:
        found.append(("balance shafts with assembly errors", faults(study)))
        if (of_pair := heights(study)) is not None:
            found.append(("balance shafts at different heights", of_pair))
    return [
        *found, ("main bearings", bearings(study)), ("modes on the mounts", modes(study)),
        ("shapes of the modes", shapes(study)), ("mounts", mounts(study)), ("forces on the car", handed_on(study)),
    ]  # fmt: skip


def loads(study: Study) -> Rows:
    """Tabulate the orders of the load on the block at the study's speed: forces and moments about the middle of the
    crank, and the torque that turns the crank.
    """
    load = study.source.at(study.rpm)
    found = [["order", "Hz", "F_x [N]", "F_y [N]", "F_z [N]", "M_x [N m]", "M_y [N m]", "M_z [N m]", "crank [N m]"]]
    seven = np.abs(np.column_stack([load.six, load.torque]))
    sizes = np.array([seven[1:, :3].max(), seven[1:, 3:].max()]).repeat((3, 4))
    for order, row in zip(load.orders[1:], seven[1:], strict=True):
        if (row > ORDER_SHARE_MIN * np.maximum(sizes, 1.0)).any():
            frequency = order * study.rpm / 60
            found.append([f"{order:g}x", f"{frequency:.1f}", *(figure(x, max(sizes)) for x in row)])
    return found


def faults(study: Study) -> Rows:
    """Tabulate the remainder of the order of wrongly fitted balance shafts at the study's speed in closed form, and its
    difference to the engine with geared shafts in space, over the 1x force of a cylinder.
    """
    rows = [["fault", "force [N]", "couple [N m]", "torque [N m]", "error in space"]]
    preset, size = study.preset, study.preset.engine(study.rpm).single
    for fault in balance_shafts.FAULTS:
        fitted = balance_shafts.faulty(preset, study.source.fitted, fault)
        known, found = (way(preset, fitted, study.rpm) for way in (balance_shafts.left, balance_shafts.left_in_space))
        force, couple, torque = (float(np.abs(part).max()) for part in (known[:2], known[2:4], known[4]))
        values = (figure(x, size) for x in (force, couple, torque))
        rows.append([fault.title, *values, f"{np.abs(found - known).max() / size:.0e}"])
    return rows


def heights(study: Study) -> Rows | None:
    """Tabulate the remaining roll moment of a pair of shafts at its order over its distance in height; None for no
    pair, or where no height helps.
    """
    fitted, preset, source = study.source.fitted, study.preset, study.source
    if len(fitted) != 2 or fitted[0].order != 2:
        return None
    try:
        full = balance_shafts.fitted(preset, "raised")
    except InputError:
        return None
    best = abs(np.subtract(*(np.array(shaft.position) @ upright(preset.layout)[2, :2] for shaft in full)))
    rows = [["difference in height [mm]", "roll 2x of inertia [N m]", "with gas at this load [N m]"]]
    for height in (0.0, best / 2, best, 1.5 * best):
        pair = tuple(balance_shafts.apart(preset, full, height))
        rolls = (abs(Source(preset, load, pair).at(study.rpm).six[4, 3]) for load in (0.0, source.load))
        rows.append([f"{1e3 * height:.1f}", *(figure(x, 1e3) for x in rolls)])
    return rows


def modes(study: Study) -> Rows:
    """Tabulate the rigid-body modes with their kinetic energy by direction [%]."""
    rows = [["mode", "mainly", "Hz", *DIRECTIONS]]
    for k, mode in enumerate(study.modes, start=1):
        shares = (f"{round(100 * share, 1) + 0.0:.1f}" for share in mode.shares)
        rows.append([str(k), mode.main, f"{mode.frequency:.2f}", *shares])
    return rows


def shapes(study: Study) -> Rows:
    """Tabulate the shapes of the rigid-body modes: motion of the centre of mass, scaled to 1 mm at the mount that moves
    most.
    """
    rows = [["mode", "mainly", "Hz", "x", "y", "z [mm]", "about x", "about y", "about z [mrad]"]]
    arms = np.array([mount.at for mount in study.placed]) - study.body.rigid.com
    for k, mode in enumerate(study.modes, start=1):
        heads = mode.shape[:3] + np.cross(mode.shape[3:], arms)
        values = mode.shape / np.linalg.norm(heads, axis=1).max()
        numbers = (f"{round(x, 3) + 0.0:.3f}" for x in values)
        rows.append([str(k), mode.main, f"{mode.frequency:.2f}", *numbers])
    return rows


def mounts(study: Study) -> Rows:
    """Tabulate places [mm] and rates [N/mm] of the mounts, as built and decoupled."""
    rows = [["mount", "", "x", "y", "z [mm]", "k_1", "k_2", "k_3 [N/mm]"]]
    for kind, placed in (("as built", study.placed), ("decoupled", study.decoupled.mounts)):
        for mount in placed:
            values = [f"{1e3 * x:.0f}" for x in mount.at] + [f"{x / 1e3:.0f}" for x in mount.rates]
            rows.append([mount.name, kind, *values])
    return rows


def handed_on(study: Study) -> Rows:
    """Tabulate the forces of the mounts on the car at the study's speed: by order, linear and in the full run."""
    rows = [["order", "Hz", "engine [N]", "car [N]", "car / engine", "mount [N]", "full motion differs by [%]"]]
    here, (size, off), single = study.here, study.differences, study.preset.engine(study.rpm).single
    engine, car = (np.linalg.norm(np.abs(part), axis=-1) for part in (here.load[0, 1:, :3], here.total[0, 1:]))
    for k, order in enumerate(here.orders[1:]):
        if size[k] > ORDER_SHARE_MIN * size.max():
            ratio = f"{car[k] / engine[k]:.4f}" if engine[k] > FORCE_SHARE_MIN * single else "moment only"
            forces = figure(engine[k], single), figure(car[k]), ratio, figure(size[k])
            rows.append([f"{order:g}x", f"{order * study.rpm / 60:.1f}", *forces, f"{100 * off[k] / size[k]:.2g}"])
    return rows


def why(study: Study) -> str:
    """Return the order of the largest difference between full run and map, its distance to resonance, and whether the
    map has that order; nothing if they agree.
    """
    if study.difference <= AGREEMENT_SHARE_MAX:
        return ""
    (order, mode, share), (size, off) = study.nearest, study.differences
    near = f"{share:.0%} of its amplitude at resonance" if share > RESONANCE_SHARE else "off resonance"
    turned = "; moving masses turn its neighbours into it" if size[off.argmax()] < off.max() else ""
    by = f"{order * study.rpm / 60:.1f} Hz, by {off.max():.2g} N"
    return f"most in {order:g}x, {by}, beside a mode of {mode:.1f} Hz, {near}{turned}"


def sweep(found: Sweep, most: int | None = None) -> Rows:
    """Tabulate the largest force of a mount over the speed, linear and in the full motion, and their difference;
    ``most``: rows of a shorter table, with the speed of the largest difference.
    """
    rows, count = [["1/min", "order", "linear [N]", "full motion [N]", "difference [%]"]], found.map.rpm.size
    chosen = np.linspace(0, count - 1, min(most or count, count)).astype(int)
    for s in np.union1d(chosen, found.off.argmax()):
        linear, full = (np.abs(part[s, 1:]).max(axis=(1, 2)) for part in (found.map.force, found.full))
        k = int(linear.argmax())
        forces = figure(linear[k]), figure(full[k])
        rows.append([f"{found.map.rpm[s]:.0f}", f"{found.map.orders[1:][k]:g}x", *forces, f"{100 * found.off[s]:.2g}"])
    return rows


def felt(study: Study) -> Rows:
    """Tabulate the acceleration of the seat rail by order, at the study's speed and load and at idle."""
    rows = [["", "order", "Hz", "x", "y", "z [mm/s^2]"]]
    for one in (study, study.idling):
        seat = np.abs(one.cabin.seat(one.here)[0])
        for order, row in zip(one.here.orders, 1e3 * seat, strict=True):
            if (row > ORDER_SHARE_MIN * 1e3 * seat.max()).any():
                what = f"{one.rpm:g} 1/min, {one.load:.0%} load"
                rows.append([what, f"{order:g}x", f"{order * one.rpm / 60:.1f}", *(figure(x) for x in row)])
    return rows


def shell(study: Study) -> Rows:
    """Tabulate the elastic modes of the shell, and the motion of the seat rail and of the mount that moves most in each
    for a modal mass of 1 kg.
    """
    rows, cabin = [["mode of the shell", "Hz", "damping", "seat rail", "most loaded mount [1/sqrt(kg)]"]], study.cabin
    sizes = (
        np.linalg.norm(part.reshape(len(part), -1, 3), axis=2).max(axis=1) for part in (cabin.at_seat, cabin.at_feet)
    )
    for rate, damping, *moved in sorted(zip(cabin.shell.rates, cabin.shell.damping, *sizes, strict=True)):
        if 0 < rate / (2 * np.pi) < SHELL_FREQUENCY_MAX:
            rows.append([str(len(rows)), f"{rate / (2 * np.pi):.1f}", f"{damping:g}", *(figure(x) for x in moved)])
    return rows


def paths(study: Study) -> tuple[str, Rows]:
    """Return (the largest component at the seat, the share of every path in it)."""
    parts = study.cabin.paths(study.here)[0]
    seat = parts.sum(axis=(1, 2))
    order, way = np.unravel_index(np.abs(seat).argmax(), seat.shape)
    title = f"{study.here.orders[order]:g}x along {'xyz'[way]}: {1e3 * abs(seat[order, way]):.3g} mm/s^2"
    rows = [["mount", "force", "alone [mm/s^2]", "phase [degrees]", "share [%]"]]
    for mount, forces in zip(study.placed, parts[order, :, :, way], strict=True):
        for name, path in zip("xyz", forces / seat[order, way], strict=True):
            alone, phase = 1e3 * abs(path * seat[order, way]), np.degrees(np.angle(path))
            rows.append(
                [mount.name, f"along {name}", figure(alone), f"{phase:.0f}", f"{round(100 * path.real, 1) + 0.0:.1f}"]
            )
    return title, rows


def bearings(study: Study) -> Rows:
    """Tabulate the loads of the main bearings over a cycle."""
    rows = [["bearing", "", "peak [N]", "mean [N]", "peak pressure [MPa]", "roller: P_m [N]", "L10h [h]"]]
    for bearing in study.bearings:
        radial = bearing.radial
        numbers = f"{radial.max():.0f}", f"{radial.mean():.0f}", f"{bearing.pressure / 1e6:.1f}"
        rows.append([bearing.name, "", *numbers, f"{bearing.mean:.0f}", f"{float(f'{bearing.hours:.3g}'):g}"])
    return rows


def seat_rail(study: Study) -> str:
    """Return the root mean squares at the seat rail in a line; nothing if the shell is not known."""
    if not study.shell_known:
        return ""
    here, idle = (float(rms(s.cabin.seat(s.here))[0]) for s in (study, study.idling))
    return f"{1e3 * here:.3g} mm/s^2 rms, at idle {1e3 * idle:.3g}"


def ripple(study: Study) -> str:
    """Return the range of the torque of gas and inertia at constant crank speed, and the speed fluctuation of a free
    crank.
    """
    angle = np.linspace(0.0, 4 * np.pi, 2881)
    gas, inertia = study.source.over_the_cycle(study.rpm, angle)
    torque = gas + inertia
    energy = cumulative_simpson(torque - torque[:-1].mean(), x=angle, initial=0.0)
    uneven = np.ptp(energy) / (study.body.rotor * study.preset.engine(study.rpm).rate ** 2)
    return f"{torque.min():.0f} to {torque.max():.0f} N m; speed fluctuation of a free crank {100 * uneven:.2g} %"


def facts(study: Study) -> list[tuple[str, str]]:
    """Return the engine and its mounts in a few lines."""
    p, (shift, turn) = study.preset, study.sag
    (built, f_built), (free, f_free) = study.roll_shares
    cycle, gas, pressure = study.source.cycle, "motored, no gas", ""
    if cycle is not None:
        gas = f"{study.load:.0%} load, mean torque {study.source.mean_torque:.1f} N m"
        pressure = f"peak {cycle.samples[1].max() / 1e5:.1f} bar, indicated mean {cycle.mean_pressure / 1e5:.2f} bar"
    found = [
        ("engine", f"{p.title}; {p.displacement * 1e6:.0f} cm^3, {p.bore * 1e3:g} x {p.stroke * 1e3:g} mm"),
        ("running", f"{study.rpm:g} rpm, {gas}"),
        ("cylinder", pressure),
        ("masses", f"piston {p.piston_mass:g} kg, rod {p.rod_mass:g} kg, powertrain {study.body.mass:.1f} kg"),
        ("balance shafts", balance_shafts.described(study.preset, study.source.fitted)),
        ("torque of the crank", ripple(study)),
        ("car", study.car.title),
        ("sag", f"{-1e3 * shift[2]:.2f} mm, turned by {np.degrees(np.linalg.norm(turn)):.3f} degrees"),
        ("roll under mean torque", f"{np.degrees(study.on_mounts.roll):.2f} degrees"),
        ("seat rail", seat_rail(study)),
        ("roll about torque-roll axis", f"{100 * built:.1f} % of a mode at {f_built:.2f} Hz"),
        ("after decoupling", f"{100 * free:.4g} % at {f_free:.2f} Hz, mounts moved by up to "
                             f"{1e3 * study.decoupled.moved:.0f} mm, rates by up to {study.decoupled.rates:.2f}"),
    ]  # fmt: skip
    return [(name, text) for name, text in found if text]
