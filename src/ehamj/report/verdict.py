"""What the page says first in words: verdict, and what failed."""

from ehamj.pages.words import DASH
from ehamj.report.shown import Results
from ehamj.result import Result


def verdict(result: Result) -> list[tuple[str, str]]:
    """The verdict's lines as the summary says them: vertical apart from horizontal."""
    criterion = result.summary.get("criterion", {})
    lines = []
    for name, axes in (("vertical", ("z",)), ("horizontal", ("x", "y"))):
        parts = [criterion.get(who, {}).get(axis, {}) for who in ("floor", "machine") for axis in axes]
        judged = any(part.get("deciding_band_hz") is not None for part in parts)
        said = criterion.get("verdict", {}).get(name, DASH)
        lines.append((name, said if judged else "not judged: the run is too short for any band of the criterion"))
    return lines


def failures(results: Results) -> list[tuple[str, str]]:
    """What went wrong in each run that is not complete."""
    return [
        (
            f"Incomplete: {label}" if len(results) > 1 else "Incomplete",
            f"{result.summary.get('failure', 'the simulation did not reach its end')}. Every number of this run below "
            "holds only until then.",
        )
        for label, result in results.items()
        if not result.complete
    ]
