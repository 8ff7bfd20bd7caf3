"""Residuals of measured modes: frequencies, damping ratios, shapes and the coupling of close modes, over deviations."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np

from ehamj.arrays import Array, ComplexArray
from ehamj.errors import InputError
from ehamj.identification.modal.compared import Pairs, coupling_deviation, likely, pairs_of, seen
from ehamj.identification.modal.computed import Computed, computed_many, computed_modes, in_closed_form
from ehamj.identification.modal.told import check_places, left_out, nothing_alike, pairing
from ehamj.identification.residual import Compared, Failed
from ehamj.identification.unknowns import Unknown, Values
from ehamj.linear.pairing import NOTHING, likely_pairs
from ehamj.measured.modes import MeasuredModes
from ehamj.scenario.model import Scenario

STAYS: Final = 1.0
"""By how much the logarithm of all pairs' likeness may rise before points of one batch pair otherwise than its first:
differences of neighbours are then of the same pairs."""


@dataclass
class ModalResiduals:
    """Measured modes against those of a scenario whose ``keys`` are looked for (`ehamj.identification.residual`).

    At every point those ``count`` pairs count which are the likeliest there; a measured mode that has no pair adds
    nothing, and since there are always as many pairs, nothing is gained by having none.
    """

    name: str
    held_out: bool
    scenario: Scenario
    keys: tuple[str, ...]
    measured: MeasuredModes
    strange: tuple[str, ...]
    """Measured modes that no rigid machine has, in words."""
    count: int
    everything: MeasuredModes
    """With those."""
    unknowns: tuple[Unknown, ...] = ()

    @classmethod
    def of(
        cls, name: str, held_out: bool, scenario: Scenario, keys: Sequence[str], measured: MeasuredModes
    ) -> "ModalResiduals":
        """For a machine, with as many pairs as it has before anything is fitted.

        Raises:
            InputError: if no measured mode is like any of the machine's.
        """
        computed = computed_modes(scenario)
        check_places(measured, computed.positions)
        strange = left_out(measured, computed.positions)
        words = tuple(f"the mode at {measured.names[k]} is left out: {why}" for k, why in strange.items())
        kept = measured.without(np.isin(np.arange(measured.frequency.size), list(strange)))
        count = len(likely_pairs(likely(kept, computed))) if kept.frequency.size else 0
        if not count:
            raise InputError(nothing_alike(measured, computed))
        return cls(name, held_out, scenario, tuple(keys), kept, words, count, measured)

    def compared(self, batch: Sequence[Values]) -> list[tuple[Compared, ...] | Failed]:
        """See `Residuals.compared`."""
        points = [{key: values[key] for key in self.keys} for values in batch]
        found: list[tuple[Compared, ...] | Failed] = []
        first: Pairs | None = None
        for computed in computed_many(self.scenario, points, self._closed):
            if isinstance(computed, InputError):
                found.append(Failed(str(computed)))
            elif computed.poles.size < self.count:
                found.append(Failed(f"{computed.poles.size} modes swing; {self.count} were measured"))
            else:
                pairs = self._pairs(computed, first)
                first = pairs if first is None else first
                found.append(self._channels(computed, pairs))
        return found

    def rough(self, batch: Sequence[Values], share: float = 1.0) -> list[tuple[Compared, ...] | Failed]:
        """The same: modes take no time."""
        return self.compared(batch)

    def found(self, values: Values) -> Mapping[str, Any]:
        """Pairs before and after."""
        before = pairing(self.everything, computed_modes(self.scenario))
        last = computed_many(self.scenario, [{key: values[key] for key in self.keys}], self._closed)[0]
        if isinstance(last, InputError):
            return {"before": before.to_dict()}
        after = pairing(self.everything, last)
        return {"method": self.measured.words, "before": before.to_dict(), "after": after.to_dict()}

    def _pairs(self, computed: Computed, first: Pairs | None) -> Pairs:
        """The likeliest pairs, or those of the batch's first point where they are about as likely."""
        best = pairs_of(self.measured, computed, self.count)
        if first is None or first == best or max(first.values()) >= computed.poles.size:
            return best
        logarithm = np.log(np.maximum(likely(self.measured, computed), NOTHING))
        rise = sum(logarithm[k, m] for k, m in best.items()) - sum(logarithm[k, m] for k, m in first.items())
        return first if rise < STAYS else best

    @cached_property
    def _closed(self) -> bool:
        return in_closed_form(self.scenario, self.keys)

    @cached_property
    def _coupling_deviation(self) -> Array:
        return coupling_deviation(self.measured)

    def _channels(self, computed: Computed, pairs: Pairs) -> tuple[Compared, ...]:
        """What is compared; the same channels at every point."""
        m, got = self.measured, seen(self.measured, computed, pairs)
        number = np.arange(m.frequency.size, dtype=float)
        damped = ~np.isnan(m.damping_ratio)
        channels = [_channel("frequency", "Hz", number, m.frequency, got.frequency, m.frequency_deviation)]
        if damped.any():
            ratios = (m.damping_ratio[damped], got.damping_ratio[damped], m.damping_deviation[damped])
            channels.append(_channel("damping ratio", "1", number[damped], *ratios))
        for n, sensor in enumerate(m.sensors.names):
            channels.append(
                _channel(f"shape {sensor}", "1", number, *self._real(m.shape[:, n], got.shape[:, n]), m.shape_deviation)
            )
        if (spread := self._coupling_deviation).size:
            nothing = np.zeros_like(got.coupling)
            channels.append(
                _channel("coupling", "Hz", np.arange(spread.size, dtype=float), nothing, got.coupling, spread)
            )
        return tuple(channels)

    def _real(self, measured: ComplexArray, predicted: ComplexArray) -> tuple[Any, Any]:
        return (measured.real, predicted.real) if self.measured.real else (measured, predicted)


def _channel(
    name: str,
    unit: str,
    number: Array,
    measured: Array | ComplexArray,
    predicted: Array | ComplexArray,
    deviation: Array,
) -> Compared:
    return Compared(name, unit, "number", number, measured, predicted, deviation)
