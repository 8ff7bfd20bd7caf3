"""What the page says in words: verdict, class met, and what failed."""

from typing import Final

from ehamj.criteria.curves import Norm
from ehamj.criteria.verdict import Verdict, where
from ehamj.judge.decisive import decibel, met_in_words, unit_of
from ehamj.judge.worse import made_worse
from ehamj.pages.words import number, scaled
from ehamj.plant.axes import AXES
from ehamj.report.shown import Results, Shown

WORSE: Final = "worse than its floor"
"""What the headline calls motion that the machine has more of."""


def verdict(shown: Shown) -> list[tuple[str, str]]:
    """The headline as the summary of the result reported says it, vertical apart from horizontal, and where the machine
    moves more than its floor."""
    whose = "" if shown.together else f"{shown.label}, "
    found = [(f"{whose}{name}", said) for name, said in shown.first.summary.lines().items()]
    if said := made_worse(shown.first.summary.worse):
        directions = len(shown.first.summary.directions) * max(1, len(shown.first.summary.parts()))
        found.insert(directions, (f"{whose}{WORSE}", said))
    return found


def class_met(verdict: Verdict, norm: Norm, worse: str, axis: str = "", place: str = "") -> str:
    """A class with its margin and the band that decides, and axis and place if given; ``worse`` than the coarsest one.

    A class is met at best where bands are not known in which the norm has limits.
    """
    if verdict.deciding_band is None:
        return "not judged"
    decided_by = where([verdict.deciding_band]) if verdict.peak is None else peak_in_words(verdict, norm)
    decided_by = f"{axis} {decided_by}" if axis else decided_by.removeprefix("at ")
    decided_by = f"{decided_by}, {place}" if place else decided_by
    if verdict.met is None:
        return f"{worse} {norm.classes[0]} ({decided_by})"
    met = met_in_words(verdict, verdict.decided)
    if verdict.at_rest:
        return met
    return f"{met} ({decibel(verdict.margin_db or 0.0)} dB, {decided_by})"


def peak_in_words(verdict: Verdict, norm: Norm) -> str:
    """The peak that decided, with its unit, and the frequency of its swing where that counts."""
    limits = (norm.limit(name, axis, None) for name in norm.classes for axis in AXES)
    limit = next((limit for limit in limits if limit is not None), None)
    factor, unit = unit_of(limit.quantity if limit is not None else "velocity", verdict.peak or 0.0)
    at = "" if verdict.peak_hz is None else f" at {number(verdict.peak_hz)} Hz"
    return f"peak {number(scaled(verdict.peak, factor))} {unit}{at}"


def failures(results: Results) -> list[tuple[str, str]]:
    """What went wrong in each run that is not complete."""
    return [
        (
            f"Incomplete: {label}" if len(results) > 1 else "Incomplete",
            f"{result.summary.failure or 'the simulation did not reach its end'}. Every number of this run below "
            "holds only until then.",
        )
        for label, result in results.items()
        if not result.complete
    ]
