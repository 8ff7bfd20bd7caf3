"""What the norms say of all places: the verdict by the worst of them in words, and what they leave undecided."""

from collections.abc import Mapping
from typing import Any, Final, Self

import numpy as np

from ehamj.criteria.curves import Norm
from ehamj.criteria.own import OwnLimits, OwnNorm
from ehamj.criteria.verdict import Verdict
from ehamj.estimate.bands import Band
from ehamj.estimate.counted import settled
from ehamj.estimate.sliding import least_length
from ehamj.estimate.statistics import SHORT, WORDS, Statistic
from ehamj.findings import Finding
from ehamj.judge.actuation import DIRECTIONS
from ehamj.judge.headline import Direction, direction
from ehamj.judge.levels import Levels
from ehamj.judge.peaks import Peaks
from ehamj.judge.places import PEAKS_TO, AtPlace, at_place
from ehamj.plant.axes import AXES

OLDER: Final = ", of the centre of gravity alone (an earlier version's result: run it again for the worst place)"
"""What to know of a verdict that an earlier version gave."""


class InWords(Finding):
    """The verdict of floor and machine at its worst place in words: along z, across, and of all axes together."""

    overall: str | None = None
    """Only of machines that are actuated in all six motions, whose verdict it is."""
    vertical: str
    horizontal: str


class Directions(Finding):
    """What decides along z, across, and of all axes together."""

    overall: Direction | None = None
    """Only of machines that are actuated in all six motions."""
    vertical: Direction
    horizontal: Direction

    @property
    def verdict(self) -> Direction:
        """The one that is the machine's verdict: of all axes where all are actuated, else the vertical."""
        return self.overall or self.vertical

    @classmethod
    def of(cls, places: Mapping[str, AtPlace], norm: Norm, levels: Levels) -> Self:
        """Of all places; arguments as of `ehamj.judge.headline.direction`."""
        return cls(**{name: direction(places, DIRECTIONS[name], norm, levels) for name in levels.actuated})

    def in_words(self, actuated: Mapping[str, str]) -> InWords:
        """The classes of floor and machine, and how each direction is ``actuated``."""
        return InWords(**{name: getattr(self, name).classes(words) for name, words in actuated.items()})


class ByNorm(Finding):
    """What one norm says of every place."""

    title: str
    places: dict[str, AtPlace]
    verdict: InWords
    own_limits: OwnLimits | None = None
    """What it judged by, where that is a user's file; of other norms no key."""


class Beside(Finding):
    """What the first norm says of floor and machine by another statistic of the levels."""

    floor: AtPlace
    machine: AtPlace
    """At its centre of gravity."""
    places: dict[str, AtPlace] | None = None
    """Every place; None in a result that is older."""
    verdict: InWords


class Criterion(Finding):
    """What the first norm says of floor and machine."""

    title: str = ""
    """Of the norm, with its rule at low frequency."""
    floor: AtPlace
    machine: AtPlace
    """At its centre of gravity."""
    decisive: Directions | None = None
    """By the worst of all places; None in a result that is older, whose verdict is that of the centre of gravity."""
    verdict: InWords
    max_1s: Beside | None = None
    """By the largest sliding 1 s RMS; None for a norm of peaks, and in a result that is older."""

    def lines(self, short: bool = False) -> dict[str, str]:
        """The headline: the verdict of each direction with place, margin and band, and by which rule and levels.

        The keys are ``vertical``, ``horizontal``, ``judged by``, and ``by the largest 1 s RMS`` where a norm has it;
        before them ``overall`` of a machine that is actuated in all six motions, whose verdict that is. A ``short`` one
        tells of the machine's worst place alone, and neither of its other places, nor of the floor's worst mount, nor
        of the largest 1 s RMS.
        """
        found = {name: self._line(name, short) for name in self.verdict}
        if said := self.judged_by():
            found["judged by"] = said
        if not short and self.max_1s is not None and "max_1s" not in self._statistics():
            beside = (f"{name} {getattr(self.max_1s.verdict, name)}" for name in self.max_1s.verdict)
            found[f"by the {SHORT['max_1s']}"] = "; ".join(beside)
        return found

    def judged_by(self, words: Mapping[Statistic, str] = WORDS) -> str:
        """By which rule and levels, each statistic in some words; empty where nothing is."""
        by = " and ".join(words[name] for name in self._statistics())
        return ", ".join(text for text in (self.title, by) if text)

    def briefly(self) -> dict[str, str]:
        """Of each direction the machine's class at its worst place, with margin and band."""
        if self.decisive is None:
            return {name: self._line(name) for name in self.verdict}
        return {name: getattr(self.decisive, name).machine() for name in self.verdict}

    def _line(self, name: str, short: bool = False) -> str:
        said = str(getattr(self.verdict, name))
        if self.decisive is None:
            told = [one for place in (self.floor, self.machine) for one in place.along(DIRECTIONS[name])]
            return f"{said}{OLDER}" if any(one.deciding_band for one in told) else "not judged: no band is decided"
        if short:
            details = getattr(self.decisive, name).at_worst()
        elif self.decisive.overall is not None and name != "overall":
            details = f"Machine worst: {getattr(self.decisive, name).worst.briefly()}"
        else:
            details = getattr(self.decisive, name).details()
        return f"{said}. {details}" if details else said

    def _statistics(self) -> list[Statistic]:
        """Of the levels that decide, each once."""
        verdicts = [*self.floor.along(AXES), *self.machine.along(AXES)]
        if self.decisive is not None:
            directions = (self.decisive.vertical, self.decisive.horizontal)
            verdicts = [one.verdict for found in directions for one in (found.floor, found.worst)]
        return list(dict.fromkeys(one.statistic for one in verdicts if one.statistic is not None))


def criterion(norm: Norm, judged: ByNorm, levels: Levels, peaks: Peaks | None = None) -> Criterion:
    """What a norm says of floor and machine, beside it by the largest 1 s RMS where it limits levels in bands."""
    found: dict[str, Any] = {}
    if beside := strongest_second(norm):
        loudest = {place: at_place(beside, levels, place, peaks) for place in judged.places}
        words = Directions.of(loudest, beside, levels).in_words(levels.actuated)
        found["max_1s"] = Beside(floor=loudest["floor"], machine=loudest["machine"], places=loudest, verdict=words)
    return Criterion(
        title=norm.title,
        floor=judged.places["floor"],
        machine=judged.places["machine"],
        decisive=Directions.of(judged.places, norm, levels),
        verdict=judged.verdict,
        **found,
    )


def strongest_second(norm: Norm) -> Norm | None:
    """A norm by the largest sliding 1 s RMS; None where all its limits are peaks."""
    return norm.by("max_1s", every=True) if norm.statistics - {"peak"} else None


def by_norm(norm: Norm, levels: Levels, peaks: Peaks | None = None, usable_to: float = np.inf) -> ByNorm:
    """Title of the norm, what it says of each place, and the verdict in words; see `at_place`."""
    places = {place: at_place(norm, levels, place, peaks, usable_to) for place in levels.places}
    own = {"own_limits": norm.stated} if isinstance(norm, OwnNorm) else {}
    verdict = Directions.of(places, norm, levels).in_words(levels.actuated)
    return ByNorm(title=norm.title, places=places, verdict=verdict, **own)


def undecided(
    norms: Mapping[str, Norm], seconds: float, rate: float, usable_to: float, usable_from: float = 0.0
) -> list[str]:
    """In words: bands that the norms need, and that a longer run or a higher recording rate would decide.

    Args:
        norms: by name.
        seconds: length of the record from which levels are taken [s].
        rate: recording rate [Hz].
        usable_to: frequency above which the ground is not known [Hz]; `unheld` tells of such bands.
        usable_from: frequency below which it is not known [Hz].
    """
    needed = {name: {band for axis in AXES for band in norm.needed(axis)} for name, norm in norms.items()}
    everything = sorted(set().union(*needed.values()), key=lambda band: band.index)
    known = [band for band in everything if _held(band, usable_to, usable_from)]
    taken = {statistic for norm in norms.values() for _, statistic in norm.kinds if statistic != "peak"}
    least = {band: max(least_length(band, statistic) for statistic in taken) for band in known}
    short = [band for band in known if seconds < least[band]]
    fast = [band for band in known if band.edges[1] > 0.5 * rate]
    found = []
    if short:
        enough = _enough(max(least[band] for band in short))
        found.append(f"the run is too short to decide {_which(short, needed)}; duration = {enough} s would")
    if fast:
        found.append(f"record_rate = {rate:g} Hz is too low to decide {_which(fast, needed)}")
    return found


def _enough(wanted: float) -> int:
    """Shortest run in whole seconds whose levels are of a longer time than is wanted [s]."""
    return next(whole for whole in range(1, 10**6) if whole - settled(whole) > wanted)


def decided_after(norm: Norm, rate: float, usable_to: float, usable_from: float) -> int:
    """Length from which on a part of a run decides every band that a norm needs and that can be decided [s].

    Args:
        norm: that judges.
        rate: recording rate [Hz].
        usable_to: frequency above which the ground is not known [Hz].
        usable_from: frequency below which it is not known [Hz].
    """
    needed = {band for axis in AXES for band in norm.needed(axis)}
    taken = [statistic for _, statistic in norm.kinds if statistic != "peak"]
    bands = [band for band in needed if _held(band, usable_to, usable_from) and band.edges[1] <= 0.5 * rate]
    return _enough(max((least_length(band, statistic) for band in bands for statistic in taken), default=0.0))


def unheld(norms: Mapping[str, Norm], found: Mapping[str, ByNorm], usable_to: float, usable_from: float) -> list[str]:
    """In words: norms that need bands of which the ground says nothing, so that the classes named are no verdicts.

    Args:
        norms: by name.
        found: what they say of a run.
        usable_to: frequency above which the ground is not known [Hz].
        usable_from: frequency below which it is not known [Hz].
    """
    missing: dict[str, set[Band]] = {}
    axes: dict[str, None] = {}
    for name, norm in norms.items():
        places = [found[name].places[who] for who in ("floor", "machine")]
        left_open = [axis for axis in AXES if not all(verdict.decided for p in places for verdict in p.along(axis))]
        missing[name] = {b for axis in left_open for b in norm.needed(axis) if not _held(b, usable_to, usable_from)}
        axes |= dict.fromkeys(left_open if missing[name] else ())
    everything = sorted(set().union(*missing.values()), key=lambda band: band.index)
    low = [band for band in everything if band.edges[0] < usable_from]
    high = [band for band in everything if band.edges[1] > usable_to]
    sides = ((low, f"from {usable_from:.3g} Hz on"), (high, f"up to {usable_to:.3g} Hz"))
    limited = [name for name, norm in norms.items() if usable_to < PEAKS_TO and "peak" in norm.statistics]
    said = []
    if peaks := [name for name in limited if not all(verdict.decided for verdict in _every(found[name]))]:
        said.append(
            f"no verdict by {', '.join(peaks)}: peaks need the ground up to {PEAKS_TO:g} Hz, and it is known up to "
            f"{usable_to:.3g} Hz only; classes named are the best that may be met"
        )
    if not everything:
        return said
    along = "" if len(axes) == len(AXES) else f" along {', '.join(axes)}"
    known = " and ".join(end for own, end in sides if own)
    wanted = " and ".join(_which(own, missing) for own, _ in sides if own)
    return [
        *said,
        f"no verdict{along}: the ground is known {known} only, and a verdict needs {wanted}; classes named are the "
        "best that may be met",
    ]


def _every(judged: ByNorm) -> list[Verdict]:
    return [verdict for who in ("floor", "machine") for verdict in judged.places[who].along(AXES)]


def _held(band: Band, usable_to: float, usable_from: float) -> bool:
    """Whether the ground is known in all of a band."""
    return usable_from <= band.edges[0] and band.edges[1] <= usable_to


def _which(several: list[Band], needed: Mapping[str, set[Band]]) -> str:
    """Bands in words, and the norms that need them."""
    first, last = several[0].name, several[-1].name
    span = f"the band at {first} Hz" if first == last else f"the bands from {first} to {last} Hz"
    return f"{span} ({', '.join(name for name, own in needed.items() if own & set(several))})"
