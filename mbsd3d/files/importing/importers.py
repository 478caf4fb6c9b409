"""Models of other programs: MJCF and URDF, read by MuJoCo in a process of its own.

What has no counterpart here is named in an error; it is left out only if the caller names its kind in ``drop``.
"""

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ...base.checks import number
from .builder import KINDS, Builder, Imported
from .xml_scan import Scan


def read_mjcf(path: str | Path, *, drop: Sequence[str] = (), timeout: float = 4.0) -> Imported:
    """The mechanism of an MJCF file (MuJoCo's XML) at its reference pose qpos0.

    Hinge, slide, ball and free joints; two or three hinges through one point (Universal, Spherical), a hinge and slides
    that make a Cylindrical or Planar joint; bodies without joint become part of their parent; springs and dampers of
    single joints; connect, weld and linear joint equalities, which are rigid here and soft there.

    Parameters
    ----------
    path : str or Path
        At most 8 MB with all it includes; it may name files in its own folder only.
    drop : sequence of str
        Kinds to leave out: "contact", "limit", "actuator", "frictionloss", ... (`KINDS`).
    timeout : float
        For the process that reads the file [s].

    Returns
    -------
    Imported
        ``.system``, and what was merged, renamed and dropped.

    Raises
    ------
    ValueError
        Naming the file and everything in it that cannot be imported and is not dropped, a file outside the folder,
        numbers that are not finite, or a file that takes too long.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from mbsd3d.importers import read_mjcf
    >>> text = '''<mujoco><worldbody><body name="bob"><joint name="hinge" axis="0 1 0" damping="0.2"/>
    ...   <inertial mass="2" pos="0 0 -0.6" diaginertia="0.1 0.1 0.02"/></body></worldbody></mujoco>'''
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, "pendulum.xml")
    ...     _ = path.write_text(text)
    ...     system = read_mjcf(path).system
    >>> system.joints[0].name, system.check().mobility
    ('hinge', 1)
    """
    return read_xml(path, "mujoco", drop, timeout)


def read_urdf(path: str | Path, *, drop: Sequence[str] = (), timeout: float = 4.0) -> Imported:
    """The mechanism of a URDF file; its root link is part of the ground. See `read_mjcf`.

    Raises
    ------
    ValueError
        As `read_mjcf`.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from mbsd3d import read_urdf
    >>> text = '''<robot name="swing"><link name="frame"/><link name="bob"><inertial><origin xyz="0 0 -0.6"/>
    ...   <mass value="2"/><inertia ixx="0.1" iyy="0.1" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
    ...   <joint name="hinge" type="continuous"><parent link="frame"/><child link="bob"/><axis xyz="0 1 0"/></joint>
    ... </robot>'''
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, "swing.urdf")
    ...     _ = path.write_text(text)
    ...     found = read_urdf(path)
    >>> found.system.bodies, found.system.joints[0].name
    ((Body('bob', mass=2),), 'hinge')
    """
    return read_xml(path, "robot", drop, timeout)


def read_xml(path: str | Path, kind: str, drop: Sequence[str], timeout: float) -> Imported:
    """Scan, let the worker compile, build."""
    path, timeout = Path(path), number(timeout, "timeout", positive=True)
    drop = (drop,) if isinstance(drop, str) else tuple(drop)
    if unknown := [x for x in drop if x not in KINDS]:
        raise ValueError(f"'{path}': drop: {unknown[0]!r} is no kind of part; give some of {', '.join(KINDS)}")
    scan = Scan(path)
    scan.read(path)
    scan.check_named()
    if scan.kind != kind:
        raise ValueError(f"'{path}': its root is <{scan.kind}>, not <{kind}>; use the reader of its format")
    try:
        return Builder(compiled_facts(path, timeout), scan.unknown, drop).build()
    except ValueError as error:
        raise ValueError(f"'{path}': {error}") from error


def compiled_facts(path: Path, timeout: float) -> dict[str, Any]:
    """What the worker says, or why it says nothing."""
    command = [sys.executable, "-m", "mbsd3d.files.importing.worker", str(path.absolute()), str(int(timeout) + 1)]
    place = str(Path(__file__).resolve().parents[3])
    extra = {"PYTHONPATH": os.pathsep.join(filter(None, (place, os.environ.get("PYTHONPATH"))))}
    extra |= {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}  # every thread takes address space
    with tempfile.TemporaryDirectory() as folder:  # MuJoCo writes a log into its working directory
        try:
            done = subprocess.run(command, capture_output=True, cwd=folder, env=os.environ | extra, timeout=timeout)
        except subprocess.TimeoutExpired:
            raise ValueError(
                f"MuJoCo takes more than {timeout:g} s to read it; make it smaller, or raise timeout"
            ) from None
    try:
        answer = json.loads(done.stdout)
    except ValueError:
        raise ValueError(
            f"MuJoCo broke off while reading it (exit code {done.returncode}): a limit of memory or time, or a fault; "
            "make the model smaller"
        ) from None
    if "error" in answer:
        raise ValueError(f"MuJoCo cannot read it: {answer['error']}")
    return answer["facts"]
