"""One HTML file without external parts, and its figures as files."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from ehamj import plots
from ehamj.report.figures import attenuation, criterion, machine
from ehamj.report.histories import histories
from ehamj.report.inputs import inputs
from ehamj.report.parts import Picture, Results, colors_of
from ehamj.report.tables import bands_table, facts, levels, oil, saturation, timing
from ehamj.report.verdict import classes, failure, headline, notes, verdict, warnings
from ehamj.result import written_whole

FAMILIES: Final = ("machine-", "attenuation-", "criterion-", "history-")
"""How the names of a report's figures begin; those that an earlier report left behind are removed."""


def write_report(folder: Path, results: Results) -> None:
    """Write ``report.html``, one page without external parts, and its figures as ``figures/*.svg``.

    Args:
        folder: existing folder.
        results: by label; the first is the one reported, the others are variants beside it.

    Raises:
        ValueError: if there is no result.
    """
    if not results:
        raise ValueError("results: a report needs at least one")
    pictures = draw(results)
    drawings = {picture.name: plots.svg(picture.figure, picture.name) for picture in pictures}
    figures = folder / "figures"
    figures.mkdir(exist_ok=True)
    for old in figures.glob("*.svg"):
        if old.stem not in drawings and old.stem.startswith(FAMILIES):
            old.unlink()
    for name, text in drawings.items():
        with written_whole(figures / f"{name}.svg") as path:
            path.write_text(text, encoding="utf-8")
    with written_whole(folder / "report.html") as path:
        path.write_text(page(results, pictures, drawings), encoding="utf-8")


def draw(results: Results) -> list[Picture]:
    """Every figure of the page, in its order."""
    colors = colors_of(results)
    return [
        *machine(next(iter(results.values())).scenario),
        *attenuation(results, colors),
        *criterion(results, colors),
        *histories(results, colors),
    ]


def page(results: Results, pictures: Sequence[Picture], drawings: Mapping[str, str]) -> str:
    """The page as HTML; ``drawings`` holds the SVG of each picture by name."""
    loader = PackageLoader("ehamj", "templates")
    environment = Environment(
        loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    sections: dict[str, list[dict[str, Any]]] = {}
    for picture in pictures:
        drawing = Markup(plots.inline(drawings[picture.name]))
        title = picture.figure.get_suptitle()
        sections.setdefault(picture.section, []).append(
            {"name": picture.name, "title": title, "caption": picture.caption, "svg": drawing}
        )
    first = next(iter(results.values()))
    return environment.get_template("report.html").render(
        scenario=first.scenario,
        variants=len(results),
        failures={label: failure(result) for label, result in results.items() if not result.complete},
        verdict=verdict(first),
        headline=headline(results),
        classes=classes(results),
        facts=facts(first),
        warnings=warnings(results, processing=False),
        processing=warnings(results, processing=True),
        figures=sections,
        notes=notes(results),
        bands=bands_table(results),
        tables=[levels(results), saturation(results), oil(results), timing(results)],
        inputs=list(inputs(results)),
        versions=first.summary.get("versions", {}),
    )
