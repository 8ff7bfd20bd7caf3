"""The response of a linear system in state space, continuous or sampled: the one C (s − A)⁻¹ B + D."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


def state_space_response(points: ComplexArray, A: Array, B: Array, C: Array, D: Array | None = None) -> ComplexArray:
    """C (s − A)⁻¹ B + D at each point, (point, output, input); D without: zero.

    Args:
        points: s = jω [1/s] of a continuous system, z = e^{jωT} of a sampled one, (point,).
        A: of the states, (n, n); none are allowed.
        B: of the inputs, (n, input).
        C: of the outputs, (output, n).
        D: of what passes at once, (output, input).
    """
    shape = (points.size, C.shape[0], B.shape[1])
    found = np.zeros(shape, complex) if D is None else np.broadcast_to(D, shape).astype(complex)
    # Laws are made of many small blocks that do not know each other: solved one by one, far faster than together.
    count, labels = connected_components(A != 0.0, directed=False) if A.size else (0, np.zeros(0))
    for own in (np.flatnonzero(labels == k) for k in range(count)):
        systems = points[:, None, None] * np.eye(own.size) - A[np.ix_(own, own)]
        right = np.broadcast_to(B[own], (points.size, own.size, B.shape[1]))
        found += C[:, own] @ np.linalg.solve(systems, right)
    return found
