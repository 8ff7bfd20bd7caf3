"""What a page is made of: sections of notes, figures and tables."""

import hashlib
import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from datetime import date
from typing import Final

from markupsafe import Markup

from ehamj.plots import Figure

NARROW: Final = 64
"""Letters of a row of words, with its gaps, that stand on half a sheet's width."""
BREAKS: Final = 18
"""Letters at which a cell of words breaks."""
LONG: Final = 300
"""Letters of a cell from which on it is no cell of a narrow table."""
SHORT: Final = 16
"""Rows from which on a table may go on on the next sheet."""


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
    folded: str = ""
    """The line that stands for it where it is folded away, such as its worst one; without, it stands open."""

    @property
    def short(self) -> bool:
        """Whether it is not parted on paper."""
        return len(self.rows) < SHORT

    @property
    def broad(self) -> bool:
        """Whether it needs the whole width of a sheet."""
        rows = [row for row in (self.head, *self.rows) if len(row) == len(self.head)]
        widest = [max(map(_letters, column)) for column in zip(*rows, strict=True)]
        if self.kind != "words":  # nothing in them breaks
            return sum(widest) + 3 * len(widest) > NARROW
        return max(widest) > LONG or sum(min(letters, BREAKS) + 3 for letters in widest) > NARROW

    def side(self, column: int) -> str:
        """The attribute of a cell in a column."""
        return Markup(' class="number"') if column in self.numeric else ""


def _letters(cell: str) -> int:
    """How long a cell is to be read."""
    return len(Markup(cell).striptags())


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
    """Its look, where it is one of its own: ``headline``, ``warnings``; ``abreast``: tables or facts beside figures;
    ``sheet``: on a new sheet."""
    tables_first: bool = False
    """Whether tables stand above the figures."""

    @property
    def begins(self) -> "Picture | Table | None":
        """What is kept with the heading: the first figure, or a short table that stands first."""
        table = next((table for table in self.tables if table.rows), None)
        if self.figures and not (self.tables_first and table):
            return self.figures[0]
        return table if table is not None and (table.short or table.broad) else None

    @property
    def begins_broad(self) -> bool:
        """Whether that needs the whole width of a sheet."""
        return _broad(self.begins)

    @property
    def ends_broad(self) -> bool:
        """Whether what stands last does."""
        tables = [table for table in self.tables if table.rows]
        shown: list[Picture | Table] = [*tables, *self.figures] if self.tables_first else [*self.figures, *tables]
        return "abreast" in self.kind or self.kind == ANNEX.kind or bool(not self.items and shown and _broad(shown[-1]))


def _broad(part: Picture | Table | None) -> bool:
    return part is not None and (part.wide if isinstance(part, Picture) else part.broad)


ANNEX: Final = Section("annex", "Annex", kind="annex")
"""Where the annex begins: on paper what stands before is the part that a client reads, and this a sheet of its own."""


@dataclass(frozen=True)
class Page:
    """A page: its heading, what it says first, its sections; those after `ANNEX` are the annex."""

    title: str
    heading: str
    lead: str
    sections: Sequence[Section]
    verdict: Sequence[tuple[str, str]] = ()
    """What came out, first on the page: whose it is ("" where it is nobody's), and what."""
    alerts: Sequence[tuple[str, str]] = ()
    """What went wrong, above everything: a few words, and what it means."""
    footer: str = ""
    mark: str = ""
    """What runs it shows (`ehamj.belonging.shown_mark`), if it shows any."""
    day: str = field(default_factory=lambda: date.today().isoformat())
    """When it was made, for the heads of the sheets."""

    @property
    def pictures(self) -> list[Picture]:
        """All its figures, in order."""
        return [picture for section in self.sections for picture in section.figures]
