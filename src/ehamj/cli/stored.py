"""Commands that show stored results."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ehamj.cli.frame import Json, app, log
from ehamj.cli.printing import print_json, say
from ehamj.errors import InputError

if TYPE_CHECKING:
    from ehamj.result import Result

ResultFolder = Annotated[Path, typer.Argument(metavar="RESULT", help="A result folder.")]
Compare = Annotated[list[Path] | None, typer.Option("--compare", help="Another result, shown beside it.")]


@app.command()
def replay(folder: ResultFolder, compare: Compare = None, as_json: Json = False) -> None:
    """Build the Rerun recording of a stored result, and open it where there is a screen.

    With `--compare` (repeatable) the recording shows the results side by side with one exaggeration and one clock, in
    RESULT/replay-compare.rrd.
    """
    from ehamj.replay import open_viewer, write_replay

    shown = _side_by_side([folder, *(compare or ())])
    path = folder / ("replay-compare.rrd" if compare else "replay.rrd")
    write_replay(path, shown, next(iter(shown.values())).scenario.output.exaggeration)
    opened = open_viewer(path)
    if as_json:
        print_json({"replay": str(path), "opened": opened})
    else:
        hint = "" if opened else f"  (no screen here; open it with: rerun {path})"
        say(f"replay: {path}{hint}")


@app.command()
def report(folder: ResultFolder, compare: Compare = None, as_json: Json = False) -> None:
    """Build the report of a stored result anew, variants that ran with it beside it, as RESULT/report.html.

    With `--compare` (repeatable) the page shows RESULT and the others named, side by side, without RESULT's own
    variants; it is RESULT/report-compare.html, its figures are in RESULT/figures-compare/.
    """
    from ehamj.report import write_report

    shown = _side_by_side([folder, *(compare or _variants(folder))])
    for label, result in shown.items():
        if not result.dataset.time.size:
            raise InputError(f"result {label!r}: failed before its first row, so that there is nothing to report")
    name, figures = ("report-compare", "figures-compare") if compare else ("report", "figures")
    with log.status("drawing"):
        write_report(folder, shown, name, figures)
    path = folder / f"{name}.html"
    if as_json:
        print_json({"report": str(path), "results": list(shown)})
    else:
        say(f"report: {path}")


def _variants(folder: Path) -> list[Path]:
    """Folders of the variants that ran with a result, those that are still there."""
    from ehamj.result import load_result

    folders = [folder / name for name in load_result(folder).scenario.compare]
    for gone in (one for one in folders if not one.is_dir()):
        log.print(f"note: the variant {gone} is gone, and left out", markup=False, highlight=False)
    return [one for one in folders if one.is_dir()]


def _side_by_side(folders: Sequence[Path]) -> "dict[str, Result]":
    """Stored results by a label: their scenario's name, with the folder's name or path where that is not enough.

    Raises:
        InputError: if a folder is named twice.
    """
    from ehamj.result import load_result

    results = [load_result(folder) for folder in folders]
    paths = [folder.resolve() for folder in folders]
    for folder, path in zip(folders, paths, strict=True):
        if paths.count(path) > 1:
            raise InputError(f"result {str(folder)!r}: is named twice; each result is shown once")
    labels = names = [result.scenario.name for result in results]
    for wheres in ([path.name for path in paths], paths):
        if len(set(labels)) < len(labels):
            labels = [f"{name} ({where})" for name, where in zip(names, wheres, strict=True)]
    return dict(zip(labels, results, strict=True))
