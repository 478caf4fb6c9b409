"""Engine and car as files to edit: `--export` writes them, `LAYOUT`, `--car` and `--shell` read them."""

import json
import re
from dataclasses import asdict
from pathlib import Path

import numpy as np

from engines.balance.gas import firing_order
from engines.nvh.cabin.table import SEAT_NAME, write_modes
from engines.nvh.excitation.presets import LAYOUT_FIELDS, POSITIVE_FIELDS, Preset
from engines.nvh.records import Record
from engines.nvh.study import Study
from mbsd3d.extend import write_atomically


def export(study: Study, folder: str | Path) -> list[Path]:
    """Write ``ENGINE.json``, ``CAR.json`` with the mounts as they are for this engine, and ``CAR-modes.csv`` if its
    shell is known, into a folder that exists; return their paths.
    """
    folder, car, preset = Path(folder), study.car, study.preset
    found = [written(engine_record(preset), folder / f"{preset.name}.json")]
    mounts = {
        mount.name: {key: getattr(mount, key) for key in ("at", "rates", "damping", "angle")} for mount in study.placed
    }
    parts = {key: getattr(car, key) for key in ("ride", "shell") if getattr(car, key) is not None}
    found.append(written({"title": car.title, "bounce": None, "mounts": mounts, **parts}, folder / f"{car.name}.json"))
    if study.shell_known:
        cabin = study.cabin
        places = [*mounts, SEAT_NAME]
        shapes = np.hstack([cabin.at_feet, cabin.at_seat])
        found.append(write_modes(cabin.shell, shapes, places, folder / f"{car.name}-modes.csv"))
    return found


def engine_record(preset: Preset) -> Record:
    """Return the fields of an engine's file, with cylinders one by one."""
    layout, block = preset.layout, asdict(preset.block)
    stations = [z * preset.spacing / layout.spacing for z in layout.stations]
    plan = dict(zip(LAYOUT_FIELDS, (layout.pins, layout.bores, stations, firing_order(layout)), strict=True))
    numbers = {name: getattr(preset, name) for name in (*POSITIVE_FIELDS, "balanced")}
    return {"title": preset.title, **plan, **numbers, "block": block}


def written(record: Record, path: Path) -> Path:
    """Format a record as JSON, lists of numbers in a line, nine digits."""
    text = json.dumps(json.loads(json.dumps(record), parse_float=lambda x: float(f"{float(x):.9g}")), indent=1)
    text = re.sub(r"\[[^][{}]*\]", lambda found: " ".join(found[0].split()), text)
    return write_atomically(path, (text + "\n").encode())
