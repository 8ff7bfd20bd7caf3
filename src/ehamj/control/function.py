"""A control law as a plain Python function: slower, the same semantics."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ehamj.control.law import check_clock, check_converter
from ehamj.errors import InputError
from ehamj.plant.mounts import MOUNTS, N_MOUNTS

Array = NDArray[np.float64]

LawFunction = Callable[[float, Array, Array], Any]


@dataclass(frozen=True)
class PythonController:
    """A law as ``function(time, measured, limited)`` → four commands [V], called at each sample.

    ``time`` [s] is that of the sample, ``measured`` (inputs,) are the channels of ``inputs`` in SI, ``limited`` (4,) is
    what fade and range took from the commands of the sample before, applied − wanted [V] (zero at first), for the
    function's own anti-windup. Both arrays are valid during the call only. If the function has a method ``reset``, that
    is called before each run. Period, delay, range, resolution, switch-on and zero of
    the readings are those of `ehamj.Controller`.

    Raises:
        InputError: if ``function`` is none, a channel is unknown, or a number is out of its range.
    """

    function: LawFunction = field(repr=False)
    inputs: tuple[str, ...]
    period: float = 1e-4
    delay: float | None = None
    voltage_limit: float = 10.0
    bits: int | None = 16
    switch_on: float = 0.0
    fade: float = 0.0
    from_rest: bool = False

    def __post_init__(self) -> None:
        if not callable(self.function):
            raise InputError(f"controller.function = {self.function!r}: must be a function of time, measured, limited")
        object.__setattr__(self, "inputs", tuple(self.inputs))
        check_clock(self.inputs, self.period, self.delay)
        check_converter(self.voltage_limit, self.bits, self.switch_on, self.fade)

    @property
    def latency(self) -> float:
        """Time from a sample to its command [s]."""
        return self.period if self.delay is None else self.delay

    @property
    def states(self) -> int:
        """A function's states are its own affair."""
        return 0

    @property
    def parts(self) -> tuple["PythonController", ...]:
        """The laws that run side by side: this one alone."""
        return (self,)

    def reset(self) -> None:
        """Let the function begin anew, if it can."""
        reset = getattr(self.function, "reset", None)
        if callable(reset):
            reset()

    def wanted(self, time: float, measured: Array, limited: Array) -> Array:
        """The function's commands, checked, (4,) [V].

        Raises:
            ValueError: if they are not four finite numbers.
        """
        volts = np.asarray(self.function(time, measured, limited), float)
        if volts.shape != (N_MOUNTS,) or not np.isfinite(volts).all():
            raise ValueError(f"it returned {volts.tolist()}, which is not {len(MOUNTS)} finite numbers")
        return volts
