"""Applied forces Q, the velocity-quadratic term h, stored energy and power of every body and force element.

``h = (0, w x I_G w) + (m w x (w x s), m s x (w x (w x s)))`` on the left side of the equations: gyroscopic and
centripetal part. Q holds gravity and the force elements, reduced to O. Each element also reports the energy it stores
(`potential`) and the power of the part that stores none (`power`), so that Q'v = -d(potential)/dt + power.
A new force is one function here and one line in `loads`.
"""

import numpy as np

from .coordinates import coordinate, measure
from .custom import custom
from .jit import inner_kernel, kernel, merged_kernel
from .kinds import BUSHING, COORDINATE_SPRING, CUSTOM, DRAG, FEEDBACK, FORCE, FRICTION, SPRING, TORQUE
from .signals import signal
from .vectors import (  # fmt: skip
    add,
    add6,
    arm,
    cross,
    dot,
    mat,
    point,
    point_velocity,
    put,
    put6,
    rotate,
    scale,
    sub,
    turning,
    vec,
)


@inner_kernel
def push(body, force, s):
    """Add a force acting at O + s to a body."""
    add6(body.Q, force, cross(s, force))


@inner_kernel
def twist(body, moment):
    """Add a moment to a body."""
    add6(body.Q, scale(0.0, moment), moment)


@merged_kernel
def inertial(m, d):
    """Gravity in Q and the velocity-quadratic term h of all bodies."""
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
def components(m, p, t):
    """The three signal components of an element at time t."""
    x = signal(m, p.signal[0], t)[0] if p.signal[0] >= 0 else 0.0
    y = signal(m, p.signal[1], t)[0] if p.signal[1] >= 0 else 0.0
    z = signal(m, p.signal[2], t)[0] if p.signal[2] >= 0 else 0.0
    return x, y, z


@merged_kernel
def applied(m, d, p, out, t):
    """Force (at a point) or torque with given components in world or body axes (value[0] = 1)."""
    body = d.body[p.body[1]]
    x = components(m, p, t)
    load = rotate(mat(body.R), x) if p.value[0] > 0.5 else add(x, scale(0.0, vec(body.w)))
    if p.kind == TORQUE:
        twist(body, load)
        out.power = dot(load, vec(body.w))
    else:
        s = arm(body, p.point[1])
        push(body, load, s)
        out.power = dot(load, point_velocity(body, s))


@merged_kernel
def spring(d, p, out):
    """Force -(k (l - l0) + c l_dot) n on b along the line from a to b; value = k, c, l0."""
    a, b = d.body[p.body[0]], d.body[p.body[1]]
    sa, sb = arm(a, p.point[0]), arm(b, p.point[1])
    gap = sub(point(b, sb), point(a, sa))
    length = np.sqrt(dot(gap, gap))
    n = scale(1.0 / length, gap)
    stretch, speed = length - p.value[2], dot(n, sub(point_velocity(b, sb), point_velocity(a, sa)))
    pull = scale(p.value[0] * stretch + p.value[1] * speed, n)
    push(a, pull, sa)
    push(b, scale(-1.0, pull), sb)
    out.potential = 0.5 * p.value[0] * stretch * stretch
    out.power = -p.value[1] * speed * speed


@merged_kernel
def feedback(m, d, p, t):
    """Load -sum g_i (x_i - r_i); x_i is measure i or its filtered value z_i with z_dot_i = (y_i - z_i) / tau."""
    load = 0.0
    for i in range(p.measures):
        x = measure(m, d, p.measure + i, t)
        if p.states > 0:
            z = d.z[p.state + i]
            d.state_rate[p.state + i] = (x - z) / p.value[0]
            x = z
        load -= m.number[p.number + i] * (x - m.number[p.number + p.measures + i])
    return load


@merged_kernel
def along_coordinate(m, d, p, out, t):
    """Spring (k, c, rest value), friction (T, c, speed of transition) or feedback along a hinge coordinate."""
    x, _, la, ta, lb, tb = coordinate(m, d, p.coordinate, t)
    a, b = d.body[m.coordinate[p.coordinate].body[0]], d.body[m.coordinate[p.coordinate].body[1]]
    rate = dot(la, vec(a.velocity)) + dot(ta, vec(a.w)) + dot(lb, vec(b.velocity)) + dot(tb, vec(b.w))
    if p.kind == COORDINATE_SPRING:
        stretch = x - p.value[2]
        load = -p.value[0] * stretch - p.value[1] * rate
        out.potential = 0.5 * p.value[0] * stretch * stretch
        out.power = -p.value[1] * rate * rate
    elif p.kind == FEEDBACK:
        load = feedback(m, d, p, t)
        out.power = load * rate
    else:
        load = -p.value[0] * np.tanh(rate / p.value[2]) - p.value[1] * rate
        out.power = load * rate
    add6(a.Q, scale(load, la), scale(load, ta))
    add6(b.Q, scale(load, lb), scale(load, tb))


@inner_kernel
def columns(body, frame):
    """Columns of R frame: the axes of an element in world axes."""
    R, F = mat(body.R), mat(frame)
    return rotate(R, (F[0], F[3], F[6])), rotate(R, (F[1], F[4], F[7])), rotate(R, (F[2], F[5], F[8]))


@inner_kernel
def into(F, a):
    """F'a for axes F given as three columns."""
    return dot(F[0], a), dot(F[1], a), dot(F[2], a)


@inner_kernel
def out_of(F, a):
    """F a for axes F given as three columns."""
    return add(add(scale(a[0], F[0]), scale(a[1], F[1])), scale(a[2], F[2]))


@inner_kernel
def relative_quaternion(A, B):
    """(p0, p) of the rotation A'B as a quaternion, for rotations below half a turn."""
    p0 = 0.5 * np.sqrt(1.0 + dot(A[0], B[0]) + dot(A[1], B[1]) + dot(A[2], B[2]))
    k = 0.25 / p0
    x, y, z = dot(A[2], B[1]) - dot(A[1], B[2]), dot(A[0], B[2]) - dot(A[2], B[0]), dot(A[1], B[0]) - dot(A[0], B[1])
    return p0, (k * x, k * y, k * z)


@inner_kernel
def scaled(p, first, x):
    """Diagonal stiffness or damping times a vector: value[first + i] x_i."""
    return p.value[first] * x[0], p.value[first + 1] * x[1], p.value[first + 2] * x[2]


@merged_kernel
def bushing(d, p, out):
    """Linear bushing in the axes F of a: force -(K d + C d_dot), moment from U = 2 p'K_r p and -C_r w.

    d is the displacement of the point of b in F; p the vector part of the relative quaternion, so that
    p_dot = (p0 w + w x p)/2 and the elastic moment on b is -2 (p0 K_r p + p x K_r p) in F.
    """
    a, b = d.body[p.body[0]], d.body[p.body[1]]
    A, B = columns(a, p.frame[0]), columns(b, p.frame[1])
    sb = arm(b, p.point[1])
    reach = sub(point(b, sb), vec(a.r))  # the force on a acts where the point of b is
    x = into(A, sub(reach, arm(a, p.point[0])))
    x_dot = into(A, sub(point_velocity(b, sb), point_velocity(a, reach)))
    w = into(A, sub(vec(b.w), vec(a.w)))
    p0, e = relative_quaternion(A, B)
    Kx, Cx, Ke, Cw = scaled(p, 0, x), scaled(p, 6, x_dot), scaled(p, 3, e), scaled(p, 9, w)
    force = out_of(A, scale(-1.0, add(Kx, Cx)))
    moment = out_of(A, sub(scale(-2.0, add(scale(p0, Ke), cross(e, Ke))), Cw))
    push(b, force, sb)
    push(a, scale(-1.0, force), reach)
    twist(b, moment)
    twist(a, scale(-1.0, moment))
    out.potential = 0.5 * dot(x, Kx) + 2.0 * dot(e, Ke)
    out.power = -dot(x_dot, Cx) - dot(w, Cw)


@merged_kernel
def drag(m, d, p, out, t):
    """Aerodynamic drag -k |v| v at a point, v relative to the wind; value[0] = k = density area coefficient / 2."""
    body = d.body[p.body[1]]
    s = arm(body, p.point[1])
    v = sub(point_velocity(body, s), components(m, p, t))
    force = scale(-p.value[0] * np.sqrt(dot(v, v)), v)
    push(body, force, s)
    out.power = dot(force, point_velocity(body, s))


@kernel
def loads(m, d, t):
    """Fill Q, h, potential, power, state_rate; needs kinematics."""
    inertial(m, d)
    for i in range(m.force.shape[0]):
        p, out = m.force[i], d.force[i]
        if p.kind == FORCE or p.kind == TORQUE:
            applied(m, d, p, out, t)
        elif p.kind == SPRING:
            spring(d, p, out)
        elif p.kind == COORDINATE_SPRING or p.kind == FRICTION or p.kind == FEEDBACK:
            along_coordinate(m, d, p, out, t)
        elif p.kind == BUSHING:
            bushing(d, p, out)
        elif p.kind == DRAG:
            drag(m, d, p, out, t)
        elif p.kind == CUSTOM:
            custom(m, d, p, out, t)
