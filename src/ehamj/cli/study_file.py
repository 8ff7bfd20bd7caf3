"""The command that does a study of many designs, as a study file asks for it."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ehamj.cli.frame import Json, Overwrite, log
from ehamj.cli.printing import print_json, say
from ehamj.cli.progress import counting
from ehamj.errors import InputError

if TYPE_CHECKING:
    from ehamj.campaign.run import Study


def study_file(
    file: Annotated[
        str, typer.Argument(metavar="FILE", help="A study file (TOML), a shipped one's name, or a study's folder.")
    ],
    out_folder: Annotated[
        Path | None, typer.Option("--out", help="Folder for the study [default: a new runs/NNNN].")
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with the designs that are stored in --out, or in FILE's folder.")
    ] = False,
    overwrite: Overwrite = False,
    threads: Annotated[
        int | None, typer.Option("--threads", metavar="N", help="Threads that compute [default: one a core].")
    ] = None,
    processes: Annotated[
        int | None, typer.Option("--processes", metavar="N", help="Processes that compute, instead of threads.")
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option("--scheduler", metavar="ADDRESS", help="A Dask scheduler that computes, as tcp://10.0.0.1:8786."),
    ] = None,
    overrides: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Override a key of the study file, e.g. plan.number=64."),
    ] = None,
    as_json: Json = False,
) -> None:
    """Do a study of many designs, as a file asks for it.

    The folder holds study.html (read it first), all designs as designs.parquet, designs.csv and designs.sqlite, the
    best designs as best-1.toml, … (`ehamj run` simulates them), study.json with the numbers, tables and figures, and
    study.toml, the study itself. Finished designs are kept whatever happens: `ehamj study FOLDER --resume` goes on.

    What a study file may hold, `ehamj schema study` says.
    """
    from ehamj.campaign.run import run_study

    computed = _scheduler(threads, processes, scheduler)
    with counting("study") as (step, progress):
        found = run_study(
            file,
            out_folder,
            overrides=overrides or (),
            resume=resume,
            overwrite=overwrite,
            scheduler=computed,
            progress=progress,
            step=step,
        )
    _told(found, as_json)


def _scheduler(threads: int | None, processes: int | None, address: str | None) -> str | None:
    """Where designs are computed, as `ehamj.campaign.named_schedulers.scheduler_of` takes it."""
    given = {"--threads": threads, "--processes": processes, "--scheduler": address}
    named = [name for name, value in given.items() if value is not None]
    if len(named) > 1:
        raise InputError(f"{' and '.join(named)}: are two places to compute in; name one")
    for name, count in (("--threads", threads), ("--processes", processes)):
        if count is not None and count < 1:
            raise InputError(f"{name} {count}: must be at least 1")
    if address is not None:
        return address
    return next((f"{name[2:]}:{given[name]}" for name in named), None)


def _told(found: "Study", as_json: bool) -> None:
    """Print what came out."""
    from ehamj.studies.page import to_dict

    outcome: Any = found.outcome
    if as_json:
        done: dict[str, Any] = {"folder": str(found.folder), "complete": found.complete}
        print_json({**done, **to_dict(found.name, outcome)})
        return
    say(outcome.question, f"{outcome.title}: ")
    for answer in outcome.answers:
        say(f"- {answer}")
    say(f"page, tables and figures: {found.folder / 'study.html'}", whole=True)
    if not found.complete:
        said = f"note: the time that it may take is used up; go on with: ehamj study {found.folder} --resume"
        log.print(said, markup=False, highlight=False, soft_wrap=True)
