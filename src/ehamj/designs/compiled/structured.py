"""µ of complex matrices for complex, diagonal changes, bounded above by scaling: inf σ(D M D⁻¹) over diagonal D > 0.

As SLICOT AB13MD does, which is the oracle. log σ is convex over log D (Sezginer and Overton, "The largest singular
value of e^X A e^−X is convex on convex sets of commuting matrices", IEEE Trans. Automatic Control 35(2), 1990); where
the largest singular values are close to each other, their smooth maximum is minimised, ever sharper.
"""

import math

import numpy as np

from ehamj.compiled import kernel
from ehamj.designs.compiled.machine import size_of

SHARP = (0.03, 0.003, 0.0003)
"""Widths of the smooth maximum of ln σ², one after the other; µ errs by ln(n)/2 of the last at most, relative."""
STEPS = 100
"""Of the search at each width, at most."""
SETTLED = 1e-5
"""Slope [-] at which it ends."""
NEARLY = 1e-5
"""Share by which a frequency must promise more than the best, to be looked at."""
SWEEPS = 30
TINY = 1e-300


@kernel
def eigen_of(matrix, vectors):  # type: ignore[no-untyped-def]
    """Diagonalise a Hermitian matrix (n, n) in place by Jacobi's rotations; eigenvectors into the columns of
    ``vectors``."""
    n = matrix.shape[0]
    for row in range(n):
        for column in range(n):
            vectors[row, column] = 1.0 if row == column else 0.0
    for _ in range(SWEEPS):
        off = whole = 0.0
        for row in range(n):
            whole += matrix[row, row].real ** 2
            for column in range(row):
                off += size_of(matrix[row, column])
        if off <= 1e-26 * whole or whole == 0.0:
            return
        for p in range(n - 1):
            for q in range(p + 1, n):
                size = math.sqrt(size_of(matrix[p, q]))
                if size <= TINY:
                    continue
                phase = matrix[p, q] / size
                theta = 0.5 * (matrix[q, q].real - matrix[p, p].real) / size
                t = (1.0 if theta >= 0.0 else -1.0) / (abs(theta) + math.sqrt(theta * theta + 1.0))
                c = 1.0 / math.sqrt(t * t + 1.0)
                turned = t * c * phase
                back = turned.conjugate()
                for k in range(n):
                    one, two = matrix[k, p], matrix[k, q]
                    matrix[k, p], matrix[k, q] = c * one - back * two, turned * one + c * two
                    one, two = vectors[k, p], vectors[k, q]
                    vectors[k, p], vectors[k, q] = c * one - back * two, turned * one + c * two
                for k in range(n):
                    one, two = matrix[p, k], matrix[q, k]
                    matrix[p, k], matrix[q, k] = c * one - turned * two, back * one + c * two


@kernel
def square_of(matrix, scale, scaled, square):  # type: ignore[no-untyped-def]
    """X = D M D⁻¹ with ln D = ``scale`` (n,) into ``scaled``, and XᴴX into ``square``."""
    n = matrix.shape[0]
    for row in range(n):
        for column in range(n):
            scaled[row, column] = matrix[row, column] * math.exp(scale[row] - scale[column])
    for row in range(n):
        for column in range(row + 1):
            total = 0.0j
            for k in range(n):
                total += scaled[k, row].conjugate() * scaled[k, column]
            square[row, column] = total
            square[column, row] = total.conjugate()


@kernel
def largest_of(square):  # type: ignore[no-untyped-def]
    """Largest of a diagonal."""
    most = 0.0
    for k in range(square.shape[0]):
        most = max(most, square[k, k].real)
    return most


@kernel
def smooth(matrix, scale, width, slope, scaled, square, vectors):  # type: ignore[no-untyped-def]
    """Smooth maximum of ln σ²(D M D⁻¹), its ``slope`` over ln D (n,), and ln of the largest σ²."""
    n = matrix.shape[0]
    square_of(matrix, scale, scaled, square)
    eigen_of(square, vectors)
    top = math.log(max(largest_of(square), TINY))
    total = 0.0
    slope[:] = 0.0
    for k in range(n):
        value = max(square[k, k].real, TINY)
        weight = math.exp((math.log(value) - top) / width)
        total += weight
        if weight > 1e-12:
            for row in range(n):
                moved = 0.0j
                for column in range(n):
                    moved += scaled[row, column] * vectors[column, k]
                slope[row] += 2.0 * weight * (size_of(moved) / value - size_of(vectors[row, k]))
    for row in range(n):
        slope[row] /= total
    return top + width * math.log(total), top


@kernel
def learn(inverse, slope, other, step, gained, share):  # type: ignore[no-untyped-def]
    """Broyden, Fletcher, Goldfarb and Shanno: what the slope gained over a ``share`` of the step, into the ``inverse``
    of the curvature."""
    n, curved, inner = step.size, 0.0, 0.0
    for row in range(n):
        step[row] *= share
        gained[row] = other[row] - slope[row]
        curved += step[row] * gained[row]
    if curved <= 1e-14:
        return
    for row in range(n):
        slope[row] = 0.0
        for column in range(n):
            slope[row] += inverse[row, column] * gained[column]
        inner += gained[row] * slope[row]
    for row in range(n):
        for column in range(n):
            inverse[row, column] += (1.0 + inner / curved) * step[row] * step[column] / curved
            inverse[row, column] -= (slope[row] * step[column] + step[row] * slope[column]) / curved


@kernel
def mu_of(matrix, scale, work, real):  # type: ignore[no-untyped-def]
    """µ of a matrix (n, n); ``scale`` (n,) is where the search for ln D begins, and ends.

    ``work`` (3, n, n) complex and ``real`` (n + 5, n) are for passing results.
    """
    n = matrix.shape[0]
    slope, trial, other, step, gained = real[n], real[n + 1], real[n + 2], real[n + 3], real[n + 4]
    best = math.inf
    for width in SHARP:
        for row in range(n):
            trial[row] = scale[row]
            for column in range(n):
                real[row, column] = 0.5 if row == column else 0.0
        value, downhill, share = math.inf, 0.0, 1.0
        for _ in range(STEPS):
            after, top = smooth(matrix, trial, width, other, work[0], work[1], work[2])
            if after > value + 1e-4 * share * downhill:  # too far: half of the way back
                share *= 0.5
                if share < 1e-9:
                    break
                for row in range(n):
                    trial[row] = scale[row] + share * step[row]
                continue
            best = min(best, top)
            if value < math.inf:
                learn(real, slope, other, step, gained, share)
            improved, value, most = value - after, after, 0.0
            for row in range(n):
                scale[row], slope[row] = trial[row], other[row]
                most = max(most, abs(slope[row]))
            if most < SETTLED or improved < 1e-9:
                break
            share, downhill = 1.0, 0.0
            for row in range(n):
                step[row] = 0.0
                for column in range(n):
                    step[row] -= real[row, column] * slope[column]
                downhill += step[row] * slope[row]
                trial[row] = scale[row] + step[row]
            if downhill >= 0.0:
                break
    return math.exp(0.5 * best)


@kernel
def highest_of(square, work):  # type: ignore[no-untyped-def]
    """Upper bound of the largest eigenvalue of a Hermitian, positive matrix, at most n^(1/64) too large: of its 64th
    power, the trace."""
    n, whole = square.shape[0], 0.0
    for row in range(n):
        whole += square[row, row].real
    if whole <= TINY:
        return 0.0
    one, two = work[0], work[2]
    for row in range(n):
        for column in range(n):
            one[row, column] = square[row, column] / whole
    for _ in range(5):
        for row in range(n):
            for column in range(row + 1):
                total = 0.0j
                for k in range(n):
                    total += one[row, k] * one[k, column]
                two[row, column] = total
                two[column, row] = total.conjugate()
        one, two = two, one
    trace = 0.0
    for row in range(n):
        for column in range(n):
            trace += size_of(one[row, column])
    return whole * trace ** (1.0 / 64.0)


@kernel
def bound_of(matrix, work):  # type: ignore[no-untyped-def]
    """Upper bound of σ by `highest_of`."""
    n, square = matrix.shape[0], work[1]
    for row in range(n):
        for column in range(row + 1):
            total = 0.0j
            for k in range(n):
                total += matrix[k, row].conjugate() * matrix[k, column]
            square[row, column] = total
            square[column, row] = total.conjugate()
    return math.sqrt(highest_of(square, work))


def largest_mus(matrices, counts, found):  # type: ignore[no-untyped-def]
    """Largest µ among the first ``counts`` of each design's matrices (design, f, n, n), into ``found`` (design,)."""
    n = matrices.shape[2]
    bounds, scale = np.empty(matrices.shape[1]), np.empty(n)
    work, real = np.empty((3, n, n), np.complex128), np.empty((n + 5, n))
    for design in range(matrices.shape[0]):
        count, best = counts[design], 0.0
        scale[:] = 0.0
        for k in range(count):
            bounds[k] = 0.0
            for row in range(n):
                best = max(best, math.sqrt(size_of(matrices[design, k, row, row])))
                for column in range(n):
                    bounds[k] += size_of(matrices[design, k, row, column])
            bounds[k] = math.sqrt(bounds[k])
        for k in range(count):
            if bounds[k] > best:
                bounds[k] = bound_of(matrices[design, k], work)
        while True:
            chosen, most = -1, best * (1.0 + NEARLY)
            for k in range(count):
                if bounds[k] > most:
                    chosen, most = k, bounds[k]
            if chosen < 0:
                break
            best = max(best, mu_of(matrices[design, chosen], scale, work, real))
            bounds[chosen] = 0.0
            for k in range(count):  # others are bounded closer by what scales this one best
                if bounds[k] > best * (1.0 + NEARLY):
                    square_of(matrices[design, k], scale, work[0], work[1])
                    bounds[k] = min(bounds[k], math.sqrt(highest_of(work[1], work)))
        found[design] = best
