"""Memory of lanes: flat arrays in which the lane is last, so that the compiler does one thing to all of them at once.

The width, how many lanes there are, is a constant for the compiler: kernels take it as a tuple ``lanes`` of so many
numbers.
"""

from collections.abc import Iterable
from typing import Any, Final

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from ehamj.arrays import Array
from ehamj.compiled import kernel
from ehamj.memory import DOUBLE

WIDTHS: Final = (1, 8)
"""Widths that are compiled: a simulation alone, and many."""


def lanes_of(width: int) -> tuple[float, ...]:
    """The tuple that tells kernels a width."""
    return (0.0,) * width


def stacked(parts: Iterable[Any]) -> Array:
    """Arrays of equal shape, one per lane, as one flat array with the lane last."""
    return np.ascontiguousarray(np.stack([np.asarray(part, np.float64) for part in parts], axis=-1)).ravel()


def lane(flat: Array, shape: tuple[int, ...], width: int, number: int | slice) -> Array:
    """One lane of a flat array, or some, as a view."""
    return flat.reshape(*shape, width)[..., number]


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


@intrinsic
def add_products(
    typing_context: Any, result: Any, r: Any, a: Any, f: Any, b: Any, v: Any, strides: Any, count: Any, lanes: Any
) -> Any:
    """result[r] += Σ a[f + k·strides[0]]·b[v + k·strides[1]] over ``count`` terms in their order, in all lanes.

    Each product and each sum is rounded.
    """
    width = len(lanes)

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        target = _vector(context, builder, signature.args[0], arguments[0], arguments[1], width)
        total = cgutils.alloca_once_value(builder, builder.load(target, align=DOUBLE))
        strides = cgutils.unpack_tuple(builder, arguments[6])
        with cgutils.for_range(builder, arguments[7]) as loop:
            factors = []
            for which, stride in zip((2, 4), strides, strict=True):
                place = builder.add(arguments[which + 1], builder.mul(loop.index, stride))
                at = _vector(context, builder, signature.args[which], arguments[which], place, width)
                factors.append(builder.load(at, align=DOUBLE))
            builder.store(builder.fadd(builder.load(total), builder.fmul(*factors)), total)
        builder.store(builder.load(total), target, align=DOUBLE)
        return context.get_dummy_value()

    place = types.intp
    return types.void(result, place, a, place, b, place, types.UniTuple(place, 2), place, lanes), codegen


@kernel
def copy_lanes(source, s, result, r, count):  # type: ignore[no-untyped-def]
    """result[r:] = source[s:], so many numbers."""
    for k in range(count):
        poke(result, r + k, peek(source, s + k))
