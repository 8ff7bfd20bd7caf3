"""Tables of what was given: parameters with their sources, mounts, floor and control."""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from markupsafe import Markup, escape
from pydantic import BaseModel

from ehamj.pages import Section, Table, badge
from ehamj.pages.words import BAR, exact, plain, plain_within
from ehamj.plant.bodies import written_inertia
from ehamj.plant.points import default_points
from ehamj.report.sections.headline import told
from ehamj.report.shown import Shown
from ehamj.scenario.model import Scenario
from ehamj.settings import PROVENANCE, Parameters

SOURCES: Final = {
    "paper": "the source paper's table or text",
    "identified": "fitted to measurements, with its standard deviation, or to something that the paper states",
    "assumed": "chosen, because nobody measured it",
    "given": "set by the user",
}
"""What each source of a parameter means."""


def inputs(shown: Shown) -> Section:
    """Parameters, mounts, ground and control; once where results share them."""
    sources = [Markup("{} {}").format(badge(name), text) for name, text in SOURCES.items()]
    note = Markup("Sources: {}.").format(Markup("; ").join(sources))
    tables = [table for tables_of in TABLES for table in _shared(shown, tables_of)]
    processing, title = told(shown, processing=True), "How the record was processed"
    return Section(
        "inputs", "Parameters and settings", tables=tables, notes=[note], items=processing, items_title=title
    )


def _shared(shown: Shown, tables_of: Callable[[Scenario], list[Table]]) -> Iterator[Table]:
    found: dict[str, tuple[list[str], list[Table]]] = {}
    for label, result in shown.results.items():
        tables = tables_of(result.scenario)
        found.setdefault(repr(tables), ([], tables))[0].append(label)
    for labels, tables in found.values():
        for table in tables:
            whose = f", {'; '.join(labels)}" if len(found) > 1 else ""
            yield replace(table, title=table.title + whose)


def _run(scenario: Scenario) -> list[Table]:
    single = [
        name
        for name in type(scenario).model_fields
        if name not in ("name", "description") and isinstance(getattr(scenario, name), int | float | str)
    ]
    return [_settings("Run", scenario, single)]


def _actuators(scenario: Scenario) -> list[Table]:
    return [_quantities(f"Actuator {name}", actuator) for name, actuator in scenario.running.items()]


def _quantities(title: str, parameters: Parameters) -> Table:
    """Each value with symbol, unit and source; settings without unit have no source."""
    known = parameters.quantities()
    rows = []
    for name, about in type(parameters).model_fields.items():
        if name in PROVENANCE:
            continue
        unit, symbol, _ = known.get(name, ("", "", ""))
        value, text = getattr(parameters, name), (about.description or "").removesuffix(f" [{unit}]")
        shown = f"{plain_within(value, parameters.deviations.get(name))} {'' if unit == '-' else unit}".strip()
        if unit == "Pa" and isinstance(value, float) and 1e4 <= value < 1e8:
            shown += f" ({exact(BAR * value)} bar)"
        rows.append([named(name, text), _symbol(symbol), shown, badge(parameters.sources.get(name, ""))])
    return Table(title, ("quantity", "symbol", "value", "source"), rows, kind="words")


def named(key: str, text: str) -> str:
    """What something is, and its key in a scenario."""
    return Markup("{} <code>{}</code>").format(text, key)


def _symbol(symbol: str) -> str:
    """A symbol with its subscripts: A_p."""
    return Markup(re.sub(r"_([^\W_]+)", r"<sub>\1</sub>", str(escape(symbol))))


def _parts(scenario: Scenario) -> list[Table]:
    """Parts and slides, and what they make together with the machine; nothing where there are none."""
    bodies = [(part.name, part.body, "fixed") for part in scenario.part]
    for slide in scenario.slide:
        along, (low, high) = plain(tuple(float(f"{entry:.4g}") for entry in slide.along)), slide.travel
        words = f"{slide.profile.kind}, from {exact(slide.begins)} m, along ({along}), {exact(low)} to {exact(high)} m"
        bodies.append((slide.name, slide.body(slide.begins), words))
    if not bodies:
        return []
    bodies.append(("all together", scenario.plant.machine.body, "at the start"))
    rows = []
    for name, body, words in bodies:
        inertia = written_inertia(np.round(body.tensor, 3))
        rows.append([name, exact(float(body.mass)), plain(tuple(np.round(body.cg, 6).tolist())), plain(inertia), words])
    head = ("part or slide", "mass [kg]", "CG [m]", "inertia [kg m²]", "how it moves")
    return [Table("On the machine", head, rows, kind="words")]


def _mounts(scenario: Scenario) -> list[Table]:
    """Where each stands, and, where any is not upright in the mount plane, its height, direction and shim."""
    plant, flat = scenario.plant, scenario.plant.flat and not any(scenario.plant.heights)
    actuators = {mount.name: mount.actuator for mount in scenario.mount}
    rows, stands = [], zip(plant.mounts, plant.positions, plant.directions, plant.heights, strict=True)
    for name, (x, y, z), along, shim in stands:
        general = [] if flat else [exact(z), ", ".join(map(exact, np.round(along, 6).tolist())), exact(1e3 * shim)]
        rows.append([name, exact(x), exact(y), *general, actuators[name]])
    general = [] if flat else ["z [m]", "acts along", "shim [mm]"]
    return [Table("Mounts", ("mount", "x [m]", "y [m]", *general, "actuator"), rows, kind="words")]


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
            yield named(key, about.description or ""), plain(value)


TABLES: Final[tuple[Callable[[Scenario], list[Table]], ...]] = (
    lambda scenario: [_quantities("Machine", scenario.machine)],
    _parts,
    _mounts,
    _actuators,
    lambda scenario: [_quantities("Supply", scenario.supply)],
    _run,
    lambda scenario: [_settings("Ground", scenario.ground)],
    lambda scenario: [_settings("Control", scenario.control)],
    _observed,
)
"""Tables of a scenario, in the page's order; each stands once where results share it."""
