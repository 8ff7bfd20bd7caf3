"""Flat arrays with a lane for each of some machines, the lane last: one operation of the compiler does all lanes.

The width, how many lanes there are, is a constant for the compiler: kernels take it as a tuple ``lanes`` of so many
numbers. Entry i of a lane is at ``i * len(lanes) + lane``; a place is i.
"""

from typing import Any, Final

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from ehamj.compiled import kernel

DOUBLE: Final = 8
"""Bytes of a number."""


def _place(context: Any, builder: Any, kind: Any, array: Any, index: Any) -> Any:
    data = context.make_array(kind)(context, builder, array).data
    return cgutils.gep_inbounds(builder, data, index)


@intrinsic
def peek(typing_context: Any, array: Any, index: Any) -> Any:
    """The number at an index of a flat array.

    Unlike ``array[index]`` without a case for negative ones, which keeps the compiler from seeing what lies where.
    """

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.load(_place(context, builder, signature.args[0], *arguments))

    return array.dtype(array, types.intp), codegen


@intrinsic
def poke(typing_context: Any, array: Any, index: Any, value: Any) -> Any:
    """Write a number at an index of a flat array."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        builder.store(arguments[2], _place(context, builder, signature.args[0], *arguments[:2]))
        return context.get_dummy_value()

    return types.void(array, types.intp, array.dtype), codegen


def _vector(context: Any, builder: Any, kind: Any, array: Any, place: Any, width: int) -> Any:
    """Address of the numbers of all lanes at a place."""
    index = builder.mul(place, place.type(width))
    data = _place(context, builder, kind, array, index)
    return builder.bitcast(data, ir.PointerType(ir.VectorType(ir.DoubleType(), width)))


def _sum(context: Any, builder: Any, signature: Any, arguments: Any, places: Any) -> Any:
    """Add to the result's place the products of the numbers at both ``places`` of each term, each rounded."""
    width = len(signature.args[-1])

    def load(which: int, place: Any) -> Any:
        at = _vector(context, builder, signature.args[which], arguments[which], place, width)
        return builder.load(at, align=DOUBLE)

    target = _vector(context, builder, signature.args[0], arguments[0], arguments[1], width)
    total = cgutils.alloca_once_value(builder, builder.load(target, align=DOUBLE))
    with cgutils.for_range(builder, arguments[7]) as loop:
        product = builder.fmul(*map(load, (2, 4), places(loop.index)))
        builder.store(builder.fadd(builder.load(total), product), total)
    builder.store(builder.load(total), target, align=DOUBLE)
    return context.get_dummy_value()


@intrinsic
def add_products(
    typing_context: Any, result: Any, r: Any, a: Any, f: Any, b: Any, v: Any, strides: Any, count: Any, lanes: Any
) -> Any:
    """result[r] += Σ a[f + k·strides[0]]·b[v + k·strides[1]] over ``count`` terms in their order, in all lanes."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        over, by = cgutils.unpack_tuple(builder, arguments[6])

        def places(k: Any) -> Any:
            return builder.add(arguments[3], builder.mul(k, over)), builder.add(arguments[5], builder.mul(k, by))

        return _sum(context, builder, signature, arguments, places)

    place = types.intp
    return types.void(result, place, a, place, b, place, types.UniTuple(place, 2), place, lanes), codegen


@intrinsic
def add_indexed(
    typing_context: Any, result: Any, r: Any, a: Any, f: Any, b: Any, v: Any, columns: Any, count: Any, lanes: Any
) -> Any:
    """result[r] += Σ a[f + k]·b[v + columns[f + k]] over ``count`` terms in their order, in all lanes: a sparse row."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        def places(k: Any) -> Any:
            place = builder.add(arguments[3], k)
            column = builder.load(_place(context, builder, signature.args[6], arguments[6], place))
            return place, builder.add(arguments[5], column)

        return _sum(context, builder, signature, arguments, places)

    place = types.intp
    return types.void(result, place, a, place, b, place, columns, place, lanes), codegen


def _two(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    """Addresses of the result's numbers and of the other's, in all lanes."""
    width = len(signature.args[-1])
    return (_vector(context, builder, signature.args[k], arguments[k], arguments[k + 1], width) for k in (0, 2))


@intrinsic
def set_lanes(typing_context: Any, result: Any, r: Any, values: Any, v: Any, lanes: Any) -> Any:
    """result[r] = values[v] in all lanes."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        target, source = _two(context, builder, signature, arguments)
        builder.store(builder.load(source, align=DOUBLE), target, align=DOUBLE)
        return context.get_dummy_value()

    return types.void(result, types.intp, values, types.intp, lanes), codegen


@intrinsic
def add_lanes(typing_context: Any, result: Any, r: Any, values: Any, v: Any, lanes: Any) -> Any:
    """result[r] += values[v] in all lanes."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        target, source = _two(context, builder, signature, arguments)
        total = builder.fadd(builder.load(target, align=DOUBLE), builder.load(source, align=DOUBLE))
        builder.store(total, target, align=DOUBLE)
        return context.get_dummy_value()

    return types.void(result, types.intp, values, types.intp, lanes), codegen


@kernel
def copy_lanes(source, s, result, r, count):  # type: ignore[no-untyped-def]
    """result[r:] = source[s:], so many numbers; of a few `set_lanes` is faster."""
    for k in range(count):
        poke(result, r + k, peek(source, s + k))
