"""Open-loop valve commands: a signal per mount [V], or none."""

import re
from abc import abstractmethod
from collections.abc import Iterator, Sequence
from typing import Annotated, Literal

from pydantic import Field

from ehamj.control.settings import ControlSettings
from ehamj.errors import InputError
from ehamj.records.inputs import RecordedInput
from ehamj.settings import Positive, Settings, SineSum
from ehamj.signals import Chirp, Multisine, Signal, Step, Total, Zero


class SignalSettings(Settings):
    """What every command signal has: the mounts that it drives."""

    mounts: tuple[str, ...] | None = Field(
        None, description="mounts that receive the signal, by name; without: all", min_length=1
    )

    @abstractmethod
    def signal(self, duration: float) -> Signal:
        """Build the signal [V] for a run of ``duration`` [s].

        Raises:
            InputError: if a record cannot be used.
        """


class SineCommand(SignalSettings):
    """amplitude·sin(2πft + phase)."""

    kind: Literal["sine"]
    amplitude: float = Field(description="amplitude [V]")
    frequency: Positive = Field(description="frequency [Hz]")
    phase: float = Field(0.0, description="phase [rad]")

    def signal(self, duration: float) -> Signal:
        return Multisine.of(self.amplitude, self.frequency, self.phase)


class MultisineCommand(SineSum, SignalSettings):
    """Sum of sines of one amplitude."""

    kind: Literal["multisine"]
    amplitude: float = Field(description="amplitude of each sine [V]")

    def signal(self, duration: float) -> Signal:
        return Multisine.of(self.amplitude, self.frequencies, self.phases)


class StepCommand(SignalSettings):
    """A jump; a negative ``start`` holds the value from the beginning, and the machine starts in its equilibrium."""

    kind: Literal["step"]
    amplitude: float = Field(description="height of the step [V]")
    start: float = Field(0.0, description="time of the step [s]")

    def signal(self, duration: float) -> Signal:
        return Step(self.amplitude, self.start)


class ChirpCommand(SignalSettings):
    """Exponential sine sweep."""

    kind: Literal["chirp"]
    amplitude: float = Field(description="amplitude [V]")
    first: Positive = Field(description="frequency at the beginning [Hz]")
    last: Positive = Field(description="frequency at the end [Hz]")
    sweep_time: Positive = Field(description="duration of the sweep [s]")
    start: float = Field(0.0, ge=0, description="time at which the sweep begins [s]")

    def signal(self, duration: float) -> Signal:
        return Chirp(self.amplitude, self.first, self.last, self.sweep_time, self.start)


class RecordedCommand(RecordedInput, SignalSettings):
    """What a logger wrote of the command."""

    kind: Literal["recorded"]

    def signal(self, duration: float) -> Signal:
        return self.replayed("voltage", "valve_command", KEY, duration)


CommandSignal = Annotated[
    SineCommand | MultisineCommand | StepCommand | ChirpCommand | RecordedCommand, Field(discriminator="kind")
]

KEY = "control.signals"
"""Of the list of signals, in messages of one of them."""


class Passive(ControlSettings):
    """No command: the valves stay centred."""

    kind: Literal["passive"] = "passive"


class OpenLoop(ControlSettings):
    """Given command signals; several for one mount add up."""

    kind: Literal["open-loop"]
    signals: tuple[CommandSignal, ...] = Field(description="the signals", min_length=1)

    def commands(self, mounts: Sequence[str], duration: float) -> tuple[Signal, ...]:
        """One signal per mount [V]; raises InputError, naming the signal's key, where a record cannot be used."""
        found = []
        signals = [_numbered(one, number, duration) for number, one in enumerate(self.signals)]
        for mount in mounts:
            driving = zip(self.signals, signals, strict=True)
            own = tuple(signal for one, signal in driving if one.mounts is None or mount in one.mounts)
            found.append(Total(own) if own else Zero())
        return tuple(found)

    def named_mounts(self) -> Iterator[tuple[str, str]]:
        for k, signal in enumerate(self.signals):
            yield from ((f"signals.{k}.mounts", mount) for mount in signal.mounts or ())


def _numbered(one: SignalSettings, number: int, duration: float) -> Signal:
    try:
        return one.signal(duration)
    except InputError as error:
        raise InputError(re.sub(rf"\b{re.escape(KEY)}(?=[.:])", f"{KEY}.{number}", str(error))) from error
