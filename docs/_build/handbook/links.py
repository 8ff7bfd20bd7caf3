"""Whether a built site holds together: every link, anchor and picture of every page, and nothing from elsewhere."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Final
from urllib.parse import unquote, urldefrag

from lxml import html

ASSETS: Final = ("//script/@src", "//img/@src", "//iframe/@src", "//source/@src", "//object/@data", "//video/@src")
"""What a page loads by itself."""
SHEETS: Final = "//link[contains(@rel, 'stylesheet') or contains(@rel, 'icon') or contains(@rel, 'pre')]/@href"
ABROAD: Final = re.compile(r"(?:[a-z]+:)?//", re.IGNORECASE)


def faults(site: Path) -> list[str]:
    """What is wrong with a built site, one line each: the page, and what it names."""
    pages = {path: html.fromstring(path.read_bytes()) for path in sorted(site.rglob("*.html"))}
    anchors = {path: {*page.xpath("//@id"), *page.xpath("//a/@name")} for path, page in pages.items()}
    found = []
    for path, page in pages.items():
        if path.name == "404.html":  # its addresses are the server's
            continue
        said = path.relative_to(site)
        found += [f"{said}: {one}" for one in _broken(path, page, site, anchors)]
        found += [f"{said}: loads {one}" for one in _assets(page) if ABROAD.match(one)]
    return found + [f"{one}" for one in _styles(site)]


def _assets(page: html.HtmlElement) -> Iterator[str]:
    for where in (*ASSETS, SHEETS):
        yield from page.xpath(where)


def _broken(path: Path, page: html.HtmlElement, site: Path, anchors: dict[Path, set[str]]) -> Iterator[str]:
    """Links of a page that lead nowhere, or out of the site."""
    links = [one for one in (*page.xpath("//a/@href"), *_assets(page)) if not ABROAD.match(one)]
    for link in dict.fromkeys(links):
        if link.startswith(("mailto:", "data:")):
            continue
        address, anchor = urldefrag(link)
        target = (path.parent / unquote(address)).resolve() if address else path
        if not target.is_relative_to(site) or not target.is_file():
            yield f"{link} is no file"
        elif anchor and target in anchors and unquote(anchor) not in anchors[target]:
            yield f"{link} has no such anchor"


def _styles(site: Path) -> Iterator[str]:
    """Style sheets that load from elsewhere."""
    for path in sorted(site.rglob("*.css")):
        for link in re.findall(r"url\(\s*['\"]?([^'\")]+)|@import\s+['\"]([^'\"]+)", path.read_text(encoding="utf-8")):
            if ABROAD.match("".join(link)):
                yield f"{path.relative_to(site)}: loads {''.join(link)}"
