"""What a case of verification is, and what came out of it."""

import time as clock
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ehamj.linear.machine import LinearModel, linear_model
from ehamj.result import Result
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario

Array = NDArray[np.float64]


def _linearise(scenario: Scenario) -> LinearModel:
    return linear_model(scenario.plant)


@dataclass(frozen=True)
class Subject:
    """What is verified: how a scenario is run, and how it is linearised. A test puts a wrong one here."""

    simulate: Callable[[Scenario], Result] = simulate
    linearise: Callable[[Scenario], LinearModel] = _linearise


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
class Outcome:
    """What a case gave. ``seconds`` includes independent solutions that later cases use again."""

    name: str
    compares: str
    source: str
    error: float
    tolerance: float
    unit: str
    why: str
    passed: bool
    detail: str
    seconds: float

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return asdict(self)


def run_case(case: Case, subject: Subject | None = None) -> Outcome:
    """Measure a case; a simulation that fails is a case that fails."""
    began = clock.perf_counter()
    try:
        error, detail = case.measure(subject or Subject())
    except Exception as failure:  # whatever breaks, the other cases are still worth running
        error, detail = float("inf"), f"{type(failure).__name__}: {failure}"
    passed = bool(error <= case.tolerance)  # not so for a NaN
    seconds = clock.perf_counter() - began
    return Outcome(
        case.name, case.compares, case.source, error, case.tolerance, case.unit, case.why, passed, detail, seconds
    )


def scenario_of(isolator: dict[str, Any] | None = None, **table: Any) -> Scenario:
    """A scenario whose four mounts have one kind of actuator; without gravity and with tied plates where not stated."""
    return parse_scenario({"gravity": 0.0, "plates": "tied", "actuators": {"isolator": isolator or {}}, **table})


def open_loop(*signals: dict[str, Any]) -> dict[str, Any]:
    """A table [control] with open-loop commands."""
    return {"kind": "open-loop", "signals": list(signals)}


def chamber_pressures(result: Result) -> Array:
    """Pressures (time, mount, chamber) [Pa]."""
    return result.dataset["chamber_pressure"].values


def fitted_order(steps: Array, errors: Array) -> float:
    """Slope of the error over the step, both logarithmic."""
    return float(np.polyfit(np.log(steps), np.log(errors), 1)[0])
