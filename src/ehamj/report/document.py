"""HTML pages without external parts, and their figures as files."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from ehamj import plots
from ehamj.report.parts import Picture
from ehamj.result import written_whole


def render(template: str, pictures: Sequence[Picture], drawings: Mapping[str, str], **values: Any) -> str:
    """A page as HTML; ``drawings`` holds the SVG of each picture by name, ``values`` what else the template shows."""
    loader = PackageLoader("ehamj", "templates")
    environment = Environment(
        loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    sections: dict[str, list[dict[str, Any]]] = {}
    for picture in pictures:
        drawing = Markup(plots.inline(drawings[picture.name]))
        title = picture.figure.get_suptitle()
        sections.setdefault(picture.section, []).append(
            {"name": picture.name, "title": title, "caption": picture.caption, "svg": drawing, "wide": picture.wide}
        )
    return environment.get_template(template).render(figures=sections, **values)


def write_page(
    folder: Path,
    name: str,
    pictures: Sequence[Picture],
    page: Callable[[Mapping[str, str]], str],
    families: tuple[str, ...] = (),
    figures_folder: str = "figures",
) -> None:
    """Write a page and its figures as SVG files.

    Args:
        folder: existing folder.
        name: of the page's file.
        pictures: of the page.
        page: the page as HTML, from the SVG of each picture by name.
        families: how the names of this page's figures begin; those that an earlier page left behind are removed.
        figures_folder: name of the figures' folder beside the page.
    """
    drawings = {picture.name: plots.svg(picture.figure, picture.name) for picture in pictures}
    figures = folder / figures_folder
    figures.mkdir(exist_ok=True)
    for old in figures.glob("*.svg"):
        if families and old.stem not in drawings and old.stem.startswith(families):
            old.unlink()
    for picture, text in drawings.items():
        with written_whole(figures / f"{picture}.svg") as path:
            path.write_text(text, encoding="utf-8")
    with written_whole(folder / name) as path:
        path.write_text(page(drawings), encoding="utf-8")
