"""Responses of linear systems by elimination in decimal numbers of sixty digits."""

from decimal import Decimal, localcontext
from typing import Any

import numpy as np

DIGITS = 60

_decimals = np.frompyfunc(Decimal, 1, 1)


def exact_response(system: Any, point: complex) -> np.ndarray:
    """C (p − A)⁻¹ B + D of a system with these matrices, (outputs, inputs), rounded at the end alone."""
    n, inputs = system.A.shape[0], system.B.shape[1]
    with localcontext() as context:
        context.prec = DIGITS
        real, imag = (_decimals(part * np.eye(n)) for part in (point.real, point.imag))
        a = _decimals(system.A)
        rows = np.block([[real - a, -imag], [imag, real - a]])
        rows = np.hstack([rows, _decimals(np.vstack([system.B, np.zeros((n, inputs))]))])
        for k in range(2 * n):
            pivot = k + int(np.argmax([abs(value) for value in rows[k:, k]]))
            rows[[k, pivot]] = rows[[pivot, k]]
            below = k + 1 + np.flatnonzero(rows[k + 1 :, k] != 0)
            across = k + np.flatnonzero(rows[k, k:] != 0)
            factors = rows[below, k] / rows[k, k]
            rows[np.ix_(below, across)] -= factors[:, None] * rows[k, across]
        states = rows[:, 2 * n :]
        for k in range(2 * n - 1, -1, -1):
            later = k + 1 + np.flatnonzero(rows[k, k + 1 : 2 * n] != 0)
            states[k] = (
                (states[k] - rows[k, later] @ states[later]) / rows[k, k] if later.size else states[k] / rows[k, k]
            )
        c = _decimals(system.C)
        found = c @ states[:n] + _decimals(system.D), c @ states[n:]
        return np.asarray(found[0].astype(float) + 1j * found[1].astype(float))
