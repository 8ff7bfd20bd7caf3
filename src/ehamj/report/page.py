"""The report of a run: which figures, tables and words stand on the page."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

from ehamj.report.document import render, write_page
from ehamj.report.figures import attenuation, machine
from ehamj.report.histories import histories
from ehamj.report.inputs import inputs
from ehamj.report.limits import against_limits, margins, when_limited
from ehamj.report.modal import modal_tables, rocking_map
from ehamj.report.norms import attenuation_at_places, classes_at_places, criterion
from ehamj.report.observed import relative_figures, relative_table, spectra
from ehamj.report.parts import Picture, Results, colors_of
from ehamj.report.responses import transmissibility
from ehamj.report.tables import bands_table, facts, levels, oil, saturation, timing
from ehamj.report.verdict import HEADLINE_BANDS, classes, failure, headline, notes, verdict, warnings

FAMILIES: Final = (
    *("machine-", "attenuation-", "transmissibility-", "criterion-", "spectrum-", "relative-", "history-", "modes-"),
)
"""How the names of a report's figures begin; those that an earlier report left behind are removed."""


def write_report(folder: Path, results: Results, name: str = "report", figures: str = "figures") -> None:
    """Write ``report.html``, one page without external parts, and its figures as ``figures/*.svg``.

    Args:
        folder: existing folder.
        results: by label; the first is the one reported, the others are variants beside it.
        name: of the page, without ending.
        figures: of the figures' folder.

    Raises:
        ValueError: if there is no result.
    """
    if not results:
        raise ValueError("results: a report needs at least one")
    pictures = draw(results)
    write_page(folder, f"{name}.html", pictures, lambda drawings: page(results, pictures, drawings), FAMILIES, figures)


def draw(results: Results) -> list[Picture]:
    """Every figure of the page, in its order."""
    colors = colors_of(results)
    return [
        *machine(next(iter(results.values())).scenario),
        *attenuation(results, colors),
        *transmissibility(results, colors),
        *criterion(results, colors),
        *spectra(results, colors),
        *relative_figures(results, colors),
        *histories(results, colors),
        *rocking_map(next(iter(results.values())).scenario),
    ]


def page(results: Results, pictures: Sequence[Picture], drawings: Mapping[str, str]) -> str:
    """The page as HTML; ``drawings`` holds the SVG of each picture by name."""
    first = next(iter(results.values()))
    return render(
        "report.html",
        pictures,
        drawings,
        scenario=first.scenario,
        variants=len(results),
        failures={label: failure(result) for label, result in results.items() if not result.complete},
        verdict=verdict(first),
        headline=headline(results),
        classes=classes(results),
        places=[table for table in (attenuation_at_places(results, HEADLINE_BANDS),) if table],
        judged=[table for table in (classes_at_places(results),) if table],
        relative=[table for table in (relative_table(results),) if table],
        facts=facts(first),
        warnings=warnings(results, processing=False),
        processing=warnings(results, processing=True),
        notes=notes(results),
        bands=bands_table(results),
        modal=list(modal_tables(results)),
        limits=[against_limits(results), saturation(results), when_limited(results), margins(results), oil(results)],
        tables=[levels(results), timing(results)],
        inputs=list(inputs(results)),
        versions=first.summary.get("versions", {}),
    )
