"""Units as products of powers: a size in SI, and how often each base unit stands in it."""

from fractions import Fraction
from typing import Final, NamedTuple


class Power(NamedTuple):
    """SI value, and powers of metre, second, count, volt, kilogram, ampere and radian."""

    size: float
    metre: Fraction = Fraction(0)
    second: Fraction = Fraction(0)
    counts: Fraction = Fraction(0)
    volt: Fraction = Fraction(0)
    kilogram: Fraction = Fraction(0)
    ampere: Fraction = Fraction(0)
    radian: Fraction = Fraction(0)

    def times(self, other: "Power", power: Fraction) -> "Power":
        """The product with a power of another."""
        exponents = (a + power * b for a, b in zip(self[1:], other[1:], strict=True))
        return Power(self.size * other.size ** float(power), *exponents)


ONE: Final = Power(1.0)
METRE, SECOND = Power(1.0, metre=Fraction(1)), Power(1.0, second=Fraction(1))
SPEED, ACCELERATION = METRE.times(SECOND, Fraction(-1)), METRE.times(SECOND, Fraction(-2))
HERTZ = ONE.times(SECOND, Fraction(-1))
RADIAN = Power(1.0, radian=Fraction(1))
NEWTON = ACCELERATION.times(Power(1.0, kilogram=Fraction(1)), Fraction(1))
PASCAL = NEWTON.times(METRE, Fraction(-2))


def of(size: float, power: Power) -> Power:
    """A unit of some powers by its SI value."""
    return power._replace(size=size)
