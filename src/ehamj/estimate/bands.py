"""Third-octave bands of IEC 61260-1 (base ten, G = 10^0.3)."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ehamj.arrays import Array, ComplexArray

G = 10.0**0.3
BAND_LOG_WIDTH = float(np.log(G) / 3)
"""ln of the ratio of a band's edges; a PSD of L²/(BAND_LOG_WIDTH·f) has the RMS L in every band."""

NOMINAL = (1.0, 1.25, 1.6, 2.0, 2.5, 3.15, 4.0, 5.0, 6.3, 8.0)


OFF_CENTRE = 0.025
"""How far a band's stated frequency may lie from an exact centre, relative: nominal ones are rounded by up to 2.4 %."""


@dataclass(frozen=True)
class Band:
    """One band: exact centre f_m and edges f_m·G^(±1/6) [Hz]."""

    index: int

    @cached_property
    def centre(self) -> float:
        """Exact mid-band frequency, 1000·G^(k/3) [Hz]."""
        return float(1000.0 * G ** (self.index / 3))

    @property
    def nominal(self) -> float:
        """Nominal centre frequency, as norms print their limits [Hz]."""
        return float(self.name)

    @cached_property
    def edges(self) -> tuple[float, float]:
        """Lower and upper edge [Hz]."""
        return self.centre * G ** (-1 / 6), self.centre * G ** (1 / 6)

    @property
    def width(self) -> float:
        """Distance of the edges [Hz]."""
        low, high = self.edges
        return high - low

    @property
    def name(self) -> str:
        """Nominal centre frequency as people write it, in Hz: '31.5'."""
        decade, place = divmod(self.index, 10)
        value = NOMINAL[place] * 10.0 ** (decade + 3)
        return np.format_float_positional(value, precision=3, fractional=False, trim="-")


def bands(first: float, last: float) -> tuple[Band, ...]:
    """The bands whose nominal centres lie from ``first`` to ``last`` [Hz]."""
    low, high = (round(10.0 * np.log10(f / 1000.0)) for f in (first, last))
    return tuple(Band(k) for k in range(int(low), int(high) + 1))


def band_numbers(centres: Sequence[float] | Array) -> Array:
    """Numbers k of bands from their nominal centres 1000·10^(k/10) [Hz].

    Raises:
        ValueError: for a frequency that is no band's centre.
    """
    stated = np.asarray(centres, float)
    numbers = np.rint(10.0 * np.log10(stated / 1000.0))
    wrong = np.abs(stated / (1000.0 * 10.0 ** (numbers / 10.0)) - 1.0) > OFF_CENTRE
    if wrong.any():
        raise ValueError(
            f"bands: {stated[wrong][0]:g} Hz is not the centre of a third-octave band (…, 6.3, 8, 10, 12.5, 16, …)"
        )
    if (np.diff(numbers) <= 0).any():
        raise ValueError("bands must rise, each band once")
    return numbers


def band_attenuation(frequency: Array, response: ComplexArray, chosen: Sequence[Band]) -> Array:
    """Attenuation per third-octave [dB], positive: quieter than the floor, NaN in bands without a frequency.

    Of a floor that moves with the same velocity at each of the given frequencies: −10 lg of the mean of |T|².

    Args:
        frequency: [Hz], (f,).
        response: one element over frequency, (f,); NaN is left out.
        chosen: bands.
    """
    found = np.full(len(chosen), np.nan)
    for k, band in enumerate(chosen):
        low, high = band.edges
        inside = np.abs(response[(frequency >= low) & (frequency < high)]) ** 2
        inside = inside[np.isfinite(inside)]
        if inside.size and inside.mean() > 0:
            found[k] = -10.0 * np.log10(inside.mean())
    return found


def undecided_above(end: float) -> str:
    """In words: the bands that are undecided where motion is known up to a frequency [Hz] only."""
    first = next((band.name for band in bands(1.0, 315.0) if band.edges[1] > end), None)
    return f"bands above {end:g} Hz are undecided" if first is None else f"bands from {first} Hz on are undecided"
