"""A study's designs as an outcome: answers, tables, drawings, notes, numbers."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from ehamj.campaign.answers import answers_of, label_of, reasons_of
from ehamj.campaign.charts import front_drawing, influence_drawings, matrix_drawing, spread_drawings
from ehamj.campaign.influence import Influence
from ehamj.campaign.influences import influences_of
from ehamj.campaign.names import unit_text
from ehamj.campaign.studied import AS_IT_IS, CONFIRM, DataFrame, Row, Studied, rows_of
from ehamj.campaign.surfaces import surface_drawings
from ehamj.campaign.yields import Yield, yields_of
from ehamj.findings import finite
from ehamj.labels import table
from ehamj.studies.outcome import Drawing, Outcome

MOST_OF_FRONT = 200
"""Designs of the front that the table holds besides the best."""


def outcome_of(studied: Studied, told: Sequence[str] = ()) -> Outcome:
    """What a study came out with, however far it has come; ``told`` is what must be known of its merits."""
    influences, yields = influences_of(studied), yields_of(studied)
    drawings: dict[str, Drawing] = {}
    for part in (
        front_drawing(studied),
        influence_drawings(studied, influences),
        spread_drawings(studied, yields),
        surface_drawings(studied, influences),
        matrix_drawing(studied, influences),
    ):
        drawings |= dict(part)
    return Outcome(
        title=studied.file.title,
        question=studied.file.question,
        answers=answers_of(studied, influences, yields),
        tables=tables_of(studied, influences, yields),
        drawings=drawings,
        notes=(*notes_of(studied, influences, yields), *(f"{one[0].upper()}{one[1:].rstrip('.')}." for one in told)),
        numbers=numbers_of(studied, influences, yields),
        settings=studied.file.model_dump(mode="json", exclude_unset=True),
    )


def tables_of(studied: Studied, influences: Sequence[Influence], yields: Sequence[Yield]) -> dict[str, xr.Dataset]:
    """Best and named designs, the front, influences, yields, confirmations, reasons; what is empty is left out."""
    found = {}
    chosen = [(f"best {k}", studied.design(row)) for k, row in enumerate(studied.best, 1)]
    chosen += list(studied.named.items())
    if chosen:
        found["best"] = _designs("the best designs, and those with a name", [name for name, _ in chosen],
                                 [row for _, row in chosen], studied)  # fmt: skip
    if studied.front:
        rows = [studied.design(row) for row in studied.front[:MOST_OF_FRONT]]
        found["front"] = _designs("designs of the Pareto front", [f"{row['number']}" for row in rows], rows, studied)
    if influences:
        found["influence"] = _influence_table(influences)
    if yields:
        found["yield"] = _yield_table(studied, yields)
    if len(again := studied.stage(CONFIRM)):
        names = [label_of(studied, row["parent"]) for row in rows_of(again)]
        found["confirm"] = _designs("once more", names, rows_of(again), studied)
    if len(studied.failed):
        counts = reasons_of(studied)
        reasons = {"reason": (list(counts), "", "reason; … stands for numbers that differ")}
        found["failures"] = table("why designs failed", reasons, designs=(list(counts.values()), "1", "designs"))
    return found


def _designs(title: str, names: Sequence[str], rows: Sequence[Row], studied: Studied) -> xr.Dataset:
    """Some designs with all their values and merits, by their own keys."""
    columns: dict[str, tuple[Any, str, str]] = {}
    for key in [*studied.parameters, *studied.merits]:
        values = [row[key] for row in rows]
        numeric = all(isinstance(value, int | float | np.number) for value in values)
        if numeric and not np.isnan(np.array(values, float)).all():
            columns[key] = (np.array(values, float), unit_text(studied.unit(key)), key)
        elif not numeric:
            columns[key] = ([str(value) for value in values], "", key)
    numbers = ([int(row["number"]) for row in rows], "1", "number of the design")
    return table(title, {"design": (list(names), "", "design")}, number=numbers, **columns)


def _influence_table(influences: Sequence[Influence]) -> xr.Dataset:
    """Every measure of every parameter and merit, with its interval."""
    rows = []
    for one in influences:
        for measure, unit in [(m, one.unit or "1") for m in one.measures] + [(m, "1") for m in one.more]:
            ends = [np.full(len(one.parameters), np.nan) if end is None else end for end in (measure.low, measure.high)]
            columns = zip(one.parameters, measure.values, *ends, strict=True)
            rows += [(one.merit, key, measure.label, unit_text(unit), *map(float, cells)) for key, *cells in columns]
        for first, second, value, reach in one.pairs:
            key = f"{first} and {second}"
            rows.append((one.merit, key, "second order", "-", value, value - reach, value + reach))
    merits, keys, labels, units, values, lows, highs = map(list, zip(*rows, strict=True))
    return table(
        "what each parameter does to each figure",
        {"row": (list(range(1, len(rows) + 1)), "1", "row")},
        merit=(merits, "", "figure of merit"),
        parameter=(keys, "", "parameter"),
        measure=(labels, "", "measure"),
        unit=(units, "", "unit"),
        value=(values, "1", "value, in that unit"),
        low=(lows, "1", "lower end of the 95 % interval"),
        high=(highs, "1", "upper end"),
    )


def _yield_table(studied: Studied, yields: Sequence[Yield]) -> xr.Dataset:
    over = {"row": (list(range(1, len(yields) + 1)), "1", "row")}
    return table(
        "yields within tolerances",
        over,
        around=([one.whose or "the study" for one in yields], "", "machines around"),
        limit=([studied.limit_said(one.limit) if one.limit else "all limits" for one in yields], "", "limit"),
        kept=([one.kept for one in yields], "1", "machines that keep it"),
        machines=([one.number for one in yields], "1", "machines"),
        share=([100 * one.share for one in yields], "%", "yield"),
        low=([100 * one.low for one in yields], "%", "lower end of the 95 % interval"),
        high=([100 * one.high for one in yields], "%", "upper end"),
    )


def notes_of(studied: Studied, influences: Sequence[Influence], yields: Sequence[Yield]) -> tuple[str, ...]:
    """What holds, and what does not."""
    file = studied.file
    notes = [f"{len(studied.designs):,} designs, {len(studied.search):,} of them of the plan ({file.plan.kind})."]
    if file.law == "derived":
        notes.append("The law was derived anew for each design, whose values it so knows exactly.")
    if yields:
        notes.append(
            "Intervals of yields are exact binomial ones (Clopper and Pearson, 95 %), of machines drawn as the file "
            "says. A machine that failed keeps no limit."
        )
    if influences and influences[0].said:
        notes.append(f"{influences[0].title[0].upper()}{influences[0].title[1:]}: from {influences[0].said} (SALib).")
    if influences and file.plan.drawn:
        notes.append(
            "Rank correlations (Spearman) see what rises or falls throughout; what rises and falls again, not."
        )
    if studied.front:
        notes.append(
            "The best compromise is nearest to the best value of each objective, counted in shares of the front; those "
            "come first that lose nothing beside a design that the file names."
        )
    return tuple(notes)


def numbers_of(studied: Studied, influences: Sequence[Influence], yields: Sequence[Yield]) -> dict[str, Any]:
    """The few numbers that a script asks for."""
    search = studied.search
    return {
        "designs": len(studied.designs),
        "planned": studied.planned,
        "failed": len(studied.failed),
        "good": int(studied.good(search).sum()),
        "best": [_plain(studied, studied.design(row)) for row in studied.best],
        "named": {name: _plain(studied, row) for name, row in studied.named.items()},
        "front": [int(search["number"][row]) for row in studied.front],
        "yield": {
            one.whose or AS_IT_IS: {"share": one.share, "low": one.low, "high": one.high, "machines": one.number}
            for one in yields
            if not one.limit
        },
        "influence": {
            one.merit: {
                measure.label: {key: finite(float(measure.values[k])) for k, key in enumerate(one.parameters)}
                for measure in (*one.measures, *one.more)
            }
            for one in influences
        },
    }


def _plain(studied: Studied, row: Row) -> dict[str, Any]:
    def said(value: Any) -> Any:
        return value if isinstance(value, str | bool) or value is None else finite(float(value))

    values = {key: said(row[key]) for key in studied.parameters}
    return {
        "number": int(row["number"]),
        "values": values,
        "merits": {name: said(row[name]) for name in studied.merits},
    }


def is_empty(designs: DataFrame) -> bool:
    """Whether there is nothing to say of a study yet."""
    return not (designs["status"] == "done").any()
