"""A run's folder: the result, its variants in folders of their own, replay and report."""

from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

from ehamj.replay import write_replay
from ehamj.report import Shown, write_report
from ehamj.result import Result


def write_run(folder: Path, results: Mapping[str, Result], progress: Callable[[str], None] = lambda step: None) -> None:
    """Write results into an existing folder; the first is the scenario's own, the others are its variants in order.

    Replay and report show all of them together; a variant's folder holds its own as well. ``progress`` is called with
    what was finished, and how many of how many files that makes.
    """
    shown = Shown.of(results)
    work = [(folder, shown)]
    for name, label in zip(shown.scenario.compare, list(results)[1:], strict=True):
        (folder / name).mkdir()
        work.append((folder / name, shown.only(label)))
    jobs = [job for one in work for job in _jobs(*one)]
    progress(f"{len(jobs)} files of {len(work)} runs")

    def do(numbered: "tuple[str, Callable[[], None]]") -> str:
        name, write = numbered
        write()
        return name

    with ThreadPoolExecutor() as pool:
        for count, finished in enumerate(as_completed([pool.submit(do, job) for job in jobs]), 1):
            progress(f"{count} of {len(jobs)}, {finished.result()}")


def _jobs(folder: Path, shown: Shown) -> "Iterator[tuple[str, Callable[[], None]]]":
    """Name and writer of each file of a run; none needs another."""
    result = shown.first
    yield f"result of {shown.label}", lambda: result.save(folder)
    output = result.scenario.output
    if not result.dataset.time.size:
        return  # it failed before its first row: there is nothing to show
    if output.replay:
        yield (
            f"replay of {shown.label}",
            lambda: write_replay(folder / "replay.rrd", shown.results, output.exaggeration),
        )
    if output.report:
        yield f"report of {shown.label}", lambda: write_report(folder, shown)
