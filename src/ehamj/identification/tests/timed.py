"""A record compared in time: the nonlinear engine is driven as the rig was, and shows the same channels."""

import math
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from ehamj.arrays import Array
from ehamj.errors import InputError
from ehamj.identification.residual import Compared, Failed, Residuals
from ehamj.identification.runs import Histories, histories
from ehamj.identification.shifted import HALF, later, later_slope, lost, thinned
from ehamj.identification.tests.test import Context
from ehamj.identification.unknowns import Unknown, Values
from ehamj.scenario.model import Scenario

FINE: Final = 4000.0
"""Rate that a run records at least, where the logger's is higher: valves and oil let nothing through at half of it
[Hz]."""
LATEST: Final = 0.02
"""Delay of a channel at most, earlier or later [s]."""
FEWEST: Final = 40
"""Samples that a beginning has at least."""
ROUGHLY: Final = 2.0
"""Beginning of a record, behind what is not compared, that tells where to begin [s]."""


@dataclass(frozen=True)
class Output:
    """A channel that is compared, and which of its sensor is not known."""

    name: str
    """ehamj's name of the channel."""
    unit: str
    samples: Array = field(repr=False)
    """(n,), SI."""
    offset: str = ""
    """Name of the unknown offset; empty: there is none."""
    gain: str = ""
    delay: str = ""

    def unknowns(self, test: str) -> tuple[Unknown, ...]:
        """Those of its sensor."""
        size = float(np.std(self.samples)) or 1.0
        found = []
        if self.offset:
            found.append(Unknown(self.offset, self.unit, 0.0, -math.inf, math.inf, test=test, size=size, closed=True))
        if self.gain:
            found.append(Unknown(self.gain, "1", 1.0, 0.1, 10.0, test=test, closed=True))
        if self.delay:
            found.append(Unknown(self.delay, "s", 0.0, -LATEST, LATEST, test=test, size=1e-3, closed=True))
        return tuple(found)


class TimeResiduals:
    """See `ehamj.identification.residual.Residuals`."""

    def __init__(
        self,
        name: str,
        held_out: bool,
        scenario_at: Callable[[Values], Scenario],
        driving: Sequence[Unknown],
        outputs: Sequence[Output],
        clock: "Clock",
        context: Context,
        begins: Residuals | None = None,
        stated: bool = False,
    ) -> None:
        """What was measured, and what it is compared with.

        Args:
            name: of the test.
            held_out: whether it only validates.
            scenario_at: the scenario of the test at a point, of `Clock.recorded` rows per second, as long as it.
            driving: unknowns of the inputs (gains, delays), which the scenario has.
            outputs: channels that are compared.
            clock: of the record, and what of it is compared.
            context: parameters that are looked for, and threads that step runs.
            begins: tells where to begin, in place of the record's beginning.
            stated: whether the scenario states its step.
        """
        self.stated = stated
        self.name, self.held_out = name, held_out
        self.outputs, self.clock, self.threads = tuple(outputs), clock, context.threads
        self.unknowns = (*driving, *(one for output in outputs for one in output.unknowns(name)))
        self._scenario_at, self._begins, self._moving = (
            scenario_at,
            begins,
            (*context.keys, *(one.name for one in driving)),
        )
        self._measured = [clock.of_measured(output.samples) for output in outputs]

    def compared(self, batch: Sequence[Values]) -> list[tuple[Compared, ...] | Failed]:
        """See `Residuals.compared`."""
        return self._compared(batch, None)

    def rough(self, batch: Sequence[Values], share: float = 1.0) -> list[tuple[Compared, ...] | Failed]:
        """The beginning of the record alone, or the linear model."""
        if self._begins is not None:
            return self._begins.rough(batch, share)
        return self._compared(batch, self.clock.until(ROUGHLY, share))

    def finer(self, values: Values, factor: int) -> tuple[Compared, ...] | Failed:
        """All channels at a point, of a run with so many steps in one."""
        scenario = self._scenario_at(values)
        assert scenario.timestep != "auto"
        fine = scenario.model_copy(update={"timestep": scenario.timestep / factor})
        (ran,) = histories([fine], [output.name for output in self.outputs], self.threads)
        return self._seen(ran, values)

    def found(self, values: Values) -> Mapping[str, Any]:
        """Nothing else."""
        return {}

    def _compared(self, batch: Sequence[Values], until: float | None) -> list[tuple[Compared, ...] | Failed]:
        driven: dict[Hashable, Values] = {}
        keys = []
        for values in batch:  # what only sensors differ in is one run
            key = tuple(values[name] for name in self._moving)
            driven.setdefault(key, values)
            keys.append(key)
        ran = dict(zip(driven, self._run(list(driven.values()), until), strict=True))
        return [self._seen(ran[key], values) for key, values in zip(keys, batch, strict=True)]

    def _run(self, batch: Sequence[Values], until: float | None) -> list[Histories | Failed]:
        scenarios: list[Scenario] = []
        refused: dict[int, Failed] = {}
        for number, values in enumerate(batch):
            try:
                scenario = self._scenario_at(values)
            except InputError as error:
                refused[number] = Failed(str(error))
                continue
            if until is not None and until < scenario.duration:
                scenario = scenario.model_copy(update={"duration": until})
            scenarios.append(scenario)
        ran = iter(histories(scenarios, [output.name for output in self.outputs], self.threads))
        return [refused[number] if number in refused else next(ran) for number in range(len(batch))]

    def _seen(self, run: Histories | Failed, values: Values) -> tuple[Compared, ...] | Failed:
        if isinstance(run, Failed):
            return run
        return tuple(
            self._channel(output, measured, run[output.name], values)
            for output, measured in zip(self.outputs, self._measured, strict=True)
        )

    def _channel(self, output: Output, measured: Array, history: Array, values: Values) -> Compared:
        """As the sensor shows it: later by its delay, times its gain, beside its offset."""
        clock = self.clock
        gain = values[output.gain] if output.gain else 1.0
        moved = later(history, values[output.delay] * clock.recorded) if output.delay else history
        own = clock.of_history(moved)
        part = clock.part(min(own.size, measured.size))
        slopes: dict[str, Array] = {}
        if output.gain:
            slopes[output.gain] = own[part]
        if output.offset:
            slopes[output.offset] = np.ones(own[part].size)
        if output.delay:
            rate = later_slope(history, values[output.delay] * clock.recorded) * clock.recorded
            slopes[output.delay] = gain * clock.of_history(rate)[part]
        predicted = gain * own[part] + (values[output.offset] if output.offset else 0.0)
        times = np.arange(own.size)[part] / clock.compared
        nobody = np.full(times.size, np.nan)
        return Compared(output.name, output.unit, "time", times, measured[part], predicted, nobody, slopes)


@dataclass(frozen=True)
class Clock:
    """Rates of a test: the logger's ``rate``, of rows that a run ``recorded``, and of what is ``compared`` [Hz]. Both
    measured and predicted are thinned alike from the second to the third."""

    rate: float
    samples: int
    """Of the logger."""
    settle: float
    """At the beginning, not compared [s]."""
    late: bool
    """Whether a channel's delay is not known."""
    wanted: float
    """Rate that is enough to compare [Hz]."""
    faded: float = 0.0
    """Time at each end over which what drives the machine fades [s]."""

    @property
    def first(self) -> int:
        """Samples of the logger per row."""
        return max(1, int(self.rate / FINE + 1e-9))

    @property
    def second(self) -> int:
        """Rows per compared sample."""
        return max(1, int(self.recorded / self.wanted + 1e-9))

    @property
    def recorded(self) -> float:
        """[Hz]"""
        return self.rate / self.first

    @property
    def compared(self) -> float:
        """[Hz]"""
        return self.recorded / self.second

    @property
    def duration(self) -> float:
        """From the first sample to the last [s]."""
        return (self.samples - 1) / self.rate

    def of_measured(self, samples: Array) -> Array:
        """What the logger wrote, at the rate that is compared."""
        return thinned(thinned(samples, self.first), self.second)

    def of_history(self, rows: Array) -> Array:
        """What a run recorded, at the rate that is compared."""
        return thinned(rows, self.second)

    @property
    def margin(self) -> float:
        """What filters, delays and fading spoil at each end [s]."""
        spoilt = self.faded + lost(self.first) / self.rate + lost(self.second) / self.recorded
        return spoilt + (LATEST + HALF / self.recorded if self.late else 0.0)

    def until(self, most: float, share: float) -> float:
        """End of a share of the record's beginning, of ``most`` seconds that count at most [s]."""
        begin = max(self.settle, self.margin)
        whole = min(most, self.duration - self.margin - begin)
        return begin + max(share * whole, min(whole, FEWEST / self.compared)) + self.margin

    def part(self, size: int) -> slice:
        """Of so many compared samples those that count: behind what settles, and away from what filters spoil."""
        margin = self.margin
        begin = math.ceil(max(self.settle, margin) * self.compared - 1e-9)
        return slice(begin, max(begin, size - math.ceil(margin * self.compared - 1e-9)))
