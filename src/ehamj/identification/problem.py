"""All fitted tests as one function of the scaled unknowns: predictions and their derivatives."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ehamj.arrays import Array
from ehamj.identification.residual import Compared, Failed, Residuals, real
from ehamj.identification.unknowns import Unknown, Values

STEP: Final = 1e-4
"""Of differences of scaled unknowns: far above rounding, and far below what bends a response."""
CENTRAL_STEP: Final = 1e-3
"""The same of central differences, whose error is its square."""


@dataclass(frozen=True)
class Linearised:
    """All channels at a point, and how their predictions change from there."""

    point: Array
    """Scaled unknowns, (k,)."""
    compared: tuple[Compared, ...]
    slopes: tuple[Array, ...]
    """Derivative of each channel's prediction in the scaled unknowns, as real numbers (`real`), (n, k) each."""
    tests: tuple[str, ...]
    """Name of each channel's test."""


class Problem:
    """Fitted tests and what is looked for in them."""

    def __init__(
        self,
        tests: Sequence[Residuals],
        parameters: Sequence[Unknown],
        rough: float | None = None,
        held: Values | None = None,
    ) -> None:
        """Of which the parameters come first, then each test's own unknowns.

        Args:
            tests: with those held out, which are ignored.
            parameters: of the scenario.
            rough: share of their beginnings that tests are compared in (`Residuals.rough`); None: all there is. What
                less than a whole beginning leaves open stays near where it starts.
            held: of the scenario's keys that tests are told beside, and that are not looked for.
        """
        self.tests = tuple(test for test in tests if not test.held_out)
        self.parameters = tuple(parameters)
        own = (*self.parameters, *(one for test in self.tests for one in test.unknowns))
        self.unknowns = own if rough is None or rough >= 1.0 else tuple(one.held_near_start for one in own)
        self.rough, self.held = rough, dict(held or {})
        self.runs = 0
        """Points of single tests that were predicted."""

    @property
    def start(self) -> Array:
        """Where all unknowns start, scaled, (k,)."""
        return np.zeros(len(self.unknowns))

    @property
    def limits(self) -> tuple[Array, Array]:
        """Bounds of the scaled unknowns, (k,) each."""
        low, high = zip(*(one.limits for one in self.unknowns), strict=True)
        return np.array(low), np.array(high)

    def values(self, point: Array) -> dict[str, float]:
        """What a point means, by name, in SI."""
        return self.held | {one.name: one.value(float(z)) for one, z in zip(self.unknowns, point, strict=True)}

    def compared(self, points: Sequence[Array]) -> list[tuple[Compared, ...] | Failed]:
        """All channels of all tests at each of some points."""
        batch = [self.values(point) for point in points]
        each = [self._of(test, batch) for test in self.tests]
        found: list[tuple[Compared, ...] | Failed] = []
        for parts in zip(*each, strict=True):
            failed = next((part for part in parts if isinstance(part, Failed)), None)
            found.append(failed or tuple(one for part in parts if not isinstance(part, Failed) for one in part))
        return found

    def _of(self, test: Residuals, batch: Sequence[Values]) -> list[tuple[Compared, ...] | Failed]:
        self.runs += len(batch)
        return test.compared(batch) if self.rough is None else test.rough(batch, self.rough)

    def linearised(self, point: Array, central: bool = False) -> Linearised | Failed:
        """Channels and their derivatives at a point, by forward differences, which stay within the bounds, or central
        ones. Where the neighbour on one side fails, the other side's difference counts."""
        compared: list[Compared] = []
        slopes: list[Array] = []
        tests: list[str] = []
        for test in self.tests:
            own = [k for k, one in enumerate(self.unknowns) if not one.closed and one.test in (None, test.name)]
            steps = [(k, step) for k in own for step in self._steps(point, k, central)]
            points = [point, *(_moved(point, k, step) for k, step in steps)]
            at, *near = self._of(test, [self.values(one) for one in points])
            if isinstance(at, Failed):
                return at
            turned = [(k, -step) for (k, step), one in zip(steps, near, strict=True) if isinstance(one, Failed)]
            if turned and not central:
                near += self._of(test, [self.values(_moved(point, k, step)) for k, step in turned])
                steps += turned
            found = self._differences(at, steps, near)
            if isinstance(found, Failed):
                return found
            compared += at
            tests += [test.name] * len(at)
            slopes += [self._with_closed(one, part, point) for one, part in zip(at, found, strict=True)]
        return Linearised(point, tuple(compared), tuple(slopes), tuple(tests))

    def _steps(self, point: Array, k: int, central: bool) -> list[float]:
        low, high = self.unknowns[k].limits
        size = CENTRAL_STEP if central else STEP
        both = [step for step in (size, -size) if low <= point[k] + step <= high]
        return both if central else both[:1]

    def _differences(
        self, at: tuple[Compared, ...], steps: Sequence[tuple[int, float]],
        near: Sequence[tuple[Compared, ...] | Failed],
    ) -> list[Array] | Failed:  # fmt: skip
        """Derivative of each channel in all unknowns, zero in those that were not moved."""
        found = [np.zeros((real(one.predicted).size, len(self.unknowns))) for one in at]
        for k in dict.fromkeys(k for k, _ in steps):
            sides = [(step, one) for (j, step), one in zip(steps, near, strict=True) if j == k]
            usable = [(step, one) for step, one in sides if not isinstance(one, Failed)]
            if not usable:
                failed = sides[0][1]
                assert isinstance(failed, Failed)
                return failed
            (first, ahead), (last, behind) = usable[0], usable[1] if len(usable) == 2 else (0.0, at)
            for number, (one, other) in enumerate(zip(ahead, behind, strict=True)):
                found[number][:, k] = real(one.predicted - other.predicted) / (first - last)
        return found

    def _with_closed(self, one: Compared, slopes: Array, point: Array) -> Array:
        for k, unknown in enumerate(self.unknowns):
            if unknown.name in one.slopes:
                scale = unknown.slope(unknown.value(float(point[k])))
                slopes[:, k] = real(one.slopes[unknown.name]) * scale
        return slopes


def _moved(point: Array, k: int, step: float) -> Array:
    found = point.copy()
    found[k] += step
    return found
