"""Figures as SVG, in files of their own and as parts of a page."""

import io
import re

from ehamj.plots.style import FONTS, Figure, styled


def svg(figure: Figure, name: str) -> str:
    """The figure as an SVG file: text as text, the same bytes every time, its ids beginning with ``name``."""
    title = figure.get_suptitle().replace("\n", " ")
    with styled(), io.StringIO() as file:
        figure.savefig(file, format="svg", metadata={"Date": None, "Creator": None, "Title": title})
        text = file.getvalue()
    text = re.sub(r"<metadata>.*?</metadata>\s*", "", text, flags=re.DOTALL)
    text = re.sub(r"<!--.*?-->\s*", "", text, flags=re.DOTALL)
    text = re.sub(r"<!DOCTYPE.*?>\s*", "", text, flags=re.DOTALL)
    text = re.sub(r'(\bid="|href="#|url\(#)([^")]*)', lambda found: f"{found[1]}{name}-{_plain(found[2])}", text)
    text = re.sub(r' d="[^"]*"', lambda path: re.sub(r"(?<=\.\d\d)\d+", "", path.group()), text)
    return text.replace("'DejaVu Sans', sans-serif", FONTS)


def _plain(text: str) -> str:
    """An id of a name that a user gave: without blanks and the like."""
    return re.sub(r"[^\w-]", "-", text)


def inline(text: str) -> str:
    """An SVG file as a part of an HTML page: without the prologue, scaled by the page."""
    text = re.sub(r"<\?xml.*?\?>\s*", "", text, count=1, flags=re.DOTALL)
    return re.sub(r' xmlns:xlink="[^"]*"', "", text, count=1)
