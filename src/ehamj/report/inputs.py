"""Tables of what was given: parameters with their sources, mounts, floor and control."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from markupsafe import Markup, escape
from pydantic import BaseModel

from ehamj.pages import Table, badge
from ehamj.pages.words import BAR, exact, plain
from ehamj.plant.mounts import MOUNTS
from ehamj.plant.points import default_points
from ehamj.report.shown import Results
from ehamj.scenario.model import Scenario
from ehamj.settings import Parameters


def inputs(results: Results) -> Iterator[Table]:
    """Parameters, mounts, ground and control; once where results share them."""
    yield from _shared(results, lambda scenario: [_quantities("Machine", scenario.machine)])
    yield from _shared(results, lambda scenario: [_mounts(scenario)])
    yield from _shared(results, _actuators)
    yield from _shared(results, lambda scenario: [_quantities("Supply", scenario.supply)])
    yield from _shared(results, _run)
    yield from _shared(results, lambda scenario: [_settings("Ground", scenario.ground)])
    yield from _shared(results, lambda scenario: [_settings("Control", scenario.control)])
    yield from _shared(results, _observed)


def _shared(results: Results, tables_of: Any) -> Iterator[Table]:
    found: dict[str, tuple[list[str], list[Table]]] = {}
    for label, result in results.items():
        tables = tables_of(result.scenario)
        found.setdefault(repr(tables), ([], tables))[0].append(label)
    for labels, tables in found.values():
        for table in tables:
            whose = f", {', '.join(labels)}" if len(found) > 1 else ""
            yield replace(table, title=table.title + whose)


def _run(scenario: Scenario) -> list[Table]:
    single = [
        name
        for name in type(scenario).model_fields
        if name not in ("name", "description") and isinstance(getattr(scenario, name), int | float | str)
    ]
    return [_settings("Run", scenario, single)]


def _actuators(scenario: Scenario) -> list[Table]:
    return [_quantities(f"Actuator {name}", actuator) for name, actuator in scenario.actuators.items()]


def _quantities(title: str, parameters: Parameters) -> Table:
    """Each value with symbol, unit and source; settings without unit have no source."""
    known = parameters.quantities()
    rows = []
    for name, about in type(parameters).model_fields.items():
        if name == "sources":
            continue
        unit, symbol, _ = known.get(name, ("", "", ""))
        value, text = getattr(parameters, name), (about.description or "").removesuffix(f" [{unit}]")
        shown = f"{plain(value)} {'' if unit == '-' else unit}".strip()
        if unit == "Pa" and isinstance(value, float) and 1e4 <= value < 1e8:
            shown += f" ({exact(BAR * value)} bar)"
        rows.append([_named(name, text), _symbol(symbol), shown, badge(parameters.sources.get(name, ""))])
    return Table(title, ("quantity", "symbol", "value", "source"), rows, kind="words")


def _named(key: str, text: str) -> str:
    """What something is, and its key in a scenario."""
    return Markup("{} <code>{}</code>").format(text, key)


def _symbol(symbol: str) -> str:
    """A symbol with its subscripts: A_p."""
    return Markup(re.sub(r"_([^\W_]+)", r"<sub>\1</sub>", str(escape(symbol))))


def _mounts(scenario: Scenario) -> Table:
    actuators: dict[str, str] = {mount.name: mount.actuator for mount in scenario.mount}
    rows = [
        [name, exact(x), exact(y), actuators[name]]
        for name, (x, y) in zip(MOUNTS, scenario.plant.positions, strict=True)
    ]
    return Table("Mounts", ("mount", "x [m]", "y [m]", "actuator"), rows, kind="words")


def _observed(scenario: Scenario) -> list[Table]:
    """Points (those of the drawing are assumed), relative motions and criteria."""
    tables = [_settings("Criteria", scenario.criteria)]
    if scenario.points:
        drawn = default_points(scenario.machine)
        rows = [
            [name, *map(exact, place), badge("assumed" if drawn.get(name) == place else "given")]
            for name, place in scenario.points.items()
        ]
        tables.append(Table("Points", ("point", "x [m]", "y [m]", "z [m]", "source"), rows, kind="words"))
    if scenario.relative:
        rows = [[relative.name, relative.origin, relative.to] for relative in scenario.relative]
        tables.append(Table("Relative motions", ("name", "from", "to"), rows, kind="words"))
    return tables


def _settings(title: str, settings: BaseModel, only: Sequence[str] = ()) -> Table:
    rows = [list(row) for row in _flat(settings, "", only)]
    return Table(title, ("setting", "value"), rows, kind="words")


def _flat(settings: BaseModel, prefix: str, only: Sequence[str] = ()) -> Iterator[tuple[str, str]]:
    """Description with key, and value of each setting, those of inner tables with their path."""
    for name, about in type(settings).model_fields.items():
        if only and name not in only:
            continue
        value, key = getattr(settings, name), f"{prefix}{name}"
        inner = value if isinstance(value, tuple) and value and isinstance(value[0], BaseModel) else ()
        if isinstance(value, BaseModel):
            yield from _flat(value, f"{key}.")
        elif inner:
            for k, part in enumerate(inner):
                yield from _flat(part, f"{key}.{k}.")
        else:
            yield _named(key, about.description or ""), plain(value)
