"""Motions of one place relative to another."""

from collections.abc import Iterator

from ehamj import plots
from ehamj.pages import Picture, Section, Table
from ehamj.pages.words import MICRO, measured, scaled
from ehamj.plots import Levels
from ehamj.report.shown import Shown, known


def relative(shown: Shown) -> Section | None:
    """The relative motions that the first result's scenario asks for."""
    if not shown.first.summary.get("relative"):
        return None
    return Section("relative", "Relative motion", list(_figures(shown)), [_table(shown)])


def _figures(shown: Shown) -> Iterator[Picture]:
    """Third-octave displacement of each, all axes together."""
    for name, first in shown.first.summary["relative"].items():
        curves = []
        for label, result in shown.results.items():
            own = result.summary.get("relative", {}).get(name, {})
            table = own.get("third_octave_displacement", {}).get("total", {})
            if max(known([table]), default=0.0) > 0.0:
                curves.append(Levels.of_bands(label, table, shown.colors[label], MICRO))
        if curves:
            figure = plots.levels(f"Relative motion, {name}", curves, "RMS displacement per band [µm]")
            caption = f"{first['from']} against {first['to']}; all three axes together."
            yield Picture(f"relative-{name}", figure, caption)


def _table(shown: Shown) -> Table:
    """Peak and RMS of each."""
    rows: list[list[str]] = []
    tables = [result.summary.get("relative", {}) for result in shown.results.values()]
    for name, about in tables[0].items():
        rows.append([f"{name}: {about['from']} against {about['to']}"])
        for part in ("x", "y", "z", "total"):
            cells = [
                measured(scaled(table.get(name, {}).get(kind, {}).get(part), MICRO))
                for table in tables
                for kind in ("peak", "rms")
            ]
            rows.append([{"total": "distance"}.get(part, part), *cells])
    head = ["", *(f"{label}, {kind}" for label in shown.results for kind in ("peak", "RMS"))]
    return Table("Relative motion [µm]", head, rows, "About its value at the start of the run.", kind="numbers wide")
