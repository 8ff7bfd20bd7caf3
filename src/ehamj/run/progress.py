"""Words about what is being done, for those who wait."""

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

Progress = Callable[[str], None]
"""Called with what is being done now."""
C = TypeVar("C")


def silent(text: str) -> None:
    """No progress is shown."""


def counted(cases: Sequence[C], progress: Progress, what: str = "nonlinear run") -> Iterator[C]:
    """The cases, each announced as it is taken: of `ehamj.run.simulate_many` when a thread gets free for it."""
    for number, case in enumerate(cases, 1):
        progress(f"{what} {number} of {len(cases)}")
        yield case
