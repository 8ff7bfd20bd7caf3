"""Motions of one place relative to another."""

from collections.abc import Iterator

from ehamj import plots
from ehamj.pages import Picture, Section, Table
from ehamj.pages.words import MICRO, measured, scaled
from ehamj.plots import Levels
from ehamj.report.shown import Shown, known


def relative(shown: Shown) -> Section | None:
    """The relative motions that the first result's scenario asks for."""
    table = _table(shown)
    return Section("relative", "Relative motion", list(_figures(shown)), [table]) if table.rows else None


def _figures(shown: Shown) -> Iterator[Picture]:
    """Third-octave displacement of each, all axes together."""
    for name, first in shown.first.summary.relative.items():
        curves = [
            Levels.of_bands(label, own.third_octave_displacement["total"], shown.colors[label], MICRO)
            for label, result in shown.results.items()
            if (own := result.summary.relative.get(name))
            and max(known([own.third_octave_displacement["total"]]), default=0.0) > 0.0
        ]
        if curves:
            figure = plots.levels(f"Relative motion, {name}", curves, "RMS displacement per band [µm]")
            caption = f"{first.origin} against {first.to}; all three axes together."
            yield Picture(f"relative-{name}", figure, caption)


def _table(shown: Shown) -> Table:
    """Peak and RMS of each."""
    rows: list[list[str]] = []
    for name, about in shown.first.summary.relative.items():
        found = [result.summary.relative.get(name) for result in shown.results.values()]
        kinds = [kind for own in found for kind in ((own.peak, own.rms) if own else ({}, {}))]
        rows.append([f"{name}: {about.origin} against {about.to}"])
        for part, words in (("x", "x"), ("y", "y"), ("z", "z"), ("total", "distance")):
            rows.append([words, *(measured(scaled(kind.get(part), MICRO)) for kind in kinds)])
    head = ["", *(f"{label}, {kind}" for label in shown.results for kind in ("peak", "RMS"))]
    return Table("Relative motion [µm]", head, rows, "About its value at the start of the run.", kind="numbers wide")
