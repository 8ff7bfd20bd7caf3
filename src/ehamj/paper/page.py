"""The reproduction as files: figures, table, record, and one page with everything."""

import csv
import html
import json
from pathlib import Path
from typing import Final

from ehamj.paper.figures import FIGURES, figure, save_figure
from ehamj.paper.reproduction import Reproduction
from ehamj.paper.table import FAILS, GIVEN, PaperNumber


def write_paper(folder: Path, found: Reproduction) -> None:
    """Write the paper's figures (SVG, PNG), its table (``table.csv``, ``table.html`` with everything) and
    ``paper.json`` into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in FIGURES:
        save_figure(figure(found, name), folder, name)
    rows = [number.to_dict() for number in found.table]
    with (folder / "table.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    record = json.dumps(found.to_dict(), indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    (folder / "paper.json").write_text(record, "utf-8")
    (folder / "table.html").write_text(table_html(found), "utf-8")


def table_html(reproduction: Reproduction) -> str:
    """The table, the claims and the figures as one page; it looks for the figures in its own folder."""
    rows = "\n".join(_html_row(comparison) for comparison in reproduction.table)
    told = "\n".join(f"<tr>{_cells(c.section, c.statement, c.finding)}</tr>" for c in reproduction.claims)
    figures = "\n".join(
        f'<figure><img src="{name}.svg" alt="{html.escape(caption)}">'
        f"<figcaption>{name.replace('-', ' ').capitalize()}. {html.escape(caption)}.</figcaption></figure>"
        for name, (caption, _) in FIGURES.items()
    )
    return _PAGE.format(rows=rows, claims=told, figures=figures)


def _cells(*texts: str) -> str:
    return "".join(f"<td>{html.escape(text)}</td>" for text in texts)


def _html_row(row: PaperNumber) -> str:
    numbers = _cells(row.section, row.name, row.stated, row.computed, row.deviation, row.allowed_text)
    kind = {FAILS: "fails", GIVEN: "given"}.get(row.verdict, "agrees")
    return f'<tr>{numbers}<td class="{kind}">{html.escape(row.verdict)}</td>{_cells(row.note)}</tr>'


_PAGE: Final = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>The paper, reproduced</title>
<style>
body {{ font: 15px/1.5 'Segoe UI', Roboto, Helvetica, Arial, sans-serif; color: #1F2933; max-width: 75rem;
  margin: 2rem auto; padding: 0 1rem; }}
.wide {{ overflow-x: auto; }}
table {{ border-collapse: collapse; font-size: 14px; }}
th, td {{ text-align: left; vertical-align: top; padding: .3rem .7rem; border-bottom: 1px solid #E4E7EB; }}
th {{ border-bottom: 2px solid #8A939C; }}
.values :is(td, th):nth-child(n+3):nth-child(-n+6) {{ text-align: right; white-space: nowrap;
  font-variant-numeric: tabular-nums; }}
.agrees {{ color: #00664B; }} .fails {{ color: #B00020; font-weight: 600; }} .given {{ color: #6E7781; }}
.figures {{ display: grid; grid-template-columns: repeat(auto-fit, minmax(min(26rem, 100%), 1fr)); gap: 1.5rem; }}
figure {{ margin: 0; }} img {{ width: 100%; }} figcaption {{ font-size: 14px; }}
</style></head><body>
<h1>The paper, reproduced</h1>
<p>Every number that <em>Design guidelines for an electro-hydraulic actuator to isolate machines from vibrations</em>
states, beside what its equations give with its Table I. "Table I allows" is what the rounding of its values leaves
open.</p>
<div class="wide"><table class="values"><thead><tr><th>Section</th><th>Number</th><th>Paper</th><th>Computed</th>
<th>Deviation</th><th>Table I allows</th><th>Verdict</th><th>Comment</th></tr></thead><tbody>
{rows}
</tbody></table></div>
<h2>What the paper says in words</h2>
<div class="wide"><table><thead><tr><th>Section</th><th>Statement</th><th>What the numbers say</th></tr></thead><tbody>
{claims}
</tbody></table></div>
<h2>The figures</h2>
<div class="figures">
{figures}
</div>
</body></html>
"""
