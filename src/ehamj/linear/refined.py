"""Frequency responses to all digits: C (p − A)⁻¹ B + D, solved, and refined with residuals in doubled precision.

Where a channel is weak beside those that it shares its states with (a sway that only gravity couples, an acceleration
far below the first mode), its value is a small difference of large terms: a direct solve leaves a few digits of it,
200 dB below the channel's largest none. Sums and products without error: Ogita, Rump and Oishi, "Accurate sum and dot
product", SIAM J. Sci. Comput. 26(6), 2005; refinement: Higham, Accuracy and Stability of Numerical Algorithms, ch. 12.
"""

from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import eig

from ehamj.arrays import Array, ComplexArray

NEUTRAL: Final = 1e-9
"""Distance of a point from a pole, over the largest pole's magnitude, below which it counts as that pole."""
ROUNDING: Final = 1e-12
"""Share of the sum of its parts below which a sum is zero."""
SINGULAR: Final = 1e14
"""Condition from which a pole is looked for."""
STEPS: Final = 3
"""Of refinement: each gains as many digits as the condition leaves, four or more."""
CHUNK: Final = 1 << 21
"""Numbers that are worked on together."""

_SPLIT: Final = 134217729.0  # 2^27 + 1

Doubled = tuple[Array, Array]
"""A value as its rounded part and what rounding took."""


def refined_response(points: ArrayLike, A: Array, B: Array, C: Array, D: Array) -> ComplexArray:
    """C (p − A)⁻¹ B + D at each point p, s = jω or z = e^{jωT}, shape (points, outputs, inputs).

    At a pole, channels that neither show it nor are driven through it have their finite value; the others are inf + nan
    j, as in python-control.
    """
    p = np.atleast_1d(np.asarray(points, complex))
    found = np.empty((p.size, C.shape[0], B.shape[1]), complex)
    size = max(1, CHUNK // max(1, (A.shape[0] + C.shape[0]) * 2 * B.shape[1] + A.size))
    for at in range(0, p.size, size):
        found[at : at + size] = _responses(p[at : at + size], A, B, C, D)
    found[:, ~_joined(A, B, C, D)] = 0.0
    found.imag[p.imag == 0.0] = np.where(np.isfinite(found.real[p.imag == 0.0]), 0.0, np.nan)
    return found


def _joined(A: Array, B: Array, C: Array, D: Array) -> NDArray[np.bool_]:
    """Whether anything leads from an input to an output, (outputs, inputs)."""
    ways = (A != 0.0) | np.eye(len(A), dtype=bool)
    for _ in range(max(1, len(A)).bit_length()):
        ways = ways @ ways
    return np.asarray((C != 0.0) @ ways @ (B != 0.0) | (D != 0.0), bool)


def _responses(points: ComplexArray, A: Array, B: Array, C: Array, D: Array) -> ComplexArray:
    systems = points[:, None, None] * np.eye(A.shape[0]) - A
    try:
        inverse = np.linalg.inv(systems)
        condition = np.linalg.norm(systems, 1, axis=(1, 2)) * np.linalg.norm(inverse, 1, axis=(1, 2))
    except np.linalg.LinAlgError:  # at a pole to the last digit
        apart = [_at_pole(point, A, B, C, D) for point in points] if points.size == 1 else [
            _responses(point, A, B, C, D)[0] for point in points[:, None]
        ]  # fmt: skip
        return np.array(apart)
    states = _solved(points, np.asarray(inverse, complex), A, B)
    high, low = _product(C, states[0])
    high, error = _sum(high, _interleaved(D))
    found = _complex(high + (low + error + C @ states[1]))
    for k in np.flatnonzero(~(condition < SINGULAR)):
        found[k] = _at_pole(points[k], A, B, C, D)
    return found


def _solved(points: ComplexArray, inverse: ComplexArray, A: Array, B: Array) -> Doubled:
    """(p − A)⁻¹ B in doubled precision, columns of real and imaginary parts in turn (points, states, 2·inputs)."""
    high, right = _parts(inverse @ B), _interleaved(B)
    low = np.zeros_like(high)
    for _ in range(STEPS):
        total, rest = _product(A, high)
        rest = rest + A @ low
        for term in (right, *_turned(points, high)):
            total, error = _sum(total, term)
            rest = rest + error
        rest = rest + sum(_turned(points, low)[::2])
        low = low + _parts(inverse @ _complex(total + rest))
        high, low = _sum(high, low)
    return high, low


def _turned(points: ComplexArray, x: Array) -> tuple[Array, ...]:
    """−p x as four terms without error: both products, each with what rounding took."""
    real, imag = (part[:, None, None] for part in (points.real, points.imag))
    cross = np.empty_like(x)
    cross[..., 0::2], cross[..., 1::2] = x[..., 1::2], -x[..., 0::2]
    return (*_times(-real, x), *_times(imag, cross))


def _product(matrix: Array, x: Array) -> Doubled:
    """matrix (n, k) times x (points, k, m) in doubled precision."""
    shape = (x.shape[0], matrix.shape[0], x.shape[2])
    high, low = np.zeros(shape), np.zeros(shape)
    for k in range(matrix.shape[1]):
        rows = np.flatnonzero(matrix[:, k])
        product, rest = _times(matrix[rows, k, None], x[:, k, None, :])
        high[:, rows], error = _sum(high[:, rows], product)
        low[:, rows] += error + rest
    return high, low


def _sum(a: Array, b: Array) -> Doubled:
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


def _times(a: Array, b: Array) -> Doubled:
    product = a * b
    (a1, a2), (b1, b2) = _halves(a), _halves(b)
    return product, a2 * b2 - (((product - a1 * b1) - a2 * b1) - a1 * b2)


def _halves(a: Array) -> Doubled:
    wide = _SPLIT * a
    upper = wide - (wide - a)
    return upper, a - upper


def _parts(x: ComplexArray) -> Array:
    return np.ascontiguousarray(x).view(float)


def _complex(x: Array) -> ComplexArray:
    return np.ascontiguousarray(x).view(complex)


def _interleaved(matrix: Array) -> Array:
    """A real matrix with its imaginary parts, zero, between its columns."""
    return _parts(matrix.astype(complex))


def _at_pole(point: complex, A: Array, B: Array, C: Array, D: Array) -> ComplexArray:
    """The response at a pole: of all other modes where the pole is not seen; its part is taken out by its projector."""
    values, left, right = eig(A, left=True)
    size = max(1.0, float(np.abs(values).max()))
    own = np.abs(values - point) <= NEUTRAL * size
    never = np.full((C.shape[0], B.shape[1]), complex(np.inf, np.nan))
    pairing = left[:, own].conj().T @ right[:, own]
    if not own.any() or np.linalg.cond(pairing) > 1.0 / NEUTRAL:
        return never
    projector = right[:, own] @ np.linalg.solve(pairing, left[:, own].conj().T)
    states = np.linalg.solve(point * np.eye(len(A)) - A + size * projector, B - projector @ B)
    found = C @ (states - projector @ states) + D
    seen = np.abs(C @ right[:, own]) > ROUNDING * (np.abs(C) @ np.abs(right[:, own]))
    reached = np.abs(left[:, own].conj().T @ B) > ROUNDING * (np.abs(left[:, own].T) @ np.abs(B))
    return np.where(seen.any(axis=1)[:, None] & reached.any(axis=0), never, found)
