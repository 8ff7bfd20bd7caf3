"""The headline: what a norm says where floor and machine are worst, with margin, band and the estimate's scatter.

A direction is judged by the worst of the places of the machine: its centre of gravity, each foot and every point. One
that is better says nothing of what stands elsewhere on the machine.
"""

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
from pydantic import Field

from ehamj.criteria.curves import WHOLE, Norm, Verdict, where
from ehamj.estimate.sliding import averaging_time
from ehamj.findings import Finding, finite
from ehamj.judge.levels import Levels
from ehamj.judge.places import AtPlace
from ehamj.plant.axes import AXES

DIRECTIONS: Final = {"vertical": ("z",), "horizontal": ("x", "y")}
"""Axes of each direction that is judged apart from the other."""
ACTUATED: Final = {"vertical": "actuated", "horizontal": "not actuated"}

AT_BEST: Final = "at best"
"""Before a class that is met as far as bands are known."""
AT_REST: Final = 100.0
"""Margin above which nothing moves that anybody would call a vibration [dB]."""
FEW: Final = 4
"""Undecided bands that a headline still names one by one."""
DEVIATIONS: Final = 2.0
"""Standard deviations that count as scatter: 95 of 100 estimates lie within."""
DECILES: Final = 2.563
"""Between the levels exceeded for 10 and for 90 % of the time, in standard deviations of a normal distribution."""
STATIONARY: Final = 2.0
"""Spread of the windows' mean squares, over that of white noise in the band, above which noise is not stationary."""


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
        verdict = self.verdict
        return verdict.met is not None and (verdict.margin_db is None or verdict.margin_db > AT_REST)

    def class_in_words(self, undecided: Sequence[str] = ()) -> str:
        """The class met, at best where bands are ``undecided``, or that not even the coarsest is."""
        verdict = self.verdict
        if verdict.deciding_band is None:
            return "not judged"
        if verdict.met is None:
            return f"worse than {verdict.next_class}"
        if undecided:
            return f"{AT_BEST} {verdict.met}"
        return "at rest" if self.at_rest else verdict.met

    def reason(self) -> str:
        """Distance to the limit of the class, and to that of the next stricter, each with its band and scatter."""
        verdict = self.verdict
        if verdict.deciding_band is None:
            return ""
        if self.at_rest:
            return "at rest"
        below, above = verdict.margin_db, verdict.excess_db
        here, there = where([verdict.deciding_band]), where([verdict.next_band or verdict.deciding_band])
        found = []
        if below is not None:
            chance = scatter_in_words(below, self.scatter_db)
            own = f" {here}{chance}" if chance or here != there or above is None else ""
            found.append(f"{decibel(below)} dB below its limit{own}")
        if above is not None:
            of = f"that of {verdict.next_class}" if found else "its limit"
            found.append(f"{decibel(above)} dB above {of} {there}{scatter_in_words(above, self.next_scatter_db)}")
        return " and ".join(found)

    def briefly(self) -> str:
        """Place, class, margin and band, as they stand beside others."""
        verdict, along = self.verdict, "" if self.axis == "z" else f", {self.axis}"
        if verdict.deciding_band is None:
            return f"{self.at} not judged"
        said = "at rest" if self.at_rest else ""
        if not said and verdict.margin_db is not None:
            said = f"{decibel(verdict.margin_db)} dB below{along}, {band_in_words(verdict.deciding_band)}"
        elif not said:
            said = f"{decibel(verdict.excess_db or 0.0)} dB above{along}, {band_in_words(verdict.deciding_band)}"
        return f"{self.at} {self.class_in_words()} ({said})"


class Direction(Finding):
    """What decides along some axes: of the floor, and of the machine at its worst place, the others beside it."""

    floor: Decisive
    worst: Decisive
    others: list[Decisive]
    """The other places of the machine, worst first."""
    bands: int
    """How many bands could decide about the machine."""
    undecided: tuple[str, ...] = Field(alias="undecided_bands_hz")
    """Those that are not known: the class is then one that is met at best."""
    floor_bands: int
    floor_undecided: tuple[str, ...] = Field(alias="floor_undecided_bands_hz")

    def classes(self, name: str) -> str:
        """The classes of floor and machine in words, and how many bands they leave open; ``name`` of the direction."""
        sides = ((self.floor, self.floor_bands, self.floor_undecided), (self.worst, self.bands, self.undecided))
        floor, machine = (one.class_in_words(missing) for one, _, missing in sides)
        left = dict.fromkeys(open_in_words(bands, missing) for _, bands, missing in sides)
        if len(left) > 1:  # each by itself
            floor, machine = (
                f"{one.class_in_words(missing)}" + (f" ({open_in_words(bands, missing)})" if missing else "")
                for one, bands, missing in sides
            )
            left = {"": None}
        said = f"floor {floor}, machine {machine} ({ACTUATED[name]})"
        return ": ".join(text for text in (said, *left) if text)

    def details(self) -> str:
        """Where floor and machine are worst, by how much, and how the machine's other places stand."""
        sides = (("machine", self.worst, self.others), ("floor", self.floor, ()))
        found = []
        for what, worst, others in sides:
            if worst.verdict.deciding_band is not None and not worst.at_rest:
                found.append(f"{what} worst at {worst.where}: {worst.reason()}")
                found += [", ".join(other.briefly() for other in others)] if others else []
        said = "; ".join(found)
        return f"{said[:1].upper()}{said[1:]}"

    def machine(self) -> str:
        """The machine's class at its worst place with margin and band, as a table of several runs holds it."""
        met = self.worst.class_in_words(self.undecided)
        left = open_in_words(self.bands, self.undecided)
        met = f"{met}: {left}" if left else met
        if self.worst.verdict.deciding_band is None or self.worst.at_rest:
            return met
        return f"{met}; worst at {self.worst.where}, {self.worst.reason()}"


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


def scatter_in_words(distance: float, scatter: float | None) -> str:
    """What to know of a distance to a limit [dB] that chance alone may have made."""
    if scatter is None or abs(distance) > scatter:
        return ""
    return f" (within the scatter of the estimate, ±{decibel(scatter)} dB)"


def direction(places: Mapping[str, AtPlace], axes: Sequence[str], norm: Norm, levels: Levels) -> Direction:
    """What decides along some axes.

    Args:
        places: what the norm says of each, the floor among them.
        axes: of the direction.
        norm: that judged.
        levels: by which it did.
    """
    found = {place: _decisive(place, judged, axes, norm, levels) for place, judged in places.items()}
    floor = found.pop("floor")
    ranked = sorted(found.values(), key=lambda one: _rank(one, norm))
    bands, missing = _left_open([places[place] for place in found], axes, ranked[0], norm)
    floor_bands, floor_missing = _left_open([places["floor"]], axes, floor, norm)
    return Direction(
        floor=floor,
        worst=ranked[0],
        others=ranked[1:],
        bands=bands,
        undecided=missing,
        floor_bands=floor_bands,
        floor_undecided=floor_missing,
    )


def _rank(one: Decisive, norm: Norm) -> tuple[float, float]:
    """The less, the worse; what is not known comes last."""
    return (np.inf, 0.0) if one.verdict.deciding_band is None else norm.rank(one.verdict)


def _decisive(place: str, judged: AtPlace, axes: Sequence[str], norm: Norm, levels: Levels) -> Decisive:
    known = [axis for axis in axes if judged[axis].deciding_band is not None] or list(axes)
    axis = min(known, key=lambda axis: norm.rank(judged[axis]))
    verdict: Verdict = judged[axis]
    mount: int | None = None
    scatters: list[float | None] = [None, None]
    if verdict.statistic != "peak" and verdict.deciding_band is not None:
        mount = levels.loudest(place, norm.kind_at(verdict, axis), axis, verdict.deciding_band)
    if verdict.statistic == "rms":
        scatters = [scatter(levels, place, mount, axis, band) for band in (verdict.deciding_band, verdict.next_band)]
    return Decisive(
        place=place,
        mount=None if mount is None else levels.mounts[mount],
        axis=axis,
        verdict=verdict,
        scatter_db=scatters[0],
        next_scatter_db=scatters[1],
    )


def _left_open(
    places: Sequence[AtPlace], axes: Sequence[str], decisive: Decisive, norm: Norm
) -> tuple[int, tuple[str, ...]]:
    """How many bands could make the class of a direction coarser, and those of them that are not known."""
    met, nothing = decisive.verdict.met, decisive.verdict.deciding_band is None
    could = {axis: norm.could_decide(axis, met, nothing) for axis in axes}
    order = list(dict.fromkeys(name for axis in axes for name in could[axis]))  # in each from low to high
    missing = {name for place in places for axis in axes for name in place[axis].undecided if name in could[axis]}
    return len(order), tuple(name for name in order if name in missing)


def scatter(levels: Levels, place: str, mount: int | None, axis: str, band: str | None) -> float | None:
    """By how much the RMS of a whole run may differ from that of a longer one, two standard deviations [dB].

    The run's mean square is the mean of those of its windows, T/τ of them that do not overlap (τ: 1 s, or 1/bandwidth
    where that is longer). Their spread is read from the levels exceeded for 10 and 90 % of the time, taken as those of
    a normal distribution: for stationary noise this gives 1/√(bandwidth · T) of the mean square, for a steady line 0.

    None where the levels over time are not known, and of peaks.
    """
    row = levels.row(band)
    if row is None:
        return None
    at = (row, *(() if mount is None else (mount,)), AXES.index(axis))
    rms, high, low = (float(levels.places[place]["velocity", name][at]) for name in ("rms", "l10", "l90"))
    if not rms > 0.0 or levels.seconds <= 0.0:
        return None
    spread = (high**2 - low**2) / DECILES / rms**2
    time = averaging_time(levels.bands[row], "max_1s")
    if not spread <= STATIONARY / np.sqrt(levels.bands[row].width * time):
        return None
    return finite(DEVIATIONS * 10.0 / np.log(10.0) * spread / np.sqrt(levels.seconds / time))
