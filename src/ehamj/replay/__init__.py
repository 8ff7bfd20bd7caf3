"""The replay: a Rerun recording of one result, or of several side by side, with its own layout."""

import importlib.util
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Literal

import numpy as np
import rerun as rr
from rerun.error_utils import catch_and_log_exceptions

from ehamj.replay.about import page
from ehamj.replay.attenuation import curves_of, log_attenuation
from ehamj.replay.blueprint import make_blueprint, playback_speed
from ehamj.replay.names import result_color
from ehamj.replay.plots import Series, log_series, series_of
from ehamj.replay.scene import exaggeration_for, log_scene, main_frequency
from ehamj.result import Result, written_whole

__all__ = ["open_viewer", "write_replay"]


def write_replay(
    path: Path, results: Mapping[str, Result], exaggeration: float | Literal["auto"] = "auto"
) -> None:
    """Write the recording of some results, which the viewer shows side by side and on one clock.

    Args:
        path: file to write, ``*.rrd``; it appears when it is whole.
        results: what to show, by label, in order.
        exaggeration: factor on all drawn motions; ``auto`` draws the largest about 0.12 m.

    Raises:
        ValueError: if there is no result, or the exaggeration is not positive.
    """
    if not results or "" in results:
        raise ValueError(f"results {list(results)}: must be at least one, each with a label")
    factor = exaggeration_for(results.values()) if exaggeration == "auto" else float(exaggeration)
    if not (np.isfinite(factor) and factor > 0.0):
        raise ValueError(f"exaggeration = {exaggeration!r}: must be a positive number or 'auto'")
    speed = playback_speed(main_frequency(results.values()))
    series, curves = _series(results), curves_of(results)
    title = next(iter(results.values())).scenario.name
    # Rerun only warns of what it cannot log, unless told otherwise; this way it is told for this block and thread alone.
    with written_whole(Path(path)) as temporary, catch_and_log_exceptions(strict=True):
        layout = make_blueprint(results, series, curves, factor, speed)
        # The viewer keeps a user's layout per application: one that belongs to other results would come up empty.
        recording = rr.RecordingStream(f"ehamj {title}: {', '.join(results)}, motion × {factor:g}")
        try:
            recording.save(temporary, default_blueprint=layout)
            recording.send_recording_name(title)
            recording.log("about", rr.TextDocument(page(results, factor, speed), media_type="text/markdown"), static=True, strict=True)
            for label, result in results.items():
                log_scene(recording, label, result, factor)
                log_series(recording, label, result.dataset.time.values, series[label])
            log_attenuation(recording, curves, tuple(results))
        finally:
            recording.disconnect()


def _series(results: Mapping[str, Result]) -> dict[str, dict[str, Series]]:
    """The plots of each result; a ground that several results share is kept with the first of them."""
    found: dict[str, dict[str, Series]] = {}
    for index, (label, result) in enumerate(results.items()):
        plots = series_of(result, label, result_color(index))
        for name in ("ground_vertical", "ground_horizontal"):
            if any(name in other and np.array_equal(other[name].values, plots[name].values) for other in found.values()):
                del plots[name]
        found[label] = plots
    return found


def open_viewer(path: Path) -> bool:
    """Start the Rerun viewer on a recording where there is a screen; whether it was started."""
    on_desktop = sys.platform in ("darwin", "win32")
    if not (on_desktop or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        return False
    if importlib.util.find_spec("rerun_cli") is None:
        return False
    # Rerun listens on all interfaces unless told otherwise. A viewer that is already open takes the file.
    command = [sys.executable, "-m", "rerun", "--bind", "127.0.0.1", str(Path(path).resolve())]
    silent = subprocess.DEVNULL
    subprocess.Popen(command, stdin=silent, stdout=silent, stderr=silent, start_new_session=True)
    return True
