"""Reading files: solutions, and models of other programs."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from ..base.errors import checks_arguments
from ..files.importing.builder import Imported
from ..files.importing.importers import read_xml
from ..files.solutions import read_run
from .solution import Solution
from .system import System


@checks_arguments
def load(path: str | Path) -> Solution:
    """Read a file written by ``solution.save``; the result is a full `Solution`.

    The same numbers, bit for bit; the certificate is made again. ``path`` with or without ".npz". ValueError if the
    file is missing, truncated, of another kind or version, or its parts do not fit together.

    >>> from tempfile import TemporaryDirectory
    >>> from mbsd3d import Body, System, load, simulate
    >>> stone = Body("stone", 1.0, (0.1, 0.1, 0.1), velocity=(0, 0, 3.0), omega=(0, 0, 0))
    >>> flight = simulate(System([stone]), 0.5, output=3)
    >>> with TemporaryDirectory() as folder:
    ...     again = load(flight.save(f"{folder}/flight"))
    >>> bool((again.position("stone") == flight.position("stone")).all())
    True
    """
    found = read_run(path)
    system = System.of(found.system)
    return Solution.of(replace(found, compiled=replace(found.compiled, system=system)))


@checks_arguments
def read_mjcf(path: str | Path, *, drop: Sequence[str] = (), timeout: float = 4.0) -> Imported:
    """The mechanism of an MJCF file (MuJoCo's XML) at its reference pose qpos0.

    Hinge, slide, ball and free joints; two or three hinges through one point (Universal, Spherical), a hinge and slides
    that make a Cylindrical or Planar joint; bodies without joint become part of their parent; springs and dampers of
    single joints; connect, weld and linear joint equalities, which are rigid here and soft there.

    ``path``: at most 8 MB with all it includes; it may name files in its own folder only. ``drop``: kinds to leave out:
    "contact", "limit", "actuator", "frictionloss", ... ``timeout`` [s] of processor time to read it. The result
    has ``.system``, and what was merged, renamed and dropped. ValueError if the file holds something that can neither
    be imported nor is dropped (the message lists it all), names a file outside its folder, holds numbers that are not
    finite, or takes too long.

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from mbsd3d import read_mjcf
    >>> text = '''<mujoco><worldbody><body name="bob"><joint name="hinge" axis="0 1 0" damping="0.2"/>
    ...   <inertial mass="2" pos="0 0 -0.6" diaginertia="0.1 0.1 0.02"/></body></worldbody></mujoco>'''
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, "pendulum.xml")
    ...     _ = path.write_text(text)
    ...     system = read_mjcf(path).system
    >>> system.joints[0].name, system.check().mobility
    ('hinge', 1)
    """
    return with_system(read_xml(path, "mujoco", drop, timeout))


@checks_arguments
def read_urdf(path: str | Path, *, drop: Sequence[str] = (), timeout: float = 4.0) -> Imported:
    """The mechanism of a URDF file; its root link is part of the ground. See `read_mjcf`.

    A link without inertial has no mass; where MuJoCo makes one of its shapes, say so by ``drop=("inertial",)``.

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
    return with_system(read_xml(path, "robot", drop, timeout))


def with_system(found: Imported) -> Imported:
    """The same import with a `System` for its mechanism."""
    return found._replace(system=System.of(found.system))
