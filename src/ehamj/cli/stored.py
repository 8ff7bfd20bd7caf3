"""Commands that show stored results."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ehamj.cli.frame import JsonOption, app, distinct, log, print_json, say
from ehamj.errors import InputError

if TYPE_CHECKING:
    from ehamj.result import Result

ResultArgument = Annotated[Path, typer.Argument(metavar="RESULT", help="A result folder.")]
CompareOption = Annotated[list[Path] | None, typer.Option("--compare", help="Another result, shown beside it.")]


@app.command()
def replay(
    folder: ResultArgument,
    compare: CompareOption = None,
    as_json: JsonOption = False,
) -> None:
    """Build the Rerun recording of a stored result, and open it where there is a screen.

    With `--compare` (repeatable) the recording shows the results side by side with one exaggeration and one clock, in
    RESULT/replay-compare.rrd.
    """
    from ehamj.replay import open_viewer, write_replay

    folders = [folder, *(compare or [])]
    shown = _side_by_side(folders)
    path = folder / ("replay-compare.rrd" if compare else "replay.rrd")
    write_replay(path, shown, next(iter(shown.values())).scenario.output.exaggeration)
    opened = open_viewer(path)
    if as_json:
        print_json({"replay": str(path), "opened": opened})
    else:
        hint = "" if opened else f"  (no screen here; open it with: rerun {path})"
        say(f"replay: {path}{hint}")


@app.command()
def report(
    folder: ResultArgument,
    compare: CompareOption = None,
    as_json: JsonOption = False,
) -> None:
    """Build the report of a stored result anew, variants that ran with it beside it, as RESULT/report.html.

    With `--compare` (repeatable) the page shows RESULT and the others named, side by side, without RESULT's own
    variants; it is RESULT/report-compare.html, its figures are in RESULT/figures-compare/.
    """
    from ehamj.report import write_report

    variants = [] if compare else _variants(folder)
    shown = _side_by_side([folder, *(compare or variants)])
    empty = [label for label, result in shown.items() if not result.dataset.time.size]
    if empty:
        raise InputError(f"result {empty[0]!r}: failed before its first row, so that there is nothing to report")
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

    found = []
    for name in load_result(folder).scenario.compare:
        if (folder / name).is_dir():
            found.append(folder / name)
        else:
            log.print(f"note: the variant {folder / name} is gone, and left out", markup=False, highlight=False)
    return found


def _side_by_side(folders: list[Path]) -> "dict[str, Result]":
    """Stored results by a label of each."""
    from ehamj.result import load_result

    loaded = [load_result(one) for one in folders]
    return dict(zip(distinct([result.scenario.name for result in loaded], folders), loaded, strict=True))
