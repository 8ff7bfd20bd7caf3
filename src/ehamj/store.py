"""A run's folder: the result, its variants in folders of their own, replay and report."""

from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from ehamj.errors import InputError
from ehamj.folders import check_out, new_folder
from ehamj.report import Shown
from ehamj.result import RESULT_FILES, SAVING, Result


def write_run(folder: Path, results: Mapping[str, Result]) -> None:
    """Write results by their scenarios' names into an existing folder; after the first its variants, those that ran.

    Replay and report show all of them together; a variant's folder holds its own as well.
    """
    shown = Shown.of(results)
    variants = {shown.scenario.variant(name).name: name for name in shown.scenario.compare}
    work = [(folder, shown)]
    for label in list(results)[1:]:
        (folder / variants[label]).mkdir()
        work.append((folder / variants[label], shown.only(label)))
    with ThreadPoolExecutor() as pool:
        list(pool.map(lambda one: _write_one(*one), work))


def _write_one(folder: Path, shown: Shown) -> None:
    from ehamj.replay import write_replay
    from ehamj.report import write_report

    result = shown.first
    result.write(folder)
    output = result.scenario.output
    if not result.dataset.time.size:
        return  # it failed before its first row: there is nothing to show
    if output.replay:
        write_replay(folder / "replay.rrd", shown.results, output.exaggeration)
    if output.report:
        write_report(folder, shown)


def save(result: Result, folder: str | Path, overwrite: bool = False, variants: Iterable[Result] = ()) -> None:
    """What `ehamj.Result.save` does, see there."""
    folder, results = Path(folder), {result.scenario.name: result}
    known = {result.scenario.variant(name).name: name for name in result.scenario.compare}
    for one in variants:
        if one.scenario.name not in known:
            allowed = ", ".join(map(repr, known)) or "none, since its compare is empty"
            raise InputError(f"variants: {one.scenario.name!r} must be one of the scenario's, {allowed}")
        results[one.scenario.name] = one
    overwrite = overwrite or (folder.is_dir() and not any(folder.iterdir()))
    check_out(folder, overwrite, RESULT_FILES, "result.save", "overwrite=True")
    with new_folder(folder, overwrite) as (_, target):
        write_run(target, results)


SAVING.append(save)
