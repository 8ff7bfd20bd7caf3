"""Linear blocks that laws are made of, and what turns continuous ones into sampled ones, which join in the same ways.

Filters are cascades of second-order sections: companion forms of poles from 0.02 Hz to 3 kHz together lose digits.
"""

from collections.abc import Sequence
from typing import NamedTuple, Self

import numpy as np
import scipy
from numpy.typing import ArrayLike

from ehamj.arrays import Array, ComplexArray

TWO_PI = 2.0 * np.pi


class Block(NamedTuple):
    """ẋ = A x + B u, y = C x + D u; with n states, p inputs, q outputs: A (n, n), B (n, p), C (q, n), D (q, p)."""

    A: Array
    B: Array
    C: Array
    D: Array

    @classmethod
    def gain(cls, matrix: ArrayLike) -> Self:
        """y = D u."""
        D = np.atleast_2d(np.asarray(matrix, float))
        return cls(np.zeros((0, 0)), np.zeros((0, D.shape[1])), np.zeros((D.shape[0], 0)), D)

    @classmethod
    def filter(cls, zeros: ArrayLike, poles: ArrayLike, gain: float) -> Self:
        """gain·Π(s − zeros)/Π(s − poles), at most as many zeros as poles; complex ones in pairs [rad/s]."""
        z, p = np.atleast_1d(np.asarray(zeros, complex)), np.atleast_1d(np.asarray(poles, complex))
        if z.size > p.size:
            raise ValueError(f"filter: {z.size} zeros and {p.size} poles; it must have at most as many zeros as poles")
        total, numerators = cls.gain([[1.0]]), _groups(z)
        for denominator in _groups(p):
            fits = next((k for k, group in enumerate(numerators) if group.size <= denominator.size), None)
            numerator = np.zeros(0) if fits is None else numerators.pop(fits)
            # Sections of gain one near their corner keep all states of the size of the signal.
            size = float(np.abs(denominator).max() or 1.0) ** (denominator.size - numerator.size)
            total = total.then(
                cls._section(size * np.poly(numerator).real, np.asarray(np.poly(denominator).real, float))
            )
            gain /= size
        return total.then(cls.gain([[gain]]))

    @classmethod
    def _section(cls, numerator: ArrayLike, denominator: Array) -> Self:
        """A section of first or second order, states of the size of the signal."""
        b, a = np.atleast_1d(np.asarray(numerator, float)), denominator
        order = a.size - 1
        corner = float(np.abs(np.roots(a)).max()) or 1.0
        b = np.concatenate([np.zeros(a.size - b.size), b]) / corner**order  # in units of the corner
        b, a = b * corner ** np.arange(order, -1.0, -1.0), a / corner ** np.arange(order + 1.0)
        D = b[0]
        C = (b - D * a)[1:][::-1]
        A = np.zeros((order, order))
        A[:-1, 1:] = np.eye(order - 1)
        A[-1] = -a[:0:-1]
        B = np.zeros((order, 1))
        B[-1] = 1.0
        return cls(corner * A, corner * B, C[None, :], np.array([[D]]))

    def then(self, after: "Block") -> Self:
        """``after`` behind this block."""
        A = np.block([[self.A, np.zeros((self.A.shape[0], after.A.shape[0]))], [after.B @ self.C, after.A]])
        B, D = np.vstack([self.B, after.B @ self.D]), after.D @ self.D
        return type(self)(A, B, np.hstack([after.D @ self.C, after.C]), D)

    def times(self, factor: float) -> Self:
        """The block with another gain."""
        return type(self)(self.A, self.B, factor * self.C, factor * self.D)

    def between(self, before: ArrayLike, after: ArrayLike) -> Self:
        """The block between two matrices: after·block·before."""
        first, last = np.asarray(before, float), np.asarray(after, float)
        return type(self)(self.A, self.B @ first, last @ self.C, last @ self.D @ first)

    def padded(self, before: int, after: int) -> Self:
        """The block with inputs beside its own that it does not read."""
        return self.inserted(self.B.shape[1], after).inserted(0, before)

    def inserted(self, at: int, count: int) -> Self:
        """The block with ``count`` inputs that it does not read between its own, before number ``at``."""
        B, D = (np.insert(matrix, [at] * count, 0.0, axis=1) for matrix in (self.B, self.D))
        return type(self)(self.A, B, self.C, D)

    def held(self, period: float) -> Self:
        """The block from input that is held over each ``period`` [s], exact; strictly proper ones stay so."""
        n, p = self.A.shape[0], self.B.shape[1]
        power = scipy.linalg.expm(period * np.block([[self.A, self.B], [np.zeros((p, n + p))]]))
        return type(self)(power[:n, :n], power[:n, n:], self.C, self.D)

    def sampled(self, period: float) -> Self:
        """The block at a sampling ``period`` [s] by the trapezoidal rule (Tustin)."""
        n = self.A.shape[0]
        solve = np.linalg.inv(np.eye(n) - 0.5 * period * self.A)
        A = solve @ (np.eye(n) + 0.5 * period * self.A)
        B, C = solve @ self.B * period, self.C @ solve
        return type(self)(A, B, C, self.D + 0.5 * self.C @ B)


def beside(blocks: Sequence[Block]) -> Block:
    """Blocks side by side, each with inputs and outputs of its own."""
    return Block(*(np.asarray(scipy.linalg.block_diag(*matrices)) for matrices in zip(*blocks, strict=True)))


def added(blocks: Sequence[Block]) -> Block:
    """The sum of blocks that share inputs and outputs."""
    A = np.asarray(scipy.linalg.block_diag(*(block.A for block in blocks)))
    B, C = np.vstack([block.B for block in blocks]), np.hstack([block.C for block in blocks])
    return Block(A, B, C, np.sum([block.D for block in blocks], axis=0))


def pair(frequency: float, damping: float) -> ComplexArray:
    """Roots of s² + 2ζωs + ω² for a ``frequency`` [Hz]."""
    omega = TWO_PI * frequency
    return np.asarray(np.roots([1.0, 2.0 * damping * omega, omega**2]), complex)


def response(points: ComplexArray, A: Array, B: Array, C: Array, D: Array | None = None) -> ComplexArray:
    """C (p − A)⁻¹ B + D at each point p, s = jω or z = e^{jωT}, shape (points, outputs, inputs); D without: zero."""
    outputs, inputs = C.shape[0], B.shape[1]
    found = np.zeros((points.size, outputs, inputs), complex)
    if D is not None:
        found += D
    # Laws are made of many small blocks that do not know each other: solved one by one, far faster than together.
    count, labels = scipy.sparse.csgraph.connected_components(A != 0.0, directed=False) if A.size else (0, np.zeros(0))
    for own in (np.flatnonzero(labels == k) for k in range(count)):
        systems = points[:, None, None] * np.eye(own.size) - A[np.ix_(own, own)]
        found += C[:, own] @ np.linalg.solve(systems, np.broadcast_to(B[own], (points.size, own.size, inputs)))
    return found


def _groups(roots: ComplexArray) -> list[ComplexArray]:
    """Roots in pairs, complex ones with their conjugates, real ones by size and the last alone; slow pairs first."""
    upper = sorted(roots[roots.imag > 1e-9 * np.abs(roots)], key=abs)
    real = sorted(roots[np.abs(roots.imag) <= 1e-9 * np.abs(roots)].real, key=abs)
    if 2 * len(upper) + len(real) != roots.size:
        raise ValueError("filter: complex zeros and poles must come with their conjugates")
    groups = [np.array([root, root.conjugate()]) for root in upper]
    groups += [np.array(real[k : k + 2], complex) for k in range(0, len(real), 2)]
    return sorted(groups, key=lambda group: (-group.size, float(np.abs(group).max())))


def joined(blocks: Sequence[Block]) -> Block:
    """Blocks with inputs of their own, one after the other, whose outputs add up."""
    together = beside(blocks)
    return Block(together.A, together.B, np.hstack([block.C for block in blocks]), np.hstack([b.D for b in blocks]))
