"""A control law as a plain Python function: slower, the same semantics."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ehamj.arrays import Array
from ehamj.control.converter import Sampled
from ehamj.control.lines import Line
from ehamj.errors import InputError

LawFunction = Callable[[float, Array, Array], Any]


@dataclass(frozen=True)
class PythonController(Sampled):
    """A law as ``function(time, measured, limited)`` → commands [V], one per valve, called at each sample.

    ``time`` [s] is that of the sample, ``measured`` (inputs,) are the channels of ``inputs`` in SI, ``limited``
    (valves,) is what fade and range took from the commands of the sample before, applied − wanted [V] (zero at first),
    for the function's own anti-windup. Both arrays are valid during the call only. If the function has a method
    ``reset``, that is called before each run. Clock and converter are those of `ehamj.Controller`.

    Raises:
        InputError: if ``function`` is none, a channel is unknown, or a number is out of its range.
    """

    function: LawFunction = field(repr=False)
    inputs: tuple[str, ...]
    period: float = 1e-4
    delay: float | None = None

    def __post_init__(self) -> None:
        if not callable(self.function):
            raise InputError(f"controller.function = {self.function!r}: must be a function of time, measured, limited")
        super().__post_init__()

    @property
    def states(self) -> int:
        """A function's states are its own affair."""
        return 0

    @property
    def lines(self) -> tuple[Line, ...]:
        """Lines that it follows are its own affair."""
        return ()

    def wanted(self, time: float, measured: Array, limited: Array) -> Array:
        """The function's commands, checked, (valves,) [V].

        Raises:
            ValueError: if they are not so many finite numbers.
        """
        volts = np.asarray(self.function(time, measured, limited), float)
        if volts.shape != (len(self.mounts),) or not np.isfinite(volts).all():
            raise ValueError(f"it returned {volts.tolist()}, which is not {len(self.mounts)} finite numbers")
        return volts
