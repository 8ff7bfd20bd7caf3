"""Times of samples: the even rate that explains them, their places on its grid, and gaps.

Times are rounded where they are printed: a clock of 3200 Hz that is printed to 0.1 ms wanders by a third of a step and
is even all the same. So the rate is sought that explains every time within its rounding: residuals t − k/f must spread
by no more than the resolution, which is convex in 1/f and leaves an interval of rates; the plainest number in it is
taken. A clock that no rate explains is believed as far as its digits carry, and its samples are resampled.
"""

from collections.abc import Callable

import numpy as np
import scipy

from ehamj.records.choices import GapChoice
from ehamj.signals import Array

JITTER = 1e-3
"""How far a time may lie from a uniform grid, in steps, beyond its rounding."""

WANDER = 0.25
"""How far a single step of a wandering clock may be from the mean one, in steps: beyond it, samples are missing."""

COARSE = 0.1
"""Resolution of times in steps up to which a wandering clock's are believed: rounding then adds noise 31 dB below a
sine at a tenth of the rate, and less below slower ones."""

UNSURE = 0.01
"""How far the rate may lie from the one that is taken, relative, for all that coarse times tell."""

HOLED = 0.02
"""Gaps per sample up to which they are believed to be some, where times are as coarse as steps."""

FEW = 2
"""Gaps that are believed to be some even where a slower clock, rounded, would explain the times without."""

ORDER = 5
"""Of the splines through the samples of a wandering clock: a sine loses 2e-6 of its amplitude at a tenth of the rate,
2.5e-4 at 0.2, and 6e-3 at 0.3 (measured on a clock that wanders by 2 %)."""


def sample_number(k: int) -> str:
    """What messages call sample ``k`` (from 0) of files without lines."""
    return f"sample {k + 1}"


def rounding(stored: np.ndarray) -> float:
    """What times are rounded to by the kind of number that they are stored in; 0 where that is nothing to speak of."""
    short = stored.dtype.kind == "f" and stored.dtype.itemsize < 8 and stored.size > 0
    return float(np.spacing(np.abs(stored).max())) if short else 0.0


def clock(
    time: Array,
    name: str,
    gaps: GapChoice,
    resolution: float = 0.0,
    stated: float | None = None,
    where: Callable[[int], str] = sample_number,
    remedy: str = "resample it, or state its rate instead of the times",
) -> tuple[float, Array, list[str]]:
    """Rate [Hz] of samples at ``time`` [s], their places on the uniform grid (n,), and remarks.

    Places are whole numbers, with gaps, but for a wandering clock, whose samples lie between those of the grid;
    `on_grid` puts samples there.

    Args:
        time: of each sample [s], shape (n,).
        name: the file's, for messages.
        gaps: what to do about them.
        resolution: to which times are rounded [s].
        stated: rate that the file states besides [Hz]; it is taken if it explains the times.
        where: what messages call the sample of a number.
        remedy: what a user may do about times that are not believed.

    Raises:
        ValueError: where times do not rise, are too coarse or too uneven to be believed, or leave gaps that may not be
            filled.
    """
    told = f"ground.file = {name!r}"
    if time.size < 2 or not np.isfinite(time).all():
        wrong = int(np.argmin(np.isfinite(time))) if time.size > 1 else 0
        raise ValueError(f"{told}: time must rise from row to row; it does not at {where(wrong)}")
    # Halves are rounded up or down, and digits that binary numbers cannot hold count as rounded, too.
    printed, resolution = resolution, 1.01 * resolution + 8.0 * float(np.spacing(np.abs(time).max()))
    index, steps = _grid(time, resolution, told, where, remedy)
    notes = _gap_notes(time, index, name, gaps, where)
    if steps is None:
        rate, note = _mean_rate(time, index, resolution, told, where, remedy)
        return rate, (time - time[0]) * rate, [f"record {name}: {note}", *notes]
    rate = _plain_rate(steps, stated)
    spread = float(np.ptp(time - index / rate))
    if steps[1] - steps[0] > 2.0 * UNSURE * steps[0] and spread * rate > JITTER:
        raise ValueError(
            f"{told}: {time.size} times that are rounded to {printed:.2g} s cannot tell the rate: it lies between "
            f"{1 / steps[1]:.4g} and {1 / steps[0]:.4g} Hz; {remedy}"
        )
    if spread * rate > 2.0 * JITTER:
        notes.insert(0, f"record {name}: times are rounded to {printed:.3g} s; {rate:.10g} Hz explains all of them")
    return rate, index, notes


def _grid(
    time: Array, resolution: float, told: str, where: Callable[[int], str], remedy: str
) -> tuple[Array, tuple[float, float] | None]:
    """Places of times on a grid, and between which steps [s] it explains them; None where no even one does.

    Times that lie on a grid are on it, even with a gap or two; else they may be rounded; else there are gaps.
    """
    every = np.arange(float(time.size))
    step = (time[-1] - time[0]) / every[-1]
    near = 2.0 * JITTER * step
    exact = explaining(time, every, min(resolution, near)) or explaining(time, every, near)
    if exact is not None:
        return every, exact
    even = explaining(time, every, resolution)
    if even is not None and not (np.diff(time) > 0).all():
        return every, even
    index = _places(time, resolution, told, where, remedy)
    step, holes = (time[-1] - time[0]) / index[-1], int(np.sum(np.diff(index) > 1))
    near = 2.0 * JITTER * step
    exact = explaining(time, index, min(resolution, near)) or explaining(time, index, near)
    if even is not None and (exact is None or holes > FEW):
        return every, even
    if resolution > 0.5 * step and (exact is None or holes > HOLED * time.size + FEW):
        raise ValueError(
            f"{told}: times are rounded to {resolution:.2g} s, of steps of {step:.2g} s, and no even rate explains all "
            f"of them: gaps cannot be placed; {remedy}"
        )
    return index, exact or explaining(time, index, resolution)


def explaining(time: Array, index: Array, tolerance: float) -> tuple[float, float] | None:
    """Least and largest step [s] of grids that ``time`` at places ``index`` keeps to within ``tolerance`` [s]."""
    middle = (time[-1] - time[0]) / index[-1]
    width = tolerance / index[-1]
    if middle <= width:
        return None
    residual = time - middle * index
    slope = width * index

    def over(aside: float) -> float:  # of the grid whose last place lies this many tolerances from the last time
        return float(np.ptp(residual - aside * slope)) / tolerance - 1.0

    best = 0.0
    if over(best) > 0.0:
        options = {"xatol": 1e-4}
        best = float(scipy.optimize.minimize_scalar(over, bounds=(-1.0, 1.0), method="bounded", options=options).x)
        if over(best) > 0.0:
            return None
    low, high = (end if over(end) <= 0.0 else scipy.optimize.brentq(over, best, end, xtol=1e-4) for end in (-1.0, 1.0))
    return middle + low * width, middle + high * width


def plainest(low: float, high: float) -> tuple[int, float]:
    """The number between two positive ones that is written with the fewest digits, and how many those are."""
    size = int(np.floor(np.log10(high)))
    for digits in range(1, 18):
        unit = 10.0 ** (size + 1 - digits)
        found = round(float(np.clip(np.round(0.5 * (low + high) / unit), np.ceil(low / unit), np.floor(high / unit))))
        value = float(f"{found}e{size + 1 - digits}")
        if low <= value <= high:
            return digits, value
    return 18, 0.5 * (low + high)


def _plain_rate(steps: tuple[float, float], stated: float | None) -> float:
    """The rate [Hz] of one of the steps [s] between two: the one stated, or a plain one, or that of a plain step."""
    if stated is not None and steps[0] <= 1.0 / stated <= steps[1]:
        return stated
    by_rate, by_step = plainest(1.0 / steps[1], 1.0 / steps[0]), plainest(*steps)
    return by_rate[1] if by_rate[0] <= by_step[0] else 1.0 / by_step[1]


def _places(time: Array, resolution: float, told: str, where: Callable[[int], str], remedy: str) -> Array:
    """Whole places of ``time`` on a grid with gaps; raises ValueError where times do not rise or are too coarse."""
    forward = np.diff(time)
    if not (forward > 0).all():
        row = int(np.argmin(forward > 0)) + 1
        coarse = "" if resolution < np.median(np.abs(forward)) else f" (rounded to {resolution:.2g} s)"
        raise ValueError(
            f"{told}: time must rise from row to row; it does not at {where(row)}{coarse}; {remedy}, or cut the file"
        )
    usual = forward < 1.5 * np.median(forward) + resolution
    step, index = float(forward[usual].mean()), np.empty(0)
    for _ in range(10):
        found = np.concatenate([[0.0], np.cumsum(np.maximum(1.0, np.round(forward / step)))])
        if np.array_equal(found, index):
            break
        index = found
        step = (time[-1] - time[0]) / index[-1]
    return index


def _mean_rate(
    time: Array, index: Array, resolution: float, told: str, where: Callable[[int], str], remedy: str
) -> tuple[float, str]:
    """A plain rate [Hz] near the mean one of a wandering clock, and the remark; ValueError if it is not believed."""
    step = (time[-1] - time[0]) / index[-1]
    aside = np.abs(np.diff(time) / np.diff(index) - step) / step
    worst = int(np.argmax(aside))
    if aside[worst] - resolution / step > WANDER:
        raise ValueError(
            f"{told}: sampling is not uniform: the step to {where(worst + 1)} is {aside[worst]:.2g} steps longer or "
            f"shorter than the mean one ({step:.4g} s); {WANDER:g} is believed of a wandering clock; {remedy}"
        )
    if resolution > COARSE * step:
        raise ValueError(
            f"{told}: sampling is not uniform, and times rounded to {resolution:.2g} s, of steps of {step:.4g} s, are "
            f"too coarse to tell how ({COARSE:g} of a step is allowed); {remedy}"
        )
    rate = plainest(0.999 / step, 1.001 / step)[1]
    off = float(np.abs(time - time[0] - index * step).max())
    return rate, (
        f"the clock wanders: times lie up to {off:.3g} s ({off / step:.2g} steps) from even spacing, single steps are "
        f"up to {100 * aside[worst]:.2g} % aside; resampled to {rate:.10g} Hz by splines"
    )


def _gap_notes(time: Array, index: Array, name: str, gaps: GapChoice, where: Callable[[int], str]) -> list[str]:
    """The remark on places that hold no sample, if there are such; raises ValueError where they may not be filled."""
    missing = index[-1] + 1 - index.size
    if missing < 1:
        return []
    step = (time[-1] - time[0]) / index[-1]
    jumps = np.flatnonzero(np.diff(index) > 1)
    first = f"the first before {where(int(jumps[0]) + 1)}"
    return [filled(name, jumps.size, missing * step, time.size * step, gaps, first)]


def on_grid(index: Array, samples: Array) -> Array:
    """Samples (n,) at places ``index`` of a uniform grid, from its place 0, with straight lines over what is missing.

    Places between those of the grid are those of a wandering clock: a spline leads through its samples. What is not
    finite stays so.
    """
    grid = np.arange(int(index[-1] + 1e-9) + 1)
    if np.array_equal(index, np.round(index)) or index.size <= ORDER or not np.isfinite(samples).all():
        return np.interp(grid, index, samples)
    # A spline would swing over a gap: points on the straight line hold it there.
    gap = np.flatnonzero(np.diff(index) > 1.5)
    extra = [np.arange(index[k] + 1.0, index[k + 1] - 0.5) for k in gap]
    places = np.sort(np.concatenate([index, *extra]))
    return scipy.interpolate.make_interp_spline(places, np.interp(places, index, samples), ORDER)(grid)


def filled(name: str, holes: int, missing: float, recorded: float, gaps: GapChoice, first: str = "") -> str:
    """The remark on ``missing`` seconds in so many holes; raises ValueError where they may not be filled."""
    whole = f"{holes} gap{'s' if holes > 1 else ''}, {missing:.4g} s in total"
    if missing > recorded:
        raise ValueError(f"ground.file = {name!r} has {whole}, more than it holds ({recorded:.4g} s); cut it")
    if gaps == "error":
        place = f" ({first})" if first else ""
        fill = 'set ground.gaps = "interpolate" to fill with straight lines'
        raise ValueError(f"ground.file = {name!r} has {whole}; {fill}{place}")
    return f"record {name} has {whole}, filled with straight lines"
