"""Custom forces: a function of the user's, called through its address, so that no kernel is compiled anew for it.

Kernels are compiled without numba's reference counts and take no function objects; what they can take is a number.
`call` turns it back into the C function ``(t, poses, k, z, states, numbers, n, wrench, z_dot)`` that custom.py makes
of the user's function. With the compiler switched off the address is that function itself.
"""

import numba
import numpy as np
from llvmlite import ir
from numba.core import types
from numba.extending import intrinsic

from .jit import inner_kernel
from .layout import MOST_BODIES
from .vectors import add, add6, arm, clear, cross, dot, mat, pair, point, point_velocity, put, sub, vec

RETURNED = 6 * MOST_BODIES  # place in Data.wrench that the wrapper sets to 0 when the function has returned


def pointer_call(typingctx, address, t, poses, k, z, states, numbers, n, wrench, z_dot):
    """Code of a call to the C function at an address; arrays go as pointers to their first entry."""

    def generate(context, builder, signature, values):
        passed = [
            context.make_array(kind)(context, builder, value).data if isinstance(kind, types.Array) else value
            for kind, value in zip(signature.args[1:], values[1:], strict=True)
        ]
        function = ir.FunctionType(ir.VoidType(), [value.type for value in passed])
        builder.call(builder.inttoptr(values[0], function.as_pointer()), passed)
        return context.get_dummy_value()

    return types.void(address, t, poses, k, z, states, numbers, n, wrench, z_dot), generate


def plain_call(function, t, poses, k, z, states, numbers, n, wrench, z_dot):
    """The same without the compiler."""
    function(t, poses, k, z, states, numbers, n, wrench, z_dot)


call = plain_call if numba.config.DISABLE_JIT else intrinsic(pointer_call)


@inner_kernel
def place(body, pose, s):
    """Fill what the function reads of the point of a body at O + s."""
    R = mat(body.R)
    put(pose.r, point(body, s))
    put(pose.velocity, point_velocity(body, s))
    put(pose.w, vec(body.w))
    for i in range(3):
        for j in range(3):
            pose.R[i, j] = R[3 * i + j]


@inner_kernel
def custom(m, d, p, out, t):
    """Loads of a custom force at its points; a function that is missing or does not return leaves the power NaN."""
    for i in range(p.bodies):
        place(d.body[p.body[i]], d.pose[i], arm(d.body[p.body[i]], p.point[i]))
    clear(d.wrench)
    d.wrench[RETURNED] = np.nan
    z, z_dot = d.z[p.state : p.state + p.states], d.state_rate[p.state : p.state + p.states]
    clear(z_dot)
    address = p.address[1] if np.iscomplexobj(d.wrench) else p.address[0]
    if address != 0:
        numbers = m.number[p.number : p.number + p.numbers]
        call(address, t, d.pose, p.bodies, z, p.states, numbers, p.numbers, d.wrench, z_dot)
    out.power = d.wrench[RETURNED]
    for i in range(p.bodies):
        body, pose = d.body[p.body[i]], d.pose[i]
        force, moment = pair(d.wrench[6 * i : 6 * i + 6])
        out.power += dot(force, vec(pose.velocity)) + dot(moment, vec(pose.w))
        add6(body.Q, force, add(moment, cross(sub(vec(pose.r), vec(body.r)), force)))
