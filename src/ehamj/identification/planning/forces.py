"""Forces on the machine: blows of a hammer, a shaker, and loads that are held."""

import math
from collections.abc import Iterator
from typing import Any, Literal

import numpy as np
from pydantic import Field

from ehamj.errors import InputError
from ehamj.forces.kinds import load_of
from ehamj.identification.planning.candidate import HIGHEST, Bench, CandidateSettings, place, words_of
from ehamj.identification.planning.trial import Trial
from ehamj.rig.low_peak import low_peak, zippered
from ehamj.settings import Band, Direction, Positive, Settings, Vector3

AXES: tuple[Vector3, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def reachable(bench: Bench) -> Iterator[tuple[str | Vector3, Vector3]]:
    """Places and directions at which a person could push: the first named point along each axis, and above the first
    mount, where a vertical force turns the machine as well."""
    machine = bench.machine
    named = next(iter(machine.points), "cg")
    yield from ((named, axis) for axis in AXES)
    x, y, z = machine.plant.positions[0]
    yield (float(x), float(y), float(z)), AXES[2]


def pushing(point: Any, direction: Any) -> dict[str, dict[str, Any]]:
    """The recorded force as [test.measurement] has it."""
    return {"force": {"force": dict(place(point, direction)), "unit": "N"}}


class HammerCandidate(CandidateSettings):
    """Half-sine blows of an instrumented hammer, whose force is recorded."""

    kind: Literal["hammer"]
    point: str | Vector3 = Field(
        "cg", description="a name in [points], 'cg', or a place from the mount plane's centre [m]"
    )
    direction: Direction = Field((0.0, 0.0, 1.0), description="direction of the blow (any length)")
    peak: Positive | None = Field(None, description="peak of the force; without: plan.limits.force [N]")
    pulse_time: Positive = Field(5e-3, description="duration of a blow [s]")
    interval: Positive = Field(2.0, description="time from one blow to the next [s]")

    @classmethod
    def usual(cls, bench: Bench) -> tuple[CandidateSettings, ...]:
        """At each place that can be reached."""
        return tuple(cls(kind="hammer", point=point, direction=axis) for point, axis in reachable(bench))

    def trial(self, bench: Bench) -> Trial:
        """See `CandidateSettings.trial`."""
        peak = min(self.peak or bench.limits.force, bench.limits.force)
        blows = max(1, math.floor(bench.duration / self.interval))
        force = {"kind": "hammer", "peak": peak, "pulse_time": self.pulse_time, "begin": 0.1, "blows": blows,
                 "interval": self.interval, **place(self.point, self.direction)}  # fmt: skip
        where = words_of(self.point, self.direction)
        words = f"{blows} blows of {peak:g} N and {1e3 * self.pulse_time:g} ms at {where}, {self.interval:g} s apart"
        scenario = bench.quiet(force=[force])
        return Trial(
            self.name or f"hammer {where}", self.kind, words, scenario, "decaying", seconds=bench.duration,
            inputs=pushing(self.point, self.direction),
        )  # fmt: skip


class ShakerCandidate(CandidateSettings):
    """A multisine force of low peak, as of a shaker whose force is recorded."""

    kind: Literal["shaker"]
    point: str | Vector3 = Field(
        "cg", description="a name in [points], 'cg', or a place from the mount plane's centre [m]"
    )
    direction: Direction = Field((0.0, 0.0, 1.0), description="direction of the force (any length)")
    band: Band = Field((2.0, 200.0), description="lowest and highest frequency [Hz]")
    lines: int = Field(40, ge=1, le=200, description="lines, at most")
    peak: Positive | None = Field(None, description="peak of the force; without: a tenth of plan.limits.force [N]")

    @classmethod
    def usual(cls, bench: Bench) -> tuple[CandidateSettings, ...]:
        """Above the first mount, vertical."""
        point, axis = list(reachable(bench))[-1]
        return (cls(kind="shaker", point=point, direction=axis, band=(2.0, min(200.0, HIGHEST * bench.rate))),)

    def trial(self, bench: Bench) -> Trial:
        """See `CandidateSettings.trial`."""
        period = max(1.0, math.ceil(2.0 / self.band[0]))
        if self.band[1] > 0.5 * bench.rate or 2.0 * period > bench.duration:
            raise InputError(
                f"plan.candidates: band = {list(self.band)} Hz: must end below half of plan.rate = {bench.rate:g} Hz, "
                f"and its period of {period:g} s fit twice into plan.duration = {bench.duration:g} s"
            )
        peak = min(self.peak or 0.1 * bench.limits.force, bench.limits.force)
        one = low_peak(period, zippered(*self.band, period, self.lines, 1)[0])
        one = one.scaled(peak / one.peak)
        force = {name: value for name, value in one.command([]).items() if name != "mounts"}
        whole = math.floor(bench.duration / period + 1e-9) * period
        where = words_of(self.point, self.direction)
        scenario = bench.quiet(force=[{**force, **place(self.point, self.direction)}], duration=whole)
        words = (
            f"multisine {self.band[0]:g}–{self.band[1]:g} Hz of a shaker at {where}, {one.harmonics.size} lines, "
            f"peak {peak:g} N, crest factor {one.crest_factor:.2f}"
        )
        name = self.name or f"shaker {self.band[0]:g}-{self.band[1]:g} Hz {where}"
        inputs = pushing(self.point, self.direction)
        return Trial(name, self.kind, words, scenario, "periodic", period, {"force": one}, seconds=whole, inputs=inputs)


class HeldLoad(Settings):
    """One load that is held."""

    point: str | Vector3 = Field(
        "cg", description="a name in [points], 'cg', or a place from the mount plane's centre [m]"
    )
    direction: Direction = Field((0.0, 0.0, -1.0), description="direction of the load (any length)")
    force: Positive | None = Field(None, description="the load; without: plan.limits.force [N]")


class StaticCandidate(CandidateSettings):
    """Loads that are held one after the other until the machine rests; readings are averaged with and without each."""

    kind: Literal["static"]
    loads: tuple[HeldLoad, ...] = Field(description="loads, one after the other", min_length=1)
    average: Positive = Field(1.0, description="time that each reading is averaged over [s]")

    @classmethod
    def usual(cls, bench: Bench) -> tuple[CandidateSettings, ...]:
        """At each place that can be reached."""
        loads = tuple(HeldLoad(point=point, direction=axis) for point, axis in reachable(bench))
        return (cls(kind="static", loads=loads),)

    def trial(self, bench: Bench) -> Trial:
        """See `CandidateSettings.trial`."""
        machine = bench.machine
        patterns, written = [], []
        for one in self.loads:
            force = one.force or bench.limits.force
            table = {"kind": "sine", "amplitude": 1.0, "frequency": 1.0, **place(one.point, one.direction)}
            scenario = bench.quiet(force=[table])  # which says what place it is
            pattern = load_of(scenario.force, scenario.points, machine.plant.machine.cg, 1.0, 0).patterns[0]
            patterns.append(tuple((force * np.asarray(pattern)).tolist()))
            written.append({"force": force, **place(one.point, one.direction)})
        where = "; ".join(f"{load['force']:g} N at {words_of(load['point'], load['direction'])}" for load in written)
        words = f"{len(written)} loads held, each reading averaged over {self.average:g} s: {where}"
        scenario = bench.quiet(duration=self.average)
        seconds = 2.0 * self.average * len(written)
        return Trial(
            self.name or "static loads", self.kind, words, scenario, "rest", 0.0, {}, tuple(patterns), tuple(written),
            seconds,
        )  # fmt: skip
