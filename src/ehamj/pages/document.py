"""Pages as HTML, and their figures as files: the one template environment."""

import re
from collections import defaultdict
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from ehamj import plots
from ehamj.pages.parts import Page
from ehamj.result import written_whole


@cache
def _environment() -> Environment:
    loader = PackageLoader("ehamj.pages")
    made = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    made.filters["css_text"] = _css_text
    return made


def _css_text(text: str) -> str:
    """Any text as a string of a style sheet: all but letters, digits and spaces by their numbers."""
    return Markup('"{}"').format(Markup("".join(c if c.isalnum() or c == " " else f"\\{ord(c):x} " for c in text)))


def render(page: Page, drawings: Mapping[str, str] | None = None) -> str:
    """A page as HTML; ``drawings`` holds the SVG of each figure by its id, without them the page shows none."""
    if drawings is None:
        inline: Mapping[str, str] = defaultdict(str)
    else:
        inline = {name: Markup(plots.inline(text)) for name, text in drawings.items()}
    return _environment().get_template("page.html").render(page=page, drawings=inline).lstrip()


def write_page(folder: Path, name: str, page: Page, figures: str = "figures") -> None:
    """Write a page, and its figures as SVG files; figures of the page that was there before are removed.

    Args:
        folder: existing folder.
        name: of the page's file.
        page: what it shows.
        figures: name of the figures' folder in it; "." for the folder itself.

    Raises:
        ValueError: if two figures have one name.
    """
    drawings = {picture.id: plots.svg(picture.figure, picture.id) for picture in page.pictures}
    if len(drawings) != len(page.pictures):
        raise ValueError(f"{name}: two of the figures {', '.join(picture.name for picture in page.pictures)} are alike")
    target = folder / figures
    target.mkdir(exist_ok=True)
    before, known = folder / name, set[str]()
    if before.is_file():
        known = set(re.findall(r'<figure id="figure-([\w-]+)"', before.read_text(encoding="utf-8")))
    for picture, text in drawings.items():
        with written_whole(target / f"{picture}.svg") as path:
            path.write_text(text, encoding="utf-8")
    with written_whole(before) as path:
        path.write_text(render(page, drawings), encoding="utf-8")
    for old in known - set(drawings):
        (target / f"{old}.svg").unlink(missing_ok=True)
