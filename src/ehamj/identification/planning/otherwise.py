"""Tests that play nothing: the floor as it is, and the supply that is shut."""

from typing import Any, Final, Literal

from pydantic import Field

from ehamj.errors import InputError
from ehamj.ground.kinds import RestGround
from ehamj.identification.planning.candidate import Bench, CandidateSettings
from ehamj.identification.planning.trial import Trial
from ehamj.linear.machine import grounds
from ehamj.scenario.keys import plain
from ehamj.settings import NotNegative, Positive

SETTLE: Final = 1.0
"""Of a record of the floor, until the machine that began at rest moves as the one that never was [s]."""


class FloorCandidate(CandidateSettings):
    """The floor as the scenario has it, which is recorded at every mount, valves centred."""

    kind: Literal["floor"]

    @classmethod
    def usual(cls, bench: Bench) -> tuple[CandidateSettings, ...]:
        """Where the scenario's floor moves."""
        return () if isinstance(bench.machine.ground, RestGround) else (cls(kind="floor"),)

    def trial(self, bench: Bench) -> Trial:
        """See `CandidateSettings.trial`."""
        ground = bench.machine.ground
        if isinstance(ground, RestGround):
            raise InputError("plan.candidates: kind = 'floor': the scenario's floor is at rest; state [ground]")
        kind = getattr(ground, "kind", "")
        scenario = bench.quiet(ground=plain(ground))
        words = f"the floor as it is ([ground], kind {kind!r}) for {bench.duration:g} s, valves centred"
        sensor = bench.machine.sensors.ground
        measures = "acceleration" if sensor is None else sensor.measures
        unit = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s²"}[measures]
        names = [f"ground_{measures} {place}" for place in grounds(bench.machine.plant.mounts)]
        inputs = {name: {"channel": name, "unit": unit} for name in names}
        name = self.name or "floor"
        settle = min(SETTLE, 0.2 * bench.duration)
        return Trial(name, self.kind, words, scenario, "random", settle, seconds=bench.duration, inputs=inputs)


class LeakDownCandidate(CandidateSettings):
    """The supply is shut while valves are centred, and the chambers' oil leaks to the tank."""

    kind: Literal["leak-down"]
    mount: str | None = Field(None, description="mount whose branch is shut, by name; without: the whole supply")
    begin: NotNegative = Field(0.2, description="time at which it is shut [s]")
    watched: Positive = Field(2.0, description="time for which it is watched after that [s]")

    @classmethod
    def usual(cls, bench: Bench) -> tuple[CandidateSettings, ...]:
        """The whole supply."""
        return (cls(kind="leak-down"),)

    def trial(self, bench: Bench) -> Trial:
        """See `CandidateSettings.trial`."""
        fault: dict[str, Any] = {"kind": "supply-lost", "time": self.begin}
        if self.mount is not None:
            fault["mount"] = self.mount
        scenario = bench.quiet(fault=[fault], duration=self.begin + self.watched)
        where = "the supply" if self.mount is None else f"the branch of {self.mount}"
        words = (
            f"{where} is shut after {self.begin:g} s, valves centred, and pressures are watched for {self.watched:g} s"
        )
        name = self.name or "leak-down" + ("" if self.mount is None else f" {self.mount}")
        return Trial(
            name, self.kind, words, scenario, "nonlinear", seconds=scenario.duration, otherwise={"fault": [fault]}
        )
