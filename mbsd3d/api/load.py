"""Reading files: solutions, and models of other programs."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from ..base.errors import checks_arguments
from ..files.bundles import Verification
from ..files.bundles import verify as verify_bundle
from ..files.importing.imported import Imported
from ..files.importing.importers import read_mujoco, read_robot, read_simulation
from ..files.solutions import read_run
from .solution import Solution
from .system import System


@checks_arguments
def load(path: str | Path) -> Solution:
    """Read a file written by ``solution.save``; the result is a full `Solution`.

    The numbers are the same bit for bit; the certificate is computed again. ``path`` may omit ".npz". ValueError if the
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
def verify(path: str | Path) -> Verification:
    """Repeat the run of a bundle of `Solution.bundle` and compare: bit for bit with the same versions and processor,
    otherwise within its stated error.

    Returns
    -------
    Verification
        ``passed``, ``identical``, ``difference`` and ``limit`` [model lengths, rad]; printing it shows the findings.

    Raises
    ------
    ValueError
        For a file that is not a bundle.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from mbsd3d import Body, System, simulate, verify
    >>> stone = Body("stone", 1.0, (0.1, 0.2, 0.3), velocity=(0, 0, 3.0), omega=(0.1, 2.0, 0))
    >>> with TemporaryDirectory() as folder:
    ...     found = verify(simulate(System([stone]), 1.0, output=11).bundle(f"{folder}/flight"))
    >>> found.passed, found.identical
    (True, True)
    """
    return verify_bundle(path)


@checks_arguments
def read_mjcf(
    path: str | Path,
    *,
    leave_out: Sequence[str] = (),
    drop: Sequence[str] = (),
    strict: bool = False,
    geometry: str = "draw",
    inertia: str = "as given",
    inputs: bool = False,
    limits: str = "watched",
    package_paths: Sequence[str | Path] = (),
    timeout: float = 4.0,
) -> Imported:
    """Read the mechanism of an MJCF file (MuJoCo's XML) at its reference pose qpos0.

    Parts that act on every motion (masses, joints, springs, dampers, dry friction, equalities, gravcomp, ...) are
    built, or the file is refused. Parts that act at times or on command (contact, limits, actuators, ...) are inactive:
    ``.inactive``, one warning and the certificate of every run report them, and where a limit of a hinge or slide is
    exceeded. Parts without effect (looks, sensors, cameras, ...) are counted in ``.idle``.

    Several joints of one body become one joint where one exists (Universal, Spherical, Cylindrical, Planar); otherwise
    they follow each other, with massless bodies in between. Bodies without a joint become part of their parent.
    Equalities are rigid here and soft in MuJoCo. Dry friction becomes a `Brake`.

    Parameters
    ----------
    path : str or Path
        At most 8 MB with all it includes; it names files in its own folder and in ``package_paths`` only.
    leave_out : sequence of str
        Kinds of active parts that may be left out if they cannot be built: "fluid", "tendon", ...; certificates report
        what was left out. ``drop`` is its older name.
    strict : bool
        Also refuse parts that act at times or on command.
    geometry : str
        "draw" the meshes that are found, or "ignore" them. A mesh is needed only where a mass follows from it.
    inertia : str
        "as given" accepts moments that no body can have, and reports them; "refuse" refuses them.
    inputs : bool
        Build motors, position and velocity servos of hinges and slides, each with an `Input` of its name for its
        command, 0 at the start; other actuators are then refused. Without it actuators give no force, not even that
        of a servo at command 0.
    limits : str
        Of hinges and slides: "watched" permits motion beyond them and reports it, "stop" builds an `EndStop` for each,
        and a `RotationStop` or `SumStop` for those of balls and fixed tendons, which are inactive otherwise.
    package_paths : sequence of str or Path
        Further folders from which files may be read.
    timeout : float
        Processor time to read it [s].

    Returns
    -------
    Imported
        ``.system``, and what was merged, renamed and left out; ``.states`` of key frames, ``.points`` of sites.

    Raises
    ------
    ValueError
        If a part that always acts can neither be built nor is left out (the message lists all of them with line and
        remedy), a file outside its folders is needed, numbers are not finite, or it takes too long.

    Examples
    --------
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
    chosen = {"leave_out": leave_out, "drop": drop, "strict": strict, "geometry": geometry, "inertia": inertia}
    chosen |= {"limits": limits, "inputs": inputs}
    return with_system(read_mujoco(path, timeout, package_paths, **chosen))


@checks_arguments
def read_urdf(
    path: str | Path,
    *,
    floating: bool | None = None,
    leave_out: Sequence[str] = (),
    drop: Sequence[str] = (),
    strict: bool = False,
    geometry: str = "draw",
    inertia: str = "as given",
    inputs: bool = False,
    limits: str = "watched",
    package_paths: Sequence[str | Path] = (),
    timeout: float = 4.0,
) -> Imported:
    """Read the mechanism of a URDF or xacro file, with all angles zero except those of mimic followers.

    Active and inactive parts are distinguished as in `read_mjcf`; gravity is 9.81 m/s^2 along -z. Links without mass
    become massless bodies; joints that move nothing with mass are welded. Fixed links become part of their parent.

    Parameters
    ----------
    path : str or Path
        At most 8 MB. What uses xacro is expanded by the package xacro.
    floating : bool or None
        Whether the root link can move. None: it is fixed if it is "world", has no mass, or carries a moving joint; the
        last case gives a warning.
    package_paths : sequence of str or Path
        Folders in which ``package://name/...`` is looked up, then upwards from the file.
    inputs : bool
        Build a motor with an `Input` of the name of its joint for every hinge and slide that follows no other [N m, N].
    leave_out, drop, strict, geometry, inertia, limits, timeout
        See `read_mjcf`.

    Returns
    -------
    Imported
        ``.points`` are the frames of links that are part of another body.

    Raises
    ------
    ValueError
        As `read_mjcf`; with the line of the element.

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
    chosen = {"leave_out": leave_out, "drop": drop, "strict": strict, "geometry": geometry, "inertia": inertia}
    chosen |= {"limits": limits, "inputs": inputs}
    return with_system(read_robot(path, timeout, package_paths, floating, **chosen))


@checks_arguments
def read_sdf(
    path: str | Path,
    *,
    floating: bool | None = None,
    leave_out: Sequence[str] = (),
    strict: bool = False,
    geometry: str = "draw",
    inertia: str = "as given",
    limits: str = "watched",
    package_paths: Sequence[str | Path] = (),
) -> Imported:
    """Read the mechanism of an SDF file, version 1.4 and newer: one model, or one world of models; loops are closed.

    Active and inactive parts are distinguished as in `read_mjcf`. Models float unless they are static or jointed to the
    world; ``.said`` reports those with joints. Links that are fixed to each other are one body; joints beyond a tree
    close loops. ``revolute2`` and ``universal`` are a `Universal` where their axes are perpendicular and nothing acts
    along them, and else two hinges over a body without mass; a ``gearbox`` is a `Gear` between the hinges of its two
    links on its reference body, a ``screw`` a `Screw`. Poses and axes are resolved through ``relative_to``,
    ``attached_to``, ``expressed_in``, models in models, whose names stand before those of their parts, and models that
    are included from other files. With ``<inertial auto="true">`` the mass of a link is that of its collision geometry,
    meshes too, of the density given or 1000 kg/m^3, and a mass given scales it. A link without <inertial> has 1 kg and
    1 kg m^2, as the format specifies; ``.said`` reports it. A model without a world takes 9.81 m/s^2 along -z, a world
    without gravity 9.8.

    Parameters
    ----------
    path : str or Path
        At most 8 MB with all it includes.
    floating : bool or None
        Whether links that nothing holds to the world can move. None: yes, as the format specifies; False fixes them.
    leave_out, strict, geometry, inertia, limits, package_paths
        See `read_mjcf`. Meshes and included models are looked up in ``package_paths``, then upwards from the file:
        ``model://name``, ``package://name/...``, ``file://`` and paths beside the file that names them.

    Returns
    -------
    Imported
        ``.states`` of the states of a world (poses and velocities of links, world axes), ``.points`` of frames.

    Raises
    ------
    ValueError
        As `read_mjcf`, with the line of the element; for older versions, included models that are missing, and
        kinematic links.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from mbsd3d import read_sdf
    >>> text = '''<sdf version="1.9"><model name="swing"><link name="bob"><inertial><pose>0 0 -0.6 0 0 0</pose>
    ...   <mass>2</mass><inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.02</izz></inertia></inertial></link>
    ...   <joint name="hinge" type="revolute"><parent>world</parent><child>bob</child>
    ...   <axis><xyz>0 1 0</xyz></axis></joint></model></sdf>'''
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, "swing.sdf")
    ...     _ = path.write_text(text)
    ...     found = read_sdf(path)
    >>> found.system.bodies, found.system.joints[0].name
    ((Body('bob', mass=2),), 'hinge')
    """
    chosen = {"leave_out": leave_out, "drop": (), "strict": strict, "geometry": geometry, "inertia": inertia}
    return with_system(read_simulation(path, package_paths, floating, limits=limits, **chosen))


def with_system(found: Imported) -> Imported:
    """Return the same import with a `System` for its mechanism."""
    return found._replace(system=System.of(found.system))
