"""3-vectors as tuples, which compiled code keeps in registers without allocation.

Matrices are 9-tuples in row order. Nothing here takes a norm or an absolute value, so every function is also right
for complex arguments (complex-step derivatives); products are transposes, never conjugates.
"""

from ..compiler.decorators import fused_kernel, inner_kernel


@inner_kernel
def vec(a):
    """Return an array of 3 as a tuple."""
    return a[0], a[1], a[2]


@inner_kernel
def mat(a):
    """Return an array of 9 as a tuple."""
    return a[0], a[1], a[2], a[3], a[4], a[5], a[6], a[7], a[8]


@inner_kernel
def pair(a):
    """Return an array of 6 as two 3-vectors."""
    return (a[0], a[1], a[2]), (a[3], a[4], a[5])


@inner_kernel
def put(array, a):
    """Set array[:3] = a."""
    array[0] = a[0]
    array[1] = a[1]
    array[2] = a[2]


@inner_kernel
def put6(array, a, b):
    """Set array = (a, b)."""
    array[0] = a[0]
    array[1] = a[1]
    array[2] = a[2]
    array[3] = b[0]
    array[4] = b[1]
    array[5] = b[2]


@inner_kernel
def add6(array, a, b):
    """Add array += (a, b)."""
    array[0] += a[0]
    array[1] += a[1]
    array[2] += a[2]
    array[3] += b[0]
    array[4] += b[1]
    array[5] += b[2]


@inner_kernel
def add(a, b):
    """Return a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@inner_kernel
def sub(a, b):
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@inner_kernel
def scale(k, a):
    """Return k a."""
    return k * a[0], k * a[1], k * a[2]


@fused_kernel
def dot(a, b):
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@fused_kernel
def cross(a, b):
    """Return a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@fused_kernel
def turning(w, s):
    """Return w x (w x s): centripetal acceleration of a point at s."""
    return cross(w, cross(w, s))


@fused_kernel
def rotate(R, a):
    """Return R a."""
    return (
        R[0] * a[0] + R[1] * a[1] + R[2] * a[2],
        R[3] * a[0] + R[4] * a[1] + R[5] * a[2],
        R[6] * a[0] + R[7] * a[1] + R[8] * a[2],
    )


@fused_kernel
def rotate_back(R, a):
    """Return R' a."""
    return (
        R[0] * a[0] + R[3] * a[1] + R[6] * a[2],
        R[1] * a[0] + R[4] * a[1] + R[7] * a[2],
        R[2] * a[0] + R[5] * a[1] + R[8] * a[2],
    )


@inner_kernel
def arm(body, local):
    """Return R p: a body-fixed vector in world axes."""
    return rotate(mat(body.R), vec(local))


@inner_kernel
def columns(body, frame):
    """Return the columns of R frame: the axes of an element in world axes."""
    R, F = mat(body.R), mat(frame)
    return rotate(R, (F[0], F[3], F[6])), rotate(R, (F[1], F[4], F[7])), rotate(R, (F[2], F[5], F[8]))


@inner_kernel
def point(body, s):
    """Return the world position of the point at s (world) from O."""
    return add(vec(body.r), s)


@inner_kernel
def point_velocity(body, s):
    """Return the velocity of the point of the body at s (world) from O."""
    return add(vec(body.velocity), cross(vec(body.w), s))


@inner_kernel
def finite(array):
    """Return True if no entry is NaN or infinite."""
    total = 0.0
    for i in range(array.shape[0]):
        total += abs(array[i]) * 0.0
    return total == 0.0


@inner_kernel
def copy(target, source):
    """Set target = source."""
    for i in range(source.shape[0]):
        target[i] = source[i]


@inner_kernel
def add_scaled(target, k, source):
    """Add target += k source."""
    for i in range(source.shape[0]):
        target[i] += k * source[i]


@inner_kernel
def clear(target):
    """Set target = 0."""
    for i in range(target.shape[0]):
        target[i] = 0.0
