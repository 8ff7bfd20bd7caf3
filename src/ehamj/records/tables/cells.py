"""Cells of a row: what parts them, and whether each is a number, a time, a word or empty."""

import csv
import re
from dataclasses import dataclass, field

from ehamj.records.tables.stamps import is_stamp

NAMES = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars", " ": "blanks"}
"""What parts cells, in words."""

NUMBER = {
    ".": re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?", re.ASCII),
    ",": re.compile(r"[-+]?(?:\d+|\d*,\d+)(?:[eEdD][-+]?\d+)?", re.ASCII),
}
"""A number, by its decimal mark."""

INFINITE = re.compile(r"[-+]?(?:inf|infinity|1\.#inf)", re.IGNORECASE)
ODD = re.compile(r"[-+]?[\d.,'’ ]*\d[\d.,'’ ]*(?:[eE][-+]?\d+)?")
"""Digits and marks that are no number as it stands, such as 1,234.5."""

EMPTY = re.compile(
    r"-*|[-+]?nan(?:\(ind\))?|[-+]?1\.#(?:qnan|ind|snan)|n/?a|#n/?a|null|none|missing|[.?*]", re.IGNORECASE
)
"""What stands for no value wherever it stands."""


LONGEST = 60
"""Characters of a number: what is longer is a word, and is not searched for marks."""

REMEMBERED = 2000
"""Lines whose kinds are remembered: where rows begin and end is asked several times."""


@dataclass(frozen=True)
class Dialect:
    """How a table writes its rows."""

    delimiter: str
    decimal: str
    thousands: str | None = None
    missing: frozenset[str] = frozenset()
    _known: dict[str, str] = field(default_factory=dict, compare=False, repr=False)

    def __str__(self) -> str:
        mark = ", decimal comma" if self.decimal == "," else ""
        return NAMES[self.delimiter] + mark

    def cells(self, line: str) -> list[str]:
        """Cells of a line without the blanks around them."""
        if '"' in line:
            return self._quoted(line)
        if self.delimiter == " ":
            return line.split()
        return [cell.strip() for cell in line.split(self.delimiter)]

    def _quoted(self, line: str) -> list[str]:
        blank = self.delimiter == " "
        line = line.replace("\t", " ").strip() if blank else line
        try:
            row = next(csv.reader([line], delimiter=self.delimiter, skipinitialspace=True), [])
        except csv.Error:  # a cell of more than 128 kB
            row = line.split(self.delimiter)
        return [cell.strip() for cell in row if cell or not blank]

    def kind(self, cell: str) -> str:
        """``n``\\ umber, ``t``\\ ime, ``e``\\ mpty, ``o``\\ dd (digits and marks, but no number) or ``w``\\ ord."""
        if len(cell) > LONGEST:
            return "w"
        if NUMBER[self.decimal].fullmatch(cell):
            return "e" if cell in self.missing else "n"
        digit = cell[:1].isdigit() and "#" not in cell  # 1.#QNAN
        if cell in self.missing or (not digit and EMPTY.fullmatch(cell)):
            return "e"
        if (self.thousands and self.ungrouped(cell) is not None) or (not digit and INFINITE.fullmatch(cell)):
            return "n"
        if digit and is_stamp(cell):
            return "t"
        return "o" if ODD.fullmatch(cell) else "w"

    def kinds(self, line: str) -> str:
        """Kinds of a line's cells, one letter each."""
        found = self._known.get(line)
        if found is None:
            found = "".join(map(self.kind, self.cells(line)))
            if len(self._known) < REMEMBERED:
                self._known[line] = found
        return found

    def number(self, cell: str) -> float | None:
        """The number that a cell holds, NaN where it is empty, None where it is anything else."""
        if len(cell) <= LONGEST and NUMBER[self.decimal].fullmatch(cell) and cell not in self.missing:
            plain = cell if self.decimal == "." else cell.replace(",", ".")
            try:
                return float(plain)
            except ValueError:  # Fortran's 1.5D-3
                return float(plain.translate(EXPONENT))
        kind = self.kind(cell)
        if kind == "e":
            return float("nan")
        if kind != "n":
            return None
        if INFINITE.fullmatch(cell):
            return float("-inf" if cell[0] == "-" else "inf")
        return float((self.ungrouped(cell) or "").replace(self.decimal, "."))

    def empty(self, cell: str) -> bool:
        """Whether a cell stands for no value."""
        return cell in self.missing or ((not cell[:1].isdigit() or "#" in cell) and self.kind(cell) == "e")

    def ungrouped(self, cell: str) -> str | None:
        """The cell without its marks of thousands, None where they stand elsewhere than every three digits.

        The apostrophe may be the typographic one.
        """
        if not self.thousands:
            return None
        cell = cell.replace("’", "'") if self.thousands == "'" else cell
        mark, decimal = re.escape(self.thousands), re.escape(self.decimal)
        grouped = re.fullmatch(rf"[-+]?\d{{1,3}}(?:{mark}\d{{3}})+(?:{decimal}\d*)?", cell)
        return cell.replace(self.thousands, "") if grouped else None


EXPONENT = str.maketrans("dD", "ee")
