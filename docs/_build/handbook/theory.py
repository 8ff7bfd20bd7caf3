"""docs/physics.md in chapters: one page for each section, the preface and their list for the first."""

import re
from typing import Final, NamedTuple, Self

from pymdownx.slugs import slugify

_SLUG: Final = slugify(case="lower")
_HEADING: Final = re.compile(r"^(#+) (.+)$", re.MULTILINE)
_LINK: Final = re.compile(r"(?<!\\)\]\((?!https?:|mailto:)([^)\s]+)\)")
_OTHERS: Final = re.compile(r"\]\((?P<up>(?:\.\./)*)physics\.md(?:#(?P<anchor>[^)\s]+))?\)")


def anchor_of(title: str) -> str:
    """The anchor of a heading, here and where the file is shown by itself."""
    return str(_SLUG(re.sub(r"[`*$]", "", title), "-"))


class Chapter(NamedTuple):
    """One section: its number, its title, and its text as it stands in the file, heading and all."""

    number: int
    title: str
    text: str

    @property
    def name(self) -> str:
        """Name of its file, without folder."""
        return f"{anchor_of(f'{self.number:02d} {self.title}')}.md"

    @property
    def anchors(self) -> list[str]:
        """Of all its headings."""
        return [anchor_of(found[2]) for found in _HEADING.finditer(_without_code(self.text))]


class Theory(NamedTuple):
    """All of the file."""

    title: str
    preface: str
    chapters: list[Chapter]

    @classmethod
    def of(cls, text: str) -> Self:
        """Split at the headings of the second level, which are numbered from 1.

        Raises:
            ValueError: if a heading has not the number that follows.
        """
        first, *sections = re.split(r"^(?=## )", text, flags=re.MULTILINE)
        title, _, preface = first.removeprefix("# ").partition("\n")
        chapters = []
        for number, section in enumerate(sections, 1):
            head = re.match(r"## (\d+)\. (.+)\n", section)
            if head is None or int(head[1]) != number:
                raise ValueError(f"docs/physics.md: {section.splitlines()[0]!r} must be '## {number}. …'")
            chapters.append(Chapter(number, head[2].strip(), section))
        return cls(title.strip(), preface.strip(), chapters)

    def page_of(self, anchor: str) -> str:
        """Name of the page with an anchor of the file, and the anchor.

        Raises:
            KeyError: if no heading has it.
        """
        where = {one: chapter.name for chapter in self.chapters for one in chapter.anchors}
        return f"{where[anchor]}#{anchor}"

    def pages(self) -> dict[str, str]:
        """Markdown by path within the site: headings one level up, links from where a chapter stands."""
        found = {
            f"theory/{one.name}": self._moved(re.sub(r"^##", "#", _outdented(one.text), count=1))
            for one in self.chapters
        }
        listed = "\n".join(f"{one.number}. [{one.title}]({one.name})" for one in self.chapters)
        return {"theory/index.md": f"# {self.title}\n\n{self._moved(self.preface)}\n\n{listed}\n", **found}

    def links_here(self, text: str) -> str:
        """Another page, its links to the file led to chapters."""

        def led(found: re.Match[str]) -> str:
            where = self.page_of(found["anchor"]) if found["anchor"] else "index.md"
            return f"]({found['up']}theory/{where})"

        return _OTHERS.sub(led, text)

    def _moved(self, text: str) -> str:
        """Links that are relative to docs/, seen from docs/theory/."""

        def seen(found: re.Match[str]) -> str:
            at = found[1]
            return f"]({self.page_of(at[1:]) if at.startswith('#') else f'../{at}'})"

        return re.sub(r'(<img[^>]* src=")(?!https?:)', r"\1../", _LINK.sub(seen, text))


def _without_code(text: str) -> str:
    return re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)


def _outdented(text: str) -> str:
    """Headings below the section's own, one level up."""
    return re.sub(r"^###(?=#* )", "##", text, flags=re.MULTILINE)
