"""What compiled code does with addresses: arrays that lie there, and C functions."""

from typing import Any

import numba
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from ehamj.compiled import kernel


@intrinsic
def _pointer(typing_context: Any, address: Any) -> Any:
    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.inttoptr(arguments[0], cgutils.voidptr_t)

    return types.voidptr(types.intp), codegen


@kernel
def view(address, n, dtype):  # type: ignore[no-untyped-def]
    """``n`` numbers or records that lie from an address on, as an array."""
    return numba.carray(_pointer(address), n, dtype)


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
