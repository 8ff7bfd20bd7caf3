"""When a digital law samples, and the converters between it and the valves."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, Self

import numpy as np

from ehamj.bounds import check_magnitude
from ehamj.control.channels import UnknownChannelError, check_channel, valve_commands
from ehamj.control.clock import MOST_WAITING, SHORTEST, waits_in_time
from ehamj.control.learners import Learner, strokes
from ehamj.control.spools import KnownSpool, positions
from ehamj.control.valves import KnownValve, measured
from ehamj.errors import InputError
from ehamj.plant.mounts import MOUNTS
from ehamj.settings import SHORTEST_FADE


@dataclass(frozen=True, kw_only=True)
class Converter:
    """Commands are limited to ±``voltage_limit`` [V] and rounded to ``bits``, one converter per valve.

    Until ``switch_on`` [s] the valves get zero, and over the ``fade`` [s] that follows the share 3s² − 2s³ of the
    commands. Laws that run side by side share one: there is one converter per valve, and one reading per channel.

    Raises:
        InputError: if a number is out of its range.
    """

    voltage_limit: float = 10.0
    bits: int | None = 16
    switch_on: float = 0.0
    fade: float = 0.0
    from_rest: bool = False
    """Readings of displacements, strokes and pressures count from where the machine stands at the start; without,
    strokes and displacements count from unloaded membranes, and pressures are absolute."""
    mounts: tuple[str, ...] = MOUNTS
    """Names of the mounts whose valves are commanded, in order."""
    valves: tuple[KnownValve, ...] = ()
    """What is known of each valve and made good before the converter; none: nothing is."""
    learners: tuple[Learner, ...] = ()
    """What is known of each mount's isolator, of which it learns; none: nothing is learnt."""

    spools: tuple[KnownSpool, ...] = ()
    """What is known of each valve's spool, behind whose position a loop is closed; none: none is."""

    def __post_init__(self) -> None:
        _must(0.0 < self.voltage_limit < np.inf, "voltage_limit", self.voltage_limit, "a positive number")
        whole = self.bits is None or (isinstance(self.bits, int) and 2 <= self.bits <= 52)
        _must(whole, "bits", self.bits, "a whole number from 2 to 52, or none")
        for name in ("switch_on", "fade"):
            _must(0.0 <= getattr(self, name) < np.inf, name, getattr(self, name), "zero or positive [s]")
        if 0.0 < self.fade < SHORTEST_FADE:
            raise InputError(f"controller.fade = {self.fade:g}: must be zero or at least {SHORTEST_FADE:g} s")
        for name in ("valves", "learners", "spools"):
            each, count = getattr(self, name), len(self.mounts)
            _must(len(each) in (0, count), name, f"{len(each)} of them", f"one per mount, {count}, or none")
        if self.learners and not self.valves:
            raise InputError("controller.learners: learn of valves that are known; give controller.valves too")

        if len({(one.period, one.delay) for one in self.spools}) > 1:
            raise InputError("controller.spools: period or delay differs from one to another; all must have the same")

    @property
    def converter(self) -> "Converter":
        """The converter by itself."""
        return Converter(**{part.name: getattr(self, part.name) for part in fields(Converter)})

    @property
    def resolution(self) -> float:
        """Step of the commands [V]; 0: exact."""
        return 0.0 if self.bits is None else 2.0 * self.voltage_limit / 2**self.bits

    @property
    def measures(self) -> tuple[str, ...]:
        """Channels that are read, as they are and not from rest, to make good what is known of the valves, and to feed
        back their spools."""
        known = measured(self.valves, self.mounts, bool(self.learners))
        return (*known, *positions(self.spools, self.mounts))

    @property
    def outputs(self) -> tuple[str, ...]:
        """Channels of the commands."""
        return valve_commands(self.mounts)


class Sampled(Converter):
    """A law that reads ``inputs`` every ``period`` [s]; its commands act ``delay`` [s] later (without: one period)."""

    inputs: tuple[str, ...]
    period: float
    delay: float | None

    def __post_init__(self) -> None:
        object.__setattr__(self, "inputs", tuple(self.inputs))
        for name in self.inputs:
            try:
                check_channel(name, self.mounts)
            except UnknownChannelError as error:
                raise InputError(f"controller.inputs: {error}") from error
        again = [name for name in dict.fromkeys(self.inputs) if self.inputs.count(name) > 1]
        if again:
            raise InputError(f"controller.inputs: {again[0]!r} stands there twice; each channel must be there once")
        _must(SHORTEST <= self.period < np.inf, "period", self.period, f"at least {SHORTEST:g} s")
        _plausible("period", self.period, "s")
        waits = f"zero, or from {SHORTEST:g} to 1 s (one period where that is longer), at most {MOST_WAITING} periods"
        _must(waits_in_time(self.delay, self.period), "delay", self.delay, waits)
        super().__post_init__()
        twice = [name for name in self.measures if self.from_rest and name in self.inputs]
        if twice:
            instead = "read load_pressure instead, or " if "pressure" in twice[0] else ""
            raise InputError(
                f"controller.inputs: {twice[0]!r} counts from rest, and what is known of the valves takes it as it is; "
                f"{instead}set from_rest = false"
            )

    @property
    def reads(self) -> tuple[str, ...]:
        """Every channel that is measured, those of the stage before the converter last."""
        return reads(self.inputs, self)

    @property
    def latency(self) -> float:
        """Time from a sample to its command [s]."""
        return self.period if self.delay is None else self.delay

    @property
    def parts(self) -> tuple[Self, ...]:
        """The laws that run side by side: this one alone."""
        return (self,)


def reads(inputs: tuple[str, ...], converter: Converter) -> tuple[str, ...]:
    """Channels that laws with these ``inputs`` and their converter measure, each once, its own last."""
    more = strokes(converter.mounts) if converter.learners else ()
    return tuple(dict.fromkeys((*inputs, *more, *converter.measures)))


def check_mounts(law: Converter, mounts: Sequence[str]) -> None:
    """Refuse a law for other valves than those of a plant's mounts, in their order.

    Raises:
        InputError: if it is.
    """
    if tuple(law.mounts) != tuple(mounts):
        raise InputError(
            f"controller.outputs: the law commands {', '.join(law.mounts)}, and the machine stands on "
            f"{', '.join(mounts)}; they must be the same, in the same order"
        )


def difference(laws: Sequence[Converter], more: Sequence[str] = ()) -> tuple[str, Any, Any] | None:
    """The first setting of their converters, or of ``more``, in which laws differ: its name, and both values."""
    for name in (*more, *(part.name for part in fields(Converter))):
        for law in laws[1:]:
            if getattr(law, name) != getattr(laws[0], name):
                return name, getattr(laws[0], name), getattr(law, name)
    return None


def _plausible(name: str, value: float, unit: str) -> None:
    """Refuse a number that nothing of its unit has."""
    try:
        check_magnitude(value, unit)
    except ValueError as error:
        raise InputError(f"controller.{name} = {value}: {error}") from None


def _must(good: Any, name: str, value: Any, be: str) -> None:
    """Refuse a setting that is not good."""
    if not good:
        raise InputError(f"controller.{name} = {value}: must be {be}")
