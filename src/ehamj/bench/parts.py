"""The parts of the bench: each times one thing, in a file of its own, and says what the figure shows of it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

from ehamj.bench.reading import Table, listed
from ehamj.plots.timings import Panel
from ehamj.registry import Registry

Figures = dict[str, Any]
"""What was measured: names, with units, over numbers and further such tables. Keys of all parts differ."""


class Effort(NamedTuple):
    """How thoroughly a part measures."""

    repetitions: int = 5
    share: float = 1.0
    """Of the usual steps and durations; a test takes few."""

    def steps(self, usual: int) -> int:
        """So many of the usual steps."""
        return max(10, round(self.share * usual))

    def duration(self, usual: float) -> float:
        """So much of a usual duration [s], whole hundredths."""
        return max(0.01, round(self.share * usual, 2))


Show = Callable[[Mapping[str, Any]], Sequence[Panel]]
Read = Callable[[Mapping[str, Any]], Sequence[Table]]


def nothing() -> None:
    """Everything that it needs is there."""


def unseen(_: Mapping[str, Any]) -> Sequence[Panel]:
    """The figure shows nothing of it."""
    return ()


@dataclass(frozen=True)
class Part:
    """One part: what it is ``about``, how it ``measure``s, and which panels of the figure ``show`` what it found.

    ``read`` gives its tables with words that say how they are read; without, keys and numbers are listed.
    """

    name: str
    about: str
    measure: Callable[[Effort], Figures]
    show: Show
    read: Read | None = None
    asked: bool = False
    """Measured only where it is asked for by name."""
    check: Callable[[], object] = nothing
    """Raises InputError where it cannot be measured; called before anything is."""

    def __call__(self, effort: Effort) -> Figures:
        """What it measures."""
        return self.measure(effort)

    def tables(self, figures: Figures) -> Sequence[Table]:
        """What it found as tables."""
        return [listed(self.about, figures)] if self.read is None else self.read(figures)


PARTS: Final[Registry[Part]] = Registry("part")


def part(name: str, about: str, show: Show = unseen, **more: Any) -> Callable[[Callable[[Effort], Figures]], Part]:
    """Decorator that registers what measures a part (see `Part`); list its file in `ehamj.bench.bench`."""
    return lambda measure: PARTS.add(name, Part(name, about, measure, show, **more))
