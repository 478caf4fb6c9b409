"""What the laws of force elements are made of: loads on bodies at points, about axes and along hinge coordinates.

A law fills Q of its bodies (reduced to O), the energy the element stores (``out.potential``) and the power of the part
that stores none (``out.power``), so that Q'v = -d(potential)/dt + power. It reads its record ``p`` of the table FORCE.
"""

from .coordinates import coordinate
from .jit import inner_kernel, merged_kernel
from .signals import signal
from .vectors import add6, cross, dot, scale, vec


@inner_kernel
def push(body, force, s):
    """Add a force acting at O + s to a body."""
    add6(body.Q, force, cross(s, force))


@inner_kernel
def twist(body, moment):
    """Add a moment to a body."""
    add6(body.Q, scale(0.0, moment), moment)


@inner_kernel
def components(m, p, t):
    """The three signal components of an element at time t."""
    x = signal(m, p.signal[0], t)[0] if p.signal[0] >= 0 else 0.0
    y = signal(m, p.signal[1], t)[0] if p.signal[1] >= 0 else 0.0
    z = signal(m, p.signal[2], t)[0] if p.signal[2] >= 0 else 0.0
    return x, y, z


@merged_kernel
def along(m, d, p, t):
    """(value, rate, blocks (linear a, angular a, linear b, angular b)) of the hinge coordinate of an element."""
    x, _, la, ta, lb, tb = coordinate(m, d, p.coordinate, t)
    a, b = d.body[m.coordinate[p.coordinate].body[0]], d.body[m.coordinate[p.coordinate].body[1]]
    rate = dot(la, vec(a.velocity)) + dot(ta, vec(a.w)) + dot(lb, vec(b.velocity)) + dot(tb, vec(b.w))
    return x, rate, (la, ta, lb, tb)


@merged_kernel
def drive(m, d, p, load, blocks):
    """Add a load along the hinge coordinate of an element: on b, and its opposite on a."""
    la, ta, lb, tb = blocks
    a, b = d.body[m.coordinate[p.coordinate].body[0]], d.body[m.coordinate[p.coordinate].body[1]]
    add6(a.Q, scale(load, la), scale(load, ta))
    add6(b.Q, scale(load, lb), scale(load, tb))
