"""Which options the data justify: of a valve that is no machine but a formula, so that what is there is known."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

from ehamj.identification.choice import Choosing, Model
from ehamj.identification.fit import Fitted, fitted
from ehamj.identification.optional import ChoiceSettings, with_neutral
from ehamj.identification.problem import Problem
from ehamj.identification.residual import Compared, Failed
from ehamj.identification.unknowns import Unknown, Values
from ehamj.identification.verdicts import Choice
from ehamj.scenario.load import parse_scenario

MACHINE = parse_scenario({})
ISOLATOR = "actuators.isolator"
GAIN = Unknown("actuators.isolator.flow_gain", "m³/s/mA", 2.0, 1.0, 4.0)


@dataclass
class Formula:
    """Flow of a valve that swings: gain times opening, with play, overlap, and (seen only where told) air."""

    options: dict[str, float] = field(default_factory=dict)
    noise: float = 0.01
    colour: float = 0.0
    seed: int = 0
    swing: float = 1.0
    name: str = "swinging"
    held_out: bool = False
    unknowns: tuple[Unknown, ...] = ()

    def __post_init__(self) -> None:
        t = np.arange(2000)
        self.spool = self.swing * (np.sin(0.05 * t) + 0.7 * np.sin(0.0831 * t + 1.0) + 0.3 * np.sin(0.31 * t))
        white = np.random.default_rng(self.seed).normal(size=t.size)
        for k in range(1, t.size):
            white[k] += self.colour * white[k - 1]
        exact = self.of({"gain": 2.3} | self.options)
        self.measured = exact + self.noise * exact.std() * white

    def of(self, own: Mapping[str, float]) -> np.ndarray:
        edges, half = np.empty_like(self.spool), 0.5 * own.get("hysteresis", 0.0)
        at = 0.0
        for k, spool in enumerate(self.spool):
            at = min(max(at, spool - half), spool + half)
            edges[k] = at
        lap = own.get("overlap", 0.0)
        opening = np.where(edges > 0.0, np.maximum(edges - lap, 0.0), np.minimum(edges + lap, 0.0))
        return np.asarray(own["gain"] * (opening + 0.5 * min(lap, 0.0) * 0.0))

    def compared(self, batch: Sequence[Values]) -> list[tuple[Compared, ...] | Failed]:
        return [self._one(values) for values in batch]

    rough = compared

    def _one(self, values: Values) -> tuple[Compared, ...] | Failed:
        own = {key.rpartition(".")[2]: value for key, value in values.items()}
        found = self.of({**own, "gain": own["flow_gain"]})
        at, none = 1e-3 * np.arange(found.size, dtype=np.float64), np.full(found.size, np.nan)
        return (Compared("flow", "m³/s", "time", at, self.measured, found, none),)

    def found(self, values: Values) -> Mapping[str, Any]:
        return {}


def chosen(formula: Formula, *options: str, **told: Any) -> tuple[Model, Choice]:
    settings = ChoiceSettings(options=options or ("hysteresis", "overlap", "air"), **told)
    problem = Problem([formula], [GAIN])
    base = fitted(problem, problem.start, 30)
    assert isinstance(base, Fitted)
    return Choosing(settings, with_neutral(settings, MACHINE), [formula], [GAIN], 30).choose(base)


@pytest.mark.parametrize(
    ("there", "colour"),
    [({}, 0.0), ({"hysteresis": 0.04}, 0.0), ({"overlap": 0.1}, 0.8), ({"hysteresis": 0.08, "overlap": 0.2}, 0.0)],
)
def test_what_is_there_is_found_with_its_value_and_nothing_else(there: dict[str, float], colour: float) -> None:
    model, choice = chosen(Formula(there, colour=colour))
    assert set(choice.justified) == set(there)
    for name, value in there.items():
        ((key, (found, deviation)),) = choice.verdicts[name].values.items()
        assert key == f"{ISOLATOR}.{name}"
        assert abs(found - value) < 4.0 * deviation / (1.0 - colour)  # deviations are those of white errors
        assert deviation < 0.02 * value
        assert choice.verdicts[name].words.startswith("the data justify")
    assert model.values["actuators.isolator.flow_gain"] == pytest.approx(2.3, rel=2e-3)
    assert "air" not in choice.justified
    assert not choice.verdicts["air"].told
    assert "leak-down" in choice.verdicts["air"].words
