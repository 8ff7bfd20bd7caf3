"""Doubts about a record: what looks clipped, counted, in the wrong unit, or sampled too slowly, said in plain words."""

import numpy as np

from ehamj.estimate.bands import bands
from ehamj.records.channel import USABLE, Channel
from ehamj.records.units import GRAVITY
from ehamj.signals import Array

LOUDEST = 10e-3
"""RMS velocity above which no floor is believed [m/s]: workshops have 0.8 mm/s per third octave (IEST-RP-CC012), and
DIN 4150-3 lets foundations of industrial buildings see peaks of 20 mm/s for a moment."""

QUIETEST = 0.5e-9
"""RMS velocity below which no floor is believed [m/s]: Peterson's low noise model has 0.6 nm/s from 1 to 10 Hz."""

TOP_BAND = 80.0
"""Highest band of the generic vibration criteria [Hz]."""

CLIPPED_RUN = 3
"""Equal samples in a row at the extreme value that look like clipping."""

NEAR_ONE = 0.05
"""How near the mean of an acceleration must lie to gravity, relative, to be taken for it."""


def clipped_samples(samples: Array) -> int:
    """Samples that stand at the largest or smallest value several times in a row, which clipping looks like."""
    count = 0
    for extreme in {float(samples.max()), float(samples.min())}:
        if extreme == 0 or np.ptp(samples) == 0:
            continue
        edges = np.flatnonzero(np.diff(np.concatenate([[False], samples == extreme, [False]]).astype(int)))
        runs = edges[1::2] - edges[::2]
        count += int(runs[runs >= CLIPPED_RUN].sum())
    return count


def doubts(channel: Channel, velocity: Array, scale: float = 1.0) -> list[str]:
    """What speaks against a channel as it is used, scaled.

    A speed that no floor has is doubted where no floor has it unscaled either: who scales a floor up means to.

    Args:
        channel: as recorded.
        velocity: what it became, unscaled [m/s], shape (n,).
        scale: the user's factor on it [-].
    """
    found = []
    clipped = clipped_samples(channel.samples)
    if clipped:
        found.append(f"{channel.name} looks clipped: {clipped} samples stand at its extreme value")
    unscaled = float(np.sqrt(velocity @ velocity / velocity.size))
    speed = abs(scale) * unscaled
    mean = abs(scale * float(np.mean(channel.samples)))
    if channel.quantity == "acceleration" and channel.response is None:
        if abs(mean - 1.0) < NEAR_ONE:
            found.append(f"{channel.name} has a mean of {mean:.3g} m/s², as gravity in g: is its unit g?")
        elif abs(mean / GRAVITY - 1.0) < NEAR_ONE:
            found.append(f"{channel.name} has a mean of {mean:.3g} m/s²: it senses gravity, which is taken off")
    if QUIETEST <= unscaled <= LOUDEST:
        return found
    also = "" if scale == 1.0 else ", and is the scale right"
    question = f"are its samples really {channel.quantity} in the unit stated{also}?"
    if speed > LOUDEST:
        whole = channel.response is None and np.array_equal(channel.samples, np.rint(channel.samples))
        guess = " All are whole numbers: they look like counts of a converter." if whole else ""
        loud = f"which no floor does (above {LOUDEST:g} m/s)"
        found.append(f"{channel.name} moves with {speed:.3g} m/s RMS, {loud}: {question}{guess}")
    elif speed < QUIETEST:
        quiet = "quieter than any site on earth (Peterson's low noise model)"
        found.append(f"{channel.name} moves with {speed:.3g} m/s RMS, {quiet}: {question}")
    return found


def too_slow(name: str, rate: float) -> str | None:
    """What to say of a record sampled at ``rate`` [Hz] that is too slow for the highest band of the criteria."""
    needed = bands(TOP_BAND, TOP_BAND)[0].edges[1] / (USABLE / 2)
    if rate >= needed:
        return None
    return (
        f"record {name} is sampled at {rate:g} Hz, too slowly for the vibration criteria: "
        f"their {TOP_BAND:g} Hz band needs {np.ceil(needed):g} Hz"
    )
