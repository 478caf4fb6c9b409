"""The public `System`: a mechanism, and what can be asked of it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ..mechanism.bodies import Body
from ..mechanism.joints import Joint
from ..mechanism.measures import Measure
from ..mechanism.mechanism import Mechanism
from ..mechanism.state import State
from .drawable import Drawable

if TYPE_CHECKING:
    from ..constraints.redundancy import Diagnosis
    from ..equations.compiled import Compiled


@dataclass(frozen=True, eq=False)
class System(Mechanism, Drawable):
    """A mechanism.

    Parameters
    ----------
    bodies : sequence of Body
    joints : sequence of Joint
        Joints and drivers.
    forces : sequence of ForceElement
    gravity : (3,) array_like
        [m/s^2], world.

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

    @classmethod
    def of(cls, mechanism: Mechanism) -> "System":
        """The system of a mechanism: the same parts."""
        return cls(mechanism.bodies, mechanism.joints, mechanism.forces, mechanism.gravity)

    @property
    def lowered(self) -> "Compiled":
        """The arrays of this system with all terms of the equations; made once, nothing writes into them."""
        from ..equations.compiled import tables_of

        return tables_of(self)

    def check(self, *, as_built: float = 1e-5) -> "Diagnosis":
        """Coordinates, rows, rank, mobility, redundant rows by joint, cures and a verdict; see `Diagnosis`.

        as_built : float
            Tolerance of the real parts [m]: misfits below it are taken up by play.
        """
        from ..constraints.redundancy import diagnose

        return diagnose(self, as_built)

    def state(self, *, as_built: float | None = None) -> State:
        """The initial state at the reference pose; velocities that are None are solved from the constraints.

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
        """A state that closes all joints and meets the given values.

        Parameters
        ----------
        angles, slides, rates : mapping of a joint (or its name) to rad, m, rad/s (m/s for a slide)
        measures : mapping of a measure to its value
        pinned : bodies that do not move from their reference pose (or their pose in ``near``)
        near : State to start from; None = the reference pose, with tree joints moved forward to the given values
        t : time at which drivers are read [s]

        Raises
        ------
        AssemblyError
            Naming the joint with the largest gap.
        """
        from ..constraints.assembly import assemble

        return assemble(self, angles or {}, slides or {}, rates or {}, measures or {}, tuple(pinned), near, t)

    def to_file(self, path: str | Path, *, replace: bool = False) -> Path:
        """Write the system to a model file that people can read and edit; every number comes back bit for bit.

        ``path`` ends in .json or .toml; ``replace`` an existing file or refuse. Returns the file, which is written
        whole or not at all. ValueError if the name ends otherwise, the file exists, the folder cannot be written, or a
        part cannot be: one with a function (`CustomForce`) or of a class of your own.

        >>> from tempfile import TemporaryDirectory
        >>> from mbsd3d import Body, System
        >>> with TemporaryDirectory() as folder:
        ...     path = System([Body("stone", mass=1.5, inertia=(1, 2, 2))]).to_file(f"{folder}/stone.toml")
        ...     System.from_file(path).bodies
        (Body('stone', mass=1.5),)
        """
        from ..files.model_files import write_model

        return write_model(self, path, replace=replace)

    @classmethod
    def from_file(cls, path: str | Path) -> "System":
        """The system of a model file, written by `to_file` or by hand, checked by the constructors of its parts.

        ``path`` ends in .json (up to 16 MB) or .toml (up to 1 MB). ValueError naming file and place, e.g. "Expected
        `float`, got `str` - at `$.bodies[3].mass`".
        """
        from ..files.model_files import read_model

        return cls.of(read_model(path))
