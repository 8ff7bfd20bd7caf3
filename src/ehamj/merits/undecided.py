"""Figures in bands that no run of a scenario can have: it is too short for them, or recorded too slowly."""

from collections.abc import Iterator

from ehamj.criteria import vc
from ehamj.criteria.curves import CANDIDATES
from ehamj.estimate.bands import Band
from ehamj.estimate.counted import LEAST_BINS, Counted, settled
from ehamj.judge.levels import BANDS
from ehamj.run.figures import Path
from ehamj.scenario.model import Scenario

IN_BANDS = ("attenuation_db", "attenuation_at_db", "third_octave_")
"""How the first key of figures begins whose last one is a band."""


def undecided(scenario: Scenario, path: Path) -> str:
    """Why no run of a scenario has a number, in words that name the way out; nothing of those that it may have.

    Args:
        scenario: what is run.
        path: keys of the number, as `ehamj.run.figures.figures` takes them.
    """
    rate = scenario.record_rate
    counted = Counted(round(scenario.duration * rate) + 1, rate)
    missing = [band for band in _bands(scenario, path) if not counted.decides(band)]
    if not missing:
        return ""
    fast = max(missing, key=lambda band: band.centre)
    if fast.edges[1] > 0.5 * rate:
        return f"its {fast.name} Hz band ends above half of record_rate = {rate:g} Hz"
    slow = min(missing, key=lambda band: band.width)
    said = f"its {slow.name} Hz band needs duration = {_enough(slow):g} s, runs take {scenario.duration:g} s"
    if path[0] == "below" and scenario.criteria.low_frequency == "flat":
        said += "; with criteria.low_frequency = 'classic' it has none below 4 Hz"
    return said


def _bands(scenario: Scenario, path: Path) -> Iterator[Band]:
    """The bands that a number is of."""
    if path[0] == "below":
        flat = scenario.criteria.low_frequency == "flat"
        yield from (band for band in CANDIDATES if vc.limit(path[1], band, flat) is not None)
    elif path[0].startswith(IN_BANDS):
        yield from (band for band in BANDS if band.name == path[-1])


def _enough(band: Band) -> float:
    """A duration that decides a band, to a tenth [s]."""
    length = LEAST_BINS / band.width
    duration = length
    for _ in range(50):  # what settles is a part of it
        duration = length + settled(duration)
    return round(duration + 0.06, 1)
