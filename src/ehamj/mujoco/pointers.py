"""Numba intrinsics: read a double or an array through a struct pointer, and call the engine by its addresses."""

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic


def _field(builder: Any, kind: Any, struct: Any, offset: Any) -> Any:
    """LLVM pointer to the ``kind`` that lies ``offset`` bytes into the struct at address ``struct``."""
    return builder.inttoptr(builder.add(struct, offset), ir.PointerType(kind))


@intrinsic
def doubles_at(typing_context: Any, struct: Any, offset: Any) -> Any:
    """The double* stored ``offset`` bytes into the struct at address ``struct``, for ``numba.carray``."""
    signature = types.CPointer(types.float64)(types.intp, types.intp)

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        pointer = ir.PointerType(ir.DoubleType())
        return builder.load(_field(builder, pointer, *arguments))

    return signature, codegen


@intrinsic
def address_at(typing_context: Any, struct: Any, offset: Any) -> Any:
    """The address stored ``offset`` bytes into the struct at address ``struct``."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.load(_field(builder, cgutils.intp_t, *arguments))

    return types.intp(types.intp, types.intp), codegen


@intrinsic
def pointer(typing_context: Any, address: Any) -> Any:
    """An address as a pointer, for ``numba.carray``."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.inttoptr(arguments[0], cgutils.voidptr_t)

    return types.voidptr(types.intp), codegen


@intrinsic
def load_double(typing_context: Any, struct: Any, offset: Any) -> Any:
    """The double stored ``offset`` bytes into the struct at address ``struct``."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.load(_field(builder, ir.DoubleType(), *arguments))

    return types.float64(types.intp, types.intp), codegen


@intrinsic
def store_double(typing_context: Any, struct: Any, offset: Any, value: Any) -> Any:
    """Write a double ``offset`` bytes into the struct at address ``struct``."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        struct, offset, value = arguments
        builder.store(value, _field(builder, ir.DoubleType(), struct, offset))
        return context.get_dummy_value()

    return types.void(types.intp, types.intp, types.float64), codegen


@intrinsic
def call_on_state(typing_context: Any, function: Any, model: Any, data: Any) -> Any:
    """Call ``void function(mjModel*, mjData*)`` by its address."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        address, model, data = arguments
        kind = ir.FunctionType(ir.VoidType(), [cgutils.intp_t, cgutils.intp_t])
        builder.call(builder.inttoptr(address, ir.PointerType(kind)), [model, data])
        return context.get_dummy_value()

    return types.void(types.intp, types.intp, types.intp), codegen


@intrinsic
def call_runge_kutta(typing_context: Any, function: Any, model: Any, data: Any, order: Any) -> Any:
    """Call ``void function(mjModel*, mjData*, int)`` by its address."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        address, model, data, order = arguments
        integer = ir.IntType(32)
        kind = ir.FunctionType(ir.VoidType(), [cgutils.intp_t, cgutils.intp_t, integer])
        builder.call(builder.inttoptr(address, ir.PointerType(kind)), [model, data, order])
        return context.get_dummy_value()

    return types.void(types.intp, types.intp, types.intp, types.int32), codegen
