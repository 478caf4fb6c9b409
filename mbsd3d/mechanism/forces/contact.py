"""Contact of a smooth surface with a plane, a sphere or a capsule: it presses, rubs, resists rolling, and lifts off."""

from dataclasses import KW_ONLY
from functools import cached_property

import numpy as np

from ...base.checks import short_repr
from ...base.errors import InputError
from ...base.fields import Number, NumberOrNone, kept, part_class
from ...base.rotations import perpendiculars
from ...base.wording import with_article
from ...compiler.decorators import inner_kernel
from ...kernels.force_laws import add_force, add_moment
from ...kernels.surfaces import CONTACT, contact_parameters, meeting, pressure
from ...kernels.vectors import add, dot, scale, sub, vec
from ..bodies import Body, Ground, as_body
from ..contacts import Plane, level_plane
from ..force_element import ForceElement, ForceRecord, check_pair
from ..motion_protocols import Motion
from ..rounded import RoundBar, Rounded, round_bar, rounded
from ..shapes import Shape
from ..shapes.solids import Capsule, Sphere

STANDARD_GRAVITY = 9.81  # [m/s^2] of the load under which the default grip is as stiff as the contact itself


@inner_kernel
def gripped(k, c, x, y, u, v, most):
    """Return (f, x_dot) of two components: f = k x + c u, limited to ``most``, and x_dot = (f - k x) / c."""
    f, g = k * x + c * u, k * y + c * v
    square = f * f + g * g
    if most.real <= 0.0:  # nothing rubs, also in derivatives
        f, g = 0.0 * f, 0.0 * g
    elif square.real > most.real * most.real:
        share = most / np.sqrt(square)
        f, g = share * f, share * g
    return f, g, (f - k * x) / c, (g - k * y) / c


@inner_kernel
def smooth(most, u, v, still):
    """Return f = most (u, v) / sqrt(u^2 + v^2 + still^2)."""
    share = most / np.sqrt(u * u + v * v + still * still)
    return share * u, share * v


@inner_kernel
def contact_friction(own, d, p, out, normal, slip, turn):
    """Return (friction, moment) in the axes of the plane, against the slip and the relative rotation.

    Internal states: deflection (2) [m], and with rolling or spinning friction rotation (3) [rad].
    """
    mu, rolling, spinning, still = own.friction, own.rolling, own.spinning, own.creep
    k, c, size = own.grip, own.grip_damping, own.size
    kr, cr = k * size * size, c * size * size
    if p.states == 0:
        f, g = smooth(mu * normal, slip[0], slip[1], still)
        r, s = smooth(rolling * normal, turn[0], turn[1], still / size)
        q, _ = smooth(spinning * normal, turn[2], 0.0 * turn[2], still / size)
        return (f, g), (r, s, q)
    i = p.state
    x, y = d.z[i], d.z[i + 1]
    f, g, x_dot, y_dot = gripped(k, c, x, y, slip[0], slip[1], mu * normal)
    d.state_rate[i], d.state_rate[i + 1] = x_dot, y_dot
    out.potential += 0.5 * k * (x * x + y * y)
    out.power += k * (x * x_dot + y * y_dot)
    r, s, q = 0.0 * f, 0.0 * f, 0.0 * f
    if p.states > 2:
        x, y, z = d.z[i + 2], d.z[i + 3], d.z[i + 4]
        r, s, x_dot, y_dot = gripped(kr, cr, x, y, turn[0], turn[1], rolling * normal)
        q, _, z_dot, _ = gripped(kr, cr, z, 0.0 * z, turn[2], 0.0 * z, spinning * normal)
        d.state_rate[i + 2], d.state_rate[i + 3], d.state_rate[i + 4] = x_dot, y_dot, z_dot
        out.potential += 0.5 * kr * (x * x + y * y + z * z)
        out.power += kr * (x * x_dot + y * y_dot + z * z_dot)
    return (f, g), (r, s, q)


@inner_kernel
def contact(m, d, p, out, t):
    """Apply normal force, friction, and moments against rolling and spinning, at the lowest point."""
    own = contact_parameters(m.number, p.number)
    a, b = d.body[p.body[0]], d.body[p.body[1]]
    plane, on_a, on_b, gap, velocity = meeting(own, p, a, b)
    spin = sub(vec(b.w), vec(a.w))
    slip = (dot(plane[0], velocity), dot(plane[1], velocity), -dot(plane[2], velocity))
    turn = (dot(plane[0], spin), dot(plane[1], spin), dot(plane[2], spin))
    normal, elastic, depth = pressure(own, gap, slip[2])
    out.potential = elastic * depth / (own.exponent + 1.0)
    out.power = (elastic - normal) * slip[2]
    friction, moment = contact_friction(own, d, p, out, normal, slip, turn)
    out.power -= friction[0] * slip[0] + friction[1] * slip[1]
    out.power -= moment[0] * turn[0] + moment[1] * turn[1] + moment[2] * turn[2]
    force = sub(scale(normal, plane[2]), add(scale(friction[0], plane[0]), scale(friction[1], plane[1])))
    couple = add(add(scale(moment[0], plane[0]), scale(moment[1], plane[1])), scale(moment[2], plane[2]))
    add_force(b, force, on_b)
    add_moment(b, scale(-1.0, couple))
    add_force(a, scale(-1.0, force), on_a)
    add_moment(a, couple)


def across(line: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Return the direction of a line at right angles to an axis; any such one for a line along it."""
    off = line - (line @ axis) * axis
    length = float(np.linalg.norm(off))
    return off / length if length > 1e-6 * float(np.linalg.norm(line)) else perpendiculars(axis)[0]


@part_class()
class Contact(ForceElement):
    """A surface of body b touches a plane, a sphere or a capsule of body a: it presses, rubs and lifts off.

    A sphere, an ellipsoid or a torus touches a plane, and all acts at its lowest point over it, which is known in
    closed form (see `mbsd3d.kernels.surfaces`). With ``other`` a sphere touches a sphere or a capsule of a, and all
    acts midway between both surfaces on the shortest line to its centre. With the penetration d and the slip velocity V
    of b over a there:

    - normal force ``N = k d^m (1 + x d_dot) + c d_dot``, never below 0: it does not pull;
    - friction ``F = -clip(k_t z + c_t V, mu N)``, where the deflection z is an internal state,
      ``z_dot = (|F| - k_t z) / c_t`` along F: it sticks with ``z_dot = V``, so that what stands does not creep, slips
      with ``|F| = mu N`` exactly, and z decays while separated. It always dissipates;
    - moments against rolling and spinning by the same law, with ``rolling N``, ``spinning N`` in place of ``mu N``.

    Energy ``k d^(m+1) / (m+1) + k_t z'z / 2`` (and that of the rotations); the rest of the power is dissipated.
    `measures.clearance` and `measures.normal_force` read it; `measures.touches`, `measures.leaves` stop a run.
    Contacts are stiff: give `RadauIIA` or `GeneralizedAlpha` to `simulate` where they last, `DOP853` where they bounce.
    There is one point of contact: a disc that settles to lie flat has it run round ever faster, end such runs before.

    Parameters
    ----------
    surface : Sphere, Ellipsoid or Torus
        One of `mbsd3d.shapes`, in axes of body b, centred at the centre of mass unless ``at`` is given.
    stiffness, exponent : float
        k > 0 [N/m^m] and m >= 1: 1 for a linear spring, 1.5 for Hertz.
    damping, loss : float
        c >= 0 [N s/m], which acts at once on contact, and x >= 0 [s/m] (Hunt and Crossley), which grows with d^m.
    friction : float
        mu >= 0 of Coulomb.
    rolling, spinning : float
        Arms >= 0 [m] of the moments against rolling and against spinning about the normal.
    grip, grip_damping : float or None
        k_t > 0 [N/m], c_t > 0 [N s/m]; None: the stiffness of the normal force under the weight of b, and
        ``sqrt(k_t mass)``. The rotations have k_t s^2 and c_t s^2, with the farthest point s of the surface.
    creep : float or None
        A speed v0 > 0 [m/s]: ``F = -mu N V / sqrt(V'V + v0^2)`` without states instead, which is smooth but never
        stands on a slope; the rotations likewise with v0 / s.
    plane : (point, normal) or None
        Plane fixed in a, world at the reference pose; None = z = 0. The surface is where the normal points.
    other : Sphere or Capsule, optional
        Of `mbsd3d.shapes`, in axes of body a, instead of a plane; ``surface`` is a sphere then. A start with the centre
        of this one on the centre or axis of the other is refused: no direction would lead out. One that comes as deep
        in a run leaves on the far side, and the check "overlap" of its certificate fails: give k well above
        ``m v^2 / (R + r)^2`` (m = 1).

    Raises
    ------
    ValueError
        For another surface or ``other``, ``other`` beside ``plane``, a number out of its range, a grip without friction
        or beside ``creep``, or a default of the grip that a body without mass cannot give.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Contact, System, accelerations, shapes
    >>> ball = Body("ball", mass=2.0, inertia=(0.008, 0.008, 0.008), position=(0, 0, 0.099))
    >>> floor = Contact(GROUND, ball, shapes.Sphere(0.1), stiffness=4e4)
    >>> now = accelerations(System([ball], forces=[floor]))
    >>> round(float(now.acceleration(ball)[0, 2]), 9)  # 4e4 * 0.001 / 2 - 9.81
    10.19
    """

    law, law_parameters = staticmethod(contact), CONTACT

    a: Body | Ground
    b: Body = kept(by=as_body)
    surface: Shape
    _: KW_ONLY
    stiffness: Number = kept(positive=True)
    exponent: Number = kept(default=1.0, minimum=1.0)
    damping: Number = kept(default=0.0, minimum=0.0)
    loss: Number = kept(default=0.0, minimum=0.0)
    friction: Number = kept(default=0.0, minimum=0.0)
    rolling: Number = kept(default=0.0, minimum=0.0)
    spinning: Number = kept(default=0.0, minimum=0.0)
    grip: NumberOrNone = kept(default=None, positive=True)
    grip_damping: NumberOrNone = kept(default=None, positive=True)
    creep: NumberOrNone = kept(default=None, positive=True)
    plane: Plane = kept(default=None, derived=level_plane)
    other: Shape | None = None

    def check(self, what: str) -> None:
        check_pair(self.a, self.b, what)
        rounded(self.surface, self.b, what)
        if self.other is not None:
            self.check_other(what)
        given = [name for name in ("grip", "grip_damping") if getattr(self, name) is not None]
        if given and not self.states():
            other = "creep" if self.creep is not None else "no friction, rolling or spinning"
            raise InputError(f"{what}: {given[0]} does nothing with {other}; leave out one of them")
        if self.states() and self.b.mass == 0.0 and len(given) < 2:
            raise InputError(f"{what}: '{self.b.name}' has no mass to choose grip by; give grip and grip_damping")

    def check_other(self, what: str) -> None:
        """Reject arguments that cannot be combined with ``other``."""
        if not isinstance(self.other, Sphere | Capsule):
            raise InputError(
                f"{what}: other {short_repr(self.other)} has no rule; give shapes.Sphere or shapes.Capsule"
            )
        if not isinstance(self.surface, Sphere):
            kind = type(self.surface).__name__
            raise InputError(
                f"{what}: surface is {with_article(kind)}; beside other= give a shapes.Sphere, or a plane instead"
            )
        if not all(map(np.array_equal, self.plane, level_plane(self))):
            raise InputError(f"{what}: both other and plane; leave out one of them")

    @cached_property
    def bristles(self) -> tuple[float, float]:
        """Return stiffness [N/m] and damping [N s/m] of the deflection, given or by default; 1 where nothing rubs."""
        if not self.states():
            return 1.0, 1.0
        grip, damping = self.grip, self.grip_damping
        if grip is None:
            depth = (self.b.mass * STANDARD_GRAVITY / self.stiffness) ** (1.0 / self.exponent)
            grip = self.exponent * self.stiffness * depth ** (self.exponent - 1.0)
        return grip, float(np.sqrt(grip * self.b.mass)) if damping is None else damping

    def states(self) -> int:
        """Number of internal states: 2 deflections, and 3 rotations with friction against rolling or spinning."""
        if self.creep is not None or self.friction == self.rolling == self.spinning == 0.0:
            return 0
        return 5 if self.rolling > 0.0 or self.spinning > 0.0 else 2

    @cached_property
    def outline(self) -> Rounded:
        """Return the surface, world at the reference pose."""
        return rounded(self.surface, self.b, "surface")

    @cached_property
    def bar(self) -> RoundBar | None:
        """Return ``other``, world at the reference pose; None beside a plane."""
        return round_bar(self.other, self.a) if isinstance(self.other, Sphere | Capsule) else None

    def record(self) -> ForceRecord:
        (at, normal), form, states, bar = self.plane, self.outline, self.states(), self.bar
        along = perpendiculars(normal)[0]
        grip, grip_damping = self.bristles
        own = {"radii": form.radii, "tube": form.tube, "size": form.size, "creep": self.creep or 1.0}
        own |= {"other": bar.radius if bar else 0.0, "half": bar.half if bar else 0.0}
        if bar is not None:
            at, along = bar.centre, bar.axis
            normal = across(form.centre - at, along)
        return ForceRecord(
            (self.a, self.b), (at, form.centre), frame=np.column_stack([along, np.cross(normal, along), normal]),
            frame_b=form.axes, states=(0.0,) * states,
            parameters=self.read_by_law(**own, grip=grip, grip_damping=grip_damping),
            scales=((1.0, 1.0, 0.0),) * 2 * (states > 0) + ((1.0, 0.0, 0.0),) * 3 * (states > 2),
        )  # fmt: skip

    def state_names(self) -> tuple[str, ...]:
        return ("deflection x", "deflection y", "turn x", "turn y", "turn z")[: self.states()]

    def acting_points(self, motion: Motion) -> np.ndarray:
        """Return (samples, 3) points at which the force acts on both bodies."""
        if self.bar is not None:
            centres = motion.body_point(self.b, self.outline.centre)
            return self.midway(centres, self.bar.moving(motion, self.a, centres))
        return self.outline.moving(motion, self.a, self.b, self.plane[1])

    def midway(self, centres: np.ndarray, lines: np.ndarray) -> np.ndarray:
        """Return the points (..., 3) midway between both surfaces, for the shortest lines to the centres."""
        distance = np.linalg.norm(lines, axis=-1, keepdims=True)
        half_gap = 0.5 * (distance - self.bar.radius - self.outline.size) if self.bar else 0.0 * distance
        return centres - (self.outline.size + half_gap) * lines / np.maximum(distance, 1e-12 * self.outline.size)

    def acts_at(self, body: Body | Ground) -> tuple[Body | Ground, np.ndarray]:
        if self.bar is not None:
            centre = self.outline.centre
            return self.b, self.midway(centre, self.bar.shortest(centre, self.bar.centre, self.bar.axis))
        return self.b, self.outline.lowest(self.outline.centre, self.outline.axes, self.plane[1])
