"""A recording in front of whoever works in Python, in a notebook or in the viewer: what ``result.replay()`` does."""

import os
import shutil
import sys
import time
from collections.abc import Sequence
from contextlib import redirect_stdout, suppress
from functools import cache
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory, gettempdir, mkdtemp
from typing import Any, Final

from ehamj.errors import InputError
from ehamj.extras import check_extra
from ehamj.replay import open_viewer, write_replay
from ehamj.result import Result, side_by_side

WIDTH, HEIGHT = "auto", 640
"""Of the viewer in a notebook [px]; all of the page's width."""

PREFIX: Final = "ehamj-replay-"
"""Of temporary folders that viewers read from: a viewer outlives a script that opened it."""
LASTING: Final = 86400.0
"""Age from which such a folder is removed by the next that is made [s]."""


def shown(result: Result, beside: Sequence[Result] = ()) -> Any:
    """Show the recording of a result beside others: in a notebook gives its viewer, elsewhere opens one, None.

    Raises:
        InputError: if there is no viewer: no package for the notebook, no screen; or a result without a row.
    """
    results = side_by_side((result, *beside), "replay")
    within = _in_notebook()
    if within:
        check_extra("rerun_notebook", "replay: in a notebook")
    if within:
        with TemporaryDirectory(prefix=PREFIX) as folder:
            path = Path(folder) / "replay.rrd"
            write_replay(path, results, result.scenario.output.exaggeration)
            return viewer(path)
    _clear()
    path = Path(mkdtemp(prefix=PREFIX)) / "replay.rrd"
    write_replay(path, results, result.scenario.output.exaggeration)
    if why := open_viewer(path):
        shutil.rmtree(path.parent)
        raise InputError(f"replay: {why}; result.save(FOLDER) keeps FOLDER/replay.rrd, which any Rerun viewer opens")
    return None


def _clear() -> None:
    """Remove what viewers of yesterday and before were opened with."""
    for folder in Path(gettempdir()).glob(f"{PREFIX}*"):
        with suppress(OSError):
            if time.time() - folder.stat().st_mtime > LASTING:
                shutil.rmtree(folder)


def viewer(path: Path) -> Any:
    """The notebook's viewer with a recording: a widget."""
    found = _viewer_class()(width=WIDTH, height=HEIGHT)
    found.send_rrd(path.read_bytes())
    return found


@cache
def _viewer_class() -> Any:
    """Rerun's widget, which this computer serves: else the browser would fetch it from Rerun's own site.

    A notebook that runs on another computer than its browser names a place that both see, or sends all with the page:
    ``RERUN_NOTEBOOK_ASSET``, as Rerun documents it.
    """
    from rerun_notebook import Viewer
    from rerun_notebook.asset_server import serve_assets

    if os.environ.get("RERUN_NOTEBOOK_ASSET"):
        return Viewer
    with redirect_stdout(StringIO()):  # it tells of itself
        _, port, *_ = serve_assets(background=True)
    return type("Viewer", (Viewer,), {"_esm": f"http://localhost:{port}/widget.js"})


def _in_notebook() -> bool:
    """Whether this process is a notebook's kernel."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return getattr(shell, "kernel", None) is not None
