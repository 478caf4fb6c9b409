"""The public `System`: a mechanism, and what can be asked of it."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from ..base.checks import number
from ..base.errors import checks_method_arguments
from ..base.fields import part_class
from ..base.style import html_table
from ..base.wording import counted
from ..mechanism.bodies import Body
from ..mechanism.couplings import GearMesh
from ..mechanism.drivers import Driver
from ..mechanism.force_element import ForceElement
from ..mechanism.joints import Joint
from ..mechanism.limits import Limit
from ..mechanism.measures import Measure
from ..mechanism.mechanism import Mechanism
from ..mechanism.state import State
from .drawable import Drawable

if TYPE_CHECKING:
    from ..constraints.engagement import Engagement
    from ..constraints.redundancy import Diagnosis
    from ..equations.compiled import Compiled
    from ..files.exporting.exported import Exported
    from ..files.fmu import Outputs, Parameter
    from ..integrators.method import Method
    from ..linear.equilibrium import Equilibrium
    from ..mechanism.signals.signal import Input


@checks_method_arguments
@part_class(init=False, repr=False)
class System(Drawable):
    """A mechanism.

    Parameters
    ----------
    bodies : sequence of Body
    joints : sequence of Joint
        Joints and drivers.
    forces : sequence of ForceElement
    gravity : (3,) array_like
        [m/s^2], world.
    name : str or None
        Of the whole system: the title of pages, reports and files; read it by ``system.title``.
    limits : sequence of Limit
        Ranges of angles and slides that are watched: the certificate of a run says where they are exceeded.
    notes : sequence of str
        Sentences that the certificate of every run repeats, e.g. what an import left inactive.

    Raises
    ------
    ValueError
        For two parts of one name, a joint of a body that is not in the system, and the like.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Revolute, System
    >>> bob = Body("bob", mass=1.0, inertia=(0.1, 0.1, 0.02), position=(0, 0, -1))
    >>> System(bodies=[bob], joints=[Revolute(GROUND, bob, at=(0, 0, 0), axis=(0, 1, 0))]).check().mobility
    1
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        joints: Sequence[Joint] = (),
        forces: Sequence[ForceElement] = (),
        gravity: ArrayLike = (0.0, 0.0, -9.81),
        *,
        name: str | None = None,
        title: str | None = None,
        limits: Sequence[Limit] = (),
        notes: Sequence[str] = (),
    ) -> None:
        title = title if name is None else name
        with suppress(TypeError):  # what is not a list of joints is refused below
            joints = tuple(joints)
            if any(isinstance(x, GearMesh) and x.mu is not None for x in joints):
                from ..mechanism.forces.dry_friction import frictions_of_teeth

                forces = tuple(forces)
                forces += tuple(frictions_of_teeth(joints, forces))
        super().__init__(bodies, joints, forces, gravity, title=title, limits=limits, notes=notes)

    def __repr__(self) -> str:
        drivers = sum(isinstance(joint, Driver) for joint in self.joints)
        counts = {"body": len(self.bodies), "joint": len(self.joints) - drivers, "driver": drivers}
        counts["force"] = len(self.forces)
        shown = ", ".join(counted(count, kind) for kind, count in counts.items() if count)
        return f"<system {self.title!r}: {shown}>" if self.title else f"<system: {shown}>"

    def _repr_html_(self) -> str:
        rows = [(body.name, "Body", f"{body.mass:g} kg") for body in self.bodies]
        parts: list[Joint | ForceElement] = [*self.joints, *self.forces]
        for part in parts:
            on = dict.fromkeys(body.name for body in part.bodies())
            rows.append((self.name(part), type(part).__name__, ", ".join(on)))
        return html_table(repr(self).strip("<>"), ("part", "type", "mass, or bodies"), rows)

    @classmethod
    def of(cls, mechanism: Mechanism) -> "System":
        """Return the system of a mechanism: the same parts."""
        given = (mechanism.bodies, mechanism.joints, mechanism.forces, mechanism.gravity)
        return cls(*given, **mechanism.besides())

    @property
    def lowered(self) -> "Compiled":
        """Return the read-only arrays of this system, with all terms of the equations switched on."""
        from ..equations.compiled import tables_of

        return tables_of(self)

    def check(self, *, as_built: float | None = None) -> "Diagnosis":
        """Find coordinates, rows, rank, mobility, redundant rows by joint, remedies and an assessment; see `Diagnosis`.

        as_built : float or None
            Tolerance of the real parts [m]: misfits below it are taken up by play. None: 1e-5 m, or for small
            mechanisms 1e-4 of their length.
        """
        from ..constraints.redundancy import diagnose

        return diagnose(self, None if as_built is None else number(as_built, "check: as_built", minimum=0.0))

    def state(self, *, as_built: float | None = None) -> State:
        """Return the initial state at the reference pose; velocities that are None are solved from the constraints.

        Drivers that start elsewhere need `assemble`; one that starts at whole turns is accepted if all bodies return to
        the reference pose.

        as_built : float or None
            Tolerance [m] within which redundant rows may be violated, for parts built slightly out of line.
        """
        from ..constraints.assembly import reference_state

        return reference_state(self, as_built)

    def assemble(
        self,
        angles: Mapping[Joint | str, float] | None = None,
        slides: Mapping[Joint | str, float] | None = None,
        rates: Mapping[Joint | str, float] | None = None,
        measures: Mapping[Measure, float] | None = None,
        pinned: Sequence[Body] = (),
        near: State | None = None,
        *,
        t: float = 0.0,
    ) -> State:
        """Return a state that closes all joints and meets the given values and what drivers prescribe at ``t``.

        The mechanism moves there from its start, all values in proportion, so that angles count their turns in every
        loop of gears or links. Of several motions the one in which joints move least is taken, and ``state.notes`` says
        so; if the number of turns depends on the choice, the error asks for another angle.

        Parameters
        ----------
        angles, slides, rates : mapping of a joint (or its name) to rad, m, rad/s (m/s for a slide)
        measures : mapping of a measure to its value
        pinned : bodies that do not move from their reference pose (or their pose in ``near``)
        near : State to start from; None = the reference pose, at rest
            Its motion continues: joints keep their rates, changed as little as joints, drivers and ``rates`` require,
            in the sense of kinetic energy. A velocity given to a body is met or refused as long as ``near`` has it.
            Joints that have engaged or broken there stay so.
        t : time at which drivers are read [s]

        Raises
        ------
        AssemblyError
            Naming the joint with the largest gap, the value that is out of reach, or the hinge whose turns are not
            determined.

        Examples
        --------
        >>> from mbsd3d import GROUND, Body, Prismatic, Revolute, Screw, System, accelerations
        >>> spindle, nut = (Body(name, mass=1.0, inertia=(0.1, 0.1, 0.2)) for name in ("spindle", "nut"))
        >>> hinge = Revolute(GROUND, spindle, at=(0, 0, 0), axis=(0, 0, 1))
        >>> rail = Prismatic(GROUND, nut, at=(0, 0, 0), axis=(0, 0, 1))
        >>> screw = Screw(spindle, nut, at=(0, 0, 0), axis=(0, 0, 1), pitch=0.01)
        >>> system = System([spindle, nut], [hinge, rail, screw])
        >>> round(float(accelerations(system, system.assemble(angles={hinge: 10.0})).slide(rail)[0]), 7)
        -0.0159155
        """
        from ..constraints.assembly import assemble
        from ..run.simulation import check_state

        check_state(near, "assemble")
        return assemble(self, angles, slides, rates, measures, pinned, near, number(t, "assemble: t"))

    def engage(self, joint: Joint, state: State) -> "Engagement[System]":
        """Return this system with a joint more, which engages at the pose of a state, and the motion after the impact.

        Points and axes of the joint are given at the reference pose, like those of any joint, and are fixed in body a;
        body b is held in its present pose. A `Distance` takes the length and a coupling of hinges the offset at that
        moment. The impact is plastic: M (u - v) + J' L = 0 and J u = b over all joints, so momentum is kept.

        Parameters
        ----------
        joint : Joint
            A joint between bodies of this system that is not in it; drivers are refused.
        state : State
            A state of this system, as ``solution.state()`` gives it.

        Returns
        -------
        Engagement
            ``.system`` and ``.state`` to continue with, ``.joint`` as part of that system, ``.lost`` energy [J],
            ``.work`` of drivers [J], ``.impulse`` of the joint and ``.impulses`` of all joints by name [N s, N m s].

        Raises
        ------
        AssemblyError
            If the joints do not close at this state, or no velocities meet all of them.

        Examples
        --------
        >>> from mbsd3d import GROUND, Body, Fixed, Revolute, System
        >>> one = Body("one", mass=1.0, inertia=(0.5, 0.5, 1.0), omega=(0, 0, 6.5))
        >>> two = Body("two", mass=1.0, inertia=(1.0, 1.0, 2.0), position=(0, 0, 0.2), omega=(0, 0, 0))
        >>> bearings = [Revolute(GROUND, shaft, at=shaft.position, axis=(0, 0, 1)) for shaft in (one, two)]
        >>> shafts = System([one, two], bearings)
        >>> joined = shafts.engage(Fixed(one, two, at=(0, 0, 0.1), name="clutch"), shafts.state())
        >>> round(float(joined.state.v[5]), 9), round(joined.lost, 9)  # 6.5 / 3; 1 * 2 / (1 + 2) * 6.5^2 / 2
        (2.166666667, 14.083333333)
        """
        from ..constraints.engagement import engage
        from ..run.simulation import check_state

        check_state(state, "engage", needed=True)
        return engage(self, joint, state)

    def release(self, joint: Joint | str, state: State) -> "Engagement[System]":
        """Return this system without a joint, and its state, in which hinges keep their count of turns.

        joint : Joint or str
            A joint of this system through which no other part acts.
        """
        from ..constraints.engagement import release
        from ..run.simulation import check_state

        check_state(state, "release", needed=True)
        return release(self, joint, state)

    def equilibrium(self, state: State | None = None) -> "Equilibrium":
        """Find the equilibrium that the mechanism reaches from a pose, moving downhill as if through honey.

        Preloaded springs, gravity, internal states of forces and nonholonomic rows are included. If the start is an
        equilibrium, even an unstable one, it is returned unchanged.

        Parameters
        ----------
        state : State or None
            Start of the search; its velocities do not matter. None = ``system.state()``.

        Returns
        -------
        Equilibrium
            ``.state`` to start from, ``.stability`` ("stable", "stable, undamped", "neutral", "unstable", "held",
            "unknown") with its ``.reason``, ``.moved`` by body, ``.residual``.

        Raises
        ------
        ValueError
            If a signal varies with time.
        AssemblyError
            If the start does not meet a joint, or a driver moves.
        EquilibriumError
            If it does not come to rest; names the body that still accelerates.

        Examples
        --------
        >>> from mbsd3d import GROUND, Body, Revolute, System, TorsionSpring
        >>> arm = Body("arm", mass=2.0, inertia=(0.1, 0.5, 0.5), com=(0.5, 0, 0))
        >>> hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=(0, 1, 0), name="hinge")
        >>> rest = System([arm], [hinge], [TorsionSpring(hinge, stiffness=40.0)]).equilibrium()
        >>> rest.stability, round(float(rest.state.coordinates[0]), 6)  # 40 x = 2 * 9.81 * 0.5 cos x
        ('stable, undamped', 0.238318)
        """
        from ..linear.equilibrium import find_equilibrium
        from ..run.simulation import check_state

        check_state(state, "equilibrium")
        return find_equilibrium(self, state or self.state())

    def to_file(self, path: str | Path, *, replace: bool = False) -> Path:
        """Write the system to a model file that people can read and edit; every number comes back bit for bit.

        ``path`` ends in .json or .toml; ``replace``: replace an existing file instead of refusing. Returns the file,
        which is written completely or not at all. ValueError for another ending, an existing file, a folder that cannot
        be written, or a part that cannot be written: one with a function (`CustomForce`) or of your own class.

        >>> from tempfile import TemporaryDirectory
        >>> from mbsd3d import Body, System
        >>> with TemporaryDirectory() as folder:
        ...     path = System([Body("stone", mass=1.5, inertia=(1, 2, 2))]).to_file(f"{folder}/stone.toml")
        ...     System.from_file(path).bodies
        (Body('stone', mass=1.5),)
        """
        from ..files.model_files import write_model

        return write_model(self, path, replace=replace)

    def to_fmu(
        self,
        path: str | Path,
        *,
        state: State | None = None,
        inputs: "Sequence[Input | str] | None" = None,
        outputs: "Outputs | None" = None,
        parameters: "Sequence[Parameter]" = (),
        method: "Method | None" = None,
        rtol: float = 1e-8,
        replace: bool = False,
    ) -> Path:
        """Write the system as an FMU for co-simulation by FMI 3.0; it needs the extra ``fmu``.

        It runs where the host is Python with mbsd3d installed, as with FMPy; other hosts must load libpython first.
        Inputs are held over a communication step; ``getFMUState`` and ``setFMUState`` work like `Stepper.snapshot` and
        `restore`. Units are base units and radians.

        Parameters
        ----------
        path : str or Path
            Ends in .fmu.
        state : State or None
            Start; None = `state()`, made anew with the parameters.
        inputs : sequence of Input or str
            `Input` signals of forces or references; None = all. One that prescribes a motion is refused.
        outputs : dict of name and measure, sequence of measures, or None
            None = ``hinge.angle``, ``hinge.rate``, ``rail.slide``, ``rail.slide_rate`` of all joints, and
            ``cart.position[1]``, ``cart.velocity[1]``, ``cart.omega[1]`` ... of all bodies. ``certificate.passed`` and
            ``certificate.worst`` are always there, ``certificate.work`` of the forces with inputs, and what holding
            them may have ``certificate.created`` of it [J].
        parameters : sequence of str or (part, str)
            Numbers that the host may set before the start, e.g. "spring.stiffness", "bob.mass".
        method, rtol
            As for `simulate`.
        replace : bool
            Whether to replace an existing file.

        Returns
        -------
        Path

        Raises
        ------
        ValueError
            Without pythonfmu3; for a part with a function, an unknown input, output or parameter, and whatever
            `Stepper` refuses.
        AssemblyError
            If the state does not meet the joints.
        """
        from ..files.fmu import write_fmu
        from ..integrators.dop853 import DOP853
        from ..results.record import RunOptions

        options = RunOptions(DOP853() if method is None else method, rtol)
        return write_fmu(self, path, state, inputs, outputs, parameters, options, replace)

    def to_mjcf(
        self, path: str | Path | None = None, *, leave_out: Sequence[Joint | ForceElement | str] = (),
        replace: bool = False,
    ) -> "Exported":  # fmt: skip
        r"""Write the system as MJCF, the XML of MuJoCo, at its reference pose.

        Trees of joints move in MuJoCo as they do here. Loops are closed by equalities, and gears, racks, screws and
        constant-velocity shafts couple coordinates by equalities: these are springs in MuJoCo, and ``soft`` names them.
        Springs and dampers between points and along hinges and sliders are written; drivers only where they hold a
        value. Limits are not written, since MuJoCo would enforce them. Shapes become geoms without contact; initial
        velocities of bodies become the key frame "start".

        Parameters
        ----------
        path : str, Path or None
            Ends in .xml or .mjcf; None = only return the text.
        leave_out : sequence of parts or names
            Joints and forces that are not written.
        replace : bool
            Replace an existing file.

        Returns
        -------
        Exported
            ``.text``, ``.path``, ``.frames``, ``.soft``, ``.inactive``, ``.said``, ``.meshes``.

        Raises
        ------
        ValueError
            Naming every joint and force that the format cannot hold and that is not left out: rolling, knife edges,
            tyres, forces with functions or internal states, signals of time; a body without mass at the end of a tree.

        Examples
        --------
        >>> from mbsd3d import GROUND, Body, Revolute, System
        >>> bob = Body("bob", mass=1.0, inertia=(0.1, 0.1, 0.02), position=(0, 0, -1))
        >>> hinge = Revolute(GROUND, bob, at=(0, 0, 0), axis=(0, 1, 0), name="hinge")
        >>> made = System([bob], [hinge]).to_mjcf()
        >>> print(*made.text.splitlines()[5:7], sep="\n")
              <inertial pos="0.0 0.0 0.0" quat="1.0 0.0 0.0 0.0" mass="1.0" diaginertia="0.1 0.1 0.02" />
              <joint name="hinge" type="hinge" pos="0.0 0.0 1.0" axis="0.0 1.0 0.0" />
        """
        from ..files.exporting.exported import written
        from ..files.exporting.mujoco import write_mjcf

        return written(write_mjcf(self, leave_out), path, (".xml", ".mjcf"), replace)

    def to_urdf(
        self, path: str | Path | None = None, *, massless: bool = False,
        leave_out: Sequence[Joint | ForceElement | str] = (), replace: bool = False,
    ) -> "Exported":  # fmt: skip
        """Write the system as URDF: a tree of `Revolute`, `Prismatic`, `Planar` and `Fixed`, at its reference pose.

        The frame of a link is that of its joint: its origin is the point of the joint, its axes are those of the body;
        ``frames`` maps it back. Dampers and limits of hinges and sliders are written, and shapes. The format has no
        place for gravity and velocities, and a free root floats only if the reader is told so: ``said`` reports this.

        Parameters
        ----------
        path : str, Path or None
            Ends in .urdf; None = only return the text.
        massless : bool
            Write `Spherical`, `Universal` and `Cylindrical` as joints in a row over massless links, which not all
            readers accept.
        leave_out, replace
            See `to_mjcf`.

        Returns
        -------
        Exported

        Raises
        ------
        ValueError
            Naming the joint that closes a loop, and every joint and force that the format cannot hold.

        Examples
        --------
        >>> from mbsd3d import GROUND, Body, Revolute, System
        >>> bob = Body("bob", mass=1.0, inertia=(0.1, 0.1, 0.02), position=(0, 0, -1))
        >>> hinge = Revolute(GROUND, bob, at=(0, 0, 0), axis=(0, 1, 0), name="hinge")
        >>> print(System([bob], [hinge]).to_urdf().frames["bob"].position)  # of the link, from O of the body
        [0. 0. 1.]
        """
        from ..files.exporting.exported import written
        from ..files.exporting.urdf import write_urdf

        return written(write_urdf(self, leave_out, massless), path, (".urdf",), replace)

    def to_sdf(
        self, path: str | Path | None = None, *, massless: bool = False,
        leave_out: Sequence[Joint | ForceElement | str] = (), replace: bool = False,
    ) -> "Exported":  # fmt: skip
        """Write the system as SDF, the format of Gazebo: a world with its gravity and one model, at the reference pose.

        `Revolute`, `Prismatic`, `Spherical`, `Universal`, `Screw` and `Fixed` have counterparts in the format, also in
        loops. A `Gear` becomes a gearbox if both hinges are on one body; otherwise, like a `RackPinion`, the mimic of a
        coordinate. Springs, dampers and limits of hinges and sliders are written, shapes, and velocities at the start
        as a state of the world.

        Parameters
        ----------
        path : str, Path or None
            Ends in .sdf; None = only return the text.
        massless : bool
            Write `Cylindrical` and `Planar` as slides and a hinge in a row over massless links, and massless bodies as
            such links. Not all readers accept them; Gazebo does not.
        leave_out, replace
            See `to_mjcf`.

        Returns
        -------
        Exported

        Raises
        ------
        ValueError
            Naming every joint and force that the format cannot hold, and joints whose parts do not meet at the
            reference pose.

        Examples
        --------
        >>> from mbsd3d import GROUND, Body, Revolute, System
        >>> bob = Body("bob", mass=1.0, inertia=(0.1, 0.1, 0.02), position=(0, 0, -1))
        >>> hinge = Revolute(GROUND, bob, at=(0, 0, 0), axis=(0, 1, 0), name="hinge")
        >>> System([bob], [hinge]).to_sdf().text.split()[1]
        'version="1.11">'
        """
        from ..files.exporting.exported import written
        from ..files.exporting.sdf import write_sdf

        return written(write_sdf(self, leave_out, massless), path, (".sdf",), replace)

    @classmethod
    def from_file(cls, path: str | Path) -> "System":
        """Read the system of a model file, written by `to_file` or by hand, checked by the constructors of its parts.

        ``path`` ends in .json (up to 16 MB) or .toml (up to 1 MB). ValueError naming file and place, e.g. "Expected
        `float`, got `str` - at `$.bodies[3].mass`".
        """
        from ..files.model_files import read_model

        return cls.of(read_model(path))
