"""How far a study is: for those who wait."""

import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from ehamj.arrays import Array
from ehamj.campaign.plans.plan import Goals, excess

RECENT: Final = 60.0
"""Time over which a rate is counted, once there is so much [s]."""


OWN: Final = "named"
"""Stage of the scenario's own design and of those with names, which no plan counts."""
SURE: Final = 8
"""Designs, and the hundredth of all, after which rate and time left are told."""


@dataclass(frozen=True)
class Standing:
    """How far a study is."""

    stage: str = ""
    done: int = 0
    """Designs that are stored, of all stages."""
    total: int = 0
    """Designs that there will be, at most."""
    failed: int = 0
    """Designs that have failed, of those that are done."""
    found: int = 0
    """Designs that were stored before, by a study that is resumed."""
    rate: float = 0.0
    """Designs in a second; 0 until the first are done [1/s]."""
    best: Mapping[str, tuple[int, float]] = field(default_factory=dict)
    """Of each objective, number and merit of the best design that meets all constraints."""
    waiting: str = ""
    """What nothing goes on without, in words."""
    interrupted: bool = False
    """Whether the user stops it here."""

    @property
    def left(self) -> float | None:
        """Time that what is left will take, at this rate [s]."""
        return (self.total - self.done) / self.rate if self.rate else None

    @property
    def words(self) -> str:
        """In one line."""
        if self.interrupted:
            return f"interrupted: {self.done:,} of {self.total:,} designs are stored; resumed, it goes on from there"
        beside = ", the scenario's own among them" if self.stage == OWN else ""
        parts = [f"{self.stage}: {self.done:,} of {self.total:,} designs{beside}"]
        if self.failed:
            parts.append(f"{self.failed:,} failed")
        if self.rate and self.done - self.found >= max(SURE, self.total // 100):  # the first ones compile and find laws
            parts.append(f"{_rate(self.rate)}, {_time(self.left or 0.0)} left")
        parts += [f"best {name} {merit:.4g} (design {number})" for name, (number, merit) in self.best.items()]
        return ", ".join([*parts, *([self.waiting] if self.waiting else [])])


Progress = Callable[[Standing], None]


def silent(standing: Standing) -> None:
    """No progress is shown."""


class Watch:
    """Counts what is done, and tells."""

    def __init__(self, total: int, goals: Goals, tell: Progress) -> None:
        self.standing, self.goals, self.tell = Standing(total=total), goals, tell
        self._recent: deque[tuple[float, int]] = deque([(time.monotonic(), 0)])
        self._new = 0

    @property
    def names(self) -> list[str]:
        """Merits that say which design is the best."""
        return [name for name, _ in self.goals.objectives] + [name for name, *_ in self.goals.constraints]

    def count(self, first: int, merits: Array | None, failed: int, size: int, new: bool) -> None:
        """Designs from number ``first`` on are stored; ``merits`` (design, name) of `names` where they compete."""
        best = self.standing.best if merits is None else self._best(first, merits)
        self._new += size if new else 0
        now = time.monotonic()
        self._recent.append((now, self._new))
        while len(self._recent) > 2 and now - self._recent[0][0] > RECENT:
            self._recent.popleft()
        (since, before), own = self._recent[0], self.standing
        found = own.found + (0 if new else size)
        rate = (self._new - before) / (now - since) if now > since else 0.0
        self.say(done=own.done + size, failed=own.failed + failed, found=found, rate=rate, best=best)

    def say(self, **changed: object) -> None:
        """Tell what is otherwise now."""
        self.standing = replace(self.standing, **changed)  # type: ignore[arg-type]
        self.tell(self.standing)

    def _best(self, first: int, merits: Array) -> Mapping[str, tuple[int, float]]:
        good = np.ones(len(merits), bool)
        for at, (_, low, high) in enumerate(self.goals.constraints, len(self.goals.objectives)):
            good &= excess(merits[:, at], low, high) <= 0.0
        best = dict(self.standing.best)
        for at, (name, sign) in enumerate(self.goals.objectives):
            own = np.where(good & ~np.isnan(merits[:, at]), sign * merits[:, at], np.inf)
            least = int(own.argmin())
            if own[least] < np.inf and (
                name not in best or (own[least], first + least) < (sign * best[name][1], best[name][0])
            ):
                best[name] = first + least, float(merits[least, at])
        return best


def _rate(rate: float) -> str:
    """A rate in words that fit it."""
    for unit, seconds in (("s", 1.0), ("min", 60.0)):
        if rate * seconds >= 1.0:
            return f"{rate * seconds:,.{0 if rate * seconds >= 100.0 else 1}f}/{unit}"
    return f"{3600.0 * rate:.2g}/h"


def _time(seconds: float) -> str:
    """A time in words that fit it."""
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    minutes = seconds / 60
    return f"{minutes:.0f} min" if minutes < 90.0 else f"{minutes / 60:.1f} h"
