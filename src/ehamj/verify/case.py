"""What a case of verification is, what came out of it, and how cases are registered and run."""

import math
import time as clock
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, NamedTuple

from ehamj.linear.machine import LinearModel, linear_model
from ehamj.registry import Registry
from ehamj.result import Result
from ehamj.run.simulate import simulate
from ehamj.scenario.model import Scenario


@dataclass(frozen=True)
class Subject:
    """What is verified: how a scenario is run, and how it is linearised. A test puts a wrong one here."""

    simulate: Callable[[Scenario], Result] = simulate
    linearise: Callable[[Scenario], LinearModel] = lambda scenario: linear_model(scenario.plant)

    def channels(self, scenario: Scenario, *names: str) -> list[Any]:
        """Values of some channels of a scenario's run, or ``time``."""
        dataset = self.simulate(scenario).dataset
        return [dataset[name].values for name in names]


class Finding(NamedTuple):
    """An error, in the case's unit, and what else is worth knowing."""

    error: float
    detail: str = ""


@dataclass(frozen=True)
class Case:
    """One comparison of ehamj with an independent solution."""

    name: str
    compares: str
    """What is compared with what."""
    source: str
    """Where the independent solution comes from."""
    unit: str
    """What the error is measured in."""
    tolerance: float
    why: str
    """Why the tolerance is what it is."""
    measure: Callable[[Subject], Finding]


@dataclass(frozen=True)
class CaseOutcome:
    """What a case gave. ``seconds`` includes independent solutions that later cases use again."""

    case: Case
    error: float
    detail: str
    seconds: float

    @property
    def passed(self) -> bool:
        """Whether the error is within the tolerance; a NaN is not."""
        return bool(self.error <= self.case.tolerance)

    def to_dict(self) -> dict[str, Any]:
        """As plain data; an error that is no finite number becomes null."""
        stated = {name: value for name, value in vars(self.case).items() if name != "measure"}
        error = self.error if math.isfinite(self.error) else None
        return stated | {"error": error, "passed": self.passed, "detail": self.detail, "seconds": self.seconds}


def run_case(case: Case, subject: Subject | None = None) -> CaseOutcome:
    """Measure a case; a simulation that fails is a case that fails."""
    began = clock.perf_counter()
    try:
        error, detail = case.measure(subject or Subject())
    except Exception as failure:  # whatever breaks, the other cases are still worth running
        error, detail = float("inf"), f"{type(failure).__name__}: {failure}"
    return CaseOutcome(case, error, detail, clock.perf_counter() - began)


CASES: Registry[Case] = Registry("verification case")
"""All cases in the order in which they are reported; `ehamj.verify.cases` lists their files."""


def case(
    name: str, compares: str, source: str, unit: str, tolerance: float, why: str
) -> Callable[[Callable[[Subject], Finding]], Callable[[Subject], Finding]]:
    """Decorator that registers what it decorates as the measure of a case; the arguments are those of `Case`."""

    def register(measure: Callable[[Subject], Finding]) -> Callable[[Subject], Finding]:
        CASES.add(name, Case(name, compares, source, unit, tolerance, why, measure))
        return measure

    return register


def verify(
    progress: Callable[[CaseOutcome], None] | None = None,
    cases: Iterable[Case] | None = None,
    subject: Subject | None = None,
) -> list[CaseOutcome]:
    """Run cases.

    Args:
        progress: called with each outcome as it comes.
        cases: which; all by default.
        subject: what is verified; ehamj itself by default.
    """
    outcomes = []
    for one in CASES.values() if cases is None else cases:
        outcomes.append(run_case(one, subject))
        if progress is not None:
            progress(outcomes[-1])
    return outcomes
