"""Applied forces Q, the velocity-quadratic term h, stored energy and power of every body and force element.

``h = (0, w x I_G w) + (m w x (w x s), m s x (w x (w x s)))`` on the left side of the equations: gyroscopic and
centripetal part. Q holds gravity and the force elements, reduced to O. The law of a force is next to its class, in a
file of `mechanism.forces`; this module finds them all.
"""

import pkgutil
from collections.abc import Callable
from importlib import import_module

from ..base.errors import InputError
from ..compiler.decorators import inner_kernel, kernel
from ..compiler.late import late_choice
from ..kernels.coordinates import coordinate
from ..kernels.force_laws import apply_along_gradient
from ..kernels.vectors import add, add_scaled, cross, dot, mat, pair, put, put6, rotate, scale, sub, turning, vec
from ..mechanism import forces
from ..mechanism.force_element import ForceElement


def kernels_of_all_forces(name: str) -> tuple[Callable, ...]:
    """Return the kernels of a name that classes in the files of `mechanism.forces` have, in the order of the classes.

    ``name`` is "law", or "gap" of stops.
    """
    found = {}
    for module in pkgutil.iter_modules(forces.__path__, f"{forces.__name__}."):
        for cls in vars(import_module(module.name)).values():
            if isinstance(cls, type) and issubclass(cls, ForceElement) and getattr(cls, name, None) is not None:
                found[cls.__qualname__] = getattr(cls, name)
    return tuple({id(one): one for _, one in sorted(found.items())}.values())


LAWS = kernels_of_all_forces("law")


def number_of_law(force: ForceElement, name: str) -> int:
    """Place of the law of a force in LAWS, which is the ``kind`` of its record.

    Raises
    ------
    ValueError
        If its class has no law, or stands where it is not looked for.
    """
    law = type(force).law
    for number, known in enumerate(LAWS):
        if known is law:
            return number
    raise InputError(
        f"force '{name}' ({type(force).__name__}): its class has no compiled law; give it a kernel `law` in a file of "
        f"{forces.__name__}, or use CustomForce"
    )


apply_law = late_choice(__name__, "apply_law", LAWS)


@inner_kernel
def gravity_and_gyroscopic_terms(m, d):
    """Set gravity in Q and the velocity-quadratic term h of all bodies."""
    g = vec(m.gravity)
    put6(d.body[m.body.shape[0]].Q, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))  # what acts on the ground adds up there
    for i in range(m.body.shape[0]):
        body, mass = d.body[i], m.body[i].mass
        R, w, s, w_body = mat(body.R), vec(body.w), vec(body.s), vec(body.w_body)
        spin = scale(m.gyroscopic, cross(w_body, rotate(mat(m.body[i].inertia), w_body)))
        pull = scale(m.centripetal * mass, turning(w, s))
        weight = scale(mass, g)
        put6(body.Q, weight, cross(s, weight))
        put(body.spin, spin)
        put6(body.h, pull, add(rotate(R, spin), cross(s, pull)))


@inner_kernel
def evaluate_coordinate(m, d, p, out, t):
    """Evaluate value, rate and gradient of the hinge coordinate along which an element acts."""
    a, b = d.body[m.coordinate[p.coordinate].body[0]], d.body[m.coordinate[p.coordinate].body[1]]
    x, _, la, ta, lb, tb = coordinate(m, d, p.coordinate, t)
    out.x = x
    out.rate = dot(la, vec(a.velocity)) + dot(ta, vec(a.w)) + dot(lb, vec(b.velocity)) + dot(tb, vec(b.w))
    put(out.gradient[0], la)
    put(out.gradient[1], ta)
    put(out.gradient[2], lb)
    put(out.gradient[3], tb)


@inner_kernel
def apply_coordinate_load(m, d, p, out):
    """Add the load of an element along its hinge coordinate to Q."""
    apply_along_gradient(d, m.coordinate[p.coordinate].body, out)


@inner_kernel
def right_sides(m, d):
    """Set Q - h and gamma at the current rows and loads as the right side of the saddle point."""
    for i in range(m.body.shape[0]):
        body = d.body[i]
        force, moment = pair(body.Q)
        pull, _ = pair(body.h)
        force = sub(force, pull)  # the gyroscopic part of h goes in body axes, the rest about O
        put6(body.top, force, sub(moment, cross(vec(body.s), pull)))
        put(body.turn, scale(-1.0, vec(body.spin)))
    for i in range(m.reflected.shape[0]):
        load = m.reflected[i].inertia * d.reflected[i].bias
        for end in range(2):
            b = m.reflected[i].body[end]
            if b < m.body.shape[0]:
                add_scaled(d.body[b].top, -load, d.reflected[i].J[end])
    for k in range(m.row.shape[0]):
        d.row[k].bottom = d.row[k].gamma


@kernel
def loads(m, d, t):
    """Evaluate Q, h, potential, power and state_rate; needs kinematics."""
    gravity_and_gyroscopic_terms(m, d)
    for i in range(m.force.shape[0]):
        p, out = m.force[i], d.force[i]
        if p.coordinate >= 0:
            evaluate_coordinate(m, d, p, out, t)
        apply_law(p.kind, m, d, p, out, t)
        if p.coordinate >= 0:
            apply_coordinate_load(m, d, p, out)
