"""The order of pages: as mkdocs.yml names them, and with a star those that begin so and that it does not name."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any


def named(nav: Any) -> Iterator[str]:
    """Every path in a tree of titles and paths."""
    if isinstance(nav, str):
        yield nav
    for one in nav.values() if isinstance(nav, Mapping) else nav if isinstance(nav, list) else ():
        yield from named(one)


def filled(nav: list[Any], pages: Iterable[str]) -> list[Any]:
    """The same tree, ``folder/*`` replaced by the folder's pages, its index first; a title of none is left out."""
    taken = set(named(nav))
    free = sorted((page for page in pages if page not in taken), key=lambda page: not page.endswith("/index.md"))

    def fill(one: Any) -> list[Any]:
        if not isinstance(one, Mapping):
            return [page for page in free if page.startswith(one[:-1])] if one.endswith("*") else [one]
        ((title, below),) = one.items()
        inside = [entry for part in (below if isinstance(below, list) else [below]) for entry in fill(part)]
        folder = isinstance(below, list) or below.endswith("/*")
        return [{title: inside if folder else inside[0]}] if inside else []

    return [entry for one in nav for entry in fill(one)]
