"""What decides about one place, in words: its class, the distance to limits, and what chance may have made of it."""

from collections.abc import Sequence
from typing import Final

from ehamj.criteria.verdict import WHOLE, Verdict, where
from ehamj.estimate.statistics import Statistic
from ehamj.findings import Finding

AT_BEST: Final = "at best"
"""Before a class that is met as far as bands are known."""
RESTING: Final = "at rest"
"""What stands for the class of what does not move."""
CLOSE: Final = 0.5
"""Distance to a limit below which it is told that the level's scatter is not known [dB]."""
UNITS: Final = {
    "displacement": ((1e6, "µm"), (1e3, "mm")),
    "velocity": ((1e6, "µm/s"), (1e3, "mm/s")),
    "acceleration": ((1e3, "mm/s²"), (1.0, "m/s²")),
}
"""Factor and unit of each quantity that a norm limits, for small and for large values."""
FEW: Final = 4
"""Undecided bands that a headline still names one by one."""


class Decisive(Finding):
    """What decides about a place along the axis where it is worst."""

    place: str
    """``floor``, ``feet``, ``machine`` (its centre of gravity) or a point."""
    mount: str | None = None
    """Of floor and feet: the mount that is worst."""
    axis: str
    verdict: Verdict
    scatter_db: float | None = None
    """By how much the level in the deciding band may differ by chance, see `scatter`; None: not known."""
    next_scatter_db: float | None = None
    """The same in the band that decides about the next stricter class."""

    @property
    def at(self) -> str:
        """The place in words."""
        return place_in_words(self.place, self.mount)

    @property
    def where(self) -> str:
        """The place in words, and the axis where there are several."""
        return self.at if self.axis == "z" else f"{self.at} along {self.axis}"

    @property
    def at_rest(self) -> bool:
        """Whether nothing moves there along its axes."""
        return self.verdict.at_rest

    def class_in_words(self, undecided: Sequence[str] = ()) -> str:
        """The class met, at best where bands are ``undecided``, or that not even the coarsest is."""
        verdict = self.verdict
        if verdict.deciding_band is None:
            return "not judged"
        if verdict.met is None:
            return f"worse than {verdict.next_class}"
        return met_in_words(verdict, not undecided)

    def reason(self) -> str:
        """Level and distance to the limit of the class, and to that of the next stricter, with band and scatter."""
        verdict = self.verdict
        if verdict.deciding_band is None:
            return ""
        if self.at_rest:
            return RESTING
        below, above = verdict.margin_db, verdict.excess_db
        here, there = where([verdict.deciding_band]), where([verdict.next_band or verdict.deciding_band])
        level, limit = level_and_limit(verdict)
        found = []
        if below is not None:
            chance = scatter_in_words(below, self.scatter_db, verdict.statistic)
            own = f" {here}{chance}" if chance or here != there or above is None else ""
            found.append(f"{level}{decibel(below)} dB below its limit{limit}{own}")
        if above is not None:
            of = f"that of {verdict.next_class}" if found else f"its limit{limit}"
            level = "" if found else level
            chance = scatter_in_words(above, self.next_scatter_db, verdict.statistic)
            found.append(f"{level}{decibel(above)} dB above {of} {there}{chance}")
        return " and ".join(found)

    def briefly(self) -> str:
        """Place, class, margin and band, as they stand beside others."""
        verdict, along = self.verdict, "" if self.axis == "z" else f", {self.axis}"
        if verdict.deciding_band is None:
            return f"{self.at} not judged"
        if self.at_rest:
            return f"{self.at} {RESTING}"
        distance, side = verdict.margin_db, "below"
        if distance is None:
            distance, side = verdict.excess_db or 0.0, "above"
        said = f"{decibel(distance)} dB {side}{along}, {band_in_words(verdict.deciding_band)}"
        return f"{self.at} {self.class_in_words()} ({said})"


def unit_of(quantity: str, value: float) -> tuple[float, str]:
    """Factor and unit in which a value [SI] of a quantity has few digits."""
    small, large = UNITS[quantity]
    return small if abs(value) * small[0] < 1e3 else large


def level_and_limit(verdict: Verdict) -> tuple[str, str]:
    """The level that decided, and its limit, as they stand in a sentence; empty where a peak decided."""
    if verdict.level is None or verdict.limit is None or verdict.quantity is None:
        return "", ""
    factor, unit = unit_of(verdict.quantity, verdict.limit)
    return f"{factor * verdict.level:.3g} {unit}, ", f" of {factor * verdict.limit:.4g} {unit}"


def met_in_words(verdict: Verdict, decided: bool) -> str:
    """A class that is met, if undecided at best; of what does not move in the bands that are known, that it is so."""
    if verdict.at_rest:
        return RESTING if decided else f"{RESTING} as far as known"
    return f"{verdict.met}" if decided else f"{AT_BEST} {verdict.met}"


def place_in_words(place: str, mount: str | None = None) -> str:
    """What a person calls a place of the summary, and the mount of floor and feet."""
    if place in ("floor", "feet"):
        what = "mount" if place == "floor" else "foot"
        return f"worst {what}" if mount is None else f"{what} {mount}"
    return "centre of gravity" if place == "machine" else place


def open_in_words(bands: int, undecided: Sequence[str]) -> str:
    """How many of the bands that could decide are undecided, and which, if they are few."""
    if not undecided:
        return ""
    if WHOLE in undecided and bands == 1:
        return "the peak is undecided"
    which = f" ({band_in_words(', '.join(undecided))})" if len(undecided) <= FEW and WHOLE not in undecided else ""
    return f"{len(undecided)} of {bands} bands undecided{which}"


def band_in_words(band: str) -> str:
    """A band, or what stands for it where the whole history decides."""
    return "peak" if band == WHOLE else f"{band} Hz"


def decibel(value: float) -> str:
    """A distance to a limit [dB]: to a tenth, below that to a hundredth."""
    if abs(value) < 0.005:
        return "less than 0.01"
    return f"{value:.{1 if abs(value) >= 0.095 else 2}f}"


def scatter_in_words(distance: float, scatter: float | None, statistic: Statistic | None) -> str:
    """What to know of a distance to a limit [dB] that chance alone may have made.

    Args:
        distance: to the limit [dB].
        scatter: of the level [dB]; None where it is not known.
        statistic: of the level; of an RMS over the whole run it is told that its scatter is not known.
    """
    if scatter is None:
        unknown = statistic == "rms" and abs(distance) < CLOSE
        return " (scatter of the estimate not known: the motion varies, or the run is short)" if unknown else ""
    return f" (within the scatter of the estimate, ±{decibel(scatter)} dB)" if abs(distance) <= scatter else ""
