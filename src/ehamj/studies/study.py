"""What a study is: a question about a machine, the settings it is asked with, and the function that answers it."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any, Final, Generic, TypeVar

from pydantic import AfterValidator, Field

from ehamj.errors import did_you_mean
from ehamj.registry import Registry
from ehamj.scenario.explain import checked
from ehamj.scenario.model import Scenario
from ehamj.settings import Settings
from ehamj.studies.outcome import Outcome, Progress, silent

S = TypeVar("S", bound=Settings)
Answer = Callable[[Scenario, S, Progress], Outcome]

Positive = Annotated[float, Field(gt=0)]
WholeHertz = Annotated[float, Field(gt=0, multiple_of=1)]
"""A frequency of which a second has whole periods [Hz]."""


def _rising(limits: tuple[float, float]) -> tuple[float, float]:
    if not limits[0] < limits[1]:
        raise ValueError("must be two rising numbers")
    return limits


Range = Annotated[tuple[Positive, Positive], AfterValidator(_rising)]
"""Lowest and highest of a positive quantity."""


def among(names: Collection[str]) -> AfterValidator:
    """Validator of a name that must be one of these."""

    def known(name: str) -> str:
        if name not in names:
            raise ValueError(f"{did_you_mean(name, names)}must be one of {', '.join(names)}")
        return name

    return AfterValidator(known)


@dataclass(frozen=True)
class Study(Generic[S]):
    """A registered study. Call it with a scenario and its settings (by default its own)."""

    name: str
    question: str
    """What it answers, one line."""
    settings: type[S]
    """Its fields are the study's options on the command line."""
    answer: Answer[S]
    small: Mapping[str, Any]
    """Settings with which it takes a second, so that it can be tried."""

    def __call__(self, scenario: Scenario, settings: S | None = None, progress: Progress = silent) -> Outcome:
        """Answer the question for a scenario; the outcome holds the settings.

        Raises:
            InputError: if the scenario does not allow it.
        """
        given = self.settings() if settings is None else settings
        return replace(self.answer(scenario, given, progress), settings=given.model_dump(mode="json"))

    def with_settings(self, values: Mapping[str, Any]) -> S:
        """Settings from plain values, such as those that an outcome holds.

        Raises:
            InputError: if one is unknown or not allowed.
        """
        return checked(self.settings, values)


STUDIES: Final[Registry[Study[Any]]] = Registry("study")
"""All studies by name; `ehamj.studies.catalogue` fills it."""


def study(name: str, settings: type[S], question: str, small: Mapping[str, Any]) -> Callable[[Answer[S]], Study[S]]:
    """Decorator that registers a function as a study; its arguments are the fields of `Study`."""

    def register(answer: Answer[S]) -> Study[S]:
        found = Study(name, question, settings, answer, small)
        STUDIES.add(name, found)
        return found

    return register
