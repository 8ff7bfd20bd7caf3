"""The command that answers questions about a machine: one command of its own for every registered study."""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from ehamj.cli.frame import Command, Json, Out, Overwrite, ScenarioName, Set, app
from ehamj.cli.options import with_options
from ehamj.cli.printing import print_json, print_names, say
from ehamj.cli.progress import doing
from ehamj.cli.study_file import study_file
from ehamj.errors import InputError, did_you_mean
from ehamj.folders import check_out, new_folder
from ehamj.plain.text import json_of
from ehamj.scenario.load import load_scenario
from ehamj.scenario_files import is_study_file, shipped_studies, table_of
from ehamj.studies.catalogue import STUDIES
from ehamj.studies.page import STUDY_FILES, to_dict, write_outcome
from ehamj.studies.study import Study

FLAGS = ("--json", "--overwrite", "--resume")
"""Options that take no word."""
FILE = "FILE"
"""Command that does what a study file asks for; a file's name leads to it."""


class _OfFile(Command):
    """A study file's own keys are set by --set; the scenario's stand in its table ``set``."""

    example = "set.duration=3"


class _Studies(TyperGroup):
    """Finds a study by its name, wherever that stands between the options."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        # A word after an option that takes one is that option's.
        free = [k for k in range(len(args)) if k == 0 or args[k - 1] in FLAGS or not args[k - 1].startswith("-")]
        named = next((k for k in free if args[k] in STUDIES), None)
        if named is None and any(is_study_file(args[k]) for k in free):
            return super().parse_args(ctx, [FILE, *args])
        named = named or 0
        return super().parse_args(ctx, [*args[named : named + 1], *args[:named], *args[named + 1 :]])

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        if cmd_name != FILE and cmd_name not in STUDIES:
            names = (*STUDIES, *shipped_studies())
            near = did_you_mean(cmd_name, names)
            raise InputError(f"study {cmd_name!r}: {near}no study file; must be one of {', '.join(names)}")
        return super().get_command(ctx, cmd_name)


studies = typer.Typer(cls=_Studies, invoke_without_command=True, rich_markup_mode="markdown")
app.add_typer(studies, name="study")


@studies.callback()
def study(context: typer.Context, as_json: Json = False) -> None:
    """Answer one question about a machine, or do a study of many designs: `ehamj study FILE.toml`.

    `ehamj study` lists the questions and the study files that ship; `ehamj study NAME --help` shows its settings. Each
    writes study.html (read it
    first), tables as NetCDF and CSV with units, figures as SVG, study.json with its settings, and scenario.toml:
    `ehamj study NAME FOLDER/scenario.toml --settings FOLDER/study.json` comes out the same.
    """
    if context.invoked_subcommand is None:
        questions = {name: one.question for name, one in STUDIES.items()}
        asked = {name: str(table_of(path, "study").get("question", "")) for name, path in shipped_studies().items()}
        print_names("studies", questions | asked, "question", as_json)


def _command(one: Study[Any]) -> Callable[..., None]:
    @with_options(one.settings)
    def command(
        given: dict[str, Any],
        scenario: ScenarioName = "recorded",
        settings: Annotated[
            Path | None, typer.Option("--settings", metavar="study.json", help="Settings of a study that was run.")
        ] = None,
        out_folder: Out = None,
        overwrite: Overwrite = False,
        overrides: Set = None,
        as_json: Json = False,
    ) -> None:
        check_out(out_folder, overwrite, STUDY_FILES)
        wanted = one.with_settings({**(_stored(settings, one) if settings else {}), **given})
        loaded = load_scenario(scenario, overrides or ())
        with doing(f"study {one.name}", steps=True) as step:
            outcome = one(loaded, wanted, step)
            step("tables and figures")
            with new_folder(out_folder, overwrite) as place:
                write_outcome(place.target, one.name, outcome, loaded)
        if as_json:
            print_json({"folder": str(place.folder), **to_dict(one.name, outcome)})
            return
        say(outcome.question, f"{outcome.title}: ")
        for answer in outcome.answers:
            say(f"- {answer}")
        say(f"page, tables and figures: {place.folder / 'study.html'}", whole=True)

    return command


def _stored(path: Path, one: Study[Any]) -> dict[str, Any]:
    """Settings that a study's folder holds."""
    try:
        found = json_of(path)
        if found["study"] != one.name:
            raise InputError(f"--settings {str(path)!r}: is of study {found['study']!r}, not {one.name!r}")
        return dict(found["settings"])
    except (OSError, ValueError, TypeError, KeyError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"--settings {str(path)!r}: must be a study.json that `ehamj study` wrote") from error


studies.command(FILE, cls=_OfFile, hidden=True)(study_file)
for _name, _one in STUDIES.items():
    studies.command(_name, cls=Command, help=f"{_one.question[0].upper()}{_one.question[1:]}.")(_command(_one))
