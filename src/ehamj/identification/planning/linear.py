"""Sensitivities of a test's outputs by the linear model: what its lines tell of each unknown.

With X = (sI − A)⁻¹B U the states under the inputs U, an output's derivative is
∂Y = C (sI − A)⁻¹(∂A X + ∂B U) + ∂C X + ∂D U: one set of equations for all unknowns. ∂A … ∂D are central differences of
models that are built at the unknowns' neighbours.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ehamj.arrays import Array, ComplexArray
from ehamj.identification.machine import with_values
from ehamj.identification.planning.excitation import excitation_of, into_model
from ehamj.identification.planning.forecast import Lines
from ehamj.identification.planning.trial import Trial
from ehamj.identification.unknowns import Unknown, Values
from ehamj.linear.machine import linear_model
from ehamj.scenario.model import Scenario

STEP: Final = 5e-3
"""Half of a central difference, in the scaled unknown: of its square remains, 2.5e-5."""


@dataclass(frozen=True)
class Neighbours:
    """Scaled steps about a point, and the points there: two for each unknown, of which one may be the point itself
    (at a bound)."""

    points: tuple[Values, ...]
    """The point itself, then below and above it in each unknown."""
    widths: Array
    """Distance of the two in the scaled unknown, (k,)."""

    @classmethod
    def of(cls, unknowns: Sequence[Unknown], at: Values, step: float = STEP) -> "Neighbours":
        """About ``at``, within the bounds."""
        points: list[Values] = [dict(at)]
        widths = []
        for one in unknowns:
            middle = one.scaled(at[one.name])
            low, high = one.limits
            ends = [max(low, middle - step), min(high, middle + step)]
            points += [{**at, one.name: one.value(end)} for end in ends]
            widths.append(ends[1] - ends[0])
        return cls(tuple(points), np.array(widths))


class Linear:
    """The linear machine and its neighbours, for many tests on it."""

    def __init__(self, machine: Scenario, unknowns: Sequence[Unknown], at: Values) -> None:
        """Build 1 + 2k models.

        Raises:
            InputError: if one of the machines has no linear model (`ehamj.linear.smooth.NotSmooth` names the option).
        """
        self._near = Neighbours.of(unknowns, at)
        self._models = [linear_model(with_values(machine, point).plant) for point in self._near.points]
        if any(model.states != self._models[0].states for model in self._models):
            raise ValueError("the states of the linear machine differ about the starting values")

    def lines(self, trial: Trial, channels: Sequence[str], rate: float) -> Lines:
        """What channels do in the lines of a test that is recorded at ``rate`` [Hz]."""
        found = excitation_of(trial, rate)
        hertz = found.frequency
        scenarios = [with_values(trial.scenario, point) for point in self._near.points]
        drives = [
            into_model(found.inputs, one, its, hertz) @ found.amplitudes
            for one, its in zip(scenarios, self._models, strict=True)
        ]
        parts = [(its.A, its.B, *its.rows(channels)) for its in self._models]
        _, B, C, D = parts[0]
        resolvent = self._resolvent(hertz)
        states = np.linalg.solve(resolvent, B @ drives[0])
        values = [C @ states + D @ drives[0]]
        for k, width in enumerate(self._near.widths):
            (A1, B1, C1, D1), (A2, B2, C2, D2) = parts[1 + 2 * k], parts[2 + 2 * k]
            below, above = drives[1 + 2 * k], drives[2 + 2 * k]
            moved = np.linalg.solve(resolvent, (A2 - A1) @ states + B2 @ above - B1 @ below)
            values.append((C @ moved + (C2 - C1) @ states + D2 @ above - D1 @ below) / width)
        return Lines(hertz, found.weights, np.stack(values, axis=-1))

    def _resolvent(self, hertz: Array) -> ComplexArray:
        A = self._models[0].A
        return np.asarray(2j * np.pi * hertz[:, None, None] * np.eye(len(A)) - A)
