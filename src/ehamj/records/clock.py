"""Times of samples: their rate, their places on a uniform grid, and gaps."""

import numpy as np

from ehamj.records.choices import GapChoice
from ehamj.signals import Array

JITTER = 1e-3
"""How far a time may lie from a uniform grid, in steps."""


def clock(time: Array, name: str, gaps: GapChoice) -> tuple[float, Array, list[str]]:
    """Rate [Hz] of samples at ``time`` [s], their places on the uniform grid, and remarks on gaps.

    Raises ValueError where times do not rise, lie off the grid, or leave gaps that may not be filled.
    """
    forward = np.diff(time)
    rising = (forward > 0) & np.isfinite(forward)
    if time.size < 2 or not rising.all():
        row = int(np.argmin(rising)) + 2 if time.size > 1 else 1
        raise ValueError(f"ground.file = {name!r}: time must rise from row to row; it does not at sample {row}")
    index = np.concatenate([[0.0], np.cumsum(np.maximum(1.0, np.round(forward / np.median(forward))))])
    step = (time[-1] - time[0]) / index[-1]
    worst = int(np.argmax(np.abs(time - time[0] - index * step)))
    jitter = abs(time[worst] - time[0] - index[worst] * step) / step
    if jitter > JITTER:
        raise ValueError(
            f"ground.file = {name!r}: sampling is not uniform: sample {worst + 1} is {jitter:.2g} steps "
            f"off its place, {JITTER:g} are allowed; resample it, or state its rate instead of the times"
        )
    missing = int(index[-1]) + 1 - time.size
    if not missing:
        return 1.0 / step, index, []
    holes = int(np.sum(np.diff(index) > 1))
    return 1.0 / step, index, [filled(name, holes, missing * step, time.size * step, gaps)]


def on_grid(index: Array, samples: Array) -> Array:
    """Samples (n,) at places ``index`` of a uniform grid, with straight lines over what is missing."""
    return np.interp(np.arange(int(index[-1]) + 1), index, samples)


def filled(name: str, holes: int, missing: float, recorded: float, gaps: GapChoice) -> str:
    """The remark on ``missing`` seconds in so many holes; raises ValueError where they may not be filled."""
    whole = f"{holes} gap{'s' if holes > 1 else ''}, {missing:.4g} s in total"
    if missing > recorded:
        raise ValueError(f"ground.file = {name!r} has {whole}, more than it holds ({recorded:.4g} s); cut it")
    if gaps == "error":
        raise ValueError(
            f'ground.file = {name!r} has {whole}; set ground.gaps = "interpolate" to fill with straight lines'
        )
    return f"record {name} has {whole}, filled with straight lines"
