"""When the C of a law samples, and when what it computed reaches the valves: delays as ticks, and the rest of one."""

import math
from fractions import Fraction
from typing import Any, NamedTuple

from ehamj.control.clock import exact
from ehamj.control.compiled.laws import Laws
from ehamj.errors import InputError

NEAR = 1e-6
"""Share of a tick by which delays may differ and be the same; times are rounded."""
NEAR_TIME = 5e-10
"""The same of the times at which commands set in and have faded in [s], as `ehamj.control.compiled.converter.faded`."""
MOST_TICKS = 2**32 - 1


class Row(NamedTuple):
    """When one of those that add to the commands computes and acts."""

    every: int
    """Ticks between its samples."""
    delay: int
    """Whole ticks that its outputs wait."""
    first: int
    """Place of its ring among all."""
    places: int
    at_once: bool
    """Its outputs are held without a ring."""
    said: str


class Clock(NamedTuple):
    """The clock of a law: ticks, and how long after one its commands reach the valves."""

    period: float
    """Of a tick [s]."""
    rest: float
    """From a tick to its commands [s]."""
    at_once: bool
    """There is no rest."""
    rest_said: str
    rows: tuple[Row, ...]
    steps: int
    """Of the integrator in a tick."""
    timestep: float
    """Of the integrator [s]."""

    @property
    def behind(self) -> int:
        """Ticks until what the valves get at one shows the commands of a step."""
        return 0 if self.at_once else 1

    @property
    def places(self) -> int:
        """Of all rings."""
        return sum(row.places for row in self.rows)

    @property
    def notes(self) -> tuple[str, ...]:
        """What to know of several rates and of what waits."""
        found = []
        for row in self.rows:
            often = "each tick" if row.every == 1 else f"each {row.every} ticks"
            ticks = "1 tick" if row.delay == 1 else f"{row.delay} ticks"
            waits = "" if row.delay == 0 else f", and what it computes waits {ticks} in here"
            found.append(f"{row.said[0].upper()}{row.said[1:]} samples {often}{waits}.")
        return tuple(found)


def clock_of(laws: Laws, timestep: float) -> Clock:
    """The clock of laws that step with a timestep [s].

    Raises:
        InputError: if their delays leave different parts of a tick: hardware that writes all valves together has one.
    """
    base = int(laws.base)
    waits = [(float(law["delay"]) + float(law["fraction"])) / base for law in laws.table]
    rests = [wait - math.floor(wait + NEAR) for wait in waits]
    rests = [0.0 if abs(rest) <= NEAR else rest for rest in rests]
    if max(rests) - min(rests) > NEAR:
        period = base * timestep
        raise InputError(
            f"--c: delays of {', '.join(f'{wait * period:.6g}' for wait in waits)} s end at different times after a "
            f"tick, one each {period:.6g} s; choose delays (control.delay) that differ by whole ticks, so that all "
            "commands are written together"
        )
    rest = rests[0] if max(rests) > 0.0 else (1.0 if min(waits) > 1.0 - NEAR else 0.0)
    tick = exact(base * timestep)
    late = exact(rest * float(tick)) if 0.0 < rest < 1.0 else tick * Fraction(int(rest))
    rows, first = [], 0
    for said, law, wait in zip(_called(laws), laws.table, waits, strict=True):
        every, delay = int(law["every"]) // base, round(wait - rest)
        at_once = rest == 0.0 and delay == 0
        places = 0 if at_once else delay // every + 1
        rows.append(Row(every, delay, first, places, at_once, said))
        first += places
    known = {0.0: "as soon as it returns", 1.0: "at the next tick, not before (EHAMJ_LAW_REST)"}
    later = known.get(rest, f"{float(late)!r} s after the tick (EHAMJ_LAW_REST), neither before nor later")
    return Clock(float(tick), float(late), rest == 0.0, later, tuple(rows), base, timestep)


def _called(laws: Laws) -> list[str]:
    """What each row is."""
    beside = [
        *(["the loop about each spool"] if laws.spools.size else []),
        *(["the stage that makes the valves good"] if laws.valves.size else []),
    ]
    count = len(laws.table) - len(beside)
    return [*(["the law"] if count == 1 else [f"law {k + 1}" for k in range(count)]), *beside]


def fade_of(switch_on: float, fade: float, clock: Clock) -> dict[str, Any]:
    """When commands set in and have faded in [s], as numbers of ticks, and what the time of a tick is made of.

    Raises:
        InputError: if that is later than ticks are counted.
    """
    begins, ends = (max(math.ceil((time - NEAR_TIME) / clock.period), 0) for time in (switch_on, switch_on + fade))
    if ends > MOST_TICKS:
        raise InputError(
            f"--c: control.switch_on = {switch_on:g} s and control.fade = {fade:g} s end after {ends:.3g} ticks; at "
            f"most {MOST_TICKS} are counted"
        )
    times = {"switch_on": switch_on, "fade": fade, "timestep": clock.timestep, "steps": float(clock.steps)}
    return {"begins": begins, "ends": ends, **times}
