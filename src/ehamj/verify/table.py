"""The outcomes as one self-contained page, and as plain data."""

import html
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ehamj.verify.case import Outcome

_STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; margin: 2rem auto; max-width: 78rem; padding: 0 1rem; color: #1d2430; }
table { border-collapse: collapse; width: 100%; } th, td { text-align: left; vertical-align: top; padding: .4rem; }
th { border-bottom: 2px solid #1d2430; } td { border-bottom: 1px solid #d5dae1; } .number { text-align: right; }
.number { font-variant-numeric: tabular-nums; white-space: nowrap; } .failed { background: #fdecea; }
small { color: #5a6473; } @media (prefers-color-scheme: dark) { body { background: #14181f; color: #e3e7ee; }
.failed { background: #4a1f1c; } th { border-color: #e3e7ee; } td { border-color: #353c47; } small { color: #9aa4b2; } }
"""


def to_dict(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """All outcomes as plain data; an error that is no finite number becomes null."""
    cases = []
    for outcome in outcomes:
        entry = outcome.to_dict()
        if not abs(outcome.error) < float("inf"):
            entry["error"] = None
        cases.append(entry)
    return {"passed": all(outcome.passed for outcome in outcomes), "cases": cases}


def write_table(outcomes: Sequence[Outcome], path: Path) -> Path:
    """Write the page to a file, or as ``verification.html`` into a folder; returns where it is."""
    path = path / "verification.html" if path.is_dir() else path
    path.write_text(page(outcomes), encoding="utf-8")
    return path


def page(outcomes: Sequence[Outcome]) -> str:
    """The page as HTML."""
    failed = sum(not outcome.passed for outcome in outcomes)
    verdict = f"{failed} of {len(outcomes)} cases fail" if failed else f"all {len(outcomes)} cases pass"
    rows = "\n".join(_row(outcome) for outcome in outcomes)
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width"><title>ehamj: verification</title>'
        f"<style>{_STYLE}</style></head><body><h1>Verification: {verdict}</h1>\n"
        '<table><thead><tr><th>case</th><th>independent solution</th><th class="number">error</th>'
        '<th class="number">tolerance</th><th>unit, and why this tolerance</th><th class="number">s</th></tr></thead>\n'
        f"<tbody>\n{rows}\n</tbody></table></body></html>\n"
    )


def _row(outcome: Outcome) -> str:
    compares, source, why, detail, unit, name = (
        html.escape(text)
        for text in (outcome.compares, outcome.source, outcome.why, outcome.detail, outcome.unit, outcome.name)
    )
    kind = "" if outcome.passed else ' class="failed"'
    mark = "✓" if outcome.passed else "✗"
    return (
        f"<tr{kind}><td>{mark} <b>{name}</b><br><small>{compares}</small></td>"
        f"<td>{source}<br><small>{detail}</small></td>"
        f'<td class="number">{outcome.error:.3g}</td><td class="number">{outcome.tolerance:.3g}</td>'
        f'<td>{unit}<br><small>{why}</small></td><td class="number">{outcome.seconds:.1f}</td></tr>'
    )
