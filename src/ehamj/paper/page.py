"""The reproduction as files: figures, table, record, and one page with everything."""

import csv
import json
from pathlib import Path
from typing import Final

from ehamj.pages import Page, Picture, Section, Table, badge, write_page
from ehamj.paper.figures import FIGURES, LOCUS, figure, root_locus
from ehamj.paper.reproduction import FAILS, GIVEN, Reproduction
from ehamj.result import written_whole

_KINDS: Final = {FAILS: "fails", GIVEN: "given"}
"""Looks of a verdict; any other is a number that comes out."""


def write_paper(folder: Path, found: Reproduction) -> None:
    """Write the paper's figures (SVG, PNG), its table (``table.csv``, ``table.html`` with everything) and
    ``paper.json`` into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    page = paper_page(found)
    write_page(folder, "table.html", page, figures=".")
    for picture in page.pictures:
        with written_whole(folder / f"{picture.id}.png") as path:
            picture.figure.savefig(path, dpi=300)
    rows = [number.to_dict() for number in found.table]
    with (folder / "table.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    record = json.dumps(found.to_dict(), indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    (folder / "paper.json").write_text(record, "utf-8")


def paper_page(found: Reproduction) -> Page:
    """The table, the claims and the figures as one page."""
    numbers = [
        (
            row.name, row.section, row.stated, row.computed, row.deviation, row.allowed_text,
            badge(row.verdict, _KINDS.get(row.verdict, "agrees")), row.note,
        )
        for row in found.table
    ]  # fmt: skip
    words = [(claim.statement, claim.section, claim.finding) for claim in found.claims]
    head = ("Number", "Section", "Paper", "Computed", "Deviation", "Table I allows", "Verdict", "Comment")
    table = Table("", head, numbers, kind="words", numeric=(2, 3, 4, 5))
    said = Table("", ("Statement", "Section", "What the numbers say"), words, kind="words")
    drawn = [Picture(name, figure(found, name), caption) for name, (caption, _) in FIGURES.items()]
    drawn.append(Picture("root-locus", root_locus(found), LOCUS))
    return Page(
        "The paper, reproduced",
        "The paper, reproduced",
        "Every number that “Design guidelines for an electro-hydraulic actuator to isolate machines from vibrations” "
        "states, beside what its equations give with its Table I. “Table I allows” is what the rounding of its values "
        "leaves open.",
        (
            Section("numbers", "Number by number", tables=[table]),
            Section("claims", "What the paper says in words", tables=[said]),
            Section("figures", "The figures", figures=drawn),
        ),
    )
