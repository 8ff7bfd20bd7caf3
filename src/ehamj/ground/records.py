"""Ground motion from a record in any format that `ehamj.records.readers` knows."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Literal, Self

import numpy as np
from pydantic import Field, model_validator

from ehamj.estimate.bands import undecided_above
from ehamj.ground.doubts import doubts, too_slow
from ehamj.ground.motion import GroundSettings, Motion, Start
from ehamj.ground.treatment import Treatment, displacement, held_frequencies
from ehamj.ground.waves import spread
from ehamj.plant.axes import AXES
from ehamj.records.channel import USABLE, Record
from ehamj.records.choices import Choices
from ehamj.records.components import toml_key
from ehamj.records.readers import READERS, check_used, reader_of
from ehamj.records.seismic import EXAMPLE
from ehamj.records.units import ORDERS
from ehamj.series import Sampled, stored
from ehamj.settings import Fade, FileName
from ehamj.signals import Faded, Signal, Zero


class RecordGround(Choices, GroundSettings, Treatment):
    """A rigid slab that moves as a record says, in x, y and z; or each mount as its own components say."""

    kind: Literal["record"]
    file: FileName = Field(
        min_length=1,
        description="record, relative to the scenario's folder: "
        f"{', '.join(f'*{ending}' for reader in READERS.values() for ending in reader.endings)}, other tables "
        "of text, texts of ESM and ITACA, seismic formats told by their content (miniSEED, SAC, SEG-Y, SEG-2, …); "
        "the name may hold wildcards, for a file per component: seismic, PEER, ESM; "
        f"or {EXAMPLE!r}, a real record that ObsPy carries",
    )
    start: float = Field(0.0, ge=0, description="time in the record at which the simulation begins [s]")
    scale: float | dict[str, float] = Field(
        1.0,
        description="factor on the motion [-]; a table by axis, place or component, as in { z = 2.5e-9 }, gives each "
        "its own, and 1 to those that it does not name",
    )
    fade_in: Fade = Field(0.0, description="time over which the simulation's motion fades in [s]; 0: as taper")

    @model_validator(mode="after")
    def _scale_wanted(self) -> Self:
        if self.full_scale is not None and self._ending != ".wav":
            raise ValueError(f"full_scale = {self.full_scale} is for *.wav files only; leave it out")
        return self

    @property
    def _ending(self) -> str:
        return Path(self.file).suffix.lower()

    def named_mounts(self) -> Iterator[tuple[str, str]]:
        for name, place in (self.axes or {}).items():
            if " " in place:
                yield f"axes.{toml_key(name)}", place.partition(" ")[0]

    def read(self) -> Record:
        """The raw record."""
        path = Path(self.file)
        reader = reader_of(path)
        check_used(path, reader, self)
        return reader.read(path, self)

    def motion(self, start: Start) -> Motion:
        """Build the motion: at rest at time 0, then what the record says.

        Raises ValueError, naming the key, where the file or a setting does not allow it.
        """
        record = self.read()
        self._check(record, start.duration)
        scales = self._scales(record)
        moving: dict[str, Signal] = {}
        notes = [*record.notes]
        for channel in record.channels:
            if np.ptp(channel.samples) == 0:
                notes.append(f"{channel.name} never changes: {channel.axis} is at rest")
                moving[channel.axis] = Zero()
                continue
            moved = displacement(channel, self, self.start, start.duration)
            scale = scales[channel.axis]
            values = moved.values[:]
            velocity = np.gradient(values)
            velocity *= moved.rate
            notes += doubts(channel, velocity, scale)
            del velocity  # as large as the motion, which may be long
            scaled = Sampled(moved.rate, stored(scale * values), moved.start)
            moving[channel.axis] = Faded(scaled, self.fade_in or self.taper)
        usable = min(self.usable(channel) for channel in record.channels)
        notes += self._notes(record)
        return spread(
            start,
            at_mounts(moving, start.mounts),
            None,
            0.0,
            notes=tuple(notes),
            usable_to=usable,
            usable_from=max(self.passes_from(channel) for channel in record.channels),
        )

    def _scales(self, record: Record) -> dict[str, float]:
        """Factor on each channel, by its place; raises ValueError where the table names none of them."""
        if not isinstance(self.scale, dict):
            return dict.fromkeys((channel.axis for channel in record.channels), self.scale)
        axes = {c.axis: (c.axis, c.axis.rpartition(" ")[2]) for c in record.channels}
        along = {key for key in self.scale if any(key in known for known in axes.values())}
        # Of an axis and a component that bear one name, the axis is meant.
        names = {c.axis: (*axes[c.axis], *({c.name} - along)) for c in record.channels}
        unknown = [name for name in self.scale if not any(name in known for known in names.values())]
        if unknown:
            held = ", ".join(f"{channel.name} ({channel.axis})" for channel in record.channels)
            raise ValueError(f"ground.scale names {unknown[0]!r}, which is none of the components in use: {held}")
        return {
            place: next((self.scale[name] for name in known if name in self.scale), 1.0)
            for place, known in names.items()
        }

    def _check(self, record: Record, duration: float) -> None:
        if self.start + duration > record.duration + 1e-9:
            raise ValueError(
                f"ground.start = {self.start:g} s and the duration, {duration:g} s, ask for "
                f"{self.start + duration:g} s, but the record {record.name} lasts {record.duration:g} s"
            )
        if self.pre_filter is not None and all(channel.response is None for channel in record.channels):
            raise ValueError(f"ground.pre_filter = {list(self.pre_filter)}: only allowed where a response is removed")

    def _notes(self, record: Record) -> list[str]:
        """Processing and limits of ``record`` in plain words."""
        steps = [] if self.detrend == "none" else [f"{self.detrend} trend subtracted (Hann weights)"]
        steps.append(f"faded in and out over {self.taper:g} s at the record's ends")
        for rate in sorted({c.rate for c in record.channels if self.decimation(c.rate) > 1}):
            low = self.decimated_rate(rate)
            steps.append(
                f"decimated from {rate:g} Hz to {low:g} Hz in the frequency domain, without phase (unchanged up to "
                f"{USABLE * low / 2:g} Hz, nothing from {low / 2:g} Hz)"
            )
        if any(channel.response is not None for channel in record.channels):
            band = f"band {list(self.pre_filter)} Hz" if self.pre_filter else "falling from 0.8 to 1 times Nyquist"
            steps.append(f"instrument response removed (water level {self.water_level:g} dB, {band})")
        if self.highpass:
            steps.append(
                f"zero-phase high-pass at {self.highpass:g} Hz (within 0.1 % above {2.4 * self.highpass:g} Hz)"
            )
        times = sorted({ORDERS[channel.quantity] for channel in record.channels} - {0})
        if times:
            steps.append(f"integrated {' or '.join(('once', 'twice')[n - 1] for n in times)} (in the frequency domain)")
        steps.append(f"resampled to at least {self.rate:g} Hz")
        scales = self._scales(record)
        if len(set(scales.values())) == 1 and set(scales.values()) != {1.0}:
            steps.append(f"scaled by {next(iter(scales.values())):g}")
        elif set(scales.values()) != {1.0}:
            steps.append("scaled by " + ", ".join(f"{scale:g} ({place})" for place, scale in scales.items()))
        notes = [f"record {record.name}, in this order: " + ", ".join(steps)]
        notes.append(
            f"the ground starts from rest: its motion fades in over the first {self.fade_in or self.taper:g} s"
        )
        return notes + self._limits(record)

    def _limits(self, record: Record) -> list[str]:
        notes = []
        if 0 < self.highpass * record.duration < 1:
            notes.append(f"record {record.name} resolves nothing below {1 / record.duration:.3g} Hz: it is too short")
        for rate in sorted({channel.rate for channel in record.channels}):
            channels = [channel for channel in record.channels if channel.rate == rate]
            end = self.usable(channels[0])
            if channels[0].response is not None:
                end = min(end, self.band(channels[0])[2])
            whose = "" if len(channels) == len(record.channels) else f" in {', '.join(c.axis for c in channels)}"
            limit = f"record {record.name} ends at {end:g} Hz{whose} (sampled at {rate:g} Hz)"
            notes.append(f"{limit}: {undecided_above(end)}")
            slow = too_slow(record.name, rate)
            notes += [] if slow is None else [slow]
        for channel in record.channels:
            held = held_frequencies(channel, self)
            if held.size:
                notes.append(
                    f"{channel.name}: the response lies below the water level from {held[0]:.3g} to {held[-1]:.3g} Hz; "
                    "motion there is understated"
                )
        return notes


def at_mounts(moving: Mapping[str, Signal], mounts: Sequence[str]) -> dict[str, Signal | tuple[Signal, ...]]:
    """Signals by axis, from signals by place: one for all mounts, or one for each; channels at rest move nothing.

    A component of an axis serves all mounts that have none of their own. Raises ValueError where a mount has none.
    """
    found: dict[str, Signal | tuple[Signal, ...]] = {}
    for axis in AXES:
        own = [moving.get(f"{mount} {axis}", moving.get(axis)) for mount in mounts]
        given = [signal for signal in own if signal is not None]
        if all(isinstance(signal, Zero) for signal in given):
            continue
        if len(given) < len(mounts):
            missing = [mount for mount, signal in zip(mounts, own, strict=True) if signal is None]
            raise ValueError(
                f"ground.axes gives {axis} to some mounts, but not to {', '.join(missing)}; name them all, or one "
                f"component for {axis!r}, which serves the others"
            )
        single = not any(f"{mount} {axis}" in moving for mount in mounts)
        found[axis] = given[0] if single else tuple(given)
    return found
