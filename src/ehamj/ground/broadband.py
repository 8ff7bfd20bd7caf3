"""Random floors: flat per third octave for as long as the run, or as a burst that passes; or shaped to a target."""

from dataclasses import dataclass
from typing import Literal, Self

import numpy as np
from pydantic import Field, model_validator

from ehamj.criteria.vc import CLASSES
from ehamj.estimate.bands import BAND_LOG_WIDTH, G, undecided_above
from ehamj.ground.lines import RandomGround
from ehamj.ground.motion import Motion, Start
from ehamj.ground.spectra import Spectrum
from ehamj.ground.targets import Target
from ehamj.settings import Fade, Positive
from ehamj.signals import Array, Sample, Signal


class _Flat(RandomGround):
    """A third-octave velocity that is flat between two frequencies and falls outside."""

    level: float | str = Field(
        "VC-C", description="third-octave RMS velocity [m/s], or a class such as VC-C or workshop"
    )
    first: Positive = Field(1.0, description="lowest third-octave band of the flat part [Hz]")
    last: Positive = Field(80.0, description="highest third-octave band of the flat part [Hz]")
    fall: float = Field(12.0, ge=0, description="fall above the flat part [dB/octave]")
    rise: float = Field(24.0, ge=0, description="rise below the flat part [dB/octave]")
    highest: Positive = Field(500.0, description="no motion above this frequency [Hz]")

    @model_validator(mode="after")
    def _possible(self) -> Self:
        if isinstance(self.level, str) and self.level not in CLASSES:
            raise ValueError(f"level = {self.level!r} must be a velocity in m/s or one of {', '.join(CLASSES)}")
        if isinstance(self.level, float) and self.level < 0:
            raise ValueError(f"level = {self.level:g} m/s must not be negative")
        if not self.first < self.last < self.highest:
            raise ValueError(
                f"first = {self.first:g}, last = {self.last:g} and highest = {self.highest:g} Hz must increase"
            )
        return self

    @property
    def velocity(self) -> float:
        """Third-octave RMS velocity in the flat part [m/s]."""
        return CLASSES[self.level] if isinstance(self.level, str) else self.level

    def spectrum(self, frequency: Array) -> Array:
        """One-sided PSD of the velocity [(m/s)²/Hz] at ``frequency`` [Hz]."""
        fall, rise = (slope / (10.0 * np.log10(2.0)) for slope in (self.fall, self.rise))
        f = np.maximum(frequency, 1e-9)
        lower, upper = self.first * G ** (-1 / 6), self.last * G ** (1 / 6)
        outside = np.minimum(1.0, f / lower) ** rise * np.minimum(1.0, upper / f) ** fall
        density = self.velocity**2 / (BAND_LOG_WIDTH * f) * outside
        return np.where((frequency > 0) & (frequency <= self.highest), density, 0.0)

    def _motion(self, start: Start, envelope: Signal | None = None) -> Motion:
        spectra = dict.fromkeys(self.axes, Spectrum(self.spectrum, 0.0, self.highest))
        return self.random_floor(start, spectra, envelope)


class BroadbandGround(_Flat):
    """A floor whose third-octave velocity is flat between two frequencies and falls outside.

    It is a dense sum of sines of exact amplitude and random phase, which repeats after the run, so that its levels are
    met by every seed. Axes are independent of each other.
    """

    kind: Literal["broadband"]

    def motion(self, start: Start) -> Motion:
        return self._motion(start)


class BurstGround(_Flat):
    """A broadband vibration that swells and decays, once or again and again: something heavy passes.

    The envelope is (s e^(1−s))³ of s = (t − begin)/swell_time: it rises to one at s = 1 and decays to 1 % at s = 3.9.
    """

    kind: Literal["burst"]
    level: float | str = Field(200e-6, description="third-octave RMS velocity at the peak [m/s], or a class")
    first: Positive = Field(5.0, description="lowest third-octave band of the flat part [Hz]")
    last: Positive = Field(20.0, description="highest third-octave band of the flat part [Hz]")
    fall: float = Field(24.0, ge=0, description="fall above the flat part [dB/octave]")
    highest: Positive = Field(200.0, description="no motion above this frequency [Hz]")
    fade_in: Fade = Field(0.0, description="time over which the motion fades in from time 0 [s]")
    begin: float = Field(1.0, ge=0, description="time at which the burst begins [s]")
    swell_time: Positive = Field(1.0, description="time from the beginning to the peak [s]")
    repeat: Positive | None = Field(None, description="time from one burst to the next [s]; without: there is one")

    @model_validator(mode="after")
    def _apart(self) -> Self:
        if self.repeat is not None and self.repeat < LEAST_REPEAT * self.swell_time:
            raise ValueError(
                f"repeat = {self.repeat:g} s must be at least {LEAST_REPEAT:g} swell_time = "
                f"{LEAST_REPEAT * self.swell_time:g} s, so that a burst has decayed when the next begins"
            )
        return self

    def motion(self, start: Start) -> Motion:
        return self._motion(start, Swell(self.begin, self.swell_time, self.repeat))


LEAST_REPEAT = 8.0
"""Least time between bursts in swell times: the one before has then decayed to 4e-7."""


@dataclass(frozen=True)
class Swell:
    """The envelope (s e^(1−s))³ of s = (t − begin)/swell_time, from 0 over 1 back to 0, repeated or not."""

    begin: float
    swell_time: float
    repeat: float | None = None

    def sample(self, time: Array, left: bool = False) -> Sample:
        since = np.maximum(time - self.begin, 0.0)
        s = (since if self.repeat is None else since % self.repeat) / self.swell_time
        decay = np.exp(3.0 * (1.0 - s))
        slope = 3.0 * s**2 * (1.0 - s) * decay / self.swell_time
        curvature = 3.0 * s * (2.0 - 6.0 * s + 3.0 * s * s) * decay / self.swell_time**2
        return Sample(s**3 * decay, slope, curvature)


class ShapedGround(RandomGround):
    """A random floor with the spectrum of a target; there is no motion outside of what the target states."""

    kind: Literal["shaped"]
    target: Target = Field(description="spectrum that the floor has")
    scale: Positive = Field(1.0, description="factor on the motion [-]")
    first: Positive | None = Field(None, description="lowest frequency of the motion [Hz]; without: as the target")
    last: Positive | None = Field(None, description="highest frequency of the motion [Hz]; without: as the target")

    def motion(self, start: Start) -> Motion:
        whole = self.target.spectra(self.axes)
        spectra = {axis: spectrum.cut(self.first, self.last) for axis, spectrum in whole.items()}
        low, high = max(s.low for s in spectra.values()), min(s.high for s in spectra.values())
        scaled = {axis: spectrum.scaled(self.scale) for axis, spectrum in spectra.items()}
        note = f"floor shaped to a {self.target.kind} target from {low:.4g} to {high:.4g} Hz"
        note += f": {undecided_above(high)}"
        return self.random_floor(start, scaled, notes=(note,), usable_to=high)
