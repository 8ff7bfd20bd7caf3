"""What matters most: how much each parameter does to each figure of merit, as the plan's designs can tell."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from ehamj.arrays import Array
from ehamj.campaign.studied import Studied

LEAST: Final = 8
"""Designs from which on a rank correlation says something."""
SURE: Final = 1.96
"""Deviations of a normal within which 95 % lie."""


@dataclass(frozen=True)
class Measure:
    """One measure of influence: its ``label``, its value for each parameter, and its 95 % interval where it has one."""

    label: str
    values: Array
    low: Array | None = None
    high: Array | None = None


@dataclass(frozen=True)
class Influence:
    """How much each of some parameters does to a merit: one or two measures; the last one decides which does most,
    and is told."""

    merit: str
    parameters: tuple[str, ...]
    title: str
    """What is measured, in words that go on with "of" a merit."""
    axis: str
    """The same with unit."""
    measures: tuple[Measure, ...]
    said: str = ""
    """What it was found from, in words."""
    base: float = 0.0
    """Value of no influence."""
    base_name: str = ""
    """What that is called; then all measures are values of the merit."""
    unit: str | None = None
    """Of the measures; None where they are shares or correlations."""
    more: tuple[Measure, ...] = ()
    """Measures without unit that the table has besides."""
    pairs: tuple[tuple[str, str, float, float], ...] = ()
    """Two parameters, what they do together beyond both alone, and half the width of its 95 % interval."""

    @property
    def known(self) -> bool:
        """Whether anything is."""
        return any(np.isfinite(measure.values).any() for measure in self.measures)

    @property
    def size(self) -> Array:
        """How much each parameter does, to be compared; 0 where nothing is known."""
        by = self.measures[-1:] if not self.base_name else self.measures
        return np.max([np.nan_to_num(np.abs(measure.values - self.base)) for measure in by], axis=0)

    @property
    def order(self) -> list[int]:
        """Parameters by that, the strongest first."""
        return [int(k) for k in np.argsort(-self.size, kind="stable")]


def rank_correlations(studied: Studied, merit: str) -> Influence | None:
    """Spearman's, with Fisher's interval (as Bonett and Wright widen it for ranks); of designs that are drawn, not
    searched. None where there are too few, or they do not differ."""
    from scipy.stats import spearmanr

    designs = studied.done[np.isfinite(studied.done[merit])]
    if len(designs) < LEAST or designs[merit].nunique() < 2:
        return None
    keys = [key for key in studied.numeric if designs[key].nunique() > 1]
    if not keys:
        return None
    found = np.array([float(spearmanr(designs[key], designs[merit]).statistic) for key in keys])
    spread = SURE * np.sqrt((1.0 + 0.5 * found**2) / (len(designs) - 3))
    score = np.arctanh(np.clip(found, -1.0 + 1e-12, 1.0 - 1e-12))
    measure = Measure("rank correlation", found, np.tanh(score - spread), np.tanh(score + spread))
    return Influence(merit, tuple(keys), "rank correlation", "rank correlation [-]", (measure,))
