"""Rational time: periods and delays as exact fractions of a second, and what they have in common."""

import math
from collections.abc import Iterable
from fractions import Fraction


def exact(time: float) -> Fraction:
    """A time [s] as the fraction that was meant: 1e-4 is 1/10000."""
    return Fraction(time).limit_denominator(10**7)


def common_divisor(times: Iterable[float]) -> Fraction:
    """The longest time of which all are multiples [s]."""
    first, *others = map(exact, times)
    for other in others:
        n = math.gcd(first.numerator * other.denominator, other.numerator * first.denominator)
        first = Fraction(n, first.denominator * other.denominator)
    return first


def common_multiple(times: Iterable[float]) -> Fraction:
    """The shortest time that is a multiple of all [s]."""
    first, *others = map(exact, times)
    for other in others:
        n = math.lcm(first.numerator * other.denominator, other.numerator * first.denominator)
        first = Fraction(n, first.denominator * other.denominator)
    return first
