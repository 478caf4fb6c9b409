"""6-vectors as pairs of 3-vectors (linear, angular), and symmetric 6x6 matrices [A B; B' C] as three 9-tuples."""

from ..compiler.decorators import fused_kernel
from ..kernels.vectors import add, cross, dot, rotate, rotate_back, scale


@fused_kernel
def dot6(a, b):
    """Return a . b."""
    return dot(a[0], b[0]) + dot(a[1], b[1])


@fused_kernel
def along6(a, k, b):
    """Return a + k b."""
    return add(a[0], scale(k, b[0])), add(a[1], scale(k, b[1]))


@fused_kernel
def times(A, B, C, a):
    """Return [A B; B' C] a."""
    return add(rotate(A, a[0]), rotate(B, a[1])), add(rotate_back(B, a[0]), rotate(C, a[1]))


@fused_kernel
def less_outer(M, k, a, b):
    """Return M - k a b'."""
    x, y, z = k * a[0], k * a[1], k * a[2]
    return (
        M[0] - x * b[0], M[1] - x * b[1], M[2] - x * b[2],
        M[3] - y * b[0], M[4] - y * b[1], M[5] - y * b[2],
        M[6] - z * b[0], M[7] - z * b[1], M[8] - z * b[2],
    )  # fmt: skip


@fused_kernel
def product(M, N):
    """Return M N."""
    return (
        M[0] * N[0] + M[1] * N[3] + M[2] * N[6],
        M[0] * N[1] + M[1] * N[4] + M[2] * N[7],
        M[0] * N[2] + M[1] * N[5] + M[2] * N[8],
        M[3] * N[0] + M[4] * N[3] + M[5] * N[6],
        M[3] * N[1] + M[4] * N[4] + M[5] * N[7],
        M[3] * N[2] + M[4] * N[5] + M[5] * N[8],
        M[6] * N[0] + M[7] * N[3] + M[8] * N[6],
        M[6] * N[1] + M[7] * N[4] + M[8] * N[7],
        M[6] * N[2] + M[7] * N[5] + M[8] * N[8],
    )


@fused_kernel
def transposed(M):
    """Return M'."""
    return M[0], M[3], M[6], M[1], M[4], M[7], M[2], M[5], M[8]


@fused_kernel
def times_skew(M, d):
    """Return M [d]x: row i is M_i x d."""
    a, b, c = cross((M[0], M[1], M[2]), d), cross((M[3], M[4], M[5]), d), cross((M[6], M[7], M[8]), d)
    return a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2]


@fused_kernel
def moved_inertia(A, B, C, d):
    """Return (B, C) of [A B; B' C] about a point at -d: A stays, B - A [d]x, C - B'[d]x + [d]x (B - A [d]x)."""
    x = times_skew(A, d)
    moved = sub9(B, x)
    y = times_skew(transposed(B), d)  # [d]x N = -(N' [d]x)'
    z = transposed(times_skew(transposed(moved), d))
    return moved, sub9(sub9(C, y), z)


@fused_kernel
def sub9(M, N):
    """Return M - N."""
    return (
        M[0] - N[0], M[1] - N[1], M[2] - N[2], M[3] - N[3], M[4] - N[4], M[5] - N[5], M[6] - N[6], M[7] - N[7],
        M[8] - N[8],
    )  # fmt: skip


@fused_kernel
def moved_load(p, d):
    """Return a load (force, moment) about a point at -d."""
    return p[0], add(p[1], cross(d, p[0]))


@fused_kernel
def moved_motion(a, d):
    """Return an acceleration (linear, angular) of a point at d."""
    return add(a[0], cross(a[1], d)), a[1]
