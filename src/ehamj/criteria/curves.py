"""What the norms share: a limit per class, axis and third-octave band, and the decision which class is met."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Self

import numpy as np

from ehamj.arrays import Array
from ehamj.criteria.verdict import WHOLE, Verdict
from ehamj.errors import InputError
from ehamj.estimate.bands import Band, bands
from ehamj.estimate.statistics import BandStatistic, Statistic
from ehamj.estimate.swings import Swings
from ehamj.findings import finite
from ehamj.plant.axes import AXES
from ehamj.records.units import Quantity

Kind = tuple[Quantity, Statistic]
ByKind = Mapping[Kind, Array]
"""Levels of one place along one axis by kind, SI, NaN where unknown: ``peak`` (1,), every other per band (bands,)."""

ORDERS: dict[Quantity, int] = {"displacement": -1, "velocity": 0, "acceleration": 1}
"""Order of each quantity as a time derivative of velocity."""

CANDIDATES = bands(0.5, 315.0)
"""Bands in which any norm here has a limit."""


@dataclass(frozen=True)
class Limit:
    """Largest level allowed: of displacement [m], velocity [m/s] or acceleration [m/s²].

    A limit of a peak may depend on the frequency of the swing that it belongs to: ``corners`` are frequencies [Hz],
    rising, and limits there, with straight lines between, over logarithms if ``logarithmic``. Where the frequency is
    not clear or lies outside, ``value`` counts, which is then the least of them.
    """

    value: float
    quantity: Quantity = "velocity"
    statistic: Statistic = "rms"
    corners: tuple[tuple[float, float], ...] = ()
    logarithmic: bool = False

    @classmethod
    def of_swings(
        cls, corners: Sequence[tuple[float, float]], quantity: Quantity = "velocity", logarithmic: bool = False
    ) -> Self:
        """A limit of the peak over the frequency of its swing."""
        return cls(min(value for _, value in corners), quantity, "peak", tuple(corners), logarithmic)

    def over(self, frequency: Array) -> Array:
        """The limit at frequencies of swings [Hz], (n,)."""
        if not self.corners:
            return np.full(np.shape(frequency), self.value)
        at, values = np.array(self.corners).T
        inside = (frequency >= at[0]) & (frequency <= at[-1])
        wanted = np.where(inside, frequency, at[0])
        if self.logarithmic:
            found = np.exp(np.interp(np.log(wanted), np.log(at), np.log(values)))
        else:
            found = np.interp(wanted, at, values)
        return np.where(inside, found, self.value)

    @property
    def kind(self) -> Kind:
        """The kind of levels that it limits."""
        return self.quantity, self.statistic

    def as_velocity(self, band: Band) -> float:
        """The same limit for a line at the band's nominal centre [m/s], as charts of criteria draw it."""
        return self.value / float(2 * np.pi * band.nominal) ** ORDERS[self.quantity]


def rounded(value: float) -> float:
    """The double nearest to a limit's decimal value, so that 50e-6·8/5 is the 80e-6 that people write."""
    return float(f"{value:.12g}")


@dataclass(frozen=True, eq=False)
class Norm:
    """A criterion: its classes, coarsest first, and the limits of each.

    ``rule`` gives the limit of a class along an axis (x, y, z) in a band, ``whole`` that of the whole history's peak;
    None where the norm says nothing.
    """

    title: str
    classes: tuple[str, ...]
    rule: Callable[[str, str, Band], Limit | None] = lambda name, axis, band: None
    whole: Callable[[str, str], Limit | None] = lambda name, axis: None
    base: str | None = None
    """Class whose curve a factor counts from, for a norm that thinks in multiples of one curve."""
    note: str = ""
    """How to read its chart."""
    marks: Mapping[str, str] = field(default_factory=dict)
    """Short names of classes in its chart."""
    practices: Mapping[str, "Norm"] = field(default_factory=dict)
    """The same norm by each practice at low frequency, where the field has several."""

    @cached_property
    def _limits(self) -> dict[tuple[str, str], dict[Band | None, Limit]]:
        """By class and axis: the limit in each band, and of the whole history (None)."""
        found: dict[tuple[str, str], dict[Band | None, Limit]] = {}
        for name in self.classes:
            for axis in AXES:
                table = {band: self.rule(name, axis, band) for band in CANDIDATES} | {None: self.whole(name, axis)}
                found[name, axis] = {band: limit for band, limit in table.items() if limit is not None}
                if any((limit.statistic == "peak") != (band is None) for band, limit in found[name, axis].items()):
                    raise ValueError(
                        f"norm {self.title!r}, {name}: a limit of the peak is one of the whole history, any "
                        "other one in a band"
                    )
        return found

    def by(self, statistic: BandStatistic, every: bool = False) -> Self:
        """The same norm, its limits of RMS in bands, or ``every`` limit there, held against another statistic."""

        def rule(name: str, axis: str, band: Band) -> Limit | None:
            limit = self.rule(name, axis, band)
            if limit is None or limit.statistic == "peak" or not (every or limit.statistic == "rms"):
                return limit
            return replace(limit, statistic=statistic)

        practices = {name: norm.by(statistic, every) for name, norm in self.practices.items()}
        return replace(self, rule=rule, practices=practices)

    def limit(self, name: str, axis: str, band: Band | None) -> Limit | None:
        """Limit of a class along an axis in a band (None: of the whole history), None where the norm says nothing."""
        return self._limits[name, axis].get(band)

    def needed(self, axis: str) -> tuple[Band, ...]:
        """The bands that must be known for a decision: those in which any class has a limit."""
        return tuple(band for band in CANDIDATES if any(self.limit(name, axis, band) for name in self.classes))

    @cached_property
    def kinds(self) -> frozenset[Kind]:
        """Kinds of levels that the norm limits."""
        return frozenset(limit.kind for table in self._limits.values() for limit in table.values())

    @cached_property
    def statistics(self) -> frozenset[Statistic]:
        """What the levels are of that the norm limits."""
        return frozenset(statistic for _, statistic in self.kinds)

    @cached_property
    def swinging(self) -> frozenset[Quantity]:
        """Quantities of which the norm limits the peak by the frequency of its swing."""
        return frozenset(limit.quantity for table in self._limits.values() for limit in table.values() if limit.corners)

    def judge(
        self, axis: str, levels: ByKind, measured: tuple[Band, ...], swings: Mapping[Quantity, Swings] | None = None
    ) -> Verdict:
        """The class that levels meet.

        Args:
            axis: x, y or z.
            levels: of each kind that the norm limits.
            measured: the bands.
            swings: where a limit depends on the frequency of a peak; without, the strictest value counts.

        Raises:
            InputError: if a kind of levels that the norm limits is not among them.
        """
        if missing := self.kinds - levels.keys():
            wanted, given = (", ".join(f"{s} of {q}" for q, s in sorted(kinds)) for kinds in (missing, levels))
            raise InputError(f"norm {self.title!r}: limits {wanted}; the levels are {given}")
        known = _known(levels, measured)
        limits = [(band, limit) for name in self.classes for band, limit in self._limits[name, axis].items()]
        several = {limit.statistic for _, limit in limits}
        statistic = several.pop() if len(several) == 1 else None
        met = deciding = margin = following = following_band = excess = None
        decider: tuple[str, Band | None] | None = None
        decisive = 0.0
        found: dict[str, Any] = {}
        for name in self.classes:
            shares = self._shares(name, axis, known, swings or {})
            if not shares:
                break
            worst, share = max(shares.items(), key=lambda item: item[1])
            if share > 1.0:
                following, following_band, excess = name, _name(worst), _decibel(share)
                decider = decider or (name, worst)
                decisive = share if met is None else decisive
                break
            met, decider, decisive = name, (name, worst), share
            margin = -_decibel(share) if share > 0 else None
        if decider is not None:
            deciding, limit = _name(decider[1]), self._limits[decider[0], axis][decider[1]]
            statistic = limit.statistic
            own = (swings or {}).get(limit.quantity)
            found = _level(limit, decisive) if decider[1] else _nearest(limit, known[None, limit.kind], own)
        base = {} if self.base is None else self._shares(self.base, axis, known, {})
        could = self._could_decide(axis, met, deciding is None)
        unknown = {band for band, kind in could if (band, kind) not in known}
        undecided = tuple(_name(band) for band in (*CANDIDATES, None) if band in unknown)
        return Verdict(
            met=met,
            decided=deciding is not None and not undecided,
            deciding_band=deciding,
            margin_db=margin,
            next_class=following,
            next_band=following_band,
            excess_db=excess,
            undecided=undecided,
            bands=len({band for band, _ in could}),
            statistic=statistic,
            **found,
            **({} if self.base is None else {"factor": max(base.values(), default=None)}),
        )

    def rank(self, verdict: Verdict) -> tuple[float, float]:
        """The less, the worse: by the class met, and of one class by the margin; what is not judged comes last."""
        if verdict.deciding_band is None:
            return np.inf, 0.0
        if verdict.met is None:
            return -1, -(verdict.excess_db or 0.0)
        return self.classes.index(verdict.met), np.inf if verdict.margin_db is None else verdict.margin_db

    def could_decide(self, axis: str, met: str | None, nothing_known: bool = False) -> tuple[str, ...]:
        """Bands by which a class met along an axis might yet turn out coarser, from low to high; last `WHOLE`.

        They are those in which it or a coarser one has a limit, of a class that is not met none: in what is known it is
        missed already. Where ``nothing_known`` they are all in which the norm has one.
        """
        could = {band for band, _ in self._could_decide(axis, met, nothing_known)}
        return tuple(_name(band) for band in (*CANDIDATES, None) if band in could)

    def _could_decide(self, axis: str, met: str | None, nothing_known: bool) -> set[tuple[Band | None, Kind]]:
        names = self.classes[: 0 if met is None else self.classes.index(met) + 1]
        limits = (self._limits[name, axis] for name in (self.classes if nothing_known else names))
        return {(band, limit.kind) for table in limits for band, limit in table.items()}

    def _shares(
        self,
        name: str,
        axis: str,
        known: Mapping[tuple[Band | None, Kind], float],
        swings: Mapping[Quantity, Swings],
    ) -> dict[Band | None, float]:
        """Level over limit in each band in which both are known."""
        found: dict[Band | None, float] = {}
        for band, limit in self._limits[name, axis].items():
            if (band, limit.kind) not in known:
                continue
            level = known[band, limit.kind]
            if limit.corners and (own := swings.get(limit.quantity)) is not None and own.peak.size:
                found[band] = float((own.peak / limit.over(own.frequency)).max())
            else:
                found[band] = level / limit.value
        return found


def _known(levels: ByKind, measured: tuple[Band, ...]) -> dict[tuple[Band | None, Kind], float]:
    """Levels that are numbers, by band (None: of the whole history) and kind."""
    return {
        (band, kind): float(value)
        for kind, values in levels.items()
        for band, value in zip((None,) if kind[1] == "peak" else measured, values, strict=True)
        if np.isfinite(value)
    }


def _level(limit: Limit, share: float) -> dict[str, Any]:
    """The level in a band that is so much of its limit."""
    return {"level": share * limit.value, "limit": limit.value, "quantity": limit.quantity}


def _nearest(limit: Limit, level: float, swings: Swings | None) -> dict[str, float | None]:
    """The peak that comes nearest to a limit of the whole history, and its frequency where that counts."""
    if not limit.corners:
        return {"peak": level}
    if swings is None or not swings.peak.size:
        return {"peak": level, "peak_hz": None}
    k = int(np.argmax(swings.peak / limit.over(swings.frequency)))
    return {"peak": float(swings.peak[k]), "peak_hz": finite(float(swings.frequency[k]))}


def _name(band: Band | None) -> str:
    return WHOLE if band is None else band.name


def _decibel(ratio: float) -> float:
    return float(20 * np.log10(ratio)) + 0.0
