"""Tables of a study as rows of text, header first, for the command line and for the page."""

import numpy as np

from validation.nvh.engine import balance_shafts
from validation.nvh.held.rigid_modes import DIRECTIONS
from validation.nvh.study import Study

Rows = list[list[str]]
LEAST = 1e-3  # of the largest: smaller orders are left out
LATE = (0.0, 1.0, 3.0, 6.0, 10.0)  # degrees of a shaft; a tooth of forty is nine


def figure(x: float, size: float = 0.0) -> str:
    """Four digits, 0 for rounding of something of this size."""
    return "0" if abs(x) <= 1e-9 * size else f"{x:.4g}"


def loads(study: Study) -> Rows:
    """Orders of the load on the block at the study's speed, forces and moments about the middle of the crank."""
    load = study.source.at(study.rpm)
    found = [["order", "Hz", "F_x [N]", "F_y [N]", "F_z [N]", "M_x [N m]", "M_y [N m]", "M_z [N m]"]]
    six = np.abs(load.six)
    sizes = np.array([six[1:, :3].max(), six[1:, 3:].max()]).repeat(3)
    for order, row in zip(load.orders[1:], six[1:], strict=True):
        if (row > LEAST * np.maximum(sizes, 1.0)).any():
            frequency = order * study.rpm / 60
            found.append([f"{order:g}x", f"{frequency:.1f}", *(figure(x, max(sizes)) for x in row)])
    return found


def timing(study: Study) -> Rows:
    """What balance shafts leave of their order at the study's speed if they are fitted late."""
    rows = [["late by [degrees]", "force [N]", "couple [N m]", "torque [N m]"]]
    preset, fitted = study.preset, study.source.fitted
    size = preset.engine(study.rpm).single
    for degrees in LATE:
        values = balance_shafts.left(preset, fitted, study.rpm, np.radians(degrees))
        rows.append([f"{degrees:g}", *(figure(x, size) for x in values)])
    return rows


def modes(study: Study) -> Rows:
    """Rigid-body modes with their kinetic energy by direction [%]."""
    rows = [["mode", "mostly", "Hz", *DIRECTIONS]]
    for k, mode in enumerate(study.modes, start=1):
        rows.append([str(k), mode.main, f"{mode.frequency:.2f}", *(f"{100 * share:.1f}" for share in mode.shares)])
    return rows


def mounts(study: Study) -> Rows:
    """Places [mm] and rates [N/mm], as built and decoupled."""
    rows = [["mount", "", "x", "y", "z [mm]", "k_1", "k_2", "k_3 [N/mm]"]]
    for kind, placed in (("as built", study.placed), ("decoupled", study.decoupled.mounts)):
        for mount in placed:
            values = [f"{1e3 * x:.0f}" for x in mount.at] + [f"{x / 1e3:.0f}" for x in mount.rates]
            rows.append([mount.name, kind, *values])
    return rows


def handed_on(study: Study) -> Rows:
    """What the mounts hand on at the study's speed: by order, linear and in the full run."""
    rows = [["order", "Hz", "engine [N]", "car [N]", "car / engine", "mount [N]", "full run off by [%]"]]
    here, (size, off) = study.here, study.differences
    engine, car = (np.linalg.norm(np.abs(part), axis=-1) for part in (here.load[0, 1:, :3], here.total[0, 1:]))
    for k, order in enumerate(here.orders[1:]):
        if size[k] > LEAST * size.max():
            ratio = f"{car[k] / engine[k]:.4f}" if engine[k] > LEAST * engine.max(initial=1.0) else "moment only"
            forces = figure(engine[k], engine.max()), figure(car[k]), ratio, figure(size[k])
            rows.append([f"{order:g}x", f"{order * study.rpm / 60:.1f}", *forces, f"{100 * off[k] / size[k]:.2g}"])
    return rows


def bearings(study: Study) -> Rows:
    """Loads of the main bearings over a cycle."""
    rows = [["bearing", "", "peak [N]", "mean [N]", "peak pressure [MPa]", "roller: P_m [N]", "L10h [h]"]]
    for bearing in study.bearings:
        radial = bearing.radial
        numbers = f"{radial.max():.0f}", f"{radial.mean():.0f}", f"{bearing.pressure / 1e6:.1f}"
        rows.append([bearing.name, "", *numbers, f"{bearing.mean:.0f}", f"{bearing.hours:.3g}"])
    return rows


def facts(study: Study) -> list[tuple[str, str]]:
    """The engine and its mounts in a few lines."""
    p, (shift, turn) = study.preset, study.sag
    (built, f_built), (free, f_free) = study.roll_shares
    cycle, gas, pressure = study.source.cycle, "motored, no gas", ""
    if cycle is not None:
        gas = f"{study.load:.0%} load, mean torque {study.source.mean_torque:.1f} N m"
        pressure = f"peak {cycle.samples[1].max() / 1e5:.1f} bar, indicated mean {cycle.mean_pressure / 1e5:.2f} bar"
    found = [
        ("engine", f"{p.title}; {p.displacement * 1e6:.0f} cm3, {p.bore * 1e3:g} x {p.stroke * 1e3:g} mm"),
        ("running", f"{study.rpm:g} rpm, {gas}"),
        ("cylinder", pressure),
        ("masses", f"piston {p.piston_mass:g} kg, rod {p.rod_mass:g} kg, powertrain {study.body.mass:.1f} kg"),
        ("balance shafts", balance_shafts.described(study.preset, study.source.fitted)),
        ("car", study.car.title),
        ("sag", f"{-1e3 * shift[2]:.2f} mm, turned by {np.degrees(np.linalg.norm(turn)):.3f} degrees"),
        ("rolled by mean torque", f"{np.degrees(study.on_mounts.roll):.2f} degrees"),
        ("roll about torque-roll axis", f"{100 * built:.1f} % of a mode at {f_built:.2f} Hz"),
        ("after decoupling", f"{100 * free:.4f} % at {f_free:.2f} Hz, mounts moved by up to "
                             f"{1e3 * study.decoupled.moved:.0f} mm, rates by up to {study.decoupled.rates:.2f}"),
    ]  # fmt: skip
    return [(name, text) for name, text in found if text]
