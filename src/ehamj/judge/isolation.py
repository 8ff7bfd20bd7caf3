"""How well a run is isolated: attenuation and levels in third-octaves, and what the norms say of every place."""

from collections.abc import Mapping
from typing import Any, Final, Literal

import numpy as np
import xarray as xr
from pydantic import Field

from ehamj.columns import columns
from ehamj.criteria.curves import ORDERS, Kind, Norm
from ehamj.criteria.settings import CriteriaSettings
from ehamj.estimate.counted import LONGEST_TAPER, settled
from ehamj.estimate.sliding import TIMES, averaging_time
from ehamj.estimate.statistics import BandStatistic
from ehamj.findings import Finding, finite
from ehamj.judge.attenuation import attenuation_at_cg, attenuation_at_places
from ehamj.judge.levels import BANDS, SLAB, ByBand, Levels, by_band, duration_of, known_bands, levels_of
from ehamj.judge.peaks import peaks_of
from ehamj.judge.transience import Transience, transience
from ehamj.judge.verdicts import ByNorm, Criterion, by_norm, criterion, strongest_second, undecided, unheld
from ehamj.plant.axes import AXES
from ehamj.plant.plant import Plant
from ehamj.records.units import Quantity

OUTSIDE = 1.5
"""Largest motion over that within what counts fully, above which it is worth a word."""

WORST_PLACE: Final = "worst place"
"""Of all places of the machine, the one with least attenuation in a band."""

Places = dict[str, dict[str, ByBand]]
"""Place → axis → band → level."""


class Analysis(Finding):
    """From when to when levels were taken [s], and up to where the ground is known [Hz] (None: everywhere)."""

    from_s: float
    to_s: float
    usable_to_hz: float | None
    usable_from_hz: float = 0.0
    """From where on the ground is known [Hz]."""


class Statistics(Finding):
    """Levels of each place that are not the whole run's RMS."""

    averaging_s: dict[BandStatistic, ByBand]
    """Averaging time of each statistic per band [s]."""
    velocity: dict[BandStatistic, Places]
    """RMS [m/s]."""
    displacement: dict[BandStatistic, Places] = Field(default_factory=dict)
    """RMS [m], where a norm limits it."""
    acceleration: dict[BandStatistic, Places] = Field(default_factory=dict)
    """RMS [m/s²], where a norm limits it."""
    peak: dict[str, dict[str, float | None]]
    """Place → axis → peak velocity of the history, all frequencies together [m/s]."""


class Isolation(Finding):
    """Attenuation and criteria of a run.

    Places are the floor (its worst mount), the feet (the worst), the machine (its CG) and each named point.
    """

    attenuation_db: dict[str, ByBand]
    """Per axis and for rx, ry, rz, of the CG: band → dB, positive: quieter than the floor, None: undecided."""
    attenuation_at_db: Places
    """The same for x, y, z at the feet (worst of foot over its own ground) and each point."""
    statistic: Literal["rms"] = "rms"
    """Of the levels that follow, and of those that attenuation is of: RMS over the whole run."""
    third_octave_velocity: Places
    """RMS [m/s]."""
    third_octave_displacement: Places | None = None
    """RMS [m], where a norm limits it."""
    third_octave_acceleration: Places | None = None
    """RMS [m/s²], where a norm limits it."""
    levels: Statistics | None = None
    """By other statistics; None in a result that is older."""
    floor_transient: bool | None = None
    """Whether the floor's largest second exceeds what stationary noise has by chance; None where nothing is known."""
    transience: Transience | None = None
    """Where that second is strongest; None where the floor is not transient."""
    criterion: Criterion
    """By the first norm."""
    criteria: dict[str, ByNorm]
    """By each norm."""
    analysis: Analysis

    def attenuation_at_worst(self, axis: str) -> ByBand:
        """Least attenuation of all places along x, y or z: band → dB, None where it is undecided at the CG."""
        tables = [self.attenuation_db[axis], *(table[axis] for table in self.attenuation_at_db.values())]
        return {
            band: None if own is None else min(v for table in tables if (v := table.get(band)) is not None)
            for band, own in tables[0].items()
        }

    def attenuation_first(self) -> dict[str, dict[str, ByBand]]:
        """The attenuation that is told first: motion → where → band → dB.

        Vertical, at the worst place and at the centre of gravity; of a machine that is actuated in all six motions that
        of each, where it is worst.
        """
        decisive = self.criterion.decisive
        if decisive is None or decisive.overall is None:
            return {"z": {WORST_PLACE: self.attenuation_at_worst("z"), "centre of gravity": self.attenuation_db["z"]}}
        along = {axis: {WORST_PLACE: self.attenuation_at_worst(axis)} for axis in ("z", "x", "y")}
        return along | {turn: {"rotation": self.attenuation_db[turn]} for turn in SLAB[len(AXES) :]}

    def in_bands(self, quantity: Quantity, statistic: BandStatistic = "rms") -> Places:
        """Levels in bands of a quantity by a statistic; empty where these were not taken."""
        if statistic == "rms":
            return getattr(self, f"third_octave_{quantity}") or {}
        tables: dict[BandStatistic, Places] = getattr(self.levels, quantity) if self.levels else {}
        return tables.get(statistic, {})


def isolation(
    dataset: xr.Dataset,
    plant: Plant,
    rate: float,
    usable_to: float = float("inf"),
    norms: Mapping[str, Norm] | None = None,
    usable_from: float = 0.0,
) -> tuple[Isolation, list[str]]:
    """Attenuation and criteria of a run, and in words what to know of its levels.

    These words tell of bands that a longer run or a higher rate would decide, and of a floor that is transient.

    Args:
        dataset: of a result.
        plant: what was simulated; the mounts' positions count.
        rate: recording rate [Hz].
        usable_to: frequency above which the ground is not known [Hz].
        norms: that judge, by name, the one of the verdict first; those of a scenario that names none by default.
        usable_from: frequency below which the ground is not known [Hz].
    """
    norms = norms or CriteriaSettings().chosen()
    end = duration_of(dataset)
    begin = settled(end)
    known = known_bands(usable_from, usable_to)
    name, norm = next(iter(norms.items()))
    second = strongest_second(norm)
    limited: set[Kind] = set().union(*(one.kinds for one in norms.values()))
    levels = levels_of(dataset, plant, rate, known, limited | (second.kinds if second else set()))
    peaks = peaks_of(dataset, rate, norms.values())
    verdicts = {name: by_norm(one, levels, peaks, usable_to) for name, one in norms.items()}
    # Velocity, and what else the norms limit in bands.
    quantities = {"velocity"} | {quantity for quantity, statistic in limited if statistic != "peak"}
    tables = {
        f"third_octave_{quantity}": _table(levels, (quantity, "rms")) for quantity in ORDERS if quantity in quantities
    }
    strongest = transience(dataset, levels, rate)
    judged = criterion(norm, verdicts[name], levels, peaks)
    found = Isolation(
        attenuation_db=attenuation_at_cg(levels, plant),
        attenuation_at_db=attenuation_at_places(levels),
        statistic="rms",
        levels=_statistics(levels),
        floor_transient=strongest is not None,
        transience=strongest,
        criterion=judged,
        criteria=verdicts,
        analysis=Analysis(from_s=begin, to_s=end, usable_to_hz=finite(usable_to), usable_from_hz=usable_from),
        **tables,
    )
    beside = "" if judged.max_1s is None else ". The class by the largest second stands beside the verdict"
    words = [strongest.in_words() + beside] if strongest else []
    words += outside(dataset, begin, end)
    left_open = undecided(norms, end - begin, rate, usable_to, usable_from)
    return found, [*words, *left_open, *unheld(norms, verdicts, usable_to, usable_from)]


def outside(dataset: xr.Dataset, begin: float, end: float) -> list[str]:
    """In words: a floor whose largest motion falls near an end of the run, where levels in bands count it for less."""
    time, fade = dataset.time.values, min(LONGEST_TAPER, begin)
    within = (time >= begin) & (time <= end - fade)
    velocity = np.zeros(time.size)
    for one in columns(dataset["ground_velocity"].variable):
        np.maximum(velocity, np.abs(one), out=velocity)
    if not within.any() or velocity.max() <= OUTSIDE * velocity[within].max():
        return []
    row = int(np.argmax(velocity))
    return [
        f"the floor moves most, with {1e6 * velocity.max():.3g} µm/s, at {time[row]:.4g} s: levels in bands are taken "
        f"from {begin:g} to {end:g} s and fade over the last {fade:g} s, so that they miss it; let the run be longer, "
        "or the motion elsewhere"
    ]


def _table(levels: Levels, kind: Kind) -> Places:
    """Levels in bands of one kind."""
    return {place: by_band(levels.at(place)[kind], levels.bands) for place in levels.places}


def _statistics(levels: Levels) -> Statistics:
    """Levels that are not the whole run's RMS."""
    known = levels.at("floor").keys()
    found: dict[str, Any] = {
        quantity: {name: _table(levels, (quantity, name)) for name in TIMES if (quantity, name) in known}
        for quantity in ORDERS
    }
    peaks = {place: levels.at(place)["velocity", "peak"][0] for place in levels.places}
    return Statistics(
        averaging_s={name: {band.name: averaging_time(band, name) for band in BANDS} for name in TIMES},
        peak={place: dict(zip(AXES, map(finite, peak), strict=True)) for place, peak in peaks.items()},
        **found,
    )
