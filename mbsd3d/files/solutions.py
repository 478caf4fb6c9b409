"""Solutions in one file, without pickle, and files that are written whole or not at all."""

import io
import json
import zipfile
import zlib
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..base.errors import InputError
from ..base.paths import as_path, package_version, with_suffix, write_atomically
from ..equations.compiled import Compiled, compile_system, modes_at, with_history
from ..mechanism.state import State
from ..results.events import Event
from ..results.joined import in_pieces
from ..results.record import Record, RunOptions
from ..results.result import RunResult
from .description import MODEL_FORMAT_VERSION, Reader, Writer, check_format, describe, read_system

SOLUTION_KIND = "mbsd3d solution"
STORED_OPTIONS = ("method", "rtol", "switches")  # of `RunOptions`, which a file keeps
STATE_SLICES = ("q", "z")  # slices of the array "state"
STORED_ARRAYS = ("t", "state", "v", "acceleration", "lam", "coordinate", "potential", "power", "residual")
DAMAGED_FILE_ERRORS = (  # RuntimeError: encrypted, of a newer zip, nested too deep
    OSError, ValueError, KeyError, TypeError, EOFError, MemoryError, RuntimeError, OverflowError, zipfile.BadZipFile,
    zlib.error,
)  # fmt: skip


def save(solution: RunResult, path: str | Path) -> Path:
    """Write a solution; see `Solution.save`."""
    return write_atomically(with_suffix(path, ".npz"), solution_bytes(solution))


def solution_bytes(solution: RunResult) -> bytes:
    """Return the file of a solution: its arrays, and the rest as JSON text."""
    system, record = solution.system, solution.record
    write, (error, order, doubling) = Writer(system), solution.estimated
    count = len(compile_system(system).coordinate_index)  # without that of the measure of stop_when
    start, final = (
        replace(x, moved={}, coordinates=None if x.coordinates is None else x.coordinates[:count])
        for x in (solution.start, solution.final)
    )
    document = {
        "format": SOLUTION_KIND,
        "version": MODEL_FORMAT_VERSION,
        "written_by": package_version(),
        "system": describe(system, without_functions=True),
        "record": record_entry(write, record),
        "start": write.part(start, "start"),
        "final": write.part(final, "final state"),
        "estimate": {"error": error, "order": order, "doubling": doubling},
    }
    if solution.pieces:
        document["events"] = [write.part(event, "event") for event in solution.events]
        document["pieces"] = [
            {
                "samples": piece.t.size,
                "modes": write.value(dict(piece.compiled.modes), "modes"),
                "record": record_entry(write, piece.record),
            }
            for piece in solution.pieces
        ]
    arrays = {name: np.asarray(array, float) for name, array in solution.arrays.items() if name not in STATE_SLICES}
    arrays["coordinate"] = arrays["coordinate"][:, :count]
    text = np.frombuffer(json.dumps(document, allow_nan=False).encode(), np.uint8)
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, json=text, **arrays)
    return buffer.getvalue()


def record_entry(write: Writer, record: Record) -> dict[str, Any]:
    """Return the JSON object of a record; method, tolerance and switches stand beside the statistics of the run."""
    own = write.part(replace(record, options=RunOptions()), "record")
    del own["options"]
    options = {name: write.value(getattr(record.options, name), f"record: {name}") for name in STORED_OPTIONS}
    return {"type": own.pop("type")} | options | ({"kinematic": True} if record.kinematic else {}) | own


def nested_options(entry: Any) -> Any:
    """Return the JSON object of a record with its options as an object of their own, as `Record` has them."""
    if not isinstance(entry, dict):
        return entry
    own = {name: value for name, value in entry.items() if name not in (*STORED_OPTIONS, "kinematic")}
    return own | {"options": {"type": "RunOptions"} | {name: entry.get(name) for name in STORED_OPTIONS}}


def read_run(path: str | Path) -> RunResult:
    """Read the result in a file of `save`; see `mbsd3d.load`."""
    found = as_path(path, "result.npz")
    source = found if found.is_file() else with_suffix(path, ".npz")
    if not source.is_file():
        raise InputError(f"'{source}' does not exist; give a file written by solution.save(path)")
    try:
        with source.open("rb") as handle:
            return read_solution(handle)
    except DAMAGED_FILE_ERRORS as error:
        reason = str(error) or type(error).__name__
        raise InputError(
            f"'{source}' cannot be read as a solution, it is of another kind, truncated or changed ({reason}); "
            "give a file written by solution.save(path), or run the simulation again"
        ) from error


def read_solution(handle: Any) -> RunResult:
    """Check arrays and text of an open file against each other, and return them: kernels do not check bounds."""
    if not zipfile.is_zipfile(handle):
        raise InputError("no complete .npz file")
    check_entries(handle)
    handle.seek(0)
    with np.load(handle, allow_pickle=False) as stored:
        arrays = {name: stored[name] for name in stored.files}
    document = json.loads(bytes(arrays.pop("json")))
    check_format(document, SOLUTION_KIND, "its text")
    system, reader = read_system(document["system"])
    record = reader.part(nested_options(document["record"]), ("record",), Record)
    final = reader.part(document["final"], ("final",), State)
    start = reader.part(document["start"], ("start",), State) if "start" in document else None  # older files
    record.rank_events = list(record.rank_events)
    compiled = with_history(compile_system(system, (), record.switches), record.inputs)
    if record.tolerance:
        record.options = replace(record.options, as_built=record.tolerance * compiled.model.length)
    pieces = [read_piece(reader, entry, compiled, final) for entry in document.get("pieces", [])]
    check_arrays(compiled, arrays, [final] if start is None else [start, final], [one for _, one in pieces])
    n = len(system.bodies)
    arrays["q"] = arrays["state"][:, : 7 * n].reshape(-1, n, 7)
    arrays["z"] = arrays["state"][:, 13 * n :]
    estimate = document["estimate"]
    estimated = estimate["error"], estimate["order"], estimate.get("doubling")
    run = RunResult(compiled, arrays, record, start or final, final, estimated)
    if pieces and start is not None:
        return with_pieces(run, pieces, [reader.part(x, ("events",), Event) for x in document["events"]])
    return run if start is not None or not run.t.size else replace(run, start=run.state(0))


def read_piece(reader: Reader, entry: dict[str, Any], compiled: Compiled, final: State) -> tuple[int, RunResult]:
    """Return the number of samples of a piece of a run with events, and the piece without them."""
    record = reader.part(nested_options(entry["record"]), ("pieces",), Record)
    record.rank_events = list(record.rank_events)
    modes = modes_at(compiled.system, replace(final, modes=reader.value(entry["modes"], ("pieces",))))
    own = compile_system(compiled.system, (), record.switches, modes)
    return int(entry["samples"]), RunResult(own, {}, record, final, final)


def with_pieces(run: RunResult, pieces: list[tuple[int, RunResult]], events: list[Event]) -> RunResult:
    """Return a run whose pieces read their share of its samples, and start with the first of them."""
    if sum(count for count, _ in pieces) != run.t.size or len(events) != len(pieces) - 1:
        raise InputError("its pieces and events do not fit its samples")
    whole = in_pieces(replace(run, events=tuple(events)), [piece for _, piece in pieces], [n for n, _ in pieces])
    begins = np.cumsum([0, *(n for n, _ in pieces)])
    starts = [run.start, *(whole.state(int(k)) for k in begins[1:-1])]
    made = (replace(piece, start=start) for piece, start in zip(whole.pieces, starts, strict=True))
    return replace(whole, pieces=tuple(made))


def check_entries(handle: Any) -> None:
    """Check names and sizes before anything is unpacked: `save` compresses nothing."""
    handle.seek(0)
    with zipfile.ZipFile(handle) as archive:
        entries = archive.infolist()
    names = {entry.filename for entry in entries}
    if len(names) < len(entries) or not names <= {f"{name}.npy" for name in (*STORED_ARRAYS, "json")}:
        odd = sorted(names - {f"{name}.npy" for name in (*STORED_ARRAYS, "json")})[:1] or ["one twice"]
        raise InputError(f"it holds '{odd[0]}', which no solution has")
    for entry in entries:
        if entry.compress_type != zipfile.ZIP_STORED:
            raise InputError(f"'{entry.filename}' is compressed, which solution.save never does")


def check_arrays(
    compiled: Compiled, arrays: dict[str, Any], states: list[State], pieces: Sequence[RunResult] = ()
) -> None:
    """Check that every array is there with the shape the model gives it."""
    model, system, n = compiled.model, compiled.system, len(compiled.system.bodies)
    rows = max([one.compiled.row_joint.size for one in pieces], default=compiled.row_joint.size)
    coordinates, elements = len(compiled.coordinate_index), len(system.forces)
    shapes = {
        "t": (), "state": (13 * n + model.z_impulse + 6,), "v": (n, 6), "acceleration": (n, 6), "lam": (rows,),
        "coordinate": (coordinates,), "potential": (elements,), "power": (elements,), "residual": (2,),
    }  # fmt: skip
    samples = np.shape(arrays["t"])[:1]
    for name, shape in shapes.items():
        array = arrays[name]
        if not isinstance(array, np.ndarray) or array.dtype != float or array.shape != (*samples, *shape):
            raise InputError(f"array '{name}' has shape {np.shape(array)}, its system needs {(*samples, *shape)}")
    for state in states:
        numbers = coordinates if state.coordinates is None else np.size(state.coordinates)
        if (state.q.size, numbers) != (7 * n, coordinates) or state.z.size not in (model.z_work, 0):
            raise InputError("the start or the final state does not fit the system")
