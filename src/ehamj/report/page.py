"""The report of a run: one page from its sections."""

from collections.abc import Callable, Sequence
from pathlib import Path

from ehamj.belonging import shown_mark
from ehamj.pages import Page, Section, write_page
from ehamj.report.sections import SECTIONS
from ehamj.report.shown import Results, Shown
from ehamj.report.verdict import failures, verdict


def write_report(folder: Path, shown: Results | Shown, name: str = "report", figures: str = "figures") -> None:
    """Write ``report.html``, one page without external parts, and its figures as ``figures/*.svg``.

    Args:
        folder: existing folder.
        shown: results by label; the first is the one reported, the others are variants beside it. `Shown.of` results
            several pages may share.
        name: of the page, without ending.
        figures: of the figures' folder.

    Raises:
        ValueError: if there is no result.
    """
    write_page(folder, f"{name}.html", report_page(shown), figures)


def report_page(shown: Results | Shown, sections: Sequence[Callable[[Shown], Section | None]] = SECTIONS) -> Page:
    """The report as a page; arguments as of `write_report`, and the sections that it has."""
    shown = shown if isinstance(shown, Shown) else Shown.of(shown)
    scenario, summary = shown.scenario, shown.first.summary
    versions = ", ".join(f"{name} {version}" for name, version in summary.versions.items())
    return Page(
        f"{_heading(shown)}: vibration isolation report",
        _heading(shown),
        scenario.description if shown.together else "",
        [found for section in sections if (found := section(shown)) is not None],
        verdict(shown),
        failures(shown.results),
        f"Versions: {versions}.",
        mark=shown_mark(result.identity for result in shown.results.values()),
    )


def _heading(shown: Shown) -> str:
    """The scenario's name; of several scenarios the label of each."""
    return shown.scenario.name if shown.together else " beside ".join(shown.results)
