"""Where the time of a command went, by the clock on the wall."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

LEAST: Final = 0.05
"""Shares below this are not told [s]."""


class Clock:
    """Time since it was made, split into named stages [s]."""

    def __init__(self) -> None:
        self.began = time.perf_counter()
        self.stages: dict[str, float] = {}

    def add(self, stage: str, seconds: float) -> None:
        """Count some time to a stage."""
        self.stages[stage] = self.stages.get(stage, 0.0) + max(seconds, 0.0)

    @contextmanager
    def during(self, stage: str) -> Iterator[None]:
        """Count what the block takes to a stage."""
        began = time.perf_counter()
        try:
            yield
        finally:
            self.add(stage, time.perf_counter() - began)

    def words(self, rest: str) -> str:
        """All of it, and each stage that took some; what no stage counts is the ``rest``, which comes first."""
        total = time.perf_counter() - self.began
        every = {rest: total - sum(self.stages.values())} | self.stages
        told = ", ".join(f"{stage} {_seconds(spent)}" for stage, spent in every.items() if spent >= LEAST)
        return f"{_seconds(total)}: {told}" if told else _seconds(total)


class Marks:
    """When a run had done its first and its last stretch of steps, and when it ended; called with the fraction done."""

    def __init__(self) -> None:
        self.first: tuple[float, float] | None = None
        self.last = self.ended = 0.0

    def __call__(self, fraction: float) -> None:
        self.last = time.perf_counter()
        if self.first is None:
            self.first = (self.last, fraction)

    def end(self) -> None:
        """Mark the end, judged and all."""
        self.ended = time.perf_counter()

    def count(self, clock: Clock, finding: float, loop: float) -> None:
        """Count the run's stages to a clock; it took ``finding`` [s] to find the law, and ``loop`` [s] to step."""
        if self.first is None:
            return
        at, fraction = self.first
        clock.add("finding the law", finding)
        clock.add("stepping", self.last - at + fraction * loop)
        clock.add("judging", self.ended - self.last)


def _seconds(value: float) -> str:
    return f"{value:.{0 if value >= 10.0 else 1}f} s"
