"""What a page is made of: figures, tables, and the results that it shows."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ehamj import plots
from ehamj.result import Result
from ehamj.scenario.model import Scenario

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
Results = Mapping[str, Result]
"""Results by label; the first is the one reported, the others are variants beside it."""


@dataclass(frozen=True)
class Picture:
    """A figure of the page: file name without ending, the section that it stands in, what is said below it."""

    name: str
    section: str
    figure: "Figure"
    caption: str = ""
    wide: bool = False
    """Whether it needs the whole width of the page; on a phone it scrolls."""


@dataclass(frozen=True)
class Table:
    """A table of the page. A row's first cell is its name; a row of one cell is a heading."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""
    kind: str = "numbers"
    """``numbers`` (to the right; ``numbers wide``: with long names) or ``words`` (to the left)."""
    badges: Sequence[str] = field(default=())
    """Of each row, a word that its last cell shows as a badge."""


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
