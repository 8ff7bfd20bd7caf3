"""How well a run is isolated: attenuation and levels in third-octaves, and what the norms say of every place."""

import xarray as xr

from ehamj.criteria.curves import ORDERS
from ehamj.criteria.settings import CriteriaSettings
from ehamj.findings import Finding, finite
from ehamj.judge.attenuation import attenuation_at_cg, attenuation_at_places
from ehamj.judge.levels import BANDS, ByBand, by_band, duration_of, levels_of, settled
from ehamj.judge.peaks import peaks_of
from ehamj.judge.verdicts import ByNorm, Criterion, by_norm, undecided, unheld
from ehamj.plant.plant import Plant

Places = dict[str, dict[str, ByBand]]
"""Place → axis → band → level."""


class Analysis(Finding):
    """From when to when levels were taken [s], and up to where the ground is known [Hz] (None: everywhere)."""

    from_s: float
    to_s: float
    usable_to_hz: float | None
    usable_from_hz: float = 0.0
    """From where on the ground is known [Hz]."""


class Isolation(Finding):
    """Attenuation and criteria of a run.

    Places are the floor (its worst mount), the feet (the worst), the machine (its CG) and each named point.
    """

    attenuation_db: dict[str, ByBand]
    """Per axis and for rx, ry, of the CG: band → dB, positive: quieter than the floor, None: undecided."""
    attenuation_at_db: Places
    """The same for x, y, z at the feet (worst of foot over its own ground) and each point."""
    third_octave_velocity: Places
    """RMS [m/s]."""
    third_octave_displacement: Places | None = None
    """RMS [m], where a norm limits it."""
    third_octave_acceleration: Places | None = None
    """RMS [m/s²], where a norm limits it."""
    criterion: Criterion
    """By the first norm."""
    criteria: dict[str, ByNorm]
    """By each norm."""
    analysis: Analysis


def isolation(
    dataset: xr.Dataset,
    plant: Plant,
    rate: float,
    usable_to: float = float("inf"),
    criteria: CriteriaSettings | None = None,
    usable_from: float = 0.0,
) -> tuple[Isolation, list[str]]:
    """Attenuation and criteria of a run, and in words the bands that a longer run or a higher rate would decide.

    Args:
        dataset: of a result.
        plant: what was simulated; the mounts' positions count.
        rate: recording rate [Hz].
        usable_to: frequency above which the ground is not known [Hz].
        criteria: the norms that judge.
        usable_from: frequency below which the ground is not known [Hz].
    """
    norms = (criteria or CriteriaSettings()).chosen()
    end = duration_of(dataset)
    begin = settled(end)
    known = tuple(band for band in BANDS if usable_from <= band.edges[0] and band.edges[1] <= usable_to)
    levels = levels_of(dataset.sel(time=slice(begin, None)), plant, rate, known)
    peaks = peaks_of(dataset.sel(time=slice(begin, None)), rate, norms.values())
    verdicts = {name: by_norm(norm, levels, peaks) for name, norm in norms.items()}
    first = next(iter(verdicts.values()))
    # Velocity, and what else the norms limit in bands.
    limited = {("velocity", "rms")}.union(*(norm.kinds for norm in norms.values()))
    tables = {
        f"third_octave_{quantity}": {
            place: by_band(levels.at(place)[quantity, "rms"], levels.bands) for place in levels.places
        }
        for quantity in ORDERS
        if (quantity, "rms") in limited
    }
    found = Isolation(
        attenuation_db=attenuation_at_cg(levels, plant),
        attenuation_at_db=attenuation_at_places(levels),
        criterion=Criterion(floor=first.places["floor"], machine=first.places["machine"], verdict=first.verdict),
        criteria=verdicts,
        analysis=Analysis(from_s=begin, to_s=end, usable_to_hz=finite(usable_to), usable_from_hz=usable_from),
        **tables,
    )
    left_open = undecided(norms, end - begin, rate, usable_to, usable_from)
    return found, [*left_open, *unheld(norms, verdicts, usable_to, usable_from)]
