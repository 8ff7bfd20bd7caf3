"""Rational time: periods and delays as exact fractions of a second, and what they have in common."""

import math
from collections.abc import Callable, Iterable
from fractions import Fraction

from ehamj.errors import InputError

SHORTEST = 1e-7
"""Shortest period or delay that is followed [s]."""

MOST_WAITING = 100
"""Periods that a command may wait: each is a state of every valve, and more is no time to compute."""


def waits_in_time(delay: float | None, period: float) -> bool:
    """Whether commands act at once, or from `SHORTEST` to one second after the sample, one period where that is longer,
    and wait no longer than `MOST_WAITING` periods."""
    longest = min(max(1.0, period), MOST_WAITING * period * (1 + 1e-9))
    return delay is None or delay == 0.0 or SHORTEST <= delay <= longest


def exact(time: float) -> Fraction:
    """A time [s] as the fraction that was meant: 1e-4 is 1/10000.

    Raises:
        InputError: if it is so short that no such fraction is near.
    """
    found = Fraction(time).limit_denominator(round(1.0 / SHORTEST))
    if abs(found - Fraction(time)) > 1e-6 * abs(time):
        raise InputError(f"a period or delay of {time:g} s: must be zero or at least {SHORTEST:g} s")
    return found


def common_divisor(times: Iterable[float]) -> Fraction:
    """The longest time of which all are multiples [s]."""
    return _common(math.gcd, times)


def common_multiple(times: Iterable[float]) -> Fraction:
    """The shortest time that is a multiple of all [s]."""
    return _common(math.lcm, times)


def _common(of: Callable[..., int], times: Iterable[float]) -> Fraction:
    found = [exact(time) for time in times]
    unit = math.lcm(*(time.denominator for time in found))
    return Fraction(of(*(int(time * unit) for time in found)), unit)
