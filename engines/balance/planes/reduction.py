"""Reduction of an engine to planes: whether the sum of planar models is the spatial block load.

Our reconstruction of the lemma that planar engine models rest on. The load that a mechanism puts on its frame (forces
of bearings, slides and driver, about the origin) is the sum of the loads of planar models, one per station z,

    F = sum F_i,      M = sum (z_i n x F_i + (r_i x F_i + driver) n),

if H1 one rigid shaft turns about a fixed axis n at a prescribed constant speed; H2 identical units hang on it, up to
phase, bank and station; H3 every unit moves in its own plane, normal to the shaft; H4 every moving body is
symmetric about its plane (its centre of mass lies there, products of inertia with n vanish) and forces superpose: none
couples units or leaves the planes, gravity among them. Then the reflection in its plane maps each unit onto itself, so
nothing drives it out, and all that passes between unit and shaft are forces in the plane.

The shaft is a stack of slices, one per station, with mass moments u s_i along their throws s_i (one complex u for all)
plus a part in proportion to their masses. Only what its product of inertia holds beyond that, [kg m^2], breaks H4: at
the speed w a couple w^2 times as large turns with the shaft, and no plane sees it. H2, of bodies and joints, is what
makes phasor sums valid; the sum of planes holds without it. Loads may be each unit's own: gas pressure has its phase.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from engines import planar
from engines.balance.planes.shaft import EXACT_TOLERANCE, Failure, Shaft, cut, find_shaft, tensor, throw
from engines.balance.planes.shaft_loads import carried_loads, heavy, moved
from engines.balance.planes.units import Unit, find_units, out_of_plane, planar_joint, unlike
from mbsd3d import Body, System
from mbsd3d.errors import InputError
from mbsd3d.extend import check_system, checks_arguments

__all__ = ["BlockLoad", "Failure", "Plane", "Reduction", "reduce_to_planes"]


class BlockLoad(NamedTuple):
    """Load of the moving parts on the frame."""

    force: np.ndarray  # (k, 3) world [N]
    moment: np.ndarray  # (k, 3) about the origin, world [N m]


class Plane(NamedTuple):
    """Planar model of all units of one station with their slice of the shaft."""

    z: float  # Of the plane, along the axis from the origin [m]
    system: planar.System
    units: tuple[str, ...]  # First bodies of its units; none for the rest of the shaft


@dataclass(frozen=True)
class Reduction:
    """Result of `reduce_to_planes`: planes, and the hypotheses that fail."""

    failures: tuple[Failure, ...]
    planes: tuple[Plane, ...]  # Empty where not even a sum can be formed
    axes: np.ndarray  # (3, 3) rows e1, e2, n: directions of x and y in the planes and of the shaft, world

    @property
    def holds(self) -> bool:
        """Return whether all hypotheses hold."""
        return not self.failures

    def __str__(self) -> str:
        if self.planes:
            stations = ", ".join(f"z = {p.z:.6g} m ({', '.join(p.units) or 'shaft'})" for p in self.planes)
            found = f"{len(self.planes)} plane{'s' * (len(self.planes) > 1)}: {stations}"
        else:
            found = "no planes"
        if self.holds:
            return f"H1 to H4 hold; {found}"
        return "\n".join(["the reduction to planes does not hold:", *(f"  {x}" for x in self.failures), f"  {found}"])

    def block_load(self, times: ArrayLike, *, driver: bool = True) -> BlockLoad:
        """Sum the block load of the planes at the times (k,) [s]; ``driver``: whether the torque of the driver reacts
        on the frame.

        ValueError if no planes could be formed; the message says why.
        """
        if not self.planes:
            raise InputError(f"block_load: {self}")
        force, moment = np.zeros((2, np.size(times), 3))
        for plane in self.planes:
            run = planar.kinematics(plane.system, times)
            for joint in plane.system.joints:
                a, _ = joint.rows()[0].bodies
                if a is not planar.GROUND or (isinstance(joint, planar.Driver) and not driver):
                    continue
                reaction = run.reaction(joint)
                flat, at = -reaction.force, reaction.point
                pull = flat @ self.axes[:2]
                about = at[:, 0] * flat[:, 1] - at[:, 1] * flat[:, 0] - reaction.moment
                force += pull
                moment += plane.z * np.cross(self.axes[2], pull) + np.outer(about, self.axes[2])
        return BlockLoad(force, moment)


@checks_arguments
def reduce_to_planes(system: System) -> Reduction:
    """Decide whether a spatial system is the sum of planar ones, and form them.

    Hypotheses are judged by the rows of the joints, inertias and loads at the reference pose (rows also at a pose
    shifted in the planes), not by the types of joints: spherical and universal pins count as hinges where all else
    keeps the bodies in their plane.

    Parameters
    ----------
    system : System
        Spatial; bodies at rest count as frame. What is welded to the shaft belongs to it, each part in its own plane.

    Returns
    -------
    Reduction
        With all failures found, each with its part and size; planes also where only H2 or H4 fails.

    Examples
    --------
    >>> from validation import reduce_to_planes
    >>> from validation.cases.inline_four import inline_four
    >>> print(reduce_to_planes(inline_four()))
    H1 to H4 hold; 4 planes: z = -0.3 m (rod 1), z = -0.1 m (rod 2), z = 0.1 m (rod 3), z = 0.3 m (rod 4)
    """
    check_system(system, "reduce_to_planes")
    shaft, failures = find_shaft(system)
    if shaft is None:
        return Reduction(tuple(failures), (), np.eye(3))
    units, loose = find_units(shaft)
    failures += loose + out_of_plane(shaft, units) + lopsided(shaft, units) + heavy(shaft)
    bodies = {id(b): flat_body(shaft, b) for b in system.bodies if shaft.moves(b)}
    loads, foreign = carried_loads(shaft, units, bodies)
    failures += foreign
    if loose or any(failure.hypothesis in ("H1", "H3") for failure in failures):
        return Reduction(tuple(failures), (), shaft.rows.axes)
    joints = [[planar_joint(shaft, link, unit.z, bodies) for link in unit.links] for unit in units]
    odd = [x for own in joints for x in own if isinstance(x, Failure)]
    if odd:
        return Reduction((*failures, *odd), (), shaft.rows.axes)
    joints = [[joint for joint in own if joint is not None] for own in joints]
    planes, unseen = form_planes(shaft, units, joints, bodies, loads)
    return Reduction((*failures, *unlike(shaft, units, joints, bodies), *unseen), planes, shaft.rows.axes)


def flat_body(shaft: Shaft, body: Body) -> planar.Body:
    """Return a body projected into its plane."""
    com, position = shaft.rows.flat(body.centre - body.position), shaft.rows.flat(body.position)
    return planar.Body(body.name, body.mass, tensor(shaft, body)[2, 2], com=com, position=position)


def lopsided(shaft: Shaft, units: list[Unit]) -> list[Failure]:
    """Return failures of H4 for bodies of units that are not symmetric about the plane."""
    failures = []
    for unit in units:
        for body in unit.bodies:
            off, inertia = shaft.rows.height(body.centre) - unit.z, tensor(shaft, body)
            product = float(np.hypot(*inertia[:2, 2]))
            if abs(off) > EXACT_TOLERANCE * shaft.rows.length:
                text = f"has its centre of mass beside the plane of '{unit.name}'"
                failures.append(Failure("H4", body.name, text, off, "m"))
            if product > EXACT_TOLERANCE * np.trace(inertia):
                text = "has a product of inertia with the normal of its plane"
                failures.append(Failure("H4", body.name, text, product, "kg m^2"))
    return failures


def form_planes(
    shaft: Shaft, units: list[Unit], joints: list[list], bodies: dict, loads: dict
) -> tuple[tuple[Plane, ...], list[Failure]]:
    """Build one planar system per station, and one for the rest of the shaft if its centre of mass needs it."""
    stations: dict[float, list[int]] = {}
    for k, unit in enumerate(units):
        near = (z for z in stations if abs(z - unit.z) <= EXACT_TOLERANCE * shaft.rows.length)
        stations.setdefault(next(near, unit.z), []).append(k)
    members = [*stations.values(), []]
    throws = [sum(throw(shaft, joints[k], bodies) for k in own) for own in stations.values()]
    heights, slices, unseen = cut(shaft, np.array(list(stations)), np.array(throws))
    gravity = shaft.rows.flat(shaft.rows.system.gravity)
    planes = []
    for k, (height, body) in enumerate(zip(heights, slices, strict=True)):
        bearing = planar.Revolute(planar.GROUND, body, at=shaft.point, name="bearing of the shaft")
        own = [bodies[id(part)] for i in members[k] for part in units[i].bodies]
        links = [joint for i in members[k] for joint in joints[i]]
        pulls = [load for i in (*members[k], *([None] if k == 0 else [])) for load in loads.get(i, [])]
        links, pulls = ([moved(part, bodies[id(shaft.body)], body) for part in parts] for parts in (links, pulls))
        driver = planar.AngleDriver(bearing, planar.rate(shaft.speed), name="driver of the shaft")
        system = planar.System([body, *own], [bearing, driver, *links], pulls, gravity)
        planes.append(Plane(float(height), system, tuple(units[i].name for i in members[k])))
    return tuple(planes), unseen
