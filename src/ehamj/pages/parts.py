"""What a page is made of: sections of notes, figures and tables."""

import hashlib
import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass

from markupsafe import Markup

from ehamj.plots import Figure


def safe_name(text: str) -> str:
    """A file name and HTML id from any name: letters, digits, ``-`` and ``_`` stay, so that most names stay whole.

    A name that has to change gets a mark of its own, so that two names never meet in one file.
    """
    safe = re.sub(r"[^\w-]+", "-", text)
    return safe if safe == text and safe else f"{safe}-{hashlib.sha256(text.encode()).hexdigest()[:6]}"


def badge(word: str, kind: str = "") -> str:
    """A word that a page shows as a badge; ``kind`` is its look, which is the word's own without."""
    return Markup('<span class="badge {}">{}</span>').format(kind or word, word) if word else ""


@dataclass(frozen=True)
class Picture:
    """A figure of the page and what is said below it.

    ``name`` may be any text, unique on its page: `id` is what its file and anchor are called.
    """

    name: str
    figure: Figure
    caption: str = ""
    wide: bool = False
    """Whether it needs the whole width of the page; on a phone it scrolls."""

    @property
    def id(self) -> str:
        """Its file's name without ending; on the page it is ``figure-ID``."""
        return safe_name(self.name)


@dataclass(frozen=True)
class Table:
    """A table of the page; without rows it is left out. A row's first cell is its name; one of one cell is a heading.

    Cells are text; `badge` and other Markup stay as they are.
    """

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""
    kind: str = "numbers"
    """``numbers`` (to the right; ``numbers wide``: with long names) or ``words`` (to the left)."""
    numeric: Collection[int] = ()
    """Columns of a table of words that hold numbers."""

    def side(self, column: int) -> str:
        """The attribute of a cell in a column."""
        return Markup(' class="number"') if column in self.numeric else ""


@dataclass(frozen=True)
class Section:
    """A part of a page: notes, then figures, tables and a list of items; what is empty is left out."""

    id: str
    """Anchor on the page; unique there."""
    title: str = ""
    figures: Sequence[Picture] = ()
    tables: Sequence[Table] = ()
    notes: Sequence[str] = ()
    """How to read it, a paragraph each."""
    facts: Sequence[tuple[str, str]] = ()
    """Name and value, one below the other, above all else."""
    items: Sequence[str] = ()
    items_title: str = ""
    kind: str = ""
    """Its look, where it is one of its own: ``headline``, ``warnings``."""
    tables_first: bool = False
    """Whether tables stand above the figures."""


@dataclass(frozen=True)
class Page:
    """A page: its heading, what it says first, its sections."""

    title: str
    heading: str
    lead: str
    sections: Sequence[Section]
    verdict: Sequence[tuple[str, str]] = ()
    """What came out, first on the page: whose it is ("" where it is nobody's), and what."""
    alerts: Sequence[tuple[str, str]] = ()
    """What went wrong, above everything: a few words, and what it means."""
    footer: str = ""

    @property
    def pictures(self) -> list[Picture]:
        """All its figures, in order."""
        return [picture for section in self.sections for picture in section.figures]
