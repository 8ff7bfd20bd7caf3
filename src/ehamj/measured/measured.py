"""What was measured in a test: channels over time on one clock, or responses over frequency."""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from ehamj.arrays import Array, ComplexArray
from ehamj.settings import Vector3

Role = Literal["input", "output"]
"""What drives the model, or what is compared with it."""


@dataclass(frozen=True)
class ForcePlace:
    """Where a measured force acts, or an accelerometer stands, and along what, of length one."""

    point: str | Vector3
    """A name in the scenario's points, ``cg``, or a place from the mount plane's centre [m]."""
    direction: Vector3


@dataclass(frozen=True)
class MeasuredChannel:
    """One channel of a test, in SI (a spool in mA)."""

    name: str
    """As of `ehamj.control.channels`, ``valve_command MOUNT``, or ``force KEY`` and ``acceleration KEY`` with the
    key of its table."""
    unit: str
    samples: Array = field(repr=False)
    """(n,)"""
    role: Role = "output"
    component: str = ""
    """What the file calls it."""
    place: ForcePlace | None = None
    """Of a force, or of an accelerometer at a point."""
    full_scale: float | None = None
    """Of its converter, where that is known."""
    resolution: float | None = None
    """Step between neighbouring values, where the samples show one: 2⁻¹⁵ of the range of a 16-bit converter's."""


@dataclass(frozen=True)
class Measured:
    """Channels of a test, all with samples at ``begin`` + k/``rate``."""

    name: str
    rate: float
    """[Hz]"""
    channels: tuple[MeasuredChannel, ...]
    begin: float = 0.0
    """Time of the first sample on the file's own clock [s]."""
    usable_to: float = float("inf")
    """Frequency up to which all channels are believed [Hz]."""
    notes: tuple[str, ...] = ()

    @property
    def time(self) -> Array:
        """From the first sample on [s], (n,)."""
        return np.arange(self.channels[0].samples.size) / self.rate

    @property
    def duration(self) -> float:
        """Time that the samples cover [s]."""
        return self.channels[0].samples.size / self.rate

    @property
    def inputs(self) -> tuple[MeasuredChannel, ...]:
        """Channels that drive the model."""
        return tuple(one for one in self.channels if one.role == "input")

    @property
    def outputs(self) -> tuple[MeasuredChannel, ...]:
        """Channels that are compared with it."""
        return tuple(one for one in self.channels if one.role == "output")

    def __getitem__(self, name: str) -> MeasuredChannel:
        """A channel by its name.

        Raises:
            KeyError: if there is none.
        """
        found = next((one for one in self.channels if one.name == name), None)
        if found is None:
            raise KeyError(f"{name!r} is none of {', '.join(one.name for one in self.channels)}")
        return found


@dataclass(frozen=True)
class MeasuredResponses:
    """Frequency responses of a test in SI, each output over each input."""

    name: str
    frequency: Array = field(repr=False)
    """[Hz], (f,)"""
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    """Names, as of `MeasuredChannel`."""
    input_units: tuple[str, ...]
    output_units: tuple[str, ...]
    response: ComplexArray = field(repr=False)
    """(f, output, input); NaN where a pair was not measured."""
    variance: Array = field(repr=False)
    """E|error|² of the complex value, (f, output, input); each of its parts has half of it."""
    coherence: Array = field(repr=False)
    """γ² (f, output, input) [-]; NaN where it is not known."""
    places: tuple[ForcePlace | None, ...] = ()
    """Of the inputs that are forces, one per input."""
    notes: tuple[str, ...] = ()
    felt: tuple[ForcePlace | None, ...] = ()
    """Of the outputs that are accelerations at points, one per output."""
