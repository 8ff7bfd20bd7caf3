"""What a plan says: what each test would tell, and which to make next."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ehamj.arrays import Array
from ehamj.identification.planning.information import TOLD
from ehamj.identification.planning.instruments import Instruments
from ehamj.identification.planning.settings import PlanSettings
from ehamj.identification.planning.trial import Trial
from ehamj.identification.unknowns import Unknown, Values
from ehamj.scenario.model import Scenario

Method = Literal["linear", "nonlinear"]


@dataclass(frozen=True)
class Forecast:
    """What one test would tell, made alone."""

    trial: Trial
    information: Array
    """In the scaled unknowns, (k, k)."""
    deviations: Array
    """Predicted standard deviation of each parameter after it, in the parameter's unit, (k,)."""
    factors: Array
    """By how much it sharpens each, (k,)."""
    method: Method
    moving: tuple[str, ...]
    """Channels that are worth recording in it: they move by more than the last bits of their converters."""


@dataclass(frozen=True)
class Step:
    """One test of the recommended sequence."""

    forecast: Forecast
    deviations: Array
    """Predicted standard deviations after it and all before it, (k,), in the parameters' units."""
    nonlinear: Array | None
    """The same by the nonlinear engine, where that was run, (k,)."""


@dataclass(frozen=True)
class Plan:
    """Which test next."""

    title: str
    machine: Scenario
    unknowns: tuple[Unknown, ...]
    at: Values
    """Values that the sensitivities are taken at."""
    before: Array
    """Standard deviations before any of the tests, (k,) in the parameters' units: of priors, else as if any value
    within the bounds were as likely, and of tests that were made."""
    done: tuple[str, ...]
    """Tests that were made, and count."""
    instruments: Instruments
    forecasts: tuple[Forecast, ...]
    refused: Mapping[str, str]
    """Candidates that cannot be made or predicted, and why."""
    sequence: tuple[Step, ...]
    settings: PlanSettings
    """What was asked."""
    untold: Mapping[str, str]
    """Parameters that no candidate tells, and why, in words."""

    @property
    def keys(self) -> tuple[str, ...]:
        """Of the parameters, in the order of all arrays."""
        return tuple(one.name for one in self.unknowns)

    def best_for(self, key: str) -> Forecast | None:
        """The test that, alone, sharpens a parameter most; None where none tells it."""
        k = self.keys.index(key)
        best = max(self.forecasts, key=lambda one: one.factors[k], default=None)
        return best if best is not None and best.factors[k] >= TOLD else None

    @property
    def answers(self) -> tuple[str, ...]:
        """What a person wants to know first, a line each."""
        found = []
        names = [step.forecast.trial.name for step in self.sequence]
        for k, step in enumerate(self.sequence):
            again = "once more" if names[k] in names[:k] else step.forecast.trial.words
            found.append(f"test {k + 1}: {names[k]}: {again}")
        if not self.sequence:
            found.append("no candidate would tell more than is known")
        for key in self.keys:
            k, best = self.keys.index(key), self.best_for(key)
            unit = "" if self.unknowns[k].unit in ("-", "1") else self.unknowns[k].unit
            if best is not None:
                told = f"best by {best.trial.name}: from ± {self.before[k]:.2g} to ± {best.deviations[k]:.2g} {unit}"
                found.append(f"{key}: {told}".rstrip())
            elif key not in self.untold:
                last = self.sequence[-1].deviations[k] if self.sequence else self.before[k]
                told = f"known to ± {self.before[k]:.2g} {unit}".rstrip() + ", which no candidate sharpens much"
                if self.before[k] >= TOLD * last:
                    told = f"by no test alone; by those together from ± {self.before[k]:.2g} to ± {last:.2g} {unit}"
                found.append(f"{key}: {told}".rstrip())
        found += [f"{key}: no candidate tells it: {why}" for key, why in self.untold.items()]
        return tuple(found)

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return {
            "title": self.title,
            "answers": list(self.answers),
            "done": list(self.done),
            "parameters": {
                one.name: {"value": self.at[one.name], "unit": one.unit, "deviation_before": float(before)}
                for one, before in zip(self.unknowns, self.before, strict=True)
            },
            "channels": {name: self.instruments.told(name) for name in self.instruments.channels},
            "candidates": [
                {
                    "name": one.trial.name,
                    "kind": one.trial.kind,
                    "words": one.trial.words,
                    "seconds": one.trial.seconds,
                    "method": one.method,
                    "deviations": _by_key(self.keys, one.deviations),
                    "factors": _by_key(self.keys, one.factors),
                    "crest_factors": {name: signal.crest_factor for name, signal in one.trial.played.items()},
                }
                for one in self.forecasts
            ],
            "refused": dict(self.refused),
            "sequence": [
                {
                    "name": step.forecast.trial.name,
                    "deviations_after": _by_key(self.keys, step.deviations),
                    "deviations_after_nonlinear": None
                    if step.nonlinear is None
                    else _by_key(self.keys, step.nonlinear),
                }
                for step in self.sequence
            ],
            "untold": dict(self.untold),
        }

    def save(self, folder: str | Path) -> None:
        """Write page, numbers, tests as scenarios and signals into a folder that is there.

        Raises:
            OSError: if a file cannot be written.
        """
        from ehamj.identification.planning.saving import save

        save(self, Path(folder))


def _by_key(keys: tuple[str, ...], values: Array) -> dict[str, float]:
    return dict(zip(keys, np.asarray(values).tolist(), strict=True))
