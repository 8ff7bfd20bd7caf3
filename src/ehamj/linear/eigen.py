"""Eigenvalues with both sides' vectors, repeated ones handled, and their first-order change.

Right vectors v and left vectors w are biorthonormal, wᴴ v = 1 and 0 between different ones, so that a change dA moves
an eigenvalue by dλ = wᴴ dA v (e.g. Golub and Van Loan, Matrix Computations, section 7.2). Where an eigenvalue repeats,
the vectors are one basis of many; `separated` turns it to the one that separates given groups of states.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import LinAlgError, eig, eigh
from scipy.optimize import linear_sum_assignment

from ehamj.arrays import Array, ComplexArray

REPEATED = 1e-6
"""Distance of two eigenvalues, over their magnitude, below which they count as one that repeats; the linear model is
good to 1e-9."""


@dataclass(frozen=True)
class Eigen:
    """Eigenvalues by magnitude (k,), right and left vectors in columns (n, k).

    Left vectors are NaN where an eigenvalue is defective. ``clusters`` are the places of equal eigenvalues, which stand
    as their mean; most hold one.
    """

    values: ComplexArray
    right: ComplexArray
    left: ComplexArray
    clusters: tuple[tuple[int, ...], ...]

    @classmethod
    def of(cls, matrix: Array) -> "Eigen":
        """Decompose a real square matrix."""
        values, left, right = eig(matrix, left=True)
        order = np.lexsort((values.imag, np.round(np.abs(values), 9)))
        values, left, right = values[order], left[:, order], right[:, order]
        clusters = _clusters(values)
        for cluster in clusters:
            own = list(cluster)
            values[own] = values[own].mean()
            left[:, own] = _paired(right[:, own], left[:, own])
        return cls(values, right, left, clusters)

    def with_basis(self, cluster: Sequence[int], change: ComplexArray) -> "Eigen":
        """The same with right vectors V·change in a cluster, and left ones that pair with them."""
        right, left, own = self.right.copy(), self.left.copy(), list(cluster)
        right[:, own] = right[:, own] @ change
        left[:, own] = _paired(right[:, own], left[:, own])
        return Eigen(self.values, right, left, self.clusters)


def _clusters(values: ComplexArray) -> tuple[tuple[int, ...], ...]:
    free = list(range(values.size))
    found = []
    while free:
        cluster = [free.pop(0)]
        for k in list(free):
            if min(abs(values[k] - values[j]) for j in cluster) <= REPEATED * abs(values[k]):
                cluster.append(k)
                free.remove(k)
        found.append(tuple(cluster))
    return tuple(found)


def _paired(right: ComplexArray, left: ComplexArray) -> ComplexArray:
    """Left vectors W with Wᴴ V = 1 in the span of the given ones; NaN where there are none (a defective eigenvalue)."""
    product = left.conj().T @ right
    if not np.isfinite(product).all() or np.linalg.cond(product) > 1e12:
        return np.full_like(left, np.nan)
    return np.asarray(left @ np.linalg.inv(product).conj().T)


def separated(vectors: ComplexArray, groups: Array) -> ComplexArray:
    """Change of basis (k, k) after which the columns of V·change differ most in the groups.

    Args:
        vectors: the parts of the eigenvectors that count, in comparable units, (n, k).
        groups: number of the group of each part, (n,); 0 ≤ number.

    Returns:
        The identity where the parts do not tell the vectors apart.
    """
    together = vectors.conj().T @ vectors
    apart = (vectors.conj().T * (1.0 + groups)) @ vectors
    try:
        return np.asarray(eigh(apart, together)[1])
    except LinAlgError:  # some combination has no such parts at all
        return np.eye(vectors.shape[1], dtype=complex)


def eigenvalue_changes(eigen: Eigen, chosen: Sequence[int], change: Array) -> ComplexArray:
    """First-order change of the chosen eigenvalues when the matrix changes by ``change`` (n, n).

    A repeated eigenvalue splits into the eigenvalues of Wᴴ dA V; each goes to the vector that it is nearest to.
    """
    found = np.full(len(chosen), np.nan, complex)
    places = {k: at for at, k in enumerate(chosen)}
    for cluster in eigen.clusters:
        wanted = [k for k in cluster if k in places]
        if not wanted:
            continue
        own = list(cluster)
        block = eigen.left[:, own].conj().T @ change @ eigen.right[:, own]
        if not np.isfinite(block).all():
            continue
        values, vectors = np.linalg.eig(block)
        rows, columns = linear_sum_assignment(-(np.abs(vectors) ** 2))
        for row, column in zip(rows, columns, strict=True):
            if own[row] in places:
                found[places[own[row]]] = values[column]
    return found


def mac(first: ComplexArray, second: ComplexArray, weights: ArrayLike | None = None) -> Array:
    """Modal assurance criterion |aᴴ W b|²/(aᴴ W a · bᴴ W b) between shapes in columns, (n, k) and (n, m) → (k, m).

    Args:
        first: shapes.
        second: shapes.
        weights: W (n, n) or its diagonal (n,): masses and inertias make parts of different units comparable.

    1 for the same shape whatever its scale and phase (Allemang 1983).
    """
    w = np.ones(first.shape[0]) if weights is None else np.asarray(weights, float)
    w = np.diag(w) if w.ndim == 1 else w
    cross = np.abs(first.conj().T @ w @ second) ** 2
    own, other = (np.einsum("nk,nm,mk->k", v.conj(), w, v).real for v in (first, second))
    return np.asarray(cross / np.maximum(np.outer(own, other), np.finfo(float).tiny))
