"""Overlap of the valve: each of its four edges opens before or after null."""

from typing import Any, ClassVar, NamedTuple

from ehamj.compiled import kernel
from ehamj.isolator.component import Option
from ehamj.settings import quantity


class Openings(NamedTuple):
    """How far each edge is open [mA]: it feeds a chamber from the supply, or drains it to the tank."""

    feeds_1: float
    drains_1: float
    feeds_2: float
    drains_2: float


@kernel
def edge_openings(opening: float, stroke: float, own: Any) -> Openings:
    """An edge opens beyond its overlap (before null, where negative), and no further than ``stroke`` [mA]."""
    return Openings(
        min(max(opening - own.overlap_supply_1, 0.0), stroke),
        min(max(-opening - own.overlap_1_tank, 0.0), stroke),
        min(max(-opening - own.overlap_supply_2, 0.0), stroke),
        min(max(opening - own.overlap_2_tank, 0.0), stroke),
    )


class Overlap(Option):
    """Overlap of the metering edges; it has no kernel on the path, the edges' flows part here."""

    overlap: tuple[float, float, float, float] = quantity(
        (0.0, 0.0, 0.0, 0.0), "mA", "x_0", "overlap of edges supply–1, 1–tank, supply–2, 2–tank (negative: underlap)",
        "assumed",
    )  # fmt: skip

    takes: ClassVar[Any] = ("overlap_supply_1", "overlap_1_tank", "overlap_supply_2", "overlap_2_tank", "lapped")

    @classmethod
    def values_of(cls, isolator: Any) -> Any:
        """x_0 of each edge [mA], and 1 if any has one."""
        return cls.Values(*isolator.overlap, float(any(isolator.overlap)))
