"""A run's folder: the result, its variants in folders of their own, replay and report."""

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from ehamj.replay import write_replay
from ehamj.report import Shown, write_report
from ehamj.result import Result


def write_run(folder: Path, results: Mapping[str, Result]) -> None:
    """Write results into an existing folder; the first is the scenario's own, the others are its variants in order.

    Replay and report show all of them together; a variant's folder holds its own as well.
    """
    shown = Shown.of(results)
    work = [(folder, shown)]
    for name, label in zip(shown.scenario.compare, list(results)[1:], strict=True):
        (folder / name).mkdir()
        work.append((folder / name, shown.only(label)))
    with ThreadPoolExecutor() as pool:
        list(pool.map(lambda one: _write_one(*one), work))


def _write_one(folder: Path, shown: Shown) -> None:
    result = shown.first
    result.save(folder)
    output = result.scenario.output
    if not result.dataset.time.size:
        return  # it failed before its first row: there is nothing to show
    if output.replay:
        write_replay(folder / "replay.rrd", shown.results, output.exaggeration)
    if output.report:
        write_report(folder, shown)
