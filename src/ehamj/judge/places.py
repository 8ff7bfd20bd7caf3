"""What a norm says of one place: the class per axis, and the axis that decides."""

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from ehamj.criteria.curves import Norm
from ehamj.criteria.verdict import WHOLE, Verdict
from ehamj.findings import Finding
from ehamj.judge.levels import Levels
from ehamj.judge.peaks import Peaks
from ehamj.plant.axes import AXES

PEAKS_TO: Final = 80.0
"""Frequency up to which the ground must be known for its peaks to be [Hz]: the common range of DIN 45669-1."""


class AtPlace(Finding):
    """What a norm says of one place."""

    x: Verdict
    y: Verdict
    z: Verdict
    worst: str | None
    """The coarsest class met; None where not even the coarsest is."""
    deciding_axis: str | None

    def along(self, axes: Sequence[str]) -> list[Verdict]:
        """The verdicts along some axes."""
        return [getattr(self, axis) for axis in axes]


def at_place(norm: Norm, levels: Levels, place: str, peaks: Peaks | None = None, usable_to: float = np.inf) -> AtPlace:
    """What a norm says of a place; ``peaks`` beside those of velocity, the ground being known to ``usable_to`` [Hz]."""
    peaks = peaks or Peaks()
    found, swings = levels.at(place) | peaks.levels.get(place, {}), peaks.swings.get(place, {})
    verdicts = {
        axis: norm.judge(axis, {kind: t[:, k] for kind, t in found.items()}, levels.bands, swings.get(axis))
        for k, axis in enumerate(AXES)
    }
    if usable_to < PEAKS_TO and "peak" in norm.statistics:
        verdicts = {axis: verdict if verdict.met is None else _open(verdict) for axis, verdict in verdicts.items()}
    worst = worst_class([verdict.met for verdict in verdicts.values()], norm.classes)
    return AtPlace(**verdicts, worst=worst, deciding_axis=_deciding_axis(verdicts, norm))


def _open(verdict: Verdict) -> Verdict:
    """A verdict by peaks of which some part is not known: they may be larger."""
    return verdict.changed(decided=False, undecided_bands_hz=tuple(dict.fromkeys((*verdict.undecided, WHOLE))))


def worst_class(classes: Sequence[str | None], order: Sequence[str]) -> str | None:
    """The coarsest of several classes; None (not even the coarsest is met) is worst of all.

    ``order`` is that of the norm's classes, coarsest first.
    """
    return None if None in classes else min((name for name in classes if name is not None), key=list(order).index)


def _deciding_axis(verdicts: Mapping[str, Verdict], norm: Norm) -> str | None:
    """The axis with the coarsest class, and of those the one nearest to the limit; None where nothing is known."""
    known = [axis for axis, verdict in verdicts.items() if verdict.deciding_band is not None]
    return min(known, key=lambda axis: norm.rank(verdicts[axis]), default=None)
