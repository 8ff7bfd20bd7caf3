"""The replay: a Rerun recording of one result, or of several side by side, with its own layout."""

import importlib.util
import itertools
import os
import re
import subprocess
import sys
import zlib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Literal

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from ehamj.belonging import shown_mark
from ehamj.replay.about import page
from ehamj.replay.attenuation import curves_of, log_attenuation
from ehamj.replay.blueprint import make_blueprint, playback_speed
from ehamj.replay.marks import arrow_scale, log_arrows, log_bar, log_faults
from ehamj.replay.plots import compared_plots, isolator_plots, log_plot
from ehamj.replay.recording import check_whole, fixed, recorded, result_color
from ehamj.replay.scene import exaggeration_for, log_scene, main_frequency
from ehamj.replay.spectrogram import heats_of, log_heats
from ehamj.result import Result

__all__ = ["check_whole", "open_viewer", "write_replay"]


def write_replay(path: Path, results: Mapping[str, Result], exaggeration: float | Literal["auto"] = "auto") -> None:
    """Write the recording of some results, which the viewer shows side by side and on one clock.

    Args:
        path: file to write, ``*.rrd``; it appears when it is whole.
        results: what to show, by label, in order.
        exaggeration: factor on all drawn motions; ``auto`` draws the largest about 0.12 m.

    Raises:
        ValueError: if there is no result, or the exaggeration is not positive.
        OSError: if the file cannot be written.
    """
    if not results or "" in results:
        raise ValueError(f"results {list(results)}: must be at least one, each with a label")
    factor = exaggeration_for(results.values()) if exaggeration == "auto" else float(exaggeration)
    if not (np.isfinite(factor) and factor > 0.0):
        raise ValueError(f"exaggeration = {exaggeration!r}: must be a positive number or 'auto'")
    arrows = arrow_scale(results.values())
    speed = playback_speed(main_frequency(results.values()))
    compared, curves, heats = compared_plots(results), curves_of(results), heats_of(results)
    isolators = {
        which: plots for label, result in results.items() for which, plots in isolator_plots(label, result).items()
    }
    title = next(iter(results.values())).scenario.name

    def layout() -> rrb.Blueprint:
        return make_blueprint(results, compared, isolators, curves, heats, factor, speed)

    mark = shown_mark(result.identity for result in results.values())
    with recorded(path, _application(title, results, factor), title, layout, mark) as recording:
        fixed(recording, "about", rr.TextDocument(page(results, factor, arrows, speed), media_type="text/markdown"))
        for index, (label, result) in enumerate(results.items()):
            log_scene(recording, label, result, factor)
            log_bar(recording, label, result, factor)
            log_arrows(recording, label, result, arrows, result_color(index))
            log_faults(recording, label, result)
        for plot in itertools.chain(compared.values(), *(plots.values() for plots in isolators.values())):
            log_plot(recording, plot)
        log_attenuation(recording, curves, tuple(results))
        log_heats(recording, heats)


def _application(title: str, labels: Iterable[str], factor: float) -> str:
    """The application that the viewer keeps a user's layout for: a layout for other results would come up empty."""
    what = "\n".join([title, *labels, f"{factor:g}"])
    plain = re.sub(r"[^A-Za-z0-9]+", "-", title).strip("-")  # Rerun allows little else
    return f"ehamj {plain} {zlib.crc32(what.encode()):08x}"


def open_viewer(path: Path) -> str:
    """Start the Rerun viewer on a recording where there is a screen: why it was not started, "" where it was."""
    if not (sys.platform in ("darwin", "win32") or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        return "no screen here"
    if importlib.util.find_spec("rerun_cli") is None:
        return "the Rerun viewer is not installed here"
    # Rerun listens on all interfaces unless told otherwise. A viewer that is already open takes the file.
    command = [sys.executable, "-m", "rerun", "--bind", "127.0.0.1", str(Path(path).resolve())]
    silent = subprocess.DEVNULL
    subprocess.Popen(command, stdin=silent, stdout=silent, stderr=silent, start_new_session=True)
    return ""
