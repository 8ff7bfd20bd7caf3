"""Lines that laws follow made ready for the stepping loop; see `ehamj.control.compiled.lines`."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ehamj.arrays import Array
from ehamj.control.compiled.lines import KEPT, Followed


def lines_of(parts: Sequence[Any], table: Any) -> tuple[NDArray[np.int64], Array, int, Array]:
    """What compiled code takes of lines that laws follow: `Laws.lines`, `Laws.followed`, how many numbers they keep,
    and the frequencies with which they begin [Hz].

    Args:
        parts: laws that run side by side.
        table: their rows, `ehamj.control.compiled.laws.LAW`.
    """
    places: list[tuple[int, int, int]] = []
    rows, frequencies, kept = [], [], 0
    for part, row in zip(parts, table, strict=False):
        for line in part.lines:
            places.append((int(row["states_at"]) + line.first, line.pairs, kept))
            kept += 1 + KEPT * line.pairs
            own, nominal = part.A[line.first :, line.first], line.nominal(part.A, part.period)
            rows.append(
                Followed(
                    real=float(own[0]),
                    imaginary=float(own[1]),
                    undamped=1.0 / math.hypot(own[0], own[1]),
                    nominal=nominal,
                    low=min(line.low, nominal),
                    high=max(line.high, nominal),
                    half=math.pi * part.period,
                    lag=-math.expm1(-part.period / line.time),
                    period=math.ceil(1.0 / (nominal * part.period)),
                    step=part.period / (2.0 * math.pi * line.time * line.pace),
                )
            )
            frequencies.append(nominal)
    return np.array(places, np.int64).ravel(), np.array(rows, float).ravel(), kept, np.array(frequencies, float)
