"""A study's folder: tables as NetCDF and CSV, figures as SVG, one page that a person reads, one file for scripts."""

import csv
import json
from pathlib import Path
from typing import Any, Literal

import numpy as np
import xarray as xr
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from ehamj.plots import inline, svg
from ehamj.result import written_whole
from ehamj.scenario.model import Scenario
from ehamj.studies.outcome import Outcome

STUDY_FILES = ("study.json", "study.html")
"""Files without which a folder is no study."""

LONGEST_TABLE = 40
"""Rows up to which a table is shown on the page."""


def write_outcome(
    folder: Path, name: str, outcome: Outcome, scenario: Scenario, page_name: Literal["study", "design"] = "study"
) -> None:
    """Write a study into an existing folder: ``study.html``, ``study.json``, ``scenario.toml``, tables and figures.

    ``page_name`` is what page and JSON file are called.
    """
    with written_whole(folder / "scenario.toml") as path:
        path.write_text(scenario.to_toml(), encoding="utf-8")
    for table, dataset in outcome.tables.items():
        with written_whole(folder / f"{table}.nc") as path:
            dataset.to_netcdf(path, engine="h5netcdf")
        head, rows = flat_table(dataset)
        with written_whole(folder / f"{table}.csv") as path, path.open("w", encoding="utf-8", newline="") as file:
            csv.writer(file).writerows([head, *rows])
    pictures = []
    for drawing, one in outcome.drawings.items():
        text = svg(one.draw(), drawing)
        with written_whole(folder / f"{drawing}.svg") as path:
            path.write_text(text, encoding="utf-8")
        pictures.append({"name": drawing, "svg": inline(text), "caption": one.caption})
    with written_whole(folder / f"{page_name}.html") as path:
        path.write_text(page(name, outcome, scenario, pictures, page_name), encoding="utf-8")
    with written_whole(folder / f"{page_name}.json") as path:
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


def _shown(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.4g}".replace("-", "−")
    return "" if value is None else str(value)


def page(
    name: str, outcome: Outcome, scenario: Scenario, pictures: list[dict[str, str]], page_name: str = "study"
) -> str:
    """The page as one self-contained HTML file."""
    tables = []
    for table, dataset in outcome.tables.items():
        head, rows = flat_table(dataset)
        shown = [[_shown(value) for value in row] for row in rows] if len(rows) <= LONGEST_TABLE else None
        title = dataset.attrs.get("title", table)
        tables.append({"name": table, "title": title, "head": head, "rows": shown, "count": len(rows)})
    loader = PackageLoader("ehamj")
    environment = Environment(
        loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    template = environment.get_template("study.html")
    safe = [picture | {"svg": Markup(picture["svg"])} for picture in pictures]
    return template.render(
        name=name, page_name=page_name, outcome=outcome, scenario=scenario, tables=tables, pictures=safe
    )
