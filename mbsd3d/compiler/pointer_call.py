"""A call to a function of the user's through its address, so that no kernel is compiled anew for it.

Kernels are compiled without numba's reference counts and take no function objects; what they can take is a number.
`call` turns it back into the C function ``(t, poses, k, z, states, numbers, n, wrench, z_dot)`` that `CustomForce`
makes of the user's function. With the compiler switched off the address is that function itself.
"""

import numba
from numba import types
from numba.extending import intrinsic

from .numba_private import ir


def pointer_call(typingctx, address, t, poses, k, z, states, numbers, n, wrench, z_dot):
    """Generate a call to the C function at an address; arrays go as pointers to their first entry."""

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
    """Call the function without the compiler."""
    function(t, poses, k, z, states, numbers, n, wrench, z_dot)


call = plain_call if numba.config.DISABLE_JIT else intrinsic(pointer_call)
