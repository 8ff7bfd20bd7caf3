"""What the page says first in words: verdict, and what failed."""

from ehamj.report.shown import Results
from ehamj.result import Result


def verdict(result: Result) -> list[tuple[str, str]]:
    """The verdict's lines as the summary says them: vertical apart from horizontal."""
    criterion = result.summary.criterion
    lines = []
    for name, axes in (("vertical", ("z",)), ("horizontal", ("x", "y"))):
        parts = [*criterion.floor.along(axes), *criterion.machine.along(axes)]
        judged = any(verdict.deciding_band is not None for verdict in parts)
        said = criterion.verdict[name]
        lines.append((name, said if judged else "not judged: the run is too short for any band of the criterion"))
    return lines


def failures(results: Results) -> list[tuple[str, str]]:
    """What went wrong in each run that is not complete."""
    return [
        (
            f"Incomplete: {label}" if len(results) > 1 else "Incomplete",
            f"{result.summary.failure or 'the simulation did not reach its end'}. Every number of this run below "
            "holds only until then.",
        )
        for label, result in results.items()
        if not result.complete
    ]
