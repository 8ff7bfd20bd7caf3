"""What a file of a record holds: channels of samples on one clock."""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import ceil
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator

from ehamj.plant.axes import AXES
from ehamj.plant.points import NAME
from ehamj.records.units import Quantity
from ehamj.signals import Array


def _place(text: str) -> str:
    mount, _, axis = text.rpartition(" ")
    if axis not in AXES or (mount and not NAME.fullmatch(mount)):
        raise ValueError(f"must be one of {', '.join(AXES)}, or that of one mount by its name, such as 'front-left z'")
    return text


Place = Annotated[str, AfterValidator(_place)]
"""What a component moves: an axis of all mounts, or of one of them by its name, ``NAME z``."""
Response = Callable[[Array], NDArray[np.complex128]]

USABLE = 0.8
"""Share of the Nyquist frequency up to which a record is believed; above it the anti-alias filter bites."""


@dataclass(frozen=True)
class Channel:
    """One recorded component: finite samples (n,) at ``time`` + k/``rate``.

    The samples are SI of ``quantity``, or counts where ``response`` says how many counts one SI unit gives at
    frequencies [Hz]. Raises ValueError where samples are not finite or fewer than 16.
    """

    axis: Place
    name: str
    rate: float
    """Sampling rate [Hz]."""
    quantity: Quantity
    samples: Array = field(repr=False)
    time: float = 0.0
    """Time of the first sample, counted from the record's beginning [s]."""
    response: Response | None = None

    def __post_init__(self) -> None:
        if self.samples.ndim != 1 or self.samples.size < 16:
            raise ValueError(
                f"ground.file: channel {self.name} holds {self.samples.size} samples; at least 16 are needed"
            )
        wrong = np.flatnonzero(~np.isfinite(self.samples))
        if wrong.size:
            where = f"sample {wrong[0] + 1} (at {self.time + wrong[0] / self.rate:g} s)"
            raise ValueError(
                f"ground.file: channel {self.name} holds {wrong.size} values that are not finite, the first is {where} "
                f"= {self.samples[wrong[0]]}; every sample must be a finite number"
            )

    @property
    def end(self) -> float:
        """Time at which the last sample's interval ends [s]."""
        return self.time + self.samples.size / self.rate

    def section(self, begin: float, end: float) -> "Channel":
        """The part from ``begin`` to ``end`` [s], or as much of it as there is."""
        first = max(0, int((begin - self.time) * self.rate))
        last = min(self.samples.size, ceil((end - self.time) * self.rate) + 1)
        time = self.time + first / self.rate
        return Channel(self.axis, self.name, self.rate, self.quantity, self.samples[first:last], time, self.response)


@dataclass(frozen=True)
class Record:
    """What a file holds: channels on one clock that begins where the last of them begins, and remarks on reading."""

    name: str
    channels: tuple[Channel, ...]
    notes: tuple[str, ...] = ()

    @property
    def duration(self) -> float:
        """Time that every channel covers [s]."""
        return min(channel.end for channel in self.channels)
