"""Parts of force laws: forces at points, moments, and components that are signals.

A law reads its record ``p`` of the table FORCE, and its parameters by name: ``own = read(m.number, p.number)``, see
`compiler.records`. It fills Q of its bodies (reduced to O), the energy the element stores
(``out.potential``) and the power of the part that stores none (``out.power``): Q'v = -d(potential)/dt + power. Along a
hinge coordinate it reads the value ``out.x`` and ``out.rate`` and gives ``out.load``; Q is filled for it.
"""

import numpy as np

from ..compiler.decorators import inner_kernel, merged_kernel
from .signals import signal
from .vectors import add6, arm, cross, dot, point, point_velocity, scale, sub, vec

TANH_SATURATION = 20.0  # [1] argument from which on tanh is 1 to rounding


@inner_kernel
def tanh(x):
    """Return tanh x of a real or complex number; that of numpy overflows for complex numbers from 355 on."""
    way = 1.0 + 0.0 * x
    if x.real < -TANH_SATURATION:
        way = -way
    elif x.real < TANH_SATURATION:
        way = np.tanh(x)
    return way


@inner_kernel
def add_force(body, force, s):
    """Add a force acting at O + s to a body."""
    add6(body.Q, force, cross(s, force))


@inner_kernel
def add_moment(body, moment):
    """Add a moment to a body."""
    add6(body.Q, scale(0.0, moment), moment)


@inner_kernel
def apply_along_gradient(d, bodies, out):
    """Add the load of an element along its gradient to Q of two bodies."""
    a, b = d.body[bodies[0]], d.body[bodies[1]]
    add6(a.Q, scale(out.load, vec(out.gradient[0])), scale(out.load, vec(out.gradient[1])))
    add6(b.Q, scale(out.load, vec(out.gradient[2])), scale(out.load, vec(out.gradient[3])))


@inner_kernel
def stop_load(k, c, depth, rate):
    """Return (load, its elastic part) of a stop that is pressed in by a depth: k d + c d_dot, never below 0."""
    load = elastic = 0.0 * rate + 0.0  # not -0
    if depth.real > 0.0:
        elastic = k * depth
        if (elastic + c * rate).real > 0.0:
            load = elastic + c * rate
    return load, elastic


@inner_kernel
def line_between(d, p):
    """Return (length, its rate, unit vector from a to b, arms on a and b) of an element; NaN where points meet."""
    a, b = d.body[p.body[0]], d.body[p.body[1]]
    sa, sb = arm(a, p.point[0]), arm(b, p.point[1])
    gap, rate = sub(point(b, sb), point(a, sa)), sub(point_velocity(b, sb), point_velocity(a, sa))
    length = np.sqrt(dot(gap, gap))
    n = scale(1.0 / length, gap)
    return length, dot(n, rate), n, sa, sb


@merged_kernel
def series(m, p, k, count):
    """Return the k-th array of ``count`` parameters of those that follow the named ones."""
    first = p.number + p.named + k * count
    return m.number[first : first + count]


@inner_kernel
def components(m, p, t):
    """Return the three signal components of an element at time t."""
    x = signal(m, p.signal[0], t)[0] if p.signal[0] >= 0 else 0.0
    y = signal(m, p.signal[1], t)[0] if p.signal[1] >= 0 else 0.0
    z = signal(m, p.signal[2], t)[0] if p.signal[2] >= 0 else 0.0
    return x, y, z
