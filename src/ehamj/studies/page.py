"""A study's folder: tables as NetCDF and CSV, figures as SVG, one page that a person reads, one file for scripts."""

import csv
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from markupsafe import Markup

from ehamj.pages import ANNEX, Page, Picture, Section, Table, safe_name, write_page
from ehamj.pages.words import exact, number
from ehamj.result import written_whole
from ehamj.scenario.model import Scenario
from ehamj.studies.outcome import Outcome

STUDY_FILES = ("study.json", "study.html")
"""Files without which a folder is no study."""

ROUNDING = 1e-9
"""Share of a column's largest number below which a number is rounding."""
LONGEST_TABLE = 40
"""Rows up to which a table is shown on the page."""


def write_outcome(
    folder: Path, name: str, outcome: Outcome, scenario: Scenario, shown: Page | None = None, stem: str = "study"
) -> None:
    """Write a study into an existing folder: ``study.html``, ``study.json``, ``scenario.toml``, tables and figures.

    Args:
        folder: existing folder.
        name: of the study.
        outcome: what it came out with.
        scenario: of the machine.
        shown: its page; `page` makes it without.
        stem: what page and JSON file are called.
    """
    with written_whole(folder / "scenario.toml") as path:
        path.write_text(scenario.to_toml(), encoding="utf-8")
    for table, dataset in outcome.tables.items():
        with written_whole(folder / f"{table}.nc") as path:
            dataset.to_netcdf(path, engine="h5netcdf")
        head, rows = flat_table(dataset)
        with written_whole(folder / f"{table}.csv") as path, path.open("w", encoding="utf-8", newline="") as file:
            csv.writer(file).writerows([head, *rows])
    write_page(folder, f"{stem}.html", shown or page(name, outcome, scenario), figures=".")
    with written_whole(folder / f"{stem}.json") as path:
        path.write_text(json.dumps(to_dict(name, outcome), indent=1, ensure_ascii=False, allow_nan=False) + "\n")


def to_dict(name: str, outcome: Outcome) -> dict[str, Any]:
    """The study as plain data, without its tables."""
    return {
        "study": name,
        "title": outcome.title,
        "question": outcome.question,
        "answers": list(outcome.answers),
        "notes": list(outcome.notes),
        "numbers": dict(outcome.numbers),
    } | ({"settings": dict(outcome.settings)} if outcome.settings else {})


def flat_table(dataset: xr.Dataset) -> tuple[list[str], list[list[Any]]]:
    """A dataset as one table: a row for every combination of its dimensions; heads carry the units."""
    frame = dataset.to_dataframe().reset_index()
    names = [*dataset.dims, *(str(name) for name in frame.columns if name not in dataset.dims)]
    head = [_head(dataset[name]) if name in dataset.variables else str(name) for name in names]
    return head, [[_cell(value) for value in row] for row in frame[names].itertuples(index=False)]


def _head(variable: xr.DataArray) -> str:
    long_name, units = variable.attrs.get("long_name", str(variable.name)), variable.attrs.get("units", "")
    return f"{long_name} [{units}]" if units not in ("", "1") else str(long_name)


def _cell(value: Any) -> Any:
    if isinstance(value, np.generic):
        value = value.item()
    return "" if isinstance(value, float) and np.isnan(value) else value


def _columns(rows: Sequence[Sequence[Any]]) -> tuple[list[list[str]], list[int]]:
    """Cells as a person reads them, and which columns are numbers.

    What is below `ROUNDING` of its column's largest is nothing but rounding, and 0.
    """
    cells, numeric = [], []
    for k, column in enumerate(zip(*rows, strict=True)):
        numbers = [value for value in column if isinstance(value, float)]
        least = ROUNDING * max(map(abs, numbers), default=0.0)
        cells.append([_shown(value, least) for value in column])
        if all(isinstance(value, int | float) or value == "" for value in column) and k > 0:
            numeric.append(k)
    return [list(row) for row in zip(*cells, strict=True)], numeric


def _shown(value: Any, least: float = 0.0) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if value is None:
        return ""
    if isinstance(value, float):
        if abs(value) < 1e4 and value == round(value):
            return exact(value)
        return number(0.0 if abs(value) < least else value, 4)
    return exact(value) if isinstance(value, int) else str(value).replace("_", " ")


def files_of(outcome: Outcome, stem: str = "study", more: Sequence[str] = ()) -> str:
    """The files beside a page whose stem this is, in words; ``more`` are said first."""
    found = [*more]
    for name, dataset in outcome.tables.items():
        found.append(f"{name}.nc and {name}.csv ({dataset.attrs.get('title', name)}, {rows_of(dataset)} rows)")
    found += [*(f"{safe_name(drawing)}.svg" for drawing in outcome.drawings), f"{stem}.json"]
    return f"Files beside this page: {', '.join(found)}, and scenario.toml"


def page(name: str, outcome: Outcome, scenario: Scenario) -> Page:
    """The outcome as a page."""
    does = Markup(", with which <code>ehamj study {} scenario.toml</code> comes out the same.").format(name)
    sections = [
        *said_besides(outcome),
        Section("figures", figures=pictures_of(outcome)),
        Section("notes", "What holds, and what does not" if outcome.notes else "", items=outcome.notes),
        ANNEX,
        *([Section("tables", "Numbers", tables=tables)] if (tables := tables_of(outcome)) else []),
        Section("files", "Files", notes=[Markup("{}").format(files_of(outcome)) + does]),
    ]
    lead = f"{outcome.question} Machine: {scenario.name}."
    return Page(f"{outcome.title}: {scenario.name}", outcome.title, lead, sections, headline_of(outcome))


def pictures_of(outcome: Outcome) -> list[Picture]:
    """Its drawings, drawn."""
    return [Picture(drawing, one.draw(), one.caption) for drawing, one in outcome.drawings.items()]


def tables_of(outcome: Outcome) -> list[Table]:
    """Those of its tables that are short enough to be shown."""
    tables = []
    for table, dataset in outcome.tables.items():
        if rows_of(dataset) <= LONGEST_TABLE:
            head, rows = flat_table(dataset)
            cells, numeric = _columns(rows)
            tables.append(Table(dataset.attrs.get("title", table), head, cells, kind="words", numeric=numeric))
    return tables


def rows_of(dataset: xr.Dataset) -> int:
    """Rows of a dataset as one table."""
    return int(np.prod(list(dataset.sizes.values())))


def headline_of(outcome: Outcome) -> list[tuple[str, str]]:
    """The answer that stands first, as a page's verdict."""
    return [("", answer) for answer in outcome.answers[:1]]


def said_besides(outcome: Outcome) -> list[Section]:
    """The answers below it."""
    return [Section("answers", items=outcome.answers[1:])] if len(outcome.answers) > 1 else []
