"""Sensors that are not where or as they are said to be: told by that a rigid machine moves in six ways only.

Readings of n > 6 sensors on a rigid body lie in six dimensions, whatever moves it. Where they do not, the sensor that
is turned round, or the two sensors or places that are exchanged, is the one with which they do.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Final

import numpy as np

from ehamj.arrays import Array, ComplexArray

OUTSIDE: Final = 0.03
"""Share of the readings' power that no rigid motion has, from which sensors are doubted."""
BETTER: Final = 0.2
"""What is left of that share where the mistake is found, at most."""
ALIKE: Final = 2.0
"""Other mistakes leave this many times as much, or are named beside it."""
MOST: Final = 64
"""Sensors of which exchanges are tried."""


def misplaced(names: Sequence[str], points: Array, directions: Array, readings: ComplexArray) -> str:
    """What is wrong with the sensors, in words; empty where nothing is, or they are too few to tell.

    Args:
        names: of sensors that measure translations (n,).
        points: where they are said to stand, from anywhere in the machine (n, 3) [m].
        directions: along which they are said to measure (n, 3).
        readings: of one kind of motion, (n, m), each column at some time, frequency or of some mode.
    """
    size = np.linalg.norm(readings, axis=0)
    if not size.any():
        return ""
    shares = readings[:, size > 0.0] / size[size > 0.0]
    power = (shares @ shares.conj().T).real
    now = _outside(points, directions, power)
    if now < OUTSIDE or len(names) > MOST:
        return ""
    found = sorted((_outside(*places, power), said) for said, places in _mistakes(names, points, directions))
    if not found or found[0][0] > BETTER * now:
        return ""
    likely = [said for left, said in found if left < ALIKE * found[0][0] + 1e-9]
    return f"{now:.0%} of the motion is none of a rigid machine, and {found[0][0]:.1%} if {', or '.join(likely[:3])}"


def _outside(points: Array, directions: Array, power: Array) -> float:
    """Share of the power outside what a rigid body does; 0 where every reading is one of its."""
    rows = np.concatenate([directions, np.cross(points, directions)], axis=1)
    left, sizes, _ = np.linalg.svd(rows, full_matrices=False)
    basis = left[:, sizes > 1e-9 * sizes[0]]
    if basis.shape[1] >= len(rows):
        return 0.0
    return float(1.0 - np.trace(basis.T @ power @ basis) / np.trace(power))


def _mistakes(names: Sequence[str], points: Array, directions: Array) -> Iterator[tuple[str, tuple[Array, Array]]]:
    """What may be wrong, in words, and how sensors would then stand."""
    for k, name in enumerate(names):
        turned = directions.copy()
        turned[k] *= -1.0
        yield f"{name} is the wrong way round (scale = -1)", (points, turned)
    for j, k in combinations(range(len(names)), 2):
        order = np.arange(len(names))
        order[[j, k]] = k, j
        yield f"{names[j]} and {names[k]} are exchanged", (points[order], directions[order])
    places = np.unique(np.round(points, 6), axis=0)
    at = [np.flatnonzero(np.abs(points - place).max(axis=1) < 1e-5) for place in places]
    for first, second in combinations(at, 2):
        if len(first) < 2 and len(second) < 2:
            continue
        moved = points.copy()
        moved[first], moved[second] = points[second[0]], points[first[0]]
        both = " and ".join(", ".join(names[int(k)] for k in group) for group in (first, second))
        yield f"the places of {both} are exchanged", (moved, directions)
