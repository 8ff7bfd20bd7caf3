"""The results that a report shows, and what is asked of them more than once."""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ehamj import plots
from ehamj.result import Result
from ehamj.scenario.model import Scenario

Array = NDArray[np.float64]
Results = Mapping[str, Result]
"""Results by label; the first is the one reported, the others are variants beside it."""


def colors_of(results: Results) -> dict[str, str]:
    """Colour of each result: the first passive one always has the same, the others follow in order."""
    passive = next((label for label, result in results.items() if result.scenario.control.kind == "passive"), None)
    others = iter((plots.BLUE, plots.GREEN, plots.PURPLE, plots.SKY, plots.ORANGE) * len(results))
    return {label: plots.VERMILLION if label == passive else next(others) for label in results}


def ground_parts(scenario: Scenario) -> tuple[Any, ...]:
    return getattr(scenario.ground, "parts", None) or (scenario.ground,)


def floor_moves(result: Result) -> bool:
    peak = result.summary.get("peak", {}).get("ground_velocity", {})
    return any(value for axes in peak.values() for value in axes.values())


def known(tables: Iterable[Mapping[str, float | None]]) -> list[float]:
    return [value for table in tables for value in table.values() if value is not None]
