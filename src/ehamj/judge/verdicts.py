"""What a norm says of each place: class per axis, the axis that decides, and the verdict in words."""

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from ehamj.criteria.curves import WHOLE, Norm, Verdict, where
from ehamj.criteria.own import OwnLimits, OwnNorm
from ehamj.estimate.bands import Band
from ehamj.estimate.counted import settled
from ehamj.estimate.sliding import least_length
from ehamj.estimate.statistics import SHORT, WORDS
from ehamj.findings import Finding
from ehamj.judge.levels import Levels
from ehamj.judge.peaks import Peaks
from ehamj.plant.axes import AXES

PEAKS_TO: Final = 80.0
"""Frequency up to which the ground must be known for its peaks to be [Hz]: the common range of DIN 45669-1."""

AT_BEST: Final = "at best"
"""Before a class that is met as far as bands are known."""


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


class InWords(Finding):
    """The verdict of floor and machine in words, along z and across."""

    vertical: str
    horizontal: str


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
    verdict: InWords


class Criterion(Finding):
    """What the first norm says of floor and machine."""

    floor: AtPlace
    machine: AtPlace
    verdict: InWords
    max_1s: Beside | None = None
    """By the largest sliding 1 s RMS; None for a norm of peaks, and in a result that is older."""

    def lines(self) -> dict[str, str]:
        """The verdict as a reader is told it, each class with the statistic of the levels that it is by."""
        found: dict[str, str] = {}
        for direction, axes in (("vertical", ("z",)), ("horizontal", ("x", "y"))):
            parts = [*self.floor.along(axes), *self.machine.along(axes)]
            if all(verdict.deciding_band is None for verdict in parts):
                found[direction] = "not judged: the run is too short for any band of the criterion"
                continue
            by = dict.fromkeys(v.statistic for v in parts if v.statistic is not None)
            said = getattr(self.verdict, direction)
            found[direction] = f"{said}, by {' and '.join(WORDS[name] for name in by)}" if by else said
            if self.max_1s is not None and "max_1s" not in by:
                found[direction] += f"; {getattr(self.max_1s.verdict, direction)} by the {SHORT['max_1s']}"
        return found


def criterion(norm: Norm, judged: ByNorm, levels: Levels, peaks: Peaks | None = None) -> Criterion:
    """What a norm says of floor and machine, beside it by the largest 1 s RMS where it limits levels in bands."""
    places = {place: judged.places[place] for place in ("floor", "machine")}
    if beside := strongest_second(norm):
        loudest = {place: at_place(beside, levels, place, peaks) for place in places}
        words = InWords(vertical=_classes(loudest, ("z",), beside), horizontal=_classes(loudest, ("x", "y"), beside))
        return Criterion(**places, verdict=judged.verdict, max_1s=Beside(**loudest, verdict=words))
    return Criterion(**places, verdict=judged.verdict)


def strongest_second(norm: Norm) -> Norm | None:
    """A norm by the largest sliding 1 s RMS; None where all its limits are peaks."""
    return norm.by("max_1s", every=True) if norm.statistics - {"peak"} else None


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


def by_norm(norm: Norm, levels: Levels, peaks: Peaks | None = None, usable_to: float = np.inf) -> ByNorm:
    """Title of the norm, what it says of each place, and the verdict in words; see `at_place`."""
    places = {place: at_place(norm, levels, place, peaks, usable_to) for place in levels.places}
    own = {"own_limits": norm.stated} if isinstance(norm, OwnNorm) else {}
    return ByNorm(title=norm.title, places=places, verdict=_in_words(places, norm), **own)


def worst_class(classes: Sequence[str | None], order: Sequence[str]) -> str | None:
    """The coarsest of several classes; None (not even the coarsest is met) is worst of all.

    ``order`` is that of the norm's classes, coarsest first.
    """
    return None if None in classes else min((name for name in classes if name is not None), key=list(order).index)


def _deciding_axis(verdicts: Mapping[str, Verdict], norm: Norm) -> str | None:
    """The axis with the coarsest class, and of those the one nearest to the limit; None where nothing is known."""
    known = [axis for axis, verdict in verdicts.items() if verdict.deciding_band is not None]
    return min(known, key=lambda axis: norm.rank(verdicts[axis]), default=None)


def _in_words(places: Mapping[str, AtPlace], norm: Norm) -> InWords:
    return InWords(
        vertical=f"{_sentence(places, ('z',), norm)} (actuated)",
        horizontal=f"{_sentence(places, ('x', 'y'), norm)} (not actuated)",
    )


def _class_in_words(verdicts: Sequence[Verdict], norm: Norm) -> str:
    if any(verdict.deciding_band is None for verdict in verdicts):
        return "undecided"
    met = worst_class([verdict.met for verdict in verdicts], norm.classes)
    if met is None:
        return f"worse than {norm.classes[0]}"
    return met if all(verdict.decided for verdict in verdicts) else f"{AT_BEST} {met}"


def _sentence(places: Mapping[str, AtPlace], axes: Sequence[str], norm: Norm) -> str:
    missing = list(dict.fromkeys(band for verdict in places["machine"].along(axes) for band in verdict.undecided))
    return _classes(places, axes, norm) + (f", undecided {where(missing)}" if missing else "")


def _classes(places: Mapping[str, AtPlace], axes: Sequence[str], norm: Norm) -> str:
    before, after = (_class_in_words(places[who].along(axes), norm) for who in ("floor", "machine"))
    return f"floor {before}, machine {after}"


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
        wanted = max(least[band] for band in short)
        enough = next(whole for whole in range(1, 10**6) if whole - settled(whole) > wanted)
        found.append(f"the run is too short to decide {_which(short, needed)}; duration = {enough} s would")
    if fast:
        found.append(f"record_rate = {rate:g} Hz is too low to decide {_which(fast, needed)}")
    return found


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
