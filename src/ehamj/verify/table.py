"""The outcomes as one self-contained page, and as plain data."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from markupsafe import Markup

from ehamj.pages import Page, Section, Table, badge, render
from ehamj.verify.case import CaseOutcome


def to_dict(outcomes: Sequence[CaseOutcome]) -> dict[str, Any]:
    """All outcomes as plain data."""
    return {"passed": all(one.passed for one in outcomes), "cases": [one.to_dict() for one in outcomes]}


def write_table(outcomes: Sequence[CaseOutcome], path: Path) -> Path:
    """Write the page to a file, or as ``verification.html`` into a folder; returns where it is."""
    path = path / "verification.html" if path.is_dir() else path
    path.write_text(render(page(outcomes)), encoding="utf-8")
    return path


def page(outcomes: Sequence[CaseOutcome]) -> Page:
    """The outcomes as a page."""
    failed = sum(not outcome.passed for outcome in outcomes)
    verdict = f"{failed} of {len(outcomes)} cases fail" if failed else f"all {len(outcomes)} cases pass"
    head = ("case", "independent solution", "error", "tolerance", "unit, and why this tolerance", "s")
    table = Table("", head, [_row(outcome) for outcome in outcomes], kind="words", numeric=(2, 3, 5))
    return Page("ehamj: verification", f"Verification: {verdict}", "", [Section("cases", tables=[table])])


def _row(outcome: CaseOutcome) -> list[str]:
    case, mark = outcome.case, badge("✓", "agrees") if outcome.passed else badge("✗", "fails")
    two_lines = Markup("{}<br><small>{}</small>")
    return [
        Markup("{} <b>{}</b><br><small>{}</small>").format(mark, case.name, case.compares),
        two_lines.format(case.source, outcome.detail),
        f"{outcome.error:.3g}",
        f"{case.tolerance:.3g}",
        two_lines.format(case.unit, case.why),
        f"{outcome.seconds:.1f}",
    ]
