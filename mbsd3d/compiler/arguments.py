"""What goes to kernels as an address: model and work space, and functions of the user's.

numba passes a named tuple as the numbers in it, 170 for model, work space and tree, and again at every call: that was
half of the time of one body. A class with `by_reference` is taken apart once, where Python calls; kernels get the
address of what was found and load what they read. Tuples do not change, so loads may be moved and merged freely.

Kernels are compiled without numba's reference counts and take no function objects; what they can take is a number.
`call` turns it back into the C function ``(t, poses, k, z, states, numbers, n, wrench, z_dot)`` that `CustomForce`
makes of the user's function, so that no kernel is compiled anew for it. With the compiler switched off the address is
that function itself.
"""

from typing import TypeVar

import numba
from numba import types
from numba.extending import (
    NativeValue,
    infer_getattr,
    intrinsic,
    lower_getattr_generic,
    models,
    register_model,
    typeof_impl,
    unbox,
)

from .numba_private import AttributeTemplate, cgutils, impl_ret_borrowed, ir

Kind = TypeVar("Kind", bound=type)


class Reference(types.Type):
    """Type of a pointer to the numbers of a named tuple."""

    def __init__(self, fields: types.NamedTuple) -> None:
        self.fields = fields
        super().__init__(name=f"Reference({fields.name})")


@register_model(Reference)
class ReferenceModel(models.PrimitiveModel):
    """A pointer."""

    def __init__(self, manager, kind):
        super().__init__(manager, kind, manager.lookup(kind.fields).get_value_type().as_pointer())


def by_reference(cls: Kind) -> Kind:
    """Let kernels take named tuples of this class by their address."""

    @typeof_impl.register(cls)
    def type_of(value, context):
        fields = types.NamedTuple([typeof_impl(one, context) for one in value], cls)
        return Reference(fields)

    return cls


@unbox(Reference)
def take_apart(kind, value, c):
    """Put the numbers of a named tuple on the stack of the function that Python calls."""
    native = c.unbox(kind.fields, value)
    address = cgutils.alloca_once_value(c.builder, native.value)
    return NativeValue(address, is_error=native.is_error, cleanup=native.cleanup)


@infer_getattr
class ReferenceFields(AttributeTemplate):
    """Types of the fields."""

    key = Reference

    def generic_resolve(self, kind, name):
        """Return the type of a field, None if there is none of this name."""
        fields = kind.fields.fields
        return kind.fields.types[fields.index(name)] if name in fields else None


def load(builder, address, kind):
    """Generate code that loads a value number by number: whole structures would stay whole in all that is compiled."""
    if isinstance(kind, (ir.LiteralStructType, ir.ArrayType)):
        whole = ir.Constant(kind, ir.Undefined)
        parts = kind.elements if isinstance(kind, ir.LiteralStructType) else [kind.element] * kind.count
        for i, part in enumerate(parts):
            whole = builder.insert_value(whole, load(builder, cgutils.gep_inbounds(builder, address, 0, i), part), i)
        return whole
    number = builder.load(address)
    number.set_metadata("invariant.load", builder.module.add_metadata([]))
    return number


@lower_getattr_generic(Reference)
def field(context, builder, kind, value, name):
    """Load a field."""
    i = kind.fields.fields.index(name)
    address = cgutils.gep_inbounds(builder, value, 0, i)
    found = kind.fields.types[i]
    return impl_ret_borrowed(context, builder, found, load(builder, address, context.get_value_type(found)))


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
