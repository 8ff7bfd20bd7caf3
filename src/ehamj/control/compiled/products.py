"""Matrices of laws times vectors, compiled: full ones by whole columns, those made of blocks row by row.

Arrays are flat, the lanes of a block of machines last: entry i of a lane is at ``i * len(lanes) + lane``.
"""

from ehamj.compiled import copy, kernel
from ehamj.compiled.lanes import add_indexed


@kernel
def add_product(matrix_t, vector, result, lanes):  # type: ignore[no-untyped-def]
    """result += matrix·vector, for the flat transposed matrix.

    Whole columns are added, one after the other, which vectorises without changing a rounding; four at a time, so that
    the result is loaded and stored a quarter as often.
    """
    width, size, columns = len(lanes), result.size, vector.size // len(lanes)
    whole = columns - columns % 4
    for k in range(0, whole, 4):
        first = matrix_t[k * size : (k + 1) * size]
        second = matrix_t[(k + 1) * size : (k + 2) * size]
        third = matrix_t[(k + 2) * size : (k + 3) * size]
        fourth = matrix_t[(k + 3) * size : (k + 4) * size]
        for lane in range(width):
            a, b = vector[k * width + lane], vector[(k + 1) * width + lane]
            c, d = vector[(k + 2) * width + lane], vector[(k + 3) * width + lane]
            for i in range(lane, size, width):
                result[i] = (((result[i] + first[i] * a) + second[i] * b) + third[i] * c) + fourth[i] * d
    for k in range(whole, columns):
        column = matrix_t[k * size : (k + 1) * size]
        for lane in range(width):
            factor = vector[k * width + lane]
            for i in range(lane, size, width):
                result[i] += column[i] * factor


@kernel
def wanted(Ct, Dt, state, measured, result, lanes):  # type: ignore[no-untyped-def]
    """y = C x + D u."""
    result[:] = 0.0
    add_product(Ct, state, result, lanes)
    add_product(Dt, measured, result, lanes)


@kernel
def advance_states(At, Bt, state, measured, scratch, lanes):  # type: ignore[no-untyped-def]
    """x⁺ = A x + B u; ``scratch`` is as long as the state."""
    scratch[:] = 0.0
    add_product(At, state, scratch, lanes)
    add_product(Bt, measured, scratch, lanes)
    copy(scratch, state)


@kernel
def add_rows(laws, at, vector, result, lanes):  # type: ignore[no-untyped-def]
    """result += matrix·vector, for a matrix whose rows begin at a place of ``laws.rows``; bits are those of
    `add_product`, which adds the zeros too."""
    rows, columns, matrices = laws.rows, laws.columns, laws.matrices  # once: looking into the tuple costs
    for i in range(result.size // len(lanes)):
        first = rows[at + i]
        add_indexed(result, i, matrices, first, vector, 0, columns, rows[at + i + 1] - first, lanes)
