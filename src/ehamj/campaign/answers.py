"""What a study came out with, in words: what is best, what matters, what holds within tolerances, what failed."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

import numpy as np

from ehamj.campaign.influence import Influence
from ehamj.campaign.names import unit_text, worded
from ehamj.campaign.studied import AS_IT_IS, CONFIRM, DataFrame, Studied, excess, rows_of
from ehamj.campaign.yields import Yield
from ehamj.pages.words import number
from ehamj.scenario.keys import entries

MERITS: Final = 3
"""Merits whose influences are told; all are in the table."""
YIELDS: Final = 8
"""Designs whose yields, and whose confirmations, are told; all are in the table."""
MANY: Final = 4
"""Merits from which on it is told how many of them each parameter decides."""
NAMED_CAUSES: Final = 3
"""Parameters that an answer names."""
LEAST_SHARE: Final = 0.05
"""Share of the strongest influence below which a parameter is not named."""
ALIKE: Final = 1e-6
"""Share of a merit below which two are as good."""
REASONS: Final = 3
"""Reasons that an answer names."""


def answers_of(studied: Studied, influences: Sequence[Influence], yields: Sequence[Yield]) -> tuple[str, ...]:
    """All of them, the most important first."""
    parts = (
        _none_good(studied),
        _best(studied),
        _against_named(studied),
        _yields(studied, yields),
        _confirmed(studied),
        _deciding(studied, influences),
        _influences(studied, influences),
        _unknown(studied),
        _unfinished(studied),
        _failed(studied),
    )
    found = tuple(answer for part in parts for answer in part)
    return found or (f"{len(studied.done)} designs are done; their figures are in the table.",)


def _best(studied: Studied) -> Iterator[str]:
    """The best design with what it has and what it comes out with."""
    if not studied.best:
        return
    row = studied.design(studied.best[0])
    merits = ", ".join(studied.said(name, row[name]) for name in studied.file.objectives)
    values = ", ".join(studied.said(key, row[key]) for key in studied.parameters)
    if studied.front:
        good = int(studied.good(studied.search).sum())
        kept = " that keep all limits" if studied.file.limits else ""
        yield (
            f"Of {good:,} designs{kept}, {len(studied.front):,} {'is' if len(studied.front) == 1 else 'are'} on the "
            f"Pareto front; design {row['number']} is the best compromise, nearest to the best of every objective at "
            f"once{_of_those_ahead(studied)}: {merits}."
        )
    else:
        (way,) = studied.file.objectives.values()
        of = f"{len(studied.done):,} designs"
        if studied.file.limits:
            of = (
                f"the {int(studied.good(studied.search).sum()):,} designs of {len(studied.done):,} that keep all limits"
            )
        yield f"Design {row['number']} is the best, its {merits} the {way} of {of}."
    yield f"Design {row['number']} has {values}."


def _of_those_ahead(studied: Studied) -> str:
    """That the best are chosen of those that lose nothing beside the designs with a name, where there are any."""
    if not studied.ahead:
        return ""
    return f", of the {studied.ahead:,} that lose nothing beside {' and '.join(studied.file.named)}"


def _against_named(studied: Studied) -> Iterator[str]:
    """Designs of the front, or the best, that beat a named one without losing in anything."""
    rows = studied.front or studied.best
    for name, named in studied.named.items():
        if not rows or not studied.file.objectives or (name == AS_IT_IS and studied.file.named):
            continue
        gains = {row: gains_of(studied, studied.design(row), named) for row in rows}
        unbeaten = {row: found for row, found in gains.items() if found and min(found.values()) >= 0.0}
        if not unbeaten:
            yield f"No design beats {_quoted(name)} without losing in another objective."
            continue
        most = max(sum(gain > 0.0 for gain in found.values()) for found in unbeaten.values())
        full = [row for row, found in unbeaten.items() if sum(gain > 0.0 for gain in found.values()) == most]
        best = next((row for row in studied.best if row in full), full[0])
        row, of = studied.design(best), len(studied.file.objectives)
        said = ", ".join(
            f"{studied.said(one, row[one])} instead of {worded(named[one], studied.unit(one))}"
            for one, gain in gains[best].items()
            if gain > 0.0
        )
        where, alone = "on the front" if studied.front else "best", len(full) == 1
        if most:
            yield (
                f"{len(full):,} of the {len(rows):,} {where} beat{'s' * alone} {_quoted(name)} in {most} of {of} "
                f"objectives and lose{'s' * alone} in none, such as design {row['number']}: {said}."
            )


def gains_of(studied: Studied, one: Mapping[str, Any], other: Mapping[str, Any]) -> dict[str, float]:
    """By how much a design is better than another one in each objective, in its unit; 0 where they are alike."""
    found = {}
    for name, sign in studied.file.goals.objectives:
        gain = -sign * (float(one[name]) - float(other[name]))
        found[name] = 0.0 if abs(gain) <= ALIKE * abs(float(other[name])) else gain
    return {} if any(np.isnan(gain) for gain in found.values()) else found


def _none_good(studied: Studied) -> Iterator[str]:
    """Which limit nothing keeps, how near the nearest design comes, and by how much it misses."""
    done = studied.done
    if not studied.file.limits or not len(done) or studied.good(studied.search).any():
        return
    misses = {name: excess(done[name].to_numpy(float), limit) for name, limit in studied.file.limits.items()}
    never = [name for name, miss in misses.items() if not (miss <= 0.0).any()]
    yield f"No design of {len(done):,} keeps all limits."
    for name in never:
        if not np.isfinite(misses[name]).any():
            yield f"Nothing keeps {studied.limit_said(name)}: no design has this figure."
            continue
        row = done.loc[int(np.argmin(misses[name]))]
        miss = worded(float(misses[name].min()), studied.unit(name))
        yield (
            f"Nothing keeps {studied.limit_said(name)}; design {row['number']} comes nearest with "
            f"{worded(row[name], studied.unit(name))}, which misses it by {miss}."
        )
    if not never:
        yield _nearest(studied, misses)


def _nearest(studied: Studied, misses: Mapping[str, "np.ndarray[tuple[int], np.dtype[np.float64]]"]) -> str:
    """The design that misses least where each limit is kept by some, but never all together."""
    scales = {name: np.ptp(v[np.isfinite(v)]) or 1.0 for name, v in misses.items()}
    worst = np.max([np.maximum(miss, 0.0) / scales[name] for name, miss in misses.items()], axis=0)
    at = int(np.argmin(worst))
    row = studied.done.loc[at]
    said = [
        f"{studied.limit_said(name)} by {worded(float(miss[at]), studied.unit(name))}"
        for name, miss in misses.items()
        if miss[at] > 0.0
    ]
    return (
        f"Each limit is kept by some designs, but by none together with the others; design {row['number']} comes "
        f"nearest and misses {' and '.join(said)}."
    )


def _yields(studied: Studied, yields: Sequence[Yield]) -> Iterator[str]:
    """Yields over all limits, and the limit that most machines miss."""
    for one in [y for y in yields if not y.limit][:YIELDS]:
        each = [y for y in yields if y.whose == one.whose and y.limit]
        worst = min(each, key=lambda y: y.share, default=None)
        about = f" around {one.whose}" if one.whose else ""
        kept = "all limits" if each else studied.limit_said(next(iter(studied.file.limits)))
        most = (
            f"; most miss {studied.limit_said(worst.limit)} ({worst.said} keep it)" if worst and worst.share < 1 else ""
        )
        yield f"Yield{about}: {one.said} of {one.number:,} machines keep {kept}{most}."


def _confirmed(studied: Studied) -> Iterator[str]:
    """The best designs once more: what came out otherwise."""
    again = studied.stage(CONFIRM)
    if not len(again) or studied.file.confirm is None:
        return
    names = [name for name in again.columns if name in studied.merits and again[name].notna().any()]
    for row in rows_of(again)[:YIELDS]:
        before = studied.designs[studied.designs["number"] == row["parent"]]
        whose = label_of(studied, row["parent"])
        if row["status"] != "done":
            yield f"Confirming {whose} failed: {row['reason']}."
            continue
        said = ", ".join(_changed(studied, name, before, row) for name in names if not np.isnan(row[name]))
        missed = [name for name, limit in studied.file.limits.items() if name in names and not limit.met(row[name])]
        kept = f"; it misses {' and '.join(map(studied.limit_said, missed))}" if missed else ""
        yield f"Once more with {_otherwise(studied)}, {whose} has {said}{kept}."


def _otherwise(studied: Studied) -> str:
    """What of the scenario is otherwise where designs are confirmed, in words."""
    own = {} if studied.file.confirm is None else studied.file.confirm.set
    return " and ".join(f"{'.'.join(key)} = {value}" for key, value in entries(own)) or "nothing otherwise"


def _changed(studied: Studied, name: str, before: DataFrame, row: Mapping[str, Any]) -> str:
    """A merit, and what it was before where that is known."""
    old = float(before[name].iloc[0]) if len(before) else np.nan
    was = "" if np.isnan(old) else f" ({worded(old, studied.unit(name))} before)"
    return studied.said(name, row[name]) + was


def label_of(studied: Studied, number: Any) -> str:
    """What a design is called."""
    name = next((name for name, row in studied.named.items() if row["number"] == number), None)
    return _quoted(name) if name else f"design {number}"


def _quoted(name: str) -> str:
    return "the scenario's own design" if name == AS_IT_IS else f"“{name}”"


def _deciding(studied: Studied, influences: Sequence[Influence]) -> Iterator[str]:
    """Which parameters do most for how many of many merits."""
    first = [one.parameters[one.order[0]] for one in influences if one.size.max() > 0.0]
    if len(first) < MANY:
        return
    counts = sorted(((first.count(key), key) for key in dict.fromkeys(first)), key=lambda one: -one[0])
    said = ", ".join(f"{studied.short[key]} for {count}" for count, key in counts)
    yield f"Of the parameters, one does most for each of the {len(first)} figures: {said}."


def _influences(studied: Studied, influences: Sequence[Influence]) -> Iterator[str]:
    """What matters most for each merit, with confidence."""
    for one in influences[:MERITS]:
        most, size = one.order[:NAMED_CAUSES], one.size
        named = [k for k in most if size[k] > LEAST_SHARE * size[most[0]]] if size[most[0]] > 0.0 else []
        if not named:
            yield f"Nothing that varies changes {one.merit}."
            continue
        named = [k for k in named if _is_sure(one, k)]
        if not named:
            yield f"These designs do not show what matters for {one.merit}: all intervals hold 0."
            continue
        said = ", then ".join(_influence(studied, one, k) for k in named)
        yield f"What matters most for {one.merit} is {said}."


def _is_sure(one: Influence, k: int) -> bool:
    """Whether the interval of an influence, if it has one, does not hold 0."""
    low, high = one.measures[-1].low, one.measures[-1].high
    return low is None or high is None or not float(low[k]) <= 0.0 <= float(high[k])


def _influence(studied: Studied, one: Influence, k: int) -> str:
    name = studied.short[one.parameters[k]]
    if one.base_name:
        unit = studied.unit(one.merit)
        ends = sorted(float(measure.values[k]) for measure in one.measures if np.isfinite(measure.values[k]))
        return f"{name} ({worded(ends[0], unit)} to {worded(ends[-1], unit)})"
    measure = one.measures[-1]
    sure, unit, said = "", "", _hundredths
    if one.unit is not None:
        unit = f" {unit_text(one.unit)}".removesuffix(" -")
        said = number
    if measure.low is not None and measure.high is not None:
        sure = f", 95 %: {said(float(measure.low[k]))} to {said(float(measure.high[k]))}{unit}"
    return f"{name} ({measure.label} {said(float(measure.values[k]))}{unit}{sure})"


def _hundredths(value: float) -> str:
    """An index or a correlation."""
    return f"{value:.2f}".replace("-0.00", "0.00").replace("-", "−")


def _unknown(studied: Studied) -> Iterator[str]:
    """Merits that no design has."""
    done = studied.designs[studied.designs["status"] == "done"]
    lost = [name for name in studied.merits if len(done) and done[name].isna().all()]
    if lost:
        yield (
            f"No design has {', '.join(lost)}, as is so of a band that runs are too short for; `ehamj run` of one "
            "design says why."
        )


def _unfinished(studied: Studied) -> Iterator[str]:
    done = len(studied.designs)
    if not studied.complete:
        yield f"The study is not finished: {done:,} of at most {studied.planned:,} designs are there; --resume goes on."


def _failed(studied: Studied) -> Iterator[str]:
    """How many designs failed, and why most of them."""
    if not len(studied.failed):
        return
    counts = reasons_of(studied)
    said = "; ".join(f"{count:,}× {reason.rstrip('.')}" for reason, count in list(counts.items())[:REASONS])
    more = f"; and {len(counts) - REASONS} other reasons" if len(counts) > REASONS else ""
    yield f"{len(studied.failed):,} of {len(studied.designs):,} designs failed: {said}{more}."


def reasons_of(studied: Studied) -> dict[str, int]:
    """How often designs failed for each reason, the commonest first; reasons that differ in numbers only are one."""
    import re

    kinds = studied.failed["reason"].map(lambda reason: re.sub(r"[-−]?\d+(\.\d+)?(e[-+]?\d+)?", "…", str(reason)))
    counts = kinds.value_counts()
    first = {str(kind): str(studied.failed["reason"][kinds == kind].iloc[0]) for kind in counts.index}
    return {first[str(kind)] if count == 1 else str(kind): int(count) for kind, count in counts.items()}
