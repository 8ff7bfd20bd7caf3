"""From a raw record to displacement without drift: pure functions of arrays, no files.

The order is deliberate, and the notes of the motion repeat it:

1. cut to the part that is used plus what the high-pass remembers,
2. detrend, with weights that vanish at both ends, so that vibration cannot tilt the line,
3. fade in and out (a quintic), so that padding adds no step,
4. decimate what is sampled much faster than any motion of interest, without phase,
5. pad with zeros for as long as the high-pass remembers, and transform,
6. divide by the instrument's response, kept above the water level and inside a band,
7. high-pass without phase, 1/(1 + (f_c/f)⁸): a fourth-order Butterworth run forwards and backwards,
8. integrate, dividing by iω once for velocity and twice for acceleration,
9. transform back on a finer grid: band-limited resampling, dense enough for a quintic spline.
"""

from math import ceil
from typing import Literal, Self

import numpy as np
import scipy
from numpy.typing import NDArray
from pydantic import Field, model_validator

from ehamj.ground.resampling import band_gain, decimated, resampled
from ehamj.records.channel import USABLE, Channel
from ehamj.records.units import ORDERS
from ehamj.series import Sampled
from ehamj.settings import Positive, Settings, Unlimited
from ehamj.signals import Array, rise

PASSES = 9.0 ** (1.0 / 8.0)
"""Frequency over the corner of the high-pass at which it leaves 0.9 of the motion, 1/(1 + PASSES⁻⁸)."""
_MEMORY = 6.0  # periods of the corner after which the high-pass has forgotten all but 1e-6


class Treatment(Settings):
    """How a record becomes displacement."""

    detrend: Literal["none", "constant", "linear"] = Field("linear", description="what is subtracted first")
    highpass: float = Field(
        0.1, ge=0, description="corner of the zero-phase high-pass [Hz]; 0, none, is for displacement records only"
    )
    taper: Positive = Field(1.0, description="time over which the record fades in and out at its two ends [s]")
    rate: float = Field(1000.0, gt=0, le=1e5, description="least rate to which the record is resampled [Hz]")
    decimate_to: Positive = Field(
        5000.0,
        description="rate to which a faster record is decimated: by a whole number, so to this or less than "
        "twice this [Hz]; the motion then holds what lies below 0.4 times the decimated rate",
    )
    water_level: Unlimited = Field(
        60.0,
        gt=0,
        description="how far below its peak the instrument's response is still divided by [dB] (inf: all of it)",
    )
    pre_filter: tuple[float, float, float, float] | None = Field(
        None,
        description="band kept when the response is removed: two frequencies where it rises, two where it falls [Hz]; "
        "default: falls from 0.8 to 1 times the Nyquist frequency",
    )

    @model_validator(mode="after")
    def _rising(self) -> Self:
        band = self.pre_filter
        if band is not None and not 0 <= band[0] <= band[1] < band[2] <= band[3]:
            raise ValueError(f"pre_filter = {list(band)} must be four rising frequencies, 0 or more, in Hz")
        return self

    @property
    def memory(self) -> float:
        """How long the filters ring [s]."""
        return _MEMORY / self.highpass if self.highpass > 0 else 10.0

    def passes_from(self, channel: Channel) -> float:
        """Frequency from which a channel passes with nine tenths of its motion, or all [Hz]."""
        falls_from = 0.0 if channel.response is None else self.band(channel)[1]
        return max(PASSES * self.highpass, falls_from)

    def band(self, channel: Channel) -> tuple[float, float, float, float]:
        """Corners of the band inside which the response is removed [Hz]."""
        rate = self.decimated_rate(channel.rate)
        return self.pre_filter or (0.0, 0.0, self.usable(channel), rate / 2)

    def decimation(self, rate: float) -> int:
        """By how much a record of ``rate`` [Hz] is decimated: the largest whole number that leaves `decimate_to`."""
        return max(1, int(rate / self.decimate_to * (1.0 + 1e-9)))

    def decimated_rate(self, rate: float) -> float:
        """What remains of ``rate`` [Hz]."""
        return rate / self.decimation(rate)

    def usable(self, channel: Channel) -> float:
        """Highest frequency that what becomes of ``channel`` is believed at [Hz]."""
        return USABLE * self.decimated_rate(channel.rate) / 2


def weighted_trend(samples: Array, kind: Literal["none", "constant", "linear"]) -> Array:
    """Mean or line through ``samples`` (n,) by least squares with Hann weights, shape (n,).

    Without weights a sine of amplitude A tilts the line by about 6A/(π periods), which integration turns into drift.
    """
    if kind == "none":
        return np.zeros_like(samples)
    along = np.linspace(-1.0, 1.0, samples.size)
    weight = 0.5 + 0.5 * np.cos(np.pi * along)
    mean = np.sum(weight * samples) / np.sum(weight)
    # Even weights and an odd slope: the two are orthogonal, so each is fitted alone.
    slope = np.sum(weight * along * samples) / np.sum(weight * along**2) if kind == "linear" else 0.0
    return mean + slope * along


def fade(size: int, width: float) -> Array:
    """Window of ``size`` samples that rises and falls over ``width`` samples, smooth to the second derivative."""
    index = np.arange(size)
    return rise(np.minimum(index, size - 1 - index) / width).value


def highpass_gain(frequency: Array, corner: float) -> Array:
    """Gain of the zero-phase high-pass, 1/(1 + (f_c/f)⁸), shape (n,); within 0.1 % of one above 2.4 f_c."""
    if corner == 0:
        return np.ones_like(frequency)
    ratio8 = (frequency / corner) ** 8
    return ratio8 / (1.0 + ratio8)


def inverse_response(response: NDArray[np.complex128], water_level: float) -> NDArray[np.complex128]:
    """Reciprocal of ``response`` (n,), its magnitude held ``water_level`` dB below the peak; zero where it is zero."""
    size = np.abs(response)
    held = np.maximum(size, size.max() * 10.0 ** (-water_level / 20.0))
    return np.divide(response.conj(), size * held, out=np.zeros_like(response), where=size > 0)


def held_frequencies(channel: Channel, treatment: Treatment) -> Array:
    """Frequencies in the channel's usable band at which the water level holds the response [Hz], shape (n,)."""
    if channel.response is None:
        return np.empty(0)
    frequency = np.geomspace(max(treatment.highpass, 1e-3), treatment.usable(channel), 500)
    size = np.abs(channel.response(frequency))
    return frequency[size < size.max() * 10.0 ** (-treatment.water_level / 20.0)]


def check(channel: Channel, treatment: Treatment) -> None:
    """Raise ValueError where ``treatment`` does not suit ``channel``."""
    length = channel.samples.size / channel.rate
    if 2 * treatment.taper > length:
        raise ValueError(f"ground.taper = {treatment.taper:g} s must be at most half of the record, {length / 2:g} s")
    if treatment.highpass == 0 and channel.quantity != "displacement":
        raise ValueError(
            f"ground.highpass = 0 Hz is allowed for displacement records only: {channel.name} holds "
            f"{channel.quantity}, which drifts when it is integrated"
        )
    least, end = 0.1 / length, treatment.usable(channel)
    if treatment.highpass and not least <= treatment.highpass < end:
        raise ValueError(
            f"ground.highpass = {treatment.highpass:g} Hz must be at least {least:g} Hz, since the record lasts "
            f"{length:g} s, and below {end:g} Hz, where it ends"
        )


def displacement(channel: Channel, treatment: Treatment, begin: float, duration: float) -> Sampled:
    """Displacement [m] of ``channel`` from ``begin`` for ``duration`` [s], its own time counting from ``begin``.

    Raises ValueError where the treatment does not suit the channel.
    """
    check(channel, treatment)
    reach = treatment.memory + treatment.taper
    part = channel.section(begin - reach, begin + duration + reach)
    samples = part.samples - weighted_trend(part.samples, treatment.detrend)
    samples = decimated(samples * fade(samples.size, treatment.taper * part.rate), treatment.decimation(part.rate))
    part_rate = treatment.decimated_rate(part.rate)

    pad = ceil(treatment.memory * part_rate)
    size = scipy.fft.next_fast_len(samples.size + 2 * pad, real=True)
    frequency = np.arange(size // 2 + 1) * (part_rate / size)
    spectrum = scipy.fft.rfft(np.concatenate([np.zeros(pad), samples]), size)
    spectrum *= highpass_gain(frequency, treatment.highpass)
    if part.response is not None:
        inverse = inverse_response(part.response(frequency), treatment.water_level)
        spectrum = spectrum * inverse * band_gain(frequency, treatment.band(part))
    spectrum[1:] /= (2j * np.pi * frequency[1:]) ** ORDERS[part.quantity]
    if ORDERS[part.quantity]:
        spectrum[0] = 0.0
    values, rate = resampled(spectrum, size, part_rate, treatment.rate)
    first_time = part.time - pad / part_rate - begin
    # A few samples beyond both ends keep the spline's boundaries out of what is simulated.
    first = max(0, int(-first_time * rate) - 16)
    last = min(values.size, ceil((duration - first_time) * rate) + 17)
    return Sampled(rate, values[first:last], first_time + first / rate)
