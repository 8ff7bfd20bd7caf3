"""What compiled code does with addresses: arrays that lie there, and C functions."""

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import make_array, populate_array


@intrinsic
def view(typing_context: Any, address: Any, n: Any, dtype: Any) -> Any:
    """``n`` numbers or records that lie from an address on, as an array; ``numba.carray`` takes a function for each."""
    kind = types.Array(dtype.dtype, 1, "C")

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        found = make_array(kind)(context, builder)
        size = context.get_constant(types.intp, context.get_abi_sizeof(context.get_data_type(kind.dtype)))
        data = builder.inttoptr(arguments[0], found.data.type)
        populate_array(found, data, (arguments[1],), (size,), size, None)
        return found._getvalue()

    return kind(types.intp, types.intp, dtype), codegen


def c_function(result: types.Type, *kinds: types.Type) -> Any:
    """A call, in compiled code, of C functions of this type: (address, tuple of arguments) → result."""

    @intrinsic
    def call(typing_context: Any, address: Any, arguments: Any) -> Any:
        def codegen(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            returned = ir.VoidType() if result is types.void else context.get_value_type(result)
            kind = ir.FunctionType(returned, [context.get_value_type(each) for each in kinds])
            function = builder.inttoptr(values[0], ir.PointerType(kind))
            found = builder.call(function, cgutils.unpack_tuple(builder, values[1]))
            return context.get_dummy_value() if result is types.void else found

        return result(types.intp, types.Tuple(kinds)), codegen

    return call
