"""The mechanism: bodies, joints, forces and gravity, checked for what can be checked without numbers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.checks import vector
from ..mechanism.bodies import GROUND, Body
from ..mechanism.forces.element import ForceElement
from ..mechanism.joints import Joint
from ..mechanism.state import State
from .drawable import Drawable

if TYPE_CHECKING:
    from ..constraints.redundancy import Diagnosis
    from ..equations.compiled import Compiled


@dataclass(frozen=True, eq=False)
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

    bodies: Sequence[Body]
    joints: Sequence[Joint] = ()
    forces: Sequence[ForceElement] = ()
    gravity: Any = (0.0, 0.0, -9.81)
    names: Mapping[int, str] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        set_field = object.__setattr__
        for key, kind in (("bodies", Body), ("joints", Joint), ("forces", ForceElement)):
            parts = tuple(getattr(self, key))
            for part in parts:
                if not isinstance(part, kind):
                    raise ValueError(f"System: {part!r} in {key} is not a {kind.__name__}")
            if len({id(part) for part in parts}) < len(parts):
                raise ValueError(f"System: a part stands twice in {key}; list every part once")
            set_field(self, key, parts)
        if not self.bodies:
            raise ValueError("System: no bodies; give at least one Body")
        set_field(self, "gravity", vector(self.gravity, "System: gravity"))
        set_field(self, "names", self._names())
        self._check_members()

    def _names(self) -> dict[int, str]:
        """Names of all parts; nameless ones are numbered by type."""
        names: dict[int, str] = {id(GROUND): "ground"}
        counts: dict[str, int] = {}
        taken = {"ground"}
        for part in (*self.bodies, *self.joints, *self.forces):
            name = part.name
            if name is None:
                kind = type(part).__name__
                counts[kind] = counts.get(kind, 0) + 1
                name = f"{kind} {counts[kind]}"
            if name in taken:
                raise ValueError(f"System: two parts are named '{name}'; give every part a name of its own")
            names[id(part)] = name
            taken.add(name)
        return names

    def _check_members(self) -> None:
        """Every joint and force acts on bodies of this system and refers to joints and forces of it."""
        members = {id(body) for body in self.bodies} | {id(GROUND)}
        known = {id(part) for part in (*self.joints, *self.forces)}
        for part in (*self.joints, *self.forces):
            for body in part.bodies():
                if id(body) not in members:
                    raise ValueError(
                        f"{type(part).__name__} '{self.name(part)}': body '{body.name}' is not in the system; "
                        "add it to bodies"
                    )
            for other in part.partners():
                if id(other) not in known:
                    kind = "joint" if isinstance(other, Joint) else "force"
                    raise ValueError(
                        f"{type(part).__name__} '{self.name(part)}': its {kind} '{other.name}' is not in the "
                        f"system; add it to {kind}s"
                    )

    @cached_property
    def lowered(self) -> "Compiled":
        """The arrays of this system with all terms of the equations; made once, nothing writes into them."""
        from ..equations.compiled import Switches, lower

        return lower(self, (), Switches())

    def name(self, part: Any) -> str:
        """Name of a part of this system."""
        return self.names.get(id(part), getattr(part, "name", None) or type(part).__name__)

    def part(self, key: Any, kind: str = "bodies") -> Any:
        """A part given by itself or by its name; unknown ones are a ValueError that lists the names there are."""
        parts = getattr(self, kind)
        if isinstance(key, Body | Joint | ForceElement) and key in parts:
            return key
        for part in parts:
            if isinstance(key, str) and self.name(part) == key:
                return part
        have = ", ".join(f"'{self.name(part)}'" for part in parts) or "none"
        shown = repr(key) if isinstance(key, str) else f"'{getattr(key, 'name', key)}'"
        raise ValueError(f"{shown} is not one of the {kind} of this system; there are {have}")

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
        angles: Mapping[Any, float] | None = None,
        slides: Mapping[Any, float] | None = None,
        rates: Mapping[Any, float] | None = None,
        measures: Mapping[Any, float] | None = None,
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

        Parameters
        ----------
        path : str or Path
            Ends in .json or .toml.
        replace : bool
            Whether an older file is replaced.

        Returns
        -------
        Path
            The file; it is written whole or not at all.

        Raises
        ------
        ValueError
            If the name ends otherwise, the file exists, the folder cannot be written, or a part cannot be written: one
            with a function (CustomForce) or of a class of your own.

        Examples
        --------
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
        """The system of a model file.

        Parameters
        ----------
        path : str or Path
            Ends in .json (up to 16 MB) or .toml (up to 1 MB), written by `to_file` or by hand.

        Returns
        -------
        System
            Checked by the constructors of its parts.

        Raises
        ------
        ValueError
            Naming file and place, e.g. "Expected `float`, got `str` - at `$.bodies[3].mass`".
        """
        from ..files.model_files import read_model

        return read_model(path)

    def total_mass(self) -> float:
        """[kg]"""
        return float(np.sum([body.mass for body in self.bodies]))
