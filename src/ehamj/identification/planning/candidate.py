"""What every kind of candidate has, and what it makes its trials from."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

from pydantic import Field

from ehamj.identification.planning.limits import Limits
from ehamj.identification.planning.trial import Trial
from ehamj.linear.machine import LinearModel, linear_model
from ehamj.scenario.load import changed
from ehamj.scenario.model import Scenario
from ehamj.settings import Settings

HIGHEST: Final = 0.2
"""Share of the logger's rate up to which a usual test excites: a spline through five samples a period is its signal."""


@dataclass(frozen=True)
class Bench:
    """The machine that tests are planned for, and what they may take."""

    machine: Scenario
    duration: float
    """Of a test, what is not compared included [s]."""
    rate: float
    """Of the logger [Hz]."""
    limits: Limits

    @cached_property
    def model(self) -> LinearModel:
        """About rest, valves centred."""
        return linear_model(self.machine.plant)

    def quiet(self, **tables: Any) -> Scenario:
        """The machine with valves held, on ground at rest, for a test's duration, but for what is given."""
        bare: dict[str, Any] = {
            "compare": [],
            "control": {"kind": "passive"},
            "ground": {"kind": "rest"},
            "force": [],
            "fault": [],
            "duration": self.duration,
            "record_rate": self.rate,
        }
        return changed(self.machine, bare | tables)


class CandidateSettings(Settings, ABC):
    """What a user writes in [[plan.candidates]] of some ``kind``; `ehamj.identification.planning.kinds` lists them."""

    kind: str
    name: str | None = Field(None, description="what it is called; without: after what it does", min_length=1)

    @classmethod
    @abstractmethod
    def usual(cls, bench: Bench) -> "tuple[CandidateSettings, ...]":
        """Sensible ones for a machine, where the user names none."""

    @abstractmethod
    def trial(self, bench: Bench) -> Trial:
        """The test as it would be made.

        Raises:
            InputError: if it cannot be, naming the key.
        """


def rounded(value: float) -> float:
    """A level that a person would set, three digits."""
    return float(f"{value:.3g}")


def place(point: Any, direction: Any) -> Mapping[str, Any]:
    """Where a force acts, as [[force]] has it."""
    return {"point": point if isinstance(point, str) else list(point), "direction": list(direction)}


AXIS_WORDS: Final[dict[tuple[float, ...], str]] = {(1.0, 0.0, 0.0): "x", (0.0, 1.0, 0.0): "y", (0.0, 0.0, 1.0): "z"}


def words_of(point: Any, direction: Any) -> str:
    """Where a force acts, in words."""
    where = point if isinstance(point, str) else "[" + ", ".join(f"{one:g}" for one in point) + "]"
    along = AXIS_WORDS.get(tuple(map(float, direction)), "[" + ", ".join(f"{one:g}" for one in direction) + "]")
    return f"{where} along {along}"
