"""Commands that show stored results."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ehamj.cli.frame import Json, app, log
from ehamj.cli.printing import print_json, say
from ehamj.cli.progress import doing
from ehamj.errors import InputError
from ehamj.folders import RUNS

if TYPE_CHECKING:
    from ehamj.result import Result

ResultFolder = Annotated[Path | None, typer.Argument(metavar="RESULT", help="A result folder, such as runs/0001.")]
Compare = Annotated[list[Path] | None, typer.Option("--compare", help="Another result, shown beside it.")]


@app.command()
def replay(
    folder: ResultFolder = None,
    compare: Compare = None,
    rebuild: Annotated[
        bool, typer.Option("--rebuild", help="Build RESULT/replay.rrd anew, with RESULT's own variants as `run` did.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Open the Rerun recording of a stored result where there is a screen; elsewhere, say where it is.

    RESULT/replay.rrd is opened as it is; one that is not there is built first, with the variants that ran with RESULT
    side by side.

    With `--compare` (repeatable) RESULT and the others named are shown side by side, with one exaggeration and one
    clock, without RESULT's own variants; this recording is built each time, as RESULT/replay-compare.rrd.
    """
    from ehamj.replay import open_viewer

    if compare and rebuild:
        raise InputError("--rebuild: is for RESULT's own recording; --compare always builds another, so leave one out")
    folder = _named(folder)
    path = folder / ("replay-compare.rrd" if compare else "replay.rrd")
    built = bool(compare) or rebuild or not path.is_file()
    if built:
        _build_replay(path, [folder, *(compare or _variants(folder))])
    else:
        _check_result(folder)
        _check_recording(path)
    why = open_viewer(path)
    if as_json:
        print_json({"replay": str(path), "opened": not why, "built": built})
        return
    say(f"replay: {path}" + ("" if built else " (as it is; --rebuild builds it anew)"), whole=True)
    if why:
        import rerun

        say(f"{why}; open it with: rerun {path}  (Rerun {rerun.__version__}, on this or another machine)", whole=True)


@app.command()
def report(
    folder: ResultFolder = None,
    compare: Compare = None,
    pdf: Annotated[bool, typer.Option("--pdf", help="Print it as report.pdf too, by an installed browser.")] = False,
    as_json: Json = False,
) -> None:
    """Build the report of a stored result anew, variants that ran with it beside it, as RESULT/report.html.

    With `--compare` (repeatable) the page shows RESULT and the others named, side by side, without RESULT's own
    variants; it is RESULT/report-compare.html, its figures are in RESULT/figures-compare/.

    With `--pdf` Chromium, Chrome or Edge prints it: two sheets to read, and an annex with everything. The environment
    variable EHAMJ_BROWSER names a browser that is not on the path.
    """
    from ehamj.pages.pdf import check_browser, print_page
    from ehamj.report import write_report

    folder = _named(folder)
    name, figures = ("report-compare", "figures-compare") if compare else ("report", "figures")
    path, printed = folder / f"{name}.html", folder / f"{name}.pdf"
    if pdf:
        check_browser(path)
    shown = _side_by_side([folder, *(compare or _variants(folder))], "report")
    with doing("drawing the report"):
        write_report(folder, shown, name, figures)
    if pdf:
        with doing("printing"):
            print_page(path, printed)
    if as_json:
        print_json({"report": str(path), "results": list(shown)} | ({"pdf": str(printed)} if pdf else {}))
    else:
        say(f"report: {path}", whole=True)
        if pdf:
            say(f"PDF: {printed}", whole=True)


def _named(folder: Path | None) -> Path:
    """The folder that was named; raises InputError where none was, which names the latest there is."""
    if folder is not None:
        return folder
    there = max(RUNS.glob("[!.]*/summary.json"), key=lambda path: path.stat().st_mtime_ns, default=None)
    latest = f"the latest here is {str(there.parent)!r}" if there else "`ehamj run` makes one"
    raise InputError(f"RESULT: is missing; name a result folder, {latest}")


def _check_result(folder: Path) -> None:
    """Raise InputError unless a folder holds a result as its run wrote it."""
    from ehamj.belonging import check_result

    check_result(folder)


def _check_recording(path: Path) -> None:
    """Raise InputError unless a recording is whole."""
    from ehamj.replay import check_whole

    try:
        check_whole(path)
    except OSError as error:
        raise InputError(f"recording {str(path)!r}: is damaged; --rebuild builds it anew from the result") from error


def _build_replay(path: Path, folders: Sequence[Path]) -> None:
    """Write the recording of some stored results, exaggerated as the first one asks."""
    from ehamj.replay import write_replay

    shown = _side_by_side(folders, "replay")
    with doing("building the recording"):
        write_replay(path, shown, next(iter(shown.values())).scenario.output.exaggeration)


def _variants(folder: Path) -> list[Path]:
    """Folders of the variants that ran with a result, those that are still there."""
    from ehamj.belonging import check_variant, is_result, told

    found = told(is_result(folder))
    here = [name for name in found.belongs.variants if (folder / name).is_dir()]
    for name in here:
        check_variant(found, name)
    for gone in (folder / name for name in found.belongs.variants if name not in here):
        log.print(f"note: the variant {gone} is gone, and left out", markup=False, highlight=False, soft_wrap=True)
    return [folder / name for name in here]


def _in_memory(folder: Path) -> "Result":
    from ehamj.result import load_result

    try:
        return load_result(folder).in_memory()
    except InputError as error:
        said = str(error)
        raise InputError(said if said.startswith("result ") else f"result {str(folder)!r}: {said}") from error


def _side_by_side(folders: Sequence[Path], to: str) -> "dict[str, Result]":
    """Stored results by what tells each from the others.

    Args:
        folders: of the results.
        to: what is done with them, for the message.

    Raises:
        InputError: if a folder is named twice, or holds no row.
    """
    from ehamj.result import side_by_side

    results = [_in_memory(folder) for folder in folders]
    paths = [folder.resolve() for folder in folders]
    for folder, path in zip(folders, paths, strict=True):
        if paths.count(path) > 1:
            raise InputError(f"result {str(folder)!r}: is named twice; each result is shown once")
    return side_by_side(results, to, paths)
