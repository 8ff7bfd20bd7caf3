"""A channel of a run, read once: its levels in bands, whatever else is strong in it.

Energy between a band's edges is read without a window, so that all that counts has the same weight. The price is
leakage: weights that fall to zero within half a second spread what is strong over a few hertz around, though little.
Lines do not leak, as they are taken out before. What else is far stronger than a band leaks least in another order of
differences: what lies below (microseism, creep, an offset with its drift) in second ones, what lies above in none.
As leakage only adds, each band is read by first differences, and by another order where that reads clearly less.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, Self

import numpy as np
from scipy.fft import next_fast_len

from ehamj.arrays import Array
from ehamj.columns import Samples
from ehamj.estimate.bands import Band
from ehamj.estimate.counted import LEAST_BINS, Counted, by_column, forget_plans
from ehamj.estimate.spectrum import FADE, FILLING, HIGHEST, RINGING, Spectrum
from ehamj.estimate.steady import Waves, lines_of

ORDERS: Final = (1, 0, 2)
"""Of differences, in order of preference."""
CLEARLY: Final = 10.0**-0.05
"""Share of the level by first differences below which another order is taken: 0.5 dB, more than the three differ by
chance."""


@dataclass(frozen=True)
class Reading:
    """One channel: its spectrum by differences of several orders, and which of them each band is read from."""

    counted: Counted
    spectra: dict[Band, Spectrum] = field(repr=False)
    """Of each band that is decided."""

    @classmethod
    def of(cls, samples: Array, counted: Counted, chosen: Sequence[Band], least_bins: float = LEAST_BINS) -> Self:
        """Of the samples (n,) of one channel, for levels in the bands ``chosen``; for ``least_bins`` see `band_rms`.

        Spectra are padded with zeros for as long as filters of the narrowest band ring, so that what they make of the
        end does not come round to the beginning.
        """
        decided = [band for band in chosen if counted.decides(band, least_bins)]
        if not decided:
            return cls(counted, {})
        padding = (RINGING + FILLING) / min(band.width for band in decided) + FADE
        size = next_fast_len(counted.n + int(np.ceil(padding * counted.rate)), real=True)
        highest = HIGHEST * max(band.centre for band in decided) * size / counted.rate
        padded = size, min(int(highest) + 2, size // 2 + 1)
        lines = lines_of(samples, counted)
        forget_plans(counted.n)
        base = Waves(lines, counted)
        first = Spectrum.of(samples, lines, base, counted, padded, ORDERS[0])
        least, found = CLEARLY * first.rms(decided, least_bins=least_bins), [first] * len(decided)
        del first  # one that no band is read from goes before the next comes
        for order in ORDERS[1:]:
            spectrum = Spectrum.of(samples, lines, base, counted, padded, order)
            levels = spectrum.rms(decided, least_bins=least_bins)
            found = [spectrum if level < known else one for level, known, one in zip(levels, least, found, strict=True)]
            least = np.minimum(least, levels)
        forget_plans(counted.n)
        return cls(counted, dict(zip(decided, found, strict=True)))

    def rms(self, chosen: Sequence[Band], order: int = 0, least_bins: float = LEAST_BINS) -> Array:
        """RMS of the whole run in each band, (bands,), NaN where undecided; see `band_rms`."""
        tables = {id(spectrum): spectrum for spectrum in self.spectra.values()}
        decided = list(self.spectra)
        levels = {
            key: dict(zip(decided, spectrum.rms(decided, order, least_bins), strict=True))
            for key, spectrum in tables.items()
        }
        return np.array([levels[id(self.spectra[band])][band] if band in self.spectra else np.nan for band in chosen])


def band_rms(
    signal: Samples,
    rate: float,
    chosen: tuple[Band, ...],
    order: int = 0,
    least_bins: float = LEAST_BINS,
) -> Array:
    """RMS of the whole run of a signal, or of its derivative or integral, in each band.

    The energy of all that counts, without window: see `Counted` for the weights near the two ends.

    Args:
        signal: samples from time 0 on, (n,) or (n, …).
        rate: sampling rate [Hz].
        chosen: bands.
        order: of the time derivative.
        least_bins: bandwidth times counted time that a band needs.

    Returns:
        (bands,) or (bands, …), in the signal's unit (times 1/s to the power of ``order``); NaN where the record is too
        short or sampled too slowly for the band.
    """
    counted = Counted(signal.shape[0], rate)
    return by_column(signal, lambda one: Reading.of(one, counted, chosen, least_bins).rms(chosen, order, least_bins))
