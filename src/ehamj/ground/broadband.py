"""Random floors of a stated third-octave level."""

from typing import Annotated, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from ehamj.criteria.third_octave import BAND_LOG_WIDTH, G
from ehamj.criteria.vc import CLASSES
from ehamj.ground.motion import Motion, Start
from ehamj.ground.waves import Wave, spread
from ehamj.layout import AXES
from ehamj.parameters import Settings
from ehamj.signals import Sampled, Signal

Array = NDArray[np.float64]
Positive = Annotated[float, Field(gt=0)]

OVERSAMPLING = 8.0
"""Samples per period of the highest frequency; the spline between them is then exact to 1e-6."""

MARGIN = 2.0
"""Motion kept before and after the run [s], for the delays of waves."""


class BroadbandGround(Settings):
    """A floor whose third-octave velocity is flat between two frequencies and falls outside.

    It is a dense sum of sines of exact amplitude and random phase, as long as the run, so that its levels are met by
    every seed. Axes are independent of each other.
    """

    kind: Literal["broadband"]
    level: float | str = Field(
        "VC-C", description="third-octave RMS velocity [m/s], or a class such as VC-C or workshop"
    )
    first: Positive = Field(1.0, description="lowest third-octave band of the flat part [Hz]")
    last: Positive = Field(80.0, description="highest third-octave band of the flat part [Hz]")
    fall: float = Field(12.0, ge=0, description="fall above the flat part [dB/octave]")
    rise: float = Field(24.0, ge=0, description="rise below the flat part [dB/octave]")
    highest: Positive = Field(500.0, description="no motion above this frequency [Hz]")
    axes: tuple[Literal["x", "y", "z"], ...] = Field(("z",), description="axes that move", min_length=1)
    wave: Wave | None = Field(None, description="pass below the machine as a plane wave; without: a rigid slab")
    fade_in: float = Field(0.5, ge=0, description="time over which the motion fades in [s]")

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

    def motion(self, start: Start) -> Motion:
        """Build the motion."""
        signals: dict[str, Signal] = {axis: self._signal(start, axis) for axis in self.axes}
        return spread(start, signals, self.wave, self.fade_in)

    def _signal(self, start: Start, axis: str) -> Signal:
        delay = 0.0 if self.wave is None else float(np.abs(self.wave.delays(start.positions)).max())
        margin = MARGIN + delay
        length = start.duration + 2 * margin
        n = int(np.ceil(OVERSAMPLING * self.highest * length))
        rate = n / length
        frequency: Array = np.arange(n // 2 + 1, dtype=np.float64) / length
        random = np.random.default_rng([start.seed, AXES.index(axis), *start.part])
        phase = random.uniform(0.0, 2.0 * np.pi, frequency.size)
        amplitude = np.sqrt(2.0 * self.spectrum(frequency) / length)  # of the velocity's line at each frequency
        lines = np.zeros(frequency.size, complex)
        lines[1:] = amplitude[1:] * np.exp(1j * phase[1:]) / (2j * np.pi * frequency[1:])
        return Sampled(rate, np.fft.irfft(lines * n / 2, n), -margin)
