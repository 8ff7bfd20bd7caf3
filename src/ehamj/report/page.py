"""The report of a run: which figures, tables and words stand on the page."""

from collections.abc import Iterator
from pathlib import Path
from typing import Final

from markupsafe import Markup

from ehamj.pages import Page, Section, badge, write_page
from ehamj.report.figures import attenuation, machine
from ehamj.report.histories import histories
from ehamj.report.inputs import inputs
from ehamj.report.limits import against_limits, margins, when_limited
from ehamj.report.modal import modal_tables, rocking_map
from ehamj.report.norms import attenuation_at_places, classes_at_places, criterion
from ehamj.report.observed import relative_figures, relative_table, spectra
from ehamj.report.responses import transmissibility
from ehamj.report.shown import Results, colors_of
from ehamj.report.tables import bands_table, facts, levels, oil, saturation, timing
from ehamj.report.verdict import HEADLINE_BANDS, classes, failure, headline, notes, verdict, warnings

SOURCES: Final = {
    "paper": "the source paper's table or text",
    "identified": "fitted to something that the paper states",
    "assumed": "chosen, because nobody measured it",
    "given": "set by the user",
}
"""What each source of a parameter means."""


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
    write_page(folder, f"{name}.html", report_page(results), figures)


def report_page(results: Results) -> Page:
    """The report as a page."""
    if not results:
        raise ValueError("results: a report needs at least one")
    first = next(iter(results.values()))
    versions = ", ".join(f"{name} {version}" for name, version in first.summary.get("versions", {}).items())
    return Page(
        f"{first.scenario.name}: vibration isolation report",
        first.scenario.name,
        first.scenario.description,
        list(_sections(results)),
        verdict(first),
        [
            (
                f"Incomplete: {label}" if len(results) > 1 else "Incomplete",
                f"{failure(result)}. Every number of this run below holds only until then.",
            )
            for label, result in results.items()
            if not result.complete
        ],
        f"Versions: {versions}.",
    )


def _sections(results: Results) -> Iterator[Section]:
    scenario, colors, beside = next(iter(results.values())).scenario, colors_of(results), notes(results)
    top = headline(results)
    yield Section("headline", tables=[top], notes=() if top.rows else [top.note], kind="headline")
    yield Section("classes", tables=[classes(results)])
    if found := warnings(results, processing=False):
        yield Section("warnings", items=found, items_title="Warnings", kind="warnings")
    first = next(iter(results.values()))
    yield Section("machine", "What was simulated", list(machine(scenario)), facts=facts(first))
    yield Section(
        "attenuation",
        "Attenuation",
        list(attenuation(results, colors)),
        [table for table in (attenuation_at_places(results, HEADLINE_BANDS),) if table],
        beside["attenuation"],
    )
    figures = list(transmissibility(results, colors))
    yield Section("transmissibility", "Transmissibility", figures, notes=beside["transmissibility"])
    tables = [table for table in (classes_at_places(results),) if table]
    yield Section("criterion", "Criteria", list(criterion(results, colors)), tables, beside["criterion"])
    if figures := list(spectra(results, colors)):
        yield Section("spectra", "Response spectra", figures, notes=beside["spectra"])
    if table := relative_table(results):
        yield Section("relative", "Relative motion", list(relative_figures(results, colors)), [table])
    yield Section("histories", "Time histories", list(histories(results, colors)), notes=beside["histories"])
    limited = [against_limits(results), saturation(results), when_limited(results), margins(results), oil(results)]
    yield Section("limits", "Limits, oil and power", tables=limited)
    if modal := list(modal_tables(results)):
        yield Section("modes", "Modes", list(rocking_map(scenario)), modal, tables_first=True)
    yield Section("tables", "Numbers", tables=[bands_table(results), levels(results), timing(results)])
    sources = [Markup("{} {}").format(badge(name), text) for name, text in SOURCES.items()]
    yield Section(
        "inputs",
        "Parameters and settings",
        tables=list(inputs(results)),
        notes=[Markup("Sources: {}.").format(Markup("; ").join(sources))],
        items=warnings(results, processing=True),
        items_title="How the record was processed",
    )
