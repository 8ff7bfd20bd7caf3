"""Memory of lanes as Python fills and reads it; see `ehamj.compiled.lanes`."""

from collections.abc import Iterable
from typing import Any, Final

import numpy as np

from ehamj.arrays import Array

WIDTHS: Final = (1, 8)
"""Widths that are compiled: a simulation alone, and many."""


def lanes_of(width: int) -> tuple[float, ...]:
    """The tuple that tells kernels a width."""
    return (0.0,) * width


def stacked(parts: Iterable[Any]) -> Array:
    """Arrays of equal shape, one per lane, as one flat array with the lane last."""
    return np.ascontiguousarray(np.stack([np.asarray(part, np.float64) for part in parts], axis=-1)).ravel()


def lane(flat: Array, shape: tuple[int, ...], width: int, number: int | slice) -> Array:
    """One lane of a flat array, or some, as a view."""
    return flat.reshape(*shape, width)[..., number]
