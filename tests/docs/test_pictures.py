"""Pictures of the documentation: those that the script makes, and small; drawn figures within their frame."""

import re
from pathlib import Path
from xml.etree import ElementTree

import pytest
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import TextToPath

from pictures import LARGEST, PICTURES, SOURCES

DOCS = Path(__file__).parents[2] / "docs"
FIGURES = sorted((DOCS / "figures").glob("*.svg"))
SVG = "{http://www.w3.org/2000/svg}"
PAGES = "\n".join(page.read_text("utf-8") for page in [*DOCS.rglob("*.md"), DOCS.parent / "README.md"])


def test_pictures_are_those_of_the_script_and_small() -> None:
    kept = {path.stem: path.stat().st_size for path in PICTURES.glob("*")}
    assert set(kept) == {name for source in SOURCES for name in source.taken}
    assert max(kept.values()) <= LARGEST
    assert len(kept) <= 12


def test_every_picture_and_figure_is_on_a_page() -> None:
    shown = set(re.findall(r"!\[[^\]]+\]\((?:\S*/)?([\w-]+\.(?:png|svg))\)", PAGES))
    assert {path.name for path in [*PICTURES.iterdir(), *FIGURES]} <= shown


@pytest.mark.parametrize("path", FIGURES, ids=lambda path: path.stem)
def test_texts_of_a_figure_are_within_its_frame(path: Path) -> None:
    """By the widths of DejaVu Sans, which is as wide as any that a browser may take."""
    root = ElementTree.parse(path).getroot()
    width, height = (float(root.attrib[side]) for side in ("width", "height"))
    for text in root.iter(f"{SVG}text"):
        said, classes = "".join(text.itertext()), text.get("class", "").split()
        font = FontProperties(family="DejaVu Sans", size=13 if "soft" in classes else 15)
        wide, _, _ = TextToPath().get_text_width_height_descent(said, font, ismath=False)
        left = float(text.attrib["x"]) - wide * (0.5 if "c" in classes else 1.0 if "e" in classes else 0.0)
        assert 0.0 <= left <= width - wide, f"{said!r} is {wide:.0f} wide and begins at {left:.0f} of {width:g}"
        assert 12.0 <= float(text.attrib["y"]) <= height - 4.0, said
