"""Couplings: rows on the angles and slides of other joints."""

from dataclasses import KW_ONLY

import numpy as np

from ..base.checks import check_choice, short_repr
from ..base.errors import InputError
from ..base.fields import Number, NumberOrNone, Numbers, Vector, kept, part_class
from ..base.wording import counted, with_article
from ..kernels import kinds
from .bodies import GROUND, Body, Ground
from .joints import AxisJoint, Joint, angle_of, coordinate_of, slide_of
from .motion_protocols import LoadedMotion, Motion
from .primitives import ZERO, Coordinate, Primitive, ratio
from .sums import Joints, KindsOrNone, NumbersOrOnes, places_of, weighted
from .tooth_contact import Axle, line_of_action

SLOTS_COUNT = 4  # [bodies] of a row
COORDINATES_COUNT = 4  # [coordinates] of a row


@part_class()
class Coupling(Joint):
    """Row on the coordinates of other joints; a and b are those of the joint it acts through."""

    def through(self) -> Joint:
        """Return the joint whose bodies carry the reaction."""
        raise NotImplementedError

    @property
    def a(self) -> Body | Ground:
        """Return body a of the joint the coupling acts through."""
        return self.through().a

    @property
    def b(self) -> Body | Ground:
        """Return body b of the joint the coupling acts through."""
        return self.through().b

    def point(self) -> np.ndarray:
        return self.through().point()

    def partners(self) -> list[Joint]:
        return [self.through()]


@part_class()
class Gear(Coupling):
    """Two hinges turn in a fixed ratio = angle_b / angle_a (1 row).

    It couples only the angles, wherever the axes are; `GearMesh` also gives the tooth force.

    Parameters
    ----------
    hinge_a, hinge_b : Joint
        Joints with an angle; their bearings share the housing, as a rule.
    ratio : float
        angle_b / angle_a [1]: -teeth_a / teeth_b for an external mesh of parallel axes; not 0.
    name : str, optional
        For results and messages; "Gear 1" and so on by default.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Gear, Revolute, System, TorqueBetween, accelerations
    >>> one = Body("one", mass=1.0, inertia=(0.1, 0.1, 0.2))
    >>> two = Body("two", mass=1.0, inertia=(0.1, 0.1, 0.2), position=(0.3, 0, 0))
    >>> a = Revolute(GROUND, one, at=(0, 0, 0), axis=(0, 0, 1), name="a")
    >>> b = Revolute(GROUND, two, at=(0.3, 0, 0), axis=(0, 0, 1), name="b")
    >>> motor = TorqueBetween(GROUND, one, (0, 0, 0.5))
    >>> now = accelerations(System([one, two], [a, b, Gear(a, b, ratio=-0.5)], [motor]))
    >>> print(now.alpha(one)[0, 2].round(9), now.alpha(two)[0, 2].round(9))  # 0.5 / (0.2 + 0.2 * 0.5^2)
    2.0 -1.0
    """

    hinge_a: Joint
    hinge_b: Joint
    _: KW_ONLY
    ratio: Number = kept()

    def through(self) -> Joint:
        return self.hinge_b

    def partners(self) -> list[Joint]:
        return [self.hinge_a, self.hinge_b]

    def check(self, what: str) -> None:
        for hinge in (self.hinge_a, self.hinge_b):
            coordinate_of(hinge, "angle", what)
        if self.hinge_a is self.hinge_b:
            raise InputError(f"{what}: both hinges are '{self.hinge_a.name}'; give two")
        if self.ratio == 0.0:
            raise InputError(f"{what}: ratio is 0; give angle_b / angle_a, or lock hinge_b with Fixed")

    def rows(self) -> list[Primitive]:
        return [ratio(angle_of(self.hinge_a), -self.ratio, angle_of(self.hinge_b), 1.0)]


@part_class()
class RackPinion(Coupling):
    """A rack moves by ``radius`` times the angle of a pinion (1 row): slide = radius angle.

    Parameters
    ----------
    pinion : Joint
        A joint with an angle.
    rack : Joint
        A joint with a slide.
    radius : float
        Slide over angle [m/rad]: the pitch radius, negative if they move in opposite directions.
    name : str, optional
        For results and messages; "RackPinion 1" and so on by default.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Prismatic, RackPinion, Revolute, System, accelerations
    >>> wheel, bar = (Body(name, mass=1.0, inertia=(0.1, 0.04, 0.1)) for name in ("wheel", "bar"))
    >>> a = Revolute(GROUND, wheel, at=(0, 0, 0), axis="y", name="a")
    >>> b = Prismatic(GROUND, bar, at=(0.2, 0, 0), axis="z", name="b")
    >>> now = accelerations(System([wheel, bar], [a, b, RackPinion(a, b, radius=0.2)]))
    >>> print(now.acceleration(bar)[0, 2].round(9))  # -g m / (m + I / r^2): the wheel holds it back
    -4.905
    """

    pinion: Joint
    rack: Joint
    _: KW_ONLY
    radius: Number = kept()

    def through(self) -> Joint:
        return self.rack

    def partners(self) -> list[Joint]:
        return [self.pinion, self.rack]

    def check(self, what: str) -> None:
        coordinate_of(self.pinion, "angle", what)
        coordinate_of(self.rack, "slide", what)

    def rows(self) -> list[Primitive]:
        return [ratio(angle_of(self.pinion), -self.radius, slide_of(self.rack), 1.0, in_metres=True)]


@part_class()
class GearMesh(Coupling):
    """Teeth of two gears in contact at a pitch point (1 row): n . (v_b - v_a) = 0 there, n the line of action.

    The residual is c = n . (u_b x d_b) theta_b - n . (u_a x d_a) theta_a [m] plus terms that vanish with the rows of
    the hinges, so that the reaction is the tooth force itself: on gear b, through the pitch point, along n. With
    F_t = torque / radius: F_r = F_t tan(pressure_angle) / cos(helix_angle), F_a = F_t tan(helix_angle). (`Gear` couples
    the same angles by pure torques and loads no bearing.)

    Parameters
    ----------
    hinge_a, hinge_b : Revolute, Cylindrical or Screw
        Hinges of the gears. Axes may be parallel (external or internal mesh), meet (bevel) or cross (screws, hypoid).
    at : (3,) array_like
        Pitch point, world at the reference pose [m]; it stays where it is in the carrier. In the plane of the axes, or
        where they cross anywhere: on their common perpendicular for screws, elsewhere for hypoid gears.
    pressure_angle : float
        Normal pressure angle [rad], 0 <= angle < pi/2; default 20 degrees.
    helix_angle : float
        Helix angle of gear a [rad], > 0 right-handed; of bevel and hypoid gears the spiral angle.
    flank : 1 or -1
        The flanks that touch: those that push gear b forwards or backwards. The row holds both ways; where
        `normal_force` is negative the other flanks touch, and the radial force has the wrong sense.
    carrier : Body, GROUND or None
        Body in which the axes of both gears rest; None = the common body of the hinges. A planet carrier, where the
        sun turns on the ground about the axis of the carrier: gear i is then body b of hinge i. (A ring that is fixed
        to the ground meshes by the hinge of the carrier itself: its gear is the ground.)
    mu : float or None
        Coefficient of friction of teeth that slip along each other, of crossed axes, as of a worm. The `System` then
        has a `DryFriction(mesh, mu=mu)` among its forces, unless one is given.

    Raises
    ------
    ValueError
        For hinges without a common body, a point that is not a pitch point, or angles out of range.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Revolute, System
    >>> one, two = (Body(name, mass=1.0, inertia=(0.1, 0.1, 0.2)) for name in ("one", "two"))
    >>> a = Revolute(GROUND, one, at=(0, 0, 0), axis=(0, 0, 1), name="a")
    >>> b = Revolute(GROUND, two, at=(0.3, 0, 0), axis=(0, 0, 1), name="b")
    >>> mesh = GearMesh(a, b, at=(0.1, 0, 0), helix_angle=0.2)
    >>> System([one, two], [a, b, mesh]).check().mobility, round(mesh.ratio, 12)
    (1, -0.5)
    """

    hinge_a: AxisJoint
    hinge_b: AxisJoint
    _: KW_ONLY
    at: Vector = kept()
    pressure_angle: Number = kept(default=np.pi / 9)
    helix_angle: Number = kept(default=0.0)
    flank: int = 1
    carrier: Body | Ground | None = None
    mu: NumberOrNone = kept(default=None, minimum=0.0)

    def partners(self) -> list[Joint]:
        return [self.hinge_a, self.hinge_b]

    @property
    def a(self) -> Body | Ground:
        """Return the body that carries gear a."""
        return self.gear(self.hinge_a)

    @property
    def b(self) -> Body | Ground:
        """Return the body that carries gear b, on which the reaction is given."""
        return self.gear(self.hinge_b)

    @property
    def ratio(self) -> float:
        """Return the rate of gear b over that of gear a, about the axes of their hinges, relative to the carrier."""
        first, second = self.levers()
        return first / second

    def check(self, what: str) -> None:
        for hinge in (self.hinge_a, self.hinge_b):
            coordinate_of(hinge, "angle", what)
            if not isinstance(hinge, AxisJoint):
                raise InputError(
                    f"{what}: '{hinge.name}' is {with_article(type(hinge).__name__)}; give a Revolute or Cylindrical"
                )
        if self.carrier is not None and not isinstance(self.carrier, Body | Ground):
            raise InputError(f"{what}: carrier = {short_repr(self.carrier)} is not a body; give a Body or GROUND")
        if not 0.0 <= self.pressure_angle < np.pi / 2 or abs(self.helix_angle) >= np.pi / 2:
            raise InputError(
                f"{what}: pressure_angle {self.pressure_angle:g} rad and helix_angle {self.helix_angle:g} rad: "
                "give radians, 0 <= pressure_angle < pi/2 and |helix_angle| < pi/2"
            )
        check_choice(self.flank, (1, -1), f"{what}: flank")
        bodies = {id(body) for body in (self.support(what), self.a, self.b)}
        if len(bodies) < 3:
            raise InputError(f"{what}: carrier and gears are not three bodies; give hinges of two gears on one carrier")
        for hinge in (self.hinge_a, self.hinge_b):
            if self.gear(hinge) is GROUND and self.carrier not in (None, hinge.a, hinge.b):
                raise InputError(f"{what}: the gear on '{hinge.name}' is the ground; give it as body b of the hinge")
        self.direction(what)

    def support(self, what: str = "GearMesh") -> Body | Ground:
        """Return the carrier."""
        if self.carrier is not None:
            return self.carrier
        first, second = self.hinge_a, self.hinge_b
        for body in (first.a, first.b):
            if body is second.a or body is second.b:
                return body
        raise InputError(f"{what}: '{first.name}' and '{second.name}' share no body; give carrier=")

    def gear(self, hinge: AxisJoint) -> Body | Ground:
        """Return the gear on a hinge: the body that is not the carrier."""
        return hinge.a if hinge.b is self.support() else hinge.b

    def axle(self, hinge: AxisJoint) -> Axle:
        """Return the axis of the gear on a hinge, as the carrier has it."""
        return Axle(hinge.at, hinge.axis) if self.gear(hinge) is hinge.b else Axle(hinge.at_b, hinge.axis_b)

    def direction(self, what: str = "GearMesh") -> np.ndarray:
        """Return the line of action n: unit direction of the force on gear b, world at the reference pose."""
        first, second = self.axle(self.hinge_a), self.axle(self.hinge_b)
        return line_of_action(first, second, self.at, self.pressure_angle, self.helix_angle, self.flank, what)

    def levers(self) -> list[float]:
        """Return n . (u_i x d_i) of both gears: their pitch velocities along n per angular velocity [m]."""
        n, axles = self.direction(), [self.axle(hinge) for hinge in (self.hinge_a, self.hinge_b)]
        return [float(n @ np.cross(axle.axis, axle.arm(self.at))) for axle in axles]

    def point(self) -> np.ndarray:
        return self.at

    def reaction_points(self, solution: Motion) -> np.ndarray:
        """Return (samples, 3) pitch points, carried by the carrier."""
        return solution.body_point(self.support(), self.at)

    def normal_force(self, solution: LoadedMotion) -> np.ndarray:
        """Return (samples,) tooth force [N] along the line of action; negative where the other flanks touch."""
        n = solution.body_axis(self.support(), self.direction())
        return np.einsum("ti,ti->t", solution.reaction(self).force, n)

    def rows(self) -> list[Primitive]:
        return [self.row_along(self.direction())]

    def row_along(self, n: np.ndarray) -> Primitive:
        """Return the row n . (v_b - v_a) = 0 at the pitch point, n a unit direction, world at the reference pose."""
        carrier = self.support()
        bodies: list[Body | Ground] = []
        points, axes, tilts, levers, angles = [], [], [], [], []
        for sign, hinge in ((-1.0, self.hinge_a), (1.0, self.hinge_b)):
            gear, mount = self.gear(hinge), self.axle(hinge)
            hub, spin = (hinge.at_b, hinge.axis_b) if gear is hinge.b else (hinge.at, hinge.axis)
            moment = np.cross(self.at - mount.point, n)
            bodies += [carrier, gear]
            points += [mount.point, hub]
            axes += [sign * n, spin]
            tilts += [sign * np.cross(moment, mount.axis), ZERO]  # x . axis = 0, gradient: moment across the axis
            levers.append(sign * float(moment @ mount.axis))
            angles.append(Coordinate("angle", carrier, gear, mount.axis, spin))
        return Primitive(
            kinds.MESH, tuple(bodies), points=tuple(points), axes=tuple(axes), second_axes=tuple(tilts),
            values=tuple(levers), coordinates=tuple(angles),
        )  # fmt: skip


@part_class()
class Coupler(Coupling):
    """An angle or slide y is a polynomial of another one (1 row): y = c0 + c1 x + c2 x^2 + ..., both counted in turns.

    x and y may be weighted sums of coordinates: sum_i w_i y_i = c(sum_j v_j x_j). The row is y - c(x) = 0, and its
    acceleration y_ddot - c' x_ddot = c'' x_dot^2. Where c' = 0 y stands still, and x is not held. The reaction is the
    load R along y, [N m] or [N], on body b of the joint of y, with -c' R along x.

    Parameters
    ----------
    x, y : Joint, or sequence of Joint
        Leader and follower, with an angle or a slide; several are summed. Without a leader, ``()``, y = c0. All
        coordinates together, four at most, are between at most four bodies, the ground included.
    coefficients : sequence of float
        c0, c1, ... of any degree [rad or m by powers of rad or m].
    x_weights, y_weights : sequence of float or None
        v_j and w_i, one per joint; None = ones.
    x_of, y_of : "angle", "slide", a sequence of them, or None
        Coordinate of joints that have both; None = the angle where there is one, else the slide.

    Notes
    -----
    Coordinates are zero at the reference pose: with c0 other than 0 it does not close, and a run starts from
    ``system.assemble()``.

    Raises
    ------
    ValueError
        For a joint without the coordinate, one given twice, weights that are 0 or not one per joint, no
        coefficient, or more than four bodies or coordinates.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Coupler, Prismatic, Revolute, System
    >>> cam, tappet = (Body(name, mass=1.0, inertia=(0.1, 0.1, 0.2)) for name in ("cam", "tappet"))
    >>> axle = Revolute(GROUND, cam, at=(0, 0, 0), axis=(0, 1, 0))
    >>> guide = Prismatic(GROUND, tappet, at=(0, 0, 0.2), axis=(0, 0, 1))
    >>> lift = Coupler(axle, guide, coefficients=(0, 0, 0.01))
    >>> system = System([cam, tappet], [axle, guide, lift])
    >>> round(float(system.assemble(angles={axle: 10.0}).q[9]), 12)  # 0.01 * 10^2
    1.0
    """

    x: Joints = kept()
    y: Joints = kept()
    _: KW_ONLY
    coefficients: Numbers = kept()
    x_weights: NumbersOrOnes = kept(default=None)
    y_weights: NumbersOrOnes = kept(default=None)
    x_of: KindsOrNone = kept(default=None)
    y_of: KindsOrNone = kept(default=None)

    def through(self) -> Joint:
        return self.y[0]

    def partners(self) -> list[Joint]:
        return list(dict.fromkeys((*self.x, *self.y)))

    def check(self, what: str) -> None:
        if not self.y:
            raise InputError(f"{what}: y has no joint; give the joint that follows")
        if not self.coefficients or (not self.x and len(self.coefficients) > 1):
            given = f"{counted(len(self.coefficients), 'coefficient')} for {counted(len(self.x), 'joint')} of x"
            raise InputError(f"{what}: {given}; give c0, c1, ..., and without x only c0")
        places = [*self.places("y", what), *self.places("x", what)]
        for place in places:
            if places.count(place) > 1:
                raise InputError(f"{what}: the {place[1]} of '{place[0].name}' is given twice; name it once")
        if len(places) > COORDINATES_COUNT:
            raise InputError(f"{what}: {len(places)} coordinates; give at most {COORDINATES_COUNT}")
        bodies = self.bodies()
        if len(bodies) > SLOTS_COUNT:
            names = ", ".join(f"'{body.name}'" for body in bodies)
            raise InputError(
                f"{what}: its coordinates are between {len(bodies)} bodies, {names}; give at most {SLOTS_COUNT}, the "
                "ground included"
            )

    def places(self, side: str, what: str) -> list[tuple[Joint, str]]:
        """Return (joint, "angle" or "slide") of each coordinate of a side."""
        return places_of(*self.of_side(side), side, what)

    def sum_of(self, side: str) -> list[tuple[Coordinate, float]]:
        """Return the coordinates of a side with their weights."""
        return weighted(*self.of_side(side))

    def of_side(self, side: str) -> tuple[tuple[Joint, ...], tuple[float, ...] | None, tuple[str | None, ...] | None]:
        """Return joints, weights and kinds of coordinates of "x" or "y"."""
        return (self.y, self.y_weights, self.y_of) if side == "y" else (self.x, self.x_weights, self.x_of)

    def rows(self) -> list[Primitive]:
        y, x = self.sum_of("y"), self.sum_of("x")
        coordinates, weights = zip(*y, *x, strict=True)
        bodies = {id(body): body for one in coordinates for body in (one.a, one.b)}
        return [
            Primitive(
                kinds.COUPLE, tuple(bodies.values()), values=weights, coordinates=coordinates,
                numbers=(float(len(y)), *self.coefficients), in_metres=coordinates[0].kind != "angle",
            )
        ]  # fmt: skip
