"""What a law knows of a line whose frequency it follows: which of its states turn with it, and within what range.

`ehamj.control.compiled.lines` says how it is followed.
"""

import math
from collections.abc import Sequence
from typing import Any, Final, NamedTuple, Self

import numpy as np

from ehamj.arrays import Array
from ehamj.control.tables import numbers_in
from ehamj.errors import InputError

NEAR: Final = 1e-3
"""Share by which a line's states may turn with another frequency: their damping takes ζ²/2 of it."""


class Line(NamedTuple):
    """Of a law, pairs of states that turn with one line: (Re x, Im x) of x⁺ = ρ e^{jωT} x + …, one pair per motion."""

    first: int
    """Number of the first of these states in the law."""
    pairs: int
    """How many there are, one after the other."""
    frequency: float
    """As it is stated: the states turn with it by themselves [Hz]."""
    low: float
    """Range within which the line is followed [Hz]."""
    high: float
    time: float
    """In which it comes down by e, and which is looked back to see it turn [s]."""
    pace: float
    """Time over which it is followed [s]."""

    @property
    def states(self) -> slice:
        """Numbers of its states in the law."""
        return slice(self.first, self.first + 2 * self.pairs)

    def nominal(self, A: Array, period: float) -> float:
        """Frequency that the states turn with by themselves [Hz]."""
        return math.atan2(A[self.first + 1, self.first], A[self.first, self.first]) / (2.0 * math.pi * period)

    def turned(self, A: Array, period: float, hertz: float) -> Array:
        """A law's matrix with its states turning with another frequency [Hz]."""
        angle = 2.0 * math.pi * period * (hertz - self.nominal(A, period))
        turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
        found, own = np.array(A), self.states
        found[own, own] = found[own, own] @ np.kron(np.eye(self.pairs), turn)
        return found

    def moved(self, by: int) -> Self:
        """The line of a law that stands behind so many states of others."""
        return self._replace(first=self.first + by)

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return self._asdict()

    @classmethod
    def from_dict(cls, table: Any) -> Self:
        """The inverse of `to_dict`.

        Raises:
            InputError: if a key is missing or unknown, or a number is not one.
        """
        first, pairs, *numbers = numbers_in(table, cls._fields, "controller.lines")
        if not first.is_integer() or not pairs.is_integer():
            raise InputError("controller.lines: first and pairs must be whole numbers")
        return cls(int(first), int(pairs), *numbers)


def check_lines(lines: Sequence[Line], A: Array, period: float) -> None:
    """Refuse lines that are not those of a law with the matrix ``A`` and a ``period`` [s].

    Raises:
        InputError: if states are not there, or belong to two lines, or do not turn by themselves in pairs; if a range
            does not hold the line, or they turn with another frequency, or it ends at half the sampling rate, or
            ``time`` is shorter than a period, or ``pace`` shorter than that.
    """
    seen: set[int] = set()
    for number, line in enumerate(lines):
        key, states = f"controller.lines.{number}", range(*line.states.indices(len(A)))
        if line.first < 0 or line.pairs < 1 or len(states) < 2 * line.pairs:
            raise InputError(f"{key}: {line.pairs} pairs from state {line.first} are not among the law's {len(A)}")
        if seen.intersection(states):
            raise InputError(f"{key}: shares states with another line; each must have its own")
        seen.update(states)
        one = A[line.first : line.first + 2, line.first : line.first + 2]
        apart = np.zeros_like(A[line.states])
        apart[:, line.states] = np.kron(np.eye(line.pairs), [[one[0, 0], -one[1, 0]], [one[1, 0], one[0, 0]]])
        alike = np.allclose(A[line.states], apart, rtol=0.0, atol=1e-12)
        others = np.delete(A[:, line.states], range(*line.states.indices(len(A))), axis=0)
        if not alike or np.any(others):
            raise InputError(
                f"{key}: its states must turn in pairs, all alike, and with no other state in controller.A"
            )
        if not 0.0 < line.low <= line.frequency <= line.high:
            raise InputError(f"{key}: a range from {line.low:g} to {line.high:g} Hz must hold {line.frequency:g} Hz")
        if not math.isclose(line.frequency, nominal := line.nominal(A, period), rel_tol=NEAR):
            raise InputError(f"{key}: frequency = {line.frequency:g} Hz, and its states turn with {nominal:g} Hz")
        if not line.high < 0.5 / period:
            raise InputError(
                f"{key}: high = {line.high:g} Hz must be below half the sampling rate, {0.5 / period:g} Hz"
            )
        if not period <= line.time <= line.pace < math.inf:
            raise InputError(
                f"{key}: time = {line.time:g} s must be at least a period, {period:g} s, and pace = {line.pace:g} s at "
                "least that"
            )
