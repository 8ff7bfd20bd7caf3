"""Commands that show stored results."""

from pathlib import Path
from typing import Annotated

import typer

from ehamj.cli.frame import JsonOption, app, distinct, out, print_json


@app.command()
def replay(
    folder: Annotated[Path, typer.Argument(metavar="RESULT", help="A result folder.")],
    compare: Annotated[list[Path] | None, typer.Option("--compare", help="Another result, shown beside it.")] = None,
    as_json: JsonOption = False,
) -> None:
    """Build the Rerun recording of a stored result, and open it where there is a screen.

    With `--compare` (repeatable) the recording shows the results side by side with one exaggeration and one clock, in
    RESULT/replay-compare.rrd.
    """
    from ehamj.replay import open_viewer, write_replay
    from ehamj.result import load_result

    folders = [folder, *(compare or [])]
    loaded = [load_result(one) for one in folders]
    labels = distinct([result.scenario.name for result in loaded], folders)
    path = folder / ("replay-compare.rrd" if compare else "replay.rrd")
    write_replay(path, dict(zip(labels, loaded, strict=True)), loaded[0].scenario.output.exaggeration)
    opened = open_viewer(path)
    if as_json:
        print_json({"replay": str(path), "opened": opened})
    else:
        hint = "" if opened else f"  (no screen here; open it with: rerun {path})"
        out.print(f"replay: {path}{hint}", markup=False, highlight=False, soft_wrap=True)
