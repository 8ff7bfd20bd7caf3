"""A study file from its first design to its page: where it is written, what is resumed, what stands there after."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import tomli_w

from ehamj.campaign.conduct import conduct
from ehamj.campaign.file import StudyFile, load_study
from ehamj.campaign.keys import own_value
from ehamj.campaign.page import write_study
from ehamj.campaign.staged import stages_of
from ehamj.campaign.standing import Progress, Standing, silent
from ehamj.campaign.store import STORE_FILE
from ehamj.campaign.studied import studied_of
from ehamj.campaign.tables import frame
from ehamj.campaign.threads import one_thread
from ehamj.errors import InputError
from ehamj.folders import check_out, numbered_folder
from ehamj.merits.applied import scenario_of
from ehamj.merits.merit import Machine
from ehamj.result import written_whole
from ehamj.studies.outcome import Outcome
from ehamj.unfinished import beside, remove

if TYPE_CHECKING:
    from pandas import DataFrame

STUDY_FILE: Final = "study.toml"
"""The study's own file in its folder."""
MARKS: Final = (STUDY_FILE, STORE_FILE)
"""Files without which a folder is none of a study of many designs."""


@dataclass(frozen=True)
class Study:
    """A study that was done, or is done in part, in its ``folder``."""

    folder: Path
    name: str
    file: StudyFile
    outcome: Outcome
    complete: bool
    """Whether all its designs are there; else the time that it may take is used up."""

    def _repr_html_(self) -> str:
        """Its answers, as a notebook shows them."""
        return self.outcome._repr_html_()

    @property
    def designs(self) -> "DataFrame":
        """All designs, as `ehamj.campaign.tables.frame` reads them."""
        return frame(self.folder)


@one_thread()
def run_study(
    source: str | Path | Mapping[str, Any] | StudyFile,
    out: str | Path | None = None,
    *,
    overrides: Iterable[str] = (),
    resume: bool = False,
    overwrite: bool = False,
    scheduler: Any = None,
    functions: Mapping[str, Callable[..., float]] | None = None,
    progress: Progress = silent,
    step: Callable[[str], None] = lambda words: None,
) -> Study:
    """Do a study of many designs, and write its page, tables and best scenarios into its folder.

    Args:
        source: a study file, the name of a shipped one, the folder of a study, or its content.
        out: folder for it; one that is resumed; without, a new one under runs/.
        overrides: ``KEY=VALUE`` each, as ``ehamj study FILE --set`` takes them.
        resume: whether to go on with the designs that are stored in ``out``.
        overwrite: whether another study may be replaced.
        scheduler: where designs are computed: "threads:4", "processes", the address of a Dask scheduler, a client.
        functions: merits of one's own, functions by name.
        progress: called with how far it is (`ehamj.campaign.standing.Standing`).
        step: called with what is done besides.

    Raises:
        InputError: if the file, the folder or the scheduler is not as it must be; nothing is written then.
        OSError: if a file cannot be written; finished designs are kept, and can be resumed.
    """
    file = load_study(source, overrides)
    folder = Path(out) if out is not None else _own_folder(source) if resume else None
    if not resume:
        check_out(folder, overwrite, MARKS)
    step("reading the study")
    machine, stages = file.machine, stages_of(file)
    space, planned = file.space(machine), sum(stage.count() for stage in stages)
    about = file.model_dump(mode="json", exclude_unset=True, exclude={"title", "question", "budget"})
    given: dict[str, Any] = {"scheduler": scheduler, "functions": functions, "hours": file.budget.hours}
    with _place(folder, resume, overwrite) as place:

        def told(standing: Standing) -> None:
            if not (place / STUDY_FILE).is_file():  # the store has begun, so that the study can be resumed
                _write_file(place, file)
            progress(standing)

        ended = conduct(place, stages, about, resume=resume, progress=told, **given)
    step("page, tables and best designs")
    nominal = {key: space.nominal.get(key) for key in space.keys}
    studied = studied_of(file, frame(place), nominal, planned, ended.complete, _of_named(file, machine, nominal))
    name = _name_of(source)
    return Study(place, name, file, write_study(place, name, studied, machine), ended.complete)


def _of_named(file: StudyFile, machine: Machine, keys: Iterable[str]) -> dict[int, dict[str, Any]]:
    """Values of each named design by its number, also those that follow from other keys, such as a preset."""
    scenarios = [scenario_of(machine, values) for values in file.values_of_named.values()]
    return {number: {key: own_value(one, key) for key in keys} for number, one in enumerate(scenarios, 1)}


def _own_folder(source: Any) -> Path | None:
    """The folder of a study that is named by it, or by its file there."""
    if not isinstance(source, str | Path):
        return None
    path = Path(source)
    folder = path if path.is_dir() else path.parent
    is_its_own = path.name in (STUDY_FILE, folder.name) and all((folder / mark).is_file() for mark in MARKS)
    return folder if is_its_own else None


def _write_file(folder: Path, file: StudyFile) -> None:
    with written_whole(folder / STUDY_FILE) as path:
        text = tomli_w.dumps(file.model_dump(mode="json", exclude_unset=True, exclude_none=True))
        path.write_text(text, encoding="utf-8")


def _name_of(source: Any) -> str:
    return Path(source).stem if isinstance(source, str | Path) else "study"


@contextmanager
def _place(wanted: Path | None, resume: bool, overwrite: bool) -> Iterator[Path]:
    """The folder where a study is done. One that is replaced moves aside, and comes back if no study begins."""
    if resume:
        if wanted is None:
            raise InputError("--resume: needs --out, the folder of the study that is to go on")
        yield wanted
        return
    folder = wanted if wanted is not None else numbered_folder()
    aside = beside(folder.resolve(), "replaced")
    if overwrite and folder.is_dir():
        folder.replace(aside)
    try:
        yield folder
    finally:
        if not (folder / STORE_FILE).is_file():
            with suppress(OSError):
                folder.rmdir()
            if aside.is_dir() and not folder.exists():
                aside.replace(folder)
        remove(aside)
