"""What a norm says of each place: class per axis, the axis that decides, and the verdict in words."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ehamj.criteria import vc
from ehamj.criteria.curves import Norm, Verdict, judge
from ehamj.estimate.bands import Band
from ehamj.estimate.periodogram import LEAST_BINS
from ehamj.judge.levels import Measured, settled
from ehamj.plant.axes import AXES


def judged(norm: Norm, measured: Measured) -> dict[str, Any]:
    """Title of the norm, what it says of each place, and the verdict in words, as plain data.

    A class is ``decided`` if every band of the norm is known, or if even the coarsest class is not met.
    """
    places = {}
    for place in measured.places["velocity"]:
        verdicts = {}
        for k, axis in enumerate(AXES):
            levels = {quantity: table[place][:, k] for quantity, table in measured.places.items()}
            verdicts[axis] = judge(norm, axis, levels, measured.bands)
        places[place] = {
            **{axis: _plain(verdict, norm) for axis, verdict in verdicts.items()},
            "worst": worst_class([verdict.met for verdict in verdicts.values()], norm.classes),
            "deciding_axis": _deciding_axis(verdicts, norm),
        }
    verdict = {
        "vertical": f"{_sentence(places, ('z',), norm)} (actuated)",
        "horizontal": f"{_sentence(places, ('x', 'y'), norm)} (not actuated)",
    }
    return {"title": norm.title, "places": places, "verdict": verdict}


def _plain(verdict: Verdict, norm: Norm) -> dict[str, Any]:
    plain = {
        "class": verdict.met,
        "decided": bool(verdict.deciding_band) and (verdict.met is None or not verdict.undecided),
        "deciding_band_hz": verdict.deciding_band,
        "margin_db": verdict.margin_db,
        "next_class": verdict.next_class,
        "next_band_hz": verdict.next_band,
        "excess_db": verdict.excess_db,
        "undecided_bands_hz": list(verdict.undecided),
    }
    return plain | ({"factor": verdict.factor} if norm.base else {})


def worst_class(classes: list[str | None], order: Sequence[str] = tuple(vc.CLASSES)) -> str | None:
    """The coarsest of several classes; None (not even the coarsest is met) is worst of all.

    ``order`` is that of the norm's classes, coarsest first.
    """
    if None in classes:
        return None
    return min((name for name in classes if name is not None), key=list(order).index)


def _deciding_axis(verdicts: dict[str, Verdict], norm: Norm) -> str | None:
    """The axis with the coarsest class, and of those the one nearest to the limit; None where nothing is known."""

    def rank(axis: str) -> tuple[int, float]:
        verdict = verdicts[axis]
        if verdict.met is None:
            return -1, -(verdict.excess_db or 0.0)
        return norm.classes.index(verdict.met), np.inf if verdict.margin_db is None else verdict.margin_db

    known = [axis for axis, verdict in verdicts.items() if verdict.deciding_band is not None]
    return min(known, key=rank, default=None)


def _class_in_words(verdicts: list[dict[str, Any]], norm: Norm) -> str:
    if any(verdict["deciding_band_hz"] is None for verdict in verdicts):
        return "undecided"
    return worst_class([verdict["class"] for verdict in verdicts], norm.classes) or f"worse than {norm.classes[0]}"


def _sentence(places: dict[str, Any], axes: tuple[str, ...], norm: Norm) -> str:
    before, after = (_class_in_words([places[who][axis] for axis in axes], norm) for who in ("floor", "machine"))
    words = f"floor {before}, machine {after}"
    undecided = list(dict.fromkeys(band for axis in axes for band in places["machine"][axis]["undecided_bands_hz"]))
    return words + (f", undecided at {', '.join(undecided)} Hz" if undecided else "")


def undecided(norms: dict[str, Norm], seconds: float, rate: float, usable_to: float) -> list[str]:
    """In words: bands that the norms need, and that a longer run or a higher recording rate would decide.

    Args:
        norms: by name.
        seconds: length of the record from which levels are taken [s].
        rate: recording rate [Hz].
        usable_to: frequency above which the ground is not known [Hz]; such bands are the ground's to explain.
    """
    needed = {name: {band for axis in AXES for band in norm.needed(axis)} for name, norm in norms.items()}
    known = sorted((band for band in set().union(*needed.values()) if band.edges[1] <= usable_to), key=_place)
    short = [band for band in known if _width(band) * seconds < LEAST_BINS]
    fast = [band for band in known if band.edges[1] > 0.5 * rate]
    found = []
    if short:
        wanted = LEAST_BINS / _width(short[0])
        enough = next(whole for whole in range(1, 10**6) if whole - settled(whole) > wanted)
        found.append(
            f"the run is too short to decide {_span(short)} ({_who(short, needed)}); duration = {enough} s would"
        )
    if fast:
        found.append(f"record_rate = {rate:g} Hz is too low to decide {_span(fast)} ({_who(fast, needed)})")
    return found


def _place(band: Band) -> int:
    return band.index


def _width(band: Band) -> float:
    low, high = band.edges
    return high - low


def _span(several: list[Band]) -> str:
    if len(several) == 1:
        return f"the band at {several[0].name} Hz"
    return f"the bands from {several[0].name} to {several[-1].name} Hz"


def _who(several: list[Band], needed: dict[str, set[Band]]) -> str:
    return ", ".join(name for name, own in needed.items() if own & set(several))
