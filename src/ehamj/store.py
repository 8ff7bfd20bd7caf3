"""A run's folder: the result, its variants in folders of their own, replay and report."""

import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import count, zip_longest
from pathlib import Path

from ehamj.errors import InputError
from ehamj.folders import RESULT_FILES, check_out, new_folder
from ehamj.report import Shown, write_report
from ehamj.result import Result
from ehamj.run.apart import work_off
from ehamj.run.progress import Progress, silent
from ehamj.scenario.variants import known_variants, labels


def write_run(folder: Path, results: Mapping[str, Result], progress: Progress = silent, apart: bool = False) -> str:
    """Write results by their scenarios' names into an existing folder; after the first its variants, those that ran.

    Replay and report show all of them together; a variant's folder holds its own as well. ``progress`` is called with
    what was finished, and how many of how many files that makes.

    Returns:
        Why replay and report are left out, in words; empty where they are not.
    """
    stored, left_out = dict(results), ""
    try:
        if any(one.scenario.output.report or one.scenario.output.replay for one in results.values()):
            results = {name: one.in_memory() for name, one in results.items()}
    except InputError as error:
        left_out = str(error)
    names = labels([result.scenario for result in results.values()])
    shown = Shown.of(dict(zip(names, results.values(), strict=True)))
    variants = known_variants(shown.scenario)
    work = [(folder, shown, stored[next(iter(stored))])]
    for label, name in zip(names[1:], list(results)[1:], strict=True):
        (folder / variants[name]).mkdir()
        work.append((folder / variants[name], shown.only(label), stored[name]))
    # What takes longest begins first: pages before recordings before results, all runs together before one.
    jobs = [
        job for kind in zip_longest(*(_jobs(*one, not left_out) for one in work)) for job in kind if job is not None
    ]
    progress(f"{len(jobs)} files of {len(work)} runs")
    numbers = count(1)
    work_off(jobs, lambda name: progress(f"{next(numbers)} of {len(jobs)}, {name}"), apart)
    return left_out


def _jobs(folder: Path, shown: Shown, stored: Result, fits: bool) -> "Iterator[tuple[str, Callable[[], None]]]":
    """Name and writer of each file of a run; none needs another."""
    output = stored.scenario.output
    if fits and stored.dataset.time.size:  # else it failed before its first row: there is nothing to show
        if output.report:
            yield f"report of {shown.label}", lambda: write_report(folder, shown)
        if output.replay:
            yield f"replay of {shown.label}", lambda: _write_replay(folder / "replay.rrd", shown)
    yield f"result of {shown.label}", lambda: stored.write(folder)


def _write_replay(path: Path, shown: Shown) -> None:
    from ehamj.replay import write_replay  # Rerun takes its time

    write_replay(path, shown.results, shown.first.scenario.output.exaggeration)


def save(result: Result, folder: str | Path, overwrite: bool = False, variants: Iterable[Result] = ()) -> None:
    """What `ehamj.Result.save` does, see there."""
    folder, results = Path(folder), {result.scenario.name: result}
    known = [full for full, name in known_variants(result.scenario).items() if name in result.scenario.compare]
    for one in variants:
        if one.scenario.name not in known:
            allowed = ", ".join(map(repr, known)) or "none, since its compare is empty"
            raise InputError(f"variants: {one.scenario.name!r} must be one of the scenario's, {allowed}")
        results[one.scenario.name] = one
    overwrite = overwrite or (folder.is_dir() and not any(folder.iterdir()))
    check_out(folder, overwrite, RESULT_FILES, "result.save", "overwrite=True")
    with new_folder(folder, overwrite) as (_, target):
        left_out = write_run(target, results)
    if left_out:
        warnings.warn(left_out, stacklevel=3)
