"""What is known of one design, and what the columns of its row are."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from ehamj.merits.merit import Failed


@dataclass(frozen=True)
class Column:
    """A value or a merit that designs have: its ``name`` (dotted), ``unit`` and what it is."""

    name: str
    unit: str
    role: Literal["value", "merit"]
    text: str = ""

    @property
    def head(self) -> str:
        """What stands above it in a table: the name with its unit."""
        return f"{self.name} [{self.unit}]"


@dataclass(frozen=True)
class Row:
    """One design and what it came out with."""

    number: int
    stage: str
    """Of the study, such as "search"."""
    parent: int | None
    """Number of the design that it is a variation of."""
    values: Mapping[str, Any]
    """What it has that is not the scenario's, by dotted key."""
    merits: Mapping[str, float]
    """Those that were found, by name; NaN where one is not defined."""
    failed: Failed | None = None
    """Why merits that were wanted are missing."""
    seconds: float = 0.0
    """What finding them took, its share of its block's time [s]."""
