"""A study file from its first design to its page: where it is written, what is resumed, what stands there in the end."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from ehamj.campaign.conduct import Conducted, conduct
from ehamj.campaign.file import StudyFile, load_study
from ehamj.campaign.page import write_study
from ehamj.campaign.staged import stages_of
from ehamj.campaign.standing import Progress, silent
from ehamj.campaign.store import STORE_FILE
from ehamj.campaign.studied import Studied, studied_of
from ehamj.campaign.tables import frame
from ehamj.errors import InputError
from ehamj.folders import check_out, made_folder
from ehamj.result import written_whole
from ehamj.studies.outcome import Outcome

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
    file: StudyFile
    outcome: Outcome
    complete: bool
    """Whether all its designs are there; else the time that it may take is used up."""

    @property
    def designs(self) -> "DataFrame":
        """All designs, as `ehamj.campaign.tables.frame` reads them."""
        return frame(self.folder)


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
    folder = Path(out) if out is not None else _own_folder(source, resume)
    if resume and folder is None:
        raise InputError("--resume: needs --out, the folder of the study that is to go on")
    if not resume:
        check_out(folder, overwrite, MARKS)
    step("reading the study")
    stages = stages_of(file)
    with _folder(folder, resume, overwrite) as place:
        _write_file(place, file)
        ended = conduct(
            place,
            stages,
            file.model_dump(mode="json", exclude_unset=True),
            scheduler=scheduler,
            resume=resume,
            functions=functions,
            progress=progress,
            hours=file.budget.hours,
        )
    step("page, tables and best designs")
    studied = studied_of(file, frame(place), stages, ended)
    return Study(place, file, write_study(place, _name_of(source, file), studied), ended.complete)
