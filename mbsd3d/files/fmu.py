"""Write a system as an FMU: FMI 3.0 co-simulation, run by the Python of the host in which mbsd3d is installed.

The FMU holds the description of the system as `System.to_file` writes it, a script of two lines that hands it to
`mbsd3d.files.fmu_instance`, and the binaries of pythonfmu3, which call that script.
"""

import hashlib
import json
import keyword
import re
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import fields, replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from ..base.checks import as_tuple, short_repr
from ..base.errors import InputError
from ..base.paths import as_path, write_atomically
from ..constraints.assembly import reference_state
from ..equations.compiled import compile_system, starts
from ..linear.inputs_outputs import input_unit, names_of
from ..mechanism import measures
from ..mechanism.measures import Measure
from ..mechanism.mechanism import Mechanism
from ..mechanism.signals.signal import Input
from ..mechanism.state import State
from ..results.record import RunOptions
from ..run.segments import Segments, driver_of
from ..run.simulation import check_state
from .description import Writer, describe, read_system

DOCUMENT = "mbsd3d_fmu.json"  # in the resources of an FMU
OWN_OUTPUTS = tuple(f"certificate.{x}" for x in ("passed", "worst", "work", "created"))  # of every FMU
HOST = "it runs where the host is Python with mbsd3d installed, as with FMPy; other hosts must load libpython first"
SCRIPT = '''"""Run by the Python of the host, in which mbsd3d must be installed."""
from mbsd3d.files.fmu_instance import FmuInstance
from pythonfmu3 import Fmi3Slave


class {name}(FmuInstance, Fmi3Slave):
    pass
'''
IDENTIFIER = re.compile(r"[A-Za-z_]\w*", re.ASCII)
AXES = np.eye(3)

Outputs = Mapping[str, Measure] | Sequence[Measure]
Parameter = str | tuple[Any, str]


def quoted(name: str) -> str:
    """Return a name of a part as FMI writes it: as it is, or in single quotes."""
    escaped = name.replace("\\", "\\\\").replace("'", "\\'")
    return name if IDENTIFIER.fullmatch(name) else f"'{escaped}'"


def usual_outputs(system: Mechanism) -> Iterator[tuple[str, Measure]]:
    """Yield (name, measure) of the angles and slides of all joints, and of positions and velocities of all bodies."""
    for joint in system.joints:
        name = quoted(system.name(joint))
        if joint.angle() is not None:
            yield from ((f"{name}.angle", measures.angle(joint)), (f"{name}.rate", measures.rate(joint)))
        if joint.slide() is not None:
            yield from ((f"{name}.slide", measures.slide(joint)), (f"{name}.slide_rate", measures.slide_rate(joint)))
    for body in system.bodies:
        for what in (measures.position, measures.velocity, measures.omega):
            for k, axis in enumerate(AXES, 1):
                yield f"{quoted(body.name)}.{what.__name__}[{k}]", what(body, axis=axis)


def named_outputs(system: Mechanism, outputs: Outputs | None) -> dict[str, Measure]:
    """Return name -> measure of the outputs asked for."""
    if outputs is None:
        found = list(usual_outputs(system))
    elif isinstance(outputs, Mapping):
        found = [(name, x) for name, x in outputs.items()]
    else:
        given = as_tuple(outputs, "to_fmu: outputs", "mbsd3d.measures, or a dict of name and measure")
        found = [(quoted(getattr(x, "label", "")), x) for x in given]
    for name, x in found:
        if not isinstance(x, Measure):
            raise InputError(f"to_fmu: outputs: {short_repr(x)} is not a measure; build one with mbsd3d.measures")
        measures.check_members(system, x, "to_fmu: outputs")
        if not isinstance(name, str) or not name.strip() or not name.isprintable():
            raise InputError(f"to_fmu: outputs: {short_repr(name)} is not a name; give a text, e.g. 'hinge.angle'")
    return unique(found, "to_fmu: outputs")


def unique(found: Sequence[tuple[str, Any]], what: str) -> dict[str, Any]:
    """Return pairs as a dict; a ValueError for a name that two have."""
    made: dict[str, Any] = {}
    for name, x in found:
        if name in made:
            raise InputError(f"{what}: two are named '{name}'; give a dict with a name for each")
        made[name] = x
    return made


def input_entries(system: Mechanism, inputs: Sequence[Input | str] | None) -> list[dict[str, Any]]:
    """Return the entries of the inputs: all, or those asked for; a ValueError for one that prescribes a motion."""
    compiled = compile_system(system)
    have = starts(compiled)
    entries: list[dict[str, Any]] = []
    if inputs is None and not have or (isinstance(inputs, list | tuple) and not inputs):
        return entries
    for name in names_of(system, inputs, "to_fmu"):
        if (driver := driver_of(system, name)) is not None:
            raise InputError(
                f"to_fmu: input '{name}' prescribes the motion of driver '{driver}', and would jump at every "
                "communication step; let it set a force, or a reference of a controller, or give inputs= without it"
            )
        unit = input_unit(compiled, name)
        entries.append({"name": quoted(name), "input": name, "unit": unit, "start": have[name], "description": "input"})
    return entries


def parameter_entries(
    system: Mechanism, described: dict[str, Any], parameters: Sequence[Parameter]
) -> list[dict[str, Any]]:  # fmt: skip
    """Return the entries of parameters, with the place of their numbers in the description of the system."""
    lists: dict[str, Sequence[Any]] = {"bodies": system.bodies, "joints": system.joints, "forces": system.forces}
    places = {system.name(part): (kind, i, part) for kind, parts in lists.items() for i, part in enumerate(parts)}
    entries = []
    for given in as_tuple(parameters, "to_fmu: parameters", "texts such as 'spring.stiffness'"):
        owner, _, field = given.rpartition(".") if isinstance(given, str) else ("", "", "")
        if isinstance(given, tuple) and len(given) == 2:
            owner, field = given[0] if isinstance(given[0], str) else system.name(given[0]), str(given[1])
        if owner not in places:
            raise InputError(f"to_fmu: parameters: {short_repr(given)} is of no part; give e.g. 'spring.stiffness'")
        kind, i, part = places[owner]
        taken = {x.name for x in fields(part) if x.init}
        value = getattr(part, field) if field in taken else None
        if not isinstance(value, int | float) or isinstance(value, bool):
            raise InputError(
                f"to_fmu: parameters: '{field}' of '{owner}' ({type(part).__name__}) is not a number that its "
                "constructor takes; give another one"
            )
        described[kind][i][field] = float(value)
        name, what = f"{quoted(owner)}.{field}", f"{field} of {type(part).__name__} '{owner}', SI units"
        entries.append(
            {"name": name, "unit": "-", "start": float(value), "description": what, "place": [kind, i, field]}
        )
    return entries


def document_of(
    system: Mechanism, state: State | None, inputs: Sequence[Input | str] | None, outputs: Outputs | None,
    parameters: Sequence[Parameter], options: RunOptions,
) -> dict[str, Any]:  # fmt: skip
    """Return all that an FMU of a system holds, as plain data."""
    described, write = describe(system), Writer(system)
    entries = {
        "inputs": input_entries(system, inputs),
        "outputs": [
            {"name": name, "unit": x.unit, "description": x.label, "measure": write.part(x, f"output '{name}'")}
            for name, x in named_outputs(system, outputs).items()
        ],
        "parameters": parameter_entries(system, described, parameters),
    }
    own = [{"name": name} for name in ("time", *OWN_OUTPUTS)]
    unique([(x["name"], x) for kind in (*entries.values(), own) for x in kind], "to_fmu: variables")
    found = {
        "title": system.title or "mechanism", "description": f"{system!r} by mbsd3d, {HOST}", "system": described,
        "start": None if state is None else write.part(state, "state"),
        "method": write.part(options.method, "method"), "rtol": options.rtol, **entries,
    }  # fmt: skip
    digest = hashlib.sha256(json.dumps(found, sort_keys=True).encode()).hexdigest()
    return found | {"hash": digest}


def begin(document: Mapping[str, Any], parameters: Mapping[str, float], t: float | None = None) -> Segments:
    """Return a run with parameters of its parts, at time t [s]; None = the time of its start."""
    described = deepcopy(document["system"])
    for entry in document["parameters"]:
        kind, place, field = entry["place"]
        described[kind][place][field] = parameters[entry["name"]]
    mechanism, reader = read_system(described)
    start = reader.part(document["start"], ("start",), State) if document["start"] else reference_state(mechanism, None)
    seen = [reader.part(x["measure"], ("outputs", i), Measure) for i, x in enumerate(document["outputs"])]
    options = RunOptions(reader.part(document["method"], ("method",)), document["rtol"])
    return Segments(mechanism, start if t is None else replace(start, t=t), options, seen)


def write_fmu(
    system: Mechanism, path: str | Path, state: State | None, inputs: Sequence[Input | str] | None,
    outputs: Outputs | None, parameters: Sequence[Parameter], options: RunOptions, replace: bool,
) -> Path:  # fmt: skip
    """Write an FMU; see `System.to_fmu`."""
    target = as_path(path, "model.fmu")
    if target.suffix != ".fmu":
        raise InputError(f"'{target}': an FMU ends in .fmu; give such a name")
    if find_spec("pythonfmu3") is None:
        raise InputError("to_fmu needs the package pythonfmu3; install it: pip install 'mbsd3d[fmu]'")
    check_state(state, "to_fmu")
    document = document_of(system, state, inputs, outputs, parameters, options)
    begin(document, {x["name"]: x["start"] for x in document["parameters"]})  # what cannot run is refused here
    with tempfile.TemporaryDirectory() as folder:
        content = packed(document, Path(folder), target.stem)
    return write_atomically(target, content, replace=replace)


def packed(document: dict[str, Any], folder: Path, stem: str) -> bytes:
    """Return the FMU of a document, made in a folder."""
    from pythonfmu3.builder import FmuBuilder  # the extra "fmu"

    name = re.sub(r"\W", "_", stem, flags=re.ASCII)
    name = f"fmu_{name}" if not name or name[0].isdigit() or keyword.iskeyword(name) else name
    script = folder / f"{name}_{document['hash'][:16]}.py"  # two FMUs in one process are two modules
    script.write_text(SCRIPT.format(name=name), encoding="utf-8")
    (folder / DOCUMENT).write_text(json.dumps(document, allow_nan=False), encoding="utf-8")
    made = FmuBuilder.build_FMU(
        script, dest=folder / "made", project_files={folder / DOCUMENT}, canGetAndSetFMUState=True
    )
    return Path(made).read_bytes()
