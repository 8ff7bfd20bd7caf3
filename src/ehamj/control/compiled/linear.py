"""Products of matrices that come flat and transposed, compiled."""

from ehamj.compiled import kernel


@kernel
def add_product(matrix_t, vector, result):  # type: ignore[no-untyped-def]
    """result += matrix·vector, for the flat transposed matrix.

    Whole columns are added, one after the other, which vectorises without changing a rounding; four at a time, so that
    the result is loaded and stored a quarter as often.
    """
    size, columns = result.size, vector.size
    whole = columns - columns % 4
    for k in range(0, whole, 4):
        a, b, c, d = vector[k], vector[k + 1], vector[k + 2], vector[k + 3]
        first = matrix_t[k * size : (k + 1) * size]
        second = matrix_t[(k + 1) * size : (k + 2) * size]
        third = matrix_t[(k + 2) * size : (k + 3) * size]
        fourth = matrix_t[(k + 3) * size : (k + 4) * size]
        for i in range(size):
            result[i] = (((result[i] + first[i] * a) + second[i] * b) + third[i] * c) + fourth[i] * d
    for k in range(whole, columns):
        factor = vector[k]
        column = matrix_t[k * size : (k + 1) * size]
        for i in range(size):
            result[i] += column[i] * factor


@kernel
def wanted(Ct, Dt, state, measured, result):  # type: ignore[no-untyped-def]
    """y = C x + D u."""
    result[:] = 0.0
    add_product(Ct, state, result)
    add_product(Dt, measured, result)


@kernel
def advance_states(At, Bt, state, measured, scratch):  # type: ignore[no-untyped-def]
    """x⁺ = A x + B u; ``scratch`` is as long as the state."""
    scratch[:] = 0.0
    add_product(At, state, scratch)
    add_product(Bt, measured, scratch)
    state[:] = scratch
