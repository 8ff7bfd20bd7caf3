"""A run's folder: the result, its variants in folders of their own, replay and report."""

import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from itertools import count, zip_longest
from pathlib import Path
from typing import NamedTuple

from ehamj.errors import InputError, NotShown
from ehamj.folders import RESULT_FILES, check_out, new_folder
from ehamj.report import Shown, write_report
from ehamj.result import Result
from ehamj.run.apart import work_off
from ehamj.run.progress import Progress, silent
from ehamj.run.unjudged import in_words
from ehamj.scenario.variants import known_variants, labels
from ehamj.unfinished import clear_leftovers, remove

Work = tuple[Path, Shown, Result, Mapping[str, str]]
"""A run's folder, what it shows, what is stored, and the identities of what is written beside it."""
Lost = Mapping[str, tuple[Path, Exception]]
"""What could not be made, in which folder of the run's, and why."""


class Written(NamedTuple):
    """What of a run is not shown: left out, in words, and what could not be made."""

    left_out: str
    lost: Lost


def write_run(folder: Path, results: Mapping[str, Result], progress: Progress = silent, apart: bool = False) -> Written:
    """Write results by their scenarios' names into an existing folder; after the first its variants, those that ran.

    Replay and report show all of them together; a variant's folder holds its own as well. ``progress`` is called with
    what was finished, and how many of how many files that makes.

    Returns:
        Why replay and report are left out, in words, empty where they are not; and what of them could not be made: the
        results stand there all the same.
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
    beside = {variants[name]: (label, stored[name]) for label, name in zip(names[1:], list(results)[1:], strict=True)}
    work: list[Work] = [
        (folder, shown, stored[next(iter(stored))], {name: result.identity for name, (_, result) in beside.items()})
    ]
    for name, (label, result) in beside.items():
        (folder / name).mkdir()
        work.append((folder / name, shown.only(label), result, {}))
    # What takes longest begins first: pages before recordings, all runs together before one.
    shows = [
        job
        for kind in zip_longest(*(_shows(*one[:2]) for one in work if not left_out))
        for job in kind
        if job is not None
    ]
    total, numbers, lost = len(work) + len(shows), count(1), dict[str, tuple[Path, Exception]]()
    at_of = {shown.label: at.relative_to(folder) for at, shown, *_ in work}
    progress(f"{total} files of {len(work)} runs")

    def finished(name: str) -> None:
        progress(f"{next(numbers)} of {total}, {name}")

    def failed(name: str, error: Exception) -> None:
        lost[name] = at_of[name.partition(" of ")[2]], error

    # Results stand before anything is made that shows them: what fails then takes none with it.
    work_off([(f"result of {one.label}", partial(own.write, at, ids)) for at, one, own, ids in work], finished)
    try:
        work_off(shows, finished, apart, failed)
    except Exception as error:  # a process that did it is gone
        lost["report and replay"] = Path(), error
        for at, *_ in work:
            _clear(at)
    return Written(left_out, lost)


def _clear(folder: Path) -> None:
    """Remove what processes that are gone had begun to write in a run's folder, and figures whose page never came."""
    figures = folder / "figures"
    for at in (folder, figures):
        clear_leftovers(at)
    if not (folder / "report.html").exists():
        remove(figures)


def _shows(folder: Path, shown: Shown) -> "Iterator[tuple[str, Callable[[], None]]]":
    """Name and writer of each file that shows a run; none needs another."""
    output = shown.first.scenario.output
    if shown.first.dataset.time.size:  # else it failed before its first row: there is nothing to show
        if output.report:
            yield f"report of {shown.label}", lambda: write_report(folder, shown)
        if output.replay:
            yield f"replay of {shown.label}", lambda: _write_replay(folder / "replay.rrd", shown)


def check_shown(folder: Path, lost: Lost, results: Iterable[Result]) -> None:
    """Say what of a run that is kept could not be shown or judged.

    Raises:
        NotShown: if there is anything.
    """
    said = [
        f"{part} of {one.scenario.name!r} could not be judged: {why}; `ehamj report {folder}` shows all else"
        for one in results
        for part, why in one.summary.unjudged.items()
    ]
    for name, (at, error) in lost.items():
        what = name.partition(" of ")[0].split(" and ")
        commands = " or ".join(f"`ehamj {one} {folder / at}`" for one in what)
        said.append(f"{name} could not be made: {in_words(error)}; {commands} makes it")
    if said:
        first = next((error for _, error in lost.values()), None)
        raise NotShown(f"{'. '.join(said)}. The run is kept in {str(folder)!r}") from first


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
    with new_folder(folder, overwrite) as place:
        left_out, lost = write_run(place.target, results)
    if left_out:
        warnings.warn(left_out, stacklevel=3)
    check_shown(place.folder, lost, results.values())
