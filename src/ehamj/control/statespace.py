"""C (p − A)⁻¹ B + D: what a linear system answers at points of the complex plane."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


def response(points: ComplexArray, A: Array, B: Array, C: Array, D: Array | None = None) -> ComplexArray:
    """C (p − A)⁻¹ B + D at each point p, s = jω or z = e^{jωT}, shape (points, outputs, inputs); D without: zero."""
    outputs, inputs = C.shape[0], B.shape[1]
    found = np.zeros((points.size, outputs, inputs), complex)
    if D is not None:
        found += D
    # Laws are made of many small blocks that do not know each other: solved one by one, far faster than together.
    count, labels = connected_components(A != 0.0, directed=False) if A.size else (0, np.zeros(0))
    for own in (np.flatnonzero(labels == k) for k in range(count)):
        systems = points[:, None, None] * np.eye(own.size) - A[np.ix_(own, own)]
        found += C[:, own] @ np.linalg.solve(systems, np.broadcast_to(B[own], (points.size, own.size, inputs)))
    return found
