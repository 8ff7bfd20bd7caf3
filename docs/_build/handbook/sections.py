"""Words that name a section of the theory, made links to its chapter."""

import re
from collections.abc import Callable
from typing import Final

_TAGS: Final = re.compile(r"(<[^>]+>)")
_CLOSED: Final = ("a", "code", "pre", "math", "h1", "h2", "h3", "h4", "script", "style")
"""Elements within which nothing becomes a link."""
_NAMED: Final = re.compile(r"docs/physics\.md, sections? (\d+)")
_WITHIN: Final = re.compile(r"\bsections? (\d+)\b")


def link_sections(html: str, chapter_url: Callable[[int], str | None], within: bool) -> str:
    """A page with its mentions of sections as links.

    Args:
        html: content of the page.
        chapter_url: address of a chapter seen from the page, None of a number that has none.
        within: whether the page is a chapter itself, where "section 3" alone is one of them.
    """
    pattern = _WITHIN if within else _NAMED

    def linked(found: re.Match[str]) -> str:
        url = chapter_url(int(found[1]))
        text = found[0].replace("docs/physics.md,", "theory,")
        return found[0] if url is None else f'<a href="{url}">{text}</a>'

    depth, parts = 0, []
    for part in _TAGS.split(html):
        name = re.match(r"</?([a-z0-9]+)", part) if part.startswith("<") else None
        if name is not None and name[1] in _CLOSED and not part.endswith("/>"):
            depth += -1 if part.startswith("</") else 1
        parts.append(pattern.sub(linked, part) if name is None and depth == 0 else part)
    return "".join(parts)
