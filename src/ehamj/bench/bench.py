"""All timings together: the parts, in the order in which they are listed here."""

from collections.abc import Iterable, Mapping
from typing import Any

from ehamj.bench import (  # noqa: F401  # isort: skip
    engines,
    lanes,
    controller,
    growth,
    studies,
    stages,
    designs,
    peer,
)
from ehamj.bench.parts import PARTS, Effort, Figures, Part
from ehamj.bench.reading import Table
from ehamj.plots.style import Figure
from ehamj.plots.timings import timings_chart
from ehamj.run.progress import Progress, silent

__all__ = ["PARTS", "bench", "bench_chart", "bench_tables", "chosen", "measured", "together"]


def chosen(names: Iterable[str] = (), more: Iterable[str] = ()) -> list[Part]:
    """Parts by name, in their order; without names all but those that have to be asked for. ``more`` come in any case.

    Raises:
        InputError: if there is no such part.
    """
    named = [PARTS.find(name) for name in names] or [one for one in PARTS.values() if not one.asked]
    wanted = {one.name for one in named} | {PARTS.find(name).name for name in more}
    return [one for one in PARTS.values() if one.name in wanted]


def bench(
    repetitions: int = 5, parts: Iterable[Part] = (), progress: Progress = silent, share: float = 1.0
) -> dict[str, Any]:
    """What the simulator takes: seconds, ratios, errors; the keys' names say their units.

    Args:
        repetitions: of each timing; its median is given.
        parts: what to time (`chosen`); by default what `chosen` gives without names.
        progress: called with the part that is timed.
        share: of the usual steps.
    """
    return together(measured(repetitions, parts, progress, share))


def measured(
    repetitions: int = 5, parts: Iterable[Part] = (), progress: Progress = silent, share: float = 1.0
) -> dict[str, Figures]:
    """As `bench`, by part."""
    wanted = list(parts) or chosen()
    for one in wanted:
        one.check()
    found: dict[str, Figures] = {}
    for one in wanted:
        progress(one.name)
        found[one.name] = one(Effort(repetitions, share))
    return found


def together(found: Mapping[str, Figures]) -> dict[str, Any]:
    """The figures of all parts; their keys differ."""
    return {key: value for figures in found.values() for key, value in figures.items()}


def bench_tables(found: Mapping[str, Figures]) -> list[Table]:
    """What was `measured` as tables, each with the words that say how it is read."""
    return [table for name, figures in found.items() for table in PARTS[name].tables(figures)]


def bench_chart(figures: dict[str, Any], parts: Iterable[Part]) -> Figure:
    """The figure of what the parts measured."""
    return timings_chart("What ehamj takes", [panel for one in parts for panel in one.show(figures)])
