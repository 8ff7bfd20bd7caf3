"""Call a Python law, as a C function, by its address."""

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic


@intrinsic
def call_law(typing_context: Any, function: Any, time: Any, measured: Any, limited: Any, wanted: Any) -> Any:
    """Call ``int function(double, double*, double*, double*)`` by its address."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        address, *values = arguments
        kind = ir.FunctionType(ir.IntType(32), [ir.DoubleType(), cgutils.intp_t, cgutils.intp_t, cgutils.intp_t])
        return builder.call(builder.inttoptr(address, ir.PointerType(kind)), values)

    signature = types.int32(types.intp, types.float64, types.intp, types.intp, types.intp)
    return signature, codegen
