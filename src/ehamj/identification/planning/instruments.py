"""What a test is seen with: channels, the instruments that read them, and their noise."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from ehamj.arrays import Array, ComplexArray
from ehamj.control.channels import UnknownChannelError, check_channel, quantity_of
from ehamj.control.sensors import Sensors, class_of
from ehamj.errors import InputError
from ehamj.plant.axes import AXES, CHAMBERS
from ehamj.scenario.model import Scenario

SHARE: Final = 0.01
"""What a channel has beside its instrument's noise, as a share of its RMS: rigs hum, and no model is the machine."""
BITS: Final = 16
"""Of the logger's converters."""
PEAK: Final = 4.0
"""Range of a converter, over the RMS of the liveliest channel that it is set for."""
STILL: Final = 1e-3
"""Share of a converter's range, thirty of its steps, below which a channel that moves is none to record."""
QUIET: Final = 0.1
"""Share of the largest RMS among channels of one variable that one counts with at least: instruments are alike."""
UNITS: Final = {
    "displacement": "m",
    "velocity": "m/s",
    "acceleration": "m/s²",
    "pressure": "Pa",
    "position": "mA",
}
"""By quantity; of machine_… channels about an axis: rad in place of m."""


@dataclass(frozen=True)
class Instruments:
    """Channels and how each is read, at ``rate`` samples per second [Hz].

    ``noise`` has standard deviations of a sample [unit], by channel or by its first word; of a channel that is not
    there, that of the scenario's instrument counts and, beside it, a ``share`` of the channel's own RMS, and what a
    converter of `BITS` rounds whose range holds the liveliest test.
    """

    channels: tuple[str, ...]
    rate: float
    sensors: Sensors
    noise: Mapping[str, float]
    share: float = SHARE
    ranges: Mapping[str, float] = field(default_factory=dict)
    """Of the logger's converters, ± this, by a channel's first word [unit]: without, they resolve anything."""

    @classmethod
    def of(
        cls,
        scenario: Scenario,
        rate: float,
        channels: Sequence[str] | None = None,
        noise: Mapping[str, float] | None = None,
        share: float = SHARE,
    ) -> "Instruments":
        """Those of a scenario: what its [sensors] can read, or ``channels``.

        Raises:
            InputError: if a channel is none, is the ground's (an input, not compared), or an instrument measures
                another quantity.
        """
        mounts, given = scenario.plant.mounts, noise or {}
        chosen = default_channels(scenario) if channels is None else tuple(channels)
        for name in chosen:
            try:
                check_channel(name, mounts)
            except UnknownChannelError as error:
                raise InputError(f"plan.channels: {error}") from None
            if name.startswith("ground_"):
                raise InputError(
                    f"plan.channels: {name!r}: ground motion is an input of a test, not compared; leave it out here"
                )
        words = {name.split(" ")[0] for name in chosen}
        for key in given:
            if key not in chosen and key not in words:
                raise InputError(
                    f"plan.noise: {key!r} must be one of the channels or their first words: "
                    f"{', '.join(sorted(words))}; the channels are {', '.join(chosen)}"
                )
        found = cls(chosen, rate, scenario.sensors, dict(given), share)
        for name in chosen:
            found.stated(name) or scenario.sensors.of(name)
        return found

    def stated(self, channel: str) -> float | None:
        """Standard deviation that the user gave of a channel's samples [unit]."""
        return self.noise.get(channel, self.noise.get(channel.split(" ")[0]))

    def response(self, hertz: Array) -> ComplexArray:
        """Reading over channel, (f, channel); one where the user states the noise of what is read."""
        sensors = [None if self.stated(name) is not None else self.sensors.of(name) for name in self.channels]
        return np.array([np.ones(hertz.size) if s is None else s.response(hertz) for s in sensors], complex).T

    def density(self, hertz: Array, rms: Array) -> Array:
        """Power density of each reading's noise, one-sided, (f, channel) [unit²/Hz].

        ``rms`` (channel,) of the readings counts where a share of it is noise. A white noise of deviation σ at the
        rate fₛ has the density 2σ²/fₛ.
        """
        found = np.empty((hertz.size, len(self.channels)))
        for k, name in enumerate(self.channels):
            alike = [rms[j] for j, other in enumerate(self.channels) if other.split(" ")[0] == name.split(" ")[0]]
            level = max(rms[k], QUIET * max(alike))
            stated, sensor = self.stated(name), None if self.stated(name) else self.sensors.of(name)
            found[:, k] = 2.0 / self.rate * (self.share * level if stated is None else stated) ** 2
            if stated is None:
                found[:, k] += 2.0 / self.rate * (self._range(name) / 2 ** (BITS - 1)) ** 2 / 12.0
            if sensor is not None:
                steps = sensor.resolution**2 / 12.0
                found[:, k] += sensor.noise_density(hertz) ** 2 + 2.0 / self.rate * steps
        return found

    def ranged(self, liveliest: Array) -> "Instruments":
        """With converters set for the largest RMS of each channel in all tests, (channel,)."""
        found: dict[str, float] = {}
        for name, rms in zip(self.channels, liveliest, strict=True):
            word = name.split(" ")[0]
            found[word] = max(found.get(word, 0.0), PEAK * float(rms))
        return replace(self, ranges=found)

    def moving(self, rms: Array) -> tuple[str, ...]:
        """Channels whose RMS (channel,) is at least `STILL` of their converters' range."""
        return tuple(name for name, own in zip(self.channels, rms, strict=True) if own > STILL * self._range(name))

    def _range(self, channel: str) -> float:
        return self.ranges.get(channel.split(" ")[0], 0.0)

    def told(self, channel: str) -> str:
        """Where its noise is known from, in words."""
        stated = self.stated(channel)
        if stated is not None:
            return f"{stated:.3g} {unit_of_channel(channel)} a sample"
        own = "" if self.sensors.of(channel) is None else f"[sensors.{class_of(channel.split(' ')[0])}], "
        converter = f"{BITS} bits of ± {self._range(channel):.2g} {unit_of_channel(channel)}"
        return f"{own}{100.0 * self.share:g} % of its RMS, {converter}"


def default_channels(scenario: Scenario) -> tuple[str, ...]:
    """What a scenario's [sensors] can read at each mount: strokes, pressures, motion of the feet; all of these where it
    has no instrument at all."""
    sensors, mounts = scenario.sensors, scenario.plant.mounts
    bare = sensors.stroke is None and sensors.pressure is None and sensors.inertial is None and sensors.spool is None
    found: list[str] = []
    if sensors.stroke is not None or bare:
        found += [f"stroke {mount}" for mount in mounts]
    if sensors.pressure is not None or bare:
        found += [f"chamber_pressure {mount} {chamber}" for mount in mounts for chamber in CHAMBERS]
    if sensors.inertial is not None or bare:
        motion = "acceleration" if sensors.inertial is None else sensors.inertial.measures
        found += [f"foot_{motion} {mount} {axis}" for mount in mounts for axis in AXES]
    if sensors.spool is not None:
        found += [f"spool {mount}" for mount in mounts]
    return tuple(found)


def unit_of_channel(name: str) -> str:
    """Unit of a channel's values."""
    unit = UNITS[quantity_of(name.split(" ")[0])]
    return unit.replace("m", "rad", 1) if name.startswith("machine_") and name.split(" ")[-1][0] == "r" else unit
