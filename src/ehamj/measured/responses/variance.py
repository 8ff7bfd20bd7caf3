"""How well a response is known: from its coherence and averages, or as the user says."""

from typing import Final

import numpy as np

from ehamj.arrays import Array, ComplexArray

LEAST: Final = 1e-3
"""Deviation over the value at least [-]: what gains of channels are known to at best; a coherence that is rounded to 1
would say none."""


def variance(values: ComplexArray, coherence: Array, averages: float) -> tuple[Array, int]:
    """E|error|² of complex values (f,), and of how many it was raised to `LEAST`.

    Magnitude and phase have (1 − γ²)/(2γ² n) of the value's square each, so both have twice that (Bendat & Piersol,
    Random Data, 4th ed., 9.2).
    """
    with np.errstate(divide="ignore"):
        relative = (1.0 - coherence) / (coherence * averages)
    raised = relative < LEAST**2
    return np.abs(values) ** 2 * np.maximum(relative, LEAST**2), int(raised.sum())
